//! Segments from displacement to force: the one evaluator of the yarns' forces, for lane groups of the sweep and for single segments.
//!
//! Method: strain and stress by the yarn law (`yarn/law.rs`) with the stiffness kk = alpha E A_0 dt^2/(2 m h l), damage of what is strained
//! beyond all before, then what effects change, then the forces. Sums of forces give the change of velocity of the nodes.
//! Each function is generic over the lanes, over the geometry at rest (`columns.rs`) and over the effects, each in its own file: viscosity
//! (`viscous.rs`), slack balance (`slack.rs`), dependence on the rate (`strain_rate.rs`), case (`casing.rs`).
//! Limits: a q that is no number, or beyond any fabric's, is reported, never swallowed.
//! Reference: docs/model.md, "The step".

use crate::ground::lanes::{Lane, at};
use crate::ground::planes::{self, Axis, CHUNK, Chunk, STRENGTH_PLANES, X, YARN_PLANES, vertical_axes};
use crate::sheet::columns::{At, Bars, Columns, Geometry};
use crate::sheet::direction::{Along, Direction};
use crate::sheet::neighbours::Around;
use crate::sheet::symmetry::Line;
use crate::yarn::law::{self, DamageLaw, LOST};
use crate::yarn::rate::Rates;
use core::hint::black_box;

/// Segments of one lane group on their way from displacement to force: along x and along y, side by side, so that a processor has two
/// chains of operations to overlap. (No closures and no array maps: they would not be compiled for the instruction set.)
#[derive(Clone, Copy)]
pub struct Segments<L> {
    /// Relative displacement of the ends in the axes of the sheet, spacings.
    pub d: [[L; 3]; 2],
    /// Twice the strain.
    pub q: [L; 2],
    /// Stiffness before the damage of this pass.
    pub before: [L; 2],
    /// Stiffness.
    pub stiffness: [L; 2],
    /// Stress in the unit of stiffness.
    pub stress: [L; 2],
}

impl<L: Lane> Segments<L> {
    /// Strain of the segments from group g; stiffness and stress follow.
    #[inline(always)]
    pub fn strained(around: &Around<'_>, bars: &Bars<L>, g: usize) -> Segments<L> {
        let d = around.differences::<L>(X, g);
        let [along, upwards] = &bars.rests;
        let q = [along.twice_strain(d[0]), upwards.twice_strain(vertical_axes(d[1]))];
        let before = around.stiffness::<L>(g);
        Segments { d, q, before, stiffness: before, stress: q }
    }

    /// Elastic stress at this stiffness.
    #[inline(always)]
    pub fn relax(&mut self, stiffness: [L; 2]) {
        self.stiffness = stiffness;
        self.stress = [law::stress(stiffness[0], self.q[0]), law::stress(stiffness[1], self.q[1])];
    }

    /// Forces on the first nodes, in the axes of the sheet.
    #[inline(always)]
    pub fn forces(&self, bars: &Bars<L>) -> [[L; 3]; 2] {
        let [along, upwards] = &bars.rests;
        let up = upwards.force(self.stress[1], vertical_axes(self.d[1]));
        [along.force(self.stress[0], self.d[0]), vertical_axes(up)]
    }
}

/// (M22) Change of velocity of nodes by one component of their forces, of which `vertical` is up - down. The order of the sum is exactly
/// mirror-symmetric.
#[inline(always)]
pub fn per_mass<L: Lane>(right: L, left: L, vertical: L, [column, row]: [L; 2]) -> L {
    right.sub(left).mul(column).add(vertical.mul(row))
}

/// Planes of [`Segments`] in a [`Stage`].
const STAGE_PLANES: usize = 14;

/// Segments of a chunk between two stages of a sweep.
#[repr(align(64))]
pub struct Stage(Chunk<STAGE_PLANES>);

impl Stage {
    /// Without segments.
    pub const EMPTY: Stage = Stage([[0.0; CHUNK]; STAGE_PLANES]);

