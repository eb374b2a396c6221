//! `cargo xtask figures`: measures the figures of docs/reliability.md that are measured in minutes, and writes the page and
//! the table in README.md from all records.
//!
//! Method: whatever measures prints lines `figure N: text`, and `figure N: NOT REACHED: text` for a miss; a command that fails
//! is a miss too. They are collected here, row by row, into docs/reliability/figures.toml. Commands whose runs are long or rare
//! (`cargo xtask coverage`, fuzz, mutants, digests) write records of their own beside it. The page is made from the records and
//! docs/reliability/page.md alone, so that the check of it measures nothing.

use crate::gates::sources;
use crate::records::{self, Record};
use crate::tools::{self, Outcome, target, top};
use std::process::{Command, Stdio};

/// Options of the command.
#[derive(clap::Args)]
pub struct Options {
    /// Measure only this row (repeatable); the others stay as they are.
    #[arg(long, value_name = "NUMBER")]
    only: Vec<String>,
    /// Measure nothing: write the page and README.md from the records.
    #[arg(long)]
    page: bool,
}

/// What measures a row.
#[derive(Clone, Copy, PartialEq)]
enum By {
    /// A command of cargo; it can print several rows.
    Cargo(&'static [&'static str]),
    /// A command that writes its own record.
    Record(&'static str),
    /// A group of the benchmark.
    Bench(&'static str),
    /// Counted here.
    Here,
}

/// A row of the table.
struct Row {
    number: &'static str,
    figure: &'static str,
    floor: &'static str,
    by: By,
}

const fn row(number: &'static str, figure: &'static str, floor: &'static str, by: By) -> Row {
    Row { number, figure, floor, by }
}

const GATES: By = By::Cargo(&["xtask", "test", "--only", "gates"]);
const FEATURES: By = By::Cargo(&["xtask", "test", "--only", "every set"]);
const TESTS: By =
    By::Cargo(&["test", "-p", "fabric-tests", "-p", "fabric-capi", "-p", "fabric-fmu", "--tests", "--", "--nocapture"]);
const SLACK: By = By::Cargo(&["test", "-p", "fabric-tests", "--test", "physics", "--", "--nocapture", "--ignored"]);
const LAW: By = By::Cargo(&["test", "-p", "fabric-tests", "--test", "constitutive", "--", "--nocapture"]);
const HOSTS: By = By::Cargo(&["xtask", "test", "--only", "C and C++ hosts", "--only", "binary interface"]);
const FMUS: By = By::Cargo(&["xtask", "test", "--only", "FMUs"]);

/// The table, in its order.
const ROWS: &[Row] = &[
    row("1", "panics reachable from an exported function", "0", GATES),
    row("2", "symbols that the linked libraries want of their host", "0 beyond the listed ones", GATES),
    row("3", "heap allocations in check, init, step, read-outs, save, load", "0", TESTS),
    row("4", "unsafe blocks", "kernel: lanes.rs and bands.rs only; C interface + FMU at most 40", GATES),
    row("5", "targets with identical digests x scenes", "8 x 6", By::Record("digests")),
    row("6", "deliberate changes that change the digest", "all, at least 6", By::Record("digests")),
    row("7", "invariances, bit-identical", "7 of 7 on every scene", TESTS),
    row("8", "bad inputs, each with its exact code and field", "500, all", TESTS),
    row("9", "error codes produced by a test", "100 %", TESTS),
    row("10", "short and misaligned buffers refused, guard bytes untouched", "100 %", TESTS),
    row("11", "corrupted images refused, target unchanged", "100 %", TESTS),
    row("12", "fuzz executions without a crash", "1e7 in all", By::Record("fuzz")),
    row("13", "mutants caught, without and with digests", "90 %, 95 %", By::Record("mutants")),
    row("14", "line coverage", "98 %", By::Record("coverage")),
    row("15", "feature sets built and tested", "4 of 4, no warnings", FEATURES),
    row("16", "energy balance", "smooth: 2e-5 at 0.5 dt_crit, order 2; 40 J: 1 % of KE0; slack tails stated", TESTS),
    row("16", "energy balance of a slack sheet", "stated", SLACK),
    row("16b", "work-energy identity per step, relative", "1e-12", TESTS),
    row("17", "momentum balance, relative", "1e-12", TESTS),
    row("18", "order of convergence", "within 0.1 of the stated one", TESTS),
    row("19", "analytic checks", "each within its tolerance", TESTS),
    row("20", "constitutive law against a 256-bit reference", "1e5 points; largest error stated", LAW),
    row("21", "non-finite state contained", "never a silent OK", TESTS),
    row("22", "binary interface", "0 unreviewed changes, 4 targets", HOSTS),
    row("23", "C and C++ hosts", "gcc and a second compiler, ASan and valgrind: 0 errors", HOSTS),
    row("24", "FMI: each call in each state", "100 % of cells", FMUS),
    row("25", "FMI importers and validators", "2 importers, 0 errors", FMUS),
    row("26", "oldest glibc of the FMU", "2.17", FMUS),
    row("27", "stack of the worst chain of calls", "4 KiB, no recursion", GATES),
    row("28", "instructions per node-step (2 segments)", "stated", By::Bench("instructions")),
    row("28", "memory per node", "stated", By::Bench("memory")),
    row("29", "tests and their size", "stated", By::Here),
];

/// Rows of the table in README.md.
const IN_README: [&str; 12] = ["1", "3", "4", "5", "8", "12", "13", "14", "16", "20", "21", "27"];

impl By {
    /// As one types it.
    fn shown(self, number: &str) -> String {
        match self {
            By::Cargo(arguments) => {
                let quoted = arguments
                    .iter()
                    .map(|word| if word.contains(' ') { format!("\"{word}\"") } else { word.to_string() });
                format!("cargo {}", quoted.collect::<Vec<_>>().join(" "))
            }
            By::Record(name) => format!("cargo xtask {name}"),
            By::Bench(group) => format!("cargo xtask bench --only {group}"),
            By::Here => format!("cargo xtask figures --only {number}"),
        }
    }
}

/// Measures, writes the records, then the page and README.md.
pub fn run(options: &Options) -> Outcome {
    if !options.page {
        for number in &options.only {
            if !ROWS.iter().any(|row| row.number == number) {
                return Err(format!("there is no row {number}"));
            }
        }
        measure(&options.only)?;
    }
    let records = records::read()?;
    for (path, text) in pages(&records)? {
        std::fs::write(top().join(path), text).map_err(|error| format!("{path}: {error}"))?;
    }
    let missed = ROWS.iter().filter(|row| !records_of(row, &records).iter().all(|record| record.reached)).count();
    println!("docs/reliability.md and README.md are written; {missed} rows hold something that is not reached");
    Ok(())
}

/// The page and README.md are what the records give, and every row is there.
pub fn check() -> Outcome {
    let records = records::read()?;
    for (path, text) in pages(&records)? {
        let committed = std::fs::read_to_string(top().join(path)).map_err(|error| format!("{path}: {error}"))?;
        if committed != text {
            return Err(format!("{path} is not what docs/reliability gives: run `cargo xtask figures --page`"));
        }
    }
    firmware_as_documented()?;
    println!("  {} rows, {} records", ROWS.len(), records.len());
    Ok(())
}

/// docs/embedding.md has the numbers that the firmware last printed: flash, RAM, instructions of a step, mean and most.
fn firmware_as_documented() -> Outcome {
    let read = |path: &str| std::fs::read_to_string(top().join(path)).map_err(|error| format!("{path}: {error}"));
    let (page, record) = (read("docs/embedding.md")?, read("docs/reliability/digests.toml")?);
    let said = record.lines().find(|line| line.starts_with("said = ")).unwrap_or_default();
    for number in said.split(|c: char| !c.is_ascii_digit()).filter(|digits| digits.len() > 3) {
        let (thousands, rest) = number.split_at(number.len() - 3);
        let shown = format!("{thousands},{rest}");
        if !page.contains(&shown) {
            return Err(format!(
                "docs/embedding.md does not have the firmware's {shown}: see docs/reliability/digests.toml"
            ));
        }
    }
    Ok(())
}

/// Runs the commands of the wanted rows, each once, and puts what they print into docs/reliability/figures.toml.
fn measure(only: &[String]) -> Outcome {
    let wanted: Vec<&Row> = ROWS.iter().filter(|row| only.is_empty() || only.iter().any(|n| n == row.number)).collect();
    let (date, commit, machine) = (records::today()?, records::commit()?, records::machine()?);
    let mut runs: Vec<(By, Result<String, String>)> = Vec::new();
    let mut measured = Vec::new();
    for row in &wanted {
        if let By::Record(name) = row.by {
            println!("row {}: written by `cargo xtask {name}`", row.number);
            continue;
        }
        if !runs.iter().any(|(by, _)| *by == row.by) {
            println!("== {}", row.by.shown(row.number));
            let printed = match row.by {
                By::Cargo(arguments) => printed_by(arguments),
                By::Bench(group) => bench(group),
                By::Here => tests_and_code().map(|text| format!("figure {}: {text}", row.number)),
                By::Record(_) => continue,
            };
            runs.push((row.by, printed));
        }
        let Some((_, printed)) = runs.iter().find(|(by, _)| *by == row.by) else { continue };
        let (text, failure) = match printed {
            Ok(text) => (text.as_str(), None),
            Err(message) => (message.as_str(), Some("the command failed")),
        };
        let mut values = figures_in(text, row.number);
        let reached = failure.is_none() && !values.is_empty() && !values.iter().any(|v| v.contains("NOT REACHED"));
        if values.is_empty() && failure.is_none() {
            values.push("not measured: the command prints nothing for this row".to_string());
        }
        values.extend(failure.map(str::to_string));
        if let [value] = &mut values[..] {
            // The column beside it says so.
            *value = value.trim_start_matches("NOT REACHED: ").to_string();
        }
        let value = values.join("; ");
        println!("row {}: {}: {value}", row.number, row.figure);
        measured.push(Record {
            number: row.number.to_string(),
            figure: row.figure.to_string(),
            value,
            floor: row.floor.to_string(),
            reached,
            command: row.by.shown(row.number),
            date: date.clone(),
            commit: commit.clone(),
            machine: machine.clone(),
        });
    }
    // In the order of the table, the newly measured ones in the place of the old.
    let old = records::of("figures")?;
    let is = |record: &&Record, row: &Row| record.number == row.number && record.figure == row.figure;
    let find = |records: &[Record], row: &Row| records.iter().find(|record| is(record, row)).cloned();
    let all: Vec<Record> = ROWS.iter().filter_map(|row| find(&measured, row).or_else(|| find(&old, row))).collect();
    records::write("figures", "cargo xtask figures", &all, "")
}

/// Runs a command of cargo; what it prints, as an error if it fails.
fn printed_by(arguments: &[&str]) -> Result<String, String> {
    let run = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
        .args(arguments)
        .current_dir(top())
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| format!("cannot start cargo: {error}"))?;
    let text = String::from_utf8_lossy(&run.stdout).into_owned();
    let file = target().join("figures.log");
    std::fs::write(&file, &text).map_err(|error| format!("{}: {error}", file.display()))?;
    if run.status.success() { Ok(text) } else { Err(text) }
}

