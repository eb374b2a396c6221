//! `cargo xtask mutants`: what the tests notice when a line of the kernel is wrong.
//!
//! Method: `cargo mutants --list` names the mutants (an operator, a result, a condition changed). They are built all at once:
//! in a copy of the sources every function begins with a switch that leads to its mutated bodies, and an environment variable
//! says which mutant is on. So there is one build for all, and a mutant costs only the tests that run it. A first run of each
//! test alone finds which functions it reaches; a mutant is tried by the tests that reach its function, the fast ones and those
//! that have caught its neighbours first, until one fails, aborts or runs out of time.
//! A constant is made a function, so that it can be switched too.
//! Limits: mutants whose body does not compile are found by the compiler's messages and left out, as cargo-mutants does.
//! The tests of tests/golden only pin bits, so they are counted apart.
#![allow(clippy::disallowed_methods)] // Shares and seconds of a report, no simulation's bits.

use crate::records::{self, Figure};
use crate::tools::{Outcome, target, top};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt::Write as _;
use std::hash::{Hash, Hasher};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// The files whose mutants count, without `kernel/src/` and `.rs`.
const FILES: &[&str] = &["yarn", "energy", "projectile", "contact", "shape", "layout", "snapshot"];
/// The suites of tests in the order in which they are tried.
const SUITES: &[&str] = &["unit", "robustness", "physics", DIGESTS];
/// The tests that only pin bits.
const DIGESTS: &str = "golden";
/// Shares of caught mutants that are asked for, without and with digests.
const FLOORS: [f64; 2] = [0.90, 0.95];

/// Options of `cargo xtask mutants`.
#[derive(clap::Args)]
pub struct Options {
    /// Only mutants of this file of the kernel, such as `yarn` (repeatable).
    #[arg(long, value_name = "NAME")]
    file: Vec<String>,
    /// Only the mutants k, k + n, k + 2n ... of the list: a sample.
    #[arg(long, value_name = "k/n")]
    shard: Option<String>,
    /// Try the mutants that survive on the tests that only pin bits, too.
    #[arg(long)]
    with_digests: bool,
    /// Take what the last run has caught as caught, and try the others again.
    #[arg(long)]
    iterate: bool,
    /// Try a mutant on the fastest tests only, as many as take so many seconds together: what survives is then an upper bound.
    #[arg(long, value_name = "N", default_value_t = f64::INFINITY)]
    seconds: f64,
    /// Only these tests: unit, robustness, physics or golden (repeatable). Only what they need is built.
    #[arg(long, value_name = "NAME")]
    suite: Vec<String>,
    /// Only tests whose name contains this text.
    #[arg(long, value_name = "TEXT", default_value = "")]
    test: String,
    /// Only mutants whose name contains this text.
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
}

/// A place in a file: line and column from 1, as cargo-mutants counts.
#[derive(Clone, Copy, Deserialize)]
struct Place {
    line: usize,
    column: usize,
}

#[derive(Clone, Copy, Deserialize)]
struct Span {
    start: Place,
    end: Place,
}

#[derive(Clone, Deserialize)]
struct Function {
    span: Span,
}

/// One mutant as cargo-mutants lists it.
#[derive(Clone, Deserialize)]
struct Mutant {
    name: String,
    file: String,
    function: Option<Function>,
    span: Span,
    replacement: String,
}

/// What became of a mutant.
#[derive(Clone, PartialEq)]
enum Fate {
    /// Does not compile.
    Unviable,
    /// The test that failed.
    Caught(String),
    /// Only tests that pin bits noticed it: the test that failed.
    CaughtByDigest(String),
    /// All tests passed.
    Survived,
}

/// A reason why a mutant survives, from docs/reliability/survivors.toml.
#[derive(Deserialize)]
struct Reason {
    file: String,
    /// The mutant's name after file and place.
    mutation: String,
    /// The line of code, trimmed.
    code: String,
    /// Column, where a line has the same operator twice.
    column: Option<usize>,
    /// equivalent, boundary or missed.
    kind: String,
    reason: String,
}

#[derive(Deserialize)]
struct Reasons {
    #[serde(default)]
    survivor: Vec<Reason>,
}

/// A test, the program it is in, and how long it takes unchanged.
#[derive(Deserialize, Serialize)]
struct Test {
    program: PathBuf,
    /// unit, physics, robustness or golden.
    suite: String,
    name: String,
    seconds: f64,
    /// Numbers of the functions it reaches.
    reaches: BTreeSet<usize>,
}

