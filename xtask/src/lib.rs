//! What the commands share with the programs that they start, xtask-tables and xtask-binaries.
#![allow(missing_docs)] // For these programs only.

pub mod targets;
pub mod tools;
