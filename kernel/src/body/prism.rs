//! Polyhedra with their mass properties: the homogeneous prism over a convex polygon, and a sector of a
//! turbine disc.
//!
//! Method: area A, centre and second moments of the polygon by sums over its edges (Green's theorem). A prism
//! of thickness t about its middle plane has the moments M (S_yy/A + t^2/12), M (S_xx/A + t^2/12), M (S_xx +
//! S_yy)/A with S_xx the integral of x^2 over the polygon about its centre, in its principal axes.
//! Limits: 3 to 14 corners. A sector's outer arc is replaced by chords, its bore by one chord (a polyhedron
//! is convex).
//! Reference: C. Steger, "On the calculation of arbitrary moments of polygons", TU Muenchen, FGBV-96-05
//! (1996).

use crate::ground::error::{Code, Error, positive};
use crate::ground::math;
use crate::scene::parts::{Attachment, AttachmentKind, Faces, MAX_FACES, Projectile, Scene, Sector, Shape};

/// Largest number of a prism's corners.
pub const MAX_CORNERS: usize = MAX_FACES - 2;
/// Chords in place of a sector's outer arc.
pub const RIM_CHORDS: usize = 8;

/// A prism as a projectile, and where its body axes are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prism {
    /// The projectile, at rest at the origin. Faces: the sides in the order of the corners, then +z and -z.
    pub projectile: Projectile,
    /// Centre of mass in the axes of the corners, m.
    pub centre: [f64; 2],
    /// Angle from the corners' x axis to the body's x axis, rad, in [-pi/4, pi/4].
    pub angle: f64,
}

/// The homogeneous prism over a convex polygon.
///
/// `corners` in m, counter-clockwise, 3 to 14; `thickness` along z, m, > 0; `mass` in kg, > 0.
///
/// # Errors
/// Fields `prism.corners`, `prism.thickness`, `prism.mass`: not finite, not positive, or corners not convex
/// and counter-clockwise. Whether it is large enough for a sheet is left to [`Scene::check`].
pub fn prism(corners: &[[f64; 2]], thickness: f64, mass: f64) -> Result<Prism, Error> {
    positive("prism.thickness", thickness)?;
    positive("prism.mass", mass)?;
    if corners.len() < 3 || corners.len() > MAX_CORNERS {
        let limit = if corners.len() < 3 { 3 } else { MAX_CORNERS };
        return Err(Error::new(Code::OutOfRange, "prism.corners", corners.len() as f64, limit as f64));
    }
    corners.iter().flatten().try_for_each(|&x| crate::ground::error::finite("prism.corners", x))?;
    refuse_not_convex(corners)?;
    Ok(built(corners, thickness, mass))
}

/// The prism over sound corners.
fn built(corners: &[[f64; 2]], thickness: f64, mass: f64) -> Prism {
    let corner = |k: usize| corners.get(k).copied().unwrap_or([0.0; 2]);
    let mut angle = 0.0;
    let profile = Profile::of(corner, corners.len(), thickness, |polygon| {
        // The axes of the corners stay the body's where they are principal axes already.
        let principal = math::abs(polygon.xy) <= 1e-12 * (polygon.xx + polygon.yy);
        angle = if principal { 0.0 } else { principal_angle(polygon) };
        [math::cos(angle), math::sin(angle)]
    });
    let projectile = Projectile {
        shape: Shape::Polyhedron,
        faces: profile.faces(),
        moments: profile.gyration().map(|squared_radius| mass * squared_radius),
        mass,
        position: [0.0; 3],
        velocity: [0.0; 3],
        ..Scene::sheet_3in_sphere().projectile
    };
    Prism { projectile, centre: profile.centre, angle }
}

/// A prism's profile: its corners, and where the body's axes are.
pub(crate) struct Profile<C> {
    corner: C,
    count: usize,
    thickness: f64,
    centre: [f64; 2],
    /// Cosine and sine of the angle from the corners' x axis to the body's.
    turn: [f64; 2],
    /// Integrals of x^2 and y^2 over the area, about the centre, in the body's axes, m^2.
    squares: [f64; 2],
}

