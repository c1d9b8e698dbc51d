/* Saved states: a copy of memory, or bytes with a checksum. An instance identifies its copies by their addresses, and
   refuses any other pointer, which may have been freed or belong to another instance: to pass a state between
   instances, serialise it. */

#include "saved.h"

#include <stdlib.h>
#include <string.h>

/* The index of a state among those of an instance, or their count. The latest are compared first. */
static size_t number_of(const Instance *instance, const void *state)
{
    for (size_t i = instance->n_states; i-- > 0;)
        if (instance->states[i] == state)
            return i;
    return instance->n_states;
}

static int is_saved(const Instance *instance, const void *state)
{
    return number_of(instance, state) < instance->n_states;
}

/* Room for another state, or NULL. */
static void *new_state(Instance *instance)
{
    if (instance->n_states == instance->room_for_states) {
        size_t room = 2 * instance->room_for_states + 4;
        void **states = realloc(instance->states, room * sizeof *states);
        if (!states)
            return NULL;
        instance->states = states;
        instance->room_for_states = room;
    }
    void *state = malloc(instance->saved_size);
    if (state)
        instance->states[instance->n_states++] = state;
    return state;
}

void free_states(Instance *instance)
{
    for (size_t i = 0; i < instance->n_states; i++)
        free(instance->states[i]);
    free(instance->states);
}

static const char NO_STATE[] = "%s: the pointer belongs to no state that this instance has saved and not freed";

/* Bytes may come from anywhere, so they end with the checksum of those before. */
static size_t serialised_size(const Instance *instance) { return instance->saved_size + sizeof(uint32_t); }

/* A pointer on entry that is not a state of this instance may be anything, such as uninitialised memory of the host,
   and is ignored. */
Status slave_save(Instance *instance, const char *call, void **state)
{
    if (!may(instance, ANY, call))
        return STATUS_ERROR;
    if (!state)
        return fail(instance, "%s: state is NULL", call);
    void *saved = is_saved(instance, *state) ? *state : new_state(instance);
    if (!saved)
        return fail(instance, "%s: there is no memory for a state", call);
    memcpy(saved, instance->now, instance->saved_size);
    *state = saved;
    return STATUS_OK;
}

Status slave_restore(Instance *instance, const char *call, const void *state)
{
    if (!may(instance, ANY, call))
        return STATUS_ERROR;
    if (!state)
        return fail(instance, "%s: state is NULL", call);
    if (!is_saved(instance, state))
        return fail(instance, NO_STATE, call);
    memcpy(instance->now, state, instance->saved_size);
    return STATUS_OK;
}

Status slave_forget(Instance *instance, const char *call, void **state)
{
    if (!may(instance, ANY, call))
        return STATUS_ERROR;
    if (!state || !*state)
        return STATUS_OK;
    if (!is_saved(instance, *state))
        return reject(instance, NO_STATE, call);
    instance->states[number_of(instance, *state)] = instance->states[instance->n_states - 1];
    instance->n_states--;
    free(*state);
    *state = NULL;
    return STATUS_OK;
}

Status slave_serialised_size(Instance *instance, const char *call, const void *state, size_t *size)
{
    if (!may(instance, ANY, call))
        return STATUS_ERROR;
    if (!state || !size)
        return fail(instance, "%s: %s is NULL", call, state ? "size" : "state");
    if (!is_saved(instance, state))
        return fail(instance, NO_STATE, call);
    *size = serialised_size(instance);
    return STATUS_OK;
}

Status slave_serialise(Instance *instance, const char *call, const void *state, void *bytes, size_t size)
{
    if (!may(instance, ANY, call))
        return STATUS_ERROR;
    if (!state || !bytes)
        return fail(instance, "%s: %s is NULL", call, state ? "bytes" : "state");
    if (!is_saved(instance, state))
        return fail(instance, NO_STATE, call);
    if (size < serialised_size(instance))
        return fail(instance, "%s: size = %zu bytes is not allowed; it must be >= %zu bytes, the size of a state", call,
                    size, serialised_size(instance));
    uint32_t sum = checksum(state, instance->saved_size);
    memcpy(bytes, state, instance->saved_size);
    memcpy((char *)bytes + instance->saved_size, &sum, sizeof sum);
    return STATUS_OK;
}

Status slave_deserialise(Instance *instance, const char *call, const void *bytes, size_t size, void **state)
{
    uint32_t sum = 0;
    if (!may(instance, ANY, call))
        return STATUS_ERROR;
    if (!bytes || !state)
        return fail(instance, "%s: %s is NULL", call, bytes ? "state" : "bytes");
    if (size < GUID_SIZE || strncmp(bytes, instance->run.data.guid, GUID_SIZE) != 0)
        return fail(instance, "%s: the state belongs to another FMU", call);
    if (size == serialised_size(instance))
        memcpy(&sum, (const char *)bytes + instance->saved_size, sizeof sum);
    if (size != serialised_size(instance) || sum != checksum(bytes, instance->saved_size))
        return fail(instance, "%s: the bytes are damaged, or their number is wrong", call);
    void *saved = new_state(instance);
    if (!saved)
        return fail(instance, "%s: there is no memory for a state", call);
    memcpy(saved, bytes, instance->saved_size);
    *state = saved; /* its previous value may be anything, and belongs to the host */
    return STATUS_OK;
}
