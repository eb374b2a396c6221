//! The FMU's component for WebAssembly (`fmu/wasm`), for archives of FMI 3.0.

use crate::platforms;
use crate::tools;
use std::path::{Path, PathBuf};

/// Target of the component.
pub const PLATFORM: &str = "wasm32-wasip2";

/// Builds it from the checkout in `source` below `target`; an error says what is missing.
pub fn build(source: &Path, target: &Path) -> Result<PathBuf, String> {
    let compiler = platforms::compiler_for(PLATFORM)?;
    let linker = platforms::beside_our_compiler("wasm-component-ld")?;
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| std::env::home_dir().map(|home| home.join(".cargo"))).unwrap_or_default();
    let mut command = compiler.command();
    command
        .args(["build", "--quiet", "--locked", "--profile", "ship", "-p", "fmu-wasm", "--target", PLATFORM])
        .arg("--target-dir")
        .arg(target)
        .args(compiler.options_with("core,alloc"))
        .env("CARGO_TARGET_WASM32_WASIP2_LINKER", &linker)
        // Vectors of two numbers. The same source gives the same bytes: places in the code of others are
        // named by this.
        .env(
            "CARGO_TARGET_WASM32_WASIP2_RUSTFLAGS",
            format!(
                "-Ctarget-feature=+simd128 --remap-path-prefix={}=/cargo -Clink-arg=--wasm-ld-path={}",
                home.display(),
                linker.with_file_name("gcc-ld/wasm-ld").display()
            ),
        )
        .current_dir(source);
    tools::said("Compiling the FMU's component for WebAssembly", || tools::wait(&mut command))?;
    Ok(target.join(PLATFORM).join("ship/fabric_shield_component.wasm"))
}

/// Component, if all it needs is here.
pub fn build_if_ready(source: &Path, target: &Path) -> Result<Option<PathBuf>, String> {
    let ready = platforms::compiler_for(PLATFORM).and(platforms::beside_our_compiler("wasm-component-ld"));
    match ready {
        Ok(_) => build(source, target).map(Some),
        Err(reason) => {
            tools::left_out(PLATFORM, &reason);
            Ok(None)
        }
    }
}
