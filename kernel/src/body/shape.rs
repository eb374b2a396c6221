//! Signed distance and outward normal of each projectile shape, in the body's frame, and its mass properties.
//!
//! Method: the gap function of a convex body is convex, 1-Lipschitz and zero on the surface; the contact
//! law's non-penetration rests on that, and on nothing else. It is the true distance outside and that of the
//! nearest face inside (polyhedra: [`crate::body::polyhedron`]), less half the thickness of the cloth, whose
//! middle surface the nodes are: phi = d - t/2. The body's origin is its centre of mass, its axes are
//! principal axes.
//! Limits: the radius must be at least the node spacing, or nodes do not see the body.
//! Reference: I. Quilez, "Distance functions" (the cylinder's two-dimensional distance to a rectangle).

use crate::body::polyhedron::{self, Gap, HalfSpaces, Polyhedron};
use crate::body::pose::{Vector, into_body};
use crate::body::sector;
use crate::ground::error::{Code, Error};
use crate::ground::math;
use crate::scene::features::Feature;
use crate::scene::parts::{Faces, Projectile, Scene, Sector, Shape};
use nalgebra::Quaternion;

/// The projectile as the middle surface of the cloth meets it.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// Shape with its own surface.
    pub form: Form,
    /// Half the thickness of the cloth, m; 0 of a body by itself.
    pub half_thickness: f64,
}

impl From<Form> for Solid {
    /// A body by itself.
    fn from(form: Form) -> Solid {
        Solid { form, half_thickness: 0.0 }
    }
}

/// A shape with its dimensions.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant)] // Made once for a simulation, and there is no heap.
pub enum Form {
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

/// Whether flat faces make the shape.
fn has_faces(shape: Shape) -> bool {
    matches!(shape, Shape::Box | Shape::Polyhedron | Shape::DiscSector)
}

/// Refuses dimensions that are too small for the node spacing, or of no body. `moments` only of known mass.
pub(crate) fn check(body: &Projectile, spacing: f64) -> Result<(), Error> {
    match body.shape {
        // Refused by its record.
        shape if has_faces(shape) && !Feature::Polyhedra.is_built() => {}
        Shape::Sphere => at_least(spacing, "projectile.radius", body.radius)?,
        Shape::Cylinder | Shape::HemisphericalCylinder => {
            at_least(spacing, "projectile.radius", body.radius)?;
            at_least(2.0 * spacing, "projectile.length", body.length)?;
            if body.shape == Shape::HemisphericalCylinder && body.length < body.radius {
                return Err(Error::new(Code::OutOfRange, "projectile.length", body.length, body.radius));
            }
        }
        Shape::Box => body.size.into_iter().try_for_each(|edge| at_least(2.0 * spacing, "projectile.size", edge))?,
        Shape::Polyhedron => {
            if body.faces.count < 4 {
                return Err(Error::new(Code::OutOfRange, "projectile.faces.count", body.faces.count.into(), 4.0));
            }
            polyhedron::check(&body.faces, spacing)?;
            if body.mass != 0.0 {
                check_moments(body.moments)?;
            }
        }
        Shape::DiscSector => check_sector(&body.sector, spacing)?,
    }
    Ok(())
}

/// Refuses a dimension below this limit, m.
fn at_least(limit: f64, field: &'static str, value: f64) -> Result<(), Error> {
    if value < limit { Err(Error::new(Code::ProjectileTooSmall, field, value, limit)) } else { Ok(()) }
}

/// Refuses a sector that is too small, or an edge of which is a millionth of the rest.
fn check_sector(sector: &Sector, spacing: f64) -> Result<(), Error> {
    const RADIUS: &str = "projectile.sector.outer_radius";
    const THICKNESS: &str = "projectile.sector.thickness";
    let Sector { inner_radius, outer_radius, thickness, .. } = *sector;
    at_least(spacing, RADIUS, outer_radius)?;
    at_least(2.0 * spacing, THICKNESS, thickness)?;
    let [least, greatest] = [1e-6 * outer_radius, (1.0 - 1e-6) * outer_radius];
    if inner_radius != 0.0 && (inner_radius < least || inner_radius > greatest) {
        let limit = if inner_radius < least { least } else { greatest };
        return Err(Error::new(Code::OutOfRange, "projectile.sector.inner_radius", inner_radius, limit));
    }
    polyhedron::check(&sector::profile(sector).faces(), spacing).map_err(|error| match error.code {
        // A face, whose distance is named, is too near to the centre of mass.
        Code::ProjectileTooSmall => Error { field: RADIUS, ..error },
        // Beyond the range of numbers.
        _ if thickness > outer_radius => Error::new(Code::OutOfRange, THICKNESS, thickness, 0.0),
        _ => Error::new(Code::OutOfRange, RADIUS, outer_radius, 0.0),
    })
}

/// Refuses moments any of which is greater than the other two together (beyond rounding).
fn check_moments(moments: [f64; 3]) -> Result<(), Error> {
    let sum = moments[0] + moments[1] + moments[2];
    let great = moments.into_iter().find(|moment| *moment > (sum - moment) * (1.0 + 1e-9));
    great.map_or(Ok(()), |x| Err(Error::new(Code::ImpossibleMoments, "projectile.moments", x, sum - x)))
}

/// Faces of a shape that has some.
fn faces(body: &Projectile) -> Faces {
    match body.shape {
        Shape::Box => box_faces(body.size),
        Shape::DiscSector => sector::profile(&body.sector).faces(),
        _ => body.faces,
    }
}

/// Radius of the circle in the sheet's plane that a projectile covers, seen along the sheet's normal, m.
/// `orientation`: the body's in the sheet's frame. Cylinders count as upright, as in the paper.
pub(crate) fn reach_in_plane(body: &Projectile, orientation: &Quaternion<f64>) -> f64 {
    if !has_faces(body.shape) || !Feature::Polyhedra.is_built() {
        return body.radius;
    }
    HalfSpaces::of(&faces(body)).reach_across(&into_body(orientation, &Vector::new(0.0, 0.0, 1.0)))
}

impl Form {
    /// The form of a projectile.
    fn of(body: &Projectile) -> Form {
        let (radius, mass) = (body.radius, body.mass);
        let gyration = match body.shape {
            Shape::Sphere => return Form::Sphere { radius },
            Shape::Cylinder => return Form::Cylinder { radius, half_length: 0.5 * body.length },
            Shape::HemisphericalCylinder => {
                let shank = body.length - radius;
                return Form::HemisphericalCylinder { radius, shank, nose: nose(radius, shank) };
            }
            // Refused by its record.
            _ if !Feature::Polyhedra.is_built() => return Form::Sphere { radius },
            Shape::Box => {
                let [a, b, c] = body.size;
                [b * b + c * c, c * c + a * a, a * a + b * b].map(|sum| sum / 12.0)
            }
            // A body of unknown mass has no known moments.
            Shape::Polyhedron => body.moments.map(|moment| if mass > 0.0 { moment / mass } else { 0.0 }),
            // With a mass those of a polyhedron of these moments, to the last bit.
            Shape::DiscSector => sector::profile(&body.sector)
                .gyration()
                .map(|squared| if mass > 0.0 { mass * squared / mass } else { squared }),
        };
        Form::Polyhedron(Polyhedron::new(&faces(body), gyration))
    }
}

impl Solid {
    /// The solid of a projectile by itself.
    pub fn of(body: &Projectile) -> Solid {
        Form::of(body).into()
    }

