//! The variables: one table from which getters, setters and both model descriptions come.
//!
//! The scene's parameters and most outputs are the rows of the kernel's tables ([`FIELDS`], [`OUTPUTS`]),
//! with their names, value references, ranges and meanings. Listed here is only what the FMU adds: inputs,
//! settings of the FMU itself, what it knows of its host's steps, and events.
//! Start values are those of `Parameters::default`.
//!
//! A variable's value reference never changes once released; a new variable takes a new one. In FMI 3.0 an
//! array has the table's reference; in FMI 2.0 its elements have that reference and the following ones, row
//! by row.

use fabric_kernel::MAX_PLIES;
use fabric_kernel::Outcome;
use fabric_kernel::fields::{
    ANGULAR_VELOCITY, ANY_SIGN, Choice, FIELDS, FORCE, Field, POSITION, Place, QUATERNION, Quantity, VELOCITY, quantity,
};
use fabric_kernel::outputs::{ENERGY, Get, OUTPUTS, Output};

/// Names a variable in code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // described in the table
pub enum Id {
    /// A row of the kernel's table of parameters, by its number.
    Scene(usize),
    /// A row of its table of outputs.
    Output(usize),
    // Inputs.
    Position,
    Velocity,
    Orientation,
    AngularVelocity,
    Acceleration,
    ExternalForce,
    ExternalTorque,
    // Settings.
    StopOnEvent,
    PlyFirst,
    Capsule,
    // Outputs.
    ForceMean,
    TorqueMean,
    InterfaceResidual,
    InterfaceGap,
    Status,
    /// Whether an event has happened: a place in [`EVENTS`].
    Happened(usize),
    /// When it happened first.
    HappenedAt(usize),
}

/// Plies that the outputs of single plies show.
pub const PLIES_SHOWN: usize = 8;

/// The events: the first contact, then the outcomes in the kernel's order.
pub const EVENTS: usize = 1 + Outcome::ALL.len();

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
    /// Output that changes at events only. In FMI 3.0 with event mode a change is shown from the next event
    /// mode on.
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
    /// Quantity of a Real; None for the other types.
    pub quantity: Option<&'static Quantity>,
    /// Typical size, if it is not that of the quantity; 0 otherwise.
    pub nominal: f64,
    /// Meaning.
    pub description: &'static str,
    /// Addition of the FMU to the meaning.
    pub note: &'static str,
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

    /// The row of the kernel's table of outputs, if it is one of those.
    pub fn output(&self) -> Option<&'static Output> {
        if let Id::Output(row) = self.id { OUTPUTS.get(row) } else { None }
    }

    /// The row of the kernel's table, if it is one of the scene's.
    pub fn field(&self) -> Option<&'static Field> {
        if let Id::Scene(row) = self.id { FIELDS.get(row) } else { None }
    }

    /// Least and greatest value: those of the kernel's table as far as the type and the quantity have them,
    /// or the FMU's own.
    pub fn limits(&self) -> [f64; 2] {
        let [least, greatest] = match (self.field(), self.kind) {
            (Some(field), _) => field.limits(),
            (None, Kind::Choice(choice)) => [0.0, choice.items.len() as f64 - 1.0],
            (None, Kind::Integer) => [0.0, MAX_PLIES as f64 - 1.0],
            (None, _) => [f64::NEG_INFINITY, f64::INFINITY],
        };
        match (self.kind, self.quantity) {
            (Kind::Integer, _) if greatest > LARGEST => [least, LARGEST],
            (_, Some(quantity)) if least < quantity.least => [quantity.least, greatest],
            _ => [least, greatest],
        }
    }

    /// Whether a number lies within the limits.
    pub fn contains(&self, value: f64) -> bool {
        let [least, greatest] = self.limits();
        least <= value && value <= greatest
    }

    const fn shaped(mut self, shape: &'static [usize]) -> Variable {
        self.shape = shape;
        self
    }

    const fn nominal(mut self, nominal: f64) -> Variable {
        self.nominal = nominal;
        self
    }
}

type Str = &'static str;
type OfQuantity = &'static Quantity;

