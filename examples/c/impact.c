/* An impact, watched: a preset, a step loop, one line of CSV every microsecond.
 *
 *     ./impact 80 > impact.csv        the 3 in sheet, the 8.4 g sphere at 80 m/s
 *
 * Exit code 1 if the scene is refused, 2 if the run fails or its energy balance does not close. */
#include <fabric_kernel.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static int line(fk_sim *sim, const char *outcome)
{
    fk_motion projectile = {0};
    fk_contact contact = {0};
    fk_fabric fabric = {0};
    fk_counters counters = {0};
    double seconds = 0.0;
    int32_t status;
    if ((status = fk_get_time(sim, NULL, &seconds)) != FK_OK || (status = fk_get_projectile(sim, &projectile, sizeof projectile)) != FK_OK
        || (status = fk_get_contact(sim, &contact, sizeof contact)) != FK_OK || (status = fk_get_fabric(sim, &fabric, sizeof fabric)) != FK_OK
        || (status = fk_get_counters(sim, &counters, sizeof counters)) != FK_OK)
        return status;
    printf("%.2f,%.4f,%.4f,%.3f,%llu,%s\n", 1e6 * seconds, projectile.velocity[2], contact.work,
           1e3 * fabric.max_deflection, (unsigned long long)counters.failed_segments, outcome);
    return FK_OK;
}

/* What has happened, or what is true now. */
static const char *name(const fk_outcome *outcome)
{
    if (outcome->mask & FK_ARRESTED)
        return "arrested";
    if (outcome->mask & FK_REBOUNDED)
        return "rebounded";
    if (outcome->mask & FK_EXITED)
        return "exited";
    if (outcome->mask & FK_PASSED)
        return "passed";
    return outcome->status == FK_STATUS_CONTACT ? "contact" : "flight";
}

int main(int argc, char **argv)
{
    fk_scene scene = fk_scene_preset(FK_PRESET_SHEET_3IN_SPHERE);
    fk_fault fault = {0};
    fk_step_limits limits = {0};
    fk_outcome outcome = {0};
    fk_energy start = {0}, end = {0};
    fk_sim *sim = NULL;
    void *memory;
    uint64_t a_microsecond, bytes = 0;
    int i;

    scene.projectile.velocity[2] = argc > 1 ? atof(argv[1]) : 80.0;
    if (fk_scene_check(&scene, &fault, sizeof fault) != FK_OK) {
        fprintf(stderr, "%s\n", fault.text); /* names the field and what is wrong with it */
        return 1;
    }
    fk_memory_size(&scene, &bytes);
    memory = malloc(bytes);
    if (memory == NULL || fk_init(memory, bytes, &scene, &sim, &fault, sizeof fault) != FK_OK) {
        fprintf(stderr, "%s\n", memory == NULL ? "no memory" : fault.text);
        return 1;
    }
    if (fk_get_step_limits(sim, &limits, sizeof limits) != FK_OK || fk_get_energy(sim, &start, sizeof start) != FK_OK)
        return 2;
    a_microsecond = (uint64_t)(1e-6 / limits.dt + 0.5);

    printf("us,velocity,absorbed_J,deflection_mm,failed,status\n");
    for (i = 0; i < 1000; i++) {
        if (fk_advance(sim, a_microsecond) != FK_OK || fk_get_outcome(sim, &outcome, sizeof outcome) != FK_OK
            || line(sim, name(&outcome)) != FK_OK) {
            fk_get_fault(sim, &fault, sizeof fault);
            fprintf(stderr, "%s\n", fault.text);
            return 2;
        }
        if (outcome.mask & FK_ENDS)
            break;
    }

    /* The run is sound if its energies add up: docs/accuracy.md. */
    if (fk_get_energy(sim, &end, sizeof end) != FK_OK || fabs(end.residual) > 0.01 * start.projectile_kinetic) {
        fprintf(stderr, "the energies do not add up by %g J\n", end.residual);
        return 2;
    }
    free(memory); /* there is nothing to destroy */
    return 0;
}
