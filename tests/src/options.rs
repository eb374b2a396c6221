//! Scenes of many options each, so that every pair of options that goes together is in one of them.

use crate::{as_proposed, rated, small_sheet};
use fabric_kernel::internals::random::splitmix64;
use fabric_kernel::{
    AttachmentKind, Draw, Drive, Error, Grading, Integrator, Motion, Path, RotationRule, Scene, Shape, Sim, Stack,
    StrengthDraw, Weft,
};
use std::collections::BTreeSet;

/// Sets something of a new simulation.
type Start = fn(&mut Sim<'_>) -> Result<(), Error>;

/// An option: its name, what it changes of a scene, and what a host then does before the first step.
pub struct Choice {
    /// Name.
    pub name: &'static str,
    scene: fn(&mut Scene),
    start: Option<Start>,
}

impl Choice {
    /// What it changes of a scene.
    pub fn set(&self, scene: &mut Scene) {
        (self.scene)(scene);
    }
}

const fn of(name: &'static str, scene: fn(&mut Scene)) -> Choice {
    Choice { name, scene, start: None }
}

const fn host(name: &'static str, start: fn(&mut Sim<'_>) -> Result<(), Error>) -> Choice {
    Choice { name, scene: |_| (), start: Some(start) }
}

/// Options, those that replace each other in one group.
pub const GROUPS: &[&[Choice]] = &[
    &[
        of("three plies", |s| s.stack = Stack { plies: 3, gap: 2.5e-4, turned: false }),
        of("turned plies", |s| s.stack = Stack { plies: 3, gap: 1e-4, turned: true }),
        of("bonded plies", |s| s.sheet.plies = 2),
    ],
    &[
        of("heavy back", |s| (s.stack.plies, s.back.plies, s.back.node_mass) = (3, 1, 1.7 * s.sheet.node_mass)),
        of("light back", |s| (s.stack.plies, s.back.plies, s.back.node_mass) = (3, 2, 0.6 * s.sheet.node_mass)),
    ],
    &[of("friction", |s| s.contact.friction = 0.3)],
    &[
        of("slipping clamps", |s| (s.attachment.hold, s.attachment.grip) = (400.0, 1e-3)),
        of("attachments of a strength", |s| s.attachment.strength = 2e4),
    ],
    &[of("viscosity", |s| *s = as_proposed(*s))],
    &[of("rate of strain", |s| *s = rated(*s, 1700.0))],
    &[of("slack balance", |s| s.slack_balance = true), of("theta rule", |s| s.integrator = Integrator::THETA)],
    &[
        of("drawn segments", |s| s.yarn.stochastic = true),
        of("drawn yarns", |s| (s.yarn.stochastic, s.yarn.draw) = (true, Draw::Yarn)),
    ],
    &[of("drawn strength", |s| {
        (s.yarn.strength_draw, s.yarn.weibull_shape, s.yarn.weibull_correlation) = (StrengthDraw::Weibull, 9.0, 0.25);
    })],
    &[of("crimp", |s| s.sheet.crimp = [0.004, 0.002]), of("pre-tension", |s| s.sheet.pre_strain = [0.002, 0.0])],
    &[of("unlike directions", |s| {
        let (modulus_mean, modulus_sd, critical_stretch) = (120e9, 1.5e9, 1.028);
        let [damage_slope, damage_intercept, damage_sd] = [5e-9, -350.0, 6.0];
        s.weft = Weft { modulus_mean, modulus_sd, damage_slope, damage_intercept, damage_sd, critical_stretch };
        s.sheet.yarn_area_y = 0.8 * s.sheet.yarn_area;
    })],
    &[of("unlike spacings", |s| s.sheet.spacing_y = 0.85e-3)],
    &[of("grading", |s| {
        s.sheet.grading = Grading { largest: 2, run: 1, centre: [0.0; 2], half_width: [4e-3; 2] };
    })],
    &[of("mirror", |s| s.symmetry.mirror_x = true)],
    &[
        of("two sides", |s| s.attachment.kind = AttachmentKind::TwoSides),
        of("four corners", |s| {
            s.attachment.kind = AttachmentKind::FourCorners;
            (s.attachment.disc_inset, s.attachment.disc_radius) = (1e-3, 0.9e-3);
        }),
        of("free sheet", |s| s.attachment.kind = AttachmentKind::Free),
    ],
    &[
        of("cylinder", |s| {
            let body = &mut s.projectile;
            (body.shape, body.radius, body.length) = (Shape::Cylinder, 3e-3, 7e-3);
        }),
        of("bullet", |s| {
            let body = &mut s.projectile;
            (body.shape, body.radius, body.length) = (Shape::HemisphericalCylinder, 3e-3, 8e-3);
        }),
        of("box", |s| (s.projectile.shape, s.projectile.size) = (Shape::Box, [5e-3, 4e-3, 6e-3])),
        of("sector", |s| {
            let part = &mut s.projectile.sector;
            (part.inner_radius, part.outer_radius, part.angle, part.thickness) = (2e-3, 6e-3, 1.2, 4e-3);
            s.projectile.shape = Shape::DiscSector;
        }),
    ],
    &[
        of("arc", |s| {
            s.sheet.radius = 0.03;
            s.projectile.position[2] += s.sheet.radius;
        }),
        of("ring", closed),
        of("ring on a case", |s| {
            closed(s);
            (s.casing.radius, s.casing.window_angle, s.casing.window_place) = (s.sheet.radius, [0.0, 0.9], [0.0, 2e-3]);
        }),
    ],
    // After the case, which carries the inner face.
    &[of("thick cloth", |s| {
        s.sheet.thickness = 3e-4;
        s.casing.radius -= if s.casing.radius > 0.0 { 0.5 * s.thickness() } else { 0.0 };
    })],
    &[of("tilted", |s| s.projectile.orientation = [0.96, 0.28, 0.0, 0.0])],
    &[of("askew", |s| {
        (s.projectile.velocity[0], s.projectile.angular_velocity) = (60.0, [2000.0, 1000.0, -3000.0]);
    })],
    &[of("turning by the theta rule", |s| s.rotation_rule = RotationRule::theta(0.5))],
    &[of("turned frame", |s| {
        (s.sheet.position, s.sheet.orientation) = ([0.5, -0.25, 2.0], [0.8, 0.0, 0.6, 0.0]);
        let pose = fabric_kernel::pose::Pose::of_sheet(&s.sheet);
        let body = &mut s.projectile;
        (body.position, body.velocity) = (pose.point_out(body.position), pose.vector_out(body.velocity));
    })],
    &[of("nothing watched", |s| (s.track_detachment, s.track_support) = (false, false))],
    &[
        Choice { name: "a path", scene: |s| s.drive = Drive::Prescribed, start: Some(follow) },
        host("a load", |sim| {
            let pose = fabric_kernel::pose::Pose::of_sheet(&sim.scene().sheet);
            sim.set_external_load(pose.vector_out([0.0, 0.0, 300.0]), [0.0; 3])
        }),
    ],
    &[
        host("given motion", |sim| {
            let mut x = vec![0.0; 3 * sim.layout().nodes()];
            sim.copy_positions(&mut x)?;
            let middle = sim.scene().sheet.position;
            x.iter_mut().enumerate().for_each(|(k, x)| *x += 1e-3 * (*x - middle[k % 3]));
            sim.set_motion(&x, &vec![0.0; x.len()])
        }),
        host("damage beforehand", |sim| {
            let stretch = |number: usize| if number.is_multiple_of(3) { 1.031 } else { 1.0 };
            sim.set_largest_stretch(&(0..sim.layout().segments()).map(stretch).collect::<Vec<_>>())
        }),
    ],
];

