//! include/fabric_kernel.h: functions, and structures but for the scene's, by cbindgen from capi/src and the
//! kernel's read-outs; the scene's structure and the constants of its choices from the kernel's table of
//! parameters, those of the statuses from the list of its codes. With it tests/c/abi/scene.inc: where each
//! number of the scene must be.

use fabric_kernel::MAX_NODES_PER_SIDE;
use fabric_kernel::fields::{CHOICES, Choice, FIELDS, Field, GROUPS, Place, Range, SLOTS, slot_of};
use fabric_kernel::{Code, Scene};
use std::fmt::Write;
use xtask::tools::{Context as _, Outcome, anyhow, emptied, shell, sources, target, top};

/// The header and the scene's layout: path below the top folder, and text.
///
/// # Errors
/// A source that is not there or has not the form that is expected: which, and what is missing.
pub fn files() -> Outcome<Vec<(String, String)>> {
    Ok(vec![("include/fabric_kernel.h".into(), header()?), ("tests/c/abi/scene.inc".into(), layout())])
}

fn header() -> Outcome<String> {
    let source = |name: &str| top().join("capi/src").join(name);
    let read = |name: &str| shell().read_file(source(name));
    let types = read("types.rs")?;
    let shown = emptied(target().join("header"))?.join("shown.rs");
    let calls = with_plain_pointers(&read("calls.rs")?);
    // Rust's notes on the file may stand at the start only.
    let capsules = read("capsule.rs")?;
    let capsules = capsules.split_once("\nuse ").map_or("", |(_, code)| code);
    let calls = calls + "\nuse " + &with_plain_pointers(capsules);
    let read_outs =
        read_outs(&types, "fabric_kernel", "kernel/src")? + &read_outs(&types, "fabric_capsule", "crates/capsule/src")?;
    shell().write_file(&shown, calls + &read_outs)?;
    let mut config = cbindgen::Config::from_file(top().join("capi/cbindgen.toml")).map_err(|error| anyhow!(error))?;
    config.after_includes = Some(format!("\n{}{}{}", statuses()?, choices(), scene().trim_end()));
    let bindings = cbindgen::Builder::new()
        .with_config(config)
        .with_src(source("types.rs"))
        .with_src(source("block.rs"))
        .with_src(shown)
        .generate()?;
    let mut text = Vec::new();
    bindings.write(&mut text);
    let text = String::from_utf8(text)?;
    let (before, end) = text.rsplit_once("#endif").context("the header has no guard")?;
    Ok(format!("{before}{BY_VALUE}\n#endif{end}"))
}

/// End of the header.
const BY_VALUE: &str = "\
// A scene with a preset's values (FK_PRESET_...). If the library does not know the preset, or is older than
// this header and knows only shorter scenes, struct_size is 0: every call then refuses the scene with
// FK_STRUCT_SIZE.
static inline fk_scene fk_scene_preset(uint32_t preset)
{
    fk_scene scene;
    scene.struct_size = 0;
    fk_scene_fill(&scene, sizeof scene, preset);
    return scene;
}

// A scene with the default values, which are those of the 10 in preset.
static inline fk_scene fk_scene_default(void)
{
    return fk_scene_preset(FK_PRESET_SHEET_10IN_CYLINDER);
}
";

/// The functions as C sees them: the types that carry a host's promise are plain pointers to it. cbindgen
/// would make a typedef of each, which C has no use for; so it is shown the pointers themselves.
fn with_plain_pointers(calls: &str) -> String {
    let pointers = [("ToChange", "*mut fk_sim"), ("ToLookAt", "*const fk_sim"), ("Lent", "*mut core::ffi::c_void")];
    let named =
        |text: String, (name, pointer): (&str, &str)| text.replace(&format!(": {name}"), &format!(": {pointer}"));
    let plain = pointers.into_iter().fold(calls.to_string(), named);
    [("Input<", "*const "), ("Output<", "*mut ")].into_iter().fold(plain, |text, (name, pointer)| {
        let mut parts = text.split(name);
        let before = parts.next().unwrap_or_default().to_string();
        parts.fold(before, |done, part| done + pointer + &part.replacen('>', "", 1))
    })
}

