// The claims' little language, see claims.h: it is evaluated while it is read.
#include "claims.h"

#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "../../examples/common/file.h"
#include "page.h"
#include "summary.h"

typedef struct reading {
    const figures *f;
    const char *at;
    // What "each" stands for; NULL and NAN in the first pass, which finds out what it is asked of.
    const char *scene;
    double x;
    // The experiments whose scenes and x are asked for by "each", and the metric; empty: none.
    char scenes_of[FIGURE_NAME], sweep_of[FIGURE_NAME], metric[FIGURE_NAME];
    bool missing; // a figure under "each"
    char error[200];
} reading;

#if defined __GNUC__
__attribute__((format(printf, 2, 3)))
#endif
static double
refuse(reading *r, const char *format, ...)
{
    if (r->error[0]) return NAN;
    va_list list;
    va_start(list, format);
    vsnprintf(r->error, sizeof r->error, format, list);
    va_end(list);
    return NAN;
}

static bool take(reading *r, const char *token)
{
    while (isspace((unsigned char)*r->at)) r->at++;
    if (strncmp(r->at, token, strlen(token))) return false;
    r->at += strlen(token);
    return true;
}

static bool is_over_all(const char *word)
{
    return !strcmp(word, "mean") || !strcmp(word, "least") || !strcmp(word, "most");
}

static bool read_fields(reading *r, char field[5][FIGURE_NAME])
{
    for (int i = 0; i < 5; i++) {
        while (isspace((unsigned char)*r->at)) r->at++;
        size_t n = strcspn(r->at, i < 4 ? "|}" : "}");
        if (r->at[n] != (i < 4 ? '|' : '}')) return false;
        const char *next = r->at + n + 1;
        while (n > 0 && isspace((unsigned char)r->at[n - 1])) n--;
        if (n == 0 || n >= FIGURE_NAME) return false;
        snprintf(field[i], FIGURE_NAME, "%.*s", (int)n, r->at);
        r->at = next;
    }
    return true;
}

// {experiment|scene|method|x|metric}, behind its opening brace.
static double read_figure(reading *r)
{
    char field[5][FIGURE_NAME];
    if (!read_fields(r, field)) return refuse(r, "a figure is {experiment|scene|method|x|metric}");
    const char *experiment = field[0], *scene = field[1], *metric = field[4], *over = "mean";
    char *end = field[3];
    double x = NAN;
    if (is_over_all(scene)) over = scene;
    if (is_over_all(field[3])) {
        if (is_over_all(scene) && strcmp(over, field[3]))
            return refuse(r, "%s over %s is not known", over, field[3]);
        over = field[3];
    } else if (!strcmp(field[3], "each")) {
        snprintf(r->sweep_of, FIGURE_NAME, "%s", experiment);
        snprintf(r->metric, FIGURE_NAME, "%s", metric);
        x = r->x;
    } else {
        x = strtod(field[3], &end);
        if (*end) return refuse(r, "\"%s\" is no value of x", field[3]);
    }
    if (!strcmp(scene, "each")) {
        snprintf(r->scenes_of, FIGURE_NAME, "%s", experiment);
        scene = r->scene;
    } else if (is_over_all(scene))
        scene = NULL;
    const summary s = summarize(r->f, experiment, scene, field[2], x, metric);
    if (s.count) return !strcmp(over, "least") ? s.least : !strcmp(over, "most") ? s.most : s.mean;
    if (r->scene || !isnan(r->x)) {
        r->missing = true;
        return NAN;
    }
    return refuse(r, "there is no figure {%s|%s|%s|%s|%s}", experiment, field[1], field[2],
                  field[3], metric);
}

static double read_sum(reading *r);

static double read_term(reading *r)
{
    if (take(r, "{")) return read_figure(r);
    if (take(r, "-")) return -read_term(r);
    if (take(r, "(")) {
        const double value = read_sum(r);
        return take(r, ")") ? value : refuse(r, "a bracket stays open");
    }
    char *end;
    const double value = strtod(r->at, &end);
    if (end == r->at) return refuse(r, "a number or a figure is missing before \"%.20s\"", r->at);
    r->at = end;
    return value;
}

static double read_product(reading *r)
{
    double value = read_term(r);
    for (;;) {
        if (take(r, "*"))
            value *= read_term(r);
        else if (take(r, "/"))
            value /= read_term(r);
        else
            return value;
    }
}

static double read_sum(reading *r)
{
    double value = read_product(r);
    for (;;) {
        if (take(r, "+"))
            value += read_product(r);
        else if (take(r, "-"))
            value -= read_product(r);
        else
            return value;
    }
}

static bool at_end(reading *r)
{
    return take(r, "") && !*r->at;
}

// sum < sum < ...
static bool read_comparison(reading *r)
{
    bool holds = true;
    double left = read_sum(r);
    int compared = 0;
    while (!r->error[0] && !at_end(r)) {
        const bool less = take(r, "<"), more = !less && take(r, ">"),
                   equal = (less || more) && *r->at == '=';
        if (!less && !more) {
            refuse(r, "\"%.20s\" cannot follow", r->at);
            break;
        }
        if (equal) r->at++;
        const double right = read_sum(r);
        if (!r->missing && !(less ? left < right : left > right) && !(equal && left == right)) {
            holds = false;
            refuse(r, "%.4g is not %s %.4g", left, less ? "less than" : "more than", right);
        }
        left = right;
        compared++;
    }
    if (!compared) refuse(r, "nothing is compared");
    return holds && !r->error[0];
}

