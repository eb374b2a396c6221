//! Whole impacts: the preset sphere at 40 J on the 3 in sheet, every attachment, uniform and stochastic yarn.
//!
//! The error of a setting is that of its ensemble mean against velocity Verlet at 0.05 dt_crit on the full network. Runs of
//! an ensemble differ by 1e-12 in the impact velocity; a stochastic sheet is the same one (seed 1) in all of them.
//!
//! A run ends when the sphere is arrested or has exited, at the corners when the last yarn from the sphere to a support is gone:
//! whether the torn sheet pulls once more is up to rounding. Runs there are long and scatter much: fewer of them, and the
//! reference is at 0.1 dt_crit.

use super::coarse::coarsened;
use super::document::Document;
use super::front::{self, Judged};
use super::{Cell, Effort, Table, node_steps, plot_errors, theta, with_step};
use crate::event::mask_of;
use crate::machine::Clock;
use crate::memory::Buffers;
use crate::progress::Progress;
use crate::{Result, report};
use fabric::scene::{STEP_DEFAULT_FRACTION, STEP_MAX_FRACTION};
use fabric::{AttachmentKind, Failure, Integrator, Outcome, Scene, Sim, StepAfterFailure, Symmetry, TimeStep};
use rayon::prelude::*;
use std::path::Path;

/// Energy of the sphere, J.
pub const ENERGY: f64 = 40.0;
/// By which the velocities of an ensemble's runs differ: large against rounding, small against everything else.
pub const ROUNDING: f64 = 1e-12;
/// Width of the toe in the settings that have one.
const TOE: f64 = 0.02;
/// Time after which a run is given up, s.
const LONGEST: f64 = 2e-3;

/// What is read off an impact.
pub struct Measure {
    /// Name for tables.
    pub name: &'static str,
    /// File name of its plots.
    pub file: &'static str,
}

const fn measure(name: &'static str, file: &'static str) -> Measure {
    Measure { name, file }
}

/// Number of measures.
pub const COUNT: usize = 6;
/// Index of the absorbed energy.
pub const ABSORBED: usize = 0;
/// Index of the residual velocity.
pub const VELOCITY: usize = 1;
/// Index of the energy residual, whose true value is 0; the errors of all others are relative to the reference.
pub const RESIDUAL: usize = 5;
/// All measures, in J, m/s, N, us, % of the segments, % of KE0.
pub const MEASURES: [Measure; COUNT] = [
    measure("absorbed energy", "absorbed"),
    measure("residual velocity", "velocity"),
    measure("peak force", "force"),
    measure("exit time", "exit"),
    measure("failed segments", "failed"),
    measure("energy residual", "residual"),
];

/// One impact: attachment and yarn.
#[derive(Clone, Copy)]
pub struct Case {
    /// Name for tables.
    pub name: &'static str,
    /// Name for files.
    pub file: &'static str,
    kind: AttachmentKind,
    stochastic: bool,
}

const fn case(name: &'static str, file: &'static str, kind: AttachmentKind, stochastic: bool) -> Case {
    Case { name, file, kind, stochastic }
}

/// What ends a run of a case.
fn end(kind: AttachmentKind) -> u32 {
    match kind {
        AttachmentKind::FourCorners => mask_of(&[Outcome::Arrested, Outcome::Detached, Outcome::Exited]),
        _ => mask_of(&[Outcome::Arrested, Outcome::Exited]),
    }
}

/// Whether a case's segments are drawn.
pub fn stochastic(case: &Case) -> bool {
    case.stochastic
}

/// All cases; the first one gets every setting.
pub const CASES: [Case; 6] = [
    case("four sides, uniform", "four_uniform", AttachmentKind::FourSides, false),
    case("four sides, stochastic", "four_stochastic", AttachmentKind::FourSides, true),
    case("two sides, uniform", "two_uniform", AttachmentKind::TwoSides, false),
    case("two sides, stochastic", "two_stochastic", AttachmentKind::TwoSides, true),
    case("corners, uniform", "corners_uniform", AttachmentKind::FourCorners, false),
    case("corners, stochastic", "corners_stochastic", AttachmentKind::FourCorners, true),
];

