//! The hot pass of viscous yarn: the sweep (`sweep.rs`) with the viscous forces of each segment and the moments of each node, one row late.
//!
//! Method: v_{n-1/2} becomes v_{n-1/2} + b(u_n, v_{n-1/2}), and the pass goes on from there. So the viscous forces belong to t_n and
//! their rates to t_{n-1/2}, an error of first order in dt of a force that vanishes with the spacing. By itself this change only lowers
//! the kinetic energy; the ledger counts it as the others: impulse times the mean of the velocities at t_{n-1/2} and t_{n+1/2}.
//! Each segment pulls its ends equally by the viscous part of its force (`yarn/law.rs`); along each yarn a moment at every node with taut
//! segments on both sides acts on the node and its two neighbours. As a force of the segment between nodes i and i + 1 that is
//! M_i - M_{i+1}. Order of one node's sum: (right - left) + (up - down), as in the sweep.
//! A node's change depends on nodes two away, all as they were: a row moves when the segments of the row above it are known. What it
//! needs until then is in the work row.
//! Limits: velocity Verlet, no graded network. The step limit is in `check.rs`.
//! Reference: docs/model.md, "Viscosity".

use crate::ground::lanes::{self, InstructionSet, Job, Lane};
use crate::ground::planes::{
    AT_REST, Axis, CARRY_PLANES, CHUNK, Chunk, HISTORY_PLANES, HOT_PLANES, MARK_PLANES, PUSH_PLANES, RATE_PLANES,
    VISCOUS_PLANES, vertical_axes,
};
use crate::scene::features::Feature;
use crate::sheet::direction::Direction;
use crate::sheet::sweep::{AHEAD, Cold, NOTHING, Pass, Report, Row, YarnRow, greatest, hand_on, least, right_of};
use crate::yarn::law;
use crate::yarn::toe::Toe;

// First planes of the work row, three each but for tension and mask. Of the vertical segments of the last row: relative velocity of the
// ends, stress without its viscous part, viscous pull, moment at their lower ends ...
const RATE: usize = 0;
const TENSION: usize = 3;
const PULL: usize = 4;
/// See [`RATE`].
pub(crate) const MOMENT: usize = 7;
/// ... of those below, their viscous force with the moments of both ends ...
const FORCE: usize = 10;
/// ... of the last row's nodes the sum of forces without viscosity, the viscous pull to the right, the moment of the horizontal yarn ...
const SUM: usize = 13;
const OWN_PULL: usize = 16;
/// See [`SUM`].
pub(crate) const OWN_MOMENT: usize = 19;
/// ... and 1 for a node that moves, 0 for a place without one. Between two jobs: viscous force of the segments above the row that moves,
/// and what the segments above and below give the present row without viscosity.
pub(crate) const MOVES: usize = 22;
const UP: usize = 23;
const LIFTED: usize = 26;

/// To the right of the last chunk of the work row.
const NO_WORK: Chunk<VISCOUS_PLANES> = [[0.0; CHUNK]; VISCOUS_PLANES];

/// A row whose segments are found, and the row below it, which moves.
pub(crate) struct ViscousRow<'a> {
    /// The row, as the sweep takes it; not moved yet.
    pub row: Row<'a>,
    /// The row below; below the first a row of nothing.
    pub below: Below<'a>,
    pub work: &'a mut [Chunk<VISCOUS_PLANES>],
}

/// A row that moves.
pub(crate) struct Below<'a> {
    pub hot: &'a mut [Chunk<HOT_PLANES>],
    /// What viscosity changes of its velocities.
    pub pushes: &'a mut [Chunk<PUSH_PLANES>],
}

/// What moving a row gives.
#[derive(Default)]
pub(crate) struct Moved {
    /// Least and greatest y displacement.
    pub reach: [f64; 2],
    /// Velocities times pushes, of those before and behind the pass, summed over the chunks.
    pub given: [[f64; CHUNK]; 2],
}

