//! Separate plies that push on each other: unilateral impulses between facing nodes, restitution zero,
//! without friction between them.
//!
//! Method: node (i, j) of a ply faces node (i, j) of the next one, and impulses along the sheet's normal z
//! keep their order. The nodes of one place in all plies are a column. Of a curved sheet each column has axes
//! of its own, of which z is the normal at rest. Masses are those of the fabrics, over that of a node of the
//! front one. Their velocities after contact follow from an exact regression (`column.rs`). So momentum is
//! kept, no energy is ever added (no relative motion at all would be allowed, too), and the order of nodes
//! does not matter. With the projectile: at given rates of the body a candidate is a spring of one-sided
//! force on its node, by the compliance of the node along the sheet and of the body. So a column is solved
//! for its nodes and candidates at once, and the columns follow each other as the nodes of a single sheet do
//! (`solve.rs`). Candidates out of reach are left out; if more comes of the impulses than that allows, all
//! are solved again. With friction columns of several candidates are solved by `column_friction.rs`, and
//! impulses that would add energy are all scaled back.
//! Limits: nodes face nodes along z, and the moment of an impulse between nodes that are displaced along the
//! sheet is not kept. A pair more than a spacing apart along the sheet does not touch. All plies of a column
//! are free or all are fixed. Velocity Verlet, no mirror planes.
//! Reference: as in `column.rs` and `solve.rs`.

use crate::body::pose::Vector;
use crate::body::projectile::{Inertia, Twist};
use crate::contact::candidate::Solved;
use crate::contact::column::{load, project, restart};
use crate::contact::laws::{self, Gain};
use crate::contact::members;
use crate::contact::solve::{MAX_SWEEPS, USED_REACH};
use crate::ground::math;
use crate::ground::planes::{self, CHUNK};
use crate::memory::arrays::Arrays;
use crate::memory::records::{Candidate, Relaxation, Tangential, Touch};
use crate::memory::system::System;
use crate::scene::features::Feature;
use crate::scene::parts::Symmetry;
use core::ops::Range;

/// Least compliance of a candidate in addition to its column's, over that of a node, without and with
/// friction: candidates of one column that point along z share their impulse by it. The larger it is, the
/// longer small gap rates last; the smaller, the fewer columns with friction converge.
const EVEN: [f64; 2] = [1e-9, 1e-6];
/// Tolerance of gap rates and slips, in parts of the fastest before contact and of the speeds that they are
/// differences of.
const TOLERANCE: [f64; 2] = [1e-12, 4e-15];
/// A gap rate that does not count if no velocity changes any more, spacings a step.
const HARMLESS: f64 = 1e-9;
/// Sweeps before friction that goes back and forth is under-relaxed.
const PATIENCE: u32 = 4;
/// Growth of the relaxation factor in a sweep in which friction goes on.
const GROWTH: f64 = 1.1;
/// A candidate whose gap grows by more than so many times the fastest approach, of a candidate or of two
/// nodes of a column, is left out, unless more comes of it.
const FAR_APART: f64 = 2.0;
/// Sweeps after which a solve is given up in which fixed nodes take an impulse. They have no compliance, and
/// neighbours under a wide body leave nearly all of an error in a sweep.
const MAX_SWEEPS_ON_SUPPORTS: u32 = 4000;
/// Impulses found after which it is given up earlier.
const UPDATES_ON_SUPPORTS: usize = 16_000_000;

/// The impulses of the first `count` candidates of a stack: [`crate::contact::solve::solve_first`] together
/// with the columns.
pub(crate) fn solve(system: &mut System<'_>, count: usize) -> Solved {
    let mut stack = StackSolve::at(system);
    let reach = stack.begin(count);
    stack.include(count, reach);
    let mut converged = stack.iterate(count);
    if stack.moved() > USED_REACH * reach {
        // Once more from the start, with all of them.
        stack.begin(count);
        stack.include(count, f64::INFINITY);
        converged = stack.iterate(count);
    }
    // Largest residual of the laws of contact and friction, m/s.
    let residual = |stack: &StackSolve| (0..count).map(|c| stack.error(c, f64::INFINITY)).fold(0.0, math::max);
    let residual = if converged { 0.0 } else { residual(&stack) };
    let solved = Solved { sweeps: stack.sweeps, converged, twist: stack.body, residual };
    if converged || !system.layout.has(Feature::Friction) { solved } else { without_gain(system, count, solved) }
}

