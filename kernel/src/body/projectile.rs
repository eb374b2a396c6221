//! The rigid body: translation always, rotation only where contact can turn it.
//!
//! Method: contact and external load enter as impulses. The torque-free rotation of a step is the implicit
//! midpoint rule I dw = dt (I w_m) x w_m with w_m = (w_n + w_{n+1})/2, solved by fixed point, and the Cayley
//! map for the quaternion: q <- q (1, dt w_m/2)/|(1, dt w_m/2)|. Kinetic energy, |L| and the spatial angular
//! momentum are kept to rounding, without sine or cosine. Optional instead: the paper's theta rule, which
//! weighs the moments (I w) x w at both ends of the step.
//! Limits: dt |w| <= 0.5.
//! Reference: J. C. Simo, K. K. Wong, Int. J. Numer. Meth. Engng 31 (1991) 19; Powell and Zohdi (2009),
//! equations 14-16.

use crate::body::pose::{self, Vector, into_body, out_of_body};
use crate::body::shape::Solid;
use crate::ground::math;
use crate::scene::features::Feature;
use crate::scene::parts::{RotationKind, RotationRule};
use nalgebra::{Quaternion, Vector4};

/// Position, orientation and rates of a rigid body in one frame. Angular velocity in the axes of that frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Motion {
    /// Centre of mass, m.
    pub position: [f64; 3],
    /// Velocity of the centre of mass, m/s.
    pub velocity: [f64; 3],
    /// Orientation, unit quaternion, scalar first.
    pub orientation: [f64; 4],
    /// Angular velocity, rad/s.
    pub angular_velocity: [f64; 3],
}

/// Constants of the body. A prescribed body has zero inverse mass and inertia: contact does not move it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia {
    /// Mass, kg (0 if unknown).
    pub mass: f64,
    /// Principal moments, kg m^2.
    pub moments: Vector,
    /// 1/mass as contact sees it, 1/kg.
    pub inverse_mass: f64,
    /// Inverse principal moments as contact sees them, 1/(kg m^2); zero for bodies that contact does not
    /// turn.
    pub inverse_moments: Vector,
    /// Whether the body turns. A sphere without friction does not: its impulses pass through its centre.
    pub turns: bool,
}

impl Inertia {
    /// No mass.
    pub(crate) const NOTHING: Inertia = Inertia {
        mass: 0.0,
        moments: Vector::new(0.0, 0.0, 0.0),
        inverse_mass: 0.0,
        inverse_moments: Vector::new(0.0, 0.0, 0.0),
        turns: false,
    };

    /// Constants of a solid of the given mass without friction; `movable` false for a prescribed body.
    pub fn of(solid: &Solid, mass: f64, movable: bool) -> Inertia {
        let moments = Vector::from(solid.inertia(mass));
        let inverse_mass = if movable { 1.0 / mass } else { 0.0 };
        let turns = solid.feels_torque();
        let inverse_moments = if movable && turns { moments.map(|moment| 1.0 / moment) } else { Vector::zeros() };
        Inertia { mass, moments, inverse_mass, inverse_moments, turns }
    }

    /// With friction a sphere turns, too.
    pub fn feel_friction(&mut self) {
        self.turns = true;
        if self.inverse_mass > 0.0 {
            self.inverse_moments = self.moments.map(|moment| 1.0 / moment);
        }
    }
}

/// State of the body in the sheet's frame; angular velocity in body axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Centre of mass at t_n, m.
    pub position: Vector,
    /// World from body, unit quaternion.
    pub orientation: Quaternion<f64>,
    /// Velocity at t_{n-1/2}, m/s.
    pub velocity: Vector,
    /// Angular velocity in body axes, rad/s.
    pub angular_velocity: Vector,
}

/// Velocity of a rigid body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist {
    /// Velocity of its centre of mass, sheet's frame, m/s.
    pub velocity: Vector,
    /// Angular velocity in body axes, rad/s.
    pub angular_velocity: Vector,
}

impl Twist {
    /// Upper bound of the speed of points within `arm`, m, of the centre, m/s.
    pub(crate) fn fastest(&self, arm: f64) -> f64 {
        math::length(self.velocity.into()) + arm * math::length(self.angular_velocity.into())
    }
}

