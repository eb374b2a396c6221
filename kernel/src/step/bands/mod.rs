//! The sweep cut into row bands, for threads that the caller lends. No thread is started here and nothing
//! waits here.
//!
//! Method: a pass, outside blocks a step, is one call of
//! [`Bands::pass`] for every band, in any order, on any threads. Each call sweeps its own rows. The last to
//! arrive, told by one atomic word, also does what cannot be cut: contact, the body, the outcomes, and what
//! the next pass needs to start: the candidates, and at every cut a copy of the row above it and the forces
//! of the segments across it. One meeting a pass, and that is the caller's: a band that is called again
//! before all have arrived is refused. If the caller says how many steps it wants, a sheet beyond the caches
//! takes several of them in a block of one pass more (`step/schedule.rs`). The bits are those of
//! [`Sim::step`](crate::Sim::step), whatever the cut.
//! Limits: velocity Verlet; at most [`MAX_BANDS`] bands. Contact is not shared out.
//! Reference: docs/model.md, "Row bands".
//!
//! ```
//! use fabric_kernel::{CacheLine, Layout, Scene, Sim};
//!
//! let mut scene = Scene::sheet_3in_sphere();
//! (scene.sheet.nodes_x, scene.sheet.nodes_y) = (41, 41);
//! let layout = Layout::of(&scene)?;
//! let mut memory = vec![CacheLine::ZERO; layout.lines()];
//! let mut sim = Sim::new(&scene, &mut memory)?;
//!
//! let mut scratch = vec![CacheLine::ZERO; layout.band_lines(2)?];
//! let bands = sim.bands(&mut scratch, 2, 100)?;
//! std::thread::scope(|threads| {
//!     for band in 0..2 {
//!         let bands = &bands;
//!         threads.spawn(move || {
//!             while bands.steps() < 100 {
//!                 let passes = bands.passes();
//!                 if bands.pass(band).is_err() {
//!                     break; // a failure; every band is told at its next call
//!                 }
//!                 while bands.passes() == passes {
//!                     std::thread::yield_now(); // better: spin briefly, then park
//!                 }
//!             }
//!         });
//!     }
//! });
//! drop(bands);
//! assert_eq!(sim.step_count(), 100);
//! # Ok::<(), fabric_kernel::Error>(())
//! ```
//! With `lanes.rs` this folder is the only place of the kernel with unsafe code.
#![allow(unsafe_code)]

/// A band's part of a pass, and what is not cut.
mod pass;
/// Plan of a pass.
mod plan;
/// Pointers into the simulation's arrays.
mod pointers;
/// Scratch of the bands.
mod scratch;

use crate::ground::error::{Code, Error, Failure};
use crate::ground::lanes::CacheLine;
use crate::memory::arrays;
use crate::memory::layout::MAX_BANDS;
use crate::memory::system::System;
use crate::memory::watch::OutcomeSet;
use crate::sweep::segments::Report;
use core::cell::UnsafeCell;
use core::marker::PhantomData;
use core::sync::atomic::{AtomicI32, AtomicU32, AtomicUsize, Ordering};
use plan::Plan;

