//! The open question: does uniform yarn over-predict about twofold near the ballistic limit of the sheet held at its
//! corners? The ratio uniform/stochastic over everything that the paper leaves open: position and size of the washers, full
//! mirror symmetry of the uniform sheet or not, one draw per segment or per yarn, which energy is read, and when.

use super::html::{Figure, Page};
use super::jobs::{Reading, Record, Runs};
use super::plan::{self, Effort, Point, WASHERS, Yarn};
use super::statistics::{self, Arrests, Estimate, Verdict};
use crate::Result;
use crate::plots::{Axes, Plot, Series, Style};
use fabric::AttachmentKind::FourCorners;
use serde::Serialize;
use std::path::Path;

/// "About twofold".
pub const TWOFOLD: [f64; 2] = [1.5, 2.5];

/// Time of the reading at a fixed time, s.
const FIXED_TIME: f64 = 400e-6;

/// Impact energies for the washers that are not the preset ones, J.
const OTHER_ENERGIES: [f64; 2] = [10.0, 15.0];
/// Washers with which one draw per yarn is tried.
const PER_YARN_WASHERS: [usize; 1] = [0];

/// Which energy is read, and when: first what the projectile has lost, then what rupture has dissipated, last what the
/// yarn has taken up, as strain or by rupture.
const READINGS: [Reading; 6] = [
    ("detached", Record::at_detached),
    ("arrested or left", |record| record.absorbed),
    ("400 µs", |record| record.at_time(FIXED_TIME)),
    ("dissipated, detached", Record::dissipated_at_detached),
    ("dissipated, arrested or left", Record::dissipated),
    ("strain and dissipated, detached", Record::yarn_work_at_detached),
];
/// Index of the absorbed and of the dissipated energy when detached.
const ABSORBED: usize = 0;
const DISSIPATED: usize = 3;

/// An ensemble of the map.
fn point(effort: Effort, washer: usize, yarn: Yarn, energy: f64) -> Point {
    Point { washer, ..plan::small(effort, FourCorners, yarn, energy) }
}

/// Energies of the map for one washer: all of them for the preset, the two about the limit for the others.
fn energies(effort: Effort, washer: usize) -> Vec<f64> {
    let all = effort.map_energies().iter().copied();
    all.filter(|energy| washer == 0 || effort != Effort::Full || OTHER_ENERGIES.contains(energy)).collect()
}

/// Every ensemble of the map.
pub fn points(effort: Effort) -> Vec<Point> {
    let mut points = Vec::new();
    for washer in 0..effort.washers() {
        for yarn in [Yarn::Stochastic, Yarn::Uniform, Yarn::Symmetric, Yarn::Woven] {
            // One draw per yarn: for the preset washers.
            if yarn != Yarn::Woven || (effort != Effort::Quick && PER_YARN_WASHERS.contains(&washer)) {
                points.extend(energies(effort, washer).iter().map(|&energy| point(effort, washer, yarn, energy)));
            }
        }
    }
    points
}

/// One ratio of the map.
#[derive(Serialize)]
pub struct Cell {
    washer: &'static str,
    uniform: &'static str,
    stochastic: &'static str,
    read_at: &'static str,
    /// Kinetic energy at impact, J.
    pub impact_j: f64,
    ratio: f64,
    ratio_low: f64,
    ratio_high: f64,
    uniform_arrested: usize,
    stochastic_arrested: usize,
    uniform_runs: usize,
    stochastic_runs: usize,
    /// Against "about twofold".
    verdict: &'static str,
}

impl Cell {
    fn of(runs: &Runs, above: &Point, below: &Point, reading: usize) -> Option<Cell> {
        let (name, value) = READINGS[reading];
        let (uniform, stochastic) = (runs.of(above), runs.of(below));
        if uniform.is_empty() || stochastic.is_empty() {
            return None;
        }
        let ratio = Estimate::ratio(&runs.values(above, value), &runs.values(below, value));
        if !ratio.value.is_finite() {
            // Nothing fails, nothing is dissipated.
            return None;
        }
        let arrested = |records: &[&Record]| records.iter().filter(|record| record.arrested).count();
        Some(Cell {
            washer: WASHERS[above.washer].name,
            uniform: above.yarn.name(),
            stochastic: below.yarn.name(),
            read_at: name,
            impact_j: above.energy(),
            ratio: ratio.value,
            ratio_low: ratio.low,
            ratio_high: ratio.high,
            uniform_arrested: arrested(&uniform),
            stochastic_arrested: arrested(&stochastic),
            uniform_runs: uniform.len(),
            stochastic_runs: stochastic.len(),
            verdict: Verdict::of(&ratio, TWOFOLD).name(),
        })
    }

    /// The ratio with its interval.
    pub fn estimate(&self) -> Estimate {
        Estimate { value: self.ratio, low: self.ratio_low, high: self.ratio_high }
    }

