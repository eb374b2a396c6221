//! Signed distance and outward normal of each projectile shape, in the body's frame, and its mass properties.
//!
//! Method: the gap function of a convex body is convex, 1-Lipschitz and zero on the surface; the contact law's
//! non-penetration rests on that, and on nothing else. Sphere, flat-ended cylinder and cylinder with a hemispherical end
//! (axis = body z): true distance. Box and polyhedron: the greatest distance from a face's plane ([`crate::polyhedron`]).
//! The body's origin is its centre of mass, its axes are principal axes.
//! Limits: the radius must be at least the node spacing, or nodes do not see the body.
//! Reference: I. Quilez, "Distance functions" (the cylinder's two-dimensional distance to a rectangle).

use crate::error::{Code, Error};
use crate::math;
use crate::polyhedron::{self, Polyhedron};
use crate::pose::Vector;
use crate::projectile::into_body;
use crate::scene::{self, Faces, Projectile, Shape};
use nalgebra::Quaternion;

/// A shape with its dimensions.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant)] // Made once for a simulation, and there is no heap.
pub enum Solid {
    /// Sphere.
    Sphere {
        /// Radius, m.
        radius: f64,
    },
    /// Flat-ended cylinder along z.
    Cylinder {
        /// Radius, m.
        radius: f64,
        /// Half the length, m.
        half_length: f64,
    },
    /// Cylinder along z with a hemisphere at its +z end.
    HemisphericalCylinder {
        /// Radius of cylinder and hemisphere, m.
        radius: f64,
        /// Length of the cylindrical part, m, >= 0.
        shank: f64,
        /// z of the hemisphere's centre from the centre of mass, m. The flat end is at z = nose - shank.
        nose: f64,
    },
    /// Box or polyhedron.
    Polyhedron(Polyhedron),
}

/// Gap of a point: signed distance (negative inside) and outward unit normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Signed distance, m.
    pub distance: f64,
    /// Gradient of the distance, outward.
    pub normal: Vector,
}

/// Refuses dimensions that are not numbers, too small for the node spacing, or of no body. `moments` only of known mass.
pub(crate) fn check(body: &Projectile, spacing: f64) -> Result<(), Error> {
    let too_small = |field, value, limit| Err(Error::new(Code::ProjectileTooSmall, field, value, limit));
    match body.shape {
        Shape::Sphere | Shape::Cylinder | Shape::HemisphericalCylinder => {
            scene::positive("projectile.radius", body.radius)?;
            if body.radius < spacing {
                return too_small("projectile.radius", body.radius, spacing);
            }
        }
        Shape::Box => {
            for edge in body.size {
                scene::positive("projectile.size", edge)?;
                if edge < 2.0 * spacing {
                    return too_small("projectile.size", edge, 2.0 * spacing);
                }
            }
        }
        Shape::Polyhedron => {
            polyhedron::check(&body.faces, spacing)?;
            if body.mass != 0.0 {
                check_moments(body.moments)?;
            }
        }
    }
    if matches!(body.shape, Shape::Cylinder | Shape::HemisphericalCylinder) {
        scene::positive("projectile.length", body.length)?;
        if body.length < 2.0 * spacing {
            return too_small("projectile.length", body.length, 2.0 * spacing);
        }
        if body.shape == Shape::HemisphericalCylinder && body.length < body.radius {
            return Err(Error::new(Code::OutOfRange, "projectile.length", body.length, body.radius));
        }
    }
    Ok(())
}

/// Refuses moments that are not positive, and any greater than the other two together (beyond rounding).
fn check_moments(moments: [f64; 3]) -> Result<(), Error> {
    moments.iter().try_for_each(|&moment| scene::positive("projectile.moments", moment))?;
    let sum = moments[0] + moments[1] + moments[2];
    for moment in moments {
        let others = sum - moment;
        if moment > others * (1.0 + 1e-9) {
            return Err(Error::new(Code::ImpossibleMoments, "projectile.moments", moment, others));
        }
    }
    Ok(())
}

