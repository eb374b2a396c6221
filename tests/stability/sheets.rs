//! Parameters, time steps and sheets at their extremes.

use crate::{ROUNDING, Row, all, changed, near, row, stretch};
use fabric_kernel::{AttachmentKind, Grading, Outcome, OutcomeSet, Scene, StepCheck, TimeStep};
use fabric_tests::{
    between_supports, drawn, positions, reference::length, reference::rest_positions, small_sheet, speed,
};

/// A sheet of N x N under 40 J of the preset sphere.
fn hit(nodes: u32) -> Scene {
    small_sheet(nodes, speed(40.0, 8.4e-3))
}

#[test]
fn huge_and_subnormal_numbers() {
    all(vec![
        row(
            "node mass 1e-20 kg",
            "dt about 8e-15 s, balances closed",
            changed(small_sheet(21, 100.0), |scene| scene.sheet.node_mass = 1e-20),
            20_000,
            |end| (1e-15..1e-14).contains(&end.sim.step_limits().dt) && end.off[0].abs() < 1e-9,
        ),
        row(
            "position 1e300 m away",
            "passed, absorbed exactly 0",
            changed(small_sheet(21, 100.0), |scene| scene.projectile.position[0] = 1e300),
            20_000,
            |end| end.only(Outcome::Passed) && end.contact.work == 0.0,
        ),
        // Contact with every node at once, as under a slab.
        row(
            "radius 1e3 m over a sheet of 29 mm",
            "balances close, under 1 % of the solves given up, none inside by 1e-12 R",
            changed(small_sheet(41, 100.0), |scene| {
                (scene.projectile.radius, scene.projectile.position[2]) = (1e3, -1e3);
            }),
            2000,
            |end| end.few_given_up() && end.outside(1e-12 * 1e3),
        ),
        row(
            "force window subnormal",
            "exits, sound: the window is one step",
            changed(small_sheet(41, 100.0), |scene| scene.force_window = 1e-320),
            100_000,
            |end| end.latched(Outcome::Exited) && end.sound() && end.outside(ROUNDING) && end.contact.force_peak > 0.0,
        ),
        row(
            "scatter of the modulus 1e90 Pa",
            "a step far below the usual one, balances closed",
            changed(small_sheet(21, 100.0), |scene| {
                (scene.yarn.stochastic, scene.yarn.modulus_sd) = (true, 1e90);
                (scene.yarn.damage_slope, scene.yarn.damage_intercept) = (0.0, 230.0);
            }),
            1000,
            |end| end.sim.step_limits().dt < 1e-45 && end.closed(),
        ),
    ]);
}

#[test]
fn steps_that_are_accepted_and_one_that_is_not() {
    let mut rows: Vec<Row> = [(0.1, 0.01), (0.2, 0.01), (0.3, 0.01), (0.4, 0.01), (0.5, 0.03)]
        .into_iter()
        .map(|(fraction, allowed)| {
            let scene = changed(hit(41), |scene| scene.time_step = TimeStep::fraction(fraction));
            let name = format!("40 J at {fraction} dt_crit");
            row(name, "exits at 94.0 m/s, energy within 1 % (0.5: 3 %)", scene, 200_000, move |end| {
                let right = end.off[0].abs() < allowed && near(end.body.velocity[2], 94.0, 0.005);
                right && end.latched(Outcome::Exited)
            })
        })
        .collect();
    let whole = small_sheet(105, speed(5.0, 8.4e-3));
    let unchecked = changed(whole, |scene| {
        (scene.time_step, scene.step_check) = (TimeStep::fraction(0.7), StepCheck::None);
    });
    let steps = |scene: &Scene| (600e-6 / scene.step_limits().unwrap().dt) as u64;
    rows.push(
        row("5 J into the 3 in sheet for 600 us", "whole, energy within 0.1 %", whole, steps(&whole), |end| {
            end.counters.failed_segments == 0 && end.off[0].abs() < 1e-3
        })
        .for_its_steps(),
    );
    rows.push(
        row("the same at 0.7 dt_crit", "heats until it tears by itself", unchecked, steps(&unchecked), |end| {
            end.counters.failed_segments > 0 && end.off[0] > 1.0
        })
        .for_its_steps(),
    );
    all(rows);
}

