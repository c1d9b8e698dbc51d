/* An FMU of FMI 2.0 whose instance lives in memory of its host, got and released by the functions that it passes: a
 * memory of zeros, in which the output y, reference 0, is 42 once it has been initialised.
 */
#include <stddef.h>

typedef struct {
    void *log;
    void *(*allocate)(size_t count, size_t size);
    void (*release)(void *memory);
} Callbacks;
typedef struct {
    const Callbacks *calls;
    double y;
} Instance;

Instance *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const Callbacks *calls,
                          int visible, int logging)
{
    Instance *self = calls->allocate(1, sizeof *self);
    self->calls = calls;
    return self;
}
void fmi2FreeInstance(Instance *self) { self->calls->release(self); }
int fmi2ExitInitializationMode(Instance *self)
{
    self->y += 42.0;
    return 0;
}
int fmi2GetReal(Instance *self, const unsigned *references, size_t n, double *values)
{
    values[0] = self->y;
    return 0;
}
