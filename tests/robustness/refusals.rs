//! Refusals that take more than one number (`inputs.rs` tries each by itself): the code, the field it names, and that nothing
//! was written. Then those of calls on a living simulation.

use fabric::{
    AttachmentKind, CacheLine, Code, Drive, Error, Faces, Layout, Motion, Path, Scene, Shape, Sim, StepAfterFailure,
    StepCheck, StrengthDraw, TimeStep,
};
use fabric_tests::{Buffers, positions, small_sheet, without_projectile};

/// Asserts that a scene is refused with this code and field, by checks and constructor alike where they look, and that the
/// constructor leaves its memory as it was.
#[track_caller]
fn refused(scene: &Scene, code: Code, field: &str) -> Error {
    // Enough for every scene below; the pattern would show any write.
    let mut memory = vec![CacheLine([7.5; 8]); 11_250];
    let error = Sim::new(scene, &mut memory).err().expect("refused");
    assert_eq!((error.code, error.field), (code, field), "{error}");
    assert!(memory.iter().all(|&line| line == CacheLine([7.5; 8])), "memory was written");
    if let Err(earlier) = scene.check() {
        assert_eq!((earlier.code, earlier.field), (code, field));
    }
    assert_eq!(scene.check_start(), Err(error));
    assert!(error.text().contains(field));
    error
}

