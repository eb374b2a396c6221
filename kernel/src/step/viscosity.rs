//! Viscosity of taut yarn: what it changes of the velocities at the start of a pass.
//!
//! Method: v_{n-1/2} becomes v_{n-1/2} + b(u_n, v_{n-1/2}), and the pass goes on from there. So the viscous forces belong to t_n and
//! their rates to t_{n-1/2}, an error of first order in dt of a force that vanishes with the spacing. By itself this change only lowers
//! the kinetic energy; the ledger counts it as the others: impulse times the mean of the velocities at t_{n-1/2} and t_{n+1/2}.
//! Each segment pulls its ends equally by the viscous part of its force (`yarn/law.rs`); along each yarn a moment at every node with taut
//! segments on both sides acts on the node and its two neighbours. As a force of the segment between nodes i and i + 1 that is
//! M_i - M_{i+1}. Order of one node's sum: (right - left) + (up - down), as in the sweep.
//! All changes are found before one is made, in rows of their own, because a node's depends on the velocities of nodes two away.
//! Limits: velocity Verlet. With bands the changes are found in a pass of their own. The step limit is in `check.rs`.
//! Reference: docs/model.md, "Viscosity".

use crate::ground::lanes::{self, InstructionSet, Job, Lane};
use crate::ground::planes::{
    self, Axis, CHUNK, Chunk, HOT_PLANES, MARK_PLANES, PUSH_PLANES, VISCOUS_PLANES, vertical_axes,
};
use crate::memory::arrays::Arrays;
use crate::memory::layout::Layout;
use crate::memory::rows::place_image_column;
use crate::memory::system::System;
use crate::scene::features::Feature;
use crate::sheet::direction::{Along, Direction};
use crate::sheet::sweep::{NOTHING, node_sum, right_of};
use crate::sheet::symmetry::Line;
use crate::yarn::law;
use crate::yarn::toe::Toe;

// First planes of the work row, three each but the first: what the row below hands on ...
const TENSION: usize = 0;
const RATE: usize = 1;
const PULL: usize = 4;
const MOMENT: usize = 7;
/// Of the row below that; before the last row alone.
const MOMENT_BEFORE: usize = 10;
const FORCE: usize = 13;
// ... and what the row itself has found.
const OWN_PULL: usize = 16;
const OWN_MOMENT: usize = 19;

/// Rows of a ply whose changes are found, and what that takes: all that may move, or one band's.
pub(crate) struct Pushing<'r> {
    pub layout: &'r Layout,
    /// Those of the ply.
    pub directions: Along<'r>,
    pub toe: &'r Toe,
    pub instructions: InstructionSet,
    /// All rows of the ply that may move, [first, end).
    pub all: [usize; 2],
    /// Those of which changes are found.
    pub own: [usize; 2],
    /// All rows of the block, with their images.
    pub hot: &'r [Chunk<HOT_PLANES>],
    /// All marks of the toe; empty for none.
    pub marks: &'r [Chunk<MARK_PLANES>],
    pub work: &'r mut [Chunk<VISCOUS_PLANES>],
    /// Changes of the own rows.
    pub pushes: &'r mut [Chunk<PUSH_PLANES>],
}

/// Finds what viscosity changes of the velocities of these rows of a ply, all that may move. Changes no node.
pub(crate) fn find_pushes(system: &mut System<'_>, all: [usize; 2]) {
    let (marked, (ply, _)) =
        (system.layout.has(Feature::Toe) && system.failed_segments > 0, system.layout.ply_and_row(all[0]));
    place_images(system, all);
    let System { layout, directions, model, arrays, instructions, .. } = system;
    let Arrays { hot, marks, viscous, pushes, .. } = arrays;
    let pushes = pushes.get_mut(all[0] * layout.chunks..all[1] * layout.chunks).unwrap_or(&mut []);
    let pushing = Pushing {
        layout,
        directions: directions.of_ply(ply),
        toe: &model.toe,
        instructions: *instructions,
        all,
        own: all,
        hot,
        marks: if marked { marks } else { &[] },
        work: viscous,
        pushes,
    };
    pushing.find();
}

/// The image columns of rows [first, end) with their velocities.
pub(crate) fn place_images(system: &mut System<'_>, [first, end]: [usize; 2]) {
    let (line, chunks) = (system.layout.x, system.layout.chunks);
    if line.is_mirrored() {
        (first..end).for_each(|j| place_image_motion(planes::row_mut(system.arrays.hot, chunks, j), line));
    }
}

