//! Projectiles: from as light as a node to 10^9 times heavier, from rest to 30 km/s, striking in every way, and spinning free.

use super::flight::{Ended, Flight, changed, ending, turned, uniform};
use super::sheets::loss;
use super::{Answer, Balances, Case, fmu, steps};
use crate::Result;
use crate::event::Summary;
use crate::memory::Buffers;
use fabric::Solid;
use fabric::pose::into_body;
use fabric::pose::{Vector, quaternion, rotate};
use fabric::{Failure, Outcome, Scene, Shape, Sim};

/// A sphere's gap to the nodes is kept to rounding.
const ROUNDING: f64 = 1e-12 * 6.35e-3;
/// All rows of this theme.
pub fn rows() -> Result<Vec<Case>> {
    let mut rows = Vec::new();
    rows.extend(masses().into_iter().map(|flight| flight.case("Masses")));
    rows.extend(velocities().into_iter().map(|flight| flight.case("Velocities")));
    rows.extend(hits()?.into_iter().map(|flight| flight.case("Hits")));
    rows.extend([ten_million_steps_of_flight(), unstable_axis()]);
    Ok(rows)
}

fn masses() -> Vec<Flight> {
    let mut flights: Vec<Flight> = [1.0, 10.0, 1e3, 1e6, 1e9]
        .into_iter()
        .map(|ratio| {
            let scene = changed(uniform(41, 100.0), |scene| scene.projectile.mass = ratio * scene.sheet.node_mass);
            // Up to some 10^4 nodes' mass the sheet throws it back; beyond, it goes through.
            let light = ratio < 1e4;
            let expected = if light { "thrown back, sound" } else { "goes through, sound" };
            Flight {
                text: Box::new(|end| {
                    format!(
                        "{}, {} sweeps, {} unconverged",
                        ending(end),
                        end.summary.most_sweeps,
                        end.summary.unconverged
                    )
                }),
                ..Flight::new(format!("projectile of {ratio:e} nodes' mass"), expected, scene, 100_000, move |end| {
                    let way = end.latched(if light { Outcome::Arrested } else { Outcome::Exited });
                    way && end.sound() && end.outside(ROUNDING)
                })
            }
        })
        .collect();
    flights.push(Flight {
        until: &[],
        text: Box::new(|end| {
            format!("{}, {} sweeps, {} unconverged", ending(end), end.summary.most_sweeps, end.summary.unconverged)
        }),
        ..Flight::new(
            "projectile of 1 mg (15 nodes' mass)",
            "rebounds at -18.1 m/s, contact converges",
            changed(uniform(41, 100.0), |scene| scene.projectile.mass = 1e-6),
            20_000,
            |end| {
                let rebound = Ended::near(end.summary.residual_velocity[2], -18.1, 0.05);
                rebound && end.sound() && end.only(Outcome::Arrested)
            },
        )
    });
    flights
}

