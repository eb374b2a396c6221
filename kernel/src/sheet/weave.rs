//! The grid: where nodes rest, which are fixed, how segments are numbered. No index arrays.
//!
//! Here nodes and segments are those of the fabric, but for the fixed nodes, which are those of the network
//! (`grading.rs`): without grading it is the same.
//!
//! Node (i, j) of a flat sheet rests at ((i - (nx-1)/2) h_x, (j - (ny-1)/2) h_y, 0), of a curved one as
//! `ring.rs` says, and has the number j nx + i. Segments: first the horizontal ones (i, j)-(i+1, j), of a
//! ring also that from the last node to the first, row by row, then the vertical ones (i, j)-(i, j+1), row by
//! row.

use crate::ground::math;
use crate::ground::planes::Axis;
use crate::scene::features::Feature;
use crate::scene::parts::{AttachmentKind, Scene};
use crate::sheet::places::Places;

/// Number of attachments that can hold a sheet: four sides or four corners.
pub const ATTACHMENTS: usize = 4;

/// Up to two runs of fixed nodes in a row, as [first, end) column pairs; an empty run has first = end.
pub type FixedRuns = [[u32; 2]; 2];

/// Number of the horizontal segment that starts at node (i, j).
pub fn horizontal_number(scene: &Scene, i: usize, j: usize) -> u64 {
    j as u64 * scene.segments_of_row() + i as u64
}

/// Number of the vertical segment that starts at node (i, j).
pub fn vertical_number(scene: &Scene, i: usize, j: usize) -> u64 {
    horizontals(scene) + j as u64 * scene.sheet.nodes_x as u64 + i as u64
}

/// Direction of a segment.
pub fn axis_of_segment(scene: &Scene, number: u64) -> Axis {
    if number < horizontals(scene) { Axis::Horizontal } else { Axis::Vertical }
}

/// Horizontal segments of a ply.
fn horizontals(scene: &Scene) -> u64 {
    scene.segments_of_row() * scene.sheet.nodes_y as u64
}

/// Number of the woven yarn that a segment belongs to: rows first, then columns.
pub fn yarn_of_segment(scene: &Scene, number: u64) -> u64 {
    let horizontals = horizontals(scene);
    // At least 1, so that no division by zero has to be compiled in.
    if number < horizontals {
        number / scene.segments_of_row().max(1)
    } else {
        scene.sheet.nodes_y as u64 + (number - horizontals) % (scene.sheet.nodes_x as u64).max(1)
    }
}

/// The fixed nodes of row j, left run first.
pub fn fixed_runs(scene: &Scene, j: usize) -> FixedRuns {
    runs_among(scene, &Places::both(scene), j)
}

/// Fixed nodes of row j among nodes at these places, left run first.
#[inline(never)]
pub(crate) fn runs_among(scene: &Scene, places: &[Places; 2], j: usize) -> FixedRuns {
    let [nx, ny] = places.each_ref().map(Places::nodes);
    let last_row = ny as usize - 1;
    let sides = [[0, 1], [nx - 1, nx]];
    match scene.attachment.kind {
        AttachmentKind::Free => [[0, 0], [0, 0]],
        AttachmentKind::TwoSides => sides,
        AttachmentKind::FourSides if j == 0 || j == last_row => [[0, nx], [0, 0]],
        // A ring has no edge along its rows.
        AttachmentKind::FourSides if Feature::Closed.is_in(scene) => [[0, 0], [0, 0]],
        AttachmentKind::FourSides => sides,
        AttachmentKind::FourCorners => corner_runs(scene, places, j),
    }
}

/// Whether column i lies in one of a row's fixed runs.
pub(crate) fn in_runs(run: &[u32; 4], i: usize) -> bool {
    let i = i as u32;
    (run[0] <= i && i < run[1]) || (run[2] <= i && i < run[3])
}

/// Whether any of the columns [first, end) lies in one of a row's fixed runs.
pub(crate) fn meets_runs(run: &[u32; 4], [first, end]: [usize; 2]) -> bool {
    let (first, end) = (first as u32, end as u32);
    (run[0] < end && first < run[1]) || (run[2] < end && first < run[3])
}

/// Centre (a - c, b - c) of the corner disc at +x, +y, m. The others are its images about the sheet's middle.
pub(crate) fn disc_centre(scene: &Scene) -> [f64; 2] {
    scene.half_size().map(|half| half - scene.attachment.disc_inset)
}

/// Coordinate of a node along its line, measured from the corner discs' centre on the node's side of the
/// middle, m.
fn from_disc_centre(index: usize, places: &Places, spacing: f64, centre: f64) -> f64 {
    let x = places.offset(index) * spacing;
    math::abs(x) - centre
}

/// Square of the distance from the centre of a corner disc to the node nearest to it, m^2; the same for all
/// four discs, because rest offsets are exactly antisymmetric. A disc holds a node if this is at most the
/// square of its radius.
pub(crate) fn disc_to_nearest_node2(scene: &Scene) -> f64 {
    let centre = disc_centre(scene);
    let nearest = |axis: Axis, centre: f64| {
        let (places, h) = (Places::of(scene, axis), scene.spacing(axis));
        let beyond = places.first(|k| places.offset(k as usize) * h >= centre) as usize;
        let sides = beyond.saturating_sub(1)..(beyond + 1).min(places.nodes() as usize);
        let distances = sides.map(|k| from_disc_centre(k, &places, h, centre));
        distances.fold(f64::MAX, |nearest, d| math::min(d * d, nearest))
    };
    nearest(Axis::Horizontal, centre[0]) + nearest(Axis::Vertical, centre[1])
}

