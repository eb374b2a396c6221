//! The parts of a scene: plain data that says what is simulated, and how large some of its numbers may be.
//! Each number has its default in `presets.rs` and a row in the table `fields/table.rs`, which says when it
//! is read and what it does not go with; `features.rs` and `sheet/check.rs` check that.
//!
//! All numbers are SI. Vectors of the projectile and of the sheet's pose are in the host's frame; the sheet's
//! own frame has its nodes in the plane z = 0, rows along x. Quaternions are scalar first and turn body
//! vectors into world vectors.

pub use crate::scene::fields::choices::{
    AttachmentKind, Draw, Drive, IntegratorKind, RotationKind, Shape, StepCheck, StrengthDraw,
};

/// Largest number of nodes along one side.
pub const MAX_NODES_PER_SIDE: u32 = 1 << 20;

/// The grid of nodes and its mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheet {
    /// Nodes along x, at least 2.
    pub nodes_x: u32,
    /// Nodes along y, at least 2.
    pub nodes_y: u32,
    /// Node spacing h along x, m, > 0: the natural length of a segment without crimp and pre-tension.
    pub spacing: f64,
    /// Node spacing along y, m, > 0; 0: as along x.
    pub spacing_y: f64,
    /// Mass of one node of one ply, kg, > 0; the same for every node.
    pub node_mass: f64,
    /// Cross-section of one yarn along x of one ply, m^2, > 0.
    pub yarn_area: f64,
    /// Cross-section of one yarn along y of one ply, m^2, > 0; 0: as along x.
    pub yarn_area_y: f64,
    /// Crimp of the yarns along x and y, in [0, 1]: natural length of a segment over the spacing, less 1.
    pub crimp: [f64; 2],
    /// Strain of the held sheet along x and y, >= 0: spacing over the natural length of a segment, less 1.
    pub pre_strain: [f64; 2],
    /// Plies sewn or bonded into one network (mass and area are multiplied), 1 ..= 1000.
    pub plies: u32,
    /// Thickness of one ply, m, >= 0: the body touches its middle surface, the network, at half of it, bonded
    /// plies at half of all theirs. 0: a surface without thickness. All separate plies have the same.
    pub thickness: f64,
    /// Where bars of the network stand for several yarns.
    pub grading: Grading,
    /// Radius to the nodes of a sheet that is curved about its y axis, m; 0: flat. Node (i, j) then rests at
    /// (R sin a, y, R cos a), and a segment along x is a chord of the node spacing.
    pub radius: f64,
    /// Whether a segment joins the last node of every row to its first: a ring.
    pub closed: bool,
    /// Origin of the sheet's frame in the host's frame, m: the middle of a flat sheet, on the axis of a
    /// curved one.
    pub position: [f64; 3],
    /// Orientation of the sheet's frame in the host's frame, unit quaternion, scalar first.
    pub orientation: [f64; 4],
}

/// A graded network: fine about the expected hit, and towards the edges bars that stand for 2, 4, 8 ... yarns
/// and as many crossings. Read-outs of nodes and segments give the network's own.
/// See docs/model.md, "Graded networks".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grading {
    /// Most yarns that a bar stands for: 2, 4, 8 ... 64; 0 or 1: no grading.
    pub largest: u32,
    /// Bars of each size before the next, at least 1.
    pub run: u32,
    /// Middle of the fine part along x and along y, m, sheet's frame; exactly 0 across a mirror plane.
    pub centre: [f64; 2],
    /// Half the width of the fine part along x and along y, m, >= 0.
    pub half_width: [f64; 2],
}

/// Several sheets one behind the other, which push on each other (`contact/stack.rs`). Each is a network of
/// its own with draws of its own, held like the first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stack {
    /// Separate plies, 1 ..= [`MAX_PLIES`]. Ply k rests at z = k (`gap` + n t), with n layers of the
    /// thickness t bonded into each; the sheet's frame is that of ply 0.
    pub plies: u32,
    /// Air between neighbouring plies where they rest, m, >= 0 and at most a million node spacings.
    pub gap: f64,
    /// Whether every other ply, from the second on, is turned by 90 degrees: its warp runs along y.
    pub turned: bool,
}

