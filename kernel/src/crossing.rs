//! Segments that go slack or taut within a step: their mean force over the step instead of the force at its middle.
//!
//! Method: velocity Verlet's kick dt F(t_n) stands for the impulse from t_{n-1/2} to t_{n+1/2}. Where a segment crosses
//! q = U^2 - 1 = 0 in that window, the force has a kink in it, and what the kick misses or adds depends on where in the
//! window the kink falls: every crossing changes the energy a little at random, and a sheet that rattles slack heats. Here the
//! kick of such a segment is its mean over the window along the straight line through q_n with the slope
//! (q_{n+1} - q_{n-1})/2 per step: with d = |q_{n+1} - q_{n-1}|/4 and |q_n| < d,
//!   mean of max(q, 0) = (q_n + d)^2/(4 d)  in place of  max(q_n, 0).
//! On a straight path the error of a crossing then no longer depends on its place in the window. q_{n+1} is what the step
//! itself gives: the sweep's plain step first, then [`CORRECTIONS`] corrections. A slope from the past alone would not be
//! symmetric in time and heats the sheet instead. As dt -> 0 the windows vanish: the yarn law is unchanged.
//! Limits: velocity Verlet. Windows are looked for among the segments with |q_n| < |q_n - q_{n-1}|.
//! Reference: docs/model.md, "Slack and taut".

use crate::lanes::{Job, Lane};
use crate::layout::{self, CHUNK, Chunk, HOT_PLANES};
use crate::pose::Vector;
use crate::sim::Sim;
use crate::sweep::{self, Axis};
use crate::weave;

/// Corrections of the mean forces in a step.
pub const CORRECTIONS: u32 = 2;
/// Numbers kept per segment that may cross: relative displacement of its ends at t_n (3), q_n, q_{n-1}, the mean of
/// max(q, 0) in use, its last change.
pub const CROSSING_REALS: usize = 7;

/// Segments of one direction that may cross in this step, in the caller's memory.
pub(crate) struct Crossings<'a> {
    pub slots: &'a mut [[f64; CROSSING_REALS]],
    /// Number of the node that a segment starts at.
    pub nodes: &'a mut [u32],
    pub count: usize,
}

impl Crossings<'_> {
    /// Notes a segment. There is a place for every one.
    fn note(&mut self, node: usize, d: [f64; 3], excess: f64, before: f64) {
        if let (Some(slot), Some(place)) = (self.slots.get_mut(self.count), self.nodes.get_mut(self.count)) {
            *slot = [d[0], d[1], d[2], excess, before, if excess > 0.0 { excess } else { 0.0 }, 0.0];
            *place = node as u32;
            self.count += 1;
        }
    }

    /// Adds `count` segments noted from place `first` on, behind those there are.
    pub(crate) fn draw_together(&mut self, first: usize, count: usize) {
        for from in first..first + count {
            if let (Some(&slot), Some(&node)) = (self.slots.get(from), self.nodes.get(from))
                && let (Some(to), Some(place)) = (self.slots.get_mut(self.count), self.nodes.get_mut(self.count))
            {
                (*to, *place) = (slot, node);
                self.count += 1;
            }
        }
    }
}

/// Looks for segments of one row that may cross, before the row is swept: a job for the lanes.
pub(crate) struct FindCrossings<'j, 'a> {
    pub row: &'j [Chunk<HOT_PLANES>],
    /// The row above; empty for the top row.
    pub above: &'j [Chunk<HOT_PLANES>],
    /// Number of the row's first node.
    pub first: usize,
    /// Horizontal and vertical segments that start in the row.
    pub ends: [usize; 2],
    pub found: &'j mut [Crossings<'a>; 2],
}

impl Job for FindCrossings<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lane>(self) {
        let FindCrossings { row, above, first, ends, found } = self;
        let [horizontal, vertical] = found;
        for (c, chunk) in row.iter().enumerate() {
            let next = row.get(c + 1);
            for g in 0..CHUNK / L::WIDTH {
                let here = group::<L>(chunk, g);
                let column = c * CHUNK + g * L::WIDTH;
                let right = match next {
                    _ if g + 1 < CHUNK / L::WIDTH => group::<L>(chunk, g + 1),
                    Some(next) => group::<L>(next, 0),
                    None => [L::splat(0.0); 6],
                };
                let neighbour = neighbours(here, right);
                let (d, d_before) = relative(here, neighbour);
                let (q, before) = (sweep::excess_horizontal(d), sweep::excess_horizontal(d_before));
                if may_cross(q, before) {
                    let whole = &L::groups(&chunk[6])[g];
                    note_group::<L>(horizontal, [d[0], d[1], d[2], q, before], whole, first, column, ends[0]);
                }
                let Some(above) = above.get(c) else { continue };
                let up = group::<L>(above, g);
                let (d, d_before) = relative(here, up);
                let (q, before) = (sweep::excess_vertical(d), sweep::excess_vertical(d_before));
                if may_cross(q, before) {
                    let whole = &L::groups(&chunk[7])[g];
                    note_group::<L>(vertical, [d[0], d[1], d[2], q, before], whole, first, column, ends[1]);
                }
            }
        }
    }
}

