//! `cargo xtask fmu`: the model descriptions, their page and parameter sets, the tables of parameters and
//! outputs of the documents, and the types of the Python package, from the tables in code; and the archives.

use crate::component;
use crate::platforms::{self, Library, Targets};
use crate::tools::{Outcome, sh, tables, target};
use std::path::{Path, PathBuf};

#[derive(clap::Args, Default)]
pub struct Options {
    /// Only compare the committed files with the tables in code.
    #[arg(long)]
    pub check: bool,
    /// Which platforms the archives hold: all whose tools are installed, or only this one.
    #[arg(long, value_enum, default_value_t)]
    pub targets: Targets,
}

pub fn run(options: &Options) -> Outcome {
    tables(if options.check { &["fmu", "--check"] } else { &["fmu"] })?;
    if options.check {
        return Ok(());
    }
    if options.targets == Targets::Host {
        println!("For this platform only; `cargo xtask fmu --targets all` adds the others.");
    }
    for archive in packed(options.targets, true)? {
        println!("{}", archive.display());
    }
    Ok(())
}

/// Builds and packs the FMUs with what is committed: FMI 2.0, then FMI 3.0. `checked`: what the libraries ask
/// of their hosts, too.
pub fn packed(targets: Targets, checked: bool) -> Outcome<[PathBuf; 2]> {
    let out = target().join("fmu");
    let libraries = platforms::build(targets)?;
    if checked {
        let named = |library: &Library| format!("{}={}", library.platform.triple, library.path.display());
        let named: Vec<_> = libraries.iter().map(named).collect();
        tables(&["check"].into_iter().chain(named.iter().map(String::as_str)).collect::<Vec<_>>())?;
    }
    let component = if targets == Targets::All { component::build_if_ready()? } else { None };
    let folders = |Library { platform, path }: &Library| format!("{}={}", platform.fmu.join(","), path.display());
    let libraries = libraries.iter().map(folders);
    sh!("python3 fmu/pack/pack.py shield {out} {component...} {libraries...}").run()?;
    Ok(["fmi2", "fmi3"].map(|version| out.join(format!("FabricShield-{version}.fmu"))))
}

/// An FMU of FMI 2.0 with the start values of a scene, from the one that is packed.
pub fn of_scene(name: &str, file: &Path) -> Outcome<PathBuf> {
    let (python, out) = (crate::wheel::installed()?, target().join("fmu"));
    sh!("{python} -m fabric_kernel.program fmu {file} --version 2 --name {name} --from {out} --out {out}").run()?;
    Ok(out.join(format!("{name}-fmi2.fmu")))
}

/// Packs files; the same files give the same bytes.
pub fn pack(archive: &Path, entries: &[(&str, &Path)]) -> Outcome {
    let entries = entries.iter().map(|(name, path)| format!("{name}={}", path.display()));
    Ok(sh!("python3 fmu/pack/pack.py {archive} {entries...}").run()?)
}
