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
    double
        origin[3]; // what positions count from: 0, or the middle of a mesh that lies far from there
} mesh;

// Reads the v and f lines of a Wavefront OBJ file; polygons, concave ones too, are split into
// triangles, and vertices that none uses are left out. A file without a polygon is an error.
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

// Scenes of one's own: zero the struct, begin objects and put parts into them, end.

// Where a part stands: its local axes and origin in the world.
typedef struct scene_frame {
    vec3 x, y, z, origin;
} scene_frame;

// Turned about +Y first, then leaning by tilt about its own x axis.
scene_frame scene_frame_at(vec3 origin, float turn, float tilt);

// What follows belongs to a new object of this colour; at most SCENE_OBJECTS of them.
void scene_begin_object(scene *s, float r, float g, float b);
void scene_put_box(scene *s, const scene_frame *f, vec3 half);
void scene_put_sphere(scene *s, const scene_frame *f, float radius, int rings);
// A bent leaf: two skins that meet in a sharp rim.
void scene_put_leaf(scene *s, const scene_frame *f, float length, float width);
// Stands the mesh on the frame's origin, as large as fits under a height and within a radius.
void scene_put_mesh(scene *s, const scene_frame *f, const mesh *m, float radius, float height);
// For other shapes, open ones too. Returns the vertex's index.
int scene_put_vertex(scene *s, vec3 position, vec3 normal);
void scene_put_triangle(scene *s, int a, int b, int c);
// False, and nothing is kept, when memory ran out.
bool scene_end(scene *s);

// For vertex buffers: position, normal and albedo of each vertex, in floats. From malloc; NULL when
// memory runs out.
typedef struct scene_vertex {
    vec3 position, normal, albedo;
} scene_vertex;
scene_vertex *scene_vertices(const scene *s);

#endif
