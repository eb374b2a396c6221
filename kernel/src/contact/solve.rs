//! Impulse contact of the nodes with the rigid projectile, equal and opposite on it. Restitution zero;
//! friction (`friction.rs`) if asked for. A fixed node is a node of infinite mass: its support takes the
//! impulse, and what the body loses there is lost.
//!
//! Method: for every candidate node (gap phi < h at t_n) an impulse lambda >= 0 along the outward normal n,
//! complementary to the gap rate phi/dt + n.(v - V' - w' x r) >= 0 at the end of the step (0 in place of
//! phi/dt for a node already inside), solved together by projected Gauss-Seidel in node order from
//! lambda = 0. The gap of a convex body is convex, so the node stays outside; no position is projected and no
//! energy is put into the yarns. Who is a candidate: `search.rs`, and which of them the body gets past beside
//! an edge: `edge.rs`. What sweeps do not settle goes on in `newton.rs`.
//! Limits: penetration-free for converged solves (others are counted, with what is left over, and never add
//! energy: impulses that would are all scaled back). A prescribed body passes through fixed nodes: neither
//! has a compliance. A node that slides on a turning body gets into it by second order in dt a step.
//! Reference: J. J. Moreau, in: Nonsmooth Mechanics and Applications (1988); M. Jean, Comput. Methods Appl.
//! Mech. Engrg. 177 (1999) 235.

use crate::body::pose::Vector;
use crate::body::projectile::{Body, Inertia, Twist};
use crate::contact::candidate::{Solved, StepInputs};
use crate::contact::laws;
use crate::contact::newton::{Newton, STIFF};
use crate::ground::math;
use crate::memory::arrays::Contacts;
use crate::memory::network::Network;
use crate::memory::records::{Candidate, Tangential};
use crate::scene::features::Feature;
use crate::scene::parts::Symmetry;

/// Most sweeps before Newton's method; in a stack without supports before giving up.
pub const MAX_SWEEPS: u32 = 200;
/// Most impulses computed in sweeps; many candidates shorten [`MAX_SWEEPS`] by it, to no less than
/// [`LEAST_SWEEPS`].
pub const MAX_UPDATES: usize = 200_000;
/// Least number of sweeps that [`MAX_UPDATES`] leaves.
pub const LEAST_SWEEPS: u32 = 20;

/// Rounding of a gap rate, in parts of the speeds that it is the difference of: nine times half a last place,
/// three of n.V, three of arm.w, and one each of the impulse, of the speed it gives and of the difference.
/// The number of nodes does not enter: impulses this small no longer change the velocity of a body that is
/// heavier than a few nodes.
const ROUNDING: f64 = 1e-15;

/// A candidate whose gap grows faster than this part of the speed of the body's surface takes no impulse,
/// unless the others change the velocity of the body that far.
const LEFT_OUT_ABOVE: f64 = 0.01;

/// Change of speed in a sweep at which sweeps have converged, in parts of the fastest gap rate or slip before
/// contact: some fifty roundings.
const CONVERGED: f64 = 1e-14;

/// Part of a reach that the body's velocity may use up before the candidates beyond it are solved, too. The
/// rest is a margin for rounding and for what convergence leaves.
pub(crate) const USED_REACH: f64 = 0.9;

/// (M8) Finds the impulses of all candidates. A node of a graded network stands for several of the mass
/// given, which move alike: its impulse is that on one of them. `effective_mass` and `impulse` of the
/// candidates are set here. Beyond mirror planes the images of a node get the images of its impulse: what
/// they do together to the body is `multiplicity` times the part of one that the planes leave. Where sweeps
/// do not settle, Newton's method goes on from there. `tangential`: one for each candidate with friction
/// (M21), none without.
pub fn solve(candidates: &mut [Candidate], tangential: &mut [Tangential], inputs: &StepInputs<'_>) -> Solved {
    let StepInputs { body, inertia, node_mass, symmetry, friction } = *inputs;
    let has_friction = Feature::Friction.is_built() && !tangential.is_empty();
    let (solved, tolerance) = if has_friction {
        sweeps::<true>(candidates, tangential, friction, body, inertia, node_mass, symmetry)
    } else {
        sweeps::<false>(candidates, tangential, friction, body, inertia, node_mass, symmetry)
    };
    if solved.converged {
        return solved;
    }
    Newton { candidates, tangential, inputs, solved, tolerance, stiff: STIFF, frozen: false, passes: 0 }.finish()
}

