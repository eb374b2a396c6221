//! The one hot pass: damage, velocity and position of every node, row by row, in place. Knows nothing of contact.
//!
//! Method: velocity Verlet in staggered form with displacements in units of the spacing h and velocities in h/dt. A segment's
//! force (`segments.rs`) is the change of velocity that it gives its first node. No root and no division below the critical stretch.
//! Each segment is computed once: the horizontal force is carried along the row, the vertical one to the row above.
//! One loop serves all sheets, composed in two ways of the same functions: fused in registers for the paper's sheet, for any without effects
//! and for any with viscosity alone; for all others in stages, a chunk of eight columns at a time, with a buffer between them.
//! Limits: dt <= 0.5 dt_crit (see `parts.rs`).
//! Reference: Powell and Zohdi (2009), equation of motion of the nodes; L. Verlet, Phys. Rev. 159 (1967) 98.

use crate::ground::lanes::{self, InstructionSet, Job, Lane};
use crate::ground::planes::{
    AT_REST, Axis, CARRY_PLANES, CHUNK, Chunk, HISTORY_PLANES, HOT_PLANES, OWED_PLANES, PAST_PLANES,
};
use crate::ground::ranges;
use crate::scene::features::Feature;
use crate::sheet::columns::{At, Bars, Columns, Geometry, Net, Plain, Rests, Table};
use crate::sheet::direction::Along;
use crate::sheet::neighbours::{Around, NOTHING};
use crate::sheet::on_casing::OnCasing;
use crate::sheet::segments::{Dissipation, Effect, Fall, Place, Report, Segments, Stage, YarnRow, Yarns, per_mass};
use crate::sheet::slack::{NOTHING_OWED, SlackBalance, bit};
use crate::sheet::strain_rate::StrainRate;
use crate::sheet::symmetry::Line;
use crate::sheet::viscous::{NO_PAST, Viscous, ViscousRow};
use crate::yarn::rate::Rates;
use core::slice::from_mut;

/// Constants of the pass over a ply.
#[derive(Clone, Copy)]
pub struct Pass<'a> {
    /// A row of nodes.
    pub x: Line,
    /// Horizontal segments in a row.
    pub horizontals: usize,
    /// Vertical segments above a row.
    pub verticals: usize,
    /// What the segments of a direction have in common.
    pub directions: Along<'a>,
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
    /// Its number.
    pub j: usize,
    /// Its hot chunks.
    pub row: &'a mut [Chunk<HOT_PLANES>],
    /// Its history.
    pub history: &'a mut [Chunk<HISTORY_PLANES>],
    /// The row above, empty for the top row.
    pub above: &'a [Chunk<HOT_PLANES>],
    /// The vertical forces from the row below, replaced by those to the row above.
    pub carry: &'a mut [Chunk<CARRY_PLANES>],
    /// Constants of its segments.
    pub yarn: &'a YarnRow<'a>,
    /// Its past; None without viscosity.
    pub viscosity: Option<ViscousRow<'a>>,
    /// Balance of its slack segments; None where none has been slack.
    pub slack: Option<SlackBalance<'a>>,
    /// Case under it; None without.
    pub on_casing: Option<OnCasing<'a>>,
    /// Energy that viscosity and rate dissipate.
    pub dissipation: &'a mut Dissipation,
}

/// All effects, as far as a row has them.
type Effects<'a> = (Option<StrainRate>, (Option<Viscous<'a>>, (Option<SlackBalance<'a>>, Option<OnCasing<'a>>)));