impl Solid {
    /// The solid of a projectile.
    pub fn of(body: &Projectile) -> Solid {
        let radius = body.radius;
        match body.shape {
            Shape::Sphere => Solid::Sphere { radius },
            Shape::Cylinder => Solid::Cylinder { radius, half_length: 0.5 * body.length },
            Shape::HemisphericalCylinder => {
                let shank = body.length - radius;
                Solid::HemisphericalCylinder { radius, shank, nose: nose(radius, shank) }
            }
            Shape::Box => {
                let [a, b, c] = body.size;
                let gyration = [b * b + c * c, c * c + a * a, a * a + b * b].map(|sum| sum / 12.0);
                Solid::Polyhedron(Polyhedron::new(&box_faces(body.size), gyration))
            }
            Shape::Polyhedron => {
                // A body of unknown mass has no known moments.
                let inverse = if body.mass > 0.0 { 1.0 / body.mass } else { 0.0 };
                Solid::Polyhedron(Polyhedron::new(&body.faces, body.moments.map(|moment| moment * inverse)))
            }
        }
    }

    /// The radius that "exited" measures travel by, m: for a box half the least edge, for a polyhedron the least distance of
    /// a face from the centre of mass.
    pub fn radius(&self) -> f64 {
        match self {
            Solid::Sphere { radius } | Solid::Cylinder { radius, .. } | Solid::HemisphericalCylinder { radius, .. } => {
                *radius
            }
            Solid::Polyhedron(body) => body.least_distance(),
        }
    }

    /// Distance from the centre of mass to the farthest surface point, m.
    pub fn reach(&self) -> f64 {
        match self {
            Solid::Sphere { radius } => *radius,
            Solid::Cylinder { radius, half_length } => math::sqrt(radius * radius + half_length * half_length),
            Solid::HemisphericalCylinder { radius, shank, nose } => {
                let end = nose - shank;
                let rim = math::sqrt(radius * radius + end * end);
                if nose + radius > rim { nose + radius } else { rim }
            }
            Solid::Polyhedron(body) => body.reach(),
        }
    }

    /// Radius of the circle in the sheet's plane that the body covers, seen along the sheet's normal, m. `orientation`: the
    /// body's in the sheet's frame. Cylinders count as upright, as in the paper.
    pub fn reach_in_plane(&self, orientation: &Quaternion<f64>) -> f64 {
        match self {
            Solid::Polyhedron(body) => body.reach_across(&into_body(orientation, &Vector::new(0.0, 0.0, 1.0))),
            _ => self.radius(),
        }
    }

    /// Edge lengths of the box along the body axes that holds the solid, m.
    pub fn edges(&self) -> [f64; 3] {
        let [x, y, z] = [Vector::new(1.0, 0.0, 0.0), Vector::new(0.0, 1.0, 0.0), Vector::new(0.0, 0.0, 1.0)];
        [x, y, z].map(|axis| self.support(&axis) + self.support(&-axis))
    }

    /// Whether contact forces can turn the body. A sphere's pass through its centre.
    pub fn feels_torque(&self) -> bool {
        !matches!(self, Solid::Sphere { .. })
    }

    /// Principal moments of inertia about the centre of mass, kg m^2, for a given mass. Homogeneous but for a polyhedron,
    /// whose radii of gyration are those of the projectile it was made of.
    pub fn inertia(&self, mass: f64) -> [f64; 3] {
        match self {
            Solid::Sphere { radius } => [0.4 * mass * (radius * radius); 3],
            Solid::Cylinder { radius, half_length } => {
                let (r2, length) = (radius * radius, 2.0 * half_length);
                let transverse = mass * (3.0 * r2 + length * length) / 12.0;
                [transverse, transverse, 0.5 * mass * r2]
            }
            Solid::HemisphericalCylinder { radius, shank, nose } => {
                // Parts: a cylinder with its centre at nose - shank/2, and a hemisphere with its own at nose + 3R/8, whose
                // transverse moment about that centre is (2/5 - 9/64) m R^2 = 83/320 m R^2.
                let r2 = radius * radius;
                let whole = shank + 2.0 / 3.0 * radius;
                let (rod, cap) = (mass * shank / whole, mass * (2.0 / 3.0 * radius) / whole);
                let (rod_at, cap_at) = (nose - 0.5 * shank, nose + 0.375 * radius);
                let transverse = rod * ((3.0 * r2 + shank * shank) / 12.0 + rod_at * rod_at)
                    + cap * (83.0 / 320.0 * r2 + cap_at * cap_at);
                [transverse, transverse, (0.5 * rod + 0.4 * cap) * r2]
            }
            Solid::Polyhedron(body) => body.gyration().map(|squared_radius| mass * squared_radius),
        }
    }

