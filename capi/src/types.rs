//! Structures and constants of the C interface. SI units; vectors in the host's frame; quaternions scalar first.
#![allow(non_camel_case_types)] // C names.

use core::ffi::c_char;
use fabric::{
    Attachment, AttachmentKind, Code, Draw, Drive, Error, Faces, Integrator, IntegratorKind, Motion, Projectile,
    RotationKind, RotationRule, Scene, Shape, Sheet, StepAfterFailure, StepCheck, Symmetry, TimeStep, Yarn,
};

/// Version of this interface: goes up whenever a structure or a function is added. A host needs a library of at least its own.
pub const FK_ABI_VERSION: u32 = 3;

/// Success.
pub const FK_OK: i32 = 0;
/// A pointer is null.
pub const FK_NULL_POINTER: i32 = -1;
/// A buffer is shorter than the size query said.
pub const FK_SHORT_BUFFER: i32 = -2;
/// A memory block is not aligned as the size query said.
pub const FK_MISALIGNED: i32 = -3;
/// The block was moved, copied or never initialised: use save and load.
pub const FK_MOVED_BLOCK: i32 = -4;
/// A structure does not carry a known `struct_size`.
pub const FK_STRUCT_SIZE: i32 = -5;
/// A number is NaN or infinite.
pub const FK_NOT_FINITE: i32 = -6;
/// A number must be greater than zero.
pub const FK_NOT_POSITIVE: i32 = -7;
/// A number lies outside its range.
pub const FK_OUT_OF_RANGE: i32 = -8;
/// A choice has an unknown number.
pub const FK_UNKNOWN_CHOICE: i32 = -9;
/// A quaternion is not of unit length (to 1e-3).
pub const FK_BAD_QUATERNION: i32 = -10;
/// The sheet has more nodes than memory can address.
pub const FK_TOO_MANY_NODES: i32 = -11;
/// The time step exceeds the largest allowed one; the fault's `limit` holds it.
pub const FK_STEP_TOO_LARGE: i32 = -12;
/// The parameters give no usable time step: none at all, or one with which no calculation stays within the numbers.
pub const FK_STEP_LIMIT_UNUSABLE: i32 = -13;
/// A damage rate below 3.
pub const FK_DAMAGE_RATE_TOO_SMALL: i32 = -14;
/// The projectile is lighter than one node.
pub const FK_PROJECTILE_TOO_LIGHT: i32 = -15;
/// The projectile is smaller than the node spacing.
pub const FK_PROJECTILE_TOO_SMALL: i32 = -16;
/// The projectile would cross more than one node spacing in a step, or turn more than half a radian; the fault's `limit`
/// holds the largest step, s, with which the motion is accepted.
pub const FK_PROJECTILE_TOO_FAST: i32 = -17;
/// A node lies inside the projectile at the start.
pub const FK_INITIAL_OVERLAP: i32 = -18;
/// The corner discs overlap one another.
pub const FK_DISCS_OVERLAP: i32 = -19;
/// A corner disc reaches under the projectile.
pub const FK_DISC_TOUCHES_PROJECTILE: i32 = -20;
/// An array does not have the length asked for.
pub const FK_WRONG_LENGTH: i32 = -21;
/// The call does not fit the way the projectile is driven.
pub const FK_WRONG_DRIVE: i32 = -22;
/// A path does not fit the simulation's time.
pub const FK_BAD_PATH: i32 = -23;
/// Only allowed before the first step.
pub const FK_ALREADY_STARTED: i32 = -24;
/// The bytes are not a snapshot image, or were altered.
pub const FK_IMAGE_MALFORMED: i32 = -25;
/// The image is of another scene or version.
pub const FK_IMAGE_OF_ANOTHER_SCENE: i32 = -26;
/// The image holds values that no simulation can have.
pub const FK_IMAGE_INVALID: i32 = -27;
/// A face's normal is not of unit length (to 1e-6).
pub const FK_BAD_NORMAL: i32 = -28;
/// The faces of a polyhedron do not enclose a body.
pub const FK_UNBOUNDED_FACES: i32 = -29;
/// One moment of inertia is greater than the other two together.
pub const FK_IMPOSSIBLE_MOMENTS: i32 = -30;
/// Mirror planes with something they would change.
pub const FK_NOT_SYMMETRIC: i32 = -31;
/// The scene asks for something this library was built without.
pub const FK_NOT_BUILT: i32 = -32;
/// A band that was called already in this pass, or a call that does not go with bands in use, or without them.
pub const FK_BAND_OUT_OF_TURN: i32 = -33;
/// The theta rule cannot be stepped in bands.
pub const FK_NOT_IN_BANDS: i32 = -34;
/// The corner discs lie between the nodes and hold none; the fault's `limit` holds the smallest radius, m, that reaches one.
pub const FK_HOLDS_NOTHING: i32 = -35;
/// Numerical failure: a non-finite number appeared, or a stretch beyond 1e25; the state is lost until reset or load.
pub const FK_NON_FINITE: i32 = -50;
/// Numerical failure: more nodes under the projectile than a `contact_capacity` other than 0; the state is that of the
/// step's start.
pub const FK_CONTACT_CAPACITY: i32 = -51;
/// Numerical failure: the projectile became faster than one node spacing in a step.
pub const FK_TOO_FAST: i32 = -52;
/// The theta rule's iteration did not converge; the state is kept at the step's start. Take a smaller step.
pub const FK_NOT_CONVERGED: i32 = -53;

