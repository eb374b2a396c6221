//! Effects of contact: rates of the body, motion of the nodes, and the sums of impulse, work and loss.
//!
//! Method: each impulse moves its node by lambda n/m and the body by the opposite. Work on either is impulse
//! times the mean of its velocities before and after (M13); the loss is the difference of both. A node of
//! multiplicity k counts k times.
//! Limits: restitution 0. Moments are those at t_n.
//! Reference: docs/model.md, "The step".

use crate::body::pose::{self, Vector};
use crate::body::projectile::{Body, Twist};
use crate::contact::candidate::{Holder, Solved};
use crate::ground::math;
use crate::ground::planes::{self, CHUNK};
use crate::ground::ranges::{NOT_KEPT, end_of_range};
use crate::memory::arrays::{Contacts, RowArrays};
use crate::memory::model::Model;
use crate::memory::network::Network;
use crate::memory::records::{Candidate, Tangential};
use crate::memory::state::{State, Sums};
use crate::scene::features::Feature;
use crate::sheet::casing;
use crate::sheet::clamp::Pull;

/// Rounding of a gap, in parts of the places that it is the difference of: half a last place from each of
/// node, body and their difference, three of the turn into the body's axes, and two of the distance from a
/// face.
const PLACE_ROUNDING: f64 = 4.0 * f64::EPSILON;

/// The body's rates after contact, and what the solve took.
pub(crate) fn set_twist(model: &Model, state: &mut State, solved: &Solved) {
    let Twist { velocity, angular_velocity } = solved.twist;
    (state.body.velocity, state.body.angular_velocity) = (velocity, angular_velocity);
    let sums = &mut state.sums;
    sums.most_sweeps = sums.most_sweeps.max(u64::from(solved.sweeps));
    if !solved.converged {
        let places = math::length(state.body.position.into()) + model.reach;
        // Gaps are differences of places: what rounding of these can do to a speed is no lack of convergence.
        sums.unconverged += u64::from(solved.residual > PLACE_ROUNDING * places / model.limits.dt);
        sums.contact_residual = math::max(solved.residual, sums.contact_residual);
    }
}

/// Sums of a step's impulses. (M13) Work is impulse times the mean of the rates before and after, for a free
/// and a prescribed body alike: the two then agree to second order.
#[derive(Default)]
struct Totals {
    /// Mean of the body's velocities before and after.
    body: Twist,
    /// Impulse on the body, N s.
    impulse: Vector,
    /// Angular impulse on it in its axes, N m s.
    angular_impulse: Vector,
    /// Work of the body, kinetic energy lost, energy dissipated by friction, work on fixed nodes, J.
    work: f64,
    loss: f64,
    friction: f64,
    support_work: f64,
    /// Nodes with an impulse.
    touched: u64,
}

impl Totals {
    fn between(before: &Body, after: &Body) -> Totals {
        let velocity = (before.velocity + after.velocity) * 0.5;
        let angular_velocity = (before.angular_velocity + after.angular_velocity) * 0.5;
        Totals { body: Twist { velocity, angular_velocity }, ..Totals::default() }
    }

    /// Work of friction on the body.
    #[inline(always)]
    fn friction_work(&self, t: &Tangential) -> f64 {
        t.work(t.surface_speed(&self.body))
    }

    /// Adds the impulses of all images of a node on the body; without mirror planes it is the node's own.
    /// Returns the impulse along the normal, and the speed of the body's surface there.
    #[inline(always)]
    fn give(&mut self, candidate: &Candidate, friction: Option<&Tangential>) -> [f64; 2] {
        let multiplicity = candidate.multiplicity;
        if let Some(t) = friction {
            self.impulse -= t.as_vector(t.impulse) * multiplicity;
            self.angular_impulse -= t.moment(t.impulse) * multiplicity;
            let done = self.friction_work(t) * multiplicity;
            self.work += done;
            self.friction += done;
        }
        let Twist { velocity, angular_velocity } = &self.body;
        let (given, speed) =
            (candidate.impulse * multiplicity, candidate.normal.dot(velocity) + candidate.arm.dot(angular_velocity));
        self.impulse -= candidate.normal * given;
        self.angular_impulse -= candidate.arm * given;
        self.work += given * speed;
        self.touched += 1;
        [given, speed]
    }

    /// Adds the loss at a support: nothing moves there.
    #[inline(always)]
    fn hold(&mut self, candidate: &Candidate, friction: Option<&Tangential>, [given, speed]: [f64; 2]) {
        self.loss += given * speed;
        let along = friction.map_or(0.0, |t| self.friction_work(t));
        self.support_work += given * speed + along * candidate.multiplicity;
    }

