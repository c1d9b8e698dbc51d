#include "loop.h"

enum { SEND, STEP, FETCH };

/* Whether a call succeeded; a status that FMI does not define counts as a failure. */
static bool is_good(int status) { return status >= 0 && status <= LOOP_WARNING; }

static int call(const Program *p, const Calls *calls, intptr_t i, intptr_t c)
{
    size_t size = (size_t)(calls->first[c + 1] - calls->first[c]);
    return calls->function[c](p->instance[i], calls->references_at[c], size, calls->values_at[c]);
}

static int send(const Program *p, intptr_t i)
{
    const Calls *calls = &p->sends;
    for (intptr_t c = calls->of[i]; c < calls->of[i + 1]; c++) {
        for (intptr_t k = calls->first[c]; k < calls->first[c + 1]; k++) {
            double value = p->values[calls->positions[k]];
            if (calls->real[c])
                calls->reals[k] = value;
            else
                calls->integers[k] = (int32_t)value;
        }
        int status = call(p, calls, i, c);
        if (!is_good(status))
            return status;
    }
    return 0;
}

/* Whether a point from n + 1 to n + `every` is recorded; those see the outputs fetched at point n. */
static bool is_recorded(const RecordBuffer *buffer, intptr_t n, intptr_t every)
{
    intptr_t earliest = n + 1 > buffer->first ? n + 1 : buffer->first;
    intptr_t over = earliest % buffer->every;
    intptr_t next = over == 0 ? earliest : over > 0 ? earliest - over + buffer->every : earliest - over;
    return next <= n + every;
}

static int fetch(const Program *p, const RecordBuffer *buffer, intptr_t i, intptr_t n)
{
    const Calls *calls = is_recorded(buffer, n, p->every[i]) ? &p->fetches : &p->needed;
    for (intptr_t c = calls->of[i]; c < calls->of[i + 1]; c++) {
        int status = call(p, calls, i, c);
        if (!is_good(status))
            return status;
        if (calls->direct[c])
            continue;
        for (intptr_t k = calls->first[c]; k < calls->first[c + 1]; k++)
            p->values[calls->positions[k]] = calls->real[c] ? calls->reals[k] : (double)calls->integers[k];
    }
    return 0;
}

static int step(const Program *p, intptr_t i, intptr_t n)
{
    double time = p->start_time + (double)n * p->step_size;
    return p->do_step[i](p->instance[i], time, p->step_sizes[i], 1);
}

/* Makes a call of component i at point n; returns whether it succeeded, and stores a failure. */
static bool done(const Program *p, const RecordBuffer *buffer, intptr_t i, intptr_t n, int what, End *end)
{
    int status = what == SEND ? send(p, i) : what == STEP ? step(p, i, n) : fetch(p, buffer, i, n);
    if (is_good(status))
        return true;
    end->component = i, end->call = what, end->status = status;
    return false;
}

static bool gauss_seidel(const Program *p, const RecordBuffer *buffer, intptr_t n, End *end)
{
    for (intptr_t i = 0; i < p->size; i++)
        if (n % p->every[i] == 0)
            for (int what = SEND; what <= FETCH; what++)
                if (!done(p, buffer, i, n, what, end))
                    return false;
    return true;
}

static bool jacobi(const Program *p, const RecordBuffer *buffer, intptr_t n, End *end)
{
    for (int what = SEND; what <= FETCH; what++)
        for (intptr_t i = 0; i < p->size; i++)
            if ((what == FETCH ? n + 1 : n) % p->every[i] == 0)
                if (!done(p, buffer, i, n, what, end))
                    return false;
    return true;
}

/* The first condition that is met at point n, or -1. */
static intptr_t condition_met(const Conditions *c, const double *values, intptr_t n)
{
    for (intptr_t k = 0; k < c->size; k++) {
        if (n < c->since[k])
            continue;
        if (!(c->signs[k] * values[c->positions[k]] > c->signs[k] * c->limits[k]))
            c->since[k] = n + 1;
        else if (n - c->since[k] >= c->hold[k])
            return k;
    }
    return -1;
}

void advance(const Program *p, const Changes *changes, const RecordBuffer *buffer, const Conditions *conditions,
             intptr_t row, intptr_t begin, intptr_t stop, intptr_t last, const volatile bool *pause, End *end)
{
    intptr_t change = 0;
    *end = (End){stop - 1, row, 0, 0, 0, -1};
    for (intptr_t n = begin; n < stop; n++) {
        for (; change < changes->size && changes->points[change] == n; change++)
            p->values[changes->positions[change]] = changes->values[change];
        if (n >= buffer->first && buffer->steps_size > 0) {
            double *to = buffer->steps_table + (n - buffer->steps_first) * buffer->steps_size;
            for (intptr_t column = 0; column < buffer->steps_size; column++)
                to[column] = p->values[buffer->steps_positions[column]];
        }
        if (n >= buffer->first && n % buffer->every == 0) {
            double *to = buffer->table + end->row * buffer->size;
            for (intptr_t column = 0; column < buffer->size; column++)
                to[column] = p->values[buffer->positions[column]];
            buffer->points[end->row++] = n;
        }
        end->met = condition_met(conditions, p->values, n);
        bool stepped =
            end->met < 0 && (n >= last || (p->jacobi ? jacobi(p, buffer, n, end) : gauss_seidel(p, buffer, n, end)));
        if (!stepped || *pause) {
            end->reached = n;
            return;
        }
    }
}
