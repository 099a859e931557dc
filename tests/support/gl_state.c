#include "gl_state.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- What there is to look at ------------------------------------------------------------------

typedef struct named {
    const char *name;
    GLenum value;
    int count; // numbers
} named;

// Read by glGetDoublev, which converts integers and booleans exactly.
static const named numbers[] = {
    {"CURRENT_PROGRAM", 0x8B8D, 1},
    {"PROGRAM_PIPELINE_BINDING", 0x825A, 1},
    {"DRAW_FRAMEBUFFER_BINDING", 0x8CA6, 1},
    {"READ_FRAMEBUFFER_BINDING", 0x8CAA, 1},
    {"RENDERBUFFER_BINDING", 0x8CA7, 1},
    {"VERTEX_ARRAY_BINDING", 0x85B5, 1},
    {"ACTIVE_TEXTURE", 0x84E0, 1},
    {"TRANSFORM_FEEDBACK_BINDING", 0x8E25, 1},
    {"TRANSFORM_FEEDBACK_PAUSED", 0x8E23, 1},
    {"TRANSFORM_FEEDBACK_ACTIVE", 0x8E24, 1},
    {"ARRAY_BUFFER_BINDING", 0x8894, 1},
    {"ELEMENT_ARRAY_BUFFER_BINDING", 0x8895, 1},
    {"PIXEL_PACK_BUFFER_BINDING", 0x88ED, 1},
    {"PIXEL_UNPACK_BUFFER_BINDING", 0x88EF, 1},
    {"TEXTURE_BUFFER_BINDING", 0x8C2A, 1},
    {"TRANSFORM_FEEDBACK_BUFFER_BINDING", 0x8C8F, 1},
    {"UNIFORM_BUFFER_BINDING", 0x8A28, 1},
    {"SHADER_STORAGE_BUFFER_BINDING", 0x90D3, 1},
    {"ATOMIC_COUNTER_BUFFER_BINDING", 0x92C1, 1},
    {"COPY_READ_BUFFER_BINDING", 0x8F36, 1},
    {"COPY_WRITE_BUFFER_BINDING", 0x8F37, 1},
    {"DRAW_INDIRECT_BUFFER_BINDING", 0x8F43, 1},
    {"DISPATCH_INDIRECT_BUFFER_BINDING", 0x90EF, 1},
    {"QUERY_BUFFER_BINDING", 0x9193, 1},
    {"PACK_SWAP_BYTES", 0x0D00, 1},
    {"PACK_LSB_FIRST", 0x0D01, 1},
    {"PACK_ROW_LENGTH", 0x0D02, 1},
    {"PACK_SKIP_ROWS", 0x0D03, 1},
    {"PACK_SKIP_PIXELS", 0x0D04, 1},
    {"PACK_ALIGNMENT", 0x0D05, 1},
    {"PACK_SKIP_IMAGES", 0x806B, 1},
    {"PACK_IMAGE_HEIGHT", 0x806C, 1},
    {"UNPACK_SWAP_BYTES", 0x0CF0, 1},
    {"UNPACK_LSB_FIRST", 0x0CF1, 1},
    {"UNPACK_ROW_LENGTH", 0x0CF2, 1},
    {"UNPACK_SKIP_ROWS", 0x0CF3, 1},
    {"UNPACK_SKIP_PIXELS", 0x0CF4, 1},
    {"UNPACK_ALIGNMENT", 0x0CF5, 1},
    {"UNPACK_SKIP_IMAGES", 0x806D, 1},
    {"UNPACK_IMAGE_HEIGHT", 0x806E, 1},
    {"DEPTH_FUNC", 0x0B74, 1},
    {"DEPTH_WRITEMASK", 0x0B72, 1},
    {"DEPTH_CLEAR_VALUE", 0x0B73, 1},
    {"COLOR_CLEAR_VALUE", 0x0C22, 4},
    {"STENCIL_CLEAR_VALUE", 0x0B91, 1},
    {"STENCIL_FUNC", 0x0B92, 1},
    {"STENCIL_VALUE_MASK", 0x0B93, 1},
    {"STENCIL_FAIL", 0x0B94, 1},
    {"STENCIL_PASS_DEPTH_FAIL", 0x0B95, 1},
    {"STENCIL_PASS_DEPTH_PASS", 0x0B96, 1},
    {"STENCIL_REF", 0x0B97, 1},
    {"STENCIL_WRITEMASK", 0x0B98, 1},
    {"STENCIL_BACK_FUNC", 0x8800, 1},
    {"STENCIL_BACK_FAIL", 0x8801, 1},
    {"STENCIL_BACK_PASS_DEPTH_FAIL", 0x8802, 1},
    {"STENCIL_BACK_PASS_DEPTH_PASS", 0x8803, 1},
    {"STENCIL_BACK_REF", 0x8CA3, 1},
    {"STENCIL_BACK_VALUE_MASK", 0x8CA4, 1},
    {"STENCIL_BACK_WRITEMASK", 0x8CA5, 1},
    {"CULL_FACE_MODE", 0x0B45, 1},
    {"FRONT_FACE", 0x0B46, 1},
    {"POLYGON_MODE", 0x0B40, 2},
    {"POLYGON_OFFSET_FACTOR", 0x8038, 1},
    {"POLYGON_OFFSET_UNITS", 0x2A00, 1},
    {"LINE_WIDTH", 0x0B21, 1},
    {"POINT_SIZE", 0x0B11, 1},
    {"POINT_FADE_THRESHOLD_SIZE", 0x8128, 1},
    {"POINT_SPRITE_COORD_ORIGIN", 0x8CA0, 1},
    {"PROVOKING_VERTEX", 0x8E4F, 1},
    {"PRIMITIVE_RESTART_INDEX", 0x8F9E, 1},
    {"PATCH_VERTICES", 0x8E72, 1},
    {"PATCH_DEFAULT_INNER_LEVEL", 0x8E73, 2},
    {"PATCH_DEFAULT_OUTER_LEVEL", 0x8E74, 4},
    {"CLIP_ORIGIN", 0x935C, 1},
    {"CLIP_DEPTH_MODE", 0x935D, 1},
    {"BLEND_COLOR", 0x8005, 4},
    {"LOGIC_OP_MODE", 0x0BF0, 1},
    {"SAMPLE_COVERAGE_VALUE", 0x80AA, 1},
    {"SAMPLE_COVERAGE_INVERT", 0x80AB, 1},
    {"MIN_SAMPLE_SHADING_VALUE", 0x8C37, 1},
    {"CLAMP_READ_COLOR", 0x891C, 1},
    {"LINE_SMOOTH_HINT", 0x0C52, 1},
    {"POLYGON_SMOOTH_HINT", 0x0C53, 1},
    {"TEXTURE_COMPRESSION_HINT", 0x84EF, 1},
    {"FRAGMENT_SHADER_DERIVATIVE_HINT", 0x8B8B, 1},
    {"DEBUG_GROUP_STACK_DEPTH", 0x826D, 1},
};