/// Nodes of row j within the discs about (+-(a - c), +-(b - c)). Discs do not overlap, so a row meets at most
/// two.
fn corner_runs(scene: &Scene, [columns, rows]: &[Places; 2], j: usize) -> FixedRuns {
    let [h_x, h_y] = scene.spacings();
    let centre = disc_centre(scene);
    let dy = from_disc_centre(j, rows, h_y, centre[1]);
    let radius2 = scene.attachment.disc_radius * scene.attachment.disc_radius;
    let inside = |i: u32| {
        let dx = from_disc_centre(i as usize, columns, h_x, centre[0]);
        dx * dx + dy * dy <= radius2
    };
    let mut runs = [[0, 0], [0, 0]];
    // Nodes of the right-hand half, the middle one with them.
    let is_right = |i: u32| 2 * columns.crossing(i) + 1 >= columns.crossings;
    // A spacing more to either side than the disc: no rounding hides a node.
    let [near, far] = [-1.0, 1.0].map(|side| (centre[0] + side * scene.attachment.disc_radius) / h_x + side);
    for i in columns.within(-far, -near).chain(columns.within(near, far)) {
        let i = i as u32;
        if inside(i) {
            let run = &mut runs[usize::from(is_right(i))];
            if run[0] == run[1] {
                run[0] = i;
            }
            run[1] = i + 1;
        }
    }
    runs
}

/// Which attachment a fixed run belongs to. Sides: 0 left (-x), 1 right (+x), 2 bottom (-y), 3 top (+y),
/// corner nodes counting to bottom and top. Corners: 0 (-x, -y), 1 (+x, -y), 2 (-x, +y), 3 (+x, +y). `rows`:
/// of nodes; `upper`: the first beyond the middle.
pub fn attachment_of(kind: AttachmentKind, rows: u32, upper: usize, j: usize, run: usize) -> usize {
    match kind {
        AttachmentKind::FourSides if j == 0 => 2,
        AttachmentKind::FourSides if j + 1 == rows as usize => 3,
        AttachmentKind::FourCorners if j >= upper => 2 + run,
        _ => run,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_dense_and_unique() {
        for closed in [false, true] {
            let (scene, across) = (of_nodes(closed), 3 + usize::from(closed));
            let mut seen = std::vec![false; 3 * across + 8];
            for j in 0..3 {
                (0..across).for_each(|i| seen[horizontal_number(&scene, i, j) as usize] = true);
            }
            for j in 0..2 {
                (0..4).for_each(|i| seen[vertical_number(&scene, i, j) as usize] = true);
            }
            assert!(seen.iter().all(|&s| s) && seen.len() as u64 == scene.segments());
        }
    }

    /// 4 x 3 nodes.
    fn of_nodes(closed: bool) -> Scene {
        let mut scene = crate::tests::sheet(4, 3);
        scene.sheet.closed = closed;
        scene
    }

    #[test]
    fn segments_of_a_row_or_column_are_one_yarn() {
        for (scene, across) in [(of_nodes(false), 3), (of_nodes(true), 4)] {
            for j in 0..3 {
                assert!((0..across).all(|i| yarn_of_segment(&scene, horizontal_number(&scene, i, j)) == j as u64));
            }
            for i in 0..4 {
                assert!((0..2).all(|j| yarn_of_segment(&scene, vertical_number(&scene, i, j)) == 3 + i as u64));
            }
        }
    }

    /// A radius short of the nearest node holds none, one beyond it holds one in every disc: centres on a
    /// node, on a line of nodes, in the middle of a mesh, beside the edge and anywhere.
    #[test]
    fn a_disc_holds_a_node_if_it_reaches_the_nearest() {
        let mut scene = Scene::sheet_3in_sphere();
        scene.attachment.kind = AttachmentKind::FourCorners;
        let h = scene.sheet.spacing;
        for (nx, ny) in [(21, 21), (20, 21), (24, 31)] {
            (scene.sheet.nodes_x, scene.sheet.nodes_y) = (nx, ny);
            for spacings in [0.0, 0.2, 0.5, 0.7, 1.0, 2.5, 3.0, 4.83, 6.999_999_999_999] {
                scene.attachment.disc_inset = spacings * h;
                let nearest = crate::ground::math::sqrt(disc_to_nearest_node2(&scene));
                let off = spacings - crate::ground::math::round(spacings);
                assert!(
                    (nearest - crate::ground::math::sqrt(2.0) * off.abs() * h).abs() < 1e-9 * h,
                    "{spacings} {nearest}"
                );
                for (radius, holds) in [(nearest - 1e-6 * h, false), (nearest + 1e-6 * h, true)] {
                    if radius < 0.0 {
                        continue;
                    }
                    scene.attachment.disc_radius = radius;
                    let mut held = [0; ATTACHMENTS];
                    for j in 0..ny as usize {
                        for (run, [first, end]) in fixed_runs(&scene, j).into_iter().enumerate() {
                            held[attachment_of(AttachmentKind::FourCorners, ny, ny.div_ceil(2) as usize, j, run)] +=
                                end - first;
                        }
                    }
                    assert_eq!(held.map(|nodes| nodes > 0), [holds; ATTACHMENTS], "{nx} {ny} {spacings} {radius}");
                    assert_eq!(holds, disc_to_nearest_node2(&scene) <= radius * radius);
                }
            }
        }
    }
}
