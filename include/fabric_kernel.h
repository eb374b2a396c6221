/* fabric_kernel.h - ballistic fabric as a network of trusses, hit by a rigid projectile.
 *
 * Made by `cargo xtask header` from capi/src and kernel/src; do not edit.
 *
 * How to use it: fill an fk_scene (fk_scene_preset), ask for its memory (fk_memory_size), give a block to fk_init, step, read
 * out (examples/c/first.c). All memory is the caller's; nothing is allocated, nothing is called back, there is nothing to destroy.
 *
 * Status. Every call returns one unless it says otherwise: 0 is success, -1 to -49 a request that was refused (nothing has
 * changed), -50 to -99 a numerical failure. A failure is latched: until fk_reset or fk_state_load every call returns its
 * number, but for fk_get_counters and fk_get_fault. Outcomes such as "exited" are physics, no errors: fk_get_outcome.
 *
 * Structures. A scene starts with its size, which fk_scene_default and fk_scene_preset set; of every other structure the caller
 * says the sizeof beside its pointer. A later library may know longer structures; it reads and writes no further than the caller's
 * size says, and takes the defaults for fields of a scene that are not there. Sizes that no version had are refused.
 *
 * Threads. "Threads: changes" - no other call on the same simulation at the same time. "Threads: reads" - other calls that
 * read may run at the same time. fk_bands_pass and fk_bands_progress may be called by several threads at once
 * (examples/c/threads.c). Different simulations are independent. No call waits, locks or allocates. None keeps a pointer it was
 * given, but for the block of fk_init, and the scratch of fk_bands_begin until fk_bands_end.
 *
 * Pointers. Each is null or valid for the length stated: one number, a structure of the size said, an array of the count beside
 * it, for sim a handle of fk_init whose block is still there. Nobody else writes there during the call, nor reads what the call
 * writes. Places of one call overlap neither one another nor the block or scratch. FK_MOVED_BLOCK is a courtesy: it tells a block
 * that was moved, copied or never initialised, and cannot see freed memory.
 *
 * "Touches" says what is written. On x86 with SSE2, x86-64, AArch64 and hard-float Arm every call computes rounding to nearest
 * and with subnormal numbers, whatever the host has set, and puts the host's floating-point environment back: the bits do not
 * depend on it. On other processors, such as RISC-V, the host must leave it at that.
 *
 * Units are SI; vectors are in the host's frame unless said otherwise; quaternions are scalar first. M1 to M22 are the equations
 * of docs/model.md. docs/embedding.md shows how to size memory, meet a deadline, drive the projectile and use several sheets.
 */

#ifndef FABRIC_KERNEL_H
#define FABRIC_KERNEL_H

#include <stdint.h>

// A pointer is null.
#define FK_NULL_POINTER -1

// A buffer is shorter than the size query said.
#define FK_SHORT_BUFFER -2

// A structure or an array does not lie at a multiple of what its numbers are aligned to.
#define FK_MISALIGNED -3

// The block was moved or copied, or never initialised: use save and load instead.
#define FK_MOVED_BLOCK -4

// A structure has a size that no version this library knows gave it.
#define FK_STRUCT_SIZE -5

// A number is NaN or infinite.
#define FK_NOT_FINITE -6

// A number must be greater than zero.
#define FK_NOT_POSITIVE -7

// A number lies outside its documented range.
#define FK_OUT_OF_RANGE -8

// A choice (kind of attachment, shape, ...) has an unknown number.
#define FK_UNKNOWN_CHOICE -9

// A quaternion has length zero or is far from unit length.
#define FK_BAD_QUATERNION -10

// The sheet has more nodes than memory can address.
#define FK_TOO_MANY_NODES -11

// The time step exceeds the largest allowed one; the fault's `limit` holds it.
#define FK_STEP_TOO_LARGE -12

// The parameters give a step limit that is zero, subnormal or not finite, or a step with which no calculation stays
// within the numbers: nodes of over 1e90 kg (N s, J at one spacing a step), or over a thousand times dt_crit.
#define FK_STEP_LIMIT_UNUSABLE -13

// A damage rate below 3 would make the yarn stiffer beyond the critical stretch than the step limit assumes.
#define FK_DAMAGE_RATE_TOO_SMALL -14

// The projectile is lighter than one node of the sheet.
#define FK_PROJECTILE_TOO_LIGHT -15

// The projectile is smaller than the node spacing: nodes would not see it.
#define FK_PROJECTILE_TOO_SMALL -16

// The projectile would cross more than one node spacing in a step, or turn more than half a radian: take a smaller
// step. Yarn that is soft or heavy allows steps so large that a usual speed is too fast for them. The fault's `limit`
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

// The call does not fit the way the projectile is driven (free or prescribed).
#define FK_WRONG_DRIVE -22

// A path does not start where the simulation is, or has no steps.
#define FK_BAD_PATH -23

// The call is only allowed before the first step.
#define FK_ALREADY_STARTED -24

// The bytes are not a snapshot image, or are truncated or altered.
#define FK_IMAGE_MALFORMED -25

// The image was made with another scene or another version.
#define FK_IMAGE_OF_ANOTHER_SCENE -26

// The image has a correct checksum but holds values no simulation can have.
#define FK_IMAGE_INVALID -27

// A normal is not of unit length (to 1e-6).
#define FK_BAD_NORMAL -28

// The faces of a polyhedron do not enclose a body.
#define FK_UNBOUNDED_FACES -29

// Moments of inertia that no body has: one is greater than the other two together.
#define FK_IMPOSSIBLE_MOMENTS -30

// Mirror planes with something they would change: a hit, a motion or a load off the planes.
#define FK_NOT_SYMMETRIC -31

// The scene asks for something this build was made without.
#define FK_NOT_BUILT -32

// A band that was called already in this pass, or a call that does not go with bands in use or without them.
#define FK_BAND_OUT_OF_TURN -33

// The theta rule cannot be stepped in bands.
#define FK_NOT_IN_BANDS -34

// The corner discs lie between the nodes and hold none; the fault's `limit` holds the smallest radius, m, that reaches
// one.
#define FK_HOLDS_NOTHING -35

// Pre-tension that pulls at an edge which is not held, or at segments that are sampled one by one: the sheet would move
// by itself.
#define FK_NOT_IN_EQUILIBRIUM -36

// An option that does not go with another one, each of which is good by itself. The fault's text names both.
#define FK_DOES_NOT_GO_WITH -37

// Plies of a stack that start through each other: a node lies below the one that it faces in the ply before.
#define FK_PLIES_OVERLAP -38

// The bytes are not a capsule, or are cut off, altered or of another format; or no capsule is being written.
#define FK_BAD_CAPSULE -39

// A non-finite number appeared in the state, or a stretch beyond 1e25: the simulation is lost.
#define FK_NON_FINITE -50

// More nodes came under the projectile than a `contact_capacity` other than 0 allows; the state is kept at the step's
// start.
#define FK_CONTACT_CAPACITY -51

// The projectile became faster than one node spacing in a step.
#define FK_TOO_FAST -52

// The theta rule's iteration did not converge; the state is kept at the step's start.
#define FK_NOT_CONVERGED -53

// attachment.kind: first and last column (left and right).
#define FK_ATTACHMENT_TWO_SIDES 0

// attachment.kind: the whole edge.
#define FK_ATTACHMENT_FOUR_SIDES 1

// attachment.kind: discs near the four corners.
#define FK_ATTACHMENT_FOUR_CORNERS 2

// attachment.kind: nothing.
#define FK_ATTACHMENT_FREE 3

// yarn.draw: every segment.
#define FK_DRAW_SEGMENT 0

// yarn.draw: every woven yarn: a whole row or column of segments.
#define FK_DRAW_YARN 1

// yarn.strength_draw: every segment has yarn.critical_stretch.
#define FK_STRENGTH_DRAW_NONE 0

// yarn.strength_draw: every segment has its own: U_c - 1 has a Weibull distribution.
#define FK_STRENGTH_DRAW_WEIBULL 1

// projectile.shape: sphere; feels no torque without friction.
#define FK_SHAPE_SPHERE 0

// projectile.shape: flat-ended cylinder along the body's z axis.
#define FK_SHAPE_CYLINDER 1

// projectile.shape: cylinder along the body's z axis with a hemisphere at its +z end.
#define FK_SHAPE_HEMISPHERICAL_CYLINDER 2

// projectile.shape: box with its edges along the body's axes.
#define FK_SHAPE_BOX 3

// projectile.shape: convex polyhedron by its faces.
#define FK_SHAPE_POLYHEDRON 4

