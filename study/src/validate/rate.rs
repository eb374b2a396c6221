//! Kevlar 49 fabric pulled at three rates of strain, against the published moduli and strengths.
//!
//! Method: two nodes 25 mm apart, so heavy that they part at a constant rate; the pull of the segment between them follows from what it
//! takes of their speed. Modulus: secant at 0.5 % of strain. Strength: the largest nominal stress. Input: modulus and strength at the
//! lowest and at the highest rate of validation/kevlar49_strength.toml, which give the growth by e-fold; so only the rate between
//! them is a test, and the outer two check the law.
//! Limit: crimp is left out, as the published modulus is that of the stretched fabric.

use super::measured_rows;
use crate::hits::each;
use crate::memory::Buffers;
use crate::table::{Cell, Table};
use crate::{Result, say};
use fabric::{AttachmentKind, Scene, TimeStep};
use std::path::Path;

/// Allowed error of moduli and strengths.
const TOLERANCE: f64 = 0.1;
/// Gauge length, m, and mass of a node, kg.
const CELL: (f64, f64) = (0.025, 1e4);
/// Strain at which the modulus is read.
const SECANT: f64 = 0.005;
/// Strain at the end, and steps until then.
const PULL: (f64, u64) = (0.025, 5000);

/// A rate of strain, 1/s, with modulus and strength, Pa, each a mean and its standard deviation.
struct Measured {
    rate: f64,
    modulus: [f64; 2],
    strength: [f64; 2],
}

fn measured() -> Result<Vec<Measured>> {
    let pair = |row: &toml::Value, key: &str, unit: f64| -> Option<[f64; 2]> {
        let values = row.get(key)?.as_array()?;
        Some([unit * values.first()?.as_integer()? as f64, unit * values.get(1)?.as_integer()? as f64])
    };
    let read = |row: &toml::Value| {
        let rate = row.get("per_second")?.as_integer()? as f64;
        Some(Measured { rate, modulus: pair(row, "modulus_gpa", 1e9)?, strength: pair(row, "strength_mpa", 1e6)? })
    };
    measured_rows("rate", read)
}

/// U^2 - 1 at which the nominal stress E U (U^2 - 1)/2 has this value, by bisection.
fn twice_strain_at(stress: f64, modulus: f64) -> f64 {
    let (mut low, mut high) = (0.0, 0.2);
    for _ in 0..60 {
        let q: f64 = 0.5 * (low + high);
        if 0.5 * modulus * (1.0 + q).sqrt() * q < stress { low = q } else { high = q }
    }
    0.5 * (low + high)
}

/// Four nodes, free, of yarn that has the lowest and the highest of the measured rates.
fn cell(slow: &Measured, fast: &Measured) -> Scene {
    let mut scene = Scene::sheet_3in_sphere();
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (2, 2);
    (scene.sheet.spacing, scene.sheet.node_mass) = CELL;
    scene.attachment.kind = AttachmentKind::Free;
    let body = &mut scene.projectile;
    (body.radius, body.mass) = (2.0 * CELL.0, 2.0 * CELL.1);
    (body.position, body.velocity) = ([0.0, 0.0, -1.0], [0.0; 3]);
    let [q, q_fast] = [slow, fast].map(|at| twice_strain_at(at.strength[0], at.modulus[0]));
    let folds = (fast.rate / slow.rate).ln();
    let yarn = &mut scene.yarn;
    yarn.stochastic = false;
    (yarn.modulus_mean, yarn.critical_stretch) = (slow.modulus[0], (1.0 + q).sqrt());
    (yarn.damage_slope, yarn.damage_intercept) = (0.0, 2302.6);
    (yarn.rate_reference, yarn.rate_limit) = (slow.rate, fast.rate);
    yarn.rate_modulus = (fast.modulus[0] / slow.modulus[0] - 1.0) / folds;
    yarn.rate_stretch = (q_fast / q - 1.0) / folds;
    scene
}

/// Modulus and strength, Pa, at this rate of strain, 1/s.
fn pulled(scene: &Scene, rate: f64) -> Result<[f64; 2]> {
    let scene = Scene { time_step: TimeStep::seconds(PULL.0 / rate / PULL.1 as f64), ..*scene };
    let mut buffers = Buffers::of(&scene)?;
    let mut sim = buffers.sim(&scene)?;
    let (mut x, mut v) = ([0.0; 12], [0.0; 12]);
    sim.copy_positions(&mut x)?;
    for (v, x) in v.iter_mut().zip(&x).step_by(3) {
        *v = rate * x;
    }
    sim.set_motion(&x, &v)?;
    let (mut modulus, mut strength): (Option<f64>, f64) = (None, 0.0);
    let mut before = v[3];
    for _ in 0..PULL.1 {
        sim.copy_positions(&mut x)?;
        let strain = (x[3] - x[0]) / scene.sheet.spacing - 1.0;
        sim.step()?;
        sim.copy_velocities(&mut v)?;
        let stress = scene.sheet.node_mass * (before - v[3]) / sim.step_limits().dt / scene.sheet.yarn_area;
        before = v[3];
        if strain > SECANT {
            modulus.get_or_insert(stress / strain);
        }
        strength = strength.max(stress);
    }
    Ok([modulus.ok_or("the yarn was not stretched")?, strength])
}

/// False if a modulus or a strength is not within the tolerance.
pub fn run(out: &Path) -> Result<bool> {
    let measured = measured()?;
    let (Some(slow), Some(fast)) = (measured.first(), measured.last()) else { return Err("no rates".into()) };
    let scene = cell(slow, fast);
    let found = each(&measured, |row| pulled(&scene, row.rate))?;
    let mut table = Table::new(&[
        "rate 1/s",
        "modulus GPa",
        "measured GPa",
        "measured GPa: deviation",
        "strength MPa",
        "measured MPa",
        "measured MPa: deviation",
    ]);
    let mut sound = true;
    for (row, [modulus, strength]) in measured.iter().zip(found) {
        sound &=
            (modulus / row.modulus[0] - 1.0).abs() < TOLERANCE && (strength / row.strength[0] - 1.0).abs() < TOLERANCE;
        let mut cells = vec![row.rate, 1e-9 * modulus];
        cells.extend(row.modulus.map(|value| 1e-9 * value));
        cells.push(1e-6 * strength);
        cells.extend(row.strength.map(|value| 1e-6 * value));
        table.add(cells.into_iter().map(Cell::Number).collect());
    }
    table.write(&out.join("rate.csv"))?;
    say::line(format_args!(
        "Kevlar 49 fabric at three rates: {}",
        if sound { "as measured" } else { "NOT as measured" }
    ));
    Ok(sound)
}
