// Slow and simple ways to the numbers of lightprobe.h, in double, that share no code with it; and
// probes to try it on.
#ifndef ORACLE_LIGHTPROBE_H
#define ORACLE_LIGHTPROBE_H

#include "../lightprobe.h"

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

#endif