    /// The solid of a scene, with half the thickness of its cloth about it.
    pub fn of_scene(scene: &Scene) -> Solid {
        Solid { form: Form::of(&scene.projectile), half_thickness: 0.5 * scene.thickness() }
    }

    /// Distance from its surface at which a node touches, m.
    #[inline(always)]
    fn off(&self) -> f64 {
        if Feature::Thickness.is_built() { self.half_thickness } else { 0.0 }
    }

    /// The radius that "exited" measures travel by, m: for a box half the least edge, for a polyhedron the
    /// least distance of a face from the centre of mass.
    pub fn radius(&self) -> f64 {
        let radius = match &self.form {
            Form::Sphere { radius } | Form::Cylinder { radius, .. } | Form::HemisphericalCylinder { radius, .. } => {
                *radius
            }
            Form::Polyhedron(body) => body.least_distance(),
        };
        radius + self.off()
    }

    /// Least radius of what is curved of the surface that nodes meet, m.
    pub(crate) fn least_curvature_radius(&self) -> f64 {
        if self.off() > 0.0 { math::min(self.radius(), self.off()) } else { self.radius() }
    }

    /// Depth above which a plane presses a node that stays off the surface, m, of `touching`; 0 of another.
    pub(crate) fn least_depth(&self, touching: f64) -> f64 {
        if self.off() > 0.0 { touching } else { 0.0 }
    }

    /// Distance from the centre of mass to the farthest surface point, m.
    pub fn reach(&self) -> f64 {
        let reach = match &self.form {
            Form::Sphere { radius } => *radius,
            Form::Cylinder { radius, half_length } => math::sqrt(radius * radius + half_length * half_length),
            Form::HemisphericalCylinder { radius, shank, nose } => {
                let end = nose - shank;
                let rim = math::sqrt(radius * radius + end * end);
                math::max(nose + radius, rim)
            }
            Form::Polyhedron(body) => body.reach,
        };
        reach + self.off()
    }

    /// Whether contact without friction can turn the body. A sphere's forces pass through its centre.
    pub fn feels_torque(&self) -> bool {
        !matches!(self.form, Form::Sphere { .. })
    }