/// How a case is computed.
#[derive(Clone, Copy, PartialEq)]
pub struct Setting {
    /// dt over dt_crit of its own network.
    pub step: f64,
    /// How nodes are stepped.
    pub integrator: Integrator,
    /// Network.
    pub network: Network,
    /// What the step does once a segment has failed.
    pub after_failure: StepAfterFailure,
    /// Width of the toe of segments that have been slack; 0 = none.
    pub toe: f64,
}

/// What of the sheet is modelled.
#[derive(Clone, Copy, PartialEq)]
pub enum Network {
    /// Every node.
    Full,
    /// A quarter: the symmetric solution.
    Quarter,
    /// One node for a square of this many nodes a side.
    Coarse(u32),
}

impl Setting {
    /// Velocity Verlet on the full network.
    pub fn verlet(step: f64) -> Setting {
        let after_failure = StepAfterFailure::Keep;
        Setting { step, integrator: Integrator::VERLET, network: Network::Full, after_failure, toe: 0.0 }
    }

    /// The line it belongs to in a plot.
    pub fn family(&self) -> String {
        let mut integrator = super::integrator_name(self.integrator);
        if self.after_failure == StepAfterFailure::Half {
            integrator += ", half after failure";
        }
        if self.toe > 0.0 {
            integrator += ", toe";
        }
        match self.network {
            Network::Full => integrator,
            Network::Quarter => format!("{integrator}, quarter"),
            Network::Coarse(factor) => format!("{integrator}, {factor} h"),
        }
    }

    /// The kernel's default.
    pub fn is_default(&self) -> bool {
        *self == Setting::verlet(STEP_DEFAULT_FRACTION)
    }

    /// Whether the kernel accepts the step.
    pub fn accepted(&self) -> bool {
        self.step <= STEP_MAX_FRACTION
    }

    /// Cost guessed beforehand, for the progress bar and to start long runs first.
    fn guess(&self) -> f64 {
        let passes = if self.integrator == Integrator::VERLET { 1.0 } else { 20.0 };
        let share = match self.network {
            Network::Full => 1.0,
            Network::Quarter => 0.3,
            Network::Coarse(factor) => f64::from(factor).powi(-3),
        };
        let half = if self.after_failure == StepAfterFailure::Half { 1.6 } else { 1.0 };
        let toe = if self.toe > 0.0 { 1.2 } else { 1.0 };
        passes * share * half * toe / self.step
    }
}

/// One run of an impact.
pub struct Run {
    /// The measures.
    pub values: [f64; COUNT],
    /// Force evaluations.
    pub node_steps: f64,
    /// Processor time, s.
    pub seconds: f64,
    /// Why the values mean nothing, if they do not.
    pub trouble: Option<String>,
}

/// A setting's runs, summed up.
pub struct Ensemble {
    /// The setting.
    pub setting: Setting,
    /// Runs that ended as they should.
    pub runs: usize,
    /// Mean over the runs of each measure.
    pub mean: [f64; COUNT],
    /// Standard deviation of each measure.
    pub deviation: [f64; COUNT],
    /// Force evaluations of one run.
    pub node_steps: f64,
    /// Least processor time of one run, s.
    pub seconds: f64,
    /// What became of runs that did not end as they should.
    pub trouble: Vec<String>,
}

/// The scene of the k-th run, whose velocity differs by k times 1e-12.
pub fn scene(case: &Case, setting: &Setting, k: usize, effort: Effort) -> Scene {
    scene_at(case, setting, k as f64 * ROUNDING, effort)
}

