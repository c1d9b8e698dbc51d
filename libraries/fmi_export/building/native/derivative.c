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

/* Room for the answers to a direction: y0, and the two others of each level, each of `n` outputs. */
typedef struct {
    Instance *instance;
    void *before; /* the saved state of the instance */
    const uint32_t *unknowns, *knowns;
    size_t n, n_knowns;
    double *answers;
    int valid[LEVELS];
    double places[2];  /* where the others are, in units of d: -1 and 1, or 1 and 2, or -1 and -2 */
    const char *input; /* the first of the direction, for messages */
} Question;

static double *answer(const Question *question, int level, int other)
{
    return question->answers + question->n * (size_t)(1 + 2 * level + other);
}

/* Take a step with inputs changed by `share` times the seed, and keep its outputs; 0, or its fault. */
static int64_t probe(const Question *question, const double *seed, double share, double *outputs)
{
    Instance *instance = question->instance;
    memcpy(instance->now, question->before, instance->saved_size);
    for (size_t i = 0; i < question->n_knowns; i++)
        instance->run.values[question->knowns[i]] += share * seed[i];
    int64_t fault = run_step(&instance->run, instance->now->time, instance->now->outcome.step_size);
    for (size_t j = 0; j < question->n; j++)
        outputs[j] = instance->run.values[question->unknowns[j]];
    return fault;
}

/* The largest share of a seed, by the nominal sizes of its inputs; 0 of a seed that is zero. */
static double first_share(const Question *question, const double *seed)
{
    double share = INFINITY;
    for (size_t i = 0; i < question->n_knowns; i++)
        if (seed[i] != 0.0)
            share = fmin(share, LARGEST_SHARE * question->instance->run.data.variables[question->knowns[i]].nominal /
                                    fabs(seed[i]));
    return isfinite(share) ? share : 0.0;
}

/* Choose where the others are, by how far the inputs can go against the direction and in it. */
static void choose_places(Question *question, const double *seed, double share)
{
    const Data *data = &question->instance->run.data;
    double room[2] = {INFINITY, INFINITY};
    question->input = NULL;
    for (size_t i = 0; i < question->n_knowns; i++) {
        uint32_t input = question->knowns[i];
        double value = question->instance->run.values[input];
        if (seed[i] == 0.0)
            continue;
        question->input = question->input ? question->input : name_of(data, input);
        room[seed[i] > 0.0] = fmin(room[seed[i] > 0.0], (data->maxima[input] - value) / fabs(seed[i]));
        room[seed[i] < 0.0] = fmin(room[seed[i] < 0.0], (value - data->minima[input]) / fabs(seed[i]));
    }
    double sense = room[1] >= room[0] ? 1.0 : -1.0;
    int one_sided = fmin(room[0], room[1]) < share * pow(FINER, FEWEST - LEVELS);
    question->places[0] = one_sided ? sense : -1.0;
    question->places[1] = one_sided ? 2.0 * sense : 1.0;
}

/* The difference quotient of the change d; `plus` and `minus` are the answers there. */
static double quotient(const Question *question, double y, double plus, double minus, double d)
{
    if (question->places[1] == 1.0)
        return (minus - plus) / (2.0 * d);
    return question->places[0] * (4.0 * (plus - y) - (minus - y)) / (2.0 * d);
}

/* How far the slopes of the two intervals between the three answers are apart. */
static double slopes_apart(const Question *question, double y, double plus, double minus, double d)
{
    return fabs(question->places[1] == 1.0 ? minus - 2.0 * y + plus : minus - 2.0 * plus + y) / d;
}

/* The derivative of an output; unchanged, with the reason in the log, if there is none. */
static Status settle(const Question *question, const char *call, double share, size_t j, double *result)
{
    double quotients[LEVELS], gap[LEVELS], noise[LEVELS], least = INFINITY, y = question->answers[j];
    double nominal =
        question->instance->run.data.variables[question->unknowns[j]].nominal; /* of a sum that is near zero */
    int best = -1;
    for (int k = 0; k < LEVELS; k++, share /= FINER) {
        double plus = answer(question, k, 0)[j], minus = answer(question, k, 1)[j];
        quotients[k] = quotient(question, y, plus, minus, share);
        gap[k] = slopes_apart(question, y, plus, minus, share);
        noise[k] = ROUNDINGS * DBL_EPSILON * fmax(fmax(nominal, fabs(y)), fmax(fabs(plus), fabs(minus))) / share;
        if (!k || !question->valid[k] || !question->valid[k - 1])
            continue;
        double change = fabs(quotients[k] - quotients[k - 1]);
        if (change < least) {
            least = change;
            best = k;
        }
    }
    const char *name = name_of(&question->instance->run.data, question->unknowns[j]);
    if (best < 0 || least > AGREEMENT * fabs(quotients[best]) + noise[best])
        return decline(question->instance,
                       "%s: %s has no derivative by %s here, differences over ever smaller changes do not agree", call,
                       name, question->input);
    int next = best + 1 < LEVELS && question->valid[best + 1];
    double finer = next ? gap[best + 1] : gap[best], coarser = next ? gap[best] : gap[best - 1];
    int is_off = finer > 0.5 * FINER * coarser && gap[best] < noise[best] * (OFF / (ROUNDINGS * DBL_EPSILON));
    if (gap[best] > KINK * fabs(quotients[best]) + noise[best] && finer > 0.5 * coarser && !is_off)
        return decline(question->instance,
                       "%s: %s has no derivative by %s here, which differs to both sides by %g of %g", call, name,
                       question->input, gap[best], quotients[best]);
    *result = quotients[best] + (quotients[best] - quotients[best - 1]) / (FINER * FINER - 1.0);
    return STATUS_OK;
}

