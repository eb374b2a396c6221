//! What belongs to clamps and to a case is asked for in few places of the kernel: where its memory is laid
//! out, and in the file of each.

use crate::{files, top};
use std::fs;

/// Most places that ask for a feature, and most files that they stand in.
const MOST: [(&str, [usize; 2]); 2] = [("Clamps", [8, 4]), ("Casing", [7, 4])];

/// Code of a file without comments and unit tests.
fn code(text: &str) -> impl Iterator<Item = &str> {
    text.lines().take_while(|line| *line != "#[cfg(test)]").filter(|line| !line.trim_start().starts_with("//"))
}

#[test]
fn clamps_and_case_are_asked_for_in_few_places() {
    let (mut paths, records) = (Vec::new(), top().join("kernel/src/scene/features.rs"));
    files(&top().join("kernel/src"), &mut paths);
    for (feature, most) in MOST {
        let name = format!("Feature::{feature}");
        let asked = paths.iter().filter(|path| **path != records).map(|path| {
            let text = fs::read_to_string(path).unwrap();
            code(&text).map(|line| line.matches(&name).count()).sum::<usize>()
        });
        let asked: Vec<usize> = asked.filter(|&count| count > 0).collect();
        println!("{name} is asked for in {} places of {} files", asked.iter().sum::<usize>(), asked.len());
        assert!(asked.iter().sum::<usize>() <= most[0] && asked.len() <= most[1], "{name}: {asked:?}, most {most:?}");
    }
}

/// A scene is asked by [`is_in`](fabric_kernel::Feature::is_in), whatever asked for its fields before.
#[test]
fn scenes_have_no_other_question_of_a_feature() {
    let parts = fs::read_to_string(top().join("kernel/src/scene/features.rs")).unwrap();
    let scene = parts.split("impl Scene {").nth(1).and_then(|block| block.split("\n}").next()).unwrap();
    assert_eq!(scene.matches("Feature::").count(), 1, "`is_free` alone has a question of its own: {scene}");
}
