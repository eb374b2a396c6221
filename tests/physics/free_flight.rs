//! Without contact the projectile coasts and the sheet stays exactly where it is.

use fabric_tests::reference::{V3, add, length, rest_positions, scale, sub};
use fabric_tests::{close, positions, sim_of, small_sheet, tilted_cylinder, velocities};

/// P = P0 + V0 t, V bit-constant; no force and no motion of the sheet, exactly.
#[test]
fn velocity_is_constant_to_the_bit_and_the_sheet_at_rest() {
    let mut scene = small_sheet(21, 0.0);
    scene.projectile.position = [1e-3, -2e-3, -0.02];
    scene.projectile.velocity = [30.0, -70.0, -110.0];
    let mut sim = sim_of(&scene);
    sim.step_every_row();
    sim.advance(5000).unwrap();
    let motion = sim.projectile().unwrap();
    assert_eq!(motion.velocity, scene.projectile.velocity);
    assert_eq!(motion.angular_velocity, [0.0; 3]);
    assert_eq!(motion.orientation, scene.projectile.orientation);
    let expected = add(scene.projectile.position, scale(scene.projectile.velocity, sim.time()));
    assert!(length(sub(motion.position, expected)) < 1e-13 * length(expected) * 10.0);

    let rest: Vec<V3> = rest_positions(&scene);
    assert_eq!(positions(&sim), rest);
    assert!(velocities(&sim).iter().all(|v| *v == [0.0; 3]));
    let energy = sim.energy().unwrap();
    assert_eq!((energy.fabric_kinetic, energy.strain, energy.dissipated, energy.contact_loss), (0.0, 0.0, 0.0, 0.0));
    assert_eq!(sim.support().unwrap().total, [0.0; 3]);
}

/// A constant force: the staggered scheme gives V = V0 + g t and P = P0 + V0 t + g t (t + dt)/2, the given
/// velocity belonging to half a step before the start. The work of the load is the gain of kinetic energy.
#[test]
fn a_projectile_under_gravity_falls_as_galileo_says() {
    let mut scene = small_sheet(11, 0.0);
    scene.projectile.position = [0.0, 0.0, -0.05];
    scene.projectile.velocity = [3.0, 0.0, 0.0];
    let mass = scene.projectile.mass;
    let gravity = [0.0, 0.0, -5e4];
    let mut sim = sim_of(&scene);
    sim.set_external_load(scale(gravity, mass), [0.0; 3]).unwrap();
    sim.advance(3000).unwrap();
    let (t, dt, motion) = (sim.time(), sim.step_limits().dt, sim.projectile().unwrap());
    close(motion.velocity[2], gravity[2] * t, 1e-12);
    assert_eq!(motion.velocity[0], 3.0);
    let place = -0.05 + gravity[2] * 0.5 * t * (t + dt);
    println!("figure 19: free fall, place off by {:.0e} (allowed 1e-12)", (motion.position[2] / place - 1.0).abs());
    close(motion.position[2], place, 1e-12);
    let gain = 0.5 * mass * motion.velocity[2] * motion.velocity[2];
    let energy = sim.energy().unwrap();
    close(energy.external_work, gain, 1e-12);
    assert!(energy.residual.abs() < 1e-12 * gain);
    let residual = sim.momentum_residual().unwrap();
    assert!(length(residual) < 1e-12 * mass * motion.velocity[2].abs());
}

/// A torque about the axis of a cylinder: w = T t/I_axial, and the work is the energy of the spin.
#[test]
fn a_torque_spins_the_cylinder_up() {
    let mut scene = tilted_cylinder(11, 0.0, -10.0);
    scene.projectile.position = [0.0, 0.0, -0.05];
    let axial = 0.5 * scene.projectile.mass * scene.projectile.radius * scene.projectile.radius;
    let torque = 2.0;
    let mut sim = sim_of(&scene);
    sim.set_external_load([0.0; 3], [0.0, 0.0, torque]).unwrap();
    sim.advance(2000).unwrap();
    let expected = torque * sim.time() / axial;
    close(sim.projectile().unwrap().angular_velocity[2], expected, 1e-12);
    close(sim.energy().unwrap().external_work, 0.5 * axial * expected * expected, 1e-10);
}