/// Lists, builds, runs and reports.
pub fn run(options: &Options) -> Outcome {
    if let Some(unknown) = options.suite.iter().find(|name| !SUITES.contains(&name.as_str())) {
        return Err(format!("there is no suite {unknown}; there are {}", SUITES.join(", ")));
    }
    if let Some(unknown) = options.file.iter().find(|name| !top().join(format!("kernel/src/{name}.rs")).exists()) {
        return Err(format!("there is no kernel/src/{unknown}.rs; without --file it is {}", FILES.join(", ")));
    }
    let files: Vec<&str> =
        if options.file.is_empty() { FILES.to_vec() } else { options.file.iter().map(String::as_str).collect() };
    let all = list(&files)?;
    let wanted: Vec<usize> = sample(all.len(), options.shard.as_deref())?
        .into_iter()
        .filter(|&k| options.only.as_ref().is_none_or(|text| all[k].name.contains(text.as_str())))
        .collect();
    println!("{} mutants in {} files, {} of them tried", all.len(), files.len(), wanted.len());

    let chosen = |suite: &str| {
        let all = options.suite.is_empty() && (suite != DIGESTS || options.with_digests);
        all || options.suite.iter().any(|name| name == suite)
    };
    let suites: Vec<&str> = SUITES.iter().copied().filter(|suite| chosen(suite)).collect();
    let (programs, unviable, functions) = build(&all, &wanted, &suites)?;
    let record = target().join("mutants/caught.txt");
    let known = std::fs::read_to_string(&record).unwrap_or_default();
    let known: BTreeMap<&str, &str> =
        known.lines().filter(|_| options.iterate).filter_map(|line| line.split_once('\t')).collect();
    let mut fates: BTreeMap<usize, Fate> = BTreeMap::new();
    for &k in &wanted {
        let caught = known.get(all[k].name.as_str()).map_or(Fate::Survived, |test| Fate::Caught(test.to_string()));
        fates.insert(k, if unviable.contains(&k) { Fate::Unviable } else { caught });
    }
    // Suite by suite, each on what has survived the ones before.
    for suite in suites {
        let mut tests = tests(&programs, suite, options)?;
        let (start, count) = (Instant::now(), tests.len());
        let time: f64 = tests.iter().map(|test| test.seconds).sum();
        for (&k, fate) in fates.iter_mut().filter(|(_, fate)| **fate == Fate::Survived) {
            if let Some(test) = judge(&mut tests, k, functions[&k], options.seconds)? {
                *fate = if suite == DIGESTS { Fate::CaughtByDigest(test) } else { Fate::Caught(test) };
            }
        }
        let left = fates.values().filter(|fate| **fate == Fate::Survived).count();
        println!("  {suite}: {left} left after {count} tests of {time:.0} s, {:.0} s", start.elapsed().as_secs_f64());
        let mut caught: BTreeMap<&str, &str> = known.clone();
        for (&k, fate) in &fates {
            match fate {
                Fate::Caught(test) => _ = caught.insert(&all[k].name, test),
                _ => _ = caught.remove(all[k].name.as_str()),
            }
        }
        write(&record, &caught.iter().map(|(name, test)| format!("{name}\t{test}\n")).collect::<String>())?;
    }
    report(&files, &all, &fates, options)
}

/// The mutants of the files, in cargo-mutants' order.
fn list(files: &[&str]) -> Result<Vec<Mutant>, String> {
    let mut arguments: Vec<String> = ["mutants", "--list", "--json"].map(String::from).to_vec();
    for file in files {
        arguments.extend(["--file".into(), format!("kernel/src/{file}.rs")]);
    }
    let output = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
        .args(&arguments)
        .current_dir(top())
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| format!("cannot start cargo: {error}"))?;
    if !output.status.success() {
        return Err("`cargo mutants` does not run: install it with `cargo install cargo-mutants --locked`".into());
    }
    serde_json::from_slice(&output.stdout).map_err(|error| format!("list of cargo-mutants: {error}"))
}

