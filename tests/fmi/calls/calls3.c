/* FMI 3.0: each function in each state, and bad arguments, against the official headers. Argument: the instantiation token. */
#include "fmi3Functions.h"
#include "calls.h"

static const char *token;
static fmi3Instance fmu;
static fmi3FMUState saved; /* a state of the instance, taken before it failed or ended */
static int with_logger, with_events = 1;

static void logger(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message) {
    messages++;
    last_status = status;
    if (environment != &messages || !category || !message || !*message) abort();
}

static fmi3Instance instantiate(void) {
    return fmi3InstantiateCoSimulation("calls", token, NULL, fmi3False, fmi3True, with_events, with_events, NULL, 0,
                                       &messages, with_logger ? logger : NULL, NULL);
}

static const fmi3ValueReference LOAD[] = {150}, WORK[] = {333}, STATUS[] = {440}, STOP[] = {270};
static const fmi3ValueReference UNKNOWN[] = {99999}, RADIUS[] = {211}, SEED[] = {260}, MODE[] = {200}, GRID[] = {220, 221};

static void set_load(double newton) {
    const fmi3Float64 load[] = {0.0, 0.0, newton};
    if (fmi3SetFloat64(fmu, LOAD, 1, load, 3)) abort();
}

static int step(double t, double h) {
    fmi3Boolean event, terminate, early;
    fmi3Float64 reached;
    return fmi3DoStep(fmu, t, h, fmi3True, &event, &terminate, &early, &reached);
}

/* After fmi3InstantiateCoSimulation; in initialisation; in event mode; in step mode after a step; in step mode after a discarded
   step; after fmi3Terminate; after a failure, which the standard calls Terminated too. */
static const char *const STATES[] = {"Instantiated", "Initialization Mode", "Event Mode", "Step Mode", "discarded", "Terminated", "failed", NULL};
enum { INSTANTIATED, INITIALIZATION, EVENT, STEP, DISCARDED, TERMINATED, FAULTED };

static void reach(int state) {
    if (fmu) fmi3FreeInstance(fmu);
    fmu = NULL;
    saved = NULL;
    if (state < 0) return;
    const fmi3ValueReference place = 600;
    const fmi3Int32 nodes[] = {21, 21};
    const fmi3Float64 position[] = {0.0, 0.0, -1.9059e-2};
    if (!(fmu = instantiate()) || fmi3SetInt32(fmu, GRID, 2, nodes, 2)) abort();
    if (fmi3SetFloat64(fmu, &place, 1, position, 3)) abort();
    if (state >= INITIALIZATION && fmi3EnterInitializationMode(fmu, fmi3False, 0.0, 0.0, fmi3True, 1e-3)) abort();
    if (state >= EVENT && fmi3ExitInitializationMode(fmu)) abort();
    if (state >= STEP && with_events && fmi3EnterStepMode(fmu)) abort();
    if (state >= STEP && step(0.0, 1e-7)) abort();
    if (state >= STEP) set_load(0.0);
    if (fmi3GetFMUState(fmu, &saved)) abort();
    if (state == DISCARDED) {
        set_load(NOT_A_NUMBER);
        if (step(1e-7, 1e-7) != fmi3Discard) abort();
    }
    if (state == TERMINATED && fmi3Terminate(fmu)) abort();
    if (state == FAULTED) {
        set_load(1e12); /* the projectile becomes faster than the sheet can follow */
        if (step(1e-7, 1e-6) != fmi3Error) abort();
    }
}

static int image_possible(int state) { return state != FAULTED; }

static size_t image(unsigned char **bytes) {
    fmi3FMUState state = NULL;
    size_t size = 0;
    if (fmi3GetFMUState(fmu, &state) || fmi3SerializedFMUStateSize(fmu, state, &size)) abort();
    *bytes = malloc(size);
    if (fmi3SerializeFMUState(fmu, state, *bytes, size) || fmi3FreeFMUState(fmu, &state)) abort();
    return size;
}

/* ---- The calls ------------------------------------------------------------------------------------------------------- */

static fmi3Float64 real[12];
static fmi3Int32 int32[2] = {2, 2};
static fmi3Int64 int64[2];
static fmi3UInt64 uint64[2];
static fmi3Boolean boolean[2];
static fmi3IntervalQualifier qualifier[1];
static size_t size;

