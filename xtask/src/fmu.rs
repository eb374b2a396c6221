//! `cargo xtask fmu`: the model descriptions, their page and parameter sets, the tables of parameters and outputs of the documents,
//! and the types of the Python package, from the tables in code; and the archives.

use crate::component;
use crate::description::{self, element_name};
use crate::header;
use crate::model::Model;
use crate::outputs;
use crate::page;
use crate::platforms::{self, Library, Targets};
use crate::tools::{self, Outcome};
use crate::xml::{Xml, some, tag};
use fabric::Scene;
use fabric::fields::{self, Choice, FIELDS, Field, Place};
use fabric_fmu::MODEL_IDENTIFIER;
use fabric_fmu::parameters::Parameters;
use fabric_fmu::starts;
use fabric_fmu::table::{Role, VARIABLES};
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

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
    let model = Model::own();
    let made = tools::top().join("modelDescription");
    let mut files = files(&model, &made);
    let others = [("docs/tables/scene.md".into(), parameters()), ("docs/tables/outputs.md".into(), outputs::table())];
    let others = parameter_sets().into_iter().chain(others).chain([outputs::types()?]);
    files.extend(others.map(|(name, text)| (tools::top().join(name), text)));
    tools::made(&files, options.check, "cargo xtask fmu")?;
    if options.check {
        return Ok(());
    }
    if options.targets == Targets::Host {
        println!("For this platform only; `cargo xtask fmu --targets all` adds the others.");
    }
    let built = build(&tools::top(), &tools::target(), options.targets, None)?;
    let archives = archives(&model, &tools::top(), &made, &built, &tools::target().join("fmu"))?;
    for archive in archives {
        println!("{}", archive.display());
    }
    Ok(())
}

/// What archives hold of compiled code: the libraries, and the component for WebAssembly if it is wanted and can be built.
type Built = (Vec<Library>, Option<PathBuf>);

fn build(source: &Path, target: &Path, targets: Targets, scene: Option<[&str; 2]>) -> Result<Built, String> {
    let libraries = platforms::build(source, target, targets, scene)?;
    let component = match targets {
        Targets::Host => None,
        Targets::All => component::build_if_ready(source, &target.join("cross"), scene)?,
    };
    Ok((libraries, component))
}

/// Builds and packs a model of a scene: FMI 2.0, then FMI 3.0.
pub fn of_scene(name: &str, file: &Path, targets: Targets) -> Result<[PathBuf; 2], String> {
    let model = Model::of(name, file)?;
    let out = tools::target().join("fmu");
    let folder = out.join(name);
    tools::made(&files(&model, &folder), false, "")?;
    // Its library has another folder than the usual one: neither is built again because of the other.
    let built = build(&tools::top(), &tools::target().join("scenes"), targets, model.compiled())?;
    archives(&model, &tools::top(), &folder, &built, &out)
}

/// The files that are made for a model in a folder, and their texts.
fn files(model: &Model, folder: &Path) -> Vec<(PathBuf, String)> {
    let names = ["fmi2.xml", "fmi3.xml", "documentation/index.html"];
    let texts = [description::fmi2(model), description::fmi3(model), page::page(model)];
    names.into_iter().map(|name| folder.join(name)).zip(texts).collect()
}

/// Packs the two archives: the files made for the model in `made`, what the checkout in `source` has besides, and what is compiled.
fn archives(
    model: &Model,
    source: &Path,
    made: &Path,
    (libraries, component): &Built,
    out: &Path,
) -> Result<[PathBuf; 2], String> {
    let of_model = |name: &str, path: &str| (name.to_string(), made.join(path));
    let file = |name: &str, path: &str| (name.to_string(), source.join("modelDescription").join(path));
    let mut two = vec![of_model("modelDescription.xml", "fmi2.xml"), file("model.png", "icon.png")];
    if model.words.is_none() {
        let folder = |name: &str| name.replace("examples", "documentation");
        two.extend(parameter_sets().iter().map(|(name, _)| (folder(name), source.join(name))));
    }
    let mut three = vec![
        of_model("modelDescription.xml", "fmi3.xml"),
        file("terminalsAndIcons/icon.png", "icon.png"),
        file("terminalsAndIcons/terminalsAndIcons.xml", "terminalsAndIcons.xml"),
    ];
    if let Some(component) = component {
        three.push((format!("binaries/{}/{}.wasm", component::PLATFORM, model.name), component.clone()));
        three.extend(component::MANIFESTS.map(|name| file(name, "fmi-ls-wasm.xml")));
    }
    for (entries, version) in [(&mut two, 2), (&mut three, 3)] {
        entries.push(of_model("documentation/index.html", "documentation/index.html"));
        entries.push(file("documentation/licenses/license.txt", "documentation/licenses/license.txt"));
        entries.extend(libraries.iter().map(|Library { platform, path }| {
            let folder = platform.fmu[version - 2];
            (format!("binaries/{folder}/{}.{}", model.name, platform.extension), path.clone())
        }));
    }
    tools::make_folder(out.to_path_buf())?;
    let names = ["fmi2", "fmi3"].map(|name| out.join(format!("{}-{name}.fmu", model.name)));
    for (archive, entries) in names.iter().zip([two, three]) {
        pack(archive, entries)?;
    }
    Ok(names)
}

