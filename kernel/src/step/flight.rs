//! Straight flight of the body past a box or a node, if nothing touches it.
//!
//! Limits: a turning body is taken to reach as far as its farthest surface point in every orientation.

use crate::body::pose::Vector;
use crate::body::shape::Solid;
use crate::ground::math;
use crate::memory::network::Network;
use crate::memory::state::State;

/// The body as it flies on when nothing touches it.
pub(super) struct Flight {
    pub position: Vector,
    pub velocity: Vector,
    /// Acceleration by the present external load, m/s^2.
    pub acceleration: Vector,
    /// Half extents along the sheet's axes as it lies now, m.
    pub extents: [f64; 3],
    /// Distance from the centre to the farthest surface point, m.
    pub reach: f64,
    /// Speed of that point by turning, m/s.
    pub turning: f64,
}

impl Flight {
    /// That of the body as it moves now.
    pub fn of(network: &Network<'_>, solid: &Solid, state: &State) -> Flight {
        let (body, free) = (&state.body, network.scene.is_free());
        Flight {
            position: body.position,
            velocity: body.velocity,
            acceleration: if free { state.force * network.model.inertia.inverse_mass } else { Vector::zeros() },
            extents: solid.half_extents(&body.orientation),
            reach: solid.reach(),
            turning: if solid.feels_torque() { body.angular_velocity.norm() * solid.reach() } else { 0.0 },
        }
    }

    /// Whether the body leaves a box for good: along some axis it lies beyond it, moves away faster than
    /// anything in the box, and no load pulls it back. A body that turns faster than it moves away must lie
    /// beyond it in any orientation.
    pub fn leaves(&self, region: &Region) -> bool {
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
    pub fn has_behind(&self, position: &Vector) -> bool {
        let behind = (position - self.position).dot(&self.velocity) < -self.reach * self.velocity.norm();
        behind && self.acceleration.dot(&self.velocity) >= 0.0
    }

    /// Whether a point lies before the body's centre.
    pub fn has_ahead(&self, position: &Vector) -> bool {
        (position - self.position).dot(&self.velocity) > 0.0
    }

    /// Whether a node that flies on straight never comes within the body's reach.
    pub fn misses(&self, position: &Vector, velocity: &Vector) -> bool {
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
#[derive(Clone, Copy)]
pub(super) struct Region {
    pub low: [f64; 3],
    pub high: [f64; 3],
    pub slowest: [f64; 3],
    pub fastest: [f64; 3],
}

impl Region {
    pub const EMPTY: Region = Region { low: [f64::MAX; 3], high: [f64::MIN; 3], slowest: [0.0; 3], fastest: [0.0; 3] };

    pub fn include(&mut self, x: &Vector) {
        for k in 0..3 {
            self.low[k] = math::min(x[k], self.low[k]);
            self.high[k] = math::max(x[k], self.high[k]);
        }
    }

    pub fn include_velocity(&mut self, v: &Vector) {
        for k in 0..3 {
            self.slowest[k] = math::min(v[k], self.slowest[k]);
            self.fastest[k] = math::max(v[k], self.fastest[k]);
        }
    }

    /// The box with its mirror images about the planes across axis k, from that at 0 to that at `last`.
    pub fn mirror(&mut self, k: usize, last: f64) {
        let beyond = self.high[k] - last;
        let far = math::max(-self.low[k], beyond);
        (self.low[k], self.high[k]) = (-far, last + far);
    }
}
