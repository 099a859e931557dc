// Wavefront OBJ: the v and f lines, in every dialect that exporters write. Lines of texture
// coordinates, normals, groups and materials are passed over.
#include "scene.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

// Corners looked at for one concave polygon: a second or two. Mostly it takes the square of their
// number, at worst the cube.
#define OBJ_WORK_MOST 300000000

typedef struct obj_vertex {
    double at[3];
    int line;
    int index; // in the mesh; -1 if no face uses it
} obj_vertex;

typedef struct obj_face {
    int first, corners, line;
} obj_face;

typedef struct parser {
    obj_vertex *vertex;
    obj_face *face;
    int *corner; // of all faces: places in vertex
    int vertices, faces, corners;
    int vertex_room, face_room, corner_room;
    int line;
    mesh *m;
    int triangle_room;
    message *why;
} parser;

static bool no_memory(parser *p)
{
    return fail(p->why, "line %d: no memory", p->line);
}

// The list with room for one more; NULL, and it stays as it was, when memory runs out.
static void *grow(parser *p, void *list, int count, int *room, size_t size)
{
    if (count < *room) return list;
    const int larger = *room + *room / 2 + 64;
    void *moved = realloc(list, (size_t)larger * size);
    if (moved)
        *room = larger;
    else
        no_memory(p);
    return moved;
}

// ---- Lines and numbers

static char *skip_blanks(char *at)
{
    return at + strspn(at, " \t\v\f");
}

static bool ends_word(char c)
{
    return !c || strchr(" \t\v\f\r\n#", c);
}

static char *obj_line_end(char *at)
{
    return at + strcspn(at, "\r\n");
}

// Past LF, CR LF, or CR alone.
static char *obj_next_line(char *end)
{
    return end + (end[0] == '\r' && end[1] == '\n' ? 2 : end[0] != 0);
}

// A backslash at its end continues a line: both and the line end become blanks. Only lines that are
// read are joined: comments and names may end in a backslash without meaning it.
static char *join_lines(char *at, int *lines)
{
    for (;;) {
        at += strcspn(at, "\\#\r\n");
        char *end = skip_blanks(at + (*at == '\\'));
        if (*at != '\\' || !(*end == 0 || *end == '\r' || *end == '\n')) return obj_line_end(at);
        *lines += *end != 0;
        end = obj_next_line(end);
        while (at < end) *at++ = ' ';
    }
}

// One coordinate. Numbers end where the line ends: strtod would look for one behind it.
static bool parse_number(char **at, double *value)
{
    char *end;
    *at = skip_blanks(*at);
    if (ends_word(**at)) return false;
    *value = strtod(*at, &end);
    if (end == *at) return false;
    if (end[-1] == '.' && *end == '#') { // 1.#QNAN, 1.#INF: Microsoft's
        *value = HUGE_VAL;
        end += 1 + strcspn(end + 1, " \t\v\f\r\n");
    }
    *at = end;
    return ends_word(*end);
}

static bool parse_vertex(parser *p, char *at)
{
    obj_vertex v = {.line = p->line, .index = -1};
    for (int i = 0; i < 3; i++) {
        if (!parse_number(&at, &v.at[i]))
            return fail(p->why, "line %d: a vertex needs three numbers", p->line);
    }
    obj_vertex *list = grow(p, p->vertex, p->vertices, &p->vertex_room, sizeof v);
    if (!list) return false;
    p->vertex = list;
    list[p->vertices++] = v;
    return true;
}

// One "7", "7/1", "7//3" or "-1/..." as an index from 0; false at the end of the line. Whether the
// vertex exists is asked when all are known: it may come later in the file.
static bool parse_corner(parser *p, char **at, int *index, bool *broken)
{
    *at = skip_blanks(*at);
    if (ends_word(**at)) return false;
    char *end;
    const long value = strtol(*at, &end, 10);
    *broken = end == *at || value == 0 || value > INT_MAX || value < -p->vertices ||
              !(*end == '/' || ends_word(*end));
    *index = *broken ? 0 : (int)(value > 0 ? value - 1 : value + p->vertices);
    *at = end;
    while (!ends_word(**at)) ++*at;
    return true;
}

