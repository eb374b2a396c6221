//! Candidates for contact: nodes nearer to the projectile than the larger node spacing.
//!
//! Method: rows, chunks and lanes that miss the box and the ball about the body are passed over; the exact
//! gap decides.
//! Limits: as many candidates as the memory has been made for; more are refused before anything has changed.
//! Reference: docs/model.md, "The step".

use crate::body::pose::{self, Vector};
use crate::body::projectile::Body;
use crate::body::shape::{self, Form, Solid};
use crate::contact::candidate::Holder;
use crate::ground::error::Failure;
use crate::ground::lanes::{self, Job, Lane};
use crate::ground::math;
use crate::ground::planes::{self, Axis, CHUNK, Chunk, HOT_PLANES};
use crate::ground::ranges::{NOT_KEPT, end_of_range, range_of, spread};
use crate::memory::arrays::{Arrays, Contacts, RowArrays};
use crate::memory::network::Network;
use crate::memory::records::{Candidate, Tangential};
use crate::scene::features::Feature;
use crate::scene::parts::{Scene, Symmetry};
use crate::sheet::clamp::{self, LET_GO, SLID, slid_by};
use crate::sheet::columns::{COLUMN_PLANES, Net, PLACE, PLACE_Z};
use crate::sheet::places::{Places, rest_offset};
use crate::sheet::weave::{in_runs, meets_runs};
use core::ops::Range;

/// Growth of the box and the ball about the body, far above rounding: it never hides a candidate, and the
/// exact test follows.
pub(crate) const ROUNDING: f64 = 1.0 + 1e-9;

/// The body as the search for candidates sees it.
pub struct Search<'s> {
    solid: &'s Solid,
    body: &'s Body,
    /// Half extents of the box about the body and the margin, m.
    half: [f64; 3],
    /// Square of the radius about the body's centre beyond which nothing is a candidate, m^2.
    reach2: f64,
    margin: f64,
    /// Radius at which a sphere touches, m.
    radius: f64,
    /// Node spacing, m.
    h: f64,
    /// Centre and half extents of the box in the sheet's plane, spacings.
    centre_in_plane: [f64; 2],
    half_in_plane: [f64; 2],
}

