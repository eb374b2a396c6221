//! What contact leaves: the rates of the body, the touched nodes moved, and the sums of the balances.
//!
//! Method: work is impulse times the mean of the body's rates before and after, of a free and a prescribed one alike: the two then agree to
//! second order. Loss is what the nodes get less than that, with their velocities from t_{n-1/2} to t_{n+1/2}. What a fixed node takes goes to
//! its support, and the work done there, which moves nothing, is lost.
//! Limits: with the theta rule, whose velocities are all at t_n, the loss is that across the impulse alone.

use crate::body::pose::{self, Vector};
use crate::body::projectile::Body;
use crate::contact::candidate::{Candidate, Solved};
use crate::contact::friction::Tangential;
use crate::ground::math;
use crate::ground::planes::{self, CHUNK};
use crate::ground::ranges::{NOT_KEPT, end_of_range};
use crate::memory::system::System;
use crate::scene::features::Feature;

/// What rounding can leave of a gap, in parts of the places that it is the difference of: half a last place from each of node, body and their
/// difference, three of the turn into the body's axes, and two of the distance from a face.
const PLACES: f64 = 4.0 * f64::EPSILON;

/// The body's rates after contact, and what the solve took.
pub(crate) fn set_rates(system: &mut System<'_>, solved: &Solved) {
    system.state.body.velocity = solved.velocity;
    system.state.body.angular_velocity = solved.angular_velocity;
    if solved.sweeps as u64 > system.state.sums.most_sweeps {
        system.state.sums.most_sweeps = solved.sweeps as u64;
    }
    if !solved.converged {
        let places = pose::length(&system.state.body.position) + system.model.reach;
        let sums = &mut system.state.sums;
        // Gaps are differences of places: what rounding of these can do to a speed is no lack of convergence.
        sums.unconverged += u64::from(solved.residual > PLACES * places / system.model.pass_dt);
        sums.contact_residual = math::max(solved.residual, sums.contact_residual);
    }
}

