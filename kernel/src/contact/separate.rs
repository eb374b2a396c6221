//! Plies separated where they press on each other with no candidate among them: behind the sweep and the projectile's impulses.

use crate::body::pose::Vector;
use crate::contact::apply::press;
use crate::contact::candidate::Candidate;
use crate::contact::column::{Node, hold_back, load, project};
use crate::contact::friction::Tangential;
use crate::ground::lanes::{self, Job, Lane};
use crate::ground::math;
use crate::ground::planes::{self, CHUNK, Chunk, HOT_PLANES, SPEED_X, SPEED_Z, X, Z};
use crate::memory::arrays::Arrays;
use crate::memory::system::System;
use crate::scene::features::Feature;
use crate::sheet::neighbours::own;
use crate::sheet::ring::{FLAT, HOOP_PLANES};

/// Separates the plies behind the sweep and the projectile's impulses. `count`: candidates.
#[inline(never)]
pub(crate) fn separate(system: &mut System<'_>, count: usize) {
    // The balances of contact take the velocities that nodes have at the end of the pass.
    let [before, rubbed_before] = half_work(system, count);
    for row in 0..system.layout.y.modelled() {
        for ply in 1..system.layout.plies {
            if system.layout.has(Feature::Curved) {
                separate_rows::<true>(system, ply, row);
            } else {
                separate_rows::<false>(system, ply, row);
            }
        }
    }
    let [after, rubbed_after] = half_work(system, count);
    system.state.sums.loss -= after - before;
    system.state.sums.friction -= rubbed_after - rubbed_before;
}

/// Half of what the projectile's impulses do with the present velocities of their nodes, along the normals and along the surface, J.
fn half_work(system: &System<'_>, count: usize) -> [f64; 2] {
    let (mut work, mut rubbed) = (0.0, 0.0);
    for c in 0..count {
        let (Some(slot), Some(&node)) = (system.arrays.candidates.get(c), system.arrays.candidate_nodes.get(c)) else {
            break;
        };
        let candidate = Candidate::read(slot);
        if candidate.impulse > 0.0 && !candidate.is_fixed() {
            let (i, j) = system.layout.column_and_row(node as usize);
            let velocity = system.velocity(i, j);
            work += 0.5 * candidate.impulse * candidate.normal.dot(&velocity);
            if let Some(t) = system.arrays.tangential.get(c).map(Tangential::read) {
                rubbed += 0.5 * t.work(t.along(&velocity));
            }
        }
    }
    [work, rubbed]
}

/// Separates the columns of one row in which this ply presses on the one before it. CURVED: of a curved sheet, whose columns have axes of
/// their own.
fn separate_rows<const CURVED: bool>(system: &mut System<'_>, ply: usize, row: usize) {
    let (rows, chunks) = (system.layout.y.modelled(), system.layout.chunks);
    let [below, above] = [ply - 1, ply].map(|ply| {
        let [first, end] = system.awake_of(ply);
        let j = ply * rows + row;
        (j, first <= j && j < end)
    });
    if !below.1 && !above.1 {
        return;
    }
    let mut from = 0;
    loop {
        let hoop: &[_] = if CURVED { system.arrays.hoop } else { &[] };
        let pressed = Pressed::<CURVED> {
            below: planes::row(system.arrays.hot, chunks, below.0),
            above: planes::row(system.arrays.hot, chunks, above.0),
            hoop,
            gap: system.model.gap,
            from,
        };
        let Some(chunk) = lanes::dispatch(system.instructions, pressed) else { return };
        from = chunk + 1;
        let [at, next] = system.layout.stacked(chunk * CHUNK, row);
        let columns = Columns::<CURVED> {
            hoop: hoop.get(chunk).unwrap_or(&FLAT),
            hot: system.arrays.hot.get(at..).unwrap_or(&[]),
            next,
            plies: system.layout.plies,
            gap: system.model.gap,
            rise: system.directions.front.vertical.rest.spacing,
            deepest: system.state.sums.ply_penetration / system.scene.sheet.spacing * (1.0 - 1e-9),
        };
        let pressed = lanes::dispatch(system.instructions, columns);
        for (i, pressed) in (chunk * CHUNK..system.layout.nodes_x).zip(pressed) {
            if pressed > 0.0 && !system.is_fixed(i, row) {
                separate_column(system, i, row);
            }
        }
    }
}

