//! The one hot pass: damage, velocity and position of every node, row by row, in place. Knows nothing of contact.
//!
//! Method: velocity Verlet in staggered form with displacements in units of the spacing h and velocities in h/dt. A segment's
//! force by the yarn law (`yarn/law.rs`), with the stiffness kk = alpha E A_0 dt^2 / (2 m h l), is the change of velocity that it
//! gives its first node. No root and no division below the critical stretch.
//! Each segment is computed once: the horizontal force is carried along the row, the vertical one to the row above.
//! Order of one node's sum: (right - left) + (up - down), exactly mirror-symmetric.
//! What slack segments owe (`slack.rs`) and a dependence on the rate (`rate.rs`) have paths of their own, compiled apart; so
//! has a fabric that is not plain (`direction.rs`): directions unlike each other, crimp or pre-tension; and a graded network
//! (`grading.rs`), whose bars and nodes differ by column and row, and a curved sheet (`ring.rs`).
//! Limits: dt <= 0.5 dt_crit (see `parts.rs`). A q that is no number, or beyond any fabric's, is reported, never swallowed.
//! Reference: Powell and Zohdi (2009), equation of motion of the nodes; L. Verlet, Phys. Rev. 159 (1967) 98.

use crate::ground::lanes::{self, InstructionSet, Job, Lane};
use crate::ground::planes::{
    self, AT_REST, Axis, CARRY_PLANES, CHUNK, Chunk, HISTORY_PLANES, HOT_PLANES, OWED_PLANES, PAST_PLANES,
    STRENGTH_PLANES, YARN_PLANES, vertical_axes,
};
use crate::ground::ranges;
use crate::scene::features::Feature;
use crate::sheet::casing::Cylinder;
use crate::sheet::direction::{Along, Direction};
use crate::sheet::grading::{self, INVERSE_WIDTH, LINE_PLANES, Net, NetRow};
use crate::sheet::neighbours::{NOTHING, right_less};
use crate::sheet::ring::{self, CHORD_X, CHORD_Z, HOOP_PLANES, PLACE_X, PLACE_Z};
use crate::sheet::slack::{NOTHING_OWED, Owed, bit, relative_velocities};
use crate::sheet::symmetry::Line;
use crate::sheet::viscous::{NO_PAST, Past, ViscousRow, bending_forces};
use crate::yarn::law::{self, DamageLaw, LOST, RestLanes, ViscosityLanes};
use crate::yarn::rate::{RateLanes, RateLaw, Rates};

/// What one pass met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// Segments whose alpha became 0.
    pub newly_failed: u64,
    /// A strain beyond [`LOST`], or none at all, was met.
    pub non_finite: bool,
}

/// Where a row's segments find their constants.
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

    /// The critical stretch of that segment. `law`: what all share.
    pub fn critical_stretch(&self, law: &DamageLaw, axis: Axis, i: usize) -> f64 {
        planes::get(self.strength, axis as usize, i).unwrap_or(law.critical_stretch)
    }
}

/// Constants of the pass.
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
    /// Bars and widths of a graded network.
    pub net: &'a Net<'a>,
    /// Dependence on the rate of strain.
    pub rates: &'a Rates,
    /// Whether rows are fetched from memory ahead of their turn; changes the speed, not the bits.
    pub fetches: bool,
    /// Instruction set; changes the speed, not the bits.
    pub instructions: InstructionSet,
}

/// Sum of a node's four forces, in the order that everything keeps.
#[inline(always)]
pub fn node_sum<L: Lane>(right: L, left: L, up: L, down: L) -> L {
    with_vertical(right, left, up.sub(down))
}

/// (M22) Sum of the forces of a graded network's node over its mass: `inverse_widths` of its column and its row.
#[inline(always)]
pub fn graded_sum<L: Lane>(right: L, left: L, up: L, down: L, inverse_widths: [L; 2]) -> L {
    graded_with_vertical(right, left, up.sub(down), inverse_widths)
}

/// The same where up - down is known.
#[inline(always)]
fn graded_with_vertical<L: Lane>(right: L, left: L, vertical: L, [column, row]: [L; 2]) -> L {
    right.sub(left).mul(column).add(vertical.mul(row))
}

/// [`node_sum`] where up - down is known.
#[inline(always)]
fn with_vertical<L: Lane>(right: L, left: L, vertical: L) -> L {
    right.sub(left).add(vertical)
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
    /// What its slack segments owe; empty where none has been slack.
    pub owed: &'a mut [Chunk<OWED_PLANES>],
    /// Bits of the directions in which they have been.
    pub been_slack: u32,
    /// What viscosity keeps of it; None without.
    pub viscous: Option<ViscousRow<'a>>,
    /// Counts what viscosity and rate take; None without both.
    pub taken: Option<&'a mut Taken>,
}

/// What viscosity and rate take of the segments of a row, over 1/4 l^2 of a horizontal one.
pub struct Taken {
    /// What of a vertical segment counts, over that of a horizontal one.
    pub share: f64,
    /// By columns, as if each were in the sheet once.
    pub by_column: [f64; CHUNK],
    /// By rupture beyond the law of the reference rate, of each segment as often as it is in the sheet.
    pub by_rupture: f64,
}

impl Taken {
    /// Nothing.
    pub const NONE: Taken = Taken { share: 0.0, by_column: [0.0; CHUNK], by_rupture: 0.0 };
}

/// [`Row::step`] as a job for the lanes. PLAIN: [`Directions::plain`], without grading; GRADED: with it; FACTOR: what else acts on the
/// stresses; FETCH: whether it asks for [`Pass::fetches`]; VISCOUS: with viscosity; CURVED: of a curved sheet; CASING: of a ring on a case.
struct RowJob<
    'a,
    'j,
    const PLAIN: bool,
    const GRADED: bool,
    const FACTOR: u8,
    const FETCH: bool = true,
    const VISCOUS: bool = false,
    const CURVED: bool = false,
    const CASING: bool = false,
>(Row<'a>, Joint<'j>);

/// A row on a case.
pub struct OnCasing<'a> {
    /// The case.
    pub case: &'a Cylinder,
    /// Its rest place along y, spacings.
    pub place_y: f64,
    /// Sums over the columns of a chunk: the case's push along x and z, and the energy that it takes.
    pub pushed: &'a mut [[f64; CHUNK]; 3],
    /// Receives the push on each of its nodes, and may be longer.
    pub pushes: &'a mut [[f64; CHUNK]],
}

