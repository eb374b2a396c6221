//! The golden scenes other than the presets: small, and together touching every shape, attachment, kind of
//! yarn and drive.

use crate::{as_proposed, drawn, rated, rough, set_off, viscous};
use fabric_kernel::{
    AttachmentKind, Draw, Drive, Grading, Integrator, Motion, Path, RotationRule, Scene, Shape, Sim, Stack,
    StrengthDraw, Symmetry, TimeStep, Weft,
};

/// Name, scene, steps, and whether segments have failed by then.
pub type Row = (&'static str, fn() -> Scene, u64, bool);

/// The pinned digest of a scene.
///
/// # Panics
/// The file has no pin of this name.
pub fn pin(name: &str) -> u64 {
    let start = format!("golden {name} ");
    let digest = include_str!("pins").lines().find_map(|line| line.strip_prefix(&start));
    u64::from_str_radix(digest.expect(name), 16).expect(name)
}

/// Scenes that are stepped plainly. The presets come first.
#[rustfmt::skip]
pub const SCENES: &[Row] = &[
    ("sheet_3in_sphere", Scene::sheet_3in_sphere, 4500, true),
    ("sheet_10in_cylinder", Scene::sheet_10in_cylinder, 600, false),
    ("uniform_sphere_before_failure", uniform_sphere, 400, false),
    ("uniform_sphere_through_failure", uniform_sphere, 3000, true),
    ("sphere_on_balanced_yarn", sphere_on_balanced_yarn, 3000, true),
    ("sphere_on_drawn_strength", sphere_on_drawn_strength, 3000, true),
    ("sphere_on_yarn_that_depends_on_rate", sphere_on_yarn_that_depends_on_rate, 3000, true),
    ("sphere_on_viscous_yarn", sphere_on_viscous_yarn, 3000, true),
    ("sphere_that_rubs", sphere_that_rubs, 3000, true),
    ("sphere_through_turned_plies", sphere_through_turned_plies, 1200, true),
    ("cylinder_on_a_graded_sheet", cylinder_on_a_graded_sheet, 2500, true),
    ("taut_warp_and_crimped_weft", taut_warp_and_crimped_weft, 3000, true),
    ("tumbling_cylinder_on_corners", tumbling_cylinder_on_corners, 2000, true),
    ("free_plies_in_a_turned_frame", free_plies_in_a_turned_frame, 1500, true),
    ("damage_law_with_offset", damage_law_with_offset, 2000, true),
    ("quarter_under_a_cylinder", quarter_under_a_cylinder, 2500, true),
    ("drawn_yarns_by_the_theta_rule", drawn_yarns_by_the_theta_rule, 1200, true),
    ("tumbling_bullet", tumbling_bullet, 2000, true),
    ("box_on_a_corner", box_on_a_corner, 1500, true),
    ("disc_sector", disc_sector, 2000, true),
];

/// 41 x 41, uniform yarn, four sides, the preset sphere at 100 m/s.
pub fn uniform_sphere() -> Scene {
    let mut scene = Scene::sheet_3in_sphere();
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (41, 41);
    scene.yarn.stochastic = false;
    scene
}

/// Sphere on drawn yarn with the energy error of slack segments corrected.
pub fn sphere_on_balanced_yarn() -> Scene {
    Scene { slack_balance: true, ..drawn(uniform_sphere()) }
}

/// Sphere on drawn viscous yarn.
pub fn sphere_on_viscous_yarn() -> Scene {
    as_proposed(drawn(uniform_sphere()))
}

/// Sphere on drawn yarn that depends on the rate of strain like Kevlar 49, up to the rates of an impact.
pub fn sphere_on_yarn_that_depends_on_rate() -> Scene {
    rated(drawn(uniform_sphere()), 1700.0)
}

/// Sphere on drawn yarn with friction, askew and spinning.
pub fn sphere_that_rubs() -> Scene {
    let mut scene = rough(drawn(uniform_sphere()), 0.3);
    scene.projectile.velocity = [40.0, -20.0, 100.0];
    scene.projectile.angular_velocity = [3000.0, 0.0, -5000.0];
    scene
}

/// A small cylinder beside the middle of an oblong graded sheet of drawn yarn and strength, two sides held:
/// bars of up to 8 yarns.
pub fn cylinder_on_a_graded_sheet() -> Scene {
    let mut scene = sphere_on_drawn_strength();
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (90, 77);
    scene.sheet.grading = Grading { largest: 8, run: 2, centre: [4e-3, -2.5e-3], half_width: [9e-3, 8e-3] };
    scene.attachment.kind = AttachmentKind::TwoSides;
    let body = &mut scene.projectile;
    body.shape = Shape::Cylinder;
    (body.radius, body.length, body.mass) = (4e-3, 9e-3, 3.5e-3);
    body.position = [3.5e-3, -2e-3, -6.2e-3];
    body.velocity = [15.0, -10.0, 300.0];
    body.orientation = [0.96, 0.28, 0.0, 0.0];
    scene
}

/// Sphere with strength drawn for every segment, in part alike along a yarn, from data at 50 mm; modulus
/// drawn too.
pub fn sphere_on_drawn_strength() -> Scene {
    let mut scene = uniform_sphere();
    let yarn = &mut scene.yarn;
    (yarn.stochastic, yarn.strength_draw, yarn.weibull_shape) = (true, StrengthDraw::Weibull, 9.0);
    (yarn.weibull_gauge_length, yarn.weibull_correlation) = (0.05, 0.25);
    scene
}

/// Four plies of a drawn, viscous fabric with unlike directions, every other one turned, that touch within
/// the run.
pub fn sphere_through_turned_plies() -> Scene {
    let mut scene = uniform_sphere();
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (31, 29);
    scene.stack = Stack { plies: 4, gap: 2.5e-4, turned: true };
    (scene.sheet.yarn_area_y, scene.weft.critical_stretch) = (0.8e-7, 1.025);
    scene.yarn.stochastic = true;
    scene.projectile.velocity = [0.0, 0.0, 220.0];
    viscous(scene, [0.06, 0.0, 0.06])
}

/// A small cylinder that strikes with its rim and tumbles, on an oblong stochastic sheet held at its corners.
pub fn tumbling_cylinder_on_corners() -> Scene {
    let mut scene = Scene::sheet_3in_sphere();
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (45, 38);
    scene.attachment.kind = AttachmentKind::FourCorners;
    (scene.attachment.disc_inset, scene.attachment.disc_radius) = (2e-3, 2e-3);
    scene.seed = 0xfeed;
    let body = &mut scene.projectile;
    body.shape = Shape::Cylinder;
    (body.radius, body.length, body.mass) = (4e-3, 9e-3, 3.5e-3);
    body.position = [1e-3, -5e-4, -6.2e-3];
    body.velocity = [15.0, -10.0, 350.0];
    body.orientation = [0.96, 0.28, 0.0, 0.0];
    body.angular_velocity = [800.0, 0.0, -1500.0];
    scene
}

/// Three plies, no supports, sheet upright and away from the origin, hit off its centre.
pub fn free_plies_in_a_turned_frame() -> Scene {
    let mut scene = Scene::sheet_3in_sphere();
    (scene.sheet.nodes_x, scene.sheet.nodes_y, scene.sheet.plies) = (31, 27, 3);
    scene.attachment.kind = AttachmentKind::Free;
    scene.sheet.position = [0.5, -0.25, 2.0];
    scene.sheet.orientation = [0.8, 0.0, 0.6, 0.0];
    // The sheet's normal is (0.96, 0, 0.28) in the host's frame.
    scene.projectile.position = [0.5 - 0.96 * 6.4e-3, -0.25 + 2e-3, 2.0 - 0.28 * 6.4e-3];
    scene.projectile.velocity = [0.96 * 900.0, 0.0, 0.28 * 900.0];
    scene.seed = 3;
    scene
}

/// A fabric of unlike directions, held taut along x and crimped along y, yarns drawn one by one.
pub fn taut_warp_and_crimped_weft() -> Scene {
    let mut scene = Scene::sheet_3in_sphere();
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (41, 35);
    (scene.sheet.spacing_y, scene.sheet.yarn_area_y) = (9e-4, 9e-8);
    (scene.sheet.pre_strain, scene.sheet.crimp) = ([0.002, 0.0], [0.0, 0.004]);
    scene.weft = Weft {
        modulus_mean: 120e9,
        modulus_sd: 1.5e9,
        damage_slope: 5e-9,
        damage_intercept: -350.0,
        damage_sd: 6.0,
        critical_stretch: 1.028,
    };
    scene.yarn.draw = Draw::Yarn;
    scene.projectile.velocity = [8.0, -5.0, 150.0];
    scene
}

/// The damage law with a true zero (B = 0.01) and a step in seconds, two sides held.
pub fn damage_law_with_offset() -> Scene {
    let mut scene = uniform_sphere();
    scene.attachment.kind = AttachmentKind::TwoSides;
    (scene.yarn.damage_b, scene.yarn.damage_a) = (0.01, 1.0 / 0.99);
    scene.yarn.alpha_fail = 0.0;
    scene.time_step = TimeStep::seconds(2.5e-8);
    scene.projectile.velocity = [0.0, 0.0, 300.0];
    (scene.track_detachment, scene.track_support) = (false, false);
    scene
}

/// A quarter of an even and odd sheet, two sides held, under the flat cylinder.
pub fn quarter_under_a_cylinder() -> Scene {
    let mut scene = Scene::sheet_10in_cylinder();
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (62, 61);
    scene.yarn.stochastic = false;
    scene.symmetry = Symmetry { mirror_x: true, mirror_y: true };
    scene.projectile.velocity = [0.0, 0.0, 150.0];
    scene
}

/// One draw per yarn, theta rule for sheet and cylinder.
pub fn drawn_yarns_by_the_theta_rule() -> Scene {
    let mut scene = tumbling_cylinder_on_corners();
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (33, 30);
    scene.attachment.kind = AttachmentKind::FourSides;
    scene.yarn.draw = Draw::Yarn;
    scene.integrator = Integrator { tolerance: 1e-9, ..Integrator::THETA };
    scene.rotation_rule = RotationRule::theta(0.5);
    scene
}

/// Every third segment damaged beforehand, the sheet of [`uniform_sphere`] stretched a little and turning,
/// the sphere under a load.
pub fn prepare_and_load(sim: &mut Sim<'_>) {
    let damaged = |number: usize| if number.is_multiple_of(3) { 1.031 + 0.0003 * (number % 40) as f64 } else { 1.0 };
    let stretches: Vec<f64> = (0..sim.layout().segments()).map(damaged).collect();
    sim.set_largest_stretch(&stretches).expect("accepted");
    set_off(sim, |k, x| {
        let (x, inside) = (x.map(|x| x * 1.002), [k % 41, k / 41].iter().all(|at| (1..40).contains(at)));
        [x, if inside { [-50.0 * x[1], 50.0 * x[0], 0.0] } else { [0.0; 3] }]
    });
    sim.set_external_load([0.5, -0.25, 2000.0], [0.0; 3]).expect("accepted");
}

/// A hemispherical cylinder that strikes askew, its nose ahead, and tumbles through.
pub fn tumbling_bullet() -> Scene {
    let mut scene = tumbling_cylinder_on_corners();
    scene.attachment.kind = AttachmentKind::TwoSides;
    let body = &mut scene.projectile;
    body.shape = Shape::HemisphericalCylinder;
    (body.radius, body.length) = (3.5e-3, 0.011);
    scene
}

/// A box on one of its corners, without supports.
pub fn box_on_a_corner() -> Scene {
    let mut scene = free_plies_in_a_turned_frame();
    (scene.sheet.position, scene.sheet.orientation) = ([0.0; 3], [1.0, 0.0, 0.0, 0.0]);
    let body = &mut scene.projectile;
    (body.shape, body.size) = (Shape::Box, [6e-3, 8e-3, 0.01]);
    body.position = [1e-3, 5e-4, -7.1e-3];
    body.velocity = [30.0, -20.0, 700.0];
    body.orientation = [0.8, 0.48, 0.36, 0.0];
    body.angular_velocity = [-900.0, 400.0, 1100.0];
    scene
}

/// The preset's disc sector on a sheet of 121 x 121, faster and spinning about its disc's axis.
pub fn disc_sector() -> Scene {
    let mut scene = Scene::turbine_disc_sector();
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (121, 121);
    scene.projectile.velocity = [20.0, 10.0, 400.0];
    scene.projectile.angular_velocity = [200.0, -2000.0, 0.0];
    scene
}

/// A cylinder of unknown mass, moved by the host.
pub fn prescribed_cylinder() -> Scene {
    let mut scene = tumbling_cylinder_on_corners();
    scene.drive = Drive::Prescribed;
    scene.projectile.mass = 0.0;
    scene.attachment.kind = AttachmentKind::FourSides;
    scene
}

/// Down at about 300 m/s while turning, then slower.
pub fn two_paths() -> [Path; 2] {
    let motion = |z: f64, speed: f64, orientation: [f64; 4]| Motion {
        position: [1.2e-3, -6e-4, z],
        velocity: [5.0, 0.0, speed],
        orientation,
        angular_velocity: [200.0, 100.0, -500.0],
    };
    [
        Path { first: 0, steps: 700, end: motion(-1.9e-3, 250.0, [0.96, 0.28, 0.0, 0.0]) },
        Path { first: 700, steps: 500, end: motion(0.6e-3, 200.0, [0.96, 0.2, 0.0, -0.2]) },
    ]
}
