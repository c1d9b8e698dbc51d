/* Derivatives of outputs by inputs over a step. */

#ifndef AMB_DERIVATIVE_H
#define AMB_DERIVATIVE_H

#include "host.h"

#pragma GCC visibility push(hidden)

/* The outputs that are differentiated, and the inputs with respect to which they are. */
typedef struct {
    const uint32_t *unknowns, *knowns;
    size_t n_unknowns, n_knowns;
} Derivatives;

/* J v and J' w of the derivatives J over a step; seed and results have a value for each input, or output. */
Status slave_directional(Instance *instance, const char *call, const Derivatives *of, const double *seed,
                         double *results);
Status slave_adjoint(Instance *instance, const char *call, const Derivatives *of, const double *seed, double *results);

#pragma GCC visibility pop

#endif
