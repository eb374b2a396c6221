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

/// What the touched nodes give the body and take from it.
struct Sums {
    /// Mean rates of the body in the pass.
    velocity: Vector,
    rate: Vector,
    impulse: Vector,
    arm: Vector,
    work: f64,
    loss: f64,
    rubbed: f64,
    held: f64,
    touched: u64,
}

/// A touched node: its place, and its mass over that of one of the front fabric.
struct Node {
    i: usize,
    j: usize,
    share: f64,
}

impl Sums {
    /// Books what the body gives a node. Returns the change of the node's velocity, spacings a pass, and the body's share of the work.
    #[inline(always)]
    fn give(&mut self, candidate: &Candidate, rubbing: Option<&Tangential>, unit: f64) -> (Vector, f64) {
        let normal = candidate.normal;
        let mut push = normal * (candidate.impulse / unit);
        if let Some(t) = rubbing {
            push += t.push(t.impulse) * (1.0 / unit);
            self.impulse -= t.push(t.impulse) * candidate.images();
            self.arm -= t.twist(t.impulse) * candidate.images();
            let done = self.rubbing(t) * candidate.images();
            self.work += done;
            self.rubbed += done;
        }
        let body_speed = normal.dot(&self.velocity) + candidate.arm.dot(&self.rate);
        // What all images of the node give; without mirror planes it is the node's own.
        let given = candidate.impulse * candidate.images();
        self.impulse -= normal * given;
        self.arm -= candidate.arm * given;
        self.work += given * body_speed;
        self.touched += 1;
        (push, body_speed)
    }

    /// Work of friction on the body's surface, J.
    #[inline(always)]
    fn rubbing(&self, t: &Tangential) -> f64 {
        t.work(t.surface_speed(&self.velocity, &self.rate))
    }

    /// Books what a fixed node takes.
    #[inline(always)]
    fn hold(&mut self, candidate: &Candidate, rubbing: Option<&Tangential>, body_speed: f64) {
        let given = candidate.impulse * candidate.images();
        self.loss += given * body_speed;
        let along = rubbing.map_or(0.0, |t| self.rubbing(t));
        self.held += given * body_speed + along * candidate.images();
    }

    /// Into those of the state.
    fn note(mut self, system: &mut System<'_>, before: &Body) {
        system.state.sums.contacts = self.touched;
        if self.touched == 0 {
            return;
        }
        self.impulse.component_mul_assign(&system.scene.symmetry.force_mask());
        self.arm.component_mul_assign(&system.scene.symmetry.torque_mask());
        if system.state.watch.first.is_none() {
            let energy = before.kinetic_energy(&system.model.inertia);
            system.state.watch.note_contact(system.state.step, before, energy);
        }
        let sums = &mut system.state.sums;
        sums.impulses += self.touched;
        sums.impulse += self.impulse;
        sums.window += self.impulse;
        if system.model.inertia.turns {
            sums.angular_impulse += pose::out_of_body(&before.orientation, &self.arm);
        }
        sums.work += self.work;
        sums.loss += self.loss;
        sums.friction += self.rubbed;
        sums.support_work += self.held;
    }
}

