#[cfg(feature = "micro")]
pub mod calibrate;
#[cfg(feature = "micro")]
pub mod fibril;
pub mod law;
pub mod rate;