impl Row<'_> {
    /// Steps the row. Returns what was met, and the least and greatest displacement along y.
    #[inline(always)]
    pub fn step(&mut self) -> (Report, [f64; 2]) {
        let pass = self.pass;
        let (set, along, net) = (pass.instructions, pass.directions, &pass.net);
        let left = if Feature::Curved.is_built() && pass.x.closed { self.force_across_the_seam() } else { [0.0; 3] };
        let is_staged = Feature::Rate.is_built() && along.horizontal.rate.depends()
            || Feature::Slack.is_built() && self.slack.is_some()
            || Feature::Casing.is_built() && self.on_casing.is_some();
        let is_flat = net.columns.is_empty() || !(Feature::Grading.is_built() || Feature::Curved.is_built());
        let is_plain = is_flat && (along.plain || !(Feature::Crimp.is_built() || Feature::Unlike.is_built()));
        let viscosity = self.viscosity.take().filter(|_| Feature::Viscosity.is_built());
        match viscosity {
            None if is_plain && !is_staged => lanes::dispatch(set, RowJob(self, left, Plain, ())),
            None if !is_staged => self.step_any(left),
            Some(row) if is_plain && !is_staged => self.step_plain_viscous(left, row),
            Some(row) if is_flat && !is_staged => self.step_viscous(left, row),
            viscosity => self.step_in_stages(left, viscosity),
        }
    }

    /// [`Row::step`] without effects.
    #[inline(never)] // Apart, as the next three: the stack of one must not add to that of another.
    fn step_any(&mut self, left: [f64; 3]) -> (Report, [f64; 2]) {
        let (Pass { instructions, directions, net, .. }, j) = (*self.pass, self.j);
        let alike = Table::alike(&directions.horizontal.rest);
        lanes::dispatch(instructions, RowJob(self, left, Table::of(&net, directions.rests(), j, &alike), ()))
    }

    /// [`Row::step`] of a plain sheet with viscosity alone.
    #[inline(never)]
    fn step_plain_viscous(&mut self, left: [f64; 3], row: ViscousRow<'_>) -> (Report, [f64; 2]) {
        let Pass { instructions, directions, .. } = *self.pass;
        lanes::dispatch(instructions, RowJob(self, left, Plain, row.along(directions)))
    }

    /// [`Row::step`] of a flat sheet with viscosity alone.
    #[inline(never)]
    fn step_viscous(&mut self, left: [f64; 3], row: ViscousRow<'_>) -> (Report, [f64; 2]) {
        let Pass { instructions, directions, .. } = *self.pass;
        lanes::dispatch(instructions, RowJob(self, left, Rests::of(directions.rests()), row.along(directions)))
    }

    /// [`Row::step`] with any effects.
    #[inline(never)]
    fn step_in_stages(&mut self, left: [f64; 3], viscosity: Option<ViscousRow<'_>>) -> (Report, [f64; 2]) {
        let (Pass { instructions, directions, net, rates, .. }, j) = (*self.pass, self.j);
        let alike = Table::alike(&directions.horizontal.rest);
        let viscosity = viscosity.map(|row| row.along(directions));
        let (slack, on_casing) = (self.slack.take(), self.on_casing.take());
        let effects = (StrainRate::of(directions, rates), (viscosity, (slack, on_casing)));
        lanes::dispatch(instructions, RowJob(self, left, Table::of(&net, directions.rests(), j, &alike), effects))
    }

    /// Force of the segment from the last node of a ring to its first, on the last; nothing is committed.
    #[inline(never)]
    fn force_across_the_seam(&self) -> [f64; 3] {
        let (pass, last) = (self.pass, self.pass.verticals.wrapping_sub(1));
        let c = last / CHUNK;
        let alike = Table::alike(&pass.directions.horizontal.rest);
        let mut past = self.viscosity.as_ref().and_then(|row| row.past.get(c).copied());
        let mut owed = self.slack.as_ref().and_then(|slack| slack.owed.get(c).copied());
        let viscosity =
            past.as_mut().map(|past| ViscousRow { past: from_mut(past), above: &[] }.along(pass.directions));
        let slack = self.slack.as_ref().zip(owed.as_mut()).map(|(slack, owed)| slack.with(owed));
        let (j, yarn) = (self.j, self.yarn);
        let geometry = Table::of(&pass.net, pass.directions.rests(), j, &alike);
        let of_row = PeekRow { pass, has_verticals: !self.above.is_empty(), yarn, geometry };
        // After the last node there is an image of the first one.
        let places = Around::of(self.row, self.above, c).zip(self.history.get(c));
        places.map_or([0.0; 3], |(around, history)| {
            let (mut here, mut history) = (*around.here, *history);
            let mut peek = of_row.chunk(c, &mut here, [around.right, around.above], &mut history);
            let [along, _] = peek.forces::<f64>(last % CHUNK, &mut (None, (viscosity, (slack, None))));
            along
        })
    }
}

