#include "measure_gl.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../examples/common/gl_context.h"
#include "../../examples/common/threads.h"
#include "flip.h"
#include "gl_convolution.h"
#include "gl_percentage_closer.h"

enum { MAP_SIDE = 256, PROBE_SIDE = 128, COUNT_BINDING = 7, MOST_LIGHTS = 16 };

typedef enum method_kind { LIBRARY, HARD, PERCENTAGE_CLOSER, CONVOLUTION } method_kind;

typedef struct gl_method {
    const char *name;
    method_kind kind;
    int variant;            // moments of the map, gl_percentage_closer_kind, terms of convolution
    mssm_settings settings; // of the library
    bool normal;            // it gets the receiver's
    bool mips;              // of convolution
    int frames;             // that a picture is the mean of; a frame pays for one of them
    float bias; // in texels, of those that need one: the best in the default scene's picture
} gl_method;

static const gl_method methods[MEASURE_GL_METHODS] = {
    {"layered, 6 moments", LIBRARY, 6, {.moments = 6}, 0, 0, 1, 0},
    {"layered, 4 moments", LIBRARY, 4, {.moments = 4}, 0, 0, 1, 0},
    {"layered, 6 moments, normal", LIBRARY, 6, {.moments = 6}, 1, 0, 1, 0},
    {LAYERED_HORIZON, LIBRARY, 6, {6, MSSM_HORIZON, 0, 0, 0, 0}, 1, 0, 1, 0},
    {"MSSM 4, lower blocker", LIBRARY, 4, {4, MSSM_LOWER_BLOCKER, 0, 0, 0, 0}, 0, 0, 1, 0},
    {"MSSM 4, upper blocker", LIBRARY, 4, {4, MSSM_UPPER_BLOCKER, 0, 0, 0, 0}, 0, 0, 1, 0},
    {"MSSM 6, lower blocker", LIBRARY, 6, {6, MSSM_LOWER_BLOCKER, 0, 0, 0, 0}, 0, 0, 1, 0},
    {"MSSM 6, upper blocker", LIBRARY, 6, {6, MSSM_UPPER_BLOCKER, 0, 0, 0, 0}, 0, 0, 1, 0},
    {PCSS_TAPS, PERCENTAGE_CLOSER, GL_PERCENTAGE_CLOSER_TAPS, {0}, 0, 0, 1, 6},
    {PCSS_GATHER, PERCENTAGE_CLOSER, GL_PERCENTAGE_CLOSER_GATHER, {0}, 0, 0, 1, 6},
    {PCSS_POISSON, PERCENTAGE_CLOSER, GL_PERCENTAGE_CLOSER_16, {0}, 0, 0, 1, 6},
    {PCSS_MORE, PERCENTAGE_CLOSER, GL_PERCENTAGE_CLOSER_32, {0}, 0, 0, 1, 6},
    {"PCSS, 16 samples over 8 frames", PERCENTAGE_CLOSER, GL_PERCENTAGE_CLOSER_16, {0}, 0, 0, 8, 6},
    {PCSS_GATHER_NORMAL, PERCENTAGE_CLOSER, GL_PERCENTAGE_CLOSER_GATHER_NORMAL, {0}, 1, 0, 1, 0.5f},
    {PCSS_POISSON_NORMAL, PERCENTAGE_CLOSER, GL_PERCENTAGE_CLOSER_16_NORMAL, {0}, 1, 0, 1, 0.5f},
    {PCSS_MORE_NORMAL, PERCENTAGE_CLOSER, GL_PERCENTAGE_CLOSER_32_NORMAL, {0}, 1, 0, 1, 0.5f},
    {CSSM8 CSSM_TABLES, CONVOLUTION, 4, {0}, 0, 0, 1, 0},
    {CSSM16 CSSM_TABLES, CONVOLUTION, 8, {0}, 0, 0, 1, 0},
    {CSSM_ANNEN CSSM_TABLES, CONVOLUTION, 16, {0}, 0, 0, 1, 0},
    {CSSM8 CSSM_MIPS, CONVOLUTION, 4, {0}, 0, 1, 1, 0},
    {CSSM16 CSSM_MIPS, CONVOLUTION, 8, {0}, 0, 1, 1, 0},
    {CSSM_ANNEN CSSM_MIPS, CONVOLUTION, 16, {0}, 0, 1, 1, 0},
    {"hard", HARD, 0, {0}, 0, 0, 1, 1},
};

