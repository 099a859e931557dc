// What examples share that draw with OpenGL 4.5 and without a window.
#ifndef GL_EXAMPLE_H
#define GL_EXAMPLE_H

#include "../../mssm.h"
#include "gl_context.h"
#include "gl_draw.h"
#include "options.h"

// Their main(): prints the usage, which begins with the program's name, where --help asks for it.
// Else makes a context, runs, and writes to stderr what went wrong.
int gl_example_main(int argc, char **argv, const char *usage,
                    bool (*run)(int argc, char **argv, message *why));

// Draws casters into a light's map with a program of gl_depth_vertex.
void gl_example_map(mssm_gl *maps, int index, const mssm_light *light, GLuint depth,
                    const gl_mesh *casters);

#endif
