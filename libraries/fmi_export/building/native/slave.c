/* FMI 2.0 for co-simulation around one model: the standard's state machine, checks, logging, saved states.

   Nothing here is global and writable, so instances share nothing. What a model is, beyond its kernels, comes from the
   resources when an instance is made. Memory is taken once for each instance and once for each saved state.

   Every call that is refused answers fmi2Error and logs the reason. A fault of a step and a wrong call put the instance
   into the error state, from which fmi2Reset and fmi2SetFMUstate lead; `decline` and `unsupported` leave it as it was.
   No step is answered with fmi2Discard, and fmi2Terminated is never true: to a host both mean an end that was wanted. */

#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2.h"
#include "instance.h"
#include "resources.h"

/* States of the standard that a slave without asynchronous steps can be in. */
enum {
    INSTANTIATED = 1,
    INITIALIZATION = 2,
    STEP_COMPLETE = 4,
    TERMINATED = 8,
    ERROR = 16,
};

enum {
    ANY = INSTANTIATED | INITIALIZATION | STEP_COMPLETE | TERMINATED | ERROR,
    READABLE = INITIALIZATION | STEP_COMPLETE | TERMINATED | ERROR,
    SETTABLE = INSTANTIATED | INITIALIZATION | STEP_COMPLETE,
    ASKABLE = STEP_COMPLETE | TERMINATED | ERROR, /* in the last, which the standard leaves out, there is most to ask */
};

static const struct {
    int32_t state;
    const char *name;
} STATE_NAMES[] = {
    {INSTANTIATED, "instantiated"}, {INITIALIZATION, "initialization mode"}, {STEP_COMPLETE, "step complete"},
    {TERMINATED, "terminated"},     {ERROR, "error"},
};

static const char *const TYPE_NAMES[] = {"Real", "Integer", "Boolean", "String"};

/* A saved state; the values and the state of the run follow. */
typedef struct {
    _Alignas(16) char guid[GUID_SIZE]; /* first, so that the state of another FMU is known by it */
    int32_t state;
    int32_t stale; /* something was set in initialization mode that the outputs do not show yet */
    double time;   /* end of the last successful step (s) */
    Outcome outcome;
} Saved;

typedef struct {
    Saved *now;
    size_t saved_size;
    Run run; /* of which `now` holds what there is to save */
    double stop; /* end of the experiment (s), where the host set one */
    fmi2CallbackFunctions host;
    int logging;
    unsigned int categories; /* one bit for each of CATEGORIES */
    const char *name;
} Instance;

/* Logging -------------------------------------------------------------------------------------------------------- */

/* In the order of fmi2Status, from fmi2Warning on. */
static const char *const CATEGORIES[] = {"logStatusWarning", "logStatusDiscard", "logStatusError", "logStatusFatal",
                                         "logAll"};
enum { N_CATEGORIES = sizeof CATEGORIES / sizeof *CATEGORIES, LOG_ALL = N_CATEGORIES - 1 };

/* Hand a text to the host's logger, which takes it for a printf format. */
static void hand_over(const fmi2CallbackFunctions *host, const char *name, fmi2Status status, const char *text)
{
    char format[2 * TEXT_SIZE];
    size_t used = 0;
    if (!host->logger)
        return;
    for (; *text && used < sizeof format - 2; text++) {
        if (*text == '%')
            format[used++] = '%';
        format[used++] = *text;
    }
    format[used] = '\0';
    host->logger(host->componentEnvironment, name, status, CATEGORIES[status - fmi2Warning], format);
}

static void say(const Instance *instance, fmi2Status status, const char *format, ...)
{
    char text[TEXT_SIZE];
    unsigned int wanted = 1u << (status - fmi2Warning) | 1u << LOG_ALL;
    va_list arguments;
    if (!instance->logging || !(instance->categories & wanted))
        return;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    hand_over(&instance->host, instance->name, status, text);
}