/// [`Row::step`] as a job for the lanes.
struct RowJob<'r, 'a, G, E>(&'r mut Row<'a>, [f64; 3], G, E);

/// How many chunks a row is fetched ahead: 4 KiB, some 100 ns of work.
const AHEAD: usize = 8;

impl<G: Geometry, E: Effect> Job for RowJob<'_, '_, G, E> {
    type Output = (Report, [f64; 2]);

    #[inline(always)]
    fn run<L: Lane>(mut self) -> (Report, [f64; 2]) {
        // In its place: copies would take stack.
        let RowJob(of_row, left, geometry, effect) = &mut self;
        let Row { pass, above, yarn, .. } = **of_row;
        let (row, history, carry) = (&mut *of_row.row, &mut *of_row.history, &mut *of_row.carry);
        let (dissipation, mut stage) = (&mut *of_row.dissipation, Stage::EMPTY);
        let mut yarns = Yarns {
            directions: pass.directions,
            rates: pass.rates,
            row: *yarn,
            line: pass.x,
            ends: [pass.horizontals, if above.is_empty() { 0 } else { pass.verticals }],
            report: Report::default(),
        };
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
        let mut rest = row;
        let mut with = With { geometry: &*geometry, effect, yarns: &mut yarns, dissipation, stage: &mut stage };
        for (number, (history, carry)) in history.iter_mut().zip(carry).enumerate() {
            let Some((here, tail)) = rest.split_first_mut() else { break };
            let above = above.get(number).unwrap_or(&NOTHING);
            // The pass reads three planes of the row above and leaves out five, which a processor does not take for a stream that
            // it should fetch by itself. All eight are fetched together: the next row needs the other five.
            if fetches {
                lanes::fetch(above, AHEAD);
            }
            // To the right of the last group: the next chunk's first, or zeros of no consequence.
            let right = tail.first().unwrap_or(&NOTHING);
            let columns = geometry.columns(number);
            let mut nodes = Nodes { number, columns, here, right, above, history, carry };
            along.chunk(&mut nodes, &mut with);
            rest = tail;
        }
        (yarns.report, [least(along.low), greatest(along.high)])
    }
}

/// Eight columns of a row.
struct Nodes<'a> {
    /// Number of the chunk.
    number: usize,
    columns: &'a Columns,
    here: &'a mut Chunk<HOT_PLANES>,
    right: &'a Chunk<HOT_PLANES>,
    above: &'a Chunk<HOT_PLANES>,
    history: &'a mut Chunk<HISTORY_PLANES>,
    carry: &'a mut Chunk<CARRY_PLANES>,
}

impl Nodes<'_> {
    #[inline(always)]
    fn around(&self) -> Around<'_> {
        Around { here: self.here, right: self.right, above: self.above }
    }
}

/// What is carried along a row from one lane group to the next: all in registers, so nothing here may be lent to a function
/// that is not inlined.
struct Carried<L> {
    /// q from which damage is looked for, of horizontal and vertical segments.
    limits: [L; 2],
    /// Force of the segments to the left.
    left: [L; 3],
    /// Least and greatest displacement along y.
    low: L,
    high: L,
}

/// What the groups of a chunk are stepped with.
struct With<'w, 'y, G, E> {
    geometry: &'w G,
    effect: &'w mut E,
    yarns: &'w mut Yarns<'y>,
    dissipation: &'w mut Dissipation,
    /// Buffer between stages: in memory, so that what one stage needs takes no register of another.
    stage: &'w mut Stage,
}

impl<L: Lane> Carried<L> {
    /// Steps eight columns.
    #[inline(always)]
    fn chunk<G: Geometry, E: Effect>(&mut self, nodes: &mut Nodes<'_>, with: &mut With<'_, '_, G, E>) {
        if E::is_staged() {
            self.staged(nodes, with);
        } else {
            self.fused(nodes, with);
        }
    }

