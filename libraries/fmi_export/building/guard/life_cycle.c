/* FMI 2.0 before PythonFMU's library: what the standard forbids is refused here, and only what is right reaches Python.

   The guard checks state, arguments and saved states as the slave of the native FMUs does, with the same words, and hands
   the call on. PythonFMU makes a Python object of each reference and value that it is given, whatever it is, so that
   nothing wrong may get there. The variables with their types are in resources/model.bin. */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "guard.h"
#include "resources.h"

enum { NAME_SIZE = 256 };

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return fmi2Version;
}

static void start_over(Instance *instance)
{
    memset(&instance->now, 0, sizeof instance->now);
    memcpy(instance->now.guid, instance->data.guid, GUID_SIZE);
    instance->now.state = INSTANTIATED;
    instance->stop = INFINITY;
}

/* An instance, its data at a multiple of 16 bytes, its name and its folder in one block of memory, or NULL. */
static Instance *allocate(const unsigned char *bytes, size_t size, const char *name, const char *folder)
{
    size_t data = (sizeof(Instance) + 15) / 16 * 16, own_name = data + size, own_folder = own_name + strlen(name) + 1;
    char *block = calloc(1, own_folder + strlen(folder) + 1);
    if (!block)
        return NULL;
    memcpy(block + data, bytes, size);
    strcpy(block + own_name, name);
    strcpy(block + own_folder, folder);
    Instance *instance = (Instance *)block;
    instance->data = data_in((const unsigned char *)block + data);
    instance->name = block + own_name;
    instance->folder = block + own_folder;
    return instance;
}

/* A new instance with the data in a folder, without Python; NULL with a reason if there can be none. */
static Instance *load(const char *name, const char *guid, const char *folder, char *reason)
{
    char why[TEXT_SIZE];
    size_t size = 0;
    Instance *instance = NULL;
    unsigned char *bytes = file_bytes(folder, "model.bin", &size, reason);
    if (!bytes)
        return NULL;
    if (!data_is_valid(bytes, size, why))
        snprintf(reason, TEXT_SIZE, "resources/model.bin does not fit: %.*s; build the FMU anew", TEXT_SIZE / 2, why);
    else if (!guid || strcmp(guid, data_in(bytes).guid) != 0)
        snprintf(reason, TEXT_SIZE, "the modelDescription.xml has guid %s, but resources/model.bin belongs to %s",
                 guid ? guid : "NULL", data_in(bytes).guid);
    else if (!(instance = allocate(bytes, size, name, folder)))
        snprintf(reason, TEXT_SIZE, "there is no memory for another instance");
    free(bytes);
    return instance;
}

/* Whether there is the script whose name is in slavemodule.txt; PythonFMU does not survive one that is missing. */
static int script_is_there(const char *folder, char *reason)
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

/* Have PythonFMU make its part of an instance; 0 with a reason if it does not. */
static int begin_python(Instance *instance, char *reason)
{
    const PythonFmu *python = &instance->python;
    if (!script_is_there(instance->folder, reason))
        return 0;
    instance->slave = python->Instantiate(instance->name, fmi2CoSimulation, instance->data.guid, instance->folder,
                                          &instance->own, instance->visible, fmi2True);
    finalise_at_exit(python);
    if (!instance->slave)
        snprintf(reason, TEXT_SIZE, "%s", *instance->heard ? instance->heard : "Python made no instance");
    return instance->slave != NULL;
}

static void release(Instance *instance)
{
    close_pythonfmu(&instance->python);
    free(instance);
}

static Instance *make(const char *name, const char *guid, const char *location, const fmi2CallbackFunctions *host,
                      fmi2Boolean visible, char *reason)
{
    char *given = resource_folder(location, reason), *folder = given ? readable_folder(given, reason) : NULL;
    Instance *instance = folder ? load(name, guid, folder, reason) : NULL;
    free(given);
    free(folder);
    if (!instance)
        return NULL;
    instance->host = *host;
    instance->own = (fmi2CallbackFunctions){hear, host->allocateMemory, host->freeMemory, NULL, instance};
    instance->visible = visible;
    if (open_pythonfmu(&instance->python, instance->folder, reason) && begin_python(instance, reason))
        return instance;
    release(instance);
    return NULL;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *host, fmi2Boolean visible, fmi2Boolean logging)
{
    char reason[TEXT_SIZE] = "";
    Instance *instance = NULL;
    if (!host)
        return NULL;
    if (!name || !*name)
        snprintf(reason, sizeof reason, "an instance needs a name");
    else if (type != fmi2CoSimulation)
        snprintf(reason, sizeof reason, "this is an FMU for co-simulation, not for model exchange");
    else
        instance = make(name, guid, resources, host, visible, reason);
    if (!instance) {
        hand_over(host, name ? name : "", fmi2Error, reason);
        return NULL;
    }
    instance->logging = logging != fmi2False;
    instance->categories = ALL_MESSAGES;
    start_over(instance);
    return instance;
}

