/* An impact, watched: a preset, a step loop, one line of CSV every microsecond.
 *
 *     ./impact 80 > impact.csv        the 3 in sheet, the 8.4 g sphere at 80 m/s
 *
 * Exit code 1 if the scene is refused, 2 if the run fails or its energy balance does not close. */
#include <fabric_kernel.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* The memory of one simulation: what fk_memory_size asks for, at a multiple of the alignment it asks for. */
typedef struct block {
    void *all;
    void *start;
    uint64_t bytes;
} block;

static int allocate(block *memory, const fk_scene *scene)
{
    uint64_t align = 0;
    if (fk_memory_size(scene, &memory->bytes, &align) != FK_OK)
        return 0;
    memory->all = malloc(memory->bytes + align);
    if (memory->all == NULL)
        return 0;
    memory->start = (char *)memory->all + (align - (uintptr_t)memory->all % align);
    return 1;
}

static int line(fk_sim *sim, const char *outcome)
{
    fk_motion projectile = {.struct_size = sizeof projectile};
    fk_contact contact = {.struct_size = sizeof contact};
    fk_fabric fabric = {.struct_size = sizeof fabric};
    fk_counters counters = {.struct_size = sizeof counters};
    double seconds = 0.0;
    int32_t status;
    if ((status = fk_get_time(sim, NULL, &seconds)) != FK_OK || (status = fk_get_projectile(sim, &projectile)) != FK_OK
        || (status = fk_get_contact(sim, &contact)) != FK_OK || (status = fk_get_fabric(sim, &fabric)) != FK_OK
        || (status = fk_get_counters(sim, &counters)) != FK_OK)
        return status;
    printf("%.2f,%.4f,%.4f,%.3f,%llu,%s\n", 1e6 * seconds, projectile.velocity[2], contact.work,
           1e3 * fabric.max_deflection, (unsigned long long)counters.failed_segments, outcome);
    return FK_OK;
}

int main(int argc, char **argv)
{
    static const char *const names[] = {"flight", "contact", "arrested", "detached", "exited", "passed"};
    fk_scene scene;
    fk_fault fault = {.struct_size = sizeof fault};
    fk_step_limits limits = {.struct_size = sizeof limits};
    fk_outcome outcome = {.struct_size = sizeof outcome};
    fk_energy start = {.struct_size = sizeof start}, end = {.struct_size = sizeof end};
    fk_sim *sim = NULL;
    block memory = {NULL, NULL, 0};
    uint64_t a_microsecond;
    int i;

    fk_scene_preset(&scene, sizeof scene, FK_PRESET_SHEET_3IN_SPHERE);
    scene.projectile_velocity[2] = argc > 1 ? atof(argv[1]) : 80.0;
    if (fk_scene_check(&scene, &fault) != FK_OK) {
        fprintf(stderr, "%s\n", fault.text); /* names the field and what is wrong with it */
        return 1;
    }
    if (!allocate(&memory, &scene) || fk_init(memory.start, memory.bytes, &scene, &sim, &fault) != FK_OK) {
        fprintf(stderr, "%s\n", memory.all == NULL ? "no memory" : fault.text);
        return 1;
    }
    if (fk_get_step_limits(sim, &limits) != FK_OK || fk_get_energy(sim, &start) != FK_OK)
        return 2;
    a_microsecond = (uint64_t)(1e-6 / limits.dt + 0.5);

    printf("us,velocity,absorbed_J,deflection_mm,failed,status\n");
    for (i = 0; i < 1000; i++) {
        if (fk_advance(sim, a_microsecond) != FK_OK || fk_get_outcome(sim, &outcome) != FK_OK
            || line(sim, names[outcome.status]) != FK_OK) {
            fk_get_fault(sim, &fault);
            fprintf(stderr, "%s\n", fault.text);
            return 2;
        }
        if (outcome.mask & (FK_ARRESTED | FK_EXITED | FK_PASSED))
            break;
    }

    /* The run is sound if its energies add up: docs/stability.md. */
    if (fk_get_energy(sim, &end) != FK_OK || fabs(end.residual) > 0.01 * start.projectile_kinetic) {
        fprintf(stderr, "the energies do not add up by %g J\n", end.residual);
        return 2;
    }
    free(memory.all); /* there is nothing to destroy */
    return 0;
}
