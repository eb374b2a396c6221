//! Viscosity of taut yarn within the hot pass (`sweep.rs`): the stress of each segment, and the moments of a
//! row.
//!
//! Method: (M16) takes what the strain of a segment has grown by since the last step, which is kept for it,
//! so stress and viscous part are one force. (M17) along z needs the velocities of nodes two away, all as
//! they were: the moments of row j + 1 are found before row j is swept, here as -M_i. The forces belong to
//! t_n and their rates to t_{n-1/2}, an error of first order in dt of a force that vanishes with the spacing;
//! the tensions that open the moments are those of t_{n-1}, at the latest damage. As a force of the segment
//! between nodes i and i + 1 the moments are M_i - M_{i+1}. What viscosity takes in a step is force times the
//! mean rate of t_{n-1/2} and t_{n+1/2}, as contact counts its impulses. So a step counts half of the rate
//! before it times the forces of the last step and of its own (`sweep/moments.rs` adds what is open).
//! In a graded network (M17) acts on nodes of single yarns alone; a bar has (M16) over its whole length.
//! Limits: velocity Verlet. The step limit is in `sheet/step_limit.rs`.
//! Reference: docs/model.md, "Viscosity".

use crate::ground::lanes::{self, InstructionSet, Job, Lane, at};
use crate::ground::planes::{Axis, CHUNK, Chunk, HOT_PLANES, MOMENT, PAST_PLANES, SPEED_Z, VISCOUS_STRESS};
use crate::scene::features::Feature;
use crate::sheet::columns::{Net, WIDTH};
use crate::sheet::direction::PlyDirections;
use crate::sheet::neighbours::{NOTHING, right_of};
use crate::sweep::segments::{At, Segments, StateChunk};
use crate::yarn::law::{self, ViscosityLanes, ViscositySplats};

/// Past of a row with viscosity: strain and viscous stress of its segments in the last step, and moments of
/// its nodes in this one.
pub struct ViscousRow<'a> {
    /// Past of the row.
    pub past: &'a mut [Chunk<PAST_PLANES>],
    /// Past of the row above; empty for none.
    pub above: &'a [Chunk<PAST_PLANES>],
}

/// Viscosity of the segments of a row.
pub struct Viscous<'a> {
    constants: ViscousAlong,
    row: ViscousRow<'a>,
}

/// Viscosity of segments along x and along y.
pub type ViscousAlong = [ViscositySplats; 2];

impl<'a> Viscous<'a> {
    /// Viscosity of a row's segments in these directions.
    #[inline(always)]
    pub fn of(directions: PlyDirections<'_>, row: ViscousRow<'a>) -> Viscous<'a> {
        Viscous { constants: along(directions), row }
    }

    /// Viscosity of chunk c; None after the last.
    #[inline(always)]
    pub fn on_chunk(&mut self, c: usize) -> Option<ViscousChunk<'_, &mut Chunk<PAST_PLANES>>> {
        let Viscous { constants, row: ViscousRow { past, above } } = self;
        let (past, tail) = past.get_mut(c..)?.split_first_mut()?;
        let (next, above) = (tail.first().unwrap_or(&NO_PAST), above.get(c).unwrap_or(&NO_PAST));
        Some(ViscousChunk { constants, past, next, above })
    }
}

/// Viscosity of segments in these directions.
#[inline(always)]
pub fn along(PlyDirections { horizontal, vertical, .. }: PlyDirections<'_>) -> ViscousAlong {
    [horizontal.viscosity.splats(), vertical.viscosity.splats()]
}

/// Viscosity of the segments of a chunk.
pub struct ViscousChunk<'c, S> {
    /// Constants along x and along y.
    pub constants: &'c ViscousAlong,
    /// Past of the chunk.
    pub past: S,
    /// Past of the next chunk of the row.
    pub next: &'c Chunk<PAST_PLANES>,
    /// Past of the chunk of the row above.
    pub above: &'c Chunk<PAST_PLANES>,
}