/// Moves the touched nodes and sums impulse, angular impulse, work and loss. What a fixed node takes goes to its support,
/// and the work done there, which moves nothing, is lost. Work is impulse times the mean of the rates
/// before and after, for a free and a prescribed body alike: the two then agree to second order.
#[inline(never)] // As above.
pub(crate) fn book_contact(system: &mut System<'_>, count: usize, before: &Body) {
    let body = system.state.body;
    let mean_velocity = (before.velocity + body.velocity) * 0.5;
    let mean_rate = (before.angular_velocity + body.angular_velocity) * 0.5;
    let mut impulse_sum = Vector::zeros();
    let mut arm_sum = Vector::zeros();
    let (mut work, mut loss, mut rubbed, mut held, mut touched) = (0.0, 0.0, 0.0, 0.0, 0);
    let (nx, chunks, implicit) = (system.layout.nodes_x, system.layout.chunks, system.layout.has(Feature::Theta));
    // They come row by row: what a row needs is done once for each.
    let (mut start, mut j, mut share, mut woken) = (0, 0, system.mass_share_of_row(0), usize::MAX);
    for c in 0..count {
        let (Some(slot), Some(&node)) = (system.blocks.candidates.get(c), system.blocks.candidate_nodes.get(c)) else {
            break;
        };
        let [.., impulse] = *slot;
        if impulse <= 0.0 {
            continue;
        }
        let candidate = Candidate::read(slot);
        let normal = candidate.normal;
        let mut i = (node as usize).wrapping_sub(start);
        if i >= nx {
            (i, j) = system.layout.column_and_row(node as usize);
            (start, share) = (node as usize - i, system.mass_share_of_row(j));
        }
        let mut push = normal * (impulse / (system.model.unit_impulse * share));
        let rubbing = system.blocks.tangential.get(c).map(Tangential::read);
        if let Some(t) = &rubbing {
            push += t.push(t.impulse) * (1.0 / (system.model.unit_impulse * share));
            impulse_sum -= t.push(t.impulse) * candidate.images();
            arm_sum -= t.twist(t.impulse) * candidate.images();
            let done = t.work(t.surface_speed(&mean_velocity, &mean_rate)) * candidate.images();
            work += done;
            rubbed += done;
        }
        if let Some(flags) = system.blocks.flags.get_mut(node as usize / 32) {
            *flags |= 1 << (node % 32);
        }
        let body_speed = normal.dot(&mean_velocity) + candidate.arm.dot(&mean_rate);
        // What all images of the node give; without mirror planes it is the node's own.
        let given = impulse * candidate.images();
        impulse_sum -= normal * given;
        arm_sum -= candidate.arm * given;
        work += given * body_speed;
        touched += 1;
        if candidate.is_fixed() {
            system.load_support(i, j, &(push * share));
            loss += given * body_speed;
            let along = rubbing.map_or(0.0, |t| t.work(t.surface_speed(&mean_velocity, &mean_rate)));
            held += given * body_speed + along * candidate.images();
            continue;
        }
        let lane = i % CHUNK;
        let Some(chunk) = planes::row_mut(system.blocks.hot, chunks, j).get_mut(i / CHUNK) else { break };
        let v = [chunk[3][lane] + push.x, chunk[4][lane] + push.y, chunk[5][lane] + push.z];
        let mut u = [chunk[0][lane], chunk[1][lane], chunk[2][lane]];
        if !implicit {
            let from = candidate.displacement;
            u = [from[0] + v[0], from[1] + v[1], from[2] + v[2]];
        } // The theta rule has put the node in its place already.
        (chunk[0][lane], chunk[1][lane], chunk[2][lane]) = (u[0], u[1], u[2]);
        (chunk[3][lane], chunk[4][lane], chunk[5][lane]) = (v[0], v[1], v[2]);
        widen(system, j, u);
        if woken != j {
            system.wake(j);
            woken = j;
        }
        // From t_{n-1/2} to t_{n+1/2}; with the theta rule's velocities, all at t_n, across the impulse alone.
        let speed_after = if implicit {
            candidate.speed_before + normal.dot(&push) * system.model.unit_speed
        } else {
            normal.dot(&Vector::from(v)) * system.model.unit_speed
        };
        loss -= given * (0.5 * (candidate.speed_before + speed_after) - body_speed);
        if let Some(t) = &rubbing {
            let [p, q] = t.along(&(Vector::from(v) * system.model.unit_speed));
            let [p_before, q_before] = t.speed_before;
            rubbed -= t.work([0.5 * (p_before + p), 0.5 * (q_before + q)]) * candidate.images();
        }
        if system.layout.has(Feature::Viscosity) {
            // The sweep has booked the viscous push as if the node went on with the velocity before the impulse.
            let pushes = planes::row(system.blocks.pushes, system.layout.chunks, j);
            let viscous = [0, 1, 2].map(|plane| planes::get(pushes, plane, i).unwrap_or(0.0));
            let crossed = 0.5 * push.dot(&Vector::from(viscous)) * system.layout.node_weight(i, j);
            system.state.sums.viscous -= crossed * (system.model.unit_energy * share);
        }
    }
    system.state.sums.contacts = touched;
    if touched == 0 {
        return;
    }
    impulse_sum.component_mul_assign(&system.scene.symmetry.force_mask());
    arm_sum.component_mul_assign(&system.scene.symmetry.torque_mask());
    if system.state.watch.first.is_none() {
        let energy = before.kinetic_energy(&system.model.inertia);
        system.state.watch.note_contact(system.state.step, before, energy);
    }
    let sums = &mut system.state.sums;
    sums.impulses += touched;
    sums.impulse += impulse_sum;
    sums.window += impulse_sum;
    if system.model.inertia.turns {
        sums.angular_impulse += pose::out_of_body(&before.orientation, &arm_sum);
    }
    sums.work += work;
    sums.loss += loss;
    sums.friction += rubbed;
    sums.support_work += held;
}

/// Notes that a row holds a node with this displacement.
fn widen(system: &mut System<'_>, j: usize, [x, y, _]: [f64; 3]) {
    if let Some([low, high, left, right]) = system.blocks.ranges.get_mut(j) {
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
