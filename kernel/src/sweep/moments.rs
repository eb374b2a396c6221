//! Viscosity of rows (`sweep/viscous.rs` is that of segments): what it starts from, the moments of a row and
//! of one node, what it dissipates in a step, and the energy of the step that is open.
//!
//! Method: a step has counted half of what its own forces take, with the rate after it; the other half, with
//! the rate of t_{n+1/2}, is open until the next step and is added to a balance in between.
//! Reference: docs/model.md, "Viscosity".

use crate::ground::planes::{self, Axis, Chunk, HOT_PLANES, MOMENT, PAST_PLANES, SPEED_Z, VISCOUS_STRESS};
use crate::memory::layout::Layout;
use crate::memory::network::Network;
use crate::scene::features::Feature;
use crate::sheet::columns::Net;
use crate::sweep::pass::Pass;
use crate::sweep::terms::{Terms, rates};
use crate::sweep::viscous::{MomentsOfRow, NO_PAST, ViscousRow};
use crate::yarn::law;

/// Past and moments of neighbouring rows; empty without viscosity.
pub(crate) struct ViscousRows<'r> {
    /// Past of the last step; moments of this one as far as they have been found.
    pub past: &'r mut [Chunk<PAST_PLANES>],
    /// Past of the row above the last, or of the ghost row there; empty for none.
    pub above: &'r mut [Chunk<PAST_PLANES>],
    /// Whether the moments of the first and of the last row are those of this step already.
    pub moments_found: [bool; 2],
}

/// The past of the last segments of a row along x and along y: twice the strain and viscous stress.
pub(crate) type Last = [[f64; 2]; 2];

