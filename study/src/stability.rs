//! Stability: extreme and senseless scenes, each with the outcome it must have.
//!
//! Nothing may end in a silent wrong answer, a panic, a hang or a NaN that passes. A row is either a refusal, which must carry
//! its code and field, or a run, which must meet a stated physical answer with its books closed.

use crate::event::{Summary, length, mask_of};
use crate::memory::Buffers;
use crate::progress::Progress;
use crate::{Result, machine, report};
use clap::Args;
use fabric::yarn::Segment;
use fabric::{AttachmentKind, Code, Drive, Error, Failure, Motion, Outcome, Path as BodyPath};
use fabric::{Scene, Shape, Sim, StepCheck, TimeStep};
use rayon::prelude::*;
use serde::Serialize;
use std::path::PathBuf;

/// Options of `stability`.
#[derive(Args)]
pub struct Options {
    /// All rows: they take seconds.
    #[arg(long, conflicts_with = "smoke")]
    quick: bool,
    /// Without the rows that step for 600 us.
    #[arg(long)]
    smoke: bool,
    /// Folder for stability.csv.
    #[arg(long, value_name = "DIR", default_value = "target/study/stability")]
    out: PathBuf,
}

/// One row of the table.
#[derive(Serialize)]
struct Row {
    case: String,
    expected: String,
    happened: String,
    /// Over the kinetic energy at the start; absent where nothing ran.
    energy_residual: Option<f64>,
    /// Over the momentum at the start; absent where nothing ran.
    momentum_residual: Option<f64>,
    worst_penetration_m: Option<f64>,
    pass: bool,
}

/// A case: how it is called, what must happen, and how to find out.
struct Case {
    name: &'static str,
    expected: String,
    long: bool,
    check: Box<dyn Fn() -> Result<Answer> + Sync + Send>,
}

/// What happened.
struct Answer {
    happened: String,
    pass: bool,
    books: Option<Books>,
}

/// How well the balances closed.
#[derive(Clone, Copy)]
struct Books {
    energy: f64,
    momentum: f64,
    penetration: f64,
}

/// Runs every row, prints and writes. False if one missed.
pub fn run(options: &Options) -> Result<bool> {
    std::fs::create_dir_all(&options.out).map_err(|error| format!("{}: {error}", options.out.display()))?;
    let mut cases = refusals();
    cases.extend(bad_calls());
    cases.extend(damage_law());
    cases.extend(runs());
    cases.retain(|case| !(case.long && options.smoke));

    let wall = machine::Wall::start();
    let progress = Progress::new("stability", cases.len() as u64);
    let rows: Vec<Row> = cases
        .par_iter()
        .map(|case| {
            // A call that should work and is refused misses its row; it does not end the study.
            let answer = (case.check)().unwrap_or_else(|error| Answer {
                happened: format!("error: {error}"),
                pass: false,
                books: None,
            });
            progress.add(1, || case.name.to_string());
            Row {
                case: case.name.to_string(),
                expected: case.expected.clone(),
                happened: answer.happened,
                energy_residual: answer.books.map(|books| books.energy),
                momentum_residual: answer.books.map(|books| books.momentum),
                worst_penetration_m: answer.books.map(|books| books.penetration),
                pass: answer.pass,
            }
        })
        .collect();
    progress.finish();

    print(&rows, wall.seconds());
    let mut writer = csv::Writer::from_path(options.out.join("stability.csv"))?;
    for row in &rows {
        writer.serialize(row)?;
    }
    writer.flush()?;
    println!("written: {}", options.out.display());
    Ok(rows.iter().all(|row| row.pass))
}

