//! xtask-tables: what is made of the tables in code, and what is checked in compiled libraries.

mod check;
mod description;
mod gates;
mod header;
mod outputs;
mod page;
mod parameters;
mod size;
mod stack;
mod xml;

use xtask::tools::{Outcome, made, top};

fn main() -> std::process::ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    xtask::tools::ended(run(&words.iter().map(String::as_str).collect::<Vec<_>>()))
}

fn run(words: &[&str]) -> Outcome {
    match words {
        ["header", check @ ..] => header::run(check == ["--check"]),
        ["fmu", check @ ..] => fmu(check == ["--check"]),
        ["check", libraries @ ..] => check::run(libraries),
        ["gates"] => gates::run(),
        ["features"] => gates::every_feature_set(),
        ["size"] => size::run(),
        _ => Err(format!("unknown: {words:?}")),
    }
}

/// What `cargo xtask fmu` makes of the tables, or the comparison with what is committed.
fn fmu(check: bool) -> Outcome {
    let tables = [
        ("modelDescription/fmi2.xml".into(), description::fmi2()),
        ("modelDescription/fmi3.xml".into(), description::fmi3()),
        ("modelDescription/documentation/index.html".into(), page::page()),
        ("docs/tables/scene.md".into(), parameters::table()),
        ("docs/tables/outputs.md".into(), outputs::table()),
    ];
    let files = tables.into_iter().chain(parameters::sets()?).chain([outputs::types()?]);
    let files: Vec<_> = files.map(|(name, text)| (top().join(name), text)).collect();
    made(&files, check, "cargo xtask fmu")
}
