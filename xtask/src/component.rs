//! The FMU's component for WebAssembly (`fmu/wasm`), for archives of FMI 3.0.

use crate::platforms::{beside_our_compiler, compiler_for};
use crate::tools::{Outcome, left_out, said, target};
use std::path::PathBuf;

/// Target of the component.
pub const PLATFORM: &str = "wasm32-wasip2";

/// Builds it, if all it needs is here.
pub fn build_if_ready() -> Outcome<Option<PathBuf>> {
    let ready = compiler_for(PLATFORM).and_then(|compiler| Ok((compiler, beside_our_compiler("wasm-component-ld")?)));
    let (compiler, linker) = match ready {
        Ok(ready) => ready,
        Err(reason) => {
            left_out(PLATFORM, &reason.to_string());
            return Ok(None);
        }
    };
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| std::env::home_dir().map(|home| home.join(".cargo"))).unwrap_or_default();
    let folder = target().join("cross");
    // Vectors of two numbers. The same source gives the same bytes: places in the code of others are named by
    // this.
    let flags = format!(
        "-Ctarget-feature=+simd128 --remap-path-prefix={}=/cargo -Clink-arg=--wasm-ld-path={}",
        home.display(),
        linker.with_file_name("gcc-ld/wasm-ld").display()
    );
    let command = compiler.command("build").args(["-p", "fmu-wasm", "--target", PLATFORM, "--target-dir"]).arg(&folder);
    let command = command.args(compiler.options("core,alloc")).env("CARGO_TARGET_WASM32_WASIP2_LINKER", &linker);
    let command = command.env("CARGO_TARGET_WASM32_WASIP2_RUSTFLAGS", flags);
    said("Compiling the FMU's component for WebAssembly", || Ok(command.run()?))?;
    Ok(Some(folder.join(PLATFORM).join("ship/fabric_shield_component.wasm")))
}
