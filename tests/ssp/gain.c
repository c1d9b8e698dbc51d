/* An FMU of FMI 2.0 whose output is k times its input. */
#include <stdlib.h>

enum { INPUT, OUTPUT, GAIN, SIZE };

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const void *callbacks,
                      int visible, int logging)
{
    double *self = calloc(SIZE, sizeof *self);
    self[INPUT] = 1.0;
    self[GAIN] = 1.0;
    return self;
}
int fmi2Reset(double *self)
{
    self[INPUT] = self[GAIN] = 1.0;
    return 0;
}
int fmi2GetReal(double *self, const unsigned *references, size_t n, double *values)
{
    self[OUTPUT] = self[GAIN] * self[INPUT];
    for (size_t i = 0; i < n; i++)
        values[i] = self[references[i]];
    return 0;
}
