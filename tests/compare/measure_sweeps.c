// What changes with the width of the kernel, the side of the map, time, and the library's settings.
#include "measure.h"

#include "../support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static bool is_there(const measurement *m, int which)
{
    compare_case c;
    message missing;
    if (!case_make(&c, which, m->data, &missing)) {
        say("  a scene is left out: %s", missing.text);
        return false;
    }
    case_free(&c);
    return true;
}

// ---- Kernel --------------------------------------------------------------------------------

enum { KERNEL_SIDE = 256, KERNEL_RECEIVERS = 2000 };

// Small tiles at random heights over all of the map, three texels wide, three apart: receivers on
// the ground below are half lit at every kernel width, and no method gets away with an early out.
static bool make_tiles(compare_case *c, message *why)
{
    enum { TILES = KERNEL_SIDE / 6 };
    uint64_t state = 11;
    memset(c, 0, sizeof *c);
    strcpy(c->name, "tiles");
    scene_begin_object(&c->scene, 0.5f, 0.5f, 0.5f);
    for (int i = 0; i < TILES * TILES; i++) {
        const float texel = 4.0f / KERNEL_SIDE, y = (float)test_range(&state, 0.05, 1);
        const float x = 6 * texel * ((float)(i % TILES) + 0.5f) - 2;
        const float z = 6 * texel * ((float)(i / TILES) + 0.5f) - 2;
        const scene_frame f = scene_frame_at(vec(x, y, z), 0, 0);
        scene_put_box(&c->scene, &f, vec(1.5f * texel, 0.2f * texel, 1.5f * texel));
    }
    c->sun = vec(0, 1, 0);
    return scene_end(&c->scene) || fail(why, "no memory for tiles");
}

// Receivers on the ground under the inner part of the tiles.
static void fill_tiles(receiver *r)
{
    uint64_t state = 12;
    for (int i = 0; i < KERNEL_RECEIVERS; i++) {
        r[i].point.x = (float)test_range(&state, -1.9, 1.9);
        r[i].point.y = 0;
        r[i].point.z = (float)test_range(&state, -1.9, 1.9);
        r[i].normal = vec(0, 1, 0);
        r[i].truth = r[i].noise = 0;
    }
}

// Texels that a light with a half-angle tangent of 1 covers at the near plane, seen from the
// ground.
static float widest(const compare_case *c)
{
    mssm_light light;
    float shadow[3] = {0, 0, 0};
    const float origin[3] = {0, 0, 0};
    if (case_light(c, 1, 1, &light) || !mssm_light_project(&light, origin, shadow)) return 1;
    const float distance = 0.5f * (shadow[2] + 1) * (light.z_far - light.z_near);
    return distance / light.extent_u * KERNEL_SIDE;
}

bool measure_kernel(measurement *m, message *why)
{
    static const int widths[] = {9, 15, 27, 51, 101, 151, 255};
    static receiver r[KERNEL_RECEIVERS];
    compare_case c;
    bench b;
    if (!measure_biases(m, why) || !make_tiles(&c, why)) return false;
    bool done = bench_create(&b, KERNEL_SIDE, why);
    fill_tiles(r);
    const float texels = widest(&c);
    for (size_t k = 0; k < sizeof widths / sizeof *widths && done; k++) {
        spread ns[METHODS_MOST];
        done = bench_update(&b, &c, (float)widths[k] / texels, why);
        if (!done) break;
        bench_time(&b, m->bias, r, KERNEL_RECEIVERS, m->quick ? 3 : 9, ns);
        for (int i = 0; i < method_count; i++)
            put(m, "kernel", c.name, methods[i].name, widths[k], "ns", ns[i].value, ns[i].low,
                ns[i].high);
    }
    bench_free(&b);
    case_free(&c);
    return done;
}

// ---- Side of the map -----------------------------------------------------------------------

enum { SIDE_CASES = 4, SIDE_RECEIVERS = 1000 };
static const int side_cases[SIDE_CASES] = {0, 3, 4, 10};

typedef struct side_sum {
    double rms[METHODS_MOST], ns[METHODS_MOST];
    int cases;
} side_sum;

