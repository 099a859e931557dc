// Convolution soft shadows (Annen and others 2008): the depth comparison as a Fourier series whose
// terms are filtered by summed-area tables or mip maps, for the average blocker depth and for the
// shadow.
#include "mip_maps.h"
#include "rivals.h"

enum { TERMS_MAX = 16 };

// What the paper leaves to its reader, for tables and mip maps, by the number of terms: the least mean
// error over the chart's scenes, by coordinate descent at other receivers than the chart's. Sharpening
// then does nothing or next to it: the strengths that the paper's pictures use (A = 30, B = 20, a scale that
// puts all ringing outside of [0,1]) make shadows darker and sharper, at 1.6 times the error.
static const convolution_tuning tunings[2][3] = {
    {{1, 0.152f, 0.037f, 1.026f, 0.013f, 0, 0, 0, 0},
     {1, 0.084f, 0.0155f, 0.971f, 0.0066f, 0, 0, 0, 0},
     {0.969f, 0.121f, 0.014f, 0.976f, 0.0115f, 0.52f, 0, 0, 0}},
    {{1, 0.136f, 0.052f, 1.041f, 0.077f, 0, 0.15f, 0.4f, 1.48f},
     {1, 0.084f, 0.0325f, 0.971f, 0.0195f, 0, 0, 0, 1.13f},
     {0.97f, 0.112f, 0.0227f, 0.976f, 0.0163f, 0.1f, 0, 0, 1.06f}}};

typedef struct state {
    view view;
    convolution_tuning set;
    int terms;
    bool empty;              // no casters at all
    float nearest, range;    // depths of casters
    float weight[TERMS_MAX]; // of the terms
    float to_stored, from_stored;
    int32_t *shadow, *depths, *plain; // tables of cos and sin; of u cos and u sin; of u
    mip_maps mips;                    // instead of them
} state;

static void tables_free(state *p)
{
    free(p->shadow);
    free(p->depths);
    free(p->plain);
}

static void tune_best(state *p, int mips)
{
    convolution_tune(p, &tunings[mips][p->terms <= 4 ? 0 : p->terms <= 8 ? 1 : 2]);
}

// Tables hold 4 terms + 1 numbers a texel, 32 bits as in the paper. Float tables of that size are
// off by a grey level and more (Hensley and others 2005), so they are integers, scaled such that
// the sum of the whole map fits: turned waves may be 1 + 4e-7, so with some room.
void *convolution_create(const struct method *m, int side, size_t *bytes)
{
    state *p = view_create(sizeof *p, side);
    if (!p) return NULL;
    const size_t entries = (size_t)(side + 1) * (size_t)(side + 1),
                 channels = 2 * (size_t)m->variant;
    p->terms = m->variant;
    p->to_stored = floorf(2147400000.0f / ((float)side * (float)side));
    p->from_stored = 1 / p->to_stored;
    p->shadow = calloc(entries * channels, sizeof *p->shadow);
    p->depths = calloc(entries * channels, sizeof *p->depths);
    p->plain = calloc(entries, sizeof *p->plain);
    if (!p->shadow || !p->depths || !p->plain) {
        convolution_destroy(p);
        return NULL;
    }
    tune_best(p, 0);
    *bytes = entries * (2 * channels + 1) * sizeof(int32_t);
    return p;
}

void *convolution_mips_create(const struct method *m, int side, size_t *bytes)
{
    state *p = view_create(sizeof *p, side);
    if (!p) return NULL;
    p->terms = m->variant;
    if (!mip_maps_create(&p->mips, side, 2 * p->terms, bytes)) {
        convolution_destroy(p);
        return NULL;
    }
    tune_best(p, 1);
    return p;
}

void convolution_tune(void *state_, const convolution_tuning *to)
{
    state *p = state_;
    p->set = *to;
    for (int k = 0; k < p->terms; k++) {
        const float order = (float)k / (float)p->terms;
        p->weight[k] = p->set.scale * 2 / (3.14159265f * (float)(2 * k + 1));
        if (to->damping > 0) p->weight[k] *= expf(-to->damping * order * order);
    }
}

void convolution_destroy(void *state_)
{
    state *p = state_;
    tables_free(p);
    mip_maps_free(&p->mips);
    view_destroy(state_);
}