#define CALL(name, ...) \
    static int call_##name(void) { return fmi3##name(__VA_ARGS__); }
/* A type that no variable has: none of it. */
#define NONE(name)                                                                        \
    static int call_Get##name(void) { return fmi3Get##name(fmu, NULL, 0, NULL, 0); } \
    static int call_Set##name(void) { return fmi3Set##name(fmu, NULL, 0, NULL, 0); }

static int call_GetVersion(void) { return strcmp(fmi3GetVersion(), "3.0") ? ERROR : OK; }
CALL(SetDebugLogging, fmu, fmi3False, 0, NULL)
static int call_FreeInstance(void) {
    fmi3FreeInstance(fmu);
    fmu = NULL;
    return OK;
}
CALL(EnterInitializationMode, fmu, fmi3False, 0.0, 0.0, fmi3False, 0.0)
CALL(ExitInitializationMode, fmu)
CALL(EnterEventMode, fmu)
CALL(Terminate, fmu)
CALL(Reset, fmu)
CALL(GetFloat64, fmu, LOAD, 1, real, 3)
static int call_GetOutput(void) { return fmi3GetFloat64(fmu, WORK, 1, real, 1); }
CALL(GetInt32, fmu, SEED, 1, int32, 1)
CALL(GetInt64, fmu, STATUS, 1, int64, 1)
CALL(GetBoolean, fmu, STOP, 1, boolean, 1)
static int call_SetFloat64(void) {
    const fmi3Float64 load[3] = {0.0, 0.0, 1.0};
    return fmi3SetFloat64(fmu, LOAD, 1, load, 3);
}
static int call_SetParameter(void) {
    const fmi3Float64 radius = 6.3e-3;
    return fmi3SetFloat64(fmu, RADIUS, 1, &radius, 1);
}
static int call_SetInt32(void) {
    /* None: every Int32 is a fixed parameter. */
    return fmi3SetInt32(fmu, SEED, 0, int32, 0);
}
static int call_SetInt64(void) {
    const fmi3Int64 mode = 0;
    return fmi3SetInt64(fmu, MODE, 1, &mode, 1);
}
static int call_SetBoolean(void) {
    const fmi3Boolean no = fmi3False;
    return fmi3SetBoolean(fmu, STOP, 1, &no, 1);
}
NONE(Float32)
NONE(Int8)
NONE(UInt8)
NONE(Int16)
NONE(UInt16)
NONE(UInt32)
NONE(UInt64)
NONE(String)
CALL(GetBinary, fmu, NULL, 0, NULL, NULL, 0)
CALL(SetBinary, fmu, NULL, 0, NULL, NULL, 0)
CALL(GetClock, fmu, NULL, 0, NULL)
CALL(SetClock, fmu, NULL, 0, NULL)
CALL(GetNumberOfVariableDependencies, fmu, WORK[0], &size)
CALL(GetVariableDependencies, fmu, WORK[0], NULL, NULL, NULL, NULL, 0)
static int call_GetFMUState(void) {
    fmi3FMUState state = NULL;
    return fmi3GetFMUState(fmu, &state);
}
CALL(SetFMUState, fmu, saved)
CALL(FreeFMUState, fmu, &saved)
CALL(SerializedFMUStateSize, fmu, saved, &size)
static int call_SerializeFMUState(void) {
    if (fmi3SerializedFMUStateSize(fmu, saved, &size)) return ERROR;
    fmi3Byte *bytes = malloc(size);
    int result = fmi3SerializeFMUState(fmu, saved, bytes, size);
    free(bytes);
    return result;
}
static int call_DeserializeFMUState(void) {
    fmi3FMUState state = NULL;
    if (fmi3SerializedFMUStateSize(fmu, saved, &size)) return ERROR;
    fmi3Byte *bytes = malloc(size);
    int result = fmi3SerializeFMUState(fmu, saved, bytes, size);
    if (result == OK) result = fmi3DeserializeFMUState(fmu, bytes, size, &state);
    free(bytes);
    return result;
}
CALL(GetDirectionalDerivative, fmu, WORK, 1, LOAD, 1, real, 3, real, 1)
CALL(GetAdjointDerivative, fmu, WORK, 1, LOAD, 1, real, 1, real, 3)
CALL(EnterConfigurationMode, fmu)
CALL(ExitConfigurationMode, fmu)
CALL(GetIntervalDecimal, fmu, WORK, 1, real, qualifier)
CALL(GetIntervalFraction, fmu, WORK, 1, uint64, uint64, qualifier)
CALL(GetShiftDecimal, fmu, WORK, 1, real)
CALL(GetShiftFraction, fmu, WORK, 1, uint64, uint64)
CALL(SetIntervalDecimal, fmu, WORK, 1, real)
CALL(SetIntervalFraction, fmu, WORK, 1, uint64, uint64)
CALL(SetShiftDecimal, fmu, WORK, 1, real)
CALL(SetShiftFraction, fmu, WORK, 1, uint64, uint64)
CALL(EvaluateDiscreteStates, fmu)
CALL(UpdateDiscreteStates, fmu, boolean, boolean, boolean, boolean, boolean, real)
CALL(EnterContinuousTimeMode, fmu)
CALL(CompletedIntegratorStep, fmu, fmi3True, boolean, boolean)
CALL(SetTime, fmu, 0.0)
CALL(SetContinuousStates, fmu, real, 1)
CALL(GetContinuousStateDerivatives, fmu, real, 1)
CALL(GetEventIndicators, fmu, real, 1)
CALL(GetContinuousStates, fmu, real, 1)
CALL(GetNominalsOfContinuousStates, fmu, real, 1)
CALL(GetNumberOfEventIndicators, fmu, &size)
CALL(GetNumberOfContinuousStates, fmu, &size)
CALL(EnterStepMode, fmu)
CALL(GetOutputDerivatives, fmu, WORK, 1, int32, real, 1)
static int call_DoStep(void) { return step(1e-7, 1e-7); }
CALL(ActivateModelPartition, fmu, 0, 0.0)

