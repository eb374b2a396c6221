//! The cases of bad input that the kernel, the C interface and the FMUs are tried with (`cases`): every
//! number of a scene within, at and beyond its range, and what is said of it.
//!
//! A number that is good or bad by itself is tried by its row of the kernel's table of parameters. Where a
//! number that is good by itself makes another one bad (a heavy node, a light projectile) a row here says so.

use fabric_kernel::Code::{self, *};
use fabric_kernel::Scene;
use fabric_kernel::fields::{FIELDS, Field, Place, Range, field};
use fabric_kernel::internals::parts::MAX_NODES_PER_SIDE;
use fabric_kernel::internals::presets::PAPER_SPACING;

/// What is expected of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expected {
    /// It is sound.
    Accepted,
    /// It is refused with this code, and this field named.
    Refused(Code, &'static str),
}
use Expected::{Accepted, Refused};

/// How far along the number line an expectation holds.
#[derive(Clone, Copy)]
enum Up {
    /// To numbers less than this.
    Below(f64),
    /// To this number.
    To(f64),
    /// To somewhere here: a limit that another field sets and that is known only roughly. No number near it
    /// is tried.
    About(f64),
    /// To the end.
    End,
}
use Up::{About, Below, End, To};

/// What is tried.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// A real number: also NaN and both infinities, which are refused.
    Real,
    /// A real number that is not read: anything goes.
    NotRead,
    /// A count or a choice.
    Count,
}

/// One number of a scene, or several alike.
struct Row {
    base: &'static str,
    names: Vec<&'static str>,
    kind: Kind,
    /// What is expected along the number line, from minus infinity on.
    line: Vec<(Up, Expected)>,
    /// Numbers tried in addition to the usual ones and the limits.
    also: &'static [f64],
}

/// One change of a sound scene.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// The scene's name.
    pub base: &'static str,
    /// The number that is changed, as in `Scene`, components with their index: `sheet.position[1]`.
    pub name: &'static str,
    /// What it becomes.
    pub value: f64,
    /// What is expected.
    pub expected: Expected,
}

/// Half the edge of the cube.
const EDGE: f64 = 6.35e-3;

/// Radius of a ring of nine nodes at the spacing of the paper, m: h/(2 sin 20 degrees).
const RING: f64 = 0.001_060_923_310_916_320_3;

/// The sound scenes: the preset 3 in scene with these changes, and those of `START` before.
#[rustfmt::skip]
const BASES: &[(&str, &[(&str, f64)])] = &[
    ("sphere", &[]),
    ("uniform", &[("yarn.stochastic", 0.0)]),
    ("weft", &[("weft.modulus_mean", 100e9), ("weft.damage_intercept", 200.0)]),
    ("wide", &[("yarn.critical_stretch", 1.1)]),
    ("stack", &[("stack.plies", 3.0), ("stack.gap", 1e-4)]),
    ("hybrid", &[("stack.plies", 3.0), ("stack.gap", 1e-4), ("back.plies", 1.0)]),
    ("strength", &[("yarn.stochastic", 0.0), ("yarn.strength_draw", 1.0)]),
    ("cylinder", &[("projectile.shape", 1.0), ("projectile.length", 0.0127)]),
    ("bullet", &[("projectile.shape", 2.0), ("projectile.length", 0.0127), ("projectile.position[2]", -0.02)]),
    ("box", &[("projectile.shape", 3.0), ("projectile.size[0]", 0.0127), ("projectile.size[1]", 0.0127), ("projectile.size[2]", 0.0127)]),
    ("cube", &[
        ("projectile.shape", 4.0), ("projectile.faces.count", 6.0),
        ("projectile.faces.planes[0][0]", 1.0), ("projectile.faces.planes[0][3]", EDGE), ("projectile.faces.planes[1][0]", -1.0), ("projectile.faces.planes[1][3]", EDGE),
        ("projectile.faces.planes[2][1]", 1.0), ("projectile.faces.planes[2][3]", EDGE), ("projectile.faces.planes[3][1]", -1.0), ("projectile.faces.planes[3][3]", EDGE),
        ("projectile.faces.planes[4][2]", 1.0), ("projectile.faces.planes[4][3]", EDGE), ("projectile.faces.planes[5][2]", -1.0), ("projectile.faces.planes[5][3]", EDGE),
        ("projectile.moments[0]", 2e-7), ("projectile.moments[1]", 2e-7), ("projectile.moments[2]", 2e-7),
    ]),
    ("sector", &[("projectile.shape", 5.0)]),
    ("corners", &[
        ("sheet.nodes_x", 23.0), ("sheet.nodes_y", 23.0), ("projectile.radius", 3e-3),
        ("attachment.kind", 2.0), ("attachment.disc_inset", 1e-3), ("attachment.disc_radius", 8e-4),
    ]),
    ("clamped", &[("attachment.hold", 20.0)]),
    ("prescribed", &[("drive", 1.0)]),
    ("fraction", &[("time_step.seconds", 0.0)]),
    ("unchecked", &[("time_step.seconds", 0.0), ("step_check", 1.0)]),
    ("theta", &[("integrator.kind", 1.0)]),
    ("rate", &[("yarn.rate_modulus", 0.13), ("yarn.rate_stretch", 0.16), ("yarn.rate_reference", 30.0), ("yarn.rate_limit", 170.0)]),
    ("mirrored", &[("yarn.stochastic", 0.0), ("symmetry.mirror_x", 1.0)]),
    ("turning", &[("rotation_rule.kind", 1.0)]),
    ("graded", &[("sheet.grading.largest", 4.0)]),
    ("ring", &[("sheet.radius", RING), ("sheet.closed", 1.0), ("projectile.position[2]", -8e-3)]),
    ("case", &[("sheet.radius", RING), ("sheet.closed", 1.0), ("projectile.position[2]", -8e-3), ("casing.radius", 1e-3), ("casing.window_angle[1]", 0.5)]),
];

