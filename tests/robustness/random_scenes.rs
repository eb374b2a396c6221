//! Scenes made of arbitrary numbers: refused without a write, or run without a panic and without silence about a lost state.

use fabric::{
    AttachmentKind, CacheLine, Code, Drive, Faces, Layout, Motion, Path, Scene, Shape, Sim, Stack, StepCheck,
    StrengthDraw, TimeStep, Weft,
};
use fabric_tests::small_sheet;
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestCaseError, TestRunner};
use std::cell::Cell;

/// Mostly a usual value changed a little, sometimes any f64 at all. Boxed, as all of a scene's values together would not fit a thread's stack.
fn near(value: f64) -> BoxedStrategy<f64> {
    prop_oneof![
        60 => (0.9..1.1).prop_map(move |factor: f64| value * factor),
        6 => (0.5..2.0).prop_map(move |factor: f64| value * factor),
        1 => Just(value),
        1 => any::<f64>(),
        1 => prop::sample::select(vec![0.0, -value, f64::MIN_POSITIVE, 1e-310, 1e300, f64::MAX, 1e-12, 1e12]),
    ]
    .boxed()
}

fn component() -> BoxedStrategy<f64> {
    prop_oneof![8 => Just(0.0), 4 => -300.0..300.0, 1 => any::<f64>()].boxed()
}

/// Viscosity, dependence on the rate, friction on the projectile, and separate plies: mostly none.
fn resistance() -> impl Strategy<Value = ([f64; 3], [f64; 4], f64, Stack)> {
    let of_yarn = prop_oneof![
        6 => Just(([0.0; 3], [0.0; 4])),
        2 => [near(0.06), near(1.5), near(0.06)].prop_map(|viscosity| (viscosity, [0.0; 4])),
        2 => [near(0.1), near(0.1), near(30.0), near(1000.0)].prop_map(|rate| ([0.0; 3], rate)),
        1 => [near(0.1), near(30.0), near(1000.0), near(0.06)].prop_map(|[a, b, c, d]| ([d, 0.0, d], [a, a, b, c])),
    ];
    let friction = prop_oneof![2 => Just(0.0), 1 => near(0.3)];
    let plies = prop_oneof![6 => Just(1u32), 3 => 2u32..5, 1 => any::<u32>()];
    let stack = (plies, near(1e-4), any::<bool>()).prop_map(|(plies, gap, turned)| Stack { plies, gap, turned });
    (of_yarn, friction, stack)
        .prop_map(|((viscosity, rate), friction, stack)| (viscosity, rate, friction, stack))
        .boxed()
}

/// Spacing and section along y, crimp, pre-tension and a law of the weft's own.
fn weft() -> impl Strategy<Value = (f64, f64, [f64; 2], [f64; 2], Weft)> {
    let some = |value: f64| prop_oneof![2 => Just(0.0), 1 => near(value)];
    let law = (some(120e9), near(2e9), near(1e-9), near(150.0), near(5.0), some(1.03)).prop_map(
        |(modulus_mean, modulus_sd, damage_slope, damage_intercept, damage_sd, critical_stretch)| Weft {
            modulus_mean,
            modulus_sd,
            damage_slope,
            damage_intercept,
            damage_sd,
            critical_stretch,
        },
    );
    (some(9e-4), some(8e-8), [some(0.01), some(0.01)], [some(0.004), some(0.004)], law)
}

