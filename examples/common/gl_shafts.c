#include "gl_shafts.h"

#include <stdio.h>
#include <stdlib.h>

// clang-format off
static const char view_text[] =
    "layout(std430, binding = 8) readonly buffer View { mssm_scattering view; };\n";

// A work group a row, 64 columns at a time: each thread fills a texel, then all add up what is
// before it.
static const char fill_text[] =
    "layout(local_size_x = 64) in;\n"
    "layout(binding = 8) uniform sampler2DArray map;\n"
    "layout(binding = 0, rgba16) writeonly uniform image2D low_image;\n"
    "layout(binding = 1, rg16) writeonly uniform image2D high_image;\n"
    "shared vec3 low[64], high[64];\n"
    "mssm_moments6 resample(mssm_epipolar row, float step, float left, float r, float right)\n"
    "{\n"
    "    vec2 across = vec2(row.x, row.y);\n"
    "    float width = length(across) * max(right - left, r * step);\n"
    "    float level = log2(max(0.5 * width * float(textureSize(map, 0).x), 1.0));\n"
    "    vec2 at = 0.5 + 0.5 * (vec2(view.eye[0], view.eye[1]) + across * r);\n"
    "    vec4 t = textureLod(map, vec3(at, 0.0), level);\n"
    "    mssm_moments4 q;\n"
    "    for (int k = 0; k < 4; k++) q.b[k] = t[k];\n"
    "    q = mssm_moments4_decode(q);\n"
    "    return mssm_moments6_encode(mssm_scattering_moments(view, r, q.b[0], q.b[1], q.b[2]));\n"
    "}\n"
    "void main()\n"
    "{\n"
    "    int thread = int(gl_LocalInvocationID.x), index = int(gl_WorkGroupID.x);\n"
    "    ivec2 size = imageSize(low_image);\n"
    "    float step = view.azimuth[1] / float(size.y);\n"
    "    mssm_epipolar row = mssm_scattering_row(view, view.azimuth[0] + step * (float(index) + 0.5));\n"
    "    vec3 low_before = vec3(0.0), high_before = vec3(0.0);\n"
    "    for (int i = thread; i < size.x; i += 64) {\n"
    "        float left = mssm_scattering_distance(row, float(i) / float(size.x));\n"
    "        float r = mssm_scattering_distance(row, (float(i) + 0.5) / float(size.x));\n"
    "        float right = mssm_scattering_distance(row, (float(i) + 1.0) / float(size.x));\n"
    "        mssm_moments6 q = resample(row, step, left, r, right);\n"
    "        vec3 low_sum = vec3(q.b[0], q.b[1], q.b[2]), high_sum = vec3(q.b[3], q.b[4], q.b[5]);\n"
    "        for (int reach = 1; reach < 64; reach *= 2) {\n"
    "            low[thread] = low_sum;\n"
    "            high[thread] = high_sum;\n"
    "            barrier();\n"
    "            if (thread >= reach) {\n"
    "                low_sum += low[thread - reach];\n"
    "                high_sum += high[thread - reach];\n"
    "            }\n"
    "            barrier();\n"
    "        }\n"
    "        low[thread] = low_sum;\n"
    "        high[thread] = high_sum;\n"
    "        barrier();\n"
    "        low_sum = (low_before + low_sum) / float(i + 1);\n"
    "        high_sum = (high_before + high_sum) / float(i + 1);\n"
    "        low_before += low[63];\n"
    "        high_before += high[63];\n"
    "        barrier();\n"
    "        imageStore(low_image, ivec2(i, index), vec4(low_sum, high_sum.x));\n"
    "        imageStore(high_image, ivec2(i, index), vec4(high_sum.yz, 0.0, 0.0));\n"
    "    }\n"
    "}\n";

static const char medium_text[] = "uniform vec3 eye, medium;\n"; // medium: extinction, where it ends

// Texels hold means up to their right edges.
static const char lookup_text[] =
    "layout(binding = 8) uniform sampler2D shafts_low;\n"
    "layout(binding = 9) uniform sampler2D shafts_high;\n"
    "float shafts_visibility(vec3 d, float distance)\n"
    "{\n"
    "    mssm_view_ray ray = mssm_scattering_ray(view, d.x, d.y, d.z, distance);\n"
    "    vec2 at = vec2(ray.column - 0.5 / float(textureSize(shafts_low, 0).x), ray.row);\n"
    "    vec4 low = textureLod(shafts_low, at, 0.0);\n"
    "    vec2 high = textureLod(shafts_high, at, 0.0).xy;\n"
    "    mssm_moments6 q;\n"
    "    for (int k = 0; k < 6; k++) q.b[k] = k < 4 ? low[k] : high[k - 4];\n"
    "    q = mssm_moments6_bias_encoded(mssm_moments6_decode(q), BIAS);\n"
    "    return mssm_scattering_visibility(ray, q);\n"
    "}\n";

const char gl_shafts_marched[] =
    "uniform mat4 world_to_shadow;\n"
    "uniform int steps;\n"
    "layout(binding = 8) uniform sampler2D depth_map;\n"
    "float shafts_visibility(vec3 d, float distance)\n"
    "{\n"
    "    vec3 from = (world_to_shadow * vec4(eye, 1)).xyz, along = mat3(world_to_shadow) * d;\n"
    "    float all = 1 - exp(-medium.x * distance), lit = 0;\n"
    "    ivec2 size = textureSize(depth_map, 0);\n"
    "    for (int i = 0; i < steps; i++) {\n"
    "        vec3 p = 0.5 + 0.5 * (from - log(1 - (i + 0.5) / steps * all) / medium.x * along);\n"
    "        ivec2 at = ivec2(floor(p.xy * size));\n"
    "        bool outside = any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, size));\n"
    "        lit += outside || texelFetch(depth_map, at, 0).x >= min(p.z, 0.95) ? 1 : 0;\n"
    "    }\n"
    "    return lit / steps;\n"
    "}\n";

