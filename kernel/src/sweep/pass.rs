//! The one hot pass: damage, velocity and position of every node, row by row, in place. Knows nothing of
//! contact.
//!
//! Method: velocity Verlet in staggered form with displacements in units of the spacing h and velocities in
//! h/dt. A segment's force (`segments.rs`) is the change of velocity that it gives its first node. No root
//! and no division below the critical stretch. Each segment is computed once: the horizontal force is carried
//! along the row, the vertical one to the row above. One loop serves all sheets, composed at compile time of
//! a geometry (`columns.rs`) and of effects (`effects.rs`): for the paper's sheet, for flat ones, for any
//! without effects, for flat ones with viscosity alone, and for any with any effects.
//! Limits: dt <= 0.5 dt_crit (see `parts.rs`).
//! Reference: Powell and Zohdi (2009), equation of motion of the nodes; L. Verlet, Phys. Rev. 159 (1967) 98.

use crate::ground::lanes::{self, InstructionSet, Job, Lane};
use crate::ground::planes::{
    AT_REST, Axis, CARRY_PLANES, CHUNK, Chunk, ENERGY_ERROR_PLANES, HISTORY_PLANES, HOT_PLANES, PAST_PLANES,
};
use crate::ground::ranges;
use crate::scene::features::Feature;
use crate::sheet::columns::{Any, Columns, Geometry, Graded, Net, PartlyPlain, Plain, Rests, Table, UNREAD, Widths};
use crate::sheet::direction::PlyDirections;
use crate::sheet::energy_error::{bit, keeps};
use crate::sheet::neighbours::{Around, NOTHING};
use crate::sheet::symmetry::Line;
use crate::sweep::effects::{All, AllOnChunk, EffectState, Effects, ViscosityAlone};
use crate::sweep::segments::{Effect, NodeChunk, Report, Segments, Slots, Unchanged, YarnRow, Yarns, per_mass};
use crate::sweep::slack::SlackChunk;
use crate::sweep::strain_rate::StrainRate;
use crate::sweep::viscous::{self, NO_PAST, ViscousAlong, ViscousChunk};
use crate::yarn::rate::Rates;
use core::marker::PhantomData;

/// Constants of the pass over a ply.
#[derive(Clone, Copy)]
pub struct Pass<'a> {
    /// A row of nodes.
    pub x: Line,
    /// Horizontal segments in a row.
    pub horizontals: usize,
    /// Vertical segments above a row.
    pub verticals: usize,
    /// Constants of the segments of each direction.
    pub directions: PlyDirections<'a>,
    /// Lines of a graded network or a curved sheet.
    pub net: Net<'a>,
    /// Dependence on the rate of strain.
    pub rates: &'a Rates,
    /// Whether rows are fetched from memory ahead of their turn; changes the speed, not the bits.
    pub fetches: bool,
    /// Instruction set; changes the speed, not the bits.
    pub instructions: InstructionSet,
}

/// A row to be stepped.
pub struct Row<'a> {
    /// Constants of the pass.
    pub pass: &'a Pass<'a>,
    /// Number of the row.
    pub j: usize,
    /// Hot chunks of the row.
    pub row: &'a mut [Chunk<HOT_PLANES>],
    /// History of the row.
    pub history: &'a mut [Chunk<HISTORY_PLANES>],
    /// The row above, empty for the top row.
    pub above: &'a [Chunk<HOT_PLANES>],
    /// The vertical forces from the row below, replaced by those to the row above.
    pub carry: &'a mut [Chunk<CARRY_PLANES>],
    /// Constants of its segments.
    pub yarn: &'a YarnRow<'a>,
    /// State of its effects; None where it has none.
    pub effects: Option<EffectState<'a>>,
}

