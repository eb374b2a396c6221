//! What viscosity does to whole impacts: energy absorbed and taken, failed segments, and the energy that slack sheets gain.
//!
//! Impacts of drawn yarn run until the body is arrested or has exited; runs differ by the seed. The slack sheet, of uniform yarn, is
//! stepped for a fixed time; its runs differ by 1e-12 in the impact velocity.

use super::overshoot::{VISCOSITIES, viscosity_name, with_viscosity};
use super::{Cell, Effort, Table, impact};
use crate::event::{kinetic_energy, mask_of};
use crate::memory::Buffers;
use crate::progress::Progress;
use crate::{Result, report};
use fabric::{AttachmentKind, Outcome, Scene};
use rayon::prelude::*;
use std::path::Path;

/// How long the slack sheet is stepped, s.
const SLACK_TIME: f64 = 1.2e-3;
/// Time after which an impact is given up, s.
const LONGEST: f64 = 4e-3;

/// An impact with and without viscosity.
struct Case {
    name: &'static str,
    scene: Scene,
    /// Stepped for this time, s, if it is not to end with an outcome.
    time: Option<f64>,
    runs: usize,
}

fn cases(effort: Effort) -> Vec<Case> {
    let sphere = |kind: AttachmentKind, energy: f64| {
        let mut scene = Scene::sheet_3in_sphere();
        scene.attachment.kind = kind;
        scene.projectile.velocity[2] = (2.0 * energy / scene.projectile.mass).sqrt();
        if effort == Effort::Smoke {
            (scene.sheet.nodes_x, scene.sheet.nodes_y) = (41, 41);
        }
        scene
    };
    let case = |name, scene, runs| Case { name, scene, time: None, runs };
    let few = if effort == Effort::Full { 8 } else { 2 };
    let mut cases = vec![case("3 in, four sides, 40 J", sphere(AttachmentKind::FourSides, 40.0), few)];
    if effort == Effort::Smoke {
        return cases;
    }
    cases.push(case("3 in, two sides, 40 J", sphere(AttachmentKind::TwoSides, 40.0), few));
    let mut slack = sphere(AttachmentKind::FourSides, 10.0);
    slack.yarn.stochastic = false;
    cases.push(Case {
        name: "3 in, four sides, 10 J, slack for 1.2 ms",
        scene: slack,
        time: Some(SLACK_TIME),
        runs: 2,
    });
    if effort == Effort::Full {
        let mut fast = Scene::sheet_10in_cylinder();
        fast.projectile.velocity[2] = 200.0;
        cases.push(case("10 in, two sides, 100 m/s", Scene::sheet_10in_cylinder(), 4));
        cases.push(case("10 in, two sides, 200 m/s", fast, 4));
    }
    cases
}

/// Absorbed energy, J; velocity at the end, m/s; peak force, N; failed segments, %; energy that viscosity took, and residual, % of KE0.
fn run_of(case: &Case, viscosity: [f64; 3], k: usize) -> Result<[f64; 6]> {
    let mut scene = with_viscosity(case.scene, viscosity);
    if scene.yarn.stochastic {
        scene.seed += k as u64;
    } else {
        scene.projectile.velocity[2] *= 1.0 + k as f64 * impact::ROUNDING;
    }
    let mut buffers = Buffers::of(&scene)?;
    let mut sim = buffers.sim(&scene)?;
    let steps = |time: f64| (time / sim.step_limits().dt) as u64;
    match case.time {
        Some(time) => sim.advance(steps(time))?,
        None => {
            sim.advance_until(mask_of(&[Outcome::Arrested, Outcome::Exited]), steps(LONGEST))?;
        }
    }
    let (contact, energy, first) = (sim.contact()?, sim.energy()?, kinetic_energy(&scene));
    Ok([
        contact.work,
        sim.projectile()?.velocity[2],
        contact.force_peak,
        100.0 * sim.counters().failed_segments as f64 / scene.segments() as f64,
        100.0 * energy.viscous / first,
        100.0 * energy.residual / first,
    ])
}

/// Measures and writes.
pub fn run(effort: Effort, out: &Path) -> Result<()> {
    let cases = cases(effort);
    let jobs: Vec<(&Case, [f64; 3], usize)> = cases
        .iter()
        .flat_map(|case| VISCOSITIES.iter().flat_map(move |v| (0..case.runs).map(move |k| (case, *v, k))))
        .collect();
    let progress = Progress::new("viscosity", jobs.len() as u64);
    let runs: Vec<[f64; 6]> = jobs
        .par_iter()
        .with_max_len(1)
        .map(|(case, viscosity, k)| {
            let run = run_of(case, *viscosity, *k).map_err(|error| error.to_string())?;
            progress.add(1, || case.name.to_string());
            Ok(run)
        })
        .collect::<std::result::Result<_, String>>()?;
    progress.finish();
    let mut table = Table::new(&[
        "case",
        "viscosity",
        "runs",
        "absorbed J",
        "absorbed J: deviation %",
        "velocity m/s",
        "peak N",
        "failed %",
        "taken by viscosity %",
        "residual %",
    ]);
    for case in &cases {
        for viscosity in VISCOSITIES {
            let own: Vec<[f64; 6]> = jobs
                .iter()
                .zip(&runs)
                .filter(|((of, with, _), _)| std::ptr::eq(*of, case) && *with == viscosity)
                .map(|(_, run)| *run)
                .collect();
            let column = |index: usize| -> Vec<f64> { own.iter().map(|run| run[index]).collect() };
            let mean = |index: usize| report::mean(&column(index));
            let mut row = vec![Cell::text(case.name), Cell::text(viscosity_name(viscosity))];
            row.push(Cell::Number(own.len() as f64));
            row.push(Cell::Number(mean(0)));
            row.push(Cell::Number(100.0 * report::deviation(&column(0)) / mean(0)));
            row.extend((1..6).map(|index| Cell::Number(mean(index))));
            table.add(row);
        }
    }
    table.write(&out.join("viscosity.csv"))
}
