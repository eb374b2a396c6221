//! The variables: one table from which getters, setters, both model descriptions and the token come.
//!
//! A variable's value reference never changes once released; a new variable takes a new one. In FMI 3.0 an array has the
//! table's reference; in FMI 2.0 its elements have that reference and the following ones, row by row.

/// Names a variable in code. `VARIABLES[id as usize]` is its row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // described in the table
#[repr(usize)]
pub enum Id {
    // Inputs.
    Position,
    Velocity,
    Orientation,
    AngularVelocity,
    Acceleration,
    ExternalForce,
    ExternalTorque,
    // Parameters.
    Mode,
    Preset,
    Shape,
    Radius,
    Length,
    Mass,
    Size,
    NodesX,
    NodesY,
    Spacing,
    NodeMass,
    YarnArea,
    Plies,
    SheetPosition,
    SheetOrientation,
    AttachmentKind,
    DiscInset,
    DiscRadius,
    ModulusMean,
    ModulusSd,
    DamageSlope,
    DamageIntercept,
    DamageSd,
    CriticalStretch,
    AlphaFail,
    Stochastic,
    Seed,
    Dt,
    ForceWindow,
    TrackDetachment,
    StopOnEvent,
    LogLevel,
    // Outputs.
    ForceMean,
    TorqueMean,
    ForcePeak,
    Impulse,
    AngularImpulse,
    Work,
    SupportImpulse,
    AttachmentImpulse,
    StatePosition,
    StateVelocity,
    StateOrientation,
    StateAngularVelocity,
    EnergyKinetic,
    EnergyStrain,
    EnergyDissipated,
    EnergyContactLoss,
    EnergyResidual,
    InterfaceResidual,
    MaxDeflection,
    MaxStretch,
    FailedSegments,
    WorstPenetration,
    MomentumResidual,
    StepFraction,
    Unconverged,
    Status,
    TimeFirstContact,
    TimeEvent,
}

/// A choice among named numbers 0, 1, 2, ...
#[derive(Debug, PartialEq)]
pub struct Choice {
    /// Name of the type.
    pub name: &'static str,
    /// Name and meaning of each number.
    pub items: &'static [(&'static str, &'static str)],
}

/// Type of a variable: Real/Float64, Integer/Int32, Boolean or Enumeration.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs)]
pub enum Kind {
    Real,
    Integer,
    Boolean,
    Choice(&'static Choice),
}

/// Who gives the value, and when.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Continuous input.
    Input,
    /// Parameter, fixed once initialisation ends.
    Fixed,
    /// Parameter that may change at any time.
    Tunable,
    /// Continuous output.
    Continuous,
    /// Output that changes at events or is a count.
    Discrete,
}

impl Role {
    /// Whether the FMU computes it.
    pub fn is_output(self) -> bool {
        matches!(self, Role::Continuous | Role::Discrete)
    }
}

/// One row of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variable {
    /// Name in code.
    pub id: Id,
    /// Name in both model descriptions.
    pub name: &'static str,
    /// Value reference (of the first element).
    pub reference: u32,
    /// Type.
    pub kind: Kind,
    /// Role.
    pub role: Role,
    /// Dimensions; empty for a scalar.
    pub shape: &'static [usize],
    /// What kind of number a Real is; None for the other types.
    pub quantity: Option<&'static Quantity>,
    /// Start values of inputs and parameters, one per element; empty for outputs.
    pub start: &'static [f64],
    /// Least and greatest value, if they are not those of the quantity.
    pub range: Option<[f64; 2]>,
    /// Typical size, if it is not that of the quantity; 0 otherwise.
    pub nominal: f64,
    /// Meaning.
    pub description: &'static str,
}

impl Variable {
    /// Number of elements.
    pub const fn size(&self) -> usize {
        let mut size = 1;
        let mut k = 0;
        while k < self.shape.len() {
            size *= self.shape[k];
            k += 1;
        }
        size
    }

