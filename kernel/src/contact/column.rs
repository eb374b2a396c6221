//! A column: the nodes of one place of the sheet in all plies, their velocities along z, and what the
//! projectile does to those that are candidates. Axes x, y and z of a curved sheet are here those of the
//! column at rest: along the hoop, along the axis, and outwards.
//!
//! Method: the velocities after contact are the nearest ones to those before (least sum of m dv^2) with which
//! no facing pair ends nearer than 0, or nearer than it was if it was through each other. That is an isotonic
//! regression of the velocities with the gaps over dt added up, solved exactly by pooling neighbours that
//! press on each other. At given rates of the body a candidate is a spring of one-sided force on its node:
//! each pool moves by the root of a sum of straight pieces.
//! Limits: nodes face each other along z alone; `MAX_NEWTON` steps for the speed of a pool.
//! Reference: R. E. Barlow, D. J. Bartholomew, J. M. Bremner, H. D. Brunk, Statistical Inference under Order
//! Restrictions (1972), pool adjacent violators; M. J. Best, N. Chakravarti, V. A. Ubhaya, SIAM J. Optim. 10
//! (2000) 658, of sums of convex functions.

use crate::ground::math;
use crate::ground::planes::{self, CHUNK};
use crate::memory::arrays::Contacts;
use crate::memory::network::Network;
use crate::memory::records::{Node, Pool};
use crate::sheet::ring;

/// Mass of a held node of a column, over that of a node of the front fabric: no sum with the others changes.
pub(super) const HELD: f64 = 1e30;

/// Steps for the speed of a pool with candidates; in each at least one of them lets go or is met.
const MAX_NEWTON: u32 = 60;

impl Pool {
    /// Pool of no node.
    const NONE: Pool = Pool { sum: 0.0, weight: 0.0, mean: 0.0, limits: [-f64::INFINITY, f64::INFINITY], nodes: 0.0 };

    /// Pool of one node, which is alone.
    fn of(node: &Node) -> Pool {
        let speed = node.speed + node.offset;
        let mut pool = Pool { mean: speed, ..Pool::NONE };
        pool.add(node, speed);
        pool.mean = if node.stiffness == 0.0 { speed } else { pool.sum / pool.weight };
        pool
    }

    /// Adds a node, whose candidate is pressed if it is at this velocity.
    fn add(&mut self, node: &Node, speed: f64) {
        let Node { mass, stiffness, offset, .. } = *node;
        (self.sum, self.weight, self.nodes) =
            (self.sum + mass * (node.speed + offset), self.weight + mass, self.nodes + 1.0);
        if stiffness == 0.0 {
            return;
        }
        let (release, [low, high]) = (node.release + offset, self.limits);
        self.limits = if speed < release { [low, math::min(release, high)] } else { [math::max(release, low), high] };
        if is_pressed(stiffness, release - speed) {
            (self.sum, self.weight) = (self.sum + math::abs(stiffness) * release, self.weight + math::abs(stiffness));
        }
    }

    /// This one and the next one together.
    fn with(&self, next: &Pool) -> Pool {
        let ([a, b], [c, d]) = (self.limits, next.limits);
        let (sum, weight) = (self.sum + next.sum, self.weight + next.weight);
        let nodes = self.nodes + next.nodes;
        Pool { sum, weight, mean: sum / weight, limits: [math::max(a, c), math::min(b, d)], nodes }
    }

    /// Whether just those candidates are pressed that it takes for pressed.
    fn is_consistent(&self) -> bool {
        self.limits[0] <= self.mean && self.mean <= self.limits[1]
    }

    /// The pool of these nodes, whose velocity is sought from that of this one: Newton steps on a straight
    /// piece each, kept between velocities that are known to be too small and too great.
    #[cold]
    fn solved(&self, nodes: &[Node]) -> Pool {
        let (mut pool, mut speed, [mut low, mut high]) = (*self, self.mean, [-f64::INFINITY, f64::INFINITY]);
        for _ in 0..MAX_NEWTON {
            pool = Pool::NONE;
            nodes.iter().for_each(|node| pool.add(node, speed));
            pool.mean = pool.sum / pool.weight;
            if pool.is_consistent() || pool.mean == speed {
                break;
            }
            [low, high] = if pool.mean < speed { [low, speed] } else { [speed, high] };
            speed = if low < pool.mean && pool.mean < high { pool.mean } else { 0.5 * (low + high) };
        }
        pool
    }
}

/// Whether a node of this stiffness is a pressed candidate, if its velocity is so much less than at its
/// release.
fn is_pressed(stiffness: f64, less: f64) -> bool {
    if stiffness > 0.0 { less > 0.0 } else { stiffness < 0.0 && less < 0.0 }
}

/// Column: nodes of one place of the sheet in all plies, and room for as many pools.
pub(super) struct Column<'c> {
    pub nodes: &'c mut [Node],
    pub pools: &'c mut [Pool],
}

