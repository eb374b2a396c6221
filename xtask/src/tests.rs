//! `cargo xtask test`, `verify` and `bench`: the checks, in the order in which they fail fastest.

use crate::platforms::Targets;
use crate::tools::{
    Context as _, Outcome, PUBLISHED, STEP_LEFT_OUT, all_left_out, anyhow, bail, emptied, ensure, last_time, py_tests,
    python_with, said, sh, shell, step_left_out, tables, target,
};
use crate::{fmu, wheel::installed};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::Instant;

#[derive(clap::Args)]
pub struct Options {
    /// Also the steps that only a release or continuous integration waits for: other platforms, sets of
    /// features, studies.
    #[arg(long)]
    all: bool,
    /// Run only the steps whose name contains this text (repeatable).
    #[arg(long, value_name = "TEXT")]
    only: Vec<String>,
    /// Refuse to leave anything out that the packages of `cargo xtask packages` bring.
    #[arg(long)]
    complete: bool,
    /// Only the second half of the steps, until this file is there.
    #[arg(long, hide = true, value_name = "FILE", conflicts_with = "only")]
    second_until: Option<PathBuf>,
}

/// Which commands run a step.
#[derive(Clone, Copy, PartialEq)]
enum When {
    Always,
    /// `cargo xtask test --all`.
    All,
    /// `cargo xtask test`; a longer step of `--all` has the same checks and more.
    Short,
}
use When::{All, Always, Short};

