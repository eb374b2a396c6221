//! The micro scale: yarns as bundles of the paper's fibrils, and the law fitted to them.

use crate::errors::bad;
use fabric_host::in_our_environment;
use fabric_kernel::calibrate::{Fit, FittedLaw, fit};
use fabric_kernel::fibril::{Bundle, BundleYarn};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};

/// Strain before and after a rupture at which its stress is taken.
const JUST: f64 = 1e-9;

/// The paper's bundle; `straight`: of fibrils without offset.
fn bundle(straight: bool) -> Bundle {
    let zylon = Bundle::zylon();
    if straight { Bundle { offset_sd: 0.0, ..zylon } } else { zylon }
}

/// What a yarn of the population gives.
fn with_yarn<T>(bundle: &Bundle, seed: u64, number: u64, read: impl FnOnce(&BundleYarn<'_>) -> T) -> PyResult<T> {
    let mut memory = vec![0.0; BundleYarn::reals(bundle)];
    let found = in_our_environment(|| BundleYarn::draw(bundle, seed, number, &mut memory).map(|yarn| read(&yarn)));
    found.ok_or_else(|| bad("number", "number: the bundle has no fibril".into()))
}

/// Modulus, Pa, damage rate and misfit of each of the first yarns of a population.
#[pyfunction]
pub fn yarns_of_fibrils<'py>(py: Python<'py>, seed: u64, count: u64) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let bundle = bundle(false);
    let row = |number| {
        let read = |yarn: &BundleYarn<'_>| {
            let law = fit(yarn, bundle.critical_stretch, Fit::Rate);
            vec![yarn.modulus(1.0), law.damage_rate, law.misfit]
        };
        with_yarn(&bundle, seed, number, read)
    };
    let rows: Vec<Vec<f64>> = py.detach(|| (0..count).map(row).collect::<PyResult<_>>())?;
    Ok(PyArray2::from_vec2(py, &rows)?)
}

/// One yarn of a population.
#[pyfunction]
#[pyo3(signature = (seed, number, *, straight = false))]
pub fn yarn_of_fibrils<'py>(py: Python<'py>, seed: u64, number: u64, straight: bool) -> PyResult<Bound<'py, PyDict>> {
    let bundle = bundle(straight);
    let critical = bundle.critical_stretch;
    let read = |yarn: &BundleYarn<'_>| {
        let stretches: Vec<f64> = (0..bundle.fibrils as usize).filter_map(|k| yarn.rupture_stretch(k)).collect();
        let alphas: Vec<f64> = stretches.iter().map(|stretch| yarn.alpha(stretch + JUST)).collect();
        let left = yarn.stress(critical + JUST) / yarn.stress(critical - JUST);
        let laws = [Fit::Rate, Fit::RateAndConstants].map(|kind| fit(yarn, critical, kind));
        (stretches, alphas, [yarn.modulus(1.0), yarn.work_to_rupture(), left], laws)
    };
    let (stretches, alphas, [modulus, work, left], laws) = with_yarn(&bundle, seed, number, read)?;
    let (mean, of_fibril) = in_our_environment(|| bundle.expected_modulus());
    let all =
        [("modulus", modulus), ("work", work), ("left", left), ("critical_stretch", critical)].into_py_dict(py)?;
    let constants = |law: FittedLaw| (law.damage_rate, law.a, law.b);
    all.set_item("laws", <(_, _)>::from(laws.map(constants)))?;
    all.set_item("expected_modulus", (mean, of_fibril / fabric_kernel::math::sqrt(f64::from(bundle.fibrils))))?;
    all.set_item("ruptures", PyArray1::from_vec(py, stretches))?;
    all.set_item("alpha", PyArray1::from_vec(py, alphas))?;
    Ok(all)
}
