//! Attachments that slip: a held node slides within the sheet's plane when the yarns pull it harder than its
//! clamp holds.
//!
//! Method: rigid and perfectly plastic (M25). In a step the yarns would give a held node that has the
//! velocity v the velocity v + p. The clamp takes from its part w within the plane at most the impulse H dt:
//! w (1 - H dt/(m |w|)) is left, nothing of a w that is smaller; and all of the part across the plane. It
//! dissipates its impulse times the mean of the velocities before and after, which is exact in the staggered
//! scheme; where yarn turns a node around within the step, the impulse is at most that which dissipates
//! nothing. A node that has slid and is nearer to the body than a spacing is out of the jaws: it is free, and
//! the yarn in the clamp acts on it with H against its velocity, (M25) with w in space; but where the yarn
//! would turn it around and the body keeps it on its way, nothing acts. A node that has slid
//! by the length of yarn in the clamp, or whose attachment has failed, is free.
//! Limits: one force for rest and sliding; a node slides as a whole, not each of its yarns along itself. A
//! body slower than H dt/m feels less than H of a node out of the jaws, which the clamp stops in each step.
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

/// Way that the node of a lane of a chunk has slid, spacings: negative once it is out of the jaws. 0 without
/// slipping clamps, which have no `slid`.
#[inline(always)]
pub(crate) fn slid_by(slid: &[[f64; CHUNK]], chunk: usize, lane: usize) -> f64 {
    if !Feature::Clamps.is_built() {
        return 0.0;
    }
    slid.get(chunk).map_or(0.0, |slid| slid[lane % CHUNK])
}

/// True while the jaws hold a node that has slid so far, false once only the yarn in them acts on it.
#[inline(always)]
pub(crate) fn is_in_jaws(slid: f64, grip: f64) -> bool {
    (0.0..grip).contains(&slid)
}

/// Clamps of a row of nodes.
pub(crate) struct ClampedRow<'r> {
    /// Impulses of the clamp on each node, spacings/step times its mass: the largest in a step, constant, and
    /// of a node out of the jaws components of that in the last one; energy dissipated by the latter.
    pub holds: &'r mut [[[f64; CHUNK]; 5]],
    /// Way that each node has slid, spacings, as [`slid_by`] has it.
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
    /// Whether the clamp acts on the node of column i.
    pub fn holds_node(&self, i: usize) -> bool {
        slid_by(self.slid, i / CHUNK, i % CHUNK) < self.grip
    }

    /// (M25) Slides the node of column i, on which a clamp acts: it had the velocity `before` and would have
    /// `pulled`.
    pub fn slide(&mut self, i: usize, before: [f64; 3], pulled: [f64; 3]) -> Slide {
        let (chunk, lane) = (i / CHUNK, i % CHUNK);
        let hold = self.holds.get(chunk).map_or(0.0, |[hold, ..]| hold[lane]);
        let normal =
            self.columns.get(chunk).map_or([0.0, 1.0], |column| [column[NORMAL_X][lane], column[NORMAL_Z][lane]]);
        let slid = slid_by(self.slid, chunk, lane);
        let is_out = slid < 0.0;
        let [along, y, _] = own_axes(pulled, normal);
        let size = math::length(if is_out { pulled } else { [along, y, 0.0] });
        // Component of `before` along w, times |w|: a node in the jaws has none normal to the sheet.
        let turned = before[0] * pulled[0] + before[1] * pulled[1] + before[2] * pulled[2];
        let most = if turned < 0.0 { math::max(size + turned / size, 0.0) } else { size };
        let taken = math::min(hold, most);
        let part = if size > taken { 1.0 - taken / size } else { 0.0 };
        // Back from the axes of the column; no zero is negative, or a row at rest would not keep its bits.
        let in_plane = [normal[1] * (along * part), y * part, -(normal[0] * (along * part))];
        let velocity = if is_out { pulled.map(|v| v * part) } else { in_plane }.map(|v| v + 0.0);
        let impulse = [0, 1, 2].map(|k| pulled[k] - velocity[k]);
        let mean = [0, 1, 2].map(|k| 0.5 * (before[k] + velocity[k]));
        let way = math::abs(slid) + size * part;
        let work = impulse[0] * mean[0] + impulse[1] * mean[1] + impulse[2] * mean[2];
        if let Some([_, pulls @ .., last]) = self.holds.get_mut(chunk).filter(|_| is_out) {
            pulls.iter_mut().zip(impulse).for_each(|(pull, taken)| pull[lane] = -taken);
            last[lane] = work;
        }
        if let Some(slid) = self.slid.get_mut(chunk) {
            slid[lane] = if is_out && way < self.grip { -way } else { way };
        }
        Slide { velocity, impulse, work }
    }
}

/// Yarns that end at the held node of column i of row j, in one ply and with one yarn a bar: at a side the
/// one that it holds, at the corner of four held sides two; under a disc each of the two yarns shares its end
/// among the nodes there. `run`: fixed nodes of the row on its side; `of_column`: how many nodes of the
/// column the disc holds; `[column, row]`: widths of the node.
pub(crate) fn yarns_ending(
    scene: &Scene,
    [i, j]: [usize; 2],
    [nx, ny]: [usize; 2],
    run: usize,
    of_column: usize,
    [column, row]: [f64; 2],
) -> f64 {
    let at_end = |k: usize, nodes: usize| f64::from(u8::from(k == 0 || k + 1 == nodes));
    match scene.attachment.kind {
        AttachmentKind::FourCorners => row / run.max(1) as f64 + column / of_column.max(1) as f64,
        AttachmentKind::FourSides if !scene.is_closed() => row * at_end(i, nx) + column * at_end(j, ny),
        AttachmentKind::FourSides => column,
        _ => row,
    }
}
