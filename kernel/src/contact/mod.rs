pub mod book;
pub mod candidate;
pub mod friction;
pub(crate) mod newton;
pub mod passage;
pub mod search;
pub mod solve;
pub mod stack;
