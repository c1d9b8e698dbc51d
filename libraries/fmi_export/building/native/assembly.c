#include "assembly.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "kernels.h"
#include "loop.h"

enum { FAULT_LOOP = 1, OF_PART = 100 };

/* A part is a run on arrays within those of the assembly, each at an even position:

       state: clock | values of the loop | values and state of each part
       work:  outputs and work array of each part */
typedef struct {
    Run run;
    Outcome outcome;
    const char *name;
} PartRun;

/* Steps are divided at instants that are a sample time apart, the first at the beginning of the first step. */
typedef struct {
    double begin, count;
} Clock;

struct Assembly {
    const Wiring *wiring;
    const Part *parts;
    const int64_t *sources, *ramps, *gathers;
    Clock *clock;
    double *gathered, *before; /* outputs gathered over a step; values before parts were initialised again */
    Program program;
    PartRun runs[MOST_PARTS];
    /* Arrays of the program, which has a call to set the inputs of a part, and another to get its outputs. */
    void *instance[MOST_PARTS], *inputs_at[MOST_PARTS], *outputs_at[MOST_PARTS];
    DoStep *do_step[MOST_PARTS];
    Exchange *set[MOST_PARTS], *get[MOST_PARTS];
    const uint32_t *no_references[MOST_PARTS];
    intptr_t every[MOST_PARTS], calls[MOST_PARTS + 1], first_input[MOST_PARTS + 1], first_output[MOST_PARTS + 1];
    double step_sizes[MOST_PARTS];
    bool all[MOST_PARTS];
};

/* What the loop calls ---------------------------------------------------------------------------------------------- */

static int set_inputs(void *part, const uint32_t *references, size_t size, void *values)
{
    Run *run = &((PartRun *)part)->run;
    (void)references;
    memcpy(run->values + run->data.n_parameters, values, size * sizeof(double));
    return 0;
}

static int get_outputs(void *part, const uint32_t *references, size_t size, void *values)
{
    const Run *run = &((PartRun *)part)->run;
    (void)references;
    memcpy(values, run->values + first_output(&run->data), size * sizeof(double));
    return 0;
}

static int step_part(void *part, double time, double step_size, int no_way_back)
{
    (void)no_way_back;
    return run_step(&((PartRun *)part)->run, time, step_size) ? LOOP_ERROR : 0;
}

/* A part with a fault keeps its outputs; further sweeps may change the inputs that caused the fault. */
static int initialise_part(void *part, double time, double step_size, int no_way_back)
{
    (void)time, (void)step_size, (void)no_way_back;
    return run_initialise(&((PartRun *)part)->run) ? LOOP_WARNING : 0;
}

/* Let the loop call all parts once, at a point that determines which parts are due. */
static End call_parts(struct Assembly *assembly, intptr_t point)
{
    const Changes nothing_changed = {0};
    const RecordBuffer nothing_recorded = {.first = INTPTR_MAX, .every = 1};
    const Conditions none = {0};
    const volatile bool pause = false;
    End end;
    advance(&assembly->program, &nothing_changed, &nothing_recorded, &none, 0, point, point + 1, point + 1, &pause,
            &end);
    return end;
}

/* Making it -------------------------------------------------------------------------------------------------------- */

static int are_below(const int64_t *numbers, int64_t count, int64_t limit)
{
    for (int64_t i = 0; i < count; i++)
        if (numbers[i] < 0 || numbers[i] >= limit)
            return 0;
    return 1;
}