/* Log each warning when it is true for the first time, after initialisation or at the end of a step. */
static void warn(Instance *instance, int stepped)
{
    char text[TEXT_SIZE];
    while (run_next_warning(&instance->run, text))
        if (stepped)
            say(instance, fmi2Warning, "at t = %.9g s: %s", instance->now->time, text);
        else
            say(instance, fmi2Warning, "initialisation: %s", text);
}

/* Refuse a call that changed nothing, and live on. fmi2GetStringStatus has the reason until the next step is done. */
static fmi2Status decline(Instance *instance, const char *format, ...)
{
    char text[TEXT_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (!instance->now->outcome.fault)
        snprintf(instance->now->outcome.reason, TEXT_SIZE, "%s", text);
    say(instance, fmi2Error, "%s", text);
    return fmi2Error;
}

/* Refuse a call for good: the first reason stays as the fault. */
static fmi2Status refuse(Instance *instance, const char *format, ...)
{
    char text[TEXT_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (!instance->now->outcome.fault)
        run_stop(&instance->run, FAULT_INTERNAL, text);
    instance->now->state = ERROR;
    say(instance, fmi2Error, "%s", text);
    return fmi2Error;
}

/* Whether `call` may come now; if not it is refused, with what state the instance is in and which would do. */
static int may(Instance *instance, int states, const char *call)
{
    char text[TEXT_SIZE];
    const char *now = "an unknown state", *separator = "";
    if (!instance)
        return 0;
    if (instance->now->state & states)
        return 1;
    for (size_t i = 0; i < sizeof STATE_NAMES / sizeof *STATE_NAMES; i++)
        if (STATE_NAMES[i].state == instance->now->state)
            now = STATE_NAMES[i].name;
    size_t used = (size_t)snprintf(text, sizeof text, "%s is not allowed in state '%s'; it is allowed in ", call, now);
    for (size_t i = 0; i < sizeof STATE_NAMES / sizeof *STATE_NAMES; i++)
        if (states & STATE_NAMES[i].state && used < sizeof text) {
            used += (size_t)snprintf(text + used, sizeof text - used, "%s'%s'", separator, STATE_NAMES[i].name);
            separator = ", ";
        }
    if (instance->now->state == ERROR && used < sizeof text)
        snprintf(text + used, sizeof text - used, "; stopped by an earlier fault: %s", instance->now->outcome.reason);
    refuse(instance, "%s", text);
    return 0;
}

/* A question that the standard leaves optional: refused, and the instance lives on. */
static fmi2Status unsupported(const Instance *instance, fmi2Status status, const char *what)
{
    if (!instance)
        return fmi2Error;
    say(instance, status, "%s", what);
    return status;
}

/* Life cycle ----------------------------------------------------------------------------------------------------- */

const char *fmi2GetTypesPlatform(void)
{
    return "default";
}

const char *fmi2GetVersion(void)
{
    return "2.0";
}

static void start_over(Instance *instance)
{
    Saved *now = instance->now;
    memcpy(now->guid, instance->run.data.guid, GUID_SIZE);
    now->state = INSTANTIATED;
    now->stale = 1;
    now->time = 0.0;
    instance->stop = INFINITY;
    run_clear(&instance->run);
}

/* Reserve `count` items at the end of a block, at a multiple of 16 bytes; return their place in it. */
static size_t reserve(size_t *end, size_t count, size_t size)
{
    size_t place = (*end + 15) / 16 * 16;
    *end = place + count * size;
    return place;
}

/* A new instance with a copy of its data in one block of memory, or NULL. */
static Instance *allocate(const unsigned char *bytes, size_t size, const char *name)
{
    Data data = data_in(bytes);
    size_t end = sizeof(Instance), real = sizeof(double);
    size_t now = reserve(&end, 1, sizeof(Saved)), values = reserve(&end, (size_t)data.n_values, real);
    size_t state = reserve(&end, (size_t)data.n_state, real), outputs = reserve(&end, (size_t)data.n_outputs, real);
    size_t work = reserve(&end, (size_t)data.n_work, real), copy = reserve(&end, size, 1);
    size_t own_name = reserve(&end, strlen(name) + 1, 1), told = reserve(&end, (size_t)data.n_warnings, 1);
    char *block = calloc(1, end);
    if (!block)
        return NULL;
    memcpy(block + copy, bytes, size);
    memcpy(block + own_name, name, strlen(name) + 1);
    Instance *instance = (Instance *)block;
    instance->now = (Saved *)(block + now);
    instance->saved_size = state + (size_t)data.n_state * real - now;
    instance->run = (Run){
        .data = data_in((const unsigned char *)block + copy),
        .values = (double *)(block + values),
        .state = (double *)(block + state),
        .outcome = &instance->now->outcome,
        .next_outputs = (double *)(block + outputs),
        .work = (double *)(block + work),
        .told = (unsigned char *)(block + told),
    };
    instance->name = block + own_name;
    return instance;
}

/* A new instance with the data at a resource location; NULL with a reason if there can be none. */
static Instance *load(const char *name, const char *guid, const char *location, char *reason)
{
    char why[TEXT_SIZE];
    size_t size = 0;
    Instance *instance = NULL;
    unsigned char *bytes = resource_bytes(location, &size, reason);
    if (!bytes)
        return NULL;
    if (!data_is_valid(bytes, size, why))
        snprintf(reason, TEXT_SIZE, "resources/model.bin does not fit: %.*s; build the FMU anew", TEXT_SIZE / 2, why);
    else if (!guid || strcmp(guid, data_in(bytes).guid) != 0)
        snprintf(reason, TEXT_SIZE, "the modelDescription.xml has guid %s, but resources/model.bin belongs to %s",
                 guid ? guid : "NULL", data_in(bytes).guid);
    else if (!(instance = allocate(bytes, size, name)))
        snprintf(reason, TEXT_SIZE, "there is no memory for another instance");
    free(bytes);
    return instance;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *host, fmi2Boolean visible, fmi2Boolean logging)
{
    char reason[TEXT_SIZE] = "";
    Instance *instance = NULL;
    (void)visible;
    if (!host)
        return NULL;
    if (!name || !*name)
        snprintf(reason, sizeof reason, "an instance needs a name");
    else if (type != fmi2CoSimulation)
        snprintf(reason, sizeof reason, "this is an FMU for co-simulation, not for model exchange");
    else
        instance = load(name, guid, resources, reason);
    if (!instance) {
        hand_over(host, name ? name : "", fmi2Error, reason);
        return NULL;
    }
    instance->host = *host;
    instance->logging = logging != fmi2False;
    instance->categories = 1u << LOG_ALL;
    start_over(instance);
    return instance;
}

void fmi2FreeInstance(fmi2Component component)
{
    free(component);
}

fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean on, size_t count, const fmi2String categories[])
{
    Instance *instance = component;
    unsigned int chosen = count ? 0 : 1u << LOG_ALL;
    if (!may(instance, ANY, "fmi2SetDebugLogging"))
        return fmi2Error;
    if (count && !categories)
        return decline(instance, "fmi2SetDebugLogging: categories is NULL");
    for (size_t i = 0; i < count; i++) {
        unsigned int k = 0;
        while (k < N_CATEGORIES && !(categories[i] && strcmp(categories[i], CATEGORIES[k]) == 0))
            k++;
        if (k == N_CATEGORIES)
            return decline(instance, "fmi2SetDebugLogging: there is no category %s; there are %s, %s, %s, %s and %s",
                           categories[i] ? categories[i] : "NULL", CATEGORIES[0], CATEGORIES[1], CATEGORIES[2],
                           CATEGORIES[3], CATEGORIES[4]);
        chosen |= 1u << k;
    }
    instance->logging = on != fmi2False;
    instance->categories = chosen;
    return fmi2OK;
}

fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean has_stop, fmi2Real stop)
{
    Instance *instance = component;
    (void)has_tolerance, (void)tolerance;
    if (!may(instance, INSTANTIATED, "fmi2SetupExperiment"))
        return fmi2Error;
    if (!isfinite(start))
        return refuse(instance, "start time = %g s is not allowed; it must be a finite number", start);
    if (has_stop && !(stop >= start))
        return refuse(instance, "stop time = %g s is not allowed; it must be >= %g s, the start", stop, start);
    instance->now->time = start;
    instance->stop = has_stop ? stop : INFINITY;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component component)
{
    Instance *instance = component;
    if (!may(instance, INSTANTIATED, "fmi2EnterInitializationMode"))
        return fmi2Error;
    instance->now->state = INITIALIZATION;
    instance->now->stale = 1;
    return fmi2OK;
}

