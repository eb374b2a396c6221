//! xtask-tables: what is made of the tables in code, and what is checked in compiled libraries.

mod check;
mod gates;
mod size;
mod stack;

use xtask::tools::{Outcome, made, top};

fn main() -> std::process::ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    xtask::tools::ended(run(&words.iter().map(String::as_str).collect::<Vec<_>>()))
}

fn run(words: &[&str]) -> Outcome {
    match words {
        ["header", check @ ..] => written(capi_header::files()?, check, "cargo xtask header"),
        ["fmu", check @ ..] => written(fmu_pack::files()?, check, "cargo xtask fmu"),
        ["check", libraries @ ..] => check::run(libraries),
        ["gates"] => gates::run(),
        ["features"] => gates::every_feature_set(),
        ["size"] => size::run(),
        _ => Err(format!("unknown: {words:?}")),
    }
}

/// Writes what is made of the tables in code, or compares it with what is committed.
fn written(files: Vec<(String, String)>, check: &[&str], command: &str) -> Outcome {
    let files: Vec<_> = files.into_iter().map(|(name, text)| (top().join(name), text)).collect();
    made(&files, check == ["--check"], command)
}