impl<C: Fn(usize) -> [f64; 2]> Profile<C> {
    /// The profile of sound corners. `turn`: of the principal axes, from the second moments about the centre.
    fn of(corner: C, count: usize, thickness: f64, turn: impl FnOnce(&AreaMoments) -> [f64; 2]) -> Profile<C> {
        let first = moments_about(&corner, count, [0.0; 2]);
        let centre = [first.x / first.area, first.y / first.area];
        let polygon = moments_about(&corner, count, centre);
        let [cosine, sine] = turn(&polygon);
        let xx = cosine * cosine * polygon.xx + 2.0 * sine * cosine * polygon.xy + sine * sine * polygon.yy;
        let yy = sine * sine * polygon.xx - 2.0 * sine * cosine * polygon.xy + cosine * cosine * polygon.yy;
        let squares = [xx / polygon.area, yy / polygon.area];
        Profile { corner, count, thickness, centre, turn: [cosine, sine], squares }
    }

    /// Squared radii of gyration, m^2.
    pub fn gyration(&self) -> [f64; 3] {
        let ([xx, yy], zz) = (self.squares, self.thickness * self.thickness / 12.0);
        [yy + zz, xx + zz, xx + yy]
    }

    /// The faces: the sides in the order of the corners, then +z and -z.
    pub fn faces(&self) -> Faces {
        let [cosine, sine] = self.turn;
        let sides = (0..self.count).map(move |k| {
            let (normal, distance) = side((self.corner)(k), (self.corner)(next(k, self.count)), self.centre);
            [cosine * normal[0] + sine * normal[1], cosine * normal[1] - sine * normal[0], 0.0, distance]
        });
        let mut faces = Faces { count: self.count as u32 + 2, ..Faces::NONE };
        let planes = sides.chain([1.0, -1.0].map(|z| [0.0, 0.0, z, 0.5 * self.thickness]));
        faces.planes.iter_mut().zip(planes).for_each(|(place, plane)| *place = plane);
        faces
    }
}

