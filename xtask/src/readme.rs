//! Runs the Python program of docs/fmi.md and the C++ program of docs/embedding.md as a reader would. (The
//! Python programs of README.md and docs/python.md are run by the tests of the package, the Rust program of
//! kernel/README.md is a doctest.)

use crate::chosts::prefix;
use crate::platforms::Targets;
use crate::tools::{Outcome, cmake, emptied, found, output, python, read, run as command, target, top, write};
use std::path::Path;

pub fn run() -> Outcome {
    crate::chosts::installed()?;
    crate::fmu::packed(Targets::Host, false)?;
    let folder = emptied(target().join("readme"))?;
    if found(&["cmake", "g++"], "program of docs/embedding.md") {
        embedding()?;
    }
    command(python()?, &[&save(&read(top().join("docs/fmi.md"))?, "python", &folder.join("example.py"))?])
}

/// The C++ program of docs/embedding.md with its CMake project; it must print what the page says.
fn embedding() -> Outcome {
    let text = read(top().join("docs/embedding.md"))?;
    let folder = emptied(target().join("embedding"))?;
    save(&text, "cpp", &folder.join("impact.cpp"))?;
    save(&text, "cmake", &folder.join("CMakeLists.txt"))?;
    let build = folder.join("build");
    cmake(&folder, &build, &prefix())?;
    let printed = output(build.join("impact"), &[])?;
    print!("{printed}");
    let said = block(&text, "text").unwrap_or_default();
    if printed.trim() == said { Ok(()) } else { Err(format!("docs/embedding.md says the program prints\n{said}")) }
}

/// Writes the first block of a language to a file; its path.
fn save(text: &str, language: &str, path: &Path) -> Result<String, String> {
    let code = block(text, language).ok_or(format!("there is no {language} example"))?;
    write(path, format!("{code}\n"))?;
    Ok(path.to_string_lossy().into_owned())
}

/// The first fenced block of a language.
fn block<'t>(text: &'t str, language: &str) -> Option<&'t str> {
    let (_, rest) = text.split_once(&format!("```{language}\n"))?;
    rest.split_once("\n```").map(|(code, _)| code)
}
