//! What parts cost: contact, the ledger, rows at rest, memory, whole presets.

use super::rows::{Report, Row};
use super::sheets::{self, Effort};
use crate::hits;
use crate::machine::{Clock, Wall};
use crate::memory::Buffers;
use crate::progress::Progress;
use crate::{Result, report as statistics};
use fabric::{Layout, Scene, Sim};

/// Contact: the same sheet in the same motion with the sphere and without, over the size of the sheet.
pub fn contact(size: u32, effort: Effort, progress: &Progress, report: &mut Report) -> Result<()> {
    let mut case = sheets::whole_run(size);
    // Slow enough to damage nothing, so that positions and velocities are all there is.
    case.scene.projectile.velocity[2] = 50.0;
    case.before = 600;
    let mut buffers = Buffers::of(&case.scene)?;
    let (mut with, image) = sheets::prepare(&case, &mut buffers)?;
    let mut positions = vec![0.0; 3 * with.layout().nodes()];
    let mut velocities = positions.clone();
    with.copy_positions(&mut positions)?;
    with.copy_velocities(&mut velocities)?;
    let mut scene = case.scene;
    scene.projectile.position[2] = -1.0;
    let mut others = Buffers::of(&scene)?;
    let mut without = others.sim(&scene)?;
    without.set_motion(&positions, &velocities)?;
    without.step_every_row();
    let bare = sheets::image_of(&without)?;

    let (steps, bursts) = sheets::steps_and_bursts(with.layout().nodes() as u64, effort);
    // The same short stretch of motion for every size.
    let (steps, bursts) = (steps.min(20), bursts * (steps / steps.min(20)));
    let mut times = [Vec::new(), Vec::new()];
    for _ in 0..effort.rounds {
        for _ in 0..bursts {
            for (k, (sim, image)) in [(&mut with, &image), (&mut without, &bare)].into_iter().enumerate() {
                sim.load(image)?;
                let clock = Clock::start();
                sim.advance(steps)?;
                times[k].push(1e6 * clock.seconds() / steps as f64);
            }
        }
        progress.add(1, || format!("contact {size}"));
    }
    let contacts = with.counters().contacts as f64;
    report.figure("contact", format!("contact, {size} x {size}: nodes touched"), contacts, "");
    match difference(&times[0], &times[1]) {
        Ok(cost) => {
            report.figure("contact", format!("contact, {size} x {size}: per step"), cost, "us");
            report.figure(
                "contact",
                format!("contact, {size} x {size}: per node touched"),
                1e3 * cost / contacts,
                "ns",
            );
        }
        Err(noise) => {
            report.figure(
                "contact",
                format!("contact, {size} x {size}: per step, not told from noise of"),
                noise,
                "us",
            );
        }
    }
    Ok(())
}

/// A small difference of large times: the least of many short bursts of each is what a busy machine disturbs least. What the quickest
/// quarter of either scatters by is noise, and the error if the difference is not larger.
fn difference(with: &[f64], without: &[f64]) -> std::result::Result<f64, f64> {
    let scatter = |times: &[f64]| {
        let mut sorted = times.to_vec();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 4] - sorted[0]
    };
    let (cost, noise) = (statistics::least(with) - statistics::least(without), scatter(with).max(scatter(without)));
    if cost > noise { Ok(cost) } else { Err(noise) }
}

/// The ledger: one call that sums up all energies, against one step.
pub fn ledger(size: u32, effort: Effort, progress: &Progress, report: &mut Report) -> Result<()> {
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
        progress.add(1, || format!("ledger {size}"));
    }
    let (call, step) = (statistics::least(&calls), statistics::least(&steps));
    report.figure("ledger", format!("all energies, {size} x {size}: one call"), 1e3 * call, "ms");
    report.figure("ledger", format!("all energies, {size} x {size}: one call in steps"), call / step, "steps");
    Ok(())
}

/// Rows at rest: a whole run from its first step with and without stepping them; the bits must agree.
pub fn rest(size: u32, effort: Effort, progress: &Progress, report: &mut Report) -> Result<()> {
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
            progress.add(1, || format!("rest {size}"));
        }
        for (k, word) in ["left out", "stepped"].into_iter().enumerate() {
            report.rows.push(Row {
                ns_per_node_step: Some(statistics::least(&times[k])),
                median: Some(statistics::median(&times[k])),
                digest: Some(format!("{:016x}", digests[k])),
                ..Row::empty(
                    &format!("first {name} steps, rows at rest {word}"),
                    size,
                    fabric::InstructionSet::widest().name(),
                    1,
                )
            });
        }
        if digests[0] != digests[1] {
            return Err(format!("rows at rest change the bits of the first {steps} steps at {size}").into());
        }
    }
    Ok(())
}

/// `contact_capacity` for tight memory under the 10 in preset: 1.6 times the nodes that wrap its cylinder (docs/embedding.md).
const TIGHT_CAPACITY: u32 = 7250;

/// Name of the figure of a sheet's memory.
fn memory_name(kind: &str, capacity: u32) -> String {
    let places = if capacity == 0 { "a place for every node".into() } else { format!("contact_capacity {capacity}") };
    format!("memory, 350 x 350, {kind}, {places}")
}