    /// Keeps the segments of group g.
    #[inline(always)]
    pub fn keep<L: Lane>(&mut self, segments: &Segments<L>, g: usize) {
        let Segments { d: [along, upwards], q, before, stiffness, stress } = segments;
        for (k, d) in [along, upwards].into_iter().enumerate() {
            self.put(3 * k, d[0], g);
            self.put(3 * k + 1, d[1], g);
            self.put(3 * k + 2, d[2], g);
            self.put(6 + k, q[k], g);
            self.put(8 + k, before[k], g);
            self.put(10 + k, stiffness[k], g);
            self.put(12 + k, stress[k], g);
        }
    }

    /// Keeps what an effect may have changed of the segments of group g.
    #[inline(always)]
    pub fn change<L: Lane>(&mut self, segments: &Segments<L>, g: usize) {
        for k in 0..2 {
            self.put(10 + k, segments.stiffness[k], g);
            self.put(12 + k, segments.stress[k], g);
        }
    }

    #[inline(always)]
    fn put<L: Lane>(&mut self, plane: usize, numbers: L, g: usize) {
        numbers.store(&mut L::groups_mut(&mut self.0[plane])[g]);
    }

    /// Segments of group g.
    #[inline(always)]
    pub fn segments<L: Lane>(&self, g: usize) -> Segments<L> {
        let Stage(planes) = self;
        Segments {
            d: [
                [at(planes, 0, g), at(planes, 1, g), at(planes, 2, g)],
                [at(planes, 3, g), at(planes, 4, g), at(planes, 5, g)],
            ],
            q: [at(planes, 6, g), at(planes, 7, g)],
            before: [at(planes, 8, g), at(planes, 9, g)],
            stiffness: [at(planes, 10, g), at(planes, 11, g)],
            stress: [at(planes, 12, g), at(planes, 13, g)],
        }
    }
}

/// Segments whose stiffness may have fallen in this pass.
pub struct Fall<L> {
    /// Twice the strain.
    pub q: [L; 2],
    /// Stiffness before and after.
    pub stiffness: [[L; 2]; 2],
    /// First column.
    pub column: usize,
}

impl<L: Lane> Fall<L> {
    /// Shows each segment whose stiffness has fallen to `see`, column by column: its lane, axis, twice its strain, and stiffness before and
    /// after.
    #[inline(always)]
    pub fn each(&self, mut see: impl FnMut(usize, Axis, f64, [f64; 2])) {
        let mut numbers = [L::ZEROS; 6];
        let [before, now] = self.stiffness;
        for (group, lanes) in numbers.iter_mut().zip([self.q[0], self.q[1], before[0], before[1], now[0], now[1]]) {
            lanes.store(group);
        }
        let at = |plane: usize, lane: usize| numbers.get(plane).and_then(|group| group.as_ref().get(lane)).copied();
        for (lane, axis) in (0..L::WIDTH).flat_map(|lane| [(lane, Axis::Horizontal), (lane, Axis::Vertical)]) {
            let k = axis as usize;
            if let (Some(q), Some(before), Some(now)) = (at(k, lane), at(2 + k, lane), at(4 + k, lane))
                && now != before
            {
                see(lane, axis, q, [before, now]);
            }
        }
    }
}

/// Chunk on which effects act.
pub struct Place<'a, G> {
    /// Geometry of its row.
    pub geometry: &'a G,
    /// Its columns.
    pub columns: &'a Columns,
    /// Its nodes and their neighbours.
    pub around: Around<'a>,
    /// Its number.
    pub chunk: usize,
}