/// The first chunk of a row, from number `from` on, in which a node ends below the one that it faces below and comes nearer to it.
struct Pressed<'a, const CURVED: bool> {
    below: &'a [Chunk<HOT_PLANES>],
    above: &'a [Chunk<HOT_PLANES>],
    hoop: &'a [Chunk<HOOP_PLANES>],
    gap: f64,
    from: usize,
}

impl<const CURVED: bool> Job for Pressed<'_, CURVED> {
    type Output = Option<usize>;

    #[inline(always)]
    fn run<L: Lane>(self) -> Option<usize> {
        let (gap, zero) = (L::splat(self.gap), L::splat(0.0));
        let [below, above] = [self.below, self.above].map(|row| row.get(self.from..).unwrap_or(&[]));
        for (c, (below, above)) in (self.from..).zip(below.iter().zip(above)) {
            let hoop = if CURVED { self.hoop.get(c) } else { None }.unwrap_or(&FLAT);
            let growth = |first: usize, g: usize| {
                own::<L, CURVED>(above, first, hoop, g)[2].sub(own::<L, CURVED>(below, first, hoop, g)[2])
            };
            let end = |g: usize| growth(X, g).add(gap);
            // One test for all of the chunk, and velocities are looked at only where it finds something.
            let lowest = (0..CHUNK / L::WIDTH).fold(zero, |lowest, g| end(g).min(lowest));
            if !zero.any_above(lowest) {
                continue;
            }
            let least = (0..CHUNK / L::WIDTH).fold(zero, |least, g| end(g).max(growth(SPEED_X, g)).min(least));
            if zero.any_above(least) {
                return Some(c);
            }
        }
        None
    }
}

/// Which of eight columns there is something to do in: a number above 0 for those in which facing nodes press on each other, or are
/// through each other by more than any were; for all if some of their nodes do not face each other.
struct Columns<'a, const CURVED: bool> {
    hoop: &'a Chunk<HOOP_PLANES>,
    /// From their chunk of the first ply on, and chunks from ply to ply.
    hot: &'a [Chunk<HOT_PLANES>],
    next: usize,
    plies: usize,
    /// As in `column.rs`.
    gap: f64,
    rise: f64,
    /// Depth that was met, spacings.
    deepest: f64,
}

impl<const CURVED: bool> Job for Columns<'_, CURVED> {
    type Output = [f64; CHUNK];

    #[inline(always)]
    fn run<L: Lane>(self) -> [f64; CHUNK] {
        let (gap, deepest, zero) = (L::splat(self.gap), L::splat(self.deepest), L::splat(0.0));
        let (one, rise) = (L::splat(1.0), L::splat(self.rise));
        let mut found = [0.0; CHUNK];
        for (g, found) in L::groups_mut(&mut found).iter_mut().enumerate() {
            let own = |chunk: &Chunk<HOT_PLANES>, first: usize| own::<L, CURVED>(chunk, first, self.hoop, g);
            // The same operations as in `load`, so that the answers are the same.
            let Some(mut below) = self.hot.first() else { break };
            let ([_, _, mut speed_below], mut place) = (own(below, SPEED_X), self.next);
            let (mut most, mut offset, mut apart_x, mut apart_y) = (zero, zero, zero, zero);
            for _ in 1..self.plies {
                let Some(above) = self.hot.get(place) else { break };
                let ([x, y, z], [x_below, y_below, z_below]) = (own(above, X), own(below, X));
                let ([_, _, v], [_, _, v_below]) = (own(above, SPEED_X), own(below, SPEED_X));
                let start = gap.add(z.sub(z_below)).sub(v.sub(v_below));
                offset = offset.add(start.max(zero));
                let speed = v.add(offset);
                most = speed_below.sub(speed).max(zero.sub(start).sub(deepest)).max(most);
                let (x, y) = (x.sub(x_below), y.sub(y_below));
                apart_x = x.max(zero.sub(x)).max(apart_x);
                apart_y = y.max(zero.sub(y)).max(apart_y);
                (below, speed_below, place) = (above, speed, place + self.next);
            }
            let face = !apart_x.any_above(one) && !apart_y.any_above(rise);
            (if face { most } else { one }).store(found);
        }
        found
    }
}

