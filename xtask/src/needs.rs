//! What the commands need of the machine: all that is missing is named at once, before anything is built.

use crate::component::PLATFORM;
use crate::platforms::compiler_for;
use crate::targets::{TARGETS, Target};
use crate::tools::{Outcome, asked, ensure, first_found, sh};
use std::collections::BTreeSet;
use std::path::Path;

struct Need {
    /// What it is, or what is left out without it.
    about: String,
    here: bool,
    /// Packages of Debian and Ubuntu.
    packages: &'static str,
}

fn need(about: impl Into<String>, here: bool, packages: &'static str) -> Need {
    Need { about: about.into(), here, packages }
}

/// Needs of the demo: Python. What linked this program is here.
fn for_demo() -> Vec<Need> {
    vec![need("Python 3.11 or newer with venv", python(), "python3 python3-venv")]
}

/// Needs of `cargo xtask test`.
fn for_test() -> Vec<Need> {
    vec![
        need("git", any(&["git"]), "git"),
        need("a C compiler (cc and gcc)", all(&["cc", "gcc"]), "gcc libc6-dev"),
        need("binutils (nm, objdump, readelf)", all(&["nm", "objdump", "readelf"]), "binutils"),
    ]
}

/// What only some checks need, and which; these are left out without it.
fn for_some() -> Vec<Need> {
    let mut needs = vec![
        need("hosts and examples in C++", all(&["c++", "g++"]), "g++"),
        need("C and C++ hosts", all(&["make", "pkg-config"]), "make pkg-config"),
        need("C and C++ examples", any(&["cmake"]), "cmake"),
        need("hosts and calls under valgrind, cost of the C++ header", any(&["valgrind"]), "valgrind"),
        need("ecospy, an importer of FMUs", tbb(), "libtbb12"),
        need("layouts in C++ on aarch64", any(&["aarch64-linux-gnu-g++"]), "g++-aarch64-linux-gnu"),
        need("web page", all(&["node", "npm"]), "nodejs npm"),
        need("test of the web page", any(&BROWSERS), "chromium"),
    ];
    for Target { triple, compiler, runner, .. } in checked() {
        needs.push(need(format!("libraries and programs for {triple}"), any(compiler.0), compiler.1));
        needs.push(need(format!("runs of programs for {triple}"), any(runner.0), runner.1));
    }
    needs
}

/// Targets that every change is checked on.
fn checked() -> impl Iterator<Item = &'static Target> {
    TARGETS.iter().filter(|target| target.checked)
}

pub const BROWSERS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// An error that names all that `cargo xtask demo` misses.
pub fn demo() -> Outcome {
    named(&missing(for_demo()))
}

/// Whether a command of cargo's is here.
pub fn cargo_has(name: &str) -> bool {
    asked(sh!("cargo {name} --version")).is_some()
}

/// An error that names all that `cargo xtask test` misses; what it will leave out is printed, and an error if
/// nothing may be.
pub fn test(complete: bool) -> Outcome {
    named(&for_test_missing())?;
    let others = missing(for_some());
    let triples = checked().map(|target| target.triple).chain([PLATFORM]);
    let triples: Vec<_> = triples.filter(|triple| compiler_for(triple).is_err()).collect();
    if complete {
        named(&others)?;
        let rust = triples.is_empty() && cargo_has("fmt") && cargo_has("clippy");
        ensure!(rust, "missing: cargo fmt, cargo clippy, or Rust for {triples:?}");
        return Ok(());
    }
    if !others.is_empty() {
        println!(
            "Left out on this machine:\n{}\nOn Debian or Ubuntu this installs it:\n\n    {}\n",
            listed(&others),
            line(&others)
        );
    }
    if !triples.is_empty() {
        println!("Left out without Rust for other platforms:\n\n    rustup target add {}\n", triples.join(" "));
    }
    Ok(())
}

/// `cargo xtask packages`: two lines, for .ci/run.
pub fn packages() -> Outcome {
    // Debian's Rust brings the source of `core`, from which it is built for any platform.
    let cross = checked().map(|target| target.triple).chain([PLATFORM]).all(|triple| compiler_for(triple).is_ok());
    let rust = if cross { "" } else { "rustc-web cargo-web rust-web-src" };
    println!("{}\n{} {rust}", joined(&for_test_missing()), joined(&missing(for_some())));
    Ok(())
}

fn missing(needs: Vec<Need>) -> Vec<Need> {
    needs.into_iter().filter(|need| !need.here).collect()
}

fn for_test_missing() -> Vec<Need> {
    missing(for_demo().into_iter().chain(for_test()).collect())
}

fn named(lost: &[Need]) -> Outcome {
    ensure!(
        lost.is_empty(),
        "missing on this machine:\n{}\nOn Debian or Ubuntu this installs all of it:\n\n    {}",
        listed(lost),
        line(lost)
    );
    Ok(())
}

fn listed(needs: &[Need]) -> String {
    needs.iter().map(|need| format!("  - {} ({})\n", need.about, need.packages)).collect()
}

fn line(needs: &[Need]) -> String {
    format!("apt-get update && apt-get install --no-install-recommends {}", joined(needs))
}

fn joined(needs: &[Need]) -> String {
    let packages: BTreeSet<_> = needs.iter().flat_map(|need| need.packages.split(' ')).collect();
    packages.into_iter().collect::<Vec<_>>().join(" ")
}

fn any(programs: &[&str]) -> bool {
    first_found(programs).is_some()
}

fn all(programs: &[&str]) -> bool {
    programs.iter().all(|program| any(&[program]))
}

fn python() -> bool {
    let probe = "import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))";
    asked(sh!("python3 -c {probe}")).is_some()
}

fn tbb() -> bool {
    ["x86_64", "aarch64"]
        .iter()
        .any(|machine| Path::new(&format!("/usr/lib/{machine}-linux-gnu/libtbb.so.12")).exists())
}