    /// Whether this is the plain reading: preset washers, whole sheet, one draw per segment, read when detached.
    pub fn plain(&self) -> bool {
        self.washer == WASHERS[0].name
            && self.uniform == Yarn::Uniform.name()
            && self.stochastic == Yarn::Stochastic.name()
            && self.read_at == READINGS[ABSORBED].0
    }

    /// The same for the dissipated energy of the mirror-symmetric sheet.
    pub fn dissipated(&self) -> bool {
        self.washer == WASHERS[0].name
            && self.uniform == Yarn::Symmetric.name()
            && self.stochastic == Yarn::Stochastic.name()
            && self.read_at == READINGS[DISSIPATED].0
    }

    /// In words.
    pub fn name(&self) -> String {
        format!("{}; {} / {}; {}; {} J", self.washer, self.uniform, self.stochastic, self.read_at, self.impact_j)
    }

    fn text(&self) -> String {
        let arrests = if self.uniform_arrested + self.stochastic_arrested > 0 {
            format!(" ({}/{})", self.uniform_arrested, self.stochastic_arrested)
        } else {
            String::new()
        };
        self.estimate().text(2) + &arrests
    }
}

/// Every ratio, in a fixed order: washers, yarns, readings, energies.
pub fn cells(runs: &Runs, effort: Effort) -> Vec<Cell> {
    let mut cells = Vec::new();
    for washer in 0..effort.washers() {
        for above in [Yarn::Uniform, Yarn::Symmetric] {
            for below in [Yarn::Stochastic, Yarn::Woven] {
                for reading in 0..READINGS.len() {
                    for energy in energies(effort, washer) {
                        let (above, below) =
                            (point(effort, washer, above, energy), point(effort, washer, below, energy));
                        cells.extend(Cell::of(runs, &above, &below, reading));
                    }
                }
            }
        }
    }
    cells
}

/// What the table of ratios shows.
pub const TEXT: &str = "The paper says that uniform yarn over-predicts about twofold near the ballistic limit of the sheet held at its corners. It does \
    not say where the washers of the 3 in sheet sit, how large they are, whether its uniform sheet stayed symmetric, which \
    energy is read and when, or whether a segment or a whole yarn gets a draw. The energy is what the projectile has lost \
    (absorbed), or what rupture has dissipated (the work done by the yarn), or that with the strain energy. Below, the \
    ratio uniform over stochastic under every combination of these readings, with its 95 % interval; in brackets how many of the uniform and of \
    the stochastic runs were arrested. Where runs are arrested their absorbed energy is capped at the impact energy, so the \
    ratio alone understates a difference; the ballistic limits are compared as well. A sheet that has not torn off by the \
    end of its run is read at the end; the reading at 400 µs takes the end of runs that were over before. Mirror-symmetric \
    sheets are read when detached at the latest: torn off evenly at all corners, they wrap the sphere and fly with it.";

/// Writes map.csv and shows the map.
pub fn show(page: &mut Page, out: &Path, runs: &Runs, effort: Effort) -> Result<()> {
    let cells = cells(runs, effort);
    let mut writer = csv::Writer::from_path(out.join("map.csv"))?;
    for cell in &cells {
        writer.serialize(cell)?;
    }
    writer.flush()?;
    page.text(TEXT);
    if effort == Effort::Full {
        page.text(&format!(
            "Left out: energies other than {} J for washers that are not the preset ones, and one draw per yarn for all washers but \
             the preset ones.",
            OTHER_ENERGIES.map(|energy| energy.to_string()).join(", ")
        ));
    }
    for (file, above, reading, title) in [
        ("map_whole.svg", Yarn::Uniform, ABSORBED, "Whole uniform sheet over stochastic, absorbed when detached"),
        (
            "map_symmetric.svg",
            Yarn::Symmetric,
            ABSORBED,
            "Mirror-symmetric uniform sheet over stochastic, absorbed when detached",
        ),
        (
            "map_dissipated.svg",
            Yarn::Symmetric,
            DISSIPATED,
            "Mirror-symmetric uniform sheet over stochastic, dissipated when detached",
        ),
    ] {
        page.figure(&plot(out, &cells, effort, file, [above.name(), READINGS[reading].0, title])?);
    }
    table(page, &cells, effort);
    page.heading("Ballistic limits");
    page.text(
        "Runs arrested, of all runs at an impact energy; a run that its step limit ended does not count as arrested. The limit is the \
         energy at which half of the runs are arrested (Spearman-Kärber, with the spacing of the energies in its 95 % interval); \
         it needs an energy at which all are arrested and one at which none is.",
    );
    limits(page, runs, effort);
    Ok(())
}

