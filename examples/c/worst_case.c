/* The most that a step can cost, to be run on the machine that has a deadline: a calm sheet, the impact, and a sheet of which
 * every yarn is in the damage zone at once, which takes a square root and an exponential for each segment.
 *
 *     ./worst_case        processor time of a step, us: mean over 50 steps, and the longest such mean
 */
#include <fabric_kernel.h>

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { BATCH = 50, BATCHES = 20 };

static void ask(int32_t status, const char *call)
{
    if (status == FK_OK)
        return;
    fprintf(stderr, "%s: %s\n", call, fk_status_name(status));
    exit(1);
}

/* Every node moved away from the middle, so that every segment has this stretch: beyond the critical 1.03. */
static void stretch(fk_sim *sim, double factor)
{
    fk_grid grid = {0};
    double *x, *v;
    uint64_t n, i;
    ask(fk_get_grid(sim, &grid, sizeof grid), "fk_get_grid");
    n = 3 * grid.nodes_x * grid.nodes_y;
    x = malloc(n * sizeof *x);
    v = calloc(n, sizeof *v);
    if (x == NULL || v == NULL)
        exit(1);
    ask(fk_copy_positions(sim, x, n), "fk_copy_positions");
    for (i = 0; i < n; i++)
        x[i] *= factor;
    ask(fk_set_motion(sim, x, v, n), "fk_set_motion");
    free(x);
    free(v);
}

static void measure(const char *name, fk_sim *sim)
{
    fk_counters counters = {0};
    double longest = 0.0, sum = 0.0;
    int batch;
    for (batch = 0; batch < BATCHES; batch++) {
        const clock_t start = clock();
        double us;
        ask(fk_advance(sim, BATCH), "fk_advance");
        us = 1e6 * (double)(clock() - start) / CLOCKS_PER_SEC / BATCH;
        sum += us;
        longest = us > longest ? us : longest;
    }
    ask(fk_get_counters(sim, &counters, sizeof counters), "fk_get_counters");
    printf("%-28s mean %7.1f us, longest %7.1f us, most sweeps %llu, failed %llu\n", name, sum / BATCHES, longest,
           (unsigned long long)counters.most_sweeps, (unsigned long long)counters.failed_segments);
}

int main(void)
{
    const uint32_t presets[] = {FK_PRESET_SHEET_3IN_SPHERE, FK_PRESET_SHEET_10IN_CYLINDER};
    int p;
    for (p = 0; p < 2; p++) {
        fk_scene scene = fk_scene_preset(presets[p]);
        fk_sim *sim = NULL;
        uint64_t bytes = 0;
        void *memory;
        scene.attachment.kind = FK_ATTACHMENT_FOUR_SIDES;
        ask(fk_memory_size(&scene, &bytes), "fk_memory_size");
        if ((memory = malloc(bytes)) == NULL)
            return 1;
        printf("%u x %u nodes, %.2f MB\n", (unsigned)scene.sheet.nodes_x, (unsigned)scene.sheet.nodes_y, 1e-6 * (double)bytes);
        ask(fk_init(memory, bytes, &scene, &sim, NULL, 0), "fk_init");
        stretch(sim, 1.01);
        measure("  taut, whole, with contact", sim);
        ask(fk_reset(sim), "fk_reset");
        measure("  impact, first 1000 steps", sim);
        ask(fk_reset(sim), "fk_reset");
        stretch(sim, 1.035);
        measure("  all in the damage zone", sim);
        free(memory);
    }
    return 0;
}
