//! The rows: one for each number of [`Scene`].
//!
//! The order of the rows is the order in C and in the fingerprint. Rows of one group stand together.
//! Once there is a release, a new parameter goes to the end of the table, with a group of its own or none, so
//! that hosts compiled before it go on working; 0 has to mean that it is off, so that images still fit.

use crate::scene::features::Feature;
use crate::scene::fields::choices::*;
use crate::scene::fields::quantities::*;
use crate::scene::fields::row::{Field, Place, Range};
use crate::scene::parts::{
    CRITICAL_STRETCH_MAX, GRADING_LARGEST, MAX_FACES, MAX_PLIES, STRAIN_RATES, Scene, WEIBULL_SHAPES,
};

/// Meaning of a group of parameters, by the first part of its name.
pub const GROUPS: &[(&str, &str)] = &[
    ("sheet", "Grid of nodes, its mass and its place"),
    ("sheet.grading", "Graded network: bars that stand for several yarns, away from the hit"),
    ("stack", "Separate plies one behind the other"),
    (
        "back",
        "Another fabric of the last plies, in the same grid of nodes. The numbers are read if back.plies is not 0",
    ),
    ("attachment", "How the sheet is held"),
    ("yarn", "The yarn law and its scatter"),
    ("weft", "The yarn along y, where it is unlike that along x"),
    ("projectile", "The rigid projectile and its motion at the start, in the host's frame"),
    ("projectile.faces", "Faces of a polyhedron, in body axes"),
    ("projectile.sector", "Dimensions of a disc sector"),
    ("casing", "The rigid case under a ring"),
    ("contact", "Contact of yarn and projectile"),
    ("symmetry", "Mirror planes through the middle of the sheet; only the part at x <= 0, y <= 0 is modelled"),
    ("integrator", "How the nodes are stepped"),
    ("time_step", "The time step, constant for the life of a simulation"),
    ("rotation_rule", "How the projectile turns between impulses"),
];

const INFINITE: f64 = f64::INFINITY;

/// Elements that a scene reads of a number: all, or none.
type Read = fn(&Scene) -> usize;
const FOUR_CORNERS: Read = |s| if_so(s.attachment.kind == AttachmentKind::FourCorners);
const GRADED: Read = |s| if_so(Feature::Grading.is_in(s));
const CASED: Read = |s| if_so(s.casing.radius != 0.0);
const STACKED: Read = |s| if_so(s.stack.plies > 1);
const OWN_WEFT: Read = |s| if_so(s.weft.modulus_mean != 0.0);
const ROUND: Read =
    |s| if_so(matches!(s.projectile.shape, Shape::Sphere | Shape::Cylinder | Shape::HemisphericalCylinder));
const SECTOR: Read = |s| if_so(s.projectile.shape == Shape::DiscSector);
const DRAWN_STRENGTH: Read = |s| if_so(s.yarn.strength_draw != StrengthDraw::None);
const ON_RATE: Read = |s| if_so(Feature::Rate.is_in(s));
const THETA_RULE: Read = |s| if_so(s.integrator.kind == IntegratorKind::Theta);