/* Whether the tables are within the constants and refer to existing items. */
static int tables_are_possible(const Data *data)
{
    const Wiring *wiring = (const Wiring *)data->constants;
    const Part *parts = (const Part *)(wiring + 1);
    const int64_t *table = (const int64_t *)(parts + data->n_parts);
    const int64_t *end = (const int64_t *)(data->constants + data->n_constants);
    if (table > end || wiring->sample_time >= data->n_parameters)
        return 0;
    const int64_t counts[] = {wiring->n_sources, 2 * wiring->n_ramps, 2 * wiring->n_gathered};
    const int64_t limits[] = {data->n_inputs + data->n_outputs - 1, data->n_inputs, data->n_outputs};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; table += counts[i++])
        if (counts[i] < 0 || counts[i] > end - table || !are_below(table, counts[i], limits[i]))
            return 0;
    const uint64_t size = sizeof(double) * (uint64_t)data->n_constants;
    for (size_t k = 0; k < data->n_parts; k++)
        if (parts[k].name >= data->n_text || parts[k].data % 16 || parts[k].data > size ||
            parts[k].size > size - parts[k].data || parts[k].n_samples < 1)
            return 0;
    return 1;
}

/* Return the next `count` items at a position, which advances to the next even position. */
static double *take(double **place, int64_t count)
{
    double *taken = *place;
    *place += count + count % 2;
    return taken;
}

/* Assign the parts their data and their positions in the arrays of the assembly; return whether they fill these
   exactly. */
static int place_parts(struct Assembly *assembly, Run *run, char *reason)
{
    const Data *data = &run->data;
    const unsigned char *constants = (const unsigned char *)data->constants;
    double *state = run->state, *work = run->work;
    int64_t n_parameters = 0, n_inputs = 0, n_outputs = 0;
    assembly->clock = (Clock *)take(&state, 2);
    assembly->program.values = take(&state, data->n_inputs + data->n_outputs - 1);
    for (size_t k = 0; k < data->n_parts; k++) {
        const Part *part = &assembly->parts[k];
        PartRun *part_run = &assembly->runs[k];
        if (!data_is_valid(constants + part->data, part->size, reason))
            return 0;
        part_run->name = data->text + part->name;
        part_run->run.data = data_in(constants + part->data);
        part_run->run.outcome = &part_run->outcome;
        part_run->run.values = take(&state, part_run->run.data.n_values);
        part_run->run.state = take(&state, part_run->run.data.n_state);
        part_run->run.next_outputs = take(&work, part_run->run.data.n_outputs);
        part_run->run.work = take(&work, part_run->run.data.n_work);
        assembly->first_input[k] = (intptr_t)n_inputs;
        assembly->first_output[k] = (intptr_t)n_outputs;
        n_parameters += part_run->run.data.n_parameters;
        n_inputs += part_run->run.data.n_inputs;
        n_outputs += part_run->run.data.n_outputs - 1; /* without the fault code */
    }
    assembly->first_input[data->n_parts] = (intptr_t)n_inputs;
    assembly->first_output[data->n_parts] = (intptr_t)n_outputs;
    snprintf(reason, TEXT_SIZE, "the sizes of its parts do not match");
    return state - run->state == data->n_state && work - run->work == data->n_work &&
           n_parameters == data->n_parameters && n_inputs == assembly->wiring->n_sources &&
           n_outputs == data->n_outputs - 1;
}

static void make_program(struct Assembly *assembly, const Data *data, intptr_t *positions, double *inputs)
{
    Program *program = &assembly->program;
    const intptr_t n_parts = (intptr_t)data->n_parts;
    for (intptr_t i = 0; i < assembly->wiring->n_sources; i++)
        positions[i] = (intptr_t)assembly->sources[i];
    for (intptr_t k = 0; k < n_parts; k++) {
        assembly->instance[k] = &assembly->runs[k];
        assembly->set[k] = set_inputs;
        assembly->get[k] = get_outputs;
        assembly->inputs_at[k] = inputs + assembly->first_input[k];
        assembly->outputs_at[k] = program->values + data->n_inputs + assembly->first_output[k];
        assembly->calls[k + 1] = k + 1;
        assembly->all[k] = true;
    }
    program->instance = assembly->instance;
    program->do_step = assembly->do_step;
    program->every = assembly->every;
    program->step_sizes = assembly->step_sizes;
    program->size = n_parts;
    program->sends = (Calls){.of = assembly->calls,
                             .function = assembly->set,
                             .references_at = assembly->no_references,
                             .values_at = assembly->inputs_at,
                             .real = assembly->all,
                             .first = assembly->first_input,
                             .positions = positions,
                             .reals = inputs};
    program->fetches = (Calls){.of = assembly->calls,
                               .function = assembly->get,
                               .references_at = assembly->no_references,
                               .values_at = assembly->outputs_at,
                               .direct = assembly->all,
                               .first = assembly->first_output};
    program->needed = program->fetches;
}