// projectile.shape: sector of a turbine disc, its rim along x and the disc's axis along z.
#define FK_SHAPE_DISC_SECTOR 5

// drive: the model moves the projectile under contact and the external load.
#define FK_DRIVE_FREE 0

// drive: the host moves the projectile; the model gives force, impulse and work.
#define FK_DRIVE_PRESCRIBED 1

// integrator.kind: velocity Verlet, explicit.
#define FK_INTEGRATOR_VERLET 0

// integrator.kind: the paper's theta rule by fixed-point iteration: the reference method.
#define FK_INTEGRATOR_THETA 1

// step_check: a step above 0.5 dt_crit is refused.
#define FK_STEP_CHECK_REFUSE 0

// step_check: no check, for stability studies only: wrong results without a warning.
#define FK_STEP_CHECK_NONE 1

// rotation_rule.kind: implicit midpoint rule, which keeps energy and angular momentum.
#define FK_ROTATION_MIDPOINT 0

// rotation_rule.kind: the paper's theta rule, which does not conserve.
#define FK_ROTATION_THETA 1

// Graded network: bars that stand for several yarns, away from the hit: a part of fk_scene.
typedef struct fk_scene_sheet_grading {
    // Most yarns that one bar stands for, and as many crossings: 2, 4, 8, 16, 32 or 64; 0 or 1 = no grading. Bars grow
    // by factors of two away from the fine part. 0 to 64. Default 0.
    uint64_t largest;
    // Bars of each size before the next. Read with grading only. 1 to 1000000. Default 4.
    uint64_t run;
    // Middle of the fine part along x and along y in the sheet's frame, about the expected hit; 0 across a mirror
    // plane. Read with grading only. In m. Default 0 each.
    double centre[2];
    // Half the width of the fine part along x and along y. Read with grading only. In m, >= 0. Default 0 each.
    double half_width[2];
} fk_scene_sheet_grading;

// Faces of a polyhedron, in body axes: a part of fk_scene.
typedef struct fk_scene_projectile_faces {
    // Number of faces of a polyhedron, 4 to 16. Read for a polyhedron only. 0 to 16. Default 0.
    uint64_t count;
    // Outward unit normal of each face (to 1e-6) and its distance from the centre of mass in m, at least sheet.spacing.
    // Beyond the count not read. Default 0 each.
    double planes[16][4];
} fk_scene_projectile_faces;

// Dimensions of a disc sector: a part of fk_scene.
typedef struct fk_scene_projectile_sector {
    // Radius of the bore, 0 or between 1e-6 and 1 - 1e-6 of that of the rim; filled up to its one chord. Read for a
    // disc sector only. In m, >= 0. Default 0.015.
    double inner_radius;
    // Radius of the rim, which is made of eight chords; no face may be nearer to the centre of mass than sheet.spacing.
    // Read for a disc sector only. In m, > 0. Default 0.04.
    double outer_radius;
    // Angle of a disc sector. Read for a disc sector only. In rad, >= 0.001 and < 3.141592653589793. Default
    // 2.0943951023931953.
    double angle;
    // Thickness along the disc's axis, at least 2 sheet.spacing. Read for a disc sector only. In m, > 0. Default 0.01.
    double thickness;
} fk_scene_projectile_sector;

// Grid of nodes, its mass and its place: a part of fk_scene.
typedef struct fk_scene_sheet {
    // Nodes along x. 2 to 1048576. Default 350 (3 in preset: 105).
    uint64_t nodes_x;
    // Nodes along y. 2 to 1048576. Default 350 (3 in preset: 105).
    uint64_t nodes_y;
    // Plies sewn or bonded into one network: mass and area are multiplied. Loose plies are stack.plies. 1 to 1000.
    // Default 1.
    uint64_t plies;
    // Thickness t of a ply; n bonded ones are n t thick, at most a tenth of the sheet. The projectile touches the
    // network, the middle of the cloth, at half of it; 0 = a surface without thickness. A projectile must start farther
    // away. In m, >= 0. Default 0.
    double thickness;
    // Node spacing h along x, the natural length of a segment (M1) without crimp and pre-tension. In m, > 0. Default
    // 7.257142857142857e-4.
    double spacing;
    // Node spacing along y, 0.1 to 10 times that along x; 0: as along x. What must exceed sheet.spacing must exceed
    // this, too. In m, >= 0. Default 0.
    double spacing_y;
    // Mass of a node of one ply (M7), the same for edge nodes. In kg, > 0. Default 6.52e-8.
    double node_mass;
    // Cross-section A_0 of a yarn of one ply (M4). In m2, > 0. Default 1.075e-7.
    double yarn_area;
    // Cross-section of a yarn along y; 0: as along x. In m2, >= 0. Default 0.
    double yarn_area_y;
    // Crimp of the yarns along x and along y: natural length of a segment over the node spacing, less 1. A segment
    // pulls only once it is taken up. 0 to 1. Default 0 each.
    double crimp[2];
    // Strain of the held sheet along x (two or four sides) and along y (four sides), below critical_stretch - 1 and
    // without crimp: node spacing over the natural length of a segment, less 1. Not with a modulus sampled for every
    // segment. >= 0. Default 0 each.
    double pre_strain[2];
    // Radius to the nodes of a sheet curved about its y axis, which rests at (R sin a, y, R cos a) with chords of
    // sheet.spacing (M23); 0 = flat. Separate plies lie at R + k (stack.gap + thickness). Velocity Verlet only; not
    // with yarn.viscosity_bending, a dependence on the rate of strain, a graded network, mirror planes or four corners.
    // In m, >= 0. Default 0.
    double radius;
    // A ring: a segment joins the last node of every row to its first. sheet.radius must be sheet.spacing/(2
    // sin(pi/sheet.nodes_x)) to 1e-6; two sides cannot be held. 0 or 1. Default 0.
    uint64_t closed;
    // Middle of the sheet in the host's frame; of a curved one the middle of its axis. In m. Default 0 each.
    double position[3];
    // Unit quaternion, scalar first, that turns the sheet's axes (normal z) into the host's. Of unit length to 1e-3.
    // Default (1, 0, 0, 0).
    double orientation[4];
    // Graded network: bars that stand for several yarns, away from the hit.
    fk_scene_sheet_grading grading;
} fk_scene_sheet;

// Separate plies one behind the other: a part of fk_scene.
typedef struct fk_scene_stack {
    // Loose plies, each a network with samples of its own, held like the first, in contact with each other; sewn ones
    // are sheet.plies. Velocity Verlet only; not with mirror planes or a dependence on the rate of strain. 1 to 1000.
    // Default 1.
    uint64_t plies;
    // Air between neighbouring plies where they rest, at most a million node spacings; 0: they lie on each other, as
    // plies of a ring with pre-strain along x must. Read for more than one ply only. In m, >= 0. Default 0.
    double gap;
    // Every other ply is turned by 90 degrees, so that its warp runs along y; the node spacings must be alike. Read for
    // more than one ply only. 0 or 1. Default 0.
    uint64_t turned;
} fk_scene_stack;

// Another fabric of the last plies, in the same grid of nodes. The numbers are read if back.plies is not 0: a part of
// fk_scene.
typedef struct fk_scene_back {
    // The last so many plies, less than stack.plies, are of this fabric; 0: none. 0 to 1000. Default 0.
    uint64_t plies;
    // Mass of a node of a ply (M7). In kg, > 0. Default 6.52e-8.
    double node_mass;
    // Cross-section A_0 of a bar along x (M4). In m2, > 0. Default 1.075e-7.
    double yarn_area;
    // Cross-section of a bar along y; 0: as along x. In m2, >= 0. Default 0.
    double yarn_area_y;
    // Crimp of the yarns along x and along y. 0 to 1. Default 0 each.
    double crimp[2];
    // Mean Young's modulus E of a segment (M3). In Pa, > 0. Default 1.4021e11.
    double modulus_mean;
    // Standard deviation of the modulus. Modulus and damage rate are sampled if this or back.damage_sd is not 0. In Pa,
    // >= 0. Default 2.04e9.
    double modulus_sd;
    // Slope of the damage rate over the modulus (M6). In 1/Pa. Default 7.91e-9.
    double damage_slope;
    // Damage rate at zero modulus (M6); the mean rate must be at least 3. Default -878.46.
    double damage_intercept;
    // Standard deviation of the damage rate about the line. >= 0. Default 8.35.
    double damage_sd;
    // Critical stretch U_c at which damage begins (M5). > 1 and <= 2. Default 1.03.
    double critical_stretch;
    // Weibull shape m of the critical strain U_c - 1, at least 1; 0: it is not sampled. 0 to 1000. Default 0.
    double weibull_shape;
    // Gauge length L at which back.critical_stretch - 1 is the Weibull scale; 0: L is the length of a segment. Counts
    // for sampled strength only. In m, >= 0. Default 0.
    double weibull_gauge_length;
} fk_scene_back;

