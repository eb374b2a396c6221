//! Means with 95 % intervals, ratios of means, and the rule that turns an interval into a verdict.
//!
//! Method: Student's t for a mean; Welch's interval of the difference of two logarithms for a ratio of means, with the
//! standard errors carried to first order.
//! A share of the runs has Wilson's interval, which has a width also where all runs are alike.
//! The ballistic limit is the mean of the distribution of single limits that the arrested parts describe (Spearman and Kärber).
//! Limits: ensembles of 3 to 10 runs are taken as normal; intervals of several points are not corrected for their number.
//! Reference: B. L. Welch, Biometrika 34 (1947) 28; E. B. Wilson, J. Amer. Statist. Assoc. 22 (1927) 209; G. Kärber, Arch. exp. Path. Pharmak. 162 (1931) 480.

use crate::report;

/// A value with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The value itself.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Estimate {
    /// A value known without sampling error.
    pub fn exact(value: f64) -> Estimate {
        Estimate { value, low: value, high: value }
    }

    /// A value with a standard error and the degrees of freedom of that error.
    pub fn of_error(value: f64, error: f64, freedom: f64) -> Estimate {
        let half = student(freedom) * error;
        Estimate { value, low: value - half, high: value + half }
    }

    /// The mean of a sample. Fewer than two values: an interval without ends.
    pub fn mean(values: &[f64]) -> Estimate {
        let n = values.len() as f64;
        Estimate::of_error(report::mean(values), standard_error(values), n - 1.0)
    }

    /// The standard deviation of a normal sample, by the normal approximation for large ones: sd/sqrt(2 (n - 1)).
    pub fn large_sample_deviation(value: f64, count: u64) -> Estimate {
        let freedom = count as f64 - 1.0;
        Estimate::of_error(value, value / (2.0 * freedom).sqrt(), freedom)
    }

    /// Ratio of the means of two independent positive samples.
    pub fn ratio(above: &[f64], below: &[f64]) -> Estimate {
        let part = |values: &[f64]| {
            let error = standard_error(values);
            // A sample of zeros has no spread either.
            let relative = if error == 0.0 { 0.0 } else { error / report::mean(values) };
            (relative * relative, values.len() as f64 - 1.0)
        };
        let ((a, a_freedom), (b, b_freedom)) = (part(above), part(below));
        let value = report::mean(above) / report::mean(below);
        let sum = a + b;
        if sum == 0.0 {
            return Estimate::exact(value);
        }
        // Welch and Satterthwaite.
        let share = |part: f64, freedom: f64| if part > 0.0 { part * part / freedom } else { 0.0 };
        let freedom = sum * sum / (share(a, a_freedom) + share(b, b_freedom));
        let factor = (student(freedom) * sum.sqrt()).exp();
        Estimate { value, low: value / factor, high: value * factor }
    }

    /// The share of a sample for which something holds. An empty sample: not defined.
    pub fn share(hits: usize, count: usize) -> Estimate {
        let (n, z) = (count as f64, student(f64::INFINITY));
        let value = hits as f64 / n;
        let middle = (value + 0.5 * z * z / n) / (1.0 + z * z / n);
        let half = z / (1.0 + z * z / n) * (value * (1.0 - value) / n + 0.25 * z * z / (n * n)).sqrt();
        // At the ends the formula gives 0 and 1 but for rounding.
        let low = if hits == 0 { 0.0 } else { middle - half };
        let high = if hits == count { 1.0 } else { middle + half };
        Estimate { value, low, high }
    }

    /// Quotient of two positive values whose intervals are independent, to first order in the logarithms.
    pub fn quotient(above: &Estimate, below: &Estimate) -> Estimate {
        let half = |part: &Estimate| 0.5 * (part.high - part.low) / part.value;
        let factor = half(above).hypot(half(below)).exp();
        let value = above.value / below.value;
        Estimate { value, low: value / factor, high: value * factor }
    }

    /// As text: value [low, high] with the given number of digits after the point.
    pub fn text(&self, digits: usize) -> String {
        let Estimate { value, low, high } = self;
        if !value.is_finite() {
            return "not defined".to_string();
        }
        if !low.is_finite() || !high.is_finite() {
            return format!("{value:.digits$} (single run)");
        }
        format!("{value:.digits$} [{low:.digits$}, {high:.digits$}]")
    }
}

/// Standard error of the mean; infinite for fewer than two values.
fn standard_error(values: &[f64]) -> f64 {
    if values.len() < 2 {
        return f64::INFINITY;
    }
    let deviation = report::deviation(values);
    // Values that differ by rounding alone have no spread.
    let rounding = 1e-14 * report::mean(values).abs();
    if deviation <= rounding { 0.0 } else { deviation / (values.len() as f64).sqrt() }
}

/// 97.5 % quantile of Student's t for 1 to 30 degrees of freedom.
const STUDENT: [f64; 30] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131, 2.120,
    2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042,
];