/// Separates one column of free nodes.
fn separate_column(system: &mut System<'_>, i: usize, row: usize) {
    let (rows, chunks, layout) = (system.layout.y.modelled(), system.layout.chunks, system.layout);
    let (deepest, presses) = load(system, i, row);
    let sums = &mut system.state.sums;
    sums.ply_penetration = math::max(deepest * system.scene.sheet.spacing, sums.ply_penetration);
    if !presses {
        return;
    }
    project(system.arrays.column);
    let by_case = if layout.has(Feature::Casing) { rest_on_casing(system, i, row) } else { 0.0 };
    let mut lost = -by_case;
    for ply in 0..layout.plies {
        let j = ply * rows + row;
        let Arrays { hot, column, before, .. } = &mut system.arrays;
        let (Some(Node { before: v, speed, mass, .. }), Some(chunk), Some(before)) = (
            column.get(ply).map(Node::read),
            planes::row_mut(hot, chunks, j).get_mut(i / CHUNK),
            before.get(j * chunks + i / CHUNK),
        ) else {
            return;
        };
        let lane = i % CHUNK;
        let push = speed - v;
        if push == 0.0 {
            continue;
        }
        lost -= mass * (push * (0.5 * (before[lane] + speed)));
        if layout.has(Feature::Curved) {
            push_outwards(system, [i, j], push);
        } else {
            chunk[SPEED_Z][lane] = speed;
            chunk[Z][lane] += push;
        }
        system.wake(j);
    }
    system.state.sums.ply_loss += lost * system.model.unit_energy;
}

/// Pushes a node of a curved sheet along the normal of its column.
#[inline(never)]
fn push_outwards(system: &mut System<'_>, [i, j]: [usize; 2], push: f64) {
    let ([sine, cosine], (u, v)) = (system.normal(i), system.node(i, j));
    let given = Vector::new(push * sine, 0.0, push * cosine);
    if system.layout.has(Feature::Casing) {
        press(system, [u[0] - v[0], u[2] - v[2]], [i, j], &given);
    }
    let moved = |x: [f64; 3]| [x[0] + given.x, x[1], x[2] + given.z];
    system.set_node(i, j, moved(u), moved(v));
}

/// Holds the nodes of a solved column back that press the first of them into its case. Returns what that takes of their energy, in units of m
/// (h/dt)^2.
#[inline(never)]
fn rest_on_casing(system: &mut System<'_>, i: usize, row: usize) -> f64 {
    let (layout, [sine, cosine]) = (system.layout, system.normal(i));
    let Some((case, first)) = system.directions.casing.zip(system.arrays.column.first().map(Node::read)) else {
        return 0.0;
    };
    let ([x, y, z], ([u, v, w], _)) = (system.rest(i, row), system.node(i, row));
    let room = case.room([x + u, y + v, z + w], [sine, cosine], first.speed - first.before);
    let Arrays { column, before, .. } = &mut system.arrays;
    let at = |ply: usize| {
        let chunk = before.get((ply * layout.y.modelled() + row) * layout.chunks + i / CHUNK);
        chunk.map_or(0.0, |before| before[i % CHUNK])
    };
    let [given, taken] = hold_back(column, first.speed + room, at);
    system.state.sums.casing -= Vector::new(given * sine, 0.0, given * cosine);
    system.state.sums.casing_loss += taken * system.model.unit_energy;
    taken
}
