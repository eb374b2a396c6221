//! The simulation: one step function over three blocks of caller memory (model, state, scratch), and its read-outs.
//!
//! One step: find the nodes near the projectile, sweep the sheet, correct the touched nodes by contact impulses, move the
//! body. The state is staggered: positions at t_n, velocities at t_{n-1/2}; it is never synchronised. Read-outs are pure.
//! Reference: docs/model.md, "The step".

use crate::contact::{self, Candidate, Search};
use crate::energy::SegmentView;
use crate::error::{Code, Error, Failure};
use crate::lanes::InstructionSet;
use crate::layout::{
    self, ALIGN_REALS, CANDIDATE_REALS, CARRY_PLANES, CHUNK, Chunk, HISTORY_PLANES, HOT_PLANES, Layout, YARN_PLANES,
};
use crate::math;
use crate::outcome::{Components, FirstContact, Latch, Outcome, Sight, TEST_INTERVAL};
use crate::path::{self, Path, Track};
use crate::pose::{Pose, Vector};
use crate::projectile::{self, Body, Inertia, Motion};
use crate::scene::{AttachmentKind, Drive, Scene, StepLimits};
use crate::shape::Solid;
use crate::state::State;
use crate::sweep::{self, Axis, Pass, Report, YarnRow};
use crate::weave::{self, ATTACHMENTS};
use crate::yarn::{DamageLaw, squared_stretch_excess};

/// The caller's memory: lengths from [`Layout::reals`] and [`Layout::words`]; longer is fine, content does not matter.
pub struct Memory<'a> {
    /// Numbers.
    pub reals: &'a mut [f64],
    /// Integers.
    pub words: &'a mut [u32],
}

/// Constants derived from the scene.
pub(crate) struct Model {
    pub limits: StepLimits,
    pub pose: Pose,
    pub solid: Solid,
    pub inertia: Inertia,
    pub law: DamageLaw,
    /// q at the critical stretch.
    pub critical: f64,
    /// Mass of a node, all plies, kg.
    pub node_mass: f64,
    /// h/dt, m/s.
    pub unit_speed: f64,
    /// m h/dt, N s.
    pub unit_impulse: f64,
    /// m (h/dt)^2, J.
    pub unit_energy: f64,
    /// A_0 h of all plies, m^3.
    pub segment_volume: f64,
    /// Modulus over kk, Pa.
    pub modulus_per_stiffness: f64,
    /// kk of the mean segment and its damage rate.
    pub mean_stiffness: f64,
    pub mean_damage_rate: f64,
    /// Steps in a force window.
    pub window_steps: u64,
}

/// The caller's memory, carved.
pub(crate) struct Blocks<'a> {
    /// Rows of [ux uy uz vx vy vz kh kv].
    pub hot: &'a mut [Chunk<HOT_PLANES>],
    /// Rows of the largest q beyond critical, horizontal and vertical.
    pub history: &'a mut [Chunk<HISTORY_PLANES>],
    /// Rows of [kh kv lambda_h lambda_v] of stochastic yarn.
    pub yarn: &'a mut [Chunk<YARN_PLANES>],
    carry: &'a mut [Chunk<CARRY_PLANES>],
    kept: &'a mut [[f64; 3]],
    /// Least and greatest y displacement of each row.
    ranges: &'a mut [[f64; 2]],
    candidates: &'a mut [[f64; CANDIDATE_REALS]],
    runs: &'a mut [[u32; 4]],
    /// Nodes with an impulse since the last outcome test.
    pub flags: &'a mut [u32],
    labels: &'a mut [u32],
    candidate_nodes: &'a mut [u32],
}

/// Contact read-out. Host's axes, cumulative since the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Impulse on the projectile, N s.
    pub impulse: [f64; 3],
    /// Angular impulse on the projectile about its moving centre of mass, N m s.
    pub angular_impulse: [f64; 3],
    /// Work of the projectile on the fabric = energy absorbed, J.
    pub work: f64,
    /// Kinetic energy lost in impacts of nodes, J.
    pub loss: f64,
    /// Largest mean force over a window of `force_window`, N.
    pub force_peak: f64,
}

/// Impulse of the sheet on its supports, N s, host's axes. Numbering of the attachments: see [`weave::attachment_of`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Support {
    /// All together.
    pub total: [f64; 3],
    /// Each side (left, right, bottom, top) or corner.
    pub attachments: [[f64; 3]; ATTACHMENTS],
}

/// Extremes of the fabric at t_n.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fabric {
    /// Largest distance of a node from the sheet's plane, m.
    pub max_deflection: f64,
    /// Largest stretch of a live segment.
    pub max_stretch: f64,
}

/// Counters and high-water marks. Available even after a failure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counters {
    /// Steps taken.
    pub steps: u64,
    /// Segments with alpha = 0.
    pub failed_segments: u64,
    /// Nodes with a contact impulse in the last step.
    pub contacts: u64,
    /// Contact solves that ran out of sweeps.
    pub unconverged: u64,
    /// Most Gauss-Seidel sweeps of one solve.
    pub most_sweeps: u64,
    /// Most candidate nodes of one step.
    pub most_candidates: u64,
    /// Places for candidate nodes.
    pub candidate_capacity: u64,
    /// Deepest penetration met, m.
    pub worst_penetration: f64,
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
    failed_segments: u64,
    failure: Option<Failure>,
    /// Rows [first, end) that may hold a node that is not exactly at rest in its place.
    awake: [usize; 2],
    skip_rest: bool,
    instructions: InstructionSet,
}

