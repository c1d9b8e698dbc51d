/* A van der Pol oscillator, x'' = w (eps (1 - x^2) x' - w x + w u), whose limit cycle has the amplitude 2. */
#include <stdlib.h>

enum { U, START, EPS, Y, SIZE };
static const double w = 400.0, step = 2e-6;
typedef struct {
    double value[SIZE], x, v;
} Oscillator;

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *where, const void *calls, int visible,
                      int logging)
{
    return calloc(1, sizeof(Oscillator));
}
int fmi2Reset(void *component)
{
    *(Oscillator *)component = (Oscillator){{0.0}};
    return 0;
}
int fmi2ExitInitializationMode(void *component)
{
    Oscillator *s = component;
    s->x = s->value[Y] = s->value[START];
    return 0;
}
int fmi2DoStep(void *component, double time, double size, int no_way_back)
{
    Oscillator *s = component;
    double *q = s->value;
    int parts = (int)(size / step + 0.5);
    double h = size / parts;
    for (int n = 0; n < parts; n++) { /* symplectic Euler */
        s->v += h * w * (q[EPS] * (1.0 - s->x * s->x) * s->v - w * s->x + w * q[U]);
        s->x += h * s->v;
    }
    q[Y] = s->x;
    return 0;
}
