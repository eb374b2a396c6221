//! Outcomes: arrested, detached, exited, passed. They latch with their step and are never acted upon: the physics goes on.
//!
//! Method: tested when the step count is a multiple of 64. All but "passed" are armed by the first contact.
//! Detached is found by joining nodes over live segments into components (union by smaller number, path halving) and asking
//! whether any node touched in the last 64 steps is joined to a support.
//! Reference: R. E. Tarjan, J. ACM 22 (1975) 215 (disjoint sets).

use crate::pose::Vector;
use crate::projectile::Body;

/// Steps between two tests.
pub const TEST_INTERVAL: u64 = 64;
/// Work below this part of the first kinetic energy over a travel of R counts as "no contact" for "exited".
pub const NEGLIGIBLE_WORK: f64 = 1e-3;

/// An outcome that can latch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Outcome {
    /// The velocity along the direction at first contact fell to 0 or below.
    Arrested = 0,
    /// No node in contact during the last 64 steps is connected to a support any more.
    Detached = 1,
    /// Over a forward travel of one radius there was no contact impulse, or only negligible work.
    Exited = 2,
    /// The projectile left the sheet's box without contact.
    Passed = 3,
}

impl Outcome {
    /// All outcomes in the order of their numbers.
    pub const ALL: [Outcome; 4] = [Outcome::Arrested, Outcome::Detached, Outcome::Exited, Outcome::Passed];

    /// The bit of this outcome in a mask.
    pub fn bit(self) -> u32 {
        1 << self as u32
    }

    /// Name for tables.
    pub fn name(self) -> &'static str {
        match self {
            Outcome::Arrested => "arrested",
            Outcome::Detached => "detached",
            Outcome::Exited => "exited",
            Outcome::Passed => "passed",
        }
    }
}

/// When an outcome latched, and the work done until then.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Latch {
    /// Step count at the test.
    pub step: u64,
    /// Work of the projectile on the fabric until then, J.
    pub work: f64,
}

/// The first contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstContact {
    /// Step count at whose start the first impulse acted.
    pub step: u64,
    /// Unit direction of the velocity just before (zero if the body was at rest).
    pub direction: Vector,
    /// Kinetic energy just before, J (0 if the mass is unknown).
    pub kinetic_energy: f64,
}

/// Everything the outcome tests remember.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Watch {
    /// The first contact, if any.
    pub first: Option<FirstContact>,
    /// Position at the last checkpoint of "exited", m.
    pub checkpoint: Vector,
    /// Work at that checkpoint, J.
    pub checkpoint_work: f64,
    /// Nodal impulses counted at that checkpoint.
    pub checkpoint_impulses: u64,
    /// Latched outcomes by number.
    pub latched: [Option<Latch>; 4],
}

impl Watch {
    /// Nothing so far.
    pub const NOTHING: Watch = Watch {
        first: None,
        checkpoint: Vector::new(0.0, 0.0, 0.0),
        checkpoint_work: 0.0,
        checkpoint_impulses: 0,
        latched: [None; 4],
    };
}

/// What a test looks at.
#[derive(Clone, Copy, Debug)]
pub struct Sight<'a> {
    /// Step count.
    pub step: u64,
    /// The body.
    pub body: &'a Body,
    /// Work on the fabric so far, J.
    pub work: f64,
    /// Nodal impulses so far.
    pub impulses: u64,
    /// Radius of the projectile, m ([`crate::shape::Solid::radius`]).
    pub radius: f64,
    /// Distance from the centre to the farthest surface point, m.
    pub reach: f64,
    /// Half edge lengths of the sheet, m.
    pub half_size: [f64; 2],
}

impl Watch {
    /// Latches an outcome once.
    pub fn latch(&mut self, outcome: Outcome, step: u64, work: f64) {
        if let Some(slot @ None) = self.latched.get_mut(outcome as usize) {
            *slot = Some(Latch { step, work });
        }
    }

    /// Notes the first contact.
    pub fn touch(&mut self, step: u64, body: &Body, kinetic_energy: f64) {
        if self.first.is_none() {
            let v = body.velocity;
            let speed = crate::math::length([v.x, v.y, v.z]);
            let direction = if speed > 0.0 { v / speed } else { Vector::zeros() };
            self.first = Some(FirstContact { step, direction, kinetic_energy });
            self.checkpoint = body.position;
        }
    }

    /// The tests that need only the body. Called every 64 steps.
    pub fn test(&mut self, sight: &Sight<'_>) {
        let Some(first) = self.first else {
            if has_passed(sight) {
                self.latch(Outcome::Passed, sight.step, sight.work);
            }
            return;
        };
        if sight.body.velocity.dot(&first.direction) <= 0.0 {
            self.latch(Outcome::Arrested, sight.step, sight.work);
        }
        let travel = (sight.body.position - self.checkpoint).dot(&first.direction);
        if travel >= sight.radius {
            let work = sight.work - self.checkpoint_work;
            let size = if work < 0.0 { -work } else { work };
            let untouched = sight.impulses == self.checkpoint_impulses;
            let negligible = first.kinetic_energy > 0.0 && size <= NEGLIGIBLE_WORK * first.kinetic_energy;
            if untouched || negligible {
                self.latch(Outcome::Exited, sight.step, sight.work);
            }
            self.checkpoint = sight.body.position;
            self.checkpoint_work = sight.work;
            self.checkpoint_impulses = sight.impulses;
        }
    }

    /// Bits of all latched outcomes.
    pub fn mask(&self) -> u32 {
        Outcome::ALL.iter().zip(&self.latched).filter(|(_, latch)| latch.is_some()).map(|(o, _)| o.bit()).sum()
    }
}

/// Beyond the sheet's box, by the body's reach, in a direction in which it moves away.
fn has_passed(sight: &Sight<'_>) -> bool {
    let (p, v) = (sight.body.position, sight.body.velocity);
    let half = [sight.half_size[0], sight.half_size[1], 0.0];
    (0..3).any(|k| {
        let limit = half[k] + sight.reach;
        (p[k] > limit && v[k] > 0.0) || (p[k] < -limit && v[k] < 0.0)
    })
}

/// Disjoint sets over the nodes, in caller's memory.
pub struct Components<'a> {
    labels: &'a mut [u32],
}

impl<'a> Components<'a> {
    /// Every node by itself.
    pub fn new(labels: &'a mut [u32]) -> Components<'a> {
        for (k, label) in labels.iter_mut().enumerate() {
            *label = k as u32;
        }
        Components { labels }
    }

    /// The representative of a node's component.
    pub fn find(&mut self, node: usize) -> usize {
        let mut k = node;
        loop {
            let Some(&parent) = self.labels.get(k) else { return node };
            if parent as usize == k {
                return k;
            }
            let grandparent = self.labels.get(parent as usize).copied().unwrap_or(parent);
            if let Some(label) = self.labels.get_mut(k) {
                *label = grandparent;
            }
            k = grandparent as usize;
        }
    }

    /// Joins two nodes' components.
    pub fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.find(a), self.find(b));
        let (small, large) = if a < b { (a, b) } else { (b, a) };
        if let Some(label) = self.labels.get_mut(large) {
            *label = small as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_join() {
        let mut labels = [0; 6];
        let mut sets = Components::new(&mut labels);
        sets.join(4, 5);
        sets.join(1, 4);
        assert_eq!(sets.find(5), sets.find(1));
        assert_ne!(sets.find(0), sets.find(1));
        assert_eq!(sets.find(3), 3);
    }
}
