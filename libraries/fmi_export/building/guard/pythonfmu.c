/* Python's functions are found in three places: in the process (a host in Python), in a library that the host has loaded
   for itself alone, and in one that is loaded here: the one with which the FMU was built, or the newest that the loader
   finds. PythonFMU's library starts that Python when there is an instance.

   In a process that PythonFMU started Python in, its library must stay: an extension such as NumPy cannot be loaded by two
   Pythons one after the other. In a host in Python it goes with the last instance, so that Windows lets the files of the
   FMU be deleted. */

#define _GNU_SOURCE

#include "pythonfmu.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "data.h"
#include "resources.h"

enum { PATH_SIZE = 4096, SHOWN = 1000 };
static const char SUFFIX[] = "_pythonfmu"; /* of the name of PythonFMU's library beside this one */
static const char NO_PYTHON[] =
    "this FMU needs Python, and the process has none: neither %s, with which it was built, nor another could be loaded (%.*s). "
    "Start the host with a Python that has NumPy in %s, or take the FMU of flavour native, which needs no Python";

/* Name and interpreter of the Python with which the FMU was built: two lines of python.txt. */
typedef struct {
    char library[PATH_SIZE], program[PATH_SIZE];
} BuiltWith;

static void take_line(char *line, const char **from, const char *end)
{
    const char *stop = memchr(*from, '\n', (size_t)(end - *from));
    size_t length = (size_t)((stop ? stop : end) - *from);
    snprintf(line, PATH_SIZE, "%.*s", (int)length, *from);
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

/* This library's own path with SUFFIX before the last dot. */
static int beside(char *path, const char *own)
{
    const char *dot = strrchr(own, '.');
    int length = dot ? (int)(dot - own) : (int)strlen(own);
    return snprintf(path, PATH_SIZE, "%.*s%s%s", length, own, SUFFIX, dot ? dot : "") < PATH_SIZE;
}

static int is_whole(const PythonFmu *library, const char *path, char *reason)
{
#define IS_THERE(name) && library->name
    if (1 PYTHONFMU_FUNCTIONS(IS_THERE))
        return 1;
    snprintf(reason, TEXT_SIZE, "%.*s is not the library of PythonFMU that belongs to this FMU", SHOWN, path);
    return 0;
}

#ifdef _WIN32

#include <windows.h>

typedef int (*Question)(void);

/* Take the text out of the wide one; 0 if it does not fit. */
static int narrow(char *text, const wchar_t *wide)
{
    return WideCharToMultiByte(CP_UTF8, 0, wide, -1, text, PATH_SIZE, NULL, NULL) > 0;
}

static HMODULE load(const char *path)
{
    wchar_t wide[PATH_SIZE];
    if (MultiByteToWideChar(CP_UTF8, MB_ERR_INVALID_CHARS, path, -1, wide, PATH_SIZE) <= 0)
        return NULL;
    return LoadLibraryExW(wide, NULL, strpbrk(path, "/\\") ? LOAD_WITH_ALTERED_SEARCH_PATH : 0);
}

static int python_runs(HMODULE python)
{
    Question is_initialised = python ? (Question)(void *)GetProcAddress(python, "Py_IsInitialized") : NULL;
    return is_initialised && is_initialised();
}

static void last_error(char *text, size_t size)
{
    DWORD code = GetLastError();
    if (!FormatMessageA(FORMAT_MESSAGE_FROM_SYSTEM | FORMAT_MESSAGE_IGNORE_INSERTS, NULL, code, 0, text, (DWORD)size, NULL))
        snprintf(text, size, "error %lu", (unsigned long)code);
    text[strcspn(text, "\r\n")] = '\0';
}

int open_pythonfmu(PythonFmu *library, const char *resources, char *reason)
{
    static const char here;
    wchar_t wide[PATH_SIZE];
    char own[PATH_SIZE], path[PATH_SIZE], why[SHOWN];
    HMODULE self;
    memset(library, 0, sizeof *library);
    if (!GetModuleHandleExW(GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS | GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT,
                            (const wchar_t *)&here, &self) ||
        !GetModuleFileNameW(self, wide, PATH_SIZE) || !narrow(own, wide) || !beside(path, own)) {
        snprintf(reason, TEXT_SIZE, "the FMU does not find its own library");
        return 0;
    }
    HMODULE python = GetModuleHandleW(L"python3.dll");
    if (!python) {
        BuiltWith built = built_with(resources);
        if (!(python = load("python3.dll")) && !(*built.library && (python = load(built.library)))) {
            last_error(why, sizeof why);
            snprintf(reason, TEXT_SIZE, NO_PYTHON, *built.library ? built.library : "the one", SHOWN, why, "PATH");
            return 0;
        }
    }
    library->stays = !python_runs(python);
    if (!(library->handle = load(path))) {
        last_error(why, sizeof why);
        snprintf(reason, TEXT_SIZE, "PythonFMU's library %.*s cannot be loaded: %s", SHOWN, path, why);
        return 0;
    }
#define TAKE(name) library->name = (__typeof__(library->name))(void *)GetProcAddress(library->handle, "fmi2" #name);
    PYTHONFMU_FUNCTIONS(TAKE)
    return is_whole(library, path, reason);
}

void close_pythonfmu(PythonFmu *library)
{
    if (library->handle && !library->stays)
        FreeLibrary(library->handle);
    library->handle = NULL;
}

void finalise_at_exit(const PythonFmu *library)
{
    (void)library; /* a library's finaliser runs first here */
}

/* PythonFMU gives the folder to Python as UTF-8 and opens files in the code page of the machine. What both can read is a
   path in ASCII, as the short names of folders are. */
static int is_ascii(const char *text)
{
    for (; *text; text++)
        if ((unsigned char)*text > 127)
            return 0;
    return 1;
}

static int shorten(char *path)
{
    wchar_t wide[PATH_SIZE], brief[PATH_SIZE];
    DWORD length = 0;
    if (MultiByteToWideChar(CP_UTF8, MB_ERR_INVALID_CHARS, path, -1, wide, PATH_SIZE) > 0)
        length = GetShortPathNameW(wide, brief, PATH_SIZE);
    return length > 0 && length < PATH_SIZE && narrow(path, brief);
}

static int make_readable(char *path, const char *folder, char *reason)
{
    snprintf(path, PATH_SIZE, "%s", folder);
    if (is_ascii(path) || (shorten(path) && is_ascii(path)))
        return 1;
    snprintf(reason, TEXT_SIZE, "PythonFMU reads no folder with letters beyond ASCII on Windows: %.*s", SHOWN, folder);
    return 0;
}

#else

#include <dlfcn.h>
#include <errno.h>
#include <limits.h>
#include <link.h>
#include <unistd.h>

extern int __cxa_atexit(void (*)(void *), void *, void *);

static int python_is_here(void)
{
    return dlsym(RTLD_DEFAULT, "Py_IsInitialized") != NULL;
}

/* The name of a libpython among the libraries of the process, or an empty text. */
static int note_python(struct dl_phdr_info *info, size_t size, void *name)
{
    const char *file = info->dlpi_name ? strrchr(info->dlpi_name, '/') : NULL;
    (void)size;
    if (!file || strncmp(file, "/libpython3", strlen("/libpython3")) != 0)
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

/* Load the Python with which the FMU was built; it takes its packages from where that interpreter does. */
static int load_built_with(const BuiltWith *built)
{
    if (!*built->library || !dlopen(built->library, RTLD_NOW | RTLD_GLOBAL) || !python_is_here())
        return 0;
    void (*set_program)(const wchar_t *) = (void (*)(const wchar_t *))dlsym(RTLD_DEFAULT, "Py_SetProgramName");
    wchar_t *(*decode)(const char *, size_t *) =
        (wchar_t * (*)(const char *, size_t *)) dlsym(RTLD_DEFAULT, "Py_DecodeLocale");
    wchar_t *program = decode && access(built->program, X_OK) == 0 ? decode(built->program, NULL) : NULL;
    if (set_program && program)
        set_program(program); /* which keeps the text */
    return 1;
}

static int load_newest_python(void)
{
    char name[40];
    for (int minor = 40; minor >= 9; minor--) {
        snprintf(name, sizeof name, "libpython3.%d.so.1.0", minor);
        if (dlopen(name, RTLD_NOW | RTLD_GLOBAL))
            return python_is_here();
    }
    return 0;
}

static int provide_python(const char *resources, char *reason)
{
    if (python_is_here() || show_loaded_python())
        return 1;
    BuiltWith built = built_with(resources);
    if (load_built_with(&built) || load_newest_python())
        return 1;
    const char *why = dlerror();
    snprintf(reason, TEXT_SIZE, NO_PYTHON, *built.library ? built.library : "the one", SHOWN, why ? why : "no symbols",
             "LD_LIBRARY_PATH");
    return 0;
}

int open_pythonfmu(PythonFmu *library, const char *resources, char *reason)
{
    static const char here;
    char path[PATH_SIZE];
    Dl_info self;
    memset(library, 0, sizeof *library);
    library->stays = 1; /* the C library would not unload it anyway */
    if (!dladdr(&here, &self) || !self.dli_fname || !beside(path, self.dli_fname)) {
        snprintf(reason, TEXT_SIZE, "the FMU does not find its own library");
        return 0;
    }
    if (!provide_python(resources, reason))
        return 0;
    if (!(library->handle = dlopen(path, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE))) {
        const char *why = dlerror();
        snprintf(reason, TEXT_SIZE, "PythonFMU's library cannot be loaded: %s", why ? why : path);
        return 0;
    }
#define TAKE(name) library->name = (__typeof__(library->name))dlsym(library->handle, "fmi2" #name);
    PYTHONFMU_FUNCTIONS(TAKE)
    return is_whole(library, path, reason);
}

void close_pythonfmu(PythonFmu *library)
{
    library->handle = NULL;
}

/* PythonFMU's library keeps a static shared pointer to its Python. At exit the C library runs static destructors first and
   a library's finaliser last, which then releases a pointer already destroyed and decrements memory that is by then a
   link of the heap's free list. As an exit handler the finaliser runs ahead of the destructors, which were registered when
   the library was loaded, and leaves nothing to release. */
void finalise_at_exit(const PythonFmu *library)
{
    static atomic_flag registered = ATOMIC_FLAG_INIT;
    void (*finaliser)(void *) = (void (*)(void *))dlsym(library->handle, "finalizePythonInterpreter");
    if (finaliser && !atomic_flag_test_and_set(&registered))
        __cxa_atexit(finaliser, NULL, NULL);
}

/* PythonFMU gives the folder to Python as UTF-8. */
static int is_utf8(const char *text)
{
    for (; *text; text++) {
        unsigned char first = (unsigned char)*text;
        int more = first < 0x80 ? 0 : first >= 0xc2 && first < 0xe0 ? 1 : first >= 0xe0 && first < 0xf0 ? 2
                   : first >= 0xf0 && first < 0xf5                  ? 3
                                                                    : -1;
        for (; more > 0 && ((unsigned char)text[1] & 0xc0) == 0x80; more--)
            text++;
        if (more)
            return 0;
    }
    return 1;
}

/* An absolute path, because it stays in Python's list of folders, whatever the working folder becomes. */
static int make_readable(char *path, const char *folder, char *reason)
{
    _Static_assert(PATH_SIZE >= PATH_MAX, "realpath fills up to PATH_MAX");
    if (!realpath(folder, path)) {
        snprintf(reason, TEXT_SIZE, "cannot read %.*s: %s", SHOWN, folder, strerror(errno));
        return 0;
    }
    if (!is_utf8(path))
        snprintf(reason, TEXT_SIZE, "PythonFMU reads no folder whose name is not UTF-8: %.*s", SHOWN, path);
    return is_utf8(path);
}

#endif

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
        snprintf(reason, TEXT_SIZE, "PythonFMU reads no folder whose name contains %%20: %.*s", SHOWN, path);
    }
    free(path);
    return NULL;
}
