//! What parts cost: the ledger, rows at rest, memory; and the time to whole answers.

use super::Bench;
use super::rows::{Report, Row};
use super::sheets;
use crate::Result;
use crate::hits;
use crate::machine::Clock;
use crate::memory::Buffers;
use crate::report::{least, median, noise};
use fabric::{Layout, Scene};
use std::time::Instant;

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
            let row = Row::of(&case, size, fabric::InstructionSet::widest().name(), 1, times);
            report.rows.push(row.ending_in(digest));
        }
        if digests[0] != digests[1] {
            return Err(format!("rows at rest change the bits of the first {steps} steps at {size}").into());
        }
    }
    Ok(())
}

/// `contact_capacity` for tight memory under the 10 in preset: 1.6 times the nodes that wrap its cylinder (docs/embedding.md).
const TIGHT_CAPACITY: u32 = 7250;

/// Bytes per node of the 10 in preset, 350 x 350, everything counted; neither the body nor the supports matter.
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

/// The presets.
type Preset = fn() -> Scene;
const PRESETS: [(&str, Preset); 2] =
    [("3 in sheet, sphere", Scene::sheet_3in_sphere), ("10 in sheet, cylinder", Scene::sheet_10in_cylinder)];
/// How often an answer is waited for.
const ANSWERS: usize = 3;
/// Simulated time after which a run is given up, s.
const LONGEST: f64 = 2e-3;
/// Shots of a V50.
const SHOTS: u64 = 60;
/// Where an up-and-down test begins, m/s, and its stride.
const FIRST: f64 = 47.0;
const STRIDE: f64 = 1.05;

/// Wall time of the presets to their end, with everything from the memory on, and of an up-and-down test of 60 shots on the 3 in preset,
/// one after another on one core. The fit of the shots takes milliseconds and is left out.
pub fn answers(bench: &mut Bench) -> Result<()> {
    let report = &mut bench.report;
    for (name, scene) in PRESETS {
        let scene = scene();
        answer(report, &format!("{name}, to its end"), || hits::goes_through(&scene, LONGEST).map(|_| 0.0))?;
    }
    let (scene, name) = (Scene::sheet_3in_sphere(), format!("V50 of the 3 in sheet, {SHOTS} shots"));
    let mean = answer(report, &name, || {
        let (mut velocity, mut log_sum) = (FIRST, 0.0);
        for hit in 0..SHOTS {
            log_sum += velocity.ln();
            let through = hits::goes_through(&hits::shot(&scene, velocity, hit), LONGEST)?;
            velocity *= if through { 1.0 / STRIDE } else { STRIDE };
        }
        Ok((log_sum / SHOTS as f64).exp())
    })?;
    report.figure("answers", format!("{name}: mean velocity"), mean, "m/s");
    Ok(())
}

/// The median of wall times, and their noise. Returns the last answer.
fn answer(report: &mut Report, name: &str, work: impl Fn() -> Result<f64>) -> Result<f64> {
    let (mut seconds, mut last) = (Vec::new(), 0.0);
    for _ in 0..ANSWERS {
        let wall = Instant::now();
        last = work()?;
        seconds.push(wall.elapsed().as_secs_f64());
    }
    report.figure("answers", format!("{name}: wall time, median of {ANSWERS}"), median(&seconds), "s");
    report.figure("answers", format!("{name}: noise"), 100.0 * noise(&seconds), "%");
    Ok(last)
}
