//! A run of rows and what sweeping it takes: the whole sheet's, or one band's.

use crate::body::pose::Vector;
use crate::ground::lanes::{self, InstructionSet, Job, Lane};
use crate::ground::planes::{
    self, CARRY_PLANES, CHUNK, Chunk, HISTORY_PLANES, HOT_PLANES, MARK_PLANES, PUSH_PLANES, RATE_PLANES,
    STRENGTH_PLANES, YARN_PLANES,
};
use crate::ground::ranges::{NOT_KEPT, end_of_range, spread};
use crate::memory::arrays::Arrays;
use crate::memory::layout::Layout;
use crate::memory::viscous_rows::Viscous;
use crate::scene::features::Feature;
use crate::sheet::direction::Directions;
use crate::sheet::grading::Net;
use crate::sheet::sweep::{Constants, Pass, Report, Row, YarnRow};
use crate::sheet::symmetry::Line;
use crate::yarn::rate::Rates;
use crate::yarn::toe::Toe;

/// Constants of a sweep.
#[derive(Clone, Copy)]
pub(crate) struct Terms<'t> {
    pub layout: &'t Layout,
    pub directions: &'t Directions,
    /// The toe of marked segments.
    pub toe: Toe,
    /// Dependence on the rate of strain.
    pub rates: &'t Rates,
    /// Whether rows are fetched from memory ahead of their turn.
    pub fetches: bool,
    pub instructions: InstructionSet,
}

impl<'t> Terms<'t> {
    /// The hot pass with these constants.
    pub fn pass<'p>(&'p self, net: &'p Net<'p>, ply: usize) -> Pass<'p> {
        Pass {
            horizontals: self.layout.x.segments(),
            verticals: self.layout.nodes_x,
            directions: self.directions.of_ply(ply),
            toe: self.toe,
            net,
            rates: self.rates,
            fetches: self.fetches,
            instructions: self.instructions,
        }
    }

    /// Constants of the segments of the k-th row of `yarn` and `strength`, which are empty where nothing is drawn, and of
    /// `logarithms`, empty where yarn does not depend on the rate.
    pub fn yarn_row<'y>(
        &self,
        yarn: &'y [Chunk<YARN_PLANES>],
        strength: &'y [Chunk<STRENGTH_PLANES>],
        logarithms: &'y [Chunk<RATE_PLANES>],
        k: usize,
        ply: usize,
    ) -> YarnRow<'y>
    where
        't: 'y,
    {
        let constants = if self.layout.has_constants() {
            Constants::Stochastic(planes::row(yarn, self.layout.chunks, k))
        } else {
            Constants::Uniform(self.directions.of_ply(ply))
        };
        let chunks = self.layout.chunks;
        YarnRow {
            constants,
            strength: planes::row(strength, chunks, k),
            logarithms: if logarithms.is_empty() { &[] } else { planes::row(logarithms, chunks, k) },
        }
    }
}

/// Neighbouring rows with all that belongs to them, to be swept from the lowest up.
pub(crate) struct Rows<'r> {
    /// Number of the first row.
    pub first: usize,
    /// Their ply.
    pub ply: usize,
    pub hot: &'r mut [Chunk<HOT_PLANES>],
    /// The row above the last, not swept yet; empty above the top row.
    pub above: &'r [Chunk<HOT_PLANES>],
    pub history: &'r mut [Chunk<HISTORY_PLANES>],
    /// Constants from the first row on; empty for uniform yarn.
    pub yarn: &'r [Chunk<YARN_PLANES>],
    /// Critical stretches from the first row on; empty where all have the same.
    pub strength: &'r [Chunk<STRENGTH_PLANES>],
    /// Logarithms of the rate from the first row on; empty where yarn does not depend on it.
    pub logarithms: &'r [Chunk<RATE_PLANES>],
    /// The toe's marks from the first row on; empty for no toe.
    pub marks: &'r [Chunk<MARK_PLANES>],
    /// What viscosity changes of the velocities; empty for none.
    pub pushes: &'r mut [Chunk<PUSH_PLANES>],
    pub viscous: Viscous<'r>,
    /// Energy that the rate takes, to which that of viscosity is added, one entry a row; empty without both.
    pub taken: &'r mut [f64],
    /// Velocities along z before the sweep; empty for a single sheet.
    pub before: &'r mut [[f64; CHUNK]],
    /// Least and greatest displacement along y and x, one entry a row.
    pub ranges: &'r mut [[u32; 4]],
    /// Fixed nodes, one entry a row.
    pub runs: &'r [[u32; 4]],
    /// Bars and widths of a graded network.
    pub net: Net<'r>,
    /// Vertical forces from the row below the first.
    pub carry: &'r mut [Chunk<CARRY_PLANES>],
    pub kept: &'r mut [[f64; 3]],
    /// What the sheet pulls at the two runs of fixed nodes of each row, in units of m h/dt; empty where nobody asks.
    pub pulls: &'r mut [[[f64; 3]; 2]],
}

