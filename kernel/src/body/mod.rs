pub mod path;
pub mod polyhedron;
pub mod pose;
pub mod projectile;
pub(crate) mod sector;
pub mod shape;