// The scene and what all methods share.
typedef struct bench {
    gl_context context;
    lighting lights;
    gl_lighting view;
    gl_reference depth; // maps of one sample a texel, for the rivals
    probe source;
    scene scene;
    camera eye;
} bench;

// A method at work. The library's depth maps have its default of 4 samples a texel, the rivals'
// one.
typedef struct subject {
    const gl_method *method;
    mssm_gl *maps;
    gl_convolution convolution;
    GLuint program;
    bool own; // the program is freed with it
    float bias;
    int frame;
} subject;

// ---- Dispatches are counted on their way to the driver ------------------------------------------

static int dispatches;
static struct {
    void(GL_CALL *DispatchCompute)(GLuint x, GLuint y, GLuint z);
    void(GL_CALL *GenerateTextureMipmap)(GLuint texture);
} driver;

static void GL_CALL count_dispatch(GLuint x, GLuint y, GLuint z)
{
    dispatches++;
    driver.DispatchCompute(x, y, z);
}

static void GL_CALL count_mipmap(GLuint texture)
{
    dispatches++;
    driver.GenerateTextureMipmap(texture);
}

static mssm_gl_function load(const char *name)
{
    if (!strcmp(name, "glDispatchCompute")) return (mssm_gl_function)count_dispatch;
    return gl_context_function(name);
}

// ---- Scene --------------------------------------------------------------------------------------

static void bench_close(bench *b)
{
    gl_reference_free(&b->depth);
    gl_lighting_free(&b->view);
    lighting_free(&b->lights);
    scene_free(&b->scene);
    probe_free(&b->source);
    gl_context_destroy(&b->context);
}

static bool bench_scene(bench *b, int lights, message *why)
{
    const lighting_settings settings = {
        .probe = {.max_lights = lights}, .map_side = MAP_SIDE, .map_samples = 1};
    gl_lighting *v = &b->view;
    b->eye = camera_look(vec(0.3f, 2.25f, 7.7f), vec(-0.05f, 0.86f, 0), 0.57f, 16.0f / 9);
    if (!probe_default(&b->source, PROBE_SIDE) || !scene_create(&b->scene, 0, NULL)) {
        return fail(why, "no memory for the scene");
    }
    if (!lighting_create(&b->lights, &settings, PROBE_SIDE, why) ||
        !lighting_extract(&b->lights, &b->source, why) ||
        !gl_lighting_create(v, &b->lights, gl_context_function, 64, 36, why) ||
        !gl_reference_create(&b->depth, MAP_SIDE, lights, why)) {
        return false;
    }
    gl_probe_upload(&v->probe, b->source.face, PROBE_SIDE);
    return gl_lighting_draw_maps(v, &b->lights, &b->scene, why); // for its casters and its order
}

// On failure nothing is kept.
static bool bench_open(bench *b, int lights, message *why)
{
    const char *missing;
    memset(b, 0, sizeof *b);
    if (!gl_context_create(&b->context, &missing)) return fail(why, "%s", missing);
    driver.DispatchCompute = gl.DispatchCompute;
    driver.GenerateTextureMipmap = gl.GenerateTextureMipmap;
    gl.DispatchCompute = count_dispatch;
    gl.GenerateTextureMipmap = count_mipmap;
    if (bench_scene(b, lights, why)) return true;
    bench_close(b);
    return false;
}

static bool bench_size(bench *b, int width, message *why)
{
    if (!gl_lighting_resize(&b->view, width, width * 9 / 16, why)) return false;
    gl_lighting_draw_view(&b->view, &b->scene, &b->eye);
    return true;
}

// ---- Methods ------------------------------------------------------------------------------------

static void subject_close(subject *s)
{
    mssm_gl_destroy(s->maps);
    if (s->program && s->own) gl.DeleteProgram(s->program);
    gl_convolution_free(&s->convolution);
    memset(s, 0, sizeof *s);
}

// The visibility text of a method, and after it what hands over the normal, which the shading pass
// has at hand under that name.
static const char normal_text[] =
    "#define mssm_visibility(light, position) mssm_visibility(light, position, normal)\n";

