/* A controller of four axes in C, as any C programmer would write one: FMI 2.0 co-simulation, standard headers, no
 * state saved. Each axis: i = -(k_p x + k_d (x - x_before) / h) / k_i, sampled once in a step.
 */
#include <stdlib.h>
#include "fmi2Functions.h"

enum { AXES = 4, FIRST_INPUT = 0, FIRST_OUTPUT = 4, K_P = 8, K_D = 9, K_I = 10, VARIABLES = 11 };

typedef struct {
    fmi2Real value[VARIABLES];
    fmi2Real before[AXES];
    int sampled;
} Controller;

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String *names) { return fmi2OK; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    Controller *c = type == fmi2CoSimulation ? calloc(1, sizeof *c) : NULL;
    if (c) {
        c->value[K_P] = 3e6;
        c->value[K_D] = 5000.0;
        c->value[K_I] = 563.0;
    }
    return c;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean t, fmi2Real tol, fmi2Real start, fmi2Boolean s,
                               fmi2Real end)
{
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return fmi2OK; }
fmi2Status fmi2Terminate(fmi2Component c) { return fmi2OK; }
fmi2Status fmi2Reset(fmi2Component c)
{
    ((Controller *)c)->sampled = 0;
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real v[])
{
    for (size_t k = 0; k < n; k++) {
        if (r[k] >= VARIABLES)
            return fmi2Error;
        v[k] = ((Controller *)c)->value[r[k]];
    }
    return fmi2OK;
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real v[])
{
    for (size_t k = 0; k < n; k++) {
        if (r[k] >= VARIABLES)
            return fmi2Error;
        ((Controller *)c)->value[r[k]] = v[k];
    }
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real t, fmi2Real h, fmi2Boolean no_set_before)
{
    Controller *c = component;
    for (int k = 0; k < AXES; k++) {
        fmi2Real x = c->value[FIRST_INPUT + k];
        fmi2Real velocity = c->sampled ? (x - c->before[k]) / h : 0.0;
        c->value[FIRST_OUTPUT + k] = -(c->value[K_P] * x + c->value[K_D] * velocity) / c->value[K_I];
        c->before[k] = x;
    }
    c->sampled = 1;
    return fmi2OK;
}

#define NONE(name, ...)                                                                                                \
    fmi2Status name(fmi2Component c, ##__VA_ARGS__) { return fmi2Error; }
NONE(fmi2CancelStep)
NONE(fmi2GetFMUstate, fmi2FMUstate *s)
NONE(fmi2SetFMUstate, fmi2FMUstate s)
NONE(fmi2FreeFMUstate, fmi2FMUstate *s)
NONE(fmi2SerializedFMUstateSize, fmi2FMUstate s, size_t *n)
NONE(fmi2SerializeFMUstate, fmi2FMUstate s, fmi2Byte b[], size_t n)
NONE(fmi2DeSerializeFMUstate, const fmi2Byte b[], size_t n, fmi2FMUstate *s)
NONE(fmi2GetInteger, const fmi2ValueReference r[], size_t n, fmi2Integer v[])
NONE(fmi2GetBoolean, const fmi2ValueReference r[], size_t n, fmi2Boolean v[])
NONE(fmi2GetString, const fmi2ValueReference r[], size_t n, fmi2String v[])
NONE(fmi2SetInteger, const fmi2ValueReference r[], size_t n, const fmi2Integer v[])
NONE(fmi2SetBoolean, const fmi2ValueReference r[], size_t n, const fmi2Boolean v[])
NONE(fmi2SetString, const fmi2ValueReference r[], size_t n, const fmi2String v[])
NONE(fmi2GetDirectionalDerivative, const fmi2ValueReference u[], size_t nu, const fmi2ValueReference k[], size_t nk,
     const fmi2Real du[], fmi2Real dk[])
NONE(fmi2SetRealInputDerivatives, const fmi2ValueReference r[], size_t n, const fmi2Integer o[], const fmi2Real v[])
NONE(fmi2GetRealOutputDerivatives, const fmi2ValueReference r[], size_t n, const fmi2Integer o[], fmi2Real v[])
NONE(fmi2GetStatus, const fmi2StatusKind k, fmi2Status *v)
NONE(fmi2GetRealStatus, const fmi2StatusKind k, fmi2Real *v)
NONE(fmi2GetIntegerStatus, const fmi2StatusKind k, fmi2Integer *v)
NONE(fmi2GetBooleanStatus, const fmi2StatusKind k, fmi2Boolean *v)
NONE(fmi2GetStringStatus, const fmi2StatusKind k, fmi2String *v)
