//! What a pass needs of the dependence on the rate of strain: the logarithm of every segment's rate, and what it takes of each row.
//!
//! Method: before the pass, for rows that may move, by lane groups: L of every segment at its present strain; what relaxation takes
//! by the growth of ln t since the last pass; and, where a segment may break further, what rupture dissipates beyond the law of
//! the reference rate. The sweep reads the logarithms.
//! Limits: as the law (`rate.rs`).
//! Reference: docs/model.md, "Rate of strain".

use crate::ground::lanes::{self, Job, Lane};
use crate::ground::planes::{self, Axis, CHUNK, Chunk, HISTORY_PLANES, HOT_PLANES, RATE_PLANES, vertical_axes};
use crate::memory::rows::place_image_column;
use crate::memory::system::System;
use crate::sheet::neighbours::{NOTHING, at, put, to_the_right, upwards};
use crate::sheet::symmetry::Line;
use crate::yarn::law::{Rest, Segment};
use crate::yarn::rate::RateLaw;

/// Finds the logarithms of rows [first, end), all that may move, and what the rate takes of each in this pass.
pub(crate) fn find_rates(system: &mut System<'_>, [first, end]: [usize; 2]) {
    let (layout, chunks) = (system.layout, system.layout.chunks);
    for j in first..end {
        if layout.x.is_mirrored() {
            place_image_column(planes::row_mut(system.arrays.hot, chunks, j), layout.x);
        }
        let of_h = taken_of_row(system, Axis::Horizontal, j) * layout.y.node_weight(j);
        let of_v = taken_of_row(system, Axis::Vertical, j) * layout.y.segment_weight(j);
        if let Some(slot) = system.arrays.taken.get_mut(j) {
            *slot = of_h + of_v;
        }
    }
}

/// Finds the logarithms of the segments of one direction that start in row j, and what relaxation and rupture take of them.
#[inline(never)]
fn taken_of_row(system: &mut System<'_>, axis: Axis, j: usize) -> f64 {
    let (chunks, line, law) = (system.layout.chunks, system.layout.x, system.rate_law(axis));
    // The growth of ln t; none before the load has begun.
    let passed = if system.state.loaded > 0 { system.model.limits.dt / system.load_time() } else { 0.0 };
    let System { directions, arrays, instructions, .. } = &mut *system;
    let direction = directions.of_ply(0).along(axis);
    let job = RowJob {
        law: &law,
        rest: &direction.rest,
        limit: law.limit(direction.critical),
        row: planes::row(arrays.hot, chunks, j),
        above: planes::row(arrays.hot, chunks, j + 1),
        history: planes::row(arrays.history, chunks, j),
        found: planes::row_mut(arrays.logarithms, chunks, j),
    };
    let (relaxing, beyond) = match axis {
        Axis::Horizontal => lanes::dispatch(*instructions, Along::<false>(job)),
        Axis::Vertical => lanes::dispatch(*instructions, Along::<true>(job)),
    };
    let mut relaxing = relaxing.iter().sum::<f64>();
    let length = direction.rest.length;
    if line.is_mirrored() {
        // All columns but the last are there twice.
        let last = line.modelled().saturating_sub(1);
        let less = 2.0 - weight(line, axis, last);
        let once = system
            .segment(axis, last, j)
            .map_or(0.0, |segment| law.relaxing(segment.stiffness, segment.twice_strain()));
        relaxing = 2.0 * relaxing - less * once;
    }
    let broken = if beyond { taken_by_rupture(system, &law, axis, j) } else { 0.0 };
    (relaxing * passed + broken) * length * length
}

/// How often the segment that starts at this node appears in the whole row.
fn weight(line: Line, axis: Axis, i: usize) -> f64 {
    match axis {
        Axis::Horizontal => line.segment_weight(i),
        Axis::Vertical => line.node_weight(i),
    }
}

/// What rupture dissipates in this pass beyond the law of the reference rate, which the balance counts (`energy.rs`).
#[inline(never)]
fn taken_by_rupture(system: &System<'_>, law: &RateLaw, axis: Axis, j: usize) -> f64 {
    let mut taken = 0.0;
    for i in 0..system.layout.nodes_x {
        let Some(segment) = system.segment(axis, i, j) else { continue };
        let q = segment.twice_strain();
        let seen = law.seen_at(q);
        let damage = system.law_of(&segment);
        if !system.direction(axis, j).law.is_damaging(seen, segment.history) {
            continue;
        }
        // Twice the stiffness stands for the modulus: energies are then those of `RateLaw::stored`.
        let material = Segment { modulus: 2.0 * segment.undamaged, damage_rate: segment.damage_rate };
        let dissipated = |q: f64| damage.dissipated(&material, damage.alpha(segment.damage_rate, q));
        let more = dissipated(seen) - dissipated(segment.history);
        taken += weight(system.layout.x, axis, i) * law.excess(q, seen) * more;
    }
    taken
}

/// Segments of one direction that start in a row.
struct RowJob<'a> {
    law: &'a RateLaw,
    rest: &'a Rest,
    /// q from which damage is looked for.
    limit: f64,
    row: &'a [Chunk<HOT_PLANES>],
    /// The row above; empty for the top row.
    above: &'a [Chunk<HOT_PLANES>],
    history: &'a [Chunk<HISTORY_PLANES>],
    found: &'a mut [Chunk<RATE_PLANES>],
}

/// Finds logarithms. Gives what relaxation takes by the growth of ln t, in sums over the columns, and whether any segment may break
/// further.
struct Along<'a, const VERTICAL: bool>(RowJob<'a>);

impl<const VERTICAL: bool> Job for Along<'_, VERTICAL> {
    type Output = ([f64; CHUNK], bool);

    #[inline(always)]
    fn run<L: Lane>(self) -> ([f64; CHUNK], bool) {
        let RowJob { law, rest, limit, row, above, history, found } = self.0;
        let plane = usize::from(VERTICAL);
        let (mut relaxing, mut beyond) = ([0.0; CHUNK], false);
        for (c, ((chunk, history), found)) in row.iter().zip(history).zip(found).enumerate() {
            let next = row.get(c + 1).unwrap_or(&NOTHING);
            let above = above.get(c).unwrap_or(&NOTHING);
            for g in 0..CHUNK / L::WIDTH {
                let q: L = if VERTICAL {
                    rest.twice_strain(vertical_axes(upwards(chunk, above, g)))
                } else {
                    rest.twice_strain(to_the_right(chunk, next, g))
                };
                put(found, plane, g, law.logarithm(q));
                let sum = &mut L::groups_mut(&mut relaxing)[g];
                L::load(sum).add(law.relaxing(at(chunk, 6 + plane, g), q)).store(sum);
                beyond |= q.any_not_below(L::splat(limit)) && q.any_above(at(history, plane, g));
            }
        }
        (relaxing, beyond)
    }
}
