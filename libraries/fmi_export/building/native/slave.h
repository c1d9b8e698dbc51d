/* The life cycle of an instance. */

#ifndef AMB_SLAVE_H
#define AMB_SLAVE_H

#include "host.h"

#pragma GCC visibility push(hidden)

/* A new instance with the data at a resource location; NULL on failure, and the logger has the reason. */
Instance *slave_new(const char *name, const char *guid, const char *location, const Host *host, int logging);
void slave_free(Instance *instance);

Status slave_set_times(Instance *instance, const char *call, double start, int has_stop, double stop);
Status slave_enter_initialization(Instance *instance, const char *call);
Status slave_exit_initialization(Instance *instance, const char *call);
Status slave_step(Instance *instance, const char *call, double time, double step_size);
Status slave_terminate(Instance *instance, const char *call);
Status slave_reset(Instance *instance, const char *call);

/* Initialise again, so that outputs are right throughout initialization mode. A fault can still be put right, and is
   a warning. */
Status slave_initialise_again(Instance *instance);

#pragma GCC visibility pop

/* Before values are read: outputs up to date, if something was set in initialization mode since. */
static inline Status refresh(Instance *instance)
{
    int right = instance->now->state != INITIALIZATION || !instance->now->stale;
    return right ? STATUS_OK : slave_initialise_again(instance);
}

#endif
