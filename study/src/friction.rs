//! What friction between yarn and projectile does: energy absorbed over the impact velocity, and the ballistic limit, against the coefficient.
//!
//! Three cases: the paper's sphere on its 3 in sheet of drawn yarn, a sphere on a sheet of Kevlar KM2, style S706, and the same sphere on a pack
//! of five separate plies of it, as `plies.rs` has them: 60 mm wide, 0.1 mm apart, a bar for two yarns. The plies do not rub on each other.
//! The pack is also made twice as wide: energies above the limit depend on it with friction.
//! Runs of an ensemble differ by the seed of the draws and by where in a cell of the network the sphere strikes: the place is what a shot does
//! not control.
//! The ballistic limit of one run number is found by bisection; their mean stands for V50.
//! Limit: beyond the first failure the model is chaotic, so a run is one sample; bisection finds one of its crossings.
//! `python3 -m reports friction` makes means with intervals of it, and docs/tables/friction.md.

use crate::effort::{self, Effort};
use crate::hits::{Impact, each, impact, limit, shot};
use crate::progress::Progress;
use crate::table::{Cell, Table};
use crate::{Result, plies, report, say};
use clap::Args;
use fabric::{Scene, StepAfterFailure};
use std::path::PathBuf;

/// Options of `friction`.
#[derive(Args)]
pub struct Options {
    #[command(flatten)]
    flags: effort::Flags,
    /// Folder for friction.csv and friction_limits.csv.
    #[arg(long, value_name = "DIR", default_value = "target/study/friction")]
    out: PathBuf,
}

const COEFFICIENTS: [f64; 5] = [0.0, 0.1, 0.2, 0.3, 0.5];
/// Time after which an impact is given up, s.
const LONGEST: f64 = 6e-4;
const PACK: &str = "pack of five separate plies of Kevlar KM2 S706, 0.69 g sphere, four sides";
const WIDE_PACK: &str = "the same pack, twice as wide";

/// A sheet and its sphere.
struct Case {
    name: &'static str,
    scene: Scene,
    /// About the ballistic limit, m/s; None if it is not searched.
    guess: Option<f64>,
    /// Velocities above it, m/s.
    velocities: Vec<f64>,
    /// Runs in each mean, if all of the study is computed.
    runs: u64,
}

fn cases(smoke: bool) -> Result<Vec<Case>> {
    let mut paper = Scene::sheet_3in_sphere();
    if smoke {
        (paper.sheet.nodes_x, paper.sheet.nodes_y) = (21, 21);
    }
    let speed = |energy: f64| (2.0 * energy / paper.projectile.mass).sqrt();
    let energies: &[f64] = if smoke { &[40.0] } else { &[20.0, 40.0, 80.0, 160.0, 320.0] };
    let velocities = energies.iter().map(|energy| speed(*energy)).collect();
    let mut cases = vec![Case {
        name: "paper's sphere, 3 in, four sides",
        scene: paper,
        guess: Some(if smoke { 20.0 } else { 55.0 }),
        velocities,
        runs: 6,
    }];
    if !smoke {
        let scene = fabric_scene::parse(include_str!("../scenes/kevlar_km2_s706.toml"))?;
        let velocities = vec![150.0, 200.0, 300.0, 450.0, 600.0];
        cases.push(Case {
            name: "Kevlar KM2 S706, 0.69 g sphere, four sides",
            scene,
            guess: Some(135.0),
            velocities,
            runs: 6,
        });
    }
    let velocities = if smoke { vec![315.0] } else { vec![315.0, 442.0] };
    let pack = plies::separate(5, smoke)?;
    cases.push(Case { name: PACK, scene: pack, guess: Some(210.0), velocities: velocities.clone(), runs: 12 });
    let mut wide = pack;
    (wide.sheet.nodes_x, wide.sheet.nodes_y) = (2 * pack.sheet.nodes_x - 1, 2 * pack.sheet.nodes_y - 1);
    cases.push(Case { name: WIDE_PACK, scene: wide, guess: None, velocities, runs: 6 });
    Ok(cases)
}

