//! What the commands share with the program that they start, xtask-tables.
#![allow(missing_docs)] // For that program only.

pub mod platforms;
pub mod targets;
pub mod tools;
