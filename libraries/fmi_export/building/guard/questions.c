/* The status of an instance, and the parts of the standard that it leaves optional. */

#include "guard.h"

/* A question that the standard leaves optional: refused, and the instance lives on. */
static fmi2Status unsupported(const Instance *instance, fmi2Status status, const char *what)
{
    if (!instance)
        return fmi2Error;
    say(instance, status, what);
    return status;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component component, const fmi2ValueReference unknowns[], size_t n_unknowns,
                                        const fmi2ValueReference knowns[], size_t n_knowns, const fmi2Real dv_known[],
                                        fmi2Real dv_unknown[])
{
    (void)unknowns, (void)n_unknowns, (void)knowns, (void)n_knowns, (void)dv_known, (void)dv_unknown;
    return unsupported(component, fmi2Error, "fmi2GetDirectionalDerivative: this FMU gives no derivatives");
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component component, REFERENCES, const fmi2Integer orders[],
                                       const fmi2Real values[])
{
    (void)references, (void)count, (void)orders, (void)values;
    return unsupported(component, fmi2Error, "fmi2SetRealInputDerivatives: inputs are constant during a step");
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component component, REFERENCES, const fmi2Integer orders[],
                                        fmi2Real values[])
{
    (void)references, (void)count, (void)orders, (void)values;
    return unsupported(component, fmi2Error, "fmi2GetRealOutputDerivatives: this FMU gives no derivatives");
}

fmi2Status fmi2CancelStep(fmi2Component component)
{
    return unsupported(component, fmi2Error, "fmi2CancelStep: there is no step to cancel, none is asynchronous");
}

fmi2Status fmi2GetStatus(fmi2Component component, fmi2StatusKind kind, fmi2Status *value)
{
    (void)kind, (void)value;
    return unsupported(component, fmi2Discard, "fmi2GetStatus: no step is asynchronous");
}

fmi2Status fmi2GetRealStatus(fmi2Component component, fmi2StatusKind kind, fmi2Real *value)
{
    Instance *instance = component;
    if (!may(instance, ASKABLE, "fmi2GetRealStatus"))
        return fmi2Error;
    if (kind != fmi2LastSuccessfulTime || !value)
        return unsupported(instance, fmi2Discard, "fmi2GetRealStatus: there is fmi2LastSuccessfulTime alone");
    *value = instance->now.time;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component component, fmi2StatusKind kind, fmi2Integer *value)
{
    (void)kind, (void)value;
    return unsupported(component, fmi2Discard, "fmi2GetIntegerStatus: there is no such status");
}

fmi2Status fmi2GetBooleanStatus(fmi2Component component, fmi2StatusKind kind, fmi2Boolean *value)
{
    Instance *instance = component;
    if (!may(instance, ASKABLE, "fmi2GetBooleanStatus"))
        return fmi2Error;
    if (kind != fmi2Terminated || !value)
        return unsupported(instance, fmi2Discard, "fmi2GetBooleanStatus: there is fmi2Terminated alone");
    *value = fmi2False; /* no fault is an end that the model wants */
    return fmi2OK;
}

/* Why the call before was refused, whether it was logged or not; empty if it was not. The text lives until the next
   call. */
fmi2Status fmi2GetStringStatus(fmi2Component component, fmi2StatusKind kind, fmi2String *value)
{
    Instance *instance = component;
    if (!may(instance, ASKABLE, "fmi2GetStringStatus"))
        return fmi2Error;
    if (kind != fmi2PendingStatus || !value)
        return unsupported(instance, fmi2Discard, "fmi2GetStringStatus: there is fmi2PendingStatus alone");
    *value = instance->now.reason;
    return fmi2OK;
}