/// Time and place, s and m, at which a sphere on one free node between four held ones (N = 3) turns back: the
/// quartic oscillator, z = ((M + m) V'^2 h^3/(E A))^(1/4) after 1.3110287771 z/V'. Exact for slow impacts,
/// whose yarns stretch little.
fn turns_back(scene: &Scene) -> (f64, f64) {
    let (mass, node, h) = (scene.projectile.mass, scene.sheet.node_mass, scene.sheet.spacing);
    let after = scene.projectile.velocity[2] * mass / (mass + node);
    let stiffness = scene.yarn.modulus_mean * scene.sheet.yarn_area;
    let depth = ((mass + node) * after * after * h * h * h / stiffness).sqrt().sqrt();
    (1.3110287771 * depth / after, depth)
}

/// The oscillator until it turns back.
fn slow(name: &str, scene: Scene) -> Row {
    let (time, depth) = turns_back(&scene);
    let expected = "turns back when and where the closed form says, to 1e-4";
    let until = Outcome::Arrested.into();
    let check = move |end: &crate::End<'_>| {
        // Outcomes are tested every 64 steps.
        let late = (end.sim.time() - time).abs() < 1e-4 * time + 64.0 * end.sim.step_limits().dt;
        let deep = near(end.body.position[2] - end.sim.scene().projectile.position[2], depth, 1e-4);
        late && deep && end.only(Outcome::Arrested) && end.few_given_up()
    };
    Row { until, ..row(name, expected, scene, 20_000_000, check) }
}

#[test]
fn a_slow_impact() {
    all(vec![slow("V = 1e-3 m/s", small_sheet(3, 1e-3))]);
}

#[test]
#[ignore = "half a minute; cargo xtask verify runs it"]
fn the_slowest_impact_and_the_softest_yarn() {
    // A millionth of the stiffness at the usual step, which is 4e-4 dt_crit then.
    let soft = changed(between_supports(small_sheet(3, 1e-3), 1.0), |scene| {
        scene.yarn.modulus_mean *= 1e-6;
        scene.yarn.damage_slope *= 1e6;
        scene.time_step = TimeStep::seconds(2e-8);
    });
    all(vec![slow("V = 1e-6 m/s", small_sheet(3, 1e-6)), slow("stiffness x 1e-6", soft)]);
}

const KINDS: [AttachmentKind; 3] = [AttachmentKind::TwoSides, AttachmentKind::FourSides, AttachmentKind::Free];

fn strip(nodes: [u32; 2]) -> Scene {
    changed(small_sheet(2, 100.0), |scene| [scene.sheet.nodes_x, scene.sheet.nodes_y] = nodes)
}

fn graded(nodes: u32, half: f64, largest: u32) -> Scene {
    changed(hit(nodes), |scene| {
        let half_width = scene.spacings().map(|h| half * h);
        scene.sheet.grading = Grading { largest, run: 1, half_width, ..scene.sheet.grading };
    })
}

#[test]
fn sheets_of_every_size_and_grading() {
    let loose = changed(small_sheet(2, 100.0), |scene| scene.attachment.kind = AttachmentKind::Free);
    // Four nodes can take no more than in an elastic impact: energy and momentum would not both close.
    let (mass, nodes) = (loose.projectile.mass, 4.0 * loose.sheet.node_mass);
    let elastic = 100.0 * (mass - nodes) / (mass + nodes);
    let mut rows =
        vec![row("2 x 2, none fixed", "sound, no slower than after an elastic impact", loose, 5000, move |end| {
            end.sound() && (elastic..100.0).contains(&end.body.velocity[2]) && end.outside(ROUNDING)
        })];
    for (nodes, kind) in
        [[2, 2], [2, 3], [3, 2], [2, 17], [17, 2]].into_iter().flat_map(|nodes| KINDS.map(|kind| (nodes, kind)))
    {
        for stochastic in [false, true] {
            let scene = changed(strip(nodes), |scene| {
                scene.projectile.velocity[2] = 150.0;
                (scene.attachment.kind, scene.yarn.stochastic) = (kind, stochastic);
            });
            let name = format!("{nodes:?} nodes, {kind:?}, drawn: {stochastic}");
            rows.push(row(name, "momentum to 1e-12", scene, 2000, |end| end.off[1] < 1e-12).for_its_steps());
        }
    }
    for nodes in [[4000, 8], [8, 4000]] {
        let name = format!("{nodes:?} nodes, 100 m/s");
        rows.push(row(name, "sound, none inside, yarns fail", strip(nodes), 2000, |end| {
            end.sound() && end.outside(ROUNDING) && end.counters.failed_segments > 0
        }));
    }
    let quarter = changed(graded(101, 15.0, 8), |scene| {
        (scene.symmetry.mirror_x, scene.symmetry.mirror_y) = (true, true);
    });
    for (name, scene) in [("graded up to 64 yarns", graded(300, 15.0, 64)), ("graded, a quarter", quarter)] {
        rows.push(row(name, "exited, sound", scene, 100_000, |end| end.latched(Outcome::Exited) && end.sound()));
    }
    let segment = graded(100, 0.2, 2);
    rows.push(row("graded, fine part of one segment", "closed", segment, 4000, |end| end.closed()).for_its_steps());
    let plies = changed(hit(41), |scene| scene.sheet.plies = 50);
    rows.push(row("50 lumped plies", "arrested, sound", plies, 100_000, |end| {
        end.only(Outcome::Arrested) && end.sound()
    }));
    all(rows);
}

