#define _GNU_SOURCE /* for dladdr */

#include "resources.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
#elif (defined __unix__ || defined __APPLE__ || defined __QNX__) && !defined __wasm__
#include <dlfcn.h>
#define HAS_DLADDR
#endif

#include "data.h"

static const char NO_MEMORY[] = "there is no memory for the path of the resources";
enum { EXCERPT = 400 }; /* characters of a location in a reason */

static char lower(char c) { return c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c; }

/* What follows `prefix` in `text`, or NULL; capitals do not matter. */
static const char *after(const char *text, const char *prefix)
{
    for (; *prefix; text++, prefix++)
        if (lower(*text) != *prefix)
            return NULL;
    return text;
}

static int digit(char c)
{
    return c >= '0' && c <= '9' ? c - '0' : lower(c) >= 'a' && lower(c) <= 'f' ? lower(c) - 'a' + 10 : -1;
}

/* Replace %20 and the like in place; a percent sign without two digits stands for itself, as in paths that a host
   did not encode. */
static void decode_percent(char *text)
{
    char *to = text;
    for (; *text; text++) {
        int high = *text == '%' ? digit(text[1]) : -1, low = high >= 0 ? digit(text[2]) : -1;
        int code = low >= 0 ? 16 * high + low : 0;
        *to++ = code ? (char)code : *text;
        text += code ? 2 : 0;
    }
    *to = '\0';
}

/* Files ----------------------------------------------------------------------------------------------------------- */

static int has_drive(const char *path) { return lower(path[0]) >= 'a' && lower(path[0]) <= 'z' && path[1] == ':'; }

/* Whether a location begins with the scheme of a URI; the single letter of a drive is none. */
static int has_scheme(const char *location)
{
    size_t length = strcspn(location, ":/\\");
    return length > 1 && location[length] == ':' && location[length + 1] == '/';
}

char *resource_folder(const char *location, char *reason)
{
    if (!location || !*location) {
        snprintf(reason, TEXT_SIZE, "the host gave no resource location; it must be the folder with model.bin");
        return NULL;
    }
    const char *path = after(location, "file:");
    int encoded = path != NULL;
    if (!encoded)
        path = location;
    else if (path[0] == '/' && path[1] == '/') {
        const char *host = path + 2, *local = after(host, "localhost");
        if (local && *local == '/')
            path = local;
        else if (*host == '/' || has_drive(host))
            path = host;
#ifndef _WIN32 /* where //host/folder is a path */
        else
            path = NULL;
#endif
    }
    if (!path || (!encoded && has_scheme(location))) {
        snprintf(reason, TEXT_SIZE, "the resource location %.*s is not on this machine", EXCERPT, location);
        return NULL;
    }
    char *folder = malloc(strlen(path) + 1);
    if (!folder) {
        snprintf(reason, TEXT_SIZE, "%s", NO_MEMORY);
        return NULL;
    }
    strcpy(folder, path);
    if (encoded)
        decode_percent(folder);
#ifdef _WIN32
    if (folder[0] == '/' && has_drive(folder + 1))
        memmove(folder, folder + 1, strlen(folder));
#endif
    size_t length = strlen(folder);
    while (length > 0 && (folder[length - 1] == '/' || folder[length - 1] == '\\'))
        folder[--length] = '\0';
    return folder;
}

/* Places beside this library --------------------------------------------------------------------------------------- */

int library_path(char *path)
{
#if defined _WIN32
    static const char here;
    wchar_t wide[PATH_SIZE];
    HMODULE self;
    return GetModuleHandleExW(GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS | GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT,
                              (const wchar_t *)&here, &self) &&
           GetModuleFileNameW(self, wide, PATH_SIZE) < PATH_SIZE &&
           WideCharToMultiByte(CP_UTF8, 0, wide, -1, path, PATH_SIZE, NULL, NULL) > 0;
#elif defined HAS_DLADDR
    static const char here;
    Dl_info self;
    return dladdr(&here, &self) && self.dli_fname && snprintf(path, PATH_SIZE, "%s", self.dli_fname) < PATH_SIZE;
#else
    (void)path;
    return 0;
#endif
}