/* FMI 3.0, sections 2.3 ("State machine and semantics") and 4.2 ("State machine for co-simulation").
   D: the step is still discarded, for the input is still bad.
   e: a failed simulation has no state worth saving and no outputs worth reading; parameters, inputs and status are read. */
static const Row TABLE[] = {
    /*                                                            Instantiated
                                                                  | Initialization Mode
                                                                  | | Event Mode
                                                                  | | | Step Mode
                                                                  | | | | Step Mode, after a discarded step
                                                                  | | | | | Terminated
                                                                  | | | | | | Terminated by a failure */
    {"GetVersion", call_GetVersion, "+ + + + + + +"},
    {"SetDebugLogging", call_SetDebugLogging, "+ + + + + + +"},
    {"FreeInstance", call_FreeInstance, "+ + + + + + +"},
    {"EnterInitializationMode", call_EnterInitializationMode, "+ - - - - - -"},
    {"ExitInitializationMode", call_ExitInitializationMode, "- + - - - - -"},
    {"EnterEventMode", call_EnterEventMode, "- - - + + - -"},
    {"Terminate", call_Terminate, "- - + + + - -"},
    {"Reset", call_Reset, "+ + + + + + +"},
    {"GetFloat64, an input", call_GetFloat64, "+ + + + + + +"},
    {"GetFloat64, an output", call_GetOutput, "+ + + + + + e"},
    {"GetInt32", call_GetInt32, "+ + + + + + +"},
    {"GetInt64", call_GetInt64, "+ + + + + + +"},
    {"GetBoolean", call_GetBoolean, "+ + + + + + +"},
    {"GetFloat32 of none", call_GetFloat32, "+ + + + + + +"},
    {"GetInt8 of none", call_GetInt8, "+ + + + + + +"},
    {"GetUInt8 of none", call_GetUInt8, "+ + + + + + +"},
    {"GetInt16 of none", call_GetInt16, "+ + + + + + +"},
    {"GetUInt16 of none", call_GetUInt16, "+ + + + + + +"},
    {"GetUInt32 of none", call_GetUInt32, "+ + + + + + +"},
    {"GetUInt64 of none", call_GetUInt64, "+ + + + + + +"},
    {"GetString of none", call_GetString, "+ + + + + + +"},
    {"GetBinary of none", call_GetBinary, "+ + + + + + +"},
    {"GetClock of none", call_GetClock, "+ + + + + + +"},
    {"SetFloat64, an input", call_SetFloat64, "+ + + + + - -"},
    {"SetFloat64, a fixed parameter", call_SetParameter, "+ + - - - - -"},
    {"SetInt32, a tunable parameter", call_SetInt32, "+ + + + + - -"},
    {"SetInt64, a fixed parameter", call_SetInt64, "+ + - - - - -"},
    {"SetBoolean, a tunable parameter", call_SetBoolean, "+ + + + + - -"},
    {"SetFloat32 of none", call_SetFloat32, "+ + + + + - -"},
    {"SetInt8 of none", call_SetInt8, "+ + + + + - -"},
    {"SetUInt8 of none", call_SetUInt8, "+ + + + + - -"},
    {"SetInt16 of none", call_SetInt16, "+ + + + + - -"},
    {"SetUInt16 of none", call_SetUInt16, "+ + + + + - -"},
    {"SetUInt32 of none", call_SetUInt32, "+ + + + + - -"},
    {"SetUInt64 of none", call_SetUInt64, "+ + + + + - -"},
    {"SetString of none", call_SetString, "+ + + + + - -"},
    {"SetBinary of none", call_SetBinary, "+ + + + + - -"},
    {"SetClock of none", call_SetClock, "+ + + + + - -"},
    {"GetNumberOfVariableDependencies", call_GetNumberOfVariableDependencies, "u u u u u u u"}, /* these two: providesPerElementDependencies */
    {"GetVariableDependencies", call_GetVariableDependencies, "u u u u u u u"},
    {"GetFMUState", call_GetFMUState, "+ + + + + + e"},
    {"SetFMUState", call_SetFMUState, "+ + + + + + +"},
    {"FreeFMUState", call_FreeFMUState, "+ + + + + + +"},
    {"SerializedFMUStateSize", call_SerializedFMUStateSize, "+ + + + + + +"},
    {"SerializeFMUState", call_SerializeFMUState, "+ + + + + + +"},
    {"DeserializeFMUState", call_DeserializeFMUState, "+ + + + + + +"},
    {"GetDirectionalDerivative", call_GetDirectionalDerivative, "- u u u u u u"},
    {"GetAdjointDerivative", call_GetAdjointDerivative, "- u u u u u u"},
    {"EnterConfigurationMode", call_EnterConfigurationMode, "u - u u u - -"}, /* structural parameters */
    {"ExitConfigurationMode", call_ExitConfigurationMode, "- - - - - - -"},
    {"GetIntervalDecimal", call_GetIntervalDecimal, "- u u u u - -"}, /* these eight: clocks */
    {"GetIntervalFraction", call_GetIntervalFraction, "- u u u u - -"},
    {"GetShiftDecimal", call_GetShiftDecimal, "- u u u u - -"},
    {"GetShiftFraction", call_GetShiftFraction, "- u u u u - -"},
    {"SetIntervalDecimal", call_SetIntervalDecimal, "- u u u u - -"},
    {"SetIntervalFraction", call_SetIntervalFraction, "- u u u u - -"},
    {"SetShiftDecimal", call_SetShiftDecimal, "- u u u u - -"},
    {"SetShiftFraction", call_SetShiftFraction, "- u u u u - -"},
    {"EvaluateDiscreteStates", call_EvaluateDiscreteStates, "- u u - - - -"}, /* providesEvaluateDiscreteStates */
    {"UpdateDiscreteStates", call_UpdateDiscreteStates, "- - + - - - -"},
    {"EnterContinuousTimeMode", call_EnterContinuousTimeMode, "- - - - - - -"}, /* these ten: model exchange */
    {"CompletedIntegratorStep", call_CompletedIntegratorStep, "- - - - - - -"},
    {"SetTime", call_SetTime, "- - - - - - -"},
    {"SetContinuousStates", call_SetContinuousStates, "- - - - - - -"},
    {"GetContinuousStateDerivatives", call_GetContinuousStateDerivatives, "- - - - - - -"},
    {"GetEventIndicators", call_GetEventIndicators, "- - - - - - -"},
    {"GetContinuousStates", call_GetContinuousStates, "- - - - - - -"},
    {"GetNominalsOfContinuousStates", call_GetNominalsOfContinuousStates, "- - - - - - -"},
    {"GetNumberOfEventIndicators", call_GetNumberOfEventIndicators, "- - - - - - -"},
    {"GetNumberOfContinuousStates", call_GetNumberOfContinuousStates, "- - - - - - -"},
    {"EnterStepMode", call_EnterStepMode, "- - + - - - -"},
    {"GetOutputDerivatives", call_GetOutputDerivatives, "- - - u u u u"}, /* maxOutputDerivativeOrder = 0 */
    {"DoStep", call_DoStep, "- - - + D - -"},
    {"ActivateModelPartition", call_ActivateModelPartition, "- - - - - - -"}, /* scheduled execution */
};

