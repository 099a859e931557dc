#include "figures.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char head[] = "experiment,scene,method,x,metric,value,low,high";

static bool put_name(char to[FIGURE_NAME], const char *from)
{
    if (strlen(from) >= FIGURE_NAME) return false;
    strcpy(to, from);
    return true;
}

bool figures_add(figures *f, const char *experiment, const char *scene, const char *method,
                 double x, const char *metric, double value, double low, double high)
{
    if (!isfinite(x) || !isfinite(value) || !isfinite(low) || !isfinite(high)) return false;
    if (f->count == f->room) {
        const int room = 2 * f->room + 256;
        figure *larger = realloc(f->list, (size_t)room * sizeof *larger);
        if (!larger) return false;
        f->list = larger;
        f->room = room;
    }
    figure *to = &f->list[f->count];
    memset(to, 0, sizeof *to);
    if (!put_name(to->experiment, experiment) || !put_name(to->scene, scene) ||
        !put_name(to->method, method) || !put_name(to->metric, metric)) {
        return false;
    }
    to->x = x;
    to->value = value;
    to->low = low;
    to->high = high;
    f->count++;
    return true;
}

const figure *figures_find(const figures *f, const char *experiment, const char *scene,
                           const char *method, double x, const char *metric)
{
    for (int i = 0; i < f->count; i++) {
        const figure *g = &f->list[i];
        if (fabs(g->x - x) <= 1e-6 * fabs(x) && !strcmp(g->method, method) &&
            !strcmp(g->scene, scene) && !strcmp(g->metric, metric) &&
            !strcmp(g->experiment, experiment)) {
            return g;
        }
    }
    return NULL;
}

// Names of methods hold commas, so they go between quotes.
static void write_name(FILE *file, const char *name)
{
    fprintf(file, strchr(name, ',') ? "\"%s\"," : "%s,", name);
}

bool figures_save(const figures *f, const char *path)
{
    FILE *file = fopen(path, "w");
    if (!file) return false;
    fprintf(file, "%s\n", head);
    for (int i = 0; i < f->count; i++) {
        const figure *g = &f->list[i];
        write_name(file, g->experiment);
        write_name(file, g->scene);
        write_name(file, g->method);
        fprintf(file, "%.7g,", g->x);
        write_name(file, g->metric);
        fprintf(file, "%.5g", g->value);
        if (g->low < g->value || g->high > g->value) fprintf(file, ",%.5g,%.5g", g->low, g->high);
        fputc('\n', file);
    }
    const bool written = !ferror(file);
    return fclose(file) == 0 && written;
}

static bool read_name(const char **at, char name[FIGURE_NAME])
{
    const bool quoted = **at == '"';
    const char *from = *at + quoted, *end = strchr(from, quoted ? '"' : ',');
    if (!end || end - from >= FIGURE_NAME || end == from) return false;
    memcpy(name, from, (size_t)(end - from));
    name[end - from] = 0;
    *at = end + quoted;
    return *(*at)++ == ',';
}

static bool read_number(const char **at, char behind, double *value)
{
    char *end;
    *value = strtod(*at, &end);
    if (end == *at || *end != behind || !isfinite(*value)) return false;
    *at = end + 1;
    return true;
}

// Without a spread the line ends behind the value.
static bool read_spread(const char **at, figure *g)
{
    char *end;
    g->value = g->low = g->high = strtod(*at, &end);
    if (end == *at || !isfinite(g->value)) return false;
    *at = end + 1;
    if (*end == '\n') return true;
    return *end == ',' && read_number(at, ',', &g->low) && read_number(at, '\n', &g->high);
}

static bool read_figure(const char *line, figure *g)
{
    const char *at = line;
    return read_name(&at, g->experiment) && read_name(&at, g->scene) && read_name(&at, g->method) &&
           read_number(&at, ',', &g->x) && read_name(&at, g->metric) && read_spread(&at, g) && !*at;
}

bool figures_load(figures *f, const char *path)
{
    char line[512];
    FILE *file = fopen(path, "r");
    if (!file) {
        fprintf(stderr, "%s: cannot be opened\n", path);
        return false;
    }
    figures_free(f);
    int number = 1;
    bool good = fgets(line, sizeof line, file) && !strncmp(line, head, sizeof head - 1) &&
                !strcmp(line + sizeof head - 1, "\n");
    while (good && fgets(line, sizeof line, file)) {
        figure g;
        memset(&g, 0, sizeof g);
        number++;
        good = read_figure(line, &g) && figures_add(f, g.experiment, g.scene, g.method, g.x,
                                                    g.metric, g.value, g.low, g.high);
    }
    good = good && !ferror(file);
    if (!good) fprintf(stderr, "%s: line %d is not a figure\n", path, number);
    fclose(file);
    if (!good) figures_free(f);
    return good;
}

void figures_free(figures *f)
{
    free(f->list);
    memset(f, 0, sizeof *f);
}
