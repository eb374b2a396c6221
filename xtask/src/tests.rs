//! `cargo xtask test`, `verify` and `bench`: the checks, in the order in which they fail fastest.

use crate::fmu;
use crate::platforms::Targets;
use crate::tools::{
    Outcome, all_left_out, cargo, emptied, left_out, own, python, python_with, read, run as command, said, target, top,
    unit_tests, wait, write,
};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::Instant;

#[derive(clap::Args)]
pub struct Options {
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

type Step = (&'static str, fn() -> Outcome);

/// What every change must pass, in two halves that take the same time side by side: the first compiles for development and release, and
/// for the targets of the digests, the second what is shipped.
const FIRST: &[Step] = &[
    ("format", || with_cargo("format", "fmt", &["fmt", "--all", "--check"])),
    ("clippy", || {
        let options = ["clippy", "--quiet", "--workspace", "--all-targets", "--features", EVERY_FEATURE];
        with_cargo("clippy", "clippy", &[&options[..], &["--", "-D", "warnings"]].concat())
    }),
    ("unit, physics, golden and robustness tests", || {
        cargo(&["test", "--quiet", "--workspace", "--features", EVERY_FEATURE])
    }),
    ("every set of features", crate::features::every_feature_set),
    ("documentation", documentation),
    ("package of the kernel", package),
    ("C header", || own("xtask-tables", &["header", "--check"])),
    (crate::web::STEP, crate::web::check),
    (crate::digests::STEP, crate::digests::short),
    ("studies in short form", studies),
    ("tutorial", tutorial),
];

/// The other half.
const SECOND: &[Step] = &[
    ("gates on the libraries", || own("xtask-binaries", &["gates"])),
    (crate::chosts::STEP, crate::chosts::run),
    ("binary interface", crate::abi::run),
    (crate::examples::STEP, crate::examples::run),
    ("FMUs", fmus),
    ("rotorburst in three forms", || crate::rotorburst::run(&crate::rotorburst::Options { short: true })),
    ("Python package", crate::wheel::test),
    ("README", crate::readme::run),
    ("demo in short form", || crate::demo::run(&crate::demo::Options { quick: true })),
];

/// What the kernel does not have by default. Where a step builds it with others, it is one more build.
const EVERY_FEATURE: &str = "fabric-kernel/micro,fabric-kernel/internals";

/// A step that is a command of cargo's, which may not be installed.
fn with_cargo(step: &str, name: &str, arguments: &[&str]) -> Outcome {
    if crate::needs::cargo_has(name) {
        return cargo(arguments);
    }
    left_out(step, &format!("no cargo {name}: rustup component add rustfmt clippy"));
    Ok(())
}

/// The page of the tutorial has what its programs print, and the notebook is that page.
fn tutorial() -> Outcome {
    let python = crate::wheel::installed()?;
    python_with("examples/notebooks/requirements.txt")?;
    command(python, &["examples/notebooks/make.py"])
}

/// The long checks, by hand before a release.
const VERIFY: &[Step] = &[
    ("release, built in two folders and tried", || {
        crate::release::run(&crate::release::Options { reproduce: true, smoke: true })
    }),
    ("digests on every target", || crate::digests::run(&crate::digests::Options::default())),
    ("sanitizers", crate::sanitize::run),
    ("tests that take minutes: searches, random hits", || {
        let tests = ["--test", "physics", "--test", "stability", "--", "--ignored"];
        cargo(&[&["test", "--quiet", "--package", "fabric-tests"], &tests[..]].concat())
    }),
    ("error against run time", error_time),
    ("map of stability, and its table", || {
        as_committed("stability", &["tables/stability.md", "images/stability_map.svg"])
    }),
    ("validation, and its table", || as_committed("validation", &["tables/validation.md"])),
    ("FMU reference results", || {
        command(python_with("tests/fmi/requirements.txt")?, &["tests/fmi/reference.py", "--check"])
    }),
    ("licences, sources and bans of the dependencies", crate::examples::deny),
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
    if let Some(stop) = &options.second_until {
        let done = steps(SECOND.iter(), || stop.exists());
        write(stop.with_extension("summary"), done.text())?;
        return done.ended();
    }
    if options.only.is_empty() {
        return side_by_side(options.complete);
    }
    let wanted = |name: &str| options.only.iter().any(|text| name.contains(text.as_str()));
    let mut chosen = FIRST.iter().chain(SECOND).filter(|(name, _)| wanted(name)).peekable();
    if chosen.peek().is_none() {
        let names: Vec<_> = FIRST.iter().chain(SECOND).map(|(name, _)| *name).collect();
        return Err(format!("no step has {:?} in its name; there are: {}", options.only, names.join(", ")));
    }
    let done = steps(chosen, || false);
    done.print();
    done.ended()
}

/// The first half of the steps here and the second in another process of this program: many a step keeps one processor busy only. Where
/// one half fails, the other ends after the step that it is in.
fn side_by_side(complete: bool) -> Outcome {
    crate::needs::test(complete)?;
    let folder = emptied(target().join("checks"))?;
    let (log, stop) = (folder.join("second.log"), folder.join("stop"));
    let failed = |error: std::io::Error| format!("{}: {error}", log.display());
    let printed = std::fs::File::create(&log).map_err(failed)?;
    let mut second = Command::new(std::env::current_exe().map_err(failed)?)
        .args(["test", "--second-until"])
        .arg(&stop)
        .stdin(Stdio::null())
        .stdout(printed.try_clone().map_err(failed)?)
        .stderr(printed)
        .spawn()
        .map_err(failed)?;
    println!("Half of the steps run beside these; what they print is in {} and follows at the end.", log.display());
    let mut done = steps(FIRST.iter(), || matches!(second.try_wait(), Ok(Some(status)) if !status.success()));
    if let Err(message) = done.ended() {
        println!("error: {message}; the other half ends after the step that it is in ...");
        std::fs::write(&stop, "").map_err(failed)?;
    }
    second.wait().map_err(failed)?;
    println!("{}", read(&log)?);
    done.add(&read(stop.with_extension("summary"))?);
    done.print();
    done.ended()
}

pub fn verify() -> Outcome {
    side_by_side(false)?;
    let done = steps(VERIFY.iter(), || false);
    done.print();
    done.ended()
}

#[derive(clap::Args)]
pub struct BenchOptions {
    /// Handed to the benchmark: --quick, --only NAME, --out DIR ... (`-- --help` lists them).
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "OPTIONS")]
    options: Vec<String>,
}

