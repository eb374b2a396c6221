/* fabric_kernel.h - ballistic fabric as a network of trusses, hit by a rigid projectile.
 *
 * Made by `cargo xtask header` from capi/src; do not edit.
 *
 * How to use it: fill an fk_scene (fk_scene_preset), ask for its memory (fk_memory_size), give a block to fk_init, step, read
 * out. All memory is the caller's; nothing is allocated, nothing is called back, there is nothing to destroy.
 *
 * Status. Every call returns one unless it says otherwise: 0 is success, -1 to -49 a request that was refused (nothing has
 * changed), -50 to -99 a numerical failure. A failure is latched: until fk_reset or fk_state_load every call returns its
 * number, but for fk_get_counters and fk_get_fault. Outcomes such as "exited" are physics, no errors: fk_get_outcome.
 *
 * Structures. Each starts with struct_size, which the caller sets to its sizeof (fk_scene_default and fk_scene_preset set that
 * of a scene). A later library may know longer structures; it reads and writes no further than the caller's size says, and takes
 * the defaults for fields of a scene that are not there. Sizes that no version had are refused.
 *
 * Threads. "Threads: changes" - no other call on the same simulation at the same time. "Threads: looks" - other calls that
 * look may run at the same time. fk_bands_pass and fk_bands_progress may be called by several threads at once
 * (examples/c/threads.c). Different simulations are independent. No call waits, locks or allocates. None keeps a pointer it was
 * given, but for the block of fk_init, and the scratch of fk_bands_begin until fk_bands_end.
 *
 * Pointers. Each is null or valid for the length stated: one number, a structure of its struct_size, an array of the count beside
 * it, for sim a handle of fk_init whose block is still there. Nobody else writes there during the call, nor reads what the call
 * writes. Places of one call overlap neither one another nor the block or scratch. FK_MOVED_BLOCK is a courtesy: it tells a block
 * that was moved, copied or never initialised, and cannot see freed memory.
 *
 * "Touches" says what is written. On x86 with SSE2, x86-64, AArch64 and hard-float Arm every call computes rounding to nearest
 * and with subnormal numbers, whatever the host has set, and puts the host's floating-point environment back: the bits do not
 * depend on it. On other processors, such as RISC-V, the host must leave it at that.
 *
 * Units are SI; vectors are in the host's frame unless said otherwise; quaternions are scalar first. M1 to M15 are the equations
 * of docs/model.md. docs/embedding.md shows how to size memory, meet a deadline, drive the projectile and use several sheets.
 */

#ifndef FABRIC_KERNEL_H
#define FABRIC_KERNEL_H

#include <stdint.h>

// Version of this interface: goes up whenever a structure or a function is added. A host needs a library of at least its own.
#define FK_ABI_VERSION 3

// Success.
#define FK_OK 0

// A pointer is null.
#define FK_NULL_POINTER -1

// A buffer is shorter than the size query said.
#define FK_SHORT_BUFFER -2

// A memory block is not aligned as the size query said.
#define FK_MISALIGNED -3

// The block was moved, copied or never initialised: use save and load.
#define FK_MOVED_BLOCK -4

// A structure does not carry a known `struct_size`.
#define FK_STRUCT_SIZE -5

// A number is NaN or infinite.
#define FK_NOT_FINITE -6

// A number must be greater than zero.
#define FK_NOT_POSITIVE -7

// A number lies outside its range.
#define FK_OUT_OF_RANGE -8

// A choice has an unknown number.
#define FK_UNKNOWN_CHOICE -9

// A quaternion is not of unit length (to 1e-3).
#define FK_BAD_QUATERNION -10

// The sheet has more nodes than memory can address.
#define FK_TOO_MANY_NODES -11

// The time step exceeds the largest allowed one; the fault's `limit` holds it.
#define FK_STEP_TOO_LARGE -12

// The parameters give no usable time step: none at all, or one with which no calculation stays within the numbers.
#define FK_STEP_LIMIT_UNUSABLE -13

// A damage rate below 3.
#define FK_DAMAGE_RATE_TOO_SMALL -14

// The projectile is lighter than one node.
#define FK_PROJECTILE_TOO_LIGHT -15

// The projectile is smaller than the node spacing.
#define FK_PROJECTILE_TOO_SMALL -16

// The projectile would cross more than one node spacing in a step, or turn more than half a radian; the fault's `limit`
// holds the largest step, s, with which the motion is accepted.
#define FK_PROJECTILE_TOO_FAST -17

// A node lies inside the projectile at the start.
#define FK_INITIAL_OVERLAP -18

// The corner discs overlap one another.
#define FK_DISCS_OVERLAP -19

// A corner disc reaches under the projectile.
#define FK_DISC_TOUCHES_PROJECTILE -20

// An array does not have the length asked for.
#define FK_WRONG_LENGTH -21

// The call does not fit the way the projectile is driven.
#define FK_WRONG_DRIVE -22

// A path does not fit the simulation's time.
#define FK_BAD_PATH -23

// Only allowed before the first step.
#define FK_ALREADY_STARTED -24

// The bytes are not a snapshot image, or were altered.
#define FK_IMAGE_MALFORMED -25

// The image is of another scene or version.
#define FK_IMAGE_OF_ANOTHER_SCENE -26

// The image holds values that no simulation can have.
#define FK_IMAGE_INVALID -27

// A face's normal is not of unit length (to 1e-6).
#define FK_BAD_NORMAL -28

// The faces of a polyhedron do not enclose a body.
#define FK_UNBOUNDED_FACES -29

