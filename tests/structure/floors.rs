//! Files stand in floors: among the modules of a crate no import leads back to where it came from.
//!
//! Method: an import is a path `crate::a::b` in the code of a file, unit tests and comments aside; it leads to the file of that module,
//! the deepest that there is. In the kernel, whose simulation is one structure with many functions, a method would hide an import: so
//! the methods of `Sim` and `System` stand in one file each.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

const CRATES: [&str; 10] =
    ["capi", "fmu", "fuzz", "host", "kernel", "scene", "study", "tests", "xtask", "capi/library"];

/// Modules of a crate by name, `a::b`, and the modules that each imports.
type Imports = BTreeMap<String, BTreeSet<String>>;

/// All source files below a folder with their module names.
fn modules(folder: &Path, above: &str, found: &mut BTreeMap<String, PathBuf>) {
    for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let stem = path.file_stem().unwrap().to_str().unwrap().to_string();
        let name = if above.is_empty() { stem.clone() } else { format!("{above}::{stem}") };
        if path.is_dir() {
            modules(&path, &name, found);
        } else if path.extension().is_some_and(|kind| kind == "rs") {
            found.insert(if stem == "mod" { above.to_string() } else { name }, path);
        }
    }
}

/// The code of a file without comments, and without the unit tests at its end.
fn code(text: &str) -> String {
    let lines = text.lines().map(|line| line.split("//").next().unwrap_or(""));
    lines.take_while(|line| !line.starts_with("mod tests {")).collect::<Vec<_>>().join("\n")
}

/// The modules that code imports.
fn imports(code: &str, own: &str, known: &BTreeMap<String, PathBuf>) -> BTreeSet<String> {
    let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut found = BTreeSet::new();
    for (at, _) in code.match_indices("crate::") {
        let path = &code[at + "crate::".len()..];
        let end = path.find(|c| !is_name(c) && c != ':').unwrap_or(path.len());
        // What stands in braces behind the path: `crate::a::{b, c::d}`.
        let group = path[end..].strip_prefix('{').and_then(|rest| rest.split('}').next()).unwrap_or("");
        for last in group.split(',') {
            let whole = format!("{}{}", &path[..end], last.trim());
            let names: Vec<&str> = whole.split([':', ' ']).filter(|name| !name.is_empty()).collect();
            let mut modules = (1..=names.len()).rev().map(|count| names[..count].join("::"));
            found.extend(modules.find(|name| known.contains_key(name)).filter(|name| name != own));
        }
    }
    found
}

fn of_crate(source: &Path) -> Imports {
    let mut known = BTreeMap::new();
    modules(source, "", &mut known);
    // The root names its modules and is named by none.
    let read = |name: &String, path: &PathBuf| imports(&code(&fs::read_to_string(path).unwrap()), name, &known);
    known.iter().map(|(name, path)| (name.clone(), read(name, path))).collect()
}

/// A way from a module back to itself, if there is one: the shortest.
fn cycle(imports: &Imports) -> Option<Vec<String>> {
    let back = |start: &String| {
        let mut ways = vec![vec![start.clone()]];
        let mut seen = BTreeSet::new();
        while let Some(way) = (!ways.is_empty()).then(|| ways.remove(0)) {
            for next in imports.get(way.last()?).into_iter().flatten() {
                let way = [&way[..], std::slice::from_ref(next)].concat();
                if next == start {
                    return Some(way);
                }
                if seen.insert(next.clone()) {
                    ways.push(way);
                }
            }
        }
        None
    };
    imports.keys().filter_map(back).min_by_key(Vec::len)
}

#[test]
fn no_import_leads_back() {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    for name in CRATES {
        let imports = of_crate(&top.join(name).join("src"));
        assert!(!imports.is_empty(), "no sources of {name}");
        if let Some(way) = cycle(&imports) {
            panic!("{name}: these files import each other: {}", way.join(" -> "));
        }
    }
}

#[test]
fn the_methods_of_a_simulation_stand_in_one_file() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().join("kernel/src");
    let mut known = BTreeMap::new();
    modules(&source, "", &mut known);
    for (name, path) in &known {
        let text = fs::read_to_string(path).unwrap();
        for (kind, home) in [("Sim", "sim"), ("System", "system")] {
            let has = text.lines().any(|line| line.starts_with("impl") && line.contains(&format!(" {kind}<")));
            assert!(!has || name == home, "methods of {kind} in {name}.rs");
            assert!(has || name != home, "no methods of {kind} in {name}.rs");
        }
    }
    let above: Vec<_> = of_crate(&source).into_iter().filter(|(_, imports)| imports.contains("sim")).collect();
    assert!(above.iter().all(|(name, _)| name == "lib"), "{above:?}");
}

#[test]
fn a_cycle_is_found_and_named() {
    let known: BTreeMap<_, _> = ["a", "b", "b::c"].map(|name| (name.to_string(), PathBuf::new())).into();
    let none = BTreeSet::new();
    for (text, expected) in [
        ("use crate::b::c::Thing;", BTreeSet::from(["b::c".to_string()])),
        ("use crate::{\n    a,\n    b::{Thing, c as d},\n};", ["b".to_string()].into()),
        ("use crate::b::{Thing, c as d};", ["b".to_string(), "b::c".to_string()].into()),
        ("let x = crate::b::f(y); // crate::b::c", ["b".to_string()].into()),
        ("use crate::a;\n/// [`crate::b`]\nmod tests {\nuse crate::b;", none),
    ] {
        assert_eq!(imports(&code(text), "a", &known), expected, "{text}");
    }
    let graph = |ways: &[(&str, &[&str])]| -> Imports {
        ways.iter().map(|(name, to)| (name.to_string(), to.iter().map(|to| to.to_string()).collect())).collect()
    };
    assert_eq!(cycle(&graph(&[("a", &["b", "c"]), ("b", &["c"]), ("c", &[])])), None);
    let way = cycle(&graph(&[("a", &["b"]), ("b", &["c"]), ("c", &["b", "a"])])).unwrap();
    assert_eq!(way, ["b", "c", "b"]);
}
