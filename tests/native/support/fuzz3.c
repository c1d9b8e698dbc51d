/* Calls of FMI 3.0 in any order with any arguments that are not pointers to nowhere.

       fuzz3 LIBRARY TOKEN RESOURCES seed count

   What comes back must be a status, and nothing else may happen. The process ends with 0 then. */

#include <dlfcn.h>
#include <stdlib.h>

#include "fmi3Functions.h"

#define FUNCTIONS(X)                                                                                                   \
    X(InstantiateCoSimulation)                                                                                         \
    X(FreeInstance)                                                                                                    \
    X(SetDebugLogging)                                                                                                 \
    X(EnterInitializationMode)                                                                                         \
    X(ExitInitializationMode)                                                                                          \
    X(DoStep)                                                                                                          \
    X(Terminate)                                                                                                       \
    X(Reset)                                                                                                           \
    X(GetFloat64)                                                                                                      \
    X(SetFloat64)                                                                                                      \
    X(GetInt32)                                                                                                        \
    X(SetInt32)                                                                                                        \
    X(GetInt64)                                                                                                        \
    X(SetInt64)                                                                                                        \
    X(GetBoolean)                                                                                                      \
    X(SetBoolean)                                                                                                      \
    X(GetString)                                                                                                       \
    X(SetUInt8)                                                                                                        \
    X(GetClock)                                                                                                        \
    X(GetFMUState)                                                                                                     \
    X(SetFMUState)                                                                                                     \
    X(FreeFMUState) X(SerializedFMUStateSize) X(SerializeFMUState) X(DeserializeFMUState) X(EnterEventMode) X(SetTime)

#define DECLARE(name) static fmi3##name##TYPE *name;
FUNCTIONS(DECLARE)

enum { N = 5, MOST = 80 };
static fmi3Instance instances[N];
static fmi3FMUState states[N];
static unsigned long long seed;

static unsigned int chance(unsigned int below)
{
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    return (unsigned int)(seed >> 33) % below;
}

static void logger(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String text)
{
    (void)environment, (void)status, (void)category;
    while (*text)
        text++;
}

static void release(unsigned int k)
{
    if (instances[k])
        FreeFMUState(instances[k], &states[k]);
    FreeInstance(instances[k]);
    instances[k] = NULL;
}

static fmi3Status through_bytes(fmi3Instance c, fmi3FMUState state)
{
    size_t size = 0;
    fmi3Status status = SerializedFMUStateSize(c, state, &size);
    if (status != fmi3OK)
        return status;
    fmi3Byte *bytes = malloc(size);
    fmi3FMUState copy = NULL;
    status = SerializeFMUState(c, state, bytes, chance(4) ? size : size / 2);
    if (status == fmi3OK) {
        for (unsigned int flips = chance(3); flips > 0; flips--)
            bytes[chance((unsigned int)size)] ^= (fmi3Byte)(1 << chance(8));
        status = DeserializeFMUState(c, bytes, chance(9) ? size : chance(8), &copy);
        if (status == fmi3OK) {
            status = SetFMUState(c, copy);
            FreeFMUState(c, &copy);
        }
    }
    free(bytes);
    return status;
}

#define CASE(number, call)                                                                                             \
    case number:                                                                                                       \
        status = call;                                                                                                 \
        break

