//! A run of rows of viscous yarn, swept: each moves when the segments of the row above it are found (`sheet/viscous.rs`).

use super::rows::{Rows, Terms, keep_fixed, keep_range, place_image_column, restore_fixed};
use crate::ground::planes::{self, CHUNK, Chunk, HOT_PLANES, PUSH_PLANES, VISCOUS_PLANES};
use crate::memory::layout::Layout;
use crate::scene::features::Feature;
use crate::sheet::grading::Net;
use crate::sheet::sweep::{Report, Row};
use crate::sheet::symmetry::Line;
use crate::sheet::viscous::{Below, MOMENT, MOVES, Moved, OWN_MOMENT, ViscousRow};

/// What a sweep of viscous yarn works with.
#[derive(Default)]
pub(crate) struct Viscous<'r> {
    /// Work row, begun.
    pub work: &'r mut [Chunk<VISCOUS_PLANES>],
    /// Work row with the moments of the row above the last; may be empty where there is none.
    pub beyond: &'r mut [Chunk<VISCOUS_PLANES>],
    /// What moves in place of a row below the first.
    pub nothing: &'r mut [Chunk<HOT_PLANES>],
    /// The fixed nodes that are marked in the work row.
    fixed: Option<[u32; 4]>,
}

impl<'r> Viscous<'r> {
    /// Of both work rows together.
    pub fn of(both: &'r mut [Chunk<VISCOUS_PLANES>], nothing: &'r mut [Chunk<HOT_PLANES>]) -> Viscous<'r> {
        let (work, beyond) = both.split_at_mut(both.len() / 2);
        Viscous { work, beyond, nothing, fixed: None }
    }

    /// Keeps the moments of a row, for the images of its nodes.
    fn copy_moments(&mut self) {
        for (beyond, work) in self.beyond.iter_mut().zip(self.work.iter()) {
            beyond[MOMENT..MOMENT + 3].copy_from_slice(&work[MOMENT..MOMENT + 3]);
        }
    }
}

impl Rows<'_> {
    /// [`Rows::sweep`] of viscous yarn.
    #[inline(never)]
    pub(super) fn sweep_viscous(&mut self, terms: &Terms<'_>) -> Report {
        let (mut report, mut moved) = (Report::default(), Moved::default());
        for k in 0..=self.ranges.len() {
            let before = self.begin_move(k, terms.layout);
            if k < self.ranges.len() {
                let Some(met) = self.find_segments(k, terms, &mut moved) else { return Report::LOST };
                report = report.merged(met);
            } else {
                self.move_last(terms, &mut moved);
            }
            self.end_move(k, terms, &moved, before);
        }
        report
    }

    /// The last row moves.
    #[inline(never)]
    fn move_last(&mut self, terms: &Terms<'_>, moved: &mut Moved) {
        let Rows { hot, pushes, viscous: Viscous { work, beyond, nothing, .. }, ranges, .. } = self;
        let last = below(hot, pushes, nothing, terms.layout.chunks, ranges.len());
        last.move_last(terms.instructions, work, beyond, moved);
    }

    /// The moments of images, once those of row k are found.
    #[inline(never)]
    fn place_moments(&mut self, k: usize, layout: &Layout) {
        if layout.x.is_mirrored() {
            place_image_of(self.viscous.work, OWN_MOMENT, layout.x);
        }
        if layout.y.is_mirrored() && self.first + k + 1 == layout.nodes_y {
            // The image of the row before the last for a row on the plane, else of the last.
            if layout.y.node(layout.y.modelled()).0 + 1 == layout.y.modelled() {
                self.viscous.copy_moments();
            }
            self.viscous.beyond.iter_mut().flat_map(|chunk| &mut chunk[MOMENT + 1]).for_each(|y| *y = -*y);
        }
    }

    /// The segments of row k; the row below moves. None if the rows are shorter than the layout says.
    #[inline(never)]
    fn find_segments(&mut self, k: usize, terms: &Terms<'_>, moved: &mut Moved) -> Option<Report> {
        let (layout, chunks, rows) = (terms.layout, terms.layout.chunks, self.ranges.len());
        if layout.y.is_mirrored() && self.first + k + 1 == layout.nodes_y {
            self.viscous.copy_moments();
        }
        let pass = terms.pass(&Net::NONE, self.ply);
        let yarn = terms.yarn_row(self.yarn, self.strength, self.logarithms, k, self.ply);
        let (history, marks) = (planes::row_mut(self.history, chunks, k), planes::row(self.marks, chunks, k));
        let (done, rest) = self.hot.split_at_mut_checked(k * chunks)?;
        let (row, next) = rest.split_at_mut_checked(chunks)?;
        let above = if k + 1 < rows { planes::row(next, chunks, 0) } else { self.above };
        let below = below(done, self.pushes, self.viscous.nothing, chunks, k);
        let (carry, work, j) = (&mut *self.carry, &mut *self.viscous.work, self.first + k);
        let row = Row { pass: &pass, j, row, history, above, carry, yarn: &yarn, marks };
        let met = ViscousRow { row, below, work }.step(moved);
        if layout.x.is_mirrored() || layout.y.is_mirrored() {
            self.place_moments(k, layout);
        }
        Some(met)
    }

    /// What is kept of row k - 1 before it moves, and which of its nodes move. Returns what its last node has, where it lies on a
    /// mirror plane.
    #[inline(never)]
    fn begin_move(&mut self, k: usize, layout: &Layout) -> [f64; 3] {
        let (Some(k), chunks) = (k.checked_sub(1), layout.chunks) else { return [0.0; 3] };
        let Some(run) = self.runs.get(k) else { return [0.0; 3] };
        let row = planes::row_mut(self.hot, chunks, k);
        if layout.x.is_mirrored() {
            place_image_column(row, layout.x);
        }
        keep_fixed(row, self.kept, run);
        if self.viscous.fixed != Some(*run) {
            mark_moving(self.viscous.work, layout.nodes_x, run);
            self.viscous.fixed = Some(*run);
        }
        velocity(row, layout)
    }

    /// Behind the move of row k - 1: fixed nodes are put back, pulls noted, energy counted. `before`: see [`Rows::begin_move`].
    #[inline(never)]
    fn end_move(&mut self, k: usize, terms: &Terms<'_>, moved: &Moved, before: [f64; 3]) {
        let (layout, chunks) = (terms.layout, terms.layout.chunks);
        let Some(k) = k.checked_sub(1) else { return };
        let (Some(run), j) = (self.runs.get(k), self.first + k) else { return };
        let (row, pushes) = (planes::row_mut(self.hot, chunks, k), planes::row(self.pushes, chunks, k));
        let pulled = restore_fixed(row, self.kept, run, |i| layout.node_weight(i, j));
        if let Some(pulls) = self.pulls.get_mut(k) {
            *pulls = pulled;
        }
        if let Some(range) = self.ranges.get_mut(k) {
            keep_range(range, moved.reach, row, terms.instructions);
        }
        let behind = velocity(row, layout);
        if let Some(taken) = self.taken.get_mut(k) {
            let rate = if layout.has(Feature::Rate) { *taken } else { 0.0 };
            let [before, behind] = [(before, 0), (behind, 1)]
                .map(|(velocity, when)| half_taken(layout, j, &moved.given[when], velocity, pushes));
            *taken = rate + before + behind;
        }
    }
}

