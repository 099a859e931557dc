// The OpenGL halves of both headers on a driver that there is not: it can lose its context at any
// call, or answer nonsense to every question. A result code and a message, never a crash, a hang or
// memory left behind. Needs no OpenGL; the address sanitizer and valgrind see every byte that is
// read.
#include "../support/gl_fakes.h"
#include "../support/test.h"

#include "../../lightprobe.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined __GNUC__
#pragma GCC diagnostic ignored \
    "-Wunused-parameter" // all that the functions below do with most of them
#endif

enum { WORKS, LOST, GARBAGE };

static struct {
    int mode;
    int calls, lost_after; // LOST: the context is gone after so many calls
    uint64_t random;
    int rarity;                                // GARBAGE: one answer in so many is nonsense
    int questions;                             // asked
    int objects;                               // made and not deleted
    int dispatches, barriers, binds, uploaded; // compute shaders, framebuffers, bytes of buffers
    int under_way, overtaking; // since the last barrier, dispatches; those that did not wait
    int messages;
    size_t longest;  // message
    void *mapped[8]; // by MapBufferRange, freed when the test ends
    int mapped_count;
} driver;

enum {
    ANY_NUMBER = 1 << 27
}; // a limit that is never reached, and the texture that is bound everywhere
enum {
    FLAT = 0x0DE1,
    TEXTURE_BINDING_CUBE_MAP = 0x8514,
    INTERNAL_FORMAT = 0x1003,
    DEPTH_SIZE = 0x884A,
    STENCIL_SIZE = 0x88F1,
    CONTEXT_LOST = 0x0507,
    SYNC_SIGNALED = 0x911A,
    SYNC_WAIT_FAILED = 0x911D
};

// Whether the call does what it should; every function begins with it.
static bool works(void)
{
    driver.calls++;
    return driver.mode != LOST || driver.calls <= driver.lost_after;
}

// What answers asks for it.
static bool nonsense(void)
{
    driver.questions++;
    return driver.mode == GARBAGE && test_random(&driver.random) % (uint64_t)driver.rarity == 0;
}

// Numbers that trip up careless code.
static int strange(void)
{
    static const int numbers[] = {0,     -1, 1, INT_MAX, INT_MIN, 7, 4096, 1 << 20, (1 << 20) + 1,
                                  65536, 45};
    return numbers[test_random(&driver.random) % (sizeof numbers / sizeof *numbers)];
}

// ---- Functions that only do something to the GPU
#define DOES_NOTHING(X)                                                                          \
    X(Enable, (GLenum a))                                                                        \
    X(Disable, (GLenum a))                                                                       \
    X(Enablei, (GLenum a, GLuint b))                                                             \
    X(Disablei, (GLenum a, GLuint b))                                                            \
    X(ViewportIndexedf, (GLuint a, GLfloat b, GLfloat c, GLfloat d, GLfloat e))                  \
    X(DepthRangeIndexed, (GLuint a, GLdouble b, GLdouble c))                                     \
    X(DepthFunc, (GLenum a))                                                                     \
    X(DepthMask, (GLboolean a))                                                                  \
    X(ColorMaski, (GLuint a, GLboolean b, GLboolean c, GLboolean d, GLboolean e))                \
    X(ClipControl, (GLenum a, GLenum b))                                                         \
    X(CullFace, (GLenum a))                                                                      \
    X(PolygonMode, (GLenum a, GLenum b))                                                         \
    X(NamedFramebufferTextureLayer, (GLuint a, GLenum b, GLuint c, GLint d, GLint e))            \
    X(NamedFramebufferDrawBuffer, (GLuint a, GLenum b))                                          \
    X(NamedFramebufferDrawBuffers, (GLuint a, GLsizei b, const GLenum *c))                       \
    X(BindVertexArray, (GLuint a))                                                               \
    X(DrawArrays, (GLenum a, GLint b, GLsizei c))                                                \
    X(NamedFramebufferReadBuffer, (GLuint a, GLenum b))                                          \
    X(ClearBufferfv, (GLenum a, GLint b, const GLfloat *c))                                      \
    X(TextureStorage3D, (GLuint a, GLsizei b, GLenum c, GLsizei d, GLsizei e, GLsizei f))        \
    X(TextureStorage3DMultisample,                                                               \
      (GLuint a, GLsizei b, GLenum c, GLsizei d, GLsizei e, GLsizei f, GLboolean g))             \
    X(TextureParameteri, (GLuint a, GLenum b, GLint c))                                          \
    X(TexParameteri, (GLenum a, GLenum b, GLint c))                                              \
    X(ActiveTexture, (GLenum a))                                                                 \
    X(BindTexture, (GLenum a, GLuint b))                                                         \
    X(BindSampler, (GLuint a, GLuint b))                                                         \
    X(SamplerParameteri, (GLuint a, GLenum b, GLint c))                                          \
    X(BindImageTexture, (GLuint a, GLuint b, GLint c, GLboolean d, GLint e, GLenum f, GLenum g)) \
    X(BufferStorage, (GLenum a, GLsizeiptr b, const void *c, GLbitfield d))                      \
    X(CopyBufferSubData, (GLenum a, GLenum b, GLintptr c, GLintptr d, GLsizeiptr e))             \
    X(BindBuffer, (GLenum a, GLuint b))                                                          \
    X(BindBufferBase, (GLenum a, GLuint b, GLuint c))                                            \
    X(BindBufferRange, (GLenum a, GLuint b, GLuint c, GLintptr d, GLsizeiptr e))                 \
    X(CompileShader, (GLuint a))                                                                 \
    X(AttachShader, (GLuint a, GLuint b))                                                        \
    X(LinkProgram, (GLuint a))                                                                   \
    X(UseProgram, (GLuint a))                                                                    \
    X(ProgramUniform1i, (GLuint a, GLint b, GLint c))                                            \
    X(ProgramUniform1f, (GLuint a, GLint b, GLfloat c))                                          \
    X(ProgramUniform1iv, (GLuint a, GLint b, GLsizei c, const GLint *d))                         \
    X(ProgramUniform4fv, (GLuint a, GLint b, GLsizei c, const GLfloat *d))                       \
    X(Flush, (void))                                                                             \
    X(ObjectLabel, (GLenum a, GLuint b, GLsizei c, const GLchar *d))                             \
    X(ObjectPtrLabel, (const void *a, GLsizei b, const GLchar *c))