/* Stepping it ------------------------------------------------------------------------------------------------------ */

/* Copy the parameters to the parts and the inputs to the loop, both checked before, and clear the faults of parts. */
static void copy_inputs(Run *run)
{
    struct Assembly *assembly = run->assembly;
    const double *parameters = run->values;
    for (size_t k = 0; k < run->data.n_parts; k++) {
        Run *part = &assembly->runs[k].run;
        memcpy(part->values, parameters, (size_t)part->data.n_parameters * sizeof *parameters);
        part->outcome->checked = 1;
        part->outcome->fault = 0;
        parameters += part->data.n_parameters;
    }
    memcpy(assembly->program.values, parameters, (size_t)run->data.n_inputs * sizeof *parameters);
}

/* Stop the run by the fault of a part; the code of a value out of range identifies a variable of the assembly. */
static void stop_by_part(Run *run, size_t k)
{
    const struct Assembly *assembly = run->assembly;
    const PartRun *part = &assembly->runs[k];
    const Data *data = &part->run.data;
    char reason[TEXT_SIZE];
    int64_t fault = part->outcome.fault;
    if (fault >= FAULT_NOT_FINITE)
        fault += first_output(&run->data) + assembly->first_output[k] - first_output(data);
    else if (fault >= FAULT_RANGE)
        fault = FAULT_RANGE + run->data.n_parameters +
                assembly->sources[assembly->first_input[k] + fault - FAULT_RANGE - data->n_parameters];
    else if (fault < FAULT_INTERNAL)
        fault += OF_PART * ((int64_t)k + 1);
    snprintf(reason, sizeof reason, "%s: %.*s", part->name, TEXT_SIZE / 2, part->outcome.reason);
    run_stop(run, fault, reason);
}

static void publish_outputs(Run *run)
{
    const Data *data = &run->data;
    const double *outputs = run->assembly->program.values + data->n_inputs;
    memcpy(run->next_outputs, outputs, (size_t)(data->n_outputs - 1) * sizeof *outputs);
}

static int64_t initialise_assembly(Run *run)
{
    struct Assembly *assembly = run->assembly;
    const Data *data = &run->data;
    const size_t size = (size_t)(data->n_inputs + data->n_outputs - 1) * sizeof(double);
    assembly->program.jacobi = false;
    for (size_t k = 0; k < data->n_parts; k++) {
        assembly->do_step[k] = initialise_part;
        assembly->every[k] = 1;
    }
    copy_inputs(run);
    int64_t sweeps = 0;
    do {
        if (sweeps++ > assembly->wiring->n_sources + 1)
            return FAULT_LOOP;
        memcpy(assembly->before, assembly->program.values, size);
        call_parts(assembly, 0);
    } while (memcmp(assembly->before, assembly->program.values, size) != 0);
    for (size_t k = 0; k < data->n_parts; k++)
        if (assembly->runs[k].outcome.fault) {
            stop_by_part(run, k);
            return 0;
        }
    publish_outputs(run);
    return 0;
}

/* When samples are due and what a host's time may differ by, as in signal_chain/sampling.py, by whose rules a part
   samples. A step that differs from the sample time by rounding of the times only has that length. */
static const double TOLERANCE = 1e-3, ROUNDING = 1e-6, ROUNDING_OF_TIME = 4.5e-16;
static const double SAME = 1e-9, SAME_TIME = 1e-15;
static const double MOST_SAMPLES = 1e6; /* in a step: more would take minutes and seem to hang */

