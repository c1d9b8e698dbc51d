/* An FMU that does at one of its calls, the HOSTILE_CALL-th, what no FMU should: HOSTILE_DEED says what. */
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

enum { NOTHING, SEGV, ABORT, LEAVE, KILL, OVERFLOW, FORK, FORK_AWAY, DAEMON, HANG, SPEAK, CLOSE, EAT, TERM, FREE_TWICE, ERROR,
       FATAL, UNKNOWN, DEAF };
typedef struct { double u, y; } Instance;

static int deep(volatile char *above) { volatile char here[4096]; here[0] = *above; return deep(here) + here[0]; }

static void sleep_long(void) { for (int i = 0; i < 600; i++) sleep(1); _exit(0); }

/* Counts a call; returns its status. */
static int called(void) {
  static int count;
  const char *which = getenv("HOSTILE_CALL"), *what = getenv("HOSTILE_DEED");
  if (!which || !what || count++ != atoi(which)) return 0;
  char *memory = malloc(8);
  switch (atoi(what)) {
  case SEGV: *(volatile int *)8 = 1; break;
  case ABORT: abort();
  case LEAVE: exit(0);
  case KILL: kill(getpid(), SIGKILL); break;
  case OVERFLOW: return deep("") & 1;
  case FORK: if (!fork()) sleep_long(); break;
  case FORK_AWAY: if (!fork()) { setsid(); sleep_long(); } break;
  case DAEMON: if (!fork()) { setsid(); if (fork()) _exit(0); sleep_long(); } break;
  case HANG: for (;;) pause();
  case SPEAK: for (int fd = 0; fd < 16; fd++) if (write(fd, "words among the answers\n", 24)) {} break;
  case CLOSE: for (int fd = 0; fd < 64; fd++) close(fd); break;
  case EAT: { size_t n = (size_t)1 << 46; volatile char *all = mmap(NULL, n, 3, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
              if (all != MAP_FAILED) all[0] = 1; break; }
  case TERM: kill(getpid(), SIGTERM); break;
  case FREE_TWICE: free(memory); free(memory); break;
  case ERROR: return 3;
  case FATAL: return 4;
  case UNKNOWN: return 77;
  case DEAF: signal(SIGTERM, SIG_IGN); signal(SIGINT, SIG_IGN); break;
  }
  return 0;
}

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
void *fmi2Instantiate(void) { return called() ? NULL : calloc(1, sizeof(Instance)); }
void fmi2FreeInstance(void *self) { called(); free(self); }
int fmi2SetReal(Instance *self, const unsigned *references, size_t n, const double *values) {
  for (size_t k = 0; k < n; k++) self->u = values[k];
  return called();
}
int fmi2GetReal(Instance *self, const unsigned *references, size_t n, double *values) {
  for (size_t k = 0; k < n; k++) values[k] = self->y;
  return called();
}
int fmi2DoStep(Instance *self, double time, double step, int no_way_back) { self->y = time + step; return called(); }
int fmi2GetFMUstate(Instance *self, Instance **state) {
  if (!*state) *state = malloc(sizeof **state);
  **state = *self;
  return called();
}
int fmi2SetFMUstate(Instance *self, const Instance *state) { *self = *state; return called(); }
int fmi2FreeFMUstate(Instance *self, Instance **state) { free(*state); *state = NULL; return called(); }

#define CALL(name) int fmi2##name(void) { return called(); }
CALL(SetDebugLogging) CALL(Terminate) CALL(Reset) CALL(SetupExperiment) CALL(EnterInitializationMode)
CALL(ExitInitializationMode) CALL(GetInteger) CALL(GetBoolean) CALL(GetString) CALL(SetInteger) CALL(SetBoolean)
CALL(SetString) CALL(SerializedFMUstateSize) CALL(SerializeFMUstate) CALL(DeSerializeFMUstate)
CALL(GetDirectionalDerivative) CALL(SetRealInputDerivatives) CALL(GetRealOutputDerivatives) CALL(CancelStep)
CALL(GetStatus) CALL(GetRealStatus) CALL(GetIntegerStatus) CALL(GetBooleanStatus) CALL(GetStringStatus)
