//! The C interface of the fabric kernel: every `fk_*` function, its structures and constants. The header
//! `include/fabric_kernel.h` is made from this crate (`cargo xtask header`).
//!
//! Rules: every call returns a status (0 is success, negative numbers are errors, never reused); the caller owns all memory;
//! nothing is allocated or called back, and no pointer kept but for the block of `fk_init`, and the scratch of `fk_bands_begin` until
//! `fk_bands_end`; one simulation must not be used by two threads at once, but for its bands
//! (`fk_bands_pass`); different ones may.
#![no_std]
#![deny(missing_docs)]

#[cfg(test)]
extern crate std;

mod block;
pub mod calls;
#[cfg(feature = "capsule")]
pub mod capsule;
#[cfg(feature = "choose-instructions")]
pub mod instructions;
mod sizes;
pub mod types;

pub use block::{Lent, ToChange, ToLookAt, fk_sim};
pub use fabric_host::{Input, Output};