// cos and sin of the odd multiples of pi u, one turn by 2 pi u after the other.
static void waves_of(float u, int terms, float *wave)
{
    const float angle = 3.14159265f * u;
    float c = cosf(angle), s = sinf(angle);
    const float turn_c = c * c - s * s, turn_s = 2 * c * s;
    for (int k = 0; k < terms; k++) {
        wave[2 * k] = c;
        wave[2 * k + 1] = s;
        const float next = c * turn_c - s * turn_s;
        s = s * turn_c + c * turn_s;
        c = next;
    }
}

// ---- tables ------------------------------------------------------------------------------------

static void find_range(state *p)
{
    const float range = view_range(&p->view, &p->nearest);
    p->empty = p->nearest >= 1;
    p->range = most(range, 1e-3f);
}

// Depth in half periods of the series. Empty texels are drawn up to the casters, and receivers
// behind all casters to halfway between the two.
static float phase_of(const state *p, float depth)
{
    return p->set.period * limited(depth, 0, 1 + p->set.gap) / (1 + p->set.gap);
}

static float phase_of_texel(const state *p, float z)
{
    return z < 1 ? phase_of(p, (most(z, -1) - p->nearest) / p->range) : p->set.period;
}

static float phase_of_receiver(const state *p, float z)
{
    const float depth = (z - p->nearest) / p->range - p->set.offset;
    return phase_of(p, least(depth, 1 + 0.5f * p->set.gap));
}

static void add_texel(state *p, size_t at, size_t above, float u, int32_t *running)
{
    const size_t n = 2 * (size_t)p->terms;
    float wave[2 * TERMS_MAX];
    waves_of(u, p->terms, wave);
    const int32_t *from = p->shadow + above * n, *from_depths = p->depths + above * n;
    int32_t *to = p->shadow + at * n, *to_depths = p->depths + at * n;
    for (size_t c = 0; c < n; c++) {
        running[c] += (int32_t)(wave[c] * p->to_stored);
        running[n + c] += (int32_t)(wave[c] * u * p->to_stored);
        to[c] = from[c] + running[c];
        to_depths[c] = from_depths[c] + running[n + c];
    }
    running[2 * n] += (int32_t)(u * p->to_stored);
    p->plain[at] = p->plain[above] + running[2 * n];
}

static void update_mips(state *p)
{
    const size_t texels = (size_t)p->view.side * (size_t)p->view.side;
    float wave[2 * TERMS_MAX];
    for (size_t i = 0; i < texels; i++) {
        const float u = phase_of_texel(p, p->view.depth[i]);
        waves_of(u, p->terms, wave);
        mip_maps_set(&p->mips, i, wave, u);
    }
    mip_maps_build(&p->mips);
}

void convolution_update(void *state_, const depth_map *map)
{
    state *p = state_;
    view_update(&p->view, map);
    find_range(p);
    if (p->mips.levels) {
        update_mips(p);
        return;
    }
    const size_t side = (size_t)p->view.side;
    for (size_t y = 0; y < side; y++) {
        int32_t running[4 * TERMS_MAX + 1] = {0};
        for (size_t x = 0; x < side; x++) {
            const size_t at = (y + 1) * (side + 1) + x + 1;
            const float u = phase_of_texel(p, p->view.depth[y * side + x]);
            add_texel(p, at, at - side - 1, u, running);
        }
    }
}

// ---- lookups -----------------------------------------------------------------------------------

// A rectangle of three by three parts: where the table holds their corners, and weights that make a
// mean of their sums.
// Or the square of mip maps that is as large.
typedef struct lookup {
    size_t x[4], y[4];
    float weight_x[3], weight_y[3];
    float outside; // share of the rectangle that lies beside the map
    mip_read mips;
} lookup;

static lookup lookup_of(const state *p, const place *r, kernel k)
{
    if (p->mips.levels) {
        const float level = 0.5f * log2f(4 * k.u * k.v) - p->set.finer;
        const mip_read mips = mip_maps_read(&p->mips, r->x, r->y, level);
        return (lookup){.mips = mips, .outside = mips.outside};
    }
    const strips x = strips_of(r->x, k.u, p->view.side), y = strips_of(r->y, k.v, p->view.side);
    const float scale = p->from_stored / (x.width * y.width);
    lookup l = {.weight_x = {x.first, 1, x.last},
                .weight_y = {scale * y.first, scale, scale * y.last}};
    for (int i = 0; i < 4; i++) {
        l.x[i] = (size_t)x.edge[i];
        l.y[i] = (size_t)y.edge[i] * ((size_t)p->view.side + 1);
    }
    l.outside = 1 - x.inside * y.inside / (x.width * y.width);
    return l;
}

