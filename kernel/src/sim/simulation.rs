//! The simulation: one step function over three blocks of caller memory (model, state, scratch), and its
//! read-outs.
//!
//! Read-outs are pure: they commit nothing, so asking for them changes no bit. After a failure every call but
//! reset, load, the counters, the outcomes (whose status then says "faulted") and the digest repeats it.

use crate::body::path::{self, Path, Track};
use crate::body::pose::Vector;
use crate::body::projectile::{Body, Motion};
use crate::body::shape::Solid;
use crate::ground::error::{Code, Error, Failure, finite3, unit_quaternion};
use crate::ground::lanes::{self, CacheLine, InstructionSet};
use crate::ground::math;
use crate::memory::arrays;
use crate::memory::layout::Layout;
use crate::memory::model::Model;
use crate::memory::network::SegmentView;
use crate::memory::state::{COUNT_MAX, State};
use crate::memory::system::System;
use crate::memory::watch::{FirstContact, Latch, Outcome, OutcomeSet};
use crate::scene::features::Feature;
use crate::scene::parts::{AttachmentKind, Scene, StepLimits};
use crate::sheet::clamp::Clamps;
use crate::sheet::direction::Directions;
use crate::sim::start;
use crate::step::bands::Bands;
use crate::step::blocks;
use crate::step::energy::{self, Energy, Ply};
use crate::step::one_step;
use crate::step::pieces::Pieces;
use crate::step::readout::GreatestOfRow;
use crate::step::schedule;
use crate::step::slip::{self, Slip};
use crate::sweep::forces;
use crate::yarn::law;
use core::mem::MaybeUninit;

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
    /// Largest mean force over a window of `force_window`, N; until the first window is full the mean force
    /// over the time elapsed.
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
    /// The case of a ring.
    pub casing: [f64; 3],
    /// Mean force on each attachment over the last window of `force_window`, N; 0 before, and without
    /// slipping clamps.
    pub force: [f64; 4],
    /// Time at which each attachment let go, s; 0: it has not.
    pub let_go: [f64; 4],
}

/// Extremes of the fabric at the present time.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Fabric {
    /// Largest distance from the sheet's plane, or from its circle, of a node that live segments join to a
    /// support, m; 0 once all of the sheet has torn off. Of all nodes if the sheet is free, or if segments
    /// have failed and `track_detachment` is off.
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
    /// Contact solves (M8) that were given up; harmless below 1 % of the steps. `contact_residual` says how
    /// far they were off.
    pub unconverged: u64,
    /// Most Gauss-Seidel sweeps of one solve, at most 300 (4000 in a stack whose held nodes are hit): sweeps
    /// and, after 200 of them, passes of Newton's method.
    pub most_sweeps: u64,
    /// Most candidate nodes of one step.
    pub most_candidates: u64,
    /// Places for candidate nodes: `contact_capacity`, or every node modelled.
    pub candidate_capacity: u64,
    /// Deepest penetration met, m: rounding where the body does not turn, up to 4e-2 spacings where it does;
    /// also that of fixed nodes in a prescribed body, which passes through them.
    pub worst_penetration: f64,
    /// Iterations of the theta rule so far = passes over the yarns' forces; 0 with velocity Verlet.
    pub iterations: u64,
    /// Most iterations of one step.
    pub most_iterations: u64,
    /// Deepest that facing nodes of two separate plies have been through each other, m: rounding before the
    /// first hole.
    pub ply_penetration: f64,
    /// Steps in which the body met the sheet beyond the fine part of a graded network, where nodes may be
    /// too far apart to feel it: 0 in a run that is to be trusted.
    pub beyond_fine: u64,
    /// Greatest speed by which a contact has failed its law in a solve that was given up, m/s: a gap that
    /// closes too fast, a slip that friction should have stopped; 0 if all converged.
    pub contact_residual: f64,
}

/// Present state, whatever has happened before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Status {
    /// No contact in the last step.
    Flight = 0,
    /// Contact in the last step.
    Contact = 1,
    /// A failure is latched.
    Faulted = 2,
}

