//! What a build pays for in memory, for docs/tables/size.md.

use fabric::{CacheLine, FEATURES, Layout, Scene, TimeStep};
use fabric_tests::options::{Choice, GROUPS};

/// The cargo features of the kernel, each once.
pub fn names() -> Vec<&'static str> {
    let mut names: Vec<_> = FEATURES.iter().map(|record| record.name).collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// A line for each set of features: its name, the features, bytes a node, and what it is.
pub fn rows() -> String {
    let [nothing, all] = [("nothing", ""), ("all", "default")];
    let each = names().into_iter().chain(["paper", "real"]).map(|name| (name, name));
    let row = |(name, features): (&str, &str)| {
        let memory = bytes_a_node(name).map_or(String::new(), |bytes| bytes.to_string());
        let about: Vec<_> = FEATURES.iter().filter(|record| record.name == name).map(|record| record.about).collect();
        format!("{name}\t{features}\t{memory}\t{}\n", about.join("; "))
    };
    [nothing].into_iter().chain(each).chain([all]).map(row).collect()
}

/// Bytes a node of a sheet of 105 x 105 nodes with the first option of the tests that asks for this feature alone; none if there is
/// none, for what no scene asks for and for sets.
fn bytes_a_node(name: &str) -> Option<usize> {
    let preset = Scene::sheet_3in_sphere();
    // Without drawn yarn, and with a step that is short enough for any.
    let mut plain = Scene { time_step: TimeStep::fraction(0.1), ..preset };
    (plain.yarn.stochastic, plain.track_detachment) = (false, false);
    let with = |choice: &Choice| {
        let mut scene = plain;
        choice.set(&mut scene);
        scene
    };
    let alone = |scene: &Scene| {
        let mut asked = FEATURES.iter().filter(|record| record.asked_by(scene).is_some()).peekable();
        asked.peek().is_some() && asked.all(|record| record.name == name)
    };
    let scene = match name {
        "nothing" => plain,
        "paper" => preset,
        "real" => fabric_scene::parse("preset = \"sheet_3in_sphere\"\n[fabric]\nname = \"kevlar_km2_s706\"").ok()?,
        "detachment" => Scene { track_detachment: true, ..plain },
        _ => GROUPS.iter().copied().flatten().map(with).find(alone)?,
    };
    let layout = Layout::of(&scene).ok()?;
    Some(layout.lines() * size_of::<CacheLine>() / layout.nodes())
}
