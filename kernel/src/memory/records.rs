//! Records of contact in the caller's memory (`contact/`). Steps fill them anew: no image holds them.

use crate::body::pose::Vector;
use crate::ground::lanes::records;

records! {
    /// Candidate for contact: a node nearer to the projectile than a spacing.
    pub struct Candidate {
        /// Displacement at t_n, spacings.
        pub displacement: [f64; 3],
        /// Outward normal n, sheet's frame.
        pub normal: Vector,
        /// r x n in body axes, m: the arm of the impulse.
        pub arm: Vector,
        /// Number of the node.
        pub node: u32,
        /// Holder of the node, which takes its impulse and is not moved: a number of
        /// [`Holder`](crate::contact::candidate::Holder).
        pub held_by: u32,
        /// Multiplicity: nodes of the whole fabric that it stands for.
        pub multiplicity: f64,
        /// n.v at t_{n-1/2}, m/s.
        pub speed_before: f64,
        /// phi/dt, 0 for a node inside, until `add_free_velocity`; then phi/dt + n.v with the node's velocity
        /// v in this step before any impulse, m/s.
        pub free_gap_rate: f64,
        /// 1/(1/m + 1/M + arm.I^-1 arm), kg, without 1/m for a fixed node; 0 if neither has a compliance or
        /// the body cannot reach the node. With mirror planes the body's part is that of all images together.
        pub effective_mass: f64,
        /// Impulse, N s.
        pub impulse: f64,
    }

    /// Friction of a candidate.
    pub struct Tangential {
        /// Two unit vectors at right angles to the normal and to each other, sheet's frame.
        pub tangents: [Vector; 2],
        /// r x t of each in body axes, m: the arms of the impulses.
        pub arms: [Vector; 2],
        /// t.v at t_{n-1/2}, m/s.
        pub speed_before: [f64; 2],
        /// t.v with the node's velocity v in this step before any impulse, m/s.
        pub speed: [f64; 2],
        /// 1/W, kg; 0 if neither has a compliance.
        pub effective_mass: f64,
        /// Impulses on the node, N s.
        pub impulse: [f64; 2],
    }

    /// Node in a column of facing nodes.
    pub struct Node {
        /// Velocity along z before contact, spacings a step.
        pub before: f64,
        /// Velocity along z with friction's part, before and then after the plies' impulses, spacings a
        /// step.
        pub speed: f64,
        /// Distance by which it may come nearer to the node below in this step, spacings; infinite if they do
        /// not face each other.
        pub gap: f64,
        /// Sum of the gaps up to this node.
        pub offset: f64,
        /// Mass, over that of a node of the front fabric.
        pub mass: f64,
        /// Contact stiffness of a candidate: n_z^2 over its other compliance, over that of a node; with the
        /// sign of n_z. 0 of another node.
        pub stiffness: f64,
        /// Velocity along z of a candidate at which the projectile's impulse on it ends.
        pub release: f64,
        /// The projectile's impulse on it along z, in masses of a node and spacings a step.
        pub push: f64,
        /// Mass of its pool and positive stiffnesses in it, after `set_pool_stiffness`.
        pub pool_stiffness: f64,
        /// Velocity change of its pool, spacings a step, after `set_pool_velocity_change`.
        pub pool_velocity_change: f64,
    }

    /// Facing nodes that press on each other and move on together, with the projectile's impulses on them;
    /// velocities with the gaps added up.
    pub struct Pool {
        /// Velocities of the nodes, each with its mass, and of the release of pressed candidates, each with
        /// its stiffness.
        pub sum: f64,
        /// Masses, and stiffnesses of the pressed candidates.
        pub weight: f64,
        /// Common velocity, sum over weight.
        pub mean: f64,
        /// Range of the common velocity in which no other candidates are pressed.
        pub limits: [f64; 2],
        /// Number of its nodes.
        pub nodes: f64,
    }

    /// Contact of a node of a stack with the projectile: part of its candidate, and what the plies do to it.
    pub struct PlyContact {
        /// Outward normal n, sheet's frame.
        pub normal: Vector,
        /// r x n in body axes, m: the arm of the impulse.
        pub arm: Vector,
        /// Outward normal in the axes of its column.
        pub own_normal: [f64; 3],
        /// Gap rate without an impulse on node and body, m/s.
        pub free_gap_rate: f64,
        /// Normal impulse, N s.
        pub impulse: f64,
        /// Normal impulse before the column was solved last, N s.
        pub impulse_before: f64,
        /// Velocity along z that impulses give its node, m/s.
        pub velocity_change_z: f64,
        /// 1/m of its node, 1/kg.
        pub inverse_mass: f64,
        /// Compliance in addition to its column's along z, 1/kg.
        pub compliance: f64,
        /// Compliance of the body across the normal, with friction, 1/kg.
        pub compliance_across: f64,
        /// Number of its candidate.
        pub number: u32,
        /// Column of the sheet in which its node lies.
        pub column: u32,
        /// Row of the sheet.
        pub row: u32,
        /// Ply.
        pub ply: u32,
        /// Holder of the node, as of its candidate.
        pub held_by: u32,
        /// 1 if impulses along the surface have changed since the column that it leads was solved, else 0.
        pub stale: u32,
    }

    /// Friction of a contact of a stack.
    pub struct PlyFriction {
        /// Friction of its candidate, with the impulses so far.
        pub tangential: Tangential,
        /// Impulse as a function of the velocity of its node.
        pub spring: Spring,
        /// Under-relaxation of the impulses along the surface.
        pub relaxation: Relaxation,
    }

    /// Impulses of a candidate along its normal and its tangents, N s, as linear functions of the change of
    /// its node's velocity along z, m/s.
    pub struct Spring {
        /// Impulses without a change.
        pub base: [f64; 3],
        /// Derivative, kg.
        pub slope: [f64; 3],
        /// Impulses before a step of Newton's method, N s.
        pub before: [f64; 3],
        /// Change of the impulse on its node along z without a change of velocity, units of the column.
        pub push: f64,
        /// Decrease of that impulse for each change of velocity, units of the column.
        pub stiffness: f64,
    }

    /// Under-relaxation of a candidate's friction.
    pub struct Relaxation {
        /// Factor in (0, 1].
        pub factor: f64,
        /// Last increment before it, N s.
        pub increment: [f64; 2],
    }
}
