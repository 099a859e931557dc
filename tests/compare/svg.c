// Line pictures as SVG text, see svg.h.
#include "svg.h"

#include <math.h>
#include <string.h>

static const struct {
    const char *name, *light, *dark;
} palette[] = {
    [COLOUR_INK] = {"ink", "#1f2328", "#e6edf3"},
    [COLOUR_FAINT] = {"faint", "#59636e", "#9198a1"},
    [COLOUR_GRID] = {"grid", "#e4e8ec", "#262c36"},
    [COLOUR_LAYERED] = {"layered", "#d45f00", "#ff8c1a"},
    [COLOUR_MSSM] = {"mssm", "#004edc", "#5470ff"},
    [COLOUR_PCSS] = {"pcss", "#0a4208", "#8fe8a0"},
    [COLOUR_CONVOLUTION] = {"convolution", "#5b1785", "#e2c8ff"},
    [COLOUR_VARIANCE] = {"variance", "#978762", "#a8905a"},
    [COLOUR_BACK_PROJECTION] = {"back", "#c25fc8", "#d03fb0"},
    [COLOUR_HARD] = {"hard", "#545a62", "#77808a"},
};
enum { COLOURS = sizeof palette / sizeof *palette, TITLE_SIZE = 17 };

static void escaped(FILE *file, const char *text)
{
    for (; *text; text++) {
        if (*text == '&')
            fputs("&amp;", file);
        else if (*text == '<')
            fputs("&lt;", file);
        else if (*text == '>')
            fputs("&gt;", file);
        else
            fputc(*text, file);
    }
}

static void write_palette(FILE *file)
{
    for (int dark = 0; dark < 2; dark++) {
        if (dark) fputs("@media (prefers-color-scheme: dark) {\n", file);
        fprintf(file, ".page{fill:%s}\n", dark ? "#0d1117" : "#ffffff");
        for (int i = 0; i < COLOURS; i++) {
            const char *value = dark ? palette[i].dark : palette[i].light;
            fprintf(file, ".%s{fill:%s}.%s-line{stroke:%s}\n", palette[i].name, value,
                    palette[i].name, value);
        }
        if (dark) fputs("}\n", file);
    }
}

// As wide as it was taken for, whatever the font.
static void write_line(svg *s, double y, const char *line)
{
    fprintf(s->file,
            "<text x=\"12\" y=\"%.1f\" class=\"ink\" font-size=\"%d\" font-weight=\"bold\" "
            "textLength=\"%.0f\" lengthAdjust=\"spacingAndGlyphs\">",
            y, TITLE_SIZE, svg_text_width(line, -TITLE_SIZE));
    escaped(s->file, line);
    fputs("</text>\n", s->file);
}

// Breaks the title at spaces and writes it, or only measures it; returns the height below.
static double write_title(svg *s, const char *title, bool write)
{
    double y = 8;
    while (*title) {
        char line[256] = "";
        size_t used = 0, best = 0;
        while (title[used] && used + 1 < sizeof line) {
            line[used] = title[used];
            line[++used] = 0;
            if (title[used] && title[used] != ' ') continue;
            if (best && svg_text_width(line, -TITLE_SIZE) > s->width - 24) break;
            best = used;
        }
        if (!best) best = used;
        line[best] = 0;
        y += TITLE_SIZE + 5;
        if (write) write_line(s, y, line);
        title += best;
        while (*title == ' ') title++;
    }
    return y + 12;
}

bool svg_open(svg *s, const char *path, double width, double below, const char *title)
{
    s->width = width;
    s->top = write_title(s, title, false);
    s->height = s->top + below;
    s->file = fopen(path, "w");
    if (!s->file) return false;
    fprintf(s->file,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" width=\"%g\" height=\"%g\" "
            "viewBox=\"0 0 %g %g\" font-family=\"Helvetica, Arial, sans-serif\">\n<title>",
            width, s->height, width, s->height);
    escaped(s->file, title);
    fputs("</title>\n<style>\npolyline,line{fill:none}\n", s->file);
    write_palette(s->file);
    fputs("</style>\n<rect class=\"page\" width=\"100%\" height=\"100%\"/>\n", s->file);
    write_title(s, title, true);
    return true;
}

