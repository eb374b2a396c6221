//! Scenes as TOML, and memory for their simulations. A scene file has a preset, and whatever differs from it;
//! with a fabric, a projectile and an aim the preset may be left out and is that of the 3 in sheet. Keys are
//! the names of the table of parameters ([`fabric_kernel::fields`]), which are the paths in
//! [`fabric_kernel::Scene`]; an unknown key is an error.
//!
//! ```toml
//! preset = "sheet_3in_sphere"          # or "sheet_10in_cylinder", "turbine_disc_sector", "ring_40in"
//! time_step = { fraction = 0.4 }       # of dt_crit; or { seconds = 2e-8 }
//! integrator = { kind = "theta", tolerance = 1e-8 }
//! fabric = "kevlar_km2_s706"           # or a table: `textile.rs`; before all other keys, which override it
//! back_fabric = "zylon_as_500_35"      # likewise, of the last `back.plies` plies, in the grid of the sheet
//!
//! [attachment]
//! kind = "four_corners"
//!
//! [projectile]
//! mass = "16 g"                        # `units.rs`; without a unit a number is in SI units
//! velocity = [0.0, 0.0, 154.3]
//! ```
//!
//! Keys from which parameters follow, as `sheet.width`: `derived.rs`.
//!
//! `sheet.grading = "automatic"` chooses a graded network for an error of 1 %, once all other keys are read.
//!
//! All keys with units, ranges and defaults: docs/tables/scene.md, or `fabric scene PRESET`, which writes
//! such a file.
//!
//! A key that the scene does not read (`weibull_shape` without drawn strength) is refused if it changes the
//! number, and so is one of the sheet that `[fabric]` determines. The table `[unread]` keeps such numbers,
//! with their whole names.
//!
//! `projectile.faces.planes` are rows `[n_x, n_y, n_z, b]`; their number is the count if none is given.

mod density;
pub mod derived;
pub mod memory;
pub mod notes;
mod polyhedron;
pub mod replay;
pub mod textile;
pub mod units;

use fabric_kernel::fields::{self, FIELDS, Field, Place};
use fabric_kernel::{AttachmentKind, Feature, Scene};
use std::io::Read;
use std::path::Path;
use toml::{Table, Value};

/// What cannot be read says why: a [`BadKey`], a [`fabric_kernel::Error`] that names the field, or a text.
pub type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Largest scene file, bytes; one with every key has some twenty thousand.
pub const LARGEST_FILE: u64 = 1 << 20;

/// The table of numbers that are kept although the scene does not read them.
pub const UNREAD: &str = "unread";

/// Error that `grading = "automatic"` asks for.
pub const AUTOMATIC_GRADING: f64 = 0.01;

/// A key that there is not, or a value that is not of its key's type.
#[derive(Debug)]
pub struct BadKey {
    /// The key.
    pub key: String,
    /// What is wrong, with the key.
    pub text: String,
}

impl std::fmt::Display for BadKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.text)
    }
}

impl std::error::Error for BadKey {}

/// A refusal that names its key.
fn bad<T>(key: &str, text: String) -> Result<T> {
    Err(Box::new(BadKey { key: key.to_string(), text }))
}

/// A preset by name.
pub type Preset = (&'static str, fn() -> Scene);
/// The presets.
pub const PRESETS: [Preset; 4] = [
    ("sheet_3in_sphere", Scene::sheet_3in_sphere),
    ("sheet_10in_cylinder", Scene::sheet_10in_cylinder),
    ("turbine_disc_sector", Scene::turbine_disc_sector),
    ("ring_40in", Scene::ring_40in),
];

/// Reads a scene. The kernel's own checks come later, when a simulation is made of it.
pub fn read(path: &Path) -> Result<Scene> {
    let text = text_of(path).map_err(|error| format!("{}: {error}", path.display()))?;
    parse(&text).map_err(|error| format!("{}: {error}", path.display()).into())
}

/// The text of a scene file, or of a preset by its name.
///
/// # Errors
/// A file that cannot be read, or is larger than [`LARGEST_FILE`].
pub fn text_of(path: &Path) -> std::io::Result<String> {
    let mut text = String::new();
    let file = match std::fs::File::open(path) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            let Some((name, _)) = PRESETS.iter().find(|(name, _)| path.as_os_str() == *name) else {
                let text = format!("No such file, and no preset: these are {}", preset_names());
                return Err(std::io::Error::new(error.kind(), text));
            };
            return Ok(format!("preset = \"{name}\"\n"));
        }
        file => file?,
    };
    file.take(LARGEST_FILE + 1).read_to_string(&mut text)?;
    if text.len() as u64 > LARGEST_FILE {
        let error = format!("larger than any scene file: more than {LARGEST_FILE} bytes");
        return Err(std::io::Error::new(std::io::ErrorKind::FileTooLarge, error));
    }
    Ok(text)
}

/// The scene that a text describes.
pub fn parse(text: &str) -> Result<Scene> {
    let mut file = table_of(text)?;
    let complete = ["fabric", "projectile", "aim"].iter().all(|key| file.contains_key(*key));
    let name = file.remove("preset").or_else(|| complete.then(|| PRESETS[0].0.into()));
    if name.is_none() {
        refuse_misspelt(&file)?;
    }
    let mut scene = preset(name)?;
    apply(&mut scene, file)?;
    derived::refuse_what_cannot_be_meant(&scene)?;
    Ok(scene)
}