// One moment of inertia is greater than the other two together.
#define FK_IMPOSSIBLE_MOMENTS -30

// Mirror planes with something they would change.
#define FK_NOT_SYMMETRIC -31

// The scene asks for something this library was built without.
#define FK_NOT_BUILT -32

// A band that was called already in this pass, or a call that does not go with bands in use, or without them.
#define FK_BAND_OUT_OF_TURN -33

// The theta rule cannot be stepped in bands.
#define FK_NOT_IN_BANDS -34

// The corner discs lie between the nodes and hold none; the fault's `limit` holds the smallest radius, m, that reaches one.
#define FK_HOLDS_NOTHING -35

// Numerical failure: a non-finite number appeared, or a stretch beyond 1e25; the state is lost until reset or load.
#define FK_NON_FINITE -50

// Numerical failure: more nodes under the projectile than a `contact_capacity` other than 0; the state is that of the
// step's start.
#define FK_CONTACT_CAPACITY -51

// Numerical failure: the projectile became faster than one node spacing in a step.
#define FK_TOO_FAST -52

// The theta rule's iteration did not converge; the state is kept at the step's start. Take a smaller step.
#define FK_NOT_CONVERGED -53

// Most bands for fk_bands_begin.
#define FK_MAX_BANDS 32

// Preset of the paper's 3 in sheet (105 x 105) with four sides held and the 8.4 g sphere.
#define FK_PRESET_SHEET_3IN_SPHERE 0

// Preset of the paper's 10 in sheet (350 x 350) with two sides held and the 37 g cylinder.
#define FK_PRESET_SHEET_10IN_CYLINDER 1

// Preset of the 10 in sheet with four sides held and a third of a small turbine disc, rim first, as a polyhedron.
#define FK_PRESET_TURBINE_DISC_SECTOR 2

// First and last column fixed.
#define FK_TWO_SIDES 0

// The whole edge fixed.
#define FK_FOUR_SIDES 1

// Discs near the corners fixed.
#define FK_FOUR_CORNERS 2

// No node fixed.
#define FK_FREE_SHEET 3

// Sphere.
#define FK_SPHERE 0

// Flat-ended cylinder along the body's z axis.
#define FK_CYLINDER 1

// Cylinder along the body's z axis with a hemisphere at its +z end.
#define FK_HEMISPHERICAL_CYLINDER 2

// Box with its edges along the body's axes.
#define FK_BOX 3

// Convex polyhedron by its faces.
#define FK_POLYHEDRON 4

// Largest number of faces of a polyhedron.
#define FK_MAX_FACES 16

// Velocity Verlet, explicit.
#define FK_VERLET 0

// The projectile turns by the implicit midpoint rule, which keeps energy and angular momentum.
#define FK_MIDPOINT 0

// The theta rule (only in a library built with the feature `implicit`; else FK_NOT_BUILT).
#define FK_THETA 1

// The step stays after the first failure.
#define FK_STEP_KEEP 0

// The step is taken as two halves after the first failure.
#define FK_STEP_HALF 1

// Every segment draws its own constants.
#define FK_DRAW_SEGMENT 0

// Every woven yarn, a row or a column of segments, draws its own constants.
#define FK_DRAW_YARN 1

// The kernel moves the projectile.
#define FK_DRIVE_FREE 0

// The host prescribes the projectile's pose.
#define FK_DRIVE_PRESCRIBED 1

// `step_value` is a fraction of dt_crit.
#define FK_STEP_FRACTION 0

// `step_value` is in seconds.
#define FK_STEP_SECONDS 1

// Refuse a step above 0.5 dt_crit.
#define FK_STEP_CHECK_REFUSE 0

// No check, for stability studies only.
#define FK_STEP_CHECK_NONE 1

// Bit of the outcome "arrested" in masks.
#define FK_ARRESTED 1

// Bit of the outcome "detached".
#define FK_DETACHED 2

// Bit of the outcome "exited".
#define FK_EXITED 4

// Bit of the outcome "passed".
#define FK_PASSED 8

// fk_outcome's status: no contact in the last step and no outcome yet.
#define FK_STATUS_FLIGHT 0

// fk_outcome's status: contact in the last step, no outcome yet.
#define FK_STATUS_CONTACT 1

// fk_outcome's status: the velocity along the direction at first contact fell to 0 or below.
#define FK_STATUS_ARRESTED 2

// fk_outcome's status: no node touched in the last 64 steps is connected to a support any more.
#define FK_STATUS_DETACHED 3

// fk_outcome's status: the projectile goes on and its contact with the fabric is over (docs/model.md, "Outcomes").
#define FK_STATUS_EXITED 4

// fk_outcome's status: no contact, and none to come: the projectile leaves the sheet's box for good.
#define FK_STATUS_PASSED 5

// A step count that has not happened.
#define FK_NEVER UINT64_MAX

// A simulation in its block. C knows only that it exists.
typedef struct fk_sim fk_sim;

