//! Rate of strain: yarn that is stiffer and bears more strain the faster it is loaded, by the logarithm of
//! the rate.
//!
//! Method: the rate of a segment is its mean rate since the load began, r = (e - e_0)/t, with the
//! Green-Lagrange strain e, that of the flat sheet e_0, and the time t since the first contact or since
//! motion was given by hand. So it needs no history, and, as the momentary rate is not, it is no matter of
//! the oscillation of the network. With L = ln(r/r_0), held within 0 and ln(r_1/r_0):
//!   S = alpha E e (1 + C_E L), and damage sees the strain e/(1 + C_U L).
//! At a fixed strain the stress falls with the logarithm of the time: yarn relaxes. The strain energy W(e, t)
//! is the integral of S over e; -dW/dt = alpha E C_E (c^2 - a^2)/(2t) is what relaxation dissipates, with c
//! the strain held within a = e(r_0) and b = e(r_1). It is never negative, so no way of loading gains energy.
//! A segment breaks at a higher strain than damage sees, and what rupture dissipates beyond the law of the
//! reference rate is counted too. The sweep finds rate, relaxation and rupture of each segment from the
//! strain that it has at hand.
//! Limits: one event that begins with the first contact. Velocity Verlet; no pre-tension.
//! Reference: docs/model.md, "Rate of strain".

use crate::ground::lanes::{Lane, Splat};
use crate::ground::math;
use crate::scene::features::Feature;
use crate::scene::parts::Scene;
use crate::yarn::law;

/// The limit from which the sweep looks for damage lies so much lower than it could: rounding must hide none.
const ROUNDING: f64 = 1e-12;

/// A strain that is none.
const LEAST: f64 = 1e-290;

/// The law of the segments of one direction at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateLaw {
    /// C_E.
    modulus: f64,
    /// C_U.
    stretch: f64,
    /// q of the flat sheet, at most 0.
    rest: f64,
    /// 2 r_0, 1/s; 0 for no dependence on the rate.
    reference: f64,
    /// r_1/r_0, at least 1.
    ratio: f64,
    /// Logarithm of the ratio.
    largest: f64,
    /// Change of q since the load began at the reference rate, 2 r_0 t.
    least: f64,
    /// Inverse of that change.
    per_least: f64,
}

/// [`RateLaw`] of several segments at once.
#[derive(Clone, Copy)]
pub struct RateLanes<L> {
    /// q of taut yarn at the reference rate, and twice it.
    first: L,
    twice_first: L,
    /// Growth of q from the reference rate to the highest.
    width: L,
    /// C_E times the largest logarithm.
    stiffest: L,
}

impl RateLaw {
    /// No dependence on the rate.
    pub const NONE: RateLaw = RateLaw {
        modulus: 0.0,
        stretch: 0.0,
        rest: 0.0,
        reference: 0.0,
        ratio: 1.0,
        largest: 0.0,
        least: 1.0,
        per_least: 1.0,
    };

    /// The law of a scene for segments with this q in the flat sheet, at no time yet.
    pub fn of(scene: &Scene, rest: f64) -> RateLaw {
        if !Feature::Rate.is_in(scene) {
            return RateLaw::NONE;
        }
        let yarn = &scene.yarn;
        let ratio = yarn.rate_limit / yarn.rate_reference;
        RateLaw {
            modulus: yarn.rate_modulus,
            stretch: yarn.rate_stretch,
            rest,
            reference: 2.0 * yarn.rate_reference,
            ratio,
            largest: math::ln(ratio),
            ..RateLaw::NONE
        }
    }

    /// The law at a time, s, since the load began.
    #[inline(always)]
    pub fn at(&self, time: f64) -> RateLaw {
        if !self.depends() {
            return RateLaw::NONE;
        }
        let least = self.reference * time;
        RateLaw { least, per_least: 1.0 / least, ..*self }
    }

    /// Whether yarn depends on the rate at all.
    #[inline(always)]
    pub fn depends(&self) -> bool {
        Feature::Rate.is_built() && self.reference != 0.0
    }

    /// Constants as all lanes read them.
    #[inline(always)]
    pub fn splats(&self) -> RateSplats {
        let [first, last] = self.range();
        // Yarn that is faster than the highest rate as soon as it is taut has the largest stiffness, too.
        let width = math::max(last - first, LEAST);
        RateSplats([first, 2.0 * first, width, self.modulus * self.largest].map(Splat::of))
    }

