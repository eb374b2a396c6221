//! Separate plies that push on each other: unilateral impulses between facing nodes, restitution zero, without friction between them.
//! Node (i, j) of a ply faces node (i, j) of the next one; masses are those of the fabrics, over that of a node of the front one.
//!
//! Limits: velocity Verlet, no mirror planes. Columns are not shared out among bands.

/// The nodes of one place in all plies.
mod column;
/// The projectile's impulses together with those of the plies.
mod joint;
/// The plies behind the sweep and those impulses.
mod part;

pub(crate) use joint::solve;
pub(crate) use part::part;
