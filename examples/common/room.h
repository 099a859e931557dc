// A room for examples/gl_room.c: a lamp swings in it, a sliding door lets in sky and sun, and a
// table with things on it stands in the middle. What its light is, and the truth about it by rays.
//
// Walls are lit by lamp, sky and sun in the shadow of the things, and by a little light that is the
// same everywhere. Things are lit by the same three and by what the walls reflect; they
// reflect nothing onto each other.
#ifndef ROOM_H
#define ROOM_H

#include "raster.h"

#include "image.h"

enum { ROOM_LEFT, ROOM_RIGHT, ROOM_FLOOR, ROOM_CEILING, ROOM_BACK, ROOM_FRONT, ROOM_WALLS };

typedef struct room {
    // Triangles in an order: the things, the wall that keeps the sun out, the other walls,
    // emitters. An emitter's albedo is its radiance.
    scene all;
    int things, sun_casters, walls;   // triangles up to the end of these
    int things_objects, wall_objects; // objects up to the end of these
    vec3 low, high;                   // the things' box
    vec3 lamp;                        // its centre
    float door;                       // how wide it stands open, in metres
} room;

extern const vec3 room_low, room_high, room_centre; // of the room; where the probe is
extern const vec3 room_wall_low, room_wall_high;    // what keeps the sun out, things included
extern const vec3 room_ambient;                     // irradiance of walls, from nowhere
extern const vec3 room_lamp_radiance, room_sky_radiance, room_sun_irradiance;
extern const vec3 room_to_sun; // unit
#define ROOM_LAMP_RADIUS 0.18f
#define ROOM_SUN_TANGENT 0.02f // of its half-angle: the sun in haze
#define ROOM_DOOR_FROM -2.25f  // z of the end that opens
#define ROOM_DOOR_WIDTH 1.2f   // towards the camera
#define ROOM_DOOR_HEIGHT 2.1f

// As it is at a time; all comes round every 1. False when memory runs out.
bool room_create(room *r, float time);
void room_free(room *r);
camera room_camera(float aspect);

// ---- The truth, by rays

typedef struct room_truth room_truth;

// Finds out what the walls reflect, on a grid of this many metres, with rays x rays to each light
// from each of its points. NULL when memory runs out. The room must stay.
room_truth *room_truth_create(const room *r, float grid, int rays, message *why);
void room_truth_free(room_truth *t);
// Irradiance of a point of the things or (wall) of the walls; the seed shifts the rays.
vec3 room_truth_irradiance(const room_truth *t, vec3 point, vec3 normal, bool wall, unsigned seed);
// Radiance that a varnish on the things (GGX of this alpha, 0.04 of the light at normal incidence)
// sends to the viewer, a unit vector away, of all but the sun.
vec3 room_truth_shine(const room_truth *t, vec3 point, vec3 normal, vec3 viewer, float alpha,
                      unsigned seed);
// A picture, four samples a pixel; shine: alpha of the things' varnish, 0: none. things, unless
// NULL: the share of each pixel that shows them.
bool room_truth_picture(const room_truth *t, const camera *eye, float shine, int width, int height,
                        image *out, float *things, message *why);
// How far a picture from room_camera() is from it: root mean square over the pixels that show
// things, in parts of their mean. The picture becomes twice as wide, with the truth on its right.
bool room_truth_beside(const room *r, float shine, image *picture, double *error, message *why);

#endif