// What is simulated. Fill it with fk_scene_default or fk_scene_preset, then change fields. The first bad field is named by
// fk_scene_check and fk_init. "Default" is what fk_scene_default gives; where the 3 in preset differs it is said.
typedef struct fk_scene {
    // Bytes of this structure; set by fk_scene_default and fk_scene_preset.
    uint64_t struct_size;
    // Nodes along x, 2 to 1048576. Default 350 (3 in preset: 105).
    uint32_t sheet_nodes_x;
    // Nodes along y, 2 to 1048576. Default 350 (3 in preset: 105).
    uint32_t sheet_nodes_y;
    // Node spacing = rest length h of a segment (M1), m, > 0. Default 0.0254/35.
    double sheet_spacing;
    // Mass of a node of one ply (M7), kg, > 0; edge nodes too. Default 6.52e-8.
    double sheet_node_mass;
    // Cross-section A_0 of a yarn of one ply (M4), m^2, > 0. Default 1.075e-7.
    double sheet_yarn_area;
    // Coincident plies lumped into one network: mass and area are multiplied. 1 to 1000. Default 1.
    uint32_t sheet_plies;
    // Which nodes are fixed: FK_TWO_SIDES, FK_FOUR_SIDES, FK_FOUR_CORNERS or FK_FREE_SHEET. Default FK_TWO_SIDES (3 in
    // preset: FK_FOUR_SIDES).
    uint32_t attachment_kind;
    // Origin of the sheet's frame, its middle, in the host's frame, m. Finite. Default 0.
    double sheet_position[3];
    // Orientation of the sheet's frame in the host's, unit quaternion (to 1e-3). The sheet lies in its own plane z =
    // 0. Default (1, 0, 0, 0).
    double sheet_orientation[4];
    // Four corners: distance of a disc's centre from both edges, m, >= 0. Default 25.4e-3 (3 in preset: 7.62e-3). Read
    // for FK_FOUR_CORNERS only.
    double attachment_disc_inset;
    // Four corners: radius of the discs, m, > 0; they may neither overlap nor reach under the projectile. Default
    // 19.05e-3 (3 in preset: 5.715e-3). Read for FK_FOUR_CORNERS only.
    double attachment_disc_radius;
    // Mean Young's modulus E of the yarn (M3), Pa, > 0. Default 140.21e9.
    double yarn_modulus_mean;
    // Standard deviation of the modulus, Pa, >= 0. Default 2.04e9. Counts for stochastic yarn only.
    double yarn_modulus_sd;
    // Slope of the damage rate over the modulus (M6), 1/Pa. Default 7.91e-9.
    double yarn_damage_slope;
    // Damage rate at zero modulus (M6), dimensionless; the mean rate must be >= 3. Default -878.46.
    double yarn_damage_intercept;
    // Standard deviation of the damage rate about M6, dimensionless, >= 0. Default 8.35. Counts for stochastic yarn
    // only.
    double yarn_damage_sd;
    // Critical stretch U_c (M5), dimensionless, in (1, 2]. Default 1.03.
    double yarn_critical_stretch;
    // Factor A of the damage law (M5), dimensionless, > 0, with A (1 - B) in (0, 1] to rounding. Default 1.
    double yarn_damage_a;
    // Offset B of the damage law (M5), dimensionless, < 1. Default 0.
    double yarn_damage_b;
    // alpha (M5) at or below this becomes 0, in [0, 1). Default 0.01.
    double yarn_alpha_fail;
    // 1: modulus and damage rate are drawn (yarn_draw); 0: all segments take the means. Default 1.
    uint32_t yarn_stochastic;
    // FK_SPHERE, FK_CYLINDER, FK_HEMISPHERICAL_CYLINDER, FK_BOX or FK_POLYHEDRON (M12). Default FK_CYLINDER (3 in
    // preset: FK_SPHERE).
    uint32_t projectile_shape;
    // Radius, m, >= sheet_spacing. Default 6.35e-3. Not read for a box or a polyhedron.
    double projectile_radius;
    // Whole length of a cylinder, m, >= 2 sheet_spacing, with a hemispherical end >= the radius too. Default 38.1e-3.
    // Read for the two cylinders only.
    double projectile_length;
    // Mass, kg, at least that of a node with all its plies; 0 = not known, only with FK_DRIVE_PRESCRIBED. Default
    // 0.037 (3 in preset: 8.4e-3).
    double projectile_mass;
    // Centre of mass at the start, host's frame, m. No node may lie inside the projectile (a fixed one inside a
    // prescribed body may). Default (0, 0, -0.01905): it touches the sheet (3 in preset: (0, 0, -6.35e-3)).
    double projectile_position[3];
    // Velocity at the start, host's axes, m/s. (Speed + spin times reach) times dt must be less than sheet_spacing.
    // Default (0, 0, 100).
    double projectile_velocity[3];
    // Orientation at the start, body to host, unit quaternion (to 1e-3). Default (1, 0, 0, 0).
    double projectile_orientation[4];
    // Angular velocity at the start, host's axes, rad/s. Default 0.
    double projectile_angular_velocity[3];
    // Seed of the stochastic yarn, any number. Default 1.
    uint64_t seed;
    // FK_STEP_FRACTION: fraction of dt_crit (M11), in (0, 0.5]. FK_STEP_SECONDS: the step, s, > 0, at most 0.5
    // dt_crit. Default 0.4; where the fabric's own energies matter 0.2 (docs/stability.md).
    double step_value;
    // Window of the peak force, s, > 0; rounded to whole steps, at least one. Until the first is full the peak force is the
    // mean over the time elapsed. Default 1e-6.
    double force_window;
    // FK_STEP_FRACTION or FK_STEP_SECONDS. Default FK_STEP_FRACTION.
    uint32_t step_kind;
    // FK_STEP_CHECK_REFUSE or FK_STEP_CHECK_NONE. Default FK_STEP_CHECK_REFUSE.
    uint32_t step_check;
    // FK_DRIVE_FREE or FK_DRIVE_PRESCRIBED. Default FK_DRIVE_FREE.
    uint32_t drive;
    // 1: watch whether the touched nodes are still held, for the outcome "detached" (4 bytes a node). Default 1. With 0 a
    // projectile that carries torn cloth is never said to have exited.
    uint32_t track_detachment;
    // 1: sum the impulses on the supports, for fk_get_support and fk_get_momentum_residual. Default 1.
    uint32_t track_support;
    // Most nodes closer than sheet_spacing to the projectile at once; each takes 116 bytes (124 with the theta rule), more
    // nodes are the failure FK_CONTACT_CAPACITY. 0 = every node modelled, which cannot be exceeded. A smaller number is
    // for tight memory; docs/embedding.md says how to choose it. Default 0.
    uint32_t contact_capacity;
    // Box: edge lengths along the body's axes, m, each >= 2 sheet_spacing. Default 12.7e-3 each. Read for a box only.
    double projectile_size[3];
    // Polyhedron: principal moments of inertia about the centre of mass along the body's axes, kg m^2, > 0, none
    // greater than the other two together. Default 0. Read for a polyhedron of known mass only; other shapes are
    // homogeneous.
    double projectile_moments[3];
    // Polyhedron: number of faces, 4 to FK_MAX_FACES. Default 0.
    uint32_t projectile_face_count;
    // 0. Not read.
    uint32_t reserved;
    // Polyhedron: of each face the outward unit normal (to 1e-6) and its distance from the centre of mass, m, >=
    // sheet_spacing; body axes. Default 0. Beyond projectile_face_count not read.
    double projectile_faces[FK_MAX_FACES][4];
    // 1: mirror plane x = 0 through the sheet's middle; only x <= 0 is modelled. Sums stay those of the whole sheet,
    // read-outs of nodes and segments cover the part (fk_get_grid). For uniform yarn, a free projectile and a centred,
    // untilted hit. Default 0.
    uint32_t mirror_x;
    // 1: mirror plane y = 0; only y <= 0 is modelled. Default 0.
    uint32_t mirror_y;
    // What draws its own constants: FK_DRAW_SEGMENT or FK_DRAW_YARN (a whole row or column). Default FK_DRAW_SEGMENT.
    // Read for stochastic yarn only.
    uint32_t yarn_draw;
    // How the nodes are stepped: FK_VERLET (M7), or FK_THETA, the paper's theta rule by fixed-point iteration (M10),
    // the reference method. Default FK_VERLET.
    uint32_t integrator;
    // Theta rule: weight of the forces at the step's end (M10), in [0.5, 1]; 0.5 is of second order. Default 0.5. This
    // and the next two are read for FK_THETA only.
    double theta;
    // Theta rule: the iteration ends when no node moves by more than this, in node spacings, > 0. Default 1e-10.
    double theta_tolerance;
    // Theta rule: iterations after which a step fails (FK_NOT_CONVERGED), >= 1. Default 500.
    uint32_t theta_max_iterations;
    // How the projectile turns: FK_MIDPOINT, or FK_THETA, the paper's theta rule (its equations 14 to 16), which does
    // not conserve. Default FK_MIDPOINT.
    uint32_t rotation_rule;
    // Theta of the projectile's rotation, in [0.5, 1]. Default 0.5. Read for rotation_rule = FK_THETA only.
    double rotation_theta;
    // FK_STEP_KEEP, or FK_STEP_HALF: from the end of the step in which the first segment fails, every step is taken as
    // two halves (M9; FK_VERLET only). Default FK_STEP_KEEP.
    uint32_t step_after_failure;
    // 0.
    uint32_t reserved_at_end;
    // Toe against the energy creep of slack sheets: Green-Lagrange strain over which the stiffness of a segment sets in once
    // it has been slack after the first failure, in [0.005, 0.05] and not beyond that of U_c; 0 = none (FK_VERLET only). The
    // largest step is 0.433 dt_crit with it.
    double slack_toe;
} fk_scene;

