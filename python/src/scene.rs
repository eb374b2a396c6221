//! Scenes: a preset, a file or a dictionary, and whatever differs from it.

use crate::{errors, parameters};
use fabric::Solid;
use fabric::fields::{FIELDS, field};
use fabric::pose::{Pose, Vector, into_body, normalised};
use fabric_host::in_our_environment;
use fabric_scene::memory::Buffers;
use fabric_scene::{PRESETS, UNREAD, short};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};
use std::path::PathBuf;

/// Everything that defines a simulation. It never changes; `replace` gives another.
#[pyclass(frozen, module = "fabric_kernel")]
pub struct Scene {
    /// The kernel's scene.
    pub scene: fabric::Scene,
}

/// How a scene is pickled: what makes it, and its arguments.
type Reduced<'py> = (Bound<'py, PyType>, (&'static str, Bound<'py, PyDict>));

/// A preset, and what differs from it.
fn make(
    preset: &str,
    parameters: Option<&Bound<'_, PyDict>>,
    more: Option<&Bound<'_, PyDict>>,
) -> PyResult<fabric::Scene> {
    let mut scene = fabric_scene::preset(Some(preset.into())).map_err(errors::of_scene)?;
    change(&mut scene, parameters)?;
    change(&mut scene, more)?;
    Ok(scene)
}

fn change(scene: &mut fabric::Scene, parameters: Option<&Bound<'_, PyDict>>) -> PyResult<()> {
    let Some(given) = parameters else { return Ok(()) };
    let mut table = parameters::table("", given, 0)?;
    // A list of everything, as `values` gives it, has what the scene does not read, too.
    if FIELDS.iter().all(|field| table.contains_key(field.name)) {
        table = [(UNREAD.to_string(), table.into())].into_iter().collect();
    }
    fabric_scene::apply(scene, table).map_err(errors::of_scene)
}

