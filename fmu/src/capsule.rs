//! A capsule in the host's log: what the host does to the simulation, as lines that `fabric replay` reads.
//!
//! An FMU has no files of its own; the log is what every host keeps and can send. Each line has up to 100
//! bytes as hexadecimal digits.

use crate::log::{Category, Line, Log};
use core::fmt::Write;
use fabric_capsule::{Call, Log as Written, Sink};
use fabric_kernel::{Error, Sim};

/// Calls between two digests of the state; a communication step is two calls.
const DIGESTS: u64 = 1000;

/// Bytes on their way into lines.
pub struct Lines {
    log: Log,
    waiting: heapless::Vec<u8, 100>,
}

impl Sink for Lines {
    fn take(&mut self, bytes: &[u8]) -> bool {
        for byte in bytes {
            if self.waiting.is_full() {
                self.record_ends();
            }
            // There is room now.
            let _ = self.waiting.push(*byte);
        }
        true
    }

    fn record_ends(&mut self) -> bool {
        let mut line = Line::new();
        let _ = line.push_str("capsule: ");
        for byte in &self.waiting {
            let _ = write!(line, "{byte:02x}");
        }
        self.waiting.clear();
        self.log.say(Category::Capsule, &line);
        true
    }
}

/// A capsule that may be written.
#[derive(Default)]
pub struct Capsule(Option<Written<Lines>>);

impl Capsule {
    /// Begins one, at step 0.
    pub fn begin(&mut self, sim: &mut Sim<'_>, log: &Log) {
        let lines = Lines { log: log.clone(), waiting: heapless::Vec::new() };
        self.0 = Some(Written::begin(sim, DIGESTS, lines));
    }

    /// Does a call, and writes it.
    ///
    /// # Errors
    /// Errors of the call.
    pub fn run(&mut self, sim: &mut Sim<'_>, call: &Call<'_>) -> Result<(), Error> {
        fabric_capsule::run(&mut self.0, sim, call)
    }

    /// Writes a call that was done.
    pub fn note(&mut self, sim: &Sim<'_>, call: &Call<'_>) {
        if let Some(written) = &mut self.0 {
            written.note(call, sim);
        }
    }

    /// Ends it.
    pub fn end(&mut self, sim: Option<&Sim<'_>>) {
        if let (Some(mut written), Some(sim)) = (self.0.take(), sim) {
            written.end(sim);
        }
    }
}
