/* An FMU of FMI 3.0 that hands on arrays of every number type, one step later, and misbehaves as its input `what`
   says. */
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define TYPES(M)                                                                                                       \
    M(Float64, double, 0)                                                                                              \
    M(Float32, float, 1)                                                                                               \
    M(Int8, int8_t, 2)                                                                                                 \
    M(UInt8, uint8_t, 3)                                                                                               \
    M(Int16, int16_t, 4)                                                                                               \
    M(UInt16, uint16_t, 5)                                                                                             \
    M(Int32, int32_t, 6) M(UInt32, uint32_t, 7) M(Int64, int64_t, 8) M(UInt64, uint64_t, 9) M(Boolean, bool, 10)
enum { GOOD, END, EARLY, MINUS_ONE, WARN, FAIL };
enum { WHAT = 100, MATRIX, SUM, CHOICE, CHOSEN }; /* of MATRIX * (1 2 3 4 5 6) */

typedef void (*Logger)(void *, int, const char *, const char *);
typedef struct {
#define FIELDS(name, type, k) type in_##name[2], out_##name[2];
    TYPES(FIELDS)
    double matrix[6], sum;
    int32_t what;
    int64_t choice, chosen;
} Values;
typedef struct {
    Values now;
    Logger log;
    void *environment;
} Instance;

static const Values START = {.matrix = {1.0, 2.0, 3.0, 4.0, 5.0, 6.0}, .choice = 1};

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible,
                                  bool logging, bool events, bool early, const uint32_t *intermediate, size_t n,
                                  void *environment, Logger log, void *update)
{
    if (events || early || n)
        return NULL;
    Instance *self = calloc(1, sizeof *self);
    *self = (Instance){START, log, environment};
    return self;
}
int fmi3Reset(Instance *self)
{
    self->now = START;
    return 0;
}

/* What a reference stands for, and its size in bytes; NULL where there is none. */
#define PLACE(name, type, k)                                                                                           \
    static void *place_##name(Values *v, uint32_t reference, size_t *size)                                             \
    {                                                                                                                  \
        *size = 2 * sizeof(type);                                                                                      \
        if (reference == 1 + 2 * k)                                                                                    \
            return v->in_##name;                                                                                       \
        if (reference == 2 + 2 * k)                                                                                    \
            return v->out_##name;                                                                                      \
        *size = reference == MATRIX ? sizeof v->matrix : sizeof(type);                                                 \
        if (k == 0 && (reference == MATRIX || reference == SUM))                                                       \
            return reference == SUM ? &v->sum : v->matrix;                                                             \
        if (k == 8 && (reference == CHOICE || reference == CHOSEN))                                                    \
            return reference == CHOICE ? &v->choice : &v->chosen;                                                      \
        return k == 6 && reference == WHAT ? &v->what : NULL;                                                          \
    }
TYPES(PLACE)

#define EXCHANGE(name, type, k)                                                                                        \
    int fmi3Get##name(Instance *self, const uint32_t *references, size_t n, type *values, size_t n_values)             \
    {                                                                                                                  \
        for (size_t i = 0, size; i < n; i++, values += size / sizeof(type), n_values -= size / sizeof(type)) {         \
            const void *place = place_##name(&self->now, references[i], &size);                                        \
            if (!place || size / sizeof(type) > n_values)                                                              \
                return 3;                                                                                              \
            memcpy(values, place, size);                                                                               \
        }                                                                                                              \
        return n_values ? 3 : 0;                                                                                       \
    }                                                                                                                  \
    int fmi3Set##name(Instance *self, const uint32_t *references, size_t n, const type *values, size_t n_values)       \
    {                                                                                                                  \
        for (size_t i = 0, size; i < n; i++, values += size / sizeof(type), n_values -= size / sizeof(type)) {         \
            void *place = place_##name(&self->now, references[i], &size);                                              \
            if (!place || size / sizeof(type) > n_values)                                                              \
                return 3;                                                                                              \
            memcpy(place, values, size);                                                                               \
        }                                                                                                              \
        return n_values ? 3 : 0;                                                                                       \
    }
TYPES(EXCHANGE)

int fmi3DoStep(Instance *self, double time, double step, bool no_way_back, bool *event, bool *end, bool *early,
               double *reached)
{
    Values *v = &self->now;
#define HAND_ON(name, type, k) memcpy(v->out_##name, v->in_##name, sizeof v->in_##name);
    TYPES(HAND_ON)
    v->chosen = v->choice;
    v->sum = 0.0;
    for (int k = 0; k < 6; k++)
        v->sum += (k + 1) * v->matrix[k];
    *event = true; /* which a host without event mode leaves alone */
    *end = v->what == END, *early = v->what == EARLY, *reached = time + step;
    if (v->what == WARN)
        self->log(self->environment, 1, NULL, "it is warm, 100 %");
    if (v->what == FAIL)
        self->log(self->environment, 3, "logStatusError", "it is hot");
    return v->what == MINUS_ONE ? -1 : v->what == WARN ? 1 : v->what == FAIL ? 3 : 0;
}

int fmi3GetFMUState(Instance *self, Values **state)
{
    if (!*state)
        *state = malloc(sizeof **state);
    **state = self->now;
    return 0;
}
int fmi3SetFMUState(Instance *self, const Values *state)
{
    self->now = *state;
    return 0;
}
int fmi3FreeFMUState(Instance *self, Values **state)
{
    free(*state);
    *state = NULL;
    return 0;
}
int fmi3SerializedFMUStateSize(Instance *self, Values *state, size_t *size)
{
    *size = sizeof *state;
    return 0;
}
int fmi3SerializeFMUState(Instance *self, Values *state, void *bytes, size_t size)
{
    memcpy(bytes, state, size);
    return 0;
}
int fmi3DeserializeFMUState(Instance *self, const void *bytes, size_t size, Values **state)
{
    *state = memcpy(malloc(size), bytes, size);
    return 0;
}
