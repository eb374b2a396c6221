//! `cargo xtask rotorburst`: the rotorburst example as an SSP package, compared with the host in Python.

use crate::tools::{Outcome, python, sh, shell, target, top};
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
    let out = shell().create_dir(target().join("rotorburst"))?;
    let shield = target().join("fmu/FabricShield-fmi2.fmu");
    let package = package(&python, &out)?;
    println!("{}", package.display());
    let short = options.short.then_some("--short");
    let program = sh!("{python} examples/rotorburst/agreement.py --fmu {shield} --ssp {package}");
    Ok(program.arg("--out").arg(out.join("results")).args(short).run()?)
}

const WARNINGS: [&str; 6] = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic"];

/// FragmentTrajectory.fmu and the shield of its scene for this platform, and Rotorburst.ssp with both. The
/// FMI headers are those that FMPy brings.
fn package(python: &Path, out: &Path) -> Outcome<PathBuf> {
    let printed = "import fmpy, os; print(os.path.dirname(fmpy.__file__) + '/c-code')";
    let headers = sh!("{python} -c {printed}").read()?;
    let library = out.join("FragmentTrajectory.so");
    let sources = ["examples/rotorburst/ssp/fragment_fmu.c", "examples/rotorburst/fragment.c"];
    let kind = ["-fPIC", "-shared", "-fvisibility=hidden", "-Wno-unused-parameter"];
    sh!("cc {WARNINGS...} {kind...} -I {headers} {sources...} -lm -o {library}").run()?;

    let source = |name: &str| top().join("examples/rotorburst/ssp").join(name);
    let (trajectory, package) = (out.join("FragmentTrajectory.fmu"), out.join("Rotorburst.ssp"));
    let binary = format!("binaries/{}/FragmentTrajectory.so", platforms::host()?.fmu[0]);
    let description = source("FragmentTrajectory.xml");
    fmu::pack(&trajectory, &[("modelDescription.xml", &description), (&binary, &library)])?;
    let shield = fmu::of_scene("RotorburstShield", &source("shield.toml"))?;
    let entries = [
        ("SystemStructure.ssd", &*source("SystemStructure.ssd")),
        ("resources/FragmentTrajectory.fmu", &trajectory),
        ("resources/RotorburstShield.fmu", &shield),
    ];
    fmu::pack(&package, &entries)?;
    Ok(package)
}
