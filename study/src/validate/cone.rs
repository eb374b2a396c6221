//! The pyramid behind the transverse wave of a sheet that is hit at a point, against theory.
//!
//! Two theories. Jump condition: the front of the pyramid is a kink of each yarn, whatever the waves before it have done. With the
//! strain just before it, U - 1, the tension N there and the mass per length mu = m/h of a yarn with what it carries of the crossing
//! yarns, the kink runs at U sqrt(N/(mu U)) relative to the yarn, which itself moves inwards. In a plain weave of equal yarns mu is
//! twice that of a yarn. Strip: Smith's relation with mu doubled, which is exact for a sheet that is hit along a line, and is used for
//! points too (D. Roylance, A. Wilde, G. Tocci, Textile Research Journal 43 (1973) 34). At a point the hit yarns also drag the
//! crossing ones, so the strain is not uniform: how far the strip is off is a result, not an error.
//!
//! Method: Kevlar KM2 S706, 801 x 801 yarns of which a quarter is modelled, hit at its centre by a sphere so heavy that its velocity
//! stays, until the longitudinal front is near the edge. The front is where the deflection is 1 % of the deepest; its speed is the
//! slope over the second half of the time. Strain and inward velocity are means over ten segments that begin four before it.
//! Limit: the kink is some spacings wide, and the strain before it is still falling outwards.

use super::yarn::slope;
use super::{named, sheet};
use crate::Result;
use crate::error_time::overshoot::{self, VISCOUS, with_viscosity};
use crate::hits::each;
use crate::memory::Buffers;
use crate::progress::Progress;
use crate::table::{Cell, Table};
use fabric::{Scene, Symmetry};
use std::path::Path;

/// Impact velocities, m/s.
const SPEEDS: [f64; 4] = [50.0, 75.0, 100.0, 150.0];
/// Radius of the sphere, m, and its mass, kg.
const SPHERE: (f64, f64) = (3.175e-3, 1.0);
/// Where the front is, in parts of the deepest deflection.
const FRONT: f64 = 0.01;
/// Segments from the front to where strain and inward velocity are taken, and their number.
const BEFORE: (usize, usize) = (4, 10);
const SAMPLES: u64 = 16;

fn scene(half: u32, speed: f64) -> Result<Scene> {
    let mut scene = with_viscosity(sheet(&named("kevlar_km2_s706")?, 1.0, 1.0)?, VISCOUS);
    (scene.sheet.nodes_x, scene.sheet.nodes_y) = (2 * half + 1, 2 * half + 1);
    scene.symmetry = Symmetry { mirror_x: true, mirror_y: true };
    let body = &mut scene.projectile;
    (body.radius, body.mass) = SPHERE;
    body.position = [0.0, 0.0, -body.radius];
    body.velocity = [0.0, 0.0, speed];
    Ok(scene)
}

/// What the pyramid of a sheet is.
struct Pyramid {
    /// Strain before its front, along the yarns.
    strain: f64,
    /// Speed of its front along the yarns and along the diagonal, m/s.
    front: [f64; 2],
    /// What the jump condition gives for the first, m/s.
    jump: f64,
    failed: u64,
}

/// Distance at which the deflection along a line of nodes, from the centre outwards, falls below the front's, m.
fn place(nodes: impl Iterator<Item = [f64; 3]>) -> Option<(usize, f64)> {
    let points: Vec<(f64, f64)> = nodes.map(|x| (x[0].hypot(x[1]), x[2])).collect();
    let level = FRONT * points.first()?.1;
    let k = points.iter().position(|point| point.1 < level)?;
    let ((r0, z0), (r1, z1)) = (points[k.checked_sub(1)?], points[k]);
    Some((k, r0 + (r1 - r0) * (z0 - level) / (z0 - z1)))
}

fn pyramid(half: u32, speed: f64) -> Result<Pyramid> {
    let scene = scene(half, speed)?;
    let mut buffers = Buffers::of(&scene)?;
    let mut sim = buffers.sim(&scene)?;
    let front = overshoot::smith(&scene, speed).1.front;
    let (h, n) = (scene.sheet.spacing, half as usize + 1);
    let steps = (0.9 * f64::from(half) * h / front / sim.step_limits().dt) as u64;
    let (mut x, mut v) = (vec![0.0; 3 * n * n], vec![0.0; 3 * n * n]);
    let (mut strain, mut jump) = (0.0, 0.0);
    let mut places = [Vec::new(), Vec::new()];
    for sample in 1..=SAMPLES {
        sim.advance(steps / 2 + steps * sample / (2 * SAMPLES) - sim.step_count())?;
        sim.copy_positions(&mut x)?;
        sim.copy_velocities(&mut v)?;
        // Nodes from the centre, which is the last one.
        let node = |i: usize, j: usize| x.as_chunks::<3>().0[(n - 1 - j) * n + n - 1 - i];
        let along = place((0..n).map(|k| node(k, 0))).ok_or("the pyramid has no front")?;
        let diagonal = place((0..n).map(|k| node(k, k))).ok_or("the pyramid has no front")?;
        places[0].push((sim.time(), along.1));
        places[1].push((sim.time(), diagonal.1));
        let from = along.0 + BEFORE.0;
        let (a, b) = (node(from, 0), node(from + BEFORE.1, 0));
        let stretch = (a[0] - b[0]).hypot(a[2] - b[2]) / (BEFORE.1 as f64 * h);
        let inward = (0..=BEFORE.1).map(|k| v[3 * (n * n - 1 - from - k)]).sum::<f64>() / (BEFORE.1 + 1) as f64;
        let pull = scene.sheet.yarn_area * scene.yarn.modulus_mean * 0.5 * stretch * (stretch * stretch - 1.0);
        let mu = scene.sheet.node_mass / h;
        strain += (stretch - 1.0) / SAMPLES as f64;
        jump += (stretch * (pull / (mu * stretch)).sqrt() - inward) / SAMPLES as f64;
    }
    let failed = sim.counters().failed_segments;
    Ok(Pyramid { strain, front: places.map(|places| slope(&places)), jump, failed })
}

/// Measures and writes.
pub fn run(quick: bool, out: &Path) -> Result<()> {
    let half = if quick { 150 } else { 400 };
    let speeds = if quick { &SPEEDS[1..3] } else { &SPEEDS };
    let progress = Progress::new("cone", speeds.len() as u64);
    let found = each(speeds, |&speed| {
        let found = pyramid(half, speed)?;
        progress.add(1, || format!("{speed} m/s"));
        Ok(found)
    })?;
    progress.finish();
    let mut table = Table::new(&[
        "impact m/s",
        "failed segments",
        "strain before the front %",
        "front m/s",
        "jump condition m/s",
        "diagonal front m/s",
        "strip strain %",
        "strip m/s",
    ]);
    for (&speed, found) in speeds.iter().zip(found) {
        let (stretch, strip) = overshoot::smith(&scene(half, speed)?, speed);
        let [along, diagonal] = found.front;
        let mut row = vec![Cell::Number(speed), Cell::Number(found.failed as f64)];
        row.extend(
            [100.0 * found.strain, along, found.jump, diagonal, 100.0 * (stretch - 1.0), strip.kink].map(Cell::Number),
        );
        table.add(row);
    }
    table.write(&out.join("cone.csv"))
}
