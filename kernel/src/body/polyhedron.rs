//! Convex polyhedra by half-spaces: {x : n_k.x <= b_k for all k}.
//!
//! Method: the true distance, which is convex and of slope 1. Inside it is max_k (n_k.x - b_k), the lowest k
//! on a tie; outside, the height above the highest plane if the foot lies on its face, else the distance from
//! the nearest edge. Vertices are the points where three planes meet and that lie outside none, edges join
//! two that lie on two planes.
//! Limits: at most 16 faces; planes that meet at less than a millionth count as parallel. A point nearer to
//! an edge than 1e-9 of the reach has the normal of a face.

use crate::body::pose::Vector;
use crate::ground::error::{Code, Error, positive};
use crate::ground::math;
use crate::scene::parts::{Faces, MAX_FACES};

/// Gap of a point: signed distance (negative inside) and outward unit normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Signed distance, m.
    pub distance: f64,
    /// Gradient of the distance, outward.
    pub normal: Vector,
}

/// Largest number of vertices: Euler's formula, 2 F - 4.
pub const MAX_VERTICES: usize = 2 * MAX_FACES - 4;

/// Largest number of edges: Euler's formula, 3 F - 6.
const MAX_EDGES: usize = 3 * MAX_FACES - 6;

/// A product of directions below this counts as zero.
const PARALLEL: f64 = 1e-6;
/// Points nearer than this part of their distance from the centre of mass are one.
const SAME: f64 = 1e-9;
/// Growth of a squared distance, far above rounding: no edge is passed over that is as near.
const NEAR: f64 = 1.0 + 1e-6;

/// Outward unit normal and distance from the centre of mass, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Face {
    normal: Vector,
    distance: f64,
}

impl Face {
    /// The plane with its normal at unit length. An exactly unit normal changes no bit.
    fn of([x, y, z, distance]: [f64; 4]) -> Face {
        let squared = x * x + y * y + z * z;
        let scale = if squared == 1.0 { 1.0 } else { 1.0 / math::sqrt(squared) };
        Face { normal: Vector::new(x, y, z) * scale, distance: distance * scale }
    }

    fn gap(&self, p: &Vector) -> f64 {
        self.normal.dot(p) - self.distance
    }

    /// Whether the two planes meet in a line.
    fn meets(&self, other: &Face) -> bool {
        self.normal.dot(&other.normal) < 1.0 - 0.5 * PARALLEL * PARALLEL
    }
}

/// The half-spaces that a polyhedron is made of.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct HalfSpaces {
    faces: [Face; MAX_FACES],
    count: usize,
}

impl HalfSpaces {
    /// Half-spaces below these faces.
    pub(crate) fn of(faces: &Faces) -> HalfSpaces {
        let mut all = [Face::default(); MAX_FACES];
        all.iter_mut().zip(faces.in_use()).for_each(|(face, plane)| *face = Face::of(*plane));
        HalfSpaces { faces: all, count: faces.in_use().len() }
    }

    fn faces(&self) -> &[Face] {
        self.faces.get(..self.count).unwrap_or(&self.faces)
    }

    /// Calls `each` with every point, m, in which three planes meet and that lies outside none, with its
    /// distance from the centre of mass. A vertex of more than three faces comes more than once.
    fn for_each_corner(&self, mut each: impl FnMut(Vector, f64)) {
        for i in 0..self.count {
            for j in i + 1..self.count {
                for k in j + 1..self.count {
                    let Some(corner) = self.meeting_point(i, j, k) else { continue };
                    let length = math::length([corner.x, corner.y, corner.z]);
                    let near = SAME * length;
                    if !self.faces().iter().any(|face| face.gap(&corner) > near) {
                        each(corner, length);
                    }
                }
            }
        }
    }

    /// The point on three faces' planes; None if two of them, or all three, are nearly parallel to one line.
    fn meeting_point(&self, i: usize, j: usize, k: usize) -> Option<Vector> {
        let (a, b, c) = (self.faces.get(i)?, self.faces.get(j)?, self.faces.get(k)?);
        let (bc, ca, ab) = (b.normal.cross(&c.normal), c.normal.cross(&a.normal), a.normal.cross(&b.normal));
        let volume = a.normal.dot(&bc);
        let parallel = (-PARALLEL..=PARALLEL).contains(&volume);
        (!parallel).then(|| (bc * a.distance + ca * b.distance + ab * c.distance) / volume)
    }

