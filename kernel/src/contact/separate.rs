//! Plies separated where they press on each other: after the sweep, and where the projectile is near after
//! its impulses.
//!
//! Method: the regression of `column.rs`, of eight columns at once ([`PlyColumns`]); one by one where the
//! projectile pushes one of them, with a case, and where nodes do not face each other.
//! Limits and reference: as in `stack.rs` and `column.rs`.

use crate::body::pose::Vector;
use crate::contact::apply::correct_casing_loss;
use crate::contact::column::{hold_back, load, project};
use crate::contact::members;
use crate::ground::lanes::{self, Item, Job, Lane, at};
use crate::ground::math;
use crate::ground::planes::{self, CHUNK, Chunk, HOT_PLANES, SPEED_X, SPEED_Z, X, Z};
use crate::memory::arrays::{Arrays, RowArrays};
use crate::memory::records::{Node, Pool};
use crate::memory::system::System;
use crate::scene::features::Feature;
use crate::sheet::columns::{COLUMN_PLANES, NORMAL_X, NORMAL_Z, Net};
use crate::sheet::neighbours::{NOTHING, own};

/// Rows that move in every ply and have no candidate: their columns are separated before the projectile's
/// impulses, while they are at hand.
#[derive(Clone, Copy)]
pub(crate) struct Apart {
    /// Rows [first, end) that move in every ply.
    moving: [usize; 2],
    /// Rows [first, end) from the first to the last that has a candidate.
    under: [usize; 2],
}

impl Apart {
    /// Rows of so many candidates, as they were found.
    pub fn of(system: &System<'_>, count: usize) -> Apart {
        let (rows, nodes_x) = (system.layout.y.modelled(), system.layout.nodes_x.max(1));
        let candidates = system.arrays.candidates.get(..count).unwrap_or(&[]);
        let (mut moving, mut under) = ([0, rows], [rows, 0]);
        for ply in 0..system.layout.plies {
            let [low, high] = system.awake_of(ply).map(|row| row.saturating_sub(ply * rows));
            moving = [low.max(moving[0]), high.min(moving[1])];
            // They come ply by ply and row by row.
            let [from, to] =
                [ply, ply + 1].map(|ply| candidates.partition_point(|c| (c.node as usize) < ply * rows * nodes_x));
            let of_ply = candidates.get(from..to).unwrap_or(&[]);
            for c in of_ply.first().into_iter().chain(of_ply.last()) {
                let row = (c.node as usize / nodes_x).saturating_sub(ply * rows);
                under = [row.min(under[0]), (row + 1).max(under[1])];
            }
        }
        Apart { moving, under }
    }

    fn contains(&self, row: usize) -> bool {
        let is_in = |[first, end]: [usize; 2]| (first..end).contains(&row);
        is_in(self.moving) && !is_in(self.under)
    }

    /// Separates the plies in those of these rows that it contains.
    pub fn separate(&self, system: &mut System<'_>, [first, end]: [usize; 2]) {
        (first..end).filter(|&row| self.contains(row)).for_each(|row| separate_row(system, row, 0));
    }

    /// Separates them in all others, after the projectile's impulses. `count`: candidates.
    pub fn separate_others(&self, system: &mut System<'_>, count: usize) {
        for row in (0..system.layout.y.modelled()).filter(|&row| !self.contains(row)) {
            if (0..system.layout.plies).any(|ply| is_awake(system, ply, row)) {
                separate_row(system, row, count);
            }
        }
    }
}

fn is_awake(system: &System<'_>, ply: usize, row: usize) -> bool {
    let [first, end] = system.awake_of(ply);
    (first..end).contains(&(ply * system.layout.y.modelled() + row))
}

