/* Reads the bytes of the data from the resource location that a host passes. */

#ifndef AMB_RESOURCES_H
#define AMB_RESOURCES_H

#include <stddef.h>

enum { PATH_SIZE = 4096 };

#pragma GCC visibility push(hidden)

/* Write the path (PATH_SIZE, UTF-8) of the library with this code; 0 if unknown, as in WebAssembly. */
int library_path(char *path);

/* Whether a location without data may be a mistake of the host; a location that contains the data may not. */
int is_wrong_place(const char *location);

/* Write the folder of the resources of the FMU that this library lies in to `path` (PATH_SIZE), for hosts whose
   location is wrong; 0 if unknown. Whether it exists is not checked. */
int resources_beside_library(char *path);

/* The bytes of the file `model.bin` at a location, in memory that the caller frees; NULL with a `reason` (TEXT_SIZE) on
   failure. A location is a file URI, a path, or the bytes themselves as a data URI in base64. */
unsigned char *resource_bytes(const char *location, size_t *size, char *reason);

/* The folder at a location, which is a file URI or a path, without a final slash, in memory that the caller frees; NULL
   with a `reason` if it is not a folder of this machine. Whether it exists is not checked. */
char *resource_folder(const char *location, char *reason);

/* The bytes of a file in a folder, in memory that the caller frees; NULL with a `reason` if it cannot be read. */
unsigned char *file_bytes(const char *folder, const char *name, size_t *size, char *reason);

#pragma GCC visibility pop

#endif
