//! The shared library's name for the dynamic linker, and that it needs nothing but the C library.

/// Goes up when a change breaks hosts that are already built; additions do not.
const GENERATION: u32 = 1;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let target = |name: &str| std::env::var(name).unwrap_or_default();
    if target("CARGO_CFG_TARGET_OS") == "linux" && target("CARGO_CFG_TARGET_ENV") == "gnu" {
        // rustc links without the default libraries; `defs` makes anything still undefined an error.
        for argument in [&format!("-Wl,-soname,libfabric_kernel.so.{GENERATION}"), "-lc", "-Wl,-z,defs"] {
            println!("cargo::rustc-cdylib-link-arg={argument}");
        }
    }
}
