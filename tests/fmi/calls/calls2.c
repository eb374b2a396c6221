/* FMI 2.0: each function in each state, and bad arguments, against the official headers. Argument: the guid. */
#include <stdarg.h>

#include "fmi2Functions.h"
#include "calls.h"

static const char *guid;
static fmi2Component fmu;
static fmi2FMUstate saved; /* a state of the instance, taken before it failed or ended */
static int with_logger;

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

static fmi2Component instantiate(void) {
    callbacks.logger = with_logger ? logger : NULL;
    return fmi2Instantiate("calls", fmi2CoSimulation, guid, "file:///resources", &callbacks, fmi2False, fmi2False);
}

static void set_load(double newton) {
    const fmi2ValueReference load = 152;
    if (fmi2SetReal(fmu, &load, 1, &newton)) abort();
}

/* After fmi2Instantiate; in initialisation; after a step; after a discarded step; after fmi2Terminate; after a failure. */
static const char *const STATES[] = {"instantiated", "initialization", "stepComplete", "stepFailed", "terminated", "error", NULL};
enum { INSTANTIATED, INITIALIZATION, COMPLETE, FAILED, TERMINATED, FAULTED };

static void reach(int state) {
    if (fmu) fmi2FreeInstance(fmu);
    fmu = NULL;
    saved = NULL;
    if (state < 0) return;
    const fmi2ValueReference grid[] = {220, 221}, place = 602;
    const fmi2Integer nodes[] = {21, 21};
    const fmi2Real position = -1.906e-2;
    if (!(fmu = instantiate()) || fmi2SetInteger(fmu, grid, 2, nodes) || fmi2SetReal(fmu, &place, 1, &position)) abort();
    if (state >= INITIALIZATION && (fmi2SetupExperiment(fmu, fmi2False, 0.0, 0.0, fmi2True, 1e-3) || fmi2EnterInitializationMode(fmu))) abort();
    if (state >= COMPLETE && (fmi2ExitInitializationMode(fmu) || fmi2DoStep(fmu, 0.0, 1e-6, fmi2True))) abort();
    if (state >= COMPLETE) set_load(0.0);
    if (fmi2GetFMUstate(fmu, &saved)) abort();
    if (state == FAILED) {
        set_load(NOT_A_NUMBER);
        if (fmi2DoStep(fmu, 1e-6, 1e-6, fmi2True) != fmi2Discard) abort();
    }
    if (state == TERMINATED && fmi2Terminate(fmu)) abort();
    if (state == FAULTED) {
        set_load(1e12); /* the projectile becomes faster than the sheet can follow */
        if (fmi2DoStep(fmu, 1e-6, 1e-6, fmi2True) != fmi2Error) abort();
    }
}

static int image_possible(int state) { return state != FAULTED; }

static size_t image(unsigned char **bytes) {
    fmi2FMUstate state = NULL;
    size_t size = 0;
    if (fmi2GetFMUstate(fmu, &state) || fmi2SerializedFMUstateSize(fmu, state, &size)) abort();
    *bytes = malloc(size);
    if (fmi2SerializeFMUstate(fmu, state, (fmi2Byte *)*bytes, size) || fmi2FreeFMUstate(fmu, &state)) abort();
    return size;
}

/* ---- The calls ------------------------------------------------------------------------------------------------------- */

static const fmi2ValueReference LOAD[] = {152}, WORK[] = {333}, STATUS[] = {440}, STOP[] = {270};
static const fmi2ValueReference UNKNOWN[] = {99999}, RADIUS[] = {211}, SEED[] = {260}, MODE[] = {200};
static fmi2Real real[2];
static fmi2Integer integer[2] = {2, 2};
static fmi2Boolean boolean[2];
static fmi2String text[2];
static fmi2Status status;

#define CALL(name, ...) \
    static int call_##name(void) { return fmi2##name(__VA_ARGS__); }