    /// How far the body reaches from its centre of mass along a unit direction given in body axes, m.
    pub fn support(&self, direction: &Vector) -> f64 {
        let along = if direction.z < 0.0 { -direction.z } else { direction.z };
        let across = 1.0 - along * along;
        let across = math::sqrt(if across > 0.0 { across } else { 0.0 });
        match self {
            Solid::Sphere { radius } => *radius,
            Solid::Cylinder { radius, half_length } => half_length * along + radius * across,
            Solid::HemisphericalCylinder { radius, nose, .. } if direction.z > 0.0 => nose * along + radius,
            Solid::HemisphericalCylinder { radius, shank, nose } => (shank - nose) * along + radius * across,
            Solid::Polyhedron(body) => body.support(direction),
        }
    }

    /// Half extents along the axes of the box about the centre of mass that holds the body, m, in the frame in which it has
    /// this orientation.
    pub fn half_extents(&self, orientation: &Quaternion<f64>) -> [f64; 3] {
        let [x, y, z] = [Vector::new(1.0, 0.0, 0.0), Vector::new(0.0, 1.0, 0.0), Vector::new(0.0, 0.0, 1.0)];
        [x, y, z].map(|axis| {
            let direction = into_body(orientation, &axis);
            let (ahead, behind) = (self.support(&direction), self.support(&-direction));
            if ahead > behind { ahead } else { behind }
        })
    }

    /// Gap of the point `p`, given in the body's frame from its centre of mass.
    pub fn gap(&self, p: &Vector) -> Gap {
        match self {
            Solid::Sphere { radius } => {
                // At the very centre every direction is as good: a fixed one keeps the bits.
                ball_gap(p, *radius, Vector::new(0.0, 0.0, -1.0))
            }
            Solid::Cylinder { radius, half_length } => {
                let axial = Vector::new(0.0, 0.0, if p.z < 0.0 { -1.0 } else { 1.0 });
                let beyond_end = (if p.z < 0.0 { -p.z } else { p.z }) - half_length;
                rim_gap(p, *radius, beyond_end, axial)
            }
            Solid::HemisphericalCylinder { radius, shank, nose } => {
                let from_nose = Vector::new(p.x, p.y, p.z - nose);
                let beyond_end = -from_nose.z - shank;
                let flat = Vector::new(0.0, 0.0, -1.0);
                if from_nose.z <= 0.0 {
                    return rim_gap(p, *radius, beyond_end, flat);
                }
                let cap = ball_gap(&from_nose, *radius, Vector::new(0.0, 0.0, 1.0));
                if cap.distance > beyond_end { cap } else { Gap { distance: beyond_end, normal: flat } }
            }
            Solid::Polyhedron(body) => body.gap(p),
        }
    }
}

/// z of the hemisphere's centre from the centre of mass. From that centre, a cylinder of volume pi R^2 c has its own at
/// -c/2 and a hemisphere of volume 2/3 pi R^3 at 3R/8.
fn nose(radius: f64, shank: f64) -> f64 {
    (0.5 * shank * shank - 0.25 * radius * radius) / (shank + 2.0 / 3.0 * radius)
}

/// The faces of a box in the order +x, -x, +y, -y, +z, -z.
fn box_faces([a, b, c]: [f64; 3]) -> Faces {
    Faces::of(&[
        [1.0, 0.0, 0.0, 0.5 * a],
        [-1.0, 0.0, 0.0, 0.5 * a],
        [0.0, 1.0, 0.0, 0.5 * b],
        [0.0, -1.0, 0.0, 0.5 * b],
        [0.0, 0.0, 1.0, 0.5 * c],
        [0.0, 0.0, -1.0, 0.5 * c],
    ])
}

