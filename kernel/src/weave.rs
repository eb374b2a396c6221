//! The grid: where nodes rest, which are fixed, how segments are numbered. No index arrays.
//!
//! Node (i, j) rests at ((i - (nx-1)/2) h, (j - (ny-1)/2) h, 0) and has the number j nx + i. Segments: first the horizontal
//! ones (i, j)-(i+1, j), row by row, then the vertical ones (i, j)-(i, j+1), row by row.

use crate::scene::{AttachmentKind, Scene};

/// Number of attachments that can hold a sheet: four sides or four corners.
pub const ATTACHMENTS: usize = 4;

/// Up to two runs of fixed nodes in a row, as [first, end) column pairs; an empty run has first = end.
pub type FixedRuns = [[u32; 2]; 2];

/// Offset of a node from the middle of its line, in node spacings; exactly antisymmetric.
pub fn rest_offset(index: usize, nodes: u32) -> f64 {
    index as f64 - 0.5 * (nodes as f64 - 1.0)
}

/// Number of the horizontal segment that starts at node (i, j).
pub fn horizontal_number(nodes_x: u32, i: usize, j: usize) -> u64 {
    j as u64 * (nodes_x as u64 - 1) + i as u64
}

/// Number of the vertical segment that starts at node (i, j).
pub fn vertical_number(nodes_x: u32, nodes_y: u32, i: usize, j: usize) -> u64 {
    (nodes_x as u64 - 1) * nodes_y as u64 + j as u64 * nodes_x as u64 + i as u64
}

/// Number of the woven yarn that a segment belongs to: rows first, then columns.
pub fn yarn_of_segment(nodes_x: u32, nodes_y: u32, number: u64) -> u64 {
    // At least 1, so that no division by zero has to be compiled in.
    let across = (nodes_x as u64 - 1).max(1);
    let horizontals = across * nodes_y as u64;
    if number < horizontals {
        number / across
    } else {
        nodes_y as u64 + (number - horizontals) % (nodes_x as u64).max(1)
    }
}

/// The fixed nodes of row j, left run first.
pub fn fixed_runs(scene: &Scene, j: usize) -> FixedRuns {
    let nx = scene.sheet.nodes_x;
    let last_row = scene.sheet.nodes_y as usize - 1;
    let sides = [[0, 1], [nx - 1, nx]];
    match scene.attachment.kind {
        AttachmentKind::Free => [[0, 0], [0, 0]],
        AttachmentKind::TwoSides => sides,
        AttachmentKind::FourSides if j == 0 || j == last_row => [[0, nx], [0, 0]],
        AttachmentKind::FourSides => sides,
        AttachmentKind::FourCorners => corner_runs(scene, j),
    }
}

/// Nodes of row j within the discs about (+-(a - c), +-(b - c)). Discs do not overlap, so a row meets at most two.
fn corner_runs(scene: &Scene, j: usize) -> FixedRuns {
    let (nx, h) = (scene.sheet.nodes_x, scene.sheet.spacing);
    let half = scene.half_size();
    let centre = [half[0] - scene.attachment.disc_inset, half[1] - scene.attachment.disc_inset];
    let y = rest_offset(j, scene.sheet.nodes_y) * h;
    let dy = (if y < 0.0 { -y } else { y }) - centre[1];
    let radius2 = scene.attachment.disc_radius * scene.attachment.disc_radius;
    let inside = |i: u32| {
        let x = rest_offset(i as usize, nx) * h;
        let dx = (if x < 0.0 { -x } else { x }) - centre[0];
        dx * dx + dy * dy <= radius2
    };
    let mut runs = [[0, 0], [0, 0]];
    let middle = nx / 2;
    for i in 0..nx {
        if inside(i) {
            let run = &mut runs[usize::from(i >= middle)];
            if run[0] == run[1] {
                run[0] = i;
            }
            run[1] = i + 1;
        }
    }
    runs
}

/// Which attachment a fixed run belongs to. Sides: 0 left (-x), 1 right (+x), 2 bottom (-y), 3 top (+y), corner nodes
/// counting to bottom and top. Corners: 0 (-x, -y), 1 (+x, -y), 2 (-x, +y), 3 (+x, +y).
pub fn attachment_of(kind: AttachmentKind, nodes_y: u32, j: usize, run: usize) -> usize {
    let last = nodes_y as usize - 1;
    match kind {
        AttachmentKind::FourSides if j == 0 => 2,
        AttachmentKind::FourSides if j == last => 3,
        AttachmentKind::FourCorners if 2 * j > last => 2 + run,
        _ => run,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_dense_and_unique() {
        let (nx, ny) = (4, 3);
        let mut seen = [false; 17];
        for j in 0..3 {
            for i in 0..3 {
                seen[horizontal_number(nx, i, j) as usize] = true;
            }
        }
        for j in 0..2 {
            for i in 0..4 {
                seen[vertical_number(nx, ny, i, j) as usize] = true;
            }
        }
        assert!(seen.iter().all(|&s| s));
    }

    #[test]
    fn segments_of_a_row_or_column_are_one_yarn() {
        let (nx, ny) = (4, 3);
        for j in 0..3 {
            assert!((0..3).all(|i| yarn_of_segment(nx, ny, horizontal_number(nx, i, j)) == j as u64));
        }
        for i in 0..4 {
            assert!((0..2).all(|j| yarn_of_segment(nx, ny, vertical_number(nx, ny, i, j)) == 3 + i as u64));
        }
    }

    #[test]
    fn corner_discs_are_mirror_symmetric() {
        let mut scene = Scene::sheet_3in_sphere();
        scene.attachment.kind = AttachmentKind::FourCorners;
        let ny = 105;
        let mut fixed = 0;
        for j in 0..ny {
            let runs = fixed_runs(&scene, j);
            assert_eq!(runs, fixed_runs(&scene, ny - 1 - j));
            assert_eq!(runs[0][1] - runs[0][0], runs[1][1] - runs[1][0]);
            assert_eq!(runs[0][0] + runs[1][1], if runs[0][0] == runs[0][1] { 0 } else { 105 });
            fixed += runs[0][1] - runs[0][0] + runs[1][1] - runs[1][0];
        }
        // Four discs of radius 7.875 spacings: about 4 pi r^2 nodes.
        assert!((760..800).contains(&fixed), "{fixed}");
    }

    #[test]
    fn four_sides_fix_the_edge() {
        let scene = Scene::sheet_3in_sphere();
        let count: u32 = (0..105).map(|j| fixed_runs(&scene, j).iter().map(|run| run[1] - run[0]).sum::<u32>()).sum();
        assert_eq!(count, 4 * 104);
    }
}