static void visibility_text(const subject *s, char *text, size_t room)
{
    const gl_method *m = s->method;
    const gl_convolution_filter filter = m->mips ? GL_CONVOLUTION_MIPS : GL_CONVOLUTION_TABLES;
    if (m->kind == LIBRARY)
        snprintf(text, room, "%s", mssm_gl_shader(s->maps));
    else if (m->kind == CONVOLUTION)
        gl_convolution_visibility(filter, m->variant, NULL, text, room);
    else if (m->kind == HARD)
        gl_reference_visibility(GL_REFERENCE_HARD, text, room);
    else
        gl_percentage_closer_visibility((gl_percentage_closer_kind)m->variant, text, room);
}

static GLuint program_of(const subject *s, message *why)
{
    enum { ROOM = 1 << 17 };
    char *text = malloc(ROOM);
    if (!text) return (void)fail(why, "no memory for a shader"), 0u;
    visibility_text(s, text, ROOM);
    if (s->method->normal) strcat(text, normal_text);
    const GLuint program = gl_lighting_program(s->method->name, text, false, why);
    free(text);
    return program;
}

static bool subject_open(subject *s, const gl_method *m, const bench *b, message *why)
{
    const int lights = b->lights.lights;
    memset(s, 0, sizeof *s);
    s->method = m;
    s->bias = m->bias;
    s->own = m->kind != CONVOLUTION;
    if (m->kind == LIBRARY) {
        const mssm_gl_desc desc = {.load = load,
                                   .lights = lights,
                                   .side = MAP_SIDE,
                                   .moments = m->variant,
                                   .settings = m->settings,
                                   .first_texture_unit = 4,
                                   .first_buffer_binding = 1};
        const mssm_result result = mssm_gl_create(&s->maps, &desc);
        if (result != MSSM_OK) return fail(why, "%s: %s", m->name, mssm_result_string(result));
    }
    if (m->kind == CONVOLUTION) {
        gl_convolution_create(&s->convolution,
                              m->mips ? GL_CONVOLUTION_MIPS : GL_CONVOLUTION_TABLES, m->variant,
                              NULL, MAP_SIDE, lights, why);
        s->program = s->convolution.program;
    } else {
        s->program = program_of(s, why);
    }
    if (s->program) return true;
    subject_close(s);
    return false;
}

static mssm_light frustum_of(const bench *b, int i)
{
    const lightprobe_light *l = &b->view.ordered[i];
    const float low[3] = {b->scene.low.x, b->scene.low.y, b->scene.low.z};
    const float high[3] = {b->scene.high.x, b->scene.high.y, b->scene.high.z};
    mssm_light f;
    memset(&f, 0, sizeof f);
    mssm_light_directional(&f, l->direction, l->axis_u, l->tan_half_u, l->tan_half_v, low, high);
    return f;
}

static double finish(void)
{
    gl.Finish();
    return seconds_now();
}

// Depth maps, and what shading reads. With a kernel, the widest that a receiver can ask for is so
// many texels wide. Times of the update alone go to *update (or NULL), which costs stops in
// between.
static void draw_maps(bench *b, subject *s, float kernel, double *update)
{
    const int lights = b->lights.lights;
    double start = 0, spent = 0;
    if (s->method->kind != LIBRARY) {
        b->depth.bias = s->bias;
        b->depth.frame = s->frame;
        gl_reference_draw(&b->depth, &b->view, lights, &b->scene, GL_REFERENCE_HARD, 0);
        if (update) start = finish();
        if (s->convolution.program) gl_convolution_update(&s->convolution, &b->depth, lights);
        if (update) *update = s->convolution.program ? finish() - start : 0;
        return;
    }
    for (int i = 0; i < lights; i++) {
        mssm_light f = frustum_of(b, i);
        const float texels = 0.5f * MAP_SIDE * (f.z_far - f.z_near);
        if (kernel > 0) f.half_u = 0.5f * kernel * f.extent_u / (0.5f * texels);
        if (kernel > 0) f.half_v = 0.5f * kernel * f.extent_v / (0.5f * texels);
        mssm_gl_set_light(s->maps, i, &f);
        mssm_gl_begin_depth(s->maps, i, 0);
        gl.UseProgram(b->view.depth_program);
        gl.ProgramUniformMatrix4fv(b->view.depth_program, 0, 1, GL_FALSE, f.world_to_shadow);
        gl_mesh_draw(&b->view.casters);
        if (update) start = finish();
        mssm_gl_end_depth(s->maps);
        if (update) spent += finish() - start;
    }
    if (update) start = finish();
    mssm_gl_build(s->maps);
    if (update) *update = spent + finish() - start;
}

