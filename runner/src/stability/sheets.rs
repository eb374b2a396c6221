//! Sheets: sizes, supports, dead, stretched and damaged ones, plies, mirror planes, and the sheet that nothing touches.

use super::flight::{Ended, Flight, changed, ending, far, scale, short, speed, stretch, uniform};
use super::{Answer, Balances, Case, fmu, steps};
use crate::event::Summary;
use crate::memory::Buffers;
use fabric::math::length;
use fabric::{AttachmentKind, Failure, Outcome, Scene, Sim};

/// All rows of this theme.
pub fn rows() -> Vec<Case> {
    let mut rows: Vec<Case> =
        [supports(), histories(), gradings()].into_iter().flatten().map(|flight| flight.case("Sheets")).collect();
    rows.push(long_sheets());
    rows.push(plies());
    rows.push(quarter());
    rows.push(a_million_steps_at_rest());
    rows
}

fn supports() -> Vec<Flight> {
    let no_work =
        |end: &Ended<'_>| end.only(Outcome::Passed) && end.summary.absorbed == 0.0 && end.summary.failed_segments == 0;
    let stopped = |name: &str, scene: Scene| {
        Flight::new(name, "arrested, all 42 J lost, none inside", scene, 100_000, |end| {
            let lost = Ended::near(end.summary.absorbed, 42.0, 1e-12);
            end.only(Outcome::Arrested) && lost && end.closed() && end.outside(1e-12 * 6.35e-3)
        })
    };
    let two = changed(uniform(2, 100.0), |scene| scene.attachment.kind = AttachmentKind::TwoSides);
    let on_node = changed(two, |scene| {
        let half = scene.half_size();
        scene.projectile.position = [half[0], half[1], -scene.projectile.radius];
    });
    let loose = changed(uniform(2, 100.0), |scene| scene.attachment.kind = AttachmentKind::Free);
    let elastic = {
        // Four nodes can take no more than in an elastic impact: energy and momentum would not both close.
        let (mass, nodes) = (loose.projectile.mass, 4.0 * loose.sheet.node_mass);
        100.0 * (mass - nodes) / (mass + nodes)
    };
    vec![
        stopped("all nodes fixed (2 x 2)", two),
        stopped("sphere on a fixed node of a corner", on_node),
        Flight::new("2 x 2, none fixed", format!("sound, v between {elastic:.5} and 100"), loose, 5000, move |end| {
            let v = end.summary.residual_velocity[2];
            end.sound() && v >= elastic && v < 100.0 && end.outside(1e-12 * 6.35e-3)
        }),
        Flight {
            text: Box::new(|end| {
                let v = end.summary.residual_velocity;
                format!("v = {:.1e}, {:.1e}, {:.4} m/s", v[0], v[1], v[2])
            }),
            ..Flight::new(
                "sphere centre over a node (N = 41, 3 J)",
                "straight on: |vx|, |vy| < 1e-9 vz",
                uniform(41, speed(3.0)),
                2000,
                |end| {
                    let v = end.summary.residual_velocity;
                    v[0].abs() < 1e-9 * v[2].abs() && v[1].abs() < 1e-9 * v[2].abs() && end.sound()
                },
            )
        },
        Flight::new(
            "projectile misses",
            "passed, absorbed exactly 0",
            changed(uniform(41, 100.0), |scene| scene.projectile.position[0] = 0.05),
            100_000,
            no_work,
        ),
        Flight {
            long: true,
            ..Flight::new(
                "4000 x 8 nodes, 100 m/s",
                "sound, none inside, yarns fail",
                strip([4000, 8], [0.0, 0.0, 100.0]),
                2000,
                |end| end.sound() && end.outside(1e-12 * 6.35e-3) && end.summary.failed_segments > 0,
            )
        },
        Flight {
            until: &[],
            ..Flight::new(
                "no fixed node (N = 41, 40 J)",
                "momentum kept to 1e-12",
                changed(uniform(41, speed(40.0)), |scene| scene.attachment.kind = AttachmentKind::Free),
                3000,
                |end| end.balances.momentum < 1e-12 && length(end.summary.support_impulse) == 0.0,
            )
        },
    ]
}

/// Graded networks: coarse beyond reason, fine for a single segment, hit where they are coarse, and cut by mirror planes.
fn gradings() -> Vec<Flight> {
    let graded = |nodes: u32, velocity: f64, half: f64, largest: u32| {
        changed(uniform(nodes, velocity), |scene| {
            let half_width = scene.spacings().map(|h| half * h);
            scene.sheet.grading = fabric::Grading { largest, run: 1, half_width, ..scene.sheet.grading };
        })
    };
    let sound = |end: &Ended<'_>| end.latched(Outcome::Exited) && end.sound();
    vec![
        Flight::new(
            "graded up to 64 yarns (N = 300, 40 J)",
            "exited, sound",
            graded(300, speed(40.0), 15.0, 64),
            100_000,
            sound,
        ),
        Flight::new(
            "graded, a quarter by mirror planes (N = 101, 40 J)",
            "exited, sound",
            changed(graded(101, speed(40.0), 15.0, 8), |scene| {
                (scene.symmetry.mirror_x, scene.symmetry.mirror_y) = (true, true)
            }),
            100_000,
            sound,
        ),
        Flight {
            until: &[],
            ..Flight::new(
                "graded, fine part of one segment (N = 100, 40 J)",
                "balances close, no NaN",
                graded(100, speed(40.0), 0.2, 2),
                4000,
                |end| end.closed(),
            )
        },
        Flight {
            until: &[],
            text: Box::new(|end| format!("{}, told in {} passes", ending(end), end.summary.beyond_fine)),
            ..Flight::new(
                "graded, hit beside the fine part (N = 101, 40 J)",
                "balances close, and the read-out tells",
                changed(graded(101, speed(40.0), 8.0, 16), |scene| scene.projectile.position[0] = 0.02),
                4000,
                |end| end.closed() && end.summary.beyond_fine > 0,
            )
        },
    ]
}