/// A text as TOML.
pub fn table_of(text: &str) -> Result<Table> {
    text.parse().map_err(|error: toml::de::Error| {
        let before = text.get(..error.span().map_or(0, |span| span.start)).unwrap_or("");
        let (number, start) = (before.matches('\n').count(), before.rfind('\n').map_or(0, |end| end + 1));
        let line = text.get(start..).and_then(|rest| rest.lines().next()).unwrap_or("");
        let bare =
            line.split_once('=').is_some_and(|(_, value)| value.trim_start().starts_with(|c: char| c.is_ascii_digit()));
        let quotes =
            if bare { "; a number with its unit stands in quotes, with a decimal point: \"5.4 mm\"" } else { "" };
        format!("line {}: {}: {}{quotes}", number + 1, short(line), short(error.message())).into()
    })
}

/// What a message repeats of a text that it was given: at most 80 characters of it, on one line.
pub fn short(text: &str) -> String {
    let (end, rest) = text.char_indices().nth(80).map_or((text.len(), ""), |(end, _)| (end, "..."));
    text[..end].replace(char::is_control, " ") + rest
}

/// Gives a scene what a table of keys says, `[fabric]` first.
pub fn apply(scene: &mut Scene, mut table: Table) -> Result<()> {
    let (kept, fabric, start) = (table.remove(UNREAD), table.remove("fabric"), *scene);
    if let Some(textile) = &fabric {
        textile::apply(scene, textile)?;
    }
    if let Some(Value::Table(kept)) = &kept {
        kept.iter().try_for_each(|(key, value)| assign(scene, key, value).map(|_| ()))?;
    } else if kept.is_some() {
        return bad(UNREAD, format!("`{UNREAD}` is a table, [{UNREAD}]"));
    }
    let (automatic, back) = (takes_automatic_grading(&mut table), table.remove("back_fabric"));
    let (mut given, mut wrong) = (Vec::new(), Vec::new());
    flat("", Value::Table(table), &mut given, &mut wrong);
    for (key, _) in given.iter_mut().filter(|(key, value)| key == "projectile.shape" && value.as_str() == Some("fsp")) {
        *key = derived::FSP.to_string();
    }
    let counted = |key: &str, given: &[(String, Value)]| given.iter().any(|(name, _)| name == key);
    let before = *scene;
    let mut nodes = ["sheet.nodes_x", "sheet.nodes_y"].map(|key| counted(key, &given));
    // The nodes of a ring follow from what is said of it.
    nodes[0] |= fabric.is_none() && !given.iter().any(|(key, _)| key.starts_with("sheet."));
    wrong.extend(derived::conflicts(&given).map(Into::into));
    let (own, mut given): (Vec<_>, Vec<_>) =
        given.into_iter().partition(|(key, _)| derived::KEYS.iter().any(|(known, ..)| key == known));
    let hold = given.iter().position(|(key, _)| key == "attachment.hold").map(|place| given.remove(place));
    match derived::radius(&own) {
        Ok(radius) => given.extend(radius.map(|radius| ("projectile.radius".to_string(), radius.into()))),
        Err(error) => wrong.push(error),
    }
    // The back fabric lies in the grid of the sheet; all other keys override it.
    let (sheet, others): (Vec<_>, Vec<_>) = given.iter().partition(|(key, _)| key.starts_with("sheet."));
    let mut changed: Vec<&Field> = Vec::new();
    for (key, value) in sheet {
        assign(scene, key, value).map_or_else(|error| wrong.push(error), |field| changed.extend(field));
    }
    if fabric.is_some() {
        wrong.extend(changed.iter().filter_map(|field| textile::determined(field.name)).map(Into::into));
    }
    let radius = scene.sheet.radius;
    wrong.extend(derived::sheet(&own, scene, nodes).err());
    if let (Some(textile), true) = (&back, wrong.is_empty()) {
        textile::apply_back(scene, textile)?;
    }
    for (key, value) in others {
        assign(scene, key, value).map_or_else(|error| wrong.push(error), |field| changed.extend(field));
    }
    if let Some((key, value)) = &hold {
        match derived::hold(value, &own, scene) {
            Ok(Some(force)) => scene.attachment.hold = force,
            Ok(None) => wrong.extend(assign(scene, key, value).err()),
            Err(error) => wrong.push(error),
        }
    }
    scene.attachment.hold *= derived::yarns_per_bar(&own);
    if !counted("attachment.kind", &given) {
        scene.attachment.kind = usual_attachment(scene.sheet.closed, &before);
    }
    // Surfaces, if nothing is said: loose plies that are thick absorb too little (notes::loose_and_thick).
    let fabric_says = matches!(&fabric, Some(Value::Table(own)) if own.contains_key(textile::THICKNESS));
    if scene.stack.plies > 1 && fabric.is_some() && !fabric_says && !counted("sheet.thickness", &given) {
        scene.sheet.thickness = 0.0;
    }
    let bears = |thickness: f64| (scene.casing.radius + 0.5 * thickness - radius).abs() <= 1e-12 * radius;
    if scene.casing.radius > 0.0 && (bears(0.0) || bears(start.thickness())) {
        // A case that bears a ring is as wide as that which its nodes close, to its inner face.
        scene.casing.radius = scene.sheet.radius - 0.5 * scene.thickness();
    }
    if fabric.is_some() && Feature::Curved.is_in(scene) && !counted("yarn.viscosity_bending", &given) {
        // What is asked for by name is refused by name.
        scene.yarn.viscosity_bending = 0.0;
    }
    if let Some((_, Value::Array(planes))) = given.iter().find(|(name, _)| name == "projectile.faces.planes")
        && !counted("projectile.faces.count", &given)
    {
        scene.projectile.faces.count = planes.len() as u32;
    }
    let placed = counted("projectile.position", &given) || own.iter().any(|(key, _)| key.starts_with("aim."));
    if scene.thickness() != start.thickness() && !placed {
        derived::keep_distance(scene, &start);
    }
    wrong.extend(derived::projectile(&own, scene, counted("projectile.mass", &given)).err());
    // The preset has numbers of other shapes, too, which nobody chose.
    for Field { name, .. } in
        FIELDS.iter().filter(|field| is_needed(field, scene, &before) && !counted(field.name, &given))
    {
        wrong.push(
            BadKey {
                key: name.to_string(),
                text: format!("{name}: missing: give it, as this shape has it and the preset's has not"),
            }
            .into(),
        );
    }
    all_of(wrong)?;
    let numbers = given.iter().any(|(key, _)| key.starts_with("back.") && key != "back.plies");
    if back.is_some() && scene.back.plies == 0 {
        return bad("back_fabric", "back_fabric: no ply is of this fabric: set back.plies".into());
    }
    if scene.back.plies > 0 && fabric.is_some() && back.is_none() && !numbers {
        return bad(
            "back.plies",
            "back.plies: the fabric of these plies is missing: give the table [back_fabric]".into(),
        );
    }
    let unread = changed.into_iter().filter(|field| !is_read(field, scene)).map(|field| {
        let read = if field.name.starts_with("back.") { "; read if back.plies is not 0" } else { "" };
        let text = format!("{}: this scene does not read it ({}{read}): leave it out", field.name, field.about);
        BadKey { key: field.name.to_string(), text }.into()
    });
    all_of(unread.collect())?;
    if automatic {
        scene.set_grading(AUTOMATIC_GRADING)?;
    }
    Ok(())
}