/* Initialise again if something was set since, so that outputs are right throughout initialization mode. A fault can
   still be put right there. */
static fmi2Status refresh(Instance *instance)
{
    Saved *now = instance->now;
    if (now->state != INITIALIZATION || !now->stale)
        return fmi2OK;
    now->stale = 0;
    if (!run_initialise(&instance->run))
        return fmi2OK;
    say(instance, fmi2Warning, "initialisation: %s", now->outcome.reason);
    return fmi2Warning;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component component)
{
    Instance *instance = component;
    if (!may(instance, INITIALIZATION, "fmi2ExitInitializationMode"))
        return fmi2Error;
    Saved *now = instance->now;
    if (now->stale)
        run_initialise(&instance->run);
    now->stale = 0;
    if (now->outcome.fault)
        return refuse(instance, "initialisation: %s", now->outcome.reason);
    now->state = STEP_COMPLETE;
    warn(instance, 0);
    return fmi2OK;
}

/* Whether a step ends after the end of the experiment, by more than what rounding adds up to in hosts that sum their
   steps; the standard has it refused. */
static int is_too_late(const Instance *instance, double time, double step_size)
{
    double rounding = 1e-9 * fmax(fmax(fabs(time), fabs(instance->stop)), step_size);
    return isfinite(step_size) && time + step_size - instance->stop > rounding;
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real time, fmi2Real step_size, fmi2Boolean no_earlier_state)
{
    Instance *instance = component;
    (void)no_earlier_state;
    if (!may(instance, STEP_COMPLETE, "fmi2DoStep"))
        return fmi2Error;
    if (!isfinite(time))
        return refuse(instance, "fmi2DoStep: time = %g s is not allowed; it must be a finite number", time);
    if (is_too_late(instance, time, step_size))
        return decline(instance, "at t = %.9g s: a step of %g s would end after the stop time of the experiment, %.9g s",
                       time, step_size, instance->stop);
    if (run_step(&instance->run, time, step_size))
        return refuse(instance, "at t = %.9g s: %s", time, instance->now->outcome.reason);
    instance->now->time = time + step_size;
    warn(instance, 1);
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component component)
{
    Instance *instance = component;
    if (!may(instance, STEP_COMPLETE, "fmi2Terminate"))
        return fmi2Error;
    instance->now->state = TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component component)
{
    Instance *instance = component;
    if (!may(instance, ANY, "fmi2Reset"))
        return fmi2Error;
    start_over(instance);
    return fmi2OK;
}

