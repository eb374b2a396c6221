//! Errors, in three kinds that are never mixed.
//!
//! - [`Error`]: the caller's request was refused; **nothing changed**. It names the code, the field and the
//!   value.
//! - [`Failure`]: the computation cannot go on; said at once and latched until reset or load.
//! - Outcomes (arrested, exited, ...) are physics, not errors: see [`crate::step::outcome`].

use crate::ground::math;
use core::ffi::CStr;

/// Codes: number, and text without a full stop.
macro_rules! codes {
    ($($(#[$about:meta])* $code:ident = $number:literal, $text:literal;)*) => {
        /// Status numbers of the C interface. 0 is success, -1..-49 preconditions, -50..-99 numerical
        /// failures. Never reused. `cargo xtask header` makes the constants of the C header, and their
        /// comments, from this list.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(i32)]
        pub enum Code {
            $($(#[$about])* $code = $number,)*
        }

        const CODES: [Code; [$($number),*].len()] = [$(Code::$code),*];
        const TEXTS: [(Code, &CStr, &str); CODES.len()] = [$((Code::$code, $text, words($text))),*];
    };
}

const fn words(text: &CStr) -> &str {
    if let Ok(words) = text.to_str() { words } else { "" }
}

codes! {
    /// A pointer is null.
    NullPointer = -1, c"null pointer";
    /// A buffer is shorter than the size query said.
    ShortBuffer = -2, c"buffer too short";
    /// A structure or an array does not lie at a multiple of what its numbers are aligned to.
    Misaligned = -3, c"structure or array not aligned";
    /// The block was moved or copied, or never initialised: use save and load instead.
    MovedBlock = -4, c"memory block moved, copied or not initialised";
    /// A structure has a size that no version this library knows gave it.
    StructSize = -5, c"structure of unknown size";
    /// A number is NaN or infinite.
    NotFinite = -6, c"not a finite number";
    /// A number must be greater than zero.
    NotPositive = -7, c"must be greater than zero";
    /// A number lies outside its documented range.
    OutOfRange = -8, c"out of range";
    /// A choice (kind of attachment, shape, ...) has an unknown number.
    UnknownChoice = -9, c"unknown choice";
    /// A quaternion has length zero or is far from unit length.
    BadQuaternion = -10, c"not a unit quaternion";
    /// The sheet has more nodes than memory can address.
    TooManyNodes = -11, c"too many nodes";
    /// The time step exceeds the largest allowed one; the fault's `limit` holds it.
    StepTooLarge = -12, c"time step too large";
    /// The parameters give a step limit that is zero, subnormal or not finite, or a step with which no
    /// calculation stays within the numbers: nodes of over 1e90 kg (N s, J at one spacing a step), or over a
    /// thousand times dt_crit.
    StepLimitUnusable = -13, c"parameters give no usable time step";
    /// A damage rate below 3 would make the yarn stiffer beyond the critical stretch than the step limit
    /// assumes.
    DamageRateTooSmall = -14, c"damage rate below 3";
    /// The projectile is lighter than one node of the sheet.
    ProjectileTooLight = -15, c"projectile lighter than a node";
    /// The projectile is smaller than the node spacing: nodes would not see it.
    ProjectileTooSmall = -16, c"projectile smaller than the node spacing";
    /// The projectile would cross more than one node spacing in a step, or turn more than half a radian: take
    /// a smaller step. Yarn that is soft or heavy allows steps so large that a usual speed is too fast for
    /// them. The fault's `limit` holds the largest step, s, with which the motion is accepted.
    ProjectileTooFast = -17, c"projectile crosses more than a node spacing in a step";
    /// A node lies inside the projectile at the start.
    InitialOverlap = -18, c"a node lies inside the projectile or within half of sheet.thickness; the sheet lies in z = 0 of sheet.position and sheet.orientation";
    /// The corner discs overlap one another.
    DiscsOverlap = -19, c"corner discs overlap";
    /// A corner disc reaches under the projectile.
    DiscTouchesProjectile = -20, c"a corner disc reaches under the projectile";
    /// An array does not have the length asked for.
    WrongLength = -21, c"array of the wrong length";
    /// The call does not fit the way the projectile is driven (free or prescribed).
    WrongDrive = -22, c"call does not fit the way the projectile is driven";
    /// A path does not start where the simulation is, or has no steps.
    BadPath = -23, c"path does not fit the simulation's time";
    /// The call is only allowed before the first step.
    AlreadyStarted = -24, c"only allowed before the first step";
    /// The bytes are not a snapshot image, or are truncated or altered.
    ImageMalformed = -25, c"no snapshot image, or an altered one";
    /// The image was made with another scene or another version.
    ImageOfAnotherScene = -26, c"snapshot image of another scene or version";
    /// The image has a correct checksum but holds values no simulation can have.
    ImageInvalid = -27, c"snapshot image holds impossible values";
    /// A normal is not of unit length (to 1e-6).
    BadNormal = -28, c"not a unit normal";
    /// The faces of a polyhedron do not enclose a body.
    UnboundedFaces = -29, c"faces do not enclose a body";
    /// Moments of inertia that no body has: one is greater than the other two together.
    ImpossibleMoments = -30, c"moments of inertia that no body has";
    /// Mirror planes with something they would change: a hit, a motion or a load off the planes.
    NotSymmetric = -31, c"not symmetric about the mirror planes";
    /// The scene asks for something this build was made without.
    NotBuilt = -32, c"needs the feature";
    /// A band that was called already in this pass, or a call that does not go with bands in use or without
    /// them.
    BandOutOfTurn = -33, c"band called out of turn, or bands (not) in use";
    /// The theta rule cannot be stepped in bands.
    NotInBands = -34, c"the theta rule cannot be stepped in bands";
    /// The corner discs lie between the nodes and hold none; the fault's `limit` holds the smallest radius,
    /// m, that reaches one.
    HoldsNothing = -35, c"an attachment that holds no node";
    /// Pre-tension that pulls at an edge which is not held, or at segments that are sampled one by one: the
    /// sheet would move by itself.
    NotInEquilibrium = -36, c"pre-tension without equilibrium: an edge that is not held, or segments sampled one by one";
    /// An option that does not go with another one, each of which is good by itself. The fault's text names
    /// both.
    DoesNotGoWith = -37, c"does not go with another field";
    /// Plies of a stack that start through each other: a node lies below the one that it faces in the ply
    /// before.
    PliesOverlap = -38, c"a node lies below the one that it faces in the ply before";
    /// The bytes are not a capsule, or are cut off, altered or of another format; or no capsule is being
    /// written.
    BadCapsule = -39, c"not a capsule, or one that is cut off or altered";
    /// A non-finite number appeared in the state, or a stretch beyond 1e25: the simulation is lost.
    NonFinite = -50, c"a non-finite number appeared in the state";
    /// More nodes came under the projectile than a `contact_capacity` other than 0 allows; the state is kept
    /// at the step's start.
    ContactCapacity = -51, c"more nodes under the projectile than contact_capacity";
    /// The projectile became faster than one node spacing in a step.
    TooFast = -52, c"the projectile became faster than a node spacing in a step";
    /// The theta rule's iteration did not converge; the state is kept at the step's start.
    NotConverged = -53, c"the iteration of a step did not converge; take a smaller step";
}

impl Code {
    /// Every code, for tables and tests.
    pub const ALL: [Code; CODES.len()] = CODES;

    /// Meaning of the code: one sentence fragment without a full stop.
    pub fn words(self) -> &'static str {
        TEXTS.iter().find(|row| row.0 == self).map_or("", |row| row.2)
    }

    /// Meaning of the code as a C string.
    pub fn text(self) -> &'static CStr {
        TEXTS.iter().find(|row| row.0 == self).map_or(c"", |row| row.1)
    }

    /// The number the C interface returns.
    pub const fn number(self) -> i32 {
        self as i32
    }
}

/// A request that was refused. Nothing changed.
#[derive(Clone, Copy, PartialEq)]
pub struct Error {
    /// Why.
    pub code: Code,
    /// The field's name as it is spelt in [`crate::scene::parts::Scene`], e.g. `sheet.spacing`; empty if no
    /// single field is to blame.
    pub field: &'static str,
    /// For [`Code::DoesNotGoWith`] the other field, for [`Code::NotBuilt`] the cargo feature, else the field
    /// that the limit follows from; empty if there is none.
    pub with: &'static str,
    /// The offending value, SI units (0 where none applies).
    pub value: f64,
    /// The limit that was crossed, SI units (0 where none applies). For [`Code::StepTooLarge`] the largest
    /// allowed step in s, for [`Code::ProjectileTooFast`] the largest step in s with which the motion is
    /// accepted.
    pub limit: f64,
}

impl Error {
    /// An error that names a field, the value found and the limit crossed.
    pub fn new(code: Code, field: &'static str, value: f64, limit: f64) -> Error {
        Error { code, field, with: "", value, limit }
    }

    /// An error without a value.
    pub fn plain(code: Code, field: &'static str) -> Error {
        Error::new(code, field, 0.0, 0.0)
    }

    /// The refusal of two fields that are good by themselves.
    pub fn beside(field: &'static str, with: &'static str) -> Error {
        Error { with, ..Error::plain(Code::DoesNotGoWith, field) }
    }

    /// Error with the field that its limit follows from.
    pub(crate) fn from(self, with: &'static str) -> Error {
        Error { with, ..self }
    }

    /// The refusal of what this build does not have; `feature`: the cargo feature that has it.
    pub fn not_built(field: &'static str, feature: &'static str) -> Error {
        Error { with: feature, ..Error::plain(Code::NotBuilt, field) }
    }
}

/// The computation cannot go on. Latched: every call but reset, load and the counters repeats it. Of a sheet
/// that is stepped in blocks (`step/blocks.rs`) some rows are then ahead of the step's start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// A non-finite number appeared; the state is lost. Load a snapshot or reset.
    NonFinite,
    /// More candidate nodes than a `contact_capacity` other than 0; the state is that of the step's start.
    /// Raise the capacity.
    ContactCapacity,
    /// The projectile became faster than one node spacing in a step (an external load can do this).
    TooFast,
    /// The theta rule's iteration did not converge; the state is that of the step's start. Take a smaller
    /// step.
    NotConverged,
}

impl Failure {
    /// The status number's code.
    pub fn code(self) -> Code {
        match self {
            Failure::NonFinite => Code::NonFinite,
            Failure::ContactCapacity => Code::ContactCapacity,
            Failure::TooFast => Code::TooFast,
            Failure::NotConverged => Code::NotConverged,
        }
    }
}

impl From<Failure> for Error {
    fn from(failure: Failure) -> Error {
        Error::plain(failure.code(), "")
    }
}

impl core::fmt::Display for Failure {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.code().words())
    }
}