pub fn bench(options: &BenchOptions) -> Outcome {
    let options: Vec<&str> = options.options.iter().map(String::as_str).collect();
    runner(&[&["bench"], &options[..]].concat())
}

/// What became of steps: a line for each that passed, was left out in whole or in part, and failed.
#[derive(Default)]
struct Done([Vec<String>; 3]);

impl Done {
    /// The lines, each behind the number of its kind, as [`Done::add`] reads them.
    fn text(&self) -> String {
        let kind = |(kind, lines): (usize, &Vec<String>)| {
            lines.iter().map(|line| format!("{kind}{line}\n")).collect::<String>()
        };
        self.0.iter().enumerate().map(kind).collect()
    }

    fn add(&mut self, text: &str) {
        for line in text.lines() {
            if let (Some(kind), Some(rest)) = (line.get(..1).and_then(|kind| kind.parse::<usize>().ok()), line.get(1..))
            {
                self.0[kind.min(2)].push(rest.into());
            }
        }
    }

    /// The number of each, alone on a line, and then what was left out and failed.
    fn print(&self) {
        let [passed, left_out, failed] = &self.0;
        println!("\n{}\n", passed.join("\n"));
        println!("{} passed, {} failed, {} skipped", passed.len(), failed.len(), left_out.len());
        for (name, lines) in [("skipped", left_out), ("failed", failed)] {
            if !lines.is_empty() {
                println!("{name}: {}", lines.join(", "));
            }
        }
    }

    fn ended(&self) -> Outcome {
        self.0[2].first().map_or(Ok(()), |message| Err(message.clone()))
    }
}

/// Runs the steps in order, stops at the first that fails, or if the word is given; what each took: time, and that of processors.
fn steps<'a>(steps: impl Iterator<Item = &'a Step>, mut stopped: impl FnMut() -> bool) -> Done {
    let mut done = Done::default();
    for (name, step) in steps {
        if stopped() {
            break;
        }
        let (start, before) = (Instant::now(), processor_seconds());
        let result = said(&format!("\n== {name}"), step);
        let (seconds, busy) = (start.elapsed().as_secs_f64(), processor_seconds() - before);
        let left_out = all_left_out();
        let whole = left_out.iter().any(|what| what.starts_with(&format!("{name} (")));
        done.0[1].extend(left_out);
        match result {
            Err(message) => {
                done.0[2].push(format!("step \"{name}\": {message}"));
                break;
            }
            Ok(()) if whole => {}
            Ok(()) => done.0[0].push(format!("  passed in {seconds:6.1} s (processors {busy:6.1} s)  {name}")),
        }
    }
    done
}

