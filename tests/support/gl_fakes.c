// The headers come first: names of theirs would shadow what gl.h declares.
#include <stddef.h>

static void *fake_malloc(size_t bytes);
static void fake_free(void *memory);

#define MSSM_MALLOC(bytes) fake_malloc(bytes)
#define MSSM_FREE(memory) fake_free(memory)
#define MSSM_IMPLEMENTATION
#include "../../mssm.h"

#define LIGHTPROBE_MALLOC(bytes) fake_malloc(bytes)
#define LIGHTPROBE_FREE(memory) fake_free(memory)
#define LIGHTPROBE_IMPLEMENTATION
#include "../../lightprobe.h"

#include "gl_fakes.h"
#include "gl_test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../examples/common/gl_context.h"

gl_fakes fakes;

// ---- Memory --------------------------------------------------------------------------------------

static int living_memory;

static void *fake_malloc(size_t bytes)
{
    void *memory = ++fakes.mallocs == fakes.fail_malloc ? NULL : malloc(bytes);
    if (memory) {
        memset(memory, 0xA5, bytes); // whoever reads what he did not write shall notice
        living_memory++;
    }
    return memory;
}

static void fake_free(void *memory)
{
    if (memory) living_memory--;
    free(memory);
}

int gl_fakes_living_memory(void)
{
    return living_memory;
}

const uint32_t *gl_fakes_map_table(const mssm_map *map, int level, int *size)
{
    *size = level < map->levels ? map->size[level] : 0;
    return level < map->levels ? map->table[level] : NULL;
}

int gl_fakes_level_of(float width, int levels)
{
    return mssm_level_of(width, levels);
}

// ---- Objects that live ---------------------------------------------------------------------------

typedef struct living {
    GLenum kind; // as glObjectLabel takes it
    GLuint name;
} living;

enum { MOST_LIVING = 1024 };
static living objects[MOST_LIVING];
static int object_count;

static void born(GLenum kind, GLsizei count, const GLuint *names)
{
    for (int i = 0; i < count && object_count < MOST_LIVING; i++) {
        if (names[i]) objects[object_count++] = (living){kind, names[i]};
    }
}

static void died(GLenum kind, GLsizei count, const GLuint *names)
{
    for (int i = 0; i < count; i++) {
        for (int j = 0; j < object_count; j++) {
            if (objects[j].kind != kind || objects[j].name != names[i]) continue;
            objects[j] = objects[--object_count];
            break;
        }
    }
}

int gl_fakes_living(bool unlabelled, char *text, int size)
{
    int count = 0, used = 0;
    if (size > 0) text[0] = '\0';
    for (int i = 0; i < object_count; i++) {
        char label[64] = "";
        GLsizei length = 0;
        if (unlabelled) {
            gl.GetObjectLabel(objects[i].kind, objects[i].name, sizeof label, &length, label);
            if (label[0]) continue;
        }
        count++;
        if (used < size) {
            used += snprintf(text + used, (size_t)(size - used), " 0x%04X %u", objects[i].kind,
                             objects[i].name);
        }
    }
    return count;
}

void gl_fakes_forget_living(void)
{
    object_count = 0;
}

// ---- A driver that fails -------------------------------------------------------------------------

static GLenum pending_error; // reported before the driver's own

// Counts an allocation; true if it is the one that fails.
static bool out_of_memory(void)
{
    if (++fakes.allocations != fakes.fail_allocation) return false;
    pending_error = GL_OUT_OF_MEMORY;
    return true;
}

static GLenum GL_CALL fake_GetError(void)
{
    const GLenum error = pending_error;
    pending_error = GL_NO_ERROR;
    return error ? error : gl.GetError();
}

// X(kind for labels, function that makes, function that deletes)
#define PLAIN_OBJECTS(X)                                         \
    X(GL_BUFFER, CreateBuffers, DeleteBuffers)                   \
    X(GL_FRAMEBUFFER, CreateFramebuffers, DeleteFramebuffers)    \
    X(GL_RENDERBUFFER, CreateRenderbuffers, DeleteRenderbuffers) \
    X(GL_VERTEX_ARRAY, CreateVertexArrays, DeleteVertexArrays)   \
    X(GL_SAMPLER, CreateSamplers, DeleteSamplers)                \
    X(GL_PROGRAM_PIPELINE, CreateProgramPipelines, DeleteProgramPipelines)

