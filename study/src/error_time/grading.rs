//! Graded networks against the whole fabric: whole impacts until the body is arrested or has exited.
//!
//! Runs of an ensemble differ by 1e-12 in the impact velocity; drawn yarn is the same (seed 1) in all of them. The error of a setting is
//! that of its mean against the mean of the fabric; beside it stands what the scatter of both leaves open, two standard errors.
//! The chaos floor is the deviation of the fabric's runs.

use super::{Cell, Effort, Table, impact, node_steps};
use crate::event::mask_of;
use crate::machine::Clock;
use crate::memory::Buffers;
use crate::progress::Progress;
use crate::{Result, report};
use fabric::{AttachmentKind, Outcome, Scene};
use rayon::prelude::*;
use std::path::Path;

/// Time after which a run is given up, s.
const LONGEST: f64 = 4e-3;
/// Energies of the sphere, J.
const ENERGIES: [f64; 3] = [10.0, 40.0, 160.0];

/// An impact.
struct Case {
    name: String,
    scene: Scene,
    runs: usize,
}

/// The network of a setting.
#[derive(Clone, Copy, PartialEq)]
enum Network {
    Fabric,
    /// Half-width of the fine part in spacings, most yarns of a bar, bars of each size.
    Given(f64, u32, u32),
}

impl Network {
    fn name(self) -> String {
        match self {
            Network::Fabric => "fabric".to_string(),
            Network::Given(half, largest, run) => format!("{half} h, up to {largest}, {run} each"),
        }
    }

    fn of(self, mut scene: Scene) -> Scene {
        if let Network::Given(half, largest, run) = self {
            let half_width = scene.spacings().map(|h| half * h);
            scene.sheet.grading = fabric::Grading { largest, run, centre: [0.0; 2], half_width };
        }
        scene
    }
}

/// One run: absorbed energy, J; velocity at the end, m/s; force evaluations; processor time, s.
type Run = [f64; 4];

fn run_of(case: &Case, network: Network, k: usize) -> Result<Option<Run>> {
    let mut scene = network.of(case.scene);
    if std::env::var("GR_SEEDS").is_ok() { scene.seed += k as u64; } else {
    scene.projectile.velocity[2] *= 1.0 + k as f64 * impact::ROUNDING; }
    let mut buffers = Buffers::of(&scene)?;
    let mut sim = buffers.sim(&scene)?;
    let steps = (LONGEST / sim.step_limits().dt) as u64;
    let end = match scene.attachment.kind {
        AttachmentKind::FourCorners => mask_of(&[Outcome::Arrested, Outcome::Detached, Outcome::Exited]),
        _ => mask_of(&[Outcome::Arrested, Outcome::Exited]),
    };
    let clock = Clock::start();
    if sim.advance_until(end, steps)? == steps {
        return Ok(None);
    }
    let seconds = clock.seconds();
    Ok(Some([sim.contact()?.work, sim.projectile()?.velocity[2], node_steps(&sim), seconds]))
}

fn cases(effort: Effort) -> Vec<Case> {
    let kinds = [
        ("four sides", AttachmentKind::FourSides),
        ("two sides", AttachmentKind::TwoSides),
        ("corners", AttachmentKind::FourCorners),
    ];
    let mut cases = Vec::new();
    let env = std::env::var("GR_CASES").unwrap_or_default();
    let nruns: usize = std::env::var("GR_RUNS").ok().and_then(|x| x.parse().ok()).unwrap_or(4);
    for (name, kind) in kinds {
        for energy in ENERGIES {
            let mut scene = Scene::sheet_3in_sphere();
            scene.attachment.kind = kind;
            scene.yarn.stochastic = std::env::var("GR_SEEDS").is_ok();
            scene.projectile.velocity[2] = (2.0 * energy / scene.projectile.mass).sqrt();
            cases.push(Case { name: format!("3 in, {name}, {energy} J"), scene, runs: nruns });
        }
    }
    let _ = effort;
    cases.push(Case { name: "10 in preset".into(), scene: Scene::sheet_10in_cylinder(), runs: nruns });
    cases.retain(|case| env.split(';').any(|e| case.name.contains(e)));
    cases
}

fn networks() -> Vec<Network> {
    let mut v = vec![Network::Fabric];
    for s in std::env::var("GR_NETS").unwrap_or_default().split(';').filter(|s| !s.is_empty()) {
        let p: Vec<f64> = s.split(',').map(|x| x.parse().unwrap()).collect();
        v.push(Network::Given(p[0], p[1] as u32, p[2] as u32));
    }
    v
}

/// Measures and writes.
pub fn run(effort: Effort, out: &Path) -> Result<()> {
    let cases = cases(effort);
    let networks = networks();
    let jobs: Vec<(&Case, Network, usize)> = cases
        .iter()
        .flat_map(|case| networks.iter().flat_map(move |network| (0..case.runs).map(move |k| (case, *network, k))))
        .collect();
    let progress = Progress::new("graded networks", jobs.len() as u64);
    let runs: Vec<Option<Run>> = jobs
        .par_iter()
        .with_max_len(1)
        .map(|(case, network, k)| {
            let run = run_of(case, *network, *k).map_err(|error| error.to_string())?;
            progress.add(1, || case.name.clone());
            Ok(run)
        })
        .collect::<std::result::Result<_, String>>()?;
    progress.finish();
    let mut table = Table::new(&[
        "case", "network", "runs", "lost", "absorbed J", "deviation %", "error %", "open %", "velocity m/s", "deviation v %", "error v %", "open v %",
        "node-steps", "times fewer", "CPU s", "times faster",
    ]);
    for case in &cases {
        let own = |network: Network| -> Vec<Option<Run>> {
            let of = |((a, with, _), _): &(&(&Case, Network, usize), &Option<Run>)| std::ptr::eq(*a, case) && *with == network;
            jobs.iter().zip(&runs).filter(of).map(|(_, run)| *run).collect()
        };
        let fabric: Vec<Run> = own(Network::Fabric).into_iter().flatten().collect();
        for &network in &networks {
            let all = own(network);
            let good: Vec<Run> = all.iter().flatten().copied().collect();
            let column = |runs: &[Run], index: usize| -> Vec<f64> { runs.iter().map(|run| run[index]).collect() };
            let mut row = vec![Cell::text(&*case.name), Cell::text(network.name()), Cell::Number(good.len() as f64)];
            row.push(Cell::Number((all.len() - good.len()) as f64));
            for index in [0, 1] {
                let (own, reference) = (column(&good, index), column(&fabric, index));
                let (mean, of) = (report::mean(&own), report::mean(&reference));
                let square = |x: &[f64]| report::deviation(x).powi(2) / x.len() as f64;
                let diff: Vec<f64> = own.iter().zip(&reference).map(|(a, b)| a - b).collect();
                let open = if std::env::var("GR_SEEDS").is_ok() { 2.0 * square(&diff).sqrt() } else { 2.0 * (square(&own) + square(&reference)).sqrt() };
                row.extend([mean, 100.0 * report::deviation(&own) / of, 100.0 * (mean / of - 1.0), 100.0 * open / of].map(Cell::Number));
            }
            let (steps, all_steps) = (report::mean(&column(&good, 2)), report::mean(&column(&fabric, 2)));
            let (seconds, all_seconds) = (report::mean(&column(&good, 3)), report::mean(&column(&fabric, 3)));
            row.extend([steps, all_steps / steps, seconds, all_seconds / seconds].map(Cell::Number));
            table.add(row);
        }
    }
    table.write(&out.join("grading.csv"))
}
