//! docs/performance.md: goals beside what was measured, tables, the plot.

use super::parts;
use super::peers::PEERS;
use super::ports;
use super::rows::{Figure, Report};
use crate::Result;
use crate::plots::{Axes, Plot, Series, Style};
use fabric::InstructionSet;
use std::fmt::Write;
use std::path::Path;

/// A limit that a measured value must keep.
pub struct Goal {
    /// What is measured.
    pub what: String,
    /// Measured; None if it could not be, here or in this run.
    pub value: Option<f64>,
    limit: f64,
    /// true: the value must not be below the limit.
    at_least: bool,
    unit: &'static str,
}

impl Goal {
    /// The limit in words.
    pub fn limit(&self) -> String {
        format!("{} {} {}", if self.at_least { "at least" } else { "at most" }, figures(self.limit), self.unit)
    }

    /// The value in words.
    pub fn measured(&self) -> String {
        self.value.map_or("-".to_string(), figures)
    }

    /// Whether it is kept.
    pub fn verdict(&self) -> &'static str {
        match self.value {
            None => "not measured",
            Some(value) if (value >= self.limit) == self.at_least || value == self.limit => "met",
            Some(_) => "**missed**",
        }
    }
}

/// All goals, with what was measured.
pub fn goals(report: &Report) -> Vec<Goal> {
    let mut goals = Vec::new();
    let mut add = |what: String, value: Option<f64>, at_least: bool, limit: f64, unit: &'static str| {
        goals.push(Goal { what, value, limit, at_least, unit });
    };
    let ns = "ns per node-step";
    for (set, limit) in [("avx512", 2.0), ("avx2", 3.3), ("scalar", 10.0)] {
        add(format!("350 x 350 whole run, {set}"), report.time("run", 350, set, 1), false, limit, ns);
    }
    for (set, limit) in [("avx512", 1.6), ("avx2", 2.5)] {
        add(format!("350 x 350 bare sweep, {set}"), report.time("sweep", 350, set, 1), false, limit, ns);
    }
    let widest = InstructionSet::widest().name();
    let bound = report.value(&ports::bound_name(widest));
    let part = report.time("sweep", 350, widest, 1).zip(bound).map(|(time, bound)| 100.0 * bound / time);
    add(format!("350 x 350 bare sweep, {widest}, part of the add-port bound"), part, true, 60.0, "%");
    for (size, limit) in [(105, 2.0), (1000, 3.6)] {
        let value = report.time("sweep", size, "avx512", 1);
        add(format!("{size} x {size} bare sweep, avx512"), value, false, limit, ns);
    }
    add("damage-dense state, 105 x 105, avx512".to_string(), report.time("dense", 105, "avx512", 1), false, 4.0, ns);
    for size in [350, 1000] {
        let times = report.time("run", size, widest, 1).zip(report.time("run", size, widest, 2));
        let value = times.map(|(one, two)| one / two);
        add(format!("2 threads, {size} x {size} whole run, {widest}"), value, true, 1.8, "x");
    }
    for (peer, limit) in [("LAMMPS", 22.0), ("NVIDIA Warp", 16.0), ("plain C", 15.0)] {
        let case = format!("peers: {peer}");
        let row = report.rows.iter().find(|row| row.case == case && row.size == 350);
        let value = row.and_then(|row| row.times_slower);
        add(format!("{peer}, 350 x 350 whole run, over the kernel's {widest}"), value, true, limit, "x");
    }
    for (kind, limit) in [("stochastic", 124.0), ("uniform", 92.0)] {
        let name = parts::memory_name(kind, parts::TIGHT_CAPACITY);
        add(name.clone(), report.value(&name), false, limit, "bytes per node");
    }
    for (version, limit) in [("FMI 2.0", 2.0), ("FMI 3.0", 3.0)] {
        for drive in ["free", "prescribed"] {
            let name = format!("{version}, {drive}: doStep beyond stepping");
            add(name.clone(), report.value(&name), false, limit, "us");
            let name = format!("{version}, {drive}: get of a force");
            add(name.clone(), report.value(&name), false, 1.0, "us");
        }
    }
    for (what, limit) in [("get", 3.0), ("set", 3.0), ("serialise", 12.0), ("deserialise", 12.0)] {
        let name = format!("state, 350 x 350: {what}");
        add(name.clone(), report.value(&name), false, limit, "ms");
    }
    goals
}

