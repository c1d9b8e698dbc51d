/* Steps of an FMU from a saved state in which one number is changed at a time; `FmuComponent.answers` documents it. */

#include "loop.h"

typedef int SetState(void *instance, double *state);
typedef int GetState(void *instance, double **state);

EXPORT intptr_t answers(void *fmu, SetState *set, GetState *get, void *stepped, DoStep *do_step, double *state,
                        double **after, double time, double step_size, intptr_t n, const intptr_t *places,
                        const double *changes, intptr_t n_observed, const intptr_t *observed, double *rows);

static bool is_good(int status) { return status >= 0 && status <= LOOP_WARNING; }

/* Returns the number of rows: all, unless a call fails. `stepped` is the instance as `do_step` takes it. */
intptr_t answers(void *fmu, SetState *set, GetState *get, void *stepped, DoStep *do_step, double *state, double **after,
                 double time, double step_size, intptr_t n, const intptr_t *places, const double *changes,
                 intptr_t n_observed, const intptr_t *observed, double *rows)
{
    for (intptr_t k = 0; k < n; k++) {
        state[places[k]] = changes[k];
        bool done =
            is_good(set(fmu, state)) && is_good(do_step(stepped, time, step_size, 1)) && is_good(get(fmu, after));
        state[places[k]] = 0.0;
        if (!done)
            return k;
        for (intptr_t column = 0; column < n_observed; column++)
            *rows++ = (*after)[observed[column]];
    }
    return n;
}