/// Numbers of the mutants in a sample "k/n", or all.
fn sample(count: usize, shard: Option<&str>) -> Result<Vec<usize>, String> {
    let Some(text) = shard else { return Ok((0..count).collect()) };
    let numbers = text.split_once('/').and_then(|(k, n)| Some((k.parse::<usize>().ok()?, n.parse::<usize>().ok()?)));
    match numbers {
        Some((k, n)) if k < n => Ok((k..count).step_by(n).collect()),
        _ => Err(format!("--shard {text}: k/n with k < n expected")),
    }
}

/// Offset of a place in a text.
fn offset(text: &str, place: Place) -> usize {
    let line: usize = text.split_inclusive('\n').take(place.line - 1).map(str::len).sum();
    line + text[line..].chars().take(place.column - 1).map(char::len_utf8).sum::<usize>()
}

/// Offset of the brace that opens the body of the function that starts at `from`.
fn body_start(text: &str, from: usize) -> Option<usize> {
    let mut at = from;
    for line in text[from..].split_inclusive('\n') {
        if !line.trim_start().starts_with("//") && !line.trim_start().starts_with("#[") {
            // No signature of the kernel has a brace.
            if let Some(brace) = line.find('{') {
                return Some(at + brace);
            }
        }
        at += line.len();
    }
    None
}

/// Source text with switches for the mutants `included`; for each line of the new text the mutant it belongs to, if any.
fn with_switches(
    text: &str,
    mutants: &[(usize, &Mutant)],
    functions: &HashMap<usize, usize>,
) -> Result<(String, Vec<Option<usize>>), String> {
    // Functions by their start, innermost bodies only (the kernel has no function inside a function).
    let mut bodies: BTreeMap<(usize, usize), Vec<(usize, &Mutant)>> = BTreeMap::new();
    let mut constants = BTreeSet::new();
    for &(k, mutant) in mutants {
        let span = mutant.function.as_ref().map_or(mutant.span, |function| function.span);
        let (start, end) = (offset(text, span.start), offset(text, span.end));
        let body = if mutant.function.is_some() {
            body_start(text, start).filter(|&open| open < end).map(|open| (open, end))
        } else {
            constant(text, start).map(|(name, open, end)| {
                constants.insert(name);
                (open, end)
            })
        };
        let body = body.ok_or_else(|| format!("{}: neither in a function nor in a constant", mutant.name))?;
        bodies.entry(body).or_default().push((k, mutant));
    }
    let (mut new, mut owner, mut lines, mut copied) = (String::new(), Vec::new(), 0, 0);
    // Every piece that belongs to a mutant begins on a line of its own.
    let mut push = |new: &mut String, piece: &str, of: Option<usize>| {
        new.push_str(piece);
        lines += piece.matches('\n').count();
        owner.resize(lines, of);
    };
    for ((open, end), mutants) in bodies {
        let function = functions[&mutants[0].0];
        if text[open..].starts_with('{') {
            push(&mut new, &text[copied..=open], None);
            push(&mut new, &format!("\nmatch crate::mutant_switch::active({function}) {{\n"), None);
        } else {
            // "const NAME: TYPE = VALUE;", whose value is evaluated by the compiler as before.
            let definition = text[copied..open].rfind("const ").map_or(open, |at| copied + at);
            push(&mut new, &text[copied..definition], None);
            let (name, kind) = text[definition + 6..open - 3].split_once(": ").ok_or("no type")?;
            let head = format!(
                "#[allow(non_snake_case)] fn {name} -> {kind} {{\nmatch crate::mutant_switch::active({function}) {{\n"
            );
            push(&mut new, &head, None);
        }
        let constant = if text[open..].starts_with('{') { "" } else { "const " };
        for (k, mutant) in mutants {
            let (from, to) = (offset(text, mutant.span.start), offset(text, mutant.span.end));
            let body = format!("{}{}{}", &text[open..from], mutant.replacement, &text[to..end]);
            push(&mut new, &format!("{} => return {constant}{{{body}}},\n", k + 1), Some(k));
        }
        push(&mut new, "_ => {}\n}\n", None);
        copied = open + 1;
        if !constant.is_empty() {
            push(&mut new, &format!("const {{{}}} }}\n", &text[open..end]), None);
            copied = end + 1;
        }
    }
    push(&mut new, &text[copied..], None);
    for name in constants {
        new = new.replace(name, &format!("{name}()"));
    }
    Ok((new, owner))
}

