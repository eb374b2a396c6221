//! From fibrils to the yarn law: least squares per yarn.
//!
//! Method: the law alpha = A (exp(-lambda (U - U_c)) - B) is fitted to a yarn's staircase on a uniform grid
//! from U_c to its last rupture. For a given lambda, A and A B follow from linear least squares; lambda by
//! golden section on its logarithm.
//! Limits: lambda in [3, 3000]; the grid has [`GRID`] points.
//! Reference: J. Kiefer, Proc. Amer. Math. Soc. 4 (1953) 502.

use crate::ground::math;
use crate::yarn::fibril::BundleYarn;

/// Points of the fit's grid.
pub const GRID: u32 = 400;

/// Parameters that a fit may vary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fit {
    /// lambda alone, with A = 1 and B = 0 (the paper's regression).
    Rate,
    /// lambda, A and B.
    RateAndConstants,
}

/// A fitted law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedLaw {
    /// lambda.
    pub damage_rate: f64,
    /// A.
    pub a: f64,
    /// B.
    pub b: f64,
    /// Root mean square misfit of alpha over the grid.
    pub misfit: f64,
}

/// Fits the damage law to a yarn.
pub fn fit(yarn: &BundleYarn<'_>, critical_stretch: f64, kind: Fit) -> FittedLaw {
    let width = (yarn.last_rupture() - critical_stretch) / (GRID - 1) as f64;
    let mut target = [0.0; GRID as usize];
    for (k, slot) in target.iter_mut().enumerate() {
        // The first point lies at U_c itself, where the staircase still stands at 1.
        *slot = if k == 0 { 1.0 } else { yarn.alpha(critical_stretch + k as f64 * width) };
    }
    let law_at = |log_rate: f64| law_of_rate(&target, width, math::exp(log_rate), kind);
    // Golden section between lambda = 3 and 3000.
    const SECTION: f64 = 0.618_033_988_749_894_9;
    let (mut low, mut high) = (math::ln(3.0), math::ln(3000.0));
    let mut x1 = high - SECTION * (high - low);
    let mut x2 = low + SECTION * (high - low);
    let (mut law1, mut law2) = (law_at(x1), law_at(x2));
    while high - low > 1e-7 {
        if law1.misfit < law2.misfit {
            high = x2;
            (x2, law2) = (x1, law1);
            x1 = high - SECTION * (high - low);
            law1 = law_at(x1);
        } else {
            low = x1;
            (x1, law1) = (x2, law2);
            x2 = low + SECTION * (high - low);
            law2 = law_at(x2);
        }
    }
    if law1.misfit < law2.misfit { law1 } else { law2 }
}

/// The best law of a given rate: alpha = A x - C with x = exp(-lambda s) and C = A B.
fn law_of_rate(target: &[f64], width: f64, damage_rate: f64, kind: Fit) -> FittedLaw {
    let n = target.len() as f64;
    // x falls by the same factor from point to point: one exponential a rate.
    let factor = math::exp(-damage_rate * width);
    let (a, c) = match kind {
        Fit::Rate => (1.0, 0.0),
        Fit::RateAndConstants => {
            let (mut x, mut sx, mut sy, mut sxx, mut sxy) = (1.0, 0.0, 0.0, 0.0, 0.0);
            for &y in target {
                sx += x;
                sy += y;
                sxx += x * x;
                sxy += x * y;
                x *= factor;
            }
            let a = (n * sxy - sx * sy) / (n * sxx - sx * sx);
            (a, (a * sx - sy) / n)
        }
    };
    let (mut x, mut sum) = (1.0, 0.0);
    for &y in target {
        let miss = a * x - c - y;
        sum += miss * miss;
        x *= factor;
    }
    FittedLaw { damage_rate, a, b: c / a, misfit: math::sqrt(sum / n) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::yarn::fibril::Bundle;
    use std::vec;

    /// Powell and Zohdi: E 140.21 GPa, mean lambda 230.6; their line over a population is in the evidence.
    #[test]
    fn the_papers_mean_rate() {
        let (bundle, count) = (Bundle::zylon(), 3000);
        let mut memory = vec![0.0; BundleYarn::reals(&bundle)];
        let (mut modulus, mut rate) = (0.0, 0.0);
        for number in 0..count {
            let yarn = BundleYarn::draw(&bundle, 1, number, &mut memory).unwrap();
            modulus += yarn.modulus(1.0) / count as f64;
            rate += fit(&yarn, bundle.critical_stretch, Fit::Rate).damage_rate / count as f64;
        }
        assert!((modulus / 1e9 - 140.228).abs() < 0.15 && (rate - 230.6).abs() < 1.0, "{modulus:e} {rate}");
    }

    #[test]
    fn a_law_is_found_again() {
        // The staircase replaced by a law with known constants.
        let (rate, a, b) = (180.0, 0.8, 0.01);
        let width = 1e-4;
        let mut target = [0.0; GRID as usize];
        for (k, slot) in target.iter_mut().enumerate() {
            *slot = a * (math::exp(-rate * k as f64 * width) - b);
        }
        let law = law_of_rate(&target, width, rate, Fit::RateAndConstants);
        assert!((law.a - a).abs() < 1e-12 && (law.b - b).abs() < 1e-12 && law.misfit < 1e-13);
    }
}
