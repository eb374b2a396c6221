//! Scratch of the bands in the memory that the caller lends: band by band, ghost rows and carried forces.
//!
//! Method: a band's sweep reads a copy of the row above it and the forces from the row below it, as they were
//! before the pass. In a block the same is kept of each step for the gaps (`step/schedule.rs`).

use super::plan::Plan;
use super::pointers::part_mut;
use crate::ground::planes::{CARRY_PLANES, CHUNK, Chunk, HOT_PLANES, PAST_PLANES};
use crate::step::schedule::Edge;

/// Scratch of one band in one pass.
pub(super) struct Scratch<'r> {
    /// Ghost row above the band: displacements and velocities before the pass.
    pub(super) above: &'r mut [Chunk<HOT_PLANES>],
    /// Vertical forces from the row below the band.
    pub(super) carry: &'r mut [Chunk<CARRY_PLANES>],
    /// Viscosity's past beside the cuts, with the moments of this pass: of the row below the band, its first,
    /// its last, and the row above it.
    pub(super) viscous: &'r mut [Chunk<PAST_PLANES>],
    /// Displacements and velocities of a row's fixed nodes during its sweep.
    pub(super) kept: &'r mut [[f64; 3]],
}

/// First numbers of a band's scratch: the fields of [`Scratch`], and for each step of a block what the gap
/// below the band reads. The first band has no gap below it: its places are those of the body's gap, but for
/// the carried forces, which are those of the tile that reaches the top of the sheet.
struct ScratchPlaces {
    above: *mut f64,
    carry: *mut f64,
    viscous: *mut f64,
    /// Viscosity's past and moments of the row above the gap.
    moments_above_gap: *mut f64,
    /// Displacements and velocities of the row above the gap.
    ghosts_above_gap: *mut f64,
    /// Vertical forces from the row below the gap.
    forces_below_gap: *mut f64,
    kept: *mut f64,
}

impl Plan {
    /// Ghost row above a gap in a step of a block.
    ///
    /// # Safety
    /// No other use while they are held.
    #[allow(clippy::mut_from_ref)] // It lies in the scratch.
    pub(super) unsafe fn above_gap<'r>(&self, edge: Edge, step: usize) -> &'r mut [Chunk<HOT_PLANES>] {
        let ScratchPlaces { ghosts_above_gap, .. } = self.places(if let Edge::Cut(band) = edge { band } else { 0 });
        // SAFETY: the caller's promise.
        unsafe { part_mut(ghosts_above_gap.cast(), step * self.layout.chunks..(step + 1) * self.layout.chunks) }
    }

    /// Viscosity's past and moments of the row above a gap in a step of a block; empty without viscosity.
    ///
    /// # Safety
    /// As for [`Plan::above_gap`].
    #[allow(clippy::mut_from_ref)] // It lies in the scratch.
    pub(super) unsafe fn moments_above_gap<'r>(&self, edge: Edge, step: usize) -> &'r mut [Chunk<PAST_PLANES>] {
        let [_, steps] = self.layout.viscous_rows_of_a_band();
        let chunks = if steps > 0 { self.layout.chunks } else { 0 };
        let ScratchPlaces { moments_above_gap, .. } = self.places(if let Edge::Cut(band) = edge { band } else { 0 });
        // SAFETY: the caller's promise.
        unsafe { part_mut(moments_above_gap.cast(), step * chunks..(step + 1) * chunks) }
    }

    /// Vertical forces that a tile carries to its upper edge in a step of a block.
    ///
    /// # Safety
    /// As for [`Plan::above_gap`].
    #[allow(clippy::mut_from_ref)] // It lies in the scratch.
    pub(super) unsafe fn below_gap<'r>(&self, edge: Edge, step: usize) -> &'r mut [Chunk<CARRY_PLANES>] {
        let forces = match edge {
            Edge::Body => self.memory.carries.cast(),
            Edge::Cut(band) => self.places(band).forces_below_gap.cast(),
            // Bands have no tile above rows that are done.
            Edge::Sheet | Edge::Done => self.places(0).forces_below_gap.cast(),
        };
        // SAFETY: the caller's promise.
        unsafe { part_mut(forces, step * self.layout.chunks..(step + 1) * self.layout.chunks) }
    }

    /// Scratch of a band.
    ///
    /// # Safety
    /// No other use while they are held.
    pub(super) unsafe fn scratch<'r>(&self, band: u32) -> Scratch<'r> {
        let (chunks, [at_cuts, _]) = (self.layout.chunks, self.layout.viscous_rows_of_a_band());
        let ScratchPlaces { above, carry, viscous, kept, .. } = self.places(band);
        // SAFETY: Bands::of has found room for as many bands, one after the other; the caller's promise.
        unsafe {
            Scratch {
                above: part_mut(above.cast(), 0..chunks),
                carry: part_mut(carry.cast(), 0..chunks),
                viscous: part_mut(viscous.cast(), 0..at_cuts * chunks),
                kept: part_mut(kept.cast(), 0..self.layout.nodes_x),
            }
        }
    }

    /// Places of a band's scratch.
    #[inline(never)]
    fn places(&self, band: u32) -> ScratchPlaces {
        let layout = &self.layout;
        let row = layout.chunks * CHUNK;
        let steps = layout.block_steps_of_a_band();
        let above = self.memory.scratch.wrapping_add(band as usize * layout.reals_of_a_band());
        let carry = above.wrapping_add(HOT_PLANES * row);
        let viscous = carry.wrapping_add(CARRY_PLANES * row);
        let [at_cuts, above_gap] = layout.viscous_rows_of_a_band().map(|rows| rows * PAST_PLANES * row);
        let moments_above_gap = viscous.wrapping_add(at_cuts);
        let ghosts_above_gap = moments_above_gap.wrapping_add(above_gap);
        let forces_below_gap = ghosts_above_gap.wrapping_add(steps * HOT_PLANES * row);
        let kept = forces_below_gap.wrapping_add(steps * CARRY_PLANES * row);
        ScratchPlaces { above, carry, viscous, moments_above_gap, ghosts_above_gap, forces_below_gap, kept }
    }
}
