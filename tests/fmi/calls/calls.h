/* What the programs for FMI 2.0 and 3.0 share: the answers of states.inc, and bad arguments of the functions that both have.
   The program that includes this has defined VERSION, Instance, State and FMI(name). */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { OK, WARNING, DISCARD, ERROR };
enum { INSTANTIATED, INITIALIZATION, EVENT, STEP, DISCARDED, TERMINATED, FAILED, STATES };
static const char *const STATE[] = {"instantiated", "initialisation", "event mode", "step mode", "discarded", "terminated", "failed"};
#define NOT_A_NUMBER (0.0 / zero)
#define H 1e-7 /* a step, s */
static double zero = 0.0;

typedef struct {
    const char *name;
    int (*call)(void);
    const char *answers;
} Row;

/* Of the program: a new instance, its small sheet, the way to step mode, a load in N, a step; its own checks. */
static Instance instantiate(void);
static int make_small(void), enter(void), enter_step_mode(void), load(double newton), step(double t, double h);
static void misuse_of_values(void), check_instantiate(void), check_more(void);

static const char *token;
static Instance fmu;
static State saved;                /* a state of the instance, taken before it failed or ended */
static int with_logger;
static int messages, last_status; /* what the logger was told since the last call */
static int checks, failures;

static void expect(int holds, const char *name, const char *state, const char *what) {
    checks++;
    if (!holds) {
        failures++;
        printf("%s in %s: %s\n", name, state, what);
    }
}

static void set_load(double newton) {
    if (load(newton)) abort();
}

/* An instance in this state; -1: none. */
static void reach(int state) {
    if (fmu) FMI(FreeInstance)(fmu);
    fmu = NULL;
    saved = NULL;
    if (state < 0) return;
    if (!(fmu = instantiate()) || make_small()) abort();
    if (state >= INITIALIZATION && enter()) abort();
    if (state >= EVENT && FMI(ExitInitializationMode)(fmu)) abort();
    if (state >= STEP && (enter_step_mode() || step(0.0, H))) abort();
    if (state >= STEP) set_load(0.0);
    if (FMI(GetFMUState)(fmu, &saved)) abort();
    if (state == DISCARDED) {
        set_load(NOT_A_NUMBER);
        if (step(H, H) != DISCARD) abort();
    }
    if (state == TERMINATED && FMI(Terminate)(fmu)) abort();
    if (state == FAILED) {
        set_load(1e12); /* the projectile becomes faster than the sheet can follow */
        if (step(H, 1e-6) != ERROR) abort();
    }
}

static size_t image(unsigned char **bytes) {
    State state = NULL;
    size_t size = 0;
    if (FMI(GetFMUState)(fmu, &state) || FMI(SerializedFMUStateSize)(fmu, state, &size)) abort();
    *bytes = malloc(size);
    if (FMI(SerializeFMUState)(fmu, state, (void *)*bytes, size) || FMI(FreeFMUState)(fmu, &state)) abort();
    return size;
}

static unsigned char *before; /* the image before a call that must be refused */
static size_t before_bytes;

static void look_before(int compare) {
    before_bytes = compare ? image(&before) : 0;
    messages = 0;
}

/* What a call has answered that must be refused with `status`: that, one message of that status, and the same image as before. */
static void refused(const char *name, const char *state, int answer, int status, int compare) {
    unsigned char *after = NULL;
    expect(answer == status, name, state, status == ERROR ? "not refused with Error" : "not discarded");
    if (with_logger) expect(messages == 1 && last_status == status, name, state, "not one message of that status");
    if (compare) expect(image(&after) == before_bytes && !memcmp(before, after, before_bytes), name, state, "something has changed");
    free(before);
    free(after);
    before = NULL;
}

static void refused_call(const char *name, const char *state, int (*call)(void), int status, int compare) {
    look_before(compare);
    refused(name, state, call(), status, compare);
}

/* A call with a bad argument, refused with `status`. */
#define MISUSE(what, status, call) \
    look_before(1);                \
    refused(what, "misuse", call, status, 1);

/* ---- The functions that both have ------------------------------------------------------------------------------------ */

static size_t size;
#define CALL(name, ...) \
    static int call_##name(void) { return FMI(name)(__VA_ARGS__); }

CALL(SetDebugLogging, fmu, 0, 0, NULL)
CALL(ExitInitializationMode, fmu)
CALL(Terminate, fmu)
CALL(Reset, fmu)
CALL(SetFMUState, fmu, saved)
CALL(FreeFMUState, fmu, &saved)
CALL(SerializedFMUStateSize, fmu, saved, &size)
static int call_FreeInstance(void) {
    FMI(FreeInstance)(fmu);
    fmu = NULL;
    return OK;
}
static int call_GetFMUState(void) {
    State state = NULL;
    return FMI(GetFMUState)(fmu, &state);
}
static int serialized(int and_back) {
    State state = NULL;
    if (FMI(SerializedFMUStateSize)(fmu, saved, &size)) return ERROR;
    void *bytes = malloc(size);
    int result = FMI(SerializeFMUState)(fmu, saved, bytes, size);
    if (result == OK && and_back) result = FMI(DeserializeFMUState)(fmu, bytes, size, &state);
    free(bytes);
    return result;
}
static int call_SerializeFMUState(void) { return serialized(0); }
static int call_DeserializeFMUState(void) { return serialized(1); }
static int call_DoStep(void) { return step(H, H); }
static int call_SetInput(void) { return load(1.0); }
static int call_GetVersion(void) { return strcmp(FMI(GetVersion)(), VERSION == 2 ? "2.0" : "3.0") ? ERROR : OK; }

