//! The scene: plain data that says what is simulated. Defaults come from functions; [`Scene::check`] names the first bad field.
//!
//! All numbers are SI. Vectors of the projectile and of the sheet's pose are in the host's frame; the sheet's own frame has
//! its nodes in the plane z = 0, rows along x. Quaternions are scalar first and turn body vectors into world vectors.

use crate::error::{Code, Error};
use crate::math;
use crate::planes::AT_REST;
use crate::random::{self, Purpose};
use crate::shape::{self, Solid};
use crate::weave;
use crate::yarn::{DamageLaw, Segment};

/// Rest length of a segment in the paper: 35 yarns per inch, m.
pub const PAPER_SPACING: f64 = 0.0254 / 35.0;
/// What counts as rest must be slower than this, m/s; a step so short that it is not is refused.
const SLOWEST_MOTION: f64 = 1e-30;
/// Largest mass of a node m, kg, m h/dt, N s, and m (h/dt)^2, J, and largest k dt^2/m: within these all that a step makes of a
/// state that is not lost are numbers, and so are its momentum and energy.
const LARGEST_UNIT: f64 = 1e90;
const LARGEST_STIFFNESS: f64 = 1e6;

/// The grid of nodes and its mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheet {
    /// Nodes along x, at least 2.
    pub nodes_x: u32,
    /// Nodes along y, at least 2.
    pub nodes_y: u32,
    /// Node spacing = rest length of a segment, m, > 0.
    pub spacing: f64,
    /// Mass of one node of one ply, kg, > 0; the same for every node.
    pub node_mass: f64,
    /// Cross-section of one yarn of one ply, m^2, > 0.
    pub yarn_area: f64,
    /// Number of coincident plies lumped into one network (mass and area are multiplied), 1 ..= 1000.
    pub plies: u32,
    /// Origin of the sheet's frame in the host's frame, m.
    pub position: [f64; 3],
    /// Orientation of the sheet's frame in the host's frame, unit quaternion, scalar first.
    pub orientation: [f64; 4],
}

/// Which nodes are fixed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum AttachmentKind {
    /// The first and last column (x = -a and x = +a).
    TwoSides = 0,
    /// The whole edge.
    FourSides = 1,
    /// Discs near the four corners.
    FourCorners = 2,
    /// No node: a free sheet.
    Free = 3,
}

/// How the sheet is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attachment {
    /// Which nodes are fixed.
    pub kind: AttachmentKind,
    /// Four corners: distance c of a disc's centre from both edges, m, >= 0.
    pub disc_inset: f64,
    /// Four corners: radius r of the discs, m, > 0, and such that a disc holds a node.
    pub disc_radius: f64,
}

/// The yarn law and its scatter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Yarn {
    /// Mean Young's modulus of a segment, Pa, > 0.
    pub modulus_mean: f64,
    /// Standard deviation of the modulus, Pa, >= 0 (stochastic yarn only).
    pub modulus_sd: f64,
    /// Slope of the damage rate over the modulus, 1/Pa.
    pub damage_slope: f64,
    /// Damage rate at zero modulus (the line lambda = slope E + intercept), dimensionless.
    pub damage_intercept: f64,
    /// Standard deviation of the damage rate about that line, >= 0 (stochastic yarn only).
    pub damage_sd: f64,
    /// Critical stretch U_c, > 1.
    pub critical_stretch: f64,
    /// Factor A of the damage law, > 0, with A (1 - B) in (0, 1].
    pub damage_a: f64,
    /// Offset B of the damage law, < 1.
    pub damage_b: f64,
    /// alpha at or below this becomes exactly 0, in [0, 1).
    pub alpha_fail: f64,
    /// true: modulus and damage rate are drawn; false: all segments take the mean.
    pub stochastic: bool,
    /// What gets a draw of its own (stochastic yarn only).
    pub draw: Draw,
}

/// What gets a draw of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Draw {
    /// Every segment (the paper).
    Segment = 0,
    /// Every woven yarn: all segments of a row, or of a column, are alike.
    Yarn = 1,
}

/// Mirror planes through the middle of the sheet. Only the part at x <= 0, y <= 0 is modelled then; sums, energies and
/// counts of segments stay those of the whole sheet, read-outs of nodes and segments cover the part. For uniform yarn, a
/// free projectile, and a hit that the planes leave as it is: centred on each of them and not tilted across it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Symmetry {
    /// The plane x = 0.
    pub mirror_x: bool,
    /// The plane y = 0.
    pub mirror_y: bool,
}

