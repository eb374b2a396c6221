/* FMI 2.0: each function in each state, and bad arguments, against the official headers. Argument: the guid. */
#include <stdarg.h>

#include "fmi2Functions.h"
#define VERSION 2
#define FMI(name) fmi2##name
#define fmi2GetFMUState fmi2GetFMUstate
#define fmi2SetFMUState fmi2SetFMUstate
#define fmi2FreeFMUState fmi2FreeFMUstate
#define fmi2SerializedFMUStateSize fmi2SerializedFMUstateSize
#define fmi2SerializeFMUState fmi2SerializeFMUstate
#define fmi2DeserializeFMUState fmi2DeSerializeFMUstate
typedef fmi2Component Instance;
typedef fmi2FMUstate State;
#include "calls.h"

static void logger(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                   fmi2String format, ...) {
    messages++;
    last_status = status;
    /* The environment is the host's, the format is "%s" with one text, and nothing is NULL. */
    va_list rest;
    va_start(rest, format);
    const char *text = strcmp(format, "%s") ? NULL : va_arg(rest, const char *);
    va_end(rest);
    if (environment != &messages || strcmp(name, "calls") || !category || !text || !*text) abort();
}

static fmi2CallbackFunctions callbacks = {logger, NULL, NULL, NULL, &messages};

static Instance instantiate(void) {
    callbacks.logger = with_logger ? logger : NULL;
    return fmi2Instantiate("calls", fmi2CoSimulation, token, "file:///resources", &callbacks, fmi2False, fmi2False);
}

static const fmi2ValueReference LOAD[] = {152}, WORK[] = {333}, STATUS[] = {440}, STOP[] = {270}, PLACE[] = {602};
static const fmi2ValueReference UNKNOWN[] = {99999}, RADIUS[] = {211}, SEED[] = {260}, MODE[] = {200}, GRID[] = {220, 221};

static int make_small(void) {
    const fmi2Integer nodes[] = {21, 21};
    const fmi2Real position = -1.906e-2;
    return fmi2SetInteger(fmu, GRID, 2, nodes) || fmi2SetReal(fmu, PLACE, 1, &position);
}

static int enter(void) {
    return fmi2SetupExperiment(fmu, fmi2False, 0.0, 0.0, fmi2True, 1e-3) || fmi2EnterInitializationMode(fmu);
}

static int enter_step_mode(void) { return OK; }
static int load(double newton) { return fmi2SetReal(fmu, LOAD, 1, &newton); }
static int step(double t, double h) { return fmi2DoStep(fmu, t, h, fmi2True); }

/* ---- The calls ------------------------------------------------------------------------------------------------------- */

static fmi2Real real[2];
static fmi2Integer integer[2] = {2, 2};
static fmi2Boolean boolean[2];
static fmi2String text[2];
static fmi2Status status;

static int call_GetTypesPlatform(void) { return strcmp(fmi2GetTypesPlatform(), "default") ? ERROR : OK; }
CALL(SetupExperiment, fmu, fmi2False, 0.0, 0.0, fmi2False, 0.0)
CALL(EnterInitializationMode, fmu)
static int call_GetInput(void) { return fmi2GetReal(fmu, LOAD, 1, real); }
static int call_GetOutput(void) { return fmi2GetReal(fmu, WORK, 1, real); }
CALL(GetInteger, fmu, STATUS, 1, integer)
CALL(GetBoolean, fmu, STOP, 1, boolean)
CALL(GetString, fmu, NULL, 0, text)
static int call_SetParameter(void) { return fmi2SetReal(fmu, RADIUS, 1, (fmi2Real[]){6.3e-3}); }
CALL(SetInteger, fmu, SEED, 0, integer) /* none: every Integer is a fixed parameter */
CALL(SetBoolean, fmu, STOP, 1, (fmi2Boolean[]){fmi2False})
CALL(SetString, fmu, NULL, 0, NULL)
CALL(GetDirectionalDerivative, fmu, WORK, 1, LOAD, 1, real, real)
CALL(SetRealInputDerivatives, fmu, LOAD, 1, integer, real)
CALL(GetRealOutputDerivatives, fmu, WORK, 1, integer, real)
CALL(CancelStep, fmu)
CALL(GetStatus, fmu, fmi2DoStepStatus, &status)
CALL(GetRealStatus, fmu, fmi2LastSuccessfulTime, real)
CALL(GetIntegerStatus, fmu, fmi2DoStepStatus, integer)
CALL(GetBooleanStatus, fmu, fmi2Terminated, boolean)
CALL(GetStringStatus, fmu, fmi2PendingStatus, text)

static const Row TABLE[] = {
#define FMI2 ROW
#define FMI3 NO_ROW
#include "states.inc"
};

/* ---- Bad arguments, after a step ------------------------------------------------------------------------------------- */

