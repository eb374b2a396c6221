//! Words of the sources in Rust: how comments begin, how wide they are, and names of types.

use crate::{files, top};
use std::collections::BTreeMap;
use std::fs;

/// Folders with sources in Rust.
const FOLDERS: [&str; 8] = ["capi", "crates", "evidence", "fmu", "kernel", "python", "tests", "xtask"];

/// Words with which no line of comment begins: it begins with the noun of what it is about.
const NO_NOUNS: [&str; 6] = ["Of", "And", "The same", "Its", "Those", "As above"];

/// Words with which no doc line of the kernel begins either.
const CLAUSES: [&str; 5] = ["What", "Whether it", "How", "By how much", "Nothing"];

/// Most columns of a line of comment. Rows of tables may be wider.
const COLUMNS: usize = 110;

/// Files in which something is farther away than something else. Time has before and after.
const IN_SPACE: [&str; 9] = [
    "kernel/src/body/shape.rs",
    "kernel/src/contact/backing.rs",
    "kernel/src/contact/edge.rs",
    "kernel/src/contact/search.rs",
    "kernel/src/scene/fields/table.rs",
    "kernel/src/scene/parts.rs",
    "kernel/src/sheet/check.rs",
    "kernel/src/step/flight.rs",
    "kernel/src/step/outcome.rs",
];

/// Files and folders whose comments may be wider: older ones, and those that are the header's.
const WIDE: [&str; 2] = ["capi/", "crates/capsule/"];

/// Names that two types of a crate have.
const TWICE: [&str; 1] = ["Options"];

/// Each file in Rust by its name from the project's folder on.
fn sources() -> Vec<(String, String)> {
    let mut found = Vec::new();
    FOLDERS.iter().for_each(|folder| files(&top().join(folder), &mut found));
    found.retain(|path| path.extension().is_some_and(|kind| kind == "rs"));
    let name = |path: &std::path::Path| path.strip_prefix(top()).unwrap().to_str().unwrap().to_string();
    found.iter().map(|path| (name(path), fs::read_to_string(path).unwrap())).collect()
}

/// Whether a text has a word, in small letters or with a capital.
fn has_word(text: &str, word: &str) -> bool {
    text.split(|c: char| !c.is_alphanumeric()).any(|part| part.eq_ignore_ascii_case(word))
}

#[test]
fn comments_begin_with_nouns_and_are_narrow() {
    let mut wrong = Vec::new();
    for (name, text) in sources() {
        let wide = WIDE.iter().any(|wide| name.starts_with(wide));
        for (number, line) in text.lines().enumerate() {
            let Some(comment) = line.trim_start().strip_prefix("//") else { continue };
            let doc = comment.strip_prefix(['/', '!']);
            let begins = |word: &&str| {
                let rest = doc.unwrap_or(comment).trim_start().strip_prefix(*word);
                rest.is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
            };
            let is_wide = !wide && !line.contains(" | ") && line.chars().count() > COLUMNS;
            let is_after = has_word(comment, "behind") && !IN_SPACE.contains(&name.as_str());
            let is_clause = doc.is_some() && name.starts_with("kernel/src/") && CLAUSES.iter().any(begins);
            if NO_NOUNS.iter().any(begins) || is_clause || is_wide || is_after || has_word(comment, "besides") {
                wrong.push(format!("{name}:{}: {}", number + 1, line.trim()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn no_type_has_the_name_of_another() {
    let mut types = BTreeMap::<(String, String), Vec<String>>::new();
    for (name, text) in sources() {
        let in_tests = name.match_indices('/').nth(1).map_or(0, |(end, _)| end);
        let folder = &name[..name.find("/src/").unwrap_or(in_tests)];
        let code = text.split("mod tests {").next().unwrap();
        for line in code.lines() {
            let line = line.strip_prefix("pub(crate) ").or(line.strip_prefix("pub(super) ")).unwrap_or(line);
            let line = line.strip_prefix("pub ").unwrap_or(line);
            let kinds = ["struct ", "enum ", "trait ", "type "];
            let Some(named) = kinds.iter().find_map(|kind| line.strip_prefix(kind)) else { continue };
            let end = named.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(named.len());
            types.entry((folder.to_string(), named[..end].to_string())).or_default().push(name.clone());
        }
    }
    types.retain(|(_, name), files| files.len() > 1 && !TWICE.contains(&name.as_str()));
    assert!(types.is_empty(), "{types:?}");
}
