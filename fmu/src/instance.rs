//! One FMU instance: what both versions of the interface do.
//!
//! Time is a count of ticks of the constant internal step: a communication step from t to t + h ends at tick
//! round((t + h - start)/dt). Nothing drifts, and how the host cuts its time does not matter in drive `free`.

use crate::capsule::Capsule;
use crate::coupling::{self, Plan, Refusal, Times};
use crate::kept::{Discrete, Kept, Phase, States};
use crate::log::{Category, Line, Log, Status, line};
use crate::memory::Block;
use crate::parameters::Parameters;
use crate::table::{Id, MOST_ELEMENTS, PLIES_SHOWN, Role, VARIABLES, Variable};
use fabric_capsule::Call;
use fabric_host::in_our_environment;
use fabric_kernel::Solid;
use fabric_kernel::TEST_INTERVAL;
use fabric_kernel::outputs::{Get, OUTPUTS, Output, Readings};
use fabric_kernel::{Body, Inertia};
use fabric_kernel::{Code, number};
use fabric_kernel::{Energy, Error, Failure, Layout, MOST_GAINED, Motion, Path, Ply, Sim, math};
use fabric_kernel::{Outcome, OutcomeSet};

/// Results of a pass over the sheet, kept until the next step.
#[derive(Clone, Copy, Default)]
struct Cache {
    readings: Readings,
    /// The first that is shown, and all.
    plies: Option<(u32, [Ply; PLIES_SHOWN])>,
}

/// The simulation and its memory. The simulation is declared, and so dropped, first.
pub struct Running {
    /// The simulation; its slices lie in the block.
    pub sim: Sim<'static>,
    _block: Block,
}

impl Running {
    /// Memory and simulation for a scene.
    pub fn new(scene: &fabric_kernel::Scene) -> Result<Running, Trouble> {
        let layout = Layout::of(scene).map_err(Trouble::Refused)?;
        let mut block = Block::new(layout.lines()).ok_or(Trouble::OutOfMemory(layout.bytes()))?;
        // SAFETY: carved once; `Running` keeps the block as long as the simulation, which is dropped before
        // it.
        let memory = unsafe { block.carve() };
        let sim = Sim::new(scene, memory).map_err(Trouble::Refused)?;
        Ok(Running { sim, _block: block })
    }
}

/// Why there is no simulation.
pub enum Trouble {
    /// The kernel says what is wrong.
    Refused(Error),
    /// `calloc` did not give so many bytes.
    OutOfMemory(usize),
}

/// How a communication step ended.
pub struct StepEnd {
    /// Status of the call.
    pub status: Status,
    /// The discrete outputs have changed.
    pub event: bool,
    /// The host is asked to end the simulation.
    pub terminate: bool,
    /// The step ended before t + h.
    pub early: bool,
}

impl StepEnd {
    fn refused(status: Status) -> StepEnd {
        StepEnd { status, event: false, terminate: false, early: false }
    }
}

/// Whether a step may end before t + h.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Early {
    /// Never.
    No,
    /// At any event.
    AtEvents,
    /// At an outcome, if `stop_on_event` is set.
    ToStop,
}

/// One instance.
pub struct Instance {
    /// The host's logger.
    pub log: Log,
    /// Everything but the simulation.
    pub kept: Kept,
    /// The simulation: from the end of initialisation on, and before that while the parameters are those it
    /// was made of, for hosts that read outputs.
    pub running: Option<Running>,
    /// States the host holds.
    pub states: States,
    /// FMI 3.0: the host handles events.
    pub event_mode_used: bool,
    /// FMI 3.0: a step may end early.
    pub early_return_allowed: bool,
    /// Capsule of the simulation, if the host requests one.
    pub capsule: Capsule,
    cache: Cache,
    /// It has been logged that quaternions are normalised.
    normalised_logged: bool,
    /// What has been logged: that the energy balance has a residual, that energy came from nothing.
    open_logged: [bool; 2],
    /// It has been logged that host and fabric differ.
    coupling_logged: bool,
}

