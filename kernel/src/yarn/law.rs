//! The yarn law, (M1) to (M5), and its viscosity, (M16) and (M17): Kirchhoff-St. Venant material with a
//! damage variable that only falls. Pure functions.
//!
//! This is the law that steps: the sweep, the theta rule, the energies and the tests call these functions,
//! the first with lanes of several segments at once.
//! Method: with the stretch U and the Green-Lagrange strain e = (U^2 - 1)/2, the second Piola-Kirchhoff
//! stress is S = alpha E e in tension and 0 in compression. Beyond the critical stretch U_c the damage
//! variable follows alpha = A (exp(-lambda (U_max - U_c)) - B), cut to 0 at `alpha_fail`, where U_max is the
//! largest stretch so far. Twice the strain, q = 2 e = U^2 - 1, follows from the displacements without a
//! root: it is what all functions take, and the history of a segment is the largest q beyond the critical
//! one. Stiffness, stress, force and energy are in the caller's units: the stiffness is half of alpha E, as S
//! = (alpha E/2) q. In Pa it gives a stress in Pa and an energy in J/m^3; the stepper's alpha E A_0 dt^2/(2 m
//! h l) gives a force in m h/dt^2, which is a change of velocity in h/dt a step, and an energy in m h^2/dt^2
//! over l^2, with the natural length l in spacings h. Strain and force follow from the rest vector and the
//! natural length of a segment, [`RestLanes`]; crimp, pre-tension, unlike directions, bars of a graded
//! network and chords of a curved sheet are other constants of the same two expressions. A plain segment lies
//! at its natural length, 1: its products with 1 and sums with -0 are exact, and a compiler that knows them
//! leaves them out.
//! Limits: lambda >= 3, so that the tangent stiffness is largest at U_c (the step limit relies on it).
//! Reference: D. Powell, T. I. Zohdi, Composites Part B 40 (2009) 451, their yarn constitutive law.

use crate::ground::lanes::{Lane, Splat};
use crate::ground::math;

/// Constants of the damage law that all segments share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DamageLaw {
    /// Critical stretch U_c > 1 at which the first fibrils break.
    pub critical_stretch: f64,
    /// Factor A > 0, with A (1 - B) in (0, 1].
    pub a: f64,
    /// Offset B < 1.
    pub b: f64,
    /// Values of alpha at or below this become exactly 0; in [0, 1).
    pub alpha_fail: f64,
}

/// Stiffness constants of one segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Young's modulus E, Pa.
    pub modulus: f64,
    /// Damage rate lambda, dimensionless.
    pub damage_rate: f64,
}

/// History of a failed segment: above every q.
pub const FAILED: f64 = f64::MAX;

/// A new q beyond this, a stretch of 1e25, is no fabric any more: the state is lost. So far below the largest
/// number that what the next step makes of a state is still a number, whose energy is one.
pub const LOST: f64 = 1e50;

/// Damage of a segment after a new largest strain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Damage {
    /// The damage variable.
    pub alpha: f64,
    /// The largest q so far; [`FAILED`] once alpha is 0.
    pub history: f64,
}

/// (M1) Stretch U of a segment from twice its strain; 0 if rounding leaves a negative U^2.
pub fn stretch(twice_strain: f64) -> f64 {
    let squared = 1.0 + twice_strain;
    math::sqrt(math::max(squared, 0.0))
}

/// Twice the strain at a stretch.
pub fn twice_strain_at(stretch: f64) -> f64 {
    (stretch - 1.0) * (stretch + 1.0)
}

/// (M3) Second Piola-Kirchhoff stress, in tension only. `stiffness`: half of alpha E.
#[inline(always)]
pub fn stress<L: Lane>(stiffness: L, twice_strain: L) -> L {
    stiffness.mul(twice_strain.max(L::splat(0.0)))
}

