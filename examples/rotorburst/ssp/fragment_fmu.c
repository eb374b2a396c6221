/* FragmentTrajectory: the fragment of fragment.c as a small FMI 2.0 co-simulation FMU, to be connected with FabricShield.

   All variables are Real, and a value reference is a place in `value`: see FragmentTrajectory.xml. States cannot be saved. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

#include "../fragment.h"

#define TOKEN "{FragmentTrajectory-1}"

/* Value references: parameters, inputs, outputs. */
enum {
    RADIUS, LENGTH, MASS, DRAG_COEFFICIENT, STANDOFF, SPEED, SPIN, TILT, TICK,
    FORCE, TORQUE = FORCE + 3,
    POSITION = TORQUE + 3, VELOCITY = POSITION + 3, ORIENTATION = VELOCITY + 3, ANGULAR_VELOCITY = ORIENTATION + 4,
    KINETIC_ENERGY = ANGULAR_VELOCITY + 3, COUNT
};

static const double START[FORCE] = {6.35e-3, 0.0, 0.0084, 0.47, 0.3, 100.0, 0.0, 0.0, 0.0};

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
    const fragment_body body = {p[RADIUS], p[LENGTH], p[MASS], p[DRAG_COEFFICIENT]};
    it->fragment = fragment_launched(&body, p[STANDOFF], p[SPEED], p[SPIN], p[TILT]);
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
    if (!(it->value[RADIUS] > 0.0 && it->value[LENGTH] >= 0.0 && it->value[MASS] > 0.0)) return refuse(it, "radius, length or mass: out of range");
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
REFUSED(GetStatus, const fmi2StatusKind k, fmi2Status *v)
REFUSED(GetRealStatus, const fmi2StatusKind k, fmi2Real *v)
REFUSED(GetIntegerStatus, const fmi2StatusKind k, fmi2Integer *v)
REFUSED(GetBooleanStatus, const fmi2StatusKind k, fmi2Boolean *v)
REFUSED(GetStringStatus, const fmi2StatusKind k, fmi2String *v)

fmi2Status fmi2CancelStep(fmi2Component c) { return refuse(c, "fmi2CancelStep: not supported"); }
