/* A C host of libfabric_kernel: prints the digests of the scenes of tests/digests, and tries what only C can ask:
 * buffers at any address; handles, pointers, sizes and lengths that are wrong. Exit code 1 on the first failed check.
 * The target `calls` of tests/fuzz compares calls in any order, and what they read, with the kernel. */
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

/* Numbers of nodes and segments of the small scene; bytes beside a block, and what these and unwritten places hold. */
enum { STEPS = 3000, SIDE = 41, N = 3 * SIDE * SIDE, SEGMENTS = 2 * SIDE * (SIDE - 1), GUARD = 64, PATTERN = 0xc3 };

/* A 41 x 41 piece of the 3 in sheet, hit at 100 m/s: past the first failed segments after 3000 steps. */
static fk_scene small_scene(void)
{
    fk_scene scene = fk_scene_preset(FK_PRESET_SHEET_3IN_SPHERE);
    scene.sheet.nodes_x = scene.sheet.nodes_y = SIDE;
    return scene;
}

/* Whether all of these bytes are this one. */
static int all_are(const void *memory, uint64_t bytes, unsigned char byte)
{
    const unsigned char *first = memory;
    return bytes == 0 || (*first == byte && memcmp(first, first + 1, bytes - 1) == 0);
}

/* A simulation in a block between guard bytes, which need not be aligned, and here never is. */
typedef struct host {
    unsigned char *all, *start;
    uint64_t bytes;
    fk_sim *sim;
} host;

/* What the block held before does not matter. */
static host made(const fk_scene *scene, int held)
{
    host h;
    CHECK(fk_memory_size(scene, &h.bytes) == FK_OK);
    h.all = malloc(h.bytes + 2 * GUARD + 1);
    CHECK(h.all != NULL);
    memset(h.all, PATTERN, h.bytes + 2 * GUARD + 1);
    h.start = h.all + GUARD + 1;
    memset(h.start, held, h.bytes);
    CHECK(fk_init(h.start, h.bytes, scene, &h.sim, NULL, 0) == FK_OK);
    return h;
}

static void let_go(host h)
{
    CHECK(all_are(h.all, GUARD + 1, PATTERN) && all_are(h.start + h.bytes, GUARD, PATTERN));
    free(h.all);
}

static uint64_t digest_of(const fk_sim *sim)
{
    uint64_t digest = 0;
    CHECK(fk_digest(sim, &digest) == FK_OK);
    return digest;
}

/* What the simulation says about its last refused call. */
static void told(const fk_sim *sim, int32_t status, const char *field)
{
    fk_fault last = {0};
    CHECK(fk_get_fault(sim, &last, sizeof last) == FK_OK && last.status == status && strcmp(last.field, field) == 0);
}

/* The digests of the scenes of tests/digests, to be compared with those of the kernel called from Rust. */
static void the_digests_of_every_scene(void)
{
    for (int i = 0; i < TEST_SCENES; i++) {
        fk_scene scene = fk_scene_preset(FK_PRESET_SHEET_3IN_SPHERE);
        host h;
        test_scenes[i].change(&scene);
        CHECK(fk_scene_check(&scene, NULL, 0) == FK_OK);
        h = made(&scene, 0xee);
        CHECK(test_run(h.sim, &scene, test_scenes[i].steps) == FK_OK);
        printf("%s %016llx\n", test_scenes[i].name, (unsigned long long)digest_of(h.sim));
        let_go(h);
    }
}

