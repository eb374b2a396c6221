//! Results as CSV: a heading, and rows of words and numbers in full precision.

use crate::Result;
use std::path::Path;

/// A table under construction.
pub struct Table {
    heading: Vec<String>,
    /// Its rows.
    pub rows: Vec<Vec<Cell>>,
}

/// One entry.
#[derive(Clone)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A number; one that is not finite leaves its place empty.
    Number(f64),
}

impl Cell {
    /// Words.
    pub fn text(text: impl Into<String>) -> Cell {
        Cell::Text(text.into())
    }
}

impl From<f64> for Cell {
    fn from(value: f64) -> Cell {
        Cell::Number(value)
    }
}

impl Table {
    /// An empty table.
    pub fn new(heading: &[&str]) -> Table {
        Table { heading: heading.iter().map(|name| name.to_string()).collect(), rows: Vec::new() }
    }

    /// One row more.
    pub fn add(&mut self, row: Vec<Cell>) {
        self.rows.push(row);
    }

    /// Writes the table.
    pub fn write(&self, path: &Path) -> Result<()> {
        let mut writer = csv::Writer::from_path(path)?;
        writer.write_record(&self.heading)?;
        for row in &self.rows {
            writer.write_record(row.iter().map(|cell| match cell {
                Cell::Text(text) => text.clone(),
                Cell::Number(value) if value.is_finite() => format!("{value:e}"),
                Cell::Number(_) => String::new(),
            }))?;
        }
        Ok(writer.flush()?)
    }
}
