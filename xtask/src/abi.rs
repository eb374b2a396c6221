//! The binary interface: the symbols, the layout of every structure on several targets.

use crate::chosts::prefix;
use crate::tools::{Outcome, ensure, found, sh, shell};

/// A target, its C and its C++ compiler, and what they need to be told.
const TARGETS: [(&str, [&str; 2], &[&str]); 7] = [
    ("x86-64", ["gcc", "g++"], &[]),
    ("i686", ["gcc", "g++"], &["-m32"]),
    ("aarch64", ["aarch64-linux-gnu-gcc", "aarch64-linux-gnu-g++"], &[]),
    ("aarch64 by clang", ["clang", "clang++"], &["--target=aarch64-linux-gnu"]),
    ("Cortex-M", ["clang", "clang++"], &["--target=thumbv7em-none-eabihf"]),
    ("Windows", ["clang", "clang++"], &["--target=x86_64-w64-mingw32"]),
    ("wasm32", ["clang", "clang++"], &["--target=wasm32"]),
];

/// Everything.
pub fn run() -> Outcome {
    crate::chosts::installed()?;
    let symbols = symbols()?;
    let layouts = layouts()?;
    println!(
        "figure 22: 0 unreviewed changes: {symbols} symbols and the header as committed, layout of every structure on \
         {layouts} targets"
    );
    Ok(())
}

/// The shared library exports what tests/c/abi/symbols.txt lists and nothing else.
fn symbols() -> Outcome<usize> {
    let library = prefix().join("lib/libfabric_kernel.so");
    let listed = sh!("nm -D --defined-only {library}").read()?;
    let mut exported: Vec<_> = listed.lines().filter_map(|line| line.split_whitespace().last()).collect();
    exported.sort_unstable();
    let committed = shell().read_file("tests/c/abi/symbols.txt")?;
    let committed: Vec<_> = committed.lines().collect();
    let lost: Vec<_> = committed.iter().filter(|name| !exported.contains(name)).collect();
    let new: Vec<_> = exported.iter().filter(|name| !committed.contains(name)).collect();
    ensure!(
        lost.is_empty() && new.is_empty(),
        "tests/c/abi/symbols.txt: new {new:?} (add them), lost {lost:?} (old hosts need them)"
    );
    println!("  {} symbols, as committed", exported.len());
    Ok(exported.len())
}

/// tests/c/abi/layout.c compiles as C and C++ for every target whose compiler is here. Only its header is
/// needed, so no C library of the target has to be. The number of targets.
fn layouts() -> Outcome<usize> {
    let mut checked = Vec::new();
    let languages = [("C", ["-xc", "-std=c11"]), ("C++", ["-xc++", "-std=c++17"])];
    for (target, compilers, options) in TARGETS {
        for (compiler, (language, standard)) in compilers.into_iter().zip(languages) {
            if !found(&[compiler], &format!("layout on {target} in {language}")) {
                continue;
            }
            let flags = ["-fsyntax-only", "-ffreestanding", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Iinclude"];
            sh!("{compiler} {options...} {standard...} {flags...} tests/c/abi/layout.c").run()?;
            checked.push(format!("{target} ({language})"));
        }
    }
    println!("  layout as committed: {}", checked.join(", "));
    Ok(TARGETS.iter().filter(|(target, ..)| checked.iter().any(|one| one.starts_with(&format!("{target} (")))).count())
}
