/* Every case of tests/inputs/cases through the C interface: its exact status and field, and nothing written when refused.
 * Usage: inputs FILE. Exit code 1 if a case is answered otherwise. */
#include "fabric_kernel.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Where each number of fk_scene is. */
static const struct place {
    const char *name;
    size_t at;
    int whole;
} places[] = {
#define SIZE(structure, bytes)
#define REAL(name, at, bytes) {#name, at, 0},
#define WHOLE(name, at, bytes) {#name, at, 1},
#include "abi/scene.inc"
};

enum { PLACES = sizeof places / sizeof places[0], LINES = 4096, MEMORY = 1 << 19, NODES = 100, PATTERN = 0x33 };

/* How often each place was given a value. */
static unsigned tried[PLACES];

typedef struct line {
    char kind[8], base[16], name[40], field[40];
    uint64_t bits;
    int status;
} line;

static line lines[LINES];

static void give_up(const char *what, const line *l)
{
    fprintf(stderr, "%s: %s %s\n", what, l->base, l->name);
    exit(1);
}

/* Gives a number of a scene, "sheet.position[2]", a value. */
static void assign(fk_scene *scene, const line *l)
{
    char name[40];
    unsigned k = 0, j = 0;
    size_t i;
    double value;
    uint64_t word = l->bits;
    char *index;
    strcpy(name, l->name);
    index = strchr(name, '[');
    if (index != NULL) {
        if (sscanf(index, "[%u][%u]", &k, &j) == 2)
            k = 4 * k + j;
        *index = '\0';
    }
    for (i = 0; i < PLACES; i++)
        if (strcmp(places[i].name, name) == 0)
            break;
    if (i == PLACES)
        give_up("no such number", l);
    tried[i]++;
    if (places[i].whole) {
        memcpy(&value, &l->bits, sizeof value);
        word = (uint64_t)value;
    }
    memcpy((char *)scene + places[i].at + 8 * k, &word, sizeof word);
}

/* Whether the block holds its pattern and nothing else. */
static int untouched(const unsigned char *memory)
{
    return memory[0] == PATTERN && memcmp(memory, memory + 1, MEMORY - 1) == 0;
}

/* Whether a scene is answered as the case says; what is refused is refused by fk_init, and writes nothing. */
static int answered(const fk_scene *scene, const line *l)
{
    static unsigned char memory[MEMORY];
    fk_fault fault = {0};
    fk_sim *sim = NULL;
    uint64_t bytes = 7;
    int32_t status, sized = fk_memory_size(scene, &bytes);
    int large = scene->sheet.nodes_x > NODES || scene->sheet.nodes_y > NODES;
    if (sized != FK_OK && (sized != l->status || bytes != 7))
        return 0;
    if (large)
        return sized == l->status;
    memset(memory, PATTERN, MEMORY);
    status = fk_init(memory, MEMORY, scene, &sim, &fault, sizeof fault);
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
        const char *form = "%7s %15s %39s %llx %d %39s";
        int read = sscanf(text, form, l->kind, l->base, l->name, &bits, &l->status, l->field);
        l->bits = bits;
        n += read == 6 || (read == 4 && strcmp(l->kind, "set") == 0);
    }
    fclose(file);
    for (i = 0; i < n; i++) {
        fk_scene scene;
        if (strcmp(lines[i].kind, "case") != 0)
            continue;
        scene = fk_scene_preset(FK_PRESET_SHEET_3IN_SPHERE);
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
        if (tried[i] == 0) {
            fprintf(stderr, "no case for %s\n", places[i].name);
            return 1;
        }
    }
    printf("figure 8: %u cases in C, %u exact\n", cases, exact);
    return cases >= 500 && exact == cases ? 0 : 1;
}
