/* The rotorburst example as a host in C that links the kernel: what rotorburst.py does through the FMU, through fabric_kernel.h.

       cc -I../../include rotorburst.c fragment.c ../../target/ship/libfabric_kernel.a -lm -o rotorburst
       ./rotorburst --case ring --angle 15 --speed 100 > history.csv

   On each communication step the kernel goes first: it is led to where the fragment should be at the end of the step, at the
   acceleration of the last mean force. Then the fragment moves on under the mean force and torque that the sheet has given. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fabric_kernel.h"
#include "fragment.h"

#define PI 3.14159265358979323846

static const double NEAR_SHEET = 0.5e-3;    /* distance at which the sheet joins in, m */
static const double FLIGHT_STEP = 1e-4;     /* largest step of the host alone, s */
static const double NONE[3] = {0.0, 0.0, 0.0};

/* The cases of rotorburst.py: the preset that has the sheet, how it is held, and the fragment. */
typedef struct {
    const char *name;
    uint32_t preset;
    uint64_t attachment, shape;
    double radius, length;           /* of a sphere, whose length is 0, or of a cylinder, m */
    fk_scene_projectile_sector disc; /* of a sector */
    double mass, drag_coefficient;
    double tick; /* the kernel's time step, s */
} impact;

/* The ring is hit from inside. */
static const impact CASES[] = {
    {"ring", FK_PRESET_RING_40IN, FK_ATTACHMENT_FREE, FK_SHAPE_DISC_SECTOR, 0.0, 0.0,
     {0.015, 0.04, 2.0 * PI / 3.0, 0.01}, 0.118, 1.05, 1e-7},
    {"disc", FK_PRESET_SHEET_10IN_CYLINDER, FK_ATTACHMENT_FOUR_SIDES, FK_SHAPE_DISC_SECTOR, 0.0, 0.0,
     {0.015, 0.04, 2.0 * PI / 3.0, 0.01}, 0.118, 1.05, 2e-8},
    {"small", FK_PRESET_SHEET_3IN_SPHERE, FK_ATTACHMENT_FOUR_SIDES, FK_SHAPE_DISC_SECTOR, 0.0, 0.0,
     {0.0075, 0.02, 2.0 * PI / 3.0, 0.005}, 0.01475, 1.05, 2e-8},
    {"10in", FK_PRESET_SHEET_10IN_CYLINDER, FK_ATTACHMENT_TWO_SIDES, FK_SHAPE_CYLINDER, 6.35e-3, 38.1e-3,
     {0.0, 0.0, 0.0, 0.0}, 0.037, 0.9, 2e-8},
    {"3in", FK_PRESET_SHEET_3IN_SPHERE, FK_ATTACHMENT_FOUR_SIDES, FK_SHAPE_SPHERE, 6.35e-3, 0.0,
     {0.0, 0.0, 0.0, 0.0}, 0.0084, 0.47, 2e-8},
};

typedef struct {
    const impact *impact;
    double speed, standoff, spin, tilt, angle, step, limit;
} options;

static void stop(const char *what)
{
    fprintf(stderr, "rotorburst: %s\n", what);
    exit(1);
}

static options parsed(int count, char **words)
{
    options o = {&CASES[0], 100.0, 0.3, 300.0, 0.0, 0.0, 1e-6, 2e-3};
    const struct {
        const char *name;
        double *place;
    } numbers[] = {{"--speed", &o.speed}, {"--standoff", &o.standoff}, {"--spin", &o.spin},
                   {"--tilt", &o.tilt},   {"--angle", &o.angle},       {"--step", &o.step},
                   {"--limit", &o.limit}};
    for (int k = 1; k + 1 < count; k += 2) {
        size_t n = 0;
        if (strcmp(words[k], "--case") == 0) {
            while (n < sizeof CASES / sizeof *CASES && strcmp(words[k + 1], CASES[n].name) != 0) n++;
            if (n == sizeof CASES / sizeof *CASES) stop("--case ring|disc|small|10in|3in");
            o.impact = &CASES[n];
            continue;
        }
        while (n < sizeof numbers / sizeof *numbers && strcmp(words[k], numbers[n].name) != 0) n++;
        if (n == sizeof numbers / sizeof *numbers) stop("options: --case --speed --standoff --spin --tilt --angle --step --limit");
        *numbers[n].place = strtod(words[k + 1], NULL);
    }
    if (count % 2 == 0) stop("an option has no value");
    return o;
}

