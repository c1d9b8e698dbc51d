/* From the resource location that a host gives to the bytes of the data. */

#ifndef AMB_RESOURCES_H
#define AMB_RESOURCES_H

#include <stddef.h>

#pragma GCC visibility push(hidden)

/* The bytes of the file `model.bin` at a location, in memory that the caller frees; NULL with a `reason` (TEXT_SIZE) if
   there are none. A location is a file URI, a path, or the bytes themselves as a data URI in base64. */
unsigned char *resource_bytes(const char *location, size_t *size, char *reason);

#pragma GCC visibility pop

#endif