/// Gauss-Seidel over the columns with candidates. Each is solved for all its nodes and candidates at once,
/// with a body of a little more compliance to several of them than it has, so that they never go too far.
pub(super) struct StackSolve<'s, 'a> {
    pub(super) system: &'s mut System<'a>,
    pub(super) inertia: Inertia,
    /// 1/m of a node of the front fabric, 1/kg.
    inverse_node_mass: f64,
    /// A gap rate or a slip that does not count, m/s.
    pub(super) tolerance: f64,
    /// Masses of the nodes of a column.
    mass: f64,
    /// Longest arm of a candidate, m.
    arm: f64,
    /// The most by which a node without an included candidate is moved along z, m/s.
    pub(super) widest: f64,
    /// Whether a fixed node has taken an impulse.
    supported: bool,
    /// Sweeps done.
    pub(super) sweeps: u32,
    /// Compliance that Newton's method adds to the body's, over that of a node (`column_friction.rs`).
    pub(super) damping: f64,
    /// Velocity of the body under the impulses so far.
    pub(super) body: Twist,
}

impl<'s, 'a> StackSolve<'s, 'a> {
    /// With the rates of the body before contact.
    fn at(system: &'s mut System<'a>) -> StackSolve<'s, 'a> {
        let scene = &system.scene;
        StackSolve {
            inertia: system.model.inertia,
            inverse_node_mass: 1.0 / system.model.node_mass,
            tolerance: 0.0,
            mass: f64::from(scene.front_plies()) + f64::from(scene.back.plies) * system.model.back_share,
            arm: 0.0,
            widest: 0.0,
            supported: false,
            sweeps: 0,
            damping: 0.0,
            body: system.state.body.twist(),
            system,
        }
    }

    /// Begins before any impulse. Returns the growth of a gap beyond which no impulse is to be expected, m/s.
    fn begin(&mut self, count: usize) -> f64 {
        (self.body, self.supported, self.sweeps) = (self.system.state.body.twist(), false, 0);
        members::sort(self.system, count);
        let (mut fastest, mut farthest, mut closing) = (0.0, 0.0, 0.0);
        for c in 0..count {
            let [speed, arm, rate] = self.start(c);
            (fastest, farthest) = (math::max(speed, fastest), math::max(arm, farthest));
            closing = math::max(-rate, closing);
        }
        // The speeds that a gap rate is the difference of.
        (self.arm, self.widest) = (math::sqrt(farthest), 0.0);
        let [relative, rounding] = TOLERANCE;
        self.tolerance = math::max(relative * fastest, rounding * self.body.fastest(self.arm));
        for c in 0..count {
            if !self.column(c).is_empty() && !self.candidate(c).is_fixed() {
                self.widest = math::max(self.spread(c), self.widest);
            }
        }
        FAR_APART * (closing + self.widest)
    }

    /// Begins with a candidate without impulse. Returns its gap rate or slip, whichever is faster, m/s, the
    /// square of its longest arm, m^2, and its gap rate, m/s.
    fn start(&mut self, c: usize) -> [f64; 3] {
        self.set_impulse(c, 0.0);
        let candidate = self.candidate(c);
        self.set_touch(c, Touch { normal: self.own_axes(c, candidate.normal).into(), ..Touch::default() });
        let rate = candidate.gap_rate(&self.body);
        let (mut fastest, mut farthest) = (math::abs(rate), candidate.arm.dot(&candidate.arm));
        if let Some(t) = self.tangential(c) {
            for (slip, arm) in t.slip(&self.body).into_iter().zip(t.arms) {
                fastest = math::max(math::abs(slip), fastest);
                farthest = math::max(arm.dot(&arm), farthest);
            }
            self.set_tangential(c, &Tangential { impulse: [0.0; 2], ..t });
            if let Some(relaxation) = self.system.arrays.relaxations.get_mut(c) {
                *relaxation = Relaxation { factor: 1.0, increment: [0.0; 2] };
            }
        }
        [fastest, farthest, rate]
    }

