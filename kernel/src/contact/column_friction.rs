//! Columns with several candidates and friction: normal and tangential impulses of their
//! candidates, and the velocities of their nodes, at once.
//!
//! Method: semismooth Newton. Under an impulse r in the frame (n, t0, t1) of a candidate its node moves along
//! the sheet by (I - q q^T) r/m; so gap rate and slips change by A dr + q dl, with q the parts of the z axis
//! in the frame, the change dl of the node's velocity along z, and A = D + (I - q q^T)/m, where D is the
//! compliance of the body, a little increased. A candidate that sticks loses all three; one that slides loses
//! its gap rate, and its friction is mu lambda along p - s/W, which turns. Either way r is linear in dl: with
//! these springs each pool of the column moves on by one number, and then plies are separated anew. A step
//! that ends higher is undone and tried again with a larger D (Levenberg and Marquardt): where two plies of a
//! pool stick to places of the body that part, impulses have to go far before one of them slides, and steps
//! with the body's own D go too far. If none helps the column takes sweeps of Gauss-Seidel instead
//! (`stack.rs`), as many as there have been of all columns: beside candidates that slide two plies may
//! neither press on each other nor part, and Newton's method leads back there, but sweeps follow the impulses
//! away, until a candidate lets go or sticks. Where |n_z| < mu |t_z|, with t along friction, a sliding
//! candidate may be wedged: its impulse would grow as its node moves away. It lets go if its gap grows, and
//! sticks if it closes, as it does in time.
//! Limits: which of several solutions is found depends on the iteration. Nothing proves that one is found;
//! what is left over is counted.
//! Reference: P. Alart, A. Curnier, Comput. Methods Appl. Mech. Engrg. 92 (1991) 353; L. Qi, J. Sun, Math.
//! Program. 58 (1993) 353; D. W. Marquardt, J. Soc. Ind. Appl. Math. 11 (1963) 431.

use crate::contact::by_column::ColumnContacts;
use crate::contact::laws;
use crate::contact::solve::MAX_SWEEPS;
use crate::contact::stack::StackSolve;
use crate::ground::math;
use crate::memory::records::{Node, PlyContact, PlyFriction, Spring};

/// Most steps for a column in a sweep.
const MOST_STEPS: u32 = 30;
/// Largest accepted error after a step, over that before it, undamped and damped: damped steps go on along a
/// face on which nothing but impulses changes.
const ACCEPTED: [f64; 2] = [0.9, 1.01];
/// Compliance added to the body's in a damped step, over that of a node: first, growth, most.
const DAMPING: [f64; 3] = [1e-3, 3.0, 0.2];
/// Tolerances of gap rates and slips where several candidates share a column, spacings a step: at which the
/// sweeps end, and at which Newton's method ends in one column.
const TOLERANCES: [f64; 2] = [1e-7, 2e-8];
/// Least derivative of a sliding candidate's gap rate by its impulse, over the compliance of its node; below
/// it the equations count as singular.
const FLAT: f64 = 1e-6;

/// Contact with friction, in the frame of its normal and its two tangents.
struct FrictionalContact {
    /// Components of the z axis along normal and tangents.
    up: [f64; 3],
    /// Impulses along them, N s.
    impulse: [f64; 3],
    /// Gap rate and slips along them, m/s.
    rate: [f64; 3],
    /// 1/m of its node, 1/kg.
    own: f64,
    /// Compliance of the body along the normal and across, 1/kg.
    body: [f64; 2],
    /// 1/W of friction, kg, and its coefficient.
    mass: f64,
    friction: f64,
}

impl FrictionalContact {
    /// Residual of the laws of contact and friction, m/s, and the increment of the impulse along the surface.
    fn error(&self) -> (f64, [f64; 2]) {
        let ([normal, p, q], [gap_rate, s, t]) = (self.impulse, self.rate);
        let trial = laws::trial_friction([p, q], [s, t], self.mass);
        let next = laws::limited(trial, self.friction * normal);
        let slip = laws::slip_violation([p, q], next, self.mass);
        (math::max(slip, laws::violation(normal, gap_rate)), trial)
    }

