/* A host that saves states and makes instances a thousand times each: the resident memory stays where it is.
   Argument: the guid. Prints both growths in kB. */
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "fmi2Functions.h"

#define CHECK(call) \
    if (call) { fprintf(stderr, "%s\n", #call); exit(1); }

static const char *guid;

static long resident(void) {
    long all, pages;
    FILE *file = fopen("/proc/self/statm", "r");
    if (!file || fscanf(file, "%ld %ld", &all, &pages) != 2) exit(1);
    fclose(file);
    return pages * (sysconf(_SC_PAGESIZE) / 1024);
}

/* The sheet of 31 x 31 nodes, the cylinder in contact with it after `steps` steps. */
static fmi2Component running(int steps) {
    static const fmi2CallbackFunctions functions = {0};
    const fmi2ValueReference grid[] = {220, 221}, place = 602;
    const fmi2Integer nodes[] = {31, 31};
    const fmi2Real position = -1.906e-2;
    fmi2Component fmu = fmi2Instantiate("memory", fmi2CoSimulation, guid, NULL, &functions, fmi2False, fmi2False);
    CHECK(!fmu)
    CHECK(fmi2SetInteger(fmu, grid, 2, nodes))
    CHECK(fmi2SetReal(fmu, &place, 1, &position))
    CHECK(fmi2EnterInitializationMode(fmu))
    CHECK(fmi2ExitInitializationMode(fmu))
    for (int k = 0; k < steps; k++) CHECK(fmi2DoStep(fmu, k * 1e-6, 1e-6, fmi2True))
    return fmu;
}

int main(int count, char **arguments) {
    if (count != 2) return 2;
    guid = arguments[1];

    fmi2Component fmu = running(10);
    fmi2FMUstate state = NULL;
    CHECK(fmi2GetFMUstate(fmu, &state))
    const fmi2FMUstate first = state;
    long before = resident();
    for (int k = 0; k < 1000; k++) {
        CHECK(fmi2GetFMUstate(fmu, &state))
        CHECK(state != first)
        CHECK(fmi2SetFMUstate(fmu, state))
    }
    const long states = resident() - before;
    fmi2FreeInstance(fmu);

    before = resident();
    for (int k = 0; k < 1000; k++) {
        fmu = running(1);
        state = NULL;
        CHECK(fmi2GetFMUstate(fmu, &state)) /* freed with the instance */
        fmi2FreeInstance(fmu);
    }
    printf("%ld %ld\n", states, resident() - before);
    return 0;
}
