//! Where the rows are: bare pointers into the simulation's arrays, which all bands share, and slices of rows made of them.

use crate::ground::planes::{
    CARRY_PLANES, CHUNK, Chunk, HISTORY_PLANES, HOT_PLANES, OWED_PLANES, PAST_PLANES, STRENGTH_PLANES, YARN_PLANES,
};
use crate::memory::arrays::{Arrays, Noted};
use crate::memory::system::System;
use crate::sheet::columns::COLUMN_PLANES;
use crate::sheet::direction::Directions;
use core::slice::{from_raw_parts, from_raw_parts_mut};

/// Where the rows are: from the simulation's arrays, taken anew for every pass.
#[derive(Clone, Copy)]
pub(super) struct Pointers {
    pub(super) directions: *const Directions,
    pub(super) hot: *mut Chunk<HOT_PLANES>,
    pub(super) history: *mut Chunk<HISTORY_PLANES>,
    pub(super) yarn: *const Chunk<YARN_PLANES>,
    pub(super) strength: *const Chunk<STRENGTH_PLANES>,
    pub(super) owed: *mut Chunk<OWED_PLANES>,
    pub(super) been_slack: *const u32,
    pub(super) past: *mut Chunk<PAST_PLANES>,
    pub(super) taken: *mut f64,
    pub(super) columns: *const Chunk<COLUMN_PLANES>,
    pub(super) lines: *const Chunk<COLUMN_PLANES>,
    pub(super) pushed: *mut [[f64; CHUNK]; 3],
    pub(super) pushes: *mut [f64; CHUNK],
    pub(super) holds: *const [f64; CHUNK],
    pub(super) slid: *mut [f64; CHUNK],
    pub(super) clamped: *mut f64,
    pub(super) before: *mut [f64; CHUNK],
    pub(super) awake: *const [u32; 2],
    pub(super) ranges: *mut [u32; 4],
    pub(super) runs: *const [u32; 4],
    /// Vertical forces of each step of a block, and pulls of the fixed nodes of each step and row.
    pub(super) carries: *mut Chunk<CARRY_PLANES>,
    pub(super) pulls: *mut [[f64; 3]; 2],
    /// The bands' own numbers.
    pub(super) scratch: *mut f64,
}

impl Pointers {
    pub(super) fn of(system: &mut System<'_>, scratch: *mut f64) -> Pointers {
        let Arrays {
            hot,
            history,
            yarn,
            strength,
            owed,
            been_slack,
            past,
            taken,
            columns,
            lines,
            pushed,
            pushes,
            holds,
            slid,
            clamped,
            before,
            awake,
            ranges,
            runs,
            shared,
            ..
        } = &mut system.arrays;
        let Noted { carries, pulls } = Noted::of(shared, &system.layout);
        Pointers {
            directions: &raw const system.directions,
            hot: hot.as_mut_ptr(),
            history: history.as_mut_ptr(),
            yarn: yarn.as_ptr(),
            strength: strength.as_ptr(),
            owed: owed.as_mut_ptr(),
            been_slack: been_slack.as_ptr(),
            past: past.as_mut_ptr(),
            taken: taken.as_mut_ptr(),
            columns: columns.as_ptr(),
            lines: lines.as_ptr(),
            pushed: pushed.as_mut_ptr(),
            pushes: pushes.as_mut_ptr(),
            holds: holds.as_ptr(),
            slid: slid.as_mut_ptr(),
            clamped: clamped.as_mut_ptr(),
            before: before.as_mut_ptr(),
            awake: awake.as_ptr(),
            ranges: ranges.as_mut_ptr(),
            runs: runs.as_ptr(),
            carries: carries.as_mut_ptr(),
            pulls: pulls.as_mut_ptr(),
            scratch,
        }
    }
}

/// `count` rows of `width` items each, from row `first` on.
///
/// # Safety
/// They lie inside what `start` points to, and nothing changes them while they are held.
pub(super) unsafe fn rows<'r, T>(start: *const T, width: usize, first: usize, count: usize) -> &'r [T] {
    // SAFETY: the caller's promise.
    unsafe { from_raw_parts(start.add(first * width), count * width) }
}

/// `count` rows of `width` items each, from row `first` on, to be changed.
///
/// # Safety
/// They lie inside what `start` points to, and nothing else uses them while they are held.
pub(super) unsafe fn rows_mut<'r, T>(start: *mut T, width: usize, first: usize, count: usize) -> &'r mut [T] {
    // SAFETY: the caller's promise.
    unsafe { from_raw_parts_mut(start.add(first * width), count * width) }
}
