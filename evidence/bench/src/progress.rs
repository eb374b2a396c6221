//! Progress of long work: a bar on a terminal, a plain line every few seconds otherwise, always on standard
//! error.

use crate::say;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Time between two plain lines.
const PAUSE: Duration = Duration::from_secs(3);

/// Progress over a known amount of work. Threads may share it.
pub struct Progress {
    bar: Option<ProgressBar>,
    what: String,
    total: u64,
    /// Work done, and when the last plain line appeared.
    done: Mutex<(u64, Instant)>,
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
            say::aside(format_args!("{what} ..."));
        }
        Progress { bar, what: what.to_string(), total: total.max(1), done: Mutex::new((0, Instant::now())) }
    }

    /// Counts `pieces` of work as done; `message` says where the work stands.
    pub fn add(&self, pieces: u64, message: impl FnOnce() -> String) {
        let Ok(mut done) = self.done.lock() else { return };
        done.0 += pieces;
        if let Some(bar) = &self.bar {
            bar.set_message(message());
            bar.set_position(done.0);
        } else if done.1.elapsed() > PAUSE {
            say::aside(format_args!("{} {:>3} %  {}", self.what, 100 * done.0.min(self.total) / self.total, message()));
            done.1 = Instant::now();
        }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
