//! Contact for solves that sweeps do not finish: the candidates are coupled by the six rates of the body
//! alone, which Newton's method finds.
//!
//! Method: while the body changes its rates by d, each candidate answers by itself: its impulse is lambda =
//! max(0, lambda_0 - rho g(d)), with the gap rate g and the impulse lambda_0 so far, and its friction the
//! nearest point of its disc. For a free node rho is its mass and the answer is exact. A fixed node has no
//! compliance: there rho is large, and the step is one of the method of multipliers, repeated from the
//! impulses found until none changes. The rates of each step solve six equations that are piecewise smooth,
//! by the semismooth Newton method; a step that goes too far is cut to a tenth, then bisected, until the
//! residual along it is at most half. The work is some passes over the candidates, in any arrangement.
//! Without friction each step is one of the convex dual problem and never adds energy; a step whose equations
//! are not solved is not taken.
//! Limits: with friction the equations need not be monotone, and the line search may fail; then the residual
//! is counted.
//! Reference: L. Qi, J. Sun, Math. Program. 58 (1993) 353; P. Alart, A. Curnier, Comput. Methods Appl. Mech.
//! Engrg. 92 (1991) 353; R. T. Rockafellar, Math. Oper. Res. 1 (1976) 97.

use crate::body::pose::Vector;
use crate::body::projectile::Inertia;
use crate::contact::candidate::{Solved, StepInputs};
use crate::contact::laws::{self, Gain};
use crate::ground::math;
use crate::memory::records::{Candidate, Tangential};

/// Passes over the candidates after which no step is begun; one begun takes at most five more.
pub const MAX_PASSES: u32 = 95;
/// rho of a fixed node over its effective mass: at first, and at least.
pub(crate) const STIFF: f64 = 1e4;
const SOFTEST: f64 = 10.0;
/// Factor of rho after a pass that has not halved the residual.
const SOFTENING: f64 = 0.1;
/// Residual over the tolerance of sweeps above which a step with the friction that the impulses so far allow
/// is tried where the line search of another fails.
const FROZEN_ABOVE: f64 = 1e8;
/// Residual of equations that does not count, over the tolerance of sweeps.
const ROUNDING_PART: f64 = 0.01;
/// Relative residuals at which equations count as solved: always, and where the line search fails.
const ROOT_TOLERANCES: [f64; 2] = [1e-8, 1e-6];
/// Residual along a step of Newton's method, over that before it, at which the line search ends.
const LINE_SEARCH_DROP: f64 = 0.5;
/// Relative width of the bracket of a kink at which the line search ends.
const BRACKET_WIDTH: f64 = 0.1;
/// Factor of a step length that goes too far, as long as none is known that does not.
const STEP_CUT: f64 = 0.1;
/// Step length below which the line search fails.
const LEAST_STEP: f64 = 1e-6;
/// Residual over the tolerance of sweeps at which a solve has converged, with friction before and after a
/// step: one more sweep would turn the friction of a node that slides with a great impulse by little only.
const CONVERGED_PART: f64 = 100.0;

/// The changes of the body's six rates: velocity, m/s, and angular velocity in body axes, rad/s.
type Six = [f64; 6];

/// Candidates whose impulses are sought, from those that they have.
pub(crate) struct Newton<'c> {
    pub candidates: &'c mut [Candidate],
    /// Friction of each candidate; none without friction.
    pub tangential: &'c mut [Tangential],
    pub inputs: &'c StepInputs<'c>,
    /// Rates of the body with these impulses.
    pub solved: Solved,
    /// Change of speed that sweeps may leave, m/s.
    pub tolerance: f64,
    /// rho of a fixed node over its effective mass.
    pub stiff: f64,
    /// Whether friction is that which the impulses so far allow.
    pub frozen: bool,
    /// Passes over the candidates so far.
    pub passes: u32,
}

/// Row of the contact Jacobian: one direction of a candidate.
struct JacobianRow {
    /// Speed of the body's surface along the direction for each of the body's six rates.
    entries: Six,
    /// Decrease of the six rates by a unit impulse.
    response: Six,
}

/// The six equations at some change of the rates, and their derivative.
struct Equations {
    residual: Six,
    jacobian: [Six; 6],
}

