//! A sector of a turbine disc as a polyhedron: the homogeneous prism over a convex polygon.
//!
//! Method: area A, centre and second moments of the polygon by sums over its edges (Green's theorem). A prism
//! of thickness t about its middle plane has the moments M (S_yy/A + t^2/12), M (S_xx/A + t^2/12), M (S_xx +
//! S_yy)/A with S_xx the integral of x^2 over the polygon about its centre, in its principal axes: those of a
//! sector are its axes of symmetry.
//! Limits: the outer arc is replaced by chords, which are short of it by 1 - cos(angle/16) of the outer
//! radius at the most; the bore by one chord (a polyhedron is convex).
//! Reference: C. Steger, "On the calculation of arbitrary moments of polygons", TU Muenchen, FGBV-96-05
//! (1996).

use crate::ground::math;
use crate::scene::parts::{Attachment, AttachmentKind, Faces, Projectile, Scene, Sector, Shape};

/// Chords in place of a sector's outer arc.
const RIM_CHORDS: usize = 8;

/// A sector's polygon.
pub(crate) struct Profile<D> {
    sector: Sector,
    /// Cosine and sine of an angle.
    direction: D,
    /// Centre of mass as seen from the disc's axis, m.
    centre: [f64; 2],
    /// Integrals of x^2 and y^2 over the area, about the centre, m^2.
    squares: [f64; 2],
}

/// The profile of a sector by its dimensions. Its directions come from [`direction`], so that making the
/// solid in the block of a C host takes little stack.
pub(crate) fn profile(sector: &Sector) -> Profile<impl Fn(f64) -> [f64; 2]> {
    Profile::of(sector, direction)
}

impl<D: Fn(f64) -> [f64; 2]> Profile<D> {
    fn of(sector: &Sector, direction: D) -> Profile<D> {
        let mut profile = Profile { sector: *sector, direction, centre: [0.0; 2], squares: [0.0; 2] };
        let first = profile.moments_about([0.0; 2]);
        profile.centre = [first.x / first.area, first.y / first.area];
        let polygon = profile.moments_about(profile.centre);
        profile.squares = [polygon.xx / polygon.area, polygon.yy / polygon.area];
        profile
    }

    /// Corners of the bore, which are one without a bore.
    fn bore(&self) -> usize {
        if self.sector.inner_radius > 0.0 { 2 } else { 1 }
    }

    /// Corners: the bore's first, then the rim's.
    fn corner(&self, k: usize) -> [f64; 2] {
        let (Sector { inner_radius, outer_radius, angle, .. }, bore) = (self.sector, self.bore());
        let (radius, angle) = match k {
            0 => (inner_radius, 0.5 * angle),
            1 if bore == 2 => (inner_radius, -0.5 * angle),
            _ => (outer_radius, angle * ((k - bore) as f64 / RIM_CHORDS as f64 - 0.5)),
        };
        (self.direction)(angle).map(|part| radius * part)
    }

    /// The two ends of each side.
    fn sides(&self) -> impl Iterator<Item = [[f64; 2]; 2]> {
        let count = self.bore() + RIM_CHORDS + 1;
        (0..count).map(move |k| [self.corner(k), self.corner(if k + 1 < count { k + 1 } else { 0 })])
    }

    /// Integrals about a point, by edges.
    fn moments_about(&self, [cx, cy]: [f64; 2]) -> AreaMoments {
        let mut sums = AreaMoments::default();
        for [start, end] in self.sides() {
            let (a, b, c, d) = (start[0] - cx, start[1] - cy, end[0] - cx, end[1] - cy);
            let twice_area = a * d - c * b;
            sums.area += twice_area / 2.0;
            sums.x += (a + c) * twice_area / 6.0;
            sums.y += (b + d) * twice_area / 6.0;
            sums.xx += (a * a + a * c + c * c) * twice_area / 12.0;
            sums.yy += (b * b + b * d + d * d) * twice_area / 12.0;
        }
        sums
    }

    /// Squared radii of gyration, m^2.
    pub fn gyration(&self) -> [f64; 3] {
        let ([xx, yy], zz) = (self.squares, self.sector.thickness * self.sector.thickness / 12.0);
        [yy + zz, xx + zz, xx + yy]
    }

    /// The faces: the sides in the order of the corners, then +z and -z.
    pub fn faces(&self) -> Faces {
        let sides = self.sides().map(|[start, end]| {
            let (x, y) = (end[0] - start[0], end[1] - start[1]);
            let length = math::length([x, y, 0.0]);
            let normal = [y / length, -x / length];
            let distance = normal[0] * (start[0] - self.centre[0]) + normal[1] * (start[1] - self.centre[1]);
            // An image of the state tells -0 from 0, which y may be.
            [normal[0], normal[1] + 0.0, 0.0, distance]
        });
        let planes = sides.chain([1.0, -1.0].map(|z| [0.0, 0.0, z, 0.5 * self.sector.thickness]));
        let mut faces = Faces { count: (self.bore() + RIM_CHORDS + 3) as u32, ..Faces::NONE };
        faces.planes.iter_mut().zip(planes).for_each(|(place, plane)| *place = plane);
        faces
    }
}

/// Integrals over a polygon: of 1, x, y, x^2, y^2.
#[derive(Default)]
struct AreaMoments {
    area: f64,
    x: f64,
    y: f64,
    xx: f64,
    yy: f64,
}