    /// Principal moments of inertia about the centre of mass, kg m^2, for a given mass. Homogeneous but for a
    /// polyhedron, whose radii of gyration are those of the projectile it was made of.
    pub fn inertia(&self, mass: f64) -> [f64; 3] {
        match &self.form {
            Form::Sphere { radius } => [0.4 * mass * (radius * radius); 3],
            Form::Cylinder { radius, half_length } => {
                let (r2, length) = (radius * radius, 2.0 * half_length);
                let transverse = mass * (3.0 * r2 + length * length) / 12.0;
                [transverse, transverse, 0.5 * mass * r2]
            }
            Form::HemisphericalCylinder { radius, shank, nose } => {
                // Parts: a cylinder with its centre at nose - shank/2, and a hemisphere with its own at nose
                // + 3R/8, whose transverse moment about that centre is (2/5 - 9/64) m R^2 = 83/320 m R^2.
                let r2 = radius * radius;
                let whole = shank + 2.0 / 3.0 * radius;
                let (rod, cap) = (mass * shank / whole, mass * (2.0 / 3.0 * radius) / whole);
                let (rod_at, cap_at) = (nose - 0.5 * shank, nose + 0.375 * radius);
                let transverse = rod * ((3.0 * r2 + shank * shank) / 12.0 + rod_at * rod_at)
                    + cap * (83.0 / 320.0 * r2 + cap_at * cap_at);
                [transverse, transverse, (0.5 * rod + 0.4 * cap) * r2]
            }
            Form::Polyhedron(body) => body.gyration.map(|squared_radius| mass * squared_radius),
        }
    }

    /// Distance that the body reaches from its centre of mass along a unit direction in body axes, m.
    pub fn support(&self, direction: &Vector) -> f64 {
        let along = math::abs(direction.z);
        let across = 1.0 - along * along;
        let across = math::sqrt(math::max(across, 0.0));
        let support = match &self.form {
            Form::Sphere { radius } => *radius,
            Form::Cylinder { radius, half_length } => half_length * along + radius * across,
            Form::HemisphericalCylinder { radius, nose, .. } if direction.z > 0.0 => nose * along + radius,
            Form::HemisphericalCylinder { radius, shank, nose } => (shank - nose) * along + radius * across,
            Form::Polyhedron(body) => body.support(direction),
        };
        support + self.off()
    }

    /// Whether the plane through the centre of mass with this unit normal, in body axes, mirrors the body
    /// onto itself, its inertia included (to 1e-9).
    pub fn is_mirrored_by(&self, normal: &Vector) -> bool {
        let (along, across) = (normal.z * normal.z, normal.x * normal.x + normal.y * normal.y);
        match &self.form {
            Form::Sphere { .. } => true,
            Form::Cylinder { .. } => along <= 1e-18 || across <= 1e-18,
            Form::HemisphericalCylinder { .. } => along <= 1e-18,
            Form::Polyhedron(body) => body.is_mirrored_by(normal),
        }
    }

    /// Half extents along the axes of the box about the centre of mass that holds the body, m, in the frame
    /// in which it has this orientation.
    pub fn half_extents(&self, orientation: &Quaternion<f64>) -> [f64; 3] {
        [Vector::x(), Vector::y(), Vector::z()].map(|axis| {
            let direction = into_body(orientation, &axis);
            math::max(self.support(&direction), self.support(&-direction))
        })
    }

    /// Whether the point `p`, in the body's frame, lies higher than `height` above two faces that meet at an
    /// edge, m. Cloth that is thick meets no edge.
    pub fn is_before_an_edge(&self, p: &Vector, height: f64) -> bool {
        if self.off() > 0.0 {
            return false;
        }
        let before_rim = |radius: f64, beyond_end: f64| {
            let from_axis = math::sqrt(p.x * p.x + p.y * p.y);
            from_axis - radius >= height && beyond_end >= height
        };
        match &self.form {
            Form::Sphere { .. } => false,
            Form::Cylinder { radius, half_length } => before_rim(*radius, math::abs(p.z) - half_length),
            Form::HemisphericalCylinder { radius, shank, nose } => before_rim(*radius, nose - shank - p.z),
            Form::Polyhedron(body) => body.is_before_an_edge(p, height),
        }
    }

    /// (M12) Gap of the point `p`, given in the body's frame from its centre of mass.
    #[inline]
    pub fn gap(&self, p: &Vector) -> Gap {
        let gap = match &self.form {
            Form::Sphere { radius } => return sphere_gap(p, radius + self.off()),
            Form::Polyhedron(body) => return body.gap(p, self.off(), f64::INFINITY),
            Form::Cylinder { radius, half_length } => {
                let axial = Vector::new(0.0, 0.0, if p.z < 0.0 { -1.0 } else { 1.0 });
                rim_gap(p, *radius, math::abs(p.z) - half_length, axial)
            }
            Form::HemisphericalCylinder { radius, shank, nose } => {
                let from_nose = Vector::new(p.x, p.y, p.z - nose);
                let (beyond_end, flat) = (-from_nose.z - shank, Vector::new(0.0, 0.0, -1.0));
                if from_nose.z <= 0.0 {
                    rim_gap(p, *radius, beyond_end, flat)
                } else {
                    let cap = ball_gap(&from_nose, *radius, Vector::z());
                    if cap.distance > beyond_end { cap } else { Gap { distance: beyond_end, normal: flat } }
                }
            }
        };
        Gap { distance: gap.distance - self.off(), ..gap }
    }