/// Name of the constant "const NAME: TYPE = VALUE;" that has a value at `inside`, and where the value begins and ends.
fn constant(text: &str, inside: usize) -> Option<(&str, usize, usize)> {
    let start = text[..inside].rfind("const ")?;
    let name = text[start + 6..inside].split(':').next()?;
    let open = start + text[start..inside].find(" = ")? + 3;
    Some((name, open, inside + text[inside..].find(';')?))
}

/// The module that every switch asks.
fn switch_module(functions: usize) -> String {
    format!(
        r#"//! Which mutant is on.
extern crate std;
use std::io::Write;
use std::sync::atomic::{{AtomicBool, AtomicU32, Ordering::Relaxed}};
const UNREAD: u32 = u32::MAX;
const TRACED: u32 = u32::MAX - 1;
static ACTIVE: AtomicU32 = AtomicU32::new(UNREAD);
static REACHED: [AtomicBool; {functions}] = [const {{ AtomicBool::new(false) }}; {functions}];
#[inline(always)]
pub fn active(function: usize) -> u32 {{
    let active = ACTIVE.load(Relaxed);
    if active < TRACED {{ active }} else {{ first(function) }}
}}
#[cold]
#[inline(never)]
fn first(function: usize) -> u32 {{
    if let Ok(file) = std::env::var("MUTANT_TRACE") {{
        ACTIVE.store(TRACED, Relaxed);
        if !REACHED[function].swap(true, Relaxed) {{
            let mut file = std::fs::OpenOptions::new().create(true).append(true).open(file).unwrap();
            file.write_all(std::format!("{{function}}\n").as_bytes()).unwrap();
        }}
        return 0;
    }}
    let active = std::env::var("MUTANT").map_or(0, |text| text.parse().unwrap());
    ACTIVE.store(active, Relaxed);
    active
}}
"#
    )
}

fn write(path: &Path, text: &str) -> Outcome {
    let fail = |error: std::io::Error| format!("{}: {error}", path.display());
    std::fs::create_dir_all(path.parent().unwrap_or(path)).map_err(fail)?;
    // What has not changed keeps its time, so that nothing is built anew for it.
    if std::fs::read_to_string(path).is_ok_and(|old| old == text) {
        return Ok(());
    }
    std::fs::write(path, text).map_err(fail)
}

/// Copies the text files of a folder.
fn copy(from: &Path, to: &Path) -> Outcome {
    let fail = |error: std::io::Error| format!("{}: {error}", from.display());
    for entry in std::fs::read_dir(from).map_err(fail)? {
        let entry = entry.map_err(fail)?;
        let (path, to) = (entry.path(), to.join(entry.file_name()));
        if path.is_dir() {
            copy(&path, &to)?;
        } else if let Ok(text) = std::fs::read_to_string(&path) {
            write(&to, &text)?;
        }
    }
    Ok(())
}

/// Test programs by suite, the mutants that do not compile, and the number of each mutant's function.
type Built = (Vec<(String, PathBuf)>, BTreeSet<usize>, HashMap<usize, usize>);

