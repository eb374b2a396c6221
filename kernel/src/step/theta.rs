//! The paper's theta rule with fixed-point iteration: the reference method beside velocity Verlet.
//!
//! Method: with accelerations a_n at the start and a^K at the latest guess of the step's end,
//!   g = theta [(1 - theta) a_n + theta a^K],  x^{K+1} = x_n + v+ + g,  a^{K+1} = forces(x^{K+1}),
//! until no node moves by more than the tolerance; then v_{n+1} = v+ + (1 - theta) a_n + theta a^{K+1} (M10).
//! Units: h and dt. v+ is v_n after the contact impulses of this step. They are found anew in every
//! iteration from the gaps at t_n and the speeds v_n + g, and act in full on position and velocity: weighted
//! with theta they would make an elastic bounce. Damage is always taken from the history at t_n and committed
//! once, after convergence, like body and sums. The state is synchronous: positions, velocities and damage
//! all at t_n. Every row is stepped, also those at rest.
//! Limits: the iteration contracts by (dt/dt_crit)^2 for theta = 1/2, so it needs the same steps as velocity
//! Verlet; its error constant is twice Verlet's. Without convergence the step fails with the state kept at
//! t_n.
//! Reference: Powell and Zohdi (2009), their temporal discretisation and adaptive iteration.

use crate::body::pose::Vector;
use crate::body::projectile::Body;
use crate::contact::apply;
use crate::contact::edge::Edges;
use crate::contact::search::Gathered;
use crate::contact::solve;
use crate::ground::error::Failure;
use crate::ground::math;
use crate::ground::planes::{
    self, CARRY_PLANES, CHUNK, Chunk, GUESS, GUESS_ACCELERATION, HOT_PLANES, ITERATE_PLANES, SPEED_X,
    START_ACCELERATION, STIFFNESS, VELOCITY_AFTER_IMPULSES, X,
};
use crate::ground::ranges::{NOT_KEPT, end_of_range};
use crate::memory::arrays::{Arrays, Contacts, RowArrays, StepScratch};
use crate::memory::network::{Network, mean_acceleration};
use crate::memory::records::Candidate;
use crate::memory::state::{COUNT_MAX, Sums};
use crate::memory::system::System;
use crate::scene::parts::Integrator;
use crate::sheet::columns::Net;
use crate::sheet::ghosts::{place_ghost_column, place_ghost_row};
use crate::sheet::neighbours::{Around, NOTHING};
use crate::sheet::weave::in_runs;
use crate::step::motion;
use crate::sweep::pass::RowForces;
use crate::sweep::segments::per_mass;
use crate::sweep::terms::Terms;
use crate::yarn::law::Damage;
use crate::yarn::rate::Rates;

/// A force beyond this, in units of m h/dt^2, is that of a lost state (see [`crate::yarn::law::LOST`]).
const LARGEST_FORCE: f64 = 1e80;

/// Steps nodes and rates of the body. On a failure nothing has changed.
pub(crate) fn iterate(system: &mut System<'_>, gathered: &Gathered, before: &Body) -> Result<(), Failure> {
    let System { network, contacts, solid, state, failed_segments, .. } = system;
    let rule = network.scene.integrator;
    // A prescribed body already has the twist of this step.
    let (body, count) = (state.body, gathered.count);
    start_velocities(network);
    keep_gaps(contacts, count);
    let mut kept = 0;
    for iteration in 1..=rule.max_iterations {
        state.body = body;
        motion::load_body(network, state);
        approach_with_forces(network, contacts, rule, count);
        // Who gets past the body is found once, and from then on only taken back: an iteration that changed
        // its mind would not end.
        let edges = Edges { network, solid, body: &state.body };
        kept = if iteration == 1 { edges.set_aside(contacts, count, gathered.deepest) } else { kept };
        let solved;
        (solved, kept) = edges.solve_contact(contacts, kept, count, |contacts, count| {
            solve::solve_first(network, contacts, &state.body, count)
        });
        push_candidates(network, contacts.found(count));
        let moved = guess(network, rule);
        let sound = forces_at_guess(network) && moved.is_finite();
        if !sound {
            break;
        }
        if moved <= rule.tolerance {
            apply::set_twist(&network.model, state, &solved);
            if commit(network, &mut state.sums, rule) {
                *failed_segments = network.count_failed([0, network.layout.nodes_y]);
            }
            apply::apply_impulses(network, contacts, state, count, before);
            motion::add_load(network, state, before);
            let sums = &mut state.sums;
            sums.iterations = (sums.iterations + iteration as u64).min(COUNT_MAX);
            sums.most_iterations = sums.most_iterations.max(iteration as u64);
            return Ok(());
        }
    }
    state.body = *before;
    start_iterates(network);
    Err(Failure::NotConverged)
}

/// The state's displacements as the first guess, and the forces there as those at the step's start.
pub(crate) fn start_iterates(network: &mut Network<'_>) {
    for (iterate, hot) in network.arrays.rows.iterate.iter_mut().zip(network.arrays.rows.hot.iter()) {
        iterate[GUESS..VELOCITY_AFTER_IMPULSES].copy_from_slice(&hot[X..SPEED_X]);
    }
    forces_at_guess(network);
    forces_to_start(network);
}

