/* A host without Python: loads one FMU library and does what the lines of its standard input say.

       host LIBRARY GUID RESOURCES < program

       new K            instantiate number K (0 to 9)       free K
       setup K t        enter K    exit K    reset K    terminate K
       real|integer|boolean K reference value               set
       read K reference...                                  print Reals, as hexadecimal numbers
       step K n count h                                     steps n, n + 1, ... of size h, until one is refused
       save K    restore K    bytes K                       a state; the last: through bytes into a new one
       fuzz seed count                                      calls in any order with any arguments
       threads number count                                 the same in several threads, each with its own instances

   Each command but the last prints one line that begins with the status. The process ends with 0 if the end of the
   program was reached. The logger writes to standard error.

   Compiled with FUZZED it is a target for libFuzzer instead, whose bytes choose the calls; LIBRARY, GUID and RESOURCES
   come from the environment. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "logger.h"

#ifdef _WIN32
#include <windows.h>
#define open_library(path) (void *)LoadLibraryA(path)
#define symbol(library, name) (void *)GetProcAddress((HMODULE)library, name)
#define GetVersion fmu_GetVersion /* Windows has one too */
#else
#include <dlfcn.h>
#include <pthread.h>
#define open_library(path) dlopen(path, RTLD_NOW | RTLD_LOCAL)
#define symbol(library, name) dlsym(library, name)
#endif

#define FUNCTIONS(X)                                                                                                   \
    X(GetTypesPlatform)                                                                                                \
    X(GetVersion)                                                                                                      \
    X(SetDebugLogging)                                                                                                 \
    X(Instantiate)                                                                                                     \
    X(FreeInstance)                                                                                                    \
    X(SetupExperiment)                                                                                                 \
    X(EnterInitializationMode)                                                                                         \
    X(ExitInitializationMode)                                                                                          \
    X(Terminate)                                                                                                       \
    X(Reset)                                                                                                           \
    X(GetReal)                                                                                                         \
    X(GetInteger)                                                                                                      \
    X(GetBoolean)                                                                                                      \
    X(GetString)                                                                                                       \
    X(SetReal)                                                                                                         \
    X(SetInteger)                                                                                                      \
    X(SetBoolean)                                                                                                      \
    X(SetString)                                                                                                       \
    X(GetFMUstate)                                                                                                     \
    X(SetFMUstate)                                                                                                     \
    X(FreeFMUstate)                                                                                                    \
    X(SerializedFMUstateSize)                                                                                          \
    X(SerializeFMUstate)                                                                                               \
    X(DeSerializeFMUstate)                                                                                             \
    X(GetDirectionalDerivative)                                                                                        \
    X(SetRealInputDerivatives)                                                                                         \
    X(GetRealOutputDerivatives)                                                                                        \
    X(DoStep) X(CancelStep) X(GetStatus) X(GetRealStatus) X(GetIntegerStatus) X(GetBooleanStatus) X(GetStringStatus)

#define DECLARE(name) static __typeof__(&fmi2##name) name;
FUNCTIONS(DECLARE)

enum { N = 10 };
static _Thread_local fmi2Component instances[N];
static _Thread_local fmi2FMUstate states[N];

static const fmi2CallbackFunctions callbacks = {logger, calloc, free, NULL, NULL};

static void quiet_logger(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                         fmi2String text, ...)
{
    char line[4096];
    va_list arguments;
    (void)environment, (void)name, (void)status, (void)category;
    va_start(arguments, text);
    vsnprintf(line, sizeof line, text, arguments);
    va_end(arguments);
}

static const fmi2CallbackFunctions quiet = {quiet_logger, calloc, free, NULL, NULL};

static void release(int k)
{
    if (instances[k])
        FreeFMUstate(instances[k], &states[k]);
    FreeInstance(instances[k]);
    instances[k] = NULL;
}

static _Thread_local unsigned long long seed;

#ifdef FUZZED
static const unsigned char *bytes_left;
static size_t n_left;
#endif

static unsigned int chance(unsigned int below)
{
#ifdef FUZZED
    if (n_left > 0) {
        n_left--;
        return *bytes_left++ % below;
    }
#endif
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    return (unsigned int)(seed >> 33) % below;
}

#define CASE(number, call)                                                                                             \
    case number:                                                                                                       \
        status = call;                                                                                                 \
        break

/* Any call with any arguments that are not pointers to nowhere: what comes back must be a status, and nothing else may
   happen. States are only given to the library that made them. */
