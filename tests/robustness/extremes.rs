//! Legal scenes at the edge of what the model is for.

use fabric::Solid;
use fabric::{Outcome, Scene};
use fabric_tests::{close, sim_of, small_sheet};

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

/// A projectile of 1e-6 kg = 15 nodes rebounds, and the contact solve still converges: V_z = -18.1 m/s from 100 m/s.
#[test]
fn a_very_light_projectile_rebounds() {
    let mut scene = small_sheet(41, 100.0);
    scene.projectile.mass = 1e-6;
    let mut sim = sim_of(&scene);
    sim.advance_until(Outcome::Arrested, 20_000).unwrap();
    let end = sim.step_count() + 5000;
    sim.advance(end - sim.step_count()).unwrap();
    assert_eq!(sim.counters().unconverged, 0);
    assert!(sim.counters().most_sweeps <= 14);
    close(sim.projectile().unwrap().velocity[2], -18.1, 3e-3);
}

/// At one node's mass the solve may run out of sweeps; that is counted and never adds energy.
#[test]
fn a_projectile_as_light_as_a_node_never_gains_energy() {
    let mut scene = small_sheet(15, 100.0);
    scene.projectile.mass = scene.sheet.node_mass;
    let first = 0.5 * scene.projectile.mass * 1e4;
    let mut sim = sim_of(&scene);
    for _ in 0..200 {
        sim.advance(10).unwrap();
        assert!(sim.energy().unwrap().projectile_kinetic <= first);
    }
    assert!(sim.energy().unwrap().residual < 1e-3 * first);
}

/// At the very centre of a sphere any normal will do, but it is a unit vector and always the same.
#[test]
fn the_centre_of_a_sphere_has_a_normal() {
    let solid = Solid::of(&Scene::sheet_3in_sphere().projectile);
    let gap = solid.gap(&[0.0; 3].into());
    assert_eq!(gap.distance, -6.35e-3);
    assert_eq!(gap.normal.norm(), 1.0);
    let rod = Solid::of(&Scene::sheet_10in_cylinder().projectile);
    assert_eq!(rod.gap(&[0.0; 3].into()).normal.norm(), 1.0);
}

/// The largest speed that is accepted runs, on every axis of the smallest sheet.
#[test]
fn the_fastest_accepted_projectile_runs() {
    let mut scene = small_sheet(9, 0.0);
    let fastest = scene.sheet.spacing / scene.step_limits().unwrap().dt;
    scene.projectile.velocity = [0.0, 0.0, 0.999 * fastest];
    let mut sim = sim_of(&scene);
    sim.advance(2000).unwrap();
    assert!(sim.contact().unwrap().work > 0.0);
}

/// The smallest sheets there are, held in every way.
#[test]
fn the_smallest_sheets_run() {
    use fabric::AttachmentKind::{FourSides, Free, TwoSides};
    for (nx, ny) in [(2, 2), (2, 3), (3, 2), (2, 17), (17, 2)] {
        for kind in [TwoSides, FourSides, Free] {
            for stochastic in [false, true] {
                let mut scene = small_sheet(2, 150.0);
                (scene.sheet.nodes_x, scene.sheet.nodes_y) = (nx, ny);
                (scene.attachment.kind, scene.yarn.stochastic) = (kind, stochastic);
                let mut sim = sim_of(&scene);
                sim.advance(2000).unwrap();
                let residual = sim.momentum_residual().unwrap();
                assert!(residual.iter().all(|r| r.abs() < 1e-12 * 8.4e-3 * 150.0));
            }
        }
    }
}

/// Ahead of a wave a sheet is at rest or moves by numbers of the processor's normal range, however small; behind it, it moves.
#[test]
fn nothing_subnormal_ahead_of_a_wave() {
    let mut scene = small_sheet(101, 100.0);
    scene.yarn.stochastic = true;
    let mut sim = sim_of(&scene);
    sim.advance(60).unwrap();
    let h = scene.sheet.spacing;
    let mut moved = vec![0.0; 3 * sim.layout().nodes()];
    sim.copy_positions(&mut moved).unwrap();
    let deflections: Vec<f64> = moved.iter().skip(2).step_by(3).map(|z| z.abs() / h).collect();
    let smallest = deflections.iter().copied().filter(|&z| z > 0.0).fold(f64::INFINITY, f64::min);
    let at_rest = deflections.iter().filter(|&&z| z == 0.0).count();
    assert!(smallest > 1e-93 && smallest < 1e-20, "{smallest:e}");
    let moving = deflections.len() - at_rest;
    assert!(at_rest > 1000 && moving > 300, "{at_rest} {moving}");
}
