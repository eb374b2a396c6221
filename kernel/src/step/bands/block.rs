//! A block of steps (`step/blocks.rs`) in bands: what each does of it, and in which order.
//!
//! Method: first every band takes all steps of its rows away from the body that do not need rows of other
//! bands: at an edge of its rows it is a row less in each step. That is one pass. What is left are gaps that
//! grow by a row at both ends in each step: one row wide at first between two bands, and the rows that the
//! body may reach. They take a step a pass; the body's gap is cut into bands as a whole sheet is. A row above
//! a gap needs the forces from below: they are found from the gap's row, which has come as far. A gap needs
//! the displacements of the row above it and the forces from the row below it as they were in each step: both
//! are kept.
//! Limits: those of a block; no viscosity. Where a cut lies close to the body's gap, that gap takes the place
//! of the cut; a sheet of few rows has fewer bands away from the body.
//! Reference: D. Wonnacott, Int. J. Parallel Programming 30 (2002) 181 (time skewing for parallel computers).
#![deny(unsafe_code)]

use crate::contact::search::Gathered;
use crate::ground::error::Failure;
use crate::memory::system::System;
use crate::sheet::segments::Report;
use crate::step::blocks::{self, Block};
use core::ops::Range;

/// How far bands have come in a block.
#[derive(Clone, Copy)]
pub(crate) struct BlockInBands {
    block: Block,
    /// Bands that have rows away from the body.
    bands: usize,
    part: Part,
}

/// What bands do of a block in one pass.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    Away,
    /// A step of the gaps.
    Near(usize),
}

/// An end of the rows of a band.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Edge {
    /// Edge of the sheet.
    Sheet,
    /// The gap in which the body is.
    Body,
    /// A gap of one row, by the number of the band above it.
    Cut(usize),
}

/// Neighbouring rows [first, end) that a band steps away from the body, a row less in each step at an edge
/// that is not the sheet's.
#[derive(Clone, Copy)]
pub(crate) struct RowsAway {
    rows: [usize; 2],
    pub lower: Edge,
    pub upper: Edge,
}

impl RowsAway {
    /// Numbers in the skewed order: row r - s takes step s of `steps` where r is the number.
    pub fn numbers(&self, steps: usize) -> Range<usize> {
        let [first, end] = self.rows;
        first..if self.upper == Edge::Sheet && first < end { end + steps - 1 } else { end }
    }

    /// The row that takes a step at number r, if one does.
    pub fn row(&self, r: usize, step: usize) -> Option<usize> {
        let [first, end] = self.rows;
        let lowest = if self.lower == Edge::Sheet { first } else { first + step };
        r.checked_sub(step).filter(|j| (lowest..end).contains(j))
    }

    /// Whether row j is the lowest in a step, next to a gap.
    pub fn starts_at_gap(&self, step: usize, j: usize) -> bool {
        self.lower != Edge::Sheet && j == self.rows[0] + step
    }
}

impl BlockInBands {
    /// The block that may begin now for `of` bands, as [`Block::plan`]; none with viscosity, whose gaps would
    /// grow by two rows in a step.
    pub fn start(system: &mut System<'_>, of: usize, most: u64) -> Option<BlockInBands> {
        let block = Block::plan(system, most).filter(|block| block.lag == 1)?;
        blocks::begin(system);
        // Far more rows than gaps; at least 1, so that no division by zero has to be compiled in.
        let bands = of.min(block.rows / (4 * block.steps).max(1)).max(1);
        Some(BlockInBands { block, bands, part: Part::Away })
    }

    /// What follows; None after the last part.
    pub fn next(self) -> Option<BlockInBands> {
        let step = if let Part::Near(step) = self.part { step + 1 } else { 0 };
        (step < self.block.steps).then_some(BlockInBands { part: Part::Near(step), ..self })
    }

    /// Whether nothing of the block is done.
    pub fn is_at_start(&self) -> bool {
        self.part == Part::Away
    }

    /// Steps of the block.
    pub fn steps(&self) -> usize {
        self.block.steps
    }

    /// The step of the gaps that is to be taken, if one is.
    pub fn step(&self) -> Option<usize> {
        if let Part::Near(step) = self.part { Some(step) } else { None }
    }