bool svg_close(svg *s)
{
    fputs("</svg>\n", s->file);
    const bool written = !ferror(s->file);
    return !fclose(s->file) && written;
}

void svg_text(svg *s, double x, double y, const char *anchor, colour ink, double size,
              const char *text)
{
    fprintf(s->file,
            "<text x=\"%.1f\" y=\"%.1f\" class=\"%s\" text-anchor=\"%s\" font-size=\"%g\"%s>", x, y,
            palette[ink].name, anchor, fabs(size), size < 0 ? " font-weight=\"bold\"" : "");
    escaped(s->file, text);
    fputs("</text>\n", s->file);
}

void svg_text_upwards(svg *s, double x, double y, colour ink, double size, const char *text)
{
    fprintf(s->file, "<g transform=\"translate(%.1f %.1f) rotate(-90)\">", x, y);
    svg_text(s, 0, 0, "middle", ink, size, text);
    fputs("</g>\n", s->file);
}

static const char *dashes(bool dashed)
{
    return dashed ? " stroke-dasharray=\"6 4\"" : "";
}

void svg_line(svg *s, double x0, double y0, double x1, double y1, colour ink, double width,
              bool dashed)
{
    fprintf(s->file,
            "<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" class=\"%s-line\" "
            "stroke-width=\"%g\"%s/>\n",
            x0, y0, x1, y1, palette[ink].name, width, dashes(dashed));
}

void svg_polyline(svg *s, int count, const double *x, const double *y, colour ink, double width,
                  bool dashed)
{
    fprintf(s->file, "<polyline class=\"%s-line\" stroke-width=\"%g\"%s points=\"",
            palette[ink].name, width, dashes(dashed));
    for (int i = 0; i < count; i++) fprintf(s->file, "%s%.1f,%.1f", i ? " " : "", x[i], y[i]);
    fputs("\"/>\n", s->file);
}

void svg_bar(svg *s, double x, double y, double width, double height, colour ink)
{
    fprintf(s->file, "<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" class=\"%s\"/>\n",
            x, y, fmax(width, 0), height, palette[ink].name);
}

void svg_marker(svg *s, double x, double y, marker shape, colour ink, double size)
{
    // Corners in units of the marker's radius.
    static const char *const path[] = {
        [MARKER_SQUARE] = "M-.85-.85H.85V.85H-.85Z",
        [MARKER_DIAMOND] = "M0-1.2L1.1 0L0 1.2L-1.1 0Z",
        [MARKER_UP] = "M0-1.1L1.1.8H-1.1Z",
        [MARKER_DOWN] = "M0 1.1L1.1-.8H-1.1Z",
        [MARKER_CROSS] = "M-.6-1L0-.4L.6-1L1-.6L.4 0L1 .6L.6 1L0 .4L-.6 1L-1 .6L-.4 0L-1-.6Z",
        [MARKER_PLUS] = "M-.3-1.1H.3V-.3H1.1V.3H.3V1.1H-.3V.3H-1.1V-.3H-.3Z",
    };
    if (shape == MARKER_CIRCLE)
        fprintf(s->file, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%g\" class=\"%s\"/>\n", x, y, size,
                palette[ink].name);
    else
        fprintf(s->file,
                "<path transform=\"translate(%.1f %.1f) scale(%g)\" d=\"%s\" class=\"%s\"/>\n", x,
                y, size, path[shape], palette[ink].name);
}

double svg_text_width(const char *text, double size)
{
    double em = 0;
    for (; *text; text++) {
        if (strchr("ijl.,:;|' !()", *text))
            em += 0.3;
        else if (strchr("trf", *text))
            em += 0.38;
        else if (strchr("mwMW%", *text))
            em += 0.9;
        else if (*text >= 'A' && *text <= 'Z')
            em += 0.69;
        else if (((unsigned char)*text & 0xc0) != 0x80) // not the later bytes of a character
            em += 0.57;
    }
    return em * fabs(size) * (size < 0 ? 1.08 : 1);
}

axis axis_make(const char *name, bool log)
{
    return (axis){.low = HUGE_VAL, .high = -HUGE_VAL, .log = log, .name = name};
}

void axis_include(axis *a, double value)
{
    if (!isfinite(value) || (a->log && value <= 0)) return;
    a->low = fmin(a->low, value);
    a->high = fmax(a->high, value);
}