impl Pass<'_> {
    /// Damage of the segments that start in a row. `has_verticals`: whether segments go upwards from it.
    #[inline(always)]
    fn yarns<'y>(&'y self, row: &'y YarnRow<'_>, has_verticals: bool) -> Yarns<'y> {
        let ends = [self.horizontals, if has_verticals { self.verticals } else { 0 }];
        let Pass { x, directions, net, rates, .. } = self;
        Yarns { directions, rates, row, line: *x, net, ends, report: Report::default() }
    }
}

impl<'a> Row<'a> {
    /// Steps the row. Returns what was met, and the least and greatest displacement along y.
    #[inline(always)] // In its place: a copy of the row would be read before its stores are done, 20 ns.
    pub fn step(&mut self) -> (Report, [f64; 2]) {
        let Pass { directions, net, instructions, .. } = self.pass;
        let is_flat = net.is_flat();
        let is_graded = Feature::Grading.is_built() && !net.lines.is_empty();
        let is_plain = is_flat && (directions.plain || !(Feature::Crimp.is_built() || Feature::Unlike.is_built()));
        let (is_viscous, others) = self.effects.as_ref().map_or((false, false), |state| {
            let others = directions.horizontal.rate.depends() || state.slack.is_some() || state.on_casing.is_some();
            (state.viscosity.is_some(), others)
        });
        match is_viscous {
            false if is_plain && !others => self.with::<Plain, ()>([0.0; 3]),
            _ if is_graded && (others || instructions.is_slow()) => self.with::<Graded<'_>, All<'_>>([0.0; 3]),
            _ if others || instructions.is_slow() => self.with::<Table<'_>, All<'_>>(self.force_across_the_seam()),
            false if is_flat => self.with::<Rests, ()>([0.0; 3]),
            false if is_graded && directions.plain => self.with::<PartlyPlain<'_>, ()>([0.0; 3]),
            false => self.with::<Table<'_>, ()>(self.force_across_the_seam()),
            true if is_plain => self.with::<Plain, ViscosityAlone<'_>>([0.0; 3]),
            true if is_flat => self.with::<Rests, ViscosityAlone<'_>>([0.0; 3]),
            true if is_graded => self.with::<Graded<'_>, ViscosityAlone<'_>>([0.0; 3]),
            true => self.with::<Table<'_>, All<'_>>(self.force_across_the_seam()),
        }
    }

    /// Steps it with this geometry and these effects.
    #[inline(always)]
    fn with<G: Geometry<'a>, E: Effects<'a>>(&mut self, left: [f64; 3]) -> (Report, [f64; 2]) {
        lanes::dispatch(self.pass.instructions, RowJob::<G, E>(self, left, PhantomData))
    }

    /// Force of the segment from the last node of a ring to its first, on the last; nothing is committed. 0
    /// of an open row.
    #[inline(always)]
    fn force_across_the_seam(&self) -> [f64; 3] {
        if Feature::Curved.is_built() && self.pass.x.closed { self.read_across_the_seam() } else { [0.0; 3] }
    }

    fn read_across_the_seam(&self) -> [f64; 3] {
        let Row { pass, j, row, history, above, yarn, effects, .. } = self;
        let last = pass.verticals.wrapping_sub(1);
        let c = last / CHUNK;
        // After the last node there is an image of the first one.
        let Some((around, history)) = Around::of(row, above, c).zip(history.get(c)) else { return [0.0; 3] };
        let mut forces = RowForces::of(pass, *j, yarn, false);
        let Some(EffectState { viscosity, slack, .. }) = effects else {
            return forces.of_node(&around, history, last, &mut ())[0];
        };
        let past = viscosity.as_ref().and_then(|viscosity| viscosity.past.get(c));
        let state = ChunkState {
            past: past.map(|past| [past, &NO_PAST, &NO_PAST]),
            energy_error: slack.as_ref().and_then(|slack| Some((slack.energy_error.get(c)?, slack.keeps))),
        };
        forces.of_node(&around, history, last, &mut RowEffects::of(pass).on_chunk(state))[0]
    }
}

/// [`Row::step`] as a job for the lanes, with the force of the segment before the first node.
struct RowJob<'r, 'a, G, E>(&'r mut Row<'a>, [f64; 3], PhantomData<(G, E)>);

