/* Directional and adjoint derivatives: of outputs after one more communication step, from where the instance is, by
   Real inputs during it. The step has the size of the last one.

   They are difference quotients of trial steps. With inputs u + d v and u - d v a step has the outputs y+ and y-, with
   u itself y0, and

       D(d) = (y+ - y-) / 2d = y' v + d^2 y'''.. + ..                                           (Ridders)

   If an input is at an end of its range, d is a change away from that end, y1 and y2 are the outputs for d and 2d, and

       D(d) = (4 y1 - y2 - 3 y0) / 2d                                                         (one-sided)

   has errors of the same orders. d begins at a tenth of the nominal size of the inputs and becomes 8 times finer, level
   by level; of two levels that agree best, D + (D - D_before) / 63 has no error of second order. C. J. F. Ridders,
   Accurate computation of F'(x) and F'(x)F''(x), Advances in Engineering Software 4 (1982) 75-76. A step that is linear
   in its inputs is exact but for rounding.

   If no two levels agree, or the differences to both sides do not approach each other, there is no derivative, as where
   a rotor begins to touch. It is then NaN, with the status Warning, or Discard if all are NaN. A step with changed
   inputs may be computed in another way than the step without, so that y0 differs from y+ and y- by an error of the
   step, regardless of d: the differences to both sides then diverge as 1/d, which is not a kink. */

#include "derivative.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "values.h"

enum { LEVELS = 8, FEWEST = 3 };         /* FEWEST: that must lie within the range of an input */
static const double LARGEST_SHARE = 0.1; /* of the nominal size of an input */
static const double FINER = 8.0;
static const double AGREEMENT = 1e-6;  /* of two levels, relative */
static const double KINK = 1e-2;       /* of the differences to both sides, relative, that a bent curve may have */
static const double ROUNDINGS = 256.0; /* by which a step's output, or an output of nominal size, may be wrong */
static const double OFF = 1e-5;        /* of the same, by which it may differ between ways to compute it */

/* Trial steps in a direction: the outputs y0 of the unchanged one, and those of two changed ones for each level. */
typedef struct {
    Instance *instance;
    void *before; /* the saved state of the instance */
    const uint32_t *unknowns, *knowns;
    size_t n, n_knowns;
    double *outputs;
    int valid[LEVELS];
    double offsets[2]; /* changes of the two, in units of d: -1 and 1, or 1 and 2, or -1 and -2 */
    const char *input; /* the first of the direction, for messages */
} TrialSteps;

static double *outputs_at(const TrialSteps *trial, int level, int other)
{
    return trial->outputs + trial->n * (size_t)(1 + 2 * level + other);
}

/* Take a step with inputs changed by `share` times the seed, and keep its outputs; 0, or its fault. */
static int64_t probe(const TrialSteps *trial, const double *seed, double share, double *outputs)
{
    Instance *instance = trial->instance;
    memcpy(instance->now, trial->before, instance->saved_size);
    for (size_t i = 0; i < trial->n_knowns; i++)
        instance->run.values[trial->knowns[i]] += share * seed[i];
    int64_t fault = run_step(&instance->run, instance->now->time, instance->now->outcome.step_size);
    for (size_t j = 0; j < trial->n; j++)
        outputs[j] = instance->run.values[trial->unknowns[j]];
    return fault;
}

/* The largest share of a seed, by the nominal sizes of its inputs; 0 of a seed that is zero. */
static double first_share(const TrialSteps *trial, const double *seed)
{
    double share = INFINITY;
    for (size_t i = 0; i < trial->n_knowns; i++)
        if (seed[i] != 0.0)
            share = fmin(share,
                         LARGEST_SHARE * trial->instance->run.data.variables[trial->knowns[i]].nominal / fabs(seed[i]));
    return isfinite(share) ? share : 0.0;
}

/* Choose the changes by how far the inputs can go against the direction and in it. */
static void choose_offsets(TrialSteps *trial, const double *seed, double share)
{
    const Data *data = &trial->instance->run.data;
    double room[2] = {INFINITY, INFINITY};
    trial->input = NULL;
    for (size_t i = 0; i < trial->n_knowns; i++) {
        uint32_t input = trial->knowns[i];
        double value = trial->instance->run.values[input];
        if (seed[i] == 0.0)
            continue;
        trial->input = trial->input ? trial->input : name_of(data, input);
        room[seed[i] > 0.0] = fmin(room[seed[i] > 0.0], (data->maxima[input] - value) / fabs(seed[i]));
        room[seed[i] < 0.0] = fmin(room[seed[i] < 0.0], (value - data->minima[input]) / fabs(seed[i]));
    }
    double sense = room[1] >= room[0] ? 1.0 : -1.0;
    int one_sided = fmin(room[0], room[1]) < share * pow(FINER, FEWEST - LEVELS);
    trial->offsets[0] = one_sided ? sense : -1.0;
    trial->offsets[1] = one_sided ? 2.0 * sense : 1.0;
}

