// The demo's command line.
#ifndef OPTIONS_H
#define OPTIONS_H

#include "file.h"

typedef enum truth_kind { TRUTH_NONE, TRUTH_PROBE, TRUTH_LIGHTS } truth_kind;

typedef enum pipeline_kind { PIPELINE_ANY, PIPELINE_CPU, PIPELINE_GL } pipeline_kind;

typedef struct options {
    const char *probe, *mesh, *out; // file names; probe and mesh NULL for the built-in ones
    int lights;
    float tolerance, min_shadow;
    float exposure; // 0: as the picture asks for
    float shine;    // alpha of GGX; 0: dull
    int estimator;  // mssm_estimator
    int moments;
    bool back_faces;
    int width, height;
    int orbit; // frames; 0 for a single picture
    truth_kind truth;
    pipeline_kind pipeline;
    bool help;
} options;

extern const char options_help[];

// False with one line in *why for anything unknown, incomplete or out of range.
bool options_parse(options *o, int argc, char **argv, message *why);
// For a program that takes some of the same options, their names in one string, and has defaults in
// *o.
bool options_parse_some(options *o, const char *names, int argc, char **argv, message *why);

// For programs with few arguments: whether one is --help or -h, which prints the usage. Ends the
// program at an option that the usage does not name, which would become a file's name.
bool options_help_asked(int argc, char **argv, const char *usage);

// The first such option, NULL if there is none.
const char *options_unknown(int argc, char **argv, const char *usage);

// A whole number from low to high, nothing before or after it; else value is untouched.
bool options_int(const char *text, int low, int high, int *value);

// WIDTHxHEIGHT, 16 to 8192 each.
bool options_size(const char *text, int *width, int *height);

#endif
