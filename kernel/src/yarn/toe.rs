//! The toe: a softened start of the yarn law for segments that have been slack, against the energy creep of a rattling sheet.
//!
//! Method: after the first failure a segment that is found slack, at t_n and at t_{n-1}, is marked for good. With e its
//! Green-Lagrange strain and t = min(e/eps, 1) its stress is alpha E e t (2 - t): it sets in without a jump of stiffness and is
//! the law's own from eps on, so also where it can be damaged. Neither state counts strain energy, so nothing jumps in the
//! energy balance at the mark. A mark is the alpha of that moment less 1, from which the energy of later rupture follows.
//! Limits: it changes the yarn law, though only of yarn that has been slack; its tangent modulus is at most 4/3 E, so the step
//! must be smaller by sqrt(3/4). Marking before the first failure would soften yarn that the wave has yet to load.
//! Reference: docs/model.md, "The toe".

use crate::ground::lanes::Lane;

/// Mark of a segment without a toe; those with one have marks in [-1, 0].
pub const NO_TOE: f64 = 1.0;
/// Every so many steps slack segments are looked for.
pub const MARK_INTERVAL: u64 = 16;

/// A toe of a certain width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Toe {
    /// eps, a Green-Lagrange strain; 0 = no toe.
    pub width: f64,
    /// 1/(2 eps): from q = 2 e to e/eps; 0 without toe.
    slope: f64,
}

impl Toe {
    /// No toe.
    pub(crate) const NONE: Toe = Toe { width: 0.0, slope: 0.0 };

    /// A toe of the width eps, or none.
    pub fn of(width: f64) -> Toe {
        Toe { width, slope: if width > 0.0 { 0.5 / width } else { 0.0 } }
    }

    /// What the toe leaves of a segment's stiffness at q = U^2 - 1: t (2 - t), exactly 1 beyond eps and without a mark.
    #[inline(always)]
    pub fn factor<L: Lane>(&self, q: L, mark: L) -> L {
        let t = q.max(L::splat(0.0)).mul(L::splat(self.slope)).max(mark).min(L::splat(1.0));
        t.mul(L::splat(2.0).sub(t))
    }

    /// Strain energy over that without toe, alpha E e^2/2, at a strain e > 0.
    pub fn stored_share(&self, strain: f64) -> f64 {
        if strain < self.width {
            let t = strain / self.width;
            t * (4.0 / 3.0 - 0.5 * t)
        } else {
            let t = self.width / strain;
            1.0 - t * t / 6.0
        }
    }

    /// Energy density, J/m^3, that rupture dissipates less than without toe while alpha falls by `fall`: beyond eps the strain
    /// energy is less by alpha E eps^2/12.
    pub fn saved(&self, modulus: f64, fall: f64) -> f64 {
        modulus * fall * self.width * self.width / 12.0
    }
}