impl<'s> Search<'s> {
    /// Prepares a search in a sheet of spacing h, m, for nodes closer than `margin`, m: the larger spacing.
    #[inline(never)]
    pub fn new(solid: &'s Solid, body: &'s Body, h: f64, margin: f64) -> Search<'s> {
        let half = solid.half_extents(&body.orientation).map(|extent| extent + margin * ROUNDING);
        let reach = (solid.reach() + margin) * ROUNDING;
        // In spacings rounding is another: a little more again.
        let half_in_plane = [0, 1].map(|k| half[k] / h * ROUNDING);
        let centre_in_plane = [0, 1].map(|k| body.position[k] / h);
        Search {
            solid,
            body,
            half,
            reach2: reach * reach,
            margin,
            radius: solid.radius(),
            h,
            centre_in_plane,
            half_in_plane,
        }
    }

    /// Columns, rows and plies of the flat sheet outside which no node is in the body's box.
    #[inline(never)]
    pub(crate) fn box_at_rest(&self, scene: &Scene, places: &[Places; 2]) -> [Range<usize>; 3] {
        // In spacings rounding is another: a little more again.
        let ends = |k: usize, h: f64| {
            let half = self.half[k] * ROUNDING;
            [(self.body.position[k] - half) / h, (self.body.position[k] + half) / h]
        };
        let ([h_x, h_y], gap, plies) = (scene.spacings(), scene.ply_gap(), scene.stack.plies as usize);
        let [[left, right], [bottom, top]] = [ends(0, h_x), ends(1, h_y)];
        let plies = if gap > 0.0 {
            let [first, last] = ends(2, gap).map(|end| math::max(end, 0.0) as usize);
            first..last.saturating_add(1).min(plies)
        } else {
            0..plies
        };
        [places[0].within(left, right), places[1].within(bottom, top), plies]
    }

    /// Whether the body reaches beyond the fine part of a graded network. Beyond the edge of the sheet
    /// nothing is coarse.
    fn is_beyond_fine(&self, scene: &Scene) -> bool {
        let axes = [(0, Axis::Horizontal), (1, Axis::Vertical)];
        axes.into_iter().zip(Places::both(scene)).any(|((k, axis), places)| {
            let ([first, last], h) = (places.fine, scene.spacing(axis));
            let (x, reach) = (self.body.position[k], self.half[k] - self.margin);
            let place = |crossing: u32| rest_offset(crossing as usize, places.crossings) * h;
            (first > 0 && x - reach < place(first)) || (last + 1 < places.crossings && x + reach > place(last))
        })
    }

    /// Gap of any point, m.
    #[inline(never)]
    pub fn gap(&self, x: &Vector) -> f64 {
        let r = x - self.body.position;
        let turns = self.solid.feels_torque();
        let r = if turns { pose::into_body(&self.body.orientation, &r) } else { r };
        self.solid.gap(&r).distance
    }

    /// Gap, normal in the sheet's frame and arm in body axes of the point `x`, if it is a candidate.
    pub fn candidate(&self, x: &Vector) -> Option<(f64, Vector, Vector)> {
        let r = x - self.body.position;
        let outside = |k: usize| r[k] > self.half[k] || r[k] < -self.half[k];
        if (0..3).any(outside) || r.norm_squared() > self.reach2 {
            return None;
        }
        self.candidate_at(&r, || self.body.velocity, 0.0)
    }

    /// Gap, normal and arm of a point inside the box and the ball, `r` from the body's centre, m, with its
    /// velocity, m/s.
    #[inline(always)] // Most of its time would be the way of its answer through memory.
    fn candidate_at(&self, r: &Vector, velocity: impl Fn() -> Vector, dt: f64) -> Option<(f64, Vector, Vector)> {
        if let Form::Sphere { .. } = self.solid.form {
            // A sphere needs no body axes: its gap depends on the distance alone.
            let gap = shape::sphere_gap(r, self.radius);
            return (gap.distance < self.margin).then_some((gap.distance, gap.normal, Vector::zeros()));
        }
        let q = &self.body.orientation;
        let r_body = pose::into_body(q, r);
        let gap = self.solid.gap_of_moving(&r_body, self.margin, || {
            let rate =
                pose::into_body(q, &(velocity() - self.body.velocity)) - self.body.angular_velocity.cross(&r_body);
            rate * dt
        });
        (gap.distance < self.margin)
            .then(|| (gap.distance, pose::out_of_body(q, &gap.normal), r_body.cross(&gap.normal)))
    }

    /// Whether no node of a row at y0 is in the box: of all the displacement along y lies in `range`, which
    /// holds 0.
    #[inline]
    pub(crate) fn misses_row(&self, y0: f64, [low, high]: [f64; 2]) -> bool {
        let ([_, y], [_, half]) = (self.centre_in_plane, self.half_in_plane);
        // One end decides, because the other one is no nearer than the row's own place.
        if y0 < y { y0 + high < y - half } else { y0 + low > y + half }
    }

    /// Chunks [first, end) of a row of `count` outside which no node is in the box: of a node in column i at
    /// x0 + i + u, or of a graded network in its place, the displacement u lies in `range`.
    fn chunks(&self, x0: f64, columns: &[Chunk<COLUMN_PLANES>], [low, high]: [f64; 2], count: usize) -> [usize; 2] {
        let ([x, _], [half, _]) = (self.centre_in_plane, self.half_in_plane);
        let (from, to) = (x - half - high, x + half - low);
        if !columns.is_empty() {
            let first = columns.partition_point(|chunk| chunk[PLACE][CHUNK - 1] < from);
            return [first, columns.partition_point(|chunk| chunk[PLACE][0] <= to)];
        }
        // What lies before the first column becomes 0.
        let chunk = |place: f64| (((place - x0) / CHUNK as f64) as usize).min(count);
        [chunk(from), chunk(to) + 1]
    }
}

/// Places of a chunk's nodes from the body.
struct Offsets {
    /// Places from the body's centre, m; not valid for nodes beyond the box or the ball.
    r: [[f64; CHUNK]; 3],
    /// Distance beyond the box and the ball, not above 0 inside.
    beyond: [f64; CHUNK],
}

/// The first of some chunks of a row with a node in the box and the ball, and where its nodes are.
struct Near<'a> {
    search: &'a Search<'a>,
    /// Columns of a graded network or a curved sheet.
    columns: &'a [Chunk<COLUMN_PLANES>],
    row: &'a [Chunk<HOT_PLANES>],
    /// Chunks of the row, [first, end).
    chunks: [usize; 2],
    /// Rest place of the row's first node, spacings.
    first: [f64; 3],
    offsets: &'a mut Offsets,
}