    /// Greatest distance of a corner from the line through the centre of mass along a unit direction, m.
    pub(crate) fn reach_across(&self, direction: &Vector) -> f64 {
        let mut greatest = 0.0;
        self.for_each_corner(|corner, _| {
            let across = direction.cross(&corner);
            greatest = math::max(math::length([across.x, across.y, across.z]), greatest);
        });
        greatest
    }

    /// Whether some direction leads away for ever. If any does, so does one along which two planes meet.
    fn is_unbounded(&self) -> bool {
        let mut any_edge = false;
        for (i, a) in self.faces().iter().enumerate() {
            for b in self.faces().iter().skip(i + 1) {
                let along = a.normal.cross(&b.normal);
                let length = math::length([along.x, along.y, along.z]);
                if length <= PARALLEL {
                    continue;
                }
                any_edge = true;
                let along = along / length;
                let free = |way: &Vector| self.faces().iter().all(|face| face.normal.dot(way) <= PARALLEL);
                if free(&along) || free(&-along) {
                    return true;
                }
            }
        }
        !any_edge
    }
}

/// Whether two points are one. `length`: distance of the first from the centre of mass, m.
fn are_one(a: &Vector, b: &Vector, length: f64) -> bool {
    let apart = a - b;
    math::length([apart.x, apart.y, apart.z]) <= SAME * length
}

/// Edge: the two vertices that it joins, by their numbers, and a bit for each plane that it lies on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct BodyEdge {
    ends: [u8; 2],
    planes: u16,
}

/// A polyhedron with its vertices and its inertia per mass.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyhedron {
    half_spaces: HalfSpaces,
    vertices: [Vector; MAX_VERTICES],
    /// Vertices found; more than there are places only if the faces are refused.
    vertex_count: usize,
    edges: [BodyEdge; MAX_EDGES],
    edge_count: usize,
    /// Distance of the farthest vertex from the centre of mass, m.
    pub reach: f64,
    /// Principal moments of inertia over the mass, m^2.
    pub gyration: [f64; 3],
}

impl Polyhedron {
    /// The polyhedron of these faces. `gyration`: principal moments of inertia over the mass, m^2.
    pub fn new(faces: &Faces, gyration: [f64; 3]) -> Polyhedron {
        let mut body = Polyhedron {
            half_spaces: HalfSpaces::of(faces),
            vertices: [Vector::zeros(); MAX_VERTICES],
            vertex_count: 0,
            edges: [BodyEdge::default(); MAX_EDGES],
            edge_count: 0,
            reach: 0.0,
            gyration,
        };
        body.find_vertices();
        body.join_vertices();
        body
    }

    /// Finds the vertices, every one once, and the reach.
    #[inline(never)]
    fn find_vertices(&mut self) {
        let Polyhedron { half_spaces, vertices, vertex_count, reach, .. } = self;
        half_spaces.for_each_corner(|corner, length| {
            let found = vertices.get(..*vertex_count).unwrap_or(&*vertices);
            if found.iter().any(|other| are_one(&corner, other, length)) {
                return;
            }
            if let Some(place) = vertices.get_mut(*vertex_count) {
                *place = corner;
            }
            *vertex_count += 1;
            *reach = math::max(length, *reach);
        });
    }

    /// Finds the edges: pairs of vertices that lie on two faces together.
    #[inline(never)]
    fn join_vertices(&mut self) {
        let (near, count) = (SAME * self.reach, self.vertices().len());
        for (i, j) in (0..count).flat_map(|i| (i + 1..count).map(move |j| (i, j))) {
            let [a, b] = [i, j].map(|k| self.vertices.get(k).copied().unwrap_or_default());
            let faces = self.half_spaces.faces();
            let shared = || faces.iter().enumerate().filter(|(_, f)| f.gap(&a) > -near && f.gap(&b) > -near);
            let first = shared().next();
            if first.is_some_and(|(_, first)| shared().any(|(_, face)| face.meets(first)))
                && let Some(place) = self.edges.get_mut(self.edge_count)
            {
                let planes = shared().fold(0, |all, (k, _)| all | 1 << k);
                *place = BodyEdge { ends: [i as u8, j as u8], planes };
                self.edge_count += 1;
            }
        }
    }

    fn faces(&self) -> &[Face] {
        self.half_spaces.faces()
    }

    /// The vertices, m.
    pub fn vertices(&self) -> &[Vector] {
        self.vertices.get(..self.vertex_count).unwrap_or(&self.vertices)
    }

    /// The two ends of every edge, m.
    pub fn edges(&self) -> impl Iterator<Item = [Vector; 2]> {
        self.edges.iter().take(self.edge_count).map(|edge| edge.ends.map(|k| self.vertex(k)))
    }

