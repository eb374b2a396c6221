//! How many runs a mean needs: its statistical error against its cost, at the default step.
//!
//! Uniform yarn: runs that differ by 1e-12 in the impact velocity (the chaos floor), and by 1e-6: what happens before the first
//! failure is then another thing to the same extent as with another step, and the first failures may come in another order.
//! Stochastic yarn: runs with different seeds, which is what a user of the scatter takes. The error of a mean of n is predicted
//! as the deviation over sqrt(n), and observed as the spread of the means of disjoint groups of n.

use super::impact::{CASES, Case, Setting};
use super::{Cell, Effort, Table, impact};
use crate::progress::Progress;
use crate::{Result, report};
use fabric::internals::parts::STEP_DEFAULT_FRACTION;
use rayon::prelude::*;
use std::path::Path;

/// By what the runs of an ensemble differ.
#[derive(Clone, Copy, PartialEq)]
enum Differs {
    /// The impact velocity, by multiples of this part of it.
    Velocity(f64),
    Seed,
}

/// Measures and writes.
pub fn run(effort: Effort, out: &Path) -> Result<()> {
    let [rounding, nudge] = [impact::ROUNDING, 1e-6].map(Differs::Velocity);
    let cases: Vec<(Case, usize, Differs)> = match effort {
        Effort::Smoke => vec![(CASES[0], 4, rounding)],
        Effort::Quick => vec![(CASES[0], 12, rounding), (CASES[0], 12, nudge), (CASES[1], 12, Differs::Seed)],
        Effort::Full => vec![
            (CASES[0], 64, rounding),
            (CASES[0], 32, nudge),
            (CASES[1], 64, Differs::Seed),
            (CASES[2], 32, rounding),
            (CASES[2], 32, nudge),
            (CASES[3], 32, Differs::Seed),
            (CASES[4], 16, rounding),
            (CASES[5], 16, Differs::Seed),
        ],
    };
    let progress = Progress::new("number of runs", cases.iter().map(|(_, runs, _)| *runs as u64).sum());
    let mut table = Table::new(&[
        "case",
        "what differs",
        "runs in the mean",
        "node-steps in all",
        "CPU s in all",
        "absorbed: standard error %",
        "absorbed: observed %",
        "velocity: standard error %",
        "velocity: observed %",
    ]);
    let mut summary = Table::new(&[
        "case",
        "what differs",
        "runs",
        "absorbed J",
        "absorbed J: deviation %",
        "velocity m/s",
        "velocity m/s: deviation %",
        "peak N",
        "peak N: deviation %",
        "failed %",
        "failed %: deviation %",
    ]);
    for (case, count, differs) in &cases {
        let setting = Setting::verlet(STEP_DEFAULT_FRACTION);
        let runs: Vec<impact::Run> = (0..*count)
            .into_par_iter()
            .with_max_len(1)
            .map(|k| -> std::result::Result<_, String> {
                let mut scene = match differs {
                    Differs::Velocity(part) => impact::scene_at(case, &setting, k as f64 * part, effort),
                    Differs::Seed => impact::scene(case, &setting, 0, effort),
                };
                scene.seed += if *differs == Differs::Seed { k as u64 } else { 0 };
                let run = impact::impact(&scene).map_err(|error| error.to_string())?;
                progress.add(1, || case.name.to_string());
                Ok(run)
            })
            .collect::<std::result::Result<_, _>>()?;
        let good: Vec<&impact::Run> = runs.iter().filter(|run| run.trouble.is_none()).collect();
        let column = |index: usize| -> Vec<f64> { good.iter().map(|run| run.values[index]).collect() };
        let cost = report::mean(&good.iter().map(|run| run.node_steps).collect::<Vec<_>>());
        let seconds = report::least(&good.iter().map(|run| run.seconds).collect::<Vec<_>>());
        let differs = match differs {
            Differs::Velocity(part) => format!("V0 by {part:e}"),
            Differs::Seed => "seed".to_string(),
        };
        let mut row = vec![Cell::text(case.name), Cell::text(&*differs), Cell::Number(good.len() as f64)];
        for index in [0, 1, 2, 4] {
            let (mean, deviation) = (report::mean(&column(index)), report::deviation(&column(index)));
            row.push(Cell::Number(mean));
            row.push(Cell::Number(100.0 * deviation / mean));
        }
        summary.add(row);
        let mut size = 1;
        while size <= good.len() {
            let [absorbed, velocity] = [impact::ABSORBED, impact::VELOCITY].map(|index| errors(&column(index), size));
            let mut row = vec![Cell::text(case.name), Cell::text(&*differs), Cell::Number(size as f64)];
            row.extend([Cell::Number(size as f64 * cost), Cell::Number(size as f64 * seconds)]);
            row.extend(absorbed.into_iter().chain(velocity).map(Cell::Number));
            table.add(row);
            size *= 2;
        }
    }
    progress.finish();
    summary.write(&out.join("runs_summary.csv"))?;
    table.write(&out.join("runs.csv"))?;
    Ok(())
}

/// Standard error of a mean of `size` values, predicted and observed over disjoint groups (NaN for fewer than four), %.
fn errors(values: &[f64], size: usize) -> [f64; 2] {
    let mean = report::mean(values);
    let groups: Vec<f64> = values.chunks_exact(size).map(report::mean).collect();
    let observed = if groups.len() < 4 { f64::NAN } else { report::deviation(&groups) };
    [report::deviation(values) / (size as f64).sqrt(), observed].map(|error| 100.0 * error / mean.abs())
}