static int call_GetTypesPlatform(void) { return strcmp(fmi2GetTypesPlatform(), "default") ? ERROR : OK; }
static int call_GetVersion(void) { return strcmp(fmi2GetVersion(), "2.0") ? ERROR : OK; }
CALL(SetDebugLogging, fmu, fmi2False, 0, NULL)
static int call_FreeInstance(void) {
    fmi2FreeInstance(fmu);
    fmu = NULL;
    return OK;
}
CALL(SetupExperiment, fmu, fmi2False, 0.0, 0.0, fmi2False, 0.0)
CALL(EnterInitializationMode, fmu)
CALL(ExitInitializationMode, fmu)
CALL(Terminate, fmu)
CALL(Reset, fmu)
CALL(GetReal, fmu, LOAD, 1, real)
static int call_GetOutput(void) { return fmi2GetReal(fmu, WORK, 1, real); }
CALL(GetInteger, fmu, STATUS, 1, integer)
CALL(GetBoolean, fmu, STOP, 1, boolean)
CALL(GetString, fmu, NULL, 0, text)
static int call_SetReal(void) {
    const fmi2Real force = 1.0;
    return fmi2SetReal(fmu, LOAD, 1, &force);
}
static int call_SetParameter(void) {
    const fmi2Real radius = 6.3e-3;
    return fmi2SetReal(fmu, RADIUS, 1, &radius);
}
static int call_SetInteger(void) {
    /* None: every Integer is a fixed parameter. */
    return fmi2SetInteger(fmu, SEED, 0, integer);
}
static int call_SetBoolean(void) {
    const fmi2Boolean no = fmi2False;
    return fmi2SetBoolean(fmu, STOP, 1, &no);
}
CALL(SetString, fmu, NULL, 0, NULL)
static int call_GetFMUstate(void) {
    fmi2FMUstate state = NULL;
    return fmi2GetFMUstate(fmu, &state);
}
CALL(SetFMUstate, fmu, saved)
CALL(FreeFMUstate, fmu, &saved)
static int call_SerializedFMUstateSize(void) {
    size_t size;
    return fmi2SerializedFMUstateSize(fmu, saved, &size);
}
static int call_SerializeFMUstate(void) {
    size_t size = 0;
    if (fmi2SerializedFMUstateSize(fmu, saved, &size)) return ERROR;
    fmi2Byte *bytes = malloc(size);
    int result = fmi2SerializeFMUstate(fmu, saved, bytes, size);
    free(bytes);
    return result;
}
static int call_DeSerializeFMUstate(void) {
    size_t size = 0;
    fmi2FMUstate state = NULL;
    if (fmi2SerializedFMUstateSize(fmu, saved, &size)) return ERROR;
    fmi2Byte *bytes = malloc(size);
    int result = fmi2SerializeFMUstate(fmu, saved, bytes, size);
    if (result == OK) result = fmi2DeSerializeFMUstate(fmu, bytes, size, &state);
    free(bytes);
    return result;
}
CALL(GetDirectionalDerivative, fmu, WORK, 1, LOAD, 1, real, real)
CALL(SetRealInputDerivatives, fmu, LOAD, 1, integer, real)
CALL(GetRealOutputDerivatives, fmu, WORK, 1, integer, real)
CALL(DoStep, fmu, 1e-6, 1e-6, fmi2True)
CALL(CancelStep, fmu)
CALL(GetStatus, fmu, fmi2DoStepStatus, &status)
CALL(GetRealStatus, fmu, fmi2LastSuccessfulTime, real)
CALL(GetIntegerStatus, fmu, fmi2DoStepStatus, integer)
CALL(GetBooleanStatus, fmu, fmi2Terminated, boolean)
CALL(GetStringStatus, fmu, fmi2PendingStatus, text)