/* The difference quotient of the change d; `plus` and `minus` are the outputs of the changed steps. */
static double quotient(const TrialSteps *trial, double y, double plus, double minus, double d)
{
    if (trial->offsets[1] == 1.0)
        return (minus - plus) / (2.0 * d);
    return trial->offsets[0] * (4.0 * (plus - y) - (minus - y)) / (2.0 * d);
}

/* How far the slopes of the two intervals between the three outputs are apart. */
static double slopes_apart(const TrialSteps *trial, double y, double plus, double minus, double d)
{
    return fabs(trial->offsets[1] == 1.0 ? minus - 2.0 * y + plus : minus - 2.0 * plus + y) / d;
}

/* The derivative of an output; unchanged, with the reason in the log, if there is none. */
static Status extrapolate(const TrialSteps *trial, const char *call, double share, size_t j, double *result)
{
    double quotients[LEVELS], gap[LEVELS], noise[LEVELS], least = INFINITY, y = trial->outputs[j];
    double nominal = trial->instance->run.data.variables[trial->unknowns[j]].nominal; /* of a sum that is near zero */
    int best = -1;
    for (int k = 0; k < LEVELS; k++, share /= FINER) {
        double plus = outputs_at(trial, k, 0)[j], minus = outputs_at(trial, k, 1)[j];
        quotients[k] = quotient(trial, y, plus, minus, share);
        gap[k] = slopes_apart(trial, y, plus, minus, share);
        noise[k] = ROUNDINGS * DBL_EPSILON * fmax(fmax(nominal, fabs(y)), fmax(fabs(plus), fabs(minus))) / share;
        if (!k || !trial->valid[k] || !trial->valid[k - 1])
            continue;
        double change = fabs(quotients[k] - quotients[k - 1]);
        if (change < least) {
            least = change;
            best = k;
        }
    }
    const char *name = name_of(&trial->instance->run.data, trial->unknowns[j]);
    if (best < 0 || least > AGREEMENT * fabs(quotients[best]) + noise[best])
        return decline(
            trial->instance,
            "%s: %s has no derivative with respect to %s here, because differences over ever smaller changes "
            "do not agree",
            call, name, trial->input);
    int next = best + 1 < LEVELS && trial->valid[best + 1];
    double finer = next ? gap[best + 1] : gap[best], coarser = next ? gap[best] : gap[best - 1];
    int is_off = finer > 0.5 * FINER * coarser && gap[best] < noise[best] * (OFF / (ROUNDINGS * DBL_EPSILON));
    if (gap[best] > KINK * fabs(quotients[best]) + noise[best] && finer > 0.5 * coarser && !is_off)
        return decline(
            trial->instance,
            "%s: %s has no derivative with respect to %s here, because the one-sided derivatives differ by %g "
            "around %g",
            call, name, trial->input, gap[best], quotients[best]);
    *result = quotients[best] + (quotients[best] - quotients[best - 1]) / (FINER * FINER - 1.0);
    return STATUS_OK;
}

/* The status of results: OK without NaN, Warning with some, Discard if all are NaN. */
static Status status_of(const double *results, size_t n)
{
    size_t n_missing = 0;
    for (size_t j = 0; j < n; j++)
        n_missing += isnan(results[j]) != 0;
    return !n_missing ? STATUS_OK : n_missing < n ? STATUS_WARNING : STATUS_DISCARD;
}

