//! The one hot pass: damage, kick and drift of every node, row by row, in place. Knows nothing of contact.
//!
//! Method: velocity Verlet in staggered form with displacements in units of the spacing h and velocities in h/dt. For a
//! segment with relative displacement d of its ends, d_a along its rest direction, q = U^2 - 1 = d_a (d_a + 2) + d_b^2 + d_c^2
//! (the components in the order x, y, z behind the axial one), and its force adds kk max(q, 0) (e_a + d) to the velocity of
//! its first node, where kk = alpha E A_0 dt^2 / (2 m h). No root and no division below the critical stretch.
//! Each segment is computed once: the horizontal force is carried along the row, the vertical one to the row above.
//! Order of one node's sum: (right - left) + (up - down), exactly mirror-symmetric.
//! Where there is a toe (`toe.rs`) its factor on kk has a path of its own, compiled apart.
//! Limits: dt <= 0.5 dt_crit (see `scene.rs`). A non-finite q is reported, never swallowed.
//! Reference: Powell and Zohdi (2009), equation of motion of the nodes; L. Verlet, Phys. Rev. 159 (1967) 98.

use crate::lanes::{self, InstructionSet, Job, Lane};
use crate::layout::{self, CARRY_PLANES, CHUNK, Chunk, HISTORY_PLANES, HOT_PLANES, MARK_PLANES, YARN_PLANES};
use crate::toe::{NO_TOE, Toe};
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
    /// Chunks of [kh, kv, lambda_h, lambda_v].
    Stochastic(&'a [Chunk<YARN_PLANES>]),
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
            YarnRow::Stochastic(row) => {
                let at = |plane: usize| layout::get(row, axis as usize + plane, i).unwrap_or(0.0);
                (at(0), at(2))
            }
        }
    }
}

/// Constants of the pass.
#[derive(Clone, Copy)]
pub struct Pass<'a> {
    /// Horizontal segments in a row.
    pub horizontals: usize,
    /// Vertical segments above a row.
    pub verticals: usize,
    /// Damage law.
    pub law: &'a DamageLaw,
    /// q at the critical stretch.
    pub critical: f64,
    /// The toe of marked segments.
    pub toe: Toe,
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

/// One row of the pass: [`Pass::row`] as a job for the lanes. TOE: whether there are marks.
struct RowJob<'a, const TOE: bool> {
    pass: &'a Pass<'a>,
    row: &'a mut [Chunk<HOT_PLANES>],
    history: &'a mut [Chunk<HISTORY_PLANES>],
    above: &'a [Chunk<HOT_PLANES>],
    carry: &'a mut [Chunk<CARRY_PLANES>],
    yarn: YarnRow<'a>,
    marks: &'a [Chunk<MARK_PLANES>],
}

/// Marks of no toe.
const NO_MARKS: Chunk<MARK_PLANES> = [[NO_TOE; CHUNK]; MARK_PLANES];

/// What stands above the top row: nothing that moves, held by segments of no stiffness.
const NOTHING_ABOVE: Chunk<HOT_PLANES> = [[0.0; CHUNK]; HOT_PLANES];

impl Pass<'_> {
    /// Steps one row. `row`: its hot chunks; `history`: its history; `above`: the row above, empty for the top row;
    /// `carry`: the vertical forces from the row below, replaced by those to the row above; `marks`: its toe's marks, empty for
    /// no toe. Returns what was met, and the least and greatest y displacement.
    pub fn row(
        &self,
        row: &mut [Chunk<HOT_PLANES>],
        history: &mut [Chunk<HISTORY_PLANES>],
        above: &[Chunk<HOT_PLANES>],
        carry: &mut [Chunk<CARRY_PLANES>],
        yarn: YarnRow<'_>,
        marks: &[Chunk<MARK_PLANES>],
    ) -> (Report, [f64; 2]) {
        let pass = self;
        if marks.is_empty() {
            lanes::dispatch(self.instructions, RowJob::<false> { pass, row, history, above, carry, yarn, marks })
        } else {
            lanes::dispatch(self.instructions, RowJob::<true> { pass, row, history, above, carry, yarn, marks })
        }
    }
}

impl<const TOE: bool> Job for RowJob<'_, TOE> {
    type Output = (Report, [f64; 2]);

    #[inline(always)]
    fn run<L: Lane>(self) -> (Report, [f64; 2]) {
        let RowJob { pass, row, history, above, carry, yarn, marks } = self;
        let zero = L::splat(0.0);
        let mut along = Along::<L, TOE> {
            pass,
            yarn,
            limit: L::splat(pass.critical),
            horizontal_end: pass.horizontals,
            vertical_end: if above.is_empty() { 0 } else { pass.verticals },
            here: first_displacement(row.first()),
            left_pull: [zero; 3],
            low: zero,
            high: zero,
            report: Report::default(),
        };
        let mut rest = row;
        for (c, (history, carry)) in history.iter_mut().zip(carry).enumerate() {
            let Some((chunk, tail)) = rest.split_first_mut() else { break };
            let above = above.get(c).unwrap_or(&NOTHING_ABOVE);
            // The node to the right of the last group: the next chunk's first, or a zero of no consequence.
            let next = first_displacement(tail.first());
            let marks = if TOE { marks.get(c).unwrap_or(&NO_MARKS) } else { &NO_MARKS };
            let mut planes = Planes { chunk, history, above, carry, marks, next, column: c * CHUNK };
            // Written out where the groups are few, so that every place in the chunk is a constant.
            match CHUNK / L::WIDTH {
                1 => along.group(&mut planes, 0),
                2 => {
                    along.group(&mut planes, 0);
                    along.group(&mut planes, 1);
                }
                groups => {
                    for g in 0..groups {
                        along.group(&mut planes, g);
                    }
                }
            }
            rest = tail;
        }
        (along.report, [least(along.low), greatest(along.high)])
    }
}

