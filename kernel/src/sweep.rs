//! The one hot pass: damage, kick and drift of every node, row by row, in place. Knows nothing of contact.
//!
//! Method: velocity Verlet in staggered form with displacements in units of the spacing h and velocities in h/dt. For a
//! segment with relative displacement d of its ends, d_a along its rest direction, q = U^2 - 1 = d_a (d_a + 2) + d_b^2 + d_c^2
//! (the components in the order x, y, z behind the axial one), and its force adds kk max(q, 0) (e_a + d) to the velocity of
//! its first node, where kk = alpha E A_0 dt^2 / (2 m h). No root and no division below the critical stretch.
//! Each segment is computed once: the horizontal force is carried along the row, the vertical one to the row above.
//! Order of one node's sum: (right - left) + (up - down), exactly mirror-symmetric.
//! Limits: dt <= 0.5 dt_crit (see `scene.rs`). A non-finite q is reported, never swallowed.
//! Reference: Powell and Zohdi (2009), equation of motion of the nodes; L. Verlet, Phys. Rev. 159 (1967) 98.

use crate::lanes::{self, InstructionSet, Job, Lane};
use crate::layout::{HISTORY_PLANES, HOT_PLANES, PAD, YARN_PLANES};
use crate::yarn::DamageLaw;

/// What one pass met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// Segments whose alpha became 0.
    pub newly_failed: u64,
    /// A non-finite q was met: the state is lost.
    pub non_finite: bool,
}

/// Where a row's segments find their constants.
#[derive(Clone, Copy)]
pub enum YarnRow<'a> {
    /// All alike.
    Uniform {
        /// Undamaged stiffness kk.
        stiffness: f64,
        /// Damage rate.
        damage_rate: f64,
    },
    /// [kh, kv, lambda_h, lambda_v] planes of the row.
    Stochastic(&'a [f64]),
}

/// History of a failed segment: above every q.
pub const FAILED: f64 = f64::MAX;

/// Direction of a segment.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// To the right-hand neighbour, along x.
    Horizontal = 0,
    /// To the neighbour above, along y.
    Vertical = 1,
}

impl YarnRow<'_> {
    /// Undamaged stiffness and damage rate of the segment that starts at column i; zero stiffness where none exists.
    pub fn constants(&self, axis: Axis, i: usize) -> (f64, f64) {
        match self {
            YarnRow::Uniform { stiffness, damage_rate } => (*stiffness, *damage_rate),
            YarnRow::Stochastic(planes) => {
                let stride = planes.len() / YARN_PLANES;
                let at = axis as usize * stride + PAD + i;
                let get = |k: usize| planes.get(k).copied().unwrap_or(0.0);
                (get(at), get(at + 2 * stride))
            }
        }
    }
}

/// Constants of the pass.
#[derive(Clone, Copy)]
pub struct Pass<'a> {
    /// Nodes along x.
    pub nodes_x: usize,
    /// Numbers in a plane.
    pub stride: usize,
    /// Damage law.
    pub law: &'a DamageLaw,
    /// q at the critical stretch.
    pub critical: f64,
    /// Instruction set; changes the speed, not the bits.
    pub instructions: InstructionSet,
}

/// q = U^2 - 1 of a horizontal segment from the relative displacement of its ends.
#[inline(always)]
pub fn excess_horizontal<L: Lane>(d: [L; 3]) -> L {
    d[0].mul(d[0].add(L::splat(2.0))).add(d[1].mul(d[1])).add(d[2].mul(d[2]))
}

/// q = U^2 - 1 of a vertical segment.
#[inline(always)]
pub fn excess_vertical<L: Lane>(d: [L; 3]) -> L {
    d[1].mul(d[1].add(L::splat(2.0))).add(d[0].mul(d[0])).add(d[2].mul(d[2]))
}

/// Force of a horizontal segment on its first node, as a change of velocity: kk max(q, 0) (e_x + d).
#[inline(always)]
pub fn pull_horizontal<L: Lane>(stiffness: L, q: L, d: [L; 3]) -> [L; 3] {
    let s = stiffness.mul(q.max(L::splat(0.0)));
    [s.mul(d[0].add(L::splat(1.0))), s.mul(d[1]), s.mul(d[2])]
}

