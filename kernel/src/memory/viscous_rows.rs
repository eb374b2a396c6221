//! What viscosity keeps of a run of rows, and what it takes of them in a pass (`sheet/viscous.rs`).

use crate::ground::lanes;
use crate::ground::planes::{self, CHUNK, Chunk, HOT_PLANES, MOMENT_PLANES, PAST_PLANES, SPEED_Z};
use crate::memory::layout::Layout;
use crate::memory::terms::Terms;
use crate::scene::features::Feature;
use crate::sheet::direction::Along;
use crate::sheet::symmetry::Line;
use crate::sheet::viscous::{MomentsOfRow, STRESS, ViscousRow};

/// What viscosity keeps of neighbouring rows; empty without it.
pub(crate) struct ViscousRows<'r> {
    /// Of the last pass.
    pub past: &'r mut [Chunk<PAST_PLANES>],
    /// Moments of the nodes.
    pub moments: &'r mut [Chunk<MOMENT_PLANES>],
    /// What the segments of each row take in a pass, by columns.
    pub by_column: &'r mut [[[f64; CHUNK]; 2]],
    /// Moments of the row above the last, or of the row whose images lie there, if it is none of these; empty for none.
    pub above: &'r [Chunk<MOMENT_PLANES>],
    /// Whether the moments of the first and of the last row are those of this pass already.
    pub known: [bool; 2],
}

/// The past of the last segments of a row along x and along y: twice the strain and viscous stress.
pub(crate) type Last = [[f64; 2]; 2];

impl ViscousRows<'_> {
    /// Finds the moments that the sweep of row k of `hot` needs: those of the row above it, and of the first row before that. `above`: the
    /// row above the last; `first`: the number of the first row in the sheet.
    #[inline(never)]
    pub fn find_moments_ahead(
        &mut self,
        terms: &Terms<'_>,
        [ply, first, k]: [usize; 3],
        rows: [&[Chunk<HOT_PLANES>]; 2],
        taken: &mut [f64],
    ) {
        if k == 0 {
            self.find_moments(terms, [ply, first, 0], rows, taken);
        }
        self.find_moments(terms, [ply, first, k + 1], rows, taken);
    }

    /// Finds the moments of row k. Begins to count what viscosity takes of it.
    #[inline(never)]
    fn find_moments(
        &mut self,
        terms: &Terms<'_>,
        [ply, first, k]: [usize; 3],
        [hot, above]: [&[Chunk<HOT_PLANES>]; 2],
        taken: &mut [f64],
    ) {
        let (chunks, rows) = (terms.layout.chunks, taken.len());
        let Some(taken) = taken.get_mut(k) else { return };
        if k == 0 && self.known[0] || k + 1 == rows && self.known[1] {
            return;
        }
        let below = k.wrapping_sub(1);
        let row = MomentsOfRow {
            directions: terms.directions.of_ply(ply),
            row: planes::row(hot, chunks, k),
            past: planes::row(self.past, chunks, k),
            below: if k > 0 { planes::row(hot, chunks, below) } else { &[] },
            past_below: if k > 0 { planes::row(self.past, chunks, below) } else { &[] },
            above: if k + 1 < rows { planes::row(hot, chunks, k + 1) } else { above },
            moments: planes::row_mut(self.moments, chunks, k),
        };
        find_moments_of_row(terms, first + k, row, taken);
    }

    /// What the sweep of the k-th of so many rows needs, and the past of its last segments. `first`: as above.
    #[inline(never)]
    pub fn row<'a>(
        &'a mut self,
        layout: &Layout,
        (k, rows, first): (usize, usize, usize),
    ) -> Option<(ViscousRow<'a>, Last)> {
        let taken = self.by_column.get_mut(k)?;
        *taken = [[0.0; CHUNK]; 2];
        let chunks = layout.chunks;
        let (moments, past) = (&*self.moments, planes::row_mut(self.past, chunks, k));
        let last = last_of(past, layout);
        let images = layout.y.is_mirrored() && first + k + 1 == layout.nodes_y;
        // The row above, or that of which it is the image.
        let above = if images { layout.y.node(layout.y.modelled()).0.checked_sub(first) } else { Some(k + 1) };
        let above = above.filter(|&above| above < rows).map_or(self.above, |above| planes::row(moments, chunks, above));
        Some((ViscousRow { past, moments: planes::row(moments, chunks, k), moments_above: above, taken }, last))
    }

    /// What the segments of the k-th row, row j of the sheet, have taken in the pass, in units of m (h/dt)^2. `before`: the past of the last
    /// ones.
    #[inline(never)]
    pub fn taken(&mut self, layout: &Layout, along: Along<'_>, [k, j]: [usize; 2], before: Last) -> f64 {
        let Some(taken) = self.by_column.get(k) else { return 0.0 };
        let past = planes::row_mut(self.past, layout.chunks, k);
        let (line, now) = (layout.x, last_of(past, layout));
        let last = layout.nodes_x.saturating_sub(1);
        let weights =
            [[line.segment_weight(0), line.segment_weight(last)], [line.node_weight(0), line.node_weight(last)]];
        let rows = [layout.y.node_weight(j), layout.y.segment_weight(j)];
        let mut sum = 0.0;
        for (axis, direction) in [along.horizontal, along.vertical].into_iter().enumerate() {
            let ([whole, of_last], length) = (weights[axis], direction.rest.length);
            let once = (now[axis][0] - before[axis][0]) * (now[axis][1] + before[axis][1]);
            let all = if line.is_mirrored() {
                whole * taken[axis].iter().sum::<f64>() - (whole - of_last) * once
            } else {
                taken[axis].iter().sum::<f64>()
            };
            sum += rows[axis] * (0.25 * length * length) * all;
        }
        if line.is_mirrored() {
            // It was that of a node beside the plane.
            set(planes::row_mut(self.moments, layout.chunks, k), 0, line.modelled(), 0.0);
        }
        sum
    }
}

