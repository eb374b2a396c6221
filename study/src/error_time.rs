//! Error over run time: what a step size costs, and what it gives.
//!
//! Two kinds of error, because the model is chaotic beyond the first failure. In the smooth phase (no contact, no failure)
//! positions can be compared point by point with a run at a much smaller step; the observed order is 2. Over a whole impact
//! only means over an ensemble mean something: runs that differ by 1e-12 in the impact velocity. Below the spread of those
//! runs (the chaos floor) no error is evidence.
//!
//! Steps above 0.5 dt_crit are refused by the kernel; here they are run unchecked, to show why.

use crate::event::{Summary, mask_of};
use crate::machine::{self, Clock};
use crate::memory::Buffers;
use crate::plots::{Axes, Plot, Series, Style};
use crate::progress::Progress;
use crate::{Result, bench, report};
use clap::Args;
use fabric::scene::STEP_MAX_FRACTION;
use fabric::{AttachmentKind, Outcome, Scene, StepCheck, TimeStep};
use rayon::prelude::*;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Options of `error-time`.
#[derive(Args)]
pub struct Options {
    /// Fewer runs in each mean: under three minutes on two cores.
    #[arg(long, conflicts_with = "smoke")]
    quick: bool,
    /// A small sheet and two runs in each mean: a check that everything works, not a result.
    #[arg(long)]
    smoke: bool,
    /// Folder for the CSV files and plots.
    #[arg(long, value_name = "DIR", default_value = "target/study/error-time")]
    out: PathBuf,
}

/// A smooth motion: the flat 21 x 21 sheet on four held sides, thrown along z.
struct Smooth {
    name: &'static str,
    /// Velocity at the middle, m/s.
    speed: f64,
    /// End in units of dt_crit.
    time: f64,
}

/// The second ends before the first segment fails: 24 dt_crit = 1.27 us.
const SMOOTH: [Smooth; 2] = [
    Smooth { name: "no damage", speed: 150.0, time: 80.0 },
    Smooth { name: "first damage", speed: 1300.0, time: 24.0 },
];
const SMOOTH_FRACTIONS: [f64; 8] = [0.7, 0.5, 0.4, 0.3, 0.25, 0.125, 0.0625, 0.03125];
/// Steps of the smooth reference in parts of dt_crit.
const SMOOTH_REFERENCE: f64 = 1.0 / 256.0;
/// Range in which the observed order must lie.
const ORDER: std::ops::RangeInclusive<f64> = 1.9..=2.1;

const EVENT_FRACTIONS: [f64; 7] = [0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1];
const EVENT_ENERGY: f64 = 40.0;

/// One row of smooth.csv.
#[derive(Serialize)]
struct SmoothRow {
    case: &'static str,
    dt_over_dt_crit: f64,
    steps: u64,
    seconds: f64,
    /// Largest distance of a node from the reference, m.
    position_error_m: f64,
    /// Energy that the balance does not close by, over the initial energy.
    energy_residual: f64,
    /// Order observed between this step and the one before it; absent in a case's first row.
    order: Option<f64>,
}

/// One row of event.csv: means over the runs, and their standard deviations.
#[derive(Serialize)]
struct EventRow {
    dt_over_dt_crit: f64,
    runs: usize,
    steps: f64,
    seconds_per_run: f64,
    absorbed_j: f64,
    absorbed_sd_j: f64,
    absorbed_error: f64,
    residual_velocity_m_per_s: f64,
    residual_velocity_sd_m_per_s: f64,
    residual_velocity_error: f64,
    peak_force_n: f64,
    peak_force_sd_n: f64,
    failed_segments: f64,
    failed_segments_sd: f64,
    /// Energy that the balance does not close by, in % of the kinetic energy at impact.
    energy_residual_percent: f64,
    timeouts: usize,
}

/// Measures, prints, writes. False if the observed order of the smooth phase is not 2.
pub fn run(options: &Options) -> Result<bool> {
    std::fs::create_dir_all(&options.out).map_err(|error| format!("{}: {error}", options.out.display()))?;
    println!("machine: {}; times are {}", machine::processor(), machine::CLOCK_NAME);
    eprintln!(
        "warning: steps above {STEP_MAX_FRACTION} dt_crit are run unchecked here; everywhere else they are refused"
    );

    let smooth = smooth_rows()?;
    let sound = print_smooth(&smooth);
    write_csv(&options.out.join("smooth.csv"), &smooth)?;
    plot_smooth(&options.out.join("smooth.svg"), &smooth)?;

    let runs = if options.smoke {
        2
    } else if options.quick {
        3
    } else {
        10
    };
    let (events, floor) = event_rows(runs, options.smoke)?;
    print_events(&events, &floor, options.smoke);
    write_csv(&options.out.join("event.csv"), &events)?;
    plot_events(&options.out.join("event.svg"), &events, &floor, options.smoke)?;
    println!("written: {}", options.out.display());
    Ok(sound)
}