/// What a curved row has besides.
struct Joint<'a> {
    /// Force of the segment before the first node.
    left: [f64; 3],
    on_casing: Option<&'a mut OnCasing<'a>>,
}

impl Joint<'_> {
    /// Of a flat sheet.
    const NONE: Joint<'static> = Joint { left: [0.0; 3], on_casing: None };
}

/// Nothing.
const NONE: u8 = 0;
/// What slack segments owe.
const SLACK: u8 = 1;
/// The factor of the rate on the stiffnesses.
const RATE: u8 = 2;

/// How many chunks a row is fetched ahead: 4 KiB, some 100 ns of work.
const AHEAD: usize = 8;

/// Columns of no grading.
const NO_GRADING: Chunk<LINE_PLANES> = [[1.0; CHUNK]; LINE_PLANES];

impl Row<'_> {
    /// Steps the row. OPTIONS: whether it may have rate, slack or grading. Returns what was met, and the least and greatest y displacement.
    #[inline(always)] // A copy of the row would be read before its stores are done: 20 ns.
    pub fn step<const OPTIONS: bool, const VISCOUS: bool>(self) -> (Report, [f64; 2]) {
        let set = self.pass.instructions;
        // What is not built has no path.
        let plain = self.pass.directions.plain || !(Feature::Crimp.is_built() || Feature::Unlike.is_built());
        let ungraded = !OPTIONS || self.pass.net.columns.is_empty() || !Feature::Grading.is_built();
        let unmarked = !OPTIONS || self.owed.is_empty() || !Feature::Slack.is_built();
        let dependent = OPTIONS && Feature::Rate.is_built() && self.pass.directions.horizontal.rate.depends();
        if VISCOUS {
            // Viscosity excludes grading.
            return match (plain, unmarked) {
                _ if dependent => {
                    lanes::dispatch_narrow(set, RowJob::<false, false, RATE, true, true>(self, Joint::NONE))
                }
                (_, false) => lanes::dispatch_narrow(set, RowJob::<false, false, SLACK, true, true>(self, Joint::NONE)),
                (true, true) => lanes::dispatch(set, RowJob::<true, false, NONE, true, true>(self, Joint::NONE)),
                (false, true) => {
                    lanes::dispatch_narrow(set, RowJob::<false, false, NONE, true, true>(self, Joint::NONE))
                }
            };
        }
        // A dependence on the rate excludes both.
        match (plain, ungraded, unmarked) {
            (true, ..) if dependent => lanes::dispatch_narrow(set, RowJob::<true, false, RATE>(self, Joint::NONE)),
            _ if dependent => lanes::dispatch_narrow(set, RowJob::<false, false, RATE>(self, Joint::NONE)),
            // The commonest path is compiled apart for sheets that lie in the caches.
            (true, true, true) if !(self.pass.fetches && Feature::Blocks.is_built()) => {
                lanes::dispatch(set, RowJob::<true, false, NONE, false>(self, Joint::NONE))
            }
            (true, true, true) => lanes::dispatch(set, RowJob::<true, false, NONE>(self, Joint::NONE)),
            (false, true, true) => lanes::dispatch(set, RowJob::<false, false, NONE>(self, Joint::NONE)),
            (_, true, false) => lanes::dispatch_narrow(set, RowJob::<false, false, SLACK>(self, Joint::NONE)),
            (_, false, true) => lanes::dispatch(set, RowJob::<false, true, NONE>(self, Joint::NONE)),
            (_, false, false) => lanes::dispatch_narrow(set, RowJob::<false, true, SLACK>(self, Joint::NONE)),
        }
    }

    /// [`Row::step`] of a curved sheet. A curve excludes a dependence on the rate and grading.
    #[inline(always)] // As above.
    pub fn step_curved<'c>(self, on_casing: Option<&'c mut OnCasing<'c>>) -> (Report, [f64; 2]) {
        let (set, left) = (self.pass.instructions, self.force_across_the_joint());
        let joint = Joint { left, on_casing };
        if Feature::Slack.is_built() && !self.owed.is_empty() {
            // Two at a time take little stack.
            let set = InstructionSet::Sse2;
            return if self.viscous.is_some() {
                lanes::dispatch(set, RowJob::<false, false, SLACK, true, true, true, true>(self, joint))
            } else {
                lanes::dispatch(set, RowJob::<false, false, SLACK, true, false, true, true>(self, joint))
            };
        }
        if self.viscous.is_some() {
            return lanes::dispatch_narrow(set, RowJob::<false, false, NONE, true, true, true, true>(self, joint));
        }
        if joint.on_casing.is_some() {
            return lanes::dispatch_narrow(set, RowJob::<false, false, NONE, true, false, true, true>(self, joint));
        }
        if self.pass.directions.plain {
            lanes::dispatch(set, RowJob::<true, false, NONE, true, false, true>(self, joint))
        } else {
            lanes::dispatch_narrow(set, RowJob::<false, false, NONE, true, false, true>(self, joint))
        }
    }

    /// The force of the segment from the last node of a ring to its first, on the last; nothing is committed. 0 of an open row.
    #[inline(never)]
    fn force_across_the_joint(&self) -> [f64; 3] {
        let Row { pass, row, history, yarn, owed, been_slack, viscous, .. } = self;
        // Only in a ring a segment begins at the last node.
        let last = pass.verticals.wrapping_sub(1);
        let places = (row.first(), row.get(last / CHUNK), history.get(last / CHUNK), pass.net.hoop.get(last / CHUNK));
        let (true, (Some(first), Some(chunk), Some([largest, _]), Some(hoop))) =
            (pass.horizontals == pass.verticals, places)
        else {
            return [0.0; 3];
        };
        let lane = last % CHUNK;
        let ([a, b, c], [x, y, z]) = (planes::displacement(first, 0), planes::displacement(chunk, lane));
        let (d, chord) = ([a - x, b - y, c - z], [hoop[CHORD_X][lane], hoop[CHORD_Z][lane]]);
        let rest = pass.directions.around().lanes();
        let q = if pass.directions.plain {
            ring::twice_strain(d, chord)
        } else {
            ring::general_twice_strain(d, chord, &rest)
        };
        let (mut largest, before, mut stiffness) = (largest[lane], chunk[6][lane], chunk[6][lane]);
        pass.damage_segment::<NONE>(q, yarn, Axis::Horizontal, last, [&mut largest, &mut stiffness]);
        let zero = 0.0_f64;
        let strain = match viscous.as_ref().and_then(|viscous| viscous.past.get(last / CHUNK)) {
            Some([before, ..]) => {
                let viscosity = pass.directions.horizontal.viscosity.lanes::<f64>();
                viscosity.twice_strain(q.max(zero), before[lane].max(zero))
            }
            None => q,
        };
        let mut stress = law::stress(stiffness, strain);
        if let Some([energy, _, given, _]) = owed.get(last / CHUNK).filter(|_| been_slack & bit(Axis::Horizontal) != 0)
        {
            let (mut energy, mut given) = ([energy[lane]; CHUNK], [given[lane]; CHUNK]);
            pass.owe_dissipated(yarn, Axis::Horizontal, last, [before, stiffness], &mut energy[0]);
            let ([a, b, c], [x, y, z]) = (planes::velocity(first, 0), planes::velocity(chunk, lane));
            let ends = [ring::end_to_end(d, chord), [a - x, b - y, c - z]];
            let mut owed = Owed { energy: &mut energy, given: &mut given };
            stress += owed.stress(&rest, [before, stiffness], q, ends, 0);
        }
        ring::force(stress, d, chord)
    }
}

