/* FragmentTrajectory: the fragment of fragment.c as a small FMI 2.0 co-simulation FMU, to be connected with FabricShield.

   All variables are Real, and a value reference is a place in `value`: see FragmentTrajectory.xml. States cannot be saved. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

#include "../fragment.h"

#define TOKEN "{FragmentTrajectory-2}"

/* Value references: parameters, inputs, outputs. */
enum {
    MASS, MOMENTS, DRAG_COEFFICIENT = MOMENTS + 3, FRONTAL_AREA, TICK,
    START_POSITION, START_VELOCITY = START_POSITION + 3, START_ORIENTATION = START_VELOCITY + 3,
    START_ANGULAR_VELOCITY = START_ORIENTATION + 4,
    FORCE = START_ANGULAR_VELOCITY + 3, TORQUE = FORCE + 3,
    POSITION = TORQUE + 3, VELOCITY = POSITION + 3, ORIENTATION = VELOCITY + 3, ANGULAR_VELOCITY = ORIENTATION + 4,
    KINETIC_ENERGY = ANGULAR_VELOCITY + 3, COUNT
};

/* Start values of the parameters: the sector of a turbine disc, 0.4 mm before the sheet. */
static const double START[FORCE] = {
    0.118, 2.985698146640359e-05, 8.515087512869415e-06, 3.640540231260633e-05, 1.05, 0.0006928203230275509, 1e-7,
    -0.022984880036043077, 0.0, 0.5157207129167358, 0.0, 0.0, 100.0, 0.5, -0.5, -0.5, -0.5, 0.0, 4350.68618340352, 0.0,
};

typedef enum { INSTANTIATED, INITIALIZING, STEPPING, TERMINATED } phase;

typedef struct {
    fmi2CallbackFunctions host;
    phase phase;
    fragment fragment;
    double value[COUNT];
} instance;

static fmi2Status refuse(instance *it, const char *what)
{
    if (it && it->host.logger) it->host.logger(it->host.componentEnvironment, "FragmentTrajectory", fmi2Error, "logStatusError", "%s", what);
    return fmi2Error;
}

static void copy(double *to, const double *from, int count) { memcpy(to, from, (size_t)count * sizeof *to); }

/* Outputs from the fragment's motion. */
static void publish(instance *it)
{
    const fragment *f = &it->fragment;
    double *rate = it->value + ANGULAR_VELOCITY, energy = 0.0;
    copy(it->value + POSITION, f->position, 3);
    copy(it->value + VELOCITY, f->velocity, 3);
    copy(it->value + ORIENTATION, f->orientation, 4);
    fragment_angular_velocity(f, rate);
    for (int k = 0; k < 3; k++) energy += 0.5 * (f->body.mass * f->velocity[k] * f->velocity[k] + f->angular_momentum[k] * rate[k]);
    it->value[KINETIC_ENERGY] = energy;
}

static void launch(instance *it)
{
    const double *p = it->value;
    const fragment_body body = {p[MASS], {p[MOMENTS], p[MOMENTS + 1], p[MOMENTS + 2]}, p[DRAG_COEFFICIENT], p[FRONTAL_AREA]};
    it->fragment = fragment_in_motion(&body, p + START_POSITION, p + START_VELOCITY, p + START_ORIENTATION, p + START_ANGULAR_VELOCITY);
    publish(it);
}