/// Most bands for fk_bands_begin.
pub const FK_MAX_BANDS: u32 = 32;

/// Preset of the paper's 3 in sheet (105 x 105) with four sides held and the 8.4 g sphere.
pub const FK_PRESET_SHEET_3IN_SPHERE: u32 = 0;
/// Preset of the paper's 10 in sheet (350 x 350) with two sides held and the 37 g cylinder.
pub const FK_PRESET_SHEET_10IN_CYLINDER: u32 = 1;
/// Preset of the 10 in sheet with four sides held and a third of a small turbine disc, rim first, as a polyhedron.
pub const FK_PRESET_TURBINE_DISC_SECTOR: u32 = 2;
/// First and last column fixed.
pub const FK_TWO_SIDES: u32 = 0;
/// The whole edge fixed.
pub const FK_FOUR_SIDES: u32 = 1;
/// Discs near the corners fixed.
pub const FK_FOUR_CORNERS: u32 = 2;
/// No node fixed.
pub const FK_FREE_SHEET: u32 = 3;
/// Sphere.
pub const FK_SPHERE: u32 = 0;
/// Flat-ended cylinder along the body's z axis.
pub const FK_CYLINDER: u32 = 1;
/// Cylinder along the body's z axis with a hemisphere at its +z end.
pub const FK_HEMISPHERICAL_CYLINDER: u32 = 2;
/// Box with its edges along the body's axes.
pub const FK_BOX: u32 = 3;
/// Convex polyhedron by its faces.
pub const FK_POLYHEDRON: u32 = 4;
/// Largest number of faces of a polyhedron.
pub const FK_MAX_FACES: usize = 16;
/// Velocity Verlet, explicit.
pub const FK_VERLET: u32 = 0;
/// The projectile turns by the implicit midpoint rule, which keeps energy and angular momentum.
pub const FK_MIDPOINT: u32 = 0;
/// The theta rule (only in a library built with the feature `implicit`; else FK_NOT_BUILT).
pub const FK_THETA: u32 = 1;
/// The step stays after the first failure.
pub const FK_STEP_KEEP: u32 = 0;
/// The step is taken as two halves after the first failure.
pub const FK_STEP_HALF: u32 = 1;
/// Every segment draws its own constants.
pub const FK_DRAW_SEGMENT: u32 = 0;
/// Every woven yarn, a row or a column of segments, draws its own constants.
pub const FK_DRAW_YARN: u32 = 1;
/// The kernel moves the projectile.
pub const FK_DRIVE_FREE: u32 = 0;
/// The host prescribes the projectile's pose.
pub const FK_DRIVE_PRESCRIBED: u32 = 1;
/// `step_value` is a fraction of dt_crit.
pub const FK_STEP_FRACTION: u32 = 0;
/// `step_value` is in seconds.
pub const FK_STEP_SECONDS: u32 = 1;
/// Refuse a step above 0.5 dt_crit.
pub const FK_STEP_CHECK_REFUSE: u32 = 0;
/// No check, for stability studies only.
pub const FK_STEP_CHECK_NONE: u32 = 1;
/// Bit of the outcome "arrested" in masks.
pub const FK_ARRESTED: u32 = 1;
/// Bit of the outcome "detached".
pub const FK_DETACHED: u32 = 2;
/// Bit of the outcome "exited".
pub const FK_EXITED: u32 = 4;
/// Bit of the outcome "passed".
pub const FK_PASSED: u32 = 8;

/// fk_outcome's status: no contact in the last step and no outcome yet.
pub const FK_STATUS_FLIGHT: u32 = 0;
/// fk_outcome's status: contact in the last step, no outcome yet.
pub const FK_STATUS_CONTACT: u32 = 1;
/// fk_outcome's status: the velocity along the direction at first contact fell to 0 or below.
pub const FK_STATUS_ARRESTED: u32 = 2;
/// fk_outcome's status: no node touched in the last 64 steps is connected to a support any more.
pub const FK_STATUS_DETACHED: u32 = 3;
/// fk_outcome's status: the projectile goes on and its contact with the fabric is over (docs/model.md, "Outcomes").
pub const FK_STATUS_EXITED: u32 = 4;
/// fk_outcome's status: no contact, and none to come: the projectile leaves the sheet's box for good.
pub const FK_STATUS_PASSED: u32 = 5;

