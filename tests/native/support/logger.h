/* What the hosts of the tests give an FMU to speak to: its words, on standard error. */

#include <stdarg.h>
#include <stdio.h>

#include "fmi2Functions.h"

static void logger(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                   fmi2String text, ...)
{
    va_list arguments;
    (void)environment;
    fprintf(stderr, "%s %d %s ", name, status, category);
    va_start(arguments, text);
    vfprintf(stderr, text, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}
