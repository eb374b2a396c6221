//! `cargo xtask fmu`: the model descriptions and the table of parameters of the documents from the tables in code, and the two
//! archives.

use crate::platforms::{self, Library, Targets};
use crate::tools::{self, Outcome};
use fabric::Scene;
use fabric::fields::{self, FIELDS, Field, Place, Range};
use fabric_fmu::MODEL_IDENTIFIER;
use fabric_fmu::parameters::Parameters;
use fabric_fmu::table::{self, Id, Kind, MOST_ELEMENTS, Role, Variable};
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Options of the command.
#[derive(clap::Args, Default)]
pub struct Options {
    /// Only compare the committed files with the tables in code.
    #[arg(long)]
    pub check: bool,
    /// Which platforms the archives hold: all whose tools are installed, or only this one.
    #[arg(long, value_enum, default_value_t)]
    pub targets: Targets,
    /// Build everything a second time in another folder and compare the archives byte by byte.
    #[arg(long)]
    pub reproduce: bool,
}

const DESCRIPTION: &str =
    "Ballistic fabric as a network of yarn segments, hit by a rigid projectile that the FMU or its host moves";

/// Runs the command.
pub fn run(options: &Options) -> Outcome {
    let files = [
        ("modelDescription/fmi2.xml", fmi2()),
        ("modelDescription/fmi3.xml", fmi3()),
        ("docs/tables/scene.md", parameters()),
    ];
    for (name, text) in &files {
        let path = tools::top().join(name);
        if !options.check {
            fs::write(path, text).map_err(|error| format!("{name}: {error}"))?;
        } else if fs::read_to_string(path).unwrap_or_default() != *text {
            return Err(format!("{name} does not match the tables in code: run `cargo xtask fmu`"));
        }
    }
    if options.check {
        return Ok(());
    }
    if options.targets == Targets::Host {
        println!("For this platform only; `cargo xtask fmu --targets all` adds the others.");
    }
    let libraries = platforms::build(&tools::top(), &tools::target(), options.targets)?;
    let archives = archives(&tools::top(), &libraries, &tools::target().join("fmu"))?;
    if options.reproduce {
        let (copy, again) = platforms::reproduced(&libraries, options.targets)?;
        let others = self::archives(&copy, &again, &copy.with_file_name("fmu"))?;
        for (one, other) in archives.iter().zip(&others) {
            let sum = |path: &Path| tools::output("sha256sum", &["--binary", &path.to_string_lossy()]);
            let sums = [sum(one)?, sum(other)?].map(|text| text.split_whitespace().next().unwrap_or("").to_string());
            println!("  {}  {}\n  {}  {}", sums[0], one.display(), sums[1], other.display());
            if sums[0] != sums[1] {
                return Err("two builds in two folders differ".into());
            }
        }
    }
    for archive in archives {
        println!("{}", archive.display());
    }
    Ok(())
}

