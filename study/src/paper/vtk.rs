//! One run as a series of sheets, which `reports` writes as VTK files.

use super::plan::{self, Yarn};
use crate::effort::Effort;
use crate::memory::Buffers;
use crate::picture::{self, Picture};
use crate::progress::Progress;
use crate::{Result, event};
use fabric::{AttachmentKind, Outcome};
use std::path::Path;

/// Impact energy of the run, J.
const ENERGY: f64 = 40.0;
/// Time between two frames, s.
const PAUSE: f64 = 10e-6;
/// Most frames.
const FRAMES: usize = 80;

/// Runs the preset 3 in sheet held at its corners and keeps its sheets in `out`/frames.
pub fn series(out: &Path, effort: Effort) -> Result<Vec<Picture>> {
    let folder = out.join("frames");
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let scene = plan::small(effort, AttachmentKind::FourCorners, Yarn::Stochastic, ENERGY).scene(effort, 0);
    let mut buffers = Buffers::of(&scene)?;
    let mut sim = buffers.sim(&scene)?;
    let mask = event::mask_of(&[Outcome::Arrested, Outcome::Exited]);
    let steps = (PAUSE / sim.step_limits().dt).round().max(1.0) as u64;
    let progress = Progress::new("series of sheets, of the most frames", FRAMES as u64);
    let mut frames = Vec::new();
    for frame in 0..FRAMES {
        let file = format!("frames/{frame:04}.bin");
        picture::keep(&out.join(&file), &sim)?;
        frames.push(picture::describe(out, file, format!("frame {frame}"), &scene)?);
        progress.add(1, || format!("{:.0} us", 1e6 * sim.time()));
        if sim.outcomes().mask.has(mask) {
            break;
        }
        sim.advance_until(mask, steps).map_err(|failure| failure.to_string())?;
    }
    progress.finish();
    Ok(frames)
}
