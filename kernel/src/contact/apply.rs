//! Effects of contact: rates of the body, motion of the nodes, and the sums of impulse, work and loss.
//!
//! Method: each impulse moves its node by lambda n/m and the body by the opposite. Work on either is impulse
//! times the mean of its velocities before and after (M13); the loss is the difference of both. A node of
//! multiplicity k counts k times.
//! Limits: restitution 0. Moments are those at t_n.
//! Reference: docs/model.md, "The step".

use crate::body::pose::{self, Vector};
use crate::body::projectile::{Body, Twist};
use crate::contact::candidate::Solved;
use crate::ground::math;
use crate::ground::planes::{self, CHUNK};
use crate::ground::ranges::{NOT_KEPT, end_of_range};
use crate::memory::records::{Candidate, Tangential};
use crate::memory::system::System;
use crate::scene::features::Feature;

/// Rounding of a gap, in parts of the places that it is the difference of: half a last place from each of
/// node, body and their difference, three of the turn into the body's axes, and two of the distance from a
/// face.
const PLACE_ROUNDING: f64 = 4.0 * f64::EPSILON;

/// The body's rates after contact, and what the solve took.
pub(crate) fn set_twist(system: &mut System<'_>, solved: &Solved) {
    let Twist { velocity, angular_velocity } = solved.twist;
    (system.state.body.velocity, system.state.body.angular_velocity) = (velocity, angular_velocity);
    let sums = &mut system.state.sums;
    sums.most_sweeps = sums.most_sweeps.max(u64::from(solved.sweeps));
    if !solved.converged {
        let places = math::length(system.state.body.position.into()) + system.model.reach;
        // Gaps are differences of places: what rounding of these can do to a speed is no lack of convergence.
        sums.unconverged += u64::from(solved.residual > PLACE_ROUNDING * places / system.model.limits.dt);
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

    /// Takes the work on a node off the loss. `v`: its velocity now, m/s; `speed_after`: its speed along the
    /// normal.
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
pub(crate) fn apply_impulses(system: &mut System<'_>, count: usize, before: &Body) {
    let mut totals = Totals::between(before, &system.state.body);
    let (nx, implicit) = (system.layout.nodes_x, system.layout.has(Feature::Theta));
    // They come row by row: what a row needs is done once for each.
    let (mut start, mut j, mut share, mut woken) = (0, 0, system.mass_share_of_row(0), usize::MAX);
    for c in 0..count {
        let Some(&candidate) = system.arrays.candidates.get(c) else { break };
        let node = candidate.node;
        if candidate.impulse <= 0.0 {
            continue;
        }
        let mut i = (node as usize).wrapping_sub(start);
        if i >= nx {
            (i, j) = system.layout.column_and_row(node as usize);
            (start, share) = (node as usize - i, system.mass_share_of_row(j));
        }
        let mut push = candidate.normal * (candidate.impulse / (system.model.unit_impulse * share));
        let friction = system.arrays.tangential.get(c).copied();
        if let Some(t) = &friction {
            push += t.as_vector(t.impulse) * (1.0 / (system.model.unit_impulse * share));
        }
        system.set_flag(node as usize);
        let given = totals.give(&candidate, friction.as_ref());
        if candidate.is_fixed() {
            if system.layout.has(Feature::Casing) && !system.is_fixed(i, j) {
                system.state.sums.casing += push * share;
            } else {
                system.load_support(i, j, &(push * share));
            }
            totals.hold(&candidate, friction.as_ref(), given);
            continue;
        }
        let Some(v) = move_node(system, &candidate, [i, j], &push) else { break };
        if system.layout.has(Feature::Casing) {
            let [x, _, z] = candidate.displacement;
            correct_casing_loss(system, [x, z], [i, j], &push);
        }
        if woken != j {
            system.wake(j);
            woken = j;
        }
        // From t_{n-1/2} to t_{n+1/2}; with the theta rule's velocities, all at t_n, across the impulse
        // alone.
        let unit_speed = system.model.unit_speed;
        let speed_after = if implicit {
            candidate.speed_before + candidate.normal.dot(&push) * unit_speed
        } else {
            candidate.normal.dot(&v) * unit_speed
        };
        totals.lose(&candidate, friction.as_ref(), given, speed_after, &(v * unit_speed));
    }
    add_to_sums(system, totals, before);
}

/// Corrects the loss at the case for a node to which projectile or plies have then given this velocity,
/// spacings a step. `displacement`: at the start of the step along x and z.
#[inline(never)]
pub(crate) fn correct_casing_loss(system: &mut System<'_>, displacement: [f64; 2], [i, j]: [usize; 2], given: &Vector) {
    let kept = system.arrays.rows.case_impulse.get(j * system.layout.chunks + i / CHUNK);
    let by_case = kept.map_or(0.0, |pushes| pushes[i % CHUNK]);
    if by_case > 0.0 {
        let (rest, [x, z]) = (system.rest(i, j), displacement);
        let (x, z) = (rest[0] + x, rest[2] + z);
        let along = (x * given.x + z * given.z) / math::length([x, 0.0, z]);
        let unit = system.model.unit_energy * system.mass_share_of_row(j);
        system.state.sums.casing_loss -= unit * (0.5 * by_case * along);
    }
}

/// Gives a free node its velocity after a push, in spacings a step, and puts it where that leads. Returns the
/// velocity.
#[inline(always)]
fn move_node(system: &mut System<'_>, candidate: &Candidate, [i, j]: [usize; 2], push: &Vector) -> Option<Vector> {
    let lane = i % CHUNK;
    let chunk = planes::row_mut(system.arrays.rows.hot, system.layout.chunks, j).get_mut(i / CHUNK)?;
    let v = Vector::from(planes::velocity(chunk, lane)) + push;
    let mut u = planes::displacement(chunk, lane);
    if !system.layout.has(Feature::Theta) {
        let from = candidate.displacement;
        u = [from[0] + v[0], from[1] + v[1], from[2] + v[2]];
    } // The theta rule has put the node in its place already.
    planes::set_motion(chunk, lane, u, v.into());
    widen(system, j, u);
    Some(v)
}

/// Adds a step's contact to the sums.
fn add_to_sums(system: &mut System<'_>, mut totals: Totals, before: &Body) {
    system.state.sums.contacts = totals.touched;
    if totals.touched == 0 {
        return;
    }
    totals.impulse.component_mul_assign(&system.scene.symmetry.force_mask());
    totals.angular_impulse.component_mul_assign(&system.scene.symmetry.torque_mask());
    if system.state.watch.first.is_none() {
        let energy = before.kinetic_energy(&system.model.inertia);
        system.state.watch.note_contact(system.state.step, before, energy);
    }
    let sums = &mut system.state.sums;
    sums.impulses += totals.touched;
    sums.impulse += totals.impulse;
    sums.window += totals.impulse;
    if system.model.inertia.turns {
        sums.angular_impulse += pose::out_of_body(&before.orientation, &totals.angular_impulse);
    }
    sums.work += totals.work;
    // Where normal impulses turn the slip around, friction gives back a part of what they lose: it is theirs.
    sums.loss += totals.loss + math::min(totals.friction, 0.0);
    sums.friction += math::max(totals.friction, 0.0);
    sums.support_work += totals.support_work;
}

/// Notes that a row holds a node with this displacement.
fn widen(system: &mut System<'_>, j: usize, [x, y, _]: [f64; 3]) {
    if let Some([low, high, left, right]) = system.arrays.rows.ranges.get_mut(j) {
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