/// Scenes of a billion nodes and more: what init would say of them takes it minutes, or more memory than there is. What is checked in
/// some milliseconds is what it would say, the more so where a part of the segments shows it.
#[test]
fn a_check_of_any_scene_takes_milliseconds() {
    fn large(s: &mut Scene) {
        (s.sheet.nodes_x, s.sheet.nodes_y, s.yarn.stochastic) = (65_000, 65_000, true);
    }
    /// A body wider than the sheet, whose lower edge comes as near as it may.
    fn over_all(s: &mut Scene) {
        (s.projectile.shape, s.projectile.size, s.projectile.mass) = (Shape::Box, [100.0, 100.0, 1.0], 1e3);
        (s.projectile.orientation, s.projectile.velocity) = ([0.999_999_5, 0.001, 0.0, 0.0], [0.0, 0.0, 1e-3]);
        s.projectile.position = [0.0, 0.0, -0.601];
    }
    type Case = (fn(&mut Scene), Result<(), (Code, &'static str)>);
    let cases: [Case; 10] = [
        (large, Ok(())),
        (|s| (s.sheet.nodes_x, s.sheet.nodes_y) = (65_536, 65_536), Err((Code::TooManyNodes, "sheet.nodes_x"))),
        (|s| (s.sheet.nodes_x, s.sheet.nodes_y) = (1 << 20, 4000), Ok(())),
        (|s| (large(s), s.yarn.draw = fabric::Draw::Yarn).1, Ok(())),
        (|s| (large(s), s.yarn.strength_draw = StrengthDraw::Weibull).1, Ok(())),
        (|s| (large(s), s.yarn.damage_sd = 1e5).1, Ok(())), // half of the draws are refused
        (|s| (large(s), s.time_step = TimeStep::seconds(2.7e-8)).1, Err((Code::StepTooLarge, "time_step.seconds"))),
        (
            |s| {
                large(s);
                (s.attachment.kind, s.sheet.pre_strain, s.yarn.draw) =
                    (AttachmentKind::FourSides, [0.02, 0.0], fabric::Draw::Yarn);
                (s.yarn.strength_draw, s.yarn.weibull_shape) = (StrengthDraw::Weibull, 2.0);
            },
            Err((Code::OutOfRange, "sheet.pre_strain")),
        ),
        (|s| (large(s), over_all(s)).1, Ok(())),
        (
            |s| {
                large(s);
                over_all(s);
                (s.attachment.kind, s.drive) = (AttachmentKind::FourCorners, Drive::Prescribed);
                s.attachment.disc_inset = 1.0;
                (s.projectile.size, s.sheet.grading.largest) = ([20.0, 20.0, 1.0], 2);
                s.sheet.grading.half_width = [100.0; 2];
            },
            Ok(()),
        ),
    ];
    for (k, (change, expected)) in cases.into_iter().enumerate() {
        let mut scene = base();
        change(&mut scene);
        let start = std::time::Instant::now();
        let found = scene.check_start();
        let took = start.elapsed();
        println!("case {k}: {:.2} ms, {found:?}", 1e3 * took.as_secs_f64());
        assert_eq!(found.map_err(|error| (error.code, error.field)), expected, "case {k}");
        // On a busy machine, too: a thousandth of what the draws take.
        assert!(took.as_secs_f64() < 0.5, "case {k}: {took:?}");
    }
}

/// Where a limit follows from another field, that one is named, too: a limit of 0 alone would help nobody.
#[test]
fn a_refusal_names_the_field_that_its_limit_follows_from() {
    type Change = fn(&mut Scene);
    let cases: [(Change, &str); 6] = [
        (|s| s.back.plies = 2, "back.plies: out of range; it is 2: see stack.plies"),
        (|s| s.sheet.spacing_y = 0.1, "sheet.spacing_y: out of range; it is 1e-1: see sheet.spacing"),
        (|s| s.projectile.mass = 1e-9, "projectile.mass: projectile lighter than a node: see sheet.node_mass"),
        (|s| s.yarn.damage_a = 2.0, "yarn.damage_a: out of range; it is 2: see yarn.damage_b"),
        (
            |s| (s.yarn.rate_modulus, s.yarn.rate_reference, s.yarn.rate_limit) = (0.1, 30.0, 1.0),
            "yarn.rate_limit: out of range; it is 1: see yarn.rate_reference",
        ),
        (
            |s| (s.attachment.kind, s.sheet.pre_strain) = (AttachmentKind::Free, [0.01, 0.0]),
            "sheet.pre_strain: pre-tension without equilibrium: an edge that is not held, or segments drawn one by one: see attachment.kind",
        ),
    ];
    for (change, text) in cases {
        let mut scene = base();
        change(&mut scene);
        assert_eq!(scene.check().unwrap_err().text().as_str(), text);
    }
}

/// The correlation of drawn strength is read for the back fabric alone, too: it is checked, and an image of another one does not fit.
#[test]
fn the_correlation_of_a_drawn_back_fabric_counts() {
    let mut scene = base();
    (scene.stack.plies, scene.back.plies, scene.back.node_mass) = (2, 1, scene.sheet.node_mass);
    scene.back.weibull_shape = 10.0;
    let of = |correlation: f64| {
        let mut scene = scene;
        scene.yarn.weibull_correlation = correlation;
        (scene.check().map_err(|error| error.field), fabric::internals::fingerprint::fingerprint(&scene, 1e-8))
    };
    assert_eq!(of(f64::NAN).0, Err("yarn.weibull_correlation"));
    assert!(of(0.0).0.is_ok() && of(0.0).1 != of(0.5).1);
}

/// A part of the segments tells a step that is too large or too small, never one that may be right.
#[test]
fn a_check_of_many_segments_refuses_nothing_that_init_takes() {
    let mut scene = base();
    (scene.sheet.nodes_x, scene.sheet.nodes_y, scene.yarn.modulus_sd) = (201, 201, 4e10);
    let limits = scene.step_limits().unwrap();
    let (fastest, memory) = (0.0254 / 35.0 / limits.dt, vec![CacheLine::ZERO; Layout::of(&scene).unwrap().lines()]);
    for (velocity, taken) in [(0.999, true), (1.001, false)] {
        scene.projectile.velocity[2] = velocity * fastest;
        assert_eq!(Sim::new(&scene, &mut memory.clone()).is_ok(), taken);
        assert!(scene.check_start().is_ok() || !taken);
    }
    scene.projectile.velocity[2] = 2.0 * fastest;
    assert!(scene.check_start().is_err_and(|error| error.code == Code::ProjectileTooFast));
    scene.projectile.velocity[2] = 50.0;
    for (fraction, refused) in [(0.999, false), (1.3, true)] {
        scene.time_step = TimeStep::seconds(fraction * limits.step_max);
        assert_eq!(scene.check_start().is_err_and(|error| error.code == Code::StepTooLarge), refused);
    }
}

fn base() -> Scene {
    let mut scene = small_sheet(9, 50.0);
    scene.yarn.stochastic = true;
    scene
}

/// Makes the projectile a cube by its faces.
fn cube(scene: &mut Scene) {
    let b = 6.35e-3;
    let body = &mut scene.projectile;
    body.shape = Shape::Polyhedron;
    body.faces = Faces::of(&[
        [1.0, 0.0, 0.0, b],
        [-1.0, 0.0, 0.0, b],
        [0.0, 1.0, 0.0, b],
        [0.0, -1.0, 0.0, b],
        [0.0, 0.0, 1.0, b],
        [0.0, 0.0, -1.0, b],
    ]);
    body.moments = [body.mass * 4.0 * b * b / 6.0; 3];
}

/// A change of one field.
type Change = fn(&mut Scene, f64);

#[test]
fn each_special_refusal_has_its_own_code() {
    let cases: [(Code, &str, Change, f64); 18] = [
        (Code::TooManyNodes, "sheet.nodes_x", |s, x| s.sheet.nodes_x = x as u32, 1_048_577.0),
        (Code::TooManyNodes, "sheet.nodes_y", |s, x| s.sheet.nodes_y = x as u32, 4e9),
        (Code::DamageRateTooSmall, "yarn.damage_intercept", |s, x| s.yarn.damage_intercept = x, -1106.1),
        (Code::ProjectileTooLight, "projectile.mass", |s, x| s.projectile.mass = x, 6.5e-8),
        (Code::ProjectileTooSmall, "projectile.radius", |s, x| s.projectile.radius = x, 7.2e-4),
        (
            Code::ProjectileTooSmall,
            "projectile.length",
            |s, x| {
                s.projectile.shape = Shape::Cylinder;
                s.projectile.length = x;
            },
            1.4e-3,
        ),
        (Code::BadQuaternion, "sheet.orientation", |s, x| s.sheet.orientation = [x, 0.0, 0.0, 0.0], 0.0),
        (Code::BadQuaternion, "sheet.orientation", |s, x| s.sheet.orientation[0] = x, 1.01),
        (Code::BadQuaternion, "projectile.orientation", |s, x| s.projectile.orientation = [x; 4], 0.0),
        (Code::BadQuaternion, "projectile.orientation", |s, x| s.projectile.orientation = [x; 4], 1e300),
        // 3.4e4 m/s cross a node spacing in a step.
        (Code::ProjectileTooFast, "projectile.velocity", |s, x| s.projectile.velocity[2] = x, 3.5e4),
        (Code::InitialOverlap, "projectile.position", |s, x| s.projectile.position[2] = x, -6.0e-3),
        (Code::InitialOverlap, "projectile.position", |s, x| s.projectile.position[2] = x, 0.0),
        // One rounding of a metre is refused, one of the radius is not.
        (Code::InitialOverlap, "projectile.position", |s, x| s.projectile.position[2] = -6.35e-3 + x, 1e-12),
        (Code::StepTooLarge, "time_step.seconds", |s, x| s.time_step = TimeStep::seconds(x), 2.7e-8),
        (Code::StepTooLarge, "time_step.seconds", |s, x| s.time_step = TimeStep::seconds(x), 1e300),
        // Kinetic energies that are no numbers.
        (Code::OutOfRange, "projectile.mass", |s, x| s.projectile.mass = x, 1e300),
        (Code::OutOfRange, "projectile.mass", |s, x| s.projectile.angular_velocity[0] = x, 1e200),
    ];
    for (code, field, change, value) in cases {
        let mut scene = base();
        change(&mut scene, value);
        refused(&scene, code, field);
    }
}

#[test]
fn a_turning_cylinder_counts_its_reach_and_its_turn() {
    let mut scene = fabric_tests::tilted_cylinder(9, 0.0, 50.0);
    let fastest = 0.0254 / 35.0 / scene.step_limits().unwrap().dt;
    let reach = (6.35e-3f64).hypot(0.01905);
    scene.projectile.angular_velocity = [1.001 * (fastest - 50.0) / reach, 0.0, 0.0];
    refused(&scene, Code::ProjectileTooFast, "projectile.velocity");
    scene.projectile.angular_velocity[0] *= 0.998;
    let mut memory = Buffers::of(&scene);
    assert!(Sim::new(&scene, &mut memory.lines).is_ok());
    // A sphere feels no torque: its spin is free.
    let mut sphere = base();
    sphere.projectile.angular_velocity = [1e9, 0.0, 0.0];
    let mut memory = Buffers::of(&sphere);
    assert!(Sim::new(&sphere, &mut memory.lines).is_ok());
}

/// What makes no sense with crimp, pre-tension and unlike directions: an edge that is not held, a line of segments that pull
/// differently, more than the law bears, a toe wider than the weft's critical strain, a projectile finer than
/// the larger spacing, a weft without a damage rate.
#[test]
fn fabrics_that_cannot_be_are_refused() {
    use fabric::Code::{DamageRateTooSmall, NotInEquilibrium, OutOfRange, ProjectileTooSmall};
    type Refusal = (Code, &'static str, fn(&mut Scene));
    let cases: [Refusal; 12] = [
        (NotInEquilibrium, "sheet.pre_strain", |s| {
            (s.attachment.kind, s.sheet.pre_strain) = (AttachmentKind::Free, [0.01, 0.0])
        }),
        (NotInEquilibrium, "sheet.pre_strain", |s| {
            (s.attachment.kind, s.sheet.pre_strain) = (AttachmentKind::TwoSides, [0.0, 0.01])
        }),
        (NotInEquilibrium, "sheet.pre_strain", |s| {
            (s.attachment.kind, s.sheet.pre_strain) = (AttachmentKind::FourCorners, [0.01, 0.01])
        }),
        (NotInEquilibrium, "yarn.draw", |s| (s.yarn.stochastic, s.sheet.pre_strain) = (true, [0.0, 0.01])),
        (OutOfRange, "sheet.crimp", |s| s.sheet.crimp = [0.0, 1.1]),
        (OutOfRange, "sheet.pre_strain", |s| s.sheet.pre_strain = [0.0301, 0.0]),
        (OutOfRange, "sheet.pre_strain", |s| (s.weft.critical_stretch, s.sheet.pre_strain) = (1.02, [0.01, 0.0201])),
        (OutOfRange, "weft.critical_stretch", |s| s.weft.critical_stretch = 0.99),
        (OutOfRange, "slack_toe", |s| (s.weft.critical_stretch, s.slack_toe) = (1.01, 0.02)),
        (OutOfRange, "sheet.spacing_y", |s| s.sheet.spacing_y = 0.09 * s.sheet.spacing),
        (ProjectileTooSmall, "projectile.radius", |s| {
            (s.projectile.radius, s.sheet.spacing_y) = (1.0e-3, 1.01e-3);
        }),
        (DamageRateTooSmall, "weft.damage_intercept", |s| s.weft.modulus_mean = 100e9),
    ];
    for (code, field, change) in cases {
        let mut scene = base();
        scene.yarn.stochastic = false;
        (scene.attachment.disc_inset, scene.attachment.disc_radius) = (0.0, 1e-4);
        scene.projectile.position[2] = -7e-3;
        change(&mut scene);
        refused(&scene, code, field);
    }
    // A modulus that does not scatter, or only from yarn to yarn, pulls evenly.
    for (sd, draw) in [(0.0, fabric::Draw::Segment), (2e9, fabric::Draw::Yarn)] {
        let mut scene = base();
        (scene.sheet.pre_strain, scene.yarn.modulus_sd, scene.yarn.draw) = ([0.01, 0.0], sd, draw);
        Buffers::of(&scene).sim(&scene);
    }
}

/// Every two options that do not go together: both are named, whichever of them a host thinks of first.
#[test]
fn options_that_do_not_go_together_are_both_named() {
    type Pair = (&'static str, &'static str, fn(&mut Scene), fn(&mut Scene));
    let theta = |s: &mut Scene| s.integrator = fabric::Integrator::THETA;
    let plies = |s: &mut Scene| s.stack.plies = 2;
    let toe = |s: &mut Scene| s.slack_toe = 0.02;
    let friction = |s: &mut Scene| s.contact.friction = 0.2;
    let strength = |s: &mut Scene| s.yarn.strength_draw = StrengthDraw::Weibull;
    let modulus = |s: &mut Scene| {
        (s.yarn.rate_modulus, s.yarn.rate_reference, s.yarn.rate_limit) = (0.1, 30.0, 170.0);
    };
    let stretch = |s: &mut Scene| {
        (s.yarn.rate_stretch, s.yarn.rate_reference, s.yarn.rate_limit) = (0.1, 30.0, 170.0);
    };
    let mirror_x = |s: &mut Scene| s.symmetry.mirror_x = true;
    let mirror_y = |s: &mut Scene| s.symmetry.mirror_y = true;
    let strained = |s: &mut Scene| s.sheet.pre_strain = [0.0, 0.01];
    let graded = |s: &mut Scene| s.sheet.grading.largest = 4;
    let pairs: [Pair; 31] = [
        ("yarn.viscosity_linear", "sheet.grading.largest", |s| s.yarn.viscosity_linear = 0.06, graded),
        ("yarn.viscosity_quadratic", "sheet.grading.largest", |s| s.yarn.viscosity_quadratic = 1.5, graded),
        ("yarn.viscosity_bending", "sheet.grading.largest", |s| s.yarn.viscosity_bending = 0.06, graded),
        ("yarn.rate_modulus", "sheet.grading.largest", modulus, graded),
        ("yarn.rate_stretch", "sheet.grading.largest", stretch, graded),
        ("contact.friction", "sheet.grading.largest", friction, graded),
        ("stack.plies", "sheet.grading.largest", plies, graded),
        ("contact.friction", "integrator.kind", friction, theta),
        ("yarn.rate_modulus", "integrator.kind", modulus, theta),
        ("yarn.rate_stretch", "integrator.kind", stretch, theta),
        ("yarn.rate_modulus", "stack.plies", modulus, plies),
        ("yarn.rate_stretch", "stack.plies", stretch, plies),
        ("yarn.viscosity_linear", "integrator.kind", |s| s.yarn.viscosity_linear = 0.06, theta),
        ("yarn.viscosity_quadratic", "integrator.kind", |s| s.yarn.viscosity_quadratic = 1.5, theta),
        ("yarn.viscosity_bending", "integrator.kind", |s| s.yarn.viscosity_bending = 0.06, theta),
        ("slack_toe", "integrator.kind", toe, theta),
        ("slack_toe", "yarn.strength_draw", toe, strength),
        ("slack_toe", "yarn.rate_modulus", toe, modulus),
        ("slack_toe", "yarn.rate_stretch", toe, stretch),
        ("step_after_failure", "integrator.kind", |s| s.step_after_failure = StepAfterFailure::Half, theta),
        ("stack.plies", "integrator.kind", plies, theta),
        ("stack.plies", "symmetry.mirror_x", plies, mirror_x),
        ("stack.plies", "symmetry.mirror_y", plies, mirror_y),
        ("yarn.stochastic", "symmetry.mirror_x", |s| s.yarn.stochastic = true, mirror_x),
        ("yarn.strength_draw", "symmetry.mirror_y", strength, mirror_y),
        ("drive", "symmetry.mirror_x", |s| s.drive = Drive::Prescribed, mirror_x),
        ("drive", "symmetry.mirror_y", |s| s.drive = Drive::Prescribed, mirror_y),
        ("sheet.pre_strain", "yarn.rate_modulus", strained, modulus),
        ("sheet.pre_strain", "yarn.rate_stretch", strained, stretch),
        ("sheet.crimp", "sheet.pre_strain", |s| s.sheet.crimp = [0.0, 0.01], strained),
        (
            "stack.turned",
            "sheet.spacing_y",
            |s| (s.stack.plies, s.stack.turned) = (2, true),
            |s| {
                s.sheet.spacing_y = 1.1 * s.sheet.spacing;
            },
        ),
    ];
    for (field, with, first, second) in pairs {
        let mut scene = base();
        (scene.yarn.stochastic, scene.attachment.kind) = (false, AttachmentKind::FourSides);
        (scene.projectile.position[2], scene.time_step) = (-7e-3, TimeStep::fraction(0.4));
        for alone in [first, second] {
            let mut one = scene;
            alone(&mut one);
            one.check().unwrap_or_else(|error| panic!("{field}, {with}: {error}"));
        }
        first(&mut scene);
        second(&mut scene);
        let error = scene.check().unwrap_err();
        assert_eq!((error.code, error.field, error.with), (Code::DoesNotGoWith, field, with));
        assert_eq!(error.text().as_str(), format!("{field}: does not go with another field: {with}"));
    }
}

#[test]
fn corner_discs_that_overlap_or_reach_the_projectile_are_refused() {
    // As on the paper's 3 in sheet: washers of 0.75 in radius, 1 in from the edges.
    let mut scene = Scene::sheet_3in_sphere();
    scene.attachment.kind = AttachmentKind::FourCorners;
    (scene.attachment.disc_inset, scene.attachment.disc_radius) = (25.4e-3, 19.05e-3);
    let mut buffers = Buffers::of(&Scene::sheet_3in_sphere());
    let error = Sim::new(&scene, &mut buffers.lines).err().unwrap();
    assert_eq!((error.code, error.field), (Code::DiscsOverlap, "attachment.disc_radius"));
    scene.attachment.disc_radius = 12.0e-3;
    let error = Sim::new(&scene, &mut buffers.lines).err().unwrap();
    assert_eq!((error.code, error.field), (Code::DiscTouchesProjectile, "attachment.disc_radius"));
}

/// Discs of 0.4 mm centred in a mesh of 0.73 mm hold no node: without the refusal that is a free sheet. The error names the radius
/// that reaches a node, whole or with mirror planes, in Rust and so in C and FMI; with a little more each disc holds its node.
#[test]
fn corner_discs_that_hold_no_node_are_refused() {
    for (mirror_x, mirror_y) in [(false, false), (true, false), (false, true), (true, true)] {
        let mut scene = base();
        scene.yarn.stochastic = false;
        (scene.sheet.nodes_x, scene.sheet.nodes_y) = (41, 40);
        scene.symmetry = fabric::Symmetry { mirror_x, mirror_y };
        scene.attachment.kind = AttachmentKind::FourCorners;
        (scene.attachment.disc_inset, scene.attachment.disc_radius) = (1.5 * scene.sheet.spacing, 0.4e-3);
        let error = refused(&scene, Code::HoldsNothing, "attachment.disc_radius");
        fabric_tests::close(error.limit, 0.5f64.sqrt() * scene.sheet.spacing, 1e-12);
        scene.attachment.disc_radius = 1.001 * error.limit;
        let mut memory = Buffers::of(&scene);
        let mut sim = memory.sim(&scene);
        sim.advance(1500).unwrap();
        let impulses = sim.support().unwrap().attachments;
        assert!(impulses.iter().all(|impulse| impulse[2] > 0.0), "{mirror_x} {mirror_y} {impulses:?}");
    }
}

/// Soft yarn allows a step in which a usual speed crosses more than a spacing: the error says which step is small enough for it, and
/// that step is accepted as it stands; a turning body and a path likewise.
#[test]
fn a_projectile_too_fast_for_the_step_is_told_the_largest_step() {
    let mut soft = base();
    soft.yarn =
        fabric::Yarn { stochastic: false, modulus_mean: 5e6, damage_slope: 0.0, damage_intercept: 230.0, ..soft.yarn };
    soft.projectile.velocity[2] = 300.0;
    let mut turning = fabric_tests::tilted_cylinder(9, 0.0, 50.0);
    turning.projectile.angular_velocity = [3e6, 0.0, 0.0];
    let mut whirling = turning;
    // So large a spacing that half a radian, and not the spacing, is what the spin may not exceed.
    whirling.sheet.spacing = 6.3e-3;
    whirling.projectile.radius = 6.35e-3;
    whirling.projectile.length = 0.0127;
    whirling.projectile.angular_velocity = [1.2e7, 0.0, 0.0];
    for (name, mut scene) in [("soft", soft), ("turning", turning), ("whirling", whirling)] {
        scene.projectile.position[2] = -0.05;
        let error = refused(&scene, Code::ProjectileTooFast, "projectile.velocity");
        // The step in the text has five digits, rounded down: it is accepted as it stands.
        let said = error.text();
        let (_, step) = said.split_once("; the largest step for this motion is ").expect("a step");
        let step: f64 = step.trim_end_matches(" s").parse().expect("a number");
        assert!(step <= error.limit && step > 0.9998 * error.limit, "{name}: {said}");
        scene.time_step = TimeStep::seconds(error.limit);
        let mut memory = Buffers::of(&scene);
        assert!(Sim::new(&scene, &mut memory.lines).is_ok(), "{name}: {error:?}");
        // And a larger one is not.
        scene.time_step = TimeStep::seconds(error.limit * (1.0 + 1e-12));
        refused(&scene, Code::ProjectileTooFast, "projectile.velocity");
    }
}

#[test]
fn a_step_refusal_names_the_largest_step_and_taking_that_step_works() {
    let mut scene = base();
    scene.time_step = TimeStep::seconds(5e-8);
    let error = refused(&scene, Code::StepTooLarge, "time_step.seconds");
    assert!(error.text().contains("the largest allowed is 2"));
    scene.time_step = TimeStep::seconds(error.limit);
    let mut memory = Buffers::of(&scene);
    assert!(Sim::new(&scene, &mut memory.lines).is_ok());
    scene.time_step = TimeStep::seconds(error.limit.next_up());
    refused(&scene, Code::StepTooLarge, "time_step.seconds");
    scene.step_check = StepCheck::None;
    let mut memory = Buffers::of(&scene);
    assert!(Sim::new(&scene, &mut memory.lines).is_ok());
}

/// Boxes, hemispherical cylinders and polyhedra: sound as they are, refused with one thing wrong.
#[test]
fn shapes_that_are_none_or_too_small_are_refused() {
    type Make = fn(&mut Scene);
    let bullet = |scene: &mut Scene| {
        scene.projectile.shape = Shape::HemisphericalCylinder;
        scene.projectile.position[2] = -0.02;
    };
    let cuboid = |scene: &mut Scene| scene.projectile.shape = Shape::Box;
    let sound: [Make; 3] = [bullet, cuboid, cube];
    for make in sound {
        let mut scene = base();
        make(&mut scene);
        let mut memory = Buffers::of(&scene);
        assert!(Sim::new(&scene, &mut memory.lines).is_ok());
        // A start inside: the flat face or the nose ahead is nearer to the centre than a tenth of the size.
        scene.projectile.position[2] = 0.0;
        refused(&scene, Code::InitialOverlap, "projectile.position");
    }
    let n = (1.0f64 / 3.0).sqrt();
    let cases: [(Code, &str, Make, Change, f64); 20] = [
        (Code::ProjectileTooSmall, "projectile.radius", bullet, |s, x| s.projectile.radius = x, 7.2e-4),
        (Code::OutOfRange, "projectile.length", bullet, |s, x| s.projectile.length = x, 6.34e-3),
        (Code::ProjectileTooSmall, "projectile.length", bullet, |s, x| s.projectile.length = x, 1.4e-3),
        (Code::ProjectileTooSmall, "projectile.size", cuboid, |s, x| s.projectile.size[0] = x, 1.45e-3),
        (Code::ProjectileTooSmall, "projectile.size", cuboid, |s, x| s.projectile.size[1] = x, 1e-9),
        (Code::ProjectileTooSmall, "projectile.faces.planes", cube, |s, x| s.projectile.faces.planes[2][3] = x, 7.2e-4),
        (Code::OutOfRange, "projectile.faces.count", cube, |s, x| s.projectile.faces.count = x as u32, 0.0),
        (Code::OutOfRange, "projectile.faces.count", cube, |s, x| s.projectile.faces.count = x as u32, 3.0),
        (Code::OutOfRange, "projectile.faces.count", cube, |s, x| s.projectile.faces.count = x as u32, 17.0),
        (Code::OutOfRange, "projectile.faces.count", cube, |s, x| s.projectile.faces.count = x as u32, 4e9),
        (Code::BadNormal, "projectile.faces.planes", cube, |s, x| s.projectile.faces.planes[1][0] = x, 0.0),
        (Code::BadNormal, "projectile.faces.planes", cube, |s, x| s.projectile.faces.planes[1][0] = x, -1.00001),
        (Code::BadNormal, "projectile.faces.planes", cube, |s, x| s.projectile.faces.planes[4][1] = x, 0.1),
        (Code::BadNormal, "projectile.faces.planes", cube, |s, x| s.projectile.faces.planes[4][1] = x, 1e300),
        (Code::UnboundedFaces, "projectile.faces.planes", cube, |s, x| s.projectile.faces.count = x as u32, 5.0),
        (Code::UnboundedFaces, "projectile.faces.planes", cube, |s, x| s.projectile.faces.count = x as u32, 4.0),
        // The same face twice, and the one against it missing.
        (Code::UnboundedFaces, "projectile.faces.planes", cube, |s, x| s.projectile.faces.planes[5][2] = x, 1.0),
        (Code::ImpossibleMoments, "projectile.moments", cube, |s, x| s.projectile.moments[0] *= x, 2.001),
        (Code::ImpossibleMoments, "projectile.moments", cube, |s, x| s.projectile.moments[1] *= x, 1e300),
        (Code::ImpossibleMoments, "projectile.moments", cube, |s, x| s.projectile.moments[2] *= x, 1e9),
    ];
    for (code, field, make, change, value) in cases {
        let mut scene = base();
        make(&mut scene);
        change(&mut scene, value);
        refused(&scene, code, field);
    }
    // Moments of a body of unknown mass are not read; normals with seven digits are good enough.
    let mut scene = base();
    cube(&mut scene);
    (scene.drive, scene.projectile.mass, scene.projectile.moments) = (Drive::Prescribed, 0.0, [f64::NAN; 3]);
    scene.projectile.faces =
        Faces::of(&[[n, n, n, 2e-3], [n, -n, -n, 2e-3], [-n, n, -n, 2e-3], [-0.5773503, -0.5773503, 0.5773503, 2e-3]]);
    let mut memory = Buffers::of(&scene);
    assert_eq!(Sim::new(&scene, &mut memory.lines).err(), None);
}

/// Dimensions that a shape does not have are not read.
#[test]
fn dimensions_of_other_shapes_are_not_read() {
    let mut scene = base();
    let nonsense = [f64::NAN; 3];
    let faces = Faces { count: u32::MAX, planes: [[f64::NAN; 4]; fabric::MAX_FACES] };
    (scene.projectile.size, scene.projectile.faces, scene.projectile.moments) = (nonsense, faces, nonsense);
    let mut memory = Buffers::of(&scene);
    memory.sim(&scene).advance(100).unwrap();
    cube(&mut scene);
    (scene.projectile.radius, scene.projectile.length, scene.projectile.size) = (f64::NAN, -1.0, nonsense);
    let mut memory = Buffers::of(&scene);
    memory.sim(&scene).advance(100).unwrap();
}

/// The corner discs keep clear of what a box or a polyhedron covers as it lies, corners included.
#[test]
fn corner_discs_under_a_box_are_refused() {
    let mut scene = Scene::sheet_3in_sphere();
    scene.attachment.kind = AttachmentKind::FourCorners;
    (scene.attachment.disc_inset, scene.attachment.disc_radius) = (13e-3, 10e-3);
    scene.projectile.shape = Shape::Box;
    scene.projectile.size = [0.03, 0.03, 0.01];
    scene.projectile.position[2] = -0.02;
    // Discs at (+-24.7, +-24.7) mm, 34.9 mm from the centre, leave 24.9 mm; the corners lie at 21.2 mm.
    assert!(scene.check().is_ok());
    scene.attachment.disc_radius = 14e-3;
    assert_eq!(scene.check().unwrap_err().code, Code::DiscTouchesProjectile);
    // On its edge the box covers 30 x 22 mm or so, and less across the corners.
    scene.projectile.size = [0.03, 0.01, 0.03];
    scene.check().unwrap();
}

/// m = 1e-20 kg asks for a step of 1e-14 s: refused with the usual one, accepted with that.
#[test]
fn a_very_light_sheet_is_never_given_a_smaller_step_in_silence() {
    let mut scene = base();
    scene.sheet.node_mass = 1e-20;
    scene.time_step = TimeStep::seconds(2e-8);
    refused(&scene, Code::StepTooLarge, "time_step.seconds");
    scene.time_step = TimeStep::seconds(1e-14);
    let mut memory = Buffers::of(&scene);
    let mut sim = memory.sim(&scene);
    sim.advance(100).unwrap();
    assert!(sim.contact().unwrap().work > 0.0);
}

#[test]
fn parameters_that_give_no_usable_step_are_refused() {
    let cases: [Change; 3] = [
        |s, x| s.sheet.node_mass = x,
        |s, x| s.sheet.spacing = x,
        |s, x| {
            s.sheet.spacing = x;
            s.sheet.node_mass = x;
        },
    ];
    for change in cases {
        let mut scene = base();
        scene.projectile.position = [0.0, 0.0, -1.0];
        scene.projectile.velocity = [0.0; 3];
        change(&mut scene, 1e-310);
        let mut memory = Buffers { lines: vec![CacheLine::ZERO; 11_250] };
        let error = Sim::new(&scene, &mut memory.lines).err().expect("refused");
        assert_eq!(error.code, Code::StepLimitUnusable, "{error}");
    }
    let mut scene = base();
    // From about 6e-51 s down, motion that counts as rest would be faster than 1e-30 m/s.
    for (dt, refusal) in [(f64::MIN_POSITIVE, true), (1e-51, true), (1e-50, false)] {
        scene.time_step = TimeStep::seconds(dt);
        assert_eq!(scene.step_limits().is_err_and(|error| error.code == Code::StepLimitUnusable), refusal, "{dt:e}");
    }
    scene.time_step = TimeStep::seconds(f64::MIN_POSITIVE);
    refused(&scene, Code::StepLimitUnusable, "time_step.seconds");
    // Unchecked, up to k dt^2/m = 1e6: some thousand times the stable step.
    scene.step_check = fabric::StepCheck::None;
    for (fraction, refusal) in [(0.4, false), (100.0, false), (1e4, true)] {
        scene.time_step = TimeStep::fraction(fraction);
        assert_eq!(
            scene.step_limits().is_err_and(|error| error.code == Code::StepLimitUnusable),
            refusal,
            "{fraction:e}"
        );
    }
    // Nodes so heavy that the momentum of a sheet is no number; all plies count.
    let mut scene = without_projectile(base());
    scene.projectile.mass = 0.0;
    for (node_mass, plies, refusal) in [(1e89, 1, false), (1e91, 1, true), (1e89, 1000, true), (f64::MAX, 3, true)] {
        (scene.sheet.node_mass, scene.sheet.plies) = (node_mass, plies);
        let limits = scene.step_limits();
        assert_eq!(limits.is_err_and(|error| error.code == Code::StepLimitUnusable), refusal, "{node_mass:e}");
    }
}

#[test]
fn a_sheet_larger_than_memory_is_refused_before_anything_is_computed() {
    let mut scene = base();
    // Drawing its segments for the step limit would take a day.
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (1 << 20, 1 << 20);
    match Layout::of(&scene) {
        Err(error) => assert_eq!(error.code, Code::TooManyNodes),
        Ok(layout) => {
            assert!(layout.bytes() > 1 << 40);
            refused(&scene, Code::ShortBuffer, "memory");
        }
    }
}

// ---- Calls on a living simulation ------------------------------------------------------------------------------------

/// Asserts that a call is refused and leaves the simulation's bits alone.
#[track_caller]
fn call_refused(sim: &mut Sim<'_>, code: Code, field: &str, call: impl FnOnce(&mut Sim<'_>) -> Result<(), Error>) {
    let before = sim.digest();
    let error = call(sim).expect_err("refused");
    assert_eq!((error.code, error.field), (code, field), "{error}");
    assert_eq!(sim.digest(), before, "a refused call changed the state");
    assert!(sim.failure().is_none());
}

#[test]
fn external_loads_are_checked() {
    let mut memory = Buffers::of(&base());
    let mut sim = memory.sim(&base());
    for bad in [f64::NAN, f64::INFINITY] {
        call_refused(&mut sim, Code::NotFinite, "external.force", |s| s.set_external_load([0.0, bad, 0.0], [0.0; 3]));
        call_refused(&mut sim, Code::NotFinite, "external.torque", |s| s.set_external_load([0.0; 3], [bad, 0.0, 0.0]));
    }
    let mut scene = base();
    scene.drive = Drive::Prescribed;
    let mut memory = Buffers::of(&scene);
    let mut sim = memory.sim(&scene);
    call_refused(&mut sim, Code::WrongDrive, "drive", |s| s.set_external_load([0.0; 3], [0.0; 3]));
}

#[test]
fn motions_set_by_hand_are_checked() {
    let scene = base();
    let mut memory = Buffers::of(&scene);
    let mut sim = memory.sim(&scene);
    let nodes = sim.layout().nodes();
    let x: Vec<f64> = positions(&sim).into_iter().flatten().collect();
    let v = vec![0.0; 3 * nodes];
    let with = |values: &[f64], at: usize, value: f64| {
        let mut changed = values.to_vec();
        changed[at] = value;
        changed
    };
    call_refused(&mut sim, Code::WrongLength, "positions", |s| s.set_motion(&x[1..], &v));
    call_refused(&mut sim, Code::WrongLength, "velocities", |s| s.set_motion(&x, &[]));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for at in [0, 3 * nodes / 2, 3 * nodes - 1] {
            call_refused(&mut sim, Code::NotFinite, "positions", |s| s.set_motion(&with(&x, at, bad), &v));
            call_refused(&mut sim, Code::NotFinite, "velocities", |s| s.set_motion(&x, &with(&v, at, bad)));
        }
    }
    // Node 0 is fixed; node 40 is the middle of 9 x 9, and 3 mm below the plane it is inside the sphere.
    // What is told is the number in SI units, not that of the node.
    let told = |sim: &mut Sim<'_>, code, field, x: &[f64], v: &[f64], value: f64| {
        let error = sim.set_motion(x, v).unwrap_err();
        assert_eq!((error.code, error.field), (code, field));
        assert!((error.value / value - 1.0).abs() < 1e-9, "{error:?}");
    };
    told(&mut sim, Code::OutOfRange, "velocities", &x, &with(&v, 1, 1e-9), 1e-9);
    told(&mut sim, Code::OutOfRange, "positions", &with(&x, 3 * 40, 1e40), &v, 1e40);
    // The sphere's centre is its radius and 1 nm before the plane.
    let deep = scene.projectile.position[2].abs() - 3e-3 - scene.projectile.radius;
    told(&mut sim, Code::InitialOverlap, "positions", &with(&x, 3 * 40 + 2, -3e-3), &v, deep);
    call_refused(&mut sim, Code::InitialOverlap, "positions", |s| s.set_motion(&with(&x, 3 * 40 + 2, -3e-3), &v));
    sim.step().unwrap();
    call_refused(&mut sim, Code::AlreadyStarted, "", |s| s.set_motion(&x, &v));
}

