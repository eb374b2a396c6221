//! Error over run time: work-precision diagrams, and a table of what to take for a wanted error.
//!
//! Two kinds of error, because the model is chaotic beyond the first failure. In the smooth phase (no contact, no failure)
//! positions can be compared point by point with a run at a much smaller step; the observed order is 2. Over a whole impact
//! only means over an ensemble mean something: runs that differ by 1e-12 in the impact velocity. Below the spread of those
//! runs (the chaos floor) no error is evidence.
//!
//! Cost is counted in node-steps: evaluations of the force on a node, one a step with velocity Verlet, one an iteration with
//! the theta rule. They are exact and the same on every machine; seconds of processor time stand beside them. (Instructions
//! of a node-step are counted by `bench`.) Rows of nodes that the wave has not reached are counted though they are skipped.
//!
//! Steps above 0.5 dt_crit are refused by the kernel; here they are run unchecked, to show why.
//!
//! | part | file |
//! |---|---|
//! | smooth phase: position and energy, the order | `smooth.rs` |
//! | closed forms: rotation, oscillator, long yarn | `closed_forms.rs` |
//! | overshoot of the undamped network: a strip under sudden impact | `overshoot.rs` |
//! | how far two runs stay together before the first failure | `pointwise.rs` |
//! | whole impacts: integrators, steps, quarter, coarser networks | `impact.rs`, `coarse.rs`, `quarter.rs` |
//! | a projectile moved by its host | `coupling.rs` |
//! | number of runs in a mean | `runs.rs` |
//! | Pareto front and the choice | `front.rs` |
//! | docs/accuracy.md | `document.rs` |

mod closed_forms;
mod coarse;
mod coupling;
mod document;
mod front;
mod impact;
mod overshoot;
mod pointwise;
mod quarter;
mod runs;
mod smooth;

use crate::machine;
use crate::plots::{Axes, Plot, Series, Style};
use crate::{Result, report};
use clap::Args;
use fabric::scene::STEP_MAX_FRACTION;
use fabric::{Integrator, IntegratorKind, Scene, StepCheck, TimeStep};
use std::path::{Path, PathBuf};

/// Options of `error-time`.
#[derive(Args)]
pub struct Options {
    /// Fewer runs in each mean and fewer settings: under three minutes on two cores.
    #[arg(long, conflicts_with = "smoke")]
    quick: bool,
    /// A small sheet and two runs in each mean: a check that everything works, not a result.
    #[arg(long)]
    smoke: bool,
    /// Only these parts.
    #[arg(long, value_enum, value_delimiter = ',')]
    only: Vec<Part>,
    /// Folder for the CSV files and plots.
    #[arg(long, value_name = "DIR", default_value = "target/study/error-time")]
    out: PathBuf,
    /// Also write accuracy.md and its pictures into this folder of documents; with --only the sections of the other parts stay.
    #[arg(long, value_name = "DIR")]
    docs: Option<PathBuf>,
}

/// A part of the study.
#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Part {
    Smooth,
    ClosedForms,
    Overshoot,
    Pointwise,
    Impact,
    Quarter,
    Coupling,
    Runs,
}

/// How much is run.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
pub enum Effort {
    /// Seconds: does it work?
    Smoke,
    /// Under three minutes on two cores.
    Quick,
    /// The figures of docs/accuracy.md.
    Full,
}

/// Measures, prints, writes. False if the observed order of the smooth phase is not 2 or a closed form is missed.
pub fn run(options: &Options) -> Result<bool> {
    let effort = match (options.smoke, options.quick) {
        (true, _) => Effort::Smoke,
        (_, true) => Effort::Quick,
        _ => Effort::Full,
    };
    let out = &options.out;
    std::fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))?;
    println!("machine: {}; times are {}", machine::processor(), machine::CLOCK_NAME);
    eprintln!(
        "warning: steps above {STEP_MAX_FRACTION} dt_crit are run unchecked here; everywhere else they are refused"
    );
    let wanted = |part: Part| options.only.is_empty() || options.only.contains(&part);
    let mut sound = true;
    let mut document = document::Document::new(effort);
    if wanted(Part::Smooth) {
        sound &= smooth::run(effort, out, &mut document)?;
    }
    if wanted(Part::ClosedForms) {
        sound &= closed_forms::run(effort, out, &mut document)?;
    }
    if wanted(Part::Overshoot) {
        sound &= overshoot::run(effort, out, &mut document)?;
    }
    if wanted(Part::Pointwise) {
        sound &= pointwise::run(effort, out, &mut document)?;
    }
    if wanted(Part::Quarter) {
        sound &= quarter::run(effort, out, &mut document)?;
    }
    if wanted(Part::Impact) {
        impact::run(effort, out, &mut document)?;
    }
    if wanted(Part::Runs) {
        runs::run(effort, out, &mut document)?;
    }
    if wanted(Part::Coupling) {
        coupling::run(effort, out, &mut document)?;
    }
    if let Some(folder) = &options.docs {
        document.write(folder, out)?;
        println!("written: {}", folder.join("accuracy.md").display());
    }
    println!("written: {}", out.display());
    Ok(sound)
}

