//! The sweep cut into row bands, for threads that the caller lends. No thread is started here and nothing waits here.
//!
//! Method: a pass (a step, or half of one after `step_after_failure`; with viscosity two make one of these) is one call of
//! [`Bands::pass`] for every band, in any order, on any threads. Each call sweeps its own rows. The last to arrive, told by one atomic word, also does what cannot be
//! cut: contact, the body, the outcomes, and what the next pass needs to start: the candidates, and at every cut a copy of
//! the row above it and the forces of the segments across it. One meeting a pass, and that is the caller's: a band that is
//! called again before all have arrived is refused. Of viscous yarn the first pass finds what viscosity changes, from velocities
//! that none has changed yet, and the second one sweeps. If the caller says how many steps it wants, a sheet beyond the caches takes eight
//! of them in a block of nine passes (`pieces.rs`). The bits are those of [`Sim::step`](crate::Sim::step), whatever the cut.
//! Limits: velocity Verlet; at most [`MAX_BANDS`] bands. Contact is not shared out.
//! Reference: docs/model.md, "Row bands".
//!
//! ```
//! use fabric::{CacheLine, Layout, Scene, Sim};
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
//! # Ok::<(), fabric::Error>(())
//! ```
//! With `lanes.rs` this is the only file of the kernel with unsafe code.
#![allow(unsafe_code)]

use crate::body::pose::Vector;
use crate::contact::search::Gathered;
use crate::ground::error::{Code, Error, Failure};
use crate::ground::lanes::{CacheLine, InstructionSet};
use crate::ground::planes::{
    CARRY_PLANES, CHUNK, Chunk, HISTORY_PLANES, HOT_PLANES, MARK_PLANES, PUSH_PLANES, RATE_PLANES, STRENGTH_PLANES,
    VISCOUS_PLANES, YARN_PLANES,
};
use crate::memory::blocks::Blocks;
use crate::memory::layout::{BLOCK_STEPS, Layout, MAX_BANDS};
use crate::memory::rows::{Rows, Terms};
use crate::memory::system::{self, System};
use crate::memory::watch::OutcomeSet;
use crate::scene::features::Feature;
use crate::sheet::direction::Directions;
use crate::sheet::grading::{LINE_PLANES, Net};
use crate::sheet::sweep::Report;
use crate::step::explicit;
use crate::step::pieces::{Course, Edge, Piece};
use crate::step::relaxation;
use crate::step::viscosity;
use crate::yarn::rate::Rates;
use crate::yarn::toe::Toe;
use core::cell::UnsafeCell;
use core::marker::PhantomData;
use core::slice::{from_raw_parts, from_raw_parts_mut};
use core::sync::atomic::{AtomicI32, AtomicU32, AtomicUsize, Ordering};

