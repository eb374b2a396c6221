//! Loans of a C or FMI host for a call: pointers to read and to write ([`Input`], [`Output`]), and its
//! floating-point environment ([`in_our_environment`]). The C interface and the FMU both use it.
#![no_std]
#![deny(missing_docs)]

#[cfg(test)]
extern crate std;

mod float;
mod pointers;

pub use float::in_our_environment;
pub use pointers::{Input, Output};