static void misuse_of_values(void) {
    const fmi2Real one = 1.0;
    MISUSE("unknown value reference", ERROR, fmi2GetReal(fmu, UNKNOWN, 1, real))
    MISUSE("set an unknown value reference", ERROR, fmi2SetReal(fmu, UNKNOWN, 1, &one))
    MISUSE("a Real read as Integer", ERROR, fmi2GetInteger(fmu, WORK, 1, integer))
    MISUSE("a Real set as Boolean", ERROR, fmi2SetBoolean(fmu, LOAD, 1, boolean))
    MISUSE("an Integer read as Real", ERROR, fmi2GetReal(fmu, SEED, 1, real))
    MISUSE("an Enumeration read as Real", ERROR, fmi2GetReal(fmu, STATUS, 1, real))
    MISUSE("a Boolean read as Real", ERROR, fmi2GetReal(fmu, STOP, 1, real))
    MISUSE("a Boolean read as Integer", ERROR, fmi2GetInteger(fmu, STOP, 1, integer))
    MISUSE("an Integer read as Boolean", ERROR, fmi2GetBoolean(fmu, SEED, 1, boolean))
    MISUSE("a Real read as Boolean", ERROR, fmi2GetBoolean(fmu, LOAD, 1, boolean))
    MISUSE("value references NULL", ERROR, fmi2GetReal(fmu, NULL, 1, real))
    MISUSE("values NULL", ERROR, fmi2GetReal(fmu, LOAD, 1, NULL))
    MISUSE("set value references NULL", ERROR, fmi2SetReal(fmu, NULL, 1, &one))
    MISUSE("set values NULL", ERROR, fmi2SetReal(fmu, LOAD, 1, NULL))
    MISUSE("an array longer than memory", ERROR, fmi2GetReal(fmu, LOAD, (size_t)-1, real))
    MISUSE("read a String", ERROR, fmi2GetString(fmu, LOAD, 1, text))
    MISUSE("set an output", ERROR, fmi2SetReal(fmu, WORK, 1, &one))
    MISUSE("set a fixed Integer", ERROR, fmi2SetInteger(fmu, SEED, 1, integer))
    MISUSE("set a fixed Enumeration", ERROR, fmi2SetInteger(fmu, MODE, 1, integer))
    MISUSE("unknown kind of status", DISCARD, fmi2GetStatus(fmu, fmi2Terminated, &status))
    MISUSE("unknown kind of number", DISCARD, fmi2GetRealStatus(fmu, fmi2DoStepStatus, real))
    MISUSE("unknown kind of truth", DISCARD, fmi2GetBooleanStatus(fmu, fmi2PendingStatus, boolean))
    MISUSE("status into NULL", ERROR, fmi2GetStatus(fmu, fmi2DoStepStatus, NULL))
    MISUSE("last time into NULL", ERROR, fmi2GetRealStatus(fmu, fmi2LastSuccessfulTime, NULL))
    MISUSE("terminated into NULL", ERROR, fmi2GetBooleanStatus(fmu, fmi2Terminated, NULL))
}

/* No instance comes of these; with a logger each says why. */
static void check_instantiate(void) {
    fmi2CallbackFunctions silent = {NULL, NULL, NULL, NULL, NULL};
    callbacks.logger = logger;
    char other[100] = "";
    strncpy(other, token, sizeof other - 1);
    other[20] ^= 1;
    struct {
        const char *what;
        fmi2Component made;
    } refused[] = {
        {"wrong guid", fmi2Instantiate("calls", fmi2CoSimulation, "{wrong}", "", &callbacks, 0, 0)},
        {"another guid", fmi2Instantiate("calls", fmi2CoSimulation, other, "", &callbacks, 0, 0)},
        {"guid NULL", fmi2Instantiate("calls", fmi2CoSimulation, NULL, "", &callbacks, 0, 0)},
        {"model exchange", fmi2Instantiate("calls", fmi2ModelExchange, token, "", &callbacks, 0, 0)},
        {"name NULL", fmi2Instantiate(NULL, fmi2CoSimulation, token, "", &silent, 0, 0)},
        {"name empty", fmi2Instantiate("", fmi2CoSimulation, token, "", &silent, 0, 0)},
        {"name blank", fmi2Instantiate("  ", fmi2CoSimulation, token, "", &silent, 0, 0)},
        {"callbacks NULL", fmi2Instantiate("calls", fmi2CoSimulation, token, "", NULL, 0, 0)},
        {"wrong guid, no logger", fmi2Instantiate("calls", fmi2CoSimulation, "{wrong}", NULL, &silent, 0, 1)},
    };
    for (size_t k = 0; k < COUNT(refused); k++) expect(!refused[k].made, refused[k].what, "fmi2Instantiate", "an instance came of it");
    expect(messages == 4, "fmi2Instantiate", "refusals", "not one message each");
}

static void check_more(void) {}

int main(int count, char **arguments) { return count == 2 ? run(arguments[1], TABLE, COUNT(TABLE)) : 2; }
