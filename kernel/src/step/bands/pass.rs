//! Pass of a band: ghost rows copied from its neighbours before, the sweep of its rows, its tiles and gaps of
//! a block of steps; and after the last band the part of the pass that is not cut.
//!
//! Method: rows are slices made of pointers that all bands share; who may touch what is said in `mod.rs`.
//! Reference: docs/model.md, "Row bands".

use super::plan::Plan;
use super::pointers::{part_mut, rows, rows_of};
use super::scratch::Scratch;
use crate::ground::error::Failure;
use crate::ground::planes::{self, Axis, CARRY_PLANES, CHUNK, Chunk, HOT_PLANES, PAST_PLANES};
use crate::memory::system::System;
use crate::scene::features::Feature;
use crate::sheet::columns::Net;
use crate::sheet::energy_error::bit;
use crate::step::blocks;
use crate::step::one_step;
use crate::step::schedule::{Block, Edge, Tile};
use crate::step::whole;
use crate::sweep::moments::{ViscousRows, find_moments_of_row, place_ghost_moments};
use crate::sweep::pass::ForcesFromBelow;
use crate::sweep::rows::Rows;
use crate::sweep::segments::Report;
use crate::sweep::viscous::MomentsOfRow;
use core::mem::take;

/// Ghost data of a sweep of rows: the row above with its moments, the forces from the row
/// below, and the band's own numbers.
struct Beside<'r> {
    above: &'r [Chunk<HOT_PLANES>],
    past_above: &'r mut [Chunk<PAST_PLANES>],
    /// Whether the moments of the first and of the last row are known.
    moments_found: [bool; 2],
    carry: &'r mut [Chunk<CARRY_PLANES>],
    kept: &'r mut [[f64; 3]],
}

impl Plan {
    /// Copies what a band needs of its neighbours' rows, before any row is swept.
    ///
    /// # Safety
    /// No band is being swept, and the simulation's arrays and the scratch are used by nothing else.
    pub(super) unsafe fn copy_ghost_rows(&self, band_count: u32, band: u32) {
        let [first, end] = self.rows_of(band_count, band);
        if self.found.is_err() || first == end {
            return;
        }
        let (layout, memory, chunks) = (&self.layout, &self.memory, self.layout.chunks);
        // SAFETY: the rows lie inside the arrays; the caller has them and the scratch to itself.
        unsafe {
            let Scratch { above, carry, viscous, .. } = self.scratch(band);
            // The plies that the band's first row and the row above it belong to, and their rows.
            let [(lowest, low), (highest, [_, top])] = [first, end - 1].map(|j| {
                let (ply, _) = layout.ply_and_row(j);
                (ply, self.rows_of_ply(ply))
            });
            if end < top {
                copy_motion(above, rows(memory.rows.hot, chunks, end, 1));
            }
            let is_cut = first > low[0] && first < low[1];
            let step = self.gap_step.unwrap_or(0);
            let [below, bottom, last, above] = rows_beside(viscous, chunks);
            if layout.has(Feature::Viscosity) {
                // What a row takes is counted once, and by the band that has it.
                if is_cut {
                    self.copy_moments(first - 1, lowest, step, below, false);
                    self.copy_moments(first, lowest, step, bottom, true);
                }
                if end < top {
                    self.copy_moments(end - 1, highest, step, last, !(is_cut && end - 1 == first));
                    self.copy_moments(end, highest, step, above, false);
                }
            }
            if is_cut {
                self.forces_from_below(first, lowest, carry, [below, bottom]);
            } else if let Some(step) = self.gap_step {
                copy_row(carry, rows(memory.carries, chunks, step, 1));
            }
        }
    }

