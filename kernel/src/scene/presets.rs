//! Scenes to begin with, and the numbers of the paper.
//!
//! Reference: D. Powell, T. I. Zohdi, Composites Part B 40 (2009) 451. The ring of 40 in stands in
//! `sheet/ring.rs`, the sector of a disc in `body/sector.rs`.

use crate::scene::parts::{
    Attachment, AttachmentKind, Back, Casing, ContactLaw, Draw, Drive, Faces, Grading, Integrator, Projectile,
    RotationRule, STEP_DEFAULT_FRACTION, Scene, Sector, Shape, Sheet, Stack, StepCheck, StrengthDraw, Symmetry,
    TimeStep, Weft, Yarn,
};

/// Rest length of a segment in the paper: 35 yarns per inch, m.
pub const PAPER_SPACING: f64 = 0.0254 / 35.0;
/// Mass of a node of the paper's sheet, kg, and cross-section of its yarn, m^2.
const PAPER_NODE_MASS: f64 = 6.52e-8;
const PAPER_YARN_AREA: f64 = 1.075e-7;

impl Yarn {
    /// The paper's yarn, with its scatter.
    pub const PAPER: Yarn = Yarn {
        modulus_mean: 140.21e9,
        modulus_sd: 2.04e9,
        damage_slope: 7.91e-9,
        damage_intercept: -878.46,
        damage_sd: 8.35,
        critical_stretch: 1.03,
        damage_a: 1.0,
        damage_b: 0.0,
        alpha_fail: 0.01,
        stochastic: true,
        draw: Draw::Segment,
        strength_draw: StrengthDraw::None,
        weibull_shape: 14.7,
        weibull_gauge_length: 0.0,
        weibull_correlation: 0.0,
        viscosity_linear: 0.0,
        viscosity_quadratic: 0.0,
        viscosity_bending: 0.0,
        rate_modulus: 0.0,
        rate_stretch: 0.0,
        rate_reference: 0.0,
        rate_limit: 0.0,
    };
}

impl Back {
    /// No ply of it; the numbers of the paper's yarn.
    pub const PAPER: Back = Back {
        plies: 0,
        node_mass: PAPER_NODE_MASS,
        yarn_area: PAPER_YARN_AREA,
        yarn_area_y: 0.0,
        crimp: [0.0; 2],
        modulus_mean: Yarn::PAPER.modulus_mean,
        modulus_sd: Yarn::PAPER.modulus_sd,
        damage_slope: Yarn::PAPER.damage_slope,
        damage_intercept: Yarn::PAPER.damage_intercept,
        damage_sd: Yarn::PAPER.damage_sd,
        critical_stretch: Yarn::PAPER.critical_stretch,
        weibull_shape: 0.0,
        weibull_gauge_length: 0.0,
    };
}

impl Scene {
    /// The paper's 3 in sheet: 105 x 105 nodes, four sides held, the 8.4 g steel sphere at its centre, 100
    /// m/s along +z.
    pub const fn sheet_3in_sphere() -> Scene {
        let radius = 6.35e-3;
        Scene {
            sheet: Sheet {
                nodes_x: 105,
                nodes_y: 105,
                spacing: PAPER_SPACING,
                spacing_y: 0.0,
                node_mass: PAPER_NODE_MASS,
                yarn_area: PAPER_YARN_AREA,
                yarn_area_y: 0.0,
                crimp: [0.0; 2],
                pre_strain: [0.0; 2],
                plies: 1,
                thickness: 0.0,
                grading: Grading { largest: 0, run: 4, centre: [0.0; 2], half_width: [0.0; 2] },
                radius: 0.0,
                closed: false,
                position: [0.0; 3],
                orientation: [1.0, 0.0, 0.0, 0.0],
            },
            stack: Stack { plies: 1, gap: 0.0, turned: false },
            back: Back::PAPER,
            symmetry: Symmetry { mirror_x: false, mirror_y: false },
            attachment: Attachment {
                kind: AttachmentKind::FourSides,
                disc_inset: 7.62e-3,
                disc_radius: 5.715e-3,
                hold: 0.0,
                grip: 0.0,
                strength: 0.0,
            },
            yarn: Yarn::PAPER,
            weft: Weft::LIKE_WARP,
            projectile: Projectile {
                shape: Shape::Sphere,
                radius,
                length: 2.0 * radius,
                size: [2.0 * radius; 3],
                faces: Faces::NONE,
                moments: [0.0; 3],
                sector: Sector {
                    inner_radius: 0.015,
                    outer_radius: 0.04,
                    angle: core::f64::consts::TAU / 3.0,
                    thickness: 0.01,
                },
                mass: 8.4e-3,
                position: [0.0, 0.0, -radius],
                velocity: [0.0, 0.0, 100.0],
                orientation: [1.0, 0.0, 0.0, 0.0],
                angular_velocity: [0.0; 3],
            },
            casing: Casing::NONE,
            contact: ContactLaw { friction: 0.0 },
            drive: Drive::Free,
            seed: 1,
            time_step: TimeStep::fraction(STEP_DEFAULT_FRACTION),
            step_check: StepCheck::Refuse,
            integrator: Integrator::VERLET,
            slack_balance: false,
            rotation_rule: RotationRule::MIDPOINT,
            force_window: 1e-6,
            track_detachment: true,
            track_through: false,
            track_support: true,
            contact_capacity: 0,
        }
    }

    /// The paper's 10 in sheet: 350 x 350 nodes, two sides held, the 37 g flat-ended cylinder at its centre,
    /// 100 m/s along +z.
    pub const fn sheet_10in_cylinder() -> Scene {
        let small = Scene::sheet_3in_sphere();
        let length = 0.0381;
        Scene {
            sheet: Sheet { nodes_x: 350, nodes_y: 350, ..small.sheet },
            attachment: Attachment {
                kind: AttachmentKind::TwoSides,
                disc_inset: 25.4e-3,
                disc_radius: 19.05e-3,
                ..small.attachment
            },
            projectile: Projectile {
                shape: Shape::Cylinder,
                length,
                mass: 0.037,
                position: [0.0, 0.0, -0.5 * length],
                ..small.projectile
            },
            ..small
        }
    }
}