/// Candidates with a normal impulse in a column of free nodes.
fn candidates_with_impulse(system: &System<'_>, i: usize, row: usize, count: usize) -> impl Iterator<Item = usize> {
    let Arrays { leaders, members, ends, candidates, .. } = &system.arrays;
    let place = row * system.layout.nodes_x + i;
    // An earlier step may have left the number of a candidate that is now elsewhere.
    let is_here = move |&c: &usize| {
        let candidate = candidates.get(c).filter(|_| c < count);
        candidate.is_some_and(|candidate| candidate.node as usize % leaders.len().max(1) == place)
    };
    let column = members::leader(leaders, place).filter(is_here).map_or(0..0, |c| members::column(ends, c));
    let column = members.get(column).unwrap_or(&[]).iter().map(|&c| c as usize).filter(is_here);
    column.filter(|&c| candidates.get(c).is_some_and(|c| c.impulse > 0.0 && !c.is_fixed()))
}

/// Separates the columns of one row in which plies press on each other.
fn separate_row(system: &mut System<'_>, row: usize, count: usize) {
    let (plies, chunks, [at, next]) = (system.layout.plies, system.layout.chunks, system.layout.stacked(0, row));
    let mut from = 0;
    loop {
        // Columns of a curved sheet have axes of their own.
        let hoop = Net { columns: system.arrays.columns, lines: system.arrays.lines }.hoop();
        let hot = system.arrays.rows.hot.get(at..).unwrap_or(&[]);
        let pressed = Pressed { hot, next, hoop, gap: system.model.gap, chunks: [from, chunks] };
        let Some(chunk) = lanes::dispatch(system.instructions, pressed) else { return };
        from = chunk + 1;
        let is_pushed = (chunk * CHUNK..system.layout.nodes_x.min(from * CHUNK))
            .any(|i| candidates_with_impulse(system, i, row, count).next().is_some());
        let columns = PlyColumns {
            hoop: hoop.get(chunk),
            hot: system.arrays.rows.hot.get_mut(at + chunk..).unwrap_or(&mut []),
            before: system.arrays.rows.before.get(at + chunk..).unwrap_or(&[]),
            speeds: Node::numbers(system.arrays.column).as_chunks_mut().0,
            ends: Pool::numbers(system.arrays.pools).as_chunks_mut().0,
            next,
            front: system.scene.front_plies() as usize,
            back_share: system.model.back_share,
            gap: system.model.gap,
            rise: system.directions.front.vertical.rest.spacing,
            deepest: system.state.sums.ply_penetration / system.scene.sheet.spacing * (1.0 - 1e-9),
            only_plies: !is_pushed && !system.layout.has(Feature::Casing),
        };
        match lanes::dispatch(system.instructions, columns) {
            Pressing::Separated { depth, lost } => {
                let sums = &mut system.state.sums;
                sums.ply_penetration = math::max(depth * system.scene.sheet.spacing, sums.ply_penetration);
                sums.ply_loss += lost * system.model.unit_energy;
                for ply in 0..plies {
                    let moving =
                        |chunk: &Chunk<HOT_PLANES>| chunk[SPEED_X..=SPEED_Z].as_flattened() != [0.0; 3 * CHUNK];
                    if !is_awake(system, ply, row)
                        && system.arrays.rows.hot.get(at + chunk + ply * next).is_some_and(moving)
                    {
                        system.wake(ply * system.layout.y.modelled() + row);
                    }
                }
            }
            Pressing::Pressed(pressed) => {
                for (i, pressed) in (chunk * CHUNK..system.layout.nodes_x).zip(pressed) {
                    if pressed > 0.0 && !system.is_fixed(i, row) {
                        separate_column(system, i, row, count);
                    }
                }
            }
        }
    }
}

/// The first chunk of a row, from one on, in which a node ends below the one that it faces below and comes
/// nearer to it.
struct Pressed<'a> {
    /// From the first chunk of the row of the first ply on, and chunks from ply to ply.
    hot: &'a [Chunk<HOT_PLANES>],
    next: usize,
    hoop: &'a [Chunk<COLUMN_PLANES>],
    gap: f64,
    /// The first one, and that after the last.
    chunks: [usize; 2],
}

impl Job for Pressed<'_> {
    type Output = Option<usize>;

    #[inline(always)]
    fn run<L: Lane>(self) -> Option<usize> {
        // Out of the sheet, along z or along the normals.
        if self.hoop.is_empty() {
            self.first(|chunk, first, _, g| at::<L, _>(chunk, first + 2, g))
        } else {
            self.first(|chunk, first, c, g| own::<L>(chunk, first, self.hoop.get(c), g)[2])
        }
    }
}

