//! Ghost nodes: images beyond mirror planes, and of the first column of a ring after its last.
//!
//! Reference: docs/model.md, "Symmetry planes".

use crate::ground::planes::{self, Chunk, HOT_PLANES, SPEED_X, SPEED_Z};
use crate::sheet::symmetry::Line;

/// Ghost column of one row, at rest: only displacements, the first three planes, are read.
pub(crate) fn place_ghost_column<const P: usize>(row: &mut [Chunk<P>], line: Line) {
    let place = line.modelled();
    let (node, mirrored) = line.node(place);
    for (plane, sign) in [(0, if mirrored { -1.0 } else { 1.0 }), (1, 1.0), (2, 1.0)] {
        let value = planes::get(row, plane, node).unwrap_or(0.0);
        planes::set(row, plane, place, sign * value);
        planes::set(row, SPEED_X + plane, place, 0.0);
    }
}

/// Ghost row of a block, its displacements and velocities, the first six planes.
pub(crate) fn place_ghost_row<const P: usize>(block: &mut [Chunk<P>], chunks: usize, line: Line) {
    let place = line.modelled();
    let (node, _) = line.node(place);
    let Some((rows, ghosts)) = block.split_at_mut_checked(place * chunks) else { return };
    for (from, to) in planes::row(rows, chunks, node).iter().zip(planes::row_mut(ghosts, chunks, 0)) {
        for plane in [0, 2, 3, 5] {
            to[plane] = from[plane];
        }
        for plane in [1, 4] {
            to[plane] = from[plane].map(|y| -y);
        }
    }
}

/// Velocities of the ghost column of so many rows.
pub(crate) fn place_ghost_speeds(hot: &mut [Chunk<HOT_PLANES>], chunks: usize, line: Line) {
    let (node, mirrored) = line.node(line.modelled());
    for row in hot.chunks_exact_mut(chunks.max(1)) {
        for (plane, sign) in [(SPEED_X, if mirrored { -1.0 } else { 1.0 }), (SPEED_X + 1, 1.0), (SPEED_Z, 1.0)] {
            let speed = planes::get(row, plane, node).unwrap_or(0.0);
            planes::set(row, plane, line.modelled(), sign * speed);
        }
    }
}