/// A step count that has not happened.
pub const FK_NEVER: u64 = u64::MAX;

/// What is simulated. Fill it with fk_scene_default or fk_scene_preset, then change fields. The first bad field is named by
/// fk_scene_check and fk_init. "Default" is what fk_scene_default gives; where the 3 in preset differs it is said.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct fk_scene {
    /// Bytes of this structure; set by fk_scene_default and fk_scene_preset.
    pub struct_size: u64,
    /// Nodes along x, 2 to 1048576. Default 350 (3 in preset: 105).
    pub sheet_nodes_x: u32,
    /// Nodes along y, 2 to 1048576. Default 350 (3 in preset: 105).
    pub sheet_nodes_y: u32,
    /// Node spacing = rest length h of a segment (M1), m, > 0. Default 0.0254/35.
    pub sheet_spacing: f64,
    /// Mass of a node of one ply (M7), kg, > 0; edge nodes too. Default 6.52e-8.
    pub sheet_node_mass: f64,
    /// Cross-section A_0 of a yarn of one ply (M4), m^2, > 0. Default 1.075e-7.
    pub sheet_yarn_area: f64,
    /// Coincident plies lumped into one network: mass and area are multiplied. 1 to 1000. Default 1.
    pub sheet_plies: u32,
    /// Which nodes are fixed: FK_TWO_SIDES, FK_FOUR_SIDES, FK_FOUR_CORNERS or FK_FREE_SHEET. Default FK_TWO_SIDES (3 in
    /// preset: FK_FOUR_SIDES).
    pub attachment_kind: u32,
    /// Origin of the sheet's frame, its middle, in the host's frame, m. Finite. Default 0.
    pub sheet_position: [f64; 3],
    /// Orientation of the sheet's frame in the host's, unit quaternion (to 1e-3). The sheet lies in its own plane z =
    /// 0. Default (1, 0, 0, 0).
    pub sheet_orientation: [f64; 4],
    /// Four corners: distance of a disc's centre from both edges, m, >= 0. Default 25.4e-3 (3 in preset: 7.62e-3). Read
    /// for FK_FOUR_CORNERS only.
    pub attachment_disc_inset: f64,
    /// Four corners: radius of the discs, m, > 0; they may neither overlap nor reach under the projectile. Default
    /// 19.05e-3 (3 in preset: 5.715e-3). Read for FK_FOUR_CORNERS only.
    pub attachment_disc_radius: f64,
    /// Mean Young's modulus E of the yarn (M3), Pa, > 0. Default 140.21e9.
    pub yarn_modulus_mean: f64,
    /// Standard deviation of the modulus, Pa, >= 0. Default 2.04e9. Counts for stochastic yarn only.
    pub yarn_modulus_sd: f64,
    /// Slope of the damage rate over the modulus (M6), 1/Pa. Default 7.91e-9.
    pub yarn_damage_slope: f64,
    /// Damage rate at zero modulus (M6), dimensionless; the mean rate must be >= 3. Default -878.46.
    pub yarn_damage_intercept: f64,
    /// Standard deviation of the damage rate about M6, dimensionless, >= 0. Default 8.35. Counts for stochastic yarn
    /// only.
    pub yarn_damage_sd: f64,
    /// Critical stretch U_c (M5), dimensionless, in (1, 2]. Default 1.03.
    pub yarn_critical_stretch: f64,
    /// Factor A of the damage law (M5), dimensionless, > 0, with A (1 - B) in (0, 1] to rounding. Default 1.
    pub yarn_damage_a: f64,
    /// Offset B of the damage law (M5), dimensionless, < 1. Default 0.
    pub yarn_damage_b: f64,
    /// alpha (M5) at or below this becomes 0, in [0, 1). Default 0.01.
    pub yarn_alpha_fail: f64,
    /// 1: modulus and damage rate are drawn (yarn_draw); 0: all segments take the means. Default 1.
    pub yarn_stochastic: u32,
    /// FK_SPHERE, FK_CYLINDER, FK_HEMISPHERICAL_CYLINDER, FK_BOX or FK_POLYHEDRON (M12). Default FK_CYLINDER (3 in
    /// preset: FK_SPHERE).
    pub projectile_shape: u32,
    /// Radius, m, >= sheet_spacing. Default 6.35e-3. Not read for a box or a polyhedron.
    pub projectile_radius: f64,
    /// Whole length of a cylinder, m, >= 2 sheet_spacing, with a hemispherical end >= the radius too. Default 38.1e-3.
    /// Read for the two cylinders only.
    pub projectile_length: f64,
    /// Mass, kg, at least that of a node with all its plies; 0 = not known, only with FK_DRIVE_PRESCRIBED. Default
    /// 0.037 (3 in preset: 8.4e-3).
    pub projectile_mass: f64,
    /// Centre of mass at the start, host's frame, m. No node may lie inside the projectile (a fixed one inside a
    /// prescribed body may). Default (0, 0, -0.01905): it touches the sheet (3 in preset: (0, 0, -6.35e-3)).
    pub projectile_position: [f64; 3],
    /// Velocity at the start, host's axes, m/s. (Speed + spin times reach) times dt must be less than sheet_spacing.
    /// Default (0, 0, 100).
    pub projectile_velocity: [f64; 3],
    /// Orientation at the start, body to host, unit quaternion (to 1e-3). Default (1, 0, 0, 0).
    pub projectile_orientation: [f64; 4],
    /// Angular velocity at the start, host's axes, rad/s. Default 0.
    pub projectile_angular_velocity: [f64; 3],
    /// Seed of the stochastic yarn, any number. Default 1.
    pub seed: u64,
    /// FK_STEP_FRACTION: fraction of dt_crit (M11), in (0, 0.5]. FK_STEP_SECONDS: the step, s, > 0, at most 0.5
    /// dt_crit. Default 0.4; where the fabric's own energies matter 0.2 (docs/stability.md).
    pub step_value: f64,
    /// Window of the peak force, s, > 0; rounded to whole steps, at least one. Until the first is full the peak force is the
    /// mean over the time elapsed. Default 1e-6.
    pub force_window: f64,
    /// FK_STEP_FRACTION or FK_STEP_SECONDS. Default FK_STEP_FRACTION.
    pub step_kind: u32,
    /// FK_STEP_CHECK_REFUSE or FK_STEP_CHECK_NONE. Default FK_STEP_CHECK_REFUSE.
    pub step_check: u32,
    /// FK_DRIVE_FREE or FK_DRIVE_PRESCRIBED. Default FK_DRIVE_FREE.
    pub drive: u32,
    /// 1: watch whether the touched nodes are still held, for the outcome "detached" (4 bytes a node). Default 1. With 0 a
    /// projectile that carries torn cloth is never said to have exited.
    pub track_detachment: u32,
    /// 1: sum the impulses on the supports, for fk_get_support and fk_get_momentum_residual. Default 1.
    pub track_support: u32,
    /// Most nodes closer than sheet_spacing to the projectile at once; each takes 116 bytes (124 with the theta rule), more
    /// nodes are the failure FK_CONTACT_CAPACITY. 0 = every node modelled, which cannot be exceeded. A smaller number is
    /// for tight memory; docs/embedding.md says how to choose it. Default 0.
    pub contact_capacity: u32,
    /// Box: edge lengths along the body's axes, m, each >= 2 sheet_spacing. Default 12.7e-3 each. Read for a box only.
    pub projectile_size: [f64; 3],
    /// Polyhedron: principal moments of inertia about the centre of mass along the body's axes, kg m^2, > 0, none
    /// greater than the other two together. Default 0. Read for a polyhedron of known mass only; other shapes are
    /// homogeneous.
    pub projectile_moments: [f64; 3],
    /// Polyhedron: number of faces, 4 to FK_MAX_FACES. Default 0.
    pub projectile_face_count: u32,
    /// 0. Not read.
    pub reserved: u32,
    /// Polyhedron: of each face the outward unit normal (to 1e-6) and its distance from the centre of mass, m, >=
    /// sheet_spacing; body axes. Default 0. Beyond projectile_face_count not read.
    pub projectile_faces: [[f64; 4]; FK_MAX_FACES],
    /// 1: mirror plane x = 0 through the sheet's middle; only x <= 0 is modelled. Sums stay those of the whole sheet,
    /// read-outs of nodes and segments cover the part (fk_get_grid). For uniform yarn, a free projectile and a centred,
    /// untilted hit. Default 0.
    pub mirror_x: u32,
    /// 1: mirror plane y = 0; only y <= 0 is modelled. Default 0.
    pub mirror_y: u32,
    /// What draws its own constants: FK_DRAW_SEGMENT or FK_DRAW_YARN (a whole row or column). Default FK_DRAW_SEGMENT.
    /// Read for stochastic yarn only.
    pub yarn_draw: u32,
    /// How the nodes are stepped: FK_VERLET (M7), or FK_THETA, the paper's theta rule by fixed-point iteration (M10),
    /// the reference method. Default FK_VERLET.
    pub integrator: u32,
    /// Theta rule: weight of the forces at the step's end (M10), in [0.5, 1]; 0.5 is of second order. Default 0.5. This
    /// and the next two are read for FK_THETA only.
    pub theta: f64,
    /// Theta rule: the iteration ends when no node moves by more than this, in node spacings, > 0. Default 1e-10.
    pub theta_tolerance: f64,
    /// Theta rule: iterations after which a step fails (FK_NOT_CONVERGED), >= 1. Default 500.
    pub theta_max_iterations: u32,
    /// How the projectile turns: FK_MIDPOINT, or FK_THETA, the paper's theta rule (its equations 14 to 16), which does
    /// not conserve. Default FK_MIDPOINT.
    pub rotation_rule: u32,
    /// Theta of the projectile's rotation, in [0.5, 1]. Default 0.5. Read for rotation_rule = FK_THETA only.
    pub rotation_theta: f64,
    /// FK_STEP_KEEP, or FK_STEP_HALF: from the end of the step in which the first segment fails, every step is taken as
    /// two halves (M9; FK_VERLET only). Default FK_STEP_KEEP.
    pub step_after_failure: u32,
    /// 0.
    pub reserved_at_end: u32,
    /// Toe against the energy creep of slack sheets: Green-Lagrange strain over which the stiffness of a segment sets in once
    /// it has been slack after the first failure, in [0.005, 0.05] and not beyond that of U_c; 0 = none (FK_VERLET only). The
    /// largest step is 0.433 dt_crit with it.
    pub slack_toe: f64,
}

