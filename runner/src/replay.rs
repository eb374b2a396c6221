//! A capsule done again: same bits, or where the first difference is.

use crate::memory::Buffers;
use crate::progress::Progress;
use crate::{Result, in_words, say};
use clap::Args;
use fabric_capsule::{Capsule, Replay, Seen};
use std::path::PathBuf;
use std::process::ExitCode;

/// Steps between two looks at the progress.
const STRIDE: u64 = 64;

/// Options of `replay`.
#[derive(Args)]
#[command(
    after_help = "Exit status: 0 same bits; 1 a difference, or a capsule that is cut off; 2 for what is refused."
)]
pub struct Options {
    /// The capsule.
    file: PathBuf,
}

/// Replays and prints what was found.
pub fn run(options: &Options) -> Result<ExitCode> {
    let name = options.file.display();
    let bytes = std::fs::read(&options.file).map_err(|error| format!("{name}: {error}"))?;
    let (capsule, cut) = match Capsule::open(&bytes) {
        Ok(capsule) => (capsule, None),
        // What a crash left.
        Err(broken) => match bytes.get(..broken.whole).map(Capsule::open) {
            Some(Ok(capsule)) if broken.what == fabric_capsule::What::Truncated => (capsule, Some(broken)),
            _ => return Err(format!("{name}: {broken}").into()),
        },
    };
    if capsule.version != fabric::VERSION {
        let (theirs, ours) = (capsule.version, fabric::VERSION);
        say::aside(format_args!(
            "warning: {name} was written by version {theirs}; this is {ours}, which may give other bits"
        ));
    }
    let scene = &capsule.scene;
    let refused =
        |error: &(dyn std::error::Error + 'static)| format!("{name}: its scene is refused: {}", in_words(error));
    let mut buffers = Buffers::of(scene).map_err(|error| refused(&*error))?;
    let mut sim = buffers.sim(scene).map_err(|error| refused(&error))?;

    let (mut replay, mut room) = (Replay::of(&capsule), vec![0.0; capsule.room()]);
    let progress = Progress::new(&format!("replay of {} calls", capsule.calls), capsule.steps);
    let difference = loop {
        let before = replay.steps;
        match replay.next(&mut sim, &mut room, STRIDE) {
            Ok(Seen::More) => {
                progress.add(replay.steps - before, || format!("call {}, step {}", replay.calls, sim.step_count()))
            }
            Ok(Seen::Same) => break None,
            Err(difference) => break Some(difference),
        }
    };
    progress.finish();
    let (calls, step) = (replay.calls, sim.step_count());
    if let Some(difference) = difference {
        let (call, at) = replay.equal;
        say::line(format_args!("{name}: differs at call {calls}, step {step}: {difference}"));
        match replay.digests {
            0 => say::line(format_args!(
                "The simulations are not alike from the start: another build, or another scene."
            )),
            _ => say::line(format_args!("The states were last found equal behind call {call}, at step {at}.")),
        }
        return Ok(ExitCode::FAILURE);
    }
    let end = if capsule.ended { "" } else { "; its program did not end it" };
    let digest = sim.digest();
    say::line(format_args!(
        "{name}: same bits: {calls} calls, {step} steps, {} digests, the last {digest:016x}{end}",
        replay.digests
    ));
    match cut {
        Some(broken) => Err(format!("{name}: {broken}; what is whole before it was replayed").into()),
        None => Ok(ExitCode::SUCCESS),
    }
}