    fn at_reference(&self) -> f64 {
        self.rest * self.per_least + 1.0
    }

    /// L, the logarithm of the rate over the reference rate.
    fn logarithm(&self, q: f64) -> f64 {
        let more = q * self.per_least - self.at_reference();
        if more <= 0.0 {
            0.0
        } else if more >= self.ratio - 1.0 {
            self.largest
        } else {
            math::ln_1p(more)
        }
    }

    /// (M19) Stiffness of a segment over that at the reference rate, 1 + C_E L.
    pub fn stiffening(&self, q: f64) -> f64 {
        self.modulus * self.logarithm(q) + 1.0
    }

    /// (M20) The q that damage sees.
    pub fn seen_at(&self, q: f64) -> f64 {
        if self.stretch == 0.0 { q } else { q / self.weakening(q) }
    }

    /// q over the one that damage sees, 1 + C_U L.
    fn weakening(&self, q: f64) -> f64 {
        1.0 + self.stretch * self.logarithm(q)
    }

    /// A q below which damage sees none beyond this critical one.
    pub fn limit(&self, critical: f64) -> f64 {
        let limit = critical * self.weakening(critical);
        if limit > critical { limit * (1.0 - ROUNDING) } else { critical }
    }

    /// Strain energy W, the integral of stress over strain. `stiffness`: half of alpha E.
    pub fn stored(&self, stiffness: f64, q: f64) -> f64 {
        let base = law::strain_energy(stiffness, q);
        if self.modulus == 0.0 || q <= 0.0 {
            return base;
        }
        // x = q - q_0 from where the yarn is taut and faster than the reference rate, up to the present or to
        // the highest rate.
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

    /// q of taut yarn at the reference rate and at the highest.
    #[inline(always)]
    fn range(&self) -> [f64; 2] {
        [math::max(self.rest + self.least, 0.0), math::max(self.rest + self.least * self.ratio, 0.0)]
    }

    /// Dissipation of rupture at q beyond that at the strain that damage sees, over the latter.
    pub fn excess(&self, q: f64, seen: f64) -> f64 {
        self.stored(1.0, q) / law::strain_energy(1.0, seen) - 1.0
    }
}

/// [`RateLaw`] as all lanes read it.
pub struct RateSplats([Splat; 4]);

impl RateSplats {
    /// Constants of a lane group.
    #[inline(always)]
    pub fn lanes<L: Lane>(&self) -> RateLanes<L> {
        let [first, twice_first, width, stiffest] = &self.0;
        RateLanes {
            first: first.lanes(),
            twice_first: twice_first.lanes(),
            width: width.lanes(),
            stiffest: stiffest.lanes(),
        }
    }
}

impl<L: Lane> RateLanes<L> {
    /// Excess of q over that of the reference rate, up to that of the highest.
    #[inline(always)]
    pub fn beyond(&self, q: L) -> L {
        q.sub(self.first).max(L::splat(0.0)).min(self.width)
    }

    /// Dissipation of relaxation while the logarithm of the time grows by 1, over 1/4 C_E, in units of
    /// [`RateLaw::stored`].
    #[inline(always)]
    pub fn relaxing(&self, stiffness: L, beyond: L) -> L {
        stiffness.mul(beyond.mul(beyond.add(self.twice_first)))
    }

    /// Above 0 where the rate lies within the two.
    #[inline(always)]
    pub fn within(&self, beyond: L) -> L {
        beyond.mul(self.width.sub(beyond))
    }

    /// 1 + C_E L where L is 0 or the largest.
    #[inline(always)]
    pub fn stiffening(&self, beyond: L) -> L {
        beyond.mul(L::splat(f64::MAX)).min(self.stiffest).add(L::splat(1.0))
    }
}

/// Constants of the laws for a sweep in addition to those of a direction.
#[derive(Clone, Copy)]
pub struct Rates {
    /// Time since the load began, s.
    pub time: f64,
    /// C_E times the growth of the logarithm of the time since the last step.
    pub relaxing: f64,
    /// q of horizontal and vertical segments from which damage is looked for.
    pub limits: [f64; 2],
}

impl Rates {
    /// No dependence on the rate.
    pub const NONE: Rates = Rates { time: 0.0, relaxing: 0.0, limits: [0.0; 2] };
}