#[test]
fn sheets_with_a_history() {
    let far = changed(small_sheet(21, 0.0), |scene| scene.projectile.position[2] = -1.0);
    let torn = row("every segment at U = 3", "all failed at once", far, 64, |end| {
        end.counters.failed_segments == end.sim.layout().segments() as u64
    });
    let taut =
        row("stretched by 0.5 %, 1 J", "arrested whole, sound", small_sheet(41, speed(1.0, 8.4e-3)), 100_000, |end| {
            end.only(Outcome::Arrested) && end.sound() && end.counters.failed_segments == 0
        });
    // alpha = exp(-lambda 0.005) = 0.316 everywhere; the whole sheet absorbs 2.9 J.
    let damaged =
        row("damaged to alpha = 0.316, 40 J", "exits, sound, absorbs less than 2.9 J", hit(41), 100_000, |end| {
            end.latched(Outcome::Exited) && end.sound() && end.contact.work < 2.9
        });
    all(vec![
        Row { prepare: |sim| stretch(sim, 3.0), ..torn.for_its_steps() },
        Row { prepare: |sim| stretch(sim, 1.005), ..taut },
        Row { prepare: |sim| sim.set_largest_stretch(&vec![1.035; sim.layout().segments()]).unwrap(), ..damaged },
    ]);
}

#[test]
fn millions_of_steps_in_which_nothing_happens() {
    let past = changed(small_sheet(2, 1.0), |scene| scene.projectile.position[0] = 0.5);
    all(vec![
        // Positions are sums of equal increments, each rounded by up to half an ulp.
        row("10^7 steps of flight past a sheet", "v to the bit, position to 1.2e-9", past, 10_000_000, |end| {
            let place = end.sim.scene().projectile.position[2] + end.sim.time();
            let bits = end.body.velocity == [0.0, 0.0, 1.0] && end.body.position[0] == 0.5;
            let none = end.contact.work == 0.0 && end.energy.residual == 0.0;
            bits && none && end.only(Outcome::Passed) && near(end.body.position[2], place, 1.2e-9)
        })
        .for_its_steps(),
        row("10^6 steps at rest", "no outcome, nothing has moved", small_sheet(11, 0.0), 1_000_000, |end| {
            let body = end.body.position == end.sim.scene().projectile.position && length(end.body.velocity) == 0.0;
            let none =
                end.contact.work == 0.0 && end.energy.residual == 0.0 && end.sim.outcomes().mask == OutcomeSet::NONE;
            body && none && positions(end.sim) == rest_positions(end.sim.scene())
        }),
    ]);
}

/// Ahead of a wave a sheet is at rest or moves by numbers of the processor's normal range, however small.
#[test]
fn nothing_is_subnormal_ahead_of_a_wave() {
    let expected = "the smallest deflection from 1e-93 to 1e-20 spacings, more than 1000 nodes at rest and 300 moving";
    all(vec![row("60 steps on 101 x 101 nodes", expected, drawn(small_sheet(101, 100.0)), 60, |end| {
        let spacing = end.sim.scene().sheet.spacing;
        let deflections = positions(end.sim).into_iter().map(|x| x[2].abs() / spacing);
        let (moving, at_rest): (Vec<f64>, Vec<f64>) = deflections.partition(|z| *z > 0.0);
        let smallest = moving.iter().copied().fold(f64::INFINITY, f64::min);
        (1e-93..1e-20).contains(&smallest) && at_rest.len() > 1000 && moving.len() > 300
    })]);
}
