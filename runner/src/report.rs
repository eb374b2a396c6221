//! Printed tables, and numbers in the way they print best.

use std::path::Path;

/// A table with a heading: the first column to the left, the others to the right.
pub fn table(heading: &[&str], rows: &[Vec<String>]) -> String {
    let heading: Vec<String> = heading.iter().map(|text| text.to_string()).collect();
    let rows: Vec<Vec<String>> =
        rows.iter().map(|row| row.iter().map(|cell| with_plain_zeros(cell)).collect()).collect();
    let all = || std::iter::once(&heading).chain(&rows);
    let width = |column: usize| all().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..heading.len()).map(width).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).enumerate();
        let cells = cells.map(|(k, (cell, &w))| if k == 0 { format!("{cell:<w$}") } else { format!("{cell:>w$}") });
        cells.collect::<Vec<_>>().join("  ")
    };
    let mut lines: Vec<String> = all().map(line).collect();
    lines.insert(1, "-".repeat(lines[0].chars().count()));
    lines.join("\n")
}

/// A cell whose zeros have no sign.
fn with_plain_zeros(cell: &str) -> String {
    let is_zero = |word: &&str| word.bytes().all(|byte| b"0.".contains(&byte)) && word.contains('0');
    let words = cell.split(' ').map(|word| word.strip_prefix('-').filter(is_zero).unwrap_or(word));
    words.collect::<Vec<_>>().join(" ")
}

/// Where the numbers of a study are, and what makes a report of them.
pub fn written(out: &Path, study: &str) -> String {
    let command = if study == "run" { "fabric-report".into() } else { format!("python -m evidence {study}") };
    format!("written: {}; pictures, after pip install ./python: {command} {0}", out.display())
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

/// A number without needless zeros.
pub fn shortest(value: f64) -> String {
    let text = format!("{value:.6}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zero_has_no_sign() {
        assert_eq!(with_plain_zeros("-0.0000 J  -0.0010 - -0"), "0.0000 J  -0.0010 - 0");
    }

    #[test]
    fn statistics_of_few_values() {
        assert_eq!((median(&[3.0, 1.0, 2.0]), median(&[4.0, 1.0, 2.0, 3.0])), (2.0, 2.5));
        assert_eq!(least(&[2.0, 1.0]), 1.0);
        assert!(median(&[]).is_nan() && least(&[]).is_nan());
    }
}
