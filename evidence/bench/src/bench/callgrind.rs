//! Instructions per node-step, counted by valgrind's callgrind: figures that no load disturbs.
//!
//! Method: this program steps one case under callgrind, for few steps and for more; the difference holds the
//! steps alone.

use super::Bench;
use super::programs::output;
use super::sheets;
use crate::Result;
use crate::memory::Buffers;
use fabric_kernel::InstructionSet;
use std::process::Command;

const SIZE: u32 = 105;
/// Steps before the counted ones: enough for the sphere to be in contact.
const BEFORE: u64 = 100;
const STEPS: [u64; 2] = [1, 11];

/// Counts; a set or a machine without callgrind is said so.
pub fn measure(bench: &mut Bench) -> Result<()> {
    let report = &mut bench.report;
    // valgrind does not know AVX-512.
    let known = |set: &InstructionSet| set.available() && *set != InstructionSet::Avx512;
    for (case, _) in sheets::COUNTED {
        for set in InstructionSet::ALL.into_iter().filter(known) {
            match count(case, set) {
                Ok(value) => {
                    let name = format!("{case} {SIZE}, {}", set.name());
                    report.figure("instructions", name, value, "instructions per node-step");
                }
                Err(error) => {
                    report.missing.push(format!("instruction counts: {error}"));
                    return Ok(());
                }
            }
        }
    }
    Ok(())
}

fn count(case: &str, set: InstructionSet) -> Result<f64> {
    let mut counts = [0.0; 2];
    for (count, steps) in counts.iter_mut().zip(STEPS) {
        let mut command = Command::new("valgrind");
        command.args(["--tool=callgrind", "--callgrind-out-file=/dev/null"]).arg(std::env::current_exe()?);
        command.args(["--only", case, "--instructions", set.name(), "--count-steps", &steps.to_string()]);
        let (_, text) = output(&mut command)?;
        *count = collected(&text).ok_or("callgrind printed no count")?;
    }
    let plies = if case == "plies" { f64::from(sheets::plies(SIZE).scene.stack.plies) } else { 1.0 };
    let nodes = plies * f64::from(SIZE) * f64::from(SIZE);
    Ok((counts[1] - counts[0]) / ((STEPS[1] - STEPS[0]) as f64 * nodes))
}

/// Number after "Collected :".
fn collected(text: &str) -> Option<f64> {
    let (_, rest) = text.split_once("Collected :")?;
    rest.split_whitespace().next()?.parse().ok()
}

/// What runs under callgrind: one case for so many steps.
pub fn step(case: &str, set: &str, steps: u64) -> Result<()> {
    let set = InstructionSet::ALL.into_iter().find(|known| known.name() == set).ok_or("unknown instruction set")?;
    let (_, case) = sheets::COUNTED.into_iter().find(|(name, _)| *name == case).ok_or("unknown case")?;
    let case = sheets::Case { before: BEFORE, ..case(SIZE)? };
    let mut buffers = Buffers::of(&case.scene)?;
    let (mut sim, _) = sheets::prepare(&case, &mut buffers)?;
    sheets::advance(&mut sim, sheets::Way { instructions: set, threads: 1, single_steps: false }, steps)
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_count_is_found() {
        assert_eq!(super::collected("==1== Events    : Ir\n==1== Collected : 4711\n==1=="), Some(4711.0));
        assert_eq!(super::collected("no such thing"), None);
    }
}