    /// Impulses as linear functions of the node's velocity along z, by the state of the contact: none if it
    /// lets go, else those of one that sticks or slides. `trial`: friction that leaves no slip, N s.
    fn spring(&self, trial: [f64; 2]) -> Spring {
        let [_, body] = self.body;
        let compliance = self.body[0] + self.own * (1.0 - self.up[0] * self.up[0]);
        if self.impulse[0] * compliance <= self.rate[0] || body + self.own == 0.0 {
            return Spring::default();
        }
        let (size, most) = (math::length([trial[0], trial[1], 0.0]), self.friction * self.impulse[0]);
        let slides = if size > most { self.sliding(trial.map(|p| p / size), most / size) } else { None };
        slides.unwrap_or_else(|| self.sticking())
    }

    /// Spring of a contact that sticks: neither a gap rate nor a slip is left.
    fn sticking(&self) -> Spring {
        let ([d, e], q) = (self.body, self.up);
        let body = [d, e, e];
        let part = body.map(|body| 1.0 / (body + self.own));
        // 1 - q.(part q)/m, without rounding.
        let [a, b, c]: [f64; 3] = core::array::from_fn(|k| q[k] * q[k] * (body[k] * part[k]));
        let rest = a + b + c;
        let [a, b, c]: [f64; 3] = core::array::from_fn(|k| q[k] * (part[k] * self.rate[k]));
        let along = self.own * ((a + b + c) / rest);
        let base = core::array::from_fn(|k| self.impulse[k] - part[k] * (self.rate[k] + q[k] * along));
        Spring { base, slope: core::array::from_fn(|k| -part[k] * q[k] / rest), ..Spring::default() }
    }

    /// Spring of a contact that slides, without a gap rate and with friction along the unit vector [c, s].
    /// `part`: size of friction over that of the trial impulse. None where the equations are singular.
    fn sliding(&self, [c, s]: [f64; 2], part: f64) -> Option<Spring> {
        let (own, mu, [up, u, v]) = (self.own, self.friction, self.up);
        // Along friction and across it.
        let (along, across) = (u * c + v * s, v * c - u * s);
        let ([normal, p, q], [gap_rate, slip, slip_across]) = (self.impulse, self.rate);
        let (p, q, slip) = (p * c + q * s, q * c - p * s, slip_across * c - slip * s);
        let [nn, na, nc] = [self.body[0] + own * (1.0 - up * up), -own * up * along, -own * up * across];
        let [ac, cc] = [-own * along * across, self.body[1] + own * (1.0 - across * across)];
        // Two equations for the normal impulse and that across.
        let turn = part * self.mass;
        let [a, b, f, g] = [nn + mu * na, nc, turn * (nc + mu * ac), turn * cc + (1.0 - part)];
        let det = a * g - b * f;
        if math::abs(a) < FLAT * own || math::abs(det) < FLAT * math::abs(a * g) {
            return None;
        }
        let solved = |x: f64, y: f64| {
            let (normal, across) = ((x * g - b * y) / det, (a * y - f * x) / det);
            [normal, mu * normal * c - across * s, mu * normal * s + across * c]
        };
        let x = nn * normal + na * p + nc * q - gap_rate;
        let y = turn * (nc * normal + ac * p + cc * q - slip);
        Some(Spring { base: solved(x, y), slope: solved(-up, -turn * across), ..Spring::default() })
    }

    /// Component along z of impulses along normal and tangents, N s.
    fn lift(&self, [normal, p, q]: &[f64; 3]) -> f64 {
        self.up[0] * normal + self.up[1] * p + self.up[2] * q
    }
}

