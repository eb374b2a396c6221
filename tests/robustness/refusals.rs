//! Refusals that take more than one number (`inputs.rs` tries each by itself): the code, the field it names,
//! and that nothing was written. Then those of calls on a living simulation.

use fabric_kernel::Code::{self, *};
use fabric_kernel::{
    AttachmentKind, CacheLine, Drive, Error, Faces, Layout, Motion, Path, Scene, Sim, StepCheck, TimeStep,
};
use fabric_tests::inputs::{self, assign};
use fabric_tests::{AT_REST, drawn, memory_of, positions, sim_of, small_sheet, stepped, tilted_cylinder};

/// Numbers of a scene and what they become, as `inputs::assign` takes them.
type Changes = [(&'static str, f64)];

/// One of the sound scenes of the table of inputs with these changes.
fn changed(base: &str, changes: &Changes) -> Scene {
    let mut scene = inputs::scene(base);
    changes.iter().for_each(|(name, value)| assert!(assign(&mut scene, name, *value), "{name}"));
    scene
}

/// Asserts that a scene is refused with this code and field, by checks and constructor alike where they look,
/// and that the constructor leaves its memory as it was.
#[track_caller]
fn refused(scene: &Scene, code: Code, field: &str) -> Error {
    // Enough for every scene below; the pattern would show any write.
    let mut memory = vec![CacheLine([7.5; 8]); 11_250];
    let error = Sim::new(scene, &mut memory).err().unwrap_or_else(|| panic!("taken, not {code:?} {field}"));
    assert_eq!((error.code, error.field), (code, field), "{error}");
    assert!(memory.iter().all(|&line| line == CacheLine([7.5; 8])), "memory was written");
    if let Err(earlier) = scene.check() {
        assert_eq!((earlier.code, earlier.field), (code, field));
    }
    assert!(scene.check_start().is_err_and(|earlier| (earlier.code, earlier.field) == (code, field)));
    assert!(error.text().contains(field));
    error
}

/// One row, one refusal: a sound scene, what of it is changed, the code and the field.
#[rustfmt::skip]
const REFUSED: &[(&str, &Changes, Code, &str)] = &[
    // One rounding of a metre is an overlap, one of the radius is none.
    ("sphere", &[("projectile.position[2]", -6.35e-3 + 1e-12)], InitialOverlap, "projectile.position"),
    ("bullet", &[("projectile.position[2]", 0.0)], InitialOverlap, "projectile.position"),
    ("box", &[("projectile.position[2]", 0.0)], InitialOverlap, "projectile.position"),
    ("cube", &[("projectile.position[2]", 0.0)], InitialOverlap, "projectile.position"),
    ("stack", &[("projectile.position[2]", 0.0)], InitialOverlap, "projectile.position"),
    // Pre-tension: edges that are not held, more than the law of any yarn bears, plies turned under the pull
    // of one direction.
    ("uniform", &[("attachment.kind", 3.0), ("sheet.pre_strain[0]", 0.01)], NotInEquilibrium, "sheet.pre_strain"),
    ("uniform", &[("attachment.kind", 0.0), ("sheet.pre_strain[1]", 0.01)], NotInEquilibrium, "sheet.pre_strain"),
    ("uniform", &[("weft.critical_stretch", 1.02), ("sheet.pre_strain[0]", 0.01), ("sheet.pre_strain[1]", 0.0201)],
        OutOfRange, "sheet.pre_strain"),
    ("uniform", &[("stack.plies", 3.0), ("stack.turned", 1.0), ("attachment.kind", 0.0),
        ("sheet.pre_strain[0]", 0.01)], NotInEquilibrium, "stack.turned"),
    ("hybrid", &[("yarn.stochastic", 0.0), ("back.modulus_sd", 0.0), ("sheet.pre_strain[0]", 0.01),
        ("back.crimp[0]", 0.01)], DoesNotGoWith, "back.crimp"),
    ("hybrid", &[("back.weibull_shape", 10.0), ("yarn.weibull_correlation", f64::NAN)],
        NotFinite, "yarn.weibull_correlation"),
    // No step is short enough: within one a segment may become taut, and go on as far as to its critical
    // stretch.
    ("wide", &[("yarn.viscosity_quadratic", 10.0)], OutOfRange, "yarn.viscosity_quadratic"),
    ("fraction", &[("time_step.fraction", 0.4), ("yarn.viscosity_bending", 0.2)], OutOfRange, "time_step.fraction"),
    // Unchecked, up to k dt^2/m = 1e6: some thousand times the stable step. Nodes so heavy that a sheet's
    // momentum is no number.
    ("unchecked", &[("time_step.fraction", 1e4)], StepLimitUnusable, "time_step.seconds"),
    ("fraction", &[("drive", 1.0), ("projectile.mass", 0.0), ("projectile.velocity[2]", 0.0),
        ("sheet.node_mass", 1e91)], StepLimitUnusable, "time_step.seconds"),
    ("fraction", &[("drive", 1.0), ("projectile.mass", 0.0), ("projectile.velocity[2]", 0.0),
        ("sheet.node_mass", 1e89), ("sheet.plies", 1000.0)], StepLimitUnusable, "time_step.seconds"),
    ("fraction", &[("drive", 1.0), ("projectile.mass", 0.0), ("projectile.velocity[2]", 0.0),
        ("sheet.node_mass", f64::MAX), ("sheet.plies", 3.0)], StepLimitUnusable, "time_step.seconds"),
    // The surface of a sphere that spins counts where it rubs.
    ("sphere", &[("contact.friction", 0.1), ("projectile.angular_velocity[2]", 1e9)],
        ProjectileTooFast, "projectile.velocity"),
    // The discs keep clear of what a box covers as it lies, corners included: 35 mm from the centre they
    // leave 25 or 21 mm.
    ("box", &[("sheet.nodes_x", 105.0), ("sheet.nodes_y", 105.0), ("attachment.kind", 2.0),
        ("attachment.disc_inset", 13e-3), ("attachment.disc_radius", 14e-3), ("projectile.size[0]", 0.03),
        ("projectile.size[1]", 0.03)], DiscTouchesProjectile, "attachment.disc_radius"),
    // What a mirror plane would change.
    ("mirrored", &[("projectile.position[0]", 1e-6)], NotSymmetric, "projectile.position"),
    ("mirrored", &[("projectile.velocity[0]", 1e-3)], NotSymmetric, "projectile.velocity"),
    ("mirrored", &[("projectile.angular_velocity[1]", 1.0)], NotSymmetric, "projectile.angular_velocity"),
    ("mirrored", &[("projectile.angular_velocity[2]", 1.0)], NotSymmetric, "projectile.angular_velocity"),
    ("mirrored", &[("projectile.shape", 1.0), ("projectile.length", 0.0127), ("projectile.orientation[0]", 0.6),
        ("projectile.orientation[2]", 0.8), ("projectile.position[2]", -0.02)], NotSymmetric, "projectile.orientation"),
    ("mirrored", &[("projectile.shape", 5.0), ("projectile.position[2]", -0.1)], NotSymmetric, "projectile.shape"),
    ("mirrored", &[("sheet.grading.largest", 4.0), ("sheet.grading.centre[0]", 1e-4)],
        NotSymmetric, "sheet.grading.centre"),
];

#[test]
fn every_row_is_refused_by_its_code_and_field() {
    for (base, changes, code, field) in REFUSED {
        println!("{base} {changes:?}");
        refused(&changed(base, changes), *code, field);
    }
}

/// Near to the rows above and sound: taken, and run.
#[rustfmt::skip]
const TAKEN: &[(&str, &Changes)] = &[
    ("bullet", &[]), ("box", &[]), ("cube", &[]), ("sector", &[]), ("hybrid", &[]), ("mirrored", &[]),
    ("unchecked", &[("time_step.fraction", 100.0), ("projectile.position[2]", -1.0)]),
    ("fraction", &[("drive", 1.0), ("projectile.mass", 0.0), ("projectile.velocity[2]", 0.0),
        ("sheet.node_mass", 1e89), ("projectile.position[2]", -1.0)]),
    // A sphere feels no torque: its spin is free.
    ("sphere", &[("projectile.angular_velocity[0]", 1e9)]),
    // A modulus that does not scatter, or only from yarn to yarn, pulls evenly.
    ("sphere", &[("sheet.pre_strain[0]", 0.01), ("yarn.modulus_sd", 0.0)]),
    ("sphere", &[("sheet.pre_strain[0]", 0.01), ("yarn.draw", 1.0)]),
    // A very light sheet asks for a step of 1e-14 s: it is never given a smaller one in silence.
    ("sphere", &[("sheet.node_mass", 1e-20), ("time_step.seconds", 1e-14)]),
    ("box", &[("sheet.nodes_x", 105.0), ("sheet.nodes_y", 105.0), ("attachment.kind", 2.0),
        ("attachment.disc_inset", 13e-3), ("attachment.disc_radius", 10e-3), ("projectile.size[0]", 0.03),
        ("projectile.size[1]", 0.03)]),
    // On its edge it covers less across the corners.
    ("box", &[("sheet.nodes_x", 105.0), ("sheet.nodes_y", 105.0), ("attachment.kind", 2.0),
        ("attachment.disc_inset", 13e-3), ("attachment.disc_radius", 14e-3), ("projectile.size[0]", 0.03),
        ("projectile.size[2]", 0.03), ("projectile.position[2]", -0.02)]),
    // Moments of a body of unknown mass are not read.
    ("cube", &[("drive", 1.0), ("projectile.mass", 0.0), ("projectile.moments[0]", f64::NAN),
        ("projectile.moments[1]", f64::NAN)]),
    ("sphere", &[("projectile.faces.count", 4e9), ("projectile.faces.planes[3][1]", f64::NAN),
        ("projectile.size[1]", f64::NAN), ("projectile.moments[2]", f64::NAN)]),
];

#[test]
fn every_sound_neighbour_is_taken_and_runs() {
    for (base, changes) in TAKEN {
        println!("{base} {changes:?}");
        let scene = changed(base, changes);
        scene.check().unwrap();
        stepped(&scene, 100);
    }
    // Normals with seven digits are good enough.
    let n = (1.0f64 / 3.0).sqrt();
    let mut scene = inputs::scene("cube");
    scene.projectile.faces =
        Faces::of(&[[n, n, n, 2e-3], [n, -n, -n, 2e-3], [-n, n, -n, 2e-3], [-0.5773503, -0.5773503, 0.5773503, 2e-3]]);
    sim_of(&scene);
}

/// Every two options that do not go together: both are named, whichever of them a host thinks of first.
#[test]
fn options_that_do_not_go_together_are_both_named() {
    let value = |name: &str| match name {
        "yarn.viscosity_linear" | "yarn.viscosity_bending" | "sheet.crimp[1]" | "sheet.pre_strain[1]" => 0.02,
        "yarn.viscosity_quadratic" => 1.5,
        "yarn.rate_modulus" | "yarn.rate_stretch" | "contact.friction" => 0.1,
        "stack.plies" => 2.0,
        "sheet.spacing_y" => 8e-4,
        "sheet.grading.largest" => 4.0,
        _ => 1.0,
    };
    #[rustfmt::skip]
    let pairs: [(&str, &[&str]); 8] = [
        ("integrator.kind", &["contact.friction", "yarn.rate_modulus", "yarn.rate_stretch", "yarn.viscosity_linear",
            "yarn.viscosity_quadratic", "yarn.viscosity_bending", "slack_balance", "stack.plies"]),
        ("stack.plies", &["yarn.rate_modulus", "yarn.rate_stretch"]),
        ("yarn.rate_modulus", &["slack_balance", "sheet.pre_strain[1]"]),
        ("yarn.rate_stretch", &["slack_balance", "sheet.pre_strain[1]"]),
        ("symmetry.mirror_x", &["stack.plies", "yarn.stochastic", "drive"]),
        ("symmetry.mirror_y", &["stack.plies", "yarn.strength_draw", "drive"]),
        ("sheet.pre_strain[1]", &["sheet.crimp[1]"]),
        ("sheet.spacing_y", &["stack.turned"]),
    ];
    let mut base = changed("uniform", &[("yarn.rate_reference", 30.0), ("yarn.rate_limit", 170.0)]);
    base.time_step = TimeStep::fraction(0.4);
    for (with, field) in pairs.iter().flat_map(|(with, fields)| fields.iter().map(move |field| (*with, *field))) {
        let mut scene = base;
        if field == "stack.turned" {
            scene.stack.plies = 2;
        }
        for alone in [field, with] {
            let mut one = scene;
            assign(&mut one, alone, value(alone));
            one.check().unwrap_or_else(|error| panic!("{field}, {with}: {error}"));
        }
        assign(&mut scene, field, value(field));
        assign(&mut scene, with, value(with));
        let error = scene.check().unwrap_err();
        let [field, with] = [field, with].map(|name| name.split('[').next().unwrap());
        assert_eq!((error.code, error.field, error.with), (DoesNotGoWith, field, with));
        assert_eq!(error.text().as_str(), format!("{field}: does not go with another field: {with}"));
    }
}

/// Where a limit follows from another field, that one is named, too: a limit of 0 alone would help nobody.
#[test]
fn a_refusal_names_the_field_that_its_limit_follows_from() {
    let rate: &Changes = &[("yarn.rate_modulus", 0.1), ("yarn.rate_reference", 30.0), ("yarn.rate_limit", 1.0)];
    let equilibrium = "sheet.pre_strain: pre-tension without equilibrium: an edge that is not held, or segments sampled one by one: see attachment.kind";
    for (changes, text) in [
        (&[("back.plies", 2.0)] as &Changes, "back.plies: out of range; it is 2: see stack.plies"),
        (&[("sheet.spacing_y", 0.1)], "sheet.spacing_y: out of range; it is 1e-1 m: see sheet.spacing"),
        (&[("projectile.mass", 1e-9)], "projectile.mass: projectile lighter than a node: see sheet.node_mass"),
        (&[("yarn.damage_a", 2.0)], "yarn.damage_a: out of range; it is 2: see yarn.damage_b"),
        (rate, "yarn.rate_limit: out of range; it is 1 1/s: see yarn.rate_reference"),
        (&[("attachment.kind", 3.0), ("sheet.pre_strain[0]", 0.01)], equilibrium),
    ] {
        assert_eq!(changed("sphere", changes).check().unwrap_err().text().as_str(), text);
    }
}

/// Scenes of a billion nodes and more: what init would say of them takes it minutes, or more memory than
/// there is. What is checked in some milliseconds is what it would say, the more so where a part of the
/// segments shows it.
#[test]
fn a_check_of_any_scene_takes_milliseconds() {
    #[rustfmt::skip]
    const LARGE: &Changes = &[
        ("sheet.nodes_x", 65_000.0), ("sheet.nodes_y", 65_000.0), ("time_step.seconds", 0.0), ("yarn.weibull_shape", 2.0),
    ];
    /// A body wider than the sheet, whose lower edge comes as near as it may.
    #[rustfmt::skip]
    const OVER_ALL: &Changes = &[
        ("projectile.size[0]", 100.0), ("projectile.size[1]", 100.0), ("projectile.size[2]", 1.0),
        ("projectile.mass", 1e3), ("projectile.orientation[0]", 0.999_999_5), ("projectile.orientation[1]", 0.001),
        ("projectile.velocity[2]", 1e-3), ("projectile.position[2]", -0.601),
    ];
    let corners: &Changes = &[("attachment.kind", 2.0), ("attachment.disc_inset", 1.0), ("drive", 1.0)];
    let graded: &Changes = &[
        ("projectile.size[0]", 20.0),
        ("projectile.size[1]", 20.0),
        ("sheet.grading.largest", 2.0),
        ("sheet.grading.half_width[0]", 100.0),
        ("sheet.grading.half_width[1]", 100.0),
    ];
    let taut: &Changes = &[("sheet.pre_strain[0]", 0.02), ("yarn.draw", 1.0), ("yarn.strength_draw", 1.0)];
    type Case<'a> = (&'a str, &'a [&'a Changes], Result<(), (Code, &'static str)>);
    let cases: [Case; 10] = [
        ("sphere", &[LARGE], Ok(())),
        (
            "sphere",
            &[&[("sheet.nodes_x", 65_536.0), ("sheet.nodes_y", 65_536.0)]],
            Err((TooManyNodes, "sheet.nodes_x")),
        ),
        ("sphere", &[&[("sheet.nodes_x", 1_048_576.0), ("sheet.nodes_y", 4000.0)]], Ok(())),
        ("sphere", &[LARGE, &[("yarn.draw", 1.0)]], Ok(())),
        ("strength", &[LARGE, &[("yarn.stochastic", 1.0)]], Ok(())),
        ("sphere", &[LARGE, &[("yarn.damage_sd", 1e5)]], Ok(())), // half of the draws are refused
        ("sphere", &[LARGE, &[("time_step.seconds", 2.7e-8)]], Err((StepTooLarge, "time_step.seconds"))),
        ("sphere", &[LARGE, taut], Err((OutOfRange, "sheet.pre_strain"))),
        ("box", &[LARGE, OVER_ALL], Ok(())),
        ("box", &[LARGE, OVER_ALL, corners, graded], Ok(())),
    ];
    for (k, (base, changes, expected)) in cases.into_iter().enumerate() {
        let scene = changed(base, &changes.concat());
        let start = std::time::Instant::now();
        let found = scene.check_start();
        let took = start.elapsed();
        println!("case {k}: {:.2} ms, {found:?}", 1e3 * took.as_secs_f64());
        assert_eq!(found.map_err(|error| (error.code, error.field)), expected, "case {k}");
        // On a busy machine, too: a thousandth of what the draws take.
        assert!(took.as_secs_f64() < 0.5, "case {k}: {took:?}");
        // Too little memory is told before anything is computed, too.
        let error = Sim::new(&scene, &mut []).err().expect("refused").code;
        assert_eq!(error, if Layout::of(&scene).is_ok() { ShortBuffer } else { TooManyNodes }, "case {k}");
    }
}

/// A part of the segments tells a step that is too large or too small, never one that may be right.
#[test]
fn a_check_of_many_segments_refuses_nothing_that_init_takes() {
    let mut scene = small_sheet(201, 50.0);
    (scene.yarn.stochastic, scene.yarn.modulus_sd) = (true, 4e10);
    let limits = scene.step_limits().unwrap();
    let (fastest, memory) = (0.0254 / 35.0 / limits.dt, memory_of(&scene));
    for (velocity, taken) in [(0.999, true), (1.001, false)] {
        scene.projectile.velocity[2] = velocity * fastest;
        assert_eq!(Sim::new(&scene, &mut memory.clone()).is_ok(), taken);
        assert!(scene.check_start().is_ok() || !taken);
    }
    scene.projectile.velocity[2] = 2.0 * fastest;
    assert!(scene.check_start().is_err_and(|error| error.code == ProjectileTooFast));
    scene.projectile.velocity[2] = 50.0;
    for (fraction, refused) in [(0.999, false), (1.3, true)] {
        scene.time_step = TimeStep::seconds(fraction * limits.step_max);
        assert_eq!(scene.check_start().is_err_and(|error| error.code == StepTooLarge), refused);
    }
}

fn base() -> Scene {
    drawn(small_sheet(9, 50.0))
}

#[test]
fn a_turning_cylinder_counts_its_reach_and_its_turn() {
    let mut scene = tilted_cylinder(9, 0.0, 50.0);
    let fastest = 0.0254 / 35.0 / scene.step_limits().unwrap().dt;
    let reach = (6.35e-3f64).hypot(0.01905);
    scene.projectile.angular_velocity = [1.001 * (fastest - 50.0) / reach, 0.0, 0.0];
    refused(&scene, ProjectileTooFast, "projectile.velocity");
    scene.projectile.angular_velocity[0] *= 0.998;
    sim_of(&scene);
}

/// Discs of 0.4 mm centred in a mesh of 0.73 mm hold no node: without the refusal that is a free sheet. The
/// error names the radius that reaches a node, whole or with mirror planes, in Rust and so in C and FMI; with
/// a little more each disc holds its node.
#[test]
fn corner_discs_that_hold_no_node_are_refused() {
    for (mirror_x, mirror_y) in [(false, false), (true, false), (false, true), (true, true)] {
        let mut scene = small_sheet(41, 50.0);
        scene.sheet.nodes_y = 40;
        scene.symmetry = fabric_kernel::Symmetry { mirror_x, mirror_y };
        scene.attachment.kind = AttachmentKind::FourCorners;
        (scene.attachment.disc_inset, scene.attachment.disc_radius) = (1.5 * scene.sheet.spacing, 0.4e-3);
        let error = refused(&scene, HoldsNothing, "attachment.disc_radius");
        fabric_tests::close(error.limit, 0.5f64.sqrt() * scene.sheet.spacing, 1e-12);
        scene.attachment.disc_radius = 1.001 * error.limit;
        let impulses = stepped(&scene, 1500).support().unwrap().attachments;
        assert!(impulses.iter().all(|impulse| impulse[2] > 0.0), "{mirror_x} {mirror_y} {impulses:?}");
    }
}

/// Soft yarn allows a step in which a usual speed crosses more than a spacing: the error says which step is
/// small enough for it, and that step is accepted as it stands; a turning body and a path likewise.
#[test]
fn a_projectile_too_fast_for_the_step_is_told_the_largest_step() {
    let mut soft = base();
    soft.yarn = fabric_kernel::Yarn {
        stochastic: false,
        modulus_mean: 5e6,
        damage_slope: 0.0,
        damage_intercept: 230.0,
        ..soft.yarn
    };
    soft.projectile.velocity[2] = 300.0;
    let mut turning = tilted_cylinder(9, 0.0, 50.0);
    turning.projectile.angular_velocity = [3e6, 0.0, 0.0];
    let mut whirling = turning;
    // So large a spacing that half a radian, and not the spacing, is what the spin may not exceed.
    (whirling.sheet.spacing, whirling.projectile.radius, whirling.projectile.length) = (6.3e-3, 6.35e-3, 0.0127);
    whirling.projectile.angular_velocity = [1.2e7, 0.0, 0.0];
    for (name, mut scene) in [("soft", soft), ("turning", turning), ("whirling", whirling)] {
        scene.projectile.position[2] = -0.05;
        let error = refused(&scene, ProjectileTooFast, "projectile.velocity");
        // The step in the text has five digits, rounded down: it is accepted as it stands.
        let said = error.text();
        let (_, step) = said.split_once("; the largest step for this motion is ").expect("a step");
        let step: f64 = step.trim_end_matches(" s").parse().expect("a number");
        assert!(step <= error.limit && step > 0.9998 * error.limit, "{name}: {said}");
        scene.time_step = TimeStep::seconds(error.limit);
        sim_of(&scene);
        // A larger one is not.
        scene.time_step = TimeStep::seconds(error.limit * (1.0 + 1e-12));
        refused(&scene, ProjectileTooFast, "projectile.velocity");
    }
}

#[test]
fn a_step_refusal_names_the_largest_step_and_taking_that_step_works() {
    let mut scene = base();
    scene.time_step = TimeStep::seconds(5e-8);
    let error = refused(&scene, StepTooLarge, "time_step.seconds");
    assert!(error.text().contains("the largest allowed is 2"));
    scene.time_step = TimeStep::seconds(error.limit);
    sim_of(&scene);
    scene.time_step = TimeStep::seconds(error.limit.next_up());
    refused(&scene, StepTooLarge, "time_step.seconds");
    scene.step_check = StepCheck::None;
    sim_of(&scene);
}

// ---- Calls on a living simulation -------------------------------------------------------------------------

/// Asserts that a call is refused and leaves the simulation's bits alone.
#[track_caller]
fn call_refused(
    sim: &mut Sim<'_>,
    code: Code,
    field: &str,
    call: impl FnOnce(&mut Sim<'_>) -> Result<(), Error>,
) -> Error {
    let before = sim.digest();
    let error = call(sim).expect_err("refused");
    assert_eq!((error.code, error.field), (code, field), "{error}");
    assert_eq!(sim.digest(), before, "a refused call changed the state");
    assert!(sim.failure().is_none());
    error
}

/// A list with one number replaced.
fn with(values: &[f64], at: usize, value: f64) -> Vec<f64> {
    let mut changed = values.to_vec();
    changed[at] = value;
    changed
}

#[test]
fn external_loads_are_checked() {
    let mut sim = sim_of(&base());
    for bad in [f64::NAN, f64::INFINITY] {
        call_refused(&mut sim, NotFinite, "external.force", |s| s.set_external_load([0.0, bad, 0.0], [0.0; 3]));
        call_refused(&mut sim, NotFinite, "external.torque", |s| s.set_external_load([0.0; 3], [bad, 0.0, 0.0]));
    }
    let mut sim = sim_of(&Scene { drive: Drive::Prescribed, ..base() });
    call_refused(&mut sim, WrongDrive, "drive", |s| s.set_external_load([0.0; 3], [0.0; 3]));
    let mut sim = sim_of(&inputs::scene("mirrored"));
    sim.set_external_load([0.0, 0.0, 3.0], [0.0; 3]).unwrap();
    call_refused(&mut sim, NotSymmetric, "external.force", |s| s.set_external_load([1.0, 0.0, 0.0], [0.0; 3]));
    // Beyond all numbers in the sheet's axes.
    let mut scene = base();
    (scene.sheet.orientation, scene.projectile.orientation) = ([0.8, 0.6, 0.0, 0.0], [0.8, 0.6, 0.0, 0.0]);
    scene.projectile.position = [0.0, 1.0, 1.0];
    let (mut sim, most) = (sim_of(&scene), [f64::MAX; 3]);
    call_refused(&mut sim, NotFinite, "external.force", |s| s.set_external_load(most, [0.0; 3]));
    call_refused(&mut sim, NotFinite, "external.torque", |s| s.set_external_load([0.0; 3], most));
}

#[test]
fn motions_set_by_hand_are_checked() {
    let scene = base();
    let mut sim = sim_of(&scene);
    let nodes = sim.layout().nodes();
    let (x, v) = (positions(&sim).as_flattened().to_vec(), vec![0.0; 3 * nodes]);
    call_refused(&mut sim, WrongLength, "positions", |s| s.set_motion(&x[1..], &v));
    call_refused(&mut sim, WrongLength, "velocities", |s| s.set_motion(&x, &[]));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for at in [0, 3 * nodes / 2, 3 * nodes - 1] {
            call_refused(&mut sim, NotFinite, "positions", |s| s.set_motion(&with(&x, at, bad), &v));
            call_refused(&mut sim, NotFinite, "velocities", |s| s.set_motion(&x, &with(&v, at, bad)));
        }
    }
    // Node 0 is fixed; node 40 is the middle of 9 x 9, and 3 mm below the plane it is inside the sphere,
    // whose centre is its radius and 1 nm before the plane. Of two plies 0.1 mm apart the first is 0.15 mm
    // down. What is told is the number in SI units.
    let mut pair = sim_of(&changed("stack", &[("stack.plies", 2.0)]));
    let both = positions(&pair).as_flattened().to_vec();
    let deep = scene.projectile.position[2].abs() - 3e-3 - scene.projectile.radius;
    for (two, code, field, x, v, value) in [
        (false, OutOfRange, "velocities", &x, &with(&v, 1, 1e-9), 1e-9),
        (false, OutOfRange, "positions", &with(&x, 3 * 40, 1e40), &v, 1e40),
        (false, InitialOverlap, "positions", &with(&x, 3 * 40 + 2, -3e-3), &v, deep),
        (true, PliesOverlap, "positions", &with(&both, 3 * 40 + 2, 1.5e-4), &vec![0.0; 6 * nodes], -5e-5),
    ] {
        let sim = if two { &mut pair } else { &mut sim };
        let error = call_refused(sim, code, field, |s| s.set_motion(x, v));
        assert!((error.value / value - 1.0).abs() < 1e-9, "{error:?}");
    }
    sim.step().unwrap();
    call_refused(&mut sim, AlreadyStarted, "", |s| s.set_motion(&x, &v));
}

#[test]
fn largest_stretches_are_checked() {
    let mut sim = sim_of(&base());
    let ones = vec![1.0; sim.layout().segments()];
    let last = |value: f64| with(&ones, ones.len() - 1, value);
    call_refused(&mut sim, WrongLength, "stretches", |s| s.set_largest_stretch(&[1.0]));
    for (value, code) in [(f64::NAN, NotFinite), (f64::INFINITY, NotFinite), (-0.1, OutOfRange), (1e101, OutOfRange)] {
        call_refused(&mut sim, code, "stretches", |s| s.set_largest_stretch(&last(value)));
    }
    sim.step().unwrap();
    call_refused(&mut sim, AlreadyStarted, "", |s| s.set_largest_stretch(&ones));
}

#[test]
fn paths_are_checked() {
    let mut scene = base();
    let end = Motion { position: scene.projectile.position, ..AT_REST };
    let good = Path { first: 0, steps: 1000, end };
    call_refused(&mut sim_of(&scene), WrongDrive, "drive", |s| s.follow(&good, 1));

    (scene.drive, scene.projectile.mass) = (Drive::Prescribed, 0.0);
    let mut sim = sim_of(&scene);
    for (first, steps, asked, field) in [
        (0, 0, 0, "path.steps"),
        (1, 1000, 1, "path.first"),
        (0, 1000, 1001, "steps"),
        (u64::MAX, u64::MAX, 1, "path.steps"),
        (0, (1 << 53) + 1, 1, "path.steps"),
    ] {
        call_refused(&mut sim, BadPath, field, |s| s.follow(&Path { first, steps, end }, asked));
    }
    let mut ends = vec![
        (BadQuaternion, "path.orientation", Motion { orientation: [0.0; 4], ..end }),
        // 1 m in 1000 steps is 5e4 m/s.
        (ProjectileTooFast, "path.velocity", Motion { position: [0.0, 0.0, 1.0], ..end }),
        (ProjectileTooFast, "path.velocity", Motion { velocity: [0.0, 0.0, 1e6], ..end }),
    ];
    for bad in [f64::NAN, f64::INFINITY] {
        ends.extend([
            (NotFinite, "path.position", Motion { position: [bad, 0.0, 0.0], ..end }),
            (NotFinite, "path.velocity", Motion { velocity: [0.0, bad, 0.0], ..end }),
            (NotFinite, "path.orientation", Motion { orientation: [1.0, 0.0, bad, 0.0], ..end }),
            (NotFinite, "path.angular_velocity", Motion { angular_velocity: [0.0, 0.0, bad], ..end }),
        ]);
    }
    for (code, field, end) in ends {
        call_refused(&mut sim, code, field, |s| s.follow(&Path { end, ..good }, 1));
    }
    // A path that is over cannot be followed again, and one that has begun cannot be entered late.
    sim.follow(&good, 1000).unwrap();
    call_refused(&mut sim, BadPath, "path.first", |s| s.follow(&good, 1));
}

#[test]
fn read_outs_of_the_wrong_length_are_refused_and_nothing_is_written() {
    let sim = sim_of(&base());
    let (nodes, segments) = (3 * sim.layout().nodes(), sim.layout().segments());
    type ReadOut = fn(&Sim<'_>, &mut [f64]) -> Result<(), Error>;
    let read_outs: [(usize, ReadOut); 4] = [
        (nodes, |s, out| s.copy_positions(out)),
        (nodes, |s, out| s.copy_velocities(out)),
        (segments, |s, out| s.copy_damage(out)),
        (segments, |s, out| s.copy_stretch(out)),
    ];
    for (right, read_out) in read_outs {
        for wrong in [right - 1, right + 1] {
            let mut out = vec![7.5; wrong];
            let error = Error::new(WrongLength, "out", wrong as f64, right as f64);
            assert_eq!(read_out(&sim, &mut out), Err(error));
            assert!(out.iter().all(|&x| x == 7.5));
        }
    }
}
