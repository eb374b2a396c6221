//! Outcomes: arrested, detached, exited, passed. They latch with their step and are never acted upon: the physics goes on.
//!
//! Method: tested when the step count is a multiple of 64. All but "passed" need a first contact.
//! What is joined to a support is found by joining nodes over live segments into components (union by smaller number).
//! "Detached" asks whether any node touched in the last 64 steps is joined to a support. "Exited" asks what can still act on
//! the body: the held part of the sheet must lie behind or beside its flight, and loose pieces in its way must move with it.
//! Limits: the body is taken to fly on straight (under its present load), and so are the nodes.
//! Without `track_detachment` nothing is known to be loose once a segment has failed: then no node at all may be in the way.
//! Reference: docs/model.md, "Outcomes"; R. E. Tarjan, J. ACM 22 (1975) 215 (disjoint sets).

use crate::blocks::Blocks;
use crate::layout;
use crate::math;
use crate::model::start_motion;
use crate::path;
use crate::pose::Vector;
use crate::projectile::Body;
use crate::scene::{AttachmentKind, Drive};
use crate::sim::Sim;
use crate::sweep::Axis;

/// Steps between two tests.
pub const TEST_INTERVAL: u64 = 64;
/// "Exited" beside loose pieces: over a travel of R the work may change by this part of it, and what the pieces can still
/// take may be four times as much ...
pub const SETTLED_PART: f64 = 0.0025;
/// ... or this, J, if it is more.
pub const SETTLED_WORK: f64 = 2.5e-4;

/// An outcome that can latch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Outcome {
    /// The velocity along the direction at first contact fell to 0 or below. A body at rest then takes its first direction later.
    Arrested = 0,
    /// No node in contact during the last 64 steps is connected to a support any more.
    Detached = 1,
    /// The body goes on and its contact with the fabric is over: nothing in its way can still take work of note from it.
    Exited = 2,
    /// No contact, and none to come: the body leaves the sheet's box for good.
    Passed = 3,
}

impl Outcome {
    /// All outcomes in the order of their numbers.
    pub const ALL: [Outcome; 4] = [Outcome::Arrested, Outcome::Detached, Outcome::Exited, Outcome::Passed];

    /// The bit of this outcome in a mask.
    pub fn bit(self) -> u32 {
        1 << self as u32
    }

    /// Name for tables.
    pub fn name(self) -> &'static str {
        match self {
            Outcome::Arrested => "arrested",
            Outcome::Detached => "detached",
            Outcome::Exited => "exited",
            Outcome::Passed => "passed",
        }
    }
}

impl core::ops::BitOr for Outcome {
    type Output = u32;

    /// The mask of both.
    fn bitor(self, other: Outcome) -> u32 {
        self.bit() | other.bit()
    }
}

impl core::ops::BitOr<Outcome> for u32 {
    type Output = u32;

    /// The mask with one more.
    fn bitor(self, other: Outcome) -> u32 {
        self | other.bit()
    }
}

/// When an outcome latched, and the work done until then.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Latch {
    /// Step count at the test.
    pub step: u64,
    /// Work of the projectile on the fabric until then, J.
    pub work: f64,
}

/// The first contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstContact {
    /// Step count at whose start the first impulse acted.
    pub step: u64,
    /// Unit direction of the velocity just before (zero if the body was at rest).
    pub direction: Vector,
    /// Kinetic energy just before, J (0 if the mass is unknown).
    pub kinetic_energy: f64,
}

/// Everything the outcome tests remember.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Watch {
    /// The first contact, if any.
    pub first: Option<FirstContact>,
    /// Position at the last checkpoint of "exited", m.
    pub checkpoint: Vector,
    /// Work at that checkpoint, J.
    pub checkpoint_work: f64,
    /// Nodal impulses counted at that checkpoint.
    pub checkpoint_impulses: u64,
    /// Latched outcomes by number.
    pub latched: [Option<Latch>; 4],
}

