/* An FMU that answers what its input `what` says: a status that FMI does not have, a text that is not UTF-8, NaN, a
 * process that outlives it, or a crash as it is ended. */
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { GOOD, MINUS_ONE, NINETY_NINE, LATIN, NAN_OUT, FORK, FORK_AWAY, CRASH_AT_TERMINATE, CRASH_AT_FREE, FORK_DAEMON };
typedef void (*Logger)(void *, const char *, int, const char *, const char *, ...);
typedef struct { Logger logger; void *allocate, *release, *finished, *environment; } Callbacks;
typedef struct { Callbacks calls; char name[256]; double what, y; } Odd;

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
void *fmi2Instantiate(const char *name, int type, const char *guid, const char *where, const Callbacks *calls, int visible,
                      int logging) {
  Odd *odd = calloc(1, sizeof *odd);
  odd->calls = *calls;
  strncpy(odd->name, name, sizeof odd->name - 1);
  return odd;
}
int fmi2SetDebugLogging(void *odd, int on, size_t n, const char *const *categories) { return 0; }
void fmi2FreeInstance(void *component) {
  Odd *odd = component;
  if (odd->what == CRASH_AT_FREE) raise(SIGSEGV);
  free(odd);
}
int fmi2Terminate(void *component) {
  if (((Odd *)component)->what == CRASH_AT_TERMINATE) raise(SIGSEGV);
  return 0;
}
int fmi2Reset(void *odd) { return 0; }
int fmi2SetupExperiment(void *odd, int a, double b, double c, int d, double e) { return 0; }
int fmi2EnterInitializationMode(void *odd) { return 0; }
int fmi2ExitInitializationMode(void *odd) { return 0; }
int fmi2SetReal(void *component, const unsigned *references, size_t n, const double *values) {
  if (n) ((Odd *)component)->what = values[0];
  return 0;
}
int fmi2GetReal(void *component, const unsigned *references, size_t n, double *values) {
  if (n) values[0] = ((Odd *)component)->y;
  return 0;
}
int fmi2DoStep(void *component, double time, double step, int no_way_back) {
  Odd *odd = component;
  int what = (int)odd->what;
  odd->y = what == NAN_OUT ? NAN : time + step;
  if (what == LATIN) odd->calls.logger(odd->calls.environment, odd->name, 1, "log", "Temp\xe9rature trop \xe9lev\xe9""e");
  if ((what == FORK || what == FORK_AWAY) && fork() == 0) {
    if (what == FORK_AWAY) setsid();
    for (int i = 0; i < 600; i++) sleep(1);
    _exit(0);
  }
  if (what == FORK_DAEMON && fork() == 0) {
    setsid();
    if (fork()) _exit(0);
    for (int i = 0; i < 600; i++) sleep(1);
    _exit(0);
  }
  if (what == FORK || what == FORK_AWAY || what == FORK_DAEMON) odd->what = GOOD;
  return what == MINUS_ONE ? -1 : what == NINETY_NINE ? 99 : 0;
}

/* What a host looks for and these tests do not call. */
#define UNUSED(name) \
  int fmi2##name(void) { return 3; }
UNUSED(GetInteger) UNUSED(GetBoolean) UNUSED(GetString) UNUSED(SetInteger) UNUSED(SetBoolean) UNUSED(SetString)
UNUSED(GetFMUstate) UNUSED(SetFMUstate) UNUSED(FreeFMUstate) UNUSED(SerializedFMUstateSize) UNUSED(SerializeFMUstate)
UNUSED(DeSerializeFMUstate) UNUSED(GetDirectionalDerivative) UNUSED(SetRealInputDerivatives)
UNUSED(GetRealOutputDerivatives) UNUSED(CancelStep) UNUSED(GetStatus) UNUSED(GetRealStatus) UNUSED(GetIntegerStatus)
UNUSED(GetBooleanStatus) UNUSED(GetStringStatus)
