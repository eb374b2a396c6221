//! Golden tests: the bits of a few runs, pinned. They say that something changed, never that it is wrong or right; the physics
//! tests do that. The scenes use literal numbers only, so that no function of the host has a part in them.

mod pins;
mod scenes;

use fabric::{Code, Scene, Sim};
use fabric_tests::Buffers;

/// Runs a scene and compares its digest with the pin. A scene that this build was made without is left out.
#[track_caller]
fn pinned(scene: &Scene, pin: u64, run: impl FnOnce(&mut Sim<'_>)) {
    if let Err(error) = scene.check()
        && error.code == Code::NotBuilt
    {
        return println!("left out: {}", error.text());
    }
    let mut memory = Buffers::of(scene);
    let mut sim = memory.sim(scene);
    run(&mut sim);
    let digest = sim.digest();
    assert_eq!(digest, pin, "digest {digest:#018x}, pinned {pin:#018x}");
}

/// The same with so many plain steps; `failures` says whether segments are to have failed by then.
#[track_caller]
fn stepped(scene: &Scene, steps: u64, failures: bool, pin: u64) {
    pinned(scene, pin, |sim| {
        sim.advance(steps).expect("no failure");
        assert_eq!(sim.counters().failed_segments > 0, failures);
    });
}

#[test]
fn sheet_3in_sphere() {
    stepped(&Scene::sheet_3in_sphere(), 4500, true, pins::SHEET_3IN_SPHERE);
}

#[test]
fn sheet_10in_cylinder() {
    stepped(&Scene::sheet_10in_cylinder(), 600, false, pins::SHEET_10IN_CYLINDER);
}

#[test]
fn uniform_sphere_before_failure() {
    stepped(&scenes::uniform_sphere(), 400, false, pins::UNIFORM_SPHERE_BEFORE_FAILURE);
}

#[test]
fn uniform_sphere_through_failure() {
    stepped(&scenes::uniform_sphere(), 3000, true, pins::UNIFORM_SPHERE_THROUGH_FAILURE);
}

#[test]
fn sphere_on_softened_yarn() {
    stepped(&scenes::sphere_on_softened_yarn(), 3000, true, pins::SPHERE_ON_SOFTENED_YARN);
}

#[test]
fn sphere_on_drawn_strength() {
    stepped(&scenes::sphere_on_drawn_strength(), 3000, true, pins::SPHERE_ON_DRAWN_STRENGTH);
}

#[test]
fn sphere_on_yarn_that_depends_on_rate() {
    let scene = scenes::sphere_on_yarn_that_depends_on_rate();
    stepped(&scene, 3000, true, pins::SPHERE_ON_YARN_THAT_DEPENDS_ON_RATE);
}

#[test]
fn sphere_on_viscous_yarn() {
    stepped(&scenes::sphere_on_viscous_yarn(), 3000, true, pins::SPHERE_ON_VISCOUS_YARN);
}

#[test]
fn sphere_that_rubs() {
    stepped(&scenes::sphere_that_rubs(), 3000, true, pins::SPHERE_THAT_RUBS);
}

#[test]
fn sphere_through_turned_plies() {
    stepped(&scenes::sphere_through_turned_plies(), 1200, true, pins::SPHERE_THROUGH_TURNED_PLIES);
}

#[test]
fn cylinder_on_a_graded_sheet() {
    stepped(&scenes::cylinder_on_a_graded_sheet(), 2500, true, pins::CYLINDER_ON_A_GRADED_SHEET);
}

#[test]
fn taut_warp_and_crimped_weft() {
    stepped(&scenes::taut_warp_and_crimped_weft(), 3000, true, pins::TAUT_WARP_AND_CRIMPED_WEFT);
}

#[test]
fn uniform_sphere_in_halves() {
    stepped(&scenes::uniform_sphere_in_halves(), 3000, true, pins::UNIFORM_SPHERE_IN_HALVES);
}

#[test]
fn tumbling_cylinder_on_corners() {
    stepped(&scenes::tumbling_cylinder_on_corners(), 2000, true, pins::TUMBLING_CYLINDER_ON_CORNERS);
}

#[test]
fn free_plies_in_a_turned_frame() {
    stepped(&scenes::free_plies_in_a_turned_frame(), 1500, true, pins::FREE_PLIES_IN_A_TURNED_FRAME);
}

#[test]
fn damage_law_with_offset() {
    stepped(&scenes::damage_law_with_offset(), 2000, true, pins::DAMAGE_LAW_WITH_OFFSET);
}

#[test]
fn quarter_under_a_cylinder() {
    stepped(&scenes::quarter_under_a_cylinder(), 2500, true, pins::QUARTER_UNDER_A_CYLINDER);
}

#[test]
fn drawn_yarns_by_the_theta_rule() {
    stepped(&scenes::drawn_yarns_by_the_theta_rule(), 1200, true, pins::DRAWN_YARNS_BY_THE_THETA_RULE);
}

#[test]
fn tumbling_bullet() {
    stepped(&scenes::tumbling_bullet(), 2000, true, pins::TUMBLING_BULLET);
}

#[test]
fn box_on_a_corner() {
    stepped(&scenes::box_on_a_corner(), 1500, true, pins::BOX_ON_A_CORNER);
}

#[test]
fn disc_sector() {
    stepped(&scenes::disc_sector(), 2000, true, pins::DISC_SECTOR);
}

#[test]
fn loaded_sphere_on_a_prepared_sheet() {
    pinned(&scenes::uniform_sphere(), pins::LOADED_SPHERE_ON_A_PREPARED_SHEET, |sim| {
        scenes::pre_damage_and_stretch(sim);
        sim.set_external_load([0.5, -0.25, 2000.0], [0.0; 3]).expect("accepted");
        sim.advance(1500).expect("no failure");
    });
}

#[test]
fn prescribed_cylinder_on_two_paths() {
    pinned(&scenes::prescribed_cylinder(), pins::PRESCRIBED_CYLINDER_ON_TWO_PATHS, |sim| {
        for path in scenes::two_paths() {
            sim.follow(&path, path.steps).expect("followed");
        }
        assert!(sim.counters().failed_segments > 0);
    });
}
