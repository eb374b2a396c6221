//! `cargo xtask demo`.

use crate::tools::Outcome;

/// Options of the command.
#[derive(clap::Args)]
pub struct Options {}

/// Runs the command.
pub fn run(_options: &Options) -> Outcome {
    Err("not built yet".into())
}
