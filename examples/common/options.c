#include "options.h"

#include "../../mssm.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char options_help[] =
    "Renders a scene lit by a light probe, with soft shadows from moment shadow maps.\n"
    "\n"
    "  --probe FILE      .hdr or .pfm: lat-long, cross or strip of six cube faces\n"
    "  --mesh FILE.obj   replaces the knot in the middle\n"
    "  --lights N        at most N lights, 1..1024 (64)\n"
    "  --tolerance T     stop adding lights at this error behind edges, 0..1 (0.02)\n"
    "  --min-shadow S    weak lights go without maps if that changes at most S (0)\n"
    "  --estimator NAME  horizon, layered, lower or upper (horizon)\n"
    "  --moments N       4, 6, or 0: as many as the maps have (0)\n"
    "  --faces WHICH     front or both: what the depth maps are made of (front)\n"
    "  --size WxH        of the picture, 16..8192 (960x540)\n"
    "  --exposure E      factor on radiance, 1e-6..1e6; the log prints it\n"
    "                    (by default the median of the lit surfaces becomes light grey)\n"
    "  --out FILE        where the PNG goes (build/demo.png)\n"
    "  --orbit N         N numbered frames with a turning probe and moving objects\n"
    "  --truth           also trace rays to the probe and print the picture's error\n"
    "  --truth-lights    the same with rays to the lights: the error of the shadows alone\n"
    "  --cpu, --gl       the pipeline to use (OpenGL 4.5 if available)\n"
    "  --help            print this text\n";

bool options_int(const char *text, int low, int high, int *value)
{
    char *end;
    errno = 0;
    const long number = strtol(text, &end, 10);
    if (end == text || *end || errno || number < low || number > high) return false;
    *value = (int)number;
    return true;
}

static bool parse_float(const char *text, float low, float high, float *value)
{
    char *end;
    const double number = strtod(text, &end);
    // The comparison also refuses NaN.
    if (end == text || *end || !(number >= (double)low && number <= (double)high)) return false;
    *value = (float)number;
    return true;
}

bool options_size(const char *text, int *width, int *height)
{
    char copy[16] = {0};
    const char *x = strchr(text, 'x');
    if (!x || (size_t)(x - text) >= sizeof copy) return false;
    memcpy(copy, text, (size_t)(x - text));
    return options_int(copy, 16, 8192, width) && options_int(x + 1, 16, 8192, height);
}

// The place of a word in a list that ends with NULL.
static bool parse_word(const char *text, const char *const *words, int *place)
{
    for (int i = 0; words[i]; i++) {
        if (strcmp(text, words[i]) != 0) continue;
        *place = i;
        return true;
    }
    return false;
}

static bool parse_estimator(const char *text, int *estimator)
{
    const char *const names[] = {"layered", "lower", "upper", "horizon", NULL};
    return parse_word(text, names, estimator);
}

static bool parse_faces(const char *text, bool *back_faces)
{
    const char *const names[] = {"front", "both", NULL};
    int place;
    if (!parse_word(text, names, &place)) return false;
    *back_faces = place == 1;
    return true;
}

// An option with a value. *known is false when there is none of that name.
static bool parse_value(options *o, const char *name, const char *value, bool *known)
{
    *known = true;
    if (!strcmp(name, "--probe")) return (o->probe = value) != NULL;
    if (!strcmp(name, "--mesh")) return (o->mesh = value) != NULL;
    if (!strcmp(name, "--out")) return (o->out = value) != NULL;
    // Without a value only the name is asked for.
    if (!value) value = "";
    if (!strcmp(name, "--lights")) return options_int(value, 1, 1024, &o->lights);
    if (!strcmp(name, "--tolerance")) return parse_float(value, 0, 1, &o->tolerance);
    if (!strcmp(name, "--exposure")) return parse_float(value, 1e-6f, 1e6f, &o->exposure);
    if (!strcmp(name, "--shine")) return parse_float(value, 0.02f, 1, &o->shine);
    if (!strcmp(name, "--min-shadow")) return parse_float(value, 0, 1, &o->min_shadow);
    if (!strcmp(name, "--estimator")) return parse_estimator(value, &o->estimator);
    if (!strcmp(name, "--faces")) return parse_faces(value, &o->back_faces);
    if (!strcmp(name, "--size")) return options_size(value, &o->width, &o->height);
    if (!strcmp(name, "--orbit")) return options_int(value, 1, 9999, &o->orbit);
    if (!strcmp(name, "--moments")) {
        return options_int(value, 0, 6, &o->moments) &&
               (o->moments == 0 || o->moments == 4 || o->moments == 6);
    }
    return *known = false;
}

// Whether the words of a list, with blanks in between, hold this one; NULL holds all.
static bool in_list(const char *names, const char *name)
{
    const size_t length = strlen(name);
    for (const char *at = names; at; at = strchr(at, ' ')) {
        at += *at == ' ';
        if (strcspn(at, " ") == length && !strncmp(at, name, length)) return true;
    }
    return !names;
}

bool options_parse(options *o, int argc, char **argv, message *why)
{
    *o = (options){.out = "build/demo.png",
                   .lights = 64,
                   .tolerance = 0.02f,
                   .estimator = MSSM_HORIZON,
                   .width = 960,
                   .height = 540};
    return options_parse_some(o, NULL, argc, argv, why);
}

bool options_parse_some(options *o, const char *names, int argc, char **argv, message *why)
{
    for (int i = 1; i < argc; i++) {
        const char *name = argv[i], *value = i + 1 < argc ? argv[i + 1] : NULL;
        if (value && !strncmp(value, "--", 2)) value = NULL;
        bool known = false;
        if (!in_list(names, name)) {
            return fail(why, "unknown option %.100s (--help lists them)", name);
        } else if (!strcmp(name, "--help")) {
            o->help = true;
        } else if (!strcmp(name, "--truth")) {
            o->truth = TRUTH_PROBE;
        } else if (!strcmp(name, "--truth-lights")) {
            o->truth = TRUTH_LIGHTS;
        } else if (!strcmp(name, "--cpu")) {
            o->pipeline = PIPELINE_CPU;
        } else if (!strcmp(name, "--gl")) {
            o->pipeline = PIPELINE_GL;
        } else if (parse_value(o, name, value, &known)) {
            i++;
        } else if (!known) {
            return fail(why, "unknown option %.100s (--help lists them)", name);
        } else if (!value) {
            return fail(why, "%s needs a value", name);
        } else {
            return fail(why, "%s cannot be %.100s (--help says what it can be)", name, value);
        }
    }
    return true;
}

const char *options_unknown(int argc, char **argv, const char *usage)
{
    for (int i = 1; i < argc; i++) {
        const size_t length = strlen(argv[i]);
        const char *at = argv[i][0] == '-' ? usage : NULL;
        while (at && (at = strstr(at, argv[i])) && strcspn(at, " ]|:,\n") != length) at++;
        if (argv[i][0] == '-' && !at) return argv[i];
    }
    return NULL;
}

bool options_help_asked(int argc, char **argv, const char *usage)
{
    for (int i = 1; i < argc; i++) {
        if (!strcmp(argv[i], "--help") || !strcmp(argv[i], "-h"))
            return printf("usage: %s\n", usage) > 0;
    }
    const char *unknown = options_unknown(argc, argv, usage);
    if (!unknown) return false;
    fprintf(stderr, "unknown option %s; usage: %s\n", unknown, usage);
    exit(1);
}
