//! docs/stability.md: what a user must know, the map and the table.

use super::map::{self, Cell, Class};
use super::{Row, residual};
use crate::Result;
use std::fmt::Write;
use std::path::Path;

/// Writes stability.md and images/stability_map.svg to a folder.
pub fn write(rows: &[Row], cells: &[Cell], docs: &Path) -> Result<()> {
    let images = docs.join("images");
    std::fs::create_dir_all(&images).map_err(|error| format!("{}: {error}", images.display()))?;
    map::draw(cells, &images.join("stability_map.svg"))?;
    let path = docs.join("stability.md");
    std::fs::write(&path, page(rows, cells)?).map_err(|error| format!("{}: {error}", path.display()).into())
}

fn page(rows: &[Row], cells: &[Cell]) -> Result<String> {
    let mut page = TEXT.replace("{map}", &map_in_words(cells));
    let missed = rows.iter().filter(|row| !row.pass).count();
    writeln!(page, "{} rows, {missed} missed.", rows.len())?;
    let mut theme = "";
    for row in rows {
        if row.theme != theme {
            theme = row.theme;
            write!(page, "\n### {theme}\n\n")?;
            page += "| case | expected | happened | energy | momentum | penetration, m | FMU | |\n";
            page += "|---|---|---|---:|---:|---:|---|---|\n";
        }
        let (case, expected, happened) = (cell(&row.case), cell(&row.expected), cell(&row.happened));
        let [energy, momentum, depth] =
            [row.energy_residual, row.momentum_residual, row.worst_penetration_m].map(residual);
        let pass = if row.pass { "ok" } else { "**missed**" };
        let fmu = row.fmu;
        writeln!(page, "| {case} | {expected} | {happened} | {energy} | {momentum} | {depth} | {fmu} | {pass} |")?;
    }
    Ok(page)
}

/// Text that does not end a table's cell.
pub fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

/// The worst residual of each accepted step, and of the refused ones.
fn map_in_words(cells: &[Cell]) -> String {
    let count = |allowed: bool, class: Class| {
        cells.iter().filter(|cell| cell.allowed() == allowed && cell.class() == class).count()
    };
    let worst = |at: f64| {
        let column = cells.iter().filter(|cell| cell.fraction == at);
        100.0 * column.fold(0.0_f64, |most, cell| most.max(cell.energy.abs()))
    };
    let steps: Vec<String> =
        [0.1, 0.2, 0.3, 0.4, 0.5].iter().map(|&at| format!("{:.2} % at {at}", worst(at))).collect();
    format!(
        "Of the {} runs with a step that is accepted {} are sound and {} creep ({} above 10 %); the worst of each step: {}. \
         Of the {} runs beyond it {} are sound, {} creep and {} are garbage.",
        cells.iter().filter(|cell| cell.allowed()).count(),
        count(true, Class::Sound),
        count(true, Class::Creep) + count(true, Class::Garbage),
        count(true, Class::Garbage),
        steps.join(", "),
        cells.iter().filter(|cell| !cell.allowed()).count(),
        count(false, Class::Sound),
        count(false, Class::Creep),
        count(false, Class::Garbage),
    )
}

const TEXT: &str = include_str!("page.md");
