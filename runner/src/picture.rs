//! A sheet and its projectile at one time, kept for the pictures that `python/fabric_kernel/sheets.py` draws.
//!
//! The file is little-endian: time, position (3) and orientation (4) of the projectile as f64; then as f32 three coordinates of
//! every node, three components of its velocity, and the stretch of every segment; then alpha of every segment as a byte, 0 to
//! 255, which is 0 only where the segment has failed. Of a stack each of these has all plies, in their order.

use crate::Result;
use fabric::{Layout, Scene, Shape, Sim, Solid};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// What the pictures of a run need besides its files.
#[derive(Serialize)]
pub struct Picture {
    /// Heading.
    name: String,
    /// The last sheet's file, from the folder of the results.
    file: &'static str,
    /// Plies with a network of their own.
    plies: usize,
    /// Modelled nodes along x and y.
    nodes: [usize; 2],
    /// Whether the sheet goes on beyond the last column, and the last row, in a mirror.
    mirrored: [bool; 2],
    /// Half of the side lengths of the whole sheet, m.
    half_size_m: [f64; 2],
    /// Radius of a curved sheet, m; 0 of a flat one.
    radius_m: f64,
    /// Strain at which the yarn begins to fail.
    critical_strain: f64,
    /// Radius of a sphere; 0 for another projectile, which its lines enclose.
    sphere_m: f64,
    /// Fixed nodes: row, first column, and column after the last.
    held: Vec<[usize; 3]>,
    /// Lines on the surface of the projectile, m, in its own axes.
    outline: Vec<Vec<[f64; 3]>>,
}

/// The file of the last sheet.
pub const LAST: &str = "sheet.bin";

/// Keeps the sheet as it is now.
pub fn keep(path: &Path, sim: &Sim<'_>) -> Result<()> {
    let [mut positions, mut velocities] = [(); 2].map(|()| vec![0.0; 3 * sim.layout().nodes()]);
    sim.copy_positions(&mut positions)?;
    sim.copy_velocities(&mut velocities)?;
    let [mut stretch, mut damage] = [(); 2].map(|()| vec![0.0; sim.layout().segments()]);
    sim.copy_stretch(&mut stretch)?;
    sim.copy_damage(&mut damage)?;
    let motion = sim.projectile()?;
    let mut bytes = Vec::new();
    for value in [sim.time()].iter().chain(&motion.position).chain(&motion.orientation) {
        bytes.extend(value.to_le_bytes());
    }
    let singles = [&positions, &velocities, &stretch].into_iter().flatten();
    singles.for_each(|&x| bytes.extend((x as f32).to_le_bytes()));
    bytes.extend(damage.iter().map(|alpha| (255.0 * alpha).ceil() as u8));
    std::fs::write(path, bytes).map_err(|error| format!("{}: {error}", path.display()).into())
}

/// Most sheets of a series.
const MOST: usize = 120;

/// Sheets kept in the folder `frames` while a run goes on. When there are too many, every second one is given up.
pub struct Series<'p> {
    out: &'p Path,
    /// Steps between two sheets, and the step at which the next is due.
    every: u64,
    due: u64,
    kept: Vec<u64>,
}

impl<'p> Series<'p> {
    /// No sheet so far. `out`: the folder of the results.
    pub fn new(out: &'p Path, every: u64) -> Result<Series<'p>> {
        let folder = out.join("frames");
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        Ok(Series { out, every, due: 0, kept: Vec::new() })
    }

    fn file(step: u64) -> PathBuf {
        Path::new("frames").join(format!("{step:08}.bin"))
    }

    /// Keeps the sheet as it is now, if it is due.
    pub fn keep(&mut self, sim: &Sim<'_>) -> Result<()> {
        let step = sim.step_count();
        if step < self.due {
            return Ok(());
        }
        keep(&self.out.join(Self::file(step)), sim)?;
        self.kept.push(step);
        if self.kept.len() > MOST {
            self.every *= 2;
            let (stay, go): (Vec<_>, Vec<_>) = self.kept.iter().enumerate().partition(|(index, _)| index % 2 == 0);
            for (_, step) in go {
                std::fs::remove_file(self.out.join(Self::file(*step)))?;
            }
            self.kept = stay.into_iter().map(|(_, step)| *step).collect();
        }
        self.due = step + self.every;
        Ok(())
    }

    /// Keeps the last sheet too. Returns the files of all.
    pub fn end(mut self, sim: &Sim<'_>) -> Result<Vec<PathBuf>> {
        if self.kept.last() != Some(&sim.step_count()) {
            self.due = 0;
            self.keep(sim)?;
        }
        Ok(self.kept.into_iter().map(Self::file).collect())
    }
}

/// Describes the sheets of this scene.
pub fn describe(name: String, scene: &Scene) -> Result<Picture> {
    let layout = Layout::of(scene)?;
    let held = |row: usize| {
        let runs = fabric::internals::weave::fixed_runs(scene, row);
        runs.map(|run| [row, run[0] as usize, run[1] as usize]).into_iter().filter(|run| run[2] > run[1])
    };
    Ok(Picture {
        name,
        file: LAST,
        plies: layout.plies,
        nodes: [layout.nodes_x, layout.y.modelled()],
        // The segment that closes a ring is not drawn either.
        mirrored: [scene.symmetry.mirror_x || scene.is_closed(), scene.symmetry.mirror_y],
        half_size_m: scene.half_size(),
        radius_m: scene.sheet.radius,
        critical_strain: scene.yarn.critical_stretch - 1.0,
        sphere_m: if scene.projectile.shape == Shape::Sphere { scene.projectile.radius } else { 0.0 },
        held: (0..layout.y.modelled()).flat_map(held).collect(),
        outline: outline(scene),
    })
}

/// Lines that show how the projectile is turned: three great circles of a sphere; rims and eight generators
/// of a cylinder, and two half circles over its hemisphere; the edges of a box or a polyhedron.
fn outline(scene: &Scene) -> Vec<Vec<[f64; 3]>> {
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
    match Solid::of(&scene.projectile) {
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
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_series_is_thinned_out_and_has_both_ends() {
        let mut scene = Scene::sheet_3in_sphere();
        (scene.sheet.nodes_x, scene.sheet.nodes_y) = (33, 33);
        let mut buffers = crate::memory::Buffers::of(&scene).unwrap();
        let mut sim = buffers.sim(&scene).unwrap();
        let out = std::env::temp_dir().join(format!("fabric-series-{}", std::process::id()));
        let mut series = Series::new(&out, 1).unwrap();
        for _ in 0..300 {
            series.keep(&sim).unwrap();
            sim.advance(1).unwrap();
        }
        let frames = series.end(&sim).unwrap();
        let files = std::fs::read_dir(out.join("frames")).unwrap().count();
        assert_eq!((frames.len(), files), (76, 76));
        assert_eq!([0, 1, 75].map(|k| &frames[k]), [0, 4, 300].map(Series::file).each_ref());
        std::fs::remove_dir_all(&out).unwrap();
    }
}
