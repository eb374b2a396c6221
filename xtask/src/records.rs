//! The records behind docs/reliability.md: one file in docs/reliability for every command that measures, committed.

use crate::tools::{output, top};
use std::path::PathBuf;

/// A row of the table as it was measured last.
#[derive(Clone, serde::Deserialize)]
pub struct Record {
    /// Number of the row.
    pub number: String,
    /// What is measured, where the record says it more closely than the table does.
    #[serde(default)]
    pub figure: String,
    /// What came out.
    pub value: String,
    /// What is asked for.
    #[serde(default)]
    pub floor: String,
    /// Whether it is.
    pub reached: bool,
    /// Measures it.
    pub command: String,
    /// Day, UTC, like 2026-11-21.
    pub date: String,
    /// Commit that was measured; " and changes" behind it if there were any.
    #[serde(default)]
    pub commit: String,
    /// Processor, system and compiler.
    #[serde(default)]
    pub machine: String,
}

/// What a file holds; tables of other names are for other readers.
#[derive(serde::Deserialize)]
struct File {
    #[serde(default)]
    row: Vec<Record>,
}

/// The folder of the records.
fn folder() -> PathBuf {
    top().join("docs/reliability")
}

/// All records, file by file in the order of their names. Rows keep the order they have in their file.
pub fn read() -> Result<Vec<Record>, String> {
    let mut paths: Vec<_> = std::fs::read_dir(folder())
        .map_err(|error| format!("{}: {error}", folder().display()))?
        .filter_map(|entry| entry.ok().map(|entry| entry.path()))
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .collect();
    paths.sort();
    let mut records = Vec::new();
    for path in paths {
        records.extend(file(&path)?);
    }
    Ok(records)
}

/// The records of one command; none if it has not run yet.
pub fn of(name: &str) -> Result<Vec<Record>, String> {
    let path = folder().join(format!("{name}.toml"));
    if path.exists() { file(&path) } else { Ok(Vec::new()) }
}

fn file(path: &std::path::Path) -> Result<Vec<Record>, String> {
    let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let file: File = toml::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(file.row)
}

/// What was just measured.
pub struct Figure<'a> {
    /// Number of the row in docs/reliability.md.
    pub number: &'a str,
    /// What is measured.
    pub figure: &'a str,
    /// What came out.
    pub value: &'a str,
    /// What is asked for.
    pub floor: &'a str,
    /// Whether it is.
    pub reached: bool,
    /// Measures it.
    pub command: &'a str,
}

impl Figure<'_> {
    /// The record: measured today, here, at this commit.
    pub fn now(&self) -> Result<Record, String> {
        Ok(Record {
            number: self.number.to_string(),
            figure: self.figure.to_string(),
            value: self.value.to_string(),
            floor: self.floor.to_string(),
            reached: self.reached,
            command: self.command.to_string(),
            date: today()?,
            commit: commit()?,
            machine: machine()?,
        })
    }
}

/// Writes docs/reliability/NAME.toml: the records of a command, and behind them tables for other readers.
pub fn write(name: &str, written_by: &str, records: &[Record], tables: &str) -> Result<(), String> {
    let mut text = format!("# Written by `{written_by}`: do not edit.\n");
    for record in records {
        text += "\n[[row]]\n";
        for (key, value) in [
            ("number", &record.number),
            ("figure", &record.figure),
            ("value", &record.value),
            ("floor", &record.floor),
            ("command", &record.command),
            ("date", &record.date),
            ("commit", &record.commit),
            ("machine", &record.machine),
        ] {
            text += &format!("{key} = \"{}\"\n", value.replace('\\', "\\\\").replace('"', "\\\""));
        }
        text += &format!("reached = {}\n", record.reached);
    }
    text += tables;
    std::fs::create_dir_all(folder()).map_err(|error| format!("{}: {error}", folder().display()))?;
    let path = folder().join(format!("{name}.toml"));
    std::fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))
}

/// Today, UTC.
pub fn today() -> Result<String, String> {
    Ok(output("date", &["--utc", "+%F"])?.trim().to_string())
}

/// The commit that is checked out, and whether there are changes to it besides the records themselves.
pub fn commit() -> Result<String, String> {
    let commit = output("git", &["rev-parse", "--short", "HEAD"])?.trim().to_string();
    let sources = ["status", "--porcelain", "--", ".", ":!docs/reliability", ":!docs/reliability.md", ":!README.md"];
    let changes = !output("git", &sources)?.is_empty();
    Ok(if changes { format!("{commit} and changes") } else { commit })
}

/// Processor, system and compiler.
pub fn machine() -> Result<String, String> {
    let processor = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_string())
    });
    let processor = processor.unwrap_or_else(|| std::env::consts::ARCH.to_string());
    let compiler = output("rustc", &["--version"])?;
    let compiler = compiler.split(" (").next().unwrap_or_default();
    Ok(format!("{processor}, {}, {}", std::env::consts::OS, compiler.trim()))
}
