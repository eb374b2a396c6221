//! Files stand in floors: among the modules of a crate no import leads back to where it came from. In the
//! kernel each file stands in a room, which is a folder of `kernel/src`, each room on a floor, and an import
//! leads into the same room or to a floor below.
//!
//! Method: an import is a path `crate::a::b` or `super::a` in the code of a file, unit tests and comments
//! aside; it leads to the file of that module, the deepest that there is. A name that the root of the crate
//! hands on leads to the file that it comes from, and a call of a method that another file than its type's
//! gives to the type (`impl Scene` in `grading.rs`) leads to that file.

use crate::{files, top};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

const CRATES: [&str; 10] = [
    "capi",
    "fmu",
    "tests/fuzz",
    "crates/host",
    "kernel",
    "crates/scene",
    "evidence/bench",
    "tests",
    "xtask",
    "capi/library",
];

/// Modules of a crate by name, `a::b`, and the modules that each imports.
type Imports = BTreeMap<String, BTreeSet<String>>;

/// The code of a crate: by module, and what leads to a module without its name.
struct Crate {
    code: BTreeMap<String, String>,
    /// Names that the root hands on, and where each comes from.
    handed_on: BTreeMap<String, String>,
    /// Calls of methods, `.name(`, and the file that gives the method to a type of another file.
    lent: BTreeMap<String, String>,
}

impl Crate {
    fn read(source: &Path) -> Crate {
        let mut paths = Vec::new();
        files(source, &mut paths);
        let module = |path: &Path| {
            let name = path.strip_prefix(source).unwrap().with_extension("");
            let names: Vec<_> = name.iter().filter(|part| *part != "mod").map(|part| part.to_str().unwrap()).collect();
            names.join("::")
        };
        let text = |path: &Path| code(&fs::read_to_string(path).unwrap());
        Crate::of(paths.iter().map(|path| (module(path), text(path))).collect())
    }

    fn of(code: BTreeMap<String, String>) -> Crate {
        let mut whole = Crate { code, handed_on: BTreeMap::new(), lent: BTreeMap::new() };
        let root = whole.code.get("lib").cloned().unwrap_or_default();
        for path in paths(&root, "pub use ") {
            if let Some(module) = whole.module_of(&path) {
                whole.handed_on.insert(path.split("::").last().unwrap().to_string(), module);
            }
        }
        for (name, text) in &whole.code {
            let blocks = text.split("\nimpl ").skip(1);
            for (kind, block) in blocks.filter_map(|block| block.split_once(" {\n")) {
                let is_here = ["struct", "enum"].iter().any(|word| text.contains(&format!("{word} {kind}")));
                if kind.contains([' ', '<']) || is_here {
                    continue;
                }
                let methods = block.split("\n}").next().unwrap().split("pub fn ").skip(1);
                let calls = methods.filter_map(|method| method.split_once("(&")).map(|(call, _)| format!(".{call}("));
                whole.lent.extend(calls.map(|call| (call, name.clone())));
            }
        }
        whole
    }

    /// The deepest module that a path names.
    fn module_of(&self, path: &str) -> Option<String> {
        let names: Vec<&str> = path.split("::").collect();
        (1..=names.len()).rev().map(|count| names[..count].join("::")).find(|name| self.code.contains_key(name))
    }

    /// The modules that the module `own` imports. The root names its modules and is named by none.
    fn imports(&self, own: &str) -> BTreeSet<String> {
        let text = &self.code[own];
        let room = own.rsplit_once("::").map_or(String::new(), |(room, _)| format!("{room}::"));
        let named = paths(text, "crate::").into_iter();
        let named = named.chain(paths(text, "super::").into_iter().map(|path| format!("{room}{path}")));
        let leads = |path: String| self.module_of(&path).or_else(|| self.handed_on.get(&path).cloned());
        let calls = self.lent.iter().filter(|(call, _)| text.contains(*call)).map(|(_, module)| module.clone());
        named.filter_map(leads).chain(calls).filter(|name| name != own).collect()
    }

    fn all_imports(&self) -> Imports {
        self.code.keys().map(|name| (name.clone(), self.imports(name))).collect()
    }
}

/// The code of a file without comments, and without the unit tests at its end.
fn code(text: &str) -> String {
    let lines = text.lines().map(|line| line.split("//").next().unwrap_or(""));
    lines.take_while(|line| !line.starts_with("mod tests {")).collect::<Vec<_>>().join("\n")
}

