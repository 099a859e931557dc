#include "gl_text.h"

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

// Bit 5 * row + column of a glyph; the characters from 32 to 95.
static const char fragment_text[] =
    "const uint glyphs[64] = uint[64](\n"
    "    0x00000000u, 0x08021084u, 0x0000014au, 0x15f52beau, 0x08fa17c4u, 0x33a21173u, "
    "0x2c9c9926u, 0x00000084u,\n"
    "    0x10421088u, 0x04421082u, 0x01573aa0u, 0x084f9080u, 0x04400000u, 0x000f8000u, "
    "0x08000000u, 0x02221110u,\n"
    "    0x1d3ae62eu, 0x1c4210c4u, 0x3e22222eu, 0x1d18320fu, 0x108fa988u, 0x1d183c3fu, "
    "0x1d18bc2eu, 0x0842221fu,\n"
    "    0x1d18ba2eu, 0x1d0f462eu, 0x00400080u, 0x04400080u, 0x10410888u, 0x01f003e0u, "
    "0x04442082u, 0x0802222eu,\n"
    "    0x1c1ef62eu, 0x231fc62eu, 0x1f18be2fu, 0x1d10862eu, 0x1f18c62fu, 0x3e10bc3fu, "
    "0x0210bc3fu, 0x1d18f42eu,\n"
    "    0x2318fe31u, 0x1c42108eu, 0x0c94211cu, 0x22929d31u, 0x3e108421u, 0x231ad771u, "
    "0x239ad671u, 0x1d18c62eu,\n"
    "    0x0217c62fu, 0x2c9ac62eu, 0x2297c62fu, 0x1d18383eu, 0x0842109fu, 0x1d18c631u, "
    "0x08a54631u, 0x23bad631u,\n"
    "    0x22a21151u, 0x08421151u, 0x3e11111fu, 0x0c210846u, 0x20821041u, 0x1884210cu, "
    "0x00004544u, 0x3e000000u\n"
    ");\n"
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
