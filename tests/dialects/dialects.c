// The shading texts on the driver's compiler in each dialect, and what they compute in OpenGL ES
// 3.0 and OpenGL 3.3 against the CPU halves. With an argument, "330" say, prints a fragment shader
// of all texts for another compiler, with "words" every text there is.
#include "../../lightprobe.h"
#include "../../mssm.h"

#include "../../examples/common/gl33.h"
#include "../../examples/common/gl_context.h"
#include "../support/test.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 64, POINTS = SIDE * SIDE, LIGHTS = 3 };

static int failures;

static bool check(bool good, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    printf(good ? "ok    " : "FAIL  ");
    vprintf(format, list);
    printf("\n");
    va_end(list);
    failures += !good;
    return good;
}

// ---- The texts

static char *shadow_text(int moments, int lights, const char *name, int estimator)
{
    mssm_gl_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.moments = moments;
    desc.lights = lights;
    desc.name = name;
    desc.settings.estimator = (mssm_estimator)estimator;
    const size_t bytes = mssm_glsl_shader(&desc, NULL, 0);
    char *text = malloc(bytes + 1);
    text[bytes] = text[bytes - 1] = 77;
    mssm_glsl_shader(&desc, text, bytes - 1);
    if (text[bytes - 1] != 77) check(false, "a text was written where it has no room");
    mssm_glsl_shader(&desc, text, bytes);
    if (text[bytes] != 77 || strlen(text) != bytes - 1)
        check(false, "the length of a text is not what was said");
    return text;
}

static const char everything[] =
    "in vec3 p, n;\n"
    "out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    vec3 sum = lightprobe_residual_irradiance(n);\n"
    "    lightprobe_lobe lobe = lightprobe_specular_lobe(n, -p, 0.1, vec3(0.04));\n"
    "    for (int i = 0; i < lightprobe_count; i++)\n"
    "        sum += (lightprobe_irradiance(i, n) + lightprobe_specular(i, lobe)) * mssm_visibility(i, p, n);\n"
    "    mssm_faces f = mssm_point_faces(p.x, p.y, p.z);\n"
    "    color = vec4(sum * f.weight[0], lamp(0, p) + lamp_at(1, p));\n"
    "}\n";

// Two shadow maps, all else of both headers.
static void all_texts(const char *text[10])
{
    text[0] = "#define LIGHTPROBE_UNIFORMS 16\n";
    text[1] = shadow_text(6, 16, NULL, 0);
    text[2] = shadow_text(4, 2, "lamp", 1);
    text[3] = mssm_glsl_lights();
    text[4] = mssm_glsl_scattering();
    text[5] = lightprobe_glsl_math();
    text[6] = lightprobe_glsl_lights();
    text[7] = lightprobe_glsl_specular();
    text[8] = everything;
    text[9] = NULL;
}

static bool compiles(const char *version, const char *const *text, char log[2000])
{
    const GLuint shader = gl33_shader(GL_FRAGMENT_SHADER, version, text, log, 2000);
    gl33.DeleteShader(shader);
    return shader != 0;
}

static void texts_compile(const char *version)
{
    const char *text[10];
    char line[40], log[2000];
    all_texts(text);
    snprintf(line, sizeof line, "#version %s\n", version);
    const bool good = compiles(line, text, log);
    check(good && !log[0], "all texts compile as %s on the driver%s%s", version, good ? "" : ": ",
          log);
}

// ---- What they compute

// A map of SIDE texels around random blockers, under a light of some kind.
typedef struct map_of {
    mssm_light light;
    mssm_map *map;
    void *memory;
} map_of;

static void make_map(map_of *m, int kind, int side, int moments, uint64_t *state)
{
    const float low[3] = {-1, 0, -1}, high[3] = {1, 1, 1}, to_light[3] = {0.4f, 1, 0.2f},
                axis[3] = {1, 0, 0};
    const float above[3] = {0.3f, 2.5f, 0.1f};
    const size_t bytes = mssm_map_bytes(side, moments);
    float *depth = malloc((size_t)side * (size_t)side * 2 * sizeof *depth);
    m->memory = malloc(bytes);
    if (kind == 0) mssm_light_directional(&m->light, to_light, axis, 0.2f, 0.1f, low, high);
    if (kind == 1) mssm_light_spot(&m->light, above, to_light, axis, 0.8f, 0.5f, 4, 0.2f, 0.3f);
    if (kind == 2) mssm_light_directional(&m->light, axis, to_light, 0, 0, low, high);
    mssm_map_init(&m->map, m->memory, bytes, side, moments);
    for (int i = 0; i < side * side * 2; i++) depth[i] = 1;
    for (int k = 0; k < 40; k++) {
        const int x = (int)test_range(state, 0, side), y = (int)test_range(state, 0, side);
        const int w = (int)test_range(state, 1, side / 4), h = (int)test_range(state, 1, side / 4);
        const float z = (float)test_range(state, -0.9, 0.5);
        for (int j = y; j < y + h && j < side; j++)
            for (int i = x; i < x + w && i < side; i++) depth[(j * side + i) * 2 + k % 2] = z;
    }
    mssm_map_update(m->map, depth, kind == 2 ? depth : NULL, 2);
    free(depth);
}

