//! Coulomb friction of the nodes on the projectile: two tangential impulses beside the normal one of a
//! contact.
//!
//! Method: at a contact with the normal impulse lambda the tangential impulse p on the node satisfies |p| <=
//! mu lambda, and with the slip s = (v - V - w x r) less its normal part at the end of the step p = -mu
//! lambda s/|s| where s is not 0. Solved in the sweeps of `solve.rs`: p <- the nearest point to p - s/W of
//! the disc |p| <= mu lambda, with the largest inverse mass W of the contact along its tangents. So the cone
//! is exact, and a node that is alone on a body that does not turn is solved at once. The impulses act on
//! node and body at the place of the node at t_n: linear and angular momentum are exact.
//! Limits: one coefficient for rest and sliding; velocity Verlet. Where nodes are coupled by the body alone
//! (fixed nodes) the impulses need not be unique; the solution found is that of the node order.
//! Reference: G. De Saxce, Z.-Q. Feng, Math. Comput. Modelling 28 (1998) 225; M. Jean, Comput. Methods Appl.
//! Mech. Engrg. 177 (1999) 235.

use crate::body::pose::{self, Vector};
use crate::body::projectile::{Body, Inertia, Twist};
use crate::contact::laws;
use crate::ground::math;
use crate::memory::records::Tangential;
use crate::scene::parts::Symmetry;

impl Tangential {
    /// Tangential part of a node at `r` from the body's centre, m, with this normal and velocity, m/s,
    /// sheet's frame.
    pub fn at(r: &Vector, normal: &Vector, velocity: &Vector, body: &Body) -> Tangential {
        // The axis that is farthest from the normal; on a mirror plane that across it, so that rounding keeps
        // the symmetry.
        let axis = match [normal.x, normal.y, normal.z].map(math::abs) {
            [x, y, z] if x <= y && x <= z => Vector::x(),
            [_, y, z] if y <= z => Vector::y(),
            _ => Vector::z(),
        };
        let across = axis.cross(normal);
        let first = across * (1.0 / math::length(across.into()));
        let tangents = [first, normal.cross(&first)];
        let speed_before = tangents.map(|t| t.dot(velocity));
        Tangential {
            tangents,
            arms: tangents.map(|t| pose::into_body(&body.orientation, &r.cross(&t))),
            speed_before,
            speed: speed_before,
            effective_mass: 0.0,
            impulse: [0.0; 2],
        }
    }

    /// Begins without impulse on a node of this inverse mass, 1/kg, that appears so often in the whole sheet.
    #[inline]
    pub(crate) fn begin(&mut self, inertia: &Inertia, own: f64, symmetry: Symmetry, multiplicity: f64) {
        let (push_mask, twist_mask) = (symmetry.force_mask(), symmetry.torque_mask());
        let ([t0, t1], [a0, a1]) = (self.tangents, self.arms);
        // What an impulse along the second tangent changes of the speed along the first.
        let compliance = |t: &Vector, a: &Vector, t_of: &Vector, a_of: &Vector| {
            let turning = a.dot(&a_of.component_mul(&twist_mask).component_mul(&inertia.inverse_moments));
            multiplicity * (inertia.inverse_mass * t.dot(&t_of.component_mul(&push_mask)) + turning)
        };
        let [g00, g01, g11] =
            [compliance(&t0, &a0, &t0, &a0), compliance(&t0, &a0, &t1, &a1), compliance(&t1, &a1, &t1, &a1)];
        let compliance = own + largest_eigenvalue(g00, g01, g11);
        (self.effective_mass, self.impulse) = (if compliance > 0.0 { 1.0 / compliance } else { 0.0 }, [0.0; 2]);
    }

    /// The parts of a velocity along the tangents.
    pub(crate) fn along(&self, v: &Vector) -> [f64; 2] {
        self.tangents.map(|t| t.dot(v))
    }

    /// Impulses times speeds, J.
    pub(crate) fn work(&self, [s, t]: [f64; 2]) -> f64 {
        let [p, q] = self.impulse;
        p * s + q * t
    }

    /// Slip along each tangent without an impulse on the node, m/s.
    pub(crate) fn slip(&self, body: &Twist) -> [f64; 2] {
        let [p, q] = self.surface_speed(body);
        [self.speed[0] - p, self.speed[1] - q]
    }

    /// Speed of the body's surface along each tangent, m/s.
    pub(crate) fn surface_speed(&self, body: &Twist) -> [f64; 2] {
        [0, 1].map(|k| self.tangents[k].dot(&body.velocity) + self.arms[k].dot(&body.angular_velocity))
    }

    /// An impulse with these parts along the tangents as a vector, sheet's frame, N s.
    pub fn as_vector(&self, [p, q]: [f64; 2]) -> Vector {
        self.tangents[0] * p + self.tangents[1] * q
    }

    /// Moment of an impulse with these parts about the body's centre, body axes, N m s.
    pub(crate) fn moment(&self, [p, q]: [f64; 2]) -> Vector {
        self.arms[0] * p + self.arms[1] * q
    }

    /// (M21) Next impulses of a node with this slip, m/s, and friction of at most this size, N s.
    pub(crate) fn next(&self, slip: [f64; 2], most: f64) -> [f64; 2] {
        laws::limited(laws::trial_friction(self.impulse, slip, self.effective_mass), most)
    }
}

/// Largest eigenvalue of a symmetric 2 x 2 matrix [[a, b], [b, c]].
fn largest_eigenvalue(a: f64, b: f64, c: f64) -> f64 {
    let half = 0.5 * (a - c);
    0.5 * (a + c) + math::length([half, b, 0.0])
}
