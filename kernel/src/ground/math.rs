//! The only place for transcendental functions: software code from `libm`, so that every target computes the same bits.
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
