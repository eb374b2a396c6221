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

use crate::body::pose::Vector;
use crate::ground::error::{Code, Error};
use crate::ground::math;
use crate::ground::planes::{self, Axis, CHUNK, Chunk, HOT_PLANES};
use crate::scene::features::Feature;
use crate::scene::measures::Cloth;
use crate::scene::parts::{Attachment, AttachmentKind, Scene};
use crate::sheet::columns::{COLUMN_PLANES, NORMAL_X, NORMAL_Z};
use crate::sheet::ring::column_axes;
use core::mem::take;

/// Planes of a chunk of clamps. Impulses in spacings/step times the mass of the node.
pub(crate) const CLAMP_PLANES: usize = 6;
/// Largest impulse of the clamp in a step, constant.
const HOLD: usize = 0;
/// First of three planes. Before the sweep of a row: velocity of the node, spacings/step. After it: impulse
/// of the clamp in this step on a node out of the jaws, 0 for others.
const PULL: usize = 1;
/// Energy dissipated by that impulse.
const WORK: usize = 4;
/// Distance slid, spacings: negative once the node is out of the jaws.
pub(crate) const SLID: usize = 5;

/// Distance slid of a node whose attachment has let go, spacings.
pub(crate) const LET_GO: f64 = f64::MAX;

/// Whether this build has clamps.
const IS_BUILT: bool = Feature::Clamps.is_built();

/// Constants of the clamps of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Clamps {
    /// Distance at which a held node has slid out of its clamp, spacings.
    pub grip: f64,
    /// Mean force over a window at which an attachment as a whole lets go, N; 0: never.
    pub strength: f64,
    /// Steps between two tests of the attachments; 0 without clamps.
    window: u64,
}

impl Clamps {
    /// Clamps of no scene: they hold.
    pub const NOTHING: Clamps = Clamps { grip: LET_GO, strength: 0.0, window: 0 };

    /// Clamps of a scene with force windows of so many steps.
    pub fn of(scene: &Scene, window: u64) -> Clamps {
        if !Feature::Clamps.is_in(scene) {
            return Clamps::NOTHING;
        }
        let slips = scene.attachment.hold != 0.0 && scene.attachment.grip != 0.0;
        let grip = if slips { scene.attachment.grip / scene.sheet.spacing } else { LET_GO };
        Clamps { grip, strength: scene.attachment.strength, window: window.max(1) }
    }

    /// Whether attachments are tested after one of the steps [first, end).
    pub fn are_tested(&self, first: u64, end: u64) -> bool {
        IS_BUILT && first.checked_next_multiple_of(self.window).is_some_and(|tested| tested < end)
    }

    /// True while the jaws hold a node that has slid so far, false once only the yarn in them acts on it.
    #[inline(always)]
    pub fn hold(&self, slid: f64) -> bool {
        (0.0..self.grip).contains(&slid)
    }

    /// Whether a clamp has let go of a node for good.
    pub fn have_let_go(&self, clamps: &[Chunk<CLAMP_PLANES>]) -> bool {
        IS_BUILT && clamps.iter().any(|chunk| chunk[SLID].iter().any(|&slid| slid >= self.grip))
    }

    /// Distance slid of a candidate that has slid within the jaws and leaves them: that of a node out of
    /// them, or free.
    pub fn leave(&self, slid: f64) -> f64 {
        if self.hold(slid) { -slid } else { slid }
    }
}

/// Chunk of clamps at a place; None without slipping clamps.
#[inline(always)]
pub(crate) fn at(clamps: &[Chunk<CLAMP_PLANES>], place: usize) -> Option<&Chunk<CLAMP_PLANES>> {
    if IS_BUILT { clamps.get(place) } else { None }
}

/// [`at`], to be changed.
#[inline(always)]
pub(crate) fn at_mut(clamps: &mut [Chunk<CLAMP_PLANES>], place: usize) -> Option<&mut Chunk<CLAMP_PLANES>> {
    if IS_BUILT { clamps.get_mut(place) } else { None }
}

