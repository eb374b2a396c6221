//! Capsules: a log of what the host does to a simulation, in the host's memory, and its replay.
//!
//! # Safety of all functions here
//! As in `calls.rs`.
#![allow(clippy::missing_safety_doc)] // said once, there

use crate::block::{self, Lent, ToChange, Window, fk_sim};
use crate::calls::{array, array_mut, put_number, status};
use crate::sizes::{Part, put_scene, read_to_change};
use crate::types::*;
use fabric_capsule::{Broken, Capsule, Difference, Log, Seen, What};
use fabric_host::{Input, Output, in_our_environment};
use fabric_kernel::{Code, Error};

/// Puts the simulation back to step 0, and writes every call that changes it from there on into `memory`: a capsule, which fk_replay,
/// `fabric replay` and the page do again and compare. A capsule that was being written is dropped. `memory` must not be used by anything
/// else until fk_capsule_end. `stride`: calls from one digest of the state to the next, at least 1; a digest takes about as long as a step,
/// and a replay can say no closer than that where the first difference is.
/// Threads: changes. Time: two passes over the sheet. Touches: the block and `memory`.
/// Errors: FK_NULL_POINTER, FK_WRONG_LENGTH (`bytes` is more than memory can have), FK_MOVED_BLOCK.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_capsule_begin(mut sim: ToChange, memory: Lent, bytes: u64, stride: u64) -> i32 {
    let begin = || {
        let window = Window::of(memory, bytes)?;
        let block = block::open(&mut sim)?;
        block.last = None;
        block.capsule = Some(in_our_environment(|| Log::begin(&mut block.sim, stride, window)));
        Ok(())
    };
    status(begin())
}

/// Hands over what has been written since fk_capsule_begin or the last call of this: `used` bytes at the start of the memory, to be kept
/// after those before; the next call writes to the start again. A call of the host's takes some 30 bytes, a digest 21, fk_set_motion and
/// fk_state_load what they are given.
/// Threads: changes. Time: constant. Touches: the block and `used`.
/// Errors: FK_SHORT_BUFFER (the memory was full: the last record may be cut off, and nothing more is written), FK_NULL_POINTER, FK_BAD_CAPSULE
/// (none is being written), FK_MOVED_BLOCK.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_capsule_take(mut sim: ToChange, mut used: Output<u64>) -> i32 {
    status(block::open(&mut sim).and_then(|block| take(block, &mut used)))
}

/// Ends a capsule with a digest, and hands over the rest of it as fk_capsule_take does. After a failure, too.
/// Threads: changes. Time: a pass over the sheet. Touches: the block, `used` and the memory, which is the host's again.
/// Errors: those of fk_capsule_take.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_capsule_end(mut sim: ToChange, mut used: Output<u64>) -> i32 {
    let mut end = || {
        let block = block::open(&mut sim)?;
        if let Some(capsule) = &mut block.capsule {
            in_our_environment(|| capsule.end(&block.sim));
        }
        let taken = take(block, &mut used);
        block.capsule = None;
        taken
    };
    status(end())
}

fn take(block: &mut fk_sim, used: &mut Output<u64>) -> Result<(), Error> {
    let capsule = block.capsule.as_mut().ok_or(Error::plain(Code::BadCapsule, "sim"))?;
    let whole = capsule.is_whole();
    put_number(used, "used", core::mem::take(&mut capsule.sink_mut().used) as u64)?;
    if whole { Ok(()) } else { Err(Error::plain(Code::ShortBuffer, "memory")) }
}