    /// Range of the velocities along z in the column of a candidate, m/s: no node of it is moved by more
    /// before the body pushes one.
    fn spread(&self, c: usize) -> f64 {
        let (i, row) = place(self.system, c);
        let (mut low, mut high) = (f64::INFINITY, -f64::INFINITY);
        let [at, next] = self.system.layout.stacked(i, row);
        for ply in 0..self.system.layout.plies {
            let chunk = self.system.arrays.rows.hot.get(at + ply * next);
            let velocity = chunk.map_or([0.0; 3], |chunk| planes::velocity(chunk, i % CHUNK));
            let [_, _, speed] = self.system.own_axes(i, velocity);
            (low, high) = (math::min(speed, low), math::max(speed, high));
        }
        (high - low) * self.system.model.unit_speed
    }

    /// Includes the candidates whose gaps grow by no more than `reach`, m/s. The others are left out of their
    /// columns, so that no sweep comes to them; but the one that leads a column leads it as before.
    fn include(&mut self, count: usize, reach: f64) {
        let (mut start, mut kept) = (0, 0);
        for leader in 0..count {
            let all = start..self.column(leader).end;
            start = all.end;
            let (members, first, mut near) = (all.len() as f64, kept, false);
            for k in all {
                let c = self.member(k);
                let is_near = self.candidate(c).gap_rate(&self.body) <= reach;
                near |= is_near;
                if (is_near || c == leader)
                    && let Some(member) = self.system.arrays.members.get_mut(kept)
                {
                    *member = c as u32;
                    kept += 1;
                }
            }
            kept = if near { kept } else { first };
            if let Some(end) = self.system.arrays.ends.get_mut(leader) {
                *end = kept as u32;
            }
            for k in first..kept {
                self.weigh(self.member(k), leader, members);
            }
        }
    }

    /// Sets the compliances of a candidate, one of so many of a column.
    fn weigh(&mut self, c: usize, leader: usize, members: f64) {
        let inverse_mass = self.inverse_node_mass / self.share(c);
        let compliance = self.added_compliance(c, inverse_mass, leader, members);
        let mut friction = self.tangential(c);
        if let Some(t) = &mut friction {
            let own = if self.candidate(leader).is_fixed() { 0.0 } else { inverse_mass };
            t.begin(&self.inertia, own, Symmetry::default(), 1.0);
            self.set_tangential(c, t);
        }
        let of_body = friction.map_or(0.0, |t| 1.0 / t.effective_mass - inverse_mass);
        let compliance_across = math::max(members * of_body, EVEN[1] * inverse_mass);
        self.set_touch(c, Touch { compliance, inverse_mass, stale: 1.0, compliance_across, ..self.touch(c) });
    }

    /// Sweeps until nothing changes any more, or too often. Returns whether nothing does.
    fn iterate(&mut self, count: usize) -> bool {
        let (mut most, mut converged) = (MAX_SWEEPS, false);
        let rough = self.system.layout.has(Feature::Friction);
        while self.sweeps < most && !converged {
            converged = true;
            let mut start = 0;
            for c in 0..count {
                let end = self.column(c).end;
                if end > start {
                    // A fixed node is alone, too.
                    let has_friction = rough && end > start + 1;
                    converged &= if has_friction { self.visit_with_friction(c) } else { self.visit(c) };
                }
                start = end;
            }
            self.sweeps += 1;
            if self.supported {
                most = MAX_SWEEPS.max(MAX_SWEEPS_ON_SUPPORTS.min((UPDATES_ON_SUPPORTS / count.max(1)) as u32));
            }
        }
        converged
    }

    /// At the most by how much the gap rate of a candidate that was left out has changed, m/s.
    fn moved(&self) -> f64 {
        let (before, after) = (self.system.state.body, self.body);
        let velocity = after.velocity - before.velocity;
        let change = Twist { velocity, angular_velocity: after.angular_velocity - before.angular_velocity };
        change.fastest(self.arm) + self.widest
    }

    /// Mass of a candidate's node over that of one of the front fabric.
    fn share(&self, c: usize) -> f64 {
        self.system.mass_share(self.ply(c))
    }