/// Distance slid of the node of a lane of a chunk, spacings: negative once it is out of the jaws. 0 without
/// slipping clamps.
#[inline(always)]
pub(crate) fn slid_by(clamps: &[Chunk<CLAMP_PLANES>], place: usize, lane: usize) -> f64 {
    at(clamps, place).map_or(0.0, |chunk| chunk[SLID][lane % CHUNK])
}

/// Impulse and work of a clamp in this step on a node out of its jaws.
pub(crate) struct Pull<'c>(&'c mut Chunk<CLAMP_PLANES>, usize);

impl<'c> Pull<'c> {
    /// Pull on the node of a lane of a chunk; None unless the node is out of its jaws.
    #[inline(always)]
    pub fn on(clamps: &'c mut [Chunk<CLAMP_PLANES>], place: usize, lane: usize) -> Option<Pull<'c>> {
        at_mut(clamps, place).filter(|chunk| chunk[SLID][lane] < 0.0).map(|chunk| Pull(chunk, lane))
    }

    /// Impulse on the node, spacings/step times its mass.
    pub fn impulse(&self) -> Vector {
        let Pull(chunk, lane) = self;
        Vector::from([0, 1, 2].map(|k| chunk[PULL + k][*lane]))
    }

    /// Energy dissipated by it.
    pub fn work(&self) -> f64 {
        self.0[WORK][self.1]
    }

    /// Takes the energy out.
    pub fn take_work(&mut self) -> f64 {
        take(&mut self.0[WORK][self.1])
    }

    /// Takes the impulse back, too. Returns the energy.
    pub fn cancel(&mut self) -> f64 {
        (0..3).for_each(|k| self.0[PULL + k][self.1] = 0.0);
        self.take_work()
    }
}

/// Velocities of the fixed nodes of a row, which [`ClampedRow::slide`] needs after its sweep.
#[cold]
pub(crate) fn keep_velocities(clamps: &mut [Chunk<CLAMP_PLANES>], row: &[Chunk<HOT_PLANES>], run: &[u32; 4]) {
    for i in (run[0]..run[1]).chain(run[2]..run[3]).map(|i| i as usize) {
        if let (Some(chunk), Some(clamps)) = (row.get(i / CHUNK), clamps.get_mut(i / CHUNK)) {
            let v = planes::velocity(chunk, i % CHUNK);
            (0..3).for_each(|k| clamps[PULL + k][i % CHUNK] = v[k]);
        }
    }
}

/// Clamps of a row of nodes.
pub(crate) struct ClampedRow<'r> {
    /// Chunks of the row.
    pub row: &'r mut [Chunk<CLAMP_PLANES>],
    /// Constants of all clamps.
    pub clamps: &'r Clamps,
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
    /// Whether clamps of the row may slip.
    #[inline(always)]
    pub fn may_slip(&self) -> bool {
        at(self.row, 0).is_some()
    }

    /// Whether the clamp acts on the node of column i.
    pub fn holds_node(&self, i: usize) -> bool {
        slid_by(self.row, i / CHUNK, i % CHUNK) < self.clamps.grip
    }

