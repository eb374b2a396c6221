//! What viscosity keeps of a run of rows, and what it takes of them in a pass (`sheet/viscous.rs`).

use crate::ground::lanes;
use crate::ground::planes::{self, Chunk, HOT_PLANES, MOMENT, PAST_PLANES, SPEED_Z, VISCOUS_STRESS};
use crate::memory::layout::Layout;
use crate::scene::features::Feature;
use crate::sheet::viscous::{MomentsOfRow, ViscousRow};
use crate::step::rows::terms::Terms;

/// What viscosity keeps of neighbouring rows; empty without it.
pub(crate) struct ViscousRows<'r> {
    /// Past of the last pass; moments of this one as far as they have been found.
    pub past: &'r mut [Chunk<PAST_PLANES>],
    /// Past of the row above the last, or of the images there; empty for none.
    pub above: &'r mut [Chunk<PAST_PLANES>],
    /// Whether the moments of the first and of the last row are those of this pass already.
    pub known: [bool; 2],
}

/// The past of the last segments of a row along x and along y: twice the strain and viscous stress.
pub(crate) type Last = [[f64; 2]; 2];

impl ViscousRows<'_> {
    /// Finds the moments of row k of `hot`, if they are not known. Begins to count what viscosity takes of
    /// it. `above`: the row above the last; `first`: the number of the first row in the sheet.
    #[inline(never)]
    pub fn find_moments(
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
        let (before, rest) = self.past.split_at_mut((k * chunks).min(self.past.len()));
        let below = k.checked_sub(1).map(|k| (planes::row(hot, chunks, k), planes::row(before, chunks, k)));
        let (below, past_below) = below.unwrap_or_default();
        let row = MomentsOfRow {
            directions: terms.directions.of_ply(ply),
            row: planes::row(hot, chunks, k),
            below,
            past_below,
            above: if k + 1 < rows { planes::row(hot, chunks, k + 1) } else { above },
            past: planes::row_mut(rest, chunks, 0),
        };
        find_moments_of_row(terms, first + k, row, taken);
    }

    /// What the sweep of the k-th of so many rows needs, and the past of its last segments. `first`: as
    /// above.
    #[inline(always)]
    pub fn row<'a>(&'a mut self, layout: &Layout, (k, rows, first): (usize, usize, usize)) -> (ViscousRow<'a>, Last) {
        let chunks = layout.chunks;
        if layout.y.is_mirrored()
            && first + k + 1 == layout.nodes_y
            && let Some(node) = layout.y.node(layout.y.modelled()).0.checked_sub(first)
        {
            place_image_moments(self.above, planes::row(self.past, chunks, node));
        }
        let (below, rest) = self.past.split_at_mut(((k + 1) * chunks).min(self.past.len()));
        let past = planes::row_mut(below, chunks, k);
        let above = if k + 1 < rows { planes::row(rest, chunks, 0) } else { &*self.above };
        let last = last_of(past, layout);
        (ViscousRow { past, above }, last)
    }

    /// What the last segments of the k-th row, a mirrored one, have taken since this was their past, over 1/4
    /// l^2.
    #[inline(never)]
    pub fn taken_of_last(&mut self, layout: &Layout, k: usize, before: &Last) -> [f64; 2] {
        // It was that of a node beside the plane.
        set(planes::row_mut(self.past, layout.chunks, k), MOMENT, layout.x.modelled(), 0.0);
        let now = last_of(planes::row(self.past, layout.chunks, k), layout);
        [0, 1].map(|axis| (now[axis][0] - before[axis][0]) * (now[axis][1] + before[axis][1]))
    }
}

/// The past of the last segments of a row along x and along y.
fn last_of(past: &[Chunk<PAST_PLANES>], layout: &Layout) -> Last {
    if !layout.x.is_mirrored() {
        return [[0.0; 2]; 2];
    }
    let at = |plane: usize| planes::get(past, plane, layout.nodes_x - 1).unwrap_or(0.0);
    [[at(0), at(VISCOUS_STRESS)], [at(1), at(VISCOUS_STRESS + 1)]]
}

/// Finds the moments of row j, and begins to count what viscosity takes of it.
#[inline(never)]
pub(crate) fn find_moments_of_row(terms: &Terms<'_>, j: usize, row: MomentsOfRow<'_>, taken: &mut f64) {
    let (layout, line) = (terms.layout, terms.layout.x);
    if layout.has(Feature::Curved) {
        *taken = 0.0;
        return;
    }
    if !line.is_mirrored() {
        let found: f64 = lanes::dispatch(terms.instructions, row).iter().sum();
        *taken = 0.5 * layout.y.node_weight(j) * found;
        return;
    }
    // Nodes on the plane are there once, the others twice; and there is an image.
    let last = layout.nodes_x - 1;
    let speed = |row: &[Chunk<HOT_PLANES>], i: usize| planes::get(row, SPEED_Z, i).unwrap_or(0.0);
    let change = |left: f64, here: f64, right: f64| (here - left) + (here - right);
    let here = speed(row.row, last);
    let left = last.checked_sub(1).map_or(0.0, |i| speed(row.row, i));
    let changes =
        [change(left, here, speed(row.row, last + 1)), change(speed(row.below, last), here, speed(row.above, last))];
    let of_last = |past: &[Chunk<PAST_PLANES>]| -> f64 {
        [0, 1].map(|k| planes::get(past, MOMENT + k, last).unwrap_or(0.0) * changes[k]).iter().sum()
    };
    let MomentsOfRow { past, .. } = row;
    let mut once = of_last(past);
    let found: f64 = lanes::dispatch(terms.instructions, MomentsOfRow { past, ..row }).iter().sum();
    once += of_last(past);
    let all = line.node_weight(0) * found - (line.node_weight(0) - line.node_weight(last)) * once;
    *taken = 0.5 * layout.y.node_weight(j) * all;
    let (node, _) = line.node(line.modelled());
    let image = planes::get(past, MOMENT, node).unwrap_or(0.0);
    set(past, MOMENT, line.modelled(), image);
}

/// The moments across the row of images, along y: those of the row.
pub(crate) fn place_image_moments(images: &mut [Chunk<PAST_PLANES>], row: &[Chunk<PAST_PLANES>]) {
    for (image, chunk) in images.iter_mut().zip(row) {
        image[MOMENT + 1] = chunk[MOMENT + 1];
    }
}

fn set<const P: usize>(row: &mut [Chunk<P>], plane: usize, column: usize, value: f64) {
    if let Some(slot) = planes::get_mut(row, plane, column) {
        *slot = value;
    }
}
