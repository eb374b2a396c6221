//! Plies separated where they press on each other: after the sweep, and where the projectile is near after
//! its impulses.
//!
//! Method: the regression of `column.rs`, of eight columns at once ([`PlyColumns`]); one by one where the
//! projectile pushes one of them, with a case, and where nodes do not face each other.
//! Limits and reference: as in `stack.rs` and `column.rs`.

use crate::body::pose::Vector;
use crate::contact::apply::{correct_casing_loss, correct_clamp_work};
use crate::contact::column::{HELD, hold_back};
use crate::ground::lanes::{self, Job, Lane, at};
use crate::ground::math;
use crate::ground::planes::{self, CHUNK, Chunk, HOT_PLANES, SPEED_X, SPEED_Z, X, Z};
use crate::memory::arrays::{Arrays, Contacts, RowArrays};
use crate::memory::network::Network;
use crate::memory::records::{Candidate, Node};
use crate::memory::state::Sums;
use crate::memory::system::System;
use crate::scene::features::Feature;
use crate::sheet::columns::{COLUMN_PLANES, NORMAL_X, NORMAL_Z, Net};
use crate::sheet::neighbours::{NOTHING, own};

/// Rows that move in every ply and have no candidate: their columns are separated before the projectile's
/// impulses, while they are at hand.
#[derive(Clone, Copy)]
pub(crate) struct EarlyRows {
    /// Rows [first, end) that move in every ply.
    moving: [usize; 2],
    /// Rows [first, end) from the first to the last that has a candidate.
    under: [usize; 2],
}

impl EarlyRows {
    /// Early rows beside these candidates, which are in the order in which they were found.
    pub fn of(network: &Network<'_>, candidates: &[Candidate]) -> EarlyRows {
        let (rows, nodes_x) = (network.layout.y.modelled(), network.layout.nodes_x.max(1));
        let (mut moving, mut under) = ([0, rows], [rows, 0]);
        for ply in 0..network.layout.plies {
            let [low, high] = network.awake_of(ply).map(|row| row.saturating_sub(ply * rows));
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
        EarlyRows { moving, under }
    }

    fn contains(&self, row: usize) -> bool {
        let is_in = |[first, end]: [usize; 2]| (first..end).contains(&row);
        is_in(self.moving) && !is_in(self.under)
    }
}

/// Plies to be separated, with the candidates that the projectile pushes.
pub(crate) struct Separation<'s, 'a> {
    pub network: &'s mut Network<'a>,
    pub contacts: &'s mut Contacts<'a>,
    pub sums: &'s mut Sums,
    /// Number of the candidates; 0 before the projectile's impulses.
    pub count: usize,
}

impl<'s, 'a> Separation<'s, 'a> {
    /// Separation of a system with so many candidates.
    pub fn of(system: &'s mut System<'a>, count: usize) -> Separation<'s, 'a> {
        let System { network, contacts, state, .. } = system;
        Separation { network, contacts, sums: &mut state.sums, count }
    }

    /// Separates the plies in those of rows [first, end) that are early.
    pub fn early(&mut self, early: &EarlyRows, [first, end]: [usize; 2]) {
        (first..end).filter(|&row| early.contains(row)).for_each(|row| self.row(row));
    }

    /// Separates them in all others, after the projectile's impulses.
    pub fn others(&mut self, early: &EarlyRows) {
        for row in (0..self.network.layout.y.modelled()).filter(|&row| !early.contains(row)) {
            if (0..self.network.layout.plies).any(|ply| self.is_awake(ply, row)) {
                self.row(row);
            }
        }
    }

    fn is_awake(&self, ply: usize, row: usize) -> bool {
        let [first, end] = self.network.awake_of(ply);
        (first..end).contains(&(ply * self.network.layout.y.modelled() + row))
    }

    /// Candidates with a normal impulse in a column of free nodes.
    fn with_impulse(&self, i: usize, row: usize) -> impl Iterator<Item = usize> {
        self.contacts.with_impulse(&self.network.layout, i, row, self.count)
    }

