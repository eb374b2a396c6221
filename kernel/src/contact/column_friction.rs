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

use crate::contact::column::{set_pool_stiffness, set_pool_velocity_change};
use crate::contact::laws;
use crate::contact::solve::MAX_SWEEPS;
use crate::contact::stack::StackSolve;
use crate::ground::math;
use crate::memory::records::{Node, Spring, Tangential, Touch};

/// Steps for a column in a sweep at the most.
const MOST_STEPS: u32 = 30;
/// Largest error after a step, over that before it, undamped and damped: damped steps go on along a face on
/// which nothing but impulses changes.
const LEFT: [f64; 2] = [0.9, 1.01];
/// Compliance added to the body's in a damped step, over that of a node: first, growth, most.
const DAMPING: [f64; 3] = [1e-3, 3.0, 0.2];
/// Gap rates and slips that do not count where several candidates share a column, spacings a step: to end
/// with, and of one column.
const ROUGH: [f64; 2] = [1e-7, 2e-8];
/// Slopes of a sliding candidate below this, over the compliance of its node, are no slopes.
const FLAT: f64 = 1e-6;

/// A candidate as its column sees it.
struct FrictionalContact {
    /// The parts of the z axis along normal and tangents.
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

    /// The spring that Newton's method takes it for.
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

    /// No speed is left.
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

    /// No gap rate is left, and friction goes along the unit vector [c, s]. `part`: its size over that of the
    /// trial impulse.
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

    /// The part along z of impulses.
    fn lift(&self, [normal, p, q]: &[f64; 3]) -> f64 {
        self.up[0] * normal + self.up[1] * p + self.up[2] * q
    }
}

impl StackSolve<'_, '_> {
    /// Solves the column of several candidates that this one leads. Returns whether it was solved already.
    pub(super) fn visit_with_friction(&mut self, leader: usize) -> bool {
        let (unit_speed, touch) = (self.system.model.unit_speed, self.touch(leader));
        let [enough, tolerance] = ROUGH.map(|part| math::max(part * unit_speed, self.tolerance));
        if touch.stale != 0.0 {
            if self.sweeps == 0 {
                self.solve_column(leader);
                self.solve_friction(leader);
            } else {
                self.load_column(leader);
            }
            self.balance(leader);
        }
        let first = self.set_springs(leader, tolerance);
        let mut stale = false;
        if first > tolerance {
            let last = self.newton(leader, first, [enough, tolerance]);
            stale = last == first && last > enough;
            // What steps have tried does not count.
            for node in self.system.arrays.column.iter().filter(|node| node.push == 0.0) {
                self.widest = math::max(math::abs(node.speed - node.before) * unit_speed, self.widest);
            }
        }
        if stale {
            // Sweeps for fixed nodes, which may go on for long, are no reason for long runs.
            let run = if self.sweeps < MAX_SWEEPS { self.sweeps } else { 0 };
            for _ in 0..=run {
                self.solve_column(leader);
                self.solve_friction(leader);
            }
        }
        self.set_touch(leader, Touch { stale: f64::from(u8::from(stale)), ..self.touch(leader) });
        first <= enough
    }

    /// Steps of Newton's method for a column whose springs are known, until its error is below the tolerance,
    /// or is small enough and steps bring no more. Returns the error then, m/s.
    fn newton(&mut self, leader: usize, first: f64, [enough, tolerance]: [f64; 2]) -> f64 {
        if self.touch(leader).stale == 0.0 {
            self.load_column(leader);
            self.balance(leader);
        }
        let (mut rates, mut best) = (self.body, first);
        let [least, growth, most] = DAMPING;
        for _ in 0..MOST_STEPS {
            self.step(leader);
            self.balance(leader);
            let error = self.set_springs(leader, tolerance);
            if error <= tolerance || error < LEFT[usize::from(self.damping > 0.0 && best > enough)] * best {
                (rates, best) = (self.body, math::min(error, best));
                if best <= tolerance {
                    break;
                }
                continue;
            }
            for k in self.column(leader) {
                let c = self.member(k);
                let before = self.spring(c).before;
                self.give_impulses(c, before);
            }
            self.body = rates;
            self.balance(leader);
            self.damping = math::max(growth * self.damping, least);
            if self.damping > most || best <= enough {
                break;
            }
            self.set_springs(leader, tolerance);
        }
        self.damping = 0.0;
        best
    }

    fn spring(&self, c: usize) -> Spring {
        self.system.arrays.springs.get(c).copied().unwrap_or_default()
    }

    fn node(&self, c: usize) -> Node {
        self.system.arrays.column.get(self.ply(c)).copied().unwrap_or_default()
    }

    fn contact(&self, c: usize) -> Option<FrictionalContact> {
        let (candidate, t, touch) = (self.candidate(c), self.tangential(c)?, self.touch(c));
        let softer = self.damping * touch.inverse_mass;
        let ([_, _, up], tangents) = (touch.normal, t.tangents);
        let up = [up, self.own_axes(c, tangents[0]).z, self.own_axes(c, tangents[1]).z];
        let mut contact = FrictionalContact {
            up,
            impulse: [candidate.impulse, t.impulse[0], t.impulse[1]],
            rate: [0.0; 3],
            own: touch.inverse_mass,
            body: [touch.compliance - touch.inverse_mass * (1.0 - up[0] * up[0]), touch.compliance_across]
                .map(|d| d + softer),
            mass: t.effective_mass,
            friction: self.system.scene.contact.friction,
        };
        let [s0, s1] = t.slip(&self.body);
        let (lift, rates) = (contact.lift(&contact.impulse), [candidate.gap_rate(&self.body), s0, s1]);
        for (k, rate) in rates.into_iter().enumerate() {
            let along = contact.impulse[k] - contact.up[k] * lift;
            contact.rate[k] = rate + touch.inverse_mass * along + contact.up[k] * touch.velocity_change_z;
        }
        Some(contact)
    }

