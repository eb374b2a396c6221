//! `cargo xtask coverage`: lines of the kernel and its interfaces that the tests in Rust run, by cargo-llvm-cov.

use crate::records::{self, Figure};
use crate::tools::{Outcome, output};
use std::collections::BTreeMap;

/// Lines that should be run.
const WANTED: f64 = 98.0;

/// Measures and writes docs/reliability/coverage.toml.
pub fn run() -> Outcome {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    if output(&cargo, &["llvm-cov", "--version"]).is_err() {
        println!(
            "  cargo-llvm-cov is not here: not measured (`cargo install cargo-llvm-cov`; it needs llvm-tools of the compiler)"
        );
        return Ok(());
    }
    let packages = ["fabric-kernel", "fabric-capi", "fabric-fmu", "fabric-tests"];
    let packages: Vec<_> = packages.iter().flat_map(|name| ["--package", name]).collect();
    let features = ["--features", "fabric-kernel/micro,fabric-kernel/implicit"];
    let text = output(&cargo, &[&["llvm-cov", "--json", "--summary-only"], &packages[..], &features[..]].concat())?;
    let report: Report = serde_json::from_str(&text).map_err(|error| format!("cargo llvm-cov: {error}"))?;
    let mut parts: BTreeMap<&str, (u64, u64)> = BTreeMap::new();
    let part_of =
        |name: &str| ["kernel/src", "capi/src", "fmu/src"].into_iter().find(|part| name.contains(&format!("/{part}/")));
    for file in report.data.iter().flat_map(|data| &data.files) {
        let Some(part) = part_of(&file.filename) else { continue };
        let lines = &file.summary.lines;
        let sum = parts.entry(part).or_default();
        *sum = (sum.0 + lines.covered, sum.1 + lines.count);
        println!("  {:5} of {:5} lines: {}", lines.covered, lines.count, file.filename);
    }
    let percent = |(covered, count): (u64, u64)| 100.0 * covered as f64 / count as f64;
    let shown: Vec<_> = parts.iter().map(|(part, sum)| format!("{part} {:.1} %", percent(*sum))).collect();
    let kernel = parts.get("kernel/src").copied().ok_or("cargo llvm-cov lists no file of the kernel")?;
    let row = Figure {
        number: "14",
        figure: "line coverage by the tests in Rust (the interfaces are also run by C, C++ and Python hosts, not counted)",
        value: &shown.join(", "),
        floor: &format!("{WANTED} % of the kernel"),
        reached: percent(kernel) >= WANTED,
        command: "cargo xtask coverage",
    };
    println!("figure 14: {}", row.value);
    records::write("coverage", row.command, &[row.now()?], "")
}

/// The part of the report that is read.
#[derive(serde::Deserialize)]
struct Report {
    data: Vec<Data>,
}

#[derive(serde::Deserialize)]
struct Data {
    files: Vec<File>,
}

#[derive(serde::Deserialize)]
struct File {
    filename: String,
    summary: Summary,
}

#[derive(serde::Deserialize)]
struct Summary {
    lines: Lines,
}

#[derive(serde::Deserialize)]
struct Lines {
    covered: u64,
    count: u64,
}
