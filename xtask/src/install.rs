//! `cargo xtask install`: the C and C++ library as other build systems expect to find it.

use crate::tools::{Outcome, emptied, finish, output, target, top};
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

/// Lays out headers, libraries, CMake package, pkg-config file and licences under `prefix`.
pub fn into(prefix: &Path) -> Outcome {
    let built = build()?;
    let [built, prefix] = [&*built, prefix].map(|path| path.to_string_lossy().into_owned());
    crate::tools::run("python3", &["capi/install/install.py", &built, &prefix, env!("CARGO_PKG_VERSION")])
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
