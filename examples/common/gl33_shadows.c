#include "gl33_shadows.h"

#include <stdlib.h>
#include <string.h>

static const char *const samplers[3] = {"mssm_table0", "mssm_table1", "mssm_depths"};

GLuint gl33_shadows_program(const char *version, int lights, const char *const *before,
                            const char *fragment, message *why)
{
    const mssm_gl_desc desc = {.lights = lights};
    const char *piece[8];
    int pieces = 0;
    const size_t bytes = mssm_glsl_shader(&desc, NULL, 0);
    char *text = malloc(bytes);
    if (!text) return fail(why, "no memory"), 0;
    mssm_glsl_shader(&desc, text, bytes);
    while (before && *before && pieces < 5) piece[pieces++] = *before++;
    piece[pieces++] = text;
    piece[pieces++] = fragment;
    piece[pieces] = NULL;
    const GLuint program = gl33_program(version, gl33_scene_vertex, piece, why);
    free(text);
    if (!program) return 0;
    gl33.UseProgram(program);
    for (int i = 0; i < 3; i++) gl33.Uniform1i(gl33.GetUniformLocation(program, samplers[i]), i);
    gl33.UniformBlockBinding(program, gl33.GetUniformBlockIndex(program, "mssm_view_block"), 0);
    return program;
}

// Empty textures with all their levels, and room for the texels of the largest.
static bool make(gl33_shadows *s, const mssm_map *map, message *why)
{
    mssm_texels t;
    gl33.GenTextures(3, s->texture);
    gl33.GenBuffers(1, &s->uniforms);
    for (int which = 0; which < 3; which++) {
        gl33.BindTexture(GL_TEXTURE_2D_ARRAY, s->texture[which]);
        gl33.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER,
                           0x2700); // GL_NEAREST_MIPMAP_NEAREST
        gl33.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
        for (int i = 0; !mssm_map_texels(map, which, i, &t, NULL, 0); i++) {
            gl33.TexImage3D(GL_TEXTURE_2D_ARRAY, i, (GLint)t.internal_format, t.side, t.side,
                            s->lights, 0, t.format, t.type, NULL);
            gl33.TexParameteri(GL_TEXTURE_2D_ARRAY, 0x813D, t.levels - 1); // GL_TEXTURE_MAX_LEVEL
            s->bytes = t.bytes > s->bytes ? t.bytes : s->bytes;
        }
    }
    s->texels = malloc(s->bytes);
    return s->texels || fail(why, "no memory for %zu bytes", s->bytes);
}

bool gl33_shadows_upload(gl33_shadows *s, int light, const mssm_map *map, const mssm_light *frustum,
                         message *why)
{
    mssm_texels t;
    gl33.ActiveTexture(GL_TEXTURE0);
    if (!s->texels && !make(s, map, why)) return false;
    for (int which = 0; which < 3; which++) {
        gl33.BindTexture(GL_TEXTURE_2D_ARRAY, s->texture[which]);
        for (int i = 0; !mssm_map_texels(map, which, i, &t, s->texels, s->bytes); i++)
            gl33.TexSubImage3D(GL_TEXTURE_2D_ARRAY, i, 0, 0, light, t.side, t.side, 1, t.format,
                               t.type, s->texels);
    }
    if (mssm_map_view(map, frustum, NULL, s->view[light])) return fail(why, "no light");
    gl33.BindBuffer(GL_UNIFORM_BUFFER, s->uniforms);
    gl33.BufferData(GL_UNIFORM_BUFFER, (GLsizeiptr)((size_t)s->lights * sizeof *s->view), s->view,
                    0x88E8); // dynamic
    return gl33.GetError() == GL_NO_ERROR || fail(why, "OpenGL refused a shadow map");
}

void gl33_shadows_bind(const gl33_shadows *s)
{
    for (GLenum i = 0; i < 3; i++) {
        gl33.ActiveTexture(GL_TEXTURE0 + i);
        gl33.BindTexture(GL_TEXTURE_2D_ARRAY, s->texture[i]);
    }
    gl33.BindBufferBase(GL_UNIFORM_BUFFER, 0, s->uniforms);
}

void gl33_shadows_free(gl33_shadows *s)
{
    gl33.DeleteTextures(3, s->texture);
    gl33.DeleteBuffers(1, &s->uniforms);
    free(s->texels);
    memset(s, 0, sizeof *s);
}
