//! A model that an FMU holds: its name and its start values.

use fabric::fields::FIELDS;
use fabric::{CacheLine, Layout, Sim};
use fabric_fmu::parameters::Parameters;
use fabric_fmu::{MODEL_IDENTIFIER, starts};
use std::path::Path;

/// A model: the fabric with the start values of a scene.
pub struct Model {
    pub name: String,
    pub starts: Parameters,
    /// Internal step, s.
    pub time_step: f64,
    /// The scene as the library is compiled with; None for the one that it has by itself.
    pub words: Option<String>,
}

impl Model {
    pub fn own() -> Model {
        let name = MODEL_IDENTIFIER.to_string();
        Model { name, starts: Parameters::default(), time_step: starts::TIME_STEP, words: None }
    }

    pub fn of(name: &str, file: &Path) -> Result<Model, String> {
        if KEYWORDS.contains(&name) {
            return Err(format!("--name {name}: a word of C, where the name stands before the names of functions"));
        }
        let sound = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if !name.starts_with(|c: char| c.is_ascii_alphabetic()) || !name.chars().all(sound) || name == MODEL_IDENTIFIER
        {
            return Err(format!("--name {name}: letters, digits and _, a letter first, and not {MODEL_IDENTIFIER}"));
        }
        let mut scene = fabric_scene::read(file).map_err(|error| error.to_string())?;
        // As an instance of it would begin.
        let refused = |error: fabric::Error| format!("{}: {error}", file.display());
        let mut memory = vec![CacheLine::ZERO; Layout::of(&scene).map_err(refused)?.lines()];
        let time_step = Sim::new(&scene, &mut memory).map_err(refused)?.step_limits().dt;
        let mut starts = Parameters::of(scene);
        if let Some((variable, value)) = starts.out_of_range() {
            return Err(format!("{}: {} = {value} cannot be a start value of an FMU", file.display(), variable.name));
        }
        let words = FIELDS.iter().flat_map(|field| (0..field.size()).map(move |element| (field, element)));
        let words = words.map(|(field, element)| format!("{:016x}", field.word(&mut scene, element))).collect();
        Ok(Model { name: name.to_string(), starts, time_step, words: Some(words) })
    }
}

/// The words of C that are no names.
const KEYWORDS: [&str; 32] = [
    "auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum", "extern", "float",
    "for", "goto", "if", "int", "long", "register", "return", "short", "signed", "sizeof", "static", "struct",
    "switch", "typedef", "union", "unsigned", "void", "volatile", "while",
];