/// The scene with another velocity, by this part of it.
pub fn scene_at(case: &Case, setting: &Setting, faster: f64, effort: Effort) -> Scene {
    let mut scene = Scene::sheet_3in_sphere();
    if effort == Effort::Smoke {
        (scene.sheet.nodes_x, scene.sheet.nodes_y) = (41, 41);
    }
    scene.attachment.kind = case.kind;
    scene.yarn.stochastic = case.stochastic;
    let speed = (2.0 * ENERGY / scene.projectile.mass).sqrt();
    scene.projectile.velocity = [0.0, 0.0, speed * (1.0 + faster)];
    scene.integrator = setting.integrator;
    scene.step_after_failure = setting.after_failure;
    scene.slack_toe = setting.toe;
    match setting.network {
        Network::Full => (),
        Network::Quarter => scene.symmetry = Symmetry { mirror_x: true, mirror_y: true },
        Network::Coarse(factor) => scene = coarsened(scene, factor),
    }
    with_step(scene, TimeStep::fraction(setting.step), setting.step)
}

/// Runs until the end of the case.
pub fn impact(scene: &Scene) -> Result<Run> {
    let mut buffers = Buffers::of(scene)?;
    let mut sim = buffers.sim(scene)?;
    let steps = (LONGEST / sim.step_limits().dt) as u64;
    let end = end(scene.attachment.kind);
    let clock = Clock::start();
    let whole = until_failure(scene, &mut sim, end, steps);
    let first = sim.step_count();
    let ended = whole.and_then(|()| sim.advance_until(end, steps - first));
    let seconds = clock.seconds();
    // Where the step is halved, steps after the first failure are two passes each.
    let halved = if first > 0 { sim.step_count() - first } else { 0 };
    let node_steps = node_steps(&sim) + halved as f64 * sim.layout().nodes() as f64;
    let trouble = match ended {
        Err(failure) => Some(format!("{failure:?}")),
        Ok(_) if sim.step_count() >= steps => Some("TIMEOUT".to_string()),
        Ok(_) => None,
    };
    if trouble.is_some() {
        return Ok(Run { values: [f64::NAN; COUNT], node_steps, seconds, trouble });
    }
    let (contact, energy) = (sim.contact()?, sim.energy()?);
    let values = [
        contact.work,
        sim.projectile()?.velocity[2],
        contact.force_peak,
        1e6 * sim.time(),
        100.0 * sim.counters().failed_segments as f64 / scene.segments() as f64,
        100.0 * energy.residual / crate::event::kinetic_energy(scene),
    ];
    Ok(Run { values, node_steps, seconds, trouble })
}

/// Where the step is halved after the first failure: runs until then.
fn until_failure(scene: &Scene, sim: &mut Sim<'_>, end: u32, steps: u64) -> std::result::Result<(), Failure> {
    let halves = scene.step_after_failure == StepAfterFailure::Half;
    while halves && sim.counters().failed_segments == 0 && sim.step_count() < steps && sim.outcomes().mask & end == 0 {
        sim.step()?;
    }
    Ok(())
}

/// Runs `runs` of each job, all at once on all cores; ensembles in the order of the jobs.
pub fn ensembles(what: &str, jobs: &[(Case, Setting, usize)], effort: Effort) -> Result<Vec<Ensemble>> {
    let mut all: Vec<(usize, usize)> =
        (0..jobs.len()).flat_map(|job| (0..jobs[job].2).map(move |k| (job, k))).collect();
    let guess = |job: usize| (1.0 + 100.0 * jobs[job].1.guess()) as u64;
    all.sort_by_key(|&(job, _)| std::cmp::Reverse(guess(job)));
    let progress = Progress::new(what, all.iter().map(|&(job, _)| guess(job)).sum());
    // One run at a time is handed out, the longest first, so that no core waits long at the end.
    let mut runs: Vec<(usize, usize, Run)> = all
        .par_iter()
        .with_max_len(1)
        .map(|&(job, k)| -> std::result::Result<_, String> {
            let (case, setting, _) = &jobs[job];
            let run = impact(&scene(case, setting, k, effort)).map_err(|error| error.to_string())?;
            progress.add(guess(job), || format!("{}: {} {}", case.name, setting.family(), setting.step));
            Ok((job, k, run))
        })
        .collect::<std::result::Result<_, _>>()?;
    progress.finish();
    runs.sort_by_key(|(job, k, _)| (*job, *k));
    Ok(jobs
        .iter()
        .enumerate()
        .map(|(job, (_, setting, _))| {
            let own: Vec<&Run> = runs.iter().filter(|(j, ..)| *j == job).map(|(.., run)| run).collect();
            sum_up(*setting, &own)
        })
        .collect())
}

