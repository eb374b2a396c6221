//! The range of a row's displacements along x, kept as the sweep leaves it, so that contact reads of a row
//! only the chunks that may be near.

use crate::ground::lanes::{self, InstructionSet, Job, Lane};
use crate::ground::math;
use crate::ground::planes::{CHUNK, Chunk, HOT_PLANES};

/// In place of a row's range along x: contact does not ask for it, and the sweep need not find it.
pub(crate) const NOT_KEPT: u32 = u32::MAX;

/// A row's least displacement, not above 0, or greatest one, not below 0, as it is kept: the bits of a number
/// of half the length.
pub(crate) fn end_of_range(end: f64) -> u32 {
    (end as f32).to_bits()
}

/// The range of a row from its ends as they are kept: no narrower than it was, but for displacements below
/// 1e-38 spacings, which no place feels.
pub(crate) fn range_of([low, high]: [u32; 2]) -> [f64; 2] {
    [low, high].map(|end| f64::from(f32::from_bits(end)) * (1.0 + f64::from(f32::EPSILON)))
}

/// The smallest of 2^n numbers, or 0; the numbers are lost.
#[inline(always)]
pub(crate) fn least(numbers: &mut [f64]) -> f64 {
    math::min(folded(numbers, math::min), 0.0)
}

/// The greatest of 2^n numbers, or 0; the numbers are lost.
#[inline(always)]
pub(crate) fn greatest(numbers: &mut [f64]) -> f64 {
    math::max(folded(numbers, math::max), 0.0)
}

/// Result of folding 2^n numbers in two until there is one: a chain of n choices where one after another has
/// 2^n.
#[inline(always)]
fn folded(mut numbers: &mut [f64], choose: impl Fn(f64, f64) -> f64) -> f64 {
    while numbers.len() > 1 {
        let (half, other) = numbers.split_at_mut(numbers.len() / 2);
        for (number, other) in half.iter_mut().zip(other) {
            *number = choose(*number, *other);
        }
        numbers = half;
    }
    numbers.first().copied().unwrap_or(0.0)
}

/// Least and greatest displacement along x of a row, or 0.
#[inline(never)]
pub(crate) fn spread(row: &[Chunk<HOT_PLANES>], instructions: InstructionSet) -> [f64; 2] {
    lanes::dispatch(instructions, Spread(row))
}

/// [`spread`] as a job for the lanes.
struct Spread<'a>(&'a [Chunk<HOT_PLANES>]);

impl Job for Spread<'_> {
    type Output = [f64; 2];

    #[inline(always)]
    fn run<L: Lane>(self) -> [f64; 2] {
        let (mut low, mut high) = ([0.0; CHUNK], [0.0; CHUNK]);
        for [x, ..] in self.0 {
            let bounds = L::groups_mut(&mut low).iter_mut().zip(L::groups_mut(&mut high));
            for (x, (low, high)) in L::groups(x).iter().zip(bounds) {
                let x = L::load(x);
                x.min(L::load(low)).store(low);
                x.max(L::load(high)).store(high);
            }
        }
        [least(&mut low), greatest(&mut high)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_of_numbers_are_found_wherever_they_stand() {
        for n in [1, 2, 4, 8] {
            for (at, sign) in (0..n).flat_map(|at| [(at, 1.0), (at, -1.0)]) {
                let numbers: std::vec::Vec<f64> =
                    (0..n).map(|k| if k == at { 7.0 * sign } else { k as f64 - 3.5 }).collect();
                let ends = [least(&mut numbers.clone()), greatest(&mut numbers.clone())];
                let plainly = [
                    numbers.iter().fold(0.0, |a, &b| f64::min(a, b)),
                    numbers.iter().fold(0.0, |a, &b| f64::max(a, b)),
                ];
                assert_eq!(ends, plainly, "{numbers:?}");
            }
        }
    }
}
