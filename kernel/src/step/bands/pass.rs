//! What a band does in a pass: the copies that it needs of its neighbours before, the sweep of its rows, and
//! its part of a block of steps; and after the last band the part that is not cut.

use super::block::{BlockInBands, Edge, RowsAway};
use super::plan::Plan;
use super::pointers::{part_mut, rows, rows_of};
use super::scratch::Scratch;
use crate::ground::error::Failure;
use crate::ground::planes::{self, Axis, CARRY_PLANES, CHUNK, Chunk, HOT_PLANES, PAST_PLANES};
use crate::memory::system::System;
use crate::scene::features::Feature;
use crate::sheet::columns::Net;
use crate::sheet::segments::Report;
use crate::sheet::slack::bit;
use crate::sheet::sweep::Lift;
use crate::sheet::viscous::MomentsOfRow;
use crate::step::explicit;
use crate::step::rows::Rows;
use crate::step::rows::moments::{ViscousRows, find_moments_of_row, place_image_moments};
use core::mem::take;

/// What a sweep of rows uses that is not theirs: the row above, the forces from the row below, and the band's
/// own numbers.
struct Beside<'r> {
    above: &'r [Chunk<HOT_PLANES>],
    carry: &'r mut [Chunk<CARRY_PLANES>],
    kept: &'r mut [[f64; 3]],
    viscous: &'r mut [Chunk<PAST_PLANES>],
}

