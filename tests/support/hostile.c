/* An FMU of FMI 2.0, or with -DFMI_VERSION=3 of FMI 3.0, that does at one of its calls what no FMU should.
 *
 * HOSTILE_DEED says what, HOSTILE_CALL at which call, counted from 0: of all calls, or of those of HOSTILE_FUNCTION
 * alone.
 */
#include <math.h>
#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <unistd.h>

#include "fmi_names.h"

enum { OK, WARNING, DISCARD, ERROR, FATAL };
typedef struct Instance Instance;
#if FMI_VERSION == 3
typedef void (*Logger)(void *, int, const char *, const char *);
#else
typedef void (*Logger)(void *, const char *, int, const char *, const char *, ...);
#endif
struct Instance {
    double u, y, reached;
    Logger log;
    void *environment;
};

static void say(Instance *self, int status, const char *text)
{
    if (!self)
        return;
#if FMI_VERSION == 3
    self->log(self->environment, status, "log", text);
#else
    self->log(self->environment, "one", status, "log", text);
#endif
}

static int deep(volatile char *above)
{
    volatile char here[4096];
    here[0] = *above;
    return deep(here) + here[0];
}

static void sleep_long(void)
{
    for (int i = 0; i < 600; i++)
        sleep(1);
    _exit(0);
}

/* The status after a deed. */
static int done(const char *deed, Instance *self)
{
#define IS(name) (strcmp(deed, #name) == 0)
    char *volatile memory = malloc(8);
    if (IS(segv))
        *(volatile int *)8 = 1;
    if (IS(abort))
        abort();
    if (IS(leave))
        exit(0);
    if (IS(kill))
        kill(getpid(), SIGKILL);
    if (IS(overflow))
        return deep("") & 1;
    if (IS(fork) && !fork())
        sleep_long();
    if (IS(fork_away) && !fork()) {
        setsid();
        sleep_long();
    }
    if (IS(daemon) && !fork()) {
        setsid();
        if (fork())
            _exit(0);
        sleep_long();
    }
    if (IS(hang)) {
        prctl(PR_SET_NAME, "hangs");
        for (;;)
            pause();
    }
    if (IS(speak))
        for (int fd = 0; fd < 16; fd++)
            if (write(fd, "words among the answers\n", 24)) {
            }
    if (IS(print) && write(1, "a word among the answers\n", 25)) {
    }
    if (IS(close))
        for (int fd = 0; fd < 64; fd++)
            close(fd);
    if (IS(eat)) {
        size_t most = sysconf(_SC_PHYS_PAGES) * 9 / 10 * sysconf(_SC_PAGE_SIZE);
        if (mmap(NULL, most, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) == MAP_FAILED)
            return ERROR;
    }
    if (IS(term))
        kill(getpid(), SIGTERM);
    if (IS(free_twice)) {
        free(memory);
        free(memory);
    }
    if (IS(deaf)) {
        signal(SIGTERM, SIG_IGN);
        signal(SIGINT, SIG_IGN);
    }
    if (IS(nan) && self)
        self->y = NAN;
    if (IS(latin))
        say(self, WARNING,
            "Temp\xe9rature trop \xe9lev\xe9"
            "e");
    if (IS(complain))
        say(self, ERROR, "no table, defaults apply");
    if (IS(inf) && self)
        self->y = INFINITY;
    return IS(discard)       ? DISCARD
           : IS(error)       ? ERROR
           : IS(fatal)       ? FATAL
           : IS(minus_one)   ? -1
           : IS(ninety_nine) ? 99
                             : OK;
}

/* Counts a call; returns its status. */
static int called(const char *function, Instance *self)
{
    static int count, is_corrupted; /* after Fatal FMI allows no further call */
    const char *which = getenv("HOSTILE_CALL"), *deed = getenv("HOSTILE_DEED"), *only = getenv("HOSTILE_FUNCTION");
    if (is_corrupted)
        abort();
    if (!which || !deed || (only && strcmp(only, function)) || count++ != atoi(which))
        return OK;
    int status = done(deed, self);
    is_corrupted = status == FATAL;
    return status;
}

static Instance *made(Logger log, void *environment)
{
    Instance *self = malloc(sizeof *self);
    *self = (Instance){0.0, 0.0, 0.0, log, environment};
    return called("Instantiate", self) ? NULL : self;
}

#if FMI_VERSION == 3
Instance *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible,
                                      bool logging, bool events, bool early, const unsigned *intermediate, size_t n,
                                      void *environment, Logger log, void *update)
{
    return made(log, environment);
}
int fmi3DoStep(Instance *self, double time, double step, bool no_way_back, bool *event, bool *end, bool *early,
               double *reached)
{
    *event = *end = *early = false, *reached = time + step / 4;
#else
typedef struct {
    Logger log;
    void *allocate, *release, *finished, *environment;
} Callbacks;
Instance *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const Callbacks *calls,
                          int visible, int logging)
{
    return made(calls->log, calls->environment);
}
int fmi2DoStep(Instance *self, double time, double step, int no_way_back)
{
#endif
    self->y = time + step, self->reached = time + step / 4;
    return called("DoStep", self);
}
void FMI(FreeInstance)(Instance *self)
{
    called("FreeInstance", self);
    free(self);
}
int FMI(SetFloat64)(Instance *self, const unsigned *references, size_t n, const double *values N_VALUES)
{
    for (size_t k = 0; k < n; k++)
        self->u = values[k];
    return called("Set", self);
}
int FMI(GetFloat64)(Instance *self, const unsigned *references, size_t n, double *values N_VALUES)
{
    for (size_t k = 0; k < n; k++)
        values[k] = self->y;
    return called("Get", self);
}
int FMI(GetFMUState)(Instance *self, Instance **state)
{
    if (!*state)
        *state = malloc(sizeof **state);
    **state = *self;
    return called("GetFMUState", self);
}
int FMI(SetFMUState)(Instance *self, const Instance *state)
{
    *self = *state;
    return called("SetFMUState", self);
}
int FMI(FreeFMUState)(Instance *self, Instance **state)
{
    free(*state);
    *state = NULL;
    return called("FreeFMUState", self);
}

#define CALL(name)                                                                                                     \
    int FMI(name)(Instance * self) { return called(#name, self); }
CALL(Terminate)
CALL(Reset)
CALL(SetDebugLogging)
CALL(EnterInitializationMode)
CALL(ExitInitializationMode)
CALL(SerializedFMUStateSize)
CALL(SerializeFMUState)
CALL(DeserializeFMUState)
#if FMI_VERSION != 3
CALL(SetupExperiment) int fmi2GetRealStatus(Instance *self, int kind, double *value)
{
    *value = self->reached;
    return called("GetRealStatus", self);
}
#endif
#include "other_functions.h"