fn print(rows: &[Row], wall: f64) {
    let mut table = report::table(&["case", "expected", "happened", "energy", "momentum", "penetration m", ""]);
    for column in [1, 2] {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(comfy_table::CellAlignment::Left);
        }
    }
    let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.1e}"));
    for row in rows {
        table.add_row(vec![
            row.case.clone(),
            row.expected.clone(),
            row.happened.clone(),
            number(row.energy_residual),
            number(row.momentum_residual),
            number(row.worst_penetration_m),
            if row.pass { "ok".to_string() } else { "MISSED".to_string() },
        ]);
    }
    println!("{table}");
    println!("energy and momentum: what the balance does not close by, over kinetic energy and momentum at the start");
    let missed = rows.iter().filter(|row| !row.pass).count();
    println!("{} rows, {missed} missed, {wall:.1} s", rows.len());
}

// ---- refusals ----

/// Scenes that must be refused, with code and field.
fn refusals() -> Vec<Case> {
    use Code::*;
    let nan = f64::NAN;
    let inf = f64::INFINITY;
    vec![
        refused("dt = 0", NotPositive, "dt", |s| s.time_step = TimeStep::Seconds(0.0)),
        refused("dt < 0", NotPositive, "dt", |s| s.time_step = TimeStep::Seconds(-1e-8)),
        refused("dt NaN", NotFinite, "dt", move |s| s.time_step = TimeStep::Seconds(nan)),
        refused("dt infinite", NotFinite, "dt", move |s| s.time_step = TimeStep::Seconds(inf)),
        refused("dt above 0.5 dt_crit", StepTooLarge, "dt", |s| s.time_step = TimeStep::Seconds(2.7e-8)),
        refused("step fraction 0.51", OutOfRange, "step_fraction", |s| s.time_step = TimeStep::Fraction(0.51)),
        refused("node mass 0", NotPositive, "sheet.node_mass", |s| s.sheet.node_mass = 0.0),
        refused("node mass NaN", NotFinite, "sheet.node_mass", move |s| s.sheet.node_mass = nan),
        refused("spacing < 0", NotPositive, "sheet.spacing", |s| s.sheet.spacing = -1e-3),
        refused("yarn area < 0", NotPositive, "sheet.yarn_area", |s| s.sheet.yarn_area = -1e-7),
        refused("modulus 0", NotPositive, "yarn.modulus_mean", |s| s.yarn.modulus_mean = 0.0),
        refused("U_c = 1", OutOfRange, "yarn.critical_stretch", |s| s.yarn.critical_stretch = 1.0),
        refused("alpha_fail < 0", OutOfRange, "yarn.alpha_fail", |s| s.yarn.alpha_fail = -0.01),
        refused("alpha_fail = 1", OutOfRange, "yarn.alpha_fail", |s| s.yarn.alpha_fail = 1.0),
        refused("B = 1", OutOfRange, "yarn.damage_b", |s| s.yarn.damage_b = 1.0),
        refused("A = 0", NotPositive, "yarn.damage_a", |s| s.yarn.damage_a = 0.0),
        refused("A (1 - B) = 1.1", OutOfRange, "yarn.damage_a", |s| s.yarn.damage_a = 1.1),
        refused("lambda < 3", DamageRateTooSmall, "yarn.damage_intercept", |s| s.yarn.damage_intercept = -1107.0),
        refused("one node along x", OutOfRange, "sheet.nodes_x", |s| s.sheet.nodes_x = 1),
        refused("projectile mass 0", NotPositive, "projectile.mass", |s| s.projectile.mass = 0.0),
        refused("lighter than a node", ProjectileTooLight, "projectile.mass", |s| s.projectile.mass = 6e-8),
        refused("R below the spacing", ProjectileTooSmall, "projectile.radius", |s| s.projectile.radius = 7e-4),
        refused("cylinder, L = 0", NotPositive, "projectile.length", |s| {
            s.projectile.shape = Shape::Cylinder;
            s.projectile.length = 0.0;
        }),
        refused("position NaN", NotFinite, "projectile.position", move |s| s.projectile.position[1] = nan),
        refused("velocity infinite", NotFinite, "projectile.velocity", move |s| s.projectile.velocity[2] = inf),
        refused("angular velocity NaN", NotFinite, "projectile.angular_velocity", move |s| {
            s.projectile.angular_velocity[0] = nan;
        }),
        refused("quaternion NaN", NotFinite, "projectile.orientation", move |s| s.projectile.orientation[3] = nan),
        refused("quaternion zero", BadQuaternion, "projectile.orientation", |s| s.projectile.orientation = [0.0; 4]),
        refused("sheet quaternion zero", BadQuaternion, "sheet.orientation", |s| s.sheet.orientation = [0.0; 4]),
        refused("overlap at the start", InitialOverlap, "projectile.position", |s| s.projectile.position[2] += 1e-4),
        refused("V dt > h", ProjectileTooFast, "projectile.velocity", |s| s.projectile.velocity[2] = 3.5e4),
        refused("corner discs overlap", DiscsOverlap, "attachment.disc_radius", |s| {
            s.attachment.kind = AttachmentKind::FourCorners;
            (s.attachment.disc_inset, s.attachment.disc_radius) = (25.4e-3, 19.05e-3);
        }),
        refused("node mass 1e-20 kg at dt 2e-8", StepTooLarge, "dt", |s| {
            s.sheet.node_mass = 1e-20;
            s.time_step = TimeStep::Seconds(2e-8);
        }),
        refused("node mass subnormal", StepLimitUnusable, "sheet.node_mass", |s| s.sheet.node_mass = 1e-320),
        refused("spacing subnormal", StepLimitUnusable, "sheet.node_mass", |s| s.sheet.spacing = 1e-320),
    ]
}

