//! One run as a series of sheets, which `reports` writes as VTK files.

use super::plan::{self, Yarn};
use crate::effort::Effort;
use crate::memory::Buffers;
use crate::picture::{Picture, Series};
use crate::{Result, event};
use fabric::{AttachmentKind, Outcome};
use std::path::Path;

/// Impact energy of the run, J.
const ENERGY: f64 = 40.0;
/// Time between two sheets, s.
const PAUSE: f64 = 10e-6;
/// Longest run, s.
const LONGEST: f64 = 800e-6;

/// Runs the preset 3 in sheet held at its corners to its end and keeps its sheets.
pub fn series(out: &Path, effort: Effort) -> Result<Vec<Picture>> {
    let scene = plan::small(effort, AttachmentKind::FourCorners, Yarn::Stochastic, ENERGY).scene(effort, 0);
    let mut buffers = Buffers::of(&scene)?;
    let mut sim = buffers.sim(&scene)?;
    let mask = event::mask_of(&[Outcome::Arrested, Outcome::Exited]);
    let steps = (PAUSE / sim.step_limits().dt).round().max(1.0) as u64;
    let mut frames = Series::new(out, steps)?;
    while !sim.outcomes().mask.has(mask) && sim.time() < LONGEST {
        frames.keep(&sim)?;
        sim.advance_until(mask, steps).map_err(|failure| failure.to_string())?;
    }
    frames.end(&sim, &scene)
}