/// A second fabric, of the last plies of a stack. It lies in the grid of the first one: a bar stands for as
/// many of its yarns as there are in a spacing. It has one law for both directions and draws of its own; the
/// rest of the yarn law is that of `yarn`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Back {
    /// Number of the last plies of `stack.plies` that are of this fabric, less than all; 0: none.
    pub plies: u32,
    /// Mass of a node, kg, > 0.
    pub node_mass: f64,
    /// Cross-section of a bar along x, m^2, > 0.
    pub yarn_area: f64,
    /// Cross-section of a bar along y, m^2, > 0; 0: as along x.
    pub yarn_area_y: f64,
    /// Crimp of the yarns along x and along y, in [0, 1].
    pub crimp: [f64; 2],
    /// Mean Young's modulus, Pa, > 0.
    pub modulus_mean: f64,
    /// Standard deviation of the modulus, Pa, >= 0.
    pub modulus_sd: f64,
    /// Slope of the damage rate over the modulus, 1/Pa.
    pub damage_slope: f64,
    /// Damage rate at zero modulus, dimensionless.
    pub damage_intercept: f64,
    /// Standard deviation of the damage rate about that line, >= 0.
    pub damage_sd: f64,
    /// Critical stretch U_c, > 1.
    pub critical_stretch: f64,
    /// Weibull shape m of the critical strain U_c - 1, in [1, 1000]; 0: it is not drawn.
    pub weibull_shape: f64,
    /// Gauge length L, m, at which `critical_stretch` - 1 is the Weibull scale; 0: that of a segment.
    pub weibull_gauge_length: f64,
}

impl Back {
    /// Whether modulus and damage rate are drawn.
    pub fn is_drawn(&self) -> bool {
        self.modulus_sd != 0.0 || self.damage_sd != 0.0
    }
}

/// Largest number of separate plies.
pub const MAX_PLIES: u32 = 1000;
/// Largest gap between plies, node spacings.
pub const MAX_GAP: f64 = 1e6;

/// Attachment of the sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attachment {
    /// Which nodes are fixed.
    pub kind: AttachmentKind,
    /// Four corners: distance c of a disc's centre from both edges, m, >= 0.
    pub disc_inset: f64,
    /// Four corners: radius r of the discs, m, > 0, and such that a disc holds a node.
    pub disc_radius: f64,
    /// Force H at which the clamp lets a bar of one ply slip, N, >= 0; 0: without limit.
    pub hold: f64,
    /// Length of yarn in the clamp, m, >= 0; a node that has slid so far is free. 0: without end.
    pub grip: f64,
    /// Force at which one attachment as a whole lets go, mean over `force_window`, N, >= 0; 0: never.
    pub strength: f64,
}

/// The yarn law and its scatter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Yarn {
    /// Mean Young's modulus of a segment, Pa, > 0.
    pub modulus_mean: f64,
    /// Standard deviation of the modulus, Pa, >= 0.
    pub modulus_sd: f64,
    /// Slope of the damage rate over the modulus, 1/Pa.
    pub damage_slope: f64,
    /// Damage rate at zero modulus (the line lambda = slope E + intercept), dimensionless.
    pub damage_intercept: f64,
    /// Standard deviation of the damage rate about that line, >= 0.
    pub damage_sd: f64,
    /// Critical stretch U_c, > 1.
    pub critical_stretch: f64,
    /// Factor A of the damage law, > 0, with A (1 - B) in (0, 1].
    pub damage_a: f64,
    /// Offset B of the damage law, < 1.
    pub damage_b: f64,
    /// alpha at or below this becomes exactly 0, in [0, 1).
    pub alpha_fail: f64,
    /// true: modulus and damage rate are drawn; false: all segments take the mean.
    pub stochastic: bool,
    /// Unit that gets a sample of its own.
    pub draw: Draw,
    /// Whether every segment has a critical stretch of its own.
    pub strength_draw: StrengthDraw,
    /// Weibull shape m of the critical strain U_c - 1, in [1, 1000].
    pub weibull_shape: f64,
    /// Gauge length L, m, at which `critical_stretch` - 1 is the Weibull scale; 0: that of a segment.
    pub weibull_gauge_length: f64,
    /// Correlation of the normal scores of two segments of one woven yarn, in [0, 1].
    pub weibull_correlation: f64,
    /// Linear viscosity of taut yarn, dimensionless, in [0, 1]; 0.06 if in doubt, 0 = none.
    pub viscosity_linear: f64,
    /// Quadratic viscosity of taut yarn, dimensionless, in [0, 10]; 1.5 if in doubt.
    pub viscosity_quadratic: f64,
    /// Viscosity against bending of taut yarn, dimensionless, in [0, 0.2]; 0.06 if in doubt.
    pub viscosity_bending: f64,
    /// C_E, growth of the modulus by e-fold of the rate of strain, in [0, 1]; 0 = none.
    pub rate_modulus: f64,
    /// C_U, growth of the critical strain by e-fold of the rate of strain, in [0, 1]; 0 = none.
    pub rate_stretch: f64,
    /// Rate of strain of modulus and critical stretch as given, 1/s, in [1e-9, 1e9].
    pub rate_reference: f64,
    /// Largest rate of strain measured, 1/s, at most 1e9; faster ones count as this.
    pub rate_limit: f64,
}