/* FMI 2.0.4, section 4.2.4, "State machine of calling sequence from master to slave", and 2.1.2 for the platform functions.
   k: after a discarded step nothing has changed, so the host may correct its inputs; the standard only lets it restore a state.
   D: the step is still discarded, for the input is still bad.
   e: a failed simulation has no state worth saving and no outputs worth reading; parameters, inputs and status are read. */
static const Row TABLE[] = {
    /*                                            instantiated
                                                  | initialization
                                                  | | stepComplete
                                                  | | | stepFailed
                                                  | | | | terminated
                                                  | | | | | error */
    {"GetTypesPlatform", call_GetTypesPlatform, "+ + + + + +"},
    {"GetVersion", call_GetVersion, "+ + + + + +"},
    {"SetDebugLogging", call_SetDebugLogging, "+ + + + + +"},
    {"FreeInstance", call_FreeInstance, "+ + + + + +"},
    {"SetupExperiment", call_SetupExperiment, "+ - - - - -"},
    {"EnterInitializationMode", call_EnterInitializationMode, "+ - - - - -"},
    {"ExitInitializationMode", call_ExitInitializationMode, "- + - - - -"},
    {"Terminate", call_Terminate, "- - + + - -"},
    {"Reset", call_Reset, "+ + + + + +"},
    {"GetReal, an input", call_GetReal, "- + + + + +"},
    {"GetReal, an output", call_GetOutput, "- + + + + e"},
    {"GetInteger", call_GetInteger, "- + + + + +"},
    {"GetBoolean", call_GetBoolean, "- + + + + +"},
    {"GetString of none", call_GetString, "- + + + + +"},
    {"SetReal, an input", call_SetReal, "+ + + k - -"},
    {"SetReal, a fixed parameter", call_SetParameter, "+ + - - - -"},
    {"SetInteger, a tunable parameter", call_SetInteger, "+ + + k - -"},
    {"SetBoolean, a tunable parameter", call_SetBoolean, "+ + + k - -"},
    {"SetString of none", call_SetString, "+ + + k - -"},
    {"GetFMUstate", call_GetFMUstate, "+ + + + + e"},
    {"SetFMUstate", call_SetFMUstate, "+ + + + + +"},
    {"FreeFMUstate", call_FreeFMUstate, "+ + + + + +"},
    {"SerializedFMUstateSize", call_SerializedFMUstateSize, "+ + + + + +"},
    {"SerializeFMUstate", call_SerializeFMUstate, "+ + + + + +"},
    {"DeSerializeFMUstate", call_DeSerializeFMUstate, "+ + + + + +"},
    {"GetDirectionalDerivative", call_GetDirectionalDerivative, "- u u u u u"},
    {"SetRealInputDerivatives", call_SetRealInputDerivatives, "u u u - - -"},
    {"GetRealOutputDerivatives", call_GetRealOutputDerivatives, "- - u u u u"},
    {"DoStep", call_DoStep, "- - + D - -"},
    {"CancelStep", call_CancelStep, "- - - - - -"}, /* only while a step is in progress, which it never is */
    {"GetStatus", call_GetStatus, "- - + + + -"},
    {"GetRealStatus", call_GetRealStatus, "- - + + + -"},
    {"GetIntegerStatus", call_GetIntegerStatus, "- - D D D -"}, /* no status is an Integer */
    {"GetBooleanStatus", call_GetBooleanStatus, "- - + + + -"},
    {"GetStringStatus", call_GetStringStatus, "- - D D D -"}, /* only while a step is pending */
};

/* ---- Bad arguments, after a step ------------------------------------------------------------------------------------- */

static const fmi2String strange[] = {"nonsense"}, none[] = {NULL};
static const fmi2Real one = 1.0;
static fmi2Byte few[8];
static fmi2FMUstate nowhere = &zero, empty;