/// Three significant figures, without needless zeros after large numbers.
pub fn figures(value: f64) -> String {
    let digits = 2 - value.abs().max(1e-9).log10().floor() as i32;
    format!("{value:.*}", digits.clamp(0, 4) as usize)
}

/// Writes performance.md and images/performance.svg.
pub fn write(report: &Report, docs: &Path) -> Result<()> {
    let images = docs.join("images");
    std::fs::create_dir_all(&images).map_err(|error| format!("{}: {error}", images.display()))?;
    draw(report, &images.join("performance.svg"))?;
    let path = docs.join("performance.md");
    std::fs::write(&path, page(report)?).map_err(|error| format!("{}: {error}", path.display()).into())
}

/// Time over size, the bare sweep of every instruction set and every peer.
fn draw(report: &Report, path: &Path) -> Result<()> {
    let mut series = Vec::new();
    let mut add = |name: String, style: Style, case: &str, set: &str| {
        let rows = report.rows.iter().filter(|row| row.case == case && row.instruction_set == set && row.threads == 1);
        let points: Vec<(f64, f64)> =
            rows.filter_map(|row| Some((f64::from(row.size), row.ns_per_node_step?))).collect();
        if !points.is_empty() {
            series.push(Series::new(name, style, points));
        }
    };
    for set in InstructionSet::ALL {
        add(format!("bare sweep, {}", set.name()), Style::Marked, "sweep", set.name());
    }
    add(
        format!("whole run, {}", InstructionSet::widest().name()),
        Style::Dashed,
        "run",
        InstructionSet::widest().name(),
    );
    for peer in &PEERS {
        add(format!("{}, whole run", peer.name), Style::Marked, &format!("peers: {}", peer.name), "compiled");
    }
    let (x, y) = ("nodes along a side", "ns per node-step, one core");
    Plot { title: "Time per node and step", x, y, axes: Axes::Logarithmic, series, marks: Vec::new() }.write(path)
}

fn page(report: &Report) -> Result<String> {
    let load = |load: Option<f64>| load.map_or("unknown".to_string(), |load| format!("{load:.2}"));
    let mut page = TEXT
        .replace("{machine}", &report.machine)
        .replace("{clock}", report.clock)
        .replace("{rounds}", &report.rounds.to_string())
        .replace("{start}", &load(report.load_at_start))
        .replace("{end}", &load(report.load_at_end));
    page = page.replace("{goals}", &goals_table(report)?);
    page = page.replace("{sweep}", &times(report, "sweep")?).replace("{run}", &times(report, "run")?);
    page = page.replace("{dense}", &dense(report)?);
    page = page.replace("{peers}", &peers(report)?);
    page = page.replace("{rest}", &rest(report)?);
    for group in ["ports", "instructions", "contact", "ledger", "memory", "presets", "fmu", "states"] {
        page = page.replace(&format!("{{{group}}}"), &figure_table(report, group)?);
    }
    let missing: String = report.missing.iter().map(|missing| format!("- {missing}\n")).collect();
    let none = "No group of measurements is missing; instruction sets that this machine lacks are.\n".to_string();
    Ok(page.replace("{missing}", if report.missing.is_empty() { &none } else { &missing }))
}

fn goals_table(report: &Report) -> Result<String> {
    let mut text = String::from("| figure | goal | measured | |\n|---|---:|---:|---|\n");
    for goal in goals(report) {
        writeln!(text, "| {} | {} | {} | {} |", goal.what, goal.limit(), goal.measured(), goal.verdict())?;
    }
    Ok(text)
}

/// One line a size, one column a way to step.
fn times(report: &Report, case: &str) -> Result<String> {
    let rows: Vec<_> = report.rows.iter().filter(|row| row.case == case).collect();
    let mut ways: Vec<(&str, u32)> = Vec::new();
    let mut sizes: Vec<u32> = Vec::new();
    for row in &rows {
        if !ways.contains(&(&row.instruction_set, row.threads)) {
            ways.push((&row.instruction_set, row.threads));
        }
        if !sizes.contains(&row.size) {
            sizes.push(row.size);
        }
    }
    let mut text = String::from("| nodes |");
    for (set, threads) in &ways {
        let many = if *threads == 1 { String::new() } else { format!(", {threads} threads") };
        write!(text, " {set}{many} |")?;
    }
    writeln!(text, " digest |\n|---|{}---|", "---:|".repeat(ways.len()))?;
    for size in sizes {
        write!(text, "| {size} x {size} |")?;
        let mut digest = "";
        for (set, threads) in &ways {
            let row =
                rows.iter().find(|row| (row.size, row.instruction_set.as_str(), row.threads) == (size, *set, *threads));
            match row.and_then(|row| row.ns_per_node_step.zip(row.median)) {
                Some((least, median)) => write!(text, " {least:.2} ({median:.2}) |")?,
                None => write!(text, " not on this machine |")?,
            }
            digest = row.and_then(|row| row.digest.as_deref()).unwrap_or(digest);
        }
        writeln!(text, " `{digest}` |")?;
    }
    Ok(text)
}