static void fuzz_once(const char *guid, const char *resources)
{
    static const double numbers[] = {0.0, 1e-4, -1.0, 5.0, 1e300, -7.0, 11.0};
    static const char *const words[] = {"logAll", "logStatusError", "nonsense", NULL};
    unsigned int k = chance(N), count = chance(3) ? 1 : chance(4);
    fmi2ValueReference references[3];
    fmi2Real reals[3];
    fmi2Integer integers[3] = {(int)chance(3), 1, 6};
    fmi2String strings[3] = {words[chance(4)], words[chance(4)], words[chance(4)]};
    fmi2Component c = instances[k];
    fmi2Status status = fmi2OK;
    fmi2Real not_finite = chance(2) ? 1e308 * 10.0 : (1e308 * 10.0) * 0.0;
    size_t size = 0;
    for (int i = 0; i < 3; i++) {
        references[i] = chance(4) ? chance(10) : chance(9) ? chance(160) : 4294967295u;
        reals[i] = chance(20) ? numbers[chance(7)] : not_finite;
    }
    const fmi2ValueReference *r = chance(30) ? references : NULL;
    fmi2Real *v = chance(30) ? reals : NULL;
    if (count == 3 && (!r || !v))
        count = 2;
    switch (chance(32)) {
    case 0:
    case 1:
        if (!c)
            instances[k] = Instantiate(chance(9) ? "fuzz" : "", chance(9) ? fmi2CoSimulation : fmi2ModelExchange,
                                       chance(9) ? guid : strings[0], chance(9) ? resources : strings[1],
                                       chance(9) ? &quiet : NULL, 0, chance(2));
        break;
    case 2:
        if (!chance(4))
            release((int)k);
        break;
        CASE(3, SetupExperiment(c, 0, 0.0, reals[0], (int)chance(2), reals[1]));
    case 4:
        CASE(5, EnterInitializationMode(c));
    case 6:
        CASE(7, ExitInitializationMode(c));
    case 8:
        if (!chance(3))
            status = Terminate(c);
        break;
        CASE(9, Reset(c));
        CASE(10, SetReal(c, r, count, v));
        CASE(11, SetInteger(c, r, count, integers));
        CASE(12, SetBoolean(c, r, count, integers));
        CASE(13, GetReal(c, r, count, v));
        CASE(14, GetInteger(c, r, count, integers));
        CASE(15, GetBoolean(c, r, count, integers));
        CASE(16, GetString(c, r, count, strings));
        CASE(17, SetString(c, r, count, strings));
        CASE(18, GetFMUstate(c, chance(20) ? &states[k] : NULL));
        CASE(19, SetFMUstate(c, states[chance(N)]));
        CASE(20, FreeFMUstate(c, chance(20) ? &states[k] : NULL));
    case 21: {
        status = SerializedFMUstateSize(c, states[k], &size);
        if (status == fmi2OK) {
            fmi2Byte *bytes = malloc(size);
            status = SerializeFMUstate(c, states[k], bytes, chance(4) ? size : size / 2);
            if (status == fmi2OK) {
                fmi2FMUstate copy = NULL;
                for (unsigned int flips = chance(3); flips > 0; flips--)
                    bytes[chance(2) ? chance((unsigned int)size) : chance(64)] ^= (char)(1 << chance(8));
                status = DeSerializeFMUstate(c, chance(20) ? bytes : NULL, chance(9) ? size : chance(8), &copy);
                if (status == fmi2OK) {
                    status = SetFMUstate(c, copy);
                    FreeFMUstate(c, &copy);
                }
            }
            free(bytes);
        }
        break;
    }
        CASE(22, SetDebugLogging(c, (int)chance(2), count, chance(9) ? strings : NULL));
        CASE(23, GetStatus(c, (fmi2StatusKind)chance(5), &status));
        CASE(24, GetRealStatus(c, (fmi2StatusKind)chance(5), chance(9) ? reals : NULL));
        CASE(25, GetBooleanStatus(c, (fmi2StatusKind)chance(5), chance(9) ? integers : NULL));
        CASE(26, GetIntegerStatus(c, (fmi2StatusKind)chance(5), NULL));
        CASE(27, CancelStep(c));
        CASE(28, GetDirectionalDerivative(c, r, count, r, count, v, v));
    default:
        status = DoStep(c, reals[0], chance(9) ? 250e-6 : chance(2) ? not_finite : -1e-4 * chance(2), 1);
        break;
    }
    if (status < fmi2OK || status > fmi2Fatal)
        exit(20);
    if (status == fmi2Error && chance(2)) { /* or most of the calls would find the error state */
        Reset(c);
        EnterInitializationMode(c);
        if (chance(4))
            ExitInitializationMode(c);
    }
}

static void fuzz(unsigned int from, long count, const char *guid, const char *resources)
{
    for (seed = from; count > 0; count--)
        fuzz_once(guid, resources);
    for (int i = 0; i < N; i++)
        release(i);
}

#ifndef _WIN32
typedef struct {
    unsigned int seed;
    long count;
    const char *guid, *resources;
} Work;

static void *fuzz_thread(void *given)
{
    const Work *work = given;
    fuzz(work->seed, work->count, work->guid, work->resources);
    return NULL;
}

static void fuzz_in_threads(unsigned int number, long count, const char *guid, const char *resources)
{
    enum { MOST = 16 };
    pthread_t threads[MOST];
    Work work[MOST];
    for (unsigned int i = 0; i < number && i < MOST; i++) {
        work[i] = (Work){i + 1, count, guid, resources};
        if (pthread_create(&threads[i], NULL, fuzz_thread, &work[i]))
            exit(21);
    }
    for (unsigned int i = 0; i < number && i < MOST; i++)
        pthread_join(threads[i], NULL);
}
#endif