// Why a request was refused or a step failed.
typedef struct fk_fault {
    // Set to sizeof(fk_fault) by the caller.
    uint64_t struct_size;
    // Status number: FK_OK, or an error's.
    int32_t status;
    // 0.
    uint32_t reserved;
    // Offending value in SI units; 0 where none applies.
    double value;
    // Limit crossed, SI units; 0 where none applies. For FK_STEP_TOO_LARGE the largest allowed step, s; for
    // FK_WRONG_LENGTH and FK_SHORT_BUFFER the length wanted.
    double limit;
    // Name of the field, zero-terminated, e.g. "sheet.spacing" for sheet_spacing; empty if no single field is to
    // blame.
    char field[48];
    // One line for a log, zero-terminated.
    char text[168];
} fk_fault;

// Pose and rates of a rigid body, host's frame. Never grows: it is part of fk_path.
typedef struct fk_motion {
    // Set to sizeof(fk_motion) by the caller.
    uint64_t struct_size;
    // Centre of mass, m. As input: finite.
    double position[3];
    // Velocity of the centre of mass, m/s. As input: finite.
    double velocity[3];
    // Orientation, body to host, unit quaternion, scalar first. As input: of unit length to 1e-3.
    double orientation[4];
    // Angular velocity, rad/s, host's axes. As input: finite.
    double angular_velocity[3];
} fk_motion;

// Where the host wants a prescribed body at the end of a communication step.
typedef struct fk_path {
    // Set to sizeof(fk_path) by the caller.
    uint64_t struct_size;
    // Step count at which the path starts: the present one (fk_get_time), or that of the path being followed.
    uint64_t first;
    // Length in steps, >= 1; less than half a turn of the body.
    uint64_t steps;
    // Pose and rates at step first + steps (its own struct_size is checked too). The body gets there by M13.
    struct fk_motion end;
} fk_path;

