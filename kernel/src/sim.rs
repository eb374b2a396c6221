//! The simulation: one step function over three blocks of caller memory (model, state, scratch), and its read-outs.
//!
//! Read-outs are pure: they commit nothing, so asking for them changes no bit. After a failure every call but reset, load, the
//! counters, the outcomes (whose status then says "faulted") and the digest repeats it.

use crate::blocks::Blocks;
use crate::contact::Search;
use crate::energy::SegmentView;
use crate::error::{Code, Error, Failure};
use crate::lanes::InstructionSet;
use crate::layout::{self, Layout};
use crate::math;
use crate::model::{Model, start_body, start_motion};
use crate::outcome::{FirstContact, Latch, Outcome};
use crate::path::{self, Path, Track};
use crate::pose::Vector;
use crate::projectile::{Body, Motion};
use crate::scene::{AttachmentKind, Drive, Scene, StepLimits};
use crate::state::{COUNT_MAX, State};
use crate::sweep::Axis;
use crate::yarn::squared_stretch_excess;
use core::mem::MaybeUninit;

/// Largest stretch that a segment may be given beforehand; its square is far from overflow.
pub(crate) const LARGEST_STRETCH: f64 = 1e100;
/// Largest displacement, in spacings, and velocity, in spacings a step, that a sheet may be given: its energy is a number then. The
/// first step may find it lost (see [`crate::sweep::LOST`]).
const LARGEST_GIVEN_MOTION: f64 = 1e30;

/// The caller's memory: lengths from [`Layout::reals`] and [`Layout::words`]; longer is fine, content does not matter.
pub struct Memory<'a> {
    /// Numbers.
    pub reals: &'a mut [f64],
    /// Integers.
    pub words: &'a mut [u32],
}

impl Memory<'_> {
    /// Refuses memory that is too short for a scene of these sizes.
    fn check(&self, layout: &Layout) -> Result<(), Error> {
        for (field, have, need) in
            [("memory.reals", self.reals.len(), layout.reals()), ("memory.words", self.words.len(), layout.words())]
        {
            if have < need {
                return Err(Error::new(Code::ShortBuffer, field, have as f64, need as f64));
            }
        }
        Ok(())
    }
}

/// Contact sums (M8) since the start or reset, host's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Contact {
    /// Impulse on the projectile, N s. A mean force is a difference of two divided by the time between.
    pub impulse: [f64; 3],
    /// Angular impulse on the projectile about its moving centre of mass, N m s.
    pub angular_impulse: [f64; 3],
    /// Work of the projectile on the fabric = energy absorbed, J.
    pub work: f64,
    /// Kinetic energy lost in impacts of nodes, part of the work, J.
    pub loss: f64,
    /// Largest mean force over a window of `force_window`, N; until the first window is full the mean force over the time elapsed.
    pub force_peak: f64,
}

/// Impulses of the sheet and of a free projectile on the supports since the start or reset, N s, host's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Support {
    /// All together.
    pub total: [f64; 3],
    /// Sides: left (-x), right, bottom (-y), top. Corners: (-,-), (+,-), (-,+), (+,+).
    pub attachments: [[f64; 3]; 4],
}

/// Extremes of the fabric at the present time.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Fabric {
    /// Largest distance from the sheet's plane of a node that live segments join to a support, m; 0 once all of the sheet has torn
    /// off. Of all nodes if the sheet is free, or if segments have failed and `track_detachment` is off.
    pub max_deflection: f64,
    /// Largest stretch (M1) of a live segment; yarns of the presets fail at about 1.05.
    pub max_stretch: f64,
}

/// Counters and high-water marks. Available even after a failure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Counters {
    /// Steps taken since the start or reset.
    pub steps: u64,
    /// Segments with alpha = 0 (M5) in the forces of the last step.
    pub failed_segments: u64,
    /// Nodes with a contact impulse in the last step.
    pub contacts: u64,
    /// Contact solves (M8) that ran out of sweeps; harmless below 1 % of the steps.
    pub unconverged: u64,
    /// Most Gauss-Seidel sweeps of one solve, at most 200, or 4000 where a fixed node takes an impulse.
    pub most_sweeps: u64,
    /// Most candidate nodes of one step.
    pub most_candidates: u64,
    /// Places for candidate nodes: `contact_capacity`, or every node modelled.
    pub candidate_capacity: u64,
    /// Deepest penetration met, m: rounding in a sound run; also that of fixed nodes in a prescribed body, which passes through them.
    pub worst_penetration: f64,
    /// Iterations of the theta rule so far = passes over the yarns' forces; 0 with velocity Verlet.
    pub iterations: u64,
    /// Most iterations of one step.
    pub most_iterations: u64,
}

