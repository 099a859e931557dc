#include "gl_test.h"

#include <stdlib.h>
#include <string.h>

#include "../../examples/common/gl_draw.h"
#include "test.h"

static bool made_by_egl; // the context of gl_test_begin

static bool egl_function(void *f, const char *name)
{
    void (*const wanted)(void) = gl_context_function(name);
    memcpy(f, &wanted, sizeof wanted);
    return wanted && made_by_egl;
}

bool gl_test_begin(gl_context *c)
{
    const char *why;
    if (gl_context_create(c, &why)) {
        void *(*current)(void);
        void (*const f)(void) = gl_context_function("eglGetCurrentContext");
        memcpy(&current, &f, sizeof f);
        made_by_egl = f && current();
        const char *renderer = getenv("TEST_RENDERER"),
                   *is = (const char *)gl.GetString(GL_RENDERER);
        CHECK(!renderer || (is && strstr(is, renderer)), "the renderer is %s, not %s",
              is ? is : "none", renderer);
        return true;
    }
    CHECK(!getenv("TEST_REQUIRE_GL"), "TEST_REQUIRE_GL is set, but %s", why);
    test_skip("%s", why);
    return false;
}

bool gl_test_quiet(const char *log)
{
    const char *version = (const char *)gl.GetString(GL_VERSION);
    return !log[0] || (version && !strstr(version, "Mesa"));
}

bool gl_test_share(const gl_context *c, gl_context *shared)
{
    enum { MAJOR = 0x3098, MINOR = 0x30FB, PROFILE = 0x30FD, NONE = 0x3038 };
    void *(*create)(void *display, void *config, void *share, const int *attributes);
    GLint profile = 0;
    gl.GetIntegerv(GL_CONTEXT_PROFILE_MASK, &profile);
    const int attributes[] = {MAJOR, 4, MINOR, 5, PROFILE, profile & 2 ? 2 : 1, NONE};
    *shared = *c;
    const bool egl = egl_function(&create, "eglCreateContext");
    shared->context = egl ? create(c->display, NULL, c->context, attributes) : NULL;
    if (!shared->context) test_note("left out: no context that shares, or not one of EGL's");
    return shared->context != NULL;
}

bool gl_test_make_current(const gl_context *c)
{
    unsigned (*make_current)(void *display, void *draw, void *read, void *context);
    return egl_function(&make_current, "eglMakeCurrent") &&
           make_current(c->display, NULL, NULL, c->context);
}

void gl_test_unshare(gl_context *shared)
{
    unsigned (*destroy)(void *display, void *context);
    if (egl_function(&destroy, "eglDestroyContext")) destroy(shared->display, shared->context);
}

GLuint gl_test_shader(GLenum type, const char *name, const char *const *text)
{
    char *log;
    const GLuint shader = gl_shader(type, text, &log);
    CHECK(shader && log && gl_test_quiet(log), "%s: %s%s", name, shader ? "warning: " : "",
          log ? log : "no memory");
    free(log);
    return shader;
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
    CHECK(linked && gl_test_quiet(log), "%s: %s", name, log);
    if (linked) return program;
    gl.DeleteProgram(program);
    return 0;
}

void gl_test_link_in_vain(GLuint program)
{
    const GLuint shader = gl.CreateShader(GL_VERTEX_SHADER); // never compiled
    GLint linked = 1;
    gl.AttachShader(program, shader);
    gl.DeleteShader(shader);
    gl.LinkProgram(program);
    gl.GetProgramiv(program, GL_LINK_STATUS, &linked);
    CHECK(!linked, "a program with a shader that was not compiled links");
}