impl Pressed<'_> {
    /// The chunk, by a component of three planes from one on.
    #[inline(always)]
    fn first<L: Lane>(&self, component: impl Fn(&Chunk<HOT_PLANES>, usize, usize, usize) -> L) -> Option<usize> {
        let (gap, zero) = (L::splat(self.gap), L::splat(0.0));
        for c in self.chunks[0]..self.chunks[1] {
            let column = self.hot.get(c..).unwrap_or(&[]);
            let outwards = |chunk: &Chunk<HOT_PLANES>, first: usize, g: usize| component(chunk, first, c, g);
            // One test for all of the chunk, and velocities are looked at only where it finds something.
            let (mut least, mut below) = (L::splat(f64::INFINITY), [L::splat(-f64::INFINITY); CHUNK]);
            for chunk in column.iter().step_by(self.next.max(1)) {
                for (g, below) in below.iter_mut().take(CHUNK / L::WIDTH).enumerate() {
                    let above = outwards(chunk, X, g);
                    (least, *below) = (above.sub(*below).min(least), above);
                }
            }
            if !zero.any_above(least.add(gap)) {
                continue;
            }
            least = zero;
            let mut below = None;
            for above in column.iter().step_by(self.next.max(1)) {
                if let Some(below) = below.replace(above) {
                    for g in 0..CHUNK / L::WIDTH {
                        let end = outwards(above, X, g).sub(outwards(below, X, g));
                        let nearing = outwards(above, SPEED_X, g).sub(outwards(below, SPEED_X, g));
                        least = end.add(gap).max(nearing).min(least);
                    }
                }
            }
            if zero.any_above(least) {
                return Some(c);
            }
        }
        None
    }
}

/// State of eight columns.
enum Pressing {
    /// A number above 0 for those in which facing nodes press on each other, or are through each other by
    /// more than any were; for all if some of their nodes do not face each other.
    Pressed([f64; CHUNK]),
    /// They are separated: how deep facing nodes were through each other at the step's start, spacings, and
    /// what was lost, m (h/dt)^2.
    Separated { depth: f64, lost: f64 },
}

/// Separates eight columns in which nothing but plies presses, or says where something presses.
///
/// The last of the nodes so far ends where those before it push it most: as a pool with some of them, s_k +
/// max(0, max_a sum m_j (s_j - s_k) / sum m_j) over j = a..k. Each of them ends at the least of its own and
/// all later ones: the regression of `column.rs`. A node on which none presses keeps its velocity exactly.
struct PlyColumns<'a> {
    /// Constants of the columns; None in a flat sheet.
    hoop: Option<&'a Chunk<COLUMN_PLANES>>,
    /// From their chunk of the first ply on, and chunks from ply to ply.
    hot: &'a mut [Chunk<HOT_PLANES>],
    before: &'a [[f64; CHUNK]],
    next: usize,
    /// Velocities of each ply with gaps added up.
    speeds: &'a mut [[f64; CHUNK]],
    /// Velocities that it ends with.
    ends: &'a mut [[f64; CHUNK]],
    /// Plies of the front fabric, and mass of a node of the back one over that of one of these.
    front: usize,
    back_share: f64,
    /// Distance of the plies, and spacing of the rows, spacings.
    gap: f64,
    rise: f64,
    /// Depth that was met, spacings.
    deepest: f64,
    only_plies: bool,
}

