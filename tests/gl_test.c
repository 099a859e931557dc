#include "gl_test.h"

#include <stdlib.h>

#include "test.h"

bool gl_test_begin(gl_context *c)
{
    const char *why;
    if (gl_context_create(c, &why)) return true;
    CHECK(!getenv("TEST_REQUIRE_GL"), "TEST_REQUIRE_GL is set, but %s", why);
    test_skip("%s", why);
    return false;
}

GLuint gl_test_shader(GLenum type, const char *name, const char *const *text)
{
    const char *piece[8] = {"#version 450 core\n"};
    GLsizei pieces = 1;
    GLint compiled = 0;
    char log[2000] = "";
    while (*text && pieces < 8) piece[pieces++] = *text++;
    const GLuint shader = gl.CreateShader(type);
    gl.ShaderSource(shader, pieces, piece, NULL);
    gl.CompileShader(shader);
    gl.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    gl.GetShaderInfoLog(shader, sizeof log, NULL, log);
    CHECK(compiled && !log[0], "%s: %s%s", name, compiled ? "warning: " : "", log);
    if (compiled) return shader;
    gl.DeleteShader(shader);
    return 0;
}

GLuint gl_test_compute(const char *name, const char *const *text)
{
    const GLuint shader = gl_test_shader(GL_COMPUTE_SHADER, name, text);
    GLint linked = 0;
    char log[2000] = "";
    if (!shader) return 0;
    const GLuint program = gl.CreateProgram();
    gl.AttachShader(program, shader);
    gl.DeleteShader(shader); // the program keeps it
    gl.LinkProgram(program);
    gl.GetProgramiv(program, GL_LINK_STATUS, &linked);
    gl.GetProgramInfoLog(program, sizeof log, NULL, log);
    CHECK(linked && !log[0], "%s: %s", name, log);
    if (linked) return program;
    gl.DeleteProgram(program);
    return 0;
}