/// A simulation lent to be stepped in bands. Shared by reference between threads; made by [`Sim::bands`](crate::Sim::bands), which has the whole
/// simulation until this is dropped. Dropping it does what is missing of a step that only some bands have taken.
pub struct Bands<'s, 'a> {
    system: *mut System<'a>,
    of: u32,
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
// SAFETY: everything behind the pointers and cells is reached through `pass` alone. A band's own rows, report and the first four parts
// of its scratch are used only by the call that has set the band's bit in `claimed`; what is kept for the gaps of a block has one
// writer in the first pass and is used by one band in the later ones; the simulation and the plan are changed only by the call
// that finds all bits of `arrived` set, while every bit of `claimed` still keeps the others out.
unsafe impl Sync for Bands<'_, '_> {}

/// What all bands need to know for one pass.
struct Plan {
    /// Where the pass ends, in parts of the step.
    end: f64,
    /// Whether it is the second half of a step that is begun.
    second_half: bool,
    /// Failed segments at the step's start.
    failed_before: u64,
    /// What lies under the projectile, or why the pass cannot be made.
    found: Result<Gathered, Failure>,
    /// Rows to sweep [first, end); of a stack from the first of the lowest ply to the last of the highest, and those between that
    /// rest are left out.
    rows: [usize; 2],
    /// Whether the bands find now what viscosity changes, and sweep afterwards.
    pushing: bool,
    /// The block of steps that the pass is part of, if it is.
    course: Option<Course>,
    /// Whether rows at rest are swept.
    all: bool,
    layout: Layout,
    toe: Toe,
    rates: Rates,
    fetches: bool,
    instructions: InstructionSet,
    /// Whether segments may have a toe's mark.
    marked: bool,
    track_support: bool,
    memory: Pointers,
}

/// Where the rows are: from the simulation's blocks, taken anew for every pass.
#[derive(Clone, Copy)]
struct Pointers {
    directions: *const Directions,
    hot: *mut Chunk<HOT_PLANES>,
    history: *mut Chunk<HISTORY_PLANES>,
    yarn: *const Chunk<YARN_PLANES>,
    strength: *const Chunk<STRENGTH_PLANES>,
    logarithms: *const Chunk<RATE_PLANES>,
    marks: *const Chunk<MARK_PLANES>,
    pushes: *mut Chunk<PUSH_PLANES>,
    taken: *mut f64,
    columns: *const Chunk<LINE_PLANES>,
    lines: *const Chunk<LINE_PLANES>,
    before: *mut [f64; CHUNK],
    awake: *const [u32; 2],
    ranges: *mut [u32; 4],
    runs: *const [u32; 4],
    /// Vertical forces of each step of a block, and pulls of the fixed nodes of each step and row.
    carries: *mut Chunk<CARRY_PLANES>,
    noted: *mut [[f64; 3]; 2],
    /// The bands' own numbers, then the pulls of the fixed nodes, six a row.
    scratch: *mut f64,
}

impl Pointers {
    /// Into these blocks and the bands' scratch.
    fn of(directions: *const Directions, blocks: &mut Blocks<'_>, scratch: *mut f64) -> Pointers {
        let Blocks {
            hot,
            history,
            yarn,
            strength,
            logarithms,
            marks,
            pushes,
            taken,
            columns,
            lines,
            before,
            awake,
            ranges,
            runs,
            carries,
            pulls,
            ..
        } = blocks;
        Pointers {
            directions,
            hot: hot.as_mut_ptr(),
            history: history.as_mut_ptr(),
            yarn: yarn.as_ptr(),
            strength: strength.as_ptr(),
            logarithms: logarithms.as_ptr(),
            marks: marks.as_ptr(),
            pushes: pushes.as_mut_ptr(),
            taken: taken.as_mut_ptr(),
            columns: columns.as_ptr(),
            lines: lines.as_ptr(),
            before: before.as_mut_ptr(),
            awake: awake.as_ptr(),
            ranges: ranges.as_mut_ptr(),
            runs: runs.as_ptr(),
            carries: carries.as_mut_ptr(),
            noted: pulls.as_mut_ptr().cast(),
            scratch,
        }
    }
}

/// A band's own numbers.
struct Scratch<'r> {
    /// The row above the band as it was at the pass's start.
    above: &'r mut [Chunk<HOT_PLANES>],
    /// Vertical forces from the row below the band.
    carry: &'r mut [Chunk<CARRY_PLANES>],
    /// Work row of viscosity.
    work: &'r mut [Chunk<VISCOUS_PLANES>],
    kept: &'r mut [[f64; 3]],
}

