//! Polyhedra by their vertices, and fragment simulators, as the kernel has them: planes about the centre of mass in principal axes,
//! mass and principal moments.
//!
//! A fragment simulator (MIL-P-46593A, STANAG 2920) is a steel cylinder with a chisel nose: a flat strip across it, and two bevels that
//! fall off from the strip by 35 degrees. Its length follows from its mass. The kernel has 16 faces, so 12 sides stand for
//! the cylinder, with its cross-section: they are 1.2 % nearer to the axis than its surface, their edges 2.3 % farther away.
//! Mass and cross-section are those of the round body, volume and moments within 0.05 % (test).

use crate::derived::{FSP, Given, of, positive};
use crate::{Result, bad, reals, short, units};
use fabric::math::{abs, cos, length, max, sin, sqrt};
use fabric::pose::{Vector, components, into_body, quaternion};
use fabric::{Faces, Projectile, Scene, Shape, Solid};
use std::f64::consts::PI;
use toml::Table;

/// Sizes of fragment simulators with their sources.
pub const FRAGMENTS: &str = include_str!("fragments.toml");

/// Width of the strip of a chisel nose over the diameter: 2.54 of 5.46 mm, 9.27 of 19.9 mm (MIL-P-46593A, from memory).
const STRIP: f64 = 0.465;

/// Angle between strip and bevel, rad.
const BEVEL: f64 = 35.0 / 180.0 * PI;

/// Most vertices that a file may give.
const MOST_VERTICES: usize = 64;

/// Distance over the reach of a body below which a point is on a plane, and two planes are one.
const SAME: f64 = 1e-9;

/// Gives the projectile faces, mass and moments, if the file has a fragment simulator or vertices. `density` and `mass`: those of the
/// file, kg/m^3 and kg; `steel`: density of a fragment simulator. Returns whether it has.
pub fn shape(
    given: &Given,
    body: &mut Projectile,
    density: Option<f64>,
    mass: Option<f64>,
    steel: f64,
) -> Result<bool> {
    const VERTICES: &str = "projectile.vertices";
    if of(given, FSP).is_some() {
        let (mass, diameter) = size(given, mass)?;
        let planes = chisel(mass / steel, diameter);
        let Some(planes) = planes else {
            let text = format!("{mass} kg of steel are too short for a chisel nose {diameter} m wide");
            return bad("projectile.diameter", format!("projectile.diameter: {text}; give another mass or diameter"));
        };
        set(body, &planes, |volume| mass / volume);
        return Ok(true);
    }
    if let Some(calibre) = of(given, "projectile.calibre") {
        let text = format!("projectile.calibre = {}: is read with shape = \"fsp\" only", short(&calibre.to_string()));
        return bad("projectile.calibre", text);
    }
    let Some(value) = of(given, VERTICES) else { return Ok(false) };
    let refused = |text: &str| bad(VERTICES, format!("{VERTICES}: {text}"));
    let mut numbers = Vec::new();
    if reals(value, &[MOST_VERTICES, 3], &|_| "m", &mut numbers).is_none() || !numbers.iter().all(|x| x.is_finite()) {
        return refused(&format!("must be at most {MOST_VERTICES} rows of 3 numbers{}", units::expected("m")));
    }
    if body.shape != Shape::Polyhedron {
        return refused("are read with shape = \"polyhedron\" only");
    }
    let Some(weighed) = density.or(mass) else {
        return refused("no mass: give projectile.material, density or mass");
    };
    let points: Vec<Vector> = numbers.chunks(3).map(|p| Vector::new(p[0], p[1], p[2])).collect();
    let planes = hull(&points);
    if planes.len() < 4 {
        return refused("these points enclose nothing");
    }
    if planes.len() > fabric::MAX_FACES {
        let [faces, most] = [planes.len(), fabric::MAX_FACES];
        return refused(&format!("the hull of these points has {faces} faces; there may be {most}"));
    }
    set(body, &planes, |volume| if density.is_some() { weighed } else { weighed / volume });
    Ok(true)
}