impl Job for PlyColumns<'_> {
    type Output = Pressing;

    #[inline(always)]
    fn run<L: Lane>(mut self) -> Pressing {
        let (gap, deepest, zero) = (L::splat(self.gap), L::splat(self.deepest), L::splat(0.0));
        let (one, rise) = (L::splat(1.0), L::splat(self.rise));
        let (mut found, mut depths, mut face) = ([0.0; CHUNK], [0.0; CHUNK], true);
        for (g, (found, depths)) in L::groups_mut(&mut found).iter_mut().zip(L::groups_mut(&mut depths)).enumerate() {
            let own = |chunk: &Chunk<HOT_PLANES>, first: usize| own::<L>(chunk, first, self.hoop, g);
            // Operations as in `load`, so that the answers are the same.
            let mut below = &NOTHING;
            let (mut speed_below, mut pressed, mut depth) = (L::splat(-f64::INFINITY), zero, zero);
            let (mut offset, mut apart_x, mut apart_y) = (zero, zero, zero);
            for (k, (above, speeds)) in self.hot.iter().step_by(self.next.max(1)).zip(&mut *self.speeds).enumerate() {
                let ([x, y, z], [a, b, v]) = (own(above, X), own(above, SPEED_X));
                if k > 0 {
                    let ([x_below, y_below, z_below], [a_below, b_below, v_below]) =
                        (own(below, X), own(below, SPEED_X));
                    let start = gap.add(z.sub(z_below)).sub(v.sub(v_below));
                    offset = offset.add(start.max(zero));
                    depth = zero.sub(start).max(depth);
                    let (x, y) = (x.sub(a).sub(x_below.sub(a_below)), y.sub(b).sub(y_below.sub(b_below)));
                    apart_x = x.max(zero.sub(x)).max(apart_x);
                    apart_y = y.max(zero.sub(y)).max(apart_y);
                }
                let speed = v.add(offset);
                pressed = speed_below.sub(speed).max(pressed);
                speed.store(&mut L::groups_mut(speeds)[g]);
                (below, speed_below) = (above, speed);
            }
            pressed.max(depth.sub(deepest)).store(found);
            depth.store(depths);
            face &= !apart_x.any_above(one) && !apart_y.any_above(rise);
        }
        if !face {
            return Pressing::Pressed([1.0; CHUNK]);
        }
        if !self.only_plies {
            return Pressing::Pressed(found);
        }
        let mut lost = [0.0; CHUNK];
        for (g, lost) in L::groups_mut(&mut lost).iter_mut().enumerate() {
            self.take_apart::<L>(g).store(lost);
        }
        let depth = depths.into_iter().fold(0.0, math::max);
        Pressing::Separated { depth, lost: lost.into_iter().sum() }
    }
}

impl PlyColumns<'_> {
    /// Takes group g of the columns apart, whose velocities with gaps added up are known. Returns what is
    /// lost.
    #[inline(always)]
    fn take_apart<L: Lane>(&mut self, g: usize) -> L {
        let zero = L::splat(0.0);
        let share = |ply: usize| if ply < self.front { 1.0 } else { self.back_share };
        for (k, ends) in self.ends.iter_mut().enumerate() {
            let Some((earlier, [speeds, ..])) = self.speeds.split_at_checked(k) else { break };
            let last = L::load(&L::groups(speeds)[g]);
            let (mut sum, mut mass, mut most) = (zero, share(k), zero);
            for (j, speeds) in earlier.iter().enumerate().rev() {
                let share = share(j);
                sum = sum.add(L::splat(share).mul(L::load(&L::groups(speeds)[g]).sub(last)));
                mass += share;
                most = sum.mul(L::splat(1.0 / mass)).max(most);
            }
            last.add(most).store(&mut L::groups_mut(ends)[g]);
        }
        let (mut end, mut lost) = (L::splat(f64::INFINITY), L::splat(0.0));
        for k in (0..self.speeds.len()).rev() {
            let at = k * self.next;
            let (Some(speeds), Some(ends), Some(chunk), Some(before)) =
                (self.speeds.get(k), self.ends.get(k), self.hot.get_mut(at), self.before.get(at))
            else {
                break;
            };
            end = L::load(&L::groups(ends)[g]).min(end);
            let push = end.sub(L::load(&L::groups(speeds)[g]));
            let [_, _, speed] = own::<L>(chunk, SPEED_X, self.hoop, g);
            let after = speed.add(push);
            let mean = L::splat(0.5).mul(L::load(&L::groups(before)[g]).add(after));
            lost = lost.sub(L::splat(share(k)).mul(push.mul(mean)));
            let add = |plane: &mut [f64; CHUNK], given: L| {
                let group = &mut L::groups_mut(plane)[g];
                L::load(group).add(given).store(group);
            };
            let [x, _, z, speed_x, _, speed_z, ..] = chunk;
            let mut up = push;
            if let Some(hoop) = self.hoop {
                let [normal_x, normal_z] = [NORMAL_X, NORMAL_Z].map(|plane| L::load(&L::groups(&hoop[plane])[g]));
                let along = push.mul(normal_x);
                up = push.mul(normal_z);
                add(x, along);
                add(speed_x, along);
            }
            add(z, up);
            add(speed_z, up);
        }
        lost
    }
}