/// Why a request was refused or a step failed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct fk_fault {
    /// Set to sizeof(fk_fault) by the caller.
    pub struct_size: u64,
    /// Status number: FK_OK, or an error's.
    pub status: i32,
    /// 0.
    pub reserved: u32,
    /// Offending value in SI units; 0 where none applies.
    pub value: f64,
    /// Limit crossed, SI units; 0 where none applies. For FK_STEP_TOO_LARGE the largest allowed step, s; for
    /// FK_WRONG_LENGTH and FK_SHORT_BUFFER the length wanted.
    pub limit: f64,
    /// Name of the field, zero-terminated, e.g. "sheet.spacing" for sheet_spacing; empty if no single field is to
    /// blame.
    pub field: [c_char; 48],
    /// One line for a log, zero-terminated.
    pub text: [c_char; 168],
}

/// Pose and rates of a rigid body, host's frame. Never grows: it is part of fk_path.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct fk_motion {
    /// Set to sizeof(fk_motion) by the caller.
    pub struct_size: u64,
    /// Centre of mass, m. As input: finite.
    pub position: [f64; 3],
    /// Velocity of the centre of mass, m/s. As input: finite.
    pub velocity: [f64; 3],
    /// Orientation, body to host, unit quaternion, scalar first. As input: of unit length to 1e-3.
    pub orientation: [f64; 4],
    /// Angular velocity, rad/s, host's axes. As input: finite.
    pub angular_velocity: [f64; 3],
}