    /// Rows [first, end) of the body's gap in the step that is to be taken.
    pub fn rows_near(&self) -> [usize; 2] {
        let ([first, end], rows) = (self.block.near, self.block.rows);
        match self.part {
            Part::Near(step) if first < end => [first.saturating_sub(step), (end + step).min(rows)],
            _ => [0, 0],
        }
    }

    /// The row of the gap between a band and the one below it; None at the sheet's edges, and close to the
    /// body's gap, which then takes its place.
    fn cut(&self, band: usize) -> Option<usize> {
        let BlockInBands { block: Block { near: [first, end], steps, rows, .. }, bands, .. } = *self;
        let row = rows * band / bands.max(1);
        let is_far = first == end || row + 2 * steps < first || row > end + 2 * steps;
        (band > 0 && band < bands && is_far).then_some(row)
    }

    /// What a band steps away from the body, of which both may have no rows.
    #[inline(never)]
    pub fn rows_away(&self, band: usize) -> [RowsAway; 2] {
        let [near, beyond] = self.block.near;
        let (first, lower) = match self.cut(band) {
            _ if band == 0 => (0, Edge::Sheet),
            Some(row) => (row + 1, Edge::Cut(band)),
            None => (beyond, Edge::Body),
        };
        let (end, upper) = match self.cut(band + 1) {
            _ if band + 1 == self.bands => (self.block.rows, Edge::Sheet),
            Some(row) => (row, Edge::Cut(band + 1)),
            None => (near, Edge::Body),
        };
        let of = |rows, lower, upper| RowsAway { rows, lower, upper };
        if band >= self.bands {
            [of([0, 0], lower, upper); 2]
        } else if near < beyond && first <= near && beyond <= end {
            [of([first, near], lower, Edge::Body), of([beyond, end], Edge::Body, upper)]
        } else {
            [of([first, end], lower, upper), of([end, end], lower, upper)]
        }
    }

    /// Rows [first, end) of the gap between a band and the one below it, in the step that is to be taken.
    pub fn rows_of_cut(&self, band: usize) -> [usize; 2] {
        match (self.part, self.cut(band)) {
            (Part::Near(step), Some(row)) => [row - step, row + 1 + step],
            _ => [0, 0],
        }
    }

    /// What lies under the body in the step near it that is to be taken, if one is.
    pub fn look_ahead(&self, system: &mut System<'_>) -> Result<Gathered, Failure> {
        if self.is_at_start() { Ok(Gathered::default()) } else { self.block.look_ahead(system) }
    }

    /// As [`Block::is_met`].
    pub fn is_met(&self, step: usize, j: usize, range: [u32; 4]) -> bool {
        self.block.is_met(step, j, range)
    }

