/* Runs every scene of scenes.h through the C interface and prints a line "name digest" each: the same file on every
 * target of `cargo xtask digests`, with or without an operating system. All memory is static. */
#include "digests.h"

#include "fabric_kernel.h"
#include "scenes.h"

/* Only in libraries built with the feature `choose-instructions`: FK_UNKNOWN_CHOICE if this machine lacks the set. */
int32_t fk_use_instructions(fk_sim *sim, uint32_t set);

/* What the largest scene needs, and some more. */
static unsigned char memory[6 << 16];

static int said(const char *name, const char *what, int32_t status)
{
    write_text(name);
    write_text(": ");
    write_text(what);
    write_text(": ");
    write_text(fk_status_name(status));
    write_text("\n");
    return 1;
}

int print_digests(void)
{
    int i, digit;
    for (i = 0; i < TEST_SCENES; i++) {
        const test_scene *test = &test_scenes[i];
        fk_scene scene = fk_scene_preset(FK_PRESET_SHEET_3IN_SPHERE);
        fk_sim *sim = 0;
        uint64_t digest = 0;
        char text[18];
        int32_t status;
        test->change(&scene);
        status = fk_init(memory, sizeof memory, &scene, &sim, 0, 0);
        if (status != FK_OK)
            return said(test->name, "init", status);
#ifdef INSTRUCTIONS
        status = fk_use_instructions(sim, INSTRUCTIONS);
        if (status != FK_OK)
            return said(test->name, "this machine lacks the instructions", status);
#endif
        status = test_run(sim, &scene, test->steps);
        if (status != FK_OK)
            return said(test->name, "run", status);
        status = fk_digest(sim, &digest);
        if (status != FK_OK)
            return said(test->name, "digest", status);
        for (digit = 0; digit < 16; digit++)
            text[digit] = "0123456789abcdef"[digest >> (60 - 4 * digit) & 15];
        text[16] = '\n';
        text[17] = 0;
        write_text(test->name);
        write_text(" ");
        write_text(text);
    }
    return 0;
}