/* ---- Bad arguments, after a step ------------------------------------------------------------------------------------- */

static const fmi3String strange[] = {"nonsense"}, none[] = {NULL};
static const fmi3Float64 one[4] = {1.0};
static fmi3Byte few[8];
static fmi3FMUState nowhere = &zero, empty;
static fmi3Float32 float32[3];
static fmi3String text[1];

static int step_with_load(double newton) {
    set_load(newton);
    int result = step(1e-7, 1e-7);
    set_load(0.0);
    return result;
}

static void misuse(int logger_given) {
    MISUSE("unknown value reference", ERROR, fmi3GetFloat64(fmu, UNKNOWN, 1, real, 1))
    MISUSE("set an unknown value reference", ERROR, fmi3SetFloat64(fmu, UNKNOWN, 1, one, 1))
    MISUSE("an element by itself", ERROR, fmi3GetFloat64(fmu, (fmi3ValueReference[]){151}, 1, real, 1))
    MISUSE("a Float64 read as Int32", ERROR, fmi3GetInt32(fmu, WORK, 1, int32, 1))
    MISUSE("an Enumeration read as Int32", ERROR, fmi3GetInt32(fmu, STATUS, 1, int32, 1))
    MISUSE("an Int32 read as Int64", ERROR, fmi3GetInt64(fmu, SEED, 1, int64, 1))
    MISUSE("a Boolean read as Int32", ERROR, fmi3GetInt32(fmu, STOP, 1, int32, 1))
    MISUSE("a Float64 read as Int64", ERROR, fmi3GetInt64(fmu, WORK, 1, int64, 1))
    MISUSE("a Boolean read as Int64", ERROR, fmi3GetInt64(fmu, STOP, 1, int64, 1))
    MISUSE("an Int32 read as Float64", ERROR, fmi3GetFloat64(fmu, SEED, 1, real, 1))
    MISUSE("an Enumeration read as Float64", ERROR, fmi3GetFloat64(fmu, STATUS, 1, real, 1))
    MISUSE("a Boolean read as Float64", ERROR, fmi3GetFloat64(fmu, STOP, 1, real, 1))
    MISUSE("an Int32 read as Boolean", ERROR, fmi3GetBoolean(fmu, SEED, 1, boolean, 1))
    MISUSE("a Float64 read as Boolean", ERROR, fmi3GetBoolean(fmu, WORK, 1, boolean, 1))
    MISUSE("a Float64 read as Float32", ERROR, fmi3GetFloat32(fmu, LOAD, 1, float32, 3))
    MISUSE("a Float64 read as String", ERROR, fmi3GetString(fmu, LOAD, 1, text, 1))
    MISUSE("value references NULL", ERROR, fmi3GetFloat64(fmu, NULL, 1, real, 1))
    MISUSE("values NULL", ERROR, fmi3GetFloat64(fmu, LOAD, 1, NULL, 3))
    MISUSE("too few values", ERROR, fmi3GetFloat64(fmu, LOAD, 1, real, 2))
    MISUSE("too many values", ERROR, fmi3GetFloat64(fmu, LOAD, 1, real, 4))
    MISUSE("no values", ERROR, fmi3GetFloat64(fmu, LOAD, 1, real, 0))
    MISUSE("set value references NULL", ERROR, fmi3SetFloat64(fmu, NULL, 1, one, 1))
    MISUSE("set values NULL", ERROR, fmi3SetFloat64(fmu, LOAD, 1, NULL, 3))
    MISUSE("set too few values", ERROR, fmi3SetFloat64(fmu, LOAD, 1, one, 2))
    MISUSE("set too many values", ERROR, fmi3SetFloat64(fmu, LOAD, 1, one, 4))
    MISUSE("an array longer than memory", ERROR, fmi3GetFloat64(fmu, LOAD, (size_t)-1, real, (size_t)-1))
    MISUSE("set an output", ERROR, fmi3SetFloat64(fmu, WORK, 1, one, 1))
    MISUSE("set the time", ERROR, fmi3SetFloat64(fmu, (fmi3ValueReference[]){0}, 1, one, 1))
    MISUSE("set a fixed Int32", ERROR, fmi3SetInt32(fmu, SEED, 1, int32, 1))
    MISUSE("unknown log category", ERROR, fmi3SetDebugLogging(fmu, fmi3True, 1, strange))
    MISUSE("log category NULL", ERROR, fmi3SetDebugLogging(fmu, fmi3True, 1, none))
    MISUSE("log categories NULL", ERROR, fmi3SetDebugLogging(fmu, fmi3True, 1, NULL))
    MISUSE("get state into NULL", ERROR, fmi3GetFMUState(fmu, NULL))
    MISUSE("get state into a stranger's", ERROR, fmi3GetFMUState(fmu, &nowhere))
    MISUSE("set state NULL", ERROR, fmi3SetFMUState(fmu, NULL))
    MISUSE("set a stranger's state", ERROR, fmi3SetFMUState(fmu, nowhere))
    MISUSE("free a stranger's state", ERROR, fmi3FreeFMUState(fmu, &nowhere))
    MISUSE("size of a stranger's state", ERROR, fmi3SerializedFMUStateSize(fmu, nowhere, &size))
    MISUSE("size into NULL", ERROR, fmi3SerializedFMUStateSize(fmu, saved, NULL))
    MISUSE("serialise into NULL", ERROR, fmi3SerializeFMUState(fmu, saved, NULL, 1 << 20))
    MISUSE("serialise into too few bytes", ERROR, fmi3SerializeFMUState(fmu, saved, few, sizeof few))
    expect(!few[0] && !few[7], "SerializeFMUState", "too few bytes", "written");
    MISUSE("deserialise NULL", ERROR, fmi3DeserializeFMUState(fmu, NULL, 1 << 20, &empty))
    MISUSE("deserialise no bytes", ERROR, fmi3DeserializeFMUState(fmu, NULL, 0, &empty))
    MISUSE("deserialise junk", ERROR, fmi3DeserializeFMUState(fmu, (fmi3Byte[64]){1, 2, 3}, 64, &empty))
    MISUSE("deserialise into NULL", ERROR, fmi3DeserializeFMUState(fmu, (fmi3Byte[64]){1, 2, 3}, 64, NULL))
    MISUSE("h = 0", ERROR, step(1e-7, 0.0))
    MISUSE("h < 0", ERROR, step(1e-7, -1e-7))
    MISUSE("h not a number", ERROR, step(1e-7, NOT_A_NUMBER))
    MISUSE("h infinite", ERROR, step(1e-7, 1.0 / zero))
    MISUSE("t not a number", ERROR, step(NOT_A_NUMBER, 1e-7))
    MISUSE("t half a step late", ERROR, step(1.5e-7, 1e-7))
    MISUSE("t half a step early", ERROR, step(0.5e-7, 1e-7))
    MISUSE("past the stop time", ERROR, step(1e-7, 2e-3))
    MISUSE("load not a number", DISCARD, step_with_load(NOT_A_NUMBER))
    MISUSE("load infinite", DISCARD, step_with_load(1.0 / zero))
}

