//! The map: time step against impact velocity on a small sheet, by the energy that the step creates.

use super::flight::{scale, unchecked, uniform};
use crate::Result;
use crate::memory::Buffers;
use crate::progress::Progress;
use fabric::Outcome;
use rayon::prelude::*;
use serde::Serialize;
use std::path::Path;

/// Nodes of the sheet along a side.
const NODES: u32 = 41;
/// Time every run lasts, s.
const TIME: f64 = 150e-6;
const FRACTIONS: [f64; 13] = [0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2];
const SPEEDS: [f64; 11] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0];

/// One run of the map.
#[derive(Serialize)]
pub struct Cell {
    /// dt over dt_crit.
    pub fraction: f64,
    /// Impact velocity, m/s.
    pub speed: f64,
    /// Energy residual over the impact energy; infinite if the run ended in a failure.
    pub energy: f64,
    /// Segments that failed.
    pub failed_segments: u64,
    /// What became of the projectile.
    pub outcome: &'static str,
}

/// Steps and velocities to run; every second one in a coarse map.
pub fn cells(coarse: bool) -> Vec<(f64, f64)> {
    let stride = if coarse { 2 } else { 1 };
    let speeds = SPEEDS.into_iter().step_by(stride);
    speeds.flat_map(|speed| FRACTIONS.into_iter().step_by(stride).map(move |fraction| (fraction, speed))).collect()
}

/// Runs them all.
pub fn compute(cells: &[(f64, f64)]) -> Result<Vec<Cell>> {
    let progress = Progress::new("stability map", cells.len() as u64);
    let run = |&(fraction, speed): &(f64, f64)| {
        let cell = cell(fraction, speed).map_err(|error| error.to_string());
        progress.add(1, || format!("{fraction} dt_crit, {speed} m/s"));
        cell
    };
    let cells: std::result::Result<Vec<Cell>, String> = cells.par_iter().map(run).collect();
    progress.finish();
    Ok(cells?)
}

fn cell(fraction: f64, speed: f64) -> Result<Cell> {
    let scene = unchecked(uniform(NODES, speed), fraction);
    let mut buffers = Buffers::of(&scene)?;
    let mut sim = buffers.sim(&scene)?;
    let start = scale(&sim)?;
    let steps = (TIME / sim.step_limits().dt) as u64;
    if sim.advance(steps).is_err() {
        let failed_segments = sim.counters().failed_segments;
        return Ok(Cell { fraction, speed, energy: f64::INFINITY, failed_segments, outcome: "faulted" });
    }
    let (energy, found) = (sim.energy()?, sim.outcomes());
    let latched = |outcome: Outcome| found.mask.has(outcome);
    let outcome = if latched(Outcome::Exited) {
        "exited"
    } else if latched(Outcome::Arrested) {
        "arrested"
    } else {
        "in contact"
    };
    Ok(Cell {
        fraction,
        speed,
        energy: energy.residual / start,
        failed_segments: sim.counters().failed_segments,
        outcome,
    })
}

/// The numbers.
pub fn write_csv(cells: &[Cell], path: &Path) -> Result<()> {
    let mut writer = csv::Writer::from_path(path)?;
    cells.iter().try_for_each(|cell| writer.serialize(cell))?;
    Ok(writer.flush()?)
}
