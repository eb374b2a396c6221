//! The kernel's ledger on the paper's sheet: what it does not close by, at the default step.

use fabric::{AttachmentKind, Scene, StepAfterFailure, TimeStep};
use fabric_tests::{sim_of, sphere_on_3in};

/// Residual over the kinetic energy at impact after `time` s.
fn residual(scene: &Scene, time: f64) -> f64 {
    let mut sim = sim_of(scene);
    let first = sim.energy().unwrap().projectile_kinetic;
    let steps = (time / sim.step_limits().dt) as u64;
    sim.advance(steps).unwrap();
    assert!(sim.counters().failed_segments > 0);
    sim.energy().unwrap().residual / first
}

/// 40 J, four sides, uniform yarn, 220 us, twice as long as the sphere takes to get through: at most 1 % of what it brought.
#[test]
fn the_ledger_of_a_perforation_closes() {
    let off = residual(&sphere_on_3in(AttachmentKind::FourSides, 40.0, false), 220e-6).abs();
    println!("figure 16: 40 J, four sides, default step, 220 us: {:.2} % of KE0", 100.0 * off);
    assert!(off < 0.01, "{off}");
}

/// A sheet that rattles slack for long gains energy: 10 J for 1.2 ms, as it is and with the two remedies of docs/model.md, with its
/// bounds. Some ten seconds.
#[test]
#[ignore = "some ten seconds; cargo xtask verify runs it"]
fn a_slack_sheet_creeps_as_stated() {
    let scene = sphere_on_3in(AttachmentKind::FourSides, 10.0, false);
    let mut halved = scene;
    halved.step_after_failure = StepAfterFailure::Half;
    let mut softened = scene;
    (softened.slack_toe, softened.time_step) = (0.02, TimeStep::fraction(0.35));
    for (name, scene, stated) in [
        ("as it is", scene, 0.3),
        ("step_after_failure = half", halved, 0.03),
        ("slack_toe = 0.02 at 0.35 dt_crit", softened, 0.01),
    ] {
        let off = residual(&scene, 1.2e-3).abs();
        println!("figure 16: 10 J, slack for 1.2 ms, {name}: {:.1} % of KE0", 100.0 * off);
        assert!(off < stated, "{name}: {off}");
    }
}