#define FAKE_PLAIN(kind, make, drop)                                    \
    static void GL_CALL fake_##make(GLsizei count, GLuint *names)       \
    {                                                                   \
        memset(names, 0, (size_t)count * sizeof *names);                \
        if (out_of_memory()) return;                                    \
        gl.make(count, names);                                          \
        born(kind, count, names);                                       \
    }                                                                   \
    static void GL_CALL fake_##drop(GLsizei count, const GLuint *names) \
    {                                                                   \
        died(kind, count, names);                                       \
        gl.drop(count, names);                                          \
    }
PLAIN_OBJECTS(FAKE_PLAIN)

#define TYPED_OBJECTS(X)                          \
    X(GL_TEXTURE, CreateTextures, DeleteTextures) \
    X(GL_QUERY, CreateQueries, DeleteQueries)

#define FAKE_TYPED(kind, make, drop)                                             \
    static void GL_CALL fake_##make(GLenum target, GLsizei count, GLuint *names) \
    {                                                                            \
        memset(names, 0, (size_t)count * sizeof *names);                         \
        if (out_of_memory()) return;                                             \
        gl.make(target, count, names);                                           \
        born(kind, count, names);                                                \
    }                                                                            \
    static void GL_CALL fake_##drop(GLsizei count, const GLuint *names)          \
    {                                                                            \
        died(kind, count, names);                                                \
        gl.drop(count, names);                                                   \
    }
TYPED_OBJECTS(FAKE_TYPED)

// X(function, parameters, arguments)
#define STORAGE(X)                                                                              \
    X(NamedBufferStorage, (GLuint b, GLsizeiptr n, const void *data, GLbitfield f),             \
      (b, n, data, f))                                                                          \
    X(BufferStorage, (GLenum t, GLsizeiptr n, const void *data, GLbitfield f), (t, n, data, f)) \
    X(TextureStorage2D, (GLuint t, GLsizei l, GLenum f, GLsizei w, GLsizei h), (t, l, f, w, h)) \
    X(TextureStorage3D, (GLuint t, GLsizei l, GLenum f, GLsizei w, GLsizei h, GLsizei d),       \
      (t, l, f, w, h, d))                                                                       \
    X(TextureStorage3DMultisample,                                                              \
      (GLuint t, GLsizei s, GLenum f, GLsizei w, GLsizei h, GLsizei d, GLboolean x),            \
      (t, s, f, w, h, d, x))                                                                    \
    X(NamedRenderbufferStorage, (GLuint r, GLenum f, GLsizei w, GLsizei h), (r, f, w, h))

#define FAKE_STORAGE(name, parameters, arguments) \
    static void GL_CALL fake_##name parameters    \
    {                                             \
        if (!out_of_memory()) gl.name arguments;  \
    }
STORAGE(FAKE_STORAGE)

static GLuint GL_CALL fake_CreateShader(GLenum type)
{
    if (out_of_memory()) return 0;
    const GLuint shader = gl.CreateShader(type);
    born(GL_SHADER, 1, &shader);
    return shader;
}

static void GL_CALL fake_DeleteShader(GLuint shader)
{
    died(GL_SHADER, 1, &shader);
    gl.DeleteShader(shader);
}

static GLuint GL_CALL fake_CreateProgram(void)
{
    if (out_of_memory()) return 0;
    const GLuint program = gl.CreateProgram();
    born(GL_PROGRAM, 1, &program);
    return program;
}

static void GL_CALL fake_DeleteProgram(GLuint program)
{
    died(GL_PROGRAM, 1, &program);
    gl.DeleteProgram(program);
}