/// Mass, kg, and diameter, m, of a fragment simulator: of its calibre, or as they are given.
fn size(given: &Given, mass: Option<f64>) -> Result<(f64, f64)> {
    let key = "projectile.calibre";
    let known: Table = FRAGMENTS.parse()?;
    let names = known.keys().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ");
    let Some(calibre) = of(given, key) else {
        let sized = mass.zip(positive(given, "projectile.diameter")?);
        let text = format!("{key}: missing: one of {names}; of another fragment give projectile.mass and diameter");
        return sized.map_or_else(|| bad(key, text), Ok);
    };
    let number = |part: &str, si| units::number(known.get(calibre.as_str()?)?.get(part)?, si);
    number("mass", "kg")
        .zip(number("diameter", "m"))
        .map_or_else(|| bad(key, format!("{key} = {}: one of {names}", short(&calibre.to_string()))), Ok)
}

/// Planes of a fragment simulator about a point within, its strip ahead at +z and along y; none if the bevels reach its tail.
fn chisel(volume: f64, diameter: f64) -> Option<Vec<[f64; 4]>> {
    let section = 0.25 * PI * diameter * diameter;
    // A polygon of 12 sides has 12 tan(15 deg) times the square of this.
    let across = sqrt(section / (12.0 * (2.0 - sqrt(3.0))));
    let half_strip = 0.5 * STRIP * diameter;
    let [sine, cosine] = [sin(BEVEL), cos(BEVEL)];
    let planes = |length: f64| {
        let side = [[1.0, 0.0], [sqrt(0.75), 0.5], [0.5, sqrt(0.75)], [0.0, 1.0]].into_iter();
        let signs = [[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]];
        let all = side.flat_map(|[x, y]| signs.map(|[a, b]| [a, b, x, y]));
        let once = all.filter(|[a, b, x, y]| (*a > 0.0 || *x > 0.0) && (*b > 0.0 || *y > 0.0));
        let bevel = sine * half_strip + cosine * 0.5 * length;
        once.map(|[a, b, x, y]| [a * x, b * y, 0.0, across])
            .chain([1.0, -1.0].map(|z| [0.0, 0.0, z, 0.5 * length]))
            .chain([1.0, -1.0].map(|x| [x * sine, 0.0, cosine, bevel]))
            .collect::<Vec<_>>()
    };
    // What the bevels take does not depend on the length.
    let long = 4.0 * diameter;
    let length = long + (volume - Integrals::of(&planes(long)).volume) / section;
    (length > (across - half_strip) * sine / cosine).then(|| planes(length))
}

/// Planes of the convex hull of points about their mean, each once.
fn hull(points: &[Vector]) -> Vec<[f64; 4]> {
    let mean = points.iter().sum::<Vector>() / points.len() as f64;
    let points: Vec<Vector> = points.iter().map(|point| point - mean).collect();
    let near = SAME * points.iter().fold(0.0, |far, p| max(length([p.x, p.y, p.z]), far));
    let mut planes: Vec<[f64; 4]> = Vec::new();
    for (i, a) in points.iter().enumerate() {
        for (j, b) in points.iter().enumerate().skip(i + 1) {
            for c in points.iter().skip(j + 1) {
                let normal = (b - a).cross(&(c - a));
                let long = length([normal.x, normal.y, normal.z]);
                let normal = if normal.dot(a) < 0.0 { -normal / long } else { normal / long };
                let distance = normal.dot(a);
                let same = |[x, y, z, other]: &[f64; 4]| {
                    let apart = Vector::new(*x, *y, *z) - normal;
                    length([apart.x, apart.y, apart.z]) <= SAME && abs(distance - other) <= near
                };
                // Of points in a line, or in one plane with the mean, there is no face.
                if distance > near
                    && points.iter().all(|p| normal.dot(p) <= distance + near)
                    && !planes.iter().any(same)
                {
                    planes.push([normal.x, normal.y, normal.z, distance]);
                }
            }
        }
    }
    planes
}

