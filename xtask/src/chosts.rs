//! The C interface: its two libraries, and C and C++ programs that use them as a host would.

use crate::digests::{lines, pins};
use crate::targets::{FROM_HOST, undefined};
use crate::tools::{Outcome, emptied, found, needs, output, read, run as command, target, top, wait};
use std::path::{Path, PathBuf};

/// The installed library that the hosts, the examples and the README use.
pub fn prefix() -> PathBuf {
    target().join("prefix")
}

/// Builds and installs it.
pub fn installed() -> Outcome {
    crate::install::into(&prefix())
}

/// A C and a C++ compiler of one family, and the libraries their hosts are linked with.
const COMPILERS: [([&str; 2], &str, usize); 2] =
    [(["gcc", "g++"], "KINDS=shared static", 8), (["clang", "clang++"], "KINDS=shared", 4)];

/// Installs the library and runs C99, C11, C++17 and C++20 hosts against it, built by a makefile with
/// pkg-config. Each must print the digests of tests/golden/pins, which are those of the kernel called from
/// Rust.
pub fn run() -> Outcome {
    needs(&["g++", "make", "pkg-config"])?;
    installed()?;
    undefined(&prefix().join("lib/libfabric_kernel.so"), &FROM_HOST)?;
    let wanted = [pins("scene")?, pins("host")?].concat();
    for ([c, cpp], kinds, expected) in COMPILERS {
        if !found(&[c], "C and C++ hosts by clang") {
            continue;
        }
        let folder = emptied(target().join("hosts").join(c))?;
        make(&folder, &[&format!("CC={c}"), &format!("CXX={cpp}"), kinds])?;
        let mut hosts = 0;
        for entry in std::fs::read_dir(&folder).map_err(|error| error.to_string())? {
            let path = entry.map_err(|error| error.to_string())?.path();
            if path.extension().is_some_and(|extension| extension == "digests") {
                let printed = read(&path)?;
                if lines(&printed) != wanted {
                    return Err(format!("{} holds other digests than {wanted:?}:\n{printed}", path.display()));
                }
                hosts += 1;
            }
        }
        if hosts != expected {
            return Err(format!("{hosts} hosts ran instead of {expected}"));
        }
        println!("figure 23: {c}, {cpp}: {hosts} hosts print the digests of the kernel");
    }
    watched(&wanted)?;
    let syntax = ["-std=c++17", "-fsyntax-only", "-fno-exceptions", "-fno-rtti", "-Wall", "-Wextra", "-Werror"];
    command("g++", &[&syntax[..], &["-Iinclude", "tests/cpp/host.cpp"]].concat())
}

/// The C99 and the C++17 host with AddressSanitizer and the checks for undefined behaviour; a short C host
/// under valgrind, which sees the library too (the long one changes the rounding mode, which valgrind does
/// not know): no complaint, the same digests.
fn watched(wanted: &[(String, String)]) -> Outcome {
    let folder = emptied(target().join("hosts/watched"))?;
    let library = prefix().join("lib/libfabric_kernel.a").to_string_lossy().into_owned();
    let include = format!("-I{}", prefix().join("include").display());
    let build = |compiler: &str, source: &str, options: &[&str]| -> Result<PathBuf, String> {
        let program = folder.join(compiler).with_extension(if options.is_empty() { "plain" } else { "sanitized" });
        let flags = ["-O1", "-g", &include, source, &library, "-lm", "-o", &program.to_string_lossy()];
        command(compiler, &[options, &flags[..]].concat())?;
        Ok(program)
    };
    for (compiler, standard, source) in
        [("gcc", "-std=c99", "tests/c/host.c"), ("g++", "-std=c++17", "tests/cpp/host.cpp")]
    {
        let sanitizer = [standard, "-fsanitize=address,undefined", "-fno-sanitize-recover"];
        let printed = output(build(compiler, source, &sanitizer)?, &[])?;
        if lines(&printed) != wanted {
            return Err(format!("{source} with sanitizers prints other digests than {wanted:?}:\n{printed}"));
        }
    }
    println!("figure 23: C99 and C++17 hosts with AddressSanitizer and UBSan (which see the host's code): 0 errors");
    let short = build("gcc", "examples/c/impact.c", &[])?;
    if !found(&["valgrind"], "C host under valgrind") {
        return Ok(());
    }
    output("valgrind", &["--quiet", "--leak-check=full", "--error-exitcode=9", &short.to_string_lossy()])?;
    println!("figure 23: a C host under valgrind (which sees the library too): 0 errors");
    Ok(())
}

/// Runs tests/c/Makefile in a folder, with pkg-config looking at the installed library.
fn make(folder: &Path, variables: &[&str]) -> Outcome {
    let mut make = std::process::Command::new("make");
    make.args(["--silent", "--jobs=2", "--file"])
        .arg(top().join("tests/c/Makefile"))
        .args(variables)
        .env("PKG_CONFIG_PATH", prefix().join("lib/pkgconfig"))
        .current_dir(folder);
    wait(&mut make)
}
