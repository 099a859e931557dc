// Light shafts on the CPU: single scattering of a directional light from a filtered moment map, one
// lookup a view ray, as gl_shafts.h does it; and by marching along view rays, which is the truth.
#ifndef SHAFTS_H
#define SHAFTS_H

#include "../../mssm.h"
#include "image.h"
#include "raster.h"

typedef struct shafts {
    mssm_scattering view;
    int rows, columns;
    float *moments; // encoded, means of all columns up to each, six a texel; from malloc
} shafts;

bool shafts_create(shafts *s, int rows, int columns); // false when memory runs out
void shafts_free(shafts *s);

// A sun over a scene.
mssm_light shafts_sun(const scene *s, const float to_sun[3]);

// A camera in a medium under a directional light; false if the light is another.
bool shafts_look(mssm_scattering *from, const mssm_light *light, const camera *eye,
                 float extinction);

// Resamples the map for the camera and adds up the rows.
void shafts_update(shafts *s, const mssm_filtered *map, const mssm_scattering *from);

// Mean visibility along a view ray (of unit direction) up to a distance.
float shafts_visibility(const shafts *s, vec3 direction, float distance);

// A depth map to march through, one sample a texel.
typedef struct shafts_march {
    const mssm_light *light;
    const float *depth;
    int side, steps;
    float extinction;
} shafts_march;

// The same from one lookup a step; steps scatter equal shares of unshadowed light.
float shafts_marched(const shafts_march *m, vec3 origin, vec3 direction, float distance);

// For pixels with surfaces at positions, zero where there is none and the medium ends at far_end:
// the share of light scattered to the camera, in all channels of out.
void shafts_march_image(const shafts_march *m, const camera *eye, const image *positions,
                        float far_end, image *out);
float shafts_distance(const camera *eye, const image *positions, float far_end, int x, int y);

// The same through a depth map of that side, drawn for it; false when memory runs out.
bool shafts_truth(const scene *s, const mssm_light *light, int side, int steps, float extinction,
                  const camera *eye, const image *positions, float far_end, image *out);

// Lays light of that colour over what is solid, as it is without the medium.
void shafts_over(image *light, vec3 color, const image *solid, float extinction, const camera *eye,
                 const image *positions, float far_end);

// Root mean square error of the first channel, and of its steps from pixel to pixel along rows:
// those show as bands.
void shafts_errors(const image *got, const image *expected, double *error, double *of_steps);

// A hall with five windows in its far wall, open to the other sides.
bool shafts_hall(scene *s);

#endif