/// Separates one column of free nodes, some of which may be among the first `count` candidates.
fn separate_column(system: &mut System<'_>, i: usize, row: usize, count: usize) {
    let (rows, chunks, layout) = (system.layout.y.modelled(), system.layout.chunks, system.layout);
    let (deepest, presses) = load(system, i, row);
    let sums = &mut system.state.sums;
    sums.ply_penetration = math::max(deepest * system.scene.sheet.spacing, sums.ply_penetration);
    if !presses {
        return;
    }
    project(system.arrays.column, system.arrays.pools);
    // Nodes that the projectile pushes get the push of the case with the next sweep, as those of a single
    // ply.
    let rests = layout.has(Feature::Casing) && candidates_with_impulse(system, i, row, count).next().is_none();
    let by_case = if rests { rest_on_casing(system, i, row) } else { 0.0 };
    let (mut lost, normal) = (-by_case, system.normal(i));
    for ply in 0..layout.plies {
        let j = ply * rows + row;
        let Arrays { rows: RowArrays { hot, before, .. }, column, .. } = &mut system.arrays;
        let (Some(&Node { before: v, speed, mass, .. }), Some(chunk), Some(before)) =
            (column.get(ply), planes::row_mut(hot, chunks, j).get_mut(i / CHUNK), before.get(j * chunks + i / CHUNK))
        else {
            return;
        };
        let lane = i % CHUNK;
        let push = speed - v;
        if push == 0.0 {
            continue;
        }
        lost -= mass * (push * (0.5 * (before[lane] + speed)));
        let given = if let Some(normal) = normal {
            push_outwards(system, [i, j], push, normal)
        } else {
            chunk[SPEED_Z][lane] = speed;
            chunk[Z][lane] += push;
            Vector::z() * push
        };
        less_from_projectile(system, count, [i, j], &given);
        system.wake(j);
    }
    system.state.sums.ply_loss += lost * system.model.unit_energy;
}

/// Pushes a node of a curved sheet along the normal of its column. Returns what its velocity changes by.
fn push_outwards(system: &mut System<'_>, [i, j]: [usize; 2], push: f64, [sine, cosine]: [f64; 2]) -> Vector {
    let (u, v) = system.node(i, j);
    let given = Vector::new(push * sine, 0.0, push * cosine);
    if system.layout.has(Feature::Casing) {
        correct_casing_loss(system, [u[0] - v[0], u[2] - v[2]], [i, j], &given);
    }
    let moved = |x: [f64; 3]| [x[0] + given.x, x[1], x[2] + given.z];
    system.set_node(i, j, moved(u), moved(v));
    given
}

/// Corrects the work of the projectile's impulse on a node to which plies then give this velocity, spacings a
/// step: the balances of contact take the velocity at the end of the step.
fn less_from_projectile(system: &mut System<'_>, count: usize, [i, j]: [usize; 2], given: &Vector) {
    let (_, row) = system.layout.ply_and_row(j);
    let node = (j * system.layout.nodes_x + i) as u32;
    let of_node = |&c: &usize| system.arrays.candidates.get(c).is_some_and(|candidate| candidate.node == node);
    let Some(c) = candidates_with_impulse(system, i, row, count).find(of_node) else { return };
    let Some(candidate) = system.arrays.candidates.get(c) else { return };
    let given = given * (0.5 * system.model.unit_speed);
    system.state.sums.loss -= candidate.impulse * candidate.normal.dot(&given);
    if let Some(t) = system.arrays.tangential.get(c) {
        system.state.sums.friction -= t.work(t.along(&given));
    }
}

