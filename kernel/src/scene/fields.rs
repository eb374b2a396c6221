//! The table of a scene's parameters: one row for each number of [`Scene`].
//!
//! From these rows come the checks of each number by itself, the fingerprint of a scene, the keys of scene files, the structure
//! `fk_scene` of the C header, the FMU's parameters with both model descriptions, the keys of kept results, and the parameter
//! table of the documents. A new parameter needs its field in `scene.rs`, its row here, and the code that reads it.
//!
//! The order of the rows is the order in C and in the fingerprint. Rows of one group stand together.
//! Once there is a release, a new parameter goes to the end of the table, with a group of its own or none, so that hosts compiled
//! before it go on working; its [`Image`] is [`Image::Later`], so that images of scenes without it still fit.

use crate::ground::error::{Code, Error, finite, not_negative, positive, unit_quaternion};
use crate::scene::parts::{
    AttachmentKind, CRITICAL_STRETCH_MAX, Draw, Drive, GRADING_LARGEST, IntegratorKind, MAX_FACES, MAX_NODES_PER_SIDE,
    MAX_PLIES, RotationKind, STRAIN_RATES, Scene, Shape, StepAfterFailure, StepCheck, StrengthDraw, WEIBULL_SHAPES,
};

/// What kind of number a real parameter is.
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

/// A quantity.
pub const fn quantity(
    name: &'static str,
    unit: &'static str,
    display: &'static str,
    least: f64,
    nominal: f64,
    description: &'static str,
) -> Quantity {
    Quantity { name, unit, display, least, nominal, description }
}

/// Of either sign.
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
/// Length of time.
pub const DURATION: Quantity = quantity("Duration", "s", "us", 0.0, 1e-6, "Length of time");

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
const ATTACHMENTS: [AttachmentKind; 4] =
    [AttachmentKind::TwoSides, AttachmentKind::FourSides, AttachmentKind::FourCorners, AttachmentKind::Free];

/// What gets a draw of its own.
pub const DRAW: Choice = Choice {
    name: "Draw",
    items: &[("segment", "every segment"), ("yarn", "every woven yarn: a whole row or column of segments")],
};
const DRAWS: [Draw; 2] = [Draw::Segment, Draw::Yarn];

/// What the critical stretch of a segment is.
pub const STRENGTH_DRAW: Choice = Choice {
    name: "StrengthDraw",
    items: &[
        ("none", "every segment has yarn.critical_stretch"),
        ("weibull", "every segment has its own: U_c - 1 is drawn from a Weibull distribution"),
    ],
};
const STRENGTH_DRAWS: [StrengthDraw; 2] = [StrengthDraw::None, StrengthDraw::Weibull];

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
const SHAPES: [Shape; 6] =
    [Shape::Sphere, Shape::Cylinder, Shape::HemisphericalCylinder, Shape::Box, Shape::Polyhedron, Shape::DiscSector];

/// Who moves the projectile.
pub const DRIVE: Choice = Choice {
    name: "Drive",
    items: &[
        ("free", "the model moves the projectile under contact and the external load"),
        ("prescribed", "the host moves the projectile; the model gives force, impulse and work"),
    ],
};
const DRIVES: [Drive; 2] = [Drive::Free, Drive::Prescribed];

/// How the nodes are stepped.
pub const INTEGRATOR: Choice = Choice {
    name: "Integrator",
    items: &[
        ("verlet", "velocity Verlet, explicit"),
        ("theta", "the paper's theta rule by fixed-point iteration: the reference method"),
    ],
};
const INTEGRATORS: [IntegratorKind; 2] = [IntegratorKind::Verlet, IntegratorKind::Theta];

/// Whether the time step is checked.
pub const STEP_CHECK: Choice = Choice {
    name: "StepCheck",
    items: &[
        ("refuse", "a step above 0.5 dt_crit is refused"),
        ("none", "no check, for stability studies only: wrong results without a warning"),
    ],
};
const STEP_CHECKS: [StepCheck; 2] = [StepCheck::Refuse, StepCheck::None];

/// What the step does once a segment has failed.
pub const STEP_AFTER_FAILURE: Choice =
    Choice { name: "StepAfterFailure", items: &[("keep", "it stays"), ("half", "every step is taken as two halves")] };
const STEPS_AFTER_FAILURE: [StepAfterFailure; 2] = [StepAfterFailure::Keep, StepAfterFailure::Half];

/// How the projectile turns.
pub const ROTATION: Choice = Choice {
    name: "Rotation",
    items: &[
        ("midpoint", "implicit midpoint rule, which keeps energy and angular momentum"),
        ("theta", "the paper's theta rule, which does not conserve"),
    ],
};
const ROTATIONS: [RotationKind; 2] = [RotationKind::Midpoint, RotationKind::Theta];

/// Every choice of a scene.
pub const CHOICES: &[&Choice] =
    &[&ATTACHMENT, &DRAW, &STRENGTH_DRAW, &SHAPE, &DRIVE, &INTEGRATOR, &STEP_CHECK, &STEP_AFTER_FAILURE, &ROTATION];

/// What a group of parameters is, by the first part of its name.
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
    ("contact", "Contact of yarn and projectile"),
    ("symmetry", "Mirror planes through the middle of the sheet; only the part at x <= 0, y <= 0 is modelled"),
    ("integrator", "How the nodes are stepped"),
    ("time_step", "The time step, constant for the life of a simulation"),
    ("rotation_rule", "How the projectile turns between impulses"),
];

