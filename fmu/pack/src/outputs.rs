//! Files made of the kernel's table of outputs: the table of the documents, and the types of the Python
//! package.

use fabric_kernel::outputs::{COUNT, Get, OUTPUTS, Output};
use xtask::tools::{Context as _, Outcome, shell};

/// docs/tables/outputs.md.
pub fn table() -> String {
    let mut out = String::from(
        "# The outputs of a simulation\n\n\
         Written by `cargo xtask fmu` from `kernel/src/sim/outputs.rs`.\n\
         A name is that of a structure of Rust and C (`fk_energy` and so on, `projectile` is `fk_motion`) or a method of Python, and of its field.\n\
         `momentum` and `step` are calls of their own.\n\n\
         | name | shape | unit | name in FMI | FMI reference | meaning |\n|---|---|---|---|---|---|\n",
    );
    for Output { name, fmi: (fmi, reference), quantity, shape, about, .. } in OUTPUTS {
        let shape = shape.iter().map(ToString::to_string).collect::<Vec<_>>().join(" x ");
        let fmi = if *reference > 0 { format!("`{fmi}` | {reference}") } else { " | ".into() };
        out.push_str(&format!("| `{name}` | {shape} | {} | {fmi} | {about} |\n", quantity.unit));
    }
    out
}

const TYPES: &str = "python/fabric_kernel/_kernel.pyi";
/// Between these lines the types stand.
const ENDS: [&str; 2] =
    ["# Made by `cargo xtask fmu` of the kernel's outputs; do not edit.\n", "# End of what is made.\n"];

/// The types of the Python package, with those of the outputs.
pub fn types() -> Outcome<(String, String)> {
    let text = shell().read_file(TYPES)?;
    let parts = text.split_once(ENDS[0]).and_then(|(before, rest)| Some((before, rest.split_once(ENDS[1])?.1)));
    let (before, after) = parts.with_context(|| format!("{TYPES} has no place for the outputs"))?;
    Ok((TYPES.into(), [before, ENDS[0], &classes(), ENDS[1], after].concat()))
}

/// Longest line in Python, as in pyproject.toml.
const LINE: usize = 130;

/// Comment of a class's attribute over as many lines as it takes.
fn wrapped(about: &str) -> String {
    let (mut text, mut length) = (String::new(), 3);
    for word in about.split(' ') {
        let comes = 1 + word.len();
        let separator = if length + comes <= LINE { " " } else { "\n    # " };
        length = if length + comes <= LINE { length + comes } else { 5 + comes };
        text += separator;
        text += word;
    }
    text.trim_start().into()
}

fn classes() -> String {
    let (mut text, mut last) = (String::new(), "");
    let mut rows: Vec<_> = OUTPUTS.iter().filter(|output| !matches!(output.get, Get::Whole(_))).collect();
    rows.sort_by_key(|output| output.parts().0);
    for output in rows {
        let (structure, field) = output.parts();
        if structure != last {
            let (first, rest) = structure.split_at(1);
            text += &format!("class {}{rest}(TypedDict):\n", first.to_uppercase());
        }
        last = structure;
        let kind = match output.shape {
            [3] => "Vector",
            [4] => "Quaternion",
            [4, 3] => "tuple[Vector, Vector, Vector, Vector]",
            _ if *output.quantity == COUNT => "int",
            _ => "float",
        };
        let unit = if output.quantity.unit == "1" { String::new() } else { format!("{}: ", output.quantity.unit) };
        let (declared, about) = (format!("    {field}: {kind}"), format!("# {unit}{}", output.about));
        if declared.len() + about.len() + 2 <= LINE {
            text += &format!("{declared}  {about}\n");
        } else {
            text += &format!("    {}\n{declared}\n", wrapped(&about));
        }
    }
    text.replace("\nclass", "\n\nclass") + "\n"
}
