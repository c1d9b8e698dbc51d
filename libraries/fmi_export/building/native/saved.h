/* Saved states of an instance. They are identified by their addresses: a pointer that does not belong to this instance
   is never dereferenced. */

#ifndef AMB_SAVED_H
#define AMB_SAVED_H

#include "host.h"

#pragma GCC visibility push(hidden)

Status slave_save(Instance *instance, const char *call, void **state);
Status slave_restore(Instance *instance, const char *call, const void *state);
Status slave_forget(Instance *instance, const char *call, void **state);
Status slave_serialised_size(Instance *instance, const char *call, const void *state, size_t *size);
Status slave_serialise(Instance *instance, const char *call, const void *state, void *bytes, size_t size);
Status slave_deserialise(Instance *instance, const char *call, const void *bytes, size_t size, void **state);

/* Free the states that the host has not freed. */
void free_states(Instance *instance);

#pragma GCC visibility pop

#endif
