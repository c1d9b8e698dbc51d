/* A running model: its arrays, checked and stepped. The C counterpart of `Instance` in fmi_export/model.py. */

#ifndef AMB_INSTANCE_H
#define AMB_INSTANCE_H

#include "data.h"

/* Faults that every model shares. */
enum { FAULT_INTERNAL = 998, FAULT_STEP_SIZE = 999, FAULT_RANGE = 1000, FAULT_NOT_FINITE = 100000 };

/* Returned by a kernel for a step without fault that leaves all outputs unchanged. */
enum { UNCHANGED = -1 };

/* The part of a saved state besides `values` and `state`. */
typedef struct {
    double step_size; /* of the present step, and of the last one after it; 0 before the first (s) */
    int64_t checked;  /* whether the parameters were checked since the last change */
    int64_t fault;
    char reason[TEXT_SIZE]; /* of the fault, or of the last refused call; empty after a successful step */
} Outcome;

typedef struct Run Run;

/* Functions that initialise or step the parts of an assembly, and write their outputs to `next_outputs`. A fault of a
   part stops the run. They return a fault of the assembly itself, or 0. */
typedef struct {
    int64_t (*initialise)(Run *run);
    int64_t (*step)(Run *run, double time, double step_size);
} Stepper;

/* `values` are parameters, inputs and outputs in the order of the value references. `work` is a cache that no call
   depends on. Kernels use vectors of two numbers, which are slower where they cross a cache line: `state`, `work` and
   the constants begin at multiples of 16 bytes. */
struct Run {
    Data data;
    struct Kernels *kernels;   /* data for calling kernels that are not functions in this library */
    const Stepper *stepper;    /* of an assembly; NULL for a model with kernels */
    struct Assembly *assembly; /* data for stepping the parts of an assembly */
    double *values, *state;
    Outcome *outcome;
    double *next_outputs, *work;
    unsigned char *reported; /* whether each warning was reported */
};

#pragma GCC visibility push(hidden)

/* Reset to start values, without a state. */
void run_clear(Run *run);

/* Compute the initial state and outputs from parameters and inputs; return 0 or the fault. */
int64_t run_initialise(Run *run);

/* Step under constant inputs; return 0 or the fault, which leaves the outputs at their last valid values. */
int64_t run_step(Run *run, double time, double step_size);

/* Whether a warning is true that was not reported since `run_clear`; write its name and sentence to `text`
   (TEXT_SIZE). */
int run_next_warning(Run *run, char *text);

/* Store a fault and its sentence until the next initialisation. */
int64_t run_stop(Run *run, int64_t fault, const char *reason);

#pragma GCC visibility pop

static inline int64_t first_output(const Data *data) { return data->n_parameters + data->n_inputs; }

#endif
