//! The micro scale: a yarn as a bundle of randomly inclined fibrils under displacement control.
//!
//! Method: fibril j runs over the gauge length h with a lateral offset d_j ~ N(0, s_d^2), so its stretch is
//! smaller than the yarn's. With r_j = d_j^2/h^2 and w_j = (1 + r_j)^(-3/2) the yarn's modulus at the yarn
//! stretch U is E*(U) = (E_f/N_f) sum_j w_j xi_j(U), where xi_j = 0 once the fibril's own stretch reaches
//! U_c, that is once U^2 >= 1 + (U_c^2 - 1)(1 + r_j). Fibrils break in the order of their r_j, so a sorted
//! yarn needs only suffix sums.
//! Limits: fibrils carry load along the undeformed direction (the paper's equation 2); no interaction between
//! fibrils.
//! Reference: D. Powell, T. I. Zohdi, Composites Part B 40 (2009) 451, their fibril-level yarn model.

use crate::ground::math;
use crate::ground::random::{self, Purpose};
use crate::yarn::law::twice_strain_at;

/// Constants of the fibrils and of the gauge length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bundle {
    /// Fibrils in a yarn, N_f >= 1.
    pub fibrils: u32,
    /// Young's modulus of a fibril, Pa, > 0.
    pub modulus: f64,
    /// Gauge length h, m, > 0.
    pub gauge_length: f64,
    /// Standard deviation of the lateral offset, m, >= 0.
    pub offset_sd: f64,
    /// Stretch at which a fibril breaks, > 1.
    pub critical_stretch: f64,
}

impl Bundle {
    /// The paper's Zylon yarn; the offset is half of the 0.74 mm major semi-axis, which reproduces its
    /// modulus.
    pub fn zylon() -> Bundle {
        Bundle { fibrils: 350, modulus: 180e9, gauge_length: 0.725e-3, offset_sd: 0.37e-3, critical_stretch: 1.03 }
    }

    /// Weight of a fibril in the modulus: (1 + r)^(-3/2).
    fn weight(ratio: f64) -> f64 {
        let sum = 1.0 + ratio;
        1.0 / (sum * math::sqrt(sum))
    }

    /// Ratio r below which a fibril is broken at the yarn stretch U; 0 or less: all are whole.
    fn broken_below(&self, stretch: f64) -> f64 {
        twice_strain_at(stretch) / twice_strain_at(self.critical_stretch) - 1.0
    }

    /// Mean and standard deviation over all fibrils of E_f w, Pa, by quadrature over the Gaussian.
    /// A yarn's modulus has this mean, and this standard deviation divided by sqrt(N_f).
    pub fn expected_modulus(&self) -> (f64, f64) {
        let mean = self.modulus * self.expectation(Bundle::weight);
        let square = self.modulus * self.modulus * self.expectation(|r| Bundle::weight(r) * Bundle::weight(r));
        (mean, math::sqrt(square - mean * mean))
    }

    /// Integral of f(r(z)) over the standard normal z, by Simpson's rule up to 12 standard deviations.
    fn expectation(&self, f: impl Fn(f64) -> f64) -> f64 {
        const INTERVALS: u32 = 4000;
        let (scale, width) = (self.offset_sd / self.gauge_length, 12.0 / INTERVALS as f64);
        let density = |z: f64| math::exp(-0.5 * z * z) * f(scale * z * scale * z);
        let mut sum = density(0.0) + density(12.0);
        for k in 1..INTERVALS {
            sum += if k % 2 == 1 { 4.0 } else { 2.0 } * density(k as f64 * width);
        }
        // Both signs of z: 2/sqrt(2 pi).
        sum * width / 3.0 * (2.0 / math::sqrt(core::f64::consts::TAU))
    }
}

/// One drawn yarn on the caller's memory, fibrils sorted by the stretch at which they break.
pub struct BundleYarn<'a> {
    bundle: Bundle,
    /// r_j, ascending.
    ratios: &'a mut [f64],
    /// Sum of the weights of fibril j and all that break later; one number more, 0.
    carried: &'a mut [f64],
}

impl<'a> BundleYarn<'a> {
    /// Numbers of memory a yarn needs: 2 N_f + 1.
    pub fn reals(bundle: &Bundle) -> usize {
        2 * bundle.fibrils as usize + 1
    }