    /// Separates the columns of one row in which plies press on each other.
    fn row(&mut self, row: usize) {
        let layout = self.network.layout;
        let (plies, chunks, [at, next]) = (layout.plies, layout.chunks, layout.stacked(0, row));
        let mut from = 0;
        loop {
            // Columns of a curved sheet have axes of their own.
            let hoop = Net { columns: self.network.arrays.columns, lines: self.network.arrays.lines }.hoop();
            let hot = self.network.arrays.rows.hot.get(at..).unwrap_or(&[]);
            let pressed = Pressed { hot, next, hoop, gap: self.network.model.gap, chunks: [from, chunks] };
            let Some(chunk) = lanes::dispatch(self.network.instructions, pressed) else { return };
            from = chunk + 1;
            let is_pushed =
                (chunk * CHUNK..layout.nodes_x.min(from * CHUNK)).any(|i| self.with_impulse(i, row).next().is_some());
            // A clamp may hold some nodes of a column and have let go of others.
            let is_held = (chunk * CHUNK..from * CHUNK).any(|i| self.network.arrays.rows.is_clamped([i, row]));
            let only_plies = !is_pushed && !is_held && self.network.directions.case().is_none();
            match self.chunk(row, chunk, only_plies) {
                Pressing::Separated { depth, mut lost } => {
                    if layout.has(Feature::Grading) {
                        let net = self.network.net(0);
                        lost.iter_mut().zip(chunk * CHUNK..).for_each(|(lost, i)| *lost *= net.share(i, row));
                    }
                    self.note_depth(depth);
                    self.sums.ply_loss += lost.into_iter().sum::<f64>() * self.network.model.unit_energy;
                    for ply in 0..plies {
                        let moving =
                            |chunk: &Chunk<HOT_PLANES>| chunk[SPEED_X..=SPEED_Z].as_flattened() != [0.0; 3 * CHUNK];
                        if !self.is_awake(ply, row)
                            && self.network.arrays.rows.hot.get(at + chunk + ply * next).is_some_and(moving)
                        {
                            self.network.wake(ply * layout.y.modelled() + row);
                        }
                    }
                }
                Pressing::Pressed(pressed) => {
                    for (i, pressed) in (chunk * CHUNK..layout.nodes_x).zip(pressed) {
                        let is_fixed = |ply| self.network.is_fixed(i, ply * layout.y.modelled() + row);
                        if pressed > 0.0 && !(0..plies).all(is_fixed) {
                            self.column(i, row);
                        }
                    }
                }
            }
        }
    }

    /// Separates the columns of one chunk of a row if `only_plies` press there, or says which of them do.
    fn chunk(&mut self, row: usize, chunk: usize, only_plies: bool) -> Pressing {
        let Network { scene, layout, model, directions, arrays, instructions, .. } = &mut *self.network;
        let [at, next] = layout.stacked(chunk * CHUNK, row);
        let Arrays { rows, columns, lines, .. } = arrays;
        let columns = PlyColumns {
            hoop: Net { columns, lines }.hoop().get(chunk),
            hot: rows.hot.get_mut(at..).unwrap_or(&mut []),
            before: rows.before.get(at..).unwrap_or(&[]),
            speeds: self.contacts.speeds_of_columns,
            ends: self.contacts.ends_of_columns,
            next,
            front: scene.front_plies() as usize,
            back_share: model.back_share,
            gap: model.gap,
            rise: directions.front.vertical.rest.spacing,
            deepest: self.sums.ply_penetration / scene.sheet.spacing * (1.0 - 1e-9),
            only_plies,
        };
        lanes::dispatch(*instructions, columns)
    }

    /// Notes a depth of facing nodes in each other, spacings.
    fn note_depth(&mut self, depth: f64) {
        let depth = depth * self.network.scene.sheet.spacing;
        self.sums.ply_penetration = math::max(depth, self.sums.ply_penetration);
    }

    /// Separates one column of which a node is free, some of which may be among the candidates.
    fn column(&mut self, i: usize, row: usize) {
        let layout = self.network.layout;
        let (deepest, presses) = self.contacts.column().load(self.network, i, row);
        self.note_depth(deepest);
        if !presses {
            return;
        }
        self.contacts.column().project();
        self.load_clamps(i, row);
        let (mut lost, normal) = (-self.rest_on_casing(i, row), self.network.normal(i));
        for ply in 0..layout.plies {
            let j = ply * layout.y.modelled() + row;
            let RowArrays { hot, before, .. } = &mut self.network.arrays.rows;
            let (Some(&Node { before: v, speed, mass, .. }), Some(chunk), Some(before)) = (
                self.contacts.nodes_of_column.get(ply),
                planes::row_mut(hot, layout.chunks, j).get_mut(i / CHUNK),
                before.get(j * layout.chunks + i / CHUNK),
            ) else {
                return;
            };
            let lane = i % CHUNK;
            let push = speed - v;
            if push == 0.0 {
                continue;
            }
            lost -= mass * (push * (0.5 * (before[lane] + speed)));
            let given = if let Some(normal) = normal {
                push_outwards(self.network, self.sums, [i, j], push, normal)
            } else {
                chunk[SPEED_Z][lane] = speed;
                chunk[Z][lane] += push;
                Vector::z() * push
            };
            correct_clamp_work(self.network, self.sums, [i, j], &given);
            self.less_from_projectile([i, j], &given);
            self.network.wake(j);
        }
        let share = if layout.has(Feature::Grading) { self.network.net(0).share(i, row) } else { 1.0 };
        self.sums.ply_loss += lost * share * self.network.model.unit_energy;
    }

