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
//! sheet is not kept. A pair more than a spacing apart along the sheet does not touch. Velocity Verlet, no
//! mirror planes.
//! Reference: as in `column.rs` and `solve.rs`.

use crate::body::pose::Vector;
use crate::body::projectile::{Body, Inertia, Twist};
use crate::contact::by_column::{ColumnContacts, SortedContacts};
use crate::contact::candidate::{Holder, Solved};
use crate::contact::column::{Column, HELD};
use crate::contact::laws::{self, Gain};
use crate::contact::solve::{MAX_SWEEPS, USED_REACH};
use crate::ground::math;
use crate::ground::planes::{self, CHUNK};
use crate::memory::arrays::Contacts;
use crate::memory::network::Network;
use crate::memory::records::{Candidate, Node, PlyContact, PlyFriction, Relaxation, Tangential};
use crate::scene::features::Feature;
use crate::scene::parts::Symmetry;

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

/// Finds the impulses of the first `count` candidates of a stack, as [`crate::contact::solve::solve`] those
/// of a single sheet, together with the columns. `body`: with its velocity before contact.
pub(crate) fn solve(network: &Network<'_>, contacts: &mut Contacts<'_>, body: &Body, count: usize) -> Solved {
    let (mut columns, column) = contacts.columns(count);
    let mut stack = StackSolve::at(network, column, body);
    let reach = stack.begin(&mut columns);
    stack.include(&mut columns, reach);
    let mut converged = stack.iterate(&mut columns);
    if stack.largest_change() > USED_REACH * reach {
        // Once more from the start, with all of them.
        stack.begin(&mut columns);
        stack.include(&mut columns, f64::INFINITY);
        converged = stack.iterate(&mut columns);
    }
    columns.give_impulses();
    let residual = if converged { 0.0 } else { stack.residual(&mut columns) };
    let solved = Solved { sweeps: stack.sweeps, converged, twist: stack.body, residual };
    if converged || !network.layout.has(Feature::Friction) { solved } else { stack.without_gain(&mut columns, solved) }
}

/// Gauss-Seidel over the columns with candidates. Each is solved for all its nodes and candidates at once,
/// with a body of a little more compliance to several of them than it has, so that they never go too far.
pub(super) struct StackSolve<'s, 'a> {
    pub(super) network: &'s Network<'a>,
    /// Column that is being solved.
    pub(super) column: Column<'s>,
    /// Velocity of the body before contact.
    before: Twist,
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
    /// Solve of a stack before its first sweep. `body`: with its velocity before contact.
    fn at(network: &'s Network<'a>, column: Column<'s>, body: &Body) -> StackSolve<'s, 'a> {
        let (scene, model) = (&network.scene, &network.model);
        StackSolve {
            network,
            column,
            before: body.twist(),
            inertia: model.inertia,
            inverse_node_mass: 1.0 / model.node_mass,
            tolerance: 0.0,
            mass: f64::from(scene.front_plies()) + f64::from(scene.back.plies) * model.back_share,
            arm: 0.0,
            widest: 0.0,
            supported: false,
            sweeps: 0,
            damping: 0.0,
            body: body.twist(),
        }
    }

    /// Sorts the candidates, without impulses. Returns the growth of a gap beyond which no impulse is to be
    /// expected, m/s.
    fn begin(&mut self, columns: &mut SortedContacts<'_>) -> f64 {
        (self.body, self.supported, self.sweeps) = (self.before, false, 0);
        columns.candidates.iter_mut().for_each(|candidate| candidate.impulse = 0.0);
        columns.tangential.iter_mut().for_each(|t| t.impulse = [0.0; 2]);
        columns.sort(self.network);
        let (mut fastest, mut farthest, mut closing, mut widest) = (0.0, 0.0, 0.0, 0.0);
        columns.for_each(|column| {
            for (contact, friction) in column.each() {
                let [speed, arm, rate] = self.sizes(contact, friction);
                (fastest, farthest) = (math::max(speed, fastest), math::max(arm, farthest));
                closing = math::max(-rate, closing);
            }
            let leader = column.leader();
            if !leader.is_fixed() {
                widest = math::max(self.spread(&leader), widest);
            }
        });
        // The speeds that a gap rate is the difference of.
        (self.arm, self.widest) = (math::sqrt(farthest), widest);
        let [relative, rounding] = TOLERANCE;
        self.tolerance = math::max(relative * fastest, rounding * self.body.fastest(self.arm));
        FAR_APART * (closing + self.widest)
    }