/// The vertical forces of a row, `row`, on the row `above`, as [`Row::step`] would leave them in `carry`; nothing is stepped and no damage is
/// committed. For a band that starts at `above`.
pub(crate) struct Lift<'a> {
    pub pass: &'a Pass<'a>,
    /// The row's number.
    pub j: usize,
    pub row: &'a [Chunk<HOT_PLANES>],
    pub history: &'a [Chunk<HISTORY_PLANES>],
    pub above: &'a [Chunk<HOT_PLANES>],
    pub carry: &'a mut [Chunk<CARRY_PLANES>],
    pub yarn: &'a YarnRow<'a>,
    /// What its slack segments owe, and nothing is changed; empty where none has been slack.
    pub owed: &'a [Chunk<OWED_PLANES>],
    /// What viscosity keeps of both rows, with the moments of this pass; empty without it.
    pub viscous: [&'a [Chunk<PAST_PLANES>]; 2],
}

impl Lift<'_> {
    /// Finds them.
    pub fn find(self) {
        // Two at a time take little stack.
        lanes::dispatch(InstructionSet::Sse2, self);
    }
}

impl Job for Lift<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lane>(self) {
        let Lift { pass, j, row, history, above, carry, yarn, owed, viscous: [past, past_above] } = self;
        let upwards = pass.directions.vertical;
        let dependent = upwards.rate.depends();
        let limit = L::splat(if dependent { pass.rates.limits[1] } else { upwards.critical });
        let rest = pass.net.row(j).upwards(&upwards.rest);
        let viscosity = upwards.viscosity.lanes::<L>();
        let report = Report::default();
        let mut cold = Cold {
            pass,
            yarn,
            horizontal_end: 0,
            vertical_end: pass.verticals,
            keeps: if owed.is_empty() { 0 } else { bit(Axis::Vertical) },
            report,
            share: 1.0,
            by_rupture: 0.0,
        };
        let rows = row.iter().zip(above).zip(history).zip(carry);
        for (c, (((here, over), [_, history]), carry)) in rows.enumerate() {
            let [_, energy, _, given] = &mut owed.get(c).copied().unwrap_or(NOTHING_OWED);
            let [[ux, uy, uz, .., kv], [ax, ay, az, ..]] = [here, over];
            let [cx, cy, cz] = carry;
            for g in 0..CHUNK / L::WIDTH {
                let d = [
                    L::load(&L::groups(ax)[g]).sub(L::load(&L::groups(ux)[g])),
                    L::load(&L::groups(ay)[g]).sub(L::load(&L::groups(uy)[g])),
                    L::load(&L::groups(az)[g]).sub(L::load(&L::groups(uz)[g])),
                ];
                // Of a plain segment these are the bits of its own functions.
                let q = rest.twice_strain(vertical_axes(d));
                let mut stiffness = L::load(&L::groups(kv)[g]);
                let before = stiffness;
                let largest = L::load(&L::groups(history)[g]);
                if q.any_not_below(limit) && q.any_above(largest) {
                    let place = Place { first: c * CHUNK + g * L::WIDTH, end: pass.verticals, axis: Axis::Vertical };
                    let (mut copy, mut damaged) = (L::ZEROS, L::ZEROS);
                    largest.store(&mut copy);
                    stiffness.store(&mut damaged);
                    cold.damage::<L, SLACK>(q, place, [&mut copy, &mut damaged], Some(&mut L::groups_mut(energy)[g]));
                    stiffness = L::load(&damaged);
                }
                if dependent {
                    stiffness = stiffness.mul(pass.stiffenings([q; 2])[1]);
                }
                let mut stress = law::stress(stiffness, q);
                let mut bent = L::splat(0.0);
                if let Some(past) = past.get(c) {
                    [_, bent] = bending_forces(past, &NO_PAST, past_above.get(c).unwrap_or(&NO_PAST), g);
                    let mut past = *past;
                    let [_, twice_strain, _, stress_before, ..] = &mut past;
                    (stress, _) = Past { twice_strain, stress: stress_before }.stress(&viscosity, stiffness, q, g);
                }
                if !owed.is_empty() {
                    let [_, w] = relative_velocities([here, &NOTHING, over], g);
                    let ends = [rest.end_to_end(vertical_axes(d)), vertical_axes(w)];
                    let mut owed = Owed { energy, given };
                    stress = stress.add(owed.stress(&rest, [before, stiffness], q, ends, g));
                }
                let mut lift = vertical_axes(rest.force(stress, vertical_axes(d)));
                if !past.is_empty() {
                    lift[2] = lift[2].add(bent);
                }
                lift[0].store(&mut L::groups_mut(cx)[g]);
                lift[1].store(&mut L::groups_mut(cy)[g]);
                lift[2].store(&mut L::groups_mut(cz)[g]);
            }
        }
    }
}