    /// Adds the reaction of nodes that clamps hold in the solved column to that on their attachment.
    fn load_clamps(&mut self, i: usize, row: usize) {
        let column = self.contacts.nodes_of_column.iter();
        let Some(ply) = column.clone().position(|node| node.mass == HELD) else { return };
        let free = column.filter(|node| node.mass != HELD);
        let given = free.fold(0.0, |sum, node| sum + node.mass * (node.speed - node.before));
        let [sine, cosine] = self.network.normal(i).unwrap_or([0.0, 1.0]);
        let on_clamp = Vector::new(sine, 0.0, cosine) * -given;
        self.network.load_support(self.sums, i, ply * self.network.layout.y.modelled() + row, &on_clamp);
    }

    /// Corrects the work of the projectile's impulse on a node to which plies then give this velocity,
    /// spacings a step: the balances of contact take the velocity at the end of the step.
    fn less_from_projectile(&mut self, [i, j]: [usize; 2], given: &Vector) {
        let (_, row) = self.network.layout.ply_and_row(j);
        let node = (j * self.network.layout.nodes_x + i) as u32;
        let candidates = &self.contacts.candidates;
        let of_node = |&c: &usize| candidates.get(c).is_some_and(|candidate| candidate.node == node);
        let Some(c) = self.with_impulse(i, row).find(of_node) else { return };
        let Some(candidate) = self.contacts.candidates.get(c) else { return };
        let given = given * (0.5 * self.network.model.unit_speed * candidate.multiplicity);
        self.sums.loss -= candidate.impulse * candidate.normal.dot(&given);
        if let Some(t) = self.contacts.tangential.get(c) {
            self.sums.friction -= t.work(t.along(&given));
        }
    }

    /// Holds the nodes of the solved column back that press the first of them into its case. Returns what
    /// that takes of their energy, in units of m (h/dt)^2.
    fn rest_on_casing(&mut self, i: usize, row: usize) -> f64 {
        let Some((case, normal)) = self.network.directions.case().zip(self.network.normal(i)) else { return 0.0 };
        // Nodes that the projectile pushes get the push of the case with the next sweep, as those of a single
        // ply.
        if self.with_impulse(i, row).next().is_some() {
            return 0.0;
        }
        let (layout, column) = (self.network.layout, &mut *self.contacts.nodes_of_column);
        let Some(first) = column.first().copied() else { return 0.0 };
        let ([x, y, z], ([u, v, w], _)) = (self.network.rest(i, row), self.network.node(i, row));
        let room = case.room([x + u, y + v, z + w], normal, first.speed - first.before);
        let before = &self.network.arrays.rows.before;
        let at = |ply: usize| {
            let chunk = before.get((ply * layout.y.modelled() + row) * layout.chunks + i / CHUNK);
            chunk.map_or(0.0, |before| before[i % CHUNK])
        };
        let [given, taken] = hold_back(column, first.speed + room, at);
        self.sums.casing.impulse -= Vector::new(given * normal[0], 0.0, given * normal[1]);
        self.sums.casing.loss += taken * self.network.model.unit_energy;
        taken
    }
}

/// Pushes a node of a curved sheet along the normal of its column. Returns what its velocity changes by.
fn push_outwards(
    network: &mut Network<'_>,
    sums: &mut Sums,
    [i, j]: [usize; 2],
    push: f64,
    [sine, cosine]: [f64; 2],
) -> Vector {
    let (u, v) = network.node(i, j);
    let given = Vector::new(push * sine, 0.0, push * cosine);
    correct_casing_loss(network, sums, [u[0] - v[0], u[2] - v[2]], [i, j], &given);
    let moved = |x: [f64; 3]| [x[0] + given.x, x[1], x[2] + given.z];
    network.set_node(i, j, moved(u), moved(v));
    given
}

/// The first chunk of a row, from one on, in which a node ends below the one that it faces below and comes
/// nearer to it.
struct Pressed<'a> {
    /// Chunks from the first of the row in the first ply on, and their number from ply to ply.
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
    /// Separated columns: depth of facing nodes in each other at the step's start, spacings, and what each
    /// lost, m (h/dt)^2.
    Separated { depth: f64, lost: [f64; CHUNK] },
}