    /// Outward normal and area, m^2, of each plane: triangles of its edges and a vertex.
    pub fn face_areas(&self) -> impl Iterator<Item = (Vector, f64)> {
        self.faces().iter().enumerate().map(|(k, face)| {
            let own = || self.edges.iter().take(self.edge_count).filter(move |edge| edge.planes >> k & 1 == 1);
            let first = own().next().map_or(Vector::zeros(), |edge| self.vertex(edge.ends[0]));
            let twice = own().map(|edge| {
                let [a, b] = edge.ends.map(|k| self.vertex(k) - first);
                math::abs(face.normal.dot(&a.cross(&b)))
            });
            (face.normal, 0.5 * twice.sum::<f64>())
        })
    }

    fn vertex(&self, k: u8) -> Vector {
        self.vertices.get(usize::from(k)).copied().unwrap_or_default()
    }

    /// Least distance of a face's plane from the centre of mass, m: a sphere of this radius about it fits
    /// inside.
    pub fn least_distance(&self) -> f64 {
        self.faces().iter().map(|face| face.distance).reduce(|a, b| math::min(b, a)).unwrap_or(0.0)
    }

    /// Whether the plane through the centre of mass with this unit normal mirrors every face onto a face, and
    /// is across a principal axis.
    pub fn is_mirrored_by(&self, normal: &Vector) -> bool {
        let turned = normal.component_mul(&Vector::from(self.gyration)).cross(normal);
        let largest = self.gyration.iter().fold(0.0, |a, &b| math::max(b, a));
        let close = |v: &Vector, scale: f64| math::length([v.x, v.y, v.z]) <= SAME * scale;
        close(&turned, largest)
            && self.faces().iter().all(|face| {
                let image = face.normal - normal * (2.0 * face.normal.dot(normal));
                let same = |other: &Face| {
                    let farther = other.distance - face.distance;
                    close(&(other.normal - image), 1.0) && close(&Vector::new(farther, 0.0, 0.0), face.distance)
                };
                self.faces().iter().any(same)
            })
    }

    /// Distance that the body reaches along a unit direction, m.
    pub fn support(&self, direction: &Vector) -> f64 {
        self.vertices().iter().map(|vertex| vertex.dot(direction)).fold(0.0, |a, b| math::max(b, a))
    }

    /// Whether a point in the body's frame lies higher than `height` above two faces, m.
    pub(crate) fn is_before_an_edge(&self, p: &Vector, height: f64) -> bool {
        self.faces().iter().filter(|face| face.gap(p) >= height).nth(1).is_some()
    }

    /// Heights of a point above the planes, m, and the number of the highest, the lowest on a tie.
    #[inline]
    fn heights(&self, p: &Vector) -> ([f64; MAX_FACES], usize) {
        let (mut heights, mut highest, mut height) = ([f64::NEG_INFINITY; MAX_FACES], 0, f64::NEG_INFINITY);
        for (k, (face, place)) in self.faces().iter().zip(&mut heights).enumerate() {
            *place = face.gap(p);
            if *place > height {
                (highest, height) = (k, *place);
            }
        }
        (heights, highest)
    }

    /// Gap of a point in the body's frame, which stays `off` the surface, m. Beyond an edge and farther away
    /// than `far` it is that of the nearest plane.
    #[inline]
    pub fn gap(&self, p: &Vector, off: f64, far: f64) -> Gap {
        self.gap_at(p, self.heights(p), off, far)
    }

    #[inline]
    fn gap_at(&self, p: &Vector, (heights, highest): ([f64; MAX_FACES], usize), off: f64, far: f64) -> Gap {
        let face = self.faces().get(highest).copied().unwrap_or_default();
        let height = heights.get(highest).copied().unwrap_or_default();
        let gap = Gap { distance: face.normal.dot(p) - (face.distance + off), normal: face.normal };
        if height <= 0.0 || gap.distance >= far {
            return gap;
        }
        // The foot lies above no other plane than those that the point is not as far below.
        let foot = p - face.normal * height;
        let is_beyond =
            |(other, above): (&Face, &f64)| *above > -height && other.gap(&foot) > 0.0 && other.meets(&face);
        if self.faces().iter().zip(&heights).any(is_beyond) {
            self.gap_of_edge(p, &heights, off, gap.normal)
        } else {
            gap
        }
    }

