//! A capsule done again.

use crate::errors;
use fabric_host::in_our_environment;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};
use std::path::PathBuf;

/// Does a capsule again, and says whether the bits are the same.
#[pyfunction]
pub fn replay(py: Python<'_>, file: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    let bytes = std::fs::read(&file)?;
    let mut stopped = None;
    let found = py.detach(|| {
        in_our_environment(|| {
            fabric_scene::replay::replay(&bytes, |_, _, _| {
                stopped = Python::attach(|py| py.check_signals()).err();
                stopped.is_none()
            })
            .map_err(|error| error.to_string())
        })
    });
    if let Some(stopped) = stopped {
        return Err(stopped);
    }
    let found = found.map_err(|text| errors::bad("file", format!("{}: {text}", file.display())))?;
    let all = [("calls", found.calls), ("step", found.step), ("digests", found.digests)].into_py_dict(py)?;
    all.set_item("same", found.difference.is_none())?;
    all.set_item("difference", found.difference)?;
    all.set_item("digest", format!("{:016x}", found.digest))?;
    all.set_item("whole", found.cut.is_none() && found.ended)?;
    all.set_item("version", found.version)?;
    Ok(all)
}