/// The projectile's form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Shape {
    /// A sphere of `radius`; feels no torque.
    Sphere = 0,
    /// A flat-ended cylinder of `radius` and `length` along its body z axis.
    Cylinder = 1,
    /// A cylinder of `radius` and total `length` with a hemisphere at its body +z end and a flat at the other.
    HemisphericalCylinder = 2,
    /// A box of edge lengths `size` along the body axes.
    Box = 3,
    /// A convex polyhedron: `faces` and `moments`. See [`crate::prism`] for prisms and disc sectors.
    Polyhedron = 4,
}

/// Largest number of faces of a polyhedron.
pub const MAX_FACES: usize = 16;

/// The faces of a convex polyhedron {x : n_k.x <= b_k for all k}, in body axes, from the centre of mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Faces {
    /// Number of faces, 4 ..= [`MAX_FACES`] for a polyhedron.
    pub count: u32,
    /// Of each face the outward unit normal (3) and its distance b from the centre of mass, m, > 0. Beyond `count` not read.
    pub planes: [[f64; 4]; MAX_FACES],
}

impl Faces {
    /// No faces: what the other shapes carry.
    pub const NONE: Faces = Faces { count: 0, planes: [[0.0; 4]; MAX_FACES] };

    /// These faces. Of more than [`MAX_FACES`] the rest is left out and `count` says so, which [`Scene::check`] refuses.
    pub fn of(planes: &[[f64; 4]]) -> Faces {
        let mut faces = Faces { count: u32::try_from(planes.len()).unwrap_or(u32::MAX), ..Faces::NONE };
        faces.planes.iter_mut().zip(planes).for_each(|(place, plane)| *place = *plane);
        faces
    }

    /// The faces in use.
    pub fn in_use(&self) -> &[[f64; 4]] {
        self.planes.get(..self.count as usize).unwrap_or(&self.planes)
    }
}

/// The rigid projectile and its motion at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projectile {
    /// Form.
    pub shape: Shape,
    /// Radius, m, >= the node spacing (not read for a box or a polyhedron).
    pub radius: f64,
    /// Length along the axis, m, at least two node spacings, and at least the radius with a hemispherical end (read for
    /// the two cylinders only).
    pub length: f64,
    /// Edge lengths of a box along the body axes, m, each at least two node spacings (read for a box only).
    pub size: [f64; 3],
    /// Faces of a polyhedron, none nearer to the centre of mass than the node spacing (read for a polyhedron only).
    pub faces: Faces,
    /// Principal moments of inertia of a polyhedron about its centre of mass, kg m^2, > 0, none greater than the other two
    /// together; the body axes are the principal axes (read for a polyhedron of known mass only; other shapes are homogeneous).
    pub moments: [f64; 3],
    /// Mass, kg, at least one node's mass. With [`Drive::Prescribed`] 0 means "not known": the body is moved by the host.
    pub mass: f64,
    /// Centre of mass at the start, m.
    pub position: [f64; 3],
    /// Velocity at the start, m/s.
    pub velocity: [f64; 3],
    /// Orientation at the start, unit quaternion, scalar first.
    pub orientation: [f64; 4],
    /// Angular velocity at the start, rad/s, in the host's axes.
    pub angular_velocity: [f64; 3],
}

/// Who moves the projectile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Drive {
    /// The kernel integrates the rigid body under contact and external load.
    Free = 0,
    /// The host prescribes the pose ([`crate::path::Path`]); without a path the body coasts.
    Prescribed = 1,
}

/// The time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeStep {
    /// A fraction of the drawn sheet's dt_crit, in (0, 0.5].
    Fraction(f64),
    /// Seconds, > 0, at most 0.5 dt_crit.
    Seconds(f64),
}

/// How the nodes are stepped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Integrator {
    /// Velocity Verlet, explicit: the default.
    Verlet,
    /// The paper's theta rule by fixed-point iteration: the reference method, several times the cost (feature `implicit`).
    Theta(ThetaRule),
}

/// Settings of the theta rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThetaRule {
    /// Weight of the forces at the step's end, in [0.5, 1]; 0.5 is of second order.
    pub theta: f64,
    /// The iteration ends when no node moves by more than this, in node spacings, > 0.
    pub tolerance: f64,
    /// Iterations after which a step fails, >= 1.
    pub max_iterations: u32,
}

