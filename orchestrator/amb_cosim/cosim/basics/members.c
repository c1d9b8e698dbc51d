/* The loop once more under a separate name: glibc has an old function `advance` too, and calls within a library go
 * through the names of all. */
#define advance advance_points
#include "loop.c"

/* The first change at point n or later. */
static intptr_t first_from(const Changes *changes, intptr_t n)
{
    intptr_t low = 0, high = changes->size;
    while (low < high) {
        intptr_t middle = low + (high - low) / 2;
        if (changes->points[middle] < n)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

EXPORT void advance_members(const Program *const *programs, const Changes *const *changes, intptr_t *points,
                            const bool *rests, intptr_t begin, intptr_t stop, intptr_t steps,
                            const volatile bool *pause, End *ends);

/* Steps members of a batch in sequence, those from `begin` to `stop`, the latter excluded, but not those that
 * rest. A member goes `steps` points on from its own, which is then another; if a step fails it stays where that is.
 * Outputs that nothing but the host reads are fetched at the end. */
void advance_members(const Program *const *programs, const Changes *const *changes, intptr_t *points, const bool *rests,
                     intptr_t begin, intptr_t stop, intptr_t steps, const volatile bool *pause, End *ends)
{
    for (intptr_t i = begin; i < stop; i++) {
        if (rests[i])
            continue;
        intptr_t n = points[i], first = first_from(changes[i], n);
        const Changes due = {changes[i]->points + first, changes[i]->positions + first, changes[i]->values + first,
                             changes[i]->size - first};
        const RecordBuffer nothing = {.first = n + steps, .every = 1};
        const Conditions none = {0};
        advance_points(programs[i], &due, &nothing, &none, 0, n, n + steps, INTPTR_MAX, pause, &ends[i]);
        points[i] = ends[i].status >= 0 && ends[i].status <= LOOP_WARNING ? n + steps : ends[i].reached;
    }
}