    /// Gap rate or slip of a contact, whichever is faster, m/s, square of its longest arm, m^2, and gap
    /// rate, m/s.
    fn sizes(&self, contact: &PlyContact, friction: Option<&PlyFriction>) -> [f64; 3] {
        let rate = contact.gap_rate(&self.body);
        let (mut fastest, mut farthest) = (math::abs(rate), contact.arm.dot(&contact.arm));
        if let Some(PlyFriction { tangential: t, .. }) = friction {
            for (slip, arm) in t.slip(&self.body).into_iter().zip(t.arms) {
                fastest = math::max(math::abs(slip), fastest);
                farthest = math::max(arm.dot(&arm), farthest);
            }
        }
        [fastest, farthest, rate]
    }

    /// Range of the velocities along z in the column of a contact, m/s: no node of it is moved by more
    /// before the body pushes one.
    fn spread(&self, contact: &PlyContact) -> f64 {
        let (network, [i, row]) = (self.network, contact.place());
        let (mut low, mut high) = (f64::INFINITY, -f64::INFINITY);
        let [at, next] = network.layout.stacked(i, row);
        for ply in 0..network.layout.plies {
            let chunk = network.arrays.rows.hot.get(at + ply * next);
            let velocity = chunk.map_or([0.0; 3], |chunk| planes::velocity(chunk, i % CHUNK));
            let [_, _, speed] = network.column_axes(i, velocity);
            (low, high) = (math::min(speed, low), math::max(speed, high));
        }
        (high - low) * network.model.unit_speed
    }

    /// Includes the candidates whose gaps grow by no more than `reach`, m/s. The others are left out of their
    /// columns.
    fn include(&self, columns: &mut SortedContacts<'_>, reach: f64) {
        let is_near = |contact: &PlyContact| contact.gap_rate(&self.body) <= reach;
        columns.retain(is_near, |mut column, all| {
            let leader = column.leader();
            column.each_mut().for_each(|(contact, friction)| self.weigh(contact, friction, &leader, all as f64));
        });
    }

    /// Sets the compliances of a contact, one of so many of a column.
    fn weigh(&self, contact: &mut PlyContact, friction: Option<&mut PlyFriction>, leader: &PlyContact, members: f64) {
        let inverse_mass = self.inverse_node_mass / self.network.mass_share(contact.ply as usize);
        contact.compliance = self.added_compliance(contact, inverse_mass, leader, members);
        let of_body = friction.map_or(0.0, |PlyFriction { tangential: t, .. }| {
            let own = if leader.is_fixed() { 0.0 } else { inverse_mass };
            t.begin(&self.inertia, own, Symmetry::default(), self.multiplicity(contact));
            1.0 / t.effective_mass - inverse_mass
        });
        (contact.inverse_mass, contact.stale) = (inverse_mass, 1);
        contact.compliance_across = math::max(members * of_body, EVEN[1] * inverse_mass);
    }

    /// Sweeps until nothing changes any more, or too often. Returns whether nothing does.
    fn iterate(&mut self, columns: &mut SortedContacts<'_>) -> bool {
        let (mut most, mut converged) = (MAX_SWEEPS, false);
        let friction = self.network.layout.has(Feature::Friction);
        while self.sweeps < most && !converged {
            converged = true;
            columns.for_each(|mut column| {
                // A fixed node is alone, too.
                let several = friction && column.contacts.len() > 1;
                converged &= if several { self.visit_with_friction(&mut column) } else { self.visit(&mut column) };
            });
            self.sweeps += 1;
            if self.supported {
                let of_all = (UPDATES_ON_SUPPORTS / columns.count().max(1)) as u32;
                most = MAX_SWEEPS.max(MAX_SWEEPS_ON_SUPPORTS.min(of_all));
            }
        }
        converged
    }

