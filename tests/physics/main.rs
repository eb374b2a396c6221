//! Physics: each test knows its answer from mathematics (a closed form, an order of convergence, a balance),
//! not from an earlier run. Numbers that the kernel's own unit tests already show (yarn law, shapes, step
//! limit) are not repeated.
#![allow(clippy::disallowed_methods)] // Expected values may come from the host's own functions.

mod balances;
mod clamps;
mod contact;
mod convergence;
mod depth;
mod edges;
mod fabrics;
mod force_window;
mod frames;
mod free_flight;
mod friction;
mod grading;
mod long_yarn;
mod oscillator;
mod outcomes;
mod plies;
mod prescribed;
mod rate;
mod rings;
mod rotation;
mod shapes;
mod sliding;
mod stability;
mod starts;
mod strength;
mod supports;
mod symmetry;
mod theta;
mod thickness;
mod viscosity;
mod wraps;

/// So many random cases, the same every time.
fn random(cases: u32) -> proptest::test_runner::Config {
    let rng_seed = proptest::test_runner::RngSeed::Fixed(1);
    proptest::test_runner::Config { cases, failure_persistence: None, rng_seed, ..Default::default() }
}

/// Asserts that errors at steps that are halved from one to the next fall with the square of the step, the
/// order 2 to this much.
#[track_caller]
fn second_order(errors: &[f64], off: f64) {
    let orders: Vec<f64> = errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
    assert!(orders.iter().all(|order| (order - 2.0).abs() < off), "orders {orders:?} of {errors:?}");
}
