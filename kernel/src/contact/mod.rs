//! Contact of nodes with the projectile, a ring's case, and each other; one line a module in the order of
//! calls.
//!
//! - `search`: candidates under the projectile, before the sweep; their free velocities after it.
//! - `candidate`: gap rate of a candidate; input and result of a solve.
//! - `backing`: places of a ring's case on which candidates are pressed.
//! - `edge`: candidates that the body gets past, set aside; calls the solver again if it meets them.
//! - `solve`: impulses on a single sheet, by sweeps.
//! - `friction`: Coulomb friction in these sweeps.
//! - `newton`: impulses where sweeps do not converge.
//! - `stack`: impulses on separate plies, by sweeps over columns.
//! - `by_column`: contacts of a stack sorted by column.
//! - `column`: velocities of one column under given springs.
//! - `column_friction`: columns of several candidates with friction.
//! - `laws`: residuals and the disc of friction, for all solvers.
//! - `apply`: effects of the impulses on body, nodes and sums.
//! - `separate`: plies that press on each other where no projectile is near, and after its impulses.

pub mod apply;
pub(crate) mod backing;
pub(crate) mod by_column;
pub mod candidate;
pub(crate) mod column;
pub(crate) mod column_friction;
pub mod edge;
pub mod friction;
pub(crate) mod laws;
pub(crate) mod newton;
pub mod search;
pub(crate) mod separate;
pub mod solve;
pub mod stack;