impl Default for ThetaRule {
    fn default() -> ThetaRule {
        ThetaRule { theta: 0.5, tolerance: 1e-10, max_iterations: 500 }
    }
}

/// What the step does once a segment has failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum StepAfterFailure {
    /// It stays.
    Keep = 0,
    /// From the end of the step in which the first segment fails every step is taken as two halves (velocity Verlet only).
    /// Step count, time, paths, outcomes and force windows go on counting whole steps.
    Half = 1,
}

/// How the projectile turns between impulses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RotationRule {
    /// Implicit midpoint rule: keeps kinetic energy and angular momentum.
    Midpoint,
    /// The paper's theta rule (its equations 14-16) with this theta, in [0.5, 1]; does not conserve (feature `implicit`).
    Theta(f64),
}

/// Whether the step is checked against the limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum StepCheck {
    /// Refuse a step above 0.5 dt_crit.
    Refuse = 0,
    /// No check: for stability studies only. Results above the limit are plausible garbage.
    None = 1,
}

/// Everything that defines a simulation. Obtain one from [`Scene::sheet_3in_sphere`] or [`Scene::sheet_10in_cylinder`] and change fields.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene {
    /// Grid and mass.
    pub sheet: Sheet,
    /// Mirror planes.
    pub symmetry: Symmetry,
    /// Supports.
    pub attachment: Attachment,
    /// Yarn law.
    pub yarn: Yarn,
    /// Projectile.
    pub projectile: Projectile,
    /// Who moves the projectile.
    pub drive: Drive,
    /// Seed of the stochastic yarn.
    pub seed: u64,
    /// Time step; constant for the life of a simulation.
    pub time_step: TimeStep,
    /// Whether the time step is checked.
    pub step_check: StepCheck,
    /// How the nodes are stepped.
    pub integrator: Integrator,
    /// What the step does once a segment has failed.
    pub step_after_failure: StepAfterFailure,
    /// The toe against the energy creep of slack sheets: Green-Lagrange strain over which the stiffness of a segment sets in
    /// once it has been slack after the first failure; in [0.005, 0.05] and not beyond that of U_c, 0.02 if in doubt. 0 = no
    /// toe: the stiffness jumps (velocity Verlet only). See docs/model.md, "The toe".
    pub slack_toe: f64,
    /// How the projectile turns.
    pub rotation_rule: RotationRule,
    /// Window of the peak force, s, > 0; rounded to whole steps, at least one. Until the first window is full the peak force is
    /// the mean over the time elapsed.
    pub force_window: f64,
    /// Watch whether the nodes in contact are still connected to a support (4 bytes per node). Without it there is no outcome
    /// "detached", and a body that carries torn cloth is never said to have exited.
    pub track_detachment: bool,
    /// Sum the impulses on the supports; the momentum residual needs them.
    pub track_support: bool,
    /// Greatest number of nodes closer than a spacing to the projectile at once, each of which takes 116 bytes (124 with the
    /// theta rule); more is the failure [`crate::Failure::ContactCapacity`]. 0 = every node modelled, which cannot be exceeded.
    /// A smaller number is for tight memory: docs/embedding.md, "Memory", says how to choose it.
    pub contact_capacity: u32,
}

/// Largest fraction of dt_crit that is accepted.
pub const STEP_MAX_FRACTION: f64 = 0.5;
/// sqrt(3/4): what a toe leaves of the largest step, because its tangent modulus is at most 4/3 E.
pub const STEP_WITH_TOE: f64 = 0.866_025_403_784_438_6;
/// Narrowest and widest toe.
pub const TOE_RANGE: [f64; 2] = [0.005, 0.05];
/// Default fraction of dt_crit.
pub const STEP_DEFAULT_FRACTION: f64 = 0.4;
/// Smallest damage rate: below it the tangent stiffness would peak beyond U_c.
pub const DAMAGE_RATE_MIN: f64 = 3.0;

/// The limits of the time step, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepLimits {
    /// The step in use.
    pub dt: f64,
    /// 2/omega_max of the taut sheet at the critical stretch, with the stiffest segment drawn.
    pub dt_crit: f64,
    /// Largest accepted step: 0.5 dt_crit, with a toe 0.5 sqrt(3/4) dt_crit.
    pub step_max: f64,
}

