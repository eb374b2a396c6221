//! Separate plies that push on each other: unilateral impulses between facing nodes, restitution zero, without friction.
//!
//! Method: node (i, j) of a ply faces node (i, j) of the next one, and impulses along the sheet's normal z keep their order. The
//! nodes of one place in all plies are a column. Masses are those of the fabrics, over a node's of the front one. Their velocities after contact are the nearest ones to those before (least
//! sum of m dv^2) with which no facing pair ends nearer than 0, or nearer than it was if it was through each other. That is an isotonic
//! regression of the velocities with the gaps over dt added up, solved exactly by pooling neighbours that press on each other.
//! So momentum is kept, no energy is ever added (no relative motion at all would be allowed, too), and the order of nodes does not matter.
//! With the projectile: the impulses of its candidates (`contact.rs`) and the columns are found in turn. A node that is pressed together with
//! others has their common mass along z; the pools are those of the columns' last solution, and the turns end when it no longer changes. If
//! they do not end, the same turns are taken with single masses and one sweep each, in which every impulse is an exact step of the
//! common dual problem: they may stop at any time without adding energy, and are counted as unconverged if they have to.
//! Energy: impulse times the mean of the velocities at t_{n-1/2} and t_{n+1/2}, as everywhere, is the loss where plies meet.
//! Limits: nodes face nodes along z. The moment of an impulse between nodes that are displaced along the sheet is not kept: it is that
//! offset times the impulse. A pair that is more than a spacing apart along the sheet does not touch; so plies may pass through each other at
//! a hole, and `ply_penetration` tells how deep pairs were that came to face each other again. All plies of a column are free or all are
//! fixed. Velocity Verlet, no mirror planes. Columns are not shared out among bands.
//! Reference: R. E. Barlow, D. J. Bartholomew, J. M. Bremner, H. D. Brunk, Statistical Inference under Order Restrictions (1972), pool
//! adjacent violators; M. J. Best, N. Chakravarti, Math. Programming 47 (1990) 425; J. J. Moreau as in `contact.rs`.

use crate::blocks::Blocks;
use crate::contact::{Candidate, Solved};
use crate::lanes::{self, Job, Lane};
use crate::layout::{CANDIDATE_REALS, COLUMN_REALS, POOLED_REALS};
use crate::math;
use crate::planes::{self, CHUNK, Chunk, HOT_PLANES};
use crate::pose::Vector;
use crate::projectile::Inertia;
use crate::system::System;

/// Turns of projectile and columns with pooled masses after which they are begun again with single ones.
const MAX_TURNS: u32 = 24;
/// Turns with single masses after which a solve is given up and counted.
const MAX_SINGLE_TURNS: u32 = 30;
/// Sweeps over the candidates in a turn with pooled masses.
const MAX_SWEEPS: u32 = 6;
/// The columns agree with the last turn if no velocity differs by more than this, spacings a pass.
const AGREED: f64 = 1e-8;
/// Sweeps end when no velocity changes by more than this, spacings a pass.
const SETTLED: f64 = 1e-9;
/// Nodes that part by less than this, spacings a pass, are one pool while the projectile's impulses are sought: else what
/// rounding leaves of plies that move alike would make another set of pools in every turn.
const TIED: f64 = 2e-9;
/// Share of a node's give by which candidates of one pool are kept apart.
const EVEN: f64 = 1e-7;
/// Steps for the common speed of a pool.
const MAX_NEWTON: u32 = 30;
/// No candidate.
const NONE: u32 = u32::MAX;

// Numbers of a node in a column.
/// Velocity along z, spacings a pass: before, then after.
const SPEED: usize = 0;
/// By how much it may come nearer to the node before it in this pass, spacings; infinite if they do not face each other.
const ROOM: usize = 1;
/// Of the n-th pool: mean velocity with the rooms added up, number of nodes, and mass.
const MEAN: usize = 2;
const COUNT: usize = 3;
const MASS: usize = 7;
/// First node of the pool that the node belongs to, and the pool's mass.
const FIRST: usize = 4;
const SIZE: usize = 5;
/// Its mass.
const SHARE: usize = 6;