impl Watch {
    /// Nothing so far.
    pub const NOTHING: Watch = Watch {
        first: None,
        checkpoint: Vector::new(0.0, 0.0, 0.0),
        checkpoint_work: 0.0,
        checkpoint_impulses: 0,
        latched: [None; 4],
    };

    /// Latches an outcome once.
    pub fn latch(&mut self, outcome: Outcome, step: u64, work: f64) {
        if let Some(slot @ None) = self.latched.get_mut(outcome as usize) {
            *slot = Some(Latch { step, work });
        }
    }

    /// Whether an outcome has latched.
    pub fn has(&self, outcome: Outcome) -> bool {
        self.latched.get(outcome as usize).is_some_and(|latch| latch.is_some())
    }

    /// Notes the first contact.
    pub fn touch(&mut self, step: u64, body: &Body, kinetic_energy: f64) {
        if self.first.is_none() {
            self.first = Some(FirstContact { step, direction: direction_of(&body.velocity), kinetic_energy });
            self.checkpoint = body.position;
        }
    }

    /// The direction in which the body goes into the fabric: that of its velocity just before the first contact or, if it was at
    /// rest then, of the first velocity that a test sees. Zero as long as it has none.
    fn take_direction(&mut self, velocity: &Vector) -> Vector {
        let Some(first) = &mut self.first else { return Vector::zeros() };
        if first.direction == Vector::zeros() {
            first.direction = direction_of(velocity);
        }
        first.direction
    }

    /// Bits of all latched outcomes.
    pub fn mask(&self) -> u32 {
        Outcome::ALL.iter().zip(&self.latched).filter(|(_, latch)| latch.is_some()).map(|(o, _)| o.bit()).sum()
    }
}

/// The unit vector along a velocity; zero for none.
fn direction_of(v: &Vector) -> Vector {
    let speed = math::length([v.x, v.y, v.z]);
    if speed > 0.0 { v / speed } else { Vector::zeros() }
}

/// The body as it flies on when nothing touches it.
struct Flight {
    position: Vector,
    velocity: Vector,
    /// Of the present external load, m/s^2.
    acceleration: Vector,
    /// Half extents along the sheet's axes as it lies now, m.
    extents: [f64; 3],
    /// Distance from the centre to the farthest surface point, m.
    reach: f64,
    /// Speed of that point by turning, m/s.
    turning: f64,
}

impl Flight {
    /// Whether it leaves a box for good: along some axis it lies beyond it, moves away faster than anything in the box, and no load
    /// pulls it back. A body that turns faster than it moves away must lie beyond it in any orientation.
    fn leaves(&self, region: &Region) -> bool {
        [(self.extents, self.turning), ([self.reach; 3], 0.0)].iter().any(|(extents, turning)| {
            (0..3).any(|k| {
                let (x, v, a) = (self.position[k], self.velocity[k], self.acceleration[k]);
                let above = x - extents[k] > region.high[k] && v - turning > region.fastest[k] && a >= 0.0;
                let below = x + extents[k] < region.low[k] && v + turning < region.slowest[k] && a <= 0.0;
                above || below
            })
        })
    }

    /// Whether a point lies behind the whole body, in any orientation, and no load turns the body back to it.
    fn has_behind(&self, position: &Vector) -> bool {
        let behind = (position - self.position).dot(&self.velocity) < -self.reach * self.velocity.norm();
        behind && self.acceleration.dot(&self.velocity) >= 0.0
    }

    /// Whether a point lies before the body's centre.
    fn has_ahead(&self, position: &Vector) -> bool {
        (position - self.position).dot(&self.velocity) > 0.0
    }

