//! The table of parameters, and values of Python for its rows.

use crate::errors::bad;
use fabric_kernel::fields::{FIELDS, Field, Place};
use fabric_scene::short;
use numpy::PyReadonlyArrayDyn;
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyBool, PyByteArray, PyBytes, PyDict, PyInt, PyString, PyTuple};
use toml::{Table, Value};

/// Tables of tables, and rows of rows, are no deeper than this.
const DEEPEST: usize = 4;
/// No parameter has more elements or rows.
const LONGEST: usize = 1000;

/// The rows of the table of parameters: a dictionary for each, with its name, shape, unit, least and greatest
/// value, choices and meaning.
#[pyfunction]
pub fn parameters(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    FIELDS.iter().map(|field| row(py, field)).collect()
}

fn row<'py>(py: Python<'py>, field: &Field) -> PyResult<Bound<'py, PyDict>> {
    let row = PyDict::new(py);
    row.set_item("name", field.name)?;
    row.set_item("shape", PyTuple::new(py, field.shape())?)?;
    row.set_item("unit", field.quantity.map_or("", |quantity| quantity.unit))?;
    let [least, greatest] = field.limits();
    row.set_item("least", least)?;
    row.set_item("greatest", greatest)?;
    let choices = match field.place {
        Place::Choice(choice, ..) => choice.items.iter().map(|(name, _)| *name).collect(),
        _ => Vec::new(),
    };
    row.set_item("choices", PyTuple::new(py, choices)?)?;
    row.set_item("about", field.about)?;
    Ok(row)
}

/// A parameter's value: a number, a truth value, a name, or tuples of numbers.
pub fn value<'py>(py: Python<'py>, field: &Field, scene: &fabric_kernel::Scene) -> PyResult<Bound<'py, PyAny>> {
    let mut scene = *scene;
    let words: Vec<u64> = (0..field.size()).map(|element| field.word(&mut scene, element)).collect();
    let first = words.first().copied().unwrap_or(0);
    let reals: Vec<f64> = words.into_iter().map(f64::from_bits).collect();
    match field.place {
        Place::Reals(_, []) => reals[0].into_bound_py_any(py),
        Place::Reals(_, [_]) => Ok(PyTuple::new(py, reals)?.into_any()),
        Place::Reals(_, shape) => {
            let rows = reals.chunks(shape[1]).take(scene.projectile.faces.in_use().len());
            let rows = rows.map(|row| PyTuple::new(py, row)).collect::<PyResult<Vec<_>>>()?;
            Ok(PyTuple::new(py, rows)?.into_any())
        }
        Place::Count(_) | Place::Seed(_) => first.into_bound_py_any(py),
        Place::Flag(_) => (first == 1).into_bound_py_any(py),
        Place::Choice(choice, ..) => {
            choice.items.get(first as usize).map_or("", |(name, _)| *name).into_bound_py_any(py)
        }
    }
}

/// A dictionary as a scene file has it. `group`: the names of the tables around it.
pub fn table(group: &str, given: &Bound<'_, PyDict>, depth: usize) -> PyResult<Table> {
    let mut table = Table::new();
    for (key, value) in given {
        let name = key.extract::<String>().map_err(|_| bad(group, format!("{group}: a key must be a text")))?;
        if name.len() > LONGEST {
            return Err(bad(group, format!("{group}: unknown key `{}`", short(&name))));
        }
        let whole = if group.is_empty() { name.clone() } else { format!("{group}.{name}") };
        let value = toml_value(&whole, &value, depth)?;
        table.insert(name, value);
    }
    Ok(table)
}