fn forces_to_start(network: &mut Network<'_>) {
    for chunk in network.arrays.rows.iterate.iter_mut() {
        chunk.copy_within(GUESS_ACCELERATION..ITERATE_PLANES, START_ACCELERATION);
    }
}

/// Velocities at t_n, before any impulse.
fn start_velocities(network: &mut Network<'_>) {
    for (iterate, hot) in network.arrays.rows.iterate.iter_mut().zip(network.arrays.rows.hot.iter()) {
        iterate[VELOCITY_AFTER_IMPULSES..START_ACCELERATION].copy_from_slice(&hot[SPEED_X..STIFFNESS]);
    }
}

/// Keeps phi/dt of the nodes found: every iteration starts from it.
fn keep_gaps(contacts: &mut Contacts<'_>, count: usize) {
    for (gap, candidate) in contacts.gaps_over_dt.iter_mut().zip(contacts.candidates.iter()).take(count) {
        *gap = candidate.free_gap_rate;
    }
}

/// phi/dt + n.(v_n + g) of every candidate.
fn approach_with_forces(network: &Network<'_>, contacts: &mut Contacts<'_>, rule: Integrator, count: usize) {
    let Contacts { candidates, gaps_over_dt, .. } = contacts;
    for (candidate, gap) in candidates.iter_mut().zip(gaps_over_dt.iter()).take(count) {
        let (i, j) = network.layout.column_and_row(candidate.node as usize);
        let velocity = network.velocity_with_forces(rule.theta, i, j);
        candidate.free_gap_rate = gap + candidate.normal.dot(&velocity) * network.model.unit_speed;
    }
}

/// v_n and the impulse of every candidate.
fn push_candidates(network: &mut Network<'_>, candidates: &[Candidate]) {
    for candidate in candidates {
        let (i, j) = network.layout.column_and_row(candidate.node as usize);
        let (_, v) = network.node(i, j);
        let push = candidate.normal * (candidate.impulse / network.model.unit_impulse);
        let row = planes::row_mut(network.arrays.rows.iterate, network.layout.chunks, j);
        for axis in 0..3 {
            planes::set(row, VELOCITY_AFTER_IMPULSES + axis, i, v[axis] + push[axis]);
        }
    }
}

/// The next guess of every free node; returns the largest change of a coordinate, infinite if any is not a
/// number.
fn guess(network: &mut Network<'_>, rule: Integrator) -> f64 {
    let chunks = network.layout.chunks;
    let (mut largest, mut finite) = (0.0, true);
    for j in 0..network.layout.nodes_y {
        let run = network.arrays.rows.runs.get(j).copied().unwrap_or([0; 4]);
        let hot = planes::row(network.arrays.rows.hot, chunks, j);
        let iterate = planes::row_mut(network.arrays.rows.iterate, chunks, j);
        for i in (0..network.layout.nodes_x).filter(|&i| !in_runs(&run, i)) {
            let (Some(hot), Some(iterate)) = (hot.get(i / CHUNK), iterate.get_mut(i / CHUNK)) else { break };
            let lane = i % CHUNK;
            for axis in 0..3 {
                let g = mean_acceleration(
                    rule.theta,
                    iterate[START_ACCELERATION + axis][lane],
                    iterate[GUESS_ACCELERATION + axis][lane],
                );
                let next = hot[axis][lane] + (iterate[VELOCITY_AFTER_IMPULSES + axis][lane] + g);
                let change = next - iterate[GUESS + axis][lane];
                let size = math::abs(change);
                finite &= size.is_finite();
                largest = math::max(size, largest);
                iterate[GUESS + axis][lane] = next;
            }
        }
    }
    if finite { largest } else { f64::INFINITY }
}