/// What changes the motion besides elasticity and damage. Each method does nothing by default.
pub trait Effect {
    /// Changes stiffness and stress of a lane group.
    #[inline(always)]
    fn act<L: Lane>(&mut self, _: &mut Segments<L>, _: &Bars<L>, _: &Around<'_>, _: At, _: &mut Dissipation) {}

    /// Learns which stiffnesses damage has changed.
    #[inline(always)]
    fn note_fall<L: Lane>(&mut self, _: &Fall<L>, _: &Yarns<'_>, _: At, _: &mut Dissipation) {}

    /// Adds to the forces on the first nodes.
    #[inline(always)]
    fn add_forces<L: Lane>(&self, _: &mut [[L; 3]; 2], _: At) {}

    /// Change of velocity of nodes that the yarns would change by `change`.
    #[inline(always)]
    fn constrain<L: Lane>(&mut self, change: [L; 3], _: &Around<'_>, _: At) -> [L; 3] {
        change
    }

    /// [`Effect::act`] on all groups of a chunk in a stage of its own.
    #[inline(always)]
    fn act_on_chunk<L: Lane, G: Geometry>(
        &mut self,
        stage: &mut Stage,
        place: &Place<'_, G>,
        dissipation: &mut Dissipation,
    ) {
        self.act_on_group::<L, G>(stage, place, 0, dissipation);
        if L::WIDTH < CHUNK {
            self.act_on_group::<L, G>(stage, place, 1, dissipation);
        }
        if L::WIDTH < CHUNK / 2 {
            self.act_on_group::<L, G>(stage, place, 2, dissipation);
            self.act_on_group::<L, G>(stage, place, 3, dissipation);
        }
    }

    /// [`Effect::act`] on a group.
    #[inline(always)]
    fn act_on_group<L: Lane, G: Geometry>(
        &mut self,
        stage: &mut Stage,
        Place { geometry, columns, around, chunk }: &Place<'_, G>,
        group: usize,
        dissipation: &mut Dissipation,
    ) {
        let mut segments = stage.segments::<L>(group);
        self.act(&mut segments, &geometry.bars(columns, group), around, At { chunk: *chunk, group }, dissipation);
        stage.change(&segments, group);
    }

    /// Whether the effect acts in a stage of its own, and not in the registers of the one loop.
    #[inline(always)]
    fn is_staged() -> bool {
        false
    }
}

/// No effect.
impl Effect for () {}

/// An effect that only some sheets have: asked for once in a chunk. The compiler is not to see that it is always the same one: constants of all
/// effects, kept over the loop, would take kilobytes of stack.
impl<E: Effect> Effect for Option<E> {
    #[inline(always)]
    fn act<L: Lane>(
        &mut self,
        segments: &mut Segments<L>,
        bars: &Bars<L>,
        around: &Around<'_>,
        at: At,
        dissipation: &mut Dissipation,
    ) {
        if let Some(effect) = black_box(self) {
            effect.act(segments, bars, around, at, dissipation);
        }
    }

    #[inline(always)]
    fn note_fall<L: Lane>(&mut self, fall: &Fall<L>, yarns: &Yarns<'_>, at: At, dissipation: &mut Dissipation) {
        if let Some(effect) = black_box(self) {
            effect.note_fall(fall, yarns, at, dissipation);
        }
    }

    #[inline(always)]
    fn add_forces<L: Lane>(&self, forces: &mut [[L; 3]; 2], at: At) {
        if let Some(effect) = black_box(self) {
            effect.add_forces(forces, at);
        }
    }

    #[inline(always)]
    fn constrain<L: Lane>(&mut self, change: [L; 3], around: &Around<'_>, at: At) -> [L; 3] {
        match black_box(self) {
            Some(effect) => effect.constrain(change, around, at),
            None => change,
        }
    }

    #[inline(always)]
    fn act_on_chunk<L: Lane, G: Geometry>(
        &mut self,
        stage: &mut Stage,
        place: &Place<'_, G>,
        dissipation: &mut Dissipation,
    ) {
        if let Some(effect) = black_box(self) {
            effect.act_on_chunk::<L, G>(stage, place, dissipation);
        }
    }

    #[inline(always)]
    fn is_staged() -> bool {
        true
    }
}

/// Two effects, the first one first.
impl<A: Effect, B: Effect> Effect for (A, B) {
    #[inline(always)]
    fn act<L: Lane>(
        &mut self,
        segments: &mut Segments<L>,
        bars: &Bars<L>,
        around: &Around<'_>,
        at: At,
        dissipation: &mut Dissipation,
    ) {
        self.0.act(segments, bars, around, at, dissipation);
        self.1.act(segments, bars, around, at, dissipation);
    }

    #[inline(always)]
    fn note_fall<L: Lane>(&mut self, fall: &Fall<L>, yarns: &Yarns<'_>, at: At, dissipation: &mut Dissipation) {
        self.0.note_fall(fall, yarns, at, dissipation);
        self.1.note_fall(fall, yarns, at, dissipation);
    }

    #[inline(always)]
    fn add_forces<L: Lane>(&self, forces: &mut [[L; 3]; 2], at: At) {
        self.0.add_forces(forces, at);
        self.1.add_forces(forces, at);
    }

    #[inline(always)]
    fn constrain<L: Lane>(&mut self, change: [L; 3], around: &Around<'_>, at: At) -> [L; 3] {
        let change = self.0.constrain(change, around, at);
        self.1.constrain(change, around, at)
    }

    #[inline(always)]
    fn act_on_chunk<L: Lane, G: Geometry>(
        &mut self,
        stage: &mut Stage,
        place: &Place<'_, G>,
        dissipation: &mut Dissipation,
    ) {
        self.0.act_on_chunk::<L, G>(stage, place, dissipation);
        self.1.act_on_chunk::<L, G>(stage, place, dissipation);
    }

    #[inline(always)]
    fn is_staged() -> bool {
        A::is_staged() || B::is_staged()
    }
}

/// Energy that viscosity and a dependence on the rate dissipate in a row, over 1/4 l^2 of a horizontal segment.
pub struct Dissipation {
    /// l^2 times the multiplicity of a vertical segment over that of a horizontal one.
    pub share: f64,
    /// Sums by lane, of segments that count once.
    pub by_column: [f64; CHUNK],
    /// Part of rupture beyond the law of the reference rate, with the multiplicity of each segment.
    pub by_rupture: f64,
}

impl Dissipation {
    /// Nothing yet.
    pub const NONE: Dissipation = Dissipation { share: 0.0, by_column: [0.0; CHUNK], by_rupture: 0.0 };

    /// Adds that of lane group g, along x and along y.
    #[inline(always)]
    pub fn add<L: Lane>(&mut self, [along, upwards]: [L; 2], factor: L, g: usize) {
        let more = along.add(upwards.mul(L::splat(self.share))).mul(factor);
        let sums = &mut L::groups_mut(&mut self.by_column)[g];
        L::load(sums).add(more).store(sums);
    }
}

/// What one pass met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// Segments whose alpha became 0.
    pub newly_failed: u64,
    /// A strain beyond [`LOST`], or none at all, was met.
    pub non_finite: bool,
}

impl Report {
    /// A state that cannot be stepped.
    pub(crate) const LOST: Report = Report { newly_failed: 0, non_finite: true };

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

/// Constants of the segments that start in a row.
#[derive(Clone, Copy)]
pub struct YarnRow<'a> {
    /// Stiffness and damage rate.
    pub constants: Constants<'a>,
    /// Chunks of own critical stretches, horizontal and vertical; empty where all have that of the law.
    pub strength: &'a [Chunk<STRENGTH_PLANES>],
}

/// Stiffness and damage rate of a row's segments.
#[derive(Clone, Copy)]
pub enum Constants<'a> {
    /// All of a direction alike.
    Uniform(Along<'a>),
    /// Chunks of [kh, kv, lambda_h, lambda_v].
    Stochastic(&'a [Chunk<YARN_PLANES>]),
}

impl<'a> YarnRow<'a> {
    /// Constants from chunk c on.
    pub fn from(&self, c: usize) -> YarnRow<'a> {
        let constants = match self.constants {
            Constants::Stochastic(row) => Constants::Stochastic(row.get(c..).unwrap_or_default()),
            uniform => uniform,
        };
        YarnRow { constants, strength: self.strength.get(c..).unwrap_or_default() }
    }
}

impl YarnRow<'_> {
    /// Undamaged stiffness and damage rate of the segment that starts at column i; zero stiffness where none exists.
    pub fn constants(&self, axis: Axis, i: usize) -> (f64, f64) {
        match self.constants {
            Constants::Uniform(directions) => {
                let direction = directions.along(axis);
                (direction.stiffness, direction.damage_rate)
            }
            Constants::Stochastic(row) => {
                let at = |plane: usize| planes::get(row, axis as usize + plane, i).unwrap_or(0.0);
                (at(0), at(2))
            }
        }
    }

