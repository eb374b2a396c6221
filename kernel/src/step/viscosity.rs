//! Viscosity between passes: what it starts from, the energy of the pass that is open, and the moments of one
//! node.
//!
//! Method: the moments of `sheet/viscous.rs`, node by node. A pass has counted half of what its own forces
//! take, with the rate after it; the other half, with the rate of t_{n+1/2}, is open until the next pass and
//! is added to a balance in between.
//! Reference: docs/model.md, "Viscosity".

use crate::ground::planes::{self, Axis, MOMENT, SPEED_Z, VISCOUS_STRESS};
use crate::memory::system::System;
use crate::scene::features::Feature;
use crate::yarn::law;

/// Starts from the present state: the strain of the last pass is that of the displacements less the
/// velocities, and nothing has acted.
#[inline(never)]
pub(crate) fn start(system: &mut System<'_>) {
    if !system.layout.has(Feature::Viscosity) {
        return;
    }
    let chunks = system.layout.chunks;
    system.arrays.rows.past.fill(crate::sheet::viscous::NO_PAST);
    for j in 0..system.layout.nodes_y {
        for i in 0..system.layout.nodes_x {
            for axis in [Axis::Horizontal, Axis::Vertical] {
                let Some(before) = system.segment(axis, i, j).map(|segment| segment.twice_strain_before()) else {
                    continue;
                };
                let past = planes::row_mut(system.arrays.rows.past, chunks, j);
                if let Some(slot) = planes::get_mut(past, axis as usize, i) {
                    *slot = before;
                }
            }
        }
    }
}

/// What the forces of the last pass take at the present rates and have not been counted for, J.
pub(crate) fn open(system: &System<'_>) -> f64 {
    if !system.layout.has(Feature::Viscosity) {
        return 0.0;
    }
    let mut taken = 0.0;
    for (i, j) in system.nodes() {
        let mut of_node = 0.0;
        for axis in [Axis::Horizontal, Axis::Vertical] {
            let [past, stress, moment] = past(system, axis, i, j);
            let taken_by_moment = 0.5 * moment * negative_second_difference(system, axis, i, j);
            of_node += system.layout.node_weight(i, j) * taken_by_moment;
            let Some(segment) = system.segment(axis, i, j) else { continue };
            let growth = segment.twice_strain() - past;
            let length = segment.rest.length;
            of_node += system.layout.segment_weight(axis, i, j) * (0.25 * length * length * stress * growth);
        }
        taken += of_node * system.mass_share_of_row(j);
    }
    taken * system.model.unit_energy
}

/// Twice the strain in the last pass of the segment from node (i, j), the viscous part of its stress, and the
/// node's moment.
pub(crate) fn past(system: &System<'_>, axis: Axis, i: usize, j: usize) -> [f64; 3] {
    let row = planes::row(system.arrays.rows.past, system.layout.chunks, j);
    [0, VISCOUS_STRESS, MOMENT]
        .map(|first| first + axis as usize)
        .map(|plane| planes::get(row, plane, i).unwrap_or(0.0))
}

/// Velocity along z at a place, of the image beyond a mirror plane too; 0 where there is no node.
fn speed(system: &System<'_>, i: Option<usize>, j: Option<usize>) -> f64 {
    let (Some(i), Some(j)) = (i, j) else { return 0.0 };
    let layout = &system.layout;
    let (ply, row) = layout.ply_and_row(j);
    let ((i, _), (row, _)) = (layout.x.node(i), if layout.is_stack() { (row, false) } else { layout.y.node(j) });
    let row = planes::row(system.arrays.rows.hot, layout.chunks, ply * layout.y.modelled() + row);
    planes::get(row, SPEED_Z, i).unwrap_or(0.0)
}

/// 2 v_i - v_{i-1} - v_{i+1} along z at a node; of no meaning where its yarn ends.
fn negative_second_difference(system: &System<'_>, axis: Axis, i: usize, j: usize) -> f64 {
    let (before, after) = match axis {
        Axis::Horizontal => (speed(system, i.checked_sub(1), Some(j)), speed(system, Some(i + 1), Some(j))),
        Axis::Vertical => (speed(system, Some(i), j.checked_sub(1)), speed(system, Some(i), Some(j + 1))),
    };
    let here = speed(system, Some(i), Some(j));
    (here - before) + (here - after)
}

/// Moment -M_i that the next pass finds for the yarn of this direction at a node, or at its image.
pub(crate) fn moment(system: &System<'_>, axis: Axis, i: usize, j: usize) -> f64 {
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
    let viscosity = system.direction(axis, j).viscosity.lanes::<f64>();
    negative_second_difference(system, axis, i, j) * viscosity.bending(before, after)
}