/* In one go; and step by step up to an image, which goes on in a block that was dirty and stepped, and resets. */
static uint64_t the_same_bits(void)
{
    fk_scene scene = small_scene();
    host h = made(&scene, 0), other = made(&scene, 0xa5);
    fk_counters counters = {0};
    uint64_t expected, bytes = 0, steps;
    unsigned char *image;
    CHECK(fk_advance(h.sim, STEPS) == FK_OK && fk_get_counters(h.sim, &counters, sizeof counters) == FK_OK);
    CHECK(counters.steps == STEPS && counters.failed_segments > 0);
    expected = digest_of(h.sim);
    printf("small %016llx\n", (unsigned long long)expected);

    CHECK(fk_reset(h.sim) == FK_OK);
    for (steps = 0; steps < STEPS / 2; steps++)
        CHECK(fk_step(h.sim) == FK_OK);
    CHECK(fk_state_size(h.sim, &bytes) == FK_OK && (image = malloc(bytes)) != NULL);
    CHECK(fk_state_save(h.sim, image, bytes) == FK_OK && fk_advance(h.sim, STEPS / 2) == FK_OK && digest_of(h.sim) == expected);
    CHECK(fk_advance(other.sim, 7) == FK_OK && fk_state_load(other.sim, image, bytes) == FK_OK);
    CHECK(fk_advance(other.sim, STEPS / 2) == FK_OK && digest_of(other.sim) == expected);
    CHECK(fk_reset(other.sim) == FK_OK && fk_advance(other.sim, STEPS) == FK_OK && digest_of(other.sim) == expected);
    free(image);
    let_go(h);
    let_go(other);
    return expected;
}

/* The smallest sheet there is, and three ways to hand a buffer over, each back and forth. */
static fk_scene smallest;
static int32_t hand_block(fk_sim *sim, unsigned char *start, uint64_t bytes)
{
    fk_sim *another = NULL;
    int32_t status = fk_init(start, bytes, &smallest, &another, NULL, 0);
    CHECK(status == FK_OK ? digest_of(another) == digest_of(sim) : another == NULL);
    CHECK(status != FK_OK || ((unsigned char *)another >= start && (unsigned char *)another < start + 64));
    return status;
}

static int32_t hand_scratch(fk_sim *sim, unsigned char *start, uint64_t bytes)
{
    int32_t status = fk_bands_begin(sim, 2, 0, start, bytes);
    return status == FK_OK ? fk_bands_end(sim) : status;
}

static int32_t hand_image(fk_sim *sim, unsigned char *start, uint64_t bytes)
{
    int32_t status = fk_state_save(sim, start, bytes);
    return status == FK_OK ? fk_state_load(sim, start, bytes) : status;
}

/* Buffers of every length below what is needed are refused, and no byte is written. Of that length they may lie
 * at any address. */
static void short_buffers(void)
{
    enum { ROOM = 1 << 14 };
    static unsigned char all[ROOM + 2 * GUARD];
    int32_t (*const hands[])(fk_sim *, unsigned char *, uint64_t) = {hand_block, hand_scratch, hand_image};
    uint64_t needed[3] = {0, 0, 0}, tried = 0, before, n;
    host h;
    smallest = small_scene();
    smallest.sheet.nodes_x = smallest.sheet.nodes_y = 2;
    h = made(&smallest, 0);
    before = digest_of(h.sim);
    CHECK(fk_memory_size(&smallest, &needed[0]) == FK_OK && fk_bands_size(h.sim, 2, &needed[1]) == FK_OK);
    CHECK(fk_state_size(h.sim, &needed[2]) == FK_OK);
    for (int k = 0; k < 3; k++) {
        CHECK(needed[k] < ROOM);
        memset(all, PATTERN, sizeof all);
        for (n = 0; n < needed[k]; n++, tried++)
            CHECK(hands[k](h.sim, all, n) == FK_SHORT_BUFFER && all_are(all, sizeof all, PATTERN));
        for (n = 0; n < 2 * GUARD; n++) {
            memset(all, PATTERN, sizeof all);
            CHECK(hands[k](h.sim, all + n, needed[k]) == FK_OK && digest_of(h.sim) == before);
            CHECK(all_are(all, n, PATTERN) && all_are(all + n + needed[k], sizeof all - n - needed[k], PATTERN));
        }
    }
    fprintf(stderr, "figure 10: %u short buffers in C, %u refused with nothing written\n", (unsigned)tried, (unsigned)tried);
    let_go(h);
}