fn sum_up(setting: Setting, runs: &[&Run]) -> Ensemble {
    let good: Vec<&&Run> = runs.iter().filter(|run| run.trouble.is_none()).collect();
    let column = |index: usize| -> Vec<f64> { good.iter().map(|run| run.values[index]).collect() };
    let cost = |value: fn(&Run) -> f64| -> Vec<f64> { runs.iter().map(|run| value(run)).collect() };
    Ensemble {
        setting,
        runs: good.len(),
        mean: std::array::from_fn(|index| report::mean(&column(index))),
        deviation: std::array::from_fn(|index| report::deviation(&column(index))),
        node_steps: report::mean(&cost(|run| run.node_steps)),
        seconds: report::least(&cost(|run| run.seconds)),
        trouble: runs.iter().filter_map(|run| run.trouble.clone()).collect(),
    }
}

/// The settings of a case, the reference first, and how many runs each gets.
fn settings(index: usize, effort: Effort) -> Vec<(Setting, usize)> {
    let case = &CASES[index];
    let corners = case.kind == AttachmentKind::FourCorners;
    let (runs, few): (usize, usize) = match effort {
        Effort::Smoke => (2, 1),
        Effort::Quick => (3, 2),
        Effort::Full => (if corners { 6 } else { 10 }, 2),
    };
    let steps: &[f64] = match effort {
        Effort::Smoke => &[0.2, 0.4],
        Effort::Quick => &[0.1, 0.2, 0.3, 0.4, 0.5],
        Effort::Full if corners => &[0.1, 0.2, 0.3, 0.4, 0.5],
        Effort::Full => &[0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7],
    };
    let mut settings: Vec<(Setting, usize)> = steps.iter().map(|&step| (Setting::verlet(step), runs)).collect();
    let coarse_steps: &[f64] = if effort == Effort::Full { &[0.2, 0.4, 0.5] } else { &[0.4] };
    for &step in coarse_steps {
        if !case.stochastic {
            settings.push((Setting { network: Network::Quarter, ..Setting::verlet(step) }, runs));
        }
        for factor in [2, 4] {
            settings.push((Setting { network: Network::Coarse(factor), ..Setting::verlet(step) }, runs));
        }
    }
    let remedied: &[f64] = if effort == Effort::Full && !corners { &[0.3, 0.4, 0.47, 0.5] } else { &[0.4] };
    for &step in remedied {
        settings.push((Setting { after_failure: StepAfterFailure::Half, ..Setting::verlet(step) }, runs));
    }
    let softened: &[f64] = if effort == Effort::Full && !corners { &[0.3, 0.35, 0.4] } else { &[0.35] };
    for &step in softened {
        settings.push((Setting { toe: TOE, ..Setting::verlet(step) }, runs));
    }
    // The theta rule costs ten times as much: where it is compared, and one point elsewhere.
    let implicit: Vec<(f64, f64)> = match (effort, index) {
        (Effort::Full, 0) => vec![(0.2, 1e-6), (0.4, 1e-4), (0.4, 1e-6), (0.4, 1e-10), (0.5, 1e-6), (0.7, 1e-6)],
        (Effort::Full, 1 | 2) => vec![(0.4, 1e-6)],
        (Effort::Quick | Effort::Smoke, 0) => vec![(0.4, 1e-6)],
        _ => vec![],
    };
    for (step, tolerance) in implicit {
        settings.push((Setting { integrator: theta(tolerance), ..Setting::verlet(step) }, few));
    }
    settings
}