    /// Steps eight columns in registers. The groups are written out, so that every place in the chunk is a constant. No lane that is run here
    /// has another width.
    #[inline(always)]
    fn fused<G: Geometry, E: Effect>(&mut self, nodes: &mut Nodes<'_>, with: &mut With<'_, '_, G, E>) {
        self.group(nodes, 0, with);
        if L::WIDTH < CHUNK {
            self.group(nodes, 1, with);
        }
        if L::WIDTH < CHUNK / 2 {
            self.group(nodes, 2, with);
            self.group(nodes, 3, with);
        }
    }

    /// Steps eight columns in stages.
    #[inline(always)]
    fn staged<G: Geometry, E: Effect>(&mut self, nodes: &mut Nodes<'_>, with: &mut With<'_, '_, G, E>) {
        self.first_stage(nodes, 0, with);
        if L::WIDTH < CHUNK {
            self.first_stage(nodes, 1, with);
        }
        if L::WIDTH < CHUNK / 2 {
            self.first_stage(nodes, 2, with);
            self.first_stage(nodes, 3, with);
        }
        let Nodes { number: chunk, columns, .. } = *nodes;
        let place = Place { geometry: with.geometry, columns, around: nodes.around(), chunk };
        with.effect.act_on_chunk::<L, G>(with.stage, &place, with.dissipation);
        self.last_stage(nodes, 0, with);
        if L::WIDTH < CHUNK {
            self.last_stage(nodes, 1, with);
        }
        if L::WIDTH < CHUNK / 2 {
            self.last_stage(nodes, 2, with);
            self.last_stage(nodes, 3, with);
        }
    }

    /// A lane group in registers.
    #[inline(always)]
    fn group<G: Geometry, E: Effect>(&mut self, nodes: &mut Nodes<'_>, group: usize, with: &mut With<'_, '_, G, E>) {
        let at = At { chunk: nodes.number, group };
        let bars = with.geometry.bars(nodes.columns, group);
        let mut segments = self.open(nodes, &bars, at, with);
        with.effect.act(&mut segments, &bars, &nodes.around(), at, with.dissipation);
        self.close(nodes, &segments, &bars, at, with.effect);
    }

    /// A lane group before the effects.
    #[inline(always)]
    fn first_stage<G: Geometry, E: Effect>(
        &mut self,
        nodes: &mut Nodes<'_>,
        group: usize,
        with: &mut With<'_, '_, G, E>,
    ) {
        let at = At { chunk: nodes.number, group };
        let segments = self.open(nodes, &with.geometry.bars(nodes.columns, group), at, with);
        with.stage.keep(&segments, group);
    }

    /// A lane group after the effects.
    #[inline(always)]
    fn last_stage<G: Geometry, E: Effect>(
        &mut self,
        nodes: &mut Nodes<'_>,
        group: usize,
        with: &mut With<'_, '_, G, E>,
    ) {
        let at = At { chunk: nodes.number, group };
        self.close(nodes, &with.stage.segments(group), &with.geometry.bars(nodes.columns, group), at, with.effect);
    }

    /// Strain, damage and elastic stress of a lane group.
    #[inline(always)]
    fn open<G: Geometry, E: Effect>(
        &self,
        nodes: &mut Nodes<'_>,
        bars: &Bars<L>,
        at: At,
        With { effect, yarns, dissipation, .. }: &mut With<'_, '_, G, E>,
    ) -> Segments<L> {
        let (g, mut segments) = (at.group, Segments::strained(&nodes.around(), bars, at.group));
        let Segments { q, before, .. } = segments;
        if L::any_not_below_either(q, self.limits) {
            let column = at.chunk * CHUNK + g * L::WIDTH;
            let ([.., kx, ky], [history_x, history_y]) = (&mut *nodes.here, &mut *nodes.history);
            let histories = [&mut L::groups_mut(history_x)[g], &mut L::groups_mut(history_y)[g]];
            let stiffnesses = [&mut L::groups_mut(kx)[g], &mut L::groups_mut(ky)[g]];
            yarns.damage_beyond(q, self.limits, column, histories, stiffnesses);
            let fall = Fall { q, stiffness: [before, nodes.around().stiffness(g)], column };
            effect.note_fall(&fall, yarns, at, dissipation);
        }
        segments.relax(nodes.around().stiffness(g));
        segments
    }

