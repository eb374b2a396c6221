//! The time step and the stiffness: from a tenth of dt_crit to beyond it, stiff and soft sheets, the theta rule.

use super::flight::{Ended, Flight, changed, far, percent, scale, short, speed, stretch, unchecked, uniform};
use super::{Answer, Balances, Case, fmu};
use crate::Result;
use crate::event::Summary;
use crate::memory::Buffers;
use fabric::{Failure, Integrator, Outcome, Scene, Sim, TimeStep, math};

/// The steps of both sweeps, over dt_crit.
const FRACTIONS: [f64; 12] = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2];

/// All rows of this theme.
pub fn rows() -> Vec<Case> {
    let mut rows: Vec<Case> = taut().chain(impacts()).map(|flight| flight.case("Time step")).collect();
    rows.push(theta_beyond_the_limit());
    rows.extend(stiffness());
    rows
}

/// A taut sheet that vibrates freely, for 60 us: the linear limit, without contact and without slack.
fn taut() -> impl Iterator<Item = Flight> {
    FRACTIONS.into_iter().map(|fraction| {
        // At a stretch of 1.01 the limit is 1.04 dt_crit; damage caps what grows beyond it.
        let sound = fraction <= 1.0;
        let expected = if sound { "sound: residual below 1 %" } else { "blows up: > 100 % energy, yarns fail" };
        let name = format!("taut sheet vibrates at {fraction} dt_crit");
        Flight {
            prepare: Some(pluck),
            until: &[],
            text: Box::new(|end| {
                let stretch = end.fabric.max_stretch;
                let failed = end.summary.failed_segments;
                format!("{:+.3} % energy, largest stretch {stretch:.4}, {failed} failed", 100.0 * end.balances.energy)
            }),
            ..Flight::new(name, expected, unchecked(far(21), fraction), steps_of(60e-6, fraction), move |end| {
                if sound {
                    end.balances.energy.abs() < 0.01 && end.summary.failed_segments == 0
                } else {
                    end.balances.energy > 1.0 && end.summary.failed_segments > 0
                }
            })
        }
    })
}

/// Stretched by 1 %, with a smooth transverse velocity of 20 m/s.
fn pluck(sim: &mut Sim<'_>) -> Result<()> {
    let mut positions = vec![0.0; 3 * sim.layout().nodes()];
    sim.copy_positions(&mut positions)?;
    positions.iter_mut().for_each(|x| *x *= 1.01);
    let mut velocities = vec![0.0; positions.len()];
    let [nx, ny] = [sim.layout().nodes_x, sim.layout().nodes_y];
    let wave = |i: usize, n: usize| math::sin(core::f64::consts::PI * i as f64 / (n - 1) as f64);
    for j in 1..ny - 1 {
        for i in 1..nx - 1 {
            velocities[3 * (j * nx + i) + 2] = 20.0 * wave(i, nx) * wave(j, ny);
        }
    }
    Ok(sim.set_motion(&positions, &velocities)?)
}

/// Steps of this fraction of the uniform preset's dt_crit in a time, s.
fn steps_of(time: f64, fraction: f64) -> u64 {
    (time / (fraction * 5.289994e-8)) as u64
}

/// 40 J into a sheet of 41 x 41 nodes, until the sphere has left; and 5 J into the 3 in sheet, which must stay whole.
fn impacts() -> impl Iterator<Item = Flight> {
    let small = FRACTIONS.into_iter().map(|fraction| {
        let scene = unchecked(uniform(41, speed(40.0)), fraction);
        let name = format!("40 J impact at {fraction} dt_crit");
        let (expected, low, high) = match fraction {
            f if f <= 0.4 => ("sound: residual below 1 %, v 94.0 m/s", -0.01, 0.01),
            f if f <= 0.5 => ("largest allowed: residual below 3 %, v 94.0 m/s", -0.03, 0.03),
            f if f <= 0.8 => ("outside: energy creep > 1 %, no NaN", 0.01, f64::INFINITY),
            _ => ("outside: a plausible wrong answer, > 5 % energy, no NaN", 0.05, f64::INFINITY),
        };
        Flight {
            text: Box::new(percent),
            ..Flight::new(name, expected, scene, 200_000, move |end| {
                let right = fraction > 0.5 || Ended::near(end.summary.residual_velocity[2], 94.0, 0.005);
                (low..=high).contains(&end.balances.energy) && right && end.latched(Outcome::Exited)
            })
        }
    });
    let full = uniform(105, speed(5.0));
    let large = [
        Flight {
            until: &[],
            text: Box::new(percent),
            long: true,
            ..Flight::new(
                "5 J into the 3 in sheet, 600 us at 0.4 dt_crit",
                "intact, residual below 0.1 %",
                full,
                steps_of(600e-6, 0.4),
                |end| end.summary.failed_segments == 0 && end.balances.energy.abs() < 1e-3,
            )
        },
        Flight {
            until: &[],
            text: Box::new(percent),
            long: true,
            ..Flight::new(
                "5 J into the 3 in sheet, 600 us at 0.7 dt_crit",
                "outside: heats until it tears by itself",
                unchecked(full, 0.7),
                steps_of(600e-6, 0.7),
                |end| end.summary.failed_segments > 0 && end.balances.energy > 1.0,
            )
        },
    ];
    small.chain(large)
}