impl<S: StateChunk<PAST_PLANES>> ViscousChunk<'_, S> {
    /// Adds the viscous stress of a lane group. Returns the dissipated energy over 1/4 l^2, along x and along
    /// y. The present becomes the past.
    #[inline(always)]
    pub fn act<L: Lane>(&mut self, segments: &mut Segments<L>, place: &At<'_, L>) -> [L; 2] {
        let [of_x, of_y] = self.constants;
        let (stress_y, taken_y) = self.stress(Axis::Vertical, &of_y.lanes(), segments, place);
        let (stress_x, taken_x) = self.stress(Axis::Horizontal, &of_x.lanes(), segments, place);
        segments.stress = [stress_x, stress_y];
        [taken_x, taken_y]
    }

    /// Stress of a lane group along an axis with its viscous part, and the dissipated energy over 1/4 l^2.
    #[inline(always)]
    fn stress<L: Lane>(
        &mut self,
        axis: Axis,
        viscosity: &ViscosityLanes<L>,
        segments: &Segments<L>,
        place: &At<'_, L>,
    ) -> (L, L) {
        let (k, g) = (axis as usize, place.group);
        let (q, stiffness) = (segments.q[k], segments.stiffness[k]);
        let (zero, past) = (L::splat(0.0), at::<L, PAST_PLANES>(self.past.get(), k, g));
        let taut = q.max(zero);
        let growth = place.bars.of_all(axis, taut.sub(past.max(zero)));
        let strain = viscosity.twice_strain(taut, growth);
        let viscous = stiffness.mul(strain.sub(taut));
        let last: L = at(self.past.get(), VISCOUS_STRESS + k, g);
        let dissipated = last.add(viscous).mul(q.sub(past));
        self.past.keep(k, g, q);
        self.past.keep(VISCOUS_STRESS + k, g, viscous);
        (stiffness.mul(strain), dissipated)
    }

    /// Adds the forces along z of the moments at both ends.
    #[inline(always)]
    pub fn add_forces<L: Lane>(&self, [along, upwards]: &mut [[L; 3]; 2], g: usize) {
        let past = self.past.get();
        let (x, y): (L, L) = (at(past, MOMENT, g), at(past, MOMENT + 1, g));
        along[2] = along[2].add(right_of(x, &past[MOMENT], &self.next[MOMENT], g).sub(x));
        upwards[2] = upwards[2].add(at::<L, PAST_PLANES>(self.above, MOMENT + 1, g).sub(y));
    }
}

/// Without a past.
pub(crate) const NO_PAST: Chunk<PAST_PLANES> = [[0.0; CHUNK]; PAST_PLANES];

/// The moments of a row of nodes, along z, of the yarns along x and y. Gives twice what they take in a step,
/// by columns.
pub(crate) struct MomentsOfRow<'a> {
    pub directions: PlyDirections<'a>,
    pub net: &'a Net<'a>,
    pub row: &'a [Chunk<HOT_PLANES>],
    /// The row below and its past; empty below the first.
    pub below: &'a [Chunk<HOT_PLANES>],
    pub past_below: &'a [Chunk<PAST_PLANES>],
    /// Empty above the last.
    pub above: &'a [Chunk<HOT_PLANES>],
    /// Past of the row, whose moments they replace.
    pub past: &'a mut [Chunk<PAST_PLANES>],
}

impl MomentsOfRow<'_> {
    /// Finds those of row j of a ply.
    #[inline(always)]
    pub fn find(&mut self, instructions: InstructionSet, j: usize) -> [f64; CHUNK] {
        if Feature::Grading.is_built() && !self.net.lines.is_empty() {
            lanes::dispatch(instructions, FindMoments::<true>(self, j))
        } else {
            lanes::dispatch(instructions, FindMoments::<false>(self, j))
        }
    }
}

/// [`MomentsOfRow::find`] as a job for the lanes. `GRADED`: in a graded network.
struct FindMoments<'r, 'a, const GRADED: bool>(&'r mut MomentsOfRow<'a>, usize);

impl<const GRADED: bool> Job for FindMoments<'_, '_, GRADED> {
    type Output = [f64; CHUNK];

    #[inline(always)]
    fn run<L: Lane>(self) -> [f64; CHUNK] {
        let FindMoments(MomentsOfRow { directions, net, row, below, past_below, above, past }, j) = self;
        let width = if GRADED { net.row_share(j) } else { 1.0 };
        let (mut along, mut dissipated) = (Moments::<L>::of(*directions, width), [0.0; CHUNK]);
        for (c, (chunk, past)) in row.iter().zip(&mut **past).enumerate() {
            let next = row.get(c + 1).unwrap_or(&NOTHING);
            let (above, below) = (above.get(c).unwrap_or(&NOTHING), below.get(c).unwrap_or(&NOTHING));
            let past_below = past_below.get(c).unwrap_or(&NO_PAST);
            let widths = net.columns.get(c).map_or(&[1.0; CHUNK], |columns| &columns[WIDTH]);
            let nodes = MomentNodes { chunk, next, above, below, past_below, widths };
            // Moments of coarse nodes are 0 and remain so. The fine part is in one piece.
            let is_fine = width == 1.0;
            if !GRADED || is_fine && widths[0] == 1.0 && widths[CHUNK - 1] == 1.0 {
                along.find::<true, true, false>(&nodes, past, &mut dissipated);
            } else if widths.contains(&1.0) {
                if is_fine {
                    along.find::<true, true, true>(&nodes, past, &mut dissipated);
                } else {
                    along.find::<true, false, true>(&nodes, past, &mut dissipated);
                }
            } else {
                if is_fine {
                    along.find::<false, true, true>(&nodes, past, &mut dissipated);
                }
                along.last = velocity_and_stress(chunk, past, CHUNK / L::WIDTH - 1);
            }
        }
        dissipated
    }
}

