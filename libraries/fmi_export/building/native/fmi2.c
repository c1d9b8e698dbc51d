/* Binds an instance to FMI 2.0 for co-simulation. */

#include "fmi2Functions.h"
#include "derivative.h"
#include "saved.h"
#include "slave.h"
#include "values.h"

#define REFERENCES const fmi2ValueReference references[], size_t count

/* Pass a text to the host's logger, which takes it for a printf format. */
static void log_text(const Host *host, const char *name, Status status, const char *category, const char *text)
{
    char format[2 * TEXT_SIZE];
    size_t used = 0;
    for (; *text && used < sizeof format - 2; text++) {
        if (*text == '%')
            format[used++] = '%';
        format[used++] = *text;
    }
    format[used] = '\0';
    ((fmi2CallbackLogger)host->logger)(host->environment, name, (fmi2Status)status, category, format);
}

static const FmiBinding BINDING = {
    .states = {"instantiated", "initialization mode", "step complete", "terminated", "error"},
    .log = log_text,
};

enum {
    READABLE = INITIALIZATION | STEP_COMPLETE | TERMINATED | ERROR,
    SETTABLE = INSTANTIATED | INITIALIZATION | STEP_COMPLETE,
    ASKABLE = STEP_COMPLETE | TERMINATED | ERROR, /* the standard omits ERROR, in which queries are most useful */
};

/* Life cycle ----------------------------------------------------------------------------------------------------- */

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }

const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    (void)visible;
    if (!functions)
        return NULL;
    Host host = {&BINDING, functions->componentEnvironment, (void (*)(void))functions->logger};
    if (type != fmi2CoSimulation) {
        slave_log_no_instance(&host, name, "this is an FMU for co-simulation, not for model exchange");
        return NULL;
    }
    return slave_new(name, guid, resources, &host, logging != fmi2False);
}

void fmi2FreeInstance(fmi2Component component) { slave_free(component); }

fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean on, size_t count, const fmi2String categories[])
{
    Instance *instance = component;
    unsigned int chosen;
    Status status = slave_categories(instance, __func__, categories, count, &chosen);
    if (status == STATUS_OK)
        instance->enabled_categories = on != fmi2False ? chosen : 0;
    return (fmi2Status)status;
}

fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean has_stop, fmi2Real stop)
{
    (void)has_tolerance, (void)tolerance;
    return (fmi2Status)slave_set_times(component, __func__, start, has_stop, stop);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component component)
{
    return (fmi2Status)slave_enter_initialization(component, __func__);
}

fmi2Status fmi2ExitInitializationMode(fmi2Component component)
{
    return (fmi2Status)slave_exit_initialization(component, __func__);
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real time, fmi2Real step_size, fmi2Boolean no_earlier_state)
{
    (void)no_earlier_state;
    return (fmi2Status)slave_step(component, __func__, time, step_size);
}

fmi2Status fmi2Terminate(fmi2Component component) { return (fmi2Status)slave_terminate(component, __func__); }

fmi2Status fmi2Reset(fmi2Component component) { return (fmi2Status)slave_reset(component, __func__); }

/* Variables ------------------------------------------------------------------------------------------------------ */

/* Before values are read: check state, pointers, references and types, and update the outputs. */
static Status before_get(Instance *instance, const char *call, Type type, REFERENCES, const void *values)
{
    if (!may(instance, READABLE, call))
        return STATUS_ERROR;
    if (count && (!references || !values))
        return fail(instance, "%s: %s is NULL", call, references ? "values" : "references");
    if (type == TYPE_REAL && is_repeated(&instance->read, references, count))
        return refresh(instance);
    for (size_t i = 0; i < count; i++)
        if (!is_variable(instance, references[i], type))
            return wrong_reference(instance, call, references[i]);
    if (type == TYPE_REAL)
        remember(instance, &instance->read, references, count);
    return refresh(instance);
}

/* Before values are set: check the same, and that each may be set now. */
static Status before_set(Instance *instance, const char *call, Type type, REFERENCES, const void *values)
{
    if (!may(instance, SETTABLE, call))
        return STATUS_ERROR;
    if (count && (!references || !values))
        return fail(instance, "%s: %s is NULL", call, references ? "values" : "references");
    instance->now->stale = 1;
    if (type == TYPE_REAL && is_repeated(&instance->written, references, count))
        return STATUS_OK;
    int are_inputs = type == TYPE_REAL;
    for (size_t i = 0; i < count; i++) {
        if (!is_variable(instance, references[i], type))
            return wrong_reference(instance, call, references[i]);
        if (!is_settable(instance, references[i]))
            return cannot_be_set(instance, call, references[i]);
        are_inputs &= references[i] >= instance->run.data.n_parameters;
    }
    if (are_inputs)
        remember(instance, &instance->written, references, count);
    return STATUS_OK;
}

fmi2Status fmi2GetReal(fmi2Component component, REFERENCES, fmi2Real values[])
{
    Instance *instance = component;
    Status status = before_get(instance, __func__, TYPE_REAL, references, count, values);
    if (status > STATUS_WARNING || !count)
        return (fmi2Status)status;
    if (instance->read.contiguous)
        memcpy(values, instance->run.values + references[0], count * sizeof *values);
    else
        for (size_t i = 0; i < count; i++)
            values[i] = instance->run.values[references[i]];
    return (fmi2Status)status;
}

fmi2Status fmi2GetInteger(fmi2Component component, REFERENCES, fmi2Integer values[])
{
    Instance *instance = component;
    Status status = before_get(instance, __func__, TYPE_INTEGER, references, count, values);
    for (size_t i = 0; i < count && status <= STATUS_WARNING; i++)
        if (slave_integer(instance, __func__, references[i], &values[i]) != STATUS_OK)
            return fmi2Error;
    return (fmi2Status)status;
}