static int step_with_load(double newton) {
    fmi2Real usual;
    if (fmi2GetReal(fmu, LOAD, 1, &usual)) abort();
    set_load(newton);
    int result = fmi2DoStep(fmu, 1e-6, 1e-6, fmi2True);
    set_load(usual);
    return result;
}

static void misuse(int logger_given) {
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
    MISUSE("unknown log category", ERROR, fmi2SetDebugLogging(fmu, fmi2True, 1, strange))
    MISUSE("log category NULL", ERROR, fmi2SetDebugLogging(fmu, fmi2True, 1, none))
    MISUSE("log categories NULL", ERROR, fmi2SetDebugLogging(fmu, fmi2True, 1, NULL))
    MISUSE("get state into NULL", ERROR, fmi2GetFMUstate(fmu, NULL))
    MISUSE("get state into a stranger's", ERROR, fmi2GetFMUstate(fmu, &nowhere))
    MISUSE("set state NULL", ERROR, fmi2SetFMUstate(fmu, NULL))
    MISUSE("set a stranger's state", ERROR, fmi2SetFMUstate(fmu, nowhere))
    MISUSE("free a stranger's state", ERROR, fmi2FreeFMUstate(fmu, &nowhere))
    MISUSE("size of a stranger's state", ERROR, fmi2SerializedFMUstateSize(fmu, nowhere, (size_t[1]){0}))
    MISUSE("size into NULL", ERROR, fmi2SerializedFMUstateSize(fmu, saved, NULL))
    MISUSE("serialise into NULL", ERROR, fmi2SerializeFMUstate(fmu, saved, NULL, 1 << 20))
    MISUSE("serialise into too few bytes", ERROR, fmi2SerializeFMUstate(fmu, saved, few, sizeof few))
    expect(!few[0] && !few[7], "SerializeFMUstate", "too few bytes", "written");
    MISUSE("deserialise NULL", ERROR, fmi2DeSerializeFMUstate(fmu, NULL, 1 << 20, &empty))
    MISUSE("deserialise no bytes", ERROR, fmi2DeSerializeFMUstate(fmu, NULL, 0, &empty))
    MISUSE("deserialise junk", ERROR, fmi2DeSerializeFMUstate(fmu, (fmi2Byte[64]){1, 2, 3}, 64, &empty))
    MISUSE("deserialise into NULL", ERROR, fmi2DeSerializeFMUstate(fmu, (fmi2Byte[64]){1, 2, 3}, 64, NULL))
    MISUSE("unknown kind of status", DISCARD, fmi2GetStatus(fmu, fmi2Terminated, &status))
    MISUSE("unknown kind of number", DISCARD, fmi2GetRealStatus(fmu, fmi2DoStepStatus, real))
    MISUSE("unknown kind of truth", DISCARD, fmi2GetBooleanStatus(fmu, fmi2PendingStatus, boolean))
    MISUSE("status into NULL", ERROR, fmi2GetStatus(fmu, fmi2DoStepStatus, NULL))
    MISUSE("last time into NULL", ERROR, fmi2GetRealStatus(fmu, fmi2LastSuccessfulTime, NULL))
    MISUSE("terminated into NULL", ERROR, fmi2GetBooleanStatus(fmu, fmi2Terminated, NULL))
    MISUSE("h = 0", ERROR, fmi2DoStep(fmu, 1e-6, 0.0, fmi2True))
    MISUSE("h < 0", ERROR, fmi2DoStep(fmu, 1e-6, -1e-6, fmi2True))
    MISUSE("h not a number", ERROR, fmi2DoStep(fmu, 1e-6, NOT_A_NUMBER, fmi2True))
    MISUSE("h infinite", ERROR, fmi2DoStep(fmu, 1e-6, 1.0 / zero, fmi2True))
    MISUSE("t not a number", ERROR, fmi2DoStep(fmu, NOT_A_NUMBER, 1e-6, fmi2True))
    MISUSE("t half a step late", ERROR, fmi2DoStep(fmu, 1.5e-6, 1e-6, fmi2True))
    MISUSE("t half a step early", ERROR, fmi2DoStep(fmu, 0.5e-6, 1e-6, fmi2True))
    MISUSE("past the stop time", ERROR, fmi2DoStep(fmu, 1e-6, 2e-3, fmi2True))
    MISUSE("load not a number", DISCARD, step_with_load(NOT_A_NUMBER))
    MISUSE("load infinite", DISCARD, step_with_load(1.0 / zero))
}

