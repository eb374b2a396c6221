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
use crate::contact::edge::Edges;
use crate::contact::search::{self, Gathered, Search};
use crate::contact::separate::{EarlyRows, Separation};
use crate::contact::solve;
use crate::contact::stack;
use crate::ground::error::Failure;
use crate::ground::math;
use crate::ground::planes::CHUNK;
use crate::memory::network::Network;
use crate::memory::state::State;
use crate::memory::system::System;
use crate::memory::watch::Outcome;
use crate::scene::features::Feature;
use crate::scene::parts::Symmetry;
use crate::sheet::clamp::{self, LET_GO, SLID};
use crate::sheet::weave::ATTACHMENTS;
use crate::step::motion;
use crate::step::outcome::{self, TEST_INTERVAL};
use crate::step::slackness;
use crate::step::theta;
use crate::step::whole;
use crate::sweep::segments::Report;
use crate::sweep::slack::SEARCH_INTERVAL;

/// Takes one step. A projectile that is too fast and too many candidates are found before anything is
/// changed.
pub(crate) fn step_once(system: &mut System<'_>) -> Result<(), Failure> {
    let gathered = look_ahead(system, [0, system.network.layout.nodes_y])?;
    // The theta rule sweeps until its forces agree with where they lead.
    let report =
        if system.network.layout.has(Feature::Theta) { Report::default() } else { whole::sweep(system, &gathered) };
    apply_contact_and_move_body(system, &gathered, report)?;
    count_step(system);
    Ok(())
}

/// Start of the theta rule, if it is in use: forces, to be found anew whenever positions or damage have been
/// changed by hand.
pub(crate) fn start_forces(network: &mut Network<'_>) {
    if network.layout.has(Feature::Theta) {
        theta::start_iterates(network);
    }
}

/// End of a step: counters, and searches and tests that are due after it.
pub(crate) fn count_step(system: &mut System<'_>) {
    let System { network, state, .. } = &mut *system;
    state.step += 1;
    if network.layout.has(Feature::Rate) && (state.sums.loaded > 0 || state.sums.contacts > 0) {
        state.sums.loaded += 1;
    }
    if network.layout.has(Feature::Slack) && state.step % SEARCH_INTERVAL == 1 {
        slackness::search(network);
    }
    close_window(network, state);
    if state.step.is_multiple_of(TEST_INTERVAL) {
        outcome::test_outcomes(system);
    }
}

/// The body moves; high-water marks.
#[inline(never)]
fn move_body_and_check(
    network: &Network<'_>,
    state: &mut State,
    gathered: &Gathered,
    target: Option<(Vector, nalgebra::Quaternion<f64>)>,
) -> Result<(), Failure> {
    motion::move_body(network, state, target);
    let (sums, deepest) = (&mut state.sums, gathered.deepest);
    sums.worst_penetration = math::max(deepest, sums.worst_penetration);
    sums.beyond_fine += u64::from(gathered.is_beyond_fine);
    sums.most_candidates = sums.most_candidates.max(gathered.count as u64);
    motion::refuse_lost_body(&network.model, state)
}

/// Candidates of the next step among `rows` [first, end), before the sweep. The state stays as it is.
///
/// # Errors
/// A body that is too fast or no number, more candidates than there is memory for.
#[inline(never)]
pub(crate) fn look_ahead(system: &mut System<'_>, rows: [usize; 2]) -> Result<Gathered, Failure> {
    let System { network, contacts, solid, state, .. } = system;
    let at_start = state.body;
    motion::prescribe_twist(network, state);
    let found = motion::refuse_too_fast(&network.model, &state.body).and_then(|()| {
        let search = Search::of(network, solid, &state.body);
        search::gather(network, contacts, &search, rows)
    });
    state.body = at_start;
    let losses = state.sums.losses().map(|loss| *loss);
    found.map(|found| Gathered { losses, ..found })
}