impl Job for Near<'_> {
    type Output = Option<usize>;

    #[inline(always)]
    fn run<L: Lane>(self) -> Option<usize> {
        const COLUMNS: [f64; CHUNK] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
        let Search { body, half, reach2, h, .. } = self.search;
        let (centre, [a, b, c]) = (&body.position, *half);
        let centre = [L::splat(centre.x), L::splat(centre.y), L::splat(centre.z)];
        let half = [L::splat(a), L::splat(b), L::splat(c)];
        let (zero, h, reach2) = (L::splat(0.0), L::splat(*h), L::splat(*reach2));
        let ([x0, y0, z0], [from, end]) = (self.first, self.chunks);
        let columns = self.columns;
        let part = self.row.get(from..end.min(self.row.len())).unwrap_or(&[]);
        let Offsets { r: [out_x, out_y, out_z], beyond: out } = self.offsets;
        for (c, [x, y, z, ..]) in (from..).zip(part) {
            // Offsets in a line are halves, so that no sum of them is rounded.
            let (places, column) = match columns.get(c) {
                Some(columns) => (&columns[PLACE], 0.0),
                None => (&COLUMNS, x0 + (c * CHUNK) as f64),
            };
            let mut near = false;
            for g in 0..CHUNK / L::WIDTH {
                let from_centre =
                    |place: L, u: &[f64; CHUNK], k: usize| place.add(L::load(&L::groups(u)[g])).mul(h).sub(centre[k]);
                let beyond_axis = |r: L, k: usize| r.max(zero.sub(r)).sub(half[k]);
                let rx = from_centre(L::load(&L::groups(places)[g]).add(L::splat(column)), x, 0);
                let beyond_x = beyond_axis(rx, 0);
                if !zero.sub(beyond_x).any_not_below(zero) {
                    // Most of a row lies to one side, and nothing more is asked of nodes beyond the box.
                    beyond_x.store(&mut L::groups_mut(out)[g]);
                    continue;
                }
                let depth = columns.get(c).map_or(L::splat(z0), |columns| L::load(&L::groups(&columns[PLACE_Z])[g]));
                let (ry, rz) = (from_centre(L::splat(y0), y, 1), from_centre(depth, z, 2));
                let beyond_box = beyond_x.max(beyond_axis(ry, 1)).max(beyond_axis(rz, 2));
                let beyond_ball = rx.mul(rx).add(ry.mul(ry)).add(rz.mul(rz)).sub(reach2);
                let beyond = beyond_box.max(beyond_ball);
                rx.store(&mut L::groups_mut(out_x)[g]);
                ry.store(&mut L::groups_mut(out_y)[g]);
                rz.store(&mut L::groups_mut(out_z)[g]);
                beyond.store(&mut L::groups_mut(out)[g]);
                near |= zero.sub(beyond).any_not_below(zero);
            }
            if near {
                return Some(c);
            }
        }
        None
    }
}

/// Nodes under the projectile at t_n.
#[derive(Clone, Copy, Default)]
pub(crate) struct Gathered {
    /// Number of candidates.
    pub count: usize,
    /// Deepest penetration of any, m; 0 if none is inside.
    pub deepest: f64,
    /// Whether the body meets the sheet beyond the fine part of a graded network.
    pub is_beyond_fine: bool,
    /// Losses before the step, J ([`Sums::losses`](crate::memory::state::Sums)).
    pub losses: [f64; 5],
}

