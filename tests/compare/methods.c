// The table of methods, and the library's own behind the same interface.
#include "methods.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rivals.h"

// ---- the library's own -------------------------------------------------------------------------

// What a variant of the library's methods stands for: moments of the map, and settings.
typedef struct choice {
    int moments;
    mssm_settings settings;
    bool normals; // the receivers' are handed over
} choice;

enum { LOWER_4, UPPER_4, LOWER_6, UPPER_6, LAYERED_4, LAYERED_6, NORMAL_4, NORMAL_6, CHOICES };

static const choice choices[CHOICES] = {
    {4, {4, MSSM_LOWER_BLOCKER, 0, 0, 0, 0}, false},
    {4, {4, MSSM_UPPER_BLOCKER, 0, 0, 0, 0}, false},
    {6, {6, MSSM_LOWER_BLOCKER, 0, 0, 0, 0}, false},
    {6, {6, MSSM_UPPER_BLOCKER, 0, 0, 0, 0}, false},
    {4, {4, MSSM_LAYERED, 0, 0, 0, 0}, false},
    {6, {6, MSSM_LAYERED, 0, 0, 0, 0}, false},
    {4, {4, MSSM_LAYERED, 0, 0, 0, 0}, true},
    {6, {6, MSSM_LAYERED, 0, 0, 0, 0}, true},
};

typedef struct moment_state {
    mssm_map *map;
    mssm_light light;
    mssm_settings settings;
    bool normals;
    void *memory;
} moment_state;

static void *moment_create(const struct method *m, int side, size_t *bytes)
{
    const choice *c = &choices[m->variant];
    moment_state *p = calloc(1, sizeof *p);
    if (!p) return NULL;
    *bytes = mssm_map_bytes(side, c->moments);
    p->memory = malloc(*bytes);
    p->settings = c->settings;
    p->normals = c->normals;
    if (p->memory && mssm_map_init(&p->map, p->memory, *bytes, side, c->moments) == MSSM_OK) {
        return p;
    }
    free(p->memory);
    free(p);
    return NULL;
}

static void moment_destroy(void *state)
{
    moment_state *p = state;
    free(p->memory);
    free(p);
}

static void moment_update(void *state, const depth_map *map)
{
    moment_state *p = state;
    p->light = *map->light;
    mssm_map_update(p->map, map->front, map->back, 1);
}

static float moment_visibility(const void *state, const float point[3], float bias, unsigned pixel)
{
    const moment_state *p = state;
    (void)bias;
    (void)pixel;
    return mssm_map_visibility(p->map, &p->light, &p->settings, point);
}

static void moment_many(const void *state, int count, const float (*points)[3],
                        const float (*normals)[3], float bias, float *out)
{
    const moment_state *p = state;
    (void)bias;
    mssm_map_visibility_many(p->map, &p->light, &p->settings, count, points,
                             p->normals ? normals : NULL, out);
}

// ---- hard shadows --------------------------------------------------------------------------------

typedef struct filtered_state {
    mssm_filtered *map;
    mssm_light light;
    mssm_filter filter;
    int radius;
    void *memory;
} filtered_state;

static void *filtered_create(int moments, float full_shadow, int radius, int side, size_t *bytes)
{
    filtered_state *p = calloc(1, sizeof *p);
    if (!p) return NULL;
    *bytes = mssm_filtered_bytes(side, moments);
    p->memory = malloc(*bytes);
    p->radius = radius;
    p->filter.full_shadow = full_shadow;
    if (p->memory && !mssm_filtered_init(&p->map, p->memory, *bytes, side, moments)) return p;
    free(p->memory);
    free(p);
    return NULL;
}

static void *filtered_create_4(const struct method *m, int side, size_t *bytes)
{
    return filtered_create(4, 0, m->variant, side, bytes);
}

static void *filtered_create_4_plain(const struct method *m, int side, size_t *bytes)
{
    return filtered_create(4, 1, m->variant, side, bytes);
}

static void *filtered_create_6(const struct method *m, int side, size_t *bytes)
{
    return filtered_create(6, 0, m->variant, side, bytes);
}

static void filtered_destroy(void *state)
{
    filtered_state *p = state;
    free(p->memory);
    free(p);
}

