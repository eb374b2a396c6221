/* FMI 3.0: each function in each state, and bad arguments, against the official headers. Argument: the instantiation token. */
#include "fmi3Functions.h"
#define VERSION 3
#define FMI(name) fmi3##name
typedef fmi3Instance Instance;
typedef fmi3FMUState State;
#include "calls.h"

static int with_events = 1;

static void logger(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message) {
    messages++;
    last_status = status;
    if (environment != &messages || !category || !message || !*message) abort();
}

static Instance instantiate(void) {
    return fmi3InstantiateCoSimulation("calls", token, NULL, fmi3False, fmi3True, with_events, with_events, NULL, 0,
                                       &messages, with_logger ? logger : NULL, NULL);
}

static const fmi3ValueReference LOAD[] = {150}, WORK[] = {333}, STATUS[] = {440}, STOP[] = {270}, PLACE[] = {600};
static const fmi3ValueReference UNKNOWN[] = {99999}, RADIUS[] = {211}, SEED[] = {260}, MODE[] = {200}, GRID[] = {220, 221};

static int make_small(void) {
    const fmi3Int32 nodes[] = {21, 21};
    const fmi3Float64 position[] = {0.0, 0.0, -1.9059e-2};
    return fmi3SetInt32(fmu, GRID, 2, nodes, 2) || fmi3SetFloat64(fmu, PLACE, 1, position, 3);
}

static int enter(void) { return fmi3EnterInitializationMode(fmu, fmi3False, 0.0, 0.0, fmi3True, 1e-3); }
static int enter_step_mode(void) { return with_events ? fmi3EnterStepMode(fmu) : OK; }
static int load(double newton) { return fmi3SetFloat64(fmu, LOAD, 1, (fmi3Float64[]){0.0, 0.0, newton}, 3); }

static int step(double t, double h) {
    fmi3Boolean event, terminate, early;
    fmi3Float64 reached;
    return fmi3DoStep(fmu, t, h, fmi3True, &event, &terminate, &early, &reached);
}

/* ---- The calls ------------------------------------------------------------------------------------------------------- */

static fmi3Float64 real[12];
static fmi3Int32 int32[2] = {2, 2};
static fmi3Int64 int64[2];
static fmi3UInt64 uint64[2];
static fmi3Boolean boolean[2];
static fmi3IntervalQualifier qualifier[1];

/* A type that no variable has: none of it. */
#define NONE(name)                                                                        \
    static int call_Get##name(void) { return fmi3Get##name(fmu, NULL, 0, NULL, 0); } \
    static int call_Set##name(void) { return fmi3Set##name(fmu, NULL, 0, NULL, 0); }

CALL(EnterInitializationMode, fmu, fmi3False, 0.0, 0.0, fmi3False, 0.0)
CALL(EnterEventMode, fmu)
static int call_GetInput(void) { return fmi3GetFloat64(fmu, LOAD, 1, real, 3); }
static int call_GetOutput(void) { return fmi3GetFloat64(fmu, WORK, 1, real, 1); }
CALL(GetInt32, fmu, SEED, 1, int32, 1)
CALL(GetInt64, fmu, STATUS, 1, int64, 1)
CALL(GetBoolean, fmu, STOP, 1, boolean, 1)
static int call_SetParameter(void) { return fmi3SetFloat64(fmu, RADIUS, 1, (fmi3Float64[]){6.3e-3}, 1); }
CALL(SetInt32, fmu, SEED, 0, int32, 0) /* none: every Int32 is a fixed parameter */
CALL(SetInt64, fmu, MODE, 1, (fmi3Int64[]){0}, 1)
CALL(SetBoolean, fmu, STOP, 1, (fmi3Boolean[]){fmi3False}, 1)
NONE(Float32) NONE(Int8) NONE(UInt8) NONE(Int16) NONE(UInt16) NONE(UInt32) NONE(UInt64) NONE(String)
CALL(GetBinary, fmu, NULL, 0, NULL, NULL, 0)
CALL(SetBinary, fmu, NULL, 0, NULL, NULL, 0)
CALL(GetClock, fmu, NULL, 0, NULL)
CALL(SetClock, fmu, NULL, 0, NULL)
CALL(GetNumberOfVariableDependencies, fmu, WORK[0], &size)
CALL(GetVariableDependencies, fmu, WORK[0], NULL, NULL, NULL, NULL, 0)
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
CALL(ActivateModelPartition, fmu, 0, 0.0)

static const Row TABLE[] = {
#define FMI2 NO_ROW
#define FMI3 ROW
#include "states.inc"
};

/* ---- Bad arguments, after a step ------------------------------------------------------------------------------------- */

static void misuse_of_values(void) {
    static const fmi3Float64 one[4] = {1.0};
    fmi3Float32 float32[3];
    fmi3String text[1];
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
    check_silence();
}

/* Instantiated without event mode: from initialisation to step mode at once, and no way into event mode. */
static void check_more(void) {
    with_events = 0;
    reach(STEP);
    refused_call("EnterEventMode", "Step Mode without events", call_EnterEventMode, ERROR, 1);
    refused_call("EnterStepMode", "Step Mode without events", call_EnterStepMode, ERROR, 1);
    refused_call("UpdateDiscreteStates", "Step Mode without events", call_UpdateDiscreteStates, ERROR, 1);
    expect(call_DoStep() == OK, "DoStep", "Step Mode without events", "not OK");
    with_events = 1;
}

int main(int count, char **arguments) { return count == 2 ? run(arguments[1], TABLE, COUNT(TABLE)) : 2; }
