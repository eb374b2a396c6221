//! Lane groups of a row's planes and of its neighbours' to the right and above.

use crate::ground::lanes::Lane;
use crate::ground::planes::{CHUNK, Chunk, HOT_PLANES};
use crate::sheet::ring::{HOOP_PLANES, NORMAL_X, NORMAL_Z, own_axes};

/// What stands above the top row and to the right of the last chunk: nothing that moves, held by segments of no stiffness.
pub(crate) const NOTHING: Chunk<HOT_PLANES> = [[0.0; CHUNK]; HOT_PLANES];

/// A lane group of a plane.
#[inline(always)]
pub(crate) fn at<L: Lane, const P: usize>(chunk: &Chunk<P>, plane: usize, g: usize) -> L {
    L::load(&L::groups(&chunk[plane])[g])
}

/// Three planes from this one on, displacements or velocities, in the axes of their columns; of a flat sheet as they are.
#[inline(always)]
pub(crate) fn own<L: Lane, const CURVED: bool>(
    chunk: &Chunk<HOT_PLANES>,
    first: usize,
    hoop: &Chunk<HOOP_PLANES>,
    g: usize,
) -> [L; 3] {
    let sheets = [at(chunk, first, g), at(chunk, first + 1, g), at(chunk, first + 2, g)];
    if CURVED { own_axes(sheets, [at(hoop, NORMAL_X, g), at(hoop, NORMAL_Z, g)]) } else { sheets }
}

/// The right-hand neighbours of group g: from the same plane, or with the first of the chunk behind.
#[inline(always)]
pub(crate) fn right_of<L: Lane>(here: L, plane: &[f64; CHUNK], next: &[f64; CHUNK], g: usize) -> L {
    if g + 1 < CHUNK / L::WIDTH { L::load_right(plane, g) } else { here.right_of(L::load(&L::groups(next)[0])) }
}

/// The first three planes: those of the right-hand neighbours less those of group g.
#[inline(always)]
pub(crate) fn to_the_right<L: Lane, const P: usize>(chunk: &Chunk<P>, next: &Chunk<P>, g: usize) -> [L; 3] {
    let here = [at(chunk, 0, g), at(chunk, 1, g), at(chunk, 2, g)];
    right_less(here, [&chunk[0], &chunk[1], &chunk[2]], next, g)
}

/// The same of these planes, where those of group g are at hand.
#[inline(always)]
pub(crate) fn right_less<L: Lane, const P: usize>(
    here: [L; 3],
    [x, y, z]: [&[f64; CHUNK]; 3],
    next: &Chunk<P>,
    g: usize,
) -> [L; 3] {
    [
        right_of(here[0], x, &next[0], g).sub(here[0]),
        right_of(here[1], y, &next[1], g).sub(here[1]),
        right_of(here[2], z, &next[2], g).sub(here[2]),
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
