//! Golden tests: the bits of a few runs, pinned. They say that something changed, never that it is wrong or
//! right; the physics tests do that. The scenes use literal numbers only, so that no function of the host has
//! a part in them.

use fabric_kernel::{Code, Scene, Sim};
use fabric_tests::golden::{self as scenes, SCENES};
use fabric_tests::sim_of;
use rayon::prelude::*;

/// Runs a scene and says what is unlike the pin: its digest, or whether segments have failed. A scene that
/// this build was made without is left out.
fn unlike(name: &str, scene: &Scene, failures: bool, run: impl FnOnce(&mut Sim<'_>)) -> Option<String> {
    if let Some(error) = scene.check().err().filter(|error| error.code == Code::NotBuilt) {
        println!("left out: {}", error.text());
        assert_ne!(std::env::var("FABRIC_RUNS").as_deref(), Ok(name), "this build was made for it");
        return None;
    }
    let mut sim = sim_of(scene);
    run(&mut sim);
    let (digest, pin, failed) = (sim.digest(), scenes::pin(name), sim.counters().failed_segments);
    let said = format!("{name}: {failed} segments failed, digest {digest:#018x}, pinned {pin:#018x}");
    (digest != pin || (failed > 0) != failures).then_some(said)
}

#[test]
fn every_scene_gives_its_pinned_bits() {
    let run = |&(name, scene, steps, failures): &scenes::Row| {
        unlike(name, &scene(), failures, |sim| sim.advance(steps).expect("no failure"))
    };
    let wrong: Vec<String> = SCENES.par_iter().filter_map(run).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn loaded_sphere_on_a_prepared_sheet() {
    let run = |sim: &mut Sim<'_>| {
        scenes::prepare_and_load(sim);
        sim.advance(1500).expect("no failure");
    };
    assert_eq!(unlike("loaded_sphere_on_a_prepared_sheet", &scenes::uniform_sphere(), true, run), None);
}

#[test]
fn prescribed_cylinder_on_two_paths() {
    let run = |sim: &mut Sim<'_>| {
        scenes::two_paths().iter().for_each(|path| sim.follow(path, path.steps).expect("followed"));
    };
    assert_eq!(unlike("prescribed_cylinder_on_two_paths", &scenes::prescribed_cylinder(), true, run), None);
}
