//! The outcomes that can latch, and what their tests remember (`outcome.rs` has the tests).

use crate::body::pose::Vector;
use crate::body::projectile::Body;
use crate::ground::math;

/// An outcome that can latch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Outcome {
    /// The body moves into the sheet no more: neither towards its other side nor along the direction of
    /// flight at first contact, which a body at rest then takes later.
    Arrested = 0,
    /// No node in contact during the last 64 steps is connected to a support any more.
    Detached = 1,
    /// Contact is over and the body goes on to the other side: nothing in its way can still take work of note
    /// from it.
    Exited = 2,
    /// No contact, and none to come: the body leaves the sheet's box for good, and not on the side of a flat
    /// sheet from which it came.
    Passed = 3,
    /// Held yarn does not stop the body any more: the rule of docs/model.md, with its measured error. Only
    /// with `track_through`.
    Through = 4,
    /// Contact is over and the body leaves on the side from which it came: the sheet has stopped it.
    Rebounded = 5,
    /// An attachment as a whole has let go; only with `attachment.strength`.
    AttachmentFailed = 6,
}

impl Outcome {
    /// All outcomes in the order of their numbers.
    pub const ALL: [Outcome; 7] = [
        Outcome::Arrested,
        Outcome::Detached,
        Outcome::Exited,
        Outcome::Passed,
        Outcome::Through,
        Outcome::Rebounded,
        Outcome::AttachmentFailed,
    ];

    /// Name for tables.
    pub fn name(self) -> &'static str {
        match self {
            Outcome::Arrested => "arrested",
            Outcome::Detached => "detached",
            Outcome::Exited => "exited",
            Outcome::Passed => "passed",
            Outcome::Through => "through",
            Outcome::Rebounded => "rebounded",
            Outcome::AttachmentFailed => "attachment_failed",
        }
    }
}

/// Some of the outcomes; `Outcome::Arrested | Outcome::Exited` are two.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OutcomeSet(u32);

impl OutcomeSet {
    /// No outcome.
    pub const NONE: OutcomeSet = OutcomeSet(0);

    /// Outcomes that end a shot: arrested, exited, passed, rebounded.
    pub const ENDS: OutcomeSet = OutcomeSet(0b10_1101);

    /// The outcomes of these bits, bit 0 being the first of [`Outcome::ALL`]; others are not counted.
    pub const fn from_bits(bits: u32) -> OutcomeSet {
        OutcomeSet(bits & 0b111_1111)
    }

    /// A bit for each.
    pub const fn bits(self) -> u32 {
        self.0
    }

    /// Whether any of these, or this one, is among them.
    pub fn has(self, others: impl Into<OutcomeSet>) -> bool {
        self.0 & others.into().0 != 0
    }
}

impl From<Outcome> for OutcomeSet {
    fn from(outcome: Outcome) -> OutcomeSet {
        OutcomeSet(1 << outcome as u32)
    }
}

impl<T: Into<OutcomeSet>> core::ops::BitOr<T> for Outcome {
    type Output = OutcomeSet;

    fn bitor(self, other: T) -> OutcomeSet {
        OutcomeSet::from(self) | other
    }
}

impl<T: Into<OutcomeSet>> core::ops::BitOr<T> for OutcomeSet {
    type Output = OutcomeSet;

    fn bitor(self, other: T) -> OutcomeSet {
        OutcomeSet(self.0 | other.into().0)
    }
}

impl<T: Into<OutcomeSet>> core::ops::BitOrAssign<T> for OutcomeSet {
    fn bitor_assign(&mut self, other: T) {
        *self = *self | other;
    }
}

impl PartialEq<Outcome> for OutcomeSet {
    fn eq(&self, other: &Outcome) -> bool {
        *self == OutcomeSet::from(*other)
    }
}

impl FromIterator<Outcome> for OutcomeSet {
    fn from_iter<I: IntoIterator<Item = Outcome>>(outcomes: I) -> OutcomeSet {
        outcomes.into_iter().fold(OutcomeSet::NONE, |set, outcome| set | outcome)
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
    /// Where the travel began after which "through" is asked next, along the normal of the sheet, m.
    pub travel_start: f64,
    /// Velocity along that normal there, m/s.
    pub travel_speed: f64,
    /// Latched outcomes by number.
    pub latched: [Option<Latch>; Outcome::ALL.len()],
}

impl Watch {
    /// Watch before the first step.
    pub const NOTHING: Watch = Watch {
        first: None,
        checkpoint: Vector::new(0.0, 0.0, 0.0),
        checkpoint_work: 0.0,
        checkpoint_impulses: 0,
        travel_start: 0.0,
        travel_speed: 0.0,
        latched: [None; Outcome::ALL.len()],
    };

    /// Latches an outcome once, unless one that has latched excludes it: what the sheet has stopped does not
    /// get past it any more, and the other way round.
    pub fn latch(&mut self, outcome: Outcome, step: u64, work: f64) {
        let excluding = match outcome {
            Outcome::Exited => Outcome::Arrested | Outcome::Rebounded | Outcome::Passed,
            Outcome::Arrested | Outcome::Rebounded => Outcome::Exited | Outcome::Passed,
            _ => OutcomeSet::NONE,
        };
        if !self.mask().has(excluding)
            && let Some(slot @ None) = self.latched.get_mut(outcome as usize)
        {
            *slot = Some(Latch { step, work });
        }
    }

    /// Whether an outcome has latched.
    pub fn has(&self, outcome: Outcome) -> bool {
        self.latched.get(outcome as usize).is_some_and(|latch| latch.is_some())
    }

    /// Notes the first contact.
    pub fn note_contact(&mut self, step: u64, body: &Body, kinetic_energy: f64) {
        if self.first.is_none() {
            self.first = Some(FirstContact { step, direction: direction_of(&body.velocity), kinetic_energy });
            self.checkpoint = body.position;
        }
    }

    /// The direction in which the body goes into the fabric: that of its velocity just before the first
    /// contact or, if it was at rest then, of the first velocity that a test sees. Zero as long as it has
    /// none.
    pub(crate) fn direction(&mut self, velocity: &Vector) -> Vector {
        let Some(first) = &mut self.first else { return Vector::zeros() };
        if first.direction == Vector::zeros() {
            first.direction = direction_of(velocity);
        }
        first.direction
    }

    /// Bits of all latched outcomes.
    pub fn mask(&self) -> OutcomeSet {
        Outcome::ALL.into_iter().zip(&self.latched).filter(|(_, latch)| latch.is_some()).map(|(o, _)| o).collect()
    }
}

/// The unit vector along a velocity; zero for none.
fn direction_of(v: &Vector) -> Vector {
    let speed = math::length([v.x, v.y, v.z]);
    if speed > 0.0 { v / speed } else { Vector::zeros() }
}
