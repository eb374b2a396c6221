//! Both model descriptions, from the tables in code.

use crate::xml::{Attribute, Xml, some};
use fabric_fmu::MODEL_IDENTIFIER;
use fabric_fmu::parameters::Parameters;
use fabric_fmu::starts::{Starts, TIME_STEP};
use fabric_fmu::table::{self, Kind, MOST_ELEMENTS, Role, Variable};
use fabric_kernel::outputs::Get;

const DESCRIPTION: &str =
    "Ballistic fabric as a network of yarn segments, hit by a rigid projectile that the FMU or its host moves";

/// A number, in the shortest form that reads back as the same; whole for types that are whole.
fn number(kind: Kind, value: f64) -> String {
    match kind {
        Kind::Real => format!("{value:?}"),
        Kind::Boolean => (value != 0.0).to_string(),
        Kind::Integer | Kind::Choice(_) => format!("{}", value as i64),
    }
}

/// Start values of an input or parameter, one text per element; none of an output.
pub fn starts(parameters: &Parameters, variable: &Variable) -> Vec<String> {
    let (mut values, mut starts) = ([0.0; MOST_ELEMENTS], *parameters);
    starts.get(variable, &mut values);
    let size = if variable.role.is_output() { 0 } else { variable.size() };
    values.iter().take(size).map(|&start| number(variable.kind, start)).collect()
}

/// Meaning of a variable. `numbered`: with the numbers of a choice, which FMI 2.0 does not declare here.
pub fn description(variable: &Variable, numbered: bool) -> String {
    let mut text = format!("{}{}", variable.description, variable.note);
    if let (Kind::Choice(choice), true) = (variable.kind, numbered) {
        let items = choice.items.iter().enumerate().map(|(k, (name, about))| format!("{k} {name} ({about})"));
        text.push_str(&format!(": {}", items.collect::<Vec<_>>().join(", ")));
    }
    text
}