// How the sheet is held: a part of fk_scene.
typedef struct fk_scene_attachment {
    // Which nodes are held. One of FK_ATTACHMENT_TWO_SIDES, FK_ATTACHMENT_FOUR_SIDES, FK_ATTACHMENT_FOUR_CORNERS and
    // FK_ATTACHMENT_FREE. Default FK_ATTACHMENT_TWO_SIDES (3 in preset: FK_ATTACHMENT_FOUR_SIDES).
    uint64_t kind;
    // Distance of a corner disc's centre from both edges. Read for four corners only. In m, >= 0. Default 0.0254 (3 in
    // preset: 0.00762).
    double disc_inset;
    // Radius of the corner discs. Each must hold a node; they may neither overlap nor reach under the projectile. Read
    // for four corners only. In m, > 0. Default 0.01905 (3 in preset: 0.005715).
    double disc_radius;
    // Force H at which the clamp lets a bar of one ply slip (M25), for each bar that ends there; 0 = without limit.
    // Velocity Verlet only. In N, >= 0. Default 0.
    double hold;
    // Length of yarn in the clamp: a node that has slid so far has been pulled out; 0 = without end. Only with a hold.
    // In m, >= 0. Default 0.
    double grip;
    // Mean force over force_window at which one attachment as a whole lets go; 0 = never. In N, >= 0. Default 0.
    double strength;
} fk_scene_attachment;

// The yarn law and its scatter: a part of fk_scene.
typedef struct fk_scene_yarn {
    // Mean Young's modulus E of a segment (M3). In Pa, > 0. Default 1.4021e11.
    double modulus_mean;
    // Standard deviation of the modulus. Counts for stochastic yarn only. In Pa, >= 0. Default 2.04e9.
    double modulus_sd;
    // Slope of the damage rate over the modulus (M6). In 1/Pa. Default 7.91e-9.
    double damage_slope;
    // Damage rate at zero modulus on that line (M6); the mean rate must be at least 3. Default -878.46.
    double damage_intercept;
    // Standard deviation of the damage rate about the line. Counts for stochastic yarn only. >= 0. Default 8.35.
    double damage_sd;
    // Critical stretch U_c at which damage begins (M5). > 1 and <= 2. Default 1.03.
    double critical_stretch;
    // Factor A of the damage law (M5); A (1 - B) must lie in (0, 1]. > 0. Default 1.
    double damage_a;
    // Offset B of the damage law (M5). < 1. Default 0.
    double damage_b;
    // Remaining part alpha of the stiffness (M5) at or below which a segment fails. >= 0 and < 1. Default 0.01.
    double alpha_fail;
    // Modulus and damage rate are sampled; if not, every segment takes the means. 0 or 1. Default 1.
    uint64_t stochastic;
    // What gets a sample of its own. Read for stochastic yarn only. One of FK_DRAW_SEGMENT and FK_DRAW_YARN. Default
    // FK_DRAW_SEGMENT.
    uint64_t draw;
    // Whether every segment has a critical stretch of its own, whether or not modulus and damage rate are sampled; not
    // with mirror planes. One of FK_STRENGTH_DRAW_NONE and FK_STRENGTH_DRAW_WEIBULL. Default FK_STRENGTH_DRAW_NONE.
    uint64_t strength_draw;
    // Weibull shape m of the critical strain U_c - 1. Read for sampled strength only. 1 to 1000. Default 14.7.
    double weibull_shape;
    // Gauge length L at which yarn.critical_stretch - 1 is the Weibull scale: that of a segment of length h is larger
    // by (L/h)^(1/m). 0: L is h. Read for sampled strength only. In m, >= 0. Default 0.
    double weibull_gauge_length;
    // Correlation of the normal scores of two segments of one woven yarn; the size effect holds along a yarn for 0.
    // Read for sampled strength only, that of the back fabric included. 0 to 1. Default 0.
    double weibull_correlation;
    // Viscosity of taut yarn, linear in the rate of stretch, against oscillation behind a front; 0 = none. Velocity
    // Verlet only. 0 to 1. Default 0.
    double viscosity_linear;
    // Likewise, quadratic in the rate and only while the yarn is stretched. 0 to 10. Default 0.
    double viscosity_quadratic;
    // Viscosity of taut yarn against bending, linear in the second difference of the velocities along it; 0 = none.
    // Velocity Verlet only. 0 to 0.2. Default 0.
    double viscosity_bending;
    // Growth C_E of the modulus by e-fold of the rate of strain above yarn.rate_reference (M19); 0 = none. Velocity
    // Verlet only; not with slack_balance, pre-tension or separate plies. 0 to 1. Default 0.
    double rate_modulus;
    // Growth C_U of the critical strain by e-fold of the rate of strain (M20); 0 = none. 0 to 1. Default 0.
    double rate_stretch;
    // Rate of strain at which modulus and critical stretch are as given, at least 1e-9/s; slower ones count as this.
    // Read for yarn that depends on the rate only. In 1/s, 0 to 1e9. Default 0.
    double rate_reference;
    // Largest rate of strain measured, at least yarn.rate_reference; faster ones count as this. Read for yarn that
    // depends on the rate only. In 1/s, 0 to 1e9. Default 0.
    double rate_limit;
} fk_scene_yarn;

// The yarn along y, where it is unlike that along x: a part of fk_scene.
typedef struct fk_scene_weft {
    // Mean Young's modulus of a segment along y; 0: modulus and damage rate as along x. In Pa, >= 0. Default 0.
    double modulus_mean;
    // Standard deviation of the modulus. Read if weft.modulus_mean is not 0. In Pa, >= 0. Default 0.
    double modulus_sd;
    // Slope of the damage rate over the modulus (M6). Read if weft.modulus_mean is not 0. In 1/Pa. Default 0.
    double damage_slope;
    // Damage rate at zero modulus (M6); the mean rate must be at least 3. Read if weft.modulus_mean is not 0. Default
    // 0.
    double damage_intercept;
    // Standard deviation of the damage rate about the line. Read if weft.modulus_mean is not 0. >= 0. Default 0.
    double damage_sd;
    // Critical stretch U_c of a segment along y, greater than 1 (M5); 0: as along x. 0 to 2. Default 0.
    double critical_stretch;
} fk_scene_weft;

// The rigid projectile and its motion at the start, in the host's frame: a part of fk_scene.
typedef struct fk_scene_projectile {
    // Form of the projectile (M12). One of FK_SHAPE_SPHERE, FK_SHAPE_CYLINDER, FK_SHAPE_HEMISPHERICAL_CYLINDER,
    // FK_SHAPE_BOX, FK_SHAPE_POLYHEDRON and FK_SHAPE_DISC_SECTOR. Default FK_SHAPE_CYLINDER (3 in preset:
    // FK_SHAPE_SPHERE).
    uint64_t shape;
    // Radius, at least sheet.spacing. Read for a sphere and the two cylinders only. In m, > 0. Default 0.00635.
    double radius;
    // Whole length along the axis, at least 2 sheet.spacing, and with a hemispherical end at least the radius. Read for
    // the two cylinders only. In m, > 0. Default 0.0381 (3 in preset: 0.0127).
    double length;
    // Mass, at least that of a node with all its plies. Prescribed projectile: 0 if it is not known. In kg. Default
    // 0.037 (3 in preset: 0.0084).
    double mass;
    // Edge lengths of a box along the body's axes, each at least 2 sheet.spacing. Read for a box only. In m, > 0.
    // Default 0.0127 each.
    double size[3];
    // Faces of a polyhedron, in body axes.
    fk_scene_projectile_faces faces;
    // Principal moments of inertia about the centre of mass along the body's axes, none greater than the other two
    // together. Read for a polyhedron of known mass only; other shapes are homogeneous. In kg.m2, > 0. Default 0 each.
    double moments[3];
    // Centre of mass at the start. No node may lie inside the projectile (a fixed one may in a prescribed one). In m.
    // Default (0, 0, -0.01905) (3 in preset: (0, 0, -0.00635)).
    double position[3];
    // Velocity of the centre of mass at the start. No point of the surface may cross sheet.spacing in a step. In m/s.
    // Default (0, 0, 100).
    double velocity[3];
    // Orientation at the start: unit quaternion, scalar first, that turns body vectors into the host's axes. Of unit
    // length to 1e-3. Default (1, 0, 0, 0).
    double orientation[4];
    // Angular velocity at the start, host's axes. In rad/s. Default 0 each.
    double angular_velocity[3];
    // Dimensions of a disc sector.
    fk_scene_projectile_sector sector;
} fk_scene_projectile;