/// Accelerations at the guess, with damage from the history at t_n, by the sweep's evaluator of forces. false
/// if the state would be lost.
fn forces_at_guess(network: &mut Network<'_>) -> bool {
    let Network { layout, directions, clamps, arrays, instructions, .. } = network;
    let (chunks, rates) = (layout.chunks, Rates::NONE);
    let Arrays { rows: RowArrays { hot, history, yarn, strength, iterate, .. }, shared, columns, lines, .. } = arrays;
    let StepScratch { carries: carry, .. } = StepScratch::of(shared, layout);
    if layout.x.is_mirrored() {
        (0..layout.nodes_y).for_each(|j| place_ghost_column(planes::row_mut(iterate, chunks, j), layout.x));
    }
    if layout.y.is_mirrored() {
        place_ghost_row(iterate, chunks, layout.y);
    }
    carry.fill([[0.0; CHUNK]; CARRY_PLANES]);
    let net = Net { columns, lines };
    let terms =
        Terms { layout, directions, clamps: *clamps, rates: &rates, fetches: false, instructions: *instructions };
    let (pass, mut sound) = (terms.pass(net, 0), true);
    let (mut here, mut right, mut over) = (NOTHING, NOTHING, NOTHING);
    let (mut along, mut up) = ([[0.0; CHUNK]; 3], [[0.0; CHUNK]; 3]);
    for j in 0..layout.nodes_y {
        let Some((below, above)) = iterate.split_at_mut_checked((j + 1) * chunks) else { break };
        let (row, above) = (planes::row_mut(below, chunks, j), planes::row(above, chunks, 0));
        let rows = planes::row(hot, chunks, j).iter().zip(planes::row(history, chunks, j));
        let yarn = terms.yarn_row(yarn, strength, j, 0);
        let mut forces = RowForces::of(&pass, j, &yarn, layout.has_verticals(j));
        let mut left = [0.0; 3];
        for (c, (hot, history)) in rows.enumerate() {
            set_guessed(&mut here, row.get(c), Some(hot));
            set_guessed(&mut right, row.get(c + 1), None);
            set_guessed(&mut over, above.get(c), None);
            let around = Around { here: &here, right: &right, above: &over };
            forces.all(c, &around, history, &mut (), [&mut along, &mut up]);
            sound &= !forces.is_lost();
            let (Some(chunk), Some(carry)) = (row.get_mut(c), carry.get_mut(c)) else { break };
            for lane in 0..CHUNK.min(layout.nodes_x.saturating_sub(c * CHUNK)) {
                let widths = net.inverse_widths(c * CHUNK + lane, j);
                for axis in 0..3 {
                    let (right, lift) = (along[axis][lane], up[axis][lane]);
                    let sum = per_mass(right, left[axis], lift - carry[axis][lane], widths);
                    sound &= (-LARGEST_FORCE..=LARGEST_FORCE).contains(&sum);
                    (carry[axis][lane], left[axis], chunk[GUESS_ACCELERATION + axis][lane]) = (lift, right, sum);
                }
            }
        }
    }
    sound
}

/// Puts nodes to their guesses, with the stiffnesses of `hot`.
fn set_guessed(
    nodes: &mut Chunk<HOT_PLANES>,
    iterate: Option<&Chunk<ITERATE_PLANES>>,
    hot: Option<&Chunk<HOT_PLANES>>,
) {
    *nodes = NOTHING;
    if let Some(iterate) = iterate {
        nodes[X..SPEED_X].copy_from_slice(&iterate[GUESS..VELOCITY_AFTER_IMPULSES]);
    }
    if let Some(hot) = hot {
        nodes[STIFFNESS..].copy_from_slice(&hot[STIFFNESS..]);
    }
}

/// Takes the converged guess: positions, velocities without impulses, supports, damage. Returns whether a
/// segment has failed.
fn commit(network: &mut Network<'_>, sums: &mut Sums, rule: Integrator) -> bool {
    let chunks = network.layout.chunks;
    let theta = rule.theta;
    for j in 0..network.layout.nodes_y {
        let run = network.arrays.rows.runs.get(j).copied().unwrap_or([0; 4]);
        let (mut low, mut high) = (0.0, 0.0);
        for i in 0..network.layout.nodes_x {
            let iterate = planes::row(network.arrays.rows.iterate, chunks, j);
            let at = |plane: usize| planes::get(iterate, plane, i).unwrap_or(0.0);
            let a = [0, 1, 2]
                .map(|axis| (1.0 - theta) * at(START_ACCELERATION + axis) + theta * at(GUESS_ACCELERATION + axis));
            let u = [at(GUESS), at(GUESS + 1), at(GUESS + 2)];
            low = math::min(u[1], low);
            high = math::max(u[1], high);
            if in_runs(&run, i) {
                network.load_support(sums, i, j, &Vector::from(a));
                continue;
            }
            let (_, v) = network.node(i, j);
            network.set_node(i, j, u, [v[0] + a[0], v[1] + a[1], v[2] + a[2]]);
        }
        if let Some(range) = network.arrays.rows.ranges.get_mut(j) {
            *range = [end_of_range(low), end_of_range(high), NOT_KEPT, NOT_KEPT];
        }
    }
    network.awake = [0, network.layout.nodes_y];
    let has_failed = commit_damage(network);
    forces_to_start(network);
    has_failed
}

/// History and stiffness at the new positions, once a step. Returns whether a segment has failed.
fn commit_damage(network: &mut Network<'_>) -> bool {
    let (layout, mut failed) = (network.layout, false);
    layout.for_each_segment(|axis, i, j| {
        let Some(segment) = network.segment(axis, i, j) else { return };
        let q = segment.twice_strain();
        if !network.direction(axis, j).law.is_damaging(q, segment.history) {
            return;
        }
        let Damage { alpha, history } = network.law_of(&segment).damage(segment.damage_rate, q);
        failed |= alpha == 0.0;
        let hot = planes::row_mut(network.arrays.rows.hot, layout.chunks, j);
        planes::set(hot, STIFFNESS + axis as usize, i, alpha * segment.undamaged);
        let histories = planes::row_mut(network.arrays.rows.history, layout.chunks, j);
        planes::set(histories, axis as usize, i, history);
    });
    failed
}
