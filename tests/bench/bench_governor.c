// What a frame of each rung of governor_ladder costs the GPU against the cheapest: the costs in
// examples/common/governor.c are from here. Medians of rounds in which rung and cheapest take
// turns.
//     build/release/bench_governor [WIDTH [ROUNDS]]
#include "../../examples/common/gl_context.h"
#include "../../examples/common/gl_lighting.h"
#include "../../examples/common/governor.h"

#include <stdio.h>
#include <stdlib.h>

enum { PROBE_SIDE = 128, ROUNDS_MOST = 31 };

// What a rung draws with.
typedef struct rung {
    lighting lights;
    gl_lighting gl;
} rung;

static void rung_close(rung *r)
{
    gl_lighting_free(&r->gl);
    lighting_free(&r->lights);
}

static bool rung_open(rung *r, const quality *q, const probe *p, int width, message *why)
{
    const lighting_settings settings = {
        .probe = {.max_lights = q->lights},
        .shadows = {.moments = q->moments, .estimator = q->estimator},
        .map_side = q->map_side,
        .map_samples = 4};
    *r = (rung){.gl = {.ordered = NULL}};
    if (!lighting_create(&r->lights, &settings, PROBE_SIDE, why) ||
        !lighting_extract(&r->lights, p, why) ||
        !gl_lighting_create(&r->gl, &r->lights, gl_context_function, width, width * 9 / 16, why)) {
        rung_close(r);
        return false;
    }
    gl_probe_upload(&r->gl.probe, p->face, p->side);
    return true;
}

// Milliseconds of the GPU; below 0 on failure.
static double draw(rung *r, const scene *s, message *why)
{
    const camera eye = camera_look(vec(0.3f, 2.25f, 7.7f), vec(-0.05f, 0.86f, 0), 0.57f, 16.0f / 9);
    double seconds = 0;
    if (!gl_lighting_draw_maps(&r->gl, &r->lights, s, why)) return -1;
    gl_lighting_draw_view(&r->gl, s, &eye);
    gl_target_begin(&r->gl.picture);
    gl_lighting_shade(&r->gl, 0, &r->lights, &eye);
    gl.Finish();
    for (int i = GL_LIGHTING_DEPTH; i <= GL_LIGHTING_SHADING; i++)
        seconds += gl_lighting_seconds(&r->gl, i);
    return 1e3 * seconds;
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

static bool measure(rung *cheapest, rung *r, const scene *s, int rounds, const quality *q,
                    message *why)
{
    double ratio[ROUNDS_MOST], ms[ROUNDS_MOST];
    if (draw(cheapest, s, why) < 0 || draw(r, s, why) < 0) return false; // compiles what has to be
    for (int i = 0; i < rounds; i++) {
        ms[i] = draw(r, s, why);
        ratio[i] = ms[i] / draw(cheapest, s, why);
    }
    qsort(ratio, (size_t)rounds, sizeof *ratio, compare);
    qsort(ms, (size_t)rounds, sizeof *ms, compare);
    printf("%2d lights, maps of %3d, %d moments, estimator %d: %6.2f (%.2f to %.2f), %.1f ms\n",
           q->lights, q->map_side, q->moments, (int)q->estimator, ratio[rounds / 2],
           ratio[rounds / 4], ratio[rounds - 1 - rounds / 4], ms[rounds / 2]);
    return true;
}

int main(int argc, char **argv)
{
    const int width = argc > 1 ? atoi(argv[1]) : 480, asked = argc > 2 ? atoi(argv[2]) : 5;
    const int rounds = asked < 1 ? 1 : asked < ROUNDS_MOST ? asked : ROUNDS_MOST;
    const char *missing = "";
    static rung cheapest, r;
    static probe p;
    static scene s;
    gl_context context;
    message why = {"no memory"};
    if (!gl_context_create(&context, &missing)) {
        printf("no frames of the governor: %s\n", missing);
        return 0;
    }
    bool done = probe_default(&p, PROBE_SIDE) && scene_create(&s, 0, NULL) &&
                rung_open(&cheapest, &governor_ladder[0], &p, width, &why);
    for (int i = 0; i < governor_ladder_levels && done; i++) {
        done = rung_open(&r, &governor_ladder[i], &p, width, &why) &&
               measure(&cheapest, &r, &s, rounds, &governor_ladder[i], &why);
        rung_close(&r);
    }
    if (!done) fprintf(stderr, "bench_governor: %s\n", why.text);
    rung_close(&cheapest);
    scene_free(&s);
    probe_free(&p);
    gl_context_destroy(&context);
    return done ? 0 : 1;
}
