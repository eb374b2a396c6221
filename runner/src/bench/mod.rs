//! The benchmark: ns per node-step over sizes, instruction sets and threads; what parts cost; peers. `python -m evidence bench`
//! compares it with the goals and writes the tables of docs/performance.md.
//!
//! One node-step is one node advanced by one step, with its two segments. Two cases come first. "sweep": a moving sheet
//! without a projectile, nothing tracked: the hot pass alone. "run": the preset sphere at 300 m/s on four held sides, taken up
//! after 1000 steps, when contact is wide and the first segments fail or are about to, with supports and detachment tracked.
//!
//! Method: everything that is compared starts from the same image and takes the same steps; rounds go through all of it in
//! turn, so that a change of the machine's load meets all alike. The least time is the machine's, the median says how quiet it
//! was; ratios are medians of the ratios of each round. Time is CPU time: of the thread for the kernel (wall time where it has
//! several), of the process for peers. All instruction sets must end in the same bits.

mod callgrind;
mod compare;
mod fmu;
mod parts;
mod peers;
mod ports;
mod programs;
mod rows;
mod sheets;
mod worst;

use crate::machine::{self, Wall};
use crate::progress::Progress;
use crate::report::{table, written};
use crate::{Result, say};
use clap::Args;
use fabric::{InstructionSet, Scene};
use rows::{Figure, Report};
use sheets::{Effort, THREADS, Way};
use std::path::PathBuf;

/// Options of `bench`.
#[derive(Args)]
pub struct Options {
    /// Few rounds, no sheet above 1000 x 1000, and none above 350 x 350 for the peers: two to three minutes on 2 quiet
    /// cores.
    #[arg(long)]
    quick: bool,
    /// Small sheets, very few rounds, and of the peers only plain C: does it work?
    #[arg(long)]
    smoke: bool,
    /// Folder for bench.json.
    #[arg(long, value_name = "DIR", default_value = "target/fabric/bench")]
    out: PathBuf,
    /// Only the groups whose name contains this ("sweep 350", "run", "fmu", ...; `--only list` prints them).
    #[arg(long, value_name = "NAME", default_value = "")]
    only: String,
    /// Only this instruction set: scalar, sse2, avx2 or avx512.
    #[arg(long, value_name = "SET", default_value = "")]
    instructions: String,
    /// Build this revision too (a git name) and measure both in turn: of one case, that of --only, or of the sweep and the whole run
    /// at 105 x 105 and 350 x 350.
    #[arg(long, value_name = "REV")]
    compare: Option<String>,
    /// How often both are measured.
    #[arg(long, value_name = "COUNT", default_value_t = 11, requires = "compare")]
    pairs: usize,
    /// Only step a case of the size that callgrind counts.
    #[arg(long, value_name = "STEPS", hide = true)]
    count_steps: Option<u64>,
}

