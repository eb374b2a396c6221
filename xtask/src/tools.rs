//! Running other programs from the project's top folder.

use std::collections::BTreeSet;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Output, Stdio};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// What every command returns: nothing, or a message for the user.
pub type Outcome = Result<(), String>;

pub fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new(".")).to_path_buf()
}

/// The folder cargo builds into, and the commands write into.
pub fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| top().join("target"), PathBuf::from)
}

/// Runs a program in the top folder and waits; its output goes to the terminal. An exit code other than 0 is
/// an error.
pub fn run(program: impl AsRef<std::ffi::OsStr>, arguments: &[&str]) -> Outcome {
    wait(Command::new(program).args(arguments).current_dir(top()))
}

pub fn wait(command: &mut Command) -> Outcome {
    let status = command.status().map_err(|error| format!("cannot start {command:?}: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("{command:?} failed ({status})")) }
}

/// Runs cargo, the one that runs this program.
pub fn cargo(arguments: &[&str]) -> Outcome {
    run(cargo_program(), arguments)
}

/// Does what may take its time, and says so: once, with the time that it took when it last had to be done.
pub fn said<T>(what: &str, action: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    static SAID: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    if SAID.lock().is_ok_and(|mut said| said.insert(what.into())) {
        println!("{what} ...{}", last_time(what).map_or(String::new(), |last| format!(" (last time {last} s)")));
    }
    let start = Instant::now();
    let done = action()?;
    let seconds = start.elapsed().as_secs();
    if seconds > 0 {
        write(time_file(what), seconds.to_string())?;
    }
    Ok(done)
}

/// Time that an action of `said` took when it last had to be done, s.
pub fn last_time(what: &str) -> Option<String> {
    std::fs::read_to_string(time_file(what)).ok()
}

fn time_file(what: &str) -> PathBuf {
    target().join("times").join(what.replace(|c: char| !c.is_alphanumeric(), "-"))
}

/// The program xtask-tables, compiled.
pub fn tables(arguments: &[&str]) -> Result<Command, String> {
    said("Compiling what reads the tables in code", || cargo(&["build", "--quiet", "--package", "xtask-tables"]))?;
    let mut program = Command::new(target().join("debug/xtask-tables"));
    program.args(arguments).current_dir(top());
    Ok(program)
}

/// Says what went wrong, if something did.
pub fn ended(result: Outcome) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

/// The names in a folder, sorted.
pub fn listed(folder: &Path) -> Result<Vec<String>, String> {
    let entries = std::fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?.flatten();
    let mut names: Vec<_> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    Ok(names)
}

pub fn cargo_program() -> std::ffi::OsString {
    std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into())
}

/// A command of cargo's that is a program of its own, run in the top folder; installed from crates.io if it
/// is not here.
pub fn cargo_tool(name: &str) -> Result<Command, String> {
    let own = target().join("bin").join(name);
    let here = first_found(&[name]).is_some();
    if !here && !own.exists() {
        let root = target().to_string_lossy().into_owned();
        said(&format!("Installing {name}"), || cargo(&["install", "--quiet", "--locked", name, "--root", &root]))?;
    }
    let mut program = if here { Command::new(name) } else { Command::new(own) };
    program.current_dir(top());
    Ok(program)
}

/// Runs a program in the top folder and returns what it prints to standard output.
pub fn output(program: impl AsRef<std::ffi::OsStr>, arguments: &[&str]) -> Result<String, String> {
    let printed = finish(Command::new(program).args(arguments).current_dir(top()))?.stdout;
    Ok(String::from_utf8_lossy(&printed).into_owned())
}

/// Runs a program to its end; what it says is the error if it fails.
pub fn finish(command: &mut Command) -> Result<Output, String> {
    let output = command.stdin(Stdio::null()).output().map_err(|error| format!("cannot start {command:?}: {error}"))?;
    if output.status.success() {
        return Ok(output);
    }
    Err(format!("{command:?} failed ({}):\n{}", output.status, String::from_utf8_lossy(&output.stderr)))
}

/// Whether a program is there and ends well.
pub fn answers(command: &mut Command) -> bool {
    command.stdin(Stdio::null()).output().is_ok_and(|output| output.status.success())
}

pub fn read(path: impl AsRef<Path>) -> Result<String, String> {
    let path = path.as_ref();
    std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}

/// The files of Rust below these folders: path and text.
pub fn sources(folders: &[&str]) -> Result<Vec<(String, String)>, String> {
    let known = ["ls-files", "--cached", "--others", "--exclude-standard", "--"];
    let listed = output("git", &[&known[..], folders].concat())?;
    let wanted = listed.lines().filter(|path| path.ends_with(".rs"));
    wanted.map(|path| Ok((path.to_string(), read(top().join(path))?))).collect()
}

/// Writes a file, into a folder that is made if need be.
pub fn write(path: impl AsRef<Path>, text: impl AsRef<[u8]>) -> Outcome {
    let path = path.as_ref();
    make_folder(path.parent().unwrap_or(path).into())?;
    std::fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
}

/// A folder, made if need be.
pub fn make_folder(folder: PathBuf) -> Result<PathBuf, String> {
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    Ok(folder)
}

/// Folder with nothing in it.
pub fn emptied(folder: PathBuf) -> Result<PathBuf, String> {
    let _ = std::fs::remove_dir_all(&folder);
    make_folder(folder)
}

/// Runs the tests in a folder by pytest, on two processors; those that it skips are left out.
pub fn py_tests(python: &Path, folder: &str) -> Outcome {
    let mut tests = Command::new(python);
    // What tests that pass have printed is shown, and why some were skipped.
    tests.args(["-m", "pytest", "-q", "-n", "2", "-rsP", "-p", "no:cacheprovider", folder]).current_dir(top());
    let mut child = tests.stdout(Stdio::piped()).spawn().map_err(|error| format!("cannot start {tests:?}: {error}"))?;
    for line in child.stdout.take().into_iter().flat_map(|said| BufReader::new(said).lines()).map_while(Result::ok) {
        println!("{line}");
        let skipped = line.starts_with("SKIPPED ") || line.starts_with("SUBSKIPPED");
        let named = line.split_once("] tests/").and_then(|(_, place)| place.split_once(": "));
        if let (true, Some((place, why))) = (skipped, named) {
            left_out(place, why);
        }
    }
    let status = child.wait().map_err(|error| error.to_string())?;
    if status.success() { Ok(()) } else { Err(format!("{tests:?} failed ({status})")) }
}

/// The first program of a list that is here.
pub fn first_found<'p>(programs: &[&'p str]) -> Option<&'p str> {
    programs.iter().copied().find(|program| answers(Command::new(program).arg("--version")))
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
    Err(format!("{STEP_LEFT_OUT}{why}"))
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
pub fn python() -> Result<PathBuf, String> {
    python_with("requirements.txt")
}

