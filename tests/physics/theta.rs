//! The theta rule with contact: against velocity Verlet, and its own balances. Its order is in
//! `convergence.rs`.

use crate::balances::{angular_momentum, linear_momentum};
use fabric_kernel::{AttachmentKind, Integrator, RotationRule, Scene, Sim, TimeStep};
use fabric_tests::reference::{add, dot, fixed_nodes, forces, length, projectile_energy, scale, sub};
use fabric_tests::{close, damage, drawn, positions, sim_of, small_sheet, speed, stepped, tilted_cylinder, velocities};

/// The scene stepped by the theta rule with theta = 1/2.
fn by_theta(scene: Scene) -> Scene {
    Scene { integrator: Integrator::THETA, ..scene }
}

/// N = 41, 3 J, 60 us, 0.4 dt_crit: both methods give the projectile 26.119 m/s, 0.1346 J lost.
#[test]
fn an_impact_agrees_with_velocity_verlet() {
    let scene = small_sheet(41, speed(3.0, 8.4e-3));
    let theta = by_theta(scene);
    let (mut verlet, mut theta) = (sim_of(&scene), sim_of(&theta));
    let steps = (60e-6 / verlet.step_limits().dt) as u64;
    verlet.advance(steps).unwrap();
    theta.advance(steps).unwrap();
    for sim in [&verlet, &theta] {
        close(sim.projectile().unwrap().velocity[2], 26.119, 1e-4);
        close(sim.contact().unwrap().work, 0.1346, 2e-3);
        assert_eq!(sim.counters().unconverged, 0);
    }
    let counters = theta.counters();
    let mean = counters.iterations as f64 / steps as f64;
    assert!((6.0..8.0).contains(&mean) && counters.most_iterations <= 9, "{mean} {}", counters.most_iterations);
    assert_eq!(verlet.counters().iterations, 0);
}

/// Linear and angular momentum of a free sheet and a tumbling cylinder, all at t_n.
#[test]
fn momentum_of_a_free_sheet_and_a_turning_cylinder_is_kept() {
    let mut scene = by_theta(tilted_cylinder(31, 0.4, 60.0));
    scene.attachment.kind = AttachmentKind::Free;
    scene.projectile.angular_velocity = [200.0, -300.0, 900.0];
    let mut sim = sim_of(&scene);
    let first = (linear_momentum(&sim), angular_momentum(&sim));
    sim.advance(600).unwrap();
    let now = (linear_momentum(&sim), angular_momentum(&sim));
    let (given, twisted) = (length(sim.contact().unwrap().impulse), length(sim.contact().unwrap().angular_impulse));
    assert!(given > 1e-4 && twisted > 1e-7);
    assert!(length(sub(now.0, first.0)) < 1e-12 * length(first.0));
    assert!(length(sim.momentum_residual().unwrap()) < 1e-12 * length(first.0));
    // Forces act at both ends of a step on nodes that move in between: angular momentum is kept to second
    // order.
    assert!(length(sub(now.1, first.1)) < 1e-4 * twisted, "{:e}", length(sub(now.1, first.1)) / twisted);
}

/// KE_{n+1} - KE_n = sum over nodes of dt (F_n + F_{n+1})/2 . (v+ + v_{n+1})/2 - contact loss of the step, to
/// rounding, where v+ = v_{n+1} - dt (F_n + F_{n+1})/2m is the velocity after contact; forces from plain
/// formulas; through failure.
#[test]
fn work_energy_identity_of_every_step() {
    let mut scene = by_theta(drawn(small_sheet(21, 120.0)));
    scene.time_step = TimeStep::fraction(0.25);
    let (m, fixed) = (scene.sheet.node_mass, fixed_nodes(&scene));
    let mut sim = sim_of(&scene);
    let dt = sim.step_limits().dt;
    let look = |sim: &Sim<'_>| {
        let x = positions(sim);
        let pulls = forces(&scene, &x, &damage(sim));
        (velocities(sim), pulls, sim.projectile().unwrap(), sim.contact().unwrap())
    };
    let mut before = look(&sim);
    let mut worst: f64 = 0.0;
    for _ in 0..1400 {
        sim.step().unwrap();
        let now = look(&sim);
        let (mut gain, mut work, mut kinetic) = (0.0, 0.0, 0.0);
        for k in (0..fixed.len()).filter(|&k| !fixed[k]) {
            let (v, w) = (now.0[k], before.0[k]);
            gain += 0.5 * m * (dot(v, v) - dot(w, w));
            kinetic += 0.5 * m * dot(v, v);
            let kick = scale(add(now.1[k], before.1[k]), 0.5 * dt);
            work += 0.5 * dot(kick, sub(scale(v, 2.0), scale(kick, 1.0 / m)));
        }
        let (energy, energy_before) = (projectile_energy(&scene, &now.2), projectile_energy(&scene, &before.2));
        let off = gain + energy - energy_before - work + (now.3.loss - before.3.loss);
        worst = worst.max(off.abs() / (kinetic + energy));
        assert!(off.abs() < 1e-12 * (kinetic + energy), "{off:e}");
        assert!((energy_before - energy - (now.3.work - before.3.work)).abs() < 1e-12 * energy);
        before = now;
    }
    assert!(sim.counters().failed_segments > 20, "{}", sim.counters().failed_segments);
    println!("figure 16b: theta rule, sphere through failure: {worst:.1e}");
}

/// The rule for the projectile's rotation is chosen by itself. On a flight of a cylinder, whose transverse
/// rates turn by a linear law, theta = 1/2 is the midpoint rule and theta = 1 differs from it by first order
/// in dt.
#[test]
fn the_rotation_rule_is_an_option_of_either_integrator() {
    let mut scene = tilted_cylinder(21, 0.4, 50.0);
    scene.projectile.position[2] = -1.0;
    scene.projectile.angular_velocity = [2e5, 1e5, 3e5];
    let spin = |rule: RotationRule, division: f64| {
        let mut scene = scene;
        scene.rotation_rule = rule;
        scene.time_step = TimeStep::fraction(0.4 / division);
        stepped(&scene, 1000 * division as u64).projectile().unwrap().angular_velocity
    };
    let differ = |theta, division| {
        length(sub(spin(RotationRule::theta(theta), division), spin(RotationRule::MIDPOINT, division))) / 3e5
    };
    assert!(differ(0.5, 1.0) < 1e-12);
    let (coarse, fine) = (differ(1.0, 1.0), differ(1.0, 2.0));
    let order = (coarse / fine).log2();
    assert!((0.9..1.1).contains(&order), "{coarse:e} {fine:e}");
}
