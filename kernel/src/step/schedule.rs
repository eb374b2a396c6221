//! Schedule of a block of steps: which row takes which step when, on one thread or in bands.
//!
//! Method: a sheet that does not stay in the caches takes several steps in one block, so that a row comes
//! from memory once and not once a step. A row can take a step as soon as the row below it, whose force it
//! needs, has taken the same step, and the row above it the one before; with viscosity, whose moments reach
//! one row further (M17), the second row above it.
//! So step s is `lag * s` rows below the first one, and rows away from the body take all steps of the block
//! in this skewed order. Rows that the body may reach take them one by one, with contact and all else that
//! belongs to a step.
//! One thread takes the rows below the body, those near it, and those above it. In bands all rows away from
//! the body come first, each band's in one pass: at an edge that is not the sheet's they are `lag` rows less
//! in each step, since rows of other bands do not follow. What is left are gaps, between two bands and around
//! the body, that grow by `lag` rows at both ends in each step and take a step a pass. A row above a gap
//! needs the forces from below: they are found from the gap's row, which has come as far. A gap needs of each
//! step the displacements of the row above it (and its moments) and the forces from the row below it: both
//! are kept.
//! Each row has the neighbours and the forces that it has in single steps: the bits are the same.
//! Limits: one ply, velocity Verlet, nothing that takes two passes or looks at the whole sheet between two
//! steps (`Layout::block_steps`); every row awake; no fixed node within the body's reach. Otherwise, and for
//! what is left of less than a block, single steps are taken. The surface of the body crosses less than a
//! spacing in a step, so what it may reach in a block is known; a row beyond [`APPROACH`] that comes so near
//! within a block, at some 2e4 m/s, is a lost state. Where a cut between two bands lies close to the body's
//! gap, that gap takes the place of the cut; a sheet of few rows has fewer bands away from the body.
//! Reference: G. Wellein, G. Hager, T. Zeiser, M. Wittmann, H. Fehske, Proc. 33rd IEEE Int. Computer Software
//! and Applications Conf. (2009) 579 (wavefront parallelization); D. Wonnacott, Int. J. Parallel Programming
//! 30 (2002) 181 (time skewing for parallel computers).

use crate::contact::search::{ROUNDING, Search};
use crate::ground::lanes::InstructionSet;
use crate::ground::ranges::range_of;
use crate::memory::layout::Layout;
use crate::memory::system::System;
use crate::scene::features::Feature;
use crate::sheet::places::rest_offset;
use core::ops::Range;

/// Distance by which a row beyond the body's reach may come nearer within a block, spacings.
const APPROACH: f64 = 8.0;

/// Steps of a block with these instructions. The wider they are, the more a sweep waits for memory.
pub(crate) fn block_steps(layout: &Layout, instructions: InstructionSet) -> usize {
    let pays = matches!(instructions, InstructionSet::Avx512 | InstructionSet::Avx2);
    if pays { layout.block_steps as usize } else { 1 }
}

/// Block of steps: its rows near the body, tiles and gaps.
#[derive(Clone, Copy)]
pub(crate) struct Block {
    /// Rows [first, end) that the body may reach.
    pub near: [usize; 2],
    pub steps: usize,
    rows: usize,
    /// Rows by which a step lags the one before.
    lag: usize,
    /// Bands that have rows away from the body; 0 for one thread that takes the rows in turn.
    bands: u32,
    reach: Reach,
}

/// From where to where along a column the body may reach within a block.
#[derive(Clone, Copy)]
struct Reach {
    /// The ends, m.
    low: f64,
    high: f64,
    /// Spacing of the nodes along x, m, the unit of displacements.
    h: f64,
    /// Spacing of the rows at rest in units of h.
    rise: f64,
    nodes_y: u32,
}

/// End of the rows of a [`Tile`].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Edge {
    /// Edge of the sheet.
    Sheet,
    /// Below it, rows that have taken all steps of the block.
    Done,
    /// The gap in which the body is.
    Body,
    /// The gap between two bands, by the number of the band above it.
    Cut(u32),
}

