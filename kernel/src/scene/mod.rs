pub mod features;
pub mod fields;
pub mod parts;
