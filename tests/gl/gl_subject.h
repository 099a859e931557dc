// What the suites of the GL half have in common: a context, maps of OpenGL and of the CPU of the
// same depth, questions to both, snapshots around calls.
#ifndef GL_SUBJECT_H
#define GL_SUBJECT_H

#include "../support/gl_fakes.h"
#include "../support/gl_state.h"
#include "../support/gl_test.h"
#include "../support/scenes.h"
#include "../support/test.h"

// Where the tests bind their own buffers, away from mssm's.
enum { DEPTH_BINDING = 7, POINT_BINDING = 8, RESULT_BINDING = 9, GROUP = 64 };

// Under valgrind a shader takes seconds to compile: every how many cases are run.
int stride(void);
void *allocate(size_t bytes);

extern struct gl_stage {
    gl_context context;
    GLuint fill; // draws a known depth into every sample
    GLuint casters;
    GLuint array; // without attributes
} stage;

GLuint link_program(const char *const texts[2]);
void make_programs(void);
bool begin_gl(void);
void nothing_is_left(const char *what);
// Ends a test in which nothing was made to fail.
void end_gl(void);

enum { MOST_LIGHTS = 300 };

typedef struct subject {
    mssm_gl_desc desc;
    mssm_gl *gl;
    GLuint asking; // program that asks for visibility
    mssm_light light[MOST_LIGHTS];
    mssm_map *map[MOST_LIGHTS];
    void *memory[MOST_LIGHTS];
} subject;

mssm_gl_desc description(int lights, int side, int samples, int moments);
void make_maps(subject *s);
bool make_subject(subject *s, const mssm_gl_desc *desc);
void drop_maps(subject *s);
void drop_subject(subject *s);

// Uploads window depths for every sample to where the fill program reads them.
GLuint bind_window(const float *window, int width, int height, int samples);
GLuint bind_depth(const mssm_light *light, const float *z, int side, int samples);
void bind_fill(bool back);
// One depth pass of one light, with depth z at every sample.
void fill_pass(subject *s, int index, bool back, const float *z);
// The CPU's map of the depth that GL has stored.
void fill_map(subject *s, int index, const float *front, const float *back);
// Both maps of a light from the same depth (back may be null); mssm_gl_build is left to the caller.
void fill(subject *s, int index, const float *front, const float *back);
void build(subject *s);

// By how much the integer of a texel may differ: more than 0 where the C compiler fuses a * b + c.
int slack(void);

typedef struct difference {
    double values, unequal; // how many
    int largest;            // of a single texel's value, recovered from the sums
} difference;

// The value of one texel in a table with a row stride, from four sums.
int texel_value(const uint32_t *at, size_t right, size_t up);
// Sums of one level of one light with a first row and column of zeros, as the CPU lays them out.
uint32_t *read_level(const subject *s, int index, int level, int size);
int levels_of(const subject *s);
void compare_level(const subject *s, int index, int level, difference *d);
// Adds the difference of all levels that a light asks for; returns how many were compared.
int compare_tables(const subject *s, int index, difference *d);
// result[i] = visibility of the light at points[3 i ...].
void ask(subject *s, int index, bool in_shadow_space, int count, const float *points,
         float *result);

mssm_light wide_light(bool spot, float size);
// Hostile depth: noise, slopes, few layers, the ends of the range.
void random_depth(float *z, int side, int samples, uint64_t *seed);

typedef struct agreement {
    int count, beyond; // by more than 2e-3 and not at a limit
    double squares, largest, largest_at_limit;
} agreement;

void compare_visibility(subject *s, int index, const char *what, int count, const float *points,
                        agreement *a);
// Half of the points on surfaces, half anywhere near.
void random_points(const scene *c, int count, float *points, uint64_t *seed);

// Triangles of a scene's shapes, counter-clockwise from outside; discs have two sides.
typedef struct mesh {
    float *xyz;
    int vertices, capacity;
    GLuint buffer, array;
} mesh;

void make_mesh(mesh *m, const scene *s);
void drop_mesh(mesh *m);
// All passes of light 0, as an application would.
void draw_light(subject *s, const mesh *m, bool with_back);

extern gl_state before, after;
extern const char bound_by_bind[]; // what mssm_gl_bind says that it binds

// The state as it is now must be that of the last snapshot, but for what is allowed.
void same_state(const char *call, const char *allowed);

// Evaluates a call between two snapshots.
#define WATCH(call, allowed)        \
    do {                            \
        gl_state_take(&before);     \
        call;                       \
        same_state(#call, allowed); \
    } while (0)

#define WATCH_OK(call, allowed)                                                     \
    do {                                                                            \
        mssm_result result_;                                                        \
        gl_state_take(&before);                                                     \
        result_ = call;                                                             \
        CHECK(result_ == MSSM_OK, "%s: %s, %s", #call, mssm_result_string(result_), \
              fakes.message);                                                       \
        same_state(#call, allowed);                                                 \
    } while (0)

#define WATCH_FAIL(call, expected)                                                \
    do {                                                                          \
        mssm_result result_;                                                      \
        gl_state_take(&before);                                                   \
        result_ = call;                                                           \
        CHECK(result_ == expected, "%s: %s", #call, mssm_result_string(result_)); \
        same_state(#call, NULL);                                                  \
    } while (0)

long resident_pages(void);

#endif