impl Instance {
    /// A new instance.
    pub fn new(log: Log) -> Instance {
        Instance {
            log,
            kept: Kept::default(),
            running: None,
            states: States::default(),
            event_mode_used: false,
            early_return_allowed: false,
            capsule: Capsule::default(),
            cache: Cache::default(),
            normalised_logged: false,
            open_logged: [false; 2],
            coupling_logged: false,
        }
    }

    /// Runs `work` if the instance is in one of `phases`.
    pub(crate) fn within(&mut self, function: &str, phases: u32, work: impl FnOnce(&mut Instance) -> Status) -> Status {
        match self.check(function, phases) {
            Ok(()) => in_our_environment(|| work(self)),
            Err(refused) => refused,
        }
    }

    /// Refuses a call if the instance is in none of `phases`.
    pub(crate) fn check(&self, function: &str, phases: u32) -> Result<(), Status> {
        if self.kept.phase as u32 & phases != 0 {
            return Ok(());
        }
        Err(self.refuse_field(Category::Error, (function, "not allowed in this state")))
    }

    /// Refuses a call: says why and returns Error.
    pub fn refuse(&self, text: &str) -> Status {
        self.refuse_as(Category::Error, text)
    }

    /// Refuses a call with Error or Discard.
    fn refuse_as(&self, category: Category, text: &str) -> Status {
        self.log.say(category, text);
        if category == Category::Discard { Status::Discard } else { Status::Error }
    }

    /// Logs once, as an event, that a quaternion of nearly unit length is taken normalised: a host that
    /// integrates one gives such.
    fn log_normalised(&mut self, normalised: bool) {
        if normalised && !self.normalised_logged {
            self.normalised_logged = true;
            self.log.say(Category::Event, "projectile.orientation: normalised here and from now on");
        }
    }

    /// Refuses with a name and a reason.
    pub(crate) fn refuse_field(&self, category: Category, (field, reason): (&str, &str)) -> Status {
        let between = if field.is_empty() { "" } else { ": " };
        self.refuse_as(category, &line(format_args!("{field}{between}{reason}")))
    }

    /// Refuses by the kernel's words, with the name that the field's variable has here. The end of the
    /// kernel's path is where the host's motion leads.
    fn refuse_error(&self, category: Category, error: &Error) -> Status {
        let known = VARIABLES.iter().find(|variable| match error.field.strip_prefix("path.") {
            Some(name) => variable.name.strip_prefix("projectile.") == Some(name),
            None => variable.field().is_some_and(|field| field.name == error.field),
        });
        self.refuse_as(category, &Error { field: known.map_or(error.field, |known| known.name), ..*error }.text())
    }

    /// Refuses a value outside the range that the description names.
    fn refuse_range(&self, variable: &Variable, value: f64) -> Status {
        let error = Error::new(Code::OutOfRange, variable.name, value, 0.0);
        self.refuse(&error.text_within(Some(variable.limits())))
    }

    /// Times of the experiment.
    pub fn set_experiment(&mut self, start: f64, stop: Option<f64>) -> Status {
        if !start.is_finite() || stop.is_some_and(|stop| !(stop.is_finite() && stop >= start)) {
            return self.refuse("start or stop time: not a finite number, or stop before start");
        }
        self.kept.start_time = start;
        self.kept.time = start;
        self.kept.stop_time = stop.unwrap_or(f64::INFINITY);
        Status::Ok
    }

    /// Enters initialisation.
    pub fn enter_initialization(&mut self) -> Status {
        self.kept.phase = Phase::Initialization;
        Status::Ok
    }

    /// Begins the simulation. If it is refused nothing has changed, and the host may correct its parameters
    /// and try again.
    pub fn exit_initialization(&mut self) -> Status {
        if let Err(status) = self.make() {
            return status;
        }
        if let Some(Running { sim, .. }) = &mut self.running
            && self.kept.parameters.capsule()
        {
            self.capsule.begin(sim, &self.log);
        }
        if let Some(Running { sim, .. }) = &self.running {
            let Layout { nodes_x, nodes_y, .. } = *sim.layout();
            let bytes = sim.layout().bytes();
            self.log
                .say(Category::Event, &line(format_args!("simulation of {nodes_x} x {nodes_y} nodes, {bytes} bytes")));
        }
        self.kept.phase = if self.event_mode_used { Phase::Event } else { Phase::Step };
        Status::Ok
    }