/// The profile of a sector by its dimensions. A sector is symmetric: its corners' axes are principal. Its
/// directions come from [`direction`], so that making the solid in the block of a C host takes little
/// stack.
pub(crate) fn of_sector(sector: &Sector) -> Profile<impl Fn(usize) -> [f64; 2]> {
    let Sector { inner_radius, outer_radius, angle, thickness } = *sector;
    let corner = move |k| sector_corner(inner_radius, outer_radius, angle, k, direction);
    Profile::of(corner, sector_count(inner_radius), thickness, |_| [1.0, 0.0])
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

/// A sector of a disc with a bore: body x outward along its middle, body z along the disc's axis.
///
/// `inner_radius` of the bore, m, >= 0; `outer_radius`, m; `angle`, rad, in (0, pi); `thickness`, m; `mass`,
/// kg. The polygon has its corners on both arcs: the rim is made of [`RIM_CHORDS`] equal chords (short of the
/// arc by 1 - cos(angle/16) of the outer radius at the most), the bore is filled up to its one chord. Mass
/// centre and moments are those of the homogeneous prism over this polygon. `centre` of the answer is the
/// centre of mass seen from the disc's axis.
///
/// # Errors
/// Fields `disc_sector.inner_radius`, `disc_sector.outer_radius`, `disc_sector.angle`, and those of
/// [`prism`].
pub fn disc_sector(
    inner_radius: f64,
    outer_radius: f64,
    angle: f64,
    thickness: f64,
    mass: f64,
) -> Result<Prism, Error> {
    positive("disc_sector.outer_radius", outer_radius)?;
    crate::ground::error::finite("disc_sector.inner_radius", inner_radius)?;
    if inner_radius < 0.0 || inner_radius >= outer_radius {
        return Err(Error::new(Code::OutOfRange, "disc_sector.inner_radius", inner_radius, outer_radius));
    }
    positive("disc_sector.angle", angle)?;
    if angle >= core::f64::consts::PI {
        return Err(Error::new(Code::OutOfRange, "disc_sector.angle", angle, core::f64::consts::PI));
    }
    let (corners, count) = sector_corners(inner_radius, outer_radius, angle);
    prism(corners.get(..count).unwrap_or(&corners), thickness, mass)
}

/// Number of a sector's corners: the bore's, which are one without a bore, and the rim's.
fn sector_count(inner_radius: f64) -> usize {
    (if inner_radius > 0.0 { 2 } else { 1 }) + RIM_CHORDS + 1
}

/// A sector's corner: the bore's first, then the rim's. `direction`: cosine and sine of an angle.
fn sector_corner(inner: f64, outer: f64, angle: f64, k: usize, direction: impl Fn(f64) -> [f64; 2]) -> [f64; 2] {
    let bore = if inner > 0.0 { 2 } else { 1 };
    let (radius, turn) = match k {
        0 => (inner, 0.5 * angle),
        1 if bore == 2 => (inner, -0.5 * angle),
        _ => (outer, angle * ((k - bore) as f64 / RIM_CHORDS as f64 - 0.5)),
    };
    direction(turn).map(|part| radius * part)
}

/// All corners of a sector, and how many there are.
fn sector_corners(inner_radius: f64, outer_radius: f64, angle: f64) -> ([[f64; 2]; RIM_CHORDS + 3], usize) {
    let direction = |turn: f64| [math::cos(turn), math::sin(turn)];
    let corners = core::array::from_fn(|k| sector_corner(inner_radius, outer_radius, angle, k, direction));
    (corners, sector_count(inner_radius))
}

impl Scene {
    /// A third of a small turbine disc, rim first, on the 10 in sheet held on four sides: bore 15 mm, rim 40
    /// mm in radius, 10 mm thick, 0.118 kg (a nickel alloy of 8190 kg/m^3), 100 m/s along +z, its axis along
    /// the sheet's y.
    pub fn turbine_disc_sector() -> Scene {
        let large = Scene::sheet_10in_cylinder();
        let (corners, count) = sector_corners(0.015, 0.04, core::f64::consts::TAU / 3.0);
        let body = built(corners.get(..count).unwrap_or(&corners), 0.01, 0.118);
        // A third of a turn about (-1, -1, -1) brings body x, outward, to +z and body z, the disc's axis, to
        // y.
        let rim = 0.04 - body.centre[0];
        Scene {
            attachment: Attachment { kind: AttachmentKind::FourSides, ..large.attachment },
            projectile: Projectile {
                position: [0.0, 0.0, -rim],
                velocity: [0.0, 0.0, 100.0],
                orientation: [0.5, -0.5, -0.5, -0.5],
                ..body.projectile
            },
            ..large
        }
    }
}

/// Integrals over a polygon: of 1, x, y, x^2, y^2, xy.
struct AreaMoments {
    area: f64,
    x: f64,
    y: f64,
    xx: f64,
    yy: f64,
    xy: f64,
}

/// Integrals about a point, by edges.
fn moments_about(corner: &impl Fn(usize) -> [f64; 2], count: usize, [cx, cy]: [f64; 2]) -> AreaMoments {
    let mut sums = AreaMoments { area: 0.0, x: 0.0, y: 0.0, xx: 0.0, yy: 0.0, xy: 0.0 };
    for k in 0..count {
        let (start, end) = (corner(k), corner(next(k, count)));
        let (a, b, c, d) = (start[0] - cx, start[1] - cy, end[0] - cx, end[1] - cy);
        let twice_area = a * d - c * b;
        sums.area += twice_area / 2.0;
        sums.x += (a + c) * twice_area / 6.0;
        sums.y += (b + d) * twice_area / 6.0;
        sums.xx += (a * a + a * c + c * c) * twice_area / 12.0;
        sums.yy += (b * b + b * d + d * d) * twice_area / 12.0;
        sums.xy += (2.0 * a * b + a * d + c * b + 2.0 * c * d) * twice_area / 24.0;
    }
    sums
}

/// The turn to the nearest principal axes: tan(2 angle) = 2 S_xy/(S_xx - S_yy).
fn principal_angle(polygon: &AreaMoments) -> f64 {
    let difference = polygon.xx - polygon.yy;
    let sign = if difference < 0.0 { -1.0 } else { 1.0 };
    0.5 * math::atan2(2.0 * sign * polygon.xy, sign * difference)
}

/// The corner after one.
fn next(k: usize, count: usize) -> usize {
    if k + 1 < count { k + 1 } else { 0 }
}

/// Outward unit normal of an edge and its distance from a point.
fn side(start: [f64; 2], end: [f64; 2], from: [f64; 2]) -> ([f64; 2], f64) {
    let (x, y) = (end[0] - start[0], end[1] - start[1]);
    let length = math::length([x, y, 0.0]);
    let normal = [y / length, -x / length];
    (normal, normal[0] * (start[0] - from[0]) + normal[1] * (start[1] - from[1]))
}

/// Refuses a polygon with a corner to the right of an edge, or with an edge of no length.
fn refuse_not_convex(corners: &[[f64; 2]]) -> Result<(), Error> {
    let bad = |number: usize| Err(Error::new(Code::OutOfRange, "prism.corners", number as f64, 0.0));
    for (k, (&start, &end)) in corners.iter().zip(corners.iter().cycle().skip(1)).enumerate() {
        let mut inside = 0.0;
        for &corner in corners {
            let (_, distance) = side(start, end, corner);
            let reach = math::abs(corner[0]) + math::abs(corner[1]) + math::abs(start[0]) + math::abs(start[1]);
            if distance.is_nan() || distance < -1e-12 * reach {
                return bad(k);
            }
            inside = math::max(distance, inside);
        }
        if inside == 0.0 {
            return bad(k);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::shape::Solid;
    use crate::tests::close;

    #[test]
    fn a_rectangle_gives_a_box_wherever_it_is_and_however_it_is_turned() {
        let cuboid = Solid::of(&Projectile {
            shape: Shape::Box,
            size: [0.03, 0.02, 0.01],
            ..Scene::sheet_3in_sphere().projectile
        });
        for turn in [0.0, 0.3, -0.7] {
            let (c, s) = (math::cos(turn), math::sin(turn));
            let place = |x: f64, y: f64| [0.5 + c * x - s * y, -0.2 + s * x + c * y];
            let corners = [place(-0.015, -0.01), place(0.015, -0.01), place(0.015, 0.01), place(-0.015, 0.01)];
            let made = prism(&corners, 0.01, 0.3).unwrap();
            close(made.angle, turn, 1e-11);
            close(made.centre[0], 0.5, 1e-14);
            close(made.centre[1], -0.2, 1e-14);
            made.projectile.moments.iter().zip(cuboid.inertia(0.3)).for_each(|(&a, b)| close(a, b, 1e-11));
            let sides =
                [[0.0, -1.0, 0.0, 0.01], [1.0, 0.0, 0.0, 0.015], [0.0, 1.0, 0.0, 0.01], [-1.0, 0.0, 0.0, 0.015]];
            let ends = [[0.0, 0.0, 1.0, 0.005], [0.0, 0.0, -1.0, 0.005]];
            let all = sides.iter().chain(&ends).flatten();
            let found = made.projectile.faces.in_use().iter().flatten();
            assert!(found.zip(all).all(|(a, b)| math::abs(a - b) < 1e-12));
        }
    }

    #[test]
    fn a_right_triangle() {
        // Legs a along x, b along y: centre (a/3, b/3), S_xx/A = a^2/18, S_xy/A = -a b/36; zz = (a^2 +
        // b^2)/18.
        let (a, b) = (0.03, 0.04);
        let made = prism(&[[0.0, 0.0], [a, 0.0], [0.0, b]], 0.012, 1.0).unwrap();
        close(made.centre[0], a / 3.0, 1e-14);
        close(made.centre[1], b / 3.0, 1e-14);
        close(made.projectile.moments[2], (a * a + b * b) / 18.0, 1e-13);
        let (xx, yy, xy) = (a * a / 18.0, b * b / 18.0, -a * b / 36.0);
        close(made.angle, 0.5 * math::atan2(-2.0 * xy, yy - xx), 1e-13);
        let root = math::sqrt(0.25 * (xx - yy) * (xx - yy) + xy * xy);
        let t = 0.012 * 0.012 / 12.0;
        close(made.projectile.moments[0], 0.5 * (xx + yy) + root + t, 1e-13);
        close(made.projectile.moments[1], 0.5 * (xx + yy) - root + t, 1e-13);
    }

    /// Against the sector with true arcs: centre 2/3 sin(w)/w (Ro^3 - Ri^3)/(Ro^2 - Ri^2) with w half the
    /// angle, and moment about the disc's axis m (Ro^2 + Ri^2)/2. Eight chords of 1/2 rad are short of the
    /// arc by 5e-4 of its radius at the most; filling the bore up to its chord adds 0.4 % of the area.
    #[test]
    fn a_disc_sector_is_nearly_the_sector_with_arcs() {
        for (inner, outer, angle, tolerance) in [(0.0, 0.03, 0.5, 1e-3), (0.015, 0.04, 0.4, 6e-3)] {
            let made = disc_sector(inner, outer, angle, 0.01, 2.0).unwrap();
            let w = 0.5 * angle;
            let centre = 2.0 / 3.0 * math::sin(w) / w * (outer * outer * outer - inner * inner * inner)
                / (outer * outer - inner * inner);
            assert_eq!(made.angle, 0.0);
            assert!(math::abs(made.centre[1]) < 1e-17);
            close(made.centre[0], centre, tolerance);
            let about_axis = made.projectile.moments[2] + 2.0 * made.centre[0] * made.centre[0];
            close(about_axis, outer * outer + inner * inner, tolerance);
        }
    }

    #[test]
    fn a_disc_sector_by_its_dimensions_is_the_same_body() {
        let mut body = Scene::turbine_disc_sector().projectile;
        let by_faces = Solid::of(&body);
        (body.shape, body.faces, body.moments) = (Shape::DiscSector, Faces::NONE, [0.0; 3]);
        // Its directions are those of another formula.
        assert!((Solid::of(&body).reach() / by_faces.reach() - 1.0).abs() < 1e-15);
        Solid::of(&body).inertia(0.118).iter().zip(by_faces.inertia(0.118)).for_each(|(&a, b)| close(a, b, 1e-14));
        let (a, b) = (of_sector(&body.sector), Scene::turbine_disc_sector().projectile.faces);
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
        let Solid::Polyhedron(body) = Solid::of(&scene.projectile) else { panic!() };
        assert_eq!((scene.projectile.faces.count, body.vertices().len(), body.edges().count()), (13, 22, 33));
        let q = crate::body::pose::normalised(scene.projectile.orientation);
        let extents = Solid::Polyhedron(body.clone()).half_extents(&q);
        let ahead = crate::body::pose::into_body(&q, &crate::body::pose::Vector::new(0.0, 0.0, 1.0));
        close(body.support(&ahead), -scene.projectile.position[2], 1e-14);
        // The disc's axis lies along y, where the body is as long as the disc is thick.
        close(extents[1], 0.005, 1e-14);
        close(extents[0], 0.04 * math::sin(core::f64::consts::PI / 3.0), 1e-14);
    }

    #[test]
    fn what_is_no_prism_is_refused() {
        let square = [[0.0, 0.0], [0.01, 0.0], [0.01, 0.01], [0.0, 0.01]];
        let [a, b, c, d] = square;
        assert!(prism(&square, 0.01, 1.0).is_ok());
        let refused = |corners: &[[f64; 2]], thickness, mass| {
            prism(corners, thickness, mass).err().map(|error| (error.code, error.field))
        };
        assert_eq!(refused(&square, 0.0, 1.0), Some((Code::NotPositive, "prism.thickness")));
        assert_eq!(refused(&square, 0.01, f64::NAN), Some((Code::NotFinite, "prism.mass")));
        assert_eq!(refused(&[a, b, c, [f64::NAN, 0.0]], 0.01, 1.0).map(|refusal| refusal.0), Some(Code::NotFinite));
        for (name, corners) in [
            ("two", &[a, b][..]),
            ("fifteen", &[a; 15]),
            ("four alike", &[a; 4]),
            ("clockwise", &[d, c, b, a]),
            ("crossed", &[a, c, b, d]),
            ("dented", &[a, b, [0.004, 0.004], d]),
            ("on a line", &[a, b, [0.02, 0.0]]),
        ] {
            assert_eq!(refused(corners, 0.01, 1.0), Some((Code::OutOfRange, "prism.corners")), "{name}");
        }
        for (inner, outer, angle, field) in [
            (-0.01, 0.04, 1.0, "disc_sector.inner_radius"),
            (0.04, 0.04, 1.0, "disc_sector.inner_radius"),
            (0.01, 0.0, 1.0, "disc_sector.outer_radius"),
            (0.01, 0.04, 0.0, "disc_sector.angle"),
            (0.01, 0.04, 3.15, "disc_sector.angle"),
        ] {
            assert_eq!(disc_sector(inner, outer, angle, 0.01, 1.0).unwrap_err().field, field);
        }
    }
}