// A picture that is the mean of several frames is added up.
static void shade(bench *b, subject *s, GLuint program)
{
    const gl_target *to = &b->view.picture;
    gl.BindFramebuffer(GL_FRAMEBUFFER, to->framebuffer);
    gl.Viewport(0, 0, to->width, to->height);
    if (s->maps) {
        mssm_gl_bind(s->maps);
    } else {
        gl_reference_bind(&b->depth);
        if (s->convolution.program) gl_convolution_bind(&s->convolution);
    }
    gl_lighting_pass(&b->view, program, &b->lights, &b->eye, 0, b->lights.lights,
                     GL_LIGHTING_BASE | (s->frame ? GL_LIGHTING_ADD : 0u));
    s->frame = (s->frame + 1) % s->method->frames;
}

// ---- What can be counted ------------------------------------------------------------------------

// Bytes of a texture, all levels and layers.
static double texture_bytes(GLuint texture, int texel_bytes)
{
    GLint levels = 0, size[3];
    double texels = 0;
    if (texture) gl.GetTextureParameteriv(texture, GL_TEXTURE_IMMUTABLE_LEVELS, &levels);
    for (int level = 0; level < levels; level++) {
        gl.GetTextureLevelParameteriv(texture, level, GL_TEXTURE_WIDTH, &size[0]);
        gl.GetTextureLevelParameteriv(texture, level, GL_TEXTURE_HEIGHT, &size[1]);
        gl.GetTextureLevelParameteriv(texture, level, GL_TEXTURE_DEPTH, &size[2]);
        texels += (double)size[0] * size[1] * size[2];
    }
    return texels * texel_bytes;
}

// Of what shading reads, for all lights.
static double map_bytes(const bench *b, const subject *s)
{
    const gl_convolution *c = &s->convolution;
    const bool mips = s->method->mips;
    if (s->maps) {
        return texture_bytes(mssm_gl_texture(s->maps, 0), 16) +
               texture_bytes(mssm_gl_texture(s->maps, 1), 8) +
               texture_bytes(mssm_gl_texture(s->maps, 2), 8);
    }
    if (!c->program) return texture_bytes(b->depth.depth, 4);
    return texture_bytes(c->basis, mips ? 4 : 16) + texture_bytes(c->weighted, mips ? 8 : 16) +
           texture_bytes(c->mean, mips ? 2 : 4);
}

// The shading text again, with every texture read counted in texels and the sums in a buffer.
static GLuint counting_program(const subject *s, message *why)
{
    static const char wrap[] =
        "#undef mssm_visibility\n"
        "layout(std430, binding = 7) buffer Counts { uint calls, all_reads; };\n"
        "float mssm_visibility(int light, vec3 position%s)\n"
        "{\n"
        "    reads = 0;\n"
        "    float visibility = counted_visibility(light, position%s);\n"
        "    atomicAdd(calls, 1);\n"
        "    atomicAdd(all_reads, reads);\n"
        "    return visibility;\n"
        "}\n%s";
    enum { ROOM = 1 << 17 };
    const gl_method *m = s->method;
    char *whole = malloc(ROOM);
    if (!whole) return (void)fail(why, "no memory"), 0u;
    // Of a read through a filter: 4 texels, 8 between mip levels, 1 from depth maps.
    int at = snprintf(whole, ROOM,
                      "uint reads = 0;\n"
                      "#define mssm_visibility counted_visibility\n"
                      "#define texelFetch(a, b, c) (reads++, texelFetch(a, b, c))\n"
                      "#define textureGather(a, b) (reads += 4, textureGather(a, b))\n"
                      "#define textureLod(a, b, c) (reads += %d, textureLod(a, b, c))\n",
                      m->kind != CONVOLUTION ? 1
                      : m->mips              ? 8
                                             : 4);
    visibility_text(s, whole + at, ROOM - 4096);
    at += (int)strlen(whole + at);
    snprintf(whole + at, (size_t)(ROOM - at), wrap, m->normal ? ", vec3 normal" : "",
             m->normal ? ", normal" : "", m->normal ? normal_text : "");
    const GLuint program = gl_lighting_program("counting reads", whole, false, why);
    free(whole);
    return program;
}