// A comparison for each scene and x that it asks for. False with the first that fails in error.
static bool check_comparison(const figures *f, const char *text, char error[256])
{
    reading first = {.f = f, .at = text, .x = NAN};
    read_comparison(&first);
    const bool scenes_asked = first.scenes_of[0], sweep_asked = first.sweep_of[0];
    snprintf(error, 256, "%s", first.error);
    if (!scenes_asked && !sweep_asked) return !error[0];
    const names scenes = scenes_of(f, scenes_asked ? first.scenes_of : first.sweep_of);
    const numbers sweep = sweep_of(f, first.sweep_of, NULL, first.metric);
    int checked = 0;
    for (int i = 0; i < (scenes_asked ? scenes.count : 1); i++) {
        for (int k = 0; k < (sweep_asked ? sweep.count : 1); k++) {
            reading r = {.f = f, .at = text, .x = sweep_asked ? sweep.list[k] : NAN};
            if (scenes_asked) r.scene = scenes.list[i];
            read_comparison(&r);
            if (r.missing) continue; // not every scene has every x
            checked++;
            if (!r.error[0]) continue;
            snprintf(error, 256, "%s (%s, x %g)", r.error, scenes_asked ? r.scene : "every scene",
                     r.x);
            return false;
        }
    }
    error[0] = 0;
    if (!checked) snprintf(error, 256, "there is no figure for any scene or x");
    return checked > 0;
}

// The last number before `end`, in the same paragraph; its decimals. NAN: there is none.
static double number_before(const char *text, const char *end, int *decimals)
{
    const char *to = end;
    while (to > text && end - to < 40 && !isdigit((unsigned char)to[-1])) to--;
    const char *from = to;
    while (from > text && (isdigit((unsigned char)from[-1]) || from[-1] == '.')) from--;
    *decimals = 0;
    if (from == to) return NAN;
    for (const char *c = from; c < to; c++)
        if (*c == '.') *decimals = (int)(to - c) - 1;
    return strtod(from, NULL);
}

// "= sum" behind a number.
static bool check_number(const figures *f, const char *page, const char *end, const char *text,
                         char error[256])
{
    reading r = {.f = f, .at = text, .x = NAN};
    int decimals;
    const double printed = number_before(page, end, &decimals), value = read_sum(&r);
    if (!r.error[0] && !at_end(&r)) refuse(&r, "\"%.20s\" cannot follow", r.at);
    if (r.scenes_of[0] || r.sweep_of[0]) refuse(&r, "a number cannot be that of each");
    if (isnan(printed)) refuse(&r, "there is no number in front of it");
    if (!r.error[0] && !(fabs(value - printed) <= 0.5000001 * pow(10, -decimals)))
        refuse(&r, "%.*f is printed, but the figures say %.*f", decimals, printed, decimals, value);
    snprintf(error, 256, "%s", r.error);
    return !r.error[0];
}

static int line_of(const char *text, const char *at)
{
    int line = 1;
    for (; text < at; text++) line += *text == '\n';
    return line;
}

static int check_claims(const figures *f, const char *path, const char *page)
{
    static const char opening[] = "<!-- claim:";
    int wrong = 0, count = 0;
    for (const char *at = page; (at = strstr(at, opening)) != NULL; at++, count++) {
        char claim[1024], error[256] = "the comment does not end, or is too long";
        const char *from = at + sizeof opening - 1, *to = strstr(from, "-->");
        if (to && to - from < (long)sizeof claim) {
            snprintf(claim, sizeof claim, "%.*s", (int)(to - from), from);
            const char *text = claim;
            while (isspace((unsigned char)*text)) text++;
            if (*text == '=' ? check_number(f, page, at, text + 1, error)
                             : check_comparison(f, text, error))
                continue;
        }
        fprintf(stderr, "%s:%d: %s\n", path, line_of(page, at), error);
        wrong++;
    }
    printf("%s: %d of %d claims follow from the figures\n", path, count - wrong, count);
    return wrong;
}

// Whether the page is what the figures make of it; names the first line that is not.
static int check_page(const figures *f, const char *path, const char *page)
{
    FILE *fresh = tmpfile();
    if (!fresh) {
        fprintf(stderr, "%s: no room for a fresh copy\n", path);
        return 1;
    }
    page_write(f, fresh);
    rewind(fresh);
    const char *at = page;
    int c;
    while ((c = fgetc(fresh)) != EOF && c == (unsigned char)*at) at++;
    const bool same = c == EOF && !*at;
    fclose(fresh);
    if (same)
        printf("%s: written from these figures\n", path);
    else
        fprintf(stderr, "%s:%d: not what these figures make of it\n", path, line_of(page, at));
    return !same;
}

int claims_check(const figures *f, const char *path)
{
    unsigned char *bytes = NULL;
    size_t size = 0;
    message why;
    if (!file_read(path, &bytes, &size, &why)) {
        fprintf(stderr, "%s\n", why.text);
        return 1;
    }
    char *page = malloc(size + 1);
    int wrong = 1;
    if (page) {
        memcpy(page, bytes, size);
        page[size] = 0;
        wrong = strncmp(page, page_mark, strlen(page_mark)) ? check_claims(f, path, page)
                                                            : check_page(f, path, page);
    }
    free(page);
    free(bytes);
    return wrong;
}
