//! The C interface: its two libraries, and C and C++ programs that use them as a host would.

use crate::digests::{lines, pins};
use crate::targets::{FROM_HOST, undefined};
use crate::tools::{Outcome, emptied, ensure, found, needs, sh, shell, target, top};
use std::path::PathBuf;

/// The installed library that the hosts, the examples and the README use.
pub fn prefix() -> PathBuf {
    target().join("prefix")
}

/// The static form of it.
pub fn library() -> PathBuf {
    prefix().join("lib/libfabric_kernel.a")
}

/// Builds and installs it.
pub fn installed() -> Outcome {
    crate::install::into(&prefix())
}

/// A C and a C++ compiler of one family, and the libraries their hosts are linked with.
const COMPILERS: [([&str; 2], &str, usize); 2] =
    [(["gcc", "g++"], "shared static", 8), (["clang", "clang++"], "shared", 4)];

/// Installs the library and runs C99, C11, C++17 and C++20 hosts against it, built by a makefile with
/// pkg-config. Each must print the digests of tests/golden/pins, which are those of the kernel called from
/// Rust.
pub fn run() -> Outcome {
    needs(&["g++", "make", "pkg-config"])?;
    installed()?;
    undefined(&prefix().join("lib/libfabric_kernel.so"), &FROM_HOST)?;
    let wanted = [pins("scene")?, pins("host")?].concat();
    let makefile = top().join("tests/c/Makefile");
    for ([c, cpp], kinds, expected) in COMPILERS {
        if !found(&[c], "C and C++ hosts by clang") {
            continue;
        }
        let folder = emptied(target().join("hosts").join(c))?;
        let make =
            sh!("make --silent --jobs=2 --no-print-directory -C {folder} -f {makefile} CC={c} CXX={cpp} KINDS={kinds}");
        make.env("PKG_CONFIG_PATH", prefix().join("lib/pkgconfig")).run()?;
        let mut hosts = shell().read_dir(&folder)?;
        hosts.retain(|path| path.extension().is_some_and(|extension| extension == "digests"));
        for path in &hosts {
            let printed = shell().read_file(path)?;
            ensure!(lines(&printed) == wanted, "{} holds other digests than {wanted:?}:\n{printed}", path.display());
        }
        ensure!(hosts.len() == expected, "{} hosts ran instead of {expected}", hosts.len());
        println!("figure 23: {c}, {cpp}: {expected} hosts print the digests of the kernel");
    }
    watched(&wanted)?;
    let warnings = ["-Wall", "-Wextra", "-Werror"];
    let few = ["-fsyntax-only", "-fno-exceptions", "-fno-rtti"];
    Ok(sh!("g++ -std=c++17 {few...} {warnings...} -Iinclude tests/cpp/host.cpp").run()?)
}

/// The C99 and the C++17 host with AddressSanitizer and the checks for undefined behaviour; a short C host
/// under valgrind, which sees the library too (the long one changes the rounding mode, which valgrind does
/// not know): no complaint, the same digests.
fn watched(wanted: &[(String, String)]) -> Outcome {
    let folder = emptied(target().join("hosts/watched"))?;
    let (library, include) = (library(), prefix().join("include"));
    let build = |compiler: &str, source: &str, options: &[&str]| -> Outcome<PathBuf> {
        let program = folder.join(compiler).with_extension(if options.is_empty() { "plain" } else { "sanitized" });
        sh!("{compiler} {options...} -O1 -g -I{include} {source} {library} -lm -o {program}").run()?;
        Ok(program)
    };
    for (compiler, standard, source) in
        [("gcc", "-std=c99", "tests/c/host.c"), ("g++", "-std=c++17", "tests/cpp/host.cpp")]
    {
        let program = build(compiler, source, &[standard, "-fsanitize=address,undefined", "-fno-sanitize-recover"])?;
        let printed = sh!("{program}").read()?;
        ensure!(lines(&printed) == wanted, "{source} with sanitizers prints other digests than {wanted:?}:\n{printed}");
    }
    println!("figure 23: C99 and C++17 hosts with AddressSanitizer and UBSan (which see the host's code): 0 errors");
    let short = build("gcc", "examples/c/impact.c", &[])?;
    if !found(&["valgrind"], "C host under valgrind") {
        return Ok(());
    }
    sh!("valgrind --quiet --leak-check=full --error-exitcode=9 {short}").ignore_stdout().run()?;
    println!("figure 23: a C host under valgrind (which sees the library too): 0 errors");
    Ok(())
}