impl<'s, 'a> Bands<'s, 'a> {
    /// Bands of a system, see `Sim::bands`.
    pub(crate) fn of(
        system: &'s mut System<'a>,
        scratch: &'s mut [CacheLine],
        of: u32,
        steps: u64,
    ) -> Result<Bands<'s, 'a>, Error> {
        system.sound()?;
        let needed = system.layout.band_lines(of)?;
        let short = Error::new(Code::ShortBuffer, "scratch", scratch.len() as f64, needed as f64);
        let scratch = CacheLine::reals(scratch.get_mut(..needed).ok_or(short)?).as_mut_ptr();
        let first_step = system.state.step;
        let until = first_step.saturating_add(steps);
        let plan = Plan::of(system, scratch, None, of, until);
        for band in 0..of {
            // SAFETY: this call has the simulation to itself, so no band is being swept.
            unsafe { plan.cut(of, band) };
        }
        let outcomes = system.state.watch.mask().bits();
        Ok(Bands {
            system,
            of,
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
    /// One band's part of the present pass: sweeps its rows; the last band to be done completes the pass for all. Returns
    /// whether this was the last. Another call for this band is refused until the pass is complete, see [`Bands::passes`].
    ///
    /// # Errors
    /// No such band, or one already called in this pass: nothing changed. A failure of the pass, to the band that completes
    /// it, and to every band from then on.
    pub fn pass(&self, band: u32) -> Result<bool, Error> {
        if band >= self.of {
            return Err(Error::new(Code::OutOfRange, "band", f64::from(band), f64::from(self.of - 1)));
        }
        if let Some(failure) = self.failure() {
            return Err(failure.into());
        }
        let bit = 1 << band;
        if self.claimed.fetch_or(bit, Ordering::AcqRel) & bit != 0 {
            return Err(Error::new(Code::BandOutOfTurn, "band", f64::from(band), 0.0));
        }
        // SAFETY: this call has claimed the band, so no other has its rows, its own scratch and report; the claim has acquired what
        // the completion of the pass before released, and nobody changes the plan before this band arrives.
        unsafe {
            let plan = &*self.plan.get();
            let met = match &plan.course {
                _ if plan.pushing => plan.push(self.of, band),
                Some(course) if course.is_at_start() => plan.step_away(band, course),
                Some(course) => plan.sweep(self.of, band).merged(plan.fill_cut(band, course)),
                None => plan.sweep(self.of, band),
            };
            if let Some(report) = self.reports.get(band as usize) {
                *report.get() = met;
            }
        }
        let all = u32::MAX >> (32 - self.of);
        if self.arrived.fetch_or(bit, Ordering::AcqRel) | bit != all {
            return Ok(false);
        }
        // SAFETY: all bands have arrived and released what they wrote; every claim still stands, so that no call gets
        // beyond it before this one has cleared them.
        let result = unsafe { self.complete() };
        self.arrived.store(0, Ordering::Relaxed);
        self.claimed.store(0, Ordering::Release);
        // Behind the claims: who sees the new count finds them cleared.
        self.passes.fetch_add(1, Ordering::Release);
        result?;
        Ok(true)
    }

    /// Passes completed since [`Sim::bands`](crate::Sim::bands), one that failed included: a band's turn comes again when this has grown. Any
    /// thread may look. With a band's call outstanding this and the two below cannot change.
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

    /// Everything behind the sweep, then the plan of the next pass.
    ///
    /// # Safety
    /// All bands have arrived and none can be claimed.
    #[inline(never)] // The next plan must not add to the stack of a sweep.
    unsafe fn complete(&self) -> Result<(), Failure> {
        // SAFETY: the caller's promise; the bands' slices of rows and scratch are gone.
        let (system, plan) = unsafe { (&mut *self.system, &mut *self.plan.get()) };
        if plan.pushing {
            plan.pushing = false;
            return Ok(());
        }
        let mut report = Report::default();
        for cell in self.reports.iter().take(self.of as usize) {
            // SAFETY: the band has arrived.
            report = report.merged(unsafe { *cell.get() });
        }
        // SAFETY: as above.
        if let Err(failure) = unsafe { plan.close(system, self.of, report) } {
            system.failure = Some(failure);
            self.failure.store(failure.code().number(), Ordering::Release);
            return Err(failure);
        }
        if plan.next_part().is_none() {
            self.steps.store((system.state.step - self.first_step) as usize, Ordering::Release);
        }
        self.outcomes.store(system.state.watch.mask().bits(), Ordering::Release);
        *plan = Plan::of(system, plan.memory.scratch, Some(plan), self.of, self.until);
        for band in 0..self.of {
            // SAFETY: the caller's promise.
            unsafe { plan.cut(self.of, band) };
        }
        Ok(())
    }
}

impl Drop for Bands<'_, '_> {
    /// Does what is missing of a begun step, or block of steps.
    fn drop(&mut self) {
        while self.failure().is_none() {
            let (called, plan) = (*self.claimed.get_mut(), self.plan.get_mut());
            let pushed = plan.layout.has(Feature::Viscosity) && plan.found.is_ok() && !plan.pushing;
            let in_block = plan.course.is_some_and(|course| !course.is_at_start());
            if called == 0 && !plan.second_half && !pushed && !in_block {
                return;
            }
            // Only those that have not been called: the last of them completes the pass, and any after it would begin another.
            (0..self.of).filter(|band| called >> band & 1 == 0).for_each(|band| {
                let _ = self.pass(band);
            });
        }
    }
}

impl Plan {
    /// Plans the pass that follows `last`, or the first one. Blocks end at step `until` at the latest.
    fn of(system: &mut System<'_>, scratch: *mut f64, last: Option<&Plan>, of: u32, until: u64) -> Plan {
        let second_half = last.is_some_and(|last| last.end < 1.0);
        let end = if system.state.halved && !second_half { 0.5 } else { 1.0 };
        let failed_before = match last {
            Some(last) if second_half => last.failed_before,
            _ => system.failed_segments,
        };
        let course = last.and_then(Plan::next_part);
        let course = course.or_else(|| Course::start(system, of as usize, until.saturating_sub(system.state.step)));
        let found = match &course {
            Some(course) => course.look_ahead(system),
            None => explicit::look_ahead(system, end, [0, system.layout.nodes_y]),
        };
        let mut rows = [system.layout.nodes_y, 0];
        let pushing = system.layout.has(Feature::Viscosity) && found.is_ok();
        for ply in 0..system.layout.plies {
            let [first, end] = system.rows_to_step(ply);
            if first == end {
                continue;
            }
            rows = [rows[0].min(first), rows[1].max(end)];
            explicit::place_images_above(system, end);
            if system.layout.has(Feature::Rate) && found.is_ok() {
                relaxation::find_rates(system, [first, end]);
            }
            if pushing {
                viscosity::place_images(system, [first, end]);
            }
        }
        rows[0] = rows[0].min(rows[1]);
        if let Some(course) = &course {
            rows = course.rows_near();
        }
        let marked = system.layout.has(Feature::Toe) && system.failed_segments > 0;
        let memory = Pointers::of(&raw const system.directions, &mut system.blocks, scratch);
        let track_support = system.scene.track_support;
        let all = system.steps_all();
        Plan {
            end,
            second_half,
            failed_before,
            found,
            rows,
            pushing,
            course,
            all,
            layout: system.layout,
            toe: system.model.toe,
            rates: explicit::rates(system),
            fetches: system.fetches,
            instructions: system.instructions,
            marked,
            track_support,
            memory,
        }
    }

    /// What follows of the block that the pass is part of; None behind its last part and outside blocks.
    fn next_part(&self) -> Option<Course> {
        self.course.and_then(Course::next)
    }

    /// The step of a block that the pass is, near the body.
    fn step_in_block(&self) -> Option<usize> {
        self.course.and_then(|course| course.step())
    }

    /// Rows [first, end) of a band.
    fn rows_of(&self, of: u32, band: u32) -> [usize; 2] {
        let [first, end] = self.rows;
        // At least 1, so that no division by zero has to be compiled in.
        let start = |band: u32| first + (end - first) * band as usize / of.max(1) as usize;
        [start(band), start(band + 1)]
    }

    /// Rows of a ply that are swept.
    ///
    /// # Safety
    /// Nothing changes the rows that are awake.
    unsafe fn rows_of_ply(&self, ply: usize) -> [usize; 2] {
        let layout = &self.layout;
        if !layout.is_stack() {
            return self.rows;
        }
        // SAFETY: there is an entry for each ply; the caller's promise.
        let awake = unsafe { self.memory.awake.add(ply).read() };
        system::rows_to_step(layout.rows_of(ply), awake.map(|row| row as usize), self.all)
    }

    /// What the segments have in common. A copy would add to the stack.
    fn directions(&self) -> &Directions {
        // SAFETY: those of the simulation, which is lent as long as there are bands; they change between plans only.
        unsafe { &*self.memory.directions }
    }

    /// Constants of the sweep.
    fn terms(&self, fetches: bool) -> Terms<'_> {
        let Plan { layout, toe, rates, instructions, .. } = self;
        Terms { layout, directions: self.directions(), toe: *toe, rates: *rates, fetches, instructions: *instructions }
    }

    /// Copies what a band needs of its neighbours' rows, before any row is swept.
    ///
    /// # Safety
    /// No band is being swept, and the simulation's blocks and the scratch are used by nothing else.
    #[inline(never)] // Its constants must not add to the stack of the plan.
    unsafe fn cut(&self, of: u32, band: u32) {
        let [first, end] = self.rows_of(of, band);
        if self.found.is_err() || first == end {
            return;
        }
        let (layout, memory, chunks) = (&self.layout, &self.memory, self.layout.chunks);
        // SAFETY: the rows lie inside the blocks; the caller has them and the scratch to itself.
        unsafe {
            let Scratch { above, carry, .. } = self.scratch(band);
            // The plies that the band's first row and the row above it belong to, and their rows.
            let [(lowest, low), (_, [_, top])] = [first, end - 1].map(|j| {
                let (ply, _) = layout.ply_and_row(j);
                (ply, self.rows_of_ply(ply))
            });
            if end < top {
                copy_displacements(above, rows(memory.hot, chunks, end, 1));
            }
            if first > low[0] && first < low[1] {
                self.lift(first, lowest, carry);
            } else if let Some(step) = self.step_in_block() {
                copy_row(carry, rows(memory.carries, chunks, step, 1));
            }
        }
    }

    /// The vertical forces on row j of a ply from the row below it.
    ///
    /// # Safety
    /// Nothing changes the two rows.
    #[inline(never)] // Its constants must not add to the stack of the plan.
    unsafe fn lift(&self, j: usize, ply: usize, carry: &mut [Chunk<CARRY_PLANES>]) {
        let (layout, memory, chunks) = (&self.layout, &self.memory, self.layout.chunks);
        // SAFETY: the rows lie inside the blocks; the caller's promise.
        unsafe {
            let yarn = if layout.has_constants() { rows(memory.yarn, chunks, j - 1, 1) } else { &[] };
            let strength = if layout.has(Feature::Strength) { rows(memory.strength, chunks, j - 1, 1) } else { &[] };
            let logarithms = if layout.has(Feature::Rate) { rows(memory.logarithms, chunks, j - 1, 1) } else { &[] };
            let below = rows(memory.hot, chunks, j - 1, 1);
            let history = rows(memory.history, chunks, j - 1, 1);
            let here = rows(memory.hot, chunks, j, 1);
            let marks = if self.marked { rows(memory.marks, chunks, j - 1, 1) } else { &[] };
            let terms = self.terms(false);
            let yarn = terms.yarn_row(yarn, strength, logarithms, 0, ply);
            terms.pass(&self.net(), ply).lift(j - 1, below, history, here, carry, &yarn, marks);
        }
    }

    /// Finds what viscosity changes of a band's rows; none is swept yet.
    ///
    /// # Safety
    /// No other call works on the same band, and nothing but calls for other bands uses the simulation and the scratch.
    #[inline(never)] // What it needs must not add to the stack of a sweep.
    unsafe fn push(&self, of: u32, band: u32) -> Report {
        let [first, end] = self.rows_of(of, band);
        if first == end {
            return Report::default();
        }
        let (layout, memory, chunks) = (&self.layout, &self.memory, self.layout.chunks);
        for ply in layout.ply_and_row(first).0..=layout.ply_and_row(end - 1).0 {
            // SAFETY: rows_of() cuts the rows without overlap and inside the blocks, so the pushes written here are this band's
            // alone; hot rows and marks are only read by all bands.
            unsafe {
                let [low, top] = self.rows_of_ply(ply);
                let (start, stop) = (first.max(low), end.min(top));
                if start >= stop {
                    continue;
                }
                let pushing = viscosity::Pushing {
                    layout,
                    directions: self.directions().of_ply(ply),
                    toe: &self.toe,
                    instructions: self.instructions,
                    all: [low, top],
                    own: [start, stop],
                    hot: rows(memory.hot, chunks, 0, layout.stored_rows()),
                    marks: if self.marked { rows(memory.marks, chunks, 0, layout.nodes_y) } else { &[] },
                    work: self.scratch(band).work,
                    pushes: rows_mut(memory.pushes, chunks, start, stop - start),
                };
                pushing.find();
            }
        }
        Report::default()
    }

    /// Sweeps a band's rows.
    ///
    /// # Safety
    /// No other call is sweeping the same band, and nothing but sweeps of other bands uses the simulation and the scratch.
    #[inline(never)] // Its constants must not add to the stack of the next plan.
    unsafe fn sweep(&self, of: u32, band: u32) -> Report {
        let [first, end] = self.rows_of(of, band);
        if self.found.is_err() || first == end {
            return Report::default();
        }
        let (layout, memory, chunks) = (&self.layout, &self.memory, self.layout.chunks);
        let (from, to) = (layout.ply_and_row(first).0, layout.ply_and_row(end - 1).0);
        let mut report = Report::default();
        for ply in from..=to {
            let [_, ply_end] = layout.rows_of(ply);
            // SAFETY: rows_of() cuts the rows without overlap and inside the blocks, so the parts taken for writing here are this
            // band's alone. Of a row that another band writes only the copy is read; the row above the last band is not swept.
            unsafe {
                let [low, top] = self.rows_of_ply(ply);
                let (start, stop) = (first.max(low), end.min(top));
                if start >= stop {
                    continue;
                }
                let count = stop - start;
                let Scratch { above, carry, kept, .. } = self.scratch(band);
                let above: &[_] = if stop < top {
                    above
                } else if let Some(step) = self.step_in_block().filter(|_| stop < ply_end) {
                    self.above_gap(Edge::Body, step)
                } else if stop == ply_end && layout.is_stack() {
                    &[]
                } else if stop < layout.stored_rows() {
                    rows(memory.hot, chunks, stop, 1)
                } else {
                    &[]
                };
                if start == low && self.course.is_none() {
                    carry.fill([[0.0; CHUNK]; CARRY_PLANES]);
                }
                let pulls = match self.step_in_block() {
                    Some(step) => memory.noted.add(step * layout.nodes_y),
                    None => self.pulls(of),
                };
                let mut rows = self.rows(start, count, ply, above, carry, kept);
                let fetches = self.fetches && self.step_in_block().is_none_or(|step| step == 0);
                report = report.merged(rows.sweep(&self.terms(fetches), |j, pulled| {
                    if self.track_support {
                        pulls.add(j).write(pulled.map(|pull| pull.into()));
                    }
                }));
            }
        }
        report
    }

    /// Takes all steps of a block that a band can take away from the body.
    ///
    /// # Safety
    /// No other call is at work on the same band, and nothing but calls for other bands uses the simulation and the scratch.
    #[inline(never)] // As above.
    unsafe fn step_away(&self, band: u32, course: &Course) -> Report {
        let mut report = Report::default();
        for piece in &course.pieces(band as usize) {
            for r in piece.numbers(course.steps()) {
                for step in 0..course.steps() {
                    if let Some(j) = piece.row(r, step) {
                        // SAFETY: the pieces of all bands and the gaps between them have no row in common. What is read of a gap's row
                        // is changed in later passes, and what is kept for a gap is of this piece alone.
                        report = report.merged(unsafe { self.step_row_away(band, course, piece, step, j) });
                    }
                }
            }
        }
        report
    }

    /// Takes a step of row j of a piece.
    ///
    /// # Safety
    /// As for [`Plan::step_away`], which is at this piece.
    unsafe fn step_row_away(&self, band: u32, course: &Course, piece: &Piece, step: usize, j: usize) -> Report {
        let hot = self.memory.hot;
        // SAFETY: the caller's promise.
        unsafe {
            let carry = self.below_gap(piece.upper, step);
            if j == 0 {
                carry.fill([[0.0; CHUNK]; CARRY_PLANES]);
            } else if piece.starts_at_gap(step, j) {
                self.lift(j, 0, carry);
                copy_displacements(self.above_gap(piece.lower, step), rows(hot, self.layout.chunks, j, 1));
            }
            self.step_row(band, course, step, j, self.row_above(j), carry)
        }
    }

    /// Takes a step of the gap between a band and the one below it.
    ///
    /// # Safety
    /// As for [`Plan::step_away`].
    #[inline(never)] // As above.
    unsafe fn fill_cut(&self, band: u32, course: &Course) -> Report {
        let [first, end] = course.rows_of_cut(band as usize);
        let (edge, mut report) = (Edge::Cut(band as usize), Report::default());
        let Some(step) = self.step_in_block().filter(|_| self.found.is_ok()) else { return report };
        for j in first..end {
            // SAFETY: the gaps have no row in common, with the body's neither.
            unsafe {
                let above = if j + 1 < end { self.row_above(j) } else { self.above_gap(edge, step) };
                report = report.merged(self.step_row(band, course, step, j, above, self.below_gap(edge, step)));
            }
        }
        report
    }

    /// Sweeps row j in a step of a block.
    ///
    /// # Safety
    /// Nothing else uses the row and what belongs to it, and nothing changes the row above.
    #[inline(never)] // As above.
    unsafe fn step_row(
        &self,
        band: u32,
        course: &Course,
        step: usize,
        j: usize,
        above: &[Chunk<HOT_PLANES>],
        carry: &mut [Chunk<CARRY_PLANES>],
    ) -> Report {
        let memory = &self.memory;
        // SAFETY: the caller's promise; there are pulls of every step and row.
        unsafe {
            let mut row = self.rows(j, 1, 0, above, carry, self.scratch(band).kept);
            // A row comes from memory in the first step alone.
            let mut report = row.sweep(&self.terms(self.fetches && step == 0), |j, pulled| {
                if self.track_support {
                    memory.noted.add(step * self.layout.nodes_y + j).write(pulled.map(|pull| pull.into()));
                }
            });
            report.non_finite |= course.is_met(step, j, memory.ranges.add(j).read());
            report
        }
    }

    /// The row above row j, none above the top row.
    ///
    /// # Safety
    /// Nothing changes it while it is held.
    unsafe fn row_above<'r>(&self, j: usize) -> &'r [Chunk<HOT_PLANES>] {
        // SAFETY: the caller's promise.
        unsafe {
            if j + 1 < self.layout.stored_rows() { rows(self.memory.hot, self.layout.chunks, j + 1, 1) } else { &[] }
        }
    }

    /// Where the displacements of the row above a gap are kept of a step of a block.
    ///
    /// # Safety
    /// Nothing else uses them while they are held.
    #[allow(clippy::mut_from_ref)] // It lies in the scratch.
    unsafe fn above_gap<'r>(&self, edge: Edge, step: usize) -> &'r mut [Chunk<HOT_PLANES>] {
        let [.., aboves, _] = self.places(if let Edge::Cut(band) = edge { band as u32 } else { 0 });
        // SAFETY: the caller's promise.
        unsafe { rows_mut(aboves.cast(), self.layout.chunks, step, 1) }
    }

    /// Where the vertical forces of a step of a block are that a piece carries to its upper edge.
    ///
    /// # Safety
    /// As for [`Plan::above_gap`].
    #[allow(clippy::mut_from_ref)] // As above.
    unsafe fn below_gap<'r>(&self, edge: Edge, step: usize) -> &'r mut [Chunk<CARRY_PLANES>] {
        let carries = match edge {
            Edge::Body => self.memory.carries,
            Edge::Cut(band) => self.places(band as u32)[5].cast(),
            Edge::Sheet => self.places(0)[5].cast(),
        };
        // SAFETY: the caller's promise.
        unsafe { rows_mut(carries, self.layout.chunks, step, 1) }
    }

    /// `count` rows of a ply from row `first` on, with all that belongs to them.
    ///
    /// # Safety
    /// They lie inside the blocks, and nothing else uses them while they are held.
    unsafe fn rows<'r>(
        &self,
        first: usize,
        count: usize,
        ply: usize,
        above: &'r [Chunk<HOT_PLANES>],
        carry: &'r mut [Chunk<CARRY_PLANES>],
        kept: &'r mut [[f64; 3]],
    ) -> Rows<'r> {
        let (layout, memory, chunks) = (&self.layout, &self.memory, self.layout.chunks);
        // SAFETY: the caller's promise.
        unsafe {
            Rows {
                first,
                ply,
                hot: rows_mut(memory.hot, chunks, first, count),
                above,
                history: rows_mut(memory.history, chunks, first, count),
                yarn: if layout.has_constants() { rows(memory.yarn, chunks, first, count) } else { &[] },
                strength: if layout.has(Feature::Strength) { rows(memory.strength, chunks, first, count) } else { &[] },
                logarithms: if layout.has(Feature::Rate) { rows(memory.logarithms, chunks, first, count) } else { &[] },
                marks: if self.marked { rows(memory.marks, chunks, first, count) } else { &[] },
                pushes: if layout.has(Feature::Viscosity) { rows(memory.pushes, chunks, first, count) } else { &[] },
                taken: if layout.takes_energy() { rows_mut(memory.taken, 1, first, count) } else { &mut [] },
                before: if layout.is_stack() { rows_mut(memory.before, chunks, first, count) } else { &mut [] },
                ranges: rows_mut(memory.ranges, 1, first, count),
                runs: rows(memory.runs, 1, first, count),
                net: self.net(),
                carry,
                kept,
            }
        }
    }