    /// Whether a node that flies on straight never comes within the body's reach.
    fn misses(&self, position: &Vector, velocity: &Vector) -> bool {
        let (r, v) = (position - self.position, velocity - self.velocity);
        let (x, u) = ((*position).into(), (*velocity).into());
        // A load that drives the two further apart all the time leaves the straight flight as the nearer one.
        if r.dot(&self.acceleration) > 0.0 || v.dot(&self.acceleration) > 0.0 {
            return self.leaves(&Region { low: x, high: x, slowest: u, fastest: u });
        }
        let (distance2, reach2, approach) = (r.norm_squared(), self.reach * self.reach, -r.dot(&v));
        // The least squared distance is r^2 - (r.v)^2/v^2.
        distance2 > reach2 && (approach <= 0.0 || (distance2 - reach2) * v.norm_squared() > approach * approach)
    }
}

/// A box about nodes, m, and the range of their velocities, m/s.
struct Region {
    low: [f64; 3],
    high: [f64; 3],
    slowest: [f64; 3],
    fastest: [f64; 3],
}

impl Region {
    const EMPTY: Region = Region { low: [f64::MAX; 3], high: [f64::MIN; 3], slowest: [0.0; 3], fastest: [0.0; 3] };

    fn take(&mut self, x: &Vector) {
        for k in 0..3 {
            self.low[k] = if x[k] < self.low[k] { x[k] } else { self.low[k] };
            self.high[k] = if x[k] > self.high[k] { x[k] } else { self.high[k] };
        }
    }

    fn take_velocity(&mut self, v: &Vector) {
        for k in 0..3 {
            self.slowest[k] = if v[k] < self.slowest[k] { v[k] } else { self.slowest[k] };
            self.fastest[k] = if v[k] > self.fastest[k] { v[k] } else { self.fastest[k] };
        }
    }

    /// The box with its mirror image about the plane across axis k.
    fn mirror(&mut self, k: usize) {
        let far = if -self.low[k] > self.high[k] { -self.low[k] } else { self.high[k] };
        (self.low[k], self.high[k]) = (-far, far);
    }
}

/// What hangs together, for one look.
pub(crate) struct Pieces {
    /// Number of the piece that holds the supports.
    support: Option<usize>,
    /// Whether every node is labelled with the number of its piece.
    labelled: bool,
    /// Without labels: whether the sheet, one piece, counts as held.
    held: bool,
}

impl Pieces {
    /// Whether a piece is joined to a support.
    pub(crate) fn hold(&self, piece: usize) -> bool {
        if self.labelled { self.support == Some(piece) } else { self.held }
    }
}

/// What loose pieces do in the body's way.
struct Loose {
    /// Some may meet the body: they are flagged.
    in_the_way: bool,
    /// Those ahead are on average no faster than the body.
    are_overtaken: bool,
    /// Those behind are on average no slower.
    pursue: bool,
}

/// Nodes with their weights and the sum of a number of theirs.
struct Swarm {
    weight: f64,
    sum: f64,
}

impl Swarm {
    const NOTHING: Swarm = Swarm { weight: 0.0, sum: 0.0 };

    fn take(&mut self, weight: f64, number: f64) {
        self.weight += weight;
        self.sum += weight * number;
    }
}

