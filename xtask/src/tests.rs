//! `cargo xtask test`, `verify` and `bench`: the checks, in the order in which they fail fastest.

use crate::tools::{Outcome, cargo};

/// Options of `cargo xtask test`.
#[derive(clap::Args)]
pub struct Options {}

/// Every check that a change must pass.
pub fn run(_options: &Options) -> Outcome {
    cargo(&["fmt", "--all", "--check"])?;
    cargo(&["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"])?;
    cargo(&["test", "--workspace"])?;
    crate::chosts::header_check()?;
    crate::chosts::run()
}

/// The long checks.
pub fn verify() -> Outcome {
    Err("not built yet".into())
}

/// ns per node-step.
pub fn bench() -> Outcome {
    Err("not built yet".into())
}
