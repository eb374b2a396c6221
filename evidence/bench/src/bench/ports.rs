//! The bound of the add ports: how many additions a second one core does if nothing else holds it up.

use super::Bench;
use crate::Result;
use crate::machine::Clock;
use fabric_kernel::InstructionSet;
use fabric_kernel::internals::lanes::{Job, Lane, dispatch};
use std::hint::black_box;

/// Additions and maxima that the law needs per node-step: two segments of 7 additions and a maximum each, 3
/// axes of 3 additions to sum the forces and 2 to kick and drift. (The hot pass does two more comparisons and
/// two range checks.)
pub const ADDITIONS: f64 = 31.0;

/// Independent sums: more than ports times latency on any core.
const SUMS: usize = 10;

/// `turns` additions to each of ten lane groups.
struct Adds {
    turns: u64,
    x: f64,
}

impl Job for Adds {
    type Output = f64;

    #[inline(always)]
    fn run<L: Lane>(self) -> f64 {
        let x = L::splat(self.x);
        let mut sums = [x; SUMS];
        for _ in 0..self.turns {
            let mut k = 0;
            while k < SUMS {
                sums[k] = sums[k].add(x);
                k += 1;
            }
        }
        let mut total = x;
        let mut k = 0;
        while k < SUMS {
            total = total.add(sums[k]);
            k += 1;
        }
        let mut group = L::ZEROS;
        total.store(&mut group);
        group.as_ref()[0]
    }
}

/// Additions per second, the most of several tries, 10^9/s.
fn rate(set: InstructionSet, width: u64) -> f64 {
    let turns = 4_000_000 / width;
    (0..7)
        .map(|_| {
            let clock = Clock::start();
            black_box(dispatch(set, Adds { turns: black_box(turns), x: black_box(1e-9) }));
            (turns * SUMS as u64 * width) as f64 / clock.seconds() * 1e-9
        })
        .fold(0.0, f64::max)
}

/// Measures every set that this machine has: rate, and the time that the additions of a node-step take.
pub fn measure(bench: &mut Bench) -> Result<()> {
    let report = &mut bench.report;
    for (set, width) in InstructionSet::ALL.into_iter().zip([2, 2, 4, 8]).filter(|(set, _)| set.available()) {
        let rate = rate(set, width);
        report.figure("ports", format!("additions, {}", set.name()), rate, "10^9/s");
        report.figure("ports", format!("add-port bound, {}", set.name()), ADDITIONS / rate, "ns per node-step");
    }
    Ok(())
}
