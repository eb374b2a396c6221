//! Stability: extreme scenes that are accepted, each with the outcome it must have, and a map of step against velocity.
//!
//! Nothing may end in a silent wrong answer, a panic, a hang or a NaN that passes. A row is a run that must meet a stated answer,
//! and passes only when the expected thing happened. What an FMU's parameters can describe goes through both FMUs too:
//! `--fmu-cases` writes it, `tests/fmi/test_stability.py` runs it. What is refused is tested by `fabric-tests`, in the kernel, the
//! C interface and the FMUs.

mod bodies;
mod extremes;
mod flight;
mod fmu;
mod friction;
mod map;
mod outcomes;
mod plies;
mod sheets;
mod steps;

use crate::effort::{self, Effort};
use crate::event::Summary;
use crate::progress::Progress;
use crate::{Result, machine, report, say};
use clap::Args;
use fmu::FmuCase;
use rayon::prelude::*;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Options of `stability`.
#[derive(Args)]
pub struct Options {
    // Quick: all rows and a coarse map; smoke: without the rows that take long, and without the map.
    #[command(flatten)]
    flags: effort::Flags,
    /// The rows of one theme alone, without the map: "Outcomes", "Masses", ... as in the headings of docs/tables/stability.md.
    #[arg(long, value_name = "THEME")]
    theme: Option<String>,
    /// Folder for stability.csv and map.csv.
    #[arg(long, value_name = "DIR", default_value = "target/fabric/stability")]
    out: PathBuf,
    /// Also write the rows that an FMU can run, with what must come out, to this file.
    #[arg(long, value_name = "FILE")]
    fmu_cases: Option<PathBuf>,
}

/// A case: how it is called, what must happen, and how to find out.
struct Case {
    /// Heading it stands under.
    theme: &'static str,
    name: String,
    expected: String,
    /// Left out of the short form.
    long: bool,
    check: Box<dyn Fn() -> Result<Answer> + Sync + Send>,
}

/// What happened.
struct Answer {
    happened: String,
    pass: bool,
    balances: Option<Balances>,
    fmu: Option<FmuCase>,
}

impl Answer {
    /// Nothing was stepped.
    fn plain(happened: String, pass: bool) -> Answer {
        Answer { happened, pass, balances: None, fmu: None }
    }
}

/// How well the balances closed.
#[derive(Clone, Copy)]
struct Balances {
    /// Energy residual over the kinetic energy at the start, or over the strain energy of a sheet that starts taut and at rest.
    /// J where both are 0.
    energy: f64,
    /// Momentum residual over the momentum at the start; N s where that is 0.
    momentum: f64,
    /// Deepest penetration of a node, m.
    penetration: f64,
}

impl Balances {
    /// From the read-outs at the end and the kinetic energy at the start, J.
    fn of(summary: &Summary, start: f64) -> Balances {
        let over = |value: f64, scale: f64| if scale > 0.0 { value / scale } else { value };
        Balances {
            energy: over(summary.energy_residual, start),
            momentum: over(summary.momentum_residual, summary.initial_momentum),
            penetration: summary.worst_penetration,
        }
    }
}

/// One row of the table.
#[derive(Serialize)]
struct Row {
    theme: &'static str,
    case: String,
    expected: String,
    happened: String,
    /// See [`Balances`]; absent where nothing ran.
    energy_residual: Option<f64>,
    momentum_residual: Option<f64>,
    worst_penetration_m: Option<f64>,
    /// What the FMU must do with the same parameters; empty if it has none for them.
    fmu: &'static str,
    pass: bool,
}

/// Every case, in the order of the table.
fn cases() -> Result<Vec<Case>> {
    let mut cases = extremes::rows();
    cases.extend(steps::rows());
    cases.extend(sheets::rows());
    cases.extend(bodies::rows()?);
    cases.extend(friction::rows());
    cases.extend(plies::rows());
    cases.extend(outcomes::rows());
    Ok(cases)
}