#define NOTHING(name, parameters)                 \
    static void GL_CALL hostile_##name parameters \
    {                                             \
        works();                                  \
    }
DOES_NOTHING(NOTHING)

static void GL_CALL hostile_DispatchCompute(GLuint x, GLuint y, GLuint z)
{
    works();
    driver.dispatches++;
    driver.overtaking += driver.under_way++ > 0;
}

static void GL_CALL hostile_MemoryBarrier(GLbitfield which)
{
    works();
    driver.barriers++;
    driver.under_way = 0;
}

static void GL_CALL hostile_BindFramebuffer(GLenum target, GLuint framebuffer)
{
    works();
    driver.binds++;
}

static void GL_CALL hostile_BufferSubData(GLenum target, GLintptr offset, GLsizeiptr bytes,
                                          const void *data)
{
    works();
    driver.uploaded += (int)bytes;
}

// ---- Objects

static void make(GLsizei count, GLuint *names)
{
    const bool good = works();
    for (int i = 0; i < count; i++) {
        names[i] = good && !nonsense() ? (GLuint)++driver.calls : 0;
        driver.objects += names[i] != 0;
    }
}

// Deleting is never without effect here, so that what is left behind shows.
static void drop(GLsizei count, const GLuint *names)
{
    works();
    for (int i = 0; i < count; i++) driver.objects -= names[i] != 0;
}

#define OBJECTS(X) X(Framebuffers) X(Buffers) X(Samplers) X(VertexArrays)
#define OBJECT(kind)                                                             \
    static void GL_CALL hostile_Create##kind(GLsizei count, GLuint *names)       \
    {                                                                            \
        make(count, names);                                                      \
    }                                                                            \
    static void GL_CALL hostile_Delete##kind(GLsizei count, const GLuint *names) \
    {                                                                            \
        drop(count, names);                                                      \
    }
OBJECTS(OBJECT)

static void GL_CALL hostile_CreateTextures(GLenum target, GLsizei count, GLuint *names)
{
    make(count, names);
}

static void GL_CALL hostile_DeleteTextures(GLsizei count, const GLuint *names)
{
    drop(count, names);
}

static GLuint GL_CALL hostile_CreateShader(GLenum type)
{
    GLuint name;
    make(1, &name);
    return name;
}

static GLuint GL_CALL hostile_CreateProgram(void)
{
    return hostile_CreateShader(0);
}

static void GL_CALL hostile_DeleteShader(GLuint name)
{
    drop(1, &name);
}

static void GL_CALL hostile_DeleteProgram(GLuint name)
{
    drop(1, &name);
}

// Reads all of the text, as a driver does.
static void GL_CALL hostile_ShaderSource(GLuint shader, GLsizei count, const GLchar *const *text,
                                         const GLint *length)
{
    size_t sum = 0;
    works();
    for (int i = 0; i < count; i++)
        sum += length && length[i] >= 0 ? (size_t)length[i] : strlen(text[i]);
    CHECK(sum > 20, "a shader of %d bytes", (int)sum);
}

