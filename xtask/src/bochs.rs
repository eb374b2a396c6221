//! Bochs, an emulator of x86-64 processors that knows AVX-512. It runs a program that is the whole ROM of a bare machine
//! (tests/digests/processor.S): no firmware, no boot loader, no operating system.

use crate::tools::{Outcome, emptied, finish, read, target, wait_within, write};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

/// The processor, by Bochs's name: the oldest of those with AVX-512.
pub const MODEL: &str = "corei7_skylake_x";
/// Files besides digests.c that make the program.
pub const SOURCES: &[&str] = &["tests/digests/processor.S", "tests/digests/processor.c", "tests/digests/memory.c"];
/// Where its parts lie.
pub const LAYOUT: &str = "-Ttests/digests/processor.ld";

/// The machine besides its processor: memory, the ROM, and a serial port whose text goes to a file. Only Bochs needs the screen.
const MACHINE: &str = "\
memory: guest=32, host=32
romimage: file=rom
com1: enabled=1, mode=file, dev=printed
display_library: term
log: log
panic: action=fatal
";

/// Whether Bochs is here and has all of that machine; if not, what is missing and how to get it.
pub fn ready() -> Outcome {
    let folder = folder("probe")?;
    // It reads the configuration, misses the ROM, and ends.
    let said =
        started(&folder, Duration::from_secs(60)).map_err(|what| format!("{what} (Debian: bochs bochs-term)"))?;
    if said.contains("ROM image") { Ok(()) } else { Err(format!("bochs says: {said} (Debian: bochs bochs-term)")) }
}

/// Runs a linked program; returns what it printed.
pub fn run(program: &Path) -> Result<String, String> {
    let folder = folder("machine")?;
    finish(Command::new("objcopy").args(["-O", "binary", "-j", ".rom"]).arg(program).arg(folder.join("rom")))?;
    let said = started(&folder, Duration::from_secs(900))?;
    if !said.contains("Shutdown port") {
        return Err(format!("bochs says: {said}"));
    }
    let printed = folder.join("printed");
    read(&printed)
}

/// A new folder for a machine, with its configuration and Bochs's input.
fn folder(name: &str) -> Result<PathBuf, String> {
    let folder = emptied(target().join("digests").join("bochs").join(name))?;
    // A processor that faults without remedy ends Bochs with an error.
    let processor = format!("cpu: model={MODEL}, ips=100000000, reset_on_triple_fault=0\n");
    write(folder.join("bochsrc"), processor + MACHINE)?;
    // Debian's Bochs has a debugger that waits for the word to continue.
    write(folder.join("input"), "c\n")?;
    Ok(folder)
}

/// Starts the machine of a folder and waits for its end; returns the message with which Bochs ended. It always ends with one, and
/// with an exit code other than 0.
fn started(folder: &Path, longest: Duration) -> Result<String, String> {
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    let mut child = Command::new("bochs")
        .args(["-q", "-f", "bochsrc"])
        .env("TERM", "dumb")
        .current_dir(folder)
        .stdin(File::open(folder.join("input")).map_err(failed)?)
        .stdout(Stdio::null())
        .stderr(File::create(folder.join("messages")).map_err(failed)?)
        .spawn()
        .map_err(|error| format!("cannot start bochs: {error}"))?;
    wait_within(&mut child, longest)?;
    let messages = std::fs::read(folder.join("messages")).map_err(failed)?;
    Ok(last_message(&String::from_utf8_lossy(&messages)))
}

/// The message with which Bochs ended.
fn last_message(messages: &str) -> String {
    let (_, end) = messages.rsplit_once("exiting with the following message:").unwrap_or(("", "nothing"));
    end.trim().lines().next().unwrap_or("nothing").to_string()
}

#[cfg(test)]
mod tests {
    use super::last_message;

    #[test]
    fn the_last_message_is_found() {
        let messages = "e[SIM   ]\n====\nBochs is exiting with the following message:\n[MEM0  ] ROM: none\n====\n";
        assert_eq!(last_message(messages), "[MEM0  ] ROM: none");
        assert_eq!(last_message("Killed"), "nothing");
    }
}
