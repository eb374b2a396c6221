//! Lane groups of a row's planes and of its neighbours' to the right and above.

use crate::ground::lanes::{Lane, at};
use crate::ground::planes::{Axis, CHUNK, Chunk, HOT_PLANES, vertical_axes};
use crate::sheet::columns::{COLUMN_PLANES, NORMAL_X, NORMAL_Z};
use crate::sheet::ring::column_axes;

/// Chunk above the top row and to the right of the last chunk: nothing that moves, held by segments of no
/// stiffness.
pub(crate) const NOTHING: Chunk<HOT_PLANES> = [[0.0; CHUNK]; HOT_PLANES];

/// Three planes from this one on, displacements or velocities, in the axes of their columns; without `hoop`,
/// of a flat sheet, as they are.
#[inline(always)]
pub(crate) fn own<L: Lane>(
    chunk: &Chunk<HOT_PLANES>,
    first: usize,
    hoop: Option<&Chunk<COLUMN_PLANES>>,
    g: usize,
) -> [L; 3] {
    let sheets = [at(chunk, first, g), at(chunk, first + 1, g), at(chunk, first + 2, g)];
    match hoop {
        Some(hoop) => column_axes(sheets, [at(hoop, NORMAL_X, g), at(hoop, NORMAL_Z, g)]),
        None => sheets,
    }
}

/// The right-hand neighbours of group g: from the same plane, or with the first of the next chunk.
#[inline(always)]
pub(crate) fn right_of<L: Lane>(here: L, plane: &[f64; CHUNK], next: &[f64; CHUNK], g: usize) -> L {
    if g + 1 < CHUNK / L::WIDTH { L::load_right(plane, g) } else { here.right_of(L::load(&L::groups(next)[0])) }
}

/// Chunk of nodes with those to the right and above, towards which its segments go.
#[derive(Clone, Copy)]
pub struct Around<'a> {
    /// The chunk.
    pub here: &'a Chunk<HOT_PLANES>,
    /// The next chunk of the row.
    pub right: &'a Chunk<HOT_PLANES>,
    /// The chunk of the row above.
    pub above: &'a Chunk<HOT_PLANES>,
}

impl<'a> Around<'a> {
    /// Chunk c of a row below the row `above`; None after the last.
    #[inline(always)]
    pub fn of(row: &'a [Chunk<HOT_PLANES>], above: &'a [Chunk<HOT_PLANES>], c: usize) -> Option<Around<'a>> {
        let (right, above) = (row.get(c + 1).unwrap_or(&NOTHING), above.get(c).unwrap_or(&NOTHING));
        Some(Around { here: row.get(c)?, right, above })
    }

    /// Relative displacement (planes from [`X`](crate::ground::planes::X) on) or velocity (from
    /// [`SPEED_X`](crate::ground::planes::SPEED_X) on) of the ends of the segments from group g, along x and
    /// along y, in the axes of the sheet.
    #[inline(always)]
    pub fn differences<L: Lane>(&self, first: usize, g: usize) -> [[L; 3]; 2] {
        let [[x, a], [y, b], [z, c]] =
            [self.difference(first, g), self.difference(first + 1, g), self.difference(first + 2, g)];
        [[x, y, z], [a, b, c]]
    }

    /// [`Around::differences`] of the segments along an axis, in their own axes.
    #[inline(always)]
    pub fn of_axis<L: Lane>(&self, axis: Axis, first: usize, g: usize) -> [L; 3] {
        let [along, up] = self.differences(first, g);
        match axis {
            Axis::Horizontal => along,
            Axis::Vertical => vertical_axes(up),
        }
    }

    /// Differences of one plane, to the right and upwards.
    #[inline(always)]
    fn difference<L: Lane>(&self, plane: usize, g: usize) -> [L; 2] {
        let here: L = at(self.here, plane, g);
        let right = right_of(here, &self.here[plane], &self.right[plane], g).sub(here);
        [right, at::<L, HOT_PLANES>(self.above, plane, g).sub(here)]
    }

    /// Stiffness of the segments from group g, along x and along y.
    #[inline(always)]
    pub fn stiffness<L: Lane>(&self, g: usize) -> [L; 2] {
        [at(self.here, 6, g), at(self.here, 7, g)]
    }
}