static void upload(const map_of *m, int light, const GLuint texture[3])
{
    void *texels = malloc((size_t)16 << 20);
    mssm_texels t;
    for (int which = 0; which < 3; which++) {
        gl33.ActiveTexture(GL_TEXTURE0 + (GLenum)which);
        gl33.BindTexture(GL_TEXTURE_2D_ARRAY, texture[which]);
        gl33.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER,
                           0x2700); // GL_NEAREST_MIPMAP_NEAREST
        gl33.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
        for (int i = 0; !mssm_map_texels(m->map, which, i, &t, texels, (size_t)16 << 20); i++) {
            gl33.TexParameteri(GL_TEXTURE_2D_ARRAY, 0x813D, t.levels - 1); // GL_TEXTURE_MAX_LEVEL
            if (light == 0)
                gl33.TexImage3D(GL_TEXTURE_2D_ARRAY, i, (GLint)t.internal_format, t.side, t.side,
                                LIGHTS, 0, t.format, t.type, NULL);
            gl33.TexSubImage3D(GL_TEXTURE_2D_ARRAY, i, 0, 0, light, t.side, t.side, 1, t.format,
                               t.type, texels);
        }
    }
    free(texels);
}

// Points and normals by the pixel, the same in C as in GLSL: small multiples of powers of two.
static void point_of(int i, float p[3], float n[3])
{
    const int x = i % SIDE, y = i / SIDE;
    const float at[3] = {(float)(x - 32) / 24.0f, (float)((x * 7 + y * 3) & 31) / 32.0f,
                         (float)(y - 32) / 24.0f};
    memcpy(p, at, sizeof at);
    n[0] = 0.25f;
    n[1] = y % 2 ? 1.0f : 0.0f; // none at all in each other row
    n[0] *= n[1];
    n[2] = 0;
}

static const char receivers[] =
    "out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
    "    vec3 p = vec3(float(at.x - 32) / 24.0, float((at.x * 7 + at.y * 3) & 31) / 32.0, float(at.y - 32) / 24.0);\n"
    "    vec3 n = at.y % 2 == 1 ? vec3(0.25, 1.0, 0.0) : vec3(0.0);\n"
    "    color = vec4(lamp(0, p, n), lamp(1, p, n), lamp(2, p, n), 1.0);\n"
    "    if (lamp(3, p) != 1.0 || lamp(-1, p, n) != 1.0) color = vec4(7.0);\n"
    "}\n";
static const char triangle[] =
    "void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }\n";

static bool draw(const char *version, const char *const *fragment, image *out, message *why,
                 void (*set)(GLuint program))
{
    static const int indices[3] = {0, 1, 2};
    GLuint array, buffer;
    const GLuint program = gl33_program(version, triangle, fragment, why);
    if (!program || !gl33_target_begin(SIDE, SIDE, 0, why)) return false;
    gl33.UseProgram(program);
    set(program);
    gl33.GenVertexArrays(1, &array);
    gl33.BindVertexArray(array);
    gl33.GenBuffers(1, &buffer);
    gl33.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffer);
    gl33.BufferData(GL_ELEMENT_ARRAY_BUFFER, sizeof indices, indices, 0x88E4);
    gl33.DrawElements(GL_TRIANGLES, 3, GL_UNSIGNED_INT, NULL);
    gl33.DeleteVertexArrays(1, &array);
    gl33.DeleteProgram(program);
    return gl33.GetError() == GL_NO_ERROR && gl33_target_read(SIDE, SIDE, out, why);
}

static void set_shadows(GLuint program)
{
    static const char *const names[3] = {"mssm_lamp_table0", "mssm_lamp_table1",
                                         "mssm_lamp_depths"};
    for (int i = 0; i < 3; i++) gl33.Uniform1i(gl33.GetUniformLocation(program, names[i]), i);
    gl33.UniformBlockBinding(program, gl33.GetUniformBlockIndex(program, "mssm_lamp_view_block"),
                             5);
}