/// Builds the tests with all mutants in them, leaving out those that do not compile.
fn build(all: &[Mutant], wanted: &[usize], suites: &[&str]) -> Result<Built, String> {
    let tree = target().join("mutants/tree");
    let mut numbers: BTreeMap<(String, usize, usize), usize> = BTreeMap::new();
    let mut functions = HashMap::new();
    for &k in wanted {
        let start = all[k].function.as_ref().map_or((0, 0), |f| (f.span.start.line, f.span.start.column));
        let next = numbers.len();
        functions.insert(k, *numbers.entry((all[k].file.clone(), start.0, start.1)).or_insert(next));
    }
    let read = |path: PathBuf| std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()));
    let mutated: BTreeSet<&str> = wanted.iter().map(|&k| all[k].file.as_str()).collect();
    // What did not compile last time is left out from the start, where the file is still the same.
    let kept_at = target().join("mutants/unviable.json");
    let kept: BTreeSet<(String, u64)> =
        std::fs::read(&kept_at).ok().and_then(|text| serde_json::from_slice(&text).ok()).unwrap_or_default();
    let mut hashes = HashMap::new();
    for &file in &mutated {
        let mut hash = std::hash::DefaultHasher::new();
        read(top().join(file))?.hash(&mut hash);
        hashes.insert(file, hash.finish());
    }
    let key = |k: usize| (all[k].name.clone(), hashes[all[k].file.as_str()]);
    let mut unviable: BTreeSet<usize> = wanted.iter().copied().filter(|&k| kept.contains(&key(k))).collect();
    // Not the whole workspace: only the kernel, the tests and the C interface that one of them calls, which shares a file with the FMU.
    let manifest = read(top().join("Cargo.toml"))?;
    let members = manifest.lines().find(|line| line.starts_with("members")).ok_or("Cargo.toml: no members")?;
    let manifest = manifest.replace(members, r#"members = ["kernel", "capi", "tests"]"#);
    write(&tree.join("Cargo.toml"), &manifest)?;
    write(&tree.join("README.md"), &read(top().join("README.md"))?)?;
    let lock = tree.join("Cargo.lock");
    if !lock.exists() {
        write(&lock, &read(top().join("Cargo.lock"))?)?;
    }
    copy(&top().join("tests"), &tree.join("tests"))?;
    for interface in ["capi", "fmu"] {
        copy(&top().join(interface), &tree.join(interface))?;
    }
    // A mutant that overflows for certain is no mistake of ours.
    let lints = "[lints.rust]\narithmetic_overflow = \"allow\"\nunconditional_panic = \"allow\"";
    let manifest = read(top().join("kernel/Cargo.toml"))?.replace("[lints]\nworkspace = true", lints);
    write(&tree.join("kernel/Cargo.toml"), &manifest)?;
    loop {
        let mut owners = HashMap::new();
        let sources = top().join("kernel/src");
        for entry in std::fs::read_dir(&sources).map_err(|error| format!("{}: {error}", sources.display()))? {
            let name = entry.map_err(|error| error.to_string())?.file_name();
            let file = format!("kernel/src/{}", name.to_string_lossy());
            let mut text = read(top().join(&file))?;
            if file == "kernel/src/lib.rs" {
                text.push_str("#[allow(missing_docs)]\nmod mutant_switch;\n");
            }
            if mutated.contains(file.as_str()) {
                let included: Vec<(usize, &Mutant)> = wanted
                    .iter()
                    .filter(|k| all[**k].file == file && !unviable.contains(*k))
                    .map(|&k| (k, &all[k]))
                    .collect();
                let (new, owner) = with_switches(&text, &included, &functions)?;
                (text, _) = (new, owners.insert(file.clone(), owner));
            }
            write(&tree.join(&file), &text)?;
        }
        write(&tree.join("kernel/src/mutant_switch.rs"), &switch_module(numbers.len()))?;
        // The compiler's cheap half first; constants are evaluated in the other.
        for command in ["check", "test"] {
            let before = unviable.len();
            let (messages, built) = cargo_messages(&tree, command, suites)?;
            messages.iter().for_each(|message| mark_unviable(message, &owners, &mut unviable));
            if unviable.len() > before {
                break;
            }
            if !built {
                return Err(format!("the mutants do not build; see `cargo {command}` in {}", tree.display()));
            }
            if command == "test" {
                let kept: BTreeSet<_> = unviable.iter().map(|&k| key(k)).collect();
                write(&kept_at, &serde_json::to_string(&kept).map_err(|error| error.to_string())?)?;
                return Ok((programs(&messages), unviable, functions));
            }
        }
        println!("  {} mutants do not compile", unviable.len());
    }
}

/// Test programs among cargo's messages: suite and path.
fn programs(messages: &[serde_json::Value]) -> Vec<(String, PathBuf)> {
    let mut programs = Vec::new();
    for message in messages {
        if let (Some(program), Some(name)) = (message["executable"].as_str(), message["target"]["name"].as_str())
            && message["profile"]["test"] == true
            && name != "fabric_tests"
        {
            let suite = if name == "fabric" { "unit" } else { name };
            programs.push((suite.to_string(), PathBuf::from(program)));
        }
    }
    programs
}