/// Eight columns of what the moments of a row follow from.
pub(crate) struct MomentNodes<'a> {
    pub chunk: &'a Chunk<HOT_PLANES>,
    /// Next chunk of the row.
    pub next: &'a Chunk<HOT_PLANES>,
    pub above: &'a Chunk<HOT_PLANES>,
    pub below: &'a Chunk<HOT_PLANES>,
    pub past_below: &'a Chunk<PAST_PLANES>,
    /// Read in a graded network only.
    pub widths: &'a [f64; CHUNK],
}

/// Numbers carried along a row whose moments are found.
pub(crate) struct Moments<L> {
    horizontal: ViscosityLanes<L>,
    vertical: ViscosityLanes<L>,
    /// Velocity of the group to the left, and the stress of its segments.
    last: [L; 2],
    /// Width of the row.
    width: L,
}

impl<L: Lane> Moments<L> {
    /// At the start of a row.
    #[inline(always)]
    pub fn of(PlyDirections { horizontal, vertical, .. }: PlyDirections<'_>, width: f64) -> Self {
        let (horizontal, vertical) = (horizontal.viscosity.lanes(), vertical.viscosity.lanes());
        Moments { horizontal, vertical, last: [L::splat(0.0); 2], width: L::splat(width) }
    }

    /// Finds those of eight columns. `past`: theirs; `dissipated`: twice what they take is added, by columns.
    /// `X`, `Y`: yarns along x and along y, both in a row of width 1. `GRADED`: columns have widths.
    #[inline(always)]
    pub fn find<const X: bool, const Y: bool, const GRADED: bool>(
        &mut self,
        nodes: &MomentNodes<'_>,
        past: &mut Chunk<PAST_PLANES>,
        dissipated: &mut [f64; CHUNK],
    ) {
        lanes::each_group!(L, |g| self.group::<X, Y, GRADED>(nodes, past, dissipated, g));
    }

    #[inline(always)]
    fn group<const X: bool, const Y: bool, const GRADED: bool>(
        &mut self,
        nodes: &MomentNodes<'_>,
        past: &mut Chunk<PAST_PLANES>,
        dissipated: &mut [f64; CHUNK],
        g: usize,
    ) {
        let MomentNodes { chunk, next, above, below, past_below, widths } = *nodes;
        let (column, [v, stress]): (L, [L; 2]) = (L::load(&L::groups(widths)[g]), velocity_and_stress(chunk, past, g));
        let (mut along_x, mut along_y) = (L::splat(0.0), L::splat(0.0));
        if X {
            let right = v.sub(right_of(v, &chunk[SPEED_Z], &next[SPEED_Z], g));
            let left = v.sub(v.left_of(self.last[0]));
            let mut bending = self.horizontal.bending(stress.left_of(self.last[1]), stress);
            if GRADED {
                bending = bending.mul(fine(column));
            }
            along_x = moment(left.add(right), bending, &mut L::groups_mut(&mut past[MOMENT])[g]);
            self.last = [v, stress];
        }
        if Y {
            let (up, down) = (v.sub(at(above, SPEED_Z, g)), v.sub(at(below, SPEED_Z, g)));
            let before = law::stress::<L>(at(below, 7, g), at(past_below, 1, g));
            let bending = self.vertical.bending(before, law::stress(at(chunk, 7, g), at(past, 1, g)));
            along_y = moment(down.add(up), bending, &mut L::groups_mut(&mut past[MOMENT + 1])[g]);
        }
        if GRADED {
            (along_x, along_y) = (if Y { along_x } else { along_x.mul(self.width) }, along_y.mul(column));
        }
        let dissipated = &mut L::groups_mut(dissipated)[g];
        L::load(dissipated).add(along_x.add(along_y)).store(dissipated);
    }
}

/// Velocities along z of a lane group, and stresses of the segments from it along x.
#[inline(always)]
fn velocity_and_stress<L: Lane>(chunk: &Chunk<HOT_PLANES>, past: &Chunk<PAST_PLANES>, g: usize) -> [L; 2] {
    [at(chunk, SPEED_Z, g), law::stress(at(chunk, 6, g), at(past, 0, g))]
}

/// 1 for the width 1, else 0: widths between are none of a network.
#[inline(always)]
fn fine<L: Lane>(width: L) -> L {
    L::splat(3.0).sub(width.add(width)).max(L::splat(0.0))
}

/// The moment at this change of the rate along the yarn. Gives twice what it takes.
#[inline(always)]
fn moment<L: Lane>(change: L, bending: L, slot: &mut L::Group) -> L {
    let moment = change.mul(bending);
    let both = L::load(slot).add(moment);
    moment.store(slot);
    both.mul(change)
}