/// Rest state of the segments of one direction in the flat sheet. Lengths in node spacings along x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rest {
    /// Distance of the ends, rho.
    pub spacing: f64,
    /// Natural length l, at which the segment begins to pull.
    pub length: f64,
    /// Twice the strain at the distance rho, q_0 = (rho/l)^2 - 1.
    pub twice_strain: f64,
    /// 1/l^2.
    pub inverse_square: f64,
}

impl Rest {
    /// A segment that lies at its natural length, 1.
    pub const PLAIN: Rest = Rest { spacing: 1.0, length: 1.0, twice_strain: NONE, inverse_square: 1.0 };

    /// Ends at the distance `spacing` with the stretch `stretch` there.
    pub fn of(spacing: f64, stretch: f64) -> Rest {
        let per_length = stretch / spacing;
        Rest {
            spacing,
            length: spacing / stretch,
            twice_strain: twice_strain_at(stretch),
            inverse_square: per_length * per_length,
        }
    }

    /// So many of these segments in series (`grading.rs`).
    pub fn in_series(&self, segments: f64) -> Rest {
        Rest {
            spacing: self.spacing * segments,
            length: self.length * segments,
            inverse_square: self.inverse_square / (segments * segments),
            ..*self
        }
    }

    /// Constants of several such segments of a flat sheet.
    #[inline(always)]
    pub fn lanes<L: Lane>(&self) -> RestLanes<L> {
        RestSplats::of(self).lanes()
    }
}

/// Zero whose sum with any number is that number, so that a compiler can leave the sum out.
pub(crate) const NONE: f64 = -0.0;

/// [`Rest`] as all lanes read it.
#[derive(Clone, Copy)]
pub struct RestSplats([Splat; 4]);

impl RestSplats {
    /// Constants of such segments.
    #[inline(always)]
    pub fn of(rest: &Rest) -> RestSplats {
        RestSplats([rest.spacing, 2.0 * rest.spacing, rest.inverse_square, rest.twice_strain].map(Splat::of))
    }

    /// Constants of a lane group of them.
    #[inline(always)]
    pub fn lanes<L: Lane>(&self) -> RestLanes<L> {
        let [spacing, twice_spacing, inverse_square, twice_strain] = &self.0;
        RestLanes {
            chord: [spacing.lanes(), L::splat(NONE)],
            twice_chord: [twice_spacing.lanes(), L::splat(NONE)],
            inverse_square: inverse_square.lanes(),
            twice_strain: twice_strain.lanes(),
        }
    }
}

/// Constants of several segments at rest. Lengths in node spacings along x.
#[derive(Clone, Copy, Debug)]
pub struct RestLanes<L> {
    /// Rest vector c from end to end: its parts along the direction of the segment in a flat sheet and along
    /// z.
    pub chord: [L; 2],
    /// 2 c.
    pub twice_chord: [L; 2],
    /// 1/l^2.
    pub inverse_square: L,
    /// Twice the strain at rest, q_0.
    pub twice_strain: L,
}

impl<L: Lane> RestLanes<L> {
    /// Segments with another rest vector.
    #[inline(always)]
    pub fn rotated(self, chord: [L; 2]) -> RestLanes<L> {
        RestLanes { chord, twice_chord: [chord[0].add(chord[0]), chord[1].add(chord[1])], ..self }
    }

    /// (M2) Twice the Green-Lagrange strain, q = 2 e = U^2 - 1 = d.(d + 2 c)/l^2 + q_0. `d`: relative
    /// displacement of the ends, along the direction of the segment in a flat sheet first.
    #[inline(always)]
    pub fn twice_strain(&self, d: [L; 3]) -> L {
        let [along, across] = self.twice_chord;
        let change = d[0].mul(d[0].add(along)).add(d[1].mul(d[1])).add(d[2].mul(d[2].add(across)));
        change.mul(self.inverse_square).add(self.twice_strain)
    }

