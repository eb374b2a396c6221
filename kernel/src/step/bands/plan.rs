//! Plan of one pass, known to all bands: made before it by the call that completed the last one, and used up
//! after it.

use super::pointers::{Pointers, rows};
use crate::contact::search::Gathered;
use crate::ground::error::Failure;
use crate::ground::lanes::InstructionSet;
use crate::memory::layout::Layout;
use crate::memory::network::{self, Network};
use crate::memory::system::System;
use crate::sheet::clamp::Clamps;
use crate::sheet::direction::Directions;
use crate::sheet::ghosts::place_ghost_speeds;
use crate::step::blocks;
use crate::step::one_step;
use crate::step::schedule::Block;
use crate::step::whole;
use crate::sweep::terms::{Terms, rates};
use crate::yarn::rate::Rates;

/// Plan of one pass.
pub(super) struct Plan {
    /// Candidates under the projectile, or why the pass cannot be made.
    pub(super) found: Result<Gathered, Failure>,
    /// Rows to sweep [first, end); of a stack from the first of the lowest ply to the last of the highest,
    /// and those between that rest are left out.
    pub(super) rows: [usize; 2],
    /// The block of steps that the pass is part of, if it is.
    pub(super) block: Option<Block>,
    /// The step of the gaps that the pass takes; None for rows away from the body, and outside blocks.
    pub(super) gap_step: Option<usize>,
    /// Whether rows at rest are swept.
    pub(super) all: bool,
    pub(super) layout: Layout,
    pub(super) clamps: Clamps,
    pub(super) rates: Rates,
    pub(super) fetches: bool,
    pub(super) instructions: InstructionSet,
    pub(super) memory: Pointers,
}

/// Rows [first, end) of all plies that a pass steps; the ghost nodes that it needs are put there.
fn prepare_rows(network: &mut Network<'_>) -> [usize; 2] {
    let mut rows = [network.layout.nodes_y, 0];
    for ply in 0..network.layout.plies {
        let [first, end] = network.rows_to_step(ply);
        if first == end {
            continue;
        }
        rows = [rows[0].min(first), rows[1].max(end)];
        whole::place_ghosts_above(network, end);
        if network.layout.x.is_mirrored() && network.layout.reads_ghost_speeds() {
            let (line, chunks) = (network.layout.x, network.layout.chunks);
            let rows = network.arrays.rows.hot.get_mut(first * chunks..end * chunks);
            place_ghost_speeds(rows.unwrap_or(&mut []), chunks, line);
        }
    }
    [rows[0].min(rows[1]), rows[1]]
}

impl Plan {
    /// Plans the pass that follows `last`, or the first one. Blocks end at step `until` at the latest.
    pub(super) fn of(
        system: &mut System<'_>,
        scratch: *mut f64,
        last: Option<&Plan>,
        band_count: u32,
        until: u64,
    ) -> Plan {
        let (block, gap_step) = match last.and_then(Plan::next_part) {
            Some((block, step)) => (Some(block), Some(step)),
            None => (Block::plan(system, until.saturating_sub(system.state.step), band_count), None),
        };
        let all = [0, system.network.layout.nodes_y];
        let found = match (&block, gap_step) {
            (Some(_), None) => {
                blocks::zero_carried_forces(&mut system.network);
                Ok(Gathered::default())
            }
            (block, _) => one_step::look_ahead(system, block.as_ref().map_or(all, |block| block.near)),
        };
        let mut rows = prepare_rows(&mut system.network);
        if let Some(block) = &block {
            rows = gap_step.map_or([0, 0], |step| block.rows_near(step));
        }
        let memory = Pointers::of(&mut system.network, scratch);
        let all = system.network.steps_all();
        Plan {
            found,
            rows,
            block,
            gap_step,
            all,
            layout: system.network.layout,
            clamps: system.network.clamps,
            rates: rates(&system.network, system.state.sums.loaded),
            fetches: system.network.fetches,
            instructions: system.network.instructions,
            memory,
        }
    }

    /// The pass after this one in its block, by the step of the gaps; None after the last and outside blocks.
    pub(super) fn next_part(&self) -> Option<(Block, usize)> {
        let (block, step) = (self.block?, self.gap_step.map_or(0, |step| step + 1));
        (step < block.steps).then_some((block, step))
    }

    /// Rows [first, end) of a band.
    pub(super) fn rows_of(&self, band_count: u32, band: u32) -> [usize; 2] {
        let [first, end] = self.rows;
        // At least 1, so that no division by zero has to be compiled in.
        let start = |band: u32| first + (end - first) * band as usize / band_count.max(1) as usize;
        [start(band), start(band + 1)]
    }

    /// Rows of a ply that are swept.
    ///
    /// # Safety
    /// No call changes the rows that are awake.
    pub(super) unsafe fn rows_of_ply(&self, ply: usize) -> [usize; 2] {
        let layout = &self.layout;
        if !layout.is_stack() {
            return self.rows;
        }
        // SAFETY: there is an entry for each ply; the caller's promise.
        let awake = unsafe { rows(self.memory.awake, 1, ply, 1) }.first().copied().unwrap_or_default();
        network::rows_to_step(layout.rows_of(ply), awake.map(|row| row as usize), self.all)
    }

    /// Constants of the segments. A copy would add to the stack.
    pub(super) fn directions(&self) -> &Directions {
        // SAFETY: those of the simulation, which is lent as long as there are bands; they change between
        // plans only.
        unsafe { &*self.memory.directions }
    }

    /// Constants of the sweep.
    pub(super) fn terms(&self, fetches: bool) -> Terms<'_> {
        let Plan { layout, clamps, rates, instructions, .. } = self;
        Terms { layout, directions: self.directions(), clamps: *clamps, rates, fetches, instructions: *instructions }
    }
}