/// Everything that is wrong as one refusal, a line for each, by the key of the first.
fn all_of(mut wrong: Vec<Box<dyn std::error::Error>>) -> Result<()> {
    const SHOWN: usize = 8;
    if wrong.len() < 2 {
        return wrong.pop().map_or(Ok(()), Err);
    }
    let key = wrong[0].downcast_ref::<BadKey>().map_or(String::new(), |bad| bad.key.clone());
    let mut lines: Vec<_> = wrong.iter().take(SHOWN).map(|error| error.to_string()).collect();
    if wrong.len() > SHOWN {
        lines.push(format!("and {} more", wrong.len() - SHOWN));
    }
    bad(&key, lines.join("\n"))
}

/// Whether the number of a parameter counts for a scene.
pub fn is_read(field: &Field, scene: &Scene) -> bool {
    match field.name {
        // One ply is the absence of a stack.
        "stack.plies" => true,
        "yarn.modulus_sd" | "yarn.damage_sd" => scene.yarn.stochastic,
        "weft.modulus_sd" | "weft.damage_sd" => scene.yarn.stochastic && scene.weft.modulus_mean != 0.0,
        "back.weibull_gauge_length" => scene.back.plies > 0 && scene.back.weibull_shape != 0.0,
        _ => (field.read)(scene) > 0,
    }
}

/// Whether a parameter is a dimension of the projectile that this scene reads and another does not.
pub fn is_needed(field: &Field, scene: &Scene, other: &Scene) -> bool {
    let dimensions = ["projectile.length", "projectile.size", "projectile.sector."];
    dimensions.iter().any(|name| field.name.starts_with(name)) && is_read(field, scene) && !is_read(field, other)
}

/// Whether a number that differs from the preset's with these textiles is kept under `[unread]`.
pub fn is_kept(field: &Field, scene: &Scene, textiles: &Table) -> bool {
    !is_read(field, scene) || textiles.contains_key("fabric") && textile::determined(field.name).is_some()
}

/// Whether the table of the sheet says `grading = "automatic"`, which may leave a network whole; takes it
/// out.
pub fn takes_automatic_grading(file: &mut Table) -> bool {
    let Some(Value::Table(sheet)) = file.get_mut("sheet") else { return false };
    let automatic = sheet.get("grading").and_then(Value::as_str) == Some("automatic");
    if automatic {
        sheet.remove("grading");
    }
    automatic
}

/// The names of the presets, in words.
pub fn preset_names() -> String {
    PRESETS.map(|(name, _)| format!("\"{name}\"")).join(", ")
}

/// The preset of this name.
pub fn preset(name: Option<Value>) -> Result<Scene> {
    let names = preset_names();
    let Some(name) = name else {
        let text =
            format!("no key `preset`: one of {names}; only a file with fabric, [projectile] and [aim] needs none");
        return bad("preset", text);
    };
    let found = PRESETS.iter().find(|(known, _)| name.as_str() == Some(known));
    found.map_or_else(
        || bad("preset", format!("preset = {}: must be one of {names}", short(&name.to_string()))),
        |(_, make)| Ok(make()),
    )
}

/// A scene as a scene file with every key, with its textiles ([`textile::of`]) and their sources, every key
/// and what it is; under `[unread]` those that it does not read, or that its textile determines, and the
/// preset has otherwise.
pub fn write(name: &str, scene: &Scene, textiles: &Table) -> String {
    let mut copy = *scene;
    let mut base = base(name, scene, textiles);
    let mut differs = |field: &Field| (0..field.size()).any(|k| field.word(&mut base, k) != field.word(&mut copy, k));
    let (read, unread): (Vec<&Field>, Vec<&Field>) =
        FIELDS.iter().partition(|field| !is_kept(field, scene, textiles) || !differs(field));
    let mut text = format!("# Every parameter. Those left out keep the preset's value.\npreset = \"{name}\"\n\n");
    // TOML wants the keys without a table first.
    let (inner, outer): (Vec<&Field>, Vec<&Field>) = read.into_iter().partition(|field| field.name.contains('.'));
    let mut table = "";
    for field in outer.into_iter().chain(inner) {
        let (group, key) = field.name.split_once('.').unwrap_or(("", field.name));
        if group != table {
            text.push_str(&if table.is_empty() { textile::write(textiles) } else { String::new() });
            table = group;
            text.push_str(&format!("\n[{group}]\n"));
        }
        if field.name == "projectile.mass"
            && let Some(material) = derived::written_material(textiles, scene)
        {
            text.push_str(&material);
            continue;
        }
        let unit = if unit_of(field) == "1" { String::new() } else { format!("{}: ", unit_of(field)) };
        text.push_str(&format!("# {unit}{}\n{key} = {}\n", about(field), value(field, &mut copy)));
    }
    if !unread.is_empty() {
        text.push_str(&format!("\n# Kept beside the fabric, or not read in this scene.\n[{UNREAD}]\n"));
    }
    for field in unread {
        text.push_str(&format!("\"{}\" = {}\n", field.name, value(field, &mut copy)));
    }
    text
}