/// Cosine and sine of an angle of at most pi/2, to some 1e-15: series at an eighth of it, and three doublings
/// of the angle.
fn direction(angle: f64) -> [f64; 2] {
    let x = angle / 8.0;
    let x2 = x * x;
    let mut sine =
        x * (1.0 - x2 / 6.0 * (1.0 - x2 / 20.0 * (1.0 - x2 / 42.0 * (1.0 - x2 / 72.0 * (1.0 - x2 / 110.0)))));
    // 1 - cos keeps its digits where the angle is small.
    let mut short = x2 / 2.0 * (1.0 - x2 / 12.0 * (1.0 - x2 / 30.0 * (1.0 - x2 / 56.0 * (1.0 - x2 / 90.0))));
    for _ in 0..3 {
        (sine, short) = (2.0 * sine * (1.0 - short), 2.0 * sine * sine);
    }
    [1.0 - short, sine]
}

impl Scene {
    /// A third of a small turbine disc, rim first, on the 10 in sheet held on four sides: bore 15 mm, rim 40
    /// mm in radius, 10 mm thick (the defaults of a sector), 0.118 kg (a nickel alloy of 8190 kg/m^3), 100
    /// m/s along +z, its axis along the sheet's y.
    pub fn turbine_disc_sector() -> Scene {
        let (large, body) = (Scene::sheet_10in_cylinder(), Scene::sheet_3in_sphere().projectile);
        let profile = Profile::of(&body.sector, |angle| [math::cos(angle), math::sin(angle)]);
        let mass = 0.118;
        Scene {
            attachment: Attachment { kind: AttachmentKind::FourSides, ..large.attachment },
            projectile: Projectile {
                shape: Shape::Polyhedron,
                faces: profile.faces(),
                moments: profile.gyration().map(|squared_radius| mass * squared_radius),
                mass,
                position: [0.0, 0.0, profile.centre[0] - body.sector.outer_radius],
                // A third of a turn about (-1, -1, -1) brings body x, outward, to +z and body z, the disc's
                // axis, to y.
                orientation: [0.5, -0.5, -0.5, -0.5],
                ..body
            },
            ..large
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::shape::{Form, Solid};
    use crate::tests::close;

    /// Against the sector with true arcs: centre 2/3 sin(w)/w (Ro^3 - Ri^3)/(Ro^2 - Ri^2) with w half the
    /// angle, and moment about the disc's axis m (Ro^2 + Ri^2)/2. Eight chords of 1/2 rad are short of the
    /// arc by 5e-4 of its radius at the most; filling the bore up to its chord adds 0.4 % of the area.
    #[test]
    fn a_disc_sector_is_nearly_the_sector_with_arcs() {
        for (inner, outer, angle, tolerance) in [(0.0, 0.03, 0.5, 1e-3), (0.015, 0.04, 0.4, 6e-3)] {
            let sector = Sector { inner_radius: inner, outer_radius: outer, angle, thickness: 0.01 };
            let made = profile(&sector);
            let w = 0.5 * angle;
            let centre = 2.0 / 3.0 * math::sin(w) / w * (outer * outer * outer - inner * inner * inner)
                / (outer * outer - inner * inner);
            assert!(math::abs(made.centre[1]) < 1e-17);
            close(made.centre[0], centre, tolerance);
            let about_axis = 2.0 * (made.gyration()[2] + made.centre[0] * made.centre[0]);
            close(about_axis, outer * outer + inner * inner, tolerance);
        }
    }

    #[test]
    fn a_disc_sector_by_its_dimensions_is_the_same_body() {
        let mut body = Scene::turbine_disc_sector().projectile;
        let by_faces = Solid::of(&body);
        (body.shape, body.faces, body.moments) = (Shape::DiscSector, Faces::NONE, [0.0; 3]);
        // Directions by another formula.
        assert!((Solid::of(&body).reach() / by_faces.reach() - 1.0).abs() < 1e-15);
        Solid::of(&body).inertia(0.118).iter().zip(by_faces.inertia(0.118)).for_each(|(&a, b)| close(a, b, 1e-14));
        let (a, b) = (profile(&body.sector), Scene::turbine_disc_sector().projectile.faces);
        for (a, b) in a.faces().in_use().iter().zip(b.in_use()) {
            a.iter().zip(b).for_each(|(a, b)| assert!((a - b).abs() < 2e-15, "{a:e} {b:e}"));
        }
        // One of unknown mass has its form all the same.
        body.mass = 0.0;
        let unknown = Solid::of(&body);
        unknown.inertia(0.118).iter().zip(by_faces.inertia(0.118)).for_each(|(&a, b)| close(a, b, 1e-14));
    }

    #[test]
    fn directions_are_cosine_and_sine() {
        for k in -200..=200 {
            let angle = f64::from(k) / 200.0 * core::f64::consts::FRAC_PI_2;
            let [cosine, sine] = direction(angle);
            assert!((cosine - math::cos(angle)).abs() < 1e-15 && (sine - math::sin(angle)).abs() < 1e-15, "{angle}");
        }
    }

    #[test]
    fn the_preset_touches_the_sheet_rim_first() {
        let scene = Scene::turbine_disc_sector();
        scene.check().unwrap();
        let solid = Solid::of(&scene.projectile);
        let Form::Polyhedron(body) = &solid.form else { panic!() };
        assert_eq!((scene.projectile.faces.count, body.vertices().len(), body.edges().count()), (13, 22, 33));
        let q = crate::body::pose::normalised(scene.projectile.orientation);
        let extents = solid.half_extents(&q);
        let ahead = crate::body::pose::into_body(&q, &crate::body::pose::Vector::new(0.0, 0.0, 1.0));
        close(body.support(&ahead), -scene.projectile.position[2], 1e-14);
        // The disc's axis lies along y, where the body is as long as the disc is thick.
        close(extents[1], 0.005, 1e-14);
        close(extents[0], 0.04 * math::sin(core::f64::consts::PI / 3.0), 1e-14);
    }
}