/* Variables ------------------------------------------------------------------------------------------------------ */

static int wrong_reference(Instance *instance, const char *call, fmi2ValueReference reference, Type type)
{
    const Data *data = &instance->run.data;
    if (reference < data->n_values && data->types[reference] == type)
        return 0;
    if (reference < data->n_values)
        refuse(instance, "%s: %s is of type %s", call, name_of(data, reference), TYPE_NAMES[data->types[reference]]);
    else
        refuse(instance, "%s: there is no value reference %u", call, reference);
    return 1;
}

/* Before values are read: state, pointers, references and types; outputs up to date. */
static fmi2Status before_get(Instance *instance, const char *call, Type type, REFERENCES, const void *values)
{
    if (!may(instance, READABLE, call))
        return fmi2Error;
    if (count && (!references || !values))
        return refuse(instance, "%s: %s is NULL", call, references ? "values" : "references");
    for (size_t i = 0; i < count; i++)
        if (wrong_reference(instance, call, references[i], type))
            return fmi2Error;
    return refresh(instance);
}

/* Before values are set: the same, and that each may be set now. Outputs never may, fixed parameters not any more. */
static fmi2Status before_set(Instance *instance, const char *call, Type type, REFERENCES, const void *values)
{
    if (!may(instance, SETTABLE, call))
        return fmi2Error;
    if (count && (!references || !values))
        return refuse(instance, "%s: %s is NULL", call, references ? "values" : "references");
    const Data *data = &instance->run.data;
    for (size_t i = 0; i < count; i++) {
        fmi2ValueReference r = references[i];
        if (wrong_reference(instance, call, r, type))
            return fmi2Error;
        int is_parameter = r < data->n_parameters;
        int fixed = is_parameter && !data->variables[r].tunable && instance->now->state == STEP_COMPLETE;
        if (fixed || r >= first_output(data))
            return refuse(instance, "%s: %s is a %s and cannot be set now", call, name_of(data, r),
                          data->text + data->variables[r].kind);
        if (is_parameter)
            instance->now->outcome.checked = 0;
    }
    instance->now->stale = 1;
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component component, REFERENCES, fmi2Real values[])
{
    Instance *instance = component;
    fmi2Status status = before_get(instance, "fmi2GetReal", TYPE_REAL, references, count, values);
    for (size_t i = 0; i < count && status <= fmi2Warning; i++)
        values[i] = instance->run.values[references[i]];
    return status;
}

