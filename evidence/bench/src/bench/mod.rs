//! The benchmark: ns per node-step over sizes, instruction sets and threads; what parts cost; peers.
//! `python -m evidence bench` compares it with the goals and writes the tables of docs/performance.md.
//!
//! One node-step is one node advanced by one step, with its two segments. Two cases come first. "sweep": a
//! moving sheet without a projectile, nothing tracked: the hot pass alone. "run": the preset sphere at 300
//! m/s on four held sides, taken up after 1000 steps, when contact is wide and the first segments fail or are
//! about to, with supports and detachment tracked.
//!
//! Method: everything that is compared starts from the same image and takes the same steps; rounds go through
//! all of it in turn, so that a change of the machine's load meets all alike. The least time is the
//! machine's, the median says how quiet it was; ratios are medians of the ratios of each round. Time is CPU
//! time: of the thread for the kernel (wall time where it has several), of the process for peers. All
//! instruction sets must end in the same bits.

mod callgrind;
mod fmu;
mod parts;
mod peers;
mod ports;
mod programs;
mod rows;
mod sheets;
mod worst;

use crate::machine;
use crate::progress::Progress;
use crate::report::written;
use crate::{Result, say};
use clap::Args;
use fabric_kernel::InstructionSet;
use rows::Report;
use sheets::{Effort, THREADS, Way};
use std::path::PathBuf;
use std::time::Instant;

/// Options of `bench`.
#[derive(Args)]
pub struct Options {
    /// Few rounds, no sheet above 1000 x 1000, and none above 350 x 350 for the peers: two to three minutes
    /// on 2 quiet cores.
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
    /// Only step a case of the size that callgrind counts.
    #[arg(long, value_name = "STEPS", hide = true)]
    count_steps: Option<u64>,
}

/// What every group is measured with, and what has been measured.
pub struct Bench {
    ways: Vec<Way>,
    effort: Effort,
    /// Only peers that need nothing but a C compiler.
    few_peers: bool,
    report: Report,
}

/// Measures a group; of those with sizes, nodes along each side.
type Measure = fn(&mut Bench, u32) -> Result<()>;

const LARGE: &[u32] = &[35, 105, 350, 700, 1000, 2000];
const SMALL: &[u32] = &[35, 105];
/// In place of sizes: measured, or not.
const ONCE: &[u32] = &[0];
const NOT: &[u32] = &[];

/// Every group: its sizes in full, with --quick and with --smoke. The first steps of the largest peers alone
/// take longer than the rest of the short form.
const GROUPS: [(&str, [&[u32]; 3], Measure); 15] = [
    ("ports", [ONCE, ONCE, ONCE], |bench, _| ports::measure(bench)),
    ("sweep", [LARGE, LARGE.split_at(5).0, SMALL], |bench, size| sheets::measure(bench, &sheets::sweep(size))),
    ("KM2 sweep", [LARGE, LARGE.split_at(5).0, SMALL], |bench, size| {
        sheets::measure(bench, &sheets::of_kevlar(sheets::sweep(size), "KM2 sweep")?)
    }),
    ("run", [LARGE, LARGE.split_at(5).0, SMALL], |bench, size| sheets::measure(bench, &sheets::whole_run(size))),
    ("KM2 run", [LARGE, LARGE.split_at(5).0, SMALL], |bench, size| {
        sheets::measure(bench, &sheets::of_kevlar(sheets::whole_run(size), "KM2 run")?)
    }),
    ("dense", [&[105]; 3], |bench, size| sheets::measure(bench, &sheets::dense(size))),
    ("plies", [&[105]; 3], |bench, size| sheets::measure(bench, &sheets::plies(size))),
    ("peers", [&[105, 350, 1000], &[105, 350], &[35]], peers::measure),
    ("rest", [&[105, 350], &[105, 350], &[35]], parts::rest),
    ("ledger", [&[105, 350], &[105, 350], &[105]], parts::ledger),
    ("worst", [ONCE, ONCE, NOT], |bench, _| worst::measure(bench)),
    ("memory", [ONCE, ONCE, ONCE], |bench, _| parts::memory(bench)),
    ("fmu", [ONCE, ONCE, ONCE], |bench, _| fmu::calls(bench)),
    ("states", [ONCE, ONCE, NOT], |bench, _| fmu::states(bench)),
    ("instructions", [ONCE, ONCE, NOT], |bench, _| callgrind::measure(bench)),
];

/// Measures, prints and writes. False if two ways to step disagree about the bits.
pub fn run(options: &Options) -> Result<bool> {
    if let Some(steps) = options.count_steps {
        callgrind::step(&options.only, &options.instructions, steps)?;
        return Ok(true);
    }
    let (form, effort) = match (options.smoke, options.quick) {
        (true, _) => (2, Effort { rounds: 2, node_steps: 1_000_000 }),
        (_, true) => (1, Effort { rounds: 5, node_steps: 10_000_000 }),
        _ => (0, Effort { rounds: 11, node_steps: 20_000_000 }),
    };
    let groups =
        GROUPS.iter().flat_map(|(name, sizes, measure)| sizes[form].iter().map(move |size| (*name, *size, measure)));
    let named = |(name, size, _): &(&str, u32, _)| if *size == 0 { name.to_string() } else { format!("{name} {size}") };
    if options.only == "list" {
        groups.for_each(|group| say::line(format_args!("{}", named(&group))));
        return Ok(true);
    }
    let groups: Vec<_> = groups.filter(|group| named(group).contains(&options.only)).collect();
    if groups.is_empty() {
        return Err(format!("no group is called {:?}; see --only list", options.only).into());
    }

    let wall = Instant::now();
    let progress = Progress::new("bench", groups.len() as u64);
    let mut bench = Bench {
        ways: ways(&options.instructions)?,
        effort,
        few_peers: options.smoke,
        report: Report::new(effort.rounds),
    };
    for group in &groups {
        let (_, size, measure) = group;
        progress.add(0, || named(group));
        measure(&mut bench, *size).map_err(|error| format!("{}: {error}", named(group)))?;
        progress.add(1, || named(group));
    }
    progress.finish();
    let mut report = bench.report;
    report.load_at_end = machine::load();
    report.seconds = wall.elapsed().as_secs_f64();
    report.print();
    let out = &options.out;
    std::fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))?;
    std::fs::write(out.join("bench.json"), serde_json::to_string_pretty(&report)? + "\n")?;
    say::line(format_args!("{}", written(out)));
    Ok(report.different_bits().is_empty())
}

/// How each case is stepped; `only`: one instruction set, or all if it is empty.
fn ways(only: &str) -> Result<Vec<Way>> {
    // A set that this machine lacks has its row too: one that says so.
    let sets = InstructionSet::ALL.into_iter().filter(|set| only.is_empty() || set.name() == only);
    // More than one thread for the widest set only.
    let threads = |set| THREADS.into_iter().filter(move |&threads| threads == 1 || set == InstructionSet::widest());
    let way = |instructions, threads| Way { instructions, threads, single_steps: false };
    let mut ways: Vec<Way> = sets.flat_map(|set| threads(set).map(move |threads| way(set, threads))).collect();
    let wide =
        |way: &&Way| way.threads == 1 && matches!(way.instructions, InstructionSet::Avx2 | InstructionSet::Avx512);
    let single: Vec<Way> = ways.iter().filter(wide).map(|way| Way { single_steps: true, ..*way }).collect();
    ways.extend(single);
    if !ways.iter().any(|way| way.instructions.available()) {
        return Err(format!("this machine has no instruction set {only:?}").into());
    }
    Ok(ways)
}
