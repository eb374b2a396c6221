//! Segments from displacement to force: the one evaluator of the yarns' forces, for lane groups of the sweep
//! and for single segments.
//!
//! Method: strain and stress by the yarn law (`yarn/law.rs`) with the stiffness
//! kk = alpha E A_0 dt^2/(2 m h l), damage of what is strained beyond all before, then what effects change,
//! then the forces. Sums of forces give the change of velocity of the nodes. Each function is generic over
//! the lanes, over the geometry at rest (`columns.rs`) and over the effects, each in its own file: viscosity
//! (`viscous.rs`), slack balance (`slack.rs`), dependence on the rate (`strain_rate.rs`), case
//! (`on_casing.rs`).
//! Limits: a q that is no number, or beyond any fabric's, is reported, never swallowed.
//! Reference: docs/model.md, "The step".

use crate::ground::lanes::Lane;
use crate::ground::planes::{self, Axis, CHUNK, Chunk, STRENGTH_PLANES, X, YARN_PLANES, vertical_axes};
use crate::sheet::columns::{Bars, Net};
use crate::sheet::direction::{Direction, PlyDirections};
use crate::sheet::neighbours::Around;
use crate::sheet::symmetry::Line;
use crate::yarn::law::{self, DamageLaw, LOST};
use crate::yarn::rate::Rates;

/// Segments of one lane group on their way from displacement to force: along x and along y, side by side, so
/// that a processor has two chains of operations to overlap. (No closures and no array maps: they would not
/// be compiled for the instruction set.)
#[derive(Clone, Copy)]
pub struct Segments<L> {
    /// Relative displacement of the ends in the axes of the sheet, spacings.
    pub d: [[L; 3]; 2],
    /// Twice the strain.
    pub q: [L; 2],
    /// Stiffness before the damage of this step.
    pub before: [L; 2],
    /// Stiffness.
    pub stiffness: [L; 2],
    /// Stress in the unit of stiffness.
    pub stress: [L; 2],
}

impl<L: Lane> Segments<L> {
    /// Strain of the segments from group g; stiffness and stress follow.
    #[inline(always)]
    pub fn strained(around: &Around<'_>, bars: &Bars<'_, L>, g: usize) -> Segments<L> {
        let d = around.differences::<L>(X, g);
        let [along, upwards] = &bars.rests;
        let q = [along.twice_strain(d[0]), upwards.twice_strain(vertical_axes(d[1]))];
        let before = around.stiffness::<L>(g);
        Segments { d, q, before, stiffness: before, stress: q }
    }

    /// Elastic stress, after damage by strains at or beyond `limits`.
    #[inline(always)]
    pub fn settle(
        &mut self,
        limits: [L; 2],
        slots: Slots<'_, L>,
        column: usize,
        yarns: &mut Yarns<'_>,
        effect: &mut impl Effect,
    ) {
        let Slots { histories: [history_x, history_y], stiffnesses: [stiffness_x, stiffness_y] } = slots;
        if L::any_not_below_either(self.q, limits) {
            let slots = [[&mut *history_x, &mut *stiffness_x], [&mut *history_y, &mut *stiffness_y]];
            yarns.damage_beyond(self.q, limits, column, slots);
            effect.note_damage([self.q, self.before], [&*stiffness_x, &*stiffness_y], column, yarns);
        }
        self.relax([L::load(stiffness_x), L::load(stiffness_y)]);
    }

    /// Elastic stress at this stiffness.
    #[inline(always)]
    pub fn relax(&mut self, stiffness: [L; 2]) {
        self.stiffness = stiffness;
        self.stress = [law::stress(stiffness[0], self.q[0]), law::stress(stiffness[1], self.q[1])];
    }