static int step_with_load(double newton) {
    set_load(newton);
    int result = step(H, H);
    set_load(0.0);
    return result;
}

static void misuse(void) {
    static const char *strange[] = {"nonsense"}, *none[] = {NULL};
    static char few[8], junk[64] = {1, 2, 3};
    static State nowhere = &zero, empty;
    misuse_of_values();
    MISUSE("unknown log category", ERROR, FMI(SetDebugLogging)(fmu, 1, 1, strange))
    MISUSE("log category NULL", ERROR, FMI(SetDebugLogging)(fmu, 1, 1, none))
    MISUSE("log categories NULL", ERROR, FMI(SetDebugLogging)(fmu, 1, 1, NULL))
    MISUSE("get state into NULL", ERROR, FMI(GetFMUState)(fmu, NULL))
    MISUSE("get state into a stranger's", ERROR, FMI(GetFMUState)(fmu, &nowhere))
    MISUSE("set state NULL", ERROR, FMI(SetFMUState)(fmu, NULL))
    MISUSE("set a stranger's state", ERROR, FMI(SetFMUState)(fmu, nowhere))
    MISUSE("free a stranger's state", ERROR, FMI(FreeFMUState)(fmu, &nowhere))
    MISUSE("size of a stranger's state", ERROR, FMI(SerializedFMUStateSize)(fmu, nowhere, &size))
    MISUSE("size into NULL", ERROR, FMI(SerializedFMUStateSize)(fmu, saved, NULL))
    MISUSE("serialise into NULL", ERROR, FMI(SerializeFMUState)(fmu, saved, NULL, 1 << 20))
    MISUSE("serialise into too few bytes", ERROR, FMI(SerializeFMUState)(fmu, saved, (void *)few, sizeof few))
    expect(!few[0] && !few[7], "SerializeFMUState", "too few bytes", "written");
    MISUSE("deserialise NULL", ERROR, FMI(DeserializeFMUState)(fmu, NULL, 1 << 20, &empty))
    MISUSE("deserialise no bytes", ERROR, FMI(DeserializeFMUState)(fmu, NULL, 0, &empty))
    MISUSE("deserialise junk", ERROR, FMI(DeserializeFMUState)(fmu, (void *)junk, sizeof junk, &empty))
    MISUSE("deserialise into NULL", ERROR, FMI(DeserializeFMUState)(fmu, (void *)junk, sizeof junk, NULL))
    MISUSE("h = 0", ERROR, step(H, 0.0))
    MISUSE("h < 0", ERROR, step(H, -H))
    MISUSE("h not a number", ERROR, step(H, NOT_A_NUMBER))
    MISUSE("h infinite", ERROR, step(H, 1.0 / zero))
    MISUSE("t not a number", ERROR, step(NOT_A_NUMBER, H))
    MISUSE("t half a step late", ERROR, step(1.5 * H, H))
    MISUSE("t half a step early", ERROR, step(0.5 * H, H))
    MISUSE("past the stop time", ERROR, step(H, 2e-3))
    MISUSE("load not a number", DISCARD, step_with_load(NOT_A_NUMBER))
    MISUSE("load infinite", DISCARD, step_with_load(1.0 / zero))
}

/* After all misuse a good step gives what it gives without. */
static void check_undisturbed(void) {
    unsigned char *plain = NULL, *misused = NULL;
    reach(STEP);
    if (step(H, H)) abort();
    size_t bytes = image(&plain);
    reach(STEP);
    misuse();
    expect(step(H, H) == OK, "DoStep", "after misuse", "not OK");
    expect(image(&misused) == bytes && !memcmp(plain, misused, bytes), "DoStep", "after misuse", "not the undisturbed run");
    free(plain);
    free(misused);
}

static void check_answers(const Row *row) {
    for (int s = 0; s < STATES; s++) {
        char answer = row->answers[2 * s];
        if (VERSION == 2 && s == EVENT) continue;
        reach(s);
        messages = 0;
        switch (answer) {
            case '+': expect(row->call() == OK, row->name, STATE[s], "not OK"); break;
            case 'D': refused_call(row->name, STATE[s], row->call, DISCARD, 1); break;
            case '-':
            case 'u':
            case 'e': refused_call(row->name, STATE[s], row->call, ERROR, s != FAILED); break;
            default: expect(0, row->name, STATE[s], "no such answer");
        }
    }
}

#define COUNT(array) (sizeof(array) / sizeof *(array))

static int run(const char *of, const Row *rows, size_t count) {
    token = of;
    check_instantiate();
    for (with_logger = 1; with_logger >= 0; with_logger--) {
        for (size_t r = 0; r < count; r++) check_answers(&rows[r]);
        check_undisturbed();
        check_more();
    }
    reach(-1); /* from here on every call is made on NULL */
    for (size_t r = 0; r < count; r++) {
        const char *name = rows[r].name;
        int static_one = !strcmp(name, "GetTypesPlatform") || !strcmp(name, "GetVersion") || !strcmp(name, "FreeInstance");
        expect(rows[r].call() == (static_one ? OK : ERROR), name, "NULL instance", "wrong status");
    }
    printf("%d checks, %d failures\n", checks, failures);
    return failures != 0;
}

/* What a row of states.inc becomes. */
#define ROW(name, answers) {#name, call_##name, answers},
#define NO_ROW(name, answers)
#define BOTH ROW