impl core::error::Error for Failure {}

/// Refuses NaN and infinities.
pub(crate) fn finite(field: &'static str, value: f64) -> Result<(), Error> {
    if value.is_finite() { Ok(()) } else { Err(Error::new(Code::NotFinite, field, value, 0.0)) }
}

/// Refuses a vector with a NaN or infinite component.
pub(crate) fn finite3(field: &'static str, v: [f64; 3]) -> Result<(), Error> {
    v.iter().try_for_each(|&x| finite(field, x))
}

/// Refuses everything but finite numbers greater than zero.
pub(crate) fn positive(field: &'static str, value: f64) -> Result<(), Error> {
    finite(field, value)?;
    if value > 0.0 { Ok(()) } else { Err(Error::new(Code::NotPositive, field, value, 0.0)) }
}

/// Refuses everything but finite numbers that are zero or greater.
pub(crate) fn not_negative(field: &'static str, value: f64) -> Result<(), Error> {
    finite(field, value)?;
    if value >= 0.0 { Ok(()) } else { Err(Error::new(Code::OutOfRange, field, value, 0.0)) }
}

/// Refuses a quaternion whose length differs from 1 by 1e-3 or more.
pub(crate) fn unit_quaternion(field: &'static str, q: [f64; 4]) -> Result<(), Error> {
    q.iter().try_for_each(|&x| finite(field, x))?;
    let length = math::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    let off = length - 1.0;
    if off < 1e-3 && off > -1e-3 { Ok(()) } else { Err(Error::new(Code::BadQuaternion, field, length, 1.0)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// That no two have one number the compiler sees to.
    #[test]
    fn every_code_has_a_text_and_a_number_in_the_range() {
        for code in Code::ALL {
            assert!((-99..=-1).contains(&code.number()) && !code.words().is_empty(), "{code:?}");
        }
    }
}
