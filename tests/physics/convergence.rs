//! Order of convergence of the sheet alone, with velocity Verlet and with the theta rule: N = 21, four sides
//! held, v_z = v0 cos cos at the start, no projectile.

use crate::second_order;
use fabric_kernel::{Integrator, TimeStep};
use fabric_tests::reference::{V3, largest_distance};
use fabric_tests::{close, damage, positions, set_off, sim_of, small_sheet, without_projectile};

struct End {
    positions: Vec<V3>,
    failed: u64,
    damaged: usize,
    dissipated: f64,
    /// Ledger residual over the kinetic energy at the start.
    residual: f64,
    /// Iterations of the theta rule per step.
    iterations: f64,
}

const VERLET: Integrator = Integrator::VERLET;
/// With theta = 1/2.
const THETA: Integrator = Integrator::THETA;

/// The sheet after `time` units of dt_crit, with steps of dt_crit/`division`.
fn run(integrator: Integrator, v0: f64, time: u64, division: u64) -> End {
    let mut scene = without_projectile(small_sheet(21, 0.0));
    scene.integrator = integrator;
    scene.time_step = TimeStep::fraction(1.0 / division as f64);
    let mut sim = sim_of(&scene);
    let half = scene.half_size()[0];
    let wave = |x: f64| (std::f64::consts::FRAC_PI_2 * x / half).cos();
    set_off(&mut sim, |_, x| {
        let inside = x[0].abs() < half && x[1].abs() < half;
        [x, [0.0, 0.0, if inside { v0 * wave(x[0]) * wave(x[1]) } else { 0.0 }]]
    });
    let first = sim.energy().unwrap().fabric_kinetic;
    sim.advance(time * division).unwrap();
    let energy = sim.energy().unwrap();
    End {
        positions: positions(&sim),
        failed: sim.counters().failed_segments,
        damaged: damage(&sim).iter().filter(|&&alpha| alpha < 1.0).count(),
        dissipated: energy.dissipated,
        residual: energy.residual / first,
        iterations: sim.counters().iterations as f64 / (time * division) as f64,
    }
}

/// Errors at 0.5, 0.25, 0.125 and 0.0625 dt_crit against dt_crit/256.
fn errors(integrator: Integrator, v0: f64, time: u64) -> [f64; 4] {
    let fine = run(integrator, v0, time, 256).positions;
    [2, 4, 8, 16].map(|division| largest_distance(&run(integrator, v0, time, division).positions, &fine))
}

/// 150 m/s, 4.2 us: no damage. 1300 m/s, 1.3 us: first damage, no failure. The errors at 0.5 dt_crit are what
/// was measured; the theta rule's is twice Verlet's.
#[test]
fn positions_converge_with_second_order() {
    for (what, integrator, v0, time, error) in [
        ("velocity Verlet", VERLET, 150.0, 80, 2.005e-9),
        ("theta = 1/2", THETA, 150.0, 80, 4.009e-9),
        ("velocity Verlet through first damage", VERLET, 1300.0, 24, 3.116e-8),
        ("theta = 1/2 through first damage", THETA, 1300.0, 24, 6.243e-8),
    ] {
        let errors = errors(integrator, v0, time);
        let [a, b, c] = [0, 1, 2].map(|k| (errors[k] / errors[k + 1]).log2());
        println!("figure 18: {what}: 2 stated, {a:.3}, {b:.3}, {c:.3} as dt is halved");
        second_order(&errors, 0.1);
        close(errors[0], error, 0.05);
        let end = run(integrator, v0, time, 16);
        assert!(end.failed == 0 && (end.damaged > 0) == (v0 > 1000.0), "{what}: {} {}", end.failed, end.damaged);
    }
}

/// No more iterations a step than the reference needed.
#[test]
fn the_theta_rule_takes_few_iterations() {
    for (division, iterations) in [(2, 5.0), (4, 4.0), (8, 3.7), (16, 3.0)] {
        let found = run(THETA, 150.0, 80, division).iterations;
        assert!(found <= iterations, "{division}: {found}");
    }
}

/// Theta = 1, backward Euler, is of first order.
#[test]
fn backward_euler_converges_with_first_order() {
    let errors = errors(Integrator { theta: 1.0, ..THETA }, 150.0, 80);
    let order = (errors[1] / errors[2]).log2();
    let finest = (errors[2] / errors[3]).log2();
    println!("figure 18: theta = 1: 1 stated, {order:.3}, {finest:.3} as dt is halved");
    assert!((0.85..1.15).contains(&order), "order {order} of {errors:?}");
    assert!((0.9..1.1).contains(&finest), "order {finest} of {errors:?}");
}

/// The energy balance closes with second order.
#[test]
fn the_balance_closes_with_second_order() {
    for (what, integrator) in [("velocity Verlet", VERLET), ("theta = 1/2", THETA)] {
        let residuals = [2, 4, 8].map(|division| run(integrator, 150.0, 80, division).residual);
        let order = (residuals[1] / residuals[2]).log2();
        println!(
            "figure 16: smooth N = 21, {what}: {:.2e} of KE0 at 0.5 dt_crit, order {order:.2}",
            residuals[0].abs()
        );
        assert!(residuals[0].abs() < 2e-5, "{residuals:?}");
        second_order(&residuals, 0.1);
    }
}

/// v0 = 1300 m/s, 2.1 us: through about 216 failures, where positions are chaotic, the dissipated energy is
/// 1.83 J and the balance closes ever better with smaller steps: dissipation is a state function of alpha.
/// (The count scatters between steps:
/// the theta rule has 184 failures at dt_crit/8 and 204 at dt_crit/64.)
#[test]
fn failures_and_dissipation_agree_and_the_balance_closes_through_them() {
    for (integrator, division, closure) in
        [(VERLET, 8, 5e-4), (VERLET, 16, 1e-4), (VERLET, 128, 1e-5), (THETA, 16, 1e-3), (THETA, 64, 1e-4)]
    {
        let end = run(integrator, 1300.0, 40, division);
        assert!((190..=230).contains(&end.failed), "{}", end.failed);
        close(end.dissipated, 1.83, 0.1);
        assert!(end.residual.abs() < closure, "{:e}", end.residual);
    }
}
