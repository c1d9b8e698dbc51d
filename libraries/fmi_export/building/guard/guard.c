/* FMI 2.0 before PythonFMU's library: what the standard forbids is refused here, and only what is right reaches Python.

   This library checks state, arguments and saved states as the slave of the native FMUs does, with the same words, and
   hands the call on. PythonFMU's library makes a Python object of each reference and value that it is given, whatever
   it is, so that nothing wrong may get there. The variables with their types are in resources/model.bin.

   A fault in Python arrives as a message of status fmi2Error, and the call is then answered with fmi2Error: never with
   fmi2Discard and fmi2Terminated, by which hosts take a fault for an end that was wanted. */

#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "data.h"
#include "fmi2.h"
#include "pythonfmu.h"
#include "resources.h"

enum { FAULT_MISUSE = 998 };

/* States of the standard that a slave without asynchronous steps can be in, and the one in which Python is lost. */
enum {
    INSTANTIATED = 1,
    INITIALIZATION = 2,
    STEP_COMPLETE = 4,
    TERMINATED = 8,
    ERROR = 16,
    LOST = 32,
};

enum {
    ANY = INSTANTIATED | INITIALIZATION | STEP_COMPLETE | TERMINATED | ERROR,
    READABLE = INITIALIZATION | STEP_COMPLETE | TERMINATED | ERROR,
    SETTABLE = INSTANTIATED | INITIALIZATION | STEP_COMPLETE,
    ASKABLE = STEP_COMPLETE | TERMINATED | ERROR | LOST,
};

static const struct {
    int32_t state;
    const char *name;
} STATE_NAMES[] = {
    {INSTANTIATED, "instantiated"}, {INITIALIZATION, "initialization mode"}, {STEP_COMPLETE, "step complete"},
    {TERMINATED, "terminated"},     {ERROR, "error"},                        {LOST, "fatal error"},
};
enum { N_STATES = sizeof STATE_NAMES / sizeof *STATE_NAMES };

static const char *const TYPE_NAMES[] = {"Real", "Integer", "Boolean", "String"};

/* What this library saves of an instance; the rest is PythonFMU's. */
typedef struct {
    _Alignas(16) char guid[GUID_SIZE]; /* first, so that the state of another FMU is known by it */
    int32_t state;
    int32_t fault;          /* of a call that was refused here */
    double time;            /* end of the last successful step (s) */
    char reason[TEXT_SIZE]; /* of the fault, or of the call that was refused last; empty after a step that was done */
} Now;

typedef struct {
    Now now;
    fmi2FMUstate python;
} Saved;

/* A serialised state is this, the bytes of PythonFMU's, and the checksum of both. */
typedef struct {
    Now now;
    uint64_t python_size;
} Prefix;

typedef struct {
    Now now;
    double stop; /* end of the experiment (s), where the host set one */
    Data data;
    PythonFmu python;
    fmi2Component slave;         /* PythonFMU's instance */
    fmi2CallbackFunctions own;   /* what it calls */
    fmi2CallbackFunctions host;
    int logging;
    unsigned int categories;     /* one bit for each of CATEGORIES */
    char heard[TEXT_SIZE];       /* the first error that Python reported in the present call */
    const char *name;
} Instance;

/* Logging -------------------------------------------------------------------------------------------------------- */

/* In the order of fmi2Status, from fmi2Warning on. */
static const char *const CATEGORIES[] = {"logStatusWarning", "logStatusDiscard", "logStatusError", "logStatusFatal",
                                         "logAll"};
enum { N_CATEGORIES = sizeof CATEGORIES / sizeof *CATEGORIES, LOG_ALL = N_CATEGORIES - 1 };

static int category_of(fmi2Status status)
{
    return status >= fmi2Warning && status <= fmi2Fatal ? (int)status - fmi2Warning : LOG_ALL;
}

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
    host->logger(host->componentEnvironment, name, status, CATEGORIES[category_of(status)], format);
}

static void say(const Instance *instance, fmi2Status status, const char *text)
{
    unsigned int wanted = 1u << category_of(status) | 1u << LOG_ALL;
    if (instance->logging && instance->categories & wanted)
        hand_over(&instance->host, instance->name, status, text);
}