static void shadows_are_the_cpus(const char *version, int side, int moments, int estimator)
{
    uint64_t state = (uint64_t)side * 7 + (uint64_t)moments;
    map_of m[LIGHTS];
    mssm_settings settings = {moments, (mssm_estimator)estimator, 0, 0, 0, 0};
    int views[LIGHTS][28];
    GLuint texture[3], uniforms;
    image picture;
    message why = {"OpenGL refused a call"};
    char *text = shadow_text(moments, LIGHTS, "lamp", estimator);
    const char *const fragment[] = {text, receivers, NULL};
    gl33.GenTextures(3, texture);
    for (int i = 0; i < LIGHTS; i++) {
        make_map(&m[i], i, side, moments, &state);
        upload(&m[i], i, texture);
        if (mssm_map_view(m[i].map, &m[i].light, &settings, views[i])) check(false, "no view");
    }
    gl33.GenBuffers(1, &uniforms);
    gl33.BindBufferBase(GL_UNIFORM_BUFFER, 5, uniforms);
    gl33.BufferData(GL_UNIFORM_BUFFER, sizeof views, views, 0x88E8);
    const bool drawn = draw(version, fragment, &picture, &why, set_shadows);
    double worst = 0, sum = 0, between = 0;
    for (int i = 0; i < POINTS && drawn; i++) {
        float p[3], n[3];
        point_of(i, p, n);
        const vec3 seen = image_get(&picture, i % SIDE, SIDE - 1 - i / SIDE);
        const float of[3] = {seen.x, seen.y, seen.z};
        for (int k = 0; k < LIGHTS; k++) {
            const float v = mssm_map_visibility_normal(m[k].map, &m[k].light, &settings, p, n);
            worst = fmax(worst, fabs(v - of[k]));
            sum += fabs(v - of[k]) / (POINTS * LIGHTS);
            between += v > 0.05f && v < 0.95f;
        }
    }
    check(
        drawn && between > POINTS / 20 && worst < 0.02 && sum < 2e-5,
        "%.6s: visibility is the CPU's, side %d, %d moments, estimator %d (%.1e, at worst %.1e, %d in penumbrae)%s",
        version + 9, side, moments, estimator, sum, worst, (int)between, drawn ? "" : why.text);
    if (drawn) image_free(&picture);
    for (int i = 0; i < LIGHTS; i++) free(m[i].memory);
    gl33.DeleteTextures(3, texture);
    gl33.DeleteBuffers(1, &uniforms);
    free(text);
}

static const char irradiance[] =
    "out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    vec2 at = gl_FragCoord.xy / 32.0 - 1.0;\n"
    "    vec3 n = normalize(vec3(at.x, 1.0 - dot(at, at), at.y));\n"
    "    vec3 sum = lightprobe_residual_irradiance(n);\n"
    "    for (int i = 0; i < lightprobe_count; i++) sum += lightprobe_irradiance(i, n);\n"
    "    vec3 view = normalize(vec3(at.x + 0.3, 1.0 - at.y * at.y, -at.y));\n"
    "    lightprobe_lobe lobe = lightprobe_specular_lobe(n, view, 0.5 * abs(at.x) + 0.03, vec3(0.04, 0.5, 1.0));\n"
    "    vec3 shine = vec3(0.0);\n"
    "    for (int i = 0; i < lightprobe_count; i++) shine += lightprobe_specular(i, at.xyx, lobe);\n"
    "    color = gl_FragCoord.x > gl_FragCoord.y ? vec4(shine, 1.0) : vec4(sum, 1.0);\n"
    "}\n";

static void set_lights(GLuint program)
{
    gl33.UniformBlockBinding(program, gl33.GetUniformBlockIndex(program, "lightprobe_buffer"), 4);
}