    /// Gap of a point that moves by `step` relative to the body within the time step, m, body axes; at least
    /// `far` of a point that is farther away.
    #[inline]
    pub(crate) fn gap_of_moving(&self, p: &Vector, far: f64, step: impl FnOnce() -> Vector) -> Gap {
        match &self.form {
            // A node that stays off the surface meets no edge.
            Form::Polyhedron(body) if self.off() > 0.0 => body.gap(p, self.off(), far),
            Form::Polyhedron(body) if Feature::Polyhedra.is_built() => body.gap_of_moving(p, far, step),
            _ => self.gap(p),
        }
    }
}

/// z of the hemisphere's centre from the centre of mass. From that centre, a cylinder of volume pi R^2 c has
/// its own at -c/2 and a hemisphere of volume 2/3 pi R^3 at 3R/8.
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

/// Gap of a sphere.
#[inline]
pub(crate) fn sphere_gap(p: &Vector, radius: f64) -> Gap {
    // At the very centre every direction is as good: a fixed one keeps the bits.
    ball_gap(p, radius, Vector::new(0.0, 0.0, -1.0))
}

#[inline]
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
    use crate::tests::{close, number};
    use std::vec::Vec;

    fn cylinder() -> Solid {
        Solid::of(&Scene::sheet_10in_cylinder().projectile)
    }

    fn bullet(radius: f64, length: f64) -> Solid {
        let base = Scene::sheet_3in_sphere().projectile;
        Solid::of(&Projectile { shape: Shape::HemisphericalCylinder, radius, length, ..base })
    }

    fn cuboid(size: [f64; 3]) -> Solid {
        Solid::of(&Projectile { shape: Shape::Box, size, ..Scene::sheet_3in_sphere().projectile })
    }

    /// A regular tetrahedron, whose moments are M e^2/20 with edge e = sqrt(24) times the radius of the
    /// inscribed sphere.
    fn tetrahedron(inscribed: f64) -> Solid {
        let n = math::sqrt(1.0 / 3.0);
        let faces = [[n, n, n, inscribed], [n, -n, -n, inscribed], [-n, n, -n, inscribed], [-n, -n, n, inscribed]];
        let faces = Faces::of(&faces);
        let (mass, base) = (0.02, Scene::sheet_3in_sphere().projectile);
        let moments = [mass * 24.0 * inscribed * inscribed / 20.0; 3];
        Solid::of(&Projectile { shape: Shape::Polyhedron, faces, moments, mass, ..base })
    }

    fn sector() -> Solid {
        let sector = Sector { inner_radius: 0.005, outer_radius: 0.02, angle: 1.2, thickness: 0.008 };
        Solid::of(&Projectile { shape: Shape::DiscSector, sector, ..Scene::sheet_3in_sphere().projectile })
    }

    /// One of each shape; the hemispherical cylinder long, stubby, and with no shank at all. All within 30
    /// mm.
    fn all() -> [Solid; 8] {
        [
            Solid::of(&Scene::sheet_3in_sphere().projectile),
            cylinder(),
            bullet(6e-3, 0.03),
            bullet(0.01, 0.014),
            bullet(0.01, 0.01),
            cuboid([0.01, 0.016, 0.024]),
            tetrahedron(4e-3),
            sector(),
        ]
    }

    fn random_point(k: u64, half: f64) -> Vector {
        Vector::new(number(3 * k), number(3 * k + 1), number(3 * k + 2)) * half
    }

    #[test]
    fn points_before_an_edge_are_above_two_faces() {
        let before = |solid: &Solid, p: [f64; 3]| solid.is_before_an_edge(&Vector::from(p), -1e-6);
        let block = cuboid([0.01, 0.016, 0.024]);
        let (x, y, z) = (0.005, 0.008, 0.012);
        for (p, expected) in [
            ([x + 1e-3, 0.0, z + 1e-3], true),
            ([x + 1e-3, 0.0, z - 9e-7], true),
            ([x - 9e-7, -y - 1e-3, 0.0], true),
            ([x + 1e-3, 0.0, z - 2e-6], false),
            ([0.0, 0.0, z + 1e-3], false),
            ([0.0, 0.0, 0.0], false),
        ] {
            assert_eq!(before(&block, p), expected, "{p:?}");
        }
        let tube = Form::Cylinder { radius: x, half_length: z }.into();
        let round = Form::HemisphericalCylinder { radius: x, shank: z, nose: 0.0 }.into();
        for (p, ends, rear) in [
            ([0.6 * x + 1e-3, 0.8 * x, z], true, false),
            ([0.6 * x + 1e-3, 0.8 * x, -z - 1e-3], true, true),
            ([0.6 * x - 1e-3, 0.8 * x - 1e-3, -z - 1e-3], false, false),
            ([2.0 * x, 0.0, 2e-6 - z], false, false),
        ] {
            assert_eq!([before(&tube, p), before(&round, p)], [ends, rear], "{p:?}");
        }
        assert!(!before(&Form::Sphere { radius: x }.into(), [2.0 * x, 0.0, 0.0]));
    }