/// The iteration contracts by (dt/dt_crit)^2 at U_c: beyond the limit it must say so and keep the state.
fn theta_beyond_the_limit() -> Case {
    let check = || {
        let mut scene = unchecked(far(21), 1.2);
        scene.integrator = Integrator::THETA;
        let mut buffers = Buffers::of(&scene)?;
        let mut sim = buffers.sim(&scene)?;
        pluck(&mut sim)?;
        let mut image = vec![0; sim.snapshot_bytes()];
        for _ in 0..1000 {
            sim.save(&mut image)?;
            let (before, step) = (sim.digest(), sim.step_count());
            if let Err(failure) = sim.step() {
                let kept = sim.digest() == before && sim.step_count() == step;
                // The state that was kept goes on: load clears the failure, and the same step fails again.
                sim.load(&image)?;
                let again = sim.digest() == before && sim.step() == Err(Failure::NotConverged);
                let pass = failure == Failure::NotConverged && kept && again;
                let kept = if kept { "state kept" } else { "STATE LOST" };
                return Ok(Answer::plain(format!("{failure}, at step {step}, {kept}"), pass));
            }
        }
        Ok(Answer::plain("converged 1000 times".to_string(), false))
    };
    Case {
        theme: "Time step",
        name: "theta rule at 1.2 dt_crit".to_string(),
        expected: "NotConverged, state kept, again after load".to_string(),
        long: false,
        check: Box::new(check),
    }
}

// ---- stiffness ----

fn stiffness() -> Vec<Case> {
    let theme = "Stiffness";
    vec![
        soft_oscillator().case(theme),
        at_scaled_speed("stiffness x 4^10, dt / 2^10, V x 2^10", 1_048_576.0, true),
        at_scaled_speed("stiffness / 4^10, dt x 2^10, V / 2^10", 1.0 / 1_048_576.0, true),
        at_scaled_speed("stiffness x 1e6, dt / 1e3, V x 1e3", 1e6, false),
        at_scaled_speed("stiffness x 1e-6, dt x 1e3, V / 1e3", 1e-6, false),
    ]
}

/// Every modulus times a factor, the same damage rates.
fn stiffer(scene: Scene, factor: f64) -> Scene {
    changed(scene, |scene| {
        scene.yarn.modulus_mean *= factor;
        scene.yarn.modulus_sd *= factor;
        scene.yarn.damage_slope /= factor;
    })
}

/// Time and place, s and m, at which a sphere on one free node between four held ones (N = 3) turns back: the quartic oscillator,
/// z = ((M + m) V'^2 h^3/(E A))^(1/4) after 1.3110287771 z/V'. Exact for slow impacts, whose yarns stretch little.
pub fn turns_back(scene: &Scene) -> (f64, f64) {
    let (mass, node, h) = (scene.projectile.mass, scene.sheet.node_mass, scene.sheet.spacing);
    let after = scene.projectile.velocity[2] * mass / (mass + node);
    let stiffness = scene.yarn.modulus_mean * scene.sheet.yarn_area;
    let depth = math::sqrt(math::sqrt((mass + node) * after * after * h * h * h / stiffness));
    (1.3110287771 * depth / after, depth)
}

