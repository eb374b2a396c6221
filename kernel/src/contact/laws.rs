//! Laws of a contact, which all solvers share: how far impulses fail them, friction that sticks or slides,
//! and impulses scaled back.
//!
//! Method: an impulse along the normal is complementary to the gap rate, friction lies in the disc of
//! Coulomb's law. Impulses that were given up on are scaled back until they add no energy: a cone holds every
//! part of what it holds.
//! Limits: impulses are known, not sought; that is the solvers' work (`solve.rs`, `newton.rs`, `stack.rs`,
//! `column_friction.rs`).
//! Reference: M. Jean, Comput. Methods Appl. Mech. Engrg. 177 (1999) 235.

use crate::body::pose::Vector;
use crate::body::projectile::{Inertia, Twist};
use crate::contact::candidate::Solved;
use crate::ground::math;
use crate::memory::records::{Candidate, Tangential};

/// Violation of complementarity by a contact with this impulse along its normal, N s, and this gap rate, m/s.
pub(crate) fn violation(impulse: f64, gap_rate: f64) -> f64 {
    if impulse > 0.0 { math::abs(gap_rate) } else { math::max(-gap_rate, 0.0) }
}

/// Violation of Coulomb's law, m/s, by friction that would go from one impulse to the next at this effective
/// mass, kg.
pub(crate) fn slip_violation([p, q]: [f64; 2], next: [f64; 2], mass: f64) -> f64 {
    let change = math::max(math::abs(next[0] - p), math::abs(next[1] - q));
    if mass > 0.0 { change / mass } else { 0.0 }
}

/// Normal impulse that leaves no gap rate, m/s, at this effective mass, kg, or 0 if that would pull, N s.
#[inline(always)]
pub(crate) fn projected_normal(impulse: f64, gap_rate: f64, mass: f64) -> f64 {
    math::max(impulse - gap_rate * mass, 0.0)
}

/// Friction that leaves no slip, m/s, at this effective mass, kg, N s.
#[inline(always)]
pub(crate) fn trial_friction(impulse: [f64; 2], slip: [f64; 2], mass: f64) -> [f64; 2] {
    [impulse[0] - slip[0] * mass, impulse[1] - slip[1] * mass]
}

/// The nearest impulse of no more than this size, N s.
pub(crate) fn limited(impulse: [f64; 2], most: f64) -> [f64; 2] {
    let size = math::length([impulse[0], impulse[1], 0.0]);
    if size > most { impulse.map(|p| p * (most / size)) } else { impulse }
}

/// Energy that impulses given up on add at the most.
pub(crate) struct Gain {
    /// Velocity of the body before, and its changes.
    body: Twist,
    changes: [Vector; 2],
    /// Impulses times the relative speeds before, J.
    pub before: f64,
    /// Work of the impulses on what they change, J.
    pub change: f64,
}

impl Gain {
    /// Energy of the body alone, before any candidate is counted.
    pub fn of_body(body: Twist, inertia: &Inertia, solved: &Solved) -> Gain {
        let Twist { velocity, angular_velocity } = solved.twist;
        let (dv, dw) = (velocity - body.velocity, angular_velocity - body.angular_velocity);
        let moves = inertia.inverse_mass > 0.0;
        let change = if moves { inertia.mass * dv.dot(&dv) + dw.component_mul(&inertia.moments).dot(&dw) } else { 0.0 };
        Gain { body, changes: [dv, dw], before: 0.0, change }
    }

    /// Impulses of a candidate times its relative speeds before, J. With the gap's part of the speed this is
    /// an upper bound.
    pub fn work_before(&self, candidate: &Candidate, friction: Option<&Tangential>) -> f64 {
        let work = candidate.impulse * candidate.gap_rate(&self.body);
        friction.map_or(work, |t| work + t.work(t.slip(&self.body)))
    }

    /// Part of the impulses that adds no energy. A part x of them adds at most x before + x^2 change/2.
    fn part(&self) -> f64 {
        if self.before + 0.5 * self.change <= 0.0 {
            1.0
        } else if self.before < 0.0 {
            -2.0 * self.before / self.change * (1.0 - 8.0 * f64::EPSILON)
        } else {
            0.0
        }
    }

    /// Leaves the part of the candidates' impulses that adds no energy. Returns the rates of the body with
    /// it.
    pub fn scale_back(&self, candidates: &mut [Candidate], tangential: &mut [Tangential], solved: Solved) -> Solved {
        let (part, [dv, dw]) = (self.part(), self.changes);
        if part == 1.0 {
            return solved;
        }
        candidates.iter_mut().for_each(|candidate| candidate.impulse *= part);
        for t in tangential.iter_mut().take(candidates.len()) {
            t.impulse = t.impulse.map(|impulse| impulse * part);
        }
        let velocity = self.body.velocity + dv * part;
        Solved { twist: Twist { velocity, angular_velocity: self.body.angular_velocity + dw * part }, ..solved }
    }
}