    /// (M25) Slides the node of column i, on which a clamp acts and which would have the velocity `pulled`.
    pub fn slide(&mut self, i: usize, pulled: [f64; 3]) -> Option<Slide> {
        let (chunk, lane) = (i / CHUNK, i % CHUNK);
        let clamp = at_mut(self.row, chunk)?;
        let (hold, slid) = (clamp[HOLD][lane], clamp[SLID][lane]);
        let before = [0, 1, 2].map(|k| clamp[PULL + k][lane]);
        let normal =
            self.columns.get(chunk).map_or([0.0, 1.0], |column| [column[NORMAL_X][lane], column[NORMAL_Z][lane]]);
        let is_out = slid < 0.0;
        let [along, y, _] = column_axes(pulled, normal);
        let size = math::length(if is_out { pulled } else { [along, y, 0.0] });
        // Component of `before` along w, times |w|: a node in the jaws has none normal to the sheet.
        let before_along = before[0] * pulled[0] + before[1] * pulled[1] + before[2] * pulled[2];
        let most = if before_along < 0.0 { math::max(size + before_along / size, 0.0) } else { size };
        let taken = math::min(hold, most);
        let part = if size > taken { 1.0 - taken / size } else { 0.0 };
        // Back from the axes of the column; no zero is negative, or a row at rest would not keep its bits.
        let in_plane = [normal[1] * (along * part), y * part, -(normal[0] * (along * part))];
        let velocity = if is_out { pulled.map(|v| v * part) } else { in_plane }.map(|v| v + 0.0);
        let impulse = [0, 1, 2].map(|k| pulled[k] - velocity[k]);
        let mean = [0, 1, 2].map(|k| 0.5 * (before[k] + velocity[k]));
        let way = math::abs(slid) + size * part;
        let work = impulse[0] * mean[0] + impulse[1] * mean[1] + impulse[2] * mean[2];
        (0..3).for_each(|k| clamp[PULL + k][lane] = if is_out { -impulse[k] } else { 0.0 });
        clamp[WORK][lane] = if is_out { work } else { 0.0 };
        clamp[SLID][lane] = if is_out && way < self.clamps.grip { -way } else { way };
        Some(Slide { velocity, impulse, work })
    }
}

/// Sets the largest impulse of the clamp on the node of column i of a row in a step.
pub(crate) fn set_hold(clamps: &mut [Chunk<CLAMP_PLANES>], place: usize, lane: usize, hold: f64) {
    if let Some(chunk) = at_mut(clamps, place) {
        chunk[HOLD][lane % CHUNK] = hold;
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
        AttachmentKind::FourSides if !Feature::Closed.is_in(scene) => row * at_end(i, nx) + column * at_end(j, ny),
        AttachmentKind::FourSides => column,
        _ => row,
    }
}

impl Scene {
    /// Checks that clamps hold more than what the sheet pulls before anything has happened.
    pub(crate) fn check_clamps(&self) -> Result<(), Error> {
        let Attachment { hold, grip, strength, .. } = self.attachment;
        if !IS_BUILT {
            return Ok(());
        }
        if grip > 0.0 && hold == 0.0 {
            return Err(Error::new(Code::OutOfRange, "attachment.grip", grip, 0.0).from("attachment.hold"));
        }
        let refused = [("attachment.hold", hold), ("attachment.strength", strength)].into_iter();
        if self.attachment.kind == AttachmentKind::Free
            && let Some((field, _)) = refused.clone().find(|(_, force)| *force != 0.0)
        {
            return Err(Error::beside(field, "attachment.kind"));
        }
        let across = [self.sheet.nodes_y, self.sheet.nodes_x].map(|bars| f64::from(bars) * f64::from(self.sheet.plies));
        for (axis, bars) in [Axis::Horizontal, Axis::Vertical].into_iter().zip(across) {
            let tension = |cloth: Cloth| {
                let stretch = self.stretch_at_rest(axis, cloth);
                let strain = 0.5 * (stretch * stretch - 1.0);
                math::max(self.mean_modulus(axis, cloth) * self.area_of(axis, cloth) * strain * stretch, 0.0)
            };
            let front = tension(Cloth::Front);
            let back = if self.back.plies > 0 { tension(Cloth::Back) } else { 0.0 };
            let all = bars * (f64::from(self.front_plies()) * front + f64::from(self.back.plies) * back);
            for ((field, force), pull) in refused.clone().zip([math::max(front, back), all]) {
                if force != 0.0 && force < pull {
                    return Err(Error::new(Code::OutOfRange, field, force, pull).from("sheet.pre_strain"));
                }
            }
        }
        Ok(())
    }
}
