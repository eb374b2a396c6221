//! Stability: extreme and senseless scenes, each with the outcome it must have, and a map of step against velocity.
//!
//! Nothing may end in a silent wrong answer, a panic, a hang or a NaN that passes. A row is either a refusal, which must carry
//! its code and field, or a run, which must meet a stated answer. A row passes only when the expected thing happened. What an
//! FMU's parameters can describe goes through both FMUs too: `--fmu-cases` writes it, `tests/fmi/test_stability.py` runs it.

mod bodies;
mod extremes;
mod flight;
mod fmu;
mod law;
mod map;
mod outcomes;
mod page;
mod refused;
mod sheets;
mod steps;

use crate::event::Summary;
use crate::progress::Progress;
use crate::{Result, machine, report};
use clap::Args;
use fmu::FmuCase;
use rayon::prelude::*;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Options of `stability`.
#[derive(Args)]
pub struct Options {
    /// All rows and a coarse map: under 3 minutes on 2 cores.
    #[arg(long, conflicts_with = "smoke")]
    quick: bool,
    /// Without the rows that take long, and without the map: seconds.
    #[arg(long)]
    smoke: bool,
    /// The rows of one theme alone, without the map: "Outcomes", "Masses", ... as in the headings of docs/stability.md.
    #[arg(long, value_name = "THEME", conflicts_with = "docs")]
    theme: Option<String>,
    /// Folder for stability.csv, map.csv and map.svg.
    #[arg(long, value_name = "DIR", default_value = "target/study/stability")]
    out: PathBuf,
    /// Also write stability.md and images/stability_map.svg to this folder.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["quick", "smoke"])]
    docs: Option<PathBuf>,
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
    books: Option<Books>,
    fmu: Option<FmuCase>,
}

impl Answer {
    /// Nothing was stepped.
    fn plain(happened: String, pass: bool) -> Answer {
        Answer { happened, pass, books: None, fmu: None }
    }
}

/// How well the balances closed.
#[derive(Clone, Copy)]
struct Books {
    /// Energy residual over the kinetic energy at the start, or over the strain energy of a sheet that starts taut and at rest.
    /// J where both are 0.
    energy: f64,
    /// Momentum residual over the momentum at the start; N s where that is 0.
    momentum: f64,
    /// Deepest penetration of a node, m.
    penetration: f64,
}

impl Books {
    /// From the read-outs at the end and the kinetic energy at the start, J.
    fn of(summary: &Summary, start: f64) -> Books {
        let over = |value: f64, scale: f64| if scale > 0.0 { value / scale } else { value };
        Books {
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
    /// See [`Books`]; absent where nothing ran.
    energy_residual: Option<f64>,
    momentum_residual: Option<f64>,
    worst_penetration_m: Option<f64>,
    /// What the FMU must do with the same parameters; empty if it has none for them.
    fmu: &'static str,
    pass: bool,
}

/// Every case, in the order of the table.
fn cases() -> Result<Vec<Case>> {
    let mut cases = refused::scenes();
    cases.extend(refused::calls());
    cases.extend(extremes::rows());
    cases.extend(law::rows());
    cases.extend(steps::rows());
    cases.extend(sheets::rows());
    cases.extend(bodies::rows()?);
    cases.extend(outcomes::rows());
    Ok(cases)
}

/// Runs every row, prints and writes. False if one missed.
pub fn run(options: &Options) -> Result<bool> {
    let in_folder = |error, path: &Path| format!("{}: {error}", path.display());
    std::fs::create_dir_all(&options.out).map_err(|error: std::io::Error| in_folder(error, &options.out))?;
    let mut cases = cases()?;
    cases.retain(|case| !(case.long && options.smoke));
    if let Some(theme) = &options.theme {
        cases.retain(|case| case.theme == theme);
        if cases.is_empty() {
            return Err(format!("no rows of theme {theme:?}: see the headings of docs/stability.md").into());
        }
    }
    let cells = if options.smoke || options.theme.is_some() { Vec::new() } else { map::cells(options.quick) };

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
                energy_residual: answer.books.map(|books| books.energy),
                momentum_residual: answer.books.map(|books| books.momentum),
                worst_penetration_m: answer.books.map(|books| books.penetration),
                fmu: answer.fmu.as_ref().map_or("", FmuCase::word),
                pass: answer.pass,
            };
            (row, answer.fmu)
        })
        .unzip();
    progress.finish();
    print(&rows, wall.seconds());

    let mut writer = csv::Writer::from_path(options.out.join("stability.csv"))?;
    rows.iter().try_for_each(|row| writer.serialize(row))?;
    writer.flush()?;
    if !cells.is_empty() {
        let wall = machine::Wall::start();
        let cells = map::compute(&cells)?;
        map::write_csv(&cells, &options.out.join("map.csv"))?;
        map::draw(&cells, &options.out.join("map.svg"))?;
        println!("map of {} runs, {:.1} s", cells.len(), wall.seconds());
        if let Some(docs) = &options.docs {
            page::write(&rows, &cells, docs)?;
        }
    }
    if let Some(path) = &options.fmu_cases {
        let named = rows.iter().zip(fmu).filter_map(|(row, case)| Some((row.case.as_str(), case?)));
        let named: serde_json::Map<String, serde_json::Value> =
            named.map(|(name, case)| Ok((name.to_string(), serde_json::to_value(case)?))).collect::<Result<_>>()?;
        std::fs::write(path, serde_json::to_string_pretty(&named)?).map_err(|error| in_folder(error, path))?;
    }
    println!("written: {}", options.out.display());
    Ok(rows.iter().all(|row| row.pass))
}

fn print(rows: &[Row], wall: f64) {
    let mut table = report::table(&["case", "expected", "happened", "energy", "momentum", "penetration m", "FMU", ""]);
    for column in [1, 2, 6] {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(comfy_table::CellAlignment::Left);
        }
    }
    for row in rows {
        table.add_row(vec![
            row.case.clone(),
            row.expected.clone(),
            row.happened.clone(),
            residual(row.energy_residual),
            residual(row.momentum_residual),
            residual(row.worst_penetration_m),
            row.fmu.to_string(),
            if row.pass { "ok".to_string() } else { "MISSED".to_string() },
        ]);
    }
    println!("{table}");
    println!("energy and momentum: what the balance does not close by, over kinetic energy and momentum at the start");
    println!("warning: rows above 0.5 dt_crit ran with step_check = none; their results mean nothing else");
    let missed = rows.iter().filter(|row| !row.pass).count();
    println!("{} rows, {missed} missed, {wall:.1} s", rows.len());
}

/// A residual with two figures; nothing where nothing ran.
fn residual(value: Option<f64>) -> String {
    value.map_or(String::new(), |value| if value == 0.0 { "0".to_string() } else { format!("{value:.1e}") })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_row_has_a_name_of_its_own_and_stands_on_the_page() {
        let page = include_str!("../../docs/stability.md");
        let mut names = HashSet::new();
        for case in cases().unwrap() {
            let row = format!("| {} | {} |", page::cell(&case.name), page::cell(&case.expected));
            assert!(page.contains(&row), "docs/stability.md lacks: {row}");
            assert!(names.insert(case.name));
        }
        assert!(page.matches("\n| ").count() >= names.len());
    }
}
