// One rasterizer for both jobs: depth maps as seen from lights, and the picture as seen by a
// camera.
#ifndef RASTER_H
#define RASTER_H

#include "scene.h"

// Depth maps -------------------------------------------------------------------------------------
// world_to_shadow as in mssm_light: column-major, clip = M (p,1); the map covers x and y in [-1,1]
// after division by w, and texel (x,y) covers [-1 + 2x/side, -1 + 2(x+1)/side], so y grows upwards.

// As the passes of mssm_gl_begin_depth: the first draws all triangles, whichever way they face,
// that with back faces only those that are seen from behind, clockwise in the map.
typedef enum raster_faces { RASTER_FRONT, RASTER_BACK } raster_faces;

typedef struct raster_frustum {
    const float *world_to_shadow;
    bool perspective;    // false: w = 1 and depth is clip.z
    float z_near, z_far; // perspective: depth is -1 + 2 (w - near) / (far - near)
} raster_frustum;

// Writes the depth of the surfaces nearest the light into depth[(y*side + x)*samples + s]: from -1
// to 1, and 1 where nothing is hit. samples: 1, 2, 4 or 8. What lies in front of -1 is cut off, as
// in OpenGL. False when memory runs out.
bool raster_depth(const scene *s, const raster_frustum *frustum, raster_faces faces, int side,
                  int samples, float *depth);

// Where sample s of a texel lies, in [0,1)^2 of the texel.
void raster_sample_position(int samples, int s, float *x, float *y);

// The camera -------------------------------------------------------------------------------------

typedef struct camera {
    vec3 position, right, up, back; // unit axes; it looks against back
    float tan_x, tan_y;             // half the field of view
} camera;

camera camera_look(vec3 from, vec3 to, float vertical_angle, float aspect);
// Through a position of the picture, x from the left and y from the top in [0,1]. Not normalized.
vec3 camera_ray(const camera *c, float x, float y);
// Its matrix for gl_Position.
void gl_camera_matrix(const camera *c, float near, float far, float world_to_clip[16]);

#define VIEW_SAMPLES 4

// What the camera sees: for every sample of a pixel the triangle in front, or -1.
typedef struct view {
    camera eye;
    int width, height;
    int *triangle; // [(y*width + x)*VIEW_SAMPLES + s], row 0 at the top; from malloc
} view;

bool view_create(view *v, const scene *s, const camera *eye, int width, int height);
void view_free(view *v);

// A piece of surface in a pixel: the samples that lie on the same object and face about the same
// way, so that a pixel is shaded once unless an edge runs through it. Position of one, mean normal
// of all.
typedef struct surface {
    vec3 position, normal;
    int object;
    float share; // of the pixel
} surface;

// Returns the number of pieces; what their shares leave is background.
int view_surfaces(const view *v, const scene *s, int x, int y, surface piece[VIEW_SAMPLES]);

#endif
