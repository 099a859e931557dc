// Where do methods fail? Runs the stability suite and writes docs/stability.md, or prints one line
// of it.
//
//     stability [--quick] [--out FOLDER]       the page, its pictures, build/stability.csv
//     stability --method NAME --moments 4|6 --format NAME --family NAME --bias X|safe
//               [--patches N] [--seed N]       those lines; what is left out means all
//     stability --case NAME                    one of the cases about tables, lights and probes
//     stability --distance --moments 4|6 --format NAME       two depths that close up
//     stability --cases FOLDER                 renews the regression cases of `make test`
#include "cases.h"
#include "distance.h"
#include "further.h"
#include "page.h"

#include "../../examples/common/threads.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct command {
    plan p;
    int lines, distance, quick;
    const char *out, *cases, *further;
} command;

static int named(const char *name, const char *const *names, int count)
{
    for (int i = 0; i < count; i++) {
        if (!strcmp(name, names[i])) return i;
    }
    fprintf(stderr, "no %s; there are", name);
    for (int i = 0; i < count; i++) fprintf(stderr, " %s", names[i]);
    fprintf(stderr, "\n");
    exit(2);
}

static void read_option(command *c, const char *option, const char *value)
{
    const char *names[METHODS];
    for (int i = 0; i < METHODS; i++) names[i] = methods[i].name;
    c->lines |= !strcmp(option, "--method") || !strcmp(option, "--family") ||
                !strcmp(option, "--bias") || !strcmp(option, "--format") ||
                !strcmp(option, "--moments");
    if (!strcmp(option, "--method"))
        c->p.method = named(value, names, METHODS);
    else if (!strcmp(option, "--family"))
        c->p.family = named(value, family_keys, FAMILY_COUNT);
    else if (!strcmp(option, "--format"))
        c->p.format = named(value, format_names, FORMATS);
    else if (!strcmp(option, "--moments"))
        c->p.m = atoi(value) == 4 ? 4 : 6;
    else if (!strcmp(option, "--seed"))
        c->p.seed = (unsigned)strtoul(value, NULL, 0);
    else if (!strcmp(option, "--patches"))
        c->p.patches = atoi(value) > 0 ? atoi(value) : 1;
    else if (!strcmp(option, "--bias")) {
        c->p.biases = 1;
        c->p.bias[0] = strcmp(value, "safe") ? strtof(value, NULL) : -1;
    } else if (!strcmp(option, "--out"))
        c->out = value;
    else if (!strcmp(option, "--cases"))
        c->cases = value;
    else if (!strcmp(option, "--case"))
        c->further = value;
    else {
        fprintf(stderr, "unknown option %s\n", option);
        exit(2);
    }
}

static command read_command(int argc, char **argv)
{
    command c = {page_plan, 0, 0, 0, "docs", NULL, NULL};
    for (int i = 1; i < argc; i++) {
        if (!strcmp(argv[i], "--quick")) {
            c.quick = 1;
            c.p.patches = page_plan.patches / 16;
        } else if (!strcmp(argv[i], "--distance")) {
            c.distance = 1;
        } else if (i + 1 < argc) {
            read_option(&c, argv[i], argv[i + 1]);
            i++;
        } else {
            fprintf(stderr, "%s needs a value\n", argv[i]);
            exit(2);
        }
    }
    return c;
}

static int print_case(const char *name)
{
    const further *all[] = {further_tables, further_lights, further_probes};
    for (int i = 0; i < 3; i++) {
        for (const further *c = all[i]; c->name; c++) {
            if (strcmp(c->name, name)) continue;
            finding f;
            memset(&f, 0, sizeof f);
            c->run(&f);
            printf("%s: %s\n    here: %s\n    the usual way: %s\n", f.holds ? "holds" : "BROKEN",
                   f.what, f.ours, f.others);
            return !f.holds;
        }
    }
    fprintf(stderr, "no case %s\n", name);
    return 2;
}

static void print_distances(const command *c)
{
    static distance_row rows[DISTANCES];
    const int m = c->p.m < 0 ? 6 : c->p.m, format = c->p.format < 0 ? 0 : c->p.format;
    distance_run(m, format, c->p.patches * RECEIVERS, rows);
    printf("%d moments, %s, safe bias: 99.9%% error / largest (failures)\n", m,
           format_titles[format]);
    for (int i = 0; i < DISTANCES; i++) {
        printf("%.1e", rows[i].distance);
        for (int k = 0; k < METHODS; k++) {
            if (!applies(k, format)) continue;
            printf("  %s %.1e / %.1e (%d)", methods[k].name, rows[i].error[k], rows[i].largest[k],
                   rows[i].failures[k]);
        }
        printf("\n");
    }
}

static void print_lines(const plan *p, results *r)
{
    page_line_head();
    for (int i = 0; i < METHODS * 2 * FORMATS * p->biases; i++) {
        const int bias = i % p->biases, row = i / p->biases;
        const int format = row % FORMATS, m = row / FORMATS % 2 ? 6 : 4;
        const int method = row / FORMATS / 2;
        if ((p->method >= 0 && p->method != method) || (p->m >= 0 && p->m != m) ||
            (p->format >= 0 && p->format != format) || !applies(method, format)) {
            continue;
        }
        page_line(r, method, m, format, bias, p->family);
    }
}

int main(int argc, char **argv)
{
    const command c = read_command(argc, argv);
    if (c.further) return print_case(c.further);
    if (c.distance) {
        print_distances(&c);
        return 0;
    }
    results r;
    const double start = seconds_now();
    int done = 1, broken = 0;
    if (!results_run(&r, &c.p)) {
        fprintf(stderr, "out of memory\n");
        return 1;
    }
    if (c.cases) {
        done = cases_write(&r, c.p.biases - 1, c.cases);
    } else if (c.lines) {
        print_lines(&c.p, &r);
    } else {
        // A quick run must not replace the page by a coarser one unless it is told to.
        const char *folder = c.quick && !strcmp(c.out, "docs") ? "build" : c.out;
        done = page_write(&r, folder, "build/stability.csv", c.p.patches * RECEIVERS,
                          seconds_now() - start, &broken);
        if (done) printf("%s/stability.md\n", folder);
    }
    results_free(&r);
    if (!done) fprintf(stderr, "cannot write\n");
    return !done || broken;
}