/// Packs the two archives with what the checkout in `source` has besides the libraries.
fn archives(source: &Path, libraries: &[Library], out: &Path) -> Result<[PathBuf; 2], String> {
    let file = |name: &str, path: &str| (name.to_string(), source.join("modelDescription").join(path));
    let documentation = ["documentation/index.html", "documentation/licenses/license.txt"];
    let mut two = vec![file("modelDescription.xml", "fmi2.xml"), file("model.png", "icon.png")];
    let mut three = vec![
        file("modelDescription.xml", "fmi3.xml"),
        file("terminalsAndIcons/icon.png", "icon.png"),
        file("terminalsAndIcons/terminalsAndIcons.xml", "terminalsAndIcons.xml"),
    ];
    for (entries, version) in [(&mut two, 2), (&mut three, 3)] {
        entries.extend(documentation.map(|name| file(name, name)));
        entries.extend(libraries.iter().map(|Library { platform, path }| {
            let folder = if version == 2 { platform.fmi2 } else { platform.fmi3 };
            (format!("binaries/{folder}/{MODEL_IDENTIFIER}.{}", platform.extension), path.clone())
        }));
    }
    tools::make_folder(out.to_path_buf())?;
    let names = ["fmi2", "fmi3"].map(|name| out.join(format!("{MODEL_IDENTIFIER}-{name}.fmu")));
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

// ---- Model descriptions -----------------------------------------------------------------------------------------------

/// Text of an attribute.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

/// An element being written: indentation, name and attributes.
fn tag(indent: usize, name: &str, attributes: &[(&str, Option<String>)]) -> String {
    let mut text = format!("{}<{name}", "  ".repeat(indent));
    for (key, value) in attributes {
        if let Some(value) = value {
            text.push_str(&format!(" {key}=\"{}\"", escaped(value)));
        }
    }
    text
}

fn some(text: impl ToString) -> Option<String> {
    Some(text.to_string())
}

/// A number, in the shortest form that reads back as the same; whole for types that are whole.
fn number(kind: Kind, value: f64) -> String {
    match kind {
        Kind::Real => format!("{value:?}"),
        Kind::Boolean => (value != 0.0).to_string(),
        Kind::Integer | Kind::Choice(_) => format!("{}", value as i64),
    }
}

fn token() -> String {
    String::from_utf8_lossy(&fabric_fmu::token::text()).into_owned()
}

/// Start values of an input or parameter, one text per element; none of an output.
fn starts(variable: &Variable) -> Vec<String> {
    let mut values = [0.0; MOST_ELEMENTS];
    Parameters::default().get(variable, &mut values);
    let size = if variable.role.is_output() { 0 } else { variable.size() };
    values.iter().take(size).map(|&start| number(variable.kind, start)).collect()
}

fn description(variable: &Variable) -> Option<String> {
    some(format!("{}{}", variable.description, variable.note))
}

/// The attributes that the two versions share, with the names of FMI 2.0.
fn head() -> Vec<(&'static str, Option<String>)> {
    vec![
        ("modelName", some(MODEL_IDENTIFIER)),
        ("description", some(DESCRIPTION)),
        ("author", some("The fabric developers")),
        ("version", some(env!("CARGO_PKG_VERSION"))),
        ("copyright", some("The fabric developers")),
        ("license", some("MIT OR Apache-2.0")),
        ("generationTool", some("cargo xtask fmu")),
        ("variableNamingConvention", some("structured")),
    ]
}

fn units(out: &mut String) {
    out.push_str("  <UnitDefinitions>\n");
    for unit in table::UNITS {
        let exponent = |power: i32| (power != 0).then(|| power.to_string());
        let [kg, m, s, rad] = unit.exponents.map(exponent);
        out.push_str(&format!("{}>\n", tag(2, "Unit", &[("name", some(unit.name))])));
        out.push_str(&format!("{}/>\n", tag(3, "BaseUnit", &[("kg", kg), ("m", m), ("s", s), ("rad", rad)])));
        for (name, factor) in unit.display {
            let attributes = [("name", some(name)), ("factor", some(number(Kind::Real, *factor)))];
            out.push_str(&format!("{}/>\n", tag(3, "DisplayUnit", &attributes)));
        }
        out.push_str("    </Unit>\n");
    }
    out.push_str("  </UnitDefinitions>\n");
}

/// The type definitions; FMI 2.0 wraps each in a SimpleType.
fn types(out: &mut String, two: bool) {
    out.push_str("  <TypeDefinitions>\n");
    for quantity in table::quantities() {
        let about = ("description", some(quantity.description));
        let attributes = [
            ("quantity", some(quantity.name)),
            ("unit", some(quantity.unit)),
            ("displayUnit", (!quantity.display.is_empty()).then(|| quantity.display.to_string())),
            ("min", finite(quantity.least)),
            ("nominal", finite(quantity.nominal)),
        ];
        let name = ("name", some(quantity.name));
        if two {
            out.push_str(&format!("{}>\n", tag(2, "SimpleType", &[name, about])));
            out.push_str(&format!("{}/>\n    </SimpleType>\n", tag(3, "Real", &attributes)));
        } else {
            out.push_str(&format!("{}/>\n", tag(2, "Float64Type", &[&[name, about], &attributes[..]].concat())));
        }
    }
    for choice in table::choices() {
        let name = [("name", some(choice.name))];
        if two {
            out.push_str(&format!("{}>\n      <Enumeration>\n", tag(2, "SimpleType", &name)));
        } else {
            out.push_str(&format!("{}>\n", tag(2, "EnumerationType", &name)));
        }
        for (value, (name, about)) in choice.items.iter().enumerate() {
            let attributes = [("name", some(name)), ("value", some(value)), ("description", some(about))];
            out.push_str(&format!("{}/>\n", tag(if two { 4 } else { 3 }, "Item", &attributes)));
        }
        out.push_str(if two { "      </Enumeration>\n    </SimpleType>\n" } else { "    </EnumerationType>\n" });
    }
    out.push_str("  </TypeDefinitions>\n");
}

fn log_and_experiment(out: &mut String) {
    out.push_str("  <LogCategories>\n");
    for (name, about) in table::LOG_CATEGORIES {
        let attributes = [("name", some(name)), ("description", some(about))];
        out.push_str(&format!("{}/>\n", tag(2, "Category", &attributes)));
    }
    out.push_str("  </LogCategories>\n");
    let real = |value| some(number(Kind::Real, value));
    let experiment = [
        ("startTime", real(0.0)),
        ("stopTime", real(table::DEFAULT_STOP_TIME)),
        ("stepSize", real(table::DEFAULT_STEP_SIZE)),
    ];
    out.push_str(&format!("{}/>\n", tag(1, "DefaultExperiment", &experiment)));
}

fn causality(variable: &Variable) -> &'static str {
    match variable.role {
        Role::Input => "input",
        Role::Fixed | Role::Tunable => "parameter",
        Role::Continuous | Role::Discrete => "output",
    }
}

