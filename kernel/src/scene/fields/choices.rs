//! Choices of a scene: the names of their items, and what the scene calls them.

use crate::scene::parts::{AttachmentKind, Draw, Drive, IntegratorKind, RotationKind, Shape, StepCheck, StrengthDraw};

/// A choice among named numbers 0, 1, 2, ...
#[derive(Debug, PartialEq)]
pub struct Choice {
    /// Name of the type.
    pub name: &'static str,
    /// Name and meaning of each number.
    pub items: &'static [(&'static str, &'static str)],
}

/// Item as the scene calls it, its name and its meaning.
pub(super) type Named<T> = (T, (&'static str, &'static str));

const fn words<T, const N: usize>(all: &[Named<T>; N]) -> [(&'static str, &'static str); N] {
    let (mut words, mut k) = ([("", ""); N], 0);
    while k < N {
        words[k] = all[k].1;
        k += 1;
    }
    words
}

/// Which nodes are held.
pub const ATTACHMENT: Choice = Choice { name: "Attachment", items: &words(&ATTACHMENTS) };
pub(super) const ATTACHMENTS: [Named<AttachmentKind>; 4] = [
    (AttachmentKind::TwoSides, ("two_sides", "first and last column (left and right)")),
    (AttachmentKind::FourSides, ("four_sides", "the whole edge")),
    (AttachmentKind::FourCorners, ("four_corners", "discs near the four corners")),
    (AttachmentKind::Free, ("free", "nothing")),
];

/// Unit that gets a sample of its own.
pub const DRAW: Choice = Choice { name: "Draw", items: &words(&DRAWS) };
pub(super) const DRAWS: [Named<Draw>; 2] = [
    (Draw::Segment, ("segment", "every segment")),
    (Draw::Yarn, ("yarn", "every woven yarn: a whole row or column of segments")),
];

/// Critical stretch of a segment.
pub const STRENGTH_DRAW: Choice = Choice { name: "StrengthDraw", items: &words(&STRENGTH_DRAWS) };
pub(super) const STRENGTH_DRAWS: [Named<StrengthDraw>; 2] = [
    (StrengthDraw::None, ("none", "every segment has yarn.critical_stretch")),
    (StrengthDraw::Weibull, ("weibull", "every segment has its own: U_c - 1 has a Weibull distribution")),
];

/// The projectile's form.
pub const SHAPE: Choice = Choice { name: "Shape", items: &words(&SHAPES) };
pub(super) const SHAPES: [Named<Shape>; 6] = [
    (Shape::Sphere, ("sphere", "sphere; feels no torque without friction")),
    (Shape::Cylinder, ("cylinder", "flat-ended cylinder along the body's z axis")),
    (
        Shape::HemisphericalCylinder,
        ("hemispherical_cylinder", "cylinder along the body's z axis with a hemisphere at its +z end"),
    ),
    (Shape::Box, ("box", "box with its edges along the body's axes")),
    (Shape::Polyhedron, ("polyhedron", "convex polyhedron by its faces")),
    (Shape::DiscSector, ("disc_sector", "sector of a turbine disc, its rim along x and the disc's axis along z")),
];

/// Who moves the projectile.
pub const DRIVE: Choice = Choice { name: "Drive", items: &words(&DRIVES) };
pub(super) const DRIVES: [Named<Drive>; 2] = [
    (Drive::Free, ("free", "the model moves the projectile under contact and the external load")),
    (Drive::Prescribed, ("prescribed", "the host moves the projectile; the model gives force, impulse and work")),
];

/// Integrator of the nodes.
pub const INTEGRATOR: Choice = Choice { name: "Integrator", items: &words(&INTEGRATORS) };
pub(super) const INTEGRATORS: [Named<IntegratorKind>; 2] = [
    (IntegratorKind::Verlet, ("verlet", "velocity Verlet, explicit")),
    (IntegratorKind::Theta, ("theta", "the paper's theta rule by fixed-point iteration: the reference method")),
];

/// Whether the time step is checked.
pub const STEP_CHECK: Choice = Choice { name: "StepCheck", items: &words(&STEP_CHECKS) };
pub(super) const STEP_CHECKS: [Named<StepCheck>; 2] = [
    (StepCheck::Refuse, ("refuse", "a step above 0.5 dt_crit is refused")),
    (StepCheck::None, ("none", "no check, for stability studies only: wrong results without a warning")),
];

/// Rule for the projectile's rotation.
pub const ROTATION: Choice = Choice { name: "Rotation", items: &words(&ROTATIONS) };
pub(super) const ROTATIONS: [Named<RotationKind>; 2] = [
    (RotationKind::Midpoint, ("midpoint", "implicit midpoint rule, which keeps energy and angular momentum")),
    (RotationKind::Theta, ("theta", "the paper's theta rule, which does not conserve")),
];

/// Every choice of a scene.
pub const CHOICES: &[&Choice] =
    &[&ATTACHMENT, &DRAW, &STRENGTH_DRAW, &SHAPE, &DRIVE, &INTEGRATOR, &STEP_CHECK, &ROTATION];