// What the plies do to a candidate.
/// Velocity along z that its column gives it at the last solution of the columns, with its own impulse, m/s.
const LIFT: usize = 0;
/// Of the candidate that keeps the numbers of a pool: velocity that impulses have given the pool since then, m/s.
const SHIFT: usize = 1;
/// Mass of its pool.
const POOL_SIZE: usize = 2;
/// Its impulse at the last turn, N s.
const LAST: usize = 3;
/// 1/m of its node, 1/kg.
const GIVE: usize = 4;

/// Takes the velocities along z in a column apart, so that no two facing nodes come nearer than they may. Neighbours that part by no more
/// than `tied`, spacings a pass, stay together.
fn project(column: &mut [[f64; COLUMN_REALS]], tied: f64) {
    // Pool n stands at place n, which is never behind the nodes read so far.
    let (mut pools, mut first, mut rooms) = (0, 0, 0.0);
    for k in 0..column.len() {
        let Some(&[speed, room, .., share, _]) = column.get(k) else { return };
        if room == f64::INFINITY {
            (first, rooms) = (pools, 0.0);
        } else {
            rooms += room;
        }
        let (mut mean, mut count, mut mass) = (speed + rooms, 1.0, share);
        while pools > first {
            let Some(&[_, _, below, nodes, .., more]) = column.get(pools - 1) else { return };
            if below <= mean - tied {
                break;
            }
            mean = (below * more + mean * mass) / (more + mass);
            (count, mass) = (count + nodes, mass + more);
            pools -= 1;
        }
        let Some(place) = column.get_mut(pools) else { return };
        (place[MEAN], place[COUNT], place[MASS]) = (mean, count, mass);
        pools += 1;
    }
    let mut start = 0;
    rooms = 0.0;
    for pool in 0..pools {
        let Some(&[_, _, mean, count, .., mass]) = column.get(pool) else { return };
        for node in column.iter_mut().skip(start).take(count as usize) {
            rooms = if node[ROOM] == f64::INFINITY { 0.0 } else { rooms + node[ROOM] };
            if count > 1.0 {
                node[SPEED] = mean - rooms;
            }
            (node[FIRST], node[SIZE]) = (start as f64, mass);
        }
        start += count as usize;
    }
}

/// Displacement and velocity along z of node i of a row, and its displacements along the sheet.
fn motion(row: &[Chunk<HOT_PLANES>], i: usize) -> [f64; 4] {
    let lane = i % CHUNK;
    row.get(i / CHUNK).map_or([0.0; 4], |chunk| [chunk[0][lane], chunk[1][lane], chunk[2][lane], chunk[5][lane]])
}

/// Puts the nodes at a place of the sheet into the column, as the sweep left them. Returns how deep facing ones are through each
/// other at the pass's start, spacings; 0 if none is.
fn load(system: &mut System<'_>, i: usize, row: usize) -> f64 {
    let (rows, chunks, gap) = (system.layout.y.modelled(), system.layout.chunks, system.model.gap);
    let rise = system.directions.front.vertical.rest.spacing;
    let shares = [1.0, system.model.back_share];
    let System { directions, blocks: Blocks { hot, column, .. }, .. } = system;
    let (mut below, mut deepest): (Option<[f64; 4]>, f64) = (None, 0.0);
    for (ply, place) in column.iter_mut().enumerate() {
        let here = motion(planes::row(hot, chunks, ply * rows + row), i);
        let [x, y, z, v] = here;
        let room = match below {
            Some([x_below, y_below, z_below, v_below])
                if math::abs(x - x_below) <= 1.0 && math::abs(y - y_below) <= rise =>
            {
                let start = gap + (z - z_below) - (v - v_below);
                deepest = math::max(-start, deepest);
                math::max(start, 0.0)
            }
            _ => f64::INFINITY,
        };
        *place = [v, room, 0.0, 0.0, 0.0, 0.0, shares[usize::from(directions.is_back(ply))], 0.0];
        below = Some(here);
    }
    deepest
}

