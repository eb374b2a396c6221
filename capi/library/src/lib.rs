//! libfabric_kernel: exports the `fk_*` functions of `fabric-capi` and nothing else.
//!
//! Shipped form: `cargo build --profile ship -p capi-lib --features bare`. With the feature `gate` a panic that could be
//! reached from an exported function becomes a link error.
#![no_std]

pub use fabric_capi::calls;
#[cfg(feature = "capsule")]
pub use fabric_capi::capsule;
#[cfg(feature = "choose-instructions")]
pub use fabric_capi::instructions;

// Without `bare` the standard library brings the one panic handler that every program needs.
#[cfg(not(feature = "bare"))]
extern crate std;

#[cfg(feature = "bare")]
mod bare {
    #[cfg(feature = "gate")]
    unsafe extern "C" {
        fn a_panic_is_reachable() -> !;
    }

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo) -> ! {
        // SAFETY: takes no arguments and does not return. The function exists nowhere, which is the point of the gate.
        #[cfg(feature = "gate")]
        unsafe {
            a_panic_is_reachable()
        }
        // Never reached: the gate shows it. There is no C library to call on a bare machine.
        #[cfg(not(feature = "gate"))]
        loop {
            core::hint::spin_loop();
        }
    }

    // The precompiled core library names this symbol. Hidden and never called.
    #[cfg(target_os = "linux")]
    core::arch::global_asm!(".weak rust_eh_personality", ".hidden rust_eh_personality", "rust_eh_personality:");
}
