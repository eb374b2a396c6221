//! The order of the sources: equations and where they are computed, files that import each other, what a host
//! may use, and words.

mod asked;
mod equations;
mod floors;
mod surface;
mod words;

use std::fs;
use std::path::{Path, PathBuf};

/// The folder of the project.
fn top() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

/// The sources in Rust and Python in a folder and below.
fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if entry.is_dir() {
            files(&entry, found);
        } else if entry.extension().is_some_and(|kind| kind == "rs" || kind == "py") {
            found.push(entry);
        }
    }
}
