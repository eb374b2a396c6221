//! Words of the sources: how comments begin in the kernel, how wide they are, and names of types.

use crate::{files, top};
use std::collections::BTreeMap;
use std::fs;

/// Words with which no doc line begins: it begins with the noun of what the item is.
const NO_NOUNS: [&str; 6] = ["Of", "And", "The same", "Its", "Those", "As above"];

/// Most columns of a line of comment.
const COLUMNS: usize = 110;

/// Files in which something lies behind something else in space. Time has before and after.
const IN_SPACE: [&str; 8] = [
    "body/shape.rs",
    "contact/backing.rs",
    "contact/edge.rs",
    "contact/search.rs",
    "scene/fields/table.rs",
    "scene/parts.rs",
    "sheet/check.rs",
    "step/outcome.rs",
];

/// Names that two types have.
const TWICE: [&str; 2] = ["Nodes", "Place"];

/// Files whose comments are older than these rules.
const OLDER: [&str; 2] = ["ground/lanes.rs", "memory/layout.rs"];

/// Each file of the kernel by its name from `kernel/src` on.
fn kernel() -> Vec<(String, String)> {
    let (source, mut found) = (top().join("kernel/src"), Vec::new());
    files(&source, &mut found);
    let name = |path: &std::path::Path| path.strip_prefix(&source).unwrap().to_str().unwrap().to_string();
    found.iter().map(|path| (name(path), fs::read_to_string(path).unwrap())).collect()
}

/// Whether a text has a word, in small letters or with a capital.
fn has_word(text: &str, word: &str) -> bool {
    text.split(|c: char| !c.is_alphanumeric()).any(|part| part.eq_ignore_ascii_case(word))
}

#[test]
fn comments_begin_with_nouns_and_are_narrow() {
    let mut wrong = Vec::new();
    for (name, text) in kernel().into_iter().filter(|(name, _)| !OLDER.contains(&name.as_str())) {
        for (number, line) in text.lines().enumerate() {
            let Some(comment) = line.trim_start().strip_prefix("//") else { continue };
            let begins = |word: &&str| {
                let rest = comment.strip_prefix(['/', '!']).and_then(|doc| doc.trim_start().strip_prefix(*word));
                rest.is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
            };
            let is_wide = line.chars().count() > COLUMNS;
            let is_after = has_word(comment, "behind") && !IN_SPACE.contains(&name.as_str());
            if NO_NOUNS.iter().any(begins) || is_wide || is_after || has_word(comment, "besides") {
                wrong.push(format!("{name}:{}: {}", number + 1, line.trim()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Rows of tables may be wider. (Comments of `capi` and `crates/capsule` are those of the header.)
#[test]
fn comments_beside_the_kernel_are_narrow() {
    let mut sources = Vec::new();
    for folder in ["crates/host", "crates/scene", "evidence", "fmu", "python", "tests", "xtask"] {
        files(&top().join(folder), &mut sources);
    }
    for file in sources.iter().filter(|file| file.extension().is_some_and(|kind| kind == "rs")) {
        let text = fs::read_to_string(file).unwrap();
        let is_wide = |line: &&str| {
            line.trim_start().starts_with("//") && !line.contains(" | ") && line.chars().count() > COLUMNS
        };
        assert_eq!(text.lines().find(is_wide), None, "{}", file.display());
    }
}

#[test]
fn no_type_has_the_name_of_another() {
    let mut types = BTreeMap::<String, Vec<String>>::new();
    for (name, text) in kernel() {
        let code = text.split("mod tests {").next().unwrap();
        for line in code.lines() {
            let line = line.strip_prefix("pub(crate) ").or(line.strip_prefix("pub(super) ")).unwrap_or(line);
            let line = line.strip_prefix("pub ").unwrap_or(line);
            let kinds = ["struct ", "enum ", "trait ", "type "];
            let Some(named) = kinds.iter().find_map(|kind| line.strip_prefix(kind)) else { continue };
            let end = named.find(|c: char| !c.is_alphanumeric()).unwrap_or(named.len());
            types.entry(named[..end].to_string()).or_default().push(name.clone());
        }
    }
    types.retain(|name, files| files.len() > 1 && !TWICE.contains(&name.as_str()));
    assert!(types.is_empty(), "{types:?}");
}
