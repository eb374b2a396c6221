//! Both model descriptions, from the tables in code.

use crate::model::Model;
use fabric::outputs::Get;
use fabric_fmu::table::{self, Kind, MOST_ELEMENTS, Role, Variable};

const DESCRIPTION: &str =
    "Ballistic fabric as a network of yarn segments, hit by a rigid projectile that the FMU or its host moves";

/// Text of an attribute or of a page.
pub fn escaped(text: &str) -> String {
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

fn token(model: &Model) -> String {
    String::from_utf8_lossy(&fabric_fmu::token::text(&model.name, model.starts)).into_owned()
}

/// Start values of an input or parameter, one text per element; none of an output.
pub fn starts(model: &Model, variable: &Variable) -> Vec<String> {
    let (mut values, mut starts) = ([0.0; MOST_ELEMENTS], model.starts);
    starts.get(variable, &mut values);
    let size = if variable.role.is_output() { 0 } else { variable.size() };
    values.iter().take(size).map(|&start| number(variable.kind, start)).collect()
}

/// What a variable is. `numbered`: with the numbers of a choice, which FMI 2.0 does not declare here.
pub fn description(variable: &Variable, numbered: bool) -> String {
    let mut text = format!("{}{}", variable.description, variable.note);
    if let (Kind::Choice(choice), true) = (variable.kind, numbered) {
        let items = choice.items.iter().enumerate().map(|(k, (name, about))| format!("{k} {name} ({about})"));
        text.push_str(&format!(": {}", items.collect::<Vec<_>>().join(", ")));
    }
    text
}

/// The attributes that the two versions share, with the names of FMI 2.0.
fn head(model: &Model) -> Vec<(&'static str, Option<String>)> {
    vec![
        ("modelName", some(&model.name)),
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

/// The type definitions; FMI 2.0 wraps each in a SimpleType and has none of the choices.
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
    for choice in table::choices().filter(|_| !two) {
        out.push_str(&format!("{}>\n", tag(2, "EnumerationType", &[("name", some(choice.name))])));
        for (value, (name, about)) in choice.items.iter().enumerate() {
            let attributes = [("name", some(name)), ("value", some(value)), ("description", some(about))];
            out.push_str(&format!("{}/>\n", tag(3, "Item", &attributes)));
        }
        out.push_str("    </EnumerationType>\n");
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
fn value_attributes(variable: &Variable, two: bool) -> Vec<(&'static str, Option<String>)> {
    let limits = variable.limits();
    let least = variable.quantity.map_or(f64::NEG_INFINITY, |quantity| quantity.least);
    let choice = matches!(variable.kind, Kind::Choice(_));
    let number_of_choice = choice && two;
    let limited = matches!(variable.kind, Kind::Real | Kind::Integer) && !variable.role.is_output() || number_of_choice;
    let limit = |k: usize| {
        let own = limited && limits[k].is_finite() && limits[k] != least;
        own.then(|| number(variable.kind, limits[k]))
    };
    let declared = match (variable.kind, variable.quantity) {
        (Kind::Choice(choice), _) if !two => some(choice.name),
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

/// What an output depends on at once, at a communication point.
fn at_once(variable: &Variable, name_of: impl Fn(&Variable) -> String) -> (&'static str, Option<String>) {
    let of_ply = variable.output().is_some_and(|output| matches!(output.get, Get::Ply(_)));
    let known = if of_ply { table::variable("ply.first") } else { None };
    ("dependencies", some(known.map_or(String::new(), name_of)))
}

/// What an output depends on in initialisation: nothing (it is zero), the parameter of the same meaning, or, where the attribute is
/// left out, all inputs and parameters. Rounding in the sheet's axes is no dependency.
fn at_start(variable: &Variable, name_of: impl Fn(&Variable) -> String) -> (&'static str, Option<String>) {
    let known = match (variable.name, variable.name.strip_prefix("state.")) {
        ("step.fraction" | "energy.strain" | "ply.strain" | "fabric.max_stretch", _) => None,
        (_, Some(motion)) => table::variable(&format!("projectile.start.{motion}")).map(name_of),
        _ => some(""),
    };
    ("dependencies", known)
}

/// Index of a variable's first element in FMI 2.0, from 1 on.
fn index_of(variable: &Variable) -> usize {
    1 + table::VARIABLES.iter().take_while(|other| other.id != variable.id).map(Variable::size).sum::<usize>()
}

/// The name of an element in FMI 2.0: `name`, `name[2]` or `name[2,3]`.
pub fn element_name(variable: &Variable, element: usize) -> String {
    match variable.shape {
        [_] => format!("{}[{}]", variable.name, element + 1),
        [_, columns] => format!("{}[{},{}]", variable.name, element / columns + 1, element % columns + 1),
        _ => variable.name.to_string(),
    }
}

const XML: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";

/// The whole model description of FMI 2.0.
pub fn fmi2(model: &Model) -> String {
    let mut out = String::from(XML);
    let mut attributes = vec![("fmiVersion", some("2.0"))];
    attributes.extend(head(model));
    attributes.push(("guid", some(token(model))));
    out.push_str(&format!("{}>\n", tag(0, "fmiModelDescription", &attributes)));
    let flags = [
        ("modelIdentifier", some(&model.name)),
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
                ("description", some(description(variable, true))),
                ("causality", some(causality(variable))),
                ("variability", some(variability(variable))),
                ("initial", initial(variable)),
            ];
            out.push_str(&format!("{}>\n", tag(2, "ScalarVariable", &attributes)));
            let name = match variable.kind {
                Kind::Real => "Real",
                // Not an Enumeration: libcosim and ecos pass over those.
                Kind::Integer | Kind::Choice(_) => "Integer",
                Kind::Boolean => "Boolean",
            };
            let mut attributes = value_attributes(variable, true);
            attributes.push(("start", starts(model, variable).get(element).cloned()));
            out.push_str(&format!("{}/>\n    </ScalarVariable>\n", tag(3, name, &attributes)));
            if variable.role.is_output() {
                let direct = [("index", some(index)), at_once(variable, |known| index_of(known).to_string())];
                outputs.push_str(&format!("{}/>\n", tag(3, "Unknown", &direct)));
                let initial = at_start(variable, |known| {
                    // A quaternion is normalised as a whole.
                    let whole = variable.name == "state.orientation";
                    let elements = if whole { 0..known.size() } else { element..element + 1 };
                    elements.map(|k| (index_of(known) + k).to_string()).collect::<Vec<_>>().join(" ")
                });
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
pub fn fmi3(model: &Model) -> String {
    let mut out = String::from(XML);
    let mut attributes = vec![("fmiVersion", some("3.0"))];
    attributes.extend(head(model));
    attributes.push(("instantiationToken", some(token(model))));
    out.push_str(&format!("{}>\n", tag(0, "fmiModelDescription", &attributes)));
    let flags = [
        ("modelIdentifier", some(&model.name)),
        ("needsExecutionTool", some(false)),
        ("canBeInstantiatedOnlyOncePerProcess", some(false)),
        ("canGetAndSetFMUState", some(true)),
        ("canSerializeFMUState", some(true)),
        ("providesDirectionalDerivatives", some(false)),
        ("providesAdjointDerivatives", some(false)),
        ("canHandleVariableCommunicationStepSize", some(true)),
        ("fixedInternalStepSize", some(number(Kind::Real, model.time_step))),
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
        let starts = starts(model, variable);
        let mut attributes = vec![
            ("name", some(variable.name)),
            ("valueReference", some(variable.reference)),
            ("description", some(description(variable, false))),
            ("causality", some(causality(variable))),
            ("variability", some(variability(variable))),
            ("initial", initial(variable)),
        ];
        attributes.extend(value_attributes(variable, false));
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
            let direct = [reference.clone(), at_once(variable, |known| known.reference.to_string())];
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