    /// Bound of the change of the gap rate of a candidate that was left out, m/s.
    fn largest_change(&self) -> f64 {
        let (before, after) = (self.before, self.body);
        let velocity = after.velocity - before.velocity;
        let change = Twist { velocity, angular_velocity: after.angular_velocity - before.angular_velocity };
        change.fastest(self.arm) + self.widest
    }

    /// Compliance of one of so many candidates of a column in addition to its z motion, 1/kg: its node along
    /// the sheet, and the body.
    ///
    /// n candidates share the body, so W <= n diag(W): with n W_kk a column cannot overshoot. That is exact
    /// for one; several with the same normal would pass the impulse on between them for long. But a body that
    /// outweighs the column needs no more compliance to what they share: that of the column's own nodes is
    /// larger, two times over.
    fn added_compliance(&self, contact: &PlyContact, own: f64, leader: &PlyContact, members: f64) -> f64 {
        let ([x, y, z], [_, _, up]) = (contact.own_normal, leader.own_normal);
        let (of_body, of_first) = (self.body_compliance(contact, contact), self.body_compliance(leader, leader));
        let along = own * (x * x + y * y);
        let even = own * EVEN[usize::from(self.network.layout.has(Feature::Friction))];
        if contact.is_fixed() {
            return of_body;
        }
        let outweighs =
            !self.is_held_in_part(leader) && 2.0 * of_first * self.mass <= 0.5 * self.inverse_node_mass * (up * up);
        if members == 1.0 || !outweighs {
            return math::max(along + members * of_body, even);
        }
        let share = z / up;
        let rest = of_body - 2.0 * share * self.body_compliance(leader, contact) + share * share * of_first;
        along + 2.0 * members * math::max(rest, 0.0) + even
    }

    /// Whether a clamp holds a node of a contact's column, which then has no compliance of its own.
    fn is_held_in_part(&self, contact: &PlyContact) -> bool {
        let ([i, row], layout) = (contact.place(), &self.network.layout);
        (0..layout.plies).any(|ply| self.network.is_held_by_clamp(i, ply * layout.y.modelled() + row))
    }

    /// Compliance of the body at one contact to an impulse on another, 1/kg.
    fn body_compliance(&self, one: &PlyContact, other: &PlyContact) -> f64 {
        let turning = one.arm.dot(&other.arm.component_mul(&self.inertia.inverse_moments));
        self.multiplicity(other) * (one.normal.dot(&other.normal) * self.inertia.inverse_mass + turning)
    }

    /// Nodes of the whole fabric that the node of a contact stands for.
    pub(super) fn multiplicity(&self, contact: &PlyContact) -> f64 {
        if self.network.layout.has(Feature::Grading) {
            let [i, row] = contact.place();
            return self.network.net(0).share(i, row);
        }
        1.0
    }

    /// A vector in the axes of a contact's column.
    pub(super) fn column_axes(&self, contact: &PlyContact, v: Vector) -> Vector {
        if !self.network.layout.has(Feature::Curved) {
            return v;
        }
        Vector::from(self.network.column_axes(contact.column as usize, v.into()))
    }

    /// Friction of a contact in the axes of its column, N s.
    fn friction(&self, contact: &PlyContact, friction: Option<&PlyFriction>) -> Vector {
        friction.map_or(Vector::zeros(), |PlyFriction { tangential: t, .. }| {
            self.column_axes(contact, t.as_vector(t.impulse))
        })
    }

    /// Velocity along the sheet that friction and this normal impulse give a contact's node, m/s.
    fn along(&self, contact: &PlyContact, friction: Option<&PlyFriction>, impulse: f64) -> [f64; 2] {
        if contact.is_fixed() {
            return [0.0; 2];
        }
        let push = Vector::from(contact.own_normal) * impulse + self.friction(contact, friction);
        [push.x * contact.inverse_mass, push.y * contact.inverse_mass]
    }