/// The attributes that the two versions share, with the names of FMI 2.0.
fn head() -> Vec<Attribute> {
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

fn units(out: &mut Xml) {
    out.element("UnitDefinitions", &[], |out| {
        for unit in table::UNITS {
            let exponent = |power: i32| (power != 0).then(|| power.to_string());
            let [kg, m, s, rad] = unit.exponents.map(exponent);
            out.element("Unit", &[("name", some(unit.name))], |out| {
                out.leaf("BaseUnit", &[("kg", kg), ("m", m), ("s", s), ("rad", rad)]);
                for (name, factor) in unit.display {
                    let factor = some(number(Kind::Real, *factor));
                    out.leaf("DisplayUnit", &[("name", some(name)), ("factor", factor)]);
                }
            });
        }
    });
}

/// The type definitions; FMI 2.0 wraps each in a SimpleType and has none of the choices.
fn types(out: &mut Xml, two: bool) {
    for quantity in table::quantities() {
        let about = [("name", some(quantity.name)), ("description", some(quantity.description))];
        let attributes = [
            ("quantity", some(quantity.name)),
            ("unit", some(quantity.unit)),
            ("displayUnit", (!quantity.display.is_empty()).then(|| quantity.display.to_string())),
            ("min", finite(quantity.least)),
            ("nominal", finite(quantity.nominal)),
        ];
        if two {
            out.element("SimpleType", &about, |out| out.leaf("Real", &attributes));
        } else {
            out.leaf("Float64Type", &[&about, &attributes[..]].concat());
        }
    }
    for choice in table::choices().filter(|_| !two) {
        out.element("EnumerationType", &[("name", some(choice.name))], |out| {
            for (value, (name, about)) in choice.items.iter().enumerate() {
                out.leaf("Item", &[("name", some(name)), ("value", some(value)), ("description", some(about))]);
            }
        });
    }
}

/// Part before the variables: the abilities of the library, which have other names in each version,
/// units, types, log and experiment.
fn before_variables(out: &mut Xml, two: bool, abilities: &[Attribute]) {
    out.leaf("CoSimulation", abilities);
    units(out);
    out.element("TypeDefinitions", &[], |out| types(out, two));
    out.element("LogCategories", &[], |out| {
        for (name, about) in table::LOG_CATEGORIES {
            out.leaf("Category", &[("name", some(name)), ("description", some(about))]);
        }
    });
    let real = |value| some(number(Kind::Real, value));
    let experiment = [
        ("startTime", real(0.0)),
        ("stopTime", real(table::DEFAULT_STOP_TIME)),
        ("stepSize", real(table::DEFAULT_STEP_SIZE)),
    ];
    out.leaf("DefaultExperiment", &experiment);
}

/// Causality, variability, and `initial`, which FMI forbids for inputs.
fn kinds(role: Role) -> [Attribute; 3] {
    let (causality, variability, initial) = match role {
        Role::Input => ("input", "continuous", None),
        Role::Fixed => ("parameter", "fixed", some("exact")),
        Role::Tunable => ("parameter", "tunable", some("exact")),
        Role::Continuous => ("output", "continuous", some("calculated")),
        Role::Discrete => ("output", "discrete", some("calculated")),
    };
    [("causality", some(causality)), ("variability", some(variability)), ("initial", initial)]
}

/// The attributes of any variable. `numbered`: as of [`description`].
fn attributes(variable: &Variable, name: &str, reference: u32, numbered: bool) -> Vec<Attribute> {
    let about = some(description(variable, numbered));
    let named = [("name", some(name)), ("valueReference", some(reference)), ("description", about)];
    named.into_iter().chain(kinds(variable.role)).collect()
}

/// A limit or typical size, if there is one.
fn finite(value: f64) -> Option<String> {
    value.is_finite().then(|| number(Kind::Real, value))
}

/// Declared type, unit (again, for hosts that do not look at types), and range and nominal where they are not
/// the type's.
fn value_attributes(variable: &Variable, two: bool) -> Vec<Attribute> {
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

/// Variables that an output depends on at once, at a communication point.
fn at_once(variable: &Variable, name_of: impl Fn(&Variable) -> String) -> Attribute {
    let of_ply = variable.output().is_some_and(|output| matches!(output.get, Get::Ply(_)));
    let known = if of_ply { table::variable("ply.first") } else { None };
    ("dependencies", some(known.map_or(String::new(), name_of)))
}

/// Variables that an output depends on in initialisation: none (it is zero), the parameter of the same
/// meaning, or, where the attribute is left out, all inputs and parameters. Rounding in the sheet's axes is
/// no dependency.
fn at_start(variable: &Variable, name_of: impl Fn(&Variable) -> String) -> Attribute {
    let known = match (variable.name, variable.name.strip_prefix("state.")) {
        ("step.fraction" | "step.seconds" | "energy.strain" | "ply.strain" | "fabric.max_stretch", _) => None,
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

/// The whole text: the model's own attributes, and what is in it.
fn whole(version: &str, token: &'static str, inside: impl FnOnce(&mut Xml)) -> String {
    let shared = head();
    let id = fabric_fmu::token::text(Starts::own().token);
    let last = (token, some(String::from_utf8_lossy(&id)));
    let mut out = Xml::new();
    out.element("fmiModelDescription", &[&[("fmiVersion", some(version))], &shared[..], &[last]].concat(), inside);
    out.text()
}

/// Every element of every variable as FMI 2.0 counts them, from 1 on.
fn elements() -> impl Iterator<Item = (usize, &'static Variable, usize)> {
    let elements = table::VARIABLES.iter().flat_map(|variable| (0..variable.size()).map(move |k| (variable, k)));
    elements.enumerate().map(|(index, (variable, k))| (index + 1, variable, k))
}

/// The whole model description of FMI 2.0.
pub fn fmi2() -> String {
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
    whole("2.0", "guid", |out| {
        before_variables(out, true, &flags);
        out.element("ModelVariables", &[], |out| {
            elements().for_each(|(_, variable, element)| scalar(out, variable, element));
        });
        out.element("ModelStructure", &[], |out| {
            let outputs = || elements().filter(|(_, variable, _)| variable.role.is_output());
            let unknown = |out: &mut Xml, index: usize, known| out.leaf("Unknown", &[("index", some(index)), known]);
            out.element("Outputs", &[], |out| {
                for (index, variable, _) in outputs() {
                    unknown(out, index, at_once(variable, |known| index_of(known).to_string()));
                }
            });
            out.element("InitialUnknowns", &[], |out| {
                for (index, variable, element) in outputs() {
                    let known = |known: &Variable| {
                        // A quaternion is normalised as a whole.
                        let whole = variable.name == "state.orientation";
                        let elements = if whole { 0..known.size() } else { element..element + 1 };
                        elements.map(|k| (index_of(known) + k).to_string()).collect::<Vec<_>>().join(" ")
                    };
                    unknown(out, index, at_start(variable, known));
                }
            });
        });
    })
}

/// An element of a variable in FMI 2.0.
fn scalar(out: &mut Xml, variable: &Variable, element: usize) {
    let reference = variable.reference + element as u32;
    let attributes = attributes(variable, &element_name(variable, element), reference, true);
    let mut value = value_attributes(variable, true);
    value.push(("start", starts(&Parameters::default(), variable).get(element).cloned()));
    out.element("ScalarVariable", &attributes, |out| out.leaf(kind_in_2(variable.kind), &value));
}

/// Name of a type in FMI 2.0. Not an Enumeration: libcosim and ecos pass over those.
pub fn kind_in_2(kind: Kind) -> &'static str {
    match kind {
        Kind::Real => "Real",
        Kind::Integer | Kind::Choice(_) => "Integer",
        Kind::Boolean => "Boolean",
    }
}

/// The whole model description of FMI 3.0.
pub fn fmi3() -> String {
    let flags = [
        ("modelIdentifier", some(MODEL_IDENTIFIER)),
        ("needsExecutionTool", some(false)),
        ("canBeInstantiatedOnlyOncePerProcess", some(false)),
        ("canGetAndSetFMUState", some(true)),
        ("canSerializeFMUState", some(true)),
        ("providesDirectionalDerivatives", some(false)),
        ("providesAdjointDerivatives", some(false)),
        ("canHandleVariableCommunicationStepSize", some(true)),
        ("fixedInternalStepSize", some(number(Kind::Real, TIME_STEP))),
        ("maxOutputDerivativeOrder", some(0)),
        ("providesIntermediateUpdate", some(false)),
        ("mightReturnEarlyFromDoStep", some(true)),
        ("hasEventMode", some(true)),
    ];
    let time = [
        ("name", some("time")),
        ("valueReference", some(table::TIME_REFERENCE)),
        ("description", some("Simulation time")),
        ("causality", some("independent")),
        ("variability", some("continuous")),
        ("declaredType", some("Time")),
        ("unit", some("s")),
    ];
    whole("3.0", "instantiationToken", |out| {
        before_variables(out, false, &flags);
        out.element("ModelVariables", &[], |out| {
            out.leaf("Float64", &time);
            table::VARIABLES.iter().for_each(|variable| array(out, variable));
        });
        out.element("ModelStructure", &[], |out| {
            let outputs = || table::VARIABLES.iter().filter(|variable| variable.role.is_output());
            let by_reference = |variable: &Variable| variable.reference.to_string();
            for variable in outputs() {
                let reference = ("valueReference", some(variable.reference));
                out.leaf("Output", &[reference, at_once(variable, by_reference)]);
            }
            for variable in outputs() {
                let reference = ("valueReference", some(variable.reference));
                out.leaf("InitialUnknown", &[reference, at_start(variable, by_reference)]);
            }
        });
    })
}

/// A variable in FMI 3.0, of any shape.
fn array(out: &mut Xml, variable: &Variable) {
    let name = match variable.kind {
        Kind::Real => "Float64",
        Kind::Integer => "Int32",
        Kind::Boolean => "Boolean",
        Kind::Choice(_) => "Enumeration",
    };
    let starts = starts(&Parameters::default(), variable);
    let mut attributes = attributes(variable, variable.name, variable.reference, false);
    attributes.extend(value_attributes(variable, false));
    attributes.push(("start", (!starts.is_empty()).then(|| starts.join(" "))));
    if variable.shape.is_empty() {
        return out.leaf(name, &attributes);
    }
    out.element(name, &attributes, |out| {
        variable.shape.iter().for_each(|length| out.leaf("Dimension", &[("start", some(length))]));
    });
}