    /// Subtracts the work on a node from the loss. `v`: its velocity now, m/s; `speed_after`: its speed along
    /// the normal.
    #[inline(always)]
    fn lose(
        &mut self,
        candidate: &Candidate,
        friction: Option<&Tangential>,
        [given, speed]: [f64; 2],
        speed_after: f64,
        v: &Vector,
    ) {
        self.loss -= given * (0.5 * (candidate.speed_before + speed_after) - speed);
        if let Some(t) = friction {
            let [p, q] = t.along(v);
            let [p_before, q_before] = t.speed_before;
            self.friction -= t.work([0.5 * (p_before + p), 0.5 * (q_before + q)]) * candidate.multiplicity;
        }
    }
}

/// Moves the touched nodes and sums impulse, angular impulse, work and loss. What a fixed node takes goes to
/// its support.
#[inline(never)]
pub(crate) fn apply_impulses(
    network: &mut Network<'_>,
    contacts: &Contacts<'_>,
    state: &mut State,
    count: usize,
    before: &Body,
) {
    let mut totals = Totals::between(before, &state.body);
    let (nx, implicit) = (network.layout.nodes_x, network.layout.has(Feature::Theta));
    // They come row by row: what a row needs is done once for each.
    let (mut start, mut j, mut share, mut woken) = (0, 0, network.mass_share_of_row(0), usize::MAX);
    for c in 0..count {
        let Some(&candidate) = contacts.candidates.get(c) else { break };
        let node = candidate.node;
        if candidate.impulse <= 0.0 {
            continue;
        }
        let mut i = (node as usize).wrapping_sub(start);
        if i >= nx {
            (i, j) = network.layout.column_and_row(node as usize);
            (start, share) = (node as usize - i, network.mass_share_of_row(j));
        }
        let mut push = candidate.normal * (candidate.impulse / (network.model.unit_impulse * share));
        let friction = contacts.tangential.get(c).copied();
        if let Some(t) = &friction {
            push += t.as_vector(t.impulse) * (1.0 / (network.model.unit_impulse * share));
        }
        network.set_flag(node as usize);
        let given = totals.give(&candidate, friction.as_ref());
        if candidate.is_fixed() {
            if candidate.held_by == Holder::Case as u32 {
                state.sums.casing.impulse += push * share;
            } else {
                network.load_support(&mut state.sums, i, j, &(push * share));
            }
            totals.hold(&candidate, friction.as_ref(), given);
            continue;
        }
        let Some(v) = move_node(network, &candidate, [i, j], &push) else { break };
        let [x, _, z] = candidate.displacement;
        correct_casing_loss(network, &mut state.sums, [x, z], [i, j], &push);
        correct_clamp_work(network, &mut state.sums, [i, j], &push);
        if woken != j {
            network.wake(j);
            woken = j;
        }
        // From t_{n-1/2} to t_{n+1/2}; with the theta rule's velocities, all at t_n, across the impulse
        // alone.
        let unit_speed = network.model.unit_speed;
        let speed_after = if implicit {
            candidate.speed_before + candidate.normal.dot(&push) * unit_speed
        } else {
            candidate.normal.dot(&v) * unit_speed
        };
        totals.lose(&candidate, friction.as_ref(), given, speed_after, &(v * unit_speed));
    }
    add_to_sums(network, state, totals, before);
}

/// Corrects the loss at the case for a node to which projectile or plies have then given this velocity,
/// spacings a step. `displacement`: at the start of the step along x and z.
#[inline(always)]
pub(crate) fn correct_casing_loss(
    network: &Network<'_>,
    sums: &mut Sums,
    displacement: [f64; 2],
    [i, j]: [usize; 2],
    given: &Vector,
) {
    let by_case = casing::impulse_on(network.arrays.rows.case_impulse, j * network.layout.chunks + i / CHUNK, i);
    if by_case > 0.0 {
        let (rest, [x, z]) = (network.rest(i, j), displacement);
        let (x, z) = (rest[0] + x, rest[2] + z);
        let along = (x * given.x + z * given.z) / math::length([x, 0.0, z]);
        let unit = network.model.unit_energy * network.mass_share_of_row(j);
        sums.casing.loss -= unit * (0.5 * by_case * along);
    }
}

