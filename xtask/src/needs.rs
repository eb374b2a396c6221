//! What the commands need of the machine: all that is missing is named at once, before anything is built.

use crate::platforms::compiler_for;
use crate::tools::{Outcome, cargo_program};
use std::path::Path;
use std::process::{Command, Stdio};

/// A tool.
struct Need {
    /// What it is, or what is left out without it.
    about: &'static str,
    /// Whether it is here.
    here: fn() -> bool,
    /// Its packages of Debian and Ubuntu.
    packages: &'static str,
}

const fn need(about: &'static str, here: fn() -> bool, packages: &'static str) -> Need {
    Need { about, here, packages }
}

/// Linked this program, so that it is here; Python is all that the demo needs besides.
const DEMO: [Need; 1] = [need("Python 3.11 or newer with venv", python, "python3 python3-venv")];

/// What `cargo xtask test` cannot do without.
const TEST: [Need; 7] = [
    need("git", || any(&["git"]), "git"),
    need("a C compiler (cc and gcc)", || all(&["cc", "gcc"]), "gcc libc6-dev"),
    need("a C++ compiler (c++ and g++)", || all(&["c++", "g++"]), "g++"),
    need("binutils (nm, objdump, readelf)", || all(&["nm", "objdump", "readelf"]), "binutils"),
    need("make", || any(&["make"]), "make"),
    need("CMake (cmake)", || any(&["cmake"]), "cmake"),
    need("pkg-config", || any(&["pkg-config"]), "pkg-config"),
];

/// What only some checks need, and which; these are left out without it.
const OTHERS: [Need; 13] = [
    need("C and C++ hosts by clang, layouts, WebAssembly", || any(&["clang"]), "clang"),
    need("hosts and calls under valgrind, cost of the C++ header", || any(&["valgrind"]), "valgrind"),
    need("ecospy, an importer of FMUs", tbb, "libtbb12"),
    need("FMU for aarch64", || any(&["aarch64-linux-gnu-gcc"]), "gcc-aarch64-linux-gnu libc6-dev-arm64-cross"),
    need("layouts in C++ on aarch64", || any(&["aarch64-linux-gnu-g++"]), "g++-aarch64-linux-gnu"),
    need("FMU for Windows", || any(&["x86_64-w64-mingw32-gcc"]), "gcc-mingw-w64-x86-64"),
    need("run of the FMU for Windows", || any(&WINE), "wine64"),
    need("run of the FMU for aarch64", || any(&["qemu-aarch64-static"]), "qemu-user-static"),
    // Not gcc-multilib, which cannot be installed beside the compiler for aarch64.
    need("digests on i686", || any(&["i686-linux-gnu-gcc"]), "gcc-i686-linux-gnu libc6-dev-i386-cross"),
    need("digests on a Cortex-M7", || any(&["arm-none-eabi-gcc"]), "gcc-arm-none-eabi"),
    need("digests on a Cortex-M7", || any(&["qemu-system-arm"]), "qemu-system-arm"),
    need("digests on WebAssembly, web page", || all(&["node", "npm"]), "nodejs npm"),
    need("test of the web page", || any(&BROWSERS), "chromium"),
];

/// Platforms that are built for, besides this one and macOS.
const TRIPLES: [&str; 5] = [
    "aarch64-unknown-linux-gnu",
    "i686-unknown-linux-gnu",
    "thumbv7em-none-eabihf",
    "wasm32-unknown-unknown",
    "x86_64-pc-windows-gnu",
];

/// Names of the browser.
pub const BROWSERS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// Names of Wine; Debian does not put it in the path.
pub const WINE: [&str; 3] = ["wine64", "wine", "/usr/lib/wine/wine64"];

/// An error that names all that `cargo xtask demo` misses.
pub fn demo() -> Outcome {
    named(&missing(&DEMO))
}

/// An error that names all that `cargo xtask test` misses; what it will leave out is printed.
pub fn test() -> Outcome {
    let mut lost = missing(&DEMO);
    lost.extend(missing(&TEST));
    named(&lost)?;
    let component = |name: &&&str| {
        let answer = Command::new(cargo_program()).args([*name, "--version"]).output();
        !answer.is_ok_and(|answer| answer.status.success())
    };
    let components: Vec<_> = ["fmt", "clippy"].iter().filter(component).collect();
    if !components.is_empty() {
        return Err(
            "cargo fmt or cargo clippy is missing; install both:\n\n    rustup component add rustfmt clippy".into()
        );
    }
    let others = missing(&OTHERS);
    if !others.is_empty() {
        println!(
            "Left out on this machine:\n{}\nOn Debian or Ubuntu this installs it:\n\n    {}\n",
            listed(&others),
            line(&others)
        );
    }
    let triples: Vec<_> = TRIPLES.iter().copied().filter(|triple| compiler_for(triple).is_err()).collect();
    if !triples.is_empty() {
        println!("Left out without Rust for other platforms:\n\n    rustup target add {}\n", triples.join(" "));
    }
    Ok(())
}

/// `cargo xtask packages`: two lines, for .ci/run.
pub fn packages() -> Outcome {
    let mut needed = missing(&DEMO);
    needed.extend(missing(&TEST));
    // Debian's Rust brings the source of `core`, from which it is built for any platform.
    let cross = TRIPLES.iter().all(|triple| compiler_for(triple).is_ok());
    let rust = if cross { "" } else { "rustc-web cargo-web rust-web-src" };
    println!("{}\n{} {rust}", joined(&needed), joined(&missing(&OTHERS)));
    Ok(())
}

fn missing(needs: &'static [Need]) -> Vec<&'static Need> {
    needs.iter().filter(|need| !(need.here)()).collect()
}

fn named(lost: &[&Need]) -> Outcome {
    if lost.is_empty() {
        return Ok(());
    }
    Err(format!(
        "missing on this machine:\n{}\nOn Debian or Ubuntu this installs all of it:\n\n    {}",
        listed(lost),
        line(lost)
    ))
}

fn listed(needs: &[&Need]) -> String {
    needs.iter().map(|need| format!("  - {} ({})\n", need.about, need.packages)).collect()
}

fn line(needs: &[&Need]) -> String {
    format!("apt-get update && apt-get install --no-install-recommends {}", joined(needs))
}

fn joined(needs: &[&Need]) -> String {
    needs.iter().map(|need| need.packages).collect::<Vec<_>>().join(" ")
}

fn any(programs: &[&str]) -> bool {
    programs.iter().any(|program| in_path(program))
}

fn all(programs: &[&str]) -> bool {
    programs.iter().all(|program| in_path(program))
}

/// Whether a program lies in the path, or where its own path says.
fn in_path(program: &str) -> bool {
    std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()).any(|folder| folder.join(program).is_file())
}

fn python() -> bool {
    let probe = "import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))";
    let answer = Command::new("python3").args(["-c", probe]).stderr(Stdio::null()).status();
    answer.is_ok_and(|status| status.success())
}

fn tbb() -> bool {
    ["x86_64", "aarch64"]
        .iter()
        .any(|machine| Path::new(&format!("/usr/lib/{machine}-linux-gnu/libtbb.so.12")).exists())
}
