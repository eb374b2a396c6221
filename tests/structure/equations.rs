//! The equations of docs/model.md, numbered (M1), (M2), ..., and the places of the sources that compute them.
//!
//! A comment that begins with the number, `/// (M5) Damage variable ...`, says "computed here". A number
//! elsewhere in a comment only mentions the equation.

use crate::{files, top};
use std::collections::BTreeMap;
use std::fs;

/// The kernel, and the host's side of the coupling, (M14).
const FOLDERS: [&str; 2] = ["kernel/src", "examples/coupling"];

/// Numbers of the equations that a line of the page gives: `(M5)`, or `(M5, ...)`.
fn numbers(line: &str) -> impl Iterator<Item = u32> {
    line.split("(M").skip(1).filter_map(|rest| {
        let end = rest.find(|c: char| !c.is_ascii_digit())?;
        rest[..end].parse().ok().filter(|_| rest[end..].starts_with([')', ',', ';']))
    })
}

/// The equation that a line of a source says is computed there.
fn computed(line: &str) -> Option<u32> {
    let text = line.trim_start();
    let comment = ["/// ", "// ", "# "].iter().find_map(|mark| text.strip_prefix(mark))?;
    numbers(comment).next().filter(|number| comment.starts_with(&format!("(M{number}) ")))
}

#[test]
fn every_equation_of_the_page_is_computed_in_one_place() {
    let page = fs::read_to_string(top().join("docs/model.md")).unwrap();
    // The sentence that says what the numbers are for gives no equation.
    let lines = page.lines().filter(|line| !line.contains("number the equations"));
    let mut places: BTreeMap<u32, Vec<String>> = lines.flat_map(numbers).map(|number| (number, Vec::new())).collect();
    let last = *places.keys().last().unwrap();
    assert!(last >= 15 && places.len() == last as usize, "numbers without a gap: {:?}", places.keys());

    let mut sources = Vec::new();
    FOLDERS.iter().for_each(|folder| files(&top().join(folder), &mut sources));
    for source in sources {
        for (k, line) in fs::read_to_string(&source).unwrap().lines().enumerate() {
            if let Some(number) = computed(line) {
                let place = format!("{}:{}", source.strip_prefix(top()).unwrap().display(), k + 1);
                places
                    .get_mut(&number)
                    .unwrap_or_else(|| panic!("{place}: no (M{number}) in docs/model.md"))
                    .push(place);
            }
        }
    }
    for (number, places) in places {
        assert_eq!(places.len(), 1, "(M{number}) of docs/model.md is computed in one place: {places:?}");
    }
}

#[test]
fn a_mention_is_told_from_a_place() {
    assert_eq!(computed("    /// (M5) Damage variable"), Some(5));
    assert_eq!(computed("# (M14) x <- x + V H"), Some(14));
    for mention in ["/// Stress of (M3) and more", "(M3) in code", "/// (M3), the stress", "//! (M1) to (M5)"] {
        assert_eq!(computed(mention), None, "{mention}");
    }
    assert_eq!(numbers("(M13, `path.rs`) and (M9), not (Mx) or (M4").collect::<Vec<_>>(), [13, 9]);
}
