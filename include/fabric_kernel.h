/* fabric_kernel.h - ballistic fabric as a network of trusses, hit by a rigid projectile.
 *
 * Made by `cargo xtask header` from capi/src; do not edit.
 *
 * How to use it: fill an fk_scene (fk_scene_preset), ask for its memory (fk_memory_size), give a block to fk_init, step, read
 * out. All memory is the caller's; nothing is allocated, nothing is called back, there is nothing to destroy.
 *
 * Every call returns a status unless it says otherwise: 0 is success, -1 to -49 a request that was refused (nothing changed),
 * -50 to -99 a numerical failure. A failure is latched: until fk_reset or fk_state_load every call returns its number, but
 * for fk_get_counters and fk_get_fault. Outcomes such as "exited" are physics, no errors: read them with fk_get_outcome.
 * Every structure starts with struct_size, which the caller sets to its sizeof.
 *
 * Every call computes rounding to nearest and with subnormal numbers, whatever the host has set, and puts the host's
 * floating-point environment back: the bits do not depend on it.
 *
 * SI units; vectors in the host's frame; quaternions scalar first. One simulation must not be used by two threads at once;
 * different simulations may.
 */

#ifndef FABRIC_KERNEL_H
#define FABRIC_KERNEL_H

#include <stdint.h>

// Version of this interface: changes whenever a structure or a function does.
#define FK_ABI_VERSION 2

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

// The parameters give no usable time step.
#define FK_STEP_LIMIT_UNUSABLE -13

// A damage rate below 3.
#define FK_DAMAGE_RATE_TOO_SMALL -14

// The projectile is lighter than one node.
#define FK_PROJECTILE_TOO_LIGHT -15

// The projectile is smaller than the node spacing.
#define FK_PROJECTILE_TOO_SMALL -16

// The projectile would cross more than one node spacing in a step.
#define FK_PROJECTILE_TOO_FAST -17

// A free node lies inside the projectile at the start.
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

// Numerical failure: a non-finite number appeared; the state is lost until reset or load.
#define FK_NON_FINITE -50

// Numerical failure: more nodes under the projectile than `contact_capacity`; the state is that of the step's start.
#define FK_CONTACT_CAPACITY -51

// Numerical failure: the projectile became faster than one node spacing in a step.
#define FK_TOO_FAST -52

// The theta rule's iteration did not converge; the state is kept at the step's start. Take a smaller step.
#define FK_NOT_CONVERGED -53

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

// fk_outcome's status: over a forward travel of one radius no contact, or only negligible work.
#define FK_STATUS_EXITED 4

// fk_outcome's status: the projectile left the sheet's box without contact.
#define FK_STATUS_PASSED 5

// A step count that has not happened.
#define FK_NEVER UINT64_MAX

// A simulation in its block. C knows only that it exists.
typedef struct fk_sim fk_sim;