/// Runs `cargo check` or `cargo test --no-run` for some tests of the copy; its messages, and whether it succeeded.
fn cargo_messages(tree: &Path, command: &str, suites: &[&str]) -> Result<(Vec<serde_json::Value>, bool), String> {
    let mut arguments = vec![command, "--message-format", "json"];
    if command == "test" {
        arguments.push("--no-run");
    }
    // Always both packages, so that what they depend on is built with the same features.
    arguments.extend(["--package", "fabric-kernel", "--package", "fabric-tests"]);
    for &suite in suites {
        match suite {
            "unit" => arguments.push("--lib"),
            _ => arguments.extend(["--test", suite]),
        }
    }
    if command == "check" {
        arguments.push("--profile=test");
    }
    let output = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
        .args(arguments)
        .args(["--features", "fabric-kernel/micro,fabric-kernel/implicit"])
        .env("CARGO_TARGET_DIR", target())
        .current_dir(tree)
        .stderr(Stdio::null())
        .output()
        .map_err(|error| format!("cannot start cargo: {error}"))?;
    let lines = output.stdout.split(|&byte| byte == b'\n').filter(|line| !line.is_empty());
    let messages = lines.map(serde_json::from_slice).collect::<Result<_, _>>().map_err(|error| error.to_string())?;
    Ok((messages, output.status.success()))
}

/// Finds the mutant that an error of the compiler is about.
fn mark_unviable(
    message: &serde_json::Value,
    owners: &HashMap<String, Vec<Option<usize>>>,
    unviable: &mut BTreeSet<usize>,
) {
    if message["message"]["level"] != "error" {
        return;
    }
    for span in message["message"]["spans"].as_array().into_iter().flatten() {
        let owner = span["file_name"].as_str().and_then(|file| owners.get(file)).zip(span["line_start"].as_u64());
        if let Some(k) = owner.and_then(|(owner, line)| owner.get(line as usize - 1).copied().flatten())
            && span["is_primary"] == true
        {
            unviable.insert(k);
        }
    }
}

/// The tests of a suite, fastest first, each run once alone and unchanged. What has run before on the same program is kept.
fn tests(programs: &[(String, PathBuf)], suite: &str, options: &Options) -> Result<Vec<Test>, String> {
    let seconds = options.seconds;
    let (mut tests, mut failing) = (Vec::new(), Vec::new());
    let Some((_, program)) = programs.iter().find(|(name, _)| name == suite) else {
        return Err(format!("no program of the tests `{suite}` was built"));
    };
    let built = program.metadata().and_then(|data| data.modified()).map_err(|error| error.to_string())?;
    let kept_at = target().join(format!("mutants/{suite}.json"));
    let kept: Option<(std::time::SystemTime, Vec<Test>)> =
        std::fs::read(&kept_at).ok().and_then(|text| serde_json::from_slice(&text).ok());
    let mut kept = kept.filter(|(time, _)| *time == built).map_or(Vec::new(), |(_, tests)| tests);
    let output = Command::new(program)
        .args(["--list", "--format", "terse"])
        .output()
        .map_err(|error| format!("{}: {error}", program.display()))?;
    for name in String::from_utf8_lossy(&output.stdout).lines().filter_map(|line| line.strip_suffix(": test")) {
        if !name.contains(&options.test) {
            continue;
        }
        if let Some(at) = kept.iter().position(|test| test.name == name) {
            tests.push(kept.swap_remove(at));
            continue;
        }
        let (suite, name, reaches) = (suite.to_string(), name.to_string(), BTreeSet::new());
        let mut test = Test { program: program.clone(), suite, name, seconds: 0.0, reaches };
        let trace = target().join("mutants/trace.txt");
        let _ = std::fs::remove_file(&trace);
        let start = Instant::now();
        let passed = passes(&test, "MUTANT_TRACE", &trace.to_string_lossy(), seconds.min(600.0))?;
        test.seconds = start.elapsed().as_secs_f64();
        if !passed && test.seconds >= seconds {
            println!("  left out for its time: {} {}", test.suite, test.name);
        } else if !passed {
            failing.push(format!("{} {}", test.suite, test.name));
        } else {
            let reached = std::fs::read_to_string(&trace).unwrap_or_default();
            test.reaches = reached.lines().filter_map(|line| line.parse().ok()).collect();
            tests.push(test);
        }
    }
    tests.append(&mut kept);
    let text = serde_json::to_string(&(built, &tests)).map_err(|error| error.to_string())?;
    write(&kept_at, &text)?;
    tests.retain(|test| test.name.contains(&options.test));
    if !failing.is_empty() {
        return Err(format!("tests that fail without any mutant: {}", failing.join(", ")));
    }
    tests.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    Ok(tests)
}