/* What the cases of inputs.c cannot say: value, limit and text of a fault, counts beyond 32 bits, sizes, presets. */
static void bad_scenes(void)
{
    fk_scene scene = small_scene();
    fk_fault fault;
    scene.time_step.seconds = 2.7e-8;
    CHECK(fk_scene_check(&scene, &fault, sizeof fault) == FK_STEP_TOO_LARGE && fault.status == FK_STEP_TOO_LARGE);
    CHECK(strcmp(fault.field, "time_step.seconds") == 0 && strstr(fault.text, "the largest allowed is") != NULL);
    CHECK(fault.value == 2.7e-8 && fault.limit > 2.5e-8 && fault.limit < 2.65e-8);
    /* A fault that cannot be written never hides another reason: it is refused first. */
    memset(&fault, PATTERN, sizeof fault);
    CHECK(fk_scene_check(&scene, &fault, sizeof fault - 8) == FK_STRUCT_SIZE);
    CHECK(fk_scene_check(&scene, (fk_fault *)((char *)&fault + 4), sizeof fault) == FK_MISALIGNED);
    CHECK(all_are(&fault, sizeof fault, PATTERN));
    scene = small_scene();
    scene.sheet.nodes_x = (uint64_t)1 << 32;
    CHECK(fk_scene_check(&scene, NULL, 0) == FK_TOO_MANY_NODES);
    scene = small_scene();
    scene.integrator.kind = UINT64_MAX;
    CHECK(fk_scene_check(&scene, NULL, 0) == FK_UNKNOWN_CHOICE);
    scene.struct_size = sizeof scene + 1;
    CHECK(fk_scene_check(&scene, NULL, 0) == FK_STRUCT_SIZE);
    for (uint32_t preset = FK_PRESET_SHEET_3IN_SPHERE; preset <= FK_PRESET_RING_40IN; preset++) {
        scene = fk_scene_preset(preset);
        CHECK(scene.struct_size == sizeof scene && fk_scene_check(&scene, NULL, 0) == FK_OK);
    }
    CHECK(fk_scene_default().sheet.nodes_x == 350 && fk_scene_preset(77).struct_size == 0);
    CHECK(fk_scene_fill(&scene, 12, FK_PRESET_SHEET_3IN_SPHERE) == FK_STRUCT_SIZE);
    CHECK(fk_scene_fill(&scene, sizeof scene, 77) == FK_UNKNOWN_CHOICE);
    CHECK(fk_scene_fill(NULL, sizeof scene, FK_PRESET_SHEET_3IN_SPHERE) == FK_NULL_POINTER);
}

/* Textiles and graded networks: what is bad is named, and changes nothing. */
static void textiles_and_gradings(void)
{
    fk_scene scene = small_scene(), before;
    const uint64_t size = sizeof(fk_textile);
    fk_textile textile = {.warp = {6.67e-5, 1340.0, 0.0}, .weft = {6.67e-5, 1340.0, 0.01}, .fibre_density = 1440.0,
                          .modulus = 84.62e9, .failure_strain = 0.0355, .damage_rate = 2300.0};
    fk_fault fault;
    CHECK(fk_scene_set_textile(&scene, &textile, size, NULL, 0) == FK_OK);
    CHECK(fk_scene_set_back_textile(&scene, &textile, size, NULL, 0) == FK_OK && scene.yarn.critical_stretch == 1.0355);
    CHECK(fabs(scene.sheet.spacing * 1340.0 - 1.0) < 1e-12 && scene.back.modulus_mean == 84.62e9);
    textile.warp.count = 0.0;
    before = scene;
    CHECK(fk_scene_set_textile(&scene, &textile, size, &fault, sizeof fault) == FK_NOT_POSITIVE);
    CHECK(strcmp(fault.field, "textile.warp.count") == 0);
    CHECK(fk_scene_set_textile(&scene, &textile, size - 16, NULL, 0) == FK_STRUCT_SIZE);
    CHECK(fk_scene_set_textile(&scene, NULL, size, NULL, 0) == FK_NULL_POINTER);
    CHECK(fk_scene_set_back_textile(NULL, &textile, size, NULL, 0) == FK_NULL_POINTER);
    CHECK(fk_scene_set_grading(&scene, 0.0, &fault, sizeof fault) == FK_OUT_OF_RANGE && strcmp(fault.field, "error") == 0);
    CHECK(fk_scene_set_grading(NULL, 0.01, NULL, 0) == FK_NULL_POINTER && memcmp(&scene, &before, sizeof scene) == 0);
    scene = fk_scene_preset(FK_PRESET_SHEET_10IN_CYLINDER);
    scene.projectile.position[0] = 0.01;
    CHECK(fk_scene_set_grading(&scene, 0.01, NULL, 0) == FK_OK);
    CHECK(scene.sheet.grading.largest > 1 && scene.sheet.grading.centre[0] == 0.01);
}