/* Derivatives of all unknowns in a direction, NaN of those that have none. */
static Status derivatives_along(TrialSteps *trial, const char *call, const double *seed, double *results)
{
    Instance *instance = trial->instance;
    double share = first_share(trial, seed), finer = share;
    for (size_t j = 0; j < trial->n; j++)
        results[j] = share == 0.0 ? 0.0 : NAN;
    if (share == 0.0)
        return STATUS_OK;
    choose_offsets(trial, seed, share);
    int64_t fault = probe(trial, seed, 0.0, trial->outputs);
    for (int k = 0; k < LEVELS && !fault; k++, finer /= FINER) {
        int64_t first = probe(trial, seed, trial->offsets[0] * finer, outputs_at(trial, k, 0));
        trial->valid[k] = !first && !probe(trial, seed, trial->offsets[1] * finer, outputs_at(trial, k, 1));
    }
    char reason[TEXT_SIZE];
    memcpy(reason, instance->now->outcome.reason, TEXT_SIZE);
    memcpy(instance->now, trial->before, instance->saved_size);
    if (fault)
        return decline(instance, "%s: the next step cannot be taken: %s", call, reason);
    for (size_t j = 0; j < trial->n; j++)
        extrapolate(trial, call, share, j, results + j);
    return status_of(results, trial->n);
}

/* Whether all are Real inputs, or Real outputs. */
static int are_of(const Instance *instance, const uint32_t *references, size_t count, int outputs)
{
    const Data *data = &instance->run.data;
    for (size_t i = 0; i < count; i++)
        if (!is_variable(instance, references[i], TYPE_REAL) || references[i] < data->n_parameters ||
            (references[i] >= first_output(data)) != outputs)
            return 0;
    return 1;
}

/* Prepare trial steps, with their room in `block`, which is to be freed. */
static Status prepare(TrialSteps *trial, const char *call, char **block)
{
    Instance *instance = trial->instance;
    if (!may(instance, STEP_COMPLETE, call))
        return STATUS_ERROR;
    if ((trial->n && !trial->unknowns) || (trial->n_knowns && !trial->knowns))
        return fail(instance, "%s: references is NULL", call);
    if (!are_of(instance, trial->unknowns, trial->n, 1) || !are_of(instance, trial->knowns, trial->n_knowns, 0))
        return decline(instance, "%s: only Real outputs have derivatives, and only with respect to Real inputs", call);
    if (!(instance->now->outcome.step_size > 0.0))
        return decline(instance,
                       "%s: a derivative is taken over a step as long as the last one, and there has been no step",
                       call);
    size_t saved = (instance->saved_size + 15) / 16 * 16, n_columns = trial->n + trial->n_knowns;
    *block = malloc(saved + ((1 + 2 * LEVELS) * trial->n + n_columns) * sizeof(double));
    if (!*block)
        return fail(instance, "%s: there is no memory for differences", call);
    trial->before = *block;
    trial->outputs = (double *)(*block + saved);
    memcpy(trial->before, instance->now, instance->saved_size);
    return STATUS_OK;
}

Status slave_directional(Instance *instance, const char *call, const Derivatives *of, const double *seed,
                         double *results)
{
    char *block = NULL;
    TrialSteps trial = {.instance = instance,
                        .unknowns = of->unknowns,
                        .knowns = of->knowns,
                        .n = of->n_unknowns,
                        .n_knowns = of->n_knowns};
    Status status = prepare(&trial, call, &block);
    if (status == STATUS_OK && ((of->n_knowns && !seed) || (of->n_unknowns && !results)))
        status = fail(instance, "%s: %s is NULL", call, seed ? "sensitivity" : "seed");
    if (status == STATUS_OK)
        status = derivatives_along(&trial, call, seed, results);
    free(block);
    return status;
}

Status slave_adjoint(Instance *instance, const char *call, const Derivatives *of, const double *seed, double *results)
{
    char *block = NULL;
    TrialSteps trial = {.instance = instance,
                        .unknowns = of->unknowns,
                        .knowns = of->knowns,
                        .n = of->n_unknowns,
                        .n_knowns = of->n_knowns};
    Status status = prepare(&trial, call, &block);
    if (status == STATUS_OK && ((of->n_unknowns && !seed) || (of->n_knowns && !results)))
        status = fail(instance, "%s: %s is NULL", call, seed ? "sensitivity" : "seed");
    int is_ready = status == STATUS_OK;
    for (size_t i = 0; i < of->n_knowns && is_ready; i++) {
        double *column = trial.outputs + (1 + 2 * LEVELS) * trial.n, *unit = column + trial.n;
        memset(unit, 0, of->n_knowns * sizeof *unit);
        unit[i] = 1.0;
        derivatives_along(&trial, call, unit, column);
        results[i] = 0.0;
        for (size_t j = 0; j < of->n_unknowns; j++)
            results[i] += seed[j] != 0.0 ? seed[j] * column[j] : 0.0;
    }
    free(block);
    return is_ready ? status_of(results, of->n_knowns) : status;
}