/* The status of an answer: OK without NaN, Warning with some, Discard if all are NaN. */
static Status status_of(const double *results, size_t n)
{
    size_t n_missing = 0;
    for (size_t j = 0; j < n; j++)
        n_missing += isnan(results[j]) != 0;
    return !n_missing ? STATUS_OK : n_missing < n ? STATUS_WARNING : STATUS_DISCARD;
}

/* Derivatives of all unknowns in a direction, NaN of those that have none. */
static Status ask(Question *question, const char *call, const double *seed, double *results)
{
    Instance *instance = question->instance;
    double share = first_share(question, seed), finer = share;
    for (size_t j = 0; j < question->n; j++)
        results[j] = share == 0.0 ? 0.0 : NAN;
    if (share == 0.0)
        return STATUS_OK;
    choose_places(question, seed, share);
    int64_t fault = probe(question, seed, 0.0, question->answers);
    for (int k = 0; k < LEVELS && !fault; k++, finer /= FINER) {
        int64_t first = probe(question, seed, question->places[0] * finer, answer(question, k, 0));
        question->valid[k] = !first && !probe(question, seed, question->places[1] * finer, answer(question, k, 1));
    }
    char reason[TEXT_SIZE];
    memcpy(reason, instance->now->outcome.reason, TEXT_SIZE);
    memcpy(instance->now, question->before, instance->saved_size);
    if (fault)
        return decline(instance, "%s: the next step cannot be taken: %s", call, reason);
    for (size_t j = 0; j < question->n; j++)
        settle(question, call, share, j, results + j);
    return status_of(results, question->n);
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

/* Make a question ready, its room in `block`, which is to be freed. */
static Status prepare(Question *question, const char *call, char **block)
{
    Instance *instance = question->instance;
    if (!may(instance, STEP_COMPLETE, call))
        return STATUS_ERROR;
    if ((question->n && !question->unknowns) || (question->n_knowns && !question->knowns))
        return fail(instance, "%s: references is NULL", call);
    if (!are_of(instance, question->unknowns, question->n, 1) ||
        !are_of(instance, question->knowns, question->n_knowns, 0))
        return decline(instance, "%s: there are derivatives of Real outputs by Real inputs alone", call);
    if (!(instance->now->outcome.step_size > 0.0))
        return decline(instance, "%s: derivatives are those over a step of the size of the last one; there was none",
                       call);
    size_t saved = (instance->saved_size + 15) / 16 * 16, n_columns = question->n + question->n_knowns;
    *block = malloc(saved + ((1 + 2 * LEVELS) * question->n + n_columns) * sizeof(double));
    if (!*block)
        return fail(instance, "%s: there is no memory for differences", call);
    question->before = *block;
    question->answers = (double *)(*block + saved);
    memcpy(question->before, instance->now, instance->saved_size);
    return STATUS_OK;
}

Status slave_directional(Instance *instance, const char *call, const Derivatives *of, const double *seed,
                         double *results)
{
    char *block = NULL;
    Question question = {.instance = instance,
                         .unknowns = of->unknowns,
                         .knowns = of->knowns,
                         .n = of->n_unknowns,
                         .n_knowns = of->n_knowns};
    Status status = prepare(&question, call, &block);
    if (status == STATUS_OK && ((of->n_knowns && !seed) || (of->n_unknowns && !results)))
        status = fail(instance, "%s: %s is NULL", call, seed ? "sensitivity" : "seed");
    if (status == STATUS_OK)
        status = ask(&question, call, seed, results);
    free(block);
    return status;
}

Status slave_adjoint(Instance *instance, const char *call, const Derivatives *of, const double *seed, double *results)
{
    char *block = NULL;
    Question question = {.instance = instance,
                         .unknowns = of->unknowns,
                         .knowns = of->knowns,
                         .n = of->n_unknowns,
                         .n_knowns = of->n_knowns};
    Status status = prepare(&question, call, &block);
    if (status == STATUS_OK && ((of->n_unknowns && !seed) || (of->n_knowns && !results)))
        status = fail(instance, "%s: %s is NULL", call, seed ? "sensitivity" : "seed");
    int can_ask = status == STATUS_OK;
    for (size_t i = 0; i < of->n_knowns && can_ask; i++) {
        double *column = question.answers + (1 + 2 * LEVELS) * question.n, *unit = column + question.n;
        memset(unit, 0, of->n_knowns * sizeof *unit);
        unit[i] = 1.0;
        ask(&question, call, unit, column);
        results[i] = 0.0;
        for (size_t j = 0; j < of->n_unknowns; j++)
            results[i] += seed[j] != 0.0 ? seed[j] * column[j] : 0.0;
    }
    free(block);
    return can_ask ? status_of(results, of->n_knowns) : status;
}
