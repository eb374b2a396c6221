//! The yarn law that steps against itself in 256 bits: largest rounding errors over random laws and
//! stretches, and at the edges.
//!
//! Method: the reference takes the same doubles and evaluates the formulas of `yarn/law.rs` in 256 bits,
//! rounded correctly. An ulp is the distance of neighbouring doubles at the exact value. alpha falls as
//! exp(-lambda U): what one ulp of the stretch makes of it is lambda times as much, so alpha's error is also
//! told in ulp of the stretch.
#![allow(clippy::disallowed_methods)] // Expected values may come from the host's own functions.

use dashu_float::FBig;
use dashu_float::round::mode::HalfEven;
use fabric_kernel::internals::law::{self as yarn, DamageLaw, Rest, Segment};

type Exact = FBig<HalfEven, 2>;

/// A double in 256 bits.
fn exact(x: f64) -> Exact {
    Exact::try_from(x).expect("finite").with_precision(256).value()
}

/// Distance of neighbouring doubles at |x|.
fn ulp(x: f64) -> f64 {
    let x = x.abs();
    x.next_up() - x
}

/// Error of a computed value, in its own unit.
fn error(computed: f64, reference: &Exact) -> f64 {
    (exact(computed) - reference).to_f64().value().abs()
}

/// Error in ulp of the exact value.
fn ulps(computed: f64, reference: &Exact) -> f64 {
    error(computed, reference) / ulp(reference.to_f64().value())
}

/// Random numbers in [0, 1): the generator SplitMix64.
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        let part = fabric_tests::number(self.0);
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        low + (high - low) * part
    }
}

/// A law within the accepted ranges; every second one is the preset's.
fn law(random: &mut Random, k: u32) -> (DamageLaw, Segment) {
    if k.is_multiple_of(2) {
        let law = DamageLaw { critical_stretch: 1.03, a: 1.0, b: 0.0, alpha_fail: 0.01 };
        return (law, Segment { modulus: random.between(130e9, 150e9), damage_rate: 230.6 });
    }
    let b = random.between(0.0, 0.5);
    let law = DamageLaw {
        critical_stretch: random.between(1.005, 1.2),
        a: random.between(0.5, 1.0) / (1.0 - b),
        b,
        alpha_fail: random.between(0.0, 0.1),
    };
    (law, Segment { modulus: random.between(1e9, 300e9), damage_rate: random.between(3.0, 1000.0) })
}

/// alpha of a law at the largest q = U^2 - 1 beyond the critical one, before it is cut.
fn exact_alpha(law: &DamageLaw, rate: f64, q: f64) -> Exact {
    let stretch = (exact(1.0) + exact(q)).sqrt();
    let decay = (-exact(rate) * (stretch - exact(law.critical_stretch))).exp();
    exact(law.a) * (decay - exact(law.b))
}

/// Energy dissipated while alpha fell to a value above `alpha_fail`, J/m^3: the integrals of s^k lambda
/// exp(-lambda s).
fn exact_dissipated(law: &DamageLaw, segment: &Segment, alpha: f64) -> Exact {
    let (half, rate, uc) =
        (exact(0.5) * exact(segment.modulus), exact(segment.damage_rate), exact(law.critical_stretch));
    let decay = exact(alpha) / exact(law.a) + exact(law.b);
    let u = -decay.ln() / &rate;
    let excess = &uc * &uc - exact(1.0);
    let first = exact(law.a) * (exact(1.0) - exact(law.b));
    let quarter = exact(0.25) * &excess * &excess;
    let drop = if first < exact(1.0) { &half * (exact(1.0) - &first) * &quarter } else { exact(0.0) };
    let c = [quarter, &uc * &excess, exact(0.5) * (exact(3.0) * &uc * &uc - exact(1.0)), uc, exact(0.25)];
    let mut integral = exact(1.0) - &decay;
    let (mut sum, mut power) = (&c[0] * &integral, exact(1.0));
    for (k, coefficient) in c.iter().enumerate().skip(1) {
        power *= &u;
        integral = exact(k as f64) / &rate * integral - &power * &decay;
        sum += coefficient * &integral;
    }
    drop + half * exact(law.a) * sum
}