static void GL_CALL fake_ShaderSource(GLuint shader, GLsizei count, const GLchar *const *text,
                                      const GLint *length)
{
    gl.ShaderSource(shader, count, text, length);
    size_t bytes = 1;
    for (int i = 0; i < count; i++) {
        bytes += length && length[i] >= 0 ? (size_t)length[i] : strlen(text[i]);
    }
    char *whole = malloc(bytes), *at = whole;
    if (!whole || fakes.text_count == GL_FAKES_TEXTS) {
        free(whole);
        return;
    }
    for (int i = 0; i < count; i++) {
        const size_t n = length && length[i] >= 0 ? (size_t)length[i] : strlen(text[i]);
        memcpy(at, text[i], n);
        at += n;
    }
    *at = '\0';
    GLint type = 0;
    gl.GetShaderiv(shader, GL_SHADER_TYPE, &type);
    fakes.text_types[fakes.text_count] = (GLenum)type;
    fakes.texts[fakes.text_count++] = whole;
}

// No terminator where one would help, percent signs for a careless printf, bytes that are no text.
static const char garbage[] = "%s%n%d \x01\xff\xfe\x80 0(1) : error C0000: \"\\\n%s%s%n";
enum { GARBAGE_LENGTH = 100000 };

static void give_garbage(GLsizei size, GLsizei *length, GLchar *log)
{
    GLsizei n = 0;
    for (; n < size - 1 && n < GARBAGE_LENGTH - 1; n++)
        log[n] = garbage[(size_t)n % (sizeof garbage - 1)];
    if (size > 0) log[n] = '\0';
    if (length) *length = n;
}

static GLuint failed_shader, failed_program;

static void GL_CALL fake_CompileShader(GLuint shader)
{
    GLint made = 0;
    char log[200] = "";
    gl.CompileShader(shader);
    gl.GetShaderiv(shader, GL_COMPILE_STATUS, &made);
    gl.GetShaderInfoLog(shader, sizeof log, NULL, log);
    if (!made || !gl_test_quiet(log)) {
        fakes.bad_logs++;
        printf("    shader %d: %s\n", fakes.compiles + 1, log);
    }
    failed_shader = ++fakes.compiles == fakes.fail_compile ? shader : 0;
}

static void GL_CALL fake_LinkProgram(GLuint program)
{
    GLint made = 0;
    char log[200] = "";
    gl.LinkProgram(program);
    gl.GetProgramiv(program, GL_LINK_STATUS, &made);
    gl.GetProgramInfoLog(program, sizeof log, NULL, log);
    if ((!made || !gl_test_quiet(log)) && !fakes.fail_compile && !fakes.fail_allocation) {
        fakes.bad_logs++;
        printf("    program %d: %s\n", fakes.links + 1, log);
    }
    failed_program = ++fakes.links == fakes.fail_link ? program : 0;
}

static void GL_CALL fake_GetShaderiv(GLuint shader, GLenum name, GLint *value)
{
    gl.GetShaderiv(shader, name, value);
    if (!shader || shader != failed_shader) return;
    if (name == GL_COMPILE_STATUS) *value = GL_FALSE;
    if (name == GL_INFO_LOG_LENGTH) *value = GARBAGE_LENGTH;
}

static void GL_CALL fake_GetProgramiv(GLuint program, GLenum name, GLint *value)
{
    gl.GetProgramiv(program, name, value);
    if (!program || program != failed_program) return;
    if (name == GL_LINK_STATUS) *value = GL_FALSE;
    if (name == GL_INFO_LOG_LENGTH) *value = GARBAGE_LENGTH;
}

static void GL_CALL fake_GetShaderInfoLog(GLuint shader, GLsizei size, GLsizei *length, GLchar *log)
{
    if (shader && shader == failed_shader)
        give_garbage(size, length, log);
    else
        gl.GetShaderInfoLog(shader, size, length, log);
}

static void GL_CALL fake_GetProgramInfoLog(GLuint program, GLsizei size, GLsizei *length,
                                           GLchar *log)
{
    if (program && program == failed_program)
        give_garbage(size, length, log);
    else
        gl.GetProgramInfoLog(program, size, length, log);
}