fn velocities() -> Vec<Flight> {
    /// Absorbed within 5 %, about half of it lost in impacts, none inside.
    fn fast(end: &Ended<'_>, absorbed: f64, residual: f64) -> bool {
        let summary = end.summary;
        Ended::near(summary.absorbed, absorbed, 0.05)
            && Ended::near(summary.residual_velocity[2], residual, 1e-4)
            && Ended::near(summary.contact_loss, 0.5 * absorbed, 0.1)
            && end.latched(Outcome::Exited)
            && end.outside(ROUNDING)
            && end.sound()
    }
    vec![
        Flight::new("V = 0", "no outcome (TIMEOUT), absorbed 0", uniform(41, 0.0), 20_000, |end| {
            end.summary.outcomes.is_empty() && end.summary.absorbed == 0.0 && end.summary.residual_velocity == [0.0; 3]
        }),
        Flight::new(
            "V = 5e-324 m/s, subnormal",
            "no NaN, absorbed 0 to rounding",
            uniform(41, 5e-324),
            20_000,
            |end| end.summary.absorbed.abs() < 1e-300 && end.failure.is_none(),
        ),
        slow(1e-6),
        slow(1e-3),
        Flight {
            long: true,
            ..Flight::new("V = 1 m/s (N = 41)", "arrested whole, sound", uniform(41, 1.0), 400_000, |end| {
                end.only(Outcome::Arrested) && end.sound() && end.outside(ROUNDING) && end.summary.failed_segments == 0
            })
        },
        Flight {
            text: Box::new(loss),
            ..Flight::new("V = 100 m/s (N = 41)", "exits, sound", uniform(41, 100.0), 100_000, |end| {
                end.latched(Outcome::Exited) && end.sound() && end.outside(ROUNDING)
            })
        },
        Flight {
            text: Box::new(loss),
            ..Flight::new(
                "V = 2000 m/s (N = 41)",
                "exits at 1998.05, absorbed 32.7 J",
                uniform(41, 2000.0),
                100_000,
                |end| fast(end, 32.73, 1998.05),
            )
        },
        Flight {
            text: Box::new(loss),
            ..Flight::new(
                "V = 5000 m/s (N = 41)",
                "exits at 4995.36, absorbed 194.8 J",
                uniform(41, 5000.0),
                100_000,
                |end| fast(end, 194.8, 4995.36),
            )
        },
        Flight {
            text: Box::new(loss),
            ..Flight::new("V = 20000 m/s (N = 41)", "exits, absorbed 3041 J", uniform(41, 2e4), 100_000, |end| {
                Ended::near(end.summary.absorbed, 3041.0, 0.05) && end.latched(Outcome::Exited) && end.sound()
            })
        },
        Flight {
            text: Box::new(loss),
            // As mass swept up times V^2: (3/2)^2 of the row before.
            ..Flight::new("V = 30000 m/s (N = 41)", "exits, absorbed 6840 J (10 %)", uniform(41, 3e4), 100_000, |end| {
                Ended::near(end.summary.absorbed, 6842.0, 0.1) && end.latched(Outcome::Exited) && end.sound()
            })
        },
        Flight {
            text: Box::new(loss),
            ..Flight::new(
                "places for 3 nodes under the sphere",
                "FAULTED: contact_capacity",
                changed(uniform(41, 100.0), |scene| scene.contact_capacity = 3),
                1000,
                |end| end.failure == Some(Failure::ContactCapacity),
            )
        },
        Flight {
            force: [0.0, 0.0, 1e12],
            ..Flight::new(
                "external force 1e12 N",
                "FAULTED: too fast, before any node is skipped",
                uniform(41, 100.0),
                1000,
                |end| end.failure == Some(Failure::TooFast),
            )
        },
    ]
}

/// One node between four yarns under a sphere: the closed form of [`steps::turns_back`], whose time grows as 1/sqrt(V).
fn slow(speed: f64) -> Flight {
    let scene = uniform(3, speed);
    let (time, _) = steps::turns_back(&scene);
    let expected = format!("stops after {:.3} ms (closed form, 1e-4), under 1 % of the solves at the cap", 1e3 * time);
    Flight {
        long: speed < 1e-4,
        until: &[Outcome::Arrested],
        text: Box::new(|end| {
            let (summary, unconverged) = (end.summary, end.summary.unconverged);
            format!("stops after {:.3} ms, {unconverged} of {} solves at the cap", 1e3 * summary.time, summary.steps)
        }),
        ..Flight::new(format!("V = {speed:e} m/s (N = 3)"), expected, scene, 20_000_000, move |end| {
            // Outcomes are tested every 64 steps.
            let late = end.summary.time - time;
            let right = late.abs() < 1e-4 * time + 64.0 * end.summary.dt;
            // Where a node and the body part by less than rounding the sweeps cannot reach their tolerance: counted, no error.
            let few = end.summary.unconverged < end.summary.steps / 100;
            right && end.only(Outcome::Arrested) && end.closed() && few
        })
    }
}

