// The shaders whose machine code is looked at, made without OpenGL.
#ifndef TEXTS_H
#define TEXTS_H

#include <stdbool.h>

#include "../compare/gl_convolution.h"
#include "../compare/gl_percentage_closer.h"

enum { TEXTS_ROOM = 1 << 17 };

// Visibility functions, each called from a compute shader as a deferred pass calls it: the position
// from an image, the light the same for all threads.
bool texts_layered(char *text, int moments, const mssm_settings *settings);
bool texts_filtered(char *text, int moments);
bool texts_reference(char *text, gl_reference_kind kind);
bool texts_samples(char *text, gl_percentage_closer_kind kind);
bool texts_convolution(char *text, gl_convolution_filter filter, int terms);
// A compute kernel of either header, by the label that it has in OpenGL.
bool texts_kernel(char *text, const char *label, int moments);

#endif