/// What a host sees first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Status {
    /// No contact in the last step and no outcome yet.
    Flight = 0,
    /// Contact in the last step.
    Contact = 1,
    /// See [`Outcome::Arrested`].
    Arrested = 2,
    /// See [`Outcome::Detached`].
    Detached = 3,
    /// See [`Outcome::Exited`].
    Exited = 4,
    /// See [`Outcome::Passed`].
    Passed = 5,
    /// A failure is latched.
    Faulted = 6,
}

/// Outcomes latched so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcomes {
    /// The latest outcome, or contact or flight.
    pub status: Status,
    /// Bits of all latched outcomes ([`Outcome::bit`]).
    pub mask: u32,
    /// First contact: step count at whose start the first impulse acted; None before.
    pub first_contact: Option<u64>,
    /// Step and work of each latched outcome, by [`Outcome`] number.
    pub latched: [Option<Latch>; 4],
}

/// A simulation on the caller's memory.
pub struct Sim<'a> {
    pub(crate) scene: Scene,
    pub(crate) layout: Layout,
    pub(crate) model: Model,
    pub(crate) state: State,
    pub(crate) blocks: Blocks<'a>,
    pub(crate) failed_segments: u64,
    pub(crate) failure: Option<Failure>,
    /// Rows [first, end) that may hold a node that is not exactly at rest in its place.
    pub(crate) awake: [usize; 2],
    pub(crate) skip_rest: bool,
    pub(crate) instructions: InstructionSet,
}

impl<'a> Sim<'a> {
    /// A simulation of `scene` at step 0: sheet flat and at rest, projectile in its start motion.
    ///
    /// # Errors
    /// Everything [`Scene::check`] and [`Scene::step_limits`] refuse, too little memory, a projectile too fast for the step,
    /// too heavy for its energy to be a number, or overlapping a node. Memory is not written then.
    pub fn new(scene: &Scene, memory: Memory<'a>) -> Result<Sim<'a>, Error> {
        let mut sim = Sim::NOTHING;
        Sim::make(scene, memory, || &mut sim)?;
        Ok(sim)
    }

    /// [`Sim::new`] in a given place, without a copy of the simulation on the stack: that would be some four kilobytes.
    ///
    /// # Errors
    /// As for [`Sim::new`]. The place is not written then.
    pub fn new_in<'p>(
        place: &'p mut MaybeUninit<Sim<'a>>,
        scene: &Scene,
        memory: Memory<'a>,
    ) -> Result<&'p mut Sim<'a>, Error> {
        Sim::make(scene, memory, || place.write(Sim::NOTHING))
    }