/// The table.
#[rustfmt::skip]
pub const FIELDS: &[Field] = &[
    // ---- Sheet
    count("sheet.nodes_x", |s| &mut s.sheet.nodes_x, Range::Nodes, 220, "Nodes along x"),
    count("sheet.nodes_y", |s| &mut s.sheet.nodes_y, Range::Nodes, 221, "Nodes along y"),
    count("sheet.plies", |s| &mut s.sheet.plies, Range::Within(1.0, 1000.0), 225,
        "Plies sewn or bonded into one network: mass and area are multiplied. Loose plies are stack.plies"),
    real("sheet.thickness", |s| one(&mut s.sheet.thickness), &LENGTH, Range::NotNegative, 760,
        "Thickness t of a ply; n bonded ones are n t thick, at most a tenth of the sheet. The projectile touches the network, the middle of the cloth, at half of it; 0 = a surface without thickness. A projectile must start farther away"),
    real("sheet.spacing", |s| one(&mut s.sheet.spacing), &LENGTH, Range::Positive, 222,
        "Node spacing h along x, the natural length of a segment (M1) without crimp and pre-tension"),
    real("sheet.spacing_y", |s| one(&mut s.sheet.spacing_y), &LENGTH, Range::NotNegative, 620,
        "Node spacing along y, 0.1 to 10 times that along x; 0: as along x. What must exceed sheet.spacing must exceed this, too"),
    real("sheet.node_mass", |s| one(&mut s.sheet.node_mass), &MASS, Range::Positive, 223,
        "Mass of a node of one ply (M7), the same for edge nodes"),
    real("sheet.yarn_area", |s| one(&mut s.sheet.yarn_area), &AREA, Range::Positive, 224,
        "Cross-section A_0 of a yarn of one ply (M4)"),
    real("sheet.yarn_area_y", |s| one(&mut s.sheet.yarn_area_y), &AREA, Range::NotNegative, 621,
        "Cross-section of a yarn along y; 0: as along x"),
    shaped("sheet.crimp", Place::Reals(|s| &mut s.sheet.crimp, &[2]), &RATIO, Range::Within(0.0, 1.0), 622,
        "Crimp of the yarns along x and along y: natural length of a segment over the node spacing, less 1. A segment pulls only once it is taken up"),
    shaped("sheet.pre_strain", Place::Reals(|s| &mut s.sheet.pre_strain, &[2]), &RATIO, Range::NotNegative, 624,
        "Strain of the held sheet along x (two or four sides) and along y (four sides), below critical_stretch - 1 and without crimp: node spacing over the natural length of a segment, less 1. Not with a modulus sampled for every segment"),
    real("sheet.radius", |s| one(&mut s.sheet.radius), &LENGTH, Range::NotNegative, 750,
        "Radius to the nodes of a sheet curved about its y axis, which rests at (R sin a, y, R cos a) with chords of sheet.spacing (M23); 0 = flat. Separate plies lie at R + k (stack.gap + thickness). Velocity Verlet only; not with yarn.viscosity_bending, a dependence on the rate of strain, a graded network, mirror planes or four corners"),
    flag("sheet.closed", |s| &mut s.sheet.closed, 751,
        "A ring: a segment joins the last node of every row to its first. sheet.radius must be sheet.spacing/(2 sin(pi/sheet.nodes_x)) to 1e-6; two sides cannot be held"),
    vector("sheet.position", |s| &mut s.sheet.position, &POSITION, Range::Any, 230,
        "Middle of the sheet in the host's frame; of a curved one the middle of its axis"),
    quaternion("sheet.orientation", |s| &mut s.sheet.orientation, 233,
        "Unit quaternion, scalar first, that turns the sheet's axes (normal z) into the host's"),
    count("sheet.grading.largest", |s| &mut s.sheet.grading.largest, Range::Within(0.0, GRADING_LARGEST as f64), 740,
        "Most yarns that one bar stands for, and as many crossings: 2, 4, 8, 16, 32 or 64; 0 or 1 = no grading. Bars grow by factors of two away from the fine part"),
    count("sheet.grading.run", |s| &mut s.sheet.grading.run, Range::Within(1.0, 1e6), 741,
        "Bars of each size before the next. Read with grading only").read(GRADED),
    shaped("sheet.grading.centre", Place::Reals(|s| &mut s.sheet.grading.centre, &[2]), &POSITION, Range::Any, 742,
        "Middle of the fine part along x and along y in the sheet's frame, about the expected hit; 0 across a mirror plane. Read with grading only")
        .read(GRADED),
    shaped("sheet.grading.half_width", Place::Reals(|s| &mut s.sheet.grading.half_width, &[2]), &LENGTH, Range::NotNegative, 744,
        "Half the width of the fine part along x and along y. Read with grading only")
        .read(GRADED),
    // ---- Separate plies
    count("stack.plies", |s| &mut s.stack.plies, Range::Within(1.0, MAX_PLIES as f64), 720,
        "Loose plies, each a network with samples of its own, held like the first, in contact with each other; sewn ones are sheet.plies. Velocity Verlet only; not with mirror planes or a dependence on the rate of strain")
        .read(|s| if_so(s.stack.plies != 1)),
    real("stack.gap", |s| one(&mut s.stack.gap), &LENGTH, Range::NotNegative, 721,
        "Air between neighbouring plies where they rest, at most a million node spacings; 0: they lie on each other, as plies of a ring with pre-strain along x must. Read for more than one ply only")
        .read(STACKED),
    flag("stack.turned", |s| &mut s.stack.turned, 722,
        "Every other ply is turned by 90 degrees, so that its warp runs along y; the node spacings must be alike. Read for more than one ply only")
        .read(STACKED),
    // ---- The fabric of the last plies
    count("back.plies", |s| &mut s.back.plies, Range::Within(0.0, MAX_PLIES as f64), 723,
        "The last so many plies, less than stack.plies, are of this fabric; 0: none"),
    of_back("back.node_mass", |s| one(&mut s.back.node_mass), &MASS, Range::Positive, 724, "Mass of a node of a ply (M7)"),
    of_back("back.yarn_area", |s| one(&mut s.back.yarn_area), &AREA, Range::Positive, 725, "Cross-section A_0 of a bar along x (M4)"),
    of_back("back.yarn_area_y", |s| one(&mut s.back.yarn_area_y), &AREA, Range::NotNegative, 726,
        "Cross-section of a bar along y; 0: as along x"),
    Field { place: Place::Reals(|s| &mut s.back.crimp, &[2]), ..of_back("back.crimp", |s| &mut s.back.crimp, &RATIO, Range::Within(0.0, 1.0), 727,
        "Crimp of the yarns along x and along y") },
    of_back("back.modulus_mean", |s| one(&mut s.back.modulus_mean), &MODULUS, Range::Positive, 729, "Mean Young's modulus E of a segment (M3)"),
    of_back("back.modulus_sd", |s| one(&mut s.back.modulus_sd), &MODULUS, Range::NotNegative, 730,
        "Standard deviation of the modulus. Modulus and damage rate are sampled if this or back.damage_sd is not 0"),
    of_back("back.damage_slope", |s| one(&mut s.back.damage_slope), &DAMAGE_SLOPE, Range::Any, 731, "Slope of the damage rate over the modulus (M6)"),
    of_back("back.damage_intercept", |s| one(&mut s.back.damage_intercept), &RATIO, Range::Any, 732,
        "Damage rate at zero modulus (M6); the mean rate must be at least 3"),
    of_back("back.damage_sd", |s| one(&mut s.back.damage_sd), &RATIO, Range::NotNegative, 733,
        "Standard deviation of the damage rate about the line"),
    of_back("back.critical_stretch", |s| one(&mut s.back.critical_stretch), &RATIO, Range::Above(1.0, CRITICAL_STRETCH_MAX), 734,
        "Critical stretch U_c at which damage begins (M5)"),
    of_back("back.weibull_shape", |s| one(&mut s.back.weibull_shape), &RATIO, Range::Within(0.0, WEIBULL_SHAPES[1]), 735,
        "Weibull shape m of the critical strain U_c - 1, at least 1; 0: it is not sampled"),
    of_back("back.weibull_gauge_length", |s| one(&mut s.back.weibull_gauge_length), &LENGTH, Range::NotNegative, 736,
        "Gauge length L at which back.critical_stretch - 1 is the Weibull scale; 0: L is the length of a segment. Counts for sampled strength only"),
    // ---- Attachment
    choice("attachment.kind", &AttachmentKind::CHOICE, |s| s.attachment.kind as u32, |s, k| pick(&mut s.attachment.kind, AttachmentKind::ALL, k), 240,
        "Which nodes are held"),
    real("attachment.disc_inset", |s| one(&mut s.attachment.disc_inset), &LENGTH, Range::NotNegative, 241,
        "Distance of a corner disc's centre from both edges. Read for four corners only").read(FOUR_CORNERS),
    real("attachment.disc_radius", |s| one(&mut s.attachment.disc_radius), &LENGTH, Range::Positive, 242,
        "Radius of the corner discs. Each must hold a node; they may neither overlap nor reach under the projectile. Read for four corners only")
        .read(FOUR_CORNERS),
    real("attachment.hold", |s| one(&mut s.attachment.hold), &FORCE, Range::NotNegative, 757,
        "Force H at which the clamp lets a bar of one ply slip (M25), for each bar that ends there; 0 = without limit. Velocity Verlet only"),
    real("attachment.grip", |s| one(&mut s.attachment.grip), &LENGTH, Range::NotNegative, 758,
        "Length of yarn in the clamp: a node that has slid so far has been pulled out; 0 = without end. Only with a hold"),
    real("attachment.strength", |s| one(&mut s.attachment.strength), &FORCE, Range::NotNegative, 759,
        "Mean force over force_window at which one attachment as a whole lets go; 0 = never"),
    // ---- Yarn
    real("yarn.modulus_mean", |s| one(&mut s.yarn.modulus_mean), &MODULUS, Range::Positive, 250, "Mean Young's modulus E of a segment (M3)"),
    real("yarn.modulus_sd", |s| one(&mut s.yarn.modulus_sd), &MODULUS, Range::NotNegative, 251,
        "Standard deviation of the modulus. Counts for stochastic yarn only"),
    real("yarn.damage_slope", |s| one(&mut s.yarn.damage_slope), &DAMAGE_SLOPE, Range::Any, 252,
        "Slope of the damage rate over the modulus (M6)"),
    real("yarn.damage_intercept", |s| one(&mut s.yarn.damage_intercept), &RATIO, Range::Any, 253,
        "Damage rate at zero modulus on that line (M6); the mean rate must be at least 3"),
    real("yarn.damage_sd", |s| one(&mut s.yarn.damage_sd), &RATIO, Range::NotNegative, 254,
        "Standard deviation of the damage rate about the line. Counts for stochastic yarn only"),
    real("yarn.critical_stretch", |s| one(&mut s.yarn.critical_stretch), &RATIO, Range::Above(1.0, CRITICAL_STRETCH_MAX), 255,
        "Critical stretch U_c at which damage begins (M5)"),
    real("yarn.damage_a", |s| one(&mut s.yarn.damage_a), &RATIO, Range::Positive, 258, "Factor A of the damage law (M5); A (1 - B) must lie in (0, 1]"),
    real("yarn.damage_b", |s| one(&mut s.yarn.damage_b), &RATIO, Range::Below(-INFINITE, 1.0), 259, "Offset B of the damage law (M5)"),
    real("yarn.alpha_fail", |s| one(&mut s.yarn.alpha_fail), &RATIO, Range::Below(0.0, 1.0), 256,
        "Remaining part alpha of the stiffness (M5) at or below which a segment fails"),
    flag("yarn.stochastic", |s| &mut s.yarn.stochastic, 257, "Modulus and damage rate are sampled; if not, every segment takes the means"),
    choice("yarn.draw", &Draw::CHOICE, |s| s.yarn.draw as u32, |s, k| pick(&mut s.yarn.draw, Draw::ALL, k), 274,
        "What gets a sample of its own. Read for stochastic yarn only")
        .read(|s| if_so(s.yarn.stochastic)),
    choice("yarn.strength_draw", &StrengthDraw::CHOICE, |s| s.yarn.strength_draw as u32,
        |s, k| pick(&mut s.yarn.strength_draw, StrengthDraw::ALL, k), 660,
        "Whether every segment has a critical stretch of its own, whether or not modulus and damage rate are sampled; not with mirror planes"),
    real("yarn.weibull_shape", |s| one(&mut s.yarn.weibull_shape), &RATIO, Range::Within(WEIBULL_SHAPES[0], WEIBULL_SHAPES[1]), 661,
        "Weibull shape m of the critical strain U_c - 1. Read for sampled strength only").read(DRAWN_STRENGTH),
    real("yarn.weibull_gauge_length", |s| one(&mut s.yarn.weibull_gauge_length), &LENGTH, Range::NotNegative, 662,
        "Gauge length L at which yarn.critical_stretch - 1 is the Weibull scale: that of a segment of length h is larger by (L/h)^(1/m). 0: L is h. Read for sampled strength only")
        .read(DRAWN_STRENGTH),
    real("yarn.weibull_correlation", |s| one(&mut s.yarn.weibull_correlation), &RATIO, Range::Within(0.0, 1.0), 663,
        "Correlation of the normal scores of two segments of one woven yarn; the size effect holds along a yarn for 0. Read for sampled strength only, that of the back fabric included")
        .read(|s| DRAWN_STRENGTH(s).max(if_so(s.back.plies > 0 && s.back.weibull_shape != 0.0))),
    real("yarn.viscosity_linear", |s| one(&mut s.yarn.viscosity_linear), &RATIO, Range::Within(0.0, 1.0), 640,
        "Viscosity of taut yarn, linear in the rate of stretch, against oscillation behind a front; 0 = none. Velocity Verlet only"),
    real("yarn.viscosity_quadratic", |s| one(&mut s.yarn.viscosity_quadratic), &RATIO, Range::Within(0.0, 10.0), 641,
        "Likewise, quadratic in the rate and only while the yarn is stretched"),
    real("yarn.viscosity_bending", |s| one(&mut s.yarn.viscosity_bending), &RATIO, Range::Within(0.0, 0.2), 642,
        "Viscosity of taut yarn against bending, linear in the second difference of the velocities along it; 0 = none. Velocity Verlet only"),
    real("yarn.rate_modulus", |s| one(&mut s.yarn.rate_modulus), &RATIO, Range::Within(0.0, 1.0), 680,
        "Growth C_E of the modulus by e-fold of the rate of strain above yarn.rate_reference (M19); 0 = none. Velocity Verlet only; not with slack_balance, pre-tension or separate plies"),
    real("yarn.rate_stretch", |s| one(&mut s.yarn.rate_stretch), &RATIO, Range::Within(0.0, 1.0), 681,
        "Growth C_U of the critical strain by e-fold of the rate of strain (M20); 0 = none"),
    real("yarn.rate_reference", |s| one(&mut s.yarn.rate_reference), &STRAIN_RATE, Range::Within(0.0, STRAIN_RATES[1]), 682,
        "Rate of strain at which modulus and critical stretch are as given, at least 1e-9/s; slower ones count as this. Read for yarn that depends on the rate only")
        .read(ON_RATE),
    real("yarn.rate_limit", |s| one(&mut s.yarn.rate_limit), &STRAIN_RATE, Range::Within(0.0, STRAIN_RATES[1]), 683,
        "Largest rate of strain measured, at least yarn.rate_reference; faster ones count as this. Read for yarn that depends on the rate only")
        .read(ON_RATE),
    // ---- Yarn along y
    real("weft.modulus_mean", |s| one(&mut s.weft.modulus_mean), &MODULUS, Range::NotNegative, 626,
        "Mean Young's modulus of a segment along y; 0: modulus and damage rate as along x"),
    real("weft.modulus_sd", |s| one(&mut s.weft.modulus_sd), &MODULUS, Range::NotNegative, 627,
        "Standard deviation of the modulus. Read if weft.modulus_mean is not 0").read(OWN_WEFT),
    real("weft.damage_slope", |s| one(&mut s.weft.damage_slope), &DAMAGE_SLOPE, Range::Any, 628,
        "Slope of the damage rate over the modulus (M6). Read if weft.modulus_mean is not 0").read(OWN_WEFT),
    real("weft.damage_intercept", |s| one(&mut s.weft.damage_intercept), &RATIO, Range::Any, 629,
        "Damage rate at zero modulus (M6); the mean rate must be at least 3. Read if weft.modulus_mean is not 0").read(OWN_WEFT),
    real("weft.damage_sd", |s| one(&mut s.weft.damage_sd), &RATIO, Range::NotNegative, 630,
        "Standard deviation of the damage rate about the line. Read if weft.modulus_mean is not 0").read(OWN_WEFT),
    real("weft.critical_stretch", |s| one(&mut s.weft.critical_stretch), &RATIO, Range::Within(0.0, 2.0), 631,
        "Critical stretch U_c of a segment along y, greater than 1 (M5); 0: as along x"),
    // ---- Projectile
    choice("projectile.shape", &Shape::CHOICE, |s| s.projectile.shape as u32, |s, k| pick(&mut s.projectile.shape, Shape::ALL, k), 210,
        "Form of the projectile (M12)"),
    real("projectile.radius", |s| one(&mut s.projectile.radius), &LENGTH, Range::Positive, 211,
        "Radius, at least sheet.spacing. Read for a sphere and the two cylinders only").read(ROUND),
    real("projectile.length", |s| one(&mut s.projectile.length), &LENGTH, Range::Positive, 212,
        "Whole length along the axis, at least 2 sheet.spacing, and with a hemispherical end at least the radius. Read for the two cylinders only")
        .read(|s| if_so(matches!(s.projectile.shape, Shape::Cylinder | Shape::HemisphericalCylinder))),
    real("projectile.mass", |s| one(&mut s.projectile.mass), &MASS, Range::Any, 213,
        "Mass, at least that of a node with all its plies. Prescribed projectile: 0 if it is not known"),
    vector("projectile.size", |s| &mut s.projectile.size, &LENGTH, Range::Positive, 214,
        "Edge lengths of a box along the body's axes, each at least 2 sheet.spacing. Read for a box only")
        .read(|s| if_so(s.projectile.shape == Shape::Box)),
    count("projectile.faces.count", |s| &mut s.projectile.faces.count, Range::Within(0.0, 16.0), 264,
        "Number of faces of a polyhedron, 4 to 16. Read for a polyhedron only")
        .read(|s| if_so(s.projectile.shape == Shape::Polyhedron)),
    shaped("projectile.faces.planes", Place::Reals(|s| s.projectile.faces.planes.as_flattened_mut(), &[MAX_FACES, 4]), &RATIO, Range::Any, 500,
        "Outward unit normal of each face (to 1e-6) and its distance from the centre of mass in m, at least sheet.spacing. Beyond the count not read")
        .read(|s| if s.projectile.shape == Shape::Polyhedron { 4 * s.projectile.faces.in_use().len() } else { 0 }),
    vector("projectile.moments", |s| &mut s.projectile.moments, &INERTIA, Range::Positive, 265,
        "Principal moments of inertia about the centre of mass along the body's axes, none greater than the other two together. Read for a polyhedron of known mass only; other shapes are homogeneous")
        .read(|s| if_so(s.projectile.shape == Shape::Polyhedron && s.projectile.mass != 0.0)),
    vector("projectile.position", |s| &mut s.projectile.position, &POSITION, Range::Any, 600,
        "Centre of mass at the start. No node may lie inside the projectile (a fixed one may in a prescribed one)").not_in_fingerprint(),
    vector("projectile.velocity", |s| &mut s.projectile.velocity, &VELOCITY, Range::Any, 603,
        "Velocity of the centre of mass at the start. No point of the surface may cross sheet.spacing in a step").not_in_fingerprint(),
    quaternion("projectile.orientation", |s| &mut s.projectile.orientation, 606,
        "Orientation at the start: unit quaternion, scalar first, that turns body vectors into the host's axes").not_in_fingerprint(),
    vector("projectile.angular_velocity", |s| &mut s.projectile.angular_velocity, &ANGULAR_VELOCITY, Range::Any, 610,
        "Angular velocity at the start, host's axes").not_in_fingerprint(),
    real("projectile.sector.inner_radius", |s| one(&mut s.projectile.sector.inner_radius), &LENGTH, Range::NotNegative, 294,
        "Radius of the bore, 0 or between 1e-6 and 1 - 1e-6 of that of the rim; filled up to its one chord. Read for a disc sector only").read(SECTOR),
    real("projectile.sector.outer_radius", |s| one(&mut s.projectile.sector.outer_radius), &LENGTH, Range::Positive, 295,
        "Radius of the rim, which is made of eight chords; no face may be nearer to the centre of mass than sheet.spacing. Read for a disc sector only")
        .read(SECTOR),
    real("projectile.sector.angle", |s| one(&mut s.projectile.sector.angle), &ANGLE, Range::Below(1e-3, core::f64::consts::PI), 296,
        "Angle of a disc sector. Read for a disc sector only").read(SECTOR),
    real("projectile.sector.thickness", |s| one(&mut s.projectile.sector.thickness), &LENGTH, Range::Positive, 297,
        "Thickness along the disc's axis, at least 2 sheet.spacing. Read for a disc sector only").read(SECTOR),
    // ---- Case
    real("casing.radius", |s| one(&mut s.casing.radius), &LENGTH, Range::NotNegative, 752,
        "Radius of a rigid case about the axis of a ring, which its nodes may lift off but not enter (M24), at most sheet.radius; 0 = none. A ring with pre-strain along x needs one of sheet.radius. The projectile does not meet it"),
    shaped("casing.window_angle", Place::Reals(|s| &mut s.casing.window_angle, &[2]), &ANGLE, Range::Within(0.0, core::f64::consts::TAU), 753,
        "A window in which there is no case: angle of its middle from +z towards +x, and half its angle; 0 = no window. Read with a case only")
        .read(CASED),
    shaped("casing.window_place", Place::Reals(|s| &mut s.casing.window_place, &[2]), &POSITION, Range::Any, 755,
        "Place of its middle along y in the sheet's frame, and half its length; 0 = no window. Read with a case only")
        .read(CASED),
    // ---- Contact
    real("contact.friction", |s| one(&mut s.contact.friction), &RATIO, Range::Within(0.0, 10.0), 700,
        "Coefficient of Coulomb friction between yarn and projectile (M21); 0 = none. With it a sphere turns, too. Velocity Verlet only"),
    // ---- Mirror planes
    flag("symmetry.mirror_x", |s| &mut s.symmetry.mirror_x, 280,
        "Mirror plane x = 0. Sums stay those of the whole sheet. For uniform yarn, a free projectile and a centred, untilted hit"),
    flag("symmetry.mirror_y", |s| &mut s.symmetry.mirror_y, 281, "Mirror plane y = 0, likewise"),
    // ---- Who moves the projectile, and how the nodes are stepped
    choice("drive", &Drive::CHOICE, |s| s.drive as u32, |s, k| pick(&mut s.drive, Drive::ALL, k), 200, "Who moves the projectile"),
    choice("integrator.kind", &IntegratorKind::CHOICE, |s| s.integrator.kind as u32, |s, k| pick(&mut s.integrator.kind, IntegratorKind::ALL, k), 282,
        "Velocity Verlet (M7), or the paper's theta rule (M10)"),
    real("integrator.theta", |s| one(&mut s.integrator.theta), &RATIO, Range::Within(0.5, 1.0), 283,
        "Theta rule: weight of the forces at the step's end (M10); 0.5 is of second order").read(THETA_RULE),
    real("integrator.tolerance", |s| one(&mut s.integrator.tolerance), &RATIO, Range::Positive, 284,
        "Theta rule: the iteration ends when no node moves by more than this, in node spacings").read(THETA_RULE),
    count("integrator.max_iterations", |s| &mut s.integrator.max_iterations, Range::Within(1.0, u32::MAX as f64), 285,
        "Theta rule: iterations after which a step fails").read(THETA_RULE),
    row("seed", Place::Seed(|s| &mut s.seed), Range::Any, 260, "Seed of the random samples"),
    // ---- Time step
    real("time_step.fraction", |s| one(&mut s.time_step.fraction), &RATIO, Range::Positive, 286,
        "Time step as a fraction of dt_crit (M11), at most 0.5. Read if time_step.seconds is 0")
        .read(|s| if_so(s.time_step.seconds == 0.0)).not_in_fingerprint(),
    real("time_step.seconds", |s| one(&mut s.time_step.seconds), &DURATION, Range::NotNegative, 261,
        "Time step in seconds, at most 0.5 dt_crit; 0: time_step.fraction says it").not_in_fingerprint(),
    choice("step_check", &StepCheck::CHOICE, |s| s.step_check as u32, |s, k| pick(&mut s.step_check, StepCheck::ALL, k), 287,
        "Whether the time step is checked against its limit").not_in_fingerprint(),
    flag("slack_balance", |s| &mut s.slack_balance, 289,
        "The energy error of segments that become slack or taut is corrected. Velocity Verlet only; not with a dependence on the rate of strain"),
    choice("rotation_rule.kind", &RotationKind::CHOICE, |s| s.rotation_rule.kind as u32, |s, k| pick(&mut s.rotation_rule.kind, RotationKind::ALL, k), 290,
        "The implicit midpoint rule, or the paper's theta rule"),
    real("rotation_rule.theta", |s| one(&mut s.rotation_rule.theta), &RATIO, Range::Within(0.5, 1.0), 291,
        "Theta rule of the rotation: weight of the step's end")
        .read(|s| if_so(s.rotation_rule.kind == RotationKind::Theta)),
    // ---- What is watched, and room
    real("force_window", |s| one(&mut s.force_window), &DURATION, Range::Positive, 262,
        "Window of the peak force, rounded to whole steps, at least one. Until the first is full the peak force is the mean over the time elapsed"),
    flag("track_detachment", |s| &mut s.track_detachment, 263,
        "Watch whether the touched nodes are still held (4 bytes a node); without it a projectile that carries torn cloth never exits"),
    flag("track_support", |s| &mut s.track_support, 292, "Sum the impulses on the supports; the momentum residual needs them"),
    count("contact_capacity", |s| &mut s.contact_capacity, Range::Any, 293,
        "Most nodes closer than sheet.spacing to the projectile at once, 120 bytes each (128 with the theta rule, 272 with friction); more are a failure. 0 = every node")
        .not_in_fingerprint(),
    flag("track_through", |s| &mut s.track_through, 298,
        "Watch whether held yarn can still stop a free projectile: the outcome through, long before exited. Needs track_detachment to distinguish held yarn from loose yarn"),
];