/// Largest errors found.
#[derive(Default)]
struct Worst {
    points: u32,
    /// Error of alpha, ulp, with the preset's law.
    alpha: f64,
    /// Error of alpha, in ulp of the stretch, what one ulp of alpha itself makes left out.
    in_stretch: f64,
    /// Error of the force, ulp.
    force: f64,
    /// Points where one of the two has failed and the other has not.
    at_cut: u32,
}

impl Worst {
    fn point(&mut self, law: &DamageLaw, segment: &Segment, stretch: f64) {
        let (rate, d) = (segment.damage_rate, [stretch - 1.0, 0.0, 0.0]);
        let q = Rest::PLAIN.lanes().twice_strain(d);
        let alpha = if law.is_damaging(q, 0.0) { law.damage(rate, q).alpha } else { 1.0 };
        if q > law.critical_twice_strain() {
            let reference = exact_alpha(law, rate, q);
            let value = reference.to_f64().value();
            if alpha > 0.0 && value > law.alpha_fail {
                let off = error(alpha, &reference);
                if law.b == 0.0 {
                    self.alpha = self.alpha.max(off / ulp(value));
                }
                // d alpha/dU = -lambda (alpha + A B).
                let slope = rate * (value + law.a * law.b);
                self.in_stretch =
                    self.in_stretch.max((off - 2.0 * ulp(value) - ulp(law.a)).max(0.0) / slope / ulp(stretch));
            } else if (alpha > 0.0) != (value > law.alpha_fail) {
                assert!((value - law.alpha_fail).abs() < 1e-12, "alpha {alpha} instead of {value}");
                self.at_cut += 1;
            }
        } else {
            assert_eq!(alpha, 1.0);
        }
        // The force at this alpha.
        let area = 1.075e-7;
        let stress = yarn::stress(0.5 * alpha * segment.modulus, q);
        let force = Rest::PLAIN.lanes().force(area * stress, d)[0];
        if force > 0.0 {
            let strain = exact(0.5) * (exact(stretch) * exact(stretch) - exact(1.0));
            let reference = exact(area) * exact(stretch) * exact(alpha) * exact(segment.modulus) * strain;
            self.force = self.force.max(ulps(force, &reference));
        } else {
            assert!(alpha == 0.0 || stretch <= 1.0, "no force at {stretch}");
        }
        self.points += 1;
    }
}

const RANDOM_POINTS: u32 = 100_000;

/// Largest errors of strain and force, ulp, of segments turned and stretched at will: in the flat sheet they
/// are one spacing apart and as long as that, or have another distance and another stretch there, as with
/// crimp, pre-tension and unlike spacings. A strain is the sum of terms that may cancel: its error is
/// measured against the greatest of them.
fn of_directions(seed: u64, plain: bool) -> [f64; 2] {
    let mut random = Random(seed);
    let [mut strain, mut force] = [0.0f64; 2];
    for k in 0..RANDOM_POINTS {
        let spacing = if plain || k.is_multiple_of(3) { 1.0 } else { random.between(0.1, 10.0) };
        let at_rest = match plain {
            true => 1.0,
            false if k.is_multiple_of(2) => random.between(0.5, 1.0),
            false => random.between(1.0, 1.1),
        };
        let rest = if plain { Rest::PLAIN } else { Rest::of(spacing, at_rest) };
        let size = spacing * 10f64.powf(random.between(-6.0, 1.0));
        let d = [0, 1, 2].map(|_| size * random.between(-1.0, 1.0));
        let (q, [x, y, z]) = (rest.lanes().twice_strain(d), d.map(exact));
        let (rho, u) = (exact(spacing), exact(at_rest));
        let along = &rho + &x;
        let squared = &along * &along + &y * &y + &z * &z;
        let exact_q = squared * &u * &u / (&rho * &rho) - exact(1.0);
        let greatest = (d[0] * (d[0] + 2.0 * spacing)).abs().max(d[1] * d[1]).max(d[2] * d[2]);
        let greatest = (greatest * (at_rest / spacing).powi(2)).max((at_rest * at_rest - 1.0).abs());
        strain = strain.max(error(q, &exact_q) / ulp(greatest));
        let stiffness = random.between(1e9, 1e11);
        let stress = yarn::stress(stiffness, q);
        let found = rest.lanes().force(stress, d);
        let stress = exact(stiffness) * exact(q.max(0.0));
        for (found, reference) in found.into_iter().zip([&stress * along, &stress * y, &stress * z]) {
            if q > 0.0 {
                force = force.max(ulps(found, &reference));
            } else {
                assert_eq!(found, 0.0);
            }
        }
    }
    println!("{RANDOM_POINTS} directions: q within {strain:.1} ulp of its greatest term, force within {force:.1} ulp");
    [strain, force]
}

