//! The projectile moved by the host.

use fabric_kernel::{Drive, Motion, Path, Scene};
use fabric_tests::reference::{add, largest_distance, length, scale, sub};
use fabric_tests::{AT_REST, close, positions, rough, sim_of, small_sheet, tilted_cylinder};

/// The motion of a free run, step by step.
fn recorded(scene: &Scene, steps: usize) -> (Vec<Motion>, Vec<[f64; 3]>, f64, [f64; 3]) {
    let mut sim = sim_of(scene);
    let mut motions = Vec::new();
    for _ in 0..steps {
        sim.step().unwrap();
        motions.push(sim.projectile().unwrap());
    }
    let contact = sim.contact().unwrap();
    (motions, positions(&sim), contact.work, contact.impulse)
}

/// The path of a free run, replayed step by step on a prescribed body, moves the fabric in the same way: work
/// and impulse are what the free body lost, and fabric energy closes with the work.
#[track_caller]
fn replay(mut scene: Scene) {
    let steps = 400;
    let (motions, free, work, impulse) = recorded(&scene, steps);
    scene.drive = Drive::Prescribed;
    let mut sim = sim_of(&scene);
    for (n, end) in motions.iter().enumerate() {
        sim.follow(&Path { first: n as u64, steps: 1, end: *end }, 1).unwrap();
    }
    assert_eq!(sim.counters().failed_segments, 0);
    let apart = largest_distance(&positions(&sim), &free);
    let deflection = sim.fabric().unwrap().max_deflection;
    assert!(apart < 1e-6 * deflection);
    let contact = sim.contact().unwrap();
    // Both count the mean of the rates before and after an impulse.
    close(contact.work, work, 1e-11);
    assert!(length(sub(contact.impulse, impulse)) < 1e-11 * length(impulse));
    let energy = sim.energy().unwrap();
    assert!(energy.residual.abs() < 1e-3 * energy.contact_work, "{:e}", energy.residual);
    let held = energy.fabric_kinetic + energy.strain + energy.dissipated + energy.friction + energy.contact_loss;
    assert!((held - energy.contact_work - energy.residual).abs() < 1e-12 * held);
    assert!(length(sim.momentum_residual().unwrap()) < 1e-11 * length(impulse));
}

#[test]
fn a_replayed_body_does_the_work_of_the_free_one() {
    // With friction the host's drive does the work of spinning, too.
    let mut rubs = rough(small_sheet(31, 60.0), 0.3);
    rubs.projectile.velocity = [30.0, 0.0, 60.0];
    rubs.projectile.angular_velocity = [1000.0, 500.0, -2000.0];
    [small_sheet(31, 60.0), tilted_cylinder(31, 0.3, 60.0), rubs].into_iter().for_each(replay);
}

/// Between its ends a path is the cubic through end positions and velocities: a constant velocity is met
/// exactly, a constant acceleration too.
#[test]
fn a_path_is_the_cubic_through_its_ends() {
    let mut scene = small_sheet(5, 0.0);
    scene.drive = Drive::Prescribed;
    let start = [0.0, 0.0, -0.05];
    scene.projectile.position = start;
    let velocity = [10.0, 20.0, -30.0];
    scene.projectile.velocity = velocity;
    let acceleration = [1e6, -2e6, 3e5];
    let mut sim = sim_of(&scene);
    let dt = sim.step_limits().dt;
    let at = |t: f64| add(add(start, scale(velocity, t)), scale(acceleration, 0.5 * t * t));
    let end = 1000.0 * dt;
    let end_of = Motion { position: at(end), velocity: add(velocity, scale(acceleration, end)), ..AT_REST };
    let path = Path { first: 0, steps: 1000, end: end_of };
    for n in [137u64, 500, 1000] {
        sim.follow(&path, n - sim.step_count()).unwrap();
        assert!(length(sub(sim.projectile().unwrap().position, at(n as f64 * dt))) < 1e-15);
    }
    // Until its end the velocity is the mean over the last step; after it the body coasts with the path's.
    let motion = sim.projectile().unwrap();
    let mean = add(velocity, scale(acceleration, end - 0.5 * dt));
    assert!(length(sub(motion.velocity, mean)) < 1e-6);
    sim.advance(100).unwrap();
    assert_eq!(sim.projectile().unwrap().velocity, path.end.velocity);
    let expected = add(motion.position, scale(path.end.velocity, 100.0 * dt));
    assert!(length(sub(sim.projectile().unwrap().position, expected)) < 1e-15);
}
