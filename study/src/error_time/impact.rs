//! Whole impacts: the preset sphere at 40 J on the 3 in sheet, every attachment, uniform and stochastic yarn.
//!
//! The error of a setting is that of its ensemble mean against velocity Verlet at 0.05 dt_crit on the full network. Runs of
//! an ensemble differ by 1e-12 in the impact velocity; a stochastic sheet is the same one (seed 1) in all of them.
//!
//! A run ends when the sphere is arrested or has exited, at the corners when the last yarn from the sphere to a support is gone:
//! whether the torn sheet pulls once more is up to rounding. Runs there are long and scatter much: fewer of them, and the
//! reference is at 0.1 dt_crit.

use super::coarse::coarsened;
use super::{Cell, Effort, Table, node_steps, theta, with_step};
use crate::event::mask_of;
use crate::machine::Clock;
use crate::memory::Buffers;
use crate::progress::Progress;
use crate::{Result, report};
use fabric::internals::parts::{STEP_DEFAULT_FRACTION, STEP_MAX_FRACTION};
use fabric::{
    AttachmentKind, Failure, Integrator, Outcome, OutcomeSet, Scene, Sim, StepAfterFailure, Symmetry, TimeStep,
};
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

/// Number of measures.
const COUNT: usize = 6;
/// Index of the absorbed energy.
pub const ABSORBED: usize = 0;
/// Index of the residual velocity.
pub const VELOCITY: usize = 1;
/// All measures, in J, m/s, N, us, % of the segments, % of KE0, as columns are called.
const MEASURES: [&str; COUNT] = ["absorbed", "velocity", "force", "exit", "failed", "residual"];

/// One impact: attachment and yarn.
#[derive(Clone, Copy)]
pub struct Case {
    /// Name for tables.
    pub name: &'static str,
    /// Name for files.
    pub file: &'static str,
    kind: AttachmentKind,
    /// Whether its segments are drawn.
    pub stochastic: bool,
}

const fn case(name: &'static str, file: &'static str, kind: AttachmentKind, stochastic: bool) -> Case {
    Case { name, file, kind, stochastic }
}

/// What ends a run of a case.
fn end(kind: AttachmentKind) -> OutcomeSet {
    match kind {
        AttachmentKind::FourCorners => mask_of(&[Outcome::Arrested, Outcome::Detached, Outcome::Exited]),
        _ => mask_of(&[Outcome::Arrested, Outcome::Exited]),
    }
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
fn until_failure(scene: &Scene, sim: &mut Sim<'_>, end: OutcomeSet, steps: u64) -> std::result::Result<(), Failure> {
    let halves = scene.step_after_failure == StepAfterFailure::Half;
    while halves && sim.counters().failed_segments == 0 && sim.step_count() < steps && !sim.outcomes().mask.has(end) {
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

/// Measures and writes.
pub fn run(effort: Effort, out: &Path) -> Result<()> {
    let cases: &[Case] = match effort {
        Effort::Smoke => &CASES[..1],
        Effort::Quick => &[CASES[0], CASES[1], CASES[2]],
        Effort::Full => &CASES,
    };
    let jobs: Vec<(Case, Setting, usize)> = (0..cases.len())
        .flat_map(|index| settings(index, effort).into_iter().map(move |(setting, runs)| (cases[index], setting, runs)))
        .collect();
    let mut heading = vec![
        "case",
        "file",
        "family",
        "dt_over_dt_crit",
        "accepted",
        "default",
        "plain",
        "full_network",
        "toe",
        "runs",
        "node_steps",
        "cpu_seconds",
        "trouble",
    ];
    let columns: Vec<String> =
        MEASURES.iter().flat_map(|name| [name.to_string(), format!("{name}_deviation")]).collect();
    heading.extend(columns.iter().map(String::as_str));
    let mut table = Table::new(&heading);
    for ((case, ..), of) in jobs.iter().zip(ensembles("whole impacts", &jobs, effort)?) {
        let setting = of.setting;
        let plain = setting == Setting::verlet(setting.step);
        let mut row = vec![Cell::text(case.name), Cell::text(case.file), Cell::text(setting.family())];
        row.push(Cell::Number(setting.step));
        let is = [setting.accepted(), setting.is_default(), plain, setting.network == Network::Full, setting.toe > 0.0];
        row.extend(is.map(|is| Cell::text(is.to_string())));
        row.extend([of.runs as f64, of.node_steps, of.seconds].map(Cell::Number));
        row.push(Cell::text(of.trouble.join(" ")));
        row.extend(
            of.mean.iter().zip(&of.deviation).flat_map(|(mean, deviation)| [*mean, *deviation].map(Cell::Number)),
        );
        table.add(row);
    }
    table.write(&out.join("impact.csv"))
}
