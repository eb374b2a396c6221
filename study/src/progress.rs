//! Progress of long work: a bar on a terminal, plain lines otherwise, always on standard error.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Progress over a known amount of work. Threads may share it.
pub struct Progress {
    bar: Option<ProgressBar>,
    what: String,
    total: u64,
    done: AtomicU64,
}

impl Progress {
    /// Starts at 0 of `total` pieces of work.
    pub fn new(what: &str, total: u64) -> Progress {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new(total);
            let style = ProgressStyle::with_template("{prefix} {bar:30} {percent:>3} %  {eta:>4} left  {msg}");
            if let Ok(style) = style {
                bar.set_style(style);
            }
            bar.set_prefix(what.to_string());
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        });
        if bar.is_none() {
            eprintln!("{what} ...");
        }
        Progress { bar, what: what.to_string(), total: total.max(1), done: AtomicU64::new(0) }
    }

    /// Counts `pieces` of work as done; `message` says where the work stands. Without a terminal a line appears at every tenth.
    pub fn add(&self, pieces: u64, message: impl FnOnce() -> String) {
        let before = self.done.fetch_add(pieces, Ordering::Relaxed);
        let after = before + pieces;
        match &self.bar {
            Some(bar) => {
                bar.set_message(message());
                bar.set_position(after);
            }
            None if 10 * after / self.total > 10 * before / self.total => {
                eprintln!("{} {:>3} %  {}", self.what, 100 * after.min(self.total) / self.total, message());
            }
            None => {}
        }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