// The rigid case under a ring: a part of fk_scene.
typedef struct fk_scene_casing {
    // Radius of a rigid case about the axis of a ring, which its nodes may lift off but not enter (M24), at most
    // sheet.radius; 0 = none. A ring with pre-strain along x needs one of sheet.radius. The projectile does not meet
    // it. In m, >= 0. Default 0.
    double radius;
    // A window in which there is no case: angle of its middle from +z towards +x, and half its angle; 0 = no window.
    // Read with a case only. In rad, 0 to 6.283185307179586. Default 0 each.
    double window_angle[2];
    // Place of its middle along y in the sheet's frame, and half its length; 0 = no window. Read with a case only. In
    // m. Default 0 each.
    double window_place[2];
} fk_scene_casing;

// Contact of yarn and projectile: a part of fk_scene.
typedef struct fk_scene_contact {
    // Coefficient of Coulomb friction between yarn and projectile (M21); 0 = none. With it a sphere turns, too.
    // Velocity Verlet only. 0 to 10. Default 0.
    double friction;
} fk_scene_contact;

// Mirror planes through the middle of the sheet; only the part at x <= 0, y <= 0 is modelled: a part of fk_scene.
typedef struct fk_scene_symmetry {
    // Mirror plane x = 0. Sums stay those of the whole sheet. For uniform yarn, a free projectile and a centred,
    // untilted hit. 0 or 1. Default 0.
    uint64_t mirror_x;
    // Mirror plane y = 0, likewise. 0 or 1. Default 0.
    uint64_t mirror_y;
} fk_scene_symmetry;

// How the nodes are stepped: a part of fk_scene.
typedef struct fk_scene_integrator {
    // Velocity Verlet (M7), or the paper's theta rule (M10). One of FK_INTEGRATOR_VERLET and FK_INTEGRATOR_THETA.
    // Default FK_INTEGRATOR_VERLET.
    uint64_t kind;
    // Theta rule: weight of the forces at the step's end (M10); 0.5 is of second order. 0.5 to 1. Default 0.5.
    double theta;
    // Theta rule: the iteration ends when no node moves by more than this, in node spacings. > 0. Default 1e-10.
    double tolerance;
    // Theta rule: iterations after which a step fails. 1 to 4294967295. Default 500.
    uint64_t max_iterations;
} fk_scene_integrator;

// The time step, constant for the life of a simulation: a part of fk_scene.
typedef struct fk_scene_time_step {
    // Time step as a fraction of dt_crit (M11), at most 0.5. Read if time_step.seconds is 0. > 0. Default 0.4.
    double fraction;
    // Time step in seconds, at most 0.5 dt_crit; 0: time_step.fraction says it. In s, >= 0. Default 0.
    double seconds;
} fk_scene_time_step;

// How the projectile turns between impulses: a part of fk_scene.
typedef struct fk_scene_rotation_rule {
    // The implicit midpoint rule, or the paper's theta rule. One of FK_ROTATION_MIDPOINT and FK_ROTATION_THETA. Default
    // FK_ROTATION_MIDPOINT.
    uint64_t kind;
    // Theta rule of the rotation: weight of the step's end. 0.5 to 1. Default 0.5.
    double theta;
} fk_scene_rotation_rule;

// What is simulated. Fill it with fk_scene_default or fk_scene_preset, then change fields. The first bad field is named
// by fk_scene_check and fk_init. The default is what fk_scene_default gives; where the 3 in preset differs it is said.
typedef struct fk_scene {
    // Bytes of this structure; set by fk_scene_default and fk_scene_preset.
    uint64_t struct_size;
    // Grid of nodes, its mass and its place.
    fk_scene_sheet sheet;
    // Separate plies one behind the other.
    fk_scene_stack stack;
    // Another fabric of the last plies, in the same grid of nodes. The numbers are read if back.plies is not 0.
    fk_scene_back back;
    // How the sheet is held.
    fk_scene_attachment attachment;
    // The yarn law and its scatter.
    fk_scene_yarn yarn;
    // The yarn along y, where it is unlike that along x.
    fk_scene_weft weft;
    // The rigid projectile and its motion at the start, in the host's frame.
    fk_scene_projectile projectile;
    // The rigid case under a ring.
    fk_scene_casing casing;
    // Contact of yarn and projectile.
    fk_scene_contact contact;
    // Mirror planes through the middle of the sheet; only the part at x <= 0, y <= 0 is modelled.
    fk_scene_symmetry symmetry;
    // Who moves the projectile. One of FK_DRIVE_FREE and FK_DRIVE_PRESCRIBED. Default FK_DRIVE_FREE.
    uint64_t drive;
    // How the nodes are stepped.
    fk_scene_integrator integrator;
    // Seed of the random samples. Default 1.
    uint64_t seed;
    // The time step, constant for the life of a simulation.
    fk_scene_time_step time_step;
    // Whether the time step is checked against its limit. One of FK_STEP_CHECK_REFUSE and FK_STEP_CHECK_NONE. Default
    // FK_STEP_CHECK_REFUSE.
    uint64_t step_check;
    // The energy error of segments that become slack or taut is corrected. Velocity Verlet only; not with a dependence
    // on the rate of strain. 0 or 1. Default 0.
    uint64_t slack_balance;
    // How the projectile turns between impulses.
    fk_scene_rotation_rule rotation_rule;
    // Window of the peak force, rounded to whole steps, at least one. Until the first is full the peak force is the
    // mean over the time elapsed. In s, > 0. Default 1e-6.
    double force_window;
    // Watch whether the touched nodes are still held (4 bytes a node); without it a projectile that carries torn cloth
    // never exits. 0 or 1. Default 1.
    uint64_t track_detachment;
    // Sum the impulses on the supports; the momentum residual needs them. 0 or 1. Default 1.
    uint64_t track_support;
    // Most nodes closer than sheet.spacing to the projectile at once, 120 bytes each (128 with the theta rule, 272 with
    // friction); more are a failure. 0 = every node. Default 0.
    uint64_t contact_capacity;
    // Watch whether held yarn can still stop a free projectile: the outcome through, long before exited. Needs
    // track_detachment to distinguish held yarn from loose yarn. 0 or 1. Default 0.
    uint64_t track_through;
} fk_scene;

// Version of this interface: goes up whenever a structure or a function is added. A host needs a library of at least its own.
#define FK_ABI_VERSION 1

// Success.
#define FK_OK 0

// Most bands for fk_bands_begin.
#define FK_MAX_BANDS 32

// Preset of the paper's 3 in sheet (105 x 105) with four sides held and the 8.4 g sphere.
#define FK_PRESET_SHEET_3IN_SPHERE 0

// Preset of the paper's 10 in sheet (350 x 350) with two sides held and the 37 g cylinder.
#define FK_PRESET_SHEET_10IN_CYLINDER 1

// Preset of the 10 in sheet with four sides held and a third of a small turbine disc, rim first, as a polyhedron: set
// projectile.shape to FK_SHAPE_DISC_SECTOR to change it by its dimensions. Its mass does not follow from them.
#define FK_PRESET_TURBINE_DISC_SECTOR 2

// Preset of a ring of NASA's tests, 40 in across within: five plies of Zylon on a case, and the sector of a disc that left the axis.
#define FK_PRESET_RING_40IN 3

// Bit of the outcome "arrested" in masks.
#define FK_ARRESTED 1

// Bit of the outcome "detached".
#define FK_DETACHED 2

// Bit of the outcome "exited".
#define FK_EXITED 4

// Bit of the outcome "passed".
#define FK_PASSED 8

// Bit of the outcome "through"; it comes only with track_through.
#define FK_THROUGH 16

// Bit of the outcome "rebounded".
#define FK_REBOUNDED 32

// Bit of the outcome "attachment_failed"; it comes only with attachment.strength.
#define FK_ATTACHMENT_FAILED 64

// Bits of the outcomes that end a shot: arrested, exited, passed, rebounded.
#define FK_ENDS 45

// fk_outcome's status: no contact in the last step.
#define FK_STATUS_FLIGHT 0

// fk_outcome's status: contact in the last step.
#define FK_STATUS_CONTACT 1

// fk_energy's gained over the kinetic energy at impact, above which the outcome is not to be trusted.
#define FK_MOST_GAINED 1e-3

// A step count that has not happened.
#define FK_NEVER UINT64_MAX