    /// Makes the simulation of the parameters, unless there is one.
    fn make(&mut self) -> Result<(), Status> {
        if self.running.is_some() {
            return Ok(());
        }
        match (Running::new(self.kept.parameters.scene()), self.kept.parameters.out_of_range()) {
            (Ok(running), None) => {
                let (start, dt) = (self.kept.start_time, running.sim.step_limits().dt);
                if f64::EPSILON * math::abs(start) > dt {
                    let [start, dt, most] = [start, dt, dt / f64::EPSILON].map(number);
                    return Err(self.refuse(&line(format_args!(
                        "start time: near {start} s numbers are farther apart than an internal step, {dt} s: at most {most} s"
                    ))));
                }
                self.running = Some(running);
                self.cache = Cache::default();
                Ok(())
            }
            (Ok(_), Some((variable, value))) => Err(self.refuse_range(variable, value)),
            (Err(Trouble::Refused(error)), _) => Err(self.refuse_error(Category::Error, &error)),
            (Err(Trouble::OutOfMemory(bytes)), _) => Err(self.out_of_memory(bytes)),
        }
    }

    /// The simulation once it has begun. One that was made before, to be read, is no part of a state.
    pub fn begun(&self) -> Option<&Running> {
        self.running.as_ref().filter(|_| self.kept.phase as u32 & Phase::SETTING_UP == 0)
    }

    /// Refuses a call for lack of memory with status Error, not Fatal: other instances are not affected.
    pub fn out_of_memory(&self, bytes: usize) -> Status {
        self.refuse(&line(format_args!("out of memory: there are no {bytes} bytes for it")))
    }

    /// From stepping to handling events.
    pub(crate) fn enter_event_mode(&mut self) -> Status {
        if !self.event_mode_used {
            return self.refuse("fmi3EnterEventMode: instantiated without event mode");
        }
        self.kept.phase = Phase::Event;
        self.show();
        Status::Ok
    }

    /// From handling events to stepping.
    pub(crate) fn enter_step_mode(&mut self) -> Status {
        self.kept.phase = Phase::Step;
        Status::Ok
    }

    /// Ends the run; values may still be read.
    pub(crate) fn terminate(&mut self) -> Status {
        self.end_capsule();
        self.kept.phase = Phase::Terminated;
        Status::Ok
    }

    /// Back to just after instantiation.
    pub fn reset(&mut self) -> Status {
        self.end_capsule();
        self.running = None;
        self.kept = Kept::default();
        self.cache = Cache::default();
        (self.open_logged, self.coupling_logged) = ([false; 2], false);
        Status::Ok
    }

    /// Ends the capsule, if one is written.
    fn end_capsule(&mut self) {
        self.capsule.end(self.running.as_ref().map(|running| &running.sim));
    }

    /// Takes over what a saved state held; the simulation is already in that state.
    pub fn restored(&mut self, kept: &Kept) {
        self.kept = *kept;
        self.cache = Cache::default();
    }

    // ---- Variables ----------------------------------------------------------------------------------------

    /// All elements of a variable.
    pub fn get(&mut self, variable: &Variable, values: &mut [f64; MOST_ELEMENTS]) -> Status {
        if !variable.role.is_output() {
            self.kept.parameters.get(variable, values);
            return Status::Ok;
        }
        if let Err(status) = self.make() {
            return status;
        }
        let failure = self.running.as_ref().and_then(|running| running.sim.failure());
        let failure = failure.filter(|_| variable.id != Id::Status);
        match failure.map_or_else(|| self.output(variable.id, values), Err) {
            Ok(()) => Status::Ok,
            Err(failure) => self.refuse(&line(format_args!("{}: {failure}", variable.name))),
        }
    }

