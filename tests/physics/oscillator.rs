//! One free node between four fixed ones: the first impact, and the oscillator it makes with the sphere. (A
//! node on one segment is in
//! `fabrics`.)

use fabric_kernel::{Sim, TimeStep};
use fabric_tests::{between_supports, close, damage, sim_of, small_sheet};

/// A flat slack sheet exerts no force, so the first step is a plastic impact of one node: V' = V M/(M + m),
/// and the loss is m M V^2/(2 (M + m)) = 3.2600e-4 J at 100 m/s.
#[test]
fn the_first_impact_is_plastic() {
    let scene = small_sheet(11, 100.0);
    let (m, mass) = (scene.sheet.node_mass, scene.projectile.mass);
    let mut sim = sim_of(&scene);
    sim.step().unwrap();
    let after = sim.projectile().unwrap().velocity[2];
    assert!((after - 100.0 * mass / (mass + m)).abs() < 1e-13);
    assert!((after - 99.99922382).abs() < 1e-8);
    let contact = sim.contact().unwrap();
    let loss = m * mass * 1e4 / (2.0 * (mass + m));
    println!("figure 19: plastic first impact, loss off by {:.0e} (allowed 1e-10)", (contact.loss / loss - 1.0).abs());
    close(contact.loss, loss, 1e-10);
    close(contact.loss, 3.2600e-4, 1e-5);
    close(contact.impulse[2], -m * after, 1e-10);
    close(contact.work, 0.5 * mass * (1e4 - after * after), 1e-8);
    assert_eq!(sim.counters().contacts, 1);
    assert_eq!(sim.outcomes().first_contact, Some(0));
}

/// Steps until the sphere stands still, and returns its depth and the time, interpolated between steps.
fn turning_point(sim: &mut Sim<'_>) -> (f64, f64) {
    let dt = sim.step_limits().dt;
    loop {
        let before = sim.projectile().unwrap();
        sim.step().unwrap();
        let after = sim.projectile().unwrap();
        if after.velocity[2] <= 0.0 {
            // Velocities belong to the middles of the two steps that meet at `before.position`.
            let fraction = before.velocity[2] / (before.velocity[2] - after.velocity[2]) - 0.5;
            let curvature = (after.velocity[2] - before.velocity[2]) / dt;
            let depth = before.position[2] - 0.5 * curvature * (fraction * dt) * (fraction * dt);
            return (depth, sim.time() - dt + fraction * dt);
        }
    }
}

/// Four yarns pulled sideways make the quartic potential E A_0 z^4/(2 h^3): with V' = V M/(M + m)
/// z_max = [(M + m) V'^2 h^3/(E A_0)]^(1/4) = 0.120808188 mm, reached after 1.3110287771 z_max/V' = 158.3842
/// us (1.3110287771 = the lemniscate constant), U_max = 1.013761109, and the sphere leaves with -V'.
#[test]
fn the_quartic_oscillator() {
    let mut scene = between_supports(small_sheet(3, 1.0), 1.0);
    scene.time_step = TimeStep::fraction(0.1);
    let (m, mass, h) = (scene.sheet.node_mass, scene.projectile.mass, scene.sheet.spacing);
    let speed = mass / (mass + m);
    let stiffness = scene.yarn.modulus_mean * scene.sheet.yarn_area;
    let depth = ((mass + m) * speed * speed * h * h * h / stiffness).powf(0.25);
    close(depth, 0.120808188e-3, 1e-8);

    let mut sim = sim_of(&scene);
    let (reached, time) = turning_point(&mut sim);
    let z = reached + scene.projectile.radius;
    close(z, depth, 1e-7);
    close(time, 1.3110287771 * depth / speed, 1e-5);
    close(time, 158.3842e-6, 1e-5);
    close(sim.fabric().unwrap().max_stretch, 1.013761109, 1e-8);
    sim.advance(2 * sim.step_count()).unwrap();
    let rebound = sim.projectile().unwrap().velocity[2];
    println!(
        "figure 19: rebound of the quartic oscillator, depth off by {:.0e}, speed by {:.0e} (allowed 1e-7)",
        (z / depth - 1.0).abs(),
        (rebound / speed + 1.0).abs()
    );
    close(rebound, -speed, 1e-7);
    assert_eq!(sim.counters().contacts, 0);
    assert!(sim.counters().failed_segments == 0 && damage(&sim).iter().all(|&alpha| alpha == 1.0));
}
