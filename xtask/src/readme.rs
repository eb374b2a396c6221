//! Runs the C and Python examples of the README as a reader would. (The Rust example is a doctest of `fabric-tests`.)

use crate::tools::{Outcome, python, run as command, target, top};
use std::path::Path;

/// Compiles and runs the C block, runs the Python block.
pub fn run() -> Outcome {
    let text = std::fs::read_to_string(top().join("README.md")).map_err(|e| format!("README.md: {e}"))?;
    let folder = target().join("readme");
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let save = |name: &str, language: &str| -> Result<String, String> {
        let path = folder.join(name);
        let code = block(&text, language).ok_or(format!("README.md has no {language} example"))?;
        std::fs::write(&path, code).map_err(|e| format!("{}: {e}", path.display()))?;
        Ok(path.to_string_lossy().into_owned())
    };
    let source = save("example.c", "c")?;
    let program = folder.join("example").to_string_lossy().into_owned();
    let library = crate::chosts::prefix().join("lib/libfabric_kernel.a");
    let compile =
        ["-std=c99", "-Wall", "-Wextra", "-Werror", "-Iinclude", &source, &library.to_string_lossy(), "-o", &program];
    command("cc", &compile)?;
    command(Path::new(&program), &[])?;
    command(python()?, &[&save("example.py", "python")?])
}

/// The first fenced block of a language.
fn block<'t>(text: &'t str, language: &str) -> Option<&'t str> {
    let (_, rest) = text.split_once(&format!("```{language}\n"))?;
    rest.split_once("\n```").map(|(code, _)| code)
}
