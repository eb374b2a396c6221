//! Kevlar 49 pulled slowly, yarn at six gauge lengths and strips of fabric, against the published Weibull scales.
//!
//! Method: rows of segments as long as the gauge, each segment with a strength of its own, are held at a uniform stretch and stepped
//! once. A yarn is one row: bisection finds the stretch at which its weakest segment gives way. A strip is as many rows as it has yarns;
//! it carries the law's stress times the part of its rows that are whole, and its strength is the largest such stress as the stretch
//! grows. Shape and scale of many samples follow from deviation and mean of the logarithms: m = pi/(sqrt(6) deviation), ln scale = mean +
//! gamma/m. Input: fabrics/kevlar_49_yarn.toml, the strength at 50 mm and the shape, two numbers that are a line through the six
//! scales of yarn; so the yarns test the size effect, and the strips what the network makes of yarns.
//! Limit: 17 yarns an inch is a choice, as no count could be cited; a chain does not depend on it, a strip hardly.

use super::{measured_rows, named};
use crate::hits::each;
use crate::memory::Buffers;
use crate::progress::Progress;
use crate::report;
use crate::table::{Cell, Table};
use crate::{Result, say};
use fabric::textile::{denier, per_inch};
use fabric::{AttachmentKind, Scene, Sim};
use std::path::Path;

/// Yarns an inch.
const COUNT: f64 = 17.0;
/// Euler's constant.
const GAMMA: f64 = 0.577_215_664_9;
/// Allowed error of a Weibull scale.
const TOLERANCE: f64 = 0.03;

/// A free sheet of this length and of so many rows, out of reach of the projectile.
fn rows(length: f64, count: u32, seed: u64) -> Result<Scene> {
    let mut textile = named("kevlar_49_yarn")?;
    for threads in [&mut textile.warp, &mut textile.weft] {
        (threads.linear_density, threads.count, threads.crimp) = (denier(1420.0), per_inch(COUNT), 0.0);
    }
    let mut scene = Scene::sheet_3in_sphere();
    scene.set_textile(&textile)?;
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = ((length / scene.sheet.spacing).round() as u32 + 1, count);
    (scene.attachment.kind, scene.seed) = (AttachmentKind::Free, seed);
    scene.projectile.position[2] = -1.0;
    scene.projectile.velocity = [0.0; 3];
    Ok(scene)
}

/// Nominal stress at a stretch, Pa.
fn nominal(scene: &Scene, stretch: f64) -> f64 {
    0.5 * scene.yarn.modulus_mean * stretch * (stretch * stretch - 1.0)
}

/// Rows whose segments all bear this stretch.
fn whole_rows(sim: &mut Sim<'_>, rest: &[f64], stretch: f64) -> Result<Vec<bool>> {
    let (segments, rows) = (sim.scene().sheet.nodes_x as usize - 1, sim.scene().sheet.nodes_y as usize);
    let (mut x, mut damage) = (rest.to_vec(), vec![1.0; sim.layout().segments()]);
    x.chunks_mut(3).for_each(|node| node[0] *= stretch);
    sim.reset();
    sim.set_motion(&x, &vec![0.0; x.len()])?;
    sim.step()?;
    sim.copy_damage(&mut damage)?;
    Ok(damage.chunks(segments).take(rows).map(|row| row.iter().all(|alpha| *alpha == 1.0)).collect())
}

/// Positions of the nodes at rest.
fn rest(sim: &Sim<'_>) -> Result<Vec<f64>> {
    let mut x = vec![0.0; 3 * sim.layout().nodes()];
    sim.copy_positions(&mut x)?;
    Ok(x)
}

/// Nominal stress at which a yarn gives way, Pa.
fn of_yarn(length: f64, seed: u64) -> Result<f64> {
    // The least number of rows; the first one is the yarn.
    let scene = rows(length, 2, seed)?;
    let mut buffers = Buffers::of(&scene)?;
    let mut sim = buffers.sim(&scene)?;
    let rest = rest(&sim)?;
    let (mut low, mut high): (f64, f64) = (1.0, 1.1);
    for _ in 0..14 {
        let middle = 0.5 * (low + high);
        if whole_rows(&mut sim, &rest, middle)?[0] { low = middle } else { high = middle }
    }
    Ok(nominal(&scene, low))
}

/// Largest nominal stress of a strip, Pa.
fn of_strip(strip: &Strip, seed: u64) -> Result<f64> {
    let scene = rows(strip.length, (strip.width * per_inch(COUNT)).round() as u32, seed)?;
    let mut buffers = Buffers::of(&scene)?;
    let mut sim = buffers.sim(&scene)?;
    let rest = rest(&sim)?;
    let (mut stretch, mut most): (f64, f64) = (1.005, 0.0);
    loop {
        let whole = whole_rows(&mut sim, &rest, stretch)?;
        let left = whole.iter().filter(|whole| **whole).count();
        if left == 0 {
            return Ok(most);
        }
        most = most.max(nominal(&scene, stretch) * left as f64 / whole.len() as f64);
        stretch += 2e-4;
    }
}

