//! What is measured: rows of time per node-step, and single figures.

use serde::Serialize;

/// Ends the name of a case that is stepped one step at a time although it could be stepped in blocks.
pub const SINGLE_STEPS: &str = ", single steps";

/// Time per node-step of one case, done one way.
#[derive(Clone, Serialize)]
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
    /// Half the range of the middle half of the rounds, in parts of the median.
    pub noise: Option<f64>,
    /// Digest of the state at the end; None for peers.
    pub digest: Option<String>,
    /// Largest deflection at the start of the rounds, m; for cases that peers run too.
    pub deflection: Option<f64>,
    /// Nodes in contact and failed segments at the end; None for peers.
    pub contacts: Option<u64>,
    pub failed_segments: Option<u64>,
    /// Peers: how it differs from the kernel.
    pub differs: Option<&'static str>,
    /// Peers: median over the rounds of the peer's time over the kernel's in the same round.
    pub times_slower: Option<f64>,
}

impl Row {
    /// A row without numbers.
    pub fn empty(case: &str, size: u32, instruction_set: &str, threads: u32) -> Row {
        Row {
            case: case.to_string(),
            size,
            instruction_set: instruction_set.to_string(),
            threads,
            ns_per_node_step: None,
            median: None,
            noise: None,
            digest: None,
            deflection: None,
            contacts: None,
            failed_segments: None,
            differs: None,
            times_slower: None,
        }
    }
}

/// A figure that is not a time per node-step.
#[derive(Clone, Serialize)]
pub struct Figure {
    /// The group it belongs to: a heading of the page.
    pub group: &'static str,
    /// What it is.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its unit.
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
    /// Adds a figure.
    pub fn figure(&mut self, group: &'static str, name: impl Into<String>, value: f64, unit: &'static str) {
        self.figures.push(Figure { group, name: name.into(), value, unit });
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
        let row =
            |set: &str, digest: Option<&str>| Row { digest: digest.map(str::to_string), ..Row::empty("a", 9, set, 1) };
        let rows = vec![row("x", Some("1")), row("y", None), row("z", Some("1"))];
        let mut report = Report {
            machine: String::new(),
            widest: "",
            clock: "",
            load_at_start: None,
            load_at_end: None,
            seconds: 0.0,
            rounds: 1,
            rows,
            figures: Vec::new(),
            missing: Vec::new(),
        };
        assert!(report.different_bits().is_empty());
        report.rows.push(row("w", Some("2")));
        assert_eq!(report.different_bits(), ["a 9 w 1"]);
    }
}