/// Runs one test with a variable set; false if it fails, aborts or takes too long.
fn passes(test: &Test, variable: &str, value: &str, processor_seconds: f64) -> Result<bool, String> {
    // Limits of processor time and of memory, so that what else the machine does plays no part.
    let limits = format!("ulimit -t {}; ulimit -v 8000000; ulimit -c 0; exec \"$@\"", processor_seconds.ceil());
    let mut child = Command::new("sh")
        .args(["-c", &limits, "sh"])
        .arg(&test.program)
        .args(["--exact", &test.name, "--test-threads", "1"])
        .env(variable, value)
        .env("RUST_BACKTRACE", "0")
        .current_dir(target().join("mutants/tree/tests"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|error| format!("cannot start sh: {error}"))?;
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait().map_err(|error| error.to_string())? {
            return Ok(status.success());
        }
        // Threads that wait for one another take no processor time.
        if start.elapsed().as_secs_f64() > 300.0 + 10.0 * processor_seconds {
            child.kill().and_then(|()| child.wait()).map_err(|error| error.to_string())?;
            return Ok(false);
        }
        std::thread::sleep(Duration::from_millis(if start.elapsed().as_millis() < 100 { 1 } else { 20 }));
    }
}

/// Tries a mutant on the tests that reach its function and returns the one that fails, which is moved to the front.
fn judge(tests: &mut Vec<Test>, mutant: usize, function: usize, seconds: f64) -> Result<Option<String>, String> {
    let mut spent = 0.0;
    for at in 0..tests.len() {
        let test = &tests[at];
        if !test.reaches.contains(&function) || spent + test.seconds > seconds {
            continue;
        }
        spent += test.seconds;
        if !passes(test, "MUTANT", &(mutant + 1).to_string(), 3.0 + 5.0 * test.seconds)? {
            let caught = format!("{} {}", test.suite, test.name);
            if test.seconds < 1.0 {
                let test = tests.remove(at);
                tests.insert(0, test);
            }
            return Ok(Some(caught));
        }
    }
    Ok(None)
}

/// Half the width and the middle of Wilson's 95 % interval of a share.
fn interval(part: usize, whole: usize) -> (f64, f64) {
    let (n, z) = (whole.max(1) as f64, 1.96);
    let share = part as f64 / n;
    let middle = (share + z * z / (2.0 * n)) / (1.0 + z * z / n);
    let half = z / (1.0 + z * z / n) * (share * (1.0 - share) / n + z * z / (4.0 * n * n)).sqrt();
    (middle - half, middle + half)
}

/// What is counted of a file, or of all.
#[derive(Default)]
struct Count {
    viable: usize,
    unviable: usize,
    caught: usize,
    by_digest: usize,
}

impl Count {
    fn add(&mut self, fate: &Fate) {
        self.viable += usize::from(*fate != Fate::Unviable);
        self.unviable += usize::from(*fate == Fate::Unviable);
        self.caught += usize::from(matches!(fate, Fate::Caught(_)));
        self.by_digest += usize::from(matches!(fate, Fate::CaughtByDigest(_)));
    }

    /// Shares caught without and with digests.
    fn shares(&self) -> [f64; 2] {
        let whole = self.viable.max(1) as f64;
        [self.caught as f64 / whole, (self.caught + self.by_digest) as f64 / whole]
    }
}