// fk_replayed's end: there is more to do.
#define FK_REPLAY_GOES_ON 0

// fk_replayed's end: all of it was done, with the same bits.
#define FK_REPLAY_SAME 1

// fk_replayed's end: a digest of the state differs.
#define FK_REPLAY_DIGEST 2

// fk_replayed's end: a call ended at another step.
#define FK_REPLAY_STEPS 3

// fk_replayed's end: a call failed otherwise, or is refused; both numbers are statuses.
#define FK_REPLAY_STATUS 4

// A simulation in its block. C knows only that it exists.
typedef struct fk_sim fk_sim;

// The yarns of one direction of a textile.
typedef struct fk_threads {
    // Mass of a yarn over its length, kg/m, > 0.
    double linear_density;
    // Yarns per metre of cloth, 1/m, > 0: ends of the warp, picks of the weft.
    double count;
    // Crimp: length of a yarn over that of the cloth, less 1, in [0, 1].
    double crimp;
} fk_threads;

// A textile of two directions of one fibre, per ply.
typedef struct fk_textile {
    // Yarns along x.
    struct fk_threads warp;
    // Yarns along y.
    struct fk_threads weft;
    // Density of the fibre, kg/m^3, > 0.
    double fibre_density;
    // Young's modulus of a yarn, over the area of its fibres, Pa, > 0.
    double modulus;
    // Standard deviation of that modulus among segments, Pa, >= 0; 0: all have the same.
    double modulus_sd;
    // Strain at which a yarn begins to fail, in (0, 1]; 0: `strength` says it. With a Weibull shape: the
    // Weibull scale.
    double failure_strain;
    // Force at which a yarn begins to fail over the area of its fibres at rest, Pa, > 0; 0: `failure_strain`
    // says it.
    double strength;
    // Part of the failure strain, or of the strength, that weaving has taken, in [0, 1); 0 for yarn taken
    // from the fabric.
    double weaving_loss;
    // Damage rate lambda beyond the failure strain, dimensionless, at least 3; 0: ln(100)/0.002.
    double damage_rate;
    // Weibull shape of the failure strain, in [1, 1000]; 0: all segments fail at the same strain.
    double weibull_shape;
    // Gauge length of the failure strain, m, >= 0; 0: the length of a segment. Read with a Weibull shape
    // only.
    double gauge_length;
    // Thickness of the ply, m, >= 0; 0: unknown, and [`Textile::assumed_thickness`] is taken.
    double thickness;
} fk_textile;

// Why a request was refused or a step failed.
typedef struct fk_fault {
    // Status number: FK_OK, or an error's.
    int32_t status;
    // 0.
    uint32_t reserved;
    // Offending value in SI units; 0 where none applies.
    double value;
    // Limit crossed, SI units; 0 where none applies. For FK_STEP_TOO_LARGE the largest allowed step, s; for
    // FK_WRONG_LENGTH and FK_SHORT_BUFFER the length wanted.
    double limit;
    // Name of the field, zero-terminated, as in fk_scene, e.g. "sheet.spacing"; empty if no single field is to blame.
    char field[48];
    // One line for a log, zero-terminated.
    char text[168];
} fk_fault;

// Position, orientation and rates of a rigid body in one frame. Angular velocity in the axes of that frame.
typedef struct fk_motion {
    // Centre of mass, m.
    double position[3];
    // Velocity of the centre of mass, m/s.
    double velocity[3];
    // Orientation, unit quaternion, scalar first.
    double orientation[4];
    // Angular velocity, rad/s.
    double angular_velocity[3];
} fk_motion;

// Where the host wants the body at the end of a communication step, in the host's frame.
typedef struct fk_path {
    // Step count at which the path starts: the simulation's present count, or that of the path being
    // followed.
    uint64_t first;
    // Length of the path in steps, at least 1; less than half a turn of the body.
    uint64_t steps;
    // Pose and rates at step `first + steps`. The body gets there by M13.
    struct fk_motion end;
} fk_path;

// The time step and its limits (M11), s.
typedef struct fk_step_limits {
    // The step in use, constant for the life of a simulation.
    double dt;
    // 2/omega_max of the taut sheet at the critical stretch, with the stiffest sampled segment.
    double dt_crit;
    // Largest accepted step: 0.5 dt_crit.
    double step_max;
} fk_step_limits;

// Modelled part of the sheet, and so the lengths of the arrays of fk_copy_... and fk_set_... Of a stack it is what one ply
// has, and arrays hold `plies` times as much, ply by ply.
typedef struct fk_grid {
    // Nodes along x: sheet.nodes_x, of a graded network its own, or what symmetry.mirror_x leaves of them.
    uint64_t nodes_x;
    // Nodes along y: sheet.nodes_y, of a graded network its own, or what symmetry.mirror_y leaves of them.
    uint64_t nodes_y;
    // Segments along x, row by row, horizontal / nodes_y in each row.
    uint64_t horizontal;
    // Segments along y, row by row, nodes_x in each row; in arrays they come after those along x.
    uint64_t vertical;
    // Separate plies.
    uint64_t plies;
} fk_grid;

// Contact sums (M8) since the start or reset, host's axes.
typedef struct fk_contact {
    // Impulse on the projectile, N s. A mean force is a difference of two divided by the time between.
    double impulse[3];
    // Angular impulse on the projectile about its moving centre of mass, N m s.
    double angular_impulse[3];
    // Work of the projectile on the fabric = energy absorbed, J.
    double work;
    // Kinetic energy lost in impacts of nodes, part of the work, J.
    double loss;
    // Largest mean force over a window of `force_window`, N; until the first window is full the mean force
    // over the time elapsed.
    double force_peak;
} fk_contact;

// Impulses of the sheet and of a free projectile on the supports since the start or reset, N s, host's axes.
typedef struct fk_support {
    // All together.
    double total[3];
    // Sides: left (-x), right, bottom (-y), top. Corners: (-,-), (+,-), (-,+), (+,+).
    double attachments[4][3];
    // The case of a ring.
    double casing[3];
    // Mean force on each attachment over the last window of `force_window`, N; 0 before, and without
    // slipping clamps.
    double force[4];
    // Time at which each attachment let go, s; 0: it has not.
    double let_go[4];
} fk_support;

// Energies (M15), J.
typedef struct fk_energy {
    // Kinetic energy of the projectile, translation and rotation, J; 0 if its mass is unknown.
    double projectile_kinetic;
    // Kinetic energy of the fabric, J.
    double fabric_kinetic;
    // Strain energy of the yarns, J.
    double strain;
    // Energy dissipated by rupture, J.
    double dissipated;
    // Kinetic energy lost in impacts of nodes on the projectile, J.
    double contact_loss;
    // Work of the projectile on the fabric: the energy absorbed, J.
    double contact_work;
    // Work of the external load on the projectile, J.
    double external_work;
    // Residual of the energy balance, J; in a sound run below 1 % of the kinetic energy at impact.
    double residual;
    // Energy that the viscosity of the yarn and its dependence on the rate of strain have dissipated, J.
    double viscous;
    // Energy dissipated by friction between yarn and projectile, J.
    double friction;
    // Kinetic energy lost where separate plies meet, J.
    double ply_loss;
    // Work of the projectile on fixed nodes, J: the part of `contact_work` that the fabric did not get. It
    // is dissipated, and part of `contact_loss` and `friction`.
    double support_work;
    // Kinetic energy lost where nodes of a ring meet its case, J.
    double casing_loss;
    // Energy dissipated in clamps in which held nodes have slid, J.
    double attachment;
    // Energy from nothing, J: by how much what contact impulses dissipate together would have fallen, over
    // all steps. Part of `residual`; in a sound run below 1e-3 of the kinetic energy at impact.
    double gained;
} fk_energy;

// Failed segments and energies of one ply of a stack.
typedef struct fk_ply {
    // Segments with alpha = 0 (M5) in the forces of the last step.
    uint64_t failed_segments;
    // Kinetic energy, J.
    double kinetic;
    // Strain energy, J.
    double strain;
    // Energy dissipated by rupture, J.
    double dissipated;
} fk_ply;

// Crossings that would slip. Of three numbers each counts within 5 and within 10 spacings of the projectile
// along the sheet, and in the whole sheet.
typedef struct fk_slip {
    // Crossings that are not held by a support.
    uint64_t crossings[3];
    // Crossings at which pinning takes more than friction and adhesion give.
    uint64_t slipping[3];
    // Largest force in the plane that pinning takes at a crossing, N.
    double largest;
} fk_slip;