fn variability(variable: &Variable) -> &'static str {
    match variable.role {
        Role::Input | Role::Continuous => "continuous",
        Role::Fixed => "fixed",
        Role::Tunable => "tunable",
        Role::Discrete => "discrete",
    }
}

/// FMI forbids `initial` for inputs.
fn initial(variable: &Variable) -> Option<String> {
    match variable.role {
        Role::Input => None,
        Role::Fixed | Role::Tunable => some("exact"),
        Role::Continuous | Role::Discrete => some("calculated"),
    }
}

/// A limit or typical size, if there is one.
fn finite(value: f64) -> Option<String> {
    value.is_finite().then(|| number(Kind::Real, value))
}

/// Declared type, unit (again, for hosts that do not look at types), and range and nominal where they are not the type's.
fn value_attributes(variable: &Variable) -> Vec<(&'static str, Option<String>)> {
    let limits = variable.limits();
    let least = variable.quantity.map_or(f64::NEG_INFINITY, |quantity| quantity.least);
    let limited = matches!(variable.kind, Kind::Real | Kind::Integer) && !variable.role.is_output();
    let limit = |k: usize| {
        let own = limited && limits[k].is_finite() && limits[k] != least;
        own.then(|| number(variable.kind, limits[k]))
    };
    let declared = match (variable.kind, variable.quantity) {
        (Kind::Choice(choice), _) => some(choice.name),
        (_, Some(quantity)) => some(quantity.name),
        _ => None,
    };
    vec![
        ("declaredType", declared),
        ("unit", variable.quantity.map(|quantity| quantity.unit.to_string())),
        ("min", limit(0)),
        ("max", limit(1)),
        ("nominal", (variable.nominal != 0.0).then(|| number(Kind::Real, variable.nominal))),
    ]
}

/// What an output depends on when initialisation ends: nothing (it is zero, or -1), the input of the same meaning, or, where the
/// attribute is left out, all inputs and parameters.
fn at_start(variable: &Variable, name_of: impl Fn(&Variable) -> String) -> (&'static str, Option<String>) {
    let input = |name: &str| table::variable(name).map(&name_of);
    let known = match variable.id {
        // Without a position from the host it comes from shape, orientation and sheet.
        Id::StatePosition | Id::StepFraction => None,
        Id::StateVelocity => input("projectile.velocity"),
        Id::StateOrientation => input("projectile.orientation"),
        Id::StateAngularVelocity => input("projectile.angular_velocity"),
        _ => some(""),
    };
    ("dependencies", known)
}

/// Index of a variable's first element in FMI 2.0, from 1 on.
fn index_of(variable: &Variable) -> usize {
    1 + table::VARIABLES.iter().take_while(|other| other.id != variable.id).map(Variable::size).sum::<usize>()
}

/// The name of an element in FMI 2.0: `name`, `name[2]` or `name[2,3]`.
fn element_name(variable: &Variable, element: usize) -> String {
    match variable.shape {
        [_] => format!("{}[{}]", variable.name, element + 1),
        [_, columns] => format!("{}[{},{}]", variable.name, element / columns + 1, element % columns + 1),
        _ => variable.name.to_string(),
    }
}

const XML: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";