static const named switches[] = {
    {"BLEND", 0x0BE2, 1},
    {"COLOR_LOGIC_OP", 0x0BF2, 1},
    {"CULL_FACE", 0x0B44, 1},
    {"DEBUG_OUTPUT", 0x92E0, 1},
    {"DEBUG_OUTPUT_SYNCHRONOUS", 0x8242, 1},
    {"DEPTH_CLAMP", 0x864F, 1},
    {"DEPTH_TEST", 0x0B71, 1},
    {"DITHER", 0x0BD0, 1},
    {"FRAMEBUFFER_SRGB", 0x8DB9, 1},
    {"LINE_SMOOTH", 0x0B20, 1},
    {"MULTISAMPLE", 0x809D, 1},
    {"POLYGON_OFFSET_FILL", 0x8037, 1},
    {"POLYGON_OFFSET_LINE", 0x2A02, 1},
    {"POLYGON_OFFSET_POINT", 0x2A01, 1},
    {"POLYGON_SMOOTH", 0x0B41, 1},
    {"PRIMITIVE_RESTART", 0x8F9D, 1},
    {"PRIMITIVE_RESTART_FIXED_INDEX", 0x8D69, 1},
    {"PROGRAM_POINT_SIZE", 0x8642, 1},
    {"RASTERIZER_DISCARD", 0x8C89, 1},
    {"SAMPLE_ALPHA_TO_COVERAGE", 0x809E, 1},
    {"SAMPLE_ALPHA_TO_ONE", 0x809F, 1},
    {"SAMPLE_COVERAGE", 0x80A0, 1},
    {"SAMPLE_MASK", 0x8E51, 1},
    {"SAMPLE_SHADING", 0x8C36, 1},
    {"SCISSOR_TEST", 0x0C11, 1},
    {"STENCIL_TEST", 0x0B90, 1},
    {"TEXTURE_CUBE_MAP_SEAMLESS", 0x884F, 1},
    {"CLIP_DISTANCE0", 0x3000, 1},
    {"CLIP_DISTANCE1", 0x3001, 1},
    {"CLIP_DISTANCE2", 0x3002, 1},
    {"CLIP_DISTANCE3", 0x3003, 1},
    {"CLIP_DISTANCE4", 0x3004, 1},
    {"CLIP_DISTANCE5", 0x3005, 1},
    {"CLIP_DISTANCE6", 0x3006, 1},
    {"CLIP_DISTANCE7", 0x3007, 1},
    // Of compatibility contexts.
    {"ALPHA_TEST", GL_ALPHA_TEST, 1},
    {"POLYGON_STIPPLE", GL_POLYGON_STIPPLE, 1},
};