/// The structures of a crate that types.rs gives names of C, under these names: cbindgen does not look into
/// other crates.
fn read_outs(types: &str, name: &str, folder: &str) -> Outcome<String> {
    let (_, list) = types
        .split_once(&format!("pub use {name}::{{"))
        .with_context(|| format!("capi/src/types.rs names no structure of {name}"))?;
    let list = list.split('}').next().unwrap_or_default();
    let names: Vec<_> = list.split(',').filter_map(|name| name.trim().split_once(" as ")).collect();
    let sources = sources(&[folder])?;
    let mut text = String::new();
    for (name, _) in &names {
        let start = format!("pub struct {name} {{\n");
        let found = sources.iter().find_map(|(_, source)| {
            let (before, rest) = source.split_once(&start)?;
            let notes = before.lines().rev().take_while(|line| line.starts_with("///") || line.starts_with("#["));
            let notes: Vec<_> = notes.collect();
            let members = rest.split_once("\n}")?.0;
            Some(format!("{}\n{start}{members}\n}}\n", notes.into_iter().rev().collect::<Vec<_>>().join("\n")))
        });
        text += &found.with_context(|| format!("{folder} has no structure {name}"))?;
    }
    let renamed = names.iter().fold(text, |text, (name, c)| {
        text.replace(&format!("pub struct {name} "), &format!("pub struct {c} "))
            .replace(&format!(": {name},"), &format!(": {c},"))
    });
    Ok(renamed)
}

/// "HemisphericalCylinder" as in "FK_HEMISPHERICAL_CYLINDER".
fn constant(name: &str) -> String {
    let mut upper = String::from("FK");
    for letter in name.chars() {
        if letter.is_uppercase() {
            upper.push('_');
        }
        upper.push(letter.to_ascii_uppercase());
    }
    upper
}

/// The constants of the statuses, with the comments of the codes.
fn statuses() -> Outcome<String> {
    let source = shell().read_file("kernel/src/ground/error.rs")?;
    let (_, list) = source.split_once("codes! {\n").context("kernel/src/ground/error.rs has no codes")?;
    let (mut text, mut comment) = (String::new(), Vec::new());
    let mut codes = Code::ALL.iter();
    for line in list.lines().take_while(|line| *line != "}").map(str::trim) {
        if let Some(words) = line.strip_prefix("/// ") {
            comment.push(words);
        } else if let Some(code) = codes.next() {
            text += &commented("", &comment.join(" "));
            let _ = writeln!(text, "#define {} {}\n", constant(&format!("{code:?}")), code.number());
            comment.clear();
        }
    }
    Ok(text)
}

/// FK_ATTACHMENT_TWO_SIDES: the number `k` of a choice.
fn item(choice: &Choice, k: u64) -> String {
    let name = choice.items.get(k as usize).map_or("", |(name, _)| name);
    format!("{}_{}", constant(choice.name), name.to_uppercase())
}

fn choices() -> String {
    let mut text = String::new();
    for choice in CHOICES {
        let of_it = |field: &&Field| matches!(field.place, Place::Choice(one, ..) if one == *choice);
        let field = FIELDS.iter().find(of_it).map_or("", |field| field.name);
        for (k, (_, about)) in choice.items.iter().enumerate() {
            text += &commented("", &format!("{field}: {about}."));
            let _ = writeln!(text, "#define {} {k}\n", item(choice, k as u64));
        }
    }
    text
}

/// A comment of lines up to 120 characters.
fn commented(indent: &str, words: &str) -> String {
    let (mut text, mut line) = (String::new(), format!("{indent}//"));
    for word in words.split_whitespace() {
        if line.len() + 1 + word.len() > 120 {
            text += &line;
            text.push('\n');
            line = format!("{indent}//");
        }
        line.push(' ');
        line += word;
    }
    text + &line + "\n"
}

/// The structures of the scene: one for each group, those within others first, then the whole.
fn scene() -> String {
    let mut groups = GROUPS.to_vec();
    groups.sort_by_key(|(name, _)| std::cmp::Reverse(name.matches('.').count()));
    let mut text = String::new();
    for (group, about) in groups {
        text += &commented("", &format!("{about}: a part of fk_scene."));
        text += &structure(&c_name(group), &format!("{group}."), "");
    }
    let whole = "What is simulated. Fill it with fk_scene_default or fk_scene_preset, then change fields. The first bad field is \
                 named by fk_scene_check and fk_init. The default is what fk_scene_default gives; where the 3 in preset differs \
                 it is said.";
    let size = commented("    ", "Bytes of this structure; set by fk_scene_default and fk_scene_preset.");
    text + &commented("", whole) + &structure("fk_scene", "", &format!("{size}    uint64_t struct_size;\n"))
}

fn c_name(group: &str) -> String {
    format!("fk_scene_{}", group.replace('.', "_"))
}

