/* The kernels of a model in Python: PythonFMU's library calls those of slave.py, which work on the arrays of the run.

   PythonFMU makes a Python object of any argument, and does not survive what the standard forbids. It is asked for
   no more than an instance, its kernels and its end; everything else is the business of the slave in C. What
   slave.py logs is the reason for which a kernel failed. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "instance.h"
#include "kernels.h"
#include "pythonfmu.h"
#include "resources.h"

enum { NAME_SIZE = 256 };

struct Kernels {
    PythonFmu python;
    fmi2Component slave;             /* PythonFMU's instance */
    fmi2CallbackFunctions callbacks; /* what it calls, and does not copy */
    int is_lost;                     /* whether it must not be called any more */
    char first_error[TEXT_SIZE];     /* the first error that Python reported in the present call */
};

static const char EXCEPTION[] = "Fatal py exception encountered: ";

/* The logger that PythonFMU calls, without arguments to the text, whose percent signs stand for themselves. On the
   first line it says in which of its functions an exception was raised. */
static void hear(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                 fmi2String text, ...)
{
    struct Kernels *kernels = environment;
    const char *cause = strncmp(text, EXCEPTION, strlen(EXCEPTION)) == 0 ? strchr(text, '\n') : NULL;
    (void)name, (void)category;
    if (status > fmi2Warning && !*kernels->first_error)
        snprintf(kernels->first_error, TEXT_SIZE, "%s", cause ? cause + 1 : text);
}

/* Why a call of PythonFMU failed, or NULL. After an exception that left a method it has released what it still uses. */
static const char *failure(struct Kernels *kernels, fmi2Status status)
{
    kernels->is_lost = status > fmi2Discard;
    if (status != fmi2OK && !*kernels->first_error)
        snprintf(kernels->first_error, TEXT_SIZE, "Python failed without giving a reason");
    return *kernels->first_error ? kernels->first_error : NULL;
}

/* Whether the script whose name is in slavemodule.txt exists; PythonFMU does not survive without it. */
static int script_exists(const char *folder, char *reason)
{
    char name[NAME_SIZE];
    size_t size = 0;
    unsigned char *bytes = file_bytes(folder, "slavemodule.txt", &size, reason), *script = NULL;
    if (bytes) {
        snprintf(name, sizeof name, "%.*s.py", (int)(size < NAME_SIZE - 4 ? size : NAME_SIZE - 4), (const char *)bytes);
        script = file_bytes(folder, name, &size, reason);
    }
    free(bytes);
    free(script);
    return script != NULL;
}

/* Tell the slave in Python where the arrays of the run are: address and size of each, in the order of the arguments. */
static const char *hand_over_arrays(struct Kernels *kernels, const Run *run)
{
    const Data *data = &run->data;
    const double *arrays[] = {run->values, run->values + data->n_parameters, run->state, run->work, run->next_outputs};
    const int64_t sizes[] = {data->n_parameters, data->n_inputs, data->n_state, data->n_work, data->n_outputs};
    const fmi2ValueReference any = 0;
    char text[256] = "";
    const char *argument = text;
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
        snprintf(text + strlen(text), sizeof text - strlen(text), "%llu %llu ",
                 (unsigned long long)(uintptr_t)arrays[i], (unsigned long long)sizes[i]);
    return failure(kernels, kernels->python.SetString(kernels->slave, &any, 1, &argument));
}

/* Have PythonFMU make an instance; 0 with a reason if it does not. */
static int begin_python(Run *run, const char *name, const char *folder, char *reason)
{
    struct Kernels *kernels = run->kernels;
    const PythonFmu *python = &kernels->python;
    kernels->callbacks = (fmi2CallbackFunctions){hear, calloc, free, NULL, kernels};
    kernels->slave =
        python->Instantiate(name, fmi2CoSimulation, run->data.guid, folder, &kernels->callbacks, fmi2False, fmi2True);
    finalise_at_exit(python);
    const char *why = kernels->slave ? hand_over_arrays(kernels, run) : failure(kernels, fmi2Error);
    if (why)
        snprintf(reason, TEXT_SIZE, "%s", why);
    return !why;
}

int open_kernels(Run *run, const char *name, const char *location, char *reason)
{
    char *located = resource_folder(location, reason), *folder = located ? readable_folder(located, reason) : NULL;
    int is_open = 0;
    free(located);
    if (folder && !(run->kernels = calloc(1, sizeof *run->kernels)))
        snprintf(reason, TEXT_SIZE, "there is no memory for another instance");
    else if (folder)
        is_open = open_pythonfmu(&run->kernels->python, folder, reason) && script_exists(folder, reason) &&
                  begin_python(run, name, folder, reason);
    if (!is_open)
        close_kernels(run);
    free(folder);
    return is_open;
}

void close_kernels(Run *run)
{
    struct Kernels *kernels = run->kernels;
    if (!kernels)
        return;
    if (kernels->slave && !kernels->is_lost)
        kernels->python.FreeInstance(kernels->slave);
    close_pythonfmu(&kernels->python);
    free(kernels);
}

/* The fault is the last of the outputs. */
static const char *answer(const Run *run, fmi2Status status, int64_t *fault)
{
    const char *why = failure(run->kernels, status);
    if (!why)
        *fault = (int64_t)run->next_outputs[run->data.n_outputs - 1];
    return why;
}

const char *call_initialise(Run *run, int64_t *fault)
{
    struct Kernels *kernels = run->kernels;
    if (kernels->is_lost)
        return kernels->first_error;
    *kernels->first_error = '\0';
    return answer(run, kernels->python.EnterInitializationMode(kernels->slave), fault);
}

const char *call_step(Run *run, double time, double step_size, int64_t *fault)
{
    struct Kernels *kernels = run->kernels;
    if (kernels->is_lost)
        return kernels->first_error;
    *kernels->first_error = '\0';
    return answer(run, kernels->python.DoStep(kernels->slave, time, step_size, fmi2True), fault);
}
