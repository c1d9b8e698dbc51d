/* An FMU of FMI 2.0 or 3.0 with a String, a Boolean, an Enumeration and, in FMI 3.0, a Binary: the output y has the
   length of the text, 100 for true, 1000 times the choice, and 10000 times the sum of the bytes. Its outputs
   `said` and `fault_code` are the text and the choice. */
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    char text[100];
    int64_t choice;
    bool flag;
    double sum;
} Instance;

static const Instance START = {"none", 1, false, 0.0};

static double y_of(const Instance *self)
{
    return (double)strlen(self->text) + (self->flag ? 100.0 : 0.0) + 1000.0 * (double)self->choice +
           10000.0 * self->sum;
}

static int set_text(Instance *self, const char *text)
{
    strncpy(self->text, text, sizeof self->text - 1);
    return 0;
}

static int reset(Instance *self)
{
    *self = START;
    return 0;
}

static void *create(void)
{
    Instance *self = calloc(1, sizeof *self);
    reset(self);
    return self;
}

#if FMI_VERSION == 3
void *fmi3InstantiateCoSimulation(void) { return create(); }
int fmi3Reset(Instance *self) { return reset(self); }
int fmi3SetString(Instance *self, const uint32_t *references, size_t n, const char *const *values, size_t size)
{
    return set_text(self, values[0]);
}
int fmi3GetString(Instance *self, const uint32_t *references, size_t n, const char **values, size_t size)
{
    values[0] = self->text;
    return 0;
}
int fmi3SetBinary(Instance *self, const uint32_t *references, size_t n, const size_t *sizes,
                  const uint8_t *const *values, size_t size)
{
    self->sum = 0.0;
    for (size_t k = 0; k < sizes[0]; k++)
        self->sum += values[0][k];
    return 0;
}
int fmi3SetBoolean(Instance *self, const uint32_t *references, size_t n, const bool *values, size_t size)
{
    self->flag = values[0];
    return 0;
}
int fmi3SetInt64(Instance *self, const uint32_t *references, size_t n, const int64_t *values, size_t size)
{
    self->choice = values[0];
    return 0;
}
int fmi3GetFloat64(Instance *self, const uint32_t *references, size_t n, double *values, size_t size)
{
    values[0] = y_of(self);
    return 0;
}
int fmi3GetInt32(Instance *self, const uint32_t *references, size_t n, int32_t *values, size_t size)
{
    values[0] = (int32_t)self->choice;
    return 0;
}
int fmi3DoStep(void *self, double time, double step, bool final, bool *event, bool *end, bool *early, double *reached)
{
    *event = *end = *early = false;
    *reached = time + step;
    return 0;
}
#else
void *fmi2Instantiate(void) { return create(); }
int fmi2Reset(Instance *self) { return reset(self); }
int fmi2SetString(Instance *self, const unsigned *references, size_t n, const char *const *values)
{
    return set_text(self, values[0]);
}
int fmi2GetString(Instance *self, const unsigned *references, size_t n, const char **values)
{
    values[0] = self->text;
    return 0;
}
int fmi2SetBoolean(Instance *self, const unsigned *references, size_t n, const int *values)
{
    self->flag = values[0];
    return 0;
}
int fmi2SetInteger(Instance *self, const unsigned *references, size_t n, const int *values)
{
    self->choice = values[0];
    return 0;
}
int fmi2GetReal(Instance *self, const unsigned *references, size_t n, double *values)
{
    values[0] = y_of(self);
    return 0;
}
int fmi2GetInteger(Instance *self, const unsigned *references, size_t n, int *values)
{
    values[0] = (int)self->choice;
    return 0;
}
#endif
