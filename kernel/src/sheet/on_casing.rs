//! Case under a ring within the sweep: its impulse on each node, added to the change of velocity by the yarns.
//!
//! Method: the law of `casing.rs` at the places at the start of the pass. The impulses of a row are summed lane by lane.
//! Limits: those of `casing.rs`.
//! Reference: docs/model.md, "Curved sheets and rings".

use crate::ground::lanes::{Lane, at};
use crate::ground::planes::{CHUNK, Chunk, SPEED_X, SPEED_Z};
use crate::sheet::casing::Cylinder;
use crate::sheet::columns::{At, COLUMN_PLANES, PLACE, PLACE_Z};
use crate::sheet::neighbours::Around;
use crate::sheet::segments::Effect;

/// Case under a row of a ring.
pub struct OnCasing<'a> {
    /// The case.
    pub case: &'a Cylinder,
    /// Rest places of the columns.
    pub columns: &'a [Chunk<COLUMN_PLANES>],
    /// Rest place of the row along y, spacings.
    pub place_y: f64,
    /// Sums by lane: push of the case along x and z, and the energy that it dissipates.
    pub pushed: &'a mut [[f64; CHUNK]; 3],
    /// Push on each node; may be longer than the row.
    pub pushes: &'a mut [[f64; CHUNK]],
}

impl Effect for OnCasing<'_> {
    #[inline(always)]
    fn constrain<L: Lane>(&mut self, change: [L; 3], around: &Around<'_>, At { chunk, group: g }: At) -> [L; 3] {
        let Some(columns) = self.columns.get(chunk) else { return change };
        let x = at::<L, COLUMN_PLANES>(columns, PLACE, g).add(at(around.here, 0, g));
        let z = at::<L, COLUMN_PLANES>(columns, PLACE_Z, g).add(at(around.here, 2, g));
        let place = [x, L::splat(self.place_y).add(at(around.here, 1, g)), z];
        let before = [at(around.here, SPEED_X, g), at(around.here, SPEED_Z, g)];
        let [to_x, to_z, taken] = &mut *self.pushed;
        let sums = [&mut L::groups_mut(to_x)[g], &mut L::groups_mut(to_z)[g], &mut L::groups_mut(taken)[g]];
        let (push, along) = self.case.push(place, before, [change[0], change[2]], sums);
        if let Some(pushes) = self.pushes.get_mut(chunk) {
            push.store(&mut L::groups_mut(pushes)[g]);
        }
        [change[0].add(along[0]), change[1], change[2].add(along[1])]
    }
}
