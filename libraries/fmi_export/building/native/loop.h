/* The loop of the master, in a separate library for the orchestrator (`amb_cosim/cosim/master/compiled.py`, which
 * documents the data), and in every engine for assemblies.
 *
 * It does what the loop in `amb_cosim/cosim/master/master.py` does, operation by operation. Structures are the
 * NamedTuples of the same name; `size` is the length of their first array. Products and sums are rounded separately
 * (-ffp-contract=off), as in Python.
 */

#ifndef AMB_LOOP_H
#define AMB_LOOP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The highest status of a call that succeeded, and the status of a call that failed. */
enum { LOOP_WARNING = 1, LOOP_ERROR = 3 };

typedef int Exchange(void *instance, const uint32_t *references, size_t size, void *values);
typedef int DoStep(void *instance, double time, double step_size, int no_way_back);

typedef struct {
    const intptr_t *of;
    Exchange *const *function;
    const uint32_t *const *references_at;
    void *const *values_at;
    const bool *real, *direct;
    const intptr_t *first, *positions;
    const uint32_t *references;
    double *reals;
    int32_t *integers;
    intptr_t size;
} Calls;

typedef struct {
    void *const *instance;
    DoStep *const *do_step;
    const intptr_t *every;
    const double *step_sizes;
    Calls sends, fetches, needed;
    double *values;
    double start_time, step_size;
    bool jacobi;
    intptr_t size;
} Program;

typedef struct {
    const intptr_t *points, *positions;
    const double *values;
    intptr_t size;
} Changes;

typedef struct {
    const intptr_t *positions;
    intptr_t first, every;
    intptr_t *points;
    double *table;
    const intptr_t *steps_positions; /* recorded at every point, in rows from `steps_first` on */
    intptr_t steps_size, steps_first;
    double *steps_table;
    intptr_t size;
} RecordBuffer;

typedef struct {
    const intptr_t *positions;
    const double *signs, *limits;
    intptr_t *since;
    const intptr_t *hold;
    intptr_t size;
} Conditions;

typedef struct {
    intptr_t reached, row, component, call, status, met;
} End;

#ifdef __has_include
#if __has_include("loop_library.h") /* present where the loop is a separate library */
#define IS_LIBRARY
#endif
#endif
#if defined IS_LIBRARY && defined _WIN32
#define EXPORT __declspec(dllexport)
#elif defined IS_LIBRARY
#define EXPORT __attribute__((visibility("default")))
#elif defined __GNUC__
#define EXPORT __attribute__((visibility("hidden")))
#else
#define EXPORT
#endif

/* Processes the points from `begin` to `stop`, the latter excluded, and steps from each but the last of the run.
 * `end` receives the last point reached, the number of rows, component, call and status of a failure, and the condition
 * that is met or -1. When another thread sets `pause`, no further step is made.
 */
EXPORT void advance(const Program *p, const Changes *changes, const RecordBuffer *buffer, const Conditions *conditions,
                    intptr_t row, intptr_t begin, intptr_t stop, intptr_t last, const volatile bool *pause, End *end);

#endif