    /// Velocity along the sheet that its impulses give a candidate's node, m/s, and the mass of the node, kg.
    fn along_of(&self, candidate: &Candidate, friction: Option<&Tangential>) -> ([f64; 2], f64) {
        let [column, _, ply] = self.network.layout.place(candidate.node as usize);
        let share = self.network.mass_share(ply);
        let mass = self.network.model.node_mass * share;
        if candidate.is_fixed() {
            return ([0.0; 2], mass);
        }
        let own = |v: Vector| Vector::from(self.network.column_axes(column, v.into()));
        let friction = friction.map_or(Vector::zeros(), |t| own(t.as_vector(t.impulse)));
        let (push, inverse_mass) =
            (own(candidate.normal) * candidate.impulse + friction, self.inverse_node_mass / share);
        ([push.x * inverse_mass, push.y * inverse_mass], mass)
    }

    /// Growth of a contact's gap but for the motion of its node along z, m/s.
    fn partial_gap_rate(&self, contact: &PlyContact, friction: Option<&PlyFriction>) -> f64 {
        let [along, across, _] = contact.own_normal;
        let [x, y] = self.along(contact, friction, contact.impulse);
        contact.gap_rate(&self.body) + (along * x + across * y)
    }

    /// Next impulses along the surface of a contact with friction.
    fn next_friction(&self, contact: &PlyContact, friction: &PlyFriction) -> [f64; 2] {
        let (impulse, change_z, t) = (contact.impulse, contact.velocity_change_z, &friction.tangential);
        let [x, y] = self.along(contact, Some(friction), impulse);
        let moved = t.tangents.map(|tangent| self.column_axes(contact, tangent).dot(&Vector::new(x, y, change_z)));
        let [p, q] = t.slip(&self.body);
        t.next([p + moved[0], q + moved[1]], self.network.scene.contact.friction * impulse)
    }

    /// Solves a column. Returns whether it was solved already.
    fn visit(&mut self, column: &mut ColumnContacts<'_>) -> bool {
        let (unit_speed, friction) = (self.network.model.unit_speed, self.network.layout.has(Feature::Friction));
        let unsettled = if friction { f64::INFINITY } else { math::max(HARMLESS * unit_speed, self.tolerance) };
        let error = self.error(column, unsettled);
        if !column.is_stale() && error <= self.tolerance {
            return true;
        }
        let lifted = match &mut *column.contacts {
            [contact] if contact.is_fixed() => self.push_fixed(contact),
            _ => self.solve_column(column),
        };
        if error > unsettled {
            // Whatever has moved.
            column.set_stale(false);
            return false;
        }
        let moved = self.solve_friction(column);
        // What candidates of one column pass on between them moves nothing.
        error <= HARMLESS * unit_speed && math::max(lifted, moved) <= self.tolerance
    }

    /// Residual of the laws of contact and friction over the contacts of a column, m/s. Those after one of
    /// more than `enough` are not looked at.
    fn error(&self, column: &ColumnContacts<'_>, enough: f64) -> f64 {
        let mut error = 0.0;
        for (contact, friction) in column.each() {
            let rate = self.partial_gap_rate(contact, friction) + contact.own_normal[2] * contact.velocity_change_z;
            error = math::max(laws::violation(contact.impulse, rate), error);
            if error > enough {
                break;
            }
            if let Some(friction) = friction {
                let (next, t) = (self.next_friction(contact, friction), &friction.tangential);
                error = math::max(laws::slip_violation(t.impulse, next, t.effective_mass), error);
            }
        }
        error
    }

    /// Largest residual of all columns, m/s.
    fn residual(&self, columns: &mut SortedContacts<'_>) -> f64 {
        let mut largest = 0.0;
        columns.for_each(|column| largest = math::max(self.error(&column, f64::INFINITY), largest));
        largest
    }