/// The scene with a step of this fraction of dt_crit, unchecked above the limit.
fn with_step(mut scene: Scene, step: TimeStep, fraction: f64) -> Scene {
    scene.time_step = step;
    scene.step_check = if fraction > STEP_MAX_FRACTION { StepCheck::None } else { StepCheck::Refuse };
    scene
}

/// The theta rule with theta = 1/2 and this tolerance in node spacings.
fn theta(tolerance: f64) -> Integrator {
    Integrator { tolerance, ..Integrator::THETA }
}

/// Name of an integrator for tables.
fn integrator_name(integrator: Integrator) -> String {
    match integrator.kind {
        IntegratorKind::Verlet => "Verlet".to_string(),
        IntegratorKind::Theta => format!("theta, tolerance {:.0e}", integrator.tolerance),
    }
}

/// Evaluations of the forces on nodes so far, counted over the nodes modelled.
fn node_steps(sim: &fabric::Sim<'_>) -> f64 {
    let counters = sim.counters();
    let passes = if counters.iterations > 0 { counters.iterations } else { counters.steps };
    passes as f64 * sim.layout().nodes() as f64
}

/// A table that is printed, written as CSV in full precision, and shown in a document.
struct Table {
    heading: Vec<String>,
    rows: Vec<Vec<Cell>>,
}

/// One entry of a table.
#[derive(Clone)]
enum Cell {
    Text(String),
    /// A number, and how it is shown.
    Number(f64, String),
}

impl Cell {
    fn text(text: impl Into<String>) -> Cell {
        Cell::Text(text.into())
    }

    fn plain(value: f64, digits: usize) -> Cell {
        Cell::Number(value, if value.is_finite() { format!("{value:.digits$}") } else { "-".to_string() })
    }

    fn power(value: f64, digits: usize) -> Cell {
        Cell::Number(value, if value.is_finite() { format!("{value:.digits$e}") } else { "-".to_string() })
    }

    fn shown(&self) -> &str {
        match self {
            Cell::Text(text) | Cell::Number(_, text) => text,
        }
    }

    fn exact(&self) -> String {
        match self {
            Cell::Text(text) => text.clone(),
            Cell::Number(value, _) if value.is_finite() => format!("{value:e}"),
            Cell::Number(..) => String::new(),
        }
    }
}

impl Table {
    fn new(heading: &[&str]) -> Table {
        Table { heading: heading.iter().map(|name| name.to_string()).collect(), rows: Vec::new() }
    }

    fn add(&mut self, row: Vec<Cell>) {
        self.rows.push(row);
    }

    /// As it is printed, which is Markdown too.
    fn text(&self) -> String {
        let mut table = report::table(&self.heading.iter().map(String::as_str).collect::<Vec<_>>());
        for row in &self.rows {
            table.add_row(row.iter().map(Cell::shown).collect::<Vec<_>>());
        }
        table.to_string()
    }

    fn write_csv(&self, path: &Path) -> Result<()> {
        let mut writer = csv::Writer::from_path(path)?;
        writer.write_record(&self.heading)?;
        for row in &self.rows {
            writer.write_record(row.iter().map(Cell::exact))?;
        }
        writer.flush()?;
        Ok(())
    }
}

/// Name of the line that joins the points of a front; they have their marks already.
const FRONT: &str = "Pareto front";

/// A logarithmic plot of marked series and dashed levels across them.
fn plot_errors(
    path: &Path,
    title: &str,
    axes: [&str; 2],
    lines: Vec<(String, Vec<(f64, f64)>)>,
    levels: &[(&str, f64)],
) -> Result<()> {
    let positive = |x: f64| x.is_finite() && x > 0.0;
    let ends = lines.iter().flat_map(|(_, points)| points).filter(|point| positive(point.0) && positive(point.1));
    let (low, high) = ends.fold((f64::MAX, f64::MIN), |(low, high), point| (low.min(point.0), high.max(point.0)));
    let style = |name: &str| if name == FRONT { Style::Line } else { Style::Marked };
    let mut series: Vec<Series> =
        lines.into_iter().map(|(name, points)| Series::new(&*name, style(&name), points)).collect();
    series.retain(|line| line.points.iter().any(|point| positive(point.0) && positive(point.1)));
    if series.is_empty() {
        return Ok(());
    }
    for (name, level) in levels {
        let points = vec![(low, *level), (high, *level)];
        series.push(Series::new(*name, Style::Dashed, points));
    }
    Plot { title, x: axes[0], y: axes[1], axes: Axes::Logarithmic, series, marks: Vec::new() }.write(path)
}