// Faces of one or two corners are points and lines, which have no area.
static bool parse_face(parser *p, char *at)
{
    obj_face f = {p->corners, 0, p->line};
    int index;
    bool broken;
    for (; parse_corner(p, &at, &index, &broken); f.corners++) {
        if (broken) return fail(p->why, "line %d: a face names no such vertex", p->line);
        int *corner = grow(p, p->corner, p->corners, &p->corner_room, sizeof index);
        if (!corner) return false;
        p->corner = corner;
        corner[p->corners++] = index;
    }
    obj_face *list = grow(p, p->face, p->faces, &p->face_room, sizeof f);
    if (!list) return false;
    p->face = list;
    list[p->faces++] = f;
    return true;
}

// What gives a shape that would be missing: surfaces, other files, and what faces and patches were
// called before 1990.
static bool is_unread(const char *at)
{
    static const char *const words[] = {"surf", "call", "fo", "bsp", "bzp"};
    const size_t length = strcspn(at, " \t\v\f\r\n");
    for (int i = 0; i < 5; i++) {
        if (length == strlen(words[i]) && !strncmp(at, words[i], length)) return true;
    }
    return false;
}

// A vertex or a face, not vn or usemtl. What follows may be missing or be no blank, one of UTF-8 say:
// a vertex that is passed over gives all later ones wrong numbers.
static bool is_word(const char *at)
{
    const char after = at[0] == 'v' || at[0] == 'f' ? at[1] : 'x';
    return !((after >= 'a' && after <= 'z') || (after >= 'A' && after <= 'Z'));
}

static bool parse_text(parser *p, char *text)
{
    for (char *line = text; *line; p->line++) {
        char *at = skip_blanks(line), *end;
        int more = 0;
        const bool word = is_word(at);
        end = word ? join_lines(at, &more) : obj_line_end(at);
        if (word && !(at[0] == 'v' ? parse_vertex : parse_face)(p, at + 1)) return false;
        if (is_unread(at)) {
            return fail(p->why, "line %d: %.*s is not read", p->line,
                        (int)strcspn(at, " \t\v\f\r\n"), at);
        }
        p->line += more;
        line = obj_next_line(end);
    }
    return true;
}

// ---- Polygons to triangles

static bool add_triangle(parser *p, int a, int b, int c)
{
    mesh *m = p->m;
    int(*list)[3] = grow(p, m->triangle, m->triangles, &p->triangle_room, sizeof *list);
    if (!list) return false;
    m->triangle = list;
    int *t = list[m->triangles++];
    t[0] = p->vertex[a].index;
    t[1] = p->vertex[b].index;
    t[2] = p->vertex[c].index;
    return true;
}

typedef struct flat_point {
    double x, y;
    int vertex;
} flat_point;

// Twice the area, positive if counter-clockwise.
static double turn_of(const flat_point *a, const flat_point *b, const flat_point *c)
{
    return (b->x - a->x) * (c->y - a->y) - (b->y - a->y) * (c->x - a->x);
}

// The polygon as it looks along the largest component of its normal (Newell's, which also fits
// polygons that are not quite flat), counter-clockwise.
static void flatten(const parser *p, const obj_face *f, flat_point *flat)
{
    double normal[3] = {0};
    const int *corner = p->corner + f->first;
    const double *origin = p->vertex[corner[0]].at; // large numbers would drown the differences
    for (int i = 0; i < f->corners; i++) {
        const double *a = p->vertex[corner[i]].at, *b = p->vertex[corner[(i + 1) % f->corners]].at;
        for (int k = 0; k < 3; k++) {
            const int u = (k + 1) % 3, v = (k + 2) % 3;
            normal[k] +=
                (a[u] - origin[u]) * (b[v] - origin[v]) - (a[v] - origin[v]) * (b[u] - origin[u]);
        }
    }
    int k = fabs(normal[1]) > fabs(normal[0]);
    if (fabs(normal[2]) > fabs(normal[k])) k = 2;
    const int u = (k + (normal[k] < 0 ? 2 : 1)) % 3, v = 3 - k - u;
    for (int i = 0; i < f->corners; i++) {
        const double *a = p->vertex[corner[i]].at;
        flat[i] = (flat_point){a[u] - origin[u], a[v] - origin[v], corner[i]};
    }
}

