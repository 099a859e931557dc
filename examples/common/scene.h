// Triangles to cast and receive shadows: a default scene made in code, or a mesh from an OBJ file
// placed in it. Every part of the default scene is a closed surface, seen counter-clockwise from
// outside, because averaging front and back depths needs that. Units are metres, +Y is up.
#ifndef SCENE_H
#define SCENE_H

#include "file.h"
#include "vec.h"

typedef struct mesh {
    vec3 *position;
    int (*triangle)[3];
    int vertices, triangles;
} mesh;

// Reads the v and f lines of a Wavefront OBJ file; polygons are split into fans. A file without a
// triangle is an error.
bool mesh_load_obj(mesh *m, const char *path, message *why);
bool mesh_parse_obj(mesh *m, const char *text, size_t size, message *why);
void mesh_free(mesh *m);

#define SCENE_OBJECTS 16

typedef struct scene {
    vec3 *position, *normal; // per vertex
    int (*triangle)[3];
    unsigned char *object; // per triangle
    vec3 albedo[SCENE_OBJECTS];
    int vertices, triangles, objects;
    vec3 low, high; // bounds
    // Private to scene.c.
    int vertex_room, triangle_room;
    bool failed;
} scene;

// Builds the default scene as it stands at a time (seconds; the moving parts come round every 8).
// centre, unless NULL, takes the place of the knot on the pedestal, scaled to fit and standing on
// it. False when memory runs out.
bool scene_create(scene *s, float time, const mesh *centre);
void scene_free(scene *s);

#endif