/// The whole model description of FMI 2.0.
fn fmi2() -> String {
    let mut out = String::from(XML);
    let mut attributes = vec![("fmiVersion", some("2.0"))];
    attributes.extend(head());
    attributes.push(("guid", some(token())));
    out.push_str(&format!("{}>\n", tag(0, "fmiModelDescription", &attributes)));
    let flags = [
        ("modelIdentifier", some(MODEL_IDENTIFIER)),
        ("needsExecutionTool", some(false)),
        ("canHandleVariableCommunicationStepSize", some(true)),
        ("canInterpolateInputs", some(false)),
        ("maxOutputDerivativeOrder", some(0)),
        ("canRunAsynchronuously", some(false)),
        ("canBeInstantiatedOnlyOncePerProcess", some(false)),
        ("canNotUseMemoryManagementFunctions", some(true)),
        ("canGetAndSetFMUstate", some(true)),
        ("canSerializeFMUstate", some(true)),
        ("providesDirectionalDerivative", some(false)),
    ];
    out.push_str(&format!("{}/>\n", tag(1, "CoSimulation", &flags)));
    units(&mut out);
    types(&mut out, true);
    log_and_experiment(&mut out);
    out.push_str("  <ModelVariables>\n");
    let mut outputs = String::new();
    let mut unknowns = String::new();
    let mut index = 0;
    for variable in &table::VARIABLES {
        for element in 0..variable.size() {
            index += 1;
            let attributes = [
                ("name", some(element_name(variable, element))),
                ("valueReference", some(variable.reference as usize + element)),
                ("description", description(variable)),
                ("causality", some(causality(variable))),
                ("variability", some(variability(variable))),
                ("initial", initial(variable)),
            ];
            out.push_str(&format!("{}>\n", tag(2, "ScalarVariable", &attributes)));
            let name = match variable.kind {
                Kind::Real => "Real",
                Kind::Integer => "Integer",
                Kind::Boolean => "Boolean",
                Kind::Choice(_) => "Enumeration",
            };
            let mut attributes = value_attributes(variable);
            attributes.push(("start", starts(variable).get(element).cloned()));
            out.push_str(&format!("{}/>\n    </ScalarVariable>\n", tag(3, name, &attributes)));
            if variable.role.is_output() {
                let direct = [("index", some(index)), ("dependencies", some(""))];
                outputs.push_str(&format!("{}/>\n", tag(3, "Unknown", &direct)));
                let initial = at_start(variable, |known| (index_of(known) + element).to_string());
                unknowns.push_str(&format!("{}/>\n", tag(3, "Unknown", &[("index", some(index)), initial])));
            }
        }
    }
    out.push_str("  </ModelVariables>\n  <ModelStructure>\n    <Outputs>\n");
    out.push_str(&outputs);
    out.push_str("    </Outputs>\n    <InitialUnknowns>\n");
    out.push_str(&unknowns);
    out.push_str("    </InitialUnknowns>\n  </ModelStructure>\n</fmiModelDescription>\n");
    out
}

/// The whole model description of FMI 3.0.
fn fmi3() -> String {
    let mut out = String::from(XML);
    let mut attributes = vec![("fmiVersion", some("3.0"))];
    attributes.extend(head());
    attributes.push(("instantiationToken", some(token())));
    out.push_str(&format!("{}>\n", tag(0, "fmiModelDescription", &attributes)));
    let flags = [
        ("modelIdentifier", some(MODEL_IDENTIFIER)),
        ("needsExecutionTool", some(false)),
        ("canBeInstantiatedOnlyOncePerProcess", some(false)),
        ("canGetAndSetFMUState", some(true)),
        ("canSerializeFMUState", some(true)),
        ("providesDirectionalDerivatives", some(false)),
        ("providesAdjointDerivatives", some(false)),
        ("canHandleVariableCommunicationStepSize", some(true)),
        ("fixedInternalStepSize", some(number(Kind::Real, table::DEFAULT_TIME_STEP))),
        ("maxOutputDerivativeOrder", some(0)),
        ("providesIntermediateUpdate", some(false)),
        ("mightReturnEarlyFromDoStep", some(true)),
        ("hasEventMode", some(true)),
    ];
    out.push_str(&format!("{}/>\n", tag(1, "CoSimulation", &flags)));
    units(&mut out);
    types(&mut out, false);
    log_and_experiment(&mut out);
    out.push_str("  <ModelVariables>\n");
    let time = [
        ("name", some("time")),
        ("valueReference", some(table::TIME_REFERENCE)),
        ("description", some("Simulation time")),
        ("causality", some("independent")),
        ("variability", some("continuous")),
        ("declaredType", some("Time")),
        ("unit", some("s")),
    ];
    out.push_str(&format!("{}/>\n", tag(2, "Float64", &time)));
    let mut outputs = String::new();
    let mut unknowns = String::new();
    for variable in &table::VARIABLES {
        let name = match variable.kind {
            Kind::Real => "Float64",
            Kind::Integer => "Int32",
            Kind::Boolean => "Boolean",
            Kind::Choice(_) => "Enumeration",
        };
        let starts = starts(variable);
        let mut attributes = vec![
            ("name", some(variable.name)),
            ("valueReference", some(variable.reference)),
            ("description", description(variable)),
            ("causality", some(causality(variable))),
            ("variability", some(variability(variable))),
            ("initial", initial(variable)),
        ];
        attributes.extend(value_attributes(variable));
        attributes.push(("start", (!starts.is_empty()).then(|| starts.join(" "))));
        let opening = tag(2, name, &attributes);
        if variable.shape.is_empty() {
            out.push_str(&format!("{opening}/>\n"));
        } else {
            out.push_str(&format!("{opening}>\n"));
            for length in variable.shape {
                out.push_str(&format!("{}/>\n", tag(3, "Dimension", &[("start", some(length))])));
            }
            out.push_str(&format!("    </{name}>\n"));
        }
        if variable.role.is_output() {
            let reference = ("valueReference", some(variable.reference));
            let direct = [reference.clone(), ("dependencies", some(""))];
            outputs.push_str(&format!("{}/>\n", tag(2, "Output", &direct)));
            let initial = at_start(variable, |known| known.reference.to_string());
            unknowns.push_str(&format!("{}/>\n", tag(2, "InitialUnknown", &[reference, initial])));
        }
    }
    out.push_str("  </ModelVariables>\n  <ModelStructure>\n");
    out.push_str(&outputs);
    out.push_str(&unknowns);
    out.push_str("  </ModelStructure>\n</fmiModelDescription>\n");
    out
}