enum { CHORDS = 8, CORNERS = CHORDS + 3 };

/* Corners of a sector's cross-section, counter-clockwise about its centre of mass, m: eight chords are the rim, one is the bore. */
static void corners_of(const fk_scene_projectile_sector *disc, double corner[CORNERS][2])
{
    double area = 0.0, centre[2] = {0.0, 0.0};
    for (int k = 0; k < CORNERS; k++) {
        const double turn = (k == 0 ? 0.5 : k == 1 ? -0.5 : (k - 2) / (double)CHORDS - 0.5) * disc->angle;
        const double radius = k < 2 ? disc->inner_radius : disc->outer_radius;
        corner[k][0] = radius * cos(turn);
        corner[k][1] = radius * sin(turn);
    }
    for (int k = 0; k < CORNERS; k++) {
        const double *a = corner[k], *b = corner[(k + 1) % CORNERS], part = a[0] * b[1] - b[0] * a[1];
        area += part;
        for (int i = 0; i < 2; i++) centre[i] += (a[i] + b[i]) * part;
    }
    for (int k = 0; k < CORNERS; k++)
        for (int i = 0; i < 2; i++) corner[k][i] -= centre[i] / (3.0 * area);
}

static fragment_body body_of(const impact *it)
{
    const double square = it->radius * it->radius, across = it->mass * (3.0 * square + it->length * it->length) / 12.0;
    const double along = (it->length == 0.0 ? 0.4 : 0.5) * it->mass * square;
    fragment_body body = {it->mass, {across, across, along}, it->drag_coefficient, PI * square};
    if (it->shape == FK_SHAPE_SPHERE) body.moments[0] = body.moments[1] = along;
    if (it->shape == FK_SHAPE_DISC_SECTOR) {
        double corner[CORNERS][2], area = 0.0, second[2] = {0.0, 0.0};
        corners_of(&it->disc, corner);
        for (int k = 0; k < CORNERS; k++) {
            const double *a = corner[k], *b = corner[(k + 1) % CORNERS], part = a[0] * b[1] - b[0] * a[1];
            area += part;
            for (int i = 0; i < 2; i++) second[i] += (a[i] * a[i] + a[i] * b[i] + b[i] * b[i]) * part;
        }
        const double xx = second[0] / (6.0 * area), yy = second[1] / (6.0 * area), zz = it->disc.thickness * it->disc.thickness / 12.0;
        body.moments[0] = it->mass * (yy + zz);
        body.moments[1] = it->mass * (xx + zz);
        body.moments[2] = it->mass * (xx + yy);
        body.frontal_area = 2.0 * it->disc.outer_radius * sin(0.5 * it->disc.angle) * it->disc.thickness;
    }
    return body;
}

/* How far the front is ahead of the centre of mass along z, m. */
static double reach(const impact *it, const double orientation[4])
{
    double turn[3][3], corner[CORNERS][2], farthest = 0.0;
    fragment_rotation(orientation, turn);
    const double along = fmin(fabs(turn[2][2]), 1.0);
    if (it->shape == FK_SHAPE_SPHERE) return it->radius;
    if (it->shape == FK_SHAPE_CYLINDER) return 0.5 * it->length * along + it->radius * sqrt(1.0 - along * along);
    corners_of(&it->disc, corner);
    for (int k = 0; k < CORNERS; k++) farthest = fmax(farthest, turn[2][0] * corner[k][0] + turn[2][1] * corner[k][1]);
    return farthest + 0.5 * it->disc.thickness * along;
}

/* The radius of the ring, m, or 0 of a flat sheet. */
static double ring_of(const impact *it) { return fk_scene_preset(it->preset).sheet.radius; }