/* The largest difference between an instant and the communication point that it stands for. */
static double rounding(double time, double step_size, double sample_time)
{
    return fmin(ROUNDING * sample_time + ROUNDING_OF_TIME * fabs(time), 0.5 * step_size);
}

/* How close to the beginning or the end of a step an instant is taken to be there. */
static double tolerance(double time, double step_size, double sample_time)
{
    return fmax(TOLERANCE * fmin(step_size, sample_time), rounding(time, step_size, sample_time));
}

/* The next instant. It is `time` if it differs from that by rounding, and before the first step. */
static double next_instant(Clock *clock, double time, double step_size, double sample_time)
{
    const double elapsed = clock->count * sample_time, late = time - (clock->begin + elapsed);
    if (clock->count == 0.0 || fabs(late) <= rounding(time, step_size, sample_time))
        clock->begin = time - elapsed;
    return clock->begin + elapsed;
}

static int is_due(double instant, double time, double step_size, double sample_time)
{
    return instant < time + step_size - tolerance(time, step_size, sample_time);
}

/* The size of the first piece of the step of `step_size` from `time`. It has the next instant at its beginning or not
   at all, and is no longer than the sample time. */
static double piece(double instant, double time, double step_size, double sample_time)
{
    if (!is_due(instant, time, step_size, sample_time))
        return step_size;
    if (instant > time + tolerance(time, step_size, sample_time))
        return instant - time;
    return step_size > sample_time + rounding(time, step_size, sample_time) ? sample_time : step_size;
}

/* Set the inputs that have a slope to their values at the time `elapsed` after the beginning of the step. */
static void follow_slopes(Run *run, double elapsed)
{
    const struct Assembly *assembly = run->assembly;
    const double *inputs = run->values + run->data.n_parameters;
    for (const int64_t *ramp = assembly->ramps; ramp < assembly->gathers; ramp += 2)
        assembly->program.values[ramp[0]] = inputs[ramp[0]] + inputs[ramp[1]] * elapsed;
}

/* Step all parts from `time`; those that span several instants step at every such instant. */
static End step_parts(Run *run, double time, double step_size, double sample_time)
{
    struct Assembly *assembly = run->assembly;
    Clock *clock = assembly->clock;
    const double instant = next_instant(clock, time, step_size, sample_time);
    const int due = is_due(instant, time, step_size, sample_time);
    assembly->program.start_time = time;
    assembly->program.jacobi = assembly->wiring->jacobi != 0;
    for (size_t k = 0; k < run->data.n_parts; k++) {
        int64_t n = assembly->parts[k].n_samples;
        assembly->do_step[k] = step_part;
        assembly->every[k] = n == 1 ? 1 : due ? (intptr_t)n : INTPTR_MAX;
        assembly->step_sizes[k] = n == 1 ? step_size : (double)n * sample_time;
    }
    End end = call_parts(assembly, due ? (intptr_t)clock->count : 1);
    if (due)
        clock->count += 1.0;
    return end;
}

/* What outputs are gathered to; as `GATHERED` in `fmi_export/model.py`. */
enum { LARGEST, SUM, MEAN };

/* Gather outputs over the pieces of a step, anew from its beginning; `share` is that of the piece in the step. */
static void gather(const Run *run, int begins, double share)
{
    const struct Assembly *assembly = run->assembly;
    const double *outputs = assembly->program.values + run->data.n_inputs;
    for (int64_t i = 0; i < assembly->wiring->n_gathered; i++) {
        const int64_t *pair = assembly->gathers + 2 * i;
        double before = begins ? 0.0 : assembly->gathered[i], value = outputs[pair[0]];
        assembly->gathered[i] =
            pair[1] == LARGEST ? fmax(before, value) : before + (pair[1] == MEAN ? share : 1.0) * value;
    }
}