    /// Whether an element may be set to a value now. Says why not.
    pub fn may_set(&self, variable: &Variable, value: f64) -> Status {
        let phases = match variable.role {
            Role::Fixed => Phase::SETTING_UP,
            Role::Input | Role::Tunable => Phase::SETTABLE,
            Role::Continuous | Role::Discrete => 0,
        };
        if phases & self.kept.phase as u32 == 0 {
            let reason = if phases == 0 { "an output cannot be set" } else { "cannot be set in this state" };
            return self.refuse_field(Category::Error, (variable.name, reason));
        }
        if !Parameters::acceptable(variable, value) {
            return self.refuse_range(variable, value);
        }
        Status::Ok
    }

    /// Sets one element; asked before with [`Instance::may_set`].
    pub fn set(&mut self, variable: &Variable, element: usize, value: f64) {
        if variable.role == Role::Fixed {
            self.running = None;
        }
        self.kept.parameters.set(variable, element, value);
    }

    fn output(&mut self, id: Id, values: &mut [f64; MOST_ELEMENTS]) -> Result<(), Failure> {
        *values = [0.0; MOST_ELEMENTS];
        let kept = &self.kept;
        // It has been made, if need be for this.
        let Some(Running { sim, .. }) = &mut self.running else { return Ok(()) };
        let cache = &mut self.cache;
        let first = kept.parameters.ply_first();
        let time_of = |step: Option<u64>| step.map_or(0.0, |n| kept.start_time + n as f64 * sim.step_limits().dt);
        match id {
            Id::ForceMean => copy(values, &kept.force_mean),
            Id::TorqueMean => copy(values, &kept.torque_mean),
            Id::InterfaceResidual => copy(values, &[kept.interface_residual]),
            Id::InterfaceGap => copy(values, &[kept.interface_gap]),
            Id::Output(row) => match OUTPUTS.get(row) {
                Some(&Output { get: Get::Ply(of), .. }) => copy(values, &cache.plies(sim, first)?.map(|ply| of(&ply))),
                Some(output) => copy(values, &cache.readings.read(sim, output)?),
                None => {}
            },
            Id::Status => copy(values, &[f64::from(kept.shown.status)]),
            Id::Happened(event) => copy(values, &[f64::from(kept.shown.happened >> event & 1)]),
            // The time of an event is shown with its Boolean.
            Id::HappenedAt(event) if kept.shown.happened >> event & 1 == 0 => {}
            Id::HappenedAt(0) => copy(values, &[time_of(sim.outcomes().first_contact)]),
            Id::HappenedAt(event) => {
                let latch = sim.outcomes().latched.into_iter().nth(event - 1).flatten();
                copy(values, &[time_of(latch.map(|latch| latch.step))]);
            }
            _ => {}
        }
        Ok(())
    }

    // ---- Stepping -----------------------------------------------------------------------------------------

    /// The discrete outputs as they are now.
    fn discrete(&self) -> Discrete {
        let Some(Running { sim, .. }) = &self.running else { return Discrete::default() };
        let outcomes = sim.outcomes();
        let first = u32::from(outcomes.first_contact.is_some());
        Discrete { status: outcomes.status as u32, happened: first | outcomes.mask.bits() << 1 }
    }

    /// Shows the host the discrete outputs as they are now.
    pub fn show(&mut self) {
        self.kept.shown = self.discrete();
    }