impl ViscousRow<'_> {
    /// Finds the vertical segments, with which the row below is complete and moves, and the horizontal ones: jobs of their own, for the
    /// sake of the stack.
    pub fn step(&mut self, moved: &mut Moved) -> Report {
        let set = self.row.pass.instructions;
        let upwards = lanes::dispatch(set, UpJob(self));
        lanes::dispatch(set, MoveJob { below: &mut self.below, work: self.work, moved });
        upwards.merged(lanes::dispatch(set, AlongJob(self)))
    }

    /// q at the critical stretch of a direction.
    #[inline(always)]
    fn limit(&self, axis: Axis) -> f64 {
        let Row { pass, yarn, .. } = &self.row;
        let dependent = Feature::Rate.is_built() && !yarn.logarithms.is_empty();
        if dependent { pass.rates.limits[axis as usize] } else { pass.directions.along(axis).critical }
    }
}

/// The vertical segments of a row.
struct UpJob<'j, 'a>(&'j mut ViscousRow<'a>);

impl Job for UpJob<'_, '_> {
    type Output = Report;

    #[inline(always)]
    fn run<L: Lane>(self) -> Report {
        let limit = L::splat(self.0.limit(Axis::Vertical));
        let ViscousRow { row: Row { pass, row, history, above, carry, yarn, marks, .. }, work, .. } = self.0;
        let mut cold = cold(pass, yarn, above);
        // A copy: what is written into the rows cannot change it.
        let up = Upwards::<L> { direction: *pass.directions.vertical, limit };
        let rows = row.iter_mut().zip(&mut **history).zip(&mut **carry).zip(&mut **work);
        for (c, (((chunk, history), carry), work)) in rows.enumerate() {
            let above = above.get(c).unwrap_or(&NOTHING);
            if pass.fetches {
                lanes::fetch(above, AHEAD);
            }
            let (marks, logarithms) = (marks.get(c), yarn.logarithms.get(c));
            let mut planes = Planes { chunk, history, marks, logarithms, column: c * CHUNK };
            // Written out, so that every place in the chunk is a constant, as in the sweep.
            match CHUNK / L::WIDTH {
                1 => up.group(&mut planes, above, carry, work, 0, &mut cold),
                2 => {
                    up.group(&mut planes, above, carry, work, 0, &mut cold);
                    up.group(&mut planes, above, carry, work, 1, &mut cold);
                }
                _ => {
                    up.group(&mut planes, above, carry, work, 0, &mut cold);
                    up.group(&mut planes, above, carry, work, 1, &mut cold);
                    up.group(&mut planes, above, carry, work, 2, &mut cold);
                    up.group(&mut planes, above, carry, work, 3, &mut cold);
                }
            }
        }
        cold.report
    }
}

/// The horizontal segments of a row.
struct AlongJob<'j, 'a>(&'j mut ViscousRow<'a>);

impl Job for AlongJob<'_, '_> {
    type Output = Report;

    #[inline(always)]
    fn run<L: Lane>(self) -> Report {
        let limit = self.0.limit(Axis::Horizontal);
        let ViscousRow { row: Row { pass, row, history, above, yarn, marks, .. }, work, .. } = self.0;
        let mut cold = cold(pass, yarn, above);
        let mut along = Rightwards::<L>::of(*pass.directions.horizontal, limit);
        let mut rest = &mut **row;
        for (c, (history, work)) in history.iter_mut().zip(&mut **work).enumerate() {
            let Some((chunk, tail)) = rest.split_first_mut() else { break };
            let next = tail.first().unwrap_or(&NOTHING);
            let (marks, logarithms) = (marks.get(c), yarn.logarithms.get(c));
            let mut planes = Planes { chunk, history, marks, logarithms, column: c * CHUNK };
            match CHUNK / L::WIDTH {
                1 => along.group(&mut planes, next, work, 0, &mut cold),
                2 => {
                    along.group(&mut planes, next, work, 0, &mut cold);
                    along.group(&mut planes, next, work, 1, &mut cold);
                }
                _ => {
                    along.group(&mut planes, next, work, 0, &mut cold);
                    along.group(&mut planes, next, work, 1, &mut cold);
                    along.group(&mut planes, next, work, 2, &mut cold);
                    along.group(&mut planes, next, work, 3, &mut cold);
                }
            }
            rest = tail;
        }
        cold.report
    }
}

/// What only damage needs. `above`: empty above the top row, which has no vertical segments.
#[inline(always)]
fn cold<'a>(pass: &'a Pass<'_>, yarn: &'a YarnRow<'_>, above: &[Chunk<HOT_PLANES>]) -> Cold<'a> {
    let vertical_end = if above.is_empty() { 0 } else { pass.verticals };
    Cold { pass, yarn, horizontal_end: pass.horizontals, vertical_end, report: Report::default() }
}

