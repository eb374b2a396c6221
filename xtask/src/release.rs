//! `cargo xtask release`: everything that a release holds, in one folder; the same from a clone of the commit
//! elsewhere, byte by byte; and what a stranger can try of it with nothing else of the project.

use crate::platforms::Targets;
use crate::tools::{
    Context as _, Outcome, PUBLISHED, cargo_tool, emptied, ensure, listed, python, python_with, sh, shell, target, top,
    xshell,
};
use crate::{demo, fmu, install, site, web, wheel};
use std::path::{Path, PathBuf};
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
type Made = Outcome<Vec<(PathBuf, String)>>;

/// What is made, and how.
type Part = (&'static str, fn() -> Made);

const PARTS: &[Part] = &[
    ("crates", package),
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
    let changed = sh!("git status --porcelain").read()?;
    ensure!(changed.is_empty(), "a release is built from a commit; commit or stash what has changed:\n{changed}");
    let commit = || sh!("git log -1").arg("--format=%H of %cs").read();
    let (before, folder) = (commit()?, emptied(target().join("dist"))?);
    let mut rows = Vec::new();
    for (name, make) in PARTS {
        println!("\n== {name}");
        let start = Instant::now();
        for (path, about) in make()? {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let bytes = std::fs::copy(&path, folder.join(&name)).with_context(|| path.display().to_string())?;
            rows.push(format!("| {name} | {bytes} | {about} |\n"));
        }
        println!("  {:.1} s", start.elapsed().as_secs_f64());
    }
    ensure!(commit()? == before, "another commit was checked out meanwhile: build the release again");
    let text = shell().read_file("xtask/release/README.md")?;
    let words = [("@VERSION@", env!("CARGO_PKG_VERSION")), ("@COMMIT@", &before), ("@FILES@", &rows.concat())];
    let text = words.iter().fold(text, |text, (word, value)| text.replace(word, value));
    shell().write_file(folder.join("README.md"), &text)?;
    let (names, inside) = (listed(&folder)?, xshell::Shell::new()?);
    inside.change_dir(&folder);
    let sums = xshell::cmd!(inside, "sha256sum {names...}").quiet().read()?;
    shell().write_file(folder.join("SHA256SUMS"), sums + "\n")?;
    println!("\n{text}\n{}", folder.display());
    if options.reproduce {
        reproduced(&folder)?;
    }
    if options.smoke {
        sh!("python3 {folder}/smoke.py").run()?;
    }
    Ok(())
}

/// Builds the commit again in a clone, from nothing.
fn reproduced(folder: &Path) -> Outcome {
    let (top, clone) = (top(), emptied(target().join("elsewhere"))?.join("a-clone-of-the-commit"));
    sh!("git clone --quiet {top} {clone}").run()?;
    // The documentation has the tables of the evidence, whose answers take hours.
    if top.join("target/evidence").is_dir() {
        sh!("cp --recursive --parents target/evidence {clone}").run()?;
    }
    // The clone takes only the tools of this one, which come from crates.io.
    let path = format!("{}:{}", target().join("bin").display(), std::env::var("PATH").unwrap_or_default());
    let mut again = std::process::Command::from(sh!("cargo xtask release").env_remove("CARGO_TARGET_DIR"));
    ensure!(again.env("PATH", path).current_dir(&clone).status()?.success(), "the clone cannot build it");
    let other = clone.join("target/dist");
    let names = listed(folder)?;
    ensure!(names == listed(&other)?, "{} and {} hold different files", folder.display(), other.display());
    for name in &names {
        let [one, two] = [folder, &other].map(|at| shell().read_binary_file(at.join(name)));
        ensure!(one? == two?, "built again in {}, {name} differs", other.display());
    }
    let sums = sh!("sha256sum {folder}/SHA256SUMS {other}/SHA256SUMS").read()?;
    println!("{} files are the same in both folders:\n{sums}", names.len());
    Ok(())
}

fn one(path: PathBuf, about: &str) -> Made {
    Ok(vec![(path, about.into())])
}

fn package() -> Made {
    sh!("cargo package --quiet {PUBLISHED...}").run()?;
    let crates = [
        ("kernel", "the kernel"),
        ("capsule", "logs of what a host does, to be replayed"),
        ("scene", "scene files with units, and memory for their simulations"),
    ];
    let file = |name| target().join(format!("package/fabric-{name}-{}.crate", env!("CARGO_PKG_VERSION")));
    Ok(crates.map(|(name, about)| (file(name), format!("Rust: {about}, as crates.io takes it"))).into())
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
    let about = |version: &str| -> Outcome<(PathBuf, String)> {
        let path = target().join(format!("fmu/FabricShield-fmi{version}.fmu"));
        let names = sh!("python3 -m zipfile --list {path}").read()?;
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
    let (folder, python, fmu) = (target().join("dist-demo"), python()?, target().join("fmu/FabricShield-fmi2.fmu"));
    let program = format!("{}/rotorburst.py", demo::PROGRAMS);
    let printed = sh!("{python} {program} --case small --fmu {fmu} --out {folder} --capsule").read()?;
    let file = folder.join("demo.capsule");
    let digits: String = printed.lines().filter_map(|line| Some(line.split_once("capsule: ")?.1.trim())).collect();
    let bytes = |pair: &[u8]| str::from_utf8(pair).ok().and_then(|pair| u8::from_str_radix(pair, 16).ok());
    let bytes: Option<Vec<u8>> = digits.as_bytes().chunks(2).map(bytes).collect();
    shell().write_file(&file, bytes.context("the log of the FMU has no hexadecimal capsule")?)?;
    one(file, "capsule of the short demo: what its host did to the FMU, to be replayed")
}

/// What is in each thing that is shipped, with licences (CycloneDX), by the tools for it.
fn bills() -> Made {
    let folder = emptied(target().join("bills"))?;
    let (source, environment, wheels) = (folder.join("source"), folder.join("wheel"), target().join("wheels"));
    let mut made = Vec::new();
    let mut save = |name: &str, from: &Path, about: &str| -> Outcome {
        // The tools name folders of this machine.
        let text = [&source, &wheels]
            .iter()
            .fold(shell().read_file(from)?, |text, at| text.replace(&*at.to_string_lossy(), ""));
        let path = folder.join(format!("{name}.cdx.json"));
        made.push((path.clone(), format!("bill of materials (CycloneDX): {about}")));
        Ok(shell().write_file(path, text)?)
    };
    // It writes a file beside each Cargo.toml: into a copy.
    let top = top();
    sh!("git clone --quiet {top} {source}").run()?;
    let cargo = ["cyclonedx", "--quiet", "--format", "json", "--spec-version", "1.5", "--override-filename", "bill"];
    let cargo = cargo_tool("cargo-cyclonedx")?.args(cargo).arg("--manifest-path").arg(source.join("Cargo.toml"));
    cargo.env("SOURCE_DATE_EPOCH", sh!("git log -1 --format=%ct").read()?).run()?;
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
    let (inside, file) = (environment.join("bin/python"), folder.join("python.json"));
    let names = listed(&wheels)?;
    let own = |name: &&String| name.ends_with(&format!("_{}.whl", std::env::consts::ARCH));
    let wheel = wheels.join(names.iter().find(own).context("no wheel of this machine")?);
    sh!("python3 -m venv --without-pip {environment}").run()?;
    let pip = sh!("{python} -m pip --quiet --disable-pip-version-check --python {inside} install --no-compile");
    pip.arg(format!("{}[all]", wheel.display()))
        .args(["-c", "requirements.txt", "-c", "evidence/requirements.txt"])
        .run()?;
    sh!("{python} -m cyclonedx_py environment {inside} --output-reproducible -o {file}").run()?;
    save("python", &file, "the Python packages that a wheel needs")?;
    Ok(made)
}

fn texts() -> Made {
    let name = format!("fabric-{}", env!("CARGO_PKG_VERSION"));
    let source = target().join(format!("{name}-source.tar.gz"));
    sh!("git archive --format=tar.gz --prefix={name}/ --output {source} HEAD").run()?;
    let source = (source, "the whole project at this commit: begin with README.md and CHANGELOG.md in it".to_string());
    let smoke = (top().join("xtask/release/smoke.py"), "tries everything here, and uses nothing else".to_string());
    let licence = |name: &str| (top().join(name), "licence of the project, of two at your choice".to_string());
    Ok(vec![source, licence("LICENSE-APACHE"), licence("LICENSE-MIT"), smoke])
}