    /// Compliance of one of so many candidates of a column in addition to its z motion, 1/kg: its node along
    /// the sheet, and the body.
    ///
    /// A step of a column never goes too far if the body has n times its compliance to each of n candidates.
    /// That is exact for one; several with the same normal would pass the impulse on between them for long.
    /// But a body that outweighs the column needs no more compliance to what they share: that of the column's
    /// own nodes is larger, two times over.
    fn added_compliance(&self, c: usize, own: f64, leader: usize, members: f64) -> f64 {
        let (candidate, first) = (&self.candidate(c), &self.candidate(leader));
        let ([x, y, z], [_, _, up]) = (self.touch(c).normal, self.touch(leader).normal);
        let (of_body, of_first) = (self.body_compliance(candidate, candidate), self.body_compliance(first, first));
        let along = own * (x * x + y * y);
        let even = own * EVEN[usize::from(self.system.layout.has(Feature::Friction))];
        if candidate.is_fixed() {
            return of_body;
        }
        let outweighs = 2.0 * of_first * self.mass <= 0.5 * self.inverse_node_mass * (up * up);
        if members == 1.0 || !outweighs {
            return math::max(along + members * of_body, even);
        }
        let share = z / up;
        let rest = of_body - 2.0 * share * self.body_compliance(first, candidate) + share * share * of_first;
        along + 2.0 * members * math::max(rest, 0.0) + even
    }

    /// Compliance of the body at one candidate to an impulse on another, 1/kg.
    fn body_compliance(&self, one: &Candidate, other: &Candidate) -> f64 {
        let turning = one.arm.dot(&other.arm.component_mul(&self.inertia.inverse_moments));
        one.normal.dot(&other.normal) * self.inertia.inverse_mass + turning
    }

    /// A vector in the axes of a candidate's column.
    pub(super) fn own_axes(&self, c: usize, v: Vector) -> Vector {
        if !self.system.layout.has(Feature::Curved) {
            return v;
        }
        Vector::from(self.system.own_axes(place(self.system, c).0, v.into()))
    }

    pub(super) fn candidate(&self, c: usize) -> Candidate {
        self.system.arrays.candidates.get(c).copied().unwrap_or_default()
    }

    pub(super) fn tangential(&self, c: usize) -> Option<Tangential> {
        self.system.arrays.tangential.get(c).copied()
    }

    pub(super) fn set_tangential(&mut self, c: usize, t: &Tangential) {
        if let Some(place) = self.system.arrays.tangential.get_mut(c) {
            *place = *t;
        }
    }

    pub(super) fn set_impulse(&mut self, c: usize, impulse: f64) {
        if let Some(slot) = self.system.arrays.candidates.get_mut(c) {
            slot.impulse = impulse;
        }
    }

    /// Column that a candidate leads, as a range of places of [`StackSolve::member`]; empty if it leads none.
    pub(super) fn column(&self, leader: usize) -> Range<usize> {
        members::column(self.system.arrays.ends, leader)
    }

    /// Candidate at a place in the order of columns.
    pub(super) fn member(&self, k: usize) -> usize {
        self.system.arrays.members.get(k).map_or(0, |&c| c as usize)
    }

    /// Ply of a candidate's node.
    pub(super) fn ply(&self, c: usize) -> usize {
        let Arrays { candidates, leaders, .. } = &self.system.arrays;
        // At least 1, so that no division by zero has to be compiled in.
        candidates.get(c).map_or(0, |candidate| candidate.node / (leaders.len() as u32).max(1)) as usize
    }

    pub(super) fn touch(&self, c: usize) -> Touch {
        self.system.arrays.touches.get(c).copied().unwrap_or_default()
    }

    pub(super) fn set_touch(&mut self, c: usize, touch: Touch) {
        if let Some(slot) = self.system.arrays.touches.get_mut(c) {
            *slot = touch;
        }
    }

    /// Friction of a candidate in the axes of its column, N s.
    fn friction(&self, c: usize) -> Vector {
        self.tangential(c).map_or(Vector::zeros(), |t| self.own_axes(c, t.as_vector(t.impulse)))
    }

