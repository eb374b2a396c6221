//! What a command prints.
//!
//! Whoever reads it may stop, as `head` does. Then the rest is dropped and the command does its work to the
//! end: it writes its files, and its exit code is what it would have been. The macros `println` and
//! `eprintln` would panic, so clippy refuses them here.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write};

/// A text on the standard output. Ends the program if it cannot be written although somebody reads, as on a
/// full disk.
pub fn text(text: Arguments<'_>) {
    let mut out = std::io::stdout().lock();
    match out.write_fmt(text).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            aside(format_args!("error: standard output: {error}"));
            std::process::exit(2);
        }
        _ => {}
    }
}

/// A line on the standard output.
pub fn line(line: Arguments<'_>) {
    text(format_args!("{line}\n"));
}

/// A line on the standard error: warnings, errors and progress. If that cannot be written, there is nobody to
/// tell.
pub fn aside(line: Arguments<'_>) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}
