//! How far two runs of one problem stay together point by point, before the first failure.
//!
//! Three runs of each scene: as it is; with an impact velocity higher by 1e-12; mirrored in the plane x = 0, which is the same
//! problem with its sums in another order. The hit is off the centre, so that no symmetry hides a difference. All three are
//! correct: what they differ by, no comparison of two programs can do better.
//!
//! A segment has no stiffness below its rest length, so a node between slack segments is held by nothing, and contact and the
//! return of tension come at slightly other times: there differences grow. How much of the sheet is slack stands beside them.

use super::impact::ROUNDING;
use super::{Cell, Effort, Table};
use crate::memory::Buffers;
use crate::{Result, say};
use fabric::{AttachmentKind, Scene, Sim};
use rayon::prelude::*;
use std::path::Path;

/// Steps between two comparisons.
const STRIDE: u64 = 200;
/// Steps that get a row of the table; the last comparison before the first failure, or before the end, gets one too.
const ROWS: [u64; 5] = [400, 1000, 2000, 4000, 8000];
/// Steps after which a scene that has not failed is given up.
const LONGEST: u64 = 16000;
/// Allowed distance of a node at the first row, in node spacings: the wave has just come to the edges.
const TOLERANCE: f64 = 1e-9;
/// Place of the hit, in node spacings from the centre.
const HIT: [f64; 2] = [0.31, 0.17];
const HELD: [(&str, AttachmentKind); 4] = [
    ("four sides", AttachmentKind::FourSides),
    ("two sides", AttachmentKind::TwoSides),
    ("corners", AttachmentKind::FourCorners),
    ("free", AttachmentKind::Free),
];

/// Largest and root mean square distance of the nodes of two runs, in node spacings; `mirror`: of a run and its mirror image.
fn apart(one: &Sim<'_>, other: &Sim<'_>, mirror: bool) -> Result<[f64; 2]> {
    let (columns, nodes) = (one.layout().nodes_x, one.layout().nodes());
    let [mut x, mut y] = [vec![0.0; 3 * nodes], vec![0.0; 3 * nodes]];
    one.copy_positions(&mut x)?;
    other.copy_positions(&mut y)?;
    let (x, y) = (x.as_chunks::<3>().0, y.as_chunks::<3>().0);
    let (mut largest, mut squares) = (0.0_f64, 0.0);
    for (k, a) in x.iter().enumerate() {
        let mut b = y[k];
        if mirror {
            b = y[k - k % columns + columns - 1 - k % columns];
            b[0] = -b[0];
        }
        let distance = fabric::math::length([a[0] - b[0], a[1] - b[1], a[2] - b[2]]) / one.scene().sheet.spacing;
        largest = largest.max(distance);
        squares += distance * distance;
    }
    Ok([largest, (squares / nodes as f64).sqrt()])
}

/// Part of the segments that are shorter than at rest, beyond rounding.
fn slack(sim: &Sim<'_>) -> Result<f64> {
    let mut stretches = vec![0.0; sim.layout().segments()];
    sim.copy_stretch(&mut stretches)?;
    Ok(stretches.iter().filter(|&&stretch| stretch < 1.0 - 1e-9).count() as f64 / stretches.len() as f64)
}

/// The rows of one scene, and whether the first of them is within rounding.
fn compare(name: &str, kind: AttachmentKind, energy: f64) -> Result<(Vec<Vec<Cell>>, bool)> {
    let mut scene = Scene::sheet_3in_sphere();
    scene.attachment.kind = kind;
    scene.yarn.stochastic = false;
    let body = &mut scene.projectile;
    body.velocity[2] = (2.0 * energy / body.mass).sqrt();
    [body.position[0], body.position[1]] = HIT.map(|part| part * scene.sheet.spacing);
    let [mut faster, mut mirrored] = [scene; 2];
    faster.projectile.velocity[2] *= 1.0 + ROUNDING;
    mirrored.projectile.position[0] *= -1.0;
    let scenes = [scene, faster, mirrored];
    let [mut first, mut second, mut third] =
        [Buffers::of(&scenes[0])?, Buffers::of(&scenes[1])?, Buffers::of(&scenes[2])?];
    let mut sims = [first.sim(&scenes[0])?, second.sim(&scenes[1])?, third.sim(&scenes[2])?];
    let (mut rows, mut last, mut sound) = (Vec::new(), None, true);
    // Largest so far: distance to either run; difference of velocity, of work.
    let (mut distances, mut velocity, mut work) = ([0.0_f64; 2], 0.0_f64, 0.0_f64);
    for step in (STRIDE..=LONGEST).step_by(STRIDE as usize) {
        for sim in &mut sims {
            sim.advance(STRIDE)?;
        }
        if sims.iter().any(|sim| sim.counters().failed_segments > 0) {
            break;
        }
        let [one, faster, mirrored] = &sims;
        let mut squares = 0.0_f64;
        for (most, (other, mirror)) in distances.iter_mut().zip([(faster, false), (mirrored, true)]) {
            let [largest, mean] = apart(one, other, mirror)?;
            *most = most.max(largest);
            squares = squares.max(mean);
            let change = other.projectile()?.velocity[2] - one.projectile()?.velocity[2];
            velocity = velocity.max(change.abs() / scene.projectile.velocity[2]);
            work = work.max((other.contact()?.work - one.contact()?.work).abs() / energy);
        }
        sound &= step > ROWS[0] || distances.iter().all(|largest| *largest < TOLERANCE);
        let mut row = vec![
            Cell::text(format!("{name}, {energy} J")),
            Cell::Number(step as f64),
            Cell::Number(1e6 * one.time()),
            Cell::Number(100.0 * slack(one)?),
        ];
        row.extend(distances.into_iter().chain([squares, velocity, work]).map(Cell::Number));
        if ROWS.contains(&step) {
            rows.push(row);
            last = None;
        } else {
            last = Some(row);
        }
    }
    rows.extend(last);
    Ok((rows, sound))
}

/// False if the runs are apart before the sheet's edge can matter.
pub fn run(effort: Effort, out: &Path) -> Result<bool> {
    let energies: &[f64] = if effort == Effort::Full { &[5.0, 10.0, 40.0] } else { &[40.0] };
    let held = if effort == Effort::Smoke { &HELD[..1] } else { &HELD };
    let scenes: Vec<_> = held.iter().flat_map(|held| energies.iter().map(move |energy| (held, *energy))).collect();
    let found: Vec<(Vec<Vec<Cell>>, bool)> = scenes
        .par_iter()
        .with_max_len(1)
        .map(|((name, kind), energy)| compare(name, *kind, *energy).map_err(|error| error.to_string()))
        .collect::<std::result::Result<_, _>>()?;
    let mut table = Table::new(&[
        "case",
        "step",
        "time us",
        "slack segments %",
        "V0 by 1e-12: largest so far (h)",
        "mirrored: largest so far (h)",
        "root mean square now (h)",
        "velocity so far, of V0",
        "work so far, of KE0",
    ]);
    let mut sound = true;
    for (rows, good) in found {
        rows.into_iter().for_each(|row| table.add(row));
        sound &= good;
    }
    table.write(&out.join("pointwise.csv"))?;
    if !sound {
        say::line(format_args!("at step {} nodes are apart by more than {TOLERANCE:e} h: NOT as it must be", ROWS[0]));
    }
    Ok(sound)
}
