/* The kernels of models as machine code, which lowering.py makes. */

#include "kernels.h"

#include <stddef.h>
#include <stdio.h>

#include "engine_key.h" /* MODELS */
#include "instance.h"

/* Return 0, or something else if the kernel raised an exception; then `fault` is not set. Of the constants none is
   written. */
typedef int32_t Initialise(int64_t *fault, void **exception, const double *constants, int64_t n_constants,
                           const double *parameters, int64_t n_parameters, const double *inputs, int64_t n_inputs,
                           double *state, int64_t n_state, double *work, int64_t n_work, double *outputs,
                           int64_t n_outputs);
typedef int32_t Step(int64_t *fault, void **exception, const double *constants, int64_t n_constants,
                     const double *parameters, int64_t n_parameters, const double *inputs, int64_t n_inputs,
                     double *state, int64_t n_state, double *work, int64_t n_work, double *outputs, int64_t n_outputs,
                     double time, double step_size);

#define DECLARED(model)                                                                                                \
    Initialise model##_initialise;                                                                                     \
    Step model##_step;
#define ENTRY(model) {model##_initialise, model##_step},

#pragma GCC visibility push(hidden)
MODELS(DECLARED)
#pragma GCC visibility pop

static const struct {
    Initialise *initialise;
    Step *step;
} MODEL[] = {MODELS(ENTRY)};

static const char *failure(int32_t raised) { return raised ? "the model's code failed with an exception" : NULL; }

int open_kernels(Run *run, const char *name, const char *location, char *reason)
{
    (void)name, (void)location;
    if (run->data.kernels < sizeof MODEL / sizeof *MODEL)
        return 1;
    snprintf(reason, TEXT_SIZE, "resources/model.bin is damaged: the engine has no such kernels");
    return 0;
}

void close_kernels(Run *run) { (void)run; }

const char *call_initialise(Run *run, int64_t *fault)
{
    const Data *data = &run->data;
    void *exception = NULL;
    Initialise *initialise = MODEL[data->kernels].initialise;
    return failure(initialise(fault, &exception, data->constants, data->n_constants, run->values, data->n_parameters,
                              run->values + data->n_parameters, data->n_inputs, run->state, data->n_state, run->work,
                              data->n_work, run->next_outputs, data->n_outputs));
}

const char *call_step(Run *run, double time, double step_size, int64_t *fault)
{
    const Data *data = &run->data;
    void *exception = NULL;
    Step *step = MODEL[data->kernels].step;
    return failure(step(fault, &exception, data->constants, data->n_constants, run->values, data->n_parameters,
                        run->values + data->n_parameters, data->n_inputs, run->state, data->n_state, run->work,
                        data->n_work, run->next_outputs, data->n_outputs, time, step_size));
}