// The time step and its limits (M11).
typedef struct fk_step_limits {
    // Set to sizeof(fk_step_limits) by the caller.
    uint64_t struct_size;
    // Step in use, s; constant for the life of the simulation.
    double dt;
    // Stability limit of the taut sheet with the stiffest segment drawn (M11), s.
    double dt_crit;
    // Largest accepted step, 0.5 dt_crit, s.
    double step_max;
} fk_step_limits;

// What is modelled of the sheet, and so the lengths of the arrays of fk_copy_... and fk_set_...
typedef struct fk_grid {
    // Set to sizeof(fk_grid) by the caller.
    uint64_t struct_size;
    // Nodes along x: sheet_nodes_x, or what mirror_x leaves of them.
    uint64_t nodes_x;
    // Nodes along y: sheet_nodes_y, or what mirror_y leaves of them.
    uint64_t nodes_y;
    // Segments along x, row by row, horizontal / nodes_y in each row.
    uint64_t horizontal;
    // Segments along y, row by row, nodes_x in each row; in arrays they come after those along x.
    uint64_t vertical;
} fk_grid;

// Contact sums (M8) since the start or reset, host's axes.
typedef struct fk_contact {
    // Set to sizeof(fk_contact) by the caller.
    uint64_t struct_size;
    // Impulse on the projectile, N s. A mean force is a difference of two divided by the time between.
    double impulse[3];
    // Angular impulse on the projectile about its moving centre of mass, N m s.
    double angular_impulse[3];
    // Work of the projectile on the fabric = energy absorbed, J.
    double work;
    // Kinetic energy lost in impacts of nodes, part of the work, J, >= 0.
    double loss;
    // Largest mean force over a window of force_window, N, >= 0; until the first window is full the mean force over the
    // time elapsed.
    double force_peak;
} fk_contact;

// Impulses of the sheet and of a free projectile on the supports since the start, N s, host's axes.
typedef struct fk_support {
    // Set to sizeof(fk_support) by the caller.
    uint64_t struct_size;
    // All together.
    double total[3];
    // Sides: left (-x), right, bottom (-y), top. Corners: (-,-), (+,-), (-,+), (+,+).
    double attachments[4][3];
} fk_support;

// Energies (M15), J.
typedef struct fk_energy {
    // Set to sizeof(fk_energy) by the caller.
    uint64_t struct_size;
    // Kinetic energy of the projectile, translation and rotation, J, >= 0 (0 if its mass is unknown).
    double projectile_kinetic;
    // Kinetic energy of the fabric, J, >= 0.
    double fabric_kinetic;
    // Strain energy of the yarns, J, >= 0.
    double strain;
    // Energy dissipated by rupture, J, >= 0.
    double dissipated;
    // Kinetic energy lost in impacts of nodes, J, >= 0.
    double contact_loss;
    // Work of the projectile on the fabric, J.
    double contact_work;
    // Work of the external load, J.
    double external_work;
    // What the balance (M15) does not close by, J; in a sound run below 1 % of the kinetic energy at impact.
    double residual;
    // Change of the audited energy when the step was halved, J; 0 if it was not.
    double halving;
} fk_energy;

// Extremes of the fabric at the present time.
typedef struct fk_fabric {
    // Set to sizeof(fk_fabric) by the caller.
    uint64_t struct_size;
    // Largest distance from the sheet's plane of a node that live segments join to a support, m, >= 0; 0 once all of the sheet
    // has torn off. Of all nodes if the sheet is free, or if segments have failed and track_detachment is 0.
    double max_deflection;
    // Largest stretch (M1) of a live segment, dimensionless; yarns of the presets fail at about 1.05.
    double max_stretch;
} fk_fabric;

// Counters; available even after a failure.
typedef struct fk_counters {
    // Set to sizeof(fk_counters) by the caller.
    uint64_t struct_size;
    // Steps taken since the start or reset.
    uint64_t steps;
    // Segments with alpha = 0 (M5) in the forces of the last step.
    uint64_t failed_segments;
    // Nodes with a contact impulse in the last step.
    uint64_t contacts;
    // Contact solves (M8) that ran out of sweeps; harmless below 1 % of the steps.
    uint64_t unconverged;
    // Most sweeps of one contact solve, at most 200, or 4000 where a fixed node takes an impulse.
    uint64_t most_sweeps;
    // Most candidate nodes of one step.
    uint64_t most_candidates;
    // Places for candidate nodes: contact_capacity, or every node modelled.
    uint64_t candidate_capacity;
    // Deepest penetration met, m, >= 0; rounding in a sound run, and the depth of fixed nodes in a prescribed body, which
    // passes through supports.
    double worst_penetration;
    // Iterations of the theta rule (M10) so far; 0 for FK_VERLET.
    uint64_t iterations;
    // Most iterations of one step.
    uint64_t most_iterations;
} fk_counters;

// Outcomes; FK_NEVER for what has not happened.
typedef struct fk_outcome {
    // Set to sizeof(fk_outcome) by the caller.
    uint64_t struct_size;
    // FK_STATUS_FLIGHT ...: the latest outcome, or contact or flight.
    uint32_t status;
    // FK_ARRESTED | FK_DETACHED | ...: the bits of all latched outcomes.
    uint32_t mask;
    // Step count at whose start the first impulse acted; FK_NEVER before.
    uint64_t first_contact;
    // Step count at which arrested, detached, exited, passed latched, in this order; FK_NEVER before.
    uint64_t step[4];
    // Work of the projectile on the fabric until then, J; 0 before.
    double work[4];
} fk_outcome;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Returns FK_ABI_VERSION of the library. A host runs with every library whose number is at least its header's.
// Threads: any, at any time. Time: constant. Touches: nothing.
uint32_t fk_abi_version(void);

