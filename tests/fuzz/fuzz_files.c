// The readers of the examples: Radiance .hdr, .pfm and .obj, whole, cut short, damaged and hostile.
// What is read makes sense, what is not leaves a message and no memory, and memory asked for is
// bounded by the size of the file.
//     make fuzz FUZZ=files
#include "fuzz.h"

#include <errno.h>
#include <limits.h>
#include <stdbool.h>

// Stands between the readers, which are compiled right here, and the allocator.
static size_t asked; // bytes at once, by the largest call
static int living;

static void *count_malloc(size_t bytes)
{
    void *memory = malloc(bytes);
    asked = bytes > asked ? bytes : asked;
    living += memory != NULL;
    return memory;
}

static void *count_calloc(size_t count, size_t size)
{
    void *memory = calloc(count, size);
    asked = count * size > asked ? count * size : asked;
    living += memory != NULL;
    return memory;
}

static void *count_realloc(void *old, size_t bytes)
{
    void *memory = realloc(old, bytes);
    asked = bytes > asked ? bytes : asked;
    living += memory && !old;
    return memory;
}

static void count_free(void *memory)
{
    living -= memory != NULL;
    free(memory);
}

#define malloc count_malloc
#define calloc count_calloc
#define realloc count_realloc
#define free count_free
#define LIGHTPROBE_IMPLEMENTATION
#define LIGHTPROBE_NO_GL
#include "../../lightprobe.h"

#include "../../examples/common/file.c"
#include "../../examples/common/image.c"
#include "../../examples/common/obj.c"
#include "../../examples/common/png.c"
#include "../../examples/common/probe.c"
#undef malloc
#undef calloc
#undef realloc
#undef free

static void check_memory(size_t size, size_t each, const char *what)
{
    EXPECT(asked <= each * size + 10000, "%s: %lu bytes at once for a file of %lu", what,
           (unsigned long)asked, (unsigned long)size);
    asked = 0;
}

// Faces and lat-long pictures become probes, whatever their pixels; the rest is refused.
static void check_probe(const image *im)
{
    probe p;
    message why = {""};
    const bool made = probe_from_image(&p, im, 0, &why);
    EXPECT(made == !why.text[0], "made %d: %s", made, why.text);
    EXPECT(!made || (p.side >= 1 && p.texels), "a probe of %d x %d", im->width, im->height);
    for (int i = 0; made && i < 18 * p.side * p.side; i++)
        EXPECT(p.texels[i] >= 0 && p.texels[i] <= FLT_MAX, "texel %d", i / 3);
    if (made) probe_free(&p);
}

static void check_image(const uint8_t *data, size_t size)
{
    image im;
    message why = {""};
    const bool decoded = image_decode(&im, data, size, &why);
    check_memory(size, 800, "picture"); // the densest coding of .hdr
    EXPECT(decoded == !why.text[0], "decoded %d: %s", decoded, why.text);
    if (!decoded) {
        EXPECT(!im.rgb && living == 0, "%d blocks left behind by: %s", living, why.text);
        return;
    }
    EXPECT(im.rgb && im.width >= 1 && im.height >= 1, "%d x %d", im.width, im.height);
    float sum = 0; // reads all of it
    for (size_t i = 0; i < 3 * (size_t)im.width * (size_t)im.height; i++) sum += im.rgb[i];
    (void)sum;
    if ((size_t)im.width * (size_t)im.height <= 20000) check_probe(&im);
    asked = 0;
    image_free(&im);
    EXPECT(living == 0, "%d blocks left", living);
}

static void check_mesh(const uint8_t *data, size_t size)
{
    mesh m;
    message why = {""};
    const bool parsed = mesh_parse_obj(&m, (const char *)data, size, &why);
    check_memory(size, 24, "mesh");
    EXPECT(parsed == !why.text[0] && !strchr(why.text, '\n'), "parsed %d: %s", parsed, why.text);
    if (!parsed) {
        EXPECT(living == 0 && !m.position && !m.triangle, "%d blocks left behind by: %s", living,
               why.text);
        return;
    }
    for (int i = 0; i < 3 * m.triangles; i++) {
        const int v = m.triangle[i / 3][i % 3];
        EXPECT(v >= 0 && v < m.vertices, "corner %d of %d", v, m.vertices);
    }
    for (int i = 0; i < m.vertices; i++)
        EXPECT(isfinite(m.position[i].x) && isfinite(m.position[i].y) && isfinite(m.position[i].z),
               "vertex %d", i);
    mesh_free(&m);
    EXPECT(living == 0, "%d blocks left", living);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    check_image(data, size);
    check_mesh(data, size);
    return 0;
}
