//! The rows as an FMU's host sees them: parameters by variable name, and what must come out, bit for bit.
//!
//! `tests/fmi/test_stability.py` reads these cases and runs them through both FMUs. Motion given by
//! hand has no such case.

use crate::Result;
use fabric::fields::{FIELDS, Place};
use fabric::outputs::{Get, OUTPUTS, Readings};
use fabric::{Drive, Error, Scene, Sim};
use fabric_fmu::table::VARIABLES;
use serde::Serialize;
use serde_json::{Map, Value, json};

/// A row for a host.
#[derive(Clone, Debug, Serialize)]
pub struct FmuCase {
    /// Start values by variable name.
    values: Map<String, Value>,
    /// Force on the projectile from the start, N.
    force: [f64; 3],
    /// What must happen.
    #[serde(flatten)]
    outcome: Expected,
}

/// What must happen.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "expected", rename_all = "snake_case")]
enum Expected {
    /// A step of this size ends in an error, and the log says this.
    Failed { h: f64, text: String },
    /// A step of this size is taken, and these are the outputs then.
    Runs { h: f64, outputs: Map<String, Value> },
}

impl FmuCase {
    /// In a word.
    pub fn word(&self) -> &'static str {
        match self.outcome {
            Expected::Failed { .. } => "faulted",
            Expected::Runs { .. } => "same bits",
        }
    }
}

/// The case of a simulation that has run under a constant force; `steps`: how far it should have come if it failed.
pub fn case(sim: &mut Sim<'_>, force: [f64; 3], steps: u64) -> Result<Option<FmuCase>> {
    let Some(values) = values(sim.scene()) else { return Ok(None) };
    let outcome = if let Some(failure) = sim.failure() {
        let h = steps as f64 * sim.step_limits().dt;
        Expected::Failed { h, text: Error::from(failure).text().to_string() }
    } else {
        Expected::Runs { h: sim.time(), outputs: outputs(sim)? }
    };
    Ok(Some(FmuCase { values, force, outcome }))
}

/// Start values for a scene; None if a host cannot give them: the motion by hand of a prescribed body, whole numbers beyond
/// 31 bits, and what lies out of range where the scene does not read it.
fn values(scene: &Scene) -> Option<Map<String, Value>> {
    let (mut copy, mut values) = (*scene, Map::new());
    for field in FIELDS {
        let ([least, greatest], read) = (field.limits(), (field.read)(scene));
        let words: Vec<_> = (0..field.size()).map(|element| field.word(&mut copy, element)).collect();
        let usable = |(element, word): (usize, &u64)| {
            let value = field.value_of(*word);
            match field.place {
                Place::Reals(..) => element < read || (value.is_finite() && least <= value && value <= greatest),
                _ => *word <= i32::MAX as u64,
            }
        };
        if scene.drive != Drive::Free || !words.iter().enumerate().all(usable) {
            return None;
        }
        let value = |word: &u64| match field.place {
            Place::Reals(..) => number(f64::from_bits(*word)),
            Place::Flag(_) => json!(*word == 1),
            _ => json!(word),
        };
        let value = match (&words[..], field.shape()) {
            ([word], []) => value(word),
            (words, _) => words.iter().map(value).collect(),
        };
        let known = VARIABLES.iter().find(|variable| variable.field().is_some_and(|own| own.name == field.name));
        values.insert(known?.name.into(), value);
    }
    Some(values)
}

/// What the FMU must show, by output name.
fn outputs(sim: &mut Sim<'_>) -> Result<Map<String, Value>> {
    let (mut outputs, mut readings) = (Map::new(), Readings::default());
    for output in OUTPUTS.iter().filter(|output| output.fmi.1 > 0 && !matches!(output.get, Get::Ply(_))) {
        let all = readings.read(sim, output)?;
        let numbers = &all[..output.size()];
        outputs.insert(output.fmi.0.into(), if output.shape.is_empty() { json!(numbers[0]) } else { json!(numbers) });
    }
    outputs.insert("status".into(), json!(sim.outcomes().status as u32));
    Ok(outputs)
}

/// JSON has no NaN and no infinity: they travel as text that Python's `float` reads.
fn number(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { json!(value.to_string()) }
}