// What is simulated. Fill it with fk_scene_default or fk_scene_preset, then change fields.
typedef struct fk_scene {
    // Bytes of this structure; set by fk_scene_default and fk_scene_preset.
    uint64_t struct_size;
    // Nodes along x, >= 2.
    uint32_t sheet_nodes_x;
    // Nodes along y, >= 2.
    uint32_t sheet_nodes_y;
    // Node spacing, m, > 0.
    double sheet_spacing;
    // Mass of a node of one ply, kg, > 0.
    double sheet_node_mass;
    // Cross-section of a yarn of one ply, m^2, > 0.
    double sheet_yarn_area;
    // Coincident plies, 1 to 1000.
    uint32_t sheet_plies;
    // FK_TWO_SIDES, FK_FOUR_SIDES, FK_FOUR_CORNERS or FK_FREE_SHEET.
    uint32_t attachment_kind;
    // Origin of the sheet's frame in the host's, m.
    double sheet_position[3];
    // Orientation of the sheet's frame in the host's, unit quaternion.
    double sheet_orientation[4];
    // Four corners: distance of a disc's centre from both edges, m, >= 0.
    double attachment_disc_inset;
    // Four corners: radius of the discs, m, > 0.
    double attachment_disc_radius;
    // Mean Young's modulus of the yarn, Pa, > 0.
    double yarn_modulus_mean;
    // Standard deviation of the modulus, Pa, >= 0.
    double yarn_modulus_sd;
    // Slope of the damage rate over the modulus, 1/Pa.
    double yarn_damage_slope;
    // Damage rate at zero modulus; the mean rate must be >= 3.
    double yarn_damage_intercept;
    // Standard deviation of the damage rate, >= 0.
    double yarn_damage_sd;
    // Critical stretch, > 1, at most 2.
    double yarn_critical_stretch;
    // Factor A of the damage law, > 0, with A (1 - B) in (0, 1].
    double yarn_damage_a;
    // Offset B of the damage law, < 1.
    double yarn_damage_b;
    // alpha at or below this becomes 0, in [0, 1).
    double yarn_alpha_fail;
    // 1: each segment draws its own constants; 0: all take the means.
    uint32_t yarn_stochastic;
    // FK_SPHERE, FK_CYLINDER, FK_HEMISPHERICAL_CYLINDER, FK_BOX or FK_POLYHEDRON.
    uint32_t projectile_shape;
    // Radius, m, >= sheet_spacing (not read for a box or a polyhedron).
    double projectile_radius;
    // Whole length of a cylinder, m, >= 2 sheet_spacing, with a hemispherical end >= the radius too (read for these only).
    double projectile_length;
    // Mass, kg, >= node mass; 0 = unknown, only with FK_DRIVE_PRESCRIBED.
    double projectile_mass;
    // Centre of mass at the start, m.
    double projectile_position[3];
    // Velocity at the start, m/s.
    double projectile_velocity[3];
    // Orientation at the start, unit quaternion.
    double projectile_orientation[4];
    // Angular velocity at the start, rad/s, host's axes.
    double projectile_angular_velocity[3];
    // Seed of the stochastic yarn.
    uint64_t seed;
    // Fraction of dt_crit in (0, 0.5], or the step in s, at most 0.5 dt_crit.
    double step_value;
    // Window of the peak force, s, > 0.
    double force_window;
    // FK_STEP_FRACTION or FK_STEP_SECONDS.
    uint32_t step_kind;
    // FK_STEP_CHECK_REFUSE or FK_STEP_CHECK_NONE.
    uint32_t step_check;
    // FK_DRIVE_FREE or FK_DRIVE_PRESCRIBED.
    uint32_t drive;
    // 1: watch whether the touched nodes are still held (4 bytes a node).
    uint32_t track_detachment;
    // 1: sum the impulses on the supports (the momentum residual needs them).
    uint32_t track_support;
    // Most nodes under the projectile at once; 0 = automatic.
    uint32_t contact_capacity;
    // Box: edge lengths along the body's axes, m, each >= 2 sheet_spacing.
    double projectile_size[3];
    // Polyhedron: principal moments of inertia about the centre of mass along the body's axes, kg m^2, > 0, none greater
    // than the other two together. Other shapes are homogeneous. Not read if the mass is unknown.
    double projectile_moments[3];
    // Polyhedron: number of faces, 4 to FK_MAX_FACES.
    uint32_t projectile_face_count;
    // 0.
    uint32_t reserved;
    // Polyhedron: of each face the outward unit normal and its distance from the centre of mass, m, >= sheet_spacing; body
    // axes. Beyond projectile_face_count not read.
    double projectile_faces[FK_MAX_FACES][4];
    // 1: mirror plane x = 0 through the sheet's middle; only x <= 0 is modelled. Sums stay those of the whole sheet,
    // read-outs of nodes and segments cover the part. For uniform yarn, a free projectile and a centred, untilted hit.
    uint32_t mirror_x;
    // 1: mirror plane y = 0; only y <= 0 is modelled.
    uint32_t mirror_y;
    // What draws its own constants: FK_DRAW_SEGMENT or FK_DRAW_YARN (a whole row or column).
    uint32_t yarn_draw;
    // FK_VERLET, or FK_THETA: the paper's theta rule by fixed-point iteration, the reference method.
    uint32_t integrator;
    // Theta rule: weight of the forces at the step's end, in [0.5, 1]; 0.5 is of second order.
    double theta;
    // Theta rule: the iteration ends when no node moves by more than this, in node spacings, > 0.
    double theta_tolerance;
    // Theta rule: iterations after which a step fails, >= 1.
    uint32_t theta_max_iterations;
    // How the projectile turns: FK_MIDPOINT, or FK_THETA, the paper's theta rule, which does not conserve.
    uint32_t rotation_rule;
    // Theta of the projectile's rotation, in [0.5, 1].
    double rotation_theta;
    // FK_STEP_KEEP, or FK_STEP_HALF: from the end of the step in which the first segment fails, every step is taken as two
    // halves (FK_VERLET only).
    uint32_t step_after_failure;
    // 0.
    uint32_t reserved_at_end;
    // Toe against the energy creep of slack sheets: Green-Lagrange strain over which the stiffness of a segment sets in once
    // it has been slack after the first failure, in [0.005, 0.05] and not beyond that of U_c; 0 = none (FK_VERLET only). The
    // largest step is 0.433 dt_crit with it.
    double slack_toe;
} fk_scene;