    /// The part of a pass that is not cut.
    ///
    /// # Safety
    /// All bands have been swept; the simulation's blocks and the scratch are used by nothing else.
    unsafe fn close(&self, system: &mut System<'_>, of: u32, report: Report) -> Result<(), Failure> {
        let gathered = self.found?;
        if let Some(course) = &self.course {
            return course.close(system, &gathered, report);
        }
        for ply in 0..system.layout.plies {
            // SAFETY: no band is being swept.
            let [first, end] = unsafe { self.rows_of_ply(ply) };
            if first == end {
                continue;
            }
            system.set_awake(ply, [first, end]);
            explicit::book_taken(system, ply, [first, end]);
            if !self.track_support {
                continue;
            }
            let ([bottom, _], share) = (system.layout.rows_of(ply), system.mass_share(ply));
            for j in first..end {
                // SAFETY: the sweep of row j has written its pulls.
                let pulls = unsafe { self.pulls(of).add(j).read() };
                let pulls = pulls.map(Vector::from);
                explicit::book_pulls(&mut system.state.sums, &system.scene, &self.layout, j - bottom, &pulls, share);
            }
        }
        explicit::close_pass(system, self.end, &gathered, report)?;
        if self.end == 1.0 {
            explicit::end_step(system, self.failed_before)?;
        }
        Ok(())
    }