/// Python of the checks with the packages of another list too.
pub fn python_with(list: &str) -> Result<PathBuf, String> {
    let venv = target().join("venv");
    // Steps that run side by side wait for one another.
    let lock =
        std::fs::File::create(make_folder(target())?.join("venv.lock")).and_then(|file| file.lock().map(|()| file));
    let _lock = lock.map_err(|error| format!("{}.lock: {error}", venv.display()))?;
    let python = venv.join("bin").join("python");
    if !python.exists() {
        said("Setting up a Python environment", || run("python3", &["-m", "venv", &venv.to_string_lossy()]))
            .map_err(|e| format!("{e}; Python 3.11 or newer with the venv module is needed"))?;
    }
    for list in ["requirements.txt", list] {
        let wanted = read(top().join(list))?;
        let stamp = venv.join(format!("{}.installed", list.replace('/', "-")));
        if std::fs::read_to_string(&stamp).is_ok_and(|installed| installed == wanted) {
            continue;
        }
        said(&format!("Installing Python packages ({list})"), || pip(&python, &["-r", list]))?;
        write(&stamp, wanted)?;
    }
    Ok(python)
}

/// Installs into the environment of a Python.
pub fn pip(python: &Path, what: &[&str]) -> Outcome {
    let install = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-compile"];
    run(python, &[&install[..], what].concat())
}

/// Writes files that are made, or compares them with what is there; `command` makes them.
pub fn made(files: &[(PathBuf, String)], check: bool, command: &str) -> Outcome {
    for (path, text) in files {
        if !check {
            write(path, text)?;
        } else if std::fs::read_to_string(path).unwrap_or_default() != *text {
            return Err(format!("{} is not what the sources give; run `{command}`", path.display()));
        }
    }
    Ok(())
}

/// Refuses two files that differ.
pub fn same_bytes(one: &Path, other: &Path) -> Outcome {
    let read = |path: &Path| std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()));
    if read(one)? == read(other)? { Ok(()) } else { Err(format!("{} and {} differ", one.display(), other.display())) }
}

/// Configures and builds a CMake project against the installed library; what the compiler says.
pub fn cmake(source: &Path, build: &Path, prefix: &Path) -> Result<String, String> {
    let (source, build) = (source.to_string_lossy(), build.to_string_lossy());
    output("cmake", &["-S", &source, "-B", &build, &format!("-DCMAKE_PREFIX_PATH={}", prefix.display())])?;
    output("cmake", &["--build", &build, "--parallel", "2"])
}

/// Major and minor number in a text like "rustc 1.96.0 (...)".
pub fn version(text: &str) -> Option<(u32, u32)> {
    let number = text.split_whitespace().find(|word| word.starts_with(|c: char| c.is_ascii_digit()))?;
    let mut parts = number.split('.').map(|part| part.parse().ok());
    Some((parts.next()??, parts.next()??))
}

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
