//! The order of the sources: equations and where they are computed, and files that import each other.

mod equations;
mod floors;