void fmi2FreeInstance(fmi2Component component)
{
    Instance *instance = component;
    if (!instance)
        return;
    if (instance->now.state != LOST)
        instance->python.FreeInstance(instance->slave);
    release(instance);
}

fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean has_stop, fmi2Real stop)
{
    Instance *instance = component;
    if (!may(instance, INSTANTIATED, "fmi2SetupExperiment"))
        return fmi2Error;
    if (!isfinite(start))
        return refuse(instance, "start time = %g s is not allowed; it must be a finite number", start);
    if (has_stop && !(stop >= start))
        return refuse(instance, "stop time = %g s is not allowed; it must be >= %g s, the start", stop, start);
    instance->now.time = start;
    instance->stop = has_stop ? stop : INFINITY;
    return answer(instance, PYTHON(SetupExperiment, has_tolerance, tolerance, start, has_stop, stop),
                  "fmi2SetupExperiment");
}

fmi2Status fmi2EnterInitializationMode(fmi2Component component)
{
    Instance *instance = component;
    if (!may(instance, INSTANTIATED, "fmi2EnterInitializationMode"))
        return fmi2Error;
    instance->now.state = INITIALIZATION;
    return answer(instance, instance->python.EnterInitializationMode(instance->slave), "fmi2EnterInitializationMode");
}

fmi2Status fmi2ExitInitializationMode(fmi2Component component)
{
    Instance *instance = component;
    if (!may(instance, INITIALIZATION, "fmi2ExitInitializationMode"))
        return fmi2Error;
    instance->now.state = STEP_COMPLETE;
    return answer(instance, instance->python.ExitInitializationMode(instance->slave), "fmi2ExitInitializationMode");
}

/* Whether a step ends after the end of the experiment, by more than what rounding adds up to in hosts that sum their
   steps; the standard has it refused. */
static int is_too_late(const Instance *instance, double time, double step_size)
{
    double rounding = 1e-9 * fmax(fmax(fabs(time), fabs(instance->stop)), step_size);
    return isfinite(step_size) && time + step_size - instance->stop > rounding;
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real time, fmi2Real step_size, fmi2Boolean no_earlier_state)
{
    Instance *instance = component;
    if (!may(instance, STEP_COMPLETE, "fmi2DoStep"))
        return fmi2Error;
    if (!isfinite(time))
        return refuse(instance, "fmi2DoStep: time = %g s is not allowed; it must be a finite number", time);
    if (is_too_late(instance, time, step_size))
        return decline(instance, "at t = %.9g s: a step of %g s would end after the stop time of the experiment, %.9g s",
                       time, step_size, instance->stop);
    instance->doing = STEPPING;
    instance->begin = time;
    instance->end = time + step_size;
    fmi2Status status = answer(instance, PYTHON(DoStep, time, step_size, no_earlier_state), "fmi2DoStep");
    if (status == fmi2OK) {
        instance->now.time = instance->end;
        *instance->now.reason = '\0';
    }
    return status;
}

fmi2Status fmi2Terminate(fmi2Component component)
{
    Instance *instance = component;
    if (!may(instance, STEP_COMPLETE, "fmi2Terminate"))
        return fmi2Error;
    instance->now.state = TERMINATED;
    return answer(instance, instance->python.Terminate(instance->slave), "fmi2Terminate");
}

/* PythonFMU makes a new instance, because one that it resets does not survive an exception of the new slave. */
fmi2Status fmi2Reset(fmi2Component component)
{
    Instance *instance = component;
    char reason[TEXT_SIZE];
    if (!may(instance, ANY, "fmi2Reset"))
        return fmi2Error;
    start_over(instance);
    instance->python.FreeInstance(instance->slave);
    if (begin_python(instance, reason))
        return fmi2OK;
    snprintf(instance->heard, sizeof instance->heard, "%s", reason);
    return answer(instance, fmi2Fatal, "fmi2Reset");
}
