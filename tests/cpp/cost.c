/* What a host's loop costs through the C interface: tests/cpp/cost.cpp is the same loop through the C++ header. Counted by
 * callgrind inside measured(). */
#include "fabric_kernel.h"

#include <stdio.h>
#include <stdlib.h>

enum { ROUNDS = 500 };

__attribute__((noinline)) double measured(fk_sim *sim)
{
    double sum = 0.0;
    int i;
    for (i = 0; i < ROUNDS; i++) {
        fk_contact contact = {0};
        fk_motion projectile = {0};
        uint64_t steps = 0;
        double seconds = 0.0;
        if (fk_step(sim) != FK_OK || fk_get_contact(sim, &contact, sizeof contact) != FK_OK || fk_get_projectile(sim, &projectile, sizeof projectile) != FK_OK
            || fk_get_time(sim, &steps, &seconds) != FK_OK)
            return -1.0;
        sum += contact.work + projectile.velocity[2] * seconds;
    }
    return sum;
}

int main(void)
{
    fk_scene scene = fk_scene_preset(FK_PRESET_SHEET_3IN_SPHERE);
    fk_sim *sim = NULL;
    uint64_t bytes = 0;
    void *memory;
    scene.sheet.nodes_x = scene.sheet.nodes_y = 21;
    if (fk_memory_size(&scene, &bytes) != FK_OK || (memory = malloc(bytes)) == NULL
        || fk_init(memory, bytes, &scene, &sim, NULL, 0) != FK_OK)
        return 1;
    printf("%.17g\n", measured(sim));
    free(memory);
    return 0;
}
