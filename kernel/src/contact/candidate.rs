//! Candidates for contact, and what a solve for the impulses of all of them is given and returns.

use crate::body::projectile::{Body, Inertia, Twist};
use crate::memory::records::Candidate;
use crate::scene::parts::Symmetry;

impl Candidate {
    /// Whether its support holds the node.
    pub(crate) fn is_fixed(&self) -> bool {
        self.fixed != 0
    }

    /// Growth of the gap, with phi/dt, without an impulse on the node, m/s.
    pub(crate) fn gap_rate(&self, body: &Twist) -> f64 {
        self.free_gap_rate - self.normal.dot(&body.velocity) - self.arm.dot(&body.angular_velocity)
    }
}

/// What a solve is given in addition to the candidates.
#[derive(Clone, Copy)]
pub struct Given<'s> {
    /// The body, with its velocity before contact.
    pub body: &'s Body,
    /// Inertia of the body.
    pub inertia: &'s Inertia,
    /// Mass of a free node, kg.
    pub node_mass: f64,
    /// Mirror planes.
    pub symmetry: Symmetry,
    /// Coefficient of friction.
    pub friction: f64,
}

/// What a solve did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solved {
    /// Sweeps, with passes of Newton's method.
    pub sweeps: u32,
    /// Whether the laws hold to tolerance.
    pub converged: bool,
    /// Velocity of the body after contact.
    pub twist: Twist,
    /// What one more sweep would change of the fastest gap rate or slip, m/s; 0 if it converged in sweeps.
    pub residual: f64,
}
