pub mod friction;
pub mod solve;
pub mod stack;