static const char pass_text[] =
    "layout(binding = 10) uniform sampler2D positions;\n"
    "uniform vec3 scattered;\n"
    "in vec3 ray;\n"
    "out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    vec4 p = texelFetch(positions, ivec2(gl_FragCoord.xy), 0);\n"
    "    float distance = p.w > 0.0 ? min(length(p.xyz - eye), medium.y) : medium.y;\n"
    "    float kept = exp(-medium.x * distance);\n"
    "    color = vec4(scattered * ((1.0 - kept) * shafts_visibility(normalize(ray), distance)), kept);\n"
    "}\n";
// clang-format on

static GLuint fill_program(message *why)
{
    const char *const text[] = {"#version 450 core\n", mssm_glsl_math(), mssm_glsl_scattering(),
                                view_text, fill_text};
    const GLuint shader = gl.CreateShader(GL_COMPUTE_SHADER), program = gl.CreateProgram();
    char log[1000] = "";
    GLint good = 0;
    gl.ShaderSource(shader, 5, text, NULL);
    gl.CompileShader(shader);
    gl.GetShaderInfoLog(shader, sizeof log, NULL, log);
    gl.AttachShader(program, shader);
    gl.DeleteShader(shader);
    gl.LinkProgram(program);
    gl.GetProgramiv(program, GL_LINK_STATUS, &good);
    if (good) return program;
    gl.DeleteProgram(program);
    fail(why, "the driver refuses the shader of light shafts: %.200s", log);
    return 0;
}

bool gl_shafts_create(gl_shafts *s, int rows, int columns, message *why)
{
    static const GLenum format[2] = {GL_RGBA16, GL_RG16};
    *s = (gl_shafts){.rows = rows, .columns = columns};
    s->fill = fill_program(why);
    if (!s->fill) return false;
    gl.CreateTextures(GL_TEXTURE_2D, 2, s->texture);
    for (int i = 0; i < 2; i++) {
        gl.TextureStorage2D(s->texture[i], 1, format[i], columns, rows);
        gl.TextureParameteri(s->texture[i], GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        gl.TextureParameteri(s->texture[i], GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    }
    gl.CreateBuffers(1, &s->view);
    gl.NamedBufferStorage(s->view, sizeof(mssm_scattering), NULL, GL_DYNAMIC_STORAGE_BIT);
    return true;
}

void gl_shafts_free(gl_shafts *s)
{
    if (s->fill) gl.DeleteProgram(s->fill);
    if (s->view) gl.DeleteBuffers(1, &s->view);
    gl.DeleteTextures(2, s->texture);
    *s = (gl_shafts){.rows = 0};
}

void gl_shafts_update(gl_shafts *s, const mssm_scattering *from, GLuint map)
{
    static const GLenum format[2] = {GL_RGBA16, GL_RG16};
    const GLint wrap = from->azimuth[1] > 6.28f ? GL_REPEAT : GL_CLAMP_TO_EDGE;
    gl.NamedBufferSubData(s->view, 0, sizeof *from, from);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, GL_SHAFTS_BINDING, s->view);
    gl.BindTextureUnit(GL_SHAFTS_TEXTURE, map);
    for (GLuint i = 0; i < 2; i++) {
        gl.TextureParameteri(s->texture[i], GL_TEXTURE_WRAP_T, wrap);
        gl.BindImageTexture(i, s->texture[i], 0, GL_FALSE, 0, GL_WRITE_ONLY, format[i]);
    }
    gl.UseProgram(s->fill);
    gl.DispatchCompute((GLuint)s->rows, 1, 1);
    gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    for (GLuint i = 0; i < 2; i++) gl.BindTextureUnit(GL_SHAFTS_TEXTURE + i, s->texture[i]);
}

GLuint gl_shafts_program(const char *name, const char *visibility, message *why)
{
    char bias[40];
    snprintf(bias, sizeof bias, "#define BIAS %.9g\n", (double)MSSM_BIAS6_UNORM16);
    const char *const vertices[] = {gl_triangle_vertex, NULL};
    const char *const own[] = {mssm_glsl_math(),
                               mssm_glsl_scattering(),
                               bias,
                               view_text,
                               medium_text,
                               lookup_text,
                               pass_text,
                               NULL};
    const char *const others[] = {medium_text, visibility, pass_text, NULL};
    return gl_program(name, vertices, visibility ? others : own, why);
}

void gl_shafts_draw(GLuint program, GLuint positions, const camera *eye, float extinction,
                    float far_end, vec3 scattered)
{
    const float medium[3] = {extinction, far_end, 0};
    gl_mesh all;
    gl_mesh_triangle(&all);
    gl_camera_uniforms(eye, program);
    gl.ProgramUniform3fv(program, gl.GetUniformLocation(program, "eye"), 1, &eye->position.x);
    gl.ProgramUniform3fv(program, gl.GetUniformLocation(program, "scattered"), 1, &scattered.x);
    gl.ProgramUniform3fv(program, gl.GetUniformLocation(program, "medium"), 1, medium);
    gl.BindTextureUnit(GL_SHAFTS_TEXTURE + 2, positions);
    gl.UseProgram(program);
    gl.Enable(GL_BLEND);
    gl.BlendFunc(GL_ONE, GL_SRC_ALPHA);
    gl_mesh_draw(&all);
    gl.Disable(GL_BLEND);
    gl_mesh_free(&all);
}