/// A ring, which is hit from outside.
fn closed(scene: &mut Scene) {
    scene.sheet.closed = true;
    scene.sheet.radius = scene.closed_radius();
    scene.projectile.position[2] = scene.sheet.radius - scene.projectile.position[2];
    scene.projectile.velocity[2] = -scene.projectile.velocity[2];
}

/// Down while it turns, for 300 steps.
fn follow(sim: &mut Sim<'_>) -> Result<(), Error> {
    let (now, time) = (sim.projectile()?, 300.0 * sim.step_limits().dt);
    let position = [0, 1, 2].map(|k| now.position[k] + 0.9 * time * now.velocity[k]);
    let turned = fabric_kernel::pose::normalised([0, 1, 2, 3].map(|k| now.orientation[k] + [0.0, 0.02, 0.0, 0.01][k]));
    let orientation = fabric_kernel::pose::components(&turned);
    let end = Motion { position, velocity: now.velocity.map(|v| 0.8 * v), orientation, angular_velocity: [0.0; 3] };
    sim.follow(&Path { first: 0, steps: 300, end }, 0)
}

/// A scene with options, each given by its group and its place there, the groups in order.
#[derive(Clone, Debug, Default)]
pub struct Mix {
    options: BTreeSet<[usize; 2]>,
    depth: f64,
}

