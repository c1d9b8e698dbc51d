/* Models that a host runs: with kernels of their own, or assemblies, whose parts the loop of the master steps, each a
   run with its kernels. */

#ifndef AMB_ASSEMBLY_H
#define AMB_ASSEMBLY_H

#include "instance.h"

#pragma GCC visibility push(hidden)

/* Make ready what a run calls, by the name of its instance and the location of its resources; 0 with a `reason`
   (TEXT_SIZE) if there is none. */
int run_open(Run *run, const char *name, const char *location, char *reason);
void run_close(Run *run);

#pragma GCC visibility pop

#endif