impl Scene {
    /// The paper's 3 in sheet: 105 x 105 nodes, four sides held, the 8.4 g steel sphere at its centre, 100 m/s along +z.
    pub const fn sheet_3in_sphere() -> Scene {
        let radius = 6.35e-3;
        Scene {
            sheet: Sheet {
                nodes_x: 105,
                nodes_y: 105,
                spacing: PAPER_SPACING,
                node_mass: 6.52e-8,
                yarn_area: 1.075e-7,
                plies: 1,
                position: [0.0; 3],
                orientation: [1.0, 0.0, 0.0, 0.0],
            },
            symmetry: Symmetry { mirror_x: false, mirror_y: false },
            attachment: Attachment { kind: AttachmentKind::FourSides, disc_inset: 7.62e-3, disc_radius: 5.715e-3 },
            yarn: Yarn {
                modulus_mean: 140.21e9,
                modulus_sd: 2.04e9,
                damage_slope: 7.91e-9,
                damage_intercept: -878.46,
                damage_sd: 8.35,
                critical_stretch: 1.03,
                damage_a: 1.0,
                damage_b: 0.0,
                alpha_fail: 0.01,
                stochastic: true,
                draw: Draw::Segment,
            },
            projectile: Projectile {
                shape: Shape::Sphere,
                radius,
                length: 2.0 * radius,
                size: [2.0 * radius; 3],
                faces: Faces::NONE,
                moments: [0.0; 3],
                mass: 8.4e-3,
                position: [0.0, 0.0, -radius],
                velocity: [0.0, 0.0, 100.0],
                orientation: [1.0, 0.0, 0.0, 0.0],
                angular_velocity: [0.0; 3],
            },
            drive: Drive::Free,
            seed: 1,
            time_step: TimeStep::Fraction(STEP_DEFAULT_FRACTION),
            step_check: StepCheck::Refuse,
            integrator: Integrator::Verlet,
            step_after_failure: StepAfterFailure::Keep,
            slack_toe: 0.0,
            rotation_rule: RotationRule::Midpoint,
            force_window: 1e-6,
            track_detachment: true,
            track_support: true,
            contact_capacity: 0,
        }
    }

    /// The paper's 10 in sheet: 350 x 350 nodes, two sides held, the 37 g flat-ended cylinder at its centre, 100 m/s along +z.
    pub const fn sheet_10in_cylinder() -> Scene {
        let small = Scene::sheet_3in_sphere();
        let length = 0.0381;
        Scene {
            sheet: Sheet { nodes_x: 350, nodes_y: 350, ..small.sheet },
            attachment: Attachment { kind: AttachmentKind::TwoSides, disc_inset: 25.4e-3, disc_radius: 19.05e-3 },
            projectile: Projectile {
                shape: Shape::Cylinder,
                length,
                mass: 0.037,
                position: [0.0, 0.0, -0.5 * length],
                ..small.projectile
            },
            ..small
        }
    }

    /// The damage law's shared constants.
    pub fn damage_law(&self) -> DamageLaw {
        DamageLaw {
            critical_stretch: self.yarn.critical_stretch,
            a: self.yarn.damage_a,
            b: self.yarn.damage_b,
            alpha_fail: self.yarn.alpha_fail,
        }
    }

    /// Mass of one node of all plies together, kg.
    pub fn lumped_mass(&self) -> f64 {
        self.sheet.node_mass * self.sheet.plies as f64
    }

    /// Cross-section of one yarn of all plies together, m^2.
    pub fn lumped_area(&self) -> f64 {
        self.sheet.yarn_area * self.sheet.plies as f64
    }

    /// Half edge lengths of the sheet along x and y, m.
    pub fn half_size(&self) -> [f64; 2] {
        [
            0.5 * (self.sheet.nodes_x as f64 - 1.0) * self.sheet.spacing,
            0.5 * (self.sheet.nodes_y as f64 - 1.0) * self.sheet.spacing,
        ]
    }

    /// The segment all others vary about: mean modulus and the damage rate on its line.
    pub fn mean_segment(&self) -> Segment {
        let modulus = self.yarn.modulus_mean;
        Segment { modulus, damage_rate: self.yarn.damage_slope * modulus + self.yarn.damage_intercept }
    }

