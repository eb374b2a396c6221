//! Instructions per node-step, counted by valgrind's callgrind: figures that no load disturbs.
//!
//! Method: this program steps one case under callgrind, for few steps and for more; the difference holds the steps alone.

use super::programs::output;
use super::rows::Report;
use super::sheets;
use crate::Result;
use crate::memory::Buffers;
use crate::progress::Progress;
use fabric::InstructionSet;
use std::process::Command;

const CASES: [&str; 8] = ["sweep", "fabric", "graded", "viscous", "rate", "run", "strength", "plies"];
const SIZE: u32 = 105;
/// Steps before the counted ones: enough for the sphere to be in contact.
const BEFORE: u64 = 100;
const STEPS: [u64; 2] = [1, 11];

/// Counts; a set or a machine without callgrind is said so.
pub fn measure(report: &mut Report, progress: &Progress) -> Result<()> {
    for case in CASES {
        for set in InstructionSet::ALL.into_iter().filter(|set| set.available()) {
            // valgrind does not know AVX-512.
            if set != InstructionSet::Avx512 {
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
            progress.add(1, || format!("callgrind {case}"));
        }
    }
    Ok(())
}

fn count(case: &str, set: InstructionSet) -> Result<f64> {
    let mut counts = [0.0; 2];
    for (count, steps) in counts.iter_mut().zip(STEPS) {
        let mut command = Command::new("valgrind");
        command.args(["--tool=callgrind", "--callgrind-out-file=/dev/null"]).arg(std::env::current_exe()?);
        command.args(["bench", "--only", case, "--instructions", set.name(), "--count-steps", &steps.to_string()]);
        let (_, text) = output(&mut command)?;
        *count = collected(&text).ok_or("callgrind printed no count")?;
    }
    let plies = if case == "plies" { f64::from(sheets::plies(SIZE).scene.stack.plies) } else { 1.0 };
    let nodes = plies * f64::from(SIZE) * f64::from(SIZE);
    Ok((counts[1] - counts[0]) / ((STEPS[1] - STEPS[0]) as f64 * nodes))
}

/// The number behind "Collected :".
fn collected(text: &str) -> Option<f64> {
    let (_, rest) = text.split_once("Collected :")?;
    rest.split_whitespace().next()?.parse().ok()
}

/// What runs under callgrind: one case for so many steps.
pub fn step(case: &str, set: &str, steps: u64) -> Result<()> {
    let set = InstructionSet::ALL.into_iter().find(|known| known.name() == set).ok_or("unknown instruction set")?;
    let mut case = match case {
        "run" => sheets::whole_run(SIZE),
        "fabric" => sheets::fabric(SIZE),
        "graded" => sheets::graded(SIZE),
        "strength" => sheets::strength(SIZE),
        "viscous" => sheets::viscous(SIZE),
        "rate" => sheets::rate(SIZE),
        "plies" => sheets::plies(SIZE),
        _ => sheets::sweep(SIZE),
    };
    case.before = BEFORE;
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
