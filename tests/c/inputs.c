/* Every case of tests/inputs/cases through the C interface: its exact status and field, and nothing written when refused.
 * Usage: inputs FILE. Exit code 1 if a case is answered otherwise. */
#include "fabric_kernel.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Where each number of fk_scene is. */
static const struct place {
    const char *structure, *member;
    size_t at, bytes;
} places[] = {
#define SIZE(structure, bytes)
#define FIELD(structure, member, at, bytes) {#structure, #member, at, bytes},
#include "abi/layout.inc"
};

enum { PLACES = sizeof places / sizeof places[0], LINES = 4096, MEMORY = 1 << 19, NODES = 100, PATTERN = 0x33 };

/* How often each place was given a value. */
static unsigned tried[PLACES];

typedef struct line {
    char kind[8], base[16], name[40], member[40], field[40];
    uint64_t bits;
    int status;
} line;

static line lines[LINES];

static void give_up(const char *what, const line *l)
{
    fprintf(stderr, "%s: %s %s\n", what, l->base, l->name);
    exit(1);
}

/* Gives a member of a scene, "sheet_position[2]", a value. */
static void assign(fk_scene *scene, const line *l)
{
    char member[40];
    unsigned k = 0, j = 0;
    size_t i, at;
    double value;
    char *index;
    memcpy(&value, &l->bits, sizeof value);
    strcpy(member, l->member);
    index = strchr(member, '[');
    if (index != NULL) {
        if (sscanf(index, "[%u][%u]", &k, &j) == 2)
            k = 4 * k + j;
        *index = '\0';
    }
    for (i = 0; i < PLACES; i++)
        if (strcmp(places[i].structure, "fk_scene") == 0 && strcmp(places[i].member, member) == 0)
            break;
    if (i == PLACES)
        give_up("no such member", l);
    tried[i]++;
    at = places[i].at + 8 * k;
    if (places[i].bytes == 4) {
        uint32_t count = (uint32_t)value;
        memcpy((char *)scene + at, &count, sizeof count);
    } else if (strcmp(member, "seed") == 0) {
        uint64_t count = (uint64_t)value;
        memcpy((char *)scene + at, &count, sizeof count);
    } else {
        memcpy((char *)scene + at, &value, sizeof value);
    }
}

/* Whether the block holds its pattern and nothing else. */
static int untouched(const unsigned char *memory)
{
    return memory[0] == PATTERN && memcmp(memory, memory + 1, MEMORY - 1) == 0;
}

/* Whether a scene is answered as the case says; what is refused is refused by fk_init, and writes nothing. */
static int answered(const fk_scene *scene, const line *l)
{
    static unsigned char all[MEMORY + 64];
    unsigned char *memory = all + (64 - (uintptr_t)all % 64);
    fk_fault fault = {.struct_size = sizeof fault};
    fk_sim *sim = NULL;
    uint64_t bytes = 7, align = 7;
    int32_t status, sized = fk_memory_size(scene, &bytes, &align);
    int large = scene->sheet_nodes_x > NODES || scene->sheet_nodes_y > NODES;
    if (sized != FK_OK && (sized != l->status || bytes != 7 || align != 7))
        return 0;
    if (large)
        return sized == l->status;
    memset(memory, PATTERN, MEMORY);
    status = fk_init(memory, MEMORY, scene, &sim, &fault);
    if (status != l->status || fault.status != status)
        return 0;
    if (status == FK_OK) {
        int32_t advanced = fk_advance(sim, 3);
        return advanced == FK_OK || advanced <= FK_NON_FINITE;
    }
    return sim == NULL && strcmp(fault.field, l->field) == 0 && strstr(fault.text, l->field) != NULL && untouched(memory);
}

int main(int count, char **arguments)
{
    FILE *file = count == 2 ? fopen(arguments[1], "r") : NULL;
    unsigned n = 0, i, k, cases = 0, exact = 0;
    char text[256];
    if (file == NULL) {
        fprintf(stderr, "usage: inputs tests/inputs/cases\n");
        return 1;
    }
    while (fgets(text, sizeof text, file) != NULL && n < LINES) {
        line *l = &lines[n];
        unsigned long long bits = 0;
        const char *form = "%7s %15s %39s %39s %llx %d %39s";
        int read = sscanf(text, form, l->kind, l->base, l->name, l->member, &bits, &l->status, l->field);
        l->bits = bits;
        n += read == 7 || (read == 5 && strcmp(l->kind, "set") == 0);
    }
    fclose(file);
    for (i = 0; i < n; i++) {
        fk_scene scene;
        if (strcmp(lines[i].kind, "case") != 0)
            continue;
        if (fk_scene_preset(&scene, sizeof scene, FK_PRESET_SHEET_3IN_SPHERE) != FK_OK)
            give_up("no preset", &lines[i]);
        for (k = 0; k < n; k++)
            if (strcmp(lines[k].kind, "set") == 0 && strcmp(lines[k].base, lines[i].base) == 0)
                assign(&scene, &lines[k]);
        assign(&scene, &lines[i]);
        cases++;
        if (answered(&scene, &lines[i]))
            exact++;
        else
            fprintf(stderr, "not as expected: %s %s %016llx\n", lines[i].base, lines[i].name, (unsigned long long)lines[i].bits);
    }
    for (i = 0; i < PLACES; i++) {
        const char *member = places[i].member;
        int said = strcmp(member, "struct_size") == 0 || strncmp(member, "reserved", 8) == 0;
        if (strcmp(places[i].structure, "fk_scene") == 0 && tried[i] == 0 && !said) {
            fprintf(stderr, "no case for fk_scene.%s\n", member);
            return 1;
        }
    }
    printf("figure 8: %u cases in C, %u exact\n", cases, exact);
    return cases >= 500 && exact == cases ? 0 : 1;
}