struct Step(When, &'static str, fn() -> Outcome);

/// Checks of a change, in two halves that take the same time side by side: the first compiles for development
/// and for the targets of the digests, the second what is shipped.
const FIRST: &[Step] = &[
    Step(Always, "documentation: words and sentences of the pages", || {
        Ok(sh!("python3 tests/structure/pages.py").run()?)
    }),
    Step(Always, "format", style),
    Step(Always, "clippy", || {
        with_cargo("clippy")?;
        Ok(sh!("cargo clippy --quiet --workspace --all-targets --features {EVERY_FEATURE} -- -D warnings").run()?)
    }),
    Step(Always, "unit, physics, golden and robustness tests", || {
        Ok(sh!("cargo test --quiet --workspace --features {EVERY_FEATURE}").run()?)
    }),
    Step(Always, "C header", || tables(&["header", "--check"])),
    Step(All, "every set of features", || tables(&["features"])),
    Step(All, "documentation", documentation),
    Step(All, "documentation as a site", crate::site::check),
    Step(All, "package of the kernel", package),
    Step(All, "web page in a browser", crate::web::check),
    Step(All, "digests on other targets", crate::digests::short),
    Step(All, "studies in short form", studies),
];

/// The other half.
const SECOND: &[Step] = &[
    Step(All, "gates on the libraries", || tables(&["gates"])),
    Step(Always, "C and C++ hosts", crate::chosts::run),
    Step(Always, "binary interface", crate::abi::run),
    Step(All, "C and C++ examples", crate::examples::run),
    Step(Short, "FMUs for this platform", || fmus(Targets::Host)),
    Step(All, "FMUs", || fmus(Targets::All)),
    Step(All, "rotorburst in two forms", || crate::rotorburst::run(&crate::rotorburst::Options { short: true })),
    Step(Always, "Python package", crate::wheel::test),
    Step(Always, "pages: what their commands print", || pages(false)),
    Step(All, "demo in short form", || crate::demo::run(&crate::demo::Options { quick: true })),
];

/// What the kernel does not have by default. Where a step builds it with others, it is one more build.
const EVERY_FEATURE: &str = "fabric-kernel/micro,fabric-kernel/internals";

/// Form of the sources: rustfmt's, and ruff's and mypy's as pyproject.toml has them.
fn style() -> Outcome {
    let python = python_with("tests/requirements.txt")?;
    let ruff = python.with_file_name("ruff");
    sh!("{ruff} format --quiet --diff").run()?;
    sh!("{ruff} check --quiet").run()?;
    sh!("{python} -m mypy --no-error-summary").run()?;
    with_cargo("fmt")?;
    Ok(sh!("cargo fmt --all --check").run()?)
}

/// Leaves out the step without a command of cargo's that may not be installed.
fn with_cargo(name: &str) -> Outcome {
    if crate::needs::cargo_has(name) {
        return Ok(());
    }
    step_left_out(&format!("no cargo {name}: rustup component add rustfmt clippy"))
}

/// Programs and commands of all pages print what the pages say, with or without those that take minutes.
fn pages(long: bool) -> Outcome {
    crate::chosts::installed()?;
    crate::fmu::packed(Targets::Host, false)?;
    let python = installed()?;
    python_with("tests/fmi/requirements.txt")?;
    if !long {
        return py_tests(&python, "tests/pages");
    }
    Ok(sh!("{python} -m pytest -q -n 2 -rP -p no:cacheprovider --long tests/pages").run()?)
}

/// The long checks, by hand before a release.
const VERIFY: &[Step] = &[
    Step(Always, "release, built in two folders and tried", || {
        crate::release::run(&crate::release::Options { reproduce: true, smoke: true })
    }),
    Step(Always, "digests on every target", || crate::digests::run(&crate::digests::Options::default())),
    Step(Always, "sanitizers", crate::sanitize::run),
    Step(Always, "tests that take minutes: searches, random hits", || {
        Ok(sh!("cargo test --quiet --package fabric-tests --test physics --test stability -- --ignored").run()?)
    }),
    Step(Always, "error against run time", error_time),
    Step(Always, "map of stability, and its table", || {
        as_committed("stability", &["tables/stability_1.csv", "images/stability_map.svg"])
    }),
    Step(Always, "pages, with the commands that take minutes", || pages(true)),
    Step(Always, "validation, and its table", || as_committed("validation", &["tables/validation.md"])),
    Step(Always, "FMU reference results", || {
        let python = python_with("tests/fmi/requirements.txt")?;
        Ok(sh!("{python} tests/fmi/reference.py --check").run()?)
    }),
    Step(Always, "licences, sources and bans of the dependencies", crate::examples::deny),
];

/// rustdoc without warnings; every public item of kernel, C interface and FMU is documented.
fn documentation() -> Outcome {
    let packages = ["-p", "fabric-kernel", "-p", "fabric-host", "-p", "fabric-capi", "-p", "fabric-fmu"];
    let command = sh!("cargo doc --quiet --no-deps {packages...} --features fabric-kernel/micro");
    // What is private to a host is named without a link.
    Ok(command.env("RUSTDOCFLAGS", "-D warnings -A rustdoc::private-intra-doc-links").run()?)
}

/// Builds of the crates as crates.io would get them, and of their documentation as docs.rs would.
fn package() -> Outcome {
    sh!("cargo package --quiet {PUBLISHED...} --allow-dirty").run()?;
    let packed = target().join(format!("package/fabric-kernel-{}/Cargo.toml", env!("CARGO_PKG_VERSION")));
    for name in ["LICENSE-MIT", "LICENSE-APACHE"] {
        ensure!(packed.with_file_name(name).is_file(), "the package of the kernel has no {name}");
    }
    let folder = target().join("package/docs");
    let options = ["--quiet", "--no-deps", "--features", "micro"];
    Ok(sh!("cargo doc {options...} --manifest-path {packed} --target-dir {folder}").run()?)
}

pub fn run(options: &Options) -> Outcome {
    let wanted = |&&Step(when, name, _): &&Step| match when {
        _ if !options.only.is_empty() => when != Short && options.only.iter().any(|text| name.contains(text.as_str())),
        Always => true,
        All => options.all,
        Short => !options.all,
    };
    if let Some(stop) = &options.second_until {
        let done = steps(SECOND.iter().filter(wanted), || stop.exists());
        shell().write_file(stop.with_extension("lines"), done.join("\n"))?;
        return ended(&done);
    }
    let [first, second] = [FIRST, SECOND].map(|half| half.iter().filter(wanted));
    if options.only.is_empty() {
        side_by_side(options, first)?;
        let others: Vec<_> = FIRST.iter().chain(SECOND).filter(|step| step.0 == All).map(|step| step.1).collect();
        if !options.all {
            println!("`cargo xtask test --all` also has: {}", others.join(", "));
        }
        return Ok(());
    }
    let mut chosen = first.chain(second).peekable();
    if chosen.peek().is_none() {
        let names: Vec<_> = FIRST.iter().chain(SECOND).map(|step| step.1).collect();
        bail!("no step has {:?} in its name; there are: {}", options.only, names.join(", "));
    }
    ended(&steps(chosen, || false))
}

/// The first half of the steps here and the second in another process of this program: many a step keeps one
/// processor busy only. If one half fails, the other ends after the step that it is in.
fn side_by_side<'a>(options: &Options, first: impl Iterator<Item = &'a Step>) -> Outcome {
    crate::needs::test(options.complete)?;
    let folder = emptied(target().join("checks"))?;
    let (log, stop) = (folder.join("second.log"), folder.join("stop"));
    let printed = std::fs::File::create(&log).with_context(|| log.display().to_string())?;
    let mut second = Command::new(std::env::current_exe()?);
    second.arg("test").args(options.all.then_some("--all")).arg("--second-until").arg(&stop).stdin(Stdio::null());
    let mut second = second.stdout(printed.try_clone()?).stderr(printed).spawn()?;
    println!("Half of the steps run beside these; what they print is in {} and follows at the end.", log.display());
    let mut done = steps(first, || matches!(second.try_wait(), Ok(Some(status)) if !status.success()));
    if let Some(message) = done.iter().find(|line| line.starts_with("failed ")) {
        println!("{message}; the other half ends after the step that it is in ...");
        shell().write_file(&stop, "")?;
    }
    second.wait()?;
    println!("{}", shell().read_file(&log)?);
    done.extend(shell().read_file(stop.with_extension("lines"))?.lines().map(String::from));
    ended(&done)
}