/// What a group of the benchmark measures, each figure as a line of row 28.
fn bench(group: &str) -> Result<String, String> {
    let file = target().join("figures.json");
    let path = file.to_string_lossy();
    tools::cargo(&["xtask", "bench", "--only", group, "--json", &path])?;
    let text = std::fs::read_to_string(&file).map_err(|error| format!("{path}: {error}"))?;
    let measured: Measured = serde_json::from_str(&text).map_err(|error| format!("{path}: {error}"))?;
    let lines = measured.figures.iter().map(|f| format!("figure 28: {}: {:.2} {}\n", f.name, f.value, f.unit));
    Ok(lines.chain(measured.missing.iter().map(|what| format!("figure 28: not measured: {what}\n"))).collect())
}

/// The part of the benchmark's JSON that is read.
#[derive(serde::Deserialize)]
struct Measured {
    figures: Vec<Figure>,
    missing: Vec<String>,
}

#[derive(serde::Deserialize)]
struct Figure {
    name: String,
    value: f64,
    unit: String,
}

/// What stands behind `figure N: ` in the lines that hold it, sorted because tests print in any order.
fn figures_in(text: &str, number: &str) -> Vec<String> {
    let label = format!("figure {number}: ");
    let behind = |line: &str| line.split_once(&label).map(|(_, value)| value.trim().to_string());
    let mut values: Vec<_> = text.lines().filter_map(behind).collect();
    values.sort();
    values.dedup();
    values
}

