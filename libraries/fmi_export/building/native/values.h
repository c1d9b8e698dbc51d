/* The variables of an instance, by their references. */

#ifndef AMB_VALUES_H
#define AMB_VALUES_H

#include <string.h>

#include "slave.h"

#pragma GCC visibility push(hidden)

/* Refuse a reference for which `is_variable` is false. */
Status wrong_reference(Instance *instance, const char *call, uint32_t reference);

/* Refuse to set a variable that exists. */
Status cannot_be_set(Instance *instance, const char *call, uint32_t reference);

/* The value of an Integer, unless it does not fit into one. */
Status slave_integer(Instance *instance, const char *call, uint32_t reference, int32_t *value);

#pragma GCC visibility pop

/* Functions that every value needs are inline. */

static inline int is_variable(const Instance *instance, uint32_t reference, Type type)
{
    return reference < instance->run.data.n_values && instance->run.data.types[reference] == type;
}

/* Whether a variable may be set now: outputs never, fixed parameters not after initialization. */
static inline int is_settable(Instance *instance, uint32_t reference)
{
    const Data *data = &instance->run.data;
    if (reference >= data->n_parameters)
        return reference < first_output(data);
    instance->now->outcome.checked = 0;
    return data->variables[reference].tunable || instance->now->state != STEP_COMPLETE;
}

static inline int is_repeated(const ReferenceList *list, const uint32_t *references, size_t count)
{
    return count == list->count && (!count || memcmp(list->references, references, count * sizeof *references) == 0);
}

/* A list that is longer than the variables is not stored. */
static inline void remember(const Instance *instance, ReferenceList *list, const uint32_t *references, size_t count)
{
    list->count = 0;
    list->contiguous = 0;
    if (!count || count > (size_t)instance->run.data.n_values)
        return;
    memcpy(list->references, references, count * sizeof *references);
    list->count = count;
    list->contiguous = 1;
    for (size_t i = 1; i < count; i++)
        list->contiguous &= references[i] == references[0] + i;
}

#endif