/// Where a parameter stands in a scene, and its type.
#[derive(Clone, Copy)]
pub enum Place {
    /// Real numbers of this shape; an empty shape is a single number.
    Reals(fn(&mut Scene) -> &mut [f64], &'static [usize]),
    /// A count, 0 ..= 2^32 - 1.
    Count(fn(&mut Scene) -> &mut u32),
    /// A seed, 0 ..= 2^64 - 1.
    Seed(fn(&mut Scene) -> &mut u64),
    /// A truth value, 0 or 1.
    Flag(fn(&mut Scene) -> &mut bool),
    /// A choice: its number, and how it is set (not, if there is no such number).
    Choice(&'static Choice, fn(&Scene) -> u32, fn(&mut Scene, u32)),
}

/// What a number may be by itself. Every real number must be finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// Anything.
    Any,
    /// > 0.
    Positive,
    /// >= 0.
    NotNegative,
    /// From the first to the second, both included.
    Within(f64, f64),
    /// Greater than the first, at most the second.
    Above(f64, f64),
    /// At least the first, less than the second.
    Below(f64, f64),
    /// Nodes along a side: 2 ..= [`MAX_NODES_PER_SIDE`].
    Nodes,
    /// Four numbers of unit length, to 1e-3.
    UnitQuaternion,
}

/// How a parameter enters the fingerprint of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Image {
    /// Always.
    Always,
    /// As far as the scene reads it.
    WhereRead,
    /// Only where it is not 0, behind all others: first this word, plus the value of a count or choice, then the bits of real numbers.
    /// Rows with the same word share one. So a scene without the option has the fingerprint it had before there was one.
    Later(u64),
    /// As far as the scene reads it, behind all others.
    LaterWhereRead,
    /// Not itself, but the step in use.
    StepInUse,
    /// Not at all: an image holds the present motion, and fits whatever room there is and however the step was asked for.
    Never,
}

/// One row of the table.
#[derive(Clone, Copy)]
pub struct Field {
    /// Name: the path in [`Scene`], in C, in scene files and in the FMUs.
    pub name: &'static str,
    /// Place and type.
    pub place: Place,
    /// What kind of number a real parameter is.
    pub quantity: Option<&'static Quantity>,
    /// What it may be.
    pub range: Range,
    /// How many of its elements the scene reads.
    pub read: fn(&Scene) -> usize,
    /// How it enters the fingerprint.
    pub image: Image,
    /// Value reference in the FMUs, of its first element. Never changes once released.
    pub fmi: u32,
    /// Meaning, and what else holds.
    pub about: &'static str,
}

impl Field {
    /// Dimensions; empty for a single number.
    pub const fn shape(&self) -> &'static [usize] {
        match self.place {
            Place::Reals(_, shape) => shape,
            _ => &[],
        }
    }

    /// Number of elements.
    pub const fn size(&self) -> usize {
        let (mut size, mut shape) = (1, self.shape());
        while let [first, rest @ ..] = shape {
            size *= *first;
            shape = rest;
        }
        size
    }

    /// Whether its elements are real numbers; else they are whole.
    pub const fn is_real(&self) -> bool {
        matches!(self.place, Place::Reals(..))
    }

    /// An element as 64 bits: those of a real number, or a whole number. 0 for an element that there is not.
    pub fn word(&self, scene: &mut Scene, element: usize) -> u64 {
        match self.place {
            Place::Reals(place, _) => place(scene).get(element).map_or(0, |x| x.to_bits()),
            Place::Count(place) => u64::from(*place(scene)),
            Place::Seed(place) => *place(scene),
            Place::Flag(place) => u64::from(*place(scene)),
            Place::Choice(_, get, _) => u64::from(get(scene)),
        }
    }

    /// Sets an element from such bits.
    ///
    /// # Errors
    /// [`Code::UnknownChoice`], or for a count beyond 32 bits the code of its range, [`Code::OutOfRange`] if it has none; nothing is
    /// changed.
    pub fn set_word(&self, scene: &mut Scene, element: usize, word: u64) -> Result<(), Error> {
        let small = u32::try_from(word);
        let known = match self.place {
            Place::Choice(choice, ..) => word < choice.items.len() as u64,
            Place::Flag(_) => word <= 1,
            _ => true,
        };
        if !known {
            return Err(Error::new(Code::UnknownChoice, self.name, word as f64, 0.0));
        }
        match (self.place, small) {
            (Place::Reals(place, _), _) => {
                if let Some(x) = place(scene).get_mut(element) {
                    *x = f64::from_bits(word);
                }
            }
            (Place::Seed(place), _) => *place(scene) = word,
            (Place::Flag(place), _) => *place(scene) = word == 1,
            (Place::Count(place), Ok(count)) => *place(scene) = count,
            (Place::Choice(_, _, set), Ok(number)) => set(scene, number),
            (_, Err(_)) => {
                self.check_element(word as f64)?;
                return Err(Error::new(Code::OutOfRange, self.name, word as f64, u32::MAX as f64));
            }
        }
        Ok(())
    }

    /// The word of a number given as a real one. Whole parameters are cut to whole numbers.
    pub fn word_of(&self, value: f64) -> u64 {
        if self.is_real() { value.to_bits() } else { value as u64 }
    }

    /// The number that a word is.
    pub fn value_of(&self, word: u64) -> f64 {
        if self.is_real() { f64::from_bits(word) } else { word as f64 }
    }

    /// Refuses an element that cannot be, whatever the others are. A quaternion is checked as a whole.
    fn check_element(&self, value: f64) -> Result<(), Error> {
        let beyond = |code, limit| Err(Error::new(code, self.name, value, limit));
        finite(self.name, value)?;
        match self.range {
            Range::Any | Range::UnitQuaternion => Ok(()),
            Range::Positive => positive(self.name, value),
            Range::NotNegative => not_negative(self.name, value),
            Range::Within(least, _) if value < least => beyond(Code::OutOfRange, least),
            Range::Within(_, greatest) if value > greatest => beyond(Code::OutOfRange, greatest),
            Range::Above(least, _) if value <= least => beyond(Code::OutOfRange, least),
            Range::Above(_, greatest) if value > greatest => beyond(Code::OutOfRange, greatest),
            Range::Below(least, _) if value < least => beyond(Code::OutOfRange, least),
            Range::Below(_, greatest) if value >= greatest => beyond(Code::OutOfRange, greatest),
            Range::Within(..) | Range::Above(..) | Range::Below(..) => Ok(()),
            Range::Nodes if value < 2.0 => beyond(Code::OutOfRange, 2.0),
            Range::Nodes if value > MAX_NODES_PER_SIDE as f64 => beyond(Code::TooManyNodes, MAX_NODES_PER_SIDE as f64),
            Range::Nodes => Ok(()),
        }
    }

    /// Least and greatest value that an element may have; infinite where there is none.
    pub fn limits(&self) -> [f64; 2] {
        let whole = |place| match place {
            Place::Choice(choice, ..) => choice.items.len() as f64 - 1.0,
            Place::Flag(_) => 1.0,
            Place::Seed(_) => u64::MAX as f64,
            _ => u32::MAX as f64,
        };
        match self.range {
            // Only a polyhedron has moments of its own: else they stay at 0.
            Range::Positive if self.name == "projectile.moments" => [0.0, f64::INFINITY],
            Range::Positive => [0.0_f64.next_up(), f64::INFINITY],
            Range::NotNegative => [0.0, f64::INFINITY],
            Range::Within(least, greatest) => [least, greatest],
            Range::Above(least, greatest) => [least.next_up(), greatest],
            Range::Below(least, greatest) => [least, greatest.next_down()],
            Range::Nodes => [2.0, MAX_NODES_PER_SIDE as f64],
            Range::Any | Range::UnitQuaternion if self.is_real() => [f64::NEG_INFINITY, f64::INFINITY],
            Range::Any | Range::UnitQuaternion => [0.0, whole(self.place)],
        }
    }

    const fn read(self, read: fn(&Scene) -> usize) -> Field {
        Field { read, ..self }
    }

    const fn image(self, image: Image) -> Field {
        Field { image, ..self }
    }
}