fn hits() -> Result<Vec<Flight>> {
    let balances = |end: &Ended<'_>| {
        let (depth, unconverged) = (end.turning_allows(), end.summary.unconverged);
        format!("{}, spin {:.0} rad/s, turning allows {depth:.1e} m, {unconverged} unconverged", ending(end), end.spin)
    };
    // Under a face as large as the sheet some solves among 1521 nodes end at the cap instead of at 1e-14: counted, no error.
    let wide = |flight: Flight| Flight {
        expected: "balances close, under 1 % of the solves at the cap, no deeper than turning allows".to_string(),
        long: true,
        check: Box::new(|end| {
            let few = end.summary.unconverged < end.summary.steps / 100;
            end.closed() && few && end.outside(end.turning_allows()) && end.summary.absorbed > 0.0
        }),
        ..flight
    };
    let hit = |name: &str, scene: Scene| {
        let turns = scene.projectile.shape != Shape::Sphere;
        let expected = if turns { "sound, no deeper than turning allows" } else { "sound, none inside" };
        Flight {
            text: Box::new(balances),
            until: &[Outcome::Exited],
            ..Flight::new(name, expected, scene, 6000, move |end| {
                let depth = if turns { end.turning_allows() } else { ROUNDING };
                end.sound() && end.outside(depth) && end.summary.absorbed > 0.0
            })
        }
    };
    let cylinder = changed(uniform(41, 100.0), |scene| {
        scene.projectile.shape = Shape::Cylinder;
        scene.projectile.length = 0.02;
    });
    let brick = changed(uniform(41, 100.0), |scene| {
        scene.projectile.shape = Shape::Box;
        scene.projectile.size = [0.01, 0.012, 0.014];
    });
    let slab = changed(uniform(41, 50.0), |scene| {
        scene.projectile.shape = Shape::Box;
        scene.projectile.size = [0.04, 0.04, 0.004];
        scene.projectile.mass = 0.05;
        scene.projectile.position[2] = -0.002;
    });
    let quarter_turn = 0.5 * core::f64::consts::PI;
    let disc = changed(fabric_scene::parse(include_str!("../../scenes/tilted_disc_sector.toml"))?, |scene| {
        scene.yarn.stochastic = false;
        (scene.sheet.nodes_x, scene.sheet.nodes_y) = (61, 61);
    });
    Ok(vec![
        hit(
            "grazing: 300 m/s along the sheet, 10 m/s down on it",
            changed(uniform(41, 10.0), |scene| {
                scene.projectile.position[0] = -0.01;
                scene.projectile.velocity[0] = 300.0;
            }),
        ),
        hit(
            "grazing: the sphere's rim on the outermost free nodes",
            changed(uniform(41, 100.0), |scene| {
                scene.projectile.position[0] =
                    scene.half_size()[0] + scene.projectile.radius - 1.5 * scene.sheet.spacing;
            }),
        ),
        hit("cylinder flat-on", turned(cylinder, [1.0, 0.0, 0.0], 0.0)),
        hit("cylinder edge-on, 45 degrees", turned(cylinder, [1.0, 0.3, 0.0], 0.5 * quarter_turn)),
        hit("cylinder on its side", turned(cylinder, [0.0, 1.0, 0.0], quarter_turn)),
        hit(
            "cylinder tumbling, 3000 rad/s",
            changed(turned(cylinder, [1.0, 0.0, 0.0], 0.4), |scene| {
                scene.projectile.angular_velocity = [3000.0, 500.0, 0.0];
            }),
        ),
        hit("box corner first", turned(brick, [1.0, -1.0, 0.0], 0.955)),
        hit(
            "box tumbling, 5000 rad/s",
            changed(turned(brick, [1.0, 0.2, 0.1], 0.7), |scene| {
                scene.projectile.angular_velocity = [4000.0, -3000.0, 100.0];
            }),
        ),
        hit("turbine disc sector edge-on, 80 m/s", disc),
        wide(hit("slab wider than the sheet, 50 m/s", slab)),
        wide(hit("slab wider than the sheet, tilted by 3 degrees", turned(slab, [1.0, 0.5, 0.0], 0.05))),
    ])
}

