//! `cargo xtask fuzz`: every fuzz target for some seconds under AddressSanitizer.

use crate::tools::{Outcome, cargo_tool, emptied, ensure, listed, sh, shell, target};
use std::path::{Path, PathBuf};
use xshell::Cmd;

#[derive(clap::Args)]
pub struct Options {
    /// How long each target runs, s.
    #[arg(long, default_value_t = 60)]
    seconds: u64,
    /// Only this target: scene, image, capsule, calls or fmi.
    #[arg(long, value_name = "NAME")]
    target: Option<String>,
    /// Afterwards put a small corpus that reaches the same code into an archive of tests/fuzz/corpus.
    #[arg(long)]
    minimise: bool,
}

/// The targets, as in `tests/fuzz/src/lib.rs`.
const TARGETS: [&str; 5] = ["scene", "image", "capsule", "calls", "fmi"];
/// Longest input, bytes. All that a target decodes of one is less.
const LONGEST: &str = "-max_len=160";

/// Without libFuzzer's finer features and statistics: they would take half of the time.
const QUICK: [&str; 3] = ["-len_control=0", "-entropic=0", "-use_counters=0"];

struct Run {
    executions: u64,
    crashes: u64,
}

pub fn run(options: &Options) -> Outcome {
    let chosen = |name: &&&str| options.target.as_deref().is_none_or(|wanted| wanted == **name);
    let names: Vec<_> = TARGETS.iter().filter(chosen).copied().collect();
    ensure!(!names.is_empty(), "no such target; there are {}", TARGETS.join(", "));
    println!("Building {} with AddressSanitizer (some minutes the first time) ...", names.join(", "));
    for name in &names {
        fuzz("build", name)?.run()?;
    }
    let runs: Vec<_> = names.iter().map(|name| campaign(name, options.seconds)).collect::<Outcome<_>>()?;
    if options.minimise {
        names.iter().try_for_each(|name| minimise(name))?;
    }
    let executions: u64 = runs.iter().map(|run| run.executions).sum();
    let crashes: u64 = runs.iter().map(|run| run.crashes).sum();
    println!("figure 12: {executions} executions in {} targets, {crashes} crashes", runs.len());
    ensure!(crashes == 0, "an input broke something: see above");
    Ok(())
}

/// A command of cargo-fuzz. Sanitizers are no stable feature of the compiler: it is switched on with
/// RUSTC_BOOTSTRAP, here alone.
fn fuzz(subcommand: &str, name: &str) -> Outcome<Cmd<'static>> {
    // Comparisons are not traced: the inputs are decoded by the byte, so that there is nothing to guess, and
    // it is twice as fast.
    let options = ["--fuzz-dir", "tests/fuzz", "--features", "fuzzer", "--no-trace-compares", "--target-dir"];
    let command = cargo_tool("cargo-fuzz")?.args(["fuzz", subcommand]).args(options);
    // A stack frame of its own for every call costs a third of the time.
    let command = command.env("RUSTC_BOOTSTRAP", "1").env("ASAN_OPTIONS", "detect_stack_use_after_return=0");
    Ok(command.arg(target().join("fuzz")).arg(name))
}

/// Where a campaign keeps what it finds, from run to run.
fn folder(kind: &str, name: &str) -> Outcome<PathBuf> {
    Ok(shell().create_dir(target().join("fuzz").join(kind).join(name))?)
}

/// One target for some seconds, from the committed corpus and what earlier runs have found. libFuzzer stops
/// at the first crash.
fn campaign(name: &str, seconds: u64) -> Outcome<Run> {
    let (corpus, crashes) = (folder("corpus", name)?, folder("crashes", name)?);
    let tally = target().join("fuzz").join(format!("{name}.tally"));
    shell().remove_path(&tally)?;
    println!("  {name}: {seconds} s ...");
    let command = fuzz("run", name)?.arg(&corpus).arg(committed(name)?).env("FABRIC_FUZZ_TALLY", &tally);
    let command = command.args(["--", LONGEST]).args(QUICK).args(["-verbosity=0", "-timeout=60"]);
    let options = [format!("-max_total_time={seconds}"), format!("-artifact_prefix={}/", crashes.display())];
    let broken = command.args(options).run().is_err();
    let (deep, executions) = counts(&tally);
    println!("  {name}: {executions} executions, {} % past the first check", percent(deep, executions));
    if broken {
        println!("  {name}: BROKEN. The input is in {}: put it into tests/fuzz/regressions/{name}.", crashes.display());
    }
    Ok(Run { executions, crashes: u64::from(broken) })
}

/// Inputs past the first check, and all.
fn counts(tally: &Path) -> (u64, u64) {
    let text = shell().read_file(tally).unwrap_or_default();
    let mut numbers = text.split_whitespace().map(|number| number.parse().unwrap_or(0));
    (numbers.next().unwrap_or(0), numbers.next().unwrap_or(0))
}

fn percent(part: u64, whole: u64) -> u64 {
    (100 * part + whole / 2).checked_div(whole).unwrap_or(0)
}

/// Replaces a committed corpus by the smallest inputs that reach the same edges.
fn minimise(name: &str) -> Outcome {
    let (found, small) = (folder("corpus", name)?, emptied(folder("small", name)?)?);
    let command = fuzz("run", name)?.args([&small, &found, &committed(name)?]);
    command.args(["--", LONGEST, "-set_cover_merge=1", "-use_counters=0"]).ignore_stderr().run()?;
    let archive = archive(name);
    let inputs = listed(&small)?;
    let words = ["--mtime=@0", "--owner=0", "--group=0", "--numeric-owner", "--mode=644", "-I", "gzip -9n"];
    println!("  {name}: {} inputs in {archive}", inputs.len());
    sh!("tar {words...} -cf {archive} -C {small} -- {inputs...}").run()?;
    Ok(())
}

fn archive(name: &str) -> String {
    format!("tests/fuzz/corpus/{name}.tar.gz")
}

/// The committed corpus of a target, unpacked.
fn committed(name: &str) -> Outcome<PathBuf> {
    let (folder, archive) = (emptied(folder("committed", name)?)?, archive(name));
    sh!("tar -xzf {archive} -C {folder}").run()?;
    Ok(folder)
}