    /// Critical stretch of that segment. `law`: what all share.
    pub fn critical_stretch(&self, law: &DamageLaw, axis: Axis, i: usize) -> f64 {
        planes::get(self.strength, axis as usize, i).unwrap_or(law.critical_stretch)
    }
}

/// Damage of the segments that start in a row: the cold path.
pub struct Yarns<'a> {
    /// What the segments of a direction have in common.
    pub directions: Along<'a>,
    /// Dependence on the rate of strain.
    pub rates: &'a Rates,
    /// Constants of the segments.
    pub row: YarnRow<'a>,
    /// A row of nodes.
    pub line: Line,
    /// Columns before which horizontal and vertical segments start.
    pub ends: [usize; 2],
    /// What has been met so far.
    pub report: Report,
}

impl Yarns<'_> {
    /// q from which damage is looked for, of horizontal and vertical segments.
    #[inline(always)]
    pub fn limits(&self) -> [f64; 2] {
        let Along { horizontal, vertical, .. } = self.directions;
        if horizontal.rate.depends() { self.rates.limits } else { [horizontal.critical, vertical.critical] }
    }

    /// Damages the segments from a column on of which some q is at or beyond the limit and above all before. `history`, `stiffness`: along x
    /// and along y.
    #[inline(always)]
    pub fn damage_beyond<L: Lane>(
        &mut self,
        q: [L; 2],
        limits: [L; 2],
        column: usize,
        [history_x, history_y]: [&mut L::Group; 2],
        [stiffness_x, stiffness_y]: [&mut L::Group; 2],
    ) {
        if q[0].any_not_below(limits[0]) && q[0].any_above(L::load(history_x)) {
            self.damage(q[0], (Axis::Horizontal, column), [history_x, stiffness_x]);
        }
        if q[1].any_not_below(limits[1]) && q[1].any_above(L::load(history_y)) {
            self.damage(q[1], (Axis::Vertical, column), [history_y, stiffness_y]);
        }
    }

    /// Damages a lane group in which some q is at or beyond the critical one and above all before, or no number.
    #[cold]
    #[inline(never)]
    fn damage<L: Lane>(&mut self, q: L, (axis, first): (Axis, usize), [history, stiffness]: [&mut L::Group; 2]) {
        let (mut strains, end) = (L::ZEROS, self.ends[axis as usize]);
        q.store(&mut strains);
        let slots = history.as_mut().iter_mut().zip(stiffness.as_mut());
        for (lane, (&q, slots)) in strains.as_ref().iter().zip(slots).enumerate() {
            if first + lane < end {
                let met = self.damage_segment(q, axis, first + lane, slots.into());
                self.report.add(met);
            }
        }
    }

    /// Only a new maximum of q changes anything: alpha is a function of the largest q, so the exponential runs only then. The
    /// history of drawn strength begins at the segment's own critical q, so no other test is needed here.
    fn damage_segment(&self, q: f64, axis: Axis, column: usize, [history, stiffness]: [&mut f64; 2]) -> Report {
        let usable = q <= LOST || q <= *history;
        if !usable {
            return Report::LOST;
        }
        let Direction { law, rate, .. } = self.directions.along(axis);
        let q = rate.at(self.rates.time).seen_at(q);
        if !law.is_damaging(q, *history) {
            return Report::default();
        }
        let failed_before = *stiffness == 0.0;
        let (undamaged, damage_rate) = self.row.constants(axis, column);
        let damage = law.at(self.row.critical_stretch(law, axis, column)).damage(damage_rate, q);
        *stiffness = damage.alpha * undamaged;
        // A failed segment never comes here again: no q is above its history.
        *history = damage.history;
        Report { newly_failed: u64::from(damage.alpha == 0.0 && !failed_before), non_finite: false }
    }

    /// Energy that a segment has dissipated when its stiffness has become `stiffness`, in the unit of stiffness.
    #[inline(never)]
    pub fn dissipated(&self, axis: Axis, column: usize, stiffness: f64) -> f64 {
        let law = &self.directions.along(axis).law;
        let (undamaged, damage_rate) = self.row.constants(axis, column);
        // Twice the stiffness stands for the modulus.
        let material = law::Segment { modulus: 2.0 * undamaged, damage_rate };
        law.at(self.row.critical_stretch(law, axis, column)).dissipated(&material, stiffness / undamaged)
    }
}
