//! A file as a sink.

extern crate std;

use crate::Sink;
use std::fs::{self, TryLockError};
use std::io::{BufWriter, Error, ErrorKind, Result, Write};
use std::path::Path;
use std::process;

/// A file that is written record by record, so that it can be replayed though its program crashes. It is locked, and of the process that
/// made it: a forked child writes nothing.
pub struct File {
    file: BufWriter<fs::File>,
    owner: u32,
}

impl File {
    /// A new file, in place of one that is there.
    ///
    /// # Errors
    /// Errors of the system; a file that another simulation writes.
    pub fn new(path: &Path) -> Result<File> {
        let file = fs::OpenOptions::new().write(true).create(true).truncate(false).open(path)?;
        // A file system without locks has no say.
        if matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
            return Err(Error::new(ErrorKind::ResourceBusy, "another simulation writes this capsule"));
        }
        if file.metadata()?.is_file() {
            file.set_len(0)?;
        }
        Ok(File { file: BufWriter::new(file), owner: process::id() })
    }
}

impl Sink for File {
    fn take(&mut self, bytes: &[u8]) -> bool {
        process::id() == self.owner && self.file.write_all(bytes).is_ok()
    }

    fn record_ends(&mut self) -> bool {
        self.file.flush().is_ok()
    }
}