impl<
    const PLAIN: bool,
    const GRADED: bool,
    const FACTOR: u8,
    const FETCH: bool,
    const VISCOUS: bool,
    const CURVED: bool,
    const CASING: bool,
> Job for RowJob<'_, '_, PLAIN, GRADED, FACTOR, FETCH, VISCOUS, CURVED, CASING>
{
    type Output = (Report, [f64; 2]);

    #[inline(always)]
    fn run<L: Lane>(self) -> (Report, [f64; 2]) {
        let Row { pass, j, row, history, above, carry, yarn, owed, been_slack, viscous, taken } = self.0;
        let (mut rest_of_past, past_above) =
            viscous.map_or((&mut [][..], &[][..]), |ViscousRow { past, above }| (past, above));
        let (mut no_past, mut none) = (NO_PAST, Taken::NONE);
        let taken = if VISCOUS || FACTOR == RATE { taken.unwrap_or(&mut none) } else { &mut none };
        let share = taken.share;
        let net = if GRADED { pass.net.row(j) } else { NetRow::NONE };
        let mut cold = Cold {
            pass,
            yarn,
            horizontal_end: pass.horizontals,
            vertical_end: if above.is_empty() { 0 } else { pass.verticals },
            keeps: been_slack,
            report: Report::default(),
            share: if FACTOR == RATE { share } else { 0.0 },
            by_rupture: 0.0,
        };
        let mut joint = self.1;
        let mut along = Carried::<L>::of::<CURVED, FACTOR>(pass, &net, been_slack, (&joint, share));
        // All as long as the row, so that one test in the loop is enough.
        let (chunks, fetches) = (row.len(), FETCH && pass.fetches);
        let (Some(history), Some(carry)) = (history.get_mut(..chunks), carry.get_mut(..chunks)) else {
            return (Report::LOST, [0.0; 2]);
        };
        if VISCOUS {
            let Some(past) = rest_of_past.get_mut(..chunks) else { return (Report::LOST, [0.0; 2]) };
            rest_of_past = past;
        }
        let mut rest = row;
        for (c, (history, carry)) in history.iter_mut().zip(carry).enumerate() {
            let Some((chunk, tail)) = rest.split_first_mut() else { break };
            let above = above.get(c).unwrap_or(&NOTHING);
            // The pass reads three planes of the row above and leaves out five, which a processor does not take for a stream that
            // it should fetch by itself. All eight are fetched together: the next row needs the other five.
            if fetches {
                lanes::fetch(above, AHEAD);
            }
            // To the right of the last group: the next chunk's first, or zeros of no consequence.
            let next = tail.first().unwrap_or(&NOTHING);
            let owed = if FACTOR == SLACK { owed.get_mut(c) } else { None };
            let (mut past, mut past_beside) = (&mut no_past, [&NO_PAST; 2]);
            if VISCOUS {
                let Some((first, tail)) = rest_of_past.split_first_mut() else { break };
                (past, rest_of_past) = (first, tail);
                past_beside[0] = rest_of_past.first().unwrap_or(&NO_PAST);
                past_beside[1] = past_above.get(c).unwrap_or(&NO_PAST);
            }
            let columns = if GRADED { net.columns.get(c).unwrap_or(&NO_GRADING) } else { &NO_GRADING };
            let hoop = if CURVED { pass.net.hoop.get(c) } else { None }.unwrap_or(&ring::FLAT);
            let mut planes = Planes {
                chunk,
                history,
                above,
                carry,
                next,
                column: c * CHUNK,
                columns,
                net: &net,
                hoop,
                joint: &mut joint,
                owed,
                past,
                past_beside,
                taken: &mut taken.by_column,
            };
            along.chunk::<PLAIN, GRADED, FACTOR, VISCOUS, CURVED, CASING>(&mut planes, &mut cold);
            rest = tail;
        }
        if FACTOR == RATE {
            taken.by_rupture = cold.by_rupture;
        }
        (cold.report, [least(along.low), greatest(along.high)])
    }
}

/// Eight columns of everything a row needs.
struct Planes<'a, 'j> {
    chunk: &'a mut Chunk<HOT_PLANES>,
    history: &'a mut Chunk<HISTORY_PLANES>,
    above: &'a Chunk<HOT_PLANES>,
    carry: &'a mut Chunk<CARRY_PLANES>,
    /// The chunk behind this one.
    next: &'a Chunk<HOT_PLANES>,
    /// First column.
    column: usize,
    /// Bars and widths of a graded network.
    columns: &'a Chunk<LINE_PLANES>,
    net: &'a NetRow<'a>,
    /// Rest vectors of a curved sheet.
    hoop: &'a Chunk<HOOP_PLANES>,
    joint: &'a mut Joint<'j>,
    /// What slack segments owe.
    owed: Option<&'a mut Chunk<OWED_PLANES>>,
    /// What viscosity keeps of the segments, and what it and the rate take of them.
    past: &'a mut Chunk<PAST_PLANES>,
    taken: &'a mut [f64; CHUNK],
    /// The same of the chunk behind and of the row above.
    past_beside: [&'a Chunk<PAST_PLANES>; 2],
}

/// What is carried along a row from one lane group to the next: all in registers, so nothing here may be lent to a function
/// that is not inlined.
struct Carried<L> {
    /// q at the critical stretch of horizontal and vertical segments.
    limits: [L; 2],
    /// Viscosity of both.
    viscosity: [ViscosityLanes<L>; 2],
    /// Dependence on the rate of both.
    rates: [RateLanes<L>; 2],
    /// [`Rates::relaxing`].
    relaxing: L,
    /// [`Taken::share`].
    share: L,
    /// How both lie in the flat sheet; of no use for plain ones. Of graded horizontal ones it is that of the fabric.
    rests: [RestLanes<L>; 2],
    /// Of the row, in a graded network.
    inverse_width: L,
    /// 1 of those that keep what they owe, else 0.
    keeps: [f64; 2],
    left_force: [L; 3],
    low: L,
    high: L,
}

/// What only the cold path needs.
struct Cold<'a> {
    pass: &'a Pass<'a>,
    yarn: &'a YarnRow<'a>,
    /// Horizontal segments start before this column.
    horizontal_end: usize,
    /// Vertical segments start before this column.
    vertical_end: usize,
    /// Bits of the directions in which segments keep what they owe.
    keeps: u32,
    report: Report,
    /// [`Taken::share`].
    share: f64,
    /// [`Taken::by_rupture`].
    by_rupture: f64,
}

