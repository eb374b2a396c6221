/* A host of the first release, kept with its header: it must run with every later library. Every structure it hands over has
 * guard bytes behind it, which a library with longer structures must not touch. Never changed. */
#include "fabric_kernel.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHECK(condition)                                                                  \
    do {                                                                                  \
        if (!(condition)) {                                                               \
            fprintf(stderr, "%s:%d: %s does not hold\n", __FILE__, __LINE__, #condition); \
            exit(1);                                                                      \
        }                                                                                 \
    } while (0)

enum { GUARD = 256 };

/* A structure and what lies behind it. */
#define GUARDED(type, name)               \
    struct {                              \
        type it;                          \
        unsigned char behind[GUARD];      \
    } name;                               \
    memset(&name, 0, sizeof name.it);     \
    memset(name.behind, 0xc3, GUARD)

static void untouched(const unsigned char *behind)
{
    size_t i;
    for (i = 0; i < GUARD; i++)
        CHECK(behind[i] == 0xc3);
}

#define KEEPS(name) untouched(name.behind)

static void *memory;

static fk_sim *made(const fk_scene *scene, fk_fault *fault)
{
    uint64_t bytes = 0;
    fk_sim *sim = NULL;
    CHECK(fk_memory_size(scene, &bytes) == FK_OK);
    memory = malloc(bytes);
    CHECK(memory != NULL);
    CHECK(fk_init(memory, bytes, scene, &sim, fault, sizeof *fault) == FK_OK);
    return sim;
}

int main(void)
{
    fk_sim *sim;
    uint64_t digest = 0, steps = 0;
    double seconds = 0.0;
    GUARDED(fk_scene, scene);
    GUARDED(fk_fault, fault);
    GUARDED(fk_step_limits, limits);
    GUARDED(fk_grid, grid);
    GUARDED(fk_motion, motion);
    GUARDED(fk_contact, contact);
    GUARDED(fk_support, support);
    GUARDED(fk_energy, energy);
    GUARDED(fk_fabric, fabric);
    GUARDED(fk_counters, counters);
    GUARDED(fk_outcome, outcome);
    GUARDED(fk_path, path);

    /* A later library knows more, never less. */
    CHECK(fk_abi_version() >= FK_ABI_VERSION);
    CHECK(fk_scene_fill(&scene.it, sizeof scene.it, FK_PRESET_SHEET_3IN_SPHERE) == FK_OK);
    CHECK(scene.it.struct_size == sizeof scene.it);
    KEEPS(scene);
    scene.it.sheet.nodes_x = 41;
    scene.it.sheet.nodes_y = 41;
    scene.it.sheet.plies = 0;
    CHECK(fk_scene_check(&scene.it, &fault.it, sizeof fault.it) == FK_OUT_OF_RANGE);
    CHECK(fault.it.status == FK_OUT_OF_RANGE && strcmp(fault.it.field, "sheet.plies") == 0);
    KEEPS(fault);
    scene.it.sheet.plies = 1;
    CHECK(fk_scene_check(&scene.it, &fault.it, sizeof fault.it) == FK_OK);

    sim = made(&scene.it, &fault.it);
    CHECK(fk_advance(sim, 3000) == FK_OK);
    CHECK(fk_get_time(sim, &steps, &seconds) == FK_OK && steps == 3000 && seconds > 0.0);
    CHECK(fk_get_step_limits(sim, &limits.it, sizeof limits.it) == FK_OK && limits.it.dt == 0.4 * limits.it.dt_crit);
    KEEPS(limits);
    CHECK(fk_get_grid(sim, &grid.it, sizeof grid.it) == FK_OK && grid.it.vertical == 40 * 41);
    KEEPS(grid);
    CHECK(fk_get_projectile(sim, &motion.it, sizeof motion.it) == FK_OK && motion.it.velocity[2] < 100.0);
    KEEPS(motion);
    CHECK(fk_get_contact(sim, &contact.it, sizeof contact.it) == FK_OK && contact.it.force_peak > 0.0);
    KEEPS(contact);
    CHECK(fk_get_support(sim, &support.it, sizeof support.it) == FK_OK && support.it.attachments[3][2] > 0.0);
    KEEPS(support);
    CHECK(fk_get_energy(sim, &energy.it, sizeof energy.it) == FK_OK && energy.it.contact_work == contact.it.work);
    KEEPS(energy);
    CHECK(fk_get_fabric(sim, &fabric.it, sizeof fabric.it) == FK_OK && fabric.it.max_stretch > 1.0);
    KEEPS(fabric);
    CHECK(fk_get_counters(sim, &counters.it, sizeof counters.it) == FK_OK && counters.it.steps == 3000);
    KEEPS(counters);
    CHECK(fk_get_outcome(sim, &outcome.it, sizeof outcome.it) == FK_OK && outcome.it.first_contact == 0);
    KEEPS(outcome);
    CHECK(fk_get_fault(sim, &fault.it, sizeof fault.it) == FK_OK && fault.it.status == FK_OK);
    KEEPS(fault);
    CHECK(fk_digest(sim, &digest) == FK_OK);
    printf("small %016llx\n", (unsigned long long)digest);
    /* A size that no release had. */
    CHECK(fk_get_counters(sim, &counters.it, sizeof counters.it - 1) == FK_STRUCT_SIZE);
    free(memory);

    scene.it.drive = FK_DRIVE_PRESCRIBED;
    sim = made(&scene.it, NULL);
    CHECK(fk_get_projectile(sim, &motion.it, sizeof motion.it) == FK_OK);
    path.it.steps = 100;
    path.it.end = motion.it;
    path.it.end.position[2] += 1e-4;
    CHECK(fk_follow(sim, &path.it, sizeof path.it, 100) == FK_OK);
    CHECK(fk_get_contact(sim, &contact.it, sizeof contact.it) == FK_OK && contact.it.work > 0.0);
    KEEPS(path);
    free(memory);
    return 0;
}
