pub mod error;
pub mod hash;
pub mod lanes;
pub mod math;
pub mod planes;
pub mod random;
pub mod ranges;