    /// Draws yarn `number` of the population `seed`. `memory`: [`BundleYarn::reals`] numbers; None if it is
    /// shorter or the bundle has no fibril.
    pub fn draw(bundle: &Bundle, seed: u64, number: u64, memory: &'a mut [f64]) -> Option<BundleYarn<'a>> {
        let count = bundle.fibrils as usize;
        let (ratios, rest) = memory.split_at_mut_checked(count)?;
        let carried = rest.get_mut(..count + 1).filter(|_| count > 0)?;
        let scale = bundle.offset_sd / bundle.gauge_length;
        for (j, ratio) in ratios.iter_mut().enumerate() {
            let fibril = number.wrapping_mul(bundle.fibrils as u64).wrapping_add(j as u64);
            let offset = scale * random::normal(seed, fibril, Purpose::FibrilOffset, 0);
            *ratio = offset * offset;
        }
        ratios.sort_unstable_by(f64::total_cmp);
        let mut sum = 0.0;
        let (last, others) = carried.split_last_mut()?;
        *last = 0.0;
        for (slot, &ratio) in others.iter_mut().zip(ratios.iter()).rev() {
            sum += Bundle::weight(ratio);
            *slot = sum;
        }
        Some(BundleYarn { bundle: *bundle, ratios, carried })
    }

    /// Fibrils broken at the yarn stretch U.
    pub fn broken(&self, stretch: f64) -> usize {
        if stretch < self.bundle.critical_stretch {
            return 0;
        }
        let below = self.bundle.broken_below(stretch);
        self.ratios.partition_point(|&ratio| ratio <= below)
    }

    /// Modulus E*(U), Pa, when the yarn is pulled monotonically to the stretch U.
    pub fn modulus(&self, stretch: f64) -> f64 {
        let carried = self.carried.get(self.broken(stretch)).copied().unwrap_or(0.0);
        self.bundle.modulus / self.bundle.fibrils as f64 * carried
    }

    /// Damage variable E*(U)/E_0: a staircase that only falls, 1 below U_c.
    pub fn alpha(&self, stretch: f64) -> f64 {
        self.modulus(stretch) / self.modulus(1.0)
    }

    /// Second Piola-Kirchhoff stress, Pa, of a monotone pull: E*(U) (U^2 - 1)/2.
    pub fn stress(&self, stretch: f64) -> f64 {
        self.modulus(stretch) * 0.5 * twice_strain_at(stretch)
    }

    /// Yarn stretch at which the k-th fibril to break does so, k from 0.
    pub fn rupture_stretch(&self, k: usize) -> Option<f64> {
        let excess = twice_strain_at(self.bundle.critical_stretch) * (1.0 + self.ratios.get(k)?);
        Some(math::sqrt(1.0 + excess))
    }

    /// Yarn stretch at which the last fibril breaks.
    pub fn last_rupture(&self) -> f64 {
        self.rupture_stretch(self.ratios.len().saturating_sub(1)).unwrap_or(self.bundle.critical_stretch)
    }

    /// Work per undeformed volume to rupture, J/m^3: every fibril's strain energy when it breaks, by d(e^2)/2
    /// between ruptures.
    pub fn work_to_rupture(&self) -> f64 {
        let mut work = 0.0;
        let mut before = 0.0;
        for k in 0..self.ratios.len() {
            let strain = 0.5 * twice_strain_at(self.rupture_stretch(k).unwrap_or(1.0));
            let carried = self.carried.get(k).copied().unwrap_or(0.0);
            work += 0.5 * carried * (strain * strain - before * before);
            before = strain;
        }
        self.bundle.modulus / self.bundle.fibrils as f64 * work
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;

    #[test]
    fn quadrature_of_the_population() {
        // Closed-form integrals over the Gaussian, to the digits of the reference table.
        let (mean, sd) = Bundle::zylon().expected_modulus();
        assert!((mean / 140.228082e9 - 1.0).abs() < 1e-6, "{mean}");
        assert!((sd / 38.039804e9 - 1.0).abs() < 1e-6, "{sd}");
        assert!((sd / math::sqrt(350.0) / 2.033313e9 - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_yarn_is_a_falling_staircase() {
        let bundle = Bundle::zylon();
        let mut memory = vec![0.0; BundleYarn::reals(&bundle)];
        let yarn = BundleYarn::draw(&bundle, 1, 0, &mut memory).unwrap();
        assert_eq!(yarn.alpha(1.0299), 1.0);
        let mut last = 1.0;
        for k in 0..2000 {
            let alpha = yarn.alpha(1.03 + k as f64 * 1e-4);
            assert!(alpha <= last && alpha >= 0.0);
            last = alpha;
        }
        assert_eq!(yarn.alpha(yarn.last_rupture() + 1e-9), 0.0);
        assert_eq!(yarn.broken(yarn.rupture_stretch(9).unwrap() + 1e-12), 10);
    }

    #[test]
    fn an_aligned_yarn_breaks_at_once() {
        let bundle = Bundle { offset_sd: 0.0, ..Bundle::zylon() };
        let mut memory = vec![0.0; BundleYarn::reals(&bundle)];
        let yarn = BundleYarn::draw(&bundle, 1, 0, &mut memory).unwrap();
        assert!((yarn.stress(1.03 - 1e-12) / 5.481e9 - 1.0).abs() < 1e-9);
        assert_eq!(yarn.stress(1.03 + 1e-12), 0.0);
        assert!((yarn.work_to_rupture() / 83.4e6 - 1.0).abs() < 1e-3);
    }

    #[test]
    fn misaligned_yarns_absorb_more() {
        // 92.9 +- 0.6 MJ/m^3 over the population.
        let bundle = Bundle::zylon();
        let mut memory = vec![0.0; BundleYarn::reals(&bundle)];
        let n = 400;
        let mut mean = 0.0;
        for number in 0..n {
            let yarn = BundleYarn::draw(&bundle, 5, number, &mut memory).unwrap();
            mean += yarn.work_to_rupture() / n as f64;
        }
        assert!((mean - 92.9e6).abs() < 0.2e6, "{mean}");
    }
}