fn dense(report: &Report) -> Result<String> {
    let mut text = times(report, "dense")?;
    let set = InstructionSet::widest().name();
    if let Some(row) = report.rows.iter().find(|row| row.case == "dense" && row.failed_segments.is_some())
        && let Some((dense, quiet)) = report.time("dense", row.size, set, 1).zip(report.time("run", row.size, set, 1))
    {
        let failed = row.failed_segments.unwrap_or(0);
        writeln!(
            text,
            "\nWith {set} that is {} times the whole run of the same size above; {failed} segments have failed.",
            figures(dense / quiet)
        )?;
    }
    Ok(text)
}

fn peers(report: &Report) -> Result<String> {
    let mut text = String::from(
        "| nodes | program | ns per node-step (median) | times slower | deflection at the start, mm | how it differs |\n\
         |---|---|---:|---:|---:|---|\n",
    );
    for row in report.rows.iter().filter(|row| row.case.starts_with("peers: ")) {
        let name = row.case.trim_start_matches("peers: ");
        let differs = PEERS.iter().find(|peer| peer.name == name).map_or("", |peer| peer.differs);
        let [time, median] = [row.ns_per_node_step, row.median].map(|time| time.map_or("-".to_string(), figures));
        let ratio = row.times_slower.map_or("1".to_string(), figures);
        let deflection = row.deflection.map_or("-".to_string(), |z| format!("{:.4}", 1e3 * z));
        let (size, set) = (row.size, &row.instruction_set);
        let name = if row.times_slower.is_some() { name.to_string() } else { format!("{name}, {set}") };
        writeln!(text, "| {size} x {size} | {name} | {time} ({median}) | {ratio} | {deflection} | {differs} |")?;
    }
    Ok(text)
}

fn rest(report: &Report) -> Result<String> {
    let mut text = String::from("| nodes | | ns per node-step | digest |\n|---|---|---:|---|\n");
    for row in report.rows.iter().filter(|row| row.case.starts_with("first ")) {
        let time = row.ns_per_node_step.map_or("-".to_string(), figures);
        let digest = row.digest.as_deref().unwrap_or("-");
        writeln!(text, "| {0} x {0} | {1} | {time} | `{digest}` |", row.size, row.case)?;
    }
    Ok(text)
}

fn figure_table(report: &Report, group: &str) -> Result<String> {
    let figures_of: Vec<&Figure> = report.figures.iter().filter(|figure| figure.group == group).collect();
    if figures_of.is_empty() {
        return Ok("Not measured in this run.\n".to_string());
    }
    let mut text = String::from("| | | |\n|---|---:|---|\n");
    for figure in figures_of {
        writeln!(text, "| {} | {} | {} |", figure.name, figures(figure.value), figure.unit)?;
    }
    Ok(text)
}

const TEXT: &str = include_str!("page.md");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goals_know_their_side() {
        let goal = |value, at_least| Goal { what: String::new(), value, limit: 2.0, at_least, unit: "" };
        assert_eq!(goal(Some(1.9), false).verdict(), "met");
        assert_eq!(goal(Some(2.1), false).verdict(), "**missed**");
        assert_eq!(goal(Some(2.1), true).verdict(), "met");
        assert_eq!(goal(Some(1.9), true).verdict(), "**missed**");
        assert_eq!([goal(Some(2.0), true).verdict(), goal(Some(2.0), false).verdict()], ["met", "met"]);
        assert_eq!(goal(None, true).verdict(), "not measured");
    }

    #[test]
    fn three_significant_figures() {
        assert_eq!([1234.5, 12.345, 1.2345, 0.012345, 0.0].map(figures), ["1234", "12.3", "1.23", "0.0123", "0.0000"]);
    }
}