/// Force of a vertical segment on its first node: kk max(q, 0) (e_y + d).
#[inline(always)]
pub fn pull_vertical<L: Lane>(stiffness: L, q: L, d: [L; 3]) -> [L; 3] {
    let s = stiffness.mul(q.max(L::splat(0.0)));
    [s.mul(d[0]), s.mul(d[1].add(L::splat(1.0))), s.mul(d[2])]
}

/// Sum of a node's four forces, in the order that everything keeps.
#[inline(always)]
pub fn node_sum<L: Lane>(right: L, left: L, up: L, down: L) -> L {
    right.sub(left).add(up.sub(down))
}

/// One row of the pass: [`Pass::row`] as a job for the lanes.
struct RowJob<'p, 'a> {
    pass: &'p Pass<'p>,
    planes: Planes<'a>,
    yarn: YarnRow<'a>,
    top: bool,
    range: &'a mut [f64; 2],
}

impl Pass<'_> {
    /// Steps one row. `row`: its hot planes; `history`: its history planes; `above`: at least the displacement planes of
    /// the row above (zeros for the top row); `carry`: three planes with the vertical forces from the row below, replaced
    /// by those to the row above. `top`: there is no row above. Returns what was met; `range` receives the least and
    /// greatest y displacement.
    #[allow(clippy::too_many_arguments)] // One hot loop over separate slices: the compiler must see that they do not alias.
    pub fn row(
        &self,
        row: &mut [f64],
        history: &mut [f64],
        above: &[f64],
        carry: &mut [f64],
        yarn: YarnRow<'_>,
        top: bool,
        range: &mut [f64; 2],
    ) -> Report {
        match Planes::of(row, history, above, carry, self.nodes_x, self.stride) {
            Some(planes) => lanes::dispatch(self.instructions, RowJob { pass: self, planes, yarn, top, range }),
            None => {
                debug_assert!(false, "row slices have the layout's lengths");
                Report { newly_failed: 0, non_finite: true }
            }
        }
    }
}

impl Job for RowJob<'_, '_> {
    type Output = Report;

    #[inline(always)]
    fn run<L: Lane>(self) -> Report {
        let RowJob { pass, planes, yarn, top, range } = self;
        // Whole groups that hold the row's nodes; displacements have one group more, of zeros.
        let count = pass.nodes_x.div_ceil(L::WIDTH);
        let Planes { u, v, stiffness, history, above, carry } = planes;
        let (Some([ux, uy, uz]), Some([vx, vy, vz]), Some([kh, kv])) =
            (groups_mut::<L, 3>(u, count + 1), groups_mut::<L, 3>(v, count), groups_mut::<L, 2>(stiffness, count))
        else {
            return Report::default();
        };
        let (Some([history_h, history_v]), Some([cx, cy, cz]), Some([ax, ay, az])) =
            (groups_mut::<L, 2>(history, count), groups_mut::<L, 3>(carry, count), groups::<L, 3>(above, count))
        else {
            return Report::default();
        };

        // Said once more where the compiler sees it: no index of the loop needs a check.
        if ux.len() != count + 1 || uy.len() != count + 1 || uz.len() != count + 1 || count == 0 {
            return Report::default();
        }
        if vx.len() != count || vy.len() != count || vz.len() != count || kh.len() != count || kv.len() != count {
            return Report::default();
        }
        if ax.len() != count || ay.len() != count || az.len() != count || history_h.len() != count {
            return Report::default();
        }
        if cx.len() != count || cy.len() != count || cz.len() != count || history_v.len() != count {
            return Report::default();
        }

        let mut report = Report::default();
        let limit = L::splat(pass.critical);
        let zero = L::splat(0.0);
        let (mut low, mut high) = (zero, zero);
        let mut here = [L::load(&ux[0]), L::load(&uy[0]), L::load(&uz[0])];
        let mut left_pull = [zero; 3];
        for g in 0..count {
            let next = [L::load(&ux[g + 1]), L::load(&uy[g + 1]), L::load(&uz[g + 1])];

            let d = [
                here[0].right_of(next[0]).sub(here[0]),
                here[1].right_of(next[1]).sub(here[1]),
                here[2].right_of(next[2]).sub(here[2]),
            ];
            let q = excess_horizontal(d);
            if q.any_not_below(limit) && q.any_above(L::load(&history_h[g])) {
                let place = Place { first: g * L::WIDTH, end: pass.nodes_x - 1, axis: Axis::Horizontal };
                report.add(pass.damage(q, place, &yarn, &mut history_h[g], &mut kh[g]));
            }
            let pull = pull_horizontal(L::load(&kh[g]), q, d);

            let d = [L::load(&ax[g]).sub(here[0]), L::load(&ay[g]).sub(here[1]), L::load(&az[g]).sub(here[2])];
            let q = excess_vertical(d);
            if q.any_not_below(limit) && q.any_above(L::load(&history_v[g])) {
                let end = if top { 0 } else { pass.nodes_x };
                let place = Place { first: g * L::WIDTH, end, axis: Axis::Vertical };
                report.add(pass.damage(q, place, &yarn, &mut history_v[g], &mut kv[g]));
            }
            let lift = pull_vertical(L::load(&kv[g]), q, d);

            let motion = Kick { here, pull, left_pull, lift };
            motion.axis(0, &mut vx[g], &mut ux[g], &mut cx[g]);
            let y = motion.axis(1, &mut vy[g], &mut uy[g], &mut cy[g]);
            motion.axis(2, &mut vz[g], &mut uz[g], &mut cz[g]);
            low = y.min(low);
            high = y.max(high);
            left_pull = pull;
            here = next;
        }
        *range = [least(low), greatest(high)];
        report
    }
}