/// All elements, or none.
const fn if_so(condition: bool) -> usize {
    if condition { usize::MAX } else { 0 }
}

type Text = &'static str;
type Reals = fn(&mut Scene) -> &mut [f64];
type Of = &'static Quantity;

const fn row(name: Text, place: Place, range: Range, fmi: u32, about: Text) -> Field {
    Field { name, place, quantity: None, range, read: |_| usize::MAX, image: Image::Always, fmi, about }
}

const fn shaped(name: Text, place: Place, of: Of, range: Range, fmi: u32, about: Text) -> Field {
    Field { quantity: Some(of), ..row(name, place, range, fmi, about) }
}

const fn real(name: Text, place: Reals, of: Of, range: Range, fmi: u32, about: Text) -> Field {
    shaped(name, Place::Reals(place, &[]), of, range, fmi, about)
}

/// Of the back fabric.
const fn of_back(name: Text, place: Reals, of: Of, range: Range, fmi: u32, about: Text) -> Field {
    real(name, place, of, range, fmi, about).read(|s| if_so(s.back.plies != 0)).image(Image::LaterWhereRead)
}

const fn vector(name: Text, place: Reals, of: Of, range: Range, fmi: u32, about: Text) -> Field {
    shaped(name, Place::Reals(place, &[3]), of, range, fmi, about)
}

const fn quaternion(name: Text, place: Reals, fmi: u32, about: Text) -> Field {
    shaped(name, Place::Reals(place, &[4]), &QUATERNION, Range::UnitQuaternion, fmi, about)
}

const fn count(name: Text, place: fn(&mut Scene) -> &mut u32, range: Range, fmi: u32, about: Text) -> Field {
    row(name, Place::Count(place), range, fmi, about)
}

const fn flag(name: Text, place: fn(&mut Scene) -> &mut bool, fmi: u32, about: Text) -> Field {
    row(name, Place::Flag(place), Range::Any, fmi, about)
}

const fn choice(
    name: Text,
    of: &'static Choice,
    get: fn(&Scene) -> u32,
    set: fn(&mut Scene, u32),
    fmi: u32,
    about: Text,
) -> Field {
    row(name, Place::Choice(of, get, set), Range::Any, fmi, about)
}

/// Takes the choice of this number, if there is one.
fn pick<T: Copy>(place: &mut T, all: &[T], number: u32) {
    if let Some(chosen) = all.get(number as usize) {
        *place = *chosen;
    }
}

const INFINITE: f64 = f64::INFINITY;

