//! Attachments that slip: a held node slides within the sheet's plane when the yarns pull it harder than its
//! clamp holds.
//!
//! Method: rigid and perfectly plastic (M25). In a step the yarns would give a held node that has the
//! velocity v the velocity v + p. The clamp takes from its part w within the plane at most the impulse H dt:
//! w (1 - H dt/(m |w|)) is left, nothing of a w that is smaller; and all of the part across the plane. It
//! dissipates its impulse times the mean of the velocities before and after, which is exact in the staggered
//! scheme. A node that has slid by the length of yarn in the clamp, or whose attachment has failed, is free.
//! Limits: one force for rest and sliding; a node slides as a whole, not each of its yarns along itself.
//! Velocity Verlet.
//! Reference: docs/model.md, "Attachments that slip"; J. C. Simo, T. J. R. Hughes, Computational Inelasticity
//! (1998), ch. 1 (return mapping).

use crate::ground::math;
use crate::ground::planes::{CHUNK, Chunk};
use crate::scene::features::Feature;
use crate::scene::parts::{AttachmentKind, Scene};
use crate::sheet::columns::{COLUMN_PLANES, NORMAL_X, NORMAL_Z};
use crate::sheet::ring::own_axes;

/// Distance slid of a node whose attachment has let go, spacings.
pub(crate) const LET_GO: f64 = f64::MAX;

/// Whether the node of a lane of a chunk is free by what `slid` says; without slipping clamps, which have
/// none, it is not.
#[inline(always)]
pub(crate) fn has_let_go(slid: &[[f64; CHUNK]], chunk: usize, lane: usize, grip: f64) -> bool {
    Feature::Clamps.is_built() && slid.get(chunk).is_some_and(|slid| slid.get(lane).is_some_and(|&slid| slid >= grip))
}

/// Clamps of a row of nodes.
pub(crate) struct ClampedRow<'r> {
    /// Largest impulse of the clamp on each node in a step, spacings/step times its mass; constant.
    pub holds: &'r [[f64; CHUNK]],
    /// Distance that each node has slid, spacings.
    pub slid: &'r mut [[f64; CHUNK]],
    /// Distance at which a node is free, spacings.
    pub grip: f64,
    /// Normals of the columns; empty where all are along z.
    pub columns: &'r [Chunk<COLUMN_PLANES>],
}

/// Effect of a clamp on a node in a step, in units of its mass, spacings and steps.
pub(crate) struct Slide {
    /// Velocity that is left, in the sheet's frame.
    pub velocity: [f64; 3],
    /// Impulse of the node on its support.
    pub impulse: [f64; 3],
    /// Energy dissipated.
    pub work: f64,
}

impl ClampedRow<'_> {
    /// Whether the node of column i is held.
    pub fn holds_node(&self, i: usize) -> bool {
        !has_let_go(self.slid, i / CHUNK, i % CHUNK, self.grip)
    }

    /// (M25) Slides the held node of column i, which had the velocity `before` and would have the velocity
    /// `pulled`.
    pub fn slide(&mut self, i: usize, before: [f64; 3], pulled: [f64; 3]) -> Slide {
        let (chunk, lane) = (i / CHUNK, i % CHUNK);
        let hold = self.holds.get(chunk).map_or(0.0, |holds| holds[lane]);
        let normal =
            self.columns.get(chunk).map_or([0.0, 1.0], |column| [column[NORMAL_X][lane], column[NORMAL_Z][lane]]);
        let [along, y, _] = own_axes(pulled, normal);
        let size = math::length([along, y, 0.0]);
        let part = if size > hold { 1.0 - hold / size } else { 0.0 };
        // Back from the axes of the column; no zero is negative, or a row at rest would not keep its bits.
        let velocity = [normal[1] * (along * part), y * part, -(normal[0] * (along * part))].map(|v| v + 0.0);
        let impulse = [0, 1, 2].map(|k| pulled[k] - velocity[k]);
        let mean = [0, 1, 2].map(|k| 0.5 * (before[k] + velocity[k]));
        if let Some(slid) = self.slid.get_mut(chunk) {
            slid[lane] += size * part;
        }
        Slide { velocity, impulse, work: impulse[0] * mean[0] + impulse[1] * mean[1] + impulse[2] * mean[2] }
    }
}

/// Yarns that end at the held node of column i of row j, in one ply and with one yarn a bar: at a side the
/// one that it holds, at the corner of four held sides two; under a disc each of the two yarns shares its end
/// among the nodes there. `run`: fixed nodes of the row on its side; `of_column`: how many nodes of the
/// column the disc holds.
pub(crate) fn yarns_ending(
    scene: &Scene,
    [i, j]: [usize; 2],
    [nx, ny]: [usize; 2],
    run: usize,
    of_column: usize,
) -> f64 {
    let at_end = |k: usize, nodes: usize| k == 0 || k + 1 == nodes;
    match scene.attachment.kind {
        AttachmentKind::FourCorners => 1.0 / run.max(1) as f64 + 1.0 / of_column.max(1) as f64,
        AttachmentKind::FourSides if !scene.is_closed() && at_end(i, nx) && at_end(j, ny) => 2.0,
        _ => 1.0,
    }
}