/// A structure of all parameters whose names start like this. What stands together in a group is one member.
fn structure(name: &str, start: &str, first: &str) -> String {
    let (mut text, mut last) = (format!("typedef struct {name} {{\n{first}"), "");
    for field in FIELDS {
        let Some(member) = field.name.strip_prefix(start) else { continue };
        if let Some((part, _)) = member.split_once('.') {
            if part != last {
                let group = format!("{start}{part}");
                let about = GROUPS.iter().find(|(name, _)| *name == group).map_or("", |(_, about)| about);
                text += &commented("    ", &format!("{about}."));
                let _ = writeln!(text, "    {} {part};", c_name(&group));
            }
            last = part;
            continue;
        }
        let number = if field.is_real() { "double" } else { "uint64_t" };
        let shape: String = field.shape().iter().map(|size| format!("[{size}]")).collect();
        text += &commented("    ", &comment(field));
        let _ = writeln!(text, "    {number} {member}{shape};");
        last = "";
    }
    format!("{text}}} {name};\n\n")
}

/// Meaning, unit, range and default of a parameter.
fn comment(field: &Field) -> String {
    let unit = field.quantity.map(|quantity| quantity.unit).filter(|unit| *unit != "1");
    let unit = unit.map(|unit| format!("In {unit}"));
    let limits = [unit, range(field)];
    let limits: Vec<_> = limits.into_iter().flatten().collect();
    let limits = if limits.is_empty() { String::new() } else { format!(" {}.", limits.join(", ")) };
    let [large, small] =
        [Scene::sheet_10in_cylinder(), Scene::sheet_3in_sphere()].map(|scene| values(field, scene, item));
    let differs = if small == large { String::new() } else { format!(" (3 in preset: {small})") };
    format!("{}.{limits} Default {large}{differs}.", field.about)
}

/// Range of a number, if it may not be any.
pub fn range(field: &Field) -> Option<String> {
    let text = match (field.range, field.place) {
        (_, Place::Flag(_)) => "0 or 1".to_string(),
        (_, Place::Choice(choice, ..)) => {
            let items: Vec<_> = (0..choice.items.len()).map(|k| item(choice, k as u64)).collect();
            let (last, others) = items.split_last()?;
            format!("One of {} and {last}", others.join(", "))
        }
        (Range::Any, _) => return None,
        (Range::Positive, _) => "> 0".to_string(),
        (Range::NotNegative, _) => ">= 0".to_string(),
        (Range::Within(least, greatest), _) => format!("{} to {}", number(least), number(greatest)),
        (Range::Above(least, greatest), _) => format!("> {} and <= {}", number(least), number(greatest)),
        (Range::Below(least, greatest), _) if least.is_infinite() => format!("< {}", number(greatest)),
        (Range::Below(least, greatest), _) => format!(">= {} and < {}", number(least), number(greatest)),
        (Range::Nodes, _) => format!("2 to {MAX_NODES_PER_SIDE}"),
        (Range::UnitQuaternion, _) => "Of unit length to 1e-3".to_string(),
    };
    Some(text)
}

/// Value of a scene's field; `named` gives the items of choices their names.
pub fn values(field: &Field, mut scene: Scene, named: impl Fn(&Choice, u64) -> String) -> String {
    let words: Vec<_> = (0..field.size()).map(|element| field.word(&mut scene, element)).collect();
    let shown = |word: u64| match field.place {
        Place::Choice(choice, ..) => named(choice, word),
        Place::Reals(..) => number(f64::from_bits(word)),
        _ => word.to_string(),
    };
    match words.as_slice() {
        [word] => shown(*word),
        [first, rest @ ..] if rest.iter().all(|word| word == first) => format!("{} each", shown(*first)),
        _ => format!("({})", words.into_iter().map(shown).collect::<Vec<_>>().join(", ")),
    }
}

/// A number as C reads it, short.
fn number(x: f64) -> String {
    let plain = x == 0.0 || (1e-3..1e7).contains(&x.abs()) || x == f64::from(u32::MAX);
    if plain { format!("{x}") } else { format!("{x:e}") }
}

/// Where each number of the scene must be, for tests/c.
fn layout() -> String {
    let mut text = String::from(
        "/* Made by `cargo xtask header`; do not edit. Every number of fk_scene: name, offset and size, bytes; REAL is a double, WHOLE\n \
         * a uint64_t. */\n",
    );
    for (row, field) in FIELDS.iter().enumerate() {
        let kind = if field.is_real() { "REAL" } else { "WHOLE" };
        let _ = writeln!(text, "{kind}({}, {}, {})", field.name, 8 * (1 + slot_of(row)), 8 * field.size());
    }
    let _ = writeln!(text, "SIZE(fk_scene, {})", 8 * (1 + SLOTS));
    text
}
