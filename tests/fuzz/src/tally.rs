//! Counts a campaign's inputs, and those that got past the first check, for `cargo xtask fuzz`.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

static ALL: AtomicU64 = AtomicU64::new(0);
static DEEP: AtomicU64 = AtomicU64::new(0);

/// Counts one input. Every 1024 the counts so far are written to the file that the environment variable
/// FABRIC_FUZZ_TALLY names.
pub fn count(deep: bool) {
    let all = ALL.fetch_add(1, Relaxed) + 1;
    let deep = DEEP.fetch_add(u64::from(deep), Relaxed) + u64::from(deep);
    if all.is_multiple_of(1024)
        && let Some(file) = std::env::var_os("FABRIC_FUZZ_TALLY")
    {
        // A count that cannot be written is only not reported.
        let _ = std::fs::write(file, format!("{deep} {all}\n"));
    }
}
