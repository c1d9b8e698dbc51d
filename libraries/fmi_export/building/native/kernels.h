/* The two lowered kernels of a model. */

#ifndef AMB_KERNELS_H
#define AMB_KERNELS_H

#include <stdint.h>

#pragma GCC visibility push(hidden)

/* 0, or something else if the kernel raised an exception; then `fault` is not set. No array is kept, and of the
   constants none is written. */
int32_t kernel_initialise(int64_t *fault, void **exception, const double *constants, int64_t n_constants,
                          const double *parameters, int64_t n_parameters, const double *inputs, int64_t n_inputs,
                          double *state, int64_t n_state, double *work, int64_t n_work, double *outputs,
                          int64_t n_outputs);
int32_t kernel_step(int64_t *fault, void **exception, const double *constants, int64_t n_constants,
                    const double *parameters, int64_t n_parameters, const double *inputs, int64_t n_inputs,
                    double *state, int64_t n_state, double *work, int64_t n_work, double *outputs, int64_t n_outputs,
                    double time, double step_size);

#pragma GCC visibility pop

#endif
