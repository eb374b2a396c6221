//! The FMU: FMI 2.0 and 3.0 co-simulation over the fabric kernel.
//!
//! One table of variables ([`table::VARIABLES`]) gives the getters, the setters, both model descriptions and
//! the [`token`].
//! One [`instance::Instance`] does the work. [`operations`] has what a host may ask of it, and in which
//! phases; [`fmi2`] and [`fmi3`] are the C functions with arguments.
//!
//! Pointers of a host cannot be checked here: null is refused, all else is as the host says. So the
//! exported functions are unsafe to Rust, while a C host makes its promise by calling. That trust stands in
//! [`Input`], [`Output`], [`calls::Handle`], [`calls::Text`] and the loggers of [`log`]; the functions
//! themselves have no unsafe code.
//!
//! Promises: memory comes from the C library's `calloc`, the large block once per instance when
//! initialisation ends; no allocation while stepping, no thread, no global state; the floating-point
//! environment of the host is saved, set and restored; a refused call says why in the log and changes
//! nothing.
#![no_std]
// Without the C functions not all is used that only they need.
#![cfg_attr(target_family = "wasm", allow(dead_code))]

#[cfg(test)]
extern crate std;

#[cfg(not(target_family = "wasm"))]
pub mod absent;
pub mod calls;
pub mod capsule;
pub mod coupling;
#[cfg(not(target_family = "wasm"))]
pub mod fmi2;
#[cfg(not(target_family = "wasm"))]
pub mod fmi3;
pub mod instance;
pub mod kept;
pub mod log;
mod memory;
pub mod operations;
pub mod parameters;
pub mod starts;
pub mod state;
pub mod table;
pub mod token;

pub use fabric_host::{Input, Output};
pub use memory::Owned;

/// Name of the model and of the library's file in both archives.
pub const MODEL_IDENTIFIER: &str = "FabricShield";
