// One sun over a large scene: maps of growing size around what the camera sees (docs/lights.md,
// "Large scenes"). Only frusta and weights: it draws nothing, and its maps are lights of an mssm_gl
// or of mssm_map.
#ifndef CASCADES_H
#define CASCADES_H

#include "../../mssm.h"

#define CASCADES_MOST 4

typedef struct cascades_desc {
    int count, side; // of maps, and their texels
    float first,
        farthest; // distances, 1e-9 to 1e9, from the camera where the first and the last map end
    float tan_x, tan_y;                                   // of the camera's half-angles of view
    float to_light[3], axis_u[3], tan_half_u, tan_half_v; // as for mssm_light_directional
    float height; // how far towards the light casters stand in front of what they shadow
} cascades_desc;

typedef struct cascades {
    cascades_desc desc;
    mssm_light light[CASCADES_MOST]; // the finest first
    float end[CASCADES_MOST], eye[3];
    unsigned moved; // bit i: map i has to be drawn
} cascades;

// Returns false where numbers are out of range: c is untouched then. Its lights are complete after
// cascades_aim.
int cascades_create(cascades *c, const cascades_desc *desc);

// Frusta for this place and direction (of any length) of the camera. In steps of 16 texels: between
// two of them a map stays as it is, bit for bit, and need not be drawn again.
void cascades_aim(cascades *c, const float eye[3], const float looks_at[3]);

// The map for a point, and how much of the next one is mixed in (beyond the last all is lit).
int cascades_choose(const cascades *c, const float point[3], float *next);

// GLSL behind the text of an mssm_gl whose lights 0, 1 ... are the maps:
//     float cascades_visibility(vec3 position, vec3 normal)
// with uniforms cascades_eye, cascades_end[4], cascades_count.
extern const char cascades_glsl[];

#endif