/// Moves the touched nodes and sums impulse, angular impulse, work and loss.
#[inline(never)] // It must not add to the stack of the solve.
pub(crate) fn book_contact(system: &mut System<'_>, count: usize, before: &Body) {
    let body = system.state.body;
    let mut sums = Sums {
        velocity: (before.velocity + body.velocity) * 0.5,
        rate: (before.angular_velocity + body.angular_velocity) * 0.5,
        impulse: Vector::zeros(),
        arm: Vector::zeros(),
        work: 0.0,
        loss: 0.0,
        rubbed: 0.0,
        held: 0.0,
        touched: 0,
    };
    let nx = system.layout.nodes_x;
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
        let mut i = (node as usize).wrapping_sub(start);
        if i >= nx {
            (i, j) = system.layout.column_and_row(node as usize);
            (start, share) = (node as usize - i, system.mass_share_of_row(j));
        }
        let rubbing = system.blocks.tangential.get(c).map(Tangential::read);
        let (push, body_speed) = sums.give(&candidate, rubbing.as_ref(), system.model.unit_impulse * share);
        if let Some(flags) = system.blocks.flags.get_mut(node as usize / 32) {
            *flags |= 1 << (node % 32);
        }
        if candidate.is_fixed() {
            system.load_support(i, j, &(push * share));
            sums.hold(&candidate, rubbing.as_ref(), body_speed);
            continue;
        }
        let place = Node { i, j, share };
        let Some(v) = move_node(system, &candidate, &place, &push) else { break };
        if woken != j {
            system.wake(j);
            woken = j;
        }
        take(system, &mut sums, &candidate, rubbing.as_ref(), [push, v], body_speed);
        if system.layout.has(Feature::Viscosity) {
            book_viscous(system, &place, &push);
        }
    }
    sums.note(system, before);
}

/// Changes the velocity of a free node by `push`, and moves it along, but for the theta rule, which has put it in its place already. Returns
/// its velocity, spacings a pass.
#[inline(always)]
fn move_node(system: &mut System<'_>, candidate: &Candidate, node: &Node, push: &Vector) -> Option<Vector> {
    let (lane, row) = (node.i % CHUNK, planes::row_mut(system.blocks.hot, system.layout.chunks, node.j));
    let chunk = row.get_mut(node.i / CHUNK)?;
    let v = [chunk[3][lane] + push.x, chunk[4][lane] + push.y, chunk[5][lane] + push.z];
    let mut u = [chunk[0][lane], chunk[1][lane], chunk[2][lane]];
    if !system.layout.has(Feature::Theta) {
        let from = candidate.displacement;
        u = [from[0] + v[0], from[1] + v[1], from[2] + v[2]];
    }
    (chunk[0][lane], chunk[1][lane], chunk[2][lane]) = (u[0], u[1], u[2]);
    (chunk[3][lane], chunk[4][lane], chunk[5][lane]) = (v[0], v[1], v[2]);
    widen(system, node.j, u);
    Some(Vector::from(v))
}

/// Books what a free node takes: from t_{n-1/2} to t_{n+1/2}; with the theta rule's velocities, all at t_n, across the impulse alone.
#[inline(always)]
fn take(
    system: &System<'_>,
    sums: &mut Sums,
    candidate: &Candidate,
    rubbing: Option<&Tangential>,
    [push, v]: [Vector; 2],
    body_speed: f64,
) {
    let unit_speed = system.model.unit_speed;
    let speed_after = if system.layout.has(Feature::Theta) {
        candidate.speed_before + candidate.normal.dot(&push) * unit_speed
    } else {
        candidate.normal.dot(&v) * unit_speed
    };
    let given = candidate.impulse * candidate.images();
    sums.loss -= given * (0.5 * (candidate.speed_before + speed_after) - body_speed);
    if let Some(t) = rubbing {
        let [p, q] = t.along(&(v * unit_speed));
        let [p_before, q_before] = t.speed_before;
        sums.rubbed -= t.work([0.5 * (p_before + p), 0.5 * (q_before + q)]) * candidate.images();
    }
}

/// The sweep has booked the viscous push on a node as if it went on with the velocity before the impulse.
#[inline(always)]
fn book_viscous(system: &mut System<'_>, node: &Node, push: &Vector) {
    let pushes = planes::row(system.blocks.pushes, system.layout.chunks, node.j);
    let viscous = [0, 1, 2].map(|plane| planes::get(pushes, plane, node.i).unwrap_or(0.0));
    let crossed = 0.5 * push.dot(&Vector::from(viscous)) * system.layout.node_weight(node.i, node.j);
    system.state.sums.viscous -= crossed * (system.model.unit_energy * node.share);
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