pub fn verify() -> Outcome {
    run(&Options { all: true, only: Vec::new(), complete: false, second_until: None })?;
    ended(&steps(VERIFY.iter(), || false))
}

#[derive(clap::Args)]
pub struct BenchOptions {
    /// Handed to the benchmark: --quick, --only NAME, --out DIR ... (`-- --help` lists them).
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "OPTIONS")]
    pub options: Vec<String>,
}

/// Prints the number of each kind of line alone on a line, then what was skipped and failed; the first
/// failure.
fn ended(done: &[String]) -> Outcome {
    let of = |kind: &str| -> Vec<&str> { done.iter().filter_map(|line| line.strip_prefix(kind)).collect() };
    let [passed, skipped, failed] = ["passed", "skipped ", "failed "].map(of);
    println!("\n  passed{}\n", passed.join("\n  passed"));
    println!("{} passed, {} failed, {} skipped", passed.len(), failed.len(), skipped.len());
    if !skipped.is_empty() {
        println!("skipped: {}", skipped.join(", "));
    }
    failed.first().map_or(Ok(()), |what| Err(anyhow!("{what}")))
}

/// Runs the steps in order, stops at the first that fails, or if the word is given. A line for each that
/// passed, with its time and that of processors, was skipped, in whole or in part, or failed.
fn steps<'a>(steps: impl Iterator<Item = &'a Step>, mut stopped: impl FnMut() -> bool) -> Vec<String> {
    let mut done = Vec::new();
    for Step(_, name, step) in steps {
        if stopped() || done.iter().any(|line: &String| line.starts_with("failed ")) {
            break;
        }
        let title = format!("\n== {name}");
        let last = last_time(&title).map_or(String::new(), |last| format!(", last time {last} s"));
        let (start, before) = (Instant::now(), processor_seconds());
        let result = said(&title, step);
        let (seconds, busy) = (start.elapsed().as_secs_f64(), processor_seconds() - before);
        done.extend(all_left_out().iter().map(|what| format!("skipped {what}")));
        done.push(match result {
            Ok(()) => format!("passed in {seconds:6.1} s (processors {busy:6.1} s{last})  {name}"),
            Err(message) => match message.to_string().strip_prefix(STEP_LEFT_OUT) {
                Some(why) => format!("skipped {name} ({why})"),
                None => format!("failed step \"{name}\": {message:#}"),
            },
        });
    }
    done
}