impl<L: Lane> Carried<L> {
    /// At the start of a row. `share`: [`Taken::share`].
    #[inline(always)]
    fn of<const CURVED: bool, const FACTOR: u8>(
        pass: &Pass<'_>,
        net: &NetRow<'_>,
        been_slack: u32,
        (joint, share): (&Joint<'_>, f64),
    ) -> Self {
        let (zero, Along { horizontal, vertical, .. }) = (L::splat(0.0), pass.directions);
        let limits = if FACTOR == RATE { pass.rates.limits } else { [horizontal.critical, vertical.critical] };
        let law = |law: &RateLaw| if FACTOR == RATE { law.at(pass.rates.time) } else { RateLaw::NONE };
        let laws = [law(&horizontal.rate), law(&vertical.rate)];
        Carried {
            limits: [L::splat(limits[0]), L::splat(limits[1])],
            viscosity: [horizontal.viscosity.lanes(), vertical.viscosity.lanes()],
            rates: [laws[0].lanes(), laws[1].lanes()],
            relaxing: L::splat(pass.rates.relaxing),
            share: L::splat(share),
            rests: [
                if CURVED { pass.directions.around() } else { horizontal.rest }.lanes(),
                net.upwards(&vertical.rest),
            ],
            inverse_width: L::splat(net.inverse_width),
            keeps: [Axis::Horizontal, Axis::Vertical].map(|axis| f64::from(u8::from(been_slack & bit(axis) != 0))),
            left_force: if CURVED { spread(joint.left) } else { [zero; 3] },
            low: zero,
            high: zero,
        }
    }

    /// How the segments of group g lie in the flat sheet.
    #[inline(always)]
    fn rests<const GRADED: bool, const FACTOR: u8, const CURVED: bool>(
        &self,
        (columns, net): (&Chunk<LINE_PLANES>, &NetRow<'_>),
        g: usize,
        pass: &Pass<'_>,
    ) -> [RestLanes<L>; 2] {
        let [horizontal, vertical] = if FACTOR == SLACK && !CURVED || FACTOR == RATE || L::WIDTH == CHUNK {
            // AVX-512 spreads a number as it reads it: eight copies of each on the stack would be no gain.
            [pass.directions.horizontal.rest.lanes(), net.upwards(&pass.directions.vertical.rest)]
        } else {
            self.rests
        };
        if GRADED {
            [grading::bars_along(columns, g, horizontal.twice_strain), vertical]
        } else {
            [horizontal, vertical]
        }
    }

    /// From which q on damage is looked for.
    #[inline(always)]
    fn limits<const PLAIN: bool, const FACTOR: u8>(&self, pass: &Pass<'_>) -> [L; 2] {
        if PLAIN {
            [self.limits[0]; 2]
        } else if FACTOR == SLACK {
            // Read where they are used, as the rests are.
            let Along { horizontal, vertical, .. } = pass.directions;
            [L::splat(horizontal.critical), L::splat(vertical.critical)]
        } else {
            self.limits
        }
    }

    /// Eight columns. Written out, so that every place in the chunk is a constant. No lane that is run here has another width.
    #[inline(always)]
    fn chunk<
        const PLAIN: bool,
        const GRADED: bool,
        const FACTOR: u8,
        const VISCOUS: bool,
        const CURVED: bool,
        const CASING: bool,
    >(
        &mut self,
        planes: &mut Planes<'_, '_>,
        cold: &mut Cold<'_>,
    ) {
        self.group::<PLAIN, GRADED, FACTOR, VISCOUS, CURVED, CASING>(planes, 0, cold);
        if L::WIDTH < CHUNK {
            self.group::<PLAIN, GRADED, FACTOR, VISCOUS, CURVED, CASING>(planes, 1, cold);
        }
        if L::WIDTH < CHUNK / 2 {
            self.group::<PLAIN, GRADED, FACTOR, VISCOUS, CURVED, CASING>(planes, 2, cold);
            self.group::<PLAIN, GRADED, FACTOR, VISCOUS, CURVED, CASING>(planes, 3, cold);
        }
    }

    /// One lane group: damage, forces, velocity and position. The two segments are worked on side by side, so that a processor has
    /// two chains of operations to overlap, and share one test for damage. (No closures and no array maps: they would not be
    /// compiled for the instruction set.)
    #[inline(always)]
    fn group<
        const PLAIN: bool,
        const GRADED: bool,
        const FACTOR: u8,
        const VISCOUS: bool,
        const CURVED: bool,
        const CASING: bool,
    >(
        &mut self,
        planes: &mut Planes<'_, '_>,
        g: usize,
        cold: &mut Cold<'_>,
    ) {
        let columns = planes.columns;
        let [w_h, w_v] = if FACTOR == SLACK {
            relative_velocities([&*planes.chunk, planes.next, planes.above], g)
        } else {
            [[L::splat(0.0); 3]; 2]
        };
        let [ux, uy, uz, vx, vy, vz, kh, kv] = &mut *planes.chunk;
        let (vx, vy, vz) = (L::groups_mut(vx), L::groups_mut(vy), L::groups_mut(vz));
        let (kh, kv) = (L::groups_mut(kh), L::groups_mut(kv));
        let [ax, ay, az, ..] = planes.above;
        let (ax, ay, az) = (L::groups(ax), L::groups(ay), L::groups(az));
        let [cx, cy, cz] = &mut *planes.carry;
        let (cx, cy, cz) = (L::groups_mut(cx), L::groups_mut(cy), L::groups_mut(cz));
        let [history_h, history_v] = &mut *planes.history;
        let (history_h, history_v) = (L::groups_mut(history_h), L::groups_mut(history_v));
        let here = [L::load(&L::groups(ux)[g]), L::load(&L::groups(uy)[g]), L::load(&L::groups(uz)[g])];
        let column = planes.column + g * L::WIDTH;

        let up = [L::load(&ax[g]).sub(here[0]), L::load(&ay[g]).sub(here[1]), L::load(&az[g]).sub(here[2])];
        let along = right_less(here, [&*ux, &*uy, &*uz], planes.next, g);
        let [rest_h, rest_v] = self.rests::<GRADED, FACTOR, CURVED>((columns, planes.net), g, cold.pass);
        let chord = [L::load(&L::groups(&planes.hoop[CHORD_X])[g]), L::load(&L::groups(&planes.hoop[CHORD_Z])[g])];
        let (q_v, q_h) = twice_strains::<L, PLAIN, CURVED>(vertical_axes(up), along, chord, [&rest_h, &rest_v]);
        let [limit_h, limit_v] = self.limits::<PLAIN, FACTOR>(cold.pass);
        let some_beyond = if PLAIN {
            q_v.any_not_below_either(q_h, limit_h)
        } else {
            q_h.any_not_below(limit_h) || q_v.any_not_below(limit_v)
        };
        let before = [L::load(&kh[g]), L::load(&kv[g])];
        let (mut factors, within) = if FACTOR == RATE {
            self.stiffenings(planes.taken, before, [q_h, q_v], g)
        } else {
            ([L::splat(1.0); 2], false)
        };
        if some_beyond {
            let of = [[&mut history_h[g], &mut kh[g]], [&mut history_v[g], &mut kv[g]]];
            cold.damage_both::<L, FACTOR>([q_h, q_v], [limit_h, limit_v], column, of, planes.owed.as_deref_mut(), g);
        }
        let (mut kh, mut kv) = (L::load(&kh[g]), L::load(&kv[g]));
        if FACTOR == RATE {
            if within {
                factors = cold.pass.stiffenings([q_h, q_v]);
            }
            (kh, kv) = (kh.mul(factors[0]), kv.mul(factors[1]));
        }
        let [mut stress_v, mut stress_h] = if VISCOUS {
            self.viscous_stresses::<FACTOR>((planes.past, planes.taken), [kh, kv], [q_h, q_v], g, cold.pass)
        } else {
            [law::stress(kv, q_v), law::stress(kh, q_h)]
        };
        let [rest_h, rest_v] = self.rests::<GRADED, FACTOR, CURVED>((columns, planes.net), g, cold.pass);
        if FACTOR == SLACK
            && let Some(owed) = planes.owed.as_deref_mut()
        {
            let x = if CURVED { ring::end_to_end(along, chord) } else { rest_h.end_to_end(along) };
            let ends = [[x, w_h], [rest_v.end_to_end(vertical_axes(up)), vertical_axes(w_v)]];
            let given = self.given(owed, [rest_h, rest_v], [before, [kh, kv]], [q_h, q_v], ends, g);
            (stress_h, stress_v) = (stress_h.add(given[0]), stress_v.add(given[1]));
        }
        let (mut lift, mut force) =
            forces::<L, PLAIN, CURVED>(([stress_h, stress_v], vertical_axes(up)), along, chord, [&rest_h, &rest_v]);
        // On a curve there are no moments.
        if VISCOUS && !CURVED {
            let [next, above] = planes.past_beside;
            let [bent_h, bent_v] = bending_forces::<L>(planes.past, next, above, g);
            force[2] = force[2].add(bent_h);
            lift[2] = lift[2].add(bent_v);
        }
        let lift = vertical_axes(lift);
        let vertical = [hand_on(lift[0], &mut cx[g]), hand_on(lift[1], &mut cy[g]), hand_on(lift[2], &mut cz[g])];

        let mut sum = self.sums::<GRADED>(force, vertical, (columns, planes.net), g);
        if CASING && let Some(on_casing) = &mut planes.joint.on_casing {
            let place = (planes.hoop, here, planes.column / CHUNK);
            sum = push_off(on_casing, place, [L::load(&vx[g]), L::load(&vz[g])], sum, g);
        }
        move_along(here[0], sum[0], &mut vx[g], &mut L::groups_mut(ux)[g]);
        let y = move_along(here[1], sum[1], &mut vy[g], &mut L::groups_mut(uy)[g]);
        move_along(here[2], sum[2], &mut vz[g], &mut L::groups_mut(uz)[g]);
        self.low = y.min(self.low);
        self.high = y.max(self.high);
    }

    /// Factors of the rate on the stiffnesses of group g, along x and y, and whether they are others, because some rates lie within the
    /// two; counts what relaxation takes. `before`: without damage of this pass.
    #[inline(always)]
    fn stiffenings(&self, taken: &mut [f64; CHUNK], before: [L; 2], q: [L; 2], g: usize) -> ([L; 2], bool) {
        let [of_h, of_v] = &self.rates;
        let beyond = [of_h.beyond(q[0]), of_v.beyond(q[1])];
        let (taken_h, taken_v) = (of_h.relaxing(before[0], beyond[0]), of_v.relaxing(before[1], beyond[1]));
        let taken = &mut L::groups_mut(taken)[g];
        L::load(taken).add(taken_h.add(taken_v.mul(self.share)).mul(self.relaxing)).store(taken);
        let within = of_h.within(beyond[0]).max(of_v.within(beyond[1])).any_above(L::splat(0.0));
        ([of_h.stiffening(beyond[0]), of_v.stiffening(beyond[1])], within)
    }

    /// The stresses of (M16) of group g along y and x with their viscous parts; counts what these take.
    #[inline(always)]
    fn viscous_stresses<const FACTOR: u8>(
        &self,
        ([q_x, q_y, x, y, ..], taken): (&mut Chunk<PAST_PLANES>, &mut [f64; CHUNK]),
        [kh, kv]: [L; 2],
        [q_h, q_v]: [L; 2],
        g: usize,
        pass: &Pass<'_>,
    ) -> [L; 2] {
        let Along { horizontal, vertical, .. } = pass.directions;
        // As the rests.
        let [of_h, of_v] = if FACTOR != NONE || L::WIDTH == CHUNK {
            [horizontal.viscosity.lanes(), vertical.viscosity.lanes()]
        } else {
            self.viscosity
        };
        let (stress_v, taken_v) = Past { twice_strain: q_y, stress: y }.stress(&of_v, kv, q_v, g);
        let (stress_h, taken_h) = Past { twice_strain: q_x, stress: x }.stress(&of_h, kh, q_h, g);
        let taken = &mut L::groups_mut(taken)[g];
        L::load(taken).add(taken_h.add(taken_v.mul(self.share))).store(taken);
        [stress_v, stress_h]
    }

    /// The stresses of (M9) that the segments of group g give along x and y. `ends`: displacement and velocity of one end relative to
    /// the other, in the axes of each.
    #[inline(always)]
    fn given(
        &self,
        [energy_h, energy_v, given_h, given_v]: &mut Chunk<OWED_PLANES>,
        [rest_h, rest_v]: [RestLanes<L>; 2],
        [before, now]: [[L; 2]; 2],
        [q_h, q_v]: [L; 2],
        [ends_h, ends_v]: [[[L; 3]; 2]; 2],
        g: usize,
    ) -> [L; 2] {
        let keeps = [L::splat(self.keeps[0]), L::splat(self.keeps[1])];
        let of_h = [before[0].mul(keeps[0]), now[0].mul(keeps[0])];
        let of_v = [before[1].mul(keeps[1]), now[1].mul(keeps[1])];
        let (mut owed_h, mut owed_v) =
            (Owed { energy: energy_h, given: given_h }, Owed { energy: energy_v, given: given_v });
        [owed_h.stress(&rest_h, of_h, q_h, ends_h, g), owed_v.stress(&rest_v, of_v, q_v, ends_v, g)]
    }

    /// The sums of force at the nodes of group g: of the segment to the right, less that to the left, and the vertical part.
    #[inline(always)]
    fn sums<const GRADED: bool>(
        &mut self,
        force: [L; 3],
        vertical: [L; 3],
        (columns, net): (&Chunk<LINE_PLANES>, &NetRow<'_>),
        g: usize,
    ) -> [L; 3] {
        let left = [
            force[0].left_of(self.left_force[0]),
            force[1].left_of(self.left_force[1]),
            force[2].left_of(self.left_force[2]),
        ];
        self.left_force = force;
        if GRADED {
            let inverse_width = if L::WIDTH == CHUNK { L::splat(net.inverse_width) } else { self.inverse_width };
            let widths = [L::load(&L::groups(&columns[INVERSE_WIDTH])[g]), inverse_width];
            [
                graded_with_vertical(force[0], left[0], vertical[0], widths),
                graded_with_vertical(force[1], left[1], vertical[1], widths),
                graded_with_vertical(force[2], left[2], vertical[2], widths),
            ]
        } else {
            [
                with_vertical(force[0], left[0], vertical[0]),
                with_vertical(force[1], left[1], vertical[1]),
                with_vertical(force[2], left[2], vertical[2]),
            ]
        }
    }
}

/// The same vector everywhere.
#[inline(always)]
fn spread<L: Lane>([x, y, z]: [f64; 3]) -> [L; 3] {
    [L::splat(x), L::splat(y), L::splat(z)]
}

/// Twice the strain of the segments of a lane group along y and along x.
#[inline(always)]
fn twice_strains<L: Lane, const PLAIN: bool, const CURVED: bool>(
    up: [L; 3],
    along: [L; 3],
    chord: [L; 2],
    [rest_h, rest_v]: [&RestLanes<L>; 2],
) -> (L, L) {
    if PLAIN && CURVED {
        (law::twice_strain(up), ring::twice_strain(along, chord))
    } else if CURVED {
        (rest_v.twice_strain(up), ring::general_twice_strain(along, chord, rest_h))
    } else if PLAIN {
        (law::twice_strain(up), law::twice_strain(along))
    } else {
        (rest_v.twice_strain(up), rest_h.twice_strain(along))
    }
}

/// Their forces along y, in the axes of these segments, and along x.
#[inline(always)]
fn forces<L: Lane, const PLAIN: bool, const CURVED: bool>(
    ([stress_h, stress_v], up): ([L; 2], [L; 3]),
    along: [L; 3],
    chord: [L; 2],
    [rest_h, rest_v]: [&RestLanes<L>; 2],
) -> ([L; 3], [L; 3]) {
    if PLAIN && CURVED {
        (law::force(stress_v, up), ring::force(stress_h, along, chord))
    } else if CURVED {
        (rest_v.force(stress_v, up), ring::force(stress_h, along, chord))
    } else if PLAIN {
        (law::force(stress_v, up), law::force(stress_h, along))
    } else {
        (rest_v.force(stress_v, up), rest_h.force(stress_h, along))
    }
}

/// The change of velocity of the nodes of group g with the push of their case, which is added to its sums.
#[inline(always)]
fn push_off<L: Lane>(
    OnCasing { case, place_y, pushed: [to_x, to_z, taken], pushes }: &mut OnCasing<'_>,
    (hoop, here, chunk): (&Chunk<HOOP_PLANES>, [L; 3], usize),
    before: [L; 2],
    sum: [L; 3],
    g: usize,
) -> [L; 3] {
    let x = L::load(&L::groups(&hoop[PLACE_X])[g]).add(here[0]);
    let z = L::load(&L::groups(&hoop[PLACE_Z])[g]).add(here[2]);
    let place = [x, L::splat(*place_y).add(here[1]), z];
    let sums = [&mut L::groups_mut(to_x)[g], &mut L::groups_mut(to_z)[g], &mut L::groups_mut(taken)[g]];
    let (push, along) = case.push(place, before, [sum[0], sum[2]], sums);
    if let Some(pushes) = pushes.get_mut(chunk) {
        push.store(&mut L::groups_mut(pushes)[g]);
    }
    [sum[0].add(along[0]), sum[1], sum[2].add(along[1])]
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
fn move_along<L: Lane>(here: L, sum: L, v: &mut L::Group, u: &mut L::Group) -> L {
    let velocity = L::load(v).add(sum).or_zero_below(L::splat(AT_REST));
    velocity.store(v);
    let moved = here.add(velocity);
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

impl Cold<'_> {
    /// Damages the segments of group g along x and y, from this column on, of which some q is at or beyond the limit and above all
    /// before.
    #[inline(always)]
    fn damage_both<L: Lane, const FACTOR: u8>(
        &mut self,
        q: [L; 2],
        limits: [L; 2],
        column: usize,
        [of_h, of_v]: [[&mut L::Group; 2]; 2],
        owed: Option<&mut Chunk<OWED_PLANES>>,
        g: usize,
    ) {
        if let Some([h, v, ..]) = owed
            && FACTOR == SLACK
        {
            let [h, v] = [&mut L::groups_mut(h)[g], &mut L::groups_mut(v)[g]];
            self.damage_beyond::<L, SLACK>(q[0], limits[0], column, Axis::Horizontal, of_h, Some(h));
            self.damage_beyond::<L, SLACK>(q[1], limits[1], column, Axis::Vertical, of_v, Some(v));
        } else {
            self.damage_beyond::<L, FACTOR>(q[0], limits[0], column, Axis::Horizontal, of_h, None);
            self.damage_beyond::<L, FACTOR>(q[1], limits[1], column, Axis::Vertical, of_v, None);
        }
    }

    /// The same of one direction.
    #[inline(always)]
    fn damage_beyond<L: Lane, const FACTOR: u8>(
        &mut self,
        q: L,
        limit: L,
        first: usize,
        axis: Axis,
        [history, stiffness]: [&mut L::Group; 2],
        owed: Option<&mut L::Group>,
    ) {
        if q.any_not_below(limit) && q.any_above(L::load(history)) {
            let end = if axis == Axis::Horizontal { self.horizontal_end } else { self.vertical_end };
            self.damage::<L, FACTOR>(q, Place { first, end, axis }, [history, stiffness], owed);
        }
    }

    /// The cold path: a lane group in which some q is at or beyond the critical one and above all before, or no number.
    #[cold]
    #[inline(never)]
    fn damage<L: Lane, const FACTOR: u8>(
        &mut self,
        q: L,
        place: Place,
        [history, stiffness]: [&mut L::Group; 2],
        mut owed: Option<&mut L::Group>,
    ) {
        let mut strains = L::ZEROS;
        q.store(&mut strains);
        let slots = history.as_mut().iter_mut().zip(stiffness.as_mut());
        for (lane, (&q, (history, stiffness))) in strains.as_ref().iter().zip(slots).enumerate() {
            let column = place.first + lane;
            if column < place.end {
                let before = *stiffness;
                let met = self.pass.damage_segment::<FACTOR>(q, self.yarn, place.axis, column, [history, stiffness]);
                self.report.add(met);
                if FACTOR == RATE && *stiffness != before {
                    self.by_rupture += self.taken_by_rupture(q, place.axis, column, [before, *stiffness]);
                }
                let owed = owed.as_deref_mut().filter(|_| FACTOR == SLACK && self.keeps & bit(place.axis) != 0);
                if let Some(owed) = owed.and_then(|owed| owed.as_mut().get_mut(lane)) {
                    self.pass.owe_dissipated(self.yarn, place.axis, column, [before, *stiffness], owed);
                }
            }
        }
    }
}

impl Cold<'_> {
    /// What a segment dissipates, whose stiffness falls, beyond the law of the reference rate, which the balance counts (`energy.rs`).
    #[inline(never)]
    fn taken_by_rupture(&self, q: f64, axis: Axis, column: usize, [before, now]: [f64; 2]) -> f64 {
        let Cold { pass, yarn, share, .. } = self;
        let dissipated = |stiffness: f64| pass.dissipated(yarn, axis, column, stiffness);
        let weight = match axis {
            Axis::Horizontal => pass.x.segment_weight(column),
            Axis::Vertical => share * pass.x.node_weight(column),
        };
        4.0 * weight * self.excess(q, axis) * (dissipated(now) - dissipated(before))
    }

    /// [`RateLaw::excess`] now.
    #[inline(never)]
    fn excess(&self, q: f64, axis: Axis) -> f64 {
        let law = self.pass.directions.along(axis).rate.at(self.pass.rates.time);
        law.excess(q, law.seen_at(q))
    }
}

impl Pass<'_> {
    /// `RateLaw::stiffening` of a lane group of segments along x and of one along y.
    #[cold]
    #[inline(never)]
    fn stiffenings<L: Lane>(&self, q: [L; 2]) -> [L; 2] {
        let mut groups = [L::ZEROS; 2];
        for ((group, direction), q) in
            groups.iter_mut().zip([self.directions.horizontal, self.directions.vertical]).zip(q)
        {
            q.store(group);
            let law = direction.rate.at(self.rates.time);
            group.as_mut().iter_mut().for_each(|q| *q = law.stiffening(*q));
        }
        [L::load(&groups[0]), L::load(&groups[1])]
    }

    /// Only a new maximum of q changes anything: alpha is a function of the largest q, so the exponential runs only then. The
    /// history of drawn strength begins at the segment's own critical q, so no other test is needed here.
    fn damage_segment<const FACTOR: u8>(
        &self,
        q: f64,
        yarn: &YarnRow<'_>,
        axis: Axis,
        column: usize,
        [history, stiffness]: [&mut f64; 2],
    ) -> Report {
        let usable = q <= LOST || q <= *history;
        if !usable {
            return Report::LOST;
        }
        let Direction { law, rate, .. } = self.directions.along(axis);
        let q = if FACTOR == NONE { q } else { rate.at(self.rates.time).seen_at(q) };
        if !law.is_damaging(q, *history) {
            return Report::default();
        }
        let failed_before = *stiffness == 0.0;
        let (undamaged, damage_rate) = yarn.constants(axis, column);
        let law = law.at(yarn.critical_stretch(law, axis, column));
        let damage = law.damage(damage_rate, q);
        *stiffness = damage.alpha * undamaged;
        // A failed segment never comes here again: no q is above its history.
        *history = damage.history;
        Report { newly_failed: u64::from(damage.alpha == 0.0 && !failed_before), non_finite: false }
    }

    /// Adds to what a segment owes what it dissipates as its stiffness changes so.
    fn owe_dissipated(&self, yarn: &YarnRow<'_>, axis: Axis, column: usize, [before, now]: [f64; 2], owed: &mut f64) {
        if now != before {
            for (sign, stiffness) in [(4.0, now), (-4.0, before)] {
                *owed += sign * self.dissipated(yarn, axis, column, stiffness);
            }
        }
    }

    /// What a segment has dissipated when its stiffness has become this, in the unit of stiffness.
    #[inline(never)]
    fn dissipated(&self, yarn: &YarnRow<'_>, axis: Axis, column: usize, stiffness: f64) -> f64 {
        let law = &self.directions.along(axis).law;
        let (undamaged, damage_rate) = yarn.constants(axis, column);
        // Twice the stiffness stands for the modulus.
        let material = law::Segment { modulus: 2.0 * undamaged, damage_rate };
        law.at(yarn.critical_stretch(law, axis, column)).dissipated(&material, stiffness / undamaged)
    }
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
