/* Life cycle of an instance. Nothing here is global and writable, so instances share nothing. Apart from its kernels, a
   model is defined by the resources, which are read when an instance is made. Memory is allocated once for each
   instance and for each saved state, and while derivatives are computed. */

#include "slave.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "assembly.h"
#include "resources.h"
#include "saved.h"

/* Log each warning when it is true for the first time, after initialisation or at the end of a step. */
static void warn(Instance *instance, int stepped)
{
    char text[TEXT_SIZE];
    while (run_next_warning(&instance->run, text))
        if (stepped)
            log_status(instance, STATUS_WARNING, "at t = %.9g s: %s", instance->now->time, text);
        else
            log_status(instance, STATUS_WARNING, "initialisation: %s", text);
}

/* Making an instance --------------------------------------------------------------------------------------------- */

static void start_over(Instance *instance)
{
    Saved *now = instance->now;
    memcpy(now->guid, instance->run.data.guid, GUID_SIZE);
    now->state = INSTANTIATED;
    now->stale = 1;
    now->time = 0.0;
    instance->stop = INFINITY;
    run_clear(&instance->run);
}

/* Reserve `count` items at the end of a block, at a multiple of 16 bytes; return their place in it. */
static size_t reserve(size_t *end, size_t count, size_t size)
{
    size_t place = (*end + 15) / 16 * 16;
    *end = place + count * size;
    return place;
}

/* A new instance with a copy of its data in a single block of memory, or NULL. */
static Instance *allocate(const unsigned char *bytes, size_t size, const char *name)
{
    Data data = data_in(bytes);
    size_t end = sizeof(Instance), real = sizeof(double);
    size_t now = reserve(&end, 1, sizeof(Saved)), values = reserve(&end, (size_t)data.n_values, real);
    size_t state = reserve(&end, (size_t)data.n_state, real), outputs = reserve(&end, (size_t)data.n_outputs, real);
    size_t work = reserve(&end, (size_t)data.n_work, real), copy = reserve(&end, size, 1);
    size_t name_at = reserve(&end, strlen(name) + 1, 1), reported_at = reserve(&end, (size_t)data.n_warnings, 1);
    size_t read = reserve(&end, (size_t)data.n_values, sizeof(uint32_t));
    size_t written = reserve(&end, (size_t)data.n_values, sizeof(uint32_t));
    char *block = calloc(1, end);
    if (!block)
        return NULL;
    memcpy(block + copy, bytes, size);
    memcpy(block + name_at, name, strlen(name) + 1);
    Instance *instance = (Instance *)block;
    instance->now = (Saved *)(block + now);
    instance->saved_size = state + (size_t)data.n_state * real - now;
    instance->run = (Run){
        .data = data_in((const unsigned char *)block + copy),
        .values = (double *)(block + values),
        .state = (double *)(block + state),
        .outcome = &instance->now->outcome,
        .next_outputs = (double *)(block + outputs),
        .work = (double *)(block + work),
        .reported = (unsigned char *)(block + reported_at),
    };
    instance->name = block + name_at;
    instance->read.references = (uint32_t *)(block + read);
    instance->written.references = (uint32_t *)(block + written);
    return instance;
}

/* A new instance with the data at a resource location or, if there are none, beside the library; `elsewhere`
   (PATH_SIZE) then receives their path. NULL with a reason if there is no instance. */
static Instance *load(const char *name, const char *guid, const char *location, char *elsewhere, char *reason)
{
    char why[TEXT_SIZE];
    size_t size = 0;
    Instance *instance = NULL;
    unsigned char *bytes = resource_bytes(location, &size, reason);
    *elsewhere = '\0';
    if (!bytes && is_wrong_place(location) && resources_beside_library(elsewhere)) {
        bytes = resource_bytes(elsewhere, &size, why);
        location = elsewhere;
    }
    if (!bytes)
        return NULL;
    if (!data_is_valid(bytes, size, why))
        snprintf(reason, TEXT_SIZE, "resources/model.bin does not match this FMU: %.*s; rebuild the FMU", TEXT_SIZE / 2,
                 why);
    else if (!guid || strcmp(guid, data_in(bytes).guid) != 0)
        snprintf(reason, TEXT_SIZE, "the modelDescription.xml has guid %s, but resources/model.bin belongs to %s",
                 guid ? guid : "NULL", data_in(bytes).guid);
    else if (!(instance = allocate(bytes, size, name)))
        snprintf(reason, TEXT_SIZE, "there is no memory for another instance");
    free(bytes);
    if (!instance || run_open(&instance->run, instance->name, location, reason))
        return instance;
    free(instance);
    return NULL;
}

