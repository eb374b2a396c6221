//! A candidate for contact, as it lies in the scratch block, and what a solve for the impulses of all of them
//! is given and returns.

use crate::body::pose::Vector;
use crate::body::projectile::{Body, Inertia};
use crate::memory::layout::CANDIDATE_REALS;
use crate::scene::parts::Symmetry;

/// How many nodes of the whole fabric a candidate stands for, and whether its support holds it: one number,
/// as it lies in the scratch block, with the sign minus for a fixed node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Images(f64);

impl Images {
    /// A free node that stands for itself, as all do without mirror planes and grading.
    pub const ITSELF: Images = Images(1.0);

    /// Multiplicity of a node that stands for so many.
    pub fn of(count: f64, fixed: bool) -> Images {
        Images(if fixed { -count } else { count })
    }
}

/// One candidate node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Candidate {
    /// Displacement at t_n, spacings.
    pub displacement: [f64; 3],
    /// Outward normal in the sheet's frame.
    pub normal: Vector,
    /// r x n in body axes, m: the arm of the impulse.
    pub arm: Vector,
    /// What it stands for.
    pub images: Images,
    /// n.v at t_{n-1/2}, m/s.
    pub speed_before: f64,
    /// phi/dt + n.v with the node's velocity v in this step before any impulse, m/s.
    pub approach: f64,
    /// 1/(1/m + 1/M + arm.I^-1 arm), kg, without 1/m for a fixed node, 0 if nothing gives way or the body
    /// cannot reach it; with mirror planes the body's part is that of all images together.
    pub effective_mass: f64,
    /// Impulse, N s.
    pub impulse: f64,
}

impl Candidate {
    /// From its place in the scratch block.
    pub fn read(slot: &[f64; CANDIDATE_REALS]) -> Candidate {
        let [ux, uy, uz, nx, ny, nz, ax, ay, az, images, speed_before, approach, effective_mass, impulse] = *slot;
        Candidate {
            displacement: [ux, uy, uz],
            normal: Vector::new(nx, ny, nz),
            arm: Vector::new(ax, ay, az),
            images: Images(images),
            speed_before,
            approach,
            effective_mass,
            impulse,
        }
    }

    /// Into its place in the scratch block.
    pub fn write(&self, slot: &mut [f64; CANDIDATE_REALS]) {
        let ([ux, uy, uz], n, a) = (self.displacement, self.normal, self.arm);
        *slot = [
            ux,
            uy,
            uz,
            n.x,
            n.y,
            n.z,
            a.x,
            a.y,
            a.z,
            self.images.0,
            self.speed_before,
            self.approach,
            self.effective_mass,
            self.impulse,
        ];
    }

    /// Whether its support holds the node: nothing moves it, and the support takes the impulse.
    pub fn is_fixed(&self) -> bool {
        self.images.0 < 0.0
    }

    /// How many nodes of the whole fabric it stands for.
    pub fn images(&self) -> f64 {
        if self.is_fixed() { -self.images.0 } else { self.images.0 }
    }

    /// How fast the gap grows, with phi/dt, as long as the body has these rates, m/s.
    pub fn gap_rate(&self, velocity: &Vector, rate: &Vector) -> f64 {
        self.approach - self.normal.dot(velocity) - self.arm.dot(rate)
    }
}

/// Sets the impulse of a candidate in its place, N s.
pub(crate) fn set_impulse([.., place]: &mut [f64; CANDIDATE_REALS], impulse: f64) {
    *place = impulse;
}

/// Sets the effective mass of a candidate in its place, kg.
pub(crate) fn set_mass([.., place, _]: &mut [f64; CANDIDATE_REALS], mass: f64) {
    *place = mass;
}

/// A candidate before its velocity in this step is known. It is kept in the place of the candidate that it
/// becomes.
pub(crate) struct FoundCandidate {
    /// phi/dt, m/s; 0 for a node inside.
    pub gap_over_dt: f64,
    candidate: Candidate,
}

impl FoundCandidate {
    /// From its place in the scratch block.
    pub fn read(slot: &[f64; CANDIDATE_REALS]) -> FoundCandidate {
        let candidate = Candidate::read(slot);
        FoundCandidate { gap_over_dt: candidate.approach, candidate }
    }

    /// The candidate with the node's velocity v, in units of `unit_speed`, m/s.
    pub fn with_velocity(&self, v: &Vector, unit_speed: f64) -> Candidate {
        let candidate = &self.candidate;
        Candidate { approach: self.gap_over_dt + candidate.normal.dot(v) * unit_speed, ..*candidate }
    }
}

/// A candidate as a solve begins, before its effective mass is known. It is kept in the place of the
/// candidate that it becomes.
pub(crate) struct Begun {
    /// How fast its gap grows before contact, m/s.
    pub gap_rate: f64,
    pub candidate: Candidate,
}

impl Begun {
    /// From its place in the scratch block.
    pub fn read(slot: &[f64; CANDIDATE_REALS]) -> Begun {
        let candidate = Candidate::read(slot);
        Begun { gap_rate: candidate.effective_mass, candidate }
    }

    /// Begins without impulse.
    pub fn begin([.., kept, impulse]: &mut [f64; CANDIDATE_REALS], gap_rate: f64) {
        (*kept, *impulse) = (gap_rate, 0.0);
    }
}

/// What a solve is given in addition to the candidates.
#[derive(Clone, Copy)]
pub struct Given<'s> {
    /// The body, with its rates before contact.
    pub body: &'s Body,
    /// How it gives way.
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
    /// Sweeps taken.
    pub sweeps: u32,
    /// false if the sweeps ran out.
    pub converged: bool,
    /// Body velocity after contact.
    pub velocity: Vector,
    /// Body angular velocity after contact, body axes.
    pub angular_velocity: Vector,
    /// What one more sweep would change of the fastest gap rate or slip, m/s; 0 if it converged in sweeps.
    pub residual: f64,
}