    /// (M6) Modulus and damage rate of one segment, by its number (horizontal segments first, row by row, then vertical).
    /// A modulus <= 0 or a rate below 3 or beyond all numbers is drawn again; after 1000 refusals the scatter makes no sense.
    pub fn draw_segment(&self, number: u64) -> Result<Segment, Error> {
        if !self.yarn.stochastic {
            return Ok(self.mean_segment());
        }
        let number = match self.yarn.draw {
            Draw::Segment => number,
            Draw::Yarn => weave::yarn_of_segment(self.sheet.nodes_x, self.sheet.nodes_y, number),
        };
        for retry in 0..1000 {
            let g1 = random::normal(self.seed, number, Purpose::Modulus, retry);
            let g2 = random::normal(self.seed, number, Purpose::DamageRate, retry);
            let modulus = self.yarn.modulus_mean + self.yarn.modulus_sd * g1;
            let damage_rate = self.yarn.damage_slope * modulus + self.yarn.damage_intercept + self.yarn.damage_sd * g2;
            if modulus > 0.0 && damage_rate >= DAMAGE_RATE_MIN && damage_rate.is_finite() {
                return Ok(Segment { modulus, damage_rate });
            }
        }
        Err(Error::new(Code::DamageRateTooSmall, "yarn.damage_sd", self.yarn.damage_sd, DAMAGE_RATE_MIN))
    }

    /// Number of segments: (nx - 1) ny + nx (ny - 1).
    pub fn segments(&self) -> u64 {
        let (nx, ny) = (self.sheet.nodes_x as u64, self.sheet.nodes_y as u64);
        (nx - 1) * ny + nx * (ny - 1)
    }

    /// The step in use and its limits. Draws every segment of a stochastic sheet to find the stiffest.
    ///
    /// (M11) omega^2 = (k/m) [2 (3 U_c^2 - 1) + 2 (U_c^2 - 1)] with k = E A_0/h: the bound of a taut plane net at U_c, where the
    /// tangent stiffness is largest; dt_crit = 2/omega.
    pub fn step_limits(&self) -> Result<StepLimits, Error> {
        self.check()?;
        let mut stiffest = self.yarn.modulus_mean;
        if self.yarn.stochastic {
            stiffest = 0.0;
            for number in 0..self.segments() {
                let modulus = self.draw_segment(number)?.modulus;
                if modulus > stiffest {
                    stiffest = modulus;
                }
            }
        }
        let u2 = self.yarn.critical_stretch * self.yarn.critical_stretch;
        let stiffness = stiffest * self.sheet.yarn_area / self.sheet.spacing;
        let omega2 = stiffness / self.sheet.node_mass * (2.0 * (3.0 * u2 - 1.0) + 2.0 * (u2 - 1.0));
        let dt_crit = 2.0 / math::sqrt(omega2);
        if !dt_crit.is_normal() {
            return Err(Error::new(Code::StepLimitUnusable, "sheet.node_mass", self.sheet.node_mass, 0.0));
        }
        let step_max = self.step_max_fraction() * dt_crit;
        let dt = match self.time_step {
            TimeStep::Fraction(fraction) => fraction * dt_crit,
            TimeStep::Seconds(dt) => dt,
        };
        if self.step_check == StepCheck::Refuse && dt > step_max {
            return Err(Error::new(Code::StepTooLarge, "dt", dt, step_max));
        }
        let speed = self.sheet.spacing / dt;
        let units = [self.lumped_mass(), self.lumped_mass() * speed, self.lumped_mass() * speed * speed];
        let unit_stiffness = dt * dt * stiffness / self.sheet.node_mass;
        let usable = units.iter().all(|unit| unit.is_normal() && *unit <= LARGEST_UNIT)
            && unit_stiffness.is_normal()
            && unit_stiffness <= LARGEST_STIFFNESS
            && AT_REST * speed <= SLOWEST_MOTION;
        if !usable {
            return Err(Error::new(Code::StepLimitUnusable, "dt", dt, step_max));
        }
        Ok(StepLimits { dt, dt_crit, step_max })
    }

    /// Checks every field by itself and against the others, in the order of declaration; the first bad one is named.
    /// The time step against dt_crit is checked by [`Scene::step_limits`].
    pub fn check(&self) -> Result<(), Error> {
        self.check_sheet()?;
        self.check_yarn()?;
        self.check_projectile()?;
        self.check_attachment()?;
        self.check_symmetry()?;
        match self.time_step {
            TimeStep::Seconds(dt) => positive("dt", dt)?,
            TimeStep::Fraction(fraction) => {
                positive("step_fraction", fraction)?;
                if self.step_check == StepCheck::Refuse && fraction > self.step_max_fraction() {
                    return Err(Error::new(Code::OutOfRange, "step_fraction", fraction, self.step_max_fraction()));
                }
            }
        }
        self.check_integrator()?;
        self.check_toe()?;
        positive("force_window", self.force_window)
    }