// Extremes of the fabric at the present time.
typedef struct fk_fabric {
    // Largest distance from the sheet's plane, or from its circle, of a node that live segments join to a
    // support, m; 0 once all of the sheet has torn off. Of all nodes if the sheet is free, or if segments
    // have failed and `track_detachment` is off.
    double max_deflection;
    // Largest stretch (M1) of a live segment; yarns of the presets fail at about 1.05.
    double max_stretch;
} fk_fabric;

// Counters and high-water marks. Available even after a failure.
typedef struct fk_counters {
    // Steps taken since the start or reset.
    uint64_t steps;
    // Segments with alpha = 0 (M5) in the forces of the last step.
    uint64_t failed_segments;
    // Nodes with a contact impulse in the last step.
    uint64_t contacts;
    // Contact solves (M8) that were given up; harmless below 1 % of the steps. `contact_residual` says how
    // far they were off.
    uint64_t unconverged;
    // Most Gauss-Seidel sweeps of one solve, at most 300 (4000 in a stack whose held nodes are hit): sweeps
    // and, after 200 of them, passes of Newton's method.
    uint64_t most_sweeps;
    // Most candidate nodes of one step.
    uint64_t most_candidates;
    // Places for candidate nodes: `contact_capacity`, or every node modelled.
    uint64_t candidate_capacity;
    // Deepest penetration met, m: rounding where the body does not turn, up to 4e-2 spacings where it does;
    // also that of fixed nodes in a prescribed body, which passes through them.
    double worst_penetration;
    // Iterations of the theta rule so far = passes over the yarns' forces; 0 with velocity Verlet.
    uint64_t iterations;
    // Most iterations of one step.
    uint64_t most_iterations;
    // Deepest that facing nodes of two separate plies have been through each other, m: rounding before the
    // first hole.
    double ply_penetration;
    // Steps in which the body met the sheet beyond the fine part of a graded network, where nodes may be
    // too far apart to feel it: 0 in a run that is to be trusted.
    uint64_t beyond_fine;
    // Greatest speed by which a contact has failed its law in a solve that was given up, m/s: a gap that
    // closes too fast, a slip that friction should have stopped; 0 if all converged.
    double contact_residual;
} fk_counters;

// Outcomes; FK_NEVER for what has not happened.
typedef struct fk_outcome {
    // FK_STATUS_FLIGHT or FK_STATUS_CONTACT: what is true now, whatever has latched.
    uint32_t status;
    // FK_ARRESTED | FK_DETACHED | ...: the bits of all latched outcomes.
    uint32_t mask;
    // Step count at whose start the first impulse acted; FK_NEVER before.
    uint64_t first_contact;
    // Step count at which arrested, detached, exited, passed, through, rebounded, attachment_failed latched, in this order; FK_NEVER before.
    uint64_t step[7];
    // Work of the projectile on the fabric until then, J; 0 before.
    double work[7];
} fk_outcome;

// Contents of a capsule.
typedef struct fk_capsule {
    // Calls.
    uint64_t calls;
    // Steps of all calls together.
    uint64_t steps;
    // Calls from one digest to the next.
    uint64_t stride;
    // Numbers that fk_replay needs room for.
    uint64_t room;
    // 1 if its program ended it, else 0.
    uint64_t ended;
    // Byte at which it is broken; 0 if it is not.
    uint64_t broken_at;
    // Bytes that are whole.
    uint64_t whole;
} fk_capsule;

// How far a replay is. All zeros: at the beginning.
typedef struct fk_replay_place {
    // Bytes of records done.
    uint64_t done;
    // Steps of the present call that were taken; its other ones are still to be taken.
    uint64_t within;
    // Calls done, the present one counted.
    uint64_t calls;
    // Steps taken, of all calls together.
    uint64_t steps;
    // Digests found equal.
    uint64_t digests;
    // Calls done where a digest was last found equal.
    uint64_t equal_calls;
    // Step count where a digest was last found equal.
    uint64_t equal_step;
} fk_replay_place;

// How far a replay is, and what it found.
typedef struct fk_replayed {
    // How far it is; all zeros at the beginning.
    struct fk_replay_place at;
    // FK_REPLAY_GOES_ON, or how it ended.
    uint64_t end;
    // Number in the capsule, where the two differ.
    uint64_t written;
    // Number found, where the two differ.
    uint64_t found;
} fk_replayed;

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

// Fills `scene` with a preset (FK_PRESET_...). `struct_size` is sizeof(fk_scene) as the caller was compiled, and becomes the
// scene's first word. fk_scene_default and fk_scene_preset below call it.
// Threads: any, each with its own scene. Time: constant. Touches: `scene`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_UNKNOWN_CHOICE.
int32_t fk_scene_fill(fk_scene *scene,
                      uint64_t struct_size,
                      uint32_t preset);

// Makes the sheet of `scene` that of a textile's data sheet: sheet.spacing, spacing_y, node_mass, yarn_area, yarn_area_y and crimp,
// the yarn law, without one of the weft's own, and the viscosity 0.06, 1.5, 0.06, which the theta rule does not take; all else
// stays (docs/model.md, "From a textile to a scene").
// `textile_size` is sizeof(fk_textile). `fault` may be null; on an error it receives the number, the first bad field, e.g.
// "textile.warp.count", its value and the limit. `fault_size` is its sizeof.
// Threads: any, each with its own scene. Time: constant. Touches: `scene`; on an error only `fault`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_UNKNOWN_CHOICE (of the scene); of the textile FK_NOT_FINITE,
// FK_NOT_POSITIVE, FK_OUT_OF_RANGE, FK_DAMAGE_RATE_TOO_SMALL.
int32_t fk_scene_set_textile(fk_scene *scene,
                             const struct fk_textile *textile,
                             uint64_t textile_size,
                             struct fk_fault *fault,
                             uint64_t fault_size);

// Makes the group `back` of `scene`, but for back.plies, the fabric of a textile's data sheet in the scene's own grid of nodes, and
// yarn.viscosity_quadratic that of the textile of the two that takes less; all else stays (docs/model.md, "Two fabrics").
// Sizes, fault, threads, time and errors: as for fk_scene_set_textile. Touches: `scene`; on an error only `fault`.
int32_t fk_scene_set_back_textile(fk_scene *scene,
                                  const struct fk_textile *textile,
                                  uint64_t textile_size,
                                  struct fk_fault *fault,
                                  uint64_t fault_size);

// Chooses a graded network, sheet.grading, for a hit as the projectile of `scene` starts, with absorbed energy and residual velocity
// expected to be wrong by at most `error`, a part of them in [0.005, 0.1]; all else stays (docs/model.md, "Graded networks"). `fault`
// may be null; on an error it receives the number, the first bad field, its value and the limit. `fault_size` is its sizeof.
// Threads: any, each with its own scene. Time: constant. Touches: `scene`; on an error only `fault`.
// Errors: FK_OUT_OF_RANGE and FK_NOT_FINITE of `error`, and those of fk_scene_check.
int32_t fk_scene_set_grading(fk_scene *scene,
                             double error,
                             struct fk_fault *fault,
                             uint64_t fault_size);

// Refuses what fk_init refuses of a scene, whatever block it is given, in some milliseconds for any scene. The answer is that of fk_init,
// unless more than 8192 segments are drawn or nodes lie under the projectile: only so many are looked at then, evenly spread, and what
// another one alone forbids is found by fk_init. `fault` may be null; on an error it receives the number, the first bad field, its
// value and the limit. `fault_size` is its sizeof.
// Threads: any. Time: at most milliseconds. Touches: `fault`, on an error.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE; of the scene, each where a field of it says so or the
// constant's text does: FK_NOT_FINITE, FK_NOT_POSITIVE, FK_OUT_OF_RANGE, FK_UNKNOWN_CHOICE, FK_BAD_QUATERNION,
// FK_TOO_MANY_NODES, FK_STEP_TOO_LARGE, FK_STEP_LIMIT_UNUSABLE, FK_DAMAGE_RATE_TOO_SMALL, FK_PROJECTILE_TOO_LIGHT,
// FK_PROJECTILE_TOO_SMALL, FK_DISCS_OVERLAP, FK_DISC_TOUCHES_PROJECTILE, FK_BAD_NORMAL, FK_UNBOUNDED_FACES,
// FK_IMPOSSIBLE_MOMENTS, FK_NOT_SYMMETRIC, FK_NOT_BUILT, FK_HOLDS_NOTHING, FK_NOT_IN_EQUILIBRIUM, FK_DOES_NOT_GO_WITH,
// FK_INITIAL_OVERLAP, FK_PROJECTILE_TOO_FAST.
int32_t fk_scene_check(const fk_scene *scene,
                       struct fk_fault *fault,
                       uint64_t fault_size);

