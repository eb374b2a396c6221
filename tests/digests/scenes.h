/* The scenes of digests.c and of the C and C++ hosts: so small that a processor without floating-point hardware runs them all in seconds, and together
 * touching every shape, attachment, kind of yarn, integrator and drive. In each but `theta` segments fail. Literal numbers only: the
 * host's arithmetic has no part in them. */
#ifndef SCENES_H
#define SCENES_H

#include "fabric_kernel.h"

typedef struct test_scene {
    const char *name;
    void (*change)(fk_scene *); /* what differs from the 3 in preset */
    uint64_t steps;
} test_scene;

static void set3(double *to, double x, double y, double z)
{
    to[0] = x;
    to[1] = y;
    to[2] = z;
}

static void sheet(fk_scene *scene, uint32_t nodes_x, uint32_t nodes_y)
{
    scene->sheet.nodes_x = nodes_x;
    scene->sheet.nodes_y = nodes_y;
}

/* A light sphere, drawn yarn, four sides held. */
static void sphere(fk_scene *scene)
{
    sheet(scene, 17, 15);
    scene->projectile.radius = 2e-3;
    scene->projectile.mass = 3e-4;
    set3(scene->projectile.position, 3e-4, -2e-4, -2.01e-3);
    set3(scene->projectile.velocity, 20.0, -10.0, 400.0);
    set3(scene->projectile.angular_velocity, 900.0, 0.0, -300.0);
}

/* A cylinder that strikes with its rim and turns. */
static void askew(fk_scene *scene)
{
    sphere(scene);
    scene->projectile.shape = FK_SHAPE_CYLINDER;
    scene->projectile.radius = 1.5e-3;
    scene->projectile.length = 4e-3;
    scene->projectile.position[2] = -2.55e-3;
    scene->projectile.orientation[0] = 0.96;
    scene->projectile.orientation[1] = 0.28;
}

/* One draw per yarn; nodes and rotation by the theta rule. */
static void theta(fk_scene *scene)
{
    askew(scene);
    sheet(scene, 11, 12);
    scene->projectile.velocity[2] = 300.0;
    scene->yarn.draw = FK_DRAW_YARN;
    scene->integrator.kind = FK_INTEGRATOR_THETA;
    scene->integrator.theta = 0.5;
    scene->integrator.tolerance = 1e-9;
    scene->integrator.max_iterations = 300;
    scene->rotation_rule.kind = FK_ROTATION_THETA;
    scene->rotation_rule.theta = 0.5;
}

/* A hemispherical end, four corners held. */
static void bullet(fk_scene *scene)
{
    askew(scene);
    scene->projectile.shape = FK_SHAPE_HEMISPHERICAL_CYLINDER;
    scene->attachment.kind = FK_ATTACHMENT_FOUR_CORNERS;
    scene->attachment.disc_inset = 1.2e-3;
    scene->attachment.disc_radius = 1e-3;
    scene->seed = 0xfeed;
}

/* A box on a free sheet of three plies, which stands upright away from the origin: its normal is (0.96, 0, 0.28). */
static void box(fk_scene *scene)
{
    sphere(scene);
    scene->attachment.kind = FK_ATTACHMENT_FREE;
    scene->sheet.plies = 3;
    set3(scene->sheet.position, 0.5, -0.25, 2.0);
    scene->sheet.orientation[0] = 0.8;
    scene->sheet.orientation[2] = 0.6;
    scene->projectile.shape = FK_SHAPE_BOX;
    set3(scene->projectile.size, 2e-3, 3e-3, 4e-3);
    set3(scene->projectile.position, 0.497216, -0.2496, 1.999188);
    set3(scene->projectile.velocity, 864.0, 0.0, 252.0);
}

/* A quarter of a sheet of uniform yarn, two sides held, under the flat end of a cylinder. */
static void quarter(fk_scene *scene)
{
    sphere(scene);
    sheet(scene, 28, 27);
    scene->symmetry.mirror_x = 1;
    scene->symmetry.mirror_y = 1;
    scene->attachment.kind = FK_ATTACHMENT_TWO_SIDES;
    scene->yarn.stochastic = 0;
    scene->projectile.shape = FK_SHAPE_CYLINDER;
    scene->projectile.length = 4e-3;
    set3(scene->projectile.position, 0.0, 0.0, -2e-3);
    set3(scene->projectile.velocity, 0.0, 0.0, 400.0);
    set3(scene->projectile.angular_velocity, 0.0, 0.0, 0.0);
}

/* A wedge, edge first. */
static void wedge(fk_scene *scene)
{
    static const double faces[5][4] = {
        {0.0, 1.0, 0.0, 2e-3}, {0.0, -1.0, 0.0, 2e-3}, {0.6, 0.0, 0.8, 1e-3}, {-0.6, 0.0, 0.8, 1e-3}, {0.0, 0.0, -1.0, 1e-3},
    };
    int face, number;
    sphere(scene);
    scene->projectile.shape = FK_SHAPE_POLYHEDRON;
    scene->projectile.faces.count = 5;
    for (face = 0; face < 5; face++)
        for (number = 0; number < 4; number++)
            scene->projectile.faces.planes[face][number] = faces[face][number];
    set3(scene->projectile.moments, 5e-10, 4e-10, 6e-10);
    set3(scene->projectile.position, 0.0, 0.0, -1.3e-3);
}

