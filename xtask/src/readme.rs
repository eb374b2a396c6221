//! Runs the Python program of docs/fmi.md and the C++ program of docs/embedding.md as a reader would. (The
//! Python programs of README.md and docs/python.md are run by the tests of the package, the Rust program of
//! kernel/README.md is a doctest.)

use crate::chosts::prefix;
use crate::platforms::Targets;
use crate::tools::{Context as _, Outcome, cmake, emptied, ensure, found, python, sh, shell, target};
use std::path::PathBuf;

pub fn run() -> Outcome {
    crate::chosts::installed()?;
    crate::fmu::packed(Targets::Host, false)?;
    let folder = emptied(target().join("readme"))?;
    if found(&["cmake", "g++"], "program of docs/embedding.md") {
        embedding()?;
    }
    let (python, program) = (python()?, save(&shell().read_file("docs/fmi.md")?, "python", folder.join("example.py"))?);
    Ok(sh!("{python} {program}").run()?)
}

/// The C++ program of docs/embedding.md with its CMake project; it must print what the page says.
fn embedding() -> Outcome {
    let text = shell().read_file("docs/embedding.md")?;
    let folder = emptied(target().join("embedding"))?;
    save(&text, "cpp", folder.join("impact.cpp"))?;
    save(&text, "cmake", folder.join("CMakeLists.txt"))?;
    let build = folder.join("build");
    cmake(&folder, &build, &prefix())?;
    let printed = sh!("{build}/impact").read()?;
    println!("{printed}");
    let said = block(&text, "text").unwrap_or_default();
    ensure!(printed.trim() == said, "docs/embedding.md says the program prints\n{said}");
    Ok(())
}

/// Writes the first block of a language to a file; its path.
fn save(text: &str, language: &str, path: PathBuf) -> Outcome<PathBuf> {
    let code = block(text, language).with_context(|| format!("there is no {language} example"))?;
    shell().write_file(&path, format!("{code}\n"))?;
    Ok(path)
}

/// The first fenced block of a language.
fn block<'t>(text: &'t str, language: &str) -> Option<&'t str> {
    let (_, rest) = text.split_once(&format!("```{language}\n"))?;
    rest.split_once("\n```").map(|(code, _)| code)
}
