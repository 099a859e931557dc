// Slow and simple ways to the numbers of lightprobe.h, in double, that share no code with it; and
// probes to try it on.
#ifndef ORACLE_LIGHTPROBE_H
#define ORACLE_LIGHTPROBE_H

#include "../../lightprobe.h"

#include <stdint.h>

typedef struct test_probe {
    int side;
    float *face[6]; // RGB
} test_probe;

test_probe test_probe_new(int side); // black
void test_probe_free(test_probe *probe);
lightprobe_cube test_probe_cube(const test_probe *probe);
// One of the shared probes; side 0 when it is not there.
test_probe test_probe_load(const char *name);
// The same probe turned by angles about Y, then X (bilinear within a face), negative values 0.
test_probe test_probe_turned(const test_probe *probe, double yaw, double pitch);

// Probes made of formulas; each exercises something else.
typedef enum test_scene {
    SCENE_SKY_SUN,  // smooth sky, dark ground, a sun of 2 degrees
    SCENE_WINDOW,   // a dim room with one bright rectangle
    SCENE_LAMPS,    // forty small coloured lamps
    SCENE_GRADIENT, // brighter towards one side
    SCENE_NOISE,    // every texel its own
    SCENE_COUNT
} test_scene;
extern const char *const test_scene_names[SCENE_COUNT];
test_probe test_scene_probe(test_scene scene, int side);
// Radiance 1 within the half-angle around the direction (antialiased), background elsewhere.
test_probe test_disc_probe(int side, const double direction[3], double half_angle,
                           double background);

void oracle_direction(int face, double s, double t, double direction[3]);
// Difference of four arctangents, in long double.
long double oracle_solid_angle(int side, int x, int y);
// Integral over the cap in rings around its axis, each ring's part above the horizon exact.
double oracle_disc_irradiance(double cos_alpha, double cos_theta);
void oracle_total(const test_probe *probe, double total[3]);   // negative channels count as 0
void oracle_vector(const test_probe *probe, double vector[3]); // of luminance

// Irradiance of unoccluded diffuse surfaces, for this many normals spread over the sphere.
#define ORACLE_NORMALS 500
typedef struct oracle_irradiance {
    double rgb[ORACLE_NORMALS][3];
} oracle_irradiance;
void oracle_irradiance_of_probe(const test_probe *probe, oracle_irradiance *out);
// With clipped discs, or with the paper's Eq. 18 (nothing below the horizon of the centre).
void oracle_irradiance_of_lights(const lightprobe_light *lights, int count, int paper,
                                 oracle_irradiance *out);
// Root mean square difference of luminance, in percent of the mean of the first.
double oracle_error(const oracle_irradiance *truth, const oracle_irradiance *other);

// Receivers of random orientation behind random straight edges. Anywhere: half-spaces whose border
// is any great circle, receivers facing any way. Near the light: within 0.02 or 0.25 radians of a
// direction drawn by its light, half of them strips of 0.1, receivers facing it.
#define ORACLE_EDGES 2000
typedef struct oracle_edges {
    int count;
    double normal[ORACLE_EDGES][3], edge[ORACLE_EDGES][3], start[ORACLE_EDGES], end[ORACLE_EDGES];
    double seen[ORACLE_EDGES]; // luminance that is left
    double mean;               // of all when nothing stands in between
} oracle_edges;
void oracle_edges_anywhere(const test_probe *probe, int count, uint64_t seed, oracle_edges *out);
void oracle_edges_near_light(const test_probe *probe, int count, uint64_t seed, oracle_edges *out);
// Root mean square error behind these edges, in parts of the mean, of lights whose rectangle is cut
// by the edge and whose disc (or Eq. 18, as above) is cut by the horizon, and of residual light
// (its nine coefficients, or NULL), which no edge cuts.
double oracle_edge_error(const oracle_edges *edges, const lightprobe_light *lights, int count,
                         int paper, const lightprobe_stats *residual);

#endif
