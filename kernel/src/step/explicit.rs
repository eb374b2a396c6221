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
use crate::ground::planes::CHUNK;
use crate::memory::system::System;
use crate::memory::watch::Outcome;
use crate::scene::features::Feature;
use crate::scene::parts::Symmetry;
use crate::sheet::clamp::LET_GO;
use crate::sheet::segments::Report;
use crate::sheet::slack::SEARCH_INTERVAL;
use crate::sheet::weave::ATTACHMENTS;
use crate::step::motion;
use crate::step::outcome::{self, TEST_INTERVAL};
use crate::step::rows::whole;
use crate::step::slackness;
use crate::step::theta;

/// One step. A projectile that is too fast and too many candidates are found before anything is changed.
pub(crate) fn step_once(system: &mut System<'_>) -> Result<(), Failure> {
    let gathered = look_ahead(system, [0, system.layout.nodes_y])?;
    // The theta rule sweeps until its forces agree with where they lead.
    let report = if system.layout.has(Feature::Theta) { Report::default() } else { whole::sweep(system, &gathered) };
    apply_contact_and_move_body(system, &gathered, report)?;
    count_step(system);
    Ok(())
}

/// Start of the theta rule, if it is in use: forces, to be found anew whenever positions or damage have been
/// changed by hand.
pub(crate) fn start_forces(system: &mut System<'_>) {
    if system.layout.has(Feature::Theta) {
        theta::start_iterates(system);
    }
}

/// End of a step: counters, and searches and tests that are due after it.
pub(crate) fn count_step(system: &mut System<'_>) {
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

/// Before the sweep: the candidates of the next step among `rows` [first, end), or why there can be none. The
/// state stays as it is.
#[inline(never)]
pub(crate) fn look_ahead(system: &mut System<'_>, rows: [usize; 2]) -> Result<Gathered, Failure> {
    let at_start = system.state.body;
    motion::prescribe_twist(system);
    let found = motion::refuse_too_fast(system).and_then(|()| search::gather(system, rows));
    system.state.body = at_start;
    found
}

/// After the sweep: the rest of the step.
#[inline(never)]
pub(crate) fn apply_contact_and_move_body(
    system: &mut System<'_>,
    gathered: &Gathered,
    report: Report,
) -> Result<(), Failure> {
    let at_start = system.state.body;
    let target = motion::prescribe_twist(system);
    if system.layout.has(Feature::Theta) {
        theta::iterate(system, system.scene.integrator, gathered, &at_start)?;
    } else {
        apply_contact_and_load(system, report, gathered, &at_start)?;
    }
    move_body_and_check(system, gathered, target)
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
    if system.scene.symmetry == Symmetry::default() {
        system.failed_segments += report.newly_failed;
    } else if report.newly_failed > 0 {
        system.failed_segments = system.count_failed([0, system.layout.nodes_y]);
    }
    motion::load_body(system);
    let apart = system.layout.is_stack().then(|| Apart::of(system, count));
    if count > 0 {
        search::add_free_velocity(system, count);
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
