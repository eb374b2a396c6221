//! Legal scenes at the edge of what the model is for.

use fabric_kernel::{Outcome, Scene};
use fabric_tests::{close, drawn, positions, sim_of, small_sheet, stepped};

/// Residual velocity, absorbed energy and contact loss when the projectile has left.
fn shot(scene: &Scene) -> [f64; 3] {
    let mut sim = sim_of(scene);
    sim.advance_until(Outcome::Exited | Outcome::Arrested, 50_000).unwrap();
    assert!(sim.outcomes().mask.has(Outcome::Exited));
    assert!(sim.energy().unwrap().residual.abs() < 1e-2 * sim.contact().unwrap().work);
    let contact = sim.contact().unwrap();
    [sim.projectile().unwrap().velocity[2], contact.work, contact.loss]
}

/// Above 1301 m/s the yarns break at first contact: the sphere sweeps up nodes, each of which takes m V^2/2 as motion and as
/// much as loss, so about half of what is absorbed is loss and the sum grows with V^2.
#[test]
fn very_fast_projectiles_sweep_up_nodes() {
    for [speed, residual, absorbed, loss] in
        [[2000.0, 1998.05, 32.73, 15.6], [5000.0, 4995.36, 194.8, 98.1], [20_000.0, f64::NAN, 3041.0, f64::NAN]]
    {
        let [v, work, lost] = shot(&small_sheet(41, speed));
        close(work, absorbed, 1e-3);
        assert!((0.45..0.55).contains(&(lost / work)), "{lost} {work}");
        if speed < 1e4 {
            close(v, residual, 1e-5);
            close(lost, loss, 5e-3);
        }
    }
}

/// The largest speed that is accepted runs, on every axis of the smallest sheet.
#[test]
fn the_fastest_accepted_projectile_runs() {
    let mut scene = small_sheet(9, 0.0);
    let fastest = scene.sheet.spacing / scene.step_limits().unwrap().dt;
    scene.projectile.velocity = [0.0, 0.0, 0.999 * fastest];
    assert!(stepped(&scene, 2000).contact().unwrap().work > 0.0);
}

/// The smallest sheets there are, held in every way.
#[test]
fn the_smallest_sheets_run() {
    use fabric_kernel::AttachmentKind::{FourSides, Free, TwoSides};
    for (nx, ny) in [(2, 2), (2, 3), (3, 2), (2, 17), (17, 2)] {
        for kind in [TwoSides, FourSides, Free] {
            for stochastic in [false, true] {
                let mut scene = small_sheet(2, 150.0);
                (scene.sheet.nodes_x, scene.sheet.nodes_y) = (nx, ny);
                (scene.attachment.kind, scene.yarn.stochastic) = (kind, stochastic);
                let residual = stepped(&scene, 2000).momentum_residual().unwrap();
                assert!(residual.iter().all(|r| r.abs() < 1e-12 * 8.4e-3 * 150.0));
            }
        }
    }
}

/// Ahead of a wave a sheet is at rest or moves by numbers of the processor's normal range, however small; behind it, it moves.
#[test]
fn nothing_subnormal_ahead_of_a_wave() {
    let sim = stepped(&drawn(small_sheet(101, 100.0)), 60);
    let h = sim.scene().sheet.spacing;
    let deflections: Vec<f64> = positions(&sim).iter().map(|x| x[2].abs() / h).collect();
    let smallest = deflections.iter().copied().filter(|&z| z > 0.0).fold(f64::INFINITY, f64::min);
    let at_rest = deflections.iter().filter(|&&z| z == 0.0).count();
    assert!(smallest > 1e-93 && smallest < 1e-20, "{smallest:e}");
    let moving = deflections.len() - at_rest;
    assert!(at_rest > 1000 && moving > 300, "{at_rest} {moving}");
}
