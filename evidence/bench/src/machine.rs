//! The machine a measurement was made on, and the clocks.

/// Name of the processor, or the architecture where it is not known.
pub fn processor() -> String {
    let cores = std::thread::available_parallelism().map_or(1, |n| n.get());
    let name = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_string())
    });
    format!("{} ({cores} cores)", name.unwrap_or_else(|| std::env::consts::ARCH.to_string()))
}

/// Mean number of running processes over the last minute, where the system tells it.
pub fn load() -> Option<f64> {
    std::fs::read_to_string("/proc/loadavg").ok()?.split_whitespace().next()?.parse().ok()
}

/// What [`Clock`] measures, for table headings.
pub const CLOCK_NAME: &str = if cfg!(unix) { "thread CPU time" } else { "wall time" };

/// A clock for the calling thread: its CPU time where the system offers it, because time slices of other
/// programs do not count; otherwise wall time.
pub struct Clock {
    #[cfg(unix)]
    start: f64,
    #[cfg(not(unix))]
    start: std::time::Instant,
}

impl Clock {
    /// Starts now.
    pub fn start() -> Clock {
        #[cfg(unix)]
        return Clock { start: thread_seconds() };
        #[cfg(not(unix))]
        return Clock { start: std::time::Instant::now() };
    }

    /// Seconds since the start.
    pub fn seconds(&self) -> f64 {
        #[cfg(unix)]
        return thread_seconds() - self.start;
        #[cfg(not(unix))]
        return self.start.elapsed().as_secs_f64();
    }
}

#[cfg(unix)]
fn thread_seconds() -> f64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}
