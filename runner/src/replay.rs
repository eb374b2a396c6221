//! `fabric replay`: prints what a replay found.

use crate::progress::Progress;
use crate::{Result, in_words, say};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// Options of `replay`.
#[derive(Args)]
#[command(
    after_help = "Exit status: 0 same bits; 1 a difference, or a capsule that is cut off; 2 for what is refused."
)]
pub struct Options {
    /// The capsule, as `fabric run --capsule`, Python's `Simulation(..., capsule=FILE)`, C or an FMU wrote it.
    file: PathBuf,
}

/// Replays and prints.
pub fn run(options: &Options) -> Result<ExitCode> {
    let name = options.file.display();
    let bytes = std::fs::read(&options.file).map_err(|error| format!("{name}: {error}"))?;
    let (progress, mut before) = (Progress::new(&format!("replay of {name}, of its steps"), 100), 0);
    let found = fabric_scene::replay::replay(&bytes, |steps, all, place| {
        let percent = 100 * steps / all.max(1);
        progress.add(percent - before, || place.to_string());
        before = percent;
        true
    });
    progress.finish();
    let found = found.map_err(|error| format!("{name}: {}", in_words(&*error)))?;
    if found.version != fabric::VERSION {
        let (theirs, ours) = (&found.version, fabric::VERSION);
        say::aside(format_args!("warning: {name} is of version {theirs}, this is {ours}, which may give other bits"));
    }
    let (calls, step, digests) = (found.calls, found.step, found.digests);
    let end = if found.ended { "" } else { "; its program did not end it" };
    match &found.difference {
        Some(difference) => say::line(format_args!("{name}: {difference}")),
        None => say::line(format_args!(
            "{name}: same bits: {calls} calls, {step} steps, {digests} digests, the last {:016x}{end}",
            found.digest
        )),
    }
    if let Some(broken) = found.cut {
        say::aside(format_args!("error: {name}: {broken}; what is whole before it was replayed"));
    }
    let whole = found.difference.is_none() && found.cut.is_none();
    Ok(if whole { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
