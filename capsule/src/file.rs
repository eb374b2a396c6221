//! A file as a sink.

extern crate std;

use crate::Sink;
use std::fs;
use std::io::{BufWriter, Result, Write};
use std::path::Path;

/// A file that is written record by record, so that it can be replayed though its program crashes.
pub struct File(BufWriter<fs::File>);

impl File {
    /// A new file, in place of one that is there.
    ///
    /// # Errors
    /// Those of the system.
    pub fn new(path: &Path) -> Result<File> {
        fs::File::create(path).map(BufWriter::new).map(File)
    }
}

impl Sink for File {
    fn take(&mut self, bytes: &[u8]) -> bool {
        self.0.write_all(bytes).is_ok()
    }

    fn record_ends(&mut self) -> bool {
        self.0.flush().is_ok()
    }
}
