//! Polyhedra by their vertices, and fragment simulators, as the kernel has them: planes about the centre of
//! mass in principal axes, mass and principal moments.
//!
//! A fragment simulator (MIL-P-46593A, STANAG 2920) is a steel cylinder with a chisel nose: a flat strip
//! across it, and two bevels that fall off from the strip by 35 degrees. Its length follows from its mass.
//! The kernel has 16 faces, so 12 sides stand for the cylinder, with its cross-section: they are 1.2 % nearer
//! to the axis than its surface, their edges 2.3 % farther away.
//! Mass and cross-section are those of the round body, volume and moments within 0.05 % (test).

use fabric_kernel::math::{abs, cos, length, sin, sqrt};
use fabric_kernel::pose::{Vector, components, quaternion};
use fabric_kernel::{Faces, Form, Projectile, Scene, Shape, Solid};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use std::f64::consts::PI;

/// Width of the strip of a chisel nose over the diameter: 2.54 of 5.46 mm, 9.27 of 19.9 mm (MIL-P-46593A,
/// from memory).
const STRIP: f64 = 0.465;

/// Angle between strip and bevel, rad.
const BEVEL: f64 = 35.0 / 180.0 * PI;

/// Distance from a plane over the reach of a body below which a point is on it.
const SAME: f64 = 1e-9;

/// Outward unit normal and distance from a point inside, m.
pub type Plane = [f64; 4];

/// Planes of a fragment simulator, its strip ahead at +z and along y; none if the bevels reach its tail.
pub fn chisel(volume: f64, diameter: f64) -> Option<Vec<Plane>> {
    let section = 0.25 * PI * diameter * diameter;
    // A polygon of 12 sides has 12 tan(15 deg) times the square of this.
    let across = sqrt(section / (12.0 * (2.0 - sqrt(3.0))));
    let half_strip = 0.5 * STRIP * diameter;
    let [sine, cosine] = [sin(BEVEL), cos(BEVEL)];
    let planes = |length: f64| {
        let sides = (0..12).map(|k| PI / 6.0 * f64::from(k)).map(|turn| [cos(turn), sin(turn), 0.0, across]);
        let ends = [1.0, -1.0].map(|z| [0.0, 0.0, z, 0.5 * length]);
        let bevels = [sine, -sine].map(|x| [x, 0.0, cosine, sine * half_strip + cosine * 0.5 * length]);
        sides.chain(ends).chain(bevels).collect::<Vec<_>>()
    };
    // What the bevels take does not depend on the length.
    let long = 4.0 * diameter;
    let length = long + (volume - integrals(&planes(long)).0) / section;
    (length > (across - half_strip) * sine / cosine).then(|| planes(length))
}

/// Distance of a point from a plane, outwards, m.
fn gap([x, y, z, distance]: &Plane, p: &Vector) -> f64 {
    x * p.x + y * p.y + z * p.z - distance
}

/// Planes of the convex hull of points, each once, about their mean.
pub fn hull(numbers: &[f64]) -> Vec<Plane> {
    let points: Vec<Vector> = numbers.chunks(3).map(Vector::from_column_slice).collect();
    let mean = points.iter().sum::<Vector>() / points.len() as f64;
    let points: Vec<Vector> = points.iter().map(|point| point - mean).collect();
    let near = SAME * points.iter().map(|p| length((*p).into())).fold(0.0, f64::max);
    let mut planes: Vec<Plane> = Vec::new();
    for (i, a) in points.iter().enumerate() {
        for (j, b) in points.iter().enumerate().skip(i + 1) {
            for c in points.iter().skip(j + 1) {
                let normal = (b - a).cross(&(c - a));
                let normal = normal / length(normal.into());
                let normal = if normal.dot(a) < 0.0 { -normal } else { normal };
                let plane = [normal.x, normal.y, normal.z, normal.dot(a)];
                let known = planes.iter().any(|plane| [a, b, c].iter().all(|p| abs(gap(plane, p)) <= near));
                // Points in a line, or in one plane with the mean, make no face.
                if plane[3] > near && !known && points.iter().all(|p| gap(&plane, p) <= near) {
                    planes.push(plane);
                }
            }
        }
    }
    planes
}

