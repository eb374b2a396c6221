//! Dependence on the rate of strain against closed forms: a segment pulled at three measured rates, one held
//! still, a cell pulled both ways. (The balances of a sheet are in `balances`.)

use crate::strength::stretch_at;
use fabric_kernel::{AttachmentKind, Scene, Sim, TimeStep};
use fabric_tests::reference::length;
use fabric_tests::{close, damage, positions, rated, set_off, sim_of, small_sheet, velocities, without_projectile};

/// Kevlar 49 fabric of 25 mm gauge length: rate, 1/s, modulus, Pa, and strength, Pa.
/// 13th International Conference on Fracture (2013), paper 389, table 2.
const MEASURED: [(f64, f64, f64); 3] = [(30.0, 120e9, 1489e6), (100.0, 131e9, 1968e6), (170.0, 147e9, 2340e6)];

/// The scene with yarn of the lowest and the highest of the measured rates.
fn measured(mut scene: Scene) -> Scene {
    let [(slow, modulus, strength), _, (fast, modulus_fast, strength_fast)] = MEASURED;
    let [u, u_fast] = [stretch_at(strength, modulus), stretch_at(strength_fast, modulus_fast)];
    let [q, q_fast] = [u * u - 1.0, u_fast * u_fast - 1.0];
    let yarn = &mut scene.yarn;
    (yarn.modulus_mean, yarn.critical_stretch) = (modulus, u);
    (yarn.damage_slope, yarn.damage_intercept) = (0.0, 2300.0);
    (yarn.rate_reference, yarn.rate_limit) = (slow, fast);
    (yarn.rate_modulus, yarn.rate_stretch) =
        ((modulus_fast / modulus - 1.0) / (fast / slow).ln(), (q_fast / q - 1.0) / (fast / slow).ln());
    scene
}

/// A cell: four nodes, free, 25 mm apart, of this mass, kg.
fn cell(node_mass: f64) -> Scene {
    let mut scene = measured(without_projectile(small_sheet(2, 0.0)));
    (scene.sheet.spacing, scene.sheet.node_mass, scene.projectile.mass) = (0.025, node_mass, 0.0);
    scene.projectile.radius = 0.03;
    scene.attachment.kind = AttachmentKind::Free;
    scene
}

/// Starts with this part of the flat sheet's size more, and this rate of strain, 1/s, along x and along y.
fn start(sim: &mut Sim<'_>, strain: [f64; 2], rate: [f64; 2]) {
    set_off(sim, |_, [x, y, z]| [[x * (1.0 + strain[0]), y * (1.0 + strain[1]), z], [x * rate[0], y * rate[1], 0.0]]);
}

/// Nodes so heavy that the pull goes on at a constant rate: modulus at 0.5 % and largest nominal stress of
/// one segment, Pa, from what its pull takes of their speed.
fn pulled(rate: f64) -> (f64, f64) {
    let mut scene = cell(1e4);
    scene.time_step = TimeStep { seconds: 0.02 / rate / 4000.0, ..scene.time_step };
    let dt = scene.time_step.seconds;
    let (mut modulus, mut strength): (Option<f64>, f64) = (None, 0.0);
    let mut sim = sim_of(&scene);
    start(&mut sim, [0.0; 2], [rate, 0.0]);
    let mut before = velocities(&sim)[1][0];
    while sim.step_count() < 4000 {
        let x = positions(&sim);
        let stretch = (x[1][0] - x[0][0]) / scene.sheet.spacing;
        sim.step().unwrap();
        let now = velocities(&sim)[1][0];
        let stress = scene.sheet.node_mass * (before - now) / dt / scene.sheet.yarn_area;
        before = now;
        if stretch > 1.005 {
            modulus.get_or_insert(stress / (stretch - 1.0));
        }
        strength = strength.max(stress);
    }
    assert_eq!((damage(&sim)[0], damage(&sim)[2]), (0.0, 1.0));
    (modulus.unwrap(), strength)
}

