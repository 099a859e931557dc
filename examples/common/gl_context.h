// An OpenGL 4.5 core context without a window, for programs that write pictures or test shaders.
// libEGL is opened at run time, so nothing has to be installed to compile or link (glibc before
// 2.34 wants -ldl).
#ifndef GL_CONTEXT_H
#define GL_CONTEXT_H

#include "gl.h"

typedef struct gl_context {
    void *display, *context;
} gl_context;

// Makes a debug context (with the environment variable GL_COMPATIBILITY one of the compatibility
// profile, as many engines have), current on the calling thread, and fills the table gl. There is
// no default framebuffer: render into your own. On failure *why is one line that says what is
// missing and what installs it; nothing stays open.
bool gl_context_create(gl_context *c, const char **why);
// The same of OpenGL 3.3 core or, with es, of OpenGL ES 3.0 (drivers may give a newer one); gl
// stays as it is: what these have is the table of gl_portable.h.
bool gl_context_create_portable(gl_context *c, bool es, const char **why);
void gl_context_destroy(gl_context *c);

// Address of a GL function, null if there is none: the loader for gl_load() and mssm_gl_desc.
void (*gl_context_function(const char *name))(void);

#endif