    /// The impulse on a fixed node. Returns how much it changes of the gap rate, m/s.
    fn push_fixed(&mut self, contact: &mut PlyContact) -> f64 {
        let compliance = contact.compliance;
        if compliance == 0.0 {
            // A prescribed body: neither has a compliance.
            return 0.0;
        }
        let trial = contact.impulse - contact.gap_rate(&self.body) / compliance;
        let impulse = math::max(trial, 0.0);
        self.supported |= impulse > 0.0;
        let change = impulse - contact.impulse;
        let of_all = change * self.multiplicity(contact);
        press(&mut self.body, &self.inertia, contact, of_all);
        contact.impulse = impulse;
        compliance * math::abs(change)
    }

    /// The nodes of a column and its candidates' normal impulses. Returns the largest change of the
    /// candidates' velocities along z, m/s.
    pub(super) fn solve_column(&mut self, column: &mut ColumnContacts<'_>) -> f64 {
        let (unit_speed, unit_impulse) = (self.network.model.unit_speed, self.network.model.unit_impulse);
        self.load_column(column);
        let has_friction = self.network.layout.has(Feature::Friction);
        for (contact, friction) in column.each() {
            let (rate, up) = (self.partial_gap_rate(contact, friction), contact.own_normal[2]);
            let along_z = self.friction(contact, friction).z;
            let Some(node) = self.column.nodes.get_mut(contact.ply as usize) else { break };
            node.stiffness = up * math::abs(up) * self.inverse_node_mass / contact.compliance;
            if up != 0.0 {
                let trial = contact.compliance * contact.impulse - rate;
                node.release = node.before + trial / (up * unit_speed);
            }
            if has_friction {
                node.speed += along_z / (unit_impulse * node.mass);
            }
        }
        self.column.project();
        self.note_moved(|node| node.stiffness == 0.0);
        // All answer to the body as it is now.
        let (mut body, mut moved) = (self.body, 0.0);
        for (contact, friction) in column.each_mut() {
            let Some(node) = self.column.nodes.get(contact.ply as usize) else { break };
            let (up, change_z) = (contact.own_normal[2], (node.speed - node.before) * unit_speed);
            let before = contact.impulse;
            let impulse = if math::abs(node.stiffness) > node.mass {
                node.push * unit_impulse / up
            } else {
                let rate = self.partial_gap_rate(contact, friction.as_deref()) + up * change_z;
                before - rate / contact.compliance
            };
            let impulse = math::max(impulse, 0.0);
            moved = math::max(math::abs(change_z - contact.velocity_change_z), moved);
            (contact.velocity_change_z, contact.impulse_before) = (change_z, before);
            let change = impulse - before;
            if change != 0.0 {
                press(&mut body, &self.inertia, contact, change * self.multiplicity(contact));
                contact.impulse = impulse;
            }
        }
        self.body = body;
        moved
    }

    /// Notes how far the nodes of the solved column are moved of which `is_passive` holds, for those without
    /// an included candidate.
    pub(super) fn note_moved(&mut self, is_passive: impl Fn(&Node) -> bool) {
        let unit_speed = self.network.model.unit_speed;
        for node in self.column.nodes.iter().filter(|node| is_passive(node)) {
            self.widest = math::max(math::abs(node.speed - node.before) * unit_speed, self.widest);
        }
    }

    /// Loads the nodes of a column.
    pub(super) fn load_column(&mut self, column: &ColumnContacts<'_>) {
        let [i, row] = column.leader().place();
        self.column.load(self.network, i, row);
    }

    /// The nodes of a loaded column under its candidates' impulses.
    pub(super) fn push_column(&mut self, column: &ColumnContacts<'_>) {
        self.column.restart();
        for (contact, friction) in column.each() {
            let push = contact.own_normal[2] * contact.impulse + self.friction(contact, friction).z;
            if let Some(node) = self.column.nodes.get_mut(contact.ply as usize) {
                node.push = push / self.network.model.unit_impulse;
                node.speed += node.push / node.mass;
            }
        }
        self.column.project();
    }