    /// Forces, velocities and positions of a lane group.
    #[inline(always)]
    fn close<E: Effect>(
        &mut self,
        nodes: &mut Nodes<'_>,
        segments: &Segments<L>,
        bars: &Bars<L>,
        at: At,
        effect: &mut E,
    ) {
        let mut forces = segments.forces(bars);
        effect.add_forces(&mut forces, at);
        let ([right, up], g) = (forces, at.group);
        let [cx, cy, cz] = &mut *nodes.carry;
        let (cx, cy, cz) = (&mut L::groups_mut(cx)[g], &mut L::groups_mut(cy)[g], &mut L::groups_mut(cz)[g]);
        let vertical = [hand_on(up[0], cx), hand_on(up[1], cy), hand_on(up[2], cz)];
        let left = [right[0].left_of(self.left[0]), right[1].left_of(self.left[1]), right[2].left_of(self.left[2])];
        self.left = right;
        let widths = bars.inverse_widths;
        let change = [
            per_mass(right[0], left[0], vertical[0], widths),
            per_mass(right[1], left[1], vertical[1], widths),
            per_mass(right[2], left[2], vertical[2], widths),
        ];
        let change = effect.constrain(change, &nodes.around(), at);
        let [ux, uy, uz, vx, vy, vz, ..] = &mut *nodes.here;
        move_along(change[0], &mut L::groups_mut(vx)[g], &mut L::groups_mut(ux)[g]);
        let y = move_along(change[1], &mut L::groups_mut(vy)[g], &mut L::groups_mut(uy)[g]);
        move_along(change[2], &mut L::groups_mut(vz)[g], &mut L::groups_mut(uz)[g]);
        self.low = y.min(self.low);
        self.high = y.max(self.high);
    }
}

/// Eight columns of a row whose forces are asked for while nothing is stepped: with copies of what damage would change.
pub(crate) struct Peek<'a> {
    here: &'a mut Chunk<HOT_PLANES>,
    right: &'a Chunk<HOT_PLANES>,
    above: &'a Chunk<HOT_PLANES>,
    history: &'a mut Chunk<HISTORY_PLANES>,
    columns: &'a Columns,
    geometry: &'a Table<'a>,
    yarns: Yarns<'a>,
}

/// Constants of a row whose forces are asked for.
pub(crate) struct PeekRow<'a> {
    pub pass: &'a Pass<'a>,
    /// Whether segments go upwards from it.
    pub has_verticals: bool,
    /// Constants of its segments.
    pub yarn: &'a YarnRow<'a>,
    /// Its geometry.
    pub geometry: Table<'a>,
}

impl PeekRow<'_> {
    /// Chunk c of the row. `here`, `history`: copies.
    #[inline(always)]
    pub fn chunk<'p>(
        &'p self,
        c: usize,
        here: &'p mut Chunk<HOT_PLANES>,
        [right, above]: [&'p Chunk<HOT_PLANES>; 2],
        history: &'p mut Chunk<HISTORY_PLANES>,
    ) -> Peek<'p> {
        let PeekRow { pass, has_verticals, yarn, geometry } = self;
        let ends = [pass.horizontals, if *has_verticals { pass.verticals } else { 0 }];
        let yarns = Yarns {
            directions: pass.directions,
            rates: pass.rates,
            row: yarn.from(c),
            line: pass.x,
            ends: ends.map(|end| end.saturating_sub(c * CHUNK)),
            report: Report::default(),
        };
        Peek { here, right, above, history, columns: geometry.columns(c), geometry, yarns }
    }
}