/// Neighbouring rows [first, end) away from the body that take the steps of a block in skewed order (time
/// skewing): `lag` rows less in each step at a gap.
#[derive(Clone, Copy)]
pub(crate) struct Tile {
    rows: [usize; 2],
    pub lower: Edge,
    pub upper: Edge,
    steps: usize,
    lag: usize,
}

impl Tile {
    /// Wavefronts r of the tile: row r - lag s takes step s.
    pub fn wavefronts(&self) -> Range<usize> {
        let [first, end] = self.rows;
        first..end + self.lag * (self.steps - 1)
    }

    /// Row that takes a step in wavefront r, if one does.
    pub fn row(&self, r: usize, step: usize) -> Option<usize> {
        r.checked_sub(self.lag * step).filter(|j| self.rows_at(step).contains(j))
    }

    /// Rows that take a step.
    fn rows_at(&self, step: usize) -> Range<usize> {
        let Tile { rows: [first, end], lower, upper, steps, lag } = *self;
        let lowest = match lower {
            Edge::Sheet => first,
            Edge::Done => first + lag * (steps - 1 - step),
            Edge::Body | Edge::Cut(_) => first + lag * step,
        };
        lowest..if upper == Edge::Sheet { end } else { end.saturating_sub(lag * step) }
    }

    /// Whether row j is the lowest in a step, above a gap.
    pub fn starts_at_gap(&self, step: usize, j: usize) -> bool {
        matches!(self.lower, Edge::Body | Edge::Cut(_)) && j == self.rows_at(step).start
    }
}

impl Block {
    /// The block that may begin now; None for single steps: beyond `most` steps, if the body may reach a
    /// fixed node or half of the rows, or if a force window of attachments that slip ends within it.
    /// `band_count`: 0 for one thread that takes the rows in turn.
    pub fn plan(system: &System<'_>, most: u64, band_count: u32) -> Option<Block> {
        let (steps, rows) = (system.network.block_steps, system.network.layout.nodes_y);
        // So that outcomes are tested after a block.
        let is_due = steps > 1 && most >= steps as u64 && system.state.step.is_multiple_of(steps as u64);
        // Energy dissipated by attachments in a block is added up at its end, too late for a window that ends
        // within it.
        let step = system.state.step;
        let window_ends = system.network.clamps.are_tested(step + 1, step + steps as u64);
        if !is_due || window_ends || system.network.rows_to_step(0) != [0, rows] {
            return None;
        }
        let (body, h) = (&system.state.body, system.network.scene.sheet.spacing);
        // The body's surface crosses less than a spacing in a step (`Model::too_fast`).
        let margin = system.network.scene.largest_spacing() + steps as f64 * h;
        let [_, half, _] = system.solid.half_extents(&body.orientation).map(|extent| extent + margin * ROUNDING);
        let (low, high) = (body.position.y - half, body.position.y + half);
        let rise = system.network.directions.front.vertical.rest.spacing;
        let reach = Reach { low, high, h, rise, nodes_y: system.network.scene.sheet.nodes_y };
        let range = |j: usize| system.network.arrays.rows.ranges.get(j).copied().unwrap_or_default();
        let comes_near = |&j: &usize| reach.meets(j, range(j), APPROACH * h);
        let lag = if system.network.layout.has(Feature::Viscosity) { 2 } else { 1 };
        let near = match ((0..rows).find(comes_near), (0..rows).rev().find(comes_near)) {
            // What is read beside a gap and what is written there are different rows.
            (Some(first), Some(last)) => [first, (last + 1).max(first + width(lag)).min(rows)],
            _ => [0, 0],
        };
        let [first, end] = near;
        let search = Search::new(&system.solid, body, h, margin);
        let is_held = (first..end).any(|j| {
            let [a, b, c, d] = system.network.arrays.rows.runs.get(j).copied().unwrap_or([0; 4]);
            (a..b).chain(c..d).any(|i| search.candidate(&system.network.position(i as usize, j)).is_some())
        });
        // Far more rows than gaps; at least 1, so that no division by zero has to be compiled in.
        let bands = if band_count == 0 { 0 } else { band_count.min((rows / (4 * lag * steps).max(1)) as u32).max(1) };
        (!is_held && 2 * (end - first + lag * steps) <= rows).then_some(Block { near, steps, rows, lag, bands, reach })
    }