static void filtered_update(void *state, const depth_map *map)
{
    filtered_state *p = state;
    p->light = *map->light;
    mssm_filtered_update(p->map, map->front, 1, p->radius);
}

static float filtered_visibility(const void *state, const float point[3], float bias,
                                 unsigned pixel)
{
    const filtered_state *p = state;
    (void)bias;
    (void)pixel;
    return mssm_filtered_visibility(p->map, &p->light, &p->filter, point, 0);
}

// ---- the tables --------------------------------------------------------------------------------

#define PERCENTAGE_CLOSER \
    percentage_closer_create, percentage_closer_destroy, percentage_closer_update
#define CONVOLUTION \
    convolution_create, convolution_destroy, convolution_update, convolution_visibility
#define CONVOLUTION_MIPS \
    convolution_mips_create, convolution_destroy, convolution_update, convolution_visibility
#define MOMENTS moment_create, moment_destroy, moment_update, moment_visibility

static const char fernando[] = "Fernando 2005, Percentage-Closer Soft Shadows";
static const char isidoro[] = "Isidoro 2006, Shadow Mapping: GPU-based Tips and Techniques";
static const char annen[] = "Annen and others 2008, Real-Time, All-Frequency Shadows in Dynamic "
                            "Scenes";
static const char kneiphof[] = "Kneiphof, Real-Time Image-Based Lighting of Dynamic Scenes with "
                               "Moment Soft Shadow Mapping";
static const char own[] = "docs/moments.md";

const method methods[] = {
    {"hard", "hard", "Williams 1978, Casting Curved Shadows on Curved Surfaces", 1, 0,
     PERCENTAGE_CLOSER, hard_visibility, 4, NULL},
    {"PCF", "PCF", "Reeves, Salesin and Cook 1987, Rendering Antialiased Shadows with Depth Maps",
     1, 0, PERCENTAGE_CLOSER, pcf_visibility, 7, NULL},
    {"PCSS, 16 samples", "PCSS", fernando, 1, 16, PERCENTAGE_CLOSER, pcss_sampled_visibility, 7,
     NULL},
    {"PCSS, 64 samples", "PCSS", fernando, 1, 64, PERCENTAGE_CLOSER, pcss_sampled_visibility, 7,
     NULL},
    {"PCSS, all texels", "PCSS", fernando, 0, 0, PERCENTAGE_CLOSER, pcss_visibility, 7, NULL},
    {"PCSS, all texels in vectors", "PCSS", fernando, 0, 1, PERCENTAGE_CLOSER, pcss_visibility, 7,
     NULL},
    {"PCSS, all texels, normal", "PCSS", isidoro, 0, 1, PERCENTAGE_CLOSER, pcss_visibility, 1,
     pcss_plane_many},
    {"VSM", "VSM", "Donnelly and Lauritzen 2006, Variance Shadow Maps", 1, 0, variance_create,
     variance_destroy, variance_update, variance_visibility, 0, NULL},
    {"VSSM", "VSM", "Yang and others 2010, Variance Soft Shadow Mapping", 1, 0,
     variance_soft_create, variance_destroy, variance_soft_update, variance_soft_visibility, 4,
     NULL},
    {"EVSM", "EVSM", "Lauritzen and McCool 2008, Layered Variance Shadow Maps", 1, 0,
     exponential_create, variance_destroy, exponential_update, exponential_visibility, 0, NULL},
    {CSSM8 CSSM_TABLES, "CSSM", annen, 1, 4, CONVOLUTION, 6, NULL},
    {CSSM16 CSSM_TABLES, "CSSM", annen, 1, 8, CONVOLUTION, 6, NULL},
    {CSSM_ANNEN CSSM_TABLES, "CSSM", annen, 1, 16, CONVOLUTION, 4, NULL},
    {CSSM8 CSSM_MIPS, "CSSM", annen, 1, 4, CONVOLUTION_MIPS, 2, NULL},
    {CSSM16 CSSM_MIPS, "CSSM", annen, 1, 8, CONVOLUTION_MIPS, 2, NULL},
    {CSSM_ANNEN CSSM_MIPS, "CSSM", annen, 1, 16, CONVOLUTION_MIPS, 3, NULL},
    {"back-projection, all texels", "back-projection",
     "Guennebaud, Barthe and Paulin 2006, Real-Time Soft Shadow Mapping by Backprojection", 0, 0,
     PERCENTAGE_CLOSER, back_projection_visibility, 4, NULL},
    {"back-projection, all texels, normal", "back-projection",
     "Guennebaud, Barthe and Paulin 2006, with the bias of Isidoro 2006", 0, 0, PERCENTAGE_CLOSER,
     back_projection_visibility, 1, back_projection_many},
    {"MSSM 4, lower blocker", "MSSM", kneiphof, 1, LOWER_4, MOMENTS, 0, moment_many},
    {"MSSM 4, upper blocker", "MSSM", kneiphof, 1, UPPER_4, MOMENTS, 0, moment_many},
    {"MSSM 6, lower blocker", "MSSM", kneiphof, 1, LOWER_6, MOMENTS, 0, moment_many},
    {"MSSM 6, upper blocker", "MSSM", kneiphof, 1, UPPER_6, MOMENTS, 0, moment_many},
    {"layered, 4 moments", "layered", own, 1, LAYERED_4, MOMENTS, 0, moment_many},
    {"layered, 6 moments", "layered", own, 1, LAYERED_6, MOMENTS, 0, moment_many},
    {"layered, 4 moments, normal", "layered", own, 1, NORMAL_4, MOMENTS, 0, moment_many},
    {"layered, 6 moments, normal", "layered", own, 1, NORMAL_6, MOMENTS, 0, moment_many},
};
const int method_count = (int)(sizeof methods / sizeof *methods);