    /// The vertical forces on row j of a ply from the row below it. `viscous`: past and moments of both.
    ///
    /// # Safety
    /// No call changes the two rows.
    unsafe fn forces_from_below(
        &self,
        j: usize,
        ply: usize,
        carry: &mut [Chunk<CARRY_PLANES>],
        viscous: [&[Chunk<PAST_PLANES>]; 2],
    ) {
        let (memory, chunks) = (&self.memory, self.layout.chunks);
        // SAFETY: the rows lie inside the arrays; the caller's promise.
        unsafe {
            let yarn = rows(memory.rows.yarn, chunks, j - 1, 1);
            let strength = rows(memory.rows.strength, chunks, j - 1, 1);
            let below = rows(memory.rows.hot, chunks, j - 1, 1);
            let history = rows(memory.rows.history, chunks, j - 1, 1);
            let here = rows(memory.rows.hot, chunks, j, 1);
            let bits = rows(memory.rows.been_slack, 1, j - 1, 1).first().copied().unwrap_or(0);
            let count = usize::from(bits & bit(Axis::Vertical) != 0);
            let energy_error = rows(memory.rows.energy_error, chunks, j - 1, count);
            let terms = self.terms(false);
            let yarn = terms.yarn_row(yarn, strength, 0, ply);
            let pass = terms.pass(self.net(ply), ply);
            let (row, above, yarn) = (below, here, &yarn);
            ForcesFromBelow { pass: &pass, j: j - 1, row, history, above, carry, yarn, energy_error, viscous }.find();
        }
    }

    /// A copy of what viscosity keeps of row j of a ply, beside a cut, with its moments in a step of a block,
    /// the first one otherwise. `counts`: whether what they take is counted.
    ///
    /// # Safety
    /// As for [`Plan::find_moments`].
    #[inline(never)]
    unsafe fn copy_moments(&self, j: usize, ply: usize, step: usize, past: &mut [Chunk<PAST_PLANES>], counts: bool) {
        // SAFETY: the caller's promise.
        unsafe {
            copy_row(past, rows(self.memory.rows.past, self.layout.chunks, j, 1));
            // Moments of a gap's lowest row were found with the row below it.
            if self.gap_step.is_none() || j == 0 || j != self.rows[0] {
                self.find_moments(j, ply, step, past, counts);
            }
        }
    }

    /// Finds the viscous moments of row j of a ply in a step of a block, the first one otherwise, in `past`,
    /// its own or a copy. `counts`: whether what they take is counted.
    ///
    /// # Safety
    /// No other call changes the row and those beside it, or uses what it dissipates.
    #[inline(never)]
    unsafe fn find_moments(&self, j: usize, ply: usize, step: usize, past: &mut [Chunk<PAST_PLANES>], counts: bool) {
        let (layout, memory, chunks) = (&self.layout, &self.memory, self.layout.chunks);
        // Rows below and above that the ply has.
        let [below, above] = [j > layout.rows_of(ply)[0], layout.has_verticals(j)].map(usize::from);
        // SAFETY: the rows lie inside the arrays; the caller's promise.
        unsafe {
            let row = MomentsOfRow {
                directions: self.directions().of_ply(ply),
                net: &self.net(ply),
                row: rows(memory.rows.hot, chunks, j, 1),
                below: rows(memory.rows.hot, chunks, j - below, below),
                past_below: rows(memory.rows.past, chunks, j - below, below),
                // The row above a gap is further.
                above: match self.gap_step {
                    Some(step) if above > 0 && j + 1 == self.rows[1] => self.above_gap(Edge::Body, step),
                    _ => rows(memory.rows.hot, chunks, j + above, above),
                },
                past,
            };
            let (mut ignored, start) = (0.0, memory.rows.dissipated.cast::<f64>());
            let dissipated = if counts { &mut *start.add(step * layout.nodes_y + j) } else { &mut ignored };
            find_moments_of_row(&self.terms(false), j, row, dissipated);
        }
    }

    /// Past and moments of row j, to be changed; empty without viscosity and above the top row.
    ///
    /// # Safety
    /// No other use while it is held.
    #[allow(clippy::mut_from_ref)] // It lies in the simulation's arrays.
    unsafe fn past_of<'r>(&self, j: usize) -> &'r mut [Chunk<PAST_PLANES>] {
        let (layout, chunks) = (&self.layout, self.layout.chunks);
        if !layout.has(Feature::Viscosity) || j >= layout.stored_rows() {
            return &mut [];
        }
        // SAFETY: there are so many rows; the caller's promise.
        unsafe { part_mut(self.memory.rows.past.cast(), j * chunks..(j + 1) * chunks) }
    }

