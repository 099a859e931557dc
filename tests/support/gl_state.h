// Everything of the current GL context's state that drawing, dispatching or making objects could
// touch, as a list of named numbers: take it before and after a call and compare.
#ifndef GL_STATE_H
#define GL_STATE_H

#include <stdbool.h>

#include "../../examples/common/gl.h"

typedef struct gl_state_entry {
    char name[48]; // "DEPTH_FUNC", "TEXTURE_BINDING_2D[5]"
    double value[4];
} gl_state_entry;

typedef struct gl_state {
    gl_state_entry *entry;
    int count, capacity;
} gl_state;

// Fills a zero-initialized or earlier snapshot. Changes nothing in the context, raises no error.
void gl_state_take(gl_state *s);
void gl_state_free(gl_state *s);

// Number of differences whose names are not among the words of `allowed` (may be null; "VIEWPORT"
// allows all that VIEWPORT[0] does one of); the first few go to text, which holds size characters.
int gl_state_differences(const gl_state *before, const gl_state *after, const char *allowed,
                         char *text, int size);

// The value of an entry, or null. Names are those above.
const gl_state_entry *gl_state_find(const gl_state *s, const char *name);

// A caller from hell: every piece of state that has a usual value gets another one, and every
// binding point an object. Made by gl_state_make_unusual, undone with all objects by
// gl_state_make_usual, which leaves the context as a new one is.
typedef struct gl_unusual {
    GLuint textures[6], samplers[2], buffers[2], arrays[2], framebuffers[2], renderbuffer;
    GLuint pipeline, feedback, query, program, stencil;
    GLint viewport[4], scissor[4]; // of the window, if there is one
} gl_unusual;

void gl_state_make_unusual(gl_unusual *u);
void gl_state_make_usual(gl_unusual *u);

#endif