/// Chunks that a row is fetched ahead: 4 KiB, some 100 ns of work.
const AHEAD: usize = 8;

impl<'a, G: Geometry<'a>, E: Effects<'a>> Job for RowJob<'_, 'a, G, E> {
    type Output = (Report, [f64; 2]);

    #[inline(always)]
    fn run<L: Lane>(self) -> (Report, [f64; 2]) {
        let RowJob(Row { pass, j, row, history, above, carry, yarn, effects }, left, _) = self;
        let (above, yarn) = (*above, *yarn);
        let Some(mut effects) = E::of(effects, pass.directions, pass.rates) else { return (Report::LOST, [0.0; 2]) };
        let geometry = G::of(&pass.net, pass.directions.rests(), *j);
        let (geometry, effects) = (geometry.in_memory(), effects.in_memory());
        let mut yarns = pass.yarns(yarn, !above.is_empty());
        let (zero, limits) = (L::splat(0.0), G::both(yarns.limits()));
        let mut along = Carried::<L> {
            limits: [L::splat(limits[0]), L::splat(limits[1])],
            left: [L::splat(left[0]), L::splat(left[1]), L::splat(left[2])],
            low: zero,
            high: zero,
        };
        // All as long as the row, so that one test in the loop is enough.
        let (chunks, fetches) = (row.len(), pass.fetches && Feature::Blocks.is_built());
        let (Some(history), Some(carry)) = (history.get_mut(..chunks), carry.get_mut(..chunks)) else {
            return (Report::LOST, [0.0; 2]);
        };
        let mut rest = &mut **row;
        for (number, (history, carry)) in history.iter_mut().zip(carry).enumerate() {
            let Some((here, tail)) = rest.split_first_mut() else { break };
            let above = above.get(number).unwrap_or(&NOTHING);
            // The pass reads three planes of the row above and leaves out five, which a processor does not
            // take for a stream that it should fetch by itself. All eight are fetched together: the next row
            // needs the other five.
            if fetches {
                lanes::fetch(above, AHEAD);
            }
            // To the right of the last group: the next chunk's first, or zeros of no consequence.
            let right = tail.first().unwrap_or(&NOTHING);
            let Some(mut effect) = effects.on_chunk(number) else { return (Report::LOST, [0.0; 2]) };
            let mut nodes = Nodes { number, columns: UNREAD, here, right, above, history, carry };
            if geometry.is_plain(number) {
                lanes::each_group!(L, |g| along.group(&mut nodes, g, &Plain, &mut effect, &mut yarns));
            } else {
                nodes.columns = geometry.columns(number);
                lanes::each_group!(L, |g| along.group(&mut nodes, g, geometry, &mut effect, &mut yarns));
            }
            rest = tail;
        }
        (yarns.report, [least(along.low), greatest(along.high)])
    }
}

/// Eight columns of a row.
struct Nodes<'a> {
    /// Number of the chunk.
    number: usize,
    columns: Columns<'a>,
    here: &'a mut Chunk<HOT_PLANES>,
    right: &'a Chunk<HOT_PLANES>,
    above: &'a Chunk<HOT_PLANES>,
    history: &'a mut Chunk<HISTORY_PLANES>,
    carry: &'a mut Chunk<CARRY_PLANES>,
}

impl NodeChunk for Nodes<'_> {
    #[inline(always)]
    fn number(&self) -> usize {
        self.number
    }

    #[inline(always)]
    fn around(&self) -> Around<'_> {
        Around { here: self.here, right: self.right, above: self.above }
    }

    #[inline(always)]
    fn slots<L: Lane>(&mut self, g: usize) -> Slots<'_, L> {
        let ([.., kx, ky], [history_x, history_y]) = (&mut *self.here, &mut *self.history);
        Slots {
            histories: [&mut L::groups_mut(history_x)[g], &mut L::groups_mut(history_y)[g]],
            stiffnesses: [&mut L::groups_mut(kx)[g], &mut L::groups_mut(ky)[g]],
        }
    }
}