// Written out, without closures: they would not be compiled for the instruction set.

/// Displacement and velocity of one lane group.
#[inline(always)]
fn group<L: Lane>([x, y, z, vx, vy, vz, ..]: &Chunk<HOT_PLANES>, g: usize) -> [L; 6] {
    [at::<L>(x, g), at::<L>(y, g), at::<L>(z, g), at::<L>(vx, g), at::<L>(vy, g), at::<L>(vz, g)]
}

#[inline(always)]
fn at<L: Lane>(plane: &[f64; CHUNK], g: usize) -> L {
    L::load(&L::groups(plane)[g])
}

/// The right-hand neighbours of a lane group.
#[inline(always)]
fn neighbours<L: Lane>(here: [L; 6], right: [L; 6]) -> [L; 6] {
    [
        here[0].right_of(right[0]),
        here[1].right_of(right[1]),
        here[2].right_of(right[2]),
        here[3].right_of(right[3]),
        here[4].right_of(right[4]),
        here[5].right_of(right[5]),
    ]
}

/// Relative displacements of the ends at t_n and at t_{n-1}.
#[inline(always)]
fn relative<L: Lane>(a: [L; 6], b: [L; 6]) -> ([L; 3], [L; 3]) {
    let d = [b[0].sub(a[0]), b[1].sub(a[1]), b[2].sub(a[2])];
    (d, [d[0].sub(b[3].sub(a[3])), d[1].sub(b[4].sub(a[4])), d[2].sub(b[5].sub(a[5]))])
}

/// Whether |q_n| < |q_n - q_{n-1}| for any of the group.
#[inline(always)]
fn may_cross<L: Lane>(q: L, before: L) -> bool {
    let zero = L::splat(0.0);
    let change = q.sub(before);
    change.max(zero.sub(change)).any_above(q.max(zero.sub(q)))
}

#[cold]
#[inline(never)]
fn note_group<L: Lane>(
    found: &mut Crossings<'_>,
    values: [L; 5],
    stiffness: &L::Group,
    first: usize,
    column: usize,
    end: usize,
) {
    let [mut x, mut y, mut z, mut excess, mut earlier] = [L::ZEROS, L::ZEROS, L::ZEROS, L::ZEROS, L::ZEROS];
    values[0].store(&mut x);
    values[1].store(&mut y);
    values[2].store(&mut z);
    values[3].store(&mut excess);
    values[4].store(&mut earlier);
    let displacements = x.as_ref().iter().zip(y.as_ref()).zip(z.as_ref());
    let excesses = excess.as_ref().iter().zip(earlier.as_ref());
    let lanes = displacements.zip(excesses).zip(stiffness.as_ref());
    for (lane, ((((&dx, &dy), &dz), (&q, &before)), &stiffness)) in lanes.enumerate() {
        let (change, size) = (q - before, if q < 0.0 { -q } else { q });
        let crosses = change > size || -change > size;
        if crosses && stiffness > 0.0 && column + lane < end {
            found.note(first + column + lane, [dx, dy, dz], q, before);
        }
    }
}

/// Mean of max(q, 0) over the window about q whose half width is `half`.
fn mean_excess(q: f64, half: f64) -> f64 {
    if q < half && q > -half {
        (q + half) * (q + half) / (4.0 * half)
    } else if q > 0.0 {
        q
    } else {
        0.0
    }
}

