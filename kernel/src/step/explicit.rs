//! One step: velocity Verlet in sweep form with impulse contact, or the theta rule (`theta.rs`), and what
//! both share.
//!
//! Method: nodes near the projectile are found, every row is swept (damage, velocity, position), the touched
//! nodes are corrected by contact impulses, the body moves. Positions live at t_n, velocities at t_{n-1/2};
//! they are never synchronised.
//! Limits: dt <= 0.5 dt_crit; no point of the projectile's surface crosses a spacing, and it turns by less
//! than half a radian, in a step.
//! Reference: docs/model.md, "The step"; L. Verlet, Phys. Rev. 159 (1967) 98.

use crate::body::pose::Vector;
use crate::body::projectile::Body;
use crate::contact::apply;
use crate::contact::backing;
use crate::contact::edge;
use crate::contact::search::{self, Gathered};
use crate::contact::separate::Apart;
use crate::contact::solve;
use crate::contact::stack;
use crate::ground::error::Failure;
use crate::ground::math;
use crate::ground::planes::{self, Axis, CARRY_PLANES, CHUNK};
use crate::memory::arrays::Noted;
use crate::memory::system::System;
use crate::memory::watch::Outcome;
use crate::scene::features::Feature;
use crate::scene::parts::Symmetry;
use crate::sheet::clamp::LET_GO;
use crate::sheet::segments::Report;
use crate::sheet::slack::SEARCH_INTERVAL;
use crate::sheet::viscous::MomentsOfRow;
use crate::sheet::weave::{self, ATTACHMENTS};
use crate::step::motion;
use crate::step::outcome::{self, TEST_INTERVAL};
use crate::step::rows::Rows;
use crate::step::rows::moments::find_moments_of_row;
use crate::step::rows::terms::Terms;
use crate::step::slackness;
use crate::step::theta;
use crate::yarn::rate::Rates;

/// One step. A projectile that is too fast and too many candidates are found before anything is changed.
pub(crate) fn step_once(system: &mut System<'_>) -> Result<(), Failure> {
    let at_start = system.state.body;
    let target = motion::prescribe_twist(system);
    let all = [0, system.layout.nodes_y];
    let found = motion::refuse_too_fast(system).and_then(|()| search::gather(system, all));
    let gathered = found.inspect_err(|_| system.state.body = at_start)?;
    if system.layout.has(Feature::Theta) {
        theta::iterate(system, system.scene.integrator, &gathered, &at_start)?;
    } else {
        let report = sweep(system, &gathered);
        apply_contact_and_load(system, report, &gathered, &at_start)?;
    }
    move_body_and_check(system, &gathered, target)?;
    end_step(system);
    Ok(())
}

/// What the theta rule starts from, if it is in use: to be found anew whenever positions or damage have been
/// changed by hand.
pub(crate) fn start_forces(system: &mut System<'_>) {
    if system.layout.has(Feature::Theta) {
        theta::start_iterates(system);
    }
}

/// What follows the pass of a step.
pub(crate) fn end_step(system: &mut System<'_>) {
    system.state.step += 1;
    if system.layout.has(Feature::Rate) && (system.state.loaded > 0 || system.state.sums.contacts > 0) {
        system.state.loaded += 1;
    }
    if system.layout.has(Feature::Slack) && system.state.step % SEARCH_INTERVAL == 1 {
        slackness::search(system);
    }
    close_window(system);
    if system.state.step.is_multiple_of(TEST_INTERVAL) {
        outcome::test_outcomes(system);
    }
}

/// The body moves; high-water marks.
#[inline(never)]
fn move_body_and_check(
    system: &mut System<'_>,
    gathered: &Gathered,
    target: Option<(Vector, nalgebra::Quaternion<f64>)>,
) -> Result<(), Failure> {
    motion::move_body(system, target);
    let (sums, deepest) = (&mut system.state.sums, gathered.deepest);
    sums.worst_penetration = math::max(deepest, sums.worst_penetration);
    sums.beyond_fine += u64::from(gathered.is_beyond_fine);
    sums.most_candidates = sums.most_candidates.max(gathered.count as u64);
    motion::refuse_lost_body(system)
}

/// For bands and blocks, before the sweep: the candidates of the next pass among `rows` [first, end), or why
/// there can be none. The state stays as it is.
#[inline(never)]
pub(crate) fn look_ahead(system: &mut System<'_>, rows: [usize; 2]) -> Result<Gathered, Failure> {
    let at_start = system.state.body;
    motion::prescribe_twist(system);
    let found = motion::refuse_too_fast(system).and_then(|()| search::gather(system, rows));
    system.state.body = at_start;
    found
}