impl Plan {
    /// Copies what a band needs of its neighbours' rows, before any row is swept.
    ///
    /// # Safety
    /// No band is being swept, and the simulation's arrays and the scratch are used by nothing else.
    #[inline(never)]
    pub(super) unsafe fn cut(&self, of: u32, band: u32) {
        let [first, end] = self.rows_of(of, band);
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
            if layout.has(Feature::Viscosity) {
                let mut slots = viscous.chunks_exact_mut(chunks.max(1));
                let [below, bottom, last, above] = [(); 4].map(|()| slots.next().unwrap_or(&mut []));
                // What a row takes is counted once, and by the band that has it.
                if is_cut {
                    self.find_moments(first - 1, lowest, below, false);
                    self.find_moments(first, lowest, bottom, true);
                }
                if end < top {
                    self.find_moments(end - 1, highest, last, !(is_cut && end - 1 == first));
                    self.find_moments(end, highest, above, false);
                }
            }
            if is_cut {
                self.lift(first, lowest, carry, viscous);
            } else if let Some(step) = self.step_in_block() {
                copy_row(carry, rows(memory.carries, chunks, step, 1));
            }
        }
    }

    /// The vertical forces on row j of a ply from the row below it.
    ///
    /// # Safety
    /// Nothing changes the two rows.
    #[inline(never)]
    unsafe fn lift(&self, j: usize, ply: usize, carry: &mut [Chunk<CARRY_PLANES>], viscous: &[Chunk<PAST_PLANES>]) {
        let (layout, memory, chunks) = (&self.layout, &self.memory, self.layout.chunks);
        // SAFETY: the rows lie inside the arrays; the caller's promise.
        unsafe {
            let yarn = rows(memory.rows.yarn, chunks, j - 1, 1);
            let strength = rows(memory.rows.strength, chunks, j - 1, 1);
            let below = rows(memory.rows.hot, chunks, j - 1, 1);
            let history = rows(memory.rows.history, chunks, j - 1, 1);
            let here = rows(memory.rows.hot, chunks, j, 1);
            let bits = rows(memory.rows.been_slack, 1, j - 1, 1).first().copied().unwrap_or(0);
            let count = usize::from(layout.has(Feature::Slack) && bits & bit(Axis::Vertical) != 0);
            let owed = rows(memory.rows.owed, chunks, j - 1, count);
            let terms = self.terms(false);
            let yarn = terms.yarn_row(yarn, strength, 0, ply);
            let (net, viscous) = (self.net(ply), [0, 1].map(|slot| planes::row(viscous, chunks, slot)));
            let pass = terms.pass(net, ply);
            let (row, above, yarn) = (below, here, &yarn);
            Lift { pass: &pass, j: j - 1, row, history, above, carry, yarn, owed, viscous }.find();
        }
    }

    /// The viscous moments of row j of a ply, beside a cut. `counts`: whether what they take is counted.
    ///
    /// # Safety
    /// Nothing changes the row and those beside it; nothing else uses what is counted of it.
    #[inline(never)]
    unsafe fn find_moments(&self, j: usize, ply: usize, past: &mut [Chunk<PAST_PLANES>], counts: bool) {
        let (layout, memory, chunks) = (&self.layout, &self.memory, self.layout.chunks);
        // Rows below and above that the ply has.
        let [below, above] = [j > layout.rows_of(ply)[0], layout.has_verticals(j)].map(usize::from);
        // SAFETY: the rows lie inside the arrays; the caller's promise.
        unsafe {
            copy_row(past, rows(memory.rows.past, chunks, j, 1));
            let row = MomentsOfRow {
                directions: self.directions().of_ply(ply),
                row: rows(memory.rows.hot, chunks, j, 1),
                below: rows(memory.rows.hot, chunks, j - below, below),
                past_below: rows(memory.rows.past, chunks, j - below, below),
                above: rows(memory.rows.hot, chunks, j + above, above),
                past,
            };
            let (mut ignored, start) = (0.0, memory.rows.taken.cast::<f64>());
            let taken = if counts { &mut *start.add(j) } else { &mut ignored };
            find_moments_of_row(&self.terms(false), j, row, taken);
        }
    }

    /// What viscosity keeps of rows [first, end) of a ply.
    ///
    /// # Safety
    /// As for [`Plan::rows`].
    #[inline(never)]
    unsafe fn viscous_rows<'r>(
        &self,
        [first, end]: [usize; 2],
        ply: usize,
        past: &'r mut [Chunk<PAST_PLANES>],
        beside: &'r mut [Chunk<PAST_PLANES>],
    ) -> ViscousRows<'r> {
        let (layout, chunks, count) = (&self.layout, self.layout.chunks, end - first);
        if !layout.has(Feature::Viscosity) {
            return ViscousRows { past, above: &mut [], known: [false; 2] };
        }
        // Beyond the mirror plane lie the images of a row, which may be the one below the band.
        let images = layout.y.is_mirrored() && end == layout.nodes_y;
        let mut slots = beside.chunks_exact_mut(chunks.max(1));
        let [below, bottom, last, above] = [(); 4].map(|()| slots.next().unwrap_or(&mut []));
        // SAFETY: the caller's promise; the images are the last band's.
        unsafe {
            let [low, top] = self.rows_of_ply(ply);
            let known = [first > low, end < top];
            if known[0] {
                copy_row(past, bottom);
            }
            if known[1] {
                copy_row(planes::row_mut(past, chunks, count - 1), last);
            }
            let above = if known[1] {
                above
            } else if images {
                part_mut(self.memory.rows.past.cast(), end * chunks..(end + 1) * chunks)
            } else {
                &mut []
            };
            if images && layout.y.node(layout.y.modelled()).0 < first {
                place_image_moments(above, below);
            }
            ViscousRows { past, above, known }
        }
    }

    /// Sweeps a band's rows.
    ///
    /// # Safety
    /// No other call is sweeping the same band, and nothing but sweeps of other bands uses the simulation and
    /// the scratch.
    #[inline(never)]
    pub(super) unsafe fn sweep(&self, of: u32, band: u32) -> Report {
        let [first, end] = self.rows_of(of, band);
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
                } else if let Some(step) = self.step_in_block().filter(|_| stop < ply_end) {
                    self.above_gap(Edge::Body, step)
                } else if stop == ply_end && layout.is_stack() {
                    &[]
                } else {
                    self.row_above(stop - 1)
                };
                if start == low && self.block.is_none() {
                    carry.fill([[0.0; CHUNK]; CARRY_PLANES]);
                }
                let beside = Beside { above, carry, kept, viscous };
                let mut rows = self.rows(self.step_in_block().unwrap_or(0), [start, stop], ply, beside);
                let fetches = self.fetches && self.step_in_block().is_none_or(|step| step == 0);
                let terms = self.terms(fetches);
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
    pub(super) unsafe fn step_away(&self, band: u32, block: &BlockInBands) -> Report {
        let mut report = Report::default();
        for part in &block.rows_away(band as usize) {
            for r in part.numbers(block.steps()) {
                for step in 0..block.steps() {
                    if let Some(j) = part.row(r, step) {
                        // SAFETY: the parts of all bands and the gaps between them have no row in common.
                        // What is read of a gap's row is changed in later passes, and what is kept for a gap
                        // is of this part alone.
                        report = report.merged(unsafe { self.step_row_away(band, block, part, step, j) });
                    }
                }
            }
        }
        report
    }

    /// Takes a step of row j of a part.
    ///
    /// # Safety
    /// As for [`Plan::step_away`], which is at this part.
    unsafe fn step_row_away(&self, band: u32, block: &BlockInBands, part: &RowsAway, step: usize, j: usize) -> Report {
        let hot = self.memory.rows.hot;
        // SAFETY: the caller's promise.
        unsafe {
            let carry = self.below_gap(part.upper, step);
            if j == 0 {
                carry.fill([[0.0; CHUNK]; CARRY_PLANES]);
            } else if part.starts_at_gap(step, j) {
                self.lift(j, 0, carry, &[]);
                copy_motion(self.above_gap(part.lower, step), rows(hot, self.layout.chunks, j, 1));
            }
            self.step_row(band, block, step, j, self.row_above(j), carry)
        }
    }

    /// Takes a step of the gap between a band and the one below it.
    ///
    /// # Safety
    /// As for [`Plan::step_away`].
    #[inline(never)]
    pub(super) unsafe fn fill_cut(&self, band: u32, block: &BlockInBands) -> Report {
        let [first, end] = block.rows_of_cut(band as usize);
        let (edge, mut report) = (Edge::Cut(band as usize), Report::default());
        let Some(step) = self.step_in_block().filter(|_| self.found.is_ok()) else { return report };
        for j in first..end {
            // SAFETY: the gaps have no row in common, with the body's neither.
            unsafe {
                let above = if j + 1 < end { self.row_above(j) } else { self.above_gap(edge, step) };
                report = report.merged(self.step_row(band, block, step, j, above, self.below_gap(edge, step)));
            }
        }
        report
    }

    /// Sweeps row j in a step of a block.
    ///
    /// # Safety
    /// Nothing else uses the row and what belongs to it, and nothing changes the row above.
    #[inline(never)]
    unsafe fn step_row(
        &self,
        band: u32,
        block: &BlockInBands,
        step: usize,
        j: usize,
        above: &[Chunk<HOT_PLANES>],
        carry: &mut [Chunk<CARRY_PLANES>],
    ) -> Report {
        // SAFETY: the caller's promise; there are pulls of every step and row.
        unsafe {
            let beside = Beside { above, carry, kept: self.scratch(band).kept, viscous: &mut [] };
            let mut row = self.rows(step, [j, j + 1], 0, beside);
            // A row comes from memory in the first step alone.
            let terms = self.terms(self.fetches && step == 0);
            let mut report = row.sweep(&terms);
            report.non_finite |= row.own.ranges.first().is_some_and(|range| block.is_met(step, j, *range));
            report
        }
    }

    /// The row above row j, none above the top row.
    ///
    /// # Safety
    /// Nothing changes it while it is held.
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
        Beside { above, carry, kept, viscous }: Beside<'r>,
    ) -> Rows<'r> {
        let (layout, memory, noted) = (&self.layout, &self.memory, step * self.layout.nodes_y);
        // SAFETY: the caller's promise.
        unsafe {
            let mut own = rows_of(&memory.rows, layout, [first, end], step);
            Rows {
                first,
                ply,
                above,
                viscous: self.viscous_rows([first, end], ply, take(&mut own.past), viscous),
                net: self.net(ply),
                carry,
                kept,
                pulls: if layout.supports {
                    part_mut(memory.pulls.cast(), noted + first..noted + end)
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
        let (layout, memory) = (&self.layout, &self.memory);
        let line = if layout.has(Feature::Curved) { ply } else { 0 };
        // SAFETY: they are as long, and nothing changes them.
        unsafe { Net { columns: rows(memory.columns, layout.chunks, line, 1), lines: &*memory.lines } }
    }

    /// The part of a pass that is not cut.
    ///
    /// # Safety
    /// All bands have been swept; the simulation's arrays and the scratch are used by nothing else.
    pub(super) unsafe fn close(&self, system: &mut System<'_>, report: Report) -> Result<(), Failure> {
        let gathered = self.found?;
        if let Some(block) = &self.block {
            return block.close(system, &gathered, report);
        }
        for ply in 0..system.layout.plies {
            // SAFETY: no band is being swept.
            let [first, end] = unsafe { self.rows_of_ply(ply) };
            if first < end {
                system.set_awake(ply, [first, end]);
            }
        }
        explicit::end_sweep(system, &gathered);
        explicit::finish_step(system, &gathered, report)?;
        explicit::end_step(system);
        Ok(())
    }
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