    /// Velocity along the sheet that friction and this normal impulse give a candidate's node, m/s.
    fn along(&self, c: usize, impulse: f64) -> [f64; 2] {
        let touch = self.touch(c);
        if self.candidate(c).is_fixed() {
            return [0.0; 2];
        }
        let push = Vector::from(touch.normal) * impulse + self.friction(c);
        [push.x * touch.inverse_mass, push.y * touch.inverse_mass]
    }

    /// Growth of a candidate's gap but for the motion of its node along z, m/s.
    fn partial_gap_rate(&self, c: usize) -> f64 {
        let (candidate, [along, across, _]) = (self.candidate(c), self.touch(c).normal);
        let [x, y] = self.along(c, candidate.impulse);
        candidate.gap_rate(&self.body) + (along * x + across * y)
    }

    /// Next impulses along the surface of a candidate with friction.
    fn next_friction(&self, c: usize, t: &Tangential) -> [f64; 2] {
        let (impulse, change_z) = (self.candidate(c).impulse, self.touch(c).velocity_change_z);
        let [x, y] = self.along(c, impulse);
        let moved = t.tangents.map(|tangent| self.own_axes(c, tangent).dot(&Vector::new(x, y, change_z)));
        let [p, q] = t.slip(&self.body);
        t.next([p + moved[0], q + moved[1]], self.system.scene.contact.friction * impulse)
    }

    /// Changes the velocity of the body by a change of a candidate's normal impulse.
    fn press(&self, body: &mut Twist, candidate: &Candidate, change: f64) {
        body.velocity -= candidate.normal * (change * self.inertia.inverse_mass);
        body.angular_velocity -= candidate.arm.component_mul(&self.inertia.inverse_moments) * change;
    }

    /// Solves the column that this candidate leads. Returns whether it was solved already.
    fn visit(&mut self, c: usize) -> bool {
        let (unit_speed, friction) = (self.system.model.unit_speed, self.system.layout.has(Feature::Friction));
        let unsettled = if friction { f64::INFINITY } else { math::max(HARMLESS * unit_speed, self.tolerance) };
        let error = self.error(c, unsettled);
        if self.touch(c).stale == 0.0 && error <= self.tolerance {
            return true;
        }
        let lifted = if self.candidate(c).is_fixed() { self.push_fixed(c) } else { self.solve_column(c) };
        if error > unsettled {
            // Whatever has moved.
            self.set_touch(c, Touch { stale: 0.0, ..self.touch(c) });
            return false;
        }
        let moved = self.solve_friction(c);
        // What candidates of one column pass on between them moves nothing.
        error <= HARMLESS * unit_speed && math::max(lifted, moved) <= self.tolerance
    }

    /// Residual of the laws of contact and friction over the candidates of a column, m/s. Candidates after
    /// one of more than `enough` are not looked at.
    fn error(&self, leader: usize, enough: f64) -> f64 {
        let mut error = 0.0;
        for c in self.column(leader).map(|k| self.member(k)) {
            let touch = self.touch(c);
            let rate = self.partial_gap_rate(c) + touch.normal[2] * touch.velocity_change_z;
            error = math::max(laws::violation(self.candidate(c).impulse, rate), error);
            if error > enough {
                break;
            }
            if let Some(t) = self.tangential(c) {
                let next = self.next_friction(c, &t);
                error = math::max(laws::slip_violation(t.impulse, next, t.effective_mass), error);
            }
        }
        error
    }

    /// The impulse on a fixed node. Returns how much it changes of the gap rate, m/s.
    fn push_fixed(&mut self, c: usize) -> f64 {
        let (candidate, compliance) = (self.candidate(c), self.touch(c).compliance);
        if compliance == 0.0 {
            // A prescribed body: neither has a compliance.
            return 0.0;
        }
        let trial = candidate.impulse - candidate.gap_rate(&self.body) / compliance;
        let impulse = math::max(trial, 0.0);
        self.supported |= impulse > 0.0;
        let change = impulse - candidate.impulse;
        let mut body = self.body;
        self.press(&mut body, &candidate, change);
        self.body = body;
        self.set_impulse(c, impulse);
        compliance * math::abs(change)
    }

