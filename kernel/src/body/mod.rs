pub mod path;
pub mod polyhedron;
pub mod pose;
pub mod prism;
pub mod projectile;
pub mod shape;