/// The 3 in sheet, uniform, changed so that it must be refused.
fn refused(
    name: &'static str,
    code: Code,
    field: &'static str,
    change: impl Fn(&mut Scene) + Sync + Send + 'static,
) -> Case {
    let check = move || {
        let mut scene = uniform(105, 100.0);
        change(&mut scene);
        let result = Buffers::of(&scene).and_then(|mut buffers| buffers.sim(&scene).map(|_| ()));
        Ok(compare(result, code, field))
    };
    Case { name, expected: refusal_text(code, field), long: false, check: Box::new(check) }
}

fn refusal_text(code: Code, field: &str) -> String {
    format!("refused: {code:?}, {field}")
}

fn compare(result: std::result::Result<(), Error>, code: Code, field: &str) -> Answer {
    match result {
        Ok(()) => Answer { happened: "accepted".to_string(), pass: false, books: None },
        Err(error) => {
            let pass = error.code == code && error.field == field;
            let happened = if pass { error.text().to_string() } else { refusal_text(error.code, error.field) };
            Answer { happened, pass, books: None }
        }
    }
}

/// Calls on a sound simulation that must be refused and change no bit.
fn bad_calls() -> Vec<Case> {
    let motion = |change: fn(&mut Motion)| {
        let mut end = Motion {
            position: [0.0, 0.0, -6.3e-3],
            velocity: [0.0, 0.0, 1.0],
            orientation: [1.0, 0.0, 0.0, 0.0],
            angular_velocity: [0.0; 3],
        };
        change(&mut end);
        BodyPath { first: 0, steps: 100, end }
    };
    let path = |name, code, field, change: fn(&mut Motion)| {
        unchanged(name, code, field, Drive::Prescribed, move |sim| sim.follow(&motion(change), 100))
    };
    vec![
        unchanged("set_motion with a NaN", Code::NotFinite, "positions", Drive::Free, |sim| {
            let mut positions = vec![0.0; 3 * sim.layout().nodes()];
            sim.copy_positions(&mut positions)?;
            positions[17] = f64::NAN;
            let velocities = vec![0.0; positions.len()];
            sim.set_motion(&positions, &velocities)
        }),
        unchanged("external force infinite", Code::NotFinite, "external.force", Drive::Free, |sim| {
            sim.set_external_load([0.0, f64::INFINITY, 0.0], [0.0; 3])
        }),
        path("path with position NaN", Code::NotFinite, "path.position", |end| end.position[0] = f64::NAN),
        path("path with velocity infinite", Code::NotFinite, "path.velocity", |end| end.velocity[0] = f64::INFINITY),
        path("path with quaternion zero", Code::BadQuaternion, "path.orientation", |end| end.orientation = [0.0; 4]),
        path("path faster than h/dt", Code::ProjectileTooFast, "path.velocity", |end| end.position[2] = 1.0),
        unchanged("external load on a prescribed body", Code::WrongDrive, "drive", Drive::Prescribed, |sim| {
            sim.set_external_load([1.0, 0.0, 0.0], [0.0; 3])
        }),
    ]
}