fn with_step(mut scene: Scene, step: TimeStep, fraction: f64) -> Scene {
    scene.time_step = step;
    // A hair above the limit is rounding of the step count, not a wish.
    scene.step_check = if fraction > STEP_MAX_FRACTION { StepCheck::None } else { StepCheck::Refuse };
    scene
}

fn smooth_rows() -> Result<Vec<SmoothRow>> {
    let progress = Progress::new("smooth phase", (SMOOTH.len() * (SMOOTH_FRACTIONS.len() + 1)) as u64);
    let mut rows: Vec<SmoothRow> = Vec::new();
    for case in &SMOOTH {
        let (reference, ..) = smooth_run(case, SMOOTH_REFERENCE, 1)?;
        progress.add(1, || case.name.to_string());
        for fraction in SMOOTH_FRACTIONS {
            let (positions, steps, dt_over_dt_crit, energy_residual, seconds) = smooth_run(case, fraction, 20)?;
            let position_error_m = positions
                .chunks_exact(3)
                .zip(reference.chunks_exact(3))
                .map(|(a, b)| crate::event::length([a[0] - b[0], a[1] - b[1], a[2] - b[2]]))
                .fold(0.0, f64::max);
            let order = rows.last().filter(|before| before.case == case.name).map(|before| {
                (before.position_error_m / position_error_m).ln() / (before.dt_over_dt_crit / dt_over_dt_crit).ln()
            });
            rows.push(SmoothRow {
                case: case.name,
                dt_over_dt_crit,
                steps,
                seconds,
                position_error_m,
                energy_residual,
                order,
            });
            progress.add(1, || case.name.to_string());
        }
    }
    progress.finish();
    Ok(rows)
}

/// Final positions, steps, dt/dt_crit, relative energy residual, least seconds of `repeats` runs. The step is the nearest to
/// `fraction` of dt_crit that ends exactly at the case's time.
fn smooth_run(case: &Smooth, fraction: f64, repeats: usize) -> Result<(Vec<f64>, u64, f64, f64, f64)> {
    let mut scene = Scene::sheet_3in_sphere();
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (21, 21);
    scene.yarn.stochastic = false;
    scene.projectile.position[2] = -1.0;
    scene.projectile.velocity = [0.0; 3];
    let dt_crit = scene.step_limits()?.dt_crit;
    let steps = (case.time / fraction).ceil();
    let dt = case.time * dt_crit / steps;
    let scene = with_step(scene, TimeStep::Seconds(dt), dt / dt_crit);
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
    let residual = (sim.energy()?.residual / start).abs();
    Ok((positions, steps as u64, dt / dt_crit, residual, report::least(&times)))
}

/// Prints the rows; whether every order observed at accepted steps is 2.
fn print_smooth(rows: &[SmoothRow]) -> bool {
    println!("\nSmooth phase: largest error of a position against dt_crit/256 (21 x 21 nodes, four sides, no contact)");
    let mut table =
        report::table(&["case", "dt/dt_crit", "steps", "time ms", "position error m", "energy residual", "order"]);
    for row in rows {
        table.add_row(vec![
            row.case.to_string(),
            format!("{:.4}", row.dt_over_dt_crit),
            row.steps.to_string(),
            format!("{:.3}", 1e3 * row.seconds),
            format!("{:.3e}", row.position_error_m),
            format!("{:.1e}", row.energy_residual),
            row.order.map_or(String::new(), |order| format!("{order:.3}")),
        ]);
    }
    println!("{table}");
    let orders = rows.iter().filter(|row| row.dt_over_dt_crit < 0.45).filter_map(|row| row.order);
    let (low, high) = orders.fold((f64::MAX, f64::MIN), |(low, high), order| (low.min(order), high.max(order)));
    let sound = ORDER.contains(&low) && ORDER.contains(&high);
    let verdict = if sound { "as it must be (1.9 to 2.1)" } else { "NOT within 1.9 to 2.1" };
    println!("observed order below 0.45 dt_crit: {low:.3} to {high:.3}: {verdict}");
    sound
}

/// Spread of single runs at the smallest step: below it no difference of two runs means anything.
struct Floor {
    absorbed: f64,
    velocity: f64,
}

