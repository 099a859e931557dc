// The way from a probe to a lit picture: probe -> area lights -> depth maps -> moment maps ->
// shading.
#ifndef LIGHTING_H
#define LIGHTING_H

#include "../../lightprobe.h"
#include "../../mssm.h"
#include "probe.h"
#include "raster.h"
#include "raytrace.h"

typedef struct lighting_settings {
    lightprobe_settings probe;
    mssm_settings shadows;
    int map_side, map_samples; // lights narrower than LIGHTING_NARROW get maps of twice the side
    bool back_faces;           // average front and back depths, which only closed meshes bear
} lighting_settings;

// Half-angle tangent below which a shadow's edges are sharp enough to show the texels of its map.
#define LIGHTING_NARROW 0.08f

typedef struct lighting {
    lighting_settings settings;
    lightprobe_light *light;
    int lights;
    lightprobe_stats stats;
    mssm_light *frustum; // one per light, like the maps
    mssm_map **map;
    // Memory of the maps and of the light extraction; the libraries allocate nothing themselves.
    void **map_memory; // one block per light
    void *scratch;
    size_t scratch_bytes;
    // Seconds of the last calls; depth and maps are parts of one loop over the lights.
    double extract_seconds, depth_seconds, map_seconds;
} lighting;

// Makes room for settings->probe.max_lights lights of probes with that side. On failure nothing is
// kept.
bool lighting_create(lighting *l, const lighting_settings *settings, int probe_side, message *why);
void lighting_free(lighting *l);

// Steps of a frame, to be called in this order. Lights go on from those of the frame before.
bool lighting_extract(lighting *l, const probe *p, message *why);
bool lighting_draw_maps(lighting *l, const scene *s, message *why);

// Side of a light's map: lights with sharp shadows get larger ones.
int lighting_map_side(const lighting *l, int i);

// Irradiance at a surface: every light's share, shadowed, and what the lights do not carry.
vec3 lighting_at(const lighting *l, vec3 point, vec3 normal);

// Who says how much light arrives: the maps, rays to the lights (shadows without the maps' errors),
// or rays to the probe itself (no lights either).
typedef struct light_source {
    const lighting *maps;         // also the lights that rays are sent to
    const bvh *tree;              // NULL: maps
    const probe_sampler *sampler; // NULL: lights
    int rays;
    unsigned seed;
} light_source;

// Radiance of every pixel, the probe itself in the background.
void lighting_render(const view *v, const scene *s, const probe *p, const light_source *source,
                     image *out);

// The exposure that brings the median of what the picture shows of the scene to a light grey,
// however bright or dark the background is.
float lighting_exposure(const image *picture, const scene *s, const camera *eye);

#endif