impl<'s> Search<'s> {
    /// Search for the candidates of a step in a network.
    pub(crate) fn of(network: &Network<'_>, solid: &'s Solid, body: &'s Body) -> Search<'s> {
        Search::new(solid, body, network.scene.sheet.spacing, network.scene.largest_spacing())
    }
}

/// Copies the nodes closer than a spacing, the larger one, to the projectile. Between a prescribed body and a
/// fixed node there is no compliance: such nodes are no candidates, and their depth is noted alone. Only rows
/// [first, end) are searched.
#[inline(never)]
pub(crate) fn gather(
    network: &mut Network<'_>,
    contacts: &mut Contacts<'_>,
    search: &Search<'_>,
    [first_row, end_row]: [usize; 2],
) -> Result<Gathered, Failure> {
    let Network { scene, layout, model, directions, clamps: law, arrays, instructions, .. } = network;
    let (rise, ply_gap) = (directions.front.vertical.rest.spacing, model.pitch);
    let (nx, chunks) = (layout.nodes_x, layout.chunks);
    let (unit_speed, dt) = (model.unit_speed, model.limits.dt);
    let (nodes_x, nodes_y) = (scene.sheet.nodes_x, scene.sheet.nodes_y);
    let stands_alone = !layout.has(Feature::Grading) && scene.symmetry == Symmetry::default();
    let Contacts { candidates, tangential, .. } = contacts;
    let Arrays { rows, columns, lines, .. } = arrays;
    let RowArrays { hot, ranges, runs, clamps, .. } = rows;
    let net = Net { columns, lines };
    let (free_body, curved) = (scene.is_free(), !net.hoop().is_empty());
    let mut slots = candidates.iter_mut().take(layout.candidates);
    let (mut count, mut deepest) = (0, 0.0);
    let mut offsets = Offsets { r: [[0.0; CHUNK]; 3], beyond: [0.0; CHUNK] };
    // Offsets are exact: those of a row follow from its first.
    let x0 = rest_offset(0, nodes_x);
    for (j, [low, high, left, right]) in ranges.iter_mut().enumerate().take(end_row).skip(first_row) {
        let (ply, row_of_ply) = layout.ply_and_row(j);
        let y0 = rest_offset(row_of_ply, nodes_y) * rise;
        let y0 = if layout.has(Feature::Grading) { planes::get(net.lines, PLACE, j).unwrap_or(y0) } else { y0 };
        if search.misses_row(y0, range_of([*low, *high])) {
            *left = NOT_KEPT;
            continue;
        }
        let z0 = ply as f64 * ply_gap;
        let run = runs.get(j).copied().unwrap_or([0; 4]);
        let row = planes::row(hot, chunks, j);
        let first = [x0, y0, z0];
        if *left == NOT_KEPT && !curved {
            // From here on the sweep keeps it.
            [*left, *right] = spread(row, *instructions).map(end_of_range);
        }
        let columns = layout.columns_of(net.columns, ply);
        // Any column of a curved row may lie at either side of the body.
        let [mut from, end] =
            if curved { [0, chunks] } else { search.chunks(x0, columns, range_of([*left, *right]), chunks) };
        while from < end {
            let next = Near { search, columns, row, chunks: [from, end], first, offsets: &mut offsets };
            let Some(c) = lanes::dispatch(*instructions, next) else { break };
            from = c + 1;
            let Some(chunk) = row.get(c) else { break };
            let held = meets_runs(&run, [c * CHUNK, from * CHUNK]);
            #[allow(clippy::needless_range_loop)] // The lane is a place in several planes.
            for lane in 0..CHUNK {
                let i = c * CHUNK + lane;
                if offsets.beyond[lane] > 0.0 || i >= nx {
                    continue;
                }
                let r = Vector::new(offsets.r[0][lane], offsets.r[1][lane], offsets.r[2][lane]);
                let v = || Vector::from(planes::velocity(chunk, lane));
                let Some((gap, normal, arm)) = search.candidate_at(&r, || v() * unit_speed, dt) else { continue };
                deepest = math::max(-gap, deepest);
                let slid = if held && in_runs(&run, i) { slid_by(clamps, j * chunks + c, lane) } else { LET_GO };
                let fixed = law.hold(slid);
                if fixed && slid == 0.0 && !free_body {
                    continue;
                }
                let Some(slot) = slots.next() else { return Err(Failure::ContactCapacity) };
                let v = v();
                let multiplicity = if stands_alone { 1.0 } else { layout.node_weight(i, j) * net.share(i, j) };
                *slot = Candidate {
                    displacement: planes::displacement(chunk, lane),
                    normal,
                    arm,
                    node: (j * nx + i) as u32,
                    held_by: if fixed { Holder::Support as u32 } else { Holder::None as u32 },
                    multiplicity,
                    speed_before: normal.dot(&v) * unit_speed,
                    free_gap_rate: math::max(gap, 0.0) / dt,
                    effective_mass: 0.0,
                    impulse: 0.0,
                };
                if let Some(place) = tangential.get_mut(count) {
                    *place = Tangential::at(&r, &normal, &(v * unit_speed), search.body);
                }
                count += 1;
            }
        }
    }
    // On the sheet, or with the box across its plane.
    let meets = count > 0 || math::abs(search.body.position.z) <= search.half[2];
    let is_beyond_fine = layout.has(Feature::Grading) && meets && search.is_beyond_fine(scene);
    Ok(Gathered { count, deepest, is_beyond_fine, ..Gathered::default() })
}

/// Adds the nodes' velocities after the sweep, before any impulse, to the candidates' gap rates and slips.
/// Held nodes that have slid leave the jaws of their clamps here: a support that moves would give the body
/// energy.
#[inline(never)]
pub(crate) fn add_free_velocity(network: &mut Network<'_>, contacts: &mut Contacts<'_>, count: usize) {
    let Network { layout, model, clamps: law, arrays, .. } = network;
    let RowArrays { hot, clamps, .. } = &mut arrays.rows;
    let (nx, chunks, unit_speed) = (layout.nodes_x, layout.chunks, model.unit_speed);
    let Contacts { candidates, tangential, .. } = contacts;
    // They come row by row: one division for each row is enough.
    let (mut start, mut row) = (0, planes::row(hot, chunks, 0));
    let mut places = tangential.iter_mut();
    for candidate in candidates.get_mut(..count).unwrap_or_default() {
        let node = candidate.node as usize;
        let mut i = node.wrapping_sub(start);
        if i >= nx {
            let (column, j) = layout.column_and_row(node);
            (i, start, row) = (column, node - column, planes::row(hot, chunks, j));
        }
        let lane = i % CHUNK;
        let Some(chunk) = row.get(i / CHUNK) else { break };
        if candidate.is_fixed()
            && let Some(chunk) = clamp::at_mut(clamps, start / nx.max(1) * chunks + i / CHUNK)
            && chunk[SLID][lane] > 0.0
        {
            candidate.held_by = Holder::None as u32;
            chunk[SLID][lane] = law.leave(chunk[SLID][lane]);
        }
        let v = Vector::from(planes::velocity(chunk, lane));
        debug_assert!(!candidate.is_fixed() || v == Vector::zeros(), "a support stands still");
        candidate.free_gap_rate += candidate.normal.dot(&v) * unit_speed;
        if let Some(t) = places.next() {
            t.speed = t.along(&(v * unit_speed));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::pose;
    use crate::ground::lanes::InstructionSet;
    use crate::scene::parts::{Projectile, Scene, Shape};
    use crate::tests::{number, sphere};
    use std::vec::Vec;

    #[test]
    fn the_box_of_the_search_ends_a_spacing_beyond_the_body() {
        let (solid, mut body) = sphere();
        body.position = Vector::new(0.0, 0.2, 0.0);
        let h = 7.26e-4;
        let search = Search::new(&solid, &body, h, h);
        for (share, inside) in [(0.999, true), (1.0, true), (1.001, false)] {
            let end = share * (solid.radius() + h);
            for (y0, range) in [(end, [0.0, 1.0]), (end + h, [-h, 0.0]), (-end, [-1.0, 0.0]), (-end - h, [0.0, h])] {
                assert_eq!(!search.misses_row((0.2 + y0) / h, range.map(|u| u / h)), inside);
            }
        }
        assert!(!search.misses_row(0.2 / h, [0.0; 2]));
        // Up to a spacing away a node is a candidate, along the axes of the box too.
        for way in [Vector::x(), Vector::y(), Vector::z()] {
            for (away, found) in [(1.0 - 1e-11, true), (1.0 + 1e-8, false)] {
                let x = body.position + way * (solid.radius() + away * h);
                assert_eq!(search.candidate(&x).is_some(), found, "{way:?}");
            }
        }
    }

    #[test]
    fn candidates_are_the_points_nearer_than_a_spacing() {
        let (margin, q) = (1e-3, pose::normalised([0.8, 0.3, -0.2, 0.5]));
        // A rotation matrix has the turned axes as its columns.
        let axes = [Vector::x(), Vector::y(), Vector::z()].map(|axis| pose::rotate(&q, &axis));
        let turned = |v: &Vector| axes[0] * v.x + axes[1] * v.y + axes[2] * v.z;
        for shape in [Shape::Sphere, Shape::Cylinder, Shape::HemisphericalCylinder, Shape::Box] {
            let projectile =
                Projectile { shape, radius: 5e-3, length: 0.02, ..Scene::sheet_10in_cylinder().projectile };
            let solid = Solid::of(&Projectile { size: [0.01, 0.014, 0.02], ..projectile });
            let body = Body { position: Vector::new(0.01, -0.02, 0.03), orientation: q, ..sphere().1 };
            let search = Search::new(&solid, &body, margin, margin);
            let (mut found, size) = (0, 1.2 * (solid.reach() + margin));
            for k in 0..20_000 {
                let r = Vector::new(number(3 * k), number(3 * k + 1), number(3 * k + 2)) * size;
                let gap = solid.gap(&Vector::new(axes[0].dot(&r), axes[1].dot(&r), axes[2].dot(&r)));
                let candidate = search.candidate(&(body.position + r));
                assert_eq!(candidate.is_some(), gap.distance < margin, "{shape:?} {gap:?}");
                if let Some((distance, normal, arm)) = candidate {
                    found += 1;
                    let outward = turned(&gap.normal);
                    assert!((distance - gap.distance).abs() < 1e-16 && (normal - outward).norm() < 1e-13);
                    // The moment of a unit force along the normal.
                    assert!((turned(&arm) - r.cross(&outward)).norm() < 1e-15);
                }
            }
            assert!(found > 1000, "{found}");
        }
    }

    #[test]
    fn the_next_chunk_is_the_first_with_a_node_in_the_box_and_the_ball() {
        let (solid, mut body) = sphere();
        let (h, first) = (1e-3, [-40.0, 2.0, 0.0]);
        body.position = Vector::new(0.0123, -0.004, 0.002);
        let half = (solid.radius() + h) / h;
        let search = Search::new(&solid, &body, h, h);
        let (mut hits, mut misses, mut left_out) = (0, 0, 0);
        for k in 0..400 {
            let row: Vec<Chunk<HOT_PLANES>> = (0..10)
                .map(|c| {
                    core::array::from_fn(|plane| {
                        core::array::from_fn(|i| {
                            [3.0, 40.0, 40.0, 0.0][plane.min(3)]
                                * number(((k * 10 + c) * 8 + i as u64) * 8 + plane as u64)
                        })
                    })
                })
                .collect();
            // With the slack of the search a node has to be well inside or outside for this to be certain;
            // all of them are.
            let inside = |c: usize| -> [bool; CHUNK] {
                core::array::from_fn(|i| {
                    let x = [first[0] + (c * CHUNK + i) as f64 + row[c][0][i], first[1] + row[c][1][i], row[c][2][i]];
                    let r: [f64; 3] = core::array::from_fn(|k| x[k] - body.position[k] / h);
                    r.iter().map(|x| x * x).sum::<f64>() <= half * half
                })
            };
            let range = spread(&row, InstructionSet::Scalar);
            // A graded network whose columns are as far from each other.
            let mut columns = [[[0.0; CHUNK]; COLUMN_PLANES]; 10];
            for (i, place) in columns.iter_mut().flat_map(|planes| &mut planes[PLACE]).enumerate() {
                *place = first[0] + i as f64;
            }
            for columns in [&[], &columns[..]] {
                let [start, end] = search.chunks(first[0], columns, range, row.len());
                for c in (0..10).filter(|c| !(start..end).contains(c)) {
                    left_out += 1;
                    assert_eq!(inside(c), [false; CHUNK]);
                }
            }
            for from in 0..=10 {
                let expected = (from..10).find(|&c| inside(c) != [false; CHUNK]);
                if expected.is_some() {
                    hits += 1
                } else {
                    misses += 1
                }
                for set in InstructionSet::ALL.into_iter().filter(|set| set.available()) {
                    let (mut offsets, chunks) = (Offsets { r: [[0.0; CHUNK]; 3], beyond: [0.0; CHUNK] }, [from, 10]);
                    let (columns, offsets) = (&[][..], &mut offsets);
                    let found =
                        lanes::dispatch(set, Near { search: &search, columns, row: &row, chunks, first, offsets });
                    assert_eq!(found, expected, "{set:?}");
                    let Some(c) = found else { continue };
                    assert_eq!(offsets.beyond.map(|x| x <= 0.0), inside(c));
                    let near = (0..CHUNK).filter(|&i| offsets.beyond[i] <= 0.0);
                    for (i, k) in near.flat_map(|i| [(i, 0), (i, 1), (i, 2)]) {
                        let rest = [first[0] + (c * CHUNK + i) as f64, first[1], first[2]];
                        assert_eq!(offsets.r[k][i], (rest[k] + row[c][k][i]) * h - body.position[k], "{set:?}");
                    }
                    assert_eq!(spread(&row, set), range);
                }
            }
        }
        assert!(hits > 200 && misses > 200 && left_out > 400, "{hits} {misses} {left_out}");
    }
}
