/* The life cycle of an instance. */

#ifndef AMB_SLAVE_H
#define AMB_SLAVE_H

#include "host.h"

#pragma GCC visibility push(hidden)

/* A new instance with the data at a resource location; NULL on failure, whose reason is logged. */
Instance *slave_new(const char *name, const char *guid, const char *location, const Host *host, int logging);
void slave_free(Instance *instance);

Status slave_set_times(Instance *instance, const char *call, double start, int has_stop, double stop);
Status slave_enter_initialization(Instance *instance, const char *call);
Status slave_exit_initialization(Instance *instance, const char *call);
Status slave_step(Instance *instance, const char *call, double time, double step_size);
Status slave_terminate(Instance *instance, const char *call);
Status slave_reset(Instance *instance, const char *call);

/* Initialise again, so that outputs are current throughout initialization mode. A fault is only a warning, because the
   host can still correct the values. */
Status slave_initialise_again(Instance *instance);

#pragma GCC visibility pop

/* Before values are read: update the outputs if a value was set in initialization mode since. */
static inline Status refresh(Instance *instance)
{
    int is_current = instance->now->state != INITIALIZATION || !instance->now->stale;
    return is_current ? STATUS_OK : slave_initialise_again(instance);
}

#endif
