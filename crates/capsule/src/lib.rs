//! A capsule: a log of everything that a host does to a simulation, which anyone can replay and compare bit by bit.
//!
//! [`Log`] writes it into a [`Sink`] of the caller's while the host works; [`Capsule`] reads it and [`Replay`] does it again. Nothing is
//! allocated, and a simulation without a log does nothing for it.
//!
//! # Format, version 1
//! Little-endian. First `FKCAPSUL` and the version, 4 bytes. Then records: kind, 1 byte; length of the content, 4 bytes; content; check,
//! 8 bytes, [`fabric_kernel::Hash`] of all bytes of the file so far but for the checks. Numbers have 8 bytes, real ones IEEE 754.
//!
//! | kind | record | content |
//! |---|---|---|
//! | 1 | origin | stride of the digests in calls, version of the kernel as text |
//! | 2 | number | a parameter that is not as in the 3 in preset: length of its name, 1 byte, name, its elements as 64 bits |
//! | 3 | start | digest of step 0 |
//! | 4 | advance | steps asked for, status, step count after it |
//! | 5 | path | first step, steps, end pose and rates (13 numbers), steps to come |
//! | 6 | external load | force, torque |
//! | 7 | motion | positions, then velocities |
//! | 8 | largest stretch | one a segment |
//! | 9 | load | an image |
//! | 10 | reset | |
//! | 11 | digest | digest after the call before |
//! | 12 | end | digest |
//!
//! Limits: a check protects against accidents, not against an attacker; a log cannot see what is done to the simulation past it.
#![no_std]
#![deny(missing_docs, unsafe_code)]

#[cfg(feature = "std")]
mod file;
mod log;
mod read;
mod replay;

#[cfg(feature = "std")]
pub use file::File;
pub use log::{Log, Sink, run};
pub use read::{Broken, Capsule, What};
pub use replay::{Difference, Replay, Seen};

use fabric_kernel::{Error, Hash, Motion, Path, Sim};

/// Version of the format.
pub const FORMAT: u32 = 1;
const MAGIC: u64 = u64::from_le_bytes(*b"FKCAPSUL");
/// Kind and length of a record, and its check, bytes.
const HEAD: usize = 5;
const CHECK: usize = 8;

/// Kind of a record: its number in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
enum Kind {
    Origin = 1,
    Number,
    Start,
    Advance,
    Path,
    ExternalLoad,
    Motion,
    LargestStretch,
    Load,
    Reset,
    Digest,
    End,
}

const KINDS: [Kind; 12] = [
    Kind::Origin,
    Kind::Number,
    Kind::Start,
    Kind::Advance,
    Kind::Path,
    Kind::ExternalLoad,
    Kind::Motion,
    Kind::LargestStretch,
    Kind::Load,
    Kind::Reset,
    Kind::Digest,
    Kind::End,
];

/// A call that changes a simulation. [`Sim::advance_until`] is an `Advance` by the steps that it took, [`Sim::follow`] a `Path` and an
/// `Advance`, bands an `Advance`; [`Sim::use_instructions`] does not change bits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Call<'a> {
    /// [`Sim::advance`]: steps.
    Advance(u64),
    /// [`Sim::start_path`]: the path, and the steps to come.
    Path(Path, u64),
    /// [`Sim::set_external_load`]: force, N, and torque, N m.
    ExternalLoad([f64; 3], [f64; 3]),
    /// [`Sim::set_motion`]: positions, m, and velocities, m/s.
    Motion(&'a [f64], &'a [f64]),
    /// [`Sim::set_largest_stretch`].
    LargestStretch(&'a [f64]),
    /// [`Sim::load`]: an image.
    Load(&'a [u8]),
    /// [`Sim::reset`].
    Reset,
}

impl Call<'_> {
    /// Does it.
    ///
    /// # Errors
    /// Errors of the call.
    #[inline(always)] // A call that is known costs no stack for others.
    pub fn apply(&self, sim: &mut Sim<'_>) -> Result<(), Error> {
        match self {
            Call::Advance(steps) => sim.advance(*steps)?,
            Call::Path(path, steps) => sim.start_path(path, *steps)?,
            Call::ExternalLoad(force, torque) => sim.set_external_load(*force, *torque)?,
            Call::Motion(positions, velocities) => sim.set_motion(positions, velocities)?,
            Call::LargestStretch(stretches) => sim.set_largest_stretch(stretches)?,
            Call::Load(image) => sim.load(image)?,
            Call::Reset => sim.reset(),
        }
        Ok(())
    }
}

/// The running check of a file.
#[derive(Clone, Copy, Default)]
struct Check(Hash);

impl Check {
    fn take(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| self.0.word(u64::from(*byte)));
    }
}

/// The numbers of a motion, in the order of the file.
fn numbers_of(motion: &Motion) -> [f64; 13] {
    let [[x, y, z], [u, v, w]] = [motion.position, motion.velocity];
    let ([a, b, c, d], [p, q, r]) = (motion.orientation, motion.angular_velocity);
    [x, y, z, u, v, w, a, b, c, d, p, q, r]
}

/// The motion of such numbers.
fn motion_of([x, y, z, u, v, w, a, b, c, d, p, q, r]: [f64; 13]) -> Motion {
    Motion { position: [x, y, z], velocity: [u, v, w], orientation: [a, b, c, d], angular_velocity: [p, q, r] }
}