/// Reads a capsule of `bytes` bytes through: its scene, for fk_init, and what is in it. Nothing of the scene is checked but that it is one.
/// Threads: any. Time: a pass over the bytes. Touches: `scene`, of `struct_size` bytes, and `about`; nothing on an error but `about`,
/// whose `broken_at` and `whole` say where the capsule is broken and how many bytes before that can be read as a capsule.
/// Errors: FK_BAD_CAPSULE (none, cut off, altered, or of another format), FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_WRONG_LENGTH.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_capsule_read(
    capsule: Input<u8>,
    bytes: u64,
    mut scene: Output<fk_scene>,
    struct_size: u64,
    mut about: Output<fk_capsule>,
    size: u64,
) -> i32 {
    let mut read = || {
        let bytes = array(&capsule, bytes, "capsule")?;
        let part = Part::of(&mut about, size)?;
        match Capsule::open(bytes) {
            Ok(found) => {
                put_scene_of(&found, &mut scene, struct_size)?;
                part.put(&fk_capsule {
                    calls: found.calls,
                    steps: found.steps,
                    stride: found.stride,
                    room: found.room() as u64,
                    ended: u64::from(found.ended),
                    broken_at: 0,
                    whole: bytes.len() as u64,
                });
                Ok(())
            }
            Err(broken) => {
                let Broken { at, whole, .. } = broken;
                part.put(&fk_capsule { broken_at: at as u64, whole: whole as u64, ..fk_capsule::default() });
                Err(bad(broken))
            }
        }
    };
    status(read())
}

/// Does a part of a capsule again, at most `steps` steps, on a simulation of its scene, and compares: with a `replay` of zeros from the
/// beginning, with that of the call before from there on. `room`: as many numbers as fk_capsule_read says, for arrays of calls; null if 0.
/// Threads: changes. Time: `steps` steps, and a pass over the bytes. Touches: the block, `room`, `replay`. It needs 5 kB of stack.
/// Errors: FK_BAD_CAPSULE, FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_WRONG_LENGTH, FK_MOVED_BLOCK. A difference is none: it is
/// said by `replay`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fk_replay(
    mut sim: ToChange,
    capsule: Input<u8>,
    bytes: u64,
    steps: u64,
    mut room: Output<f64>,
    n: u64,
    mut replay: Output<fk_replayed>,
    size: u64,
) -> i32 {
    let mut go_on = || {
        let capsule = Capsule::open(array(&capsule, bytes, "capsule")?).map_err(bad)?;
        let room = if n == 0 { &mut [][..] } else { array_mut(&mut room, n, "room")? };
        let mut found = read_to_change(&replay, size)?;
        let part = Part::of(&mut replay, size)?;
        let block = block::open(&mut sim)?;
        let last = found.at.steps.saturating_add(steps);
        while found.end == FK_REPLAY_GOES_ON {
            let most = last.saturating_sub(found.at.steps);
            if most == 0 && found.at.takes_steps(&capsule) {
                break;
            }
            match in_our_environment(|| found.at.next(&capsule, &mut block.sim, room, most)) {
                Ok(Seen::More) => {}
                Ok(Seen::Same) => found.end = FK_REPLAY_SAME,
                Err(difference) => (found.end, found.written, found.found) = numbers_of(difference),
            }
        }
        part.put(&found);
        Ok(())
    };
    status(go_on())
}

fn numbers_of(difference: Difference) -> (u64, u64, u64) {
    match difference {
        Difference::Digest(written, found) => (FK_REPLAY_DIGEST, written, found),
        Difference::Steps(written, found) => (FK_REPLAY_STEPS, written, found),
        Difference::Status(written, found) => (FK_REPLAY_STATUS, written as u64, found as u64),
        Difference::Refused(error) => (FK_REPLAY_STATUS, 0, i64::from(error.code.number()) as u64),
        Difference::Room => (FK_REPLAY_STATUS, 0, i64::from(Code::ShortBuffer.number()) as u64),
    }
}

#[inline(never)] // A scene takes a kilobyte of stack.
fn put_scene_of(capsule: &Capsule<'_>, place: &mut Output<fk_scene>, size: u64) -> Result<(), Error> {
    let mut scene = capsule.scene();
    let scene = scene.as_mut().map_err(|_| Error::plain(Code::BadCapsule, "capsule"))?;
    put_scene(place, size, scene)
}

fn bad(broken: Broken) -> Error {
    let limit = if let What::OtherFormat(format) = broken.what { f64::from(format) } else { 0.0 };
    Error::new(Code::BadCapsule, "capsule", broken.at as f64, limit)
}