/// Where the host wants a prescribed body at the end of a communication step.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct fk_path {
    /// Set to sizeof(fk_path) by the caller.
    pub struct_size: u64,
    /// Step count at which the path starts: the present one (fk_get_time), or that of the path being followed.
    pub first: u64,
    /// Length in steps, >= 1; less than half a turn of the body.
    pub steps: u64,
    /// Pose and rates at step first + steps (its own struct_size is checked too). The body gets there by M13.
    pub end: fk_motion,
}

/// The time step and its limits (M11).
#[repr(C)]
#[derive(Clone, Copy)]
pub struct fk_step_limits {
    /// Set to sizeof(fk_step_limits) by the caller.
    pub struct_size: u64,
    /// Step in use, s; constant for the life of the simulation.
    pub dt: f64,
    /// Stability limit of the taut sheet with the stiffest segment drawn (M11), s.
    pub dt_crit: f64,
    /// Largest accepted step, 0.5 dt_crit, s.
    pub step_max: f64,
}

/// What is modelled of the sheet, and so the lengths of the arrays of fk_copy_... and fk_set_...
#[repr(C)]
#[derive(Clone, Copy)]
pub struct fk_grid {
    /// Set to sizeof(fk_grid) by the caller.
    pub struct_size: u64,
    /// Nodes along x: sheet_nodes_x, or what mirror_x leaves of them.
    pub nodes_x: u64,
    /// Nodes along y: sheet_nodes_y, or what mirror_y leaves of them.
    pub nodes_y: u64,
    /// Segments along x, row by row, horizontal / nodes_y in each row.
    pub horizontal: u64,
    /// Segments along y, row by row, nodes_x in each row; in arrays they come after those along x.
    pub vertical: u64,
}

