//! A simulation, which owns its memory.

use crate::errors::{self, bad};
use crate::parameters;
use crate::scene::Scene;
use fabric_capsule::{Call, File, Log};
use fabric_host::in_our_environment;
use fabric_kernel::outputs::{COUNT, Get, OUTPUTS, Output, Readings};
use fabric_kernel::{CacheLine, Failure, MOST_GAINED, Motion, Outcome, OutcomeSet, Path, Sim};
use fabric_scene::memory::Buffers;
use fabric_scene::{notes, short};
use numpy::{PyArray1, PyArray3, PyArrayMethods};
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::{PyOSError, PyRuntimeWarning};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyBytes, PyDict, PyString, PyTuple};
use std::ffi::CString;
use std::path::PathBuf;

/// Nodes stepped between two looks at signals, some tenths of a second.
const NODES_AT_A_TIME: u64 = 5_000_000;
/// Steps between two looks at the energy balance, which takes about a step.
const LOOK: u64 = 256;
/// Calls between two digests of a capsule.
const DIGESTS: u64 = 100;
/// The system's number of an error of input or output, on every system.
const EIO: i32 = 5;

/// One impact. It may be used by any thread, but by one at a time.
#[pyclass(module = "fabric_kernel")]
pub struct Simulation {
    /// It refers to the lines below, which it outlives in no way: it is private, and nothing it lends leaves
    /// a call.
    sim: Sim<'static>,
    _lines: Vec<CacheLine>,
    scene: Py<Scene>,
    /// Kinetic energy of the projectile at the start, J.
    impact_energy: f64,
    /// What is still to be told: that the energy balance is open, that energy came from nothing.
    warns: [bool; 2],
    capsule: Option<Log<File>>,
}

impl Drop for Simulation {
    fn drop(&mut self) {
        if let Some(capsule) = &mut self.capsule {
            in_our_environment(|| capsule.end(&self.sim));
        }
    }
}

impl Simulation {
    fn of(made_of: Py<Scene>, warns: bool, capsule: Option<PathBuf>) -> PyResult<Simulation> {
        let scene = &made_of.get().scene;
        let mut lines = Buffers::of(scene).map_err(|error| errors::of_making(scene, error))?.into_lines();
        // SAFETY: the lines stay where they are until the simulation is dropped together with them, and
        // nobody else uses them.
        let memory = unsafe { std::slice::from_raw_parts_mut(lines.as_mut_ptr(), lines.len()) };
        let mut sim =
            in_our_environment(|| Sim::new(scene, memory)).map_err(|error| errors::of_making(scene, error.into()))?;
        let file = capsule.map(|path| File::new(&path)).transpose()?;
        let capsule = file.map(|file| in_our_environment(|| Log::begin(&mut sim, DIGESTS, file)));
        let impact_energy = in_our_environment(|| sim.energy()).map_err(errors::failed)?.projectile_kinetic;
        Ok(Simulation { sim, _lines: lines, scene: made_of, impact_energy, warns: [warns; 2], capsule })
    }

