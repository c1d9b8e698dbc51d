/* An instance of a model as a host of FMI sees it: its states, its log, and how calls are refused. This code is
   independent of the version of FMI; `fmi2.c` and `fmi3.c` bind it to each.

   Functions take the name of the FMI call for their messages. A refused call returns STATUS_ERROR and logs the reason.
   A fault of a step and a wrong call put the instance into the error state, which a reset or the restoration of an
   earlier state ends; `reject` and `unsupported` leave it unchanged. A query without an answer returns STATUS_DISCARD,
   after which FMI 3.0 lets a host continue. A step never does, because in FMI 3.0 that would promise the state before
   the step. No fault is reported as a termination by the model, which hosts take for success. */

#ifndef AMB_HOST_H
#define AMB_HOST_H

#include <stddef.h>
#include <stdint.h>

#include "instance.h"

/* With the numbers of fmi2Status and fmi3Status. */
typedef enum { STATUS_OK, STATUS_WARNING, STATUS_DISCARD, STATUS_ERROR } Status;

/* States of the standards that a slave without asynchronous steps and event mode can be in. */
enum { INSTANTIATED = 1, INITIALIZATION = 2, STEP_COMPLETE = 4, TERMINATED = 8, ERROR = 16, N_STATES = 5 };
enum { ANY = INSTANTIATED | INITIALIZATION | STEP_COMPLETE | TERMINATED | ERROR };

typedef struct Host Host;

/* Differences between the versions of FMI besides their functions. */
typedef struct {
    const char *states[N_STATES]; /* their names */
    void (*log)(const Host *host, const char *instance, Status status, const char *category, const char *text);
} FmiBinding;

struct Host {
    const FmiBinding *binding;
    void *environment;
    void (*logger)(void); /* of the type that the binding knows; may be NULL */
};

/* A saved state; the values and the state of the run follow. */
typedef struct {
    char guid[GUID_SIZE]; /* first, so that it identifies the state of another FMU */
    int32_t state;
    int32_t stale; /* whether a value was set in initialization mode since the outputs were computed */
    double time;   /* end of the last successful step (s) */
    Outcome outcome;
} Saved;

/* A checked list of references of Reals; hosts repeat their lists at every step. */
typedef struct {
    uint32_t *references; /* room for all variables */
    size_t count;
    int contiguous; /* each is the previous plus 1 */
} ReferenceList;

typedef struct {
    Saved *now;
    size_t saved_size;
    Run run;     /* its saved part is in `now` */
    double stop; /* end of the experiment (s), infinite where the host set none */
    Host host;
    unsigned int enabled_categories; /* a bit for each category that is logged; errors always are */
    const char *name;
    ReferenceList read, written; /* the last lists that were read and set; the latter only if they are inputs */
    void **states;               /* saved by this instance and not freed yet */
    size_t n_states, room_for_states;
} Instance;

#pragma GCC visibility push(hidden)

/* Errors are always logged: hosts do not log by default, and would stop or continue without a message. */
void log_status(const Instance *instance, Status status, const char *format, ...);

/* Log why there is no instance. */
void slave_log_no_instance(const Host *host, const char *name, const char *reason);

/* The categories with these names, as bits of `enabled_categories`; all without names. */
Status slave_categories(Instance *instance, const char *call, const char *const names[], size_t count,
                        unsigned int *chosen);

/* Fail a call that the present state does not allow; the message names the present state and the allowed ones. */
void fail_in_state(Instance *instance, int states, const char *call);

/* Fail a call and enter the error state; the first reason remains as the fault. */
Status fail(Instance *instance, const char *format, ...);

/* Refuse a call that changed nothing; the state of the instance is unchanged. */
Status reject(Instance *instance, const char *format, ...);

/* Return STATUS_DISCARD for a query without an answer; the state of the instance is unchanged. */
Status decline(Instance *instance, const char *format, ...);

/* Refuse an optional query of the standards; the state of the instance is unchanged. */
Status unsupported(const Instance *instance, Status status, const char *call, const char *why);

#pragma GCC visibility pop

/* Whether `call` is allowed now; otherwise it fails. */
static inline int may(Instance *instance, int states, const char *call)
{
    if (!instance)
        return 0;
    if (instance->now->state & states)
        return 1;
    fail_in_state(instance, states, call);
    return 0;
}

#endif
