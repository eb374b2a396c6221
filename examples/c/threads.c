/* One simulation on several threads of the host's own: every thread sweeps a band of the sheet's rows.
 *
 *     cargo build --profile ship -p capi-lib --features bare
 *     cc -O2 -Iinclude examples/c/threads.c target/ship/libfabric_kernel.a -pthread -o threads
 *     ./threads THREADS [NODES [STEPS]]
 *
 * Prints the state's digest; it does not depend on the number of threads. The library starts no thread and waits for none.
 * Once a pass all threads meet, and the meeting is the host's: here they spin briefly, which is quickest while all are at
 * work, then park on a condition variable, so that a busy machine loses no more than a switch. */
#define _POSIX_C_SOURCE 200809L
#include "fabric_kernel.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { SPINS = 2000 };

/* What all threads share. */
typedef struct crew {
    fk_sim *sim;
    uint64_t steps;
    uint32_t outcomes; /* any of these ends the run */
    pthread_mutex_t lock;
    pthread_cond_t passed;
} crew;

typedef struct member {
    crew *crew;
    uint32_t band;
    int32_t status;
    pthread_t thread;
} member;

static void require(int32_t status, const char *call)
{
    if (status != FK_OK) {
        fprintf(stderr, "%s: %s\n", call, fk_status_name(status));
        exit(1);
    }
}

static uint64_t passes_of(const crew *c)
{
    uint64_t passes = 0;
    fk_bands_progress(c->sim, &passes, NULL, NULL);
    return passes;
}

/* Wakes those that parked. Under the lock, so that nobody parks between a last look and the call. */
static void wake(crew *c)
{
    pthread_mutex_lock(&c->lock);
    pthread_cond_broadcast(&c->passed);
    pthread_mutex_unlock(&c->lock);
}

/* Returns when more than `passes` passes are complete. */
static void wait_for_others(crew *c, uint64_t passes)
{
    int spins;
    for (spins = 0; spins < SPINS; spins++)
        if (passes_of(c) > passes)
            return;
    pthread_mutex_lock(&c->lock);
    while (passes_of(c) == passes)
        pthread_cond_wait(&c->passed, &c->lock);
    pthread_mutex_unlock(&c->lock);
}

/* One thread: its band's part of every pass. A failure ends it: the last band gets it first, the others at their next turn. */
static void *work(void *argument)
{
    member *m = argument;
    crew *c = m->crew;
    for (;;) {
        uint64_t passes, steps;
        uint32_t outcomes, last;
        /* Stands still until this thread's band has been called: all threads see the same and end after the same step. */
        m->status = fk_bands_progress(c->sim, &passes, &steps, &outcomes);
        if (m->status != FK_OK || steps >= c->steps || (outcomes & c->outcomes) != 0)
            return NULL;
        m->status = fk_bands_pass(c->sim, m->band, &last);
        if (m->status != FK_OK) {
            wake(c);
            return NULL;
        }
        if (last)
            wake(c);
        else
            wait_for_others(c, passes);
    }
}

/* A zero-terminated number or the default. */
static uint64_t number(int argc, char **argv, int index, uint64_t otherwise)
{
    return argc > index ? strtoull(argv[index], NULL, 10) : otherwise;
}

static void *allocated(uint64_t bytes)
{
    void *memory = malloc(bytes);
    if (memory == NULL) {
        fprintf(stderr, "no memory\n");
        exit(1);
    }
    return memory;
}

int main(int argc, char **argv)
{
    const uint32_t threads = (uint32_t)number(argc, argv, 1, 2);
    const uint32_t nodes = (uint32_t)number(argc, argv, 2, 41);
    fk_scene scene = fk_scene_preset(FK_PRESET_SHEET_3IN_SPHERE);
    fk_sim *sim = NULL;
    uint64_t bytes = 0, scratch_bytes = 0, digest = 0, taken = 0;
    void *block, *scratch;
    member members[FK_MAX_BANDS];
    uint32_t band;
    struct timespec start, end;
    crew c;

    scene.sheet.nodes_x = nodes;
    scene.sheet.nodes_y = nodes;
    require(fk_memory_size(&scene, &bytes), "fk_memory_size");
    block = allocated(bytes);
    require(fk_init(block, bytes, &scene, &sim, NULL, 0), "fk_init");

    require(fk_bands_size(sim, threads, &scratch_bytes), "fk_bands_size");
    scratch = allocated(scratch_bytes);
    c.steps = number(argc, argv, 3, 3000);
    require(fk_bands_begin(sim, threads, c.steps, scratch, scratch_bytes), "fk_bands_begin");
    c.sim = sim;
    c.outcomes = 0;
    pthread_mutex_init(&c.lock, NULL);
    pthread_cond_init(&c.passed, NULL);

    clock_gettime(CLOCK_MONOTONIC, &start);
    for (band = 0; band < threads; band++) {
        members[band].crew = &c;
        members[band].band = band;
        if (pthread_create(&members[band].thread, NULL, work, &members[band]) != 0) {
            fprintf(stderr, "no thread\n");
            return 1;
        }
    }
    for (band = 0; band < threads; band++)
        pthread_join(members[band].thread, NULL);
    clock_gettime(CLOCK_MONOTONIC, &end);

    /* No thread is in a call any more: the simulation goes back to the other calls. */
    require(fk_bands_end(sim), "fk_bands_end");
    require(fk_get_time(sim, &taken, NULL), "fk_get_time");
    require(fk_digest(sim, &digest), "fk_digest");
    fprintf(stderr, "%u threads, %u x %u nodes, %llu steps: %.2f ns per node-step (wall time)\n", (unsigned)threads,
            (unsigned)nodes, (unsigned)nodes, (unsigned long long)taken,
            ((double)(end.tv_sec - start.tv_sec) * 1e9 + (double)(end.tv_nsec - start.tv_nsec)) /
                ((double)nodes * (double)nodes * (double)taken));
    printf("%016llx\n", (unsigned long long)digest);

    pthread_cond_destroy(&c.passed);
    pthread_mutex_destroy(&c.lock);
    free(scratch);
    free(block);
    return 0;
}
