//! Error over run time: what work-precision diagrams, and the choice of a setting for a wanted error, are made of.
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
//! | overshoot of the undamped network, and viscosity against it: a strip under sudden impact | `overshoot.rs` |
//! | viscosity in whole impacts | `viscosity.rs` |
//! | how far two runs stay together before the first failure | `pointwise.rs` |
//! | whole impacts: integrators, steps, quarter, coarser networks | `impact.rs`, `coarse.rs`, `quarter.rs` |
//! | graded networks against the whole fabric | `grading.rs` |
//! | a projectile moved by its host | `coupling.rs` |
//! | number of runs in a mean | `runs.rs` |
//!
//! `python3 -m reports error-time` finds the Pareto front and the choice, draws, and writes the tables of docs/accuracy.md.

mod coarse;
mod coupling;
mod grading;
mod impact;
pub mod overshoot;
mod pointwise;
mod quarter;
mod runs;
mod smooth;
mod viscosity;

use crate::effort::{self, Effort};
use crate::machine;
use crate::table::{Cell, Table};
use crate::{Result, report, say};
use clap::Args;
use fabric::internals::parts::STEP_MAX_FRACTION;
use fabric::{Integrator, IntegratorKind, Scene, StepCheck, TimeStep};
use std::path::PathBuf;

/// Options of `error-time`.
#[derive(Args)]
pub struct Options {
    #[command(flatten)]
    flags: effort::Flags,
    /// Only these parts.
    #[arg(long, value_enum, value_delimiter = ',')]
    only: Vec<Part>,
    /// Folder for the CSV files.
    #[arg(long, value_name = "DIR", default_value = "target/study/error-time")]
    out: PathBuf,
}

/// A part of the study.
#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Part {
    Smooth,
    Overshoot,
    Viscosity,
    Pointwise,
    Impact,
    Grading,
    Quarter,
    Coupling,
    Runs,
}

/// Measures and writes. False if the observed order of the smooth phase is not 2 or the strip's mean strain is not the closed form's.
pub fn run(options: &Options) -> Result<bool> {
    let effort = options.flags.effort();
    let out = &options.out;
    std::fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))?;
    say::line(format_args!("machine: {}; times are {}", machine::processor(), machine::CLOCK_NAME));
    let about = serde_json::json!({
        "effort": effort.option(),
        "machine": machine::processor(), "clock": machine::CLOCK_NAME,
    });
    std::fs::write(out.join("error-time.json"), about.to_string())?;
    say::aside(format_args!(
        "warning: steps above {STEP_MAX_FRACTION} dt_crit are run unchecked here; everywhere else they are refused"
    ));
    let wanted = |part: Part| options.only.is_empty() || options.only.contains(&part);
    let mut sound = true;
    if wanted(Part::Smooth) {
        sound &= smooth::run(effort, out)?;
    }
    if wanted(Part::Overshoot) {
        sound &= overshoot::run(effort, out)?;
    }
    if wanted(Part::Viscosity) {
        viscosity::run(effort, out)?;
    }
    if wanted(Part::Pointwise) {
        sound &= pointwise::run(effort, out)?;
    }
    if wanted(Part::Quarter) {
        sound &= quarter::run(effort, out)?;
    }
    if wanted(Part::Impact) {
        impact::run(effort, out)?;
    }
    if wanted(Part::Grading) {
        grading::run(effort, out)?;
    }
    if wanted(Part::Runs) {
        runs::run(effort, out)?;
    }
    if wanted(Part::Coupling) {
        coupling::run(effort, out)?;
    }
    say::line(format_args!("{}", report::written(out, "error-time")));
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
