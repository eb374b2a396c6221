//! Running other programs from the project's top folder.

pub use anyhow::{Context, anyhow, bail, ensure};
pub use {crate::sh, xshell};

use std::collections::BTreeSet;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Output, Stdio};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;
use xshell::{Cmd, Shell};

/// What every command returns: nothing, or a message for the user.
pub type Outcome<T = ()> = anyhow::Result<T>;

pub fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new(".")).to_path_buf()
}

/// The folder cargo builds into, and the commands write into.
pub fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| top().join("target"), PathBuf::from)
}

/// A command in the top folder, with values in braces: `sh!("git clone {from} {to}").run()`.
/// `cargo` is the one that runs this program.
#[macro_export]
macro_rules! sh {
    ($words:literal) => {
        $crate::tools::xshell::cmd!($crate::tools::Top, $words)
    };
}

pub struct Top;

impl Top {
    pub fn cmd(&self, program: impl AsRef<Path>) -> Cmd<'static> {
        let cargo = std::env::var_os("CARGO").filter(|_| program.as_ref() == Path::new("cargo"));
        shell().cmd(cargo.map_or(program.as_ref().into(), PathBuf::from)).quiet()
    }
}

/// Files by their paths from the top folder.
pub fn shell() -> &'static Shell {
    thread_local!(static SHELL: &'static Shell = {
        let shell = Box::leak(Box::new(Shell::new().expect("a folder to work in")));
        shell.change_dir(top());
        shell
    });
    SHELL.with(|shell| *shell)
}

/// Does what may take its time, and says so: once, with the time that it took when it last had to be done.
pub fn said<T>(what: &str, action: impl FnOnce() -> Outcome<T>) -> Outcome<T> {
    static SAID: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    if SAID.lock().is_ok_and(|mut said| said.insert(what.into())) {
        println!("{what} ...{}", last_time(what).map_or(String::new(), |last| format!(" (last time {last} s)")));
    }
    let start = Instant::now();
    let done = action()?;
    let seconds = start.elapsed().as_secs();
    if seconds > 0 {
        shell().write_file(time_file(what), seconds.to_string())?;
    }
    Ok(done)
}

/// Time that an action of `said` took when it last had to be done, s.
pub fn last_time(what: &str) -> Option<String> {
    shell().read_file(time_file(what)).ok()
}

fn time_file(what: &str) -> PathBuf {
    target().join("times").join(what.replace(|c: char| !c.is_alphanumeric(), "-"))
}

/// Runs the program xtask-tables, compiled.
pub fn tables(words: &[&str]) -> Outcome {
    let build = || Ok(sh!("cargo build --quiet --package xtask-tables").run()?);
    said("Compiling what reads the tables in code", build)?;
    let program = target().join("debug/xtask-tables");
    Ok(sh!("{program} {words...}").run()?)
}

/// Says what went wrong, if something did.
pub fn ended(result: Outcome) -> ExitCode {
    result.map_or_else(
        |message| {
            eprintln!("error: {message:#}");
            ExitCode::FAILURE
        },
        |()| ExitCode::SUCCESS,
    )
}

/// The names in a folder, sorted.
pub fn listed(folder: &Path) -> Outcome<Vec<String>> {
    let name = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(shell().read_dir(folder)?.iter().map(name).collect())
}

/// A command of cargo's that is a program of its own; installed from crates.io if it is not here.
pub fn cargo_tool(name: &str) -> Outcome<Cmd<'static>> {
    let (root, own) = (target(), target().join("bin").join(name));
    if first_found(&[name]).is_some() {
        return Ok(sh!("{name}"));
    }
    if !own.exists() {
        let install = || Ok(sh!("cargo install --quiet --locked {name} --root {root}").run()?);
        said(&format!("Installing {name}"), install)?;
    }
    Ok(sh!("{own}"))
}

/// Runs a program to its end; what it says is the error if it fails.
pub fn finish(command: Cmd) -> Outcome<Output> {
    let command = command.ignore_status();
    let output = command.output()?;
    let said = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "`{command}` failed ({}):\n{said}", output.status);
    Ok(output)
}

/// What a program prints that may be missing or fail.
pub fn asked(command: Cmd) -> Option<String> {
    command.ignore_stderr().read().ok()
}

/// The files of Rust below these folders: path and text.
pub fn sources(folders: &[&str]) -> Outcome<Vec<(String, String)>> {
    let listed = sh!("git ls-files --cached --others --exclude-standard -- {folders...}").read()?;
    let wanted = listed.lines().filter(|path| path.ends_with(".rs"));
    wanted.map(|path| Ok((path.to_string(), shell().read_file(path)?))).collect()
}

/// Folder with nothing in it.
pub fn emptied(folder: PathBuf) -> Outcome<PathBuf> {
    shell().remove_path(&folder)?;
    Ok(shell().create_dir(folder)?)
}