impl Sim<'_> {
    /// Corrects the kicks of the segments noted before the sweep.
    pub(crate) fn correct_crossings(&mut self) {
        let counts = [self.blocks.crossings[0].count, self.blocks.crossings[1].count];
        for _ in 0..CORRECTIONS {
            for (axis, count) in [Axis::Horizontal, Axis::Vertical].into_iter().zip(counts) {
                (0..count).for_each(|c| self.find_change(axis, c));
            }
            for (axis, count) in [Axis::Horizontal, Axis::Vertical].into_iter().zip(counts) {
                (0..count).for_each(|c| self.apply_change(axis, c));
            }
        }
    }

    /// The places of a noted segment's ends.
    fn crossing(&self, axis: Axis, c: usize) -> Option<[[usize; 2]; 2]> {
        // At least 1, so that no division by zero has to be compiled in.
        let nx = self.layout.nodes_x.max(1);
        let node = *self.blocks.crossings[axis as usize].nodes.get(c)? as usize;
        let (i, j) = (node % nx, node / nx);
        let end = match axis {
            Axis::Horizontal => [i + 1, j],
            Axis::Vertical => [i, j + 1],
        };
        Some([[i, j], end])
    }

    fn find_change(&mut self, axis: Axis, c: usize) {
        let Some([[i, j], [i2, j2]]) = self.crossing(axis, c) else { return };
        let (a, b) = (self.displacement(i, j), self.displacement(i2, j2));
        let d = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
        let after = match axis {
            Axis::Horizontal => sweep::excess_horizontal(d),
            Axis::Vertical => sweep::excess_vertical(d),
        };
        let Some([_, _, _, q, before, mean, change]) = self.blocks.crossings[axis as usize].slots.get_mut(c) else {
            return;
        };
        let difference = after - *before;
        let half = 0.25 * if difference < 0.0 { -difference } else { difference };
        let next = mean_excess(*q, half);
        *change = next - *mean;
        *mean = next;
    }

    fn apply_change(&mut self, axis: Axis, c: usize) {
        let Some([start, end]) = self.crossing(axis, c) else { return };
        let Some(&mut [dx, dy, dz, _, _, _, change]) = self.blocks.crossings[axis as usize].slots.get_mut(c) else {
            return;
        };
        if change == 0.0 {
            return;
        }
        let row = layout::row(self.blocks.hot, self.layout.chunks, start[1]);
        let stiffness = layout::get(row, 6 + axis as usize, start[0]).unwrap_or(0.0);
        let s = stiffness * change;
        let pull = match axis {
            Axis::Horizontal => Vector::new(s * (dx + 1.0), s * dy, s * dz),
            Axis::Vertical => Vector::new(s * dx, s * (dy + 1.0), s * dz),
        };
        self.push_node(start, pull);
        self.push_node(end, -pull);
    }

    /// A change of velocity, and of the position at the step's end with it; on a fixed node it is a pull on its support.
    fn push_node(&mut self, [i, j]: [usize; 2], kick: Vector) {
        if i >= self.layout.nodes_x || j >= self.layout.nodes_y {
            return;
        }
        if self.is_fixed(i, j) {
            if self.scene.track_support {
                let side = usize::from(self.blocks.runs.get(j).is_some_and(|run| i as u32 >= run[1]));
                let at = weave::attachment_of(self.scene.attachment.kind, self.scene.sheet.nodes_y, j, side);
                let pull = kick * (self.layout.node_weight(i, j) * self.scene.symmetry.share());
                self.state.sums.pull_support(self.scene.attachment.kind, at, &pull, self.scene.symmetry);
            }
            return;
        }
        let row = layout::row_mut(self.blocks.hot, self.layout.chunks, j);
        let (Some([x, y, z, vx, vy, vz, ..]), lane) = (row.get_mut(i / CHUNK), i % CHUNK) else { return };
        for (plane, kick) in [(x, kick.x), (vx, kick.x), (vy, kick.y), (z, kick.z), (vz, kick.z)] {
            plane[lane] += kick;
        }
        y[lane] += kick.y;
        let moved = y[lane];
        self.widen(j, moved);
    }

    /// Displacement at the step's end of a place, a node's or its image's.
    fn displacement(&self, i: usize, j: usize) -> [f64; 3] {
        let ((i, turn_x), (j, turn_y)) = (self.layout.x.node(i), self.layout.y.node(j));
        let row = layout::row(self.blocks.hot, self.layout.chunks, j);
        let (Some([x, y, z, ..]), lane) = (row.get(i / CHUNK), i % CHUNK) else { return [0.0; 3] };
        let (x, y) = (if turn_x { -x[lane] } else { x[lane] }, if turn_y { -y[lane] } else { y[lane] });
        [x, y, z[lane]]
    }
}

#[cfg(test)]
mod tests {
    use super::mean_excess;

    #[test]
    fn the_mean_is_continuous_and_exact_on_a_line() {
        assert_eq!((mean_excess(-2.0, 1.0), mean_excess(2.0, 1.0), mean_excess(-1.0, 1.0)), (0.0, 2.0, 0.0));
        assert_eq!(mean_excess(1.0, 1.0), 1.0);
        assert_eq!(mean_excess(0.3, 0.0), 0.3);
        // Midpoint rule over the window.
        let n = 100_000;
        let sum: f64 = (0..n).map(|k| 0.2 - 0.5 + (k as f64 + 0.5) / n as f64).filter(|q| *q > 0.0).sum();
        assert!((mean_excess(0.2, 0.5) - sum / n as f64).abs() < 1e-9);
    }
}