#[test]
fn largest_stretches_are_checked() {
    let scene = base();
    let mut memory = Buffers::of(&scene);
    let mut sim = memory.sim(&scene);
    let segments = sim.layout().segments();
    let with = |value: f64| {
        let mut stretches = vec![1.0; segments];
        stretches[segments - 1] = value;
        stretches
    };
    call_refused(&mut sim, Code::WrongLength, "stretches", |s| s.set_largest_stretch(&[1.0]));
    call_refused(&mut sim, Code::NotFinite, "stretches", |s| s.set_largest_stretch(&with(f64::NAN)));
    call_refused(&mut sim, Code::NotFinite, "stretches", |s| s.set_largest_stretch(&with(f64::INFINITY)));
    call_refused(&mut sim, Code::OutOfRange, "stretches", |s| s.set_largest_stretch(&with(-0.1)));
    call_refused(&mut sim, Code::OutOfRange, "stretches", |s| s.set_largest_stretch(&with(1e101)));
    sim.step().unwrap();
    call_refused(&mut sim, Code::AlreadyStarted, "", |s| s.set_largest_stretch(&with(1.0)));
}

#[test]
fn paths_are_checked() {
    let mut scene = base();
    let at_rest = Motion {
        position: scene.projectile.position,
        velocity: [0.0; 3],
        orientation: [1.0, 0.0, 0.0, 0.0],
        angular_velocity: [0.0; 3],
    };
    let good = Path { first: 0, steps: 1000, end: at_rest };
    let mut memory = Buffers::of(&scene);
    let mut sim = memory.sim(&scene);
    call_refused(&mut sim, Code::WrongDrive, "drive", |s| s.follow(&good, 1));

    scene.drive = Drive::Prescribed;
    scene.projectile.mass = 0.0;
    let mut memory = Buffers::of(&scene);
    let mut sim = memory.sim(&scene);
    call_refused(&mut sim, Code::BadPath, "path.steps", |s| s.follow(&Path { steps: 0, ..good }, 0));
    call_refused(&mut sim, Code::BadPath, "path.first", |s| s.follow(&Path { first: 1, ..good }, 1));
    call_refused(&mut sim, Code::BadPath, "steps", |s| s.follow(&good, 1001));
    call_refused(&mut sim, Code::BadPath, "path.steps", |s| {
        s.follow(&Path { first: u64::MAX, steps: u64::MAX, ..good }, 1)
    });
    call_refused(&mut sim, Code::BadPath, "path.steps", |s| s.follow(&Path { steps: (1 << 53) + 1, ..good }, 1));
    for bad in [f64::NAN, f64::INFINITY] {
        let ends: [(&str, Motion); 4] = [
            ("path.position", Motion { position: [bad, 0.0, 0.0], ..at_rest }),
            ("path.velocity", Motion { velocity: [0.0, bad, 0.0], ..at_rest }),
            ("path.orientation", Motion { orientation: [1.0, 0.0, bad, 0.0], ..at_rest }),
            ("path.angular_velocity", Motion { angular_velocity: [0.0, 0.0, bad], ..at_rest }),
        ];
        for (field, end) in ends {
            call_refused(&mut sim, Code::NotFinite, field, |s| s.follow(&Path { end, ..good }, 1));
        }
    }
    let end = Motion { orientation: [0.0; 4], ..at_rest };
    call_refused(&mut sim, Code::BadQuaternion, "path.orientation", |s| s.follow(&Path { end, ..good }, 1));
    // 1 m in 1000 steps is 5e4 m/s.
    let end = Motion { position: [0.0, 0.0, 1.0], ..at_rest };
    call_refused(&mut sim, Code::ProjectileTooFast, "path.velocity", |s| s.follow(&Path { end, ..good }, 1));
    let end = Motion { velocity: [0.0, 0.0, 1e6], ..at_rest };
    call_refused(&mut sim, Code::ProjectileTooFast, "path.velocity", |s| s.follow(&Path { end, ..good }, 1));
    // A path that is over cannot be followed again, and one that has begun cannot be entered late.
    sim.follow(&good, 1000).unwrap();
    call_refused(&mut sim, Code::BadPath, "path.first", |s| s.follow(&good, 1));
}