// Why a request was refused.
typedef struct fk_fault {
    // Set to sizeof(fk_fault) by the caller.
    uint64_t struct_size;
    // Status number.
    int32_t status;
    // 0.
    uint32_t reserved;
    // Offending value (0 where none applies).
    double value;
    // Limit crossed (0 where none applies); for FK_STEP_TOO_LARGE the largest allowed step, s.
    double limit;
    // Name of the field, zero-terminated; empty if no single field is to blame.
    char field[48];
    // One line for a log, zero-terminated.
    char text[168];
} fk_fault;

// Pose and rates of a rigid body, host's frame.
typedef struct fk_motion {
    // Set to sizeof(fk_motion) by the caller.
    uint64_t struct_size;
    // Centre of mass, m.
    double position[3];
    // Velocity, m/s.
    double velocity[3];
    // Orientation, unit quaternion, scalar first.
    double orientation[4];
    // Angular velocity, rad/s, host's axes.
    double angular_velocity[3];
} fk_motion;

// Where the host wants a prescribed body at the end of a communication step.
typedef struct fk_path {
    // Set to sizeof(fk_path) by the caller.
    uint64_t struct_size;
    // Step count at which the path starts: the present one, or that of the path being followed.
    uint64_t first;
    // Length in steps, >= 1.
    uint64_t steps;
    // Pose and rates at step first + steps (its own struct_size is checked too).
    struct fk_motion end;
} fk_path;

// The time step and its limits, s.
typedef struct fk_step_limits {
    // Set to sizeof(fk_step_limits) by the caller.
    uint64_t struct_size;
    // Step in use.
    double dt;
    // Stability limit of the taut sheet with the stiffest segment drawn.
    double dt_crit;
    // Largest accepted step, 0.5 dt_crit.
    double step_max;
} fk_step_limits;

// Contact sums since the start, host's axes.
typedef struct fk_contact {
    // Set to sizeof(fk_contact) by the caller.
    uint64_t struct_size;
    // Impulse on the projectile, N s.
    double impulse[3];
    // Angular impulse on the projectile about its moving centre of mass, N m s.
    double angular_impulse[3];
    // Work of the projectile on the fabric = energy absorbed, J.
    double work;
    // Kinetic energy lost in impacts of nodes, J.
    double loss;
    // Largest mean force over a window of force_window, N.
    double force_peak;
} fk_contact;

// Impulses of the sheet on its supports since the start, N s, host's axes.
typedef struct fk_support {
    // Set to sizeof(fk_support) by the caller.
    uint64_t struct_size;
    // All together.
    double total[3];
    // Sides: left (-x), right, bottom (-y), top. Corners: (-,-), (+,-), (-,+), (+,+).
    double attachments[4][3];
} fk_support;

// Energies, J.
typedef struct fk_energy {
    // Set to sizeof(fk_energy) by the caller.
    uint64_t struct_size;
    // Kinetic energy of the projectile (0 if its mass is unknown).
    double projectile_kinetic;
    // Kinetic energy of the fabric.
    double fabric_kinetic;
    // Strain energy of the yarns.
    double strain;
    // Energy dissipated by rupture.
    double dissipated;
    // Kinetic energy lost in impacts of nodes.
    double contact_loss;
    // Work of the projectile on the fabric.
    double contact_work;
    // Work of the external load.
    double external_work;
    // What the balance does not close by.
    double residual;
    // Change of the audited energy when the step was halved; 0 if it was not.
    double halving;
} fk_energy;

// Extremes of the fabric.
typedef struct fk_fabric {
    // Set to sizeof(fk_fabric) by the caller.
    uint64_t struct_size;
    // Largest distance of a node from the sheet's plane, m.
    double max_deflection;
    // Largest stretch of a live segment.
    double max_stretch;
} fk_fabric;

