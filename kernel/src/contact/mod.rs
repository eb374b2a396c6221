pub mod candidate;
pub mod friction;
pub(crate) mod newton;
pub mod solve;
pub mod stack;