static const named unit_bindings[] = {
    {"TEXTURE_BINDING_1D", 0x8068, 1},
    {"TEXTURE_BINDING_2D", 0x8069, 1},
    {"TEXTURE_BINDING_3D", 0x806A, 1},
    {"TEXTURE_BINDING_1D_ARRAY", 0x8C1C, 1},
    {"TEXTURE_BINDING_2D_ARRAY", 0x8C1D, 1},
    {"TEXTURE_BINDING_RECTANGLE", 0x84F6, 1},
    {"TEXTURE_BINDING_CUBE_MAP", 0x8514, 1},
    {"TEXTURE_BINDING_CUBE_MAP_ARRAY", 0x900A, 1},
    {"TEXTURE_BINDING_BUFFER", 0x8C2C, 1},
    {"TEXTURE_BINDING_2D_MULTISAMPLE", 0x9104, 1},
    {"TEXTURE_BINDING_2D_MULTISAMPLE_ARRAY", 0x9105, 1},
    {"SAMPLER_BINDING", 0x8919, 1},
};

static const named image_parts[] = {
    {"IMAGE_BINDING_NAME", 0x8F3A, 1},    {"IMAGE_BINDING_LEVEL", 0x8F3B, 1},
    {"IMAGE_BINDING_LAYERED", 0x8F3C, 1}, {"IMAGE_BINDING_LAYER", 0x8F3D, 1},
    {"IMAGE_BINDING_ACCESS", 0x8F3E, 1},  {"IMAGE_BINDING_FORMAT", 0x906E, 1},
};

// Indexed buffers: the binding, and below how many there are, and where start and size are.
static const struct {
    const char *name;
    GLenum binding, start, size, count;
} indexed_buffers[] = {
    {"UNIFORM_BUFFER", 0x8A28, 0x8A29, 0x8A2A, 0x8A2F},
    {"SHADER_STORAGE_BUFFER", 0x90D3, 0x90D4, 0x90D5, 0x90DD},
    {"ATOMIC_COUNTER_BUFFER", 0x92C1, 0x92C2, 0x92C3, 0x92DC},
    {"TRANSFORM_FEEDBACK_BUFFER", 0x8C8F, 0x8C84, 0x8C85, 0x8E70},
};

static const named draw_buffer_parts[] = {
    {"BLEND_SRC_RGB", 0x80C9, 1},      {"BLEND_SRC_ALPHA", 0x80CB, 1},
    {"BLEND_DST_RGB", 0x80C8, 1},      {"BLEND_DST_ALPHA", 0x80CA, 1},
    {"BLEND_EQUATION_RGB", 0x8009, 1}, {"BLEND_EQUATION_ALPHA", 0x883D, 1},
};

static const named query_targets[] = {
    {"SAMPLES_PASSED", 0x8914, 1},
    {"ANY_SAMPLES_PASSED", 0x8C2F, 1},
    {"ANY_SAMPLES_PASSED_CONSERVATIVE", 0x8D6A, 1},
    {"PRIMITIVES_GENERATED", 0x8C87, 1},
    {"TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN", 0x8C88, 1},
    {"TIME_ELAPSED", 0x88BF, 1},
};

#define LENGTH(array) ((int)(sizeof(array) / sizeof *(array)))

enum {
    STATE_MAX_TEXTURE_UNITS = 0x8B4D,
    STATE_MAX_IMAGE_UNITS = 0x8F38,
    STATE_MAX_VIEWPORTS = 0x825B,
    STATE_MAX_DRAW_BUFFERS = 0x8824,
    STATE_MAX_SAMPLE_MASK_WORDS = 0x8E59,
    STATE_SAMPLE_MASK_VALUE = 0x8E52,
    STATE_SCISSOR_BOX = 0x0C10,
    STATE_DEPTH_RANGE = 0x0B70,
    STATE_COLOR_WRITEMASK = 0x0C23,
    STATE_CURRENT_QUERY = 0x8865,
    STATE_DRAW_BUFFER0 = 0x8825,
    STATE_READ_BUFFER = 0x0C02
};