impl Pushing<'_> {
    /// Finds the changes. Those of a row depend on the velocities of two rows below it and two above.
    pub fn find(self) {
        let Pushing { layout, directions, toe, instructions, all, own: [first, end], hot, marks, work, pushes } = self;
        let (Along { horizontal, vertical, .. }, chunks) = (directions, layout.chunks);
        work.fill([[0.0; CHUNK]; VISCOUS_PLANES]);
        for j in first.saturating_sub(2).max(all[0])..(end + 1).min(all[1]) {
            // What a row below the first would get goes to the place of the first, which is written afterwards.
            let below = planes::row_mut(pushes, chunks, j.saturating_sub(first + 1));
            let row = planes::row(hot, chunks, j);
            let above = if layout.has_verticals(j) { planes::row(hot, chunks, j + 1) } else { &[] };
            let marks = planes::row(marks, chunks, j);
            if layout.y.is_mirrored() && j + 1 == layout.nodes_y {
                keep_moments(work);
            }
            lanes::dispatch(instructions, FirstLoop { horizontal, vertical, toe, row, above, marks, work, below });
            if !(first..end).contains(&j) {
                continue;
            }
            if layout.x.is_mirrored() {
                place_image_moment(work, layout.x);
            }
            let here = planes::row_mut(pushes, chunks, j - first);
            lanes::dispatch(instructions, SecondLoop { work, here });
            // Places without a node: an image moves with its node.
            for place in layout.nodes_x..chunks * CHUNK {
                (0..PUSH_PLANES).for_each(|plane| set(here, plane, place, 0.0));
            }
        }
        if end == all[1] && first < end {
            let mirrored = layout.y.is_mirrored() && end == layout.nodes_y;
            let last = planes::row_mut(pushes, chunks, end - first - 1);
            close_row(work, last, mirrored.then_some(layout.y), layout.nodes_x);
        }
    }
}

/// What viscosity would change of the velocity of node (i, j), spacings a pass: as [`find_pushes`] finds it, to the bit.
pub(crate) fn push(system: &System<'_>, i: usize, j: usize) -> [f64; 3] {
    let right = segment_force(system, Axis::Horizontal, Some(i), Some(j));
    let left = segment_force(system, Axis::Horizontal, i.checked_sub(1), Some(j));
    let up = segment_force(system, Axis::Vertical, Some(i), Some(j));
    let down = segment_force(system, Axis::Vertical, Some(i), j.checked_sub(1));
    [0, 1, 2].map(|k| node_sum(right[k], left[k], up[k], down[k]))
}

/// What one segment does.
struct Acting {
    /// Relative velocity of its ends.
    rate: [f64; 3],
    /// Stress, without its viscous part.
    tension: f64,
    /// Viscous force on its first node.
    pull: [f64; 3],
}

/// The segment from node (i, j), if there is one.
fn acting(system: &System<'_>, axis: Axis, i: usize, j: usize) -> Option<Acting> {
    let segment = system.segment(axis, i, j)?;
    let end = if axis == Axis::Horizontal { system.node(i + 1, j) } else { system.node(i, j + 1) };
    let (_, v) = system.node(i, j);
    let rate = [end.1[0] - v[0], end.1[1] - v[1], end.1[2] - v[2]];
    let q = segment.twice_strain();
    let stiffness = if system.layout.has(Feature::Toe) && system.failed_segments > 0 {
        segment.stiffness * system.model.toe.factor(q, segment.mark)
    } else {
        segment.stiffness
    };
    let own = (axis.own_axes(segment.d), axis.own_axes(rate));
    let viscosity = &system.direction(axis, j).viscosity;
    let viscous = viscosity.stress(stiffness, q, segment.rest.twice_strain_rate(own.0, own.1));
    let pull = axis.own_axes(segment.rest.force(viscous, own.0));
    Some(Acting { rate, tension: law::stress(stiffness, q), pull })
}

/// Moment of the yarn of this direction at node (i, j), or of its image there.
fn moment(system: &System<'_>, axis: Axis, i: usize, j: usize) -> [f64; 3] {
    let ((node_i, turn_x), (node_j, turn_y)) = (system.layout.x.node(i), system.layout.y.node(j));
    let before = match axis {
        Axis::Horizontal => node_i.checked_sub(1).and_then(|i| acting(system, axis, i, node_j)),
        Axis::Vertical => node_j.checked_sub(1).and_then(|j| acting(system, axis, node_i, j)),
    };
    let (Some(before), Some(behind)) = (before, acting(system, axis, node_i, node_j)) else { return [0.0; 3] };
    let bending = system.direction(axis, node_j).viscosity.bending(before.tension, behind.tension);
    let [x, y, z] = [0, 1, 2].map(|k| (behind.rate[k] - before.rate[k]) * bending);
    [if turn_x { -x } else { x }, if turn_y { -y } else { y }, z]
}

