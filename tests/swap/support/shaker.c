/* A generator of a force f = amplitude sin(ratio phi) on a rotor that turns by phi, whose speed it reads. */
#include <math.h>
#include <stdlib.h>

enum { SPEED, AMPLITUDE, RATIO, F, SIZE };
typedef struct {
    double value[SIZE], phi;
} Shaker;

void *fmi2Instantiate(void) { return calloc(1, sizeof(Shaker)); }
int fmi2DoStep(Shaker *s, double time, double size, int no_way_back)
{
    s->phi += s->value[SPEED] * size;
    s->value[F] = s->value[AMPLITUDE] * sin(s->value[RATIO] * s->phi);
    return 0;
}