/// A part of the benchmark.
enum Group {
    Ports,
    Sweep(u32),
    Run(u32),
    Dense(u32),
    Plies(u32),
    Peers(u32),
    Rest(u32),
    Contact(u32),
    Ledger(u32),
    Worst,
    Memory,
    Fmu,
    States,
    Instructions,
    Preset(&'static str, Preset),
    Answer(&'static str, Preset),
    V50,
}

impl Group {
    fn name(&self) -> String {
        match self {
            Group::Ports => "ports".to_string(),
            Group::Sweep(size) => format!("sweep {size}"),
            Group::Run(size) => format!("run {size}"),
            Group::Dense(size) => format!("dense {size}"),
            Group::Plies(size) => format!("plies {size}"),
            Group::Peers(size) => format!("peers {size}"),
            Group::Rest(size) => format!("rest {size}"),
            Group::Contact(size) => format!("contact {size}"),
            Group::Ledger(size) => format!("ledger {size}"),
            Group::Worst => "worst".to_string(),
            Group::Memory => "memory".to_string(),
            Group::Fmu => "fmu".to_string(),
            Group::States => "states".to_string(),
            Group::Instructions => "instructions".to_string(),
            Group::Preset(name, _) => format!("preset {name}"),
            Group::Answer(name, _) => format!("answer {name}"),
            Group::V50 => "answer V50".to_string(),
        }
    }

    /// Rounds, for the progress bar.
    fn pieces(&self, rounds: usize) -> usize {
        match self {
            Group::Ports | Group::Memory | Group::Preset(..) | Group::Answer(..) | Group::V50 => 1,
            Group::Worst => worst::SCENES as usize,
            Group::Instructions => 2 * InstructionSet::ALL.into_iter().filter(|set| set.available()).count(),
            Group::Fmu => 4 * rounds,
            Group::Rest(_) => 3 * rounds.min(3),
            _ => rounds,
        }
    }
}

/// All groups, in the order in which they run.
fn groups(options: &Options) -> Vec<Group> {
    let sizes: &[u32] = match (options.smoke, options.quick) {
        (true, _) => &[35, 105],
        (_, true) => &[35, 105, 350, 700, 1000],
        _ => &[35, 105, 350, 700, 1000, 2000],
    };
    let mut groups = vec![Group::Ports];
    groups.extend(sizes.iter().flat_map(|&size| [Group::Sweep(size), Group::Run(size)]));
    groups.extend([Group::Dense(105), Group::Plies(105)]);
    if options.smoke {
        groups.extend([Group::Peers(35), Group::Rest(35), Group::Contact(105), Group::Ledger(105), Group::Memory]);
        groups.push(Group::Fmu);
        return groups;
    }
    groups.extend([105, 350].map(Group::Peers));
    if !options.quick {
        // Their first steps alone take longer than the rest of the short form.
        groups.push(Group::Peers(1000));
    }
    groups.extend([105, 350].map(Group::Rest));
    groups.extend([105, 350, 700].map(Group::Contact));
    groups.extend([105, 350].map(Group::Ledger));
    groups.extend([Group::Worst, Group::Memory, Group::Fmu, Group::States, Group::Instructions]);
    let [(small, sphere), (large, cylinder)] = PRESETS;
    groups.extend([Group::Preset(small, sphere), Group::Preset(large, cylinder)]);
    if !options.quick {
        groups.extend([Group::Answer(small, sphere), Group::Answer(large, cylinder), Group::V50]);
    }
    groups
}

/// Makes a scene.
type Preset = fn() -> Scene;

/// The presets.
const PRESETS: [(&str, Preset); 2] =
    [("3 in sheet, sphere", Scene::sheet_3in_sphere), ("10 in sheet, cylinder", Scene::sheet_10in_cylinder)];

/// Simulated time of the presets, s.
const PRESET_SECONDS: f64 = 0.5e-3;

/// How often an answer is waited for.
const ANSWERS: usize = 3;

/// Measures, prints and writes. False if two ways to step disagree about the bits.
pub fn run(options: &Options) -> Result<bool> {
    if let Some(steps) = options.count_steps {
        callgrind::step(&options.only, &options.instructions, steps)?;
        return Ok(true);
    }
    if let Some(revision) = &options.compare {
        return compare::run(revision, &options.only, &options.instructions, options.pairs, &options.out);
    }
    let groups = groups(options);
    if options.only == "list" {
        groups.iter().for_each(|group| say::line(format_args!("{}", group.name())));
        return Ok(true);
    }
    let groups: Vec<Group> = groups.into_iter().filter(|group| group.name().contains(&options.only)).collect();
    if groups.is_empty() {
        return Err(format!("no group is called {:?}; see --only list", options.only).into());
    }
    // A set that this machine lacks has its row too: one that says so.
    let sets = InstructionSet::ALL
        .into_iter()
        .filter(|set| options.instructions.is_empty() || set.name() == options.instructions);
    // More than one thread for the widest set only.
    let threads = |set| THREADS.into_iter().filter(move |&threads| threads == 1 || set == InstructionSet::widest());
    let way = |instructions, threads| Way { instructions, threads, single_steps: false };
    let mut ways: Vec<Way> = sets.flat_map(|set| threads(set).map(move |threads| way(set, threads))).collect();
    let wide =
        |way: &&Way| way.threads == 1 && matches!(way.instructions, InstructionSet::Avx2 | InstructionSet::Avx512);
    let single: Vec<Way> = ways.iter().filter(wide).map(|way| Way { single_steps: true, ..*way }).collect();
    ways.extend(single);
    if !ways.iter().any(|way| way.instructions.available()) {
        return Err(format!("this machine has no instruction set {:?}", options.instructions).into());
    }
    let effort = match (options.smoke, options.quick) {
        (true, _) => Effort { rounds: 2, node_steps: 1_000_000 },
        (_, true) => Effort { rounds: 5, node_steps: 10_000_000 },
        _ => Effort { rounds: 11, node_steps: 20_000_000 },
    };

    let wall = Wall::start();
    let pieces: usize = groups.iter().map(|group| group.pieces(effort.rounds)).sum();
    let progress = Progress::new("bench", pieces as u64);
    let mut report = Report {
        machine: machine::processor(),
        widest: InstructionSet::widest().name(),
        clock: machine::CLOCK_NAME,
        load_at_start: machine::load(),
        load_at_end: None,
        seconds: 0.0,
        rounds: effort.rounds,
        rows: Vec::new(),
        figures: Vec::new(),
        missing: Vec::new(),
    };
    for group in &groups {
        measure(group, options, &ways, effort, &progress, &mut report)
            .map_err(|error| format!("{}: {error}", group.name()))?;
    }
    progress.finish();
    report.load_at_end = machine::load();
    report.seconds = wall.seconds();

    print(&report);
    let out = &options.out;
    std::fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))?;
    std::fs::write(out.join("bench.json"), serde_json::to_string_pretty(&report)? + "\n")?;
    say::line(format_args!("{}", written(out, "bench")));
    Ok(report.different_bits().is_empty())
}