    /// Forces of the segments from group g of a chunk on their first nodes, along x and along y, in the axes
    /// of the sheet, with damage by strains at or beyond `limits`.
    #[inline(always)]
    pub fn evaluate(
        nodes: &mut impl NodeChunk,
        g: usize,
        bars: &Bars<'_, L>,
        limits: [L; 2],
        yarns: &mut Yarns<'_>,
        effect: &mut impl Effect,
    ) -> [[L; 3]; 2] {
        let mut segments = Segments::strained(&nodes.around(), bars, g);
        let column = nodes.number() * CHUNK + g * L::WIDTH;
        segments.settle(limits, nodes.slots(g), column, yarns, effect);
        effect.act(&mut segments, &At { bars, around: nodes.around(), group: g });
        let mut forces = segments.forces(bars);
        effect.add_forces(&mut forces, g);
        forces
    }

    /// Forces on the first nodes, in the axes of the sheet.
    #[inline(always)]
    fn forces(&self, bars: &Bars<'_, L>) -> [[L; 3]; 2] {
        let [along, upwards] = &bars.rests;
        let up = upwards.force(self.stress[1], vertical_axes(self.d[1]));
        [along.force(self.stress[0], self.d[0]), vertical_axes(up)]
    }
}

/// State of the effects on a chunk: the sweep keeps what an effect computes, reading calls drop it.
pub trait StateChunk<const P: usize> {
    /// State before the step, with what damage has added.
    fn get(&self) -> &Chunk<P>;

    /// New numbers of a lane group.
    fn keep<L: Lane>(&mut self, plane: usize, g: usize, new: L);
}

/// State that damage adds to.
pub trait DamagedChunk<const P: usize>: StateChunk<P> {
    /// Adds a number to one of the state while segments are damaged.
    fn add(&mut self, plane: usize, lane: usize, more: f64);
}

/// State that the step changes.
impl<const P: usize> StateChunk<P> for &mut Chunk<P> {
    #[inline(always)]
    fn get(&self) -> &Chunk<P> {
        self
    }

    #[inline(always)]
    fn keep<L: Lane>(&mut self, plane: usize, g: usize, new: L) {
        new.store(&mut L::groups_mut(&mut self[plane])[g]);
    }
}

impl<const P: usize> DamagedChunk<P> for &mut Chunk<P> {
    fn add(&mut self, plane: usize, lane: usize, more: f64) {
        self[plane][lane % CHUNK] += more;
    }
}

/// State that is read.
impl<const P: usize> StateChunk<P> for &Chunk<P> {
    #[inline(always)]
    fn get(&self) -> &Chunk<P> {
        self
    }

    #[inline(always)]
    fn keep<L: Lane>(&mut self, _: usize, _: usize, _: L) {}
}

/// State that is read, and that damage adds to.
pub struct Unchanged<'c, const P: usize> {
    state: &'c Chunk<P>,
    /// State with what damage has added, once it has.
    damaged: Option<Chunk<P>>,
}

impl<'c, const P: usize> Unchanged<'c, P> {
    /// This state.
    #[inline(always)]
    pub fn of(state: &'c Chunk<P>) -> Unchanged<'c, P> {
        Unchanged { state, damaged: None }
    }
}

impl<const P: usize> StateChunk<P> for Unchanged<'_, P> {
    #[inline(always)]
    fn get(&self) -> &Chunk<P> {
        self.damaged.as_ref().unwrap_or(self.state)
    }

    #[inline(always)]
    fn keep<L: Lane>(&mut self, _: usize, _: usize, _: L) {}
}

impl<const P: usize> DamagedChunk<P> for Unchanged<'_, P> {
    fn add(&mut self, plane: usize, lane: usize, more: f64) {
        self.damaged.get_or_insert(*self.state)[plane][lane % CHUNK] += more;
    }
}

/// Eight nodes, from which segments start.
pub trait NodeChunk {
    /// Number of the chunk in its row.
    fn number(&self) -> usize;

    /// The chunk with its neighbours.
    fn around(&self) -> Around<'_>;

    /// Places of what damage changes in lane group g.
    fn slots<L: Lane>(&mut self, g: usize) -> Slots<'_, L>;
}

