#include "system.h"

#include <stdio.h>
#include <string.h>
#include <windows.h>

#include "data.h"

const char LIBRARY_PATH[] = "PATH";

static int narrow(char *text, const wchar_t *wide)
{
    return WideCharToMultiByte(CP_UTF8, 0, wide, -1, text, PATH_SIZE, NULL, NULL) > 0;
}

static int widen(wchar_t *wide, const char *text)
{
    return MultiByteToWideChar(CP_UTF8, MB_ERR_INVALID_CHARS, text, -1, wide, PATH_SIZE) > 0;
}

/* Python ---------------------------------------------------------------------------------------------------------- */

/* PythonFMU's library asks for python3.dll, which hands over to the Python that it belongs to: that of the process,
   or the library in whose folder it lies. */
static const char PYTHON[] = "python3.dll";

int provide_python(const BuiltWith *python, char *why)
{
    return load_library(PYTHON, why) || (*python->library && load_library(python->library, why));
}

int python_runs(void)
{
    HMODULE python = GetModuleHandleA(PYTHON);
    int (*is_initialised)(void) = python ? (int (*)(void))(void *)GetProcAddress(python, "Py_IsInitialized") : NULL;
    return is_initialised && is_initialised();
}

/* Libraries ------------------------------------------------------------------------------------------------------- */

void *load_library(const char *path, char *why)
{
    wchar_t wide[PATH_SIZE];
    HMODULE library = NULL;
    if (widen(wide, path))
        library = LoadLibraryExW(wide, NULL, strpbrk(path, "/\\") ? LOAD_WITH_ALTERED_SEARCH_PATH : 0);
    if (!library)
        snprintf(why, EXCERPT, "%s: error %lu of Windows", path, (unsigned long)GetLastError());
    return library;
}

void unload_library(void *library) { FreeLibrary(library); }

void *function_in(void *library, const char *name) { return (void *)GetProcAddress(library, name); }

void call_at_exit(void (*finaliser)(void)) { (void)finaliser; }

/* Folders --------------------------------------------------------------------------------------------------------- */

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
    DWORD length = widen(wide, path) ? GetShortPathNameW(wide, brief, PATH_SIZE) : 0;
    return length > 0 && length < PATH_SIZE && narrow(path, brief);
}

/* PythonFMU gives the folder to Python as UTF-8 and opens files in the code page of the machine. Both read ASCII, in
   which the short names of folders are. */
int make_readable(char *path, const char *folder, char *reason)
{
    snprintf(path, PATH_SIZE, "%s", folder);
    if (is_ascii(path) || (shorten(path) && is_ascii(path)))
        return 1;
    snprintf(reason, TEXT_SIZE, "PythonFMU cannot read a folder with letters beyond ASCII on Windows: %.*s", EXCERPT,
             folder);
    return 0;
}