/// Numbers carried along a row from one lane group to the next: all in registers, so nothing here may be lent
/// to a function that is not inlined.
struct Carried<L> {
    /// q from which damage is looked for, of horizontal and vertical segments.
    limits: [L; 2],
    /// Force of the segments to the left.
    left: [L; 3],
    /// Least and greatest displacement along y.
    low: L,
    high: L,
}

impl<L: Lane> Carried<L> {
    /// Steps a lane group.
    #[inline(always)]
    fn group<'a, G: Geometry<'a>>(
        &mut self,
        nodes: &mut Nodes<'_>,
        g: usize,
        geometry: &G,
        effect: &mut impl Effect,
        yarns: &mut Yarns<'_>,
    ) {
        let bars = geometry.bars(nodes.columns, g);
        let forces = Segments::evaluate(nodes, g, &bars, self.limits, yarns, effect);
        self.advance(nodes, forces, bars.widths, g, effect);
    }

    /// Velocities and positions of a lane group.
    #[inline(always)]
    fn advance(
        &mut self,
        nodes: &mut Nodes<'_>,
        [right, up]: [[L; 3]; 2],
        widths: Option<Widths<'_>>,
        g: usize,
        effect: &mut impl Effect,
    ) {
        let [cx, cy, cz] = &mut *nodes.carry;
        let (cx, cy, cz) = (&mut L::groups_mut(cx)[g], &mut L::groups_mut(cy)[g], &mut L::groups_mut(cz)[g]);
        let vertical = [hand_on(up[0], cx), hand_on(up[1], cy), hand_on(up[2], cz)];
        let left = [right[0].left_of(self.left[0]), right[1].left_of(self.left[1]), right[2].left_of(self.left[2])];
        self.left = right;
        let widths = Widths::inverse(widths);
        let change = [
            per_mass(right[0], left[0], vertical[0], widths),
            per_mass(right[1], left[1], vertical[1], widths),
            per_mass(right[2], left[2], vertical[2], widths),
        ];
        let change = effect.constrain(change, &nodes.around(), g);
        let [ux, uy, uz, vx, vy, vz, ..] = &mut *nodes.here;
        move_along(change[0], &mut L::groups_mut(vx)[g], &mut L::groups_mut(ux)[g]);
        let y = move_along(change[1], &mut L::groups_mut(vy)[g], &mut L::groups_mut(uy)[g]);
        move_along(change[2], &mut L::groups_mut(vz)[g], &mut L::groups_mut(uz)[g]);
        self.low = y.min(self.low);
        self.high = y.max(self.high);
    }
}

/// State of the effects on a chunk that is read.
#[derive(Clone, Copy)]
pub(crate) struct ChunkState<'a> {
    /// Past of the chunk, of the next one and of the one above; None without viscosity.
    pub past: Option<[&'a Chunk<PAST_PLANES>; 3]>,
    /// Energy errors of slack segments, and 1 along each axis in which segments keep them; None without any.
    pub energy_error: Option<(&'a Chunk<ENERGY_ERROR_PLANES>, [f64; 2])>,
}

/// [`All`] of a chunk whose state stays as it is.
type EffectsOnRead<'c> = AllOnChunk<'c, &'c Chunk<PAST_PLANES>, Unchanged<'c, ENERGY_ERROR_PLANES>>;

/// Constants of the effects on a row that is read.
pub(crate) struct RowEffects<'a> {
    rate: Option<StrainRate<'a>>,
    viscosity: ViscousAlong,
}