/* No instance comes of these; with a logger each says why. */
static void check_instantiate(void) {
    char other[100] = "";
    strncpy(other, token, sizeof other - 1);
    other[20] ^= 1;
    struct {
        const char *what;
        fmi3Instance made;
    } refused[] = {
        {"wrong token", fmi3InstantiateCoSimulation("calls", "{wrong}", NULL, 0, 0, 0, 0, NULL, 0, &messages, logger, NULL)},
        {"another token", fmi3InstantiateCoSimulation("calls", other, NULL, 0, 0, 0, 0, NULL, 0, &messages, logger, NULL)},
        {"token NULL", fmi3InstantiateCoSimulation("calls", NULL, NULL, 0, 0, 0, 0, NULL, 0, &messages, logger, NULL)},
        {"name NULL", fmi3InstantiateCoSimulation(NULL, token, NULL, 0, 0, 0, 0, NULL, 0, &messages, logger, NULL)},
        {"name empty", fmi3InstantiateCoSimulation("", token, NULL, 0, 0, 0, 0, NULL, 0, &messages, logger, NULL)},
        {"name blank", fmi3InstantiateCoSimulation("\t ", token, NULL, 0, 0, 0, 0, NULL, 0, &messages, logger, NULL)},
        {"model exchange", fmi3InstantiateModelExchange("calls", token, NULL, 0, 0, &messages, logger)},
        {"scheduled execution", fmi3InstantiateScheduledExecution("calls", token, NULL, 0, 0, &messages, logger, NULL, NULL, NULL)},
        {"wrong token, no logger", fmi3InstantiateCoSimulation("calls", "", NULL, 0, 1, 0, 0, NULL, 0, NULL, NULL, NULL)},
    };
    for (size_t k = 0; k < COUNT(refused); k++) expect(!refused[k].made, refused[k].what, "instantiation", "an instance came of it");
    expect(messages == 8, "instantiation", "refusals", "not one message each");
}

