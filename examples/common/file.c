#include "file.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FILE_MOST ((size_t)1 << 30)

bool fail(message *why, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    vsnprintf(why->text, sizeof why->text, format, list);
    va_end(list);
    return false;
}

// Grows as it reads instead of asking for the size first: pipes have none, and a directory only
// fails at the first read.
static bool read_all(FILE *file, unsigned char **bytes, size_t *size)
{
    size_t room = (size_t)1 << 16;
    *size = 0;
    *bytes = malloc(room);
    while (*bytes) {
        *size += fread(*bytes + *size, 1, room - *size, file);
        if (ferror(file)) break;
        if (*size < room) return true;
        if (room >= FILE_MOST) {
            errno = EFBIG;
            break;
        }
        room *= 2;
        unsigned char *grown = realloc(*bytes, room);
        if (!grown) break;
        *bytes = grown;
    }
    free(*bytes);
    *bytes = NULL;
    return false;
}

bool file_read(const char *path, unsigned char **bytes, size_t *size, message *why)
{
    FILE *file = fopen(path, "rb");
    if (!file) return fail(why, "%s: %s", path, strerror(errno));
    const bool read = read_all(file, bytes, size);
    if (!read) fail(why, "%s: %s", path, strerror(errno));
    fclose(file);
    return read;
}

bool file_write(const char *path, const void *bytes, size_t size, message *why)
{
    FILE *file = fopen(path, "wb");
    if (!file) return fail(why, "%s: %s", path, strerror(errno));
    const size_t written = fwrite(bytes, 1, size, file);
    // A full disk may show only when the last buffer is written out.
    const bool closed = fclose(file) == 0;
    if (written != size || !closed) return fail(why, "%s: %s", path, strerror(errno));
    return true;
}
