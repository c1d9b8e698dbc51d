/* A controller of four axes in C, without states that can be saved.
 *
 * Each axis: i = -(k_p x + k_d (x - x_before) / h) / k_i, sampled once in a step.
 */
#include <stddef.h>
#include <stdlib.h>

enum { AXES = 4, FIRST_INPUT = 0, FIRST_OUTPUT = 4, K_P = 8, K_D = 9, K_I = 10, VARIABLES = 11 };

typedef struct {
    double value[VARIABLES];
    double before[AXES];
    int sampled;
} Controller;

void *fmi2Instantiate(void)
{
    Controller *c = calloc(1, sizeof *c);
    c->value[K_P] = 3e6;
    c->value[K_D] = 5000.0;
    c->value[K_I] = 563.0;
    return c;
}
int fmi2Reset(Controller *c)
{
    c->sampled = 0;
    return 0;
}
int fmi2DoStep(Controller *c, double t, double h, int no_set_before)
{
    for (int k = 0; k < AXES; k++) {
        double x = c->value[FIRST_INPUT + k];
        double velocity = c->sampled ? (x - c->before[k]) / h : 0.0;
        c->value[FIRST_OUTPUT + k] = -(c->value[K_P] * x + c->value[K_D] * velocity) / c->value[K_I];
        c->before[k] = x;
    }
    c->sampled = 1;
    return 0;
}
