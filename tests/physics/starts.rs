//! Simulations that do not start from the flat, whole sheet at rest.

use fabric_kernel::{Scene, TimeStep};
use fabric_tests::reference::{largest_distance, length};
use fabric_tests::{between_supports, close, damage, positions, sim_of, small_sheet, velocities};

/// A run broken off and started again elsewhere from positions and velocities goes on as if nothing had
/// happened.
#[test]
fn a_restart_from_positions_and_velocities_goes_on() {
    let scene = small_sheet(21, 60.0);
    let mut sim = sim_of(&scene);
    sim.advance(200).unwrap();
    let mut later: Scene = scene;
    let motion = sim.projectile().unwrap();
    (later.projectile.position, later.projectile.velocity) = (motion.position, motion.velocity);
    // The flat sheet the constructor sees would overlap the projectile, which is already through its plane.
    later.projectile.position[2] -= 1.0;
    let shift = |x: &[[f64; 3]], by: f64| x.iter().map(|p| [p[0], p[1], p[2] + by]).collect::<Vec<_>>();
    let (x, v) = (shift(&positions(&sim), -1.0), velocities(&sim));
    let mut other = sim_of(&later);
    other.set_motion(x.as_flattened(), v.as_flattened()).unwrap();
    assert!(largest_distance(&positions(&other), &x) < 1e-15);
    assert!(largest_distance(&velocities(&other), &v) < 1e-12 * 60.0);
    sim.advance(200).unwrap();
    other.advance(200).unwrap();
    assert_eq!(sim.counters().failed_segments, 0);
    assert!(sim.counters().contacts > 0);
    // Positions about 1 m off round more coarsely: 1e-16 m and what the contact makes of it.
    let apart = largest_distance(&shift(&positions(&other), 1.0), &positions(&sim));
    assert!(apart < 1e-11);
}

/// Damage given by the largest stretch so far follows the exponential law, and softens the quartic
/// oscillator:
/// z_max grows by alpha^(-1/4).
#[test]
fn a_pre_damaged_sheet_is_softer() {
    let mut scene = between_supports(small_sheet(3, 0.7), 1.0);
    scene.time_step = TimeStep::fraction(0.1);
    let largest = 1.0325;
    let rate = 7.91 * 140.21 - 878.46;
    let alpha = (-rate * (largest - 1.03f64)).exp();
    let mut sim = sim_of(&scene);
    sim.set_largest_stretch(&[largest; 12]).unwrap();
    for value in damage(&sim) {
        close(value, alpha, 1e-11);
    }
    assert_eq!(sim.energy().unwrap().residual, 0.0);
    let mut deepest: f64 = 0.0;
    while sim.projectile().unwrap().velocity[2] > 0.0 {
        sim.step().unwrap();
        deepest = deepest.max(sim.projectile().unwrap().position[2] + scene.projectile.radius);
    }
    let (m, mass, h) = (scene.sheet.node_mass, scene.projectile.mass, scene.sheet.spacing);
    let energy = mass * mass / (mass + m) * 0.7 * 0.7;
    let exact = (energy * h * h * h / (alpha * scene.yarn.modulus_mean * scene.sheet.yarn_area)).powf(0.25);
    close(deepest, exact, 1e-6);
    // Unloading does not heal, and the stretch stays below the largest ever: alpha is what it was.
    for value in damage(&sim) {
        close(value, alpha, 1e-11);
    }
}

/// With every segment failed no force acts: nodes fly straight on, and the momentum of projectile and debris
/// is constant.
#[test]
fn a_sheet_of_dead_yarns_is_debris() {
    let mut scene = small_sheet(15, 100.0);
    scene.attachment.kind = fabric_kernel::AttachmentKind::Free;
    let mut sim = sim_of(&scene);
    let segments = sim.layout().segments();
    sim.set_largest_stretch(&vec![1.2; segments]).unwrap();
    assert_eq!(sim.counters().failed_segments, segments as u64);
    sim.advance(2000).unwrap();
    let energy = sim.energy().unwrap();
    assert_eq!(energy.strain, 0.0);
    // Every swept-up node takes m V^2/2 as motion and m V^2/2 as loss.
    close(energy.fabric_kinetic, energy.contact_loss, 0.02);
    assert!(energy.residual.abs() < 1e-12 * energy.projectile_kinetic);
    assert!(length(sim.momentum_residual().unwrap()) < 1e-13 * 0.84);
    let end = fabric_kernel::Outcome::Exited;
    sim.advance_until(end, 20_000).unwrap();
    assert_eq!(sim.outcomes().mask, end);
}