    #[test]
    fn inertia_against_closed_forms() {
        let close = |a: f64, b: f64| close(a, b, 1e-14);
        close(all()[0].inertia(2.0)[0], 0.4 * 2.0 * 6.35e-3 * 6.35e-3);
        let [across, _, along] = Solid::from(Form::Cylinder { radius: 2.0, half_length: 3.0 }).inertia(12.0);
        close(across, 12.0 * (2.0 * 2.0 / 4.0 + 6.0 * 6.0 / 12.0));
        close(along, 12.0 * 2.0 * 2.0 / 2.0);
        // A hemisphere, and a stubby one: both parts about the flat where they meet, moved to the common
        // centre of mass.
        for s in [0.0, 0.012] {
            let r = 0.01;
            let Form::HemisphericalCylinder { nose, .. } = bullet(r, r + s).form else { panic!() };
            let rod = 2.0 * s / (s + 2.0 / 3.0 * r);
            let about_flat = rod * (0.25 * r * r + s * s / 3.0) + (2.0 - rod) * 0.4 * r * r;
            close(nose, (rod * 0.5 * s - (2.0 - rod) * 0.375 * r) / 2.0);
            close(bullet(r, r + s).inertia(2.0)[0], about_flat - 2.0 * nose * nose);
            close(bullet(r, r + s).inertia(2.0)[2], (0.5 * rod + 0.4 * (2.0 - rod)) * r * r);
        }
        let edges = cuboid([3e-3, 4e-3, 12e-3]).inertia(12.0);
        close(edges[0], 160e-6);
        close(edges[1], 153e-6);
        close(edges[2], 25e-6);
        tetrahedron(5e-3).inertia(0.02).iter().for_each(|&moment| close(moment, 0.02 * 24.0 * 25e-6 / 20.0));
    }

    /// Centre of mass, and inertia tensor over the mass (xx yy zz yz zx xy), by the middles of 120 cells an
    /// edge of the enclosing cube. The cells are turned so that no face of the body is in line with them.
    fn integrals(solid: &Solid) -> (Vector, [f64; 6]) {
        const CELLS: i32 = 120;
        let step = 2.0 * solid.reach() / CELLS as f64;
        let at = |k: i32| (k as f64 - 0.5 * CELLS as f64 + 0.5) * step;
        let turn = Quaternion::new(0.8, 0.31, -0.23, 0.45).normalize();
        let (mut cells, mut sum, mut second) = (0.0, Vector::zeros(), [0.0; 6]);
        for (i, j, k) in (0..CELLS).flat_map(|i| (0..CELLS).flat_map(move |j| (0..CELLS).map(move |k| (i, j, k)))) {
            let p = into_body(&turn, &Vector::new(at(i), at(j), at(k)));
            if solid.gap(&p).distance < 0.0 {
                let (xx, yy, zz) = (p.x * p.x, p.y * p.y, p.z * p.z);
                let terms = [yy + zz, xx + zz, xx + yy, p.y * p.z, p.z * p.x, p.x * p.y];
                second.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
                sum += p;
                cells += 1.0;
            }
        }
        (sum / cells, second.map(|sum| sum / cells))
    }

    /// The gap function and the mass properties tell of one body: origin in its centre of mass, axes
    /// principal.
    #[test]
    fn inertia_against_integrals_over_the_inside() {
        for solid in all() {
            let (centre, second) = integrals(&solid);
            let reach = solid.reach();
            assert!(centre.norm() < 1e-3 * reach, "{:e} of {reach:e}: {solid:?}", centre.norm());
            for (moment, integral) in solid.inertia(1.0).iter().zip(second) {
                assert!((moment / integral - 1.0).abs() < 2e-3, "{moment:e} {integral:e}: {solid:?}");
            }
            second[3..].iter().for_each(|product| assert!(product.abs() < 5e-4 * reach * reach));
        }
    }

    #[test]
    fn distances_of_points() {
        let (r, shank) = (6e-3, 0.024);
        let (long, half) = (bullet(r, r + shank), bullet(0.01, 0.01));
        let nose = |solid: &Solid| match &solid.form {
            Form::HemisphericalCylinder { nose, .. } => *nose,
            _ => 0.0,
        };
        let (radius, end) = (6.35e-3, 0.01905);
        // Places from where the nose begins.
        for (solid, x, y, z, expected) in [
            (cylinder(), 0.0, 0.0, end, 0.0),
            (cylinder(), radius, 0.0, 0.0, 0.0),
            (cylinder(), 0.0, radius + 3e-3, end + 4e-3, 5e-3),
            (cylinder(), 0.0, 0.0, 0.0, -radius),
            (cylinder(), 0.0, 1e-3, end - 1e-3, -1e-3),
            (cylinder(), 0.0, -radius - 1e-3, 0.5 * end, 1e-3),
            (long.clone(), 0.0, 0.0, r, 0.0),
            (long.clone(), 0.0, 0.6 * r, 0.8 * r, 0.0),
            (long.clone(), r, 0.0, 0.0, 0.0),
            (long.clone(), 0.0, -r, -0.7 * shank, 0.0),
            (long.clone(), 0.0, 0.3 * r, -shank, 0.0),
            (long.clone(), 3e-3, 0.0, 4e-3, -1e-3),
            (long.clone(), 9e-3, 0.0, 12e-3, 9e-3),
            (long.clone(), 0.0, r + 3e-3, -shank - 4e-3, 5e-3),
            (long, 0.0, 0.0, -shank + 1e-3, -1e-3),
            // Above the middle of a hemisphere's flat the flat is nearer than the dome.
            (half, 0.0, 0.0, 1e-3, -1e-3),
        ] {
            let found = solid.gap(&Vector::new(x, y, nose(&solid) + z)).distance;
            assert!((found - expected).abs() < 1e-17, "{solid:?} at {x} {y} {z}: {found}");
        }
    }