/* The damage law with a true zero, energy that slack segments give back, the step in seconds, nothing watched. */
static void slack(fk_scene *scene)
{
    sphere(scene);
    scene->yarn.damage_b = 0.01;
    scene->yarn.damage_a = 1.01;
    scene->yarn.alpha_fail = 0.0;
    scene->slack_balance = 1;
    scene->time_step.seconds = 2e-8;
    scene->track_detachment = 0;
    scene->track_support = 0;
}

/* Friction between yarn and a sphere that spins. */
static void rubs(fk_scene *scene)
{
    sphere(scene);
    scene->contact.friction = 0.4;
}

/* A cylinder of unknown mass, moved by the host. */
static void prescribed(fk_scene *scene)
{
    askew(scene);
    scene->drive = FK_DRIVE_PRESCRIBED;
    scene->projectile.mass = 0.0;
}

/* A graded network of drawn yarn, fine beside its middle, with bars of up to four yarns. */
static void graded(fk_scene *scene)
{
    sphere(scene);
    sheet(scene, 33, 30);
    scene->sheet.grading.largest = 4;
    scene->sheet.grading.run = 1;
    scene->sheet.grading.centre[0] = 3e-4;
    scene->sheet.grading.centre[1] = -2e-4;
    scene->sheet.grading.half_width[0] = 4e-3;
    scene->sheet.grading.half_width[1] = 4.5e-3;
}

/* Three plies that touch, the second one turned, of a fabric with unlike directions. */
static void plies(fk_scene *scene)
{
    sphere(scene);
    scene->stack.plies = 3;
    scene->stack.gap = 2.5e-4;
    scene->stack.turned = 1;
    scene->sheet.yarn_area_y = 8e-8;
}

/* Unlike directions, taut along x and crimped along y, one draw per yarn. */
static void unlike(fk_scene *scene)
{
    sphere(scene);
    scene->sheet.spacing_y = 9e-4;
    scene->sheet.yarn_area_y = 9e-8;
    scene->sheet.pre_strain[0] = 0.002;
    scene->sheet.crimp[1] = 0.004;
    scene->weft.modulus_mean = 120e9;
    scene->weft.damage_intercept = 150.0;
    scene->weft.critical_stretch = 1.028;
    scene->yarn.draw = FK_DRAW_YARN;
}

/* Strength drawn for every segment, in part alike along a yarn. */
static void strength(fk_scene *scene)
{
    sphere(scene);
    scene->yarn.strength_draw = FK_STRENGTH_DRAW_WEIBULL;
    scene->yarn.weibull_shape = 9.0;
    scene->yarn.weibull_gauge_length = 0.05;
    scene->yarn.weibull_correlation = 0.25;
}

/* A sheet made from a data sheet: viscous, crimped, of drawn modulus and strength. */
static void textile(fk_scene *scene)
{
    static fk_textile kevlar;
    sphere(scene);
    kevlar.warp.linear_density = 6.7e-5;
    kevlar.warp.count = 1339.0;
    kevlar.warp.crimp = 0.011;
    kevlar.weft.linear_density = 6.7e-5;
    kevlar.weft.count = 1250.0;
    kevlar.weft.crimp = 0.003;
    kevlar.fibre_density = 1440.0;
    kevlar.modulus = 84.62e9;
    kevlar.modulus_sd = 1e9;
    kevlar.failure_strain = 0.0355;
    kevlar.damage_rate = 2300.0;
    kevlar.weibull_shape = 14.7;
    kevlar.gauge_length = 0.05;
    kevlar.thickness = 2e-4;
    scene->projectile.position[2] -= 1e-4;
    /* A textile that is refused leaves the preset's sheet, which has another digest. */
    (void)fk_scene_set_textile(scene, &kevlar, sizeof kevlar, 0, 0);
}

enum { TEST_SCENES = 14 };

static const test_scene test_scenes[TEST_SCENES] = {
    {"sphere", sphere, 400},   {"theta", theta, 150}, {"bullet", bullet, 400}, {"box", box, 300},
    {"quarter", quarter, 400}, {"wedge", wedge, 400}, {"slack", slack, 400},       {"prescribed", prescribed, 300},
    {"unlike", unlike, 400},   {"strength", strength, 400}, {"textile", textile, 400}, {"rubs", rubs, 400},
    {"plies", plies, 400},
    {"graded", graded, 400},
};

/* Steps a scene to its end; a prescribed body is led through the sheet while it turns back, in two calls. */
static int32_t test_run(fk_sim *sim, const fk_scene *scene, uint64_t steps)
{
    static fk_path zero;
    fk_path path = zero;
    int32_t status;
    if (scene->drive != FK_DRIVE_PRESCRIBED)
        return fk_advance(sim, steps);
    path.steps = steps;
    set3(path.end.position, 4e-4, 0.0, -6e-4);
    set3(path.end.velocity, 5.0, 0.0, 300.0);
    path.end.orientation[0] = 0.8;
    path.end.orientation[1] = 0.6;
    set3(path.end.angular_velocity, 200.0, 100.0, -500.0);
    status = fk_follow(sim, &path, sizeof path, steps / 3);
    return status != FK_OK ? status : fk_follow(sim, &path, sizeof path, steps - steps / 3);
}

#endif /* SCENES_H */
