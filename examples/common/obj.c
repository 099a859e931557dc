// Wavefront OBJ: the v and f lines, everything else is passed over.
#include "scene.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

typedef struct parser {
    mesh *m;
    int vertex_room, triangle_room;
    int line;
    message *why;
} parser;

static bool no_memory(parser *p)
{
    return fail(p->why, "line %d: no memory", p->line);
}

static const char *skip_blanks(const char *at)
{
    while (*at == ' ' || *at == '\t') at++;
    return at;
}

// Numbers end where the line ends: the text is one string, and strtod would look for a number
// behind the newline.
static bool parse_number(const char **at, double *value)
{
    char *end;
    *at = skip_blanks(*at);
    if (*at[0] == '\n' || *at[0] == '\r' || *at[0] == 0) return false;
    *value = strtod(*at, &end);
    if (end == *at) return false;
    *at = end;
    return true;
}

static bool parse_vertex(parser *p, const char *at)
{
    mesh *m = p->m;
    double c[3];
    for (int i = 0; i < 3; i++) {
        // The negation also catches NaN. 1e18 is the most whose square is still a float.
        if (!parse_number(&at, &c[i]) || !(fabs(c[i]) < 1e18)) {
            return fail(p->why, "line %d: a vertex needs three finite numbers", p->line);
        }
    }
    if (m->vertices == p->vertex_room) {
        const int room = p->vertex_room * 2 + 256;
        vec3 *larger = realloc(m->position, (size_t)room * sizeof *larger);
        if (!larger) return no_memory(p);
        m->position = larger;
        p->vertex_room = room;
    }
    m->position[m->vertices++] = vec((float)c[0], (float)c[1], (float)c[2]);
    return true;
}

// One "7", "7/1", "7//3" or "-1/..." as an index from 0; false at the end of the line. Whether the
// vertex exists is asked when all are known: it may come later in the file.
static bool parse_corner(parser *p, const char **at, int *index, bool *broken)
{
    *at = skip_blanks(*at);
    if (!**at || strchr("\r\n#", **at)) return false;
    char *end;
    const long value = strtol(*at, &end, 10);
    *broken = end == *at || value == 0 || value > INT_MAX || value < -p->m->vertices;
    *index = *broken ? 0 : (int)(value > 0 ? value - 1 : value + p->m->vertices);
    *at = end + strcspn(end, " \t\r\n");
    return true;
}

static bool add_face_triangle(parser *p, int a, int b, int c)
{
    mesh *m = p->m;
    if (m->triangles == p->triangle_room) {
        const int room = p->triangle_room * 2 + 256;
        int(*larger)[3] = realloc(m->triangle, (size_t)room * sizeof *larger);
        if (!larger) return no_memory(p);
        m->triangle = larger;
        p->triangle_room = room;
    }
    m->triangle[m->triangles][0] = a;
    m->triangle[m->triangles][1] = b;
    m->triangle[m->triangles++][2] = c;
    return true;
}

static bool parse_face(parser *p, const char *at)
{
    int first = 0, previous = 0, index, count = 0;
    bool broken;
    for (; parse_corner(p, &at, &index, &broken); count++) {
        if (broken) return fail(p->why, "line %d: a face names no such vertex", p->line);
        if (count >= 2 && !add_face_triangle(p, first, previous, index)) return false;
        if (count == 0) first = index;
        previous = index;
    }
    return count >= 3 || fail(p->why, "line %d: a face needs three corners", p->line);
}

static bool parse_text(parser *p, const char *text)
{
    for (const char *line = text; *line; p->line++) {
        const char *at = skip_blanks(line), *end = strchr(line, '\n');
        const bool word = at[0] && (at[1] == ' ' || at[1] == '\t');
        if (word && at[0] == 'v' && !parse_vertex(p, at + 1)) return false;
        if (word && at[0] == 'f' && !parse_face(p, at + 1)) return false;
        if (!end) break;
        line = end + 1;
    }
    for (int i = 0; i < 3 * p->m->triangles; i++) {
        const int index = p->m->triangle[i / 3][i % 3];
        if (index >= p->m->vertices) {
            return fail(p->why, "a face names vertex %d of %d", index + 1, p->m->vertices);
        }
    }
    return p->m->triangles > 0 || fail(p->why, "no faces");
}

bool mesh_parse_obj(mesh *m, const char *text, size_t size, message *why)
{
    parser p = {m, 0, 0, 1, why};
    memset(m, 0, sizeof *m);
    // The file need not end in a newline, and may hold zero bytes: a string ends at the first.
    char *copy = malloc(size + 1);
    if (!copy) return no_memory(&p);
    memcpy(copy, text, size);
    copy[size] = 0;
    const bool parsed = parse_text(&p, copy);
    free(copy);
    if (!parsed) mesh_free(m);
    return parsed;
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