impl Mix {
    fn choices(&self) -> impl Iterator<Item = &'static Choice> {
        self.options.iter().map(|&[group, k]| &GROUPS[group][k])
    }

    /// Names of its options.
    pub fn names(&self) -> Vec<&'static str> {
        self.choices().map(|choice| choice.name).collect()
    }

    /// The scene: a sphere, or what else has been chosen, before a small sheet of 19 x 17 nodes.
    pub fn scene(&self) -> Scene {
        let mut scene = small_sheet(19, 250.0);
        scene.sheet.nodes_y = 17;
        (scene.projectile.radius, scene.projectile.position[2]) = (3e-3, -self.depth);
        self.choices().for_each(|choice| choice.set(&mut scene));
        scene
    }

    /// What the host does before the first step.
    ///
    /// # Errors
    /// What the kernel refuses.
    pub fn start(&self, sim: &mut Sim<'_>) -> Result<(), Error> {
        self.choices().filter_map(|choice| choice.start).try_for_each(|start| start(sim))
    }

    /// Whether the kernel takes it.
    fn goes(&self) -> bool {
        let scene = self.scene();
        let Ok(layout) = fabric_kernel::Layout::of(&scene) else { return false };
        let mut memory = vec![fabric_kernel::CacheLine::ZERO; layout.lines()];
        Sim::new(&scene, &mut memory).is_ok_and(|mut sim| self.start(&mut sim).is_ok())
    }

    fn with(&self, option: [usize; 2]) -> Option<Mix> {
        let free = self.options.iter().all(|other| other[0] != option[0]);
        let options = self.options.iter().copied().chain([option]).collect();
        Some(Mix { options, ..*self }).filter(|mix| free && mix.goes())
    }

    /// With the projectile as near to the sheet as it may start.
    fn touching(&self) -> Mix {
        let (mut near, mut far) = (0.0, self.depth);
        while far - near > 1e-6 {
            let mix = Mix { depth: 0.5 * (near + far), ..self.clone() };
            *(if mix.goes() { &mut far } else { &mut near }) = mix.depth;
        }
        Mix { depth: far, ..self.clone() }
    }

    /// The pairs of its options.
    pub fn pairs(&self) -> impl Iterator<Item = [[usize; 2]; 2]> + '_ {
        self.options.iter().flat_map(|&a| self.options.range(a..).skip(1).map(move |&b| [a, b]))
    }
}

/// Mixes with every pair of options that goes together, and the names of the pairs that do not.
pub fn mixes() -> (Vec<Mix>, Vec<[&'static str; 2]>) {
    let all: Vec<_> = GROUPS.iter().enumerate().flat_map(|(g, group)| (0..group.len()).map(move |k| [g, k])).collect();
    let nothing = Mix { depth: 0.01, ..Mix::default() };
    let pair = |[a, b]: [[usize; 2]; 2]| nothing.with(a).and_then(|mix| mix.with(b));
    let pairs = all.iter().flat_map(|&a| all.iter().map(move |&b| [a, b])).filter(|[a, b]| a[0] < b[0]);
    let (open, apart): (Vec<_>, Vec<_>) = pairs.partition(|&ab| pair(ab).is_some());
    let mut open = BTreeSet::from_iter(open);
    let (mut mixes, mut draws) = (Vec::new(), 0);
    let mut draw = |below: usize| {
        draws += 1;
        (splitmix64(draws) % below as u64) as usize
    };
    while let Some(mut mix) = open.first().and_then(|&ab| pair(ab)) {
        // Then others in any order, as long as they go with all so far: few or many.
        let (mut others, keep) = (all.clone(), 1 + draw(4));
        while !others.is_empty() {
            let option = others.swap_remove(draw(others.len()));
            mix = if draw(4) < keep { mix.with(option).unwrap_or(mix) } else { mix };
        }
        mix.pairs().for_each(|ab| _ = open.remove(&ab));
        mixes.push(mix.touching());
    }
    // A third option may let two others go together.
    let held: BTreeSet<_> = mixes.iter().flat_map(Mix::pairs).collect();
    let name = |[group, k]: [usize; 2]| GROUPS[group][k].name;
    (mixes, apart.into_iter().filter(|ab| !held.contains(ab)).map(|ab| ab.map(name)).collect())
}