/// Prints the table and, for a run over all files, writes docs/reliability/mutants.toml.
fn report(files: &[&str], all: &[Mutant], fates: &BTreeMap<usize, Fate>, options: &Options) -> Outcome {
    let reasons = read_reasons()?;
    let (mut table, mut total) = (BTreeMap::new(), Count::default());
    for (&k, fate) in fates {
        let name = all[k].file.trim_start_matches("kernel/src/").trim_end_matches(".rs");
        table.entry(name).or_insert_with(Count::default).add(fate);
        total.add(fate);
    }
    println!(
        "\n{:12} {:>8} {:>7} {:>7} {:>12} {:>9}",
        "file", "unviable", "viable", "caught", "digest only", "survived"
    );
    let line = |name: &str, count: &Count| {
        let survived = count.viable - count.caught - count.by_digest;
        let [without, with] = count.shares().map(|share| 100.0 * share);
        println!(
            "{name:12} {:8} {:7} {:7} {:12} {survived:9}   {without:.1} % without, {with:.1} % with digests",
            count.unviable, count.viable, count.caught, count.by_digest
        );
    };
    files.iter().filter_map(|name| Some((name, table.get(name)?))).for_each(|(name, count)| line(name, count));
    line("all", &total);

    // Survivors without digests: these are what the tests that know the answer do not notice.
    let mut survivors = String::new();
    let mut unnamed = Vec::new();
    for (&k, fate) in fates {
        if matches!(fate, Fate::Caught(_) | Fate::Unviable) {
            continue;
        }
        let mutant = &all[k];
        let source = std::fs::read_to_string(top().join(&mutant.file)).map_err(|error| error.to_string())?;
        let code = source.lines().nth(mutant.span.start.line - 1).unwrap_or_default().trim().to_string();
        let mutation = mutation(mutant);
        let reason = reasons.iter().find(|reason| {
            (mutant.file.as_str(), mutation, &code) == (reason.file.as_str(), reason.mutation.as_str(), &reason.code)
                && reason.column.is_none_or(|column| column == mutant.span.start.column)
        });
        let (kind, why) = reason.map_or(("missed", "not looked at"), |reason| (&reason.kind, &reason.reason));
        if reason.is_none() {
            unnamed.push(&mutant.name);
        }
        let digest = matches!(fate, Fate::CaughtByDigest(_));
        let _ = write!(
            survivors,
            "\n[[survivor]]\nfile = {:?}\nline = {}\nmutation = {mutation:?}\ncode = {code:?}\ncaught_by_digest = {digest}\n\
             kind = {kind:?}\nreason = {why:?}\n",
            mutant.file, mutant.span.start.line
        );
    }
    if !unnamed.is_empty() {
        println!("\nsurvivors without a line in docs/reliability/survivors.toml:");
        unnamed.iter().for_each(|name| println!("  {name}"));
    }
    if files != FILES || options.only.is_some() || options.iterate || !options.test.is_empty() {
        println!("\ndocs/reliability/mutants.toml is written by a whole run over all files only");
        return Ok(());
    }
    let mut chosen = options.shard.as_ref().map_or(String::new(), |shard| format!(" --shard {shard}"));
    options.suite.iter().for_each(|suite| chosen.push_str(&format!(" --suite {suite}")));
    if options.seconds.is_finite() {
        let _ = write!(chosen, " --seconds {}", options.seconds);
    }
    if options.with_digests {
        chosen.push_str(" --with-digests");
    }
    let by = if options.suite.is_empty() {
        String::new()
    } else {
        format!(", by {} tests alone", options.suite.join(" and "))
    };
    let mut records = Vec::new();
    for (k, what) in ["without digests", "with digests"].into_iter().enumerate() {
        let caught = [total.caught, total.caught + total.by_digest][k];
        let mut value = format!("{:.1} % ({caught} of {}){by}", 100.0 * total.shares()[k], total.viable);
        if k == 1 && !options.with_digests {
            value = format!("at least {value}");
        }
        if options.shard.is_some() {
            let (low, high) = interval(caught, total.viable);
            let _ = write!(
                value,
                ", a sample of {} mutants: 95 % interval {:.1} to {:.1} %",
                all.len(),
                100.0 * low,
                100.0 * high
            );
        }
        let row = Figure {
            number: "13",
            figure: &format!("viable mutants caught {what}"),
            value: &value,
            floor: &format!("{:.0} %", 100.0 * FLOORS[k]),
            reached: total.shares()[k] >= FLOORS[k],
            command: &format!("cargo xtask mutants{chosen}"),
        };
        records.push(row.now()?);
    }
    let mut text = String::from("\n");
    for (name, count) in &table {
        let _ = write!(
            text,
            "[[file]]\nname = \"kernel/src/{name}.rs\"\nunviable = {}\nviable = {}\ncaught = {}\ncaught_by_digest_only = {}\n\n",
            count.unviable, count.viable, count.caught, count.by_digest
        );
    }
    text.push_str(survivors.trim_start());
    records::write("mutants", "cargo xtask mutants", &records, &text)
}

/// A mutant's name without its place.
fn mutation(mutant: &Mutant) -> &str {
    mutant.name.split_once(": ").map_or(&mutant.name, |(_, mutation)| mutation)
}

/// Why mutants survive.
fn read_reasons() -> Result<Vec<Reason>, String> {
    let path = top().join("docs/reliability/survivors.toml");
    let text = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let reasons: Reasons = toml::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(reasons.survivor)
}
