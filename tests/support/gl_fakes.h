// A driver and an allocator that fail on demand, and the count of what a library made of them.
//
// The test program's copy of both headers is compiled in gl_fakes.c, so that MSSM_MALLOC and
// LIGHTPROBE_MALLOC can be made to fail and the insides of a map can be looked at.
#ifndef GL_FAKES_H
#define GL_FAKES_H

#include <stdbool.h>
#include <stdint.h>

#include "../../examples/common/gl.h"
#include "../../mssm.h"

typedef void (*gl_fakes_function)(void);

enum { GL_FAKES_NAMES = 256, GL_FAKES_TEXTS = 64 };

typedef struct gl_fakes {
    // What is to fail; zero fails nothing. Counts are from 1 since the last reset.
    const char *missing; // the driver has no such function
    int fail_allocation; // this creation or storage call is out of memory
    int fail_malloc;     // this MSSM_MALLOC gives null
    int fail_compile;    // this shader does not compile, with garbage as its log
    int fail_link;       // this program does not link, likewise
    bool incomplete;     // framebuffers are incomplete
    bool silent_names;   // calls by name that some drivers don't carry out do nothing
    int depth_bounds;    // the extension is there, and its test off (1) or on (2)
    int max_samples;     // the driver's limits are this
    int major, minor;    // the context's version is this, and
    const char *version; // GL_VERSION reads so; "" for null: no current context
    // What happened.
    int allocations, mallocs, compiles, links;
    int messages;                      // through gl_fakes_log
    char message[400];                 // the last one, cut off
    int debug_messages;                // errors and warnings of the driver: gl_fakes_watch
    char debug_message[400];           // the first
    const char *names[GL_FAKES_NAMES]; // asked of the loader
    int name_count;
    int unwatched; // functions that make objects and that are not counted here
    char unwatched_name[64];
    char *texts[GL_FAKES_TEXTS]; // all shaders, as given to the driver
    GLenum text_types[GL_FAKES_TEXTS];
    int text_count;
    int bad_logs; // shaders or programs with words in their log, or not made
} gl_fakes;

extern gl_fakes fakes;

// Nothing fails, nothing has happened. Objects that live go on being counted.
void gl_fakes_reset(void);

// To be passed to the library; the functions of the current gl_context behind it.
gl_fakes_function gl_fakes_load(const char *name);

// For mssm_gl_desc.log. user must be &fakes.
void gl_fakes_log(void *user, const char *message);

// Lets the driver report to fakes.debug_messages: errors, undefined behaviour, deprecated and
// non-portable use, and losses of speed of high severity.
void gl_fakes_watch(void);

// Objects made through gl_fakes_load and not deleted; the first names of those go to text, and with
// `unlabelled` only those without a label are counted.
int gl_fakes_living(bool unlabelled, char *text, int size);
void gl_fakes_forget_living(void); // their context is gone

int gl_fakes_living_memory(void);

// Level l's table of a CPU map: (size + 1)^2 entries of `moments` channels with a first row and
// column of zeros, size 0 past the last level.
const uint32_t *gl_fakes_map_table(const mssm_map *map, int level, int *size);
// The level of a kernel of that width in texels.
int gl_fakes_level_of(float width, int levels);

#endif