// ---- Questions

static GLenum GL_CALL hostile_GetError(void)
{
    if (!works()) return CONTEXT_LOST;
    return nonsense() ? (GLenum)strange() : 0;
}

static const unsigned char *GL_CALL hostile_GetString(GLenum name)
{
    static const unsigned char good[] = "4.5 (Core Profile)",
                               bad[] = {0xff, '%', 'n', 0x80, '%', 's', 0};
    return works() ? (nonsense() ? bad : good) : NULL;
}

static void GL_CALL hostile_GetIntegerv(GLenum name, GLint *value)
{
    if (!works()) return; // a lost context writes nothing
    *value = name == GL_MAJOR_VERSION ? 4 : name == GL_MINOR_VERSION ? 5 : ANY_NUMBER;
    if (name == TEXTURE_BINDING_CUBE_MAP) *value = 9; // the one that is given to update
    if (nonsense()) *value = strange();
}

static void GL_CALL hostile_GetIntegeri_v(GLenum name, GLuint index, GLint *value)
{
    if (works()) *value = nonsense() ? strange() : 0;
}

static void GL_CALL hostile_GetInteger64i_v(GLenum name, GLuint index, int64_t *value)
{
    if (works()) *value = nonsense() ? (int64_t)test_random(&driver.random) : 0;
}

static void GL_CALL hostile_GetFloati_v(GLenum name, GLuint index, GLfloat *value)
{
    for (int i = 0; i < 2 && works(); i++) value[i] = nonsense() ? (GLfloat)strange() : 0;
}

static void GL_CALL hostile_GetDoublei_v(GLenum name, GLuint index, GLdouble *value)
{
    for (int i = 0; i < 2 && works(); i++) value[i] = nonsense() ? (GLdouble)strange() : 0;
}

static void GL_CALL hostile_GetBooleani_v(GLenum name, GLuint index, GLboolean *value)
{
    if (works()) value[0] = nonsense() ? (GLboolean)strange() : GL_TRUE;
}

static const unsigned char *GL_CALL hostile_GetStringi(GLenum name, GLuint index)
{
    static const unsigned char bounds[] = "GL_EXT_depth_bounds_test";
    return works() && !nonsense() ? bounds : NULL;
}

static GLboolean GL_CALL hostile_IsEnabled(GLenum name)
{
    return works() && nonsense();
}

static GLboolean GL_CALL hostile_IsEnabledi(GLenum name, GLuint index)
{
    return works() && nonsense();
}

#define IS(kind)                                           \
    static GLboolean GL_CALL hostile_Is##kind(GLuint name) \
    {                                                      \
        return works() && !nonsense();                     \
    }
// clang-format off
IS(Texture) IS(Sampler) IS(Framebuffer) IS(Program) IS(VertexArray) IS(Buffer)
    // clang-format on

    static GLenum GL_CALL hostile_CheckNamedFramebufferStatus(GLuint framebuffer, GLenum target)
{
    return works() && !nonsense() ? GL_FRAMEBUFFER_COMPLETE : 0;
}

static void GL_CALL hostile_GetTexParameteriv(GLenum target, GLenum name, GLint *value)
{
    if (works()) *value = nonsense() ? strange() : 0;
}

static void GL_CALL hostile_GetTexLevelParameteriv(GLenum target, GLint level, GLenum name,
                                                   GLint *value)
{
    int good = target == FLAT || target == GL_TEXTURE_2D_ARRAY ? 64 : 16; // side, depth's bits
    if (name == GL_TEXTURE_SAMPLES) good = 4;
    if (name == INTERNAL_FORMAT) good = GL_RGBA32F;
    if ((name == DEPTH_SIZE && target != FLAT) || name == STENCIL_SIZE) good = 0;
    if (works()) *value = nonsense() ? strange() : good;
}

// Of shaders and programs: their status, and how long their log claims to be.
static void ask_status(GLenum name, GLint *value)
{
    if (!works()) return;
    *value = name == GL_INFO_LOG_LENGTH ? 30 : GL_TRUE;
    if (nonsense()) *value = name == GL_INFO_LOG_LENGTH ? strange() : 0;
}

static void GL_CALL hostile_GetShaderiv(GLuint shader, GLenum name, GLint *value)
{
    ask_status(name, value);
}

static void GL_CALL hostile_GetProgramiv(GLuint program, GLenum name, GLint *value)
{
    ask_status(name, value);
}

// Fills all there is, without a terminator, and lies about how much that was.
static void give_log(GLsizei room, GLsizei *length, GLchar *log)
{
    if (!works()) return;
    for (int i = 0; i < room; i++) log[i] = "%n%s\xff\n"[i % 6];
    if (length) *length = strange();
}

