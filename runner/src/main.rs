//! Single runs and studies of the fabric kernel, on the host.
//!
//! Everything a command prints or writes is reproducible to the bit, except times and what is computed from them.
#![allow(clippy::disallowed_methods)] // A host program: std floats do no harm here.
#![warn(clippy::print_stdout, clippy::print_stderr)] // They panic when their reader has gone: say.rs.

mod bench;
mod event;
mod fabrics;
mod machine;
mod picture;
mod progress;
mod replay;
mod report;
mod run;
mod say;
mod threads;

use clap::{Parser, Subcommand};
use fabric_scene::memory;
use std::process::ExitCode;

/// What a command returns: a sentence for the user if it could not do its work.
type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Runs and studies of ballistic fabric under rigid-projectile impact.
#[derive(Parser)]
#[command(name = "fabric", version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run one scene: table, history, the sheet at the end.
    Run(run::Options),
    /// Do again what a capsule has of a simulation, and compare bit by bit.
    Replay(replay::Options),
    /// Print a preset, or a scene file with its fabric, as a scene file with every parameter, its unit and its meaning.
    Scene {
        #[arg(help = scene_help())]
        scene: String,
    },
    /// List the named fabrics for the table [fabric] of a scene file.
    Fabrics {
        /// Print this one's numbers with their sources.
        name: Option<String>,
    },
    /// Measure ns per node-step: bare sweep and whole run over sheet sizes and instruction sets.
    Bench(bench::Options),
}

/// What a command that takes a scene says of it.
fn scene_help() -> String {
    format!("A scene file, see runner/scenes, or one of the presets {}", fabric_scene::preset_names())
}

/// An error's text; of the kernel's errors with the numbers, which the kernel itself cannot print.
fn in_words(error: &(dyn std::error::Error + 'static)) -> String {
    let Some(refused) = error.downcast_ref::<fabric::Error>() else { return error.to_string() };
    let fabric::Error { code, value, limit, .. } = *refused;
    match code {
        // Its text has the number.
        fabric::Code::NotPositive => refused.to_string(),
        _ if (value, limit) == (0.0, 0.0) => refused.to_string(),
        _ if value.is_nan() => format!("{refused} (given NaN, which is not a number)"),
        fabric::Code::ProjectileTooFast => {
            format!("{refused} (given {value:.6e} m/s): take time_step = {{ seconds = {limit:e} }} or less")
        }
        fabric::Code::InitialOverlap => {
            format!(
                "{refused}, {:.3e} m deep: move projectile.position away from the sheet, or give [aim]",
                value.abs()
            )
        }
        fabric::Code::OutOfRange => match fabric::fields::field(refused.field).map(|field| field.limits()) {
            Some([least, greatest]) if !(least..=greatest).contains(&value) => {
                format!("{refused}; it goes from {least} to {greatest}")
            }
            _ => format!("{refused}; the limit is {limit}"),
        },
        _ if limit == 0.0 => format!("{refused} (given {value:.6e})"),
        _ => format!("{refused} (given {value:.6e}, the limit is {limit:.6e})"),
    }
}

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Run(options) => return ended(run::run(&options)),
        Command::Replay(options) => return ended(replay::run(&options)),
        Command::Scene { scene } => fabric_scene::whole(&scene).map(|text| {
            say::text(format_args!("{text}"));
            true
        }),
        Command::Fabrics { name } => fabrics::print(name.as_deref()),
        Command::Bench(options) => bench::run(&options),
    };
    ended(result.map(|sound| if sound { ExitCode::SUCCESS } else { ExitCode::FAILURE }))
}

/// The exit status; of what cannot be done after its reason.
fn ended(result: Result<ExitCode>) -> ExitCode {
    result.unwrap_or_else(|error| {
        say::aside(format_args!("error: {}", in_words(&*error)));
        ExitCode::from(2)
    })
}