/// Shape, scale and the standard error of the scale of Weibull samples with these logarithms.
fn weibull(logarithms: &[f64]) -> [f64; 3] {
    let deviation = report::deviation(logarithms);
    let shape = std::f64::consts::PI / (6.0_f64.sqrt() * deviation);
    let scale = (report::mean(logarithms) + GAMMA / shape).exp();
    // Of the location of a Gumbel distribution by moments: 1.108/m over the root of the number.
    [shape, scale, scale * 1.108 / shape / (logarithms.len() as f64).sqrt()]
}

/// A sample as published: gauge length, m, Weibull scale, Pa, and shape.
struct Yarn {
    length: f64,
    scale: f64,
    shape: f64,
}

/// A strip as published: width and length, m, direction, Weibull scale, Pa, and shape.
struct Strip {
    width: f64,
    length: f64,
    direction: String,
    scale: f64,
    shape: f64,
}

fn number(row: &toml::Value, key: &str) -> Option<f64> {
    let value = row.get(key)?;
    value.as_float().or(value.as_integer().map(|whole| whole as f64))
}

fn yarns() -> Result<Vec<Yarn>> {
    measured_rows("yarn", |row| {
        let length = 1e-3 * number(row, "gauge_length_mm")?;
        Some(Yarn { length, scale: 1e6 * number(row, "scale_mpa")?, shape: number(row, "shape")? })
    })
}

fn strips() -> Result<Vec<Strip>> {
    measured_rows("fabric", |row| {
        let size = row.get("size_mm")?.as_array()?;
        let [width, length] = [size.first()?, size.get(1)?].map(|side| side.as_integer().unwrap_or(0) as f64 * 1e-3);
        let direction = row.get("direction")?.as_str()?.to_string();
        Some(Strip { width, length, direction, scale: 1e6 * number(row, "scale_mpa")?, shape: number(row, "shape")? })
    })
}

/// False if a scale of yarn is not within the tolerance.
pub fn run(quick: bool, out: &Path) -> Result<bool> {
    let (yarns, strips) = (yarns()?, strips()?);
    let (chains, samples) = if quick { (30, 4) } else { (500, 60) };
    let jobs: Vec<(&Yarn, u64)> = yarns.iter().flat_map(|yarn| (0..chains).map(move |k| (yarn, k))).collect();
    // Warp and fill are alike to the model.
    let sizes: Vec<&Strip> = strips.iter().step_by(2).collect();
    let pulls: Vec<(&Strip, u64)> = sizes.iter().flat_map(|&strip| (0..samples).map(move |k| (strip, k))).collect();
    let progress = Progress::new("strength", (jobs.len() + pulls.len()) as u64);
    let found = each(&jobs, |(yarn, seed)| {
        let found = of_yarn(yarn.length, *seed)?;
        progress.add(1, || format!("yarn of {:.0} mm", 1e3 * yarn.length));
        Ok(found.ln())
    })?;
    let pulled = each(&pulls, |(strip, seed)| {
        let found = of_strip(strip, *seed)?;
        progress.add(1, || format!("strip of {:.0} mm", 1e3 * strip.width));
        Ok(found.ln())
    })?;
    progress.finish();
    let heading = ["sample", "samples", "scale MPa", "standard error MPa", "shape", "measured MPa", "measured shape"];
    let mut table = Table::new(&heading);
    let mut sound = true;
    for (yarn, logarithms) in yarns.iter().zip(found.chunks(chains as usize)) {
        let [shape, scale, error] = weibull(logarithms);
        sound &= quick || (scale / yarn.scale - 1.0).abs() < TOLERANCE;
        let mut row = vec![Cell::text(format!("{:.0} mm", 1e3 * yarn.length))];
        let numbers = [chains as f64, 1e-6 * scale, 1e-6 * error, shape, 1e-6 * yarn.scale, yarn.shape];
        row.extend(numbers.map(Cell::Number));
        table.add(row);
    }
    table.write(&out.join("strength.csv"))?;
    let mut table = Table::new(&heading);
    for strip in &strips {
        let size = sizes.iter().position(|size| size.width == strip.width).ok_or("strips of unlike widths")?;
        let [shape, scale, error] = weibull(&pulled[size * samples as usize..(size + 1) * samples as usize]);
        let name = format!("{:.0} mm x {:.0} mm, {}", 1e3 * strip.width, 1e3 * strip.length, strip.direction);
        let mut row = vec![Cell::text(name)];
        let numbers = [samples as f64, 1e-6 * scale, 1e-6 * error, shape, 1e-6 * strip.scale, strip.shape];
        row.extend(numbers.map(Cell::Number));
        table.add(row);
    }
    table.write(&out.join("strip.csv"))?;
    say::line(format_args!("Kevlar 49 yarn at six lengths: {}", if sound { "as measured" } else { "NOT as measured" }));
    Ok(sound)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quantiles of a Weibull distribution of shape 10 and scale 2 in equal parts of the probability.
    #[test]
    fn shape_and_scale_of_a_known_sample() {
        let quantile = |k: u32| -(1.0 - (f64::from(k) + 0.5) / 1e5).ln();
        let logarithms: Vec<f64> = (0..100_000).map(|k| (2.0 * quantile(k).powf(0.1)).ln()).collect();
        let [shape, scale, _] = weibull(&logarithms);
        assert!((shape / 10.0 - 1.0).abs() < 1e-3 && (scale / 2.0 - 1.0).abs() < 1e-4, "{shape} {scale}");
    }
}
