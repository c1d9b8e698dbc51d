/* An instance of a model as a host of FMI runs it: states, checks, log, saved states. Nothing here knows a version of
   FMI; `fmi2.c` and `fmi3.c` bind it to them.

   Functions get the name of the FMI call for their messages. Every call that is refused answers STATUS_ERROR and
   logs the reason. A fault of a step and a wrong call put the instance into the error state, from which a reset and
   a state from before lead; `reject` and `unsupported` leave it as it was. A question without an answer is answered
   STATUS_DISCARD, after which FMI 3.0 lets a host go on. No step is: FMI 3.0 would promise the state from before it.
   No fault is an end that the model wants, which hosts take for success. */

#ifndef AMB_SLAVE_H
#define AMB_SLAVE_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

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

/* Refusals ------------------------------------------------------------------------------------------------------- */

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

/* Life cycle ----------------------------------------------------------------------------------------------------- */

/* A new instance with the data at a resource location; NULL on failure, and the logger has the reason. */
Instance *slave_new(const char *name, const char *guid, const char *location, const Host *host, int logging);
void slave_free(Instance *instance);
void slave_log_no_instance(const Host *host, const char *name, const char *reason);

/* The categories with these names, as bits of `enabled_categories`; all without names. */
Status slave_categories(Instance *instance, const char *call, const char *const names[], size_t count,
                        unsigned int *chosen);
Status slave_set_times(Instance *instance, const char *call, double start, int has_stop, double stop);
Status slave_enter_initialization(Instance *instance, const char *call);
Status slave_exit_initialization(Instance *instance, const char *call);
Status slave_step(Instance *instance, const char *call, double time, double step_size);
Status slave_terminate(Instance *instance, const char *call);
Status slave_reset(Instance *instance, const char *call);

/* Variables ------------------------------------------------------------------------------------------------------ */

/* Refuse a reference for which `is_variable` is false. */
Status wrong_reference(Instance *instance, const char *call, uint32_t reference);

/* Refuse to set a variable that exists. */
Status cannot_be_set(Instance *instance, const char *call, uint32_t reference);

/* Initialise again, so that outputs are right throughout initialization mode. A fault can still be put right, and is
   a warning. */
Status slave_initialise_again(Instance *instance);

/* The value of an Integer, unless it does not fit into one. */
Status slave_integer(Instance *instance, const char *call, uint32_t reference, int32_t *value);

/* Saved states --------------------------------------------------------------------------------------------------- */

/* They are recognised by their addresses: a pointer that is none of this instance's is not looked at. */
Status slave_save(Instance *instance, const char *call, void **state);
Status slave_restore(Instance *instance, const char *call, const void *state);
Status slave_forget(Instance *instance, const char *call, void **state);
Status slave_serialised_size(Instance *instance, const char *call, const void *state, size_t *size);
Status slave_serialise(Instance *instance, const char *call, const void *state, void *bytes, size_t size);
Status slave_deserialise(Instance *instance, const char *call, const void *bytes, size_t size, void **state);

/* Free what the host has not. */
void free_states(Instance *instance);

/* Derivatives ---------------------------------------------------------------------------------------------------- */

/* Of which outputs, by which inputs. */
typedef struct {
    const uint32_t *unknowns, *knowns;
    size_t n_unknowns, n_knowns;
} Derivatives;

/* J v and J' w of the derivatives J over a step; seed and results have a value for each input, or output. */
Status slave_directional(Instance *instance, const char *call, const Derivatives *of, const double *seed,
                         double *results);
Status slave_adjoint(Instance *instance, const char *call, const Derivatives *of, const double *seed, double *results);

#pragma GCC visibility pop

/* What every call and every value needs is inline. */

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

/* Before values are read: outputs up to date, if something was set in initialization mode since. */
static inline Status refresh(Instance *instance)
{
    int right = instance->now->state != INITIALIZATION || !instance->now->stale;
    return right ? STATUS_OK : slave_initialise_again(instance);
}

#endif