static bool side_case(measurement *m, bench *b, int which, side_sum *sum, message *why)
{
    static receiver r[SIDE_RECEIVERS];
    static float value[(METHODS_MOST + 1) * SIDE_RECEIVERS];
    compare_case c;
    spread ns[METHODS_MOST];
    if (!case_make(&c, which, m->data, why)) return false;
    const int count = m->quick ? SIDE_RECEIVERS / 10 : SIDE_RECEIVERS;
    bool done = bench_update(b, &c, 0.1f, why);
    if (done && !case_receivers(&c, &b->light, count, m->quick ? 256 : 576, 3, r))
        done = fail(why, "%s: no receivers", c.name);
    case_free(&c);
    if (!done) return false;
    bench_evaluate(b, m->bias, r, count, value);
    bench_time(b, m->bias, r, count, 3, ns);
    for (int i = 0; i < method_count; i++) {
        sum->rms[i] += errors_of(value + i * count, r, count, value + method_count * count).rms;
        sum->ns[i] += ns[i].value;
    }
    sum->cases++;
    return true;
}

// Milliseconds that a new depth map costs a method. Some do next to nothing, too little for the
// clock.
static double update_ms(const bench *b, int which)
{
    int repeats = 1;
    for (;;) {
        const double start = cpu_seconds();
        const depth_map map = bench_map(b, &methods[which]);
        for (int i = 0; i < repeats; i++) methods[which].update(b->state[which], &map);
        const double seconds = cpu_seconds() - start;
        if (seconds > 1e-4 || repeats > 100000) return 1e3 * seconds / repeats;
        repeats *= 10;
    }
}

// In rounds over all methods.
static void side_updates(measurement *m, const bench *b)
{
    static double times[METHODS_MOST][ROUNDS_MOST];
    const int rounds = m->quick ? 3 : 7;
    for (int round = 0; round < rounds; round++) {
        for (int i = 0; i < method_count; i++) times[i][round] = update_ms(b, i);
    }
    for (int i = 0; i < method_count; i++) {
        const spread s = spread_of(times[i], rounds);
        if (!is_followed(methods[i].name)) continue;
        put(m, "side", "all", methods[i].name, b->side, "update_ms", s.value, s.low, s.high);
    }
}

static bool one_side(measurement *m, int side, message *why)
{
    bench b;
    side_sum sum;
    memset(&sum, 0, sizeof sum);
    bool done = bench_create(&b, side, why);
    for (int k = 0; k < SIDE_CASES && done; k++) done = side_case(m, &b, side_cases[k], &sum, why);
    if (done) side_updates(m, &b);
    for (int i = 0; i < method_count && done; i++) {
        const double rms = sum.rms[i] / sum.cases, ns = sum.ns[i] / sum.cases;
        const double bytes = (double)b.bytes[i];
        if (side == 256 || is_followed(methods[i].name))
            put(m, "side", "all", methods[i].name, side, "bytes", bytes, bytes, bytes);
        if (!is_followed(methods[i].name)) continue;
        put(m, "side", "all", methods[i].name, side, "rms", rms, rms, rms);
        put(m, "side", "all", methods[i].name, side, "ns", ns, ns, ns);
    }
    bench_free(&b);
    return done;
}

bool measure_side(measurement *m, message *why)
{
    static const int sides[] = {64, 128, 256, 512, 1024};
    bool done = measure_biases(m, why);
    for (int k = 0; k < (m->quick ? 4 : 5) && done; k++) done = one_side(m, sides[k], why);
    return done;
}

// ---- Moving sequences ----------------------------------------------------------------------

enum { STEPS = 10, STEP_RECEIVERS = 400, STEP_CASES = 5 };
static const int step_cases[STEP_CASES] = {0, 2, 3, 4, 10};

typedef struct sequence {
    receiver r[STEP_RECEIVERS];
    float value[2][METHODS_MOST * STEP_RECEIVERS]; // this step's and the last one's
    float truth[2][STEP_RECEIVERS];
    double squares[METHODS_MOST], truth_squares, noise_squares;
    int steps;
} sequence;

// Differences between this step and the last.
static void add_step(sequence *q, int step, int count)
{
    const float *now = q->truth[step & 1], *before = q->truth[~step & 1];
    q->steps += count;
    for (int k = 0; k < count; k++) {
        const double d = (double)now[k] - (double)before[k];
        q->truth_squares += d * d;
        q->noise_squares += 2 * (double)q->r[k].noise * (double)q->r[k].noise;
        for (int i = 0; i < method_count; i++) {
            const float *v = q->value[step & 1], *w = q->value[~step & 1];
            const double e = (double)v[i * count + k] - (double)w[i * count + k] - d;
            q->squares[i] += e * e;
        }
    }
}

