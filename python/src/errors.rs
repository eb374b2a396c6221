//! Refusals and failures as Python's exceptions.

use fabric_scene::BadKey;
use pyo3::create_exception;
use pyo3::exceptions::{PyMemoryError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;

create_exception!(
    fabric_kernel,
    Refused,
    PyValueError,
    "The request cannot be met; nothing has changed. `field` names the parameter or argument, `code` the reason. The \
     parameter that excludes it, or from which the limit follows, is `other`. Number and limit in SI units: `value`, `limit`."
);
create_exception!(
    fabric_kernel,
    Failed,
    PyRuntimeError,
    "The computation cannot go on: `code` says why. Every call repeats it until `reset` or `restore`."
);

/// What the kernel says.
pub fn of(error: fabric_kernel::Error) -> PyErr {
    let code = format!("{:?}", error.code);
    if error.code.number() > -50 {
        return refused([error.field, error.with], &code, error.to_string(), [error.value, error.limit]);
    }
    let failed = Failed::new_err(error.to_string());
    with(failed, |failed| failed.setattr("code", code))
}

/// A failure of a step.
pub fn failed(failure: fabric_kernel::Failure) -> PyErr {
    of(failure.into())
}

/// Why a simulation of a scene cannot be made: a refusal, with what must be said of its projectile, or the
/// lack of memory.
pub fn of_making(scene: &fabric_kernel::Scene, error: Box<dyn std::error::Error>) -> PyErr {
    let doubt = fabric_scene::notes::unlikely_body(scene).map_or(String::new(), |note| format!("; {note}"));
    error
        .downcast_ref()
        .map_or_else(|| PyMemoryError::new_err(error.to_string()), |error| within("", of(*error), &doubt))
}

/// What the reader of scenes says.
pub fn of_scene(error: Box<dyn std::error::Error>) -> PyErr {
    if let Some(error) = error.downcast_ref::<fabric_kernel::Error>() {
        return of(*error);
    }
    let key = error.downcast_ref::<BadKey>().map_or("", |bad| &bad.key);
    bad(key, error.to_string())
}

/// A refusal between other words, such as the name of the file that it is of.
pub fn within(before: &str, error: PyErr, after: &str) -> PyErr {
    Python::attach(|py| {
        let text = format!("{before}{}{after}", error.value(py));
        with(error, |refused| refused.setattr("args", (text,)))
    })
}

/// A key or an argument that is not what it must be.
pub fn bad(field: &str, text: String) -> PyErr {
    refused([field, ""], "BadValue", text, [0.0, 0.0])
}

fn refused([field, other]: [&str; 2], code: &str, text: String, [value, limit]: [f64; 2]) -> PyErr {
    with(Refused::new_err(text), |refused| {
        refused.setattr("field", field)?;
        refused.setattr("other", other)?;
        refused.setattr("code", code)?;
        refused.setattr("value", value)?;
        refused.setattr("limit", limit)
    })
}

/// The exception with its attributes; or what went wrong with them.
fn with(error: PyErr, set: impl FnOnce(&Bound<'_, PyAny>) -> PyResult<()>) -> PyErr {
    match Python::attach(|py| set(error.value(py).as_any())) {
        Ok(()) => error,
        Err(other) => other,
    }
}