/// 97.5 % quantile of Student's t, linear in 1/freedom between tabulated values; below 1 degree that of 1.
pub fn student(freedom: f64) -> f64 {
    let at = |n: usize| STUDENT[n.clamp(1, 30) - 1];
    if freedom.is_nan() || freedom <= 1.0 {
        return at(1);
    }
    if freedom >= 30.0 {
        return 1.96 + (at(30) - 1.96) * 30.0 / freedom;
    }
    let n = freedom.floor();
    let part = (1.0 / n - 1.0 / freedom) / (1.0 / n - 1.0 / (n + 1.0));
    at(n as usize) + part * (at(n as usize + 1) - at(n as usize))
}

/// Runs at one impact energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrests {
    /// Impact energy, J.
    pub energy: f64,
    /// Runs that were arrested.
    pub arrested: usize,
    /// All runs.
    pub runs: usize,
}

/// The ballistic limit, J, from counts at increasing energies: None unless all runs are arrested at the first of them and none
/// at the last. Parts that rise with energy are pooled. The error has the counts' and that of not knowing where between
/// two energies a limit lies (the spacing over sqrt(12)).
pub fn arrest_limit(counts: &[Arrests]) -> Option<Estimate> {
    let (first, last) = (counts.first()?, counts.last()?);
    if first.arrested != first.runs || last.arrested != 0 || first.runs == 0 {
        return None;
    }
    // Pools of neighbours: arrested, runs, and how many energies.
    let mut pools: Vec<(usize, usize, usize)> = Vec::new();
    for count in counts {
        let mut pool = (count.arrested, count.runs, 1);
        while let Some(&before) = pools.last()
            && before.0 * pool.1 < pool.0 * before.1
        {
            pool = (before.0 + pool.0, before.1 + pool.1, before.2 + pool.2);
            pools.pop();
        }
        pools.push(pool);
    }
    let parts: Vec<f64> = pools.iter().flat_map(|pool| vec![pool.0 as f64 / pool.1 as f64; pool.2]).collect();
    let (mut limit, mut variance) = (0.0, 0.0);
    for k in 0..counts.len() - 1 {
        let (from, to) = (counts[k].energy, counts[k + 1].energy);
        let share = parts[k] - parts[k + 1];
        limit += share * 0.5 * (from + to);
        variance += (share * (to - from)).powi(2) / 12.0;
        if k > 0 {
            let weight = 0.5 * (to - counts[k - 1].energy);
            variance += weight * weight * parts[k] * (1.0 - parts[k]) / (counts[k].runs as f64 - 1.0).max(1.0);
        }
    }
    Some(Estimate::of_error(limit, variance.sqrt(), f64::INFINITY))
}

/// What an interval says about a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The whole interval lies in the range that the claim allows.
    Agrees,
    /// No part of it does.
    DoesNot,
    /// Some part does.
    CannotBeTold,
}

impl Verdict {
    /// The rule: compares an interval with the range [low, high] that a claim allows.
    pub fn of(estimate: &Estimate, range: [f64; 2]) -> Verdict {
        if estimate.value.is_nan() {
            Verdict::CannotBeTold
        } else if range[0] <= estimate.low && estimate.high <= range[1] {
            Verdict::Agrees
        } else if estimate.high < range[0] || range[1] < estimate.low {
            Verdict::DoesNot
        } else {
            Verdict::CannotBeTold
        }
    }

    /// A claim about every one of several points: it must hold at all; one counterexample refutes it.
    pub fn all(verdicts: &[Verdict]) -> Verdict {
        if verdicts.contains(&Verdict::DoesNot) {
            Verdict::DoesNot
        } else if verdicts.is_empty() || verdicts.contains(&Verdict::CannotBeTold) {
            Verdict::CannotBeTold
        } else {
            Verdict::Agrees
        }
    }

    /// A claim that some point exists at which it holds.
    pub fn any(verdicts: &[Verdict]) -> Verdict {
        if verdicts.contains(&Verdict::Agrees) {
            Verdict::Agrees
        } else if verdicts.is_empty() || verdicts.contains(&Verdict::CannotBeTold) {
            Verdict::CannotBeTold
        } else {
            Verdict::DoesNot
        }
    }

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Agrees => "agrees",
            Verdict::DoesNot => "does not",
            Verdict::CannotBeTold => "cannot be told",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interval_of_a_known_sample() {
        // 1 .. 10: mean 5.5, sd 3.02765, half width 2.262 sd/sqrt(10) = 2.1657.
        let values: Vec<f64> = (1..=10).map(f64::from).collect();
        let mean = Estimate::mean(&values);
        assert_eq!(mean.value, 5.5);
        assert!((mean.high - 7.66569).abs() < 1e-4 && (mean.low - 3.33431).abs() < 1e-4, "{mean:?}");
        assert_eq!(Estimate::mean(&[3.0]).high, f64::INFINITY);
        assert_eq!(Estimate::mean(&[10.0, 10.0, 10.0]), Estimate::exact(10.0));
    }

    #[test]
    fn student_quantiles() {
        for (freedom, value) in [(1.0, 12.706), (9.0, 2.262), (30.0, 2.042), (60.0, 2.000), (1e9, 1.960)] {
            assert!((student(freedom) - value).abs() < 2e-3, "{freedom}");
        }
        assert!(student(9.5) < student(9.0) && student(9.5) > student(10.0));
    }