impl<'a> RowEffects<'a> {
    /// Constants of a pass.
    #[inline(always)]
    pub fn of(pass: &'a Pass<'_>) -> RowEffects<'a> {
        let Pass { directions, rates, .. } = pass;
        RowEffects {
            rate: StrainRate::of(*directions, rates).filter(|_| Feature::Rate.is_built()),
            viscosity: viscous::along(*directions),
        }
    }

    /// Effects on a chunk with this state, which stays as it is.
    #[inline(always)]
    pub fn on_chunk<'c>(&'c self, state: ChunkState<'c>) -> EffectsOnRead<'c> {
        let constants = &self.viscosity;
        let viscous = |[past, next, above]: [&'c _; 3]| ViscousChunk { constants, past, next, above };
        let slack = |(state, keeps)| SlackChunk { energy_error: Unchanged::of(state), keeps };
        AllOnChunk {
            rate: self.rate.as_ref(),
            viscosity: state.past.map(viscous),
            slack: state.energy_error.map(slack),
            on_casing: None,
            dissipation: None,
        }
    }
}

/// Eight columns of a row that is read.
struct ReadNodes<'a> {
    number: usize,
    around: Around<'a>,
    /// Histories and stiffnesses with the damage of this step, along x and along y each.
    damaged: [[f64; CHUNK]; 4],
}

impl<'a> ReadNodes<'a> {
    #[inline(always)]
    fn of(number: usize, around: &Around<'a>, [history_x, history_y]: &Chunk<HISTORY_PLANES>) -> ReadNodes<'a> {
        let [.., kx, ky] = around.here;
        ReadNodes { number, around: *around, damaged: [*history_x, *history_y, *kx, *ky] }
    }

    /// Forces of the segments from lane group g on their first nodes, along x and along y.
    #[inline(always)]
    fn forces<L: Lane>(
        &mut self,
        g: usize,
        geometry: &Any<'_>,
        yarns: &mut Yarns<'_>,
        effect: &mut impl Effect,
    ) -> [[L; 3]; 2] {
        let (bars, limits) = (geometry.bars::<L>(geometry.columns(self.number), g), yarns.limits());
        Segments::evaluate(self, g, &bars, [L::splat(limits[0]), L::splat(limits[1])], yarns, effect)
    }
}

impl NodeChunk for ReadNodes<'_> {
    #[inline(always)]
    fn number(&self) -> usize {
        self.number
    }

    #[inline(always)]
    fn around(&self) -> Around<'_> {
        self.around
    }

    #[inline(always)]
    fn slots<L: Lane>(&mut self, g: usize) -> Slots<'_, L> {
        let [history_x, history_y, kx, ky] = &mut self.damaged;
        Slots {
            histories: [&mut L::groups_mut(history_x)[g], &mut L::groups_mut(history_y)[g]],
            stiffnesses: [&mut L::groups_mut(kx)[g], &mut L::groups_mut(ky)[g]],
        }
    }
}

/// Vertical forces of row j, `row`, on the row `above`, as [`Row::step`] would leave them in the carry;
/// nothing is stepped or kept. For a band that starts at `above`.
pub(crate) struct ForcesFromBelow<'a> {
    pub pass: &'a Pass<'a>,
    pub j: usize,
    pub row: &'a [Chunk<HOT_PLANES>],
    pub history: &'a [Chunk<HISTORY_PLANES>],
    pub above: &'a [Chunk<HOT_PLANES>],
    pub carry: &'a mut [Chunk<CARRY_PLANES>],
    pub yarn: &'a YarnRow<'a>,
    /// Energy errors and stresses of its slack segments, empty where none has been slack along y.
    pub energy_error: &'a [Chunk<ENERGY_ERROR_PLANES>],
    /// Past of viscosity of both rows, with the moments of this step; empty without it.
    pub viscous: [&'a [Chunk<PAST_PLANES>]; 2],
}