/// The past of the last segments of a row along x and along y.
fn last_of(past: &[Chunk<PAST_PLANES>], layout: &Layout) -> Last {
    if !layout.x.is_mirrored() {
        return [[0.0; 2]; 2];
    }
    let at = |plane: usize| planes::get(past, plane, layout.nodes_x - 1).unwrap_or(0.0);
    [[at(0), at(STRESS)], [at(1), at(STRESS + 1)]]
}

/// Finds the moments of row j, and begins to count what viscosity takes of it, behind what the rate takes.
#[inline(never)]
pub(crate) fn find_moments_of_row(terms: &Terms<'_>, j: usize, row: MomentsOfRow<'_>, taken: &mut f64) {
    let (layout, line) = (terms.layout, terms.layout.x);
    let before = if layout.has(Feature::Rate) { *taken } else { 0.0 };
    if !line.is_mirrored() {
        let found: f64 = lanes::dispatch(terms.instructions, row).iter().sum();
        *taken = before + 0.5 * layout.y.node_weight(j) * found;
        return;
    }
    // Nodes on the plane are there once, the others twice; and there is an image.
    let last = layout.nodes_x - 1;
    let speed = |row: &[Chunk<HOT_PLANES>], i: usize| planes::get(row, SPEED_Z, i).unwrap_or(0.0);
    let change = |left: f64, here: f64, right: f64| (right - here) - (here - left);
    let here = speed(row.row, last);
    let left = last.checked_sub(1).map_or(0.0, |i| speed(row.row, i));
    let changes =
        [change(left, here, speed(row.row, last + 1)), change(speed(row.below, last), here, speed(row.above, last))];
    let of_last = |moments: &[Chunk<MOMENT_PLANES>]| -> f64 {
        (0..MOMENT_PLANES).map(|k| planes::get(moments, k, last).unwrap_or(0.0) * changes[k]).sum()
    };
    let MomentsOfRow { moments, .. } = row;
    let mut once = of_last(moments);
    let found: f64 = lanes::dispatch(terms.instructions, MomentsOfRow { moments, ..row }).iter().sum();
    once += of_last(moments);
    let all = line.node_weight(0) * found - (line.node_weight(0) - line.node_weight(last)) * once;
    *taken = before + 0.5 * layout.y.node_weight(j) * all;
    let (node, _) = line.node(line.modelled());
    let image = planes::get(moments, 0, node).unwrap_or(0.0);
    set(moments, 0, line.modelled(), image);
}

/// The velocities of the image column of so many rows.
pub(crate) fn place_image_speeds(hot: &mut [Chunk<HOT_PLANES>], chunks: usize, line: Line) {
    let (node, _) = line.node(line.modelled());
    for row in hot.chunks_exact_mut(chunks.max(1)) {
        for (plane, sign) in [(SPEED_Z - 2, -1.0), (SPEED_Z - 1, 1.0), (SPEED_Z, 1.0)] {
            let speed = planes::get(row, plane, node).unwrap_or(0.0);
            set(row, plane, line.modelled(), sign * speed);
        }
    }
}

fn set<const P: usize>(row: &mut [Chunk<P>], plane: usize, column: usize, value: f64) {
    if let Some(slot) = planes::get_mut(row, plane, column) {
        *slot = value;
    }
}
