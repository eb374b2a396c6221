//! The step that is halved after the first failure: second order through the switch, the same bits before it, closed balances.

use crate::second_order;
use fabric::{AttachmentKind, Drive, Motion, Path, Scene, TimeStep};
use fabric_tests::reference::{V3, fixed_nodes, largest_distance, length};
use fabric_tests::{AT_REST, halved, positions, set_off, sim_of, small_sheet, sphere_on_3in, without_projectile};

/// A taut sheet that swings, with one node near a corner pulled so far that its yarns break in the first step.
fn swinging_sheet(scene: &Scene, after: f64) -> Vec<V3> {
    let mut sim = sim_of(scene);
    let (h, half) = (scene.sheet.spacing, scene.half_size()[0]);
    let wave = |x: f64| (std::f64::consts::FRAC_PI_2 * x / half).cos();
    let fixed = fixed_nodes(scene);
    set_off(&mut sim, |k, [a, b, _]| {
        let height = if fixed[k] { 0.0 } else { wave(a) * wave(b) };
        let pull = if k == 2 * 41 + 2 { 0.1 * h } else { 0.0 };
        [[1.005 * a + pull, 1.005 * b, 2.0 * h * height], [0.0, 0.0, 60.0 * height]]
    });
    sim.advance((after / sim.step_limits().dt).round() as u64).unwrap();
    assert!(sim.counters().failed_segments > 0);
    // Far from the broken corner.
    positions(&sim).into_iter().enumerate().filter(|(k, _)| k % 41 > 28 && k / 41 > 28).map(|(_, x)| x).collect()
}

/// Scaling the velocities without the quarter kick would leave an error of first order.
#[test]
fn the_switch_is_of_second_order() {
    let base = without_projectile(small_sheet(41, 0.0));
    let after = 16.0 * base.step_limits().unwrap().dt_crit;
    let run = |scene: Scene, division: f64| {
        let scene = Scene { time_step: TimeStep::fraction(1.0 / division), ..scene };
        swinging_sheet(&scene, after)
    };
    let fine = run(base, 128.0);
    let errors = [2.0, 4.0, 8.0].map(|division| largest_distance(&run(halved(base), division), &fine));
    second_order(&errors, 0.2);
    // Half the step all the way has a quarter of the error of a whole one; the halved run is close to it.
    let whole = largest_distance(&run(base, 2.0), &fine);
    assert!(errors[0] < 0.5 * whole, "{errors:?} {whole:e}");
}

#[test]
fn bits_are_the_same_until_something_fails() {
    let scene = small_sheet(41, 100.0);
    for (other, later) in [(halved(scene), 1)] {
        let (mut plain, mut other) = (sim_of(&scene), sim_of(&other));
        while plain.counters().failed_segments == 0 {
            plain.step().unwrap();
            other.step().unwrap();
            // The step of the failure itself is still a whole one.
            assert!(positions(&plain) == positions(&other));
        }
        assert_eq!(other.counters().failed_segments, plain.counters().failed_segments);
        plain.advance(later).unwrap();
        other.advance(later).unwrap();
        assert!(positions(&plain) != positions(&other));
        assert_eq!(plain.time(), other.time());
    }
}

/// 40 J on four held sides: momentum to rounding through the switch, with load; a tenth of the energy creep or less.
#[test]
fn balances_close_through_the_switch() {
    let residual = |scene: Scene| {
        let mut sim = sim_of(&scene);
        sim.set_external_load([0.0, 3.0, 500.0], [0.0; 3]).unwrap();
        for _ in 0..20 {
            sim.advance(500).unwrap();
            let momentum = scene.projectile.mass * scene.projectile.velocity[2];
            assert!(length(sim.momentum_residual().unwrap()) < 1e-12 * momentum);
        }
        let energy = sim.energy().unwrap();
        (energy.residual.abs(), energy.halving.abs())
    };
    let scene = sphere_on_3in(AttachmentKind::FourSides, 40.0, false);
    let (plain, none) = residual(scene);
    let (half, jump) = residual(halved(scene));
    assert_eq!(none, 0.0);
    assert!(half < 0.2 * plain, "{half} {plain}");
    assert!(jump > 0.0 && jump < 1e-3 * 40.0, "{jump:e}");
}

/// A prescribed body reads its path at the middle of the step too.
#[test]
fn a_path_is_followed_in_halves() {
    let mut scene = halved(small_sheet(31, 100.0));
    scene.drive = Drive::Prescribed;
    let mut sim = sim_of(&scene);
    let end = |z: f64| Motion { position: [0.0, 0.0, z], velocity: [0.0, 0.0, 100.0], ..AT_REST };
    let duration = 5000.0 * sim.step_limits().dt;
    let z = scene.projectile.position[2] + 100.0 * duration;
    sim.follow(&Path { first: 0, steps: 5000, end: end(z) }, 5000).unwrap();
    assert!(sim.counters().failed_segments > 0);
    assert!((sim.projectile().unwrap().position[2] - z).abs() < 1e-15);
    assert!((sim.projectile().unwrap().velocity[2] - 100.0).abs() < 1e-6);
}
