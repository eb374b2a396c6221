//! Scenes: a preset, a file or a dictionary, and whatever differs from it.

use crate::{errors, parameters};
use fabric_host::in_our_environment;
use fabric_kernel::Feature;
use fabric_kernel::fields::{FIELDS, field};
use fabric_scene::memory::Buffers;
use fabric_scene::{PRESETS, UNREAD, derived, short, textile};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::PathBuf;
use toml::Table;

/// Everything that defines a simulation. It never changes; `replace` gives another.
#[pyclass(frozen, module = "fabric_kernel")]
pub struct Scene {
    /// The kernel's scene.
    pub scene: fabric_kernel::Scene,
    /// The textiles that it was made of, and the projectile's material, as a scene file has them.
    textiles: Table,
    /// The preset that it began with.
    preset: String,
    /// What the reader of the file must know, if it is of a file.
    remarks: Vec<String>,
}

/// How a scene is pickled: what makes it, and its arguments.
type Reduced<'py> = (Bound<'py, PyType>, (&'static str, Bound<'py, PyDict>));

impl Scene {
    /// Scene with what differs.
    fn changed(&self, given: [Option<&Bound<'_, PyDict>>; 2]) -> PyResult<Scene> {
        let (mut scene, mut textiles) = (self.scene, self.textiles.clone());
        let mut as_it_is = false;
        for given in given.into_iter().flatten() {
            let mut table = parameters::table("", given, 0)?;
            // A list of everything, as `to_dict` gives it, has what the scene does not read, too.
            if FIELDS.iter().all(|field| table.contains_key(field.name)) {
                table = [(UNREAD.to_string(), table.into())].into_iter().collect();
            }
            follow(&mut textiles, &mut table);
            as_it_is |= table.contains_key(UNREAD);
            textiles.extend(textile::of(&table));
            in_our_environment(|| fabric_scene::apply(&mut scene, table)).map_err(errors::of_scene)?;
        }
        if !as_it_is {
            derived::refuse_what_cannot_be_meant(&scene).map_err(errors::of_scene)?;
        }
        if scene.back.plies == 0 {
            textiles.remove("back_fabric");
        }
        Ok(Scene { scene, textiles, preset: self.preset.clone(), remarks: Vec::new() })
    }

    /// With another scene of the same textiles.
    fn with(&self, scene: fabric_kernel::Scene) -> Scene {
        Scene { scene, textiles: self.textiles.clone(), preset: self.preset.clone(), remarks: self.remarks.clone() }
    }
}

/// The mass of a material follows the size of the projectile, until another mass is given.
fn follow(kept: &mut Table, table: &mut Table) {
    let given: Vec<String> = fabric_scene::given(table).into_iter().map(|(key, _)| key).collect();
    let has = |key: &str| given.iter().any(|name| name == key);
    let weighed = ["projectile.mass", "projectile.calibre", "projectile.vertices"].into_iter().any(has);
    if weighed || table.contains_key(UNREAD) {
        kept.remove("projectile");
    }
    let own = has("projectile.material") || has("projectile.density");
    if let (Some(toml::Value::Table(body)), false) = (kept.get("projectile"), own) {
        table.extend(body.iter().map(|(key, value)| (format!("projectile.{key}"), value.clone())));
    }
}

impl Scene {
    /// The nearest preset, and the parameters that differ from it.
    fn difference<'py>(&self, py: Python<'py>) -> PyResult<(&'static str, Bound<'py, PyDict>)> {
        let mut nearest: Option<(&str, Bound<'py, PyDict>)> = None;
        for (name, _) in PRESETS {
            let (base, other, kept) =
                (fabric_scene::base(name, &self.scene, &self.textiles), PyDict::new(py), PyDict::new(py));
            for (key, textile) in &self.textiles {
                other.set_item(key, parameters::object(py, textile)?)?;
            }
            // The mass follows from the material.
            for field in FIELDS
                .iter()
                .filter(|field| field.name != "projectile.mass" || !self.textiles.contains_key("projectile"))
            {
                let (own, usual) = (parameters::value(py, field, &self.scene)?, parameters::value(py, field, &base)?);
                // By their words: -0.0 is not 0.0, and what is no number is none again.
                if own.repr()?.to_cow()? != usual.repr()?.to_cow()?
                    || fabric_scene::is_needed(field, &self.scene, &base)
                {
                    let is_kept = fabric_scene::is_kept(field, &self.scene, &self.textiles);
                    if is_kept { &kept } else { &other }.set_item(field.name, own)?;
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
        if preset.ends_with(".toml") {
            let text = format!(
                "preset = \"{}\": a file is read by Scene.read; presets have names without an end",
                short(preset)
            );
            return Err(errors::bad("preset", text));
        }
        let scene = fabric_scene::preset(Some(preset.into())).map_err(errors::of_scene)?;
        Scene { scene, textiles: Table::new(), preset: preset.into(), remarks: Vec::new() }.changed([parameters, more])
    }

    /// The scene of a file.
    #[staticmethod]
    pub fn read(path: PathBuf) -> PyResult<Scene> {
        // Rust does not say which file it was, Python does.
        let text = fabric_scene::text_of(&path)
            .map_err(|error| PyErr::from(std::io::Error::new(error.kind(), format!("{}: {error}", path.display()))))?;
        made_of(&text, &format!("{}: ", path.display()))
    }

    /// The scene of a file's text.
    #[staticmethod]
    fn parse(text: &str) -> PyResult<Scene> {
        made_of(text, "")
    }

    /// Scene with other values.
    #[pyo3(signature = (parameters = None, /, **more))]
    fn replace(&self, parameters: Option<&Bound<'_, PyDict>>, more: Option<&Bound<'_, PyDict>>) -> PyResult<Scene> {
        self.changed([parameters, more])
    }

    /// Scene with the projectile just before the sheet, so that its centre flies through a point of it.
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
        scene.projectile.position =
            in_our_environment(|| derived::aimed(&scene, "point", point, 0.0)).map_err(errors::of_scene)?;
        Ok(self.with(scene))
    }

    /// Scene with the graded network that the kernel chooses for an error.
    fn graded(&self, error: f64) -> PyResult<Scene> {
        let mut scene = self.scene;
        scene.set_grading(error).map_err(errors::of)?;
        Ok(self.with(scene))
    }

    /// Refuses a scene that cannot be simulated.
    fn check(&self, py: Python<'_>) -> PyResult<()> {
        let scene = self.scene;
        py.detach(|| in_our_environment(|| Buffers::check(&scene)).map_err(|error| errors::of_making(&scene, error)))
    }

    /// Every parameter by its name.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for field in FIELDS {
            all.set_item(field.name, parameters::value(py, field, &self.scene)?)?;
        }
        Ok(all)
    }

    /// Every number of the scene as 64 bits, in the order of the table of parameters.
    fn words(&self) -> Vec<u64> {
        let mut scene = self.scene;
        let words = FIELDS.iter().flat_map(|field| (0..field.size()).map(move |element| (field, element)));
        words.map(|(field, element)| field.word(&mut scene, element)).collect()
    }

    /// The scene as a file's text, with every parameter and its meaning.
    fn to_toml(&self) -> String {
        fabric_scene::write(PRESETS[0].0, &self.scene, &self.textiles)
    }

    /// Names of the fabrics of the sheet and of the last plies.
    #[getter]
    fn fabrics(&self) -> (Option<String>, Option<String>) {
        textile::names(&self.textiles).into()
    }

    /// Name of the fabric of the sheet, or of the preset that it is of.
    #[getter]
    fn label(&self) -> String {
        let [front, _] = textile::names(&self.textiles);
        let own =
            || if self.textiles.contains_key("fabric") { "a fabric of the file's own numbers" } else { &self.preset };
        front.unwrap_or_else(|| own().into())
    }

    /// The material of the projectile.
    #[getter]
    fn material(&self) -> Option<&str> {
        self.textiles.get("projectile")?.get("material")?.as_str()
    }

    /// What is known of the fabric of the sheet beside what the network reads.
    fn weave<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for (key, number) in textile::weave(&self.textiles).map_err(errors::of_scene)? {
            all.set_item(key, number)?;
        }
        Ok(all)
    }

