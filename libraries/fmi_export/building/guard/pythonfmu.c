#include "pythonfmu.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "data.h"
#include "resources.h"
#include "system.h"

static const char SUFFIX[] = "_pythonfmu"; /* of the name of PythonFMU's library */

static void take_line(char *line, const char **from, const char *end)
{
    const char *stop = memchr(*from, '\n', (size_t)(end - *from));
    int length = (int)((stop ? stop : end) - *from);
    snprintf(line, PATH_SIZE, "%.*s", length, *from);
    *from = stop ? stop + 1 : end;
}

static BuiltWith built_with(const char *resources)
{
    BuiltWith python = {"", ""};
    char reason[TEXT_SIZE];
    size_t size = 0;
    unsigned char *bytes = file_bytes(resources, "python.txt", &size, reason);
    if (bytes) {
        const char *at = (const char *)bytes, *end = at + size;
        take_line(python.library, &at, end);
        take_line(python.program, &at, end);
    }
    free(bytes);
    return python;
}

/* The path of PythonFMU's library: this library's with SUFFIX before the last dot. */
static int path_beside(char *path)
{
    char library[PATH_SIZE];
    if (!library_path(library))
        return 0;
    const char *dot = strrchr(library, '.');
    int length = (int)(dot ? (size_t)(dot - library) : strlen(library));
    return snprintf(path, PATH_SIZE, "%.*s%s%s", length, library, SUFFIX, dot ? dot : "") < PATH_SIZE;
}

/* The functions of the library at a path, which a Python that was started here does not survive the end of: an
   extension such as NumPy cannot be loaded by two Pythons in sequence. In a host in Python the library goes with the
   last instance, so that Windows lets the files of the FMU be deleted. */
static int load_functions(PythonFmu *pythonfmu, const char *path, char *reason)
{
    char why[EXCERPT];
    pythonfmu->stays = !python_runs();
    if (!(pythonfmu->library = load_library(path, why))) {
        snprintf(reason, TEXT_SIZE, "PythonFMU's library cannot be loaded: %s", why);
        return 0;
    }
#define TAKE(name) pythonfmu->name = (__typeof__(pythonfmu->name))function_in(pythonfmu->library, "fmi2" #name);
    PYTHONFMU_FUNCTIONS(TAKE)
#define IS_MISSING(name) | !pythonfmu->name
    if (!(0 PYTHONFMU_FUNCTIONS(IS_MISSING)))
        return 1;
    snprintf(reason, TEXT_SIZE, "%.*s is not the library of PythonFMU that belongs to this FMU", EXCERPT, path);
    return 0;
}

int open_pythonfmu(PythonFmu *pythonfmu, const char *resources, char *reason)
{
    char path[PATH_SIZE], why[EXCERPT];
    BuiltWith built = built_with(resources);
    memset(pythonfmu, 0, sizeof *pythonfmu);
    if (!path_beside(path))
        snprintf(reason, TEXT_SIZE, "the FMU cannot find its own library");
    else if (!provide_python(&built, why))
        snprintf(
            reason, TEXT_SIZE,
            "this FMU needs Python, but the process has none, and neither %.*s, with which the FMU was built, nor "
            "another one can be loaded (%s); name the folder of one that has NumPy in %s, or use the FMU of flavour "
            "native, which needs no Python",
            EXCERPT, *built.library ? built.library : "the one", why, LIBRARY_PATH);
    else
        return load_functions(pythonfmu, path, reason);
    return 0;
}

void close_pythonfmu(PythonFmu *pythonfmu)
{
    if (pythonfmu->library && !pythonfmu->stays)
        unload_library(pythonfmu->library);
    pythonfmu->library = NULL;
}

/* PythonFMU's library keeps a static shared pointer to its Python. Where static destructors run first at exit and a
   library's finaliser last, this one would release a pointer already destroyed, and decrement memory that is by then a
   link of the heap's free list. Called ahead of the destructors it leaves nothing to release. */
void finalise_at_exit(const PythonFmu *pythonfmu)
{
    static atomic_flag done = ATOMIC_FLAG_INIT;
    void *finaliser = function_in(pythonfmu->library, "finalizePythonInterpreter");
    if (finaliser && !atomic_flag_test_and_set(&done))
        call_at_exit((void (*)(void))finaliser);
}

/* PythonFMU takes %20 for a space, and the first file:// away. */
char *readable_folder(const char *folder, char *reason)
{
    char *path = malloc(PATH_SIZE);
    if (!path) {
        snprintf(reason, TEXT_SIZE, "there is no memory for the path of the resources");
        return NULL;
    }
    if (make_readable(path, folder, reason)) {
        if (!strstr(path, "%20") && !strstr(path, "file://"))
            return path;
        snprintf(reason, TEXT_SIZE, "PythonFMU cannot read a folder with %%20 in its path: %.*s", EXCERPT, path);
    }
    free(path);
    return NULL;
}
