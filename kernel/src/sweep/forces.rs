//! Change of velocity that the yarns give one node, between passes.
//!
//! Method: the sweep's evaluator of forces (`sweep/segments.rs`) for the segments from the node, from the one
//! to its left and from the one below. Damage is that up to t_n; nothing is committed.
//! Limits: slack segments give no energy back.
//! Reference: docs/model.md, "The step".

use crate::ground::planes::{self, Axis, CHUNK, MOMENT, STIFFNESS};
use crate::memory::network::Network;
use crate::sheet::neighbours::{Around, NOTHING};
use crate::sweep::moments;
use crate::sweep::pass::{ChunkState, RowEffects, RowForces};
use crate::sweep::segments::per_mass;
use crate::sweep::terms::Terms;
use crate::sweep::terms::rates;
use crate::sweep::viscous::NO_PAST;

/// Change of velocity per step at t_n by the yarns and by the case that the node rests on. `viscous`: with
/// the viscous forces of the next step; after `loaded` steps of load.
pub(crate) fn acceleration(network: &Network<'_>, loaded: u64, viscous: bool, i: usize, j: usize) -> [f64; 3] {
    let from = |i: Option<usize>, j: Option<usize>| {
        i.zip(j).and_then(|(i, j)| forces_from(network, loaded, viscous, i, j)).unwrap_or_default()
    };
    let ([right, up], [left, _]) = (from(Some(i), Some(j)), from(network.layout.x.before(i), Some(j)));
    let [_, down] = from(Some(i), j.checked_sub(1));
    let widths = network.net(0).inverse_widths(i, j);
    let change = [0, 1, 2].map(|k| per_mass(right[k], left[k], up[k] - down[k], widths));
    let Some(case) = network.directions.case() else { return change };
    let (rest, (u, _)) = (network.rest(i, j), network.node(i, j));
    case.carry([0, 1, 2].map(|k| rest[k] + u[k]), change)
}

/// Forces on node (i, j) of the segments that start there, along x and along y; 0 where there is none.
pub(crate) fn forces_from(
    network: &Network<'_>,
    loaded: u64,
    viscous: bool,
    i: usize,
    j: usize,
) -> Option<[[f64; 3]; 2]> {
    let Network { layout, directions, clamps, arrays, instructions, .. } = network;
    let (chunks, (ply, _), (c, lane)) = (layout.chunks, layout.ply_and_row(j), (i / CHUNK, i % CHUNK));
    // The node and its neighbours alone, which may be ghosts beyond a mirror plane.
    let [mut here, mut right, mut above] = [NOTHING; 3];
    let ends = network.ends_of_segments(j);
    for (x, y) in [(0, 0), (1, 0), (0, 1)] {
        let (u, _) = network.node(i + x, j + y);
        let chunk = if y == 1 {
            &mut above
        } else if lane + x < CHUNK {
            &mut here
        } else {
            &mut right
        };
        for (plane, u) in chunk.iter_mut().zip(u) {
            plane[(lane + x) % CHUNK] = u;
        }
    }
    here[STIFFNESS..].copy_from_slice(&planes::row(arrays.rows.hot, chunks, j).get(c)?[STIFFNESS..]);
    let [mut past, mut past_right, mut past_above] = [NO_PAST; 3];
    if viscous {
        past.copy_from_slice(planes::row(arrays.rows.past, chunks, j).get(c)?);
        past[MOMENT][lane] = moments::moment(network, Axis::Horizontal, i, j);
        past[MOMENT + 1][lane] = moments::moment(network, Axis::Vertical, i, j);
        let beside = if lane + 1 < CHUNK { &mut past } else { &mut past_right };
        beside[MOMENT][(lane + 1) % CHUNK] = moments::moment(network, Axis::Horizontal, i + 1, j);
        past_above[MOMENT + 1][lane] = moments::moment(network, Axis::Vertical, i, j + 1);
    }
    let state = ChunkState { past: viscous.then_some([&past, &past_right, &past_above]), energy_error: None };
    let rates = rates(network, loaded);
    let terms =
        Terms { layout, directions, clamps: *clamps, rates: &rates, fetches: false, instructions: *instructions };
    let (pass, yarn) =
        (terms.pass(network.net(ply), ply), terms.yarn_row(arrays.rows.yarn, arrays.rows.strength, j, ply));
    let history = planes::row(arrays.rows.history, chunks, j).get(c)?;
    let around = Around { here: &here, right: &right, above: &above };
    let (mut forces, effects) = (RowForces::of(&pass, j, &yarn, layout.has_verticals(j)), RowEffects::of(&pass));
    let [along, up] = forces.of_node(&around, history, i, &mut effects.on_chunk(state));
    // Yarn beyond all strains that can be stepped has failed.
    let exists = |end: usize, force| if i < end && !forces.is_lost() { force } else { [0.0; 3] };
    Some([exists(ends[0], along), exists(ends[1], up)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ground::lanes::InstructionSet;
    use crate::ground::planes::AT_REST;
    use crate::scene::parts::{Scene, Symmetry};
    use crate::tests::{sheet, sim};

    /// Forces on a node are those of the next step to the bit: at edges, mirror planes, seams and tears.
    #[test]
    fn forces_on_a_node_are_those_of_the_next_step_to_the_bit() {
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
                sim.system.network.instructions = InstructionSet::ALL[k % 4];
                sim.system.network.place_ghost_row();
                let before: std::vec::Vec<_> = sim
                    .system
                    .network
                    .nodes()
                    .map(|(i, j)| {
                        (
                            i,
                            j,
                            sim.system.network.node(i, j).1,
                            acceleration(&sim.system.network, sim.system.state.sums.loaded, true, i, j),
                        )
                    })
                    .collect();
                sim.step().unwrap();
                for (i, j, v, a) in before {
                    if sim.system.network.is_fixed(i, j)
                        || sim.system.network.has_flag(j * sim.system.network.layout.nodes_x + i)
                    {
                        continue;
                    }
                    let due = [0, 1, 2].map(|k| {
                        let v = v[k] + a[k];
                        if v.abs() < AT_REST { 0.0 } else { v }
                    });
                    assert_eq!(sim.system.network.node(i, j).1, due, "({i}, {j}) {:?}", scene.symmetry);
                    moved += usize::from(due != [0.0; 3]);
                }
            }
            assert!(sim.system.failed_segments > 0 && moved > 4000, "{moved}");
        }
    }
}
