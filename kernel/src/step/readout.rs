//! Read-outs over the segments that start in a row, side by side in lanes.
//!
//! Method: the expressions of [`Network::segment`], and so its bits. One by one are looked at those next to a
//! mirror plane, in the coarse part of a graded network, of a curved sheet, and in a lane group that holds a
//! broken one.
//! Limits: where there is no segment the stiffness is 0, as of a broken one.
//! Reference: docs/model.md, "The step".

use crate::ground::lanes::{Job, Lane};
use crate::ground::math;
use crate::ground::planes::{self, Axis, CHUNK, X};
use crate::memory::network::Network;
use crate::sheet::neighbours::Around;
use crate::sweep::pass::greatest;

/// Chunk c of row j; None next to a mirror plane, in the coarse part of a graded network and of a curved
/// sheet.
#[inline(always)]
pub(crate) fn around<'a>(network: &'a Network<'_>, c: usize, j: usize) -> Option<Around<'a>> {
    let layout = &network.layout;
    if layout.x.is_mirrored() || layout.y.is_mirrored() || !network.net(0).is_fine(c, j) {
        return None;
    }
    let [row, above] = [j, j + 1].map(|j| planes::row(network.arrays.rows.hot, layout.chunks, j));
    Around::of(row, above, c)
}

/// The greatest q = U^2 - 1 of the segments that start in row j and are not broken; 0 if none is stretched.
pub(crate) struct GreatestOfRow<'a> {
    pub network: &'a Network<'a>,
    pub j: usize,
}

impl Job for GreatestOfRow<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<L: Lane>(self) -> f64 {
        let GreatestOfRow { network, j } = self;
        let (mut found, mut alone) = (L::splat(0.0), 0.0);
        for c in 0..network.layout.chunks {
            let around = around(network, c, j);
            for axis in [Axis::Horizontal, Axis::Vertical] {
                let rest = network.direction(axis, j).rest.lanes::<L>();
                for g in 0..CHUNK / L::WIDTH {
                    if let Some(around) = &around
                        && !L::splat(0.0).sub(around.stiffness(g)[axis as usize]).any_not_below(L::splat(0.0))
                    {
                        found = rest.twice_strain(around.of_axis::<L>(axis, X, g)).max(found);
                    } else {
                        let first = c * CHUNK + g * L::WIDTH;
                        alone = math::max(greatest_alone(network, axis, first, L::WIDTH, j), alone);
                    }
                }
            }
        }
        math::max(greatest(found), alone)
    }
}

/// Greatest stretch of segments along an axis, one by one.
#[inline(never)] // It must not be compiled for each instruction set.
fn greatest_alone(network: &Network<'_>, axis: Axis, first: usize, count: usize, j: usize) -> f64 {
    let segments = (first..first + count).filter_map(|i| network.segment(axis, i, j));
    let whole = segments.filter(|segment| segment.stiffness > 0.0);
    whole.fold(0.0, |greatest, segment| math::max(segment.twice_strain(), greatest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ground::lanes::InstructionSet;
    use crate::scene::parts::{Scene, StrengthDraw, Symmetry};
    use crate::step::energy::weighted_energy;
    use crate::tests::{sheet, sim};

    /// Strain and dissipated energy and the greatest q, segment by segment.
    fn one_by_one(network: &Network<'_>, loaded: u64) -> (f64, f64, f64) {
        let (mut strain, mut dissipated, mut greatest) = (0.0, 0.0, 0.0);
        let axes = [Axis::Horizontal, Axis::Vertical];
        let rates = axes.map(|axis| [network.rate_law_before(axis, loaded), network.rate_law(axis, loaded)]);
        for j in 0..network.layout.nodes_y {
            let (mut row_strain, mut row_dissipated) = (0.0, 0.0);
            for i in 0..network.layout.nodes_x {
                for (axis, rates) in axes.into_iter().zip(&rates) {
                    let (stored, lost) = weighted_energy(network, rates, axis, i, j);
                    row_strain += stored;
                    row_dissipated += lost;
                    greatest = math::max(greatest_alone(network, axis, i, 1, j), greatest);
                }
            }
            strain += network.mass_share_of_row(j) * row_strain;
            dissipated += row_dissipated;
        }
        (strain * network.model.unit_energy, dissipated * network.model.segment_volume, greatest)
    }

    #[test]
    fn lanes_give_the_bits_of_single_segments() {
        let changes: [fn(&mut Scene); 10] = [
            |_| (),
            |scene| scene.yarn.stochastic = false,
            |scene| (scene.sheet.spacing_y, scene.sheet.crimp) = (1.2 * scene.sheet.spacing, [0.001, 0.003]),
            |scene| scene.yarn.strength_draw = StrengthDraw::Weibull,
            |scene| {
                scene.symmetry = Symmetry { mirror_x: true, mirror_y: true };
                scene.yarn.stochastic = false;
            },
            |scene| scene.slack_balance = true,
            |scene| {
                (scene.yarn.rate_modulus, scene.yarn.rate_stretch) = (0.02, 0.01);
                (scene.yarn.rate_reference, scene.yarn.rate_limit) = (1.0, 1e4);
            },
            |scene| (scene.stack.plies, scene.stack.gap) = (2, 1e-4),
            |scene| scene.set_grading(0.03).unwrap(),
            |scene| (scene.sheet.nodes_x, scene.sheet.nodes_y) = (58, 47),
        ];
        for (k, change) in changes.into_iter().enumerate() {
            // Drawn yarn.
            let mut scene = sheet(61, 61);
            scene.projectile.velocity[2] = 300.0;
            change(&mut scene);
            let mut sim = sim(&scene);
            let mut failed = 0;
            for _ in 0..6 {
                sim.advance(150).unwrap();
                let (strain, dissipated, greatest) = one_by_one(&sim.system.network, sim.system.state.sums.loaded);
                for set in InstructionSet::ALL.into_iter().filter(|set| set.available()) {
                    sim.use_instructions(set).unwrap();
                    let energy = sim.energy().unwrap();
                    assert_eq!((energy.strain, energy.dissipated), (strain, dissipated), "scene {k}");
                    assert_eq!(sim.fabric().unwrap().max_stretch, crate::yarn::law::stretch(greatest), "scene {k}");
                }
                failed = sim.counters().failed_segments;
            }
            assert!(failed > 0, "scene {k}");
        }
    }
}
