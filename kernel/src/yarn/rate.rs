//! Rate of strain: yarn that is stiffer and bears more strain the faster it is loaded, by the logarithm of the rate.
//!
//! Method: the rate of a segment is its mean rate since the load began, r = (e - e_0)/t, with the Green-Lagrange strain e, that of
//! the flat sheet e_0, and the time t since the first contact or since motion was given by hand. So it needs no history, and, as
//! the momentary rate is not, it is no matter of the oscillation of the network. With L = ln(r/r_0), held within 0 and ln(r_1/r_0):
//!   S = alpha E e (1 + C_E L), and damage sees the strain e/(1 + C_U L).
//! At a fixed strain the stress falls with the logarithm of the time: yarn relaxes. The strain energy W(e, t) is the integral of S
//! over e; -dW/dt = alpha E C_E (c^2 - a^2)/(2t) is what relaxation dissipates, with c the strain held within a = e(r_0) and
//! b = e(r_1). It is never negative, so no way of loading gains energy. A segment breaks at a higher strain than damage sees, and
//! what rupture dissipates beyond the law of the reference rate is counted too.
//! Before a pass the logarithms of its rows are found (`relaxation.rs`), and what is dissipated in them; the sweep reads the logarithms.
//! Limits: one event that begins with the first contact. Velocity Verlet; no pre-tension.
//! Reference: docs/model.md, "Rate of strain".

use crate::ground::lanes::Lane;
use crate::ground::math;
use crate::scene::parts::Scene;
use crate::yarn::law;

/// The limit from which the sweep looks for damage lies so much lower than it could: rounding must hide none.
const ROUNDING: f64 = 1e-12;

/// The law of the segments of one direction at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateLaw {
    /// C_E.
    modulus: f64,
    /// C_U.
    stretch: f64,
    /// q of the flat sheet, at most 0.
    rest: f64,
    /// Change of q since then at the reference rate, 2 r_0 t.
    least: f64,
    /// Its inverse; 0 for no dependence on the rate.
    per_least: f64,
    /// r_1/r_0, at least 1.
    ratio: f64,
    /// Its logarithm.
    largest: f64,
}

impl RateLaw {
    /// No dependence on the rate.
    pub const NONE: RateLaw =
        RateLaw { modulus: 0.0, stretch: 0.0, rest: 0.0, least: 1.0, per_least: 0.0, ratio: 1.0, largest: 0.0 };

    /// The law of a scene for segments with this q in the flat sheet, at a time, s, since the load began.
    pub fn of(scene: &Scene, rest: f64, time: f64) -> RateLaw {
        if !scene.depends_on_rate() {
            return RateLaw::NONE;
        }
        let yarn = &scene.yarn;
        let (ratio, least) = (yarn.rate_limit / yarn.rate_reference, 2.0 * yarn.rate_reference * time);
        RateLaw {
            modulus: yarn.rate_modulus,
            stretch: yarn.rate_stretch,
            rest,
            least,
            per_least: 1.0 / least,
            ratio,
            largest: math::ln(ratio),
        }
    }

    /// L, the logarithm of the rate over the reference rate.
    #[inline(always)]
    pub fn logarithm<L: Lane>(&self, q: L) -> L {
        let over = q.sub(L::splat(self.rest)).mul(L::splat(self.per_least));
        let (one, ratio) = (L::splat(1.0), L::splat(self.ratio));
        let over = over.max(one).min(ratio);
        // Mostly all are held: 0 or the largest.
        if !over.sub(one).mul(ratio.sub(over)).any_above(L::splat(0.0)) {
            return over.sub(one).mul(L::splat(f64::MAX)).min(L::splat(self.largest));
        }
        let mut group = L::ZEROS;
        over.store(&mut group);
        for x in group.as_mut() {
            *x = if *x <= 1.0 {
                0.0
            } else if *x >= self.ratio {
                self.largest
            } else {
                math::ln(*x)
            };
        }
        L::load(&group)
    }

