pub mod features;
pub mod fields;
pub mod measures;
pub mod parts;
pub mod presets;
pub mod sentence;
