/* PythonFMU's library, which lies beside this one. */

#ifndef AMB_PYTHONFMU_H
#define AMB_PYTHONFMU_H

#include "fmi2Functions.h"

#define PYTHONFMU_FUNCTIONS(X) X(Instantiate) X(FreeInstance) X(SetString) X(EnterInitializationMode) X(DoStep)

typedef struct {
    void *library;
    int stays; /* to the end of the process */
#define POINTER(name) __typeof__(fmi2##name) *name;
    PYTHONFMU_FUNCTIONS(POINTER)
#undef POINTER
} PythonFmu;

#pragma GCC visibility push(hidden)

/* Load PythonFMU's library, and a Python before it if this process has none; `resources` is the folder in which
   python.txt names the interpreter that the FMU was built with. 0 with a `reason` (TEXT_SIZE) if either cannot be
   had. */
int open_pythonfmu(PythonFmu *pythonfmu, const char *resources, char *reason);

/* Let go of the library after an instance of it was freed, or could not be made. */
void close_pythonfmu(PythonFmu *pythonfmu);

/* See to it that the process ends well. To be called when an instance was made or not, so that what Python has
   loaded by then still exists when it is finalised. */
void finalise_at_exit(const PythonFmu *pythonfmu);

/* The folder as PythonFMU can read it, in memory that the caller frees; NULL with a `reason` if it cannot. */
char *readable_folder(const char *folder, char *reason);

#pragma GCC visibility pop

#endif