static void GL_CALL hostile_GetShaderInfoLog(GLuint shader, GLsizei room, GLsizei *length,
                                             GLchar *log)
{
    give_log(room, length, log);
}

static void GL_CALL hostile_GetProgramInfoLog(GLuint program, GLsizei room, GLsizei *length,
                                              GLchar *log)
{
    give_log(room, length, log);
}

// Exactly the bytes asked for, with anything in them.
static void *GL_CALL hostile_MapBufferRange(GLenum target, GLintptr offset, GLsizeiptr length,
                                            GLbitfield access)
{
    if (!works() || driver.mapped_count == 8 || length <= 0 || length > 1 << 24) return NULL;
    unsigned char *memory = malloc((size_t)length);
    for (GLsizeiptr i = 0; memory && i < length; i++)
        memory[i] = driver.mode == GARBAGE ? (unsigned char)test_random(&driver.random) : 0;
    driver.mapped[driver.mapped_count++] = memory;
    return memory;
}

static void *GL_CALL hostile_FenceSync(GLenum condition, GLbitfield flags)
{
    static int fence;
    return works() && !nonsense() ? &fence : NULL;
}

static GLenum GL_CALL hostile_ClientWaitSync(void *fence, GLbitfield flags, uint64_t nanoseconds)
{
    if (!works()) return SYNC_WAIT_FAILED;
    return nonsense() ? (GLenum)strange() : SYNC_SIGNALED;
}

static void GL_CALL hostile_DeleteSync(void *fence)
{
    works();
}

