#include "gl_text.h"

#include "font.h"

// A letter is a rectangle of 6 x 8 font pixels: code, column and row in one number of the buffer.
static const char vertex_text[] =
    "layout(std430, binding = 0) readonly buffer Letters { uint letter[]; };\n"
    "uniform vec2 cell;\n" // size of a letter, the viewport being 2 x 2
    "flat out uint code;\n"
    "out vec2 at;\n"
    "void main()\n"
    "{\n"
    "    uint l = letter[gl_InstanceID];\n"
    "    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);\n"
    "    code = l & 255u;\n"
    "    at = corner * vec2(6, 8);\n"
    "    vec2 place = (vec2(l >> 8 & 4095u, l >> 20) + 0.5 + corner) * cell;\n"
    "    gl_Position = vec4(place.x - 1, 1 - place.y, 0, 1);\n"
    "}\n";

#define QUOTED(...) #__VA_ARGS__
#define AS_TEXT(list) QUOTED(list)

// clang-format off
static const char fragment_text[] =
    "const uint glyphs[64] = uint[64](" AS_TEXT(FONT_GLYPHS) ");\n"
    "flat in uint code;\n"
    "in vec2 at;\n"
    "out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    uvec2 p = uvec2(max(floor(at) - 1, 0));\n"
    "    bool inside = at.x >= 1 && at.y >= 1 && p.x < 5 && p.y < 6;\n"
    "    bool ink = inside && (glyphs[code - 32u] >> (5 * p.y + p.x) & 1u) == 1u;\n"
    "    color = ink ? vec4(1) : vec4(0, 0, 0, 0.55);\n"
    "}\n";
// clang-format on

bool gl_text_create(gl_text *t, message *why)
{
    *t = (gl_text){0};
    t->program = gl_program_simple("text", vertex_text, fragment_text, why);
    gl_mesh_triangle(&t->none);
    gl.CreateBuffers(1, &t->letters);
    gl.NamedBufferStorage(t->letters, GL_TEXT_LENGTH * sizeof(GLuint), NULL,
                          GL_DYNAMIC_STORAGE_BIT);
    if (t->program) return true;
    gl_text_free(t);
    return false;
}

void gl_text_free(gl_text *t)
{
    if (t->program) gl.DeleteProgram(t->program);
    if (t->letters) gl.DeleteBuffers(1, &t->letters);
    gl_mesh_free(&t->none);
    *t = (gl_text){0};
}

void gl_text_draw(gl_text *t, const char *lines, int width, int height, int scale)
{
    GLuint letter[GL_TEXT_LENGTH], column = 0, row = 0;
    int count = 0;
    for (const char *c = lines; *c && count < GL_TEXT_LENGTH; c++) {
        const GLuint code = (GLuint)(*c >= 'a' && *c <= 'z' ? *c - 'a' + 'A' : *c);
        if (*c == '\n')
            row++, column = 0;
        else if (code >= 32 && code < 96)
            letter[count++] = code | column++ << 8 | row << 20;
    }
    gl.NamedBufferSubData(t->letters, 0, count * (GLsizeiptr)sizeof *letter, letter);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, t->letters);
    gl.ProgramUniform2f(t->program, gl.GetUniformLocation(t->program, "cell"),
                        12 * (float)scale / (float)width, 16 * (float)scale / (float)height);
    gl.UseProgram(t->program);
    gl.BindVertexArray(t->none.array);
    gl.Enable(GL_BLEND);
    gl.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    gl.DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, count);
    gl.Disable(GL_BLEND);
}