/// Positions are sums of equal increments, each rounded: up to half an ulp each.
fn ten_million_steps_of_flight() -> Case {
    let check = || {
        let steps = 10_000_000;
        let scene = changed(uniform(2, 1.0), |scene| scene.projectile.position[0] = 0.5);
        let mut buffers = Buffers::of(&scene)?;
        let mut sim = buffers.sim(&scene)?;
        sim.advance(steps)?;
        let summary = Summary::of(&sim, fabric::OutcomeSet::NONE)?;
        let motion = sim.projectile()?;
        let place = scene.projectile.position[2] + sim.time();
        let off = ((motion.position[2] - place) / place).abs();
        let bits = motion.velocity == scene.projectile.velocity && motion.position[0] == 0.5;
        let passed = summary.outcomes.len() == 1 && summary.latched(Outcome::Passed).is_some();
        let pass = off < 1.2e-9 && bits && passed && summary.absorbed == 0.0 && summary.energy_residual == 0.0;
        let happened = format!("position off by {off:.1e}, v bit-constant: {bits}");
        let start = summary.initial_kinetic_energy;
        Ok(Answer {
            happened,
            pass,
            balances: Some(Balances::of(&summary, start)),
            fmu: fmu::case(&mut sim, [0.0; 3], steps)?,
        })
    };
    Case {
        theme: "Free flight",
        name: "10^7 steps of flight past a 2 x 2 sheet".to_string(),
        expected: "v bit-constant, position to 1.2e-9, passed".to_string(),
        long: true,
        check: Box::new(check),
    }
}

/// A box that spins about its middle axis turns over and over, and keeps energy and angular momentum (Dzhanibekov's effect).
fn unstable_axis() -> Case {
    let check = || {
        let scene = changed(uniform(2, 0.0), |scene| {
            let body = &mut scene.projectile;
            body.shape = Shape::Box;
            body.size = [0.01, 0.02, 0.03];
            body.position = [0.0, 0.0, -0.1];
            body.angular_velocity = [10.0, 1e4, 0.0];
        });
        let mut buffers = Buffers::of(&scene)?;
        let mut sim = buffers.sim(&scene)?;
        let inertia = Solid::of(&scene.projectile).inertia(scene.projectile.mass);
        let spin = |sim: &Sim<'_>| -> Result<(Vector, Vector, f64)> {
            let motion = sim.projectile()?;
            let q = quaternion(motion.orientation);
            let w = into_body(&q, &Vector::from(motion.angular_velocity));
            let momentum = w.component_mul(&Vector::from(inertia));
            Ok((w, rotate(&q, &momentum), 0.5 * w.dot(&momentum)))
        };
        let (_, momentum, energy) = spin(&sim)?;
        let (mut turns, mut up, mut worst) = (0, true, [0.0_f64; 2]);
        for _ in 0..1000 {
            sim.advance(1000)?;
            let (w, l, e) = spin(&sim)?;
            if (w.y > 0.0) != up {
                (up, turns) = (!up, turns + 1);
            }
            worst =
                [worst[0].max(((e - energy) / energy).abs()), worst[1].max((l - momentum).norm() / momentum.norm())];
        }
        let summary = Summary::of(&sim, fabric::OutcomeSet::NONE)?;
        let happened = format!("turned over {turns} times, energy {:.1e}, momentum {:.1e}", worst[0], worst[1]);
        let pass = turns >= 5 && worst.iter().all(|&x| x < 1e-10);
        Ok(Answer {
            happened,
            pass,
            balances: Some(Balances::of(&summary, energy)),
            fmu: fmu::case(&mut sim, [0.0; 3], 1_000_000)?,
        })
    };
    Case {
        theme: "Free flight",
        name: "box spinning about its unstable axis, 10^6 steps".to_string(),
        expected: "turns over; energy and angular momentum to 1e-10".to_string(),
        long: false,
        check: Box::new(check),
    }
}
