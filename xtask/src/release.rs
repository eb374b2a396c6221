//! `cargo xtask release`: everything that a release holds, in one folder; the same from a clone of the commit
//! elsewhere, byte by byte; and what a stranger can try of it with nothing else of the project.

use crate::platforms::Targets;
use crate::tools::{
    self, Outcome, cargo_program, cargo_tool, emptied, listed, output, python, python_with, read, run as command,
    same_bytes, target, top, write,
};
use crate::{demo, fmu, install, site, web, wheel};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

#[derive(clap::Args)]
pub struct Options {
    /// Build it again from a clone of the commit in another folder, and compare every byte.
    #[arg(long)]
    pub reproduce: bool,
    /// Try what is in the folder with nothing else of the project, by the smoke.py that it holds.
    #[arg(long)]
    pub smoke: bool,
}

/// Files and what they are.
type Made = Result<Vec<(PathBuf, String)>, String>;

/// What is made, and how.
type Part = (&'static str, fn() -> Made);

const PARTS: &[Part] = &[
    ("crate", package),
    ("Python package", wheels),
    ("FMUs", fmus),
    ("C and C++ library", library),
    ("page", page),
    ("documentation", documentation),
    ("capsule of the demo", capsule),
    ("bills of materials", bills),
    ("source and texts", texts),
];

pub fn run(options: &Options) -> Outcome {
    let changed = output("git", &["status", "--porcelain"])?;
    if !changed.is_empty() {
        return Err(format!("a release is built from a commit; commit or stash what has changed:\n{changed}"));
    }
    let commit = || output("git", &["log", "-1", "--format=%H of %cs"]);
    let (before, folder) = (commit()?, emptied(target().join("dist"))?);
    let mut rows = Vec::new();
    for (name, make) in PARTS {
        println!("\n== {name}");
        let start = Instant::now();
        for (path, about) in make()? {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let copied = std::fs::copy(&path, folder.join(&name));
            let bytes = copied.map_err(|error| format!("{}: {error}", path.display()))?;
            rows.push(format!("| {name} | {bytes} | {about} |\n"));
        }
        println!("  {:.1} s", start.elapsed().as_secs_f64());
    }
    if commit()? != before {
        return Err("another commit was checked out meanwhile: build the release again".into());
    }
    let text = read(top().join("xtask/release/README.md"))?;
    let words = [("@VERSION@", env!("CARGO_PKG_VERSION")), ("@COMMIT@", before.trim()), ("@FILES@", &rows.concat())];
    let text = words.iter().fold(text, |text, (word, value)| text.replace(word, value));
    write(folder.join("README.md"), &text)?;
    let names = listed(&folder)?;
    let sums = Command::new("sha256sum").args(&names).current_dir(&folder).output();
    write(folder.join("SHA256SUMS"), sums.map_err(|error| format!("sha256sum: {error}"))?.stdout)?;
    println!("\n{text}\n{}", folder.display());
    if options.reproduce {
        reproduced(&folder)?;
    }
    if options.smoke {
        command("python3", &[&folder.join("smoke.py").to_string_lossy()])?;
    }
    Ok(())
}

/// Builds the commit again in a clone, from nothing.
fn reproduced(folder: &Path) -> Outcome {
    let clone = emptied(target().join("elsewhere"))?.join("a-clone-of-the-commit");
    command("git", &["clone", "--quiet", &top().to_string_lossy(), &clone.to_string_lossy()])?;
    let mut again = Command::new(cargo_program());
    // The clone takes only the tools of this one, which come from crates.io.
    let path = format!("{}:{}", target().join("bin").display(), std::env::var("PATH").unwrap_or_default());
    again.args(["xtask", "release"]).env_remove("CARGO_TARGET_DIR").env("PATH", path).current_dir(&clone);
    tools::wait(&mut again)?;
    let other = clone.join("target/dist");
    let names = listed(folder)?;
    if names != listed(&other)? {
        return Err(format!("{} and {} hold different files", folder.display(), other.display()));
    }
    let differ = |name: &&String| same_bytes(&folder.join(name), &other.join(name)).is_err();
    let differing: Vec<_> = names.iter().filter(differ).collect();
    if !differing.is_empty() {
        return Err(format!("built again in {}, these differ: {differing:?}", other.display()));
    }
    let [one, two] = [folder, &other].map(|at| at.join("SHA256SUMS").to_string_lossy().into_owned());
    let sums = output("sha256sum", &[&one, &two])?;
    println!("{} files are the same in both folders:\n{sums}", names.len());
    Ok(())
}

fn one(path: PathBuf, about: &str) -> Made {
    Ok(vec![(path, about.into())])
}

fn package() -> Made {
    tools::cargo(&["package", "--quiet", "--package", "fabric-kernel"])?;
    let name = format!("package/fabric-kernel-{}.crate", env!("CARGO_PKG_VERSION"));
    one(target().join(name), "Rust: the crate of the kernel, as crates.io takes it")
}

fn wheels() -> Made {
    wheel::run()?;
    let folder = target().join("wheels");
    let about =
        |name: &str| if name.ends_with(".whl") { "Python: a wheel" } else { "Python: the source of the wheels" };
    Ok(listed(&folder)?.iter().map(|name| (folder.join(name), about(name).into())).collect())
}

fn fmus() -> Made {
    fmu::run(&fmu::Options { targets: Targets::All, ..Default::default() })?;
    let about = |version: &str| -> Result<(PathBuf, String), String> {
        let path = target().join(format!("fmu/FabricShield-fmi{version}.fmu"));
        let names = output("python3", &["-m", "zipfile", "--list", &path.to_string_lossy()])?;
        let platforms = names.lines().filter_map(|name| Some(name.strip_prefix("binaries/")?.split_once('/')?.0));
        let platforms = platforms.collect::<Vec<_>>().join(", ");
        Ok((path, format!("FMU for FMI {version}.0: {platforms}")))
    };
    ["2", "3"].into_iter().map(about).collect()
}

fn library() -> Made {
    one(install::archive()?, "C and C++: both libraries, headers, CMake package, pkg-config file, licences")
}

fn page() -> Made {
    one(web::build()?.join("index.html"), "the kernel in a web page, with three.js (MIT): open it in a browser")
}

fn documentation() -> Made {
    one(site::run()?, "the documentation as a site: unpack it and open index.html")
}

/// What the host of the demo in short form does to the FMU, from the FMU's log.
fn capsule() -> Made {
    let (folder, text) = (target().join("dist-demo"), |path: PathBuf| path.to_string_lossy().into_owned());
    let (program, fmu) =
        (text(top().join(demo::PROGRAMS).join("rotorburst.py")), text(target().join("fmu/FabricShield-fmi2.fmu")));
    let options = ["--case", "small", "--fmu", &fmu, "--out", &text(folder.clone()), "--capsule"];
    let printed = output(python()?, &[&[&*program], &options[..]].concat())?;
    let file = folder.join("demo.capsule");
    let digits: String = printed.lines().filter_map(|line| Some(line.split_once("capsule: ")?.1.trim())).collect();
    let bytes = |pair: &[u8]| str::from_utf8(pair).ok().and_then(|pair| u8::from_str_radix(pair, 16).ok());
    let bytes: Option<Vec<u8>> = digits.as_bytes().chunks(2).map(bytes).collect();
    write(&file, bytes.ok_or("the log of the FMU has no hexadecimal capsule")?)?;
    one(file, "capsule of the short demo: what its host did to the FMU, to be replayed")
}

/// What is in each thing that is shipped, with licences (CycloneDX), by the tools for it.
fn bills() -> Made {
    let folder = emptied(target().join("bills"))?;
    let (source, environment, wheels) = (folder.join("source"), folder.join("wheel"), target().join("wheels"));
    let mut made = Vec::new();
    let mut save = |name: &str, from: &Path, about: &str| -> Outcome {
        // The tools name folders of this machine.
        let text = [&source, &wheels].iter().fold(read(from)?, |text, at| text.replace(&*at.to_string_lossy(), ""));
        let path = folder.join(format!("{name}.cdx.json"));
        made.push((path.clone(), format!("bill of materials (CycloneDX): {about}")));
        write(path, text)
    };
    // It writes a file beside each Cargo.toml: into a copy.
    command("git", &["clone", "--quiet", &top().to_string_lossy(), &source.to_string_lossy()])?;
    let cargo = ["cyclonedx", "--quiet", "--format", "json", "--spec-version", "1.5", "--override-filename", "bill"];
    let time = output("git", &["log", "-1", "--format=%ct"])?;
    tools::wait(cargo_tool("cargo-cyclonedx")?.args(cargo).env("SOURCE_DATE_EPOCH", time.trim()).current_dir(&source))?;
    for (name, package, about) in [
        ("crate", "kernel", "the crates in the kernel's"),
        ("c", "capi/library", "those in the libraries for C and C++, and in the page beside three.js"),
        ("fmu", "fmu/library", "those in the FMUs' libraries"),
        ("component", "fmu/wasm", "those in the FMU's component"),
        ("wheel", "python", "those in the wheels"),
    ] {
        save(name, &source.join(package).join("bill.json"), about)?;
    }
    let python = python_with("xtask/release/requirements.txt")?;
    let [inside, file] =
        [environment.join("bin/python"), folder.join("python.json")].map(|at| at.to_string_lossy().into_owned());
    let names = listed(&wheels)?;
    let own = |name: &&String| name.ends_with(&format!("_{}.whl", std::env::consts::ARCH));
    let wheel = names.iter().find(own).map(|name| format!("{}[all]", wheels.join(name).display()));
    let wheel = wheel.ok_or("no wheel of this machine")?;
    command("python3", &["-m", "venv", "--without-pip", &environment.to_string_lossy()])?;
    let pip =
        ["-m", "pip", "--quiet", "--disable-pip-version-check", "--python", &inside, "install", "--no-compile", &wheel];
    command(&python, &[&pip[..], &["-c", "requirements.txt", "-c", "evidence/requirements.txt"]].concat())?;
    let list = ["-m", "cyclonedx_py", "environment", &inside, "--output-reproducible", "-o", &file];
    command(&python, &list)?;
    save("python", Path::new(&file), "the Python packages that a wheel needs")?;
    Ok(made)
}

fn texts() -> Made {
    let name = format!("fabric-{}", env!("CARGO_PKG_VERSION"));
    let (source, prefix) = (target().join(format!("{name}-source.tar.gz")), format!("--prefix={name}/"));
    command("git", &["archive", "--format=tar.gz", &prefix, "--output", &source.to_string_lossy(), "HEAD"])?;
    let source = (source, "the whole project at this commit: begin with README.md and CHANGELOG.md in it".to_string());
    let smoke = (top().join("xtask/release/smoke.py"), "tries everything here, and uses nothing else".to_string());
    let licence = |name: &str| (top().join(name), "licence of the project, of two at your choice".to_string());
    Ok(vec![source, licence("LICENSE-APACHE"), licence("LICENSE-MIT"), smoke])
}
