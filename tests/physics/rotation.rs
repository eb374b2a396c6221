//! Torque-free rotation against the closed forms.

use fabric_kernel::Scene;
use fabric_kernel::{Body, Inertia, Motion};
use fabric_kernel::{Form, Solid};
use fabric_tests::reference::{V3, length, moments, sub, turn, turn_back};
use fabric_tests::{AT_REST, sim_of, tilted_cylinder};

/// A body with I = (1, 2, 3) and w(0) = (1, 0, 1), drifted for `steps` steps: the case of the Jacobi
/// functions.
fn drifted(dt: f64, steps: u64) -> Body {
    let solid = Solid::from(Form::Cylinder { radius: 1.0, half_length: 1.0 });
    let mut inertia = Inertia::of(&solid, 1.0, true);
    inertia.moments = [1.0, 2.0, 3.0].into();
    let mut body = Body::of(&Motion { angular_velocity: [1.0, 0.0, 1.0], ..AT_REST });
    for _ in 0..steps {
        body.drift(&inertia, fabric_kernel::RotationRule::MIDPOINT, dt);
    }
    body
}

fn rate(body: &Body) -> V3 {
    body.angular_velocity.into()
}

/// Euler's equations: w = (cn, sn, dn)(t | m = 1/3). The scheme is of second order, so (4 fine - coarse)/3
/// meets the table to its rounding. The motion of w has the period 4 K(m = 1/3) = 6.93566754103174.
#[test]
fn the_tumbling_body_follows_the_jacobi_functions_and_has_their_period() {
    let table: [(u64, V3); 4] = [
        (1, [0.577802471812, 0.816176637480, 0.882015815511]),
        (2, [-0.216378369067, 0.976309582765, 0.825998304801]),
        (5, [-0.164350429765, -0.986402015527, 0.821991699829]),
        (10, [-0.921069998444, 0.389397044115, 0.974400660583]),
    ];
    for (t, exact) in table {
        let (coarse, fine) = (rate(&drifted(1.0 / 1024.0, 1024 * t)), rate(&drifted(1.0 / 2048.0, 2048 * t)));
        let ratio = length(sub(coarse, exact)) / length(sub(fine, exact));
        assert!((ratio - 4.0).abs() < 0.02, "order 2 at t = {t}: {ratio}");
        let off = (0..3).map(|k| ((4.0 * fine[k] - coarse[k]) / 3.0 - exact[k]).abs()).fold(0.0, f64::max);
        println!("figure 19: tumbling body at t = {t}, off the Jacobi functions by {off:.0e} (allowed 2e-11)");
        assert!(off < 2e-11, "t = {t}: {coarse:?} {fine:?} {exact:?}");
    }
    let after = rate(&drifted(6.93566754103174 / 20_000.0, 20_000));
    assert!(length(sub(after, [1.0, 0.0, 1.0])) < 2e-7);
}

/// Implicit midpoint with the Cayley map keeps the spatial angular momentum vector and the kinetic energy to
/// rounding.
#[test]
fn spatial_angular_momentum_is_kept_over_ten_thousand_steps() {
    let body = drifted(0.1, 10_000);
    let w = rate(&body);
    let q = body.orientation;
    let momentum = turn([q.w, q.i, q.j, q.k], [w[0], 2.0 * w[1], 3.0 * w[2]]);
    let drift = length(sub(momentum, [1.0, 0.0, 3.0])) / 10f64.sqrt();
    println!("figure 19: rigid body tumbling 10000 steps, angular momentum off by {drift:.0e} (allowed 1e-13)");
    assert!(drift < 1e-13, "drift {drift:e}");
    let energy = w[0] * w[0] + 2.0 * w[1] * w[1] + 3.0 * w[2] * w[2];
    assert!((energy / 4.0 - 1.0).abs() < 1e-13);
}

/// A cylinder tumbling past the sheet, through the simulation: spatial angular momentum constant, and the
/// transverse rate precesses in the body at (I_a - I_t)/I_t = -0.846153846 of the axial spin.
#[test]
fn a_free_cylinder_precesses_in_the_simulation() {
    let mut scene: Scene = tilted_cylinder(5, 0.3, 0.0);
    scene.projectile.position = [0.0, 0.0, -1.0];
    // Heavy nodes allow a step of 8e-5 s.
    scene.sheet.node_mass = 0.03;
    let spin = 100.0;
    let q = scene.projectile.orientation;
    scene.projectile.angular_velocity = turn(q, [10.0, 0.0, spin]);
    let inertia = moments(&scene);
    let momentum = |m: &Motion| {
        let w = turn_back(m.orientation, m.angular_velocity);
        turn(m.orientation, [inertia[0] * w[0], inertia[1] * w[1], inertia[2] * w[2]])
    };
    let mut sim = sim_of(&scene);
    let first = momentum(&sim.projectile().unwrap());
    sim.advance(10_000).unwrap();
    let motion = sim.projectile().unwrap();
    assert!(length(sub(momentum(&motion), first)) < 1e-13 * length(first));

    let w = turn_back(motion.orientation, motion.angular_velocity);
    assert!((w[2] - spin).abs() < 1e-10 * spin);
    let expected = -0.846153846 * spin * sim.time();
    let off = (w[1].atan2(w[0]) - expected).rem_euclid(std::f64::consts::TAU);
    let off = off.min(std::f64::consts::TAU - off);
    // Midpoint rule: relative phase error (rate dt)^2/12.
    let dt = sim.step_limits().dt;
    assert!(off < 1.1 * expected.abs() * (0.846 * spin * dt).powi(2) / 12.0 + 1e-6, "{off:e}");
}