    /// Bars and widths of a graded network.
    ///
    /// # Safety
    /// The simulation's blocks are there.
    unsafe fn net<'r>(&self) -> Net<'r> {
        let layout = &self.layout;
        if !layout.has(Feature::Grading) {
            return Net { columns: &[], lines: &[] };
        }
        // SAFETY: they are as long, and nothing changes them.
        unsafe {
            Net {
                columns: rows(self.memory.columns, 1, 0, layout.chunks),
                lines: rows(self.memory.lines, 1, 0, layout.nodes_y.div_ceil(CHUNK)),
            }
        }
    }

    /// A band's own numbers.
    ///
    /// # Safety
    /// Nothing else uses them while they are held.
    unsafe fn scratch<'r>(&self, band: u32) -> Scratch<'r> {
        let chunks = self.layout.chunks;
        let worked = if self.layout.has(Feature::Viscosity) { chunks } else { 0 };
        let [above, carry, work, kept, ..] = self.places(band);
        // SAFETY: Bands::of has found room for as many bands, one behind the other; the caller's promise.
        unsafe {
            Scratch {
                above: from_raw_parts_mut(above.cast(), chunks),
                carry: from_raw_parts_mut(carry.cast(), chunks),
                work: from_raw_parts_mut(work.cast(), worked),
                kept: from_raw_parts_mut(kept.cast(), self.layout.nodes_x),
            }
        }
    }