    /// Work between the plies of a column under the candidates' impulses: impulses times relative velocities
    /// before, with those at which gaps would close. And the square of what all impulses change of the
    /// velocities along z. In units of m (h/dt)^2.
    fn of_plies(&mut self, column: &ColumnContacts<'_>) -> [f64; 2] {
        self.load_column(column);
        self.push_column(column);
        let (mut work, mut moved, mut from_below) = (0.0, 0.0, 0.0);
        let mut nodes = self.column.nodes.iter();
        while let Some(node) = nodes.next() {
            let change = node.speed - node.before;
            if node.gap != f64::INFINITY {
                work += from_below * node.gap;
            }
            // A clamp takes all that comes from below, and what comes from above is found from there.
            if node.mass == HELD {
                let above = nodes.clone().take_while(|node| node.gap != f64::INFINITY && node.mass != HELD);
                from_below = above.fold(0.0, |sum, node| sum + node.mass * (node.speed - node.before) - node.push);
                continue;
            }
            let momentum = node.mass * change;
            work += node.before * (momentum - node.push);
            moved += momentum * change;
            from_below -= momentum - node.push;
        }
        [work, moved]
    }

    /// The next impulses along the surface of a contact, from these towards those that Coulomb's law asks
    /// for.
    ///
    /// A column that slides may go back and forth for ever: what friction pushes the node along the sheet,
    /// the normal impulse lets go of several times over where the surface is nearly flat, and it limits
    /// friction. So after some sweeps a candidate whose way turns back goes half as far, and farther again
    /// while it does not turn. The impulses stay in the cone, and what is left to go counts in full.
    fn relaxed(&self, contact: &PlyContact, friction: &mut PlyFriction, next: [f64; 2]) -> [f64; 2] {
        let ([p, q], relaxation) = (friction.tangential.impulse, &mut friction.relaxation);
        let increment = [next[0] - p, next[1] - q];
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
        let most = self.network.scene.contact.friction * contact.impulse;
        laws::limited([p + factor * increment[0], q + factor * increment[1]], most)
    }

    /// The impulses along the surface of a column's contacts, where there is friction. Returns the largest
    /// change of the velocities along the sheet since the column was solved last, of fixed nodes of the slip,
    /// m/s.
    pub(super) fn solve_friction(&mut self, column: &mut ColumnContacts<'_>) -> f64 {
        let (mut moved, mut stale) = (0.0, false);
        for (contact, mut friction) in column.each_mut() {
            let before = self.along(contact, friction.as_deref(), contact.impulse_before);
            if let Some(friction) = &mut friction {
                let [p, q] = friction.tangential.impulse;
                let next = self.next_friction(contact, friction);
                let next = self.relaxed(contact, friction, next);
                let (t, multiplicity) = (&mut friction.tangential, self.multiplicity(contact));
                t.impulse = next;
                let change = [next[0] - p, next[1] - q];
                let of_all = change.map(|change| change * multiplicity);
                self.body.velocity -= t.as_vector(of_all) * self.inertia.inverse_mass;
                self.body.angular_velocity -= t.moment(of_all).component_mul(&self.inertia.inverse_moments);
                let size = math::max(math::abs(change[0]), math::abs(change[1]));
                stale |= size > self.tolerance * t.effective_mass;
                if contact.is_fixed() && t.effective_mass > 0.0 {
                    moved = math::max(size / t.effective_mass, moved);
                }
            }
            let after = self.along(contact, friction.as_deref(), contact.impulse);
            let change = math::max(math::abs(after[0] - before[0]), math::abs(after[1] - before[1]));
            moved = math::max(change, moved);
        }
        column.set_stale(stale);
        moved
    }

