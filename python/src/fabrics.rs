//! The named fabrics.

use crate::errors;
use fabric_scene::textile;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};

/// Named fabrics: of each its name, its title, the text of its file, and its numbers, NaN where they are of a
/// yarn alone.
#[pyfunction]
pub fn fabrics(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    let all = textile::all().map_err(errors::of_scene)?;
    let row = |textile::Named { name, title, file, textile }| {
        let woven = if textile.warp.count > 0.0 { 1.0 } else { f64::NAN };
        let numbers = [
            ("areal_density", woven * textile.areal_density()),
            ("spacing", woven / textile.weft.count),
            ("area", woven * textile.warp.linear_density / textile.fibre_density),
            ("wave_speed", textile.wave_speed()),
            ("critical_stretch", textile.critical_stretch().map_err(errors::of)?),
        ];
        let found = numbers.into_py_dict(py)?;
        for (key, text) in [("name", name), ("title", &title), ("text", file)] {
            found.set_item(key, text)?;
        }
        Ok(found)
    };
    all.into_iter().map(row).collect()
}