    /// Stiffness over that at the reference rate, at this logarithm.
    #[inline(always)]
    pub fn stiffening<L: Lane>(&self, logarithm: L) -> L {
        stiffening(self.modulus, logarithm)
    }

    /// The q that damage sees.
    pub fn seen_at(&self, q: f64) -> f64 {
        if self.stretch == 0.0 { q } else { seen(self.stretch, q, self.logarithm(q)) }
    }

    /// A q below which damage sees none beyond this critical one.
    pub fn limit(&self, critical: f64) -> f64 {
        let limit = critical * (1.0 + self.stretch * self.logarithm(critical));
        if limit > critical { limit * (1.0 - ROUNDING) } else { critical }
    }

    /// Strain energy W, the integral of stress over strain. `stiffness`: half of alpha E.
    pub fn stored(&self, stiffness: f64, q: f64) -> f64 {
        let base = law::strain_energy(stiffness, q);
        if self.modulus == 0.0 || q <= 0.0 {
            return base;
        }
        // x = q - q_0 from where the yarn is taut and faster than the reference rate, up to the present or to the highest rate.
        let first = math::max(self.least, -self.rest);
        let last = math::min(q - self.rest, self.least * self.ratio);
        let integral = |x: f64| {
            let logarithm = math::ln(x * self.per_least);
            0.5 * x * x * (logarithm - 0.5) + self.rest * x * (logarithm - 1.0)
        };
        let growing = if last > first { integral(last) - integral(first) } else { 0.0 };
        let [_, held] = self.range();
        let beyond = if q > held { 0.5 * self.largest * (q * q - held * held) } else { 0.0 };
        base + 0.5 * stiffness * self.modulus * (growing + beyond)
    }

    /// What relaxation takes while the logarithm of the time grows by 1, in units of [`RateLaw::stored`].
    #[inline(always)]
    pub fn relaxing<L: Lane>(&self, stiffness: L, q: L) -> L {
        let [first, last] = self.range();
        let held = q.max(L::splat(first)).min(L::splat(last));
        stiffness.mul(held.mul(held).sub(L::splat(first * first))).mul(L::splat(0.25 * self.modulus))
    }

    /// q of taut yarn at the reference rate and at the highest.
    #[inline(always)]
    fn range(&self) -> [f64; 2] {
        [math::max(self.rest + self.least, 0.0), math::max(self.rest + self.least * self.ratio, 0.0)]
    }

    /// What rupture dissipates at q beyond what it would at the strain that damage sees, over the latter.
    pub fn excess(&self, q: f64, seen: f64) -> f64 {
        self.stored(1.0, q) / law::strain_energy(1.0, seen) - 1.0
    }
}

/// What a sweep needs of the laws at its time.
#[derive(Clone, Copy)]
pub struct Rates {
    /// C_E.
    modulus: f64,
    /// C_U.
    stretch: f64,
    /// q of horizontal and vertical segments from which damage is looked for.
    pub limits: [f64; 2],
}

impl Rates {
    /// Of a scene; `limits`: q of horizontal and vertical segments from which damage is looked for.
    pub(crate) fn of(scene: &Scene, limits: [f64; 2]) -> Rates {
        Rates { modulus: scene.yarn.rate_modulus, stretch: scene.yarn.rate_stretch, limits }
    }

    /// Stiffness over that at the reference rate, at this logarithm.
    #[inline(always)]
    pub fn stiffening<L: Lane>(&self, logarithm: L) -> L {
        stiffening(self.modulus, logarithm)
    }

    /// The q that damage sees, at this logarithm.
    pub fn seen(&self, q: f64, logarithm: f64) -> f64 {
        seen(self.stretch, q, logarithm)
    }
}

/// (M20) q/(1 + C_U L).
fn seen(stretch: f64, q: f64, logarithm: f64) -> f64 {
    q / (1.0 + stretch * logarithm)
}

/// (M19) 1 + C_E L.
#[inline(always)]
fn stiffening<L: Lane>(modulus: f64, logarithm: L) -> L {
    L::splat(modulus).mul(logarithm).add(L::splat(1.0))
}
