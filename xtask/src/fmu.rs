//! `cargo xtask fmu`: the model descriptions, their page and parameter sets, the tables of parameters and
//! outputs of the documents, and the types of the Python package, from the tables in code; and the archives.

use crate::component;
use crate::platforms::{self, Library, Targets};
use crate::tools::{self, Outcome};
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
    tools::wait(&mut tools::tables(if options.check { &["fmu", "--check"] } else { &["fmu"] })?)?;
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
pub fn packed(targets: Targets, checked: bool) -> Result<[PathBuf; 2], String> {
    let (target, out) = (tools::target(), tools::target().join("fmu"));
    let libraries = platforms::build(&tools::top(), &target, targets)?;
    let named = |library: &Library| format!("{}={}", library.platform.triple, library.path.display());
    let named: Vec<_> = libraries.iter().map(named).collect();
    if checked {
        let words: Vec<_> = ["check"].into_iter().chain(named.iter().map(String::as_str)).collect();
        tools::wait(&mut tools::tables(&words)?)?;
    }
    let component = match targets {
        Targets::Host => None,
        Targets::All => component::build_if_ready(&tools::top(), &target.join("cross"))?,
    };
    let folders = |Library { platform, path }: &Library| format!("{}={}", platform.fmu.join(","), path.display());
    let mut words = vec!["fmu/pack/pack.py".into(), "shield".into(), out.to_string_lossy().into_owned()];
    words.extend(component.map(|file| file.to_string_lossy().into_owned()));
    words.extend(libraries.iter().map(folders));
    tools::run("python3", &words.iter().map(String::as_str).collect::<Vec<_>>())?;
    Ok(["fmi2", "fmi3"].map(|version| out.join(format!("FabricShield-{version}.fmu"))))
}

/// An FMU of FMI 2.0 with the start values of a scene, from the one that is packed.
pub fn of_scene(name: &str, file: &Path) -> Result<PathBuf, String> {
    let (python, out) = (crate::wheel::installed()?, tools::target().join("fmu"));
    let [file, folder] = [file, &out].map(|path| path.to_string_lossy().into_owned());
    let words = ["-m", "fabric_kernel.program", "fmu", &file, "--version", "2", "--name", name];
    tools::run(python, &[&words[..], &["--from", &folder, "--out", &folder]].concat())?;
    Ok(out.join(format!("{name}-fmi2.fmu")))
}

/// Packs files; the same files give the same bytes.
pub fn pack(archive: &Path, entries: &[(String, PathBuf)]) -> Outcome {
    let entries: Vec<_> = entries.iter().map(|(name, path)| format!("{name}={}", path.display())).collect();
    let words = ["fmu/pack/pack.py", &archive.to_string_lossy()].map(String::from);
    tools::run("python3", &words.iter().chain(&entries).map(String::as_str).collect::<Vec<_>>())
}