/// A simulation lent to be stepped in bands. Shared by reference between threads; made by
/// [`Sim::bands`](crate::Sim::bands), which has the whole simulation until this is dropped. Dropping it does
/// what is missing of a step that only some bands have taken; forgotten within a block it leaves rows at
/// different steps.
pub struct Bands<'s, 'a> {
    system: *mut System<'a>,
    band_count: u32,
    /// Steps taken before these bands, and those that will have been taken at least.
    first_step: u64,
    until: u64,
    /// Written by the last band to arrive, read by all bands between two meetings.
    plan: UnsafeCell<Plan>,
    /// Written by its own band, read by the last to arrive.
    reports: [UnsafeCell<Report>; MAX_BANDS as usize],
    /// One bit for every band that was called in this pass.
    claimed: AtomicU32,
    /// One bit for every band that has done its rows in this pass.
    arrived: AtomicU32,
    passes: AtomicUsize,
    steps: AtomicUsize,
    outcomes: AtomicU32,
    /// Number of the failure's code, or 0.
    failure: AtomicI32,
    lent: PhantomData<(&'s mut System<'a>, &'s mut [f64])>,
}

// SAFETY: holds a `&mut System` and a `&mut [f64]`, both of which may go to another thread.
unsafe impl Send for Bands<'_, '_> {}
// SAFETY: everything under the pointers and cells is reached through `pass` alone. A band's rows, report and
// scratch `above`, `carry`, `viscous` and `kept` are used only by the call that has set the band's bit in
// `claimed`. All else is changed only by the call that finds all bits of `arrived` set, while every bit of
// `claimed` still keeps the others out. In a block (`step/schedule.rs`) rows are tiles and gaps. No two have
// a row in common, for gaps stay apart. In addition
// - a tile writes at its upper edge the moments (`past`) of the gap's lowest row, what they dissipate and the
//   forces on it; at its lower edge ghost row and moments above the gap. No other tile has that edge;
// - a tile reads of a gap the rows beside its own: above it the lowest ones, whose moments it finds, below it
//   the highest ones. So a gap has at first as many rows as keep what is read and written apart;
// - a gap reads what its two tiles have kept of each step, in passes after theirs.
unsafe impl Sync for Bands<'_, '_> {}

impl<'s, 'a> Bands<'s, 'a> {
    /// Bands of a system, see `Sim::bands`.
    pub(crate) fn of(
        system: &'s mut System<'a>,
        scratch: &'s mut [CacheLine],
        band_count: u32,
        steps: u64,
    ) -> Result<Bands<'s, 'a>, Error> {
        system.sound()?;
        let needed = system.network.layout.band_lines(band_count)?;
        let short = arrays::short("scratch", scratch.len(), needed);
        let scratch = CacheLine::reals(scratch.get_mut(..needed).ok_or(short)?).as_mut_ptr();
        let first_step = system.state.step;
        let until = first_step.saturating_add(steps);
        let plan = Plan::of(system, scratch, None, band_count, until);
        for band in 0..band_count {
            // SAFETY: this call has the simulation to itself, so no band is being swept.
            unsafe { plan.copy_ghost_rows(band_count, band) };
        }
        let outcomes = system.state.watch.mask().bits();
        Ok(Bands {
            system,
            band_count,
            first_step,
            until,
            plan: UnsafeCell::new(plan),
            reports: core::array::from_fn(|_| UnsafeCell::new(Report::default())),
            claimed: AtomicU32::new(0),
            arrived: AtomicU32::new(0),
            passes: AtomicUsize::new(0),
            steps: AtomicUsize::new(0),
            outcomes: AtomicU32::new(outcomes),
            failure: AtomicI32::new(0),
            lent: PhantomData,
        })
    }
}

impl Bands<'_, '_> {
    /// One band's part of the present pass: sweeps its rows; the last band to be done completes the pass for
    /// all. Returns whether this was the last. Another call for this band is refused until the pass is
    /// complete, see [`Bands::passes`].
    ///
    /// # Errors
    /// No such band, or one already called in this pass: nothing changed. A failure of the pass, to the band
    /// that completes it, and to every band from then on.
    pub fn pass(&self, band: u32) -> Result<bool, Error> {
        if band >= self.band_count {
            return Err(Error::new(Code::OutOfRange, "band", f64::from(band), f64::from(self.band_count - 1)));
        }
        if let Some(failure) = self.failure() {
            return Err(failure.into());
        }
        let bit = 1 << band;
        if self.claimed.fetch_or(bit, Ordering::AcqRel) & bit != 0 {
            return Err(Error::new(Code::BandOutOfTurn, "band", f64::from(band), 0.0));
        }
        // SAFETY: this call has claimed the band, so no other has its rows, its own scratch and report; the
        // claim has acquired what the completion of the pass before released, and nobody changes the plan
        // before this band arrives.
        unsafe {
            let plan = &*self.plan.get();
            let met = match &plan.block {
                Some(block) => match plan.gap_step {
                    Some(step) => plan.sweep(self.band_count, band).merged(plan.sweep_gap(band, block, step)),
                    None => plan.step_away(band, block),
                },
                None => plan.sweep(self.band_count, band),
            };
            if let Some(report) = self.reports.get(band as usize) {
                *report.get() = met;
            }
        }
        let all = u32::MAX >> (32 - self.band_count);
        if self.arrived.fetch_or(bit, Ordering::AcqRel) | bit != all {
            return Ok(false);
        }
        // SAFETY: all bands have arrived and released what they wrote; every claim still stands, so that no
        // call gets beyond it before this one has cleared them.
        let result = unsafe { self.complete() };
        self.arrived.store(0, Ordering::Relaxed);
        self.claimed.store(0, Ordering::Release);
        // After the claims: who sees the new count finds them cleared.
        self.passes.fetch_add(1, Ordering::Release);
        result?;
        Ok(true)
    }

