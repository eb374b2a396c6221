//! What parts cost: the ledger, rows at rest, memory.

use super::Bench;
use super::rows::Row;
use super::sheets;
use crate::Result;
use crate::machine::Clock;
use crate::memory::Buffers;
use crate::report::least;
use fabric_kernel::{Layout, Scene};

/// The ledger: one call that sums up all energies, against one step.
pub fn ledger(bench: &mut Bench, size: u32) -> Result<()> {
    let Bench { effort, report, .. } = bench;
    let case = sheets::whole_run(size);
    let mut buffers = Buffers::of(&case.scene)?;
    let (mut sim, image) = sheets::prepare(&case, &mut buffers)?;
    let (mut calls, mut steps) = (Vec::new(), Vec::new());
    for _ in 0..effort.rounds {
        sim.load(&image)?;
        let clock = Clock::start();
        sim.advance(10)?;
        steps.push(clock.seconds() / 10.0);
        let clock = Clock::start();
        std::hint::black_box(sim.energy()?);
        calls.push(clock.seconds());
    }
    let (call, step) = (least(&calls), least(&steps));
    report.figure("ledger", format!("all energies, {size} x {size}: one call"), 1e3 * call, "ms");
    report.figure("ledger", format!("all energies, {size} x {size}: one call in steps"), call / step, "steps");
    Ok(())
}

/// Rows at rest: a whole run from its first step with and without stepping them; the bits must agree.
pub fn rest(bench: &mut Bench, size: u32) -> Result<()> {
    let Bench { effort, report, .. } = bench;
    let case = sheets::whole_run(size);
    let nodes = f64::from(size) * f64::from(size);
    for (name, steps) in [("n/4", u64::from(size) / 4), ("n", u64::from(size)), ("4 n", 4 * u64::from(size))] {
        let mut digests = [0; 2];
        let mut times = [Vec::new(), Vec::new()];
        for _ in 0..effort.rounds.min(3) {
            for k in 0..2 {
                // A simulation of its own: that every row is stepped cannot be taken back.
                let mut buffers = Buffers::of(&case.scene)?;
                let mut sim = buffers.sim(&case.scene)?;
                if k == 1 {
                    sim.step_every_row();
                }
                let clock = Clock::start();
                sim.advance(steps)?;
                times[k].push(1e9 * clock.seconds() / (steps as f64 * nodes));
                digests[k] = sim.digest();
            }
        }
        for ((word, times), digest) in ["left out", "stepped"].into_iter().zip(&times).zip(digests) {
            let case = format!("first {name} steps, rows at rest {word}");
            let row = Row::of(&case, size, fabric_kernel::InstructionSet::widest().name(), 1, times);
            report.rows.push(row.ending_in(digest));
        }
        if digests[0] != digests[1] {
            return Err(format!("rows at rest change the bits of the first {steps} steps at {size}").into());
        }
    }
    Ok(())
}

/// `contact_capacity` for tight memory under the 10 in preset: 1.6 times the nodes that wrap its cylinder
/// (docs/embedding.md).
const TIGHT_CAPACITY: u32 = 7250;

/// Bytes per node of the 10 in preset, 350 x 350, everything counted; neither the body nor the supports
/// matter.
pub fn memory(bench: &mut Bench) -> Result<()> {
    let report = &mut bench.report;
    let mut scene = Scene::sheet_10in_cylinder();
    for (kind, stochastic) in [("stochastic", true), ("uniform", false)] {
        for capacity in [0, TIGHT_CAPACITY] {
            (scene.yarn.stochastic, scene.contact_capacity) = (stochastic, capacity);
            let layout = Layout::of(&scene)?;
            let bytes = layout.bytes() as f64 / layout.nodes() as f64;
            let places = match capacity {
                0 => "a place for every node".into(),
                _ => format!("contact_capacity {capacity}"),
            };
            report.figure("memory", format!("memory, 350 x 350, {kind}, {places}"), bytes, "bytes per node");
        }
    }
    let layout = Layout::of(&Scene::sheet_10in_cylinder())?;
    let image = layout.snapshot_bytes() as f64 / layout.nodes() as f64;
    report.figure("memory", "image of the 10 in preset", image, "bytes per node");
    Ok(())
}
