/* What is said to the host: messages, refusals, and the answers of PythonFMU.

   A fault in Python arrives as a message of status fmi2Error, and the call is then answered with fmi2Error: never with
   fmi2Discard and fmi2Terminated, by which hosts take a fault for an end that was wanted. */

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "guard.h"

static const struct {
    int32_t state;
    const char *name;
} STATE_NAMES[] = {
    {INSTANTIATED, "instantiated"}, {INITIALIZATION, "initialization mode"}, {STEP_COMPLETE, "step complete"},
    {TERMINATED, "terminated"},     {ERROR, "error"},                        {LOST, "fatal error"},
};
enum { N_STATES = sizeof STATE_NAMES / sizeof *STATE_NAMES };

/* In the order of fmi2Status, from fmi2Warning on. */
static const char *const CATEGORIES[] = {"logStatusWarning", "logStatusDiscard", "logStatusError", "logStatusFatal",
                                         "logAll"};
enum { N_CATEGORIES = sizeof CATEGORIES / sizeof *CATEGORIES, LOG_ALL = N_CATEGORIES - 1 };
_Static_assert(ALL_MESSAGES == 1 << LOG_ALL, "the last category is for all messages");

static int category_of(fmi2Status status)
{
    return status >= fmi2Warning && status <= fmi2Fatal ? (int)status - fmi2Warning : LOG_ALL;
}

/* Hand a text to the host's logger, which takes it for a printf format. */
void hand_over(const fmi2CallbackFunctions *host, const char *name, fmi2Status status, const char *text)
{
    char format[2 * TEXT_SIZE];
    size_t used = 0;
    if (!host->logger)
        return;
    for (; *text && used < sizeof format - 2; text++) {
        if (*text == '%')
            format[used++] = '%';
        format[used++] = *text;
    }
    format[used] = '\0';
    host->logger(host->componentEnvironment, name, status, CATEGORIES[category_of(status)], format);
}

void say(const Instance *instance, fmi2Status status, const char *text)
{
    unsigned int wanted = 1u << category_of(status) | 1u << LOG_ALL;
    if (instance->logging && instance->categories & wanted)
        hand_over(&instance->host, instance->name, status, text);
}

void say_when(const Instance *instance, char *text, fmi2Status status, const char *what)
{
    const char *colon = ": ";
    *text = '\0';
    if (instance->doing == INITIALISING)
        snprintf(text, TEXT_SIZE, "initialisation");
    else if (instance->doing == STEPPING)
        snprintf(text, TEXT_SIZE, "at t = %.9g s", status <= fmi2Warning ? instance->end : instance->begin);
    else
        colon = "";
    size_t used = strlen(text);
    snprintf(text + used, TEXT_SIZE - used, "%s%s", colon, what);
}

static const char EXCEPTION[] = "Fatal py exception encountered: ";

/* An error is kept, and told when the call that it comes from is answered. PythonFMU gives no arguments to the text, whose
   percent signs stand for themselves, and says on a first line in which of its functions there was an exception. */
void hear(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
          fmi2String what, ...)
{
    Instance *instance = environment;
    const char *cause = strncmp(what, EXCEPTION, strlen(EXCEPTION)) == 0 ? strchr(what, '\n') : NULL;
    char text[TEXT_SIZE];
    (void)name, (void)category;
    if (status > fmi2Warning && !*instance->heard) {
        snprintf(instance->heard, sizeof instance->heard, "%s", cause ? cause + 1 : what);
        return;
    }
    say_when(instance, text, status, what);
    say(instance, status, text);
}

#define FORMAT(text) \
    char text[TEXT_SIZE]; \
    va_list arguments; \
    va_start(arguments, format); \
    vsnprintf(text, sizeof text, format, arguments); \
    va_end(arguments)

/* Note and tell why a call is refused; the first reason stays. */
static void tell_why(Instance *instance, const char *reason, const char *text)
{
    if (!(instance->now.state & (ERROR | LOST)))
        snprintf(instance->now.reason, TEXT_SIZE, "%s", reason);
    say(instance, fmi2Error, text);
}

static fmi2Status stop(Instance *instance, const char *reason, const char *text)
{
    tell_why(instance, reason, text);
    if (instance->now.state != LOST) {
        instance->now.state = ERROR;
        instance->now.fault = FAULT_MISUSE;
    }
    return fmi2Error;
}

fmi2Status decline(Instance *instance, const char *format, ...)
{
    FORMAT(text);
    tell_why(instance, text, text);
    return fmi2Error;
}

fmi2Status refuse(Instance *instance, const char *format, ...)
{
    FORMAT(text);
    return stop(instance, text, text);
}

/* Whether `call` may come now; if not it is refused, with what state the instance is in and which would do. */
int may(Instance *instance, int states, const char *call)
{
    char text[TEXT_SIZE];
    const char *now = "an unknown state", *separator = "";
    if (!instance)
        return 0;
    *instance->heard = '\0';
    instance->doing = instance->now.state == INITIALIZATION ? INITIALISING : NOTHING;
    if (instance->now.state & states)
        return 1;
    for (size_t i = 0; i < N_STATES; i++)
        if (STATE_NAMES[i].state == instance->now.state)
            now = STATE_NAMES[i].name;
    size_t used = (size_t)snprintf(text, sizeof text, "%s is not allowed in state '%s'; it is allowed in ", call, now);
    for (size_t i = 0; i < N_STATES; i++)
        if (states & STATE_NAMES[i].state && used < sizeof text) {
            used += (size_t)snprintf(text + used, sizeof text - used, "%s'%s'", separator, STATE_NAMES[i].name);
            separator = ", ";
        }
    if (instance->now.state & (ERROR | LOST) && used < sizeof text)
        snprintf(text + used, sizeof text - used, "; stopped by an earlier fault: %s", instance->now.reason);
    refuse(instance, "%s", text);
    return 0;
}

/* After an exception that left a method PythonFMU has released what it still uses, so that it is not called any more. */
fmi2Status answer(Instance *instance, fmi2Status status, const char *call)
{
    char text[TEXT_SIZE];
    if (status == fmi2OK && !*instance->heard)
        return fmi2OK;
    if (!*instance->heard)
        snprintf(instance->heard, sizeof instance->heard, "%s failed in Python, without a reason", call);
    say_when(instance, text, fmi2Error, instance->heard);
    if (status <= fmi2Discard)
        return stop(instance, instance->heard, text);
    snprintf(instance->now.reason, TEXT_SIZE, "%s", instance->heard);
    instance->now.state = LOST;
    say(instance, fmi2Fatal, text);
    return fmi2Fatal;
}

fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean on, size_t count, const fmi2String categories[])
{
    Instance *instance = component;
    unsigned int chosen = count ? 0 : 1u << LOG_ALL;
    if (!may(instance, ANY, "fmi2SetDebugLogging"))
        return fmi2Error;
    if (count && !categories)
        return decline(instance, "fmi2SetDebugLogging: categories is NULL");
    for (size_t i = 0; i < count; i++) {
        unsigned int k = 0;
        while (k < N_CATEGORIES && !(categories[i] && strcmp(categories[i], CATEGORIES[k]) == 0))
            k++;
        if (k == N_CATEGORIES)
            return decline(instance, "fmi2SetDebugLogging: there is no category %s; there are %s, %s, %s, %s and %s",
                           categories[i] ? categories[i] : "NULL", CATEGORIES[0], CATEGORIES[1], CATEGORIES[2],
                           CATEGORIES[3], CATEGORIES[4]);
        chosen |= 1u << k;
    }
    instance->logging = on != fmi2False;
    instance->categories = chosen;
    return fmi2OK;
}