/// The case's scene with friction.
fn rough(case: &Case, friction: f64) -> Scene {
    let mut scene = case.scene;
    scene.contact.friction = friction;
    // Torn cloth that flaps gains energy with whole steps.
    scene.step_after_failure = StepAfterFailure::Half;
    scene
}

/// A run above the limit, or the search of one.
struct Job {
    case: usize,
    friction: f64,
    velocity: Option<f64>,
    number: u64,
}

/// What a job found.
enum Found {
    Impact(Impact),
    Limit(f64),
}

/// Measures and writes.
pub fn run(options: &Options) -> Result<bool> {
    std::fs::create_dir_all(&options.out).map_err(|error| format!("{}: {error}", options.out.display()))?;
    let effort = options.flags.effort();
    let smoke = effort == Effort::Smoke;
    let cases = cases(smoke)?;
    let runs = |case: &Case| match effort {
        Effort::Smoke => 2,
        Effort::Quick => 3,
        Effort::Full => case.runs,
    };
    let coefficients = if smoke { &[0.0, 0.3][..] } else { &COEFFICIENTS };
    let mut jobs = Vec::new();
    for (k, case) in cases.iter().enumerate() {
        // The searches first: they take longest.
        let search = case.guess.map(|_| None);
        for velocity in search.into_iter().chain(case.velocities.iter().map(|velocity| Some(*velocity))) {
            for &friction in coefficients {
                jobs.extend((0..runs(case)).map(|number| Job { case: k, friction, velocity, number }));
            }
        }
    }
    let progress = Progress::new("friction", jobs.len() as u64);
    let found = each(&jobs, |job| {
        let case = &cases[job.case];
        let scene = rough(case, job.friction);
        let done = match job.velocity {
            Some(velocity) => Found::Impact(impact(&shot(&scene, velocity, job.number), LONGEST)?),
            None => Found::Limit(limit(&scene, case.guess.unwrap_or(0.0), job.number, LONGEST)?),
        };
        progress.add(1, || format!("{}, coefficient {}", case.name, job.friction));
        Ok(done)
    })?;
    progress.finish();
    let mut impacts = Table::new(&[
        "case",
        "friction",
        "impact velocity m/s",
        "run",
        "through",
        "velocity m/s",
        "impact J",
        "absorbed J",
        "rubbed J",
        "residual %",
        "unconverged",
    ]);
    let mut limits = Table::new(&["case", "friction", "run", "limit m/s"]);
    let mut worst: f64 = 0.0;
    for (job, found) in jobs.iter().zip(&found) {
        let case = &cases[job.case];
        let mut row = vec![Cell::text(case.name), Cell::Number(job.friction)];
        match found {
            Found::Limit(limit) => {
                row.extend([job.number as f64, *limit].map(Cell::Number));
                limits.add(row);
            }
            Found::Impact(impact) => {
                let velocity = job.velocity.unwrap_or(0.0);
                let energy = 0.5 * case.scene.projectile.mass * velocity * velocity;
                row.extend(
                    [velocity, job.number as f64, f64::from(impact.through), impact.velocity, energy].map(Cell::Number),
                );
                row.extend([impact.absorbed, impact.rubbed, 100.0 * impact.residual].map(Cell::Number));
                row.push(Cell::Number(impact.unconverged as f64));
                worst = worst.max(impact.residual.abs());
                impacts.add(row);
            }
        }
    }
    impacts.write(&options.out.join("friction.csv"))?;
    limits.write(&options.out.join("friction_limits.csv"))?;
    say::line(format_args!("largest energy residual: {:.3} % of the impact energy", 100.0 * worst));
    say::line(format_args!("{}", report::written(&options.out, "friction")));
    Ok(worst < 0.01)
}
