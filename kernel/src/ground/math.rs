//! The only place for transcendental functions: software code from `libm`, so that every target computes the
//! same bits.
//!
//! Only `+ - * /` and these functions are used in the kernel. No fused multiply-add, no std floats.

/// The greater of two numbers; `b` if either is NaN or both are zeros.
#[inline]
pub fn max(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The smaller of two numbers; `b` if either is NaN or both are zeros.
#[inline]
pub fn min(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The size of a number; -0 and NaN stay as they are.
#[inline]
pub fn abs(x: f64) -> f64 {
    if x < 0.0 { -x } else { x }
}

/// Square root, correctly rounded.
pub fn sqrt(x: f64) -> f64 {
    libm::sqrt(x)
}

/// Natural exponential.
pub fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// Natural logarithm.
pub fn ln(x: f64) -> f64 {
    libm::log(x)
}

/// Logarithm of 1 + x, exact also where x is small.
pub fn ln_1p(x: f64) -> f64 {
    libm::log1p(x)
}

/// Part of the standard normal distribution above z.
pub fn normal_above(z: f64) -> f64 {
    0.5 * libm::erfc(z * core::f64::consts::FRAC_1_SQRT_2)
}

/// Sine of an angle in radians.
pub fn sin(x: f64) -> f64 {
    libm::sin(x)
}

/// Cosine of an angle in radians.
pub fn cos(x: f64) -> f64 {
    libm::cos(x)
}

/// Sine and cosine of an angle in [-pi, pi], to some 1e-15: series for an eighth of it, and three doublings.
/// For where the reduction of any angle, which [`sin`] needs, would take half a kilobyte too much stack.
pub fn sine_and_cosine(angle: f64) -> [f64; 2] {
    const SINE: [f64; 6] =
        [-1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0, 1.0 / 362_880.0, -1.0 / 39_916_800.0, 1.0 / 6_227_020_800.0];
    const VERSINE: [f64; 7] = [
        1.0 / 2.0,
        -1.0 / 24.0,
        1.0 / 720.0,
        -1.0 / 40_320.0,
        1.0 / 3_628_800.0,
        -1.0 / 479_001_600.0,
        1.0 / 87_178_291_200.0,
    ];
    let part = 0.125 * angle;
    let squared = part * part;
    let series = |terms: &[f64]| terms.iter().rev().fold(0.0, |sum, term| sum * squared + term);
    // The versine, 1 less the cosine, keeps its digits where it is small.
    let (mut sine, mut versine) = (part + part * (squared * series(&SINE)), squared * series(&VERSINE));
    for _ in 0..3 {
        (sine, versine) = (2.0 * sine * (1.0 - versine), 2.0 * sine * sine);
    }
    [sine, 1.0 - versine]
}

/// Angle of the point (x, y) in radians, in [-pi, pi].
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// Nearest integer, halves away from zero.
pub fn round(x: f64) -> f64 {
    libm::round(x)
}

/// Smallest integer not below `x`.
pub fn ceil(x: f64) -> f64 {
    libm::ceil(x)
}

/// Euclidean length of a vector; the squares are added in index order.
pub fn length(v: [f64; 3]) -> f64 {
    sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_are_those_of_libm() {
        for k in -1000..=1000 {
            let angle = f64::from(k) * (core::f64::consts::PI / 1000.0);
            let [sine, cosine] = sine_and_cosine(angle);
            assert!(abs(sine - sin(angle)) < 4e-15 && abs(cosine - cos(angle)) < 4e-15, "{angle}");
            assert_eq!(sine_and_cosine(-angle), [-sine, cosine]);
        }
    }
}