/// Volume, m^3, and integrals of the place, m^4, and of the products of its coordinates, m^5, over the
/// polyhedron of these planes: sums over tetrahedra of the point inside, the middle of a face and an edge of
/// it.
fn integrals(planes: &[Plane]) -> (f64, Vector, Matrix3<f64>) {
    let mut sums = (0.0, Vector::zeros(), Matrix3::zeros());
    let body =
        Projectile { shape: Shape::Polyhedron, faces: Faces::of(planes), ..Scene::sheet_3in_sphere().projectile };
    let Form::Polyhedron(solid) = Solid::of(&body).form else { return sums };
    for plane in planes {
        let on = |p: &Vector| abs(gap(plane, p)) <= SAME * solid.reach;
        let corners: Vec<Vector> = solid.vertices().iter().copied().filter(on).collect();
        let middle = corners.iter().sum::<Vector>() / corners.len() as f64;
        for [a, b] in solid.edges().filter(|[a, b]| on(a) && on(b)) {
            let volume = abs(middle.dot(&a.cross(&b))) / 6.0;
            let corners = [middle, a, b, middle + a + b];
            sums.0 += volume;
            sums.1 += corners[3] * (0.25 * volume);
            sums.2 += corners.map(|p| p * p.transpose()).iter().sum::<Matrix3<f64>>() * (0.05 * volume);
        }
    }
    sums
}

