#include "gl_sampled.h"

// clang-format off
static const char add_text[] =
    "layout(binding = 0) uniform sampler2D positions;\n"
    "layout(binding = 1) uniform sampler2D normals;\n"
    "layout(binding = 2) uniform sampler2D depth;\n"
    "layout(location = 8) uniform mat4 world_to_shadow;\n"
    "uniform float offset;\n"
    "out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    vec4 at = texelFetch(positions, ivec2(gl_FragCoord.xy), 0);\n"
    "    vec3 n = texelFetch(normals, ivec2(gl_FragCoord.xy), 0).xyz;\n"
    "    vec4 p = world_to_shadow * vec4(at.xyz + offset * n, 1);\n"
    "    vec3 q = 0.5 * p.xyz / p.w + 0.5;\n"
    "    float lit = 1;\n"
    "    if (p.w > 0 && all(greaterThan(q, vec3(0))) && all(lessThan(q.xy, vec2(1)))) {\n"
    "        ivec2 texel = ivec2(q.xy * textureSize(depth, 0));\n"
    "        lit = texelFetch(depth, texel, 0).r < min(q.z, 1) ? 0 : 1;\n"
    "    }\n"
    "    color = vec4(lit, 0, 0, 1);\n"
    "}\n";
// clang-format on

// Squared distance as if copies of the light lay on all sides, so that its rim is not favoured.
static float distance_of(const float p[2], const float q[2])
{
    const float x = fabsf(p[0] - q[0]), y = fabsf(p[1] - q[1]);
    const float u = x < 2 - x ? x : 2 - x, v = y < 2 - y ? y : 2 - y;
    return u * u + v * v;
}

// Points by cells of the light, as lists: one too near to a candidate is found at once.
enum { CELLS = 16 };
typedef struct cells {
    int first[CELLS][CELLS], next[GL_SAMPLED_POINTS]; // numbers of points, from 1 on
} cells;

static int cell_of(float x)
{
    const int cell = (int)((x + 1) * (CELLS / 2));
    return cell < CELLS ? cell : CELLS - 1;
}

static bool is_near(const cells *c, float point[GL_SAMPLED_POINTS][2], const float p[2], float most)
{
    const int x = cell_of(p[0]) + CELLS, y = cell_of(p[1]) + CELLS;
    for (int k = 0; k < 9; k++) {
        int i = c->first[(y + k / 3 - 1) % CELLS][(x + k % 3 - 1) % CELLS];
        for (; i > 0; i = c->next[i - 1]) {
            if (distance_of(p, point[i - 1]) <= most) return true;
        }
    }
    return false;
}

// A sequence every start of which is spread like a Poisson disc: of many random points the next is
// always the one furthest from all before (Mitchell 1991). The middle comes first.
static void spread(float point[GL_SAMPLED_POINTS][2])
{
    cells c = {{{0}}, {0}};
    unsigned random = 1;
    for (int i = 0; i < GL_SAMPLED_POINTS; i++) {
        float best = -1;
        point[i][0] = point[i][1] = 0;
        for (int candidate = 0; candidate < 2 * i + 8 && i > 0; candidate++) {
            float p[2], nearest = 8;
            for (int k = 0; k < 2; k++) {
                random = random * 1664525u + 1013904223u;
                p[k] = (float)(random >> 8) / 8388608.0f - 1;
            }
            if (is_near(&c, point, p, best)) continue;
            for (int j = 0; j < i && nearest > best; j++) {
                const float d = distance_of(p, point[j]);
                nearest = d < nearest ? d : nearest;
            }
            if (nearest <= best) continue;
            best = nearest;
            point[i][0] = p[0], point[i][1] = p[1];
        }
        int *first = &c.first[cell_of(point[i][1])][cell_of(point[i][0])];
        c.next[i] = *first;
        *first = i + 1;
    }
}

bool gl_sampled_create(gl_sampled *s, int map_side, int width, int height, message *why)
{
    const GLenum none[GL_TARGET_COLORS] = {0}, sum[GL_TARGET_COLORS] = {GL_RGBA32F};
    *s = (gl_sampled){.samples = 0};
    spread(s->point);
    gl_mesh_triangle(&s->triangle);
    return (s->depth_program = gl_program_simple("sample", gl_depth_vertex, NULL, why)) &&
           (s->add_program = gl_program_simple("add", gl_triangle_vertex, add_text, why)) &&
           gl_target_create(&s->map, map_side, map_side, 1, none, why) &&
           gl_target_create(&s->sum, width, height, 1, sum, why);
}

void gl_sampled_free(gl_sampled *s)
{
    gl_target_free(&s->map);
    gl_target_free(&s->sum);
    gl_mesh_free(&s->triangle);
    if (s->depth_program) gl.DeleteProgram(s->depth_program);
    if (s->add_program) gl.DeleteProgram(s->add_program);
    *s = (gl_sampled){.samples = 0};
}

unsigned long long gl_sampled_hash(unsigned long long hash, const void *bytes, size_t count)
{
    const unsigned char *b = bytes; // FNV-1a
    hash = hash ? hash : 14695981039346656037ull;
    for (size_t i = 0; i < count; i++) hash = (hash ^ b[i]) * 1099511628211ull;
    return hash;
}

void gl_sampled_add(gl_sampled *s, unsigned long long state, int points,
                    gl_sampled_frustum *frustum, const void *light, const gl_mesh *casters,
                    const GLuint surfaces[2], float normal_offset)
{
    if (s->samples == 0 || state != s->state) {
        s->state = state;
        s->samples = 0;
        gl_target_begin(&s->sum);
    }
    gl.ProgramUniform1f(s->add_program, gl.GetUniformLocation(s->add_program, "offset"),
                        normal_offset);
    for (; points > 0 && s->samples < GL_SAMPLED_POINTS; points--, s->samples++) {
        const float *p = s->point[s->samples];
        const mssm_light f = frustum(light, p[0], p[1]);
        // Matrices go by uniforms, which no driver takes out of order (see gl_reference.c).
        gl.ProgramUniformMatrix4fv(s->depth_program, 0, 1, GL_FALSE, f.world_to_shadow);
        gl.ProgramUniformMatrix4fv(s->add_program, 8, 1, GL_FALSE, f.world_to_shadow);
        gl_target_begin(&s->map);
        gl.Enable(GL_DEPTH_TEST);
        gl.UseProgram(s->depth_program);
        gl_mesh_draw(casters);
        gl.Disable(GL_DEPTH_TEST);
        gl.BindFramebuffer(GL_FRAMEBUFFER, s->sum.framebuffer);
        gl.Viewport(0, 0, s->sum.width, s->sum.height);
        for (GLuint i = 0; i < 2; i++) gl.BindTextureUnit(i, surfaces[i]);
        gl.BindTextureUnit(2, s->map.depth);
        gl.Enable(GL_BLEND);
        gl.BlendFunc(GL_ONE, GL_ONE);
        gl.UseProgram(s->add_program);
        gl_mesh_draw(&s->triangle);
        gl.Disable(GL_BLEND);
    }
}
