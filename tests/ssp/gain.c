/* An FMU of FMI 2.0 whose output is k times its input. */
#include <stdlib.h>

enum { INPUT, OUTPUT, GAIN, SIZE };

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const void *callbacks,
                      int visible, int logging)
{
    double *self = calloc(SIZE, sizeof *self);
    self[INPUT] = 1.0;
    self[GAIN] = 1.0;
    return self;
}
void fmi2FreeInstance(void *self) { free(self); }
int fmi2SetDebugLogging(void) { return 0; }
int fmi2SetupExperiment(void) { return 0; }
int fmi2EnterInitializationMode(void) { return 0; }
int fmi2ExitInitializationMode(void) { return 0; }
int fmi2Terminate(void) { return 0; }
int fmi2Reset(double *self)
{
    self[INPUT] = self[GAIN] = 1.0;
    return 0;
}
int fmi2SetReal(double *self, const unsigned *references, size_t n, const double *values)
{
    for (size_t i = 0; i < n; i++)
        self[references[i]] = values[i];
    return 0;
}
int fmi2GetReal(double *self, const unsigned *references, size_t n, double *values)
{
    self[OUTPUT] = self[GAIN] * self[INPUT];
    for (size_t i = 0; i < n; i++)
        values[i] = self[references[i]];
    return 0;
}
int fmi2DoStep(void) { return 0; }

#define ABSENT(name)                                                                                                   \
    int fmi2##name(void) { return 3; }
ABSENT(SetInteger)
ABSENT(GetInteger)
ABSENT(SetBoolean)
ABSENT(GetBoolean)
ABSENT(SetString)
ABSENT(GetString)
ABSENT(GetFMUstate)
ABSENT(SetFMUstate)
ABSENT(FreeFMUstate)
ABSENT(SerializedFMUstateSize)
ABSENT(SerializeFMUstate)
ABSENT(DeSerializeFMUstate)
ABSENT(GetDirectionalDerivative)
ABSENT(SetRealInputDerivatives)
ABSENT(GetRealOutputDerivatives)
ABSENT(CancelStep)
ABSENT(GetStatus)
ABSENT(GetRealStatus)
ABSENT(GetIntegerStatus)
ABSENT(GetBooleanStatus)
ABSENT(GetStringStatus)
