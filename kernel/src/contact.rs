//! Impulse contact of the nodes with the rigid projectile, equal and opposite on it. Frictionless, restitution zero.
//!
//! Method: for every candidate node (gap phi < h at t_n) an impulse lambda >= 0 along the outward normal n, complementary to
//! the gap rate phi/dt + n.(v - V' - w' x r) >= 0 at the end of the step (0 in place of phi/dt for a node already inside),
//! solved together by projected Gauss-Seidel in node order from lambda = 0. The gap of a convex body is convex, so the node
//! stays outside; no position is projected and no energy is put into the yarns.
//! Limits: penetration-free for converged solves (200 sweeps at the most; unconverged solves are counted and never add energy).
//! Rotation makes the non-penetration second order in dt.
//! Reference: J. J. Moreau, in: Nonsmooth Mechanics and Applications (1988); M. Jean, Comput. Methods Appl. Mech. Engrg. 177 (1999) 235.

use crate::layout::CANDIDATE_REALS;
use crate::pose::Vector;
use crate::projectile::{self, Body, Inertia};
use crate::scene::Symmetry;
use crate::shape::Solid;

/// Sweeps after which a solve is given up and counted.
pub const MAX_SWEEPS: u32 = 200;

/// One candidate node.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// Displacement at t_n, spacings.
    pub displacement: [f64; 3],
    /// Outward normal in the sheet's frame.
    pub normal: Vector,
    /// r x n in body axes, m: the arm of the impulse.
    pub arm: Vector,
    /// How often the node appears in the whole sheet: 1 without mirror planes.
    pub weight: f64,
    /// n.v at t_{n-1/2}, m/s.
    pub speed_before: f64,
    /// phi/dt, m/s (0 for a node inside), and, once the sweep is done, phi/dt + n.v_free.
    pub approach: f64,
    /// 1/(1/m + 1/M + arm.I^-1 arm), kg; with mirror planes the body's part is that of all images together.
    pub effective_mass: f64,
    /// Impulse, N s; the last number of the slot.
    pub impulse: f64,
}

impl Candidate {
    /// From its place in the scratch block.
    pub fn read(slot: &[f64; CANDIDATE_REALS]) -> Candidate {
        let [ux, uy, uz, nx, ny, nz, ax, ay, az, weight, speed_before, approach, effective_mass, impulse] = *slot;
        Candidate {
            displacement: [ux, uy, uz],
            normal: Vector::new(nx, ny, nz),
            arm: Vector::new(ax, ay, az),
            weight,
            speed_before,
            approach,
            effective_mass,
            impulse,
        }
    }

    /// Into its place in the scratch block.
    pub fn write(&self, slot: &mut [f64; CANDIDATE_REALS]) {
        let ([ux, uy, uz], n, a) = (self.displacement, self.normal, self.arm);
        *slot = [
            ux,
            uy,
            uz,
            n.x,
            n.y,
            n.z,
            a.x,
            a.y,
            a.z,
            self.weight,
            self.speed_before,
            self.approach,
            self.effective_mass,
            self.impulse,
        ];
    }
}

/// The body as the search for candidates sees it.
pub struct Search<'s> {
    solid: &'s Solid,
    body: Body,
    half: [f64; 3],
    margin: f64,
}

impl<'s> Search<'s> {
    /// Prepares a search for nodes closer than `margin` (the node spacing, m).
    pub fn new(solid: &'s Solid, body: &Body, margin: f64) -> Search<'s> {
        // A little more than the margin, so that rounding never hides a candidate; the exact test follows.
        let half = solid.half_extents(&body.orientation).map(|extent| extent + margin * (1.0 + 1e-9));
        Search { solid, body: *body, half, margin }
    }

    /// Whether any of the y values from `low` to `high`, m, lies in the body's box.
    pub fn meets_row(&self, low: f64, high: f64) -> bool {
        high >= self.body.position.y - self.half[1] && low <= self.body.position.y + self.half[1]
    }

    /// Whether the x value, m, lies in the body's box.
    pub fn meets_column(&self, x: f64) -> bool {
        let r = x - self.body.position.x;
        r <= self.half[0] && r >= -self.half[0]
    }

    /// Gap, normal in the sheet's frame and arm in body axes of the point `x`, if it is a candidate.
    pub fn candidate(&self, x: &Vector) -> Option<(f64, Vector, Vector)> {
        let r = x - self.body.position;
        let outside = |k: usize| r[k] > self.half[k] || r[k] < -self.half[k];
        if outside(0) || outside(1) || outside(2) {
            return None;
        }
        let q = &self.body.orientation;
        if !self.solid.feels_torque() {
            // A sphere needs no body axes: its gap depends on the distance alone.
            let gap = self.solid.gap(&r);
            return (gap.distance < self.margin).then_some((gap.distance, gap.normal, Vector::zeros()));
        }
        let r_body = projectile::into_body(q, &r);
        let gap = self.solid.gap(&r_body);
        (gap.distance < self.margin)
            .then(|| (gap.distance, projectile::out_of_body(q, &gap.normal), r_body.cross(&gap.normal)))
    }
}

/// What a solve did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solved {
    /// Sweeps taken.
    pub sweeps: u32,
    /// false if the sweeps ran out.
    pub converged: bool,
    /// Body velocity after contact.
    pub velocity: Vector,
    /// Body angular velocity after contact, body axes.
    pub angular_velocity: Vector,
}