/// What the programs that this one has started and that have ended took of processors, s, as Linux keeps it (proc(5)).
fn processor_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = text.rsplit(')').next().unwrap_or_default().split_whitespace();
    fields.skip(13).take(2).filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / 100.0
}

/// Compares the committed model descriptions, builds both FMUs for every platform there are tools for and those of a scene of its own,
/// and runs the FMPy tests.
fn fmus() -> Outcome {
    fmu::run(&fmu::Options { check: true, ..Default::default() })?;
    fmu::run(&fmu::Options { targets: Targets::All, figures: true, ..Default::default() })?;
    let file = "runner/scenes/tilted_disc_sector.toml";
    fmu::of_scene("TiltedDiscSector", &top().join(file), Targets::Host)?;
    // What tests/fmi/test_stability.py compares them with.
    let out = target().join("fmu/run").to_string_lossy().into_owned();
    runner(&["run", file, "--steps", "6000", "--sample", "6000", "--until", "none", "--out", &out])?;
    unit_tests(&python_with("tests/fmi/requirements.txt")?, "tests/fmi")
}

/// The questions of docs/accuracy.md.
fn error_time() -> Outcome {
    let python = crate::wheel::installed()?;
    for name in ["smooth", "overshoot", "viscosity", "pointwise", "quarter", "impact", "grading", "number", "coupling"]
    {
        command(&python, &["-m", "evidence", name])?;
    }
    Ok(())
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
    command(&python, &["-m", "unittest", "--quiet", "evidence.tests"])?;
    let out = target().join("smoke");
    let folder = |name: &str| out.join(name).to_string_lossy().into_owned();
    command(&python, &["-m", "evidence", "--smoke", "--out", &folder("evidence"), "--docs", &folder("evidence/docs")])?;
    runner(&["bench", "--smoke", "--out", &folder("bench")])?;
    report("bench", &folder("bench"))?;
    // The first steps of a stack, which has a picture of its own.
    let first = ["run", "runner/scenes/pack_of_62_plies.toml", "--steps", "64", "--until", "none"];
    runner(&[&first[..], &["--out", &folder("run of plies")]].concat())?;
    report("run", &folder("run of plies"))?;
    let sheets = ["--sample", "512", "--movie", "--vtk"];
    runner(&[&["run", "runner/scenes/four_sides_40J.toml", "--out", &folder("run")], &sheets[..]].concat())?;
    report("run", &folder("run"))
}

/// The pictures and tables of what a study has written, beside its numbers.
fn report(name: &str, folder: &str) -> Outcome {
    if name == "run" {
        return command(python()?, &["-m", "fabric_kernel.report", folder]);
    }
    let docs = format!("{folder}/docs");
    command(python()?, &["-m", "evidence", name, folder, "--out", folder, "--docs", &docs])
}

fn runner(arguments: &[&str]) -> Outcome {
    let program = ["run", "--quiet", "--release", "--package", "fabric", "--"];
    cargo(&[&program[..], arguments].concat())
}

#[cfg(test)]
mod counted {
    use super::{Done, Step, steps};
    use crate::tools::found;

    #[test]
    fn what_is_left_out_has_not_passed() {
        let all: [Step; 4] = [
            ("whole", || if found(&["tool"], "whole") { Err("a tool".into()) } else { Ok(()) }),
            ("part", || if found(&["other tool"], "a part") { Err("a tool".into()) } else { Ok(()) }),
            ("bad", || Err("broken".into())),
            ("never", || Ok(())),
        ];
        let mut done = Done::default();
        done.add(&steps(all.iter(), || false).text());
        let [passed, left_out, failed] = &done.0;
        assert!(passed.len() == 1 && passed[0].ends_with("part"), "{passed:?}");
        assert_eq!(*left_out, ["whole (no tool)", "a part (no other tool)"]);
        assert_eq!(*failed, ["step \"bad\": broken"]);
        assert!(done.ended().is_err());
    }
}