// Returns the library's version, e.g. "0.1.0", a static string.
// Threads: any, at any time. Time: constant. Touches: nothing.
const char *fk_version(void);

// Returns what a status number means, a static string; "unknown status" for numbers that no call returns.
// Threads: any, at any time. Time: constant. Touches: nothing.
const char *fk_status_name(int32_t status);

// Fills `scene` with the 10 in preset, whose values are the defaults given with the fields of fk_scene. `struct_size`
// is sizeof(fk_scene) as the caller was compiled.
// Threads: any, each with its own scene. Time: constant. Touches: `scene`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE.
int32_t fk_scene_default(struct fk_scene *scene, uint64_t struct_size);

// Fills `scene` with a preset (FK_PRESET_...). `struct_size` is sizeof(fk_scene) as the caller was compiled.
// Threads: any, each with its own scene. Time: constant. Touches: `scene`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_UNKNOWN_CHOICE.
int32_t fk_scene_preset(struct fk_scene *scene, uint64_t struct_size, uint32_t preset);

// Checks a scene, the time step (M11) included. `fault` may be null; on an error it receives the number, the first bad
// field, its value and the limit.
// Threads: any. Time: draws every segment of a stochastic sheet (some 0.1 us each). Touches: `fault`, on an error.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE; of the scene, each where a field of it says so or the
// constant's text does: FK_NOT_FINITE, FK_NOT_POSITIVE, FK_OUT_OF_RANGE, FK_UNKNOWN_CHOICE, FK_BAD_QUATERNION,
// FK_TOO_MANY_NODES, FK_STEP_TOO_LARGE, FK_STEP_LIMIT_UNUSABLE, FK_DAMAGE_RATE_TOO_SMALL, FK_PROJECTILE_TOO_LIGHT,
// FK_PROJECTILE_TOO_SMALL, FK_DISCS_OVERLAP, FK_DISC_TOUCHES_PROJECTILE, FK_BAD_NORMAL, FK_UNBOUNDED_FACES,
// FK_IMPOSSIBLE_MOMENTS, FK_NOT_SYMMETRIC, FK_NOT_BUILT, FK_HOLDS_NOTHING.
int32_t fk_scene_check(const struct fk_scene *scene, struct fk_fault *fault);

// Bytes and alignment of the block that fk_init needs for a scene. The size depends on the nodes, the projectile's
// size and the options, not on material or motion; it may differ between versions of the library.
// Threads: any. Time: constant. Touches: `bytes`, `align`; neither on an error.
// Errors: those of fk_scene_check but for the time step.
int32_t fk_memory_size(const struct fk_scene *scene, uint64_t *bytes, uint64_t *align);

// Makes a simulation of `scene` at step 0 at the start of the caller's block and hands back its handle in `out`: sheet
// flat and at rest, projectile in its start motion. The scene is copied; the block's old content does not matter. The
// block must not be moved or copied while the handle is used (use fk_state_save and fk_state_load); simply let go of
// it when done.
// Threads: any, each with its own block. Time: as fk_scene_check and a pass over the block. Touches: the block and
// `out`; on an error only `fault`, which may be null.
// Errors: those of fk_scene_check, FK_SHORT_BUFFER, FK_MISALIGNED, FK_INITIAL_OVERLAP, FK_PROJECTILE_TOO_FAST,
// FK_OUT_OF_RANGE (a projectile too heavy for its energy to be a number).
int32_t fk_init(void *memory,
                uint64_t bytes,
                const struct fk_scene *scene,
                struct fk_sim **out,
                struct fk_fault *fault);

// Back to step 0 as after fk_init, and to its bits. Clears a failure, the fault of fk_get_fault, the external load,
// and what fk_set_motion and fk_set_largest_stretch gave.
// Threads: changes. Time: a pass over the sheet. Touches: the block.
// Errors: FK_NULL_POINTER, FK_MOVED_BLOCK.
int32_t fk_reset(struct fk_sim *sim);

// One step: M7 for the yarns, M8 for contact, then the projectile.
// Threads: changes. Time: at most one step's; docs/embedding.md says how to bound it. Touches: the block.
// Errors: FK_NULL_POINTER, FK_MOVED_BLOCK; failures FK_NON_FINITE, FK_CONTACT_CAPACITY, FK_TOO_FAST and with the theta
// rule FK_NOT_CONVERGED, which every later call but fk_reset, fk_state_load, fk_get_counters and fk_get_fault repeats.
int32_t fk_step(struct fk_sim *sim);

// `steps` steps; the bits do not depend on how they are split over calls. A failure ends it early; fk_get_counters
// then tells the steps taken.
// Threads: changes. Time: `steps` steps. Touches: the block.
// Errors: as fk_step.
int32_t fk_advance(struct fk_sim *sim, uint64_t steps);

// Up to `steps` steps, ending after the one at which any outcome of `mask` (FK_ARRESTED | ...) is latched, at once if
// one already is. Outcomes are tested every 64 steps. `taken` may be null.
// Threads: changes. Time: at most `steps` steps. Touches: the block; `taken`, the steps taken, unless a failure ended
// them.
// Errors: as fk_step.
int32_t fk_advance_until(struct fk_sim *sim, uint32_t mask, uint64_t steps, uint64_t *taken);

