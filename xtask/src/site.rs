//! `cargo xtask site`: all pages, the reference of the Python package, the C header and the crate's
//! documentation as a site with a search (docs/site).

use crate::tools::{Outcome, cargo, first_found, python_with, run as command, step_left_out, target};
use std::path::PathBuf;

/// Writes target/site/html; the same as an archive.
pub fn run() -> Result<PathBuf, String> {
    let folder = target().join("rustdoc");
    let into = ["--target-dir", &folder.to_string_lossy()];
    cargo(&[&["doc", "--quiet", "--no-deps", "--package", "fabric-kernel"], &into[..]].concat())?;
    make()?;
    Ok(target().join("site/fabric-documentation.zip"))
}

/// The pages become a site, and no link on it is broken.
pub fn check() -> Outcome {
    if first_found(&["npm"]).is_none() {
        return step_left_out("no npm (Debian: npm)");
    }
    make()
}

fn make() -> Outcome {
    command(python_with("docs/site/requirements.txt")?, &["docs/site/make.py"])
}