/// Packs files so that the same files give the same bytes: sorted, with one fixed time and mode.
pub fn pack(archive: &Path, mut entries: Vec<(String, PathBuf)>) -> Outcome {
    entries.sort();
    let file = fs::File::create(archive).map_err(|error| format!("{}: {error}", archive.display()))?;
    let mut zip = zip::ZipWriter::new(file);
    for (name, path) in entries {
        let bytes = fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        let mode = if name.starts_with("binaries/") { 0o755 } else { 0o644 };
        let options = zip::write::SimpleFileOptions::default()
            .compression_method(zip::CompressionMethod::Deflated)
            .compression_level(Some(9))
            .last_modified_time(zip::DateTime::default())
            .unix_permissions(mode);
        zip.start_file(&name, options).map_err(|error| format!("{name}: {error}"))?;
        zip.write_all(&bytes).map_err(|error| format!("{name}: {error}"))?;
    }
    zip.finish().map_err(|error| format!("{}: {error}", archive.display()))?;
    Ok(())
}

// ---- Parameter sets ---------------------------------------------------------------------------------------------------

/// The other presets, and a stack, as parameter sets of SSP 1.0 for the FMU of FMI 2.0: what differs from its start values.
fn parameter_sets() -> Vec<(String, String)> {
    let name_of = |name: &str| format!("examples/parameters/{name}.ssv");
    let others = fabric_scene::PRESETS.iter().filter(|(_, make)| make() != Scene::sheet_10in_cylinder());
    let others = others.map(|(name, make)| (*name, make())).chain([("three_plies", three_plies())]);
    others.map(|(name, scene)| (name_of(name), parameter_set(name, scene))).collect()
}

/// The 3 in sheet and its sphere with three separate plies, a quarter of a millimetre apart.
fn three_plies() -> Scene {
    let scene = Scene::sheet_3in_sphere();
    Scene { stack: fabric::Stack { plies: 3, gap: 2.5e-4, ..scene.stack }, ..scene }
}

fn parameter_set(name: &str, mut scene: Scene) -> String {
    // As the start values: a time step in seconds, and the projectile 1 mm before the sheet.
    scene.time_step.seconds = starts::TIME_STEP;
    scene.projectile.position[2] -= starts::STAND_OFF;
    let (own, other) = (Model::own(), Model { starts: Parameters::of(scene), ..Model::own() });
    let mut out = Xml::new();
    out.line(&format!(
        "<!-- Written by `cargo xtask fmu`: the scene {name}, as far as it differs from the start values of {MODEL_IDENTIFIER}. -->"
    ));
    let space = ("xmlns:ssv", some("http://ssp-standard.org/SSP1/SystemStructureParameterValues"));
    let attributes = [("version", some("1.0")), ("name", some(name)), space];
    let parameters = |out: &mut Xml| {
        for variable in VARIABLES.iter().filter(|variable| variable.role == Role::Fixed) {
            let [is, wanted] = [&own, &other].map(|model| description::starts(model, variable));
            for (element, (_, wanted)) in is.iter().zip(&wanted).enumerate().filter(|(_, (is, wanted))| is != wanted) {
                let parameter = tag("ssv:Parameter", &[("name", some(element_name(variable, element)))]);
                let kind = format!("ssv:{}", description::kind_in_2(variable.kind));
                out.line(&format!("<{parameter}><{}/></ssv:Parameter>", tag(&kind, &[("value", some(wanted))])));
            }
        }
    };
    out.element("ssv:ParameterSet", &attributes, |out| out.element("ssv:Parameters", &[], parameters));
    out.text()
}

// ---- Table of parameters ----------------------------------------------------------------------------------------------

/// docs/tables/scene.md.
fn parameters() -> String {
    let mut out = String::from(
        "# The parameters of a scene\n\n\
         Written by `cargo xtask fmu` from `kernel/src/scene/fields/table.rs`.\n\
         The names are those of Rust, of scene files and of the FMUs, where `projectile.position` and the other three numbers of the \
         motion are `projectile.start.position` and so on.\n\
         Scene files take [units and further keys](../../fabrics/README.md#sheet-and-projectile), too.\n\
         A vector has the same range for each element.\n\
         The default is that of the 10 in preset; that of the 3 in preset follows after \"3 in:\" where it differs.\n\
         The FMUs start with `time_step.seconds` = 2e-8 and with the projectile 1 mm before the sheet.\n\n\
         | name | type | unit | range | default | FMI reference | meaning |\n|---|---|---|---|---|---|---|\n",
    );
    for field in FIELDS {
        let named =
            |choice: &Choice, k: u64| format!("`{}`", choice.items.get(k as usize).map_or("", |(name, _)| name));
        let scenes = [Scene::sheet_10in_cylinder(), Scene::sheet_3in_sphere()];
        let [ten, three] = scenes.map(|scene| header::values(field, scene, named));
        let default = if ten == three { ten } else { format!("{ten}; 3 in: {three}") };
        let unit = field.quantity.map_or("", |quantity| quantity.unit);
        let cells =
            [format!("`{}`", field.name), typed(field), unit.into(), range(field), default, field.fmi.to_string()];
        out.push_str(&format!("| {} | {} |\n", cells.join(" | "), field.about));
    }
    out.push_str("\n## The choices\n");
    for choice in fields::CHOICES {
        out.push_str(&format!("\n{}:\n\n", choice.name));
        for (number, (name, about)) in choice.items.iter().enumerate() {
            out.push_str(&format!("- {number} `{name}`: {about}\n"));
        }
    }
    out
}

fn typed(field: &Field) -> String {
    match field.place {
        Place::Reals(_, []) => "real".into(),
        Place::Reals(_, shape) => {
            format!("real, {}", shape.iter().map(ToString::to_string).collect::<Vec<_>>().join(" x "))
        }
        Place::Count(_) => "count".into(),
        Place::Seed(_) => "seed, 64 bits".into(),
        Place::Flag(_) => "1 (true) or 0".into(),
        Place::Choice(choice, ..) => choice.name.into(),
    }
}

fn range(field: &Field) -> String {
    match field.place {
        Place::Flag(_) | Place::Choice(..) => String::new(),
        _ => header::range(field).unwrap_or_default(),
    }
}