impl ForcesFromBelow<'_> {
    /// Finds them.
    pub fn find(self) {
        let ForcesFromBelow { pass, j, row, history, above, carry, yarn, energy_error, viscous } = self;
        let ([past, past_above], mut along) = (viscous, [[0.0; CHUNK]; 3]);
        let (mut forces, effects) = (RowForces::of(pass, j, yarn, true), RowEffects::of(pass));
        for (c, (carry, history)) in carry.iter_mut().zip(history).enumerate() {
            let Some(around) = Around::of(row, above, c) else { break };
            let state = ChunkState {
                past: past.get(c).map(|past| [past, &NO_PAST, past_above.get(c).unwrap_or(&NO_PAST)]),
                energy_error: energy_error.get(c).map(|energy_error| (energy_error, keeps(bit(Axis::Vertical)))),
            };
            forces.all(c, &around, history, &mut effects.on_chunk(state), [&mut along, carry]);
        }
    }
}

/// Forces of the segments of a row as the sweep would find them: nothing is stepped, no damage and no state
/// of an effect is kept.
pub(crate) struct RowForces<'a> {
    geometry: Any<'a>,
    yarns: Yarns<'a>,
}

impl<'a> RowForces<'a> {
    /// Forces of row j. `has_verticals`: whether segments go upwards from it.
    #[inline(always)]
    pub fn of(pass: &'a Pass<'_>, j: usize, yarn: &'a YarnRow<'_>, has_verticals: bool) -> RowForces<'a> {
        RowForces { geometry: Any::of(&pass.net, pass.directions.rests(), j), yarns: pass.yarns(yarn, has_verticals) }
    }

    /// Whether a state was met that cannot be stepped.
    pub fn is_lost(&self) -> bool {
        self.yarns.report.non_finite
    }

    /// Forces of the segments from the node of column i on it, along x and along y.
    #[inline(always)]
    pub fn of_node(
        &mut self,
        around: &Around<'_>,
        history: &Chunk<HISTORY_PLANES>,
        i: usize,
        effect: &mut impl Effect,
    ) -> [[f64; 3]; 2] {
        ReadNodes::of(i / CHUNK, around, history).forces(i % CHUNK, &self.geometry, &mut self.yarns, effect)
    }

    /// Forces of all segments from chunk c, two at a time, into `along` and `up`.
    pub fn all(
        &mut self,
        c: usize,
        around: &Around<'_>,
        history: &Chunk<HISTORY_PLANES>,
        effect: &mut impl Effect,
        [along, up]: [&mut [[f64; CHUNK]; 3]; 2],
    ) {
        type Pair = [f64; 2];
        let mut nodes = ReadNodes::of(c, around, history);
        for g in 0..CHUNK / Pair::WIDTH {
            let [x, y] = nodes.forces::<Pair>(g, &self.geometry, &mut self.yarns, effect);
            for ((along, up), (x, y)) in along.iter_mut().zip(up.iter_mut()).zip(x.into_iter().zip(y)) {
                x.store(&mut Pair::groups_mut(along)[g]);
                y.store(&mut Pair::groups_mut(up)[g]);
            }
        }
    }
}

/// up - down: the vertical part of a node's sum. Leaves `up` in the carry, as what the row above calls down.
#[inline(always)]
fn hand_on<L: Lane>(up: L, carry: &mut L::Group) -> L {
    let vertical = up.sub(L::load(carry));
    up.store(carry);
    vertical
}

/// (M7) v <- v + a, u <- u + v along one axis. Returns the new u.
#[inline(always)]
fn move_along<L: Lane>(change: L, v: &mut L::Group, u: &mut L::Group) -> L {
    let velocity = L::load(v).add(change).or_zero_below(L::splat(AT_REST));
    velocity.store(v);
    let moved = L::load(u).add(velocity);
    moved.store(u);
    moved
}

/// Smallest number of a lane group, or 0.
#[inline(always)]
fn least<L: Lane>(lanes: L) -> f64 {
    let mut group = L::ZEROS;
    lanes.store(&mut group);
    ranges::least(group.as_mut())
}

/// Greatest number of a lane group, or 0.
#[inline(always)]
pub(crate) fn greatest<L: Lane>(lanes: L) -> f64 {
    let mut group = L::ZEROS;
    lanes.store(&mut group);
    ranges::greatest(group.as_mut())
}