/// Eight columns of a row.
struct Planes<'a> {
    chunk: &'a mut Chunk<HOT_PLANES>,
    history: &'a mut Chunk<HISTORY_PLANES>,
    /// Marks of the toe, if there is one.
    marks: Option<&'a Chunk<MARK_PLANES>>,
    /// Logarithms of the rate, if the yarn depends on it.
    logarithms: Option<&'a Chunk<RATE_PLANES>>,
    /// First column.
    column: usize,
}

/// Eight nodes that move, with their part of the work row.
struct Nodes<'a> {
    hot: &'a mut Chunk<HOT_PLANES>,
    pushes: &'a mut Chunk<PUSH_PLANES>,
    work: &'a mut Chunk<VISCOUS_PLANES>,
    /// The part behind it.
    next: &'a Chunk<VISCOUS_PLANES>,
}

/// What one segment does.
struct Acting<L> {
    /// Stress, without its viscous part, as the moments take it.
    tension: L,
    /// Force and viscous pull on the first node, in the axes of the segment.
    force: [L; 3],
    pull: [L; 3],
}

/// Segments of a lane group: twice the strain, and the stiffness that viscosity takes and that of the force.
struct Segments<L> {
    q: L,
    before: L,
    stiffness: L,
}

impl Planes<'_> {
    /// The segments of one direction of a lane group, with their damage. `d`: in their axes.
    #[inline(always)]
    fn damage<L: Lane>(
        &mut self,
        direction: &Direction,
        limit: L,
        axis: Axis,
        d: [L; 3],
        g: usize,
        cold: &mut Cold<'_>,
    ) -> Segments<L> {
        let plane = axis as usize;
        let q = direction.rest.twice_strain(d);
        // Viscosity takes the stiffness before this pass's damage.
        let mut before: L = at(self.chunk, 6 + plane, g);
        let (history, stiffness) = (&mut self.history[plane], &mut self.chunk[6 + plane]);
        let (history, stiffness) = (&mut L::groups_mut(history)[g], &mut L::groups_mut(stiffness)[g]);
        cold.damage_beyond(q, limit, self.column + g * L::WIDTH, axis, history, stiffness);
        let mut stiffness = L::load(stiffness);
        // Both together are refused.
        if let Some(marks) = self.marks.filter(|_| Feature::Toe.is_built()) {
            let factor = cold.pass.toe.factor(q, at(marks, plane, g));
            (before, stiffness) = (before.mul(factor), stiffness.mul(factor));
        } else if let Some(logarithms) = self.logarithms.filter(|_| Feature::Rate.is_built()) {
            stiffness = stiffness.mul(cold.pass.rates.stiffening(at(logarithms, plane, g)));
        }
        Segments { q, before, stiffness }
    }
}

impl<L: Lane> Segments<L> {
    /// What they do. `d`, `rate`: in their axes.
    #[inline(always)]
    fn act(&self, direction: &Direction, d: [L; 3], rate: [L; 3]) -> Acting<L> {
        let Segments { q, before, stiffness } = *self;
        Acting {
            tension: law::stress(before, q),
            force: direction.rest.force(law::stress(stiffness, q), d),
            pull: direction.rest.force(viscous(direction, before, q, d, rate), d),
        }
    }
}

/// Constants of vertical segments.
struct Upwards<L> {
    direction: Direction,
    /// q at the critical stretch.
    limit: L,
}

impl<L: Lane> Upwards<L> {
    /// One lane group, into the work row.
    #[inline(always)]
    fn group(
        &self,
        planes: &mut Planes<'_>,
        above: &Chunk<HOT_PLANES>,
        [cx, cy, cz]: &mut Chunk<CARRY_PLANES>,
        work: &mut Chunk<VISCOUS_PLANES>,
        g: usize,
        cold: &mut Cold<'_>,
    ) {
        let d = vertical_axes(upwards::<L, HOT_PLANES>(planes.chunk, above, 0, g));
        let segments = planes.damage(&self.direction, self.limit, Axis::Vertical, d, g, cold);
        let rate = upwards(planes.chunk, above, 3, g);
        let acting = segments.act(&self.direction, d, vertical_axes(rate));
        hand_up(work, g, &acting, rate, &self.direction);
        let lift = vertical_axes(acting.force);
        put(work, LIFTED, g, hand_on(lift[0], &mut L::groups_mut(cx)[g]));
        put(work, LIFTED + 1, g, hand_on(lift[1], &mut L::groups_mut(cy)[g]));
        put(work, LIFTED + 2, g, hand_on(lift[2], &mut L::groups_mut(cz)[g]));
    }
}

