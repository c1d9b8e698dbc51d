#include "loop.h"

typedef int SetState(void *instance, void *state);
typedef int GetState(void *instance, void **state);

/* An FMU whose state is `memory`, which it is given before each step, and whose state after it goes to `after`.
 * `stepped` is what `do_step` gets as instance. */
typedef struct {
  void *instance, *stepped;
  SetState *restore;
  DoStep *do_step;
  GetState *save;
  double *memory, *after;
  double time, step_size;
} Stepped;

/* The three calls that a step may fail in. */
enum { RESTORE, STEP, SAVE };

EXPORT int answer_changes(const Stepped *fmu, const intptr_t *changed, const double *changes, intptr_t n_changed,
                          const intptr_t *shown, intptr_t n_shown, double *answers, intptr_t *call);

/* Steps an FMU from its state with one number of it after the other changed from 0, and writes what of the state is shown
 * after each step to a row of `answers`. Returns the status of the first call that failed, or 0. */
int answer_changes(const Stepped *fmu, const intptr_t *changed, const double *changes, intptr_t n_changed,
                   const intptr_t *shown, intptr_t n_shown, double *answers, intptr_t *call) {
  for (intptr_t k = 0; k < n_changed; k++) {
    void *after = fmu->after;
    fmu->memory[changed[k]] = changes[k];
    *call = RESTORE;
    int status = fmu->restore(fmu->instance, fmu->memory);
    if (status >= 0 && status <= LOOP_WARNING)
      *call = STEP, status = fmu->do_step(fmu->stepped, fmu->time, fmu->step_size, 1);
    if (status >= 0 && status <= LOOP_WARNING) *call = SAVE, status = fmu->save(fmu->instance, &after);
    fmu->memory[changed[k]] = 0.0;
    if (status < 0 || status > LOOP_WARNING) return status;
    for (intptr_t i = 0; i < n_shown; i++) answers[k * n_shown + i] = fmu->after[shown[i]];
  }
  return 0;
}