impl Scene {
    /// The nearest preset, and the parameters that differ from it.
    fn difference<'py>(&self, py: Python<'py>) -> PyResult<(&'static str, Bound<'py, PyDict>)> {
        let mut nearest: Option<(&str, Bound<'py, PyDict>)> = None;
        for (name, preset) in PRESETS {
            let (base, other, kept) = (preset(), PyDict::new(py), PyDict::new(py));
            let unread = fabric_scene::unread(name, &self.scene);
            for field in FIELDS {
                let (own, usual) = (parameters::value(py, field, &self.scene)?, parameters::value(py, field, &base)?);
                // By their words: -0.0 is not 0.0, and what is no number is none again.
                if own.repr()?.to_cow()? != usual.repr()?.to_cow()? {
                    let is_unread = unread.iter().any(|unread| unread.name == field.name);
                    if is_unread { &kept } else { &other }.set_item(field.name, own)?;
                }
            }
            if !kept.is_empty() {
                other.set_item(UNREAD, kept)?;
            }
            if nearest.as_ref().is_none_or(|(_, least)| other.len() < least.len()) {
                nearest = Some((name, other));
            }
        }
        Ok(nearest.unwrap_or((PRESETS[0].0, PyDict::new(py))))
    }
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (preset = "sheet_3in_sphere", parameters = None, /, **more))]
    fn new(preset: &str, parameters: Option<&Bound<'_, PyDict>>, more: Option<&Bound<'_, PyDict>>) -> PyResult<Scene> {
        Ok(Scene { scene: make(preset, parameters, more)? })
    }

    /// The scene of a file.
    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<Scene> {
        // Rust does not say which file it was, Python does.
        let text = fabric_scene::text_of(&path)
            .map_err(|error| PyErr::from(std::io::Error::new(error.kind(), format!("{}: {error}", path.display()))))?;
        Scene::parse(&text)
    }

    /// The scene of a file's text.
    #[staticmethod]
    fn parse(text: &str) -> PyResult<Scene> {
        Ok(Scene { scene: fabric_scene::parse(text).map_err(errors::of_scene)? })
    }

    /// The same with other values.
    #[pyo3(signature = (parameters = None, /, **more))]
    fn replace(&self, parameters: Option<&Bound<'_, PyDict>>, more: Option<&Bound<'_, PyDict>>) -> PyResult<Scene> {
        let mut scene = self.scene;
        change(&mut scene, parameters)?;
        change(&mut scene, more)?;
        Ok(Scene { scene })
    }

    /// The same with the projectile just before the sheet, so that its centre flies through a point of it.
    #[pyo3(signature = (point = None, *, velocity = None, orientation = None))]
    fn aimed(
        &self,
        point: Option<&Bound<'_, PyAny>>,
        velocity: Option<&Bound<'_, PyAny>>,
        orientation: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Scene> {
        let mut scene = self.scene;
        let body = &mut scene.projectile;
        let point = parameters::array("point", point, [0.0; 2])?;
        body.velocity = parameters::array("velocity", velocity, body.velocity)?;
        body.orientation = parameters::array("orientation", orientation, body.orientation)?;
        scene.check().map_err(errors::of)?;
        within_the_sheet(&scene, point)?;
        let position = in_our_environment(|| aim(&scene, point)).ok_or_else(|| {
            errors::bad("projectile.velocity", "projectile.velocity: does not lead to the sheet".into())
        })?;
        scene.projectile.position = position;
        Ok(Scene { scene })
    }

    /// The same with the graded network that the kernel chooses for an error.
    fn graded(&self, error: f64) -> PyResult<Scene> {
        let mut scene = self.scene;
        scene.set_grading(error).map_err(errors::of)?;
        Ok(Scene { scene })
    }

    /// Refuses a scene that cannot be simulated.
    fn check(&self, py: Python<'_>) -> PyResult<()> {
        let scene = self.scene;
        py.detach(|| in_our_environment(|| Buffers::check(&scene)).map_err(errors::of_making))
    }

    /// Every parameter by its name.
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for field in FIELDS {
            all.set_item(field.name, parameters::value(py, field, &self.scene)?)?;
        }
        Ok(all)
    }

    /// The scene as a file's text, with every parameter and its meaning.
    fn text(&self) -> String {
        fabric_scene::write(PRESETS[0].0, &self.scene)
    }

    /// What must be said of a projectile that is too heavy or too light for its size.
    fn unlikely_body(&self) -> Option<String> {
        fabric_scene::notes::unlikely_body(&self.scene)
    }

    /// What a report must say of the edges of the projectile at a speed, m/s.
    fn sharp_edges(&self, speed: f64) -> Option<String> {
        fabric_scene::notes::sharp_edges(&self.scene, speed)
    }

    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let field = field(name).ok_or_else(|| PyKeyError::new_err(short(name).to_string()))?;
        parameters::value(py, field, &self.scene)
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Scene>().is_ok_and(|other| other.get().scene == self.scene)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let (preset, other) = self.difference(py)?;
        Ok(if other.is_empty() { format!("Scene('{preset}')") } else { format!("Scene('{preset}', {other})") })
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        Ok((py.get_type::<Scene>(), self.difference(py)?))
    }
}

/// Refuses a point beside the sheet, from its middle, m: a millimetre is easily written as a metre. A mesh beyond the edge is allowed.
fn within_the_sheet(scene: &fabric::Scene, point: [f64; 2]) -> PyResult<()> {
    let ([x, y], [half_x, half_y]) = (point, scene.half_size());
    let mesh = scene.sheet.spacing.max(scene.sheet.spacing_y);
    if fabric::math::abs(x) <= half_x + mesh && fabric::math::abs(y) <= half_y + mesh {
        return Ok(());
    }
    let reach = format!("the sheet reaches {half_x:.4} m and {half_y:.4} m from its middle");
    Err(errors::bad("point", format!("point: ({x}, {y}) m lies beside the sheet; {reach}")))
}

/// Where the projectile's centre must be so that it touches the first ply in its way with its foremost point, and flies through a
/// point of it, given in the sheet's plane. None if its velocity leads along the sheet.
fn aim(scene: &fabric::Scene, point: [f64; 2]) -> Option<[f64; 3]> {
    let (body, pose) = (&scene.projectile, Pose::of_sheet(&scene.sheet));
    let velocity = pose.vector_in(body.velocity);
    let up = velocity[2] > 0.0;
    let ahead = Vector::new(0.0, 0.0, if up { 1.0 } else { -1.0 });
    let orientation = normalised(pose.orientation_in(body.orientation));
    let reach = Solid::of(body).support(&into_body(&orientation, &ahead));
    let height = if up { 0.0 } else { scene.stack_height() };
    let back = -reach / fabric::math::abs(velocity[2]);
    let position = [point[0] + velocity[0] * back, point[1] + velocity[1] * back, height - ahead.z * reach];
    let position = pose.point_out(position);
    position.iter().all(|x| x.is_finite()).then_some(position)
}