static bool run_sequence(measurement *m, bench *b, int which, float tangent, sequence *q,
                         message *why)
{
    const int count = m->quick ? STEP_RECEIVERS / 4 : STEP_RECEIVERS;
    const int rays = m->quick ? 576 : 1296, steps = m->quick ? STEPS / 2 : STEPS;
    bool done = true;
    memset(q, 0, sizeof *q);
    for (int step = 0; step < steps && done; step++) {
        compare_case c;
        if (!case_make_step(&c, which, step, m->data, why)) return false;
        done = bench_update(b, &c, tangent, why);
        if (done && step == 0 && !case_receivers(&c, &b->light, count, 4, 7, q->r))
            done = fail(why, "%s: no receivers", c.name);
        // The same rays at every step: their noise mostly cancels in the differences.
        if (done) case_truth(&c, &b->light, count, rays, 7, q->r);
        if (done) bench_evaluate(b, m->bias, q->r, count, q->value[step & 1]);
        for (int k = 0; k < count; k++) q->truth[step & 1][k] = q->r[k].truth;
        if (done && step > 0) add_step(q, step, count);
        case_free(&c);
    }
    return done;
}

static void put_sequence(measurement *m, const char *name, double x, const sequence *q)
{
    const double steps = q->steps, truth = sqrt(q->truth_squares / steps);
    const double noise = sqrt(q->noise_squares / steps);
    const char *where = x > 0 ? "temporal" : "overall";
    put(m, where, name, "truth", x, "step_rms", truth, truth, truth);
    if (x <= 0) put(m, "truth", name, where, x, "noise", noise, noise, noise);
    for (int i = 0; i < method_count; i++) {
        if (strcmp(name, "all") && !is_followed(methods[i].name)) continue;
        const double rms = sqrt(q->squares[i] / steps);
        put(m, where, name, methods[i].name, x, "step_rms", rms, rms, rms);
    }
}

static void add_sequence(sequence *sum, const sequence *q)
{
    for (int i = 0; i < method_count; i++) sum->squares[i] += q->squares[i];
    sum->truth_squares += q->truth_squares;
    sum->noise_squares += q->noise_squares;
    sum->steps += q->steps;
}

bool measure_temporal(measurement *m, message *why)
{
    static const float sizes[] = {0.05f, 0.1f, 0.4f};
    static sequence q, of_size, all;
    bench b;
    if (!measure_biases(m, why)) return false;
    bool done = bench_create(&b, 256, why);
    memset(&all, 0, sizeof all);
    for (int l = m->quick ? 1 : 0; l < 3 && done; l++) {
        memset(&of_size, 0, sizeof of_size);
        for (int k = 0; k < STEP_CASES && done; k++) {
            compare_case c;
            done = run_sequence(m, &b, step_cases[k], sizes[l], &q, why) &&
                   case_make(&c, step_cases[k], m->data, why);
            if (!done) break;
            put_sequence(m, c.name, (double)sizes[l], &q);
            case_free(&c);
            add_sequence(&of_size, &q);
        }
        if (!done) break;
        put_sequence(m, "all", (double)sizes[l], &of_size);
        add_sequence(&all, &of_size);
    }
    if (done) put_sequence(m, "all", 0, &all);
    bench_free(&b);
    return done;
}

// ---- Settings ------------------------------------------------------------------------------

enum { SETTING_SIDE = 256, SETTING_RECEIVERS = 1000, SETTINGS = 8 };

typedef struct setting {
    const char *name;
    mssm_settings settings;
    bool back_faces;
} setting;

static const setting all_settings[SETTINGS] = {
    {"default", {0, MSSM_LAYERED, 0, 0, 0, 0}, false},
    {"4 moments", {4, MSSM_LAYERED, 0, 0, 0, 0}, false},
    {"tolerance 1/64", {0, MSSM_LAYERED, 0, 0, 0, 1.0f / 64}, false},
    {"tolerance 1/16", {0, MSSM_LAYERED, 0, 0, 0, 1.0f / 16}, false},
    {"tolerance 1/4096", {0, MSSM_LAYERED, 0, 0, 0, 1.0f / 4096}, false},
    {"max_kernel 27", {0, MSSM_LAYERED, 0, 0, 27, 0}, false},
    {"max_kernel 81", {0, MSSM_LAYERED, 0, 0, 81, 0}, false},
    {"back faces where closed", {0, MSSM_LAYERED, 0, 0, 0, 0}, true},
};

// Two maps of one case, without and with back faces.
typedef struct setting_maps {
    mssm_map *map[2];
    void *memory[2];
    float *front, *back;
} setting_maps;