#define GET(type, out, get) \
    type out;               \
    CHECK(get(sim, &out, sizeof out) == FK_OK)

/* Until the sheet is perforated: read-outs against each other, as the header says they are. */
static void read_outs(void)
{
    fk_scene scene = small_scene();
    host h = made(&scene, 0);
    fk_sim *sim = h.sim;
    double seconds = 0.0;
    uint64_t steps = 0, taken = 0;
    told(sim, FK_OK, "");
    GET(fk_grid, grid, fk_get_grid);
    CHECK(grid.nodes_x == SIDE && grid.nodes_y == SIDE && grid.horizontal + grid.vertical == SEGMENTS && grid.plies == 1);
    GET(fk_step_limits, limits, fk_get_step_limits);
    CHECK(limits.dt == 0.4 * limits.dt_crit && limits.step_max == 0.5 * limits.dt_crit);
    CHECK(fk_advance_until(sim, FK_ENDS, 50000, &taken) == FK_OK);
    GET(fk_outcome, outcome, fk_get_outcome);
    CHECK(outcome.mask & FK_EXITED && outcome.status == FK_STATUS_FLIGHT && outcome.first_contact == 0);
    CHECK(outcome.step[2] == taken && outcome.work[2] > 0.0 && outcome.step[0] == FK_NEVER && outcome.work[0] == 0.0);
    CHECK(fk_get_time(sim, &steps, &seconds) == FK_OK && steps == taken && seconds == (double)steps * limits.dt);
    GET(fk_motion, motion, fk_get_projectile);
    GET(fk_contact, contact, fk_get_contact);
    GET(fk_energy, energy, fk_get_energy);
    CHECK(motion.velocity[2] > 0.0 && fabs((42.0 - energy.projectile_kinetic) / contact.work - 1.0) < 1e-9);
    CHECK(fabs(scene.projectile.mass * (motion.velocity[2] - 100.0) / contact.impulse[2] - 1.0) < 1e-9);
    CHECK(contact.work == energy.contact_work && contact.loss == energy.contact_loss && contact.force_peak > 0.0);
    GET(fk_support, support, fk_get_support);
    CHECK(support.total[2] > 0.0 && support.attachments[0][2] > 0.0);
    GET(fk_counters, counters, fk_get_counters);
    CHECK(counters.steps == taken && counters.failed_segments > 0 && counters.most_candidates > 0);
    let_go(h);
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
    host h = made(&scene, 0);
    int again, advanced, mode;
    unsigned flushed;
    CHECK(fesetround(FE_UPWARD) == 0);
    flush_subnormals(1);
    again = fk_init(h.start, h.bytes, &scene, &h.sim, NULL, 0);
    advanced = fk_advance(h.sim, STEPS);
    mode = fegetround();
    flushed = flush_subnormals(0);
    CHECK(fesetround(FE_TONEAREST) == 0);
    CHECK(again == FK_OK && advanced == FK_OK && mode == FE_UPWARD && flushed && digest_of(h.sim) == expected);
    let_go(h);
}

static int32_t first_ply(const fk_sim *sim, fk_ply *out, uint64_t size) { return fk_get_ply(sim, 0, out, size); }
static int32_t slip(const fk_sim *sim, fk_slip *out, uint64_t size) { return fk_get_slip(sim, 2e-4, 0.1, 0.0, out, size); }
static int32_t follow(fk_sim *sim, fk_path *path, uint64_t size) { return fk_follow(sim, path, size, 1); }
static int32_t motion(fk_sim *sim, const double *numbers, uint64_t n) { return fk_set_motion(sim, numbers, numbers, n); }