/* The logger that PythonFMU calls. An error is kept, and told when the call that it comes from is answered; PythonFMU
   gives no arguments to the text, whose percent signs stand for themselves. */
static void hear(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                 fmi2String text, ...)
{
    Instance *instance = environment;
    (void)name, (void)category;
    if (status <= fmi2Warning || *instance->heard)
        say(instance, status, text);
    else
        snprintf(instance->heard, sizeof instance->heard, "%s", text);
}

#define FORMAT(text) \
    char text[TEXT_SIZE]; \
    va_list arguments; \
    va_start(arguments, format); \
    vsnprintf(text, sizeof text, format, arguments); \
    va_end(arguments)

/* Refuse a call that changed nothing, and live on. fmi2GetStringStatus has the reason until the next step is done. */
static fmi2Status decline(Instance *instance, const char *format, ...)
{
    FORMAT(text);
    if (instance->now.state != ERROR && instance->now.state != LOST)
        snprintf(instance->now.reason, TEXT_SIZE, "%s", text);
    say(instance, fmi2Error, text);
    return fmi2Error;
}

/* Refuse a call for good: the first reason stays. */
static fmi2Status refuse(Instance *instance, const char *format, ...)
{
    FORMAT(text);
    decline(instance, "%s", text);
    if (instance->now.state == LOST)
        return fmi2Error;
    instance->now.state = ERROR;
    instance->now.fault = FAULT_MISUSE;
    return fmi2Error;
}

/* Whether `call` may come now; if not it is refused, with what state the instance is in and which would do. */
static int may(Instance *instance, int states, const char *call)
{
    char text[TEXT_SIZE];
    const char *now = "an unknown state", *separator = "";
    if (!instance)
        return 0;
    *instance->heard = '\0';
    if (instance->now.state & states)
        return 1;
    for (size_t i = 0; i < N_STATES; i++)
        if (STATE_NAMES[i].state == instance->now.state)
            now = STATE_NAMES[i].name;
    size_t used = (size_t)snprintf(text, sizeof text, "%s is not allowed in state '%s'; it is allowed in ", call, now);
    for (size_t i = 0; i < N_STATES; i++)
        if (states & STATE_NAMES[i].state && used < sizeof text) {
            used += (size_t)snprintf(text + used, sizeof text - used, "%s'%s'", separator, STATE_NAMES[i].name);
            separator = ", ";
        }
    if (instance->now.state & (ERROR | LOST) && used < sizeof text)
        snprintf(text + used, sizeof text - used, "; stopped by an earlier fault: %s", instance->now.reason);
    refuse(instance, "%s", text);
    return 0;
}

/* What PythonFMU's answer comes to. After an exception that left a method it has released what it still uses, so that it
   is not called any more. */
static fmi2Status answer(Instance *instance, fmi2Status status, const char *call)
{
    if (status == fmi2OK && !*instance->heard)
        return fmi2OK;
    if (!*instance->heard)
        snprintf(instance->heard, sizeof instance->heard, "%s failed in Python, without a reason", call);
    if (status <= fmi2Discard)
        return refuse(instance, "%s", instance->heard);
    snprintf(instance->now.reason, TEXT_SIZE, "%s", instance->heard);
    instance->now.state = LOST;
    say(instance, fmi2Fatal, instance->heard);
    return fmi2Fatal;
}

#define PYTHON(call, ...) instance->python.call(instance->slave, __VA_ARGS__)

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
    memset(&instance->now, 0, sizeof instance->now);
    memcpy(instance->now.guid, instance->data.guid, GUID_SIZE);
    instance->now.state = INSTANTIATED;
    instance->stop = INFINITY;
}

/* The start of a block at a multiple of 16 bytes, in which the instance, its name and its data are. */
static Instance *allocate(const unsigned char *bytes, size_t size, const char *name)
{
    size_t data = (sizeof(Instance) + 15) / 16 * 16, own_name = data + size;
    char *block = calloc(1, own_name + strlen(name) + 1);
    if (!block)
        return NULL;
    memcpy(block + data, bytes, size);
    strcpy(block + own_name, name);
    Instance *instance = (Instance *)block;
    instance->data = data_in((const unsigned char *)block + data);
    instance->name = block + own_name;
    return instance;
}

