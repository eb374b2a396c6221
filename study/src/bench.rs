//! ns per node-step. One node-step is one node advanced by one step, with its two segments.
//!
//! Two cases. "sweep": a moving sheet without a projectile, nothing tracked: the hot pass alone. "run": the preset sphere at
//! 300 m/s on four held sides, taken up after 1000 steps, when contact is wide and the first segments fail or are about to,
//! with supports and detachment tracked. Rows still at rest are stepped too, so that the figure does not depend on how far
//! the wave has come.
//!
//! Method: every instruction set starts from the same image and takes the same steps; the rounds go through all sets in turn,
//! so that a change of the machine's load meets all of them. The least time is the machine's, the median says how quiet it was.
//! All sets must end in the same bits.

use crate::machine::{self, Clock, Wall};
use crate::memory::Buffers;
use crate::progress::Progress;
use crate::{Result, report};
use clap::Args;
use fabric::{AttachmentKind, InstructionSet, Scene, Sim};
use serde::Serialize;
use std::path::PathBuf;

/// Options of `bench`.
#[derive(Args)]
pub struct Options {
    /// Small sheets and few rounds, for a look in seconds.
    #[arg(long)]
    smoke: bool,
    /// Write every row as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Folder for bench.json, as with the other studies.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Only the cases whose name ("sweep 350", "run 105", ...) contains this.
    #[arg(long, value_name = "NAME", default_value = "")]
    only: String,
    /// Only this instruction set: scalar, sse2, avx2 or avx512.
    #[arg(long, value_name = "SET", default_value = "")]
    instructions: String,
}

/// One measured row.
#[derive(Serialize)]
struct Row {
    case: &'static str,
    size: u32,
    instruction_set: &'static str,
    threads: u32,
    /// Least and median over the rounds.
    ns_per_node_step: f64,
    ns_per_node_step_median: f64,
    bytes_per_node: f64,
    steps_per_round: u64,
    rounds: usize,
    contacts: u64,
    failed_segments: u64,
    digest: String,
}

/// Everything in the JSON file.
#[derive(Serialize)]
struct Report {
    machine: String,
    clock: &'static str,
    load_at_start: Option<f64>,
    rows: Vec<Row>,
}

const CASES: [&str; 2] = ["sweep", "run"];
const SIZES: [u32; 5] = [35, 105, 350, 700, 1000];
/// Node-steps in one round: long against the clock, short against a coffee.
const NODE_STEPS: u64 = 20_000_000;