fn histories() -> Vec<Flight> {
    vec![
        Flight {
            prepare: Some(|sim| Ok(sim.set_largest_stretch(&vec![2.0; sim.layout().segments()])?)),
            ..Flight::new(
                "all segments dead (N = 41, 40 J)",
                "exited, supports feel 0, momentum 1e-12",
                uniform(41, speed(40.0)),
                100_000,
                |end| {
                    let summary = end.summary;
                    let dead = summary.failed_segments == summary.segments && summary.support_impulses == [[0.0; 3]; 4];
                    dead && end.latched(Outcome::Exited) && end.balances.momentum < 1e-12
                },
            )
        },
        Flight {
            prepare: Some(|sim| stretch(sim, 3.0)),
            until: &[],
            ..Flight::new(
                "every segment at U = 3 at the start",
                "all failed at once, their energy lost",
                far(21),
                64,
                |end| end.summary.failed_segments == end.summary.segments,
            )
        },
        Flight {
            prepare: Some(|sim| stretch(sim, 1e28)),
            until: &[],
            ..Flight::new("positions 1e28 h apart", "FAULTED, not a NaN that passes", far(21), 64, |end| {
                end.failure == Some(Failure::NonFinite)
            })
        },
        steps::at_rest_and_taut(),
        Flight {
            prepare: Some(|sim| stretch(sim, 1.005)),
            ..Flight::new(
                "pre-stretched by 0.5 %, 1 J (N = 41)",
                "arrested whole, residual below 1 %",
                uniform(41, speed(1.0)),
                100_000,
                |end| end.only(Outcome::Arrested) && end.sound() && end.summary.failed_segments == 0,
            )
        },
        Flight {
            // alpha = exp(-lambda 0.005) = 0.316 everywhere.
            prepare: Some(|sim| Ok(sim.set_largest_stretch(&vec![1.035; sim.layout().segments()])?)),
            ..Flight::new(
                "pre-damaged to alpha = 0.316, 40 J",
                "exits, residual below 1 %, absorbs less than the whole sheet's 2.9 J",
                uniform(41, speed(40.0)),
                100_000,
                |end| end.latched(Outcome::Exited) && end.sound() && end.summary.absorbed < 2.9,
            )
        },
        Flight::new(
            "50 plies, 40 J (N = 41)",
            "arrested, residual below 1 %",
            changed(uniform(41, speed(40.0)), |scene| scene.sheet.plies = 50),
            100_000,
            |end| end.only(Outcome::Arrested) && end.sound(),
        ),
    ]
}

/// Two scenes that must move alike: the largest difference of the projectiles' velocities over their speed.
fn pair(
    one: &Scene,
    other: &Scene,
    count: u64,
    alike: fn(&Sim<'_>, &Sim<'_>) -> crate::Result<f64>,
) -> crate::Result<(f64, Summary, Balances, Option<fmu::FmuCase>)> {
    let (mut first, mut second) = (Buffers::of(one)?, Buffers::of(other)?);
    let (mut first, mut second) = (first.sim(one)?, second.sim(other)?);
    let start = scale(&second)?;
    first.advance(count)?;
    second.advance(count)?;
    let summary = Summary::of(&second, fabric::OutcomeSet::NONE)?;
    let balances = Balances::of(&summary, start);
    Ok((alike(&first, &second)?, summary, balances, fmu::case(&mut second, [0.0; 3], count)?))
}

/// A strip of a few nodes by thousands, four sides held, under the sphere.
fn strip(nodes: [u32; 2], velocity: [f64; 3]) -> Scene {
    changed(uniform(2, 0.0), |scene| {
        [scene.sheet.nodes_x, scene.sheet.nodes_y] = nodes;
        scene.projectile.velocity = velocity;
    })
}

