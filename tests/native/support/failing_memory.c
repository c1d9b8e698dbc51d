/* Preloaded: memory number FAILING that the library whose name contains LIBRARY asks for is refused, and no other. */

#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t count, size_t size);
extern void *__libc_realloc(void *memory, size_t size);

static int is_refused(const void *caller)
{
    static long count;
    const char *failing = getenv("FAILING"), *library = getenv("LIBRARY");
    Dl_info info;
    if (!failing || !library || !dladdr(caller, &info) || !info.dli_fname || !strstr(info.dli_fname, library))
        return 0;
    if (++count != strtol(failing, NULL, 10))
        return 0;
    errno = ENOMEM;
    return 1;
}

void *malloc(size_t size) { return is_refused(__builtin_return_address(0)) ? NULL : __libc_malloc(size); }

void *calloc(size_t count, size_t size)
{
    return is_refused(__builtin_return_address(0)) ? NULL : __libc_calloc(count, size);
}

void *realloc(void *memory, size_t size)
{
    return is_refused(__builtin_return_address(0)) ? NULL : __libc_realloc(memory, size);
}