/// Values of the outer two rates are given, so they must come out to what a secant differs from a tangent;
/// the middle one within 10 %.
#[test]
fn modulus_and_strength_are_as_measured_at_three_rates() {
    for ((rate, modulus, strength), tolerance) in MEASURED.into_iter().zip([0.015, 0.1, 0.015]) {
        let found = pulled(rate);
        println!(
            "{rate} /s: modulus {:.1} GPa ({:.1}), strength {:.0} MPa ({:.0})",
            1e-9 * found.0,
            1e-9 * modulus,
            1e-6 * found.1,
            1e-6 * strength
        );
        close(found.0, modulus, tolerance);
        close(found.1, strength, tolerance);
    }
}

/// Slower and faster than what has been measured, nothing changes any more.
#[test]
fn no_rate_is_extrapolated() {
    let [slowest, fastest] = [0, 2].map(|k| pulled(MEASURED[k].0));
    for (rate, expected) in [(3.0, slowest), (3000.0, fastest)] {
        let found = pulled(rate);
        close(found.0, expected.0, 2e-3);
        close(found.1, expected.1, 2e-3);
    }
}

/// Strain energy density over E, and stress over E, at this strain and time: integrals of e (1 + C L).
fn closed_form(scene: &Scene, e: f64, t: f64) -> (f64, f64) {
    let yarn = &scene.yarn;
    let (c, slow, fast) = (yarn.rate_modulus, yarn.rate_reference * t, yarn.rate_limit * t);
    let up_to = |e: f64| 0.5 * e * e * ((e / slow).ln() - 0.5) + 0.25 * slow * slow;
    let (extra, logarithm) = if e <= slow {
        (0.0, 0.0)
    } else if e <= fast {
        (up_to(e), (e / slow).ln())
    } else {
        (up_to(fast) + 0.5 * (fast / slow).ln() * (e * e - fast * fast), (fast / slow).ln())
    };
    (0.5 * e * e + c * extra, e * (1.0 + c * logarithm))
}

/// A segment that is stretched at once by 0.8 % and held keeps the stress of the highest rate until its mean
/// rate has fallen to it, then relaxes with the logarithm of the time, to the stress of the reference rate;
/// what its strain energy loses is taken.
#[test]
fn a_held_segment_relaxes_as_the_formula_says() {
    let mut scene = cell(1e-3);
    (scene.attachment.kind, scene.track_support) = (AttachmentKind::TwoSides, true);
    scene.time_step = TimeStep { seconds: 1e-7, ..scene.time_step };
    let strain = 0.008;
    let e = 0.5 * ((1.0 + strain) * (1.0 + strain) - 1.0);
    let mut sim = sim_of(&scene);
    start(&mut sim, [strain, 0.0], [0.0; 2]);
    let dt = sim.step_limits().dt;
    let volume = 2.0 * scene.sheet.yarn_area * scene.sheet.spacing * scene.yarn.modulus_mean;
    let (first, mut checked) = (sim.energy().unwrap().strain, [0; 3]);
    close(first, volume * closed_form(&scene, e, dt).0, 1e-12);
    let mut pulled = 0.0;
    for n in 0..4000 {
        sim.step().unwrap();
        let impulse = length(sim.support().unwrap().attachments[0]);
        if n % 10 == 0 {
            // The pull of this step belongs to its start; the count begins with the step in which the load
            // does.
            let (energy, t) = (sim.energy().unwrap(), (n + 1) as f64 * dt);
            let (stored, stress) = closed_form(&scene, e, t);
            let force = 2.0 * scene.yarn.modulus_mean * scene.sheet.yarn_area * (1.0 + strain) * stress;
            close((impulse - pulled) / dt, force, 1e-9);
            close(energy.strain, volume * stored, 2e-3);
            assert!((energy.strain + energy.viscous - first).abs() < 2e-4 * first, "{n} {energy:?}");
            checked[usize::from(e < scene.yarn.rate_limit * t) + usize::from(e < scene.yarn.rate_reference * t)] += 1;
        }
        pulled = impulse;
    }
    assert!(checked.iter().all(|&count| count > 20), "{checked:?}");
    let (slow, fast) = (e / scene.yarn.rate_reference, e / scene.yarn.rate_limit);
    close(closed_form(&scene, e, slow).1, e, 1e-12);
    close(closed_form(&scene, e, fast).1 / e, MEASURED[2].1 / MEASURED[0].1, 1e-12);
}