fmi2Status fmi2GetInteger(fmi2Component component, REFERENCES, fmi2Integer values[])
{
    Instance *instance = component;
    fmi2Status status = before_get(instance, "fmi2GetInteger", TYPE_INTEGER, references, count, values);
    for (size_t i = 0; i < count && status <= fmi2Warning; i++) {
        double value = instance->run.values[references[i]];
        if (!(value > INT_MIN - 1.0 && value < INT_MAX + 1.0))
            return refuse(instance, "fmi2GetInteger: %s = %g does not fit into an integer",
                          name_of(&instance->run.data, references[i]), value);
        values[i] = (fmi2Integer)value;
    }
    return status;
}

fmi2Status fmi2GetBoolean(fmi2Component component, REFERENCES, fmi2Boolean values[])
{
    Instance *instance = component;
    fmi2Status status = before_get(instance, "fmi2GetBoolean", TYPE_BOOLEAN, references, count, values);
    for (size_t i = 0; i < count && status <= fmi2Warning; i++)
        values[i] = instance->run.values[references[i]] != 0.0;
    return status;
}

/* There are no strings, so that these two refuse all but an empty list. */
fmi2Status fmi2GetString(fmi2Component component, REFERENCES, fmi2String values[])
{
    return before_get(component, "fmi2GetString", TYPE_STRING, references, count, values);
}

fmi2Status fmi2SetString(fmi2Component component, REFERENCES, const fmi2String values[])
{
    return before_set(component, "fmi2SetString", TYPE_STRING, references, count, values);
}

fmi2Status fmi2SetReal(fmi2Component component, REFERENCES, const fmi2Real values[])
{
    Instance *instance = component;
    fmi2Status status = before_set(instance, "fmi2SetReal", TYPE_REAL, references, count, values);
    for (size_t i = 0; i < count && status == fmi2OK; i++)
        instance->run.values[references[i]] = values[i];
    return status;
}