// Means of so many channels, a multiple of four. Differences are taken as integers, exactly.
static void means_of(const lookup *l, const int32_t *table, size_t channels, float *mean)
{
    for (size_t first = 0; first < channels; first += LANES) {
        floats sum = {0};
        for (int j = 0; j < 3; j++) {
            const int32_t *low = table + l->y[j] * channels + first;
            const int32_t *high = table + l->y[j + 1] * channels + first;
            ints column =
                load_ints(high + l->x[0] * channels) - load_ints(low + l->x[0] * channels);
            floats row = {0};
            for (int i = 0; i < 3; i++) {
                const size_t at = l->x[i + 1] * channels;
                const ints next = load_ints(high + at) - load_ints(low + at);
                row += all_of(l->weight_x[i]) * __builtin_convertvector(next - column, floats);
                column = next;
            }
            sum += all_of(l->weight_y[j]) * row;
        }
        memcpy(mean + first, &sum, sizeof sum);
    }
}

static float mean_phase(const state *p, const lookup *l)
{
    float mean = 0;
    if (p->mips.levels) return mip_maps_phase(&p->mips, &l->mips);
    for (int j = 0; j < 3; j++) {
        const int32_t *low = p->plain + l->y[j], *high = p->plain + l->y[j + 1];
        for (int i = 0; i < 3; i++) {
            const size_t a = l->x[i], b = l->x[i + 1];
            const int32_t part = (high[b] - low[b]) - (high[a] - low[a]);
            mean += l->weight_y[j] * l->weight_x[i] * (float)part;
        }
    }
    return mean;
}

// The series for "nearer than the receiver", less its constant (Eq. 10): own are the receiver's
// waves, mean the filtered ones.
static float series(const state *p, const float *own, const float *mean)
{
    float sum = 0;
    for (int k = 0; k < p->terms; k++) {
        sum += p->weight[k] * (own[2 * k + 1] * mean[2 * k] - own[2 * k] * mean[2 * k + 1]);
    }
    return sum;
}

// The same for the empty texels beside the map.
static float series_empty(const state *p, const float *own)
{
    float wave[2 * TERMS_MAX];
    waves_of(p->set.period, p->terms, wave);
    return series(p, own, wave);
}

// Share of the rectangle that blocks: the complement of the shadow test.
static float blocked_share(const state *p, const lookup *l, const float *own)
{
    float mean[2 * TERMS_MAX];
    if (p->mips.levels)
        mip_maps_waves(&p->mips, &l->mips, mean);
    else
        means_of(l, p->shadow, 2 * (size_t)p->terms, mean);
    const float beside = l->outside > 0 ? l->outside * series_empty(p, own) : 0;
    return 0.5f - p->set.shift + series(p, own, mean) + beside;
}

// The same times the phase of what blocks, Eq. 11: the very same series, or their ratio would be
// off where little blocks.
static float blocked_phase(const state *p, const lookup *l, const float *own)
{
    float mean[2 * TERMS_MAX];
    if (p->mips.levels)
        mip_maps_weighted(&p->mips, &l->mips, mean);
    else
        means_of(l, p->depths, 2 * (size_t)p->terms, mean);
    const float beside = l->outside > 0 ? l->outside * series_empty(p, own) : 0;
    const float constant = (0.5f - p->set.shift) * (mean_phase(p, l) + l->outside * p->set.period);
    return constant + series(p, own, mean) + beside * p->set.period;
}

float convolution_visibility(const void *state_, const float point[3], float bias, unsigned pixel)
{
    const state *p = state_;
    const convolution_tuning *set = &p->set;
    place r;
    (void)pixel;
    if (p->empty || !place_of(&p->view, point, bias, &r)) return 1;
    const float u = phase_of_receiver(p, r.z);
    float own[2 * TERMS_MAX];
    waves_of(u, p->terms, own);

    lookup l = lookup_of(p, &r, kernel_of(&p->view, &r, -1));
    const float found = blocked_share(p, &l, own);
    if (found <= 1e-3f) return 1;
    const float average = limited(blocked_phase(p, &l, own) / found, 0, u); // Eq. 6

    const float blocker = p->nearest + average * p->range * (1 + set->gap) / set->period;
    l = lookup_of(p, &r, kernel_of(&p->view, &r, blocker));
    const float lit = limited(1 - blocked_share(p, &l, own), 0, 1);
    const float distance = (r.z - blocker) / p->range;       // in depths of the map
    return powf(lit, 1 + set->a * expf(-set->b * distance)); // Eq. 9
}