fn plot(out: &Path, cells: &[Cell], effort: Effort, file: &str, [above, reading, title]: [&str; 3]) -> Result<Figure> {
    let mut series = Vec::new();
    for washer in &WASHERS[..effort.washers()] {
        let wanted = |cell: &&Cell| {
            cell.washer == washer.name
                && cell.uniform == above
                && cell.stochastic == Yarn::Stochastic.name()
                && cell.read_at == reading
        };
        let mut line = Series::new(washer.name, Style::Marked, Vec::new());
        for cell in cells.iter().filter(wanted) {
            // Side by side, so that the error bars do not hide one another.
            let shift = 0.12 * (series.len() as f64 - 2.0);
            line.points.push((cell.impact_j + shift, cell.ratio));
            line.bars.push((cell.ratio_low, cell.ratio_high));
        }
        series.push(line);
    }
    let energies = effort.map_energies();
    let ends = [energies[0] - 0.5, energies[energies.len() - 1] + 0.5];
    for (name, level) in [("no difference", 1.0), ("twofold", 2.0)] {
        series.push(Series::new(name, Style::Dashed, ends.map(|x| (x, level)).to_vec()));
    }
    Plot { title, x: "impact energy (J)", y: "ratio of energies", axes: Axes::FromZero, series, marks: Vec::new() }
        .write(&out.join(file))?;
    let caption = format!("{title}. 95 % intervals; points are shifted sideways a little to tell them apart.");
    Figure::svg(out, file, caption)
}

fn heading(effort: Effort) -> Vec<String> {
    let mut heading = vec!["washers".to_string(), "uniform".into(), "draw".into(), "read".into()];
    heading.extend(effort.map_energies().iter().map(|energy| format!("{energy} J")));
    heading
}

fn rows(cells: &[Cell], effort: Effort) -> Vec<Vec<String>> {
    let same_row = |a: &Cell, b: &Cell| {
        (a.washer, a.uniform, a.stochastic, a.read_at) == (b.washer, b.uniform, b.stochastic, b.read_at)
    };
    let row = |row: &[Cell]| {
        let first = &row[0];
        let symmetry = if first.uniform == Yarn::Uniform.name() { "whole" } else { "symmetric" };
        let draw = if first.stochastic == Yarn::Stochastic.name() { "segment" } else { "yarn" };
        let mut texts = vec![first.washer.to_string(), symmetry.into(), draw.into(), first.read_at.to_string()];
        for &energy in effort.map_energies() {
            texts.push(row.iter().find(|cell| cell.impact_j == energy).map_or(String::new(), Cell::text));
        }
        texts
    };
    cells.chunk_by(same_row).map(row).collect()
}

fn table(page: &mut Page, cells: &[Cell], effort: Effort) {
    let heading = heading(effort);
    let heading: Vec<&str> = heading.iter().map(String::as_str).collect();
    page.table(&heading, &[1, 2, 3], &rows(cells, effort));
}

/// The same table in Markdown.
pub fn markdown(runs: &Runs, effort: Effort) -> String {
    let heading = heading(effort);
    let heading: Vec<&str> = heading.iter().map(String::as_str).collect();
    crate::report::markdown(&heading, &rows(&cells(runs, effort), effort))
}

/// How many runs were arrested, and the limits.
fn limits(page: &mut Page, runs: &Runs, effort: Effort) {
    let mut columns = effort.map_energies().to_vec();
    // Figs 14 and 18 have more energies for the preset washers.
    columns.extend(effort.energies().iter().filter(|&&energy| energy < effort.map_energies()[0]));
    columns.sort_by(f64::total_cmp);
    let mut rows = Vec::new();
    for (washer, name) in WASHERS[..effort.washers()].iter().enumerate().map(|(k, washer)| (k, washer.name)) {
        let counts = |yarn: Yarn| -> Vec<Arrests> {
            let count = |&energy: &f64| {
                let records = runs.of(&point(effort, washer, yarn, energy));
                let arrested = records.iter().filter(|record| record.arrested).count();
                (!records.is_empty()).then_some(Arrests { energy, arrested, runs: records.len() })
            };
            columns.iter().filter_map(count).collect()
        };
        let stochastic = statistics::arrest_limit(&counts(Yarn::Stochastic));
        for yarn in [Yarn::Stochastic, Yarn::Woven, Yarn::Uniform, Yarn::Symmetric] {
            let counts = counts(yarn);
            if counts.is_empty() {
                continue;
            }
            let limit = statistics::arrest_limit(&counts);
            let mut row = vec![name.to_string(), yarn.name().to_string()];
            row.extend(columns.iter().map(|energy| {
                let found = counts.iter().find(|count| count.energy == *energy);
                found.map_or(String::new(), |count| format!("{}/{}", count.arrested, count.runs))
            }));
            row.push(limit.map_or("not bracketed".to_string(), |limit| limit.text(1)));
            let ratio = limit.zip(stochastic).filter(|_| yarn != Yarn::Stochastic);
            row.push(ratio.map_or(String::new(), |(limit, below)| Estimate::quotient(&limit, &below).text(2)));
            rows.push(row);
        }
    }
    let mut heading = vec!["washers".to_string(), "yarn".into()];
    heading.extend(columns.iter().map(|energy| format!("{energy} J")));
    heading.extend(["limit (J)".to_string(), "over stochastic".into()]);
    let heading: Vec<&str> = heading.iter().map(String::as_str).collect();
    page.table(&heading, &[1], &rows);
}