impl Peek<'_> {
    /// [`Peek::forces`] of all eight columns, two at a time, into `along` and `up`.
    pub fn all(&mut self, effects: &mut Effects<'_>, along: &mut [[f64; CHUNK]; 3], up: &mut [[f64; CHUNK]; 3]) {
        type Pair = [f64; 2];
        for g in 0..CHUNK / Pair::WIDTH {
            let [x, y] = self.forces::<Pair>(g, effects);
            for ((along, up), (x, y)) in along.iter_mut().zip(up.iter_mut()).zip(x.into_iter().zip(y)) {
                x.store(&mut Pair::groups_mut(along)[g]);
                y.store(&mut Pair::groups_mut(up)[g]);
            }
        }
    }

    /// Whether a state was met that cannot be stepped.
    pub fn is_lost(&self) -> bool {
        self.yarns.report.non_finite
    }

    /// Forces of the segments from lane group g on their first nodes, along x and along y, as the sweep would find them. `effects`: of
    /// copies that begin at the chunk.
    #[inline(always)]
    pub fn forces<L: Lane>(&mut self, group: usize, effects: &mut Effects<'_>) -> [[L; 3]; 2] {
        let (mut carry, mut none) = ([[0.0; CHUNK]; CARRY_PLANES], Dissipation::NONE);
        let Peek { here, right, above, history, columns, geometry, yarns } = self;
        let mut nodes = Nodes { number: 0, columns, here, right, above, history, carry: &mut carry };
        let (at, zero, limits) = (At { chunk: 0, group }, L::splat(0.0), yarns.limits());
        let along =
            Carried { limits: [L::splat(limits[0]), L::splat(limits[1])], left: [zero; 3], low: zero, high: zero };
        let bars = geometry.bars(nodes.columns, group);
        let mut stage = Stage::EMPTY;
        let mut with = With { geometry: *geometry, effect: effects, yarns, dissipation: &mut none, stage: &mut stage };
        let mut segments = along.open(&mut nodes, &bars, at, &mut with);
        with.effect.act(&mut segments, &bars, &nodes.around(), at, with.dissipation);
        let mut forces = segments.forces(&bars);
        with.effect.add_forces(&mut forces, at);
        forces
    }
}

/// Vertical forces of row j, `row`, on the row `above`, as [`Row::step`] would leave them in the carry; nothing is stepped and no damage is
/// committed. For a band that starts at `above`.
pub(crate) struct Lift<'a> {
    pub pass: &'a Pass<'a>,
    pub j: usize,
    pub row: &'a [Chunk<HOT_PLANES>],
    pub history: &'a [Chunk<HISTORY_PLANES>],
    pub above: &'a [Chunk<HOT_PLANES>],
    pub carry: &'a mut [Chunk<CARRY_PLANES>],
    pub yarn: &'a YarnRow<'a>,
    /// Energy errors and stresses of its slack segments, empty where none has been slack along y.
    pub owed: &'a [Chunk<OWED_PLANES>],
    /// What viscosity keeps of both rows, with the moments of this pass; empty without it.
    pub viscous: [&'a [Chunk<PAST_PLANES>]; 2],
}

impl Lift<'_> {
    /// Finds them.
    #[inline(never)]
    pub fn find(self) {
        let Lift { pass, j, row, history, above, carry, yarn, owed, viscous: [past, past_above] } = self;
        let alike = Table::alike(&pass.directions.horizontal.rest);
        let geometry = Table::of(&pass.net, pass.directions.rests(), j, &alike);
        let of_row = PeekRow { pass, has_verticals: true, yarn, geometry };
        // Of all chunks in turn: copies in the loop would take more stack.
        let (mut here, mut history_here) = (NOTHING, [[0.0; CHUNK]; HISTORY_PLANES]);
        let (mut past_here, mut owed_here) = (NO_PAST, NOTHING_OWED);
        let mut along = [[0.0; CHUNK]; 3];
        for (c, (carry, history)) in carry.iter_mut().zip(history).enumerate() {
            let Some(around) = Around::of(row, above, c) else { break };
            let mut effects = (StrainRate::of(pass.directions, pass.rates), (None, (None, None)));
            here.copy_from_slice(around.here);
            history_here.copy_from_slice(history);
            if let Some(past) = past.get(c) {
                past_here.copy_from_slice(past);
                let row = ViscousRow { past: from_mut(&mut past_here), above: past_above.get(c..).unwrap_or_default() };
                effects.1.0 = Some(row.along(pass.directions));
            }
            if let Some(owed) = owed.get(c) {
                owed_here.copy_from_slice(owed);
                effects.1.1.0 = Some(SlackBalance::of(from_mut(&mut owed_here), bit(Axis::Vertical)));
            }
            let mut peek = of_row.chunk(c, &mut here, [around.right, around.above], &mut history_here);
            peek.all(&mut effects, &mut along, carry);
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
