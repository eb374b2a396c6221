//! The ledger, entry by entry, from positions and damage at t_{n-1} and t_n and the formulas of the model.

use fabric::Scene;
use fabric::yarn::{DamageLaw, Segment};
use fabric_tests::reference::{add, dot, length, projectile_energy, rest_positions, scale, segment_ends, sub};
use fabric_tests::{Buffers, close, damage, positions, small_sheet, tilted_cylinder};

/// A tumbling cylinder that tears drawn yarns, whose law has an offset and drops at once at the critical stretch.
fn scene() -> Scene {
    let mut scene = tilted_cylinder(21, 0.35, 120.0);
    scene.projectile.angular_velocity = [300.0, -500.0, 2000.0];
    scene.yarn.stochastic = true;
    (scene.yarn.damage_a, scene.yarn.damage_b) = (0.95, 0.02);
    scene.track_support = true;
    scene
}

/// Kinetic, strain and dissipated energy of the fabric, J: the velocity is that between two positions, strain and
/// dissipation are means of the values at both.
#[test]
fn every_entry_is_a_sum_over_nodes_or_segments() {
    let scene = scene();
    let (m, h) = (scene.sheet.node_mass, scene.sheet.spacing);
    let yarn = &scene.yarn;
    let (critical_stretch, a, b, alpha_fail) = (yarn.critical_stretch, yarn.damage_a, yarn.damage_b, yarn.alpha_fail);
    let law = DamageLaw { critical_stretch, a, b, alpha_fail };
    let ends = segment_ends(&scene);
    let drawn: Vec<Segment> = (0..ends.len()).map(|k| scene.draw_segment(k as u64).unwrap()).collect();
    let mut buffers = Buffers::of(&scene);
    let mut sim = buffers.sim(&scene);
    let dt = sim.step_limits().dt;
    let first = projectile_energy(&scene, &sim.projectile().unwrap());
    sim.set_external_load([40.0, -25.0, 300.0], [0.02, -0.03, 0.01]).unwrap();
    let mut before = (rest_positions(&scene), vec![1.0; ends.len()]);
    let (mut partly, mut broken) = (0, 0);
    for n in 0..900 {
        sim.step().unwrap();
        let now = (positions(&sim), damage(&sim));
        if n % 15 == 0 {
            let energy = sim.energy().unwrap();
            let speed = |(now, before): (&[f64; 3], &[f64; 3])| scale(sub(*now, *before), 1.0 / dt);
            let kinetic: f64 = now.0.iter().zip(&before.0).map(speed).map(|v| 0.5 * m * dot(v, v)).sum();
            let (mut strain, mut dissipated) = (0.0, 0.0);
            for (k, [from, to]) in ends.iter().enumerate() {
                for (x, alpha) in [&before, &now] {
                    let stretch = length(sub(x[*to], x[*from])) / h;
                    strain += 0.5 * scene.lumped_area() * h * drawn[k].stored(alpha[k], stretch);
                    dissipated += 0.5 * scene.lumped_area() * h * law.dissipated(&drawn[k], alpha[k]);
                }
            }
            close(energy.fabric_kinetic, kinetic, 1e-9);
            close(energy.strain, strain, 1e-9);
            close(energy.dissipated, dissipated, 1e-9);
            close(energy.projectile_kinetic, projectile_energy(&scene, &sim.projectile().unwrap()), 1e-12);
            let held = kinetic + strain + dissipated + energy.contact_loss;
            let residual = held + energy.projectile_kinetic - energy.external_work - first;
            assert!((energy.residual - residual).abs() < 1e-9 * first);
            let momentum = scene.projectile.mass * 120.0;
            assert!(length(sim.momentum_residual().unwrap()) < 1e-12 * momentum);
            partly += now.1.iter().filter(|alpha| **alpha > 0.0 && **alpha < 1.0).count();
            broken += now.1.iter().filter(|alpha| **alpha == 0.0).count();
        }
        before = now;
    }
    assert!(partly > 10 && broken > 10, "{partly} {broken}");
}

/// Without the supports' share the momentum balance is open by just what they have taken.
#[test]
fn the_supports_share_closes_the_momentum_balance() {
    let mut scene = scene();
    let mut left_open = |track| {
        scene.track_support = track;
        let mut buffers = Buffers::of(&scene);
        let mut sim = buffers.sim(&scene);
        sim.advance(400).unwrap();
        (sim.momentum_residual().unwrap(), sim.support().unwrap().total)
    };
    let (closed, taken) = left_open(true);
    let (open, _) = left_open(false);
    assert!(length(taken) > 1e-6 && length(closed) < 1e-9 * length(taken));
    assert!(length(add(open, taken)) < 1e-9 * length(taken));
}

/// Ends that are nearer than at rest at one of the two times only: the mean is half of the other's energy.
#[test]
fn strain_counts_in_tension_only() {
    let mut scene = fabric_tests::without_projectile(small_sheet(3, 0.0));
    scene.attachment.kind = fabric::AttachmentKind::Free;
    let h = scene.sheet.spacing;
    let mut buffers = Buffers::of(&scene);
    let mut sim = buffers.sim(&scene);
    let dt = sim.step_limits().dt;
    // The whole sheet contracts along x through its length at rest, by 2e-4 of it a step.
    let rest = rest_positions(&scene);
    let x: Vec<f64> = rest.iter().flat_map(|x| [1.0001 * x[0], x[1], x[2]]).collect();
    let v: Vec<f64> = rest.iter().flat_map(|x| [-2e-4 * x[0] / dt, 0.0, 0.0]).collect();
    sim.set_motion(&x, &v).unwrap();
    let before = positions(&sim);
    sim.step().unwrap();
    let now = positions(&sim);
    let strain = |x: &[[f64; 3]]| -> f64 {
        let energy = |[from, to]: &[usize; 2]| {
            let stretch = length(sub(x[*to], x[*from])) / h;
            let strain = f64::max(0.5 * (stretch * stretch - 1.0), 0.0);
            0.5 * scene.lumped_area() * h * scene.yarn.modulus_mean * strain * strain
        };
        segment_ends(&scene).iter().map(energy).sum()
    };
    assert!(strain(&before) > 0.0 && strain(&now) == 0.0);
    close(sim.energy().unwrap().strain, 0.5 * strain(&before), 1e-9);
}
