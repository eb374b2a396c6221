//! Where the bands' own numbers are in the scratch that the caller lends: band by band.

use super::plan::Plan;
use super::pointers::part_mut;
use crate::ground::planes::{CARRY_PLANES, CHUNK, Chunk, HOT_PLANES, PAST_PLANES};
use crate::scene::features::Feature;
use crate::step::rows::schedule::Edge;

/// A band's own numbers.
pub(super) struct Scratch<'r> {
    /// The row above the band as it was at the pass's start.
    pub(super) above: &'r mut [Chunk<HOT_PLANES>],
    /// Vertical forces from the row below the band.
    pub(super) carry: &'r mut [Chunk<CARRY_PLANES>],
    /// What viscosity keeps beside the cuts, with the moments of this pass: of the row below the band, its
    /// first, its last, and the row above it.
    pub(super) viscous: &'r mut [Chunk<PAST_PLANES>],
    pub(super) kept: &'r mut [[f64; 3]],
}

/// Where a band's own numbers begin: those of [`Scratch`]; and, of each step of a block, the row above the
/// gap below the band with its moments, and the forces carried from below to that gap. The first band has no
/// gap below it: its row above is that of the body's gap, its forces are those of the part that reaches the
/// top of the sheet.
struct ScratchPlaces {
    above: *mut f64,
    carry: *mut f64,
    viscous: *mut f64,
    moments: *mut f64,
    aboves: *mut f64,
    carries: *mut f64,
    kept: *mut f64,
}

impl Plan {
    /// Where the displacements of the row above a gap are kept of a step of a block.
    ///
    /// # Safety
    /// Nothing else uses them while they are held.
    #[allow(clippy::mut_from_ref)] // It lies in the scratch.
    pub(super) unsafe fn above_gap<'r>(&self, edge: Edge, step: usize) -> &'r mut [Chunk<HOT_PLANES>] {
        let ScratchPlaces { aboves, .. } = self.places(if let Edge::Cut(band) = edge { band } else { 0 });
        // SAFETY: the caller's promise.
        unsafe { part_mut(aboves.cast(), step * self.layout.chunks..(step + 1) * self.layout.chunks) }
    }

    /// Where viscosity's past and moments of the row above a gap are kept of a step of a block; empty without
    /// it.
    ///
    /// # Safety
    /// As for [`Plan::above_gap`].
    #[allow(clippy::mut_from_ref)] // It lies in the scratch.
    pub(super) unsafe fn moments_above_gap<'r>(&self, edge: Edge, step: usize) -> &'r mut [Chunk<PAST_PLANES>] {
        let chunks = if self.layout.has(Feature::Viscosity) { self.layout.chunks } else { 0 };
        let ScratchPlaces { moments, .. } = self.places(if let Edge::Cut(band) = edge { band } else { 0 });
        // SAFETY: the caller's promise.
        unsafe { part_mut(moments.cast(), step * chunks..(step + 1) * chunks) }
    }

    /// Where the vertical forces of a step of a block are that a band carries to its upper edge.
    ///
    /// # Safety
    /// As for [`Plan::above_gap`].
    #[allow(clippy::mut_from_ref)] // It lies in the scratch.
    pub(super) unsafe fn below_gap<'r>(&self, edge: Edge, step: usize) -> &'r mut [Chunk<CARRY_PLANES>] {
        let carries = match edge {
            Edge::Body => self.memory.carries.cast(),
            Edge::Cut(band) => self.places(band).carries.cast(),
            Edge::Sheet | Edge::Taken => self.places(0).carries.cast(),
        };
        // SAFETY: the caller's promise.
        unsafe { part_mut(carries, step * self.layout.chunks..(step + 1) * self.layout.chunks) }
    }

    /// A band's own numbers.
    ///
    /// # Safety
    /// Nothing else uses them while they are held.
    pub(super) unsafe fn scratch<'r>(&self, band: u32) -> Scratch<'r> {
        let chunks = self.layout.chunks;
        let ScratchPlaces { above, carry, viscous, kept, .. } = self.places(band);
        // SAFETY: Bands::of has found room for as many bands, one after the other; the caller's promise.
        unsafe {
            Scratch {
                above: part_mut(above.cast(), 0..chunks),
                carry: part_mut(carry.cast(), 0..chunks),
                viscous: part_mut(viscous.cast(), 0..self.layout.viscous_rows_at_cuts() * chunks),
                kept: part_mut(kept.cast(), 0..self.layout.kept_nodes()),
            }
        }
    }

    /// Where a band's own numbers are.
    #[inline(never)]
    fn places(&self, band: u32) -> ScratchPlaces {
        let layout = &self.layout;
        let row = layout.chunks * CHUNK;
        let steps = layout.block_steps_of_a_band();
        let above = self.memory.scratch.wrapping_add(band as usize * layout.reals_of_a_band());
        let carry = above.wrapping_add(HOT_PLANES * row);
        let viscous = carry.wrapping_add(CARRY_PLANES * row);
        let moments = viscous.wrapping_add(layout.viscous_rows_at_cuts() * PAST_PLANES * row);
        let aboves = viscous.wrapping_add(layout.viscous_rows_of_a_band() * PAST_PLANES * row);
        let carries = aboves.wrapping_add(steps * HOT_PLANES * row);
        let kept = carries.wrapping_add(steps * CARRY_PLANES * row);
        ScratchPlaces { above, carry, viscous, moments, aboves, carries, kept }
    }
}