/* No instance comes of these; with a logger each says why. */
static void check_instantiate(void) {
    fmi2CallbackFunctions silent = {NULL, NULL, NULL, NULL, NULL};
    callbacks.logger = logger;
    char other[100] = "";
    strncpy(other, guid, sizeof other - 1);
    other[20] ^= 1;
    struct {
        const char *what;
        fmi2Component made;
    } refused[] = {
        {"wrong guid", fmi2Instantiate("calls", fmi2CoSimulation, "{wrong}", "", &callbacks, 0, 0)},
        {"another guid", fmi2Instantiate("calls", fmi2CoSimulation, other, "", &callbacks, 0, 0)},
        {"guid NULL", fmi2Instantiate("calls", fmi2CoSimulation, NULL, "", &callbacks, 0, 0)},
        {"model exchange", fmi2Instantiate("calls", fmi2ModelExchange, guid, "", &callbacks, 0, 0)},
        {"name NULL", fmi2Instantiate(NULL, fmi2CoSimulation, guid, "", &silent, 0, 0)},
        {"name empty", fmi2Instantiate("", fmi2CoSimulation, guid, "", &silent, 0, 0)},
        {"name blank", fmi2Instantiate("  ", fmi2CoSimulation, guid, "", &silent, 0, 0)},
        {"callbacks NULL", fmi2Instantiate("calls", fmi2CoSimulation, guid, "", NULL, 0, 0)},
        {"wrong guid, no logger", fmi2Instantiate("calls", fmi2CoSimulation, "{wrong}", NULL, &silent, 0, 1)},
    };
    for (size_t k = 0; k < COUNT(refused); k++) expect(!refused[k].made, refused[k].what, "fmi2Instantiate", "an instance came of it");
    expect(messages == 4, "fmi2Instantiate", "refusals", "not one message each");
}

/* After everything in the table a good step gives what it gives without. */
static void check_undisturbed(int logger_given) {
    unsigned char *plain = NULL, *misused = NULL;
    reach(COMPLETE);
    if (fmi2DoStep(fmu, 1e-6, 1e-6, fmi2True)) abort();
    size_t bytes = image(&plain);
    reach(COMPLETE);
    misuse(logger_given);
    set_load(0.0);
    expect(fmi2DoStep(fmu, 1e-6, 1e-6, fmi2True) == fmi2OK, "DoStep", "after misuse", "not OK");
    expect(image(&misused) == bytes && !memcmp(plain, misused, bytes), "DoStep", "after misuse", "not the undisturbed run");
    free(plain);
    free(misused);
}

int main(int count, char **arguments) {
    if (count != 2) return 2;
    guid = arguments[1];
    messages = 0;
    check_instantiate();
    for (with_logger = 1; with_logger >= 0; with_logger--) {
        check_table(TABLE, COUNT(TABLE), STATES, with_logger);
        check_undisturbed(with_logger);
    }
    reach(-1); /* from here on every call is made on NULL */
    for (size_t r = 0; r < COUNT(TABLE); r++) {
        int of_no_instance = TABLE[r].call == call_GetTypesPlatform || TABLE[r].call == call_GetVersion || TABLE[r].call == call_FreeInstance;
        expect(TABLE[r].call() == (of_no_instance ? OK : ERROR), TABLE[r].name, "NULL instance", "wrong status");
    }
    printf("%d checks, %d failures\n", checks, failures);
    return failures != 0;
}
