//! `cargo xtask fmu`: the model descriptions, their page and parameter sets, the tables of parameters and outputs of the documents,
//! and the types of the Python package, from the tables in code; and the archives.

use crate::component;
use crate::platforms::{self, Library, Targets};
use crate::tools::{self, Outcome};
use std::path::{Path, PathBuf};

/// Name of the model that has no scene of its own.
const OWN: &str = "FabricShield";

#[derive(clap::Args, Default)]
pub struct Options {
    /// Only compare the committed files with the tables in code.
    #[arg(long)]
    pub check: bool,
    /// Which platforms the archives hold: all whose tools are installed, or only this one.
    #[arg(long, value_enum, default_value_t)]
    pub targets: Targets,
    /// Pack a model of its own, whose start values, description and page are those of this scene (TOML).
    #[arg(long, value_name = "FILE", requires = "name", conflicts_with = "check")]
    pub scene: Option<PathBuf>,
    /// Name of that model: letters, digits and _, a letter first.
    #[arg(long, requires = "scene")]
    pub name: Option<String>,
}

pub fn run(options: &Options) -> Outcome {
    if let (Some(name), Some(file)) = (&options.name, &options.scene) {
        for archive in of_scene(name, file, options.targets)? {
            println!("{}", archive.display());
        }
        return Ok(());
    }
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

/// Builds and packs the FMUs with what is committed. `checked`: what the libraries ask of their hosts, too.
pub fn packed(targets: Targets, checked: bool) -> Result<[PathBuf; 2], String> {
    let built = build(&tools::target(), targets, None, checked)?;
    archives(OWN, &tools::top().join("modelDescription"), &built, &tools::target().join("fmu"))
}

/// What archives hold of compiled code: the libraries, and the component for WebAssembly if it is wanted and can be built.
type Built = (Vec<Library>, Option<PathBuf>);

fn build(target: &Path, targets: Targets, scene: Option<[&str; 2]>, checked: bool) -> Result<Built, String> {
    let libraries = platforms::build(&tools::top(), target, targets, scene)?;
    let named = |library: &Library| format!("{}={}", library.platform.triple, library.path.display());
    let named: Vec<_> = libraries.iter().map(named).collect();
    if checked {
        let words: Vec<_> = ["check"].into_iter().chain(named.iter().map(String::as_str)).collect();
        tools::wait(&mut tools::tables(&words)?)?;
    }
    let component = match targets {
        Targets::Host => None,
        Targets::All => component::build_if_ready(&tools::top(), &target.join("cross"), scene)?,
    };
    Ok((libraries, component))
}

/// Builds and packs a model of a scene: FMI 2.0, then FMI 3.0.
pub fn of_scene(name: &str, file: &Path, targets: Targets) -> Result<[PathBuf; 2], String> {
    let out = tools::target().join("fmu");
    let (file, folder) = (std::path::absolute(file).map_err(|error| error.to_string())?, out.join(name));
    let mut model = tools::tables(&["model", name, &file.to_string_lossy(), &folder.to_string_lossy()])?;
    let words = String::from_utf8_lossy(&tools::finish(&mut model)?.stdout).into_owned();
    // Its library has another folder than the usual one: neither is built again because of the other.
    let built = build(&tools::target().join("scenes"), targets, Some([name, words.trim()]), true)?;
    archives(name, &folder, &built, &out)
}

/// Packs the two archives: the files made for the model in `made`, what the checkout has besides, and what is compiled.
fn archives(name: &str, made: &Path, (libraries, component): &Built, out: &Path) -> Result<[PathBuf; 2], String> {
    let of_model = |name: &str, path: &str| (name.to_string(), made.join(path));
    let file = |name: &str, path: &str| (name.to_string(), tools::top().join("modelDescription").join(path));
    let mut two = vec![of_model("modelDescription.xml", "fmi2.xml"), file("model.png", "icon.png")];
    if name == OWN {
        let sets = tools::listed(&tools::top().join("examples/parameters"))?;
        let entry = |set: &String| {
            (format!("documentation/parameters/{set}"), tools::top().join("examples/parameters").join(set))
        };
        two.extend(sets.iter().filter(|set| set.ends_with(".ssv")).map(entry));
    }
    let mut three = vec![
        of_model("modelDescription.xml", "fmi3.xml"),
        file("terminalsAndIcons/icon.png", "icon.png"),
        file("terminalsAndIcons/terminalsAndIcons.xml", "terminalsAndIcons.xml"),
    ];
    if let Some(component) = component {
        three.push((format!("binaries/{}/{name}.wasm", component::PLATFORM), component.clone()));
        three.extend(component::MANIFESTS.map(|name| file(name, "fmi-ls-wasm.xml")));
    }
    for (entries, version) in [(&mut two, 2), (&mut three, 3)] {
        entries.push(of_model("documentation/index.html", "documentation/index.html"));
        entries.push(file("documentation/licenses/license.txt", "documentation/licenses/license.txt"));
        entries.extend(libraries.iter().map(|Library { platform, path }| {
            let folder = platform.fmu[version - 2];
            (format!("binaries/{folder}/{name}.{}", platform.extension), path.clone())
        }));
    }
    tools::make_folder(out.to_path_buf())?;
    let names = ["fmi2", "fmi3"].map(|version| out.join(format!("{name}-{version}.fmu")));
    for (archive, entries) in names.iter().zip([two, three]) {
        pack(archive, &entries)?;
    }
    Ok(names)
}

/// Packs files so that the same files give the same bytes: sorted, with one fixed time and mode.
pub fn pack(archive: &Path, entries: &[(String, PathBuf)]) -> Outcome {
    let entries: Vec<_> = entries.iter().map(|(name, path)| format!("{name}={}", path.display())).collect();
    let words = ["xtask/pack.py", &archive.to_string_lossy()].map(String::from);
    tools::run("python3", &words.iter().chain(&entries).map(String::as_str).collect::<Vec<_>>())
}
