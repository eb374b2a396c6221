//! The shared library of the FMU: it exports the `fmi2*` and `fmi3*` functions of `fabric-fmu` and nothing
//! else.
//!
//! Shipped form: `cargo build --profile ship -p fmu-lib --features bare`. With the feature `gate` a panic
//! that could be reached from an exported function becomes a link error.
#![no_std]

pub use fabric_fmu::{absent, fmi2, fmi3, operations};

// Without `bare` the standard library brings the one panic handler that every program needs.
#[cfg(not(feature = "bare"))]
extern crate std;

#[cfg(feature = "bare")]
mod bare {
    // Neither takes arguments or returns. With `gate` the function exists nowhere, which is the point.
    // rustc links without default libraries: without these lines there is no dependency on the C library.
    #[cfg_attr(target_os = "linux", link(name = "c"))]
    #[cfg_attr(target_os = "windows", link(name = "msvcrt"))]
    #[cfg_attr(target_os = "macos", link(name = "System"))]
    unsafe extern "C" {
        #[cfg(feature = "gate")]
        safe fn a_panic_is_reachable() -> !;
        #[cfg(not(feature = "gate"))]
        safe fn abort() -> !;
    }

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo) -> ! {
        #[cfg(feature = "gate")]
        a_panic_is_reachable();
        #[cfg(not(feature = "gate"))]
        abort();
    }

    // The precompiled core library names this symbol. Hidden and never called.
    #[cfg(target_os = "linux")]
    core::arch::global_asm!(".weak rust_eh_personality", ".hidden rust_eh_personality", "rust_eh_personality:");
}