/// What the keys of a scene with these textiles override: a preset with them, in the grid of the scene.
pub fn base(preset: &str, scene: &Scene, textiles: &Table) -> Scene {
    let mut base = self::preset(Some(preset.into())).unwrap_or(*scene);
    // They have been read before.
    let _ = textiles.get("fabric").map(|textile| textile::apply(&mut base, textile));
    if let Some(textile) = textiles.get("back_fabric") {
        let sheet = std::mem::replace(&mut base.sheet, scene.sheet);
        let _ = textile::apply_back(&mut base, textile);
        base.sheet = sheet;
    }
    base.attachment.kind = usual_attachment(scene.sheet.closed, &base);
    base
}

/// Attachment of a file that says nothing of it: a sheet that is closed where the preset's is not is free.
fn usual_attachment(closed: bool, preset: &Scene) -> AttachmentKind {
    if closed && !preset.sheet.closed { AttachmentKind::Free } else { preset.attachment.kind }
}

/// What a parameter is, its names if it is a choice.
fn about(field: &Field) -> String {
    match field.place {
        Place::Choice(..) => format!("{}: {}", field.about, expected(field)),
        _ => field.about.to_string(),
    }
}

/// A parameter's value as TOML has it.
fn value(field: &Field, scene: &mut Scene) -> String {
    let words: Vec<u64> = (0..field.size()).map(|element| field.word(scene, element)).collect();
    let numbers = |words: &[u64]| {
        let texts: Vec<_> = words.iter().map(|word| real(*word)).collect();
        format!("[{}]", texts.join(", "))
    };
    let first = words.first().copied().unwrap_or(0);
    match field.place {
        Place::Reals(_, []) => real(first),
        Place::Reals(_, [_]) => numbers(&words),
        Place::Reals(_, shape) => {
            let rows = scene.projectile.faces.in_use().len();
            let rows: Vec<_> = words.chunks(shape[1]).take(rows).map(numbers).collect();
            format!("[{}]", rows.join(", "))
        }
        Place::Count(_) | Place::Seed(_) => first.to_string(),
        Place::Flag(_) => (first == 1).to_string(),
        Place::Choice(choice, ..) => format!("\"{}\"", choice.items[first as usize].0),
    }
}

/// A real number as TOML has it, from its bits.
fn real(word: u64) -> String {
    // TOML writes what is no number in small letters.
    format!("{:?}", f64::from_bits(word)).to_lowercase()
}

/// The names of all keys: those of parameters, and those from which they follow.
fn names() -> impl Iterator<Item = &'static str> {
    FIELDS.iter().map(|field| field.name).chain(derived::KEYS.iter().map(|(name, ..)| *name))
}

/// Every key below a table with its whole name, tables of tables taken apart.
fn flat(prefix: &str, value: Value, all: &mut derived::Given, wrong: &mut Vec<Box<dyn std::error::Error>>) {
    let inside = |name: &'static str| name.strip_prefix(prefix)?.strip_prefix('.');
    match value {
        Value::Table(table) if prefix.is_empty() || names().any(|name| inside(name).is_some()) => {
            for (key, value) in table {
                let name = if prefix.is_empty() { key } else { format!("{prefix}.{key}") };
                flat(&name, value, all, wrong);
            }
        }
        value => {
            let keys: Vec<_> = names().filter_map(inside).collect();
            if keys.is_empty() {
                return all.push((prefix.to_string(), value));
            }
            let text = format!("`{prefix}` is a table, [{prefix}], with {}", keys.join(", "));
            wrong.push(BadKey { key: prefix.to_string(), text }.into());
        }
    }
}

/// The keys of a table with their whole names, and their values.
pub fn given(table: &Table) -> derived::Given {
    let mut all = Vec::new();
    flat("", Value::Table(table.clone()), &mut all, &mut Vec::new());
    all
}

/// A key without its table.
fn last_of(key: &str) -> &str {
    key.rsplit('.').next().unwrap_or(key)
}

/// Plies of a file, by how they hold together.
const PLIES: &str = "`sheet.plies`, sewn together, or `stack.plies`, loose ones";

/// What people call a parameter or a table otherwise.
const CALLED: [(&str, &str); 9] = [
    ("weight", "projectile.mass"),
    ("caliber", "projectile.diameter"),
    ("caliber", "projectile.calibre"),
    ("fragment", "projectile"),
    ("bullet", "projectile"),
    ("textile", "fabric"),
    ("sheet.size", "sheet.width"),
    ("aim.velocity", "aim.speed"),
    ("aim.position", "aim.point"),
];

/// The keys of a file that are tables, and `preset`.
fn tables() -> impl Iterator<Item = &'static str> {
    ["preset", "fabric", "back_fabric"].into_iter().chain(names().filter_map(|name| Some(name.split_once('.')?.0)))
}