/* A new instance with the data in a folder, without Python; NULL with a reason if there can be none. */
static Instance *load(const char *name, const char *guid, const char *folder, char *reason)
{
    char why[TEXT_SIZE];
    size_t size = 0;
    Instance *instance = NULL;
    unsigned char *bytes = file_bytes(folder, "model.bin", &size, reason);
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

/* Have PythonFMU make its part of an instance; 0 with a reason if it does not. */
static int begin_python(Instance *instance, const char *folder, fmi2Boolean visible, char *reason)
{
    const fmi2CallbackFunctions own = {hear, instance->host.allocateMemory, instance->host.freeMemory, NULL, instance};
    memcpy(&instance->own, &own, sizeof own);
    if (open_pythonfmu(&instance->python, folder, reason)) {
        instance->slave = instance->python.Instantiate(instance->name, fmi2CoSimulation, instance->data.guid, folder,
                                                       &instance->own, visible, fmi2True);
        finalise_at_exit(&instance->python);
        if (instance->slave)
            return 1;
        snprintf(reason, TEXT_SIZE, "%s", *instance->heard ? instance->heard : "Python made no instance");
    }
    close_pythonfmu(&instance->python);
    return 0;
}

static Instance *make(const char *name, const char *guid, const char *location, const fmi2CallbackFunctions *host,
                      fmi2Boolean visible, char *reason)
{
    char *given = resource_folder(location, reason), *folder = given ? readable_folder(given, reason) : NULL;
    Instance *instance = folder ? load(name, guid, folder, reason) : NULL;
    if (instance) {
        memcpy(&instance->host, host, sizeof *host);
        if (!begin_python(instance, folder, visible, reason)) {
            free(instance);
            instance = NULL;
        }
    }
    free(given);
    free(folder);
    return instance;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *host, fmi2Boolean visible, fmi2Boolean logging)
{
    char reason[TEXT_SIZE] = "";
    Instance *instance = NULL;
    if (!host)
        return NULL;
    if (!name || !*name)
        snprintf(reason, sizeof reason, "an instance needs a name");
    else if (type != fmi2CoSimulation)
        snprintf(reason, sizeof reason, "this is an FMU for co-simulation, not for model exchange");
    else
        instance = make(name, guid, resources, host, visible, reason);
    if (!instance) {
        hand_over(host, name ? name : "", fmi2Error, reason);
        return NULL;
    }
    instance->logging = logging != fmi2False;
    instance->categories = 1u << LOG_ALL;
    start_over(instance);
    return instance;
}

void fmi2FreeInstance(fmi2Component component)
{
    Instance *instance = component;
    if (!instance)
        return;
    if (instance->now.state != LOST)
        instance->python.FreeInstance(instance->slave);
    close_pythonfmu(&instance->python);
    free(instance);
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
    if (!may(instance, INSTANTIATED, "fmi2SetupExperiment"))
        return fmi2Error;
    if (!isfinite(start))
        return refuse(instance, "start time = %g s is not allowed; it must be a finite number", start);
    if (has_stop && !(stop >= start))
        return refuse(instance, "stop time = %g s is not allowed; it must be >= %g s, the start", stop, start);
    instance->now.time = start;
    instance->stop = has_stop ? stop : INFINITY;
    return answer(instance, PYTHON(SetupExperiment, has_tolerance, tolerance, start, has_stop, stop),
                  "fmi2SetupExperiment");
}

fmi2Status fmi2EnterInitializationMode(fmi2Component component)
{
    Instance *instance = component;
    if (!may(instance, INSTANTIATED, "fmi2EnterInitializationMode"))
        return fmi2Error;
    instance->now.state = INITIALIZATION;
    return answer(instance, instance->python.EnterInitializationMode(instance->slave), "fmi2EnterInitializationMode");
}

static fmi2ValueReference fault_code(const Instance *instance)
{
    return (fmi2ValueReference)instance->data.n_values - 1;
}

/* Python says what is wrong when it finds it; a fault that was not put right since is still in its fault code. */
fmi2Status fmi2ExitInitializationMode(fmi2Component component)
{
    Instance *instance = component;
    if (!may(instance, INITIALIZATION, "fmi2ExitInitializationMode"))
        return fmi2Error;
    fmi2ValueReference reference = fault_code(instance);
    fmi2Integer fault = 0;
    fmi2Status status = instance->python.ExitInitializationMode(instance->slave);
    if (status == fmi2OK)
        status = PYTHON(GetInteger, &reference, 1, &fault);
    if (fault && !*instance->heard)
        snprintf(instance->heard, sizeof instance->heard, "%s", instance->now.reason);
    if (!fault && !*instance->heard)
        instance->now.state = STEP_COMPLETE;
    return answer(instance, fault ? fmi2Discard : status, "fmi2ExitInitializationMode");
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
    if (!may(instance, STEP_COMPLETE, "fmi2DoStep"))
        return fmi2Error;
    if (!isfinite(time))
        return refuse(instance, "fmi2DoStep: time = %g s is not allowed; it must be a finite number", time);
    if (is_too_late(instance, time, step_size))
        return decline(instance, "at t = %.9g s: a step of %g s would end after the stop time of the experiment, %.9g s",
                       time, step_size, instance->stop);
    fmi2Status status = answer(instance, PYTHON(DoStep, time, step_size, no_earlier_state), "fmi2DoStep");
    if (status == fmi2OK) {
        instance->now.time = time + step_size;
        *instance->now.reason = '\0';
    }
    return status;
}

fmi2Status fmi2Terminate(fmi2Component component)
{
    Instance *instance = component;
    if (!may(instance, STEP_COMPLETE, "fmi2Terminate"))
        return fmi2Error;
    instance->now.state = TERMINATED;
    return answer(instance, instance->python.Terminate(instance->slave), "fmi2Terminate");
}

fmi2Status fmi2Reset(fmi2Component component)
{
    Instance *instance = component;
    if (!may(instance, ANY, "fmi2Reset"))
        return fmi2Error;
    start_over(instance);
    return answer(instance, instance->python.Reset(instance->slave), "fmi2Reset");
}

/* Variables ------------------------------------------------------------------------------------------------------ */

static int wrong_reference(Instance *instance, const char *call, fmi2ValueReference reference, Type type)
{
    const Data *data = &instance->data;
    if (reference < data->n_values && data->types[reference] == type)
        return 0;
    if (reference < data->n_values)
        refuse(instance, "%s: %s is of type %s", call, name_of(data, reference), TYPE_NAMES[data->types[reference]]);
    else
        refuse(instance, "%s: there is no value reference %u", call, reference);
    return 1;
}

/* Whether values may be read: state, pointers, references and types. */
static int may_get(Instance *instance, const char *call, Type type, REFERENCES, const void *values)
{
    if (!may(instance, READABLE, call))
        return 0;
    if (count && (!references || !values)) {
        refuse(instance, "%s: %s is NULL", call, references ? "values" : "references");
        return 0;
    }
    for (size_t i = 0; i < count; i++)
        if (wrong_reference(instance, call, references[i], type))
            return 0;
    return 1;
}

/* Whether values may be set: the same, and that each may be set now. Outputs never may, fixed parameters not any more. */
static int may_set(Instance *instance, const char *call, Type type, REFERENCES, const void *values)
{
    if (!may(instance, SETTABLE, call))
        return 0;
    if (count && (!references || !values)) {
        refuse(instance, "%s: %s is NULL", call, references ? "values" : "references");
        return 0;
    }
    const Data *data = &instance->data;
    for (size_t i = 0; i < count; i++) {
        fmi2ValueReference r = references[i];
        if (wrong_reference(instance, call, r, type))
            return 0;
        int fixed = r < data->n_parameters && !data->variables[r].tunable && instance->now.state == STEP_COMPLETE;
        if (fixed || r >= data->n_parameters + data->n_inputs) {
            refuse(instance, "%s: %s is a %s and cannot be set now", call, name_of(data, r),
                   data->text + data->variables[r].kind);
            return 0;
        }
    }
    return 1;
}

/* Outputs are computed anew in initialization mode, where a fault can still be put right. */
static fmi2Status answer_get(Instance *instance, fmi2Status status, const char *call)
{
    if (instance->now.state != INITIALIZATION || status != fmi2OK || !*instance->heard)
        return answer(instance, status, call);
    snprintf(instance->now.reason, TEXT_SIZE, "%s", instance->heard);
    say(instance, fmi2Warning, instance->heard);
    return fmi2Warning;
}

#define GET(type, kind) \
    fmi2Status fmi2Get##type(fmi2Component component, REFERENCES, fmi2##type values[]) \
    { \
        Instance *instance = component; \
        if (!may_get(instance, "fmi2Get" #type, kind, references, count, values)) \
            return fmi2Error; \
        fmi2Status status = PYTHON(Get##type, references, count, values); \
        show_own_fault(instance, kind, references, count, values); \
        return answer_get(instance, status, "fmi2Get" #type); \
    }

#define SET(type, kind) \
    fmi2Status fmi2Set##type(fmi2Component component, REFERENCES, const fmi2##type values[]) \
    { \
        Instance *instance = component; \
        if (!may_set(instance, "fmi2Set" #type, kind, references, count, values)) \
            return fmi2Error; \
        return answer(instance, PYTHON(Set##type, references, count, values), "fmi2Set" #type); \
    }

/* Python does not know of calls that were refused here. */
static void show_own_fault(const Instance *instance, Type type, REFERENCES, void *values)
{
    fmi2Integer *numbers = values;
    if (type != TYPE_INTEGER || !instance->now.fault)
        return;
    for (size_t i = 0; i < count; i++)
        if (references[i] == fault_code(instance) && !numbers[i])
            numbers[i] = instance->now.fault;
}

GET(Real, TYPE_REAL)
GET(Integer, TYPE_INTEGER)
GET(Boolean, TYPE_BOOLEAN)
SET(Real, TYPE_REAL)
SET(Integer, TYPE_INTEGER)
SET(Boolean, TYPE_BOOLEAN)

/* There are no strings, so that these two refuse all but an empty list. */
fmi2Status fmi2GetString(fmi2Component component, REFERENCES, fmi2String values[])
{
    return may_get(component, "fmi2GetString", TYPE_STRING, references, count, values) ? fmi2OK : fmi2Error;
}

fmi2Status fmi2SetString(fmi2Component component, REFERENCES, const fmi2String values[])
{
    return may_set(component, "fmi2SetString", TYPE_STRING, references, count, values) ? fmi2OK : fmi2Error;
}

/* Saved states --------------------------------------------------------------------------------------------------- */

static int is_ours(const Instance *instance, const char *guid)
{
    return strncmp(guid, instance->data.guid, GUID_SIZE) == 0;
}

fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    Instance *instance = component;
    fmi2FMUstate python = NULL;
    if (!may(instance, ANY, "fmi2GetFMUstate"))
        return fmi2Error;
    if (!state)
        return refuse(instance, "fmi2GetFMUstate: state is NULL");
    Saved *saved = *state ? *state : calloc(1, sizeof *saved);
    if (!saved)
        return refuse(instance, "fmi2GetFMUstate: there is no memory for a state");
    fmi2Status status = answer(instance, PYTHON(GetFMUstate, &python), "fmi2GetFMUstate");
    if (status != fmi2OK) {
        if (!*state)
            free(saved);
        return status;
    }
    if (saved->python)
        PYTHON(FreeFMUstate, &saved->python);
    saved->now = instance->now;
    saved->python = python;
    *state = saved;
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state)
{
    Instance *instance = component;
    const Saved *saved = state;
    if (!may(instance, ANY, "fmi2SetFMUstate"))
        return fmi2Error;
    if (!state)
        return refuse(instance, "fmi2SetFMUstate: state is NULL");
    if (!is_ours(instance, state))
        return refuse(instance, "fmi2SetFMUstate: the state belongs to another FMU");
    instance->now = saved->now;
    return answer(instance, PYTHON(SetFMUstate, saved->python), "fmi2SetFMUstate");
}

fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    Instance *instance = component;
    if (!may(instance, ANY, "fmi2FreeFMUstate"))
        return fmi2Error;
    if (!state || !*state)
        return fmi2OK;
    Saved *saved = *state;
    fmi2Status status = answer(instance, PYTHON(FreeFMUstate, &saved->python), "fmi2FreeFMUstate");
    free(saved);
    *state = NULL;
    return status;
}

/* The size of a serialised state, of which PythonFMU's is a part; 0 if Python fails. */
static fmi2Status sizes(Instance *instance, const Saved *saved, size_t *python, size_t *whole, const char *call)
{
    fmi2Status status = answer(instance, PYTHON(SerializedFMUstateSize, saved->python, python), call);
    *whole = sizeof(Prefix) + *python + sizeof(uint32_t);
    return status;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component component, fmi2FMUstate state, size_t *size)
{
    Instance *instance = component;
    size_t python = 0, whole = 0;
    if (!may(instance, ANY, "fmi2SerializedFMUstateSize"))
        return fmi2Error;
    if (!state || !size)
        return refuse(instance, "fmi2SerializedFMUstateSize: %s is NULL", state ? "size" : "state");
    fmi2Status status = sizes(instance, state, &python, &whole, "fmi2SerializedFMUstateSize");
    *size = whole;
    return status;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    Instance *instance = component;
    const Saved *saved = state;
    size_t python = 0, whole = 0;
    if (!may(instance, ANY, "fmi2SerializeFMUstate"))
        return fmi2Error;
    if (!state || !bytes)
        return refuse(instance, "fmi2SerializeFMUstate: %s is NULL", state ? "bytes" : "state");
    fmi2Status status = sizes(instance, saved, &python, &whole, "fmi2SerializeFMUstate");
    if (status != fmi2OK)
        return status;
    if (size < whole)
        return refuse(instance, "fmi2SerializeFMUstate: a state takes %zu bytes, not %zu", whole, size);
    Prefix prefix;
    memset(&prefix, 0, sizeof prefix);
    prefix.now = saved->now;
    prefix.python_size = python;
    memcpy(bytes, &prefix, sizeof prefix);
    status = answer(instance, PYTHON(SerializeFMUstate, saved->python, bytes + sizeof prefix, python),
                    "fmi2SerializeFMUstate");
    uint32_t sum = checksum(bytes, sizeof prefix + python);
    memcpy(bytes + sizeof prefix + python, &sum, sizeof sum);
    return status;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component component, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    Instance *instance = component;
    Prefix prefix;
    uint32_t sum = 0;
    if (!may(instance, ANY, "fmi2DeSerializeFMUstate"))
        return fmi2Error;
    if (!bytes || !state)
        return refuse(instance, "fmi2DeSerializeFMUstate: %s is NULL", bytes ? "state" : "bytes");
    if (size < GUID_SIZE || !is_ours(instance, bytes))
        return refuse(instance, "fmi2DeSerializeFMUstate: the state belongs to another FMU");
    if (size >= sizeof prefix + sizeof sum) {
        memcpy(&prefix, bytes, sizeof prefix);
        memcpy(&sum, bytes + size - sizeof sum, sizeof sum);
    }
    if (size < sizeof prefix + sizeof sum || prefix.python_size != size - sizeof prefix - sizeof sum ||
        sum != checksum(bytes, size - sizeof sum))
        return refuse(instance, "fmi2DeSerializeFMUstate: the bytes are not whole");
    Saved *saved = calloc(1, sizeof *saved);
    if (!saved)
        return refuse(instance, "fmi2DeSerializeFMUstate: there is no memory for a state");
    saved->now = prefix.now;
    fmi2Status status =
        answer(instance, PYTHON(DeSerializeFMUstate, bytes + sizeof prefix, (size_t)prefix.python_size, &saved->python),
               "fmi2DeSerializeFMUstate");
    if (status == fmi2OK)
        *state = saved; /* what was there before may be anything, and is the host's to free */
    else
        free(saved);
    return status;
}

/* Optional parts of the standard --------------------------------------------------------------------------------- */

/* A question that the standard leaves optional: refused, and the instance lives on. */
static fmi2Status unsupported(const Instance *instance, fmi2Status status, const char *what)
{
    if (!instance)
        return fmi2Error;
    say(instance, status, what);
    return status;
}

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
    *value = instance->now.time;
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
    *value = instance->now.reason;
    return fmi2OK;
}