/// All records of a row. One without a figure of its own stands for the row's; one that is missing is said to be.
fn records_of(row: &Row, records: &[Record]) -> Vec<Record> {
    let twice = ROWS.iter().filter(|other| other.number == row.number).count() > 1;
    let mut found: Vec<Record> = records
        .iter()
        .filter(|record| record.number == row.number && (!twice || record.figure == row.figure))
        .cloned()
        .collect();
    if found.is_empty() {
        found.push(Record {
            number: row.number.to_string(),
            figure: String::new(),
            value: "not measured".to_string(),
            floor: String::new(),
            reached: false,
            command: row.by.shown(row.number),
            date: String::new(),
            commit: String::new(),
            machine: String::new(),
        });
    }
    for record in &mut found {
        for (own, general) in [(&mut record.figure, row.figure), (&mut record.floor, row.floor)] {
            if own.is_empty() {
                *own = general.to_string();
            }
        }
    }
    found
}

/// The pages as the records give them: path and text.
fn pages(records: &[Record]) -> Result<[(&'static str, String); 2], String> {
    let read = |path: &str| std::fs::read_to_string(top().join(path)).map_err(|error| format!("{path}: {error}"));
    let page = read("docs/reliability/page.md")?.replace("{{table}}\n", &table(records));
    let readme = read("README.md")?;
    let (begin, end) = ("<!-- figures: written by cargo xtask figures -->\n", "<!-- figures end -->\n");
    let (before, rest) = readme.split_once(begin).ok_or("README.md has no place for the figures")?;
    let (_, after) = rest.split_once(end).ok_or("README.md has no end of the figures")?;
    Ok([("docs/reliability.md", page), ("README.md", format!("{before}{begin}{}{end}{after}", short_table(records)))])
}

/// A cell's text.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

fn verdict(record: &Record) -> &'static str {
    match (record.reached, record.value.starts_with("not measured")) {
        (true, _) if record.floor == "stated" => "stated",
        (true, _) => "yes",
        (false, true) => "**not measured**",
        (false, false) => "**NOT REACHED**",
    }
}