impl StackSolve<'_, '_> {
    /// Solves a column of several contacts. Returns whether it was solved already.
    pub(super) fn visit_with_friction(&mut self, column: &mut ColumnContacts<'_>) -> bool {
        let unit_speed = self.network.model.unit_speed;
        let [enough, tolerance] = TOLERANCES.map(|part| math::max(part * unit_speed, self.tolerance));
        if column.is_stale() {
            if self.sweeps == 0 {
                self.solve_column(column);
                self.solve_friction(column);
            } else {
                self.load_column(column);
            }
            self.balance(column);
        }
        let first = self.set_springs(column, tolerance);
        let mut stale = false;
        if first > tolerance {
            if !column.is_stale() {
                self.load_column(column);
                self.balance(column);
            }
            let last = self.newton(column, first, [enough, tolerance]);
            stale = last == first && last > enough;
            // What steps have tried does not count.
            self.note_moved(|node| node.push == 0.0);
        }
        if stale {
            // Sweeps for fixed nodes, which may go on for long, are no reason for long runs.
            let run = if self.sweeps < MAX_SWEEPS { self.sweeps } else { 0 };
            for _ in 0..=run {
                self.solve_column(column);
                self.solve_friction(column);
            }
        }
        column.set_stale(stale);
        first <= enough
    }

    /// Steps of Newton's method for a loaded column whose springs are known, until its error is below the
    /// tolerance, or is small enough and steps bring no more. Returns the error then, m/s.
    fn newton(&mut self, column: &mut ColumnContacts<'_>, first: f64, [enough, tolerance]: [f64; 2]) -> f64 {
        let (mut rates, mut best) = (self.body, first);
        let [least, growth, most] = DAMPING;
        for _ in 0..MOST_STEPS {
            self.step(column);
            self.balance(column);
            let error = self.set_springs(column, tolerance);
            if error <= tolerance || error < ACCEPTED[usize::from(self.damping > 0.0 && best > enough)] * best {
                (rates, best) = (self.body, math::min(error, best));
                if best <= tolerance {
                    break;
                }
                continue;
            }
            for (contact, friction) in with_friction(column) {
                self.give_impulses(contact, friction, friction.spring.before);
            }
            self.body = rates;
            self.balance(column);
            self.damping = math::max(growth * self.damping, least);
            if self.damping > most || best <= enough {
                break;
            }
            self.set_springs(column, tolerance);
        }
        self.damping = 0.0;
        best
    }

    /// Node of a contact in the loaded column.
    fn node(&self, contact: &PlyContact) -> Node {
        self.column.nodes.get(contact.ply as usize).copied().unwrap_or_default()
    }

    /// Contact at the present velocities of the body and of its node.
    fn contact(&self, contact: &PlyContact, friction: &PlyFriction) -> FrictionalContact {
        let t = &friction.tangential;
        let softer = self.damping * contact.inverse_mass;
        let ([_, _, up], tangents) = (contact.own_normal, t.tangents);
        let up = [up, self.column_axes(contact, tangents[0]).z, self.column_axes(contact, tangents[1]).z];
        let along_normal = contact.compliance - contact.inverse_mass * (1.0 - up[0] * up[0]);
        let mut found = FrictionalContact {
            up,
            impulse: [contact.impulse, t.impulse[0], t.impulse[1]],
            rate: [0.0; 3],
            own: contact.inverse_mass,
            body: [along_normal, contact.compliance_across].map(|d| d + softer),
            mass: t.effective_mass,
            friction: self.network.scene.contact.friction,
        };
        let [s0, s1] = t.slip(&self.body);
        let (lift, rates) = (found.lift(&found.impulse), [contact.gap_rate(&self.body), s0, s1]);
        for (k, rate) in rates.into_iter().enumerate() {
            let along = found.impulse[k] - found.up[k] * lift;
            found.rate[k] = rate + contact.inverse_mass * along + found.up[k] * contact.velocity_change_z;
        }
        found
    }

    /// Finds the velocities along z in a loaded column under the impulses on it.
    fn balance(&mut self, column: &mut ColumnContacts<'_>) {
        let unit_speed = self.network.model.unit_speed;
        self.push_column(column);
        for contact in &mut *column.contacts {
            let node = self.node(contact);
            contact.velocity_change_z = (node.speed - node.before) * unit_speed;
        }
    }