/// What is carried along the row of horizontal segments.
struct Rightwards<L> {
    /// A copy, as of the vertical ones.
    direction: Direction,
    /// q at the critical stretch.
    limit: L,
    /// Of the segments to the left: stress, relative velocity of the ends, force.
    tension: L,
    rate: [L; 3],
    left_force: [L; 3],
}

impl<L: Lane> Rightwards<L> {
    #[inline(always)]
    fn of(direction: Direction, limit: f64) -> Rightwards<L> {
        let zero = L::splat(0.0);
        Rightwards { direction, limit: L::splat(limit), tension: zero, rate: [zero; 3], left_force: [zero; 3] }
    }

    /// One lane group, into the work row.
    #[inline(always)]
    fn group(
        &mut self,
        planes: &mut Planes<'_>,
        next: &Chunk<HOT_PLANES>,
        work: &mut Chunk<VISCOUS_PLANES>,
        g: usize,
        cold: &mut Cold<'_>,
    ) {
        let d = to_the_right(planes.chunk, next, 0, g);
        let segments = planes.damage(&self.direction, self.limit, Axis::Horizontal, d, g, cold);
        let rate = to_the_right(planes.chunk, next, 3, g);
        let acting = segments.act(&self.direction, d, rate);
        let before = acting.tension.left_of(self.tension);
        let bending = self.direction.viscosity.lanes().bending(before, acting.tension);
        self.axis(work, g, 0, rate[0], bending, &acting);
        self.axis(work, g, 1, rate[1], bending, &acting);
        self.axis(work, g, 2, rate[2], bending, &acting);
        (self.tension, self.rate, self.left_force) = (acting.tension, rate, acting.force);
    }

    /// One axis of it.
    #[inline(always)]
    fn axis(&self, work: &mut Chunk<VISCOUS_PLANES>, g: usize, k: usize, rate: L, bending: L, acting: &Acting<L>) {
        let force = acting.force[k];
        put(work, OWN_PULL + k, g, acting.pull[k]);
        put(work, OWN_MOMENT + k, g, rate.sub(rate.left_of(self.rate[k])).mul(bending));
        put(work, SUM + k, g, force.sub(force.left_of(self.left_force[k])).add(at(work, LIFTED + k, g)));
    }
}

/// (M16) Viscous part of the stress of segments.
#[inline(always)]
fn viscous<L: Lane>(direction: &Direction, stiffness: L, q: L, d: [L; 3], rate: [L; 3]) -> L {
    let Direction { rest, viscosity, .. } = direction;
    viscosity.lanes().stress(stiffness, q, rest.lanes().twice_strain_rate(d, rate))
}

/// The vertical segments of a group into the work row, and the viscous force of those below them, which is complete now.
#[inline(always)]
fn hand_up<L: Lane>(
    work: &mut Chunk<VISCOUS_PLANES>,
    g: usize,
    acting: &Acting<L>,
    rate: [L; 3],
    direction: &Direction,
) {
    let bending = direction.viscosity.lanes().bending(at(work, TENSION, g), acting.tension);
    put(work, TENSION, g, acting.tension);
    let pull = vertical_axes(acting.pull);
    hand_up_along(work, g, 0, rate[0], bending, pull[0]);
    hand_up_along(work, g, 1, rate[1], bending, pull[1]);
    hand_up_along(work, g, 2, rate[2], bending, pull[2]);
}

/// [`hand_up`] along one axis.
#[inline(always)]
fn hand_up_along<L: Lane>(work: &mut Chunk<VISCOUS_PLANES>, g: usize, k: usize, rate: L, bending: L, pull: L) {
    let before: L = at(work, MOMENT + k, g);
    let moment = rate.sub(at(work, RATE + k, g)).mul(bending);
    put(work, UP + k, g, at::<L, VISCOUS_PLANES>(work, PULL + k, g).add(before.sub(moment)));
    put(work, MOMENT + k, g, moment);
    put(work, PULL + k, g, pull);
    put(work, RATE + k, g, rate);
}

