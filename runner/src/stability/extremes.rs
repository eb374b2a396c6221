//! Huge and subnormal parameters that are accepted: the answer is right. (Which are refused: `tests/src/inputs.rs`.)

use super::Case;
use super::flight::{Ended, Flight, changed, ending, uniform};
use fabric::{Outcome, Scene};

/// All rows of this theme.
pub fn rows() -> Vec<Case> {
    let passed = |end: &Ended<'_>| end.only(Outcome::Passed) && end.summary.absorbed == 0.0;
    let quiet = |end: &Ended<'_>| end.sound() && end.failure.is_none() && end.latched(Outcome::Exited);
    let flights = vec![
        Flight::new(
            "node mass 1e-20 kg at 0.4 dt_crit",
            "accepted, dt about 8e-15 s, balances closed",
            changed(uniform(21, 100.0), |scene| scene.sheet.node_mass = 1e-20),
            20_000,
            |end| (1e-15..1e-14).contains(&end.summary.dt) && end.balances.energy.abs() < 1e-9,
        ),
        Flight::new(
            "position 1e300 m away",
            "passed, absorbed exactly 0",
            changed(uniform(21, 100.0), |scene| scene.projectile.position[0] = 1e300),
            20_000,
            passed,
        ),
        Flight {
            text: Box::new(|end| format!("{}, {} unconverged", ending(end), end.summary.unconverged)),
            // Contact with every node at once, as under a slab.
            ..Flight::new(
                "radius 1e3 m over a sheet of 29 mm",
                "balances close, under 1 % of the solves at the cap, none inside by 1e-12 R",
                changed(uniform(41, 100.0), |scene| {
                    scene.projectile.radius = 1e3;
                    scene.projectile.position[2] = -1e3;
                }),
                2000,
                |end| end.closed() && end.summary.unconverged < 20 && end.outside(1e-12 * 1e3),
            )
        },
        Flight::new(
            "force window 1e300 s",
            "exits, sound: the peak force is the mean over the run",
            changed(uniform(41, 100.0), |scene| scene.force_window = 1e300),
            100_000,
            move |end| {
                let [x, y, z] = end.summary.residual_velocity;
                let lost = Scene::sheet_3in_sphere().projectile.mass * fabric::math::length([x, y, z - 100.0]);
                quiet(end) && (end.summary.peak_force * end.summary.time / lost - 1.0).abs() < 1e-9
            },
        ),
        Flight::new(
            "force window subnormal",
            "exits, sound: the window is one step",
            changed(uniform(41, 100.0), |scene| scene.force_window = 1e-320),
            100_000,
            move |end| quiet(end) && end.summary.peak_force > 0.0,
        ),
        Flight::new(
            "scatter of the modulus 1e90 Pa",
            "accepted with a step far below the usual one, sound",
            changed(uniform(21, 100.0), |scene| {
                scene.yarn.stochastic = true;
                scene.yarn.modulus_sd = 1e90;
                scene.yarn.damage_slope = 0.0;
                scene.yarn.damage_intercept = 230.0;
            }),
            1000,
            |end| end.summary.dt < 1e-45 && end.closed(),
        ),
    ];
    flights.into_iter().map(|flight| flight.case("Huge and subnormal")).collect()
}