// Moves a prescribed body along `path` (M13) for `steps` steps. Call again with the same path to go on along it; the
// bits do not depend on how a path is split. Without a path the body coasts.
// Threads: changes. Time: `steps` steps. Touches: the block.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, FK_WRONG_DRIVE (the scene's drive is
// FK_DRIVE_FREE), FK_BAD_PATH, FK_NOT_FINITE, FK_BAD_QUATERNION, FK_PROJECTILE_TOO_FAST, FK_OUT_OF_RANGE; failures as
// fk_step.
int32_t fk_follow(struct fk_sim *sim, const struct fk_path *path, uint64_t steps);

// Bytes of scratch, aligned as the block, that fk_bands_begin needs for `of` bands.
// Errors: FK_NULL_POINTER, FK_OUT_OF_RANGE (`of` is not 1 to FK_MAX_BANDS), FK_NOT_IN_BANDS, FK_MOVED_BLOCK, a latched
// failure.
int32_t fk_bands_size(const struct fk_sim *sim, uint32_t of, uint64_t *bytes);

// Cuts the sheet into `of` bands of rows, to be stepped by as many threads of the host's. From here to fk_bands_end the
// bands have the simulation: every call but fk_bands_pass and fk_bands_progress is refused with FK_BAND_OUT_OF_TURN.
// `scratch` must not be moved or used by anything else until then.
// Errors: FK_NULL_POINTER, FK_SHORT_BUFFER, FK_MISALIGNED, FK_OUT_OF_RANGE, FK_NOT_IN_BANDS, FK_BAND_OUT_OF_TURN (bands are in
// use), FK_MOVED_BLOCK, a latched failure.
int32_t fk_bands_begin(struct fk_sim *sim,
                       uint32_t of,
                       void *scratch,
                       uint64_t bytes);

// One band's part of a pass: a pass is a step, or half of one after step_after_failure. To be called for every band once a
// pass, in any order, from any threads, at the same time. Nothing waits in here: the last band to be done completes the pass
// for all. `last` (may be null) receives 1 in that call, else 0. The host must wait for the pass to be complete before it
// calls the same band again: until then it is refused. The bits are those of fk_step.
// Errors: FK_OUT_OF_RANGE (no such band), FK_BAND_OUT_OF_TURN (called already in this pass, or no fk_bands_begin): nothing
// changed. FK_NULL_POINTER, FK_MOVED_BLOCK. A failure as fk_step: to the last band, and to every band in later passes.
int32_t fk_bands_pass(const struct fk_sim *sim,
                      uint32_t band,
                      uint32_t *last);

// How far the bands have come since fk_bands_begin: passes completed (a failed one included), steps completed, outcomes
// latched (FK_ARRESTED | ...). Any pointer may be null. Any thread may look between fk_bands_begin and fk_bands_end, also while
// others are in fk_bands_pass; the end drops what this looks at. When `passes` has grown, the next pass may begin; while a
// thread's own band has not been called, none of the three changes.
// Errors: FK_NULL_POINTER (sim), FK_BAND_OUT_OF_TURN (no fk_bands_begin), FK_MOVED_BLOCK.
int32_t fk_bands_progress(const struct fk_sim *sim,
                          uint64_t *passes,
                          uint64_t *steps,
                          uint32_t *outcomes);

// Gives the simulation back to the other calls, once no thread is in a call of the bands any more. A step that only some
// bands have taken is completed. Returns the failure of the last pass, if there was one.
// Errors: FK_NULL_POINTER, FK_BAND_OUT_OF_TURN (no fk_bands_begin), FK_MOVED_BLOCK; failures as fk_step.
int32_t fk_bands_end(struct fk_sim *sim);

// Step count, and time = steps times dt, s. Either pointer may be null.
// Threads: looks. Time: constant. Touches: `steps`, `seconds`.
// Errors: FK_NULL_POINTER (sim), FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_time(const struct fk_sim *sim, uint64_t *steps, double *seconds);

// The time step and its limits (M11).
// Threads: looks. Time: constant. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_step_limits(const struct fk_sim *sim, struct fk_step_limits *out);

// What is modelled of the sheet: the lengths of the arrays below.
// Threads: looks. Time: constant. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_grid(const struct fk_sim *sim, struct fk_grid *out);

// The projectile: pose at the present time, rates of the half step before it (M7).
// Threads: looks. Time: constant. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_projectile(const struct fk_sim *sim, struct fk_motion *out);

// Sets the force, N, and torque about the centre of mass, N m (3 numbers each, host's axes), that act on a free body
// from now on, in every step until they are set anew. At the start both are 0.
// Threads: changes. Time: constant. Touches: the block.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_NOT_FINITE, FK_WRONG_DRIVE (the scene's drive is FK_DRIVE_PRESCRIBED),
// FK_NOT_SYMMETRIC, FK_MOVED_BLOCK, a latched failure.
int32_t fk_set_external_load(struct fk_sim *sim, const double *force, const double *torque);

// Starts from given positions, m, and velocities, m/s, at time 0: `n` = 3 nodes_x nodes_y (fk_get_grid) numbers each,
// node by node, rows along x first, host's frame. For restarts from another code and sheets that start stretched.
// Fixed nodes stay where this puts them; their velocity must be 0. Only before the first step, and after
// fk_set_largest_stretch.
// Threads: changes. Time: two passes over the sheet. Touches: the block.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_WRONG_LENGTH, FK_NOT_FINITE, FK_OUT_OF_RANGE (a fixed node that
// moves; a position beyond 1e30 spacings, a velocity beyond 1e30 spacings a step), FK_INITIAL_OVERLAP,
// FK_NOT_SYMMETRIC, FK_ALREADY_STARTED, FK_MOVED_BLOCK, a latched failure.
int32_t fk_set_motion(struct fk_sim *sim, const double *positions, const double *velocities, uint64_t n);