fmi2Status fmi2SetInteger(fmi2Component component, REFERENCES, const fmi2Integer values[])
{
    Instance *instance = component;
    fmi2Status status = before_set(instance, "fmi2SetInteger", TYPE_INTEGER, references, count, values);
    for (size_t i = 0; i < count && status == fmi2OK; i++)
        instance->run.values[references[i]] = values[i];
    return status;
}

fmi2Status fmi2SetBoolean(fmi2Component component, REFERENCES, const fmi2Boolean values[])
{
    Instance *instance = component;
    fmi2Status status = before_set(instance, "fmi2SetBoolean", TYPE_BOOLEAN, references, count, values);
    for (size_t i = 0; i < count && status == fmi2OK; i++)
        instance->run.values[references[i]] = values[i] != fmi2False;
    return status;
}

/* Saved states --------------------------------------------------------------------------------------------------- */

static int is_ours(const Instance *instance, const char *guid)
{
    return strncmp(guid, instance->run.data.guid, GUID_SIZE) == 0;
}

/* Bytes may come from anywhere, so they end with the checksum of those before. */
static size_t serialised_size(const Instance *instance)
{
    return instance->saved_size + sizeof(uint32_t);
}

fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    Instance *instance = component;
    if (!may(instance, ANY, "fmi2GetFMUstate"))
        return fmi2Error;
    if (!state)
        return refuse(instance, "fmi2GetFMUstate: state is NULL");
    Saved *saved = *state ? *state : malloc(instance->saved_size);
    if (!saved)
        return refuse(instance, "fmi2GetFMUstate: there is no memory for a state");
    memcpy(saved, instance->now, instance->saved_size);
    *state = saved;
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state)
{
    Instance *instance = component;
    if (!may(instance, ANY, "fmi2SetFMUstate"))
        return fmi2Error;
    if (!state)
        return refuse(instance, "fmi2SetFMUstate: state is NULL");
    if (!is_ours(instance, state))
        return refuse(instance, "fmi2SetFMUstate: the state belongs to another FMU");
    memcpy(instance->now, state, instance->saved_size);
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    if (!may(component, ANY, "fmi2FreeFMUstate"))
        return fmi2Error;
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component component, fmi2FMUstate state, size_t *size)
{
    Instance *instance = component;
    if (!may(instance, ANY, "fmi2SerializedFMUstateSize"))
        return fmi2Error;
    if (!state || !size)
        return refuse(instance, "fmi2SerializedFMUstateSize: %s is NULL", state ? "size" : "state");
    *size = serialised_size(instance);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    Instance *instance = component;
    if (!may(instance, ANY, "fmi2SerializeFMUstate"))
        return fmi2Error;
    if (!state || !bytes)
        return refuse(instance, "fmi2SerializeFMUstate: %s is NULL", state ? "bytes" : "state");
    if (size < serialised_size(instance))
        return refuse(instance, "fmi2SerializeFMUstate: a state takes %zu bytes, not %zu", serialised_size(instance),
                      size);
    uint32_t sum = checksum(state, instance->saved_size);
    memcpy(bytes, state, instance->saved_size);
    memcpy(bytes + instance->saved_size, &sum, sizeof sum);
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component component, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    Instance *instance = component;
    uint32_t sum = 0;
    if (!may(instance, ANY, "fmi2DeSerializeFMUstate"))
        return fmi2Error;
    if (!bytes || !state)
        return refuse(instance, "fmi2DeSerializeFMUstate: %s is NULL", bytes ? "state" : "bytes");
    if (size < GUID_SIZE || !is_ours(instance, bytes))
        return refuse(instance, "fmi2DeSerializeFMUstate: the state belongs to another FMU");
    if (size == serialised_size(instance))
        memcpy(&sum, bytes + instance->saved_size, sizeof sum);
    if (size != serialised_size(instance) || sum != checksum(bytes, instance->saved_size))
        return refuse(instance, "fmi2DeSerializeFMUstate: the bytes are not whole");
    Saved *saved = malloc(instance->saved_size);
    if (!saved)
        return refuse(instance, "fmi2DeSerializeFMUstate: there is no memory for a state");
    memcpy(saved, bytes, instance->saved_size);
    *state = saved; /* what was there before may be anything, and is the host's to free */
    return fmi2OK;
}

