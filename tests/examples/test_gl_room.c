// The room whose probe is rendered each frame: the example's own code against rays, in one picture
// and over frames in which lamp, door and sun patch move.
#define main gl_room_main
#include "../../examples/gl_room.c"
#undef main

#include "../support/gl_test.h"
#include "../support/test.h"
#include "../../examples/common/threads.h"

#include <stdlib.h>
#include <string.h>

enum {
    WIDTH = 192,
    HEIGHT = 108,
    LIGHTS = 16,
    PROBE = 64,
    RECEIVERS = 400,
    FRAMES = 9,
    TRUTHS = 3
};

typedef struct stage {
    gl_context context;
    renderer r;
    int receivers, pixel[RECEIVERS];
    vec3 point[RECEIVERS], normal[RECEIVERS], albedo[RECEIVERS];
    float drawn[FRAMES][RECEIVERS][3], truth[TRUTHS][RECEIVERS][3];
} stage;

static float seen[3][HEIGHT][WIDTH]
                 [4]; // position, normal, albedo in the middles of pixels, from below

static vec3 seen_at(int what, int x, int y)
{
    return vec_of(seen[what][y][x]);
}

// Whether a pixel shows a thing, and its neighbours the same piece of its surface.
static bool is_inside(const room *world, int x, int y)
{
    const vec3 p = seen_at(0, x, y), n = seen_at(1, x, y);
    const vec3 low = vec_min(p, world->low), high = vec_max(p, world->high);
    bool inside =
        vec_length(vec_sub(low, world->low)) + vec_length(vec_sub(high, world->high)) < 1e-4f;
    for (int i = 0; i < 9; i++) {
        const int u = x + i % 3 - 1, v = y + i / 3 - 1;
        inside = inside && vec_dot(n, seen_at(1, u, v)) > 0.9f &&
                 fabsf(vec_dot(n, vec_sub(p, seen_at(0, u, v)))) < 0.01f;
    }
    return inside;
}

static void choose_receivers(stage *s)
{
    const camera eye = room_camera((float)WIDTH / HEIGHT);
    gl_surfaces surfaces;
    gl_mesh all = {0};
    room world;
    uint64_t state = 3;
    message why = {"no memory"};
    CHECK(room_create(&world, 0) && gl_mesh_upload(&all, &world.all, &why) &&
              gl_surfaces_create(&surfaces, WIDTH, HEIGHT, &why),
          "%s", why.text);
    gl_surfaces_draw(&surfaces, &all, &eye);
    for (int i = 0; i < 3; i++)
        gl.GetTextureImage(surfaces.target.color[i], 0, GL_RGBA, GL_FLOAT, sizeof seen[i], seen[i]);
    for (int i = 0; i < 100000 && s->receivers < RECEIVERS; i++) {
        const int x = (int)test_range(&state, 1, WIDTH - 1),
                  y = (int)test_range(&state, 1, HEIGHT - 1), k = s->receivers;
        if (!is_inside(&world, x, y)) continue;
        s->pixel[k] = (HEIGHT - 1 - y) * WIDTH + x;
        s->point[k] = seen_at(0, x, y);
        s->normal[k] = seen_at(1, x, y);
        s->albedo[k] = seen_at(2, x, y);
        s->receivers++;
    }
    CHECK(s->receivers == RECEIVERS, "%d receivers", s->receivers);
    gl.UseProgram(0);
    gl_surfaces_free(&surfaces);
    gl_mesh_free(&all);
    room_free(&world);
}

static bool begin(stage *s, int lights)
{
    const options o = {.lights = lights, .width = WIDTH, .height = HEIGHT};
    message why = {"no memory"};
    memset(s, 0, sizeof *s);
    if (!gl_test_begin(&s->context)) return false;
    choose_receivers(s);
    CHECK(create(&s->r, &o, PROBE, &why), "%s", why.text);
    return true;
}

enum { KINDS = 7, NAMES = 2000, DELETE_STATUS = 0x8B80 };

// Not counting what is marked for deletion: Mesa keeps the program of the last pass for depth
// alone.
static int living_objects(void)
{
    static const char *const is[KINDS] = {"glIsTexture", "glIsBuffer",      "glIsFramebuffer",
                                          "glIsProgram", "glIsVertexArray", "glIsQuery",
                                          "glIsShader"};
    int count = 0;
    for (int k = 0; k < KINDS; k++) {
        GLboolean(GL_CALL * living)(GLuint name);
        void (*const function)(void) = gl_context_function(is[k]);
        memcpy(&living, &function, sizeof living);
        for (GLuint i = 1; i < NAMES; i++) {
            GLint deleted = 0;
            if (!living(i)) continue;
            if (k == 3) gl.GetProgramiv(i, DELETE_STATUS, &deleted);
            if (k == 6) gl.GetShaderiv(i, DELETE_STATUS, &deleted);
            count += !deleted;
        }
    }
    return count;
}

