#define _GNU_SOURCE

#include "system.h"

#include <dlfcn.h>
#include <errno.h>
#include <limits.h>
#include <link.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <wchar.h>

#include "data.h"

const char LIBRARY_PATH[] = "LD_LIBRARY_PATH";

/* Python ---------------------------------------------------------------------------------------------------------- */

static int python_is_here(void) { return dlsym(RTLD_DEFAULT, "Py_IsInitialized") != NULL; }

int python_runs(void)
{
    int (*is_initialised)(void) = (int (*)(void))dlsym(RTLD_DEFAULT, "Py_IsInitialized");
    return is_initialised && is_initialised();
}

/* Stop at a libpython among the libraries of the process, and write down its name. */
static int note_python(struct dl_phdr_info *info, size_t size, void *name)
{
    static const char PREFIX[] = "/libpython3";
    const char *file = info->dlpi_name ? strrchr(info->dlpi_name, '/') : NULL;
    (void)size;
    if (!file || strncmp(file, PREFIX, strlen(PREFIX)) != 0)
        return 0;
    snprintf(name, PATH_SIZE, "%s", info->dlpi_name);
    return 1;
}

/* Let everybody see a Python that the host has loaded for itself alone. */
static int show_loaded_python(void)
{
    char name[PATH_SIZE] = "";
    dl_iterate_phdr(note_python, name);
    return *name && dlopen(name, RTLD_NOW | RTLD_GLOBAL | RTLD_NOLOAD) && python_is_here();
}

/* Load the Python with which the FMU was built. It takes its packages from where the interpreter does, which may
   belong to a virtual environment. */
static int load_built_with(const BuiltWith *python)
{
    if (!*python->library || !dlopen(python->library, RTLD_NOW | RTLD_GLOBAL) || !python_is_here())
        return 0;
    void (*set_program)(const wchar_t *) = (void (*)(const wchar_t *))dlsym(RTLD_DEFAULT, "Py_SetProgramName");
    wchar_t *(*decode)(const char *, size_t *) =
        (wchar_t * (*)(const char *, size_t *)) dlsym(RTLD_DEFAULT, "Py_DecodeLocale");
    wchar_t *program = decode && access(python->program, X_OK) == 0 ? decode(python->program, NULL) : NULL;
    if (set_program && program)
        set_program(program); /* which keeps the text */
    return 1;
}

static int load_newest_python(void)
{
    char name[40];
    for (int minor = 40; minor >= 11; minor--) {
        snprintf(name, sizeof name, "libpython3.%d.so.1.0", minor);
        if (dlopen(name, RTLD_NOW | RTLD_GLOBAL))
            return python_is_here();
    }
    return 0;
}

static void write_error(char *why)
{
    const char *said = dlerror();
    snprintf(why, EXCERPT, "%s", said ? said : "without a reason");
}

int provide_python(const BuiltWith *python, char *why)
{
    if (python_is_here() || show_loaded_python() || load_built_with(python) || load_newest_python())
        return 1;
    write_error(why);
    return 0;
}

/* Libraries ------------------------------------------------------------------------------------------------------- */

/* It is never unloaded: its destructors are registered, and the C library would keep it for its unique symbols
   anyway. */
void *load_library(const char *path, char *why)
{
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (!library)
        write_error(why);
    return library;
}

void unload_library(void *library) { dlclose(library); }

void *function_in(void *library, const char *name) { return dlsym(library, name); }

extern int __cxa_atexit(void (*)(void *), void *, void *);

/* Exit handlers run last in, first out, and those of static destructors were registered when the library was loaded. */
void call_at_exit(void (*finaliser)(void)) { __cxa_atexit((void (*)(void *))finaliser, NULL, NULL); }

/* Folders --------------------------------------------------------------------------------------------------------- */

static int is_utf8(const char *text)
{
    while (*text) {
        unsigned char first = (unsigned char)*text++;
        int more = first < 0x80 ? 0 : first < 0xc2 ? -1 : first < 0xe0 ? 1 : first < 0xf0 ? 2 : first < 0xf5 ? 3 : -1;
        for (; more > 0 && ((unsigned char)*text & 0xc0) == 0x80; more--)
            text++;
        if (more)
            return 0;
    }
    return 1;
}

/* PythonFMU gives the folder to Python as UTF-8. It is absolute, because it stays in Python's list of folders
   whatever the working folder becomes. */
int make_readable(char *path, const char *folder, char *reason)
{
    _Static_assert(PATH_SIZE >= PATH_MAX, "realpath writes up to PATH_MAX");
    if (!realpath(folder, path)) {
        snprintf(reason, TEXT_SIZE, "cannot read %.*s: %s", EXCERPT, folder, strerror(errno));
        return 0;
    }
    if (!is_utf8(path))
        snprintf(reason, TEXT_SIZE, "PythonFMU cannot read a folder whose name is not UTF-8: %.*s", EXCERPT, path);
    return is_utf8(path);
}
