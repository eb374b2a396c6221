//! Kevlar 49 yarn pulled at six gauge lengths, against the published Weibull scales.
//!
//! Method: a chain of segments as long as the gauge, each with a strength of its own, is held at a uniform stretch and stepped once;
//! bisection finds the stretch at which its weakest segment gives way. The Weibull scale of many chains follows from the mean of the
//! logarithms, ln scale - gamma/m, with the shape m of the input. Input: fabrics/kevlar_49_yarn.toml, the strength at 50 mm and the
//! shape, two numbers that are a line through the six scales; so this tests the size effect, not the strength.
//! Limit: the spacing, 17 yarns an inch, is a choice; the strength of a chain does not depend on it.

use super::{each, measured_rows, named};
use crate::Result;
use crate::memory::Buffers;
use crate::progress::Progress;
use crate::report;
use crate::table::{Cell, Table};
use fabric::textile::{denier, per_inch};
use fabric::{AttachmentKind, Scene};
use std::path::Path;

/// Euler's constant.
const GAMMA: f64 = 0.577_215_664_9;
/// Allowed error of a Weibull scale.
const TOLERANCE: f64 = 0.03;

/// A free sheet of two equal chains of this length, m, out of reach of the projectile.
fn chains(length: f64, seed: u64) -> Result<Scene> {
    let mut textile = named("kevlar_49_yarn")?;
    for threads in [&mut textile.warp, &mut textile.weft] {
        (threads.linear_density, threads.count, threads.crimp) = (denier(1420.0), per_inch(17.0), 0.0);
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

/// Nominal stress at which the first chain gives way, Pa.
fn strength(length: f64, seed: u64) -> Result<f64> {
    let scene = chains(length, seed)?;
    let mut buffers = Buffers::of(&scene)?;
    let segments = scene.sheet.nodes_x as usize - 1;
    let (mut low, mut high): (f64, f64) = (1.0, 1.1);
    for _ in 0..14 {
        let middle = 0.5 * (low + high);
        let mut sim = buffers.sim(&scene)?;
        let mut x = vec![0.0; 3 * sim.layout().nodes()];
        let mut damage = vec![1.0; sim.layout().segments()];
        sim.copy_positions(&mut x)?;
        x.chunks_mut(3).for_each(|node| node[0] *= middle);
        sim.set_motion(&x, &vec![0.0; x.len()])?;
        sim.step()?;
        sim.copy_damage(&mut damage)?;
        if damage[..segments].iter().any(|alpha| *alpha < 1.0) { high = middle } else { low = middle }
    }
    Ok(nominal(&scene, low))
}

/// Gauge lengths, m, and Weibull scales, Pa, as published.
fn measured() -> Result<Vec<(f64, f64)>> {
    let number = |row: &toml::Value, key: &str| Some(row.get(key)?.as_integer()? as f64);
    measured_rows("yarn", |row| Some((1e-3 * number(row, "gauge_length_mm")?, 1e6 * number(row, "scale_mpa")?)))
}

/// False if a scale is not within the tolerance.
pub fn run(quick: bool, out: &Path) -> Result<bool> {
    let (measured, count) = (measured()?, if quick { 30 } else { 400 });
    let shape = named("kevlar_49_yarn")?.weibull_shape;
    let jobs: Vec<(f64, u64)> = measured.iter().flat_map(|(length, _)| (0..count).map(move |k| (*length, k))).collect();
    let progress = Progress::new("strength", jobs.len() as u64);
    let strengths = each(&jobs, |(length, seed)| {
        let found = strength(*length, *seed)?;
        progress.add(1, || format!("{:.0} mm", 1e3 * length));
        Ok(found.ln())
    })?;
    progress.finish();
    let mut table = Table::new(&["gauge length mm", "chains", "scale MPa", "standard error MPa", "measured MPa"]);
    let mut sound = true;
    for ((length, published), logarithms) in measured.iter().zip(strengths.chunks(count as usize)) {
        let scale = (report::mean(logarithms) + GAMMA / shape).exp();
        let error = scale * report::deviation(logarithms) / (logarithms.len() as f64).sqrt();
        sound &= quick || (scale / published - 1.0).abs() < TOLERANCE;
        let numbers = [1e3 * length, logarithms.len() as f64, 1e-6 * scale, 1e-6 * error, 1e-6 * published];
        table.add(numbers.map(Cell::Number).to_vec());
    }
    table.write(&out.join("strength.csv"))?;
    println!("Kevlar 49 yarn at six lengths: {}", if sound { "as measured" } else { "NOT as measured" });
    Ok(sound)
}