    /// A communication step from t to t + h. Discard: nothing has changed.
    pub fn do_step(&mut self, t: f64, h: f64, early: Early) -> StepEnd {
        if let Some(reason) = self.bad_times(t, h) {
            return StepEnd::refused(self.refuse(&reason));
        }
        let Some(Running { sim, .. }) = &self.running else {
            return StepEnd::refused(self.refuse("there is no simulation"));
        };
        let (dt, start) = (sim.step_limits().dt, self.kept.start_time);
        let last_tick = math::round((t + h - start) / dt);
        if last_tick.is_nan() || last_tick >= MOST_TICKS {
            return StepEnd::refused(self.refuse("doStep: t + h is too many internal steps away"));
        }
        let now = sim.step_count();
        // A tick count is a whole number below 2^52.
        let ticks = (last_tick as u64).saturating_sub(now);
        let times = Times { now: start + now as f64 * dt - t, end: start + last_tick * dt - t };

        let mut plan = None;
        if self.kept.parameters.prescribed() {
            // Also a step of no ticks refuses bad input.
            let (force, driven) = (self.kept.force_mean, self.kept.driven);
            match coupling::plan(&self.kept.parameters, sim, &times, ticks, force, driven) {
                Ok(made) => {
                    self.log_normalised(made.normalised);
                    plan = Some(made);
                }
                Err(refusal) => return StepEnd::refused(self.refuse_input(&refusal)),
            }
        }
        let before = self.sums();
        // Before the step: if it fails, what was read earlier is not the state any more.
        self.cache = Cache::default();
        let end = match self.advance(plan.as_ref().map(|plan| plan.path), ticks, early) {
            Ok(end) => end,
            Err(status) => {
                if self.kept.phase == Phase::Faulted {
                    self.show();
                }
                return StepEnd::refused(status);
            }
        };
        let reached = if end.early { start + self.steps() as f64 * dt } else { t + h };
        self.account(dt, before, plan.as_ref());
        self.kept.time = reached;
        self.kept.terminated = end.terminate;
        let event = self.discrete() != self.kept.shown;
        // A host that ends with this step comes to no event mode any more.
        if !self.event_mode_used || end.terminate {
            self.show();
        }
        StepEnd { event, ..end }
    }

    fn refuse_input(&self, refusal: &Refusal) -> Status {
        match *refusal {
            Refusal::Input(field, reason) => self.refuse_field(Category::Discard, (field, reason)),
            Refusal::TooFar(gap, positions) => {
                let [[x, y, z], [u, v, w]] = positions.map(|place| place.map(number));
                let [gap, limit] = [gap, self.kept.parameters.scene().sheet.spacing].map(number);
                let text = line(format_args!(
                    "projectile.position, orientation: at ({x}, {y}, {z}) m, {gap} m from where the fabric has the body, ({u}, {v}, {w}) m; \
                     the limit is sheet.spacing, {limit} m"
                ));
                self.refuse_as(Category::Discard, &text)
            }
        }
    }

    /// Why a step cannot be from t to t + h.
    fn bad_times(&self, t: f64, h: f64) -> Option<Line> {
        if !(t.is_finite() && h.is_finite() && h > 0.0) {
            return Some(line(format_args!("doStep: the step size must be greater than zero and both times finite")));
        }
        if t + h == t {
            let [t, h] = [t, h].map(number);
            return Some(line(format_args!("doStep: t + h is t: {h} s is less than numbers near {t} s are apart")));
        }
        // The host may add up its steps, and forms h as a difference of two times.
        let slack = 1e-3 * h + 4.0 * f64::EPSILON * if t < 0.0 { -t } else { t };
        let off = t - self.kept.time;
        if off > slack || off < -slack {
            let [t, ended, off] = [t, self.kept.time, off].map(number);
            return Some(line(format_args!(
                "doStep: the communication point {t} s is not where the last step ended, {ended} s: it is off by {off} s"
            )));
        }
        if t + h > self.kept.stop_time + slack {
            let [end, stop] = [t + h, self.kept.stop_time].map(number);
            return Some(line(format_args!("doStep: the step leads to {end} s, past the stop time, {stop} s")));
        }
        None
    }

    fn steps(&self) -> u64 {
        self.running.as_ref().map_or(0, |running| running.sim.step_count())
    }

    /// Impulse, angular impulse, work and tick count.
    fn sums(&self) -> ([f64; 3], [f64; 3], f64, u64) {
        match self.running.as_ref().map(|running| (running.sim.contact(), running.sim.step_count())) {
            Some((Ok(contact), step)) => (contact.impulse, contact.angular_impulse, contact.work, step),
            _ => ([0.0; 3], [0.0; 3], 0.0, 0),
        }
    }

