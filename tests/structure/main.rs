//! The order of the sources: equations and where they are computed, files that import each other, and what a host may use.

mod equations;
mod floors;
mod surface;
