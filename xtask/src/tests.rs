//! `cargo xtask test`, `verify` and `bench`: the checks, in the order in which they fail fastest.

use crate::fmu;
use crate::platforms::Targets;
use crate::tools::{
    Outcome, STEP_LEFT_OUT, all_left_out, cargo, emptied, last_time, py_tests, python_with, read, run as command, said,
    step_left_out, tables, target, top, wait, write,
};
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
        command("python3", &["tests/structure/pages.py"])
    }),
    Step(Always, "format", style),
    Step(Always, "clippy", || {
        let options = ["clippy", "--quiet", "--workspace", "--all-targets", "--features", EVERY_FEATURE];
        with_cargo("clippy", &[&options[..], &["--", "-D", "warnings"]].concat())
    }),
    Step(Always, "unit, physics, golden and robustness tests", || {
        cargo(&["test", "--quiet", "--workspace", "--features", EVERY_FEATURE])
    }),
    Step(Always, "C header", || wait(&mut tables(&["header", "--check"])?)),
    Step(All, "every set of features", || wait(&mut tables(&["features"])?)),
    Step(All, "documentation", documentation),
    Step(All, "documentation as a site", crate::site::check),
    Step(All, "package of the kernel", package),
    Step(All, "web page in a browser", crate::web::check),
    Step(All, "digests on other targets", crate::digests::short),
    Step(All, "studies in short form", studies),
];

/// The other half.
const SECOND: &[Step] = &[
    Step(All, "gates on the libraries", || wait(&mut tables(&["gates"])?)),
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
    command(&ruff, &["format", "--quiet", "--diff"])?;
    command(&ruff, &["check", "--quiet"])?;
    command(&python, &["-m", "mypy", "--no-error-summary"])?;
    with_cargo("fmt", &["fmt", "--all", "--check"])
}

/// A command of cargo's that may not be installed.
fn with_cargo(name: &str, arguments: &[&str]) -> Outcome {
    if !crate::needs::cargo_has(name) {
        return step_left_out(&format!("no cargo {name}: rustup component add rustfmt clippy"));
    }
    cargo(arguments)
}

/// Programs and commands of all pages print what the pages say, with or without those that take minutes.
fn pages(long: bool) -> Outcome {
    crate::chosts::installed()?;
    crate::fmu::packed(Targets::Host, false)?;
    let python = crate::wheel::installed()?;
    python_with("tests/fmi/requirements.txt")?;
    if !long {
        return py_tests(&python, "tests/pages");
    }
    command(python, &["-m", "pytest", "-q", "-n", "2", "-rP", "-p", "no:cacheprovider", "--long", "tests/pages"])
}

/// The long checks, by hand before a release.
const VERIFY: &[Step] = &[
    Step(Always, "release, built in two folders and tried", || {
        crate::release::run(&crate::release::Options { reproduce: true, smoke: true })
    }),
    Step(Always, "digests on every target", || crate::digests::run(&crate::digests::Options::default())),
    Step(Always, "sanitizers", crate::sanitize::run),
    Step(Always, "tests that take minutes: searches, random hits", || {
        let tests = ["--test", "physics", "--test", "stability", "--", "--ignored"];
        cargo(&[&["test", "--quiet", "--package", "fabric-tests"], &tests[..]].concat())
    }),
    Step(Always, "error against run time", error_time),
    Step(Always, "map of stability, and its table", || {
        as_committed("stability", &["tables/stability_1.csv", "images/stability_map.svg"])
    }),
    Step(Always, "pages, with the commands that take minutes", || pages(true)),
    Step(Always, "validation, and its table", || as_committed("validation", &["tables/validation.md"])),
    Step(Always, "FMU reference results", || {
        command(python_with("tests/fmi/requirements.txt")?, &["tests/fmi/reference.py", "--check"])
    }),
    Step(Always, "licences, sources and bans of the dependencies", crate::examples::deny),
];

/// rustdoc without warnings; every public item of kernel, C interface and FMU is documented.
fn documentation() -> Outcome {
    let packages = ["fabric-kernel", "fabric-host", "fabric-capi", "fabric-fmu"];
    let packages: Vec<_> = packages.iter().flat_map(|name| ["--package", name]).collect();
    let features = ["--features", "fabric-kernel/micro"];
    let mut command = Command::new(crate::tools::cargo_program());
    command
        .args([&["doc", "--quiet", "--no-deps"], &packages[..], &features[..]].concat())
        // What is private to a host is named without a link.
        .env("RUSTDOCFLAGS", "-D warnings -A rustdoc::private-intra-doc-links")
        .current_dir(top());
    wait(&mut command)
}

/// The kernel as crates.io would get it builds by itself, and its documentation as docs.rs would build it.
fn package() -> Outcome {
    cargo(&["package", "--quiet", "--package", "fabric-kernel", "--allow-dirty"])?;
    let packed = target().join(format!("package/fabric-kernel-{}/Cargo.toml", env!("CARGO_PKG_VERSION")));
    if let Some(missing) = ["LICENSE-MIT", "LICENSE-APACHE"].iter().find(|name| !packed.with_file_name(name).is_file())
    {
        return Err(format!("the package of the kernel has no {missing}"));
    }
    let folder = target().join("package/docs");
    let (packed, folder) = (packed.to_string_lossy(), folder.to_string_lossy());
    let features = ["--no-deps", "--features", "micro"];
    cargo(&[&["doc", "--quiet", "--manifest-path", &packed, "--target-dir", &folder], &features[..]].concat())
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
        write(stop.with_extension("lines"), done.join("\n"))?;
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
        return Err(format!("no step has {:?} in its name; there are: {}", options.only, names.join(", ")));
    }
    ended(&steps(chosen, || false))
}