// Counters; available even after a failure.
typedef struct fk_counters {
    // Set to sizeof(fk_counters) by the caller.
    uint64_t struct_size;
    // Steps taken.
    uint64_t steps;
    // Segments with alpha = 0.
    uint64_t failed_segments;
    // Nodes with a contact impulse in the last step.
    uint64_t contacts;
    // Contact solves that ran out of sweeps.
    uint64_t unconverged;
    // Most sweeps of one contact solve.
    uint64_t most_sweeps;
    // Most candidate nodes of one step.
    uint64_t most_candidates;
    // Places for candidate nodes.
    uint64_t candidate_capacity;
    // Deepest penetration met, m.
    double worst_penetration;
    // Iterations of the theta rule so far.
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
    // FK_ARRESTED ... bits of all latched outcomes.
    uint32_t mask;
    // Step count at whose start the first impulse acted.
    uint64_t first_contact;
    // Step count of arrested, detached, exited, passed.
    uint64_t step[4];
    // Work of the projectile on the fabric until then, J.
    double work[4];
} fk_outcome;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Returns FK_ABI_VERSION of the library; compare it with the header's.
uint32_t fk_abi_version(void);

// Returns the library's version, e.g. "0.1.0", a static string.
const char *fk_version(void);

// Returns what a status number means, a static string; "unknown status" for numbers that no call returns.
const char *fk_status_name(int32_t status);

// Fills `scene` with the 10 in preset. `struct_size` is sizeof(fk_scene) as the caller was compiled.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE.
int32_t fk_scene_default(struct fk_scene *scene, uint64_t struct_size);

// Fills `scene` with a preset (FK_PRESET_...). `struct_size` is sizeof(fk_scene) as the caller was compiled.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_UNKNOWN_CHOICE.
int32_t fk_scene_preset(struct fk_scene *scene, uint64_t struct_size, uint32_t preset);

// Checks a scene, the time step included (which draws every segment of a stochastic sheet). `fault` may be null; on an
// error it receives the code, the first bad field, the value and the limit.
// Errors: every precondition of fk_scene's fields, FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE.
int32_t fk_scene_check(const struct fk_scene *scene, struct fk_fault *fault);

// Bytes and alignment of the block that fk_init needs for a scene.
// Errors: those of fk_scene_check but for the time step. On an error neither number has been written.
int32_t fk_memory_size(const struct fk_scene *scene, uint64_t *bytes, uint64_t *align);

// Makes a simulation of `scene` at the start of the caller's block and hands back its handle in `out`. The block must
// not be moved or copied while the handle is used (use fk_state_save and fk_state_load); simply let go of it when done.
// `fault` may be null. On an error nothing has been written but `fault`.
// Errors: those of fk_scene_check, FK_SHORT_BUFFER, FK_MISALIGNED, FK_INITIAL_OVERLAP, FK_PROJECTILE_TOO_FAST,
// FK_OUT_OF_RANGE (a projectile too heavy for its energy to be a number).
int32_t fk_init(void *memory,
                uint64_t bytes,
                const struct fk_scene *scene,
                struct fk_sim **out,
                struct fk_fault *fault);

// Back to step 0 as after fk_init. Clears a failure, the fault of fk_get_fault and the external load.
// Errors: FK_NULL_POINTER, FK_MOVED_BLOCK.
int32_t fk_reset(struct fk_sim *sim);

// One step. Errors: FK_NULL_POINTER, FK_MOVED_BLOCK, and the failures FK_NON_FINITE, FK_CONTACT_CAPACITY, FK_TOO_FAST,
// which every later call but reset, load and the counters repeats.
int32_t fk_step(struct fk_sim *sim);

// `steps` steps; the bits do not depend on how they are split over calls. Errors as fk_step.
int32_t fk_advance(struct fk_sim *sim, uint64_t steps);

// Up to `steps` steps, ending when any outcome of `mask` (FK_ARRESTED | ...) is latched. `taken` (may be null) receives the
// steps taken. Errors as fk_step.
int32_t fk_advance_until(struct fk_sim *sim,
                         uint32_t mask,
                         uint64_t steps,
                         uint64_t *taken);

// Moves a prescribed body along `path` for `steps` steps. Call again with the same path to go on along it.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, FK_WRONG_DRIVE, FK_BAD_PATH, FK_NOT_FINITE,
// FK_BAD_QUATERNION, FK_PROJECTILE_TOO_FAST, FK_OUT_OF_RANGE; failures as fk_step.
int32_t fk_follow(struct fk_sim *sim, const struct fk_path *path, uint64_t steps);

// Step count and time (steps times dt), s. Either pointer may be null.
// Errors: FK_NULL_POINTER (sim), FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_time(const struct fk_sim *sim, uint64_t *steps, double *seconds);

// The time step and its limits.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_step_limits(const struct fk_sim *sim, struct fk_step_limits *out);