impl Sim<'_> {
    /// Tests every outcome that has not latched. Called every 64 steps.
    pub(crate) fn test_outcomes(&mut self) {
        let (step, work, velocity) = (self.state.step, self.state.sums.work, self.state.body.velocity);
        if self.state.watch.first.is_none() {
            if !self.state.watch.has(Outcome::Passed) && self.has_passed() {
                self.state.watch.latch(Outcome::Passed, step, work);
            }
        } else {
            if !self.state.watch.has(Outcome::Detached) && self.contact_is_detached() {
                self.state.watch.latch(Outcome::Detached, step, work);
            }
            let direction = self.state.watch.take_direction(&velocity);
            let settled = self.pass_checkpoint();
            if direction == Vector::zeros() {
                // At rest since before the first contact: nothing has been stopped.
            } else if velocity.dot(&direction) <= 0.0 {
                self.state.watch.latch(Outcome::Arrested, step, work);
            } else if !self.state.watch.has(Outcome::Exited) && self.has_exited(settled) {
                self.state.watch.latch(Outcome::Exited, step, work);
            }
        }
        self.blocks.flags.fill(0);
    }

    /// At the end of a forward travel of R: whether the work has settled since its start. None elsewhere.
    fn pass_checkpoint(&mut self) -> Option<bool> {
        let (watch, sums, position) = (&mut self.state.watch, &self.state.sums, self.state.body.position);
        let travel = (position - watch.checkpoint).dot(&watch.first?.direction);
        if travel < self.model.solid.radius() {
            return None;
        }
        let change = sums.work - watch.checkpoint_work;
        let settled = (if change < 0.0 { -change } else { change }) <= settling(sums.work);
        watch.checkpoint = position;
        watch.checkpoint_work = sums.work;
        watch.checkpoint_impulses = sums.impulses;
        Some(settled)
    }

    /// Contact is over: the body goes on and nothing that could act on it is in its way, or only loose pieces that take no more.
    fn has_exited(&mut self, settled: Option<bool>) -> bool {
        match settled {
            Some(true) => self.way_is_clear(true),
            // Without a node at the body the end of the travel need not be awaited.
            _ => self.state.sums.contacts == 0 && self.way_is_clear(false),
        }
    }

    /// The body has missed the sheet.
    fn has_passed(&self) -> bool {
        let half = self.scene.half_size();
        let half = [half[0], half[1], 0.0];
        let flight = self.flight();
        if self.scene.drive == Drive::Prescribed {
            // Only its host knows how it goes on; that it has got past the sheet's box is a fact.
            let start = path::into_sheet(&self.model.pose, &start_motion(&self.scene)).position;
            return (0..3).any(|k| {
                let (from, x, limit) = (start[k], flight.position[k], half[k] + flight.extents[k]);
                (from < -half[k] && x > limit) || (from > half[k] && x < -limit)
            });
        }
        let mut region = Region { low: half.map(|half| -half), high: half, ..Region::EMPTY };
        let [first, end] = self.awake;
        for j in first..end {
            for i in 0..self.layout.nodes_x {
                // A sheet set in motion by the host may be faster than the body.
                region.take(&self.position(i, j));
                region.take_velocity(&self.velocity(i, j));
            }
        }
        self.complete(&mut region);
        flight.leaves(&region)
    }

    /// Velocity of a node at t_{n-1/2}, m/s.
    fn velocity(&self, i: usize, j: usize) -> Vector {
        let (_, v) = self.node(i, j);
        Vector::from(v) * self.model.unit_speed
    }

    /// Adds what mirror planes leave out of a box, and where a held sheet swings back to.
    fn complete(&self, region: &mut Region) {
        let symmetry = self.scene.symmetry;
        let swings = self.scene.attachment.kind != AttachmentKind::Free;
        for (k, mirrored) in [symmetry.mirror_x, symmetry.mirror_y, swings].into_iter().enumerate() {
            if mirrored {
                region.mirror(k);
            }
        }
    }

    fn flight(&self) -> Flight {
        let (body, solid) = (&self.state.body, &self.model.solid);
        let free = self.scene.drive == Drive::Free;
        Flight {
            position: body.position,
            velocity: body.velocity,
            acceleration: if free { self.state.force * self.model.inertia.inverse_mass } else { Vector::zeros() },
            extents: solid.half_extents(&body.orientation),
            reach: solid.reach(),
            turning: if solid.feels_torque() { body.angular_velocity.norm() * solid.reach() } else { 0.0 },
        }
    }

    /// Whether nothing of the sheet will act on the body any more if it flies on as it does. `beside_debris`: loose pieces in its
    /// way are allowed if they have next to nothing to exchange with it.
    fn way_is_clear(&mut self, beside_debris: bool) -> bool {
        let (pieces, flight) = (self.pieces(), self.flight());
        if !self.held_is_clear(&pieces, &flight) {
            return false;
        }
        let loose = self.loose_pieces(&pieces, &flight);
        if loose.pursue {
            return false;
        }
        if !loose.in_the_way && !loose.are_overtaken {
            return true;
        }
        beside_debris && self.exchange(&pieces, &flight, &loose) <= 4.0 * settling(self.state.sums.work)
    }

    /// Whether what is held lies behind the body and stays there, or the body leaves the box about it for good.
    fn held_is_clear(&self, pieces: &Pieces, flight: &Flight) -> bool {
        let (mut held, mut behind, mut none) = (Region::EMPTY, true, true);
        for (i, j) in self.nodes() {
            if !pieces.hold(self.piece(pieces, i, j)) {
                continue;
            }
            let (x, v) = (self.position(i, j), self.velocity(i, j));
            none = false;
            held.take(&x);
            if self.scene.attachment.kind == AttachmentKind::Free {
                held.take_velocity(&v);
            }
            behind = behind && !flight.has_ahead(&x) && flight.misses(&x, &v);
        }
        self.complete(&mut held);
        none || behind || flight.leaves(&held)
    }

    /// Looks for loose pieces in the body's way and flags them.
    fn loose_pieces(&mut self, pieces: &Pieces, flight: &Flight) -> Loose {
        self.blocks.flags.fill(0);
        let (mut ahead, mut behind, mut in_the_way) = (Swarm::NOTHING, Swarm::NOTHING, false);
        for (i, j) in self.nodes() {
            let piece = self.piece(pieces, i, j);
            if pieces.hold(piece) {
                continue;
            }
            let (x, v) = (self.position(i, j), self.velocity(i, j));
            let (node_ahead, node_behind) = (flight.has_ahead(&x), flight.has_behind(&x));
            let piece_ahead = self.lies_ahead(piece, flight);
            let weight = self.layout.node_weight(i, j);
            if piece_ahead && !self.is_alone(i, j) {
                ahead.take(weight, v.dot(&flight.velocity));
            }
            if node_behind {
                behind.take(weight, v.dot(&flight.velocity));
            }
            if node_ahead != piece_ahead || !(node_behind || flight.misses(&x, &v)) {
                in_the_way = true;
                if let Some(flags) = self.blocks.flags.get_mut(piece / 32) {
                    *flags |= 1 << (piece % 32);
                }
            }
        }
        let own = flight.velocity.norm_squared();
        Loose {
            in_the_way,
            are_overtaken: ahead.weight > 0.0 && ahead.sum <= ahead.weight * own,
            pursue: behind.weight > 0.0 && behind.sum >= behind.weight * own,
        }
    }

    /// What the loose pieces in the way can still change the work by, J: V sqrt(2 m E) with their mass m and their kinetic
    /// energy E seen from the body.
    fn exchange(&self, pieces: &Pieces, flight: &Flight, loose: &Loose) -> f64 {
        let (mut mass, mut energy) = (0.0, 0.0);
        for (i, j) in self.nodes() {
            let piece = self.piece(pieces, i, j);
            let flagged = self.blocks.flags.get(piece / 32).is_some_and(|flags| flags >> (piece % 32) & 1 == 1);
            let overtaken =
                || loose.are_overtaken && self.lies_ahead(piece, flight) && !pieces.hold(piece) && !self.is_alone(i, j);
            if flagged || overtaken() {
                let node_mass = self.layout.node_weight(i, j) * self.model.node_mass;
                mass += node_mass;
                energy += 0.5 * node_mass * (self.velocity(i, j) - flight.velocity).norm_squared();
            }
        }
        flight.velocity.norm() * math::sqrt(2.0 * mass * energy)
    }

    /// All nodes, row by row.
    fn nodes(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let (nx, ny) = (self.layout.nodes_x, self.layout.nodes_y);
        (0..ny).flat_map(move |j| (0..nx).map(move |i| (i, j)))
    }

    /// Whether a piece, by the node with its smallest number, lies before the body's centre.
    fn lies_ahead(&self, piece: usize, flight: &Flight) -> bool {
        let nx = self.layout.nodes_x.max(1);
        flight.has_ahead(&self.position(piece % nx, piece / nx))
    }

    /// Finds what hangs together. Before the first failure all nodes are one piece; later, without labels, none is known to be
    /// loose.
    pub(crate) fn pieces(&mut self) -> Pieces {
        let labelled = self.failed_segments > 0 && self.layout.track_detachment;
        let support = if labelled { self.join_nodes() } else { None };
        let held = self.scene.attachment.kind != AttachmentKind::Free || !self.layout.track_detachment;
        Pieces { support, labelled, held }
    }

    /// The number of the piece that a node belongs to.
    pub(crate) fn piece(&self, pieces: &Pieces, i: usize, j: usize) -> usize {
        let label = self.blocks.labels.get(j * self.layout.nodes_x + i);
        label.filter(|_| pieces.labelled).map_or(0, |&label| label as usize)
    }

    /// Whether no live segment ends at a node: then it flies straight.
    fn is_alone(&self, i: usize, j: usize) -> bool {
        let before = |axis: Axis, i: Option<usize>, j: Option<usize>| match (i, j) {
            (Some(i), Some(j)) => self.is_live(axis, i, j),
            _ => false,
        };
        !(self.is_live(Axis::Horizontal, i, j)
            || before(Axis::Horizontal, i.checked_sub(1), Some(j))
            || self.is_live(Axis::Vertical, i, j)
            || before(Axis::Vertical, Some(i), j.checked_sub(1)))
    }

    /// Whether the segment that starts at node (i, j) has not failed.
    fn is_live(&self, axis: Axis, i: usize, j: usize) -> bool {
        let row = layout::row(self.blocks.hot, self.layout.chunks, j);
        layout::get(row, 6 + axis as usize, i).is_some_and(|stiffness| stiffness > 0.0)
    }

    /// true if some node was touched since the last test, some node is fixed, and no live path joins any two of them.
    fn contact_is_detached(&mut self) -> bool {
        let can_be = self.layout.track_detachment && self.scene.attachment.kind != AttachmentKind::Free;
        let watched = can_be && self.failed_segments > 0;
        if !watched || self.blocks.flags.iter().all(|&f| f == 0) || self.held_by_a_straight_yarn() {
            return false;
        }
        let Some(support) = self.join_nodes() else { return false };
        let Blocks { labels, flags, .. } = &self.blocks;
        let mut touched =
            labels.iter().enumerate().filter(|(k, _)| flags.get(k / 32).is_some_and(|f| f >> (k % 32) & 1 == 1));
        !touched.any(|(_, &label)| label as usize == support)
    }

    /// Labels every node with the smallest number of a node that live segments join it to. All fixed nodes count as joined.
    /// Gives the label of the fixed nodes, if there are any.
    fn join_nodes(&mut self) -> Option<usize> {
        let (nx, ny, chunks) = (self.layout.nodes_x, self.layout.nodes_y, self.layout.chunks);
        let Blocks { hot, labels, runs, .. } = &mut self.blocks;
        let mut sets = Components::new(labels);
        for j in 0..ny {
            let row = layout::row(hot, chunks, j);
            let live = |axis: usize, i: usize| layout::get(row, 6 + axis, i).is_some_and(|stiffness| stiffness > 0.0);
            for i in 0..nx {
                let k = j * nx + i;
                if i + 1 < nx && live(0, i) {
                    sets.join(k, k + 1);
                }
                if j + 1 < ny && live(1, i) {
                    sets.join(k, k + nx);
                }
            }
        }
        // All fixed nodes into one component.
        let mut support = None;
        for (j, run) in runs.iter().enumerate() {
            for i in (run[0]..run[1]).chain(run[2]..run[3]) {
                let k = j * nx + i as usize;
                match support {
                    None => support = Some(k),
                    Some(first) => sets.join(first, k),
                }
            }
        }
        sets.flatten();
        support.map(|k| sets.find(k))
    }

    /// true if live segments run straight from a touched node to a fixed one: the usual case, found without joining nodes.
    fn held_by_a_straight_yarn(&self) -> bool {
        let (nx, ny) = (self.layout.nodes_x, self.layout.nodes_y);
        let live = |axis: Axis, i: usize, j: usize| self.is_live(axis, i, j);
        let fixed = |i: usize, j: usize| self.is_fixed(i, j);
        let held = |i: usize, j: usize| {
            // Left, right, down and up, as far as the yarn is whole.
            (0..i).rev().map_while(|i| live(Axis::Horizontal, i, j).then_some((i, j))).any(|(i, j)| fixed(i, j))
                || (i + 1..nx)
                    .map_while(|i| live(Axis::Horizontal, i - 1, j).then_some((i, j)))
                    .any(|(i, j)| fixed(i, j))
                || (0..j).rev().map_while(|j| live(Axis::Vertical, i, j).then_some((i, j))).any(|(i, j)| fixed(i, j))
                || (j + 1..ny).map_while(|j| live(Axis::Vertical, i, j - 1).then_some((i, j))).any(|(i, j)| fixed(i, j))
        };
        let words = self.blocks.flags.iter().enumerate().filter(|(_, word)| **word != 0);
        // At least 1, so that no division by zero has to be compiled in.
        let nx = nx.max(1);
        words
            .flat_map(|(w, &word)| (0..32).filter(move |bit| word >> bit & 1 == 1).map(move |bit| 32 * w + bit))
            .any(|k| held(k % nx, k / nx))
    }
}