/// Holds the nodes of a solved column back that press the first of them into its case. Returns what that
/// takes of their energy, in units of m (h/dt)^2.
fn rest_on_casing(system: &mut System<'_>, i: usize, row: usize) -> f64 {
    let layout = system.layout;
    let case = system.directions.casing.zip(system.normal(i));
    let Some(((case, normal), first)) = case.zip(system.arrays.column.first().copied()) else { return 0.0 };
    let ([x, y, z], ([u, v, w], _)) = (system.rest(i, row), system.node(i, row));
    let room = case.room([x + u, y + v, z + w], normal, first.speed - first.before);
    let Arrays { rows: RowArrays { before, .. }, column, .. } = &mut system.arrays;
    let at = |ply: usize| {
        let chunk = before.get((ply * layout.y.modelled() + row) * layout.chunks + i / CHUNK);
        chunk.map_or(0.0, |before| before[i % CHUNK])
    };
    let [given, taken] = hold_back(column, first.speed + room, at);
    system.state.sums.casing -= Vector::new(given * normal[0], 0.0, given * normal[1]);
    system.state.sums.casing_loss += taken * system.model.unit_energy;
    taken
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ground::lanes::InstructionSet;
    use crate::tests::number;

    /// Eight columns at once end as each by itself, of one fabric and of two, with every instruction set;
    /// what nothing presses on stays exactly.
    #[test]
    fn columns_of_a_chunk_end_as_one_by_one() {
        for case in 0..200_u64 {
            let (plies, gap) = (2 + (case % 7) as usize, 0.1);
            let (front, back_share) = (1 + plies / 2, if case % 2 == 0 { 1.0 } else { 0.4 });
            let mut hot = [NOTHING; 8];
            for (k, lane) in (0..plies).flat_map(|k| (0..CHUNK).map(move |lane| (k, lane))) {
                let draw = |n: u64| number(10_000 * case + 100 * k as u64 + 10 * lane as u64 + n);
                (hot[k][Z][lane], hot[k][SPEED_Z][lane]) = (0.1 * draw(0), 0.2 * draw(1));
            }
            for set in InstructionSet::ALL.into_iter().filter(|set| set.available()) {
                let (mut moved, mut speeds, mut ends) = (hot, [[0.0; CHUNK]; 8], [[0.0; CHUNK]; 8]);
                let columns = PlyColumns {
                    hoop: None,
                    hot: &mut moved[..plies],
                    before: &[[0.0; CHUNK]; 8],
                    next: 1,
                    speeds: &mut speeds[..plies],
                    ends: &mut ends[..plies],
                    front,
                    back_share,
                    gap,
                    rise: 1.0,
                    deepest: 0.0,
                    only_plies: true,
                };
                assert!(matches!(lanes::dispatch(set, columns), Pressing::Separated { .. }));
                for lane in 0..CHUNK {
                    let mut alone = [Node::default(); 8];
                    for k in 0..plies {
                        let [z, speed] = [Z, SPEED_Z].map(|plane| hot[k][plane][lane]);
                        let [below, below_speed] =
                            [Z, SPEED_Z].map(|plane| if k > 0 { hot[k - 1][plane][lane] } else { 0.0 });
                        let start = gap + (z - below) - (speed - below_speed);
                        let room = if k > 0 { start.max(0.0) } else { f64::INFINITY };
                        let mass = if k < front { 1.0 } else { back_share };
                        alone[k] = Node { speed, gap: room, mass, ..Node::default() };
                    }
                    project(&mut alone[..plies], &mut [Pool::default(); 8]);
                    for k in 0..plies {
                        let (after, before) = (alone[k].speed, hot[k][SPEED_Z][lane]);
                        let found = moved[k][SPEED_Z][lane];
                        assert!((found - after).abs() < 1e-15, "{case}, {set:?}, ply {k}: {found}, {after}");
                        assert!((after == before) == (found == before), "{case}, {set:?}, ply {k}");
                    }
                }
            }
        }
    }
}