/// Compliances of the body and of the nodes, which all have the same mass.
#[derive(Clone, Copy)]
struct Compliances<'s> {
    inertia: &'s Inertia,
    /// Mass of a free node, kg, and its inverse, 1/kg.
    node_mass: f64,
    inverse_node_mass: f64,
    symmetry: Symmetry,
    /// Factors by which mirror planes keep the components of a force and of a torque, 0 or 1.
    masks: [Vector; 2],
    /// Whether there is no mirror plane.
    whole: bool,
    /// Whether the body turns, now or by contact: the arms of a sphere without friction are exactly zero.
    turns: bool,
    /// Effective mass of a node of multiplicity 1 on a body that does not turn, kg.
    plain_mass: f64,
    /// Whether any node is held.
    supported: bool,
}

/// Sizes that a solve is judged by.
#[derive(Clone, Copy, Default)]
struct Sizes {
    /// Largest gap rate or slip before contact, m/s.
    fastest: f64,
    /// Square of the longest arm, m^2.
    farthest: f64,
    greatest_multiplicity: f64,
}

impl<'s> Compliances<'s> {
    fn of(body: &Body, inertia: &'s Inertia, node_mass: f64, symmetry: Symmetry) -> Compliances<'s> {
        let inverse_node_mass = 1.0 / node_mass;
        Compliances {
            inertia,
            node_mass,
            inverse_node_mass,
            symmetry,
            masks: [symmetry.force_mask(), symmetry.torque_mask()],
            whole: symmetry == Symmetry::default(),
            turns: body.angular_velocity != Vector::zeros() || inertia.inverse_moments != Vector::zeros(),
            plain_mass: 1.0 / (inverse_node_mass + inertia.inverse_mass),
            supported: false,
        }
    }

    #[inline(always)]
    fn is_alone(&self, c: &Candidate) -> bool {
        self.whole && c.multiplicity == 1.0
    }

    #[inline(always)]
    fn push(&self, c: &Candidate) -> Vector {
        if self.is_alone(c) { c.normal } else { c.normal.component_mul(&self.masks[0]) * c.multiplicity }
    }

    #[inline(always)]
    fn moment(&self, c: &Candidate) -> Vector {
        if self.is_alone(c) { c.arm } else { c.arm.component_mul(&self.masks[1]) * c.multiplicity }
    }

    /// Inverse mass of a node, 1/kg; 0 of a fixed one.
    #[inline(always)]
    fn inverse_mass(&self, c: &Candidate) -> f64 {
        if c.is_fixed() { 0.0 } else { self.inverse_node_mass }
    }

    #[inline(always)]
    fn effective_mass(&self, c: &Candidate) -> f64 {
        if !self.turns && self.is_alone(c) && !c.is_fixed() {
            return self.plain_mass;
        }
        let turning = c.arm.dot(&self.moment(c).component_mul(&self.inertia.inverse_moments));
        let moving = if self.whole { c.multiplicity } else { c.normal.dot(&self.push(c)) };
        let compliance = self.inverse_mass(c) + self.inertia.inverse_mass * moving + turning;
        if compliance > 0.0 { 1.0 / compliance } else { 0.0 }
    }

    #[inline(always)]
    fn gap_rate(&self, c: &Candidate, rates: &Twist) -> f64 {
        if self.turns { c.gap_rate(rates) } else { c.free_gap_rate - c.normal.dot(&rates.velocity) }
    }

    /// Prepares all candidates but for their masses.
    #[inline(always)]
    fn begin(&mut self, candidates: &mut [Candidate], rates: &Twist) -> Sizes {
        let mut sizes = Sizes::default();
        for c in candidates {
            self.supported |= c.is_fixed();
            sizes.greatest_multiplicity = math::max(c.multiplicity, sizes.greatest_multiplicity);
            let gap_rate = self.gap_rate(c, rates);
            sizes.fastest = math::max(math::abs(gap_rate), sizes.fastest);
            if self.turns {
                sizes.farthest = math::max(c.arm.dot(&c.arm), sizes.farthest);
            }
            c.impulse = 0.0;
        }
        sizes
    }

    /// Prepares the tangential parts of the candidates.
    fn begin_friction(
        &self,
        candidates: &[Candidate],
        tangential: &mut [Tangential],
        rates: &Twist,
        sizes: &mut Sizes,
    ) {
        for (c, t) in candidates.iter().zip(tangential) {
            t.begin(self.inertia, self.inverse_mass(c), self.symmetry, c.multiplicity);
            for (slip, arm) in t.slip(rates).into_iter().zip(t.arms) {
                sizes.fastest = math::max(math::abs(slip), sizes.fastest);
                sizes.farthest = math::max(arm.dot(&arm), sizes.farthest);
            }
        }
    }

    /// The masses of candidates. Of what is out of reach it is 0, so that no sweep changes it.
    fn set_masses(&self, candidates: &mut [Candidate], rates: &Twist, out_of_reach: f64) {
        for c in candidates {
            let is_far = self.gap_rate(c, rates) > out_of_reach;
            c.effective_mass = if is_far { 0.0 } else { self.effective_mass(c) };
        }
    }

    /// One sweep over all candidates, in their order. Returns the largest change of an impulse, in that of a
    /// node's, and adds to the sum of changes.
    #[inline(always)]
    fn sweep<const FRICTION: bool>(
        &self,
        candidates: &mut [Candidate],
        tangential: &mut [Tangential],
        coefficient: f64,
        rates: &mut Twist,
        changes: &mut f64,
    ) -> f64 {
        let mut largest_change = 0.0;
        for (k, slot) in candidates.iter_mut().enumerate() {
            let mut c = *slot;
            if !FRICTION && c.effective_mass == 0.0 {
                continue;
            }
            let fixed = self.supported && c.is_fixed();
            if c.impulse > 0.0 {
                c.free_gap_rate += if fixed { 0.0 } else { c.impulse / self.node_mass };
            }
            let gap_rate = self.gap_rate(&c, rates);
            let impulse = laws::projected_normal(c.impulse, gap_rate, c.effective_mass);
            let change = impulse - c.impulse;
            if change != 0.0 {
                rates.velocity -= self.push(&c) * (change * self.inertia.inverse_mass);
                if self.turns {
                    let turned = self.moment(&c).component_mul(&self.inertia.inverse_moments);
                    rates.angular_velocity -= turned * change;
                }
                slot.impulse = impulse;
                let mut size = math::abs(change);
                *changes += size;
                if fixed {
                    // A change of speed is what counts, and here the mass that changes it is the body's.
                    size *= self.node_mass / c.effective_mass;
                }
                largest_change = math::max(size, largest_change);
            }
            if FRICTION && let Some(t) = tangential.get_mut(k) {
                let size = self.solve_friction(&c, coefficient * impulse, t, rates);
                largest_change = math::max(size, largest_change);
            }
        }
        largest_change
    }

    /// Friction of one candidate up to the impulse `most`. Returns the change.
    #[inline(always)]
    fn solve_friction(&self, c: &Candidate, most: f64, t: &mut Tangential, rates: &mut Twist) -> f64 {
        let own = self.inverse_mass(c);
        let [s0, s1] = t.slip(rates);
        let [p, q] = t.impulse;
        let next = t.next([s0 + p * own, s1 + q * own], most);
        let change = [next[0] - p, next[1] - q];
        if change == [0.0; 2] {
            return 0.0;
        }
        rates.velocity -=
            t.as_vector(change).component_mul(&self.masks[0]) * (c.multiplicity * self.inertia.inverse_mass);
        let moment = t.moment(change).component_mul(&self.masks[1]) * c.multiplicity;
        rates.angular_velocity -= moment.component_mul(&self.inertia.inverse_moments);
        t.impulse = next;
        let size = math::max(math::abs(change[0]), math::abs(change[1]));
        if c.is_fixed() { size * (self.node_mass / t.effective_mass) } else { size }
    }
}

/// The sweeps of both solves: without friction the compiler leaves out what belongs to it. Returns also the
/// change of speed in a sweep below which a solve has settled, m/s. References that stand in a structure
/// would be read again for every candidate: here each is an argument.
fn sweeps<const FRICTION: bool>(
    candidates: &mut [Candidate],
    tangential: &mut [Tangential],
    coefficient: f64,
    body: &Body,
    inertia: &Inertia,
    node_mass: f64,
    symmetry: Symmetry,
) -> (Solved, f64) {
    let mut compliances = Compliances::of(body, inertia, node_mass, symmetry);
    let mut rates = body.twist();
    let mut sizes = compliances.begin(candidates, &rates);
    if FRICTION {
        compliances.begin_friction(candidates, tangential, &rates, &mut sizes);
    }
    // The speeds that a gap rate is the difference of.
    let moving = rates.fastest(math::sqrt(sizes.farthest));
    let (relative, rounding) = (CONVERGED * sizes.fastest, ROUNDING * moving);
    let tolerance = node_mass * math::max(relative, rounding);
    // A node whose gap grows is left out, as long as what all changes of the impulses together can do to the
    // body, however they add up, changes the speed of its surface by less than that: it would take no
    // impulse.
    let follows = sizes.greatest_multiplicity * (inertia.inverse_mass + sizes.farthest * inertia.inverse_moments.max());
    let mut out_of_reach = if FRICTION { f64::INFINITY } else { LEFT_OUT_ABOVE * moving };
    compliances.set_masses(candidates, &rates, out_of_reach);
    let (mut sweeps, mut converged, mut changes) = (0, false, 0.0);
    let most = LEAST_SWEEPS.max(MAX_SWEEPS.min((MAX_UPDATES / candidates.len().max(1)) as u32));
    while sweeps < most && !converged {
        let largest = compliances.sweep::<FRICTION>(candidates, tangential, coefficient, &mut rates, &mut changes);
        sweeps += 1;
        converged = largest <= tolerance;
        let followed = changes * follows < USED_REACH * out_of_reach;
        if out_of_reach < f64::INFINITY && !followed {
            // Once more from the start, with all of them.
            (out_of_reach, sweeps, converged) = (f64::INFINITY, 0, false);
            rates = body.twist();
            candidates.iter_mut().for_each(|c| c.effective_mass = compliances.effective_mass(c));
            candidates.iter_mut().for_each(|c| c.impulse = 0.0);
        }
    }
    if !converged {
        candidates.iter_mut().for_each(|c| c.effective_mass = compliances.effective_mass(c));
    }
    (Solved { sweeps, converged, twist: rates, residual: 0.0 }, tolerance / node_mass)
}

/// The impulses of the first `count` candidates of a single sheet. `body`: with its velocity before contact.
pub(crate) fn solve_first(network: &Network<'_>, contacts: &mut Contacts<'_>, body: &Body, count: usize) -> Solved {
    let Network { scene, model, .. } = network;
    let inputs = StepInputs {
        body,
        inertia: &model.inertia,
        node_mass: model.node_mass,
        symmetry: scene.symmetry,
        friction: scene.contact.friction,
    };
    let Contacts { candidates, tangential, .. } = contacts;
    let slots = candidates.get_mut(..count).unwrap_or_default();
    solve(slots, tangential.get_mut(..count).unwrap_or_default(), &inputs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::shape::Solid;
    use crate::contact::candidate::Holder;
    use crate::scene::parts::Scene;
    use crate::tests::{close, number, sphere};
    use std::vec::Vec;

    fn solve(slots: &mut [Candidate], body: &Body, inertia: &Inertia, node_mass: f64, symmetry: Symmetry) -> Solved {
        super::solve(slots, &mut [], &StepInputs { body, inertia, node_mass, symmetry, friction: 0.0 })
    }

    /// A turning rod of the mass of `nodes` nodes of a gram.
    fn rod(nodes: f64, movable: bool) -> (Inertia, Body) {
        let solid = Solid::of(&Scene::sheet_10in_cylinder().projectile);
        let body = Body {
            velocity: Vector::new(3.0, -2.0, 80.0),
            angular_velocity: Vector::new(400.0, -700.0, 250.0),
            ..sphere().1
        };
        (Inertia::of(&solid, nodes * NODE, movable), body)
    }
    const NODE: f64 = 1e-3;

    fn armed(normal: Vector, arm: Vector, multiplicity: f64, free_gap_rate: f64) -> Candidate {
        Candidate { normal, arm, multiplicity, free_gap_rate, ..Candidate::default() }
    }

    #[test]
    fn one_node_off_the_axis_takes_the_impulse_of_rigid_body_mechanics() {
        let (normal, arm) = (Vector::new(0.48, -0.6, 0.64), Vector::new(4e-3, -0.011, 7e-3));
        for (movable, turning) in [(true, true), (true, false), (false, true), (false, false)] {
            let (inertia, mut body) = rod(5.0, movable);
            if !turning {
                body.angular_velocity = Vector::zeros();
            }
            let mut slots = [armed(normal, arm, 1.0, -7.0)];
            let solved = solve(&mut slots, &body, &inertia, NODE, Symmetry::default());
            let gap_rate = normal.dot(&body.velocity) + arm.dot(&body.angular_velocity) + 7.0;
            let (mass, moments) = (5.0 * NODE, inertia.moments);
            let compliance =
                if movable { 1.0 / mass + arm.component_mul(&arm).component_div(&moments).sum() } else { 0.0 };
            let impulse = gap_rate / (1.0 / NODE + compliance);
            let found = slots[0];
            assert!(solved.converged && solved.sweeps <= 3 && gap_rate > 0.0);
            close(found.impulse, impulse, 1e-13);
            close(found.effective_mass, 1.0 / (1.0 / NODE + compliance), 1e-14);
            let taken = if movable { impulse } else { 0.0 };
            assert!((solved.twist.velocity - (body.velocity - normal * (taken / mass))).norm() < 1e-11);
            let rate = body.angular_velocity - arm.component_div(&moments) * taken;
            assert!((solved.twist.angular_velocity - rate).norm() < 1e-9);
        }
    }

    #[test]
    fn complementarity_on_a_body_that_turns() {
        let (mut pushed, mut let_go, mut given_up) = (0, 0, 0);
        for k in 0..3000 {
            let draw = |m: u64| number(64 * k + m);
            let (inertia, body) = rod(math::exp(3.0 * draw(60)) * 3.0, true);
            let mut slots: [_; 6] = core::array::from_fn(|node| {
                let draw = |m: u64| draw(8 * node as u64 + m);
                let normal = Vector::new(draw(0), draw(1), 1.0 + draw(2)).normalize();
                let arm = Vector::new(0.02 * draw(3), 0.02 * draw(4), 0.006 * draw(5));
                armed(normal, arm, 1.0, 60.0 * draw(6))
            });
            let solved = solve(&mut slots, &body, &inertia, NODE, Symmetry::default());
            if !solved.converged {
                given_up += 1;
                continue;
            }
            for c in slots {
                let surface = c.normal.dot(&solved.twist.velocity) + c.arm.dot(&solved.twist.angular_velocity);
                let gap_rate = c.free_gap_rate + c.impulse / NODE - surface;
                assert!(c.impulse >= 0.0 && gap_rate > -1e-10, "{k} {gap_rate:e}");
                assert!(c.impulse == 0.0 || gap_rate < 1e-10, "{k} {gap_rate:e}");
                pushed += usize::from(c.impulse > 0.0);
                let_go += usize::from(c.impulse == 0.0);
            }
        }
        assert!(pushed > 1000 && let_go > 1000 && given_up < 10, "{pushed} {let_go} {given_up}");
    }

    /// A light body that a node throws back at ten times its speed meets a node that went away too fast for
    /// it before.
    #[test]
    fn a_body_that_is_thrown_back_meets_what_was_out_of_its_reach() {
        let (inertia, mut body) = rod(0.01, true);
        (body.velocity, body.angular_velocity) = (Vector::z(), Vector::zeros());
        let up = armed(Vector::z(), Vector::zeros(), 1.0, -10.0);
        let far = armed(-Vector::z(), Vector::zeros(), 1.0, 3.0);
        for mut slots in [[up, far], [far, up]] {
            let solved = solve(&mut slots, &body, &inertia, NODE, Symmetry::default());
            assert!(solved.twist.velocity.z < -2.5 && slots.iter().all(|c| c.impulse > 0.0), "{solved:?}");
        }
    }

    #[test]
    fn nodes_out_of_reach_change_no_bit() {
        for k in 0..200 {
            let draw = |m: u64| number(100 * k + m);
            // The velocity of a light body changes so far that all are solved, that of a heavy one does not.
            let heavy = k % 2 == 1;
            let (inertia, body) = rod(if heavy { 1e5 } else { 100.0 }, true);
            // The first one sets the tolerance: it is the farthest.
            let mut near: Vec<_> = Vec::from([armed(Vector::x(), Vector::zeros(), 1.0, 1e4)]);
            let mut all = near.clone();
            for node in 0..12 {
                let draw = |m: u64| draw(8 * node + m);
                let normal = Vector::new(draw(0), draw(1), 1.0 + draw(2)).normalize();
                let arm = Vector::new(0.02 * draw(3), 0.02 * draw(4), 0.006 * draw(5));
                near.push(armed(normal, arm, 1.0, 60.0 * draw(6)));
                // A gap that grows at 5 m/s, or faster.
                let surface = normal.dot(&body.velocity) + arm.dot(&body.angular_velocity);
                let leaving =
                    if heavy { armed(normal, arm, 1.0, surface + 5.0) } else { armed(-normal, arm, 1.0, 900.0) };
                all.extend([leaving, near[near.len() - 1]]);
            }
            let alone = solve(&mut near, &body, &inertia, NODE, Symmetry::default());
            let among = solve(&mut all, &body, &inertia, NODE, Symmetry::default());
            assert_eq!(alone, among);
            let left_out = all.iter().filter(|c| c.effective_mass == 0.0).count();
            assert!(!heavy || left_out >= 13, "{left_out}");
            let pushed = |slots: &[Candidate]| -> Vec<f64> {
                slots.iter().map(|c| c.impulse).filter(|impulse| *impulse > 0.0).collect()
            };
            assert_eq!(pushed(&near), pushed(&all));
        }
    }

    /// A body of a hundredth of a node's mass among twenty nodes: sweeps pass its velocity on from node to
    /// node for long.
    #[test]
    fn what_sweeps_do_not_finish_newtons_method_does() {
        let (inertia, mut body) = rod(0.01, true);
        body.angular_velocity = Vector::zeros();
        let mut slots: Vec<_> = (0..20).map(|k| armed(Vector::z(), Vector::zeros(), 1.0, 0.01 * number(k))).collect();
        let solved = solve(&mut slots, &body, &inertia, NODE, Symmetry::default());
        assert!(solved.converged && solved.sweeps > MAX_SWEEPS && solved.sweeps < MAX_SWEEPS + 20, "{solved:?}");
        assert!(solved.residual <= 1e-13 * body.velocity.z);
        let energy = |speed: f64, nodes: f64| 0.5 * inertia.mass * speed * speed + 0.5 * NODE * nodes;
        let nodes = |after: f64| -> f64 {
            let speed = |c: &Candidate| c.free_gap_rate + after * c.impulse / NODE;
            slots.iter().map(|c| speed(c) * speed(c)).sum()
        };
        assert!(energy(solved.twist.velocity.z, nodes(1.0)) <= energy(body.velocity.z, nodes(0.0)));
    }

    /// Fixed nodes whose normals differ by little: each sweep leaves cos^2 of their angle of an error. A body
    /// that moves against both stops along them, and keeps what is across them.
    #[test]
    fn a_body_in_a_narrow_wedge_of_fixed_nodes_stops() {
        for angle in [0.3, 1e-2, 1e-4] {
            let (inertia, mut body) = rod(5.0, true);
            (body.velocity, body.angular_velocity) = (Vector::new(2.0, -7.0, 40.0), Vector::zeros());
            let normal = |angle: f64| Vector::new(math::sin(angle), 0.0, math::cos(angle));
            let held = |angle: f64| Candidate {
                held_by: Holder::Support as u32,
                ..armed(normal(angle), Vector::zeros(), 1.0, 0.0)
            };
            // Between them the body is pressed from both sides along x.
            let mut slots = [held(angle), held(-angle)];
            let solved = solve(&mut slots, &body, &inertia, NODE, Symmetry::default());
            assert!(solved.converged && solved.sweeps <= MAX_SWEEPS + 100, "{angle}: {solved:?}");
            let [left, right] = slots;
            let surfaces = [&left, &right].map(|c| c.normal.dot(&solved.twist.velocity));
            let presses = 40.0 * math::sin(angle) > 2.0 * math::cos(angle);
            assert!(surfaces.iter().all(|speed| *speed < 1e-9), "{angle}: {surfaces:?}");
            if presses {
                assert!(
                    solved.twist.velocity.x.abs() < 1e-8 && solved.twist.velocity.z.abs() < 1e-9,
                    "{angle}: {solved:?}"
                );
            }
            assert!((solved.twist.velocity.y + 7.0).abs() < 1e-12 && left.impulse > 0.0);
        }
    }

    #[test]
    fn one_node_on_a_sphere_is_solved_at_once() {
        // A sphere of three nodes' mass that does not turn; alone, and with its three images beyond two
        // planes: then the body takes the impulse along z four times over.
        let (solid, body) = sphere();
        let inertia = Inertia::of(&solid, 3.0 * NODE, true);
        let normal = Vector::new(0.48, -0.6, 0.64);
        let planes = Symmetry { mirror_x: true, mirror_y: true };
        for (symmetry, multiplicity, moved) in
            [(Symmetry::default(), 1.0, normal), (planes, 4.0, Vector::new(0.0, 0.0, 0.64))]
        {
            let mut slots = [armed(normal, Vector::zeros(), multiplicity, -7.0)];
            let solved = solve(&mut slots, &body, &inertia, NODE, symmetry);
            let compliance = 1.0 / NODE + multiplicity * normal.dot(&moved) / (3.0 * NODE);
            let impulse = (0.64 * 100.0 + 7.0) / compliance;
            let found = slots[0];
            assert!(solved.converged && solved.sweeps <= 2, "{solved:?}");
            close(found.effective_mass, 1.0 / compliance, 1e-14);
            close(found.impulse, impulse, 1e-13);
            assert!(
                (solved.twist.velocity - (body.velocity - moved * (multiplicity * impulse / (3.0 * NODE)))).norm()
                    < 1e-12
            );
        }
    }
}