static void end(stage *s)
{
    CHECK(living_objects() > 20, "%d objects at work", living_objects());
    gl.UseProgram(0); // what is in use goes on living
    destroy(&s->r);
    CHECK(living_objects() == 0, "%d objects are left", living_objects());
    CHECK(gl.GetError() == GL_NO_ERROR, "GL error");
    gl_context_destroy(&s->context);
}

// Its cube without distances, by which all light comes from infinity.
static bool draw_without_places(renderer *r, const room *world, message *why)
{
    static float texels[6 * PROBE * PROBE][4];
    GLuint cube;
    if (!gl_room_set(&r->walls, world, why)) return false;
    gl_room_draw_cube(&r->walls);
    gl.GetTextureImage(r->walls.cube, 1, GL_RGBA, GL_FLOAT, sizeof texels, texels);
    for (int i = 0; i < 6 * PROBE * PROBE; i++) texels[i][3] = 0;
    gl.CreateTextures(GL_TEXTURE_CUBE_MAP, 1, &cube);
    gl.TextureStorage2D(cube, 1, GL_RGBA32F, PROBE, PROBE);
    gl.TextureSubImage3D(cube, 0, 0, 0, 0, PROBE, PROBE, 6, GL_RGBA, GL_FLOAT, texels);
    const bool drawn = draw_lit_by(r, world, cube, why);
    gl.DeleteTextures(1, &cube);
    return drawn;
}

static void draw(stage *s, float time, bool at_infinity, float out[RECEIVERS][3])
{
    room world;
    image picture = {0};
    message why = {"no memory"};
    const bool drawn = room_create(&world, time) &&
                       (at_infinity ? draw_without_places : draw_frame)(&s->r, &world, &why) &&
                       gl_target_read(&s->r.picture, &picture, &why);
    CHECK(drawn, "%s", why.text);
    for (int i = 0; i < s->receivers && drawn; i++)
        memcpy(out[i], picture.rgb + 3 * s->pixel[i], sizeof out[i]);
    image_free(&picture);
    room_free(&world);
}

typedef struct trace_work {
    const stage *s;
    const room_truth *rays;
    float (*out)[3];
} trace_work;

// What the varnish adds, where there is one.
static void trace_one(void *context, int i)
{
    const trace_work *w = context;
    if (w->s->r.shine > 0) {
        const vec3 eye = room_camera((float)WIDTH / HEIGHT).position;
        const vec3 shine =
            room_truth_shine(w->rays, w->s->point[i], w->s->normal[i],
                             vec_unit(vec_sub(eye, w->s->point[i])), w->s->r.shine, (unsigned)i);
        memcpy(w->out[i], &shine, sizeof w->out[i]);
        return;
    }
    const vec3 e =
        room_truth_irradiance(w->rays, w->s->point[i], w->s->normal[i], false, (unsigned)i);
    const vec3 color = vec_scale(vec_mul(e, w->s->albedo[i]), 1 / VEC_PI);
    memcpy(w->out[i], &color, sizeof w->out[i]);
}

static void trace(const stage *s, float time, float out[RECEIVERS][3])
{
    room world;
    message why = {"no memory"};
    room_truth *rays = room_create(&world, time) ? room_truth_create(&world, 0.12f, 8, &why) : NULL;
    CHECK(rays, "%s", why.text);
    if (rays) parallel_for(s->receivers, trace_one, &(trace_work){s, rays, out}, NULL);
    room_truth_free(rays);
    room_free(&world);
}

static double mean(const stage *s, float a[RECEIVERS][3])
{
    double sum = 0;
    for (int i = 0; i < 3 * s->receivers; i++) sum += (double)a[i / 3][i % 3];
    return sum / (3 * s->receivers);
}

static double difference(const stage *s, float a[RECEIVERS][3], float b[RECEIVERS][3])
{
    double squares = 0;
    for (int i = 0; i < 3 * s->receivers; i++)
        squares += pow((double)(a[i / 3][i % 3] - b[i / 3][i % 3]), 2);
    return sqrt(squares / (3 * s->receivers));
}

static stage s;

