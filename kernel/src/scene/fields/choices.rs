//! Choices of a scene: each an enum, and a table of its items with their names and meanings.

/// A choice among named numbers 0, 1, 2, ...
#[derive(Debug, PartialEq)]
pub struct Choice {
    /// Name of the type.
    pub name: &'static str,
    /// Name and meaning of each number.
    pub items: &'static [(&'static str, &'static str)],
}

/// Enum of a choice, its table, and all its items in the order of their numbers.
macro_rules! choice {
    ($(#[$about:meta])* $kind:ident, $title:literal: $($item:ident, $name:literal, $meaning:literal;)+) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u32)]
        pub enum $kind {
            $(#[doc = $meaning] $item,)+
        }

        impl $kind {
            pub(super) const CHOICE: Choice = Choice { name: $title, items: &[$(($name, $meaning)),+] };
            pub(super) const ALL: &'static [$kind] = &[$($kind::$item),+];
        }
    };
}

choice! {
    /// Which nodes are fixed.
    AttachmentKind, "Attachment":
    TwoSides, "two_sides", "first and last column (left and right)";
    FourSides, "four_sides", "the whole edge";
    FourCorners, "four_corners", "discs near the four corners";
    Free, "free", "nothing";
}

choice! {
    /// Unit that gets a sample of its own.
    Draw, "Draw":
    Segment, "segment", "every segment";
    Yarn, "yarn", "every woven yarn: a whole row or column of segments";
}

choice! {
    /// Critical stretch of a segment.
    StrengthDraw, "StrengthDraw":
    None, "none", "every segment has yarn.critical_stretch";
    Weibull, "weibull", "every segment has its own: U_c - 1 has a Weibull distribution";
}

choice! {
    /// The projectile's form.
    Shape, "Shape":
    Sphere, "sphere", "sphere; feels no torque without friction";
    Cylinder, "cylinder", "flat-ended cylinder along the body's z axis";
    HemisphericalCylinder, "hemispherical_cylinder", "cylinder along the body's z axis with a hemisphere at its +z end";
    Box, "box", "box with its edges along the body's axes";
    Polyhedron, "polyhedron", "convex polyhedron by its faces";
    DiscSector, "disc_sector", "sector of a turbine disc, its rim along x and the disc's axis along z";
}

choice! {
    /// Who moves the projectile.
    Drive, "Drive":
    Free, "free", "the model moves the projectile under contact and the external load";
    Prescribed, "prescribed", "the host moves the projectile; the model gives force, impulse and work";
}

choice! {
    /// Integrator of the nodes.
    IntegratorKind, "Integrator":
    Verlet, "verlet", "velocity Verlet, explicit";
    Theta, "theta", "the paper's theta rule by fixed-point iteration: the reference method";
}

choice! {
    /// Whether the time step is checked.
    StepCheck, "StepCheck":
    Refuse, "refuse", "a step above 0.5 dt_crit is refused";
    None, "none", "no check, for stability studies only: wrong results without a warning";
}

choice! {
    /// Rule for the projectile's rotation.
    RotationKind, "Rotation":
    Midpoint, "midpoint", "implicit midpoint rule, which keeps energy and angular momentum";
    Theta, "theta", "the paper's theta rule, which does not conserve";
}

/// Every choice of a scene.
pub const CHOICES: &[&Choice] = &[
    &AttachmentKind::CHOICE,
    &Draw::CHOICE,
    &StrengthDraw::CHOICE,
    &Shape::CHOICE,
    &Drive::CHOICE,
    &IntegratorKind::CHOICE,
    &StepCheck::CHOICE,
    &RotationKind::CHOICE,
];