/// The first half of the steps here and the second in another process of this program: many a step keeps one
/// processor busy only. If one half fails, the other ends after the step that it is in.
fn side_by_side<'a>(options: &Options, first: impl Iterator<Item = &'a Step>) -> Outcome {
    crate::needs::test(options.complete)?;
    let folder = emptied(target().join("checks"))?;
    let (log, stop) = (folder.join("second.log"), folder.join("stop"));
    let failed = |error: std::io::Error| format!("{}: {error}", log.display());
    let printed = std::fs::File::create(&log).map_err(failed)?;
    let mut second = Command::new(std::env::current_exe().map_err(failed)?);
    second.arg("test").args(options.all.then_some("--all")).arg("--second-until").arg(&stop).stdin(Stdio::null());
    second.stdout(printed.try_clone().map_err(failed)?).stderr(printed);
    let mut second = second.spawn().map_err(failed)?;
    println!("Half of the steps run beside these; what they print is in {} and follows at the end.", log.display());
    let mut done = steps(first, || matches!(second.try_wait(), Ok(Some(status)) if !status.success()));
    if let Some(message) = done.iter().find(|line| line.starts_with("failed ")) {
        println!("{message}; the other half ends after the step that it is in ...");
        std::fs::write(&stop, "").map_err(failed)?;
    }
    second.wait().map_err(failed)?;
    println!("{}", read(&log)?);
    done.extend(read(stop.with_extension("lines"))?.lines().map(String::from));
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
    options: Vec<String>,
}

pub fn bench(options: &BenchOptions) -> Outcome {
    let options: Vec<&str> = options.options.iter().map(String::as_str).collect();
    benchmark(&options)
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
    failed.first().map_or(Ok(()), |what| Err((*what).into()))
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
            Err(message) => match message.strip_prefix(STEP_LEFT_OUT) {
                Some(why) => format!("skipped {name} ({why})"),
                None => format!("failed step \"{name}\": {message}"),
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
    crate::wheel::installed()?;
    py_tests(&python_with("tests/fmi/requirements.txt")?, "tests/fmi")
}

/// The questions of docs/accuracy.md.
fn error_time() -> Outcome {
    let python = crate::wheel::installed()?;
    for name in ["smooth", "overshoot", "viscosity", "pointwise", "quarter", "grading", "number", "coupling"] {
        command(&python, &["-m", "evidence", name])?;
    }
    // The full answer takes most of an hour.
    command(&python, &["-m", "evidence", "accuracy", "--quick"])
}

/// What a question of the evidence writes for the documents is what is committed.
fn as_committed(name: &str, files: &[&str]) -> Outcome {
    let docs = target().join("evidence/docs");
    command(crate::wheel::installed()?, &["-m", "evidence", name, "--docs", &docs.to_string_lossy()])?;
    for file in files {
        if read(docs.join(file))? != read(top().join("docs").join(file))? {
            return Err(format!("docs/{file} is not what this gives: python -m evidence {name} --docs docs"));
        }
    }
    Ok(())
}

/// Every question of the evidence and the benchmark in their `--smoke` form, written to target/smoke.
fn studies() -> Outcome {
    let python = crate::wheel::installed()?;
    py_tests(&python, "evidence/tests.py")?;
    let out = target().join("smoke");
    let folder = |name: &str| out.join(name).to_string_lossy().into_owned();
    command(&python, &["-m", "evidence", "--smoke", "--out", &folder("evidence"), "--docs", &folder("evidence/docs")])?;
    let bench = folder("bench");
    benchmark(&["--smoke", "--out", &bench])?;
    command(&python, &["-m", "evidence", "bench", &bench, "--out", &bench, "--docs", &format!("{bench}/docs")])
}

fn benchmark(options: &[&str]) -> Outcome {
    cargo(&[&["run", "--quiet", "--release", "--package", "fabric-bench", "--"], options].concat())
}

#[cfg(test)]
mod counted {
    use super::{Always, Step, ended, steps};
    use crate::tools::{found, needs};

    #[test]
    fn what_is_left_out_has_not_passed() {
        let all: [Step; 4] = [
            Step(Always, "whole", || needs(&["no-tool"])),
            Step(Always, "part", || if found(&["no-other"], "a part") { Err("a tool".into()) } else { Ok(()) }),
            Step(Always, "bad", || Err("broken".into())),
            Step(Always, "never", || Ok(())),
        ];
        let mut done = steps(all.iter(), || false);
        assert!(ended(&done).is_err());
        assert!(done.remove(2).starts_with("passed "));
        assert_eq!(done, ["skipped whole (no no-tool)", "skipped a part (no no-other)", "failed step \"bad\": broken"]);
    }
}
