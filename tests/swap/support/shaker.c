/* A generator of a force f = amplitude sin(psi), psi' = (ratio + sweep t) times the speed of the rotor, which it reads. */
#include <math.h>
#include <stdlib.h>

enum { SPEED, AMPLITUDE, RATIO, SWEEP, F, SIZE };
typedef struct {
    double value[SIZE], psi, t;
} Shaker;

void *fmi2Instantiate(void) { return calloc(1, sizeof(Shaker)); }
int fmi2DoStep(Shaker *s, double time, double size, int no_way_back)
{
    const double *q = s->value;
    s->psi += (q[RATIO] + q[SWEEP] * s->t) * q[SPEED] * size;
    s->t += size;
    s->value[F] = q[AMPLITUDE] * sin(s->psi);
    return 0;
}