/* Calls with a structure, the second list after a failure too; calls that fill or read an array, and its length. */
#define STRUCTURES(CALL)                                                                                        \
    CALL(fk_step_limits, fk_get_step_limits) CALL(fk_grid, fk_get_grid) CALL(fk_motion, fk_get_projectile)      \
    CALL(fk_contact, fk_get_contact) CALL(fk_support, fk_get_support) CALL(fk_energy, fk_get_energy)            \
    CALL(fk_fabric, fk_get_fabric) CALL(fk_outcome, fk_get_outcome)                                              \
    CALL(fk_ply, first_ply) CALL(fk_slip, slip) CALL(fk_path, follow)
#define AFTER_FAILURES(CALL) CALL(fk_counters, fk_get_counters) CALL(fk_fault, fk_get_fault)
#define COPIES(CALL) \
    CALL(fk_copy_positions, N) CALL(fk_copy_velocities, N) CALL(fk_copy_damage, SEGMENTS) CALL(fk_copy_stretch, SEGMENTS)
#define STARTS(CALL) CALL(motion, N) CALL(fk_set_largest_stretch, SEGMENTS)

static double numbers[N + 2];

#define SAYS(type, get)                                                                                           \
    {                                                                                                             \
        type out;                                                                                                 \
        memset(&out, PATTERN, sizeof out);                                                                        \
        CHECK(get(sim, &out, sizeof out) == status && all_are(&out, sizeof out, PATTERN));                        \
    }
#define SAYS_ARRAY(call, n) CHECK(call(sim, numbers, n) == status);

/* Every call that repeats a failure returns `status` and writes nothing. */
static void every_call_says(fk_sim *sim, int32_t status)
{
    static unsigned char bytes[1 << 18];
    uint64_t count = 7;
    memset(numbers, PATTERN, sizeof numbers);
    memset(bytes, PATTERN, sizeof bytes);
    CHECK(fk_step(sim) == status && fk_advance(sim, 0) == status && fk_advance(sim, 1) == status);
    CHECK(fk_advance_until(sim, 0, 1, &count) == status && fk_advance_until(sim, 0, 0, NULL) == status);
    CHECK(fk_set_external_load(sim, numbers, numbers) == status);
    CHECK(fk_get_time(sim, &count, NULL) == status && fk_get_momentum_residual(sim, numbers) == status);
    STRUCTURES(SAYS)
    COPIES(SAYS_ARRAY)
    STARTS(SAYS_ARRAY)
    CHECK(fk_state_size(sim, &count) == status && fk_state_save(sim, bytes, sizeof bytes) == status);
    CHECK(fk_digest(sim, &count) == status && fk_bands_size(sim, 2, &count) == status && count == 7);
    CHECK(all_are(numbers, sizeof numbers, PATTERN) && all_are(bytes, sizeof bytes, PATTERN));
}

/* So do those that a failure does not stop, */
static void the_others_say(fk_sim *sim, int32_t status)
{
    uint64_t image = 0;
    AFTER_FAILURES(SAYS)
    CHECK(fk_reset(sim) == status && fk_state_load(sim, (unsigned char *)&image, 8) == status);
    CHECK(fk_bands_begin(sim, 2, 0, &image, 8) == status && image == 0);
}

/* and those of bands. */
static void bands_say(fk_sim *sim, int32_t status)
{
    uint64_t passes = 7, steps = 7;
    uint32_t last = 7;
    CHECK(fk_bands_pass(sim, 0, &last) == status && fk_bands_end(sim) == status);
    CHECK(fk_bands_progress(sim, &passes, &steps, &last) == status && passes == 7 && steps == 7 && last == 7);
}

#define REFUSES(type, get)                                                                                        \
    {                                                                                                             \
        const uint64_t size = sizeof(type), wrong[] = {size - 4, size + 8, 0, UINT64_MAX};                        \
        type places[2];                                                                                           \
        memset(places, PATTERN, sizeof places);                                                                   \
        CHECK(get(sim, NULL, size) == FK_NULL_POINTER && get(sim, (type *)((char *)places + 4), size) == FK_MISALIGNED); \
        for (int k = 0; k < 4; k++)                                                                                 \
            CHECK(get(sim, places, wrong[k]) == FK_STRUCT_SIZE && all_are(places, sizeof places, PATTERN));       \
    }