/// A value of Python as a scene file has it.
fn toml_value(key: &str, given: &Bound<'_, PyAny>, depth: usize) -> PyResult<Value> {
    if depth > DEEPEST {
        return Err(bad(key, format!("{key}: tables or arrays one in the other")));
    }
    if let Ok(text) = given.cast::<PyString>() {
        let text = text.extract().map_err(|_| bad(key, format!("{key}: a text that is no Unicode")))?;
        return Ok(Value::String(text));
    }
    if let Ok(inner) = given.cast::<PyDict>() {
        return Ok(Value::Table(table(key, inner, depth + 1)?));
    }
    // NumPy's, too; whole numbers are none.
    if let Ok(flag) = given.extract::<bool>() {
        return Ok(Value::Boolean(flag));
    }
    if let Ok(whole) = given.extract::<i64>() {
        return Ok(Value::Integer(whole));
    }
    if given.is_instance_of::<PyInt>() && !given.is_instance_of::<PyBool>() {
        return Err(bad(key, format!("{key}: whole numbers lie between -2^63 and 2^63 - 1")));
    }
    // Bytes are no array of numbers, although they could be read as one.
    let bytes = given.is_instance_of::<PyBytes>() || given.is_instance_of::<PyByteArray>();
    if let Some(length) = given.len().ok().filter(|_| !bytes) {
        if length > LONGEST {
            return Err(bad(key, format!("{key}: has {length} elements, more than any parameter")));
        }
        let elements = (0..length).map(|k| toml_value(key, &given.get_item(k)?, depth + 1));
        return Ok(Value::Array(elements.collect::<PyResult<_>>()?));
    }
    let number = given.extract().map_err(|_| {
        let kind = given.get_type().name().map_or_else(|_| "this".into(), |name| name.to_string());
        bad(key, format!("{key}: {kind} is neither a number, a truth value, a text, nor an array or table of them"))
    })?;
    Ok(Value::Float(number))
}

/// A value of a scene file as Python has it.
pub fn object<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    match value {
        Value::String(text) => text.into_bound_py_any(py),
        Value::Integer(whole) => whole.into_bound_py_any(py),
        Value::Float(number) => number.into_bound_py_any(py),
        Value::Boolean(flag) => flag.into_bound_py_any(py),
        Value::Datetime(time) => time.to_string().into_bound_py_any(py),
        Value::Array(all) => all.iter().map(|one| object(py, one)).collect::<PyResult<Vec<_>>>()?.into_bound_py_any(py),
        Value::Table(table) => {
            let items = table.iter().map(|(key, one)| Ok((key, object(py, one)?))).collect::<PyResult<Vec<_>>>()?;
            Ok(items.into_py_dict(py)?.into_any())
        }
    }
}

/// An argument of so many numbers.
pub fn array<const N: usize>(name: &str, given: Option<&Bound<'_, PyAny>>, default: [f64; N]) -> PyResult<[f64; N]> {
    let Some(given) = given else { return Ok(default) };
    let numbers = numbers(name, given, &[N])?;
    Ok(std::array::from_fn(|k| numbers[k]))
}

/// The numbers of an array of this shape in the order of its indices, however they lie in memory. Whole
/// numbers and other floats are converted, if a double holds each of their type.
pub fn numbers(name: &str, given: &Bound<'_, PyAny>, shape: &[usize]) -> PyResult<Vec<f64>> {
    let py = given.py();
    let wanted = match shape {
        [count] => format!("{count} numbers"),
        _ => format!("an array of shape {}", PyTuple::new(py, shape)?),
    };
    let refuse = |found: String| bad(name, format!("{name}: must be {wanted}; it is {found}"));
    let numpy = py.import("numpy")?;
    if given.is_instance(&numpy.getattr("ma")?.getattr("MaskedArray")?)? {
        return Err(refuse("masked".into()));
    }
    let array = numpy.call_method1("asarray", (given,)).map_err(|error| {
        let of_it = error.is_instance_of::<PyValueError>(py) || error.is_instance_of::<PyTypeError>(py);
        if of_it { refuse("no array".into()) } else { error }
    })?;
    let (kind, found) = (array.getattr("dtype")?, array.getattr("shape")?);
    let real = ["i", "u", "f"].contains(&kind.getattr("kind")?.extract::<String>()?.as_str());
    if !real || !numpy.call_method1("can_cast", (&kind, "float64"))?.extract::<bool>()? {
        return Err(refuse(format!("of type {kind}")));
    }
    if found.extract::<Vec<usize>>()? != shape {
        return Err(refuse(format!("of shape {found}")));
    }
    // A copy, which no other thread changes while the kernel reads it.
    let order = [("order", "C")].into_py_dict(py)?;
    let doubles = array.call_method("astype", ("float64",), Some(&order))?;
    Ok(doubles.extract::<PyReadonlyArrayDyn<'_, f64>>()?.as_slice()?.to_vec())
}