void axis_tick(axis *a, double value)
{
    for (int i = 0; i < a->given; i++)
        if (a->tick[i] == value) return;
    if (a->given < AXIS_TICKS) a->tick[a->given++] = value;
}

void axis_finish(axis *a)
{
    if (a->low > a->high) a->low = a->high = 1;
    if (a->log) {
        const double air = pow(fmax(a->high / a->low, 1.5), 0.06);
        a->low /= air;
        a->high *= air;
    } else {
        a->low = fmin(a->low, 0);
        a->high = a->high > a->low ? a->high + 0.08 * (a->high - a->low) : a->low + 1;
    }
}

// Where a value lies between the ends of the axis, 0 to 1.
static double axis_share(const axis *a, double value)
{
    if (a->log) return log(value / a->low) / log(a->high / a->low);
    return (value - a->low) / (a->high - a->low);
}

double plot_x(const plot *p, double value)
{
    return p->x + p->width * axis_share(&p->across, value);
}

double plot_y(const plot *p, double value)
{
    return p->y + p->height * (1 - axis_share(&p->up, value));
}

// Round values along an axis: the decades with 2 and 5 on a log axis, 1, 2 or 5 times a power of
// ten apart on a linear one; at most `most` of them.
static int axis_ticks(const axis *a, int most, double ticks[AXIS_TICKS])
{
    static const char *const digits[] = {"1", "15", "125", "12357", "123456789"};
    int count = 0;
    if (a->given) {
        memcpy(ticks, a->tick, sizeof a->tick);
        return a->given;
    }
    if (!a->log) {
        const double rough = (a->high - a->low) / most, power = pow(10, floor(log10(rough)));
        const double step = power * (rough > 5 * power   ? 10
                                     : rough > 2 * power ? 5
                                     : rough > power     ? 2
                                                         : 1);
        for (double v = ceil(a->low / step) * step; v <= a->high && count < AXIS_TICKS; v += step)
            ticks[count++] = fabs(v) < step / 2 ? 0 : v;
        return count;
    }
    for (int set = 0; set < 5; set++) { // the richest set that is not too rich
        double found[AXIS_TICKS];
        int n = 0;
        for (int e = (int)floor(log10(a->low)); e <= (int)ceil(log10(a->high)) && n <= most; e++) {
            for (const char *d = digits[set]; *d && n <= most; d++) {
                const double v = (*d - '0') * pow(10, e);
                if (v >= a->low * 0.999 && v <= a->high * 1.001) found[n++] = v;
            }
        }
        if (n > most && set == 0) { // every second decade must do
            n = 0;
            for (int e = (int)ceil(log10(a->low));
                 e <= (int)floor(log10(a->high)) && n < AXIS_TICKS; e += 2)
                found[n++] = pow(10, e);
            set = 5;
        } else if (n > most)
            break;
        memcpy(ticks, found, (size_t)n * sizeof *ticks);
        count = n;
    }
    return count;
}

static void tick_text(char text[16], double value)
{
    if (fabs(value) >= 1e6)
        snprintf(text, 16, "%gM", value / 1e6);
    else if (fabs(value) >= 1e4)
        snprintf(text, 16, "%gk", value / 1e3);
    else
        snprintf(text, 16, "%g", value);
}

void plot_grid(const plot *p)
{
    double ticks[AXIS_TICKS];
    char text[16];
    const int most_up = (int)fmin(fmax(p->height / 32, 3), 12);
    const int most_across = (int)fmin(fmax(p->width / 50, 3), 12);
    for (int i = 0, n = axis_ticks(&p->up, most_up, ticks); i < n; i++) {
        const double y = plot_y(p, ticks[i]);
        svg_line(p->svg, p->x, y, p->x + p->width, y, COLOUR_GRID, 1, false);
        tick_text(text, ticks[i]);
        svg_text(p->svg, p->x - 6, y + 4, "end", COLOUR_FAINT, 12, text);
    }
    for (int i = 0, n = axis_ticks(&p->across, most_across, ticks); i < n; i++) {
        const double x = plot_x(p, ticks[i]);
        svg_line(p->svg, x, p->y, x, p->y + p->height, COLOUR_GRID, 1, false);
        tick_text(text, ticks[i]);
        svg_text(p->svg, x, p->y + p->height + 16, "middle", COLOUR_FAINT, 12, text);
    }
    svg_text(p->svg, p->x + p->width / 2, p->y + p->height + 34, "middle", COLOUR_FAINT, 12,
             p->across.name);
    svg_text_upwards(p->svg, p->x - 44, p->y + p->height / 2, COLOUR_FAINT, 12, p->up.name);
}

