//! A projectile moved by its host: coupling schemes over the communication step H, against the integrated run.
//!
//! The host holds the sphere's position and velocity. Every H it gives the fabric a path to where it expects the sphere to be,
//! takes back the impulses of the contact, and moves the sphere by them. A scheme is
//! - the force it uses: the mean over H, or the last internal step's ("inst");
//! - the path: C1, a cubic from the pose and rate the fabric now has to those expected at t + H; or "jump", where the fabric is
//!   put right within the first internal step and then moves on as expected;
//! - the expectation: with the last force's acceleration ("acc"), or with the velocity alone ("vel");
//! - the update: impulses act at the start of internal steps, so x += V H + F/(2M) H (H + dt) is exact for a constant force;
//!   "plain" leaves out the dt;
//! - passes: with a rollback, the fabric is put back and H repeated with the force just found.
//!
//! Measures: the velocity at 50 us, before any segment fails, against the integrated run, deterministic; the absorbed energy of
//! the ensemble; the interface energy error, which is what the host's sphere lost less the work done on the fabric.

use super::{Cell, Effort, Table, impact};
use crate::event::{kinetic_energy, mask_of};
use crate::machine::Clock;
use crate::memory::Buffers;
use crate::progress::Progress;
use crate::{Result, report};
use fabric::{Drive, Motion, Outcome, OutcomeSet, Path as Route, Scene, Sim, TimeStep};
use rayon::prelude::*;
use std::path::Path;

/// Internal step, s: that of the FMU.
const DT: f64 = 2e-8;
/// Communication steps in internal steps: 1e-7 ... 1e-5 s.
const EXCHANGES: [u64; 5] = [5, 25, 50, 250, 500];
/// Internal steps to 50 us.
const EARLY: u64 = 2500;
/// Most internal steps of a run.
const LONGEST: u64 = 40_000;

/// What the host does.
#[derive(Clone, Copy)]
struct Scheme {
    name: &'static str,
    mean_force: bool,
    jump: bool,
    accelerated: bool,
    plain: bool,
    /// Repetitions of H with the force just found.
    rollbacks: u32,
}

const fn scheme(name: &'static str, mean_force: bool, jump: bool, accelerated: bool) -> Scheme {
    Scheme { name, mean_force, jump, accelerated, plain: false, rollbacks: 0 }
}

const SCHEMES: [Scheme; 12] = [
    scheme("mean C1 acc", true, false, true),
    scheme("mean C1 vel", true, false, false),
    scheme("mean jump acc", true, true, true),
    scheme("mean jump vel", true, true, false),
    scheme("inst C1 acc", false, false, true),
    scheme("inst C1 vel", false, false, false),
    scheme("inst jump acc", false, true, true),
    scheme("inst jump vel", false, true, false),
    Scheme { plain: true, ..scheme("mean C1 acc, plain", true, false, true) },
    Scheme { rollbacks: 1, ..scheme("mean C1 acc, 1 rollback", true, false, true) },
    Scheme { rollbacks: 2, ..scheme("mean C1 acc, 2 rollbacks", true, false, true) },
    Scheme { rollbacks: 1, ..scheme("mean C1 vel, 1 rollback", true, false, false) },
];

/// One run.
struct Run {
    /// Velocity at 50 us, m/s.
    early: f64,
    residual_velocity: f64,
    /// What the sphere lost, J.
    absorbed: f64,
    /// That less the work on the fabric, over KE0.
    interface: f64,
    peak: f64,
    node_steps: f64,
    seconds: f64,
    /// Whether it was arrested or exited.
    ended: bool,
}

/// A scheme at one H, summed up.
struct Row {
    name: String,
    exchange: f64,
    early: f64,
    interface: f64,
    absorbed: [f64; 2],
    velocity: [f64; 2],
    peak: f64,
    node_steps: f64,
    seconds: f64,
    runs: usize,
    ended: usize,
}