    /// Works without the interpreter.
    fn work<T: Send>(&mut self, py: Python<'_>, work: impl FnOnce(&mut Sim<'static>) -> T + Send) -> T {
        py.detach(|| in_our_environment(|| work(&mut self.sim)))
    }

    /// Does a call, which the capsule gets, without the interpreter.
    fn call(&mut self, py: Python<'_>, call: &Call<'_>) -> PyResult<()> {
        let done = py.detach(|| in_our_environment(|| fabric_capsule::run(&mut self.capsule, &mut self.sim, call)));
        done.map_err(errors::of)?;
        self.whole_capsule()
    }

    fn whole_capsule(&self) -> PyResult<()> {
        match &self.capsule {
            Some(capsule) if !capsule.is_whole() => {
                Err(PyOSError::new_err((EIO, "capsule: the file cannot be written")))
            }
            _ => Ok(()),
        }
    }

    /// Steps until `steps` are taken, one of `until` has come or so many segments have failed; looks at
    /// signals from time to time.
    /// Returns the steps taken.
    fn advance(&mut self, py: Python<'_>, until: OutcomeSet, steps: u64, failed: Option<u64>) -> PyResult<u64> {
        let stride = (NODES_AT_A_TIME / self.sim.layout().nodes().max(1) as u64).max(1);
        let mut taken = 0;
        loop {
            let now = stride.min(steps - taken).min(LOOK - self.sim.step_count() % LOOK);
            let advanced = self.work(py, |sim| match failed {
                None => sim.advance_until(until, now),
                Some(failed) => until_failed(sim, until, now, failed),
            });
            if let Some(capsule) = &mut self.capsule {
                let steps = *advanced.as_ref().unwrap_or(&now);
                in_our_environment(|| capsule.note(&Call::Advance(steps), &self.sim));
            }
            let done = advanced.map_err(errors::failed)?;
            taken += done;
            self.whole_capsule()?;
            self.tell_of_open_balance(py)?;
            if taken == steps || done < now || self.sim.outcomes().mask.has(until) {
                return Ok(taken);
            }
            py.check_signals()?;
        }
    }

    /// Warns once if the energies no longer add up, and once more if energy then comes from nothing.
    fn tell_of_open_balance(&mut self, py: Python<'_>) -> PyResult<()> {
        if self.warns == [false; 2] || !self.sim.step_count().is_multiple_of(LOOK) {
            return Ok(());
        }
        let energy = in_our_environment(|| self.sim.energy()).map_err(errors::failed)?;
        let gained = energy.gained > MOST_GAINED * self.impact_energy;
        if !self.warns[usize::from(gained)] {
            return Ok(());
        }
        if let Some(text) = notes::open_balance(&self.sim, self.impact_energy, &energy).map_err(errors::of)? {
            self.warns = [false, self.warns[1] && !gained];
            PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &CString::new(text)?, 1)?;
        }
        Ok(())
    }

    /// The outputs of a structure by their names there.
    fn read_out<'py>(&mut self, py: Python<'py>, structure: &str) -> PyResult<Bound<'py, PyDict>> {
        let of_it = || OUTPUTS.iter().filter(|output| output.parts().0 == structure);
        let mut readings = Readings::default();
        let values =
            self.work(py, |sim| of_it().map(|output| readings.read(sim, output)).collect::<Result<Vec<_>, _>>());
        let all = PyDict::new(py);
        for (output, values) in of_it().zip(values.map_err(errors::failed)?) {
            all.set_item(output.parts().1, shaped(py, output, output.shape, &values)?)?;
        }
        Ok(all)
    }

    /// An array that a read-out of the kernel fills; NumPy takes it over without a copy.
    fn filled(
        &self,
        length: usize,
        fill: impl FnOnce(&Sim<'static>, &mut [f64]) -> Result<(), fabric_kernel::Error>,
    ) -> PyResult<Vec<f64>> {
        let mut numbers = vec![0.0; length];
        in_our_environment(|| fill(&self.sim, &mut numbers)).map_err(errors::of)?;
        Ok(numbers)
    }

    fn of_nodes<'py>(
        &self,
        py: Python<'py>,
        fill: impl FnOnce(&Sim<'static>, &mut [f64]) -> Result<(), fabric_kernel::Error>,
    ) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let shape = self.shape_of_nodes();
        PyArray1::from_vec(py, self.filled(shape.iter().product(), fill)?).reshape(shape)
    }

    /// Rows, columns, axes.
    fn shape_of_nodes(&self) -> [usize; 3] {
        [self.sim.layout().nodes_y, self.sim.layout().nodes_x, 3]
    }

    fn of_segments<'py>(
        &self,
        py: Python<'py>,
        fill: impl FnOnce(&Sim<'static>, &mut [f64]) -> Result<(), fabric_kernel::Error>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(PyArray1::from_vec(py, self.filled(self.sim.layout().segments(), fill)?))
    }
}

/// Single steps until one of `until` has come, so many segments have failed, or `steps` are taken. Returns
/// the steps taken.
fn until_failed(sim: &mut Sim<'_>, until: OutcomeSet, steps: u64, failed: u64) -> Result<u64, Failure> {
    let mut taken = 0;
    while taken < steps && sim.counters().failed_segments < failed && !sim.outcomes().mask.has(until) {
        taken += sim.advance_until(until, 1)?;
    }
    Ok(taken)
}

