//! `bench --compare REV`: this program against that of another revision, in turn, so that the machine's load meets both alike.
//!
//! Method: git checks the revision out into a folder of the target folder, cargo builds it there, and its program is kept for the
//! next time. Both then measure the same cases in turn, as programs of their own, each going first in every other pair. What
//! is told is the ratio of their medians within a pair: its median over the pairs, and half the range of the middle half of them as noise.
//! Limits: cases that both revisions have under the same name; a load that changes within a pair, some seconds, is not cancelled.

use super::programs::{folder, output, top};
use crate::machine;
use crate::progress::Progress;
use crate::report::{median, noise, table};
use crate::{Result, say};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What is compared if nothing is chosen.
const CASES: [&str; 4] = ["sweep 105", "run 105", "sweep 350", "run 350"];

/// What is measured of one case, done one way.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    case: String,
    size: u32,
    instruction_set: String,
    threads: u32,
}

/// A row of bench.json, as far as every revision writes it.
#[derive(Deserialize)]
struct Row {
    case: String,
    size: u32,
    instruction_set: String,
    threads: u32,
    median: Option<f64>,
    digest: Option<String>,
}

/// The rows that are read of bench.json.
#[derive(Deserialize)]
struct Measured {
    rows: Vec<Row>,
}

/// All pairs of one key: the other revision's ns and this one's, and whether the bits differed in any.
#[derive(Default)]
struct Pairs {
    ns: [Vec<f64>; 2],
    bits_differ: bool,
}

/// A line of compare.json.
#[derive(Serialize)]
struct Line {
    case: String,
    size: u32,
    instruction_set: String,
    threads: u32,
    /// Medians of the other revision and of this one, ns per node-step.
    ns: [f64; 2],
    /// Median of this one's time over the other's in the same pair.
    ratio: f64,
    /// Half the range of the middle half of the ratios over their median.
    noise: f64,
    same_bits: bool,
}

/// Compares, prints and writes compare.json. `only`: one case, or none for those above. False if the bits differ.
pub fn run(revision: &str, only: &str, instructions: &str, pairs: usize, out: &Path) -> Result<bool> {
    let programs = [build(revision)?, std::env::current_exe()?];
    let cases = if only.is_empty() { CASES.to_vec() } else { vec![only] };
    let progress = Progress::new("compare", (cases.len() * pairs) as u64);
    let load = machine::load();
    let mut found: BTreeMap<Key, Pairs> = BTreeMap::new();
    for case in &cases {
        for pair in 0..pairs {
            let mut rows = [Vec::new(), Vec::new()];
            for which in [pair % 2, 1 - pair % 2] {
                rows[which] = measure(&programs[which], case, instructions, out)?;
            }
            let [before, now] = rows;
            for (key, ns, digest) in now {
                let Some((_, ns_before, digest_before)) = before.iter().find(|(other, ..)| *other == key) else {
                    continue;
                };
                let pairs = found.entry(key).or_default();
                pairs.ns[0].push(*ns_before);
                pairs.ns[1].push(ns);
                pairs.bits_differ |= digest != *digest_before;
            }
            progress.add(1, || case.to_string());
        }
    }
    progress.finish();
    let lines: Vec<Line> = found.into_iter().map(|(key, pairs)| line(key, &pairs)).collect();
    if lines.is_empty() {
        return Err(format!("nothing that both revisions measure is called {only:?}").into());
    }
    print(revision, &lines, pairs, load);
    std::fs::write(out.join("compare.json"), serde_json::to_string_pretty(&lines)? + "\n")?;
    Ok(lines.iter().all(|line| line.same_bits))
}

fn line(key: Key, pairs: &Pairs) -> Line {
    let Key { case, size, instruction_set, threads } = key;
    let [before, now] = &pairs.ns;
    let ratios: Vec<f64> = now.iter().zip(before).map(|(now, before)| now / before).collect();
    Line {
        case,
        size,
        instruction_set,
        threads,
        ns: [median(before), median(now)],
        ratio: median(&ratios),
        noise: noise(&ratios),
        same_bits: !pairs.bits_differ,
    }
}

