// The papers' figures, re-made: docs/figures.md and its pictures.
//     figures [--quick] FOLDER [NAME...]
// With names only those figures, on the standard output. --quick: small and few, to see whether all
// of it works; fails where the page has something that is no number.
#include "page.h"

#include "../../examples/common/threads.h"

#include <string.h>

static const struct {
    const char *name;
    page_figure *make;
} all[] = {
    {"light-sources", light_sources},       {"probe-times", probe_times},
    {"shadow-times", shadow_times},         {"probe-lights-one", probe_lights_one},
    {"probe-lights-two", probe_lights_two}, {"blocker-bounds", blocker_bounds},
    {"many-lights", many_lights},           {"hard-shadow-times", hard_shadow_times},
};
enum { FIGURES = sizeof all / sizeof *all };

static const char head[] =
    "<!-- written by `make figures` -->\n# The papers' figures\n\n"
    "Kneiphof's figures 2 to 7, Annen's table 1 and the plots of Peters' slides, re-made on "
    "the built-in scene and probe by `make figures`. A paragraph after each says whether it "
    "agrees with the paper, computed from the figure's own data. Errors in the papers are in "
    "[errata.md](errata.md).\n\n"
    "Times are of this machine's processor, also under OpenGL (Mesa's llvmpipe): slopes and "
    "ratios can be compared with the papers', milliseconds cannot. What GPUs execute is in "
    "[gpu.md](gpu.md).\n\n";

static bool write_page(page *p, char **names, int count, message *why)
{
    bool done = true;
    for (int i = 0; i < FIGURES && done; i++) {
        bool wanted = count == 0;
        for (int k = 0; k < count; k++) wanted = wanted || !strcmp(names[k], all[i].name);
        if (!wanted) continue;
        const double start = seconds_now();
        done = all[i].make(p, why);
        fprintf(stderr, "%-18s %.0f s\n", all[i].name, seconds_now() - start);
    }
    return done;
}

// A number that was never measured shows as one of these.
static bool all_numbers(const char *path, message *why)
{
    static const char *const none[] = {" nan", "-nan", "(nan", " inf", "-inf", "(inf"};
    char line[4096];
    bool done = true;
    FILE *file = fopen(path, "r");
    if (!file) return fail(why, "cannot read %s", path);
    while (done && fgets(line, sizeof line, file)) {
        for (size_t i = 0; i < sizeof none / sizeof *none && done; i++)
            done = !strstr(line, none[i]) || fail(why, "no number: %.150s", line);
    }
    fclose(file);
    return done;
}

int main(int argc, char **argv)
{
    message why = {"usage: figures [--quick] FOLDER [NAME...]"};
    const bool quick = argc > 1 && !strcmp(argv[1], "--quick");
    argc -= quick;
    argv += quick;
    page p = {stdout, argc > 1 ? argv[1] : ".", quick};
    char path[1024];
    bool done = argc > 1, whole = argc == 2;
    snprintf(path, sizeof path, "%s/figures.md", p.folder);
    setvbuf(stdout, NULL, _IOLBF, 0);
    if (whole) {
        p.file = fopen(path, "w");
        done = p.file || fail(&why, "cannot write %s", path);
        if (done) setvbuf(p.file, NULL, _IOLBF, 0);
        if (done) fputs(head, p.file);
    }
    if (done) done = write_page(&p, argv + 2, argc - 2, &why);
    if (p.file && whole && fclose(p.file)) done = fail(&why, "the page was not written");
    if (done && whole) done = all_numbers(path, &why);
    if (!done) fprintf(stderr, "figures: %s\n", why.text);
    return done ? 0 : 1;
}