    /// Finds the velocities along z in a loaded column under the impulses on it.
    fn balance(&mut self, leader: usize) {
        let unit_speed = self.system.model.unit_speed;
        self.push_column(leader);
        for k in self.column(leader) {
            let c = self.member(k);
            let node = self.node(c);
            if let Some(touch) = self.system.arrays.touches.get_mut(c) {
                touch.velocity_change_z = (node.speed - node.before) * unit_speed;
            }
        }
    }

    /// Takes the candidates of a column for springs if they fail the laws of contact and friction by more
    /// than `tolerance`. Returns by how much they do at the most, m/s.
    fn set_springs(&mut self, leader: usize, tolerance: f64) -> f64 {
        let (mut error, mut left_out) = (0.0, 0);
        for k in self.column(leader) {
            let c = self.member(k);
            let Some(contact) = self.contact(c) else { break };
            let (own, trial) = contact.error();
            error = math::max(own, error);
            if error > tolerance {
                self.set_spring(c, &contact, &contact.spring(trial));
            } else {
                left_out += 1;
            }
        }
        let first = if error > tolerance { left_out } else { 0 };
        for k in self.column(leader).take(first) {
            let c = self.member(k);
            let Some(contact) = self.contact(c) else { break };
            self.set_spring(c, &contact, &contact.spring(contact.error().1));
        }
        error
    }

    /// Keeps the spring of a candidate and what it does to its node, in units of the column.
    fn set_spring(&mut self, c: usize, contact: &FrictionalContact, spring: &Spring) {
        let (unit_speed, unit_impulse) = (self.system.model.unit_speed, self.system.model.unit_impulse);
        let push = (contact.lift(&spring.base) - contact.lift(&contact.impulse)) / unit_impulse;
        let stiffness = -contact.lift(&spring.slope) * (unit_speed / unit_impulse);
        if let Some(slot) = self.system.arrays.springs.get_mut(c) {
            *slot = Spring { before: slot.before, push, stiffness, ..*spring };
        }
    }

    /// Hangs the spring of a candidate on its node.
    fn hang(&mut self, c: usize) {
        let (ply, Spring { push, stiffness, .. }) = (self.ply(c), self.spring(c));
        if let Some(node) = self.system.arrays.column.get_mut(ply) {
            (node.push, node.stiffness) = (push, stiffness);
        }
    }

    /// A step of Newton's method. The impulses before it are kept.
    fn step(&mut self, leader: usize) {
        let unit_speed = self.system.model.unit_speed;
        for k in self.column(leader) {
            let c = self.member(k);
            if let Some(candidate) = self.system.arrays.candidates.get(c)
                && let Some(t) = self.system.arrays.tangential.get(c)
                && let Some(spring) = self.system.arrays.springs.get_mut(c)
            {
                spring.before = [candidate.impulse, t.impulse[0], t.impulse[1]];
            }
            self.hang(c);
        }
        set_pool_stiffness(self.system.arrays.column, self.system.arrays.pools);
        for k in self.column(leader) {
            let c = self.member(k);
            let node = self.node(c);
            // Wedged: the others of its pool hold it against its negative stiffness.
            if node.stiffness < 0.0
                && self.spring(c).slope[0] > 0.0
                && -node.stiffness < node.pool_stiffness()
                && let Some(contact) = self.contact(c)
            {
                let lets_go = contact.rate[0] > 0.0;
                self.set_spring(c, &contact, &if lets_go { Spring::default() } else { contact.sticking() });
                self.hang(c);
            }
        }
        set_pool_velocity_change(self.system.arrays.column, self.system.arrays.pools);
        for k in self.column(leader) {
            let c = self.member(k);
            let (spring, change) = (self.spring(c), self.node(c).pool_velocity_change() * unit_speed);
            self.give_impulses(c, core::array::from_fn(|k| spring.base[k] + spring.slope[k] * change));
        }
    }

    /// Gives a candidate the nearest impulses that are allowed, and the body what they change.
    fn give_impulses(&mut self, c: usize, [normal, p, q]: [f64; 3]) {
        let (candidate, normal) = (self.candidate(c), math::max(normal, 0.0));
        if candidate.impulse == 0.0 && normal == 0.0 {
            return;
        }
        let Some(t) = self.tangential(c) else { return };
        let impulse = laws::limited([p, q], self.system.scene.contact.friction * normal);
        let (given, along) = (normal - candidate.impulse, [0, 1].map(|k| impulse[k] - t.impulse[k]));
        self.body.velocity -= (candidate.normal * given + t.as_vector(along)) * self.inertia.inverse_mass;
        self.body.angular_velocity -=
            (candidate.arm * given + t.moment(along)).component_mul(&self.inertia.inverse_moments);
        self.set_tangential(c, &Tangential { impulse, ..t });
        self.set_impulse(c, normal);
    }
}