    /// Impulses with friction, scaled back if they would add energy, as those of a single sheet are that were
    /// given up on: a cone holds every part of what it holds. The impulses between the plies are scaled with
    /// them here; those that separate the plies in the end leave no more energy than these and what they
    /// would do against the gaps.
    fn without_gain(&mut self, columns: &mut SortedContacts<'_>, solved: Solved) -> Solved {
        let model = &self.network.model;
        let mut gain = Gain::of_body(self.before, &model.inertia, &solved);
        for (c, candidate) in columns.candidates.iter().enumerate() {
            let friction = columns.tangential.get(c);
            gain.before += candidate.multiplicity * gain.work_before(candidate, friction);
            let ([x, y], mass) = self.along_of(candidate, friction);
            gain.change += candidate.multiplicity * (mass * (x * x + y * y));
        }
        // SortedContacts of all candidates.
        columns.sort(self.network);
        let (mut between, mut lifted) = (0.0, 0.0);
        columns.for_each(|column| {
            let leader = column.leader();
            if !leader.is_fixed() {
                let ([work, moved], multiplicity) = (self.of_plies(&column), self.multiplicity(&leader));
                (between, lifted) = (between + multiplicity * work, lifted + multiplicity * moved);
            }
        });
        gain.before += between * model.unit_energy;
        gain.change += lifted * model.unit_energy;
        gain.scale_back(columns.candidates, columns.tangential, solved)
    }
}

impl PlyContact {
    /// Whether a support or the case holds the node.
    pub(super) fn is_fixed(&self) -> bool {
        self.held_by != Holder::None as u32
    }

    /// Growth of the gap without an impulse on the node, m/s.
    pub(super) fn gap_rate(&self, body: &Twist) -> f64 {
        self.free_gap_rate - self.normal.dot(&body.velocity) - self.arm.dot(&body.angular_velocity)
    }

    /// Column and row of the sheet in which its node lies.
    fn place(&self) -> [usize; 2] {
        [self.column as usize, self.row as usize]
    }
}