// Gives every segment the largest stretch it has ever had, U_max of M5: a pre-damaged sheet. `n` = horizontal +
// vertical (fk_get_grid) numbers, horizontal ones first, row by row, in [0, 1e100]; up to the critical stretch means
// whole. Only before the first step.
// Threads: changes. Time: two passes over the sheet. Touches: the block.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_WRONG_LENGTH, FK_NOT_FINITE, FK_OUT_OF_RANGE, FK_ALREADY_STARTED,
// FK_MOVED_BLOCK, a latched failure.
int32_t fk_set_largest_stretch(struct fk_sim *sim, const double *stretches, uint64_t n);

// Contact sums (M8).
// Threads: looks. Time: constant. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_contact(const struct fk_sim *sim, struct fk_contact *out);

// Impulses on the supports; zero without track_support.
// Threads: looks. Time: constant. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_support(const struct fk_sim *sim, struct fk_support *out);

// The energies (M15).
// Threads: looks. Time: a pass over the sheet, with exp for damaged segments. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_energy(const struct fk_sim *sim, struct fk_energy *out);

// Linear momentum, N s, that the balance of projectile, fabric, supports and external load does not close by: three
// numbers, host's axes. Rounding in a sound run. Needs track_support.
// Threads: looks. Time: a pass over the sheet. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_momentum_residual(const struct fk_sim *sim, double *out);

// Largest deflection and stretch (M1). What is still joined to a support is found in the simulation's scratch.
// Threads: changes, though no result. Time: a pass over the sheet. Touches: the block's scratch, `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_fabric(struct fk_sim *sim, struct fk_fabric *out);

// Counters; also after a failure.
// Threads: looks. Time: constant. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK.
int32_t fk_get_counters(const struct fk_sim *sim, struct fk_counters *out);

// Why the last call that changes this simulation (fk_step ... fk_set_motion, fk_state_load) was refused or failed;
// status FK_OK and empty texts if none was since fk_init or fk_reset. Also after a failure.
// Threads: looks. Time: constant. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK.
int32_t fk_get_fault(const struct fk_sim *sim, struct fk_fault *out);

// Outcomes latched so far: physics, not errors. Tested every 64 steps; they change nothing.
// Threads: looks. Time: constant. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_outcome(const struct fk_sim *sim, struct fk_outcome *out);

// Positions, m: `n` = 3 nodes_x nodes_y (fk_get_grid) numbers, node by node, rows along x first, host's frame.
// Threads: looks. Time: a pass over the sheet. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_WRONG_LENGTH, FK_MOVED_BLOCK, a latched failure.
int32_t fk_copy_positions(const struct fk_sim *sim, double *out, uint64_t n);

// Velocities at the present time, m/s: `n` and order as fk_copy_positions, host's axes.
// Threads: looks. Time: a pass over the sheet. Touches: `out`.
// Errors: as fk_copy_positions.
int32_t fk_copy_velocities(const struct fk_sim *sim, double *out, uint64_t n);

// alpha of every segment (M5; 1 whole, 0 failed): `n` = horizontal + vertical (fk_get_grid) numbers, horizontal ones
// first, row by row, then the vertical ones.
// Threads: looks. Time: a pass over the sheet. Touches: `out`.
// Errors: as fk_copy_positions.
int32_t fk_copy_damage(const struct fk_sim *sim, double *out, uint64_t n);

// Stretch of every segment (M1), failed ones too: `n` and order as fk_copy_damage.
// Threads: looks. Time: a pass over the sheet. Touches: `out`.
// Errors: as fk_copy_positions.
int32_t fk_copy_stretch(const struct fk_sim *sim, double *out, uint64_t n);

// Bytes of a snapshot image; constant for a simulation.
// Threads: looks. Time: constant. Touches: `bytes`.
// Errors: FK_NULL_POINTER, FK_MOVED_BLOCK, a latched failure.
int32_t fk_state_size(const struct fk_sim *sim, uint64_t *bytes);

// Writes the state into `image`, at least fk_state_size bytes long (`bytes` is its length): with a checksum, and
// portable between machines that run the same version of the library.
// Threads: looks. Time: a pass over the sheet. Touches: `image`.
// Errors: FK_NULL_POINTER, FK_SHORT_BUFFER, FK_WRONG_LENGTH (`bytes` is more than memory can have), FK_MOVED_BLOCK, a
// latched failure.
int32_t fk_state_save(const struct fk_sim *sim, uint8_t *image, uint64_t bytes);

// Puts the simulation into the state of an image of the same scene, bit for bit; clears a failure. `bytes` is what
// fk_state_size says. On an error nothing has changed.
// Threads: changes. Time: a few passes over the sheet. Touches: the block.
// Errors: FK_NULL_POINTER, FK_WRONG_LENGTH (`bytes` is more than memory can have), FK_IMAGE_MALFORMED,
// FK_IMAGE_OF_ANOTHER_SCENE, FK_IMAGE_INVALID, FK_MOVED_BLOCK.
int32_t fk_state_load(struct fk_sim *sim, const uint8_t *image, uint64_t bytes);

// A hash of the whole state: equal digests mean equal bits, on every machine.
// Threads: looks. Time: a pass over the sheet. Touches: `digest`.
// Errors: FK_NULL_POINTER, FK_MOVED_BLOCK, a latched failure.
int32_t fk_digest(const struct fk_sim *sim, uint64_t *digest);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* FABRIC_KERNEL_H */
