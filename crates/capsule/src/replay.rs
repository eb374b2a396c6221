//! Doing a capsule again, and comparing.
//!
//! Method: a call is done as it was; after it the step count, the status of a failed one and, where the capsule has one, the digest of the
//! state are compared. The first difference ends it.

use crate::read::{Record, call, record, words};
use crate::{Call, Capsule, Kind};
use core::fmt;
use fabric_kernel::{Error, Sim};

/// How far a replay is. All zeros: at the beginning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Replay {
    /// Bytes of records done.
    done: u64,
    /// Steps of the present call that were taken; its other ones are still to be taken.
    within: u64,
    /// Calls done, the present one counted.
    pub calls: u64,
    /// Steps taken, of all calls together.
    pub steps: u64,
    /// Digests found equal.
    pub digests: u64,
    /// Calls done where a digest was last found equal.
    pub equal_calls: u64,
    /// Step count where a digest was last found equal.
    pub equal_step: u64,
}

/// Result of a part of a replay.
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
    /// Digests of the state: written, and found.
    Digest(u64, u64),
    /// Step counts after a call: written, and found.
    Steps(u64, u64),
    /// Status of a call, 0 or a failure's: written, and found.
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

impl Replay {
    /// Does a record of a capsule, of one with many steps at most `most` of them. sim: of the capsule's scene, at step 0 where the replay
    /// begins. room: as many numbers as [`Capsule::room`] says.
    ///
    /// # Errors
    /// The first difference; it is after call `calls` (1: the first), at the simulation's step count.
    pub fn next(
        &mut self,
        capsule: &Capsule<'_>,
        sim: &mut Sim<'_>,
        room: &mut [f64],
        most: u64,
    ) -> Result<Seen, Difference> {
        if self.digests == 0 {
            self.compare(capsule.start, sim)?;
        }
        let Some(next) = self.record(capsule) else { return Ok(Seen::Same) };
        match next.kind {
            Kind::Advance => {
                let [steps, status, behind] = words(next.content).ok_or(Difference::Room)?;
                self.calls += u64::from(self.within == 0);
                let now = steps.saturating_sub(self.within).min(most.max(1));
                let before = sim.step_count();
                let failure = Call::Advance(now).apply(sim).err();
                self.steps += sim.step_count().saturating_sub(before);
                self.within += now;
                if failure.is_none() && self.within < steps {
                    return Ok(Seen::More);
                }
                self.within = 0;
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
        self.done = (capsule.records.len() - next.rest.len()) as u64;
        Ok(if next.rest.is_empty() { Seen::Same } else { Seen::More })
    }

    /// Whether what is to be done next takes steps.
    pub fn takes_steps(&self, capsule: &Capsule<'_>) -> bool {
        self.record(capsule).is_some_and(|next| next.kind == Kind::Advance)
    }

    fn record<'c>(&self, capsule: &Capsule<'c>) -> Option<Record<'c>> {
        record(capsule.records.get(self.done as usize..)?).ok()
    }

    fn compare(&mut self, written: u64, sim: &Sim<'_>) -> Result<(), Difference> {
        let found = sim.digest();
        if written != found {
            return Err(Difference::Digest(written, found));
        }
        (self.equal_calls, self.equal_step) = (self.calls, sim.step_count());
        self.digests += 1;
        Ok(())
    }
}