/// By how much the work may still change when it counts as final, J.
fn settling(work: f64) -> f64 {
    let part = SETTLED_PART * if work < 0.0 { -work } else { work };
    if part > SETTLED_WORK { part } else { SETTLED_WORK }
}

/// Disjoint sets over the nodes, in caller's memory.
pub struct Components<'a> {
    labels: &'a mut [u32],
}

impl<'a> Components<'a> {
    /// Every node by itself.
    pub fn new(labels: &'a mut [u32]) -> Components<'a> {
        for (k, label) in labels.iter_mut().enumerate() {
            *label = k as u32;
        }
        Components { labels }
    }

    /// The representative of a node's component.
    pub fn find(&mut self, node: usize) -> usize {
        let mut k = node;
        loop {
            let Some(&parent) = self.labels.get(k) else { return node };
            if parent as usize == k {
                return k;
            }
            let grandparent = self.labels.get(parent as usize).copied().unwrap_or(parent);
            if let Some(label) = self.labels.get_mut(k) {
                *label = grandparent;
            }
            k = grandparent as usize;
        }
    }

    /// Gives every node the number of its component's representative.
    pub fn flatten(&mut self) {
        // A representative has the smallest number of its component, so those before are done.
        for k in 0..self.labels.len() {
            let root = self.find(k) as u32;
            if let Some(label) = self.labels.get_mut(k) {
                *label = root;
            }
        }
    }

    /// Joins two nodes' components.
    pub fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.find(a), self.find(b));
        let (small, large) = if a < b { (a, b) } else { (b, a) };
        if let Some(label) = self.labels.get_mut(large) {
            *label = small as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_join() {
        let mut labels = [0; 6];
        let mut sets = Components::new(&mut labels);
        sets.join(4, 5);
        sets.join(1, 4);
        assert_eq!(sets.find(5), sets.find(1));
        assert_ne!(sets.find(0), sets.find(1));
        assert_eq!(sets.find(3), 3);
    }
}