/* After everything in the table a good step gives what it gives without. */
static void check_undisturbed(int logger_given) {
    unsigned char *plain = NULL, *misused = NULL;
    reach(STEP);
    if (step(1e-7, 1e-7)) abort();
    size_t bytes = image(&plain);
    reach(STEP);
    misuse(logger_given);
    set_load(0.0);
    expect(step(1e-7, 1e-7) == fmi3OK, "DoStep", "after misuse", "not OK");
    expect(image(&misused) == bytes && !memcmp(plain, misused, bytes), "DoStep", "after misuse", "not the undisturbed run");
    free(plain);
    free(misused);
}

/* Instantiated without event mode: from initialisation to step mode at once, and no way into event mode. */
static void check_without_events(void) {
    with_events = 0;
    reach(STEP);
    refused_call("EnterEventMode", "Step Mode without events", call_EnterEventMode, ERROR, 1, with_logger);
    refused_call("EnterStepMode", "Step Mode without events", call_EnterStepMode, ERROR, 1, with_logger);
    refused_call("UpdateDiscreteStates", "Step Mode without events", call_UpdateDiscreteStates, ERROR, 1, with_logger);
    expect(call_DoStep() == OK, "DoStep", "Step Mode without events", "not OK");
    with_events = 1;
}

/* Without logging the logger is not called; it can be switched on later. */
static void check_silence(void) {
    reach(-1);
    messages = 0;
    fmu = fmi3InstantiateCoSimulation("calls", token, NULL, fmi3False, fmi3False, 0, 0, NULL, 0, &messages, logger, NULL);
    expect(fmu && step(0.0, 1e-7) == fmi3Error && messages == 0, "logger", "loggingOn = fmi3False", "called");
    const fmi3String errors[] = {"logStatusError"};
    expect(fmi3SetDebugLogging(fmu, fmi3True, 1, errors) == fmi3OK, "SetDebugLogging", "Instantiated", "not OK");
    expect(step(0.0, 1e-7) == fmi3Error && messages == 1, "logger", "switched on", "not called once");
}

int main(int count, char **arguments) {
    if (count != 2) return 2;
    token = arguments[1];
    check_instantiate();
    check_silence();
    for (with_logger = 1; with_logger >= 0; with_logger--) {
        check_table(TABLE, COUNT(TABLE), STATES, with_logger);
        check_undisturbed(with_logger);
        check_without_events();
    }
    reach(-1); /* from here on every call is made on NULL */
    for (size_t r = 0; r < COUNT(TABLE); r++) {
        int of_no_instance = TABLE[r].call == call_GetVersion || TABLE[r].call == call_FreeInstance;
        expect(TABLE[r].call() == (of_no_instance ? OK : ERROR), TABLE[r].name, "NULL instance", "wrong status");
    }
    printf("%d checks, %d failures\n", checks, failures);
    return failures != 0;
}