/// Contact sums (M8) since the start or reset, host's axes.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct fk_contact {
    /// Set to sizeof(fk_contact) by the caller.
    pub struct_size: u64,
    /// Impulse on the projectile, N s. A mean force is a difference of two divided by the time between.
    pub impulse: [f64; 3],
    /// Angular impulse on the projectile about its moving centre of mass, N m s.
    pub angular_impulse: [f64; 3],
    /// Work of the projectile on the fabric = energy absorbed, J.
    pub work: f64,
    /// Kinetic energy lost in impacts of nodes, part of the work, J, >= 0.
    pub loss: f64,
    /// Largest mean force over a window of force_window, N, >= 0; until the first window is full the mean force over the
    /// time elapsed.
    pub force_peak: f64,
}

/// Impulses of the sheet and of a free projectile on the supports since the start, N s, host's axes.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct fk_support {
    /// Set to sizeof(fk_support) by the caller.
    pub struct_size: u64,
    /// All together.
    pub total: [f64; 3],
    /// Sides: left (-x), right, bottom (-y), top. Corners: (-,-), (+,-), (-,+), (+,+).
    pub attachments: [[f64; 3]; 4],
}

/// Energies (M15), J.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct fk_energy {
    /// Set to sizeof(fk_energy) by the caller.
    pub struct_size: u64,
    /// Kinetic energy of the projectile, translation and rotation, J, >= 0 (0 if its mass is unknown).
    pub projectile_kinetic: f64,
    /// Kinetic energy of the fabric, J, >= 0.
    pub fabric_kinetic: f64,
    /// Strain energy of the yarns, J, >= 0.
    pub strain: f64,
    /// Energy dissipated by rupture, J, >= 0.
    pub dissipated: f64,
    /// Kinetic energy lost in impacts of nodes, J, >= 0.
    pub contact_loss: f64,
    /// Work of the projectile on the fabric, J.
    pub contact_work: f64,
    /// Work of the external load, J.
    pub external_work: f64,
    /// What the balance (M15) does not close by, J; in a sound run below 1 % of the kinetic energy at impact.
    pub residual: f64,
    /// Change of the audited energy when the step was halved, J; 0 if it was not.
    pub halving: f64,
}

/// Extremes of the fabric at the present time.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct fk_fabric {
    /// Set to sizeof(fk_fabric) by the caller.
    pub struct_size: u64,
    /// Largest distance from the sheet's plane of a node that live segments join to a support, m, >= 0; 0 once all of the sheet
    /// has torn off. Of all nodes if the sheet is free, or if segments have failed and track_detachment is 0.
    pub max_deflection: f64,
    /// Largest stretch (M1) of a live segment, dimensionless; yarns of the presets fail at about 1.05.
    pub max_stretch: f64,
}

/// Counters; available even after a failure.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct fk_counters {
    /// Set to sizeof(fk_counters) by the caller.
    pub struct_size: u64,
    /// Steps taken since the start or reset.
    pub steps: u64,
    /// Segments with alpha = 0 (M5) in the forces of the last step.
    pub failed_segments: u64,
    /// Nodes with a contact impulse in the last step.
    pub contacts: u64,
    /// Contact solves (M8) that ran out of sweeps; harmless below 1 % of the steps.
    pub unconverged: u64,
    /// Most sweeps of one contact solve, at most 200, or 4000 where a fixed node takes an impulse.
    pub most_sweeps: u64,
    /// Most candidate nodes of one step.
    pub most_candidates: u64,
    /// Places for candidate nodes: contact_capacity, or every node modelled.
    pub candidate_capacity: u64,
    /// Deepest penetration met, m, >= 0; rounding in a sound run, and the depth of fixed nodes in a prescribed body, which
    /// passes through supports.
    pub worst_penetration: f64,
    /// Iterations of the theta rule (M10) so far; 0 for FK_VERLET.
    pub iterations: u64,
    /// Most iterations of one step.
    pub most_iterations: u64,
}

/// Outcomes; FK_NEVER for what has not happened.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct fk_outcome {
    /// Set to sizeof(fk_outcome) by the caller.
    pub struct_size: u64,
    /// FK_STATUS_FLIGHT ...: the latest outcome, or contact or flight.
    pub status: u32,
    /// FK_ARRESTED | FK_DETACHED | ...: the bits of all latched outcomes.
    pub mask: u32,
    /// Step count at whose start the first impulse acted; FK_NEVER before.
    pub first_contact: u64,
    /// Step count at which arrested, detached, exited, passed latched, in this order; FK_NEVER before.
    pub step: [u64; 4],
    /// Work of the projectile on the fabric until then, J; 0 before.
    pub work: [f64; 4],
}