/// A cell of several figures: each on a line of its own.
fn lines(text: &str) -> String {
    cell(text).replace("; ", "<br>")
}

/// The whole table, and below it the machines.
fn table(records: &[Record]) -> String {
    let mut text = String::from(
        "| # | figure | value | asked for | reached | measured by | on |\n|---|---|---|---|---|---|---|\n",
    );
    let mut machines: Vec<&str> = Vec::new();
    let all: Vec<Record> = ROWS.iter().flat_map(|row| records_of(row, records)).collect();
    for record in &all {
        let machine = match machines.iter().position(|known| *known == record.machine) {
            _ if record.machine.is_empty() => String::new(),
            Some(k) => format!(" ({})", k + 1),
            None => {
                machines.push(&record.machine);
                format!(" ({})", machines.len())
            }
        };
        let commit = if record.commit.is_empty() { String::new() } else { format!(", {}", record.commit) };
        text += &format!(
            "| {} | {} | {} | {} | {} | `{}` | {}{commit}{machine} |\n",
            record.number,
            cell(&record.figure),
            lines(&record.value),
            lines(&record.floor),
            verdict(record),
            cell(&record.command),
            record.date
        );
    }
    let asked: Vec<_> = all.iter().filter(|record| record.floor != "stated").collect();
    let reached = asked.iter().filter(|record| record.reached).count();
    text += &format!("\nOf {} lines that ask for something {reached} are reached.\n", asked.len());
    for (k, machine) in machines.iter().enumerate() {
        text += &format!("{}({}) {machine}\n", if k == 0 { "\n" } else { "<br>" }, k + 1);
    }
    text
}