/// Takes the rest of a step after its sweep: contact, load, and the motion of the body.
#[inline(never)]
pub(crate) fn apply_contact_and_move_body(
    system: &mut System<'_>,
    gathered: &Gathered,
    report: Report,
) -> Result<(), Failure> {
    let System { network, state, .. } = &mut *system;
    let at_start = state.body;
    let [on_body, friction, plies, case, _] = gathered.losses;
    let clamps = state.sums.clamps.dissipated;
    let target = motion::prescribe_twist(network, state);
    if network.layout.has(Feature::Theta) {
        theta::iterate(system, gathered, &at_start)?;
    } else {
        apply_contact_and_load(system, report, gathered, &at_start)?;
    }
    let State { sums, .. } = &mut system.state;
    if system.network.layout.has.share_losses() {
        // A block has not yet added up what the clamps of all rows have dissipated in this step.
        let pushed = core::mem::take(&mut sums.work_of_pushed);
        sums.share_losses([on_body, friction, plies, case, clamps - pushed]);
    }
    move_body_and_check(&system.network, &mut system.state, gathered, target)
}

/// Failures, loads and contact after the sweep.
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
    let System { network, contacts, solid, state, failed_segments, .. } = system;
    if network.scene.symmetry == Symmetry::default() {
        *failed_segments += report.newly_failed;
    } else if report.newly_failed > 0 {
        *failed_segments = network.count_failed([0, network.layout.nodes_y]);
    }
    motion::load_body(network, state);
    let is_stack = network.layout.is_stack();
    let early = is_stack.then(|| EarlyRows::of(network, contacts.found(count)));
    if count > 0 {
        if clamp::at(network.arrays.rows.clamps, 0).is_some() {
            apply::let_driven_nodes_go(network, &mut state.sums, contacts.found(count));
        }
        search::add_free_velocity(network, contacts, count);
        count = backing::back_by_case(network, contacts, &state.body.twist(), count);
        let edges = Edges { network, solid, body: &state.body };
        let kept = edges.set_aside(contacts, count, gathered.deepest);
        let (solved, _) = if is_stack {
            edges.solve_contact(contacts, kept, count, |contacts, count| {
                stack::solve(network, contacts, &state.body, count)
            })
        } else {
            edges.solve_contact(contacts, kept, count, |contacts, count| {
                solve::solve_first(network, contacts, &state.body, count)
            })
        };
        apply::set_twist(&network.model, state, &solved);
        apply::apply_impulses(network, contacts, state, count, before);
    } else {
        state.sums.contacts = 0;
    }
    if let Some(early) = early {
        Separation { network, contacts, sums: &mut state.sums, count }.others(&early);
    }
    motion::add_load(network, state, before);
    Ok(())
}

/// Keeps the largest mean force at the end of a force window, and tests the attachments.
fn close_window(network: &mut Network<'_>, state: &mut State) {
    if !state.step.is_multiple_of(network.model.window_steps) {
        return;
    }
    let sums = &mut state.sums;
    let w = sums.window;
    let mean = math::length([w.x, w.y, w.z]) / (network.model.window_steps as f64 * network.model.limits.dt);
    sums.force_peak = math::max(mean, sums.force_peak);
    sums.window = Vector::zeros();
    if network.clamps.are_tested(state.step, state.step + 1) {
        test_attachments(network, state);
    }
}

/// Finds the mean force on each attachment over a force window; one lets go where that is more than its
/// strength.
#[inline(never)]
fn test_attachments(network: &mut Network<'_>, state: &mut State) {
    let (step, strength) = (state.step, network.clamps.strength);
    let unit = network.model.unit_impulse / (network.model.window_steps as f64 * network.model.limits.dt);
    let sums = &mut state.sums;
    let mut lets_go = [false; ATTACHMENTS];
    for (at, lets_go) in lets_go.iter_mut().enumerate() {
        let (support, clamps) = (sums.support[at], &mut sums.clamps);
        let impulse = support - clamps.window_support[at];
        clamps.window_support[at] = support;
        clamps.support_force[at] = math::length(impulse.into()) * unit;
        *lets_go = strength > 0.0 && clamps.let_go[at] == 0 && clamps.support_force[at] > strength;
        clamps.let_go[at] = if *lets_go { step } else { clamps.let_go[at] };
    }
    if lets_go == [false; ATTACHMENTS] {
        return;
    }
    let work = sums.work;
    state.watch.latch(Outcome::AttachmentFailed, step, work);
    for (i, j) in network.nodes() {
        if network.arrays.rows.is_attached([i, j]) && lets_go.get(network.attachment_of(i, j)) == Some(&true) {
            let place = j * network.layout.chunks + i / CHUNK;
            if let Some(chunk) = clamp::at_mut(network.arrays.rows.clamps, place) {
                chunk[SLID][i % CHUNK] = LET_GO;
            }
        }
    }
}