impl Body {
    /// At rest at the origin.
    pub(crate) const AT_REST: Body = Body {
        position: Vector::new(0.0, 0.0, 0.0),
        orientation: Quaternion { coords: Vector4::new(0.0, 0.0, 0.0, 1.0) },
        velocity: Vector::new(0.0, 0.0, 0.0),
        angular_velocity: Vector::new(0.0, 0.0, 0.0),
    };

    /// The body in a given motion.
    pub fn of(motion: &Motion) -> Body {
        let orientation = pose::normalised(motion.orientation);
        Body {
            position: Vector::from(motion.position),
            orientation,
            velocity: Vector::from(motion.velocity),
            angular_velocity: into_body(&orientation, &Vector::from(motion.angular_velocity)),
        }
    }

    /// Velocity of the body.
    pub(crate) fn twist(&self) -> Twist {
        Twist { velocity: self.velocity, angular_velocity: self.angular_velocity }
    }

    /// The body's motion with the angular velocity in the frame's axes.
    pub fn motion(&self) -> Motion {
        Motion {
            position: self.position.into(),
            velocity: self.velocity.into(),
            orientation: pose::components(&self.orientation),
            angular_velocity: out_of_body(&self.orientation, &self.angular_velocity).into(),
        }
    }

    /// Kinetic energy, J.
    pub fn kinetic_energy(&self, inertia: &Inertia) -> f64 {
        let w = self.angular_velocity;
        let spin = w.component_mul(&inertia.moments).dot(&w);
        0.5 * inertia.mass * self.velocity.dot(&self.velocity) + 0.5 * spin
    }

    /// Drift of one step: translation, and rotation where the body turns.
    pub fn drift(&mut self, inertia: &Inertia, rule: RotationRule, dt: f64) {
        self.position += self.velocity * dt;
        if inertia.turns {
            let rate = self.angular_velocity;
            let (mean, end) = match rule.kind {
                RotationKind::Theta if Feature::ThetaRotation.is_built() => {
                    let theta = rule.theta;
                    let end = theta_rate(&rate, &inertia.moments, theta, dt);
                    (rate * (1.0 - theta) + end * theta, end)
                }
                _ => {
                    let middle = implicit_rate(&rate, &rate, &inertia.moments, 0.5 * dt);
                    (middle, middle * 2.0 - rate)
                }
            };
            self.angular_velocity = end;
            self.orientation = cayley_turn(&self.orientation, &mean, dt);
        }
    }
}

/// Angular acceleration of a body without a torque, I^-1 N(w) with N(w) = (I w) x w.
fn torque_free(w: &Vector, moments: &Vector) -> Vector {
    w.component_mul(moments).cross(w).component_div(moments)
}

/// Angular velocity w' = explicit + dt I^-1 N(w'), sought from w. With w for the explicit part and half a
/// step it is that of the midpoint.
fn implicit_rate(w: &Vector, explicit: &Vector, moments: &Vector, dt: f64) -> Vector {
    let (mut end, scale) = (*w, max_component(w));
    for _ in 0..50 {
        let next = explicit + torque_free(&end, moments) * dt;
        let change = max_component(&(next - end));
        end = next;
        if change <= 1e-15 * scale {
            break;
        }
    }
    end
}

/// Angular velocity after a torque-free step of the theta rule: w' = w + dt I^-1 [(1 - theta) N(w) + theta
/// N(w')] (Powell and Zohdi 2009, equations 14-16).
fn theta_rate(w: &Vector, moments: &Vector, theta: f64, dt: f64) -> Vector {
    let explicit = w + torque_free(w, moments) * (dt * (1.0 - theta));
    implicit_rate(w, &explicit, moments, dt * theta)
}

fn max_component(v: &Vector) -> f64 {
    v.iter().fold(0.0, |largest, &x| {
        let size = math::abs(x);
        math::max(size, largest)
    })
}