/// Parts the plies behind the sweep and the projectile's impulses. `count`: candidates.
pub(crate) fn part(system: &mut System<'_>, count: usize) {
    // The books of contact take the velocities that nodes have at the end of the pass.
    let before = half_work(system, count);
    for row in 0..system.layout.y.modelled() {
        for ply in 1..system.layout.plies {
            part_rows(system, ply, row);
        }
    }
    system.state.sums.loss -= half_work(system, count) - before;
}

/// Half of what the projectile's impulses do with the present velocities of their nodes, J.
fn half_work(system: &System<'_>, count: usize) -> f64 {
    let mut work = 0.0;
    for c in 0..count {
        let (Some(slot), Some(&node)) = (system.blocks.candidates.get(c), system.blocks.candidate_nodes.get(c)) else {
            break;
        };
        let candidate = Candidate::read(slot);
        if candidate.impulse > 0.0 && !candidate.is_fixed() {
            let (i, j) = system.layout.column_and_row(node as usize);
            work += 0.5 * candidate.impulse * candidate.normal.dot(&system.velocity(i, j));
        }
    }
    work
}

/// Parts the columns of one row in which this ply presses on the one before it.
fn part_rows(system: &mut System<'_>, ply: usize, row: usize) {
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
        let pressed = Pressed {
            below: planes::row(system.blocks.hot, chunks, below.0),
            above: planes::row(system.blocks.hot, chunks, above.0),
            gap: system.model.gap,
            from,
        };
        let Some(chunk) = lanes::dispatch(system.instructions, pressed) else { return };
        from = chunk + 1;
        for i in chunk * CHUNK..(from * CHUNK).min(system.layout.nodes_x) {
            if !system.is_fixed(i, row) {
                part_column(system, i, row);
            }
        }
    }
}

/// The first chunk of a row, from number `from` on, in which a node ends below the one that it faces below and comes nearer to it.
struct Pressed<'a> {
    below: &'a [Chunk<HOT_PLANES>],
    above: &'a [Chunk<HOT_PLANES>],
    gap: f64,
    from: usize,
}

impl Job for Pressed<'_> {
    type Output = Option<usize>;

    #[inline(always)]
    fn run<L: Lane>(self) -> Option<usize> {
        let (gap, zero) = (L::splat(self.gap), L::splat(0.0));
        for (c, (below, above)) in self.below.iter().zip(self.above).enumerate().skip(self.from) {
            for g in 0..CHUNK / L::WIDTH {
                let at = |chunk: &Chunk<HOT_PLANES>, plane: usize| L::load(&L::groups(&chunk[plane])[g]);
                let end = at(above, 2).sub(at(below, 2)).add(gap);
                if zero.any_above(end.max(at(above, 5).sub(at(below, 5)))) {
                    return Some(c);
                }
            }
        }
        None
    }
}

/// Parts one column of free nodes.
fn part_column(system: &mut System<'_>, i: usize, row: usize) {
    let (rows, chunks, layout) = (system.layout.y.modelled(), system.layout.chunks, system.layout);
    let deepest = load(system, i, row) * system.scene.sheet.spacing;
    system.state.sums.ply_penetration = math::max(deepest, system.state.sums.ply_penetration);
    project(system.blocks.column, 0.0);
    let (mut lost, mut viscous) = (0.0, 0.0);
    for ply in 0..layout.plies {
        let j = ply * rows + row;
        let Blocks { hot, column, before, pushes, .. } = &mut system.blocks;
        let [speed, share] = column.get(ply).map_or([0.0, 1.0], |place| [place[SPEED], place[SHARE]]);
        let (Some(chunk), Some(before)) =
            (planes::row_mut(hot, chunks, j).get_mut(i / CHUNK), before.get(j * chunks + i / CHUNK))
        else {
            return;
        };
        let lane = i % CHUNK;
        let push = speed - chunk[5][lane];
        if push == 0.0 {
            continue;
        }
        chunk[5][lane] = speed;
        chunk[2][lane] += push;
        lost -= share * (push * (0.5 * (before[lane] + speed)));
        if layout.viscous {
            // The sweep has booked the viscous push as if the node went on with the velocity before the impulse.
            viscous -= share * 0.5 * push * planes::get(planes::row(pushes, chunks, j), 2, i).unwrap_or(0.0);
        }
        system.wake(j);
    }
    system.state.sums.ply_loss += lost * system.model.unit_energy;
    system.state.sums.viscous += viscous * system.model.unit_energy;
}

