//! The smooth phase: error of positions and energy against a run at dt_crit/256, and the order.
//!
//! A flat 21 x 21 sheet on four held sides is thrown along z; there is no contact. Both integrators solve the same equations,
//! so both are compared with the same run: velocity Verlet at dt_crit/256.

use super::{Cell, Effort, Table, integrator_name, node_steps, theta, with_step};
use crate::machine::Clock;
use crate::memory::Buffers;
use crate::progress::Progress;
use crate::{Result, bench, report, say};
use fabric::{Integrator, Scene, TimeStep};
use std::path::Path;

/// A smooth motion.
struct Case {
    name: &'static str,
    /// Velocity at the middle, m/s.
    speed: f64,
    /// End in units of dt_crit.
    time: f64,
}

/// The second ends before the first segment fails: 24 dt_crit = 1.27 us.
const CASES: [Case; 2] =
    [Case { name: "no damage", speed: 150.0, time: 80.0 }, Case { name: "first damage", speed: 1300.0, time: 24.0 }];
const FRACTIONS: [f64; 9] = [0.7, 0.5, 0.4, 0.3, 0.25, 0.125, 0.0625, 0.05, 0.03125];
const TOLERANCES: [f64; 4] = [1e-4, 1e-6, 1e-8, 1e-10];
/// The tolerance at which the theta rule's own order shows.
const TIGHT: f64 = 1e-10;
/// Step of the reference in units of dt_crit.
const REFERENCE: f64 = 1.0 / 256.0;
/// Range in which the observed order must lie, below `ASYMPTOTIC` dt_crit.
const ORDER: std::ops::RangeInclusive<f64> = 1.9..=2.1;
const ASYMPTOTIC: f64 = 0.45;

/// What one run gave.
struct Run {
    positions: Vec<f64>,
    /// What the energy balance does not close by, over the energy at the start.
    residual: f64,
    dt_over_dt_crit: f64,
    steps: u64,
    node_steps: f64,
    seconds: f64,
}

/// One row of smooth.csv.
struct Row {
    case: &'static str,
    integrator: Integrator,
    dt_over_dt_crit: f64,
    steps: u64,
    node_steps: f64,
    seconds: f64,
    /// Largest distance of a node from the reference, m.
    position: f64,
    energy: f64,
    /// Orders of position and energy between this step and the one before it.
    orders: Option<[f64; 2]>,
}

impl Row {
    /// Whether the order of this row must be 2: the integrator's own error, at a step that is small enough.
    fn checked(&self) -> bool {
        let own = self.integrator == Integrator::VERLET || self.integrator.tolerance <= TIGHT;
        own && self.dt_over_dt_crit < ASYMPTOTIC
    }
}

/// False if an order is not 2.
pub fn run(effort: Effort, out: &Path) -> Result<bool> {
    let rows = rows(effort)?;
    let mut table = Table::new(&[
        "case",
        "integrator",
        "dt/dt_crit",
        "steps",
        "node-steps",
        "CPU ms",
        "position error m",
        "order",
        "energy error",
        "order of energy",
    ]);
    for row in &rows {
        let order = |k: usize| row.orders.map_or(Cell::text(""), |orders| Cell::Number(orders[k]));
        table.add(vec![
            Cell::text(row.case),
            Cell::text(integrator_name(row.integrator)),
            Cell::Number(row.dt_over_dt_crit),
            Cell::Number(row.steps as f64),
            Cell::Number(row.node_steps),
            Cell::Number(1e3 * row.seconds),
            Cell::Number(row.position),
            order(0),
            Cell::Number(row.energy),
            order(1),
        ]);
    }
    table.write(&out.join("smooth.csv"))?;
    let (verdict, sound) = verdict(&rows);
    say::line(format_args!("{verdict}"));
    Ok(sound)
}

