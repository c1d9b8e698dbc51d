#include "instance.h"

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "kernels.h"

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

static void explain_range(char *text, const Data *data, int64_t variable, double value)
{
    append(text, "%s = ", name_of(data, variable));
    append_number(text, value);
    append(text, "%s", data->text + data->variables[variable].allowed);
}

/* A sentence with the present values of the variables it names, of outputs those in `outputs`. */
static void explain(char *text, const Run *run, const Sentence *sentence, const double *outputs)
{
    const Piece *piece = run->data.pieces + sentence->first_piece;
    int64_t first = first_output(&run->data);
    for (uint32_t i = 0; i < sentence->n_pieces; i++, piece++) {
        append(text, "%s", run->data.text + piece->text);
        if (piece->variable == STEP_SIZE)
            append_number(text, run->outcome->step_size);
        else if (piece->variable != NO_VALUE)
            append_number(text,
                          piece->variable < first ? run->values[piece->variable] : outputs[piece->variable - first]);
    }
}

/* The sentence for a fault of the kernels; outputs have the values that they had found. */
static void explain_fault(char *text, const Run *run, int64_t fault)
{
    const Data *data = &run->data;
    for (const Sentence *sentence = data->faults; sentence < data->faults + data->n_faults; sentence++)
        if (sentence->of == fault) {
            explain(text, run, sentence, run->next_outputs);
            return;
        }
    append(text, "fault %lld", (long long)fault);
}

/* First of `count` values that is outside its range or not a number, or -1; `first` is the variable it begins with. */
static int64_t first_outside(const Data *data, const double *values, int64_t first, int64_t count)
{
    const double *minima = data->minima + first, *maxima = data->maxima + first;
    int64_t outside = 0; /* as wide as a value, and found without a jump: the compiler compares several at once */
    for (int64_t i = 0; i < count; i++)
        outside |= !((minima[i] <= values[i]) & (values[i] <= maxima[i]));
    for (int64_t i = 0; outside && i < count; i++)
        if (!(minima[i] <= values[i] && values[i] <= maxima[i]))
            return i;
    return -1;
}

int64_t run_stop(Run *run, int64_t fault, const char *reason)
{
    Outcome *outcome = run->outcome;
    outcome->fault = fault;
    if (reason != outcome->reason)
        snprintf(outcome->reason, sizeof outcome->reason, "%s", reason);
    run->values[run->data.n_values - 1] = (double)fault;
    return fault;
}

int run_next_warning(Run *run, char *text)
{
    const Data *data = &run->data;
    for (int64_t i = 0; i < data->n_warnings; i++) {
        int64_t variable = data->warnings[i].of;
        if (run->reported[i] || run->values[variable] == 0.0)
            continue;
        run->reported[i] = 1;
        text[0] = '\0';
        append(text, "%s: ", name_of(data, variable));
        explain(text, run, &data->warnings[i], run->values + first_output(data));
        return 1;
    }
    return 0;
}

/* Inputs may be new at every step, parameters only after one was set. */
static int64_t check_inputs(Run *run)
{
    Outcome *outcome = run->outcome;
    int64_t first = outcome->checked ? run->data.n_parameters : 0;
    int64_t i = first_outside(&run->data, run->values + first, first, first_output(&run->data) - first);
    if (i < 0) {
        outcome->checked = 1;
        return 0;
    }
    i += first;
    outcome->reason[0] = '\0';
    explain_range(outcome->reason, &run->data, i, run->values[i]);
    return run_stop(run, FAULT_RANGE + i, outcome->reason);
}

/* Publish the outputs if no part has stopped the run, the kernel did not fail, returned no fault, and each output is
   in its range. */
static int64_t finish(Run *run, const char *failure, int64_t fault)
{
    const Data *data = &run->data;
    char *reason = run->outcome->reason;
    if (run->outcome->fault)
        return run->outcome->fault;
    if (failure)
        return run_stop(run, FAULT_INTERNAL, failure);
    if (fault == UNCHANGED)
        return 0;
    if (fault != 0) {
        reason[0] = '\0';
        explain_fault(reason, run, fault);
        return run_stop(run, fault, reason);
    }
    int64_t first = first_output(data), i = first_outside(data, run->next_outputs, first, data->n_outputs);
    if (i >= 0) {
        reason[0] = '\0';
        if (isfinite(run->next_outputs[i]))
            explain_range(reason, data, first + i, run->next_outputs[i]);
        else
            append(reason, "%s is no longer a finite number", name_of(data, first + i));
        return run_stop(run, FAULT_NOT_FINITE + first + i, reason);
    }
    memcpy(run->values + first, run->next_outputs, (size_t)data->n_outputs * sizeof *run->values);
    run->values[data->n_values - 1] = 0.0;
    reason[0] = '\0';
    return 0;
}

void run_clear(Run *run)
{
    const Data *data = &run->data;
    memset(run->outcome, 0, sizeof *run->outcome);
    memcpy(run->values, data->start_values, (size_t)data->n_values * sizeof *run->values);
    memset(run->state, 0, (size_t)data->n_state * sizeof *run->state);
    memset(run->reported, 0, (size_t)data->n_warnings);
}

int64_t run_initialise(Run *run)
{
    const Data *data = &run->data;
    const char *failure = NULL;
    int64_t fault = 0;
    run->outcome->fault = 0;
    if (check_inputs(run))
        return run->outcome->fault;
    memset(run->state, 0, (size_t)data->n_state * sizeof *run->state);
    if (run->stepper)
        fault = run->stepper->initialise(run);
    else
        failure = call_initialise(run, &fault);
    return finish(run, failure, fault);
}

int64_t run_step(Run *run, double time, double step_size)
{
    const char *failure = NULL;
    int64_t fault = 0;
    if (!(step_size > 0.0 && isfinite(step_size))) {
        char *reason = run->outcome->reason;
        reason[0] = '\0';
        append(reason, "step size = ");
        append_number(reason, step_size);
        append(reason, " s is not allowed; it must be > 0 s and finite");
        return run_stop(run, FAULT_STEP_SIZE, reason);
    }
    if (check_inputs(run))
        return run->outcome->fault;
    run->outcome->step_size = step_size;
    if (run->stepper)
        fault = run->stepper->step(run, time, step_size);
    else
        failure = call_step(run, time, step_size, &fault);
    return finish(run, failure, fault);
}