/// Places of what damage changes in a lane group of segments, along x and along y.
pub struct Slots<'a, L: Lane> {
    /// Largest strains so far.
    pub histories: [&'a mut L::Group; 2],
    /// Stiffnesses.
    pub stiffnesses: [&'a mut L::Group; 2],
}

/// (M22) Change of velocity of nodes by one component of their forces, of which `vertical` is up - down. The
/// order of the sum is exactly mirror-symmetric. `widths`: 1 over those of column and row; None where all are
/// 1.
#[inline(always)]
pub fn per_mass<L: Lane>(right: L, left: L, vertical: L, widths: Option<[L; 2]>) -> L {
    let along = right.sub(left);
    match widths {
        None => along.add(vertical),
        Some([column, row]) => along.mul(column).add(vertical.mul(row)),
    }
}

/// Lane group of segments in which some stiffness has fallen in this step.
pub struct Fall<'a> {
    /// Twice the strain and stiffness before, each along x and along y.
    numbers: [[[f64; CHUNK]; 2]; 2],
    /// Stiffness after, along x and along y.
    now: [&'a [f64]; 2],
    /// Column of the first.
    column: usize,
}

impl<'a> Fall<'a> {
    /// Segments that start from this column on: twice the strain and stiffness before, and stiffness after.
    /// None if no stiffness has fallen.
    #[inline(always)]
    pub fn of<L: Lane>(lanes: [[L; 2]; 2], now: [&'a L::Group; 2], column: usize) -> Option<Fall<'a>> {
        let [_, before] = lanes;
        if !(before[0].any_above(L::load(now[0])) || before[1].any_above(L::load(now[1]))) {
            return None;
        }
        let mut numbers = [[[0.0; CHUNK]; 2]; 2];
        for (numbers, [x, y]) in numbers.iter_mut().zip(lanes) {
            x.store(&mut L::groups_mut(&mut numbers[0])[0]);
            y.store(&mut L::groups_mut(&mut numbers[1])[0]);
        }
        Some(Fall { numbers, now: [now[0].as_ref(), now[1].as_ref()], column })
    }

    /// Shows each segment whose stiffness has fallen to `see`, column by column: its column, axis, twice its
    /// strain, and stiffness before and after.
    #[inline(always)]
    pub fn each(&self, mut see: impl FnMut(usize, Axis, f64, [f64; 2])) {
        let [q, before] = &self.numbers;
        for lane in 0..CHUNK {
            for axis in [Axis::Horizontal, Axis::Vertical] {
                let (k, before) = (axis as usize, before[axis as usize][lane]);
                if let Some(&now) = self.now[k].get(lane).filter(|&&now| now != before) {
                    see(self.column + lane, axis, q[k][lane], [before, now]);
                }
            }
        }
    }
}

/// Place of a lane group of segments.
pub struct At<'a, L> {
    /// Geometry of the segments.
    pub bars: &'a Bars<'a, L>,
    /// Chunk of their nodes, with its neighbours.
    pub around: Around<'a>,
    /// Number of the group in the chunk.
    pub group: usize,
}

/// Effect on a chunk's nodes that is neither elasticity nor damage. Each method does nothing by
/// default.
pub trait Effect {
    /// Changes stiffness and stress of a lane group.
    #[inline(always)]
    fn act<L: Lane>(&mut self, _: &mut Segments<L>, _: &At<'_, L>) {}

    /// Learns of a lane group of segments, from a column on, that may have been damaged: twice the strain and
    /// stiffness before, and stiffness after.
    #[inline(always)]
    fn note_damage<L: Lane>(&mut self, _: [[L; 2]; 2], _now: [&L::Group; 2], _column: usize, _: &Yarns<'_>) {}

    /// Adds to the forces on the first nodes.
    #[inline(always)]
    fn add_forces<L: Lane>(&self, _: &mut [[L; 3]; 2], _group: usize) {}

    /// Change of velocity of nodes that the yarns would change by `change`.
    #[inline(always)]
    fn constrain<L: Lane>(&mut self, change: [L; 3], _: &Around<'_>, _group: usize) -> [L; 3] {
        change
    }
}

/// No effect.
impl Effect for () {}

/// Energy that viscosity and a dependence on the rate dissipate in a row, over 1/4 l^2 of a horizontal
/// segment.
pub struct Dissipation {
    /// l^2 times the multiplicity of a vertical segment over that of a horizontal one.
    pub share: f64,
    /// Sums by lane, of segments that count once but for those of a graded network.
    pub by_column: [f64; CHUNK],
    /// Part of rupture beyond the law of the reference rate, with the multiplicity of each segment.
    pub by_rupture: f64,
}

impl Dissipation {
    /// Zero dissipation.
    pub const NONE: Dissipation = Dissipation { share: 0.0, by_column: [0.0; CHUNK], by_rupture: 0.0 };

    /// Adds that of a lane group, along x and along y.
    #[inline(always)]
    pub fn add<L: Lane>(&mut self, [mut along, mut upwards]: [L; 2], factor: L, place: &At<'_, L>) {
        if let Some(shares) = place.bars.shares {
            let segments: L = shares.segments(Axis::Horizontal);
            (along, upwards) = (along.mul(segments.mul(segments)), upwards.mul(shares.width()));
        }
        let more = along.add(upwards.mul(L::splat(self.share))).mul(factor);
        let sums = &mut L::groups_mut(&mut self.by_column)[place.group];
        L::load(sums).add(more).store(sums);
    }
}

/// Findings of one pass.
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
    Uniform(PlyDirections<'a>),
    /// Chunks of [kh, kv, lambda_h, lambda_v].
    Stochastic(&'a [Chunk<YARN_PLANES>]),
}

impl YarnRow<'_> {
    /// Undamaged stiffness and damage rate of the segment that starts at column i; zero stiffness where none
    /// exists.
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
    /// Constants of the segments of each direction.
    pub directions: &'a PlyDirections<'a>,
    /// Dependence on the rate of strain.
    pub rates: &'a Rates,
    /// Constants of the segments.
    pub row: &'a YarnRow<'a>,
    /// A row of nodes.
    pub line: Line,
    /// Lines of the ply.
    pub net: &'a Net<'a>,
    /// Columns before which horizontal and vertical segments start.
    pub ends: [usize; 2],
    /// Findings so far.
    pub report: Report,
}

impl Yarns<'_> {
    /// q from which damage is looked for, of horizontal and vertical segments.
    #[inline(always)]
    pub fn limits(&self) -> [f64; 2] {
        let PlyDirections { horizontal, vertical, .. } = self.directions;
        if horizontal.rate.depends() { self.rates.limits } else { [horizontal.critical, vertical.critical] }
    }

    /// Damages the segments from a column on of which some q is at or beyond the limit and above all before.
    /// `slots`: their histories and stiffnesses, along x and along y.
    #[inline(always)]
    fn damage_beyond<L: Lane>(
        &mut self,
        q: [L; 2],
        limits: [L; 2],
        column: usize,
        [slots_x, slots_y]: [[&mut L::Group; 2]; 2],
    ) {
        if q[0].any_not_below(limits[0]) && q[0].any_above(L::load(slots_x[0])) {
            self.damage(q[0], (Axis::Horizontal, column), slots_x);
        }
        if q[1].any_not_below(limits[1]) && q[1].any_above(L::load(slots_y[0])) {
            self.damage(q[1], (Axis::Vertical, column), slots_y);
        }
    }

    /// Damages a lane group in which some q is at or beyond the critical one and above all before, or no
    /// number.
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

    /// Only a new maximum of q changes anything: alpha is a function of the largest q, so the exponential
    /// runs only then. The history of drawn strength begins at the segment's own critical q, so no other test
    /// is needed here.
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

    /// Energy that a segment has dissipated when its stiffness has become `stiffness`, in the unit of
    /// stiffness.
    #[inline(never)]
    pub fn dissipated(&self, axis: Axis, column: usize, stiffness: f64) -> f64 {
        let law = &self.directions.along(axis).law;
        let (undamaged, damage_rate) = self.row.constants(axis, column);
        // Twice the stiffness stands for the modulus.
        let material = law::Segment { modulus: 2.0 * undamaged, damage_rate };
        law.at(self.row.critical_stretch(law, axis, column)).dissipated(&material, stiffness / undamaged)
    }
}