/// A cell pulled both ways at different rates: each of its segments is that of its own rate, so the energies
/// of the cell, two segments along x and two along y, are closed forms; nothing is lost of momentum.
#[test]
fn a_cell_pulled_both_ways_is_the_sum_of_its_segments() {
    let mut scene = cell(1e4);
    scene.time_step = TimeStep { seconds: 1e-4 / 2000.0, ..scene.time_step };
    let rates = [100.0, 45.0];
    let mut sim = sim_of(&scene);
    start(&mut sim, [0.0; 2], rates);
    sim.advance(1600).unwrap();
    let t = sim.time();
    let volume = 2.0 * scene.sheet.yarn_area * scene.sheet.spacing * scene.yarn.modulus_mean;
    let expected: f64 = rates
        .into_iter()
        .map(|rate| {
            let e = |t: f64| 0.5 * ((1.0 + rate * t) * (1.0 + rate * t) - 1.0);
            volume * closed_form(&scene, e(t), t).0
        })
        .sum();
    let energy = sim.energy().unwrap();
    close(energy.strain, expected, 3e-3);
    // Relaxation while e = r t: the integral of E C (e^2 - (r_0 t)^2)/2t is E C (e^2 - (r_0 t)^2)/4.
    let taken: f64 = rates
        .into_iter()
        .map(|rate| {
            let (e, slow) = (rate * t, scene.yarn.rate_reference * t);
            volume * scene.yarn.rate_modulus * (e * e - slow * slow) / 4.0
        })
        .sum();
    close(energy.viscous, taken, 0.01);
    assert!(energy.residual.abs() < 1e-3 * energy.strain, "{energy:?}");
    assert!(length(sim.momentum_residual().unwrap()) < 1e-9 * scene.sheet.node_mass * rates[0] * scene.sheet.spacing);
}

/// A cell that swings until it is slack: loaded, unloaded, loaded again. What is taken never comes back.
#[test]
fn no_cycle_gains_energy() {
    let mut scene = cell(0.05);
    scene.time_step = TimeStep { seconds: 2e-6, ..scene.time_step };
    let mut sim = sim_of(&scene);
    start(&mut sim, [0.006, 0.009], [60.0, -40.0]);
    let first = sim.energy().unwrap();
    let first = first.fabric_kinetic + first.strain;
    let mut taken = 0.0;
    while sim.time() < 20e-3 {
        sim.step().unwrap();
        let energy = sim.energy().unwrap();
        assert!(energy.viscous >= taken && energy.residual.abs() < 2e-3 * first, "{energy:?}");
        taken = energy.viscous;
    }
    assert!(taken > 0.003 * first, "{taken} {first}");
}

/// The default step follows from the largest tangent modulus and critical stretch; a network as stiff as that
/// is stable up to it.
#[test]
fn the_step_is_that_of_the_stiffest_yarn() {
    let (scene, mut stiff) = (rated(small_sheet(41, 120.0), 1700.0), small_sheet(41, 120.0));
    let logarithm = (scene.yarn.rate_limit / scene.yarn.rate_reference).ln();
    stiff.yarn.modulus_mean *= 1.0 + 0.13 * (1.0 + logarithm);
    (stiff.yarn.damage_slope, stiff.yarn.damage_intercept) = (0.0, 230.0);
    let u: f64 = stiff.yarn.critical_stretch;
    stiff.yarn.critical_stretch = (1.0 + (u * u - 1.0) * (1.0 + 0.16 * logarithm)).sqrt();
    close(scene.step_limits().unwrap().dt_crit, stiff.step_limits().unwrap().dt_crit, 1e-14);
}
