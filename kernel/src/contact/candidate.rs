//! Candidates for contact; input and result of a solve for the impulses of all of them.
//!
//! Method: the gap of a convex body is linearised at t_n. With the normal n, the arm r x n and the free gap
//! rate phi/dt + n.v, the gap rate at body rates V, w is phi/dt + n.v - n.V - (r x n).w.
//! Limits: first order in dt where the body turns.
//! Reference: M. Jean, Comput. Methods Appl. Mech. Engrg. 177 (1999) 235.

use crate::body::projectile::{Body, Inertia, Twist};
use crate::memory::records::Candidate;
use crate::scene::parts::Symmetry;

/// Holder of a candidate's node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Holder {
    /// A free node.
    None = 0,
    /// The support that the node is fixed to.
    Support = 1,
    /// The case that the node is pressed on (`backing.rs`).
    Case = 2,
}

impl Candidate {
    /// Whether a support or the case holds the node.
    pub(crate) fn is_fixed(&self) -> bool {
        self.held_by != Holder::None as u32
    }

    /// Growth of the gap, with phi/dt, without an impulse on the node, m/s.
    pub(crate) fn gap_rate(&self, body: &Twist) -> f64 {
        self.free_gap_rate - self.normal.dot(&body.velocity) - self.arm.dot(&body.angular_velocity)
    }
}

/// Input of a solve in addition to the candidates.
#[derive(Clone, Copy)]
pub struct StepInputs<'s> {
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

/// Result of a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solved {
    /// Sweeps, with passes of Newton's method.
    pub sweeps: u32,
    /// Whether the laws hold to tolerance.
    pub converged: bool,
    /// Velocity of the body after contact.
    pub twist: Twist,
    /// Change of the fastest gap rate or slip by one more sweep, m/s; 0 if it converged in sweeps.
    pub residual: f64,
}
