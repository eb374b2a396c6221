//! Other programs that the benchmark builds, installs and runs.

use crate::{Result, say};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Top folder of the checkout.
pub fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap_or(Path::new(".")).to_path_buf()
}

/// Where the benchmark builds and installs: a folder of the target folder.
pub fn folder(name: &str) -> Result<PathBuf> {
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| top().join("target"), PathBuf::from);
    let folder = target.join(name);
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    Ok(folder)
}

/// Runs a program and returns what it wrote to standard output and standard error; an error if it cannot or
/// fails.
pub fn output(command: &mut Command) -> Result<(String, String)> {
    let shown = command.get_program().to_string_lossy().into_owned();
    let output = command.output().map_err(|error| format!("cannot start {shown}: {error}"))?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (out, err) = (text(&output.stdout), text(&output.stderr));
    if output.status.success() {
        return Ok((out, err));
    }
    let last = err.lines().chain(out.lines()).map(str::trim).rfind(|line| !line.is_empty()).unwrap_or("").to_string();
    Err(format!("{shown} failed ({}): {last}", output.status).into())
}

/// The Python of the peers' virtual environment, made and filled from evidence/bench/peers/requirements.txt
/// if need be.
pub fn python() -> Result<PathBuf> {
    let venv = folder("peers")?.join("venv");
    let python = venv.join("bin").join("python");
    let list = top().join("evidence/bench/peers/requirements.txt");
    let wanted = std::fs::read_to_string(&list).map_err(|error| format!("{}: {error}", list.display()))?;
    let stamp = venv.join("requirements.installed");
    if std::fs::read_to_string(&stamp).is_ok_and(|installed| installed == wanted) {
        return Ok(python);
    }
    say::aside(format_args!("installing the peers into {} ...", venv.display()));
    output(Command::new("python3").args(["-m", "venv"]).arg(&venv))?;
    let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r"];
    output(Command::new(&python).args(pip).arg(&list))?;
    std::fs::write(&stamp, wanted)?;
    Ok(python)
}