/// The table.
#[rustfmt::skip]
pub const FIELDS: &[Field] = &[
    // ---- Sheet
    count("sheet.nodes_x", |s| &mut s.sheet.nodes_x, Range::Nodes, 220, "Nodes along x"),
    count("sheet.nodes_y", |s| &mut s.sheet.nodes_y, Range::Nodes, 221, "Nodes along y"),
    count("sheet.plies", |s| &mut s.sheet.plies, Range::Within(1.0, 1000.0), 225,
        "Layers bonded into one network: mass and area are multiplied. stack.plies has plies that move apart"),
    real("sheet.spacing", |s| one(&mut s.sheet.spacing), &LENGTH, Range::Positive, 222,
        "Node spacing h along x, the natural length of a segment (M1) without crimp and pre-tension"),
    real("sheet.spacing_y", |s| one(&mut s.sheet.spacing_y), &LENGTH, Range::NotNegative, 620,
        "Node spacing along y, 0.1 to 10 times that along x; 0: as along x. What must exceed sheet.spacing must exceed this, too")
        .image(Image::Later(0x7_0000)),
    real("sheet.node_mass", |s| one(&mut s.sheet.node_mass), &MASS, Range::Positive, 223,
        "Mass of a node of one ply (M7), the same for edge nodes"),
    real("sheet.yarn_area", |s| one(&mut s.sheet.yarn_area), &AREA, Range::Positive, 224,
        "Cross-section A_0 of a yarn of one ply (M4)"),
    real("sheet.yarn_area_y", |s| one(&mut s.sheet.yarn_area_y), &AREA, Range::NotNegative, 621,
        "Cross-section of a yarn along y; 0: as along x").image(Image::Later(0x7_0001)),
    shaped("sheet.crimp", Place::Reals(|s| &mut s.sheet.crimp, &[2]), &RATIO, Range::Within(0.0, 1.0), 622,
        "Crimp of the yarns along x and along y: natural length of a segment over the node spacing, less 1. A segment pulls only once it is taken up")
        .image(Image::Later(0x7_0002)),
    shaped("sheet.pre_strain", Place::Reals(|s| &mut s.sheet.pre_strain, &[2]), &RATIO, Range::NotNegative, 624,
        "Strain at which the sheet is held along x (two or four sides) and along y (four sides), below critical_stretch - 1 and without crimp: node spacing over the natural length of a segment, less 1. Not with a modulus drawn for every segment")
        .image(Image::Later(0x7_0003)),
    vector("sheet.position", |s| &mut s.sheet.position, &POSITION, Range::Any, 230, "Middle of the sheet in the host's frame"),
    quaternion("sheet.orientation", |s| &mut s.sheet.orientation, 233,
        "Unit quaternion, scalar first, that turns the sheet's axes (normal z) into the host's"),
    count("sheet.grading.largest", |s| &mut s.sheet.grading.largest, Range::Within(0.0, GRADING_LARGEST as f64), 740,
        "Most yarns that one bar stands for, and as many crossings: 2, 4, 8, 16, 32 or 64; 0 or 1 = no grading. Bars grow by factors of two away from the fine part. Not with viscosity, a dependence on the rate of strain, friction or separate plies")
        .image(Image::Later(0x6a_0000)),
    count("sheet.grading.run", |s| &mut s.sheet.grading.run, Range::Within(1.0, 1e6), 741,
        "Bars of each size before the next. Read with grading only").read(graded).image(Image::LaterWhereRead),
    shaped("sheet.grading.centre", Place::Reals(|s| &mut s.sheet.grading.centre, &[2]), &POSITION, Range::Any, 742,
        "Middle of the fine part along x and along y in the sheet's frame, about the expected hit; 0 across a mirror plane. Read with grading only")
        .read(graded).image(Image::LaterWhereRead),
    shaped("sheet.grading.half_width", Place::Reals(|s| &mut s.sheet.grading.half_width, &[2]), &LENGTH, Range::NotNegative, 744,
        "Half the width of the fine part along x and along y. Read with grading only")
        .read(graded).image(Image::LaterWhereRead),
    // ---- Separate plies
    count("stack.plies", |s| &mut s.stack.plies, Range::Within(1.0, MAX_PLIES as f64), 720,
        "Separate plies, each a network with draws of its own, held like the first, that push on each other. Velocity Verlet only; not with mirror planes, a dependence on the rate of strain or a graded network")
        .read(|s| if_so(s.stack.plies != 1)).image(Image::Later(0x69_0000)),
    real("stack.gap", |s| one(&mut s.stack.gap), &LENGTH, Range::NotNegative, 721,
        "Distance of neighbouring plies where they rest, at most a million node spacings; 0: they lie on each other. Read for more than one ply only")
        .read(stacked).image(Image::Later(0x69_1000)),
    flag("stack.turned", |s| &mut s.stack.turned, 722,
        "Every other ply is turned by 90 degrees, so that its warp runs along y; the node spacings must be alike. Read for more than one ply only")
        .read(stacked).image(Image::Later(0x69_2000)),
    // ---- The fabric of the last plies
    count("back.plies", |s| &mut s.back.plies, Range::Within(0.0, MAX_PLIES as f64), 723,
        "The last so many plies, less than stack.plies, are of this fabric; 0: none").image(Image::Later(0x69_3000)),
    of_back("back.node_mass", |s| one(&mut s.back.node_mass), &MASS, Range::Positive, 724, "Mass of a node of a ply (M7)"),
    of_back("back.yarn_area", |s| one(&mut s.back.yarn_area), &AREA, Range::Positive, 725, "Cross-section A_0 of a bar along x (M4)"),
    of_back("back.yarn_area_y", |s| one(&mut s.back.yarn_area_y), &AREA, Range::NotNegative, 726,
        "Cross-section of a bar along y; 0: as along x"),
    Field { place: Place::Reals(|s| &mut s.back.crimp, &[2]), ..of_back("back.crimp", |s| &mut s.back.crimp, &RATIO, Range::Within(0.0, 1.0), 727,
        "Crimp of the yarns along x and along y") },
    of_back("back.modulus_mean", |s| one(&mut s.back.modulus_mean), &MODULUS, Range::Positive, 729, "Mean Young's modulus E of a segment (M3)"),
    of_back("back.modulus_sd", |s| one(&mut s.back.modulus_sd), &MODULUS, Range::NotNegative, 730,
        "Standard deviation of the modulus. Modulus and damage rate are drawn if this or back.damage_sd is not 0"),
    of_back("back.damage_slope", |s| one(&mut s.back.damage_slope), &DAMAGE_SLOPE, Range::Any, 731, "Slope of the damage rate over the modulus (M6)"),
    of_back("back.damage_intercept", |s| one(&mut s.back.damage_intercept), &RATIO, Range::Any, 732,
        "Damage rate at zero modulus (M6); the mean rate must be at least 3"),
    of_back("back.damage_sd", |s| one(&mut s.back.damage_sd), &RATIO, Range::NotNegative, 733,
        "Standard deviation of the damage rate about the line"),
    of_back("back.critical_stretch", |s| one(&mut s.back.critical_stretch), &RATIO, Range::Above(1.0, CRITICAL_STRETCH_MAX), 734,
        "Critical stretch U_c at which damage begins (M5)"),
    of_back("back.weibull_shape", |s| one(&mut s.back.weibull_shape), &RATIO, Range::Within(0.0, WEIBULL_SHAPES[1]), 735,
        "Weibull shape m of the critical strain U_c - 1, at least 1; 0: it is not drawn"),
    of_back("back.weibull_gauge_length", |s| one(&mut s.back.weibull_gauge_length), &LENGTH, Range::NotNegative, 736,
        "Gauge length L at which back.critical_stretch - 1 is the Weibull scale; 0: L is the length of a segment. Counts for drawn strength only"),
    // ---- Attachment
    choice("attachment.kind", &ATTACHMENT, |s| s.attachment.kind as u32, |s, k| pick(&mut s.attachment.kind, &ATTACHMENTS, k), 240,
        "Which nodes are held"),
    real("attachment.disc_inset", |s| one(&mut s.attachment.disc_inset), &LENGTH, Range::NotNegative, 241,
        "Distance of a corner disc's centre from both edges. Read for four corners only").read(four_corners),
    real("attachment.disc_radius", |s| one(&mut s.attachment.disc_radius), &LENGTH, Range::Positive, 242,
        "Radius of the corner discs. Each must hold a node; they may neither overlap nor reach under the projectile. Read for four corners only")
        .read(four_corners),
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
    flag("yarn.stochastic", |s| &mut s.yarn.stochastic, 257, "Modulus and damage rate are drawn; if not, every segment takes the means"),
    choice("yarn.draw", &DRAW, |s| s.yarn.draw as u32, |s, k| pick(&mut s.yarn.draw, &DRAWS, k), 274,
        "What gets a draw of its own. Read for stochastic yarn only")
        .read(|s| if_so(s.yarn.stochastic)).image(Image::Later(0x1_0000)),
    choice("yarn.strength_draw", &STRENGTH_DRAW, |s| s.yarn.strength_draw as u32,
        |s, k| pick(&mut s.yarn.strength_draw, &STRENGTH_DRAWS, k), 660,
        "Whether every segment has a critical stretch of its own, whether or not modulus and damage rate are drawn; not with mirror planes or a toe")
        .image(Image::Later(0x66_0000)),
    real("yarn.weibull_shape", |s| one(&mut s.yarn.weibull_shape), &RATIO, Range::Within(WEIBULL_SHAPES[0], WEIBULL_SHAPES[1]), 661,
        "Weibull shape m of the critical strain U_c - 1. Read for drawn strength only").read(drawn_strength).image(Image::LaterWhereRead),
    real("yarn.weibull_gauge_length", |s| one(&mut s.yarn.weibull_gauge_length), &LENGTH, Range::NotNegative, 662,
        "Gauge length L at which yarn.critical_stretch - 1 is the Weibull scale: that of a segment of length h is larger by (L/h)^(1/m). 0: L is h. Read for drawn strength only")
        .read(drawn_strength).image(Image::LaterWhereRead),
    real("yarn.weibull_correlation", |s| one(&mut s.yarn.weibull_correlation), &RATIO, Range::Within(0.0, 1.0), 663,
        "Correlation of the normal scores of two segments of one woven yarn; the size effect holds along a yarn for 0. Read for drawn strength only, that of the back fabric included")
        .read(|s| drawn_strength(s).max(if_so(s.back.plies > 0 && s.back.weibull_shape != 0.0))).image(Image::LaterWhereRead),
    real("yarn.viscosity_linear", |s| one(&mut s.yarn.viscosity_linear), &RATIO, Range::Within(0.0, 1.0), 640,
        "Viscosity of taut yarn, linear in the rate of stretch, against oscillation behind a front; 0 = none. Velocity Verlet only")
        .image(Image::Later(0x8_0000)),
    real("yarn.viscosity_quadratic", |s| one(&mut s.yarn.viscosity_quadratic), &RATIO, Range::Within(0.0, 10.0), 641,
        "Likewise, quadratic in the rate and only while the yarn is stretched").image(Image::Later(0x8_0001)),
    real("yarn.viscosity_bending", |s| one(&mut s.yarn.viscosity_bending), &RATIO, Range::Within(0.0, 0.2), 642,
        "Viscosity of taut yarn against bending, linear in the second difference of the velocities along it; 0 = none. Velocity Verlet only")
        .image(Image::Later(0x8_0002)),
    real("yarn.rate_modulus", |s| one(&mut s.yarn.rate_modulus), &RATIO, Range::Within(0.0, 1.0), 680,
        "Growth C_E of the modulus by e-fold of the rate of strain above yarn.rate_reference (M19); 0 = none. Velocity Verlet only; not with a toe, pre-tension, separate plies or a graded network")
        .image(Image::Later(0x67_0000)),
    real("yarn.rate_stretch", |s| one(&mut s.yarn.rate_stretch), &RATIO, Range::Within(0.0, 1.0), 681,
        "Growth C_U of the critical strain by e-fold of the rate of strain (M20); 0 = none").image(Image::Later(0x67_0001)),
    real("yarn.rate_reference", |s| one(&mut s.yarn.rate_reference), &STRAIN_RATE, Range::Within(0.0, STRAIN_RATES[1]), 682,
        "Rate of strain at which modulus and critical stretch are as given, at least 1e-9/s; slower ones count as this. Read for yarn that depends on the rate only")
        .read(on_rate).image(Image::LaterWhereRead),
    real("yarn.rate_limit", |s| one(&mut s.yarn.rate_limit), &STRAIN_RATE, Range::Within(0.0, STRAIN_RATES[1]), 683,
        "Largest rate of strain measured, at least yarn.rate_reference; faster ones count as this. Read for yarn that depends on the rate only")
        .read(on_rate).image(Image::LaterWhereRead),
    // ---- Yarn along y
    real("weft.modulus_mean", |s| one(&mut s.weft.modulus_mean), &MODULUS, Range::NotNegative, 626,
        "Mean Young's modulus of a segment along y; 0: modulus and damage rate as along x").image(Image::Later(0x7_0004)),
    real("weft.modulus_sd", |s| one(&mut s.weft.modulus_sd), &MODULUS, Range::NotNegative, 627,
        "Standard deviation of the modulus. Read if weft.modulus_mean is not 0").read(own_weft).image(Image::LaterWhereRead),
    real("weft.damage_slope", |s| one(&mut s.weft.damage_slope), &DAMAGE_SLOPE, Range::Any, 628,
        "Slope of the damage rate over the modulus (M6). Read if weft.modulus_mean is not 0").read(own_weft).image(Image::LaterWhereRead),
    real("weft.damage_intercept", |s| one(&mut s.weft.damage_intercept), &RATIO, Range::Any, 629,
        "Damage rate at zero modulus (M6); the mean rate must be at least 3. Read if weft.modulus_mean is not 0").read(own_weft).image(Image::LaterWhereRead),
    real("weft.damage_sd", |s| one(&mut s.weft.damage_sd), &RATIO, Range::NotNegative, 630,
        "Standard deviation of the damage rate about the line. Read if weft.modulus_mean is not 0").read(own_weft).image(Image::LaterWhereRead),
    real("weft.critical_stretch", |s| one(&mut s.weft.critical_stretch), &RATIO, Range::Within(0.0, 2.0), 631,
        "Critical stretch U_c of a segment along y, greater than 1 (M5); 0: as along x").image(Image::Later(0x7_0005)),
    // ---- Projectile
    choice("projectile.shape", &SHAPE, |s| s.projectile.shape as u32, |s, k| pick(&mut s.projectile.shape, &SHAPES, k), 210,
        "Form of the projectile (M12)"),
    real("projectile.radius", |s| one(&mut s.projectile.radius), &LENGTH, Range::Positive, 211,
        "Radius, at least sheet.spacing. Read for a sphere and the two cylinders only").read(round),
    real("projectile.length", |s| one(&mut s.projectile.length), &LENGTH, Range::Positive, 212,
        "Whole length along the axis, at least 2 sheet.spacing, and with a hemispherical end at least the radius. Read for the two cylinders only")
        .read(|s| if_so(matches!(s.projectile.shape, Shape::Cylinder | Shape::HemisphericalCylinder))),
    real("projectile.mass", |s| one(&mut s.projectile.mass), &MASS, Range::Any, 213,
        "Mass, at least that of a node with all its plies. Prescribed projectile: 0 if it is not known"),
    vector("projectile.size", |s| &mut s.projectile.size, &LENGTH, Range::Positive, 214,
        "Edge lengths of a box along the body's axes, each at least 2 sheet.spacing. Read for a box only")
        .read(|s| if_so(s.projectile.shape == Shape::Box)).image(Image::WhereRead),
    count("projectile.faces.count", |s| &mut s.projectile.faces.count, Range::Within(0.0, 16.0), 264,
        "Number of faces of a polyhedron, 4 to 16. Read for a polyhedron only")
        .read(|s| if_so(s.projectile.shape == Shape::Polyhedron)).image(Image::WhereRead),
    shaped("projectile.faces.planes", Place::Reals(|s| s.projectile.faces.planes.as_flattened_mut(), &[MAX_FACES, 4]), &RATIO, Range::Any, 500,
        "Of each face the outward unit normal (to 1e-6) and its distance from the centre of mass in m, at least sheet.spacing. Beyond the count not read")
        .read(|s| if s.projectile.shape == Shape::Polyhedron { 4 * s.projectile.faces.in_use().len() } else { 0 })
        .image(Image::WhereRead),
    vector("projectile.moments", |s| &mut s.projectile.moments, &INERTIA, Range::Positive, 265,
        "Principal moments of inertia about the centre of mass along the body's axes, none greater than the other two together. Read for a polyhedron of known mass only; other shapes are homogeneous")
        .read(|s| if_so(s.projectile.shape == Shape::Polyhedron && s.projectile.mass != 0.0)).image(Image::WhereRead),
    vector("projectile.position", |s| &mut s.projectile.position, &POSITION, Range::Any, 600,
        "Centre of mass at the start. No node may lie inside the projectile (a fixed one may in a prescribed one)").image(Image::Never),
    vector("projectile.velocity", |s| &mut s.projectile.velocity, &VELOCITY, Range::Any, 603,
        "Velocity of the centre of mass at the start. No point of the surface may cross sheet.spacing in a step").image(Image::Never),
    quaternion("projectile.orientation", |s| &mut s.projectile.orientation, 606,
        "Orientation at the start: unit quaternion, scalar first, that turns body vectors into the host's axes").image(Image::Never),
    vector("projectile.angular_velocity", |s| &mut s.projectile.angular_velocity, &ANGULAR_VELOCITY, Range::Any, 610,
        "Angular velocity at the start, host's axes").image(Image::Never),
    real("projectile.sector.inner_radius", |s| one(&mut s.projectile.sector.inner_radius), &LENGTH, Range::NotNegative, 294,
        "Radius of the bore, 0 or between 1e-6 and 1 - 1e-6 of that of the rim; filled up to its one chord. Read for a disc sector only").read(sector).image(Image::WhereRead),
    real("projectile.sector.outer_radius", |s| one(&mut s.projectile.sector.outer_radius), &LENGTH, Range::Positive, 295,
        "Radius of the rim, which is made of eight chords; no face may be nearer to the centre of mass than sheet.spacing. Read for a disc sector only")
        .read(sector).image(Image::WhereRead),
    real("projectile.sector.angle", |s| one(&mut s.projectile.sector.angle), &ANGLE, Range::Below(1e-3, core::f64::consts::PI), 296,
        "Angle of a disc sector. Read for a disc sector only").read(sector).image(Image::WhereRead),
    real("projectile.sector.thickness", |s| one(&mut s.projectile.sector.thickness), &LENGTH, Range::Positive, 297,
        "Thickness along the disc's axis, at least 2 sheet.spacing. Read for a disc sector only").read(sector).image(Image::WhereRead),
    // ---- Contact
    real("contact.friction", |s| one(&mut s.contact.friction), &RATIO, Range::Within(0.0, 10.0), 700,
        "Coefficient of Coulomb friction between yarn and projectile (M21); 0 = none. With it a sphere turns, too. Velocity Verlet only; not with a graded network")
        .image(Image::Later(0x68_0000)),
    // ---- Mirror planes
    flag("symmetry.mirror_x", |s| &mut s.symmetry.mirror_x, 280,
        "Mirror plane x = 0. Sums stay those of the whole sheet. For uniform yarn, a free projectile and a centred, untilted hit")
        .image(Image::Later(0x2_0000)),
    flag("symmetry.mirror_y", |s| &mut s.symmetry.mirror_y, 281, "Mirror plane y = 0, likewise").image(Image::Later(0x2_0000)),
    // ---- Who moves the projectile, and how the nodes are stepped
    choice("drive", &DRIVE, |s| s.drive as u32, |s, k| pick(&mut s.drive, &DRIVES, k), 200, "Who moves the projectile"),
    choice("integrator.kind", &INTEGRATOR, |s| s.integrator.kind as u32, |s, k| pick(&mut s.integrator.kind, &INTEGRATORS, k), 282,
        "Velocity Verlet (M7), or the paper's theta rule (M10)").image(Image::Later(0x2_FFFF)),
    real("integrator.theta", |s| one(&mut s.integrator.theta), &RATIO, Range::Within(0.5, 1.0), 283,
        "Theta rule: weight of the forces at the step's end (M10); 0.5 is of second order").read(theta_rule).image(Image::LaterWhereRead),
    real("integrator.tolerance", |s| one(&mut s.integrator.tolerance), &RATIO, Range::Positive, 284,
        "Theta rule: the iteration ends when no node moves by more than this, in node spacings").read(theta_rule).image(Image::LaterWhereRead),
    count("integrator.max_iterations", |s| &mut s.integrator.max_iterations, Range::Within(1.0, u32::MAX as f64), 285,
        "Theta rule: iterations after which a step fails").read(theta_rule).image(Image::LaterWhereRead),
    row("seed", Place::Seed(|s| &mut s.seed), Range::Any, 260, "Seed of the draws"),
    // ---- Time step
    real("time_step.fraction", |s| one(&mut s.time_step.fraction), &RATIO, Range::Positive, 286,
        "Time step as a fraction of dt_crit (M11), at most 0.5 (0.433 with a toe). Read if time_step.seconds is 0")
        .read(|s| if_so(s.time_step.seconds == 0.0)).image(Image::Never),
    real("time_step.seconds", |s| one(&mut s.time_step.seconds), &DURATION, Range::NotNegative, 261,
        "Time step in seconds, at most 0.5 dt_crit (0.433 with a toe); 0: time_step.fraction says it").image(Image::StepInUse),
    choice("step_check", &STEP_CHECK, |s| s.step_check as u32, |s, k| pick(&mut s.step_check, &STEP_CHECKS, k), 287,
        "Whether the time step is checked against its limit").image(Image::Never),
    choice("step_after_failure", &STEP_AFTER_FAILURE, |s| s.step_after_failure as u32,
        |s, k| pick(&mut s.step_after_failure, &STEPS_AFTER_FAILURE, k), 288,
        "The step from the first failed segment on (M9). Velocity Verlet only").image(Image::Later(0x5_0000)),
    real("slack_toe", |s| one(&mut s.slack_toe), &RATIO, Range::NotNegative, 289,
        "Toe: Green-Lagrange strain over which the stiffness of a segment sets in that has been slack after the first failure, in [0.005, 0.05] and not beyond that of U_c; 0 = none. Velocity Verlet only")
        .image(Image::Later(0x6_0000)),
    choice("rotation_rule.kind", &ROTATION, |s| s.rotation_rule.kind as u32, |s, k| pick(&mut s.rotation_rule.kind, &ROTATIONS, k), 290,
        "The implicit midpoint rule, or the paper's theta rule").image(Image::Later(0x3_FFFF)),
    real("rotation_rule.theta", |s| one(&mut s.rotation_rule.theta), &RATIO, Range::Within(0.5, 1.0), 291,
        "Theta rule of the rotation: weight of the step's end")
        .read(|s| if_so(s.rotation_rule.kind == RotationKind::Theta)).image(Image::LaterWhereRead),
    // ---- What is watched, and room
    real("force_window", |s| one(&mut s.force_window), &DURATION, Range::Positive, 262,
        "Window of the peak force, rounded to whole steps, at least one. Until the first is full the peak force is the mean over the time elapsed"),
    flag("track_detachment", |s| &mut s.track_detachment, 263,
        "Watch whether the touched nodes are still held (4 bytes a node); without it a projectile that carries torn cloth never exits"),
    flag("track_support", |s| &mut s.track_support, 292, "Sum the impulses on the supports; the momentum residual needs them"),
    count("contact_capacity", |s| &mut s.contact_capacity, Range::Any, 293,
        "Most nodes closer than sheet.spacing to the projectile at once, 116 bytes each (124 with the theta rule, 268 with friction); more are a failure. 0 = every node")
        .image(Image::Never),
];