/// What is carried along the row that moves.
struct Moving<L> {
    /// Viscous force of the segments to the left.
    left_force: [L; 3],
    low: L,
    high: L,
}

impl<L: Lane> Moving<L> {
    /// Moves a lane group.
    #[inline(always)]
    fn nodes(&mut self, nodes: &mut Nodes<'_>, given: &mut [[f64; CHUNK]; 2], g: usize) {
        let x = self.along(nodes, g, 0);
        let y = self.along(nodes, g, 1);
        let z = self.along(nodes, g, 2);
        self.low = y.place.min(self.low);
        self.high = y.place.max(self.high);
        let [before, behind] = given;
        let (before, behind) = (&mut L::groups_mut(before)[g], &mut L::groups_mut(behind)[g]);
        L::load(before).add(x.before.add(y.before).add(z.before)).store(before);
        // Fixed nodes are put back to rest.
        let given = x.behind.add(y.behind).add(z.behind).mul(at(nodes.work, MOVES, g));
        L::load(behind).add(given).store(behind);
    }

    /// One axis: all forces are known.
    #[inline(always)]
    fn along(&mut self, nodes: &mut Nodes<'_>, g: usize, k: usize) -> Step<L> {
        let Nodes { hot, pushes, work, next } = nodes;
        let up: L = at(work, UP + k, g);
        let vertical = up.sub(at(work, FORCE + k, g));
        put(work, FORCE + k, g, up);
        let moment: L = at(work, OWN_MOMENT + k, g);
        let right = right_of(moment, &work[OWN_MOMENT + k], &next[OWN_MOMENT + k], g);
        let force = at::<L, VISCOUS_PLANES>(work, OWN_PULL + k, g).add(moment.sub(right));
        let push = force.sub(force.left_of(self.left_force[k])).add(vertical);
        self.left_force[k] = force;
        put(pushes, k, g, push);
        let rest = L::splat(AT_REST);
        let v: L = at(hot, 3 + k, g);
        let pushed = v.add(push).or_zero_below(rest);
        let velocity = pushed.add(at(work, SUM + k, g)).or_zero_below(rest);
        put(hot, 3 + k, g, velocity);
        let place = at::<L, HOT_PLANES>(hot, k, g).add(velocity);
        put(hot, k, g, place);
        Step { place, before: v.mul(push), behind: velocity.mul(push) }
    }
}

/// One axis of a group of nodes that has moved: where they are, and the velocities before and behind times the pushes.
struct Step<L> {
    place: L,
    before: L,
    behind: L,
}

/// A row moves whose forces are all known.
struct MoveJob<'j, 'a> {
    below: &'j mut Below<'a>,
    work: &'j mut [Chunk<VISCOUS_PLANES>],
    moved: &'j mut Moved,
}

impl Job for MoveJob<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lane>(self) {
        let MoveJob { below, work, moved } = self;
        let zero = L::splat(0.0);
        let mut moving = Moving::<L> { left_force: [zero; 3], low: zero, high: zero };
        let mut given = [[0.0; CHUNK]; 2];
        let mut rest = work;
        for (hot, pushes) in below.hot.iter_mut().zip(&mut *below.pushes) {
            let Some((work, tail)) = rest.split_first_mut() else { break };
            let mut nodes = Nodes { hot, pushes, work, next: tail.first().unwrap_or(&NO_WORK) };
            match CHUNK / L::WIDTH {
                1 => moving.nodes(&mut nodes, &mut given, 0),
                2 => {
                    moving.nodes(&mut nodes, &mut given, 0);
                    moving.nodes(&mut nodes, &mut given, 1);
                }
                _ => {
                    moving.nodes(&mut nodes, &mut given, 0);
                    moving.nodes(&mut nodes, &mut given, 1);
                    moving.nodes(&mut nodes, &mut given, 2);
                    moving.nodes(&mut nodes, &mut given, 3);
                }
            }
            rest = tail;
        }
        *moved = Moved { reach: [least(moving.low), greatest(moving.high)], given };
    }
}

