/* What PythonFMU and Python need of the operating system; linux.c and windows.c have it. Paths are in UTF-8. */

#ifndef AMB_SYSTEM_H
#define AMB_SYSTEM_H

#include <stddef.h>

#include "resources.h"

enum { EXCERPT = 1000 /* characters of a path or a text in a reason */ };

/* The Python with which the FMU was built: its library and its interpreter; empty where it has none. */
typedef struct {
    char library[PATH_SIZE], program[PATH_SIZE];
} BuiltWith;

#pragma GCC visibility push(hidden)

/* Make Python's functions available to libraries that are loaded after this: those of the process, or else those of a
   Python that is loaded. 0, and `why` (EXCERPT), without any. */
int provide_python(const BuiltWith *python, char *why);

/* Where the libraries of another Python may be named: a variable of the environment. */
extern const char LIBRARY_PATH[];

/* Whether Python was started; only after `provide_python`. */
int python_runs(void);

/* A library, or NULL and `why` (EXCERPT). */
void *load_library(const char *path, char *why);
void unload_library(void *library);
void *function_in(void *library, const char *name);

/* Write the folder as PythonFMU can read it to `path` (PATH_SIZE); 0 with a `reason` (TEXT_SIZE) if it cannot. */
int make_readable(char *path, const char *folder, char *reason);

/* Have a library's finaliser called when the process exits, ahead of the destructors of its static objects; nothing
   where that is the order of things. */
void call_at_exit(void (*finaliser)(void));

#pragma GCC visibility pop

#endif
