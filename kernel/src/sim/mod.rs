pub mod fingerprint;
pub mod outputs;
pub(crate) mod restore;
pub mod simulation;
pub mod snapshot;
pub mod start;
