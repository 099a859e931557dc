// A few lines of text over a picture, in a font of 5 x 6 pixels that lives in the shader. Capitals,
// digits and signs; small letters are shown as capitals.
#ifndef GL_TEXT_H
#define GL_TEXT_H

#include "gl_draw.h"

#define GL_TEXT_LENGTH 1024

typedef struct gl_text {
    GLuint program, letters;
    gl_mesh none; // what is drawn comes from the vertex number
} gl_text;

bool gl_text_create(gl_text *t, message *why);
void gl_text_free(gl_text *t);

// Into the viewport of this size, the first line at the upper left; scale: pixels per font pixel.
void gl_text_draw(gl_text *t, const char *lines, int width, int height, int scale);

#endif
