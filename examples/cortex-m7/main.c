/* Firmware for a bare Cortex-M7: steps a sheet of 35 x 35 nodes, all yarn drawn, under the sphere of the 3 in preset at 250 m/s, in
 * static memory, and prints its digest and the instructions of a step.
 *
 *     make LIBRARY=path/to/libfabric_kernel.a run       (in this folder; see the Makefile for how to build the library)
 *
 * Flash: the library, board.c and this file. RAM: the block of `memory` below (fk_memory_size says how much of it is used), a
 * few bytes, and a stack of some 6 KiB and what yours takes. Any Cortex-M7 with double-precision floating point and 512 KiB of RAM in one piece will do;
 * an500.ld has the addresses of one board.
 *
 * How the instructions are counted: QEMU with `-icount shift=0` lets 1 ns of its clock pass for each instruction, and the system timer
 * counts that clock at the board's 25 MHz: a tick is 40 instructions. It is a count of instructions, not of time: the
 * emulator knows nothing of caches, wait states or how long a division takes. On a real processor a tick is a
 * cycle: then set INSTRUCTIONS_PER_TICK to 1 and read cycles. */
#include "board.h"
#include "fabric_kernel.h"

enum { NODES = 35, STEPS = 1500, INSTRUCTIONS_PER_TICK = 40 };

static unsigned char memory[320 << 10];

static void write_number(uint64_t number)
{
    char text[21], *at = text + 20;
    *at = 0;
    do
        *--at = (char)('0' + number % 10);
    while ((number /= 10) > 0);
    board_write(at);
}

static void write_digest(uint64_t digest)
{
    char text[17];
    int digit;
    for (digit = 0; digit < 16; digit++)
        text[digit] = "0123456789abcdef"[digest >> (60 - 4 * digit) & 15];
    text[16] = 0;
    board_write(text);
}

static int failed(const char *call, int32_t status)
{
    board_write(call);
    board_write(": ");
    board_write(fk_status_name(status));
    board_write("\n");
    return 1;
}

int main(void)
{
    fk_scene scene = fk_scene_preset(FK_PRESET_SHEET_3IN_SPHERE);
    fk_sim *sim = 0;
    fk_counters counters = {0};
    uint64_t bytes = 0, digest = 0, ticks = 0, most = 0;
    int32_t status;
    int step;
    scene.sheet.nodes_x = NODES;
    scene.sheet.nodes_y = NODES;
    scene.projectile.velocity[2] = 250.0;
    if ((status = fk_memory_size(&scene, &bytes)) != FK_OK)
        return failed("fk_memory_size", status);
    if ((status = fk_init(memory, sizeof memory, &scene, &sim, 0, 0)) != FK_OK)
        return failed("fk_init", status);

    board_timer_start();
    for (step = 1; step <= STEPS; step++) {
        uint32_t now;
        if ((status = fk_step(sim)) != FK_OK)
            return failed("fk_step", status);
        now = board_timer_ticks();
        ticks += now;
        most = now > most ? now : most;
    }
    fk_digest(sim, &digest);
    fk_get_counters(sim, &counters, sizeof counters);

    board_write("digest ");
    write_digest(digest);
    board_write("\nbytes of the simulation ");
    write_number(bytes);
    board_write("\nsegments failed ");
    write_number(counters.failed_segments);
    board_write("\ninstructions a step: mean ");
    write_number(ticks * INSTRUCTIONS_PER_TICK / STEPS);
    board_write(", most ");
    write_number(most * INSTRUCTIONS_PER_TICK);
    board_write("\n");
    return 0;
}
