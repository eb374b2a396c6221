/* A whole co-simulation by a host in C, for every platform that an archive holds: Linux (dlopen) and Windows (LoadLibrary).

       loader 2|3 LIBRARY TOKEN save FILE    the whole run; writes the state after half of the steps to FILE
       loader 2|3 LIBRARY TOKEN load FILE    a new instance takes the state from FILE and does the other half

   Prints the bits of outputs after every tenth step and a hash of the whole state at the end: equal text means equal bits.
   The host rounds upwards all the time; the FMU must not care, and must leave that as it is. */
#include <fenv.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
#define OPEN(path) ((void *)LoadLibraryA(path))
#define FIND(library, name) ((void *)GetProcAddress((HMODULE)(library), name))
#else
#include <dlfcn.h>
#define OPEN(path) dlopen(path, RTLD_NOW)
#define FIND(library, name) dlsym(library, name)
#endif

#include "fmi2FunctionTypes.h"
#include "fmi3FunctionTypes.h"

enum { STEPS = 60, EVERY = 10, VALUES = 16 };

static void fail(const char *what)
{
    fprintf(stderr, "loader: %s\n", what);
    exit(1);
}

static void *find(void *library, const char *name)
{
    void *function = FIND(library, name);
    if (!function) fail(name);
    return function;
}

#define NEED(version, name) fmi##version##name##TYPE *name = (fmi##version##name##TYPE *)find(library, "fmi" #version #name)
#define DO(call) do { if ((call) != 0) fail(#call); } while (0)

static void say2(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status, fmi2String category, fmi2String message, ...)
{
    (void)environment, (void)instance;
    fprintf(stderr, "status %d, %s: %s\n", (int)status, category, message);
}

static void say3(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message)
{
    (void)environment;
    fprintf(stderr, "status %d, %s: %s\n", (int)status, category, message);
}

static void print_values(int step, const double *values)
{
    printf("step %2d", step);
    for (int k = 0; k < VALUES; k++) {
        uint64_t bits;
        memcpy(&bits, &values[k], sizeof bits);
        printf(" %016llx", (unsigned long long)bits);
    }
    printf("\n");
}

/* FNV-1a. */
static void print_hash(const unsigned char *bytes, size_t count)
{
    uint64_t hash = 0xcbf29ce484222325u;
    for (size_t k = 0; k < count; k++) hash = (hash ^ bytes[k]) * 0x100000001b3u;
    printf("state %016llx %lu bytes\n", (unsigned long long)hash, (unsigned long)count);
}

static void write_file(const char *path, const unsigned char *bytes, size_t count)
{
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(bytes, 1, count, file) != count || fclose(file) != 0) fail("cannot write the state");
}

static unsigned char *read_file(const char *path, size_t *count)
{
    const size_t most = 1 << 22;
    unsigned char *bytes = malloc(most);
    FILE *file = fopen(path, "rb");
    if (!file || !bytes) fail("cannot read the state");
    *count = fread(bytes, 1, most, file);
    fclose(file);
    return bytes;
}

/* Value references: nodes along x and y, height of the projectile; force, impulse, work, velocity, energies. */
static const unsigned integers[] = {220, 221}, height[] = {602};
static const int32_t sheet[] = {41, 41};
static const double place[] = {-1.906e-2};
static const unsigned scalars[VALUES] = {300, 301, 302, 320, 321, 322, 333, 380, 381, 382, 410, 411, 412, 413, 414, 420};
static const unsigned arrays[] = {300, 320, 333, 380, 410, 411, 412, 413, 414, 420};

/* Times of the steps, computed before the rounding is changed. */
static double times[STEPS + 1];
static const double step_size = 1e-6;

