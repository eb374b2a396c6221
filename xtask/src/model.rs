//! A model that an FMU holds: its name and its start values.

use fabric::fields::FIELDS;
use fabric_fmu::parameters::Parameters;
use fabric_fmu::{MODEL_IDENTIFIER, starts};
use std::path::Path;

/// A model: the fabric with the start values of a scene.
pub struct Model {
    /// modelName and modelIdentifier.
    pub name: String,
    /// Start values.
    pub starts: Parameters,
    /// Internal step, s.
    pub time_step: f64,
    /// The scene as the library is compiled with; None for the one that it has by itself.
    pub words: Option<String>,
}

impl Model {
    /// FabricShield.
    pub fn own() -> Model {
        let name = MODEL_IDENTIFIER.to_string();
        Model { name, starts: Parameters::default(), time_step: starts::TIME_STEP, words: None }
    }

    /// A model of a scene.
    pub fn of(name: &str, file: &Path) -> Result<Model, String> {
        let sound = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if !name.starts_with(|c: char| c.is_ascii_alphabetic()) || !name.chars().all(sound) || name == MODEL_IDENTIFIER
        {
            return Err(format!("--name {name}: letters, digits and _, a letter first, and not {MODEL_IDENTIFIER}"));
        }
        let mut scene = fabric_scene::read(file).map_err(|error| error.to_string())?;
        let limits = scene.step_limits().map_err(|error| format!("{}: {error}", file.display()))?;
        let mut starts = Parameters::of(scene);
        if let Some((variable, value)) = starts.out_of_range() {
            return Err(format!("{}: {} = {value} cannot be a start value of an FMU", file.display(), variable.name));
        }
        let words = FIELDS.iter().flat_map(|field| (0..field.size()).map(move |element| (field, element)));
        let words = words.map(|(field, element)| format!("{:016x}", field.word(&mut scene, element))).collect();
        Ok(Model { name: name.to_string(), starts, time_step: limits.dt, words: Some(words) })
    }
}