impl Newton<'_> {
    /// Goes on from a solve that was given up. What does not converge here either is scaled back.
    pub fn finish(mut self) -> Solved {
        let (mut before, mut was_near) = (f64::INFINITY, false);
        loop {
            let residual = self.residual();
            self.passes += 1;
            let is_near = residual <= CONVERGED_PART * self.tolerance;
            self.solved.residual = residual;
            self.solved.converged = is_near && (was_near || self.tangential.is_empty());
            if self.solved.converged || self.passes >= MAX_PASSES {
                break;
            }
            // The rounding of gap rates enters the impulses so many times over.
            if residual > 0.5 * before {
                self.stiff = math::max(SOFTENING * self.stiff, SOFTEST);
            }
            (before, was_near) = (residual, is_near);
            self.frozen = false;
            let mut change = self.root();
            if change.is_none() && residual > FROZEN_ABOVE * self.tolerance {
                self.frozen = true;
                change = self.root();
            }
            let Some(change) = change else { break };
            self.take(&change);
            self.passes += 1;
        }
        self.solved.sweeps += self.passes;
        if !self.solved.converged {
            self.scale_back();
            self.solved.residual = self.residual();
        }
        self.solved
    }

    /// Scales impulses that were given up on back until they add no energy.
    #[inline(never)]
    fn scale_back(&mut self) {
        let mut gain = Gain::of_body(self.inputs.body.twist(), self.inputs.inertia, &self.solved);
        for (k, c) in self.candidates.iter().enumerate() {
            let friction = self.tangential.get(k);
            gain.before += c.multiplicity * gain.work_before(c, friction);
            if !c.is_fixed() {
                let [p, q] = friction.map_or([0.0; 2], |t| t.impulse);
                gain.change += c.multiplicity * (c.impulse * c.impulse + (p * p + q * q)) / self.inputs.node_mass;
            }
        }
        self.solved = gain.scale_back(self.candidates, self.tangential, self.solved);
    }

    /// Residual of the laws of contact and friction, m/s: what one more sweep would change of the fastest.
    fn residual(&self) -> f64 {
        let mut worst = 0.0;
        for (k, c) in self.candidates.iter().enumerate() {
            if c.effective_mass == 0.0 {
                continue;
            }
            let (own, rate) = self.rate(c);
            let impulse = laws::projected_normal(c.impulse, rate, c.effective_mass);
            worst = math::max(math::abs(impulse - c.impulse) / c.effective_mass, worst);
            if let Some(t) = self.tangential.get(k)
                && t.effective_mass > 0.0
            {
                let [p, q] = t.impulse;
                let [s0, s1] = t.slip(&self.solved.twist);
                let next = t.next([s0 + p * own, s1 + q * own], self.inputs.friction * c.impulse);
                let change = math::length([next[0] - p, next[1] - q, 0.0]);
                worst = math::max(change / t.effective_mass, worst);
            }
        }
        worst
    }

    /// 1/m of a candidate's node, 1/kg, 0 if it is fixed, and how fast its gap grows, m/s.
    fn rate(&self, c: &Candidate) -> (f64, f64) {
        let own = if c.is_fixed() { 0.0 } else { 1.0 / self.inputs.node_mass };
        (own, c.gap_rate(&self.solved.twist) + c.impulse * own)
    }

    fn row(&self, direction: &Vector, arm: &Vector, multiplicity: f64) -> JacobianRow {
        let push = direction.component_mul(&self.inputs.symmetry.force_mask())
            * (multiplicity * self.inputs.inertia.inverse_mass);
        let twist =
            arm.component_mul(&self.inputs.symmetry.torque_mask()).component_mul(&self.inputs.inertia.inverse_moments)
                * multiplicity;
        let six = |v: &Vector, w: &Vector| [v.x, v.y, v.z, w.x, w.y, w.z];
        JacobianRow { entries: six(direction, arm), response: six(&push, &twist) }
    }

    /// The change of the rates that solves the six equations, if Newton's method finds it.
    fn root(&mut self) -> Option<Six> {
        let mut change = [0.0; 6];
        let mut at = self.equations(&change);
        let first = self.product(&at.residual, &at.residual);
        let [solved_below, enough_below] = ROOT_TOLERANCES.map(|part| part * part * first);
        // What rounding may leave.
        let rounding = ROUNDING_PART * self.tolerance;
        let solved_below = math::max(solved_below, self.inputs.inertia.mass * (rounding * rounding));
        loop {
            let square = self.product(&at.residual, &at.residual);
            if square <= solved_below {
                return Some(change);
            }
            let found = solution(&at).and_then(|step| self.line_search(&change, &step, &mut at));
            let Some(next) = found else { return (square <= enough_below).then_some(change) };
            change = next;
        }
    }

    /// Where a step of Newton's method ends: where it is whole, if that is nearer to the solution, or about
    /// the least of what the equations without friction are the gradient of, which is convex. `at`: the
    /// equations there.
    fn line_search(&mut self, change: &Six, step: &Six, at: &mut Equations) -> Option<Six> {
        let (square, along) = (self.product(&at.residual, &at.residual), self.product(&at.residual, step));
        // Parts of the step that are too short and too long.
        let (mut part, mut low, mut high) = (1.0, 0.0, 1.0);
        while self.passes < MAX_PASSES {
            let next = combined(change, -part, step);
            *at = self.equations(&next);
            let rest = self.product(&at.residual, step);
            let nearer = part == 1.0 && (rest > 0.0 || self.product(&at.residual, &at.residual) < square);
            // A kink ends a step, too.
            let at_kink = rest > 0.0 && high - low <= BRACKET_WIDTH * high;
            if nearer || at_kink || math::abs(rest) <= LINE_SEARCH_DROP * along {
                return Some(next);
            }
            [low, high] = if rest > 0.0 { [part, high] } else { [low, part] };
            if high < LEAST_STEP {
                return None;
            }
            part = if low > 0.0 { 0.5 * (low + high) } else { STEP_CUT * high };
        }
        None
    }

    /// The product of two changes of the rates in which their squares are twice the kinetic energy, J.
    fn product(&self, one: &Six, other: &Six) -> f64 {
        let Inertia { inverse_mass, inverse_moments, mass, moments, .. } = self.inputs.inertia;
        let [a, b, c, d, e, f] = core::array::from_fn(|k| one[k] * other[k]);
        let moves = if *inverse_mass > 0.0 { mass * (a + b + c) } else { 0.0 };
        let turns = *inverse_moments != Vector::zeros();
        moves + if turns { moments.x * d + moments.y * e + moments.z * f } else { 0.0 }
    }

    /// The equations where the body changes its rates by this: the change, and what the answers of the
    /// candidates take of the rates.
    fn equations(&mut self, change: &Six) -> Equations {
        self.passes += 1;
        let mut at = Equations { residual: *change, jacobian: [[0.0; 6]; 6] };
        (0..6).for_each(|k| at.jacobian[k][k] = 1.0);
        for (k, c) in self.candidates.iter().enumerate() {
            self.answer(k, c, change, |row, given, slope| at.add(row, given, slope));
        }
        at
    }

    /// Leaves the candidates the impulses with which they answer this change of the body's rates, and the
    /// body the rates that follow.
    fn take(&mut self, change: &Six) {
        let mut sum = [0.0; 6];
        for k in 0..self.candidates.len() {
            let Some(&c) = self.candidates.get(k) else { return };
            let [normal, p, q] = self.answer(k, &c, change, |row, given, _| sum = combined(&sum, given, &row.response));
            if let Some(slot) = self.candidates.get_mut(k) {
                slot.impulse = normal;
            }
            let Some(mut t) = self.tangential.get(k).copied() else { continue };
            // With frozen friction the normal impulse may now allow less.
            t.impulse = laws::limited([p, q], self.inputs.friction * normal);
            if self.frozen {
                let multiplicity = c.multiplicity;
                for (d, given) in [(0, t.impulse[0] - p), (1, t.impulse[1] - q)] {
                    sum = combined(&sum, given, &self.row(&t.tangents[d], &t.arms[d], multiplicity).response);
                }
            }
            if let Some(place) = self.tangential.get_mut(k) {
                *place = t;
            }
        }
        let [a, b, c, d, e, f] = sum;
        self.solved.twist.velocity -= Vector::new(a, b, c);
        self.solved.twist.angular_velocity -= Vector::new(d, e, f);
    }

    /// The impulses with which a candidate answers a change of the body's rates. `each` gets, for each of its
    /// directions, what more is given, and the derivative of that by the rates.
    #[inline(always)]
    fn answer(&self, k: usize, c: &Candidate, change: &Six, mut each: impl FnMut(&JacobianRow, f64, &Six)) -> [f64; 3] {
        let (own, rate) = self.rate(c);
        let rho = if c.is_fixed() { self.stiff * c.effective_mass } else { self.inputs.node_mass };
        let normal = self.row(&c.normal, &c.arm, c.multiplicity);
        let impulse = laws::projected_normal(c.impulse, rate - dot(&normal.entries, change), rho);
        let slope = if impulse > 0.0 { normal.entries.map(|x| rho * x) } else { [0.0; 6] };
        each(&normal, impulse - c.impulse, &slope);
        let Some(t) = self.tangential.get(k) else { return [impulse, 0.0, 0.0] };
        let rho = if c.is_fixed() { self.stiff * t.effective_mass } else { self.inputs.node_mass };
        let rows = [0, 1].map(|d| self.row(&t.tangents[d], &t.arms[d], c.multiplicity));
        let slip = t.slip(&self.solved.twist);
        let slip = [0, 1].map(|d| slip[d] + t.impulse[d] * own - dot(&rows[d].entries, change));
        let trial = laws::trial_friction(t.impulse, slip, rho);
        let (most, grows) = if self.frozen { (c.impulse, 0.0) } else { (impulse, self.inputs.friction) };
        let (most, size) = (self.inputs.friction * most, math::length([trial[0], trial[1], 0.0]));
        let next = laws::limited(trial, most);
        // A node that slides: the disc grows with the normal impulse, and the direction turns.
        let slides = size > most;
        let turns = if slides { rho * (most / size) } else { rho };
        let along = if slides { trial.map(|p| p / size) } else { [0.0; 2] };
        let radial: Six = core::array::from_fn(|l| along[0] * rows[0].entries[l] + along[1] * rows[1].entries[l]);
        for d in 0..2 {
            let slope_of = |l: usize| turns * (rows[d].entries[l] - along[d] * radial[l]) + grows * along[d] * slope[l];
            each(&rows[d], next[d] - t.impulse[d], &core::array::from_fn(slope_of));
        }
        [impulse, next[0], next[1]]
    }
}

