//! What is computed: a point is an ensemble of runs that differ in their seed, or, with uniform yarn, in the last digits of
//! the impact velocity.

use crate::effort::Effort;
use fabric::{AttachmentKind, Draw, Scene, Symmetry};

/// Impact energies of the sphere on the 3 in sheet, J.
pub const ENERGIES: [f64; 10] = [2.5, 5.0, 7.5, 10.0, 15.0, 20.0, 40.0, 80.0, 160.0, 320.0];
/// Impact energies of the map of the open question, J: about the ballistic limit of the sheet held at its corners.
pub const MAP_ENERGIES: [f64; 6] = [5.0, 7.5, 10.0, 12.5, 15.0, 20.0];
/// Impact velocities of the cylinder on the 10 in sheet, m/s.
pub const VELOCITIES: [f64; 6] = [40.0, 60.0, 80.0, 100.0, 140.0, 200.0];
/// The attachments in the order in which tables and plots show them.
pub const ATTACHMENTS: [AttachmentKind; 3] =
    [AttachmentKind::TwoSides, AttachmentKind::FourSides, AttachmentKind::FourCorners];
/// A low and a high impact energy for the energy histories (Figs 15 to 17), J.
pub const HISTORY_ENERGIES: [f64; 2] = [20.0, 160.0];
/// Impact velocity of the pictures of the 10 in sheet (Figs 10 and 12), m/s.
pub const PICTURE_VELOCITY: f64 = 100.0;

/// The two experiments of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Sheet {
    /// 3 in sheet, sphere.
    Small,
    /// 10 in sheet, cylinder.
    Large,
}

impl Sheet {
    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Sheet::Small => "3 in, sphere",
            Sheet::Large => "10 in, cylinder",
        }
    }
}

/// Yarn of a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Yarn {
    /// Every segment draws its own modulus and damage rate.
    Stochastic,
    /// All segments take the mean; rounding decides which corner fails first.
    Uniform,
    /// The same, kept mirror-symmetric by planes: all corners fail alike.
    Symmetric,
    /// Every woven yarn draws once.
    Woven,
}

impl Yarn {
    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Yarn::Stochastic => "stochastic",
            Yarn::Uniform => "uniform",
            Yarn::Symmetric => "uniform, mirror-symmetric",
            Yarn::Woven => "stochastic, one draw per yarn",
        }
    }
}

/// Washers at the corners: where and how large.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Washer {
    /// Distance of the centre from both edges, m.
    pub inset: f64,
    /// Radius, m.
    pub radius: f64,
    /// In words.
    pub name: &'static str,
}

/// The washers of the preset, first, and the other readings of the paper's text.
pub const WASHERS: [Washer; 5] = [
    Washer { inset: 7.62e-3, radius: 5.715e-3, name: "preset: c 7.62, r 5.715 mm" },
    Washer { inset: 12.7e-3, radius: 9.525e-3, name: "larger: c 12.7, r 9.525 mm" },
    Washer { inset: 7.62e-3, radius: 2.9e-3, name: "smaller: c 7.62, r 2.9 mm" },
    Washer { inset: 0.0, radius: 5.715e-3, name: "quarter disc: c 0, r 5.715 mm" },
    Washer { inset: 0.0, radius: 9.5e-3, name: "quarter disc: c 0, r 9.5 mm" },
];

/// Impact by energy or by velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Impact {
    /// Kinetic energy, J.
    Energy(f64),
    /// Velocity, m/s.
    Velocity(f64),
}

/// An ensemble.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Sheet and projectile.
    pub sheet: Sheet,
    /// How it is held.
    pub attachment: AttachmentKind,
    /// Index in [`WASHERS`] (corners of the 3 in sheet only).
    pub washer: usize,
    /// Yarn.
    pub yarn: Yarn,
    /// Impact.
    pub impact: Impact,
    /// Number of runs.
    pub runs: u64,
}

/// Most steps of a run on the 10 in sheet in the short form.
pub const LARGE_QUICK_STEPS: u64 = 80_000;
/// Nodes along a side of the tiny sheets.
const SMOKE_NODES: u32 = 35;

