// Scenes of spheres, boxes and discs with exact ray intersections: the truth that estimators of
// visibility are held against, and the depth maps that they see instead.
#ifndef SCENES_H
#define SCENES_H

#include <stdint.h>

#include "../../mssm.h"

enum { SCENE_SHAPES = 160 };

typedef enum shape_kind { SHAPE_SPHERE, SHAPE_BOX, SHAPE_DISC } shape_kind;

typedef struct shape {
    shape_kind kind;
    double centre[3];
    double axis[3][3]; // unit; the box's edges, axis[2] is the disc's normal
    double half[3];    // the box's half-sizes; half[0] is the radius of spheres and discs
} shape;

// What casts shadows; receivers are where scene_receiver puts them.
typedef struct scene {
    const char *name;
    shape shapes[SCENE_SHAPES];
    int count;
    double sun[3];          // unit, towards the light
    double ground;          // height of a ground that receives but is not in the depth map
    int ground_casts;       // the scene brings a ground of its own
    double low[3], high[3]; // of all shapes
} scene;

// The scenes are the same on every run. Each was made to hurt somebody.
enum { SCENE_COUNT = 10 };
void scene_make(scene *s, int which);

// For scenes of a test's own: zero the struct, add shapes, then scene_finish.
void scene_add_sphere(scene *s, double x, double y, double z, double radius);
void scene_add_box(scene *s, double x, double y, double z, double hx, double hy, double hz);
void scene_add_disc(scene *s, double x, double y, double z, double radius, const double normal[3]);
// Turns the shape that was added last.
void scene_turn_last(scene *s, const double axis_0[3], const double axis_2[3]);
void scene_finish(scene *s);

// A light of that size along s->sun, fitted to the casters; axis_u is any fixed choice.
mssm_result scene_light(const scene *s, double tan_half_u, double tan_half_v, mssm_light *light);

// The depth map of a light, as the matrix in the light says: samples spread evenly over each texel,
// front and back the nearest front and back faces (back may be NULL).
void scene_depth(const scene *s, const mssm_light *light, int side, int samples, float *front,
                 float *back);

// A point on the ground or on a shape, seen from above and facing the light, and the normal there.
void scene_receiver(const scene *s, uint64_t *state, double point[3], double normal[3]);

// A point seen from anywhere, lit or not.
void scene_surface(const scene *s, uint64_t *state, double point[3], double normal[3]);

// Of a directional light: the cosine between normal and the light's middle; and how much less or more
// it is at the corners, times their distance if the middle's is 1. All is above at facing >= reach,
// nothing at facing <= -reach.
double scene_facing(const mssm_light *light, const double normal[3], double *reach);

// Whether a shape lies between two points.
int scene_blocks(const scene *s, const double from[3], const double to[3]);

// Share of the light that a point sees, by grid x grid stratified rays.
double scene_visibility(const scene *s, const mssm_light *light, const double point[3],
                        const double normal[3], int grid, uint64_t *state);

// The same of the part of the light above the point's horizon; 1 where there is none.
double scene_visibility_above(const scene *s, const mssm_light *light, const double point[3],
                              const double normal[3], int grid, uint64_t *state);

#endif
