//! A sheet and its projectile at one time, kept for the pictures that `reports` draws.
//!
//! The file is little-endian: time, position (3) and orientation (4) of the projectile as f64; 3 coordinates of every node as
//! f32; alpha of every segment as a byte, 0 to 255, which is 0 only where the segment has failed. Of a stack all plies, in their order.

use crate::Result;
use fabric::shape::Solid;
use fabric::{Motion, Scene, Sim};
use serde::Serialize;
use std::path::Path;

/// What a picture needs besides the file.
#[derive(Serialize)]
pub struct Picture {
    /// Heading.
    name: String,
    /// The file, from the folder of the results.
    file: String,
    /// Plies with a network of their own.
    plies: usize,
    /// Modelled nodes along x and y.
    nodes: [usize; 2],
    /// Whether the sheet goes on beyond the last column, and the last row, in a mirror.
    mirrored: [bool; 2],
    /// Half of the side lengths of the whole sheet, m.
    half_size_m: [f64; 2],
    /// Distance of neighbouring nodes at rest, m.
    spacing_m: f64,
    /// Fixed nodes: row, first column, and column after the last.
    held: Vec<[usize; 3]>,
    /// Lines on the surface of the projectile, m.
    outline: Vec<Vec<[f64; 3]>>,
}

/// Keeps the sheet as it is now.
pub fn keep(path: &Path, sim: &Sim<'_>) -> Result<()> {
    let mut positions = vec![0.0; 3 * sim.layout().nodes()];
    sim.copy_positions(&mut positions)?;
    let mut damage = vec![0.0; sim.layout().segments()];
    sim.copy_damage(&mut damage)?;
    let motion = sim.projectile()?;
    let mut bytes = Vec::new();
    for value in [sim.time()].iter().chain(&motion.position).chain(&motion.orientation) {
        bytes.extend(value.to_le_bytes());
    }
    positions.iter().for_each(|&x| bytes.extend((x as f32).to_le_bytes()));
    bytes.extend(damage.iter().map(|alpha| (255.0 * alpha).ceil() as u8));
    std::fs::write(path, bytes).map_err(|error| format!("{}: {error}", path.display()).into())
}

/// Describes a kept sheet of this scene; `file`: where it is, from the folder of the results.
pub fn describe(folder: &Path, file: String, name: String, scene: &Scene) -> Result<Picture> {
    let path = folder.join(&file);
    let bytes = std::fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let head = bytes.get(..64).ok_or_else(|| format!("{}: too short for a sheet", path.display()))?;
    let head: Vec<f64> = head.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
    let motion = Motion {
        position: [head[1], head[2], head[3]],
        velocity: [0.0; 3],
        orientation: [head[4], head[5], head[6], head[7]],
        angular_velocity: [0.0; 3],
    };
    let layout = fabric::Layout::of(scene)?;
    let held = |row: usize| {
        let runs = fabric::weave::fixed_runs(scene, row);
        runs.map(|run| [row, run[0] as usize, run[1] as usize]).into_iter().filter(|run| run[2] > run[1])
    };
    Ok(Picture {
        name,
        file,
        plies: layout.plies,
        nodes: [layout.nodes_x, layout.y.modelled()],
        mirrored: [scene.symmetry.mirror_x, scene.symmetry.mirror_y],
        half_size_m: scene.half_size(),
        spacing_m: scene.sheet.spacing,
        held: (0..layout.y.modelled()).flat_map(held).collect(),
        outline: outline(scene, &motion),
    })
}

/// Lines that show where the projectile is and how it is turned: three great circles of a sphere; rims and eight generators
/// of a cylinder, and two half circles over its hemisphere; the edges of a box or a polyhedron.
fn outline(scene: &Scene, motion: &Motion) -> Vec<Vec<[f64; 3]>> {
    use std::f64::consts::TAU;
    let arc = |part: f64, at: &dyn Fn(f64, f64) -> [f64; 3]| -> Vec<[f64; 3]> {
        let angles = (0..=48).map(|k| part * TAU * k as f64 / 48.0);
        angles.map(|angle| at(angle.cos(), angle.sin())).collect()
    };
    let rods = |r: f64, bottom: f64, top: f64| {
        let rims = [bottom, top].map(|z| arc(1.0, &|a, b| [r * a, r * b, z]));
        let generators: Vec<_> = (0..48).step_by(6).map(|k| vec![rims[0][k], rims[1][k]]).collect();
        generators.into_iter().chain(rims).collect::<Vec<_>>()
    };
    let lines = match Solid::of(&scene.projectile) {
        Solid::Sphere { radius: r } => vec![
            arc(1.0, &|a, b| [r * a, r * b, 0.0]),
            arc(1.0, &|a, b| [r * a, 0.0, r * b]),
            arc(1.0, &|a, b| [0.0, r * a, r * b]),
        ],
        Solid::Cylinder { radius, half_length } => rods(radius, -half_length, half_length),
        Solid::HemisphericalCylinder { radius: r, shank, nose } => {
            let mut lines = rods(r, nose - shank, nose);
            lines.push(arc(0.5, &|a, b| [r * a, 0.0, nose + r * b]));
            lines.push(arc(0.5, &|a, b| [0.0, r * a, nose + r * b]));
            lines
        }
        Solid::Polyhedron(body) => body.edges().map(|ends| ends.map(Into::into).to_vec()).collect(),
    };
    let world = |line: Vec<[f64; 3]>| line.into_iter().map(|x| placed(x, motion)).collect();
    lines.into_iter().map(world).collect()
}

/// A point of the body in the world: P + q x q^-1, written as x + 2 w (u x x) + 2 u x (u x x) with q = (w, u).
fn placed(x: [f64; 3], motion: &Motion) -> [f64; 3] {
    let [w, ux, uy, uz] = motion.orientation;
    let cross = |b: [f64; 3]| [uy * b[2] - uz * b[1], uz * b[0] - ux * b[2], ux * b[1] - uy * b[0]];
    let once = cross(x);
    let twice = cross(once);
    [0, 1, 2].map(|k| motion.position[k] + x[k] + 2.0 * (w * once[k] + twice[k]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_about_z_brings_x_to_y() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let motion = Motion {
            position: [0.0, 0.0, 3.0],
            velocity: [0.0; 3],
            orientation: [half, 0.0, 0.0, half],
            angular_velocity: [0.0; 3],
        };
        let point = placed([1.0, 0.0, 0.0], &motion);
        assert!(fabric::math::length([point[0], point[1] - 1.0, point[2] - 3.0]) < 1e-15);
    }
}
