//! Pose of one frame in another: a point and a unit quaternion. Used at the simulation's boundary, where the
//! host's frame and the sheet's frame meet. An identity pose changes no bit.

use crate::scene::parts::Sheet;
use nalgebra::{Quaternion, Vector3};

/// A three-dimensional vector.
pub type Vector = Vector3<f64>;

/// A frame's place in the host's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    position: Vector,
    /// World from body, scalar first; None where it is exactly the identity.
    orientation: Option<Quaternion<f64>>,
}

impl Pose {
    /// The host's frame itself.
    pub(crate) const IDENTITY: Pose = Pose { position: Vector::new(0.0, 0.0, 0.0), orientation: None };

    /// The sheet's pose in the host's frame.
    pub fn of_sheet(sheet: &Sheet) -> Pose {
        let q = sheet.orientation;
        let orientation = if q == [1.0, 0.0, 0.0, 0.0] { None } else { Some(normalised(q)) };
        Pose { position: Vector::from(sheet.position), orientation }
    }

    /// A point of the host's frame, seen from this frame.
    pub fn point_in(&self, point: [f64; 3]) -> [f64; 3] {
        self.vector_in((Vector::from(point) - self.position).into())
    }

    /// A point of this frame, in the host's frame.
    pub fn point_out(&self, point: [f64; 3]) -> [f64; 3] {
        (Vector::from(self.vector_out(point)) + self.position).into()
    }

    /// A direction of the host's frame, seen from this frame.
    pub fn vector_in(&self, v: [f64; 3]) -> [f64; 3] {
        self.orientation.map_or(v, |q| rotate(&q.conjugate(), &Vector::from(v)).into())
    }

    /// A direction of this frame, in the host's frame.
    pub fn vector_out(&self, v: [f64; 3]) -> [f64; 3] {
        self.orientation.map_or(v, |q| rotate(&q, &Vector::from(v)).into())
    }

    /// An orientation given in the host's frame, seen from this frame.
    pub fn orientation_in(&self, q: [f64; 4]) -> [f64; 4] {
        self.orientation.map_or(q, |own| components(&(own.conjugate() * quaternion(q))))
    }

    /// An orientation of this frame, in the host's frame.
    pub fn orientation_out(&self, q: [f64; 4]) -> [f64; 4] {
        self.orientation.map_or(q, |own| components(&(own * quaternion(q))))
    }
}

/// Quaternion from its components, scalar first.
pub fn quaternion(q: [f64; 4]) -> Quaternion<f64> {
    Quaternion::new(q[0], q[1], q[2], q[3])
}

/// Components of a quaternion, scalar first.
pub fn components(q: &Quaternion<f64>) -> [f64; 4] {
    [q.w, q.i, q.j, q.k]
}

/// The quaternion at unit length. Exactly unit input is returned unchanged.
pub fn normalised(q: [f64; 4]) -> Quaternion<f64> {
    let squared = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    if squared == 1.0 {
        return quaternion(q);
    }
    let scale = 1.0 / crate::ground::math::sqrt(squared);
    Quaternion::new(q[0] * scale, q[1] * scale, q[2] * scale, q[3] * scale)
}

/// The vector turned by a unit quaternion: v + 2 s (u x v) + 2 u x (u x v) with q = (s, u).
pub fn rotate(q: &Quaternion<f64>, v: &Vector) -> Vector {
    let u = Vector::new(q.i, q.j, q.k);
    let t = u.cross(v) * 2.0;
    v + t * q.w + u.cross(&t)
}

/// A vector of the world in body axes. The identity orientation changes no bit.
pub fn into_body(orientation: &Quaternion<f64>, v: &Vector) -> Vector {
    rotate(&orientation.conjugate(), v)
}

/// A body vector in world axes.
pub fn out_of_body(orientation: &Quaternion<f64>, v: &Vector) -> Vector {
    rotate(orientation, v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parts::Scene;

    #[test]
    fn identity_changes_no_bit() {
        let pose = Pose::of_sheet(&Scene::sheet_3in_sphere().sheet);
        let p = [0.1, -0.2, 1e-300];
        assert_eq!(pose.point_in(p), p);
        assert_eq!(pose.vector_out(p), p);
        assert_eq!(pose.orientation_in([0.6, 0.8, 0.0, 0.0]), [0.6, 0.8, 0.0, 0.0]);
    }
}
