/* An FMU of FMI 2.0, or with -DFMI_VERSION=3 of FMI 3.0, that shows what its host tells it, and integrates k u.
 *
 * Reals by reference: 0 u, 1 k, 2 y0, 3 y (y0 only as initialisation mode ends), 4 time of the last step's end, 5 the
 * start time, 6 the stop time or -1 without one, 7 the size of the last step, 8 the number of instances in the process,
 * 9 the last input that a step began with, 10 the tolerance or -1 without one.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "fmi_names.h"

enum { U, K, Y0, Y, TIME, START, STOP, STEP, INSTANCES, USED, TOLERANCE, SIZE };
typedef struct {
    double values[SIZE];
} Instance;

static int instances;

static Instance *made(void)
{
    Instance *self = calloc(1, sizeof *self);
    self->values[INSTANCES] = ++instances;
    self->values[K] = 1.0;
    return self;
}

static int told(Instance *self, int has_tolerance, double tolerance, double start, int has_stop, double stop)
{
    self->values[TOLERANCE] = has_tolerance ? tolerance : -1.0;
    self->values[TIME] = self->values[START] = start;
    self->values[STOP] = has_stop ? stop : -1.0;
    return 0;
}

static int step(Instance *self, double time, double size)
{
    double *v = self->values;
    v[USED] = v[U];
    v[Y] += v[K] * v[U] * size;
    v[TIME] = time + size;
    v[STEP] = size;
    return v[STOP] >= v[START] && v[TIME] > v[STOP] + 1e-9 ? 3 : 0;
}

#if FMI_VERSION == 3
Instance *fmi3InstantiateCoSimulation(void) { return made(); }
int fmi3EnterInitializationMode(Instance *self, bool has_tolerance, double tolerance, double start, bool has_stop,
                                double stop)
{
    return told(self, has_tolerance, tolerance, start, has_stop, stop);
}
int fmi3DoStep(Instance *self, double time, double size, bool no_way_back, bool *event, bool *end, bool *early,
               double *reached)
{
    *event = *end = *early = false, *reached = time + size;
    return step(self, time, size);
}
#else
Instance *fmi2Instantiate(void) { return made(); }
int fmi2SetupExperiment(Instance *self, int has_tolerance, double tolerance, double start, int has_stop, double stop)
{
    return told(self, has_tolerance, tolerance, start, has_stop, stop);
}
int fmi2DoStep(Instance *self, double time, double size, int no_way_back) { return step(self, time, size); }
#endif
int FMI(ExitInitializationMode)(Instance *self)
{
    self->values[Y] = self->values[Y0];
    return 0;
}
void FMI(FreeInstance)(Instance *self) { free(self), instances--; }
int FMI(GetFMUState)(Instance *self, Instance **state)
{
    if (!*state)
        *state = malloc(sizeof **state);
    **state = *self;
    return 0;
}
int FMI(SetFMUState)(Instance *self, const Instance *state)
{
    *self = *state;
    return 0;
}
int FMI(FreeFMUState)(Instance *self, Instance **state)
{
    free(*state);
    *state = NULL;
    return 0;
}
int FMI(SerializedFMUStateSize)(Instance *self, const Instance *state, size_t *size)
{
    *size = sizeof *state;
    return 0;
}
int FMI(SerializeFMUState)(Instance *self, const Instance *state, char *bytes, size_t size)
{
    memcpy(bytes, state, size);
    return 0;
}
int FMI(DeserializeFMUState)(Instance *self, const char *bytes, size_t size, Instance **state)
{
    *state = malloc(size);
    memcpy(*state, bytes, size);
    return 0;
}