/// A number as Python has it: whole if it is a count.
fn number<'py>(py: Python<'py>, output: &Output, value: f64) -> PyResult<Bound<'py, PyAny>> {
    if *output.quantity == COUNT { (value as u64).into_bound_py_any(py) } else { value.into_bound_py_any(py) }
}

/// Numbers as tuples, of rows if they have more dimensions.
fn shaped<'py>(py: Python<'py>, output: &Output, shape: &[usize], values: &[f64]) -> PyResult<Bound<'py, PyAny>> {
    let [length, inner @ ..] = shape else { return number(py, output, values.first().copied().unwrap_or_default()) };
    let rows = values.chunks(inner.iter().product()).take(*length);
    let rows = rows.map(|row| shaped(py, output, inner, row)).collect::<PyResult<Vec<_>>>()?;
    Ok(PyTuple::new(py, rows)?.into_any())
}

/// The set of outcomes of these names; one name alone is a set, too.
fn outcome_set(until: &Bound<'_, PyAny>) -> PyResult<OutcomeSet> {
    let known = Outcome::ALL.map(Outcome::name).join(", ");
    let one = until.extract::<String>().map(|name| vec![name]);
    let names: Vec<String> = one
        .or_else(|_| until.extract())
        .map_err(|_| bad("until", format!("until: must be names of outcomes; there are {known}")))?;
    let outcome = |name: &String| {
        let found = Outcome::ALL.into_iter().find(|outcome| outcome.name() == name);
        found.ok_or_else(|| bad("until", format!("until: there is no outcome {:?}; there are {known}", short(name))))
    };
    names.iter().map(outcome).collect()
}

/// Outcomes that a scene may have.
fn outcomes_of(scene: &fabric_kernel::Scene, until: &Bound<'_, PyAny>) -> PyResult<OutcomeSet> {
    let set = outcome_set(until)?;
    if set.has(Outcome::Through) && !scene.track_through {
        return Err(bad("until", "until: through comes only with track_through, which the scene does not have".into()));
    }
    Ok(set)
}