/// The yarn along y, the weft, where it is unlike that along x, the warp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weft {
    /// Mean Young's modulus, Pa, > 0; 0: modulus and damage rate are those of `yarn`.
    pub modulus_mean: f64,
    /// Standard deviation of the modulus, Pa, >= 0.
    pub modulus_sd: f64,
    /// Slope of the damage rate over the modulus, 1/Pa.
    pub damage_slope: f64,
    /// Damage rate at zero modulus, dimensionless.
    pub damage_intercept: f64,
    /// Standard deviation of the damage rate about that line, >= 0.
    pub damage_sd: f64,
    /// Critical stretch U_c, > 1; 0: that of `yarn`.
    pub critical_stretch: f64,
}

impl Weft {
    /// The weft is of the warp's yarn.
    pub const LIKE_WARP: Weft = Weft {
        modulus_mean: 0.0,
        modulus_sd: 0.0,
        damage_slope: 0.0,
        damage_intercept: 0.0,
        damage_sd: 0.0,
        critical_stretch: 0.0,
    };
}

/// Mirror planes through the middle of the sheet. Only the part at x <= 0, y <= 0 is modelled then; sums,
/// energies and counts of segments stay those of the whole sheet, read-outs of nodes and segments cover the
/// part. For uniform yarn, a free projectile, and a hit that the planes leave as it is: centred on each of
/// them and not tilted across it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Symmetry {
    /// The plane x = 0.
    pub mirror_x: bool,
    /// The plane y = 0.
    pub mirror_y: bool,
}

/// Largest number of faces of a polyhedron.
pub const MAX_FACES: usize = 16;

/// The faces of a convex polyhedron {x : n_k.x <= b_k for all k}, in body axes, from the centre of mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Faces {
    /// Number of faces, 4 ..= [`MAX_FACES`] for a polyhedron.
    pub count: u32,
    /// Outward unit normal (3) of each face and its distance b from the centre of mass, m, > 0. Beyond
    /// `count` not read.
    pub planes: [[f64; 4]; MAX_FACES],
}

impl Faces {
    /// No faces: what the other shapes carry.
    pub const NONE: Faces = Faces { count: 0, planes: [[0.0; 4]; MAX_FACES] };

    /// These faces. Of more than [`MAX_FACES`] the rest is left out and `count` says so, which
    /// [`Scene::check`] refuses.
    pub fn of(planes: &[[f64; 4]]) -> Faces {
        let mut faces = Faces { count: u32::try_from(planes.len()).unwrap_or(u32::MAX), ..Faces::NONE };
        faces.planes.iter_mut().zip(planes).for_each(|(place, plane)| *place = *plane);
        faces
    }

    /// The faces in use.
    pub fn in_use(&self) -> &[[f64; 4]] {
        self.planes.get(..self.count as usize).unwrap_or(&self.planes)
    }
}

