//! Where the rows are: bare pointers into the simulation's arrays, which all bands share, and slices of rows
//! made of them.

use crate::ground::planes::{CARRY_PLANES, Chunk};
use crate::memory::arrays::{Arrays, RowArrays, RowPointers, StepScratch, arrays};
use crate::memory::layout::Layout;
use crate::memory::network::Network;
use crate::scene::features::Feature;
use crate::sheet::columns::COLUMN_PLANES;
use crate::sheet::direction::Directions;
use core::ops::Range;
use core::slice::{from_raw_parts, from_raw_parts_mut};

/// Where the rows are: from the simulation's arrays, taken anew for every pass.
#[derive(Clone, Copy)]
pub(super) struct Pointers {
    pub(super) directions: *const Directions,
    pub(super) rows: RowPointers,
    /// Constants of the columns and of the rows, and awake rows of each ply.
    pub(super) columns: *const [Chunk<COLUMN_PLANES>],
    pub(super) lines: *const [Chunk<COLUMN_PLANES>],
    pub(super) awake: *const [[u32; 2]],
    /// Vertical forces of each step of a block.
    pub(super) carries: *mut [Chunk<CARRY_PLANES>],
    /// Pulls of the fixed nodes of each step and row.
    pub(super) reactions: *mut [[[f64; 3]; 2]],
    /// The bands' own numbers.
    pub(super) scratch: *mut f64,
}

impl Pointers {
    pub(super) fn of(network: &mut Network<'_>, scratch: *mut f64) -> Pointers {
        let Network { directions, layout, arrays: Arrays { rows, columns, lines, awake, shared, .. }, .. } = network;
        let StepScratch { carries, reactions } = StepScratch::of(shared, layout);
        Pointers {
            directions,
            rows: rows.pointers(),
            columns: *columns,
            lines: *lines,
            awake: *awake,
            carries,
            reactions,
            scratch,
        }
    }
}

macro_rules! rows_of_bands {
    ($layout:ident;
     rows { $($(#[$_meaning:meta])* $row:ident: [$_item:ty], $kept:expr, [$steps:expr, $_rows:expr, $width:expr];)* }
     others $_others:tt
     contacts $_contacts:tt) => {
        /// Rows [first, end) in a step of a block, the first one otherwise.
        ///
        /// # Safety
        /// They lie inside the arrays, and nothing else uses them while they are held.
        #[inline(always)]
        pub(super) unsafe fn rows_of<'r>(
            pointers: &RowPointers,
            $layout: &Layout,
            rows: [usize; 2],
            step: usize,
        ) -> RowArrays<'r> {
            // SAFETY: the caller's promise.
            unsafe {
                RowArrays {
                    $($row: if $kept {
                        part_mut(pointers.$row.cast(), $layout.part([$steps, $width], rows, step))
                    } else {
                        Default::default()
                    },)*
                }
            }
        }
    };
}
arrays! { rows_of_bands }

/// Items of an array, to be changed.
///
/// # Safety
/// They lie inside the array, and nothing else uses them while they are held.
pub(super) unsafe fn part_mut<'r, T>(array: *mut T, range: Range<usize>) -> &'r mut [T] {
    // SAFETY: the caller's promise.
    unsafe { from_raw_parts_mut(array.add(range.start), range.len()) }
}

/// `count` rows of `width` items each, from row `first` on; none of an absent array.
///
/// # Safety
/// They lie inside the array, and nothing changes them while they are held.
pub(super) unsafe fn rows<'r, T>(array: *const [T], width: usize, first: usize, count: usize) -> &'r [T] {
    let [first, count] = if array.is_empty() { [0, 0] } else { [first * width, count * width] };
    // SAFETY: the caller's promise.
    unsafe { from_raw_parts(array.cast::<T>().add(first), count) }
}