/// What somebody may have meant who wrote a key that there is not.
fn meant(key: &str) -> String {
    let (name, last) = (key.split('[').next().unwrap_or(key), last_of(key));
    if fields::field(name).is_some() {
        return format!("; an element has no key of its own: set the whole of `{name}`");
    }
    let likeness = |name: &str| (1e3 * strsim::normalized_levenshtein(key, name)) as u32;
    let of_last = |name: &str| strsim::normalized_levenshtein(last, last_of(name));
    if key.starts_with("fabric.") || key.starts_with("back_fabric.") {
        return "; a textile is one table with its name or all of its numbers: fabric = { name = ..., modulus = ... }"
            .into();
    }
    if ["ply", "plies", "layer", "layers"].contains(&last) && !key.starts_with("stack.") && !key.starts_with("back.") {
        return format!("; is it {PLIES}?");
    }
    let mut near: Vec<&str> =
        CALLED.iter().filter(|(other, _)| *other == key || *other == last).map(|(_, name)| *name).collect();
    if near.is_empty() {
        near = names().filter(|name| last_of(name) == last).collect();
    }
    if near.is_empty() {
        // `projectile.wight` and `projectile.length` have only the table in common.
        let is_like = |name: &&str| likeness(name) > 600 && of_last(name) >= 0.5;
        near = names().chain(tables()).filter(is_like).max_by_key(|name| likeness(name)).into_iter().collect();
    }
    let table = key.strip_suffix(last).unwrap_or_default();
    let inside = || names().filter(|name| !table.is_empty() && name.starts_with(table));
    if near.is_empty() {
        let by_last = |one: &&str, other: &&str| of_last(one).total_cmp(&of_last(other));
        near = inside().max_by(by_last).filter(|name| of_last(name) >= 0.4).into_iter().collect();
    }
    if near.is_empty() && inside().next().is_none() {
        near = tables().filter(|table| key.starts_with(table)).take(1).collect();
    }
    let near: Vec<String> = near.iter().map(|name| format!("`{name}`")).collect();
    let all: Vec<&str> = inside().filter_map(|name| name.strip_prefix(table)).collect();
    match (near.is_empty(), all.is_empty()) {
        (false, _) => format!("; is it {}?", near.join(" or ")),
        (_, false) => format!("; [{}] has {}", table.trim_end_matches('.'), all.join(", ")),
        _ => "; docs/tables/scene.md and data/fabrics/README.md have all keys".into(),
    }
}

/// Refuses a table that is nearly one, without which a file may need no preset.
fn refuse_misspelt(file: &Table) -> Result<()> {
    let is_known = |key: &str| tables().any(|table| table == key) || fields::field(key).is_some();
    for key in file.keys().filter(|key| !is_known(key)) {
        let meant = meant(key);
        if meant.starts_with("; is it") {
            return bad(key, format!("unknown key `{}`{meant}", short(key)));
        }
    }
    Ok(())
}

/// Gives a parameter a value. Returns it if that is another one than before.
fn assign(scene: &mut Scene, key: &str, value: &Value) -> Result<Option<&'static Field>> {
    let Some(field) = fields::field(key) else {
        let key = &short(key);
        return bad(key, format!("unknown key `{key}`{}", meant(key)));
    };
    let Some(words) = words(field, value) else {
        let instead = match field.name {
            "sheet.nodes_x" | "sheet.nodes_y" => "; a width is given as sheet.width",
            "projectile.velocity" => "; a speed is given as aim.speed",
            "projectile.position" => "; where it hits is given as aim.point",
            _ => "",
        };
        let [least, greatest] = field.limits();
        let meant = match field.place {
            Place::Reals(..) => units::meant(value, unit_of(field), &|x| (least..=greatest).contains(&x)),
            _ => unquoted(field, value),
        } + instead;
        return bad(key, format!("{key} = {}: must be {}{meant}", short(&value.to_string()), expected(field)));
    };
    let mut changed = false;
    for (element, word) in words.into_iter().enumerate() {
        changed |= field.word(scene, element) != word;
        field.set_word(scene, element, word)?;
    }
    Ok(changed.then_some(field))
}

/// What somebody meant who wrote a count or a flag in quotes.
fn unquoted(field: &Field, value: &Value) -> String {
    let text = value.as_str().map_or("", str::trim);
    let bare = format!("x = {}", short(text)).parse::<Table>().ok().and_then(|table| words(field, table.get("x")?));
    let [least, greatest] = field.limits();
    let fits = !text.contains(['#', '\n'])
        && bare.is_some_and(|words| words.iter().all(|&word| (least..=greatest).contains(&(word as f64))));
    if fits { format!("; write {text} without quotes") } else { String::new() }
}

/// The words of a value, if it is of the parameter's type.
fn words(field: &Field, value: &Value) -> Option<Vec<u64>> {
    let whole = |value: &Value| value.as_integer().and_then(|whole| u64::try_from(whole).ok());
    match field.place {
        Place::Reals(_, shape) => {
            let mut numbers = Vec::new();
            // A plane is a direction and a distance.
            let of_plane = |k: usize| if k % 4 == 3 { "m" } else { "1" };
            let si = |k: usize| if field.name.ends_with(".planes") { of_plane(k) } else { unit_of(field) };
            reals(value, shape, &si, &mut numbers)?;
            Some(numbers.into_iter().map(f64::to_bits).collect())
        }
        Place::Count(_) | Place::Seed(_) => Some(vec![whole(value)?]),
        Place::Flag(_) => Some(vec![u64::from(value.as_bool()?)]),
        Place::Choice(choice, ..) => {
            let name = value.as_str()?;
            Some(vec![choice.items.iter().position(|(item, _)| *item == name)? as u64])
        }
    }
}

/// The SI unit of a real parameter.
fn unit_of(field: &Field) -> &'static str {
    field.quantity.map_or("1", |quantity| quantity.unit)
}

/// Numbers of an array of this shape, whose SI units are told by their index. Of rows there may be fewer.
fn reals(value: &Value, shape: &[usize], si: &dyn Fn(usize) -> &'static str, numbers: &mut Vec<f64>) -> Option<()> {
    let Some((size, rest)) = shape.split_first() else {
        numbers.push(units::number(value, si(numbers.len()))?);
        return Some(());
    };
    let elements = value.as_array()?;
    let fits = if rest.is_empty() { elements.len() == *size } else { elements.len() <= *size };
    if !fits {
        return None;
    }
    elements.iter().try_for_each(|element| reals(element, rest, si, numbers))
}