    /// Step means, and what host and fabric differ by at the step's start. A step shorter than an internal
    /// step may have none: then all stays as it is.
    fn account(&mut self, dt: f64, before: Sums, plan: Option<&Plan>) {
        let after = self.sums();
        let ticks = after.3.saturating_sub(before.3);
        if ticks == 0 {
            return;
        }
        // Not the host's h, which it may have rounded: all hosts are to see the same bits.
        let time = ticks as f64 * dt;
        let over = |a: [f64; 3], b: [f64; 3]| [(b[0] - a[0]) / time, (b[1] - a[1]) / time, (b[2] - a[2]) / time];
        self.kept.force_mean = over(before.0, after.0);
        self.kept.torque_mean = over(before.1, after.1);
        let Some(plan) = plan else { return };
        (self.kept.driven, self.kept.interface_gap) = (plan.driven, plan.gap);
        let parameters = &self.kept.parameters;
        let body = &parameters.scene().projectile;
        if body.mass > 0.0 {
            let inertia = Inertia::of(&Solid::of(body), body.mass, true);
            let kinetic = |motion: &Motion| Body::of(motion).kinetic_energy(&inertia);
            let impact = kinetic(&parameters.start());
            self.kept.interface_residual = impact - kinetic(&plan.body) - before.2;
            if impact > 0.0 && math::abs(self.kept.interface_residual) > 0.01 * impact && !self.coupling_logged {
                self.coupling_logged = true;
                self.log.say(Category::Warning, COARSE_COUPLING);
            }
        }
    }

    /// The internal steps of one communication step.
    fn advance(&mut self, path: Option<Path>, ticks: u64, early: Early) -> Result<StepEnd, Status> {
        let stop_on_event = self.kept.parameters.stop_on_event();
        let (force, torque) = (self.kept.parameters.force, self.kept.parameters.torque);
        let Some(Running { sim, .. }) = &mut self.running else {
            return Err(Status::Error);
        };
        let (mask, contact) = (sim.outcomes().mask, sim.outcomes().first_contact);
        let beyond_fine = sim.counters().beyond_fine;
        if path.is_none()
            && let Err(error) = self.capsule.run(sim, &Call::ExternalLoad(force, torque))
        {
            return Err(self.refuse_error(Category::Discard, &error));
        }
        let end = sim.step_count().saturating_add(ticks);
        let mut outcome_came;
        let mut contact_came;
        loop {
            let left = end.saturating_sub(sim.step_count());
            let chunk = match early {
                Early::No => left,
                // Outcomes are tested every 64 steps; first contact can come in any step.
                Early::AtEvents if sim.outcomes().first_contact.is_none() => left.min(1),
                _ => left.min(TEST_INTERVAL - sim.step_count() % TEST_INTERVAL),
            };
            if chunk > 0
                && let Err(error) = match &path {
                    Some(path) => {
                        let started = self.capsule.run(sim, &Call::Path(*path, chunk));
                        started.and_then(|()| self.capsule.run(sim, &Call::Advance(chunk)))
                    }
                    None => self.capsule.run(sim, &Call::Advance(chunk)),
                }
            {
                if sim.failure().is_none() {
                    return Err(self.refuse_error(Category::Discard, &error));
                }
                self.kept.phase = Phase::Faulted;
                return Err(self.refuse_error(Category::Error, &error));
            }
            let outcomes = sim.outcomes();
            outcome_came = outcomes.mask != mask;
            contact_came = outcomes.first_contact.is_some() && contact.is_none();
            let stop = match early {
                Early::No => false,
                Early::AtEvents => outcome_came || contact_came,
                Early::ToStop => outcome_came && stop_on_event,
            };
            if stop || sim.step_count() >= end {
                break;
            }
        }
        let early = sim.step_count() < end;
        if beyond_fine == 0 && sim.counters().beyond_fine > 0 {
            self.log.say(Category::Warning, BEYOND_FINE);
        }
        self.log_events(mask, contact_came);
        self.log_open_balance();
        Ok(StepEnd { status: Status::Ok, event: false, terminate: outcome_came && stop_on_event, early })
    }

