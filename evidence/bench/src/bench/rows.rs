//! What is measured: rows of time per node-step, and single figures.

use crate::machine;
use crate::report::{least, median};
use crate::say;
use fabric_kernel::InstructionSet;
use serde::Serialize;

/// Ends the name of a case that is stepped one step at a time although it could be stepped in blocks.
pub const SINGLE_STEPS: &str = ", single steps";

/// Time per node-step of one case, done one way.
#[derive(Clone, Default, Serialize)]
pub struct Row {
    /// What is stepped: "sweep", "run", ..., or "peers: NAME".
    pub case: String,
    /// Nodes along each side.
    pub size: u32,
    /// Instruction set of the kernel; "compiled" where a compiler chose.
    pub instruction_set: String,
    /// Threads.
    pub threads: u32,
    /// Least over the rounds, ns; None if this machine lacks the instruction set.
    pub ns_per_node_step: Option<f64>,
    /// Median over the rounds, ns.
    pub median: Option<f64>,
    /// Digest of the state at the end; None for peers.
    pub digest: Option<String>,
    /// Largest deflection at the start of the rounds, m; for cases that peers run too.
    pub deflection: Option<f64>,
    /// Peers: how it differs from the kernel.
    pub differs: Option<&'static str>,
    /// Peers: median over the rounds of the peer's time over the kernel's in the same round.
    pub times_slower: Option<f64>,
}

impl Row {
    /// With the times of the rounds, ns; none where it could not be stepped.
    pub fn of(case: &str, size: u32, instruction_set: &str, threads: u32, times: &[f64]) -> Row {
        let (case, instruction_set) = (case.to_string(), instruction_set.to_string());
        let [ns_per_node_step, median] = [least, median].map(|of| (!times.is_empty()).then(|| of(times)));
        Row { case, size, instruction_set, threads, ns_per_node_step, median, ..Row::default() }
    }

    /// With the digest of the state at the end.
    pub fn ending_in(self, digest: u64) -> Row {
        Row { digest: Some(format!("{digest:016x}")), ..self }
    }
}

/// A figure that is not a time per node-step.
#[derive(Clone, Serialize)]
pub struct Figure {
    /// The group it belongs to: a heading of the page.
    pub group: &'static str,
    /// What it is.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Unit.
    pub unit: &'static str,
}

/// Everything that was measured: the JSON file.
#[derive(Serialize)]
pub struct Report {
    /// Processor.
    pub machine: String,
    /// The widest instruction set of the machine.
    pub widest: &'static str,
    /// What clock timed the kernel.
    pub clock: &'static str,
    /// Mean number of running processes over the last minute, before and after.
    pub load_at_start: Option<f64>,
    pub load_at_end: Option<f64>,
    /// Wall time of the whole measurement, s.
    pub seconds: f64,
    /// Rounds of each row.
    pub rounds: usize,
    pub rows: Vec<Row>,
    pub figures: Vec<Figure>,
    /// What could not be measured, and why.
    pub missing: Vec<String>,
}

impl Report {
    /// Nothing measured so far.
    pub fn new(rounds: usize) -> Report {
        Report {
            machine: machine::processor(),
            widest: InstructionSet::widest().name(),
            clock: machine::CLOCK_NAME,
            load_at_start: machine::load(),
            load_at_end: None,
            seconds: 0.0,
            rounds,
            rows: Vec::new(),
            figures: Vec::new(),
            missing: Vec::new(),
        }
    }

    /// Adds a figure.
    pub fn figure(&mut self, group: &'static str, name: impl Into<String>, value: f64, unit: &'static str) {
        self.figures.push(Figure { group, name: name.into(), value, unit });
    }

    /// A line for each row and figure; tables are made by `python -m evidence bench`.
    pub fn print(&self) {
        for Row { case, size, instruction_set, threads, ns_per_node_step, median, .. } in &self.rows {
            let time = match (ns_per_node_step, median) {
                (Some(least), Some(median)) => format!("{least:.2} ns per node-step, median {median:.2}"),
                _ => "not on this machine".to_string(),
            };
            say::line(format_args!("{case}, {size} x {size}, {instruction_set}, {threads} threads: {time}"));
        }
        for Figure { name, value, unit, .. } in &self.figures {
            say::line(format_args!("{name}: {value:.4} {unit}"));
        }
        self.missing.iter().for_each(|missing| say::line(format_args!("not measured: {missing}")));
        self.different_bits().iter().for_each(|row| say::line(format_args!("DIFFERENT BITS: {row}")));
        say::line(format_args!("measured in {:.0} s on {}", self.seconds, self.machine));
    }

    /// Cases and sizes whose rows do not all have the same digest.
    pub fn different_bits(&self) -> Vec<String> {
        let mut found = Vec::new();
        let case = |row: &Row| row.case.trim_end_matches(SINGLE_STEPS).to_string();
        for row in &self.rows {
            let twin = self.rows.iter().find(|other| (case(other), other.size) == (case(row), row.size));
            if let (Some(digest), Some(twin)) = (&row.digest, twin)
                && twin.digest.as_ref().is_some_and(|other| other != digest)
            {
                found.push(format!("{} {} {} {}", row.case, row.size, row.instruction_set, row.threads));
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn different_bits_are_found() {
        let mut report = Report::new(1);
        report.rows = vec![Row::of("a", 9, "x", 1, &[2.0]).ending_in(1), Row::of("a", 9, "y", 1, &[])];
        report.rows.push(Row::of("a", 9, "z", 1, &[3.0]).ending_in(1));
        assert!(report.different_bits().is_empty());
        report.rows.push(Row::of("a", 9, "w", 1, &[4.0]).ending_in(2));
        assert_eq!(report.different_bits(), ["a 9 w 1"]);
    }
}