/// The impulses of the first `count` candidates of a stack: [`crate::contact::solve`] together with the columns.
#[inline(never)] // It must not add to the stack of a single sheet's solve.
pub(crate) fn solve(system: &mut System<'_>, count: usize) -> Solved {
    link(system, count);
    let pooled = take_turns::<true>(system, count);
    if pooled.converged { pooled } else { take_turns::<false>(system, count) }
}

/// The place of a candidate's node in the sheet: column, row and ply.
fn place(system: &System<'_>, c: usize) -> (usize, usize, usize) {
    let node = system.blocks.candidate_nodes.get(c).copied().unwrap_or(0);
    let (i, j) = system.layout.column_and_row(node as usize);
    let (ply, row) = system.layout.ply_and_row(j);
    (i, row, ply)
}

/// Links the candidates of each column of free nodes, the last one first.
fn link(system: &mut System<'_>, count: usize) {
    for clear in [true, false] {
        for c in 0..count {
            let (i, row, _) = place(system, c);
            let (fixed, at) = (system.is_fixed(i, row), row * system.layout.nodes_x + i);
            let Blocks { last, links, .. } = &mut system.blocks;
            let (Some(last), Some(link)) = (last.get_mut(at), links.get_mut(c)) else { return };
            if clear {
                (*last, *link) = (NONE, [NONE, c as u32]);
            } else if !fixed {
                link[0] = *last;
                *last = c as u32;
            }
        }
    }
}

/// The candidate of the same column that is linked behind one.
fn behind(system: &System<'_>, c: usize) -> Option<usize> {
    system.blocks.links.get(c).map(|link| link[0]).filter(|&next| next != NONE).map(|next| next as usize)
}

/// Projectile and columns in turn, from no impulse. POOLED: nodes that press on each other have their common mass; else every node
/// its own, and the projectile one sweep a turn.
#[inline(never)] // Once on the stack, not twice.
fn take_turns<const POOLED: bool>(system: &mut System<'_>, count: usize) -> Solved {
    let body = system.state.body;
    let mut solved =
        Solved { sweeps: 0, converged: false, velocity: body.velocity, angular_velocity: body.angular_velocity };
    for c in 0..count {
        let (_, _, ply) = place(system, c);
        let share = system.mass_share(ply);
        let Blocks { candidates, pooled, links, .. } = &mut system.blocks;
        if let (Some([.., impulse]), Some(pool), Some(link)) =
            (candidates.get_mut(c), pooled.get_mut(c), links.get_mut(c))
        {
            (*impulse, *pool, link[1]) =
                (0.0, [0.0, 0.0, share, 0.0, 1.0 / (system.model.node_mass * share)], c as u32);
        }
    }
    let (mut settled, turns) = (false, if POOLED { MAX_TURNS } else { MAX_SINGLE_TURNS });
    for turn in 0..turns {
        let changed = solve_columns::<POOLED>(system, count);
        if turn > 0 && settled && changed <= AGREED * system.model.unit_speed {
            solved.converged = true;
            break;
        }
        let from = (solved.velocity, solved.angular_velocity);
        let inertia = system.model.inertia;
        let Blocks { candidates, pooled, links, .. } = &mut system.blocks;
        let mut sweep = Sweep {
            candidates: candidates.get_mut(..count).unwrap_or(&mut []),
            pooled,
            links,
            inertia: &inertia,
            give: 1.0 / system.model.node_mass,
            tolerance: SETTLED * system.model.unit_speed,
            first: true,
            turns: solved.angular_velocity != Vector::zeros() || inertia.inverse_moments != Vector::zeros(),
            velocity: solved.velocity,
            rate: solved.angular_velocity,
        };
        let most = if POOLED { MAX_SWEEPS } else { 1 };
        let mut sweeps = 0;
        settled = false;
        while sweeps < most && !settled {
            settled = sweep.run() <= sweep.tolerance;
            sweep.first = false;
            sweeps += 1;
        }
        (solved.velocity, solved.angular_velocity) = (sweep.velocity, sweep.rate);
        solved.sweeps = solved.sweeps.max(sweeps);
        // Turns may go round in a circle between two sets of pools: every other one goes half the way only.
        let half = POOLED && turn > 2 && turn % 2 == 1 && changed > AGREED * system.model.unit_speed;
        let share = 2.0 / f64::from(turn + 1);
        if half {
            solved.velocity = from.0 + (solved.velocity - from.0) * share;
            solved.angular_velocity = from.1 + (solved.angular_velocity - from.1) * share;
            settled = false;
        }
        let Blocks { candidates, pooled, .. } = &mut system.blocks;
        for (slot, pool) in candidates.iter_mut().zip(pooled.iter_mut()).take(count) {
            let [.., impulse] = slot;
            if half {
                *impulse = pool[LAST] + share * (*impulse - pool[LAST]);
            }
            pool[LAST] = *impulse;
        }
    }
    solved
}

