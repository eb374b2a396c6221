//! Signed distance and outward normal of each projectile shape, in the body's frame.
//!
//! Method: the gap function of a convex body is convex, 1-Lipschitz and zero on the surface; the contact law's
//! non-penetration rests on that. Sphere and flat-ended cylinder (axis = body z): true distance.
//! Limits: the radius must be at least the node spacing, or nodes do not see the body.
//! Reference: I. Quilez, "Distance functions" (the cylinder's two-dimensional distance to a rectangle).

use crate::math;
use crate::pose::Vector;
use crate::scene::{Projectile, Shape};

/// A shape with its dimensions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid {
    /// Form.
    pub shape: Shape,
    /// Radius, m.
    pub radius: f64,
    /// Half the length along the axis, m (the radius for a sphere).
    pub half_length: f64,
}

/// Gap of a point: signed distance (negative inside) and outward unit normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Signed distance, m.
    pub distance: f64,
    /// Gradient of the distance, outward.
    pub normal: Vector,
}

impl Solid {
    /// The solid of a projectile.
    pub fn of(body: &Projectile) -> Solid {
        let half_length = match body.shape {
            Shape::Sphere => body.radius,
            Shape::Cylinder => 0.5 * body.length,
        };
        Solid { shape: body.shape, radius: body.radius, half_length }
    }

    /// Distance from the centre of mass to the farthest surface point, m.
    pub fn reach(&self) -> f64 {
        match self.shape {
            Shape::Sphere => self.radius,
            Shape::Cylinder => math::sqrt(self.radius * self.radius + self.half_length * self.half_length),
        }
    }

    /// Whether contact forces can turn the body. A sphere's pass through its centre.
    pub fn feels_torque(&self) -> bool {
        self.shape != Shape::Sphere
    }

    /// Principal moments of inertia of the homogeneous solid about its centre, kg m^2, for a given mass.
    pub fn inertia(&self, mass: f64) -> [f64; 3] {
        let r2 = self.radius * self.radius;
        match self.shape {
            Shape::Sphere => [0.4 * mass * r2; 3],
            Shape::Cylinder => {
                let length = 2.0 * self.half_length;
                let transverse = mass * (3.0 * r2 + length * length) / 12.0;
                [transverse, transverse, 0.5 * mass * r2]
            }
        }
    }

    /// Half extents along the world axes of the box around the body, m; `axis` is the body's z axis in the world.
    pub fn half_extents(&self, axis: &Vector) -> [f64; 3] {
        match self.shape {
            Shape::Sphere => [self.radius; 3],
            Shape::Cylinder => [axis.x, axis.y, axis.z].map(|a| {
                let a = if a < 0.0 { -a } else { a };
                let across = 1.0 - a * a;
                self.half_length * a + self.radius * math::sqrt(if across > 0.0 { across } else { 0.0 })
            }),
        }
    }

    /// Gap of the point `p`, given in the body's frame from its centre of mass.
    pub fn gap(&self, p: &Vector) -> Gap {
        match self.shape {
            Shape::Sphere => {
                let length = math::length([p.x, p.y, p.z]);
                // At the very centre every direction is as good: a fixed one keeps the bits.
                let normal = if length > 0.0 { p / length } else { Vector::new(0.0, 0.0, -1.0) };
                Gap { distance: length - self.radius, normal }
            }
            Shape::Cylinder => self.cylinder_gap(p),
        }
    }

    fn cylinder_gap(&self, p: &Vector) -> Gap {
        let from_axis = math::sqrt(p.x * p.x + p.y * p.y);
        let radial = if from_axis > 0.0 {
            Vector::new(p.x / from_axis, p.y / from_axis, 0.0)
        } else {
            Vector::new(1.0, 0.0, 0.0)
        };
        let axial = Vector::new(0.0, 0.0, if p.z < 0.0 { -1.0 } else { 1.0 });
        let beyond_side = from_axis - self.radius;
        let beyond_end = (if p.z < 0.0 { -p.z } else { p.z }) - self.half_length;
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
