/* An instance of a model as a host of FMI sees it: its states, its log, and how calls are refused. Nothing here knows
   a version of FMI; `fmi2.c` and `fmi3.c` bind it to them.

   Functions get the name of the FMI call for their messages. Every call that is refused answers STATUS_ERROR and
   logs the reason. A fault of a step and a wrong call put the instance into the error state, from which a reset and
   a state from before lead; `reject` and `unsupported` leave it as it was. A question without an answer is answered
   STATUS_DISCARD, after which FMI 3.0 lets a host go on. No step is: FMI 3.0 would promise the state from before it.
   No fault is an end that the model wants, which hosts take for success. */

#ifndef AMB_HOST_H
#define AMB_HOST_H

#include <stddef.h>
#include <stdint.h>

#include "instance.h"

/* In numbers as fmi2Status and fmi3Status. */
typedef enum { STATUS_OK, STATUS_WARNING, STATUS_DISCARD, STATUS_ERROR } Status;

/* States of the standards that a slave without asynchronous steps and event mode can be in. */
enum { INSTANTIATED = 1, INITIALIZATION = 2, STEP_COMPLETE = 4, TERMINATED = 8, ERROR = 16, N_STATES = 5 };
enum { ANY = INSTANTIATED | INITIALIZATION | STEP_COMPLETE | TERMINATED | ERROR };

typedef struct Host Host;

/* What the versions of FMI differ in beyond their functions. */
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
    char guid[GUID_SIZE]; /* first, so that the state of another FMU is recognised by it */
    int32_t state;
    int32_t stale; /* something was set in initialization mode that the outputs do not show yet */
    double time;   /* end of the last successful step (s) */
    Outcome outcome;
} Saved;

/* A list of references of Reals that was checked; hosts repeat theirs at every step. */
typedef struct {
    uint32_t *references; /* room for all variables */
    size_t count;
    int contiguous; /* each is the previous plus 1 */
} ReferenceList;

typedef struct {
    Saved *now;
    size_t saved_size;
    Run run;     /* of which `now` holds what is saved */
    double stop; /* end of the experiment (s), infinite where the host set none */
    Host host;
    unsigned int enabled_categories; /* a bit for each category that is logged; errors always are */
    const char *name;
    ReferenceList read, written; /* the latest lists that were read, and set; of the latter only those of inputs */
    void **states;               /* saved by this instance and not freed yet */
    size_t n_states, room_for_states;
} Instance;

#pragma GCC visibility push(hidden)

/* Errors are always logged: hosts do not log by default, and would stop, or go on, without a word. */
void log_status(const Instance *instance, Status status, const char *format, ...);

/* Log why there is no instance. */
void slave_log_no_instance(const Host *host, const char *name, const char *reason);

/* The categories with these names, as bits of `enabled_categories`; all without names. */
Status slave_categories(Instance *instance, const char *call, const char *const names[], size_t count,
                        unsigned int *chosen);

/* Refuse a call that the present state does not allow, with what state the instance is in and which would do. */
void fail_in_state(Instance *instance, int states, const char *call);

/* Refuse a call for good: the first reason stays as the fault. */
Status fail(Instance *instance, const char *format, ...);

/* Refuse a call that changed nothing, and live on. */
Status reject(Instance *instance, const char *format, ...);

/* Leave a question without an answer, and live on. */
Status decline(Instance *instance, const char *format, ...);

/* A question that the standards leave optional: refused, and the instance lives on. */
Status unsupported(const Instance *instance, Status status, const char *call, const char *why);

#pragma GCC visibility pop

/* Whether `call` may come now; if not it is refused. */
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