void labels_add(labels *l, double x, double y, colour ink, double size, const char *text)
{
    if (l->count == LABEL_ROOM) return;
    label *one = &l->list[l->count++];
    *one = (label){.x = x, .y = y, .left = x, .baseline = y, .size = size, .ink = ink};
    snprintf(one->text, sizeof one->text, "%s", text);
}

typedef struct box {
    double x0, y0, x1, y1;
} box;

static box label_box(const label *l)
{
    const double size = fabs(l->size);
    return (box){l->left, l->baseline - 0.8 * size, l->left + svg_text_width(l->text, l->size),
                 l->baseline + 0.25 * size};
}

static double overlap(box a, box b)
{
    const double w = fmin(a.x1, b.x1) - fmax(a.x0, b.x0), h = fmin(a.y1, b.y1) - fmax(a.y0, b.y0);
    return w > 0 && h > 0 ? w * h : 0;
}

// The point of the label's box that is nearest to what it names.
static void leader_end(const label *l, double *x, double *y)
{
    const box b = label_box(l);
    *x = fmin(fmax(l->x, b.x0), b.x1);
    *y = fmin(fmax(l->y, b.y0), b.y1);
}

// Whether two leaders cross: each one's ends lie on different sides of the other.
static bool leaders_cross(const label *a, const label *b)
{
    double ax, ay, bx, by;
    leader_end(a, &ax, &ay);
    leader_end(b, &bx, &by);
    const double s0 = (bx - b->x) * (a->y - b->y) - (by - b->y) * (a->x - b->x);
    const double s1 = (bx - b->x) * (ay - b->y) - (by - b->y) * (ax - b->x);
    const double s2 = (ax - a->x) * (b->y - a->y) - (ay - a->y) * (b->x - a->x);
    const double s3 = (ax - a->x) * (by - a->y) - (ay - a->y) * (bx - a->x);
    return s0 * s1 < 0 && s2 * s3 < 0;
}

// How much of a leader runs through a box, by samples.
static double leader_through(const label *l, box b)
{
    double x, y;
    int inside = 0;
    leader_end(l, &x, &y);
    for (int i = 1; i < 16; i++) {
        const double px = l->x + (x - l->x) * i / 16, py = l->y + (y - l->y) * i / 16;
        inside += px > b.x0 && px < b.x1 && py > b.y0 && py < b.y1;
    }
    return inside;
}

static double label_cost(const labels *l, int which, const plot *p)
{
    const label *one = &l->list[which];
    const box own = label_box(one);
    const box wide = {own.x0 - 3, own.y0 - 2, own.x1 + 3, own.y1 + 2};
    const double outside = fmax(p->x + 2 - own.x0, 0) + fmax(own.x1 - p->x - p->width + 2, 0) +
                           fmax(p->y + 2 - own.y0, 0) + fmax(own.y1 - p->y - p->height + 2, 0);
    double x, y;
    leader_end(one, &x, &y);
    double cost = 2 * hypot(x - one->x, y - one->y) + 1000 * outside;
    for (int i = 0; i < l->count; i++) {
        const label *other = &l->list[i];
        const double r = l->clear;
        const box point = {other->x - r, other->y - r, other->x + r, other->y + r};
        cost += 20 * overlap(wide, point);
        if (i == which) continue;
        if (!other->text[0]) continue;
        const box b = label_box(other);
        cost +=
            40 * overlap(wide, b) + 200 * leader_through(one, b) + 200 * leader_through(other, own);
        if (hypot(other->x - one->x, other->y - one->y) > 2 * r)
            cost += 100 * leader_through(one, point);
        if (leaders_cross(one, other)) cost += 400;
    }
    return cost;
}