/// The rows of README.md, in short.
fn short_table(records: &[Record]) -> String {
    let mut text = String::from("| figure | value | asked for | reached |\n|---|---|---|---|\n");
    for row in ROWS.iter().filter(|row| IN_README.contains(&row.number)) {
        for record in records_of(row, records) {
            let [figure, value, floor] = [&record.figure, &record.value, &record.floor].map(|text| cell(text));
            text += &format!("| {figure} | {} | {floor} | {} |\n", headline(&value), verdict(&record));
        }
    }
    text
}

/// The first statement of a value, without what it says in brackets; the page has the rest.
fn headline(value: &str) -> &str {
    let first = value.split("; ").next().unwrap_or(value);
    first.split_once(" (").map_or(first, |(before, _)| before)
}

/// Row 29: lines that are neither empty nor only a comment, and numbers of tests.
fn tests_and_code() -> Result<String, String> {
    let (mut code, mut testing, mut tests) = (0, 0, 0);
    for ending in ["rs", "c", "h", "hpp", "cpp", "py"] {
        for (path, text) in sources(&["kernel", "capi", "fmu", "tests", "include"], ending)? {
            let line_counts = |line: &&str| {
                let line = line.trim_start();
                !line.is_empty() && !["//", "/*", "*", "#!", "# "].iter().any(|comment| line.starts_with(comment))
            };
            // A module of unit tests stands at the end of its file.
            let (own, unit) = text.split_once("#[cfg(test)]\nmod tests").unwrap_or((&text, ""));
            let [own, unit] = [own, unit].map(|text| text.lines().filter(line_counts).count());
            if path.starts_with("tests/") {
                testing += own + unit;
            } else {
                (code, testing) = (code + own, testing + unit);
            }
            tests +=
                text.lines().filter(|line| line.trim() == "#[test]" || line.trim().starts_with("def test_")).count();
        }
    }
    let ratio = testing as f64 / code as f64;
    Ok(format!(
        "{tests} tests in Rust and Python; {testing} lines of tests to {code} of kernel and interfaces ({ratio:.2} : 1); \
         studies, examples and tables of cases not counted"
    ))
}

#[cfg(test)]
mod tests {
    use super::{ROWS, figures_in};

    #[test]
    fn lines_are_found_behind_what_a_test_runner_prints() {
        let text = "test a ... figure 16: 1e-5\nok\nfigure 16b: 2e-13\n  figure 16: 0.8 %\n";
        assert_eq!(figures_in(text, "16"), ["0.8 %", "1e-5"]);
        assert_eq!(figures_in(text, "16b"), ["2e-13"]);
        assert!(figures_in(text, "6").is_empty());
    }

    #[test]
    fn no_row_is_forgotten() {
        for number in 1..=29 {
            assert!(ROWS.iter().any(|row| row.number == number.to_string()), "{number}");
        }
    }
}
