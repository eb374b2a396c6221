//! What a host may use of the kernel: its public names, and the public functions of its public types. A
//! change of any is a change of surface.txt.

use crate::{files, top};
use std::collections::BTreeSet;
use std::fs;

/// The names of the `pub use` and `pub const` of lib.rs, with the file that a name comes from.
fn names(library: &str) -> Vec<(String, String)> {
    let public = library.split("\npub mod internals").next().unwrap();
    let mut names = Vec::new();
    for statement in public.split("\npub use ").skip(1).map(|text| text.split(';').next().unwrap()) {
        let (path, last) = match statement.split_once("::{") {
            Some((path, list)) => (path.to_string(), list.trim_end_matches('}').to_string()),
            None => statement.rsplit_once("::").map(|(path, last)| (path.to_string(), last.to_string())).unwrap(),
        };
        for name in last.split(',').map(str::trim).filter(|name| !name.is_empty()) {
            let whole = if name == "self" { path.clone() } else { format!("{path}::{name}") };
            let (from, name) = whole.rsplit_once("::").unwrap();
            names.push((name.to_string(), from.to_string()));
        }
    }
    names
}

/// The name that an item of this line declares, if it is public.
fn declared(line: &str) -> Option<&str> {
    let rest = line.strip_prefix("pub ")?;
    let kinds = ["const fn ", "fn ", "struct ", "enum ", "const ", "trait ", "type ", "static "];
    let rest = kinds.iter().find_map(|kind| rest.strip_prefix(kind))?;
    rest.split(|letter: char| !letter.is_alphanumeric() && letter != '_').next()
}

#[test]
fn what_a_host_may_use_is_listed() {
    let source = top().join("kernel/src");
    let names = names(&fs::read_to_string(source.join("lib.rs")).unwrap());
    let mut surface: BTreeSet<String> = names.iter().map(|(name, _)| name.clone()).collect();
    let mut all = Vec::new();
    files(&source, &mut all);
    for file in all {
        let text = fs::read_to_string(&file).unwrap();
        let text = text.split("\n#[cfg(test)]").next().unwrap();
        let module = file.file_stem().unwrap().to_str().unwrap();
        let folder = |above: usize| file.ancestors().nth(above).unwrap().file_name().unwrap().to_str().unwrap();
        // A module is a file of a room, or a folder of files there.
        for (module, room) in [(module, folder(1)), (folder(1), folder(2))] {
            if names.iter().any(|(name, from)| name == module && from == room) {
                surface.extend(text.lines().filter_map(declared).map(|name| format!("{module}::{name}")));
            }
        }
        let mut owner = None;
        for line in text.lines() {
            if let Some(head) = line.strip_prefix("impl").filter(|head| !head.contains(" for ")) {
                let head =
                    if head.starts_with('<') { head.split_once("> ").map_or("", |(_, rest)| rest) } else { head };
                owner = head.split(|c: char| !c.is_alphanumeric() && c != '_').find(|part| !part.is_empty());
            }
            if line == "}" {
                owner = None;
            }
            let Some((owner, item)) = owner.zip(line.strip_prefix("    ").and_then(declared)) else { continue };
            if names.iter().any(|(name, _)| name == owner) {
                surface.insert(format!("{owner}::{item}"));
            }
        }
    }
    let list = top().join("tests/structure/surface.txt");
    let found = surface.into_iter().map(|name| name + "\n").collect::<String>();
    let listed = fs::read_to_string(&list).unwrap_or_default();
    if found != listed {
        let written = top().join("target/surface.txt");
        fs::write(&written, &found).unwrap();
        panic!("what the kernel offers has changed: compare {} with {}", written.display(), list.display());
    }
}
