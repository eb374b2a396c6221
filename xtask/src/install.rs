//! `cargo xtask install`: the C and C++ library as other build systems expect to find it.

use crate::tools::{Outcome, emptied, ensure, finish, said, sh, target};
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub struct Options {
    /// Folder that receives include/, lib/ and share/, e.g. /usr/local or ~/.local. It may be moved
    /// afterwards.
    #[arg(long, value_name = "FOLDER")]
    prefix: PathBuf,
}

pub fn run(options: &Options) -> Outcome {
    into(&std::path::absolute(&options.prefix)?)
}

/// Packs what `install` lays out: target/archive/fabric_kernel-VERSION-TARGET.tar.gz. The same libraries give
/// the same archive.
pub fn archive() -> Outcome<PathBuf> {
    let platform = sh!("rustc --print host-tuple").read()?;
    let name = format!("fabric_kernel-{}-{platform}", env!("CARGO_PKG_VERSION"));
    let folder = emptied(target().join("archive"))?;
    into(&folder.join(&name))?;
    let file = folder.join(format!("{name}.tar.gz"));
    let fixed =
        ["--sort=name", "--mtime=@0", "--owner=0", "--group=0", "--numeric-owner", "--use-compress-program=gzip -n"];
    sh!("tar {fixed...} -C {folder} -cf {file} {name}").run()?;
    Ok(file)
}

/// Lays out headers, libraries, CMake package, pkg-config file and licences under `prefix`.
pub fn into(prefix: &Path) -> Outcome {
    let (built, version) = (build()?, env!("CARGO_PKG_VERSION"));
    Ok(sh!("python3 capi/install/install.py {built} {prefix} {version}").run()?)
}

/// Builds both libraries as they ship. A warning of the compiler or the linker is an error.
pub fn build() -> Outcome<PathBuf> {
    let cargo = sh!("cargo build --profile ship --package capi-lib --features bare");
    let built = said("Compiling the C library", || finish(cargo))?;
    let said = String::from_utf8_lossy(&built.stderr);
    ensure!(!said.contains("warning"), "libfabric_kernel does not build cleanly:\n{said}");
    Ok(target().join("ship"))
}