/// Bytes per node of the 10 in preset, 350 x 350, everything counted; neither the body nor the supports matter.
pub fn memory(report: &mut Report) -> Result<()> {
    let mut scene = Scene::sheet_10in_cylinder();
    for (kind, stochastic) in [("stochastic", true), ("uniform", false)] {
        for capacity in [0, TIGHT_CAPACITY] {
            (scene.yarn.stochastic, scene.contact_capacity) = (stochastic, capacity);
            let layout = Layout::of(&scene)?;
            let bytes = layout.bytes() as f64 / layout.nodes() as f64;
            report.figure("memory", memory_name(kind, capacity), bytes, "bytes per node");
        }
    }
    let layout = Layout::of(&Scene::sheet_10in_cylinder())?;
    let image = layout.snapshot_bytes() as f64 / layout.nodes() as f64;
    report.figure("memory", "image of the 10 in preset", image, "bytes per node");
    Ok(())
}

/// Seconds for a preset as it is, rows at rest left out.
pub fn preset(name: &str, scene: &Scene, seconds: f64, report: &mut Report) -> Result<()> {
    let mut buffers = Buffers::of(scene)?;
    let wall = Wall::start();
    let clock = Clock::start();
    let mut sim = buffers.sim(scene)?;
    let setup = clock.seconds();
    let steps = (seconds / sim.step_limits().dt).ceil() as u64;
    let clock = Clock::start();
    sim.advance(steps)?;
    let (stepping, wall) = (clock.seconds(), wall.seconds());
    let ms = 1e3 * seconds;
    report.figure("presets", format!("{name}, {ms} ms: drawing and setting up"), setup, "s");
    report.figure("presets", format!("{name}, {ms} ms: {steps} steps"), stepping, "s");
    report.figure("presets", format!("{name}, {ms} ms: wall time of both"), wall, "s");
    report.rows.push(row_of_preset(name, &sim, stepping, steps));
    Ok(())
}

/// Simulated time after which a run is given up, s.
const LONGEST: f64 = 2e-3;

/// Wall time of a preset to its end, with everything from the memory on, `rounds` times.
pub fn preset_to_end(name: &str, scene: &Scene, rounds: usize, report: &mut Report) -> Result<()> {
    let mut times = Vec::new();
    for _ in 0..rounds {
        let wall = Wall::start();
        hits::goes_through(scene, LONGEST)?;
        times.push(wall.seconds());
    }
    answered(&format!("{name}, to its end"), &times, report);
    Ok(())
}

/// Shots of a V50.
const SHOTS: u64 = 60;
/// Where an up-and-down test begins, m/s, and its stride.
const FIRST: f64 = 47.0;
const STRIDE: f64 = 1.05;

/// Wall time of an up-and-down test of 60 shots on the 3 in preset, one after another on one core, `rounds` times. The fit of the
/// shots takes milliseconds and is left out.
pub fn v50(rounds: usize, report: &mut Report) -> Result<()> {
    let (mut times, mut log_sum, scene) = (Vec::new(), 0.0, Scene::sheet_3in_sphere());
    for _ in 0..rounds {
        let wall = Wall::start();
        let mut velocity = FIRST;
        log_sum = 0.0;
        for hit in 0..SHOTS {
            log_sum += velocity.ln();
            let through = hits::goes_through(&hits::shot(&scene, velocity, hit), LONGEST)?;
            velocity *= if through { 1.0 / STRIDE } else { STRIDE };
        }
        times.push(wall.seconds());
    }
    answered(&format!("V50 of the 3 in sheet, {SHOTS} shots"), &times, report);
    let mean = (log_sum / SHOTS as f64).exp();
    report.figure("answers", format!("V50 of the 3 in sheet, {SHOTS} shots: mean velocity"), mean, "m/s");
    Ok(())
}

/// The median of wall times, and their noise.
fn answered(name: &str, seconds: &[f64], report: &mut Report) {
    let rounds = seconds.len();
    report.figure("answers", format!("{name}: wall time, median of {rounds}"), statistics::median(seconds), "s");
    report.figure("answers", format!("{name}: noise"), 100.0 * statistics::noise(seconds), "%");
}

fn row_of_preset(name: &str, sim: &Sim<'_>, seconds: f64, steps: u64) -> Row {
    let ns = 1e9 * seconds / (steps * sim.layout().nodes() as u64) as f64;
    let counters = sim.counters();
    Row {
        ns_per_node_step: Some(ns),
        median: Some(ns),
        digest: Some(format!("{:016x}", sim.digest())),
        contacts: Some(counters.contacts),
        failed_segments: Some(counters.failed_segments),
        ..Row::empty(&format!("preset {name}"), sim.scene().sheet.nodes_x, sim.instructions().name(), 1)
    }
}

#[cfg(test)]
mod tests {
    use super::difference;

    #[test]
    fn a_cost_below_the_noise_is_not_one() {
        assert_eq!(difference(&[80.0, 80.5, 81.0, 95.0], &[77.0, 77.5, 78.0, 79.0]), Ok(3.0));
        assert_eq!(difference(&[75.0, 85.0, 86.0, 95.0], &[79.7, 81.0, 83.0, 84.0]), Err(10.0)); // -4.7
        assert_eq!(difference(&[80.0; 4], &[80.0; 4]), Err(0.0));
    }
}
