// A small PNG encoder: 8-bit RGB, row filters, LZ77 with the fixed Huffman code.
#ifndef PNG_H
#define PNG_H

#include "file.h"

// The file's bytes, from malloc; NULL when memory runs out. Width and height from 1 to 32768.
unsigned char *png_encode(const unsigned char *rgb8, int width, int height, size_t *size);
bool png_write(const char *path, const unsigned char *rgb8, int width, int height, message *why);

#endif