/// Finds the impulses of all candidates. `body` carries the velocities before contact; `node_mass` in kg.
/// Every candidate's `approach` is set; `effective_mass` and `impulse` are set here.
/// Behind mirror planes the images of a node get the images of its impulse: what they do together to the body is `weight`
/// times the part of one that the planes leave.
pub fn solve(
    candidates: &mut [[f64; CANDIDATE_REALS]],
    body: &Body,
    inertia: &Inertia,
    node_mass: f64,
    symmetry: Symmetry,
) -> Solved {
    let (push_mask, twist_mask) = (symmetry.force_mask(), symmetry.torque_mask());
    let push = |c: &Candidate| c.normal.component_mul(&push_mask) * c.weight;
    let twist = |c: &Candidate| c.arm.component_mul(&twist_mask) * c.weight;
    let mut velocity = body.velocity;
    let mut rate = body.angular_velocity;
    let inverse_node_mass = 1.0 / node_mass;
    let mut fastest = 0.0;
    for slot in candidates.iter_mut() {
        let mut c = Candidate::read(slot);
        let turning = c.arm.dot(&twist(&c).component_mul(&inertia.inverse_moments));
        let moving = if symmetry == Symmetry::default() { 1.0 } else { c.normal.dot(&push(&c)) };
        c.effective_mass = 1.0 / (inverse_node_mass + inertia.inverse_mass * moving + turning);
        c.impulse = 0.0;
        c.write(slot);
        let approach = c.approach - c.normal.dot(&velocity) - c.arm.dot(&rate);
        let size = if approach < 0.0 { -approach } else { approach };
        fastest = if size > fastest { size } else { fastest };
    }
    let tolerance = 1e-14 * node_mass * fastest;
    for sweep in 1..=MAX_SWEEPS {
        let mut largest_change = 0.0;
        for slot in candidates.iter_mut() {
            let c = Candidate::read(slot);
            let gap_rate = c.approach + c.impulse / node_mass - c.normal.dot(&velocity) - c.arm.dot(&rate);
            let trial = c.impulse - gap_rate * c.effective_mass;
            let impulse = if trial > 0.0 { trial } else { 0.0 };
            let change = impulse - c.impulse;
            if change != 0.0 {
                velocity -= push(&c) * (change * inertia.inverse_mass);
                rate -= twist(&c).component_mul(&inertia.inverse_moments) * change;
                slot[CANDIDATE_REALS - 1] = impulse;
                let size = if change < 0.0 { -change } else { change };
                largest_change = if size > largest_change { size } else { largest_change };
            }
        }
        if largest_change <= tolerance {
            return Solved { sweeps: sweep, converged: true, velocity, angular_velocity: rate };
        }
    }
    Solved { sweeps: MAX_SWEEPS, converged: false, velocity, angular_velocity: rate }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;
    use crate::projectile::Motion;
    use crate::scene::Scene;

    fn sphere() -> (Solid, Inertia, Body) {
        let scene = Scene::sheet_3in_sphere();
        let solid = Solid::of(&scene.projectile);
        let inertia = Inertia::of(&solid, scene.projectile.mass, true);
        let motion = Motion {
            position: [0.0; 3],
            velocity: [0.0, 0.0, 100.0],
            orientation: [1.0, 0.0, 0.0, 0.0],
            angular_velocity: [0.0; 3],
        };
        (solid, inertia, Body::of(&motion))
    }

    fn slot(normal: Vector, approach: f64) -> [f64; CANDIDATE_REALS] {
        let mut slot = [0.0; CANDIDATE_REALS];
        let candidate = Candidate { normal, approach, weight: 1.0, ..Candidate::read(&slot) };
        candidate.write(&mut slot);
        slot
    }

    #[test]
    fn one_node_head_on_sticks_to_the_body() {
        let (_, inertia, body) = sphere();
        let mass = 6.52e-8;
        let mut slots = [slot(Vector::new(0.0, 0.0, 1.0), 0.0)];
        let solved = solve(&mut slots, &body, &inertia, mass, Symmetry::default());
        let expected = 100.0 * inertia.mass / (inertia.mass + mass);
        assert!(solved.converged);
        assert!((solved.velocity.z / expected - 1.0).abs() < 1e-14);
        assert!((slots[0][13] - mass * expected).abs() < 1e-12 * mass * expected);
    }

    #[test]
    fn a_receding_node_feels_nothing() {
        let (_, inertia, body) = sphere();
        let mut slots = [slot(Vector::new(0.0, 0.0, 1.0), 150.0)];
        let solved = solve(&mut slots, &body, &inertia, 6.52e-8, Symmetry::default());
        assert_eq!(solved.velocity, body.velocity);
        assert_eq!(slots[0][13], 0.0);
    }

    #[test]
    fn complementarity_of_many_nodes() {
        let (_, inertia, body) = sphere();
        let mut slots: [[f64; CANDIDATE_REALS]; 40] = core::array::from_fn(|k| {
            let angle = 0.02 * k as f64;
            slot(Vector::new(math::sin(angle), 0.0, math::cos(angle)), 3.0 * k as f64)
        });
        let mass = 6.52e-8;
        let solved = solve(&mut slots, &body, &inertia, mass, Symmetry::default());
        assert!(solved.converged && solved.sweeps < 10);
        for c in slots.iter().map(Candidate::read) {
            let gap_rate = c.approach + c.impulse / mass - c.normal.dot(&solved.velocity);
            assert!(c.impulse >= 0.0 && gap_rate > -1e-10);
            assert!(c.impulse == 0.0 || gap_rate.abs() < 1e-10);
        }
    }
}
