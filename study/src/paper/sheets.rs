//! Pictures of deformed sheets (Figs 10 and 12): the state of a sheet as it is kept on disk, and small raster images of it.

use super::plan::Effort;
use crate::{Result, event, run};
use fabric::{AttachmentKind, Motion, Scene, Sim};
use std::path::{Path, PathBuf};

/// Times of the pictures of clamped sheets, s.
const CLAMPED_TIMES: [f64; 3] = [150e-6, 250e-6, 350e-6];
/// The same for sheets held at their corners, which tear later, s.
const CORNER_TIMES: [f64; 3] = [200e-6, 600e-6, 1000e-6];
/// The same for the tiny sheets of a smoke test, s.
const SMOKE_TIMES: [f64; 3] = [5e-6, 10e-6, 20e-6];

/// Times of the pictures of a sheet, s.
pub fn times(effort: Effort, attachment: AttachmentKind) -> &'static [f64] {
    match (effort, attachment) {
        (Effort::Smoke, _) => &SMOKE_TIMES,
        (_, AttachmentKind::FourCorners) => &CORNER_TIMES,
        _ => &CLAMPED_TIMES,
    }
}

/// A sheet at one time.
pub struct Sheet {
    /// Time, s.
    pub time: f64,
    /// The projectile.
    pub motion: Motion,
    /// Positions of the nodes, m.
    pub positions: Vec<[f32; 3]>,
    /// alpha of every segment, 0 to 255; 0 only if it has failed.
    pub damage: Vec<u8>,
}

/// Where a sheet is kept.
pub fn path(out: &Path, key: &str, time: f64) -> PathBuf {
    out.join("sheets").join(format!("{key}_{:.0}us.bin", 1e6 * time))
}

/// Keeps the sheet as it is now. Little-endian: time, position and orientation as f64, positions as f32, damage as bytes.
pub fn keep(out: &Path, key: &str, time: f64, sim: &Sim<'_>) -> Result<()> {
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
    let path = path(out, key, time);
    std::fs::create_dir_all(out.join("sheets"))?;
    std::fs::write(&path, bytes).map_err(|error| format!("{}: {error}", path.display()).into())
}

/// Reads a kept sheet of this scene.
pub fn read(path: &Path, scene: &Scene) -> Result<Sheet> {
    let bytes = std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let nodes = scene.sheet.nodes_x as usize * scene.sheet.nodes_y as usize;
    if bytes.len() != 64 + 12 * nodes + scene.segments() as usize {
        return Err(format!("{}: not a sheet of {nodes} nodes", path.display()).into());
    }
    let (head, rest) = bytes.split_at(64);
    let (positions, damage) = rest.split_at(12 * nodes);
    let head: Vec<f64> = head.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
    let numbers: Vec<f32> = positions.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
    Ok(Sheet {
        time: head[0],
        motion: Motion {
            position: [head[1], head[2], head[3]],
            velocity: [0.0; 3],
            orientation: [head[4], head[5], head[6], head[7]],
            angular_velocity: [0.0; 3],
        },
        positions: numbers.as_chunks::<3>().0.to_vec(),
        damage: damage.to_vec(),
    })
}

/// Width of a picture, pixels.
const WIDTH: usize = 460;
/// Drawn so many times larger and averaged down.
const FINE: usize = 2;

/// A raster image of lines on white.
struct Image {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 3]>,
}

impl Image {
    fn new(width: usize, height: usize) -> Image {
        let (width, height) = (width * FINE, height * FINE);
        Image { width, height, pixels: vec![[255; 3]; width * height] }
    }

    /// A line between two points, in pixels of the finished image from its upper left corner; `opacity` of 1 covers.
    fn line(&mut self, from: (f64, f64), to: (f64, f64), colour: [u8; 3], opacity: f64, thick: bool) {
        let scale = FINE as f64;
        let (dx, dy) = (scale * (to.0 - from.0), scale * (to.1 - from.1));
        let steps = dx.abs().max(dy.abs()).ceil().clamp(1.0, 20_000.0);
        for k in 0..=steps as u64 {
            let part = k as f64 / steps;
            let (x, y) = (scale * from.0 + part * dx, scale * from.1 + part * dy);
            self.dot(x, y, colour, opacity);
            if thick {
                self.dot(x + 1.0, y, colour, opacity);
                self.dot(x, y + 1.0, colour, opacity);
            }
        }
    }

    fn dot(&mut self, x: f64, y: f64, colour: [u8; 3], opacity: f64) {
        if x < 0.0 || y < 0.0 || x >= self.width as f64 || y >= self.height as f64 {
            return;
        }
        let pixel = &mut self.pixels[y as usize * self.width + x as usize];
        for (channel, &wanted) in pixel.iter_mut().zip(&colour) {
            *channel = (*channel as f64 * (1.0 - opacity) + wanted as f64 * opacity).round() as u8;
        }
    }