fn ball_gap(p: &Vector, radius: f64, normal_at_centre: Vector) -> Gap {
    let length = math::length([p.x, p.y, p.z]);
    let normal = if length > 0.0 { p / length } else { normal_at_centre };
    Gap { distance: length - radius, normal }
}

/// Gap of a tube about z that ends in a flat `beyond_end` short of the point.
fn rim_gap(p: &Vector, radius: f64, beyond_end: f64, axial: Vector) -> Gap {
    let from_axis = math::sqrt(p.x * p.x + p.y * p.y);
    let radial =
        if from_axis > 0.0 { Vector::new(p.x / from_axis, p.y / from_axis, 0.0) } else { Vector::new(1.0, 0.0, 0.0) };
    let beyond_side = from_axis - radius;
    if beyond_side > 0.0 && beyond_end > 0.0 {
        let distance = math::sqrt(beyond_side * beyond_side + beyond_end * beyond_end);
        let normal = radial * (beyond_side / distance) + axial * (beyond_end / distance);
        Gap { distance, normal }
    } else if beyond_side > beyond_end {
        Gap { distance: beyond_side, normal: radial }
    } else {
        Gap { distance: beyond_end, normal: axial }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    fn cylinder() -> Solid {
        Solid::of(&Scene::sheet_10in_cylinder().projectile)
    }

    #[test]
    fn inertia_of_the_presets() {
        let sphere = Solid::of(&Scene::sheet_3in_sphere().projectile).inertia(8.4e-3);
        assert!((sphere[0] / 1.354836e-7 - 1.0).abs() < 1e-6);
        let rod = cylinder().inertia(0.037);
        assert!((rod[0] / 4.848781e-6 - 1.0).abs() < 1e-6);
        assert!((rod[2] / 7.459662e-7 - 1.0).abs() < 1e-6);
    }

    #[test]
    fn cylinder_distances() {
        let (r, l) = (6.35e-3, 0.01905);
        let at = |x, y, z| cylinder().gap(&Vector::new(x, y, z)).distance;
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} {b}");
        close(at(0.0, 0.0, l), 0.0);
        close(at(r, 0.0, 0.0), 0.0);
        close(at(0.0, r + 3e-3, l + 4e-3), 5e-3);
        close(at(0.0, 0.0, 0.0), -r);
        close(at(0.0, 1e-3, l - 1e-3), -1e-3);
        close(at(0.0, -r - 1e-3, 0.5 * l), 1e-3);
    }

    #[test]
    fn gaps_are_convex_and_one_lipschitz() {
        // Along random chords: the middle is no farther than the mean of the ends, and no slope exceeds 1.
        for solid in [cylinder(), Solid::of(&Scene::sheet_3in_sphere().projectile)] {
            let point = |k: u64| {
                let c =
                    |m: u64| (crate::random::splitmix64(3 * k + m) >> 11) as f64 / (1u64 << 53) as f64 * 0.06 - 0.03;
                Vector::new(c(0), c(1), c(2))
            };
            for k in 0..20_000 {
                let (a, b) = (point(2 * k), point(2 * k + 1));
                let (da, db) = (solid.gap(&a).distance, solid.gap(&b).distance);
                let middle = solid.gap(&((a + b) * 0.5));
                assert!(middle.distance <= 0.5 * (da + db) + 1e-17);
                assert!((da - db).abs() <= (a - b).norm() + 1e-17);
                assert!((middle.normal.norm() - 1.0).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn normal_is_the_gradient() {
        let solid = cylinder();
        let step = 1e-8;
        for p in [
            Vector::new(0.004, 0.003, 0.021),
            Vector::new(0.009, -0.002, 0.004),
            Vector::new(-0.007, 0.005, -0.02),
            Vector::new(0.001, 0.002, 0.0185),
        ] {
            let gap = solid.gap(&p);
            for k in 0..3 {
                let mut q = p;
                q[k] += step;
                let slope = (solid.gap(&q).distance - gap.distance) / step;
                assert!((slope - gap.normal[k]).abs() < 1e-5);
            }
        }
    }
}
