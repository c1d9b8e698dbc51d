/* An instance of the guard, and what all its calls begin and end with. */

#ifndef AMB_GUARD_H
#define AMB_GUARD_H

#include <stdint.h>

#include "data.h"
#include "fmi2Functions.h"
#include "pythonfmu.h"

#define REFERENCES const fmi2ValueReference references[], size_t count

enum { FAULT_MISUSE = 998, ALL_MESSAGES = 1 << 4 /* of the categories */ };

/* States of the standard that a slave without asynchronous steps can be in, and the one in which Python is lost. */
enum {
    INSTANTIATED = 1,
    INITIALIZATION = 2,
    STEP_COMPLETE = 4,
    TERMINATED = 8,
    ERROR = 16,
    LOST = 32,
};

enum {
    ANY = INSTANTIATED | INITIALIZATION | STEP_COMPLETE | TERMINATED | ERROR,
    READABLE = INITIALIZATION | STEP_COMPLETE | TERMINATED | ERROR,
    SETTABLE = INSTANTIATED | INITIALIZATION | STEP_COMPLETE,
    ASKABLE = STEP_COMPLETE | TERMINATED | ERROR | LOST,
};

enum { NOTHING, INITIALISING, STEPPING };

/* What this library saves of an instance; the rest is PythonFMU's. */
typedef struct {
    _Alignas(16) char guid[GUID_SIZE]; /* first, so that the state of another FMU is known by it */
    int32_t state;
    int32_t fault;          /* of a call that was refused here */
    double time;            /* end of the last successful step (s) */
    char reason[TEXT_SIZE]; /* of the fault, or of the call that was refused last; empty after a step that was done */
} Now;

typedef struct {
    Now now;
    double stop; /* end of the experiment (s), where the host set one */
    Data data;
    PythonFmu python;
    fmi2Component slave;         /* PythonFMU's instance */
    fmi2CallbackFunctions own;   /* what it calls */
    fmi2CallbackFunctions host;
    int logging;
    unsigned int categories;     /* of the messages that the host wants, one bit for each */
    char heard[TEXT_SIZE];       /* the first error that Python reported in the present call */
    int doing;                   /* what, in the present call */
    double begin, end;           /* of the present step (s) */
    const char *name, *folder;   /* the second is that of the resources */
    fmi2Boolean visible;
} Instance;

/* Call a function of PythonFMU's instance. */
#define PYTHON(function, ...) instance->python.function(instance->slave, __VA_ARGS__)

#pragma GCC visibility push(hidden)

/* Whether `call` may come now; if not it is refused, with what state the instance is in and which would do. */
int may(Instance *instance, int states, const char *call);

/* Refuse a call for good: the first reason stays. fmi2Error. */
fmi2Status refuse(Instance *instance, const char *format, ...);

/* Refuse a call that changed nothing, and live on. fmi2GetStringStatus has the reason until the next step is done. */
fmi2Status decline(Instance *instance, const char *format, ...);

/* What PythonFMU's answer to `call` comes to: a refusal if Python reported an error. */
fmi2Status answer(Instance *instance, fmi2Status status, const char *call);

/* Write to `text` (TEXT_SIZE) when it was that Python said something in the present call, and what. */
void say_when(const Instance *instance, char *text, fmi2Status status, const char *what);

/* Hand a text to the host's logger if the host wants it. */
void say(const Instance *instance, fmi2Status status, const char *text);

/* The logger that PythonFMU calls. */
void hear(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
          fmi2String text, ...);

/* Hand a text to a host's logger. */
void hand_over(const fmi2CallbackFunctions *host, const char *name, fmi2Status status, const char *text);

#pragma GCC visibility pop

#endif