const fn row(id: Id, name: Str, reference: u32, kind: Kind, role: Role, description: Str) -> Variable {
    let (shape, quantity): (&[usize], _) = (&[], None);
    let (nominal, note) = (0.0, "");
    Variable { id, name, reference, kind, role, shape, quantity, nominal, description, note }
}

const fn input(id: Id, name: Str, reference: u32, of: OfQuantity, about: Str) -> Variable {
    Variable { quantity: Some(of), shape: &[3], ..row(id, name, reference, Kind::Real, Role::Input, about) }
}

const fn tunable(id: Id, name: Str, reference: u32, kind: Kind, about: Str) -> Variable {
    row(id, name, reference, kind, Role::Tunable, about)
}

const fn output(id: Id, name: Str, reference: u32, of: OfQuantity, about: Str) -> Variable {
    Variable { quantity: Some(of), ..row(id, name, reference, Kind::Real, Role::Continuous, about) }
}

/// The variable of a row of the kernel's table of outputs; each output of a single ply is one of several.
const fn of_output(number: usize) -> Variable {
    let Output { fmi: (name, reference), quantity, shape, nominal, get, about, .. } = OUTPUTS[number];
    let shape = if let Get::Ply(_) = get { &[PLIES_SHOWN] } else { shape };
    Variable { shape, nominal, ..output(Id::Output(number), name, reference, quantity, about) }
}

/// Reference of the kernel's output after which one of the FMU's own stands; 0 for most.
const fn behind(id: Id) -> u32 {
    match id {
        Id::InterfaceResidual => 414,
        Id::InterfaceGap => 434,
        _ => 0,
    }
}

const fn discrete(id: Id, name: Str, reference: u32, kind: Kind, about: Str) -> Variable {
    row(id, name, reference, kind, Role::Discrete, about)
}

/// Whether an event has happened.
const fn happened(event: usize, name: Str, about: Str) -> Variable {
    discrete(Id::Happened(event), name, 443 + event as u32, Kind::Boolean, about)
}

/// When it happened.
const fn at(event: usize, name: Str, about: Str) -> Variable {
    Variable { role: Role::Discrete, ..output(Id::HappenedAt(event), name, 448 + event as u32, &TIME, about) }
}

/// A parameter's name: the kernel's, but where an input has that name.
const fn name_of(field: &Field) -> Str {
    match field.fmi {
        600 => "projectile.start.position",
        603 => "projectile.start.velocity",
        606 => "projectile.start.orientation",
        610 => "projectile.start.angular_velocity",
        _ => field.name,
    }
}

/// The variable of a row of the kernel's table.
const fn of_scene(number: usize) -> Variable {
    let field = &FIELDS[number];
    let kind = match field.place {
        Place::Reals(..) => Kind::Real,
        Place::Count(_) | Place::Seed(_) => Kind::Integer,
        Place::Flag(_) => Kind::Boolean,
        Place::Choice(choice, ..) => Kind::Choice(choice),
    };
    let note = if let Place::Seed(_) = field.place { ". In the FMU at most 2^31 - 1" } else { "" };
    let known = row(Id::Scene(number), name_of(field), field.fmi, kind, Role::Fixed, field.about);
    Variable { quantity: field.quantity, shape: field.shape(), note, ..known }
}

