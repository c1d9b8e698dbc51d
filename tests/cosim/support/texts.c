/* An FMU of FMI 2.0 or 3.0 with a String, a Boolean, an Enumeration and, in FMI 3.0, a Binary: the output y has the
   length of the text, 100 for true, 1000 times the choice, and 10000 times the sum of the bytes. Its outputs
   `said` and `fault_code` are the text and the choice. */
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "../../support/fmi_names.h"

typedef struct {
    char text[100];
    int64_t choice;
    bool flag;
    double sum;
} Instance;

int FMI(Reset)(Instance *self)
{
    *self = (Instance){"none", 1, false, 0.0};
    return 0;
}
static void *create(void)
{
    Instance *self = calloc(1, sizeof *self);
    FMI(Reset)(self);
    return self;
}

#if FMI_VERSION == 3
typedef bool Boolean;
typedef int64_t Enumeration;
typedef int32_t Integer;
#define fmi3SetEnumeration fmi3SetInt64
#define fmi3GetInteger fmi3GetInt32
void *fmi3InstantiateCoSimulation(void) { return create(); }
int fmi3SetBinary(Instance *self, const uint32_t *references, size_t n, const size_t *sizes,
                  const uint8_t *const *values, size_t size)
{
    self->sum = 0.0;
    for (size_t k = 0; k < sizes[0]; k++)
        self->sum += values[0][k];
    return 0;
}
int fmi3DoStep(void *self, double time, double step, bool final, bool *event, bool *end, bool *early, double *reached)
{
    *event = *end = *early = false;
    *reached = time + step;
    return 0;
}
#else
typedef int Boolean, Enumeration, Integer;
#define fmi2SetEnumeration fmi2SetInteger
void *fmi2Instantiate(void) { return create(); }
#endif
int FMI(SetString)(Instance *self, const uint32_t *references, size_t n, const char *const *values N_VALUES)
{
    strncpy(self->text, values[0], sizeof self->text - 1);
    return 0;
}
int FMI(GetString)(Instance *self, const uint32_t *references, size_t n, const char **values N_VALUES)
{
    values[0] = self->text;
    return 0;
}
int FMI(SetBoolean)(Instance *self, const uint32_t *references, size_t n, const Boolean *values N_VALUES)
{
    self->flag = values[0];
    return 0;
}
int FMI(SetEnumeration)(Instance *self, const uint32_t *references, size_t n, const Enumeration *values N_VALUES)
{
    self->choice = values[0];
    return 0;
}
int FMI(GetInteger)(Instance *self, const uint32_t *references, size_t n, Integer *values N_VALUES)
{
    values[0] = (Integer)self->choice;
    return 0;
}
int FMI(GetFloat64)(Instance *self, const uint32_t *references, size_t n, double *values N_VALUES)
{
    values[0] =
        (double)strlen(self->text) + (self->flag ? 100.0 : 0.0) + 1000.0 * (double)self->choice + 10000.0 * self->sum;
    return 0;
}