fn unchanged(
    name: &'static str,
    code: Code,
    field: &'static str,
    drive: Drive,
    call: impl Fn(&mut Sim<'_>) -> std::result::Result<(), Error> + Sync + Send + 'static,
) -> Case {
    let check = move || {
        let mut scene = uniform(21, 100.0);
        scene.drive = drive;
        let mut buffers = Buffers::of(&scene)?;
        let mut sim = buffers.sim(&scene)?;
        let before = sim.digest();
        let mut answer = compare(call(&mut sim), code, field);
        if sim.digest() != before {
            answer.pass = false;
            answer.happened += "; STATE CHANGED";
        }
        Ok(answer)
    };
    Case { name, expected: refusal_text(code, field) + ", same digest", long: false, check: Box::new(check) }
}

// ---- the damage law at its edges ----

fn damage_law() -> Vec<Case> {
    let law = Scene::sheet_3in_sphere().damage_law();
    let segment = Segment { modulus: 140.21e9, damage_rate: 230.6 };
    let alpha = move |stretch: f64| law.alpha(segment.damage_rate, fabric::yarn::squared_stretch_excess(stretch));
    let value = |happened: String, pass: bool| Ok(Answer { happened, pass, books: None });
    vec![
        Case {
            name: "U exactly U_c",
            expected: "alpha = 1".to_string(),
            long: false,
            check: Box::new(move || value(format!("alpha = {}", alpha(1.03)), alpha(1.03) == 1.0)),
        },
        Case {
            name: "lambda (U - U_c) > 700, U up to 1e150",
            expected: "alpha = 0".to_string(),
            long: false,
            check: Box::new(move || {
                let values = [5.0, 1e3, 1e100, 1e150].map(alpha);
                value(format!("alpha = {values:?}"), values == [0.0; 4])
            }),
        },
        Case {
            name: "dissipation of one jump to failure",
            expected: "86.6265224 MJ/m^3 (1e-8)".to_string(),
            long: false,
            check: Box::new(move || {
                let mega = 1e-6 * law.dissipated(&segment, 0.0);
                value(format!("{mega:.7} MJ/m^3"), (mega / 86.6265224 - 1.0).abs() < 1e-8)
            }),
        },
    ]
}

// ---- runs ----

/// What a run ended with, for its check.
struct Ended<'a> {
    summary: &'a Summary,
    failure: Option<Failure>,
}

impl Ended<'_> {
    fn near(value: f64, expected: f64, part: f64) -> bool {
        (value - expected).abs() <= part * expected.abs()
    }

    fn only(&self, outcome: Outcome) -> bool {
        self.summary.outcomes.len() == 1 && self.summary.latched(outcome).is_some()
    }

    fn momentum_closes(&self, tolerance: f64) -> bool {
        let start = self.summary.initial_momentum;
        self.summary.momentum_residual <= tolerance * start
    }
}

