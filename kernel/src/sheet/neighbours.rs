//! Lane groups of a row's planes and of its neighbours' to the right and above.

use crate::ground::lanes::Lane;
use crate::ground::planes::{CHUNK, Chunk, HOT_PLANES};

/// What stands above the top row and to the right of the last chunk: nothing that moves, held by segments of no stiffness.
pub(crate) const NOTHING: Chunk<HOT_PLANES> = [[0.0; CHUNK]; HOT_PLANES];

/// A lane group of a plane.
#[inline(always)]
pub(crate) fn at<L: Lane, const P: usize>(chunk: &Chunk<P>, plane: usize, g: usize) -> L {
    L::load(&L::groups(&chunk[plane])[g])
}

/// The right-hand neighbours of group g: from the same plane, or with the first of the chunk behind.
#[inline(always)]
pub(crate) fn right_of<L: Lane>(here: L, plane: &[f64; CHUNK], next: &[f64; CHUNK], g: usize) -> L {
    if g + 1 < CHUNK / L::WIDTH { L::load_right(plane, g) } else { here.right_of(L::load(&L::groups(next)[0])) }
}

/// The first three planes: those of the right-hand neighbours less those of group g.
#[inline(always)]
pub(crate) fn to_the_right<L: Lane, const P: usize>(chunk: &Chunk<P>, next: &Chunk<P>, g: usize) -> [L; 3] {
    let here: [L; 3] = [at(chunk, 0, g), at(chunk, 1, g), at(chunk, 2, g)];
    [
        right_of(here[0], &chunk[0], &next[0], g).sub(here[0]),
        right_of(here[1], &chunk[1], &next[1], g).sub(here[1]),
        right_of(here[2], &chunk[2], &next[2], g).sub(here[2]),
    ]
}

/// The same for the neighbours above.
#[inline(always)]
pub(crate) fn upwards<L: Lane, const P: usize>(chunk: &Chunk<P>, above: &Chunk<P>, g: usize) -> [L; 3] {
    [
        at::<L, P>(above, 0, g).sub(at(chunk, 0, g)),
        at::<L, P>(above, 1, g).sub(at(chunk, 1, g)),
        at::<L, P>(above, 2, g).sub(at(chunk, 2, g)),
    ]
}