    /// Largest accepted fraction of dt_crit.
    pub fn step_max_fraction(&self) -> f64 {
        if self.slack_toe > 0.0 { STEP_WITH_TOE * STEP_MAX_FRACTION } else { STEP_MAX_FRACTION }
    }

    fn check_toe(&self) -> Result<(), Error> {
        let toe = self.slack_toe;
        finite("slack_toe", toe)?;
        let [narrowest, widest] = TOE_RANGE;
        let critical = 0.5 * self.damage_law().critical_twice_strain();
        let widest = if critical < widest { critical } else { widest };
        let limit = if self.integrator != Integrator::Verlet {
            0.0
        } else if toe < narrowest {
            narrowest
        } else {
            widest
        };
        let verlet = self.integrator == Integrator::Verlet;
        let sound = toe == 0.0 || (verlet && toe >= narrowest && toe <= widest);
        if sound { Ok(()) } else { Err(Error::new(Code::OutOfRange, "slack_toe", toe, limit)) }
    }

    fn check_integrator(&self) -> Result<(), Error> {
        let built = |field| if cfg!(feature = "implicit") { Ok(()) } else { Err(Error::plain(Code::NotBuilt, field)) };
        let weight = |field, theta: f64| {
            finite(field, theta)?;
            let limit = if theta < 0.5 { 0.5 } else { 1.0 };
            if (0.5..=1.0).contains(&theta) { Ok(()) } else { Err(Error::new(Code::OutOfRange, field, theta, limit)) }
        };
        if let Integrator::Theta(rule) = self.integrator {
            built("integrator")?;
            weight("integrator.theta", rule.theta)?;
            positive("integrator.tolerance", rule.tolerance)?;
            if self.step_after_failure != StepAfterFailure::Keep {
                return Err(Error::plain(Code::OutOfRange, "step_after_failure"));
            }
            if rule.max_iterations < 1 {
                return Err(Error::new(Code::OutOfRange, "integrator.max_iterations", 0.0, 1.0));
            }
        }
        if let RotationRule::Theta(theta) = self.rotation_rule {
            built("rotation_rule")?;
            weight("rotation_rule.theta", theta)?;
        }
        Ok(())
    }

    fn check_sheet(&self) -> Result<(), Error> {
        let sheet = &self.sheet;
        for (field, nodes) in [("sheet.nodes_x", sheet.nodes_x), ("sheet.nodes_y", sheet.nodes_y)] {
            if nodes < 2 {
                return Err(Error::new(Code::OutOfRange, field, nodes as f64, 2.0));
            }
            if nodes > MAX_NODES_PER_SIDE {
                return Err(Error::new(Code::TooManyNodes, field, nodes as f64, MAX_NODES_PER_SIDE as f64));
            }
        }
        positive("sheet.spacing", sheet.spacing)?;
        positive("sheet.node_mass", sheet.node_mass)?;
        positive("sheet.yarn_area", sheet.yarn_area)?;
        if sheet.plies < 1 || sheet.plies > 1000 {
            return Err(Error::new(Code::OutOfRange, "sheet.plies", sheet.plies as f64, 1000.0));
        }
        finite3("sheet.position", sheet.position)?;
        unit_quaternion("sheet.orientation", sheet.orientation)
    }

