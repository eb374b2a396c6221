//! Graded networks against the whole fabric: whole impacts until the body is arrested or has exited, at corners also detached.
//!
//! On the 3 in sheet runs differ by the seed of drawn yarn, the same seeds for every network; on the 10 in preset by 1e-12 in the
//! impact velocity. The error of a network is that of its mean against the mean of the fabric. "Open" is what the runs leave
//! open of it, two standard errors: of the differences of equal seeds, or of both means.
//! The chaos floor is the deviation of the fabric's own runs.

use super::{Cell, Effort, Table, impact, node_steps};
use crate::event::mask_of;
use crate::machine::Clock;
use crate::memory::Buffers;
use crate::progress::Progress;
use crate::{Result, report};
use fabric::{AttachmentKind, Grading, Outcome, Scene};
use rayon::prelude::*;
use std::path::Path;

/// Time after which a run is given up, s.
const LONGEST: f64 = 4e-3;

/// An impact.
struct Case {
    name: String,
    scene: Scene,
    runs: usize,
    /// Whether runs differ by the seed; else by the impact velocity.
    seeds: bool,
    networks: &'static [Network],
}

/// The network of a setting.
#[derive(Clone, Copy, PartialEq)]
enum Network {
    Fabric,
    /// Half-width of the fine part in spacings, most yarns of a bar, bars of each size.
    Given(f64, u32, u32),
    /// As the kernel chooses it for this error.
    Automatic(f64),
}

const SMALL: [Network; 5] = [
    Network::Fabric,
    Network::Automatic(0.01),
    Network::Automatic(0.03),
    Network::Given(20.0, 2, 4),
    Network::Given(20.0, 4, 4),
];
const LARGE: [Network; 5] = [
    Network::Fabric,
    Network::Automatic(0.01),
    Network::Automatic(0.03),
    Network::Given(40.0, 8, 4),
    Network::Given(40.0, 2, 4),
];

impl Network {
    fn name(self) -> String {
        match self {
            Network::Fabric => "fabric".to_string(),
            Network::Given(half, largest, run) => format!("fine to {half} h, up to {largest}, {run} of each"),
            Network::Automatic(error) => format!("automatic, {} %", 100.0 * error),
        }
    }

    fn of(self, mut scene: Scene) -> Result<Scene> {
        match self {
            Network::Fabric => (),
            Network::Given(half, largest, run) => {
                let half_width = scene.spacings().map(|h| half * h);
                scene.sheet.grading = Grading { largest, run, centre: [0.0; 2], half_width };
            }
            Network::Automatic(error) => scene.set_grading(error)?,
        }
        Ok(scene)
    }
}

/// One run: absorbed energy, J; velocity at the end, m/s; force evaluations; processor time, s.
type Run = [f64; 4];

/// None if it did not end in time.
fn run_of(case: &Case, network: Network, k: usize) -> Result<Option<Run>> {
    let mut scene = network.of(case.scene)?;
    if case.seeds {
        scene.seed += k as u64;
    } else {
        scene.projectile.velocity[2] *= 1.0 + k as f64 * impact::ROUNDING;
    }
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
    let sphere = |name: &str, kind: AttachmentKind, energy: f64, runs: usize| {
        let mut scene = Scene::sheet_3in_sphere();
        scene.attachment.kind = kind;
        scene.projectile.velocity[2] = (2.0 * energy / scene.projectile.mass).sqrt();
        if effort == Effort::Smoke {
            (scene.sheet.nodes_x, scene.sheet.nodes_y) = (41, 41);
        }
        Case { name: format!("3 in, {name}, {energy} J"), scene, runs, seeds: true, networks: &SMALL }
    };
    let four = |energy, runs| sphere("four sides", AttachmentKind::FourSides, energy, runs);
    if effort == Effort::Smoke {
        return vec![four(40.0, 2)];
    }
    let runs = if effort == Effort::Full { 20 } else { 4 };
    let mut cases: Vec<Case> = [10.0, 40.0, 160.0].map(|energy| four(energy, runs)).into();
    cases.push(sphere("two sides", AttachmentKind::TwoSides, 40.0, runs));
    if effort == Effort::Full {
        cases.push(sphere("two sides", AttachmentKind::TwoSides, 10.0, runs));
        cases.push(sphere("two sides", AttachmentKind::TwoSides, 160.0, runs));
        cases.push(sphere("corners", AttachmentKind::FourCorners, 40.0, 10));
        let scene = Scene::sheet_10in_cylinder();
        cases.push(Case { name: "10 in preset".to_string(), scene, runs: 20, seeds: false, networks: &LARGE });
    }
    cases
}

/// Mean, its deviation, error against the reference and what is open of it, all but the mean in % of the reference's mean.
fn compared(own: &[f64], reference: &[f64], paired: bool) -> [f64; 4] {
    let (mean, of) = (report::mean(own), report::mean(reference));
    let variance = |x: &[f64]| report::deviation(x).powi(2) / x.len() as f64;
    let differences: Vec<f64> = own.iter().zip(reference).map(|(a, b)| a - b).collect();
    let open = 2.0 * if paired { variance(&differences) } else { variance(own) + variance(reference) }.sqrt();
    [mean, 100.0 * report::deviation(own) / of, 100.0 * (mean / of - 1.0), 100.0 * open / of]
}

/// Measures and writes.
pub fn run(effort: Effort, out: &Path) -> Result<()> {
    let cases = cases(effort);
    let jobs: Vec<(&Case, Network, usize)> = cases
        .iter()
        .flat_map(|case| case.networks.iter().flat_map(move |network| (0..case.runs).map(move |k| (case, *network, k))))
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
        "case",
        "network",
        "nodes",
        "runs",
        "absorbed J",
        "absorbed: deviation %",
        "absorbed: error %",
        "absorbed: open %",
        "velocity m/s",
        "velocity: deviation %",
        "velocity: error %",
        "velocity: open %",
        "node-steps",
        "times fewer",
        "CPU s",
        "times faster",
    ]);
    for case in &cases {
        // Runs that ended with every network.
        let of = |network: Network| -> Vec<Option<Run>> {
            let own = |job: &(&Case, Network, usize)| std::ptr::eq(job.0, case) && job.1 == network;
            jobs.iter().zip(&runs).filter(|(job, _)| own(job)).map(|(_, run)| *run).collect()
        };
        let fabric = of(Network::Fabric);
        for &network in case.networks {
            let (own, reference): (Vec<Run>, Vec<Run>) =
                of(network).into_iter().zip(&fabric).filter_map(|(a, b)| Some((a?, (*b)?))).unzip();
            let column = |runs: &[Run], index: usize| -> Vec<f64> { runs.iter().map(|run| run[index]).collect() };
            let [nx, ny] = network.of(case.scene)?.network();
            let mut row = vec![Cell::text(&*case.name), Cell::text(network.name()), Cell::text(format!("{nx} x {ny}"))];
            row.push(Cell::Number(own.len() as f64));
            for index in [0, 1] {
                row.extend(compared(&column(&own, index), &column(&reference, index), case.seeds).map(Cell::Number));
            }
            for index in [2, 3] {
                let (own, reference) = (report::mean(&column(&own, index)), report::mean(&column(&reference, index)));
                row.extend([own, reference / own].map(Cell::Number));
            }
            table.add(row);
        }
    }
    table.write(&out.join("grading.csv"))
}