/// A sector of a turbine disc: body x outward along its middle, body z along the disc's axis, origin at the
/// centre of mass. It is a prism: eight equal chords, with their corners on it, replace the rim, and the bore
/// is filled up to its one chord.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sector {
    /// Radius of the bore, m, 0 or between 1e-6 and 1 - 1e-6 of that of the rim.
    pub inner_radius: f64,
    /// Radius of the rim, m; no face may be nearer to the centre of mass than the node spacing.
    pub outer_radius: f64,
    /// Angle, rad, in [1e-3, pi).
    pub angle: f64,
    /// Thickness, m, at least two node spacings.
    pub thickness: f64,
}

/// The rigid projectile and its motion at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projectile {
    /// Form.
    pub shape: Shape,
    /// Radius, m, >= the node spacing.
    pub radius: f64,
    /// Length along the axis, m, at least two node spacings, and the radius with a hemispherical end.
    pub length: f64,
    /// Edge lengths of a box along the body axes, m, each at least two node spacings.
    pub size: [f64; 3],
    /// Faces of a polyhedron, none nearer to the centre of mass than the node spacing.
    pub faces: Faces,
    /// Principal moments of inertia of a polyhedron about its centre of mass, kg m^2, > 0, none greater than
    /// the other two together; the body axes are the principal axes. Other shapes are homogeneous.
    pub moments: [f64; 3],
    /// Dimensions of a disc sector.
    pub sector: Sector,
    /// Mass, kg, at least one node's mass. With [`Drive::Prescribed`] 0 means "not known".
    pub mass: f64,
    /// Centre of mass at the start, m.
    pub position: [f64; 3],
    /// Velocity at the start, m/s.
    pub velocity: [f64; 3],
    /// Orientation at the start, unit quaternion, scalar first.
    pub orientation: [f64; 4],
    /// Angular velocity at the start, rad/s, in the host's axes.
    pub angular_velocity: [f64; 3],
}

/// A rigid cylinder about the axis of a ring, which its nodes may lift off but not enter. The projectile does
/// not meet it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Casing {
    /// Radius, m, at most that of the ring less half its thickness; 0: no case, and the numbers below are not
    /// read.
    pub radius: f64,
    /// A window without case, if not 0: angle of its middle from +z towards +x, and half its angle, rad.
    pub window_angle: [f64; 2],
    /// Window along y, if not 0: place of its middle, and half its length, m, within the ring.
    pub window_place: [f64; 2],
}

impl Casing {
    /// No case.
    pub const NONE: Casing = Casing { radius: 0.0, window_angle: [0.0; 2], window_place: [0.0; 2] };
}

/// Law of contact in addition to the impulses that keep yarn and projectile apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLaw {
    /// Coefficient of Coulomb friction, in [0, 10]; 0 = none. With friction a sphere feels torque, too.
    pub friction: f64,
}

/// The time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeStep {
    /// A fraction of the drawn sheet's dt_crit, in (0, 0.5]. Read if `seconds` is 0.
    pub fraction: f64,
    /// The step itself, s, at most 0.5 dt_crit; 0: `fraction` says it.
    pub seconds: f64,
}

impl TimeStep {
    /// A step as a fraction of dt_crit.
    pub const fn fraction(fraction: f64) -> TimeStep {
        TimeStep { fraction, seconds: 0.0 }
    }

    /// A step in seconds.
    pub const fn seconds(seconds: f64) -> TimeStep {
        TimeStep { fraction: 0.0, seconds }
    }
}

/// Integrator of the nodes, with the settings of the theta rule (read for it only).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Integrator {
    /// The method.
    pub kind: IntegratorKind,
    /// Weight of the forces at the step's end, in [0.5, 1]; 0.5 is of second order.
    pub theta: f64,
    /// The iteration ends when no node moves by more than this, in node spacings, > 0.
    pub tolerance: f64,
    /// Iterations after which a step fails, >= 1.
    pub max_iterations: u32,
}

impl Integrator {
    /// Velocity Verlet.
    pub const VERLET: Integrator =
        Integrator { kind: IntegratorKind::Verlet, theta: 0.5, tolerance: 1e-10, max_iterations: 500 };
    /// The theta rule with its usual settings.
    pub const THETA: Integrator = Integrator { kind: IntegratorKind::Theta, ..Integrator::VERLET };
}

