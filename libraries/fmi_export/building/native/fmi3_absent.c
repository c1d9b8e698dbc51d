/* Features of FMI 3.0 that these FMUs lack: other types, clocks, event mode, time derivatives, model exchange,
   scheduled execution. Their functions exist, and refuse every call with the reason. A variable of a type without
   variables is a wrong reference, which ends the run like any other wrong call; the other calls leave the instance
   unchanged. */

#include "fmi3Functions.h"
#include "values.h"

#pragma GCC diagnostic ignored "-Wunused-parameter"

/* An empty list is allowed. */
static fmi3Status none_of_type(Instance *instance, const char *call, const fmi3ValueReference references[],
                               size_t count)
{
    if (!may(instance, ANY, call))
        return fmi3Error;
    if (!count)
        return fmi3OK;
    return (fmi3Status)(references ? wrong_reference(instance, call, references[0])
                                   : fail(instance, "%s: references is NULL", call));
}

static fmi3Status absent(const Instance *instance, const char *call, const char *why)
{
    return (fmi3Status)unsupported(instance, STATUS_ERROR, call, why);
}

#define REFERENCES const fmi3ValueReference references[], size_t count

#define NO_VARIABLES(TYPE)                                                                                             \
    fmi3Status fmi3Get##TYPE(fmi3Instance instance, REFERENCES, fmi3##TYPE values[], size_t n_values)                  \
    {                                                                                                                  \
        return none_of_type(instance, __func__, references, count);                                                    \
    }                                                                                                                  \
    fmi3Status fmi3Set##TYPE(fmi3Instance instance, REFERENCES, const fmi3##TYPE values[], size_t n_values)            \
    {                                                                                                                  \
        return none_of_type(instance, __func__, references, count);                                                    \
    }

NO_VARIABLES(Float32)
NO_VARIABLES(Int8)
NO_VARIABLES(UInt8)
NO_VARIABLES(Int16)
NO_VARIABLES(UInt16)
NO_VARIABLES(UInt32)
NO_VARIABLES(UInt64)
NO_VARIABLES(String)

fmi3Status fmi3GetBinary(fmi3Instance instance, REFERENCES, size_t sizes[], fmi3Binary values[], size_t n_values)
{
    return none_of_type(instance, __func__, references, count);
}

fmi3Status fmi3SetBinary(fmi3Instance instance, REFERENCES, const size_t sizes[], const fmi3Binary values[],
                         size_t n_values)
{
    return none_of_type(instance, __func__, references, count);
}

fmi3Status fmi3GetClock(fmi3Instance instance, REFERENCES, fmi3Clock values[])
{
    return none_of_type(instance, __func__, references, count);
}

fmi3Status fmi3SetClock(fmi3Instance instance, REFERENCES, const fmi3Clock values[])
{
    return none_of_type(instance, __func__, references, count);
}

/* A function that refuses its calls, with its further parameters. */
#define ABSENT(NAME, WHY, ...)                                                                                         \
    fmi3Status NAME(fmi3Instance instance __VA_ARGS__) { return absent(instance, __func__, WHY); }

#define AND , /* before the first further parameter */

static const char CLOCKS[] = "this FMU has no clocks", EVENTS[] = "this FMU has no event mode",
                  DERIVATIVES[] = "this FMU provides no time derivatives of its outputs",
                  STRUCTURE[] = "this FMU has no structural parameters",
                  EXCHANGE[] = "this is an FMU for co-simulation, not for model exchange",
                  SCHEDULED[] = "this is an FMU for co-simulation, not for scheduled execution",
                  DEPENDENCIES[] = "the dependencies are those of the modelDescription";

ABSENT(fmi3GetIntervalDecimal, CLOCKS, AND REFERENCES, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
ABSENT(fmi3GetIntervalFraction, CLOCKS, AND REFERENCES, fmi3UInt64 counters[], fmi3UInt64 resolutions[],
       fmi3IntervalQualifier qualifiers[])
ABSENT(fmi3GetShiftDecimal, CLOCKS, AND REFERENCES, fmi3Float64 shifts[])
ABSENT(fmi3GetShiftFraction, CLOCKS, AND REFERENCES, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
ABSENT(fmi3SetIntervalDecimal, CLOCKS, AND REFERENCES, const fmi3Float64 intervals[])
ABSENT(fmi3SetIntervalFraction, CLOCKS, AND REFERENCES, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
ABSENT(fmi3SetShiftDecimal, CLOCKS, AND REFERENCES, const fmi3Float64 shifts[])
ABSENT(fmi3SetShiftFraction, CLOCKS, AND REFERENCES, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])

ABSENT(fmi3EnterEventMode, EVENTS, )
ABSENT(fmi3EnterStepMode, EVENTS, )
ABSENT(fmi3EvaluateDiscreteStates, EVENTS, )
ABSENT(fmi3UpdateDiscreteStates, EVENTS, AND fmi3Boolean *again, fmi3Boolean *terminate, fmi3Boolean *nominals,
       fmi3Boolean *states, fmi3Boolean *has_next, fmi3Float64 *next)

ABSENT(fmi3EnterConfigurationMode, STRUCTURE, )
ABSENT(fmi3ExitConfigurationMode, STRUCTURE, )

ABSENT(fmi3GetNumberOfVariableDependencies, DEPENDENCIES, AND fmi3ValueReference reference, size_t *count)
ABSENT(fmi3GetVariableDependencies, DEPENDENCIES, AND fmi3ValueReference dependent, size_t elements[],
       fmi3ValueReference independents[], size_t elements_of_independents[], fmi3DependencyKind kinds[], size_t count)

ABSENT(fmi3GetOutputDerivatives, DERIVATIVES, AND REFERENCES, const fmi3Int32 orders[], fmi3Float64 values[],
       size_t n_values)

ABSENT(fmi3EnterContinuousTimeMode, EXCHANGE, )
ABSENT(fmi3CompletedIntegratorStep, EXCHANGE, AND fmi3Boolean no_earlier_state, fmi3Boolean *event,
       fmi3Boolean *terminate)
ABSENT(fmi3SetTime, EXCHANGE, AND fmi3Float64 time)
ABSENT(fmi3SetContinuousStates, EXCHANGE, AND const fmi3Float64 states[], size_t count)
ABSENT(fmi3GetContinuousStateDerivatives, EXCHANGE, AND fmi3Float64 derivatives[], size_t count)
ABSENT(fmi3GetEventIndicators, EXCHANGE, AND fmi3Float64 indicators[], size_t count)
ABSENT(fmi3GetContinuousStates, EXCHANGE, AND fmi3Float64 states[], size_t count)
ABSENT(fmi3GetNominalsOfContinuousStates, EXCHANGE, AND fmi3Float64 nominals[], size_t count)
ABSENT(fmi3GetNumberOfEventIndicators, EXCHANGE, AND size_t *count)
ABSENT(fmi3GetNumberOfContinuousStates, EXCHANGE, AND size_t *count)
ABSENT(fmi3ActivateModelPartition, SCHEDULED, AND fmi3ValueReference clock, fmi3Float64 time)
