//! `cargo xtask wheel`: the Python package as wheels, and its tests in an environment that has nothing else.

use crate::platforms::{Compiler, compiler_for, own};
use crate::targets::TARGETS;
use crate::tools::{
    Context as _, Outcome, emptied, finish, left_out, locked, pip, py_tests, python_with, said, sh, shell, target, top,
};
use std::path::{Path, PathBuf};

/// Builds the wheels into target/wheels, and packs their source.
pub fn run() -> Outcome {
    let folder = emptied(target().join("wheels"))?;
    for target in TARGETS.iter().filter(|target| target.wheel) {
        let host = target.triple.starts_with(std::env::consts::ARCH);
        match if host { Ok(own()) } else { compiler_for(target.triple) } {
            Ok(compiler) => build(&folder, Some((target.triple, &compiler)))?,
            Err(reason) => left_out(&format!("wheel for {}", target.triple), &reason.to_string()),
        }
    }
    let maturin = python_with("python/requirements.txt")?.with_file_name("maturin");
    finish(sh!("{maturin} sdist --manifest-path python/Cargo.toml --out {folder}"))?;
    for path in shell().read_dir(&folder)? {
        println!("  {} ({} bytes)", path.display(), path.metadata()?.len());
    }
    Ok(())
}

/// One wheel: for this machine, or, to be released, for every Linux of a target with glibc 2.17 or newer, of
/// which zig has the libraries.
fn build(folder: &Path, released: Option<(&str, &Compiler)>) -> Outcome {
    let python = python_with("python/requirements.txt")?;
    let (program, mut into) = (python.with_file_name("maturin"), target());
    // In the source that is packed the lock names crates that are not in it.
    let mut maturin = sh!("{program} build --quiet --locked --manifest-path python/Cargo.toml --out {folder}");
    if let Some((triple, compiler)) = released {
        let zig = python_with("python/zig.txt")?;
        into = into.join("cross");
        maturin = compiler.lent_to(maturin).args(["--zig", "--compatibility", "manylinux2014", "--target", triple]);
        // zig is a module of this Python.
        let folders = std::env::var_os("PATH").unwrap_or_default();
        let folders = zig.parent().map(Path::to_path_buf).into_iter().chain(std::env::split_paths(&folders));
        maturin = maturin.env("PATH", std::env::join_paths(folders)?);
    } else {
        maturin = maturin.arg("--interpreter").arg(&python);
    }
    maturin = maturin.arg("--target-dir").arg(into).env("CARGO_ENCODED_RUSTFLAGS", flags());
    let platform = released.map_or("this platform", |(triple, _)| triple);
    said(&format!("Compiling the Python package for {platform}"), || finish(maturin).map(|_| ()))
}

/// The folders of this machine whose names a panic's place would show, and what stands for them.
fn folders() -> [(PathBuf, &'static str); 2] {
    let home = || PathBuf::from(std::env::var_os("HOME").unwrap_or_default()).join(".cargo");
    [(top(), "fabric"), (std::env::var_os("CARGO_HOME").map_or_else(home, PathBuf::from), "cargo")]
}

/// Flags of the compiler, the user's own included, between separators as cargo wants them.
fn flags() -> String {
    let own = std::env::var("RUSTFLAGS").unwrap_or_default();
    let renamed = folders().map(|(folder, name)| format!("--remap-path-prefix={}={name}", folder.display()));
    own.split_whitespace().map(str::to_string).chain(renamed).collect::<Vec<_>>().join("\x1f")
}

/// Refuses a wheel of which a file names a folder of this machine.
fn names_no_folder(wheel: &Path) -> Outcome {
    let program = "import sys, zipfile; wheel = zipfile.ZipFile(sys.argv[1])\n\
                   sys.exit([name for name in wheel.namelist() for at in sys.argv[2:] if at.encode() in wheel.read(name)] or 0)";
    let folders = folders().map(|(folder, _)| folder);
    let found = finish(sh!("python3 -c {program} {wheel} {folders...}"));
    found.map(|_| ()).context("a file in the wheel names a folder of this machine")
}

/// Ends with 0 if the wheel of this path is what is installed (PEP 610).
const IS_INSTALLED: &str = "import sys, hashlib, importlib.metadata as m; d = m.distribution('fabric_kernel').read_text('direct_url.json'); \
    sys.exit(hashlib.sha256(open(sys.argv[1], 'rb').read()).hexdigest() not in (d or ''))";

/// The Python of the project's environment, with the package of this clone as it is now.
pub fn installed() -> Outcome<PathBuf> {
    // Steps that run side by side take turns, and what is in use is not installed again.
    let _lock = locked(&target().join("evidence-wheel.lock"))?;
    let python = python_with("evidence/requirements.txt")?;
    let folder = emptied(target().join("evidence-wheel"))?;
    build(&folder, None)?;
    renewed(&python, &only_file(&folder)?)?;
    Ok(python)
}

/// Installs a wheel unless it is what is installed.
fn renewed(python: &Path, wheel: &Path) -> Outcome {
    if finish(sh!("{python} -c {IS_INSTALLED} {wheel}")).is_ok() {
        return Ok(());
    }
    pip(python, &["--force-reinstall", "--no-deps", &wheel.to_string_lossy()])
}

/// Runs the tests, those with a Dask cluster included, in an environment that has the wheel, what it asks for
/// and nothing else.
pub fn test() -> Outcome {
    let folder = target().join("wheel-test");
    let venv = folder.join("venv");
    let (python, stamp) = (venv.join("bin/python"), venv.join("asked-for"));
    let asked = shell().read_file("python/pyproject.toml")?;
    let kept = shell().read_file(&stamp).is_ok_and(|before| before == asked);
    let built = emptied(folder.join("wheel"))?;
    build(&built, None)?;
    let wheel = only_file(&built)?;
    names_no_folder(&wheel)?;
    if !kept {
        emptied(venv.clone())?;
        sh!("python3 -m venv {venv}").run()?;
        pip(&python, &[&format!("{}[test]", wheel.display())])?;
        shell().write_file(stamp, asked)?;
    }
    renewed(&python, &wheel)?;
    py_tests(&python, "tests/python")
}

fn only_file(folder: &Path) -> Outcome<PathBuf> {
    shell().read_dir(folder)?.pop().with_context(|| format!("no wheel in {}", folder.display()))
}