static void probe_lights_are_the_cpus(const char *version)
{
    enum { FACE = 16, MOST = 12 };
    static float texels[6 * FACE * FACE * 3], block[(192 + 80 * MOST) / 4];
    lightprobe_light light[MOST];
    lightprobe_stats stats;
    lightprobe_settings settings;
    lightprobe_cube cube = {{0}, FACE, 3};
    uint64_t state = 11;
    int count = 0;
    memset(&settings, 0, sizeof settings);
    settings.max_lights = MOST - 2;
    for (int i = 0; i < 6 * FACE * FACE * 3; i++) texels[i] = (float)pow(test_uniform(&state), 8);
    for (int i = 0; i < 6; i++) cube.face[i] = texels + i * FACE * FACE * 3;
    const size_t bytes = lightprobe_scratch_bytes(FACE, MOST);
    void *scratch = malloc(bytes);
    if (lightprobe_extract(&cube, &settings, scratch, bytes, light, &count, &stats))
        check(false, "no lights");
    check(!lightprobe_uniforms(light, count, &stats, block, sizeof block),
          "%d lights become uniforms", count);
    GLuint uniforms;
    gl33.GenBuffers(1, &uniforms);
    gl33.BindBufferBase(GL_UNIFORM_BUFFER, 4, uniforms);
    gl33.BufferData(GL_UNIFORM_BUFFER, sizeof block, block, 0x88E8);
    const char *const fragment[] = {"#define LIGHTPROBE_UNIFORMS 12\n",
                                    lightprobe_glsl_math(),
                                    lightprobe_glsl_lights(),
                                    lightprobe_glsl_specular(),
                                    irradiance,
                                    NULL};
    image picture;
    message why = {"OpenGL refused a call"};
    const bool drawn = draw(version, fragment, &picture, &why, set_lights);
    double worst = 0, most = 0;
    for (int i = 0; i < POINTS && drawn; i++) {
        const float x = ((float)(i % SIDE) + 0.5f) / 32 - 1,
                    z = ((float)(i / SIDE) + 0.5f) / 32 - 1;
        const vec3 unit = vec_unit(vec(x, 1 - x * x - z * z, z));
        const float n[3] = {unit.x, unit.y, unit.z};
        float sum[3];
        lightprobe_residual_irradiance(&stats, n, sum);
        for (int k = 0; k < count; k++) {
            const float *d = light[k].direction;
            const float part = lightprobe_disc_irradiance(light[k].cos_alpha,
                                                          d[0] * n[0] + d[1] * n[1] + d[2] * n[2]);
            for (int c = 0; c < 3; c++) sum[c] += part * light[k].irradiance[c];
        }
        if (i % SIDE > i / SIDE) {
            const vec3 to_viewer = vec_unit(vec(x + 0.3f, 1 - z * z, -z));
            const float view[3] = {to_viewer.x, to_viewer.y, to_viewer.z}, f0[3] = {0.04f, 0.5f, 1};
            const lightprobe_lobe lobe =
                lightprobe_specular_lobe(n, view, 0.5f * fabsf(x) + 0.03f, f0);
            memset(sum, 0, sizeof sum);
            for (int k = 0; k < count; k++) {
                float part[3];
                lightprobe_specular(light[k], lobe, x, z, x, part);
                for (int c = 0; c < 3; c++) sum[c] += part[c];
            }
        }
        const vec3 seen = image_get(&picture, i % SIDE, SIDE - 1 - i / SIDE);
        worst = fmax(
            worst, fmax(fabs(seen.x - sum[0]), fmax(fabs(seen.y - sum[1]), fabs(seen.z - sum[2]))));
        most = fmax(most, sum[1]);
    }
    check(
        drawn && most > 0.1 && worst < 1e-5 * most,
        "%.6s: irradiance and reflection of a probe's lights are the CPU's (at worst %.1e of %.2f)%s",
        version + 9, worst, most, drawn ? "" : why.text);
    if (drawn) image_free(&picture);
    free(scratch);
    gl33.DeleteBuffers(1, &uniforms);
}

// ---- Bad arguments

static char said[200];

static void hear(void *user, const char *line)
{
    (void)user;
    snprintf(said, sizeof said, "%s", line);
}

static void refuse(const mssm_gl_desc *desc, const char *word)
{
    said[0] = 0;
    const bool refused = !mssm_glsl_shader(desc, NULL, 0) && strstr(said, word);
    if (!refused) check(false, "\"%s\" is not refused: \"%s\"", word, said);
}

