/* A running model: its arrays, checked and stepped. The C counterpart of `Instance` in fmi_export/model.py. */

#ifndef AMB_INSTANCE_H
#define AMB_INSTANCE_H

#include "data.h"

/* Faults that every model shares. */
enum { FAULT_INTERNAL = 998, FAULT_STEP_SIZE = 999, FAULT_RANGE = 1000, FAULT_NOT_FINITE = 100000 };

/* What a kernel returns for a step that is no fault and leaves all outputs as they are. */
enum { UNCHANGED = -1 };

/* What there is to save besides `values` and `state`. */
typedef struct {
    double step_size; /* of the present step, and of the last one after it; 0 before the first (s) */
    int64_t checked;  /* whether the parameters are within their ranges, as far as is known */
    int64_t fault;
    char reason[TEXT_SIZE]; /* of the fault, or of the call that was refused last; empty after a step that was done */
} Outcome;

typedef struct Run Run;

/* What steps the parts of an assembly, in place of kernels. The answer is a fault of the assembly itself, or 0; what
   stops a part stops the run. */
typedef struct {
    int64_t (*initialise)(Run *run);
    int64_t (*step)(Run *run, double time, double step_size);
} Stepper;

/* `values` are parameters, inputs and outputs in the order of the value references. What kernels leave in `work` saves
   time, and no call needs it. Kernels use vectors of two numbers, which are slower where they cross a cache line:
   `state`, `work` and the constants begin at multiples of 16 bytes. */
struct Run {
    Data data;
    struct Kernels *kernels;   /* what calls them, if it is more than a function */
    const Stepper *stepper;    /* of an assembly alone */
    struct Assembly *assembly; /* the parts that it steps */
    double *values, *state;
    Outcome *outcome;
    double *next_outputs, *work;
    unsigned char *reported; /* which warnings */
};

#pragma GCC visibility push(hidden)

/* Start values, and no state. */
void run_clear(Run *run);

/* The initial state and outputs from parameters and inputs; 0, or the fault. */
int64_t run_initialise(Run *run);

/* A step under constant inputs; 0, or the fault. Outputs keep their last good values then. */
int64_t run_step(Run *run, double time, double step_size);

/* Whether a warning is true that was not reported since `run_clear`; its name and sentence go to `text` (TEXT_SIZE). */
int run_next_warning(Run *run, char *text);

/* Keep a fault and its sentence until the next initialisation. */
int64_t run_stop(Run *run, int64_t fault, const char *reason);

#pragma GCC visibility pop

static inline int64_t first_output(const Data *data) { return data->n_parameters + data->n_inputs; }

#endif
