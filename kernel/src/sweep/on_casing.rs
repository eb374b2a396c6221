//! Case under a ring within the sweep: its impulse on each node, added to the change of velocity by the
//! yarns.
//!
//! Method: the law of `casing.rs` at the places at the start of the step. The impulses of a row are summed
//! lane by lane.
//! Limits: those of `casing.rs`.
//! Reference: docs/model.md, "Curved sheets and rings".

use crate::ground::lanes::{Lane, at};
use crate::ground::planes::{CHUNK, Chunk, SPEED_X, SPEED_Z};
use crate::sheet::casing::Cylinder;
use crate::sheet::columns::{COLUMN_PLANES, PLACE, PLACE_Z};
use crate::sheet::neighbours::Around;

/// Case under a row of a ring.
pub struct OnCasing<'a> {
    /// The case.
    pub case: &'a Cylinder,
    /// Rest places of the columns.
    pub columns: &'a [Chunk<COLUMN_PLANES>],
    /// Rest place of the row along y, spacings.
    pub place_y: f64,
    /// Sums by lane: impulse of the case, components x and z, and energy dissipated by it.
    pub impulse_of_row: &'a mut [[f64; CHUNK]; 3],
    /// Impulse on each node; may be longer than the row.
    pub impulse: &'a mut [[f64; CHUNK]],
}

impl OnCasing<'_> {
    /// Case under chunk c; None after the last.
    #[inline(always)]
    pub fn on_chunk(&mut self, c: usize) -> Option<CasingChunk<'_>> {
        let OnCasing { case, columns, place_y, impulse_of_row, impulse } = self;
        let (columns, impulse) = (columns.get(c)?, impulse.get_mut(c)?);
        Some(CasingChunk { case, columns, place_y: *place_y, impulse_of_row, impulse })
    }
}

/// Case under a chunk of a ring.
pub struct CasingChunk<'c> {
    case: &'c Cylinder,
    columns: &'c Chunk<COLUMN_PLANES>,
    place_y: f64,
    impulse_of_row: &'c mut [[f64; CHUNK]; 3],
    impulse: &'c mut [f64; CHUNK],
}

impl CasingChunk<'_> {
    /// Change of velocity with the push of the case, of lane group g that the yarns would change by `change`.
    #[inline(always)]
    pub fn constrain<L: Lane>(&mut self, change: [L; 3], around: &Around<'_>, g: usize) -> [L; 3] {
        let x = at::<L, COLUMN_PLANES>(self.columns, PLACE, g).add(at(around.here, 0, g));
        let z = at::<L, COLUMN_PLANES>(self.columns, PLACE_Z, g).add(at(around.here, 2, g));
        let place = [x, L::splat(self.place_y).add(at(around.here, 1, g)), z];
        let before = [at(around.here, SPEED_X, g), at(around.here, SPEED_Z, g)];
        let [to_x, to_z, dissipated] = &mut *self.impulse_of_row;
        let sums = [&mut L::groups_mut(to_x)[g], &mut L::groups_mut(to_z)[g], &mut L::groups_mut(dissipated)[g]];
        let (push, along) = self.case.push(place, before, [change[0], change[2]], sums);
        push.store(&mut L::groups_mut(self.impulse)[g]);
        [change[0].add(along[0]), change[1], change[2].add(along[1])]
    }
}