    /// Lower bound of the squared distance from an edge, m^2, by the heights above two of its planes: the
    /// squared distance from its line where they are at right angles.
    fn least_squared(&self, edge: &BodyEdge, heights: &[f64; MAX_FACES]) -> f64 {
        let first = edge.planes.trailing_zeros() as usize;
        let other = (edge.planes & edge.planes.wrapping_sub(1)).trailing_zeros() as usize;
        let ([a, b], faces) = ([first, other].map(|k| heights[k % MAX_FACES]), &self.half_spaces.faces);
        a * a + b * b - 2.0 * faces[first % MAX_FACES].normal.dot(&faces[other % MAX_FACES].normal) * a * b
    }

    /// Gap of a point outside whose nearest point is on an edge: one of a plane that the point is above.
    /// `normal`: of the highest.
    #[inline(never)]
    fn gap_of_edge(&self, p: &Vector, heights: &[f64; MAX_FACES], off: f64, normal: Vector) -> Gap {
        let below = heights.iter().enumerate().fold(0, |all, (k, above)| if *above > 0.0 { all | 1 << k } else { all });
        let edges = || self.edges.iter().take(self.edge_count).filter(|edge| edge.planes & below != 0);
        let way_from = |edge: &BodyEdge| {
            let [a, b] = edge.ends.map(|k| self.vertex(k));
            let (from, along) = (p - a, b - a);
            let part = math::max(math::min(from.dot(&along) / along.norm_squared(), 1.0), 0.0);
            from - along * part
        };
        // Most edges are farther away than the one whose line may be nearest.
        let (mut first, mut lowest, mut bounds) = (None, f64::INFINITY, [f64::INFINITY; MAX_EDGES]);
        for (edge, bound) in edges().zip(&mut bounds) {
            *bound = self.least_squared(edge, heights);
            if *bound < lowest {
                (first, lowest) = (Some(edge), *bound);
            }
        }
        let most = first.map_or(f64::INFINITY, |edge| way_from(edge).norm_squared() * NEAR);
        let (mut nearest, mut least) = (Vector::zeros(), f64::INFINITY);
        for (edge, _) in edges().zip(&bounds).filter(|(_, bound)| **bound <= most) {
            let way = way_from(edge);
            if way.norm_squared() < least {
                (nearest, least) = (way, way.norm_squared());
            }
        }
        let distance = math::sqrt(least);
        let normal = if distance > SAME * self.reach { nearest / distance } else { normal };
        Gap { distance: distance - off, normal }
    }

    /// Gap of a point, nearer than `far`, that moves by `step` relative to the body within the time step, m,
    /// body axes. Before an edge that is equally near to several faces, or on it, the normal is that of the
    /// face that is nearest after the step; if several are, the mean of theirs.
    pub fn gap_of_moving(&self, p: &Vector, far: f64, step: impl FnOnce() -> Vector) -> Gap {
        let (heights, highest) = self.heights(p);
        let mut gap = self.gap_at(p, (heights, highest), 0.0, far);
        let (same, height) = (SAME * self.reach, heights.get(highest).copied().unwrap_or_default());
        let tied = || self.faces().iter().zip(&heights).filter(|(_, above)| **above >= height - same);
        if height < -same || tied().nth(1).is_none() {
            return gap;
        }
        let (step, mut farthest, mut count) = (step(), f64::NEG_INFINITY, 0);
        for (face, _) in tied() {
            let moves = face.normal.dot(&step);
            if moves > farthest + same {
                (gap.normal, farthest, count) = (face.normal, moves, 1);
            } else if moves >= farthest - same {
                (gap.normal, count) = (gap.normal + face.normal, count + 1);
            }
        }
        if count == 1 {
            gap.distance = height;
        } else {
            gap.normal *= 1.0 / math::length([gap.normal.x, gap.normal.y, gap.normal.z]);
        }
        gap
    }
}