/// Rule for the projectile's rotation between impulses, with the setting of the theta rule (read for it
/// only).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotationRule {
    /// The method.
    pub kind: RotationKind,
    /// Weight of the end of the step, in [0.5, 1].
    pub theta: f64,
}

impl RotationRule {
    /// The midpoint rule.
    pub const MIDPOINT: RotationRule = RotationRule { kind: RotationKind::Midpoint, theta: 0.5 };

    /// The theta rule.
    pub const fn theta(theta: f64) -> RotationRule {
        RotationRule { kind: RotationKind::Theta, theta }
    }
}

/// Everything that defines a simulation. Obtain one from [`Scene::sheet_3in_sphere`] or
/// [`Scene::sheet_10in_cylinder`] and change fields.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene {
    /// Grid and mass.
    pub sheet: Sheet,
    /// Separate plies.
    pub stack: Stack,
    /// The fabric of the last of them, where it is another.
    pub back: Back,
    /// Mirror planes.
    pub symmetry: Symmetry,
    /// Supports.
    pub attachment: Attachment,
    /// Yarn law.
    pub yarn: Yarn,
    /// Yarn law along y, where it is another.
    pub weft: Weft,
    /// The case under a ring.
    pub casing: Casing,
    /// Projectile.
    pub projectile: Projectile,
    /// Contact of the two.
    pub contact: ContactLaw,
    /// Who moves the projectile.
    pub drive: Drive,
    /// Seed of the stochastic yarn.
    pub seed: u64,
    /// Time step; constant for the life of a simulation.
    pub time_step: TimeStep,
    /// Whether the time step is checked.
    pub step_check: StepCheck,
    /// Integrator of the nodes.
    pub integrator: Integrator,
    /// Whether the energy error of segments that become slack or taut is corrected: without it a sheet that
    /// rattles gains energy. See docs/model.md, "Slack and taut".
    pub slack_balance: bool,
    /// Rule for the projectile's rotation.
    pub rotation_rule: RotationRule,
    /// Window of the peak force, s, > 0; rounded to whole steps, at least one. Until the first window is full
    /// the peak force is the mean over the time elapsed.
    pub force_window: f64,
    /// Watch whether the nodes in contact are still connected to a support (4 bytes per node). Without it
    /// there is no outcome "detached", and a body that carries torn cloth is never said to have exited.
    pub track_detachment: bool,
    /// Watch whether held yarn can still stop a free body: the outcome "through", long before "exited".
    /// Without `track_detachment` all yarn counts as held. See docs/model.md, "Outcomes".
    pub track_through: bool,
    /// Sum the impulses on the supports; the momentum residual needs them.
    pub track_support: bool,
    /// Greatest number of nodes closer than a spacing to the projectile at once; more is the failure
    /// [`crate::Failure::ContactCapacity`]. 0 = every node modelled. A smaller number is for tight memory:
    /// docs/embedding.md, "Memory".
    pub contact_capacity: u32,
}

/// Largest fraction of dt_crit that is accepted.
pub const STEP_MAX_FRACTION: f64 = 0.5;
/// Default fraction of dt_crit.
pub const STEP_DEFAULT_FRACTION: f64 = 0.4;
/// Rates of strain accepted, 1/s.
pub const STRAIN_RATES: [f64; 2] = [1e-9, 1e9];
/// Range of the Weibull shape of drawn strength.
pub const WEIBULL_SHAPES: [f64; 2] = [1.0, 1000.0];
/// Most yarns that a bar of a graded network may stand for.
pub const GRADING_LARGEST: u32 = 64;
/// Largest critical stretch.
pub const CRITICAL_STRETCH_MAX: f64 = 2.0;
/// Smallest damage rate: below it the tangent stiffness would peak beyond U_c.
pub const DAMAGE_RATE_MIN: f64 = 3.0;

/// The time step and its limits (M11), s.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct StepLimits {
    /// The step in use, constant for the life of a simulation.
    pub dt: f64,
    /// 2/omega_max of the taut sheet at the critical stretch, with the stiffest sampled segment.
    pub dt_crit: f64,
    /// Largest accepted step: 0.5 dt_crit.
    pub step_max: f64,
}