impl Contacts<'_> {
    /// The column of nodes and its pools.
    pub(super) fn column(&mut self) -> Column<'_> {
        Column { nodes: self.nodes_of_column, pools: self.pools }
    }
}

impl Column<'_> {
    /// Takes the nodes at a place of the sheet as the sweep left them, those that a clamp holds with the mass
    /// [`HELD`]. Returns the greatest depth of facing nodes in each other at the step's start, spacings, 0
    /// if there is none; and whether any press on each other before the projectile does.
    pub fn load(&mut self, network: &Network<'_>, i: usize, row: usize) -> (f64, bool) {
        let Network { layout, model, directions, arrays, .. } = network;
        let (lane, rows) = (i % CHUNK, &arrays.rows);
        let (gap, rise) = (model.gap, directions.front.vertical.rest.spacing);
        let shares = [1.0, model.back_share];
        let [mut at, next] = layout.stacked(i, row);
        let normal = network.normal(i);
        let own = |v: [f64; 3]| normal.map_or(v, |normal| ring::column_axes(v, normal));
        let (mut below, mut deepest): (Option<[f64; 4]>, f64) = (None, 0.0);
        let (mut offset, mut speed_below, mut presses) = (0.0, -f64::INFINITY, false);
        for (ply, place) in self.nodes.iter_mut().enumerate() {
            let Some(chunk) = rows.hot.get(at) else { break };
            at += next;
            let ([x, y, z], [a, b, v]) = (own(planes::displacement(chunk, lane)), own(planes::velocity(chunk, lane)));
            // Where it was at the step's start: the projectile's impulses must not change who faces whom.
            let (x, y) = (x - a, y - b);
            let mut allowed = f64::INFINITY;
            if let Some([x_below, y_below, z_below, v_below]) = below
                && math::abs(x - x_below) <= 1.0
                && math::abs(y - y_below) <= rise
            {
                let start = gap + (z - z_below) - (v - v_below);
                deepest = math::max(-start, deepest);
                allowed = math::max(start, 0.0);
                offset += allowed;
            } else {
                (offset, speed_below) = (0.0, -f64::INFINITY);
            }
            let speed = v + offset;
            presses |= speed_below > speed;
            speed_below = speed;
            let held = network.is_held_by_clamp(i, ply * layout.y.modelled() + row);
            let mass = if held { HELD } else { shares[usize::from(directions.is_back(ply))] };
            *place = Node { before: v, speed: v, gap: allowed, offset, mass, release: v, ..Node::default() };
            below = Some([x, y, z, v]);
        }
        (deepest, presses)
    }

    /// Pool adjacent violators: nearest velocities with speed + offset non-decreasing, and the projectile's
    /// impulses on the candidates at these velocities.
    pub fn project(&mut self) {
        project(self.nodes, self.pools);
    }

    /// Nodes as they were loaded.
    pub fn restart(&mut self) {
        for node in &mut *self.nodes {
            (node.speed, node.stiffness, node.push) = (node.before, 0.0, 0.0);
        }
    }

    /// Sets the pool stiffness of the nodes of a column that was solved without candidates: the pool's mass
    /// and its nodes' positive stiffnesses.
    pub fn set_pool_stiffness(&mut self) {
        each_pool(self.nodes, self.pools, |nodes, pool| {
            let sum = nodes.iter().fold(pool.weight, |held, node| held + math::max(node.stiffness, 0.0));
            nodes.iter_mut().for_each(|node| node.pool_stiffness = sum);
        });
    }

    /// Sets the pool velocity change of the nodes: the pool's, if its nodes get the impulses `push` and, for
    /// each change of velocity, less by `stiffness`.
    pub fn set_pool_velocity_change(&mut self) {
        each_pool(self.nodes, self.pools, |nodes, pool| {
            let sums = |[push, held]: [f64; 2], node: &Node| [push + node.push, held + node.stiffness];
            let [push, held] = nodes.iter().fold([0.0, pool.weight], sums);
            let change = if math::abs(held) > 1e-9 * pool.weight { push / held } else { 0.0 };
            nodes.iter_mut().for_each(|node| node.pool_velocity_change = change);
        });
    }
}

/// [`Column::project`].
fn project(column: &mut [Node], pools: &mut [Pool]) {
    // First pool of the nodes that face each other, among those so far.
    let (mut count, mut first, mut offset) = (0, 0, 0.0);
    for k in 0..column.len() {
        let Some(node) = column.get_mut(k) else { return };
        if node.gap == f64::INFINITY {
            (first, offset) = (count, 0.0);
        } else {
            offset += node.gap;
        }
        node.offset = offset;
        let mut pool = Pool::of(node);
        while count > first {
            let Some(below) = pools.get(count - 1) else { return };
            if below.mean <= pool.mean {
                break;
            }
            pool = below.with(&pool);
            if !pool.is_consistent() {
                let start = (k + 1).saturating_sub(pool.nodes as usize);
                pool = pool.solved(column.get(start..=k).unwrap_or(&[]));
            }
            count -= 1;
        }
        let Some(place) = pools.get_mut(count) else { return };
        *place = pool;
        count += 1;
    }
    each_pool(column, pools, move_together);
}