/// q (1, dt w/2)/|(1, dt w/2)|.
pub fn cayley_turn(q: &Quaternion<f64>, w: &Vector, dt: f64) -> Quaternion<f64> {
    let half = w * (0.5 * dt);
    let turned = *q * Quaternion::new(1.0, half.x, half.y, half.z);
    let squared = turned.w * turned.w + turned.i * turned.i + turned.j * turned.j + turned.k * turned.k;
    turned * (1.0 / crate::ground::math::sqrt(squared))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::AT_REST;

    /// Largest error of w at t = 10 and relative drift of the kinetic energy with the theta rule.
    fn theta_spun(theta: f64, dt: f64) -> (f64, f64) {
        let moments = Vector::new(1.0, 2.0, 3.0);
        let mut w = Vector::new(1.0, 0.0, 1.0);
        for _ in 0..(10.0 / dt + 0.5) as usize {
            w = theta_rate(&w, &moments, theta, dt);
        }
        let exact = Vector::new(-0.921069998444, 0.389397044115, 0.974400660583);
        (max_component(&(w - exact)), w.component_mul(&moments).dot(&w) / 4.0 - 1.0)
    }

    #[test]
    fn the_theta_rule_converges_and_does_not_conserve() {
        for (dt, error, drift) in [
            (0.1, 3.881e-3, 1.29e-4),
            (0.05, 9.718e-4, 3.17e-5),
            (0.025, 2.431e-4, 7.91e-6),
            (0.0125, 6.077e-5, 1.98e-6),
        ] {
            let found = theta_spun(0.5, dt);
            assert!((found.0 / error - 1.0).abs() < 2e-3, "{dt}: {found:?}");
            assert!((found.1.abs() / drift - 1.0).abs() < 1e-2, "{dt}: {found:?}");
        }
        // Backward Euler is of first order and loses energy, forward Euler gains it.
        let order = (theta_spun(1.0, 0.025).0 / theta_spun(1.0, 0.0125).0).log2();
        assert!((0.85..1.0).contains(&order), "{order}");
        assert!((theta_spun(1.0, 0.1).1 + 0.21).abs() < 0.01 && (theta_spun(0.0, 0.1).1 - 0.50).abs() < 0.01);
    }

    #[test]
    fn iterations_end_where_nothing_moves_any_more() {
        // A step as long as the limit allows, dt |w| = 0.5: the equations of both rules hold to rounding.
        // Slow or fast: what counts is the angle.
        for speed in [1e-6, 1.0, 1e4] {
            let (moments, w) = (Vector::new(1.0, 2.0, 3.0), Vector::new(30.0, -20.0, 34.0) * speed);
            let dt = 0.5 / w.norm();
            let moment = |w: &Vector| w.component_mul(&moments).cross(w).component_div(&moments);
            let middle = implicit_rate(&w, &w, &moments, 0.5 * dt);
            assert!((middle - w - moment(&middle) * (0.5 * dt)).norm() <= 4e-15 * w.norm());
            for theta in [0.25, 0.5, 1.0] {
                let end = theta_rate(&w, &moments, theta, dt);
                let mean = moment(&w) * (1.0 - theta) + moment(&end) * theta;
                assert!((end - w - mean * dt).norm() <= 4e-15 * w.norm(), "{theta}");
            }
        }
    }

    /// The mean of the theta rule turns the body: of a tumbling one too.
    #[test]
    fn the_theta_rule_turns_by_the_weighted_mean_of_the_rates() {
        let solid = Solid::from(crate::Form::Cylinder { radius: 6.35e-3, half_length: 0.01905 });
        let inertia = Inertia::of(&solid, 0.037, true);
        let motion = Motion { angular_velocity: [40.0, 0.0, 50.0], ..AT_REST };
        let dt = 5e-3;
        for theta in [0.25, 0.5, 0.75] {
            let mut body = Body::of(&motion);
            let first = body.angular_velocity;
            body.drift(&inertia, RotationRule::theta(theta), dt);
            let mean = first * (1.0 - theta) + body.angular_velocity * theta;
            // The quaternion's vector part over its scalar part is dt/2 times the rate.
            let q = body.orientation;
            let rate = Vector::new(q.i, q.j, q.k) * (2.0 / (dt * q.w));
            assert!((rate - mean).norm() < 1e-12 * mean.norm() && (body.angular_velocity - first).norm() > 1.0);
        }
    }
}
