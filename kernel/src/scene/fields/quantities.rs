//! Kinds of real numbers: their units.

/// Kind of a real parameter.
#[derive(Debug, PartialEq)]
pub struct Quantity {
    /// Name, as the type definitions of the FMUs have it.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Unit in which a program may show it; empty for the unit itself.
    pub display: &'static str,
    /// Least value of any such number; minus infinity if there is none.
    pub least: f64,
    /// Typical size.
    pub nominal: f64,
    /// Meaning.
    pub description: &'static str,
}

/// Text of the program.
pub(crate) type Str = &'static str;

/// A quantity.
pub const fn quantity(name: Str, unit: Str, display: Str, least: f64, nominal: f64, description: Str) -> Quantity {
    Quantity { name, unit, display, least, nominal, description }
}

/// Quantity of either sign.
pub const ANY_SIGN: f64 = f64::NEG_INFINITY;
/// Place or displacement.
pub const POSITION: Quantity = quantity("Position", "m", "mm", ANY_SIGN, 1e-3, "Place or displacement");
/// Size of a thing.
pub const LENGTH: Quantity = quantity("Length", "m", "mm", 0.0, 1e-2, "Size of a thing");
/// Cross-section.
pub const AREA: Quantity = quantity("Area", "m2", "mm2", 0.0, 1e-7, "Cross-section of a yarn");
/// Velocity.
pub const VELOCITY: Quantity = quantity("Velocity", "m/s", "", ANY_SIGN, 100.0, "Velocity");
/// Angle.
pub const ANGLE: Quantity = quantity("Angle", "rad", "deg", 0.0, 1.0, "Angle");
/// Angular velocity.
pub const ANGULAR_VELOCITY: Quantity =
    quantity("AngularVelocity", "rad/s", "deg/s", ANY_SIGN, 100.0, "Angular velocity");
/// Element of a quaternion.
pub const QUATERNION: Quantity =
    quantity("Quaternion", "1", "", ANY_SIGN, 1.0, "Element of a unit quaternion, scalar first");
/// Number without unit.
pub const RATIO: Quantity = quantity("Ratio", "1", "", ANY_SIGN, 1.0, "Number without unit");
/// Mass.
pub const MASS: Quantity = quantity("Mass", "kg", "g", 0.0, 1e-2, "Mass");
/// Moment of inertia.
pub const INERTIA: Quantity = quantity("Inertia", "kg.m2", "", 0.0, 1e-6, "Moment of inertia");
/// Young's modulus.
pub const MODULUS: Quantity = quantity("Modulus", "Pa", "GPa", 0.0, 1e11, "Young's modulus of a yarn");
/// Damage rate per modulus.
pub const DAMAGE_SLOPE: Quantity = quantity("DamageSlope", "1/Pa", "1/GPa", ANY_SIGN, 1e-9, "Damage rate per modulus");
/// Rate of strain.
pub const STRAIN_RATE: Quantity = quantity("StrainRate", "1/s", "", 0.0, 100.0, "Rate of strain");
/// Force.
pub const FORCE: Quantity = quantity("Force", "N", "kN", ANY_SIGN, 1e4, "Force");
/// Length of time.
pub const DURATION: Quantity = quantity("Duration", "s", "us", 0.0, 1e-6, "Length of time");