    /// Warns once of energies that do not add up to 1 %, and once of energy from nothing, if the host wants
    /// warnings: reading the energies is a pass over the sheet.
    fn log_open_balance(&mut self) {
        let Some(Running { sim, .. }) = &self.running else { return };
        if self.open_logged[1] || !self.log.wants(Category::Warning) {
            return;
        }
        let (body, node) = (&sim.scene().projectile, sim.scene().lumped_mass());
        let speed = math::length(body.velocity);
        let Ok(energy) = self.cache.readings.energy(sim) else { return };
        // A prescribed body may have no mass; then its work counts, from that of meeting 100 nodes on.
        let known = math::max(0.5 * body.mass, 100.0 * node) * (speed * speed);
        let gained = energy.gained > MOST_GAINED * known;
        let is_open = math::abs(energy.residual) > 0.01 * math::max(known, math::abs(energy.contact_work));
        if gained || is_open && !self.open_logged[0] {
            self.open_logged = [true, gained];
            self.log.say(Category::Warning, if gained { GAINED } else { OPEN_BALANCE });
        }
    }

    fn log_events(&self, before: OutcomeSet, contact_came: bool) {
        let Some(Running { sim, .. }) = &self.running else { return };
        let outcomes = sim.outcomes();
        let (start, dt) = (self.kept.start_time, sim.step_limits().dt);
        let log = |name: &str, step: u64| {
            let time = number(start + step as f64 * dt);
            self.log.say(Category::Event, &line(format_args!("{name} at {time} s, internal step {step}")));
        };
        if contact_came && let Some(step) = outcomes.first_contact {
            log("first contact", step);
        }
        for (outcome, latch) in Outcome::ALL.iter().zip(outcomes.latched) {
            if let Some(latch) = latch
                && !before.has(*outcome)
            {
                log(outcome.name(), latch.step);
            }
        }
    }
}

/// Said once, as a warning.
const OPEN_BALANCE: &str = "energy.residual: more than 1 % of the impact energy. Yarn that goes slack and taut changes the energy: take \
                            slack_balance = true";

/// Said once, as a warning.
const GAINED: &str = "energy.gained: contact has given more than 0.1 % of the impact energy that came from nowhere, and the outcome is not to \
                      be trusted. Take half of time_step.fraction";

/// Said once, as a warning.
const COARSE_COUPLING: &str = "interface.residual: host and fabric differ by more than 1 % of the impact energy. Take communication steps \
                               of at most 1/20 of m v/F, of mass, velocity and greatest mean force (unless the host does work on the body)";

/// Said once, as a warning.
const BEYOND_FINE: &str = "contact.beyond_fine: the projectile met the sheet beyond the fine part of the graded network, where nodes may be \
                           too far apart to meet it. Move sheet.grading.centre or enlarge sheet.grading.half_width";

type Sums = ([f64; 3], [f64; 3], f64, u64);

/// Above this a tick count is no longer exact.
const MOST_TICKS: f64 = (1_u64 << 52) as f64;

impl Cache {
    /// The plies from one on; nothing for those that there are not. That of a single sheet is in its
    /// energies.
    fn plies(&mut self, sim: &Sim, first: u32) -> Result<[Ply; PLIES_SHOWN], Failure> {
        if let Some((of, plies)) = self.plies
            && of == first
        {
            return Ok(plies);
        }
        let mut plies = [Ply::default(); PLIES_SHOWN];
        if sim.layout().is_stack() {
            sim.failure().map_or(Ok(()), Err)?;
            for (behind, place) in (0..).zip(&mut plies) {
                *place = sim.ply(first.saturating_add(behind)).unwrap_or_default();
            }
        } else if let ([only, ..], 0) = (&mut plies, first) {
            let Energy { fabric_kinetic: kinetic, strain, dissipated, .. } = self.readings.energy(sim)?;
            *only = Ply { failed_segments: sim.counters().failed_segments, kinetic, strain, dissipated };
        }
        self.plies = Some((first, plies));
        Ok(plies)
    }
}

fn copy(to: &mut [f64; MOST_ELEMENTS], from: &[f64]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
}