impl ViscousRows<'_> {
    /// Finds the moments of row k of `hot`, if they are not known yet. Begins the account of what viscosity
    /// dissipates in it. `above`: the row above the last; `first`: the number of the first row in the sheet.
    #[inline(never)]
    pub fn find_moments(
        &mut self,
        pass: &Pass<'_>,
        terms: &Terms<'_>,
        [ply, first, k]: [usize; 3],
        [hot, above]: [&[Chunk<HOT_PLANES>]; 2],
        dissipated: &mut [f64],
    ) {
        let (chunks, rows) = (terms.layout.chunks, dissipated.len());
        let Some(dissipated) = dissipated.get_mut(k) else { return };
        if k == 0 && self.moments_found[0] || k + 1 == rows && self.moments_found[1] {
            return;
        }
        let (before, rest) = self.past.split_at_mut((k * chunks).min(self.past.len()));
        let below = k.checked_sub(1).map(|k| (planes::row(hot, chunks, k), planes::row(before, chunks, k)));
        let (below, past_below) = below.unwrap_or_default();
        let row = MomentsOfRow {
            directions: terms.directions.of_ply(ply),
            net: &pass.net,
            row: planes::row(hot, chunks, k),
            below,
            past_below,
            above: if k + 1 < rows { planes::row(hot, chunks, k + 1) } else { above },
            past: planes::row_mut(rest, chunks, 0),
        };
        find_moments_of_row(terms, first + k, row, dissipated);
    }

    /// Viscous state for the sweep of the k-th of so many rows, and the past of its last segments. `first`:
    /// as above.
    #[inline(always)]
    pub fn row<'a>(&'a mut self, layout: &Layout, (k, rows, first): (usize, usize, usize)) -> (ViscousRow<'a>, Last) {
        let chunks = layout.chunks;
        if layout.y.is_mirrored()
            && first + k + 1 == layout.nodes_y
            && let Some(node) = layout.y.node(layout.y.modelled()).0.checked_sub(first)
        {
            place_ghost_moments(self.above, planes::row(self.past, chunks, node));
        }
        let (below, rest) = self.past.split_at_mut(((k + 1) * chunks).min(self.past.len()));
        let past = planes::row_mut(below, chunks, k);
        let above = if k + 1 < rows { planes::row(rest, chunks, 0) } else { &*self.above };
        let last = last_of(past, layout);
        (ViscousRow { past, above }, last)
    }

    /// Energy that the last segments of the k-th row, a mirrored one, dissipate in this step, over l^2/4.
    #[inline(never)]
    pub fn taken_of_last(&mut self, layout: &Layout, k: usize, before: &Last) -> [f64; 2] {
        // It was that of a node beside the plane.
        planes::set(planes::row_mut(self.past, layout.chunks, k), MOMENT, layout.x.modelled(), 0.0);
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

/// Finds the moments of row j (M17), and begins the account of what viscosity dissipates in it.
pub(crate) fn find_moments_of_row(terms: &Terms<'_>, j: usize, mut row: MomentsOfRow<'_>, dissipated: &mut f64) {
    let (layout, line) = (terms.layout, terms.layout.x);
    if layout.has(Feature::Curved) {
        *dissipated = 0.0;
        return;
    }
    if !line.is_mirrored() {
        let found: f64 = row.find(terms.instructions, j).iter().sum();
        *dissipated = 0.5 * layout.y.node_weight(j) * found;
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
    let widths = [row.net.row_share(j), row.net.column_share(last)];
    let of_last = |past: &[Chunk<PAST_PLANES>]| -> f64 {
        [0, 1].map(|k| planes::get(past, MOMENT + k, last).unwrap_or(0.0) * changes[k] * widths[k]).iter().sum()
    };
    let mut once = of_last(row.past);
    let found: f64 = row.find(terms.instructions, j).iter().sum();
    once += of_last(row.past);
    let all = line.node_weight(0) * found - (line.node_weight(0) - line.node_weight(last)) * once;
    *dissipated = 0.5 * layout.y.node_weight(j) * all;
    let (node, _) = line.node(line.modelled());
    let image = planes::get(row.past, MOMENT, node).unwrap_or(0.0);
    planes::set(row.past, MOMENT, line.modelled(), image);
}

/// Moments of the ghost row along y: those of the row that it mirrors.
pub(crate) fn place_ghost_moments(ghosts: &mut [Chunk<PAST_PLANES>], row: &[Chunk<PAST_PLANES>]) {
    for (ghost, chunk) in ghosts.iter_mut().zip(row) {
        ghost[MOMENT + 1] = chunk[MOMENT + 1];
    }
}

/// The viscous moments of row j of a ply in a step of a block, the first one otherwise, which the row below
/// it needs; nothing above the top row.
pub(crate) fn find_moments_above(system: &mut Network<'_>, loaded: u64, [ply, step]: [usize; 2], j: usize) {
    if !system.layout.has(Feature::Viscosity) {
        return;
    }
    let rates = rates(system, loaded);
    let Network { layout, directions, clamps, arrays, instructions, .. } = &mut *system;
    let chunks = layout.chunks;
    let (past_below, past) = arrays.rows.past.split_at_mut((j * chunks).min(arrays.rows.past.len()));
    let Some(dissipated) = arrays.rows.dissipated.get_mut(step * layout.nodes_y + j).filter(|_| j < layout.nodes_y)
    else {
        return;
    };
    let net = Net { columns: layout.columns_of(arrays.columns, ply), lines: arrays.lines };
    let row = MomentsOfRow {
        directions: directions.of_ply(ply),
        net: &net,
        row: planes::row(arrays.rows.hot, chunks, j),
        below: planes::row(arrays.rows.hot, chunks, j - 1),
        past_below: planes::row(past_below, chunks, j - 1),
        above: if layout.is_stack() && !layout.has_verticals(j) {
            &[]
        } else {
            planes::row(arrays.rows.hot, chunks, j + 1)
        },
        past: planes::row_mut(past, chunks, 0),
    };
    let terms =
        Terms { layout, directions, clamps: *clamps, rates: &rates, fetches: false, instructions: *instructions };
    find_moments_of_row(&terms, j, row, dissipated);
}

/// Starts from the present state: the strain of the last step is that of the displacements less the
/// velocities, and nothing has acted.
pub(crate) fn start(system: &mut Network<'_>) {
    if !system.layout.has(Feature::Viscosity) {
        return;
    }
    let layout = system.layout;
    system.arrays.rows.past.fill(NO_PAST);
    layout.for_each_segment(|axis, i, j| {
        let Some(before) = system.segment(axis, i, j).map(|segment| segment.twice_strain_before()) else { return };
        planes::set(planes::row_mut(system.arrays.rows.past, layout.chunks, j), axis as usize, i, before);
    });
}

/// Energy that the forces of the last step dissipate at the present rates and no sum holds yet, J.
pub(crate) fn uncounted_dissipation(system: &Network<'_>) -> f64 {
    if !system.layout.has(Feature::Viscosity) {
        return 0.0;
    }
    let mut dissipated = 0.0;
    for (i, j) in system.nodes() {
        let mut of_node = 0.0;
        for axis in [Axis::Horizontal, Axis::Vertical] {
            let [past, stress, moment] = past(system, axis, i, j);
            let taken_by_moment =
                0.5 * moment * width(system, axis.other(), i, j) * negative_second_difference(system, axis, i, j);
            of_node += system.layout.node_weight(i, j) * taken_by_moment;
            let Some(segment) = system.segment(axis, i, j) else { continue };
            let growth = segment.twice_strain() - past;
            let length = segment.rest.length;
            of_node +=
                system.layout.segment_weight(axis, i, j) * segment.bar[1] * (0.25 * length * length * stress * growth);
        }
        dissipated += of_node * system.mass_share_of_row(j);
    }
    dissipated * system.model.unit_energy
}

/// Twice the strain in the last step of the segment from node (i, j), the viscous part of its stress, and the
/// node's moment.
pub(crate) fn past(system: &Network<'_>, axis: Axis, i: usize, j: usize) -> [f64; 3] {
    let row = planes::row(system.arrays.rows.past, system.layout.chunks, j);
    [0, VISCOUS_STRESS, MOMENT]
        .map(|first| first + axis as usize)
        .map(|plane| planes::get(row, plane, i).unwrap_or(0.0))
}

/// Width of node (i, j) along an axis.
fn width(network: &Network<'_>, axis: Axis, i: usize, j: usize) -> f64 {
    match axis {
        Axis::Horizontal => network.net(0).column_share(i),
        Axis::Vertical => network.net(0).row_share(j),
    }
}

/// Velocity along z at a place, of the image beyond a mirror plane too; 0 where there is no node.
fn speed(system: &Network<'_>, i: Option<usize>, j: Option<usize>) -> f64 {
    let (Some(i), Some(j)) = (i, j) else { return 0.0 };
    let layout = &system.layout;
    let (ply, row) = layout.ply_and_row(j);
    let ((i, _), (row, _)) = (layout.x.node(i), if layout.is_stack() { (row, false) } else { layout.y.node(j) });
    let row = planes::row(system.arrays.rows.hot, layout.chunks, ply * layout.y.modelled() + row);
    planes::get(row, SPEED_Z, i).unwrap_or(0.0)
}

/// 2 v_i - v_{i-1} - v_{i+1} along z at a node; of no meaning where its yarn ends.
fn negative_second_difference(system: &Network<'_>, axis: Axis, i: usize, j: usize) -> f64 {
    let (before, after) = match axis {
        Axis::Horizontal => (speed(system, i.checked_sub(1), Some(j)), speed(system, Some(i + 1), Some(j))),
        Axis::Vertical => (speed(system, Some(i), j.checked_sub(1)), speed(system, Some(i), Some(j + 1))),
    };
    let here = speed(system, Some(i), Some(j));
    (here - before) + (here - after)
}

/// Moment -M_i that the next step finds for the yarn of this direction at a node, or at its image.
pub(crate) fn moment(system: &Network<'_>, axis: Axis, i: usize, j: usize) -> f64 {
    let ((i, _), (j, _)) = (system.layout.x.node(i), system.layout.y.node(j));
    let tension = |i: Option<usize>, j: Option<usize>| {
        let segment = system.segment(axis, i?, j?)?;
        Some(law::stress(segment.stiffness, past(system, axis, i?, j?)[0]))
    };
    let before = match axis {
        Axis::Horizontal => tension(i.checked_sub(1), Some(j)),
        Axis::Vertical => tension(Some(i), j.checked_sub(1)),
    };
    let (Some(before), Some(after)) = (before, tension(Some(i), Some(j))) else { return 0.0 };
    if width(system, axis, i, j) != 1.0 {
        return 0.0;
    }
    let viscosity = system.direction(axis, j).viscosity.lanes::<f64>();
    negative_second_difference(system, axis, i, j) * viscosity.bending(before, after)
}