/// Kick and drift of one lane group of nodes. (Methods, not closures: they must be compiled for the instruction set.)
struct Kick<L> {
    here: [L; 3],
    pull: [L; 3],
    left_pull: [L; 3],
    lift: [L; 3],
}

impl<L: Lane> Kick<L> {
    /// v <- v + a, u <- u + v along one axis; hands the vertical force on to the row above. Returns the new u.
    #[inline(always)]
    fn axis(&self, axis: usize, v: &mut L::Group, u: &mut L::Group, below: &mut L::Group) -> L {
        let left = self.pull[axis].left_of(self.left_pull[axis]);
        let sum = node_sum(self.pull[axis], left, self.lift[axis], L::load(below));
        let velocity = L::load(v).add(sum);
        velocity.store(v);
        let moved = self.here[axis].add(velocity);
        moved.store(u);
        self.lift[axis].store(below);
        moved
    }
}

/// Smallest number of a lane group, or 0.
#[inline(always)]
fn least<L: Lane>(lanes: L) -> f64 {
    let mut group = L::ZEROS;
    lanes.store(&mut group);
    group.as_ref().iter().fold(0.0, |a, &b| if b < a { b } else { a })
}

/// Greatest number of a lane group, or 0.
#[inline(always)]
fn greatest<L: Lane>(lanes: L) -> f64 {
    let mut group = L::ZEROS;
    lanes.store(&mut group);
    group.as_ref().iter().fold(0.0, |a, &b| if b > a { b } else { a })
}

/// The first `count` groups of each plane.
#[inline(always)]
fn groups<L: Lane, const N: usize>(planes: [&[f64]; N], count: usize) -> Option<[&[L::Group]; N]> {
    let mut out = [&[] as &[L::Group]; N];
    for (slot, plane) in out.iter_mut().zip(planes) {
        *slot = L::groups(plane).get(..count)?;
    }
    Some(out)
}

/// The first `count` groups of each plane, to be changed.
#[inline(always)]
fn groups_mut<L: Lane, const N: usize>(planes: [&mut [f64]; N], count: usize) -> Option<[&mut [L::Group]; N]> {
    let mut out = core::array::from_fn(|_| <&mut [L::Group]>::default());
    for (slot, plane) in out.iter_mut().zip(planes) {
        *slot = L::groups_mut(plane).get_mut(..count)?;
    }
    Some(out)
}

