//! Refusals and failures as Python's exceptions.

use fabric::fields::{FIELDS, field};
use fabric_scene::BadKey;
use pyo3::create_exception;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

create_exception!(
    fabric_kernel,
    Refused,
    PyValueError,
    "What was asked for cannot be; nothing has changed. `field` names the parameter or argument, `code` the reason, `other` the \
     parameter that it does not go with; `value` and `limit` are the number found and the limit it crosses, in SI units."
);
create_exception!(
    fabric_kernel,
    Failed,
    PyRuntimeError,
    "The computation cannot go on: `code` says why. Every call repeats it until `reset` or `restore`."
);

/// What the kernel says.
pub fn of(error: fabric::Error) -> PyErr {
    let code = format!("{:?}", error.code);
    if error.code.number() > -50 {
        let mut text = error.text().to_string();
        let limits = field(error.field).map(|field| field.limits());
        if let (fabric::Code::OutOfRange, Some([least, greatest])) = (error.code, limits)
            && !(least..=greatest).contains(&error.value)
        {
            text += &format!("; it goes from {least} to {greatest}");
        }
        return refused([error.field, error.with], &code, text, [error.value, error.limit]);
    }
    let failed = Failed::new_err(error.text().to_string());
    with(failed, |failed| failed.setattr("code", code))
}

/// A failure of a step.
pub fn failed(failure: fabric::Failure) -> PyErr {
    of(failure.into())
}

/// What the reader of scenes says.
pub fn of_scene(error: Box<dyn std::error::Error>) -> PyErr {
    if let Some(error) = error.downcast_ref::<fabric::Error>() {
        return of(*error);
    }
    let key = error.downcast_ref::<BadKey>().map_or("", |bad| &bad.key);
    let mut text = error.to_string();
    if !key.is_empty() && text.starts_with("unknown key") {
        text += &meant(key);
    }
    bad(key, text)
}

/// What somebody may have meant who wrote a key that there is not.
fn meant(key: &str) -> String {
    let names = || FIELDS.iter().map(|field| field.name);
    let (name, last) = (key.split('[').next().unwrap_or(key), key.rsplit('.').next().unwrap_or(key));
    if field(name).is_some() {
        return format!("; an element has no key of its own: set the whole of `{name}`");
    }
    let mut near: Vec<String> =
        names().filter(|name| name.rsplit('.').next() == Some(last)).map(String::from).collect();
    if near.is_empty() {
        let close = |py: Python<'_>| -> PyResult<Vec<String>> {
            let names: Vec<&str> = names().collect();
            py.import("difflib")?.call_method1("get_close_matches", (key, names))?.extract()
        };
        near = Python::attach(close).unwrap_or_default();
    }
    let near: Vec<String> = near.iter().map(|name| format!("`{name}`")).collect();
    if near.is_empty() { String::new() } else { format!("; is it {}?", near.join(" or ")) }
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