/* z of the foremost point, or how far the farthest corner from the axis is beyond the ring, m; and what it is not faster than, m/s. */
static double front(const impact *it, const fragment *f, double *closing)
{
    double turn[3][3], corner[CORNERS][2], rate[3], farthest = 0.0, around = 0.0;
    *closing = f->velocity[2];
    if (ring_of(it) == 0.0) return f->position[2] + reach(it, f->orientation);
    fragment_rotation(f->orientation, turn);
    fragment_angular_velocity(f, rate);
    corners_of(&it->disc, corner);
    for (int k = 0; k < CORNERS; k++) {
        const double x = f->position[0] + turn[0][0] * corner[k][0] + turn[0][1] * corner[k][1];
        const double z = f->position[2] + turn[2][0] * corner[k][0] + turn[2][1] * corner[k][1];
        farthest = fmax(farthest, hypot(x, z));
        around = fmax(around, hypot(corner[k][0], corner[k][1]));
    }
    *closing = sqrt(f->velocity[0] * f->velocity[0] + f->velocity[1] * f->velocity[1] + f->velocity[2] * f->velocity[2]) +
               sqrt(rate[0] * rate[0] + rate[1] * rate[1] + rate[2] * rate[2]) * around;
    return farthest - ring_of(it);
}

/* A sector that left its disc on the axis of the ring, its rim ahead, the stand-off before the ring: its spin is that of the disc, and its
   path leads off the plane of rotation, to the middle of the ring. */
static fragment burst(const options *o)
{
    const fragment_body body = body_of(o->impact);
    const double orientation[4] = {0.5, -0.5, -0.5, -0.5}, angle = o->angle * PI / 180.0;
    const double arm = o->impact->disc.outer_radius - reach(o->impact, orientation);
    const double position[3] = {-arm, -o->standoff * tan(angle), ring_of(o->impact)};
    const double velocity[3] = {0.0, o->speed * sin(angle), o->speed * cos(angle)}, rate[3] = {0.0, o->speed / arm, 0.0};
    fragment f = fragment_in_motion(&body, position, velocity, orientation, rate);
    double closing;
    f.position[2] -= o->standoff + front(o->impact, &f, &closing);
    return f;
}

/* The front at the stand-off; the axis along the flight, or a sector's rim ahead and its axis along y; then all tilted about x. */
static fragment launched(const options *o)
{
    if (ring_of(o->impact) != 0.0) return burst(o);
    const fragment_body body = body_of(o->impact);
    const double about_x[3] = {o->tilt * PI / 180.0, 0.0, 0.0}, rim_ahead[4] = {0.5, -0.5, -0.5, -0.5}, axis_ahead[4] = {1.0, 0.0, 0.0, 0.0};
    const double velocity[3] = {0.0, 0.0, o->speed};
    double orientation[4], turn[3][3], position[3] = {0.0, 0.0, 0.0}, rate[3];
    fragment_turned(about_x, o->impact->shape == FK_SHAPE_DISC_SECTOR ? rim_ahead : axis_ahead, orientation);
    position[2] = -o->standoff - reach(o->impact, orientation);
    fragment_rotation(orientation, turn);
    for (int k = 0; k < 3; k++) rate[k] = turn[k][2] * o->spin;
    return fragment_in_motion(&body, position, velocity, orientation, rate);
}

static fk_motion motion_of(const fragment *f)
{
    fk_motion motion = {0};
    memcpy(motion.position, f->position, sizeof motion.position);
    memcpy(motion.velocity, f->velocity, sizeof motion.velocity);
    memcpy(motion.orientation, f->orientation, sizeof motion.orientation);
    fragment_angular_velocity(f, motion.angular_velocity);
    return motion;
}

/* A motion carried on by h at constant acceleration and angular velocity. */
static fk_motion carried(const fk_motion *motion, const double acceleration[3], double h)
{
    fk_motion end = *motion;
    double turn[3];
    for (int k = 0; k < 3; k++) {
        end.position[k] += (motion->velocity[k] + 0.5 * acceleration[k] * h) * h;
        end.velocity[k] += acceleration[k] * h;
        turn[k] = motion->angular_velocity[k] * h;
    }
    fragment_turned(turn, motion->orientation, end.orientation);
    return end;
}

