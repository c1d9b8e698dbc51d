/* FMUs of FMI 3.0 as the loop calls those of FMI 2.0; `binding3.py` has the same structures.
 *
 * Where fmi2SetReal and fmi2DoStep get an instance, these functions get an `Instance`; in place of value references
 * they get the address of a `Group`. All values are doubles for the loop. /
 */

#include <math.h>
#include <string.h>

#include "loop.h"

enum { NOTHING, ENDS, EARLY, UNFIT };
enum { DISCARD = 2 };

typedef int ExchangeArrays(void *instance, const uint32_t *references, size_t n_references, void *values,
                           size_t n_values);
typedef int DoStep3(void *instance, double time, double step_size, bool no_way_back, bool *event, bool *ends,
                    bool *early, double *reached);

typedef struct {
    void *instance;
    DoStep3 *do_step;
    intptr_t why;
    double number; /* time that a step reached (s), or what does not fit */
} Instance;

typedef struct {
    ExchangeArrays *call;
    const uint32_t *references;
    size_t n_references;
    void *image;
    size_t n_values;
    const intptr_t *at;
    intptr_t kind;
} Group;

EXPORT int step_fmi3(Instance *fmu, double time, double step_size, int no_way_back);
EXPORT int send_fmi3(Instance *fmu, const uint32_t *place, size_t n, const double *values);
EXPORT int fetch_fmi3(Instance *fmu, const uint32_t *place, size_t n, double *values);

int step_fmi3(Instance *fmu, double time, double step_size, int no_way_back)
{
    bool event = false, ends = false, early = false;
    double reached = time;
    int status = fmu->do_step(fmu->instance, time, step_size, no_way_back != 0, &event, &ends, &early, &reached);
    fmu->why = NOTHING;
    fmu->number = reached;
    if (status < 0 || status > LOOP_WARNING || !(ends || early))
        return status;
    fmu->why = ends ? ENDS : EARLY;
    return DISCARD;
}

/* For each integer type: its type, smallest value, and what all its values are below. */
#define INTEGERS(M)                                                                                                    \
    M(2, int8_t, -128.0, 128.0)                                                                                        \
    M(3, uint8_t, 0.0, 256.0)                                                                                          \
    M(4, int16_t, -32768.0, 32768.0)                                                                                   \
    M(5, uint16_t, 0.0, 65536.0)                                                                                       \
    M(6, int32_t, -2147483648.0, 2147483648.0)                                                                         \
    M(7, uint32_t, 0.0, 4294967296.0)                                                                                  \
    M(8, int64_t, -9223372036854775808.0, 9223372036854775808.0)                                                       \
    M(9, uint64_t, 0.0, 18446744073709551616.0)

/* Puts a value at position k of an image; returns whether the type can hold it. */
static bool store(const Group *group, intptr_t k, double value)
{
    switch (group->kind) {
#define STORE(kind, type, low, high)                                                                                   \
    case kind:                                                                                                         \
        if (!(value >= low && value < high))                                                                           \
            return false;                                                                                              \
        ((type *)group->image)[k] = (type)value;                                                                       \
        return true;
        INTEGERS(STORE)
    case 0:
        ((double *)group->image)[k] = value;
        return true;
    case 1:
        ((float *)group->image)[k] = (float)value;
        return true;
    default:
        ((bool *)group->image)[k] = value != 0.0;
        return true;
    }
}

static double load(const Group *group, intptr_t k)
{
    switch (group->kind) {
#define LOAD(kind, type, low, high)                                                                                    \
    case kind:                                                                                                         \
        return (double)((const type *)group->image)[k];
        INTEGERS(LOAD)
    case 0:
        return ((const double *)group->image)[k];
    case 1:
        return ((const float *)group->image)[k];
    default:
        return ((const bool *)group->image)[k];
    }
}

static const Group *group_at(const uint32_t *place)
{
    const Group *group;
    memcpy(&group, place, sizeof group);
    return group;
}

static int exchange(Instance *fmu, const Group *group)
{
    fmu->why = NOTHING;
    return group->call(fmu->instance, group->references, group->n_references, group->image, group->n_values);
}

int send_fmi3(Instance *fmu, const uint32_t *place, size_t n, const double *values)
{
    const Group *group = group_at(place);
    for (size_t k = 0; k < n; k++)
        if (!store(group, group->at[k], values[k])) {
            fmu->why = UNFIT, fmu->number = values[k];
            return LOOP_ERROR;
        }
    return exchange(fmu, group);
}

int fetch_fmi3(Instance *fmu, const uint32_t *place, size_t n, double *values)
{
    const Group *group = group_at(place);
    int status = exchange(fmu, group);
    for (size_t k = 0; k < n; k++)
        values[k] = load(group, group->at[k]);
    return status;
}
