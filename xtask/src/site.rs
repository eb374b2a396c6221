//! `cargo xtask site`: all pages, the reference of the Python package, the C header and the crate's
//! documentation as a site with a search (docs/site).

use crate::tools::{Outcome, first_found, python_with, sh, step_left_out, target};
use std::path::PathBuf;

/// Writes target/site/html; the same as an archive.
pub fn run() -> Outcome<PathBuf> {
    let folder = target().join("rustdoc");
    sh!("cargo doc --quiet --no-deps --package fabric-kernel --target-dir {folder}").run()?;
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
    let python = python_with("docs/site/requirements.txt")?;
    Ok(sh!("{python} docs/site/make.py").run()?)
}