static void start(instance *it)
{
    it->phase = INSTANTIATED;
    memset(it->value, 0, sizeof it->value);
    copy(it->value, START, FORCE);
    launch(it);
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token, fmi2String resources,
                              const fmi2CallbackFunctions *host, fmi2Boolean visible, fmi2Boolean logging)
{
    (void)name, (void)resources, (void)visible, (void)logging;
    instance *it = type == fmi2CoSimulation && token && strcmp(token, TOKEN) == 0 ? calloc(1, sizeof *it) : NULL;
    if (!it) return NULL;
    if (host) it->host = *host;
    start(it);
    return it;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[])
{
    (void)on, (void)count, (void)categories;
    return c ? fmi2OK : fmi2Error;
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real from, fmi2Boolean stopDefined,
                               fmi2Real stop)
{
    instance *it = c;
    (void)toleranceDefined, (void)tolerance, (void)from, (void)stopDefined, (void)stop;
    return it && it->phase == INSTANTIATED ? fmi2OK : refuse(it, "fmi2SetupExperiment: not allowed in this state");
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    instance *it = c;
    if (!it || it->phase != INSTANTIATED) return refuse(it, "fmi2EnterInitializationMode: not allowed in this state");
    it->phase = INITIALIZING;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    instance *it = c;
    if (!it || it->phase != INITIALIZING) return refuse(it, "fmi2ExitInitializationMode: not allowed in this state");
    const double *p = it->value, *q = p + START_ORIENTATION;
    if (!(p[MASS] > 0.0 && p[MOMENTS] > 0.0 && p[MOMENTS + 1] > 0.0 && p[MOMENTS + 2] > 0.0 && p[DRAG_COEFFICIENT] >= 0.0 && p[FRONTAL_AREA] >= 0.0))
        return refuse(it, "mass, moments, drag_coefficient or frontal_area: out of range");
    if (!(fabs(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1.0) < 1e-6)) return refuse(it, "start.orientation: not a unit quaternion");
    it->phase = STEPPING;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    instance *it = c;
    if (!it || it->phase != STEPPING) return refuse(it, "fmi2Terminate: not allowed in this state");
    it->phase = TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    if (!c) return fmi2Error;
    start(c);
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference references[], size_t count, fmi2Real values[])
{
    instance *it = c;
    if (!it) return fmi2Error;
    for (size_t k = 0; k < count; k++) {
        if (references[k] >= COUNT) return refuse(it, "fmi2GetReal: unknown value reference");
        values[k] = it->value[references[k]];
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference references[], size_t count, const fmi2Real values[])
{
    instance *it = c;
    if (!it) return fmi2Error;
    for (size_t k = 0; k < count; k++) {
        const fmi2ValueReference reference = references[k];
        if (reference >= POSITION || (reference < FORCE && it->phase != INSTANTIATED && it->phase != INITIALIZING))
            return refuse(it, "fmi2SetReal: not to be set, or not now");
        if (!isfinite(values[k])) return refuse(it, "fmi2SetReal: not a finite number");
    }
    for (size_t k = 0; k < count; k++) it->value[references[k]] = values[k];
    if (it->phase != STEPPING) launch(it);
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean forGood)
{
    instance *it = c;
    double own[3];
    (void)t, (void)forGood;
    if (!it || it->phase != STEPPING) return refuse(it, "fmi2DoStep: not allowed in this state");
    if (!(h > 0.0)) return refuse(it, "fmi2DoStep: the step size must be greater than zero");
    fragment_own_force(&it->fragment, own);
    fragment_step(&it->fragment, h, own, it->value + FORCE, it->value + TORQUE, it->value[TICK]);
    publish(it);
    return fmi2OK;
}

/* The rest is not supported, as the model description says. */
#define REFUSED(name, ...) \
    fmi2Status fmi2##name(fmi2Component c, __VA_ARGS__) { return refuse(c, "fmi2" #name ": not supported"); }

REFUSED(GetInteger, const fmi2ValueReference r[], size_t n, fmi2Integer v[])
REFUSED(GetBoolean, const fmi2ValueReference r[], size_t n, fmi2Boolean v[])
REFUSED(GetString, const fmi2ValueReference r[], size_t n, fmi2String v[])
REFUSED(SetInteger, const fmi2ValueReference r[], size_t n, const fmi2Integer v[])
REFUSED(SetBoolean, const fmi2ValueReference r[], size_t n, const fmi2Boolean v[])
REFUSED(SetString, const fmi2ValueReference r[], size_t n, const fmi2String v[])
REFUSED(GetFMUstate, fmi2FMUstate *s)
REFUSED(SetFMUstate, fmi2FMUstate s)
REFUSED(FreeFMUstate, fmi2FMUstate *s)
REFUSED(SerializedFMUstateSize, fmi2FMUstate s, size_t *n)
REFUSED(SerializeFMUstate, fmi2FMUstate s, fmi2Byte b[], size_t n)
REFUSED(DeSerializeFMUstate, const fmi2Byte b[], size_t n, fmi2FMUstate *s)
REFUSED(GetDirectionalDerivative, const fmi2ValueReference u[], size_t n, const fmi2ValueReference k[], size_t m, const fmi2Real d[], fmi2Real v[])
REFUSED(SetRealInputDerivatives, const fmi2ValueReference r[], size_t n, const fmi2Integer o[], const fmi2Real v[])
REFUSED(GetRealOutputDerivatives, const fmi2ValueReference r[], size_t n, const fmi2Integer o[], fmi2Real v[])

/* No step is ever pending. */
#define NOT_KNOWN(name, ...) \
    fmi2Status fmi2##name(fmi2Component c, __VA_ARGS__) { return c ? fmi2Discard : fmi2Error; }

NOT_KNOWN(GetStatus, const fmi2StatusKind k, fmi2Status *v)
NOT_KNOWN(GetRealStatus, const fmi2StatusKind k, fmi2Real *v)
NOT_KNOWN(GetIntegerStatus, const fmi2StatusKind k, fmi2Integer *v)
NOT_KNOWN(GetBooleanStatus, const fmi2StatusKind k, fmi2Boolean *v)
NOT_KNOWN(GetStringStatus, const fmi2StatusKind k, fmi2String *v)

fmi2Status fmi2CancelStep(fmi2Component c) { return refuse(c, "fmi2CancelStep: not supported"); }
