//! Slack segments within the sweep: the stress that corrects their energy error, and the search for them.
//!
//! Method: the law of `sheet/energy_error.rs`. The segments of a row along x, or upwards from it, keep energy
//! errors from the first slack one of them on, crimped ones from the start.
//! Limits: those of `sheet/energy_error.rs`.
//! Reference: docs/model.md, "Slack and taut".

use crate::ground::lanes::{Job, Lane, at};
use crate::ground::planes::{Axis, CHUNK, Chunk, ENERGY_ERROR_PLANES, HOT_PLANES, SPEED_X, vertical_axes};
use crate::sheet::columns::{Geometry, Table};
use crate::sheet::energy_error::{EnergyError, GIVEN, bit, keeps};
use crate::sheet::neighbours::Around;
use crate::sweep::segments::{At, DamagedChunk, Fall, Segments, Yarns};
use crate::yarn::law::RestLanes;

/// Every so many steps, from the first one on, rows are searched for slack segments.
pub(crate) const SEARCH_INTERVAL: u64 = 16;

/// Balance of energy of the slack segments of a row.
pub struct SlackBalance<'a> {
    /// Energy error and last stress of each segment.
    pub energy_error: &'a mut [Chunk<ENERGY_ERROR_PLANES>],
    /// 1 along each axis in which segments keep them, else 0.
    pub keeps: [f64; 2],
}

impl<'a> SlackBalance<'a> {
    /// Balance of a row with these energy errors, in whose directions of these bits segments have been slack.
    #[inline(always)]
    pub fn of(energy_error: &'a mut [Chunk<ENERGY_ERROR_PLANES>], bits: u32) -> SlackBalance<'a> {
        SlackBalance { energy_error, keeps: keeps(bits) }
    }

    /// Balance of chunk c; None after the last.
    #[inline(always)]
    pub fn on_chunk(&mut self, c: usize) -> Option<SlackChunk<&mut Chunk<ENERGY_ERROR_PLANES>>> {
        Some(SlackChunk { energy_error: self.energy_error.get_mut(c)?, keeps: self.keeps })
    }
}

/// Balance of energy of the slack segments of a chunk.
pub struct SlackChunk<S> {
    /// Energy error and last stress of each segment.
    pub energy_error: S,
    /// 1 along each axis in which segments keep them, else 0.
    pub keeps: [f64; 2],
}

impl<S: DamagedChunk<ENERGY_ERROR_PLANES>> SlackChunk<S> {
    /// Adds the stresses that correct the energy of a lane group.
    #[inline(always)]
    pub fn act<L: Lane>(&mut self, segments: &mut Segments<L>, At { bars, around, group: g }: &At<'_, L>) {
        let w = around.differences::<L>(SPEED_X, *g);
        let [along, upwards] = &bars.rests;
        let x = [along.end_to_end(segments.d[0]), upwards.end_to_end(vertical_axes(segments.d[1]))];
        let given_x = self.given(Axis::Horizontal, segments, along, [x[0], w[0]], *g);
        let given_y = self.given(Axis::Vertical, segments, upwards, [x[1], vertical_axes(w[1])], *g);
        segments.stress = [segments.stress[0].add(given_x), segments.stress[1].add(given_y)];
    }

    /// Stress given to a lane group along an axis. `ends`: from end to end, and how the ends move relative to
    /// each other.
    #[inline(always)]
    fn given<L: Lane>(
        &mut self,
        axis: Axis,
        segments: &Segments<L>,
        rest: &RestLanes<L>,
        ends: [[L; 3]; 2],
        g: usize,
    ) -> L {
        let (k, state) = (axis as usize, self.energy_error.get());
        let last = EnergyError { energy: at(state, k, g), given: at(state, GIVEN + k, g) };
        let keeps = L::splat(self.keeps[k]);
        let stiffnesses = [segments.before[k].mul(keeps), segments.stiffness[k].mul(keeps)];
        let next = last.next(rest, stiffnesses, segments.q[k], ends);
        self.energy_error.keep(k, g, next.energy);
        self.energy_error.keep(GIVEN + k, g, next.given);
        next.given
    }

    /// Adds what damage dissipates to the energy errors.
    pub fn note_fall(&mut self, fall: &Fall<'_>, yarns: &Yarns<'_>) {
        fall.each(|column, axis, _, [before, now]| {
            if self.keeps[axis as usize] != 0.0 {
                self.energy_error.add(axis as usize, column, 4.0 * yarns.dissipated(axis, column, now));
                self.energy_error.add(axis as usize, column, -4.0 * yarns.dissipated(axis, column, before));
            }
        });
    }
}

/// Bits of the directions in which a segment that starts in a row is slack.
pub(crate) struct FindSlack<'a> {
    pub row: &'a [Chunk<HOT_PLANES>],
    /// Empty above the last row.
    pub above: &'a [Chunk<HOT_PLANES>],
    pub geometry: Table<'a>,
}

impl Job for FindSlack<'_> {
    type Output = u32;

    #[inline(always)]
    fn run<L: Lane>(self) -> u32 {
        let FindSlack { row, above, geometry } = self;
        let (zero, mut slack) = (L::splat(0.0), [false; 2]);
        for chunk in 0..row.len() {
            let Some(around) = Around::of(row, above, chunk) else { break };
            let columns = geometry.columns(chunk);
            for group in 0..CHUNK / L::WIDTH {
                let bars = geometry.bars(columns, group);
                let Segments { q, stiffness, .. } = Segments::<L>::strained(&around, &bars, group);
                // Where there is no segment the stiffness is 0, as of a broken one.
                slack[0] |= zero.any_above(stiffness[0].mul(q[0]));
                slack[1] |= zero.any_above(stiffness[1].mul(q[1]));
            }
            if slack == [true; 2] {
                break;
            }
        }
        let bits = |axis: Axis| u32::from(slack[axis as usize]) * bit(axis);
        bits(Axis::Horizontal) | bits(Axis::Vertical)
    }
}