static void bad_arguments_are_refused(void)
{
    mssm_gl_desc desc, bad;
    memset(&desc, 0, sizeof desc);
    desc.log = hear;
    bad = desc;
    bad.lights = 586;
    refuse(&bad, "lights 586: 1 to 585");
    bad.lights = -1;
    refuse(&bad, "lights -1: 1 to 585");
    bad = desc;
    bad.side = -3; // these do not count
    bad.samples = 99;
    if (!mssm_glsl_shader(&bad, NULL, 0)) check(false, "refused for what does not count: %s", said);
    bad = desc;
    bad.moments = 5;
    refuse(&bad, "moments");
    bad = desc;
    bad.name = "gl_name";
    refuse(&bad, "name");
    bad = desc;
    bad.filtered = 1;
    refuse(&bad, "filtered");
    check(!mssm_glsl_shader(NULL, NULL, 0), "texts: bad descriptors are refused with a word");
    lightprobe_stats stats;
    lightprobe_light light[2];
    unsigned char block[352], same[352];
    memset(&stats, 1, sizeof stats);
    memset(light, 1, sizeof light);
    memset(block, 7, sizeof block);
    memcpy(same, block, sizeof block);
    const bool refused =
        lightprobe_uniforms(NULL, 1, &stats, block, 352) == LIGHTPROBE_ERROR_NULL &&
        lightprobe_uniforms(light, 1, NULL, block, 352) == LIGHTPROBE_ERROR_NULL &&
        lightprobe_uniforms(light, 1, &stats, NULL, 352) == LIGHTPROBE_ERROR_NULL &&
        lightprobe_uniforms(light, -1, &stats, block, 352) == LIGHTPROBE_ERROR_LIGHTS &&
        lightprobe_uniforms(light, 2, &stats, block, 351) == LIGHTPROBE_ERROR_LIGHTS &&
        lightprobe_uniforms(NULL, 0, &stats, block, 191) == LIGHTPROBE_ERROR_LIGHTS;
    check(refused && !memcmp(block, same, sizeof block),
          "uniforms of lights: bad arguments change nothing");
    float last[3];
    light[1].distance = 5;
    light[1].slope_u = 6;
    light[1].slope_v = 7;
    check(!lightprobe_uniforms(NULL, 0, &stats, block, 192) &&
              !lightprobe_uniforms(light, 2, &stats, block, 352),
          "uniforms of lights: as many bytes as are said");
    memcpy(last, block + 340, sizeof last);
    check(last[0] == 5 && last[1] == 6 && last[2] == 7, "uniforms of lights: distance and slopes");
}

// ---- Contexts

static bool begin(gl_context *c, bool es)
{
    const char *missing;
    if (gl_context_create_portable(c, es, &missing) && gl33_load(gl_context_function, &missing))
        return true;
    printf("%s  OpenGL%s: %s\n", getenv("TEST_REQUIRE_GL") ? "FAIL" : "skip",
           es ? " ES 3.0" : " 3.3", missing);
    failures += getenv("TEST_REQUIRE_GL") != NULL;
    return false;
}

static void compute_in(bool es)
{
    const char *version = es ? "#version 300 es\nprecision highp float;\n" : "#version 330 core\n";
    gl_context context = {0};
    if (!begin(&context, es)) return;
    texts_compile(es ? "300 es" : "330");
    if (es) texts_compile("310 es");
    static const int sides[] = {37, 64, 200};
    for (int i = 0; i < 3; i++) {
        for (int moments = 4; moments <= 6; moments += 2)
            shadows_are_the_cpus(version, sides[i], moments, 0);
    }
    shadows_are_the_cpus(version, 100, 6, 1);
    shadows_are_the_cpus(version, 100, 4, 2);
    probe_lights_are_the_cpus(version);
    const char *text[10];
    char log[2000];
    all_texts(text);
    check(!compiles(es ? "#version 100\n" : "#version 150\n", text + 1, log) &&
              strstr(log, "#version 330"),
          "a #version that will not do is named");
    gl_context_destroy(&context);
}

static void print_every_text(void)
{
    gl_context context = {0};
    const char *missing, *text[10];
    all_texts(text);
    for (int i = 1; i < 8; i++) puts(text[i]);
    puts(mssm_glsl_translucent());
    if (!gl_context_create(&context, &missing)) return;
    for (int filtered = 0; filtered < 2; filtered++) {
        mssm_gl_desc desc;
        mssm_gl *made;
        memset(&desc, 0, sizeof desc);
        desc.load = gl_context_function;
        desc.side = 32;
        desc.filtered = filtered;
        if (mssm_gl_create(&made, &desc)) {
            failures++;
            continue;
        }
        puts(mssm_gl_shader(made));
        mssm_gl_destroy(made);
    }
    gl_context_destroy(&context);
}

int main(int argc, char **argv)
{
    gl_context context = {0};
    const char *missing, *text[10];
    if (argc > 1 && !strcmp(argv[1], "words")) {
        print_every_text();
        return failures;
    }
    if (argc > 1) {
        all_texts(text);
        printf("#version %s\n", argv[1]);
        for (int i = 0; i < 9; i++) fputs(text[i], stdout);
        return failures;
    }
    bad_arguments_are_refused();
    compute_in(true);
    compute_in(false);
    if (gl_context_create(&context, &missing) && gl33_load(gl_context_function, &missing)) {
        static const char *const versions[] = {"410 core", "430 core", "450 core"};
        for (int i = 0; i < 3; i++) texts_compile(versions[i]);
        gl_context_destroy(&context);
    } else {
        printf("skip  OpenGL 4.1 to 4.5: %s\n", missing);
    }
    return failures > 0;
}
