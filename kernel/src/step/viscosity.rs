//! Viscosity of taut yarn at a single node, for read-outs and for contact, and the images that the hot pass needs of it.
//!
//! Method: as in the hot pass (`sheet/viscous.rs`), to the bit, segment by segment.
//! Reference: docs/model.md, "Viscosity".

use crate::ground::planes::Axis;
use crate::memory::system::System;
use crate::scene::features::Feature;
use crate::sheet::sweep::node_sum;
use crate::yarn::law;

/// What viscosity would change of the velocity of node (i, j), spacings a pass, to the bit.
pub(crate) fn push(system: &System<'_>, i: usize, j: usize) -> [f64; 3] {
    let right = segment_force(system, Axis::Horizontal, Some(i), Some(j));
    let left = segment_force(system, Axis::Horizontal, i.checked_sub(1), Some(j));
    let up = segment_force(system, Axis::Vertical, Some(i), Some(j));
    let down = segment_force(system, Axis::Vertical, Some(i), j.checked_sub(1));
    [0, 1, 2].map(|k| node_sum(right[k], left[k], up[k], down[k]))
}

/// What one segment does.
struct Acting {
    /// Relative velocity of its ends.
    rate: [f64; 3],
    /// Stress, without its viscous part.
    tension: f64,
    /// Viscous force on its first node.
    pull: [f64; 3],
}

/// The segment from node (i, j), if there is one.
fn acting(system: &System<'_>, axis: Axis, i: usize, j: usize) -> Option<Acting> {
    let segment = system.segment(axis, i, j)?;
    let end = if axis == Axis::Horizontal { system.node(i + 1, j) } else { system.node(i, j + 1) };
    let (_, v) = system.node(i, j);
    let rate = [end.1[0] - v[0], end.1[1] - v[1], end.1[2] - v[2]];
    let q = segment.twice_strain();
    let stiffness = if system.layout.has(Feature::Toe) && system.failed_segments > 0 {
        segment.stiffness * system.model.toe.factor(q, segment.mark)
    } else {
        segment.stiffness
    };
    let own = (axis.own_axes(segment.d), axis.own_axes(rate));
    let viscosity = &system.direction(axis, j).viscosity;
    let viscous = viscosity.stress(stiffness, q, segment.rest.twice_strain_rate(own.0, own.1));
    let pull = axis.own_axes(segment.rest.force(viscous, own.0));
    Some(Acting { rate, tension: law::stress(stiffness, q), pull })
}

/// Moment of the yarn of this direction at node (i, j), or of its image there.
fn moment(system: &System<'_>, axis: Axis, i: usize, j: usize) -> [f64; 3] {
    let ((node_i, turn_x), (node_j, turn_y)) = (system.layout.x.node(i), system.layout.y.node(j));
    let before = match axis {
        Axis::Horizontal => node_i.checked_sub(1).and_then(|i| acting(system, axis, i, node_j)),
        Axis::Vertical => node_j.checked_sub(1).and_then(|j| acting(system, axis, node_i, j)),
    };
    let (Some(before), Some(behind)) = (before, acting(system, axis, node_i, node_j)) else { return [0.0; 3] };
    let bending = system.direction(axis, node_j).viscosity.bending(before.tension, behind.tension);
    let [x, y, z] = [0, 1, 2].map(|k| (behind.rate[k] - before.rate[k]) * bending);
    [if turn_x { -x } else { x }, if turn_y { -y } else { y }, z]
}

/// Force of the segment from node (i, j) on it, with the moments at its ends.
fn segment_force(system: &System<'_>, axis: Axis, i: Option<usize>, j: Option<usize>) -> [f64; 3] {
    let (Some(i), Some(j)) = (i, j) else { return [0.0; 3] };
    let Some(segment) = acting(system, axis, i, j) else { return [0.0; 3] };
    let end = if axis == Axis::Horizontal { (i + 1, j) } else { (i, j + 1) };
    let (here, there) = (moment(system, axis, i, j), moment(system, axis, end.0, end.1));
    [0, 1, 2].map(|k| segment.pull[k] + (here[k] - there[k]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ground::lanes::InstructionSet;
    use crate::ground::planes;
    use crate::scene::parts::{Scene, Symmetry};
    use crate::{Layout, Sim};

    /// The rows' expressions and the single node's are written apart: they must give the same bits, at edges, planes and tears.
    #[test]
    fn rows_and_single_nodes_agree_to_the_bit() {
        let plain = {
            let mut scene = Scene::sheet_3in_sphere();
            (scene.sheet.nodes_x, scene.sheet.nodes_y) = (21, 18);
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
        let softened = Scene { slack_toe: 0.02, ..plain };
        for scene in [plain, part(true, false), part(false, true), part(true, true), unlike, softened] {
            let layout = Layout::of(&scene).unwrap();
            let mut memory = std::vec![crate::CacheLine::ZERO; layout.lines()];
            let mut sim = Sim::new(&scene, &mut memory).unwrap();
            let mut pushed = 0;
            for turn in 0..48 {
                // Pushes are velocities in a pass: their energy with the velocities before and behind them.
                let mut gained = 0.0;
                sim.advance(14).unwrap();
                let rows = sim.system.rows_to_step(0);
                sim.system.place_image_row();
                sim.system.instructions = InstructionSet::ALL[turn % InstructionSet::ALL.len()];
                let nodes = || (rows[0]..rows[1]).flat_map(|j| (0..layout.nodes_x).map(move |i| (i, j)));
                let expected: std::vec::Vec<_> = nodes().map(|(i, j)| push(&sim.system, i, j)).collect();
                for ((i, j), found) in nodes().zip(&expected).filter(|((i, j), _)| !sim.system.is_fixed(*i, *j)) {
                    let (_, v) = sim.system.node(i, j);
                    let work: f64 = (0..3).map(|k| found[k] * (2.0 * v[k] + found[k])).sum();
                    gained += work * layout.node_weight(i, j);
                }
                sim.advance(1).unwrap();
                for ((i, j), expected) in nodes().zip(expected) {
                    let row = planes::row(sim.system.arrays.pushes, layout.chunks, j);
                    let found = [0, 1, 2].map(|plane| planes::get(row, plane, i).unwrap());
                    assert_eq!(found, expected, "{:?} ({i}, {j}) {:?}", sim.system.instructions, scene.symmetry);
                    pushed += usize::from(found != [0.0; 3]);
                }
                assert!(gained < 0.0, "viscosity takes energy");
            }
            assert!(sim.system.failed_segments > 0 && pushed > 4000, "{pushed}");
        }
    }
}