impl Equations {
    #[inline(always)]
    fn add(&mut self, row: &JacobianRow, given: f64, slope: &Six) {
        for k in 0..6 {
            self.residual[k] += row.response[k] * given;
            for (sum, part) in self.jacobian[k].iter_mut().zip(slope) {
                *sum += row.response[k] * part;
            }
        }
    }
}

fn dot(a: &Six, b: &Six) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + (a[3] * b[3] + a[4] * b[4] + a[5] * b[5])
}

/// a + part b.
fn combined(a: &Six, part: f64, b: &Six) -> Six {
    core::array::from_fn(|k| a[k] + part * b[k])
}

/// Solution of the equations `jacobian` times it is `residual`, by elimination in order: without friction no
/// pivot is less than 1. None if there is one close to 0.
fn solution(at: &Equations) -> Option<Six> {
    let (mut rows, mut right) = (at.jacobian, at.residual);
    for k in 0..6 {
        let (pivot, of_pivot) = (rows[k], right[k]);
        if pivot[k].is_nan() || math::abs(pivot[k]) <= f64::EPSILON {
            return None;
        }
        for i in k + 1..6 {
            let factor = rows[i][k] / pivot[k];
            for l in k..6 {
                rows[i][l] -= factor * pivot[l];
            }
            right[i] -= factor * of_pivot;
        }
    }
    for k in (0..6).rev() {
        let mut rest = right[k];
        for l in k + 1..6 {
            rest -= rows[k][l] * right[l];
        }
        right[k] = rest / rows[k][k];
    }
    Some(right)
}
