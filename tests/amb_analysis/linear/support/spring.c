/* A mass on a stiffening spring, at rest under the force there is at first, as an FMU that gives directional
 * derivatives.
 *
 *     m x'' = f - d x' - k x - c x^3,  lag f' = u - f;  with lag = 0 f = u. The state f is not listed.
 */
#include <stdlib.h>

enum { U, X, V, V_DOT, LAG, Y, SIZE };
static const double m = 2.0, d = 5.0, k = 8e4, c = 3e11, step = 2e-6;
typedef struct {
    double value[SIZE], f;
} Spring;

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *where, const void *calls, int visible,
                      int logging)
{
    return calloc(1, sizeof(Spring));
}
int fmi2Reset(void *s)
{
    *(Spring *)s = (Spring){{0.0}};
    return 0;
}
int fmi2ExitInitializationMode(void *component)
{
    Spring *s = component;
    double *v = s->value, x = 0.0;
    for (int n = 0; n < 60; n++)
        x -= (k * x + c * x * x * x - v[U]) / (k + 3.0 * c * x * x);
    v[X] = v[Y] = x, v[V] = 0.0, s->f = v[U];
    return 0;
}
static double acceleration(double f, double x, double v) { return (f - d * v - k * x - c * x * x * x) / m; }
int fmi2DoStep(void *component, double time, double size, int no_way_back)
{
    Spring *s = component;
    double *v = s->value;
    int parts = (int)(size / step + 0.5);
    double h = size / parts;
    for (int n = 0; n < parts; n++) { /* Runge-Kutta of fourth order */
        s->f = v[LAG] > 0.0 ? s->f + h / v[LAG] * (v[U] - s->f) : v[U];
        double x = v[X], w = v[V], f = s->f;
        double a1 = acceleration(f, x, w), w2 = w + 0.5 * h * a1;
        double a2 = acceleration(f, x + 0.5 * h * w, w2), w3 = w + 0.5 * h * a2;
        double a3 = acceleration(f, x + 0.5 * h * w2, w3), w4 = w + h * a3;
        double a4 = acceleration(f, x + h * w3, w4);
        v[X] = x + h / 6.0 * (w + 2.0 * w2 + 2.0 * w3 + w4);
        v[V] = w + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    }
    v[Y] = v[X];
    return 0;
}
int fmi2GetDirectionalDerivative(void *component, const unsigned *unknown, size_t n, const unsigned *known,
                                 size_t n_known, const double *seed, double *found)
{
    const double *v = ((Spring *)component)->value;
    double stiffness = k + 3.0 * c * v[X] * v[X];
    if (v[LAG] < 0.0)
        return 3;
    for (size_t j = 0; j < n; j++) {
        found[j] = 0.0;
        for (size_t i = 0; i < n_known; i++) {
            double slope = 0.0;
            if (unknown[j] == V_DOT)
                slope = (known[i] == X ? -stiffness : known[i] == V ? -d : 1.0) / m;
            if (unknown[j] == V)
                slope = known[i] == V;
            if (unknown[j] == Y)
                slope = known[i] == X;
            found[j] += slope * seed[i];
        }
    }
    return 0;
}