static int run_line(char *line, const char *guid, const char *resources)
{
    char command[16];
    unsigned int k = 0, reference = 0;
    int used = 0;
    double number = 0.0;
    if (sscanf(line, "%15s %u%n", command, &k, &used) < 2)
        return 0;
    char *rest = line + used;
    if (strcmp(command, "fuzz") == 0) {
        fuzz(k, strtol(rest, NULL, 10), guid, resources);
        return 1;
    }
#ifndef _WIN32
    if (strcmp(command, "threads") == 0) {
        fuzz_in_threads(k, strtol(rest, NULL, 10), guid, resources);
        return 1;
    }
#endif
    if (k >= N)
        return 0;
    fmi2Component c = instances[k];
    fmi2Status status = fmi2OK;
    if (strcmp(command, "new") == 0) {
        char name[] = "fmu0";
        name[3] = (char)('0' + k);
        instances[k] = Instantiate(name, fmi2CoSimulation, guid, resources, &callbacks, fmi2False, fmi2True);
        status = instances[k] ? fmi2OK : fmi2Error;
    } else if (strcmp(command, "free") == 0)
        release((int)k);
    else if (strcmp(command, "setup") == 0)
        status = SetupExperiment(c, fmi2False, 0.0, strtod(rest, NULL), fmi2False, 0.0);
    else if (strcmp(command, "enter") == 0)
        status = EnterInitializationMode(c);
    else if (strcmp(command, "exit") == 0)
        status = ExitInitializationMode(c);
    else if (strcmp(command, "reset") == 0)
        status = Reset(c);
    else if (strcmp(command, "terminate") == 0)
        status = Terminate(c);
    else if (strcmp(command, "real") == 0 || strcmp(command, "integer") == 0 || strcmp(command, "boolean") == 0) {
        reference = (unsigned int)strtoul(rest, &rest, 10);
        number = strtod(rest, NULL);
        int integer = (int)number;
        status = *command == 'r'   ? SetReal(c, &reference, 1, &number)
                 : *command == 'i' ? SetInteger(c, &reference, 1, &integer)
                                   : SetBoolean(c, &reference, 1, &integer);
    } else if (strcmp(command, "read") == 0) {
        fmi2ValueReference references[256];
        fmi2Real values[256];
        size_t count = 0;
        char *end = rest;
        for (;; rest = end) {
            references[count] = (unsigned int)strtoul(rest, &end, 10);
            if (end == rest || count == 256)
                break;
            count++;
        }
        status = GetReal(c, count ? references : NULL, count, count ? values : NULL);
        printf("%d", status);
        for (size_t i = 0; i < count && status <= fmi2Warning; i++)
            printf(" %a", values[i]);
        putchar('\n');
        return 1;
    } else if (strcmp(command, "step") == 0) {
        long n = strtol(rest, &rest, 10), count = strtol(rest, &rest, 10);
        number = strtod(rest, NULL);
        for (long i = n; i < n + count && status == fmi2OK; i++)
            status = DoStep(c, (double)i * number, number, fmi2True);
    } else if (strcmp(command, "save") == 0)
        status = GetFMUstate(c, &states[k]);
    else if (strcmp(command, "restore") == 0)
        status = SetFMUstate(c, states[k]);
    else if (strcmp(command, "bytes") == 0) {
        size_t size = 0;
        status = SerializedFMUstateSize(c, states[k], &size);
        fmi2Byte *bytes = malloc(size);
        if (status == fmi2OK)
            status = SerializeFMUstate(c, states[k], bytes, size);
        FreeFMUstate(c, &states[k]);
        if (status == fmi2OK)
            status = DeSerializeFMUstate(c, bytes, size, &states[k]);
        free(bytes);
    } else
        return 0;
    printf("%d\n", status);
    return 1;
}

static int load(const char *path)
{
    void *library = open_library(path);
    if (!library)
        return 11;
#define LOOK_UP(name)                                                                                                  \
    if (!(name = (__typeof__(name))symbol(library, "fmi2" #name)))                                                     \
        return 12;
    FUNCTIONS(LOOK_UP)
    return 0;
}

#ifdef FUZZED
int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size)
{
    static int loaded;
    if (!loaded && load(getenv("LIBRARY")))
        abort();
    loaded = 1;
    for (bytes_left = data, n_left = size; n_left > 0;)
        fuzz_once(getenv("GUID"), getenv("RESOURCES"));
    for (int k = 0; k < N; k++)
        release(k);
    return 0;
}
#else
int main(int count, char **arguments)
{
    static char line[4096];
    if (count != 4)
        return 10;
    int failed = load(arguments[1]);
    if (failed)
        return failed;
    while (fgets(line, sizeof line, stdin))
        if (!run_line(line, arguments[2], arguments[3]))
            return 13;
    for (int k = 0; k < N; k++)
        release(k);
    return 0;
}
#endif