impl<'a> Sim<'a> {
    /// A simulation of `scene` at step 0: sheet flat and at rest, projectile in its start motion.
    ///
    /// # Errors
    /// Everything [`Scene::check`] and [`Scene::step_limits`] refuse, too little memory, a projectile too fast for the step
    /// or overlapping a free node. Memory is not written then.
    pub fn new(scene: &Scene, memory: Memory<'a>) -> Result<Sim<'a>, Error> {
        let layout = Layout::of(scene)?;
        let limits = scene.step_limits()?;
        let model = Model::of(scene, limits);
        let motion = path::into_sheet(&model.pose, &start_motion(scene));
        model.check_speed(&motion)?;
        let state = State::at_start(Body::of(&motion));
        refuse_overlap(scene, &model, &state.body)?;
        let blocks = Blocks::carve(memory, &layout)?;
        let mut sim = Sim {
            scene: *scene,
            layout,
            model,
            state,
            blocks,
            failed_segments: 0,
            failure: None,
            awake: [0, 0],
            skip_rest: true,
            instructions: InstructionSet::widest(),
        };
        sim.fill_model()?;
        sim.clear_state();
        sim.start_audit();
        Ok(sim)
    }

    /// Back to step 0 as after [`Sim::new`]. Clears a failure, motion and history set by hand, and the external load.
    pub fn reset(&mut self) {
        let motion = path::into_sheet(&self.model.pose, &start_motion(&self.scene));
        self.state = State::at_start(Body::of(&motion));
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
        self.sound()?;
        if self.scene.drive != Drive::Prescribed {
            return Err(Error::plain(Code::WrongDrive, "drive"));
        }
        let step = self.state.step;
        let bad = |field, value: u64, limit: u64| Error::new(Code::BadPath, field, value as f64, limit as f64);
        let Some(last) = path.first.checked_add(path.steps).filter(|_| path.steps > 0) else {
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
            let track = Track { first: path.first, steps: path.steps, start: self.state.body, end };
            self.model.check_track(&track)?;
            self.state.track = track;
        }
        Ok(self.advance(steps)?)
    }

    fn body_of_path(&self, path: &Path) -> Result<Body, Error> {
        use crate::scene::{finite3, unit_quaternion};
        finite3("path.position", path.end.position)?;
        finite3("path.velocity", path.end.velocity)?;
        unit_quaternion("path.orientation", path.end.orientation)?;
        finite3("path.angular_velocity", path.end.angular_velocity)?;
        Ok(Body::of(&path::into_sheet(&self.model.pose, &path.end)))
    }

    /// Sets the force, N, and torque, N m, that act on a free body from now on, host's axes (gravity, drag, a host).
    pub fn set_external_load(&mut self, force: [f64; 3], torque: [f64; 3]) -> Result<(), Error> {
        self.sound()?;
        crate::scene::finite3("external.force", force)?;
        crate::scene::finite3("external.torque", torque)?;
        if self.scene.drive != Drive::Free {
            return Err(Error::plain(Code::WrongDrive, "drive"));
        }
        self.state.force = Vector::from(self.model.pose.vector_in(force));
        self.state.torque = Vector::from(self.model.pose.vector_in(torque));
        Ok(())
    }

    /// Starts from given positions, m, and velocities, m/s, at t_0 (3 per node, node by node, host's frame): restart from
    /// another code, pre-stretched sheets. Fixed nodes stay where this puts them; their velocity must be 0.
    ///
    /// # Errors
    /// Wrong lengths, non-finite numbers, a moving fixed node, a free node inside the projectile, or a step already taken.
    pub fn set_motion(&mut self, positions: &[f64], velocities: &[f64]) -> Result<(), Error> {
        self.sound()?;
        self.refuse_if_started()?;
        for (field, values) in [("positions", positions), ("velocities", velocities)] {
            if values.len() != 3 * self.layout.nodes() {
                let wanted = 3.0 * self.layout.nodes() as f64;
                return Err(Error::new(Code::WrongLength, field, values.len() as f64, wanted));
            }
            values.iter().try_for_each(|&x| crate::scene::finite(field, x))?;
        }
        let (points, _) = positions.as_chunks::<3>();
        let (speeds, _) = velocities.as_chunks::<3>();
        let nx = self.layout.nodes_x;
        let search = Search::new(&self.model.solid, &self.state.body, self.scene.sheet.spacing);
        for (k, (point, velocity)) in points.iter().zip(speeds).enumerate() {
            let fixed = self.is_fixed(k % nx, k / nx);
            if fixed && *velocity != [0.0; 3] {
                return Err(Error::new(Code::OutOfRange, "velocities", k as f64, 0.0));
            }
            let x = Vector::from(self.model.pose.point_in(*point));
            if !fixed && search.candidate(&x).is_some_and(|(gap, _, _)| self.model.overlaps(gap)) {
                return Err(Error::new(Code::InitialOverlap, "positions", k as f64, 0.0));
            }
        }
        let h = self.scene.sheet.spacing;
        for (k, (point, velocity)) in points.iter().zip(speeds).enumerate() {
            let (i, j) = (k % nx, k / nx);
            let x = self.model.pose.point_in(*point);
            let v = self.model.pose.vector_in(*velocity);
            let rest = self.rest(i, j);
            let u = [x[0] / h - rest[0], x[1] / h - rest[1], x[2] / h];
            self.set_node(i, j, u, v.map(|v| v / self.model.unit_speed));
        }
        self.rebuild_derived();
        // The stored velocity belongs to t_{-1/2}: back by half a kick with the forces at t_0.
        for k in 0..self.layout.nodes() {
            let (i, j) = (k % nx, k / nx);
            if !self.is_fixed(i, j) {
                let (u, v) = self.node(i, j);
                let a = self.acceleration(i, j);
                self.set_node(i, j, u, [v[0] - 0.5 * a[0], v[1] - 0.5 * a[1], v[2] - 0.5 * a[2]]);
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
        stretches.iter().try_for_each(|&x| crate::scene::finite("stretches", x))?;
        if let Some(&below) = stretches.iter().find(|&&x| x < 0.0) {
            return Err(Error::new(Code::OutOfRange, "stretches", below, 0.0));
        }
        if let Some(&above) = stretches.iter().find(|&&x| x > 1e100) {
            return Err(Error::new(Code::OutOfRange, "stretches", above, 1e100));
        }
        let mut stretches = stretches.iter();
        let (nx, ny, chunks) = (self.layout.nodes_x, self.layout.nodes_y, self.layout.chunks);
        let critical = self.model.critical;
        for (axis, columns, rows) in [(0, nx - 1, ny), (1, nx, ny - 1)] {
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

    /// The projectile: pose at t_n, rates at t_{n-1/2} (constant between impulses), host's frame.
    pub fn projectile(&self) -> Result<Motion, Failure> {
        self.sound()?;
        Ok(path::out_of_sheet(&self.model.pose, &self.state.body.motion()))
    }

    /// Contact sums.
    pub fn contact(&self) -> Result<Contact, Failure> {
        self.sound()?;
        let sums = &self.state.sums;
        Ok(Contact {
            impulse: self.model.pose.vector_out(sums.impulse.into()),
            angular_impulse: self.model.pose.vector_out(sums.angular_impulse.into()),
            work: sums.work,
            loss: sums.loss,
            force_peak: sums.force_peak,
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

    /// Deflection and stretch, with a full pass over the sheet.
    pub fn fabric(&self) -> Result<Fabric, Failure> {
        self.sound()?;
        let (mut deflection, mut excess) = (0.0, 0.0);
        for j in 0..self.layout.nodes_y {
            for i in 0..self.layout.nodes_x {
                let (u, _) = self.node(i, j);
                let z = if u[2] < 0.0 { -u[2] } else { u[2] };
                deflection = if z > deflection { z } else { deflection };
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

    /// Positions at t_n, m, 3 per node, node by node (rows along x first), host's frame.
    pub fn copy_positions(&self, out: &mut [f64]) -> Result<(), Error> {
        self.sound()?;
        self.copy_nodes("out", out, |sim, i, j| sim.model.pose.point_out(sim.position(i, j).into()))
    }

    /// Velocities at t_n, m/s, 3 per node, host's axes: the stored half-step velocities and half a kick.
    pub fn copy_velocities(&self, out: &mut [f64]) -> Result<(), Error> {
        self.sound()?;
        self.copy_nodes("out", out, |sim, i, j| {
            let (_, v) = sim.node(i, j);
            let a = if sim.is_fixed(i, j) { [0.0; 3] } else { sim.acceleration(i, j) };
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
        let nx = self.layout.nodes_x;
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

    // ---- The step -------------------------------------------------------------------------------------------------

    fn step_once(&mut self) -> Result<(), Failure> {
        let target = self.prescribe_rates();
        self.refuse_too_fast()?;
        let before = self.state.body;
        let count = self.gather()?;
        let report = self.sweep();
        if report.non_finite {
            return Err(Failure::NonFinite);
        }
        self.failed_segments += report.newly_failed;
        self.touch(count, &before);
        self.move_body(target);
        self.state.step += 1;
        self.close_window();
        if self.state.step.is_multiple_of(TEST_INTERVAL) {
            self.test_outcomes();
        }
        Ok(())
    }

    /// A prescribed body on a path: sets its rates for this step and returns its pose at the step's end.
    fn prescribe_rates(&mut self) -> Option<(Vector, nalgebra::Quaternion<f64>)> {
        let state = &mut self.state;
        let track = &state.track;
        if track.steps == 0 || state.step >= track.first + track.steps {
            return None;
        }
        let dt = self.model.limits.dt;
        let (position, orientation) = track.pose(state.step + 1, dt);
        state.body.velocity = (position - state.body.position) / dt;
        if self.model.solid.feels_torque() {
            state.body.angular_velocity = path::cayley_rate(&state.body.orientation, &orientation, dt);
        }
        Some((position, orientation))
    }

    fn refuse_too_fast(&self) -> Result<(), Failure> {
        let body = &self.state.body;
        let (v, w) = (body.velocity, body.angular_velocity);
        let (speed, rate) = (math::length([v.x, v.y, v.z]), math::length([w.x, w.y, w.z]));
        if !(speed.is_finite() && rate.is_finite()) {
            return Err(Failure::NonFinite);
        }
        if self.model.too_fast(speed, rate) { Err(Failure::TooFast) } else { Ok(()) }
    }

    /// Copies the free nodes closer than h to the projectile; returns how many.
    fn gather(&mut self) -> Result<usize, Failure> {
        let h = self.scene.sheet.spacing;
        let search = Search::new(&self.model.solid, &self.state.body, h);
        let (nx, ny, chunks) = (self.layout.nodes_x, self.layout.nodes_y, self.layout.chunks);
        let (unit_speed, nodes_x, nodes_y) =
            (self.model.unit_speed, self.scene.sheet.nodes_x, self.scene.sheet.nodes_y);
        let Blocks { hot, ranges, candidates, candidate_nodes, runs, .. } = &mut self.blocks;
        let mut slots = candidates.iter_mut().zip(candidate_nodes.iter_mut());
        let mut count = 0;
        let mut worst = self.state.sums.worst_penetration;
        for j in 0..ny {
            let y0 = weave::rest_offset(j, nodes_y);
            let [low, high] = ranges.get(j).copied().unwrap_or([0.0; 2]);
            if !search.meets_row((y0 + low) * h, (y0 + high) * h) {
                continue;
            }
            let run = runs.get(j).copied().unwrap_or([0; 4]);
            let row = layout::row(hot, chunks, j);
            for i in 0..nx {
                let (Some(chunk), lane) = (row.get(i / CHUNK), i % CHUNK) else { break };
                let x = (weave::rest_offset(i, nodes_x) + chunk[0][lane]) * h;
                if !search.meets_column(x) {
                    continue;
                }
                let u = [chunk[0][lane], chunk[1][lane], chunk[2][lane]];
                let x = Vector::new(x, (y0 + u[1]) * h, u[2] * h);
                let Some((gap, normal, arm)) = search.candidate(&x) else { continue };
                if in_runs(&run, i) {
                    continue;
                }
                let Some((slot, node)) = slots.next() else { return Err(Failure::ContactCapacity) };
                let v = Vector::new(chunk[3][lane], chunk[4][lane], chunk[5][lane]);
                let candidate = Candidate {
                    displacement: u,
                    normal,
                    arm,
                    gap,
                    speed_before: normal.dot(&v) * unit_speed,
                    approach: 0.0,
                    effective_mass: 0.0,
                    impulse: 0.0,
                };
                candidate.write(slot);
                *node = (j * nx + i) as u32;
                count += 1;
                worst = if -gap > worst { -gap } else { worst };
            }
        }
        self.state.sums.worst_penetration = worst;
        if count as u64 > self.state.sums.most_candidates {
            self.state.sums.most_candidates = count as u64;
        }
        Ok(count)
    }

    /// The hot pass over all rows that are awake or next to one, with fixed nodes put back and their pull booked.
    fn sweep(&mut self) -> Report {
        let (nx, ny, chunks) = (self.layout.nodes_x, self.layout.nodes_y, self.layout.chunks);
        let [first, end] = self.rows_to_step();
        let pass =
            Pass { nodes_x: nx, law: &self.model.law, critical: self.model.critical, instructions: self.instructions };
        let Blocks { hot, history, yarn, carry, kept, ranges, runs, .. } = &mut self.blocks;
        let uniform =
            YarnRow::Uniform { stiffness: self.model.mean_stiffness, damage_rate: self.model.mean_damage_rate };
        let mut report = Report::default();
        carry.fill([[0.0; CHUNK]; CARRY_PLANES]);
        for j in first..end {
            let Some((below, above)) = hot.split_at_mut_checked((j + 1) * chunks) else { break };
            let row = layout::row_mut(below, chunks, j);
            let yarn = if self.layout.stochastic { YarnRow::Stochastic(layout::row(yarn, chunks, j)) } else { uniform };
            let run = runs.get(j).copied().unwrap_or([0; 4]);
            let above = if j + 1 < ny { layout::row(above, chunks, 0) } else { &[] };
            keep_fixed(row, kept, &run);
            let (met, range) = pass.row(row, layout::row_mut(history, chunks, j), above, carry, yarn);
            report = report.merged(met);
            if let Some(slot) = ranges.get_mut(j) {
                *slot = range;
            }
            let pulls = restore_fixed(row, kept, &run);
            if self.scene.track_support {
                for (k, pull) in pulls.iter().enumerate() {
                    let at = weave::attachment_of(self.scene.attachment.kind, self.scene.sheet.nodes_y, j, k);
                    if let Some(sum) = self.state.sums.support.get_mut(at) {
                        *sum += pull;
                    }
                }
            }
        }
        self.awake = [first, end];
        report
    }

    /// Awake rows and their neighbours.
    fn rows_to_step(&self) -> [usize; 2] {
        let ny = self.layout.nodes_y;
        let [first, end] = self.awake;
        if !self.skip_rest {
            [0, ny]
        } else if first == end {
            [0, 0]
        } else {
            [first.saturating_sub(1), (end + 1).min(ny)]
        }
    }

    /// External load, contact impulses on the gathered nodes and on the body, and their sums.
    fn touch(&mut self, count: usize, before: &Body) {
        let dt = self.model.limits.dt;
        let (force, torque) = (self.state.force, self.state.torque);
        if self.scene.drive == Drive::Free {
            let body = &mut self.state.body;
            body.velocity += force * (dt * self.model.inertia.inverse_mass);
            if self.model.solid.feels_torque() {
                let twist = projectile::into_body(&body.orientation, &(torque * dt));
                body.angular_velocity += twist.component_mul(&self.model.inertia.inverse_moments);
            }
        }
        if count > 0 {
            self.solve_contact(count, before);
        } else {
            self.state.sums.contacts = 0;
        }
        if self.scene.drive == Drive::Free {
            let mean = (before.velocity + self.state.body.velocity) * 0.5;
            let mut work = force.dot(&mean) * dt;
            if self.model.solid.feels_torque() {
                let spin = (before.angular_velocity + self.state.body.angular_velocity) * 0.5;
                work += projectile::into_body(&before.orientation, &torque).dot(&spin) * dt;
            }
            self.state.sums.external_work += work;
            self.state.sums.external_impulse += force * dt;
        }
    }

    fn solve_contact(&mut self, count: usize, before: &Body) {
        let (nx, dt) = (self.layout.nodes_x, self.model.limits.dt);
        for c in 0..count {
            let Some(node) = self.blocks.candidate_nodes.get(c).map(|&k| k as usize) else { break };
            let (_, v) = self.node(node % nx, node / nx);
            let Some(slot) = self.blocks.candidates.get_mut(c) else { break };
            let mut candidate = Candidate::read(slot);
            let gap = if candidate.gap > 0.0 { candidate.gap } else { 0.0 };
            candidate.approach = gap / dt + candidate.normal.dot(&Vector::from(v)) * self.model.unit_speed;
            candidate.write(slot);
        }
        let slots = self.blocks.candidates.get_mut(..count).unwrap_or(&mut []);
        let solved = contact::solve(slots, &self.state.body, &self.model.inertia, self.model.node_mass);
        self.state.body.velocity = solved.velocity;
        self.state.body.angular_velocity = solved.angular_velocity;
        if solved.sweeps as u64 > self.state.sums.most_sweeps {
            self.state.sums.most_sweeps = solved.sweeps as u64;
        }
        self.state.sums.unconverged += u64::from(!solved.converged);
        self.book_contact(count, before);
    }

    /// Moves the touched nodes and books impulse, angular impulse, work and loss.
    fn book_contact(&mut self, count: usize, before: &Body) {
        let nx = self.layout.nodes_x;
        let body = self.state.body;
        let mean_velocity = (before.velocity + body.velocity) * 0.5;
        let mean_rate = (before.angular_velocity + body.angular_velocity) * 0.5;
        let mut impulse_sum = Vector::zeros();
        let mut arm_sum = Vector::zeros();
        let (mut work, mut loss, mut touched) = (0.0, 0.0, 0);
        for c in 0..count {
            let (Some(slot), Some(&node)) = (self.blocks.candidates.get(c), self.blocks.candidate_nodes.get(c)) else {
                break;
            };
            let candidate = Candidate::read(slot);
            if candidate.impulse <= 0.0 {
                continue;
            }
            let (impulse, normal) = (candidate.impulse, candidate.normal);
            let (i, j) = (node as usize % nx, node as usize / nx);
            let (_, free) = self.node(i, j);
            let kick = normal * (impulse / self.model.unit_impulse);
            let v = [free[0] + kick.x, free[1] + kick.y, free[2] + kick.z];
            let u = candidate.displacement;
            self.set_node(i, j, [u[0] + v[0], u[1] + v[1], u[2] + v[2]], v);
            self.widen(j, u[1] + v[1]);
            if let Some(flags) = self.blocks.flags.get_mut(node as usize / 32) {
                *flags |= 1 << (node % 32);
            }
            let speed_after = normal.dot(&Vector::from(v)) * self.model.unit_speed;
            let body_speed = normal.dot(&mean_velocity) + candidate.arm.dot(&mean_rate);
            impulse_sum -= normal * impulse;
            arm_sum -= candidate.arm * impulse;
            work += impulse * body_speed;
            loss -= impulse * (0.5 * (candidate.speed_before + speed_after) - body_speed);
            touched += 1;
        }
        self.state.sums.contacts = touched;
        if touched == 0 {
            return;
        }
        if self.state.watch.first.is_none() {
            let energy = before.kinetic_energy(&self.model.inertia);
            self.state.watch.touch(self.state.step, before, energy);
        }
        let sums = &mut self.state.sums;
        sums.impulses += touched;
        sums.impulse += impulse_sum;
        sums.window += impulse_sum;
        if self.model.solid.feels_torque() {
            sums.angular_impulse += projectile::out_of_body(&before.orientation, &arm_sum);
        }
        sums.work += work;
        sums.loss += loss;
    }

    /// Notes that a row holds a moving node with this y displacement.
    fn widen(&mut self, j: usize, y: f64) {
        let [first, end] = self.awake;
        self.awake = if first == end { [j, j + 1] } else { [first.min(j), end.max(j + 1)] };
        if let Some([low, high]) = self.blocks.ranges.get_mut(j) {
            *low = if y < *low { y } else { *low };
            *high = if y > *high { y } else { *high };
        }
    }

    fn move_body(&mut self, target: Option<(Vector, nalgebra::Quaternion<f64>)>) {
        let dt = self.model.limits.dt;
        let state = &mut self.state;
        match (self.scene.drive, target) {
            (Drive::Free, _) => state.body.drift(&self.model.solid, &self.model.inertia, dt),
            (Drive::Prescribed, Some((position, orientation))) => {
                state.body.position = position;
                state.body.orientation = orientation;
                if state.step + 1 == state.track.first + state.track.steps {
                    // The next path starts with the rates this one ends with.
                    state.body.velocity = state.track.end.velocity;
                    state.body.angular_velocity = state.track.end.angular_velocity;
                }
            }
            (Drive::Prescribed, None) => {
                state.body.position += state.body.velocity * dt;
                if self.model.solid.feels_torque() {
                    let w = state.body.angular_velocity;
                    state.body.orientation = projectile::cayley_turn(&state.body.orientation, &w, dt);
                }
            }
        }
    }

    /// At the end of a force window: keeps the largest mean force.
    fn close_window(&mut self) {
        if !self.state.step.is_multiple_of(self.model.window_steps) {
            return;
        }
        let sums = &mut self.state.sums;
        let w = sums.window;
        let mean = math::length([w.x, w.y, w.z]) / (self.model.window_steps as f64 * self.model.limits.dt);
        sums.force_peak = if mean > sums.force_peak { mean } else { sums.force_peak };
        sums.window = Vector::zeros();
    }

    fn test_outcomes(&mut self) {
        let detached = self.layout.track_detachment
            && self.state.watch.first.is_some()
            && self.state.watch.latched[Outcome::Detached as usize].is_none()
            && self.failed_segments > 0
            && self.contact_is_detached();
        let sight = Sight {
            step: self.state.step,
            body: &self.state.body,
            work: self.state.sums.work,
            impulses: self.state.sums.impulses,
            radius: self.scene.projectile.radius,
            reach: self.model.solid.reach(),
            half_size: self.scene.half_size(),
        };
        if detached {
            self.state.watch.latch(Outcome::Detached, sight.step, sight.work);
        }
        self.state.watch.test(&sight);
        self.blocks.flags.fill(0);
    }

    /// true if some node was touched since the last test, some node is fixed, and no live path joins any two of them.
    fn contact_is_detached(&mut self) -> bool {
        let (nx, ny, chunks) = (self.layout.nodes_x, self.layout.nodes_y, self.layout.chunks);
        if self.scene.attachment.kind == AttachmentKind::Free || self.blocks.flags.iter().all(|&f| f == 0) {
            return false;
        }
        let Blocks { hot, labels, runs, flags, .. } = &mut self.blocks;
        let mut sets = Components::new(labels);
        for j in 0..ny {
            let row = layout::row(hot, chunks, j);
            let live = |axis: usize, i: usize| layout::get(row, 6 + axis, i).is_some_and(|stiffness| stiffness > 0.0);
            for i in 0..nx {
                let k = j * nx + i;
                if i + 1 < nx && live(0, i) {
                    sets.join(k, k + 1);
                }
                if j + 1 < ny && live(1, i) {
                    sets.join(k, k + nx);
                }
            }
        }
        // All fixed nodes into one component.
        let mut support = None;
        for (j, run) in runs.iter().enumerate() {
            for i in (run[0]..run[1]).chain(run[2]..run[3]) {
                let k = j * nx + i as usize;
                match support {
                    None => support = Some(k),
                    Some(first) => sets.join(first, k),
                }
            }
        }
        let Some(support) = support else { return false };
        let root = sets.find(support);
        for k in 0..nx * ny {
            let touched = flags.get(k / 32).is_some_and(|f| f >> (k % 32) & 1 == 1);
            if touched && sets.find(k) == root {
                return false;
            }
        }
        true
    }

    // ---- Nodes and segments ---------------------------------------------------------------------------------------

    /// Rest place of a node in spacings.
    fn rest(&self, i: usize, j: usize) -> [f64; 2] {
        [weave::rest_offset(i, self.scene.sheet.nodes_x), weave::rest_offset(j, self.scene.sheet.nodes_y)]
    }

    /// Position at t_n in the sheet's frame, m.
    fn position(&self, i: usize, j: usize) -> Vector {
        let (u, _) = self.node(i, j);
        let (rest, h) = (self.rest(i, j), self.scene.sheet.spacing);
        Vector::new((rest[0] + u[0]) * h, (rest[1] + u[1]) * h, u[2] * h)
    }

    /// Displacement (spacings) and velocity (spacings per step) of a node.
    fn node(&self, i: usize, j: usize) -> ([f64; 3], [f64; 3]) {
        let row = layout::row(self.blocks.hot, self.layout.chunks, j);
        let at = |plane: usize| layout::get(row, plane, i).unwrap_or(0.0);
        ([at(0), at(1), at(2)], [at(3), at(4), at(5)])
    }

    fn set_node(&mut self, i: usize, j: usize, u: [f64; 3], v: [f64; 3]) {
        let row = layout::row_mut(self.blocks.hot, self.layout.chunks, j);
        for (plane, value) in u.into_iter().chain(v).enumerate() {
            if let Some(slot) = layout::get_mut(row, plane, i) {
                *slot = value;
            }
        }
    }

    pub(crate) fn is_fixed(&self, i: usize, j: usize) -> bool {
        self.blocks.runs.get(j).is_some_and(|run| in_runs(run, i))
    }

    /// The segment that starts at node (i, j), if there is one.
    pub(crate) fn segment(&self, axis: Axis, i: usize, j: usize) -> Option<SegmentView> {
        let (nx, ny, chunks) = (self.layout.nodes_x, self.layout.nodes_y, self.layout.chunks);
        let (i2, j2) = match axis {
            Axis::Horizontal => (i + 1, j),
            Axis::Vertical => (i, j + 1),
        };
        if i2 >= nx || j2 >= ny {
            return None;
        }
        let ((u1, v1), (u2, v2)) = (self.node(i, j), self.node(i2, j2));
        let d = [u2[0] - u1[0], u2[1] - u1[1], u2[2] - u1[2]];
        let dv = [v2[0] - v1[0], v2[1] - v1[1], v2[2] - v1[2]];
        let (undamaged, damage_rate) = self.yarn_row(j).constants(axis, i);
        Some(SegmentView {
            axis,
            stiffness: layout::get(layout::row(self.blocks.hot, chunks, j), 6 + axis as usize, i)?,
            undamaged,
            damage_rate,
            history: layout::get(layout::row(self.blocks.history, chunks, j), axis as usize, i)?,
            d,
            d_before: [d[0] - dv[0], d[1] - dv[1], d[2] - dv[2]],
        })
    }

    fn yarn_row(&self, j: usize) -> YarnRow<'_> {
        if self.layout.stochastic {
            YarnRow::Stochastic(layout::row(self.blocks.yarn, self.layout.chunks, j))
        } else {
            YarnRow::Uniform { stiffness: self.model.mean_stiffness, damage_rate: self.model.mean_damage_rate }
        }
    }

    /// Change of velocity per step that the yarns give a node at t_n, with damage up to t_n; nothing is committed.
    /// The same expressions in the same order as the sweep.
    fn acceleration(&self, i: usize, j: usize) -> [f64; 3] {
        let pull = |axis: Axis, i: Option<usize>, j: Option<usize>| -> [f64; 3] {
            let (Some(i), Some(j)) = (i, j) else { return [0.0; 3] };
            let Some(segment) = self.segment(axis, i, j) else { return [0.0; 3] };
            let q = segment.excess_now();
            let stiffness = if q > self.model.critical && q > segment.history {
                self.model.law.alpha(segment.damage_rate, q) * segment.undamaged
            } else {
                segment.stiffness
            };
            match axis {
                Axis::Horizontal => sweep::pull_horizontal(stiffness, q, segment.d),
                Axis::Vertical => sweep::pull_vertical(stiffness, q, segment.d),
            }
        };
        let right = pull(Axis::Horizontal, Some(i), Some(j));
        let left = pull(Axis::Horizontal, i.checked_sub(1), Some(j));
        let up = pull(Axis::Vertical, Some(i), Some(j));
        let down = pull(Axis::Vertical, Some(i), j.checked_sub(1));
        [
            sweep::node_sum(right[0], left[0], up[0], down[0]),
            sweep::node_sum(right[1], left[1], up[1], down[1]),
            sweep::node_sum(right[2], left[2], up[2], down[2]),
        ]
    }

    // ---- Filling the blocks ---------------------------------------------------------------------------------------

    /// Yarn constants and fixed runs.
    fn fill_model(&mut self) -> Result<(), Error> {
        for (j, run) in self.blocks.runs.iter_mut().enumerate() {
            let [[a, b], [c, d]] = weave::fixed_runs(&self.scene, j);
            *run = [a, b, c, d];
        }
        if !self.layout.stochastic {
            return Ok(());
        }
        let (nx, ny, chunks) = (self.layout.nodes_x, self.layout.nodes_y, self.layout.chunks);
        let (nodes_x, nodes_y) = (self.scene.sheet.nodes_x, self.scene.sheet.nodes_y);
        self.blocks.yarn.fill([[0.0; CHUNK]; YARN_PLANES]);
        for j in 0..ny {
            let row = layout::row_mut(self.blocks.yarn, chunks, j);
            for i in 0..nx {
                let horizontal = (i + 1 < nx).then(|| weave::horizontal_number(nodes_x, i, j));
                let vertical = (j + 1 < ny).then(|| weave::vertical_number(nodes_x, nodes_y, i, j));
                for (axis, number) in [horizontal, vertical].into_iter().enumerate() {
                    let Some(number) = number else { continue };
                    let segment = self.scene.draw_segment(number)?;
                    if let Some(slot) = layout::get_mut(row, axis, i) {
                        *slot = segment.modulus / self.model.modulus_per_stiffness;
                    }
                    if let Some(slot) = layout::get_mut(row, axis + 2, i) {
                        *slot = segment.damage_rate;
                    }
                }
            }
        }
        Ok(())
    }

    /// Sheet flat, at rest and whole.
    fn clear_state(&mut self) {
        self.blocks.hot.fill([[0.0; CHUNK]; HOT_PLANES]);
        self.blocks.history.fill([[0.0; CHUNK]; HISTORY_PLANES]);
        self.blocks.flags.fill(0);
        self.rebuild_derived();
    }

    /// Everything that follows from displacements, velocities and histories: stiffness planes, failed segments, row ranges,
    /// awake rows. Clears a failure.
    pub(crate) fn rebuild_derived(&mut self) {
        self.failure = None;
        self.failed_segments = 0;
        let (nx, ny, chunks) = (self.layout.nodes_x, self.layout.nodes_y, self.layout.chunks);
        let mut awake: Option<[usize; 2]> = None;
        for j in 0..ny {
            for i in 0..nx {
                for axis in [Axis::Horizontal, Axis::Vertical] {
                    let Some(segment) = self.segment(axis, i, j) else { continue };
                    let stiffness = self.model.law.alpha(segment.damage_rate, segment.history) * segment.undamaged;
                    let row = layout::row_mut(self.blocks.hot, chunks, j);
                    if let Some(slot) = layout::get_mut(row, 6 + axis as usize, i) {
                        *slot = stiffness;
                    }
                    self.failed_segments += u64::from(stiffness == 0.0);
                }
            }
            let (mut low, mut high, mut moved) = (0.0, 0.0, false);
            for i in 0..nx {
                let (u, v) = self.node(i, j);
                moved |= u.iter().chain(&v).any(|&x| x != 0.0);
                low = if u[1] < low { u[1] } else { low };
                high = if u[1] > high { u[1] } else { high };
            }
            if let Some(range) = self.blocks.ranges.get_mut(j) {
                *range = [low, high];
            }
            if moved {
                awake = Some([awake.map_or(j, |[first, _]| first), j + 1]);
            }
        }
        self.awake = awake.unwrap_or([0, 0]);
    }
}

/// Refuses a start in which a free node of the flat sheet lies inside the projectile.
fn refuse_overlap(scene: &Scene, model: &Model, body: &Body) -> Result<(), Error> {
    let h = scene.sheet.spacing;
    let search = Search::new(&model.solid, body, h);
    for j in 0..scene.sheet.nodes_y as usize {
        let y = weave::rest_offset(j, scene.sheet.nodes_y) * h;
        if !search.meets_row(y, y) {
            continue;
        }
        let [[a, b], [c, d]] = weave::fixed_runs(scene, j);
        for i in (0..scene.sheet.nodes_x as usize).filter(|&i| !in_runs(&[a, b, c, d], i)) {
            let x = Vector::new(weave::rest_offset(i, scene.sheet.nodes_x) * h, y, 0.0);
            if let Some((gap, _, _)) = search.candidate(&x).filter(|(gap, _, _)| model.overlaps(*gap)) {
                return Err(Error::new(Code::InitialOverlap, "projectile.position", gap, 0.0));
            }
        }
    }
    Ok(())
}

impl Model {
    fn of(scene: &Scene, limits: StepLimits) -> Model {
        let solid = Solid::of(&scene.projectile);
        let (h, dt) = (scene.sheet.spacing, limits.dt);
        let node_mass = scene.lumped_mass();
        let law = scene.damage_law();
        let mean = scene.mean_segment();
        // kk = E A_0 dt^2 / (2 m h); plies cancel.
        let modulus_per_stiffness = 2.0 * scene.sheet.node_mass * h / (scene.sheet.yarn_area * dt * dt);
        let window = math::round(scene.force_window / dt);
        Model {
            limits,
            pose: Pose::of_sheet(&scene.sheet),
            solid,
            inertia: Inertia::of(&solid, scene.projectile.mass, scene.drive == Drive::Free),
            law,
            critical: law.critical_excess(),
            node_mass,
            unit_speed: h / dt,
            unit_impulse: node_mass * h / dt,
            unit_energy: node_mass * (h / dt) * (h / dt),
            segment_volume: scene.lumped_area() * h,
            modulus_per_stiffness,
            mean_stiffness: mean.modulus / modulus_per_stiffness,
            mean_damage_rate: mean.damage_rate,
            window_steps: if window >= 1.0 { window as u64 } else { 1 },
        }
    }

    /// Rounding aside, a node deeper than a billionth of the spacing is inside.
    fn overlaps(&self, gap: f64) -> bool {
        gap < -1e-9 * self.unit_speed * self.limits.dt
    }

    /// Whether surface points cross a node spacing in a step, or the body turns more than half a radian.
    fn too_fast(&self, speed: f64, rate: f64) -> bool {
        let (turning, reach) = if self.solid.feels_torque() { (rate, self.solid.reach()) } else { (0.0, 0.0) };
        let within = speed + turning * reach < self.unit_speed && self.limits.dt * turning <= 0.5;
        !within
    }

    fn check_speed(&self, motion: &Motion) -> Result<(), Error> {
        let (speed, rate) = (math::length(motion.velocity), math::length(motion.angular_velocity));
        if self.too_fast(speed, rate) {
            return Err(Error::new(Code::ProjectileTooFast, "projectile.velocity", speed, self.unit_speed));
        }
        Ok(())
    }

    /// Speed bound of a path: the derivative of the cubic lies in the hull of its ends and 3 (P1 - P0)/T - V0 - V1.
    fn check_track(&self, track: &Track) -> Result<(), Error> {
        let duration = track.steps as f64 * self.limits.dt;
        let (start, end) = (&track.start, &track.end);
        let chord = (end.position - start.position) * (3.0 / duration);
        let turn = path::rotation_vector(&(start.orientation.conjugate() * end.orientation)) * (3.0 / duration);
        let speeds = [start.velocity, end.velocity, chord - start.velocity - end.velocity];
        let rates =
            [start.angular_velocity, end.angular_velocity, turn - start.angular_velocity - end.angular_velocity];
        let largest = |vectors: [Vector; 3]| {
            vectors.iter().map(|v| math::length([v.x, v.y, v.z])).fold(0.0, |a, b| if b > a { b } else { a })
        };
        let (speed, rate) = (largest(speeds), largest(rates));
        if self.too_fast(speed, rate) {
            return Err(Error::new(Code::ProjectileTooFast, "path.velocity", speed, self.unit_speed));
        }
        Ok(())
    }
}

impl<'a> Blocks<'a> {
    fn carve(memory: Memory<'a>, layout: &Layout) -> Result<Blocks<'a>, Error> {
        let Memory { reals, words } = memory;
        let (have_reals, have_words) = (reals.len(), words.len());
        let short = |field, have: usize, need: usize| Error::new(Code::ShortBuffer, field, have as f64, need as f64);
        if have_reals < layout.reals() {
            return Err(short("memory.reals", have_reals, layout.reals()));
        }
        if have_words < layout.words() {
            return Err(short("memory.words", have_words, layout.words()));
        }
        let skip = reals.as_ptr().align_offset(8 * ALIGN_REALS);
        let mut reals = Carver(reals);
        let mut words = Carver(words);
        let (nx, ny, row) = (layout.nodes_x, layout.nodes_y, layout.chunks * CHUNK);
        let watched = |count: usize| if layout.track_detachment { count } else { 0 };
        let carved = (|| {
            reals.take(skip)?;
            Some(Blocks {
                hot: chunked(reals.take(ny * HOT_PLANES * row)?),
                history: chunked(reals.take(ny * HISTORY_PLANES * row)?),
                yarn: chunked(reals.take(if layout.stochastic { ny * YARN_PLANES * row } else { 0 })?),
                carry: chunked(reals.take(CARRY_PLANES * row)?),
                kept: reals.take(3 * nx)?.as_chunks_mut().0,
                ranges: reals.take(2 * ny)?.as_chunks_mut().0,
                candidates: reals.take(layout.candidates * CANDIDATE_REALS)?.as_chunks_mut().0,
                runs: words.take(4 * ny)?.as_chunks_mut().0,
                flags: words.take(watched(layout.nodes().div_ceil(32)))?,
                labels: words.take(watched(layout.nodes()))?,
                candidate_nodes: words.take(layout.candidates)?,
            })
        })();
        carved.ok_or(short("memory.reals", have_reals, layout.reals()))
    }
}

/// Cuts pieces off the front of a slice.
struct Carver<'a, T>(&'a mut [T]);

impl<'a, T> Carver<'a, T> {
    fn take(&mut self, count: usize) -> Option<&'a mut [T]> {
        let (piece, rest) = core::mem::take(&mut self.0).split_at_mut_checked(count)?;
        self.0 = rest;
        Some(piece)
    }
}

fn start_motion(scene: &Scene) -> Motion {
    let body = &scene.projectile;
    Motion {
        position: body.position,
        velocity: body.velocity,
        orientation: body.orientation,
        angular_velocity: body.angular_velocity,
    }
}

/// Numbers as chunks of P planes.
fn chunked<const P: usize>(reals: &mut [f64]) -> &mut [Chunk<P>] {
    reals.as_chunks_mut().0.as_chunks_mut().0
}

fn in_runs(run: &[u32; 4], i: usize) -> bool {
    let i = i as u32;
    (run[0] <= i && i < run[1]) || (run[2] <= i && i < run[3])
}

/// Remembers the displacements of a row's fixed nodes.
fn keep_fixed(row: &[Chunk<HOT_PLANES>], kept: &mut [[f64; 3]], run: &[u32; 4]) {
    for columns in [run[0]..run[1], run[2]..run[3]] {
        for i in columns.map(|i| i as usize) {
            let (Some([x, y, z, ..]), Some(kept)) = (row.get(i / CHUNK), kept.get_mut(i)) else { break };
            *kept = [x[i % CHUNK], y[i % CHUNK], z[i % CHUNK]];
        }
    }
}

/// Puts a row's fixed nodes back to rest and returns the pull of the sheet on each run, in units of m h/dt.
fn restore_fixed(row: &mut [Chunk<HOT_PLANES>], kept: &[[f64; 3]], run: &[u32; 4]) -> [Vector; 2] {
    let mut pulls = [Vector::zeros(); 2];
    for (pull, columns) in pulls.iter_mut().zip([run[0]..run[1], run[2]..run[3]]) {
        for i in columns.map(|i| i as usize) {
            let (Some(chunk), Some(kept)) = (row.get_mut(i / CHUNK), kept.get(i)) else { break };
            let lane = i % CHUNK;
            *pull += Vector::new(chunk[3][lane], chunk[4][lane], chunk[5][lane]);
            for plane in 0..3 {
                chunk[plane][lane] = kept[plane];
                chunk[3 + plane][lane] = 0.0;
            }
        }
    }
    pulls
}