static int64_t step_assembly(Run *run, double time, double step_size)
{
    const Wiring *wiring = run->assembly->wiring;
    Clock *clock = run->assembly->clock;
    const double sample_time = wiring->sample_time < 0 ? wiring->step_size : run->values[wiring->sample_time];
    double at = time, left = step_size;
    int pieces = 0;
    if (step_size > MOST_SAMPLES * sample_time) {
        char reason[TEXT_SIZE];
        snprintf(reason, sizeof reason,
                 "step size = %g s is not allowed; it must be at most %g times the sample time of %g s", step_size,
                 MOST_SAMPLES, sample_time);
        return run_stop(run, FAULT_STEP_SIZE, reason);
    }
    copy_inputs(run);
    while (left > 0.0) {
        double size = piece(next_instant(clock, at, left, sample_time), at, left, sample_time);
        int is_whole = fabs(size - sample_time) <= SAME * sample_time + SAME_TIME * fabs(at);
        follow_slopes(run, at - time);
        End end = step_parts(run, at, is_whole ? sample_time : size, sample_time);
        if (end.status) {
            stop_by_part(run, (size_t)end.component);
            return 0;
        }
        left -= size;
        at = time + step_size - left;
        if (left > 0.0 || pieces > 0)
            gather(run, pieces == 0, size / step_size);
        pieces++;
    }
    publish_outputs(run);
    for (int64_t i = 0; pieces > 1 && i < wiring->n_gathered; i++)
        run->next_outputs[run->assembly->gathers[2 * i]] = run->assembly->gathered[i];
    return 0;
}

/* Opening it ------------------------------------------------------------------------------------------------------- */

static const Stepper STEPPER = {initialise_assembly, step_assembly};

static void close_assembly(Run *run)
{
    for (size_t k = 0; k < run->data.n_parts; k++)
        close_kernels(&run->assembly->runs[k].run);
    free(run->assembly);
}

static int open_assembly(Run *run, const char *location, char *reason)
{
    const Data *data = &run->data;
    if (!tables_are_possible(data)) {
        snprintf(reason, TEXT_SIZE, "resources/model.bin is damaged: its wiring is impossible");
        return 0;
    }
    const Wiring *wiring = (const Wiring *)data->constants;
    const size_t n_sources = (size_t)wiring->n_sources, n_values = (size_t)(data->n_inputs + data->n_outputs);
    const size_t n_gathered = (size_t)wiring->n_gathered;
    const size_t numbers = (n_sources + n_values + n_gathered) * sizeof(double);
    struct Assembly *assembly = calloc(1, sizeof *assembly + numbers + n_sources * sizeof(intptr_t));
    if (!assembly) {
        snprintf(reason, TEXT_SIZE, "there is no memory for another instance");
        return 0;
    }
    run->assembly = assembly;
    run->stepper = &STEPPER;
    assembly->wiring = wiring;
    assembly->parts = (const Part *)(wiring + 1);
    assembly->sources = (const int64_t *)(assembly->parts + data->n_parts);
    assembly->ramps = assembly->sources + wiring->n_sources;
    assembly->gathers = assembly->ramps + 2 * wiring->n_ramps;
    double *inputs = (double *)(assembly + 1);
    assembly->before = inputs + n_sources;
    assembly->gathered = assembly->before + n_values;
    int is_open = place_parts(assembly, run, reason);
    if (is_open)
        make_program(assembly, data, (intptr_t *)(assembly->gathered + n_gathered), inputs);
    for (size_t k = 0; is_open && k < data->n_parts; k++)
        is_open = open_kernels(&assembly->runs[k].run, assembly->runs[k].name, location, reason);
    if (!is_open)
        close_assembly(run);
    return is_open;
}

int run_open(Run *run, const char *name, const char *location, char *reason)
{
    return run->data.n_parts ? open_assembly(run, location, reason) : open_kernels(run, name, location, reason);
}

void run_close(Run *run)
{
    if (run->assembly)
        close_assembly(run);
    else
        close_kernels(run);
}
