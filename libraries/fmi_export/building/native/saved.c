/* Saved states: one copy of memory, alone or with a checksum as bytes. */

#include <stdlib.h>
#include <string.h>

#include "slave.h"

static int is_ours(const Instance *instance, const char *guid)
{
    return strncmp(guid, instance->run.data.guid, GUID_SIZE) == 0;
}

/* Bytes may come from anywhere, so they end with the checksum of those before. */
static size_t serialised_size(const Instance *instance)
{
    return instance->saved_size + sizeof(uint32_t);
}

Status slave_save(Instance *instance, const char *call, void **state)
{
    if (!may(instance, ANY, call))
        return STATUS_ERROR;
    if (!state)
        return fail(instance, "%s: state is NULL", call);
    void *saved = *state ? *state : malloc(instance->saved_size);
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
    if (!is_ours(instance, state))
        return fail(instance, "%s: the state belongs to another FMU", call);
    memcpy(instance->now, state, instance->saved_size);
    return STATUS_OK;
}

Status slave_forget(Instance *instance, const char *call, void **state)
{
    if (!may(instance, ANY, call))
        return STATUS_ERROR;
    if (state) {
        free(*state);
        *state = NULL;
    }
    return STATUS_OK;
}

Status slave_serialised_size(Instance *instance, const char *call, const void *state, size_t *size)
{
    if (!may(instance, ANY, call))
        return STATUS_ERROR;
    if (!state || !size)
        return fail(instance, "%s: %s is NULL", call, state ? "size" : "state");
    *size = serialised_size(instance);
    return STATUS_OK;
}

Status slave_serialise(Instance *instance, const char *call, const void *state, void *bytes, size_t size)
{
    if (!may(instance, ANY, call))
        return STATUS_ERROR;
    if (!state || !bytes)
        return fail(instance, "%s: %s is NULL", call, state ? "bytes" : "state");
    if (size < serialised_size(instance))
        return fail(instance, "%s: a state takes %zu bytes, not %zu", call, serialised_size(instance), size);
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
    if (size < GUID_SIZE || !is_ours(instance, bytes))
        return fail(instance, "%s: the state belongs to another FMU", call);
    if (size == serialised_size(instance))
        memcpy(&sum, (const char *)bytes + instance->saved_size, sizeof sum);
    if (size != serialised_size(instance) || sum != checksum(bytes, instance->saved_size))
        return fail(instance, "%s: the bytes are not whole", call);
    void *saved = malloc(instance->saved_size);
    if (!saved)
        return fail(instance, "%s: there is no memory for a state", call);
    memcpy(saved, bytes, instance->saved_size);
    *state = saved; /* what was there before may be anything, and is the host's to free */
    return STATUS_OK;
}