/// State of the projectile and of the computation.
pub const STATUS: Choice = Choice {
    name: "Status",
    items: &[
        ("flight", "no contact in the last internal step"),
        ("contact", "contact in the last internal step"),
        ("faulted", "the computation cannot go on: see the log; reset or restore a state"),
    ],
};

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
    unit("1/s", [0, 0, -1, 0], &[]),
    unit("1/Pa", [-1, 1, 2, 0], &[("1/GPa", 1e9)]),
    unit("J", [1, 2, -2, 0], &[("mJ", 1e3)]),
    unit("N", [1, 1, -2, 0], &[("kN", 1e-3)]),
    unit("N.m", [1, 2, -2, 0], &[]),
    unit("N.m.s", [1, 2, -1, 0], &[]),
    unit("N.s", [1, 1, -1, 0], &[]),
    unit("Pa", [1, -1, -2, 0], &[("GPa", 1e-9)]),
    unit("kg", [1, 0, 0, 0], &[("g", 1e3)]),
    unit("kg.m2", [1, 2, 0, 0], &[]),
    unit("m", [0, 1, 0, 0], &[("mm", 1e3)]),
    unit("m/s", [0, 1, -1, 0], &[]),
    unit("m/s2", [0, 1, -2, 0], &[]),
    unit("m2", [0, 2, 0, 0], &[("mm2", 1e6)]),
    unit("rad", [0, 0, 0, 1], &[("deg", 180.0 / core::f64::consts::PI)]),
    unit("rad/s", [0, 0, -1, 1], &[("deg/s", 180.0 / core::f64::consts::PI)]),
    unit("s", [0, 0, 1, 0], &[("us", 1e6)]),
];

const ACCELERATION: Quantity = quantity("Acceleration", "m/s2", "", ANY_SIGN, 1e5, "Acceleration");
const TORQUE: Quantity = quantity("Torque", "N.m", "", ANY_SIGN, 10.0, "Torque");
const TIME: Quantity = quantity("Time", "s", "us", ANY_SIGN, 1e-3, "Point in time");

/// Every quantity in use, for the type definitions.
pub fn quantities() -> impl Iterator<Item = &'static Quantity> {
    let of = |k: usize| VARIABLES.get(k)?.quantity;
    (0..COUNT).filter(move |&k| of(k).is_some() && (0..k).all(|before| of(before) != of(k))).filter_map(of)
}

/// Every choice in use, for the type definitions.
pub fn choices() -> impl Iterator<Item = &'static Choice> {
    let of = |k: usize| match VARIABLES.get(k)?.kind {
        Kind::Choice(choice) => Some(choice),
        _ => None,
    };
    (0..COUNT).filter(move |&k| of(k).is_some() && (0..k).all(|before| of(before) != of(k))).filter_map(of)
}

/// Log categories: name and meaning.
pub const LOG_CATEGORIES: &[(&str, &str)] = &[
    ("logEvents", "Initialisation, first contact, outcomes, what was put right"),
    ("logStatusDiscard", "Steps refused with nothing changed"),
    ("logStatusError", "Calls refused, and failures"),
    ("logStatusFatal", "No memory for an instance"),
    ("logCapsule", "With the parameter capsule: what the host does, for `fabric replay`"),
    (
        "logStatusWarning",
        "An open energy balance, a hit beyond the fine part of a graded network, too large a coupling step",
    ),
    ("logAll", "All of these"),
];

/// Default end of a run, s: the default projectile has left the sheet.
pub const DEFAULT_STOP_TIME: f64 = 6e-4;
/// Default communication step, s.
pub const DEFAULT_STEP_SIZE: f64 = 1e-6;

const LARGEST: f64 = i32::MAX as f64;

