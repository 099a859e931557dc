// Soft shadow methods measured against the truth and against each other, for `make chart`:
//     measure --out FILE.csv [--append] [--quick] [--only EXPERIMENT] [--data DIR] [--probe FILE]
//             [--scene FILE.obj [--sun x,y,z]]
// --scene measures that mesh alone (OBJ: v and f lines, +Y up, any unit; a ground is put under its
// lowest point) and prints a table for each light; --probe measures the lights of that file alone
// (lat-long or strip of six faces, .hdr or .pfm). Figures go to the file of --out, if there is one.
#include "measure.h"
#include "measure_gl.h"

#include "../../examples/common/threads.h"

#include <stdlib.h>
#include <string.h>

static bool measure_opengl(measurement *m, message *why)
{
    (void)why; // without OpenGL there is less in the file
    measure_gl(&m->f, m->quick);
    return true;
}

static const struct {
    const char *name;
    experiment_run *run;
} experiments[] = {
    {"error", measure_error},     {"eye", measure_eye},           {"kernel", measure_kernel},
    {"side", measure_side},       {"temporal", measure_temporal}, {"setting", measure_setting},
    {"lights", measure_lights},   {"array", measure_array},       {"bandwidth", measure_bandwidth},
    {"picture", measure_picture}, {"hard", measure_hard},         {"gl", measure_opengl},
};
enum { EXPERIMENTS = sizeof experiments / sizeof *experiments };

typedef struct arguments {
    const char *out, *only;
    bool append;
} arguments;

static bool parse_sun(const char *text, vec3 *sun)
{
    char end;
    return sscanf(text, "%f,%f,%f%c", &sun->x, &sun->y, &sun->z, &end) == 3 &&
           vec_length(*sun) > 0 && isfinite(vec_length(*sun));
}

static bool known_experiment(const char *name)
{
    bool known = false;
    for (int i = 0; i < EXPERIMENTS; i++) known = known || !strcmp(experiments[i].name, name);
    return known;
}

static bool parse(arguments *a, measurement *m, int argc, char **argv, message *why)
{
    for (int i = 1; i < argc; i++) {
        const char *name = argv[i], **text = NULL;
        if (!strcmp(name, "--quick")) {
            m->quick = true;
            continue;
        }
        if (!strcmp(name, "--append")) {
            a->append = true;
            continue;
        }
        const char *sun = NULL;
        if (!strcmp(name, "--out")) text = &a->out;
        if (!strcmp(name, "--only")) text = &a->only;
        if (!strcmp(name, "--data")) text = &m->data;
        if (!strcmp(name, "--probe")) text = &m->probe;
        if (!strcmp(name, "--scene")) text = &m->scene;
        if (!strcmp(name, "--sun")) text = &sun;
        if (!text) return fail(why, "unknown: %.100s (measure.c says what there is)", name);
        if (++i == argc) return fail(why, "%s needs a value", name);
        *text = argv[i];
        if (sun && !parse_sun(sun, &m->sun)) return fail(why, "--sun wants x,y,z: %.100s", sun);
    }
    if (a->only && !known_experiment(a->only)) return fail(why, "no experiment %.100s", a->only);
    if (!a->out && !m->scene) return fail(why, "--out FILE.csv is missing");
    return true;
}

// What is to be run: one scene, the lights of one probe, one experiment, or everything.
static bool wanted(const arguments *a, const measurement *m, int i)
{
    const char *name = experiments[i].name;
    if (a->only) return !strcmp(a->only, name);
    return !m->probe || !strcmp(name, "lights");
}

static bool run(const arguments *a, measurement *m, message *why)
{
    if (a->append && !figures_load(&m->f, a->out)) return fail(why, "nothing to append to");
    if (m->scene && !measure_scene(m, why)) return false;
    for (int i = 0; i < EXPERIMENTS; i++) {
        if (!wanted(a, m, i) || (m->scene && !a->only && !m->probe)) continue;
        const double start = seconds_now();
        say("%s", experiments[i].name);
        if (!experiments[i].run(m, why)) return false;
        say("%s: %.1f s", experiments[i].name, seconds_now() - start);
    }
    if (a->out && !figures_save(&m->f, a->out)) return fail(why, "%s: not written", a->out);
    return true;
}

int main(int argc, char **argv)
{
    static measurement m;
    arguments a = {NULL, NULL, false};
    message why = {{0}};
    m.sun = vec(0.3f, 1, 0.45f);
    const bool done = parse(&a, &m, argc, argv, &why) && run(&a, &m, &why);
    if (!done) fprintf(stderr, "measure: %s\n", why.text);
    figures_free(&m.f);
    return done ? 0 : 1;
}
