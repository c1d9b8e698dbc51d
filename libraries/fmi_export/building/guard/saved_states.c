/* Saving, restoring and serialising an instance: what the guard knows of it, and what Python does. */

#include <stdlib.h>
#include <string.h>

#include "guard.h"

typedef struct {
    Now now;
    fmi2FMUstate python;
} Saved;

/* A serialised state is this, the bytes of PythonFMU's, and the checksum of both. */
typedef struct {
    Now now;
    uint64_t python_size;
} Prefix;

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