/// Separates eight columns in which nothing but plies presses, or says where something presses.
///
/// The last of the nodes so far ends where those before it push it most: as a pool with some of them, s_k +
/// max(0, max_a sum m_j (s_j - s_k) / sum m_j) over j = a..k. Each of them ends at the least of its own and
/// all later ones: the regression of `column.rs`. A node on which none presses keeps its velocity exactly.
struct PlyColumns<'a> {
    /// Constants of the columns; None in a flat sheet.
    hoop: Option<&'a Chunk<COLUMN_PLANES>>,
    /// Chunks from that of the columns in the first ply on, and their number from ply to ply.
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
            self.end_of_group::<L>(g).store(lost);
        }
        let depth = depths.into_iter().fold(0.0, math::max);
        Pressing::Separated { depth, lost }
    }
}

impl PlyColumns<'_> {
    /// Separates group g of the columns, whose velocities with gaps added up are known. Returns the energy
    /// lost.
    #[inline(always)]
    fn end_of_group<L: Lane>(&mut self, g: usize) -> L {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::column::Column;
    use crate::ground::lanes::InstructionSet;
    use crate::memory::records::Pool;
    use crate::tests::{network, number, sheet};

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
                    Column { nodes: &mut alone[..plies], pools: &mut [Pool::default(); 8] }.project();
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

    /// Plies of two fabrics that lie on each other and approach in some columns: these end with the velocity
    /// of their common momentum, and the loss is the kinetic energy lost. Columns are separated one by one
    /// beside a node that the projectile pushes, and all of a chunk at once.
    #[test]
    fn plies_that_meet_move_on_with_their_common_momentum() {
        let mut scene = sheet(21, 19);
        (scene.stack.plies, scene.stack.gap) = (3, 1e-4);
        (scene.back.plies, scene.back.node_mass) = (1, 1.7 * scene.sheet.node_mass);
        scene.back.yarn_area = scene.sheet.yarn_area;
        for is_pushed in [false, true] {
            let (mut network, mut contacts, _) = network(&scene);
            let (gap, rows) = (network.model.gap, network.layout.y.modelled());
            let masses = [1.0, 1.0, network.model.back_share];
            let (row, columns) = (9, [3, 8, 9, 15]);
            for (k, (i, ply)) in (0..).zip(columns.into_iter().flat_map(|i| [(i, 0), (i, 1), (i, 2)])) {
                let (j, speed) = (ply * rows + row, 0.02 * (2.0 - ply as f64) + 1e-3 * number(k));
                network.set_node(i, j, [0.0, 0.0, speed - ply as f64 * gap], [0.0, 0.0, speed]);
                network.arrays.rows.before[j * network.layout.chunks + i / CHUNK][i % CHUNK] = speed;
                network.wake(j);
            }
            let mut count = 0;
            if is_pushed {
                let node = (row * network.layout.nodes_x + 9) as u32;
                contacts.candidates[0] = Candidate { node, impulse: 1e-30, ..Candidate::default() };
                contacts.columns(1).0.sort(&network);
                count = 1;
            }
            let speeds = |network: &Network<'_>, i: usize| [0, 1, 2].map(|ply| network.node(i, ply * rows + row).1[2]);
            let before = columns.map(|i| speeds(&network, i));
            let early = EarlyRows::of(&network, contacts.found(count));
            let mut sums = Sums::NOTHING;
            let mut separation = Separation { network: &mut network, contacts: &mut contacts, sums: &mut sums, count };
            separation.early(&early, [0, rows]);
            assert_eq!(separation.sums.ply_loss > 0.0, !is_pushed, "the row of a candidate waits");
            separation.others(&early);
            let mut lost = 0.0;
            for (i, before) in columns.into_iter().zip(before) {
                let sum = |of: [f64; 3]| masses.iter().zip(of).map(|(mass, of)| mass * of).sum::<f64>();
                let common = sum(before) / masses.iter().sum::<f64>();
                assert!(speeds(&network, i).iter().all(|speed| (speed - common).abs() < 1e-15), "column {i}");
                lost +=
                    0.5 * sum(before.map(|speed| speed * speed)) - 0.5 * masses.iter().sum::<f64>() * common * common;
            }
            let lost = lost * network.model.unit_energy;
            assert!((sums.ply_loss - lost).abs() < 1e-12 * lost, "{} {lost}", sums.ply_loss);
            assert!(network.node(4, row).1 == [0.0; 3]);
        }
    }
}