// Tries the places around a point, near ones first, and keeps the best.
static void label_settle(labels *l, int which, const plot *p)
{
    label *one = &l->list[which], best = *one;
    if (!one->text[0]) return;
    const double width = svg_text_width(one->text, one->size), size = fabs(one->size);
    double lowest = HUGE_VAL;
    for (int ring = 0; ring < 9; ring++) {
        for (int side = 0; side < 24; side++) {
            const double angle = side * 3.14159265358979 / 12, c = cos(angle), s = sin(angle);
            const double reach = l->clear + 2 + 9 * ring;
            // The box touches the circle with its nearest side or corner.
            one->left = one->x + reach * c + width * (c - 1) / 2;
            one->baseline = one->y + reach * s + size * (0.275 + 0.525 * s);
            const double cost = label_cost(l, which, p);
            if (cost >= lowest) continue;
            lowest = cost;
            best = *one;
        }
    }
    *one = best;
}

// Settles all labels, first put into that direction, and returns what the result costs.
static double labels_settle(labels *l, const plot *p, double angle)
{
    double cost = 0;
    for (int i = 0; i < l->count; i++) {
        label *one = &l->list[i];
        one->left = one->x + l->clear * cos(angle) +
                    svg_text_width(one->text, one->size) * (cos(angle) - 1) / 2;
        one->baseline = one->y + l->clear * sin(angle) + 4;
    }
    for (int round = 0; round < 12; round++)
        for (int i = 0; i < l->count; i++) label_settle(l, i, p);
    for (int i = 0; i < l->count; i++)
        if (l->list[i].text[0]) cost += label_cost(l, i, p);
    return cost;
}

static void draw_leader(const labels *l, const plot *p, const label *one)
{
    double x, y;
    leader_end(one, &x, &y);
    const double distance = hypot(x - one->x, y - one->y), from = l->clear / distance;
    if (distance > l->clear + 7)
        svg_line(p->svg, one->x + from * (x - one->x), one->y + from * (y - one->y), x, y,
                 COLOUR_FAINT, 0.7, false);
}

void labels_scatter(labels *l, const plot *p)
{
    enum { STARTS = 16 };
    labels best = *l;
    double lowest = HUGE_VAL;
    for (int start = 0; start < STARTS; start++) {
        const double cost = labels_settle(l, p, start * 2 * 3.14159265358979 / STARTS);
        if (cost >= lowest) continue;
        lowest = cost;
        best = *l;
    }
    *l = best;
    for (int i = 0; i < l->count; i++)
        if (l->list[i].text[0]) draw_leader(l, p, &l->list[i]);
    for (int i = 0; i < l->count; i++) {
        const label *one = &l->list[i];
        if (one->text[0])
            svg_text(p->svg, one->left, one->baseline, "start", one->ink, one->size, one->text);
    }
}

static void sort_by_height(labels *l)
{
    for (int i = 1; i < l->count; i++) {
        for (int k = i; k > 0 && l->list[k].y < l->list[k - 1].y; k--) {
            const label swap = l->list[k];
            l->list[k] = l->list[k - 1];
            l->list[k - 1] = swap;
        }
    }
}

void labels_stack(labels *l, const plot *p)
{
    sort_by_height(l);
    for (int round = 0; round < 400; round++) { // push neighbours apart, a little at a time
        for (int i = 0; i + 1 < l->count; i++) {
            label *a = &l->list[i], *b = &l->list[i + 1];
            const double lack = 1.2 * fabs(a->size) - (b->baseline - a->baseline);
            if (lack <= 0) continue;
            a->baseline -= lack / 2;
            b->baseline += lack / 2;
        }
        if (l->count) {
            label *first = &l->list[0], *last = &l->list[l->count - 1];
            first->baseline = fmax(first->baseline, p->y - 6);
            last->baseline = fmin(last->baseline, p->y + p->height + 6);
        }
    }
    for (int i = 0; i < l->count; i++) {
        const label *one = &l->list[i];
        const double left = p->x + p->width + 22;
        const double x[2] = {one->x + l->clear + 1, left - 4}, y[2] = {one->y, one->baseline};
        svg_polyline(p->svg, 2, x, y, COLOUR_FAINT, 0.7, false);
        svg_text(p->svg, left, one->baseline + 4, "start", one->ink, one->size, one->text);
    }
}
