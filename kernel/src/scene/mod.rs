pub mod fields;
pub mod parts;
