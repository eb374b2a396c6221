//! `cargo xtask bench`: ns per node-step of the bare sweep and of whole runs over sheet sizes and instruction
//! sets.
//!
//! Everything that is printed or written is reproducible to the bit, except times and what is computed from
//! them.
#![allow(clippy::disallowed_methods)] // A host program: std floats do no harm here.
#![warn(clippy::print_stdout, clippy::print_stderr)] // They panic when their reader has gone: say.rs.

mod bench;
mod machine;
mod progress;
mod report;
mod say;
mod threads;

use clap::Parser;
use fabric_scene::memory;
use std::process::ExitCode;

/// What a function returns: a sentence for the user if it could not do its work.
type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Measures ns per node-step: bare sweep and whole run over sheet sizes and instruction sets.
#[derive(Parser)]
#[command(name = "fabric-bench", version)]
struct Arguments {
    #[command(flatten)]
    options: bench::Options,
}

fn main() -> ExitCode {
    match bench::run(&Arguments::parse().options) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            say::aside(format_args!("error: {error}"));
            ExitCode::from(2)
        }
    }
}
