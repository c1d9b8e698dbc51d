/* Binds an instance to FMI 3.0 for co-simulation, without event mode and early return.

   The value reference of a variable is its position, as in FMI 2.0. Variables of the same kind that stand in sequence
   may be the elements of an array: it has the reference of the first of them, and the others have none. `time`, the
   independent variable, follows the last position.

   A fault is fmi3Error. fmi3Discard would promise the state from before the step, which a step does not keep; a host
   that wants it saves it. A step beyond the stop time is fmi3Error because the standard says so, although nothing
   has changed then. What FMI 3.0 has besides is in fmi3_absent.c, refused. */

#include <stdlib.h>

#include "fmi3Functions.h"
#include "derivative.h"
#include "saved.h"
#include "slave.h"
#include "values.h"

#define REFERENCES const fmi3ValueReference references[], size_t count

/* Hand a text to the host's logger, in which #123# is a variable and ## a number sign. */
static void log_text(const Host *host, const char *name, Status status, const char *category, const char *text)
{
    char message[2 * TEXT_SIZE];
    size_t used = 0;
    (void)name;
    for (; *text && used < sizeof message - 2; text++) {
        if (*text == '#')
            message[used++] = '#';
        message[used++] = *text;
    }
    message[used] = '\0';
    ((fmi3LogMessageCallback)host->logger)(host->environment, (fmi3Status)status, category, message);
}

static const FmiBinding BINDING = {
    .states = {"Instantiated", "Initialization Mode", "Step Mode", "Terminated", "Terminated by an error"},
    .log = log_text,
};

enum { SETTABLE = INSTANTIATED | INITIALIZATION | STEP_COMPLETE };

/* Life cycle ----------------------------------------------------------------------------------------------------- */

const char *fmi3GetVersion(void) { return fmi3Version; }

static Host host_of(fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger)
{
    return (Host){&BINDING, environment, (void (*)(void))logger};
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean event_mode, fmi3Boolean early_return,
                                         const fmi3ValueReference intermediate[], size_t n_intermediate,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                         fmi3IntermediateUpdateCallback update)
{
    Host host = host_of(environment, logger);
    const char *reason = event_mode       ? "this FMU has no event mode"
                         : n_intermediate ? "this FMU has no values within a step"
                                          : NULL;
    (void)visible, (void)early_return, (void)intermediate, (void)update;
    if (!reason)
        return slave_new(name, token, resources, &host, logging);
    slave_log_no_instance(&host, name, reason);
    return NULL;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback logger)
{
    Host host = host_of(environment, logger);
    (void)token, (void)resources, (void)visible, (void)logging;
    slave_log_no_instance(&host, name, "this is an FMU for co-simulation, not for model exchange");
    return NULL;
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                               fmi3Boolean visible, fmi3Boolean logging,
                                               fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                               fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock,
                                               fmi3UnlockPreemptionCallback unlock)
{
    Host host = host_of(environment, logger);
    (void)token, (void)resources, (void)visible, (void)logging, (void)update, (void)lock, (void)unlock;
    slave_log_no_instance(&host, name, "this is an FMU for co-simulation, not for scheduled execution");
    return NULL;
}

void fmi3FreeInstance(fmi3Instance instance) { slave_free(instance); }

/* Unlike in FMI 2.0 categories are switched, and those that are not named stay as they are. */
fmi3Status fmi3SetDebugLogging(fmi3Instance component, fmi3Boolean on, size_t count, const fmi3String categories[])
{
    Instance *instance = component;
    unsigned int chosen;
    Status status = slave_categories(instance, __func__, categories, count, &chosen);
    if (status == STATUS_OK)
        instance->enabled_categories =
            on ? instance->enabled_categories | chosen : instance->enabled_categories & ~chosen;
    return (fmi3Status)status;
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean has_tolerance, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean has_stop, fmi3Float64 stop)
{
    (void)has_tolerance, (void)tolerance;
    Status status = slave_set_times(instance, __func__, start, has_stop, stop);
    return (fmi3Status)(status == STATUS_OK ? slave_enter_initialization(instance, __func__) : status);
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    return (fmi3Status)slave_exit_initialization(instance, __func__);
}

fmi3Status fmi3DoStep(fmi3Instance component, fmi3Float64 time, fmi3Float64 step_size, fmi3Boolean no_earlier_state,
                      fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early_return, fmi3Float64 *last_time)
{
    Instance *instance = component;
    (void)no_earlier_state;
    Status status = slave_step(instance, __func__, time, step_size);
    if (event)
        *event = fmi3False;
    if (terminate)
        *terminate = fmi3False;
    if (early_return)
        *early_return = fmi3False;
    if (last_time && instance)
        *last_time = instance->now->time;
    return (fmi3Status)status;
}

