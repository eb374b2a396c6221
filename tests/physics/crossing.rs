//! Mean forces of segments that go slack or taut within a step: no energy creep, same order, same symmetries.

use fabric::{AttachmentKind, Code, Crossing, InstructionSet, Integrator, Scene, Sim, Symmetry, ThetaRule, TimeStep};
use fabric_tests::reference::{largest_distance, length};
use fabric_tests::{Buffers, positions, small_sheet, speed, velocities, without_projectile};

fn by_means(scene: Scene) -> Scene {
    Scene { crossing: Crossing::Mean, ..scene }
}

/// Energy residual in per cent of the impact energy after so many steps of 0.4 dt_crit, and the segments failed.
fn creep(scene: &Scene, steps: u64, energy: f64) -> (f64, u64) {
    let mut buffers = Buffers::of(scene);
    let mut sim = buffers.sim(scene);
    sim.advance(steps).unwrap();
    (100.0 * sim.energy().unwrap().residual / energy, sim.counters().failed_segments)
}

/// 40 J on a small sheet, four sides, well beyond the exit: ten times less than with the force at the middle.
#[test]
fn a_slack_sheet_does_not_heat_after_failure() {
    let scene = small_sheet(41, speed(40.0, 8.4e-3));
    let (point, failed) = creep(&scene, 15_000, 40.0);
    assert!(failed > 100);
    let (mean, failed) = creep(&by_means(scene), 15_000, 40.0);
    assert!(mean.abs() < 0.1 * point && mean.abs() < 0.1 && failed > 100, "{mean} {point}");
}

/// 1 J on a small sheet, 0.5 dt_crit, 600 us: the sheet stays whole and keeps its energy ten times better.
#[test]
fn an_intact_sheet_does_not_heat() {
    let mut scene = small_sheet(41, speed(1.0, 8.4e-3));
    scene.time_step = TimeStep::Fraction(0.5);
    let steps = (600e-6 / scene.step_limits().unwrap().dt) as u64;
    let (point, failed) = creep(&scene, steps, 1.0);
    assert!(failed == 0, "{point}");
    let (mean, failed) = creep(&by_means(scene), steps, 1.0);
    assert!(mean.abs() < 0.1 * point && failed == 0, "{mean} {point}");
}

/// A sheet that goes slack and taut again converges with second order.
#[test]
fn the_order_stays_two() {
    let mut scene = without_projectile(by_means(small_sheet(21, 0.0)));
    let run = |scene: &Scene, division: u64| {
        let scene = Scene { time_step: TimeStep::Fraction(1.0 / division as f64), ..*scene };
        let mut buffers = Buffers::of(&scene);
        let mut sim = buffers.sim(&scene);
        let x = positions(&sim);
        let half = scene.half_size()[0];
        let wave = |x: f64| if x.abs() < 0.999 * half { (std::f64::consts::FRAC_PI_2 * x / half).cos() } else { 0.0 };
        let v: Vec<f64> = x.iter().flat_map(|x| [0.0, 0.0, 150.0 * wave(x[0]) * wave(x[1])]).collect();
        sim.set_motion(&x.concat(), &v).unwrap();
        sim.advance(80 * division).unwrap();
        positions(&sim)
    };
    let mut errors = |crossing| {
        scene.crossing = crossing;
        let fine = run(&scene, 256);
        [2, 4, 8].map(|division| largest_distance(&run(&scene, division), &fine))
    };
    let (mean, point) = (errors(Crossing::Mean), errors(Crossing::Point));
    for pair in mean.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((1.8..2.3).contains(&order), "{mean:?} {point:?}");
    }
}

/// Momentum with the supports, to rounding.
#[test]
fn momentum_is_kept() {
    for kind in [AttachmentKind::FourSides, AttachmentKind::Free] {
        let scene = by_means(Scene {
            attachment: fabric::Attachment { kind, ..small_sheet(31, 0.0).attachment },
            ..small_sheet(31, 250.0)
        });
        let mut buffers = Buffers::of(&scene);
        let mut sim = buffers.sim(&scene);
        sim.advance(4000).unwrap();
        assert!(length(sim.momentum_residual().unwrap()) < 1e-12 * scene.projectile.mass * 250.0, "{kind:?}");
        assert!(sim.counters().failed_segments > 0);
    }
}

/// The same bits with every instruction set, with every row stepped, from a snapshot, and in a quarter model.
#[test]
fn bits_do_not_depend_on_how_it_is_run() {
    let mut scene = by_means(small_sheet(31, 110.0));
    scene.yarn.stochastic = true;
    let run = |prepare: &dyn Fn(&mut Sim<'_>)| {
        let mut buffers = Buffers::of(&scene);
        let mut sim = buffers.sim(&scene);
        prepare(&mut sim);
        sim.advance(3000).unwrap();
        assert!(sim.counters().failed_segments > 0);
        sim.digest()
    };
    let digest = run(&|_| {});
    assert_eq!(run(&|sim| sim.step_every_row()), digest);
    for set in InstructionSet::ALL.into_iter().filter(|set| set.available()) {
        assert_eq!(run(&|sim| sim.use_instructions(set).unwrap()), digest, "{}", set.name());
    }
    let (mut a, mut b) = (Buffers::of(&scene), Buffers::of(&scene));
    let (mut sim, mut other) = (a.sim(&scene), b.sim(&scene));
    sim.advance(1500).unwrap();
    let mut image = vec![0; sim.snapshot_bytes()];
    sim.save(&mut image).unwrap();
    other.load(&image).unwrap();
    other.advance(1500).unwrap();
    assert_eq!(other.digest(), digest);
}

#[test]
fn a_quarter_moves_as_the_whole_sheet() {
    for nodes in [14, 15] {
        let mut scene = by_means(small_sheet(nodes, 0.0));
        scene.projectile.position = [0.0, 0.0, -1.0];
        let run = |symmetry: Symmetry| {
            let scene = Scene { symmetry, ..scene };
            let mut buffers = Buffers::of(&scene);
            let mut sim = buffers.sim(&scene);
            let x = positions(&sim);
            let half = scene.half_size()[0];
            let wave = |x: f64| if x.abs() < 0.99 * half { (1.5 * x / half).cos() } else { 0.0 };
            let v: Vec<f64> = x.iter().flat_map(|x| [0.0, 0.0, 1300.0 * wave(x[0]) * wave(x[1])]).collect();
            sim.set_motion(&x.concat(), &v).unwrap();
            sim.advance(600).unwrap();
            (positions(&sim), velocities(&sim), sim.counters().failed_segments)
        };
        let (whole, part) = (run(Symmetry::default()), run(Symmetry { mirror_x: true, mirror_y: true }));
        let columns = nodes.div_ceil(2) as usize;
        for (k, (x, v)) in part.0.iter().zip(&part.1).enumerate() {
            let at = k / columns * nodes as usize + k % columns;
            assert!((*x, *v) == (whole.0[at], whole.1[at]), "{nodes}, node {k}");
        }
        assert!(whole.2 > 0);
        assert_eq!(part.2, whole.2);
    }
}

#[test]
fn the_theta_rule_has_no_means() {
    let mut scene = by_means(small_sheet(21, 100.0));
    scene.integrator = Integrator::Theta(ThetaRule::default());
    let error = scene.check().unwrap_err();
    assert_eq!((error.code, error.field), (Code::OutOfRange, "crossing"));
}
