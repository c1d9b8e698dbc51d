/* The interface of slave.c to a model: tables that the build writes into model.c, and the two lowered kernels. */

#ifndef AMB_MODEL_H
#define AMB_MODEL_H

#include <stdint.h>

#include "sizes.h" /* N_PARAMETERS, N_INPUTS, N_OUTPUTS, N_VALUES, N_STATE, N_WORK, N_CONSTANTS, N_FAULTS, TEXT_SIZE */

#pragma GCC visibility push(hidden)

typedef enum { REAL, INTEGER, BOOLEAN, STRING } Type;

typedef struct {
    const char *name;
    Type type;
    int tunable;
    const char *kind;    /* "fixed parameter" */
    const char *allowed; /* what follows name and value in the sentence for a value outside the range */
} Variable;

/* Text, followed by the value of a variable unless `variable` is -1. A sentence ends with a text of NULL. */
typedef struct {
    const char *text;
    int variable;
} Piece;

typedef struct {
    int64_t code;
    const Piece *sentence;
} FaultSentence;

extern const char model_guid[];
extern const Variable variables[N_VALUES];
extern const unsigned char types[N_VALUES]; /* as in `variables`, but close together */
extern const double start_values[N_VALUES], minima[N_VALUES], maxima[N_VALUES];
extern const double model_constants[N_CONSTANTS];
extern const FaultSentence fault_sentences[N_FAULTS + 1];

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