static bool same_place(const flat_point *a, const flat_point *b)
{
    return a->x == b->x && a->y == b->y;
}

// Leaves out corners that repeat the one before and spikes, which go out and back: they have no area
// and hide that a polygon is concave. Returns how many are left.
static int drop_repeats(flat_point *flat, int count)
{
    int kept = 0;
    for (int i = 0; i < count; i++) {
        flat[kept++] = flat[i];
        if (kept > 1 && same_place(flat + kept - 1, flat + kept - 2)) kept--;
        if (kept > 2 && same_place(flat + kept - 1, flat + kept - 3)) kept -= 2;
    }
    for (bool dropped = true; dropped && kept > 2;) { // where the last corner meets the first
        const bool repeated = same_place(flat + kept - 1, flat);
        const bool tip = same_place(flat + kept - 1, flat + 1);
        dropped = repeated || tip || same_place(flat + kept - 2, flat);
        if (dropped) kept -= repeated ? 1 : 2;
        if (dropped && !repeated && tip) memmove(flat, flat + 1, (size_t)kept * sizeof *flat);
    }
    return kept;
}

static bool is_convex(const flat_point *flat, int count)
{
    for (int i = 0; i < count; i++) {
        if (turn_of(flat + i, flat + (i + 1) % count, flat + (i + 2) % count) < 0) return false;
    }
    return true;
}

// Whether the triangle at b holds no other corner. Those in the place of one of its own are let in:
// the bridges to holes run along themselves.
static bool is_ear(const flat_point *flat, int count, int b)
{
    const flat_point *c[3] = {flat + (b + count - 1) % count, flat + b, flat + (b + 1) % count};
    if (!(turn_of(c[0], c[1], c[2]) > 0)) return false;
    for (int i = 0; i < count; i++) {
        const flat_point *q = flat + i;
        bool own = false, inside = true;
        for (int k = 0; k < 3; k++) {
            own |= same_place(q, c[k]);
            inside &= turn_of(c[k], c[(k + 1) % 3], q) >= 0;
        }
        if (inside && !own) return false;
    }
    return true;
}

// Cuts ears off (Meisters 1975) until three corners are left. A polygon that crosses itself may
// come to have none: then any corner is cut.
static bool cut_ears(parser *p, const obj_face *f, flat_point *flat, int count)
{
    long long work = 0;
    for (int b = 0, tried = 0; count > 3;) {
        b %= count;
        const int a = (b + count - 1) % count, c = (b + 1) % count;
        work += count;
        if (work > OBJ_WORK_MOST)
            return fail(p->why, "line %d: a polygon of too many corners", f->line);
        const bool straight = turn_of(flat + a, flat + b, flat + c) == 0;
        if (tried < count && !is_ear(flat, count, b)) {
            b++;
            tried++;
            continue;
        }
        // (A corner that lies on the line of its neighbours is no ear, and cut when nothing else
        // is.)
        if (!straight && !add_triangle(p, flat[a].vertex, flat[b].vertex, flat[c].vertex))
            return false;
        memmove(flat + b, flat + b + 1, (size_t)(count - b - 1) * sizeof *flat);
        count--;
        tried = 0;
    }
    return add_triangle(p, flat[0].vertex, flat[1].vertex, flat[2].vertex);
}

static bool triangulate(parser *p, const obj_face *f, flat_point *flat)
{
    if (f->corners < 3) return true;
    flatten(p, f, flat);
    const int count = f->corners > 3 ? drop_repeats(flat, f->corners) : 3;
    if (count > 3 && !is_convex(flat, count)) return cut_ears(p, f, flat, count);
    for (int i = 2; i < count; i++) {
        if (!add_triangle(p, flat[0].vertex, flat[i - 1].vertex, flat[i].vertex)) return false;
    }
    return true;
}

// ---- The mesh