/// Outcomes latched so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcomes {
    /// Contact, flight or a failure.
    pub status: Status,
    /// All latched outcomes.
    pub mask: OutcomeSet,
    /// First contact: step count at whose start the first impulse acted; None before.
    pub first_contact: Option<u64>,
    /// Step and work of each latched outcome, by its number in [`crate::memory::watch::Outcome::ALL`].
    pub latched: [Option<Latch>; Outcome::ALL.len()],
}

/// A simulation on the caller's memory.
pub struct Sim<'a> {
    pub(crate) system: System<'a>,
}

impl<'a> Sim<'a> {
    /// A simulation of `scene` at step 0: sheet flat and at rest, projectile in its start motion.
    ///
    /// # Errors
    /// Everything [`Scene::check`] and [`Scene::step_limits`] refuse, too little memory, a projectile too
    /// fast for the step, too heavy for its energy to be a number, or overlapping a node. Memory is not
    /// written then.
    pub fn new(scene: &Scene, memory: &'a mut [CacheLine]) -> Result<Sim<'a>, Error> {
        let limits = Sim::check(scene, memory)?;
        let mut sim = Sim::NOTHING;
        sim.fill(scene, limits, memory)?;
        sim.start();
        Ok(sim)
    }

    /// [`Sim::new`] in a given place, without a copy of the simulation on the stack: that would be some four
    /// kilobytes.
    ///
    /// # Errors
    /// As for [`Sim::new`]. The place is not written then.
    pub fn new_in<'p>(
        place: &'p mut MaybeUninit<Sim<'a>>,
        scene: &Scene,
        memory: &'a mut [CacheLine],
    ) -> Result<&'p mut Sim<'a>, Error> {
        let limits = Sim::check(scene, memory)?;
        let sim = place.write(Sim::NOTHING);
        sim.fill(scene, limits, memory)?;
        sim.start();
        Ok(sim)
    }

    /// Content of a place before a simulation is made there.
    const NOTHING: Sim<'a> = Sim { system: System::NOTHING };

    /// Checks the scene and the memory for it.
    #[inline(never)]
    fn check(scene: &Scene, memory: &[CacheLine]) -> Result<StepLimits, Error> {
        // Before the step limit, which draws every segment: a sheet that fits no memory is refused at once.
        arrays::check(memory, &Layout::of(scene)?)?;
        let limits = scene.step_limits()?;
        start::check_body(scene, limits, u64::MAX)?;
        Ok(limits)
    }

    /// Takes the scene and the memory, which have been found right, and fills it.
    #[inline(never)]
    fn fill(&mut self, scene: &Scene, limits: StepLimits, memory: &'a mut [CacheLine]) -> Result<(), Error> {
        let system = &mut self.system;
        system.network.scene = *scene;
        system.network.layout = Layout::of_sound(scene)?;
        system.solid = Solid::of_scene(scene);
        system.network.model = Model::of(scene, limits, &system.solid);
        system.state = State::at_start(start::place_body(scene, &system.network.model, &system.solid)?);
        system.network.directions = Directions::of(scene, limits.dt);
        system.network.clamps = Clamps::of(scene, system.network.model.window_steps);
        system.network.fetches = system.network.layout.exceeds_caches();
        system.network.instructions = InstructionSet::widest();
        system.network.block_steps = schedule::block_steps(&system.network.layout, system.network.instructions);
        system.network.arrays.carve(&mut system.contacts, memory, &system.network.layout)?;
        system.network.fill_model()?;
        system.clear_state();
        Ok(())
    }

    /// Back to step 0 as after [`Sim::new`]. Clears a failure, motion and history set by hand, and the
    /// external load.
    pub fn reset(&mut self) {
        // Accepted once, so accepted again.
        if let Ok(body) = start::place_body(&self.system.network.scene, &self.system.network.model, &self.system.solid)
        {
            self.system.state = State::at_start(body);
        }
        self.system.clear_state();
        self.start();
    }

    fn start(&mut self) {
        one_step::start_forces(&mut self.system.network);
        energy::start_audit(&mut self.system.network, &mut self.system.state);
    }

    /// One step. After a failure: the same failure again.
    pub fn step(&mut self) -> Result<(), Failure> {
        self.system.sound()?;
        let result = one_step::step_once(&mut self.system);
        self.system.latch(result)
    }