fn one(number: &mut f64) -> &mut [f64] {
    core::slice::from_mut(number)
}

fn four_corners(scene: &Scene) -> usize {
    if_so(scene.attachment.kind == AttachmentKind::FourCorners)
}

fn graded(scene: &Scene) -> usize {
    if_so(scene.is_graded())
}

fn stacked(scene: &Scene) -> usize {
    if_so(scene.stack.plies > 1)
}

fn own_weft(scene: &Scene) -> usize {
    if_so(scene.weft.modulus_mean != 0.0)
}

fn round(scene: &Scene) -> usize {
    if_so(matches!(scene.projectile.shape, Shape::Sphere | Shape::Cylinder | Shape::HemisphericalCylinder))
}

fn sector(scene: &Scene) -> usize {
    if_so(scene.projectile.shape == Shape::DiscSector)
}

fn drawn_strength(scene: &Scene) -> usize {
    if_so(scene.yarn.strength_draw != StrengthDraw::None)
}

fn on_rate(scene: &Scene) -> usize {
    if_so(scene.depends_on_rate())
}

fn theta_rule(scene: &Scene) -> usize {
    if_so(scene.integrator.kind == IntegratorKind::Theta)
}

/// Number of elements of all parameters together.
pub const SLOTS: usize = slot_of(FIELDS.len());

