//! Rings of one ply and of separate ones against closed forms: circles of their own, one on another, on the
//! case, and the balances.

use crate::plies::{another, of_ply, off_the_lumped, stacked, takes_along, with_back};
use crate::rings::{on_casing, radius_of, ring, tension, with_sphere};
use crate::second_order;
use fabric_kernel::{AttachmentKind, Code, Scene, TimeStep};
use fabric_tests::reference::{V3, dot, length, scale, sub};
use fabric_tests::{close, damage, positions, set_off, sim_of, velocities};
use std::f64::consts::PI;

/// A ring of 48 nodes in each of three free rows, of so many plies at this gap in spacings.
fn plies(count: u32, gap: f64) -> Scene {
    let scene = ring(48, 3);
    stacked(scene, count, gap * scene.sheet.spacing)
}

/// Outwards at this speed, m/s.
fn outwards(x: V3, speed: f64) -> V3 {
    scale([x[0], 0.0, x[2]], speed / radius_of(x))
}

/// Each node of a ring that is set off outwards feels -2 N(U) sin(pi/n), so that its radius follows one
/// equation, stepped here by itself. Plies that do not touch breathe each by that of its own radius, viscous
/// ones too; what the balance leaves open is of second order.
#[test]
fn each_ply_breathes_by_itself() {
    let (mut worst, speed): (f64, _) = (0.0, 40.0);
    for (count, viscosity) in [1, 3].into_iter().flat_map(|count| [(count, [0.0; 2]), (count, [0.06, 1.5])]) {
        let mut scene = plies(count, 2.0);
        [scene.yarn.viscosity_linear, scene.yarn.viscosity_quadratic] = viscosity;
        let (m, h, sine) = (scene.sheet.node_mass, scene.sheet.spacing, (PI / 48.0).sin());
        let run = |fraction: f64| {
            let mut sim = sim_of(&Scene { time_step: TimeStep::fraction(fraction), ..scene });
            set_off(&mut sim, |_, x| [x, outwards(x, speed)]);
            sim.advance((20.0 / fraction) as u64).unwrap();
            sim
        };
        let (sim, steps) = (run(0.4), 50);
        let dt = sim.step_limits().dt;
        // (M16) with the growth of U^2/2 in the last step for U dU, and c dt/h as `sound`.
        let sound = (scene.yarn.modulus_mean * scene.sheet.yarn_area * h / m).sqrt() * dt / h;
        for ply in 0..count as usize {
            let natural = scene.sheet.radius + 2.0 * ply as f64 * h;
            let (mut r, mut way, mut before) = (natural, speed * dt, 1.0);
            for _ in 0..steps {
                let u = (r / natural).max(1.0);
                let growth = 0.5 * (u * u - before * before);
                let rate = viscosity[0] * growth / sound + viscosity[1] * growth * growth.max(0.0) / (sound * sound);
                let viscous = scene.yarn.modulus_mean * scene.sheet.yarn_area * u * rate;
                way -= dt * dt * 2.0 * (tension(&scene, u) + viscous) * sine / m;
                (r, before) = (r + way, u);
            }
            worst = of_ply(&sim, ply).into_iter().map(|x| (radius_of(x) - r).abs() / natural).fold(worst, f64::max);
            assert!(r > natural, "{r}");
        }
        let open = [0.4, 0.2, 0.1, 0.05].map(|fraction| {
            let energy = run(fraction).energy().unwrap();
            let held = energy.fabric_kinetic + energy.strain;
            close(held + energy.viscous - energy.residual, 0.5 * m * 144.0 * f64::from(count) * speed * speed, 1e-12);
            assert_eq!((energy.viscous > 1e-3 * held, energy.ply_loss), (viscosity[0] > 0.0, 0.0));
            assert!(energy.strain > 0.1 * held);
            energy.residual.abs() / held
        });
        println!("figure 19: {count} plies that breathe, open energy at steps of 0.4, 0.2, 0.1 and 0.05: {open:?}");
        second_order(&open, 0.1);
    }
    println!("figure 19: plies that breathe by themselves, radius off by {worst:.0e} (allowed 1e-12)");
    assert!(worst < 1e-12, "{worst:e}");
}