// The projectile: pose at the present time, rates of the last half step.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_projectile(const struct fk_sim *sim, struct fk_motion *out);

// Sets the force, N, and torque, N m (3 numbers each, host's axes), that act on a free body from now on.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_NOT_FINITE, FK_WRONG_DRIVE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_set_external_load(struct fk_sim *sim, const double *force, const double *torque);

// Starts from given positions, m, and velocities, m/s: `n` = 3 numbers per node each, node by node, rows along x first,
// host's frame. Only before the first step; the velocity of fixed nodes must be 0.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_WRONG_LENGTH, FK_NOT_FINITE, FK_OUT_OF_RANGE, FK_INITIAL_OVERLAP,
// FK_ALREADY_STARTED, FK_MOVED_BLOCK, a latched failure.
int32_t fk_set_motion(struct fk_sim *sim, const double *positions, const double *velocities, uint64_t n);

// Gives every segment the largest stretch it has ever had (`n` = number of segments, horizontal ones first, row by row):
// a pre-damaged sheet. Only before the first step.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_WRONG_LENGTH, FK_NOT_FINITE, FK_OUT_OF_RANGE, FK_ALREADY_STARTED,
// FK_MOVED_BLOCK, a latched failure.
int32_t fk_set_largest_stretch(struct fk_sim *sim,
                               const double *stretches,
                               uint64_t n);

// Contact sums. Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_contact(const struct fk_sim *sim, struct fk_contact *out);

// Impulses on the supports; zero without track_support.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_support(const struct fk_sim *sim, struct fk_support *out);

// The energies, with a full pass over the sheet.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_energy(const struct fk_sim *sim, struct fk_energy *out);

// Linear momentum, N s, that the balance does not close by: three numbers, host's axes. Meaningful with track_support.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_momentum_residual(const struct fk_sim *sim, double *out);

// Largest deflection and stretch, with a full pass over the sheet.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_fabric(const struct fk_sim *sim, struct fk_fabric *out);

// Counters; also after a failure. Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK.
int32_t fk_get_counters(const struct fk_sim *sim, struct fk_counters *out);

// Why the last call that changes this simulation (fk_step ... fk_set_motion, fk_state_load) was refused or failed; status
// FK_OK and empty texts if none was since fk_init or fk_reset. Also after a failure.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK.
int32_t fk_get_fault(const struct fk_sim *sim,
                     struct fk_fault *out);

// Outcomes latched so far. Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_outcome(const struct fk_sim *sim, struct fk_outcome *out);

// Positions, m: `n` = 3 numbers per node, node by node, rows along x first, host's frame.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_WRONG_LENGTH, FK_MOVED_BLOCK, a latched failure.
int32_t fk_copy_positions(const struct fk_sim *sim, double *out, uint64_t n);

// Velocities, m/s: shape and errors as fk_copy_positions.
int32_t fk_copy_velocities(const struct fk_sim *sim, double *out, uint64_t n);

// alpha of every segment (1 whole, 0 failed): `n` = number of segments, horizontal ones first, row by row, then the
// vertical ones. Errors as fk_copy_positions.
int32_t fk_copy_damage(const struct fk_sim *sim, double *out, uint64_t n);

// Stretch of every segment: shape and errors as fk_copy_damage.
int32_t fk_copy_stretch(const struct fk_sim *sim, double *out, uint64_t n);

// Bytes of a snapshot image. Errors: FK_NULL_POINTER, FK_MOVED_BLOCK, a latched failure.
int32_t fk_state_size(const struct fk_sim *sim, uint64_t *bytes);

// Writes the state into `image`, at least fk_state_size bytes: portable between machines.
// Errors: FK_NULL_POINTER, FK_SHORT_BUFFER, FK_MOVED_BLOCK, a latched failure.
int32_t fk_state_save(const struct fk_sim *sim, uint8_t *image, uint64_t bytes);

// Puts the simulation into the state of an image of the same scene; clears a failure. On an error nothing has changed.
// Errors: FK_NULL_POINTER, FK_IMAGE_MALFORMED, FK_IMAGE_OF_ANOTHER_SCENE, FK_IMAGE_INVALID, FK_MOVED_BLOCK.
int32_t fk_state_load(struct fk_sim *sim, const uint8_t *image, uint64_t bytes);

// A hash of the whole state: equal digests mean equal bits. Errors: FK_NULL_POINTER, FK_MOVED_BLOCK, a latched failure.
int32_t fk_digest(const struct fk_sim *sim, uint64_t *digest);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* FABRIC_KERNEL_H */