/// For bands and blocks, after the sweep: the rest of the pass.
#[inline(never)]
pub(crate) fn finish_step(system: &mut System<'_>, gathered: &Gathered, report: Report) -> Result<(), Failure> {
    let at_start = system.state.body;
    let target = motion::prescribe_twist(system);
    apply_contact_and_load(system, report, gathered, &at_start)?;
    move_body_and_check(system, gathered, target)
}

/// What the sweep leaves to do: failures, loads and contact.
#[inline(never)]
fn apply_contact_and_load(
    system: &mut System<'_>,
    report: Report,
    gathered: &Gathered,
    before: &Body,
) -> Result<(), Failure> {
    let mut count = gathered.count;
    if report.non_finite {
        return Err(Failure::NonFinite);
    }
    if system.scene.symmetry == Symmetry::default() {
        system.failed_segments += report.newly_failed;
    } else if report.newly_failed > 0 {
        system.failed_segments = system.count_failed([0, system.layout.nodes_y]);
    }
    motion::load_body(system);
    let apart = system.layout.is_stack().then(|| Apart::of(system, count));
    if count > 0 {
        search::complete_candidates(system, count);
        if system.layout.has(Feature::Casing) {
            count = backing::back_by_case(system, count);
        }
        let kept = edge::set_aside(system, count, gathered.deepest);
        let (solved, _) = if system.layout.is_stack() {
            edge::solve_contact(system, kept, count, stack::solve)
        } else {
            edge::solve_contact(system, kept, count, solve::solve_first)
        };
        apply::set_twist(system, &solved);
        apply::apply_impulses(system, count, before);
    } else {
        system.state.sums.contacts = 0;
    }
    if let Some(apart) = apart {
        apart.separate_others(system, count);
    }
    motion::add_load(system, before);
    Ok(())
}

/// The hot pass over all rows that are awake or next to one, with fixed nodes put back and their pull booked.
fn sweep(system: &mut System<'_>, gathered: &Gathered) -> Report {
    begin_sweep(system);
    let report = if system.layout.is_stack() {
        sweep_stack(system, gathered.count)
    } else {
        sweep_rows(system, 0, system.awake, None)
    };
    add_to_sums(system);
    report
}

/// For bands, after the sweep of the rows that are awake: what is left of it.
pub(crate) fn end_sweep(system: &mut System<'_>, gathered: &Gathered) {
    if system.layout.is_stack() {
        Apart::of(system, gathered.count).separate(system, [0, system.layout.y.modelled()]);
    }
    add_to_sums(system);
}

/// Books what a sweep of the rows that are awake has taken, and what it has been pulled and pushed by.
#[inline(never)]
fn add_to_sums(system: &mut System<'_>) {
    for ply in 0..system.layout.plies {
        let rows = system.awake_of(ply);
        add_dissipation(system, ply, rows, 0);
        add_pulls(system, ply, rows, 0);
        if system.layout.has(Feature::Clamps) {
            add_clamp_work(system, ply, rows, 0);
        }
        add_case_pushes(system, ply, rows);
    }
}

/// The hot pass over some rows of all plies after the other, whose columns are separated while they are at
/// hand. `count`: candidates.
fn sweep_stack(system: &mut System<'_>, count: usize) -> Report {
    let (mut report, mut first, apart) = (Report::default(), 0, Apart::of(system, count));
    while first < system.layout.y.modelled() {
        let rows = [first, first + (RUN_CHUNKS / (system.layout.plies * system.layout.chunks).max(1)).max(1)];
        for ply in 0..system.layout.plies {
            report = report.merged(sweep_run(system, ply, rows));
        }
        apart.separate(system, rows);
        first = rows[1];
    }
    report
}

/// The hot pass over those of a ply's rows [first, end) that are awake, counted from its first one.
fn sweep_run(system: &mut System<'_>, ply: usize, [first, end]: [usize; 2]) -> Report {
    let ([bottom, _], [low, high]) = (system.layout.rows_of(ply), system.awake_of(ply));
    let (start, stop) = ((bottom + first).max(low), (bottom + end).min(high));
    if start >= stop {
        return Report::default();
    }
    if system.layout.has(Feature::Viscosity) && stop < high {
        find_moments_above(system, [ply, 0], stop);
    }
    sweep_rows(system, ply, [start, stop], None)
}