#define REFUSES_ARRAY(call, n)                                                                                    \
    {                                                                                                             \
        const uint64_t wrong[] = {(n) - 1, (n) + 1, 0, UINT64_MAX / 8};                                           \
        CHECK(call(sim, NULL, n) == FK_NULL_POINTER && call(sim, (double *)((char *)numbers + 4), n) == FK_MISALIGNED); \
        for (int k = 0; k < 4; k++)                                                                                 \
            CHECK(call(sim, numbers, wrong[k]) == FK_WRONG_LENGTH && all_are(numbers, sizeof numbers, PATTERN));  \
    }

/* Handles that are none, misaligned or copied; wrong pointers, sizes and lengths: refused, the state as it was. */
static void bad_arguments(void)
{
    const fk_scene scene = small_scene();
    host h = made(&scene, 0);
    fk_sim *sim = h.sim, *none = NULL;
    unsigned char *copy = malloc(h.bytes + 64), *handle = (unsigned char *)sim, *moved;
    const uint64_t before = digest_of(sim), length = h.bytes - (uint64_t)(handle - h.start);
    uint64_t bytes = 7;
    CHECK(copy != NULL);
    moved = copy + (64 - (uintptr_t)copy % 64);
    memcpy(moved, handle, length);
    for (int k = 0; k < 3; k++) {
        fk_sim *const wrong[] = {NULL, (fk_sim *)moved, (fk_sim *)(handle + 8)};
        const int32_t status = k == 0 ? FK_NULL_POINTER : FK_MOVED_BLOCK;
        every_call_says(wrong[k], status);
        the_others_say(wrong[k], status);
        bands_say(wrong[k], status);
    }
    CHECK(memcmp(moved, handle, length) == 0);
    free(copy);
    bands_say(sim, FK_BAND_OUT_OF_TURN);

    CHECK(fk_memory_size(NULL, &bytes) == FK_NULL_POINTER && fk_memory_size(&scene, NULL) == FK_NULL_POINTER);
    CHECK(fk_init(NULL, h.bytes, &scene, &none, NULL, 0) == FK_NULL_POINTER);
    CHECK(fk_init(h.start, h.bytes, NULL, &none, NULL, 0) == FK_NULL_POINTER);
    CHECK(fk_init(h.start, h.bytes, &scene, NULL, NULL, 0) == FK_NULL_POINTER);
    CHECK(fk_init(h.start, h.bytes, (const fk_scene *)((const char *)&scene + 4), &none, NULL, 0) == FK_MISALIGNED && none == NULL);
    STRUCTURES(REFUSES)
    AFTER_FAILURES(REFUSES)
    memset(numbers, PATTERN, sizeof numbers);
    COPIES(REFUSES_ARRAY)
    STARTS(REFUSES_ARRAY)
    told(sim, FK_WRONG_LENGTH, "stretches");
    CHECK(fk_set_motion(sim, numbers, NULL, N) == FK_NULL_POINTER);
    told(sim, FK_NULL_POINTER, "velocities");
    CHECK(fk_get_momentum_residual(sim, NULL) == FK_NULL_POINTER);
    CHECK(fk_get_momentum_residual(sim, (double *)((char *)numbers + 4)) == FK_MISALIGNED);
    CHECK(fk_set_external_load(sim, NULL, numbers) == FK_NULL_POINTER && fk_set_external_load(sim, numbers, NULL) == FK_NULL_POINTER);
    CHECK(fk_state_save(sim, NULL, h.bytes) == FK_NULL_POINTER && fk_state_load(sim, NULL, h.bytes) == FK_NULL_POINTER);
    CHECK(fk_digest(sim, NULL) == FK_NULL_POINTER && fk_state_size(sim, NULL) == FK_NULL_POINTER);
    CHECK(fk_bands_begin(sim, 3, 0, NULL, h.bytes) == FK_NULL_POINTER && fk_bands_begin(sim, 0, 0, numbers, 8) == FK_OUT_OF_RANGE);
    CHECK(fk_bands_size(sim, 0, &bytes) == FK_OUT_OF_RANGE && fk_bands_size(sim, FK_MAX_BANDS + 1, &bytes) == FK_OUT_OF_RANGE);
    CHECK(bytes == 7 && digest_of(sim) == before && fk_get_time(sim, NULL, NULL) == FK_OK && fk_step(sim) == FK_OK);
    let_go(h);
}