    fn check_yarn(&self) -> Result<(), Error> {
        let yarn = &self.yarn;
        positive("yarn.modulus_mean", yarn.modulus_mean)?;
        not_negative("yarn.modulus_sd", yarn.modulus_sd)?;
        finite("yarn.damage_slope", yarn.damage_slope)?;
        finite("yarn.damage_intercept", yarn.damage_intercept)?;
        not_negative("yarn.damage_sd", yarn.damage_sd)?;
        finite("yarn.critical_stretch", yarn.critical_stretch)?;
        if yarn.critical_stretch <= 1.0 || yarn.critical_stretch > 2.0 {
            let limit = if yarn.critical_stretch > 2.0 { 2.0 } else { 1.0 };
            return Err(Error::new(Code::OutOfRange, "yarn.critical_stretch", yarn.critical_stretch, limit));
        }
        positive("yarn.damage_a", yarn.damage_a)?;
        finite("yarn.damage_b", yarn.damage_b)?;
        if yarn.damage_b >= 1.0 {
            return Err(Error::new(Code::OutOfRange, "yarn.damage_b", yarn.damage_b, 1.0));
        }
        let first = yarn.damage_a * (1.0 - yarn.damage_b);
        // One rounding above 1 is what A = 1/(1 - B) gives.
        if !(first > 0.0 && first <= 1.0 + 4.0 * f64::EPSILON) {
            return Err(Error::new(Code::OutOfRange, "yarn.damage_a", yarn.damage_a, 1.0 / (1.0 - yarn.damage_b)));
        }
        finite("yarn.alpha_fail", yarn.alpha_fail)?;
        if yarn.alpha_fail < 0.0 || yarn.alpha_fail >= 1.0 {
            return Err(Error::new(Code::OutOfRange, "yarn.alpha_fail", yarn.alpha_fail, 1.0));
        }
        let rate = self.mean_segment().damage_rate;
        finite("yarn.damage_slope", rate)?;
        if rate < DAMAGE_RATE_MIN {
            return Err(Error::new(Code::DamageRateTooSmall, "yarn.damage_intercept", rate, DAMAGE_RATE_MIN));
        }
        Ok(())
    }

    fn check_projectile(&self) -> Result<(), Error> {
        let body = &self.projectile;
        shape::check(body, self.sheet.spacing)?;
        finite("projectile.mass", body.mass)?;
        if !(self.drive == Drive::Prescribed && body.mass == 0.0) {
            positive("projectile.mass", body.mass)?;
            if body.mass < self.lumped_mass() {
                return Err(Error::new(Code::ProjectileTooLight, "projectile.mass", body.mass, self.lumped_mass()));
            }
        }
        finite3("projectile.position", body.position)?;
        finite3("projectile.velocity", body.velocity)?;
        unit_quaternion("projectile.orientation", body.orientation)?;
        finite3("projectile.angular_velocity", body.angular_velocity)
    }

    /// Mirror planes need yarn that is alike everywhere and a body that contact alone moves. Whether the hit is centred is
    /// checked where the start motion is known in the sheet's frame (`symmetry.rs`).
    fn check_symmetry(&self) -> Result<(), Error> {
        let Symmetry { mirror_x, mirror_y } = self.symmetry;
        if !mirror_x && !mirror_y {
            return Ok(());
        }
        if self.yarn.stochastic {
            return Err(Error::plain(Code::NotSymmetric, "yarn.stochastic"));
        }
        if self.drive != Drive::Free {
            return Err(Error::plain(Code::NotSymmetric, "drive"));
        }
        Ok(())
    }

    #[inline(never)] // Its solid must not add to the stack of what is checked next.
    fn check_attachment(&self) -> Result<(), Error> {
        if self.attachment.kind != AttachmentKind::FourCorners {
            return Ok(());
        }
        let (inset, radius) = (self.attachment.disc_inset, self.attachment.disc_radius);
        not_negative("attachment.disc_inset", inset)?;
        positive("attachment.disc_radius", radius)?;
        let centre = weave::disc_centre(self);
        if centre[0] <= radius || centre[1] <= radius {
            let limit = if centre[0] < centre[1] { centre[0] } else { centre[1] };
            return Err(Error::new(Code::DiscsOverlap, "attachment.disc_radius", radius, limit));
        }
        // The discs are clear of the projectile's bounding circle about the sheet's centre line where it starts.
        let pose = crate::pose::Pose::of_sheet(&self.sheet);
        let offset = pose.point_in(self.projectile.position);
        let orientation = crate::pose::normalised(pose.orientation_in(self.projectile.orientation));
        let reach = Solid::of(&self.projectile).reach_in_plane(&orientation);
        for (sx, sy) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
            let gap = math::length([offset[0] - sx * centre[0], offset[1] - sy * centre[1], 0.0]) - reach;
            if gap <= radius {
                return Err(Error::new(Code::DiscTouchesProjectile, "attachment.disc_radius", radius, gap));
            }
        }
        let nearest2 = weave::disc_to_nearest_node2(self);
        if nearest2 > radius * radius {
            return Err(Error::new(Code::HoldsNothing, "attachment.disc_radius", radius, math::sqrt(nearest2)));
        }
        Ok(())
    }
}

