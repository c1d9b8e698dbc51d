/* Assemblies: models whose parts the loop of the master steps, each a run with its kernels. */

#ifndef AMB_ASSEMBLY_H
#define AMB_ASSEMBLY_H

#include "instance.h"

#pragma GCC visibility push(hidden)

/* As `open_kernels` and `close_kernels`, for the parts of an assembly. */
int open_assembly(Run *run, const char *location, char *reason);
void close_assembly(Run *run);

/* Initialise, or step, all parts, and leave their outputs in `next_outputs`. What stops a part stops the run. The
   answer is a fault of the assembly itself, or 0. */
int64_t initialise_assembly(Run *run);
int64_t step_assembly(Run *run, double time, double step_size);

#pragma GCC visibility pop

#endif