    /// Least and greatest value: the variable's own, or those of its quantity or choice.
    pub fn limits(&self) -> [f64; 2] {
        match (self.range, self.quantity, self.kind) {
            (Some(range), _, _) => range,
            (None, Some(quantity), _) => [quantity.least, f64::INFINITY],
            (None, None, Kind::Choice(choice)) => [0.0, choice.items.len() as f64 - 1.0],
            (None, None, _) => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    const fn shaped(mut self, shape: &'static [usize]) -> Variable {
        self.shape = shape;
        self
    }

    const fn range(mut self, least: f64, greatest: f64) -> Variable {
        self.range = Some([least, greatest]);
        self
    }

    const fn nominal(mut self, nominal: f64) -> Variable {
        self.nominal = nominal;
        self
    }
}

type Text = &'static str;
type OfQuantity = &'static Quantity;

const fn row(id: Id, name: Text, reference: u32, kind: Kind, role: Role, description: Text) -> Variable {
    let (shape, quantity, start): (&[usize], _, &[f64]) = (&[], None, &[]);
    Variable { id, name, reference, kind, role, shape, quantity, start, range: None, nominal: 0.0, description }
}

const fn input(id: Id, name: Text, reference: u32, of: OfQuantity, start: &'static [f64], about: Text) -> Variable {
    let shape: &[usize] = if start.len() == 4 { &[4] } else { &[3] };
    Variable { quantity: Some(of), start, shape, ..row(id, name, reference, Kind::Real, Role::Input, about) }
}

const fn real(id: Id, name: Text, reference: u32, of: OfQuantity, start: &'static [f64], about: Text) -> Variable {
    Variable { quantity: Some(of), start, ..row(id, name, reference, Kind::Real, Role::Fixed, about) }
}

const fn parameter(id: Id, name: Text, reference: u32, kind: Kind, start: &'static [f64], about: Text) -> Variable {
    Variable { start, ..row(id, name, reference, kind, Role::Fixed, about) }
}

const fn tunable(id: Id, name: Text, reference: u32, kind: Kind, start: &'static [f64], about: Text) -> Variable {
    Variable { start, ..row(id, name, reference, kind, Role::Tunable, about) }
}

const fn output(id: Id, name: Text, reference: u32, of: OfQuantity, about: Text) -> Variable {
    Variable { quantity: Some(of), ..row(id, name, reference, Kind::Real, Role::Continuous, about) }
}

const fn discrete(id: Id, name: Text, reference: u32, kind: Kind, about: Text) -> Variable {
    row(id, name, reference, kind, Role::Discrete, about)
}

const fn time(id: Id, name: Text, reference: u32, about: Text) -> Variable {
    Variable { quantity: Some(&TIME), ..row(id, name, reference, Kind::Real, Role::Discrete, about) }
}

/// Who moves the projectile.
pub const MODE: Choice = Choice {
    name: "Mode",
    items: &[
        ("integrated", "the FMU moves the projectile under contact and the external load"),
        ("host_driven", "the host moves the projectile; the FMU gives force, impulse and work"),
    ],
};

/// Where parameters come from that the host does not set.
pub const PRESET: Choice = Choice {
    name: "Preset",
    items: &[
        ("sheet_10in_cylinder", "10 in sheet of 350 x 350 nodes, two sides held, 37 g flat-ended cylinder"),
        ("sheet_3in_sphere", "3 in sheet of 105 x 105 nodes, four sides held, 8.4 g sphere"),
        ("custom", "the start values of the parameters themselves"),
    ],
};

/// The projectile's form.
pub const SHAPE: Choice = Choice {
    name: "Shape",
    items: &[
        ("sphere", "sphere; feels no torque"),
        ("cylinder", "flat-ended cylinder along the body's z axis"),
        ("hemispherical_cylinder", "cylinder along the body's z axis with a hemisphere at its +z end"),
        ("box", "box with its edges along the body's axes"),
    ],
};

/// Which nodes are held.
pub const ATTACHMENT: Choice = Choice {
    name: "AttachmentKind",
    items: &[
        ("two_sides", "first and last column (left and right)"),
        ("four_sides", "the whole edge"),
        ("four_corners", "discs near the four corners"),
        ("free", "nothing"),
    ],
};

/// What has become of the projectile.
pub const STATUS: Choice = Choice {
    name: "Status",
    items: &[
        ("flight", "no contact in the last internal step and no outcome yet"),
        ("contact", "contact in the last internal step"),
        ("arrested", "stopped along its direction at first contact"),
        ("detached", "the nodes under the projectile have lost every connection to a support"),
        ("exited", "the projectile goes on and its contact with the fabric is over"),
        ("passed", "no contact, and none to come: the projectile leaves the sheet's box for good"),
        ("faulted", "the computation cannot go on: see the log; reset or restore a state"),
    ],
};

/// The choices, for the type definitions.
pub const CHOICES: &[&Choice] = &[&MODE, &PRESET, &SHAPE, &ATTACHMENT, &STATUS];

/// A unit in terms of kg, m, s and rad, with the display units hosts may offer (name and factor).
pub struct Unit {
    /// Name.
    pub name: &'static str,
    /// Exponents of kg, m, s, rad.
    pub exponents: [i32; 4],
    /// Display units: name, and how many of them make one unit.
    pub display: &'static [(&'static str, f64)],
}

