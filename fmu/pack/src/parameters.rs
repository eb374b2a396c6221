//! The scene's parameters: parameter sets (SSP 1.0) for the FMU, and their table in the documents.

use crate::description::{self, element_name};
use crate::xml::{Xml, some, tag};
use fabric_fmu::MODEL_IDENTIFIER;
use fabric_fmu::parameters::Parameters;
use fabric_fmu::starts;
use fabric_fmu::table::{Role, VARIABLES};
use fabric_kernel::Scene;
use fabric_kernel::fields::{self, Choice, FIELDS, Field, Place};
use xtask::tools::anyhow;

/// The other presets, a stack, and a real fabric, as parameter sets of SSP 1.0 for the FMU of FMI 2.0: what
/// differs from its start values.
pub fn sets() -> xtask::tools::Outcome<Vec<(String, String)>> {
    let name_of = |name: &str| format!("examples/parameters/{name}.ssv");
    let others = fabric_scene::PRESETS.iter().filter(|(_, make)| make() != Scene::sheet_10in_cylinder());
    let zylon = "preset = \"sheet_10in_cylinder\"\nfabric.name = \"zylon_as_500_35\"";
    let more = [
        ("three_plies", three_plies()),
        ("zylon_as_500_35", fabric_scene::parse(zylon).map_err(|error| anyhow!("{error}"))?),
    ];
    let others = others.map(|(name, make)| (*name, make())).chain(more);
    Ok(others.map(|(name, scene)| (name_of(name), parameter_set(name, scene))).collect())
}

/// The 3 in sheet and its sphere with three separate plies, a quarter of a millimetre apart.
fn three_plies() -> Scene {
    let scene = Scene::sheet_3in_sphere();
    Scene { stack: fabric_kernel::Stack { plies: 3, gap: 2.5e-4, ..scene.stack }, ..scene }
}

fn parameter_set(name: &str, mut scene: Scene) -> String {
    // As the start values: a time step in seconds, and the projectile 1 mm before the sheet.
    scene.time_step.seconds = starts::TIME_STEP;
    scene.projectile.position[2] -= starts::STAND_OFF;
    let [own, other] = [Parameters::default(), Parameters::of(scene)];
    let mut out = Xml::new();
    out.line(&format!(
        "<!-- Written by `cargo xtask fmu`: the scene {name}, as far as it differs from the start values of {MODEL_IDENTIFIER}. -->"
    ));
    let space = ("xmlns:ssv", some("http://ssp-standard.org/SSP1/SystemStructureParameterValues"));
    let attributes = [("version", some("1.0")), ("name", some(name)), space];
    let parameters = |out: &mut Xml| {
        for variable in VARIABLES.iter().filter(|variable| variable.role == Role::Fixed) {
            let [is, wanted] = [&own, &other].map(|parameters| description::starts(parameters, variable));
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

/// docs/tables/scene.md.
pub fn table() -> String {
    let mut out = String::from(
        "# The parameters of a scene\n\n\
         Written by `cargo xtask fmu` from `kernel/src/scene/fields/table.rs`.\n\
         The names are those of Rust, of scene files and of the FMUs, where `projectile.position` and the other three numbers of the \
         motion are `projectile.start.position` and so on.\n\
         Scene files take [units and further keys](../../data/fabrics/README.md#sheet-and-projectile), too.\n\
         A vector has the same range for each element.\n\
         The default is that of the 10 in preset; that of the 3 in preset follows after \"3 in:\" where it differs.\n\
         The FMUs start with `time_step.seconds` = 2e-8 and with the projectile 1 mm before the sheet.\n\n\
         | name | type | unit | range | default | FMI reference | meaning |\n|---|---|---|---|---|---|---|\n",
    );
    for field in FIELDS {
        let named =
            |choice: &Choice, k: u64| format!("`{}`", choice.items.get(k as usize).map_or("", |(name, _)| name));
        let scenes = [Scene::sheet_10in_cylinder(), Scene::sheet_3in_sphere()];
        let [ten, three] = scenes.map(|scene| capi_header::values(field, scene, named));
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
        _ => capi_header::range(field).unwrap_or_default(),
    }
}