static void run2(void *library, const char *token, int load, const char *path)
{
    NEED(2, Instantiate); NEED(2, FreeInstance); NEED(2, SetupExperiment); NEED(2, EnterInitializationMode);
    NEED(2, ExitInitializationMode); NEED(2, SetInteger); NEED(2, SetReal); NEED(2, GetReal); NEED(2, DoStep); NEED(2, Terminate);
    NEED(2, GetFMUstate); NEED(2, SetFMUstate); NEED(2, FreeFMUstate); NEED(2, SerializedFMUstateSize); NEED(2, SerializeFMUstate);
    NEED(2, DeSerializeFMUstate);
    fmi2CallbackFunctions functions = {0};
    fmi2FMUstate state = NULL;
    double values[VALUES];
    size_t count = 0;
    functions.logger = say2;
    fmi2Component fmu = Instantiate("loader", fmi2CoSimulation, token, "", &functions, fmi2False, fmi2False);
    if (!fmu) fail("no instance");
    if (load) {
        unsigned char *bytes = read_file(path, &count);
        DO(DeSerializeFMUstate(fmu, (const fmi2Byte *)bytes, count, &state));
        DO(SetFMUstate(fmu, state));
        free(bytes);
    } else {
        DO(SetInteger(fmu, integers, 2, sheet));
        DO(SetReal(fmu, height, 1, place));
        DO(SetupExperiment(fmu, fmi2False, 0.0, 0.0, fmi2False, 0.0));
        DO(EnterInitializationMode(fmu));
        DO(ExitInitializationMode(fmu));
    }
    for (int step = load ? STEPS / 2 : 0; step < STEPS; step++) {
        DO(DoStep(fmu, times[step], step_size, fmi2True));
        if ((step + 1) % EVERY == 0) {
            DO(GetReal(fmu, scalars, VALUES, values));
            print_values(step + 1, values);
        }
        if (step + 1 == STEPS || (!load && step + 1 == STEPS / 2)) {
            DO(GetFMUstate(fmu, &state));
            DO(SerializedFMUstateSize(fmu, state, &count));
            unsigned char *bytes = malloc(count);
            if (!bytes) fail("memory");
            DO(SerializeFMUstate(fmu, state, (fmi2Byte *)bytes, count));
            if (step + 1 == STEPS) print_hash(bytes, count);
            else write_file(path, bytes, count);
            free(bytes);
        }
    }
    DO(FreeFMUstate(fmu, &state));
    DO(Terminate(fmu));
    FreeInstance(fmu);
}

static void run3(void *library, const char *token, int load, const char *path)
{
    NEED(3, InstantiateCoSimulation); NEED(3, FreeInstance); NEED(3, EnterInitializationMode); NEED(3, ExitInitializationMode);
    NEED(3, SetInt32); NEED(3, SetFloat64); NEED(3, GetFloat64); NEED(3, DoStep); NEED(3, Terminate);
    NEED(3, GetFMUState); NEED(3, SetFMUState); NEED(3, FreeFMUState); NEED(3, SerializedFMUStateSize); NEED(3, SerializeFMUState);
    NEED(3, DeserializeFMUState);
    const fmi3ValueReference whole_position[] = {600};
    const double position[] = {0.0, 0.0, place[0]};
    fmi3FMUState state = NULL;
    double values[VALUES], last_time;
    fmi3Boolean event, terminate, early;
    size_t count = 0;
    fmi3Instance fmu = InstantiateCoSimulation("loader", token, "", fmi3False, fmi3False, fmi3False, fmi3False, NULL, 0, NULL, say3, NULL);
    if (!fmu) fail("no instance");
    if (load) {
        unsigned char *bytes = read_file(path, &count);
        DO(DeserializeFMUState(fmu, bytes, count, &state));
        DO(SetFMUState(fmu, state));
        free(bytes);
    } else {
        DO(SetInt32(fmu, integers, 2, sheet, 2));
        DO(SetFloat64(fmu, whole_position, 1, position, 3));
        DO(EnterInitializationMode(fmu, fmi3False, 0.0, 0.0, fmi3False, 0.0));
        DO(ExitInitializationMode(fmu));
    }
    for (int step = load ? STEPS / 2 : 0; step < STEPS; step++) {
        DO(DoStep(fmu, times[step], step_size, fmi3True, &event, &terminate, &early, &last_time));
        if ((step + 1) % EVERY == 0) {
            DO(GetFloat64(fmu, arrays, sizeof arrays / sizeof *arrays, values, VALUES));
            print_values(step + 1, values);
        }
        if (step + 1 == STEPS || (!load && step + 1 == STEPS / 2)) {
            DO(GetFMUState(fmu, &state));
            DO(SerializedFMUStateSize(fmu, state, &count));
            unsigned char *bytes = malloc(count);
            if (!bytes) fail("memory");
            DO(SerializeFMUState(fmu, state, bytes, count));
            if (step + 1 == STEPS) print_hash(bytes, count);
            else write_file(path, bytes, count);
            free(bytes);
        }
    }
    DO(FreeFMUState(fmu, &state));
    DO(Terminate(fmu));
    FreeInstance(fmu);
}

int main(int count, char **arguments)
{
    if (count != 6) fail("five arguments, please");
    void *library = OPEN(arguments[2]);
    if (!library) fail("cannot open the library");
    const int load = strcmp(arguments[4], "load") == 0;
    for (int step = 0; step <= STEPS; step++) times[step] = step * step_size;
    if (fesetround(FE_UPWARD) != 0) fail("cannot round upwards");
    if (arguments[1][0] == '2') run2(library, arguments[3], load, arguments[5]);
    else run3(library, arguments[3], load, arguments[5]);
    if (fegetround() != FE_UPWARD) fail("the rounding has been changed");
    return 0;
}