/// Integrals over a polyhedron.
struct Integrals {
    /// m^3.
    volume: f64,
    /// Of the place, m^4.
    first: Vector,
    /// Of the products of its coordinates, m^5.
    second: [[f64; 3]; 3],
}

impl Integrals {
    /// Those of the polyhedron of these planes, about the point from which their distances are, which is inside: sums over the
    /// tetrahedra of that point, the middle of a face and an edge of it.
    fn of(planes: &[[f64; 4]]) -> Integrals {
        let mut sum = Integrals { volume: 0.0, first: Vector::zeros(), second: [[0.0; 3]; 3] };
        let body =
            Projectile { shape: Shape::Polyhedron, faces: Faces::of(planes), ..Scene::sheet_3in_sphere().projectile };
        let Solid::Polyhedron(solid) = Solid::of(&body) else { return sum };
        let near = SAME * solid.reach();
        let on = |[x, y, z, distance]: &[f64; 4], p: &Vector| abs(x * p.x + y * p.y + z * p.z - distance) <= near;
        for plane in planes {
            let corners: Vec<&Vector> = solid.vertices().iter().filter(|p| on(plane, p)).collect();
            let middle = corners.iter().copied().sum::<Vector>() / corners.len() as f64;
            for [a, b] in solid.edges().filter(|[a, b]| on(plane, a) && on(plane, b)) {
                let volume = abs(middle.dot(&a.cross(&b))) / 6.0;
                let total = middle + a + b;
                sum.volume += volume;
                sum.first += total * (0.25 * volume);
                for (i, row) in sum.second.iter_mut().enumerate() {
                    for (j, entry) in row.iter_mut().enumerate() {
                        let products = middle[i] * middle[j] + a[i] * a[j] + b[i] * b[j] + total[i] * total[j];
                        *entry += products * (0.05 * volume);
                    }
                }
            }
        }
        sum
    }
}