// Bytes of the block that fk_init needs for a scene, wherever it starts. They depend on the nodes, the projectile's
// size and the options, not on material or motion; they may differ between versions of the library.
// Threads: any. Time: constant. Touches: `bytes`, not on an error.
// Errors: those of fk_scene_check but for the time step and the projectile's start.
int32_t fk_memory_size(const fk_scene *scene, uint64_t *bytes);

// Makes a simulation of `scene` at step 0 in the caller's block, which may start anywhere, and hands back its handle in
// `out`: sheet flat and at rest, projectile in its start motion. The scene is copied; the block's old content does not
// matter. The block must not be moved or copied while the handle is used (use fk_state_save and fk_state_load); simply
// let go of it when done.
// Threads: any, each with its own block. Time: draws every segment of a stochastic sheet (some 0.1 us each), and a pass over the
// block. Touches: the block and `out`; on an error only `fault`, which may be null.
// Errors: those of fk_scene_check, FK_SHORT_BUFFER.
int32_t fk_init(void *memory,
                uint64_t bytes,
                const fk_scene *scene,
                struct fk_sim **out,
                struct fk_fault *fault,
                uint64_t fault_size);

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

// Moves a prescribed body along `path` (M13), of `path_size` = sizeof(fk_path), for `steps` steps. Call again with the
// same path to go on along it; the bits do not depend on how a path is split. Without a path the body coasts.
// Threads: changes. Time: `steps` steps. Touches: the block.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, FK_WRONG_DRIVE (the scene's drive is
// FK_DRIVE_FREE), FK_BAD_PATH, FK_NOT_FINITE, FK_BAD_QUATERNION, FK_PROJECTILE_TOO_FAST, FK_OUT_OF_RANGE; failures as
// fk_step.
int32_t fk_follow(struct fk_sim *sim, const struct fk_path *path, uint64_t path_size, uint64_t steps);

// Bytes of scratch that fk_bands_begin needs for `of` bands, wherever it starts.
// Errors: FK_NULL_POINTER, FK_OUT_OF_RANGE (`of` is not 1 to FK_MAX_BANDS), FK_NOT_IN_BANDS, FK_TOO_MANY_NODES (more memory than
// there can be), FK_MOVED_BLOCK, a latched failure.
int32_t fk_bands_size(const struct fk_sim *sim,
                      uint32_t of,
                      uint64_t *bytes);

// Cuts the sheet into `of` bands of rows, to be stepped by as many threads of the host's. From here to fk_bands_end the
// bands have the simulation: every call but fk_bands_pass and fk_bands_progress is refused with FK_BAND_OUT_OF_TURN.
// `scratch` must not be moved or used by anything else until then.
// `steps`: how many steps will be taken at least until fk_bands_end; a sheet that is too large for the caches takes eight of these
// in one block of nine passes. 0 if it is not known. If fewer are taken, fk_bands_end completes the block: up to eight steps more.
// Errors: FK_NULL_POINTER, FK_SHORT_BUFFER, FK_OUT_OF_RANGE, FK_NOT_IN_BANDS, FK_TOO_MANY_NODES, FK_BAND_OUT_OF_TURN (bands are in
// use), FK_MOVED_BLOCK, a latched failure.
int32_t fk_bands_begin(struct fk_sim *sim,
                       uint32_t of,
                       uint64_t steps,
                       void *scratch,
                       uint64_t bytes);

// One band's part of a pass: a pass is a step; a block of eight steps takes nine. To be called for every band once a pass, in any order, from any threads, at the same time. Nothing waits in here: the
// last band to be done completes the pass for all. `last` (may be null) receives 1 in that call, else 0. The host must wait for the pass to be complete before it
// calls the same band again: until then it is refused. The bits are those of fk_step.
// Errors: FK_OUT_OF_RANGE (no such band), FK_BAND_OUT_OF_TURN (called already in this pass, or no fk_bands_begin): nothing
// changed. FK_NULL_POINTER, FK_MOVED_BLOCK. A failure as fk_step: to the last band, and to every band in later passes.
int32_t fk_bands_pass(const struct fk_sim *sim,
                      uint32_t band,
                      uint32_t *last);

// How far the bands have come since fk_bands_begin: passes completed (a failed one included), steps completed, outcomes
// latched (FK_ARRESTED | ...). Any pointer may be null. Any thread may read them between fk_bands_begin and fk_bands_end, also while
// others are in fk_bands_pass; the end drops what this reads. In a block `steps` grows by eight at its end. When `passes` has grown, the next pass may begin; while a
// thread's own band has not been called, none of the three changes.
// Errors: FK_NULL_POINTER (sim), FK_BAND_OUT_OF_TURN (no fk_bands_begin), FK_MOVED_BLOCK.
int32_t fk_bands_progress(const struct fk_sim *sim,
                          uint64_t *passes,
                          uint64_t *steps,
                          uint32_t *outcomes);

// Gives the simulation back to the other calls, once no thread is in a call of the bands any more. A step that only some
// bands have taken, or a block that is begun, is completed. Returns the failure of the last pass, if there was one.
// Errors: FK_NULL_POINTER, FK_BAND_OUT_OF_TURN (no fk_bands_begin), FK_MOVED_BLOCK; failures as fk_step.
int32_t fk_bands_end(struct fk_sim *sim);

// Step count, and time = steps times dt, s. Either pointer may be null.
// Threads: reads. Time: constant. Touches: `steps`, `seconds`.
// Errors: FK_NULL_POINTER (sim), FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_time(const struct fk_sim *sim, uint64_t *steps, double *seconds);

// The time step and its limits (M11).
// Threads: reads. Time: constant. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_step_limits(const struct fk_sim *sim, struct fk_step_limits *out, uint64_t size);

// Modelled part of the sheet: the lengths of the arrays below.
// Threads: reads. Time: constant. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_grid(const struct fk_sim *sim, struct fk_grid *out, uint64_t size);

// The projectile: pose at the present time, rates of the half step before it (M7).
// Threads: reads. Time: constant. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_projectile(const struct fk_sim *sim, struct fk_motion *out, uint64_t size);

// Sets the force, N, and torque about the centre of mass, N m (3 numbers each, host's axes), that act on a free body
// from now on, in every step until they are set anew. At the start both are 0.
// Threads: changes. Time: constant. Touches: the block.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_NOT_FINITE, FK_WRONG_DRIVE (the scene's drive is FK_DRIVE_PRESCRIBED),
// FK_NOT_SYMMETRIC, FK_MOVED_BLOCK, a latched failure.
int32_t fk_set_external_load(struct fk_sim *sim, const double *force, const double *torque);

// Starts from given positions, m, and velocities, m/s, at time 0: `n` = 3 plies nodes_x nodes_y (fk_get_grid) numbers each,
// node by node, rows along x first, host's frame. For restarts from another code and sheets that start stretched.
// Fixed nodes stay where this puts them; their velocity must be 0. Only before the first step, and after
// fk_set_largest_stretch.
// Threads: changes. Time: two passes over the sheet. Touches: the block.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_WRONG_LENGTH, FK_NOT_FINITE, FK_OUT_OF_RANGE (a fixed node that
// moves; a position beyond 1e30 spacings, a velocity beyond 1e30 spacings a step), FK_INITIAL_OVERLAP,
// FK_PLIES_OVERLAP, FK_NOT_SYMMETRIC, FK_ALREADY_STARTED, FK_MOVED_BLOCK, a latched failure.
int32_t fk_set_motion(struct fk_sim *sim,
                      const double *positions,
                      const double *velocities,
                      uint64_t n);

// Gives every segment the largest stretch it has ever had, U_max of M5: a pre-damaged sheet. `n` = horizontal +
// vertical (fk_get_grid) numbers, horizontal ones first, row by row, in [0, 1e100]; up to the critical stretch means
// whole. Only before the first step.
// Threads: changes. Time: two passes over the sheet. Touches: the block.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_WRONG_LENGTH, FK_NOT_FINITE, FK_OUT_OF_RANGE, FK_ALREADY_STARTED,
// FK_MOVED_BLOCK, a latched failure.
int32_t fk_set_largest_stretch(struct fk_sim *sim, const double *stretches, uint64_t n);

// Contact sums (M8).
// Threads: reads. Time: constant. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_contact(const struct fk_sim *sim, struct fk_contact *out, uint64_t size);

// Impulses on the supports; zero without track_support.
// Threads: reads. Time: constant. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_support(const struct fk_sim *sim, struct fk_support *out, uint64_t size);