fn measure(
    group: &Group,
    options: &Options,
    ways: &[Way],
    effort: Effort,
    progress: &Progress,
    report: &mut Report,
) -> Result<()> {
    match *group {
        Group::Ports => {
            ports::measure(report);
            progress.add(1, || "ports".to_string());
        }
        Group::Sweep(size) => report.rows.extend(sheets::measure(&sheets::sweep(size), ways, effort, progress)?),
        Group::Run(size) => report.rows.extend(sheets::measure(&sheets::whole_run(size), ways, effort, progress)?),
        Group::Dense(size) => {
            report.rows.extend(sheets::measure(&sheets::dense(size), ways, effort, progress)?);
        }
        Group::Plies(size) => {
            report.rows.extend(sheets::measure(&sheets::plies(size), ways, effort, progress)?);
        }
        Group::Peers(size) => peers::measure(size, options.smoke, effort, progress, report)?,
        Group::Rest(size) => parts::rest(size, effort, progress, report)?,
        Group::Contact(size) => parts::contact(size, effort, progress, report)?,
        Group::Ledger(size) => parts::ledger(size, effort, progress, report)?,
        Group::Worst => worst::measure(progress, report)?,
        Group::Memory => {
            parts::memory(report)?;
            progress.add(1, || "memory".to_string());
        }
        Group::Fmu => fmu::calls(effort, progress, report)?,
        Group::States => fmu::states(effort, progress, report)?,
        Group::Instructions => callgrind::measure(report, progress)?,
        Group::Preset(name, scene) => {
            progress.add(1, || format!("preset {name}"));
            parts::preset(name, &scene(), PRESET_SECONDS, report)?;
        }
        Group::Answer(name, scene) => {
            progress.add(1, || format!("answer {name}"));
            parts::preset_to_end(name, &scene(), ANSWERS, report)?;
        }
        Group::V50 => {
            progress.add(1, || "answer V50".to_string());
            parts::v50(ANSWERS, report)?;
        }
    }
    Ok(())
}

fn print(report: &Report) {
    let load = |load: Option<f64>| load.map_or("unknown".to_string(), |load| format!("{load:.2}"));
    say::line(format_args!("machine: {}", report.machine));
    say::line(format_args!(
        "clock: {} (peers: process CPU time); load at the start {}, at the end {}",
        report.clock,
        load(report.load_at_start),
        load(report.load_at_end)
    ));
    let heading =
        ["case", "nodes", "instructions", "threads", "ns/node-step", "median", "noise", "x the kernel's", "digest"];
    let mut rows = Vec::new();
    for row in &report.rows {
        let number = |value: Option<f64>| value.map_or("-".to_string(), |value| format!("{value:.2}"));
        rows.push(vec![
            row.case.clone(),
            format!("{0} x {0}", row.size),
            row.instruction_set.clone(),
            row.threads.to_string(),
            row.ns_per_node_step.map_or("not on this machine".to_string(), |ns| format!("{ns:.2}")),
            number(row.median),
            row.noise.map_or("-".to_string(), |noise| format!("{:.1} %", 100.0 * noise)),
            number(row.times_slower),
            row.digest.clone().unwrap_or("-".to_string()),
        ]);
    }
    if !rows.is_empty() {
        say::line(format_args!("{}", table(&heading, &rows)));
    }
    if !report.figures.is_empty() {
        let row = |figure: &Figure| vec![figure.name.clone(), figures(figure.value), figure.unit.to_string()];
        say::line(format_args!(
            "{}",
            table(&["figure", "value", "unit"], &report.figures.iter().map(row).collect::<Vec<_>>())
        ));
    }
    report.missing.iter().for_each(|missing| say::line(format_args!("not measured: {missing}")));
    match report.different_bits() {
        none if none.is_empty() => say::line(format_args!("every way to step gave the same bits")),
        some => some.iter().for_each(|row| say::line(format_args!("DIFFERENT BITS: {row}"))),
    }
    say::line(format_args!("measured in {:.0} s", report.seconds));
}

/// Three significant figures, and all digits before the point.
fn figures(value: f64) -> String {
    let digits = 2 - value.abs().max(1e-9).log10().floor() as i32;
    format!("{value:.*}", digits.clamp(0, 4) as usize)
}
