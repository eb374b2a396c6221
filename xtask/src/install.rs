//! `cargo xtask install`: the C and C++ library as other build systems expect to find it.

use crate::tools::{Outcome, emptied, finish, make_folder, output, read, target, top, write};
use std::path::{Path, PathBuf};
use std::process::Command;

#[derive(clap::Args)]
pub struct Options {
    /// Folder that receives include/, lib/ and share/, e.g. /usr/local or ~/.local. It may be moved
    /// afterwards.
    #[arg(long, value_name = "FOLDER")]
    prefix: PathBuf,
}

pub fn run(options: &Options) -> Outcome {
    into(&std::path::absolute(&options.prefix).map_err(|error| error.to_string())?)
}

/// Packs what `install` lays out: target/archive/fabric_kernel-VERSION-TARGET.tar.gz. The same libraries give
/// the same archive.
pub fn archive() -> Result<PathBuf, String> {
    let target_name = output("rustc", &["--print", "host-tuple"])?;
    let name = format!("fabric_kernel-{}-{}", env!("CARGO_PKG_VERSION"), target_name.trim());
    let folder = emptied(target().join("archive"))?;
    into(&folder.join(&name))?;
    let file = folder.join(format!("{name}.tar.gz"));
    let fixed =
        ["--sort=name", "--mtime=@0", "--owner=0", "--group=0", "--numeric-owner", "--use-compress-program=gzip -n"];
    let (folder, path) = (folder.to_string_lossy(), file.to_string_lossy());
    crate::tools::run("tar", &[&fixed[..], &["-C", &folder, "-cf", &path, &name]].concat())?;
    Ok(file)
}

/// Lays out under `prefix`:
///
///     include/fabric_kernel.h, fabric_kernel.hpp
///     lib/libfabric_kernel.a
///     lib/libfabric_kernel.so -> libfabric_kernel.so.1
///     lib/pkgconfig/fabric_kernel.pc
///     lib/cmake/fabric_kernel/fabric_kernel-config.cmake, fabric_kernel-config-version.cmake
///     share/licenses/fabric_kernel/
pub fn into(prefix: &Path) -> Outcome {
    let built = build()?;
    let (include, lib) = (prefix.join("include"), prefix.join("lib"));
    for header in ["fabric_kernel.h", "fabric_kernel.hpp"] {
        copy(&top().join("include").join(header), &include.join(header))?;
    }
    copy(&built.join("libfabric_kernel.a"), &lib.join("libfabric_kernel.a"))?;
    let shared = built.join("libfabric_kernel.so");
    let soname = soname(&shared)?;
    copy(&shared, &lib.join(&soname))?;
    link(&soname, &lib.join("libfabric_kernel.so"))?;

    let version = env!("CARGO_PKG_VERSION");
    let mut parts = version.split('.');
    let (major, minor) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
    let words = [("@VERSION@", version), ("@MAJOR@", major), ("@MINOR@", minor), ("@SONAME@", &soname)];
    let cmake = lib.join("cmake").join("fabric_kernel");
    for (template, folder) in [
        ("fabric_kernel.pc", &lib.join("pkgconfig")),
        ("fabric_kernel-config.cmake", &cmake),
        ("fabric_kernel-config-version.cmake", &cmake),
    ] {
        let path = top().join("capi/install").join(format!("{template}.in"));
        let text = read(&path)?;
        let text = words.iter().fold(text, |text, (word, value)| text.replace(word, value));
        write(folder.join(template), text)?;
    }
    let licences = prefix.join("share/licenses/fabric_kernel");
    for licence in ["LICENSE-MIT", "LICENSE-APACHE"] {
        copy(&top().join(licence), &licences.join(licence))?;
    }
    // Of the crates that are linked.
    copy(&top().join("modelDescription/documentation/licenses/license.txt"), &licences.join("crates.txt"))?;
    println!("  fabric_kernel {version} ({soname}) installed in {}", prefix.display());
    Ok(())
}

/// Builds both libraries as they ship. A warning of the compiler or the linker is an error.
pub fn build() -> Result<PathBuf, String> {
    let mut cargo = Command::new(crate::tools::cargo_program());
    cargo.args(["build", "--profile", "ship", "--package", "capi-lib", "--features", "bare"]).current_dir(top());
    let built = crate::tools::said("Compiling the C library", || finish(&mut cargo))?;
    let said = String::from_utf8_lossy(&built.stderr);
    if said.contains("warning") {
        return Err(format!("libfabric_kernel does not build cleanly:\n{said}"));
    }
    Ok(target().join("ship"))
}

/// The name that a shared library asks hosts to look for.
fn soname(library: &Path) -> Result<String, String> {
    let listed = output("readelf", &["-d", &library.to_string_lossy()])?;
    let line = listed.lines().find(|line| line.contains("(SONAME)"));
    let name = line.and_then(|line| line.split_once('[')?.1.split_once(']')).map(|(name, _)| name.to_owned());
    name.ok_or(format!("{} has no soname", library.display()))
}

/// Copies a file to a place whose folder may not be there yet. What is there is removed first, not written
/// over: a program that runs with the old library keeps it.
fn copy(from: &Path, to: &Path) -> Outcome {
    make_folder(to.parent().unwrap_or(Path::new(".")).into())?;
    let _ = std::fs::remove_file(to);
    std::fs::copy(from, to).map_err(|error| format!("{} to {}: {error}", from.display(), to.display()))?;
    Ok(())
}

#[cfg(unix)]
fn link(name: &str, at: &Path) -> Outcome {
    let _ = std::fs::remove_file(at);
    std::os::unix::fs::symlink(name, at).map_err(|error| format!("{}: {error}", at.display()))
}

#[cfg(not(unix))]
fn link(_: &str, _: &Path) -> Outcome {
    Err("the installation is written for Linux".into())
}