/// Force of the segment from node (i, j) on it, with the moments at its ends.
fn segment_force(system: &System<'_>, axis: Axis, i: Option<usize>, j: Option<usize>) -> [f64; 3] {
    let (Some(i), Some(j)) = (i, j) else { return [0.0; 3] };
    let Some(segment) = acting(system, axis, i, j) else { return [0.0; 3] };
    let end = if axis == Axis::Horizontal { (i + 1, j) } else { (i, j + 1) };
    let (here, there) = (moment(system, axis, i, j), moment(system, axis, end.0, end.1));
    [0, 1, 2].map(|k| segment.pull[k] + (here[k] - there[k]))
}

/// What the segments that start in a row do, the moments of its nodes, and the vertical part of the changes of the row below.
struct FirstLoop<'a> {
    horizontal: &'a Direction,
    vertical: &'a Direction,
    toe: &'a Toe,
    row: &'a [Chunk<HOT_PLANES>],
    /// The row above; empty for the top row.
    above: &'a [Chunk<HOT_PLANES>],
    /// Marks of the toe, empty for none.
    marks: &'a [Chunk<MARK_PLANES>],
    work: &'a mut [Chunk<VISCOUS_PLANES>],
    /// Changes of the row below, of which the horizontal part is known.
    below: &'a mut [Chunk<PUSH_PLANES>],
}

/// The horizontal part of a row's changes.
struct SecondLoop<'a> {
    work: &'a [Chunk<VISCOUS_PLANES>],
    here: &'a mut [Chunk<PUSH_PLANES>],
}

impl Job for FirstLoop<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lane>(self) {
        let FirstLoop { horizontal, vertical, toe, row, above, marks, work, below } = self;
        // Copies: what is written into the rows cannot change them, so they stay in registers.
        let (horizontal, vertical) = (*horizontal, *vertical);
        let zero = L::splat(0.0);
        let mut along = Carried::<L> { horizontal, vertical, tension: zero, rate: [zero; 3] };
        for (c, ((chunk, work), below)) in row.iter().zip(work).zip(below).enumerate() {
            let next = row.get(c + 1).unwrap_or(&NOTHING);
            let above = above.get(c).unwrap_or(&NOTHING);
            let toe = marks.get(c).map(|marks| (toe, marks));
            let mut planes = Planes { chunk, next, above, toe, work, below };
            // Written out, so that every place in the chunk is a constant, as in the sweep.
            match CHUNK / L::WIDTH {
                1 => along.group(&mut planes, 0),
                2 => {
                    along.group(&mut planes, 0);
                    along.group(&mut planes, 1);
                }
                _ => {
                    along.group(&mut planes, 0);
                    along.group(&mut planes, 1);
                    along.group(&mut planes, 2);
                    along.group(&mut planes, 3);
                }
            }
        }
    }
}

/// Eight columns of everything that the first loop needs.
struct Planes<'a> {
    chunk: &'a Chunk<HOT_PLANES>,
    /// The chunk behind this one.
    next: &'a Chunk<HOT_PLANES>,
    above: &'a Chunk<HOT_PLANES>,
    /// The toe with its marks, if there is one.
    toe: Option<(&'a Toe, &'a Chunk<MARK_PLANES>)>,
    work: &'a mut Chunk<VISCOUS_PLANES>,
    below: &'a mut Chunk<PUSH_PLANES>,
}

/// What the first loop carries along a row from one lane group to the next.
struct Carried<L> {
    horizontal: Direction,
    vertical: Direction,
    /// Stress of the segments to the left.
    tension: L,
    /// Relative velocity of their ends.
    rate: [L; 3],
}

