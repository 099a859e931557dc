#include "gl_example.h"

#include <stdio.h>
#include <string.h>

int gl_example_main(int argc, char **argv, const char *usage,
                    bool (*run)(int argc, char **argv, message *why))
{
    gl_context context = {0};
    const char *missing;
    message why = {"no memory"};
    if (options_help_asked(argc, argv, usage)) return 0;
    const bool done = (gl_context_create(&context, &missing) || fail(&why, "%s", missing)) &&
                      run(argc, argv, &why);
    if (!done) fprintf(stderr, "%.*s: %s\n", (int)strcspn(usage, " "), usage, why.text);
    gl_context_destroy(&context);
    return done ? 0 : 1;
}

void gl_example_map(mssm_gl *maps, int index, const mssm_light *light, GLuint depth,
                    const gl_mesh *casters)
{
    mssm_gl_set_light(maps, index, light);
    mssm_gl_begin_depth(maps, index, 0);
    gl.UseProgram(depth);
    gl.ProgramUniformMatrix4fv(depth, 0, 1, GL_FALSE, light->world_to_shadow);
    gl_mesh_draw(casters);
    mssm_gl_end_depth(maps);
}
