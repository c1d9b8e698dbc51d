/* Functions of FMI that the FMUs of the tests need not define: those of an FMU's own file take the place of these. */
#include <stdlib.h>

#include "fmi_names.h"

#define WEAK __attribute__((weak))
enum { OK = 0, ERROR = 3 };

WEAK const char *FMI(GetVersion)(void) { return FMI_VERSION == 3 ? "3.0" : "2.0"; }
WEAK void FMI(FreeInstance)(void *self) { free(self); }
#if FMI_VERSION != 3
WEAK const char *fmi2GetTypesPlatform(void) { return "default"; }
#endif

/* An instance begins with its Reals, in the order of their references. */
WEAK int FMI(SetFloat64)(double *self, const unsigned *references, size_t n, const double *values N_VALUES)
{
    for (size_t k = 0; k < n; k++)
        self[references[k]] = values[k];
    return OK;
}
WEAK int FMI(GetFloat64)(const double *self, const unsigned *references, size_t n, double *values N_VALUES)
{
    for (size_t k = 0; k < n; k++)
        values[k] = self[references[k]];
    return OK;
}

#define CALL(name)                                                                                                     \
    WEAK int FMI(name)(void) { return OK; }
CALL(SetupExperiment)
CALL(EnterInitializationMode)
CALL(ExitInitializationMode)
CALL(Terminate)
CALL(Reset)
CALL(SetDebugLogging)
CALL(DoStep)
#undef CALL
#define CALL(name)                                                                                                     \
    WEAK int FMI(name)(void) { return ERROR; }
CALL(GetFMUState)
CALL(SetFMUState)
CALL(FreeFMUState)
CALL(SerializedFMUStateSize)
CALL(SerializeFMUState)
CALL(DeserializeFMUState)
CALL(GetRealStatus)
#include "other_functions.h"
