// The room of room.h in OpenGL: its walls lit by lamp, sky and sun with soft shadows, for a camera
// and as a cube map with distances, and its things, to be drawn with a shader of one's own.
#ifndef GL_ROOM_H
#define GL_ROOM_H

#include "gl_draw.h"
#include "room.h"

#include "../../mssm.h"

typedef struct gl_room {
    mssm_gl *shadows; // of lamp, sky and sun
    GLuint depth, program, cube, cube_target;
    gl_target face; // multisampled, twice as large
    gl_mesh mesh;
    int things, sun_casters, walls; // triangles up to the end of these
} gl_room;

// side: of the cube's faces, which are level 1 of its texture. Each of their texels is the mean of
// 16 samples: with 4 the lamp's light would jitter by a third of a percent from frame to frame.
bool gl_room_create(gl_room *g, int side, message *why);
void gl_room_free(gl_room *g);

// As it stands now: triangles, lights, shadow maps.
bool gl_room_set(gl_room *g, const room *r, message *why);
// RGB radiance and distance from room_centre of walls and lights into g->cube.
void gl_room_draw_cube(gl_room *g);
// Into the target that is bound, with the depth test on.
void gl_room_draw_walls(gl_room *g, const camera *eye);
// To draw, not to free.
gl_mesh gl_room_things(const gl_room *g);

#endif
