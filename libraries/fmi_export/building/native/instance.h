/* A running model: its arrays, checked and stepped. The C counterpart of `Instance` in fmi_export/model.py. */

#ifndef AMB_INSTANCE_H
#define AMB_INSTANCE_H

#include "model.h"

enum { FIRST_INPUT = N_PARAMETERS, FIRST_OUTPUT = N_PARAMETERS + N_INPUTS, FAULT_CODE = N_VALUES - 1 };

/* Faults that every model shares. */
enum { FAULT_INTERNAL = 998, FAULT_STEP_SIZE = 999, FAULT_RANGE = 1000, FAULT_NOT_FINITE = 100000 };

/* Parameters, inputs and outputs in the order of the value references; state; and the fault with its sentence. This is
   all there is to save: what kernels leave in the scratch array saves time, and no call needs it. */
typedef struct {
    double values[N_VALUES];
    _Alignas(16) double state[N_STATE];
    int64_t checked; /* whether the parameters are within their ranges, as far as is known */
    int64_t fault;
    char reason[TEXT_SIZE];
} Run;

/* Kernels use vectors of two numbers, which are slower where they cross a cache line. */
typedef struct {
    double next_outputs[N_OUTPUTS];
    _Alignas(16) double work[N_WORK];
} Scratch;

#pragma GCC visibility push(hidden)

/* Start values, and no state. */
void run_clear(Run *run);

/* The initial state and outputs from parameters and inputs; 0, or the fault. */
int64_t run_initialise(Run *run, Scratch *scratch);

/* One step under constant inputs; 0, or the fault. Outputs keep their last good values then. */
int64_t run_step(Run *run, Scratch *scratch, double time, double step_size);

/* Keep a fault and its sentence until the next initialisation. */
int64_t run_stop(Run *run, int64_t fault, const char *reason);

#pragma GCC visibility pop

#endif