/// Changes the velocity of the body by a change of a contact's normal impulse.
fn press(body: &mut Twist, inertia: &Inertia, contact: &PlyContact, change: f64) {
    body.velocity -= contact.normal * (change * inertia.inverse_mass);
    body.angular_velocity -= contact.arm.component_mul(&inertia.inverse_moments) * change;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::pose::Vector;
    use crate::scene::parts::Scene;
    use crate::tests::{close, network, number, sheet, sphere};
    use std::vec::Vec;

    const PLIES: usize = 4;

    /// Four plies that lie on each other in every column, at rest, and a coefficient of friction.
    fn pack(friction: f64) -> (Network<'static>, Contacts<'static>) {
        let mut scene = Scene { seed: 3, ..sheet(15, 13) };
        (scene.stack.plies, scene.stack.gap, scene.contact.friction) = (PLIES as u32, 1e-4, friction);
        let (mut network, contacts, _) = network(&scene);
        for (i, j) in network.nodes() {
            let (ply, _) = network.layout.ply_and_row(j);
            network.set_node(i, j, [0.0, 0.0, -(ply as f64) * network.model.gap], [0.0; 3]);
        }
        (network, contacts)
    }

    /// Candidate that pushes the node at a place along a normal, N s by no impulse yet.
    fn candidate(network: &Network<'_>, [i, row, ply]: [usize; 3], normal: Vector, free_gap_rate: f64) -> Candidate {
        let node = (ply * network.layout.y.modelled() + row) * network.layout.nodes_x + i;
        Candidate { node: node as u32, normal, free_gap_rate, multiplicity: 1.0, ..Candidate::default() }
    }

    /// Heavy body of the preset, at 100 m/s along z.
    fn body() -> Body {
        sphere().1
    }

    #[test]
    fn a_column_that_lies_on_itself_takes_the_impulse_of_all_its_nodes() {
        let (network, mut contacts) = pack(0.0);
        let (body, model) = (body(), &network.model);
        for ply in 0..PLIES {
            // Plies below the pushed one stay.
            let mass = (PLIES - ply) as f64 * model.node_mass;
            contacts.candidates[0] = candidate(&network, [7, 6, ply], Vector::z(), 0.0);
            let solved = solve(&network, &mut contacts, &body, 1);
            let impulse = body.velocity.z / (model.inertia.inverse_mass + 1.0 / mass);
            assert!(solved.converged, "{solved:?}");
            close(contacts.candidates[0].impulse, impulse, 1e-9);
            close(solved.twist.velocity.z, body.velocity.z - impulse * model.inertia.inverse_mass, 1e-12);
        }
    }

    #[test]
    fn friction_on_a_column_that_slides_is_that_of_coulomb() {
        let (network, mut contacts) = pack(0.1);
        let mut body = body();
        body.velocity = Vector::new(-30.0, 40.0, 60.0);
        contacts.candidates[0] = candidate(&network, [7, 6, 0], Vector::z(), 0.0);
        contacts.tangential[0] = Tangential::at(&-Vector::z(), &Vector::z(), &Vector::zeros(), &body);
        let solved = solve(&network, &mut contacts, &body, 1);
        let (impulse, t) = (contacts.candidates[0].impulse, contacts.tangential[0]);
        let along = t.as_vector(t.impulse);
        assert!(solved.converged && impulse > 0.0, "{solved:?}");
        close(along.norm(), 0.1 * impulse, 1e-9);
        // Along the slip of the surface over the node, which is that of the body.
        close(along.dot(&Vector::new(-0.6, 0.8, 0.0)), along.norm(), 1e-9);
    }

    /// Contacts of many columns, several in some: no impulse pulls, no gap closes, and an impulse leaves no
    /// gap rate. Velocities of the nodes are found anew from the impulses.
    #[test]
    fn impulses_are_complementary_to_gap_rates() {
        let (mut network, mut contacts) = pack(0.0);
        let (body, model) = (body(), network.model.unit_speed);
        let (mut pushed, mut free) = (0, 0);
        for case in 0..40_u64 {
            let draw = |k: u64| number(10_000 * case + k);
            for (k, (i, j)) in (0..).zip(network.nodes()) {
                let (u, _) = network.node(i, j);
                network.set_node(i, j, u, [0.0, 0.0, 0.05 * draw(k)]);
            }
            let mut found = Vec::new();
            for k in 0..24_u64 {
                let place = [3 + k as usize % 3, 4 + k as usize / 12, k as usize / 3 % PLIES];
                let normal = Vector::new(0.3 * draw(5000 + k), 0.3 * draw(6000 + k), 1.0).normalize();
                let candidate = candidate(&network, place, normal, 60.0 + 90.0 * draw(7000 + k));
                if !found.iter().any(|other: &Candidate| other.node == candidate.node) {
                    found.push(candidate);
                }
            }
            contacts.candidates[..found.len()].copy_from_slice(&found);
            let solved = solve(&network, &mut contacts, &body, found.len());
            assert!(solved.converged, "{case} {solved:?}");
            let momentum: Vector = contacts.found(found.len()).iter().map(|c| c.normal * c.impulse).sum();
            let lost = (body.velocity - solved.twist.velocity) * network.model.inertia.mass;
            assert!((lost - momentum).norm() < 1e-9 * momentum.norm(), "{case}");
            for k in 0..found.len() {
                let candidate = contacts.candidates[k];
                let [i, row, ply] = network.layout.place(candidate.node as usize);
                let of_column: Vec<_> = contacts.found(found.len()).to_vec();
                let mut column = contacts.column();
                column.load(&network, i, row);
                for other in of_column {
                    let [a, b, ply] = network.layout.place(other.node as usize);
                    if [a, b] == [i, row] {
                        column.nodes[ply].speed += other.normal.z * other.impulse / network.model.unit_impulse;
                    }
                }
                column.project();
                let node = column.nodes[ply];
                let along =
                    candidate.impulse / network.model.node_mass * (1.0 - candidate.normal.z * candidate.normal.z);
                let up = candidate.normal.z * (node.speed - node.before) * model;
                let rate = candidate.gap_rate(&solved.twist) + along + up;
                assert!(candidate.impulse >= 0.0 && rate > -1e-7, "{case} {k} {rate:e}");
                assert!(candidate.impulse == 0.0 || rate < 1e-7, "{case} {k} {rate:e}");
                *(if candidate.impulse > 0.0 { &mut pushed } else { &mut free }) += 1;
            }
        }
        assert!(pushed > 200 && free > 200, "{pushed} {free}");
    }
}
