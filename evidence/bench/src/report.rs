//! Statistics of few values, and what is said at the end.

use std::path::Path;

/// Where the numbers are, and what makes a report of them.
pub fn written(out: &Path) -> String {
    format!("written: {}; pictures, after pip install ./python[all]: python -m evidence bench {0}", out.display())
}

/// The middle value; the mean of the two middle ones of an even number. NaN for none.
pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => sorted[n / 2],
        n => 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]),
    }
}

/// The least value. NaN for none.
pub fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NAN, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statistics_of_few_values() {
        assert_eq!((median(&[3.0, 1.0, 2.0]), median(&[4.0, 1.0, 2.0, 3.0])), (2.0, 2.5));
        assert_eq!(least(&[2.0, 1.0]), 1.0);
        assert!(median(&[]).is_nan() && least(&[]).is_nan());
    }
}