// ---- Table of parameters ----------------------------------------------------------------------------------------------

/// docs/tables/scene.md.
fn parameters() -> String {
    let mut out = String::from(
        "# The parameters of a scene\n\n\
         Written by `cargo xtask fmu` from `kernel/src/fields.rs`.\n\
         The names are those of Rust, of scene files and of the FMUs.\n\
         A vector has the same range and default for each element where one is given.\n\
         The default is that of the 10 in preset; that of the 3 in preset follows after \"3 in:\" where it differs.\n\
         The FMUs start with `time_step.seconds` = 2e-8 and with the projectile 1 mm before the sheet.\n\n\
         | name | type | unit | range | default | FMI reference | meaning |\n|---|---|---|---|---|---|---|\n",
    );
    for field in FIELDS {
        let [ten, three] =
            [Scene::sheet_10in_cylinder(), Scene::sheet_3in_sphere()].map(|mut scene| shown(field, &mut scene));
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
        Place::Flag(_) => "true or false".into(),
        Place::Choice(choice, ..) => choice.name.into(),
    }
}

fn range(field: &Field) -> String {
    let text = |x: f64| if field.is_real() { format!("{x:?}") } else { format!("{x}") };
    match field.range {
        Range::Any => String::new(),
        Range::Positive => "> 0".into(),
        Range::NotNegative => ">= 0".into(),
        Range::Within(least, greatest) if greatest == f64::from(u32::MAX) => format!(">= {}", text(least)),
        Range::Within(least, greatest) => format!("{} to {}", text(least), text(greatest)),
        Range::Above(least, greatest) => format!("> {}, <= {}", text(least), text(greatest)),
        Range::Below(least, greatest) if least.is_finite() => format!(">= {}, < {}", text(least), text(greatest)),
        Range::Below(_, greatest) => format!("< {}", text(greatest)),
        Range::Nodes => format!("2 to {}", field.limits()[1]),
        Range::UnitQuaternion => "unit length, to 1e-3".into(),
    }
}

/// A parameter of a scene, in short.
fn shown(field: &Field, scene: &mut Scene) -> String {
    let values: Vec<_> = (0..field.size()).map(|k| field.value_of(field.word(scene, k))).collect();
    let text = |value: &f64| match field.place {
        Place::Reals(..) if value.abs() >= 1e6 => format!("{value:e}"),
        Place::Reals(..) => format!("{value:?}"),
        Place::Flag(_) => (*value != 0.0).to_string(),
        Place::Choice(choice, ..) => {
            choice.items.get(*value as usize).map_or(String::new(), |(name, _)| format!("`{name}`"))
        }
        Place::Count(_) | Place::Seed(_) => value.to_string(),
    };
    match &values[..] {
        [first, rest @ ..] if rest.iter().all(|value| value == first) => text(first),
        _ => values.iter().map(text).collect::<Vec<_>>().join(", "),
    }
}
