//! The page in the archives, documentation/index.html: a picture, how to use the model, and a table of its
//! variables from the tables in code.

use crate::description::{description, starts};
use crate::xml::escaped;
use fabric_fmu::MODEL_IDENTIFIER;
use fabric_fmu::parameters::Parameters;
use fabric_fmu::starts::TIME_STEP;
use fabric_fmu::table::{DEFAULT_STEP_SIZE, DEFAULT_STOP_TIME, Kind, Role, STATUS, VARIABLES, Variable};
use fabric_kernel::fields::Choice;

pub fn page() -> String {
    let text = include_str!("page.html");
    text.replace("{name}", MODEL_IDENTIFIER)
        .replace("{version}", env!("CARGO_PKG_VERSION"))
        .replace("{stop_time}", &format!("{DEFAULT_STOP_TIME:?}"))
        .replace("{step_size}", &format!("{DEFAULT_STEP_SIZE:?}"))
        .replace("{time_step}", &format!("{:?}", TIME_STEP))
        .replace("{status}", &items(&STATUS))
        .replace("{outcomes}", &rows(|variable| variable.name.starts_with("outcome.")))
        .replace("{inputs}", &rows(|variable| variable.role == Role::Input))
        .replace("{outputs}", &rows(|variable| variable.role.is_output() && !variable.name.starts_with("outcome.")))
        .replace("{parameters}", &rows(|variable| matches!(variable.role, Role::Fixed | Role::Tunable)))
}

/// The items of a choice as rows of a table.
fn items(choice: &Choice) -> String {
    let row = |(number, (name, about)): (usize, &(&str, &str))| {
        format!("<tr><td>{number}</td><td>{name}</td><td>{}</td></tr>\n", escaped(about))
    };
    choice.items.iter().enumerate().map(row).collect()
}

/// Variables as rows of a table: name, start, unit, reference, meaning.
fn rows(wanted: impl Fn(&Variable) -> bool) -> String {
    VARIABLES.iter().filter(|variable| wanted(variable)).map(row).collect()
}

fn row(variable: &Variable) -> String {
    let size: Vec<_> = variable.shape.iter().map(ToString::to_string).collect();
    let name = if size.is_empty() { String::new() } else { format!(" [{}]", size.join(" x ")) };
    let starts = starts(&Parameters::default(), variable);
    let start = match &starts[..] {
        [first, rest @ ..] if rest.iter().all(|start| start == first) => first.clone(),
        _ => starts.join(" "),
    };
    let unit = match (variable.kind, variable.quantity) {
        (Kind::Choice(_), _) => "choice",
        (Kind::Boolean, _) => "true, false",
        (_, Some(quantity)) if quantity.unit != "1" => quantity.unit,
        _ => "",
    };
    let about = escaped(&description(variable, true));
    let cells = [
        format!("<code>{}</code>{name}", variable.name),
        start,
        unit.to_string(),
        variable.reference.to_string(),
        about,
    ];
    format!("<tr><td>{}</td></tr>\n", cells.join("</td><td>"))
}