/// Plies that lie on each other and are alike are the lumped ring of their mass, rubbed or not, with a case
/// or without.
#[test]
fn plies_on_each_other_move_as_the_lumped_ring() {
    let mut worst = [0.0_f64; 2];
    for (count, friction, cased) in [(2, 0.0, false), (5, 0.0, true), (3, 0.2, false)] {
        let mut scene = with_sphere(ring(60, 21), 1.5e-3, 50.0, true);
        (scene.attachment.kind, scene.contact.friction) = (AttachmentKind::FourSides, friction);
        (scene.projectile.velocity[0], scene.projectile.velocity[1]) = (8.0, 5.0);
        if cased {
            (scene.casing.radius, scene.sheet.pre_strain[0]) = (scene.sheet.radius, 0.003);
            (scene.casing.window_angle, scene.casing.window_place) = ([0.0, 0.6], [0.0, 8.0 * scene.sheet.spacing]);
        }
        let [speed, work, strain] = off_the_lumped(&scene, count, 250);
        worst = [worst[0].max(speed), worst[1].max(work).max(strain)];
    }
    let [speed, energy] = worst;
    println!("figure 19: plies on each other and the lumped ring, speed off by {speed:.0e}, energies by {energy:.0e}");
    assert!(speed < 1e-8 && energy < 1e-6, "{speed:e} {energy:e}");
}

/// Also one of another fabric, three times as heavy.
#[test]
fn a_ply_that_moves_outwards_takes_along_one_after_the_other() {
    let mut sim = sim_of(&with_back(plies(3, 0.2), 1, |back| back.node_mass *= 3.0));
    // Every node tears off, so that nothing but contact moves it.
    sim.set_largest_stretch(&vec![10.0; sim.layout().segments()]).unwrap();
    takes_along(sim, &[1.0, 1.0, 3.0], |x| outwards(x, 1.0));
}

/// Slack plies that fall on a case, or on one that lies there, stop on it, and what they bring, m v^2/2 of
/// each node, is lost.
#[test]
fn plies_that_fall_on_their_case_stop() {
    for (count, moving, allowed) in [(1, 0, 1e-13), (3, 0, 1e-12), (3, 1, 1e-12), (2, 1, 1e-12)] {
        let mut scene = plies(count, 0.1);
        scene.casing.radius = if moving == 0 { 0.98 * scene.sheet.radius } else { scene.sheet.radius };
        let mut sim = sim_of(&scene);
        // Slack before they start, too.
        let falling = |x: V3| [[0.995 * x[0], x[1], 0.995 * x[2]], outwards(x, -20.0)];
        set_off(&mut sim, |k, x| if k / 144 >= moving { falling(x) } else { [x, [0.0; 3]] });
        sim.advance(700).unwrap();
        let off = |ply: usize| {
            let x = of_ply(&sim, ply);
            x.into_iter().map(|x| (radius_of(x) / scene.casing.radius - 1.0).abs()).fold(0.0, f64::max)
        };
        let (energy, worst) = (sim.energy().unwrap(), (0..count as usize).map(off).fold(0.0, f64::max));
        let brought = 0.5 * scene.sheet.node_mass * 144.0 * 400.0 * f64::from(count - moving as u32);
        println!(
            "figure 19: {count} plies that fall on their case, place off by {worst:.0e}, energy by {:.0e}",
            energy.residual.abs() / brought
        );
        assert!(worst < allowed && energy.residual.abs() < 1e-12 * brought, "{worst:e} {energy:?}");
        close(energy.casing_loss + energy.ply_loss, brought, 1e-12);
        let push = length(sim.momentum_residual().unwrap());
        assert!(push < 1e-12 * 144.0 * scene.sheet.node_mass * 20.0, "{push:e}");
        assert!(sim.counters().ply_penetration < 1e-14);
    }
}