/// The pools of a solved column and their nodes.
fn each_pool(mut column: &mut [Node], pools: &[Pool], mut each: impl FnMut(&mut [Node], &Pool)) {
    for pool in pools {
        let Some((nodes, rest)) = column.split_at_mut_checked((pool.nodes as usize).max(1)) else { return };
        each(nodes, pool);
        column = rest;
    }
}

/// Moves the nodes of a pool.
fn move_together(nodes: &mut [Node], pool: &Pool) {
    if let [node] = nodes
        && pool.weight == node.mass
    {
        // Alone, and pressed by nothing.
        return;
    }
    // What the rounding of the common velocity has left: the stiffnesses would make much of it.
    let mut rest = 0.0;
    if nodes.iter().any(|node| node.stiffness != 0.0) {
        for node in nodes.iter() {
            let speed = pool.mean - node.offset;
            let less = node.release - speed;
            rest += node.mass * (node.speed - speed);
            if is_pressed(node.stiffness, less) {
                rest += math::abs(node.stiffness) * less;
            }
        }
        rest /= pool.weight;
    }
    for node in nodes {
        node.speed = if node.mass == HELD { node.before } else { pool.mean - node.offset };
        let less = node.release - node.speed;
        if is_pressed(node.stiffness, less) {
            node.push = math::abs(node.stiffness) * (less - rest);
        }
    }
}

/// Holds the nodes back that face the first of a column where the case holds it: no lower than at this
/// velocity. Returns what the case gives them, and what that takes of their energy, from the velocities
/// `before` the sweep on, in masses of a node and units of (h/dt)^2.
pub(super) fn hold_back(column: &mut [Node], floor: f64, before: impl Fn(usize) -> f64) -> [f64; 2] {
    let (mut given, mut taken) = (0.0, 0.0);
    for (ply, node) in column.iter_mut().enumerate() {
        if ply > 0 && node.gap == f64::INFINITY || node.mass == HELD {
            break;
        }
        let lift = floor - node.offset - node.speed;
        if lift > 0.0 {
            node.speed += lift;
            given += node.mass * lift;
            taken -= node.mass * (lift * (0.5 * (before(ply) + node.speed)));
        }
    }
    [given, taken]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::number;
    use std::vec;
    use std::vec::Vec;

    /// The conditions that make a solution the nearest one: no pair nearer than it may be, no impulse that
    /// pulls, none across a pair that is not as near as it may be. And so momentum is kept, and energy is
    /// never added. Of one fabric and of two.
    #[test]
    fn columns_are_solved_exactly() {
        for case in 0..4000 {
            let draw = |k: u64| number(1000 * case + k);
            let count = 2 + (case % 60);
            let nodes: Vec<[f64; 2]> = (0..count)
                .map(|k| {
                    let room = if k == 0 || draw(3 * k) > 0.95 { f64::INFINITY } else { draw(3 * k + 1).max(0.0) };
                    [draw(3 * k + 2), room]
                })
                .collect();
            let node = |&[speed, room]: &[f64; 2]| Node { speed, gap: room, mass: 1.0, ..Node::default() };
            let mut solved: Vec<_> = nodes.iter().map(node).collect();
            let (back, of_back) = (count / 2, if case % 2 == 0 { 1.0 } else { math::exp(4.6 * draw(999)) });
            solved.iter_mut().skip(back as usize).for_each(|node| node.mass = of_back);
            project(&mut solved, &mut vec![Pool::NONE; nodes.len()]);
            let mut impulse = 0.0;
            let (mut before, mut after) = (0.0, 0.0);
            for (k, (node, [speed, room])) in solved.iter().zip(&nodes).enumerate() {
                // The impulse between this node and the one below it: what those below have lost.
                if k > 0 {
                    let nearer = solved[k - 1].speed - node.speed;
                    let rounding = 1e-12 * of_back.max(1.0);
                    assert!(nearer <= room + 1e-12 && impulse > -rounding, "{case} {k}");
                    assert!(impulse < rounding || (nearer - room).abs() < 1e-12, "{case} {k}");
                }
                let mass = node.mass;
                impulse += mass * (speed - node.speed);
                (before, after) = (before + mass * speed * speed, after + mass * node.speed * node.speed);
            }
            assert!(impulse.abs() < 1e-12 * of_back.max(1.0) && after <= before * (1.0 + 1e-12), "{case}");
        }
    }
}