/// Runs the tests in a folder by pytest, on two processors; those that it skips are left out.
pub fn py_tests(python: &Path, folder: &str) -> Outcome {
    // What tests that pass have printed is shown, and why some were skipped.
    let tests = sh!("{python} -m pytest -q -n 2 -rsP -p no:cacheprovider {folder}");
    let mut child = Command::from(tests).stdout(Stdio::piped()).spawn()?;
    for line in child.stdout.take().into_iter().flat_map(|said| BufReader::new(said).lines()).map_while(Result::ok) {
        println!("{line}");
        let skipped = line.starts_with("SKIPPED ") || line.starts_with("SUBSKIPPED");
        let named = line.split_once("] tests/").and_then(|(_, place)| place.split_once(": "));
        if let (true, Some((place, why))) = (skipped, named) {
            left_out(place, why);
        }
    }
    ensure!(child.wait()?.success(), "pytest {folder} failed");
    Ok(())
}

/// The first program of a list that is here.
pub fn first_found<'p>(programs: &[&'p str]) -> Option<&'p str> {
    programs.iter().copied().find(|program| asked(sh!("{program} --version")).is_some())
}

static LEFT_OUT: Mutex<Vec<String>> = Mutex::new(Vec::new());
/// Begins the message of a step that is left out.
pub const STEP_LEFT_OUT: &str = "left out: ";

/// Notes a part of a check that is left out on this machine.
pub fn left_out(what: &str, why: &str) {
    println!("  left out: {what} ({why})");
    LEFT_OUT.lock().unwrap_or_else(PoisonError::into_inner).push(format!("{what} ({why})"));
}

/// What was left out since this was asked last.
pub fn all_left_out() -> Vec<String> {
    std::mem::take(&mut LEFT_OUT.lock().unwrap_or_else(PoisonError::into_inner))
}

/// Leaves out the whole step.
pub fn step_left_out(why: &str) -> Outcome {
    Err(anyhow!("{STEP_LEFT_OUT}{why}"))
}

/// Leaves out the whole step if a program is not here.
pub fn needs(programs: &[&str]) -> Outcome {
    let missing = programs.iter().find(|program| first_found(&[program]).is_none());
    missing.map_or(Ok(()), |program| step_left_out(&format!("no {program}")))
}

/// Whether programs are here; if not, the part of a check that needs them is left out.
pub fn found(programs: &[&str], what: &str) -> bool {
    let missing = programs.iter().find(|program| first_found(&[program]).is_none());
    missing.inspect(|program| left_out(what, &format!("no {program}"))).is_none()
}

/// The Python of the project's virtual environment, which is made and filled from `requirements.txt` if need
/// be.
pub fn python() -> Outcome<PathBuf> {
    python_with("requirements.txt")
}

/// Python of the checks with the packages of another list too.
pub fn python_with(list: &str) -> Outcome<PathBuf> {
    let venv = shell().create_dir(target())?.join("venv");
    // Steps that run side by side wait for one another.
    let _lock = locked(&target().join("venv.lock"))?;
    let python = venv.join("bin").join("python");
    if !python.exists() {
        said("Setting up a Python environment", || Ok(sh!("python3 -m venv {venv}").run()?))
            .context("Python 3.11 or newer with the venv module is needed")?;
    }
    for list in ["requirements.txt", list] {
        let wanted = shell().read_file(list)?;
        let stamp = venv.join(format!("{}.installed", list.replace('/', "-")));
        if shell().read_file(&stamp).is_ok_and(|installed| installed == wanted) {
            continue;
        }
        said(&format!("Installing Python packages ({list})"), || pip(&python, &["-r", list]))?;
        shell().write_file(&stamp, wanted)?;
    }
    Ok(python)
}

/// Waits for the file's other holder; it is let go of with what this returns.
pub fn locked(path: &Path) -> Outcome<std::fs::File> {
    let file = std::fs::File::create(path).and_then(|file| file.lock().map(|()| file));
    file.with_context(|| path.display().to_string())
}

/// Installs into the environment of a Python.
pub fn pip(python: &Path, what: &[&str]) -> Outcome {
    Ok(sh!("{python} -m pip install --quiet --disable-pip-version-check --no-compile {what...}").run()?)
}

/// Configures and builds a CMake project against the installed library; what the compiler says.
pub fn cmake(source: &Path, build: &Path, prefix: &Path) -> Outcome<String> {
    finish(sh!("cmake -S {source} -B {build} -DCMAKE_PREFIX_PATH={prefix}"))?;
    Ok(sh!("cmake --build {build} --parallel 2").read()?)
}

/// Major and minor number in a text like "rustc 1.96.0 (...)".
pub fn version(text: &str) -> Option<(u32, u32)> {
    let number = text.split_whitespace().find(|word| word.starts_with(|c: char| c.is_ascii_digit()))?;
    let mut parts = number.split('.').map(|part| part.parse().ok());
    Some((parts.next()??, parts.next()??))
}

/// The crates of a release, as options of cargo.
pub const PUBLISHED: [&str; 6] = ["-p", "fabric-kernel", "-p", "fabric-capsule", "-p", "fabric-scene"];

#[cfg(test)]
mod tests {
    use super::version;

    #[test]
    fn versions_are_read_and_ordered() {
        assert_eq!(version("rustc 1.96.0 (6b00bc388 2026-06-23) (built from a source tarball)"), Some((1, 96)));
        assert_eq!(version("rustc 1.63.0"), Some((1, 63)));
        assert_eq!(version("2.14"), Some((2, 14)));
        assert!(version("2.2.5") < version("2.14"));
        assert_eq!(version("PRIVATE"), None);
    }
}
