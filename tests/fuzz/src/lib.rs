//! What fuzzing tries: functions of a byte string that assert what the libraries promise for any input.
//!
//! Each target's `run` decodes its bytes into something that is mostly sound and partly odd (random bytes
//! alone would be refused at the first check), makes the calls, and asserts what must hold. It returns
//! whether a simulation came of it and took a step: the share of inputs that got past the first check.
//! [`fuzz_targets`](../../fuzz_targets) hands the functions to libFuzzer; `tests/replay.rs` runs the
//! committed corpora through them without it.

pub mod bytes;
pub mod calls;
pub mod capsule;
pub mod fmi;
pub mod image;
pub mod memory;
pub mod scene;
pub mod small;
pub mod tally;

/// A fuzz target: its name, which is that of its archive in `corpus`, and its function.
pub type Target = (&'static str, fn(&[u8]) -> bool);

/// Every target.
pub const TARGETS: &[Target] = &[
    ("scene", scene::run),
    ("image", image::run),
    ("capsule", capsule::run),
    ("calls", calls::run),
    ("fmi", fmi::run),
];