/// About as many chunks of a stack are swept in a run: half a mebibyte, which a second-level cache keeps
/// until the plies are separated.
const RUN_CHUNKS: usize = 1024;

/// What a sweep starts from: the rows to step are awake.
#[inline(never)]
fn begin_sweep(system: &mut System<'_>) {
    for ply in 0..system.layout.plies {
        let rows = system.rows_to_step(ply);
        if rows[0] < rows[1] {
            system.set_awake(ply, rows);
        }
    }
    place_images_above(system, system.awake[1]);
    let carries = Noted::of(system.arrays.shared, &system.layout).carries;
    carries
        .iter_mut()
        .take(system.layout.plies * system.layout.chunks)
        .for_each(|forces| *forces = [[0.0; CHUNK]; CARRY_PLANES]);
}

/// The hot pass over rows [first, end) in a step of a block: with the forces carried in that step, and pulls
/// that are noted and not booked.
pub(crate) fn sweep_in_block(system: &mut System<'_>, step: usize, rows: [usize; 2]) -> Report {
    if system.layout.has(Feature::Viscosity) {
        find_moments_above(system, [0, step], rows[1]);
    }
    sweep_rows(system, 0, rows, Some(step))
}

/// The viscous moments of row j of a ply in a step of a block, the first one otherwise, which the row below
/// it needs; nothing above the top row.
#[inline(never)]
fn find_moments_above(system: &mut System<'_>, [ply, step]: [usize; 2], j: usize) {
    let rates = rates(system);
    let System { layout, directions, arrays, instructions, .. } = &mut *system;
    let chunks = layout.chunks;
    let (past_below, past) = arrays.rows.past.split_at_mut((j * chunks).min(arrays.rows.past.len()));
    let Some(taken) = arrays.rows.taken.get_mut(step * layout.nodes_y + j).filter(|_| j < layout.nodes_y) else {
        return;
    };
    let row = MomentsOfRow {
        directions: directions.of_ply(ply),
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
    let terms = Terms { layout, directions, rates: &rates, fetches: false, instructions: *instructions };
    find_moments_of_row(&terms, j, row, taken);
}

/// The hot pass over rows [first, end) of a ply. `in_block`: the step of a block.
#[inline(never)]
fn sweep_rows(system: &mut System<'_>, ply: usize, rows: [usize; 2], in_block: Option<usize>) -> Report {
    let rates = rates(system);
    let System { layout, directions, arrays, fetches, instructions, .. } = &mut *system;
    // In a block rows come from memory in the first step alone.
    let fetches = *fetches && in_block.is_none_or(|step| step == 0);
    let terms = Terms { layout, directions, rates: &rates, fetches, instructions: *instructions };
    // A block shorter than the layout says is a lost state, never a row that stands still.
    match &mut Rows::of(arrays, layout, rows, ply, in_block) {
        Some(rows) => rows.sweep(&terms),
        None => Report::LOST,
    }
}

/// Books the energy that viscosity and rate have taken of rows [first, end) of a ply in a step of a block,
/// the first one otherwise, lowest row first.
#[inline(never)]
pub(crate) fn add_dissipation(system: &mut System<'_>, ply: usize, [first, end]: [usize; 2], step: usize) {
    let unit = system.model.unit_energy * system.mass_share(ply);
    let taken = system.arrays.rows.taken.get(step * system.layout.nodes_y..).and_then(|taken| taken.get(first..end));
    taken.into_iter().flatten().for_each(|taken| system.state.sums.viscous += unit * taken);
}

/// Adds what the clamps of rows [first, end) of a ply have dissipated in a step of a block, the first one
/// otherwise, lowest row first.
#[inline(never)]
pub(crate) fn add_clamp_work(system: &mut System<'_>, ply: usize, [first, end]: [usize; 2], step: usize) {
    let unit = system.model.unit_energy * system.mass_share(ply);
    let of_rows = system.arrays.rows.clamped.get(step * system.layout.nodes_y..).and_then(|rows| rows.get(first..end));
    of_rows.into_iter().flatten().for_each(|work| system.state.sums.attachment += unit * work);
}

/// Books what a case has pushed rows [first, end) of a ply by, and what it has taken, lowest row first.
#[inline(never)]
pub(crate) fn add_case_pushes(system: &mut System<'_>, ply: usize, [first, end]: [usize; 2]) {
    let share = system.mass_share(ply);
    let (unit, sums) = (system.model.unit_energy * share, &mut system.state.sums);
    for push in system.arrays.rows.pushed.get_mut(first..end).unwrap_or_default() {
        // The next pass may leave out a row.
        let [x, z, taken] = push.map(|sums| sums.iter().fold(0.0, |sum, part| sum + part));
        *push = [[0.0; CHUNK]; 3];
        sums.casing -= Vector::new(x, 0.0, z) * share;
        sums.casing_loss += unit * taken;
    }
}

/// The row of images above a sweep that reaches the plane.
pub(crate) fn place_images_above(system: &mut System<'_>, end: usize) {
    if system.layout.y.is_mirrored() && end == system.layout.nodes_y {
        system.place_image_row();
    }
}

/// What a sweep needs of the dependence on the rate of strain.
pub(crate) fn rates(system: &System<'_>) -> Rates {
    if !system.layout.has(Feature::Rate) {
        return Rates::NONE;
    }
    // Below it damage sees no strain beyond the critical one.
    let limit = |axis: Axis| system.rate_law(axis).limit(system.direction(axis, 0).critical);
    let time = system.load_time();
    // None before the load has begun.
    let growth = if system.state.loaded > 0 { system.model.limits.dt / time } else { 0.0 };
    let relaxing = system.scene.yarn.rate_modulus * growth;
    Rates { time, relaxing, limits: [limit(Axis::Horizontal), limit(Axis::Vertical)] }
}

/// At the end of a force window: keeps the largest mean force.
fn close_window(system: &mut System<'_>) {
    if !system.state.step.is_multiple_of(system.model.window_steps) {
        return;
    }
    let sums = &mut system.state.sums;
    let w = sums.window;
    let mean = math::length([w.x, w.y, w.z]) / (system.model.window_steps as f64 * system.model.limits.dt);
    sums.force_peak = math::max(mean, sums.force_peak);
    sums.window = Vector::zeros();
    if system.layout.has(Feature::Clamps) {
        test_attachments(system);
    }
}

/// At the end of a force window: the mean force on each attachment, which lets go where that is more than its
/// strength.
#[inline(never)]
fn test_attachments(system: &mut System<'_>) {
    let (step, strength) = (system.state.step, system.scene.attachment.strength);
    let unit = system.model.unit_impulse / (system.model.window_steps as f64 * system.model.limits.dt);
    let sums = &mut system.state.sums;
    let mut lets_go = [false; ATTACHMENTS];
    for (at, lets_go) in lets_go.iter_mut().enumerate() {
        let impulse = sums.support[at] - sums.window_support[at];
        sums.window_support[at] = sums.support[at];
        sums.support_force[at] = math::length(impulse.into()) * unit;
        *lets_go = strength > 0.0 && sums.let_go[at] == 0 && sums.support_force[at] > strength;
        sums.let_go[at] = if *lets_go { step } else { sums.let_go[at] };
    }
    if lets_go == [false; ATTACHMENTS] {
        return;
    }
    let work = sums.work;
    system.state.watch.latch(Outcome::AttachmentFailed, step, work);
    for (i, j) in system.nodes() {
        if system.is_fixed(i, j) && lets_go.get(system.attachment_of(i, j)) == Some(&true) {
            let place = j * system.layout.chunks + i / CHUNK;
            if let Some(slid) = system.arrays.rows.slid.get_mut(place) {
                slid[i % CHUNK] = LET_GO;
            }
        }
    }
}

/// Books what the sheet pulls at the fixed nodes of rows [first, end) of a ply in a step of a block, the
/// first one otherwise, lowest row first.
#[inline(never)]
pub(crate) fn add_pulls(system: &mut System<'_>, ply: usize, [first, end]: [usize; 2], step: usize) {
    let share = system.scene.symmetry.share() * system.mass_share(ply);
    let System { scene, layout, state, arrays, .. } = system;
    let ((kind, symmetry), [bottom, _]) = ((scene.attachment.kind, scene.symmetry), layout.rows_of(ply));
    let Noted { pulls, .. } = Noted::of(arrays.shared, layout);
    let pulls = pulls.get(step * layout.nodes_y..).and_then(|pulls| pulls.get(first..end));
    for (j, pulls) in pulls.into_iter().flatten().enumerate() {
        for (side, pull) in pulls.iter().enumerate() {
            let at = weave::attachment_of(kind, layout.y.nodes, layout.upper, first - bottom + j, side);
            state.sums.add_to_support(kind, at, &(Vector::from(*pull) * share), symmetry);
        }
    }
}