fn event_rows(runs: usize, smoke: bool) -> Result<(Vec<EventRow>, Floor)> {
    let fractions: &[f64] = if smoke { &EVENT_FRACTIONS[..6] } else { &EVENT_FRACTIONS };
    let jobs: Vec<(usize, usize)> = (0..fractions.len()).flat_map(|f| (0..runs).map(move |k| (f, k))).collect();
    let cost = |fraction: f64| (100.0 / fraction) as u64;
    let total = jobs.iter().map(|&(f, _)| cost(fractions[f])).sum();
    let progress = Progress::new("40 J, four sides", total);
    let results: Vec<(usize, usize, Summary, f64)> = jobs
        .par_iter()
        .map(|&(f, k)| -> std::result::Result<_, String> {
            let (summary, seconds) = event_run(fractions[f], k, smoke).map_err(|error| error.to_string())?;
            progress.add(cost(fractions[f]), || format!("dt {} dt_crit, run {k}", fractions[f]));
            Ok((f, k, summary, seconds))
        })
        .collect::<std::result::Result<_, _>>()?;
    progress.finish();

    let samples = |index: usize, value: &dyn Fn(&Summary) -> f64| -> Vec<f64> {
        let mut found: Vec<(usize, f64)> =
            results.iter().filter(|(f, ..)| *f == index).map(|(_, k, summary, _)| (*k, value(summary))).collect();
        found.sort_by_key(|(k, _)| *k);
        found.into_iter().map(|(_, value)| value).collect()
    };
    let absorbed = |summary: &Summary| summary.absorbed;
    let velocity = |summary: &Summary| summary.residual_velocity[2];
    let reference = fractions.len() - 1;
    let (best_absorbed, best_velocity) =
        (report::mean(&samples(reference, &absorbed)), report::mean(&samples(reference, &velocity)));
    let floor = Floor {
        absorbed: report::deviation(&samples(reference, &absorbed)),
        velocity: report::deviation(&samples(reference, &velocity)),
    };
    let mut rows = Vec::new();
    for (index, &fraction) in fractions.iter().enumerate() {
        let seconds: Vec<f64> = results.iter().filter(|(f, ..)| *f == index).map(|(.., seconds)| *seconds).collect();
        let (energies, velocities) = (samples(index, &absorbed), samples(index, &velocity));
        let forces = samples(index, &|summary| summary.peak_force);
        let failed = samples(index, &|summary| summary.failed_segments as f64);
        let timeouts = samples(index, &|summary| f64::from(summary.ended_by == "TIMEOUT"));
        rows.push(EventRow {
            dt_over_dt_crit: fraction,
            runs,
            steps: report::mean(&samples(index, &|summary| summary.steps as f64)),
            seconds_per_run: report::least(&seconds),
            absorbed_j: report::mean(&energies),
            absorbed_sd_j: report::deviation(&energies),
            absorbed_error: (report::mean(&energies) / best_absorbed - 1.0).abs(),
            residual_velocity_m_per_s: report::mean(&velocities),
            residual_velocity_sd_m_per_s: report::deviation(&velocities),
            residual_velocity_error: (report::mean(&velocities) / best_velocity - 1.0).abs(),
            peak_force_n: report::mean(&forces),
            peak_force_sd_n: report::deviation(&forces),
            failed_segments: report::mean(&failed),
            failed_segments_sd: report::deviation(&failed),
            energy_residual_percent: report::mean(&samples(index, &|s| 100.0 * s.energy_residual_relative)),
            timeouts: timeouts.iter().sum::<f64>() as usize,
        });
    }
    Ok((rows, floor))
}

/// The k-th run at one step: uniform yarn, four sides, V0 (1 + k 1e-12), until arrested or exited.
fn event_run(fraction: f64, k: usize, smoke: bool) -> Result<(Summary, f64)> {
    let mut scene = Scene::sheet_3in_sphere();
    if smoke {
        (scene.sheet.nodes_x, scene.sheet.nodes_y) = (41, 41);
    }
    scene.attachment.kind = AttachmentKind::FourSides;
    scene.yarn.stochastic = false;
    let speed = (2.0 * EVENT_ENERGY / scene.projectile.mass).sqrt();
    scene.projectile.velocity = [0.0, 0.0, speed * (1.0 + k as f64 * 1e-12)];
    let scene = with_step(scene, TimeStep::Fraction(fraction), fraction);
    let mut buffers = Buffers::of(&scene)?;
    let mut sim = buffers.sim(&scene)?;
    let mask = mask_of(&[Outcome::Arrested, Outcome::Exited]);
    let clock = Clock::start();
    sim.advance_until(mask, (40_000.0 / fraction) as u64)?;
    let seconds = clock.seconds();
    Ok((Summary::of(&sim, mask)?, seconds))
}

