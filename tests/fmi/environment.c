/* A host that has changed the floating-point environment and gives no logger: the bits are the same, and its setting comes back.
   Arguments: library, guid. Prints the contact work in the usual environment and in each changed one. */
#include <dlfcn.h>
#include <stdio.h>
#include <xmmintrin.h>

#include "fmi2FunctionTypes.h"

#define LOAD(name)                                                          \
    fmi2##name##TYPE *name = (fmi2##name##TYPE *)dlsym(library, "fmi2" #name); \
    if (!name) return 2

int main(int count, char **arguments) {
    void *library = count == 3 ? dlopen(arguments[1], RTLD_NOW) : NULL;
    if (!library) return 1;
    LOAD(Instantiate);
    LOAD(FreeInstance);
    LOAD(EnterInitializationMode);
    LOAD(ExitInitializationMode);
    LOAD(SetInteger);
    LOAD(SetReal);
    LOAD(GetReal);
    LOAD(DoStep);

    const unsigned usual = 0x1f80, flush = 0x8000, zeros = 0x0040, down = 0x2000, up = 0x4000, chop = 0x6000;
    const unsigned environments[] = {usual, usual | flush, usual | zeros, usual | down, usual | up, usual | flush | zeros | chop};
    for (unsigned k = 0; k < sizeof environments / sizeof *environments; k++) {
        fmi2CallbackFunctions functions = {0};
        fmi2Component fmu = Instantiate("environment", fmi2CoSimulation, arguments[2], "", &functions, 0, 1);
        if (!fmu) return 3;
        const fmi2ValueReference grid[] = {220, 221}, place[] = {602}, work[] = {333};
        const fmi2Integer nodes[] = {31, 31};
        const fmi2Real position[] = {-1.906e-2};
        fmi2Real value;
        if (SetInteger(fmu, grid, 2, nodes) || SetReal(fmu, place, 1, position)) return 4;
        _mm_setcsr(environments[k]);
        int status = EnterInitializationMode(fmu) | ExitInitializationMode(fmu);
        for (int step = 0; step < 20; step++) status |= DoStep(fmu, step * 1e-6, 1e-6, fmi2True);
        status |= GetReal(fmu, work, 1, &value);
        unsigned after = _mm_getcsr() & 0xffc0;
        _mm_setcsr(usual);
        if (status != fmi2OK || after != (environments[k] & 0xffc0)) return 5;
        printf("%a\n", value);
        FreeInstance(fmu);
    }
    return 0;
}