#define RETURN(name_) \
    if (!strcmp(name, "gl" #name_)) return (gl_fakes_function)hostile_##name_;
#define RETURN_NOTHING(name_, parameters) RETURN(name_)
#define RETURN_OBJECT(kind) RETURN(Create##kind) RETURN(Delete##kind)

static gl_fakes_function load_hostile(const char *name)
{
    // clang-format off
    DOES_NOTHING(RETURN_NOTHING)
    RETURN(DispatchCompute) RETURN(MemoryBarrier) RETURN(BindFramebuffer) RETURN(BufferSubData)
    OBJECTS(RETURN_OBJECT)
    RETURN(CreateTextures) RETURN(DeleteTextures) RETURN(CreateShader) RETURN(DeleteShader)
    RETURN(CreateProgram) RETURN(DeleteProgram) RETURN(ShaderSource) RETURN(GetError)
    RETURN(GetString) RETURN(GetIntegerv) RETURN(GetIntegeri_v) RETURN(GetInteger64i_v)
    RETURN(GetFloati_v) RETURN(IsEnabled) RETURN(GetDoublei_v) RETURN(GetBooleani_v)
    RETURN(GetStringi) RETURN(IsSampler) RETURN(IsFramebuffer) RETURN(IsProgram)
    RETURN(IsVertexArray) RETURN(IsBuffer) RETURN(IsEnabledi) RETURN(IsTexture)
    RETURN(CheckNamedFramebufferStatus) RETURN(GetTexParameteriv) RETURN(GetTexLevelParameteriv)
    RETURN(GetShaderiv) RETURN(GetProgramiv) RETURN(GetShaderInfoLog) RETURN(GetProgramInfoLog)
    RETURN(MapBufferRange) RETURN(FenceSync) RETURN(ClientWaitSync) RETURN(DeleteSync)
        // clang-format on
        CHECK(0, "%s is not in the hostile driver", name);
    return NULL;
}

// ---- Lives on it

static void log_hostile(void *user, const char *message)
{
    (void)user;
    driver.messages++;
    driver.longest = strlen(message) > driver.longest ? strlen(message) : driver.longest;
}

static void begin_driver(int mode, int lost_after, uint64_t seed)
{
    memset(&driver, 0, sizeof driver);
    driver.mode = mode;
    driver.lost_after = lost_after;
    driver.random = seed * 2 + 1;
    driver.rarity = 3 << seed % 9; // down to one in 768: some get through their whole life
    gl_fakes_reset();
}

static void end_driver(const char *what)
{
    for (int i = 0; i < driver.mapped_count; i++) free(driver.mapped[i]);
    CHECK(!gl_fakes_living_memory(), "%s: %d pieces of memory are left", what,
          gl_fakes_living_memory());
    CHECK(driver.mode == GARBAGE || !driver.objects, "%s: %d objects are left", what,
          driver.objects);
}

static void check_result(int r, int most, const char *what, const char *call)
{
    CHECK(r >= 0 && r <= most, "%s: %s gave %d", what, call, r);
}

// Of calls of mssm.h; a failure has something to say.
static int count_failures(const mssm_result *all, int n, int messages_before, const char *what)
{
    int failures = 0;
    for (int i = 0; i < n; i++) {
        check_result((int)all[i], MSSM_ERROR_ORDER, what, "a call");
        failures += all[i] != MSSM_OK;
    }
    CHECK(!failures || driver.messages > messages_before, "%s: %d failures without a word", what,
          failures);
    return failures;
}

// What every life begins with: a light, and what create said.
static mssm_light light_of_half_size(float half)
{
    static const float up[3] = {0, 1, 0}, axis[3] = {1, 0, 0}, low[3] = {-1, -1, -1},
                       high[3] = {1, 1, 1};
    mssm_light light;
    mssm_light_directional(&light, up, axis, half, half, low, high);
    return light;
}

static void check_create(mssm_result r, bool made, const char *what)
{
    check_result((int)r, MSSM_ERROR_ORDER, what, "create");
    CHECK(!r == made && (!r || driver.messages > 0), "%s: result %d, %d messages", what, r,
          driver.messages);
}

// Every call of mssm.h once, in order; the number of failures.
static int live_mssm(const char *what)
{
    const mssm_light light = light_of_half_size(0.1f);
    mssm_gl_desc d;
    mssm_gl *g = NULL;
    memset(&d, 0, sizeof d);
    d.load = load_hostile;
    d.lights = 2;
    d.side = 64;
    d.log = log_hostile;
    const mssm_result r = mssm_gl_create(&g, &d);
    check_create(r, g != NULL, what);
    if (r) return 1;
    const int before = driver.messages;
    mssm_result all[14];
    const mssm_gl_depth given = {ANY_NUMBER, 0, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0};
    int n = 0;
    all[n++] = mssm_gl_set_light(g, 0, &light);
    all[n++] = mssm_gl_set_light(g, 1, &light);
    all[n++] = mssm_gl_begin_depth(g, 0, 0);
    all[n++] = mssm_gl_end_depth(g);
    all[n++] = mssm_gl_begin_depth(g, 0, 1);
    all[n++] = mssm_gl_end_depth(g);
    all[n++] = mssm_gl_build(g);
    all[n++] = mssm_gl_bind(g);
    all[n++] = mssm_gl_show(g, 0, MSSM_SHOW_MEAN);
    all[n++] = mssm_gl_set_moments(g, 1, ANY_NUMBER);
    all[n++] = mssm_gl_set_depth(g, 1, &given, NULL);
    all[n++] = mssm_gl_set_depth(g, 0, &given, &given);
    all[n++] = mssm_gl_resize(g, 3, 128);
    all[n++] = mssm_gl_build(g);
    const int failures = count_failures(all, n, before, what);
    CHECK(mssm_gl_shader(g) && strlen(mssm_gl_shader(g)) > 1000, "%s: no shading text", what);
    mssm_gl_destroy(g);
    return failures;
}

static int live_filtered(const char *what)
{
    const mssm_light light = light_of_half_size(0);
    mssm_gl_desc d;
    mssm_gl *g = NULL;
    memset(&d, 0, sizeof d);
    d.load = load_hostile;
    d.lights = 2;
    d.filtered = 1;
    d.side = 64;
    d.log = log_hostile;
    const mssm_result r = mssm_gl_create(&g, &d);
    check_create(r, g != NULL, what);
    if (r) return 1;
    const int before = driver.messages;
    mssm_result all[7];
    int n = 0;
    all[n++] = mssm_gl_set_light(g, 1, &light);
    all[n++] = mssm_gl_begin_depth(g, 1, 0);
    all[n++] = mssm_gl_end_depth(g);
    all[n++] = mssm_gl_begin_translucent(g);
    all[n++] = mssm_gl_end_translucent(g);
    all[n++] = mssm_gl_build(g);
    all[n++] = mssm_gl_bind(g);
    const int failures = count_failures(all, n, before, what);
    mssm_gl_destroy(g);
    return failures;
}

static int live_lightprobe(const char *what)
{
    lightprobe_light lights[4];
    lightprobe_gl_desc d;
    lightprobe_gl *g = NULL;
    lightprobe_stats stats;
    int failures = 0, count = -3;
    memset(&d, 0, sizeof d);
    d.load = load_hostile;
    d.side = 16;
    d.max_lights = 4;
    d.log = log_hostile;
    lightprobe_result r = lightprobe_gl_create(&g, &d);
    check_result((int)r, LIGHTPROBE_ERROR_ORDER, what, "create");
    CHECK(!r == !!g && (!r || driver.messages > 0), "%s: result %d, %d messages", what, r,
          driver.messages);
    if (r) return 1;
    for (int i = 0; i < 5; i++) {
        r = lightprobe_gl_update(g, 9);
        check_result((int)r, LIGHTPROBE_ERROR_ORDER, what, "update");
        failures += r != LIGHTPROBE_OK;
        if (i == 3) lightprobe_gl_restart(g);
        r = lightprobe_gl_read(g, i == 2, lights, &count, &stats);
        check_result((int)r, LIGHTPROBE_ERROR_ORDER, what, "read");
        CHECK(r ? count == -3 : count >= 0 && count <= 4, "%s: result %d, %d lights", what, r,
              count);
        failures += r != LIGHTPROBE_OK && r != LIGHTPROBE_ERROR_NOT_READY;
        count = -3;
        const lightprobe_gl_range range = lightprobe_gl_lights(g, i & 1);
        CHECK(range.offset >= 0 && range.bytes >= 0, "%s: a range from %ld", what,
              (long)range.offset);
    }
    lightprobe_gl_destroy(g);
    return failures;
}

static const struct {
    const char *name;
    int (*live)(const char *what);
    int noticed; // at least one nonsense in so many; filtered maps ask the driver least
} lives[] = {
    {"mssm.h", live_mssm, 2}, {"filtered", live_filtered, 3}, {"lightprobe.h", live_lightprobe, 2}};
enum { LIVES = sizeof lives / sizeof *lives };

static void a_context_may_be_lost_at_any_call(void)
{
    char what[60];
    for (int k = 0; k < LIVES; k++) {
        begin_driver(WORKS, 0, 1);
        CHECK(lives[k].live(lives[k].name) == 0, "%s fails on a driver that works", lives[k].name);
        const int calls = driver.calls;
        end_driver(lives[k].name);
        int failed = 0;
        for (int after = 0; after < calls; after += 1 + (test_trials(100) < 10 ? 16 : 0)) {
            snprintf(what, sizeof what, "%s, lost after %d calls", lives[k].name, after);
            begin_driver(LOST, after, 1);
            failed += lives[k].live(what) > 0;
            end_driver(what);
        }
        test_note("%s: %d calls, the context lost after each of them: %d failed", lives[k].name,
                  calls, failed);
        CHECK(failed > 20 || test_trials(100) < 10, "hardly any loss is noticed");
    }
}

static void drivers_may_answer_nonsense(void)
{
    char what[60];
    for (int k = 0; k < LIVES; k++) {
        int failed = 0;
        size_t longest = 0;
        const int rounds = test_trials(4000);
        for (int seed = 0; seed < rounds; seed++) {
            snprintf(what, sizeof what, "%s, nonsense %d", lives[k].name, seed);
            begin_driver(GARBAGE, 0, (uint64_t)seed);
            failed += lives[k].live(what) > 0;
            longest = driver.longest > longest ? driver.longest : longest;
            end_driver(what);
        }
        test_note("%s: %d of %d drivers fail, longest message %d", lives[k].name, failed, rounds,
                  (int)longest);
        CHECK(failed > rounds / lives[k].noticed && longest <= (1 << 20) + 1, "message of %d bytes",
              (int)longest);
    }
}

// What is in range is made or refused with a word; nothing is computed with numbers that overflow.
static void extreme_sizes_are_made_or_refused(void)
{
    static const int numbers[] = {INT_MIN, -1,   0,     1,     2,     4096,
                                  4097,    8192, 16384, 16385, 65536, INT_MAX};
    enum { N = sizeof numbers / sizeof *numbers };
    int made = 0, refused = 0;
    for (int i = 0; i < N * N * 3; i++) {
        begin_driver(WORKS, 0, 1);
        mssm_gl_desc d;
        mssm_gl *g = NULL;
        memset(&d, 0, sizeof d);
        d.load = load_hostile;
        d.log = log_hostile;
        d.lights = numbers[i % N];
        d.side = numbers[i / N % N];
        d.samples = i / N / N == 0 ? 4 : i / N / N == 1 ? INT_MAX : -1;
        const mssm_result r = mssm_gl_create(&g, &d);
        const bool valid =
            d.lights >= 0 && d.lights < INT_MAX && d.side >= 0 && d.side <= 16384 && d.samples == 4;
        CHECK(!r == !!g && (r || valid) && (!r || driver.messages),
              "%d lights, side %d, %d samples: result %d", d.lights, d.side, d.samples, r);
        made += !r;
        refused += r != MSSM_OK;
        mssm_gl_destroy(g);
        lightprobe_gl_desc p;
        lightprobe_gl *l = NULL;
        memset(&p, 0, sizeof p);
        p.load = load_hostile;
        p.log = log_hostile;
        p.max_lights = numbers[i % N];
        p.side = numbers[i / N % N];
        const lightprobe_result q =
            i < N * N ? lightprobe_gl_create(&l, &p) : LIGHTPROBE_ERROR_SIDE;
        CHECK(!q == !!l && (q || (p.max_lights >= 0 && p.max_lights <= 4096 && p.side >= 0 &&
                                  p.side <= 8192)),
              "%d lights, side %d: result %d", p.max_lights, p.side, q);
        lightprobe_gl_destroy(l);
        end_driver("sizes");
    }
    test_note("%d made, %d refused", made, refused);
    CHECK(made > 10 && refused > 10, "%d made, %d refused", made, refused);
}

// Within a frame nothing asks GL, which may cost a wait each time, and calls are few.
static void frames_ask_nothing(void)
{
    enum { LIGHTS = 50 };
    const mssm_light light = light_of_half_size(0.1f);
    int calls[2] = {0, 0}, questions[2] = {0, 0};
    for (int framed = 0; framed < 2; framed++) {
        mssm_gl_desc d;
        mssm_gl *g = NULL;
        begin_driver(WORKS, 0, 1);
        memset(&d, 0, sizeof d);
        d.load = load_hostile;
        d.lights = LIGHTS;
        d.side = 64;
        d.log = log_hostile;
        CHECK(!mssm_gl_create(&g, &d), "create");
        for (int i = 0; g && i < LIGHTS; i++) CHECK(!mssm_gl_set_light(g, i, &light), "light");
        if (g && framed) CHECK(!mssm_gl_begin_frame(g), "begin");
        const int calls_before = driver.calls, questions_before = driver.questions;
        for (int i = 0; g && i < LIGHTS; i++)
            CHECK(!mssm_gl_begin_depth(g, i, 0) && !mssm_gl_end_depth(g), "pass");
        if (g) CHECK(!mssm_gl_build(g), "build");
        calls[framed] = driver.calls - calls_before;
        questions[framed] = driver.questions - questions_before;
        for (int i = 0; g && i < 2; i++) { // nothing has changed
            const int built = driver.calls;
            CHECK(!mssm_gl_set_light(g, i, &light), "the same light");
            CHECK(!mssm_gl_build(g) && driver.calls == built, "%d calls to build nothing",
                  driver.calls - built);
        }
        const mssm_gl_depth given = {ANY_NUMBER, 0, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0};
        for (int round = 0; g && round < 2; round++) {
            const int asked = driver.questions;
            for (int i = 0; i < LIGHTS; i++)
                CHECK(!mssm_gl_set_depth(g, i, &given, NULL), "set_depth");
            CHECK((driver.questions == asked) == (framed && round),
                  "given depth, round %d: %d questions", round, driver.questions - asked);
        }
        if (g && framed) CHECK(!mssm_gl_end_frame(g), "end");
        mssm_gl_destroy(g);
        end_driver("a frame");
    }
    test_note("%d lights: %d calls, %d of them questions; in a frame %d and %d", LIGHTS, calls[0],
              questions[0], calls[1], questions[1]);
    CHECK(questions[0] > LIGHTS, "questions are not counted");
    CHECK(!questions[1] && calls[1] <= 30 * LIGHTS, "%d calls, %d questions", calls[1],
          questions[1]);
}

// GPUs wait at each barrier. Depth passes become moments many at a time (16 layers are 15 lights
// and room for back faces, or 8 lights with these), front faces that back faces follow not alone,
// and of 50 lights one that changes is uploaded alone.
static void only_what_is_needed_is_done(void)
{
    enum { LIGHTS = 50 };
    const mssm_light light = light_of_half_size(0.1f), other = light_of_half_size(0.05f);
    static const int resolves[2] = {(LIGHTS + 14) / 15, (LIGHTS + 7) / 8};
    int dispatches[2] = {0, 0}, barriers[2] = {0, 0};
    mssm_gl_desc d;
    mssm_gl *g = NULL;
    begin_driver(WORKS, 0, 1);
    memset(&d, 0, sizeof d);
    d.load = load_hostile;
    d.lights = LIGHTS;
    d.log = log_hostile;
    CHECK(!mssm_gl_create(&g, &d), "create");
    for (int i = 0; g && i < LIGHTS; i++) CHECK(!mssm_gl_set_light(g, i, &light), "light");
    for (int back = 0; back < 2 && g; back++) {
        const int made = driver.dispatches, waited = driver.barriers, bound = driver.binds;
        for (int i = 0; i < LIGHTS; i++) {
            for (int k = 0; k <= back; k++)
                CHECK(!mssm_gl_begin_depth(g, i, k) && !mssm_gl_end_depth(g), "pass");
        }
        const int last = driver.dispatches;
        CHECK(!mssm_gl_build(g), "build");
        // All but the last lights wait for no build; three for least depths, two a level.
        CHECK(last - made == resolves[back] - 1 && driver.dispatches - last <= 1 + 3 + 2 * 5,
              "%d dispatches before the build, %d in it", last - made, driver.dispatches - last);
        dispatches[back] = driver.dispatches - made;
        barriers[back] = driver.barriers - waited;
        CHECK(barriers[back] <= dispatches[back] + 1, "%d barriers", barriers[back]);
        CHECK(driver.binds - bound == 2 * LIGHTS * (1 + back), "%d framebuffers bound",
              driver.binds - bound);
    }
    const int all = driver.uploaded;
    for (int i = 0; i < 3 && g; i++) {
        const int before = driver.uploaded, calls = driver.calls, at[3] = {0, 17, LIGHTS - 1};
        CHECK(!mssm_gl_set_light(g, at[i], &other) && !mssm_gl_build(g), "one light");
        const int bytes = driver.uploaded - before;
        CHECK(bytes > 0 && bytes < 200 && driver.calls - calls < 10, "%d bytes, %d calls", bytes,
              driver.calls - calls);
    }
    test_note(
        "%d lights: %d dispatches, %d with back faces, %d and %d barriers, %d bytes of views twice; of one light %d",
        LIGHTS, dispatches[0], dispatches[1], barriers[0], barriers[1], all,
        (driver.uploaded - all) / 3);
    mssm_gl_destroy(g);
    end_driver("what is needed");
}

// All write what another reads, even another object's: without barriers GPUs run them at once.
static void dispatches_wait_for_each_other(void)
{
    const mssm_light light = light_of_half_size(0.1f);
    mssm_gl_desc d;
    mssm_gl *smoke = NULL, *soft = NULL;
    begin_driver(WORKS, 0, 1);
    for (int k = 0; k < LIVES; k++) CHECK(lives[k].live("a life") == 0, "%s", lives[k].name);
    memset(&d, 0, sizeof d);
    d.load = load_hostile;
    d.log = log_hostile;
    d.lights = 3;
    CHECK(!mssm_gl_create(&soft, &d), "create");
    d.filtered = 1;
    CHECK(!mssm_gl_create(&smoke, &d) && !mssm_gl_set_light(smoke, 0, &light), "create");
    for (int framed = 0; framed < 2 && soft && smoke; framed++) {
        if (framed) CHECK(!mssm_gl_begin_frame(soft) && !mssm_gl_begin_frame(smoke), "begin");
        for (int i = 0; i < 3; i++) { // one set of filtered moments serves all lights
            CHECK(!mssm_gl_begin_depth(smoke, 0, 0) && !mssm_gl_end_depth(smoke), "pass");
            if (framed)
                CHECK(!mssm_gl_set_light(soft, i, &light) &&
                          !mssm_gl_set_moments(soft, i, mssm_gl_texture(smoke, 3)),
                      "set_moments");
        }
        if (framed) CHECK(!mssm_gl_end_frame(smoke) && !mssm_gl_end_frame(soft), "end");
    }
    test_note("%d dispatches", driver.dispatches);
    CHECK(driver.dispatches > 30 && !driver.overtaking, "%d of %d dispatches wait for none",
          driver.overtaking, driver.dispatches);
    mssm_gl_destroy(soft);
    mssm_gl_destroy(smoke);
    end_driver("dispatches");
}

static void thousands_of_lives_leave_nothing(void)
{
    const int count = test_trials(2000);
    begin_driver(WORKS, 0, 1);
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < LIVES; k++)
            CHECK(lives[k].live("a life") == 0, "life %d of %s fails", i, lives[k].name);
        CHECK(!gl_fakes_living_memory() && !driver.objects,
              "life %d: %d objects, %d pieces of memory are left", i, driver.objects,
              gl_fakes_living_memory());
        while (driver.mapped_count > 0) free(driver.mapped[--driver.mapped_count]);
    }
    end_driver("the last life");
}

const test_case gl_hostile_tests[] = {
    {"hostile driver: the context may be lost at any call", a_context_may_be_lost_at_any_call},
    {"hostile driver: any answer may be nonsense", drivers_may_answer_nonsense},
    {"hostile driver: extreme sizes are made or refused", extreme_sizes_are_made_or_refused},
    {"hostile driver: within a frame nothing is asked", frames_ask_nothing},
    {"hostile driver: only what is needed is done", only_what_is_needed_is_done},
    {"hostile driver: dispatches wait for each other", dispatches_wait_for_each_other},
    {"hostile driver: 2000 lives leave nothing behind", thousands_of_lives_leave_nothing},
    {NULL, NULL},
};