/// Measures, prints, writes.
pub fn run(effort: Effort, out: &Path) -> Result<()> {
    let (runs, exchanges): (usize, &[u64]) = match effort {
        Effort::Smoke => (1, &EXCHANGES[4..]),
        Effort::Quick => (2, &EXCHANGES[2..]),
        Effort::Full => (4, &EXCHANGES),
    };
    // The integrated run first; then every scheme and H.
    let mut jobs: Vec<Option<(Scheme, u64)>> = vec![None];
    jobs.extend(exchanges.iter().flat_map(|&exchange| SCHEMES.map(|scheme| Some((scheme, exchange)))));
    let all: Vec<(usize, usize)> = (0..jobs.len()).flat_map(|job| (0..runs).map(move |k| (job, k))).collect();
    let progress = Progress::new("coupling", all.len() as u64);
    let mut results: Vec<(usize, usize, Run)> = all
        .par_iter()
        .with_max_len(1)
        .map(|&(job, k)| -> std::result::Result<_, String> {
            let scene = scene(k, effort);
            let run = match &jobs[job] {
                None => integrated(&scene),
                Some((scheme, exchange)) => coupled(&scene, scheme, *exchange),
            };
            progress.add(1, || jobs[job].map_or("integrated", |(scheme, _)| scheme.name).to_string());
            Ok((job, k, run.map_err(|error| error.to_string())?))
        })
        .collect::<std::result::Result<_, _>>()?;
    progress.finish();
    results.sort_by_key(|(job, k, _)| (*job, *k));
    let rows: Vec<Row> = jobs
        .iter()
        .enumerate()
        .map(|(job, of)| {
            sum_up(*of, &results.iter().filter(|(j, ..)| *j == job).map(|(.., run)| run).collect::<Vec<_>>())
        })
        .collect();

    let integrated = &rows[0];
    let mut table = Table::new(&[
        "scheme",
        "H s",
        "runs",
        "ended",
        "V(50 us) error m/s",
        "interface energy error % of KE0",
        "absorbed J",
        "absorbed: standard error",
        "velocity m/s",
        "velocity: standard error",
        "peak N",
        "node-steps",
        "CPU s",
    ]);
    for row in &rows {
        table.add(vec![
            Cell::text(&*row.name),
            if row.exchange > 0.0 { Cell::Number(row.exchange) } else { Cell::text("") },
            Cell::Number(row.runs as f64),
            Cell::Number(row.ended as f64),
            Cell::Number(row.early - integrated.early),
            Cell::Number(100.0 * row.interface),
            Cell::Number(row.absorbed[0]),
            Cell::Number(row.absorbed[1]),
            Cell::Number(row.velocity[0]),
            Cell::Number(row.velocity[1]),
            Cell::Number(row.peak),
            Cell::Number(row.node_steps),
            Cell::Number(row.seconds),
        ]);
    }
    table.write(&out.join("coupling.csv"))?;
    Ok(())
}

fn scene(k: usize, effort: Effort) -> Scene {
    let mut scene = impact::scene(&impact::CASES[0], &impact::Setting::verlet(0.4), k, effort);
    scene.time_step = TimeStep::seconds(DT);
    scene
}

fn end() -> OutcomeSet {
    mask_of(&[Outcome::Arrested, Outcome::Exited])
}

/// The kernel moves the sphere.
fn integrated(scene: &Scene) -> Result<Run> {
    let mut buffers = Buffers::of(scene)?;
    let mut sim = buffers.sim(scene)?;
    let clock = Clock::start();
    sim.advance(EARLY)?;
    let early = sim.projectile()?.velocity[2];
    sim.advance_until(end(), LONGEST)?;
    let seconds = clock.seconds();
    let velocity = sim.projectile()?.velocity[2];
    read(scene, &sim, early, velocity, seconds, super::node_steps(&sim))
}

fn read(scene: &Scene, sim: &Sim<'_>, early: f64, velocity: f64, seconds: f64, node_steps: f64) -> Result<Run> {
    let contact = sim.contact()?;
    let start = kinetic_energy(scene);
    let lost = start - 0.5 * scene.projectile.mass * velocity * velocity;
    // The sphere moves along z but for rounding.
    Ok(Run {
        early,
        residual_velocity: velocity,
        absorbed: lost,
        interface: (lost - contact.work) / start,
        peak: contact.force_peak,
        node_steps,
        seconds,
        ended: sim.outcomes().mask.has(end()),
    })
}

/// The sphere as its host holds it.
#[derive(Clone, Copy)]
struct Sphere {
    position: [f64; 3],
    velocity: [f64; 3],
    mass: f64,
}