impl<'r> Rows<'r> {
    /// Rows [first, end) of the whole sheet; None if a block is shorter than the layout says. `marked`: whether segments may have
    /// a toe; `in_block`: the step of a block.
    pub fn of(
        arrays: &'r mut Arrays<'_>,
        layout: &Layout,
        [first, end]: [usize; 2],
        ply: usize,
        marked: bool,
        in_block: Option<usize>,
    ) -> Option<Rows<'r>> {
        let own = first * layout.chunks..end * layout.chunks;
        let noted = in_block.unwrap_or(0) * layout.nodes_y;
        let (swept, rest) = arrays.hot.split_at_mut_checked(own.end)?;
        Some(Rows {
            first,
            ply,
            hot: swept.get_mut(own.start..)?,
            above: if layout.is_stack() && layout.ply_and_row(end).1 == 0 {
                // The row behind is of the next ply.
                &[]
            } else {
                planes::row(rest, layout.chunks, 0)
            },
            history: arrays.history.get_mut(own.clone())?,
            yarn: if layout.has_constants() { arrays.yarn.get(own.clone())? } else { &[] },
            strength: if layout.has(Feature::Strength) { arrays.strength.get(own.clone())? } else { &[] },
            logarithms: if layout.has(Feature::Rate) { arrays.logarithms.get(own.clone())? } else { &[] },
            marks: if marked { arrays.marks.get(own.clone())? } else { &[] },
            pushes: if layout.has(Feature::Viscosity) { arrays.pushes.get_mut(own.clone())? } else { &mut [] },
            viscous: Viscous::of(arrays.viscous, arrays.nothing),
            taken: if layout.takes_energy() { arrays.taken.get_mut(first..end)? } else { &mut [] },
            before: if layout.is_stack() { arrays.before.get_mut(own)? } else { &mut [] },
            ranges: arrays.ranges.get_mut(first..end)?,
            runs: arrays.runs.get(first..end)?,
            net: Net { columns: arrays.columns, lines: arrays.lines },
            carry: match in_block {
                None => arrays.carry,
                Some(step) => planes::row_mut(arrays.carries, layout.chunks, step),
            },
            kept: arrays.kept,
            pulls: if layout.supports { arrays.pulls.get_mut(noted + first..noted + end)? } else { &mut [] },
        })
    }
}