/// Makes a projectile the polyhedron of these planes, with a density that depends on its volume, kg/m^3. Its
/// axes become the principal ones, its origin the centre of mass; the orientation turns along.
pub fn set(body: &mut Projectile, planes: &[Plane], density: impl Fn(f64) -> f64) {
    let (volume, first, second) = integrals(planes);
    let (density, centre) = (density(volume), first / volume);
    let second = second - centre * centre.transpose() * volume;
    let (mut along, mut axes) = (second.diagonal(), Matrix3::identity());
    // Axes that are principal but for rounding stay.
    if [(0, 1), (0, 2), (1, 2)].iter().any(|place| abs(second[*place]) > 1e-14 * second.trace()) {
        let found = second.symmetric_eigen();
        (along, axes) = (found.eigenvalues, found.eigenvectors);
        axes *= if axes.determinant() < 0.0 { -1.0 } else { 1.0 };
        let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
        body.orientation = components(&(quaternion(body.orientation) * turn.quaternion()));
    }
    let moved = planes.iter().map(|plane| {
        let own = axes.transpose() * Vector::from_column_slice(&plane[..3]);
        [own.x, own.y, own.z, -gap(plane, &centre)]
    });
    (body.shape, body.faces) = (Shape::Polyhedron, Faces::of(&moved.collect::<Vec<_>>()));
    (body.mass, body.moments) = (density * volume, along.map(|one| density * (along.sum() - one)).into());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{parse, textile, write};
    use toml::Table;

    #[track_caller]
    fn scene(body: &str) -> Scene {
        parse(&format!("preset = \"sheet_3in_sphere\"\n[projectile]\n{body}\n[aim]\nspeed = 300\n")).unwrap()
    }

    /// The round body in slices along its strip, a chord wide, and as long as bevels and tail leave it.
    #[test]
    fn a_fragment_simulator_is_nearly_the_round_one() {
        for (calibre, grams, diameter) in
            [(".22", 1.1016, 5.46e-3), (".30", 2.8512, 7.52e-3), (".50", 13.413, 12.6e-3), ("20 mm", 53.783, 19.9e-3)]
        {
            let whole = scene(&format!("shape = \"fsp\"\ncalibre = \"{calibre}\""));
            whole.check().unwrap();
            assert_eq!(parse(&write("sheet_3in_sphere", &whole, &textile::of(&Table::new()))).unwrap(), whole);
            let found = whole.projectile;
            assert!((1e3 * found.mass / grams - 1.0).abs() < 1e-4, "{calibre}: {}", found.mass);
            let [nose, tail] = [12, 13].map(|end| found.faces.in_use()[end][3]);
            assert_eq!(found.position[2], -nose);
            let (slices, mut sums) = (4000, [0.0; 5]);
            for k in 0..slices {
                let x = diameter * ((f64::from(k) + 0.5) / f64::from(slices) - 0.5);
                let half = sqrt(0.25 * diameter * diameter - x * x);
                let top = nose + tail - (x.abs() - 0.5 * STRIP * diameter).max(0.0) * sin(BEVEL) / cos(BEVEL);
                let volume = 2.0 * half * top * diameter / f64::from(slices);
                let own = [1.0, x * x, half * half / 3.0, 0.5 * top, top * top / 3.0];
                sums.iter_mut().zip(own).for_each(|(sum, own)| *sum += volume * own);
            }
            let [volume, xx, yy, z, zz] = sums;
            let zz = zz - z * z / volume;
            let round = [yy + zz, xx + zz, xx + yy].map(|sum| 7850.0 * sum);
            for (found, round) in
                found.moments.iter().chain([&found.mass]).zip(round.iter().chain([&(7850.0 * volume)]))
            {
                assert!((found / round - 1.0).abs() < 5e-4, "{calibre}: {found:e} {round:e}");
            }
        }
        let own = scene("shape = \"fsp\"\nmass = \"17 grain\"\ndiameter = \"5.46 mm\"");
        assert_eq!(own, scene("shape = \"fsp\"\ncalibre = \".22\""));
    }

    /// A box by its corners, turned and moved, with a point inside.
    #[test]
    fn vertices_make_the_polyhedron_of_their_hull() {
        let (turn, edges) = (quaternion([0.5, 0.1, -0.7, 0.5]), Vector::new(0.01, 0.02, 0.03));
        let corner = |k: u8| edges.component_mul(&Vector::from([k & 1, k >> 1 & 1, k >> 2].map(f64::from)));
        let turned = |p: Vector| fabric_kernel::pose::rotate(&turn, &p);
        let points = (0..8).map(|k| turned(corner(k))).chain([turned(corner(7) * 0.4)]);
        let rows: Vec<_> = points.map(|p| format!("{:?}", [p.x, p.y, p.z])).collect();
        let body =
            scene(&format!("shape = \"polyhedron\"\ndensity = 2000\nvertices = [{}]", rows.join(", "))).projectile;
        assert!(body.faces.count == 6 && (body.mass / 0.012 - 1.0).abs() < 1e-12, "{body:?}");
        for [x, y, z, distance] in body.faces.in_use().iter().copied() {
            // In the box's own axes.
            let normal =
                fabric_kernel::pose::rotate(&(turn.conjugate() * quaternion(body.orientation)), &Vector::new(x, y, z));
            let axis = normal.iamax();
            assert!((normal[axis].abs() - 1.0).abs() < 1e-12 && (distance / edges[axis] - 0.5).abs() < 1e-12);
            let moment = body.moments[Vector::new(x, y, z).iamax()];
            let others = edges.norm_squared() - edges[axis] * edges[axis];
            assert!((moment / (0.001 * others) - 1.0).abs() < 1e-12, "{moment}");
        }
        // In its own axes no bit of the orientation changes.
        let rows: Vec<_> = (0..8).map(corner).map(|p| format!("{:?}", [p.x, p.y, p.z])).collect();
        let straight =
            scene(&format!("shape = \"polyhedron\"\nmass = 0.012\nvertices = [{}]", rows.join(", "))).projectile;
        assert_eq!((straight.orientation, straight.mass), ([1.0, 0.0, 0.0, 0.0], 0.012));
    }
}