    /// Where a band's own numbers are: those of [`Scratch`] in their order; then, of each step of a block, the row above the gap below the
    /// band, and the forces carried from below to that gap. The first band has no gap below it: its row above is that of the body's gap, its
    /// forces are those of the piece that reaches the top of the sheet.
    #[inline(never)] // As above.
    fn places(&self, band: u32) -> [*mut f64; 6] {
        let layout = &self.layout;
        let row = layout.chunks * CHUNK;
        let steps = if layout.in_waves { BLOCK_STEPS } else { 0 };
        let above = self.memory.scratch.wrapping_add(band as usize * layout.reals_of_a_band());
        let carry = above.wrapping_add(HOT_PLANES * row);
        let work = carry.wrapping_add(CARRY_PLANES * row);
        let aboves = work.wrapping_add(if layout.has(Feature::Viscosity) { VISCOUS_PLANES * row } else { 0 });
        let carries = aboves.wrapping_add(steps * HOT_PLANES * row);
        [above, carry, work, carries.wrapping_add(steps * CARRY_PLANES * row), aboves, carries]
    }

    /// Where the pulls of row 0's two runs are, behind the bands' own numbers.
    fn pulls(&self, of: u32) -> *mut [[f64; 3]; 2] {
        self.memory.scratch.wrapping_add(of as usize * self.layout.reals_of_a_band()).cast()
    }
}