static bool setting_maps_create(setting_maps *s, message *why)
{
    const size_t bytes = mssm_map_bytes(SETTING_SIDE, 6);
    const size_t texels = SETTING_SIDE * SETTING_SIDE;
    s->front = malloc(texels * sizeof *s->front);
    s->back = malloc(texels * sizeof *s->back);
    bool made = s->front && s->back;
    for (int i = 0; i < 2; i++) {
        s->memory[i] = malloc(bytes);
        made = made && s->memory[i] &&
               mssm_map_init(&s->map[i], s->memory[i], bytes, SETTING_SIDE, 6) == MSSM_OK;
    }
    return made || fail(why, "no memory for maps");
}

static void setting_maps_free(setting_maps *s)
{
    free(s->front);
    free(s->back);
    free(s->memory[0]);
    free(s->memory[1]);
}

typedef struct setting_sums {
    double rms[SETTINGS], ns[SETTINGS];
    int cases;
} setting_sums;

static float ask_setting(const setting_maps *s, const mssm_light *light, int k, const receiver *r)
{
    const float point[3] = {r->point.x, r->point.y, r->point.z};
    const setting *t = &all_settings[k];
    return mssm_map_visibility(s->map[t->back_faces], light, &t->settings, point);
}

// Errors and interleaved times of all settings over the receivers of one case.
static void compare_settings(const setting_maps *s, const mssm_light *light, const receiver *r,
                             int count, setting_sums *sums)
{
    static float value[SETTING_RECEIVERS], scratch[SETTING_RECEIVERS];
    enum { ROUNDS = 7 };
    double times[SETTINGS][ROUNDS];
    double rms[SETTINGS];
    for (int round = 0; round < ROUNDS; round++) {
        for (int k = 0; k < SETTINGS; k++) {
            const double start = cpu_seconds();
            for (int i = 0; i < count; i++) value[i] = ask_setting(s, light, k, &r[i]);
            times[k][round] = 1e9 * (cpu_seconds() - start) / count;
            rms[k] = errors_of(value, r, count, scratch).rms;
        }
    }
    for (int k = 0; k < SETTINGS; k++) {
        sums->rms[k] += rms[k];
        sums->ns[k] += spread_of(times[k], ROUNDS).value;
    }
    sums->cases++;
}

static bool setting_case(measurement *m, const setting_maps *s, int which, float tangent,
                         setting_sums *sums, message *why)
{
    static receiver r[SETTING_RECEIVERS];
    const int count = m->quick ? SETTING_RECEIVERS / 8 : SETTING_RECEIVERS;
    compare_case c;
    mssm_light light;
    if (!case_make(&c, which, m->data, why)) return false;
    bool done = case_light(&c, tangent, tangent, &light) == MSSM_OK &&
                case_depth(&c, &light, SETTING_SIDE, s->front, s->back) &&
                mssm_map_update(s->map[0], s->front, NULL, 1) == MSSM_OK &&
                mssm_map_update(s->map[1], s->front, c.closed ? s->back : NULL, 1) == MSSM_OK;
    if (!done) fail(why, "%s: no map", c.name);
    // Lights too large for a case are left out, as in the experiment on errors.
    if (done && case_receivers(&c, &light, count, m->quick ? 256 : 484, 5, r))
        compare_settings(s, &light, r, count, sums);
    case_free(&c);
    return done;
}

bool measure_setting(measurement *m, message *why)
{
    static const float sizes[] = {0.05f, 0.2f, 0.4f};
    setting_maps s = {{NULL, NULL}, {NULL, NULL}, NULL, NULL};
    setting_sums sums;
    memset(&sums, 0, sizeof sums);
    bool done = setting_maps_create(&s, why);
    for (int which = 0; which < CASE_COUNT && done; which++) {
        if (!is_there(m, which)) continue;
        for (int l = m->quick ? 1 : 0; l < (m->quick ? 2 : 3) && done; l++)
            done = setting_case(m, &s, which, sizes[l], &sums, why);
    }
    setting_maps_free(&s);
    for (int k = 0; k < SETTINGS && done; k++) {
        const double rms = sums.rms[k] / sums.cases, ns = sums.ns[k] / sums.cases;
        put(m, "setting", "all", all_settings[k].name, 0, "rms", rms, rms, rms);
        put(m, "setting", "all", all_settings[k].name, 0, "ns", ns, ns, ns);
    }
    return done;
}
