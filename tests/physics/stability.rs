//! The step limit, observed: a taut sheet is stable below it and blows up above it.

use fabric_kernel::{Scene, StepCheck, TimeStep};
use fabric_tests::{close, set_off, sim_of, small_sheet, without_projectile};

/// Kinetic energy after `steps` steps of dt, s, over that at the start, of a sheet whose nodes are put at
/// `stretch` times their places and kicked a little: every mode gets its share; the stiffest, a chequerboard,
/// a larger one. A stable step multiplies the velocity of a mode by up to 1/sqrt(1 - (omega dt/2)^2), so its
/// energy at 0.99 of the limit by 50; an unstable one multiplies it without end.
pub(crate) fn growth(scene: &Scene, stretch: f64, dt: f64, steps: u64) -> f64 {
    let scene = Scene { time_step: TimeStep::seconds(dt), step_check: StepCheck::None, ..*scene };
    let mut sim = sim_of(&scene);
    let nodes = scene.sheet.nodes_x as usize;
    set_off(&mut sim, |k, x| {
        let (i, j) = (k % nodes, k / nodes);
        let noise = |a: f64| 1e-5 * ((k as f64 * a).sin());
        let sign = if (i + j) % 2 == 0 { 1e-4 } else { -1e-4 };
        let inside = (1..nodes - 1).contains(&i) && (1..nodes - 1).contains(&j);
        let kick = if inside { [sign + noise(1.3), sign + noise(2.1), sign + noise(3.7)] } else { [0.0; 3] };
        [x.map(|x| x * stretch), kick]
    });
    let first = sim.energy().unwrap().fabric_kinetic;
    sim.advance(steps).unwrap();
    sim.energy().unwrap().fabric_kinetic / first
}

/// A sheet at stretch U has omega_max^2 = (k/m) [2 (3 U^2 - 1) + 2 (U^2 - 1)]; at U_c this is the bound that
/// dt_crit is made of, at 1 the limit 2/omega is sqrt(m/k) = 1.059 dt_crit. A sheet of 21 nodes a side
/// reaches it within (pi/40)^2/2 = 0.3 %.
#[test]
fn the_limit_of_a_taut_sheet_is_where_the_formula_says() {
    let scene = without_projectile(small_sheet(21, 0.0));
    let k = scene.yarn.modulus_mean * scene.sheet.yarn_area / scene.sheet.spacing;
    for stretch in [1.0005, 1.02_f64] {
        let u2 = stretch * stretch;
        let limit = 2.0 / (k / scene.sheet.node_mass * (2.0 * (3.0 * u2 - 1.0) + 2.0 * (u2 - 1.0))).sqrt();
        assert!(growth(&scene, stretch, 0.99 * limit, 4000) < 100.0, "{stretch}");
        assert!(growth(&scene, stretch, 1.01 * limit, 400) > 1e6, "{stretch}");
    }
    close((scene.sheet.node_mass / k).sqrt(), 1.059 * scene.step_limits().unwrap().dt_crit, 1e-3);
}