// ---- Taking it -----------------------------------------------------------------------------------

// The next entry, zeroed.
static double *add(gl_state *s, const char *name, int index)
{
    if (s->count == s->capacity) {
        s->capacity = s->capacity ? 2 * s->capacity : 1024;
        s->entry = realloc(s->entry, (size_t)s->capacity * sizeof *s->entry);
        if (!s->entry) abort();
    }
    gl_state_entry *e = &s->entry[s->count++];
    memset(e, 0, sizeof *e);
    if (index < 0)
        snprintf(e->name, sizeof e->name, "%s", name);
    else
        snprintf(e->name, sizeof e->name, "%s[%d]", name, index);
    return e->value;
}

static int limit(GLenum name)
{
    GLint n = 0;
    gl.GetIntegerv(name, &n);
    return n;
}

static bool compatible(void)
{
    return limit(GL_CONTEXT_PROFILE_MASK) & 2;
}

static int switch_count(void)
{
    return LENGTH(switches) - (compatible() ? 0 : 2);
}

static double indexed_integer(GLenum name, int index)
{
    GLint value = 0;
    gl.GetIntegeri_v(name, (GLuint)index, &value);
    return value;
}

static void take_units(gl_state *s)
{
    const int units = limit(STATE_MAX_TEXTURE_UNITS);
    const GLenum active = (GLenum)limit(0x84E0);
    for (int unit = 0; unit < units; unit++) {
        gl.ActiveTexture(GL_TEXTURE0 + (GLenum)unit);
        for (int i = 0; i < LENGTH(unit_bindings); i++) {
            add(s, unit_bindings[i].name, unit)[0] = limit(unit_bindings[i].value);
        }
    }
    gl.ActiveTexture(active);
    const int images = limit(STATE_MAX_IMAGE_UNITS);
    for (int unit = 0; unit < images; unit++) {
        for (int i = 0; i < LENGTH(image_parts); i++) {
            add(s, image_parts[i].name, unit)[0] = indexed_integer(image_parts[i].value, unit);
        }
    }
}

static void take_buffers(gl_state *s)
{
    for (int i = 0; i < LENGTH(indexed_buffers); i++) {
        const int count = limit(indexed_buffers[i].count);
        for (int k = 0; k < count; k++) {
            GLint64 start = 0, size = 0;
            double *value = add(s, indexed_buffers[i].name, k);
            value[0] = indexed_integer(indexed_buffers[i].binding, k);
            gl.GetInteger64i_v(indexed_buffers[i].start, (GLuint)k, &start);
            gl.GetInteger64i_v(indexed_buffers[i].size, (GLuint)k, &size);
            value[1] = (double)start;
            value[2] = (double)size;
        }
    }
}

static void take_targets(gl_state *s)
{
    for (int k = 0; k < limit(STATE_MAX_VIEWPORTS); k++) {
        GLfloat box[4] = {0};
        gl.GetFloati_v(GL_VIEWPORT, (GLuint)k, box);
        double *viewport = add(s, "VIEWPORT", k);
        for (int i = 0; i < 4; i++) viewport[i] = (double)box[i];
        GLint scissor[4] = {0};
        gl.GetIntegeri_v(STATE_SCISSOR_BOX, (GLuint)k, scissor);
        double *value = add(s, "SCISSOR_BOX", k);
        for (int i = 0; i < 4; i++) value[i] = scissor[i];
        gl.GetDoublei_v(STATE_DEPTH_RANGE, (GLuint)k, add(s, "DEPTH_RANGE", k));
        add(s, "SCISSOR_TEST", k)[0] = gl.IsEnabledi(GL_SCISSOR_TEST, (GLuint)k);
    }
    for (int k = 0; k < limit(STATE_MAX_DRAW_BUFFERS); k++) {
        GLboolean mask[4] = {0};
        gl.GetBooleani_v(STATE_COLOR_WRITEMASK, (GLuint)k, mask);
        double *value = add(s, "COLOR_WRITEMASK", k);
        for (int i = 0; i < 4; i++) value[i] = mask[i];
        add(s, "BLEND", k)[0] = gl.IsEnabledi(GL_BLEND, (GLuint)k);
        for (int i = 0; i < LENGTH(draw_buffer_parts); i++) {
            add(s, draw_buffer_parts[i].name, k)[0] =
                indexed_integer(draw_buffer_parts[i].value, k);
        }
        // Of the framebuffer that is bound.
        add(s, "DRAW_BUFFER", k)[0] = limit(STATE_DRAW_BUFFER0 + (GLenum)k);
    }
    add(s, "READ_BUFFER", -1)[0] = limit(STATE_READ_BUFFER);
    for (int k = 0; k < limit(STATE_MAX_SAMPLE_MASK_WORDS); k++) {
        add(s, "SAMPLE_MASK_VALUE", k)[0] = indexed_integer(STATE_SAMPLE_MASK_VALUE, k);
    }
}