// Checks what faces use, and numbers it; *most is the largest number of corners.
static bool find_used(parser *p, int *most)
{
    for (int i = 0; i < p->faces; i++) {
        const obj_face *f = p->face + i;
        if (f->corners > *most) *most = f->corners;
        for (int k = 0; k < f->corners; k++) {
            const int corner = p->corner[f->first + k];
            if (corner >= p->vertices) {
                return fail(p->why, "line %d: a face names vertex %d of %d", f->line, corner + 1,
                            p->vertices);
            }
            obj_vertex *v = p->vertex + corner;
            if (f->corners < 3) continue;
            for (int a = 0; a < 3; a++) {
                // The negation also catches NaN. 1e18 is the most whose square is still a float.
                if (!(fabs(v->at[a]) < 1e18))
                    return fail(
                        p->why,
                        "line %d: a face uses this vertex, whose numbers must be finite and below 1e18",
                        v->line);
            }
            v->index = 0;
        }
    }
    for (int i = 0; i < p->vertices; i++) {
        if (p->vertex[i].index == 0) p->vertex[i].index = p->m->vertices++;
    }
    return *most >= 3 || fail(p->why, "no faces");
}

// Of a mesh far from its origin, as maps of the land are, floats would keep little: they are
// counted from its middle then.
static bool put_vertices(parser *p)
{
    mesh *m = p->m;
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL},
           size = 0;
    m->position = malloc((size_t)m->vertices * sizeof *m->position);
    if (!m->position) return no_memory(p);
    for (int i = 0; i < 3 * p->vertices; i++) {
        const obj_vertex *v = p->vertex + i / 3;
        if (v->index < 0) continue;
        low[i % 3] = fmin(low[i % 3], v->at[i % 3]);
        high[i % 3] = fmax(high[i % 3], v->at[i % 3]);
    }
    for (int k = 0; k < 3; k++) size = fmax(size, high[k] - low[k]);
    for (int k = 0; k < 3; k++) {
        const double middle = 0.5 * (low[k] + high[k]);
        if (fabs(middle) > 16 * size) m->origin[k] = middle;
    }
    for (int i = 0; i < p->vertices; i++) {
        const obj_vertex *v = p->vertex + i;
        if (v->index < 0) continue;
        m->position[v->index] =
            vec((float)(v->at[0] - m->origin[0]), (float)(v->at[1] - m->origin[1]),
                (float)(v->at[2] - m->origin[2]));
    }
    return true;
}

static bool make_mesh(parser *p)
{
    int most = 0;
    if (!find_used(p, &most) || !put_vertices(p)) return false;
    flat_point *flat = malloc((size_t)most * sizeof *flat);
    bool made = flat || no_memory(p);
    for (int i = 0; i < p->faces && made; i++) made = triangulate(p, p->face + i, flat);
    free(flat);
    return made && (p->m->triangles > 0 || fail(p->why, "no faces"));
}

bool mesh_parse_obj(mesh *m, const char *text, size_t size, message *why)
{
    parser p = {.line = 1, .m = m, .why = why};
    const size_t mark = size >= 3 && !memcmp(text, "\xef\xbb\xbf", 3) ? 3 : 0; // of UTF-8
    memset(m, 0, sizeof *m);
    const char *zero = memchr(text, 0, size);
    if (zero) {
        for (const char *at = text; at < zero; at++) p.line += *at == '\n';
        return fail(why, "line %d: a zero byte, so no plain text (UTF-16 must be saved as UTF-8)",
                    p.line);
    }
    char *copy = malloc(size - mark + 1); // as a string: the file need not end in a newline
    if (!copy) return no_memory(&p);
    memcpy(copy, text + mark, size - mark);
    copy[size - mark] = 0;
    const bool made = parse_text(&p, copy) && make_mesh(&p);
    free(copy);
    free(p.vertex);
    free(p.face);
    free(p.corner);
    if (!made) mesh_free(m);
    return made;
}

bool mesh_load_obj(mesh *m, const char *path, message *why)
{
    unsigned char *bytes;
    size_t size;
    message reason;
    memset(m, 0, sizeof *m);
    if (!file_read(path, &bytes, &size, why)) return false;
    const bool parsed = mesh_parse_obj(m, (const char *)bytes, size, &reason);
    free(bytes);
    return parsed || fail(why, "%s: %.180s", path, reason.text);
}

void mesh_free(mesh *m)
{
    free(m->position);
    free(m->triangle);
    memset(m, 0, sizeof *m);
}