/// Paths after a prefix: `crate::a::{b, c::d}` gives `a::b` and `a::c::d`.
fn paths(code: &str, prefix: &str) -> Vec<String> {
    let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut found = Vec::new();
    for (at, _) in code.match_indices(prefix) {
        let path = &code[at + prefix.len()..];
        let end = path.find(|c| !is_name(c) && c != ':').unwrap_or(path.len());
        let group = path[end..].strip_prefix('{').and_then(|rest| rest.split('}').next()).unwrap_or("");
        for last in group.split(',').map(|last| last.split_whitespace().next().unwrap_or("")) {
            let last = if last == "self" { "" } else { last };
            found.push(format!("{}{last}", &path[..end]).trim_end_matches(':').to_string());
        }
    }
    found
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

/// The rooms that `lib.rs` declares and the floor of each: `/// Floor 3: ...` above `mod yarn;`.
fn floors(lib: &str) -> BTreeMap<String, u32> {
    let mut floor = 0;
    let mut rooms = BTreeMap::new();
    for line in lib.lines() {
        if let Some(rest) = line.strip_prefix("/// Floor ") {
            floor = rest.split(':').next().unwrap().parse().unwrap();
        } else if let Some(room) = line.strip_prefix("mod ") {
            rooms.insert(room.trim_end_matches(';').to_string(), floor);
        }
    }
    rooms
}

/// Imports between rooms that do not lead to a floor below.
fn upward(imports: &Imports, floors: &BTreeMap<String, u32>) -> Vec<String> {
    let room = |module: &str| module.split("::").next().unwrap().to_string();
    let arrows = imports.iter().flat_map(|(from, to)| to.iter().map(move |to| (from, to)));
    let goes_up = |(from, to): &(&String, &String)| {
        let (from, to) = (room(from), room(to));
        from != "lib" && from != to && floors.get(&from) <= floors.get(&to)
    };
    arrows.filter(goes_up).map(|(from, to)| format!("{from} -> {to}")).collect()
}

#[test]
fn no_import_leads_back() {
    for name in CRATES {
        let imports = Crate::read(&top().join(name).join("src")).all_imports();
        assert!(!imports.is_empty(), "no sources of {name}");
        if let Some(way) = cycle(&imports) {
            panic!("{name}: these files import each other: {}", way.join(" -> "));
        }
    }
}

#[test]
fn each_file_of_the_kernel_stands_in_a_room_and_imports_from_below() {
    let source = top().join("kernel/src");
    let floors = floors(&fs::read_to_string(source.join("lib.rs")).unwrap());
    let whole = Crate::read(&source);
    let homeless = |name: &&String| *name != "lib" && !floors.contains_key(name.split("::").next().unwrap());
    assert_eq!(whole.code.keys().find(homeless), None, "in none of {floors:?}");
    let imports = whole.all_imports();
    println!("{} rooms, {} imports", floors.len(), imports.values().map(BTreeSet::len).sum::<usize>());
    assert_eq!(upward(&imports, &floors), [""; 0]);
}

#[test]
fn an_import_is_found_and_a_way_up_or_back_is_named() {
    let whole = |files: &[(&str, &str)]| Crate::of(files.iter().map(|(n, t)| (n.to_string(), code(t))).collect());
    let house = |text: &str| {
        let scene = "\nimpl Thing {\n    pub fn lent(&self) {}\n}\n";
        let lib = "pub use b::c::{Thing as Other, Thing};";
        whole(&[("a", text), ("lib", lib), ("b", ""), ("b::c", "pub struct Thing;"), ("b::d", scene), ("b::e", text)])
    };
    for (text, expected) in [
        ("use crate::b::c::Thing;", &["b::c"][..]),
        ("use crate::{\n    lib,\n    b::{Thing, c as d},\n};", &["b", "lib"]),
        ("use crate::b::{Thing, c as d};", &["b", "b::c"]),
        ("use crate::b::c::{self, Thing};", &["b::c"]),
        ("let x = crate::b::f(y); // crate::b::c", &["b"]),
        ("use crate::Thing;", &["b::c"]),
        ("x.lent()", &["b::d"]),
        ("/// [`crate::b`]\nmod tests {\nuse crate::b;", &[]),
    ] {
        assert_eq!(house(text).imports("a"), expected.iter().map(|name| name.to_string()).collect(), "{text}");
    }
    assert_eq!(house("use super::c::Thing;").imports("b::e"), ["b::c".to_string()].into());

    let graph = |ways: &[(&str, &[&str])]| -> Imports {
        ways.iter().map(|(name, to)| (name.to_string(), to.iter().map(|to| to.to_string()).collect())).collect()
    };
    assert_eq!(cycle(&graph(&[("a", &["b", "c"]), ("b", &["c"]), ("c", &[])])), None);
    let way = cycle(&graph(&[("a", &["b"]), ("b", &["c"]), ("c", &["b", "a"])])).unwrap();
    assert_eq!(way, ["b", "c", "b"]);
    let floors = floors("/// Floor 1: low.\nmod low;\n/// Floor 2: high.\nmod high;\n");
    let imports = graph(&[("low::x", &["low::y", "high::z"]), ("high::z", &["low::x"])]);
    assert_eq!(upward(&imports, &floors), ["low::x -> high::z"]);
}
