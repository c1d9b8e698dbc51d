/* A mass that falls freely: height h (exact start), speed v (local, exact start) and its energy e (calculated). */
#include <stdbool.h>
#include <stdlib.h>

#include "../../support/fmi_names.h"

typedef struct {
    double h, v, e, g;
} Instance;

static const double of_start[] = {1.0, 0.0};

static void *create(void)
{
    Instance *self = calloc(1, sizeof *self);
    self->h = of_start[0];
    self->v = of_start[1];
    self->g = 9.81;
    return self;
}
static int step(Instance *self, double dt)
{
    self->h += dt * (self->v - 0.5 * dt * self->g);
    self->v -= dt * self->g;
    self->e = self->g * self->h + 0.5 * self->v * self->v;
    return 0;
}
#if FMI_VERSION == 3
void *fmi3InstantiateCoSimulation(void) { return create(); }
int fmi3DoStep(Instance *self, double time, double dt, bool final, bool *event, bool *end, bool *early, double *reached)
{
    *event = *end = *early = false;
    *reached = time + dt;
    return step(self, dt);
}
#else
void *fmi2Instantiate(void) { return create(); }
int fmi2DoStep(Instance *self, double time, double dt) { return step(self, dt); }
#endif
int FMI(ExitInitializationMode)(Instance *self) { return step(self, 0.0); }