/// Measures, prints, writes.
pub fn run(effort: Effort, out: &Path, document: &mut Document) -> Result<()> {
    let cases: &[Case] = match effort {
        Effort::Smoke => &CASES[..1],
        Effort::Quick => &[CASES[0], CASES[1], CASES[2]],
        Effort::Full => &CASES,
    };
    let jobs: Vec<(usize, Setting, usize)> = (0..cases.len())
        .flat_map(|index| settings(index, effort).into_iter().map(move |(setting, runs)| (index, setting, runs)))
        .collect();
    let flat: Vec<(Case, Setting, usize)> =
        jobs.iter().map(|&(index, setting, runs)| (cases[index], setting, runs)).collect();
    let mut ensembles = ensembles("whole impacts", &flat, effort)?.into_iter();
    let nodes = if effort == Effort::Smoke { 41 } else { 105 };
    let mut csv = csv_table();
    println!(
        "\nfront: on the Pareto front of cost and the error of A absorbed energy, V velocity, P peak force, X exit time, F failed \
         segments, E energy residual; * of all together"
    );
    if effort == Effort::Smoke {
        println!("--smoke: two runs of a small sheet. A check that everything works, not a result");
    }
    for (index, case) in cases.iter().enumerate() {
        let count = jobs.iter().filter(|(of, ..)| *of == index).count();
        let judged = front::judge(ensembles.by_ref().take(count).collect());
        println!("\n{ENERGY} J, {}, {nodes} x {nodes} nodes: mean ± standard error", case.name);
        let table = shown(&judged);
        println!("{}", table.text());
        println!("{}", front::verdict(&judged));
        let choice = front::choice(&judged);
        println!("{}", choice.text());
        for ensemble in &judged.rows {
            csv.add(csv_row(case, ensemble));
        }
        plot(case, &judged, out)?;
        document.impact(case, &table, &front::verdict(&judged), &choice);
    }
    csv.write_csv(&out.join("impact.csv"))
}

/// The table that is printed.
fn shown(judged: &Judged) -> Table {
    let mut table = Table::new(&[
        "setting",
        "dt/dt_crit",
        "runs",
        "node-steps",
        "CPU s",
        "absorbed J",
        "error %",
        "velocity m/s",
        "error %",
        "peak N",
        "error %",
        "exit us",
        "failed %",
        "energy residual % of KE0",
        "front by node-steps",
        "by seconds",
    ]);
    for row in &judged.rows {
        let of = &row.ensemble;
        let value = |index: usize, digits: usize| {
            let error = of.deviation[index] / (of.runs as f64).sqrt();
            let text =
                if of.runs == 0 { "-".into() } else { format!("{:.digits$} ± {error:.digits$}", of.mean[index]) };
            Cell::Number(of.mean[index], text)
        };
        // An error that cannot be told from 0 is shown with the least that could be.
        let error = |index: usize| {
            let (error, floor) = (100.0 * row.error[index], 100.0 * row.resolution[index]);
            let text = if error.is_nan() {
                "-".to_string()
            } else if error < floor {
                format!("< {floor:.2}")
            } else {
                format!("{error:.2}")
            };
            Cell::Number(error, text)
        };
        let mut name = of.setting.family();
        if of.setting.is_default() {
            name += " (default)";
        }
        if !of.setting.accepted() {
            name += " (refused)";
        }
        if let Some(trouble) = of.trouble.first() {
            name += &format!(" [{} x {trouble}]", of.trouble.len());
        }
        table.add(vec![
            Cell::text(name),
            Cell::plain(of.setting.step, 2),
            Cell::plain(of.runs as f64, 0),
            Cell::power(of.node_steps, 2),
            Cell::plain(of.seconds, 3),
            value(0, 3),
            error(0),
            value(1, 3),
            error(1),
            value(2, 1),
            error(2),
            value(3, 1),
            value(4, 2),
            value(RESIDUAL, 4),
            Cell::text(row.marks(0)),
            Cell::text(row.marks(1)),
        ]);
    }
    table
}