fmi2Status fmi2GetBoolean(fmi2Component component, REFERENCES, fmi2Boolean values[])
{
    Instance *instance = component;
    Status status = before_get(instance, __func__, TYPE_BOOLEAN, references, count, values);
    for (size_t i = 0; i < count && status <= STATUS_WARNING; i++)
        values[i] = instance->run.values[references[i]] != 0.0;
    return (fmi2Status)status;
}

/* There are no string variables, so these two refuse all lists that are not empty. */
fmi2Status fmi2GetString(fmi2Component component, REFERENCES, fmi2String values[])
{
    return (fmi2Status)before_get(component, __func__, TYPE_STRING, references, count, values);
}

fmi2Status fmi2SetString(fmi2Component component, REFERENCES, const fmi2String values[])
{
    return (fmi2Status)before_set(component, __func__, TYPE_STRING, references, count, values);
}

#define SET(TYPE, KIND, VALUE)                                                                                         \
    fmi2Status fmi2Set##TYPE(fmi2Component component, REFERENCES, const fmi2##TYPE values[])                           \
    {                                                                                                                  \
        Instance *instance = component;                                                                                \
        Status status = before_set(instance, __func__, KIND, references, count, values);                               \
        for (size_t i = 0; i < count && status == STATUS_OK; i++)                                                      \
            instance->run.values[references[i]] = VALUE;                                                               \
        return (fmi2Status)status;                                                                                     \
    }

SET(Real, TYPE_REAL, values[i])
SET(Integer, TYPE_INTEGER, values[i])
SET(Boolean, TYPE_BOOLEAN, values[i] != fmi2False)

/* Saved states --------------------------------------------------------------------------------------------------- */

fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    return (fmi2Status)slave_save(component, __func__, state);
}

fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state)
{
    return (fmi2Status)slave_restore(component, __func__, state);
}

fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    return (fmi2Status)slave_forget(component, __func__, state);
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component component, fmi2FMUstate state, size_t *size)
{
    return (fmi2Status)slave_serialised_size(component, __func__, state, size);
}

fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    return (fmi2Status)slave_serialise(component, __func__, state, bytes, size);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component component, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    return (fmi2Status)slave_deserialise(component, __func__, bytes, size, state);
}

/* Status --------------------------------------------------------------------------------------------------------- */

static fmi2Status no_status(Instance *instance, const char *call, const char *why)
{
    return (fmi2Status)unsupported(instance, STATUS_DISCARD, call, why);
}

fmi2Status fmi2GetStatus(fmi2Component component, fmi2StatusKind kind, fmi2Status *value)
{
    (void)kind, (void)value;
    return no_status(component, __func__, "steps are never asynchronous");
}

fmi2Status fmi2GetRealStatus(fmi2Component component, fmi2StatusKind kind, fmi2Real *value)
{
    Instance *instance = component;
    if (!may(instance, ASKABLE, __func__))
        return fmi2Error;
    if (kind != fmi2LastSuccessfulTime || !value)
        return no_status(instance, __func__, "the only Real status is fmi2LastSuccessfulTime");
    *value = instance->now->time;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component component, fmi2StatusKind kind, fmi2Integer *value)
{
    (void)kind, (void)value;
    return no_status(component, __func__, "there is no Integer status");
}

fmi2Status fmi2GetBooleanStatus(fmi2Component component, fmi2StatusKind kind, fmi2Boolean *value)
{
    Instance *instance = component;
    if (!may(instance, ASKABLE, __func__))
        return fmi2Error;
    if (kind != fmi2Terminated || !value)
        return no_status(instance, __func__, "the only Boolean status is fmi2Terminated");
    *value = fmi2False;
    return fmi2OK;
}

/* The reason why the last call was refused, whether it was logged or not; empty if it was not refused. The text is
   valid until the next call. */
fmi2Status fmi2GetStringStatus(fmi2Component component, fmi2StatusKind kind, fmi2String *value)
{
    Instance *instance = component;
    if (!may(instance, ASKABLE, __func__))
        return fmi2Error;
    if (kind != fmi2PendingStatus || !value)
        return no_status(instance, __func__, "the only String status is fmi2PendingStatus");
    *value = instance->now->outcome.reason;
    return fmi2OK;
}

/* Derivatives ---------------------------------------------------------------------------------------------------- */

fmi2Status fmi2GetDirectionalDerivative(fmi2Component component, const fmi2ValueReference unknowns[], size_t n_unknowns,
                                        const fmi2ValueReference knowns[], size_t n_knowns, const fmi2Real dv_known[],
                                        fmi2Real dv_unknown[])
{
    const Derivatives of = {unknowns, knowns, n_unknowns, n_knowns};
    return (fmi2Status)slave_directional(component, __func__, &of, dv_known, dv_unknown);
}

/* Optional parts of the standard --------------------------------------------------------------------------------- */

static fmi2Status not_here(Instance *instance, const char *call, const char *why)
{
    return (fmi2Status)unsupported(instance, STATUS_ERROR, call, why);
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component component, REFERENCES, const fmi2Integer orders[],
                                       const fmi2Real values[])
{
    (void)references, (void)count, (void)orders, (void)values;
    return not_here(component, __func__, "inputs are constant during a step");
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component component, REFERENCES, const fmi2Integer orders[],
                                        fmi2Real values[])
{
    (void)references, (void)count, (void)orders, (void)values;
    return not_here(component, __func__, "this FMU provides no time derivatives of its outputs");
}

fmi2Status fmi2CancelStep(fmi2Component component)
{
    return not_here(component, __func__, "there is no step to cancel; steps are never asynchronous");
}