fmi3Status fmi3Terminate(fmi3Instance instance) { return (fmi3Status)slave_terminate(instance, __func__); }

fmi3Status fmi3Reset(fmi3Instance instance) { return (fmi3Status)slave_reset(instance, __func__); }

/* Variables ------------------------------------------------------------------------------------------------------ */

static int is_time(const Instance *instance, fmi3ValueReference reference)
{
    return reference == instance->run.data.n_values;
}

/* How many values a reference stands for; 0 if it is that of an element of an array. */
static size_t length_of(const Instance *instance, fmi3ValueReference reference)
{
    return is_time(instance, reference) ? 1 : instance->run.data.variables[reference].length;
}

/* Before values are read or set: state, pointers, and that there are as many values as the references stand for. */
static Status before(Instance *instance, int states, const char *call, Type type, REFERENCES, const void *values,
                     size_t n_values)
{
    size_t total = 0;
    if (!may(instance, states, call))
        return STATUS_ERROR;
    if ((count && !references) || (n_values && !values))
        return fail(instance, "%s: %s is NULL", call, references ? "values" : "references");
    for (size_t i = 0; i < count; i++) {
        fmi3ValueReference r = references[i];
        if (!is_variable(instance, r, type) && !(type == TYPE_REAL && is_time(instance, r)))
            return wrong_reference(instance, call, r);
        if (!length_of(instance, r))
            return fail(instance, "%s: %s is an element of an array, whose value reference is that of the first one",
                        call, name_of(&instance->run.data, r));
        total += length_of(instance, r);
    }
    if (total != n_values)
        return fail(instance, "%s: these variables have %zu values, not %zu", call, total, n_values);
    return STATUS_OK;
}

static Status before_get(Instance *instance, const char *call, Type type, REFERENCES, const void *values,
                         size_t n_values)
{
    Status status = before(instance, ANY, call, type, references, count, values, n_values);
    return status == STATUS_OK ? refresh(instance) : status;
}

static Status before_set(Instance *instance, const char *call, Type type, REFERENCES, const void *values,
                         size_t n_values)
{
    if (before(instance, SETTABLE, call, type, references, count, values, n_values) != STATUS_OK)
        return STATUS_ERROR;
    for (size_t i = 0; i < count; i++)
        if (is_time(instance, references[i]))
            return fail(instance, "%s: time cannot be set", call);
        else if (!is_settable(instance, references[i]))
            return cannot_be_set(instance, call, references[i]);
    instance->now->stale = 1;
    return STATUS_OK;
}

/* The values of a variable, in sequence. */
static double *values_of(const Instance *instance, fmi3ValueReference reference)
{
    return is_time(instance, reference) ? &instance->now->time : instance->run.values + reference;
}

/* What follows for each value k of each reference: `there` is its place among the model's, `values` that of the
   host. */
#define FOR_EACH_VALUE(instance, references, count)                                                                    \
    for (size_t i = 0; i < (count); i++)                                                                               \
        for (double *there = values_of(instance, (references)[i]),                                                     \
                    *end = there + length_of(instance, (references)[i]);                                               \
             there < end; there++, values++)

#define GET(TYPE, KIND, VALUE)                                                                                         \
    fmi3Status fmi3Get##TYPE(fmi3Instance component, REFERENCES, fmi3##TYPE values[], size_t n_values)                 \
    {                                                                                                                  \
        Instance *instance = component;                                                                                \
        Status status = before_get(instance, __func__, KIND, references, count, values, n_values);                     \
        if (status <= STATUS_WARNING)                                                                                  \
            FOR_EACH_VALUE(instance, references, count) {                                                              \
                VALUE;                                                                                                 \
            }                                                                                                          \
        return (fmi3Status)status;                                                                                     \
    }

#define SET(TYPE, KIND)                                                                                                \
    fmi3Status fmi3Set##TYPE(fmi3Instance component, REFERENCES, const fmi3##TYPE values[], size_t n_values)           \
    {                                                                                                                  \
        Instance *instance = component;                                                                                \
        Status status = before_set(instance, __func__, KIND, references, count, values, n_values);                     \
        if (status == STATUS_OK)                                                                                       \
            FOR_EACH_VALUE(instance, references, count)                                                                \
                *there = (double)*values;                                                                              \
        return (fmi3Status)status;                                                                                     \
    }

