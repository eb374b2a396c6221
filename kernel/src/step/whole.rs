//! Sweep of the whole sheet, or of some rows of it, by one thread.
//!
//! Method: rows that are awake or next to one are swept from the lowest up. A stack is swept some rows of all
//! plies after the other, whose columns are separated while they are at hand.
//! Reference: docs/model.md, "The step".

use crate::contact::search::Gathered;
use crate::contact::separate::{EarlyRows, Separation};
use crate::ground::planes::{CARRY_PLANES, CHUNK};
use crate::memory::arrays::StepScratch;
use crate::memory::network::Network;
use crate::memory::system::System;
use crate::sweep::accounts;
use crate::sweep::moments;
use crate::sweep::rows::Rows;
use crate::sweep::segments::Report;
use crate::sweep::terms::{Terms, rates};

/// Sweeps all rows that are awake or next to one (M7), puts fixed nodes back and adds up their reactions.
pub(crate) fn sweep(system: &mut System<'_>, gathered: &Gathered) -> Report {
    begin_sweep(&mut system.network);
    let report = if system.network.layout.is_stack() {
        sweep_stack(system, gathered.count)
    } else {
        let awake = system.network.awake;
        sweep_rows(&mut system.network, system.state.sums.loaded, 0, awake, None)
    };
    accounts::add_awake(&mut system.network, &mut system.state.sums);
    report
}

/// For bands, after the sweep of the rows that are awake: what is left of it.
pub(crate) fn end_sweep(system: &mut System<'_>, gathered: &Gathered) {
    if system.network.layout.is_stack() {
        let early = EarlyRows::of(&system.network, system.contacts.found(gathered.count));
        let rows = [0, system.network.layout.y.modelled()];
        Separation::of(system, 0).early(&early, rows);
    }
    accounts::add_awake(&mut system.network, &mut system.state.sums);
}

/// Sweeps some rows of all plies after the other, whose columns are separated while they are at hand.
/// `count`: candidates.
fn sweep_stack(system: &mut System<'_>, count: usize) -> Report {
    let early = EarlyRows::of(&system.network, system.contacts.found(count));
    let (mut report, mut first, layout, loaded) =
        (Report::default(), 0, system.network.layout, system.state.sums.loaded);
    while first < layout.y.modelled() {
        let rows = [first, first + (RUN_CHUNKS / (layout.plies * layout.chunks).max(1)).max(1)];
        for ply in 0..layout.plies {
            report = report.merged(sweep_run(&mut system.network, loaded, ply, rows));
        }
        Separation::of(system, 0).early(&early, rows);
        first = rows[1];
    }
    report
}

/// Sweeps those of a ply's rows [first, end) that are awake, counted from its first one.
fn sweep_run(system: &mut Network<'_>, loaded: u64, ply: usize, [first, end]: [usize; 2]) -> Report {
    let ([bottom, _], [low, high]) = (system.layout.rows_of(ply), system.awake_of(ply));
    let (start, stop) = ((bottom + first).max(low), (bottom + end).min(high));
    if start >= stop {
        return Report::default();
    }
    if stop < high {
        moments::find_moments_above(system, loaded, [ply, 0], stop);
    }
    sweep_rows(system, loaded, ply, [start, stop], None)
}

/// About as many chunks of a stack are swept in a run: half a mebibyte, which a second-level cache keeps
/// until the plies are separated.
const RUN_CHUNKS: usize = 1024;

/// Notes that the rows to step are awake.
pub(crate) fn wake_rows_to_step(system: &mut Network<'_>) {
    for ply in 0..system.layout.plies {
        let rows = system.rows_to_step(ply);
        if rows[0] < rows[1] {
            system.set_awake(ply, rows);
        }
    }
}

/// State from which a sweep starts: rows to step awake, ghost row placed, no force carried.
#[inline(never)]
fn begin_sweep(system: &mut Network<'_>) {
    wake_rows_to_step(system);
    place_ghosts_above(system, system.awake[1]);
    let carries = StepScratch::of(system.arrays.shared, &system.layout).carries;
    carries
        .iter_mut()
        .take(system.layout.plies * system.layout.chunks)
        .for_each(|forces| *forces = [[0.0; CHUNK]; CARRY_PLANES]);
}

/// Sweeps rows [first, end) in a step of a block, with the forces carried in that step; reactions are noted
/// and not yet added up.
pub(crate) fn sweep_in_block(system: &mut Network<'_>, loaded: u64, step: usize, rows: [usize; 2]) -> Report {
    if rows[0] == rows[1] {
        return Report::default();
    }
    moments::find_moments_above(system, loaded, [0, step], rows[1]);
    sweep_rows(system, loaded, 0, rows, Some(step))
}

/// Sweeps rows [first, end) of a ply. `in_block`: the step of a block.
fn sweep_rows(system: &mut Network<'_>, loaded: u64, ply: usize, rows: [usize; 2], in_block: Option<usize>) -> Report {
    let rates = rates(system, loaded);
    let Network { layout, directions, clamps, arrays, fetches, instructions, .. } = &mut *system;
    // In a block rows come from memory in the first step alone.
    let fetches = *fetches && in_block.is_none_or(|step| step == 0);
    let terms = Terms { layout, directions, clamps: *clamps, rates: &rates, fetches, instructions: *instructions };
    // A block shorter than the layout says is a lost state, never a row that stands still.
    match &mut Rows::of(arrays, layout, rows, ply, in_block) {
        Some(rows) => rows.sweep(&terms),
        None => Report::LOST,
    }
}

/// Ghost row above a sweep that reaches the mirror plane.
pub(crate) fn place_ghosts_above(system: &mut Network<'_>, end: usize) {
    if system.layout.y.is_mirrored() && end == system.layout.nodes_y {
        system.place_ghost_row();
    }
}