impl<L: Lane> Carried<L> {
    #[inline(always)]
    fn group(&mut self, planes: &mut Planes<'_>, g: usize) {
        let Planes { chunk, next, above, toe, work, below } = planes;
        let (chunk, above) = (*chunk, *above);
        let (mut kh, mut kv): (L, L) = (at(chunk, 6, g), at(chunk, 7, g));
        let (d, rate): ([L; 3], [L; 3]) = (to_the_right(chunk, next, 0, g), to_the_right(chunk, next, 3, g));
        let (d_v, rate_v): ([L; 3], [L; 3]) = (upwards(chunk, above, 0, g), upwards(chunk, above, 3, g));
        let (q, q_v) = (self.horizontal.rest.twice_strain(d), self.vertical.rest.twice_strain(vertical_axes(d_v)));
        if let Some((toe, [mark_h, mark_v])) = toe {
            kh = kh.mul(toe.factor(q, L::load(&L::groups(mark_h)[g])));
            kv = kv.mul(toe.factor(q_v, L::load(&L::groups(mark_v)[g])));
        }

        let Direction { rest, viscosity, .. } = &self.horizontal;
        let tension = law::stress(kh, q);
        let pull = rest.force(viscosity.stress(kh, q, rest.twice_strain_rate(d, rate)), d);
        let bending = viscosity.bending(tension.left_of(self.tension), tension);
        put(work, OWN_PULL, g, pull[0]);
        put(work, OWN_PULL + 1, g, pull[1]);
        put(work, OWN_PULL + 2, g, pull[2]);
        put(work, OWN_MOMENT, g, rate[0].sub(rate[0].left_of(self.rate[0])).mul(bending));
        put(work, OWN_MOMENT + 1, g, rate[1].sub(rate[1].left_of(self.rate[1])).mul(bending));
        put(work, OWN_MOMENT + 2, g, rate[2].sub(rate[2].left_of(self.rate[2])).mul(bending));
        (self.tension, self.rate) = (tension, rate);

        let Direction { rest, viscosity, .. } = &self.vertical;
        let tension = law::stress(kv, q_v);
        let own = (vertical_axes(d_v), vertical_axes(rate_v));
        let viscous = viscosity.stress(kv, q_v, rest.twice_strain_rate(own.0, own.1));
        let pull = vertical_axes(rest.force(viscous, own.0));
        let bending = viscosity.bending(at(work, TENSION, g), tension);
        put(work, TENSION, g, tension);
        hand_up(work, below, 0, g, rate_v[0], bending, pull[0]);
        hand_up(work, below, 1, g, rate_v[1], bending, pull[1]);
        hand_up(work, below, 2, g, rate_v[2], bending, pull[2]);
    }
}

/// One axis of the vertical part: what the segment below now exerts goes into the changes of the row below, what this one begins into
/// the work row.
#[inline(always)]
fn hand_up<L: Lane>(
    work: &mut Chunk<VISCOUS_PLANES>,
    below: &mut Chunk<PUSH_PLANES>,
    k: usize,
    g: usize,
    rate: L,
    bending: L,
    pull: L,
) {
    let moment_before: L = at(work, MOMENT + k, g);
    let moment = rate.sub(at(work, RATE + k, g)).mul(bending);
    let up = at::<L, VISCOUS_PLANES>(work, PULL + k, g).add(moment_before.sub(moment));
    let vertical = up.sub(at(work, FORCE + k, g));
    put(below, k, g, at::<L, PUSH_PLANES>(below, k, g).add(vertical));
    put(work, FORCE + k, g, up);
    put(work, MOMENT + k, g, moment);
    put(work, PULL + k, g, pull);
    put(work, RATE + k, g, rate);
}

impl Job for SecondLoop<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lane>(self) {
        let SecondLoop { work, here } = self;
        let mut left_force = [L::splat(0.0); 3];
        for (c, (chunk, here)) in work.iter().zip(here).enumerate() {
            let next = work.get(c + 1).unwrap_or(&NO_WORK);
            for g in 0..CHUNK / L::WIDTH {
                for (k, left_force) in left_force.iter_mut().enumerate() {
                    let moment: L = at(chunk, OWN_MOMENT + k, g);
                    let right = right_of(moment, &chunk[OWN_MOMENT + k], &next[OWN_MOMENT + k], g);
                    let force = at::<L, VISCOUS_PLANES>(chunk, OWN_PULL + k, g).add(moment.sub(right));
                    put(here, k, g, force.sub(force.left_of(*left_force)));
                    *left_force = force;
                }
            }
        }
    }
}

/// To the right of the last chunk of the work row.
const NO_WORK: Chunk<VISCOUS_PLANES> = [[0.0; CHUNK]; VISCOUS_PLANES];

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

/// Keeps the moments of the row before the last, for the images of its nodes.
fn keep_moments(work: &mut [Chunk<VISCOUS_PLANES>]) {
    for chunk in work {
        for k in 0..3 {
            chunk[MOMENT_BEFORE + k] = chunk[MOMENT + k];
        }
    }
}