    /// (M4) Force on the first node: stress times section along the present direction c + d, N = A_0 U S, by
    /// components. `d`: as for [`RestLanes::twice_strain`].
    #[inline(always)]
    pub fn force(&self, stress: L, d: [L; 3]) -> [L; 3] {
        let [x, y, z] = self.end_to_end(d);
        [stress.mul(x), stress.mul(y), stress.mul(z)]
    }

    /// Vector from end to end, c + d.
    #[inline(always)]
    pub fn end_to_end(&self, d: [L; 3]) -> [L; 3] {
        [d[0].add(self.chord[0]), d[1], d[2].add(self.chord[1])]
    }
}

/// Part of the tension at the critical stretch up to which the bending viscosity grows with the tension.
const FULL_BENDING: f64 = 0.1;

/// Viscosity of the yarns of one direction, in the stepper's units: strain rates in 1 per step, velocities in
/// h/dt.
///
/// Method: with the speed c of sound along the yarn and its mass mu per length, a segment that is stretched
/// at the rate dU/dt = r pulls by mu c b_1 (h r) U^2 + mu b_2 (h r)^2 U^3 more than the law says, the second
/// part only while it is stretched (von Neumann and Richtmyer). Along a yarn the moment mu c b_3 (v_{i-1} - 2
/// v_i + v_{i+1}) acts on three neighbours as -1, 2, -1.
/// Limits: taut yarn only. A segment that has just become taut counts as stretched from its natural length,
/// so that no force jumps, and none pushes.
/// Reference: J. von Neumann, R. D. Richtmyer, J. Appl. Phys. 21 (1950) 232; docs/model.md, "Viscosity".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viscosity {
    /// Time of the linear part, passes: b_1 over c dt/h.
    linear: f64,
    /// Coefficient of the quadratic part, passes squared: b_2 over 2 (c dt/h)^2.
    quadratic: f64,
    /// Coefficient of the moment: b_3 c dt/h.
    bending: f64,
    /// 1 over the tension from which on the moment is whole.
    per_tension: f64,
}

impl Viscosity {
    /// None.
    pub const NONE: Viscosity = Viscosity { linear: 0.0, quadratic: 0.0, bending: 0.0, per_tension: 0.0 };

    /// The parts b_1, b_2 and b_3 of yarn with this mean stiffness kk, in the stepper's units, and twice the
    /// critical strain. (c dt/h)^2 = 2 kk.
    pub fn of([linear, quadratic, bending]: [f64; 3], stiffness: f64, critical: f64) -> Viscosity {
        let sound = math::sqrt(2.0 * stiffness);
        Viscosity {
            linear: linear / sound,
            quadratic: quadratic / (4.0 * stiffness),
            bending: bending * sound,
            per_tension: 1.0 / (FULL_BENDING * critical * stiffness),
        }
    }

    /// The parts along the yarn as all lanes read them.
    #[inline(always)]
    pub fn splats(&self) -> ViscositySplats {
        ViscositySplats([Splat::of(self.linear), Splat::of(self.quadratic)])
    }

    /// Viscosity for several segments at once.
    #[inline(always)]
    pub fn lanes<L: Lane>(&self) -> ViscosityLanes<L> {
        ViscosityLanes {
            linear: L::splat(self.linear),
            quadratic: L::splat(self.quadratic),
            bending: L::splat(self.bending),
            bending_per_tension: L::splat(self.bending * self.per_tension),
        }
    }
}

/// [`Viscosity`] of several segments at once.
#[derive(Clone, Copy)]
pub struct ViscosityLanes<L> {
    linear: L,
    quadratic: L,
    bending: L,
    bending_per_tension: L,
}

/// [`Viscosity`] along the yarn as all lanes read it.
pub struct ViscositySplats([Splat; 2]);

impl ViscositySplats {
    /// Constants of a lane group; without moments.
    #[inline(always)]
    pub fn lanes<L: Lane>(&self) -> ViscosityLanes<L> {
        let (zero, [linear, quadratic]) = (L::splat(0.0), &self.0);
        ViscosityLanes {
            linear: linear.lanes(),
            quadratic: quadratic.lanes(),
            bending: zero,
            bending_per_tension: zero,
        }
    }
}

