/* Scenes that the C and C++ hosts run for their digests; a test of `fabric-capi` runs the same from Rust. Small, and together
 * touching every shape, the mirror planes and every option that a scene has besides numbers. */
#ifndef SCENES_H
#define SCENES_H

#include "fabric_kernel.h"

static void sheet(fk_scene *scene, uint32_t nodes_x, uint32_t nodes_y)
{
    scene->sheet.nodes_x = nodes_x;
    scene->sheet.nodes_y = nodes_y;
}

/* A cylinder that strikes with its rim, faster than the sheet holds, and turns. */
static void askew(fk_scene *scene)
{
    sheet(scene, 33, 30);
    scene->projectile.radius = 3.5e-3;
    scene->projectile.length = 11e-3;
    scene->projectile.mass = 3.5e-3;
    scene->projectile.position[2] = -7.5e-3;
    scene->projectile.velocity[0] = 15.0;
    scene->projectile.velocity[2] = 350.0;
    scene->projectile.orientation[0] = 0.96;
    scene->projectile.orientation[1] = 0.28;
    scene->projectile.angular_velocity[0] = 800.0;
    scene->projectile.angular_velocity[2] = -1500.0;
}

static void theta(fk_scene *scene)
{
    askew(scene);
    scene->projectile.shape = FK_SHAPE_CYLINDER;
    scene->yarn.draw = FK_DRAW_YARN;
    scene->integrator.kind = FK_INTEGRATOR_THETA;
    scene->integrator.theta = 0.5;
    scene->integrator.tolerance = 1e-9;
    scene->integrator.max_iterations = 300;
    scene->rotation_rule.kind = FK_ROTATION_THETA;
    scene->rotation_rule.theta = 0.5;
}

static void quarter(fk_scene *scene)
{
    sheet(scene, 42, 41);
    scene->yarn.stochastic = 0;
    scene->symmetry.mirror_x = 1;
    scene->symmetry.mirror_y = 1;
}

static void box(fk_scene *scene)
{
    askew(scene);
    scene->projectile.shape = FK_SHAPE_BOX;
    scene->projectile.size[0] = 6e-3;
    scene->projectile.size[1] = 7e-3;
    scene->projectile.size[2] = 8e-3;
}

static void bullet(fk_scene *scene)
{
    askew(scene);
    scene->projectile.shape = FK_SHAPE_HEMISPHERICAL_CYLINDER;
}

/* The preset's sector of a disc, on a smaller sheet. */
static void sector(fk_scene *scene)
{
    sheet(scene, 121, 121);
    scene->projectile.velocity[2] = 400.0;
    scene->projectile.angular_velocity[1] = -2000.0;
}

static void rubs(fk_scene *scene)
{
    bullet(scene);
    scene->contact.friction = 0.25;
}

typedef struct test_scene {
    const char *name;
    uint32_t preset;
    void (*change)(fk_scene *);
    uint64_t steps;
} test_scene;

enum { TEST_SCENES = 6 };

static const test_scene test_scenes[TEST_SCENES] = {
    {"theta", FK_PRESET_SHEET_3IN_SPHERE, theta, 400},
    {"quarter", FK_PRESET_SHEET_3IN_SPHERE, quarter, 3000},
    {"box", FK_PRESET_SHEET_3IN_SPHERE, box, 1000},
    {"bullet", FK_PRESET_SHEET_3IN_SPHERE, bullet, 1000},
    {"sector", FK_PRESET_TURBINE_DISC_SECTOR, sector, 500},
    {"rubs", FK_PRESET_SHEET_3IN_SPHERE, rubs, 1000},
};

#endif /* SCENES_H */