/// Measures, prints and writes. False if two instruction sets disagree about the bits.
pub fn run(options: &Options) -> Result<bool> {
    let sets: Vec<InstructionSet> = InstructionSet::ALL
        .into_iter()
        .filter(|set| set.available() && (options.instructions.is_empty() || set.name() == options.instructions))
        .collect();
    if sets.is_empty() {
        return Err(format!("this machine has no instruction set {:?}", options.instructions).into());
    }
    let cases: Vec<(&'static str, u32)> = SIZES
        .iter()
        .filter(|&&size| !options.smoke || size <= 350)
        .flat_map(|&size| CASES.map(|case| (case, size)))
        .filter(|(case, size)| format!("{case} {size}").contains(&options.only))
        .collect();
    if cases.is_empty() {
        return Err(format!("no case is called {:?}", options.only).into());
    }
    let rounds = if options.smoke { 3 } else { 9 };

    let load = machine::load();
    let wall = Wall::start();
    let progress = Progress::new("bench", (cases.len() * rounds) as u64);
    let mut rows = Vec::new();
    for (case, size) in cases {
        rows.extend(measure(case, size, &sets, rounds, options.smoke, &progress)?);
    }
    progress.finish();

    let report = Report { machine: machine::processor(), clock: machine::CLOCK_NAME, load_at_start: load, rows };
    print(&report, wall.seconds());
    let text = serde_json::to_string_pretty(&report)? + "\n";
    if let Some(path) = &options.json {
        std::fs::write(path, &text)?;
    }
    if let Some(folder) = &options.out {
        std::fs::create_dir_all(folder)?;
        std::fs::write(folder.join("bench.json"), &text)?;
    }
    Ok(same_bits(&report.rows))
}

/// One case at one size, with every instruction set.
fn measure(
    case: &'static str,
    size: u32,
    sets: &[InstructionSet],
    rounds: usize,
    smoke: bool,
    progress: &Progress,
) -> Result<Vec<Row>> {
    let scene = scene(case, size);
    let mut buffers = Buffers::of(&scene)?;
    let mut sim = buffers.sim(&scene)?;
    sim.step_every_row();
    if case == "sweep" {
        throw(&mut sim, 20.0)?;
    }
    sim.advance(1000)?;
    let mut image = vec![0; sim.snapshot_bytes()];
    sim.save(&mut image)?;

    let nodes = sim.layout().nodes() as u64;
    let node_steps = if smoke { NODE_STEPS / 5 } else { NODE_STEPS };
    let steps = (node_steps / nodes).clamp(10, 400);
    // Small sheets are over in milliseconds: repeat the same steps.
    let repeats = (node_steps / (steps * nodes)).max(1);
    let mut times = vec![Vec::new(); sets.len()];
    let mut digests = vec![0; sets.len()];
    for _ in 0..rounds {
        for (index, set) in sets.iter().enumerate() {
            sim.use_instructions(*set)?;
            let mut seconds = 0.0;
            for _ in 0..repeats {
                sim.load(&image)?;
                let clock = Clock::start();
                sim.advance(steps)?;
                seconds += clock.seconds();
            }
            times[index].push(1e9 * seconds / (repeats * steps * nodes) as f64);
            digests[index] = sim.digest();
        }
        progress.add(1, || format!("{case} {size}"));
    }
    let counters = sim.counters();
    let bytes = sim.layout().bytes() as f64 / nodes as f64;
    let row = |(index, set): (usize, &InstructionSet)| Row {
        case,
        size,
        instruction_set: set.name(),
        threads: 1,
        ns_per_node_step: report::least(&times[index]),
        ns_per_node_step_median: report::median(&times[index]),
        bytes_per_node: bytes,
        steps_per_round: steps * repeats,
        rounds,
        contacts: counters.contacts,
        failed_segments: counters.failed_segments,
        digest: format!("{:016x}", digests[index]),
    };
    Ok(sets.iter().enumerate().map(row).collect())
}

fn scene(case: &str, size: u32) -> Scene {
    let mut scene = Scene::sheet_3in_sphere();
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (size, size);
    scene.attachment.kind = AttachmentKind::FourSides;
    if case == "sweep" {
        scene.projectile.position[2] = -1.0;
        scene.projectile.velocity = [0.0; 3];
        (scene.track_support, scene.track_detachment) = (false, false);
    } else {
        scene.projectile.velocity = [0.0, 0.0, 300.0];
    }
    scene
}

/// Gives a flat sheet the velocity `speed` cos(pi x/2a) cos(pi y/2b), m/s, along z.
pub fn throw(sim: &mut Sim<'_>, speed: f64) -> Result<()> {
    let mut positions = vec![0.0; 3 * sim.layout().nodes()];
    sim.copy_positions(&mut positions)?;
    let [a, b] = sim.scene().half_size();
    let mut velocities = vec![0.0; positions.len()];
    for (x, v) in positions.chunks_exact(3).zip(velocities.chunks_exact_mut(3)) {
        // Exactly 0 on the held edge, where the cosine only almost is.
        let inside = x[0].abs() < 0.999_999 * a && x[1].abs() < 0.999_999 * b;
        let half_turn = std::f64::consts::FRAC_PI_2;
        v[2] = if inside { speed * (half_turn * x[0] / a).cos() * (half_turn * x[1] / b).cos() } else { 0.0 };
    }
    sim.set_motion(&positions, &velocities)?;
    Ok(())
}

fn same_bits(rows: &[Row]) -> bool {
    rows.windows(2)
        .all(|pair| (pair[0].case, pair[0].size) != (pair[1].case, pair[1].size) || pair[0].digest == pair[1].digest)
}

fn print(report: &Report, wall: f64) {
    println!("machine: {}", report.machine);
    let load = report.load_at_start.map_or("unknown".to_string(), |load| format!("{load:.2}"));
    println!("clock: {}, one thread; load of the machine at the start: {load}", report.clock);
    let mut table = report::table(&[
        "case",
        "nodes",
        "instructions",
        "ns/node-step least",
        "median",
        "bytes/node",
        "contacts",
        "failed",
        "digest",
    ]);
    for row in &report.rows {
        table.add_row(vec![
            row.case.to_string(),
            format!("{0} x {0}", row.size),
            row.instruction_set.to_string(),
            format!("{:.2}", row.ns_per_node_step),
            format!("{:.2}", row.ns_per_node_step_median),
            format!("{:.1}", row.bytes_per_node),
            row.contacts.to_string(),
            row.failed_segments.to_string(),
            row.digest.clone(),
        ]);
    }
    println!("{table}");
    let verdict = if same_bits(&report.rows) { "the same bits" } else { "DIFFERENT BITS" };
    println!("instruction sets give {verdict}; measured in {wall:.1} s");
}