void gl_state_take(gl_state *s)
{
    s->count = 0;
    for (int i = 0; i < LENGTH(numbers); i++) {
        GLdouble value[16] = {0};
        gl.GetDoublev(numbers[i].value, value);
        memcpy(add(s, numbers[i].name, -1), value, (size_t)numbers[i].count * sizeof *value);
    }
    for (int i = 0; i < switch_count(); i++) {
        add(s, switches[i].name, -1)[0] = gl.IsEnabled(switches[i].value);
    }
    for (int i = 0; i < LENGTH(query_targets); i++) {
        GLint query = 0;
        gl.GetQueryiv(query_targets[i].value, STATE_CURRENT_QUERY, &query);
        add(s, query_targets[i].name, -1)[0] = query;
    }
    take_units(s);
    take_buffers(s);
    take_targets(s);
}

void gl_state_free(gl_state *s)
{
    free(s->entry);
    memset(s, 0, sizeof *s);
}

// ---- Comparing -----------------------------------------------------------------------------------

static bool is_allowed(const char *name, const char *allowed)
{
    char word[64];
    for (const char *at = allowed; at && *at; at += strcspn(at, " ") + 1) {
        snprintf(word, sizeof word, "%.*s", (int)strcspn(at, " "), at);
        const size_t length = strlen(word);
        if (!strncmp(word, name, length) && strchr("[", name[length])) return true;
        if (!strchr(at, ' ')) break;
    }
    return false;
}

int gl_state_differences(const gl_state *before, const gl_state *after, const char *allowed,
                         char *text, int size)
{
    int found = 0, used = 0;
    if (size > 0) text[0] = '\0';
    for (int i = 0; i < before->count && i < after->count; i++) {
        const gl_state_entry *a = &before->entry[i], *b = &after->entry[i];
        if (!memcmp(a->value, b->value, sizeof a->value) || is_allowed(a->name, allowed)) continue;
        if (found++ < 8 && used < size) {
            used += snprintf(text + used, (size_t)(size - used), "%s%s %g %g %g %g -> %g %g %g %g",
                             found > 1 ? "; " : "", a->name, a->value[0], a->value[1], a->value[2],
                             a->value[3], b->value[0], b->value[1], b->value[2], b->value[3]);
        }
    }
    return found + abs(before->count - after->count);
}

const gl_state_entry *gl_state_find(const gl_state *s, const char *name)
{
    for (int i = 0; i < s->count; i++) {
        if (!strcmp(s->entry[i].name, name)) return &s->entry[i];
    }
    return NULL;
}

// ---- A caller from hell ----------------------------------------------------------------------------

// A switch's unusual value: on where it is off in a new context. Debug output stays for the tests.
// Not transform feedback: while it runs, GL itself forbids to change programs.
static void turn_switches(bool unusual)
{
    for (int i = 0; i < switch_count(); i++) {
        const GLenum name = switches[i].value;
        const bool usual = name == GL_MULTISAMPLE || name == GL_DITHER;
        if (!strncmp(switches[i].name, "DEBUG", 5)) continue;
        (usual != unusual ? gl.Enable : gl.Disable)(name);
    }
}

static GLuint make_program(void)
{
    static const char *const text[2] = {
        "#version 450 core\nvoid main() { gl_Position = vec4(0); }\n",
        "#version 450 core\nvoid main() {}\n"};
    const GLuint program = gl.CreateProgram();
    for (int i = 0; i < 2; i++) {
        const GLuint shader = gl.CreateShader(i ? GL_FRAGMENT_SHADER : GL_VERTEX_SHADER);
        gl.ShaderSource(shader, 1, &text[i], NULL);
        gl.CompileShader(shader);
        gl.AttachShader(program, shader);
        gl.DeleteShader(shader);
    }
    gl.LinkProgram(program);
    return program;
}