impl<L: Lane> ViscosityLanes<L> {
    /// (M16) Twice the strain that would give the stress with its viscous part, at least 0. `now`: twice the
    /// strain of taut yarn, 0 of slack one, at t_n; `growth`: its growth since t_{n-1}, of a bar times its
    /// segments, over whose length the rate is taken.
    #[inline(always)]
    pub fn twice_strain(&self, now: L, growth: L) -> L {
        let zero = L::splat(0.0);
        let per_growth = growth.max(zero).mul(self.quadratic).add(self.linear);
        growth.mul(per_growth).add(now).max(zero)
    }

    /// (M17) Factor of the moment between two segments with these stresses: whole where both are taut.
    #[inline(always)]
    pub fn bending(&self, before: L, after: L) -> L {
        before.min(after).mul(self.bending_per_tension).min(self.bending)
    }
}

/// Strain energy, the integral of stress over strain: alpha E e^2/2 in tension. `stiffness`: half of alpha E.
#[inline(always)]
pub fn strain_energy<L: Lane>(stiffness: L, twice_strain: L) -> L {
    let taut = twice_strain.max(L::splat(0.0));
    L::splat(0.25).mul(stiffness).mul(taut).mul(taut)
}

impl DamageLaw {
    /// The law of a segment with a critical stretch of its own.
    pub fn at(&self, critical_stretch: f64) -> DamageLaw {
        DamageLaw { critical_stretch, ..*self }
    }

    /// Twice the strain at the critical stretch: no damage up to it.
    pub fn critical_twice_strain(&self) -> f64 {
        twice_strain_at(self.critical_stretch)
    }

    /// Whether a strain damages a segment further: it is beyond the critical one and beyond all before.
    #[inline]
    pub fn is_damaging(&self, twice_strain: f64, history: f64) -> bool {
        twice_strain > history && twice_strain > self.critical_twice_strain()
    }

    /// Damage of a segment after a strain that is damaging.
    pub fn damage(&self, damage_rate: f64, twice_strain: f64) -> Damage {
        let alpha = self.alpha(damage_rate, twice_strain);
        Damage { alpha, history: if alpha == 0.0 { FAILED } else { twice_strain } }
    }

    /// (M5) Damage variable alpha in [0, 1] after the largest strain ever seen; 1 up to and including U_c.
    pub fn alpha(&self, damage_rate: f64, largest_twice_strain: f64) -> f64 {
        if largest_twice_strain <= self.critical_twice_strain() {
            return 1.0;
        }
        let beyond = stretch(largest_twice_strain) - self.critical_stretch;
        let alpha = self.a * (math::exp(-damage_rate * beyond) - self.b);
        if alpha <= self.alpha_fail {
            0.0
        } else if alpha > 1.0 {
            1.0
        } else {
            alpha
        }
    }

    /// Stretch beyond U_c at which the law reaches `alpha`: the inverse of [`DamageLaw::alpha`] inside (0, A
    /// (1 - B)).
    fn beyond_critical(&self, damage_rate: f64, alpha: f64) -> f64 {
        let decay = alpha / self.a + self.b;
        // A law without offset never reaches exactly 0: the smallest positive number stands for it.
        -math::ln(math::max(decay, f64::MIN_POSITIVE)) / damage_rate
    }

    /// Where alpha is just before it becomes 0: `alpha_fail`, or less if the law starts below it and so fails
    /// at U_c.
    fn cut(&self) -> f64 {
        let first = self.a * (1.0 - self.b);
        math::min(self.alpha_fail, first)
    }

    /// Stretch at which a segment fails (alpha becomes 0).
    pub fn failure_stretch(&self, damage_rate: f64) -> f64 {
        self.critical_stretch + self.beyond_critical(damage_rate, self.cut())
    }

