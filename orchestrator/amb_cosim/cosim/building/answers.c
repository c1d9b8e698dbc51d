/* Steps of an FMU from a saved state, some numbers of which are set before; `FmuComponent.answers` documents it. */

#include "loop.h"

typedef int SetState(void *instance, double *state);
typedef int GetState(void *instance, double **state);

EXPORT intptr_t answers(void *fmu, SetState *set, GetState *get, void *stepped, DoStep *do_step, double *state,
                        double **after, double time, double step_size, intptr_t n, intptr_t n_places,
                        const intptr_t *places, const double *values, intptr_t n_observed, const intptr_t *observed,
                        double *rows);

static bool is_good(int status) { return status >= 0 && status <= LOOP_WARNING; }

/* Returns the number of rows: all, unless a call fails. `stepped` is the instance as `do_step` takes it. */
intptr_t answers(void *fmu, SetState *set, GetState *get, void *stepped, DoStep *do_step, double *state, double **after,
                 double time, double step_size, intptr_t n, intptr_t n_places, const intptr_t *places,
                 const double *values, intptr_t n_observed, const intptr_t *observed, double *rows)
{
    for (intptr_t row = 0; row < n; row++) {
        for (intptr_t k = 0; k < n_places; k++)
            state[places[k]] = *values++;
        if (!is_good(set(fmu, state)) || !is_good(do_step(stepped, time, step_size, 1)) || !is_good(get(fmu, after)))
            return row;
        for (intptr_t k = 0; k < n_observed; k++)
            *rows++ = (*after)[observed[k]];
    }
    return n;
}