prop_compose! {
    fn scenes()(
        nodes in (prop_oneof![9 => 3u32..13, 1 => 0u32..3], prop_oneof![9 => 3u32..13, 1 => 0u32..3]),
        plies in prop_oneof![20 => Just(1u32), 1 => any::<u32>()],
        sheet in (near(7.26e-4), near(6.52e-8), near(1.075e-7)),
        yarn in (near(140e9), near(2e9), near(7.91e-9), near(-878.0), near(8.35)),
        law in (near(0.03).prop_map(|strain| 1.0 + strain), near(0.9), near(0.0), near(0.01)),
        body in (near(6.35e-3), near(0.0381), near(8.4e-3), near(-7e-3)),
        velocity in (component(), component(), near(100.0)),
        rates in [component(), component(), component()],
        kind in 0..4usize,
        shape in prop::sample::select(vec![
            Shape::Sphere,
            Shape::Cylinder,
            Shape::HemisphericalCylinder,
            Shape::Box,
            Shape::Polyhedron,
        ]),
        size in [near(0.01), near(0.01), near(0.01)],
        cut in (near(0.6), near(0.8), near(6e-3), 0u32..18),
        moments in [near(1e-7), near(1e-7), near(1.5e-7)],
        choices in (any::<bool>(), any::<bool>(), any::<bool>(), any::<bool>()),
        discs in (near(1e-3), near(8e-4)),
        capacity in prop_oneof![3 => Just(0u32), 1 => 0u32..20],
        seed in any::<u64>(),
        fraction in near(0.4),
        toe in prop_oneof![3 => Just(0.0), 1 => near(0.02)],
        strength in (0..3usize, near(10.0), near(0.05), near(0.5)),
        resistance in resistance(),
        weft in prop_oneof![2 => Just(None), 1 => weft().prop_map(Some)],
    ) -> Scene {
        let mut scene = small_sheet(5, 0.0);
        (scene.sheet.nodes_x, scene.sheet.nodes_y, scene.sheet.plies) = (nodes.0, nodes.1, plies);
        (scene.sheet.spacing, scene.sheet.node_mass, scene.sheet.yarn_area) = sheet;
        let y = &mut scene.yarn;
        (y.modulus_mean, y.modulus_sd, y.damage_slope, y.damage_intercept, y.damage_sd) = yarn;
        (y.critical_stretch, y.damage_a, y.damage_b, y.alpha_fail) = law;
        y.stochastic = choices.0;
        y.strength_draw = [StrengthDraw::None, StrengthDraw::None, StrengthDraw::Weibull][strength.0];
        (y.weibull_shape, y.weibull_gauge_length, y.weibull_correlation) = (strength.1, strength.2, strength.3);
        let p = &mut scene.projectile;
        (p.radius, p.length, p.mass, p.position[2]) = body;
        (p.velocity, p.angular_velocity) = (velocity.into(), rates);
        (p.shape, p.size, p.moments) = (shape, size, moments);
        // A box with an edge cut off, and now and then another count of faces.
        let [a, b, c] = size.map(|edge| 0.5 * edge);
        p.faces = Faces::of(&[
            [1.0, 0.0, 0.0, a],
            [-1.0, 0.0, 0.0, a],
            [0.0, 1.0, 0.0, b],
            [0.0, -1.0, 0.0, b],
            [0.0, 0.0, 1.0, c],
            [0.0, 0.0, -1.0, c],
            [cut.0, cut.1, 0.0, cut.2],
        ]);
        p.faces.count = if cut.3 < 14 { 6 + cut.3 % 2 } else { cut.3 };
        scene.drive = if choices.1 { Drive::Prescribed } else { Drive::Free };
        (scene.track_detachment, scene.track_support) = (choices.2, choices.3);
        let kinds =
            [AttachmentKind::TwoSides, AttachmentKind::FourSides, AttachmentKind::FourCorners, AttachmentKind::Free];
        scene.attachment.kind = kinds[kind];
        (scene.attachment.disc_inset, scene.attachment.disc_radius) = discs;
        (scene.contact_capacity, scene.seed) = (capacity, seed);
        scene.time_step = TimeStep::fraction(fraction);
        scene.slack_toe = toe;
        let yarn = &mut scene.yarn;
        [yarn.viscosity_linear, yarn.viscosity_quadratic, yarn.viscosity_bending] = resistance.0;
        [yarn.rate_modulus, yarn.rate_stretch, yarn.rate_reference, yarn.rate_limit] = resistance.1;
        (scene.contact.friction, scene.stack) = (resistance.2, resistance.3);
        (scene.back.plies, scene.back.node_mass) = (scene.stack.plies / 3, 0.7 * scene.sheet.node_mass);
        if let Some((spacing_y, yarn_area_y, crimp, pre_strain, weft)) = weft {
            (scene.sheet.spacing_y, scene.sheet.yarn_area_y) = (spacing_y, yarn_area_y);
            (scene.sheet.crimp, scene.sheet.pre_strain, scene.weft) = (crimp, pre_strain, weft);
        }
        if fraction > 0.7 {
            scene.step_check = StepCheck::None;
        }
        scene
    }
}

/// The same cases every time.
fn config() -> ProptestConfig {
    ProptestConfig { cases: 4000, failure_persistence: None, rng_seed: RngSeed::Fixed(1), ..ProptestConfig::default() }
}