    /// The nodes of a column and its candidates' normal impulses. Returns the largest change of the
    /// candidates' velocities along z, m/s.
    pub(super) fn solve_column(&mut self, leader: usize) -> f64 {
        let (unit_speed, unit_impulse) = (self.system.model.unit_speed, self.system.model.unit_impulse);
        self.load_column(leader);
        let has_friction = self.system.layout.has(Feature::Friction);
        for k in self.column(leader) {
            let c = self.member(k);
            let (candidate, touch, friction) = (self.candidate(c), self.touch(c), self.friction(c).z);
            let (rate, up, ply) = (self.partial_gap_rate(c), touch.normal[2], self.ply(c));
            let Some(node) = self.system.arrays.column.get_mut(ply) else { break };
            node.stiffness = up * math::abs(up) * self.inverse_node_mass / touch.compliance;
            if up != 0.0 {
                node.release = node.before + (touch.compliance * candidate.impulse - rate) / (up * unit_speed);
            }
            if has_friction {
                node.speed += friction / (unit_impulse * node.mass);
            }
        }
        project(self.system.arrays.column, self.system.arrays.pools);
        for node in self.system.arrays.column.iter().filter(|node| node.stiffness == 0.0) {
            self.widest = math::max(math::abs(node.speed - node.before) * unit_speed, self.widest);
        }
        // All answer to the body as it is now.
        let (mut body, mut moved) = (self.body, 0.0);
        for k in self.column(leader) {
            let c = self.member(k);
            let (candidate, mut touch) = (self.candidate(c), self.touch(c));
            let Some(node) = self.system.arrays.column.get(self.ply(c)) else { break };
            let (up, change_z) = (touch.normal[2], (node.speed - node.before) * unit_speed);
            let impulse = if math::abs(node.stiffness) > node.mass {
                node.push * unit_impulse / up
            } else {
                let rate = self.partial_gap_rate(c) + up * change_z;
                candidate.impulse - rate / touch.compliance
            };
            let impulse = math::max(impulse, 0.0);
            moved = math::max(math::abs(change_z - touch.velocity_change_z), moved);
            (touch.velocity_change_z, touch.impulse_before) = (change_z, candidate.impulse);
            self.set_touch(c, touch);
            let change = impulse - candidate.impulse;
            if change != 0.0 {
                self.press(&mut body, &candidate, change);
                self.set_impulse(c, impulse);
            }
        }
        self.body = body;
        moved
    }

    /// Puts the nodes of a column into the scratch block.
    pub(super) fn load_column(&mut self, leader: usize) {
        let (i, row) = place(self.system, leader);
        load(self.system, i, row);
    }

    /// The nodes of a loaded column under its candidates' impulses.
    pub(super) fn push_column(&mut self, leader: usize) {
        restart(self.system.arrays.column);
        for k in self.column(leader) {
            let c = self.member(k);
            let (push, ply) = (self.touch(c).normal[2] * self.candidate(c).impulse + self.friction(c).z, self.ply(c));
            if let Some(node) = self.system.arrays.column.get_mut(ply) {
                node.push = push / self.system.model.unit_impulse;
                node.speed += node.push / node.mass;
            }
        }
        project(self.system.arrays.column, self.system.arrays.pools);
    }

    /// Work between the plies of a column under the candidates' impulses: impulses times relative velocities
    /// before, with those at which gaps would close. And the square of what all impulses change of the
    /// velocities along z. In units of m (h/dt)^2.
    fn of_plies(&mut self, leader: usize) -> [f64; 2] {
        self.load_column(leader);
        self.push_column(leader);
        let (mut work, mut moved, mut from_below) = (0.0, 0.0, 0.0);
        for node in self.system.arrays.column.iter() {
            let change = node.speed - node.before;
            if node.gap != f64::INFINITY {
                work += from_below * node.gap;
            }
            let momentum = node.mass * change;
            work += node.before * (momentum - node.push);
            moved += momentum * change;
            from_below -= momentum - node.push;
        }
        [work, moved]
    }

