//! `cargo xtask rotorburst`: the rotorburst example as an SSP package, compared with the host in Python.

use crate::tools::{Outcome, make_folder, output, python, run as command, target, top};
use crate::{fmu, platforms};
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub struct Options {
    /// Only what is judged: the time up to the first failed segment.
    #[arg(long)]
    pub short: bool,
}

/// Builds the fragment's FMU and the package, and compares both forms.
pub fn run(options: &Options) -> Outcome {
    let python = python()?;
    fmu::packed(platforms::Targets::Host, false)?;
    let out = target().join("rotorburst");
    make_folder(out.to_path_buf())?;
    let shield = target().join("fmu/FabricShield-fmi2.fmu");
    let package = package(&python, &out)?;
    println!("{}", package.display());

    let text = |path: &Path| path.to_string_lossy().into_owned();
    let program = text(&top().join("examples/rotorburst/agreement.py"));
    let (shield, package, results) = (text(&shield), text(&package), text(&out.join("results")));
    let mut arguments = vec![&*program, "--fmu", &shield, "--ssp", &package, "--out", &results];
    if options.short {
        arguments.push("--short");
    }
    command(python, &arguments)
}

const WARNINGS: [&str; 6] = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic"];

/// FragmentTrajectory.fmu and the shield of its scene for this platform, and Rotorburst.ssp with both. The
/// FMI headers are those that FMPy brings.
fn package(python: &Path, out: &Path) -> Result<PathBuf, String> {
    let headers = output(python, &["-c", "import fmpy, os; print(os.path.dirname(fmpy.__file__) + '/c-code')"])?;
    let library = out.join("FragmentTrajectory.so");
    let sources = ["examples/rotorburst/ssp/fragment_fmu.c", "examples/rotorburst/fragment.c"];
    let kind = ["-fPIC", "-shared", "-fvisibility=hidden", "-Wno-unused-parameter", "-I", headers.trim()];
    let last = ["-lm", "-o", &library.to_string_lossy()];
    command("cc", &[&WARNINGS[..], &kind, &sources, &last].concat())?;

    let source = |name: &str| top().join("examples/rotorburst/ssp").join(name);
    let trajectory = out.join("FragmentTrajectory.fmu");
    let binary = format!("binaries/{}/FragmentTrajectory.so", platforms::host()?.fmu[0]);
    fmu::pack(&trajectory, &[("modelDescription.xml".into(), source("FragmentTrajectory.xml")), (binary, library)])?;
    let shield = fmu::of_scene("RotorburstShield", &source("shield.toml"))?;
    let package = out.join("Rotorburst.ssp");
    let entries = [
        ("SystemStructure.ssd", source("SystemStructure.ssd")),
        ("resources/FragmentTrajectory.fmu", trajectory),
        ("resources/RotorburstShield.fmu", shield),
    ];
    fmu::pack(&package, &entries.map(|(name, path)| (name.to_string(), path)))?;
    Ok(package)
}
