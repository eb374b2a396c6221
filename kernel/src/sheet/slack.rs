//! The energy that a step makes of segments that become slack or taut, and how each gives it back.
//!
//! Method: in a step velocity Verlet changes the energy 1/2 m v_{n-1/2} v_{n+1/2} + W_n + D_n by what the strain energy W and the dissipated
//! energy D of a segment grow by, less the work of the trapezoid rule on it. That is known exactly: with the vector x from end to end at
//! t_n, its last change w, the natural length l, r = 2 x.w/l^2 and p = |w|^2/l^2, q was q_0 = q - r + p, so with the stress k q+ + g of each
//! step, k_0 and g_0 in the last one, a segment makes
//!
//! ```text
//! k q+ (q+ - r) - k_0 q_0+ (q_0+ + r - 2 p) + 4 (D - D_0) - g_0 (r - 2 p) - g r,  in units of l^2/4 m h^2/dt^2.
//! ```
//!
//! The sum of all but the last part is what it owes, b. The stress g = b/(2 r) takes half of that in its own step and half in the next one.
//! It acts along the segment, also while it is slack, so momentum and angular momentum stay exact.
//! The segments of a row along x, or upwards from it, keep this from the first slack one of them on, crimped ones from the start. Before,
//! g is 0, and what a taut segment makes is of third order.
//! Limits: g is at most 0.3 k |r|, so a slack segment may push or pull that much, and what it owes waits until it moves. A broken one gives
//! nothing back. The motion itself is not mended. Velocity Verlet; no dependence on the rate.
//! Reference: docs/model.md, "Slack and taut"; discrete gradients: O. Gonzalez, J. Nonlinear Sci. 6 (1996) 449.

use crate::ground::lanes::{Job, Lane};
use crate::ground::planes::{Axis, CHUNK, Chunk, HOT_PLANES, OWED_PLANES, vertical_axes};
use crate::sheet::direction::Along;
use crate::sheet::grading::NetRow;
use crate::sheet::neighbours::{NOTHING, at, right_of, to_the_right, upwards};
use crate::sheet::ring::{self, CHORD_X, CHORD_Z, HOOP_PLANES};
use crate::yarn::law::RestLanes;

/// Largest stress given, over k |r|.
const LARGEST: f64 = 0.3;
/// Every so many steps, from the first one on, rows are searched for slack segments.
pub(crate) const SEARCH_INTERVAL: u64 = 16;

/// What nobody owes.
pub(crate) const NOTHING_OWED: Chunk<OWED_PLANES> = [[0.0; CHUNK]; OWED_PLANES];
/// First plane of the stresses given: the energies owed come before.
pub(crate) const GIVEN: usize = 2;

/// What eight segments of one direction owe, and the stress that they gave in the last pass.
pub(crate) struct Owed<'a> {
    pub energy: &'a mut [f64; CHUNK],
    pub given: &'a mut [f64; CHUNK],
}

impl Owed<'_> {
    /// (M9) The stress that group g gives in this pass. Its stiffnesses of the last pass and of this one; `x`, `w`: from end to end, and how
    /// the ends move relative to each other.
    #[inline(always)]
    pub fn stress<L: Lane>(
        &mut self,
        rest: &RestLanes<L>,
        [stiffness_before, stiffness]: [L; 2],
        q: L,
        [x, w]: [[L; 3]; 2],
        g: usize,
    ) -> L {
        let (energy, given) = (&mut L::groups_mut(self.energy)[g], &mut L::groups_mut(self.given)[g]);
        let zero = L::splat(0.0);
        let [r, r_before] = growths(rest, [x, w]);
        let (taut, before) = (q.max(zero), q.sub(L::splat(0.5).mul(r.add(r_before))).max(zero));
        let law = stiffness.mul(taut.mul(taut.sub(r))).sub(stiffness_before.mul(before.mul(before.add(r_before))));
        let owed = L::load(energy).add(law).sub(L::load(given).mul(r_before));
        // Not more than the limit either way; 0 where the length does not change.
        let limit = stiffness.mul(L::splat(LARGEST)).mul(r.max(zero.sub(r)));
        let whole = owed.mul(r).div(r.mul(r.add(r)).add(L::splat(f64::MIN_POSITIVE)));
        let stress = whole.min(limit).max(zero.sub(limit));
        owed.sub(stress.mul(r)).store(energy);
        stress.store(given);
        stress
    }
}

/// r and r - 2 p: what q grows by in the last step, from the direction that the segment has at its end and at its start.
#[inline(always)]
pub(crate) fn growths<L: Lane>(rest: &RestLanes<L>, [x, w]: [[L; 3]; 2]) -> [L; 2] {
    let two = L::splat(2.0).mul(rest.inverse_square);
    let along = x[0].mul(w[0]).add(x[1].mul(w[1])).add(x[2].mul(w[2]));
    let squared = w[0].mul(w[0]).add(w[1].mul(w[1])).add(w[2].mul(w[2]));
    [two.mul(along), two.mul(along.sub(squared))]
}

