/* What an instance tells its host: log and refusals. */

#include "host.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Log ------------------------------------------------------------------------------------------------------------ */

/* In the order of Status, from STATUS_WARNING on; the last means all. */
static const char *const CATEGORIES[] = {"logStatusWarning", "logStatusDiscard", "logStatusError", "logStatusFatal",
                                         "logAll"};
enum { N_CATEGORIES = sizeof CATEGORIES / sizeof *CATEGORIES, EVERY_CATEGORY = (1 << N_CATEGORIES) - 1 };

static void log_text(const Host *host, const char *name, Status status, const char *text)
{
    if (host->logger)
        host->binding->log(host, name, status, CATEGORIES[status - STATUS_WARNING], text);
}

void log_status(const Instance *instance, Status status, const char *format, ...)
{
    char text[TEXT_SIZE];
    va_list arguments;
    if (status < STATUS_ERROR && !(instance->enabled_categories >> (status - STATUS_WARNING) & 1))
        return;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    log_text(&instance->host, instance->name, status, text);
}

void slave_log_no_instance(const Host *host, const char *name, const char *reason)
{
    log_text(host, name ? name : "", STATUS_ERROR, reason);
}

Status slave_categories(Instance *instance, const char *call, const char *const names[], size_t count,
                        unsigned int *chosen)
{
    *chosen = count ? 0 : EVERY_CATEGORY;
    if (!may(instance, ANY, call))
        return STATUS_ERROR;
    if (count && !names)
        return reject(instance, "%s: categories is NULL", call);
    for (size_t i = 0; i < count; i++) {
        unsigned int k = 0;
        while (k < N_CATEGORIES && !(names[i] && strcmp(names[i], CATEGORIES[k]) == 0))
            k++;
        if (k == N_CATEGORIES)
            return reject(instance, "%s: there is no category %s; there are %s, %s, %s, %s and %s", call,
                          names[i] ? names[i] : "NULL", CATEGORIES[0], CATEGORIES[1], CATEGORIES[2], CATEGORIES[3],
                          CATEGORIES[4]);
        *chosen |= k == N_CATEGORIES - 1 ? EVERY_CATEGORY : 1u << k;
    }
    return STATUS_OK;
}

/* Refusals ------------------------------------------------------------------------------------------------------- */

static Status refuse(Instance *instance, Status status, const char *format, va_list arguments)
{
    char text[TEXT_SIZE];
    vsnprintf(text, sizeof text, format, arguments);
    if (!instance->now->outcome.fault)
        snprintf(instance->now->outcome.reason, TEXT_SIZE, "%s", text);
    log_status(instance, status, "%s", text);
    return status;
}

Status reject(Instance *instance, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    Status status = refuse(instance, STATUS_ERROR, format, arguments);
    va_end(arguments);
    return status;
}

Status decline(Instance *instance, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    Status status = refuse(instance, STATUS_DISCARD, format, arguments);
    va_end(arguments);
    return status;
}

Status fail(Instance *instance, const char *format, ...)
{
    char text[TEXT_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (!instance->now->outcome.fault)
        run_stop(&instance->run, FAULT_INTERNAL, text);
    instance->now->state = ERROR;
    log_status(instance, STATUS_ERROR, "%s", text);
    return STATUS_ERROR;
}

void fail_in_state(Instance *instance, int states, const char *call)
{
    char text[TEXT_SIZE];
    const char *const *names = instance->host.binding->states, *now = "an unknown state", *separator = "";
    for (int i = 0; i < N_STATES; i++)
        if (instance->now->state == 1 << i)
            now = names[i];
    size_t used = (size_t)snprintf(text, sizeof text, "%s is not allowed in state '%s'; it is allowed in ", call, now);
    for (int i = 0; i < N_STATES && used < sizeof text; i++)
        if (states & 1 << i) {
            used += (size_t)snprintf(text + used, sizeof text - used, "%s'%s'", separator, names[i]);
            separator = ", ";
        }
    int stopped = instance->now->state == ERROR;
    fail(instance, "%s%s%s", text, stopped ? "; stopped by an earlier fault: " : "",
         stopped ? instance->now->outcome.reason : "");
}

Status unsupported(const Instance *instance, Status status, const char *call, const char *why)
{
    if (!instance)
        return STATUS_ERROR;
    log_status(instance, status, "%s: %s", call, why);
    return status;
}
