/* The two kernels of a model as a run calls them: compiled.c has them as machine code, ../guard/interpreted.c in
   Python. */

#ifndef AMB_KERNELS_H
#define AMB_KERNELS_H

#include <stdint.h>

struct Run; /* of instance.h */

#pragma GCC visibility push(hidden)

/* Prepare calls of the kernels of a run, by the name of its instance and the location of its resources; 0 with a
   `reason` (TEXT_SIZE) on failure. */
int open_kernels(struct Run *run, const char *name, const char *location, char *reason);
void close_kernels(struct Run *run);

/* Call a kernel on the arrays of a run, whose addresses are not stored; return NULL with its `fault`, or the reason of
   a failure. */
const char *call_initialise(struct Run *run, int64_t *fault);
const char *call_step(struct Run *run, double time, double step_size, int64_t *fault);

#pragma GCC visibility pop

#endif