/// Displacement of the first lane group of a chunk, zero where there is none.
#[inline(always)]
fn first_displacement<L: Lane>(chunk: Option<&Chunk<HOT_PLANES>>) -> [L; 3] {
    match chunk {
        Some([x, y, z, ..]) => [L::load(&L::groups(x)[0]), L::load(&L::groups(y)[0]), L::load(&L::groups(z)[0])],
        None => [L::splat(0.0); 3],
    }
}

/// Eight columns of everything a row needs.
struct Planes<'a, L> {
    chunk: &'a mut Chunk<HOT_PLANES>,
    history: &'a mut Chunk<HISTORY_PLANES>,
    above: &'a Chunk<HOT_PLANES>,
    carry: &'a mut Chunk<CARRY_PLANES>,
    marks: &'a Chunk<MARK_PLANES>,
    /// Displacement of the lane group behind this chunk.
    next: [L; 3],
    /// First column.
    column: usize,
}

/// What is carried along a row from one lane group to the next.
struct Along<'a, L, const TOE: bool> {
    pass: &'a Pass<'a>,
    yarn: YarnRow<'a>,
    limit: L,
    /// Horizontal segments start before this column.
    horizontal_end: usize,
    /// Vertical segments start before this column.
    vertical_end: usize,
    here: [L; 3],
    left_pull: [L; 3],
    low: L,
    high: L,
    report: Report,
}

impl<L: Lane, const TOE: bool> Along<'_, L, TOE> {
    /// One lane group: damage, forces, kick and drift.
    #[inline(always)]
    fn group(&mut self, planes: &mut Planes<'_, L>, g: usize) {
        let [ux, uy, uz, vx, vy, vz, kh, kv] = &mut *planes.chunk;
        let (ux, uy, uz) = (L::groups_mut(ux), L::groups_mut(uy), L::groups_mut(uz));
        let (vx, vy, vz) = (L::groups_mut(vx), L::groups_mut(vy), L::groups_mut(vz));
        let (kh, kv) = (L::groups_mut(kh), L::groups_mut(kv));
        let [ax, ay, az, ..] = planes.above;
        let (ax, ay, az) = (L::groups(ax), L::groups(ay), L::groups(az));
        let [cx, cy, cz] = &mut *planes.carry;
        let (cx, cy, cz) = (L::groups_mut(cx), L::groups_mut(cy), L::groups_mut(cz));
        let [history_h, history_v] = &mut *planes.history;
        let (history_h, history_v) = (L::groups_mut(history_h), L::groups_mut(history_v));
        let [mark_h, mark_v] = planes.marks;
        let (mark_h, mark_v) = (L::groups(mark_h), L::groups(mark_v));
        let here = self.here;
        let next = if g + 1 < CHUNK / L::WIDTH {
            [L::load(&ux[g + 1]), L::load(&uy[g + 1]), L::load(&uz[g + 1])]
        } else {
            planes.next
        };
        let column = planes.column + g * L::WIDTH;

        let d = [
            here[0].right_of(next[0]).sub(here[0]),
            here[1].right_of(next[1]).sub(here[1]),
            here[2].right_of(next[2]).sub(here[2]),
        ];
        let q = excess_horizontal(d);
        if q.any_not_below(self.limit) && q.any_above(L::load(&history_h[g])) {
            let place = Place { first: column, end: self.horizontal_end, axis: Axis::Horizontal };
            self.report.add(self.pass.damage(q, place, &self.yarn, &mut history_h[g], &mut kh[g]));
        }
        let pull = pull_horizontal(self.stiffness(&kh[g], q, &mark_h[g]), q, d);

        let d = [L::load(&ax[g]).sub(here[0]), L::load(&ay[g]).sub(here[1]), L::load(&az[g]).sub(here[2])];
        let q = excess_vertical(d);
        if q.any_not_below(self.limit) && q.any_above(L::load(&history_v[g])) {
            let place = Place { first: column, end: self.vertical_end, axis: Axis::Vertical };
            self.report.add(self.pass.damage(q, place, &self.yarn, &mut history_v[g], &mut kv[g]));
        }
        let lift = pull_vertical(self.stiffness(&kv[g], q, &mark_v[g]), q, d);

        let kick = Kick { here, pull, left_pull: self.left_pull, lift };
        kick.axis(0, &mut vx[g], &mut ux[g], &mut cx[g]);
        let y = kick.axis(1, &mut vy[g], &mut uy[g], &mut cy[g]);
        kick.axis(2, &mut vz[g], &mut uz[g], &mut cz[g]);
        self.low = y.min(self.low);
        self.high = y.max(self.high);
        self.left_pull = pull;
        self.here = next;
    }

    /// kk, with the toe's factor where there is a toe.
    #[inline(always)]
    fn stiffness(&self, stiffness: &L::Group, q: L, mark: &L::Group) -> L {
        let stiffness = L::load(stiffness);
        if TOE { stiffness.mul(self.pass.toe.factor(q, L::load(mark))) } else { stiffness }
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