/// What a value must be, in words.
fn expected(field: &Field) -> String {
    match field.place {
        Place::Reals(_, []) => format!("a number{}", units::expected(unit_of(field))),
        Place::Reals(_, [size]) => format!("an array of {size} numbers{}", units::expected(unit_of(field))),
        Place::Reals(_, [rows, columns, ..]) => format!("at most {rows} rows of {columns} numbers"),
        Place::Count(_) | Place::Seed(_) => match field.limits() {
            [least, most] if most < 1e6 => format!("a whole number from {least} to {most}"),
            _ => "a whole number, not below 0".to_string(),
        },
        Place::Flag(_) => "true or false".to_string(),
        Place::Choice(choice, ..) => {
            let own = (field.name == "projectile.shape").then_some("fsp");
            let names = choice.items.iter().map(|(name, _)| *name).chain(own);
            let names: Vec<_> = names.map(|name| format!("\"{name}\"")).collect();
            format!("one of {}", names.join(", "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fabric_kernel::{AttachmentKind, Draw, Integrator, RotationRule, Shape, TimeStep};

    #[test]
    fn a_preset_alone_is_that_preset() {
        assert_eq!(parse("preset = \"sheet_3in_sphere\"").unwrap(), Scene::sheet_3in_sphere());
        assert_eq!(parse("preset = \"sheet_10in_cylinder\"").unwrap(), Scene::sheet_10in_cylinder());
        assert_eq!(parse("preset = \"turbine_disc_sector\"").unwrap(), Scene::turbine_disc_sector());
        assert_eq!(parse("preset = \"ring_40in\"").unwrap(), Scene::ring_40in());
    }

    #[test]
    fn a_key_that_something_reads_or_that_is_kept_is_read_again() {
        for text in [
            "[stack]\nplies = 2\n[back]\nplies = 1\nweibull_shape = 10.0\n[yarn]\nweibull_correlation = 0.5\n",
            "[yarn]\nstrength_draw = \"weibull\"\nweibull_shape = 10.0\n",
            "[stack]\ngap = 0.0\n",
            "[unread]\n\"projectile.length\" = 0.5\n",
        ] {
            let scene = parse(&format!("preset = \"sheet_3in_sphere\"\n{text}")).unwrap();
            assert_eq!(parse(&write("sheet_3in_sphere", &scene, &Table::new())).unwrap(), scene);
        }
    }

    /// A message repeats no more than 200 characters of a long input, and a file that has no end is given up.
    #[test]
    fn messages_are_short_and_files_have_a_limit() {
        let long = "a".repeat(100_000);
        let texts = [
            format!("{long} = 1"),
            format!("seed = \"{long}\""),
            format!("[sheet]\n{long} = 1"),
            format!("[{long}]\nx = 1"),
            format!("[projectile]\nvelocity = [{}]", "1.0, ".repeat(50_000)),
            format!("[fabric]\nname = \"{long}\""),
            format!("[fabric]\n{long} = 1"),
            format!("[fabric]\nwarp.{long} = 1"),
            format!("[fabric]\nmodulus = \"{long}\""),
            format!("seed = {long}"),
            format!("seed = {}", "9".repeat(100_000)),
            format!("seed = 1\nseed = 2 # {long}"),
            format!("unread = \"{long}\""),
            format!("[unread]\n{long} = 1"),
        ];
        for text in texts {
            let message = parse(&format!("preset = \"sheet_3in_sphere\"\n{text}\n")).unwrap_err().to_string();
            let echoed = message.matches(['a', '9']).count() + message.matches("1.0, ").count();
            assert!(echoed < 200 && message.len() < 700, "{message}");
        }
        assert!(parse(&format!("preset = \"{long}\"")).unwrap_err().to_string().len() < 250);
        let endless = read(Path::new("/dev/zero")).unwrap_err().to_string();
        assert_eq!(endless, "/dev/zero: larger than any scene file: more than 1048576 bytes");
    }

    /// 2^31, 2^32 and more are the same mistake.
    #[test]
    fn a_count_beyond_its_bits_has_the_code_of_one_beyond_its_range() {
        for count in [1_u64 << 21, 1 << 31, 1 << 32, i64::MAX as u64] {
            let text = format!("preset = \"sheet_3in_sphere\"\nsheet.nodes_x = {count}\n");
            let error = parse(&text).map_or_else(
                |error| *error.downcast_ref::<fabric_kernel::Error>().expect("of the kernel"),
                |scene| scene.check().unwrap_err(),
            );
            assert_eq!((error.code, error.field), (fabric_kernel::Code::TooManyNodes, "sheet.nodes_x"), "{count}");
            assert_eq!((error.value, error.limit), (count as f64, 1_048_576.0));
        }
    }

    #[test]
    fn viscous_fabrics_are_graded_closer_to_the_hit() {
        let text = "preset = \"sheet_10in_cylinder\"\n[fabric]\nname = \"kevlar_km2_s706\"\n[sheet]\ngrading = \"automatic\"\n";
        let inviscid = "[yarn]\nviscosity_linear = 0.0\nviscosity_quadratic = 0.0\nviscosity_bending = 0.0\n";
        let [viscous, plain] = [parse(text), parse(&format!("{text}{inviscid}"))].map(|scene| scene.unwrap().network());
        assert!(viscous[0] < plain[0], "{viscous:?} {plain:?}");
    }

    #[test]
    fn an_automatic_grading_follows_the_other_keys() {
        let text = "preset = \"sheet_10in_cylinder\"\n[sheet]\ngrading = \"automatic\"\n[projectile]\nposition = [0.01, 0.0, -0.02]\n";
        let mut expected = Scene::sheet_10in_cylinder();
        expected.projectile.position = [0.01, 0.0, -0.02];
        expected.set_grading(0.01).unwrap();
        assert_eq!(parse(text).unwrap(), expected);
        assert_eq!(expected.sheet.grading.centre, [0.01, 0.0]);
        assert!(parse("preset = \"sheet_3in_sphere\"\n[sheet]\ngrading = \"fine\"\n").is_err());
        let given = parse("preset = \"sheet_3in_sphere\"\n[sheet.grading]\nlargest = 4\nhalf_width = [0.02, 0.01]\n");
        assert_eq!(given.unwrap().sheet.grading.half_width, [0.02, 0.01]);
    }

    #[test]
    fn a_file_with_fabric_projectile_and_aim_needs_no_preset() {
        let text = "fabric = \"kevlar_km2_s706\"\nprojectile.mass = \"8 g\"\naim.speed = \"490 fps\"\n";
        assert_eq!(parse(text).unwrap(), parse(&format!("preset = \"sheet_3in_sphere\"\n{text}")).unwrap());
        let said = parse("fabric = \"kevlar_km2_s706\"\n").unwrap_err().to_string();
        assert!(PRESETS.iter().all(|(name, _)| said.contains(name)), "{said}");
        for (right, wrong) in [("aim.", "aiming."), ("projectile.", "projectil."), ("fabric =", "fabrik =")] {
            let said = parse(&text.replace(right, wrong)).unwrap_err().to_string();
            assert!(said.ends_with(&format!("is it `{}`?", right.trim_end_matches([' ', '=', '.']))), "{said}");
        }
        let missing = read(Path::new("no_preset")).unwrap_err().to_string();
        assert!(
            missing.starts_with("no_preset: No such file, and no preset: ") && missing.contains("ring_40in"),
            "{missing}"
        );
        assert_eq!(read(Path::new("ring_40in")).unwrap(), Scene::ring_40in());
    }

    #[test]
    fn given_keys_override_and_the_rest_stays() {
        let text = "preset = \"sheet_3in_sphere\"\nseed = 7\ntime_step = { seconds = 1e-8 }\nattachment = { kind = \"four_corners\" }\n\
                    integrator = { kind = \"theta\", tolerance = 1e-8 }\nrotation_rule = { kind = \"theta\" }\nsymmetry.mirror_x = true\n\
                    yarn.draw = \"yarn\"\n[projectile]\nvelocity = [1.0, 2.0, 3.0]\n";
        let mut expected = Scene::sheet_3in_sphere();
        (expected.seed, expected.yarn.draw, expected.symmetry.mirror_x) = (7, Draw::Yarn, true);
        expected.time_step = TimeStep { seconds: 1e-8, ..expected.time_step };
        expected.attachment.kind = AttachmentKind::FourCorners;
        expected.integrator = Integrator { tolerance: 1e-8, ..Integrator::THETA };
        expected.rotation_rule = RotationRule::theta(0.5);
        expected.projectile.velocity = [1.0, 2.0, 3.0];
        assert_eq!(parse(text).unwrap(), expected);
    }

    /// Each with numbers that are not those of the preset it names.
    #[test]
    fn what_is_written_is_read_as_the_same_scene() {
        for (name, make) in PRESETS {
            let mut scene = make();
            (scene.seed, scene.time_step.seconds, scene.yarn.draw) = (7, 1.23456789e-8, Draw::Yarn);
            scene.attachment.kind = AttachmentKind::Free;
            assert_eq!(parse(&write("sheet_3in_sphere", &scene, &Table::new())).unwrap(), scene, "{name}");
            (scene.projectile.mass, scene.projectile.radius) = (f64::NAN, f64::NEG_INFINITY);
            let unsound = parse(&write("sheet_3in_sphere", &scene, &Table::new())).unwrap().projectile;
            assert!(unsound.mass.is_nan() && unsound.radius == f64::NEG_INFINITY);
        }
    }

    #[test]
    fn a_fabric_comes_before_the_keys_that_override_it() {
        let text = "preset = \"sheet_3in_sphere\"\n[fabric]\nname = \"kevlar_km2_s706\"\n[yarn]\nmodulus_mean = 9e10\n\
                    viscosity_bending = 0.0\n";
        let scene = parse(text).unwrap();
        assert_eq!((scene.yarn.critical_stretch, scene.yarn.modulus_mean), (1.0355, 9e10));
        assert_eq!(scene.viscosity(), [0.06, 1.5, 0.0]);
        assert!((scene.sheet.spacing * 34.0 / 0.0254 - 1.0).abs() < 1e-12);
        scene.step_limits().unwrap();
        let bare = parse("preset = \"sheet_3in_sphere\"\n[fabric]\nname = \"kevlar_49_yarn\"\n").unwrap_err();
        assert!(bare.to_string().contains("fabric.linear_density, count: missing or 0"), "{bare}");
    }

    /// The preset has the numbers of the fabric's file; a ring of a fabric has as many nodes as its radius
    /// takes, and what it refuses is left out, but not where it is asked for.
    #[test]
    fn a_ring_of_a_fabric_closes() {
        let bare = Scene::ring_40in();
        let ring = parse("preset = \"ring_40in\"\nfabric = \"zylon_as_500_35\"\nsheet.yarns_per_bar = 4\n").unwrap();
        let differ = |a: f64, b: f64| (a / b - 1.0).abs() > 1e-12;
        let (own, other) = (ring.sheet, bare.sheet);
        assert!(!differ(own.spacing, other.spacing) && !differ(own.node_mass, other.node_mass));
        assert!(!differ(own.yarn_area, other.yarn_area) && !differ(own.radius, other.radius));
        assert_eq!((own.nodes_x, ring.yarn.modulus_mean), (other.nodes_x, bare.yarn.modulus_mean));
        assert_eq!((ring.viscosity(), ring.casing.radius), (bare.viscosity(), own.radius - 0.5 * ring.thickness()));
        let rim = -Scene::turbine_disc_sector().projectile.position[2];
        assert_eq!(bare.projectile.position, [rim - 0.04, 0.0, bare.sheet.radius - rim - 2e-3]);
        let text = "preset = \"sheet_3in_sphere\"\nfabric = { name = \"kevlar_km2_s706\", warp.crimp = 0.01 }\n\
                    sheet = { radius = \"100 mm\", closed = true }\ncasing.radius = \"100 mm\"\n\
                    aim = { point = [\"50 mm\", 0], speed = 80, stand_off = \"1 mm\" }\n";
        let scene = parse(text).unwrap();
        assert!(scene.slack_balance && scene.viscosity()[2] == 0.0);
        assert_eq!(scene.casing.radius, scene.sheet.radius - 0.5 * scene.thickness());
        assert_eq!(scene.sheet.nodes_x, 841);
        scene.check().unwrap();
        // Free, unless it says how it is held.
        let held = parse(&format!("{text}attachment.kind = \"four_sides\"\n")).unwrap().attachment.kind;
        assert_eq!([scene.attachment.kind, held], [AttachmentKind::Free, AttachmentKind::FourSides]);
        assert!(parse(&format!("{text}yarn.viscosity_bending = 0.06\n")).unwrap().check().is_err());
        // Half a radian along the hoop, from inside and from outside, the sphere 1 mm before the ring.
        let ([x, _, z], [u, _, w], r) = (scene.projectile.position, scene.projectile.velocity, scene.sheet.radius);
        let (away, [sine, cosine]) = (
            fabric_kernel::math::length([x, 0.0, z]),
            [fabric_kernel::math::sin, fabric_kernel::math::cos].map(|f| f(0.05 / r)),
        );
        assert!(
            (away + 6.35e-3 + 1e-3 + 0.5 * scene.thickness() - r).abs() < 1e-5 * r
                && (x * cosine - z * sine).abs() < 1e-6 * r
        );
        assert!((u * x + w * z - 80.0 * away).abs() < 1e-9 * away);
        let outside = parse(&format!("{text}projectile.velocity = [0, 0, -80]\n").replace("speed = 80, ", "")).unwrap();
        let [x, _, z] = outside.projectile.position;
        let away = fabric_kernel::math::length([x, 0.0, z]);
        assert!((away - 6.35e-3 - 1e-3 - 0.5 * scene.thickness() - r).abs() < 1e-5 * r && (x - r * sine).abs() < 1e-12);
    }

    #[test]
    fn the_last_plies_may_be_of_another_fabric() {
        let text = "preset = \"sheet_3in_sphere\"\n[fabric]\nname = \"zylon_as_500_35\"\n[stack]\nplies = 5\n[back]\nplies = 2\n\
                    modulus_mean = 9e10\n[back_fabric]\nname = \"kevlar_km2_s706\"\n";
        let scene = parse(text).unwrap();
        scene.check().unwrap();
        let surface = "preset = \"sheet_3in_sphere\"\n[fabric]\nname = \"zylon_as_500_35\"\nthickness = 0\n";
        let front = parse(surface).unwrap();
        assert_eq!((scene.sheet, scene.yarn.modulus_mean), (front.sheet, front.yarn.modulus_mean));
        assert_eq!((scene.back.plies, scene.back.modulus_mean, scene.front_plies()), (2, 9e10, 3));
        let [h_x, h_y] = scene.spacings();
        assert!((scene.back.node_mass / (h_x * h_y) / 0.180 - 1.0).abs() < 0.01);
    }

    #[test]
    fn shapes_and_their_dimensions() {
        let parsed = |shape: &str| parse(&format!("preset = \"sheet_3in_sphere\"\n[projectile]\n{shape}"));
        let body = |text: &str| parsed(text).unwrap().projectile;
        assert_eq!(body("shape = \"hemispherical_cylinder\"\nlength = 0.02").shape, Shape::HemisphericalCylinder);
        let cuboid = body("shape = \"box\"\nsize = [0.01, 0.02, 0.03]");
        assert_eq!((cuboid.shape, cuboid.size), (Shape::Box, [0.01, 0.02, 0.03]));
        let faces = "faces.planes = [[1.0, 0.0, 0.0, 0.01], [0.0, 1.0, 0.0, \"20 mm\"]]\nmoments = [1.0, 2.0, 3.0]";
        let given = body(&format!("shape = \"polyhedron\"\n{faces}"));
        assert_eq!(given.faces.in_use(), [[1.0, 0.0, 0.0, 0.01], [0.0, 1.0, 0.0, 0.02]]);
        assert_eq!((given.shape, given.moments), (Shape::Polyhedron, [1.0, 2.0, 3.0]));
        let size = "{ inner_radius = 0.01, outer_radius = 0.03, angle = 1.0, thickness = 0.008 }";
        let sector = body(&format!("shape = \"disc_sector\"\nsector = {size}"));
        let expected = fabric_kernel::Sector { inner_radius: 0.01, outer_radius: 0.03, angle: 1.0, thickness: 0.008 };
        assert_eq!((sector.shape, sector.sector), (Shape::DiscSector, expected));
    }

    #[test]
    fn the_example_scenes_are_sound() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/scenes");
        let mut count = 0;
        for entry in std::fs::read_dir(folder).unwrap() {
            let scene = read(&entry.unwrap().path()).unwrap();
            scene.step_limits().unwrap();
            count += 1;
        }
        assert!(count > 0);
    }
}