/// A number of steps.
fn count(steps: &Bound<'_, PyAny>) -> PyResult<u64> {
    steps.extract().map_err(|_| bad("steps", "steps: must be a whole number, at least 0 and below 2^64".into()))
}

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (scene, *, warns = true, capsule = None))]
    fn new(py: Python<'_>, scene: &Bound<'_, PyAny>, warns: bool, capsule: Option<PathBuf>) -> PyResult<Simulation> {
        let scene = match scene.cast::<Scene>() {
            Ok(scene) => scene.clone().unbind(),
            Err(no) if !scene.is_instance_of::<PyString>() => return Err(no.into()),
            Err(_) => Py::new(py, Scene::read(scene.extract()?)?)?,
        };
        py.detach(|| Simulation::of(scene, warns, capsule))
    }

    /// The scene it was made of.
    #[getter]
    fn scene(&self, py: Python<'_>) -> Py<Scene> {
        self.scene.clone_ref(py)
    }

    /// Steps taken.
    #[getter]
    fn step_count(&self) -> u64 {
        self.sim.step_count()
    }

    /// Time, s.
    #[getter]
    fn time(&self) -> f64 {
        self.sim.time()
    }

    /// The time step in use and its limits, s.
    fn step_limits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let limits = self.sim.step_limits();
        [("dt", limits.dt), ("dt_crit", limits.dt_crit), ("step_max", limits.step_max)].into_py_dict(py)
    }

    /// A hash of the whole state: equal digests mean equal bits.
    #[getter]
    fn digest(&self, py: Python<'_>) -> String {
        format!("{:016x}", py.detach(|| in_our_environment(|| self.sim.digest())))
    }

    /// The scene, where it is, and how it has ended.
    fn __repr__(&self, py: Python<'_>) -> String {
        let scene = self.scene.bind(py).repr().map_or_else(|_| "Scene(...)".into(), |text| text.to_string());
        let come = Outcome::ALL.iter().zip(self.sim.outcomes().latched).filter(|(_, latch)| latch.is_some());
        let come: Vec<_> = self.failure().into_iter().chain(come.map(|(outcome, _)| outcome.name().into())).collect();
        let ended = if come.is_empty() { String::new() } else { format!(", {}", come.join(" and ")) };
        format!("<Simulation of {scene}: step {}, {:.4} us{ended}>", self.step_count(), 1e6 * self.time())
    }

    /// Takes so many steps.
    #[pyo3(signature = (steps = None))]
    fn step(&mut self, py: Python<'_>, steps: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let steps = steps.map_or(Ok(1), count)?;
        self.advance(py, OutcomeSet::NONE, steps, None).map(|_| ())
    }

    /// Steps until one of the outcomes has come, so many segments have failed, or so many steps are taken.
    /// Returns the steps taken.
    #[pyo3(signature = (until, steps, *, failed = None))]
    fn run(
        &mut self,
        py: Python<'_>,
        until: &Bound<'_, PyAny>,
        steps: &Bound<'_, PyAny>,
        failed: Option<u64>,
    ) -> PyResult<u64> {
        let (until, steps) = (outcomes_of(self.sim.scene(), until)?, count(steps)?);
        self.advance(py, until, steps, failed)
    }

    /// Moves a prescribed projectile along a path that ends with this pose and these rates.
    #[pyo3(signature = (position, velocity, orientation = None, angular_velocity = None, *, path_steps, first = None, steps = None))]
    #[expect(clippy::too_many_arguments, reason = "they are Python's keyword arguments")]
    fn follow(
        &mut self,
        py: Python<'_>,
        position: &Bound<'_, PyAny>,
        velocity: &Bound<'_, PyAny>,
        orientation: Option<&Bound<'_, PyAny>>,
        angular_velocity: Option<&Bound<'_, PyAny>>,
        path_steps: u64,
        first: Option<u64>,
        steps: Option<u64>,
    ) -> PyResult<()> {
        let end = Motion {
            position: parameters::array("position", Some(position), [0.0; 3])?,
            velocity: parameters::array("velocity", Some(velocity), [0.0; 3])?,
            orientation: parameters::array("orientation", orientation, [1.0, 0.0, 0.0, 0.0])?,
            angular_velocity: parameters::array("angular_velocity", angular_velocity, [0.0; 3])?,
        };
        let path = Path { first: first.unwrap_or(self.sim.step_count()), steps: path_steps, end };
        let steps = steps.unwrap_or(path_steps);
        self.call(py, &Call::Path(path, steps))?;
        self.call(py, &Call::Advance(steps))
    }

    /// Back to step 0. Clears a failure.
    fn reset(&mut self, py: Python<'_>) -> PyResult<()> {
        self.call(py, &Call::Reset)
    }

    /// The force, N, and torque, N m, that act on a free projectile from now on.
    #[pyo3(signature = (force, torque = None))]
    fn set_external_load(
        &mut self,
        py: Python<'_>,
        force: &Bound<'_, PyAny>,
        torque: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let force = parameters::array("force", Some(force), [0.0; 3])?;
        let torque = parameters::array("torque", torque, [0.0; 3])?;
        self.call(py, &Call::ExternalLoad(force, torque))
    }

    /// Starts from positions, m, and velocities, m/s, of all nodes.
    fn set_motion(
        &mut self,
        py: Python<'_>,
        positions: &Bound<'_, PyAny>,
        velocities: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let shape = self.shape_of_nodes();
        let positions = parameters::numbers("positions", positions, &shape)?;
        let velocities = parameters::numbers("velocities", velocities, &shape)?;
        self.call(py, &Call::Motion(&positions, &velocities))
    }

    /// Gives every segment the largest stretch that it has had.
    fn set_largest_stretch(&mut self, py: Python<'_>, stretches: &Bound<'_, PyAny>) -> PyResult<()> {
        let stretches = parameters::numbers("stretches", stretches, &[self.sim.layout().segments()])?;
        self.call(py, &Call::LargestStretch(&stretches))
    }

    /// The state as bytes.
    fn save<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        PyBytes::new_with(py, self.sim.snapshot_bytes(), |image| {
            in_our_environment(|| self.sim.save(image)).map_err(errors::of)
        })
    }

    /// Back to a saved state of the same scene and version.
    fn restore(&mut self, py: Python<'_>, image: &[u8]) -> PyResult<()> {
        self.call(py, &Call::Load(image))
    }

    /// Pose and rates of the projectile.
    fn projectile<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.read_out(py, "projectile")
    }

    /// Contact sums.
    fn contact<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.read_out(py, "contact")
    }

    /// Impulses on the supports, N s.
    fn support<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.read_out(py, "support")
    }

    /// The energies, J.
    fn energy<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.read_out(py, "energy")
    }

    /// What one ply holds, J, and its failed segments.
    fn ply<'py>(&self, py: Python<'py>, ply: u32) -> PyResult<Bound<'py, PyDict>> {
        let ply = py.detach(|| in_our_environment(|| self.sim.ply(ply))).map_err(errors::of)?;
        let all = PyDict::new(py);
        for output in OUTPUTS {
            if let Get::Ply(of) = output.get {
                all.set_item(output.parts().1, number(py, output, of(&ply))?)?;
            }
        }
        Ok(all)
    }

    /// At how many crossings yarns would slip.
    #[pyo3(signature = (thickness, friction, adhesion = 0.0))]
    fn slip<'py>(&self, py: Python<'py>, thickness: f64, friction: f64, adhesion: f64) -> PyResult<Bound<'py, PyDict>> {
        let found = py.detach(|| in_our_environment(|| self.sim.slip(thickness, friction, adhesion)));
        let fabric_kernel::Slip { crossings, slipping, largest } = found.map_err(errors::of)?;
        let all = PyDict::new(py);
        all.set_item("crossings", <(u64, u64, u64)>::from(crossings))?;
        all.set_item("slipping", <(u64, u64, u64)>::from(slipping))?;
        all.set_item("largest", largest)?;
        Ok(all)
    }

    /// Momentum that the balance does not close by, N s.
    fn momentum_residual(&self, py: Python<'_>) -> PyResult<(f64, f64, f64)> {
        let residual = py.detach(|| in_our_environment(|| self.sim.momentum_residual()));
        residual.map(Into::into).map_err(errors::failed)
    }

    /// Largest deflection, m, and largest stretch.
    fn fabric<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.read_out(py, "fabric")
    }

    /// Counters; also after a failure.
    fn counters<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.read_out(py, "counters")
    }

    /// Step, time and work of each outcome that has come, by its name.
    fn outcomes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (found, dt, all) = (self.sim.outcomes(), self.sim.step_limits().dt, PyDict::new(py));
        for (outcome, latch) in Outcome::ALL.iter().zip(found.latched) {
            if let Some(latch) = latch {
                let one = [("time", latch.step as f64 * dt), ("work", latch.work)].into_py_dict(py)?;
                one.set_item("step", latch.step)?;
                all.set_item(outcome.name(), one)?;
            }
        }
        Ok(all)
    }

    /// Step at whose start the first contact impulse acted; None before.
    #[getter]
    fn first_contact(&self) -> Option<u64> {
        self.sim.outcomes().first_contact
    }

    /// The code of the latched failure, if there is one.
    #[getter]
    fn failure(&self) -> Option<String> {
        self.sim.failure().map(|failure| format!("{failure:?}"))
    }

    /// Positions of the nodes, m.
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        self.of_nodes(py, |sim, out| sim.copy_positions(out))
    }

    /// Velocities of the nodes, m/s.
    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        self.of_nodes(py, |sim, out| sim.copy_velocities(out))
    }

    /// Remaining part of the stiffness of each segment: 1 whole, 0 failed.
    fn damage<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.of_segments(py, |sim, out| sim.copy_damage(out))
    }

    /// Stretch of each segment.
    fn stretch<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.of_segments(py, |sim, out| sim.copy_stretch(out))
    }
}
