#include "gl_test.h"

#include <ctype.h>
#include <math.h>
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
        if (getenv("TEST_ROUNDING")) gl_test_round_loosely();
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

bool gl_test_rounds(void)
{
    static const char *const body = "layout(local_size_x = 64) in;\n"
                                    "layout(std430, binding = 0) buffer numbers { float x[]; };\n"
                                    "void main()\n"
                                    "{\n"
                                    "    uint i = gl_GlobalInvocationID.x;\n"
                                    "    precise float q = x[i] / x[i ^ 1u], r = sqrt(x[i]);\n"
                                    "    x[1024 + i] = q;\n"
                                    "    x[2048 + i] = r;\n"
                                    "}\n";
    static const char *const text[] = {body, NULL};
    static float x[3072];
    uint64_t seed = 91;
    bool same = true;
    GLuint buffer;
    const GLuint program = gl_test_compute("rounding", text);
    for (int i = 0; i < 1024; i++) x[i] = (float)test_range(&seed, 0.01, 10);
    gl.CreateBuffers(1, &buffer);
    gl.NamedBufferStorage(buffer, sizeof x, x, 0);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer);
    gl.UseProgram(program);
    gl.DispatchCompute(16, 1, 1);
    gl.MemoryBarrier(~0u);
    gl.GetNamedBufferSubData(buffer, 0, sizeof x, x);
    for (int i = 0; i < 1024; i++) {
        const float quotient = x[i] / x[i ^ 1], root = sqrtf(x[i]);
        same = same && x[1024 + i] == quotient && x[2048 + i] == root;
    }
    gl.UseProgram(0);
    gl.DeleteProgram(program);
    gl.DeleteBuffers(1, &buffer);
    return same;
}

// ---- A GPU that rounds as GLSL allows -----------------------------------------------------------

static void(GL_CALL *exact_source)(GLuint shader, GLsizei count, const GLchar *const *text,
                                   const GLint *length);

// clang-format off
static const char loose_functions[] =
    "float test_loose(float x)\n"
    "{\n"
    "    uint bits = floatBitsToUint(x);\n"
    "    if ((bits & 0x7fffffu) == 0u || isnan(x)) return x;\n"
    "    return x + x * (float(int(bits * 2654435761u >> 24) % 9 - 4) * 5.9604645e-8);\n"
    "}\n"
    "vec2 test_loose(vec2 x) { return vec2(test_loose(x.x), test_loose(x.y)); }\n"
    "vec3 test_loose(vec3 x) { return vec3(test_loose(x.xy), test_loose(x.z)); }\n"
    "vec4 test_loose(vec4 x) { return vec4(test_loose(x.xy), test_loose(x.zw)); }\n"
    "int test_loose(int x) { return x; }\n"
    "uint test_loose(uint x) { return x; }\n"
    "ivec2 test_loose(ivec2 x) { return x; }\n"
    "float test_root(float x) { return test_loose(sqrt(x)); }\n"
    "vec2 test_root(vec2 x) { return vec2(test_root(x.x), test_root(x.y)); }\n"
    "#line 2\n";
// clang-format on

// A name with what is called, chosen or indexed of it, or brackets; 0 for numbers.
static size_t operand(const char *s)
{
    size_t i = 0;
    if (*s != '(' && *s != '_' && !isalpha((unsigned char)*s)) return 0;
    while (s[i] == '_' || s[i] == '.' || s[i] == '(' || s[i] == '[' ||
           isalnum((unsigned char)s[i])) {
        int depth = 0;
        do {
            depth += (s[i] == '(' || s[i] == '[') - (s[i] == ')' || s[i] == ']');
            i++;
        } while (depth > 0 && s[i]);
    }
    return i;
}

static char *write_loosely(char *to, const char *s, const char *end)
{
    for (char before = ' '; s < end; before = *s++) {
        const bool root =
            !strncmp(s, "sqrt(", 5) && before != '_' && !isalnum((unsigned char)before);
        const char *from = s + 1 + (s[1] == '=');
        if (s[0] == '/' && s[1] == '/') { // a comment
            memcpy(to, s, (size_t)(end - s));
            return to + (end - s);
        }
        while (*from == ' ') from++;
        const size_t n = s[0] != '/' ? 0 : s[1] == '=' ? strcspn(from, ";") : operand(from);
        if (root) {
            to = strcpy(to, "test_root") + 9;
            s += 3;
        } else if (n > 0 && from + n <= end) {
            to = strcpy(to, s[1] == '=' ? "/= test_loose(" : "/ test_loose(");
            to = write_loosely(to + strlen(to), from, from + n);
            *to++ = ')';
            s = from + n - 1;
        } else {
            *to++ = *s;
        }
    }
    return to;
}

// Line by line; those of the preprocessor stay, and constants, which must not call anything.
static void GL_CALL loose_source(GLuint shader, GLsizei count, const GLchar *const *text,
                                 const GLint *length)
{
    size_t bytes = 1;
    for (int i = 0; i < count; i++) bytes += strlen(text[i]);
    char *whole = calloc(bytes, 1), *loose = calloc(4 * bytes + sizeof loose_functions, 1);
    if (!whole || !loose) abort();
    for (int i = 0; i < count; i++)
        strncat(whole, text[i], length && length[i] >= 0 ? (size_t)length[i] : bytes);
    char *to = loose;
    for (const char *s = whole, *end; *s; s = end) {
        const size_t n = strcspn(s, "\n");
        const char *constant = strstr(s, "const ");
        end = s + n + (s[n] == '\n');
        if (!strncmp(s, "#define sqrtf sqrt\n", 19)) {
            to = strcpy(to, "#define sqrtf test_root\n") + 24;
        } else if (s[strspn(s, " ")] == '#' || (constant && constant < end)) {
            memcpy(to, s, (size_t)(end - s));
            to += end - s;
        } else {
            to = write_loosely(to, s, end);
        }
        if (!strncmp(s, "#version 4", 10))
            to = strcpy(to, loose_functions) + sizeof loose_functions - 1;
    }
    const GLchar *const one = strstr(loose, "test_loose") ? loose : whole;
    exact_source(shader, 1, &one, NULL);
    free(whole);
    free(loose);
}

void gl_test_round_loosely(void)
{
    if (gl.ShaderSource == loose_source) return;
    exact_source = gl.ShaderSource;
    gl.ShaderSource = loose_source;
}