    /// Features of the kernel that the scene needs, with the field that asks for each.
    fn features(&self) -> std::collections::BTreeMap<&'static str, &'static str> {
        let all = fabric_kernel::FEATURES.iter().rev();
        all.filter_map(|record| Some((record.name, record.asked_by(&self.scene)?))).collect()
    }

    /// What the reader of the scene's file must know.
    #[getter]
    fn remarks(&self) -> Vec<String> {
        self.remarks.clone()
    }

    /// Held nodes of each ply: row, first column, and column after the last.
    fn held(&self) -> PyResult<Vec<(usize, u32, u32)>> {
        let layout = fabric_kernel::Layout::of(&self.scene).map_err(errors::of)?;
        let of_row =
            |row| fabric_kernel::internals::weave::fixed_runs(&self.scene, row).map(|[from, end]| (row, from, end));
        Ok((0..layout.y.modelled()).flat_map(of_row).filter(|(_, from, end)| end > from).collect())
    }

    /// What must be said of a projectile that is too heavy or too light for its size.
    fn unlikely_body(&self) -> Option<String> {
        fabric_scene::notes::unlikely_body(&self.scene)
    }

    /// What a report must say of the edges of the projectile at a speed, m/s.
    fn sharp_edges(&self, speed: f64) -> Option<String> {
        fabric_scene::notes::sharp_edges(&self.scene, speed)
    }