    /// Puts the moments that are known into rows [first, end) of a ply, a band's: which they are, and what
    /// viscosity keeps of the row above. `viscous`: those of [`Scratch`].
    ///
    /// # Safety
    /// As for [`Plan::rows`].
    #[inline(never)]
    unsafe fn put_known_moments<'r>(
        &self,
        [first, end]: [usize; 2],
        ply: usize,
        viscous: &'r mut [Chunk<PAST_PLANES>],
    ) -> ([bool; 2], &'r mut [Chunk<PAST_PLANES>]) {
        let (layout, chunks) = (&self.layout, self.layout.chunks);
        if !layout.has(Feature::Viscosity) {
            return ([false; 2], &mut []);
        }
        // Beyond the mirror plane lies a ghost row, whose node row may be the one below the band.
        let has_ghosts = layout.y.is_mirrored() && end == layout.nodes_y;
        let [below, bottom, last, above] = rows_beside(viscous, chunks);
        // SAFETY: the caller's promise; the ghost row is the last band's.
        unsafe {
            let [low, top] = self.rows_of_ply(ply);
            if first > low {
                copy_row(self.past_of(first), bottom);
            }
            // Moments of a gap's lowest row were found with the row below it.
            let is_found = first > low || self.gap_step.is_some() && first > 0;
            if end < top {
                copy_row(self.past_of(end - 1), last);
                return ([is_found, true], above);
            }
            let above = match self.gap_step {
                Some(step) if end < layout.nodes_y => self.moments_above_gap(Edge::Body, step),
                _ if has_ghosts => self.past_of(end),
                _ => &mut [],
            };
            if has_ghosts && layout.y.node(layout.y.modelled()).0 < first {
                place_ghost_moments(above, below);
            }
            ([is_found, false], above)
        }
    }

    /// Sweeps a band's rows.
    ///
    /// # Safety
    /// No other call is sweeping the same band, and nothing but sweeps of other bands uses the simulation and
    /// the scratch.
    pub(super) unsafe fn sweep(&self, band_count: u32, band: u32) -> Report {
        let [first, end] = self.rows_of(band_count, band);
        if self.found.is_err() || first == end {
            return Report::default();
        }
        let layout = &self.layout;
        let (from, to) = (layout.ply_and_row(first).0, layout.ply_and_row(end - 1).0);
        let mut report = Report::default();
        for ply in from..=to {
            let [_, ply_end] = layout.rows_of(ply);
            // SAFETY: rows_of() cuts the rows without overlap and inside the arrays, so the parts taken for
            // writing here are this band's alone. Of a row that another band writes only the copy is read;
            // the row above the last band is not swept.
            unsafe {
                let [low, top] = self.rows_of_ply(ply);
                let (start, stop) = (first.max(low), end.min(top));
                if start >= stop {
                    continue;
                }
                let Scratch { above, carry, viscous, kept } = self.scratch(band);
                let above: &[_] = if stop < top {
                    above
                } else if let Some(step) = self.gap_step.filter(|_| stop < ply_end) {
                    self.above_gap(Edge::Body, step)
                } else if stop == ply_end && layout.is_stack() {
                    &[]
                } else {
                    self.row_above(stop - 1)
                };
                if start == low && self.block.is_none() {
                    carry.fill([[0.0; CHUNK]; CARRY_PLANES]);
                }
                let (moments_found, past_above) = self.put_known_moments([start, stop], ply, viscous);
                let beside = Beside { above, past_above, moments_found, carry, kept };
                let step = self.gap_step.unwrap_or(0);
                let mut rows = self.rows(step, [start, stop], ply, beside);
                let terms = self.terms(self.fetches && step == 0);
                let met = rows.sweep(&terms);
                report = report.merged(met);
            }
        }
        report
    }

    /// Takes all steps of a block that a band can take away from the body.
    ///
    /// # Safety
    /// No other call is at work on the same band, and nothing but calls for other bands uses the simulation
    /// and the scratch.
    #[inline(never)]
    pub(super) unsafe fn step_away(&self, band: u32, block: &Block) -> Report {
        let mut report = Report::default();
        for tile in [false, true].map(|is_above| block.tile(band, is_above)) {
            for r in tile.wavefronts() {
                for step in 0..block.steps {
                    let Some(j) = tile.row(r, step) else { continue };
                    // SAFETY: the tiles of all bands and the gaps between them have no row in common. What
                    // is read of a gap's row is changed in later passes, and what is kept for a gap, and the
                    // moments of its lowest row, are of this tile alone.
                    report = report.merged(unsafe { self.step_row_away(band, block, &tile, step, j) });
                }
            }
        }
        report
    }

    /// Takes a step of row j of a tile.
    ///
    /// # Safety
    /// As for [`Plan::step_away`], which is at this tile.
    unsafe fn step_row_away(&self, band: u32, block: &Block, tile: &Tile, step: usize, j: usize) -> Report {
        // SAFETY: the caller's promise.
        unsafe {
            let Scratch { kept, viscous, .. } = self.scratch(band);
            let carry = self.below_gap(tile.upper, step);
            if j == 0 {
                carry.fill([[0.0; CHUNK]; CARRY_PLANES]);
            } else if tile.starts_at_gap(step, j) {
                self.start_above_gap(tile.lower, step, j, carry, viscous);
            }
            let past_above = self.past_of(j + 1);
            if !past_above.is_empty() {
                self.find_moments(j + 1, 0, step, past_above, true);
            }
            let beside = Beside { above: self.row_above(j), past_above, moments_found: [j > 0, false], carry, kept };
            self.step_rows(block, step, [j, j + 1], beside)
        }
    }

    /// Finds the forces on row j from the row below it, of a gap, and keeps of the row what the gap needs.
    ///
    /// # Safety
    /// As for [`Plan::step_away`], which is at this row.
    unsafe fn start_above_gap(
        &self,
        gap: Edge,
        step: usize,
        j: usize,
        carry: &mut [Chunk<CARRY_PLANES>],
        viscous: &mut [Chunk<PAST_PLANES>],
    ) {
        let chunks = self.layout.chunks;
        // SAFETY: the caller's promise.
        unsafe {
            let (below, here) = (planes::row_mut(viscous, chunks, 0), self.past_of(j));
            if !here.is_empty() {
                self.copy_moments(j - 1, 0, step, below, false);
                self.find_moments(j, 0, step, here, true);
                copy_row(self.moments_above_gap(gap, step), here);
            }
            self.forces_from_below(j, 0, carry, [below, here]);
            copy_motion(self.above_gap(gap, step), rows(self.memory.rows.hot, chunks, j, 1));
        }
    }

    /// Takes a step of the gap between a band and the one below it.
    ///
    /// # Safety
    /// As for [`Plan::step_away`].
    #[inline(never)]
    pub(super) unsafe fn sweep_gap(&self, band: u32, block: &Block, step: usize) -> Report {
        let (rows, gap) = (block.rows_of_gap(step, band), Edge::Cut(band));
        if self.found.is_err() || rows[0] == rows[1] {
            return Report::default();
        }
        // SAFETY: the gaps have no row in common, with the body's neither.
        unsafe {
            let beside = Beside {
                above: self.above_gap(gap, step),
                past_above: self.moments_above_gap(gap, step),
                moments_found: [true, false],
                carry: self.below_gap(gap, step),
                kept: self.scratch(band).kept,
            };
            self.step_rows(block, step, rows, beside)
        }
    }

    /// Sweeps rows [first, end) away from the body in a step of a block.
    ///
    /// # Safety
    /// No other call uses the rows and what belongs to them, or changes the row above.
    unsafe fn step_rows(&self, block: &Block, step: usize, rows: [usize; 2], beside: Beside<'_>) -> Report {
        // SAFETY: the caller's promise; there are reactions of every step and row.
        unsafe {
            let mut swept = self.rows(step, rows, 0, beside);
            // A row comes from memory in the first step alone.
            let mut report = swept.sweep(&self.terms(self.fetches && step == 0));
            report.non_finite |= block.are_met(step, rows[0], swept.own.ranges);
            report
        }
    }

    /// The row above row j, none above the top row.
    ///
    /// # Safety
    /// No change while it is held.
    unsafe fn row_above<'r>(&self, j: usize) -> &'r [Chunk<HOT_PLANES>] {
        // SAFETY: the caller's promise.
        unsafe {
            let count = usize::from(j + 1 < self.layout.stored_rows());
            rows(self.memory.rows.hot, self.layout.chunks, j + 1, count)
        }
    }

    /// Rows [first, end) of a ply with all that belongs to them, in a step of a block, the first one
    /// otherwise.
    ///
    /// # Safety
    /// They lie inside the arrays, and nothing else uses them while they are held.
    unsafe fn rows<'r>(
        &self,
        step: usize,
        [first, end]: [usize; 2],
        ply: usize,
        Beside { above, past_above, moments_found, carry, kept }: Beside<'r>,
    ) -> Rows<'r> {
        let (layout, memory, noted) = (&self.layout, &self.memory, step * self.layout.nodes_y);
        // SAFETY: the caller's promise.
        unsafe {
            let mut own = rows_of(&memory.rows, layout, [first, end], step);
            Rows {
                first,
                ply,
                above,
                viscous: ViscousRows { past: take(&mut own.past), above: past_above, moments_found },
                net: self.net(ply),
                carry,
                kept,
                reactions: if layout.supports {
                    part_mut(memory.reactions.cast(), noted + first..noted + end)
                } else {
                    Default::default()
                },
                own,
            }
        }
    }

    /// Constants of a graded network or a curved sheet.
    ///
    /// # Safety
    /// The simulation's arrays are there.
    unsafe fn net<'r>(&self, ply: usize) -> Net<'r> {
        // SAFETY: nothing changes them.
        let (columns, lines) = unsafe { (&*self.memory.columns, &*self.memory.lines) };
        Net { columns: self.layout.columns_of(columns, ply), lines }
    }

    /// The part of a pass that is not cut.
    ///
    /// # Safety
    /// All bands have been swept; the simulation's arrays and the scratch are used by nothing else.
    pub(super) unsafe fn close(&self, system: &mut System<'_>, report: Report) -> Result<(), Failure> {
        let gathered = self.found?;
        if let Some(block) = &self.block {
            match self.gap_step {
                Some(step) => blocks::end_near(system, block, step, &gathered, report)?,
                None if report.non_finite => return Err(Failure::NonFinite),
                None => system.failed_segments += report.newly_failed,
            }
            if self.next_part().is_none() {
                blocks::end(system);
            }
            return Ok(());
        }
        whole::wake_rows_to_step(&mut system.network);
        whole::end_sweep(system, &gathered);
        one_step::apply_contact_and_move_body(system, &gathered, report)?;
        one_step::count_step(system);
        Ok(())
    }
}

/// Rows of [`Scratch::viscous`]: below the band, its first, its last, and above it; empty without viscosity.
fn rows_beside(viscous: &mut [Chunk<PAST_PLANES>], chunks: usize) -> [&mut [Chunk<PAST_PLANES>]; 4] {
    let mut rows = viscous.chunks_exact_mut(chunks.max(1));
    [(); 4].map(|()| rows.next().unwrap_or(&mut []))
}

/// Copies a row of chunks.
fn copy_row<const P: usize>(copy: &mut [Chunk<P>], row: &[Chunk<P>]) {
    copy.iter_mut().zip(row).for_each(|(copy, chunk)| *copy = *chunk);
}

/// Copies the displacements and velocities of a row, which are all that is read of a row above.
#[inline(never)]
fn copy_motion(copy: &mut [Chunk<HOT_PLANES>], row: &[Chunk<HOT_PLANES>]) {
    for (copy, chunk) in copy.iter_mut().zip(row) {
        copy.iter_mut().zip(chunk).take(6).for_each(|(copy, plane)| *copy = *plane);
    }
}