const fn unit(name: &'static str, exponents: [i32; 4], display: &'static [(&'static str, f64)]) -> Unit {
    Unit { name, exponents, display }
}

/// Every unit in use.
pub const UNITS: &[Unit] = &[
    unit("1", [0, 0, 0, 0], &[]),
    unit("1/Pa", [-1, 1, 2, 0], &[("1/GPa", 1e9)]),
    unit("J", [1, 2, -2, 0], &[("mJ", 1e3)]),
    unit("N", [1, 1, -2, 0], &[("kN", 1e-3)]),
    unit("N.m", [1, 2, -2, 0], &[]),
    unit("N.m.s", [1, 2, -1, 0], &[]),
    unit("N.s", [1, 1, -1, 0], &[]),
    unit("Pa", [1, -1, -2, 0], &[("GPa", 1e-9)]),
    unit("kg", [1, 0, 0, 0], &[("g", 1e3)]),
    unit("m", [0, 1, 0, 0], &[("mm", 1e3)]),
    unit("m/s", [0, 1, -1, 0], &[]),
    unit("m/s2", [0, 1, -2, 0], &[]),
    unit("m2", [0, 2, 0, 0], &[("mm2", 1e6)]),
    unit("rad/s", [0, 0, -1, 1], &[("deg/s", 180.0 / core::f64::consts::PI)]),
    unit("s", [0, 0, 1, 0], &[("us", 1e6)]),
];

/// What kind of number a Real is: a type definition of both model descriptions.
#[derive(Debug, PartialEq)]
pub struct Quantity {
    /// Name of the type.
    pub name: &'static str,
    /// Unit, one of [`UNITS`].
    pub unit: &'static str,
    /// Unit hosts should show, one of the unit's display units; empty for the unit itself.
    pub display: &'static str,
    /// Least value; minus infinity if there is none.
    pub least: f64,
    /// Typical size.
    pub nominal: f64,
    /// Meaning.
    pub description: &'static str,
}

const fn quantity(name: Text, unit: Text, display: Text, least: f64, nominal: f64, description: Text) -> Quantity {
    Quantity { name, unit, display, least, nominal, description }
}

const ANY_SIGN: f64 = f64::NEG_INFINITY;
const POSITION: Quantity = quantity("Position", "m", "mm", ANY_SIGN, 1e-3, "Place or displacement");
const LENGTH: Quantity = quantity("Length", "m", "mm", 0.0, 1e-2, "Size of a thing");
const AREA: Quantity = quantity("Area", "m2", "mm2", 0.0, 1e-7, "Cross-section of a yarn");
const VELOCITY: Quantity = quantity("Velocity", "m/s", "", ANY_SIGN, 100.0, "Velocity");
const ACCELERATION: Quantity = quantity("Acceleration", "m/s2", "", ANY_SIGN, 1e5, "Acceleration");
const ANGULAR_VELOCITY: Quantity = quantity("AngularVelocity", "rad/s", "deg/s", ANY_SIGN, 100.0, "Angular velocity");
const QUATERNION: Quantity =
    quantity("Quaternion", "1", "", ANY_SIGN, 1.0, "Element of a unit quaternion, scalar first");
const RATIO: Quantity = quantity("Ratio", "1", "", ANY_SIGN, 1.0, "Number without unit");
const MASS: Quantity = quantity("Mass", "kg", "g", 0.0, 1e-2, "Mass");
const FORCE: Quantity = quantity("Force", "N", "kN", ANY_SIGN, 1e4, "Force");
const TORQUE: Quantity = quantity("Torque", "N.m", "", ANY_SIGN, 10.0, "Torque");
const IMPULSE: Quantity = quantity("Impulse", "N.s", "", ANY_SIGN, 1.0, "Force over time");
const ANGULAR_IMPULSE: Quantity = quantity("AngularImpulse", "N.m.s", "", ANY_SIGN, 1e-3, "Torque over time");
const ENERGY: Quantity = quantity("Energy", "J", "", ANY_SIGN, 10.0, "Energy or work");
const MODULUS: Quantity = quantity("Modulus", "Pa", "GPa", 0.0, 1e11, "Young's modulus of a yarn");
const DAMAGE_SLOPE: Quantity = quantity("DamageSlope", "1/Pa", "1/GPa", ANY_SIGN, 1e-9, "Damage rate per modulus");
const DURATION: Quantity = quantity("Duration", "s", "us", 0.0, 1e-6, "Length of time");
const TIME: Quantity = quantity("Time", "s", "us", ANY_SIGN, 1e-3, "Point in time");

/// Every quantity in use, for the type definitions.
pub const QUANTITIES: &[&Quantity] = &[
    &POSITION,
    &LENGTH,
    &AREA,
    &VELOCITY,
    &ACCELERATION,
    &ANGULAR_VELOCITY,
    &QUATERNION,
    &RATIO,
    &MASS,
    &FORCE,
    &TORQUE,
    &IMPULSE,
    &ANGULAR_IMPULSE,
    &ENERGY,
    &MODULUS,
    &DAMAGE_SLOPE,
    &DURATION,
    &TIME,
];

/// Log categories: name and meaning.
pub const LOG_CATEGORIES: &[(&str, &str)] = &[
    ("logEvents", "First contact, outcomes, initialisation"),
    ("logStatusWarning", "What was put right or may surprise"),
    ("logStatusDiscard", "Steps refused with nothing changed"),
    ("logStatusError", "Calls refused, and failures"),
    ("logStatusFatal", "No memory for an instance"),
    ("logAll", "All of these"),
];

/// Default end of a run, s: the default projectile has left the sheet.
pub const DEFAULT_STOP_TIME: f64 = 1e-3;
/// Default communication step, s.
pub const DEFAULT_STEP_SIZE: f64 = 1e-6;
/// Default internal step, s; the start value of `dt`.
pub const DEFAULT_DT: f64 = 2e-8;

const ZERO: &[f64] = &[0.0, 0.0, 0.0];
const ONE_TURN: &[f64] = &[1.0, 0.0, 0.0, 0.0];
const LARGEST: f64 = i32::MAX as f64;

/// Every variable but `time`.
pub const VARIABLES: &[Variable] = &[
    input(
        Id::Position,
        "projectile.position",
        100,
        &POSITION,
        &[0.0, 0.0, -(0.0381 / 2.0 + 1e-3)],
        "Centre of mass, host's axes. If never set: nose 1 mm before the sheet. Mode integrated reads it when initialisation \
         ends; mode host_driven at every step",
    ),
    input(
        Id::Velocity,
        "projectile.velocity",
        110,
        &VELOCITY,
        &[0.0, 0.0, 100.0],
        "Velocity of the centre of mass. Read like projectile.position",
    ),
    input(
        Id::Orientation,
        "projectile.orientation",
        120,
        &QUATERNION,
        ONE_TURN,
        "Unit quaternion, scalar first, that turns body vectors into the host's axes. Read like projectile.position",
    ),
    input(
        Id::AngularVelocity,
        "projectile.angular_velocity",
        130,
        &ANGULAR_VELOCITY,
        ZERO,
        "Angular velocity in the host's axes. Read like projectile.position",
    ),
    input(
        Id::Acceleration,
        "projectile.acceleration",
        140,
        &ACCELERATION,
        ZERO,
        "Optional, mode host_driven: acceleration expected over the step. If zero: last mean force over projectile.mass",
    ),
    input(
        Id::ExternalForce,
        "external.force",
        150,
        &FORCE,
        ZERO,
        "Mode integrated: force at the centre of mass, held over the step (gravity, drag)",
    )
    .nominal(1.0),
    input(
        Id::ExternalTorque,
        "external.torque",
        160,
        &TORQUE,
        ZERO,
        "Mode integrated: torque about the centre of mass, held over the step",
    )
    .nominal(1e-3),
    parameter(Id::Mode, "mode", 200, Kind::Choice(&MODE), &[0.0], "Who moves the projectile"),
    parameter(
        Id::Preset,
        "preset",
        201,
        Kind::Choice(&PRESET),
        &[0.0],
        "Where parameters come from that the host does not set. A parameter that the host sets counts over any preset",
    ),
    parameter(Id::Shape, "projectile.shape", 210, Kind::Choice(&SHAPE), &[1.0], "Form of the projectile"),
    real(Id::Radius, "projectile.radius", 211, &LENGTH, &[6.35e-3], "Radius, at least sheet.spacing (not read for a box)"),
    real(Id::Length, "projectile.length", 212, &LENGTH, &[0.0381], "Whole length along the axis (read for the cylinders only)"),
    real(
        Id::Mass,
        "projectile.mass",
        213,
        &MASS,
        &[0.037],
        "Mass, at least that of a node. Mode host_driven: 0 if not known; then there is no interface.residual and no \
         acceleration from the mean force",
    ),
    real(
        Id::Size,
        "projectile.size",
        214,
        &LENGTH,
        &[0.0127; 3],
        "Edge lengths of a box, each at least twice sheet.spacing (read for a box only)",
    )
    .shaped(&[3]),
    parameter(Id::NodesX, "sheet.nodes_x", 220, Kind::Integer, &[350.0], "Nodes along x, at least 2").range(0.0, LARGEST),
    parameter(Id::NodesY, "sheet.nodes_y", 221, Kind::Integer, &[350.0], "Nodes along y, at least 2").range(0.0, LARGEST),
    real(Id::Spacing, "sheet.spacing", 222, &LENGTH, &[0.0254 / 35.0], "Node spacing = rest length of a segment, > 0")
        .nominal(1e-3),
    real(Id::NodeMass, "sheet.node_mass", 223, &MASS, &[6.52e-8], "Mass of a node of one ply, > 0").nominal(1e-7),
    real(Id::YarnArea, "sheet.yarn_area", 224, &AREA, &[1.075e-7], "Cross-section of a yarn of one ply, > 0"),
    parameter(
        Id::Plies,
        "sheet.plies",
        225,
        Kind::Integer,
        &[1.0],
        "Coincident plies lumped into one network, 1 to 1000: an upper bound, without contact between plies",
    )
    .range(0.0, LARGEST),
    real(Id::SheetPosition, "sheet.position", 230, &POSITION, ZERO, "Middle of the sheet in the host's frame").shaped(&[3]),
    real(
        Id::SheetOrientation,
        "sheet.orientation",
        233,
        &QUATERNION,
        ONE_TURN,
        "Unit quaternion, scalar first, that turns the sheet's axes (normal = z) into the host's",
    )
    .shaped(&[4]),
    parameter(Id::AttachmentKind, "attachment.kind", 240, Kind::Choice(&ATTACHMENT), &[0.0], "Which nodes are held"),
    real(
        Id::DiscInset,
        "attachment.disc_inset",
        241,
        &LENGTH,
        &[25.4e-3],
        "Four corners: distance of a disc's centre from both edges",
    ),
    real(Id::DiscRadius, "attachment.disc_radius", 242, &LENGTH, &[19.05e-3], "Four corners: radius of the discs, each of which must hold a node"),
    real(Id::ModulusMean, "yarn.modulus_mean", 250, &MODULUS, &[140.21e9], "Mean Young's modulus of a segment, > 0"),
    real(Id::ModulusSd, "yarn.modulus_sd", 251, &MODULUS, &[2.04e9], "Standard deviation of the modulus, >= 0").nominal(1e9),
    real(
        Id::DamageSlope,
        "yarn.damage_slope",
        252,
        &DAMAGE_SLOPE,
        &[7.91e-9],
        "Slope of the damage rate over the modulus",
    ),
    real(Id::DamageIntercept, "yarn.damage_intercept", 253, &RATIO, &[-878.46], "Damage rate at zero modulus on that line"),
    real(Id::DamageSd, "yarn.damage_sd", 254, &RATIO, &[8.35], "Standard deviation of the damage rate about the line, >= 0")
    .range(0.0, f64::INFINITY),
    real(Id::CriticalStretch, "yarn.critical_stretch", 255, &RATIO, &[1.03], "Stretch at which damage begins, > 1")
    .range(1.0, f64::INFINITY),
    real(
        Id::AlphaFail,
        "yarn.alpha_fail",
        256,
        &RATIO,
        &[0.01],
        "Remaining part of the stiffness at which a segment fails, in [0, 1)",
    )
    .range(0.0, 1.0),
    parameter(
        Id::Stochastic,
        "yarn.stochastic",
        257,
        Kind::Boolean,
        &[1.0],
        "Every segment draws its own modulus and damage rate; false: all take the mean",
    ),
    parameter(Id::Seed, "seed", 260, Kind::Integer, &[1.0], "Seed of the draws").range(0.0, LARGEST),
    real(
        Id::Dt,
        "dt",
        261,
        &DURATION,
        &[DEFAULT_DT],
        "Internal time step, constant for the whole run. Refused above half the stability limit; the log says the largest",
    )
    .nominal(1e-8),
    real(Id::ForceWindow, "force_window", 262, &DURATION, &[1e-6], "Window of contact.force_peak, > 0"),
    parameter(
        Id::TrackDetachment,
        "track_detachment",
        263,
        Kind::Boolean,
        &[1.0],
        "Watch whether the nodes under the projectile are still connected to a support; without it a projectile that carries torn cloth never exits",
    ),
    tunable(
        Id::StopOnEvent,
        "stop_on_event",
        270,
        Kind::Boolean,
        &[0.0],
        "Ask the host to end the simulation at the first outcome (arrested, detached, exited, passed)",
    ),
    tunable(
        Id::LogLevel,
        "log.level",
        271,
        Kind::Integer,
        &[2.0],
        "0 only fatal errors, 1 errors and refused steps, 2 warnings, 3 events",
    )
    .range(0.0, 3.0),
    output(
        Id::ForceMean,
        "contact.force_mean",
        300,
        &FORCE,
        "Mean force on the projectile over the last communication step: impulse over the step size",
    )
    .shaped(&[3]),
    output(
        Id::TorqueMean,
        "contact.torque_mean",
        310,
        &TORQUE,
        "Mean torque on the projectile about its moving centre of mass over the last communication step",
    )
    .shaped(&[3]),
    output(Id::ForcePeak, "contact.force_peak", 313, &FORCE, "Largest mean force over consecutive windows of force_window; until the first is full the mean force over the time elapsed"),
    output(Id::Impulse, "contact.impulse", 320, &IMPULSE, "Impulse on the projectile since the start").shaped(&[3]),
    output(
        Id::AngularImpulse,
        "contact.angular_impulse",
        330,
        &ANGULAR_IMPULSE,
        "Angular impulse on the projectile about its moving centre of mass since the start",
    )
    .shaped(&[3]),
    output(Id::Work, "contact.work", 333, &ENERGY, "Work of the projectile on the fabric since the start: the energy absorbed"),
    output(Id::SupportImpulse, "support.impulse", 340, &IMPULSE, "Impulse of the sheet on all its supports since the start")
        .shaped(&[3]),
    output(
        Id::AttachmentImpulse,
        "support.attachment_impulse",
        350,
        &IMPULSE,
        "The same for each attachment: sides left (-x), right, bottom (-y), top; or corners (-x -y), (+x -y), (-x +y), (+x +y)",
    )
    .shaped(&[4, 3]),
    output(Id::StatePosition, "state.position", 370, &POSITION, "Centre of mass of the body the fabric saw")
        .shaped(&[3]),
    output(Id::StateVelocity, "state.velocity", 380, &VELOCITY, "Velocity of that body (half an internal step earlier)")
        .shaped(&[3]),
    output(Id::StateOrientation, "state.orientation", 390, &QUATERNION, "Orientation of that body, scalar first").shaped(&[4]),
    output(
        Id::StateAngularVelocity,
        "state.angular_velocity",
        400,
        &ANGULAR_VELOCITY,
        "Angular velocity of that body, host's axes",
    )
    .shaped(&[3]),
    output(Id::EnergyKinetic, "energy.kinetic", 410, &ENERGY, "Kinetic energy of the fabric"),
    output(Id::EnergyStrain, "energy.strain", 411, &ENERGY, "Strain energy of the yarns"),
    output(Id::EnergyDissipated, "energy.dissipated", 412, &ENERGY, "Energy dissipated by rupture"),
    output(
        Id::EnergyContactLoss,
        "energy.contact_loss",
        413,
        &ENERGY,
        "Kinetic energy lost when nodes are swept up by the projectile",
    ),
    output(Id::EnergyResidual, "energy.residual", 414, &ENERGY, "What the energy balance does not close by"),
    output(
        Id::InterfaceResidual,
        "interface.residual",
        415,
        &ENERGY,
        "Mode host_driven with a mass: the host's loss of kinetic energy since the start, from the velocities it supplied, \
         minus contact.work, both at the start of the last communication step. Work of gravity or drag in the host is part of it",
    ),
    output(Id::MaxDeflection, "fabric.max_deflection", 420, &POSITION, "Largest distance from the sheet's plane of a node that is still joined to a support (of any node of a free sheet)"),
    output(Id::MaxStretch, "fabric.max_stretch", 421, &RATIO, "Largest stretch of a segment that has not failed"),
    discrete(Id::FailedSegments, "fabric.failed_segments", 422, Kind::Integer, "Number of failed segments"),
    output(
        Id::WorstPenetration,
        "fabric.worst_penetration",
        423,
        &POSITION,
        "Deepest penetration of a node into the projectile so far",
    )
    .nominal(1e-6),
    output(
        Id::MomentumResidual,
        "momentum.residual",
        430,
        &IMPULSE,
        "Size of what the momentum balance of fabric, projectile and supports does not close by",
    ),
    output(Id::StepFraction, "step.fraction", 431, &RATIO, "dt over the stability limit of the sheet as drawn"),
    discrete(Id::Unconverged, "contact.unconverged", 432, Kind::Integer, "Contact solves that ran out of sweeps"),
    discrete(Id::Status, "status", 440, Kind::Choice(&STATUS), "The latest outcome, or contact or flight"),
    time(Id::TimeFirstContact, "time_first_contact", 441, "Time of the first contact; -1 before"),
    time(Id::TimeEvent, "time_event", 442, "Time of the latest outcome; -1 before"),
];

/// Number of variables.
pub const COUNT: usize = VARIABLES.len();

/// Value reference of FMI 3.0's `time`.
pub const TIME_REFERENCE: u32 = 0;

/// Numbers kept for inputs and parameters, all elements together.
pub const SLOTS: usize = OFFSETS[COUNT];

/// Where each variable's values are kept; outputs take no room.
pub const OFFSETS: [usize; COUNT + 1] = {
    let mut offsets = [0; COUNT + 1];
    let mut k = 0;
    while k < COUNT {
        offsets[k + 1] = offsets[k] + VARIABLES[k].start.len();
        k += 1;
    }
    offsets
};

/// Start values of all inputs and parameters.
pub const STARTS: [f64; SLOTS] = {
    let mut starts = [0.0; SLOTS];
    let mut k = 0;
    while k < COUNT {
        let mut e = 0;
        while e < VARIABLES[k].start.len() {
            starts[OFFSETS[k] + e] = VARIABLES[k].start[e];
            e += 1;
        }
        k += 1;
    }
    starts
};

/// A hash of the table (names, references, types, roles, sizes and start values) and of the kernel's version and image format:
/// a library and a model description of different builds refuse each other.
pub const TOKEN_HASH: u64 = {
    let mut hash = hashed(0xcbf2_9ce4_8422_2325, fabric::VERSION.as_bytes());
    hash = hashed(hash, &fabric::snapshot::FORMAT.to_le_bytes());
    let mut k = 0;
    while k < COUNT {
        let variable = &VARIABLES[k];
        hash = hashed(hash, variable.name.as_bytes());
        hash = hashed(hash, &variable.reference.to_le_bytes());
        if let Some(quantity) = variable.quantity {
            hash = hashed(hash, quantity.name.as_bytes());
            hash = hashed(hash, quantity.unit.as_bytes());
        }
        hash = hashed(hash, &[kind_number(variable.kind), variable.role as u8, variable.size() as u8]);
        let mut e = 0;
        while e < variable.start.len() {
            hash = hashed(hash, &variable.start[e].to_bits().to_le_bytes());
            e += 1;
        }
        k += 1;
    }
    hash
};

const fn kind_number(kind: Kind) -> u8 {
    match kind {
        Kind::Real => 0,
        Kind::Integer => 1,
        Kind::Boolean => 2,
        Kind::Choice(_) => 3,
    }
}

/// FNV-1a.
const fn hashed(mut hash: u64, bytes: &[u8]) -> u64 {
    let mut k = 0;
    while k < bytes.len() {
        hash = (hash ^ bytes[k] as u64).wrapping_mul(0x0000_0100_0000_01b3);
        k += 1;
    }
    hash
}

/// The token as a text: guid of FMI 2.0, instantiationToken of FMI 3.0.
pub const TOKEN: [u8; 28] = {
    let mut token = *b"{FabricShield-0000000000000}";
    let mut rest = TOKEN_HASH;
    let mut k = 26;
    while k > 13 {
        token[k] = b"0123456789abcdef"[(rest & 15) as usize];
        rest >>= 4;
        k -= 1;
    }
    token
};

/// The row, its place in the table and the element that a value reference of FMI 2.0 means.
pub fn element(reference: u32) -> Option<(&'static Variable, usize)> {
    VARIABLES.iter().find_map(|variable| {
        let element = reference.checked_sub(variable.reference)? as usize;
        (element < variable.size()).then_some((variable, element))
    })
}

/// The row that a value reference of FMI 3.0 means.
pub fn whole(reference: u32) -> Option<&'static Variable> {
    VARIABLES.iter().find(|variable| variable.reference == reference)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters;
    use fabric::Scene;
    use std::collections::HashSet;

    #[test]
    fn rows_stand_where_their_id_says_and_references_do_not_overlap() {
        let mut names = HashSet::new();
        let mut references = HashSet::from([TIME_REFERENCE]);
        for (k, variable) in VARIABLES.iter().enumerate() {
            assert_eq!(variable.id as usize, k, "{}", variable.name);
            assert!(names.insert(variable.name));
            for element in 0..variable.size() as u32 {
                assert!(references.insert(variable.reference + element), "{}", variable.name);
            }
            assert_eq!(variable.start.len(), if variable.role.is_output() { 0 } else { variable.size() });
            assert_eq!(variable.kind == Kind::Real, variable.quantity.is_some(), "{}", variable.name);
            assert!(variable.quantity.is_none_or(|quantity| QUANTITIES.contains(&quantity)));
            let [least, greatest] = variable.limits();
            assert!(variable.start.iter().all(|&x| least <= x && x <= greatest), "{}", variable.name);
            assert!(variable.role != Role::Continuous || variable.kind == Kind::Real);
        }
    }

    #[test]
    fn quantities_have_known_units_and_every_unit_is_used() {
        for quantity in QUANTITIES {
            let unit = UNITS.iter().find(|unit| unit.name == quantity.unit).expect(quantity.name);
            let shown = |(name, _): &(&str, f64)| *name == quantity.display;
            assert!(quantity.display.is_empty() || unit.display.iter().any(shown), "{}", quantity.name);
            assert!(VARIABLES.iter().any(|variable| variable.quantity == Some(quantity)), "{}", quantity.name);
        }
        assert!(UNITS.iter().all(|unit| QUANTITIES.iter().any(|quantity| quantity.unit == unit.name)));
    }

    #[test]
    fn start_values_are_the_ten_inch_preset() {
        for variable in VARIABLES {
            if let Some(values) = parameters::of_scene(&Scene::sheet_10in_cylinder(), variable.id) {
                assert_eq!(&values[..variable.size()], variable.start, "{}", variable.name);
            }
        }
    }

    #[test]
    fn token_is_readable() {
        assert_eq!(TOKEN[26], b"0123456789abcdef"[(TOKEN_HASH & 15) as usize]);
        assert!(core::str::from_utf8(&TOKEN).unwrap().starts_with("{FabricShield-"));
    }
}