/// What the programs that this one has started and that have ended took of processors, s, as Linux keeps it
/// (proc(5)).
fn processor_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = text.rsplit(')').next().unwrap_or_default().split_whitespace();
    fields.skip(13).take(2).filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / 100.0
}

/// Compares the committed model descriptions, builds both FMUs and runs the FMPy tests.
fn fmus(targets: Targets) -> Outcome {
    fmu::run(&fmu::Options { check: true, ..Default::default() })?;
    fmu::run(&fmu::Options { targets, ..Default::default() })?;
    println!("figure 26: the versions of the GNU C library above");
    installed()?;
    py_tests(&python_with("tests/fmi/requirements.txt")?, "tests/fmi")
}

/// The questions of docs/accuracy.md.
fn error_time() -> Outcome {
    let python = installed()?;
    for name in ["smooth", "overshoot", "viscosity", "pointwise", "quarter", "grading", "number", "coupling"] {
        sh!("{python} -m evidence {name}").run()?;
    }
    // The full answer takes most of an hour.
    Ok(sh!("{python} -m evidence accuracy --quick").run()?)
}

/// What a question of the evidence writes for the documents is what is committed.
fn as_committed(name: &str, files: &[&str]) -> Outcome {
    let (python, docs) = (installed()?, target().join("evidence/docs"));
    sh!("{python} -m evidence {name} --docs {docs}").run()?;
    for file in files {
        let same = shell().read_file(docs.join(file))? == shell().read_file(format!("docs/{file}"))?;
        ensure!(same, "docs/{file} is not what this gives: python -m evidence {name} --docs docs");
    }
    Ok(())
}

/// Every question of the evidence and the benchmark in their `--smoke` form, written to target/smoke.
fn studies() -> Outcome {
    let (python, out) = (installed()?, target().join("smoke"));
    py_tests(&python, "evidence/tests.py")?;
    sh!("{python} -m evidence --smoke --out {out}/evidence --docs {out}/evidence/docs").run()?;
    let bench = out.join("bench");
    benchmark(&["--smoke".into(), "--out".into(), bench.to_string_lossy().into_owned()])?;
    Ok(sh!("{python} -m evidence bench {bench} --out {bench} --docs {bench}/docs").run()?)
}

pub fn benchmark(options: &[String]) -> Outcome {
    Ok(sh!("cargo run --quiet --release --package fabric-bench -- {options...}").run()?)
}

#[cfg(test)]
mod counted {
    use super::{Always, Step, ended, steps};
    use crate::tools::{bail, found, needs};

    #[test]
    fn what_is_left_out_has_not_passed() {
        let all: [Step; 4] = [
            Step(Always, "whole", || needs(&["no-tool"])),
            Step(Always, "part", || if found(&["no-other"], "a part") { bail!("a tool") } else { Ok(()) }),
            Step(Always, "bad", || bail!("broken")),
            Step(Always, "never", || Ok(())),
        ];
        let mut done = steps(all.iter(), || false);
        assert!(ended(&done).is_err());
        assert!(done.remove(2).starts_with("passed "));
        assert_eq!(done, ["skipped whole (no no-tool)", "skipped a part (no no-other)", "failed step \"bad\": broken"]);
    }
}
