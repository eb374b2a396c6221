//! Scenes made of arbitrary numbers: refused without a write, or run without a panic and without silence about a lost state.

use fabric::fields::FIELDS;
use fabric::{CacheLine, Code, Drive, Layout, Motion, Path, Scene, Sim};
use fabric_tests::options::{self, Mix};
use fabric_tests::{image_of, sim_of};
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestCaseError, TestRunner};
use std::cell::RefCell;
use std::collections::BTreeMap;

fn component() -> BoxedStrategy<f64> {
    prop_oneof![8 => Just(0.0), 4 => -300.0..300.0, 1 => any::<f64>()].boxed()
}

/// Mostly a usual value changed a little, sometimes any f64 at all.
fn near() -> BoxedStrategy<(f64, Option<f64>)> {
    let special = vec![0.0, -1.0, 1.0, 2.0, f64::MIN_POSITIVE, 1e-310, 1e300, f64::MAX, 1e-12, 1e12];
    prop_oneof![
        60 => (0.9..1.1).prop_map(|factor: f64| (factor, None)),
        6 => (0.5..2.0).prop_map(|factor: f64| (factor, None)),
        1 => any::<f64>().prop_map(|other| (1.0, Some(other))),
        1 => prop::sample::select(special).prop_map(|other| (1.0, Some(other))),
    ]
    .boxed()
}

/// A scene of many options on another sheet, and some of its numbers changed.
fn scenes() -> impl Strategy<Value = (Mix, Scene)> {
    let mix = prop::sample::select(options::mixes().0);
    let sides = || prop_oneof![9 => 3u32..13, 1 => 0u32..3];
    let changes = prop::collection::vec((0..FIELDS.len(), any::<usize>(), near()), 0..40);
    (mix, sides(), sides(), any::<u64>(), changes).prop_map(|(mix, nodes_x, nodes_y, seed, changes)| {
        let mut scene = mix.scene();
        (scene.sheet.nodes_x, scene.sheet.nodes_y, scene.seed) = (nodes_x, nodes_y, seed);
        for (field, element, (factor, other)) in changes {
            let (field, element) = (&FIELDS[field], element % FIELDS[field].size());
            let value = other.unwrap_or(factor * field.value_of(field.word(&mut scene, element)));
            // A choice that there is not is refused at once.
            let _ = field.set_word(&mut scene, element, field.word_of(value));
        }
        (mix, scene)
    })
}

/// The same cases every time.
fn config() -> ProptestConfig {
    ProptestConfig { cases: 4000, failure_persistence: None, rng_seed: RngSeed::Fixed(1), ..ProptestConfig::default() }
}

/// Starts and steps a scene, if it is accepted. Whether it was.
fn refused_or_run(mix: &Mix, scene: &Scene) -> Result<bool, TestCaseError> {
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
    // What is refused here changes nothing.
    let _ = mix.start(&mut sim);
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
        let image = image_of(&sim);
        let digest = sim.digest();
        prop_assert!(sim.load(&image).is_ok(), "an image of a sound simulation loads");
        prop_assert_eq!(sim.digest(), digest);
    }
    Ok(true)
}

/// A test that nearly all scenes do not get to would say nothing: with each option some must run.
#[test]
fn any_scene_is_refused_or_runs() {
    let ran = RefCell::new(BTreeMap::<_, u32>::new());
    let run = TestRunner::new(config()).run(&scenes(), |(mix, scene)| {
        if refused_or_run(&mix, &scene)? {
            mix.names().into_iter().chain(["scenes"]).for_each(|name| *ran.borrow_mut().entry(name).or_default() += 1);
        }
        Ok(())
    });
    run.unwrap_or_else(|error| panic!("{error}"));
    println!("ran: {:?}", ran.borrow());
    for choice in options::GROUPS.iter().copied().flatten() {
        assert!(ran.borrow().get(choice.name).is_some_and(|&count| count >= 20), "{}", choice.name);
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn any_path_is_refused_or_followed(
        first in prop_oneof![Just(0u64), any::<u64>()],
        steps in prop_oneof![1u64..300, any::<u64>()],
        asked in 0u64..300,
        position in [component(), component(), component()],
        velocity in [component(), component(), component()],
        orientation in (0.5..1.5f64, component(), component(), component()),
        rate in [component(), component(), component()],
    ) {
        let mut scene = fabric_tests::tilted_cylinder(9, 0.2, 40.0);
        scene.drive = Drive::Prescribed;
        let mut sim = sim_of(&scene);
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
