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

/// Which nodes are held.
pub const ATTACHMENT: Choice = Choice {
    name: "Attachment",
    items: &[
        ("two_sides", "first and last column (left and right)"),
        ("four_sides", "the whole edge"),
        ("four_corners", "discs near the four corners"),
        ("free", "nothing"),
    ],
};
pub(super) const ATTACHMENTS: [AttachmentKind; 4] =
    [AttachmentKind::TwoSides, AttachmentKind::FourSides, AttachmentKind::FourCorners, AttachmentKind::Free];

/// What gets a sample of its own.
pub const DRAW: Choice = Choice {
    name: "Draw",
    items: &[("segment", "every segment"), ("yarn", "every woven yarn: a whole row or column of segments")],
};
pub(super) const DRAWS: [Draw; 2] = [Draw::Segment, Draw::Yarn];

/// What the critical stretch of a segment is.
pub const STRENGTH_DRAW: Choice = Choice {
    name: "StrengthDraw",
    items: &[
        ("none", "every segment has yarn.critical_stretch"),
        ("weibull", "every segment has its own: U_c - 1 has a Weibull distribution"),
    ],
};
pub(super) const STRENGTH_DRAWS: [StrengthDraw; 2] = [StrengthDraw::None, StrengthDraw::Weibull];

/// The projectile's form.
pub const SHAPE: Choice = Choice {
    name: "Shape",
    items: &[
        ("sphere", "sphere; feels no torque without friction"),
        ("cylinder", "flat-ended cylinder along the body's z axis"),
        ("hemispherical_cylinder", "cylinder along the body's z axis with a hemisphere at its +z end"),
        ("box", "box with its edges along the body's axes"),
        ("polyhedron", "convex polyhedron by its faces"),
        ("disc_sector", "sector of a turbine disc, its rim along x and the disc's axis along z"),
    ],
};
pub(super) const SHAPES: [Shape; 6] =
    [Shape::Sphere, Shape::Cylinder, Shape::HemisphericalCylinder, Shape::Box, Shape::Polyhedron, Shape::DiscSector];

/// Who moves the projectile.
pub const DRIVE: Choice = Choice {
    name: "Drive",
    items: &[
        ("free", "the model moves the projectile under contact and the external load"),
        ("prescribed", "the host moves the projectile; the model gives force, impulse and work"),
    ],
};
pub(super) const DRIVES: [Drive; 2] = [Drive::Free, Drive::Prescribed];

/// How the nodes are stepped.
pub const INTEGRATOR: Choice = Choice {
    name: "Integrator",
    items: &[
        ("verlet", "velocity Verlet, explicit"),
        ("theta", "the paper's theta rule by fixed-point iteration: the reference method"),
    ],
};
pub(super) const INTEGRATORS: [IntegratorKind; 2] = [IntegratorKind::Verlet, IntegratorKind::Theta];

/// Whether the time step is checked.
pub const STEP_CHECK: Choice = Choice {
    name: "StepCheck",
    items: &[
        ("refuse", "a step above 0.5 dt_crit is refused"),
        ("none", "no check, for stability studies only: wrong results without a warning"),
    ],
};
pub(super) const STEP_CHECKS: [StepCheck; 2] = [StepCheck::Refuse, StepCheck::None];

/// How the projectile turns.
pub const ROTATION: Choice = Choice {
    name: "Rotation",
    items: &[
        ("midpoint", "implicit midpoint rule, which keeps energy and angular momentum"),
        ("theta", "the paper's theta rule, which does not conserve"),
    ],
};
pub(super) const ROTATIONS: [RotationKind; 2] = [RotationKind::Midpoint, RotationKind::Theta];

/// Every choice of a scene.
pub const CHOICES: &[&Choice] =
    &[&ATTACHMENT, &DRAW, &STRENGTH_DRAW, &SHAPE, &DRIVE, &INTEGRATOR, &STEP_CHECK, &ROTATION];
