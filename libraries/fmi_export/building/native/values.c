/* Messages about values that a host may not read or set. */

#include "values.h"

#include <limits.h>

static const char *const TYPE_NAMES[] = {"Real", "Integer", "Boolean", "String"};

Status wrong_reference(Instance *instance, const char *call, uint32_t reference)
{
    const Data *data = &instance->run.data;
    if (reference < data->n_values)
        return fail(instance, "%s: %s is of type %s", call, name_of(data, reference),
                    TYPE_NAMES[data->types[reference]]);
    return fail(instance, "%s: there is no value reference %u", call, reference);
}

Status cannot_be_set(Instance *instance, const char *call, uint32_t reference)
{
    const Data *data = &instance->run.data;
    return fail(instance, "%s: %s is a %s and cannot be set now", call, name_of(data, reference),
                data->text + data->variables[reference].kind);
}

Status slave_integer(Instance *instance, const char *call, uint32_t reference, int32_t *value)
{
    double number = instance->run.values[reference];
    if (!(number > INT_MIN - 1.0 && number < INT_MAX + 1.0))
        return fail(instance, "%s: %s = %g does not fit into an integer", call, name_of(&instance->run.data, reference),
                    number);
    *value = (int32_t)number;
    return STATUS_OK;
}