Instance *slave_new(const char *name, const char *guid, const char *location, const Host *host, int logging)
{
    char reason[TEXT_SIZE] = "an instance needs a name", elsewhere[PATH_SIZE];
    Instance *instance = name && *name ? load(name, guid, location, elsewhere, reason) : NULL;
    if (!instance) {
        slave_log_no_instance(host, name, reason);
        return NULL;
    }
    instance->host = *host;
    instance->enabled_categories = logging ? ~0u : 0;
    start_over(instance);
    if (*elsewhere)
        log_status(instance, STATUS_WARNING,
                   "there are no resources at %.1000s; those beside the library are used, %.1000s",
                   location ? location : "NULL", elsewhere);
    return instance;
}

void slave_free(Instance *instance)
{
    if (!instance)
        return;
    run_close(&instance->run);
    free_states(instance);
    free(instance);
}

/* Life cycle ----------------------------------------------------------------------------------------------------- */

Status slave_set_times(Instance *instance, const char *call, double start, int has_stop, double stop)
{
    if (!may(instance, INSTANTIATED, call))
        return STATUS_ERROR;
    if (!isfinite(start))
        return fail(instance, "start time = %g s is not allowed; it must be a finite number", start);
    if (has_stop && !(stop >= start))
        return fail(instance, "stop time = %g s is not allowed; it must be >= %g s, the start", stop, start);
    instance->now->time = start;
    instance->stop = has_stop ? stop : INFINITY;
    return STATUS_OK;
}

Status slave_enter_initialization(Instance *instance, const char *call)
{
    if (!may(instance, INSTANTIATED, call))
        return STATUS_ERROR;
    instance->now->state = INITIALIZATION;
    instance->now->stale = 1;
    return STATUS_OK;
}

Status slave_initialise_again(Instance *instance)
{
    instance->now->stale = 0;
    if (!run_initialise(&instance->run))
        return STATUS_OK;
    log_status(instance, STATUS_WARNING, "initialisation: %s", instance->now->outcome.reason);
    return STATUS_WARNING;
}

Status slave_exit_initialization(Instance *instance, const char *call)
{
    if (!may(instance, INITIALIZATION, call))
        return STATUS_ERROR;
    Saved *now = instance->now;
    if (now->stale)
        run_initialise(&instance->run);
    now->stale = 0;
    if (now->outcome.fault)
        return fail(instance, "initialisation: %s", now->outcome.reason);
    now->state = STEP_COMPLETE;
    warn(instance, 0);
    return STATUS_OK;
}

/* Whether a step ends after the end of the experiment, by more than what rounding adds up to in hosts that sum their
   steps; the standards have it refused. */
static int is_too_late(const Instance *instance, double time, double step_size)
{
    double rounding = 1e-9 * fmax(fmax(fabs(time), fabs(instance->stop)), step_size);
    return isfinite(step_size) && time + step_size - instance->stop > rounding;
}

Status slave_step(Instance *instance, const char *call, double time, double step_size)
{
    if (!may(instance, STEP_COMPLETE, call))
        return STATUS_ERROR;
    if (!isfinite(time))
        return fail(instance, "%s: time = %g s is not allowed; it must be a finite number", call, time);
    if (is_too_late(instance, time, step_size))
        return reject(instance, "at t = %.9g s: a step of %g s would end after the stop time of the experiment, %.9g s",
                      time, step_size, instance->stop);
    if (run_step(&instance->run, time, step_size))
        return fail(instance, "at t = %.9g s: %s", time, instance->now->outcome.reason);
    instance->now->time = time + step_size;
    warn(instance, 1);
    return STATUS_OK;
}

Status slave_terminate(Instance *instance, const char *call)
{
    if (!may(instance, STEP_COMPLETE, call))
        return STATUS_ERROR;
    instance->now->state = TERMINATED;
    return STATUS_OK;
}

Status slave_reset(Instance *instance, const char *call)
{
    if (!may(instance, ANY, call))
        return STATUS_ERROR;
    start_over(instance);
    return STATUS_OK;
}
