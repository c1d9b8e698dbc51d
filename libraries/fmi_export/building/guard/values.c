/* Reading and setting variables. */

#include "guard.h"

static const char *const TYPE_NAMES[] = {"Real", "Integer", "Boolean", "String"};

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
    char text[TEXT_SIZE];
    say_when(instance, text, fmi2Warning, instance->heard);
    say(instance, fmi2Warning, text);
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
    fmi2ValueReference fault_code = (fmi2ValueReference)instance->data.n_values - 1;
    if (type != TYPE_INTEGER || !instance->now.fault)
        return;
    for (size_t i = 0; i < count; i++)
        if (references[i] == fault_code && !numbers[i])
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