/// Corrects the work of a clamp on a node out of its jaws to which projectile or plies have then given this
/// velocity, spacings a step.
#[inline(always)]
pub(crate) fn correct_clamp_work(network: &mut Network<'_>, sums: &mut Sums, [i, j]: [usize; 2], given: &Vector) {
    let place = j * network.layout.chunks + i / CHUNK;
    if let Some(mut pull) = Pull::on(network.arrays.rows.clamps, place, i % CHUNK) {
        let (impulse, work) = (pull.impulse(), pull.take_work());
        let unit = network.model.unit_energy * network.mass_share_of_row(j) * network.share(i, j);
        sums.clamps.dissipated -= unit * (0.5 * impulse.dot(given));
        sums.work_of_pushed += unit * work;
    }
}

/// Takes back what clamps have done in this step to candidates out of their jaws along the way that these
/// went before it: the body would keep them on that way, and the clamp would drive it.
#[inline(never)]
pub(crate) fn let_driven_nodes_go(network: &mut Network<'_>, sums: &mut Sums, candidates: &[Candidate]) {
    for candidate in candidates {
        let (i, j) = network.layout.column_and_row(candidate.node as usize);
        let (place, lane) = (j * network.layout.chunks + i / CHUNK, i % CHUNK);
        let RowArrays { hot, clamps, .. } = &mut network.arrays.rows;
        let Some(mut pull) = Pull::on(clamps, place, lane) else { continue };
        let Some(chunk) = planes::row(hot, network.layout.chunks, j).get(i / CHUNK) else { break };
        let impulse = pull.impulse();
        // Work is impulse times the mean of the velocities before and after it.
        if 2.0 * pull.work() + impulse.dot(&Vector::from(planes::velocity(chunk, lane))) >= 0.0 {
            continue;
        }
        let taken = pull.cancel();
        let share = network.mass_share_of_row(j);
        let unit = network.model.unit_energy * share * network.share(i, j);
        sums.clamps.dissipated -= unit * taken;
        sums.work_of_pushed += unit * taken;
        network.load_support(sums, i, j, &(impulse * share));
        if move_node(network, candidate, [i, j], &-impulse).is_none() {
            break;
        }
    }
}

/// Gives a free node its velocity after a push, in spacings a step, and puts it where that leads. Returns the
/// velocity.
#[inline(always)]
fn move_node(network: &mut Network<'_>, candidate: &Candidate, [i, j]: [usize; 2], push: &Vector) -> Option<Vector> {
    let lane = i % CHUNK;
    let chunk = planes::row_mut(network.arrays.rows.hot, network.layout.chunks, j).get_mut(i / CHUNK)?;
    let v = Vector::from(planes::velocity(chunk, lane)) + push;
    let mut u = planes::displacement(chunk, lane);
    if !network.layout.has(Feature::Theta) {
        let from = candidate.displacement;
        u = [from[0] + v[0], from[1] + v[1], from[2] + v[2]];
    } // The theta rule has put the node in its place already.
    planes::set_motion(chunk, lane, u, v.into());
    widen(&mut network.arrays.rows, j, u);
    Some(v)
}

/// Adds a step's contact to the sums.
fn add_to_sums(network: &Network<'_>, state: &mut State, mut totals: Totals, before: &Body) {
    state.sums.contacts = totals.touched;
    if totals.touched == 0 {
        return;
    }
    totals.impulse.component_mul_assign(&network.scene.symmetry.force_mask());
    totals.angular_impulse.component_mul_assign(&network.scene.symmetry.torque_mask());
    if state.watch.first.is_none() {
        let energy = before.kinetic_energy(&network.model.inertia);
        state.watch.note_contact(state.step, before, energy);
    }
    let sums = &mut state.sums;
    sums.impulses += totals.touched;
    sums.impulse += totals.impulse;
    sums.window += totals.impulse;
    if network.model.inertia.turns {
        sums.angular_impulse += pose::out_of_body(&before.orientation, &totals.angular_impulse);
    }
    sums.work += totals.work;
    sums.loss += totals.loss;
    sums.friction += totals.friction;
    sums.support_work += math::max(totals.support_work, 0.0);
}

/// Notes that a row holds a node with this displacement.
fn widen(rows: &mut RowArrays<'_>, j: usize, [x, y, _]: [f64; 3]) {
    if let Some([low, high, left, right]) = rows.ranges.get_mut(j) {
        widen_range([low, high], y);
        if *left != NOT_KEPT {
            widen_range([left, right], x);
        }
    }
}

fn widen_range([low, high]: [&mut u32; 2], displacement: f64) {
    let end = end_of_range(displacement);
    if f32::from_bits(end) < f32::from_bits(*low) {
        *low = end;
    } else if f32::from_bits(end) > f32::from_bits(*high) {
        *high = end;
    }
}