    /// The next impulses along the surface of a candidate, from these towards those that Coulomb's law asks
    /// for.
    ///
    /// A column that slides may go back and forth for ever: what friction pushes the node along the sheet,
    /// the normal impulse lets go of several times over where the surface is nearly flat, and it limits
    /// friction. So after some sweeps a candidate whose way turns back goes half as far, and farther again
    /// while it does not turn. The impulses stay in the cone, and what is left to go counts in full.
    fn relaxed(&mut self, c: usize, candidate: &Candidate, [p, q]: [f64; 2], next: [f64; 2]) -> [f64; 2] {
        let increment = [next[0] - p, next[1] - q];
        let Some(relaxation) = self.system.arrays.relaxations.get_mut(c) else { return next };
        let factor = match self.sweeps {
            0..PATIENCE => relaxation.factor,
            _ if increment[0] * relaxation.increment[0] + increment[1] * relaxation.increment[1] < 0.0 => {
                0.5 * relaxation.factor
            }
            _ => math::min(GROWTH * relaxation.factor, 1.0),
        };
        *relaxation = Relaxation { factor, increment };
        if factor == 1.0 {
            return next;
        }
        let most = self.system.scene.contact.friction * candidate.impulse;
        laws::limited([p + factor * increment[0], q + factor * increment[1]], most)
    }

    /// The impulses along the surface of a column's candidates, where there is friction. Returns the largest
    /// change of the velocities along the sheet since the column was solved last, of fixed nodes of the slip,
    /// m/s.
    pub(super) fn solve_friction(&mut self, leader: usize) -> f64 {
        let (mut moved, mut stale) = (0.0, false);
        for k in self.column(leader) {
            let c = self.member(k);
            let (candidate, before) = (self.candidate(c), self.along(c, self.touch(c).impulse_before));
            if let Some(mut t) = self.tangential(c) {
                let [p, q] = t.impulse;
                let next = self.next_friction(c, &t);
                t.impulse = self.relaxed(c, &candidate, [p, q], next);
                let change = [t.impulse[0] - p, t.impulse[1] - q];
                self.body.velocity -= t.as_vector(change) * self.inertia.inverse_mass;
                self.body.angular_velocity -= t.moment(change).component_mul(&self.inertia.inverse_moments);
                self.set_tangential(c, &t);
                let size = math::max(math::abs(change[0]), math::abs(change[1]));
                stale |= size > self.tolerance * t.effective_mass;
                if candidate.is_fixed() && t.effective_mass > 0.0 {
                    moved = math::max(size / t.effective_mass, moved);
                }
            }
            let after = self.along(c, candidate.impulse);
            let change = math::max(math::abs(after[0] - before[0]), math::abs(after[1] - before[1]));
            moved = math::max(change, moved);
        }
        self.set_touch(leader, Touch { stale: f64::from(u8::from(stale)), ..self.touch(leader) });
        moved
    }
}

/// The column and the row of a candidate's node in the sheet.
fn place(system: &System<'_>, c: usize) -> (usize, usize) {
    let node = system.arrays.candidates.get(c).map_or(0, |candidate| candidate.node);
    let (i, j) = system.layout.column_and_row(node as usize);
    (i, system.layout.ply_and_row(j).1)
}

/// Impulses with friction, scaled back if they would add energy, as those of a single sheet are that were
/// given up on: a cone holds every part of what it holds. The impulses between the plies are scaled with them
/// here; those that separate the plies in the end leave no more energy than these and what they would do
/// against the gaps.
fn without_gain(system: &mut System<'_>, count: usize, solved: Solved) -> Solved {
    let mass = system.model.node_mass;
    let mut gain = Gain::of_body(system.state.body.twist(), &system.model.inertia, &solved);
    // Columns of all candidates.
    members::sort(system, count);
    let (mut stack, mut between, mut lifted) = (StackSolve::at(system), 0.0, 0.0);
    for c in 0..count {
        let (candidate, share) = (stack.candidate(c), stack.share(c));
        gain.before += gain.work_before(&candidate, stack.tangential(c).as_ref());
        let [x, y] = stack.along(c, candidate.impulse);
        gain.change += mass * share * (x * x + y * y);
        if !stack.column(c).is_empty() && !candidate.is_fixed() {
            let [work, moved] = stack.of_plies(c);
            (between, lifted) = (between + work, lifted + moved);
        }
    }
    gain.before += between * system.model.unit_energy;
    gain.change += lifted * system.model.unit_energy;
    let candidates = system.arrays.candidates.get_mut(..count).unwrap_or_default();
    gain.scale_back(candidates, system.arrays.tangential, solved)
}