    /// What is in a place before a simulation is made there.
    const NOTHING: Sim<'a> = Sim {
        scene: Scene::sheet_3in_sphere(),
        layout: Layout::NOTHING,
        model: Model::NOTHING,
        state: State::at_start(Body::AT_REST),
        blocks: Blocks::nothing(),
        failed_segments: 0,
        failure: None,
        awake: [0, 0],
        skip_rest: true,
        instructions: InstructionSet::Scalar,
    };

    /// Checks everything, then makes the simulation in the place that `place` gives, where [`Sim::NOTHING`] is.
    fn make<'p>(
        scene: &Scene,
        memory: Memory<'a>,
        place: impl FnOnce() -> &'p mut Sim<'a>,
    ) -> Result<&'p mut Sim<'a>, Error>
    where
        'a: 'p,
    {
        let layout = Layout::of(scene)?;
        // Before the step limit, which draws every segment: a sheet that fits no memory is refused at once.
        memory.check(&layout)?;
        let limits = scene.step_limits()?;
        let body = start_body(scene, limits)?;
        let sim = place();
        sim.scene = *scene;
        sim.layout = layout;
        sim.model.take(scene, limits);
        sim.state = State::at_start(body);
        sim.instructions = InstructionSet::widest();
        sim.fill(memory)?;
        Ok(sim)
    }

    /// Takes the memory, which has been found to be enough, and fills it.
    #[inline(never)] // The blocks must not add to the stack of the checks.
    fn fill(&mut self, memory: Memory<'a>) -> Result<(), Error> {
        self.blocks = Blocks::carve(memory, &self.layout)?;
        self.fill_model()?;
        self.clear_state();
        self.start_audit();
        Ok(())
    }

    /// Back to step 0 as after [`Sim::new`]. Clears a failure, motion and history set by hand, and the external load.
    pub fn reset(&mut self) {
        let motion = path::into_sheet(&self.model.pose, &start_motion(&self.scene));
        let mut body = Body::of(&motion);
        // Accepted once, so accepted again.
        let _ = self.scene.symmetry.settle(&self.model.solid, &mut body, self.scene.sheet.spacing);
        self.state = State::at_start(body);
        self.take_halves(false);
        self.clear_state();
        self.start_audit();
    }

    /// One step. After a failure: the same failure again.
    pub fn step(&mut self) -> Result<(), Failure> {
        self.sound()?;
        match self.step_once() {
            Ok(()) => Ok(()),
            Err(failure) => {
                self.failure = Some(failure);
                Err(failure)
            }
        }
    }

    /// `steps` steps. Stops at the first failure.
    pub fn advance(&mut self, steps: u64) -> Result<(), Failure> {
        self.sound()?;
        for _ in 0..steps {
            self.step()?;
        }
        Ok(())
    }

    /// Up to `steps` steps, ending after the step at which any outcome of `mask` is latched (at once if it already is).
    /// Returns the steps taken.
    pub fn advance_until(&mut self, mask: u32, steps: u64) -> Result<u64, Failure> {
        self.sound()?;
        for taken in 0..steps {
            if self.state.watch.mask() & mask != 0 {
                return Ok(taken);
            }
            self.step()?;
        }
        Ok(steps)
    }

    /// Moves a prescribed body along `path` for `steps` steps. Call again with the same path to go on along it: the bits do
    /// not depend on how the path is split.
    ///
    /// # Errors
    /// The body is not prescribed; the path starts elsewhere in time, is shorter than asked for, not finite, or too fast.
    pub fn follow(&mut self, path: &Path, steps: u64) -> Result<(), Error> {
        self.take_path(path, steps)?;
        Ok(self.advance(steps)?)
    }

    /// Starts a path, or goes on along it, for `steps` steps to come.
    #[inline(never)] // It must not add to the stack of the steps.
    fn take_path(&mut self, path: &Path, steps: u64) -> Result<(), Error> {
        self.sound()?;
        if self.scene.drive != Drive::Prescribed {
            return Err(Error::plain(Code::WrongDrive, "drive"));
        }
        let step = self.state.step;
        let bad = |field, value: u64, limit: u64| Error::new(Code::BadPath, field, value as f64, limit as f64);
        let Some(last) = path.first.checked_add(path.steps).filter(|&last| path.steps > 0 && last <= COUNT_MAX) else {
            return Err(bad("path.steps", path.steps, 1));
        };
        let end = self.body_of_path(path)?;
        let track = &self.state.track;
        let continued = track.steps == path.steps && track.first == path.first && track.end == end && step < last;
        if !continued && path.first != step {
            return Err(bad("path.first", path.first, step));
        }
        if steps > last - step {
            return Err(bad("steps", steps, last - step));
        }
        if !continued {
            let track = Track { first: path.first, steps: path.steps, start: self.path_start(), end };
            self.model.check_track(&track)?;
            self.state.track = track;
        }
        Ok(())
    }

    /// The body as a path starts from it: with the rates the path before ended with, if one ended just here.
    fn path_start(&self) -> Body {
        let (body, track) = (self.state.body, &self.state.track);
        if track.steps > 0 && track.first + track.steps == self.state.step {
            Body { velocity: track.end.velocity, angular_velocity: track.end.angular_velocity, ..body }
        } else {
            body
        }
    }

    fn body_of_path(&self, path: &Path) -> Result<Body, Error> {
        use crate::error::{finite3, unit_quaternion};
        finite3("path.position", path.end.position)?;
        finite3("path.velocity", path.end.velocity)?;
        unit_quaternion("path.orientation", path.end.orientation)?;
        finite3("path.angular_velocity", path.end.angular_velocity)?;
        Ok(Body::of(&path::into_sheet(&self.model.pose, &path.end)))
    }

    /// Sets the force, N, and torque, N m, that act on a free body from now on, host's axes (gravity, drag, a host).
    pub fn set_external_load(&mut self, force: [f64; 3], torque: [f64; 3]) -> Result<(), Error> {
        self.sound()?;
        crate::error::finite3("external.force", force)?;
        crate::error::finite3("external.torque", torque)?;
        if self.scene.drive != Drive::Free {
            return Err(Error::plain(Code::WrongDrive, "drive"));
        }
        let force = Vector::from(self.model.pose.vector_in(force));
        let torque = Vector::from(self.model.pose.vector_in(torque));
        // What is a number in the host's axes may be none in the sheet's.
        crate::error::finite3("external.force", force.into())?;
        crate::error::finite3("external.torque", torque.into())?;
        self.scene.symmetry.check_load(&force, &torque)?;
        self.state.force = force.component_mul(&self.scene.symmetry.force_mask());
        self.state.torque = torque.component_mul(&self.scene.symmetry.torque_mask());
        Ok(())
    }

    /// Starts from given positions, m, and velocities, m/s, at t_0 (3 per node, node by node, host's frame): restart from
    /// another code, pre-stretched sheets. Fixed nodes stay where this puts them; their velocity must be 0.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite or beyond 1e30 spacings (a step), a moving fixed node, a node inside the
    /// projectile (a fixed one in a prescribed body may be), or a step already taken.
    pub fn set_motion(&mut self, positions: &[f64], velocities: &[f64]) -> Result<(), Error> {
        self.sound()?;
        self.refuse_if_started()?;
        for (field, values) in [("positions", positions), ("velocities", velocities)] {
            if values.len() != 3 * self.layout.nodes() {
                let wanted = 3.0 * self.layout.nodes() as f64;
                return Err(Error::new(Code::WrongLength, field, values.len() as f64, wanted));
            }
            values.iter().try_for_each(|&x| crate::error::finite(field, x))?;
        }
        let (points, _) = positions.as_chunks::<3>();
        let (speeds, _) = velocities.as_chunks::<3>();
        // At least 1, so that no division by zero has to be compiled in.
        let nx = self.layout.nodes_x.max(1);
        let search = Search::new(&self.model.solid, &self.state.body, self.scene.sheet.spacing, self.instructions);
        for (k, (point, velocity)) in points.iter().zip(speeds).enumerate() {
            let fixed = self.is_fixed(k % nx, k / nx);
            if fixed && *velocity != [0.0; 3] {
                return Err(Error::new(Code::OutOfRange, "velocities", k as f64, 0.0));
            }
            let x = Vector::from(self.model.pose.point_in(*point));
            let meets = !fixed || self.scene.drive == Drive::Free;
            if meets && search.candidate(&x).is_some_and(|(gap, _, _)| self.model.overlaps(gap)) {
                return Err(Error::new(Code::InitialOverlap, "positions", k as f64, 0.0));
            }
            let v = Vector::from(self.model.pose.vector_in(*velocity));
            let units = [("positions", x, self.scene.sheet.spacing), ("velocities", v, self.model.unit_speed)];
            for (field, vector, unit) in units {
                let limit = LARGEST_GIVEN_MOTION * unit;
                if !vector.iter().all(|component| (-limit..=limit).contains(component)) {
                    return Err(Error::new(Code::OutOfRange, field, k as f64, limit));
                }
            }
            if self.leaves_plane(k % nx, k / nx, &x, &v) {
                return Err(Error::new(Code::NotSymmetric, "positions", k as f64, 0.0));
            }
        }
        let h = self.scene.sheet.spacing;
        for (k, (point, velocity)) in points.iter().zip(speeds).enumerate() {
            let (i, j) = (k % nx, k / nx);
            let x = self.model.pose.point_in(*point);
            let v = self.model.pose.vector_in(*velocity);
            let rest = self.rest(i, j);
            let mut u = [x[0] / h - rest[0], x[1] / h - rest[1], x[2] / h];
            let mut v = v.map(|v| v / self.model.unit_speed);
            for (axis, on_plane) in self.on_planes(i, j).into_iter().enumerate() {
                if on_plane {
                    (u[axis], v[axis]) = (0.0, 0.0);
                }
            }
            self.set_node(i, j, u, v);
        }
        self.rebuild_derived();
        // The explicit scheme stores the velocity at t_{-1/2}: back by half a kick with the forces at t_0.
        if !self.layout.implicit {
            for (i, j) in (0..self.layout.nodes()).map(|k| (k % nx, k / nx)) {
                if !self.is_fixed(i, j) {
                    let (u, v) = self.node(i, j);
                    let a = self.acceleration(i, j);
                    self.set_node(i, j, u, [v[0] - 0.5 * a[0], v[1] - 0.5 * a[1], v[2] - 0.5 * a[2]]);
                }
            }
        }
        self.start_audit();
        Ok(())
    }

    /// Gives every segment the largest stretch it has ever had (1 or less: undamaged), in the order of the segments'
    /// numbers: a pre-damaged sheet. Call before [`Sim::set_motion`] if both are used.
    pub fn set_largest_stretch(&mut self, stretches: &[f64]) -> Result<(), Error> {
        self.sound()?;
        self.refuse_if_started()?;
        if stretches.len() != self.layout.segments() {
            let wanted = self.layout.segments() as f64;
            return Err(Error::new(Code::WrongLength, "stretches", stretches.len() as f64, wanted));
        }
        stretches.iter().try_for_each(|&x| crate::error::finite("stretches", x))?;
        if let Some(&below) = stretches.iter().find(|&&x| x < 0.0) {
            return Err(Error::new(Code::OutOfRange, "stretches", below, 0.0));
        }
        if let Some(&above) = stretches.iter().find(|&&x| x > LARGEST_STRETCH) {
            return Err(Error::new(Code::OutOfRange, "stretches", above, LARGEST_STRETCH));
        }
        let mut stretches = stretches.iter();
        let (nx, ny, chunks) = (self.layout.nodes_x, self.layout.nodes_y, self.layout.chunks);
        let critical = self.model.critical;
        let (across, up) = (self.layout.x.segments(), self.layout.y.segments());
        for (axis, columns, rows) in [(0, across, ny), (1, nx, up)] {
            for j in 0..rows {
                let history = layout::row_mut(self.blocks.history, chunks, j);
                for i in 0..columns {
                    let excess = squared_stretch_excess(stretches.next().copied().unwrap_or(0.0));
                    if let Some(slot) = layout::get_mut(history, axis, i) {
                        *slot = if excess > critical { excess } else { 0.0 };
                    }
                }
            }
        }
        self.rebuild_derived();
        self.start_audit();
        Ok(())
    }

    /// Steps every row, also those still exactly at rest; the bits are the same. For measuring what skipping saves.
    pub fn step_every_row(&mut self) {
        self.skip_rest = false;
    }

    /// Uses another instruction set than the widest this machine has; the bits are the same. One that it lacks is refused.
    pub fn use_instructions(&mut self, set: InstructionSet) -> Result<(), Error> {
        if !set.available() {
            return Err(Error::plain(Code::UnknownChoice, "instruction_set"));
        }
        self.instructions = set;
        Ok(())
    }

    /// The instruction set in use.
    pub fn instructions(&self) -> InstructionSet {
        self.instructions
    }

    /// The scene this simulation was made with.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Sizes.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Steps taken.
    pub fn step_count(&self) -> u64 {
        self.state.step
    }

    /// Time, s: step count times dt.
    pub fn time(&self) -> f64 {
        self.state.step as f64 * self.model.limits.dt
    }

    /// The time step and its limits.
    pub fn step_limits(&self) -> StepLimits {
        self.model.limits
    }

    /// The latched failure, if any.
    pub fn failure(&self) -> Option<Failure> {
        self.failure
    }

    /// The projectile, host's frame: pose at t_n, rates at t_{n-1/2} (constant between impulses; on a path the means over the
    /// last step; with the theta rule the rates at t_n).
    pub fn projectile(&self) -> Result<Motion, Failure> {
        self.sound()?;
        Ok(path::out_of_sheet(&self.model.pose, &self.state.body.motion()))
    }

    /// Contact sums.
    pub fn contact(&self) -> Result<Contact, Failure> {
        self.sound()?;
        let (sums, steps) = (&self.state.sums, self.state.step);
        // No window has been closed before the first is full: a run shorter than that still has its mean force.
        let force_peak = if steps > 0 && steps < self.model.window_steps {
            math::length(sums.window.into()) / (steps as f64 * self.model.limits.dt)
        } else {
            sums.force_peak
        };
        Ok(Contact {
            impulse: self.model.pose.vector_out(sums.impulse.into()),
            angular_impulse: self.model.pose.vector_out(sums.angular_impulse.into()),
            work: sums.work,
            loss: sums.loss,
            force_peak,
        })
    }

    /// Impulses on the supports; zero without `track_support`.
    pub fn support(&self) -> Result<Support, Failure> {
        self.sound()?;
        let mut total = Vector::zeros();
        let attachments = self.state.sums.support.map(|support| {
            let impulse = support * self.model.unit_impulse;
            total += impulse;
            self.model.pose.vector_out(impulse.into())
        });
        Ok(Support { total: self.model.pose.vector_out(total.into()), attachments })
    }

    /// Deflection and stretch, with a full pass over the sheet. Changes nothing but scratch.
    pub fn fabric(&mut self) -> Result<Fabric, Failure> {
        self.sound()?;
        // Of a free sheet every node counts.
        let pieces = if self.scene.attachment.kind == AttachmentKind::Free { None } else { Some(self.pieces()) };
        let (mut deflection, mut excess) = (0.0, 0.0);
        for j in 0..self.layout.nodes_y {
            for i in 0..self.layout.nodes_x {
                let (u, _) = self.node(i, j);
                let z = if u[2] < 0.0 { -u[2] } else { u[2] };
                let held = pieces.as_ref().is_none_or(|pieces| pieces.hold(self.piece(pieces, i, j)));
                deflection = if held && z > deflection { z } else { deflection };
                for axis in [Axis::Horizontal, Axis::Vertical] {
                    if let Some(segment) = self.segment(axis, i, j)
                        && segment.stiffness > 0.0
                    {
                        let q = segment.excess_now();
                        excess = if q > excess { q } else { excess };
                    }
                }
            }
        }
        Ok(Fabric { max_deflection: deflection * self.scene.sheet.spacing, max_stretch: math::sqrt(1.0 + excess) })
    }

    /// Counters; also after a failure.
    pub fn counters(&self) -> Counters {
        let sums = &self.state.sums;
        Counters {
            steps: self.state.step,
            failed_segments: self.failed_segments,
            contacts: sums.contacts,
            unconverged: sums.unconverged,
            most_sweeps: sums.most_sweeps,
            most_candidates: sums.most_candidates,
            candidate_capacity: self.layout.candidates as u64,
            worst_penetration: sums.worst_penetration,
            iterations: sums.iterations,
            most_iterations: sums.most_iterations,
        }
    }

    /// Outcomes latched so far.
    pub fn outcomes(&self) -> Outcomes {
        let watch = &self.state.watch;
        // The latest latch wins; of several in one test, the one with the highest number.
        let mut latest: Option<(Outcome, u64)> = None;
        for (outcome, latch) in Outcome::ALL.iter().zip(&watch.latched) {
            if let Some(latch) = latch
                && latest.is_none_or(|(_, step)| latch.step >= step)
            {
                latest = Some((*outcome, latch.step));
            }
        }
        let status = match (self.failure, latest) {
            (Some(_), _) => Status::Faulted,
            (None, Some((Outcome::Arrested, _))) => Status::Arrested,
            (None, Some((Outcome::Detached, _))) => Status::Detached,
            (None, Some((Outcome::Exited, _))) => Status::Exited,
            (None, Some((Outcome::Passed, _))) => Status::Passed,
            (None, None) if self.state.sums.contacts > 0 => Status::Contact,
            (None, None) => Status::Flight,
        };
        Outcomes {
            status,
            mask: watch.mask(),
            first_contact: watch.first.map(|first: FirstContact| first.step),
            latched: watch.latched,
        }
    }

    /// Positions at t_n, m, 3 per node modelled, node by node (rows along x first), host's frame.
    pub fn copy_positions(&self, out: &mut [f64]) -> Result<(), Error> {
        self.sound()?;
        self.copy_nodes("out", out, |sim, i, j| sim.model.pose.point_out(sim.position(i, j).into()))
    }

    /// Velocities at t_n, m/s, 3 per node modelled, host's axes: the stored half-step velocities and half a kick, or those
    /// that the theta rule stores.
    pub fn copy_velocities(&self, out: &mut [f64]) -> Result<(), Error> {
        self.sound()?;
        self.copy_nodes("out", out, |sim, i, j| {
            let (_, v) = sim.node(i, j);
            let stored = sim.layout.implicit || sim.is_fixed(i, j);
            let a = if stored { [0.0; 3] } else { sim.acceleration(i, j) };
            let unit = sim.model.unit_speed;
            let v = [(v[0] + 0.5 * a[0]) * unit, (v[1] + 0.5 * a[1]) * unit, (v[2] + 0.5 * a[2]) * unit];
            sim.model.pose.vector_out(v)
        })
    }

    /// alpha at t_n of every segment in the order of their numbers: 1 whole, 0 failed.
    pub fn copy_damage(&self, out: &mut [f64]) -> Result<(), Error> {
        self.sound()?;
        self.copy_segments(out, |sim, segment| {
            let q = segment.excess_now();
            let largest = if q > segment.history { q } else { segment.history };
            sim.model.law.alpha(segment.damage_rate, largest)
        })
    }

    /// Stretch at t_n of every segment in the order of their numbers.
    pub fn copy_stretch(&self, out: &mut [f64]) -> Result<(), Error> {
        self.sound()?;
        self.copy_segments(out, |_, segment| {
            let u2 = 1.0 + segment.excess_now();
            math::sqrt(if u2 > 0.0 { u2 } else { 0.0 })
        })
    }

    /// Whether a node lies on the mirror planes x = 0 and y = 0.
    fn on_planes(&self, i: usize, j: usize) -> [bool; 2] {
        [(self.layout.x, i), (self.layout.y, j)].map(|(line, i)| line.mirrored && line.node_weight(i) == 1.0)
    }

    /// Whether a position, m, or velocity, m/s, takes a node off a mirror plane, beyond rounding.
    fn leaves_plane(&self, i: usize, j: usize, x: &Vector, v: &Vector) -> bool {
        let small = |value: f64, scale: f64| value <= 1e-9 * scale && value >= -1e-9 * scale;
        let (h, unit_speed) = (self.scene.sheet.spacing, self.model.unit_speed);
        (0..2).any(|k| self.on_planes(i, j)[k] && !(small(x[k], h) && small(v[k], unit_speed)))
    }

    fn copy_segments(&self, out: &mut [f64], value: impl Fn(&Self, &SegmentView) -> f64) -> Result<(), Error> {
        let needed = self.layout.segments();
        if out.len() != needed {
            return Err(Error::new(Code::WrongLength, "out", out.len() as f64, needed as f64));
        }
        let mut slots = out.iter_mut();
        for axis in [Axis::Horizontal, Axis::Vertical] {
            for j in 0..self.layout.nodes_y {
                for i in 0..self.layout.nodes_x {
                    if let Some(segment) = self.segment(axis, i, j)
                        && let Some(slot) = slots.next()
                    {
                        *slot = value(self, &segment);
                    }
                }
            }
        }
        Ok(())
    }

    fn copy_nodes(
        &self,
        field: &'static str,
        out: &mut [f64],
        value: impl Fn(&Self, usize, usize) -> [f64; 3],
    ) -> Result<(), Error> {
        let needed = 3 * self.layout.nodes();
        if out.len() != needed {
            return Err(Error::new(Code::WrongLength, field, out.len() as f64, needed as f64));
        }
        let (slots, _) = out.as_chunks_mut::<3>();
        let nx = self.layout.nodes_x.max(1);
        for (k, slot) in slots.iter_mut().enumerate() {
            *slot = value(self, k % nx, k / nx);
        }
        Ok(())
    }

    /// The latched failure as an error, so that every call after it says the same.
    pub(crate) fn sound(&self) -> Result<(), Failure> {
        self.failure.map_or(Ok(()), Err)
    }

    fn refuse_if_started(&self) -> Result<(), Error> {
        if self.state.step == 0 { Ok(()) } else { Err(Error::plain(Code::AlreadyStarted, "")) }
    }
}
