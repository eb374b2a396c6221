//! Viscosity between passes: what it starts from, the energy of the pass that is open, and the force on one
//! node.
//!
//! Method: the forces of `sheet/viscous.rs`, node by node. A pass has counted half of what its own forces
//! take, with the rate after it; the other half, with the rate of t_{n+1/2}, is open until the next pass and
//! is added to a balance in between.
//! Reference: docs/model.md, "Viscosity".

use crate::ground::planes::{self, Axis, MOMENT, SPEED_Z, VISCOUS_STRESS};
use crate::memory::system::System;
use crate::scene::features::Feature;
use crate::sheet::segments::per_mass;
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
            let taken_by_moment = 0.5 * moment * change_of_rate(system, axis, i, j);
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
fn past(system: &System<'_>, axis: Axis, i: usize, j: usize) -> [f64; 3] {
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
fn change_of_rate(system: &System<'_>, axis: Axis, i: usize, j: usize) -> f64 {
    let (before, after) = match axis {
        Axis::Horizontal => (speed(system, i.checked_sub(1), Some(j)), speed(system, Some(i + 1), Some(j))),
        Axis::Vertical => (speed(system, Some(i), j.checked_sub(1)), speed(system, Some(i), Some(j + 1))),
    };
    let here = speed(system, Some(i), Some(j));
    (here - before) + (here - after)
}

/// The moment that the next pass finds for the yarn of this direction at a node, or at its image.
fn moment(system: &System<'_>, axis: Axis, i: usize, j: usize) -> f64 {
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
    change_of_rate(system, axis, i, j) * viscosity.bending(before, after)
}

/// Force of the segment from node (i, j) on it in the next pass, viscosity included.
fn segment_force(system: &System<'_>, axis: Axis, i: Option<usize>, j: Option<usize>) -> [f64; 3] {
    let (Some(i), Some(j)) = (i, j) else { return [0.0; 3] };
    let Some(segment) = system.segment(axis, i, j) else { return [0.0; 3] };
    let end = if axis == Axis::Horizontal { (i + 1, j) } else { (i, j + 1) };
    let [past, ..] = past(system, axis, i, j);
    let viscosity = system.direction(axis, j).viscosity.lanes::<f64>();
    let strain = viscosity.twice_strain(segment.twice_strain().max(0.0), past.max(0.0));
    let [x, y, z] = segment.force(system.stiffness_now(&segment), strain);
    let (here, there) = (moment(system, axis, i, j), moment(system, axis, end.0, end.1));
    [x, y, z + (there - here)]
}

/// Change of velocity in the next pass that the yarns give a node, viscosity included; nothing is committed.
/// Expressions and order of the sweep.
pub(crate) fn acceleration(system: &System<'_>, i: usize, j: usize) -> [f64; 3] {
    let right = segment_force(system, Axis::Horizontal, Some(i), Some(j));
    let left = segment_force(system, Axis::Horizontal, system.layout.x.before(i), Some(j));
    let up = segment_force(system, Axis::Vertical, Some(i), Some(j));
    let down = segment_force(system, Axis::Vertical, Some(i), j.checked_sub(1));
    system.carried(i, j, [0, 1, 2].map(|k| per_mass(right[k], left[k], up[k] - down[k], None)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ground::lanes::InstructionSet;
    use crate::ground::planes::AT_REST;
    use crate::scene::parts::{Scene, Symmetry};
    use crate::tests::{sheet, sim};

    /// The rows' expressions and the single node's are written apart: they must give the same bits, at edges,
    /// planes and tears.
    #[test]
    fn rows_and_single_nodes_agree_to_the_bit() {
        let plain = {
            let mut scene = sheet(21, 18);
            scene.projectile.velocity = [0.0, 0.0, 250.0];
            let yarn = &mut scene.yarn;
            (yarn.viscosity_linear, yarn.viscosity_quadratic, yarn.viscosity_bending) = (0.1, 1.5, 0.06);
            scene
        };
        let part = |mirror_x, mirror_y| {
            let mut scene = Scene { symmetry: Symmetry { mirror_x, mirror_y }, ..plain };
            scene.yarn.stochastic = false;
            scene
        };
        let unlike = {
            let mut scene = plain;
            (scene.sheet.spacing_y, scene.sheet.crimp) = (9e-4, [0.0, 0.004]);
            scene
        };
        let curved = {
            let mut scene = plain;
            (scene.sheet.radius, scene.sheet.spacing_y, scene.yarn.viscosity_bending) =
                (30.0 * scene.sheet.spacing, 9e-4, 0.0);
            scene.projectile.position[2] += scene.sheet.radius;
            scene
        };
        let ring = {
            let mut scene = curved;
            (scene.sheet.nodes_x, scene.sheet.closed) = (60, true);
            let radius = scene.closed_radius();
            scene.projectile.position[2] += radius - scene.sheet.radius;
            scene.sheet.radius = radius;
            scene
        };
        for scene in [plain, part(true, false), part(false, true), part(true, true), unlike, curved, ring] {
            let mut sim = sim(&scene);
            let mut moved = 0;
            for k in 0..60 {
                sim.advance(12).unwrap();
                sim.system.instructions = InstructionSet::ALL[k % 4];
                sim.system.place_image_row();
                let before: std::vec::Vec<_> = sim
                    .system
                    .nodes()
                    .map(|(i, j)| (i, j, sim.system.node(i, j).1, acceleration(&sim.system, i, j)))
                    .collect();
                sim.step().unwrap();
                for (i, j, v, a) in before {
                    let pushed = sim.system.arrays.flags[(j * sim.system.layout.nodes_x + i) / 32]
                        >> ((j * sim.system.layout.nodes_x + i) % 32)
                        & 1
                        == 1;
                    if sim.system.is_fixed(i, j) || pushed {
                        continue;
                    }
                    let due = [0, 1, 2].map(|k| {
                        let v = v[k] + a[k];
                        if v.abs() < AT_REST { 0.0 } else { v }
                    });
                    assert_eq!(sim.system.node(i, j).1, due, "({i}, {j}) {:?}", scene.symmetry);
                    moved += usize::from(due != [0.0; 3]);
                }
            }
            assert!(sim.system.failed_segments > 0 && moved > 4000, "{moved}");
        }
    }
}