#[test]
fn read_outs_of_the_wrong_length_are_refused_and_nothing_is_written() {
    let mut memory = Buffers::of(&base());
    let sim = memory.sim(&base());
    let (nodes, segments) = (sim.layout().nodes(), sim.layout().segments());
    for off in [-1isize, 1] {
        let at = |n: usize| n.checked_add_signed(off).unwrap();
        let mut out = vec![7.5; at(3 * nodes)];
        for error in [sim.copy_positions(&mut out), sim.copy_velocities(&mut out)] {
            assert_eq!(
                error.unwrap_err(),
                Error::new(Code::WrongLength, "out", at(3 * nodes) as f64, 3.0 * nodes as f64)
            );
        }
        assert!(out.iter().all(|&x| x == 7.5));
        let mut out = vec![7.5; at(segments)];
        for error in [sim.copy_damage(&mut out), sim.copy_stretch(&mut out)] {
            assert_eq!(error.unwrap_err().code, Code::WrongLength);
        }
        assert!(out.iter().all(|&x| x == 7.5));
    }
}

#[test]
fn a_load_beyond_all_numbers_in_the_sheets_axes() {
    let mut scene = base();
    (scene.sheet.orientation, scene.projectile.orientation) = ([0.8, 0.6, 0.0, 0.0], [0.8, 0.6, 0.0, 0.0]);
    scene.projectile.position = [0.0, 1.0, 1.0];
    let mut memory = Buffers::of(&scene);
    let mut sim = memory.sim(&scene);
    let most = [f64::MAX; 3];
    call_refused(&mut sim, Code::NotFinite, "external.force", |s| s.set_external_load(most, [0.0; 3]));
    call_refused(&mut sim, Code::NotFinite, "external.torque", |s| s.set_external_load([0.0; 3], most));
}
