/* Runs a source-code FMU of FMI 2.0 that is linked into the same program, and prints an output at every step:

       static_host GUID RESOURCES INPUT OUTPUT STEPS

   where input and output are value references. The input is u(n) = (37 n mod 100) / 25 - 2. */

#include "names.h"

#include "logger.h"

#include <stdlib.h>

int main(int count, char **given)
{
    const fmi2CallbackFunctions functions = {logger, calloc, free, NULL, NULL};
    if (count != 6)
        return 2;
    const fmi2ValueReference input = (fmi2ValueReference)atoi(given[3]), output = (fmi2ValueReference)atoi(given[4]);
    fmi2Component fmu = fmi2Instantiate("one", fmi2CoSimulation, given[1], given[2], &functions, fmi2False, fmi2True);
    if (!fmu || fmi2SetupExperiment(fmu, fmi2False, 0.0, 0.0, fmi2False, 0.0) > fmi2Warning ||
        fmi2EnterInitializationMode(fmu) > fmi2Warning || fmi2ExitInitializationMode(fmu) > fmi2Warning)
        return 1;
    for (int n = 0; n < atoi(given[5]); n++) {
        const fmi2Real u = (37 * n % 100) / 25.0 - 2.0;
        fmi2Real y;
        if (fmi2SetReal(fmu, &input, 1, &u) > fmi2Warning ||
            fmi2DoStep(fmu, n * 250e-6, 250e-6, fmi2True) > fmi2Warning ||
            fmi2GetReal(fmu, &output, 1, &y) > fmi2Warning)
            return 1;
        printf("%a\n", y);
    }
    fmi2FreeInstance(fmu);
    return 0;
}