static void things_are_lit_as_by_rays(void)
{
    const float times[] = {STILL,
                           0.3f}; // the lamp above the things, and aside; the door open, half open
    if (!begin(&s, LIGHTS)) return;
    for (int i = 0; i < 2; i++) {
        lightprobe_gl_restart(s.r.lights.probe);
        draw(&s, times[i], false, s.drawn[0]);
        draw(&s, times[i], true, s.drawn[1]);
        trace(&s, times[i], s.truth[0]);
        const double all = mean(&s, s.truth[0]),
                     placed = difference(&s, s.drawn[0], s.truth[0]) / all;
        const double endless = difference(&s, s.drawn[1], s.truth[0]) / all;
        test_note("at %.2f: rms error %.3f, with lights at infinity %.3f", (double)times[i], placed,
                  endless);
        CHECK(placed < 0.12, "at %.2f: rms error %.3f", (double)times[i], placed);
        CHECK(placed < 0.25 * endless, "at infinity only %.3f", endless);
    }
    end(&s);
}

static void varnish_shines_as_by_rays(void)
{
    if (!begin(&s, LIGHTS)) return;
    draw(&s, STILL, false, s.drawn[0]);
    s.r.shine = 0.3f;
    lightprobe_gl_restart(s.r.lights.probe);
    draw(&s, STILL, false, s.drawn[1]);
    trace(&s, STILL, s.truth[0]);
    for (int i = 0; i < 3 * s.receivers; i++) s.drawn[1][i / 3][i % 3] -= s.drawn[0][i / 3][i % 3];
    const double all = mean(&s, s.truth[0]);
    const double wrong = difference(&s, s.drawn[1], s.truth[0]) / all;
    test_note("shine %.2f of all, mean of the rays' %.3f, rms difference %.3f of it",
              all / mean(&s, s.drawn[0]), mean(&s, s.drawn[1]) / all, wrong);
    CHECK(wrong < 0.77, "rms difference %.3f", wrong); // 1.44 without any shine
    CHECK(mean(&s, s.drawn[1]) > 0.7 * all && mean(&s, s.drawn[1]) < all, "the mean is wrong");
    end(&s);
}

// Frames of 1/480 of the loop, a 60th of a second of eight. The truth between its frames is
// straight. What differs is less than what moves; most of it is where balls touch the table.
static void nothing_flickers(void)
{
    const float step = 1.0f / 480, start = 0.1f;
    if (!begin(&s, LIGHTS)) return;
    const int every = (FRAMES - 1) / (TRUTHS - 1);
    double worst = 0, steps = 0, unlike = 0;
    for (int i = 0; i < FRAMES; i++) draw(&s, start + step * (float)i, false, s.drawn[i]);
    for (int i = 0; i < TRUTHS; i++) trace(&s, start + step * (float)(i * every), s.truth[i]);
    for (int i = 0; i + 1 < FRAMES; i++) {
        double squares = 0, own = 0;
        for (int j = 0; j < 3 * s.receivers; j++) {
            const double is = (double)(s.drawn[i + 1][j / 3][j % 3] - s.drawn[i][j / 3][j % 3]);
            const double was =
                (double)(s.truth[i / every + 1][j / 3][j % 3] - s.truth[i / every][j / 3][j % 3]) /
                every;
            squares += pow(is - was, 2);
            own += was * was;
        }
        worst = fmax(worst, sqrt(squares / (3 * s.receivers)));
        unlike += squares;
        steps += own;
    }
    const double all = mean(&s, s.truth[0]);
    test_note("from %.1f: steps of the truth %.4f of the mean; what differs %.4f, at most %.4f",
              (double)start, sqrt(steps / (3 * s.receivers) / (FRAMES - 1)) / all,
              sqrt(unlike / (3 * s.receivers) / (FRAMES - 1)) / all, worst / all);
    CHECK(unlike < steps && worst < 0.015 * all, "a step that is %.4f of the mean off",
          worst / all);
    end(&s);
}

// Also on what a lamp has run into, from within which it fills half of all directions.
static void truth_is_finite_within_the_lamp(void)
{
    room world;
    message why = {"no memory"};
    if (!room_create(&world, STILL)) abort();
    world.lamp = vec(room_low.x, 0.73f, 0);
    room_truth *rays = room_truth_create(&world, 0.5f, 2, &why);
    CHECK(rays, "%s", why.text);
    for (int i = 0; i < 5 && rays; i++) {
        const vec3 point = vec(room_low.x + 0.01f, 0.73f, 0.06f * (float)i);
        const vec3 light = room_truth_irradiance(rays, point, vec(1, 0, 0), false, 1);
        CHECK(light.x > 0 && light.x < 1e3f, "%g at %d", (double)light.x, i);
    }
    room_truth_free(rays);
    room_free(&world);
}

const test_case gl_room_tests[] = {
    {"room: the truth is finite within the lamp", truth_is_finite_within_the_lamp},
    {"room GL: things are lit as by rays", things_are_lit_as_by_rays},
    {"room GL: varnish shines as by rays", varnish_shines_as_by_rays},
    {"room GL: nothing flickers that the truth does not", nothing_flickers},
    {0, 0},
};
