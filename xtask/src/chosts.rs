//! The C interface: its header, its two libraries, and C and C++ programs that use them as a host would.

use crate::tools::{Outcome, cargo, output, panic_gate, run as command, target, top};
use std::path::{Path, PathBuf};

/// Where the header is committed.
fn header_path() -> PathBuf {
    top().join("include").join("fabric_kernel.h")
}

/// The header as cbindgen makes it now.
fn header() -> Result<String, String> {
    let config = cbindgen::Config::from_file(top().join("capi").join("cbindgen.toml"))?;
    let bindings = cbindgen::Builder::new()
        .with_config(config)
        .with_src(top().join("capi/src/types.rs"))
        .with_src(top().join("capi/src/block.rs"))
        .with_src(top().join("capi/src/calls.rs"))
        .generate()
        .map_err(|error| format!("cbindgen: {error}"))?;
    let mut text = Vec::new();
    bindings.write(&mut text);
    String::from_utf8(text).map_err(|error| error.to_string())
}

/// `cargo xtask header`: writes include/fabric_kernel.h.
pub fn header_write() -> Outcome {
    std::fs::write(header_path(), header()?).map_err(|error| format!("{}: {error}", header_path().display()))
}

/// The committed header must be what cbindgen makes.
pub fn header_check() -> Outcome {
    let committed = std::fs::read_to_string(header_path()).map_err(|e| format!("{}: {e}", header_path().display()))?;
    if committed == header()? {
        Ok(())
    } else {
        Err("include/fabric_kernel.h is not what capi/src gives; run `cargo xtask header` and commit it".into())
    }
}

/// Builds libfabric_kernel as it ships; returns the folder with the static and the shared library.
pub fn libraries() -> Result<PathBuf, String> {
    cargo(&["build", "--quiet", "--profile", "ship", "--package", "capi-lib", "--features", "bare"])?;
    Ok(target().join("ship"))
}

/// C99, C11 and C++17 hosts against the static and the shared library; each must print the digest of tests/c/digest, which
/// a test of `fabric-capi` compares with the kernel called from Rust.
pub fn run() -> Outcome {
    let libraries = libraries()?;
    let folder = target().join("hosts");
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let pinned = std::fs::read_to_string(top().join("tests/c/digest")).map_err(|e| format!("tests/c/digest: {e}"))?;
    for (compiler, standard, source) in
        [("cc", "c99", "tests/c/host.c"), ("cc", "c11", "tests/c/host.c"), ("c++", "c++17", "tests/cpp/host.cpp")]
    {
        for library in ["libfabric_kernel.a", "libfabric_kernel.so"] {
            let program = folder.join(format!("host-{standard}-{library}"));
            compile(compiler, standard, source, &libraries.join(library), &program)?;
            let printed = output(&program, &[])?;
            print!("  {compiler} -std={standard}, {library}: {printed}");
            if printed.trim() != pinned.trim() {
                return Err(format!("{source} prints another digest than tests/c/digest holds, {}", pinned.trim()));
            }
        }
    }
    threads(&libraries.join("libfabric_kernel.a"), &folder, &pinned)?;
    undefined(&libraries.join("libfabric_kernel.so"))?;
    panic_gate("capi-lib")
}

/// The example with threads: the same digest for any number of them.
fn threads(library: &Path, folder: &Path, pinned: &str) -> Outcome {
    let (source, program) = ("examples/c/threads.c", folder.join("threads"));
    compile("cc", "c99", source, library, &program)?;
    for threads in ["1", "2", "3", "5"] {
        let printed = output(&program, &[threads])?;
        print!("  {source}, {threads} threads: {printed}");
        if printed.trim() != pinned.trim() {
            return Err(format!("{source} with {threads} threads prints another digest than tests/c/digest holds"));
        }
    }
    Ok(())
}

fn compile(compiler: &str, standard: &str, source: &str, library: &Path, program: &Path) -> Outcome {
    let standard = format!("-std={standard}");
    let folder = format!("-Wl,-rpath,{}", library.parent().unwrap_or(Path::new(".")).display());
    let warnings = ["-O1", "-g", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Iinclude"];
    let (library, program) = (library.to_string_lossy(), program.to_string_lossy());
    command(
        compiler,
        &[&[&*standard], &warnings[..], &[source, &library, &folder, "-o", &program, "-lm", "-pthread"]].concat(),
    )
}

/// The shared library may ask its host for these and nothing else.
fn undefined(library: &Path) -> Outcome {
    const ALLOWED: [&str; 4] = ["memcpy", "memmove", "memset", "memcmp"];
    let listed = output("nm", &["-D", "--undefined-only", &library.to_string_lossy()])?;
    let names = listed.lines().filter(|line| !line.contains(" w ")).filter_map(|line| line.split_whitespace().last());
    let strangers: Vec<_> =
        names.map(|name| name.split('@').next().unwrap_or(name)).filter(|name| !ALLOWED.contains(name)).collect();
    if strangers.is_empty() { Ok(()) } else { Err(format!("{} wants {strangers:?}", library.display())) }
}
