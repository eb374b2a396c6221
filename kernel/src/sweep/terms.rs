//! Constants that all rows of a sweep share.

use crate::ground::lanes::InstructionSet;
use crate::ground::planes::Axis;
use crate::ground::planes::{self, Chunk, STRENGTH_PLANES, YARN_PLANES};
use crate::memory::layout::Layout;
use crate::memory::network::Network;
use crate::scene::features::Feature;
use crate::sheet::clamp::Clamps;
use crate::sheet::columns::Net;
use crate::sheet::direction::Directions;
use crate::sweep::pass::Pass;
use crate::sweep::segments::{Constants, YarnRow};
use crate::yarn::rate::Rates;

/// Constants of a sweep.
#[derive(Clone, Copy)]
pub(crate) struct Terms<'t> {
    pub layout: &'t Layout,
    pub directions: &'t Directions,
    pub clamps: Clamps,
    /// Dependence on the rate of strain.
    pub rates: &'t Rates,
    /// Whether rows are fetched from memory ahead of their turn.
    pub fetches: bool,
    pub instructions: InstructionSet,
}

impl<'t> Terms<'t> {
    /// The hot pass with these constants.
    pub fn pass<'p>(&'p self, net: Net<'p>, ply: usize) -> Pass<'p> {
        Pass {
            x: self.layout.x,
            horizontals: self.layout.x.segments(),
            verticals: self.layout.nodes_x,
            directions: self.directions.of_ply(ply),
            net,
            rates: self.rates,
            fetches: self.fetches,
            instructions: self.instructions,
        }
    }

    /// Constants of the segments of the k-th row of `yarn` and `strength`, which are empty where nothing is
    /// drawn.
    #[inline(always)]
    pub fn yarn_row<'y>(
        &self,
        yarn: &'y [Chunk<YARN_PLANES>],
        strength: &'y [Chunk<STRENGTH_PLANES>],
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
        YarnRow { constants, strength: planes::row(strength, self.layout.chunks, k) }
    }
}

/// Dependence on the rate of strain in a sweep, after `loaded` steps of load.
pub(crate) fn rates(system: &Network<'_>, loaded: u64) -> Rates {
    if !system.layout.has(Feature::Rate) {
        return Rates::NONE;
    }
    // Below it damage sees no strain beyond the critical one.
    let limit = |axis: Axis| system.rate_law(axis, loaded).limit(system.direction(axis, 0).critical);
    let time = system.load_time(loaded);
    // None before the load has begun.
    let growth = if loaded > 0 { system.model.limits.dt / time } else { 0.0 };
    let relaxing = system.scene.yarn.rate_modulus * growth;
    Rates { time, relaxing, limits: [limit(Axis::Horizontal), limit(Axis::Vertical)] }
}