    #[test]
    fn box_distances_and_the_order_of_its_faces() {
        let solid = cuboid([0.02, 0.016, 0.024]);
        let at = |x, y, z| solid.gap(&Vector::new(x, y, z));
        assert_eq!(at(0.0, 0.0, 0.0).distance, -8e-3);
        // On ties the first face in the order +x -x +y -y +z -z.
        assert_eq!(at(0.0, 0.0, 0.0).normal, Vector::new(0.0, 1.0, 0.0));
        assert_eq!(cuboid([0.02; 3]).gap(&Vector::zeros()).normal, Vector::new(1.0, 0.0, 0.0));
        assert_eq!(cuboid([0.02; 3]).gap(&Vector::new(-0.01, 0.01, 0.01)).normal, Vector::new(-1.0, 0.0, 0.0));
    }

    /// Where a ray from the centre leaves the body, found from its sphere, tube and planes, the gap is zero
    /// to rounding; it is negative before and positive after.
    #[test]
    fn zero_set_along_rays() {
        for k in 0..2000 {
            let ray = random_point(k, 1.0).normalize();
            let across = math::sqrt(ray.x * ray.x + ray.y * ray.y);
            let surface = |solid: &Solid| match &solid.form {
                Form::Sphere { radius } => *radius,
                Form::Cylinder { radius, half_length } => (radius / across).min(half_length / ray.z.abs()),
                Form::HemisphericalCylinder { radius, shank, nose } => {
                    // The largest t at which t ray is in the tube or the ball, and not behind the flat.
                    let along = nose * ray.z;
                    let ball = along + math::sqrt(f64::max(along * along - nose * nose + radius * radius, 0.0));
                    let tube = radius / across;
                    let out = if tube * ray.z > *nose { ball } else { tube };
                    if ray.z < 0.0 { out.min((nose - shank) / ray.z) } else { out }
                }
                Form::Polyhedron(body) => body.exit(&ray),
            };
            for solid in all() {
                let t = surface(&solid);
                let gap = solid.gap(&(ray * t)).distance;
                assert!(gap.abs() < 1e-16, "{gap:e} at {t:e}: {solid:?}");
                assert!(
                    solid.gap(&(ray * (0.999 * t))).distance < 0.0 && solid.gap(&(ray * (1.001 * t))).distance > 0.0
                );
            }
        }
    }