/* Optional parts of the standard --------------------------------------------------------------------------------- */

fmi2Status fmi2GetDirectionalDerivative(fmi2Component component, const fmi2ValueReference unknowns[], size_t n_unknowns,
                                        const fmi2ValueReference knowns[], size_t n_knowns, const fmi2Real dv_known[],
                                        fmi2Real dv_unknown[])
{
    (void)unknowns, (void)n_unknowns, (void)knowns, (void)n_knowns, (void)dv_known, (void)dv_unknown;
    return unsupported(component, fmi2Error, "fmi2GetDirectionalDerivative: this FMU gives no derivatives");
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component component, REFERENCES, const fmi2Integer orders[],
                                       const fmi2Real values[])
{
    (void)references, (void)count, (void)orders, (void)values;
    return unsupported(component, fmi2Error, "fmi2SetRealInputDerivatives: inputs are constant during a step");
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component component, REFERENCES, const fmi2Integer orders[],
                                        fmi2Real values[])
{
    (void)references, (void)count, (void)orders, (void)values;
    return unsupported(component, fmi2Error, "fmi2GetRealOutputDerivatives: this FMU gives no derivatives");
}

fmi2Status fmi2CancelStep(fmi2Component component)
{
    return unsupported(component, fmi2Error, "fmi2CancelStep: there is no step to cancel, none is asynchronous");
}

fmi2Status fmi2GetStatus(fmi2Component component, fmi2StatusKind kind, fmi2Status *value)
{
    (void)kind, (void)value;
    return unsupported(component, fmi2Discard, "fmi2GetStatus: no step is asynchronous");
}

fmi2Status fmi2GetRealStatus(fmi2Component component, fmi2StatusKind kind, fmi2Real *value)
{
    Instance *instance = component;
    if (!may(instance, ASKABLE, "fmi2GetRealStatus"))
        return fmi2Error;
    if (kind != fmi2LastSuccessfulTime || !value)
        return unsupported(instance, fmi2Discard, "fmi2GetRealStatus: there is fmi2LastSuccessfulTime alone");
    *value = instance->now->time;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component component, fmi2StatusKind kind, fmi2Integer *value)
{
    (void)kind, (void)value;
    return unsupported(component, fmi2Discard, "fmi2GetIntegerStatus: there is no such status");
}

fmi2Status fmi2GetBooleanStatus(fmi2Component component, fmi2StatusKind kind, fmi2Boolean *value)
{
    Instance *instance = component;
    if (!may(instance, ASKABLE, "fmi2GetBooleanStatus"))
        return fmi2Error;
    if (kind != fmi2Terminated || !value)
        return unsupported(instance, fmi2Discard, "fmi2GetBooleanStatus: there is fmi2Terminated alone");
    *value = fmi2False; /* no fault is an end that the model wants */
    return fmi2OK;
}

/* Why the call before was refused, whether it was logged or not; empty if it was not. The text lives until the next
   call. */
fmi2Status fmi2GetStringStatus(fmi2Component component, fmi2StatusKind kind, fmi2String *value)
{
    Instance *instance = component;
    if (!may(instance, ASKABLE, "fmi2GetStringStatus"))
        return fmi2Error;
    if (kind != fmi2PendingStatus || !value)
        return unsupported(instance, fmi2Discard, "fmi2GetStringStatus: there is fmi2PendingStatus alone");
    *value = instance->now->outcome.reason;
    return fmi2OK;
}