impl Rows<'_> {
    /// The hot pass over these rows, with fixed nodes put back and their pulls noted.
    pub fn sweep(&mut self, terms: &Terms<'_>) -> Report {
        let layout = terms.layout;
        // Empty but for a stack.
        if !self.before.is_empty() {
            lanes::dispatch(terms.instructions, Keep { hot: self.hot, before: self.before });
        }
        if layout.has(Feature::Viscosity) {
            return self.sweep_viscous(terms);
        }
        let rows_besides = layout.has(Feature::Strength) || layout.has(Feature::Toe) && !self.marks.is_empty();
        let optional = rows_besides || layout.has(Feature::Grading) || layout.has(Feature::Rate);
        if optional { self.sweep_with::<true>(terms) } else { self.sweep_with::<false>(terms) }
    }

    /// [`Rows::sweep`] without viscosity. OPTIONS: whether there is drawn strength, rate, toe or grading; otherwise no row is asked for them.
    #[inline(never)]
    fn sweep_with<const OPTIONS: bool>(&mut self, terms: &Terms<'_>) -> Report {
        let layout = terms.layout;
        let chunks = layout.chunks;
        let Rows { hot, history, ranges, carry, kept, pulls, .. } = self;
        let (first, ply, above, yarn, runs) = (self.first, self.ply, self.above, self.yarn, self.runs);
        let (strength, logarithms) = if OPTIONS { (self.strength, self.logarithms) } else { (&[][..], &[][..]) };
        let (marks, net) = if OPTIONS { (self.marks, &self.net) } else { (&[][..], &Net::NONE) };
        let pass = terms.pass(net, ply);
        if layout.x.is_mirrored() {
            (0..ranges.len()).for_each(|k| place_image_column(planes::row_mut(hot, chunks, k), layout.x));
        }
        // Whether nodes stand for several.
        let weighed = layout.x.is_mirrored() || layout.y.is_mirrored() || layout.has(Feature::Grading);
        let (mut report, rows) = (Report::default(), ranges.len());
        for (k, (range, run)) in ranges.iter_mut().zip(runs).enumerate() {
            let j = first + k;
            let Some((below, next)) = hot.split_at_mut_checked((k + 1) * chunks) else { return Report::LOST };
            let row = planes::row_mut(below, chunks, k);
            let above = if k + 1 < rows { planes::row(next, chunks, 0) } else { above };
            keep_fixed(row, kept, run);
            let yarn = terms.yarn_row(yarn, strength, logarithms, k, ply);
            let (history, marks) = (planes::row_mut(history, chunks, k), planes::row(marks, chunks, k));
            let (met, reach) = Row { pass: &pass, j, row, history, above, carry, yarn: &yarn, marks }.step();
            report = report.merged(met);
            let pulled = if weighed {
                restore_fixed(row, kept, run, |i| layout.node_weight(i, j) * net.share(i, j))
            } else {
                restore_fixed(row, kept, run, |_| 1.0)
            };
            if let Some(pulls) = pulls.get_mut(k) {
                *pulls = pulled;
            }
            keep_range(range, reach, row, terms.instructions);
        }
        report
    }
}

/// Keeps the velocities along z.
struct Keep<'a> {
    hot: &'a [Chunk<HOT_PLANES>],
    before: &'a mut [[f64; CHUNK]],
}

impl Job for Keep<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lane>(self) {
        for (before, chunk) in self.before.iter_mut().zip(self.hot) {
            for (before, speed) in L::groups_mut(before).iter_mut().zip(L::groups(&chunk[5])) {
                L::load(speed).store(before);
            }
        }
    }
}

/// The ends of a row's displacements: along y as the pass has found them, along x if they are kept.
pub(super) fn keep_range(range: &mut [u32; 4], reach: [f64; 2], row: &[Chunk<HOT_PLANES>], set: InstructionSet) {
    let [low, high, left, right] = range;
    [*low, *high] = reach.map(end_of_range);
    if *left != NOT_KEPT {
        // While the row is at hand.
        [*left, *right] = spread(row, set).map(end_of_range);
    }
}

/// Remembers the displacements of a row's fixed nodes.
pub(super) fn keep_fixed(row: &[Chunk<HOT_PLANES>], kept: &mut [[f64; 3]], run: &[u32; 4]) {
    for columns in [run[0]..run[1], run[2]..run[3]] {
        for i in columns.map(|i| i as usize) {
            let (Some([x, y, z, ..]), Some(kept)) = (row.get(i / CHUNK), kept.get_mut(i)) else { break };
            *kept = [x[i % CHUNK], y[i % CHUNK], z[i % CHUNK]];
        }
    }
}

/// Puts the fixed nodes of a row back to rest and returns the pull of the sheet on each run, in units of m h/dt; behind
/// mirror planes that of all images together, before any is turned.
#[inline]
pub(super) fn restore_fixed(
    row: &mut [Chunk<HOT_PLANES>],
    kept: &[[f64; 3]],
    run: &[u32; 4],
    weight: impl Fn(usize) -> f64,
) -> [[f64; 3]; 2] {
    let mut pulls = [Vector::zeros(); 2];
    for (pull, columns) in pulls.iter_mut().zip([run[0]..run[1], run[2]..run[3]]) {
        for i in columns.map(|i| i as usize) {
            let (Some(chunk), Some(kept)) = (row.get_mut(i / CHUNK), kept.get(i)) else { break };
            let lane = i % CHUNK;
            *pull += Vector::new(chunk[3][lane], chunk[4][lane], chunk[5][lane]) * weight(i);
            for plane in 0..3 {
                chunk[plane][lane] = kept[plane];
                chunk[3 + plane][lane] = 0.0;
            }
        }
    }
    pulls.map(|pull| pull.into())
}