/// Solves every column with a candidate for the present impulses. Returns the largest change, m/s, against what the sweeps since
/// the last time have made of it.
fn solve_columns<const POOLED: bool>(system: &mut System<'_>, count: usize) -> f64 {
    let (unit_speed, unit_impulse) = (system.model.unit_speed, system.model.unit_impulse);
    let mut largest = 0.0;
    for c in 0..count {
        let (i, row, _) = place(system, c);
        if system.blocks.last.get(row * system.layout.nodes_x + i) != Some(&(c as u32)) {
            continue;
        }
        load(system, i, row);
        let mut next = Some(c);
        while let Some(k) = next {
            let (_, _, ply) = place(system, k);
            let Blocks { candidates, column, .. } = &mut system.blocks;
            if let (Some(node), Some(slot)) = (column.get_mut(ply), candidates.get(k)) {
                let candidate = Candidate::read(slot);
                node[SPEED] += candidate.impulse * candidate.normal.z / (unit_impulse * node[SHARE]);
            }
            next = behind(system, k);
        }
        project(system.blocks.column, TIED);
        // The place of a pool's mean now keeps the pool's candidate.
        system.blocks.column.iter_mut().for_each(|node| node[MEAN] = -1.0);
        next = Some(c);
        while let Some(k) = next {
            let (_, _, ply) = place(system, k);
            let (_, free) = system.node(i, ply * system.layout.y.modelled() + row);
            let Blocks { column, pooled, links, .. } = &mut system.blocks;
            let kept = links.get(k).map_or(k, |link| link[1] as usize);
            let shift = pooled.get(kept).map_or(0.0, |pool| pool[SHIFT]);
            if let (Some(node), Some(pool)) = (column.get(ply), pooled.get_mut(k)) {
                let lift = (node[SPEED] - free[2]) * unit_speed;
                largest = math::max(math::abs(lift - (pool[LIFT] + shift)), largest);
                pool[LIFT] = lift;
            }
            next = behind(system, k);
        }
        next = Some(c);
        while let Some(k) = next {
            let (_, _, ply) = place(system, k);
            let Blocks { column, pooled, links, .. } = &mut system.blocks;
            let [first, size] = column.get(ply).map_or([0.0, 1.0], |node| [node[FIRST], node[SIZE]]);
            if let (Some(head), Some(pool), Some(link)) =
                (column.get_mut(first as usize), pooled.get_mut(k), links.get_mut(k))
            {
                if head[MEAN] < 0.0 {
                    head[MEAN] = k as f64;
                }
                pool[SHIFT] = 0.0;
                if POOLED {
                    (pool[POOL_SIZE], link[1]) = (size, head[MEAN] as u32);
                }
            }
            next = behind(system, k);
        }
    }
    largest
}

