/* The rotorburst example as a host in C that links the kernel: what rotorburst.py does through the FMU, through fabric_kernel.h.

       cc -I../../include rotorburst.c fragment.c ../../target/ship/libfabric_kernel.a -lm -o rotorburst
       ./rotorburst --case 3in --speed 100 > history.csv

   On each communication step the kernel goes first: it is led to where the fragment should be at the end of the step, at the
   acceleration of the last mean force. Then the fragment moves on under the mean force and torque that the sheet has given. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fabric_kernel.h"
#include "fragment.h"

static const double NEAR_SHEET = 0.5e-3;    /* distance at which the sheet joins in, m */
static const double FLIGHT_STEP = 1e-4;     /* largest step of the host alone, s */
static const double INTERNAL_STEP = 2e-8;   /* the kernel's time step, s */
static const double NONE[3] = {0.0, 0.0, 0.0};

typedef struct {
    int ten_inch;
    double speed, standoff, spin, tilt, step, limit;
} options;

static void stop(const char *what)
{
    fprintf(stderr, "rotorburst: %s\n", what);
    exit(1);
}

static options parsed(int count, char **words)
{
    options o = {1, 100.0, 0.3, 300.0, 0.0, 1e-6, 2e-3};
    const struct {
        const char *name;
        double *place;
    } numbers[] = {{"--speed", &o.speed}, {"--standoff", &o.standoff}, {"--spin", &o.spin},
                   {"--tilt", &o.tilt},   {"--step", &o.step},         {"--limit", &o.limit}};
    for (int k = 1; k + 1 < count; k += 2) {
        size_t n = 0;
        if (strcmp(words[k], "--case") == 0) {
            o.ten_inch = strcmp(words[k + 1], "10in") == 0;
            continue;
        }
        while (n < sizeof numbers / sizeof *numbers && strcmp(words[k], numbers[n].name) != 0) n++;
        if (n == sizeof numbers / sizeof *numbers) stop("options: --case 10in|3in --speed --standoff --spin --tilt --step --limit");
        *numbers[n].place = strtod(words[k + 1], NULL);
    }
    if (count % 2 == 0) stop("an option has no value");
    return o;
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
    fk_scene scene = fk_scene_preset(o->ten_inch ? FK_PRESET_SHEET_10IN_CYLINDER : FK_PRESET_SHEET_3IN_SPHERE);
    fk_fault fault = {0};
    fk_sim *sim = NULL;
    uint64_t bytes = 0;
    scene.attachment.kind = o->ten_inch ? FK_ATTACHMENT_TWO_SIDES : FK_ATTACHMENT_FOUR_SIDES;
    scene.time_step.seconds = INTERNAL_STEP;
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
    const fragment_body cylinder = {6.35e-3, 38.1e-3, 0.037, 0.9}, sphere = {6.35e-3, 0.0, 0.0084, 0.47};
    fragment f = fragment_launched(o.ten_inch ? &cylinder : &sphere, o.standoff, o.speed, o.spin, o.tilt * 3.14159265358979323846 / 180.0);
    double start = 0.0, own[3], force[3] = {0.0}, torque[3];
    fk_contact before = {0}, after = {0};
    fk_counters counters = {0};
    fk_outcome outcome = {0};

    while (fragment_front(&f) < -NEAR_SHEET) {
        const double h = fmin(FLIGHT_STEP, (-NEAR_SHEET - fragment_front(&f)) / f.velocity[2] + 1e-7);
        if (f.velocity[2] <= 0.0) stop("the fragment never reaches the sheet");
        fragment_own_force(&f, own);
        fragment_step(&f, h, own, NONE, NONE, 0.0);
        start += h;
    }
    fk_sim *sim = sheet(&o, &f);
    const uint64_t ticks = (uint64_t)llround(o.step / INTERNAL_STEP);
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
        fragment_step(&f, o.step, own, force, torque, INTERNAL_STEP);
        fk_get_counters(sim, &counters, sizeof counters);
        print_row(start + (double)(k + 1) * o.step, &f, force, after.work, counters.failed_segments);
        fk_get_outcome(sim, &outcome, sizeof outcome);
        if (outcome.mask & (FK_ARRESTED | FK_EXITED | FK_PASSED)) break;
    }
    return 0;
}