/// The image column of one row, at rest: only displacements, the first three planes, are read.
pub(crate) fn place_image_column<const P: usize>(row: &mut [Chunk<P>], line: Line) {
    let place = line.modelled();
    let (node, _) = line.node(place);
    for (plane, sign) in [(0, -1.0), (1, 1.0), (2, 1.0)] {
        let value = planes::get(row, plane, node).unwrap_or(0.0);
        if let Some(slot) = planes::get_mut(row, plane, place) {
            *slot = sign * value;
        }
        if let Some(slot) = planes::get_mut(row, 3 + plane, place) {
            *slot = 0.0;
        }
    }
}

/// The image row of a block, its displacements and velocities, the first six planes.
pub(crate) fn place_image_row<const P: usize>(block: &mut [Chunk<P>], chunks: usize, line: Line) {
    let place = line.modelled();
    let (node, _) = line.node(place);
    let Some((rows, images)) = block.split_at_mut_checked(place * chunks) else { return };
    for (from, to) in planes::row(rows, chunks, node).iter().zip(planes::row_mut(images, chunks, 0)) {
        for plane in [0, 2, 3, 5] {
            to[plane] = from[plane];
        }
        for plane in [1, 4] {
            to[plane] = from[plane].map(|y| -y);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::ground::lanes::InstructionSet;
    use crate::{Failure, Layout, Scene, Sim};

    #[test]
    fn a_block_that_is_too_short_is_a_failure_and_no_row_that_stands_still() {
        let mut scene = Scene::sheet_3in_sphere();
        (scene.sheet.nodes_x, scene.sheet.nodes_y) = (21, 21);
        let layout = Layout::of(&scene).unwrap();
        let mut memory = std::vec![crate::CacheLine::ZERO; layout.lines()];
        let mut sim = Sim::new(&scene, &mut memory).unwrap();
        sim.step_every_row();
        sim.step().unwrap();
        sim.system.arrays.history = &mut [];
        assert_eq!(sim.step(), Err(Failure::NonFinite));
    }

    /// The path of fabrics that are not plain is the general one: it gives a plain sheet the bits of its own.
    #[test]
    fn a_plain_sheet_moves_alike_on_both_paths() {
        let run = |toe: f64, plain: bool| {
            let mut scene = Scene::sheet_3in_sphere();
            (scene.sheet.nodes_x, scene.sheet.nodes_y, scene.slack_toe) = (41, 41, toe);
            let layout = Layout::of(&scene).unwrap();
            let mut memory = std::vec![crate::CacheLine::ZERO; layout.lines()];
            let mut sim = Sim::new(&scene, &mut memory).unwrap();
            assert!(sim.system.directions.front.plain);
            sim.system.directions.front.plain = plain;
            sim.advance(3000).unwrap();
            assert!(sim.counters().failed_segments > 10);
            sim.digest()
        };
        for toe in [0.0, 0.02] {
            assert_eq!(run(toe, true), run(toe, false));
        }
    }

    /// The path of sheets beyond the caches gives a small one the bits of its own.
    #[test]
    fn rows_fetched_from_memory_move_as_others_do() {
        let run = |exceeds: bool, set: InstructionSet| {
            let mut scene = Scene::sheet_3in_sphere();
            (scene.sheet.nodes_x, scene.sheet.nodes_y) = (41, 41);
            let layout = Layout::of(&scene).unwrap();
            let mut memory = std::vec![crate::CacheLine::ZERO; layout.lines()];
            let mut sim = Sim::new(&scene, &mut memory).unwrap();
            assert!(!sim.system.fetches);
            sim.system.fetches = exceeds;
            sim.use_instructions(set).unwrap();
            sim.advance(3000).unwrap();
            assert!(sim.counters().failed_segments > 10);
            sim.digest()
        };
        for set in InstructionSet::ALL.into_iter().filter(|set| set.available()) {
            assert_eq!(run(true, set), run(false, set));
        }
    }
}