/// Steps a scene, if it is accepted. Whether it was.
fn refused_or_run(scene: &Scene) -> Result<bool, TestCaseError> {
    let mut memory = vec![CacheLine([7.5; 8]); 5600];
    let checked = scene.check_start();
    let mut sim = match Sim::new(scene, &mut memory) {
        Ok(sim) => {
            prop_assert_eq!(checked, Ok(()));
            sim
        }
        Err(error) => {
            prop_assert!(!error.text().is_empty());
            // What is wrong may be no number, which equals nothing.
            let same = checked.is_err_and(|checked| (checked.code, checked.field) == (error.code, error.field));
            prop_assert!(error.code == Code::ShortBuffer || same);
            prop_assert!(memory.iter().all(|&line| line == CacheLine([7.5; 8])));
            return Ok(false);
        }
    };
    prop_assert!(Layout::of(scene).is_ok());
    let outcome = sim.advance(200);
    prop_assert_eq!(outcome.err(), sim.failure());
    if sim.failure().is_none() {
        let motion = sim.projectile().unwrap();
        prop_assert!(motion.position.iter().chain(&motion.velocity).all(|x| x.is_finite()));
        let mut x = vec![0.0; 3 * sim.layout().nodes()];
        sim.copy_positions(&mut x).unwrap();
        prop_assert!(x.iter().all(|x| x.is_finite()));
        sim.copy_velocities(&mut x).unwrap();
        sim.energy().unwrap();
        let mut image = vec![0; sim.snapshot_bytes()];
        sim.save(&mut image).unwrap();
        let digest = sim.digest();
        prop_assert!(sim.load(&image).is_ok(), "an image of a sound simulation loads");
        prop_assert_eq!(sim.digest(), digest);
    }
    Ok(true)
}

/// Whether a scene is of a kind.
type Is = fn(&Scene) -> bool;

/// A test that nearly all scenes do not get to would say nothing: of each kind some must run.
#[test]
fn any_scene_is_refused_or_runs() {
    let kinds: [(&str, Is, u32); 6] = [
        ("scenes", |_| true, 150),
        ("with separate plies", |scene| scene.stack.plies > 1, 25),
        ("with friction", |scene| scene.contact.friction > 0.0, 40),
        ("with viscosity", |scene| scene.yarn.viscosity_linear > 0.0, 40),
        ("with a dependence on the rate", |scene| scene.yarn.rate_modulus > 0.0, 30),
        ("with unlike directions", |scene| scene.weft.modulus_mean > 0.0, 8),
    ];
    let counts: [Cell<u32>; 6] = Default::default();
    let run = TestRunner::new(config()).run(&scenes(), |scene| {
        if refused_or_run(&scene)? {
            let found = kinds.iter().zip(&counts).filter(|((_, is, _), _)| is(&scene));
            found.for_each(|(_, count)| count.set(count.get() + 1));
        }
        Ok(())
    });
    run.unwrap_or_else(|error| panic!("{error}"));
    for ((kind, _, least), count) in kinds.iter().zip(&counts) {
        println!("{} {kind} ran", count.get());
        assert!(count.get() >= *least, "{} {kind} ran", count.get());
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn any_bytes_are_refused_as_an_image(bytes in prop::collection::vec(any::<u8>(), 0..3000)) {
        let scene = small_sheet(5, 50.0);
        let mut memory = fabric_tests::Buffers::of(&scene);
        let mut sim = memory.sim(&scene);
        let before = sim.digest();
        prop_assert!(sim.load(&bytes).is_err());
        prop_assert_eq!(sim.digest(), before);
    }

    #[test]
    fn any_path_is_refused_or_followed(
        first in prop_oneof![Just(0u64), any::<u64>()],
        steps in prop_oneof![1u64..300, any::<u64>()],
        asked in 0u64..300,
        position in [component(), component(), component()],
        velocity in [component(), component(), component()],
        orientation in (near(1.0), component(), component(), component()),
        rate in [component(), component(), component()],
    ) {
        let mut scene = fabric_tests::tilted_cylinder(9, 0.2, 40.0);
        scene.drive = Drive::Prescribed;
        let mut memory = fabric_tests::Buffers::of(&scene);
        let mut sim = memory.sim(&scene);
        let before = sim.digest();
        // Paths of some nanometres: such as the step limit lets through.
        let position = position.map(|x| x * 1e-9);
        let place = [position[0], position[1], scene.projectile.position[2] + position[2]];
        let end = Motion { position: place, velocity, orientation: orientation.into(), angular_velocity: rate };
        if sim.follow(&Path { first, steps, end }, asked).is_err() && sim.failure().is_none() {
            prop_assert_eq!(sim.digest(), before);
        }
    }
}
