// The papers' figures, re-made: docs/figures.md and its pictures.
//     figures FOLDER [NAME...]
// With names only those figures, on the standard output.
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

static const char head[] = "<!-- written by `make figures` -->\n"
                           "# The papers' figures\n\n"
                           "Kneiphof's figures 2 to 7, Annen's table 1 and the plots of Peters' "
                           "slides, re-made on the built-in scene and probe by `make figures`, "
                           "with one sentence each: does it agree with the paper? The sentence is "
                           "computed from the figure's own data. What is wrong in the papers is "
                           "in [errata.md](errata.md).\n\n"
                           "Times are of this machine's processor, also where OpenGL draws (Mesa's "
                           "llvmpipe): slopes and ratios can be compared with the papers', "
                           "milliseconds cannot. What GPUs execute is in [gpu.md](gpu.md).\n\n";

int main(int argc, char **argv)
{
    message why = {"usage: figures FOLDER [NAME...]"};
    page p = {stdout, argc > 1 ? argv[1] : "."};
    bool done = argc > 1;
    setvbuf(stdout, NULL, _IOLBF, 0);
    if (argc == 2) {
        p.file = fopen(page_path(&p, "figures.md"), "w");
        done = p.file || fail(&why, "cannot write %s", page_path(&p, "figures.md"));
        if (done) setvbuf(p.file, NULL, _IOLBF, 0);
        if (done) fputs(head, p.file);
    }
    for (int i = 0; i < FIGURES && done; i++) {
        bool wanted = argc == 2;
        for (int k = 2; k < argc; k++) wanted = wanted || !strcmp(argv[k], all[i].name);
        if (!wanted) continue;
        const double start = seconds_now();
        done = all[i].make(&p, &why);
        fprintf(stderr, "%-18s %.0f s\n", all[i].name, seconds_now() - start);
    }
    if (p.file && p.file != stdout && fclose(p.file)) done = fail(&why, "the page was not written");
    if (!done) fprintf(stderr, "figures: %s\n", why.text);
    return done ? 0 : 1;
}
