//! Doing a capsule again, and comparing.
//!
//! Method: a call is done as it was; behind it the step count, the status of a failed one and, where the capsule has one, the digest of the
//! state are compared. The first difference ends it.

use crate::read::{call, record, words};
use crate::{Call, Capsule, Kind};
use core::fmt;
use fabric::{Error, Sim};

/// A capsule being replayed.
#[derive(Clone, Copy, Debug)]
pub struct Replay<'c> {
    rest: &'c [u8],
    start: u64,
    /// Steps of the present call that are still to be taken.
    left: Option<u64>,
    /// Calls done, and steps taken in them.
    pub calls: u64,
    /// Steps taken, of all calls together.
    pub steps: u64,
    /// Calls done and step count where a digest was last found equal.
    pub equal: (u64, u64),
    /// Digests found equal.
    pub digests: u64,
}

/// What was found by a part of a replay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// There is more to do.
    More,
    /// All of it was done and was equal.
    Same,
}

/// The first difference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Difference {
    /// Of the digests of the state: written, and found.
    Digest(u64, u64),
    /// Of the step counts behind a call.
    Steps(u64, u64),
    /// Of the status of a call, 0 or a failure's.
    Status(i64, i64),
    /// A call that was accepted is refused.
    Refused(Error),
    /// `room` is too short for a call's array, or a record is none.
    Room,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Difference::Digest(written, found) => write!(f, "the digest was {written:016x} and is {found:016x}"),
            Difference::Steps(written, found) => write!(f, "it ended at step {written} and ends at step {found}"),
            Difference::Status(written, found) => write!(f, "its status was {written} and is {found}"),
            Difference::Refused(error) => write!(f, "it was accepted and is refused: {error}"),
            Difference::Room => write!(f, "its array does not fit the room given"),
        }
    }
}

impl<'c> Replay<'c> {
    /// From the beginning, on a simulation of the capsule's scene at step 0.
    pub fn of(capsule: &Capsule<'c>) -> Replay<'c> {
        let rest = capsule.records;
        Replay { rest, start: capsule.start, left: None, calls: 0, steps: 0, equal: (0, 0), digests: 0 }
    }

    /// Does a record, of one with many steps at most `most` of them. room: as many numbers as [`Capsule::room`] says.
    ///
    /// # Errors
    /// The first difference; it is behind call `calls` (1: the first), at the simulation's step count, and behind [`Replay::equal`].
    pub fn next(&mut self, sim: &mut Sim<'_>, room: &mut [f64], most: u64) -> Result<Seen, Difference> {
        if self.digests == 0 {
            self.compare(self.start, sim)?;
        }
        let Ok(next) = record(self.rest) else { return Ok(Seen::Same) };
        match next.kind {
            Kind::Advance => {
                let [steps, status, behind] = words(next.content).ok_or(Difference::Room)?;
                if self.left.is_none() {
                    self.calls += 1;
                }
                let left = self.left.unwrap_or(steps);
                let now = left.min(most.max(1));
                let before = sim.step_count();
                let failure = Call::Advance(now).apply(sim).err();
                self.steps += sim.step_count().saturating_sub(before);
                if failure.is_none() && now < left {
                    self.left = Some(left - now);
                    return Ok(Seen::More);
                }
                self.left = None;
                let found = i64::from(failure.map_or(0, |error| error.code.number()));
                if status as i64 != found {
                    return Err(Difference::Status(status as i64, found));
                }
                if behind != sim.step_count() {
                    return Err(Difference::Steps(behind, sim.step_count()));
                }
            }
            Kind::Digest | Kind::End => {
                let [written] = words(next.content).ok_or(Difference::Room)?;
                self.compare(written, sim)?;
            }
            kind => {
                self.calls += 1;
                let call = call(kind, next.content, room).ok_or(Difference::Room)?;
                call.apply(sim).map_err(Difference::Refused)?;
            }
        }
        self.rest = next.rest;
        Ok(if self.rest.is_empty() { Seen::Same } else { Seen::More })
    }

    fn compare(&mut self, written: u64, sim: &Sim<'_>) -> Result<(), Difference> {
        let found = sim.digest();
        if written != found {
            return Err(Difference::Digest(written, found));
        }
        self.equal = (self.calls, sim.step_count());
        self.digests += 1;
        Ok(())
    }
}