    /// What is left of the part when all bands have done theirs.
    pub fn close(&self, system: &mut System<'_>, gathered: &Gathered, report: Report) -> Result<(), Failure> {
        if let Part::Near(step) = self.part {
            self.block.close_near(system, step, self.rows_near(), gathered, report)?;
        } else if report.non_finite {
            return Err(Failure::NonFinite);
        } else {
            system.failed_segments += report.newly_failed;
        }
        if self.next().is_none() {
            blocks::end(system);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ground::random::splitmix64;
    use std::vec;
    use std::vec::Vec;

    const STEPS: usize = 8;

    /// How far the rows are, and what is kept for the gaps.
    struct Sheet {
        /// Steps that each row has taken.
        taken: Vec<usize>,
        /// By edge and step: the row whose displacements are kept, and the row whose forces upwards are.
        aboves: Vec<(Edge, usize, usize)>,
        carries: Vec<(Edge, usize, usize)>,
    }

    impl Sheet {
        /// Takes a step of row j, which must be due. `above`, `below`: the edges for which the row above is
        /// kept, and the forces from below.
        fn step(&mut self, step: usize, j: usize, above: Option<Edge>, below: Option<Edge>) {
            assert_eq!(self.taken[j], step, "row {j}");
            match above {
                Some(edge) => assert!(self.aboves.contains(&(edge, step, j + 1)), "above row {j}, step {step}"),
                None => assert!(self.taken.get(j + 1).is_none_or(|&taken| taken == step), "above row {j}, step {step}"),
            }
            if let Some(edge) = below {
                // The last to be kept.
                let kept = self.carries.iter().rfind(|&&(of, at, _)| (of, at) == (edge, step));
                assert!(kept.copied() == j.checked_sub(1).map(|below| (edge, step, below)), "row {j}, step {step}");
            }
            self.taken[j] += 1;
        }

        /// The rows of a gap in a step.
        fn fill(&mut self, step: usize, [first, end]: [usize; 2], edge: Edge) {
            for j in first..end {
                let above = (j + 1 == end && end < self.taken.len()).then_some(edge);
                self.step(step, j, above, (j == first).then_some(edge));
            }
        }
    }

    /// Takes a block, its bands in the order that `key` gives. Returns how many bands had rows away from the
    /// body.
    fn take(near: [usize; 2], rows: usize, of: usize, key: u64) -> usize {
        let bands = of.min(rows / (4 * STEPS)).max(1);
        let mut block = BlockInBands { block: Block::of_rows(near, STEPS, rows), bands, part: Part::Away };
        let mut sheet = Sheet { taken: vec![0; rows], aboves: Vec::new(), carries: Vec::new() };
        let order = |pass: usize| (0..of).map(move |k| (k + key as usize + pass) % of);
        // Which band writes which row in the first pass, and which rows it looks at.
        let (mut written, mut seen) = (vec![None; rows], Vec::new());
        for band in order(0) {
            for part in block.rows_away(band) {
                let steps = part.numbers(STEPS).flat_map(|r| (0..STEPS).map(move |step| (step, part.row(r, step))));
                for (step, j) in steps.filter_map(|(step, j)| Some((step, j?))) {
                    let at_gap = part.starts_at_gap(step, j);
                    if at_gap {
                        assert_eq!(sheet.taken[j - 1], step, "below row {j}");
                        sheet.aboves.push((part.lower, step, j));
                        seen.push((band, j - 1));
                    }
                    seen.push((band, j + 1));
                    sheet.step(step, j, None, (!at_gap && j > 0).then_some(part.upper));
                    sheet.carries.push((part.upper, step, j));
                    assert!(written[j].is_none_or(|by| by == band), "row {j}");
                    written[j] = Some(band);
                }
            }
        }
        for (band, j) in seen {
            assert!(written.get(j).is_none_or(|by| by.is_none_or(|by| by == band)), "row {j} is read by band {band}");
        }
        while let Some(next) = block.next() {
            block = next;
            let step = block.step().unwrap();
            sheet.fill(step, block.rows_near(), Edge::Body);
            order(step).for_each(|band| sheet.fill(step, block.rows_of_cut(band), Edge::Cut(band)));
        }
        assert!(sheet.taken.iter().all(|&taken| taken == STEPS));
        (0..of).filter(|&band| written.contains(&Some(band))).count()
    }

    #[test]
    fn every_row_takes_every_step_when_all_that_it_needs_is_there() {
        for k in 0..3000 {
            let number = |n: u64| splitmix64(100 * k + n) as usize;
            let rows = 40 + number(0) % 400;
            let tall = number(1) % (rows / 2 - STEPS + 1);
            let first = number(2) % (rows - tall + 1);
            // Now and then at an edge of the sheet, or nowhere.
            let near =
                [[first, first + tall], [0, tall], [rows - tall, rows], [0, 0]][(number(3) % 6).saturating_sub(2)];
            take(if near[0] == near[1] { [0, 0] } else { near }, rows, 1 + number(4) % 12, k);
        }
    }

    #[test]
    fn the_body_lies_between_two_bands_or_within_one() {
        // Its gap takes the place of the cut in the middle; else it has a band of its own on both sides.
        assert_eq!(take([480, 520], 1000, 2, 0), 2);
        assert_eq!(take([200, 240], 1000, 2, 0), 2);
        assert_eq!(take([200, 240], 1000, 12, 0), 12);
        // 32 rows a band at least.
        assert_eq!(take([30, 40], 400, 20, 0), 12);
        // Both cuts would lie close to the body's gap, which leaves nothing between them.
        assert_eq!(take([80, 120], 200, 3, 0), 2);
    }
}