int resources_beside_library(char *path)
{
    static const char PLACE[] = "resources";
    int levels = 3; /* from binaries/<platform>/<library> up */
    size_t length = library_path(path) ? strlen(path) : 0;
    while (length > 0 && levels > 0) {
        length--;
        levels -= path[length] == '/' || path[length] == '\\';
    }
    if (levels > 0 || length + sizeof PLACE >= PATH_SIZE)
        return 0;
    strcpy(path + length + 1, PLACE);
    return 1;
}

/* Content ---------------------------------------------------------------------------------------------------------- */

static FILE *open_file(const char *path)
{
#ifdef _WIN32
    int length = MultiByteToWideChar(CP_UTF8, MB_ERR_INVALID_CHARS, path, -1, NULL, 0);
    wchar_t *wide = length > 0 ? malloc((size_t)length * sizeof *wide) : NULL;
    if (!wide) {
        errno = EINVAL;
        return NULL;
    }
    MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, length);
    FILE *file = _wfopen(wide, L"rb");
    free(wide);
    return file;
#else
    return fopen(path, "rb");
#endif
}

static unsigned char *content_of(FILE *file, size_t *size)
{
    size_t room = 1 << 16, read;
    unsigned char *bytes = malloc(room);
    *size = 0;
    while (bytes && (read = fread(bytes + *size, 1, room - *size, file)) > 0) {
        *size += read;
        if (*size < room)
            continue;
        unsigned char *larger = realloc(bytes, room *= 2);
        if (!larger)
            free(bytes);
        bytes = larger;
    }
    if (bytes && ferror(file)) {
        free(bytes);
        bytes = NULL;
    }
    return bytes;
}

unsigned char *file_bytes(const char *folder, const char *name, size_t *size, char *reason)
{
    char *path = malloc(strlen(folder) + strlen(name) + 2);
    if (!path) {
        snprintf(reason, TEXT_SIZE, "%s", NO_MEMORY);
        return NULL;
    }
    sprintf(path, "%s/%s", folder, name);
    FILE *file = open_file(path);
    unsigned char *bytes = file ? content_of(file, size) : NULL;
    if (!bytes)
        snprintf(reason, TEXT_SIZE, "cannot read %.*s: %s", EXCERPT, path, strerror(errno));
    if (file)
        fclose(file);
    free(path);
    return bytes;
}

/* Data URIs ------------------------------------------------------------------------------------------------------- */

static int base64_digit(char c)
{
    static const char DIGITS[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char *at = c ? strchr(DIGITS, c) : NULL;
    return at ? (int)(at - DIGITS) : -1;
}

/* The bytes of `data:...;base64,DIGITS`, of which `rest` follows the colon. */
static unsigned char *bytes_of_uri(const char *rest, size_t *size, char *reason)
{
    const char *digits = strstr(rest, ";base64,");
    if (!digits || digits > rest + strcspn(rest, ",")) {
        snprintf(reason, TEXT_SIZE, "a data URI with the resources must be in base64: data:;base64,...");
        return NULL;
    }
    digits += strlen(";base64,");
    unsigned char *bytes = malloc(strlen(digits) / 4 * 3 + 3);
    if (!bytes) {
        snprintf(reason, TEXT_SIZE, "there is no memory for the resources");
        return NULL;
    }
    unsigned int group = 0, bits = 0;
    *size = 0;
    for (; base64_digit(*digits) >= 0; digits++) {
        group = group << 6 | (unsigned int)base64_digit(*digits);
        bits += 6;
        if (bits >= 8) {
            bits -= 8;
            bytes[(*size)++] = (unsigned char)(group >> bits);
        }
    }
    if (digits[strspn(digits, "=")]) {
        snprintf(reason, TEXT_SIZE, "the data URI with the resources is not valid base64 at character %zu",
                 (size_t)(digits - rest) + strlen("data:") + 1);
        free(bytes);
        return NULL;
    }
    return bytes;
}

static const char *of_data_uri(const char *location) { return location ? after(location, "data:") : NULL; }

int is_wrong_place(const char *location) { return !of_data_uri(location); }

unsigned char *resource_bytes(const char *location, size_t *size, char *reason)
{
    const char *rest = of_data_uri(location);
    if (rest)
        return bytes_of_uri(rest, size, reason);
    char *folder = resource_folder(location, reason);
    unsigned char *bytes = folder ? file_bytes(folder, "model.bin", size, reason) : NULL;
    free(folder);
    return bytes;
}