    /// `steps` steps. Stops at the first failure.
    pub fn advance(&mut self, steps: u64) -> Result<(), Failure> {
        self.system.sound()?;
        let mut taken = 0;
        while taken < steps {
            taken += self.step_some(steps - taken)?;
        }
        Ok(())
    }

    /// A block of steps (`step/blocks.rs`) if one can be taken within `most`, otherwise one step. Returns how
    /// many.
    fn step_some(&mut self, most: u64) -> Result<u64, Failure> {
        if !Feature::Blocks.is_built() {
            return self.step().map(|()| 1);
        }
        let steps = blocks::step_block(&mut self.system, most);
        match self.system.latch(steps)? {
            0 => self.step().map(|()| 1),
            steps => Ok(steps),
        }
    }

    /// Up to `steps` steps, ending after the step at which any outcome of `until` is latched (at once if it
    /// already is). Returns the steps taken.
    pub fn advance_until(&mut self, until: impl Into<OutcomeSet>, steps: u64) -> Result<u64, Failure> {
        self.system.sound()?;
        let until = until.into();
        let mut taken = 0;
        while taken < steps && !self.system.state.watch.mask().has(until) {
            taken += self.step_some(steps - taken)?;
        }
        Ok(taken)
    }

    /// Moves a prescribed body along `path` for `steps` steps. Call again with the same path to go on along
    /// it: the bits do not depend on how the path is split.
    ///
    /// # Errors
    /// The body is not prescribed; the path starts elsewhere in time, is shorter than asked for, not finite,
    /// or too fast.
    pub fn follow(&mut self, path: &Path, steps: u64) -> Result<(), Error> {
        self.start_path(path, steps)?;
        self.advance(steps).map_err(Into::into)
    }

    /// Starts a path, or goes on along it, for `steps` steps to come: [`Sim::follow`] without the steps.
    ///
    /// # Errors
    /// Errors of [`Sim::follow`] before its first step.
    pub fn start_path(&mut self, path: &Path, steps: u64) -> Result<(), Error> {
        self.system.sound()?;
        if self.system.network.scene.is_free() {
            return Err(Error::plain(Code::WrongDrive, "drive"));
        }
        let step = self.system.state.step;
        let bad = |field, value: u64, limit: u64| Error::new(Code::BadPath, field, value as f64, limit as f64);
        let Some(last) = path.first.checked_add(path.steps).filter(|&last| path.steps > 0 && last <= COUNT_MAX) else {
            return Err(bad("path.steps", path.steps, 1));
        };
        let end = self.body_of_path(path)?;
        let track = &self.system.state.track;
        let continued = track.steps == path.steps && track.first == path.first && track.end == end && step < last;
        if !continued && path.first != step {
            return Err(bad("path.first", path.first, step));
        }
        if steps > last - step {
            return Err(bad("steps", steps, last - step));
        }
        if !continued {
            let track = Track { first: path.first, steps: path.steps, start: self.path_start(), end };
            self.system.network.model.check_track(&track)?;
            self.system.state.track = track;
        }
        Ok(())
    }

    /// The body as a path starts from it: with the rates the path before ended with, if one ended just here.
    fn path_start(&self) -> Body {
        let (body, track) = (self.system.state.body, &self.system.state.track);
        if track.steps > 0 && track.first + track.steps == self.system.state.step {
            Body { velocity: track.end.velocity, angular_velocity: track.end.angular_velocity, ..body }
        } else {
            body
        }
    }

    fn body_of_path(&self, path: &Path) -> Result<Body, Error> {
        finite3("path.position", path.end.position)?;
        finite3("path.velocity", path.end.velocity)?;
        unit_quaternion("path.orientation", path.end.orientation)?;
        finite3("path.angular_velocity", path.end.angular_velocity)?;
        Ok(Body::of(&path::into_sheet(&self.system.network.model.pose, &path.end)))
    }

