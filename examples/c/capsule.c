/* A capsule: a log of what this program does to a simulation, written to a file, read back, done again and compared bit by bit.
 * `capsule FILE` writes FILE (run.capsule without one) and replays it, `capsule FILE replay` replays one of another machine; `fabric replay
 * FILE` and the web page do so, too. */
#include <fabric_kernel.h>
#include <stdio.h>
#include <stdlib.h>

static uint8_t log_memory[65536], file[65536];

static fk_sim *simulation(const fk_scene *scene)
{
    uint64_t bytes = 0;
    fk_sim *sim = NULL;
    if (fk_memory_size(scene, &bytes) != FK_OK || fk_init(malloc(bytes), bytes, scene, &sim, NULL, 0) != FK_OK) {
        puts("no simulation");
        exit(1);
    }
    return sim;
}

/* Writes a capsule into a file; the number of its bytes, or 0. */
static uint64_t written(const char *name)
{
    fk_scene scene = fk_scene_preset(FK_PRESET_SHEET_3IN_SPHERE);
    scene.projectile.velocity[2] = 80.0;
    fk_sim *sim = simulation(&scene);
    fk_capsule_begin(sim, log_memory, sizeof log_memory, 10);

    /* A host that steps, and pulls at the sphere as it goes. */
    double force[3] = {0.0, 0.0, 0.0}, torque[3] = {0.0, 0.0, 0.0};
    for (int call = 0; call < 30; ++call) {
        force[0] = 0.5 * call;
        fk_set_external_load(sim, force, torque);
        fk_advance(sim, 40);
    }
    uint64_t used = 0;
    if (fk_capsule_end(sim, &used) != FK_OK) {
        puts("the capsule does not fit its memory");
        return 0;
    }
    FILE *out = fopen(name, "wb");
    return out && fwrite(log_memory, 1, used, out) == used && fclose(out) == 0 ? used : 0;
}

int main(int count, char **arguments)
{
    const char *name = count > 1 ? arguments[1] : "run.capsule";
    if (count < 3 && written(name) == 0) {
        puts("the capsule cannot be written");
        return 1;
    }
    FILE *in = fopen(name, "rb");
    const uint64_t read = in ? fread(file, 1, sizeof file, in) : 0;
    fk_scene found = fk_scene_default();
    fk_capsule about = {0};
    if (fk_capsule_read(file, read, &found, sizeof found, &about, sizeof about) != FK_OK) {
        printf("not a capsule: byte %llu\n", (unsigned long long)about.broken_at);
        return 1;
    }
    fk_sim *again = simulation(&found);
    fk_replayed replay = {0};
    fk_replay(again, file, read, about.steps, NULL, 0, &replay, sizeof replay);
    uint64_t digest = 0;
    fk_digest(again, &digest);
    printf("%s, %llu calls, %llu steps, %llu digests, the last %016llx\n", replay.end == FK_REPLAY_SAME ? "same bits" : "differs",
           (unsigned long long)replay.at.calls, (unsigned long long)replay.at.steps, (unsigned long long)replay.at.digests,
           (unsigned long long)digest);
    return replay.end == FK_REPLAY_SAME ? 0 : 1;
}