    /// The image as PNG.
    fn png(&self) -> Result<Vec<u8>> {
        let (width, height) = (self.width / FINE, self.height / FINE);
        let mut bytes = Vec::with_capacity(3 * width * height);
        for y in 0..height {
            for x in 0..width {
                for channel in 0..3 {
                    let mut sum = 0;
                    for k in 0..FINE * FINE {
                        let place = (y * FINE + k / FINE) * self.width + x * FINE + k % FINE;
                        sum += self.pixels[place][channel] as usize;
                    }
                    bytes.push((sum / (FINE * FINE)) as u8);
                }
            }
        }
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, width as u32, height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::High);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&bytes)?;
        writer.finish()?;
        Ok(file)
    }
}

const YARN: [u8; 3] = [70, 95, 135];
const BODY: [u8; 3] = [0, 0, 0];

/// Yellow for the first damage, over orange, to dark red for failed.
fn damage_colour(alpha: u8) -> [u8; 3] {
    if alpha == 0 { [140, 0, 20] } else { [240, 90 + (alpha as u16 * 130 / 255) as u8, 30] }
}

impl Sheet {
    /// The sheet from the side: x to the right, z (the line of flight) upward, the same scale along both. PNG.
    pub fn side_view(&self, scene: &Scene) -> Result<Vec<u8>> {
        let half = scene.half_size()[0];
        let scale = 0.94 * WIDTH as f64 / (2.0 * half);
        // Room for the projectile and for the dome.
        let outline = run::outline(scene, &self.motion);
        let heights = || outline.iter().flatten().map(|point| point[2]);
        let below = heights().fold(0.0, f64::min).abs() + 0.05 * half;
        let above = heights().fold(self.deflection(), f64::max) + 0.05 * half;
        let mut image = Image::new(WIDTH, ((below + above) * scale) as usize);
        let at = |x: f64, z: f64| (0.5 * WIDTH as f64 + scale * x, scale * (above - z));
        let point = |node: usize| at(self.positions[node][0] as f64, self.positions[node][2] as f64);
        for (a, b, alpha) in self.segments(scene) {
            if alpha > 0 {
                image.line(point(a), point(b), YARN, 0.10, false);
            }
        }
        for (a, b, alpha) in self.segments(scene) {
            if alpha > 0 && alpha < 255 {
                image.line(point(a), point(b), damage_colour(alpha), 0.9, true);
            }
        }
        for line in &outline {
            for pair in line.windows(2) {
                image.line(at(pair[0][0], pair[0][2]), at(pair[1][0], pair[1][2]), BODY, 1.0, true);
            }
        }
        image.png()
    }

    /// Damage on the undeformed grid, seen along the line of flight. PNG.
    pub fn damage_map(&self, scene: &Scene) -> Result<Vec<u8>> {
        let (nx, ny) = (scene.sheet.nodes_x as usize, scene.sheet.nodes_y as usize);
        let mut image = Image::new(WIDTH, WIDTH);
        let scale = 0.96 * WIDTH as f64 / nx.max(ny) as f64;
        let margin = 0.02 * WIDTH as f64;
        let place = |i: f64, j: f64| (margin + scale * (i + 0.5), WIDTH as f64 - margin - scale * (j + 0.5));
        let at = |node: usize| place((node % nx) as f64, (node / nx) as f64);
        let (right, top) = (nx as f64 - 1.0, ny as f64 - 1.0);
        let frame = [(0.0, 0.0), (right, 0.0), (right, top), (0.0, top), (0.0, 0.0)];
        for pair in frame.windows(2) {
            image.line(place(pair[0].0, pair[0].1), place(pair[1].0, pair[1].1), [170; 3], 1.0, true);
        }
        for j in 0..ny {
            for run in fabric::weave::fixed_runs(scene, j).iter().filter(|run| run[1] > run[0]) {
                let (from, to) = (run[0] as f64, run[1] as f64 - 1.0);
                image.line(place(from - 0.4, j as f64), place(to + 0.4, j as f64), [120; 3], 1.0, true);
            }
        }
        for (a, b, alpha) in self.segments(scene).filter(|(_, _, alpha)| *alpha < 255) {
            image.line(at(a), at(b), damage_colour(alpha), 1.0, true);
        }
        image.png()
    }

    /// Failed segments.
    pub fn failed(&self) -> usize {
        self.damage.iter().filter(|&&alpha| alpha == 0).count()
    }

    /// Largest deflection of a node that is still near the sheet's body, m: debris may be anywhere.
    pub fn deflection(&self) -> f64 {
        let mut depths: Vec<f64> = self.positions.iter().map(|x| event::length([0.0, 0.0, x[2] as f64])).collect();
        depths.sort_by(f64::total_cmp);
        depths.get(depths.len() - 1 - depths.len() / 500).copied().unwrap_or(0.0)
    }

    fn segments(&self, scene: &Scene) -> impl Iterator<Item = (usize, usize, u8)> {
        let (nx, ny) = (scene.sheet.nodes_x as usize, scene.sheet.nodes_y as usize);
        let across = (0..ny).flat_map(move |j| (0..nx - 1).map(move |i| (j * nx + i, j * nx + i + 1)));
        let along = (0..ny - 1).flat_map(move |j| (0..nx).map(move |i| (j * nx + i, (j + 1) * nx + i)));
        across.chain(along).zip(&self.damage).map(|((a, b), &alpha)| (a, b, alpha))
    }
}