impl fk_scene {
    /// The structure of a scene.
    pub fn of(scene: &Scene) -> fk_scene {
        let (sheet, yarn, body) = (&scene.sheet, &scene.yarn, &scene.projectile);
        let (step_kind, step_value) = match scene.time_step {
            TimeStep { fraction, seconds: 0.0 } => (FK_STEP_FRACTION, fraction),
            TimeStep { seconds, .. } => (FK_STEP_SECONDS, seconds),
        };
        let rule = scene.integrator;
        let (integrator, rotation_rule) = (rule.kind as u32, scene.rotation_rule.kind as u32);
        let rotation_theta = scene.rotation_rule.theta;
        fk_scene {
            struct_size: size_of::<fk_scene>() as u64,
            sheet_nodes_x: sheet.nodes_x,
            sheet_nodes_y: sheet.nodes_y,
            sheet_spacing: sheet.spacing,
            sheet_node_mass: sheet.node_mass,
            sheet_yarn_area: sheet.yarn_area,
            sheet_plies: sheet.plies,
            attachment_kind: scene.attachment.kind as u32,
            sheet_position: sheet.position,
            sheet_orientation: sheet.orientation,
            attachment_disc_inset: scene.attachment.disc_inset,
            attachment_disc_radius: scene.attachment.disc_radius,
            yarn_modulus_mean: yarn.modulus_mean,
            yarn_modulus_sd: yarn.modulus_sd,
            yarn_damage_slope: yarn.damage_slope,
            yarn_damage_intercept: yarn.damage_intercept,
            yarn_damage_sd: yarn.damage_sd,
            yarn_critical_stretch: yarn.critical_stretch,
            yarn_damage_a: yarn.damage_a,
            yarn_damage_b: yarn.damage_b,
            yarn_alpha_fail: yarn.alpha_fail,
            yarn_stochastic: u32::from(yarn.stochastic),
            projectile_shape: body.shape as u32,
            projectile_radius: body.radius,
            projectile_length: body.length,
            projectile_mass: body.mass,
            projectile_position: body.position,
            projectile_velocity: body.velocity,
            projectile_orientation: body.orientation,
            projectile_angular_velocity: body.angular_velocity,
            seed: scene.seed,
            step_value,
            force_window: scene.force_window,
            step_kind,
            step_check: scene.step_check as u32,
            drive: scene.drive as u32,
            track_detachment: u32::from(scene.track_detachment),
            track_support: u32::from(scene.track_support),
            contact_capacity: scene.contact_capacity,
            projectile_size: body.size,
            projectile_moments: body.moments,
            projectile_face_count: body.faces.count,
            reserved: 0,
            projectile_faces: body.faces.planes,
            mirror_x: u32::from(scene.symmetry.mirror_x),
            mirror_y: u32::from(scene.symmetry.mirror_y),
            yarn_draw: yarn.draw as u32,
            integrator,
            theta: rule.theta,
            theta_tolerance: rule.tolerance,
            theta_max_iterations: rule.max_iterations,
            rotation_rule,
            rotation_theta,
            step_after_failure: scene.step_after_failure as u32,
            reserved_at_end: 0,
            slack_toe: scene.slack_toe,
        }
    }