    /// Sets the force, N, and torque, N m, that act on a free body from now on, host's axes (gravity, drag, a
    /// host).
    pub fn set_external_load(&mut self, force: [f64; 3], torque: [f64; 3]) -> Result<(), Error> {
        self.system.sound()?;
        finite3("external.force", force)?;
        finite3("external.torque", torque)?;
        if !self.system.network.scene.is_free() {
            return Err(Error::plain(Code::WrongDrive, "drive"));
        }
        let force = Vector::from(self.system.network.model.pose.vector_in(force));
        let torque = Vector::from(self.system.network.model.pose.vector_in(torque));
        // What is a number in the host's axes may be none in the sheet's.
        finite3("external.force", force.into())?;
        finite3("external.torque", torque.into())?;
        self.system.network.scene.symmetry.check_load(&force, &torque)?;
        self.system.state.force = force.component_mul(&self.system.network.scene.symmetry.force_mask());
        self.system.state.torque = torque.component_mul(&self.system.network.scene.symmetry.torque_mask());
        Ok(())
    }

    /// Starts from given positions, m, and velocities, m/s, at t_0 (3 per node, node by node, host's frame):
    /// restart from another code, pre-stretched sheets. Fixed nodes stay where this puts them; their velocity
    /// must be 0.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite or beyond 1e30 spacings (a step), a moving fixed node, a
    /// node inside the projectile (a fixed one in a prescribed body may be), plies through each other, or a
    /// step already taken.
    pub fn set_motion(&mut self, positions: &[f64], velocities: &[f64]) -> Result<(), Error> {
        start::set_motion(&mut self.system, positions, velocities)
    }

    /// Gives every segment the largest stretch it has ever had (1 or less: undamaged), in the order of the
    /// segments' numbers: a pre-damaged sheet. Call before [`Sim::set_motion`] if both are used.
    pub fn set_largest_stretch(&mut self, stretches: &[f64]) -> Result<(), Error> {
        start::set_largest_stretch(&mut self.system, stretches)
    }