    /// Passes completed since [`Sim::bands`](crate::Sim::bands), one that failed included: a band's turn
    /// comes again when this has grown. Any thread may look. With a band's call outstanding this and the two
    /// below cannot change.
    pub fn passes(&self) -> u64 {
        self.passes.load(Ordering::Acquire) as u64
    }

    /// Steps completed since [`Sim::bands`](crate::Sim::bands).
    pub fn steps(&self) -> u64 {
        self.steps.load(Ordering::Acquire) as u64
    }

    /// Bits of the outcomes latched so far.
    pub fn outcomes(&self) -> OutcomeSet {
        OutcomeSet::from_bits(self.outcomes.load(Ordering::Acquire))
    }

    /// The failure that ended the last pass, if one did.
    pub fn failure(&self) -> Option<Failure> {
        let number = self.failure.load(Ordering::Acquire);
        [Failure::NonFinite, Failure::ContactCapacity, Failure::TooFast, Failure::NotConverged]
            .into_iter()
            .find(|failure| failure.code().number() == number)
    }

    /// Everything after the sweep, then the plan of the next pass.
    ///
    /// # Safety
    /// All bands have arrived and none can be claimed.
    #[inline(never)]
    unsafe fn complete(&self) -> Result<(), Failure> {
        // SAFETY: the caller's promise; the bands' slices of rows and scratch are gone.
        let (system, plan) = unsafe { (&mut *self.system, &mut *self.plan.get()) };
        let mut report = Report::default();
        for cell in self.reports.iter().take(self.band_count as usize) {
            // SAFETY: the band has arrived.
            report = report.merged(unsafe { *cell.get() });
        }
        // SAFETY: as above.
        let closed = unsafe { plan.close(system, report) };
        if let Err(failure) = system.latch(closed) {
            self.failure.store(failure.code().number(), Ordering::Release);
            return Err(failure);
        }
        if plan.next_part().is_none() {
            self.steps.store((system.state.step - self.first_step) as usize, Ordering::Release);
        }
        self.outcomes.store(system.state.watch.mask().bits(), Ordering::Release);
        *plan = Plan::of(system, plan.memory.scratch, Some(plan), self.band_count, self.until);
        for band in 0..self.band_count {
            // SAFETY: the caller's promise.
            unsafe { plan.copy_ghost_rows(self.band_count, band) };
        }
        Ok(())
    }
}

impl Drop for Bands<'_, '_> {
    /// Does what is missing of a begun step, or block of steps.
    fn drop(&mut self) {
        while self.failure().is_none() {
            let (called, plan) = (*self.claimed.get_mut(), self.plan.get_mut());
            let in_block = plan.gap_step.is_some();
            if called == 0 && !in_block {
                return;
            }
            // Only those that have not been called: the last of them completes the pass, and any after it
            // would begin another. A call that never came back leaves none.
            let mut missing = (0..self.band_count).filter(|band| called >> band & 1 == 0).peekable();
            if missing.peek().is_none() {
                return;
            }
            missing.for_each(|band| {
                let _ = self.pass(band);
            });
        }
    }
}
