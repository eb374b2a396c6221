//! Random draws keyed by (seed, segment, purpose): no traversal order, no generator state to save.
//!
//! Method: two rounds of splitmix64 turn the key into the seed of a PCG (`Pcg64Mcg`, 128-bit multiplicative
//! congruential, XSL-RR output), whose first two outputs become one standard normal by Box-Muller.
//! Limits: |normal| <= 8.6 (the smallest uniform is 2^-54).
//! Reference: G. E. P. Box, M. E. Muller, Ann. Math. Stat. 29 (1958) 610; M. E. O'Neill, HMC-CS-2014-0905
//! (2014).

use crate::ground::math;
use rand_core::Rng;
use rand_pcg::Pcg64Mcg;

/// No normal number is larger.
pub const LARGEST_NORMAL: f64 = 8.7;

/// Purpose of a sample; part of its key, so that samples for different purposes are independent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Young's modulus of a segment.
    Modulus = 0,
    /// Damage rate of a segment.
    DamageRate = 1,
    /// Lateral offset of a fibril.
    FibrilOffset = 2,
    /// Strength of a segment, and with `retry` 1 what the segments of a woven yarn share of it.
    Strength = 3,
}

/// One step of the splitmix64 sequence, used as a 64-bit mixing function.
pub fn splitmix64(x: u64) -> u64 {
    let z = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A standard normal number that depends on its key alone. `retry` counts redraws of a refused value.
pub fn normal(seed: u64, segment: u64, purpose: Purpose, retry: u64) -> f64 {
    let key = key(seed, segment, purpose as u64, retry);
    let mut generator = Pcg64Mcg::new(((key as u128) << 64) | splitmix64(key) as u128);
    let radius = math::sqrt(-2.0 * math::ln(uniform(generator.next_u64())));
    radius * math::cos(core::f64::consts::TAU * uniform(generator.next_u64()))
}

/// The key of a draw. Four purposes share the labels of a seed; the next four have a seed of their own.
fn key(seed: u64, segment: u64, purpose: u64, retry: u64) -> u64 {
    let seed = if purpose < 4 { seed } else { splitmix64(seed ^ splitmix64(purpose / 4)) };
    let label = segment.wrapping_mul(4).wrapping_add(purpose % 4).wrapping_add(retry << 40);
    splitmix64(seed.wrapping_add(splitmix64(label)))
}

/// The upper 53 bits as a number in the open interval (0, 1).
fn uniform(bits: u64) -> f64 {
    ((bits >> 11) as f64 + 0.5) * (1.0 / 9_007_199_254_740_992.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splitmix_known_answer() {
        // First output of the reference generator started at 0.
        assert_eq!(splitmix64(0), 0xe220_a839_7b1d_cdaf);
    }

    #[test]
    fn normals_have_mean_zero_and_unit_variance() {
        let n = 200_000;
        let (mut sum, mut squares) = (0.0, 0.0);
        for segment in 0..n {
            let g = normal(7, segment, Purpose::Modulus, 0);
            sum += g;
            squares += g * g;
        }
        // Four standard errors.
        assert!((sum / n as f64).abs() < 4.0 / math::sqrt(n as f64));
        assert!((squares / n as f64 - 1.0).abs() < 4.0 * math::sqrt(2.0 / n as f64));
    }

    /// Numbers to come, too.
    #[test]
    fn no_two_purposes_segments_or_redraws_share_a_key() {
        let all = (0..12).flat_map(|purpose| (0..500).flat_map(move |k| (0..3).map(move |retry| (k, purpose, retry))));
        let keys: std::collections::BTreeSet<u64> = all.map(|(k, purpose, retry)| key(1, k, purpose, retry)).collect();
        assert_eq!(keys.len(), 12 * 500 * 3);
    }

    #[test]
    fn purposes_are_uncorrelated() {
        let n = 100_000;
        let product: f64 =
            (0..n).map(|s| normal(1, s, Purpose::Modulus, 0) * normal(1, s, Purpose::DamageRate, 0)).sum();
        assert!((product / n as f64).abs() < 4.0 / math::sqrt(n as f64));
    }
}