/// Number of elements before a row: where it stands in the C structure, in words of 64 bits, behind the first.
pub const fn slot_of(row: usize) -> usize {
    let (mut slots, mut k) = (0, 0);
    while k < row && k < FIELDS.len() {
        slots += FIELDS[k].size();
        k += 1;
    }
    slots
}

/// The row of a name.
pub fn field(name: &str) -> Option<&'static Field> {
    FIELDS.iter().find(|field| field.name == name)
}

/// Refuses the first number, in the order of the table, that cannot be, whatever the others are. What the scene does not read may
/// be anything.
#[inline(never)]
pub fn check(scene: &Scene) -> Result<(), Error> {
    let mut copy = *scene;
    for field in FIELDS {
        let read = (field.read)(scene).min(field.size());
        for element in 0..read {
            field.check_element(field.value_of(field.word(&mut copy, element)))?;
        }
        if let (Range::UnitQuaternion, Place::Reals(place, _)) = (field.range, field.place)
            && let Some(quaternion) = place(&mut copy).first_chunk()
        {
            unit_quaternion(field.name, *quaternion)?;
        }
    }
    Ok(())
}

/// Shows the words of a scene's fingerprint, in their order. `dt`: the step in use, s.
#[inline(never)]
pub fn fingerprint_words(scene: &Scene, dt: f64, take: &mut impl FnMut(u64)) {
    let mut copy = *scene;
    for field in FIELDS {
        let elements = match field.image {
            Image::Always => field.size(),
            Image::WhereRead => (field.read)(scene).min(field.size()),
            Image::StepInUse => {
                take(dt.to_bits());
                0
            }
            Image::Later(_) | Image::LaterWhereRead | Image::Never => 0,
        };
        (0..elements).for_each(|element| take(field.word(&mut copy, element)));
    }
    for (k, field) in FIELDS.iter().enumerate() {
        let read = (field.read)(scene).min(field.size());
        let shares = |other: &&Field| other.image == field.image;
        match field.image {
            Image::LaterWhereRead => (0..read).for_each(|element| take(field.word(&mut copy, element))),
            Image::Later(_) if FIELDS.iter().take(k).any(|other| shares(&other)) => {} // shown with the first
            Image::Later(tag) if field.is_real() => {
                let used = (0..read).any(|element| field.value_of(field.word(&mut copy, element)) != 0.0);
                if used {
                    take(tag);
                    (0..read).for_each(|element| take(field.word(&mut copy, element)));
                }
            }
            Image::Later(tag) if read > 0 => {
                let bits = FIELDS.iter().filter(shares).enumerate();
                let sum = bits.map(|(bit, other)| other.word(&mut copy, 0) << bit).sum::<u64>();
                if sum > 0 {
                    take(tag + sum);
                }
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;
    use std::format;
    use std::string::{String, ToString};
    use std::vec::Vec;

    /// Every number of a scene by its path, as the scene's own debug output has them.
    fn numbers(scene: &Scene) -> BTreeMap<String, String> {
        let (mut path, mut found, mut deep) = (Vec::new(), BTreeMap::new(), 0);
        for line in format!("{scene:#?}").lines().skip(1) {
            let line = line.trim();
            let (name, value) = line.split_once(": ").unwrap_or(("", line));
            if deep > 0 || value == "[" {
                // Within an array all belongs to its name.
                if deep == 0 {
                    path.push(name.to_string());
                }
                deep += usize::from(value == "[");
                deep -= usize::from(value.starts_with(']'));
                found.entry(path.join(".")).or_insert_with(String::new).push_str(value);
                if deep == 0 {
                    path.pop();
                }
            } else if value.ends_with('{') {
                path.push(name.to_string());
            } else if line.starts_with('}') {
                path.pop();
            } else {
                path.push(name.to_string());
                found.insert(path.join("."), value.to_string());
                path.pop();
            }
        }
        found
    }

    #[test]
    fn every_number_of_a_scene_has_a_row_of_its_name() {
        let names: Vec<_> = numbers(&Scene::sheet_3in_sphere()).into_keys().collect();
        for name in &names {
            assert!(field(name).is_some(), "{name} has no row in the table");
        }
        for field in FIELDS {
            assert!(names.iter().any(|name| name == field.name), "{} is no field of a scene", field.name);
        }
        assert_eq!(names.len(), FIELDS.len());
    }

    #[test]
    fn a_row_reads_and_sets_the_number_that_it_names_and_no_other() {
        for field in FIELDS {
            for element in [0, field.size() - 1] {
                let mut scene = Scene::sheet_3in_sphere();
                let before = numbers(&scene);
                let old = field.word(&mut scene, element);
                let new = if field.is_real() { 1234.5_f64.to_bits() } else { 1 - old.min(1) };
                field.set_word(&mut scene, element, new).unwrap();
                assert_eq!(field.word(&mut scene, element), new, "{}", field.name);
                let after = numbers(&scene);
                let changed: Vec<_> = after.iter().filter(|(name, value)| before[*name] != **value).collect();
                assert!(changed.len() == 1 && changed[0].0 == field.name, "{}: {changed:?}", field.name);
                if field.is_real() {
                    assert_eq!(changed[0].1.matches("1234.5").count(), 1, "{}", field.name);
                }
            }
        }
    }

    #[test]
    fn choices_are_those_of_the_scene_in_their_order() {
        let mut scene = Scene::sheet_3in_sphere();
        for field in FIELDS {
            let Place::Choice(choice, get, _) = field.place else { continue };
            assert!(CHOICES.contains(&choice), "{}", field.name);
            for (number, (item, _)) in choice.items.iter().enumerate() {
                field.set_word(&mut scene, 0, number as u64).unwrap();
                assert_eq!(get(&scene) as usize, number, "{}", field.name);
                let named = numbers(&scene)[field.name].trim_end_matches(',').to_lowercase();
                assert_eq!(named, item.replace('_', ""), "{}", field.name);
            }
            let error = field.set_word(&mut scene, 0, choice.items.len() as u64).unwrap_err();
            assert_eq!((error.code, error.field), (Code::UnknownChoice, field.name));
        }
    }

    #[test]
    fn names_references_and_groups_do_not_overlap() {
        let (mut names, mut references) = (BTreeMap::new(), BTreeMap::new());
        for (k, row) in FIELDS.iter().enumerate() {
            assert!(names.insert(row.name, k).is_none(), "{}", row.name);
            for element in 0..row.size() as u32 {
                assert!(references.insert(row.fmi + element, k).is_none(), "{}: {}", row.name, row.fmi + element);
            }
            assert_eq!(row.is_real(), row.quantity.is_some(), "{}", row.name);
            // Rows of a group stand together: C has one structure for them.
            if let Some((group, _)) = row.name.rsplit_once('.') {
                assert!(GROUPS.iter().any(|(name, _)| *name == group), "{group} is not among the groups");
                let of_it = |field: &&Field| field.name.starts_with(&format!("{group}."));
                let first = FIELDS.iter().position(|field| of_it(&field)).unwrap();
                assert!(FIELDS[first..=k].iter().all(|field| of_it(&field)), "{} stands apart", row.name);
            }
        }
    }

    /// Words of the fingerprint that tell one option from all others. Rows of one word are flags, which share its low bits.
    #[test]
    fn options_have_words_of_their_own() {
        let mut taken = Vec::new();
        for (k, row) in FIELDS.iter().enumerate() {
            let Image::Later(tag) = row.image else { continue };
            let sharing: Vec<_> = FIELDS.iter().filter(|other| other.image == row.image).collect();
            let flags = sharing.iter().all(|other| matches!(other.place, Place::Flag(_)));
            assert!(sharing.len() == 1 || flags, "{}: its word is that of another row", row.name);
            let last = match row.place {
                Place::Choice(choice, ..) => tag + choice.items.len() as u64 - 1,
                Place::Flag(_) => tag + (1 << sharing.len()) - 1,
                _ => tag,
            };
            let first = if row.is_real() { tag } else { tag + 1 };
            if FIELDS[..k].iter().all(|other| other.image != row.image) {
                let apart = |&(from, to): &(u64, u64)| last < from || to < first;
                assert!(taken.iter().all(apart), "{}: its words are those of another row", row.name);
                taken.push((first, last));
            }
        }
    }

    /// A row that always counts changes the fingerprint, and so every digest, of all scenes: none may join these.
    #[test]
    fn no_more_rows_count_always() {
        let mut always = FIELDS.iter().filter(|row| row.image == Image::Always).map(|row| row.name);
        assert_eq!(always.clone().count(), 30, "a new parameter is Image::Later: {:?}", always.next_back());
    }

    #[test]
    fn defaults_lie_in_their_ranges() {
        for mut scene in [Scene::sheet_3in_sphere(), Scene::sheet_10in_cylinder(), Scene::turbine_disc_sector()] {
            check(&scene).unwrap();
            for field in FIELDS {
                let [least, greatest] = field.limits();
                let value = field.value_of(field.word(&mut scene, 0));
                assert!(least <= value && value <= greatest, "{}", field.name);
            }
        }
    }
}