/// Each rounding is at most an ulp of what it rounds. Force: three in a row. Strain: two in the first
/// product, one in each square, and two sums of up to two and three times the greatest term; at rest lengths
/// a scale of three roundings on up to three terms, and one more sum.
#[test]
fn strain_and_force_in_any_direction_are_those_of_256_bits_to_rounding() {
    let ([strain, force], [at_rest, force_there]) = (of_directions(22, true), of_directions(23, false));
    assert!(strain <= 9.0 && force <= 3.0 && at_rest <= 24.0 && force_there <= 3.0);
    // At rest the strain is that of the stretch, to the bit.
    assert_eq!(Rest::of(1.3, 1.01).lanes().twice_strain([0.0; 3]), yarn::twice_strain_at(1.01));
    assert_eq!(Rest::of(1.0, 1.0), Rest::PLAIN);
}

#[test]
fn the_law_is_that_of_256_bits_to_rounding() {
    let mut random = Random(20);
    let mut worst = Worst::default();
    for k in 0..RANDOM_POINTS {
        let (law, segment) = law(&mut random, k);
        let failure = law.failure_stretch(segment.damage_rate);
        let stretch = match k % 8 {
            0 => random.between(0.9, law.critical_stretch),
            _ => random.between(law.critical_stretch, failure),
        };
        worst.point(&law, &segment, stretch);
    }
    for k in 0..1000 {
        // Both sides of where yarn goes slack, of the critical stretch and of failure, and far beyond.
        let (law, segment) = law(&mut random, k);
        for edge in [1.0, law.critical_stretch, law.failure_stretch(segment.damage_rate)] {
            for stretch in [edge.next_down(), edge, edge.next_up(), edge.next_up().next_up()] {
                worst.point(&law, &segment, stretch);
            }
        }
        worst.point(&law, &segment, 2.0);
        worst.point(&law, &segment, 1e3);
    }
    let Worst { points, alpha, in_stretch, force, at_cut } = worst;
    println!(
        "figure 20: {points} points: alpha within {alpha:.0} ulp with the preset law, with any within what {in_stretch:.2} ulp of the \
         stretch make, 2 of its own aside; force at that alpha within {force:.1} ulp; {at_cut} points at failure where rounding decides"
    );
    assert!(points >= 100_000 && in_stretch <= 2.0 && force <= 4.0);
}

#[test]
fn dissipated_energy_is_that_of_256_bits() {
    let mut random = Random(21);
    let (mut absolute, mut relative) = (0.0f64, 0.0f64);
    const POINTS: u32 = 10_000;
    for k in 0..POINTS {
        let (law, segment) = law(&mut random, k);
        let highest = law.a * (1.0 - law.b);
        let alpha = random.between(law.alpha_fail.max(1e-3), highest);
        let (computed, reference) = (law.dissipated(&segment, alpha), exact_dissipated(&law, &segment, alpha));
        let whole = law.dissipated(&segment, 0.0);
        absolute = absolute.max(error(computed, &reference) / whole);
        // Where a tenth of the damage is done the value itself is a fair scale.
        if alpha < 0.9 * highest {
            relative = relative.max(error(computed, &reference) / reference.to_f64().value());
        }
    }
    println!(
        "figure 20: dissipated energy at {POINTS} points within {absolute:.1e} of the yarn's whole work, {relative:.1e} of itself once a \
         tenth of alpha is gone"
    );
    assert!(absolute < 1e-11, "{absolute:e}");
}