/* The sheet with the fragment where it is now. The memory is ours and lives as long as the program. */
static fk_sim *sheet(const options *o, const fragment *f)
{
    const fk_motion motion = motion_of(f);
    fk_scene scene = fk_scene_preset(o->impact->preset);
    fk_fault fault = {0};
    fk_sim *sim = NULL;
    uint64_t bytes = 0;
    scene.attachment.kind = o->impact->attachment;
    scene.projectile.shape = o->impact->shape;
    if (o->impact->shape == FK_SHAPE_DISC_SECTOR) scene.projectile.sector = o->impact->disc;
    scene.projectile.mass = o->impact->mass;
    scene.time_step.seconds = o->impact->tick;
    scene.drive = FK_DRIVE_PRESCRIBED;
    scene.seed = 1;
    memcpy(scene.projectile.position, motion.position, sizeof motion.position);
    memcpy(scene.projectile.velocity, motion.velocity, sizeof motion.velocity);
    memcpy(scene.projectile.orientation, motion.orientation, sizeof motion.orientation);
    memcpy(scene.projectile.angular_velocity, motion.angular_velocity, sizeof motion.angular_velocity);
    if (fk_memory_size(&scene, &bytes) != FK_OK) stop("the scene is refused");
    void *memory = malloc(bytes);
    if (memory == NULL) stop("out of memory");
    if (fk_init(memory, bytes, &scene, &sim, &fault, sizeof fault) != FK_OK) stop(fault.text);
    return sim;
}

static void print_row(double t, const fragment *f, const double force[3], double work, uint64_t failed)
{
    double rate[3];
    fragment_angular_velocity(f, rate);
    printf("%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%" PRIu64 "\n", t, f->position[0], f->position[1],
           f->position[2], f->velocity[0], f->velocity[1], f->velocity[2], rate[0], rate[1], rate[2], force[2], work, failed);
}

int main(int count, char **words)
{
    const options o = parsed(count, words);
    fragment f = launched(&o);
    double start = 0.0, own[3], force[3] = {0.0}, torque[3];
    fk_contact before = {0}, after = {0};
    fk_counters counters = {0};
    fk_outcome outcome = {0};

    double closing, ahead;
    while ((ahead = front(o.impact, &f, &closing)) < -NEAR_SHEET) {
        const double h = fmin(FLIGHT_STEP, (-NEAR_SHEET - ahead) / closing + 1e-7);
        if (f.velocity[2] <= 0.0) stop("the fragment never reaches the sheet");
        fragment_own_force(&f, own);
        fragment_step(&f, h, own, NONE, NONE, 0.0);
        start += h;
    }
    fk_sim *sim = sheet(&o, &f);
    const uint64_t ticks = (uint64_t)llround(o.step / o.impact->tick);
    printf("time,position[1],position[2],position[3],velocity[1],velocity[2],velocity[3],angular_velocity[1],angular_velocity[2],"
           "angular_velocity[3],contact.force_mean[3],contact.work,fabric.failed_segments\n");
    for (uint64_t k = 0; k < (uint64_t)llround(o.limit / o.step); k++) {
        const fk_motion now = motion_of(&f);
        double acceleration[3];
        fragment_own_force(&f, own);
        for (int i = 0; i < 3; i++) acceleration[i] = (force[i] + own[i]) / f.body.mass;
        const fk_path path = {.first = k * ticks, .steps = ticks, .end = carried(&now, acceleration, o.step)};
        if (fk_get_contact(sim, &before, sizeof before) != FK_OK || fk_follow(sim, &path, sizeof path, ticks) != FK_OK || fk_get_contact(sim, &after, sizeof after) != FK_OK) {
            fk_fault fault = {0};
            fk_get_fault(sim, &fault, sizeof fault);
            stop(fault.text);
        }
        for (int i = 0; i < 3; i++) {
            force[i] = (after.impulse[i] - before.impulse[i]) / o.step;
            torque[i] = (after.angular_impulse[i] - before.angular_impulse[i]) / o.step;
        }
        fragment_step(&f, o.step, own, force, torque, o.impact->tick);
        fk_get_counters(sim, &counters, sizeof counters);
        print_row(start + (double)(k + 1) * o.step, &f, force, after.work, counters.failed_segments);
        fk_get_outcome(sim, &outcome, sizeof outcome);
        if (outcome.mask & FK_ENDS) break;
    }
    return 0;
}
