/* An FMU of FMI 2.0, or with -DFMI_VERSION=3 of FMI 3.0, that ends the run at the time `end`, within a step.
 *
 * Reals by reference: 0 end, 1 kind, 2 the output y, which is the time reached. The output 3 is the String "runs", and
 * after the end "over". Kinds: 0 an end with its time; without in FMI 2.0: 1 no answer on the time, 2 the time 0, 3 a
 * step that is discarded without an end.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>

#include "../../support/fmi_names.h"

enum { END, KIND, Y, SAID, SIZE };
enum { OK, DISCARD = 2 };
enum { LAST_TIME = 2, TERMINATED = 3 };
typedef struct {
    double values[SIZE];
    const char *said;
} Instance;

static Instance *create(void)
{
    Instance *self = calloc(1, sizeof *self);
    self->values[END] = 1e9;
    self->said = "runs";
    return self;
}

/* Steps; returns whether the run ends. */
static bool step(Instance *self, double end)
{
    bool ends = end > self->values[END];
    self->values[Y] = ends ? self->values[END] : end;
    self->said = ends ? "over" : "runs";
    return ends;
}

static int get_text(const Instance *self, const char **values)
{
    values[0] = self->said;
    return OK;
}

#if FMI_VERSION == 3
Instance *fmi3InstantiateCoSimulation(void) { return create(); }
int fmi3GetString(const Instance *self, const unsigned *references, size_t n, const char **values, size_t size)
{
    return get_text(self, values);
}
int fmi3DoStep(Instance *self, double time, double size, bool no_way_back, bool *event, bool *end, bool *early,
               double *reached)
{
    *event = *early = false, *end = step(self, time + size), *reached = self->values[Y];
    return OK;
}
#else
Instance *fmi2Instantiate(void) { return create(); }
int fmi2GetString(const Instance *self, const unsigned *references, size_t n, const char **values)
{
    return get_text(self, values);
}
int fmi2DoStep(Instance *self, double time, double size, int no_way_back)
{
    return step(self, time + size) ? DISCARD : OK;
}
int fmi2GetBooleanStatus(Instance *self, int kind, int *value)
{
    *value = kind == TERMINATED && self->values[KIND] != 3.0;
    return OK;
}
int fmi2GetRealStatus(Instance *self, int kind, double *value)
{
    *value = self->values[KIND] == 2.0 ? 0.0 : self->values[Y];
    return kind == LAST_TIME && self->values[KIND] == 1.0 ? DISCARD : OK;
}
#endif