/// Relative velocities of the ends of the segments from group g, to the right and upwards, in the axes of the sheet.
#[inline(always)]
pub(crate) fn relative_velocities<L: Lane>([chunk, next, above]: [&Chunk<HOT_PLANES>; 3], g: usize) -> [[L; 3]; 2] {
    let here: [L; 3] = [at(chunk, 3, g), at(chunk, 4, g), at(chunk, 5, g)];
    let right = [
        right_of(here[0], &chunk[3], &next[3], g).sub(here[0]),
        right_of(here[1], &chunk[4], &next[4], g).sub(here[1]),
        right_of(here[2], &chunk[5], &next[5], g).sub(here[2]),
    ];
    let up: [L; 3] = [at(above, 3, g), at(above, 4, g), at(above, 5, g)];
    [right, [up[0].sub(here[0]), up[1].sub(here[1]), up[2].sub(here[2])]]
}

/// The bit that says of a row that segments of this direction have been slack.
pub(crate) const fn bit(axis: Axis) -> u32 {
    1 << axis as u32
}

/// Bits of the directions in which a segment that starts in a row is slack.
pub(crate) struct FindSlack<'a> {
    pub row: &'a [Chunk<HOT_PLANES>],
    /// Empty above the last row.
    pub above: &'a [Chunk<HOT_PLANES>],
    pub directions: Along<'a>,
    pub net: NetRow<'a>,
    /// Of a curved sheet.
    pub hoop: &'a [Chunk<HOOP_PLANES>],
}

impl Job for FindSlack<'_> {
    type Output = u32;

    #[inline(always)]
    fn run<L: Lane>(self) -> u32 {
        let FindSlack { row, above, directions, net, hoop } = self;
        let Along { horizontal, vertical, .. } = directions;
        let (zero, rest_v, around) = (L::splat(0.0), net.upwards::<L>(&vertical.rest), directions.around().lanes());
        let mut slack = [false; 2];
        for (c, chunk) in row.iter().enumerate() {
            let (next, above) = (row.get(c + 1).unwrap_or(&NOTHING), above.get(c).unwrap_or(&NOTHING));
            for g in 0..CHUNK / L::WIDTH {
                let (along, up) = (to_the_right(chunk, next, g), vertical_axes(upwards(chunk, above, g)));
                let of_x = match hoop.get(c) {
                    Some(hoop) => {
                        ring::general_twice_strain(along, [at(hoop, CHORD_X, g), at(hoop, CHORD_Z, g)], &around)
                    }
                    None => net.along::<L>(c, g, &horizontal.rest).twice_strain(along),
                };
                for (k, q) in [of_x, rest_v.twice_strain(up)].into_iter().enumerate() {
                    // Where there is no segment the stiffness is 0, as of a broken one.
                    slack[k] |= zero.any_above(at::<L, HOT_PLANES>(chunk, 6 + k, g).mul(q));
                }
            }
            if slack == [true; 2] {
                break;
            }
        }
        let bits = |axis: Axis| u32::from(slack[axis as usize]) * bit(axis);
        bits(Axis::Horizontal) | bits(Axis::Vertical)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::yarn::law::Rest;

    /// A crossing from q_0 to q at any rate, without and with the strain of the motion across: k q_0 q either way, less what the turn does.
    #[test]
    fn a_crossing_makes_the_product_of_both_strains() {
        let (rest, k) = (Rest::of(1.0, 0.99), 0.3);
        for w in [[2e-2, 0.0, 0.0], [-2e-2, 0.0, 0.0], [2e-2, 0.01, -0.03], [-2e-2, -0.03, 0.02]] {
            let d: [f64; 3] = [1.01e-2 + 0.5 * w[0], 0.0, 0.0];
            let (q, q_0) = (rest.twice_strain(d), rest.twice_strain([d[0] - w[0], d[1] - w[1], d[2] - w[2]]));
            let p = (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]) * rest.inverse_square;
            assert!(q * q_0 < 0.0, "{q} {q_0}");
            let mut owed = Owed { energy: &mut [0.0; CHUNK], given: &mut [0.0; CHUNK] };
            let ends = [rest.lanes().end_to_end(d), w];
            let given = owed.stress(&rest.lanes(), [k; 2], q, ends, 0);
            let [r, _] = growths(&rest.lanes(), ends);
            let made = if q > 0.0 { k * q * (q_0 - p) } else { -k * q_0 * (q - p) };
            assert!((owed.energy[0] + given * r - made).abs() < 1e-12 * k * q.abs(), "{} {made}", owed.energy[0]);
            assert!(given.abs() <= LARGEST * k * r.abs() && given * r * made >= 0.0);
        }
    }
}