/// Runs every row, prints and writes. False if one missed.
pub fn run(options: &Options) -> Result<bool> {
    let in_folder = |error, path: &Path| format!("{}: {error}", path.display());
    std::fs::create_dir_all(&options.out).map_err(|error: std::io::Error| in_folder(error, &options.out))?;
    let mut cases = cases()?;
    let effort = options.flags.effort();
    cases.retain(|case| !(case.long && effort == Effort::Smoke));
    if let Some(theme) = &options.theme {
        cases.retain(|case| case.theme == theme);
        if cases.is_empty() {
            return Err(format!("no rows of theme {theme:?}: see the headings of docs/tables/stability.md").into());
        }
    }
    let mapped = effort != Effort::Smoke && options.theme.is_none();
    let cells = if mapped { map::cells(effort == Effort::Quick) } else { Vec::new() };

    let wall = machine::Wall::start();
    let progress = Progress::new("stability", cases.len() as u64);
    let (rows, fmu): (Vec<Row>, Vec<Option<FmuCase>>) = cases
        .par_iter()
        .map(|case| {
            // A call that should work and is refused misses its row; it does not end the study.
            let answer = (case.check)().unwrap_or_else(|error| Answer::plain(format!("error: {error}"), false));
            progress.add(1, || case.name.clone());
            let row = Row {
                theme: case.theme,
                case: case.name.clone(),
                expected: case.expected.clone(),
                happened: answer.happened,
                energy_residual: answer.balances.map(|balances| balances.energy),
                momentum_residual: answer.balances.map(|balances| balances.momentum),
                worst_penetration_m: answer.balances.map(|balances| balances.penetration),
                fmu: answer.fmu.as_ref().map_or("", FmuCase::word),
                pass: answer.pass,
            };
            (row, answer.fmu)
        })
        .unzip();
    progress.finish();
    for row in rows.iter().filter(|row| !row.pass) {
        say::line(format_args!("MISSED: {}: expected {}, happened: {}", row.case, row.expected, row.happened));
    }
    let missed = rows.iter().filter(|row| !row.pass).count();
    say::line(format_args!("{} rows, {missed} missed, {:.1} s", rows.len(), wall.seconds()));

    let mut writer = csv::Writer::from_path(options.out.join("stability.csv"))?;
    rows.iter().try_for_each(|row| writer.serialize(row))?;
    writer.flush()?;
    if !cells.is_empty() {
        let wall = machine::Wall::start();
        let cells = map::compute(&cells)?;
        map::write_csv(&cells, &options.out.join("map.csv"))?;
        say::line(format_args!("map of {} runs, {:.1} s", cells.len(), wall.seconds()));
    }
    if let Some(path) = &options.fmu_cases {
        let named = rows.iter().zip(fmu).filter_map(|(row, case)| Some((row.case.as_str(), case?)));
        let named: serde_json::Map<String, serde_json::Value> =
            named.map(|(name, case)| Ok((name.to_string(), serde_json::to_value(case)?))).collect::<Result<_>>()?;
        std::fs::write(path, serde_json::to_string_pretty(&named)?).map_err(|error| in_folder(error, path))?;
    }
    say::line(format_args!("{}", report::written(&options.out, "stability")));
    Ok(rows.iter().all(|row| row.pass))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_row_has_a_name_of_its_own_and_stands_in_the_table() {
        let table = include_str!("../../docs/tables/stability.md");
        let mut names = HashSet::new();
        for case in cases().unwrap() {
            let row = format!("| {} | {} |", case.name.replace('|', "\\|"), case.expected.replace('|', "\\|"));
            assert!(table.contains(&row), "docs/tables/stability.md lacks: {row}");
            assert!(names.insert(case.name));
        }
        // Two lines of each theme are its head.
        assert_eq!(table.matches("\n| ").count(), names.len() + 2 * table.matches("\n## ").count());
    }
}