fn csv_table() -> Table {
    let mut table = Table::new(&[
        "case",
        "family",
        "dt_over_dt_crit",
        "accepted",
        "default",
        "runs",
        "node_steps",
        "cpu_seconds",
        "trouble",
    ]);
    for measure in &MEASURES {
        let columns = ["mean", "standard_error", "error", "resolution"];
        table.heading.extend(columns.map(|what| format!("{}_{what}", measure.file)));
        table.heading.extend(front::NAMES.map(|front| format!("{}_front_{front}", measure.file)));
    }
    table.heading.extend(front::NAMES.map(|front| format!("all_front_{front}")));
    table
}

fn csv_row(case: &Case, row: &front::Row) -> Vec<Cell> {
    let of = &row.ensemble;
    let number = |value: f64| Cell::Number(value, String::new());
    let mut cells = vec![
        Cell::text(case.name),
        Cell::text(of.setting.family()),
        number(of.setting.step),
        Cell::text(of.setting.accepted().to_string()),
        Cell::text(of.setting.is_default().to_string()),
        number(of.runs as f64),
        number(of.node_steps),
        number(of.seconds),
        Cell::text(of.trouble.join(" ")),
    ];
    for index in 0..COUNT {
        cells.extend([of.mean[index], of.deviation[index] / (of.runs as f64).sqrt()].map(number));
        cells.extend([row.error[index], row.resolution[index]].map(number));
        cells.extend(row.fronts.iter().map(|front| Cell::text(front.each[index].to_string())));
    }
    cells.extend(row.fronts.iter().map(|front| Cell::text(front.all.to_string())));
    cells
}

fn plot(case: &Case, judged: &Judged, out: &Path) -> Result<()> {
    for (index, measure) in MEASURES.iter().enumerate() {
        for (clock, axis, cost, by) in [
            ("steps", "node-steps of one run (force evaluations)", (|of| of.node_steps) as fn(&Ensemble) -> f64, 0),
            ("seconds", "processor time of one run (s)", |of| of.seconds, 1),
        ] {
            let mut lines: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
            for row in judged.rows.iter().filter(|row| !row.reference) {
                let name = row.ensemble.setting.family();
                let point = (cost(&row.ensemble), 100.0 * row.error[index]);
                match lines.iter_mut().find(|(known, _)| *known == name) {
                    Some((_, points)) => points.push(point),
                    None => lines.push((name, vec![point])),
                }
            }
            let marked = |which: &dyn Fn(&front::Row) -> bool| -> Vec<(f64, f64)> {
                let chosen = judged.rows.iter().filter(|row| which(row));
                let mut points: Vec<_> = chosen.map(|row| (cost(&row.ensemble), 100.0 * row.error[index])).collect();
                points.sort_by(|a, b| a.0.total_cmp(&b.0));
                points
            };
            lines.insert(0, (super::FRONT.to_string(), marked(&|row| row.fronts[by].each[index])));
            lines.push(("default".to_string(), marked(&|row| row.ensemble.setting.is_default())));
            let title = format!("{ENERGY} J, {}: error of the {}", case.name, measure.name);
            let path = out.join(format!("{}_{}_{clock}.svg", case.file, measure.file));
            let label = if index == RESIDUAL { "energy residual (% of KE0)" } else { "error of the mean (%)" };
            let levels: &[(&str, f64)] = &[
                ("chaos floor, one run", 100.0 * judged.floor[index]),
                ("resolution of the means", 100.0 * judged.resolution[index]),
            ];
            let levels = if index == RESIDUAL { &levels[..1] } else { levels };
            plot_errors(&path, &title, [axis, label], lines, levels)?;
        }
    }
    Ok(())
}