static void make_objects(gl_unusual *u)
{
    static const GLenum targets[6] = {
        GL_TEXTURE_2D, GL_TEXTURE_2D_ARRAY,       GL_TEXTURE_CUBE_MAP,
        GL_TEXTURE_3D, GL_TEXTURE_2D_MULTISAMPLE, GL_TEXTURE_2D_MULTISAMPLE_ARRAY};
    for (int i = 0; i < 6; i++) gl.CreateTextures(targets[i], 1, &u->textures[i]);
    gl.TextureStorage2D(u->textures[0], 2, GL_RGBA8, 8, 8);
    gl.TextureStorage3D(u->textures[1], 2, GL_RGBA8, 8, 8, 3);
    gl.TextureStorage2D(u->textures[2], 1, GL_RGBA8, 8, 8);
    gl.TextureStorage3D(u->textures[3], 1, GL_RGBA8, 8, 8, 3);
    gl.TextureStorage2DMultisample(u->textures[4], 4, GL_RGBA8, 8, 8, GL_TRUE);
    gl.TextureStorage3DMultisample(u->textures[5], 4, GL_RGBA8, 8, 8, 3, GL_TRUE);
    gl.CreateSamplers(2, u->samplers);
    gl.SamplerParameteri(u->samplers[0], GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    gl.SamplerParameteri(u->samplers[0], GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl.CreateBuffers(2, u->buffers);
    for (int i = 0; i < 2; i++) gl.NamedBufferStorage(u->buffers[i], 4096, NULL, 0);
    gl.CreateVertexArrays(2, u->arrays);
    gl.VertexArrayElementBuffer(u->arrays[0], u->buffers[0]);
    gl.CreateFramebuffers(2, u->framebuffers);
    gl.NamedFramebufferTexture(u->framebuffers[0], GL_COLOR_ATTACHMENT0, u->textures[0], 0);
    gl.NamedFramebufferTexture(u->framebuffers[1], GL_COLOR_ATTACHMENT0, u->textures[0], 1);
    gl.CreateRenderbuffers(1, &u->renderbuffer);
    gl.CreateProgramPipelines(1, &u->pipeline);
    gl.CreateTransformFeedbacks(1, &u->feedback);
    gl.CreateQueries(GL_ANY_SAMPLES_PASSED, 1, &u->query);
    u->program = make_program();
}

// A query that some samples passed, so that conditional rendering draws.
static void make_query_pass(const gl_unusual *u)
{
    static const char *const text[2] = {
        "#version 450 core\nvoid main() { vec2 p = vec2(gl_VertexID % 2, gl_VertexID / 2);"
        " gl_Position = vec4(4.0 * p - 1.0, 0, 1); }\n",
        "#version 450 core\nlayout(location = 0) out vec4 c; void main() { c = vec4(1); }\n"};
    const GLuint program = gl.CreateProgram();
    for (int i = 0; i < 2; i++) {
        const GLuint shader = gl.CreateShader(i ? GL_FRAGMENT_SHADER : GL_VERTEX_SHADER);
        gl.ShaderSource(shader, 1, &text[i], NULL);
        gl.CompileShader(shader);
        gl.AttachShader(program, shader);
        gl.DeleteShader(shader);
    }
    gl.LinkProgram(program);
    gl.UseProgram(program);
    gl.BindVertexArray(u->arrays[1]);
    gl.BindFramebuffer(GL_FRAMEBUFFER, u->framebuffers[0]);
    gl.Viewport(0, 0, 8, 8);
    gl.BeginQuery(GL_ANY_SAMPLES_PASSED, u->query);
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
    gl.EndQuery(GL_ANY_SAMPLES_PASSED);
    gl.UseProgram(0);
    gl.DeleteProgram(program);
}

static void bind_everything(const gl_unusual *u)
{
    static const GLenum generic[] = {
        GL_ARRAY_BUFFER,          GL_PIXEL_PACK_BUFFER,         GL_PIXEL_UNPACK_BUFFER,
        GL_TEXTURE_BUFFER,        GL_TRANSFORM_FEEDBACK_BUFFER, GL_UNIFORM_BUFFER,
        GL_SHADER_STORAGE_BUFFER, GL_ATOMIC_COUNTER_BUFFER,     GL_COPY_READ_BUFFER,
        GL_COPY_WRITE_BUFFER,     GL_DRAW_INDIRECT_BUFFER,      GL_DISPATCH_INDIRECT_BUFFER,
        GL_QUERY_BUFFER};
    gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, u->framebuffers[0]);
    gl.BindFramebuffer(GL_READ_FRAMEBUFFER, u->framebuffers[1]);
    gl.BindRenderbuffer(GL_RENDERBUFFER, u->renderbuffer);
    gl.BindVertexArray(u->arrays[0]);
    gl.BindProgramPipeline(u->pipeline);
    gl.BindTransformFeedback(GL_TRANSFORM_FEEDBACK, u->feedback);
    gl.UseProgram(u->program);
    for (GLuint unit = 0; unit < 24; unit++) {
        for (int i = 0; i < 6; i++) gl.BindTextureUnit(unit, u->textures[i]);
        gl.BindSampler(unit, u->samplers[0]);
    }
    for (GLuint unit = 0; unit < 8; unit++) {
        gl.BindImageTexture(unit, u->textures[1], 1, unit % 2, 2, GL_READ_WRITE, GL_RGBA8);
    }
    for (int i = 0; i < 4; i++) {
        const GLenum target = i == 0   ? GL_UNIFORM_BUFFER
                              : i == 1 ? GL_SHADER_STORAGE_BUFFER
                              : i == 2 ? GL_ATOMIC_COUNTER_BUFFER
                                       : GL_TRANSFORM_FEEDBACK_BUFFER;
        const int count = limit(indexed_buffers[i].count);
        for (int k = 0; k < count && k < 16; k++) {
            gl.BindBufferRange(target, (GLuint)k, u->buffers[0], 256 * (k % 4), 256);
        }
    }
    for (int i = 0; i < LENGTH(generic); i++) gl.BindBuffer(generic[i], u->buffers[1]);
    gl.ActiveTexture(GL_TEXTURE0 + 3);
}

// Numbers that are not the usual ones; usual restores those of a new context. stencil: all bits of
// a stencil mask, of which drivers keep as many as they like.
static void set_numbers(bool usual, const gl_unusual *u)
{
    static const GLenum pack[] = {
        GL_PACK_ROW_LENGTH,    GL_PACK_SKIP_ROWS,     GL_PACK_SKIP_PIXELS, GL_PACK_SKIP_IMAGES,
        GL_PACK_IMAGE_HEIGHT,  GL_UNPACK_ROW_LENGTH,  GL_UNPACK_SKIP_ROWS, GL_UNPACK_SKIP_PIXELS,
        GL_UNPACK_SKIP_IMAGES, GL_UNPACK_IMAGE_HEIGHT};
    for (int i = 0; i < LENGTH(pack); i++) gl.PixelStorei(pack[i], usual ? 0 : 3 + i);
    gl.PixelStorei(GL_PACK_SWAP_BYTES, !usual);
    gl.PixelStorei(GL_UNPACK_SWAP_BYTES, !usual);
    gl.PixelStorei(GL_PACK_ALIGNMENT, usual ? 4 : 8);
    gl.PixelStorei(GL_UNPACK_ALIGNMENT, usual ? 4 : 2);
    gl.ClipControl(usual ? GL_LOWER_LEFT : GL_UPPER_LEFT,
                   usual ? GL_NEGATIVE_ONE_TO_ONE : GL_ZERO_TO_ONE);
    gl.DepthFunc(usual ? GL_LESS : GL_GREATER);
    gl.DepthMask(usual);
    gl.ClearDepth(usual ? 1 : 0);
    gl.DepthRange(usual ? 0 : 1, usual ? 1 : 0);
    gl.ClearColor(usual ? 0 : 0.25f, usual ? 0 : 0.5f, 0, 0);
    gl.StencilFunc(usual ? GL_ALWAYS : GL_NEVER, usual ? 0 : 1,
                   usual ? u->stencil : 0x7Fu); // never
    gl.StencilOp(usual ? GL_KEEP : GL_REPLACE, GL_KEEP, GL_KEEP);
    gl.StencilMask(usual ? u->stencil : 0x3Fu);
    gl.CullFace(usual ? GL_BACK : GL_FRONT_AND_BACK); // both
    gl.PolygonMode(GL_FRONT_AND_BACK, usual ? GL_FILL : GL_LINE);
    if (!usual && compatible()) gl.PolygonMode(GL_BACK, GL_POINT);
    gl.PolygonOffset(usual ? 0 : 3, usual ? 0 : 500);
    gl.LineWidth(1);
    gl.PointSize(usual ? 1 : 2);
    gl.ProvokingVertex(usual ? GL_LAST_VERTEX_CONVENTION : GL_FIRST_VERTEX_CONVENTION);
    gl.PrimitiveRestartIndex(usual ? 0 : 1);
    gl.LogicOp(usual ? GL_COPY : GL_INVERT);
    gl.BlendFunc(usual ? GL_ONE : GL_SRC_ALPHA, usual ? GL_ZERO : GL_ONE_MINUS_SRC_ALPHA);
    gl.SampleCoverage(usual ? 1 : 0.25f, !usual);
    gl.SampleMaski(0, usual ? ~0u : 2u);
    gl.MinSampleShading(usual ? 0 : 0.5f);
    gl.ColorMask(GL_TRUE, usual, GL_TRUE, usual);
    gl.ColorMaski(1, usual, GL_TRUE, usual, GL_TRUE);
    // Arrays last: the functions without an index set all of them.
    gl.Viewport(0, 0, usual ? u->viewport[2] : 5, usual ? u->viewport[3] : 3);
    gl.Scissor(0, 0, usual ? u->scissor[2] : 2, usual ? u->scissor[3] : 2);
    if (usual) return;
    gl.ViewportIndexedf(0, 1.5f, -0.25f, 3.5f, 2.25f);
    gl.ViewportIndexedf(2, 4, 4, 8, 8);
    gl.ScissorIndexed(1, 1, 1, 3, 3);
    gl.DepthRangeIndexed(0, 0.1234567890123, 0.9876543210987); // more digits than a float has
    gl.DepthRangeIndexed(1, 0.25, 0.75);
    gl.Disablei(GL_SCISSOR_TEST, 3);
    gl.Disablei(GL_BLEND, 1);
}

void gl_state_make_unusual(gl_unusual *u)
{
    memset(u, 0, sizeof *u);
    gl.GetIntegerv(GL_VIEWPORT, u->viewport);
    gl.GetIntegerv(STATE_SCISSOR_BOX, u->scissor);
    make_objects(u);
    make_query_pass(u);
    bind_everything(u);
    u->stencil = (GLuint)limit(GL_STENCIL_WRITEMASK);
    set_numbers(false, u);
    turn_switches(true);
    gl.BeginConditionalRender(u->query, GL_QUERY_WAIT); // wait for the result
}

static void unbind_everything(void)
{
    static const GLenum generic[] = {
        GL_ARRAY_BUFFER,          GL_PIXEL_PACK_BUFFER,         GL_PIXEL_UNPACK_BUFFER,
        GL_TEXTURE_BUFFER,        GL_TRANSFORM_FEEDBACK_BUFFER, GL_UNIFORM_BUFFER,
        GL_SHADER_STORAGE_BUFFER, GL_ATOMIC_COUNTER_BUFFER,     GL_COPY_READ_BUFFER,
        GL_COPY_WRITE_BUFFER,     GL_DRAW_INDIRECT_BUFFER,      GL_DISPATCH_INDIRECT_BUFFER,
        GL_QUERY_BUFFER};
    gl.UseProgram(0);
    gl.BindProgramPipeline(0);
    gl.BindTransformFeedback(GL_TRANSFORM_FEEDBACK, 0);
    gl.BindVertexArray(0);
    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl.BindRenderbuffer(GL_RENDERBUFFER, 0);
    for (GLuint unit = 0; unit < 24; unit++) {
        gl.BindTextureUnit(unit, 0);
        gl.BindSampler(unit, 0);
    }
    for (GLuint unit = 0; unit < 8; unit++) {
        gl.BindImageTexture(unit, 0, 0, GL_FALSE, 0, GL_READ_ONLY, GL_R8);
    }
    for (int i = 0; i < LENGTH(generic); i++) gl.BindBuffer(generic[i], 0);
    gl.ActiveTexture(GL_TEXTURE0);
}

void gl_state_make_usual(gl_unusual *u)
{
    gl.EndConditionalRender();
    turn_switches(false);
    set_numbers(true, u);
    unbind_everything();
    gl.DeleteTextures(6, u->textures);
    gl.DeleteSamplers(2, u->samplers);
    gl.DeleteBuffers(2, u->buffers); // takes them off the indexed bindings, too
    gl.DeleteVertexArrays(2, u->arrays);
    gl.DeleteFramebuffers(2, u->framebuffers);
    gl.DeleteRenderbuffers(1, &u->renderbuffer);
    gl.DeleteProgramPipelines(1, &u->pipeline);
    gl.DeleteTransformFeedbacks(1, &u->feedback);
    gl.DeleteQueries(1, &u->query);
    gl.DeleteProgram(u->program);
    memset(u, 0, sizeof *u);
}