/// A sheet of 9 x 9, the sphere 0.65 mm before it, and a step far below every limit that a case moves.
const START: &[(&str, f64)] =
    &[("sheet.nodes_x", 9.0), ("sheet.nodes_y", 9.0), ("projectile.position[2]", -7e-3), ("time_step.seconds", 5e-9)];

/// Numbers tried of every real field.
const REALS: [f64; 9] = [0.0, -0.0, 5e-324, -5e-324, f64::MIN_POSITIVE, 1.0, -1.0, f64::MAX, -f64::MAX];

/// Largest and smallest numbers of a quaternion's scalar alone: its length may be off by less than 1e-3, and
/// these decimals lie just inside and just outside of it.
const TURN: [(Up, Expected); 5] = [
    (Below(-1.001), Refused(BadQuaternion, "")),
    (Below(-0.999), Accepted),
    (To(0.999), Refused(BadQuaternion, "")),
    (To(1.001), Accepted),
    (End, Refused(BadQuaternion, "")),
];

/// The table. An empty field in an expectation means the row's own.
#[rustfmt::skip]
fn rows() -> Vec<Row> {
    let h = PAPER_SPACING;
    let overlap = Refused(InitialOverlap, "projectile.position");
    let too_fast = Refused(ProjectileTooFast, "projectile.velocity");
    let too_heavy = Refused(OutOfRange, "projectile.mass");
    let no_limit = Refused(StepLimitUnusable, "sheet.node_mass");
    let no_step = Refused(StepLimitUnusable, "time_step.seconds");
    let too_long = Refused(StepTooLarge, "time_step.seconds");
    let weak = Refused(DamageRateTooSmall, "yarn.damage_intercept");
    let weak_weft = Refused(DamageRateTooSmall, "weft.damage_intercept");
    let own = |code| Refused(code, "");
    let not_positive = (To(0.0), own(NotPositive));
    let negative = (Below(0.0), own(OutOfRange));
    let rest = (End, Accepted);
    let beyond = (End, own(OutOfRange));
    let apart = own(DoesNotGoWith);
    let real = |base, names: &[&'static str], line: &[(Up, Expected)], also| Row { base, names: names.to_vec(), kind: Kind::Real, line: line.to_vec(), also };
    let not_read = |base, names: &[&'static str]| Row { base, names: names.to_vec(), kind: Kind::NotRead, line: vec![rest], also: &[] };
    let count = |base, names: &[&'static str], line: &[(Up, Expected)], also| Row { base, names: names.to_vec(), kind: Kind::Count, line: line.to_vec(), also };
    let choice = |base, names: &[&'static str], last: f64| Row {
        base, names: names.to_vec(), kind: Kind::Count, line: vec![(To(last), Accepted), (End, own(UnknownChoice))], also: &[],
    };
    let bore = Refused(OutOfRange, "projectile.sector.inner_radius");
    let step_max = scene("sphere").step_limits().expect("sound").step_max;
    let fastest = h / 5e-9;
    let rounding = 1.0 + 4.0 * f64::EPSILON;
    let turned = [(About(-0.0447), own(BadQuaternion)), (About(0.0447), Accepted), (End, own(BadQuaternion))];
    let at_least_two = [not_positive, (Below(2.0 * h), own(ProjectileTooSmall))];
    let line = |first: &[(Up, Expected)], then: &[(Up, Expected)]| [first, then].concat();
    let mut rows = vec![
        // ---- Sheet. A small node or spacing, a thick or stiff yarn, make the stable step smaller, and at
        // last no number.
        real("sphere", &["sheet.spacing"], &[not_positive, (About(1e-296), no_limit), (About(3e-5), too_long), (To(6.35e-3), Accepted), (End, Refused(ProjectileTooSmall, "projectile.radius"))], &[1e-300, 1e-6, 1e-3]),
        real("sphere", &["sheet.thickness"], &[negative, (About(0.8 * h), Accepted), beyond], &[1e-4, 5e-4, 6e-4]),
        real("case", &["sheet.thickness"], &[negative, (About(2.0 * (RING - 1e-3)), Accepted), (About(0.8 * h), Refused(OutOfRange, "casing.radius")), beyond], &[1e-4, 2e-4]),
        real("sphere", &["sheet.node_mass"], &[not_positive, (About(1e-299), no_limit), (About(3e-9), too_long), (To(8.4e-3), Accepted), (End, Refused(ProjectileTooLight, "projectile.mass"))], &[1e-20, 1e-6]),
        real("sphere", &["sheet.yarn_area"], &[not_positive, (About(1e-296), no_step), (About(3e-6), Accepted), (About(1e290), too_long), (End, no_limit)], &[1e-8, 1e-5]),
        real("sphere", &["sheet.position[0]", "sheet.position[1]"], &[rest], &[1e-4]),
        real("sphere", &["sheet.position[2]"], &[(About(-13.35e-3), Accepted), (About(-0.65e-3), overlap), rest], &[-7e-3, -1e-3, 1e-4]),
        real("sphere", &["sheet.orientation[0]"], &TURN, &[]),
        real("sphere", &["sheet.orientation[1]", "sheet.orientation[2]", "sheet.orientation[3]"], &turned, &[0.04, -0.05]),
        // ---- Unlike directions, crimp and pre-tension.
        real("sphere", &["sheet.spacing_y"], &[negative, (To(0.0), Accepted), (About(0.1 * h), own(OutOfRange)), (To(6.35e-3), Accepted), (To(10.0 * h), Refused(ProjectileTooSmall, "projectile.radius")), beyond], &[0.099 * PAPER_SPACING, 0.101 * PAPER_SPACING, 1e-3]),
        real("sphere", &["sheet.yarn_area_y"], &[negative, (To(0.0), Accepted), (About(1e-296), no_step), (About(3e-6), Accepted), (About(1e290), too_long), (End, no_limit)], &[1e-8, 1e-5]),
        real("sphere", &["sheet.pre_strain[0]", "sheet.pre_strain[1]"], &[negative, (To(0.0), Accepted), (Below(1.03 - 1.0), Refused(NotInEquilibrium, "yarn.draw")), beyond], &[]),
        real("uniform", &["sheet.pre_strain[0]", "sheet.pre_strain[1]"], &[negative, (Below(1.03 - 1.0), Accepted), beyond], &[]),
        real("corners", &["sheet.pre_strain[0]", "sheet.pre_strain[1]"], &[negative, (To(0.0), Accepted), (Below(1.03 - 1.0), own(NotInEquilibrium)), beyond], &[]),
        real("sphere", &["weft.modulus_mean"], &[negative, (To(0.0), Accepted), (End, weak_weft)], &[]),
        real("weft", &["weft.modulus_mean"], &[negative, (To(0.0), Accepted), (About(1e-290), no_step), (About(3e12), Accepted), (About(1e290), too_long), (End, no_limit)], &[5e12]),
        real("weft", &["weft.modulus_sd"], &[negative, (About(1e11), Accepted), (About(1e290), too_long), (End, no_limit)], &[1e9, 1e20]),
        real("weft", &["weft.damage_slope"], &[(About(-1e297), own(NotFinite)), (About(-1.97e-9), weak_weft), (About(1e297), Accepted), (End, own(NotFinite))], &[-2e-9, -1.9e-9]),
        real("weft", &["weft.damage_intercept"], &[(Below(3.0), weak_weft), rest], &[]),
        real("weft", &["weft.damage_sd"], &[negative, rest], &[]),
        not_read("sphere", &["weft.modulus_sd", "weft.damage_slope", "weft.damage_intercept", "weft.damage_sd"]),
        real("sphere", &["weft.critical_stretch"], &[negative, (To(0.0), Accepted), (To(1.0), own(OutOfRange)), (To(2.0), Accepted), beyond], &[]),
        // ---- Yarn. The mean damage rate, slope E + intercept, is at least 3.
        real("sphere", &["yarn.modulus_mean"], &[not_positive, (About(1.1143e11), weak), (About(3e12), Accepted), (About(1e290), too_long), (End, no_limit)], &[1.1e11, 1.2e11, 5e12]),
        real("sphere", &["yarn.modulus_sd"], &[negative, (About(1e11), Accepted), (About(1e290), too_long), (End, no_limit)], &[1e9, 1e20]),
        real("sphere", &["yarn.damage_sd"], &[negative, rest], &[]),
        real("uniform", &["yarn.modulus_sd", "yarn.damage_sd"], &[negative, rest], &[]),
        real("sphere", &["yarn.damage_slope"], &[(About(-1e297), own(NotFinite)), (About(6.2867e-9), weak), (About(1e297), Accepted), (End, own(NotFinite))], &[6.2e-9, 6.3e-9]),
        real("sphere", &["yarn.damage_intercept"], &[(Below(3.0 - 7.91e-9 * 140.21e9), weak), rest], &[]),
        real("sphere", &["yarn.damage_a"], &[not_positive, (To(rounding), Accepted), beyond], &[]),
        real("sphere", &["yarn.damage_b"], &[(About(-1e-15), Refused(OutOfRange, "yarn.damage_a")), (Below(1.0), Accepted), beyond], &[0.5, -0.01]),
        count("sphere", &["symmetry.mirror_x", "symmetry.mirror_y"], &[(To(0.0), Accepted), (To(1.0), Refused(DoesNotGoWith, "yarn.stochastic")), (End, own(UnknownChoice))], &[]),
        choice("uniform", &["symmetry.mirror_x", "symmetry.mirror_y"], 1.0),
        count("strength", &["symmetry.mirror_x", "symmetry.mirror_y"], &[(To(0.0), Accepted), (To(1.0), Refused(DoesNotGoWith, "yarn.strength_draw")), (End, own(UnknownChoice))], &[]),
        // ---- Graded networks.
        count("sphere", &["sheet.grading.largest"], &[(To(2.0), Accepted), (To(3.0), own(OutOfRange)), (To(4.0), Accepted), (Below(64.0), own(OutOfRange)), (To(64.0), Accepted), beyond], &[]),
        not_read("sphere", &["sheet.grading.centre[0]", "sheet.grading.centre[1]", "sheet.grading.half_width[0]", "sheet.grading.half_width[1]"]),
        // ---- Curved sheets, and the case under a ring. The sphere of the flat sheet is met by a nearly
        // closed arc.
        real("sphere", &["sheet.radius"], &[negative, (To(0.0), Accepted), (About(1.0609e-3), own(OutOfRange)), (About(1.35e-3), overlap), (To(1e6 * h), Accepted), beyond], &[1e-3, 1.2e-3, 2e-3]),
        real("ring", &["sheet.radius"], &[negative, (To(0.0), own(NotPositive)), (About(RING - 1.2e-9), own(OutOfRange)), (About(RING + 1.2e-9), Accepted), beyond], &[RING - 0.9e-9, RING + 0.9e-9]),
        real("theta", &["sheet.radius"], &[negative, (To(0.0), Accepted), (End, apart)], &[]),
        real("stack", &["sheet.radius"], &[negative, (To(0.0), Accepted), (About(1.0609e-3), own(OutOfRange)), (About(1.35e-3), overlap), (To(1e6 * h), Accepted), beyond], &[]),
        count("sphere", &["sheet.closed"], &[(To(0.0), Accepted), (To(1.0), Refused(NotPositive, "sheet.radius")), (End, own(UnknownChoice))], &[]),
        choice("ring", &["sheet.closed"], 1.0),
        real("sphere", &["casing.radius"], &[negative, (To(0.0), Accepted), beyond], &[]),
        real("ring", &["casing.radius"], &[negative, (About(RING + 1.2e-9), Accepted), beyond], &[RING, 0.9 * RING]),
        real("case", &["casing.window_place[0]"], &[(About(-5.0 * h), own(OutOfRange)), (About(5.0 * h), Accepted), beyond], &[]),
        real("case", &["casing.window_place[1]"], &[negative, (About(5.0 * h), Accepted), beyond], &[]),
        not_read("ring", &["casing.window_angle[0]", "casing.window_place[1]"]),
        real("ring", &["sheet.pre_strain[0]"], &[negative, (To(0.0), Accepted), (Below(1.03 - 1.0), Refused(NotInEquilibrium, "yarn.draw")), beyond], &[]),
        // ---- Attachment.
        choice("corners", &["attachment.kind"], 3.0),
        real("corners", &["attachment.disc_inset"], &[negative, (About(5.29e-3), Accepted), (About(7.18e-3), Refused(DiscTouchesProjectile, "attachment.disc_radius")), (End, Refused(DiscsOverlap, "attachment.disc_radius"))], &[5e-3, 6e-3, 7.5e-3]),
        real("corners", &["attachment.disc_radius"], &[not_positive, (About(3.88e-4), own(HoldsNothing)), (About(6.87e-3), Accepted), (About(6.98e-3), own(DiscTouchesProjectile)), (End, own(DiscsOverlap))], &[3.8e-4, 3.9e-4, 6e-3, 6.9e-3, 8e-3]),
        not_read("sphere", &["attachment.disc_inset", "attachment.disc_radius"]),
        real("sphere", &["attachment.grip"], &[negative, (To(0.0), Accepted), (End, own(OutOfRange))], &[]),
        real("clamped", &["attachment.grip"], &[negative, (End, Accepted)], &[]),
        real("sphere", &["attachment.hold", "attachment.strength"], &[negative, (End, Accepted)], &[]),
        real("theta", &["attachment.hold", "attachment.strength"], &[negative, (To(0.0), Accepted), (End, apart)], &[]),
        // ---- Projectile. No free node inside it at the start; its kinetic energy at any speed is a number.
        count("bullet", &["projectile.shape"], &[(To(3.0), Accepted), (To(4.0), Refused(NotPositive, "projectile.moments")), (To(5.0), Accepted), (End, own(UnknownChoice))], &[]),
        real("sphere", &["projectile.radius"], &[not_positive, (Below(h), own(ProjectileTooSmall)), (About(7e-3), Accepted), (About(1e150), overlap), (End, too_heavy)], &[6.9e-3, 7.1e-3]),
        real("cylinder", &["projectile.radius"], &[not_positive, (Below(h), own(ProjectileTooSmall)), (About(1e150), Accepted), (End, too_heavy)], &[]),
        real("cylinder", &["projectile.length"], &line(&at_least_two, &[(About(0.014), Accepted), (About(1e150), overlap), (End, too_heavy)]), &[0.0139, 0.0141]),
        real("bullet", &["projectile.radius"], &[not_positive, (Below(h), own(ProjectileTooSmall)), (To(0.0127), Accepted), (End, Refused(OutOfRange, "projectile.length"))], &[]),
        real("bullet", &["projectile.length"], &line(&at_least_two, &[(Below(6.35e-3), own(OutOfRange)), (About(0.03), Accepted), (About(1e150), overlap), (End, too_heavy)]), &[0.02, 0.06]),
        not_read("sphere", &["projectile.sector.inner_radius", "projectile.sector.outer_radius", "projectile.sector.angle", "projectile.sector.thickness"]),
        real("sector", &["projectile.sector.inner_radius"], &[negative, (To(0.0), Accepted), (Below(1e-6 * 0.04), own(OutOfRange)), (To((1.0 - 1e-6) * 0.04), Accepted), beyond], &[]),
        real("sector", &["projectile.sector.outer_radius"], &[not_positive, (Below(h), own(ProjectileTooSmall)), (About(0.015), bore), (About(15e3), Accepted), (End, bore)], &[0.0149, 0.0151, 1e4, 2e4]),
        real("sector", &["projectile.sector.angle"], &[(Below(1e-3), own(OutOfRange)), (About(0.0494), Refused(ProjectileTooSmall, "projectile.sector.outer_radius")), (Below(core::f64::consts::PI), Accepted), beyond], &[0.049, 0.05]),
        real("sector", &["projectile.sector.thickness"], &line(&at_least_two, &[(About(0.014), Accepted), (About(1e150), overlap), (About(1e300), too_heavy), (End, own(OutOfRange))]), &[0.0139, 0.0141]),
        not_read("sphere", &["projectile.length", "projectile.size[0]", "projectile.size[1]", "projectile.size[2]", "projectile.moments[0]", "projectile.moments[1]", "projectile.moments[2]", "projectile.faces.planes[0][0]", "projectile.faces.planes[15][3]"]),
        not_read("box", &["projectile.radius", "projectile.length", "projectile.faces.planes[0][0]", "projectile.moments[0]"]),
        not_read("cube", &["projectile.radius", "projectile.length", "projectile.size[1]", "projectile.faces.planes[6][0]", "projectile.faces.planes[15][3]"]),
        real("box", &["projectile.size[0]", "projectile.size[1]"], &line(&at_least_two, &[(About(1e150), Accepted), (End, too_heavy)]), &[]),
        real("box", &["projectile.size[2]"], &line(&at_least_two, &[(About(0.014), Accepted), (About(1e150), overlap), (End, too_heavy)]), &[0.0139, 0.0141]),
        count("cube", &["projectile.faces.count"], &[(Below(4.0), own(OutOfRange)), (To(5.0), Refused(UnboundedFaces, "projectile.faces.planes")), (To(6.0), Accepted), (To(16.0), Refused(BadNormal, "projectile.faces.planes")), beyond], &[]),
        real("cube", &["projectile.faces.planes[0][3]", "projectile.faces.planes[3][3]", "projectile.faces.planes[5][3]"], &[not_positive, (Below(h), own(ProjectileTooSmall)), rest], &[]),
        real("cube", &["projectile.faces.planes[4][3]"], &[not_positive, (Below(h), own(ProjectileTooSmall)), (About(7e-3), Accepted), (End, overlap)], &[]),
        real("cube", &["projectile.faces.planes[0][0]", "projectile.faces.planes[2][1]"], &[(About(-1.000001), own(BadNormal)), (About(-0.999999), own(UnboundedFaces)), (About(0.999999), own(BadNormal)), (About(1.000001), Accepted), (End, own(BadNormal))], &[0.99999, 0.9999995, 1.0000005, 1.00001]),
        real("cube", &["projectile.faces.planes[0][1]", "projectile.faces.planes[4][0]", "projectile.faces.planes[5][1]"], &[(About(-0.001414), own(BadNormal)), (About(0.001414), Accepted), (End, own(BadNormal))], &[0.0014, -0.0014, 0.0015]),
        real("cube", &["projectile.moments[0]", "projectile.moments[1]", "projectile.moments[2]"], &[not_positive, (About(4e-7), Accepted), (End, own(ImpossibleMoments))], &[3.9e-7, 4.1e-7]),
        real("sphere", &["projectile.mass"], &[not_positive, (Below(6.52e-8), own(ProjectileTooLight)), (About(1e297), Accepted), (End, own(OutOfRange))], &[]),
        real("prescribed", &["projectile.mass"], &[(Below(0.0), own(NotPositive)), (To(0.0), Accepted), (Below(6.52e-8), own(ProjectileTooLight)), (About(1e297), Accepted), (End, own(OutOfRange))], &[]),
        real("sphere", &["projectile.position[0]", "projectile.position[1]"], &[rest], &[1e-4]),
        real("sphere", &["projectile.position[2]"], &[(About(-6.35e-3), Accepted), (About(6.35e-3), overlap), rest], &[-6.36e-3, -6.34e-3, 6.34e-3, 6.36e-3]),
        real("sphere", &["projectile.velocity[0]", "projectile.velocity[1]"], &[(About(-fastest), too_fast), (About(fastest), Accepted), (End, too_fast)], &[-1.4e5, 1.4e5, 1.5e5]),
        real("sphere", &["projectile.velocity[2]"], &[(To(-fastest), too_fast), (Below(fastest), Accepted), (End, too_fast)], &[]),
        real("sphere", &["projectile.orientation[0]"], &TURN, &[]),
        real("sphere", &["projectile.orientation[1]", "projectile.orientation[2]", "projectile.orientation[3]"], &turned, &[0.04, -0.05]),
        real("sphere", &["projectile.angular_velocity[0]", "projectile.angular_velocity[1]", "projectile.angular_velocity[2]"], &[(About(-1e150), too_heavy), (About(1e150), Accepted), (End, too_heavy)], &[]),
        real("cylinder", &["projectile.angular_velocity[0]", "projectile.angular_velocity[1]", "projectile.angular_velocity[2]"], &[(About(-1.6e7), too_fast), (About(1.6e7), Accepted), (End, too_fast)], &[1e7, -1e7, 2e7]),
        // ---- Step, integrator and the rest.
        real("sphere", &["time_step.seconds"], &[negative, (To(0.0), Accepted), (About(1e-50), no_step), (To(step_max), Accepted), (End, own(StepTooLarge))], &[1e-52, 1e-30]),
        real("fraction", &["time_step.fraction"], &[not_positive, (About(1e-43), no_step), (To(0.5), Accepted), beyond], &[1e-30]),
        real("unchecked", &["time_step.fraction"], &[not_positive, (About(1e-43), no_step), (About(1e140), Accepted), (End, no_step)], &[]),
        not_read("sphere", &["integrator.theta", "integrator.tolerance", "rotation_rule.theta", "time_step.fraction"]),
        choice("sphere", &["slack_balance"], 1.0),
        count("theta", &["slack_balance"], &[(To(0.0), Accepted), (To(1.0), apart), (End, own(UnknownChoice))], &[]),
        count("rate", &["slack_balance"], &[(To(0.0), Accepted), (To(1.0), apart), (End, own(UnknownChoice))], &[]),
        not_read("sphere", &["stack.gap"]),
        count("hybrid", &["back.plies"], &[(To(2.0), Accepted), beyond], &[]),
        count("sphere", &["back.plies"], &[(To(0.0), Accepted), beyond], &[]),
        real("hybrid", &["back.node_mass"], &[not_positive, (About(1e-299), Refused(StepLimitUnusable, "back.node_mass")), (About(3e-9), too_long), (To(8.4e-3), Accepted), (End, Refused(ProjectileTooLight, "projectile.mass"))], &[1e-20, 1e-6]),
        real("hybrid", &["back.yarn_area"], &[not_positive, (About(1e-296), no_step), (About(3e-6), Accepted), (About(1e290), too_long), (End, Refused(StepLimitUnusable, "back.node_mass"))], &[1e-8, 1e-5]),
        real("hybrid", &["back.yarn_area_y"], &[negative, (To(0.0), Accepted), (About(1e-296), no_step), (About(3e-6), Accepted), (About(1e290), too_long), (End, Refused(StepLimitUnusable, "back.node_mass"))], &[1e-8, 1e-5]),
        real("hybrid", &["back.modulus_mean"], &[not_positive, (About(1.1143e11), Refused(DamageRateTooSmall, "back.damage_intercept")), (About(3e12), Accepted), (About(1e290), too_long), (End, Refused(StepLimitUnusable, "back.node_mass"))], &[1.1e11, 1.2e11, 5e12]),
        real("hybrid", &["back.modulus_sd"], &[negative, (About(1e11), Accepted), (About(1e290), too_long), (End, Refused(StepLimitUnusable, "back.node_mass"))], &[1e9, 1e20]),
        real("hybrid", &["back.damage_slope"], &[(About(-1e297), own(NotFinite)), (About(6.2867e-9), Refused(DamageRateTooSmall, "back.damage_intercept")), (About(1e297), Accepted), (End, own(NotFinite))], &[6.2e-9, 6.3e-9]),
        real("hybrid", &["back.damage_intercept"], &[(Below(3.0 - 7.91e-9 * 140.21e9), own(DamageRateTooSmall)), rest], &[]),
        real("hybrid", &["back.weibull_shape"], &[negative, (To(0.0), Accepted), (Below(1.0), own(OutOfRange)), (To(1000.0), Accepted), beyond], &[]),
        not_read("sphere", &["back.node_mass", "back.yarn_area", "back.yarn_area_y", "back.crimp[0]", "back.modulus_mean", "back.modulus_sd", "back.damage_slope", "back.damage_intercept", "back.damage_sd", "back.critical_stretch", "back.weibull_shape", "back.weibull_gauge_length"]),
        real("stack", &["stack.gap"], &[negative, (To(1e6 * h), Accepted), beyond], &[]),
        count("stack", &["symmetry.mirror_x", "symmetry.mirror_y"], &[(To(0.0), Accepted), (To(1.0), Refused(DoesNotGoWith, "stack.plies")), (End, own(UnknownChoice))], &[]),
        real("stack", &["contact.friction"], &[negative, (To(10.0), Accepted), beyond], &[0.02]),
        count("rate", &["stack.plies"], &[(Below(1.0), own(OutOfRange)), (To(1.0), Accepted), (About(1000.0), Refused(DoesNotGoWith, "yarn.rate_modulus")), beyond], &[]),
        count("theta", &["stack.plies"], &[(Below(1.0), own(OutOfRange)), (To(1.0), Accepted), (To(1000.0), apart), beyond], &[]),
        count("stack", &["stack.plies"], &[(Below(1.0), own(OutOfRange)), (About(1000.0), Accepted), beyond], &[]),
        not_read("sphere", &["yarn.weibull_shape", "yarn.weibull_gauge_length", "yarn.weibull_correlation"]),
        real("sphere", &["yarn.rate_modulus", "yarn.rate_stretch"], &[negative, (To(0.0), Accepted), (To(1.0), Refused(OutOfRange, "yarn.rate_reference")), beyond], &[0.1]),
        not_read("sphere", &["yarn.rate_reference", "yarn.rate_limit"]),
        real("rate", &["yarn.rate_modulus", "yarn.rate_stretch"], &[negative, (To(1.0), Accepted), beyond], &[0.1]),
        real("rate", &["yarn.rate_reference"], &[(Below(1e-9), own(OutOfRange)), (To(170.0), Accepted), (To(1e9), Refused(OutOfRange, "yarn.rate_limit")), beyond], &[1e-8, 1e3]),
        real("rate", &["yarn.rate_limit"], &[(Below(30.0), own(OutOfRange)), (To(1e9), Accepted), beyond], &[1e3]),
        real("rate", &["sheet.pre_strain[0]", "sheet.pre_strain[1]"], &[negative, (To(0.0), Accepted), (End, apart)], &[0.02]),
        real("theta", &["yarn.viscosity_linear"], &[negative, (To(0.0), Accepted), (To(1.0), apart), beyond], &[0.02]),
        real("theta", &["yarn.viscosity_quadratic", "contact.friction"], &[negative, (To(0.0), Accepted), (To(10.0), apart), beyond], &[0.02]),
        real("theta", &["yarn.viscosity_bending"], &[negative, (To(0.0), Accepted), (To(0.2), apart), beyond], &[0.02]),
        real("mirrored", &["projectile.position[0]"], &[(About(-7e-13), Refused(NotSymmetric, "projectile.position")), (About(7e-13), Accepted), (End, Refused(NotSymmetric, "projectile.position"))], &[1e-4]),
    ];
    // What is good or bad by itself.
    for field in FIELDS {
        if !rows.iter().filter(|row| row.kind != Kind::NotRead).flat_map(|row| &row.names).any(|name| field_of(name) == field.name) {
            rows.push(by_itself(field));
        }
    }
    rows
}

/// The row of a number that is good or bad by itself: in a scene that reads it, what the table of parameters
/// says.
fn by_itself(field: &'static Field) -> Row {
    let base = bases().find(|base| (field.read)(&scene(base)) > 0).expect("a sound scene that reads it");
    let own = |code| Refused(code, "");
    let last = match field.place {
        Place::Choice(choice, ..) => Some(choice.items.len() as f64 - 1.0),
        Place::Flag(_) => Some(1.0),
        _ => None,
    };
    let line = match (last, field.range) {
        (Some(last), _) => vec![(To(last), Accepted), (End, own(UnknownChoice))],
        (None, Range::Any) => vec![(End, Accepted)],
        (None, Range::Positive) => vec![(To(0.0), own(NotPositive)), (End, Accepted)],
        (None, Range::NotNegative) => vec![(Below(0.0), own(OutOfRange)), (End, Accepted)],
        (None, Range::Within(a, b)) => vec![(Below(a), own(OutOfRange)), (To(b), Accepted), (End, own(OutOfRange))],
        (None, Range::Above(a, b)) => vec![(To(a), own(OutOfRange)), (To(b), Accepted), (End, own(OutOfRange))],
        (None, Range::Below(a, b)) => vec![(Below(a), own(OutOfRange)), (Below(b), Accepted), (End, own(OutOfRange))],
        (None, Range::Nodes) => {
            let most = f64::from(MAX_NODES_PER_SIDE);
            vec![(Below(2.0), own(OutOfRange)), (To(most), Accepted), (End, own(TooManyNodes))]
        }
        (None, Range::UnitQuaternion) => panic!("{}: a quaternion needs a row of its own", field.name),
    };
    let names = match field.shape() {
        [] => vec![field.name],
        [size] => (0..*size).map(|k| &*format!("{}[{k}]", field.name).leak()).collect(),
        _ => panic!("{}: rows of numbers need a row of their own", field.name),
    };
    Row { base, names, kind: if field.is_real() { Kind::Real } else { Kind::Count }, line, also: &[] }
}

/// Every case.
pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for row in rows() {
        let limits = row.line.iter().filter_map(|(up, _)| match up {
            Below(limit) | To(limit) => Some(*limit),
            About(_) | End => None,
        });
        let mut values: Vec<f64> = match row.kind {
            Kind::Real => limits.flat_map(|x| [x.next_down(), x, x.next_up()]).chain(REALS).collect(),
            Kind::NotRead => REALS.to_vec(),
            Kind::Count => limits.flat_map(|x| [x - 1.0, x, x + 1.0]).chain([0.0, 1.0, f64::from(u32::MAX)]).collect(),
        };
        values.extend(row.also);
        if row.kind != Kind::Count {
            values.extend([f64::NAN, f64::INFINITY, f64::NEG_INFINITY]);
        }
        for name in &row.names {
            let mut seen = Vec::new();
            for &value in &values {
                if seen.contains(&value.to_bits()) || (row.kind == Kind::Count && value < 0.0) {
                    continue;
                }
                seen.push(value.to_bits());
                let expected = if row.kind == Kind::Real && !value.is_finite() {
                    Refused(NotFinite, "")
                } else {
                    along(&row.line, value)
                };
                let expected = match expected {
                    Refused(code, "") => Refused(code, field_of(name)),
                    other => other,
                };
                cases.push(Case { base: row.base, name, value, expected });
            }
        }
    }
    cases
}

/// What is expected at a value.
fn along(line: &[(Up, Expected)], value: f64) -> Expected {
    let within = |up: &Up| match up {
        Below(limit) => value < *limit,
        To(limit) => value <= *limit,
        About(limit) => value < *limit,
        End => true,
    };
    line.iter().find(|(up, _)| within(up)).map_or(Accepted, |(_, expected)| *expected)
}

/// The field that an error names: without indices.
fn field_of(name: &'static str) -> &'static str {
    name.split('[').next().unwrap_or(name)
}

/// A sound scene by its name.
pub fn scene(base: &str) -> Scene {
    let mut scene = Scene::sheet_3in_sphere();
    for (name, value) in assignments(base) {
        assert!(assign(&mut scene, name, value), "{name} = {value}");
    }
    scene
}

/// The names of the sound scenes.
pub fn bases() -> impl Iterator<Item = &'static str> {
    BASES.iter().map(|(name, _)| *name)
}

/// What makes a sound scene of the preset 3 in scene.
fn assignments(base: &str) -> impl Iterator<Item = (&'static str, f64)> {
    let (_, changes) = BASES.iter().find(|(name, _)| *name == base).expect("a sound scene");
    START.iter().chain(*changes).copied()
}

/// Gives a number of a scene a value. false if a `Scene` cannot hold it: an unknown choice.
pub fn assign(scene: &mut Scene, name: &str, value: f64) -> bool {
    let (name, index) = name.split_once('[').unwrap_or((name, "0]"));
    let field = field(name).unwrap_or_else(|| panic!("{name} is no number of a scene"));
    let indices = index.trim_end_matches(']').split("][").map(|text| text.parse::<usize>().expect("an index"));
    // The first of two indices counts rows.
    let row = field.shape().get(1).copied().unwrap_or(1);
    let element = indices.fold(0, |element, index| element * row + index);
    field.set_word(scene, element, field.word_of(value)).is_ok()
}

/// The cases as the text that the C host and the FMI tests read: tests/inputs. Lines of
///
/// - `text CODE WORDS`: what a code is called,
/// - `set BASE NAME BITS`: a change of the preset that makes a sound scene,
/// - `case BASE NAME BITS CODE FIELD`: a change of that scene, and what is expected (0 and `-` if it is
///   accepted).
///
/// NAME is the path in `fk_scene`, BITS are those of the value as an f64.
pub fn listed() -> String {
    use std::fmt::Write;
    let mut text = String::from(
        "# Written by `cargo run -p fabric-tests --bin inputs`: do not edit. tests/src/inputs.rs says what it is.\n",
    );
    let mut line = |line: std::fmt::Arguments<'_>| writeln!(text, "{line}").expect("a string takes all");
    for code in Code::ALL {
        line(format_args!("text {} {}", code.number(), code.text().to_str().expect("plain")));
    }
    for (base, _) in BASES {
        for (name, value) in assignments(base) {
            line(format_args!("set {base} {name} {:016x}", value.to_bits()));
        }
    }
    for Case { base, name, value, expected } in cases() {
        let (code, field) = match expected {
            Accepted => (0, "-"),
            Refused(code, field) => (code.number(), field),
        };
        line(format_args!("case {base} {name} {:016x} {code} {field}", value.to_bits()));
    }
    text
}
