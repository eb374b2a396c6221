/* The first program: the paper's 3 in sheet, hit by the 8.4 g sphere at 80 m/s. */
#include <fabric_kernel.h>
#include <stdio.h>
#include <stdlib.h>

int main(void)
{
    fk_scene scene = fk_scene_preset(FK_PRESET_SHEET_3IN_SPHERE);
    scene.projectile.velocity[2] = 80.0;
    uint64_t bytes = 0;
    fk_memory_size(&scene, &bytes);
    fk_sim *sim = NULL;
    fk_fault fault = {0};
    if (fk_init(malloc(bytes), bytes, &scene, &sim, &fault, sizeof fault) != FK_OK) {
        puts(fault.text);
        return 1;
    }
    fk_advance_until(sim, FK_ENDS, 50000, NULL);
    fk_contact contact = {0};
    fk_get_contact(sim, &contact, sizeof contact);
    printf("the fabric took %.2f J\n", contact.work);
}
