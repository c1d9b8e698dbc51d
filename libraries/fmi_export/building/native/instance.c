#include "instance.h"

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

/* Append to a text of TEXT_SIZE; what does not fit is left out. */
static void append(char *text, const char *format, ...)
{
    size_t used = strlen(text);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text + used, TEXT_SIZE - used, format, arguments);
    va_end(arguments);
}

static void append_number(char *text, double value)
{
    if (isnan(value))
        append(text, "nan"); /* without the sign that printf may show */
    else
        append(text, "%g", value);
}

static void explain_range(char *text, int variable, double value)
{
    append(text, "%s = ", variables[variable].name);
    append_number(text, value);
    append(text, "%s", variables[variable].allowed);
}

/* The sentence for a fault of the kernels, with the present values of the variables it names. */
static void explain_fault(char *text, const Run *run, int64_t fault)
{
    for (int i = 0; i < N_FAULTS; i++) {
        if (fault_sentences[i].code != fault)
            continue;
        for (const Piece *piece = fault_sentences[i].sentence; piece->text; piece++) {
            append(text, "%s", piece->text);
            if (piece->variable >= 0)
                append_number(text, run->values[piece->variable]);
        }
        return;
    }
    append(text, "fault %lld", (long long)fault);
}

/* First of `count` values that is outside its range or not a number, or -1; `first` is the variable it begins with. */
static int first_outside(const double *values, int first, int count)
{
    int outside = 0; /* found without a jump, so that the compiler compares several at once */
    for (int i = 0; i < count; i++)
        outside |= !((minima[first + i] <= values[i]) & (values[i] <= maxima[first + i]));
    for (int i = 0; outside && i < count; i++)
        if (!(minima[first + i] <= values[i] && values[i] <= maxima[first + i]))
            return i;
    return -1;
}

int64_t run_stop(Run *run, int64_t fault, const char *reason)
{
    run->fault = fault;
    if (reason != run->reason)
        snprintf(run->reason, sizeof run->reason, "%s", reason);
    run->values[FAULT_CODE] = (double)fault;
    return fault;
}

/* Inputs may be new at every step, parameters only after one was set. */
static int64_t check_given(Run *run)
{
    int first = run->checked ? FIRST_INPUT : 0;
    int i = first_outside(run->values + first, first, FIRST_OUTPUT - first);
    if (i < 0) {
        run->checked = 1;
        return 0;
    }
    i += first;
    run->reason[0] = '\0';
    explain_range(run->reason, i, run->values[i]);
    return run_stop(run, FAULT_RANGE + i, run->reason);
}

/* Publish the outputs if the kernel returned no fault and each output is in its range. */
static int64_t finish(Run *run, const Scratch *scratch, int32_t raised, int64_t fault)
{
    if (raised != 0)
        return run_stop(run, FAULT_INTERNAL, "the model's code failed with an exception");
    if (fault != 0) {
        run->reason[0] = '\0';
        explain_fault(run->reason, run, fault);
        return run_stop(run, fault, run->reason);
    }
    int i = first_outside(scratch->next_outputs, FIRST_OUTPUT, N_OUTPUTS);
    if (i >= 0) {
        int variable = FIRST_OUTPUT + i;
        run->reason[0] = '\0';
        if (isfinite(scratch->next_outputs[i]))
            explain_range(run->reason, variable, scratch->next_outputs[i]);
        else
            append(run->reason, "%s is no longer a finite number", variables[variable].name);
        return run_stop(run, FAULT_NOT_FINITE + variable, run->reason);
    }
    memcpy(run->values + FIRST_OUTPUT, scratch->next_outputs, sizeof scratch->next_outputs);
    run->values[FAULT_CODE] = 0.0;
    return 0;
}

void run_clear(Run *run)
{
    memset(run, 0, sizeof *run);
    memcpy(run->values, start_values, sizeof run->values);
}

int64_t run_initialise(Run *run, Scratch *scratch)
{
    int64_t fault = 0;
    void *exception = NULL;
    run->fault = 0;
    if (check_given(run))
        return run->fault;
    memset(run->state, 0, sizeof run->state);
    int32_t raised = kernel_initialise(&fault, &exception, model_constants, N_CONSTANTS, run->values, N_PARAMETERS,
                                       run->values + FIRST_INPUT, N_INPUTS, run->state, N_STATE, scratch->work, N_WORK,
                                       scratch->next_outputs, N_OUTPUTS);
    return finish(run, scratch, raised, fault);
}

int64_t run_step(Run *run, Scratch *scratch, double time, double step_size)
{
    int64_t fault = 0;
    void *exception = NULL;
    if (!(step_size > 0.0 && isfinite(step_size))) {
        run->reason[0] = '\0';
        append(run->reason, "step size = ");
        append_number(run->reason, step_size);
        append(run->reason, " s is not allowed; it must be > 0 s and finite");
        return run_stop(run, FAULT_STEP_SIZE, run->reason);
    }
    if (check_given(run))
        return run->fault;
    int32_t raised = kernel_step(&fault, &exception, model_constants, N_CONSTANTS, run->values, N_PARAMETERS,
                                 run->values + FIRST_INPUT, N_INPUTS, run->state, N_STATE, scratch->work, N_WORK,
                                 scratch->next_outputs, N_OUTPUTS, time, step_size);
    return finish(run, scratch, raised, fault);
}
