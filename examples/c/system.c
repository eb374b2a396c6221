/* A system model that flies its own fragment, a tumbling steel box, through the fabric: both meet every microsecond on a bus.
 *
 * Each bus step the host guesses where its fragment will be, with the force of the step before; the fabric follows that path
 * (fk_follow) and answers with the impulse it gave; the host then moves its fragment by that impulse. So momentum is exchanged
 * exactly, and the work only as well as the guess: the error falls with the bus step. Prints CSV; exit code 1 if a call is
 * refused or fails, 2 if the energies of host and fabric differ. */
#include <fabric_kernel.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double BUS_STEP = 1e-6;     /* s */
static const uint64_t STEPS_A_BUS_STEP = 50; /* of 2e-8 s in the fabric */

/* The host's rigid body: angular momentum in the host's axes, so that an angular impulse is simply added. */
typedef struct fragment {
    double mass, moments[3];
    double position[3], velocity[3], orientation[4], angular_momentum[3];
} fragment;

/* Body axes to host's axes. */
static void turn(const double q[4], const double v[3], double out[3])
{
    const double t[3] = {2 * (q[2] * v[2] - q[3] * v[1]), 2 * (q[3] * v[0] - q[1] * v[2]), 2 * (q[1] * v[1] - q[2] * v[0])};
    out[0] = v[0] + q[0] * t[0] + q[2] * t[2] - q[3] * t[1];
    out[1] = v[1] + q[0] * t[1] + q[3] * t[0] - q[1] * t[2];
    out[2] = v[2] + q[0] * t[2] + q[1] * t[1] - q[2] * t[0];
}

/* Angular velocity, rad/s, host's axes: R I^-1 R^T L. */
static void spin(const fragment *f, const double q[4], double w[3])
{
    const double back[4] = {q[0], -q[1], -q[2], -q[3]};
    double body[3];
    int k;
    turn(back, f->angular_momentum, body);
    for (k = 0; k < 3; k++)
        body[k] /= f->moments[k];
    turn(q, body, w);
}

/* out = q + h/2 w q, of unit length. */
static void rotate(const double q[4], const double w[3], double h, double out[4])
{
    double next[4], length;
    int k;
    next[0] = q[0] - 0.5 * h * (w[0] * q[1] + w[1] * q[2] + w[2] * q[3]);
    next[1] = q[1] + 0.5 * h * (w[0] * q[0] + w[1] * q[3] - w[2] * q[2]);
    next[2] = q[2] + 0.5 * h * (w[1] * q[0] + w[2] * q[1] - w[0] * q[3]);
    next[3] = q[3] + 0.5 * h * (w[2] * q[0] + w[0] * q[2] - w[1] * q[1]);
    length = sqrt(next[0] * next[0] + next[1] * next[1] + next[2] * next[2] + next[3] * next[3]);
    for (k = 0; k < 4; k++)
        out[k] = next[k] / length;
}

/* One bus step under the impulses that the fabric gives it. They act at the start of each of the fabric's steps, half of such a
 * step earlier than spread evenly: hence the `inner` in the position (docs/model.md, "Prescribed projectile"). */
static void fly(fragment *f, const double impulse[3], const double angular_impulse[3], double h, double inner)
{
    double w[3], middle[4];
    int k;
    for (k = 0; k < 3; k++) {
        f->position[k] += f->velocity[k] * h + 0.5 * impulse[k] / f->mass * (h + inner);
        f->velocity[k] += impulse[k] / f->mass;
        f->angular_momentum[k] += 0.5 * angular_impulse[k];
    }
    spin(f, f->orientation, w);
    rotate(f->orientation, w, 0.5 * h, middle);
    spin(f, middle, w);
    rotate(f->orientation, w, h, f->orientation);
    for (k = 0; k < 3; k++)
        f->angular_momentum[k] += 0.5 * angular_impulse[k];
}

static double energy(const fragment *f)
{
    double w[3], sum = 0.0;
    int k;
    spin(f, f->orientation, w);
    for (k = 0; k < 3; k++)
        sum += 0.5 * f->mass * f->velocity[k] * f->velocity[k] + 0.5 * w[k] * f->angular_momentum[k];
    return sum;
}

/* Ends the program if a call was refused or failed. */
static void ask(int32_t status, const fk_sim *sim)
{
    fk_fault fault = {0};
    if (status == FK_OK)
        return;
    if (sim == NULL || fk_get_fault(sim, &fault, sizeof fault) != FK_OK || fault.status != status)
        strncpy(fault.text, fk_status_name(status), sizeof fault.text - 1);
    fprintf(stderr, "%s\n", fault.text);
    exit(1);
}