    /// Energy dissipated per undeformed volume, J/m^3, as a function of the present alpha alone: the strain
    /// energy released while alpha fell from 1, integral of (E/2) e(U)^2 (-d alpha).
    pub fn dissipated(&self, segment: &Segment, alpha: f64) -> f64 {
        let first = self.a * (1.0 - self.b);
        if alpha >= 1.0 {
            return 0.0;
        }
        let half_modulus = 0.5 * segment.modulus;
        let (uc, rate) = (self.critical_stretch, segment.damage_rate);
        let critical = self.critical_twice_strain();
        // A law that starts below 1 drops at once at U_c.
        let mut density = if first < 1.0 { half_modulus * (1.0 - first) * (0.25 * critical * critical) } else { 0.0 };
        let smooth_end = if alpha > 0.0 { alpha } else { self.cut() };
        let u = self.beyond_critical(rate, smooth_end);
        let decay = math::exp(-rate * u);
        // e(U_c + s)^2 = c0 + c1 s + c2 s^2 + c3 s^3 + c4 s^4; J_k = integral of s^k lambda exp(-lambda s).
        let c = [0.25 * critical * critical, uc * critical, 0.5 * (3.0 * uc * uc - 1.0), uc, 0.25];
        let mut power = 1.0;
        let mut integral = 1.0 - decay;
        let mut sum = c[0] * integral;
        for (k, coefficient) in c.iter().enumerate().skip(1) {
            power *= u;
            integral = -power * decay + (k as f64 / rate) * integral;
            sum += coefficient * integral;
        }
        density += half_modulus * self.a * sum;
        if alpha <= 0.0 {
            let last = twice_strain_at(uc + u);
            density += half_modulus * self.cut() * (0.25 * last * last);
        }
        density
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::close;

    const LAW: DamageLaw = DamageLaw { critical_stretch: 1.03, a: 1.0, b: 0.0, alpha_fail: 0.01 };
    const YARN: Segment = Segment { modulus: 140.21e9, damage_rate: 230.6 };

    /// Second Piola-Kirchhoff stress, Pa, of a segment pulled along its rest direction.
    fn stress_at(alpha: f64, stretch: f64) -> f64 {
        stress(0.5 * alpha * YARN.modulus, Rest::PLAIN.lanes().twice_strain([stretch - 1.0, 0.0, 0.0]))
    }

    fn alpha_at(law: &DamageLaw, stretch: f64) -> f64 {
        law.alpha(YARN.damage_rate, twice_strain_at(stretch))
    }

    #[test]
    fn a_law_that_starts_below_its_end_releases_all_at_the_critical_stretch() {
        let critical = LAW.critical_twice_strain();
        let stored = strain_energy(0.5 * YARN.modulus, critical);
        // Without an offset, and with one: 0.5 (1 - 0.5) is below 0.4.
        let with_offset = DamageLaw { a: 0.5, b: 0.5, alpha_fail: 0.4, ..LAW };
        for law in [0.01, 0.005, 1e-100, 3e-312].map(|a| DamageLaw { a, ..LAW }).into_iter().chain([with_offset]) {
            assert_eq!(law.alpha(YARN.damage_rate, critical.next_up()), 0.0);
            close(law.dissipated(&YARN, 0.0), stored, 1e-12);
            close(law.failure_stretch(YARN.damage_rate), law.critical_stretch, 1e-15);
        }
    }

    #[test]
    fn alpha_never_grows_with_the_largest_stretch() {
        // The history variable stands for the running minimum of alpha only if the computed law is monotone,
        // to the last bit.
        let mut last = 1.0;
        let mut q = LAW.critical_twice_strain();
        for _ in 0..2_000_000 {
            q = q.next_up();
            let alpha = LAW.alpha(YARN.damage_rate, q);
            assert!(alpha <= last);
            last = alpha;
        }
        for i in 0..400_000 {
            let alpha = alpha_at(&LAW, 1.0300001 + i as f64 * 6e-8);
            assert!(alpha <= last);
            last = alpha;
        }
    }

    #[test]
    fn stored_plus_dissipated_depends_on_the_largest_stretch_only() {
        // Work of a monotone pull to `largest`, by quadrature of the nominal stress P = U S; with offset and
        // first drop, too.
        let (largest, n) = (1.04, 400_000);
        let width = (largest - 1.0) / n as f64;
        for law in [LAW, DamageLaw { a: 0.9, b: 0.02, ..LAW }] {
            let work: f64 = (0..n)
                .map(|i| {
                    let u = 1.0 + (i as f64 + 0.5) * width;
                    u * stress_at(alpha_at(&law, u), u) * width
                })
                .sum();
            let alpha = alpha_at(&law, largest);
            let stored = strain_energy(0.5 * alpha * YARN.modulus, twice_strain_at(largest));
            close(stored + law.dissipated(&YARN, alpha), work, 1e-7);
        }
        // The whole work of the preset's yarn, with what the cut releases, J/m^3.
        close(LAW.dissipated(&YARN, 0.0), 86.6265224e6, 1e-8);
    }

    #[test]
    fn limits_of_the_law() {
        // A value at alpha_fail itself is cut, the next above is not.
        let q = twice_strain_at(1.035);
        let alpha = LAW.alpha(YARN.damage_rate, q);
        assert_eq!(DamageLaw { alpha_fail: alpha, ..LAW }.alpha(YARN.damage_rate, q), 0.0);
        assert_eq!(DamageLaw { alpha_fail: alpha.next_down(), ..LAW }.alpha(YARN.damage_rate, q), alpha);
        // Without offset and cut it ends where exp(-lambda s) leaves the normal numbers, 1022 ln 2 on.
        let endless = DamageLaw { alpha_fail: 0.0, ..LAW };
        close(endless.failure_stretch(100.0), 1.03 + 1022.0 * core::f64::consts::LN_2 / 100.0, 1e-14);
        // With an offset: exp(-lambda s) = B + alpha_fail/A.
        let law = DamageLaw { a: 0.8, b: 0.1, alpha_fail: 0.04, ..LAW };
        close(law.failure_stretch(100.0), 1.03 - math::ln(0.15) / 100.0, 1e-14);
    }

    /// At any strain and growth: nothing where the segment is slack, never a push in all, never work out of
    /// nothing, and no jump where the segment becomes taut.
    #[test]
    fn viscosity_only_takes() {
        let viscosity = Viscosity::of([0.5, 3.0, 0.1], 0.07, LAW.critical_twice_strain()).lanes::<f64>();
        for k in -400..400 {
            let now = math::max(1e-4 * f64::from(k), 0.0);
            for n in -400..400 {
                let before = math::max(1e-4 * f64::from(n), 0.0);
                let both = viscosity.twice_strain(now, now - before);
                let viscous = both - now;
                assert!(viscous * (now - before) >= 0.0 && both >= 0.0, "{now} {before}");
                assert!(now > 0.0 || viscous == 0.0, "{now} {before}");
                assert!(viscous.abs() <= now * 20.0);
            }
        }
    }

    #[test]
    fn the_moment_is_whole_from_a_tenth_of_the_critical_tension_on() {
        let (kk, critical) = (0.07, LAW.critical_twice_strain());
        let viscosity = Viscosity::of([0.0, 0.0, 0.06], kk, critical).lanes::<f64>();
        let whole = 0.06 * math::sqrt(2.0 * kk);
        let at = |part: f64, other: f64| viscosity.bending(kk * critical * part, kk * critical * other);
        close(at(0.1001, 0.9), whole, 1e-15);
        close(at(0.9, 0.05), 0.5 * whole, 1e-12);
        assert_eq!((at(0.0, 0.5), at(0.5, 0.0)), (0.0, 0.0));
    }
}