impl Effort {
    /// Impact energies on the 3 in sheet.
    pub fn energies(self) -> &'static [f64] {
        match self {
            Effort::Full => &ENERGIES,
            Effort::Quick => &[10.0, 20.0, 160.0],
            Effort::Smoke => &[20.0, 160.0],
        }
    }

    /// Impact velocities on the 10 in sheet.
    pub fn velocities(self) -> &'static [f64] {
        match self {
            Effort::Full => &VELOCITIES,
            Effort::Quick | Effort::Smoke => &[100.0, 200.0],
        }
    }

    /// Impact energies of the map.
    pub fn map_energies(self) -> &'static [f64] {
        match self {
            Effort::Full => &MAP_ENERGIES,
            Effort::Quick => &[10.0],
            Effort::Smoke => &[20.0],
        }
    }

    /// Washers of the map.
    pub fn washers(self) -> usize {
        match self {
            Effort::Full => WASHERS.len(),
            Effort::Quick | Effort::Smoke => 2,
        }
    }

    /// Runs of a point of this sheet.
    pub fn runs(self, sheet: Sheet) -> u64 {
        match (self, sheet) {
            (Effort::Full, Sheet::Small) => 10,
            (Effort::Full, Sheet::Large) => 3,
            (Effort::Quick, Sheet::Small) => 3,
            (Effort::Quick, Sheet::Large) => 1,
            (Effort::Smoke, _) => 2,
        }
    }

    /// Yarns of the micro scale.
    pub fn yarns(self) -> u64 {
        if self == Effort::Smoke { 300 } else { 10_000 }
    }

    /// What is left out against the full study, in words.
    pub fn left_out(self) -> Option<String> {
        let list = |values: &[f64], all: &[f64]| {
            let missing = all.iter().filter(|value| !values.contains(value));
            missing.map(|value| value.to_string()).collect::<Vec<_>>().join(", ")
        };
        let shape = match self {
            Effort::Full => return None,
            Effort::Quick => format!("Runs on the 10 in sheet end after {LARGE_QUICK_STEPS} steps at the latest. "),
            Effort::Smoke => {
                format!(
                    "A smoke test: sheets of {SMOKE_NODES} x {SMOKE_NODES} nodes; nothing here says anything about the paper. "
                )
            }
        };
        Some(format!(
            "{shape}Left out against the full study: impact energies {} J on the 3 in sheet, velocities {} m/s on the 10 in sheet; \
             in the map of the open question energies {} J, one draw per yarn, and all washers but the first {}. Runs per point: {} instead of 10 on \
             the 3 in sheet, {} instead of 3 on the 10 in sheet.",
            list(self.energies(), &ENERGIES),
            list(self.velocities(), &VELOCITIES),
            list(self.map_energies(), &MAP_ENERGIES),
            self.washers(),
            self.runs(Sheet::Small),
            self.runs(Sheet::Large),
        ))
    }
}

/// A plain point of the 3 in sheet.
pub fn small(effort: Effort, attachment: AttachmentKind, yarn: Yarn, energy: f64) -> Point {
    let runs = effort.runs(Sheet::Small);
    Point { sheet: Sheet::Small, attachment, washer: 0, yarn, impact: Impact::Energy(energy), runs }
}

/// A point of the 10 in sheet.
pub fn large(effort: Effort, attachment: AttachmentKind, velocity: f64) -> Point {
    let impact = Impact::Velocity(velocity);
    Point {
        sheet: Sheet::Large,
        attachment,
        washer: 0,
        yarn: Yarn::Stochastic,
        impact,
        runs: effort.runs(Sheet::Large),
    }
}

/// Points of Figs 14 to 20: the 3 in sheet with one yarn.
pub fn small_points(effort: Effort, yarn: Yarn) -> Vec<Point> {
    let points = |attachment| effort.energies().iter().map(move |&energy| small(effort, attachment, yarn, energy));
    ATTACHMENTS.into_iter().flat_map(points).collect()
}

/// Points on how failure begins in mirror-symmetric clamped sheets.
pub fn mirrored_points(effort: Effort) -> Vec<Point> {
    let points = |attachment| HISTORY_ENERGIES.map(|energy| small(effort, attachment, Yarn::Symmetric, energy));
    [AttachmentKind::TwoSides, AttachmentKind::FourSides].into_iter().flat_map(points).collect()
}

/// Points of Fig 13: the 10 in sheet.
pub fn large_points(effort: Effort) -> Vec<Point> {
    let points = |attachment| effort.velocities().iter().map(move |&velocity| large(effort, attachment, velocity));
    ATTACHMENTS.into_iter().flat_map(points).collect()
}

/// Points of Figs 10 and 12: one run for each attachment.
pub fn picture_points(effort: Effort) -> Vec<Point> {
    ATTACHMENTS.map(|attachment| Point { runs: 1, ..large(effort, attachment, PICTURE_VELOCITY) }).to_vec()
}

/// Times of the pictures of a sheet, s. Those held at their corners tear later.
pub fn picture_times(effort: Effort, attachment: AttachmentKind) -> &'static [f64] {
    match (effort, attachment) {
        (Effort::Smoke, _) => &[5e-6, 10e-6, 20e-6],
        (_, AttachmentKind::FourCorners) => &[200e-6, 600e-6, 1000e-6],
        _ => &[150e-6, 250e-6, 350e-6],
    }
}

/// Impact energies of the map for the washers that are not the preset ones, J.
const OTHER_ENERGIES: [f64; 2] = [10.0, 15.0];