fn print_events(rows: &[EventRow], floor: &Floor, smoke: bool) {
    let nodes = nodes(smoke);
    println!(
        "\nWhole impact: {EVENT_ENERGY} J on {nodes} nodes, four sides, uniform yarn; mean ± standard deviation of runs"
    );
    let mut table = report::table(&[
        "dt/dt_crit",
        "runs",
        "steps",
        "s/run",
        "absorbed J",
        "error %",
        "residual velocity m/s",
        "error %",
        "peak force N",
        "failed segments",
        "energy residual % of KE0",
    ]);
    let spread = |mean: f64, sd: f64, digits: usize| format!("{mean:.digits$} ± {sd:.digits$}");
    for row in rows {
        table.add_row(vec![
            format!("{:.2}", row.dt_over_dt_crit),
            if row.timeouts > 0 { format!("{}, {} TIMEOUT", row.runs, row.timeouts) } else { row.runs.to_string() },
            format!("{:.0}", row.steps),
            format!("{:.2}", row.seconds_per_run),
            spread(row.absorbed_j, row.absorbed_sd_j, 3),
            format!("{:.3}", 100.0 * row.absorbed_error),
            spread(row.residual_velocity_m_per_s, row.residual_velocity_sd_m_per_s, 3),
            format!("{:.4}", 100.0 * row.residual_velocity_error),
            spread(row.peak_force_n, row.peak_force_sd_n, 0),
            spread(row.failed_segments, row.failed_segments_sd, 0),
            format!("{:.4}", row.energy_residual_percent),
        ]);
    }
    println!("{table}");
    let last = rows.last().map_or(f64::NAN, |row| row.absorbed_j);
    println!(
        "errors against the smallest step; chaos floor there: absorbed ± {:.3} J ({:.3} %), velocity ± {:.3} m/s",
        floor.absorbed,
        100.0 * floor.absorbed / last,
        floor.velocity
    );
    println!("a small error above {STEP_MAX_FRACTION} dt_crit is luck: the energy residual tells");
}

fn nodes(smoke: bool) -> &'static str {
    if smoke { "41 x 41" } else { "105 x 105" }
}

fn plot_smooth(path: &Path, rows: &[SmoothRow]) -> Result<()> {
    let mut series: Vec<Series> = SMOOTH
        .iter()
        .map(|case| {
            let rows = rows.iter().filter(|row| row.case == case.name);
            Series::new(case.name, Style::Marked, rows.map(|row| (1e3 * row.seconds, row.position_error_m)).collect())
        })
        .collect();
    // Twice the time, a quarter of the error.
    if let (Some(&(x0, y0)), Some(&(x1, _))) = (series[0].points.first(), series[0].points.last()) {
        let points = vec![(x0, 2.0 * y0), (x1, 2.0 * y0 * (x0 / x1) * (x0 / x1))];
        series.push(Series::new("order 2", Style::Dashed, points));
    }
    Plot {
        title: "Smooth phase: error over run time, velocity Verlet, 0.7 to 1/32 dt_crit",
        x: "run time (ms)",
        y: "largest position error (m)",
        axes: Axes::Logarithmic,
        series,
        marks: Vec::new(),
    }
    .write(path)
}

fn plot_events(path: &Path, rows: &[EventRow], floor: &Floor, smoke: bool) -> Result<()> {
    let line = |name: &str, value: &dyn Fn(&EventRow) -> f64| {
        Series::new(name, Style::Marked, rows.iter().map(|row| (row.seconds_per_run, value(row))).collect())
    };
    let level = |name: &str, value: f64| {
        let ends = [rows.first(), rows.last()].into_iter().flatten();
        Series::new(name, Style::Dashed, ends.map(|row| (row.seconds_per_run, value)).collect())
    };
    let (absorbed, velocity) =
        rows.last().map_or((f64::NAN, f64::NAN), |row| (row.absorbed_j, row.residual_velocity_m_per_s));
    let steps = rows.first().zip(rows.last()).map_or(String::new(), |(first, last)| {
        format!("{} to {} dt_crit", first.dt_over_dt_crit, last.dt_over_dt_crit)
    });
    Plot {
        title: &format!("{EVENT_ENERGY} J on four sides, {} nodes: error over run time, {steps}", nodes(smoke)),
        x: "run time (s)",
        y: "error (%)",
        axes: Axes::Logarithmic,
        series: vec![
            line("absorbed energy", &|row| 100.0 * row.absorbed_error),
            line("residual velocity", &|row| 100.0 * row.residual_velocity_error),
            line("energy residual (of KE0)", &|row| row.energy_residual_percent.abs()),
            level("chaos floor, energy", 100.0 * floor.absorbed / absorbed),
            level("chaos floor, velocity", 100.0 * floor.velocity / velocity),
        ],
        marks: Vec::new(),
    }
    .write(path)
}

fn write_csv<T: Serialize>(path: &Path, rows: &[T]) -> Result<()> {
    let mut writer = csv::Writer::from_path(path)?;
    for row in rows {
        writer.serialize(row)?;
    }
    writer.flush()?;
    Ok(())
}