fn print(revision: &str, lines: &[Line], pairs: usize, load: Option<f64>) {
    let shown = |load: Option<f64>| load.map_or("unknown".to_string(), |load| format!("{load:.2}"));
    say::line(format_args!("machine: {}", machine::processor()));
    say::line(format_args!("{pairs} pairs; load at the start {}, at the end {}", shown(load), shown(machine::load())));
    let heading =
        ["case", "nodes", "instructions", "threads", &format!("ns, {revision}"), "ns, now", "ratio", "noise", "bits"];
    let row = |line: &Line| {
        vec![
            line.case.clone(),
            format!("{0} x {0}", line.size),
            line.instruction_set.clone(),
            line.threads.to_string(),
            format!("{:.2}", line.ns[0]),
            format!("{:.2}", line.ns[1]),
            format!("{:.3}", line.ratio),
            format!("{:.1} %", 100.0 * line.noise),
            if line.same_bits { "same" } else { "DIFFERENT" }.to_string(),
        ]
    };
    say::line(format_args!("{}", table(&heading, &lines.iter().map(row).collect::<Vec<_>>())));
}

/// One program's medians, and digests.
fn measure(program: &Path, case: &str, instructions: &str, out: &Path) -> Result<Vec<(Key, f64, Option<String>)>> {
    let folder = out.join("pair");
    let mut command = Command::new(program);
    command.args(["bench", "--quick", "--only", case, "--instructions", instructions, "--out"]).arg(&folder);
    output(&mut command)?;
    let text = std::fs::read_to_string(folder.join("bench.json"))?;
    let Measured { rows } = serde_json::from_str(&text)?;
    let named = |row: Row| {
        let Row { case, size, instruction_set, threads, median, digest } = row;
        Some((Key { case, size, instruction_set, threads }, median?, digest))
    };
    Ok(rows.into_iter().filter_map(named).collect())
}

/// The program of a revision: built if it is not there yet.
fn build(revision: &str) -> Result<PathBuf> {
    let git = |arguments: &[&str]| output(Command::new("git").current_dir(top()).args(arguments));
    let (commit, _) = git(&["rev-parse", "--verify", "--short=12", &format!("{revision}^{{commit}}")])?;
    let commit = commit.trim();
    let folder = folder("compare")?;
    let program = folder.join(format!("fabric-{commit}{}", std::env::consts::EXE_SUFFIX));
    if program.exists() {
        return Ok(program);
    }
    let checkout = folder.join(commit);
    let place = checkout.to_string_lossy().into_owned();
    say::aside(format_args!("building {revision} ({commit}) ..."));
    if !checkout.exists() {
        git(&["worktree", "add", "--detach", "--force", &place, commit])?;
    }
    let built = folder.join("build");
    // Until version 0.1.0 folder, package and program had other names.
    let manifest = ["runner", "study"].map(|folder| std::fs::read_to_string(checkout.join(folder).join("Cargo.toml")));
    let [now, before] = manifest;
    let manifest = now.or(before)?;
    let name = manifest.lines().find_map(|line| line.strip_prefix("name = ")).unwrap_or_default().trim_matches('"');
    let mut cargo = Command::new("cargo");
    cargo.current_dir(&checkout).args(["build", "--release", "--package", name, "--target-dir"]).arg(&built);
    let result = output(&mut cargo);
    git(&["worktree", "remove", "--force", &place])?;
    result?;
    std::fs::copy(built.join("release").join(name).with_extension(std::env::consts::EXE_EXTENSION), &program)?;
    Ok(program)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_are_taken_pair_by_pair() {
        let key = Key { case: "run".to_string(), size: 105, instruction_set: "avx2".to_string(), threads: 1 };
        // The machine is three times as slow in the second pair.
        let pairs = Pairs { ns: [vec![2.0, 6.0, 2.0], vec![1.8, 5.4, 1.8]], bits_differ: false };
        let line = line(key, &pairs);
        assert!((line.ratio - 0.9).abs() < 1e-15 && line.noise < 1e-15);
        assert_eq!(line.ns, [2.0, 1.8]);
    }
}