/// All elements, or none.
const fn if_so(condition: bool) -> usize {
    if condition { usize::MAX } else { 0 }
}

type Reals = fn(&mut Scene) -> &mut [f64];
type Of = &'static Quantity;
type Chosen = fn(&Scene) -> u32;

const fn row(name: Str, place: Place, range: Range, fmi: u32, about: Str) -> Field {
    Field { name, place, quantity: None, range, read: |_| usize::MAX, in_fingerprint: true, fmi, about }
}

const fn shaped(name: Str, place: Place, of: Of, range: Range, fmi: u32, about: Str) -> Field {
    Field { quantity: Some(of), ..row(name, place, range, fmi, about) }
}

const fn real(name: Str, place: Reals, of: Of, range: Range, fmi: u32, about: Str) -> Field {
    shaped(name, Place::Reals(place, &[]), of, range, fmi, about)
}

/// Real number of the back fabric.
const fn of_back(name: Str, place: Reals, of: Of, range: Range, fmi: u32, about: Str) -> Field {
    real(name, place, of, range, fmi, about).read(|s| if_so(s.back.plies != 0))
}

const fn vector(name: Str, place: Reals, of: Of, range: Range, fmi: u32, about: Str) -> Field {
    shaped(name, Place::Reals(place, &[3]), of, range, fmi, about)
}

const fn quaternion(name: Str, place: Reals, fmi: u32, about: Str) -> Field {
    shaped(name, Place::Reals(place, &[4]), &QUATERNION, Range::UnitQuaternion, fmi, about)
}

const fn count(name: Str, place: fn(&mut Scene) -> &mut u32, range: Range, fmi: u32, about: Str) -> Field {
    row(name, Place::Count(place), range, fmi, about)
}

const fn flag(name: Str, place: fn(&mut Scene) -> &mut bool, fmi: u32, about: Str) -> Field {
    row(name, Place::Flag(place), Range::Any, fmi, about)
}

const fn choice(name: Str, of: &'static Choice, get: Chosen, set: fn(&mut Scene, u32), fmi: u32, about: Str) -> Field {
    row(name, Place::Choice(of, get, set), Range::Any, fmi, about)
}

/// Takes the choice of this number, if there is one.
fn pick<T: Copy>(place: &mut T, all: &[T], number: u32) {
    *place = all.get(number as usize).copied().unwrap_or(*place);
}

fn one(number: &mut f64) -> &mut [f64] {
    core::slice::from_mut(number)
}
