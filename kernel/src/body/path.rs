//! The prescribed body: a C1 pose inside a communication step.
//!
//! Method: the position follows the cubic Hermite polynomial from the pose and rate the fabric *now has* to
//! the end pose and rate; the rotation vector of q0^-1 q1 follows the same cubic. Evaluated at (n -
//! first)/steps, so it does not depend on how calls are split. The velocity of step n is (P(t_{n+1}) -
//! P(t_n))/dt, and w comes from q(t_{n+1}) = q(t_n) cay(dt w).
//! Limits: the rotation is exact about one axis, otherwise third order in the path's length; less than half a
//! turn a path.
//! Reference: M. Arnold, in: Co-simulation (2010), on smooth extrapolation of coupling variables.

use crate::body::pose::{self, Vector};
use crate::body::projectile::{Body, Motion};
use crate::ground::math;
use nalgebra::Quaternion;

/// Where the host wants the body at the end of a communication step, in the host's frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Path {
    /// Step count at which the path starts: the simulation's present count, or that of the path being
    /// followed.
    pub first: u64,
    /// Length of the path in steps, at least 1; less than half a turn of the body.
    pub steps: u64,
    /// Pose and rates at step `first + steps`. The body gets there by M13.
    pub end: Motion,
}

/// A path being followed, in the sheet's frame; angular velocities in body axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Track {
    /// Step count at the start.
    pub first: u64,
    /// Length in steps; 0 = no path.
    pub steps: u64,
    /// Body at the start.
    pub start: Body,
    /// Body at the end.
    pub end: Body,
}

impl Track {
    /// Position and orientation `elapsed` steps after the first.
    pub fn pose(&self, elapsed: f64, dt: f64) -> (Vector, Quaternion<f64>) {
        let duration = self.steps as f64 * dt;
        let s = elapsed / self.steps as f64;
        // (M13) Cubic Hermite polynomial on [0, 1] from 0, with these slopes at its ends. The 0 is a term of
        // the sum, so that no -0 comes out.
        let r = 1.0 - s;
        let cubic = |first: Vector, end: Vector, last: Vector| {
            let rise = Vector::zeros() + first * duration * (s * r * r) + end * (s * s * (3.0 - 2.0 * s));
            rise - last * duration * (s * s * r)
        };
        let (start, end) = (&self.start, &self.end);
        let whole = rotation_vector(&(start.orientation.conjugate() * end.orientation));
        let rotation = cubic(start.angular_velocity, whole, end.angular_velocity);
        let way = cubic(start.velocity, end.position - start.position, end.velocity);
        (way + start.position, start.orientation * exponential(&rotation))
    }
}

/// Axis times angle, rad, of the shorter rotation.
pub fn rotation_vector(q: &Quaternion<f64>) -> Vector {
    let q = if q.w < 0.0 { -q } else { *q };
    let u = Vector::new(q.i, q.j, q.k);
    let length = math::length([q.i, q.j, q.k]);
    if length > 0.0 { u * (2.0 * math::atan2(length, q.w) / length) } else { Vector::zeros() }
}

/// Quaternion of a rotation vector.
pub fn exponential(rotation: &Vector) -> Quaternion<f64> {
    let angle = math::length([rotation.x, rotation.y, rotation.z]);
    if angle == 0.0 {
        return Quaternion::new(1.0, 0.0, 0.0, 0.0);
    }
    let factor = math::sin(0.5 * angle) / angle;
    Quaternion::new(math::cos(0.5 * angle), rotation.x * factor, rotation.y * factor, rotation.z * factor)
}

/// The body rate w with q1 = q0 cay(dt w): dt w/2 = vector part over scalar part of q0^-1 q1.
pub fn cayley_rate(q0: &Quaternion<f64>, q1: &Quaternion<f64>, dt: f64) -> Vector {
    let relative = q0.conjugate() * q1;
    Vector::new(relative.i, relative.j, relative.k) * (2.0 / (dt * relative.w))
}

/// A motion in the host's frame, brought into the sheet's.
pub fn into_sheet(pose: &pose::Pose, motion: &Motion) -> Motion {
    Motion {
        position: pose.point_in(motion.position),
        velocity: pose.vector_in(motion.velocity),
        orientation: pose.orientation_in(motion.orientation),
        angular_velocity: pose.vector_in(motion.angular_velocity),
    }
}

/// A motion in the sheet's frame, brought into the host's.
pub fn out_of_sheet(pose: &pose::Pose, motion: &Motion) -> Motion {
    Motion {
        position: pose.point_out(motion.position),
        velocity: pose.vector_out(motion.velocity),
        orientation: pose.orientation_out(motion.orientation),
        angular_velocity: pose.vector_out(motion.angular_velocity),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(x: f64, v: f64, angle: f64, rate: f64) -> Body {
        Body::of(&Motion {
            position: [x, 0.0, 0.0],
            velocity: [v, 0.0, 0.0],
            orientation: pose::components(&exponential(&Vector::new(0.0, 0.0, angle))),
            angular_velocity: [0.0, 0.0, rate],
        })
    }

    #[test]
    fn a_constant_rate_about_one_axis_is_exact() {
        let track = Track { first: 0, steps: 100, start: motion(0.0, 1.0, 0.0, 3.0), end: motion(1.0, 1.0, 3.0, 3.0) };
        for n in 0..=100 {
            let (p, q) = track.pose(n as f64, 0.01);
            assert!((p.x - n as f64 * 0.01).abs() < 1e-14);
            assert!((rotation_vector(&q).z - n as f64 * 0.03).abs() < 1e-13);
        }
    }
}