    /// Cuts the sheet into `of` bands of rows for threads of the caller's. `scratch`: as many lines as
    /// [`Layout::band_lines`] says, content does not matter. `steps`: how many steps will be taken at least
    /// before the bands are dropped; a sheet that is too large for the caches takes eight of these in one
    /// block of nine passes. 0 if it is not known. If fewer are taken, dropping the bands completes the
    /// block: up to eight steps more.
    ///
    /// # Errors
    /// More bands than [`crate::memory::layout::MAX_BANDS`] or none, too little scratch or more than there
    /// can be, the theta rule, a latched failure; bands are not built.
    pub fn bands<'s>(&'s mut self, scratch: &'s mut [CacheLine], of: u32, steps: u64) -> Result<Bands<'s, 'a>, Error> {
        Feature::Bands.needed_by("bands")?;
        Bands::of(&mut self.system, scratch, of, steps)
    }

    /// Steps every row, also those still exactly at rest; the bits are the same. For measuring what skipping
    /// saves.
    pub fn step_every_row(&mut self) {
        self.system.network.skip_rest = false;
    }

    /// Uses another instruction set than the widest this machine has; the bits are the same. One that it
    /// lacks is refused.
    pub fn use_instructions(&mut self, set: InstructionSet) -> Result<(), Error> {
        if !set.available() {
            return Err(Error::plain(Code::UnknownChoice, "instruction_set"));
        }
        self.system.network.instructions = set;
        self.system.network.block_steps = schedule::block_steps(&self.system.network.layout, set);
        Ok(())
    }

    /// The instruction set in use.
    pub fn instructions(&self) -> InstructionSet {
        self.system.network.instructions
    }

    /// The scene this simulation was made with.
    pub fn scene(&self) -> &Scene {
        &self.system.network.scene
    }

    /// Sizes.
    pub fn layout(&self) -> &Layout {
        &self.system.network.layout
    }

    /// Steps taken.
    pub fn step_count(&self) -> u64 {
        self.system.state.step
    }

    /// Time, s: step count times dt.
    pub fn time(&self) -> f64 {
        self.system.state.step as f64 * self.system.network.model.limits.dt
    }

    /// The time step and its limits.
    pub fn step_limits(&self) -> StepLimits {
        self.system.network.model.limits
    }

    /// The latched failure, if any.
    pub fn failure(&self) -> Option<Failure> {
        self.system.failure
    }

    /// The projectile, host's frame: pose at t_n, rates at t_{n-1/2} (constant between impulses; on a path
    /// the means over the last step; with the theta rule the rates at t_n).
    pub fn projectile(&self) -> Result<Motion, Failure> {
        self.system.sound()?;
        Ok(path::out_of_sheet(&self.system.network.model.pose, &self.system.state.body.motion()))
    }

    /// Contact sums.
    pub fn contact(&self) -> Result<Contact, Failure> {
        self.system.sound()?;
        let (sums, steps) = (&self.system.state.sums, self.system.state.step);
        // No window has been closed before the first is full: a run shorter than that still has its mean
        // force.
        let force_peak = if steps > 0 && steps < self.system.network.model.window_steps {
            math::length(sums.window.into()) / (steps as f64 * self.system.network.model.limits.dt)
        } else {
            sums.force_peak
        };
        Ok(Contact {
            impulse: self.system.network.model.pose.vector_out(sums.impulse.into()),
            angular_impulse: self.system.network.model.pose.vector_out(sums.angular_impulse.into()),
            work: sums.work,
            loss: sums.loss,
            force_peak,
        })
    }

    /// Impulses on the supports; zero without `track_support`.
    pub fn support(&self) -> Result<Support, Failure> {
        self.system.sound()?;
        let (sums, model, mut total) = (&self.system.state.sums, &self.system.network.model, Vector::zeros());
        let mut impulse_out = |sum: Vector| {
            let impulse = sum * model.unit_impulse;
            total += impulse;
            model.pose.vector_out(impulse.into())
        };
        Ok(Support {
            attachments: sums.support.map(&mut impulse_out),
            casing: impulse_out(sums.casing.impulse),
            total: model.pose.vector_out(total.into()),
            force: sums.clamps.support_force,
            let_go: sums.clamps.let_go.map(|step| step as f64 * model.limits.dt),
        })
    }

    /// The energies, with a full pass over the sheet. Commits nothing.
    pub fn energy(&self) -> Result<Energy, Failure> {
        energy::energy(&self.system)
    }

    /// Failed segments and energies of one ply, with a pass over it. Of a single sheet ply 0 is all. Commits
    /// nothing.
    ///
    /// # Errors
    /// No such ply; a latched failure.
    pub fn ply(&self, ply: u32) -> Result<Ply, Error> {
        self.system.sound()?;
        energy::ply(&self.system.network, self.system.state.sums.loaded, ply)
    }

    /// At how many crossings yarns would slip, with a pass over the sheet. Commits nothing.
    /// `thickness`: of the ply, m, > 0. `friction`: coefficient between yarns, >= 0. `adhesion`: the force
    /// f_0 at a crossing without pressure, N, >= 0.
    ///
    /// # Errors
    /// A number out of its range; a curved sheet; a build without the feature `slip`; a latched failure.
    pub fn slip(&self, thickness: f64, friction: f64, adhesion: f64) -> Result<Slip, Error> {
        Feature::Slip.needed_by("slip")?;
        slip::slip(&self.system, thickness, friction, adhesion)
    }

    /// Linear momentum that the balance of fabric, projectile, supports and loads does not close by, N s,
    /// host's axes. Meaningful with `track_support` (or without fixed nodes). Commits nothing.
    pub fn momentum_residual(&self) -> Result<[f64; 3], Failure> {
        energy::momentum_residual(&self.system)
    }

    /// Deflection and stretch, with a full pass over the sheet. Changes nothing but scratch.
    pub fn fabric(&mut self) -> Result<Fabric, Failure> {
        self.system.sound()?;
        // Every node of a free sheet counts.
        let pieces = if self.system.network.scene.attachment.kind == AttachmentKind::Free {
            None
        } else {
            Some(Pieces::of(&mut self.system.network, self.system.failed_segments > 0))
        };
        let (mut deflection, mut largest) = (0.0, 0.0);
        for j in 0..self.system.network.layout.nodes_y {
            for i in 0..self.system.network.layout.nodes_x {
                let z = math::abs(self.system.network.deflection(i, j));
                let held = pieces.as_ref().is_none_or(|pieces| pieces.hold(pieces.of_node(&self.system.network, i, j)));
                if held {
                    deflection = math::max(z, deflection);
                }
            }
            let row = GreatestOfRow { network: &self.system.network, j };
            largest = math::max(lanes::dispatch(self.system.network.instructions, row), largest);
        }
        Ok(Fabric {
            max_deflection: deflection * self.system.network.scene.sheet.spacing,
            max_stretch: law::stretch(largest),
        })
    }

    /// Counters; also after a failure.
    pub fn counters(&self) -> Counters {
        let sums = &self.system.state.sums;
        Counters {
            steps: self.system.state.step,
            failed_segments: self.system.failed_segments,
            contacts: sums.contacts,
            unconverged: sums.unconverged,
            most_sweeps: sums.most_sweeps,
            most_candidates: sums.most_candidates,
            candidate_capacity: self.system.network.layout.candidates as u64,
            worst_penetration: sums.worst_penetration,
            iterations: sums.iterations,
            most_iterations: sums.most_iterations,
            ply_penetration: sums.ply_penetration,
            beyond_fine: sums.beyond_fine,
            contact_residual: sums.contact_residual,
        }
    }

    /// Outcomes latched so far.
    pub fn outcomes(&self) -> Outcomes {
        let watch = &self.system.state.watch;
        let status = match self.system.failure {
            Some(_) => Status::Faulted,
            None if self.system.state.sums.contacts > 0 => Status::Contact,
            None => Status::Flight,
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
        self.system.sound()?;
        self.copy_nodes(out, |sim, i, j| {
            sim.system.network.model.pose.point_out(sim.system.network.position(i, j).into())
        })
    }

    /// Velocities at t_n, m/s, 3 per node modelled, host's axes: the stored half-step velocities and half a
    /// step of the forces, or those that the theta rule stores.
    pub fn copy_velocities(&self, out: &mut [f64]) -> Result<(), Error> {
        self.system.sound()?;
        self.copy_nodes(out, |sim, i, j| {
            let (_, v) = sim.system.network.node(i, j);
            let stored = sim.system.network.layout.has(Feature::Theta) || sim.system.network.is_fixed(i, j);
            let viscous = sim.system.network.layout.has(Feature::Viscosity);
            let a = if stored {
                [0.0; 3]
            } else {
                forces::acceleration(&sim.system.network, sim.system.state.sums.loaded, viscous, i, j)
            };
            let unit = sim.system.network.model.unit_speed;
            let v = [0, 1, 2].map(|k| (v[k] + 0.5 * a[k]) * unit);
            sim.system.network.model.pose.vector_out(v)
        })
    }

    /// alpha at t_n of every segment in the order of their numbers: 1 whole, 0 failed.
    pub fn copy_damage(&self, out: &mut [f64]) -> Result<(), Error> {
        self.system.sound()?;
        self.copy_segments(out, |sim, segment| {
            let q = segment.twice_strain();
            let largest = math::max(
                sim.system.network.rate_law(segment.axis, sim.system.state.sums.loaded).seen_at(q),
                segment.history,
            );
            sim.system.network.law_of(segment).alpha(segment.damage_rate, largest)
        })
    }

    /// Stretch at t_n of every segment in the order of their numbers.
    pub fn copy_stretch(&self, out: &mut [f64]) -> Result<(), Error> {
        self.system.sound()?;
        self.copy_segments(out, |_, segment| law::stretch(segment.twice_strain()))
    }

    fn copy_segments(&self, out: &mut [f64], value: impl Fn(&Self, &SegmentView) -> f64) -> Result<(), Error> {
        start::check_length("out", out, self.system.network.layout.segments())?;
        let mut slots = out.iter_mut();
        self.system.network.layout.for_each_segment(|axis, i, j| {
            if let (Some(segment), Some(slot)) = (self.system.network.segment(axis, i, j), slots.next()) {
                *slot = value(self, &segment);
            }
        });
        Ok(())
    }

    fn copy_nodes(&self, out: &mut [f64], value: impl Fn(&Self, usize, usize) -> [f64; 3]) -> Result<(), Error> {
        start::check_length("out", out, 3 * self.system.network.layout.nodes())?;
        let (slots, _) = out.as_chunks_mut::<3>();
        for (k, slot) in slots.iter_mut().enumerate() {
            let (i, j) = self.system.network.layout.column_and_row(k);
            *slot = value(self, i, j);
        }
        Ok(())
    }
}
