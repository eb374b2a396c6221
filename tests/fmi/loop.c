/* A host in a page: the default run of a smaller sheet, in FMI 2.0 and in FMI 3.0.
   Arguments: token, step size, number of steps. Prints the outputs named in test_importers.py, exactly, one line per version. */
#include <stdio.h>
#include <stdlib.h>

#include "fmi2Functions.h"
#include "fmi3Functions.h"

/* contact.work, energy.kinetic, energy.strain, energy.contact_loss, fabric.max_deflection, contact.force_peak */
static const unsigned OUTPUTS[] = {333, 410, 411, 413, 420, 313};
enum { COUNT = sizeof OUTPUTS / sizeof *OUTPUTS };
static const unsigned GRID[] = {220, 221};
static const int NODES[] = {41, 41};

static void print(const double *values) {
    for (int k = 0; k < COUNT; k++) printf("%a%c", values[k], k + 1 < COUNT ? ' ' : '\n');
}

static int two(const char *guid, double h, int steps) {
    const fmi2CallbackFunctions functions = {0};
    double values[COUNT];
    fmi2Component fmu = fmi2Instantiate("loop", fmi2CoSimulation, guid, "", &functions, fmi2False, fmi2False);
    if (!fmu || fmi2SetInteger(fmu, GRID, 2, NODES) || fmi2SetupExperiment(fmu, fmi2False, 0.0, 0.0, fmi2False, 0.0)) return 1;
    if (fmi2EnterInitializationMode(fmu) || fmi2ExitInitializationMode(fmu)) return 1;
    for (int k = 0; k < steps; k++)
        if (fmi2DoStep(fmu, k * h, h, fmi2True)) return 1;
    if (fmi2GetReal(fmu, OUTPUTS, COUNT, values) || fmi2Terminate(fmu)) return 1;
    fmi2FreeInstance(fmu);
    print(values);
    return 0;
}

static int three(const char *token, double h, int steps) {
    fmi3Boolean event, terminate, early;
    double values[COUNT], reached;
    fmi3Instance fmu = fmi3InstantiateCoSimulation("loop", token, NULL, 0, 0, 0, 0, NULL, 0, NULL, NULL, NULL);
    if (!fmu || fmi3SetInt32(fmu, GRID, 2, NODES, 2)) return 1;
    if (fmi3EnterInitializationMode(fmu, 0, 0.0, 0.0, 0, 0.0) || fmi3ExitInitializationMode(fmu)) return 1;
    for (int k = 0; k < steps; k++)
        if (fmi3DoStep(fmu, k * h, h, 1, &event, &terminate, &early, &reached)) return 1;
    if (fmi3GetFloat64(fmu, OUTPUTS, COUNT, values, COUNT) || fmi3Terminate(fmu)) return 1;
    fmi3FreeInstance(fmu);
    print(values);
    return 0;
}

int main(int count, char **arguments) {
    if (count != 4) return 2;
    const double h = atof(arguments[2]);
    const int steps = atoi(arguments[3]);
    return two(arguments[1], h, steps) || three(arguments[1], h, steps);
}