/* An external load that makes the projectile too fast: said at once, latched, cleared by load and reset. */
static void failure(void)
{
    const fk_scene scene = small_scene();
    host h = made(&scene, 0);
    fk_sim *sim = h.sim;
    const uint64_t start = digest_of(sim);
    static unsigned char image[1 << 18];
    uint64_t bytes = 0;
    const double force[3] = {1e9, 0, 0}, torque[3] = {0, 0, 0};
    CHECK(fk_state_size(sim, &bytes) == FK_OK && bytes < sizeof image && fk_state_save(sim, image, bytes) == FK_OK);
    for (int k = 0; k < 2; k++) {
        CHECK(fk_set_external_load(sim, force, torque) == FK_OK && fk_advance(sim, 1000) == FK_TOO_FAST);
        every_call_says(sim, FK_TOO_FAST);
        told(sim, FK_TOO_FAST, "");
        GET(fk_counters, counters, fk_get_counters);
        CHECK(counters.steps < 1000);
        CHECK((k == 0 ? fk_state_load(sim, image, bytes) : fk_reset(sim)) == FK_OK && digest_of(sim) == start);
    }
    CHECK(fk_step(sim) == FK_OK);
    let_go(h);
}

/* Bands called one after the other: the same bits; calls out of turn are refused and change nothing. */
static void bands(uint64_t expected)
{
    const fk_scene scene = small_scene();
    host h = made(&scene, 0);
    fk_sim *sim = h.sim;
    uint64_t bytes = 0, passes = 0, steps = 0;
    uint32_t last, outcomes = 7, band;
    unsigned char *scratch;
    CHECK(fk_bands_size(sim, 3, &bytes) == FK_OK && (scratch = malloc(bytes + GUARD)) != NULL);
    memset(scratch, PATTERN, bytes + GUARD);
    CHECK(fk_bands_begin(sim, 3, 0, scratch, bytes) == FK_OK);
    every_call_says(sim, FK_BAND_OUT_OF_TURN);
    the_others_say(sim, FK_BAND_OUT_OF_TURN);
    while (steps < STEPS - 1) {
        for (band = 3; band-- > 0;) {
            CHECK(fk_bands_pass(sim, band, &last) == FK_OK && last == (band == 0));
            CHECK(band == 0 || fk_bands_pass(sim, band, &last) == FK_BAND_OUT_OF_TURN);
        }
        CHECK(fk_bands_pass(sim, 3, &last) == FK_OUT_OF_RANGE);
        CHECK(fk_bands_progress(sim, &passes, &steps, &outcomes) == FK_OK && passes == steps && outcomes == 0);
    }
    CHECK(fk_bands_progress(sim, NULL, NULL, NULL) == FK_OK);
    /* The last step is begun by one band only and completed by the end. */
    CHECK(fk_bands_pass(sim, 1, NULL) == FK_OK && fk_bands_end(sim) == FK_OK && digest_of(sim) == expected);
    CHECK(all_are(scratch + bytes, GUARD, PATTERN));
    free(scratch);
    let_go(h);
}

int main(void)
{
    CHECK(fk_abi_version() == FK_ABI_VERSION && strlen(fk_version()) > 0);
    CHECK(strcmp(fk_status_name(FK_OK), "success") == 0 && strcmp(fk_status_name(-1000), "unknown status") == 0);
    the_digests_of_every_scene();
    const uint64_t digest = the_same_bits();
    bad_arguments();
    short_buffers();
    bad_scenes();
    textiles_and_gradings();
    read_outs();
    rounding_of_the_host(digest);
    failure();
    bands(digest);
    fprintf(stderr, "%d checks hold\n", checks);
    return 0;
}
