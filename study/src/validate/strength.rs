//! Kevlar 49 yarn pulled slowly at six gauge lengths, against the published Weibull scales. Strips of fabric: reports/strips.py.
//!
//! Method: a row of segments as long as the gauge, each segment with a strength of its own, is held at a uniform stretch and stepped
//! once; bisection finds the stretch at which its weakest segment gives way. Shape and scale of many samples follow from deviation and
//! mean of the logarithms: m = pi/(sqrt(6) deviation), ln scale = mean + gamma/m. Input: fabrics/kevlar_49_yarn.toml, the strength at
//! 50 mm and the shape, two numbers that are a line through the six scales of yarn; so this tests the size effect.
//! Limit: 17 yarns an inch is a choice, as no count could be cited; a chain does not depend on it.

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

/// A free sheet of this length and of two rows, the least number, out of reach of the projectile.
fn rows(length: f64, seed: u64) -> Result<Scene> {
    let mut textile = named("kevlar_49_yarn")?;
    for threads in [&mut textile.warp, &mut textile.weft] {
        (threads.linear_density, threads.count, threads.crimp) = (denier(1420.0), per_inch(COUNT), 0.0);
    }
    let mut scene = Scene::sheet_3in_sphere();
    scene.set_textile(&textile)?;
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = ((length / scene.sheet.spacing).round() as u32 + 1, 2);
    (scene.attachment.kind, scene.seed) = (AttachmentKind::Free, seed);
    scene.projectile.position[2] = -1.0;
    scene.projectile.velocity = [0.0; 3];
    Ok(scene)
}

/// Nominal stress at a stretch, Pa.
fn nominal(scene: &Scene, stretch: f64) -> f64 {
    0.5 * scene.yarn.modulus_mean * stretch * (stretch * stretch - 1.0)
}

/// Whether all segments of the first row, which is the yarn, bear this stretch.
fn is_whole(sim: &mut Sim<'_>, rest: &[f64], stretch: f64) -> Result<bool> {
    let (segments, mut x) = (sim.scene().sheet.nodes_x as usize - 1, rest.to_vec());
    let mut damage = vec![1.0; sim.layout().segments()];
    x.chunks_mut(3).for_each(|node| node[0] *= stretch);
    sim.reset();
    sim.set_motion(&x, &vec![0.0; x.len()])?;
    sim.step()?;
    sim.copy_damage(&mut damage)?;
    Ok(damage.iter().take(segments).all(|alpha| *alpha == 1.0))
}

/// Nominal stress at which a yarn gives way, Pa.
fn of_yarn(length: f64, seed: u64) -> Result<f64> {
    let scene = rows(length, seed)?;
    let mut buffers = Buffers::of(&scene)?;
    let mut sim = buffers.sim(&scene)?;
    let mut rest = vec![0.0; 3 * sim.layout().nodes()];
    sim.copy_positions(&mut rest)?;
    let (mut low, mut high): (f64, f64) = (1.0, 1.1);
    for _ in 0..14 {
        let middle = 0.5 * (low + high);
        if is_whole(&mut sim, &rest, middle)? { low = middle } else { high = middle }
    }
    Ok(nominal(&scene, low))
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

/// False if a scale of yarn is not within the tolerance.
pub fn run(quick: bool, out: &Path) -> Result<bool> {
    let yarns = yarns()?;
    let chains = if quick { 30 } else { 500 };
    let jobs: Vec<(&Yarn, u64)> = yarns.iter().flat_map(|yarn| (0..chains).map(move |k| (yarn, k))).collect();
    let progress = Progress::new("strength", jobs.len() as u64);
    let found = each(&jobs, |(yarn, seed)| {
        let found = of_yarn(yarn.length, *seed)?;
        progress.add(1, || format!("yarn of {:.0} mm", 1e3 * yarn.length));
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