// The energies (M15).
// Threads: reads. Time: a pass over the sheet, with exp for damaged segments. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_energy(const struct fk_sim *sim, struct fk_energy *out, uint64_t size);

// Failed segments and energies of one ply, 0 to scene.stack.plies - 1; of a single sheet ply 0 is all.
// Threads: reads. Time: a pass over the ply, with exp for damaged segments. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_OUT_OF_RANGE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_ply(const struct fk_sim *sim, uint32_t ply, struct fk_ply *out, uint64_t size);

// At how many crossings yarns would slip, which the network pins. `thickness` of the ply, m, > 0; `friction` between yarns, >= 0; `adhesion`, the force
// at a crossing without pressure, N, >= 0. Not of curved sheets.
// Threads: reads. Time: a pass over the sheet, with exp for damaged segments. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_NOT_FINITE, FK_NOT_POSITIVE, FK_OUT_OF_RANGE, FK_DOES_NOT_GO_WITH, FK_NOT_BUILT,
// FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_slip(const struct fk_sim *sim,
                    double thickness,
                    double friction,
                    double adhesion,
                    struct fk_slip *out,
                    uint64_t size);

// Linear momentum, N s, that the balance of projectile, fabric, supports and external load does not close by: three
// numbers, host's axes. Rounding in a sound run. Needs track_support.
// Threads: reads. Time: a pass over the sheet. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_momentum_residual(const struct fk_sim *sim, double *out);

// Largest deflection and stretch (M1). What is still joined to a support is found in the simulation's scratch.
// Threads: changes, though no result. Time: a pass over the sheet. Touches: the block's scratch, `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_fabric(struct fk_sim *sim, struct fk_fabric *out, uint64_t size);

// Counters; also after a failure.
// Threads: reads. Time: constant. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK.
int32_t fk_get_counters(const struct fk_sim *sim, struct fk_counters *out, uint64_t size);

// Why the last call that changes this simulation (fk_step ... fk_set_motion, fk_state_load) was refused or failed;
// status FK_OK and empty texts if none was since fk_init or fk_reset. Also after a failure.
// Threads: reads. Time: constant. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK.
int32_t fk_get_fault(const struct fk_sim *sim, struct fk_fault *out, uint64_t size);

// Outcomes latched so far: physics, not errors. Tested every 64 steps; they change nothing.
// Threads: reads. Time: constant. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_MOVED_BLOCK, a latched failure.
int32_t fk_get_outcome(const struct fk_sim *sim, struct fk_outcome *out, uint64_t size);

// Positions, m: `n` = 3 plies nodes_x nodes_y (fk_get_grid) numbers, node by node, rows along x first, host's frame.
// Threads: reads. Time: a pass over the sheet. Touches: `out`.
// Errors: FK_NULL_POINTER, FK_MISALIGNED, FK_WRONG_LENGTH, FK_MOVED_BLOCK, a latched failure.
int32_t fk_copy_positions(const struct fk_sim *sim, double *out, uint64_t n);

// Velocities at the present time, m/s: `n` and order as fk_copy_positions, host's axes.
// Threads: reads. Time: a pass over the sheet. Touches: `out`.
// Errors: as fk_copy_positions.
int32_t fk_copy_velocities(const struct fk_sim *sim, double *out, uint64_t n);

// alpha of every segment (M5; 1 whole, 0 failed): `n` = horizontal + vertical (fk_get_grid) numbers, horizontal ones
// first, row by row, then the vertical ones.
// Threads: reads. Time: a pass over the sheet. Touches: `out`.
// Errors: as fk_copy_positions.
int32_t fk_copy_damage(const struct fk_sim *sim, double *out, uint64_t n);

// Stretch of every segment (M1), failed ones too: `n` and order as fk_copy_damage.
// Threads: reads. Time: a pass over the sheet. Touches: `out`.
// Errors: as fk_copy_positions.
int32_t fk_copy_stretch(const struct fk_sim *sim, double *out, uint64_t n);

// Bytes of a snapshot image; constant for a simulation.
// Threads: reads. Time: constant. Touches: `bytes`.
// Errors: FK_NULL_POINTER, FK_MOVED_BLOCK, a latched failure.
int32_t fk_state_size(const struct fk_sim *sim, uint64_t *bytes);

// Writes the state into `image`, at least fk_state_size bytes long (`bytes` is its length): with a checksum, and
// portable between machines that run the same version of the library.
// Threads: reads. Time: a pass over the sheet. Touches: `image`.
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
// Threads: reads. Time: a pass over the sheet. Touches: `digest`.
// Errors: FK_NULL_POINTER, FK_MOVED_BLOCK, a latched failure.
int32_t fk_digest(const struct fk_sim *sim, uint64_t *digest);

// Puts the simulation back to step 0, and writes every call that changes it from there on into `memory`: a capsule, which fk_replay,
// `fabric replay` and the page do again and compare. A capsule that was being written is dropped. `memory` must not be used by anything
// else until fk_capsule_end. `stride`: calls from one digest of the state to the next, at least 1; a digest takes about as long as a step,
// and a replay can say no closer than that where the first difference is.
// Threads: changes. Time: two passes over the sheet. Touches: the block and `memory`.
// Errors: FK_NULL_POINTER, FK_WRONG_LENGTH (`bytes` is more than memory can have), FK_MOVED_BLOCK.
int32_t fk_capsule_begin(struct fk_sim *sim,
                         void *memory,
                         uint64_t bytes,
                         uint64_t stride);

// Hands over what has been written since fk_capsule_begin or the last call of this: `used` bytes at the start of the memory, to be kept
// after those before; the next call writes to the start again. A call of the host's takes some 30 bytes, a digest 21, fk_set_motion and
// fk_state_load what they are given.
// Threads: changes. Time: constant. Touches: the block and `used`.
// Errors: FK_SHORT_BUFFER (the memory was full: the last record may be cut off, and nothing more is written), FK_NULL_POINTER, FK_BAD_CAPSULE
// (none is being written), FK_MOVED_BLOCK.
int32_t fk_capsule_take(struct fk_sim *sim,
                        uint64_t *used);

// Ends a capsule with a digest, and hands over the rest of it as fk_capsule_take does. After a failure, too.
// Threads: changes. Time: a pass over the sheet. Touches: the block, `used` and the memory, which is the host's again.
// Errors: those of fk_capsule_take.
int32_t fk_capsule_end(struct fk_sim *sim, uint64_t *used);

// Reads a capsule of `bytes` bytes through: its scene, for fk_init, and what is in it. Nothing of the scene is checked but that it is one.
// Threads: any. Time: a pass over the bytes. Touches: `scene`, of `struct_size` bytes, and `about`; nothing on an error but `about`,
// whose `broken_at` and `whole` say where the capsule is broken and how many bytes before that can be read as a capsule.
// Errors: FK_BAD_CAPSULE (none, cut off, altered, or of another format), FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_WRONG_LENGTH.
int32_t fk_capsule_read(const uint8_t *capsule,
                        uint64_t bytes,
                        fk_scene *scene,
                        uint64_t struct_size,
                        struct fk_capsule *about,
                        uint64_t size);

// Does a part of a capsule again, at most `steps` steps, on a simulation of its scene, and compares: with a `replay` of zeros from the
// beginning, with that of the call before from there on. `room`: as many numbers as fk_capsule_read says, for arrays of calls; null if 0.
// Threads: changes. Time: `steps` steps, and a pass over the bytes. Touches: the block, `room`, `replay`. It needs 5 kB of stack.
// Errors: FK_BAD_CAPSULE, FK_NULL_POINTER, FK_MISALIGNED, FK_STRUCT_SIZE, FK_WRONG_LENGTH, FK_MOVED_BLOCK. A difference is none: it is
// said by `replay`.
int32_t fk_replay(struct fk_sim *sim,
                  const uint8_t *capsule,
                  uint64_t bytes,
                  uint64_t steps,
                  double *room,
                  uint64_t n,
                  struct fk_replayed *replay,
                  uint64_t size);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

// A scene with a preset's values (FK_PRESET_...). If the library does not know the preset, or is older than
// this header and knows only shorter scenes, struct_size is 0: every call then refuses the scene with
// FK_STRUCT_SIZE.
static inline fk_scene fk_scene_preset(uint32_t preset)
{
    fk_scene scene;
    scene.struct_size = 0;
    fk_scene_fill(&scene, sizeof scene, preset);
    return scene;
}

// A scene with the default values, which are those of the 10 in preset.
static inline fk_scene fk_scene_default(void)
{
    return fk_scene_preset(FK_PRESET_SHEET_10IN_CYLINDER);
}

#endif  /* FABRIC_KERNEL_H */