int main(void)
{
    fragment f = {.mass = 4e-3, .position = {0.0, 0.0, -8.2e-3}, .velocity = {0.0, 0.0, 150.0}, .orientation = {0.96, 0.28, 0.0, 0.0}};
    const double edges[3] = {8e-3, 8e-3, 10e-3}, rates[3] = {1500.0, 300.0, 0.0};
    double impulse[3] = {0}, angular[3] = {0}, before[2][3] = {{0}}, start, lost, body[3];
    fk_scene scene = fk_scene_preset(FK_PRESET_SHEET_3IN_SPHERE);
    fk_path path = {.steps = 50};
    fk_contact contact = {0};
    fk_outcome outcome = {0};
    fk_sim *sim = NULL;
    uint64_t bytes = 0;
    void *memory;
    int bus, k;

    /* Whose mass and motion are which: the host keeps them, the fabric sees a prescribed body of this shape. */
    scene.drive = FK_DRIVE_PRESCRIBED;
    scene.projectile.mass = 0.0; /* not known to the fabric */
    scene.projectile.shape = FK_SHAPE_BOX;
    memcpy(scene.projectile.size, edges, sizeof edges);
    scene.time_step.seconds = BUS_STEP / (double)STEPS_A_BUS_STEP;

    /* The moments of a box, and the angular momentum R I R^T w of its tumbling. */
    for (k = 0; k < 3; k++)
        f.moments[k] = f.mass * (edges[(k + 1) % 3] * edges[(k + 1) % 3] + edges[(k + 2) % 3] * edges[(k + 2) % 3]) / 12.0;
    for (k = 0; k < 3; k++)
        body[k] = f.moments[k] * rates[k]; /* rates about the body's axes */
    turn(f.orientation, body, f.angular_momentum);
    memcpy(scene.projectile.position, f.position, sizeof f.position);
    memcpy(scene.projectile.velocity, f.velocity, sizeof f.velocity);
    memcpy(scene.projectile.orientation, f.orientation, sizeof f.orientation);
    spin(&f, f.orientation, scene.projectile.angular_velocity);

    ask(fk_memory_size(&scene, &bytes), NULL);
    if ((memory = malloc(bytes)) == NULL)
        return 1;
    ask(fk_init(memory, bytes, &scene, &sim, NULL, 0), NULL);

    start = energy(&f);
    printf("us,velocity,force_N,absorbed_J,host_lost_J,outcomes\n");
    for (bus = 1; bus <= 400 && !(outcome.mask & FK_ENDS); bus++) {
        fragment guess = f;
        fly(&guess, impulse, angular, BUS_STEP, scene.time_step.seconds);
        memcpy(path.end.position, guess.position, sizeof guess.position);
        memcpy(path.end.velocity, guess.velocity, sizeof guess.velocity);
        memcpy(path.end.orientation, guess.orientation, sizeof guess.orientation);
        spin(&guess, guess.orientation, path.end.angular_velocity);
        ask(fk_follow(sim, &path, sizeof path, STEPS_A_BUS_STEP), sim);
        path.first += STEPS_A_BUS_STEP;

        ask(fk_get_contact(sim, &contact, sizeof contact), sim);
        for (k = 0; k < 3; k++) {
            impulse[k] = contact.impulse[k] - before[0][k];
            angular[k] = contact.angular_impulse[k] - before[1][k];
        }
        memcpy(before[0], contact.impulse, sizeof before[0]);
        memcpy(before[1], contact.angular_impulse, sizeof before[1]);
        fly(&f, impulse, angular, BUS_STEP, scene.time_step.seconds);
        ask(fk_get_outcome(sim, &outcome, sizeof outcome), sim);
        printf("%d,%.3f,%.1f,%.4f,%.4f,%u\n", bus, f.velocity[2], impulse[2] / BUS_STEP, contact.work, start - energy(&f),
               (unsigned)outcome.mask);
    }

    /* The fabric has what the host lost: momentum to rounding, energy as well as the bus step allows. */
    lost = start - energy(&f);
    if (fabs(f.mass * (f.velocity[2] - 150.0) - contact.impulse[2]) > 1e-12 || fabs(lost / contact.work - 1.0) > 0.01) {
        fprintf(stderr, "the host lost %.4f J, the fabric absorbed %.4f J\n", lost, contact.work);
        return 2;
    }
    free(memory);
    return 0;
}