/// Variables that the FMU adds to the kernel's tables.
const OWN: &[Variable] = &[
    input(
        Id::Position,
        "projectile.position",
        100,
        &POSITION,
        "Drive prescribed: centre of mass at the communication point. Position and velocity all zero before anything else was \
         given: not connected, the body flies on from its start",
    ),
    input(
        Id::Velocity,
        "projectile.velocity",
        110,
        &VELOCITY,
        "Drive prescribed: velocity of the centre of mass at the communication point",
    ),
    input(
        Id::Orientation,
        "projectile.orientation",
        120,
        &QUATERNION,
        "Drive prescribed: orientation at the communication point, unit quaternion, scalar first. All zero: not connected, the \
         body turns on as it does",
    )
    .shaped(&[4]),
    input(
        Id::AngularVelocity,
        "projectile.angular_velocity",
        130,
        &ANGULAR_VELOCITY,
        "Drive prescribed: angular velocity, host's axes. Read if the orientation is connected",
    ),
    input(
        Id::Acceleration,
        "projectile.acceleration",
        140,
        &ACCELERATION,
        "Optional, drive prescribed: acceleration expected over the step. If zero: last mean force over projectile.mass",
    ),
    input(
        Id::ExternalForce,
        "external.force",
        150,
        &FORCE,
        "Drive free: force at the centre of mass, held over the step (gravity, drag)",
    )
    .nominal(1.0),
    input(
        Id::ExternalTorque,
        "external.torque",
        160,
        &TORQUE,
        "Drive free: torque about the centre of mass, held over the step",
    )
    .nominal(1e-3),
    tunable(
        Id::StopOnEvent,
        "stop_on_event",
        270,
        Kind::Boolean,
        "Ask the host to end the simulation at the first outcome (arrested, detached, exited, passed, through, rebounded, attachment_failed)",
    ),
    tunable(
        Id::Capsule,
        "capsule",
        272,
        Kind::Boolean,
        "Write what the host does to the log, as lines of the category logCapsule, which `fabric replay` does again and compares bit by bit; \
         read where initialisation ends",
    ),
    tunable(
        Id::PlyFirst,
        "ply.first",
        271,
        Kind::Integer,
        "Number of the ply that the first element of the outputs ply.* shows, from 0; the others show those behind it",
    ),
    output(
        Id::ForceMean,
        "contact.force_mean",
        300,
        &FORCE,
        "Mean force on the projectile over the internal steps of the last communication step that had any: impulse over their time",
    )
    .shaped(&[3]),
    output(
        Id::TorqueMean,
        "contact.torque_mean",
        310,
        &TORQUE,
        "Mean torque on the projectile about its moving centre of mass over the same time",
    )
    .shaped(&[3]),
    output(
        Id::InterfaceResidual,
        "interface.residual",
        415,
        &ENERGY,
        "Drive prescribed with a mass: the host's loss of kinetic energy since the start, from the velocities it supplied, \
         minus contact.work, both at the start of the last communication step. Work of gravity or drag in the host is part of it",
    ),
    output(
        Id::InterfaceGap,
        "interface.gap",
        433,
        &POSITION,
        "Drive prescribed: how far surface points of the host's body and of the fabric's lay apart at most, at the start of the \
         last communication step. More than one node spacing is refused",
    )
    .nominal(1e-6),
    discrete(Id::Status, "status", 440, Kind::Choice(&STATUS), "What is true now, whatever has happened before"),
    happened(0, "outcome.first_contact", "The projectile has touched the sheet"),
    happened(1, "outcome.arrested", "It moves into the sheet no more"),
    happened(2, "outcome.detached", "The nodes under it have lost every connection to a support"),
    happened(3, "outcome.exited", "Its contact with the fabric is over, and it goes on to the other side"),
    happened(4, "outcome.passed", "No contact, and none to come: it has missed the sheet"),
    at(0, "outcome.first_contact_time", "When it first touched the sheet; 0 unless outcome.first_contact"),
    at(1, "outcome.arrested_time", "When it stopped; 0 unless outcome.arrested"),
    at(2, "outcome.detached_time", "When that was found; 0 unless outcome.detached"),
    at(3, "outcome.exited_time", "When that was found; 0 unless outcome.exited"),
    at(4, "outcome.passed_time", "When that was found; 0 unless outcome.passed"),
    discrete(Id::Happened(5), "outcome.through", 453, Kind::Boolean, "Held yarn does not stop it any more; never without track_through"),
    Variable { role: Role::Discrete, ..output(Id::HappenedAt(5), "outcome.through_time", 454, &TIME, "When that was found; 0 unless outcome.through") },
    discrete(Id::Happened(6), "outcome.rebounded", 455, Kind::Boolean, "Its contact with the fabric is over, and it leaves on the side from which it came"),
    Variable { role: Role::Discrete, ..output(Id::HappenedAt(6), "outcome.rebounded_time", 456, &TIME, "When that was found; 0 unless outcome.rebounded") },
    discrete(Id::Happened(7), "outcome.attachment_failed", 457, Kind::Boolean, "An attachment as a whole has let go; never without attachment.strength"),
    Variable { role: Role::Discrete, ..output(Id::HappenedAt(7), "outcome.attachment_failed_time", 458, &TIME, "When the first one let go; 0 unless outcome.attachment_failed") },
];