static void call(const char *token, const char *resources)
{
    static const double numbers[] = {0.0, 1e-4, -1.0, 5.0, 1e300, 11.0};
    static const char *const words[] = {"logAll", "logStatusError", "nonsense", NULL};
    unsigned int k = chance(N), count = chance(4);
    fmi3ValueReference references[3];
    fmi3Float64 reals[MOST], last;
    fmi3Int32 integers[MOST];
    fmi3Int64 longs[MOST];
    fmi3Boolean booleans[MOST], event, terminate, early;
    fmi3String strings[MOST];
    fmi3UInt8 bytes[MOST];
    size_t n = chance(2) ? count : chance(20);
    for (int i = 0; i < MOST; i++) {
        reals[i] = numbers[chance(6)];
        integers[i] = (fmi3Int32)chance(9) - 4;
        longs[i] = chance(9) ? integers[i] : INT64_MAX;
        booleans[i] = chance(2);
        strings[i] = words[chance(4)];
        bytes[i] = 0;
    }
    for (int i = 0; i < 3; i++) /* of the first elements of arrays more often than not */
        references[i] = chance(3)
                            ? (const fmi3ValueReference[]){0, 1, 7, 10, 12, 14, 15, 17, 19, 21, 29, 30}[chance(12)]
                        : chance(9) ? chance(40)
                                    : 4294967295u;
    const fmi3ValueReference *r = chance(30) ? references : NULL;
    fmi3Instance c = instances[k];
    fmi3Status status = fmi3OK;
    switch (chance(27)) {
    case 0:
    case 1:
        if (!c)
            instances[k] =
                InstantiateCoSimulation(chance(9) ? "fuzz" : "", chance(9) ? token : strings[0],
                                        chance(9) ? resources : strings[1], false, chance(2), !chance(20), chance(2),
                                        references, chance(20) ? 0 : 1, NULL, chance(9) ? logger : NULL, NULL);
        break;
    case 2:
        if (!chance(4))
            release(k);
        break;
    case 3:
        CASE(4, EnterInitializationMode(c, false, 0.0, reals[0], chance(2), reals[1]));
    case 5:
        CASE(6, ExitInitializationMode(c));
        CASE(7, Terminate(c));
        CASE(8, Reset(c));
        CASE(9, GetFloat64(c, r, count, reals, n));
        CASE(10, SetFloat64(c, r, count, reals, n));
        CASE(11, GetInt32(c, r, count, integers, n));
        CASE(12, SetInt32(c, r, count, integers, n));
        CASE(13, GetInt64(c, r, count, longs, n));
        CASE(14, SetInt64(c, r, count, longs, n));
        CASE(15, GetBoolean(c, r, count, booleans, n));
        CASE(16, SetBoolean(c, r, count, booleans, n));
        CASE(17, GetString(c, r, count, strings, n));
        CASE(18, SetUInt8(c, r, count, bytes, n));
        CASE(19, GetClock(c, r, count, booleans));
        CASE(20, GetFMUState(c, chance(20) ? &states[k] : NULL));
        CASE(21, SetFMUState(c, states[chance(N)]));
        CASE(22, through_bytes(c, states[k]));
        CASE(23, SetDebugLogging(c, chance(2), count, chance(9) ? strings : NULL));
        CASE(24, chance(2) ? EnterEventMode(c) : SetTime(c, reals[0]));
    default:
        status = DoStep(c, reals[0], chance(9) ? 250e-6 : reals[1], true, chance(9) ? &event : NULL, &terminate, &early,
                        chance(9) ? &last : NULL);
    }
    if (status < fmi3OK || status > fmi3Error)
        exit(20);
    if (status == fmi3Error && chance(2)) { /* or most of the calls would find the error state */
        Reset(c);
        EnterInitializationMode(c, false, 0.0, 0.0, false, 0.0);
        if (chance(4))
            ExitInitializationMode(c);
    }
}

int main(int count, char **arguments)
{
    if (count != 6)
        return 10;
    void *library = dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL);
    if (!library)
        return 11;
#define LOOK_UP(name)                                                                                                  \
    if (!(name = (fmi3##name##TYPE *)dlsym(library, "fmi3" #name)))                                                    \
        return 12;
    FUNCTIONS(LOOK_UP)
    seed = strtoull(arguments[4], NULL, 10);
    for (long left = strtol(arguments[5], NULL, 10); left > 0; left--)
        call(arguments[2], arguments[3]);
    for (unsigned int k = 0; k < N; k++)
        release(k);
    return 0;
}
