//! Drawn strength: chains pulled until their weakest segment gives way, the published strengths of one yarn
//! at six lengths. (The balances of such a sheet are in `balances`.)

use fabric_kernel::{AttachmentKind, Integrator, Scene, Sim, StrengthDraw};
use fabric_tests::{close, damage, memory_of, set_off, sim_of, small_sheet, without_projectile};

/// Strength of Kevlar 49 yarn at six gauge lengths: mm, and Weibull scale in MPa.
/// 13th International Conference on Fracture (2013), papers 386 and 389.
const MEASURED: [(f64, f64); 6] =
    [(50.0, 1933.0), (125.0, 1829.0), (200.0, 1795.0), (275.0, 1724.0), (350.0, 1726.0), (425.0, 1652.0)];
/// Weibull shape and the scale at 50 mm, MPa: the straight line through the logarithms of the six, by least
/// squares.
const SHAPE: f64 = 14.74;
const SCALE: f64 = 1944.3;
/// Spacing of 17 yarns an inch, m.
const SPACING: f64 = 0.0254 / 17.0;

/// A free sheet of two equal chains of this length, m, without projectile. The yarn's modulus makes
/// `critical_stretch` that of SCALE.
fn chains(length: f64, seed: u64) -> Scene {
    let mut scene = without_projectile(small_sheet(2, 0.0));
    let segments = length / SPACING;
    (scene.sheet.nodes_x, scene.sheet.spacing, scene.seed) = (segments.round() as u32 + 1, SPACING, seed);
    scene.attachment.kind = AttachmentKind::Free;
    scene.projectile.radius = SPACING;
    let yarn = &mut scene.yarn;
    (yarn.modulus_mean, yarn.critical_stretch) = (120e9, stretch_at(SCALE * 1e6, 120e9));
    (yarn.damage_slope, yarn.damage_intercept) = (0.0, 2300.0);
    yarn.strength_draw = StrengthDraw::Weibull;
    (yarn.weibull_shape, yarn.weibull_gauge_length) = (SHAPE, 0.05);
    scene
}

/// Stretch at which the nominal stress is `stress`: E U (U^2 - 1)/2, by bisection.
pub(crate) fn stretch_at(stress: f64, modulus: f64) -> f64 {
    let (mut low, mut high) = (1.0, 1.1);
    for _ in 0..60 {
        let u: f64 = 0.5 * (low + high);
        if modulus * 0.5 * u * (u * u - 1.0) < stress { low = u } else { high = u }
    }
    0.5 * (low + high)
}

/// Nominal stress, Pa, at which the first chain of the scene gives way, as the kernel finds it: it is held at
/// a uniform stretch, and stepped once.
fn strength(scene: &Scene) -> f64 {
    let mut memory = memory_of(scene);
    let nx = scene.sheet.nodes_x as usize;
    let mut gives_way = |stretch: f64| {
        let mut sim = Sim::new(scene, &mut memory).unwrap();
        set_off(&mut sim, |_, [x, y, z]| [[x * stretch, y, z], [0.0; 3]]);
        sim.step().unwrap();
        damage(&sim)[..nx - 1].iter().any(|alpha| *alpha < 1.0)
    };
    let (mut low, mut high): (f64, f64) = (1.0, 1.1);
    for _ in 0..14 {
        let middle = 0.5 * (low + high);
        if gives_way(middle) { high = middle } else { low = middle }
    }
    0.5 * scene.yarn.modulus_mean * low * (low * low - 1.0)
}

/// Nominal stress, Pa, at the critical stretch of the weakest segment of the first chain.
fn weakest(scene: &Scene) -> f64 {
    let segments = u64::from(scene.sheet.nodes_x) - 1;
    let stretch = (0..segments).map(|k| scene.draw_critical_stretch(k)).fold(2.0, f64::min);
    0.5 * scene.yarn.modulus_mean * stretch * (stretch * stretch - 1.0)
}

/// The Weibull scale of 1,500 chains of each length by its logarithm (mean ln scale - gamma/m): the standard
/// error is 0.2 %.
#[test]
fn a_yarn_is_as_strong_as_measured_at_six_gauge_lengths() {
    const CHAINS: u64 = 1500;
    for (millimetres, measured) in MEASURED {
        let length = 1e-3 * millimetres;
        let strengths = (0..CHAINS).map(|seed| weakest(&chains(length, seed)) * 1e-6);
        let mean = strengths.map(f64::ln).sum::<f64>() / CHAINS as f64;
        let scale = (mean + 0.577_215_664_9 / SHAPE).exp();
        println!("{millimetres} mm: {scale:.0} MPa, measured {measured} MPa");
        assert!((scale / measured - 1.0).abs() < 0.03, "{millimetres} mm: {scale} MPa instead of {measured} MPa");
    }
}

/// A segment is damaged from its own critical stretch on and not before; the others stay whole.
#[test]
fn the_weakest_segment_gives_way_at_its_own_critical_stretch() {
    for (seed, (millimetres, _)) in (0..24).zip(MEASURED.into_iter().cycle()) {
        let scene = chains(1e-3 * millimetres, seed);
        close(strength(&scene), weakest(&scene), 1e-3);
    }
}

/// Both methods tear the same segments at first.
#[test]
fn the_theta_rule_draws_the_same_strength() {
    let mut scene = small_sheet(41, 80.0);
    let yarn = &mut scene.yarn;
    (yarn.strength_draw, yarn.weibull_shape, yarn.weibull_gauge_length) = (StrengthDraw::Weibull, 10.0, 0.01);
    let torn = |scene: &Scene| {
        let mut sim = sim_of(scene);
        let mut steps = 0;
        while damage(&sim).iter().all(|alpha| *alpha == 1.0) {
            sim.advance(4).unwrap();
            steps += 1;
        }
        let first = damage(&sim).iter().position(|alpha| *alpha < 1.0);
        (steps, first)
    };
    let (verlet, theta) = (torn(&scene), torn(&Scene { integrator: Integrator::THETA, ..scene }));
    assert_eq!(verlet.1, theta.1);
    assert!(i32::abs(verlet.0 - theta.0) <= 1, "{verlet:?} {theta:?}");
}