    /// The scene it describes; an unknown choice names its field.
    pub fn scene(&self) -> Result<Scene, Error> {
        let unknown = |field, value: u32| Error::new(Code::UnknownChoice, field, value as f64, 0.0);
        let flag = |field, value: u32| match value {
            0 => Ok(false),
            1 => Ok(true),
            other => Err(unknown(field, other)),
        };
        let kind = match self.attachment_kind {
            FK_TWO_SIDES => AttachmentKind::TwoSides,
            FK_FOUR_SIDES => AttachmentKind::FourSides,
            FK_FOUR_CORNERS => AttachmentKind::FourCorners,
            FK_FREE_SHEET => AttachmentKind::Free,
            other => return Err(unknown("attachment.kind", other)),
        };
        let shape = match self.projectile_shape {
            FK_SPHERE => Shape::Sphere,
            FK_CYLINDER => Shape::Cylinder,
            FK_HEMISPHERICAL_CYLINDER => Shape::HemisphericalCylinder,
            FK_BOX => Shape::Box,
            FK_POLYHEDRON => Shape::Polyhedron,
            other => return Err(unknown("projectile.shape", other)),
        };
        let time_step = match self.step_kind {
            FK_STEP_FRACTION => TimeStep::fraction(self.step_value),
            FK_STEP_SECONDS => TimeStep::seconds(self.step_value),
            other => return Err(unknown("step_kind", other)),
        };
        let step_check = match self.step_check {
            FK_STEP_CHECK_REFUSE => StepCheck::Refuse,
            FK_STEP_CHECK_NONE => StepCheck::None,
            other => return Err(unknown("step_check", other)),
        };
        let drive = match self.drive {
            FK_DRIVE_FREE => Drive::Free,
            FK_DRIVE_PRESCRIBED => Drive::Prescribed,
            other => return Err(unknown("drive", other)),
        };
        let draw = match self.yarn_draw {
            FK_DRAW_SEGMENT => Draw::Segment,
            FK_DRAW_YARN => Draw::Yarn,
            other => return Err(unknown("yarn.draw", other)),
        };
        let kind_of_integrator = match self.integrator {
            FK_VERLET => IntegratorKind::Verlet,
            FK_THETA => IntegratorKind::Theta,
            other => return Err(unknown("integrator", other)),
        };
        let step_after_failure = match self.step_after_failure {
            FK_STEP_KEEP => StepAfterFailure::Keep,
            FK_STEP_HALF => StepAfterFailure::Half,
            other => return Err(unknown("step_after_failure", other)),
        };
        let rotation_rule = match self.rotation_rule {
            FK_MIDPOINT => RotationKind::Midpoint,
            FK_THETA => RotationKind::Theta,
            other => return Err(unknown("rotation_rule", other)),
        };
        Ok(Scene {
            sheet: Sheet {
                nodes_x: self.sheet_nodes_x,
                nodes_y: self.sheet_nodes_y,
                spacing: self.sheet_spacing,
                node_mass: self.sheet_node_mass,
                yarn_area: self.sheet_yarn_area,
                plies: self.sheet_plies,
                position: self.sheet_position,
                orientation: self.sheet_orientation,
            },
            symmetry: Symmetry {
                mirror_x: flag("symmetry.mirror_x", self.mirror_x)?,
                mirror_y: flag("symmetry.mirror_y", self.mirror_y)?,
            },
            attachment: Attachment {
                kind,
                disc_inset: self.attachment_disc_inset,
                disc_radius: self.attachment_disc_radius,
            },
            yarn: Yarn {
                modulus_mean: self.yarn_modulus_mean,
                modulus_sd: self.yarn_modulus_sd,
                damage_slope: self.yarn_damage_slope,
                damage_intercept: self.yarn_damage_intercept,
                damage_sd: self.yarn_damage_sd,
                critical_stretch: self.yarn_critical_stretch,
                damage_a: self.yarn_damage_a,
                damage_b: self.yarn_damage_b,
                alpha_fail: self.yarn_alpha_fail,
                stochastic: flag("yarn.stochastic", self.yarn_stochastic)?,
                draw,
            },
            projectile: Projectile {
                sector: Scene::sheet_3in_sphere().projectile.sector,
                shape,
                radius: self.projectile_radius,
                length: self.projectile_length,
                size: self.projectile_size,
                faces: Faces { count: self.projectile_face_count, planes: self.projectile_faces },
                moments: self.projectile_moments,
                mass: self.projectile_mass,
                position: self.projectile_position,
                velocity: self.projectile_velocity,
                orientation: self.projectile_orientation,
                angular_velocity: self.projectile_angular_velocity,
            },
            drive,
            seed: self.seed,
            time_step,
            step_check,
            integrator: Integrator {
                kind: kind_of_integrator,
                theta: self.theta,
                tolerance: self.theta_tolerance,
                max_iterations: self.theta_max_iterations,
            },
            step_after_failure,
            slack_toe: self.slack_toe,
            rotation_rule: RotationRule { kind: rotation_rule, theta: self.rotation_theta },
            force_window: self.force_window,
            track_detachment: flag("track_detachment", self.track_detachment)?,
            track_support: flag("track_support", self.track_support)?,
            contact_capacity: self.contact_capacity,
        })
    }
}

impl fk_motion {
    /// The kernel's motion.
    pub fn motion(&self) -> Motion {
        Motion {
            position: self.position,
            velocity: self.velocity,
            orientation: self.orientation,
            angular_velocity: self.angular_velocity,
        }
    }
}

impl fk_fault {
    /// Nothing was refused.
    pub(crate) const NONE: fk_fault = fk_fault {
        struct_size: size_of::<fk_fault>() as u64,
        status: FK_OK,
        reserved: 0,
        value: 0.0,
        limit: 0.0,
        field: [0; 48],
        text: [0; 168],
    };

    /// The structure of an error.
    pub fn of(error: &Error) -> fk_fault {
        let mut fault =
            fk_fault { status: error.code.number(), value: error.value, limit: error.limit, ..fk_fault::NONE };
        copy_text(&mut fault.field, error.field);
        copy_text(&mut fault.text, &error.text());
        fault
    }
}

/// Copies what fits and leaves a zero at the end.
fn copy_text(to: &mut [c_char], text: &str) {
    let room = to.len().saturating_sub(1);
    to.iter_mut().take(room).zip(text.bytes()).for_each(|(slot, byte)| *slot = byte as c_char);
}
