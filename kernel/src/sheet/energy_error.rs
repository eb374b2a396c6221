//! Energy error of segments that become slack or taut in a step, and the stress that corrects it.
//!
//! Method: in a step velocity Verlet changes the energy 1/2 m v_{n-1/2} v_{n+1/2} + W_n + D_n by what the
//! strain energy W and the dissipated energy D of a segment grow by, less the work of the trapezoid rule on
//! it. That is known exactly: with the vector x from end to end at t_n, its last change w, the natural length
//! l, r = 2 x.w/l^2 and p = |w|^2/l^2, q was q_0 = q - r + p, so with the stress k q+ + g of each step, k_0
//! and g_0 in the last one, the energy error of a segment in a step is
//!
//! ```text
//! k q+ (q+ - r) - k_0 q_0+ (q_0+ + r - 2 p) + 4 (D - D_0) - g_0 (r - 2 p) - g r,
//!     in units of l^2/4 m h^2/dt^2.
//! ```
//!
//! The sum of all but the last part is the accumulated error b. The stress g = b/(2 r) corrects half of it in
//! its own step and half in the next one. It acts along the segment, also while it is slack, so momentum and
//! angular momentum stay exact. The segments of a row along x, or upwards from it, keep b from the first
//! slack one of them on, crimped ones from the start. Before, g is 0, and the error of a taut segment is of
//! third order.
//! Limits: g is at most 0.3 k |r|, so a slack segment may push or pull that much, and its error waits until
//! it moves. The error of a broken segment remains. The motion itself is not corrected. Velocity Verlet; no
//! dependence on the rate.
//! Reference: docs/model.md, "Slack and taut"; discrete gradients: O. Gonzalez, J. Nonlinear Sci. 6 (1996)
//! 449.

use crate::ground::lanes::Lane;
use crate::ground::planes::{Axis, CHUNK, Chunk, ENERGY_ERROR_PLANES};
use crate::yarn::law::RestLanes;

/// Largest stress given, over k |r|.
const LARGEST: f64 = 0.3;

/// Chunk without an energy error.
pub(crate) const NO_ENERGY_ERROR: Chunk<ENERGY_ERROR_PLANES> = [[0.0; CHUNK]; ENERGY_ERROR_PLANES];
/// First plane of the stresses given: the energy errors come before.
pub(crate) const GIVEN: usize = 2;

/// Energy error of a segment, and the stress that corrects it.
#[derive(Clone, Copy)]
pub(crate) struct EnergyError<L> {
    /// Energy error.
    pub energy: L,
    /// Correcting stress of the step.
    pub given: L,
}

impl<L: Lane> EnergyError<L> {
    /// (M9) Energy error after a step, and the stress that corrects it; `self`: those of the last step. The
    /// stiffnesses of the last step and of this one; `x`, `w`: from end to end, and how the ends move
    /// relative to each other.
    #[inline(always)]
    pub fn next(
        self,
        rest: &RestLanes<L>,
        [stiffness_before, stiffness]: [L; 2],
        q: L,
        [x, w]: [[L; 3]; 2],
    ) -> EnergyError<L> {
        let zero = L::splat(0.0);
        let [r, r_before] = growths(rest, [x, w]);
        let (taut, before) = (q.max(zero), q.sub(L::splat(0.5).mul(r.add(r_before))).max(zero));
        let law = stiffness.mul(taut.mul(taut.sub(r))).sub(stiffness_before.mul(before.mul(before.add(r_before))));
        let energy_error = self.energy.add(law).sub(self.given.mul(r_before));
        // Not more than the limit either way; 0 where the length does not change.
        let limit = stiffness.mul(L::splat(LARGEST)).mul(r.max(zero.sub(r)));
        let whole = energy_error.mul(r).div(r.mul(r.add(r)).add(L::splat(f64::MIN_POSITIVE)));
        let given = whole.min(limit).max(zero.sub(limit));
        EnergyError { energy: energy_error.sub(given.mul(r)), given }
    }
}

/// r and r - 2 p: what q grows by in the last step, from the direction that the segment has at its end and at
/// its start.
#[inline(always)]
pub(crate) fn growths<L: Lane>(rest: &RestLanes<L>, [x, w]: [[L; 3]; 2]) -> [L; 2] {
    let two = L::splat(2.0).mul(rest.inverse_square);
    let along = x[0].mul(w[0]).add(x[1].mul(w[1])).add(x[2].mul(w[2]));
    let squared = w[0].mul(w[0]).add(w[1].mul(w[1])).add(w[2].mul(w[2]));
    [two.mul(along), two.mul(along.sub(squared))]
}

/// 1 along each axis whose bit is set, else 0.
#[inline(always)]
pub(crate) fn keeps(bits: u32) -> [f64; 2] {
    let keeps = |axis: Axis| f64::from(u8::from(bits & bit(axis) != 0));
    [keeps(Axis::Horizontal), keeps(Axis::Vertical)]
}

/// The bit that says of a row that segments of this direction have been slack.
pub(crate) const fn bit(axis: Axis) -> u32 {
    1 << axis as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::yarn::law::Rest;

    /// A crossing from q_0 to q at any rate, without and with the strain of the motion across: k q_0 q either
    /// way, less what the turn does.
    #[test]
    fn a_crossing_makes_the_product_of_both_strains() {
        let (rest, k) = (Rest::of(1.0, 0.99), 0.3);
        for w in [[2e-2, 0.0, 0.0], [-2e-2, 0.0, 0.0], [2e-2, 0.01, -0.03], [-2e-2, -0.03, 0.02]] {
            let d: [f64; 3] = [1.01e-2 + 0.5 * w[0], 0.0, 0.0];
            let (q, q_0) =
                (rest.lanes().twice_strain(d), rest.lanes().twice_strain([d[0] - w[0], d[1] - w[1], d[2] - w[2]]));
            let p = (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]) * rest.inverse_square;
            assert!(q * q_0 < 0.0, "{q} {q_0}");
            let ends = [rest.lanes().end_to_end(d), w];
            let EnergyError { energy, given } =
                EnergyError { energy: 0.0, given: 0.0 }.next(&rest.lanes(), [k; 2], q, ends);
            let [r, _] = growths(&rest.lanes(), ends);
            let made = if q > 0.0 { k * q * (q_0 - p) } else { -k * q_0 * (q - p) };
            assert!((energy + given * r - made).abs() < 1e-12 * k * q.abs(), "{energy} {made}");
            assert!(given.abs() <= LARGEST * k * r.abs() && given * r * made >= 0.0);
        }
    }
}