impl Below<'_> {
    /// The last row moves. `beyond`: a work row with the moments of the row above; empty for none.
    pub fn move_last(
        mut self,
        set: InstructionSet,
        work: &mut [Chunk<VISCOUS_PLANES>],
        beyond: &[Chunk<VISCOUS_PLANES>],
        moved: &mut Moved,
    ) {
        for (c, chunk) in work.iter_mut().enumerate() {
            let beyond = beyond.get(c).unwrap_or(&NO_WORK);
            for k in 0..3 {
                for lane in 0..CHUNK {
                    chunk[UP + k][lane] = chunk[PULL + k][lane] + (chunk[MOMENT + k][lane] - beyond[MOMENT + k][lane]);
                }
            }
        }
        lanes::dispatch(set, MoveJob { below: &mut self, work, moved });
    }
}

/// The vertical segments of a row that another band moves, into a work row.
pub(crate) struct RowBeside<'a> {
    pub vertical: &'a Direction,
    pub toe: &'a Toe,
    pub row: &'a [Chunk<HOT_PLANES>],
    /// Empty above the top row.
    pub above: &'a [Chunk<HOT_PLANES>],
    /// Marks of the toe, empty for none.
    pub marks: &'a [Chunk<MARK_PLANES>],
    pub work: &'a mut [Chunk<VISCOUS_PLANES>],
}

impl Job for RowBeside<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lane>(self) {
        let RowBeside { vertical, toe, row, above, marks, work } = self;
        for (c, (chunk, work)) in row.iter().zip(work).enumerate() {
            let above = above.get(c).unwrap_or(&NOTHING);
            for g in 0..CHUNK / L::WIDTH {
                let (d, rate) = (upwards::<L, HOT_PLANES>(chunk, above, 0, g), upwards(chunk, above, 3, g));
                let axes = vertical_axes(d);
                let q = vertical.rest.twice_strain(axes);
                let mut stiffness: L = at(chunk, 7, g);
                if let Some([_, mark]) = marks.get(c) {
                    stiffness = stiffness.mul(toe.factor(q, L::load(&L::groups(mark)[g])));
                }
                let pull = vertical.rest.force(viscous(vertical, stiffness, q, axes, vertical_axes(rate)), axes);
                let acting = Acting { tension: law::stress(stiffness, q), force: axes, pull };
                hand_up(work, g, &acting, rate, vertical);
            }
        }
    }
}

impl RowBeside<'_> {
    /// Finds them.
    pub fn find(self, set: InstructionSet) {
        lanes::dispatch(set, self);
    }
}

/// A lane group of a plane.
#[inline(always)]
pub(crate) fn at<L: Lane, const P: usize>(chunk: &Chunk<P>, plane: usize, g: usize) -> L {
    L::load(&L::groups(&chunk[plane])[g])
}

/// Puts a lane group into a plane.
#[inline(always)]
pub(crate) fn put<L: Lane, const P: usize>(chunk: &mut Chunk<P>, plane: usize, g: usize, lanes: L) {
    lanes.store(&mut L::groups_mut(&mut chunk[plane])[g]);
}

/// Three planes from `first` on: those of the right-hand neighbours less those of group g.
#[inline(always)]
pub(crate) fn to_the_right<L: Lane, const P: usize>(
    chunk: &Chunk<P>,
    next: &Chunk<P>,
    first: usize,
    g: usize,
) -> [L; 3] {
    let here: [L; 3] = [at(chunk, first, g), at(chunk, first + 1, g), at(chunk, first + 2, g)];
    [
        right_of(here[0], &chunk[first], &next[first], g).sub(here[0]),
        right_of(here[1], &chunk[first + 1], &next[first + 1], g).sub(here[1]),
        right_of(here[2], &chunk[first + 2], &next[first + 2], g).sub(here[2]),
    ]
}

/// The same for the neighbours above.
#[inline(always)]
pub(crate) fn upwards<L: Lane, const P: usize>(chunk: &Chunk<P>, above: &Chunk<P>, first: usize, g: usize) -> [L; 3] {
    [
        at::<L, P>(above, first, g).sub(at(chunk, first, g)),
        at::<L, P>(above, first + 1, g).sub(at(chunk, first + 1, g)),
        at::<L, P>(above, first + 2, g).sub(at(chunk, first + 2, g)),
    ]
}