/// Gauss-Seidel over the candidates, with the columns as they were solved last.
struct Sweep<'s> {
    candidates: &'s mut [[f64; CANDIDATE_REALS]],
    pooled: &'s mut [[f64; POOLED_REALS]],
    links: &'s [[u32; 2]],
    inertia: &'s Inertia,
    /// 1/m of a node of the front fabric, 1/kg.
    give: f64,
    /// A change of speed that does not count, m/s.
    tolerance: f64,
    /// Whether this is the first sweep of a turn.
    first: bool,
    /// Whether the body turns, now or by contact.
    turns: bool,
    velocity: Vector,
    rate: Vector,
}

impl Sweep<'_> {
    /// One sweep over the pools with candidates. Returns the largest change of a speed, m/s.
    fn run(&mut self) -> f64 {
        let mut largest = 0.0;
        for c in 0..self.candidates.len() {
            if self.links.get(c).is_some_and(|link| link[1] == c as u32) {
                let change = self.visit(c);
                largest = math::max(change, largest);
            }
        }
        largest
    }

    /// The candidate of the same pool that is linked behind one.
    fn next(&self, c: usize, kept: usize) -> Option<usize> {
        let mut next = self.links.get(c)?[0];
        while next != NONE {
            let link = self.links.get(next as usize)?;
            if link[1] == kept as u32 {
                return Some(next as usize);
            }
            next = link[0];
        }
        None
    }

    /// How much the body gives way to one candidate when another pushes, 1/kg.
    fn body_give(&self, one: &Candidate, other: &Candidate) -> f64 {
        let turning = one.arm.dot(&other.arm.component_mul(&self.inertia.inverse_moments));
        one.normal.dot(&other.normal) * self.inertia.inverse_mass + turning
    }

    /// What the candidates of a pool of this size, the first of which is given, have in common.
    fn common(&self, first: &Candidate, size: f64, members: f64) -> Common {
        let (of_pool, of_body) = (if first.is_fixed() { 0.0 } else { self.give / size }, self.body_give(first, first));
        // A body gives way to one candidate as it does; to several by at most twice the sum of what they share and what they do not.
        let factor = if members > 1.0 { 2.0 } else { 1.0 };
        let up = first.normal.z;
        let steep = math::abs(up) > 0.1 && !first.is_fixed();
        let of_body_alike = if steep { factor * of_body / (up * up) } else { 0.0 };
        Common {
            first: *first,
            of_pool,
            all: of_pool + of_body_alike,
            of_body,
            apart: factor * members,
            steep,
            members,
        }
    }

    /// How much a candidate gives way besides, 1/kg: its node along the sheet, and the body as far as it is pushed in another way
    /// than by the first candidate.
    fn own_give(&self, candidate: &Candidate, give: f64, common: &Common) -> f64 {
        let normal = &candidate.normal;
        let along = normal.x * normal.x + normal.y * normal.y;
        let of_body = self.body_give(candidate, candidate);
        let of_body = if !common.steep {
            common.members * of_body
        } else if common.members == 1.0 {
            0.0
        } else {
            let share = normal.z / common.first.normal.z;
            let rest =
                of_body - 2.0 * share * self.body_give(&common.first, candidate) + share * share * common.of_body;
            common.apart * math::max(rest, 0.0)
        };
        // Candidates of one normal may share an impulse in any way: the last term lets them share it alike.
        let even = if common.members > 1.0 { EVEN } else { 0.0 };
        if candidate.is_fixed() { of_body } else { of_body + give * (along + even) }
    }

    /// The impulses of one pool's candidates that leave their gaps open, with a body that gives way a little more than it does, so that
    /// they never go too far. With s the common change of the gap rates over n_z, impulse k is max(0, lambda_k - (rate_k + n_z s)/own
    /// give): one equation for s, whose slope is at least 1.
    fn visit(&mut self, kept: usize) -> f64 {
        let Some(&[_, shift, size, ..]) = self.pooled.get(kept) else { return 0.0 };
        // In the first sweep of a turn every candidate notes its own give, in the place of its effective mass.
        let mut members = 1.0;
        let mut next = self.next(kept, kept);
        while let Some(c) = next {
            members += 1.0;
            next = self.next(c, kept);
        }
        let first = self.candidates.get(kept).map_or(Candidate::read(&NO_CANDIDATE), Candidate::read);
        let common = self.common(&first, size, members);
        if self.first {
            next = Some(kept);
            while let Some(c) = next {
                let candidate = self.candidates.get(c).map_or(Candidate::read(&NO_CANDIDATE), Candidate::read);
                let own = self.pooled.get(c).map_or(self.give, |pool| pool[GIVE]);
                let give = self.own_give(&candidate, own, &common);
                if let Some([.., place, _]) = self.candidates.get_mut(c) {
                    *place = give;
                }
                next = if members > 1.0 { self.next(c, kept) } else { None };
            }
        }
        let speed = self.common_speed(kept, shift, &common);
        let (mut largest, mut moved) = (0.0, 0.0);
        let (mut velocity, mut rate_of_body) = (self.velocity, self.rate);
        next = Some(kept);
        while let Some(c) = next {
            let (candidate, rate, give) = self.look(c, shift);
            let impulse = if members > 1.0 {
                wanted(&candidate, rate + candidate.normal.z * speed, give)
            } else {
                // Solved at once.
                wanted(&candidate, rate, give + common.all * candidate.normal.z * candidate.normal.z)
            };
            let change = impulse - candidate.impulse;
            moved += common.of_pool * candidate.normal.z * change;
            velocity -= candidate.normal * (change * self.inertia.inverse_mass);
            rate_of_body -= candidate.arm.component_mul(&self.inertia.inverse_moments) * change;
            largest = math::max(math::abs(change) * (give + common.of_pool), largest);
            next = if members > 1.0 { self.next(c, kept) } else { None };
            if let Some([.., place]) = self.candidates.get_mut(c) {
                *place = impulse;
            }
        }
        (self.velocity, self.rate) = (velocity, rate_of_body);
        if let Some(pool) = self.pooled.get_mut(kept) {
            pool[SHIFT] += moved;
        }
        let moved = math::abs(moved);
        math::max(moved, largest)
    }

    /// The common change s of a pool with several candidates, m/s, by Newton steps: the equation is made of straight pieces.
    fn common_speed(&self, kept: usize, shift: f64, common: &Common) -> f64 {
        let mut speed = 0.0;
        for _ in 0..if common.members > 1.0 { MAX_NEWTON } else { 0 } {
            let (mut error, mut slope) = (speed, 1.0);
            let mut next = Some(kept);
            while let Some(c) = next {
                let (candidate, rate, give) = self.look(c, shift);
                let impulse = wanted(&candidate, rate + candidate.normal.z * speed, give);
                error -= common.all * candidate.normal.z * (impulse - candidate.impulse);
                if impulse > 0.0 {
                    slope += common.all * candidate.normal.z * candidate.normal.z / give;
                }
                next = self.next(c, kept);
            }
            let step = error / slope;
            speed -= step;
            if math::abs(step) <= 1e-9 * self.tolerance {
                break;
            }
        }
        speed
    }

    /// A candidate, its gap rate with the pool's motion so far, and its own give.
    fn look(&self, c: usize, shift: f64) -> (Candidate, f64, f64) {
        let candidate = self.candidates.get(c).map_or(Candidate::read(&NO_CANDIDATE), Candidate::read);
        let [lift, own] = self.pooled.get(c).map_or([0.0, self.give], |pool| [pool[LIFT], pool[GIVE]]);
        let normal = &candidate.normal;
        let along = normal.x * normal.x + normal.y * normal.y;
        let of_plies = along * candidate.impulse * own + normal.z * (lift + shift);
        let rate = if self.turns {
            candidate.gap_rate(&self.velocity, &self.rate)
        } else {
            candidate.approach - normal.dot(&self.velocity)
        };
        (candidate, if candidate.is_fixed() { rate } else { rate + of_plies }, candidate.effective_mass)
    }
}