    /// Rows [first, end), those that the body may reach among them, that take a step one by one.
    pub fn rows_near(&self, step: usize) -> [usize; 2] {
        let ([first, end], lag) = (self.near, self.lag);
        if self.bands > 0 && first == end {
            return [0, 0];
        }
        let above = if self.bands > 0 { step } else { self.steps - 1 - step };
        [first.saturating_sub(lag * step), (end + lag * above).min(self.rows)]
    }

    /// First row of the gap between a band and the one below it; None at the sheet's edges, and close to the
    /// body's gap, which then takes its place.
    fn gap_start(&self, band: u32) -> Option<usize> {
        let Block { near: [first, end], steps, rows, lag, bands, .. } = *self;
        // Gaps stay apart: each grows by `lag` rows at both ends in each step.
        let (row, far) = (rows * band as usize / bands.max(1) as usize, 2 * lag * steps);
        (band > 0 && band < bands && (first == end || row + far < first || row > end + far)).then_some(row)
    }

    /// Rows [first, end) of the gap between a band and the one below it, in a step.
    pub fn rows_of_gap(&self, step: usize, band: u32) -> [usize; 2] {
        self.gap_start(band).map_or([0, 0], |row| [row - self.lag * step, row + width(self.lag) + self.lag * step])
    }

    /// The one of [`Block::tiles`] above the body, or that below it, alone on the stack.
    #[inline(never)]
    pub fn tile(&self, band: u32, is_above: bool) -> Tile {
        let [below, above] = self.tiles(band);
        if is_above { above } else { below }
    }

    /// Rows away from the body that a band steps, below the body and above it; all of them on one thread. Any
    /// may have none.
    fn tiles(&self, band: u32) -> [Tile; 2] {
        let Block { near: [near, beyond], steps, rows, lag, bands, .. } = *self;
        let tile = |rows, lower, upper| Tile { rows, lower, upper, steps, lag };
        if bands == 0 {
            return [tile([0, near], Edge::Sheet, Edge::Body), tile([beyond, rows], Edge::Done, Edge::Sheet)];
        }
        let (first, lower) = match self.gap_start(band) {
            _ if band == 0 => (0, Edge::Sheet),
            Some(row) => (row + width(lag), Edge::Cut(band)),
            None => (beyond, Edge::Body),
        };
        let (end, upper) = match self.gap_start(band + 1) {
            _ if band + 1 == bands => (rows, Edge::Sheet),
            Some(row) => (row, Edge::Cut(band + 1)),
            None => (near, Edge::Body),
        };
        if band >= bands {
            [tile([0, 0], lower, lower); 2]
        } else if near < beyond && first <= near && beyond <= end {
            [tile([first, near], lower, Edge::Body), tile([beyond, end], Edge::Body, upper)]
        } else {
            [tile([first, end.max(first)], lower, upper), tile([end, end], lower, upper)]
        }
    }

    /// Whether a row that was to be beyond the body's reach is not after a step, before the last one.
    pub fn is_met(&self, step: usize, j: usize, range: [u32; 4]) -> bool {
        let [near, beyond] = self.near;
        !(near..beyond).contains(&j) && step + 1 < self.steps && self.reach.meets(j, range, 0.0)
    }

    /// Whether any of neighbouring rows, the first of them row j, is met ([`Block::is_met`]).
    pub fn are_met(&self, step: usize, j: usize, ranges: &[[u32; 4]]) -> bool {
        ranges.iter().zip(j..).any(|(range, j)| self.is_met(step, j, *range))
    }
}