/// A millionth of the stiffness at the usual step, which is 4e-4 dt_crit then.
fn soft_oscillator() -> Flight {
    let scene = changed(stiffer(uniform(3, 1e-3), 1e-6), |scene| {
        scene.time_step = TimeStep::seconds(2e-8);
        // A sphere that passes between the supports.
        scene.projectile.radius = scene.sheet.spacing;
        scene.projectile.position = [0.0, 0.0, -scene.sheet.spacing];
    });
    let (time, depth) = turns_back(&scene);
    Flight {
        long: true,
        until: &[Outcome::Arrested],
        text: Box::new(|end| {
            let deflection = end.fabric.max_deflection;
            format!("stops after {:.4} ms at {:.6} mm", 1e3 * end.summary.time, 1e3 * deflection)
        }),
        ..Flight::new(
            "stiffness x 1e-6 at dt = 2e-8 s",
            format!("stops after {:.4} ms at {:.6} mm (closed form, 1e-4)", 1e3 * time, 1e3 * depth),
            scene,
            20_000_000,
            move |end| {
                let deflection = end.fabric.max_deflection;
                let stops = Ended::near(deflection, depth, 1e-4) && Ended::near(end.summary.time, time, 1e-4);
                stops && end.only(Outcome::Arrested) && end.balances.energy.abs() < 1e-4 && end.balances.momentum < 1e-9
            },
        )
    }
}

/// With E times a factor and all speeds times its root, the same lengths come at the same step counts: to the bit for powers
/// of 4, to rounding before the first failure otherwise.
fn at_scaled_speed(name: &str, factor: f64, exact: bool) -> Case {
    let check = move || {
        let root = math::sqrt(factor);
        let plain = uniform(41, speed(40.0));
        let scene = changed(stiffer(plain, factor), |scene| {
            scene.projectile.velocity[2] *= root;
            scene.force_window /= root;
        });
        // Through 167 failed segments to the bit; otherwise before rounding grows.
        let steps = if exact { 4000 } else { 400 };
        let (mut one, mut other) = (Buffers::of(&plain)?, Buffers::of(&scene)?);
        let (mut one, mut other) = (one.sim(&plain)?, other.sim(&scene)?);
        let start = scale(&other)?;
        one.advance(steps)?;
        other.advance(steps)?;
        let mut positions = [vec![0.0; 3 * one.layout().nodes()], vec![0.0; 3 * one.layout().nodes()]];
        one.copy_positions(&mut positions[0])?;
        other.copy_positions(&mut positions[1])?;
        let h = plain.sheet.spacing;
        let mut difference =
            positions[0].iter().zip(&positions[1]).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs() / h));
        let (v, w) = (one.projectile()?.velocity[2], other.projectile()?.velocity[2] / root);
        difference = difference.max((v - w).abs() / v.abs());
        let failed = one.counters().failed_segments;
        let pass = if exact {
            difference == 0.0 && failed > 0 && failed == other.counters().failed_segments
        } else {
            difference < 1e-12 && failed == 0
        };
        let summary = Summary::of(&other, fabric::OutcomeSet::NONE)?;
        Ok(Answer {
            happened: format!("largest difference {}, {failed} failed", short(difference)),
            pass,
            balances: Some(Balances::of(&summary, start)),
            fmu: fmu::case(&mut other, [0.0; 3], steps)?,
        })
    };
    let expected = if exact {
        "the same bits in units of h and dt, damage included"
    } else {
        "the same for 400 steps, to rounding (1e-12)"
    };
    Case {
        theme: "Stiffness",
        name: name.to_string(),
        expected: expected.to_string(),
        long: false,
        check: Box::new(check),
    }
}

/// A sheet stretched evenly stays where it is: the forces on every free node cancel.
pub fn at_rest_and_taut() -> Flight {
    Flight {
        prepare: Some(|sim| stretch(sim, 1.01)),
        until: &[],
        text: Box::new(|end| format!("fabric moves with {} J", short(end.summary.fabric_kinetic))),
        ..Flight::new(
            "pre-stretched by 1 %, 10^4 steps",
            "stays at rest: below 1e-20 J, nothing fails",
            far(21),
            10_000,
            |end| end.summary.fabric_kinetic < 1e-20 && end.summary.failed_segments == 0,
        )
    }
}
