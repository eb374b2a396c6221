//! Robustness: what is refused and how, that a refusal writes nothing, that bits do not depend on how calls
//! are made, and that no input makes the kernel panic or lose its state in silence.
#![allow(clippy::disallowed_methods)] // A host program: std floats do no harm here.

mod allocation;
mod bands;
mod capacity;
mod codes;
mod failures;
mod inputs;
mod invariance;
mod memory;
mod poison;
mod refusals;
mod snapshots;
mod units;