/// Taut plies rest on their case, whose pushes from all around cancel.
#[test]
fn taut_plies_rest_on_their_case() {
    for count in [1, 4] {
        let scene = stacked(on_casing(0.01), count, 0.0);
        let mut sim = sim_of(&scene);
        let (start, taut, h) = (positions(&sim), sim.energy().unwrap().strain, scene.sheet.spacing);
        sim.advance(2000).unwrap();
        let off = positions(&sim).into_iter().zip(&start).map(|(a, b)| length(sub(a, *b)) / h).fold(0.0, f64::max);
        let speed = velocities(&sim).into_iter().map(length).fold(0.0, f64::max) / (h / sim.step_limits().dt);
        let (energy, support) = (sim.energy().unwrap(), sim.support().unwrap());
        let pushes = 2000.0 * 48.0 * 5.0 * f64::from(count) * sim.step_limits().dt;
        let push = pushes * 2.0 * tension(&scene, 1.01) * (PI / 48.0).sin();
        println!(
            "figure 19: {count} taut plies on their case, moved by {off:.0e} spacings, at {speed:.0e} of one a step, energy open by {:.0e}, \
             case {:.0e} of its pushes",
            energy.residual.abs() / taut,
            length(support.casing) / push
        );
        assert!(off < 1e-11 && speed < 1e-13 && energy.residual.abs() < 1e-12 * taut, "{off:e} {speed:e} {energy:?}");
        close(energy.strain, taut, 1e-10);
        assert!(length(support.casing) < 1e-12 * push && length(sim.momentum_residual().unwrap()) < 1e-12 * push);
    }
}

/// Through the window at an angle, with bare, taut and viscous plies, one and several, of two fabrics and
/// with friction: momentum and energy close, and no ply is entered.
#[test]
fn balances_of_a_perforated_wrap() {
    let (mut most_energy, mut most_momentum) = (0.0_f64, 0.0_f64);
    for (count, gap, strain, friction) in
        [(1, 0.0, 0.0, 0.0), (1, 0.0, 0.003, 0.0), (3, 0.1, 0.0, 0.0), (4, 0.0, 0.003, 0.0), (3, 0.2, 0.0, 0.3)]
    {
        let mut scene = stacked(with_sphere(ring(80, 31), 2e-3, 150.0, true), count, 0.0);
        let h = scene.sheet.spacing;
        (scene.attachment.kind, scene.stack.gap) = (AttachmentKind::FourSides, gap * h);
        (scene.casing.radius, scene.sheet.pre_strain[0], scene.contact.friction) =
            (scene.sheet.radius, strain, friction);
        (scene.yarn.viscosity_linear, scene.yarn.viscosity_quadratic) = (20.0 * strain, 500.0 * strain);
        (scene.casing.window_angle, scene.casing.window_place) = ([0.0, 0.45], [0.0, 6.0 * h]);
        (scene.projectile.velocity[0], scene.projectile.velocity[1]) = (30.0, 20.0);
        if friction > 0.0 {
            scene = with_back(scene, 1, another);
        }
        scene.slack_balance = count > 1 && friction == 0.0;
        let body = scene.projectile;
        let brought = (0.5 * body.mass * dot(body.velocity, body.velocity), body.mass * length(body.velocity));
        let (mut sim, mut through) = (sim_of(&scene), 0.0);
        for _ in 0..40 {
            sim.advance(50).unwrap();
            let energy = sim.energy().unwrap();
            most_energy = most_energy.max(energy.residual.abs() / brought.0);
            most_momentum = most_momentum.max(length(sim.momentum_residual().unwrap()) / brought.1);
            if sim.counters().failed_segments == 0 {
                through = sim.counters().ply_penetration / h;
            }
            // Until torn yarn flies about, nodes get deep before the window only.
            let away = |x: &V3| x[2] < 0.6 * radius_of(*x) || x[1].abs() > 9.0 * h;
            let least = positions(&sim).into_iter().filter(away).map(radius_of).fold(f64::MAX, f64::min);
            assert!(sim.step_count() > 400 || least > scene.casing.radius - 1e-9, "{least}");
        }
        println!(
            "figure 19: a perforated wrap of {count} plies: energy open by {most_energy:.0e}, momentum by {most_momentum:.0e}, through by {through:.0e} spacings, {:?}",
            sim.counters()
        );
        assert!(through < 1e-12 && sim.counters().failed_segments > 0);
        assert!(gap == 0.0 || sim.energy().unwrap().ply_loss > 0.0);
        assert!(damage(&sim).contains(&0.0) && length(sim.support().unwrap().casing) > 1e-3 * brought.1);
    }
    assert!(most_energy < 0.01 && most_momentum < 1e-12, "{most_energy:e} {most_momentum:e}");
}

#[test]
fn taut_plies_with_gaps_are_refused() {
    let error = stacked(on_casing(0.01), 2, 1e-4).check().unwrap_err();
    assert_eq!((error.code, error.field), (Code::NotInEquilibrium, "stack.gap"));
}