/// Refuses planes without a unit normal, not about the centre of mass, nearer to it than the node spacing, or
/// that enclose nothing. There are at most [`MAX_FACES`].
pub(crate) fn check(faces: &Faces, spacing: f64) -> Result<(), Error> {
    const FIELD: &str = "projectile.faces.planes";
    for &[x, y, z, distance] in faces.in_use() {
        let off = math::length([x, y, z]) - 1.0;
        if !(-1e-6..=1e-6).contains(&off) {
            return Err(Error::new(Code::BadNormal, FIELD, off + 1.0, 1.0));
        }
        positive(FIELD, distance)?;
        if distance < spacing {
            return Err(Error::new(Code::ProjectileTooSmall, FIELD, distance, spacing));
        }
    }
    let body = Polyhedron::new(faces, [0.0; 3]);
    if body.half_spaces.is_unbounded() {
        return Err(Error::plain(Code::UnboundedFaces, FIELD));
    }
    // Only planes that meet almost, but not quite, in one point give more.
    let vertices = body.vertex_count.min(MAX_VERTICES + 1);
    if !(4..=MAX_VERTICES).contains(&vertices) {
        return Err(Error::new(Code::UnboundedFaces, FIELD, vertices as f64, MAX_VERTICES as f64));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    impl Polyhedron {
        /// Distance from the centre of mass at which a ray leaves: the nearest plane that it meets from
        /// inside.
        pub(crate) fn exit(&self, ray: &Vector) -> f64 {
            let met = self.faces().iter().filter(|face| face.normal.dot(ray) > 0.0);
            met.map(|face| face.distance / face.normal.dot(ray)).fold(f64::INFINITY, f64::min)
        }
    }

    fn octahedron() -> Vec<[f64; 4]> {
        let n = math::sqrt(1.0 / 3.0);
        let signs = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
        [n, -n].into_iter().flat_map(|x| signs.map(|[y, z]| [x, n * y, n * z, 0.01])).collect()
    }

    fn counts(planes: &[[f64; 4]]) -> (usize, usize) {
        let body = Polyhedron::new(&Faces::of(planes), [0.0; 3]);
        (body.vertices().len(), body.edges().count())
    }

    #[test]
    fn vertices_and_edges_of_regular_bodies() {
        let cube: Vec<[f64; 4]> = (0..3)
            .flat_map(|k| {
                [1.0, -1.0].map(|sign| {
                    let mut plane = [0.0, 0.0, 0.0, 0.01];
                    plane[k] = sign;
                    plane
                })
            })
            .collect();
        assert_eq!(counts(&cube), (8, 12));
        // Four faces meet at each vertex of an octahedron; two planes that only touch at a vertex make no
        // edge.
        assert_eq!(counts(&octahedron()), (6, 12));
        let body = Polyhedron::new(&Faces::of(&octahedron()), [0.0; 3]);
        assert!((body.reach - 0.01 * math::sqrt(3.0)).abs() < 1e-16);
        assert!((body.half_spaces.reach_across(&Vector::new(0.0, 0.0, 1.0)) - body.reach).abs() < 1e-16);
        assert_eq!(body.least_distance(), 0.01);
        // A plane that cuts nothing off adds nothing.
        let idle = [&cube[..], &[[0.6, 0.8, 0.0, 0.03]]].concat();
        assert_eq!(counts(&idle), (8, 12));
        // Octahedron and cube together: a truncated cube, 14 faces; at 0.75 of the corner distance a
        // cuboctahedron.
        let both = |cut: f64| {
            let cut = octahedron().into_iter().map(move |[x, y, z, _]| [x, y, z, cut * 0.01 * math::sqrt(3.0)]);
            cube.iter().copied().chain(cut).collect::<Vec<_>>()
        };
        assert_eq!(counts(&both(0.8)), (24, 36));
        assert_eq!(counts(&both(2.0 / 3.0)), (12, 24));
    }

    #[test]
    fn bodies_without_an_end_are_found() {
        let unbounded = |planes: &[[f64; 4]]| Polyhedron::new(&Faces::of(planes), [0.0; 3]).half_spaces.is_unbounded();
        let all = octahedron();
        assert!(!unbounded(&all));
        // A tube along z, a tube closed at one end, a slab, faces that all look one way.
        let tube = [[1.0, 0.0, 0.0, 0.01], [-1.0, 0.0, 0.0, 0.01], [0.0, 1.0, 0.0, 0.01], [0.0, -1.0, 0.0, 0.01]];
        assert!(unbounded(&tube));
        assert!(unbounded(&[&tube[..], &[[0.0, 0.0, 1.0, 0.01]]].concat()));
        assert!(!unbounded(&[&tube[..], &[[0.0, 0.0, 1.0, 0.01], [0.0, 0.0, -1.0, 0.01]]].concat()));
        assert!(unbounded(&[tube[0], tube[1], tube[0], tube[1]]));
        assert!(unbounded(&all[..4]));
        // Without one of its faces an octahedron is still closed by the others; without two that meet, it is
        // not.
        assert!(!unbounded(&all[1..]));
        assert!(unbounded(&all[2..]));
    }

    #[test]
    fn a_normal_off_by_a_rounding_is_put_right_with_its_distance() {
        let face = Face::of([0.6 * 1.0000001, 0.8 * 1.0000001, 0.0, 0.01 * 1.0000001]);
        assert!((face.normal.norm() - 1.0).abs() < 1e-15 && (face.distance - 0.01).abs() < 1e-17);
    }
}
