//! Content of an image of a simulation, in this order: header, scalar state (`state.rs`), row by row the
//! numbers of its nodes and segments, bits of contact, checksum.
//!
//! Method: one traversal of a row, by two tables; the image is counted by the tables and written, hashed,
//! checked and read along the traversal. Limits: a number is its 64 bits, so images agree on every target.

use crate::body::projectile::Body;
use crate::ground::planes::{
    CHUNK, ENERGY_ERROR_PLANES, HISTORY_PLANES, HOT_PLANES, MOMENT, PAST_PLANES, VISCOUS_STRESS,
};
use crate::memory::layout::Layout;
use crate::memory::state::{State, Visitor};
use crate::scene::features::{Feature, Features};
use crate::sheet::clamp::{CLAMP_PLANES, SLID};
use crate::sheet::energy_error::GIVEN;

/// Words before the state: name, version of the format, fingerprint of the scene, number of words.
pub(crate) const HEADER_WORDS: usize = 4;

/// Array whose numbers an image holds, as [`RowArrays::numbers`](crate::memory::arrays::RowArrays) has them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Array {
    Hot,
    Clamps,
    Past,
    History,
    EnergyError,
}

/// Planes of each array.
const PLANES: [usize; 5] = [HOT_PLANES, CLAMP_PLANES, PAST_PLANES, HISTORY_PLANES, ENERGY_ERROR_PLANES];

impl Array {
    /// Whether the array has numbers.
    #[inline(always)]
    fn is_kept(self, layout: &Layout) -> bool {
        match self {
            Array::Hot | Array::History => true,
            Array::Clamps => layout.has(Feature::Clamps),
            Array::Past => layout.has(Feature::Viscosity),
            Array::EnergyError => layout.has(Feature::Slack),
        }
    }
}

/// Planes of an array that an image holds.
type Entry = (Array, &'static [usize]);

/// Numbers of a node: displacement and velocity, distance slid, moments.
const NODE: [Entry; 3] =
    [(Array::Hot, &[0, 1, 2, 3, 4, 5]), (Array::Clamps, &[SLID]), (Array::Past, &[MOMENT, MOMENT + 1])];

/// Numbers of a segment: history, energy error, correcting stress, strain and viscous stress before the step.
/// Planes of the horizontal one; those of the vertical one follow.
const SEGMENT: [Entry; 3] =
    [(Array::History, &[0]), (Array::EnergyError, &[0, GIVEN]), (Array::Past, &[0, VISCOUS_STRESS])];

/// Place of a number.
#[derive(Clone, Copy)]
pub(crate) struct NumberPlace {
    pub array: Array,
    pub plane: usize,
    /// Column of the node.
    pub i: usize,
    /// Index in the array.
    pub at: usize,
}

/// Shows the place of each number of row j that an image holds, in order.
#[inline(always)]
pub(crate) fn traverse(layout: &Layout, j: usize, mut visit: impl FnMut(NumberPlace)) {
    let verticals = layout.has_verticals(j);
    for i in 0..layout.nodes_x {
        NODE.iter().for_each(|entry| show(layout, entry, [i, j], 0, &mut visit));
        for (axis, exists) in [(0, i < layout.x.segments()), (1, verticals)] {
            if exists {
                SEGMENT.iter().for_each(|entry| show(layout, entry, [i, j], axis, &mut visit));
            }
        }
    }
}

/// Shows the places of an entry of node (i, j), or of its segment along an axis.
#[inline(always)]
fn show(layout: &Layout, entry: &Entry, [i, j]: [usize; 2], axis: usize, visit: &mut impl FnMut(NumberPlace)) {
    let &(array, planes) = entry;
    if array.is_kept(layout) {
        for plane in planes {
            let (plane, chunk) = (plane + axis, j * layout.chunks + i / CHUNK);
            let at = (chunk * PLANES[array as usize] + plane) * CHUNK + i % CHUNK;
            visit(NumberPlace { array, plane, i, at });
        }
    }
}

/// Words of an image. None: more than there can be.
pub(crate) fn words(layout: &Layout) -> Option<usize> {
    let vertical = layout.nodes_x.checked_mul(layout.y.segments())?.checked_mul(layout.plies)?;
    let segments = layout.x.segments().checked_mul(layout.nodes_y)?.checked_add(vertical)?;
    let of = |table: &[Entry]| -> usize {
        table.iter().filter(|(array, _)| array.is_kept(layout)).map(|(_, planes)| planes.len()).sum()
    };
    let been_slack = if Array::EnergyError.is_kept(layout) { layout.nodes_y } else { 0 };
    let flags = if layout.has(Feature::Detachment) { layout.nodes().div_ceil(32) } else { 0 };
    let numbers = layout.nodes().checked_mul(of(&NODE))?.checked_add(segments.checked_mul(of(&SEGMENT))?)?;
    numbers.checked_add(been_slack)?.checked_add(flags)?.checked_add(frame_words(layout.has))
}

/// Words of an image in addition to rows and bits of contact: header, scalar state and checksum.
pub fn frame_words(has: Features) -> usize {
    let mut counter = Counter(0);
    State::at_start(Body::AT_REST).visit(has, &mut counter);
    HEADER_WORDS + counter.0 + 1
}

/// Number of the words of a state.
struct Counter(usize);

impl Visitor for Counter {
    fn count(&mut self, _: &mut u64) {
        self.0 += 1;
    }
    fn real(&mut self, _: &mut f64) {
        self.0 += 1;
    }
}