    /// What a report must say of loose plies with a thickness.
    fn loose_and_thick(&self) -> Option<String> {
        fabric_scene::notes::loose_and_thick(&self.scene)
    }

    /// What a report must say of a network that is too coarse for the projectile.
    fn coarse_network(&self) -> PyResult<Option<String>> {
        let weave = textile::weave(&self.textiles).map_err(errors::of_scene)?;
        let spacing = weave.iter().find(|(key, _)| *key == "spacing").map(|(_, spacing)| *spacing);
        Ok(fabric_scene::notes::coarse_network(&self.scene, spacing))
    }

    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let field = field(name).ok_or_else(|| PyKeyError::new_err(short(name)))?;
        parameters::value(py, field, &self.scene)
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Scene>().is_ok_and(|other| other.get().scene == self.scene)
    }

    fn __hash__(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        // 0.0 and -0.0 are equal.
        for word in self.words() {
            (if word == (-0.0_f64).to_bits() { 0 } else { word }).hash(&mut hasher);
        }
        hasher.finish()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let (preset, other) = self.difference(py)?;
        Ok(if other.is_empty() { format!("Scene('{preset}')") } else { format!("Scene('{preset}', {other})") })
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        Ok((py.get_type::<Scene>(), self.difference(py)?))
    }
}

/// The scene of a file's text. `file`: what goes before a refusal.
fn made_of(text: &str, file: &str) -> PyResult<Scene> {
    let scene = in_our_environment(|| fabric_scene::parse(text));
    let scene = scene.map_err(|error| errors::within(file, errors::of_scene(error), ""))?;
    let mut file = fabric_scene::table_of(text).map_err(errors::of_scene)?;
    let textiles = textile::of(&file);
    let mut remarks = Vec::from_iter(derived::unplaced(&file, &scene));
    if fabric_scene::takes_automatic_grading(&mut file) && !Feature::Grading.is_in(&scene) {
        remarks.push(format!(
            "sheet.grading = \"automatic\" left the network whole. For an error of {} % no row of this sheet can be left out, or it is held \
             at its corners (docs/model.md, \"Graded networks\")",
            100.0 * fabric_scene::AUTOMATIC_GRADING
        ));
    }
    let preset = file.get("preset").and_then(toml::Value::as_str).unwrap_or_default().into();
    Ok(Scene { scene, textiles, preset, remarks })
}