/// What the candidates of a pool have in common.
struct Common {
    first: Candidate,
    /// Give of the pool along z, 1/kg.
    of_pool: f64,
    /// With that of the body, over n_z^2 of the first candidate.
    all: f64,
    /// Give of the body to the first candidate, 1/kg.
    of_body: f64,
    /// Factor of what the body gives besides.
    apart: f64,
    /// Whether the first normal is far enough from the sheet's plane for this.
    steep: bool,
    members: f64,
}

/// A place without a candidate.
const NO_CANDIDATE: [f64; CANDIDATE_REALS] = [0.0; CANDIDATE_REALS];

/// The impulse that a gap rate asks for.
fn wanted(candidate: &Candidate, rate: f64, give: f64) -> f64 {
    if give == 0.0 {
        // A fixed node and a prescribed body.
        return 0.0;
    }
    let trial = candidate.impulse - rate / give;
    math::max(trial, 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// Numbers from -1 to 1 without visible order.
    fn number(k: u64) -> f64 {
        2.0 * (crate::random::splitmix64(k) >> 11) as f64 / (1u64 << 53) as f64 - 1.0
    }

    fn column(nodes: &[[f64; 2]]) -> Vec<[f64; COLUMN_REALS]> {
        nodes.iter().map(|&[speed, room]| [speed, room, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]).collect()
    }

    fn speeds(column: &[[f64; COLUMN_REALS]]) -> Vec<f64> {
        column.iter().map(|node| node[SPEED]).collect()
    }

    #[test]
    fn a_falling_ply_takes_along_what_it_meets() {
        let far = f64::INFINITY;
        // One that comes from below takes along all that touches; one of them is a gap away that it does not reach.
        let mut pushed = column(&[[1.0, far], [0.0, 0.0], [0.0, 0.0], [0.0, 0.5]]);
        project(&mut pushed, 0.0);
        for (speed, expected) in speeds(&pushed).into_iter().zip([1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 0.0]) {
            assert!((speed - expected).abs() < 1e-15);
        }
        // Across a gap of 0.5: both end at one place.
        let mut met = column(&[[1.0, far], [0.0, 0.5]]);
        project(&mut met, 0.0);
        assert_eq!(speeds(&met), [0.75, 0.25]);
        // Nodes that do not face each other pass.
        let mut beside = column(&[[1.0, far], [0.0, far], [-1.0, 0.0]]);
        project(&mut beside, 0.0);
        assert_eq!(speeds(&beside), [1.0, -0.5, -0.5]);
        // Nodes that part are left alone.
        let parting = [[-1.0, far], [0.0, 0.0], [2.0, 0.3]];
        let mut apart = column(&parting);
        project(&mut apart, 0.0);
        assert_eq!(speeds(&apart), [-1.0, 0.0, 2.0]);
        assert!(apart.iter().enumerate().all(|(k, node)| node[FIRST] == k as f64 && node[SIZE] == 1.0));
    }

    /// The conditions that make a solution the nearest one: no pair nearer than it may be, no impulse that pulls, none across a
    /// pair that is not as near as it may be. And so momentum is kept, and energy is never added.
    #[test]
    fn columns_are_solved_exactly() {
        for case in 0..2000 {
            let draw = |k: u64| number(1000 * case + k);
            let count = 2 + (case % 60);
            let nodes: Vec<[f64; 2]> = (0..count)
                .map(|k| {
                    let room = if k == 0 || draw(3 * k) > 0.95 { f64::INFINITY } else { draw(3 * k + 1).max(0.0) };
                    [draw(3 * k + 2), room]
                })
                .collect();
            let mut solved = column(&nodes);
            project(&mut solved, 0.0);
            let mut impulse = 0.0;
            let (mut before, mut after) = (0.0, 0.0);
            for (k, (node, [speed, room])) in solved.iter().zip(&nodes).enumerate() {
                // The impulse between this node and the one below it: what those below have lost.
                if k > 0 {
                    let nearer = solved[k - 1][SPEED] - node[SPEED];
                    assert!(nearer <= room + 1e-12 && impulse > -1e-12, "{case} {k}");
                    assert!(impulse < 1e-12 || (nearer - room).abs() < 1e-12, "{case} {k}");
                }
                impulse += speed - node[SPEED];
                (before, after) = (before + speed * speed, after + node[SPEED] * node[SPEED]);
            }
            assert!(impulse.abs() < 1e-12 && after <= before + 1e-12, "{case}");
        }
    }
}