/// Largest number of nodes along one side.
pub const MAX_NODES_PER_SIDE: u32 = 1 << 20;

/// Refuses NaN and infinities.
pub(crate) fn finite(field: &'static str, value: f64) -> Result<(), Error> {
    if value.is_finite() { Ok(()) } else { Err(Error::new(Code::NotFinite, field, value, 0.0)) }
}

/// Refuses a vector with a NaN or infinite component.
pub(crate) fn finite3(field: &'static str, v: [f64; 3]) -> Result<(), Error> {
    v.iter().try_for_each(|&x| finite(field, x))
}

/// Refuses everything but finite numbers greater than zero.
pub(crate) fn positive(field: &'static str, value: f64) -> Result<(), Error> {
    finite(field, value)?;
    if value > 0.0 { Ok(()) } else { Err(Error::new(Code::NotPositive, field, value, 0.0)) }
}

fn not_negative(field: &'static str, value: f64) -> Result<(), Error> {
    finite(field, value)?;
    if value >= 0.0 { Ok(()) } else { Err(Error::new(Code::OutOfRange, field, value, 0.0)) }
}

/// Refuses a quaternion whose length differs from 1 by 1e-3 or more.
pub(crate) fn unit_quaternion(field: &'static str, q: [f64; 4]) -> Result<(), Error> {
    q.iter().try_for_each(|&x| finite(field, x))?;
    let length = math::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    let off = length - 1.0;
    if off < 1e-3 && off > -1e-3 { Ok(()) } else { Err(Error::new(Code::BadQuaternion, field, length, 1.0)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_sound() {
        for scene in [Scene::sheet_3in_sphere(), Scene::sheet_10in_cylinder()] {
            scene.check().unwrap();
            let limits = scene.step_limits().unwrap();
            assert!(limits.dt > 1.9e-8 && limits.dt < 2.12e-8);
        }
        assert_eq!(Scene::sheet_3in_sphere().segments(), 21_840);
        assert_eq!(Scene::sheet_10in_cylinder().segments(), 244_300);
    }

    #[test]
    fn uniform_step_limit() {
        let mut scene = Scene::sheet_3in_sphere();
        scene.yarn.stochastic = false;
        let limits = scene.step_limits().unwrap();
        assert!((limits.dt_crit / 5.289994e-8 - 1.0).abs() < 1e-6);
        assert!((limits.step_max / 2.644997e-8 - 1.0).abs() < 1e-6);
        scene.time_step = TimeStep::Seconds(2.7e-8);
        let error = scene.step_limits().unwrap_err();
        assert_eq!((error.code, error.field), (Code::StepTooLarge, "dt"));
        assert_eq!(error.limit, limits.step_max);
        scene.step_check = StepCheck::None;
        assert!(scene.step_limits().is_ok());
    }

    #[test]
    #[cfg(not(feature = "implicit"))]
    fn a_build_without_the_theta_rule_refuses_it() {
        let mut scene = Scene::sheet_3in_sphere();
        scene.integrator = Integrator::Theta(ThetaRule::default());
        assert_eq!(scene.check().unwrap_err(), Error::plain(Code::NotBuilt, "integrator"));
        scene.integrator = Integrator::Verlet;
        scene.rotation_rule = RotationRule::Theta(0.5);
        assert_eq!(scene.check().unwrap_err(), Error::plain(Code::NotBuilt, "rotation_rule"));
    }

    #[test]
    fn one_draw_per_yarn_makes_rows_and_columns_alike() {
        let mut scene = Scene::sheet_3in_sphere();
        scene.yarn.draw = Draw::Yarn;
        let horizontal = |i, j| scene.draw_segment(weave::horizontal_number(105, i, j)).unwrap();
        let vertical = |i, j| scene.draw_segment(weave::vertical_number(105, 105, i, j)).unwrap();
        assert_eq!(horizontal(0, 7), horizontal(103, 7));
        assert_ne!(horizontal(0, 7), horizontal(0, 8));
        assert_eq!(vertical(7, 0), vertical(7, 103));
        assert_ne!(vertical(7, 0), horizontal(0, 7));
    }

    #[test]
    fn mean_damage_rate_lies_on_the_line() {
        assert!((Scene::sheet_3in_sphere().mean_segment().damage_rate - 230.6011).abs() < 1e-9);
    }
}