/// Every ensemble of the map: all energies for the preset washers, which alone are tried with one draw per yarn too; the two
/// energies about the limit for the others.
pub fn map_points(effort: Effort) -> Vec<Point> {
    let mut points = Vec::new();
    for washer in 0..effort.washers() {
        let all = effort.map_energies().iter().copied();
        let energies: Vec<f64> =
            all.filter(|energy| washer == 0 || effort != Effort::Full || OTHER_ENERGIES.contains(energy)).collect();
        for yarn in [Yarn::Stochastic, Yarn::Uniform, Yarn::Symmetric, Yarn::Woven] {
            if yarn != Yarn::Woven || (effort != Effort::Quick && washer == 0) {
                let point = |&energy| Point { washer, ..small(effort, AttachmentKind::FourCorners, yarn, energy) };
                points.extend(energies.iter().map(point));
            }
        }
    }
    points
}

/// Name of an attachment.
pub fn attachment_name(kind: AttachmentKind) -> &'static str {
    match kind {
        AttachmentKind::TwoSides => "two sides",
        AttachmentKind::FourSides => "four sides",
        AttachmentKind::FourCorners => "corners",
        AttachmentKind::Free => "free",
    }
}

impl Point {
    /// Kinetic energy at impact, J.
    pub fn energy(&self) -> f64 {
        match self.impact {
            Impact::Energy(energy) => energy,
            Impact::Velocity(velocity) => 0.5 * self.preset().projectile.mass * velocity * velocity,
        }
    }

    /// In words.
    pub fn name(&self) -> String {
        let (sheet, impact) = match (self.sheet, self.impact) {
            (Sheet::Small, Impact::Energy(energy)) => ("3 in", format!("{energy} J")),
            (Sheet::Large, Impact::Energy(energy)) => ("10 in", format!("{energy} J")),
            (Sheet::Small, Impact::Velocity(velocity)) => ("3 in", format!("{velocity} m/s")),
            (Sheet::Large, Impact::Velocity(velocity)) => ("10 in", format!("{velocity} m/s")),
        };
        let washer = if self.washer == 0 { String::new() } else { format!(", {}", WASHERS[self.washer].name) };
        format!("{sheet}, {}{washer}, {}, {impact}", attachment_name(self.attachment), self.yarn.name())
    }

    fn preset(&self) -> Scene {
        match self.sheet {
            Sheet::Small => Scene::sheet_3in_sphere(),
            Sheet::Large => Scene::sheet_10in_cylinder(),
        }
    }

    /// The scene of run k, k from 0.
    pub fn scene(&self, effort: Effort, k: u64) -> Scene {
        let mut scene = self.preset();
        scene.attachment.kind = self.attachment;
        if self.sheet == Sheet::Small {
            let washer = WASHERS[self.washer];
            (scene.attachment.disc_inset, scene.attachment.disc_radius) = (washer.inset, washer.radius);
        }
        if effort == Effort::Smoke {
            let scale = (SMOKE_NODES - 1) as f64 / (scene.sheet.nodes_x - 1) as f64;
            (scene.sheet.nodes_x, scene.sheet.nodes_y) = (SMOKE_NODES, SMOKE_NODES);
            scene.attachment.disc_inset *= scale;
            scene.attachment.disc_radius *= scale;
        }
        let speed = match self.impact {
            Impact::Energy(energy) => (2.0 * energy / scene.projectile.mass).sqrt(),
            Impact::Velocity(velocity) => velocity,
        };
        scene.projectile.velocity = [0.0, 0.0, speed];
        match self.yarn {
            Yarn::Stochastic | Yarn::Woven => scene.seed = k + 1,
            Yarn::Uniform | Yarn::Symmetric => {
                scene.yarn.stochastic = false;
                scene.projectile.velocity[2] *= 1.0 + k as f64 * 1e-12;
            }
        }
        if self.yarn == Yarn::Woven {
            scene.yarn.draw = Draw::Yarn;
        }
        if self.yarn == Yarn::Symmetric {
            scene.symmetry = Symmetry { mirror_x: true, mirror_y: true };
        }
        scene
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_is_sound() {
        for effort in [Effort::Full, Effort::Quick, Effort::Smoke] {
            for attachment in ATTACHMENTS {
                for washer in 0..effort.washers() {
                    for yarn in [Yarn::Stochastic, Yarn::Uniform, Yarn::Symmetric, Yarn::Woven] {
                        let point = Point { washer, ..small(effort, attachment, yarn, 20.0) };
                        point.scene(effort, 1).check().unwrap();
                        assert!((point.energy() - 20.0).abs() < 1e-12);
                    }
                }
                large(effort, attachment, 100.0).scene(effort, 0).check().unwrap();
            }
        }
    }

    #[test]
    fn uniform_runs_differ_in_the_last_digits_only() {
        let point = small(Effort::Full, AttachmentKind::FourCorners, Yarn::Uniform, 10.0);
        let speed = |k: u64| point.scene(Effort::Full, k).projectile.velocity[2];
        assert!(speed(1) > speed(0) && speed(9) / speed(0) - 1.0 < 1e-11);
    }
}