/// Rows that a gap has at first: one; with viscosity one whose moments are found from below, and two that
/// the row above the gap reads. So no band reads what another one writes in the same pass.
fn width(lag: usize) -> usize {
    2 * lag - 1
}

impl Reach {
    /// Whether row j, displaced by `range`, comes as near as `slack`, m.
    fn meets(&self, j: usize, [lowest, highest, ..]: [u32; 4], slack: f64) -> bool {
        let [lowest, highest] = range_of([lowest, highest]);
        let rest = rest_offset(j, self.nodes_y) * self.rise;
        (rest + highest) * self.h >= self.low - slack && (rest + lowest) * self.h <= self.high + slack
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ground::random::splitmix64;
    use std::vec;
    use std::vec::Vec;

    const STEPS: usize = 8;

    /// Steps taken by the rows, and ghost rows and forces kept for the gaps.
    struct Sheet {
        lag: usize,
        /// Steps that each row has taken.
        taken: Vec<usize>,
        /// By edge and step: the row whose displacements are kept, and the row whose forces upwards are.
        aboves: Vec<(Edge, usize, usize)>,
        carries: Vec<(Edge, usize, usize)>,
    }

    impl Sheet {
        /// Whether all of some rows have come to a step, those that there are.
        fn are_at(&self, step: usize, mut rows: core::ops::RangeInclusive<usize>) -> bool {
            rows.all(|j| self.taken.get(j).is_none_or(|&taken| taken == step))
        }

        /// Takes a step of row j with the forces from below that are kept for an edge.
        fn step(&mut self, step: usize, j: usize, below: Option<Edge>) {
            assert_eq!(self.taken[j], step, "row {j}");
            if let Some(edge) = below {
                // The last to be kept.
                let kept = self.carries.iter().rfind(|&&(of, at, _)| (of, at) == (edge, step));
                assert!(kept.copied() == j.checked_sub(1).map(|below| (edge, step, below)), "row {j}, step {step}");
            }
            self.taken[j] += 1;
        }

        /// Takes a step of row j of a tile. Returns the rows that it looks at.
        fn step_away(&mut self, tile: &Tile, step: usize, j: usize) -> Vec<usize> {
            assert!(self.are_at(step, j..=j + self.lag), "above row {j}, step {step}");
            let mut seen: Vec<usize> = (j..=j + self.lag).collect();
            let starts = tile.starts_at_gap(step, j);
            if starts {
                let below = j.saturating_sub(self.lag)..=j;
                assert!(self.are_at(step, below.clone()), "below row {j}, step {step}");
                self.aboves.push((tile.lower, step, j));
                seen.extend(below);
            }
            self.step(
                step,
                j,
                (!starts && j > 0).then_some(if tile.lower == Edge::Done { Edge::Body } else { tile.upper }),
            );
            self.carries.push((if tile.lower == Edge::Done { Edge::Body } else { tile.upper }, step, j));
            seen
        }

        /// The rows of a gap in a step, or those near the body on one thread.
        fn fill(&mut self, step: usize, [first, end]: [usize; 2], edge: Edge, follows: bool) {
            for j in first..end {
                let (top, rows) = (j + 1 == end, self.taken.len());
                if top && end < rows && !follows {
                    assert!(self.aboves.contains(&(edge, step, end)), "above row {j}, step {step}");
                } else {
                    let last = if follows { j + self.lag } else { (j + self.lag).min(end - 1) };
                    assert!(self.are_at(step, j..=last), "above row {j}, step {step}");
                }
                self.step(step, j, (j == first && first > 0).then_some(edge));
                self.carries.push((edge, step, j));
            }
        }
    }

    /// Steps and rows of a tile in their order.
    fn order_of(tile: &Tile) -> impl Iterator<Item = (usize, usize)> {
        let at = move |r: usize| (0..STEPS).filter_map(move |step| Some((step, tile.row(r, step)?)));
        tile.wavefronts().flat_map(at)
    }

    /// Takes a block, its bands in the order that `key` gives; `of`: bands, 0 for one thread. Returns how
    /// many bands had rows away from the body.
    fn take(near: [usize; 2], rows: usize, lag: usize, of: u32, key: u64) -> usize {
        let bands = if of == 0 { 0 } else { of.min((rows / (4 * lag * STEPS)) as u32).max(1) };
        let reach = Reach { low: 0.0, high: 0.0, h: 1.0, rise: 1.0, nodes_y: rows as u32 };
        let block = Block { near, steps: STEPS, rows, lag, bands, reach };
        let mut sheet = Sheet { lag, taken: vec![0; rows], aboves: Vec::new(), carries: Vec::new() };
        if of == 0 {
            let [below, above] = block.tiles(0);
            order_of(&below).for_each(|(step, j)| drop(sheet.step_away(&below, step, j)));
            (0..STEPS).for_each(|step| sheet.fill(step, block.rows_near(step), Edge::Body, true));
            order_of(&above).for_each(|(step, j)| drop(sheet.step_away(&above, step, j)));
            assert!(sheet.taken.iter().all(|&taken| taken == STEPS));
            return 0;
        }
        let order = |pass: usize| (0..of).map(move |k| (k + key as u32 + pass as u32) % of);
        // Which band writes which row in the first pass, with moments, and which rows it looks at.
        let (mut written, mut seen) = (vec![None; rows], Vec::new());
        for band in order(0) {
            for tile in block.tiles(band) {
                for (step, j) in order_of(&tile) {
                    seen.extend(sheet.step_away(&tile, step, j).into_iter().map(|j| (band, j)));
                    for by in written.iter_mut().skip(j).take(lag) {
                        assert!(by.is_none_or(|by| by == band), "row {j}");
                        *by = Some(band);
                    }
                }
            }
        }
        for (band, j) in seen {
            assert!(written.get(j).is_none_or(|by| by.is_none_or(|by| by == band)), "row {j} is read by band {band}");
        }
        for step in 0..STEPS {
            sheet.fill(step, block.rows_near(step), Edge::Body, false);
            order(step).for_each(|band| sheet.fill(step, block.rows_of_gap(step, band), Edge::Cut(band), false));
        }
        assert!(sheet.taken.iter().all(|&taken| taken == STEPS));
        (0..of).filter(|&band| written.contains(&Some(band))).count()
    }

    #[test]
    fn every_row_takes_every_step_when_all_that_it_needs_is_there() {
        for k in 0..3000 {
            let number = |n: u64| splitmix64(100 * k + n) as usize;
            let (rows, lag) = (80 + number(0) % 400, 1 + number(5) % 2);
            let tall = width(lag) + number(1) % (rows / 2 - lag * STEPS - width(lag) + 1);
            let first = number(2) % (rows - tall + 1);
            // Now and then at an edge of the sheet, or nowhere.
            let near =
                [[first, first + tall], [0, tall], [rows - tall, rows], [0, 0]][(number(3) % 6).saturating_sub(2)];
            take(near, rows, lag, (number(4) % 13) as u32, k);
        }
    }

    #[test]
    fn the_body_lies_between_two_bands_or_within_one() {
        // The body's gap replaces the cut in the middle; else it has a band of its own on both sides.
        assert_eq!(take([480, 520], 1000, 1, 2, 0), 2);
        assert_eq!(take([200, 240], 1000, 1, 2, 0), 2);
        assert_eq!(take([200, 240], 1000, 1, 12, 0), 12);
        // 32 rows a band at least, and twice as many with viscosity.
        assert_eq!(take([30, 40], 400, 1, 20, 0), 12);
        assert_eq!(take([30, 40], 400, 2, 20, 0), 6);
        // Both cuts would lie close to the body's gap, which leaves nothing between them.
        assert_eq!(take([80, 120], 200, 1, 3, 0), 2);
    }
}
