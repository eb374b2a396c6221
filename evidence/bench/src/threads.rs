//! Steps of one simulation on several threads: a band of its rows each.
//!
//! A thread that has to wait for the others spins briefly, which is quickest while all are at work, and then
//! parks, so that a busy machine loses no more than a switch. The bits are those of one thread.

use crate::Result;
use fabric_kernel::{Bands, Failure, OutcomeSet, Sim};
use std::sync::{Condvar, Mutex};
use std::time::{Duration, Instant};

/// How long a thread spins before it parks.
const SPIN: Duration = Duration::from_micros(50);

/// As [`Sim::advance_until`], on `threads` threads.
///
/// # Errors
/// The inner one is a failure of the simulation; the outer one a number of threads that it cannot be cut for.
pub fn advance_until(
    sim: &mut Sim<'_>,
    mask: OutcomeSet,
    steps: u64,
    threads: u32,
) -> Result<std::result::Result<u64, Failure>> {
    if threads == 1 {
        return Ok(sim.advance_until(mask, steps));
    }
    let mut scratch = vec![fabric_kernel::CacheLine::ZERO; sim.layout().band_lines(threads)?];
    let bands = sim.bands(&mut scratch, threads, steps)?;
    let meeting = Meeting::default();
    let work = |band| while bands.steps() < steps && !bands.outcomes().has(mask) && meeting.pass(&bands, band) {};
    std::thread::scope(|scope| {
        for band in 1..threads {
            scope.spawn(move || work(band));
        }
        work(0);
    });
    // A block that is begun ends before an outcome stops the threads, so dropping the bands takes no step
    // more.
    Ok(bands.failure().map_or(Ok(bands.steps()), Err))
}

/// Where bands wait for the last of them.
#[derive(Default)]
struct Meeting {
    parked: Mutex<()>,
    done: Condvar,
}

impl Meeting {
    /// One band's part of a pass; returns when the pass is complete. False after a failure.
    fn pass(&self, bands: &Bands<'_, '_>, band: u32) -> bool {
        let passes = bands.passes();
        // Each band has one thread, which waits below: the only refusal left is a failure.
        let Ok(last) = bands.pass(band) else {
            self.wake();
            return false;
        };
        if last {
            self.wake();
        } else {
            self.wait(|| bands.passes() > passes);
        }
        bands.failure().is_none()
    }

    /// Wakes those that parked. The lock lets nobody park between its last look and the call.
    fn wake(&self) {
        drop(self.parked.lock().unwrap_or_else(|poisoned| poisoned.into_inner()));
        self.done.notify_all();
    }

    fn wait(&self, done: impl Fn() -> bool) {
        let start = Instant::now();
        while start.elapsed() < SPIN {
            for _ in 0..32 {
                if done() {
                    return;
                }
                std::hint::spin_loop();
            }
        }
        let mut parked = self.parked.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        while !done() {
            parked = self.done.wait(parked).unwrap_or_else(|poisoned| poisoned.into_inner());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::Buffers;
    use fabric_kernel::Scene;

    /// Step count and digest at an outcome.
    fn ends_at(threads: u32) -> (u64, u64) {
        let mut scene = Scene::sheet_3in_sphere();
        (scene.sheet.nodes_x, scene.sheet.nodes_y) = (31, 31);
        let mut buffers = Buffers::of(&scene).unwrap();
        let mut sim = buffers.sim(&scene).unwrap();
        let until = OutcomeSet::ENDS;
        let mut taken = 0;
        while !sim.outcomes().mask.has(until) {
            taken += advance_until(&mut sim, until, 1000, threads).unwrap().unwrap();
        }
        assert_eq!(taken, sim.step_count());
        (taken, sim.digest())
    }

    #[test]
    fn threads_change_no_bit_and_stop_at_the_same_outcome() {
        let one = ends_at(1);
        assert!(!one.0.is_multiple_of(1000));
        assert_eq!([ends_at(2), ends_at(3)], [one, one]);
    }

    #[test]
    fn a_failure_ends_all_threads() {
        let mut scene = Scene::sheet_3in_sphere();
        (scene.sheet.nodes_x, scene.sheet.nodes_y) = (31, 31);
        scene.contact_capacity = 1;
        let mut buffers = Buffers::of(&scene).unwrap();
        let mut sim = buffers.sim(&scene).unwrap();
        let failure = advance_until(&mut sim, OutcomeSet::NONE, 1000, 2).unwrap();
        assert_eq!(failure, Err(Failure::ContactCapacity));
    }
}