/// Makes a projectile the polyhedron of these planes, of a density that depends on its volume, kg/m^3. Its axes become the principal ones, its
/// origin the centre of mass; the orientation turns along.
fn set(body: &mut Projectile, planes: &[[f64; 4]], density: impl Fn(f64) -> f64) {
    let Integrals { volume, first, mut second } = Integrals::of(planes);
    let (density, centre) = (density(volume), first / volume);
    for (i, row) in second.iter_mut().enumerate() {
        row.iter_mut().enumerate().for_each(|(j, entry)| *entry -= volume * centre[i] * centre[j]);
    }
    // Jacobi's rotations: about axis 2 of the first two, and so on.
    let mut turn = quaternion([1.0, 0.0, 0.0, 0.0]);
    let small = 1e-14 * (second[0][0] + second[1][1] + second[2][2]);
    for [p, q, axis] in [[0, 1, 2], [0, 2, 1], [1, 2, 0]].repeat(20) {
        if abs(second[p][q]) <= small {
            continue;
        }
        let ratio = (second[q][q] - second[p][p]) / (2.0 * second[p][q]);
        let tangent = (if ratio < 0.0 { -1.0 } else { 1.0 }) / (abs(ratio) + sqrt(ratio * ratio + 1.0));
        let cosine = 1.0 / sqrt(tangent * tangent + 1.0);
        let sine = tangent * cosine;
        for row in &mut second {
            (row[p], row[q]) = (cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]);
        }
        for k in 0..3 {
            let (a, b) = (second[p][k], second[q][k]);
            (second[p][k], second[q][k]) = (cosine * a - sine * b, sine * a + cosine * b);
        }
        let half = sqrt(0.5 * (1.0 + cosine));
        let mut step = [half, 0.0, 0.0, 0.0];
        step[axis + 1] = if axis == 1 { 0.5 } else { -0.5 } * sine / half;
        turn *= quaternion(step);
    }
    let planes: Vec<[f64; 4]> = planes
        .iter()
        .map(|[x, y, z, distance]| {
            let normal = Vector::new(*x, *y, *z);
            let own = into_body(&turn, &normal);
            [own.x, own.y, own.z, distance - normal.dot(&centre)]
        })
        .collect();
    let [x, y, z] = [0, 1, 2].map(|k| density * second[k][k]);
    (body.shape, body.faces) = (Shape::Polyhedron, Faces::of(&planes));
    (body.mass, body.moments) = (density * volume, [y + z, x + z, x + y]);
    if turn != quaternion([1.0, 0.0, 0.0, 0.0]) {
        body.orientation = components(&(quaternion(body.orientation) * turn));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{parse, textile, write};

    #[track_caller]
    fn body(text: &str) -> Projectile {
        let text = format!("preset = \"sheet_3in_sphere\"\n[projectile]\n{text}\n[aim]\nspeed = 300\n");
        parse(&text).unwrap_or_else(|error| panic!("{error}")).projectile
    }

    /// The round body in slices of its strip's direction: a chord of the circle wide, and as long as bevels and tail leave it.
    #[test]
    fn a_fragment_simulator_is_nearly_the_round_one() {
        for (calibre, mass, diameter) in [
            (".22", 1.1016e-3, 5.46e-3),
            (".30", 2.8512e-3, 7.52e-3),
            (".50", 13.413e-3, 12.6e-3),
            ("20 mm", 53.783e-3, 19.9e-3),
        ] {
            let found = body(&format!("shape = \"fsp\"\ncalibre = \"{calibre}\""));
            assert!((found.mass / mass - 1.0).abs() < 1e-4, "{calibre}: {}", found.mass);
            let length = found.faces.in_use()[12][3] + found.faces.in_use()[13][3];
            let (slices, mut sums) = (4000, [0.0; 5]);
            for k in 0..slices {
                let x = diameter * ((f64::from(k) + 0.5) / f64::from(slices) - 0.5);
                let half = sqrt(0.25 * diameter * diameter - x * x);
                let top = length - max(x.abs() - 0.5 * STRIP * diameter, 0.0) * sin(BEVEL) / cos(BEVEL);
                let volume = 2.0 * half * top * diameter / f64::from(slices);
                let own = [1.0, x * x, half * half / 3.0, 0.5 * top, top * top / 3.0];
                sums.iter_mut().zip(own).for_each(|(sum, own)| *sum += volume * own);
            }
            let [volume, xx, yy, z, zz] = sums;
            let zz = zz - z * z / volume;
            assert!((found.mass / (7850.0 * volume) - 1.0).abs() < 1e-3);
            let round = [yy + zz, xx + zz, xx + yy].map(|sum| sum / volume);
            for (found, round) in found.moments.iter().zip(round) {
                let off = found / mass / round - 1.0;
            }
            // The strip is ahead.
            assert_eq!(found.position[2], -found.faces.in_use()[12][3]);
        }
        let own = body("shape = \"fsp\"\nmass = \"17 grain\"\ndiameter = \"5.46 mm\"");
        assert_eq!(own, body("shape = \"fsp\"\ncalibre = \".22\""));
    }

    /// A box by its corners, turned and moved, with a point inside: its axes are those of its edges, and it lies where its corners say.
    #[test]
    fn vertices_make_the_polyhedron_of_their_hull() {
        let (edges, turn) = ([0.01, 0.02, 0.03], quaternion([0.5, 0.1, -0.7, 0.5]));
        let corner = |k: usize| {
            Vector::new(edges[0] * (k & 1) as f64, edges[1] * (k >> 1 & 1) as f64, edges[2] * (k >> 2) as f64)
        };
        let turned = |p: Vector| fabric::pose::rotate(&turn, &p);
        let rows: Vec<_> = (0..8).map(|k| turned(corner(k))).chain([turned(corner(7) * 0.4)]).collect();
        let rows = rows.iter().map(|p| format!("[{:?}, {:?}, {:?}]", p.x, p.y, p.z)).collect::<Vec<_>>().join(", ");
        let found = body(&format!("shape = \"polyhedron\"\ndensity = 2000\nvertices = [{rows}]"));
        assert_eq!(found.faces.count, 6);
        assert!((found.mass / 0.012 - 1.0).abs() < 1e-12);
        let mut moments = found.moments;
        moments.sort_by(f64::total_cmp);
        for (found, [a, b]) in moments.iter().zip([[0.01, 0.02], [0.01, 0.03], [0.02, 0.03]]) {
            assert!((found / (0.001 * (a * a + b * b)) - 1.0).abs() < 1e-12, "{found}");
        }
        for [x, y, z, distance] in found.faces.in_use() {
            let normal = fabric::pose::rotate(&quaternion(found.orientation), &Vector::new(*x, *y, *z));
            let far = (0..8).map(|k| normal.dot(&turned(corner(k) - Vector::from(edges) * 0.5))).fold(0.0, max);
            assert!(
                (far - distance).abs() < 1e-15
                    && [0.005, 0.01, 0.015].iter().any(|half| (half - distance).abs() < 1e-15)
            );
        }
        // Along its own axes already: no bit of the orientation changes.
        let rows: Vec<_> = (0..8).map(|k| corner(k)).map(|p| format!("[{:?}, {:?}, {:?}]", p.x, p.y, p.z)).collect();
        let straight = body(&format!("shape = \"polyhedron\"\nmass = 0.012\nvertices = [{}]", rows.join(", ")));
        assert_eq!((straight.orientation, straight.mass), ([1.0, 0.0, 0.0, 0.0], 0.012));
    }

    #[test]
    fn a_fragment_simulator_is_written_and_read_again_and_refusals_name_their_key() {
        let text = |body: &str| format!("preset = \"sheet_3in_sphere\"\n[projectile]\n{body}\n[aim]\nspeed = 300\n");
        let scene = parse(&text("shape = \"fsp\"\ncalibre = \"20 mm\"")).unwrap();
        scene.check().unwrap();
        assert_eq!(parse(&write("sheet_3in_sphere", &scene, &textile::of(&Table::new()))).unwrap(), scene);
        for (wrong, told) in [
            ("shape = \"fsp\"", "projectile.calibre: missing: one of \".22\", \".30\", \".50\", \"20 mm\""),
            ("shape = \"fsp\"\ncalibre = \".38\"", "projectile.calibre = \".38\": one of"),
            ("shape = \"fsp\"\ncalibre = \".22\"\nmass = 1e-3", "projectile.calibre and projectile.mass"),
            ("shape = \"fsp\"\ncalibre = \".22\"\nmaterial = \"lead\"", "\"fsp\" and projectile.material"),
            (
                "shape = \"fsp\"\nmass = \"0.1 g\"\ndiameter = \"5.46 mm\"",
                "projectile.diameter: 0.0001 kg of steel are too short",
            ),
            ("calibre = \".22\"", "projectile.calibre = \".22\": is read with shape = \"fsp\" only"),
            (
                "shape = \"polyhedron\"\nmass = 1e-3\nvertices = [[0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0]]",
                "projectile.vertices: these points",
            ),
            (
                "shape = \"polyhedron\"\nvertices = [[0, 0, 0], [0, 1, 0], [1, 0, 0], [0, 0, 1]]",
                "projectile.vertices: no mass",
            ),
            ("mass = 1\nvertices = [[0, 0, 0]]", "projectile.vertices: are read with shape"),
            ("shape = \"polyhedron\"\nmass = 1\nvertices = [[0, 0]]", "projectile.vertices: must be at most 64 rows"),
        ] {
            let error = parse(&text(wrong)).unwrap_err().to_string();
            assert!(error.contains(told), "{wrong}: {error}");
        }
    }
}