    #[test]
    fn gaps_are_convex_and_one_lipschitz() {
        // A few roundings of the largest distance.
        let rounding = 4.0 * 0.05 * 0.5 * f64::EPSILON;
        // Along random chords: the middle is no farther than the mean of the ends, and no slope exceeds 1.
        for solid in all() {
            for k in 0..20_000 {
                let (a, b) = (random_point(2 * k, 0.03), random_point(2 * k + 1, 0.03));
                let (da, db) = (solid.gap(&a).distance, solid.gap(&b).distance);
                let middle = solid.gap(&((a + b) * 0.5));
                assert!(middle.distance <= 0.5 * (da + db) + rounding);
                assert!((da - db).abs() <= (a - b).norm() + rounding);
                assert!((middle.normal.norm() - 1.0).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn normal_is_the_gradient() {
        let step = 1e-8;
        for solid in all() {
            let mut smooth = 0;
            for k in 0..300 {
                let p = random_point(k, 0.02);
                let gap = solid.gap(&p);
                let slopes: Vec<[f64; 2]> = (0..3)
                    .map(|k| {
                        [step, -step].map(|step| {
                            let mut q = p;
                            q[k] += step;
                            (solid.gap(&q).distance - gap.distance) / step
                        })
                    })
                    .collect();
                // Within a step of a kink the two sides differ by more than the curvature gives.
                if slopes.iter().all(|[ahead, behind]| (ahead - behind).abs() < 1e-4) {
                    smooth += 1;
                    assert!(slopes.iter().zip(gap.normal.iter()).all(|(s, n)| (s[0] - n).abs() < 1e-4), "{solid:?}");
                }
            }
            assert!(smooth > 290, "{smooth}");
        }
    }

    #[test]
    fn mirror_planes() {
        let [sphere, rod, long, _, half, cuboid, tetrahedron, sector] = all();
        let n = math::sqrt(0.5);
        let [x, y, z] = [Vector::new(1.0, 0.0, 0.0), Vector::new(0.0, 1.0, 0.0), Vector::new(0.0, 0.0, 1.0)];
        let (across, askew) = (Vector::new(n, -n, 0.0), Vector::new(0.0, 0.6, 0.8));
        let of = |solid: &Solid| [x, y, z, across, askew].map(|normal| solid.is_mirrored_by(&normal));
        assert_eq!(of(&sphere), [true; 5]);
        assert_eq!(of(&rod), [true, true, true, true, false]);
        assert_eq!(of(&long), [true, true, false, true, false]);
        assert_eq!(of(&half), of(&long));
        assert_eq!(of(&cuboid), [true, true, true, false, false]);
        assert_eq!(of(&tetrahedron), [false, false, false, true, false]);
        assert_eq!(of(&sector), [false, true, true, false, false]);
        let square = super::tests::cuboid([0.01, 0.01, 0.02]);
        assert_eq!(of(&square), [true, true, true, true, false]);
        // Every plane along the axis of a body of revolution mirrors it, and none askew.
        for (x, y, z) in [(0.6, 0.8, 0.0), (-0.8, -0.6, 0.0), (0.6, 0.0, 0.8), (0.0, -0.6, 0.8), (0.0, 0.6, -0.8)] {
            let normal = Vector::new(x, y, z);
            assert_eq!([&rod, &long].map(|solid| solid.is_mirrored_by(&normal)), [z == 0.0; 2], "{normal:?}");
        }
        for (tilt, mirrors) in [(5e-10, true), (-5e-10, true), (2e-9, false)] {
            assert_eq!(rod.is_mirrored_by(&Vector::new(tilt, 0.0, 1.0)), mirrors, "{tilt}");
        }
        // Faces of a cube, but heavier to turn about one axis: only the planes across the axes are left.
        let faces = box_faces([0.01; 3]);
        let cube = |moments| {
            let base = Scene::sheet_3in_sphere().projectile;
            Solid::of(&Projectile { shape: Shape::Polyhedron, faces, moments, mass: 1.0, ..base })
        };
        assert_eq!(of(&cube([2e-5; 3])), [true, true, true, true, false]);
        assert_eq!(of(&cube([2e-5, 3e-5, 2e-5])), [true, true, true, false, false]);
    }

    /// Reach and support bound the body, and points of the surface come near them.
    #[test]
    fn reach_and_support_are_the_farthest_points() {
        for solid in all() {
            let half = 1.01 * solid.reach();
            let inside: Vec<Vector> =
                (0..40_000).map(|k| random_point(k, half)).filter(|p| solid.gap(p).distance <= 0.0).collect();
            for k in 0..50 {
                let way = random_point(k, 1.0).normalize();
                let farthest = inside.iter().map(|p| p.dot(&way)).fold(0.0, f64::max);
                let support = solid.support(&way);
                assert!(farthest <= support && farthest > 0.8 * support, "{farthest:e} {support:e} {solid:?}");
                // The plane at the support touches the body: nothing of it is nearer to the point above than
                // that.
                let above = solid.gap(&(way * (support + 1e-3))).distance;
                assert!(above > 0.0);
            }
            assert!(inside.iter().all(|p| p.norm() <= solid.reach()));
            let [a, b, c] = solid.half_extents(&Quaternion::new(0.5, -0.5, 0.1, 0.7).normalize());
            assert!(inside.iter().all(|p| p.norm() <= math::length([a, b, c])));
        }
    }

    /// The point that the support is of lies on the surface, at exactly that height.
    #[test]
    fn support_is_that_of_a_point_of_the_surface() {
        for k in 0..500 {
            let way = random_point(k, 1.0).normalize();
            let ring = |radius: f64, z: f64| {
                let across = math::sqrt(way.x * way.x + way.y * way.y);
                Vector::new(radius * way.x / across, radius * way.y / across, z)
            };
            for solid in all() {
                let point = match &solid.form {
                    Form::Sphere { radius } => way * *radius,
                    Form::Cylinder { radius, half_length } => ring(*radius, half_length.copysign(way.z)),
                    Form::HemisphericalCylinder { radius, nose, .. } if way.z > 0.0 => {
                        way * *radius + Vector::new(0.0, 0.0, *nose)
                    }
                    Form::HemisphericalCylinder { radius, shank, nose } => ring(*radius, nose - shank),
                    // Corners are tested in polyhedron.rs.
                    Form::Polyhedron(_) => continue,
                };
                assert!((solid.support(&way) - point.dot(&way)).abs() < 1e-16, "{solid:?}");
                assert!(solid.gap(&point).distance.abs() < 1e-16);
            }
        }
    }

    #[test]
    fn extents_of_known_bodies() {
        let close = |found: [f64; 3], expected: [f64; 3]| {
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-16), "{found:?} {expected:?}");
        };
        let none = Quaternion::new(1.0, 0.0, 0.0, 0.0);
        let n = math::sqrt(0.5);
        let (about_x, turned) = (Quaternion::new(n, n, 0.0, 0.0), Quaternion::new(0.0, 1.0, 0.0, 0.0));
        close(cylinder().half_extents(&none), [6.35e-3, 6.35e-3, 0.01905]);
        close(cylinder().half_extents(&about_x), [6.35e-3, 0.01905, 6.35e-3]);
        close(cuboid([0.01, 0.016, 0.024]).half_extents(&about_x), [5e-3, 0.012, 8e-3]);
        // Lop-sided: the farther end counts, whichever way up. The nose of a long bullet, the flat's rim of
        // half a ball.
        for (radius, length) in [(6e-3, 0.03), (0.01, 0.01)] {
            let solid = bullet(radius, length);
            let Form::HemisphericalCylinder { nose, shank, .. } = solid.form else { panic!() };
            let (tip, flat) = (nose + radius, shank - nose);
            close(solid.half_extents(&none), [radius, radius, tip.max(flat)]);
            close(solid.half_extents(&turned), [radius, radius, tip.max(flat)]);
            close([solid.reach(), 0.0, 0.0], [tip.max(math::sqrt(radius * radius + flat * flat)), 0.0, 0.0]);
        }
        close([cylinder().reach(), 0.0, 0.0], [math::sqrt(6.35e-3 * 6.35e-3 + 0.01905 * 0.01905), 0.0, 0.0]);
        assert_eq!(
            [cylinder().radius(), bullet(6e-3, 0.03).radius(), cuboid([0.01, 0.016, 0.024]).radius()],
            [6.35e-3, 6e-3, 5e-3]
        );
        // Seen from above, a box covers a circle through its corners, a cylinder by convention that of its
        // radius.
        let body = |shape, size| Projectile { shape, radius: 6.35e-3, size, ..Scene::sheet_3in_sphere().projectile };
        assert_eq!(reach_in_plane(&body(Shape::Cylinder, [0.0; 3]), &about_x), 6.35e-3);
        let corners = math::sqrt(5e-3 * 5e-3 + 0.012 * 0.012);
        assert!((reach_in_plane(&body(Shape::Box, [0.01, 0.016, 0.024]), &about_x) - corners).abs() < 1e-16);
        assert!(!all()[0].feels_torque() && all()[1..].iter().all(Solid::feels_torque));
    }

    #[test]
    fn normals_on_the_axis_and_at_the_centre() {
        let normal = |solid: &Solid, z: f64| solid.gap(&Vector::new(0.0, 0.0, z)).normal;
        // A long cylinder's axis: every way across is as near; the normal is one of them.
        assert_eq!(cylinder().gap(&Vector::zeros()), Gap { distance: -6.35e-3, normal: Vector::x() });
        for (z, sign) in [(0.03, 1.0), (-0.03, -1.0), (0.018, 1.0), (-0.018, -1.0)] {
            assert_eq!(normal(&cylinder(), z), Vector::z() * sign);
        }
        assert_eq!(normal(&all()[0], 0.0), -Vector::z());
        let solid = bullet(6e-3, 0.03);
        let Form::HemisphericalCylinder { nose, .. } = solid.form else { panic!() };
        assert_eq!(normal(&solid, nose + 1e-3), Vector::z());
        assert_eq!(normal(&solid, nose), Vector::x());
        assert_eq!(normal(&solid, nose - 0.025), -Vector::z());
    }

    #[test]
    fn no_moment_is_greater_than_the_others_together() {
        // A flat disc has equality; rounding of 1e-9 is let through.
        for (k, (factor, sound)) in (0..3).flat_map(|k| {
            [(0.5, true), (1.0, true), (1.0 + 0.5e-9, true), (1.0 + 3e-9, false), (2.0, false)].map(|case| (k, case))
        }) {
            let mut moments = [3.0, 3.0, 3.0];
            (moments[k], moments[(k + 1) % 3], moments[(k + 2) % 3]) = (3.0 * factor, 2.0, 1.0);
            // The smaller ones stay possible.
            assert_eq!(check_moments(moments).is_ok(), sound, "{moments:?}");
        }
        let error = check_moments([1.0, 4.0, 2.0]).unwrap_err();
        assert_eq!((error.code, error.value, error.limit), (Code::ImpossibleMoments, 4.0, 3.0));
        // Moments of a body of unknown mass are not read.
        let faces = box_faces([0.01; 3]);
        let base = Scene::sheet_3in_sphere().projectile;
        let body = Projectile { shape: Shape::Polyhedron, faces, moments: [1.0, 4.0, 2.0], mass: 0.0, ..base };
        assert_eq!(check(&body, 7.26e-4), Ok(()));
        assert_eq!(check(&Projectile { mass: 1.0, ..body }, 7.26e-4).unwrap_err().code, Code::ImpossibleMoments);
        assert_eq!(Solid::of(&body).inertia(2.0), [0.0; 3]);
    }
}