/// The vertical part of the changes of the last row. `mirrored`: the column's line, if there are images above.
fn close_row(work: &[Chunk<VISCOUS_PLANES>], last: &mut [Chunk<PUSH_PLANES>], mirrored: Option<Line>, nodes_x: usize) {
    for i in 0..nodes_x {
        for plane in 0..PUSH_PLANES {
            let at = |first: usize| planes::get(work, first + plane, i).unwrap_or(0.0);
            let beyond = mirrored.map_or(0.0, |line| {
                // The image of the row before the last for a row on the plane, else of the last.
                let own = line.node(line.modelled()).0 + 1 == line.modelled();
                let moment = at(if own { MOMENT } else { MOMENT_BEFORE });
                if plane == 1 { -moment } else { moment }
            });
            let up = at(PULL) + (at(MOMENT) - beyond);
            let horizontal = planes::get(last, plane, i).unwrap_or(0.0);
            set(last, plane, i, horizontal + (up - at(FORCE)));
        }
    }
}

/// The image column of a row with its velocities.
fn place_image_motion(row: &mut [Chunk<HOT_PLANES>], line: Line) {
    place_image_column(row, line);
    let (node, _) = line.node(line.modelled());
    for (plane, sign) in [(3, -1.0), (4, 1.0), (5, 1.0)] {
        let value = planes::get(row, plane, node).unwrap_or(0.0);
        set(row, plane, line.modelled(), sign * value);
    }
}

/// The moment of the image of a node behind the plane x = 0.
fn place_image_moment(work: &mut [Chunk<VISCOUS_PLANES>], line: Line) {
    let (node, _) = line.node(line.modelled());
    for (k, sign) in [(0, -1.0), (1, 1.0), (2, 1.0)] {
        let value = planes::get(work, OWN_MOMENT + k, node).unwrap_or(0.0);
        set(work, OWN_MOMENT + k, line.modelled(), sign * value);
    }
}

fn set<const P: usize>(row: &mut [Chunk<P>], plane: usize, column: usize, value: f64) {
    if let Some(slot) = planes::get_mut(row, plane, column) {
        *slot = value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ground::lanes::InstructionSet;
    use crate::scene::parts::{Scene, Symmetry};
    use crate::tests::{sheet, sim};

    /// The rows' expressions and the single node's are written apart: they must give the same bits, at edges, planes and tears.
    #[test]
    fn rows_and_single_nodes_agree_to_the_bit() {
        let plain = {
            let mut scene = sheet(21, 18);
            scene.projectile.velocity = [0.0, 0.0, 250.0];
            let yarn = &mut scene.yarn;
            (yarn.viscosity_linear, yarn.viscosity_quadratic, yarn.viscosity_bending) = (0.1, 1.5, 0.06);
            scene
        };
        let part = |mirror_x, mirror_y| {
            let mut scene = Scene { symmetry: Symmetry { mirror_x, mirror_y }, ..plain };
            scene.yarn.stochastic = false;
            scene
        };
        let unlike = {
            let mut scene = plain;
            (scene.sheet.spacing_y, scene.sheet.crimp) = (9e-4, [0.0, 0.004]);
            scene
        };
        let softened = Scene { slack_toe: 0.02, ..plain };
        for scene in [plain, part(true, false), part(false, true), part(true, true), unlike, softened] {
            let mut sim = sim(&scene);
            let layout = *sim.layout();
            let mut pushed = 0;
            for _ in 0..12 {
                // Pushes are velocities in a pass: their energy with the velocities before and behind them.
                let mut gained = 0.0;
                sim.advance(60).unwrap();
                let rows = sim.system.rows_to_step(0);
                sim.system.place_image_row();
                for set in InstructionSet::ALL {
                    sim.system.instructions = set;
                    find_pushes(&mut sim.system, rows);
                    for (i, j) in sim.system.nodes().filter(|(_, j)| (rows[0]..rows[1]).contains(j)) {
                        let row = planes::row(sim.system.arrays.pushes, layout.chunks, j);
                        let found = [0, 1, 2].map(|plane| planes::get(row, plane, i).unwrap());
                        assert_eq!(found, push(&sim.system, i, j), "{set:?} ({i}, {j}) {:?}", scene.symmetry);
                        pushed += usize::from(found != [0.0; 3]);
                        if !sim.system.is_fixed(i, j) {
                            let (_, v) = sim.system.node(i, j);
                            let work: f64 = (0..3).map(|k| found[k] * (2.0 * v[k] + found[k])).sum();
                            gained += work * layout.node_weight(i, j);
                        }
                    }
                    assert!(gained < 0.0, "viscosity takes energy");
                }
            }
            assert!(sim.system.failed_segments > 0 && pushed > 4000, "{pushed}");
        }
    }
}
