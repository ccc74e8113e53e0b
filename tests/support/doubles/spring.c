/* m x'' + c x' + k x = force, an FMI 2.0 co-simulation FMU in C, against the headers that FMPy ships.
 *
 * It interpolates its input as the standard has it: force at the start of a step, first and second derivative there
 * (fmi2SetRealInputDerivatives); both are 0 unless set, for one step, after the value (a new value forgets them). The step is
 * integrated by 50 classical Runge-Kutta steps. It is strict: a wrong value reference, a parameter set after initialisation, a
 * step from another time than its own (to 1e-9 of the step) or derivatives of order 3 are errors. With REWINDS=0 it cannot save
 * or restore its state: the functions are there, as hosts look them up, and return errors. */
#include "fmi2Functions.h"
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#ifndef REWINDS
#define REWINDS 1
#endif
#define SUBSTEPS 50
#define MAGIC 0x53505247u

enum { MASS, DAMPING, STIFFNESS, INITIAL_X, INITIAL_V, FORCE, X, V, A, STEPS, DISCRETE, COUNT };

typedef struct {
    uint32_t magic;
    int mode; /* 0 instantiated, 1 initialising, 2 stepping */
    double time, slope, bend, value[COUNT];
} State;

typedef struct {
    State now;
    const fmi2CallbackFunctions *host;
    char name[64];
} Spring;

static fmi2Status fail(Spring *s, const char *text) {
    if (s->host && s->host->logger)
        s->host->logger(s->host->componentEnvironment, s->name, fmi2Error, "error", "%s", text);
    return fmi2Error;
}

static double acceleration(const State *z, double x, double v, double force) {
    return (force - z->value[DAMPING] * v - z->value[STIFFNESS] * x) / z->value[MASS];
}

static void start(State *z) {
    z->value[X] = z->value[INITIAL_X];
    z->value[V] = z->value[INITIAL_V];
    z->value[A] = acceleration(z, z->value[X], z->value[V], z->value[FORCE]);
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String names[]) { return fmi2OK; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *host, fmi2Boolean visible, fmi2Boolean logging) {
    if (type != fmi2CoSimulation || strcmp(guid, GUID) != 0) return NULL;
    Spring *s = calloc(1, sizeof *s);
    s->host = host;
    snprintf(s->name, sizeof s->name, "%s", name);
    s->now.magic = MAGIC;
    s->now.value[MASS] = s->now.value[STIFFNESS] = 1.0;
    return s;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerant, fmi2Real tolerance, fmi2Real begin, fmi2Boolean stops,
                               fmi2Real stop) {
    ((Spring *)c)->now.time = begin;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    ((Spring *)c)->now.mode = 1;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    Spring *s = c;
    if (!(s->now.value[MASS] > 0.0)) return fail(s, "mass must be above 0");
    start(&s->now);
    s->now.mode = 2;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c) { return fmi2OK; }
fmi2Status fmi2Reset(fmi2Component c) { return fmi2Error; }

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    Spring *s = c;
    if (s->now.mode == 1) start(&s->now);
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= COUNT) return fail(s, "no such Real");
        value[i] = s->now.value[vr[i]];
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    Spring *s = c;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] > FORCE && vr[i] != DISCRETE) return fail(s, "outputs cannot be set");
        if (vr[i] < FORCE && s->now.mode == 2) return fail(s, "parameters are fixed after initialisation");
        s->now.value[vr[i]] = value[i];
        if (vr[i] == FORCE) s->now.slope = s->now.bend = 0.0;
    }
    return fmi2OK;
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
                                       const fmi2Real value[]) {
    Spring *s = c;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != FORCE) return fail(s, "only the force has derivatives");
        if (order[i] == 1) s->now.slope = value[i];
        else if (order[i] == 2) s->now.bend = value[i];
        else return fail(s, "derivatives of order 1 and 2 only");
    }
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real dt, fmi2Boolean final) {
    Spring *s = c;
    State *z = &s->now;
    if (z->mode != 2) return fail(s, "not initialised");
    if (!(dt > 0.0) || fabs(time - z->time) > 1e-9 * dt) return fail(s, "a step from another time than mine");
    const double h = dt / SUBSTEPS, f0 = z->value[FORCE];
    double x = z->value[X], v = z->value[V];
#define F(t) (f0 + (t) * (z->slope + 0.5 * (t) * z->bend))
    for (int i = 0; i < SUBSTEPS; i++) {
        const double t = i * h, middle = F(t + 0.5 * h);
        const double v1 = v, a1 = acceleration(z, x, v1, F(t));
        const double v2 = v + 0.5 * h * a1, a2 = acceleration(z, x + 0.5 * h * v1, v2, middle);
        const double v3 = v + 0.5 * h * a2, a3 = acceleration(z, x + 0.5 * h * v2, v3, middle);
        const double v4 = v + h * a3, a4 = acceleration(z, x + h * v3, v4, F(t + h));
        x += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
        v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    }
    z->value[X] = x;
    z->value[V] = v;
    z->value[A] = acceleration(z, x, v, F(dt));
    z->value[STEPS] += 1.0;
    z->slope = z->bend = 0.0;
    z->time = time + dt;
    return fmi2OK;
}

#if REWINDS
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    if (!*state) *state = malloc(sizeof(State));
    memcpy(*state, &((Spring *)c)->now, sizeof(State));
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    if (((State *)state)->magic != MAGIC) return fail(c, "this is no state of mine");
    memcpy(&((Spring *)c)->now, state, sizeof(State));
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    if (*state) ((State *)*state)->magic = 0; /* a state used after it was freed is seen */
    free(*state);
    *state = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    *size = sizeof(State);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    if (size < sizeof(State)) return fail(c, "the buffer is too small");
    memcpy(bytes, state, sizeof(State));
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    if (size != sizeof(State)) return fail(c, "a state of another size");
    if (!*state) *state = malloc(sizeof(State));
    memcpy(*state, bytes, sizeof(State));
    return fmi2OK;
}
#else
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *s) { return fmi2Error; }
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate s) { return fmi2Error; }
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *s) { return fmi2Error; }
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate s, size_t *n) { return fmi2Error; }
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate s, fmi2Byte b[], size_t n) { return fmi2Error; }
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *s) { return fmi2Error; }
#endif

/* what an FMU without these abilities exports all the same: hosts look the names up */
fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Integer v[]) { return n ? fmi2Error : fmi2OK; }
fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Boolean v[]) { return n ? fmi2Error : fmi2OK; }
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2String v[]) { return n ? fmi2Error : fmi2OK; }
fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer v[]) { return n ? fmi2Error : fmi2OK; }
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Boolean v[]) { return n ? fmi2Error : fmi2OK; }
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2String v[]) { return n ? fmi2Error : fmi2OK; }
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference u[], size_t m, const fmi2ValueReference k[],
                                        size_t n, const fmi2Real d[], fmi2Real r[]) { return fmi2Error; }
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer o[],
                                        fmi2Real v[]) { return fmi2Error; }
fmi2Status fmi2CancelStep(fmi2Component c) { return fmi2Error; }
fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind k, fmi2Status *v) { return fmi2Error; }
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind k, fmi2Real *v) { return fmi2Error; }
fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind k, fmi2Integer *v) { return fmi2Error; }
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind k, fmi2Boolean *v) { return fmi2Error; }
fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind k, fmi2String *v) { return fmi2Error; }