    #[test]
    fn ratio_of_known_samples() {
        // Equal sizes and equal relative errors s: 2 (n - 1) degrees of freedom, half width of the logarithm t s sqrt(2).
        let (above, below) = ([18.0, 20.0, 22.0], [9.0, 10.0, 11.0]);
        let ratio = Estimate::ratio(&above, &below);
        assert_eq!(ratio.value, 2.0);
        let half = 2.776 * 0.1 / 3f64.sqrt() * 2f64.sqrt();
        assert!(((ratio.high / 2.0).ln() - half).abs() < 1e-9, "{ratio:?}");
        assert!((ratio.low * ratio.high - 4.0).abs() < 1e-9);
        assert_eq!(Estimate::ratio(&[2.0, 2.0], &[1.0, 1.0]), Estimate::exact(2.0));
        assert_eq!(Estimate::ratio(&[0.0, 0.0], &[1.0, 1.0]), Estimate::exact(0.0));
        assert!(Estimate::ratio(&[0.0, 0.0], &[0.0, 0.0]).value.is_nan());
    }

    #[test]
    fn share_of_known_counts() {
        // Wilson's own form: for none and all of n the interval ends at z^2/(n + z^2) from the edge.
        let part = 1.96 * 1.96 / (10.0 + 1.96 * 1.96);
        let [none, half, all] = [0, 5, 10].map(|hits| Estimate::share(hits, 10));
        assert!((none.value, none.low) == (0.0, 0.0) && (none.high - part).abs() < 1e-12, "{none:?}");
        assert!((all.value, all.high) == (1.0, 1.0) && (all.low - 1.0 + part).abs() < 1e-12, "{all:?}");
        // 5 of 10: 0.237 to 0.763.
        assert!(half.value == 0.5 && (half.low - 0.2366).abs() < 1e-4 && (half.high - 0.7634).abs() < 1e-4, "{half:?}");
        assert_eq!(Verdict::of(&all, [0.5, 1.0]), Verdict::Agrees);
        assert_eq!(Verdict::of(&none, [0.5, 1.0]), Verdict::DoesNot);
        assert_eq!(Verdict::of(&half, [0.5, 1.0]), Verdict::CannotBeTold);
        assert_eq!(Verdict::of(&Estimate::share(0, 0), [0.5, 1.0]), Verdict::CannotBeTold);
    }

    #[test]
    fn ballistic_limit_of_known_counts() {
        let counts = |arrested: &[usize]| -> Vec<Arrests> {
            let at = |(k, &arrested): (usize, &usize)| Arrests { energy: 2.0 * k as f64, arrested, runs: 10 };
            arrested.iter().enumerate().map(at).collect()
        };
        // All arrested at 2 J, none at 4 J: 3 J, and no better than the spacing.
        let limit = arrest_limit(&counts(&[10, 10, 0, 0])).unwrap();
        assert_eq!(limit.value, 3.0);
        assert!((limit.high - 3.0 - 1.96 * 2.0 / 12f64.sqrt()).abs() < 1e-9);
        // Half at 2 J: 2 J.
        assert_eq!(arrest_limit(&counts(&[10, 5, 0])).unwrap().value, 2.0);
        // 3 and 5 of 10 are pooled to 4 and 4.
        let [rising, pooled] = [[10, 3, 5, 0], [10, 4, 4, 0]].map(|arrested| arrest_limit(&counts(&arrested)).unwrap());
        assert_eq!(rising, pooled);
        assert_eq!(arrest_limit(&counts(&[9, 5, 0])), None);
        assert_eq!(arrest_limit(&counts(&[10, 5, 1])), None);
        assert_eq!(arrest_limit(&[]), None);
    }

    #[test]
    fn verdicts_follow_the_interval() {
        let estimate = |low: f64, high: f64| Estimate { value: 0.5 * (low + high), low, high };
        assert_eq!(Verdict::of(&estimate(1.6, 2.4), [1.5, 2.5]), Verdict::Agrees);
        assert_eq!(Verdict::of(&estimate(0.9, 1.4), [1.5, 2.5]), Verdict::DoesNot);
        assert_eq!(Verdict::of(&estimate(1.4, 1.6), [1.5, 2.5]), Verdict::CannotBeTold);
        assert_eq!(Verdict::of(&Estimate::mean(&[2.0]), [1.5, 2.5]), Verdict::CannotBeTold);
        use Verdict::{Agrees, CannotBeTold, DoesNot};
        assert_eq!(Verdict::all(&[Agrees, CannotBeTold]), CannotBeTold);
        assert_eq!(Verdict::all(&[Agrees, DoesNot, CannotBeTold]), DoesNot);
        assert_eq!(Verdict::any(&[Agrees, DoesNot]), Agrees);
        assert_eq!(Verdict::any(&[DoesNot, CannotBeTold]), CannotBeTold);
        assert_eq!((Verdict::all(&[]), Verdict::any(&[])), (CannotBeTold, CannotBeTold));
    }
}