#define FILTERED filtered_destroy, filtered_update, filtered_visibility

const method hard_methods[] = {
    {"hard", "hard", "Williams 1978, Casting Curved Shadows on Curved Surfaces", 1, 0,
     PERCENTAGE_CLOSER, hard_visibility, 2, NULL},
    {"PCF, Gaussian", "PCF",
     "Reeves, Salesin and Cook 1987, Rendering Antialiased Shadows with Depth Maps", 0, 0,
     gaussian_create, percentage_closer_destroy, percentage_closer_update, gaussian_visibility, 4,
     NULL},
    {"VSM, Gaussian", "VSM", "Donnelly and Lauritzen 2006, Variance Shadow Maps", 1, 0,
     variance_hard_create, variance_destroy, variance_update, variance_visibility, 0, NULL},
    {"EVSM, Gaussian", "VSM", "Lauritzen and McCool 2008, Layered Variance Shadow Maps", 1, 0,
     exponential_hard_create, variance_destroy, exponential_hard_update,
     exponential_hard_visibility, 0, NULL},
    {"EVSM, Gaussian, 64 bits", "VSM", "Lauritzen and McCool 2008, Layered Variance Shadow Maps", 1,
     0, exponential_half_create, variance_destroy, exponential_half_update,
     exponential_half_visibility, 0, NULL},
    {"filtered, 4 moments of 32-bit floats", "VSM", "Peters and Klein 2015, Moment Shadow Mapping",
     1, 0, moments_float_create, variance_destroy, moments_float_update, moments_float_visibility,
     0, NULL},
    {"filtered, 4 moments", "filtered", "docs/filtered.md", 1, 0, filtered_create_4, FILTERED, 0,
     NULL},
    {"filtered, 4 moments, full_shadow 1", "filtered", "docs/filtered.md", 1, 0,
     filtered_create_4_plain, FILTERED, 0, NULL},
    {"filtered, 6 moments", "filtered", "docs/filtered.md", 1, 0, filtered_create_6, FILTERED, 0,
     NULL},
};
const int hard_method_count = (int)(sizeof hard_methods / sizeof *hard_methods);

const method *method_named(const char *name)
{
    for (int i = 0; i < method_count; i++) {
        if (!strcmp(methods[i].name, name)) return &methods[i];
    }
    for (int i = 0; i < hard_method_count; i++) {
        if (!strcmp(hard_methods[i].name, name)) return &hard_methods[i];
    }
    return NULL;
}