/// Which segments a lane group holds.
#[derive(Clone, Copy)]
struct Place {
    /// Column of the first.
    first: usize,
    /// Segments exist up to this column.
    end: usize,
    /// Direction.
    axis: Axis,
}

impl Pass<'_> {
    /// The cold path: a lane group in which some q is at or beyond the critical one and above all before, or not finite.
    #[cold]
    #[inline(never)]
    fn damage<L: Lane>(
        &self,
        q: L,
        place: Place,
        yarn: &YarnRow<'_>,
        history: &mut L::Group,
        stiffness: &mut L::Group,
    ) -> Report {
        let mut excess = L::ZEROS;
        q.store(&mut excess);
        let mut report = Report::default();
        let slots = history.as_mut().iter_mut().zip(stiffness.as_mut());
        for (lane, (&q, (history, stiffness))) in excess.as_ref().iter().zip(slots).enumerate() {
            let column = place.first + lane;
            if column < place.end {
                report.add(self.damage_segment(q, yarn, place.axis, column, history, stiffness));
            }
        }
        report
    }

    /// Only a new maximum of q changes anything: alpha is a function of the largest q, so the exponential runs only then.
    fn damage_segment(
        &self,
        q: f64,
        yarn: &YarnRow<'_>,
        axis: Axis,
        column: usize,
        history: &mut f64,
        stiffness: &mut f64,
    ) -> Report {
        if !q.is_finite() {
            return Report { newly_failed: 0, non_finite: true };
        }
        if !(q > self.critical && q > *history) {
            return Report::default();
        }
        let failed_before = *stiffness == 0.0;
        let (undamaged, damage_rate) = yarn.constants(axis, column);
        let alpha = self.law.alpha(damage_rate, q);
        *stiffness = alpha * undamaged;
        // A failed segment never comes here again: no q is above this.
        *history = if alpha == 0.0 { FAILED } else { q };
        Report { newly_failed: u64::from(alpha == 0.0 && !failed_before), non_finite: false }
    }
}

impl Report {
    fn add(&mut self, other: Report) {
        self.newly_failed += other.newly_failed;
        self.non_finite |= other.non_finite;
    }

    /// Both reports together.
    pub fn merged(mut self, other: Report) -> Report {
        self.add(other);
        self
    }
}

/// The planes of one row without their leading zeros.
struct Planes<'a> {
    u: [&'a mut [f64]; 3],
    v: [&'a mut [f64]; 3],
    stiffness: [&'a mut [f64]; 2],
    history: [&'a mut [f64]; 2],
    above: [&'a [f64]; 3],
    carry: [&'a mut [f64]; 3],
}

impl<'a> Planes<'a> {
    fn of(
        row: &'a mut [f64],
        history: &'a mut [f64],
        above: &'a [f64],
        carry: &'a mut [f64],
        nodes: usize,
        stride: usize,
    ) -> Option<Planes<'a>> {
        // The values, and eight zeros behind them.
        if stride < PAD + nodes.next_multiple_of(PAD) + PAD {
            return None;
        }
        let [ux, uy, uz, vx, vy, vz, kh, kv] = split_planes::<HOT_PLANES>(row, stride)?;
        let above = |plane: usize| above.get(plane * stride + PAD..(plane + 1) * stride);
        Some(Planes {
            u: [ux, uy, uz],
            v: [vx, vy, vz],
            stiffness: [kh, kv],
            history: split_planes::<HISTORY_PLANES>(history, stride)?,
            above: [above(0)?, above(1)?, above(2)?],
            carry: split_planes::<3>(carry, stride)?,
        })
    }
}

/// A row cut into its planes, each without its leading zeros.
fn split_planes<const N: usize>(row: &mut [f64], stride: usize) -> Option<[&mut [f64]; N]> {
    let mut planes = row.chunks_exact_mut(stride);
    let mut out = core::array::from_fn(|_| <&mut [f64]>::default());
    for plane in out.iter_mut() {
        *plane = planes.next()?.get_mut(PAD..)?;
    }
    Some(out)
}
