/* A C host of libfabric_kernel: runs an impact in several ways that must give the same bits, and asks for things that must
 * be refused. Prints the digests of its runs. Exit code 1 on the first check that fails. */
#include "fabric_kernel.h"
#include "../digests/scenes.h"

#include <fenv.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef __SSE2__
#include <xmmintrin.h>
#endif

static int checks = 0;

#define CHECK(condition)                                                               \
    do {                                                                               \
        checks++;                                                                      \
        if (!(condition)) {                                                            \
            fprintf(stderr, "%s:%d: %s does not hold\n", __FILE__, __LINE__, #condition); \
            exit(1);                                                                   \
        }                                                                              \
    } while (0)

enum { STEPS = 3000 };

/* A 41 x 41 piece of the 3 in sheet, hit at 100 m/s: past the first failed segments after 3000 steps. */
static fk_scene small_scene(void)
{
    fk_scene scene = fk_scene_preset(FK_PRESET_SHEET_3IN_SPHERE);
    scene.sheet.nodes_x = 41;
    scene.sheet.nodes_y = 41;
    return scene;
}

/* Memory with guard bytes behind; it need not be aligned, and here it never is. */
typedef struct block {
    unsigned char *all;
    unsigned char *start;
    uint64_t bytes;
} block;

enum { GUARD = 64, GUARD_BYTE = 0xc3 };

static block new_block(const fk_scene *scene, int fill)
{
    block b;
    CHECK(fk_memory_size(scene, &b.bytes) == FK_OK);
    b.all = malloc(1 + b.bytes + GUARD);
    CHECK(b.all != NULL);
    b.start = b.all + 1;
    memset(b.start, fill, b.bytes);
    memset(b.start + b.bytes, GUARD_BYTE, GUARD);
    return b;
}

/* The bytes behind the block must be as they were. */
static void free_block(block b)
{
    size_t i;
    for (i = 0; i < GUARD; i++)
        CHECK(b.start[b.bytes + i] == GUARD_BYTE);
    free(b.all);
}

static uint64_t digest_of(const fk_sim *sim)
{
    uint64_t digest = 0;
    CHECK(fk_digest(sim, &digest) == FK_OK);
    return digest;
}

/* The digests of the scenes of tests/digests are printed, to be compared with those of the kernel called from Rust. */
static void the_digests_of_every_scene(void)
{
    int i;
    for (i = 0; i < TEST_SCENES; i++) {
        fk_scene scene;
        block b;
        fk_sim *sim = NULL;
        fk_contact contact = {0};
        scene = fk_scene_preset(FK_PRESET_SHEET_3IN_SPHERE);
        test_scenes[i].change(&scene);
        CHECK(fk_scene_check(&scene, NULL, 0) == FK_OK);
        b = new_block(&scene, 0xee);
        CHECK(fk_init(b.start, b.bytes, &scene, &sim, NULL, 0) == FK_OK);
        CHECK(test_run(sim, &scene, test_scenes[i].steps) == FK_OK);
        CHECK(fk_get_contact(sim, &contact, sizeof contact) == FK_OK && contact.work > 0.0);
        printf("%s %016llx\n", test_scenes[i].name, (unsigned long long)digest_of(sim));
        free_block(b);
    }
}

static uint64_t straight_run(void)
{
    fk_scene scene = small_scene();
    block b = new_block(&scene, 0);
    fk_sim *sim = NULL;
    fk_counters counters = {0};
    uint64_t digest;
    CHECK(fk_init(b.start, b.bytes, &scene, &sim, NULL, 0) == FK_OK);
    CHECK(fk_advance(sim, STEPS) == FK_OK);
    CHECK(fk_get_counters(sim, &counters, sizeof counters) == FK_OK);
    CHECK(counters.steps == STEPS && counters.failed_segments > 0);
    digest = digest_of(sim);
    printf("small %016llx\n", (unsigned long long)digest);
    free_block(b);
    return digest;
}

/* Dirty and longer memory, uneven batches, read-outs in between, save and load half-way: the same bits. */
static void the_same_bits(uint64_t expected)
{
    fk_scene scene = small_scene();
    block b = new_block(&scene, 0xa5), c = new_block(&scene, 0x5a);
    fk_sim *sim = NULL, *other = NULL;
    fk_energy energy = {0};
    uint64_t done = 0, image_bytes = 0, batch = 1;
    unsigned char *image;
    CHECK(fk_init(b.start, b.bytes + GUARD, &scene, &sim, NULL, 0) == FK_OK);
    CHECK(fk_state_size(sim, &image_bytes) == FK_OK);
    image = malloc(image_bytes);
    CHECK(image != NULL);
    while (done < STEPS / 2) {
        uint64_t steps = done + batch > STEPS / 2 ? STEPS / 2 - done : batch;
        CHECK(fk_advance(sim, steps) == FK_OK);
        CHECK(fk_get_energy(sim, &energy, sizeof energy) == FK_OK);
        done += steps;
        batch = batch * 3 % 97 + 1;
    }
    CHECK(fk_state_save(sim, image, image_bytes) == FK_OK);
    CHECK(fk_init(c.start, c.bytes, &scene, &other, NULL, 0) == FK_OK);
    CHECK(fk_advance(other, 7) == FK_OK);
    CHECK(fk_state_load(other, image, image_bytes) == FK_OK);
    CHECK(fk_advance(other, STEPS - done) == FK_OK);
    CHECK(digest_of(other) == expected);
    while (done++ < STEPS)
        CHECK(fk_step(sim) == FK_OK);
    CHECK(digest_of(sim) == expected);
    CHECK(fk_reset(sim) == FK_OK);
    CHECK(fk_advance(sim, STEPS) == FK_OK);
    CHECK(digest_of(sim) == expected);

    /* A damaged image is refused and changes nothing. */
    image[image_bytes / 2] ^= 1;
    CHECK(fk_state_load(sim, image, image_bytes) == FK_IMAGE_MALFORMED);
    image[image_bytes / 2] ^= 1;
    CHECK(fk_state_load(sim, image, image_bytes - 1) == FK_IMAGE_MALFORMED);
    CHECK(fk_state_save(sim, image, image_bytes - 1) == FK_SHORT_BUFFER);
    CHECK(digest_of(sim) == expected);
    free(image);
    free_block(b);
    free_block(c);
}

/* Null, short and moved blocks: refused, nothing written. */
static void bad_memory(void)
{
    fk_scene scene = small_scene();
    block b = new_block(&scene, 0x77);
    fk_sim *sim = (fk_sim *)&scene, *before = sim;
    uint64_t i, length, steps = 0;
    unsigned char *copy = malloc(b.bytes + 128), *moved, *handle;
    CHECK(copy != NULL);
    CHECK(fk_init(NULL, b.bytes, &scene, &sim, NULL, 0) == FK_NULL_POINTER);
    CHECK(fk_init(b.start, b.bytes, NULL, &sim, NULL, 0) == FK_NULL_POINTER);
    CHECK(fk_init(b.start, b.bytes, &scene, NULL, NULL, 0) == FK_NULL_POINTER);
    CHECK(fk_init(b.start, b.bytes - 1, &scene, &sim, NULL, 0) == FK_SHORT_BUFFER);
    CHECK(fk_init(b.start, 0, &scene, &sim, NULL, 0) == FK_SHORT_BUFFER);
    CHECK(sim == before);
    for (i = 0; i < b.bytes; i++)
        if (b.start[i] != 0x77)
            break;
    CHECK(i == b.bytes);

    CHECK(fk_step(NULL) == FK_NULL_POINTER);
    CHECK(fk_init(b.start, b.bytes, &scene, &sim, NULL, 0) == FK_OK);
    handle = (unsigned char *)sim;
    length = b.bytes - (uint64_t)(handle - b.start);
    moved = copy + (64 - (uintptr_t)copy % 64);
    memcpy(moved, handle, length);
    CHECK(fk_step((fk_sim *)moved) == FK_MOVED_BLOCK);
    CHECK(fk_get_time((fk_sim *)moved, &steps, NULL) == FK_MOVED_BLOCK);
    CHECK(fk_step((fk_sim *)(handle + 8)) == FK_MOVED_BLOCK);
    CHECK(memcmp(moved, handle, length) == 0);
    CHECK(fk_step(sim) == FK_OK);
    free(copy);
    free_block(b);
}

/* Blocks, images and scratch of every length below what is needed, of the smallest sheet: refused, and no byte written, inside
 * or beside it. With the length that is needed they may lie at any address. */
static void short_buffers(void)
{
    enum { ROOM = 1 << 14 };
    static unsigned char all[ROOM + 128], image[ROOM];
    fk_scene scene = small_scene();
    block b;
    fk_sim *sim = NULL, *none = NULL;
    uint64_t bytes = 0, n, tried = 0, before;
    scene.sheet.nodes_x = scene.sheet.nodes_y = 2;
    CHECK(fk_memory_size(&scene, &bytes) == FK_OK && bytes < ROOM);
    memset(all, GUARD_BYTE, sizeof all);
    memset(image, GUARD_BYTE, sizeof image);
#define UNWRITTEN(place) ((place)[0] == GUARD_BYTE && memcmp(place, (place) + 1, sizeof(place) - 1) == 0)
    for (n = 0; n < bytes; n++, tried++)
        CHECK(fk_init(all, n, &scene, &none, NULL, 0) == FK_SHORT_BUFFER && none == NULL && UNWRITTEN(all));

    b = new_block(&scene, 0);
    CHECK(fk_init(b.start, b.bytes, &scene, &sim, NULL, 0) == FK_OK);
    before = digest_of(sim);
    for (n = 0; n < 128; n++) {
        memset(all, GUARD_BYTE, sizeof all);
        CHECK(fk_init(all + n, bytes, &scene, &none, NULL, 0) == FK_OK && digest_of(none) == before);
        CHECK((unsigned char *)none >= all + n && (unsigned char *)none < all + n + 64);
        CHECK((n == 0 || all[n - 1] == GUARD_BYTE) && all[n + bytes] == GUARD_BYTE);
    }
    memset(all, GUARD_BYTE, sizeof all);
    CHECK(fk_bands_size(sim, 2, &bytes) == FK_OK && bytes < ROOM);
    for (n = 0; n < bytes; n++, tried++)
        CHECK(fk_bands_begin(sim, 2, 0, all, n) == FK_SHORT_BUFFER && UNWRITTEN(all));
    for (n = 0; n < 128; n++) {
        memset(all, GUARD_BYTE, sizeof all);
        CHECK(fk_bands_begin(sim, 2, 0, all + n, bytes) == FK_OK && fk_bands_end(sim) == FK_OK && digest_of(sim) == before);
        CHECK((n == 0 || all[n - 1] == GUARD_BYTE) && all[n + bytes] == GUARD_BYTE);
    }
    CHECK(fk_state_size(sim, &bytes) == FK_OK && bytes < ROOM);
    for (n = 0; n < bytes; n++, tried++)
        CHECK(fk_state_save(sim, image, n) == FK_SHORT_BUFFER && UNWRITTEN(image));
    /* An image may lie at any address. */
    for (n = 0; n < 8; n++) {
        memset(image, GUARD_BYTE, sizeof image);
        CHECK(fk_state_save(sim, image + n, bytes) == FK_OK);
        CHECK((n == 0 || image[n - 1] == GUARD_BYTE) && image[n + bytes] == GUARD_BYTE);
        CHECK(fk_state_load(sim, image + n, bytes) == FK_OK);
    }
    CHECK(digest_of(sim) == before);
    fprintf(stderr, "figure 10: %u short buffers in C, %u refused with nothing written\n", (unsigned)tried, (unsigned)tried);
    free_block(b);
}

/* What a scene is refused with. */
static fk_fault refused(const fk_scene *scene, int32_t status)
{
    fk_fault fault = {0};
    CHECK(fk_scene_check(scene, &fault, sizeof fault) == status && fault.status == status);
    return fault;
}

/* What the cases of inputs.c cannot say: limit and text of a fault, two fields at once, counts beyond 32 bits, sizes, presets. */
static void bad_scenes(void)
{
    fk_scene scene = small_scene();
    fk_fault fault;
    scene.time_step.seconds = 2.7e-8;
    fault = refused(&scene, FK_STEP_TOO_LARGE);
    CHECK(fault.limit > 2.5e-8 && fault.limit < 2.65e-8 && strstr(fault.text, "the largest allowed is") != NULL);
    scene = small_scene();
    scene.integrator.kind = FK_INTEGRATOR_THETA;
    scene.contact.friction = 0.2;
    fault = refused(&scene, FK_DOES_NOT_GO_WITH);
    CHECK(strcmp(fault.text, "contact.friction: does not go with another field: integrator.kind") == 0);
    scene = small_scene();
    scene.sheet.nodes_x = (uint64_t)1 << 32;
    CHECK(strcmp(refused(&scene, FK_TOO_MANY_NODES).field, "sheet.nodes_x") == 0);
    scene = small_scene();
    scene.integrator.kind = UINT64_MAX;
    CHECK(strcmp(refused(&scene, FK_UNKNOWN_CHOICE).field, "integrator.kind") == 0);

    scene = small_scene();
    CHECK(fk_scene_check(&scene, NULL, 0) == FK_OK);
    scene.struct_size = 8;
    CHECK(strcmp(refused(&scene, FK_STRUCT_SIZE).field, "fk_scene") == 0);
    scene.struct_size = sizeof scene + 1;
    CHECK(fk_scene_check(&scene, NULL, 0) == FK_STRUCT_SIZE);
    CHECK(fk_scene_fill(&scene, 12, FK_PRESET_SHEET_3IN_SPHERE) == FK_STRUCT_SIZE);
    CHECK(fk_scene_fill(&scene, sizeof scene, 77) == FK_UNKNOWN_CHOICE);
    CHECK(fk_scene_fill(NULL, sizeof scene, FK_PRESET_SHEET_3IN_SPHERE) == FK_NULL_POINTER);
    scene = fk_scene_preset(77);
    CHECK(scene.struct_size == 0 && fk_scene_check(&scene, NULL, 0) == FK_STRUCT_SIZE);
    scene = fk_scene_default();
    CHECK(scene.sheet.nodes_x == 350 && scene.struct_size == sizeof scene);
    scene = fk_scene_preset(FK_PRESET_TURBINE_DISC_SECTOR);
    CHECK(scene.projectile.shape == FK_SHAPE_POLYHEDRON && scene.projectile.faces.count == 13);
    CHECK(fk_scene_check(&scene, NULL, 0) == FK_OK);
}

/* A textile's data sheet becomes the sheet of a scene; a bad one is named and changes nothing. */
static void textiles(void)
{
    fk_scene scene = small_scene(), before = scene;
    fk_threads threads = {600e-3 / 9000, 34 / 0.0254, 0.0};
    fk_textile textile;
    memset(&textile, 0, sizeof textile);
    textile.warp = textile.weft = threads;
    textile.fibre_density = 1440.0;
    textile.modulus = 84.62e9;
    textile.failure_strain = 0.0355;
    textile.damage_rate = 2300.0;
    textile.weft.crimp = 0.01;
    CHECK(fk_scene_set_textile(&scene, &textile, sizeof textile, NULL, 0) == FK_OK);
    CHECK(fabs(scene.sheet.spacing * 34 / 0.0254 - 1.0) < 1e-12 && scene.sheet.spacing_y == 0.0);
    CHECK(fabs(scene.sheet.yarn_area / (600e-3 / 9000 / 1440) - 1.0) < 1e-12 && scene.sheet.crimp[1] == 0.01);
    CHECK(fabs(scene.sheet.node_mass / (2.01 * 600e-3 / 9000 * 0.0254 / 34) - 1.0) < 1e-12);
    CHECK(scene.yarn.modulus_mean == 84.62e9 && scene.yarn.critical_stretch == 1.0355 && scene.yarn.stochastic == 0);
    CHECK(before.yarn.viscosity_bending == 0.0 && scene.yarn.viscosity_bending == 0.06);
    CHECK(scene.sheet.nodes_x == before.sheet.nodes_x && fk_scene_check(&scene, NULL, 0) == FK_OK);

    fk_fault fault;
    /* Behind it lies a fabric of its own in the same grid, of the same wave speed. */
    CHECK(fk_scene_set_back_textile(&scene, &textile, sizeof textile, NULL, 0) == FK_OK);
    CHECK(scene.back.plies == 0 && scene.back.node_mass == scene.sheet.node_mass && scene.back.yarn_area == scene.sheet.yarn_area);
    CHECK(scene.back.modulus_mean == 84.62e9 && scene.back.critical_stretch == 1.0355 && scene.back.crimp[1] == 0.01);
    CHECK(fk_scene_set_back_textile(&scene, NULL, sizeof textile, NULL, 0) == FK_NULL_POINTER);
    before = scene;
    textile.warp.count = 0.0;
    scene = before;
    CHECK(fk_scene_set_textile(&scene, &textile, sizeof textile, &fault, sizeof fault) == FK_NOT_POSITIVE);
    CHECK(strcmp(fault.field, "textile.warp.count") == 0 && memcmp(&scene, &before, sizeof scene) == 0);
    CHECK(fk_scene_set_textile(&scene, &textile, sizeof textile - 8, NULL, 0) == FK_STRUCT_SIZE);
    CHECK(fk_scene_set_textile(&scene, NULL, sizeof textile, NULL, 0) == FK_NULL_POINTER);
    CHECK(fk_scene_set_textile(NULL, &textile, sizeof textile, NULL, 0) == FK_NULL_POINTER);
}

/* A graded network is chosen about the hit; a bad error is named and changes nothing. Read-outs give the network's own nodes. */
static void gradings(void)
{
    fk_scene scene = fk_scene_preset(FK_PRESET_SHEET_10IN_CYLINDER), before = scene;
    fk_fault fault;
    CHECK(fk_scene_set_grading(&scene, 0.0, &fault, sizeof fault) == FK_OUT_OF_RANGE && strcmp(fault.field, "error") == 0);
    CHECK(memcmp(&scene, &before, sizeof scene) == 0 && fk_scene_set_grading(NULL, 0.01, NULL, 0) == FK_NULL_POINTER);
    scene.projectile.position[0] = 0.01;
    CHECK(fk_scene_set_grading(&scene, 0.01, NULL, 0) == FK_OK);
    CHECK(scene.sheet.grading.largest > 1 && scene.sheet.grading.centre[0] == 0.01);
    uint64_t graded = 0, fabric = 0;
    CHECK(fk_memory_size(&scene, &graded) == FK_OK && fk_memory_size(&before, &fabric) == FK_OK && 2 * graded < fabric);
}

/* A fault or a bad number must not hide one another: the structure that is to tell is looked at first. */
static void bad_faults(void)
{
    fk_scene scene = small_scene();
    fk_fault odd;
    memset(&odd, 0, sizeof odd);
    CHECK(fk_scene_check(&scene, &odd, sizeof odd - 8) == FK_STRUCT_SIZE);
    scene.sheet.plies = 0;
    CHECK(fk_scene_check(&scene, &odd, sizeof odd - 8) == FK_STRUCT_SIZE);
    CHECK(odd.status == 0 && odd.field[0] == '\0');
    CHECK(fk_scene_check(&scene, &odd, sizeof odd) == FK_OUT_OF_RANGE);
    CHECK(odd.status == FK_OUT_OF_RANGE && strcmp(odd.field, "sheet.plies") == 0 && odd.value == 0.0);
    CHECK(strstr(odd.text, "sheet.plies") != NULL);
}

/* What the simulation says about its last refused call. */
static void told(const fk_sim *sim, int32_t status, const char *field)
{
    fk_fault last = {0};
    CHECK(fk_get_fault(sim, &last, sizeof last) == FK_OK);
    CHECK(last.status == status && strcmp(last.field, field) == 0);
}

/* Whether every number is exactly this one. */
static int all_are(const double *numbers, uint64_t n, double value)
{
    uint64_t i;
    for (i = 0; i < n; i++)
        if (numbers[i] != value)
            return 0;
    return 1;
}

/* Until the sheet is perforated: every read-out, against what must hold between them. */
static void read_outs(void)
{
    fk_scene scene = small_scene();
    block b = new_block(&scene, 0);
    fk_sim *sim = NULL;
    fk_step_limits limits = {0};
    fk_grid grid = {0};
    fk_motion motion = {0};
    fk_contact contact = {0};
    fk_support support = {0};
    fk_energy energy = {0};
    fk_fabric fabric = {0};
    fk_outcome outcome = {0};
    fk_counters counters = {0};
    const uint64_t n = 3 * 41 * 41, segments = 2 * 41 * 40;
    double *x = malloc(4 * n * sizeof *x), *v = x + n, *damage = v + n, *stretch = damage + n;
    double seconds = 0.0, momentum[3], sum[3] = {0, 0, 0}, first_energy;
    uint64_t steps = 0, taken = 0, i, at, failed = 0;
    int k;
    CHECK(x != NULL);
    CHECK(fk_init(b.start, b.bytes, &scene, &sim, NULL, 0) == FK_OK);
    told(sim, FK_OK, "");
    CHECK(fk_get_grid(sim, &grid, sizeof grid) == FK_OK && grid.nodes_x == 41 && grid.nodes_y == 41);
    CHECK(grid.horizontal == 40 * 41 && grid.vertical == 40 * 41);
    CHECK(fk_get_step_limits(sim, &limits, sizeof limits) == FK_OK);
    CHECK(limits.dt == 0.4 * limits.dt_crit && limits.step_max == 0.5 * limits.dt_crit);
    CHECK(fk_get_outcome(sim, &outcome, sizeof outcome) == FK_OK);
    CHECK(outcome.status == FK_STATUS_FLIGHT && outcome.mask == 0 && outcome.first_contact == FK_NEVER);
    CHECK(fk_copy_positions(sim, x, n) == FK_OK && fk_copy_velocities(sim, v, n) == FK_OK);
    CHECK(x[0] == -x[3 * 40] && x[2] == 0.0 && all_are(v, n, 0.0));
    CHECK(fk_copy_damage(sim, damage, segments) == FK_OK && all_are(damage, segments, 1.0));
    CHECK(fk_copy_stretch(sim, stretch, segments) == FK_OK && all_are(stretch, segments, 1.0));
    CHECK(fk_copy_positions(sim, x, n - 1) == FK_WRONG_LENGTH);
    CHECK(fk_copy_positions(sim, NULL, n) == FK_NULL_POINTER);
    CHECK(fk_copy_positions(sim, (double *)((char *)x + 4), n) == FK_MISALIGNED);
    CHECK(fk_copy_damage(sim, damage, segments + 1) == FK_WRONG_LENGTH);
    CHECK(fk_copy_damage(sim, damage, UINT64_MAX) == FK_WRONG_LENGTH);
    CHECK(fk_get_energy(sim, &energy, sizeof energy) == FK_OK);
    first_energy = energy.projectile_kinetic;
    CHECK(fabs(first_energy - 42.0) < 1e-9);

    CHECK(fk_advance_until(sim, FK_ENDS, 50000, &taken) == FK_OK);
    CHECK(fk_get_outcome(sim, &outcome, sizeof outcome) == FK_OK);
    CHECK(outcome.mask & FK_EXITED && outcome.status == FK_STATUS_FLIGHT);
    CHECK(outcome.first_contact == 0 && outcome.step[2] == taken && outcome.step[0] == FK_NEVER);
    CHECK(outcome.work[2] > 0.0 && outcome.step[4] == FK_NEVER && outcome.work[4] == 0.0);
    CHECK(fk_get_time(sim, &steps, &seconds) == FK_OK && steps == taken && seconds == (double)steps * limits.dt);
    CHECK(fk_get_time(sim, NULL, NULL) == FK_OK);
    CHECK(fk_get_projectile(sim, &motion, sizeof motion) == FK_OK);
    CHECK(fk_get_contact(sim, &contact, sizeof contact) == FK_OK);
    CHECK(fk_get_energy(sim, &energy, sizeof energy) == FK_OK);
    CHECK(motion.velocity[2] > 0.0 && motion.velocity[2] < 100.0);
    CHECK(fabs(scene.projectile.mass * (motion.velocity[2] - 100.0) / contact.impulse[2] - 1.0) < 1e-9);
    CHECK(fabs((first_energy - energy.projectile_kinetic) / contact.work - 1.0) < 1e-9);
    CHECK(contact.work == energy.contact_work && contact.loss == energy.contact_loss && contact.force_peak > 0.0);
    CHECK(fk_get_support(sim, &support, sizeof support) == FK_OK);
    for (i = 0; i < 4; i++)
        for (k = 0; k < 3; k++)
            sum[k] += support.attachments[i][k];
    CHECK(support.total[2] > 0.0 && fabs(sum[2] / support.total[2] - 1.0) < 1e-12);
    CHECK(fk_get_momentum_residual(sim, momentum) == FK_OK);
    for (k = 0; k < 3; k++)
        CHECK(fabs(momentum[k]) < 1e-11 * scene.projectile.mass * 100.0);
    CHECK(fk_get_fabric(sim, &fabric, sizeof fabric) == FK_OK);
    CHECK(fk_copy_positions(sim, x, n) == FK_OK);
    CHECK(fabric.max_deflection > 0.0 && fabric.max_stretch >= 1.0);
    /* Some node lies there; those that lie farther out are debris. */
    for (i = 0, at = 0; i < n; i += 3)
        at += fabs(fabs(x[i + 2]) - fabric.max_deflection) <= 1e-15 * fabric.max_deflection;
    CHECK(at >= 1);
    CHECK(fk_copy_damage(sim, damage, segments) == FK_OK);
    for (i = 0; i < segments; i++)
        failed += damage[i] == 0.0;
    /* The damage read out belongs to t_n, the counter to the forces of the last step. */
    CHECK(fk_get_counters(sim, &counters, sizeof counters) == FK_OK);
    CHECK(counters.failed_segments > 0 && failed >= counters.failed_segments);
    CHECK(counters.most_candidates <= counters.candidate_capacity);
    /* What a host watches: a sound run. */
    CHECK(fabs(energy.residual) < 0.01 * first_energy && limits.dt / limits.dt_crit <= 0.5);
    CHECK(counters.unconverged == 0 && counters.worst_penetration < 1e-12 * scene.projectile.radius);
    CHECK(fabric.max_stretch < 1.06);

    counters.steps = 16;
    CHECK(fk_get_counters(sim, &counters, 16) == FK_STRUCT_SIZE && counters.steps == 16);
    CHECK(fk_get_energy(sim, NULL, sizeof energy) == FK_NULL_POINTER);
    CHECK(fk_get_energy(sim, (fk_energy *)((char *)x + 1), sizeof energy) == FK_MISALIGNED);
    CHECK(fk_get_momentum_residual(sim, NULL) == FK_NULL_POINTER);
    CHECK(fk_digest(sim, NULL) == FK_NULL_POINTER && fk_state_size(sim, NULL) == FK_NULL_POINTER);
    CHECK(fk_set_motion(sim, x, v, n) == FK_ALREADY_STARTED);
    CHECK(fk_set_largest_stretch(sim, stretch, segments) == FK_ALREADY_STARTED);
    free(x);
    free_block(b);
}

/* Each ply of a stack by itself: what all hold together is what the stack holds. */
static void separate_plies(void)
{
    fk_scene scene = small_scene();
    fk_sim *sim = NULL;
    fk_energy energy;
    fk_counters counters;
    fk_grid grid;
    fk_ply ply, sum = {0};
    uint64_t steps;
    uint32_t k;
    block b;
    scene.stack.plies = 3;
    scene.stack.gap = 2.5e-4;
    scene.projectile.velocity[2] = 250.0;
    b = new_block(&scene, 0);
    CHECK(fk_init(b.start, b.bytes, &scene, &sim, NULL, 0) == FK_OK);
    CHECK(fk_get_grid(sim, &grid, sizeof grid) == FK_OK && grid.plies == 3 && grid.nodes_x == 41);
    CHECK(fk_get_ply(sim, 2, &ply, sizeof ply) == FK_OK && ply.failed_segments == 0 && ply.kinetic == 0.0 && ply.strain == 0.0);
    CHECK(fk_advance_until(sim, FK_EXITED, 1500, &steps) == FK_OK);
    CHECK(fk_get_energy(sim, &energy, sizeof energy) == FK_OK && fk_get_counters(sim, &counters, sizeof counters) == FK_OK);
    for (k = 0; k < 3; k++) {
        CHECK(fk_get_ply(sim, k, &ply, sizeof ply) == FK_OK);
        CHECK(ply.failed_segments > 0 && ply.kinetic > 0.0 && ply.strain > 0.0 && ply.dissipated > 0.0);
        sum.failed_segments += ply.failed_segments;
        sum.kinetic += ply.kinetic;
        sum.strain += ply.strain;
        sum.dissipated += ply.dissipated;
    }
    CHECK(sum.failed_segments == counters.failed_segments && counters.ply_penetration >= 0.0);
    CHECK(fabs(sum.kinetic / energy.fabric_kinetic - 1.0) < 1e-12 && fabs(sum.strain / energy.strain - 1.0) < 1e-12);
    CHECK(fabs(sum.dissipated / energy.dissipated - 1.0) < 1e-12);
    ply.kinetic = 7.0;
    CHECK(fk_get_ply(sim, 3, &ply, sizeof ply) == FK_OUT_OF_RANGE && ply.kinetic == 7.0);
    CHECK(fk_get_ply(sim, 0, &ply, 8) == FK_STRUCT_SIZE && fk_get_ply(sim, 0, NULL, sizeof ply) == FK_NULL_POINTER);
    CHECK(fk_get_ply(NULL, 0, &ply, sizeof ply) == FK_NULL_POINTER);
    free_block(b);

    /* Of a single sheet ply 0 is all. */
    scene.stack.plies = 1;
    b = new_block(&scene, 0);
    CHECK(fk_init(b.start, b.bytes, &scene, &sim, NULL, 0) == FK_OK && fk_advance(sim, 300) == FK_OK);
    CHECK(fk_get_energy(sim, &energy, sizeof energy) == FK_OK && fk_get_ply(sim, 0, &ply, sizeof ply) == FK_OK);
    CHECK(ply.kinetic == energy.fabric_kinetic && ply.strain == energy.strain && ply.dissipated == energy.dissipated);
    CHECK(fk_get_ply(sim, 1, &ply, sizeof ply) == FK_OUT_OF_RANGE);
    free_block(b);
}

/* Yarns slip at more crossings with less friction, and at none with enough. */
static void slip(void)
{
    fk_scene scene = small_scene();
    fk_sim *sim = NULL;
    fk_slip little, much, held;
    block b = new_block(&scene, 0);
    CHECK(fk_init(b.start, b.bytes, &scene, &sim, NULL, 0) == FK_OK && fk_advance(sim, 300) == FK_OK);
    CHECK(fk_get_slip(sim, 2e-4, 0.1, 0.0, &little, sizeof little) == FK_OK && fk_get_slip(sim, 2e-4, 0.3, 0.0, &much, sizeof much) == FK_OK);
    CHECK(little.slipping[2] > much.slipping[2] && much.slipping[2] >= much.slipping[1] && much.slipping[1] >= much.slipping[0]);
    CHECK(little.crossings[2] == 39 * 39 && little.largest > 0.0 && little.largest == much.largest);
    CHECK(fk_get_slip(sim, 2e-4, 0.0, little.largest, &held, sizeof held) == FK_OK && held.slipping[2] == 0);
    CHECK(fk_get_slip(sim, 0.0, 0.1, 0.0, &held, sizeof held) == FK_NOT_POSITIVE && fk_get_slip(sim, 2e-4, -0.1, 0.0, &held, sizeof held) == FK_OUT_OF_RANGE);
    CHECK(fk_get_slip(sim, 2e-4, 0.1, 0.0, &held, 8) == FK_STRUCT_SIZE && fk_get_slip(sim, 2e-4, 0.1, 0.0, NULL, sizeof held) == FK_NULL_POINTER);
    free_block(b);
}

/* Starts given by the host: what does not fit is refused by name and changes nothing. */
static void given_starts(void)
{
    fk_scene scene = small_scene();
    block b = new_block(&scene, 0);
    fk_sim *sim = NULL;
    const uint64_t n = 3 * 41 * 41, segments = 2 * 41 * 40, centre = 3 * (20 * 41 + 20);
    double *x = malloc(3 * n * sizeof *x), *v = x + n, *stretch = v + n;
    uint64_t before, i;
    CHECK(x != NULL);
    CHECK(fk_init(b.start, b.bytes, &scene, &sim, NULL, 0) == FK_OK);
    CHECK(fk_copy_positions(sim, x, n) == FK_OK && fk_copy_velocities(sim, v, n) == FK_OK);
    before = digest_of(sim);
    CHECK(fk_set_motion(sim, x, v, n - 3) == FK_WRONG_LENGTH);
    told(sim, FK_WRONG_LENGTH, "positions");
    CHECK(fk_set_motion(sim, NULL, v, n) == FK_NULL_POINTER);
    told(sim, FK_NULL_POINTER, "positions");
    x[centre] = NAN;
    CHECK(fk_set_motion(sim, x, v, n) == FK_NOT_FINITE);
    told(sim, FK_NOT_FINITE, "positions");
    x[centre] = 0.0;
    v[centre + 1] = INFINITY;
    CHECK(fk_set_motion(sim, x, v, n) == FK_NOT_FINITE);
    told(sim, FK_NOT_FINITE, "velocities");
    v[centre + 1] = 0.0;
    v[0] = 1.0;
    CHECK(fk_set_motion(sim, x, v, n) == FK_OUT_OF_RANGE);
    told(sim, FK_OUT_OF_RANGE, "velocities");
    v[0] = 0.0;
    x[centre + 2] = -1e-3;
    CHECK(fk_set_motion(sim, x, v, n) == FK_INITIAL_OVERLAP);
    told(sim, FK_INITIAL_OVERLAP, "positions");
    x[centre + 2] = 0.0;
    for (i = 0; i < segments; i++)
        stretch[i] = 1.0;
    CHECK(fk_set_largest_stretch(sim, stretch, segments - 1) == FK_WRONG_LENGTH);
    stretch[7] = -1.0;
    CHECK(fk_set_largest_stretch(sim, stretch, segments) == FK_OUT_OF_RANGE);
    told(sim, FK_OUT_OF_RANGE, "stretches");
    CHECK(digest_of(sim) == before);

    stretch[7] = 1.06;
    v[centre + 2] = 5.0;
    CHECK(fk_set_largest_stretch(sim, stretch, segments) == FK_OK);
    CHECK(fk_set_motion(sim, x, v, n) == FK_OK);
    CHECK(fk_copy_damage(sim, stretch, segments) == FK_OK && stretch[7] == 0.0 && stretch[6] == 1.0);
    CHECK(digest_of(sim) != before);
    CHECK(fk_reset(sim) == FK_OK);
    told(sim, FK_OK, "");
    CHECK(digest_of(sim) == before);
    free(x);
    free_block(b);
}

/* Flush subnormals to zero, on input and output, as fast-math does; how it was set before. */
static unsigned flush_subnormals(unsigned on)
{
#ifdef __SSE2__
    const unsigned flags = 0x8040, before = _mm_getcsr();
    _mm_setcsr(on ? before | flags : before & ~flags);
    return (before & flags) == flags;
#else
    return on ^ 1;
#endif
}

/* A host that rounds upwards and flushes subnormals gets the same bits and finds its settings as they were. */
static void rounding_of_the_host(uint64_t expected)
{
    fk_scene scene = small_scene();
    block b = new_block(&scene, 0);
    fk_sim *sim = NULL;
    int32_t made, advanced;
    unsigned flushed;
    int mode;
    CHECK(fesetround(FE_UPWARD) == 0);
    flush_subnormals(1);
    made = fk_init(b.start, b.bytes, &scene, &sim, NULL, 0);
    advanced = fk_advance(sim, STEPS);
    mode = fegetround();
    flushed = flush_subnormals(0);
    CHECK(fesetround(FE_TONEAREST) == 0);
    CHECK(made == FK_OK && advanced == FK_OK && mode == FE_UPWARD && flushed);
    CHECK(digest_of(sim) == expected);
    free_block(b);
}

/* A projectile the host prescribes; requests that do not fit it are refused and change nothing. */
static void a_led_body(void)
{
    fk_scene scene = small_scene();
    block b;
    fk_sim *sim = NULL;
    fk_path path;
    fk_contact contact = {0};
    fk_energy energy = {0};
    const double load[3] = {0, 0, 1};
    uint64_t before;
    scene.drive = FK_DRIVE_PRESCRIBED;
    scene.projectile.mass = 0.0;
    b = new_block(&scene, 0);
    CHECK(fk_init(b.start, b.bytes, &scene, &sim, NULL, 0) == FK_OK);
    memset(&path, 0, sizeof path);
    path.steps = 500;
    path.end.orientation[0] = 1.0;
    path.end.position[2] = scene.projectile.position[2] + 1e-3;
    path.end.velocity[2] = 90.0;
    before = digest_of(sim);
    CHECK(fk_set_external_load(sim, load, load) == FK_WRONG_DRIVE);
    told(sim, FK_WRONG_DRIVE, "drive");
    path.first = 3;
    CHECK(fk_follow(sim, &path, sizeof path, 1) == FK_BAD_PATH);
    told(sim, FK_BAD_PATH, "path.first");
    path.first = 0;
    CHECK(fk_follow(sim, &path, sizeof path, 501) == FK_BAD_PATH);
    path.end.position[0] = NAN;
    CHECK(fk_follow(sim, &path, sizeof path, 1) == FK_NOT_FINITE);
    told(sim, FK_NOT_FINITE, "path.position");
    path.end.position[0] = 0.0;
    path.end.orientation[0] = 0.0;
    CHECK(fk_follow(sim, &path, sizeof path, 1) == FK_BAD_QUATERNION);
    told(sim, FK_BAD_QUATERNION, "path.orientation");
    path.end.orientation[0] = 1.0;
    path.end.position[2] += 1.0;
    CHECK(fk_follow(sim, &path, sizeof path, 1) == FK_PROJECTILE_TOO_FAST);
    path.end.position[2] -= 1.0;
    CHECK(fk_follow(sim, NULL, sizeof path, 1) == FK_NULL_POINTER && fk_follow(sim, &path, sizeof path + 8, 1) == FK_STRUCT_SIZE);
    CHECK(digest_of(sim) == before);
    CHECK(fk_follow(sim, &path, sizeof path, 200) == FK_OK);
    CHECK(fk_follow(sim, &path, sizeof path, 300) == FK_OK);
    CHECK(fk_get_contact(sim, &contact, sizeof contact) == FK_OK);
    CHECK(fk_get_energy(sim, &energy, sizeof energy) == FK_OK);
    CHECK(contact.work > 0.0 && contact.impulse[2] < 0.0);
    CHECK(fabs(energy.residual) < 1e-3 * contact.work);
    free_block(b);
}

/* After a failure every call but reset, load, the counters and the fault returns its number. */
static void every_call_says(fk_sim *sim, int32_t status)
{
    fk_path path = {.steps = 1};
    fk_motion motion = {0};
    fk_grid grid = {0};
    fk_step_limits limits = {0};
    fk_contact contact = {0};
    fk_support support = {0};
    fk_energy energy = {0};
    fk_fabric fabric = {0};
    fk_outcome outcome = {0};
    static double numbers[3 * 41 * 41];
    static unsigned char bytes[1 << 18];
    uint64_t count = 0;
    const uint64_t n = 3 * 41 * 41, segments = 2 * 41 * 40;
    CHECK(fk_step(sim) == status && fk_advance(sim, 0) == status && fk_advance(sim, 1) == status);
    CHECK(fk_advance_until(sim, 0, 1, &count) == status && fk_advance_until(sim, 0, 0, NULL) == status);
    CHECK(fk_follow(sim, &path, sizeof path, 1) == status);
    CHECK(fk_get_time(sim, &count, NULL) == status && fk_get_step_limits(sim, &limits, sizeof limits) == status);
    CHECK(fk_get_grid(sim, &grid, sizeof grid) == status);
    CHECK(fk_get_projectile(sim, &motion, sizeof motion) == status && fk_get_contact(sim, &contact, sizeof contact) == status);
    CHECK(fk_get_support(sim, &support, sizeof support) == status && fk_get_energy(sim, &energy, sizeof energy) == status);
    CHECK(fk_get_fabric(sim, &fabric, sizeof fabric) == status && fk_get_outcome(sim, &outcome, sizeof outcome) == status);
    CHECK(fk_get_momentum_residual(sim, numbers) == status);
    CHECK(fk_set_external_load(sim, numbers, numbers) == status);
    CHECK(fk_set_motion(sim, numbers, numbers, n) == status);
    CHECK(fk_set_largest_stretch(sim, numbers, segments) == status);
    CHECK(fk_copy_positions(sim, numbers, n) == status && fk_copy_velocities(sim, numbers, n) == status);
    CHECK(fk_copy_damage(sim, numbers, segments) == status && fk_copy_stretch(sim, numbers, segments) == status);
    CHECK(fk_state_size(sim, &count) == status && fk_state_save(sim, bytes, sizeof bytes) == status);
    CHECK(fk_digest(sim, &count) == status && count == 0);
    /* Nothing has been written. */
    CHECK(motion.velocity[2] == 0.0 && motion.orientation[0] == 0.0 && grid.nodes_x == 0 && limits.dt == 0.0);
    CHECK(contact.impulse[2] == 0.0 && support.total[2] == 0.0 && energy.projectile_kinetic == 0.0);
    CHECK(fabric.max_stretch == 0.0 && outcome.first_contact == 0 && all_are(numbers, n, 0.0) && bytes[0] == 0);
}

/* The same of calls that a failure does not stop. */
static void every_other_call_says(fk_sim *sim, int32_t status)
{
    fk_counters counters = {0};
    fk_fault fault = {0};
    fk_ply ply = {0};
    fk_slip slip = {0};
    uint64_t count = 0;
    uint32_t last = 7;
    const unsigned char image[8] = {0};
    every_call_says(sim, status);
    CHECK(fk_reset(sim) == status && fk_state_load(sim, image, sizeof image) == status);
    CHECK(fk_get_counters(sim, &counters, sizeof counters) == status && counters.candidate_capacity == 0);
    CHECK(fk_get_fault(sim, &fault, sizeof fault) == status && fault.status == 0);
    CHECK(fk_get_ply(sim, 0, &ply, sizeof ply) == status && fk_get_slip(sim, 2e-4, 0.1, 0.0, &slip, sizeof slip) == status);
    CHECK(fk_bands_size(sim, 2, &count) == status && fk_bands_begin(sim, 2, 0, &count, sizeof count) == status && count == 0);
    CHECK(fk_bands_pass(sim, 0, &last) == status && last == 7 && fk_bands_end(sim) == status);
    CHECK(fk_bands_progress(sim, NULL, NULL, NULL) == status);
}

/* A read-out refuses a structure that is none, is misaligned, or has another size, and writes nothing. */
#define REFUSES(type, get)                                                                       \
    do {                                                                                         \
        type places[2], as_before[2];                                                            \
        memset(places, 0x5a, sizeof places);                                                     \
        memset(as_before, 0x5a, sizeof as_before);                                               \
        CHECK(get(sim, NULL, sizeof(type)) == FK_NULL_POINTER);                                  \
        CHECK(get(sim, (type *)((char *)places + 4), sizeof(type)) == FK_MISALIGNED);            \
        CHECK(get(sim, places, sizeof(type) - 4) == FK_STRUCT_SIZE);                             \
        CHECK(get(sim, places, sizeof(type) + 8) == FK_STRUCT_SIZE);                             \
        CHECK(get(sim, places, UINT64_MAX) == FK_STRUCT_SIZE);                                   \
        CHECK(memcmp(places, as_before, sizeof places) == 0);                                    \
    } while (0)

/* A call with an array of numbers refuses none, a misaligned one, and one of another length. */
#define REFUSES_ARRAY(call, n)                                                                   \
    do {                                                                                         \
        CHECK(call(sim, NULL, n) == FK_NULL_POINTER);                                            \
        CHECK(call(sim, (double *)((char *)numbers + 4), n) == FK_MISALIGNED);                   \
        CHECK(call(sim, numbers, (n) - 1) == FK_WRONG_LENGTH);                                   \
        CHECK(call(sim, numbers, (n) + 1) == FK_WRONG_LENGTH);                                   \
        CHECK(call(sim, numbers, 0) == FK_WRONG_LENGTH);                                         \
        CHECK(call(sim, numbers, UINT64_MAX / 8) == FK_WRONG_LENGTH);                            \
        CHECK(all_are(numbers, n, 7.5));                                                         \
    } while (0)

static int32_t motions(fk_sim *sim, const double *positions, uint64_t n)
{
    return fk_set_motion(sim, positions, positions, n);
}

/* Every call refuses a handle that is none, is not aligned or was copied, and pointers, sizes and lengths that are wrong; the state
 * stays what it was. */
static void bad_arguments(void)
{
    fk_scene scene = small_scene();
    block b = new_block(&scene, 0);
    fk_sim *sim = NULL, *none = NULL;
    fk_fault faults[2];
    fk_path path = {.steps = 1};
    static double numbers[3 * 41 * 41 + 2];
    const uint64_t n = 3 * 41 * 41, segments = 2 * 41 * 40;
    uint64_t bytes = 0, before, i;
    unsigned char *copy = malloc(b.bytes + 128), *moved, *handle;
    CHECK(copy != NULL);
    memset(faults, 0, sizeof faults);
    CHECK(fk_init(b.start, b.bytes, (fk_scene *)((char *)&scene + 4), &none, NULL, 0) == FK_MISALIGNED);
    CHECK(fk_init(b.start, b.bytes, &scene, &none, (fk_fault *)((char *)faults + 4), sizeof *faults) == FK_MISALIGNED);
    CHECK(fk_init(b.start, b.bytes, &scene, &none, faults, sizeof *faults - 8) == FK_STRUCT_SIZE);
    CHECK(none == NULL && faults[0].status == 0 && faults[1].status == 0);
    CHECK(fk_init(b.start, b.bytes, &scene, &sim, NULL, 0) == FK_OK && fk_step(sim) == FK_OK);
    handle = (unsigned char *)sim;
    moved = copy + (64 - (uintptr_t)copy % 64);
    memcpy(moved, handle, b.bytes - (uint64_t)(handle - b.start));
    every_other_call_says(NULL, FK_NULL_POINTER);
    every_other_call_says((fk_sim *)moved, FK_MOVED_BLOCK);
    every_other_call_says((fk_sim *)(handle + 8), FK_MOVED_BLOCK);
    free(copy);

    before = digest_of(sim);
    REFUSES(fk_step_limits, fk_get_step_limits);
    REFUSES(fk_grid, fk_get_grid);
    REFUSES(fk_motion, fk_get_projectile);
    REFUSES(fk_contact, fk_get_contact);
    REFUSES(fk_support, fk_get_support);
    REFUSES(fk_energy, fk_get_energy);
    REFUSES(fk_fabric, fk_get_fabric);
    REFUSES(fk_outcome, fk_get_outcome);
    REFUSES(fk_counters, fk_get_counters);
    REFUSES(fk_fault, fk_get_fault);
    for (i = 0; i < n + 2; i++)
        numbers[i] = 7.5;
    REFUSES_ARRAY(fk_copy_positions, n);
    REFUSES_ARRAY(fk_copy_velocities, n);
    REFUSES_ARRAY(fk_copy_damage, segments);
    REFUSES_ARRAY(fk_copy_stretch, segments);
    CHECK(fk_get_momentum_residual(sim, (double *)((char *)numbers + 4)) == FK_MISALIGNED);
    CHECK(fk_set_external_load(sim, NULL, numbers) == FK_NULL_POINTER && fk_set_external_load(sim, numbers, NULL) == FK_NULL_POINTER);
    CHECK(fk_state_size(sim, &bytes) == FK_OK && fk_state_save(sim, NULL, bytes) == FK_NULL_POINTER);
    CHECK(fk_state_load(sim, NULL, bytes) == FK_NULL_POINTER);
    CHECK(digest_of(sim) == before && fk_reset(sim) == FK_OK);
    before = digest_of(sim);
    REFUSES_ARRAY(motions, n);
    REFUSES_ARRAY(fk_set_largest_stretch, segments);
    CHECK(digest_of(sim) == before);
    free_block(b);

    scene.drive = FK_DRIVE_PRESCRIBED;
    b = new_block(&scene, 0);
    CHECK(fk_init(b.start, b.bytes, &scene, &sim, NULL, 0) == FK_OK);
    before = digest_of(sim);
    CHECK(fk_follow(sim, (fk_path *)((char *)&path + 4), sizeof path, 1) == FK_MISALIGNED);
    CHECK(fk_follow(sim, &path, sizeof path - 8, 1) == FK_STRUCT_SIZE && digest_of(sim) == before);
    free_block(b);
}

/* An external load that makes the projectile too fast: said at once, latched, cleared by reset. */
static void failure(void)
{
    fk_scene scene = small_scene();
    block b = new_block(&scene, 0);
    fk_sim *sim = NULL;
    fk_counters counters = {0};
    uint64_t bytes = 0, start;
    unsigned char *image;
    const double force[3] = {1e9, 0, 0}, torque[3] = {0, 0, 0}, wrong[3] = {NAN, 0, 0};
    CHECK(fk_init(b.start, b.bytes, &scene, &sim, NULL, 0) == FK_OK);
    start = digest_of(sim);
    CHECK(fk_state_size(sim, &bytes) == FK_OK);
    image = malloc(bytes);
    CHECK(image != NULL && fk_state_save(sim, image, bytes) == FK_OK);
    CHECK(fk_set_external_load(sim, wrong, torque) == FK_NOT_FINITE);
    told(sim, FK_NOT_FINITE, "external.force");
    CHECK(fk_set_external_load(sim, force, torque) == FK_OK);
    CHECK(fk_advance(sim, 1000) == FK_TOO_FAST);
    CHECK(fk_get_counters(sim, &counters, sizeof counters) == FK_OK && counters.steps < 1000);
    told(sim, FK_TOO_FAST, "");
    every_call_says(sim, FK_TOO_FAST);
    CHECK(fk_get_counters(sim, &counters, sizeof counters) == FK_OK);
    CHECK(fk_state_load(sim, image, bytes) == FK_OK);
    CHECK(digest_of(sim) == start);
    CHECK(fk_set_external_load(sim, force, torque) == FK_OK);
    CHECK(fk_advance(sim, 1000) == FK_TOO_FAST);
    CHECK(fk_reset(sim) == FK_OK);
    CHECK(digest_of(sim) == start);
    CHECK(fk_step(sim) == FK_OK);
    free(image);
    free_block(b);

    /* Too few places for the nodes under the projectile. */
    scene.contact_capacity = 1;
    b = new_block(&scene, 0);
    CHECK(fk_init(b.start, b.bytes, &scene, &sim, NULL, 0) == FK_OK);
    CHECK(fk_advance(sim, STEPS) == FK_CONTACT_CAPACITY);
    every_call_says(sim, FK_CONTACT_CAPACITY);
    free_block(b);
}

/* Bands called one after the other: the same bits; calls out of turn are refused and change nothing. */
static void bands(uint64_t expected)
{
    fk_scene scene = small_scene();
    block b = new_block(&scene, 0);
    fk_sim *sim = NULL;
    fk_counters counters = {0};
    fk_fault why = {0};
    uint64_t bytes = 0, passes = 0, steps = 0;
    uint32_t last = 7, outcomes = 7, band;
    unsigned char *scratch, byte;
    CHECK(fk_init(b.start, b.bytes, &scene, &sim, NULL, 0) == FK_OK);
    CHECK(fk_bands_size(sim, 0, &bytes) == FK_OUT_OF_RANGE && fk_bands_size(NULL, 3, &bytes) == FK_NULL_POINTER);
    CHECK(fk_bands_size(sim, FK_MAX_BANDS + 1, &bytes) == FK_OUT_OF_RANGE && bytes == 0);
    CHECK(fk_bands_size(sim, 3, &bytes) == FK_OK);
    scratch = malloc(bytes + GUARD);
    CHECK(scratch != NULL);
    memset(scratch, GUARD_BYTE, bytes + GUARD);

    CHECK(fk_bands_pass(sim, 0, &last) == FK_BAND_OUT_OF_TURN && last == 7);
    CHECK(fk_bands_progress(sim, &passes, &steps, &outcomes) == FK_BAND_OUT_OF_TURN && fk_bands_end(sim) == FK_BAND_OUT_OF_TURN);
    CHECK(fk_bands_begin(sim, 3, 0, NULL, bytes) == FK_NULL_POINTER && fk_bands_begin(NULL, 3, 0, scratch, bytes) == FK_NULL_POINTER);
    CHECK(fk_bands_begin(sim, 3, 0, scratch, bytes - 1) == FK_SHORT_BUFFER);
    CHECK(fk_bands_begin(sim, 0, 0, scratch, bytes) == FK_OUT_OF_RANGE);
    for (byte = 0; byte < GUARD; byte++)
        CHECK(scratch[byte] == GUARD_BYTE);
    CHECK(fk_bands_begin(sim, 3, 0, scratch, bytes) == FK_OK);
    CHECK(fk_bands_begin(sim, 3, 0, scratch, bytes) == FK_BAND_OUT_OF_TURN);
    every_call_says(sim, FK_BAND_OUT_OF_TURN);
    CHECK(fk_reset(sim) == FK_BAND_OUT_OF_TURN && fk_state_load(sim, scratch, 8) == FK_BAND_OUT_OF_TURN);
    CHECK(fk_get_counters(sim, &counters, sizeof counters) == FK_BAND_OUT_OF_TURN && fk_get_fault(sim, &why, sizeof why) == FK_BAND_OUT_OF_TURN);

    while (steps < STEPS - 1) {
        for (band = 3; band-- > 0;) {
            CHECK(fk_bands_pass(sim, band, &last) == FK_OK && last == (band == 0));
            if (band > 0)
                CHECK(fk_bands_pass(sim, band, &last) == FK_BAND_OUT_OF_TURN);
        }
        CHECK(fk_bands_pass(sim, 3, &last) == FK_OUT_OF_RANGE);
        CHECK(fk_bands_progress(sim, &passes, &steps, &outcomes) == FK_OK && passes == steps);
    }
    CHECK(fk_bands_progress(sim, NULL, NULL, NULL) == FK_OK);
    /* The last step is begun by one band only and completed by the end. */
    CHECK(fk_bands_pass(sim, 1, NULL) == FK_OK);
    CHECK(fk_bands_end(sim) == FK_OK && fk_bands_end(sim) == FK_BAND_OUT_OF_TURN);
    CHECK(digest_of(sim) == expected);
    for (byte = 0; byte < GUARD; byte++)
        CHECK(scratch[bytes + byte] == GUARD_BYTE);
    free_block(b);

    /* A failure: told to the last band, then to all, and by the end. */
    scene.contact_capacity = 1;
    b = new_block(&scene, 0);
    CHECK(fk_init(b.start, b.bytes, &scene, &sim, NULL, 0) == FK_OK);
    CHECK(fk_bands_begin(sim, 2, 0, scratch, bytes) == FK_OK);
    for (steps = 0; fk_bands_pass(sim, 0, NULL) == FK_OK; steps++)
        CHECK(steps < STEPS && fk_bands_pass(sim, 1, NULL) == (steps == 0 ? FK_CONTACT_CAPACITY : FK_OK));
    CHECK(fk_bands_pass(sim, 1, NULL) == FK_CONTACT_CAPACITY);
    CHECK(fk_bands_end(sim) == FK_CONTACT_CAPACITY);
    told(sim, FK_CONTACT_CAPACITY, "");
    CHECK(fk_bands_begin(sim, 2, 0, scratch, bytes) == FK_CONTACT_CAPACITY);
    free(scratch);
    free_block(b);
}

int main(void)
{
    uint64_t digest;
    CHECK(fk_abi_version() == FK_ABI_VERSION);
    CHECK(strlen(fk_version()) > 0);
    CHECK(strcmp(fk_status_name(FK_OK), "success") == 0);
    CHECK(strcmp(fk_status_name(-1000), "unknown status") == 0);
    the_digests_of_every_scene();
    digest = straight_run();
    the_same_bits(digest);
    bad_memory();
    bad_arguments();
    short_buffers();
    bad_scenes();
    textiles();
    gradings();
    bad_faults();
    read_outs();
    separate_plies();
    slip();
    given_starts();
    rounding_of_the_host(digest);
    a_led_body();
    failure();
    bands(digest);
    fprintf(stderr, "%d checks hold\n", checks);
    return 0;
}