/// Row k - 1, which moves; for k = 0 a row of nothing, whose pushes are those of row 0 until it moves.
fn below<'r>(
    hot: &'r mut [Chunk<HOT_PLANES>],
    pushes: &'r mut [Chunk<PUSH_PLANES>],
    nothing: &'r mut [Chunk<HOT_PLANES>],
    chunks: usize,
    k: usize,
) -> Below<'r> {
    let pushes = planes::row_mut(pushes, chunks, k.saturating_sub(1));
    Below { hot: if k > 0 { planes::row_mut(hot, chunks, k - 1) } else { nothing }, pushes }
}

/// Half the energy, in units of m (h/dt)^2, that these pushes take of row j: once with the velocities before the pass and once with
/// those behind it, as contact counts its impulses. `given`: velocities times pushes; `velocity`: of the row's last node.
fn half_taken(
    layout: &Layout,
    j: usize,
    given: &[f64; CHUNK],
    velocity: [f64; 3],
    pushes: &[Chunk<PUSH_PLANES>],
) -> f64 {
    let (line, last) = (layout.x, layout.nodes_x.saturating_sub(1));
    let less = line.node_weight(0) - line.node_weight(last);
    let on_plane = if less > 0.0 {
        // Of a node on the plane there is one, of the others there are two.
        less * (0..PUSH_PLANES).map(|k| velocity[k] * planes::get(pushes, k, last).unwrap_or(0.0)).sum::<f64>()
    } else {
        0.0
    };
    -0.5 * layout.y.node_weight(j) * (line.node_weight(0) * given.iter().sum::<f64>() - on_plane)
}

/// Velocity of the last node of a row.
fn velocity(row: &[Chunk<HOT_PLANES>], layout: &Layout) -> [f64; 3] {
    let last = layout.nodes_x.saturating_sub(1);
    [3, 4, 5].map(|plane| planes::get(row, plane, last).unwrap_or(0.0))
}

/// Which nodes of a row move.
fn mark_moving(work: &mut [Chunk<VISCOUS_PLANES>], nodes_x: usize, run: &[u32; 4]) {
    for (c, chunk) in work.iter_mut().enumerate() {
        for (lane, slot) in chunk[MOVES].iter_mut().enumerate() {
            let i = c * CHUNK + lane;
            let is_fixed = [run[0]..run[1], run[2]..run[3]].iter().any(|fixed| fixed.contains(&(i as u32)));
            *slot = f64::from(u8::from(i < nodes_x && !is_fixed));
        }
    }
}

/// The image column of a row with its velocities.
pub(crate) fn place_image_motion(row: &mut [Chunk<HOT_PLANES>], line: Line) {
    place_image_column(row, line);
    place_image_of(row, 3, line);
}

/// The image of a node's vector, three planes from `first` on.
fn place_image_of<const P: usize>(row: &mut [Chunk<P>], first: usize, line: Line) {
    let (node, _) = line.node(line.modelled());
    for (k, sign) in [(0, -1.0), (1, 1.0), (2, 1.0)] {
        let value = planes::get(row, first + k, node).unwrap_or(0.0);
        if let Some(slot) = planes::get_mut(row, first + k, line.modelled()) {
            *slot = sign * value;
        }
    }
}