/// Number of variables.
pub const COUNT: usize = {
    let (mut count, mut k) = (FIELDS.len() + OWN.len(), 0);
    while k < OUTPUTS.len() {
        count += (OUTPUTS[k].fmi.1 > 0) as usize;
        k += 1;
    }
    count
};

/// Every variable but `time`: the scene's, then the FMU's own, among which are the kernel's outputs.
pub static VARIABLES: [Variable; COUNT] = {
    let (mut all, mut count) = ([OWN[0]; COUNT], 0);
    while count < FIELDS.len() {
        all[count] = of_scene(count);
        count += 1;
    }
    let (mut own, mut output, mut last) = (0, 0, 0);
    while count < COUNT {
        if own < OWN.len() && (behind(OWN[own].id) == 0 || behind(OWN[own].id) == last) {
            all[count] = OWN[own];
            (own, count) = (own + 1, count + 1);
            continue;
        }
        last = OUTPUTS[output].fmi.1;
        if last > 0 {
            all[count] = of_output(output);
            count += 1;
        }
        output += 1;
    }
    all
};

/// Most elements of one variable.
pub const MOST_ELEMENTS: usize = {
    let (mut most, mut k) = (fabric_kernel::outputs::MOST_ELEMENTS, 0);
    while k < FIELDS.len() {
        most = if FIELDS[k].size() > most { FIELDS[k].size() } else { most };
        k += 1;
    }
    most
};

/// Value reference of FMI 3.0's `time`.
pub const TIME_REFERENCE: u32 = 0;

/// The row of a name.
pub fn variable(name: &str) -> Option<&'static Variable> {
    VARIABLES.iter().find(|variable| variable.name == name)
}

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
    use std::collections::HashSet;

    #[test]
    fn names_and_references_do_not_overlap() {
        let mut names = HashSet::new();
        let mut references = HashSet::from([TIME_REFERENCE]);
        for variable in &VARIABLES {
            assert!(names.insert(variable.name));
            for element in 0..variable.size() as u32 {
                assert!(references.insert(variable.reference + element), "{}", variable.name);
            }
            assert_eq!(variable.kind == Kind::Real, variable.quantity.is_some(), "{}", variable.name);
            assert!(variable.role != Role::Continuous || variable.kind == Kind::Real);
            assert!(variable.size() <= MOST_ELEMENTS, "{}", variable.name);
        }
    }

    #[test]
    fn the_scene_is_parameters_and_the_motion_of_the_body_is_inputs_too() {
        assert!(VARIABLES.iter().all(|variable| (variable.role == Role::Fixed) == variable.field().is_some()));
        for name in ["position", "velocity", "orientation", "angular_velocity"] {
            let (input, start) = (std::format!("projectile.{name}"), std::format!("projectile.start.{name}"));
            assert_eq!(variable(&input).unwrap().role, Role::Input);
            assert_eq!(variable(&start).unwrap().field().unwrap().name, input);
        }
    }

    #[test]
    fn the_status_and_the_events_are_discrete_and_nothing_else() {
        for variable in &VARIABLES {
            let is_event = matches!(variable.id, Id::Status | Id::Happened(_) | Id::HappenedAt(_));
            assert_eq!(variable.role == Role::Discrete, is_event, "{}", variable.name);
        }
    }

    #[test]
    fn quantities_have_known_units_and_every_unit_is_used() {
        for quantity in quantities() {
            let unit = UNITS.iter().find(|unit| unit.name == quantity.unit).expect(quantity.name);
            let shown = |(name, _): &(&str, f64)| *name == quantity.display;
            assert!(quantity.display.is_empty() || unit.display.iter().any(shown), "{}", quantity.name);
        }
        assert!(UNITS.iter().all(|unit| quantities().any(|quantity| quantity.unit == unit.name)));
        // A type's name means one thing.
        let types: std::vec::Vec<_> = quantities().map(|q| q.name).chain(choices().map(|c| c.name)).collect();
        assert_eq!(types.iter().collect::<HashSet<_>>().len(), types.len());
    }
}