/// `count` rows of `width` items each, from row `first` on.
///
/// # Safety
/// They lie inside what `start` points to, and nothing changes them while they are held.
unsafe fn rows<'r, T>(start: *const T, width: usize, first: usize, count: usize) -> &'r [T] {
    // SAFETY: the caller's promise.
    unsafe { from_raw_parts(start.add(first * width), count * width) }
}

/// `count` rows of `width` items each, from row `first` on, to be changed.
///
/// # Safety
/// They lie inside what `start` points to, and nothing else uses them while they are held.
unsafe fn rows_mut<'r, T>(start: *mut T, width: usize, first: usize, count: usize) -> &'r mut [T] {
    // SAFETY: the caller's promise.
    unsafe { from_raw_parts_mut(start.add(first * width), count * width) }
}

/// Copies a row of chunks.
fn copy_row<const P: usize>(copy: &mut [Chunk<P>], row: &[Chunk<P>]) {
    copy.iter_mut().zip(row).for_each(|(copy, chunk)| *copy = *chunk);
}

/// Copies the displacements of a row, which are all that is read of a row above.
#[inline(never)] // It must not add to the stack of a sweep.
fn copy_displacements(copy: &mut [Chunk<HOT_PLANES>], row: &[Chunk<HOT_PLANES>]) {
    for (copy, chunk) in copy.iter_mut().zip(row) {
        copy.iter_mut().zip(chunk).take(3).for_each(|(copy, plane)| *copy = *plane);
    }
}