type Check = fn(&Ended<'_>) -> bool;
type Text = fn(&Summary) -> String;

/// A run of a scene and what must be true at its end.
struct Flight {
    name: &'static str,
    expected: &'static str,
    long: bool,
    scene: Scene,
    prepare: fn(&mut Sim<'_>) -> Result<()>,
    until: &'static [Outcome],
    steps: u64,
    check: Check,
    text: Text,
}

impl Flight {
    fn new(name: &'static str, expected: &'static str, scene: Scene, steps: u64, check: Check) -> Flight {
        let until: &[Outcome] = &[Outcome::Arrested, Outcome::Exited, Outcome::Passed];
        Flight { name, expected, long: false, scene, prepare: |_| Ok(()), until, steps, check, text: ending }
    }

    fn case(self) -> Case {
        let (name, expected, long) = (self.name, self.expected.to_string(), self.long);
        Case { name, expected, long, check: Box::new(move || self.fly()) }
    }

    fn fly(&self) -> Result<Answer> {
        let mut buffers = Buffers::of(&self.scene)?;
        let mut sim = buffers.sim(&self.scene)?;
        (self.prepare)(&mut sim)?;
        let mask = mask_of(self.until);
        if let Err(failure) = sim.advance_until(mask, self.steps) {
            // Read-outs refuse after a failure; a fresh simulation stands for them.
            sim.reset();
            let summary = Summary::of(&sim, mask)?;
            let pass = (self.check)(&Ended { summary: &summary, failure: Some(failure) });
            return Ok(Answer { happened: format!("FAULTED: {failure}"), pass, books: None });
        }
        let summary = Summary::of(&sim, mask)?;
        let momentum = summary.initial_momentum;
        let books = Books {
            energy: summary.energy_residual_relative,
            momentum: if momentum > 0.0 { summary.momentum_residual / momentum } else { summary.momentum_residual },
            penetration: summary.worst_penetration,
        };
        let finite = [summary.absorbed, summary.energy_residual, summary.momentum_residual, summary.fabric_kinetic];
        let finite = finite.iter().chain(&summary.residual_velocity).all(|value| value.is_finite());
        let pass = finite && (self.check)(&Ended { summary: &summary, failure: None });
        Ok(Answer { happened: (self.text)(&summary), pass, books: Some(books) })
    }
}

/// How the run ended, in a few words.
fn ending(summary: &Summary) -> String {
    let (speed, absorbed) = (summary.residual_velocity[2], summary.absorbed);
    format!("{}, v {speed:.2} m/s, absorbed {absorbed:.4} J, {} failed", summary.ended_by, summary.failed_segments)
}

fn uniform(nodes: u32, speed: f64) -> Scene {
    let mut scene = Scene::sheet_3in_sphere();
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (nodes, nodes);
    scene.yarn.stochastic = false;
    scene.projectile.velocity = [0.0, 0.0, speed];
    scene
}

/// Speed of the preset sphere with this kinetic energy, m/s.
fn speed(energy: f64) -> f64 {
    (2.0 * energy / Scene::sheet_3in_sphere().projectile.mass).sqrt()
}

fn changed(mut scene: Scene, change: impl Fn(&mut Scene)) -> Scene {
    change(&mut scene);
    scene
}

fn unchecked(scene: Scene, fraction: f64) -> Scene {
    changed(scene, |scene| {
        scene.time_step = TimeStep::Fraction(fraction);
        scene.step_check = StepCheck::None;
    })
}

fn runs() -> Vec<Case> {
    let flights = [steps_and_energies(), sheets_and_starts(), fast_and_light()];
    flights.into_iter().flatten().map(Flight::case).collect()
}

/// Why the step is limited: energy created above the limit, without any NaN.
fn steps_and_energies() -> Vec<Flight> {
    let created: Check = |end| end.summary.energy_residual_relative > 0.05;
    let percent: Text = |summary| {
        let (residual, speed) = (100.0 * summary.energy_residual_relative, summary.residual_velocity[2]);
        format!("{residual:+.2} % energy, v {speed:.2} m/s, {} failed", summary.failed_segments)
    };
    let full = uniform(105, speed(5.0));
    let small = uniform(41, speed(40.0));
    // 600 us whatever comes.
    let rest = |fraction: f64| (600e-6 / (fraction * 5.289994e-8)) as u64;
    vec![
        Flight {
            until: &[],
            text: percent,
            long: true,
            ..Flight::new("5 J sheet, 600 us at 0.4 dt_crit", "intact, residual below 0.1 %", full, rest(0.4), |end| {
                end.summary.failed_segments == 0 && end.summary.energy_residual_relative.abs() < 1e-3
            })
        },
        Flight {
            until: &[],
            text: percent,
            long: true,
            ..Flight::new(
                "5 J sheet, 600 us at 0.7, unchecked",
                "plausible garbage: tears by itself",
                unchecked(full, 0.7),
                rest(0.7),
                |end| end.summary.failed_segments > 0 && end.summary.energy_residual_relative > 1.0,
            )
        },
        Flight {
            text: percent,
            ..Flight::new("N = 41, 40 J at 0.4 dt_crit", "residual below 1 %, v 94.0", small, 100_000, |end| {
                let summary = end.summary;
                summary.energy_residual_relative.abs() < 0.01 && Ended::near(summary.residual_velocity[2], 94.0, 0.005)
            })
        },
        Flight {
            text: percent,
            ..Flight::new(
                "N = 41, 40 J at 0.9, unchecked",
                "plausible garbage: > 5 % energy, no NaN",
                unchecked(small, 0.9),
                100_000,
                created,
            )
        },
        Flight {
            text: percent,
            ..Flight::new(
                "N = 41, 40 J at 1.2, unchecked",
                "plausible garbage: > 5 % energy, no NaN",
                unchecked(small, 1.2),
                100_000,
                created,
            )
        },
    ]
}

fn sheets_and_starts() -> Vec<Flight> {
    let no_work: Check =
        |end| end.only(Outcome::Passed) && end.summary.absorbed == 0.0 && end.summary.failed_segments == 0;
    let two = changed(uniform(2, 100.0), |scene| scene.attachment.kind = AttachmentKind::TwoSides);
    let on_node = changed(two, |scene| {
        let half = scene.half_size();
        scene.projectile.position = [half[0], half[1], 0.0];
    });
    vec![
        Flight::new("all nodes fixed (2 x 2)", "passed, absorbed exactly 0", two, 100_000, no_work),
        Flight::new("sphere centre on a (fixed) node", "passed, absorbed exactly 0", on_node, 100_000, no_work),
        Flight {
            text: |summary| {
                let v = summary.residual_velocity;
                format!("v = {:.1e}, {:.1e}, {:.4} m/s", v[0], v[1], v[2])
            },
            ..Flight::new(
                "sphere centre over a node (N = 41, 3 J)",
                "straight on: |vx|, |vy| < 1e-9 vz",
                uniform(41, speed(3.0)),
                2000,
                |end| {
                    let v = end.summary.residual_velocity;
                    v[0].abs() < 1e-9 * v[2].abs() && v[1].abs() < 1e-9 * v[2].abs()
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
        Flight::new("V0 = 0", "no outcome (TIMEOUT), absorbed 0", uniform(41, 0.0), 20_000, |end| {
            end.summary.outcomes.is_empty() && end.summary.absorbed == 0.0 && end.summary.residual_velocity == [0.0; 3]
        }),
        Flight {
            until: &[],
            ..Flight::new(
                "no fixed node (N = 41, 40 J)",
                "momentum kept to 1e-12",
                changed(uniform(41, speed(40.0)), |scene| scene.attachment.kind = AttachmentKind::Free),
                3000,
                |end| end.momentum_closes(1e-12) && length(end.summary.support_impulse) == 0.0,
            )
        },
        Flight {
            prepare: |sim| Ok(sim.set_largest_stretch(&vec![2.0; sim.layout().segments()])?),
            ..Flight::new(
                "all segments dead (N = 41, 40 J)",
                "exited, supports feel 0, momentum 1e-12",
                uniform(41, speed(40.0)),
                100_000,
                |end| {
                    let summary = end.summary;
                    let dead = summary.failed_segments == summary.segments && summary.support_impulses == [[0.0; 3]; 4];
                    dead && summary.latched(Outcome::Exited).is_some() && end.momentum_closes(1e-12)
                },
            )
        },
        Flight {
            prepare: |sim| stretched(sim, 3.0),
            until: &[],
            ..Flight::new("every segment at U = 3 at the start", "all failed at once", far(21), 64, |end| {
                end.summary.failed_segments == end.summary.segments
            })
        },
        Flight {
            prepare: |sim| stretched(sim, 1e160),
            until: &[],
            ..Flight::new("positions 1e160 h apart", "FAULTED, not a NaN that passes", far(21), 64, |end| {
                end.failure == Some(Failure::NonFinite)
            })
        },
        Flight::new(
            "node mass 1e-20 kg at 0.4 dt_crit",
            "accepted, dt about 8e-15 s, books closed",
            changed(uniform(21, 100.0), |scene| scene.sheet.node_mass = 1e-20),
            20_000,
            |end| {
                let summary = end.summary;
                (1e-15..1e-14).contains(&summary.dt) && summary.energy_residual_relative.abs() < 1e-9
            },
        ),
    ]
}

/// A sheet without projectile, four sides held.
fn far(nodes: u32) -> Scene {
    changed(uniform(nodes, 0.0), |scene| scene.projectile.position[2] = -1.0)
}

/// Every position times `factor`.
fn stretched(sim: &mut Sim<'_>, factor: f64) -> Result<()> {
    let mut positions = vec![0.0; 3 * sim.layout().nodes()];
    sim.copy_positions(&mut positions)?;
    positions.iter_mut().for_each(|x| *x *= factor);
    let velocities = vec![0.0; positions.len()];
    Ok(sim.set_motion(&positions, &velocities)?)
}

fn fast_and_light() -> Vec<Flight> {
    let loss: Text = |summary| {
        let (speed, absorbed) = (summary.residual_velocity[2], summary.absorbed);
        format!(
            "{}, v {speed:.2} m/s, absorbed {absorbed:.2} J, contact loss {:.2} J",
            summary.ended_by, summary.contact_loss
        )
    };
    /// Absorbed within 5 %, about half of it lost in impacts, none inside.
    fn fast(end: &Ended<'_>, absorbed: f64, residual: f64) -> bool {
        let summary = end.summary;
        Ended::near(summary.absorbed, absorbed, 0.05)
            && Ended::near(summary.residual_velocity[2], residual, 1e-4)
            && Ended::near(summary.contact_loss, 0.5 * absorbed, 0.1)
            && summary.latched(Outcome::Exited).is_some()
    }
    vec![
        Flight {
            text: loss,
            ..Flight::new(
                "V = 2000 m/s (N = 41)",
                "exits at 1998.05, absorbed 32.7 J",
                uniform(41, 2000.0),
                100_000,
                |end| fast(end, 32.73, 1998.05),
            )
        },
        Flight {
            text: loss,
            ..Flight::new(
                "V = 5000 m/s (N = 41)",
                "exits at 4995.36, absorbed 194.8 J",
                uniform(41, 5000.0),
                100_000,
                |end| fast(end, 194.8, 4995.36),
            )
        },
        Flight {
            text: loss,
            ..Flight::new("V = 20000 m/s (N = 41)", "exits, absorbed 3041 J", uniform(41, 2e4), 100_000, |end| {
                Ended::near(end.summary.absorbed, 3041.0, 0.05) && end.summary.latched(Outcome::Exited).is_some()
            })
        },
        Flight {
            until: &[],
            text: |summary| {
                format!("{}, {} sweeps, {} unconverged", ending(summary), summary.most_sweeps, summary.unconverged)
            },
            ..Flight::new(
                "projectile of 1 mg (15 nodes' mass)",
                "rebounds at -18.1 m/s, contact converges",
                changed(uniform(41, 100.0), |scene| scene.projectile.mass = 1e-6),
                20_000,
                |end| {
                    let summary = end.summary;
                    let rebound = Ended::near(summary.residual_velocity[2], -18.1, 0.05);
                    rebound && summary.unconverged == 0 && end.only(Outcome::Arrested)
                },
            )
        },
    ]
}