#define INTEGER                                                                                                        \
    int32_t value = 0;                                                                                                 \
    if (slave_integer(instance, __func__, (uint32_t)(there - instance->run.values), &value) != STATUS_OK)              \
        return fmi3Error;                                                                                              \
    *values = value

GET(Float64, TYPE_REAL, *values = *there)
GET(Boolean, TYPE_BOOLEAN, *values = *there != 0.0)
GET(Int32, TYPE_INTEGER, INTEGER)
GET(Int64, TYPE_INTEGER, INTEGER) /* of enumerations, which FMI 3.0 reads and sets so */
SET(Float64, TYPE_REAL)
SET(Boolean, TYPE_BOOLEAN)
SET(Int32, TYPE_INTEGER)
SET(Int64, TYPE_INTEGER)

/* Saved states --------------------------------------------------------------------------------------------------- */

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    return (fmi3Status)slave_save(instance, __func__, state);
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state)
{
    return (fmi3Status)slave_restore(instance, __func__, state);
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    return (fmi3Status)slave_forget(instance, __func__, state);
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size)
{
    return (fmi3Status)slave_serialised_size(instance, __func__, state, size);
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    return (fmi3Status)slave_serialise(instance, __func__, state, bytes, size);
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState *state)
{
    return (fmi3Status)slave_deserialise(instance, __func__, bytes, size, state);
}

/* Derivatives ---------------------------------------------------------------------------------------------------- */

/* Positions of all values of variables, `n` of them; NULL if there are others, a reference is none of a Float64, or
   there is no memory. */
static uint32_t *positions_of(Instance *instance, REFERENCES, size_t n)
{
    size_t used = 0;
    int is_possible = !n || (n - 1) / (size_t)instance->run.data.n_values < count;
    uint32_t *positions = is_possible ? malloc((n + 1) * sizeof *positions) : NULL;
    for (size_t i = 0; positions && i < count; i++) {
        size_t length = is_variable(instance, references[i], TYPE_REAL) ? length_of(instance, references[i]) : 0;
        if (!length || length > n - used) {
            free(positions);
            return NULL;
        }
        for (size_t k = 0; k < length; k++)
            positions[used++] = references[i] + (uint32_t)k;
    }
    if (positions && used == n)
        return positions;
    free(positions);
    return NULL;
}

/* The derivatives of variables, arrays among them, by others. */
static Status derivatives(Instance *instance, const char *call,
                          Status (*find)(Instance *, const char *, const Derivatives *, const double *, double *),
                          const fmi3ValueReference unknowns[], const fmi3ValueReference knowns[], Derivatives of,
                          size_t n_of_unknowns, size_t n_of_knowns, const double *seed, double *results)
{
    if (!may(instance, STEP_COMPLETE, call))
        return STATUS_ERROR;
    if ((of.n_unknowns && !unknowns) || (of.n_knowns && !knowns))
        return fail(instance, "%s: references is NULL", call);
    uint32_t *of_unknowns = positions_of(instance, unknowns, of.n_unknowns, n_of_unknowns);
    uint32_t *of_knowns = positions_of(instance, knowns, of.n_knowns, n_of_knowns);
    const Derivatives values = {of_unknowns, of_knowns, n_of_unknowns, n_of_knowns};
    Status status =
        of_unknowns && of_knowns
            ? find(instance, call, &values, seed, results)
            : decline(instance,
                      "%s: all variables must be Float64, with a value of seed or sensitivity for each element", call);
    free(of_unknowns);
    free(of_knowns);
    return status;
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t n_unknowns,
                                        const fmi3ValueReference knowns[], size_t n_knowns, const fmi3Float64 seed[],
                                        size_t n_seed, fmi3Float64 sensitivity[], size_t n_sensitivity)
{
    const Derivatives of = {NULL, NULL, n_unknowns, n_knowns};
    return (fmi3Status)derivatives(instance, __func__, slave_directional, unknowns, knowns, of, n_sensitivity, n_seed,
                                   seed, sensitivity);
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t n_unknowns,
                                    const fmi3ValueReference knowns[], size_t n_knowns, const fmi3Float64 seed[],
                                    size_t n_seed, fmi3Float64 sensitivity[], size_t n_sensitivity)
{
    const Derivatives of = {NULL, NULL, n_unknowns, n_knowns};
    return (fmi3Status)derivatives(instance, __func__, slave_adjoint, unknowns, knowns, of, n_seed, n_sensitivity, seed,
                                   sensitivity);
}