impl Sphere {
    /// After `time` under a constant force whose impulses act at the start of steps of `dt` (0: all the time).
    fn after(self, force: [f64; 3], time: f64, dt: f64) -> Sphere {
        let mut next = self;
        for (c, force) in force.into_iter().enumerate() {
            let acceleration = force / self.mass;
            next.position[c] += self.velocity[c] * time + 0.5 * acceleration * time * (time + dt);
            next.velocity[c] += acceleration * time;
        }
        next
    }

    fn motion(&self) -> Motion {
        Motion {
            position: self.position,
            velocity: self.velocity,
            orientation: [1.0, 0.0, 0.0, 0.0],
            angular_velocity: [0.0; 3],
        }
    }
}

/// The host moves the sphere.
fn coupled(scene: &Scene, scheme: &Scheme, exchange: u64) -> Result<Run> {
    let mut driven = *scene;
    driven.drive = Drive::Prescribed;
    let mut buffers = Buffers::of(&driven)?;
    let mut sim = buffers.sim(&driven)?;
    let mut image = vec![0; if scheme.rollbacks > 0 { sim.snapshot_bytes() } else { 0 }];
    let body = &scene.projectile;
    let mut sphere = Sphere { position: body.position, velocity: body.velocity, mass: body.mass };
    let dt = if scheme.plain { 0.0 } else { DT };
    let time = exchange as f64 * DT;
    let (mut force, mut early, mut node_steps) = ([0.0; 3], f64::NAN, 0.0);
    let nodes = sim.layout().nodes() as f64;
    let clock = Clock::start();
    while sim.step_count() < LONGEST && !sim.outcomes().mask.has(end()) {
        if scheme.rollbacks > 0 {
            sim.save(&mut image)?;
        }
        for pass in 0..=scheme.rollbacks {
            if pass > 0 {
                sim.load(&image)?;
            }
            // Without the acceleration only a repetition knows the force.
            let expected = if scheme.accelerated || pass > 0 { force } else { [0.0; 3] };
            force = follow(&mut sim, &sphere, expected, scheme, exchange, dt)?;
            node_steps += exchange as f64 * nodes;
        }
        sphere = sphere.after(force, time, dt);
        if sim.step_count() == EARLY {
            early = sphere.velocity[2];
        }
    }
    read(scene, &sim, early, sphere.velocity[2], clock.seconds(), node_steps)
}

/// One communication step of the fabric; the force on the sphere that the host will use.
fn follow(
    sim: &mut Sim<'_>,
    sphere: &Sphere,
    expected: [f64; 3],
    scheme: &Scheme,
    exchange: u64,
    dt: f64,
) -> Result<[f64; 3]> {
    let first = sim.step_count();
    let before = sim.contact()?.impulse;
    let target = |steps: u64| sphere.after(expected, steps as f64 * DT, dt).motion();
    let mut done = 0;
    if scheme.jump {
        sim.follow(&Route { first, steps: 1, end: target(1) }, 1)?;
        done = 1;
    }
    let path = Route { first: first + done, steps: exchange - done, end: target(exchange) };
    sim.follow(&path, exchange - done - 1)?;
    let nearly = sim.contact()?.impulse;
    sim.follow(&path, 1)?;
    let after = sim.contact()?.impulse;
    let (from, time) = if scheme.mean_force { (before, exchange as f64 * DT) } else { (nearly, DT) };
    Ok([0, 1, 2].map(|c| (after[c] - from[c]) / time))
}

fn sum_up(of: Option<(Scheme, u64)>, runs: &[&Run]) -> Row {
    let column = |value: fn(&Run) -> f64| -> Vec<f64> { runs.iter().map(|run| value(run)).collect() };
    let mean = |value: fn(&Run) -> f64| report::mean(&column(value));
    let with_error =
        |value: fn(&Run) -> f64| [mean(value), report::deviation(&column(value)) / (runs.len() as f64).sqrt()];
    Row {
        name: of.map_or("integrated".to_string(), |(scheme, _)| scheme.name.to_string()),
        exchange: of.map_or(0.0, |(_, exchange)| exchange as f64 * DT),
        early: mean(|run| run.early),
        interface: mean(|run| run.interface),
        absorbed: with_error(|run| run.absorbed),
        velocity: with_error(|run| run.residual_velocity),
        peak: mean(|run| run.peak),
        node_steps: mean(|run| run.node_steps),
        seconds: report::least(&column(|run| run.seconds)),
        runs: runs.len(),
        ended: runs.iter().filter(|run| run.ended).count(),
    }
}