/// 4000 x 8 and 8 x 4000 nodes under a sphere wider than the strip: one answer, turned by a right angle.
fn long_sheets() -> Case {
    let check = || {
        let (one, other) = (strip([4000, 8], [3.0, 1.0, 60.0]), strip([8, 4000], [1.0, 3.0, 60.0]));
        let (difference, summary, balances, fmu) = pair(&one, &other, 300, |one, other| {
            let (v, w) = (one.projectile()?.velocity, other.projectile()?.velocity);
            Ok(length([v[0] - w[1], v[1] - w[0], v[2] - w[2]]) / length(v))
        })?;
        let sound =
            balances.energy.abs() < 0.01 && balances.momentum < 1e-9 && summary.worst_penetration <= 1e-12 * 6.35e-3;
        let happened = format!(
            "difference {}, absorbed {} J, {} failed",
            short(difference),
            short(summary.absorbed),
            summary.failed_segments
        );
        Ok(Answer {
            happened,
            pass: sound && difference < 1e-12 && summary.failed_segments == 0,
            balances: Some(balances),
            fmu,
        })
    };
    Case {
        theme: "Sheets",
        name: "4000 x 8 against 8 x 4000 nodes".to_string(),
        expected: "the same for 300 steps, turned (1e-12), sound".to_string(),
        long: false,
        check: Box::new(check),
    }
}

/// Mass and area of n plies are n times one ply's: with the projectile n times heavier nothing moves differently.
fn plies() -> Case {
    let check = || {
        let one = uniform(41, speed(40.0));
        let other = changed(one, |scene| {
            scene.sheet.plies = 64;
            scene.projectile.mass *= 64.0;
        });
        let (difference, summary, balances, fmu) = pair(&one, &other, 4000, |one, other| {
            let (v, w) = (one.projectile()?.velocity, other.projectile()?.velocity);
            let failed = one.counters().failed_segments == other.counters().failed_segments;
            Ok(if failed { length([v[0] - w[0], v[1] - w[1], v[2] - w[2]]) } else { f64::INFINITY })
        })?;
        let happened = format!("difference {}, {} failed", short(difference), summary.failed_segments);
        Ok(Answer { happened, pass: difference == 0.0 && summary.failed_segments > 0, balances: Some(balances), fmu })
    };
    Case {
        theme: "Sheets",
        name: "64 plies under a sphere 64 times heavier".to_string(),
        expected: "the bits of one ply, damage included".to_string(),
        long: false,
        check: Box::new(check),
    }
}

/// A quarter model against the whole sheet, before the first failure.
fn quarter() -> Case {
    let check = || {
        let one = uniform(41, speed(3.0));
        let other = changed(one, |scene| (scene.symmetry.mirror_x, scene.symmetry.mirror_y) = (true, true));
        let (difference, summary, balances, fmu) = pair(&one, &other, 800, |one, other| {
            let (v, w) = (one.projectile()?.velocity[2], other.projectile()?.velocity[2]);
            let (a, b) = (one.contact()?.work, other.contact()?.work);
            Ok(((v - w) / v).abs().max(((a - b) / a).abs()))
        })?;
        let sound = balances.energy.abs() < 0.01 && balances.momentum < 1e-9;
        let happened = format!("difference {}, {} failed", short(difference), summary.failed_segments);
        Ok(Answer { happened, pass: sound && difference < 1e-12, balances: Some(balances), fmu })
    };
    Case {
        theme: "Sheets",
        name: "quarter model against the whole (N = 41, 3 J)".to_string(),
        expected: "velocity and work the same for 800 steps (1e-12)".to_string(),
        long: false,
        check: Box::new(check),
    }
}

/// Nothing moves, so nothing may change: of a saved image only the counts of steps and its checksum.
fn a_million_steps_at_rest() -> Case {
    let check = || {
        let scene = uniform(11, 0.0);
        let mut buffers = Buffers::of(&scene)?;
        let mut sim = buffers.sim(&scene)?;
        let image = |sim: &Sim<'_>| -> crate::Result<Vec<u64>> {
            let mut bytes = vec![0; sim.snapshot_bytes()];
            sim.save(&mut bytes)?;
            Ok(bytes.as_chunks::<8>().0.iter().map(|word| u64::from_le_bytes(*word)).collect())
        };
        // The first step sets the marks of the contact search: the nodes under the sphere just touch it.
        sim.advance(64)?;
        let before = image(&sim)?;
        sim.advance(1_000_000)?;
        let after = image(&sim)?;
        let changed = before.iter().zip(&after).filter(|(a, b)| a != b).count();
        let summary = Summary::of(&sim, fabric::OutcomeSet::NONE)?;
        let balances = Balances::of(&summary, 0.0);
        let pass =
            changed == 2 && summary.absorbed == 0.0 && summary.energy_residual == 0.0 && summary.outcomes.is_empty();
        let happened = format!("{changed} of {} words differ, {}", before.len(), summary.ended_by);
        Ok(Answer { happened, pass, balances: Some(balances), fmu: fmu::case(&mut sim, [0.0; 3], 1_000_064)? })
    };
    Case {
        theme: "Sheets",
        name: "10^6 steps at rest (V = 0)".to_string(),
        expected: "no outcome; only the step count and the checksum change".to_string(),
        long: true,
        check: Box::new(check),
    }
}

/// Used by the flights of [`super::bodies`] too.
pub fn loss(end: &Ended<'_>) -> String {
    format!("{}, contact loss {} J", ending(end), short(end.summary.contact_loss))
}
