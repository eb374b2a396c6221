/* A host that has changed the floating-point environment and gives no logger: the bits are the same, and its setting comes back.
   Argument: the guid. Prints the contact work in the usual environment and in each changed one. */
#include <stdio.h>
#include <xmmintrin.h>

#include "fmi2Functions.h"

int main(int count, char **arguments) {
    if (count != 2) return 1;
    const unsigned usual = 0x1f80, flush = 0x8000, zeros = 0x0040, down = 0x2000, up = 0x4000, chop = 0x6000;
    const unsigned environments[] = {usual, usual | flush, usual | zeros, usual | down, usual | up, usual | flush | zeros | chop};
    for (unsigned k = 0; k < sizeof environments / sizeof *environments; k++) {
        fmi2CallbackFunctions functions = {0};
        fmi2Component fmu = fmi2Instantiate("environment", fmi2CoSimulation, arguments[1], "", &functions, 0, 1);
        if (!fmu) return 3;
        const fmi2ValueReference grid[] = {220, 221}, place[] = {602}, work[] = {333};
        const fmi2Integer nodes[] = {31, 31};
        const fmi2Real position[] = {-1.906e-2};
        fmi2Real value;
        if (fmi2SetInteger(fmu, grid, 2, nodes) || fmi2SetReal(fmu, place, 1, position)) return 4;
        _mm_setcsr(environments[k]);
        int status = fmi2EnterInitializationMode(fmu) | fmi2ExitInitializationMode(fmu);
        for (int step = 0; step < 20; step++) status |= fmi2DoStep(fmu, step * 1e-6, 1e-6, fmi2True);
        status |= fmi2GetReal(fmu, work, 1, &value);
        unsigned after = _mm_getcsr() & 0xffc0;
        _mm_setcsr(usual);
        if (status != fmi2OK || after != (environments[k] & 0xffc0)) return 5;
        printf("%a\n", value);
        fmi2FreeInstance(fmu);
    }
    return 0;
}