fn rows(effort: Effort) -> Result<Vec<Row>> {
    let tolerances: &[f64] = if effort == Effort::Smoke { &[1e-6, TIGHT] } else { &TOLERANCES };
    let integrators: Vec<Integrator> =
        std::iter::once(Integrator::VERLET).chain(tolerances.iter().map(|&tolerance| theta(tolerance))).collect();
    let progress = Progress::new("smooth phase", (CASES.len() * (1 + integrators.len() * FRACTIONS.len())) as u64);
    let mut rows: Vec<Row> = Vec::new();
    for case in &CASES {
        let reference = thrown(case, Integrator::VERLET, REFERENCE, 1)?;
        progress.add(1, || case.name.to_string());
        for &integrator in &integrators {
            for (index, fraction) in FRACTIONS.into_iter().enumerate() {
                let repeats = if integrator == Integrator::VERLET { 20 } else { 3 };
                let run = thrown(case, integrator, fraction, repeats)?;
                let apart = |(a, b): (&[f64], &[f64])| fabric::math::length([a[0] - b[0], a[1] - b[1], a[2] - b[2]]);
                let position = run.positions.chunks_exact(3).zip(reference.positions.chunks_exact(3)).map(apart);
                let position = position.fold(0.0, f64::max);
                let orders = rows.last().filter(|_| index > 0).map(|before| {
                    let refined = (before.dt_over_dt_crit / run.dt_over_dt_crit).ln();
                    [(before.position, position), (before.energy, run.residual)]
                        .map(|(coarse, fine)| (coarse / fine).ln() / refined)
                });
                rows.push(Row {
                    case: case.name,
                    integrator,
                    dt_over_dt_crit: run.dt_over_dt_crit,
                    steps: run.steps,
                    node_steps: run.node_steps,
                    seconds: run.seconds,
                    position,
                    energy: run.residual,
                    orders,
                });
                progress.add(1, || format!("{}, {}", case.name, integrator_name(integrator)));
            }
        }
    }
    progress.finish();
    Ok(rows)
}

/// A run whose step is the nearest to `fraction` of dt_crit that ends exactly at the case's time; least time of `repeats`.
fn thrown(case: &Case, integrator: Integrator, fraction: f64, repeats: usize) -> Result<Run> {
    let mut scene = Scene::sheet_3in_sphere();
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (21, 21);
    scene.yarn.stochastic = false;
    scene.projectile.position[2] = -1.0;
    scene.projectile.velocity = [0.0; 3];
    scene.integrator = integrator;
    let dt_crit = scene.step_limits()?.dt_crit;
    let steps = (case.time / fraction).ceil();
    let dt = case.time * dt_crit / steps;
    let scene = with_step(scene, TimeStep::seconds(dt), dt / dt_crit);
    let mut buffers = Buffers::of(&scene)?;
    let mut sim = buffers.sim(&scene)?;
    let mut times = Vec::new();
    let mut start = 0.0;
    for _ in 0..repeats {
        sim.reset();
        bench::throw(&mut sim, case.speed)?;
        let energy = sim.energy()?;
        start = energy.fabric_kinetic + energy.strain;
        let clock = Clock::start();
        sim.advance(steps as u64)?;
        times.push(clock.seconds());
    }
    let mut positions = vec![0.0; 3 * sim.layout().nodes()];
    sim.copy_positions(&mut positions)?;
    Ok(Run {
        positions,
        residual: (sim.energy()?.residual / start).abs(),
        dt_over_dt_crit: dt / dt_crit,
        steps: steps as u64,
        node_steps: node_steps(&sim),
        seconds: report::least(&times),
    })
}

/// Says the range of the orders of either integrator, and whether all are 2. The order of the energy is asked for without
/// damage only: with it, the error changes sign as segments pass the critical stretch.
fn verdict(rows: &[Row]) -> (String, bool) {
    let mut sentences = Vec::new();
    let mut sound = true;
    for integrator in [Integrator::VERLET, theta(TIGHT)] {
        for (k, quantity) in ["position", "energy"].into_iter().enumerate() {
            let orders = rows
                .iter()
                .filter(|row| row.checked() && row.integrator == integrator && (k == 0 || row.case == CASES[0].name))
                .filter_map(|row| Some(row.orders?[k]));
            let (low, high) = orders.fold((f64::MAX, f64::MIN), |(low, high), order| (low.min(order), high.max(order)));
            let as_it_must = ORDER.contains(&low) && ORDER.contains(&high);
            sound &= as_it_must;
            let verdict = if as_it_must { "" } else { ", NOT within 1.9 to 2.1" };
            sentences.push(format!("{}, {quantity}: {low:.3} to {high:.3}{verdict}", integrator_name(integrator)));
        }
    }
    (format!("observed order below {ASYMPTOTIC} dt_crit: {}", sentences.join("; ")), sound)
}