    /// Linearises the contacts of a column if their largest residual of the laws of contact and friction is
    /// more than `tolerance`. Returns that residual, m/s.
    fn set_springs(&self, column: &mut ColumnContacts<'_>, tolerance: f64) -> f64 {
        let (mut error, mut left_out) = (0.0, 0);
        for (contact, friction) in with_friction(column) {
            let found = self.contact(contact, friction);
            let (own, trial) = found.error();
            error = math::max(own, error);
            if error > tolerance {
                self.set_spring(friction, &found, &found.spring(trial));
            } else {
                left_out += 1;
            }
        }
        let first = if error > tolerance { left_out } else { 0 };
        for (contact, friction) in with_friction(column).take(first) {
            let found = self.contact(contact, friction);
            self.set_spring(friction, &found, &found.spring(found.error().1));
        }
        error
    }

    /// Keeps the spring of a contact and what it does to its node, in units of the column.
    fn set_spring(&self, friction: &mut PlyFriction, contact: &FrictionalContact, spring: &Spring) {
        let (unit_speed, unit_impulse) = (self.network.model.unit_speed, self.network.model.unit_impulse);
        let push = (contact.lift(&spring.base) - contact.lift(&contact.impulse)) / unit_impulse;
        let stiffness = -contact.lift(&spring.slope) * (unit_speed / unit_impulse);
        friction.spring = Spring { before: friction.spring.before, push, stiffness, ..*spring };
    }

    /// Gives a node of the column the spring of its contact.
    fn load_spring(&mut self, contact: &PlyContact, friction: &PlyFriction) {
        if let Some(node) = self.column.nodes.get_mut(contact.ply as usize) {
            (node.push, node.stiffness) = (friction.spring.push, friction.spring.stiffness);
        }
    }

    /// A step of Newton's method. The impulses before it are kept.
    fn step(&mut self, column: &mut ColumnContacts<'_>) {
        let unit_speed = self.network.model.unit_speed;
        for (contact, friction) in with_friction(column) {
            let [p, q] = friction.tangential.impulse;
            friction.spring.before = [contact.impulse, p, q];
            self.load_spring(contact, friction);
        }
        self.column.set_pool_stiffness();
        for (contact, friction) in with_friction(column) {
            let node = self.node(contact);
            // Wedged: the others of its pool hold it against its negative stiffness.
            if node.stiffness < 0.0 && friction.spring.slope[0] > 0.0 && -node.stiffness < node.pool_stiffness {
                let found = self.contact(contact, friction);
                let lets_go = found.rate[0] > 0.0;
                self.set_spring(friction, &found, &if lets_go { Spring::default() } else { found.sticking() });
                self.load_spring(contact, friction);
            }
        }
        self.column.set_pool_velocity_change();
        for (contact, friction) in with_friction(column) {
            let (spring, change) = (friction.spring, self.node(contact).pool_velocity_change * unit_speed);
            let impulses = core::array::from_fn(|k| spring.base[k] + spring.slope[k] * change);
            self.give_impulses(contact, friction, impulses);
        }
    }

    /// Gives a contact the nearest impulses that are allowed, and the body what they change.
    fn give_impulses(&mut self, contact: &mut PlyContact, friction: &mut PlyFriction, [normal, p, q]: [f64; 3]) {
        let normal = math::max(normal, 0.0);
        if contact.impulse == 0.0 && normal == 0.0 {
            return;
        }
        let (t, multiplicity) = (&mut friction.tangential, self.multiplicity(contact));
        let impulse = laws::limited([p, q], self.network.scene.contact.friction * normal);
        let (given, along) = (normal - contact.impulse, [0, 1].map(|k| impulse[k] - t.impulse[k]));
        self.body.velocity -=
            (contact.normal * given + t.as_vector(along)) * (multiplicity * self.inertia.inverse_mass);
        self.body.angular_velocity -=
            (contact.arm * given + t.moment(along)).component_mul(&self.inertia.inverse_moments) * multiplicity;
        (t.impulse, contact.impulse) = (impulse, normal);
    }
}

/// Contacts of a column with their friction.
fn with_friction<'m>(
    column: &'m mut ColumnContacts<'_>,
) -> impl Iterator<Item = (&'m mut PlyContact, &'m mut PlyFriction)> {
    column.contacts.iter_mut().zip(column.friction.iter_mut())
}
