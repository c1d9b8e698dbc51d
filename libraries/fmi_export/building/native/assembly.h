/* Runs of models with kernels, and of assemblies, whose parts are stepped by the loop of the master; each part is a run
   with kernels. */

#ifndef AMB_ASSEMBLY_H
#define AMB_ASSEMBLY_H

#include "instance.h"

#pragma GCC visibility push(hidden)

/* Prepare the kernels or the parts of a run, by the name of its instance and the location of its resources; 0 with a
   `reason` (TEXT_SIZE) on failure. */
int run_open(Run *run, const char *name, const char *location, char *reason);
void run_close(Run *run);

#pragma GCC visibility pop

#endif
