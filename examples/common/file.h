// Whole files in and out of memory, and the one clear line that a failure leaves behind.
#ifndef FILE_H
#define FILE_H

#include <stdbool.h>
#include <stddef.h>

typedef struct message {
    char text[256]; // no newline; empty when all went well
} message;

// Writes the line and returns false, so that a failing function ends in `return fail(why, ...)`.
#if defined __GNUC__
__attribute__((format(printf, 2, 3)))
#endif
bool fail(message *why, const char *format, ...);

// Reads a file to its end; the caller frees *bytes. More than 1 GiB is refused.
bool file_read(const char *path, unsigned char **bytes, size_t *size, message *why);
bool file_write(const char *path, const void *bytes, size_t size, message *why);

#endif