// Texels read for one receiver and light that is not below its horizon: the mean over the picture.
static double count_reads(bench *b, subject *s, message *why)
{
    const GLuint program = counting_program(s, why);
    GLuint buffer, counts[2] = {0, 0};
    if (!program) return 0;
    gl.CreateBuffers(1, &buffer);
    gl.NamedBufferStorage(buffer, sizeof counts, counts, 0);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, COUNT_BINDING, buffer);
    shade(b, s, program);
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl.GetNamedBufferSubData(buffer, 0, sizeof counts, counts);
    gl.DeleteBuffers(1, &buffer);
    gl.DeleteProgram(program);
    return counts[0] ? (double)counts[1] / counts[0] : 0;
}

// ---- Runs ---------------------------------------------------------------------------------------

static void run_round(bench *b, subject *s, gl_times *t)
{
    const int i = t->count++;
    const double start = finish();
    draw_maps(b, s, 0, NULL);
    const double drawn = finish();
    shade(b, s, s->program);
    const double end = finish();
    t->shade[i] = 1e3 * (end - drawn);
    t->frame[i] = 1e3 * (end - start);
    draw_maps(b, s, 0, &t->update[i]);
    t->update[i] *= 1e3;
}

// Compiles and fills what the first frame of a program has to.
static void warm_up(bench *b, subject *s)
{
    draw_maps(b, s, 0, NULL);
    gl.Enable(GL_SCISSOR_TEST);
    gl.Scissor(0, 0, 8, 8);
    shade(b, s, s->program);
    gl.Disable(GL_SCISSOR_TEST);
    gl.Finish();
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void sort(double *to, const double *values, int count)
{
    memcpy(to, values, (size_t)count * sizeof *to);
    qsort(to, (size_t)count, sizeof *to, compare);
}

double measure_gl_median(const double *values, int count)
{
    double v[MEASURE_GL_ROUNDS];
    sort(v, values, count);
    return 0.5 * (v[count / 2] + v[(count - 1) / 2]);
}

static const gl_method *method_called(const char *name)
{
    for (int i = 0; i < MEASURE_GL_METHODS; i++) {
        if (!strcmp(methods[i].name, name)) return &methods[i];
    }
    return NULL;
}

static bool open_subjects(bench *b, subject *s, const char *const *names, int count, message *why)
{
    for (int i = 0; i < count; i++) {
        const gl_method *m = method_called(names[i]);
        if (m ? subject_open(&s[i], m, b, why) : fail(why, "no method %s", names[i])) {
            warm_up(b, &s[i]);
            continue;
        }
        while (i) subject_close(&s[--i]);
        return false;
    }
    return true;
}

bool measure_gl_times(int lights, int width, int rounds, const char *const *names, int count,
                      gl_times *times, message *why)
{
    subject s[MEASURE_GL_METHODS];
    bench b;
    if (!bench_open(&b, lights, why)) return false;
    const bool done = bench_size(&b, width, why) && open_subjects(&b, s, names, count, why);
    memset(times, 0, (size_t)count * sizeof *times);
    for (int i = 0; i < rounds * count && done; i++)
        run_round(&b, &s[i % count], &times[i % count]);
    for (int i = 0; i < count && done; i++) subject_close(&s[i]);
    bench_close(&b);
    return done;
}

static void add(figures *f, const char *experiment, const char *name, double x, const char *metric,
                const double *values, int count)
{
    double v[MEASURE_GL_ROUNDS];
    sort(v, values, count);
    if (!figures_add(f, experiment, "default", name, x, metric, measure_gl_median(v, count), v[0],
                     v[count - 1])) {
        fprintf(stderr, "no memory for figures\n");
    }
}

// What does not depend on the clock; reads in a small picture, since sums have 32 bits.
static bool add_counts(figures *f, bench *b, subject *s, message *why)
{
    const double lights = b->lights.lights;
    const char *name = s->method->name;
    dispatches = 0;
    draw_maps(b, s, 0, NULL);
    const double counted = dispatches, bytes = map_bytes(b, s), reads = count_reads(b, s, why);
    add(f, "gl", name, lights, "dispatches", &counted, 1);
    add(f, "gl", name, lights, "bytes", &bytes, 1);
    add(f, "gl", name, lights, "reads", &reads, 1);
    return reads > 0;
}

// The lights' picture with the visibility of every surface by rays: two of them, whose mean is the
// truth.
static bool trace_truth(bench *b, int grid, image truth[2], message *why)
{
    const gl_target *to = &b->view.picture;
    bvh *tree = bvh_create(&b->scene);
    view v;
    if (!tree) return fail(why, "no memory for rays");
    bool done = view_create(&v, &b->scene, &b->eye, to->width, to->height);
    for (int i = 0; i < 2 && done; i++) {
        const light_source rays = {&b->lights, tree, NULL, grid, (unsigned)i + 1};
        done = image_create(&truth[i], to->width, to->height);
        if (done) lighting_render(&v, &b->scene, &b->source, &rays, &truth[i]);
    }
    view_free(&v);
    bvh_free(tree);
    return done || fail(why, "no memory for the truth");
}

// Of luminance, in percent of its mean, over the whole picture.
static double picture_error(const image *truth, const image *picture)
{
    const int count = truth->width * truth->height;
    double squares = 0, sum = 0;
    for (int i = 0; i < count; i++) {
        const double a = (double)vec_luminance(vec_of(truth->rgb + 3 * i));
        const double d = (double)vec_luminance(vec_of(picture->rgb + 3 * i)) - a;
        squares += d * d;
        sum += a;
    }
    return 100 * sqrt(squares / count) / (sum / count);
}

// Of a method with its bias; false with a message.
static bool draw_picture(bench *b, subject *s, image *picture, message *why)
{
    s->frame = 0;
    do {
        draw_maps(b, s, 0, NULL);
        shade(b, s, s->program);
    } while (s->frame > 0);
    if (!gl_target_read(&b->view.picture, picture, why)) return false;
    const float share = 1.0f / (float)s->method->frames;
    for (int i = 0; i < 3 * picture->width * picture->height; i++) picture->rgb[i] *= share;
    return true;
}

// Of the pictures as a viewer shows them; scales the picture.
static double shown_flip(const bench *b, const image *truth, image *picture)
{
    const float exposure = lighting_exposure(truth, &b->scene, &b->eye);
    image shown = {0, 0, NULL};
    if (!image_create(&shown, truth->width, truth->height)) return NAN;
    for (int i = 0; i < 3 * shown.width * shown.height; i++) {
        shown.rgb[i] = exposure * truth->rgb[i];
        picture->rgb[i] *= exposure;
    }
    const double flip = flip_mean(&shown, picture);
    image_free(&shown);
    return flip;
}

// NAN with a message; flip may be NULL.
static double method_error(bench *b, subject *s, const image *truth, double *flip, message *why)
{
    image picture = {0, 0, NULL};
    if (!draw_picture(b, s, &picture, why)) return NAN;
    const double error = picture_error(truth, &picture);
    if (flip) *flip = shown_flip(b, truth, &picture);
    image_free(&picture);
    return error;
}

// The bias that suits the method best, and the error with each of those tried.
static bool find_bias(figures *f, bench *b, subject *s, const image *truth, bool quick,
                      message *why)
{
    static const float tried[] = {0, 0.5f, 1, 2, 3, 4, 6, 8, 12, 16};
    double least = HUGE_VAL;
    float best = 0;
    for (size_t i = quick ? 1 : 0; i < sizeof tried / sizeof *tried; i += quick ? 4 : 1) {
        s->bias = tried[i];
        const double error = method_error(b, s, truth, NULL, why);
        if (isnan(error)) return false;
        add(f, "gl_bias", s->method->name, (double)tried[i], "rms", &error, 1);
        if (error < least) best = tried[i];
        least = fmin(least, error);
    }
    s->bias = best;
    return true;
}

static bool add_errors(figures *f, bench *b, subject *s, bool quick, message *why)
{
    const int grid = quick ? 6 : 12; // of rays to a light
    const double lights = b->lights.lights;
    image truth[2] = {{0, 0, NULL}, {0, 0, NULL}};
    bool done = trace_truth(b, grid, truth, why);
    const double noise = done ? 0.5 * picture_error(&truth[0], &truth[1]) : 0;
    const int count = done ? 3 * truth[0].width * truth[0].height : 0;
    for (int i = 0; i < count; i++) truth[0].rgb[i] = 0.5f * (truth[0].rgb[i] + truth[1].rgb[i]);
    if (done) add(f, "gl", "truth", lights, "rms", &noise, 1);
    float same = 0; // of methods that read alike: the last bias found
    for (int i = 0; i < MEASURE_GL_METHODS && done; i++) {
        const gl_method *m = s[i].method;
        const bool biased = m->kind == HARD || m->kind == PERCENTAGE_CLOSER;
        if (m->frames > 1) s[i].bias = same;
        if (biased && m->frames == 1) done = find_bias(f, b, &s[i], &truth[0], quick, why);
        double flip = 0;
        const double error = done ? method_error(b, &s[i], &truth[0], &flip, why) : NAN;
        const double bias = (double)(same = s[i].bias);
        done = done && !isnan(error) && !isnan(flip);
        if (done) add(f, "gl", m->name, lights, "flip", &flip, 1);
        if (done) add(f, "gl", m->name, lights, "rms", &error, 1);
        if (done && biased) add(f, "gl", m->name, lights, "bias", &bias, 1);
    }
    for (int i = 0; i < 2; i++) image_free(&truth[i]);
    return done;
}

static void add_times(figures *f, const bench *b, const subject *s, const gl_times *t)
{
    const double lights = b->lights.lights, width = b->view.picture.width;
    add(f, "gl", s->method->name, lights, "width", &width, 1);
    add(f, "gl", s->method->name, lights, "shade_ms", t->shade, t->count);
    add(f, "gl", s->method->name, lights, "update_ms", t->update, t->count);
    add(f, "gl", s->method->name, lights, "frame_ms", t->frame, t->count);
}

// The shading pass against the width of kernels.
static void add_kernels(figures *f, bench *b, subject *s, int rounds)
{
    static const int widths[] = {9, 19, 39, 75, 101};
    enum { WIDTHS = sizeof widths / sizeof *widths };
    double ms[WIDTHS][MEASURE_GL_ROUNDS];
    for (int i = 0; i < rounds * WIDTHS; i++) {
        draw_maps(b, s, (float)widths[i % WIDTHS], NULL);
        const double start = finish();
        shade(b, s, s->program);
        ms[i % WIDTHS][i / WIDTHS] = 1e3 * (finish() - start);
    }
    for (int i = 0; i < WIDTHS; i++) {
        add(f, "gl_kernel", s->method->name, widths[i], "shade_ms", ms[i], rounds);
    }
}

static bool measure_lights(figures *f, int lights, bool quick, message *why)
{
    const int width = quick ? 96 : 960, rounds = quick ? 1 : lights < MOST_LIGHTS ? 2 : 3;
    gl_times times[MEASURE_GL_METHODS];
    const char *names[MEASURE_GL_METHODS];
    subject s[MEASURE_GL_METHODS];
    bench b;
    memset(times, 0, sizeof times);
    for (int i = 0; i < MEASURE_GL_METHODS; i++) names[i] = methods[i].name;
    if (!bench_open(&b, lights, why)) return false;
    bool done = open_subjects(&b, s, names, MEASURE_GL_METHODS, why);
    const bool opened = done;
    if (done) done = bench_size(&b, width < 192 ? width : 192, why);
    if (done && lights == MOST_LIGHTS) done = add_errors(f, &b, s, quick, why);
    for (int i = 0; i < MEASURE_GL_METHODS && done; i++) done = add_counts(f, &b, &s[i], why);
    if (done) done = bench_size(&b, width, why);
    for (int i = 0; i < MEASURE_GL_METHODS && done; i++) warm_up(&b, &s[i]);
    for (int i = 0; i < rounds * MEASURE_GL_METHODS && done; i++) {
        run_round(&b, &s[i % MEASURE_GL_METHODS], &times[i % MEASURE_GL_METHODS]);
    }
    for (int i = 0; i < MEASURE_GL_METHODS && done; i++) add_times(f, &b, &s[i], &times[i]);
    if (lights == MOST_LIGHTS && done) add_kernels(f, &b, &s[0], rounds);
    for (int i = 0; i < MEASURE_GL_METHODS && opened; i++) subject_close(&s[i]);
    bench_close(&b);
    return done;
}

void measure_gl(figures *f, bool quick)
{
    message why = {{0}};
    if (!measure_lights(f, 4, quick, &why) || !measure_lights(f, MOST_LIGHTS, quick, &why)) {
        fprintf(stderr, "OpenGL is left out: %s\n", why.text);
    }
}
