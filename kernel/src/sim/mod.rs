pub mod outputs;
pub mod simulation;
pub mod snapshot;
pub mod start;
