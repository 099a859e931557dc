#include "gl_range.h"

#include <stdlib.h>

// clang-format off
// A work group a row, and no atomics: there is nothing to be reset, and the CPU goes over the rows.
static const char reduce_text[] =
    "#version 450 core\n"
    "layout(local_size_x = 64) in;\n"
    "layout(binding = 0) uniform sampler2DMSArray depth;\n"
    "layout(std430, binding = 0) writeonly buffer Rows { vec2 rows[]; };\n"
    "layout(location = 0) uniform int first;\n"
    "layout(location = 1) uniform int layer;\n"
    "shared vec2 part[64];\n"
    "void main()\n"
    "{\n"
    "    int thread = int(gl_LocalInvocationID.x), row = int(gl_WorkGroupID.x);\n"
    "    int samples = textureSamples(depth), side = textureSize(depth).x;\n"
    "    vec2 range = vec2(2, -1);\n" // nothing drawn
    "    for (int x = thread; x < side; x += 64) {\n"
    "        for (int s = 0; s < samples; s++) {\n"
    "            float d = texelFetch(depth, ivec3(x, row, layer), s).r;\n"
    "            if (d < 1) range = vec2(min(range.x, d), max(range.y, d));\n"
    "        }\n"
    "    }\n"
    "    part[thread] = range;\n"
    "    for (int step = 32; step > 0; step /= 2) {\n"
    "        barrier();\n"
    "        if (thread < step) {\n"
    "            vec2 other = part[thread + step];\n"
    "            part[thread] = vec2(min(part[thread].x, other.x), max(part[thread].y, other.y));\n"
    "        }\n"
    "    }\n"
    "    if (thread == 0) rows[first + row] = part[0];\n"
    "}\n";
// clang-format on

bool gl_range_create(gl_range *r, int lights, int side, message *why)
{
    const char *const text = reduce_text;
    const GLsizeiptr rows = (GLsizeiptr)lights * side;
    GLint good = 0;
    *r = (gl_range){.side = side};
    r->drawn = calloc((size_t)lights, sizeof *r->drawn);
    r->rows = malloc((size_t)side * sizeof *r->rows);
    if (!r->drawn || !r->rows) return fail(why, "no memory for %d lights", lights);
    gl.CreateBuffers(1, &r->buffer);
    gl.NamedBufferStorage(r->buffer, rows * (GLsizeiptr)sizeof *r->rows, NULL, 0);
    const GLuint shader = gl.CreateShader(GL_COMPUTE_SHADER);
    r->program = gl.CreateProgram();
    gl.ShaderSource(shader, 1, &text, NULL);
    gl.CompileShader(shader);
    gl.AttachShader(r->program, shader);
    gl.DeleteShader(shader);
    gl.LinkProgram(r->program);
    gl.GetProgramiv(r->program, GL_LINK_STATUS, &good);
    return good || fail(why, "the driver refuses the shader of depth ranges");
}

void gl_range_free(gl_range *r)
{
    if (r->buffer) gl.DeleteBuffers(1, &r->buffer);
    if (r->program) gl.DeleteProgram(r->program);
    free(r->drawn);
    free(r->rows);
    *r = (gl_range){.side = 0};
}

void gl_range_reduce(gl_range *r, int index, const mssm_gl *maps)
{
    GLint framebuffer = 0, depth = 0;
    gl.GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &framebuffer);
    gl.GetNamedFramebufferAttachmentParameteriv((GLuint)framebuffer, GL_DEPTH_ATTACHMENT,
                                                GL_FRAMEBUFFER_ATTACHMENT_OBJECT_NAME, &depth);
    gl.BindTextureUnit(0, (GLuint)depth);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, r->buffer);
    gl.ProgramUniform1i(r->program, 0, index * r->side);
    gl.ProgramUniform1i(r->program, 1, mssm_gl_layer(maps));
    gl.UseProgram(r->program);
    gl.DispatchCompute((GLuint)r->side, 1, 1);
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
}

// From window depth in the map of one frustum to depth in that of another over the same rays.
static float depth_in(const mssm_light *to, const mssm_light *drawn, float window)
{
    const float z = 2 * window - 1;
    if (!to->perspective) {
        const float range = (drawn->z_far - drawn->z_near) / (to->z_far - to->z_near);
        return to->world_to_shadow[14] + (z - drawn->world_to_shadow[14]) * range;
    }
    const float n = drawn->z_near, f = drawn->z_far;
    const float distance = 2 * f * n / (f + n - z * (f - n));
    return -1 + 2 * (distance - to->z_near) / (to->z_far - to->z_near);
}

mssm_light gl_range_fit(gl_range *r, int index, const mssm_light *whole)
{
    const GLsizeiptr bytes = r->side * (GLsizeiptr)sizeof *r->rows;
    const mssm_light drawn = r->drawn[index];
    float low = 2, high = -1;
    mssm_light fitted = *whole;
    if (drawn.z_far > drawn.z_near) {
        gl.GetNamedBufferSubData(r->buffer, index * bytes, bytes, r->rows);
        for (int y = 0; y < r->side; y++) {
            low = fminf(low, r->rows[y][0]);
            high = fmaxf(high, r->rows[y][1]);
        }
    }
    // Where casters have come close to the planes that cut them off, others may be beyond.
    if (high >= low &&
        (drawn.z_near == whole->z_near && drawn.z_far == whole->z_far
             ? true
             : depth_in(&drawn, &drawn, low) > -0.95f && depth_in(&drawn, &drawn, high) < 0.95f)) {
        const float a = depth_in(whole, &drawn, low), b = depth_in(whole, &drawn, high);
        const float margin = GL_RANGE_MARGIN * (b - a);
        mssm_light_fit(&fitted, fmaxf(a - margin, -1), fminf(fmaxf(b + margin, -1), 1));
    }
    r->drawn[index] = fitted;
    return fitted;
}
