//! xtask-tables: what is made of the tables in code, and what is checked in compiled libraries.

mod check;
mod gates;
mod size;
mod stack;

use xtask::tools::{Outcome, bail, ensure, shell};

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
        _ => bail!("unknown: {words:?}"),
    }
}

/// Writes what is made of the tables in code, or compares it with what is committed.
fn written(files: Vec<(String, String)>, check: &[&str], command: &str) -> Outcome {
    for (path, text) in files {
        if check != ["--check"] {
            shell().write_file(path, text)?;
        } else {
            let same = shell().read_file(&path).unwrap_or_default() == text;
            ensure!(same, "{path} is not what the sources give; run `{command}`");
        }
    }
    Ok(())
}