static GLenum GL_CALL fake_CheckNamedFramebufferStatus(GLuint framebuffer, GLenum target)
{
    const GLenum status = gl.CheckNamedFramebufferStatus(framebuffer, target);
    return fakes.incomplete ? GL_FRAMEBUFFER_UNSUPPORTED : status; // unsupported
}

// GL_EXT_depth_bounds_test, which a shadow pass must not keep on, on drivers without it.
enum { NUM_EXTENSIONS = 0x821D, EXTENSIONS = 0x1F03, DEPTH_BOUNDS_TEST = 0x8890 };

static const unsigned char *GL_CALL fake_GetStringi(GLenum name, GLuint index)
{
    static const unsigned char bounds[] = "GL_EXT_depth_bounds_test";
    const unsigned char *(GL_CALL * GetStringi)(GLenum, GLuint);
    const gl_fakes_function f = gl_context_function("glGetStringi");
    GLint count = 0;
    memcpy(&GetStringi, &f, sizeof f);
    gl.GetIntegerv(NUM_EXTENSIONS, &count);
    return fakes.depth_bounds && index == (GLuint)count ? bounds : GetStringi(name, index);
}

static GLboolean GL_CALL fake_IsEnabled(GLenum name)
{
    return fakes.depth_bounds && name == DEPTH_BOUNDS_TEST ? fakes.depth_bounds == 2
                                                           : gl.IsEnabled(name);
}

static void GL_CALL fake_Enable(GLenum name)
{
    if (fakes.depth_bounds && name == DEPTH_BOUNDS_TEST)
        fakes.depth_bounds = 2;
    else
        gl.Enable(name);
}

static void GL_CALL fake_Disable(GLenum name)
{
    if (fakes.depth_bounds && name == DEPTH_BOUNDS_TEST)
        fakes.depth_bounds = 1;
    else
        gl.Disable(name);
}

static void GL_CALL fake_GetIntegerv(GLenum name, GLint *value)
{
    static const GLenum limits[] = {GL_MAX_SAMPLES, GL_MAX_COLOR_TEXTURE_SAMPLES,
                                    GL_MAX_DEPTH_TEXTURE_SAMPLES, GL_MAX_INTEGER_SAMPLES,
                                    GL_MAX_FRAMEBUFFER_SAMPLES};
    if (fakes.version && !fakes.version[0]) return; // no context: nothing is written
    gl.GetIntegerv(name, value);
    for (int i = 0; i < 5; i++) {
        if (name == limits[i] && fakes.max_samples) *value = fakes.max_samples;
    }
    if (name == NUM_EXTENSIONS && fakes.depth_bounds) ++*value;
    if (name == GL_MAJOR_VERSION && fakes.version) *value = fakes.major;
    if (name == GL_MINOR_VERSION && fakes.version) *value = fakes.minor;
}

static const unsigned char *GL_CALL fake_GetString(GLenum name)
{
    if (fakes.version && !fakes.version[0]) return NULL;
    if (name != GL_VERSION || !fakes.version) return gl.GetString(name);
    return (const unsigned char *)fakes.version;
}

// Calls that Intel's driver for Windows takes without a word and does not carry out: Magnum's list
// of driver workarounds, "intel-windows-...", and voxy's issue 656.
static bool is_silent(const char *name)
{
    static const char *const ends[] = {
        "ClearNamedFramebufferfv",  "NamedBufferStorage",   "NamedBufferSubData",
        "BindTextureUnit",          "BlitNamedFramebuffer", "CopyNamedBufferSubData",
        "GetTextureParameteriv",    "MapNamedBufferRange",  "FlushMappedNamedBuffer",
        "GetTextureLevelParameter", "ClearNamedBufferData", "NamedBufferData"};
    for (int i = 0; i < (int)(sizeof ends / sizeof *ends); i++) {
        if (!strncmp(name + 2, ends[i], strlen(ends[i]))) return true;
    }
    return false;
}

static void *GL_CALL fake_nothing(void)
{
    return NULL;
}

// ---- The loader ----------------------------------------------------------------------------------

// Whether a function with this name could make or delete objects or their memory.
static bool makes_objects(const char *name)
{
    static const char *const starts[] = {"glCreate", "glGen", "glDelete", "glFenceSync"};
    for (int i = 0; i < 4; i++) {
        if (!strncmp(name, starts[i], strlen(starts[i])))
            return strcmp(name, "glGenerateTextureMipmap");
    }
    return strstr(name, "Storage") || strstr(name, "BufferData") || strstr(name, "TexImage") ||
           !strcmp(name, "glTextureView");
}

#define RETURN_FAKE(function) \
    if (!strcmp(name, "gl" #function)) return (gl_fakes_function)fake_##function;
#define RETURN_OBJECT(kind, make, drop) RETURN_FAKE(make) RETURN_FAKE(drop)
#define RETURN_STORAGE(function, parameters, arguments) RETURN_FAKE(function)

gl_fakes_function gl_fakes_load(const char *name)
{
    if (fakes.name_count < GL_FAKES_NAMES) fakes.names[fakes.name_count++] = name;
    if (fakes.missing && !strcmp(fakes.missing, name)) return NULL;
    if (fakes.silent_names && is_silent(name)) return (gl_fakes_function)fake_nothing;
    PLAIN_OBJECTS(RETURN_OBJECT)
    TYPED_OBJECTS(RETURN_OBJECT)
    STORAGE(RETURN_STORAGE)
    RETURN_FAKE(GetError)
    RETURN_FAKE(CreateShader)
    RETURN_FAKE(DeleteShader)
    RETURN_FAKE(CreateProgram)
    RETURN_FAKE(DeleteProgram)
    RETURN_FAKE(ShaderSource)
    RETURN_FAKE(CompileShader)
    RETURN_FAKE(LinkProgram)
    RETURN_FAKE(GetShaderiv)
    RETURN_FAKE(GetProgramiv)
    RETURN_FAKE(GetShaderInfoLog)
    RETURN_FAKE(GetProgramInfoLog)
    RETURN_FAKE(CheckNamedFramebufferStatus)
    RETURN_FAKE(GetIntegerv)
    RETURN_FAKE(GetStringi)
    RETURN_FAKE(IsEnabled)
    RETURN_FAKE(Enable)
    RETURN_FAKE(Disable)
    RETURN_FAKE(GetString)
    if (makes_objects(name) && !fakes.unwatched++) {
        snprintf(fakes.unwatched_name, sizeof fakes.unwatched_name, "%s", name);
    }
    return gl_context_function(name);
}

void gl_fakes_reset(void)
{
    for (int i = 0; i < fakes.text_count; i++) free(fakes.texts[i]);
    memset(&fakes, 0, sizeof fakes);
    pending_error = GL_NO_ERROR;
    failed_shader = failed_program = 0;
}

// ---- Messages ------------------------------------------------------------------------------------

void gl_fakes_log(void *user, const char *message)
{
    gl_fakes *f = user;
    f->messages++;
    snprintf(f->message, sizeof f->message, "%s", message ? message : "");
}

static void GL_CALL on_debug(GLenum source, GLenum type, GLuint id, GLenum severity, GLsizei length,
                             const GLchar *message, const void *user)
{
    (void)source, (void)id, (void)length, (void)user;
    const bool slow = type == GL_DEBUG_TYPE_PERFORMANCE && severity == GL_DEBUG_SEVERITY_HIGH;
    const bool wrong = type == GL_DEBUG_TYPE_ERROR || type == GL_DEBUG_TYPE_DEPRECATED_BEHAVIOR ||
                       type == GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR ||
                       type == GL_DEBUG_TYPE_PORTABILITY;
    if (!slow && !wrong) return;
    if (!fakes.debug_messages++) {
        snprintf(fakes.debug_message, sizeof fakes.debug_message, "%s", message);
    }
}

void gl_fakes_watch(void)
{
    gl.Enable(GL_DEBUG_OUTPUT);
    gl.Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    gl.DebugMessageCallback(on_debug, NULL);
    gl.DebugMessageControl(GL_DONT_CARE, GL_DONT_CARE, GL_DONT_CARE, 0, NULL, GL_TRUE);
}
