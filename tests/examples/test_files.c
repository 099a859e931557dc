// What the examples build on: picture and mesh files, probes, the rasterizer and the ray tracer.
#include "../support/test.h"

#include "../../examples/common/image.h"
#include "../../examples/common/lighting.h"
#include "../../examples/common/options.h"
#include "../../examples/common/png.h"
#include "../../examples/common/probe.h"
#include "../../examples/common/raster.h"
#include "../../examples/common/raytrace.h"
#include "../../examples/common/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

// A growing string of bytes to build files in.
typedef struct bytes {
    unsigned char at[1 << 16];
    size_t size;
} bytes;

static void put(bytes *b, int byte)
{
    b->at[b->size++] = (unsigned char)byte;
}

static void put_text(bytes *b, const char *text)
{
    while (*text) put(b, *text++);
}

// Decodes from a block of exactly that size, so that a sanitizer sees every read past the end.
static bool decode_exact(image *im, const unsigned char *data, size_t size, message *why)
{
    unsigned char *copy = malloc(size ? size : 1);
    memcpy(copy, data, size);
    const bool decoded = image_decode(im, size ? copy : copy + 1, size, why);
    free(copy);
    return decoded;
}

// ---- Pictures in

static void put_float(bytes *b, float value, bool little)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    for (int i = 0; i < 4; i++) put(b, (int)(bits >> (little ? 8 * i : 24 - 8 * i) & 255));
}

static void pfm_keeps_values(void)
{
    static bytes b;
    const float value[4] = {-1.5f, INFINITY, NAN, 3e-42f};
    for (int kind = 0; kind < 4; kind++) {
        const bool little = kind & 1, grey = kind & 2;
        const int channels = grey ? 1 : 3;
        image im;
        message why = {{0}};
        b.size = 0;
        put_text(&b, grey ? "Pf\n" : "PF\n");
        put_text(&b, little ? "3 2\n-1.0\n" : "3 2\n1.0\n");
        for (int i = 0; i < 6 * channels; i++) {
            put_float(&b, i % 5 == 4 ? (float)i : value[i % 5], little);
        }
        CHECK(decode_exact(&im, b.at, b.size, &why), "kind %d: %s", kind, why.text);
        if (!im.rgb) return;
        for (int i = 0; i < 18; i++) {
            // The file's first row is the lowest.
            const int x = i / 3 % 3, y = 1 - i / 9,
                      k = grey ? (y * 3 + x) : (y * 3 + x) * 3 + i % 3;
            const float want = k % 5 == 4 ? (float)k : value[k % 5];
            CHECK(!memcmp(&im.rgb[i], &want, sizeof want), "kind %d, value %d: %g for %g", kind, i,
                  (double)im.rgb[i], (double)want);
        }
        image_free(&im);
    }
}

enum { HDR_WIDTH = 19, HDR_HEIGHT = 5 };

static void hdr_pixel(int x, int y, unsigned char p[4])
{
    // Runs of equal pixels, none of which looks like a mark of the run-length codings.
    p[0] = (unsigned char)(40 + x / 6 * 13 + y);
    p[1] = (unsigned char)(x > 11 ? 200 : 3 * x);
    p[2] = (unsigned char)(y * 50);
    p[3] = (unsigned char)(y == 4 ? 0 : 120 + y * 4 + x / 10);
}

static void put_row_old(bytes *b, int y)
{
    unsigned char p[4], last[4] = {1, 1, 1, 0};
    for (int x = 0; x < HDR_WIDTH; x++) {
        hdr_pixel(x, y, p);
        int run = 0;
        while (x > 0 && x + run < HDR_WIDTH && !memcmp(p, last, 4)) {
            if (x + ++run < HDR_WIDTH) hdr_pixel(x + run, y, p);
        }
        if (run) {
            for (int i = 0; i < 3; i++) put(b, 1);
            put(b, run);
            x += run - 1;
            continue;
        }
        for (int i = 0; i < 4; i++) put(b, last[i] = p[i]);
    }
}

static void put_row_new(bytes *b, int y)
{
    put_text(b, "\2\2");
    put(b, 0);
    put(b, HDR_WIDTH);
    for (int c = 0; c < 4; c++) {
        for (int x = 0; x < HDR_WIDTH;) {
            unsigned char p[4], q[4];
            int run = 1;
            hdr_pixel(x, y, p);
            while (x + run < HDR_WIDTH && (hdr_pixel(x + run, y, q), q[c] == p[c])) run++;
            put(b, run > 2 ? 128 + run : 1);
            put(b, p[c]);
            x += run > 2 ? run : 1;
        }
    }
}

// coding 0: flat, 1: old runs, 2: new runs.
static void make_hdr(bytes *b, int coding, const char *sizes)
{
    b->size = 0;
    put_text(b, "#?RADIANCE\n# made by a test\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1\n\n");
    put_text(b, sizes);
    for (int y = 0; y < HDR_HEIGHT; y++) {
        if (coding == 1)
            put_row_old(b, y);
        else if (coding == 2)
            put_row_new(b, y);
        for (int x = 0; coding == 0 && x < HDR_WIDTH; x++) {
            unsigned char p[4];
            hdr_pixel(x, y, p);
            for (int i = 0; i < 4; i++) put(b, p[i]);
        }
    }
}

static void hdr_codings_agree(void)
{
    static bytes b;
    for (int kind = 0; kind < 5; kind++) {
        const bool flip_x = kind == 3, flip_y = kind == 4;
        image im;
        message why = {{0}};
        make_hdr(&b, kind < 3 ? kind : 2,
                 flip_x   ? "-Y 5 -X 19\n"
                 : flip_y ? "+Y 5 +X 19\n"
                          : "-Y 5 +X 19\n");
        CHECK(decode_exact(&im, b.at, b.size, &why), "kind %d: %s", kind, why.text);
        if (!im.rgb) continue;
        CHECK(im.width == HDR_WIDTH && im.height == HDR_HEIGHT, "%d x %d", im.width, im.height);
        for (int i = 0; i < HDR_WIDTH * HDR_HEIGHT; i++) {
            const int x = i % HDR_WIDTH, y = i / HDR_WIDTH;
            unsigned char p[4];
            hdr_pixel(flip_x ? HDR_WIDTH - 1 - x : x, flip_y ? HDR_HEIGHT - 1 - y : y, p);
            const double unit = p[3] ? pow(2, p[3] - 136) : 0;
            for (int c = 0; c < 3; c++) {
                CHECK((double)im.rgb[3 * i + c] == p[c] * unit, "kind %d, pixel %d,%d", kind, x, y);
            }
        }
        image_free(&im);
    }
}

static void truncated_pictures_are_refused(void)
{
    static bytes b;
    for (int kind = 0; kind < 4; kind++) {
        image im;
        message why;
        if (kind < 3) {
            make_hdr(&b, kind, "-Y 5 +X 19\n");
        } else {
            b.size = 0;
            put_text(&b, "PF\n4 3\n-1.0\n");
            for (int i = 0; i < 36; i++) put_float(&b, 1, true);
        }
        for (size_t size = 0; size < b.size; size++) {
            why.text[0] = 0;
            const bool decoded = decode_exact(&im, b.at, size, &why);
            CHECK(!decoded && !im.rgb, "kind %d of %d bytes passed", kind, (int)size);
            CHECK(why.text[0] && !strchr(why.text, '\n'), "kind %d: \"%s\"", kind, why.text);
        }
        CHECK(decode_exact(&im, b.at, b.size, &why), "kind %d whole: %s", kind, why.text);
        image_free(&im);
    }
}

static void hostile_headers_are_refused(void)
{
    const char *text[] = {
        "",
        "P",
        "PF",
        "PF\n",
        "P6\n2 2\n255\nabcdefghijkl",
        "PF\n-1 2\n-1\n",
        "PF\n0 1\n-1\n",
        "PF\n2147483647 2147483647\n-1\n",
        "PF\n99999999999999999999 1\n-1\n",
        "PF\n1 1\n0\nabcdefghijkl",
        "PF\n1 1\nnan\nabcdefghijkl",
        "PF\n1 1\nx\nabcdefghijkl",
        "PF\n1x 1\n-1\nabcdefghijkl",
        "PF\n32768 32768\n-1\nabc",
        "#?",
        "#?RADIANCE\n",
        "#?RADIANCE\n\n",
        "#?RADIANCE\n\n-Y\n",
        "#?RADIANCE\n\n-Y 1 +X 99999999\n",
        "#?RADIANCE\n\n-Y 32768 +X 32768\n\1\1\1\377",
        "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\nabcd",
        "#?RADIANCE\n\n+X 1 -Y 1\nabcd",
        "#?RADIANCE\n\n-Y 1 +X 1\n\1\1\1\1#",
        "#?RADIANCE\n\n-Y 1 +X 9\nabcd\1\1\1\377",
        "#?RADIANCE\n\n-Y 1 +X 8\n\2\2\1\1",
        "#?RADIANCE\n\n?Y 1 ?X 1\nabcd",
    };
    for (size_t i = 0; i < sizeof text / sizeof *text; i++) {
        image im;
        message why = {{0}};
        const bool decoded =
            decode_exact(&im, (const unsigned char *)text[i], strlen(text[i]), &why);
        CHECK(!decoded && !im.rgb && why.text[0], "header %d passed", (int)i);
        if (decoded) image_free(&im);
    }
}

// Every dialect of the header, whatever byte the values begin with, whole, with bytes behind, and
// cut short.
static void pfm_headers_have_dialects(void)
{
    static bytes b;
    const struct {
        const char *text;
        bool lines; // not all in one: then a byte too few is noticed
    } header[] = {
        {"PF\n3 2\n-1.0\n", true},
        {"PF\r\n3 2\r\n-1.0\r\n", true},
        {"PF\r3 2\r-1.0\r", true},
        {"PF\n3 2\n-1.0 \t \n", true},
        {"PF 3 2 -1.000000 \n", false},
        {"PF 3 2 -1\r\n", false},
        {"PF 3 2 -1 ", false},
        {"PF\n3 2\n-1 ", true},
        {"PF\n# by a tool\n3 # w\n#\n2\n-1.0\n", true},
        {"PF#x\r\n# y\r\n 3\r\n\r\n2 -1.0 # z\r\n", true},
        {"PF\n3 2\n-1.0\n# late\n# er\n", true},
        {"PF4\n3 2\n-1.0\n", true},
        {"\xef\xbb\xbfPF\n3 2\n-1.0\n", true},
    };
    const char first[] = "\n\r #\t\1\0\x40";
    for (size_t k = 0; k < sizeof header / sizeof *header; k++) {
        const char *text = header[k].text;
        const int channels = strstr(text, "PF4") ? 4 : 3;
        for (size_t f = 0; f < sizeof first; f++) {
            for (int more = -3; more < 3; more++) {
                image im;
                message why = {{0}};
                float value[24];
                b.size = 0;
                put_text(&b, text);
                const size_t start = b.size;
                for (int i = 0; i < 6 * channels; i++)
                    put_float(&b, value[i] = 1.5f + (float)i, true);
                b.at[start] = (unsigned char)first[f];
                memcpy(value, b.at + start, 4);
                if (more > 0) put_text(&b, more > 1 ? "\n\n" : "\n");
                if (more < 0) b.size -= (size_t)-more;
                const bool decoded = decode_exact(&im, b.at, b.size, &why);
                // Blanks that begin the values, behind a blank and not at a file's exact end, are
                // lost: what then misses bytes is refused, as is a file cut short. One header in a
                // single line cannot tell either from the other.
                const bool blank = f < 5, tail = text[strlen(text) - 1] == ' ';
                if (more < 0)
                    CHECK(!decoded || !header[k].lines, "header %d cut by %d", (int)k, -more);
                if (more == 0 && (!tail || !header[k].lines || f > 1))
                    CHECK(decoded, "header %d, byte %d: %s", (int)k, (int)f, why.text);
                if (more > 0 && !blank)
                    CHECK(decoded, "header %d, byte %d, %d more: %s", (int)k, (int)f, more,
                          why.text);
                if (decoded && more >= 0 && (more == 0 || !blank)) {
                    bool right = im.width == 3 && im.height == 2;
                    for (int i = 0; i < 18; i++) {
                        const int from = (1 - i / 9) * 3 * channels + i / 3 % 3 * channels + i % 3;
                        right = right && !memcmp(im.rgb + i, value + from, 4);
                    }
                    CHECK(right, "header %d, byte %d, %d more: wrong values", (int)k, (int)f, more);
                }
                image_free(&im);
            }
        }
    }
}

static void hdr_headers_have_dialects(void)
{
    const struct {
        const char *lines;
        double scale[3]; // 0: refused
        const char *reason;
    } header[] = {
        {"FORMAT=32-bit_rle_rgbe\n", {1, 1, 1}, ""},
        {"FORMAT= 32-bit_rle_rgbe  \r\n", {1, 1, 1}, ""},
        {"FORMAT = 32-bit_rle_rgbe\n", {1, 1, 1}, ""},
        {"", {1, 1, 1}, ""},
        {"EXPOSURE=4.0\nGAMMA=1.0\n", {0.25, 0.25, 0.25}, ""},
        {"EXPOSURE= 4\nEXPOSURE=.5 \r\n", {0.5, 0.5, 0.5}, ""},
        {"COLORCORR=1 2 4\nEXPOSURE=2\n", {0.5, 0.25, 0.125}, ""},
        {"# EXPOSURE=4\nVIEW= -vp 0 0 0\nPIXASPECT=1\nSOFTWARE=a=b\nnothing\n", {1, 1, 1}, ""},
        {"PRIMARIES=.640 .330 .290 .600 .150 .060 .333 .333\n", {1, 1, 1}, ""},
        {"PRIMARIES= 0.6400 0.3300 0.3000 0.6000 0.1500 0.0600 0.3127 0.3290\n", {1, 1, 1}, ""},
        {"PRIMARIES=.708 .292 .170 .797 .131 .046 .3127 .3290\n", {0}, "line 2"},
        {"x=1\nEXPOSURE=0\n", {0}, "line 3"},
        {"EXPOSURE=-1\n", {0}, "EXPOSURE=-1"},
        {"EXPOSURE=1e99999\n", {0}, "line 2"},
        {"EXPOSURE=nan\n", {0}, "line 2"},
        {"EXPOSURE=1x\n", {0}, "line 2"},
        {"EXPOSURE=\n", {0}, "line 2"},
        {"EXPOSURE=1e20\nEXPOSURE=1e20\n", {0}, "line 3"},
        {"COLORCORR=1 2\n", {0}, "line 2"},
        {"GAMMA=2.2\n", {0}, "not linear"},
        {" EXPOSURE=2\n COLORCORR= 1 1 2\n", {0.5, 0.5, 0.25}, ""},
        // Behind tabs: pictures that pcompos put together, at the values that they had.
        {"a.hdr:\n\tEXPOSURE=2\n\tCOLORCORR=1 1 2\npcompos a.hdr 0 0\n", {1, 1, 1}, ""},
        {"FORMAT=32-bit_rle_xyze\n", {0}, "32-bit_rle_xyze"},
        {" FORMAT=32-bit_rle_xyze\n", {0}, "32-bit_rle_xyze"},
    };
    for (size_t k = 0; k < sizeof header / sizeof *header; k++) {
        image im;
        message why = {{0}};
        char text[256];
        sprintf(text, "#?RADIANCE\n%s\n -Y 1 +X  2 \r\n\200\100\040\201\100\040\020\200",
                header[k].lines);
        const bool decoded = decode_exact(&im, (const unsigned char *)text, strlen(text), &why);
        CHECK(decoded == (header[k].scale[0] > 0), "header %d: %s", (int)k, why.text);
        CHECK(decoded || strstr(why.text, header[k].reason), "header %d: \"%s\"", (int)k, why.text);
        for (int c = 0; decoded && c < 3; c++) {
            CHECK((double)im.rgb[c] == ldexp(header[k].scale[c], -c), "header %d: %g", (int)k,
                  (double)im.rgb[c]);
        }
        image_free(&im);
    }
}

// What is too much before the values is told from them by the file's size, where it can be.
static void pfm_values_may_begin_late(void)
{
    static bytes b;
    const char *const text[] = {"PF\n3 2\n-1.0\n\n", "PF\r\n3 2\r\n-1\r\n\r\n", "PF 3 2 -1  ",
                                "PF\n3 2\n-1\0\n"};
    const int length[] = {13, 15, 11, 11};
    for (int k = 0; k < 4; k++) {
        image im;
        message why = {{0}};
        b.size = 0;
        for (int i = 0; i < length[k]; i++) put(&b, text[k][i]);
        for (int i = 0; i < 18; i++) put_float(&b, 1.5f + (float)i, true);
        const bool decoded = decode_exact(&im, b.at, b.size, &why);
        CHECK(decoded == (k < 3) && (decoded || why.text[0]), "header %d: %s", k, why.text);
        CHECK(!decoded || (im.rgb[0] == 10.5f && im.rgb[17] == 9.5f), "header %d: %g", k,
              decoded ? (double)im.rgb[0] : 0);
        image_free(&im);
    }
}

// Plain pixels that look like marks of either coding, anywhere; and codings that fill just as many
// bytes.
static void flat_pictures_may_look_coded(void)
{
    static bytes b;
    const unsigned char mark[5][4] = {
        {2, 2, 0, 16}, {2, 2, 5, 9}, {1, 1, 1, 128}, {1, 1, 1, 1}, {2, 2, 1, 128}};
    uint64_t random = 41;
    for (int trial = 0; trial < 2000; trial++) {
        const int w = trial % 5 == 4 ? 384 : 1 + trial % 40, h = 1 + trial / 5 % 4, pixels = w * h;
        // Of these 1 1 1 1 is a run of one, unless it stands first; it is darker than anything.
        const unsigned char *m = mark[trial % 5];
        char text[64];
        image im;
        message why = {{0}};
        b.size = 0;
        sprintf(text, "#?RGBE\n\n-Y %d +X %d\n", h, w);
        put_text(&b, text);
        unsigned char *pixel = b.at + b.size;
        for (int i = 0; i < 4 * pixels; i++) put(&b, 128 + (int)(test_random(&random) % 20));
        for (int k = 0; k < 4; k++) {
            const int at = k == 0 && trial % 2 ? 0 : (int)(test_random(&random) % (unsigned)pixels);
            if (at > 0 || trial % 5 != 3) memcpy(pixel + 4 * at, m, 4);
        }
        if (trial % 5 == 3) continue;
        CHECK(decode_exact(&im, b.at, b.size, &why), "trial %d, %d x %d: %s", trial, w, h,
              why.text);
        for (int i = 0; im.rgb && i < 3 * pixels; i++) {
            const unsigned char *p = pixel + i / 3 * 4;
            const double want = ldexp(p[i % 3], p[3] - 136);
            CHECK((double)im.rgb[i] == want, "trial %d, pixel %d of %d x %d: %g for %g", trial,
                  i / 3, w, h, (double)im.rgb[i], want);
        }
        image_free(&im);
    }
    // Noise in runs takes more bytes than plain; cut to just those it must not be taken for plain.
    b.size = 0;
    put_text(&b, "#?RGBE\n\n-Y 80 +X 16\n");
    const size_t start = b.size;
    for (int row = 0; row < 80; row++) {
        put_text(&b, "\2\2");
        put(&b, 0), put(&b, 16);
        for (int c = 0; c < 4; c++) {
            put(&b, 16);
            for (int x = 0; x < 16; x++) put(&b, 100 + (int)(test_random(&random) % 30));
        }
    }
    image im;
    message why;
    CHECK(decode_exact(&im, b.at, b.size, &why), "%s", why.text);
    image_free(&im);
    CHECK(!decode_exact(&im, b.at, start + 4 * 80 * 16, &why), "runs cut short passed for pixels");
}

static void damaged_files_do_no_harm(void)
{
    static bytes b;
    const char obj[] =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1e3\nf 1 2 3\nf -1/2/3 -2//1 1/1 4\n# end\n";
    const uint64_t seed = 20;
    uint64_t random = seed;
    int passed = 0;
    const int trials = test_trials(30000);
    for (int trial = 0; trial < trials; trial++) {
        const int kind = trial % 4;
        message why;
        if (kind < 3)
            make_hdr(&b, kind, "-Y 5 +X 19\n");
        else
            memcpy(b.at, obj, b.size = sizeof obj - 1);
        for (int i = 0; i < 1 + trial / 4 % 6; i++) {
            b.at[test_random(&random) % b.size] = (unsigned char)test_random(&random);
        }
        b.size -= (size_t)(test_random(&random) % 4);
        if (kind < 3) {
            image im;
            if (!decode_exact(&im, b.at, b.size, &why)) continue;
            passed++;
            image_free(&im);
        } else {
            mesh m;
            if (!mesh_parse_obj(&m, (const char *)b.at, b.size, &why)) continue;
            passed++;
            for (int i = 0; i < 3 * m.triangles; i++) {
                const int index = m.triangle[i / 3][i % 3];
                CHECK(index >= 0 && index < m.vertices, "trial %d: index %d", trial, index);
            }
            mesh_free(&m);
        }
    }
    CHECK(passed < trials, "all of %d damaged files passed", trials);
}

static void missing_files_are_named(void)
{
    image im;
    mesh m;
    probe p;
    message why = {{0}};
    CHECK(!image_load(&im, "/nowhere/at.hdr", &why), "loaded");
    CHECK(strstr(why.text, "/nowhere/at.hdr") != NULL, "\"%s\"", why.text);
    CHECK(!image_load(&im, ".", &why), "a directory was loaded");
    CHECK(!mesh_load_obj(&m, "/nowhere/at.obj", &why), "loaded");
    CHECK(strstr(why.text, "/nowhere/at.obj") != NULL, "\"%s\"", why.text);
    CHECK(!probe_load(&p, "/nowhere/at.pfm", 0, &why), "loaded");
    CHECK(!image_save_png(&(image){1, 1, (float[3]){0}}, 1, "/nowhere/at.png", &why), "saved");
    CHECK(strstr(why.text, "/nowhere/at.png") != NULL, "\"%s\"", why.text);
}

static void options_are_checked(void)
{
    // A value of "-" stands for none.
    char bad[][2][24] = {
        {"--light", "3"},       {"--lights", "-"},       {"--lights", "0"},
        {"--lights", "3x"},     {"--lights", "1e3"},     {"--lights", "99999999999999999999"},
        {"--tolerance", "nan"}, {"--tolerance", "-1"},   {"--size", "100"},
        {"--size", "0x100"},    {"--size", "100x100x1"}, {"--size", "x"},
        {"--moments", "5"},     {"--moments", ""},       {"--estimator", "best"},
        {"--probe", "-"},       {"--orbit", "0"},        {"--faces", "back"},
        {"picture.hdr", "-"},   {"--exposure", "0"},     {"--exposure", "inf"},
    };
    options o;
    message why;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char *arguments[3] = {(char[]){"demo"}, bad[i][0], bad[i][1]};
        why.text[0] = 0;
        CHECK(!options_parse(&o, bad[i][1][0] != '-' ? 3 : 2, arguments, &why), "%s passed",
              bad[i][0]);
        CHECK(why.text[0] && !strchr(why.text, '\n'), "%s: \"%s\"", bad[i][0], why.text);
    }
    char words[][12] = {"demo", "--size",      "640x360", "--moments",
                        "4",    "--estimator", "upper",   "--truth"};
    char *arguments[8];
    for (int i = 0; i < 8; i++) arguments[i] = words[i];
    CHECK(options_parse(&o, 8, arguments, &why), "%s", why.text);
    CHECK(o.width == 640 && o.height == 360 && o.moments == 4 && o.estimator == 2, "values");
    CHECK(o.truth == TRUTH_PROBE && o.lights == 64 && !o.probe && !o.help && o.exposure == 0,
          "defaults");
    // Another program's choice of them, with defaults of its own.
    char pick[][12] = {"lights", "--exposure", "0.25",     "--help",
                       "--size", "64x64",      "--lights", "2"};
    for (int i = 0; i < 8; i++) arguments[i] = pick[i];
    o = (options){.lights = 7};
    CHECK(options_parse_some(&o, "--lights --exposure --help", 4, arguments, &why), "%s", why.text);
    CHECK(o.exposure == 0.25f && o.help && o.lights == 7 && o.width == 0, "choice");
    CHECK(!options_parse_some(&o, "--lights --exposure --help", 6, arguments, &why) && o.width == 0,
          "--size passed");
    arguments[1] = (char[]){"--light"};
    CHECK(!options_parse_some(&o, "--lights --exposure --help", 2, arguments, &why),
          "a part of a name");
    static const char *const none[] = {"", "x", "4x", "0", "33", "-1", "4294967298", "2.5"};
    int number = 7;
    for (int i = 0; i < 8; i++) {
        CHECK(!options_int(none[i], 1, 32, &number) && number == 7, "\"%s\" is a number", none[i]);
    }
    CHECK(options_int("32", 1, 32, &number) && number == 32, "%d", number);
    // And of those with a usage alone, whose other words are names of files.
    static const char usage[] = "gl [--es|--gl33] [--out FILE] [PICTURE.png]: what --es-like does";
    char few[][12] = {"gl", "--es", "--gl33", "--out", "a.png", "--e", "-s", "--es-", "--PICTURE"};
    for (int i = 1; i < 9; i++) {
        arguments[1] = few[i];
        const char *unknown = options_unknown(2, arguments, usage);
        CHECK(i < 5 ? !unknown : unknown == few[i], "%s: %s", few[i], unknown ? unknown : "known");
    }
}

// ---- Pictures out: a decoder of its own as the oracle

typedef struct bits {
    const unsigned char *at, *end;
    unsigned hold;
    int count;
    bool failed;
} bits;

static unsigned take(bits *in, int count)
{
    while (in->count < count) {
        if (in->at == in->end) in->failed = true;
        in->hold |= (in->at < in->end ? *in->at++ : 0u) << in->count;
        in->count += 8;
    }
    const unsigned value = in->hold & ((1u << count) - 1);
    in->hold >>= count;
    in->count -= count;
    return value;
}

static unsigned take_code(bits *in, unsigned code, int count)
{
    for (int i = 0; i < count; i++) code = code << 1 | take(in, 1);
    return code;
}

// RFC 1951, 3.2.6.
static unsigned take_symbol(bits *in)
{
    unsigned code = take_code(in, 0, 7);
    if (code <= 0x17) return code + 256;
    code = take_code(in, code, 1);
    if (code >= 0x30 && code <= 0xbf) return code - 0x30;
    if (code >= 0xc0 && code <= 0xc7) return code - 0xc0 + 280;
    return take_code(in, code, 1) - 0x190 + 144;
}

static size_t inflate_fixed(bits *in, unsigned char *out, size_t room)
{
    static const unsigned length_base[29] = {3,  4,  5,  6,   7,   8,   9,   10,  11, 13,
                                             15, 17, 19, 23,  27,  31,  35,  43,  51, 59,
                                             67, 83, 99, 115, 131, 163, 195, 227, 258};
    static const int length_bits[29] = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2,
                                        2, 3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 0};
    static const unsigned distance_base[30] = {
        1,   2,   3,   4,   5,   7,    9,    13,   17,   25,   33,   49,   65,    97,    129,
        193, 257, 385, 513, 769, 1025, 1537, 2049, 3073, 4097, 6145, 8193, 12289, 16385, 24577};
    size_t size = 0;
    if (take(in, 3) != 3) in->failed = true;
    while (!in->failed) {
        const unsigned symbol = take_symbol(in);
        if (symbol == 256) return size;
        if (symbol < 256) {
            if (size == room) break;
            out[size++] = (unsigned char)symbol;
            continue;
        }
        if (symbol > 285) break;
        const unsigned length = length_base[symbol - 257] + take(in, length_bits[symbol - 257]);
        const unsigned code = take_code(in, 0, 5);
        if (code > 29) break;
        const unsigned distance = distance_base[code] + take(in, code < 4 ? 0 : (int)code / 2 - 1);
        if (distance > size || length > room - size) break;
        for (unsigned i = 0; i < length; i++, size++) out[size] = out[size - distance];
    }
    in->failed = true;
    return size;
}

static uint32_t word_at(const unsigned char *p)
{
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

// Polynomial division bit by bit, highest first on reflected bytes: another way than the encoder's.
static uint32_t crc_of(const unsigned char *data, size_t size)
{
    uint32_t crc = 0xffffffffu, mirrored = 0;
    for (size_t i = 0; i < 8 * size; i++) {
        const uint32_t bit = (crc >> 31) ^ ((uint32_t)data[i / 8] >> (i % 8) & 1u);
        crc = crc << 1 ^ (bit ? 0x04c11db7u : 0);
    }
    for (int i = 0; i < 32; i++) mirrored |= (~crc >> i & 1u) << (31 - i);
    return mirrored;
}

static int unfilter(int filter, int left, int up, int corner)
{
    const int p = left + up - corner, a = abs(p - left), b = abs(p - up), c = abs(p - corner);
    if (filter == 1) return left;
    if (filter == 2) return up;
    if (filter == 3) return (left + up) / 2;
    if (filter == 4) return a <= b && a <= c ? left : b <= c ? up : corner;
    return 0;
}

// The pixels of a PNG with these sizes, or NULL.
static unsigned char *decode_png(const unsigned char *png, size_t size, int width, int height)
{
    static const unsigned char signature[8] = {137, 'P', 'N', 'G', 13, 10, 26, 10};
    const size_t row = 3 * (size_t)width, raw = (row + 1) * (size_t)height;
    unsigned char *lines = calloc(raw, 1), *pixels = calloc(row, (size_t)height);
    bool right = size > 8 && !memcmp(png, signature, 8), ended = false;
    for (size_t at = 8; right && at + 12 <= size && !ended;) {
        const size_t length = word_at(png + at);
        const unsigned char *data = png + at + 8;
        right = length <= size - at - 12 && crc_of(data - 4, length + 4) == word_at(data + length);
        if (right && !memcmp(data - 4, "IHDR", 4)) {
            right = (int)word_at(data) == width && (int)word_at(data + 4) == height &&
                    !memcmp(data + 8, "\10\2\0\0\0", 5);
        } else if (right && !memcmp(data - 4, "IDAT", 4)) {
            bits in = {data + 2, data + length - 4, 0, 0, false};
            uint32_t a = 1, b = 0;
            right = (data[0] * 256 + data[1]) % 31 == 0 && inflate_fixed(&in, lines, raw) == raw;
            for (size_t i = 0; i < raw; i++) {
                a = (a + lines[i]) % 65521;
                b = (b + a) % 65521;
            }
            right = right && !in.failed && in.at == in.end &&
                    (b << 16 | a) == word_at(data + length - 4);
        }
        ended = !memcmp(data - 4, "IEND", 4);
        at += length + 12;
        if (ended) right = right && at == size;
    }
    for (size_t i = 0; i < row * (size_t)height; i++) {
        const size_t x = i % row, y = i / row;
        const int left = x >= 3 ? pixels[i - 3] : 0, up = y ? pixels[i - row] : 0;
        const int corner = x >= 3 && y ? pixels[i - row - 3] : 0;
        pixels[i] = (unsigned char)(lines[y * (row + 1) + 1 + x] +
                                    unfilter(lines[y * (row + 1)], left, up, corner));
    }
    free(lines);
    if (right && ended) return pixels;
    free(pixels);
    return NULL;
}

static unsigned char sample_pixel(int kind, int x, int y, int c, uint64_t *random)
{
    if (kind == 0) return 77;
    if (kind == 1) return (unsigned char)(x + 2 * y + 40 * c);
    if (kind == 2) return (unsigned char)test_random(random);
    if (kind == 3) return (unsigned char)((x / 7 + y / 5) % 2 * 255);
    return (unsigned char)(128 + 100 * sin(0.05 * x * (c + 1)) * cos(0.03 * y));
}

static void png_decodes_to_its_pixels(void)
{
    const int sizes[4][2] = {{1, 1}, {3, 200}, {257, 2}, {320, 240}};
    uint64_t random = 5;
    for (int trial = 0; trial < 20; trial++) {
        const int kind = trial % 5, width = sizes[trial / 5][0], height = sizes[trial / 5][1];
        const size_t count = 3 * (size_t)width * (size_t)height;
        unsigned char *pixels = malloc(count);
        size_t size = 0;
        for (size_t i = 0; i < count; i++) {
            const int at = (int)(i / 3);
            pixels[i] = sample_pixel(kind, at % width, at / width, (int)(i % 3), &random);
        }
        unsigned char *png = png_encode(pixels, width, height, &size);
        unsigned char *back = png ? decode_png(png, size, width, height) : NULL;
        CHECK(back && !memcmp(back, pixels, count), "kind %d, %d x %d", kind, width, height);
        // Noise grows, by a ninth bit for half its bytes; everything else must shrink.
        const size_t most = kind == 2 ? count * 11 / 10 : count * 2 / 5;
        CHECK(count < 100000 || size < most, "kind %d: %d of %d bytes", kind, (int)size,
              (int)count);
        free(pixels);
        free(png);
        free(back);
    }
}

static void tone_curve_is_total(void)
{
    float rgb[18] = {0, -1, NAN, INFINITY, -INFINITY, 1e38f, 1e-38f, 0.18f, 1, 2, 4, 8, 1e6f, 0.5f};
    unsigned char out[18];
    const image im = {6, 1, rgb};
    image_tonemap(&im, 1, out);
    CHECK(out[0] == 0 && out[1] == 0 && out[2] == 0 && out[4] == 0 && out[6] == 0,
          "black is not black");
    CHECK(out[3] == 255 && out[5] == 255, "infinity is %d, 1e38 is %d", out[3], out[5]);
    for (int i = 7; i < 12; i++)
        CHECK(out[i] < out[i + 1] || out[i] == 255, "not monotone at %d", i);
    CHECK(out[11] < 255 && rgb[11] == 8, "8 is white already");
    for (int i = 14; i < 18; i++) rgb[i] = NAN;
    CHECK(isfinite(image_exposure(&im)), "exposure is not finite");
}

// ---- Probes

// DESIGN 2, written out.
static vec3 convention(int face, float s, float t)
{
    switch (face) {
    case 0: return vec(1, -t, -s);
    case 1: return vec(-1, -t, s);
    case 2: return vec(s, 1, t);
    case 3: return vec(s, -1, -t);
    case 4: return vec(s, -t, 1);
    default: return vec(-s, -t, -1);
    }
}

static void directions_follow_the_convention(void)
{
    uint64_t random = 3;
    for (int i = 0; i < 6000; i++) {
        const int face = i % 6;
        const float s = (float)test_range(&random, -0.999, 0.999);
        const float t = (float)test_range(&random, -0.999, 0.999);
        float back_s, back_t;
        const vec3 d = convention(face, s, t);
        CHECK(vec_length(vec_sub(probe_direction(face, s, t), d)) == 0, "face %d", face);
        const int back =
            probe_locate(vec_scale(d, (float)test_range(&random, 0.1, 10)), &back_s, &back_t);
        CHECK(back == face && fabsf(back_s - s) < 1e-5f && fabsf(back_t - t) < 1e-5f,
              "face %d %g %g came back as %d %g %g", face, (double)s, (double)t, back,
              (double)back_s, (double)back_t);
    }
}

static double density(double s, double t)
{
    return pow(1 + s * s + t * t, -1.5);
}

// The integral of radiance, with 8 x 8 points a texel. moment, unless NULL, gets that of the
// direction.
static double flux(const probe *p, int channel, double moment[3])
{
    double sum = 0;
    if (moment) moment[0] = moment[1] = moment[2] = 0;
    for (int i = 0; i < 6 * p->side * p->side; i++) {
        const int face = i / p->side / p->side, y = i / p->side % p->side, x = i % p->side;
        const double value = (double)p->texels[3 * i + channel];
        for (int k = 0; k < 64 && value != 0; k++) {
            const double s = 2 * (x + (k % 8 + 0.5) / 8) / p->side - 1;
            const double t = 2 * (y + (k / 8 + 0.5) / 8) / p->side - 1;
            const double w = value * density(s, t) / 16 / p->side / p->side;
            const vec3 d = vec_unit(convention(face, (float)s, (float)t));
            sum += w;
            if (!moment) continue;
            moment[0] += w * (double)d.x;
            moment[1] += w * (double)d.y;
            moment[2] += w * (double)d.z;
        }
    }
    return sum;
}

static void lat_long_keeps_constants(void)
{
    const int sizes[4][2] = {{16, 16}, {64, 16}, {256, 32}, {1000, 24}};
    for (int k = 0; k < 4; k++) {
        image im;
        probe p;
        message why;
        float worst = 0;
        image_create(&im, sizes[k][0], sizes[k][0] / 2);
        for (int i = 0; i < 3 * im.width * im.height; i++) im.rgb[i] = 2.5f;
        CHECK(probe_from_image(&p, &im, sizes[k][1], &why), "%s", why.text);
        for (int i = 0; i < 18 * p.side * p.side; i++)
            worst = fmaxf(worst, fabsf(p.texels[i] - 2.5f));
        CHECK(worst < 1e-5f, "width %d: off by %g", im.width, (double)worst);
        const double total = flux(&p, 1, NULL);
        CHECK(fabs(total / (10 * PI) - 1) < 1e-4, "width %d: flux %g", im.width, total);
        image_free(&im);
        probe_free(&p);
    }
}

// A single bright pixel, at poles, at the seam and elsewhere: where it is and how much it sends.
static void lat_long_keeps_single_pixels(void)
{
    const int place[6][2] = {{0, 0}, {127, 63}, {0, 31}, {64, 20}, {96, 32}, {17, 50}};
    for (int k = 0; k < 6; k++) {
        image im;
        probe p;
        message why;
        double moment[3];
        image_create(&im, 128, 64);
        image_set(&im, place[k][0], place[k][1], vec(0, 1000, 0));
        CHECK(probe_from_image(&p, &im, 32, &why), "%s", why.text);
        // Documented: the middle column looks along -Z, a quarter to its right is +X.
        const double azimuth = 2 * PI * ((place[k][0] + 0.5) / 128 - 0.5);
        const double polar = PI * (place[k][1] + 0.5) / 64;
        const double want =
            1000 * 2 * PI / 128 * (cos(PI * place[k][1] / 64) - cos(PI * (place[k][1] + 1) / 64));
        const double got = flux(&p, 1, moment);
        CHECK(fabs(got / want - 1) < 3e-3, "pixel %d: %g for %g", k, got, want);
        const double along =
            (moment[0] * sin(polar) * sin(azimuth) + moment[1] * cos(polar) -
             moment[2] * sin(polar) * cos(azimuth)) /
            sqrt(moment[0] * moment[0] + moment[1] * moment[1] + moment[2] * moment[2]);
        CHECK(along > 0.9995, "pixel %d is %.2f degrees off", k, acos(along) * 180 / PI);
        image_free(&im);
        probe_free(&p);
    }
}

static void broken_pixels_are_counted(void)
{
    image im;
    probe p;
    message why;
    image_create(&im, 32, 16);
    for (int i = 0; i < 3 * 32 * 16; i++) im.rgb[i] = 1;
    im.rgb[100] = NAN;
    im.rgb[400] = INFINITY;
    CHECK(probe_from_image(&p, &im, 0, &why), "%s", why.text);
    CHECK(p.broken == 2, "%d broken", p.broken);
    // The sun that was too bright for its file is the brightest, and nothing but it is bright.
    float most = 0;
    for (int i = 0; i < 18 * p.side * p.side; i++) {
        most = fmaxf(most, p.texels[i]);
        CHECK(p.texels[i] >= 0 && (i % 3 == 1 || p.texels[i] <= 1.001f), "texel %d", i);
    }
    CHECK(most > 10000 && most <= 65504, "the sun is %g", (double)most);
    CHECK(fabs(flux(&p, 1, NULL) /
                   (65503 * 2 * PI / 32 * (cos(PI * 4 / 16) - cos(PI * 5 / 16)) + 4 * PI) -
               1) < 3e-3,
          "its flux is %g", flux(&p, 1, NULL));
    probe_free(&p);
    im.height = 15;
    CHECK(!probe_from_image(&p, &im, 0, &why) && why.text[0], "32 x 15 passed");
    image_free(&im);
}

// Sides of probes: of panoramas by their width, within limits; of faces as they are.
static void pictures_become_probes(void)
{
    const int sizes[][4] = {{2, 1, 0, 16},       {101, 50, 0, 25},   {1024, 512, 0, 128},
                            {1024, 512, 40, 40}, {64, 32, 500, 128}, {1, 1, 0, 16},
                            {1200, 900, 7, 300}, {9, 12, 0, 3},      {6, 1, 0, 1},
                            {200, 1200, 0, 200}, {31, 14, 0, 0},     {100, 100, 0, 0}};
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
        image im;
        probe p;
        message why = {{0}};
        image_create(&im, sizes[k][0], sizes[k][1]);
        for (int i = 0; i < 3 * im.width * im.height; i++) im.rgb[i] = 3;
        const bool made = probe_from_image(&p, &im, sizes[k][2], &why);
        CHECK(made == (sizes[k][3] > 0) && p.side == sizes[k][3], "%d x %d: side %d, %s", im.width,
              im.height, p.side, why.text);
        for (int i = 0; made && i < 18 * p.side * p.side; i++)
            CHECK(fabsf(p.texels[i] - 3) < 1e-5f, "%d x %d: texel %d", im.width, im.height, i / 3);
        image_free(&im);
        probe_free(&p);
    }
}

static void turning_moves_light(void)
{
    probe p, turned;
    uint64_t random = 9;
    CHECK(probe_create(&p, 16) && probe_create(&turned, 16), "no memory");
    for (int i = 0; i < 3 * 6 * 256; i++) p.texels[i] = (float)pow(test_uniform(&random), 8);
    for (int k = 0; k < 12; k++) {
        const float angle = k < 4 ? 0.5f * (float)PI * (float)k : (float)test_range(&random, -7, 7);
        double before[3], after[3];
        const double sum = flux(&p, 0, before);
        CHECK(probe_rotate(&turned, &p, angle), "no memory");
        const double turned_sum = flux(&turned, 0, after);
        CHECK(fabs(turned_sum / sum - 1) < 2e-3, "angle %g: flux times %g", (double)angle,
              turned_sum / sum);
        const vec3 want =
            vec_turn(vec((float)before[0], (float)before[1], (float)before[2]), angle);
        const vec3 off = vec_sub(vec((float)after[0], (float)after[1], (float)after[2]), want);
        CHECK((double)vec_length(off) < 2e-3 * sum, "angle %g: off by %g of %g", (double)angle,
              (double)vec_length(off), sum);
    }
    // A quarter turn takes +Z to +X, texel for texel.
    probe_rotate(&turned, &p, 0.5f * (float)PI);
    for (int i = 0; i < 256; i++) {
        float s, t;
        const float u = (float)(2 * (i % 16) + 1) / 16 - 1, v = (float)(2 * (i / 16) + 1) / 16 - 1;
        const int face = probe_locate(vec_turn(convention(4, u, v), 0.5f * (float)PI), &s, &t);
        const int x = (int)((s + 1) * 8), y = (int)((t + 1) * 8);
        CHECK(face == 0, "face %d", face);
        CHECK(fabsf(turned.texels[3 * ((face * 16 + y) * 16 + x)] - p.texels[3 * (4 * 256 + i)]) <
                  1e-4f,
              "texel %d", i);
    }
    probe_free(&p);
    probe_free(&turned);
}

static void broken_texels_stay_alone(void)
{
    probe p, turned;
    int dark = 0;
    CHECK(probe_create(&p, 8) && probe_create(&turned, 8), "no memory");
    for (int i = 0; i < 18 * 64; i++) p.texels[i] = 1;
    p.texels[3 * (4 * 64 + 27)] = NAN;
    p.texels[3 * (1 * 64 + 7)] = INFINITY;
    CHECK(probe_rotate(&turned, &p, 0), "no memory");
    CHECK(!memcmp(p.texels, turned.texels, sizeof(float) * 18 * 64), "turning by nothing changes");
    CHECK(probe_rotate(&turned, &p, 0.3f), "no memory");
    for (int i = 0; i < 18 * 64; i++) {
        CHECK(turned.texels[i] >= 0 && turned.texels[i] < 1.001f, "texel %d", i / 3);
        dark += turned.texels[i] < 0.999f;
    }
    CHECK(dark >= 2 && dark <= 18, "%d values are darker", dark);
    probe_free(&p);
    probe_free(&turned);
}

static void strips_round_trip(void)
{
    probe p, back;
    image im;
    message why;
    CHECK(probe_default(&p, 24) && probe_to_image(&p, &im), "no memory");
    CHECK(probe_from_image(&back, &im, 0, &why), "%s", why.text);
    CHECK(back.side == 24 && !memcmp(p.texels, back.texels, sizeof(float) * 18 * 24 * 24),
          "changed");
    for (int i = 0; i < 18 * 24 * 24; i++)
        CHECK(p.texels[i] >= 0 && isfinite(p.texels[i]), "%d", i);
    image_free(&im);
    probe_free(&p);
    probe_free(&back);
}

// ---- Meshes

static vec3 random_direction(uint64_t *random)
{
    const double z = test_range(random, -1, 1), a = test_range(random, 0, 2 * PI),
                 r = sqrt(1 - z * z);
    return vec((float)(r * cos(a)), (float)(r * sin(a)), (float)z);
}

static void obj_edge_cases(void)
{
    const struct {
        const char *text;
        int vertices, triangles; // 0 triangles: refused
    } cases[] = {
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3", 3, 1},
        {"v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1/1/1 2//2 3/3\r\n", 3, 1},
        {"v 0 0 0 1\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0\nv 1 1 0\nv .5 2 0\nf -5 -4 -3 -2 -1\n", 5, 3},
        {"f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n", 3, 1},
        {"  # c\n\tv 0 0 0\nvn 1 0 0\nvt 0 0\nv 1 0 0\no x\ng y\nusemtl z\nv 0 1e2 0\n f 3 2 1 # "
         "c\n",
         3, 1},
        {"", 0, 0},
        {"v 0 0 0\n", 0, 0},
        {"v 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", 0, 0},
        // Marks, line ends, continued lines, comments.
        {"\xef\xbb\xbfv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3", 3, 1},
        {"v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r", 3, 1},
        {"v 0 0 0\r\nv 1 0 0\rv 0 1 0\n\nf 1 2 3\r\n", 3, 1},
        {"v 0 \\\n0 0\nv 1 0 0\nv 0 1 0\nf 1 \\\r\n2\\\r 3 \\ \n", 3, 1},
        {"v \\\n\\\n0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\\", 3, 1},
        {"# C:\\temp\\\nv 0 0 0\ng a\\\nv 1 0 0 # b\\\nv 0 1 0#c\nf 1 2 3#d\n", 3, 1},
        {"v\f0\v0 0\nv\t1 0 0\nv 0 1 0\nf\t1\v2 3", 3, 1},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\\3\n", 0, 0},
        // Faces of one or two corners, and of none; vertices that none uses, whatever they are.
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\nf 1\nf \nf 1 2 3\n", 3, 1},
        {"v 9 9 9\nv 0 0 0\nv 1 0 0\nv nan 0 0\nv 0 1 0\nv 1e300 0 0\nf 2 3 5\nf 1 4", 3, 1},
        {"v 0 0 0\nv 1.#QNAN -1.#IND 1.#INF\nv 1 0 0\nv 0 1 0\nf 1 3 4", 3, 1},
        {"v 0 0 0\nv 1.#QNAN 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4", 0, 0},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\nl 1 2\n", 0, 0},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 9\nf 1 2 3\n", 0, 0},
        // Numbers with something in them.
        {"v 0,5 0,5 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", 0, 0},
        {"v 0 0 0x\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", 0, 0},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1.5 2 3\n", 0, 0},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nsurf 0 1 0 1 1 2 3\n", 0, 0},
        {"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", 0, 0},
        {"v 0 0 inf\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", 0, 0},
        {"v 0 0 1e30\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", 0, 0},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", 0, 0},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", 0, 0},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 1 2\n", 0, 0},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n", 0, 0},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 x 2\n", 0, 0},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 99999999999999999999 2 3\n", 0, 0},
        {"v 0 0\n0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", 0, 0},
        // No numbers, no blank, old names; corners that repeat.
        {"v\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", 0, 0},
        {"v\xc2\xa0"
         "0 0 0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
         0, 0},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nv", 0, 0},
        {"v 0 0 0\nv-1 0 0\nv 0 1 0\nf\nf1 3 2#f\n", 3, 1},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nfo 1 2 3\n", 0, 0},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nbzp 1 1 1 1 2 2 2 2 3 3 3 3 1 2 3 1\n", 0, 0},
        {"v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 1 2 2 3 3 1\n", 3, 1},
        {"v 0 0 0\nv 1 0 0\nf 1 2 1 2\n", 0, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        mesh m;
        message why = {{0}};
        const bool parsed = mesh_parse_obj(&m, cases[i].text, strlen(cases[i].text), &why);
        CHECK(parsed == (cases[i].triangles > 0), "case %d: %s", (int)i, why.text);
        CHECK(m.vertices == cases[i].vertices && m.triangles == cases[i].triangles,
              "case %d: %d vertices, %d triangles", (int)i, m.vertices, m.triangles);
        CHECK(parsed || why.text[0], "case %d failed without a word", (int)i);
        mesh_free(&m);
    }
}

static void obj_refusals_name_the_line(void)
{
    const char *const text[][2] = {
        {"v 0 0\n", "line 1:"},
        {"\n\r\n\rv 0 0 x", "line 4:"},
        {"v 0 0 \\\n\\\n0\nv 0 0", "line 4:"},
        {"v 0 0 0\nv 0 0 nan\nv 0 0 0\n\nf 1 2 3", "line 2:"},
        {"v 0 0 0\nv 0 1 0\nv 0 0 -1e30\nf 1 2 3",
         "line 3: a face uses this vertex, whose numbers must be finite and below 1e18"},
        {"v 0 0 0\nv 0 0 0\nf 1 2 \\\n3\nf 1 2 1", "line 3:"},
        {"v 0 0 0\n\nv 0 0 0\nf 1 2 -3", "line 4:"},
        {"v 0 0 0\ncall other.obj", "line 2:"},
    };
    mesh m;
    message why;
    for (size_t i = 0; i < sizeof text / sizeof *text; i++) {
        why.text[0] = 0;
        CHECK(!mesh_parse_obj(&m, text[i][0], strlen(text[i][0]), &why), "case %d passed", (int)i);
        CHECK(strstr(why.text, text[i][1]), "case %d: \"%s\"", (int)i, why.text);
    }
    CHECK(!mesh_parse_obj(&m, "v 0 0 0\n\0v 1 0 0", 16, &why) && strstr(why.text, "line 2"),
          "a zero byte: %s", why.text);
}

// Random polygons that do not cross themselves, in any plane: the triangles have the polygon's
// area, and all face its way, so none lies on another or outside.
static void obj_polygons_may_be_concave(void)
{
    static char text[1 << 16];
    uint64_t random = 12;
    const int trials = test_trials(3000);
    for (int trial = 0; trial < trials; trial++) {
        // A star around a point; a comb; a frame, whose hole a bridge joins to its rim.
        const int kind = trial % 3,
                  count = kind == 2 ? 10 : 2 * (2 + (int)(test_random(&random) % 20));
        const vec3 n = trial % 7 ? random_direction(&random) : vec(0, 0, trial % 2 ? 1.0f : -1.0f);
        const vec3 u = vec_unit(vec_cross(fabsf(n.x) < 0.8f ? vec(1, 0, 0) : vec(0, 1, 0), n)),
                   v = vec_cross(n, u);
        static const double frame[10][2] = {{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0},
                                            {1, 1}, {1, 3}, {3, 3}, {3, 1}, {1, 1}};
        double area = 0, at[64][2];
        size_t size = 0;
        const int start = (int)(test_random(&random) % (unsigned)count);
        for (int i = 0; i < count; i++) {
            const double r = test_range(&random, 0.1, 3), angle = 2 * PI * i / count;
            double x = r * cos(angle), y = r * sin(angle);
            if (kind == 1) {
                const int half = count / 2;
                x = i < half ? i : count - 1 - i;
                y = i < half ? (i % 2 ? 0.9 : 0) : 1.1 + (i % 2 ? 3 : 0.0);
            }
            if (kind == 2) x = frame[i][0], y = frame[i][1];
            at[(i + start) % count][0] = x;
            at[(i + start) % count][1] = y;
        }
        for (int i = 0; i < count; i++) {
            const double *p = at[i], *q = at[(i + 1) % count];
            area += 0.5 * (p[0] * q[1] - p[1] * q[0]);
            size += (size_t)sprintf(
                text + size, "v %.9g %.9g %.9g\n", p[0] * (double)u.x + p[1] * (double)v.x,
                p[0] * (double)u.y + p[1] * (double)v.y, p[0] * (double)u.z + p[1] * (double)v.z);
        }
        size += (size_t)sprintf(text + size, "f");
        for (int i = 0; i < count; i++) {
            // Some are there twice, or the way to the next one and back: no area.
            const int next = (i + 1) % count,
                      more = trial / 3 % 4 & (int)(test_random(&random) >> 40);
            size += (size_t)sprintf(text + size, " %d", i + 1);
            if (more & 1) size += (size_t)sprintf(text + size, " %d", i + 1);
            if (more & 2) size += (size_t)sprintf(text + size, " %d %d", next + 1, i + 1);
        }
        mesh m;
        message why;
        CHECK(mesh_parse_obj(&m, text, size, &why), "trial %d: %s", trial, why.text);
        double sum = 0, all = 0;
        for (int i = 0; i < m.triangles; i++) {
            const vec3 a = m.position[m.triangle[i][0]];
            const vec3 twice = vec_cross(vec_sub(m.position[m.triangle[i][1]], a),
                                         vec_sub(m.position[m.triangle[i][2]], a));
            sum += 0.5 * (double)vec_dot(twice, n);
            all += 0.5 * fabs((double)vec_dot(twice, n));
        }
        CHECK(fabs(sum - area) < 2e-5 * count && fabs(all - area) < 2e-5 * count,
              "trial %d, kind %d of %d corners: area %g, of all %g, for %g", trial, kind, count,
              sum, all, area);
        CHECK(m.triangles <= count - 2, "%d triangles of %d corners", m.triangles, count);
        mesh_free(&m);
    }
}

// A disc of many corners, some of which are concave by rounding; and more corners than anyone waits
// for.
static void obj_polygons_may_be_long(void)
{
    const int most = test_trials(10) < 10 ? 5000 : 40000;
    for (int count = 5000; count <= most; count *= 8) {
        char *text = malloc((size_t)count * 40 + 9);
        size_t size = 0;
        double sum = 0;
        mesh m;
        message why = {{0}};
        for (int i = 0; i < count; i++) {
            // The long one turns to and fro all the way.
            const double angle = 2 * PI * i / count, r = count > 5000 ? 1 + 0.5 * (i % 2) : 1;
            size += (size_t)sprintf(text + size, "v %.6f %.6f 3\n", r * cos(angle), r * sin(angle));
        }
        size += (size_t)sprintf(text + size, "f");
        for (int i = 0; i < count; i++) size += (size_t)sprintf(text + size, " %d", i + 1);
        const bool parsed = mesh_parse_obj(&m, text, size, &why);
        CHECK(parsed == (count == 5000) && (parsed || strstr(why.text, "line 40001: ")),
              "%d corners: %s", count, why.text);
        for (int i = 0; i < m.triangles; i++) {
            const vec3 a = m.position[m.triangle[i][0]];
            const vec3 twice = vec_cross(vec_sub(m.position[m.triangle[i][1]], a),
                                         vec_sub(m.position[m.triangle[i][2]], a));
            sum += 0.5 * fabs((double)twice.z);
        }
        CHECK(!parsed || fabs(sum / PI - 1) < 1e-5, "area %g", sum);
        mesh_free(&m);
        free(text);
    }
}

static void obj_far_from_the_origin(void)
{
    const char text[] =
        "v 500000.01 4649776.02 10\nv 500000.11 4649776.02 10\nv 500000.11 4649776.12 10\n"
        "v 0 0 0\nf 1 2 3\n";
    const double want[3][3] = {
        {500000.01, 4649776.02, 10}, {500000.11, 4649776.02, 10}, {500000.11, 4649776.12, 10}};
    mesh m;
    message why = {{0}};
    CHECK(mesh_parse_obj(&m, text, strlen(text), &why) && m.vertices == 3, "%s", why.text);
    for (int i = 0; i < m.vertices; i++) {
        const double off[3] = {m.origin[0] + (double)m.position[i].x - want[i][0],
                               m.origin[1] + (double)m.position[i].y - want[i][1],
                               m.origin[2] + (double)m.position[i].z - want[i][2]};
        CHECK(fabs(off[0]) + fabs(off[1]) + fabs(off[2]) < 1e-8, "vertex %d is off by %g", i,
              off[0] + off[1] + off[2]);
    }
    mesh_free(&m);
    CHECK(mesh_parse_obj(&m, "v 5 5 5\nv 6 5 5\nv 5 6 5\nf 1 2 3", 31, &why), "%s", why.text);
    CHECK(m.origin[0] == 0 && m.position[0].x == 5, "moved for nothing");
    mesh_free(&m);
}

// In nanometres or light years, a mesh in the scene has the normals that it has in metres.
static void meshes_of_any_size_have_normals(void)
{
    for (int power = -26; power <= 17; power++) {
        char text[256];
        mesh m;
        scene s;
        message why = {{0}};
        int bad = 0;
        sprintf(text,
                "v 0 0 0\nv 1e%d 0 0\nv 0 1e%d 0\nv 0 0 1e%d\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4",
                power, power, power);
        CHECK(mesh_parse_obj(&m, text, strlen(text), &why), "1e%d: %s", power, why.text);
        CHECK(scene_create(&s, 0, &m), "memory");
        for (int i = 0; i < s.vertices; i++) bad += !(fabsf(vec_length(s.normal[i]) - 1) < 1e-5f);
        CHECK(!bad, "1e%d: %d of %d normals are none", power, bad, s.vertices);
        scene_free(&s);
        mesh_free(&m);
    }
}

typedef struct edge {
    vec3 from, to;
} edge;

static int compare_edges(const void *a, const void *b)
{
    const float *x = a, *y = b;
    for (int i = 0; i < 6; i++) {
        if (x[i] != y[i]) return x[i] < y[i] ? -1 : 1;
    }
    return 0;
}

static void default_scene_is_closed(void)
{
    scene s;
    CHECK(scene_create(&s, 1.7f, NULL), "no memory");
    const size_t count = 3 * (size_t)s.triangles;
    edge *forth = malloc(count * sizeof *forth), *back = malloc(count * sizeof *back);
    double volume[SCENE_OBJECTS] = {0};
    for (size_t i = 0; i < count; i++) {
        const int *t = s.triangle[i / 3];
        forth[i].from = back[i].to = s.position[t[i % 3]];
        forth[i].to = back[i].from = s.position[t[(i + 1) % 3]];
        if (i % 3 == 0) {
            const vec3 n = vec_cross(s.position[t[1]], s.position[t[2]]);
            volume[s.object[i / 3]] += (double)vec_dot(s.position[t[0]], n) / 6;
        }
    }
    qsort(forth, count, sizeof *forth, compare_edges);
    qsort(back, count, sizeof *back, compare_edges);
    // Every edge is walked once in each direction.
    int open = 0, twice = 0;
    for (size_t i = 0; i < count; i++) {
        open += compare_edges(forth + i, back + i) != 0;
        twice += i > 0 && !compare_edges(forth + i, forth + i - 1);
    }
    CHECK(open == 0 && twice == 0, "%d open edges, %d walked twice", open, twice);
    for (int i = 0; i < s.objects; i++) CHECK(volume[i] > 1e-4, "object %d: %g m^3", i, volume[i]);
    for (int i = 0; i < s.vertices; i++) {
        CHECK(fabsf(vec_length(s.normal[i]) - 1) < 1e-4f, "normal %d is not a unit vector", i);
    }
    int backwards = 0;
    for (int i = 0; i < s.triangles; i++) {
        const int *t = s.triangle[i];
        const vec3 n = vec_cross(vec_sub(s.position[t[1]], s.position[t[0]]),
                                 vec_sub(s.position[t[2]], s.position[t[0]]));
        const vec3 shading = vec_add(vec_add(s.normal[t[0]], s.normal[t[1]]), s.normal[t[2]]);
        backwards += vec_dot(n, shading) <= 0;
    }
    CHECK(backwards == 0, "%d triangles face against their normals", backwards);
    free(forth);
    free(back);
    scene_free(&s);
}

// ---- Rasterizer and ray tracer

// An orthographic view along -towards that holds the scene.
static void orthographic(const scene *s, vec3 towards, float m[16])
{
    const vec3 centre = vec_scale(vec_add(s->low, s->high), 0.5f);
    const float size = 0.5f * vec_length(vec_sub(s->high, s->low));
    const vec3 u =
        vec_unit(vec_cross(fabsf(towards.y) < 0.9f ? vec(0, 1, 0) : vec(1, 0, 0), towards));
    const vec3 row[4] = {vec_scale(u, 1 / size), vec_scale(vec_cross(towards, u), 1 / size),
                         vec_scale(towards, -1 / size), vec(0, 0, 0)};
    for (int k = 0; k < 4; k++) {
        m[k] = row[k].x;
        m[4 + k] = row[k].y;
        m[8 + k] = row[k].z;
        m[12 + k] = k < 3 ? -vec_dot(row[k], centre) : 1;
    }
}

// The nearest triangle of one facing by trying all: the oracle of oracles.
static float nearest_of_all(const scene *s, vec3 origin, vec3 d, bool back)
{
    float nearest = HUGE_VALF;
    for (int i = 0; i < s->triangles; i++) {
        const vec3 a = s->position[s->triangle[i][0]], b = s->position[s->triangle[i][1]];
        const vec3 c = s->position[s->triangle[i][2]];
        const vec3 n = vec_cross(vec_sub(b, a), vec_sub(c, a));
        const float slope = vec_dot(n, d), distance = vec_dot(n, vec_sub(a, origin)) / slope;
        if (!(slope != 0) || (slope > 0) != back || !(distance > 0 && distance < nearest)) continue;
        const vec3 p = vec_mad(origin, d, distance);
        if (vec_dot(n, vec_cross(vec_sub(b, a), vec_sub(p, a))) >= 0 &&
            vec_dot(n, vec_cross(vec_sub(c, b), vec_sub(p, b))) >= 0 &&
            vec_dot(n, vec_cross(vec_sub(a, c), vec_sub(p, c))) >= 0) {
            nearest = distance;
        }
    }
    return nearest;
}

static void depth_maps_agree_with_rays(void)
{
    enum { SIDE = 64 };
    static float depth[SIDE * SIDE * 8];
    scene s;
    uint64_t random = 77;
    scene_create(&s, 0, NULL);
    bvh *tree = bvh_create(&s);
    for (int light = 0; light < 12; light++) {
        float m[16];
        const int samples = 1 << light % 4;
        const bool back = light >= 8;
        const vec3 d = random_direction(&random);
        orthographic(&s, d, m);
        const raster_frustum frustum = {m, false, 0, 0};
        CHECK(raster_depth(&s, &frustum, back ? RASTER_BACK : RASTER_FRONT, SIDE, samples, depth),
              "memory");
        const float size2 = 1 / (m[0] * m[0] + m[4] * m[4] + m[8] * m[8]);
        const vec3 u = vec_scale(vec(m[0], m[4], m[8]), size2),
                   v = vec_scale(vec(m[1], m[5], m[9]), size2);
        const vec3 w = vec_scale(vec(m[2], m[6], m[10]), size2);
        const vec3 centre = vec_scale(vec_add(s.low, s.high), 0.5f);
        int off = 0, tried = 0;
        for (int i = 0; i < SIDE * SIDE * samples; i += back ? 97 : 1, tried++) {
            float px, py;
            raster_sample_position(samples, i % samples, &px, &py);
            const float x = 2 * ((float)(i / samples % SIDE) + px) / SIDE - 1;
            const float y = 2 * ((float)(i / samples / SIDE) + py) / SIDE - 1;
            const vec3 from = vec_sub(vec_mad(vec_mad(centre, u, x), v, y), w);
            const float t =
                back ? nearest_of_all(&s, from, w, true) : bvh_hit_nearest(tree, from, w);
            const float want = t < 2 ? -1 + t : 1;
            off += fabsf(depth[i] - want) > 2e-4f;
        }
        // Samples within rounding of a silhouette may go either way.
        CHECK(off <= 1 + tried / 2000, "light %d: %d of %d samples are off", light, off, tried);
    }
    bvh_free(tree);
    scene_free(&s);
}

// Loose triangles that face any way and cross the near and the far plane, by trying all in double.
static void depth_maps_cut_as_opengl_does(void)
{
    enum { SIDE = 48, COUNT = 60 };
    static float depth[SIDE * SIDE];
    uint64_t random = 8;
    for (int trial = 0; trial < 12; trial++) {
        scene s = {0};
        scene_begin_object(&s, 1, 1, 1);
        for (int i = 0; i < 3 * COUNT; i++) {
            scene_put_vertex(&s,
                             vec_scale(random_direction(&random), (float)test_range(&random, 0, 2)),
                             vec(0, 1, 0));
            if (i % 3 == 2) scene_put_triangle(&s, i - 2, i - 1, i);
        }
        // Rows x and y turned in the plane and mirrored every other time, depth of -1 to 1 for z of
        // .6 to -.6, or in perspective from z = 2.5: between distances 1.5 and 3.
        const bool perspective = trial >= 6, back = trial % 3 == 2;
        const float c = cosf((float)trial), e = sinf((float)trial),
                    mirror = trial % 2 ? -1.0f : 1.0f;
        const float near = perspective ? 1.5f : 0, far = perspective ? 3.0f : 1;
        const float m[16] = {c * mirror,
                             -e * mirror,
                             0,
                             0,
                             e,
                             c,
                             0,
                             0,
                             0,
                             0,
                             perspective ? 0 : -1 / 0.6f,
                             perspective ? -1.0f : 0,
                             0,
                             0,
                             0,
                             perspective ? 2.5f : 1};
        const raster_frustum frustum = {m, perspective, near, far};
        int off = 0, hit = 0;
        CHECK(scene_end(&s), "memory");
        CHECK(raster_depth(&s, &frustum, back ? RASTER_BACK : RASTER_FRONT, SIDE, 1, depth),
              "memory");
        for (int i = 0; i < SIDE * SIDE; i++) {
            const double x = (2 * (i % SIDE) + 1.0) / SIDE - 1,
                         y = (2 * (i / SIDE) + 1.0) / SIDE - 1;
            double want = 1;
            for (int t = 0; t < s.triangles; t++) {
                double p[3][4];
                for (int k = 0; k < 12; k++) {
                    const vec3 v = s.position[s.triangle[t][k / 4]];
                    p[k / 4][k % 4] = (double)m[k % 4] * (double)v.x +
                                      (double)m[4 + k % 4] * (double)v.y +
                                      (double)m[8 + k % 4] * (double)v.z + (double)m[12 + k % 4];
                }
                // Homogeneous barycentric coordinates: sums of b (x, y, w) are (x, y, 1).
                double b[3], sum = 0, z = 0;
                bool inside = true;
                const double det = p[0][0] * (p[1][1] * p[2][3] - p[2][1] * p[1][3]) -
                                   p[1][0] * (p[0][1] * p[2][3] - p[2][1] * p[0][3]) +
                                   p[2][0] * (p[0][1] * p[1][3] - p[1][1] * p[0][3]);
                if (det == 0 || (back && det > 0)) continue;
                for (int k = 0; k < 3; k++) {
                    const double *q = p[(k + 1) % 3], *r = p[(k + 2) % 3];
                    b[k] = (x * (q[1] * r[3] - r[1] * q[3]) - y * (q[0] * r[3] - r[0] * q[3]) +
                            (q[0] * r[1] - r[0] * q[1])) /
                           det;
                    inside = inside && b[k] >= 0;
                    sum += b[k];
                    z += b[k] * p[k][2];
                }
                if (perspective)
                    z = -1 + 2 * (1 / sum - (double)near) / ((double)far - (double)near);
                if (inside && z >= -1 && z < want) want = z;
            }
            hit += want < 1;
            off += !(fabs((double)depth[i] - want) < 1e-4);
        }
        CHECK(hit > 300 && off <= 3, "trial %d: %d of %d samples are off", trial, off, hit);
        scene_free(&s);
    }
}

static void perspective_depth_is_linear(void)
{
    enum { SIDE = 96 };
    static float depth[SIDE * SIDE];
    const vec3 from = vec(2.5f, 3.2f, 1.5f), back = vec_unit(vec(0.6f, 0.7f, 0.3f));
    const vec3 u = vec_unit(vec_cross(vec(0, 1, 0), back)), v = vec_cross(back, u);
    const vec3 row[4] = {vec_scale(u, 1 / 0.8f), vec_scale(v, 1 / 0.8f), vec(0, 0, 0),
                         vec_scale(back, -1)};
    float m[16];
    scene s;
    scene_create(&s, 0, NULL);
    bvh *tree = bvh_create(&s);
    for (int k = 0; k < 4; k++) {
        m[k] = row[k].x;
        m[4 + k] = row[k].y;
        m[8 + k] = row[k].z;
        m[12 + k] = -vec_dot(row[k], from);
    }
    const raster_frustum frustum = {m, true, 0.5f, 9.0f};
    int off = 0;
    CHECK(raster_depth(&s, &frustum, RASTER_FRONT, SIDE, 1, depth), "memory");
    for (int i = 0; i < SIDE * SIDE; i++) {
        const float x = (2 * (float)(i % SIDE) + 1) / SIDE - 1,
                    y = (2 * (float)(i / SIDE) + 1) / SIDE - 1;
        const vec3 d = vec_mad(vec_mad(vec_scale(back, -1), u, 0.8f * x), v, 0.8f * y);
        const float t = bvh_hit_nearest(tree, from, d); // d advances by 1 along the axis
        const float want = t < 9 ? -1 + 2 * (t - 0.5f) / 8.5f : 1;
        off += fabsf(depth[i] - want) > 5e-4f;
    }
    CHECK(off <= SIDE * SIDE / 1000, "%d samples are off", off);
    bvh_free(tree);
    scene_free(&s);
}

static void camera_sees_what_rays_hit(void)
{
    const camera eye = camera_look(vec(1, 2.5f, 6), vec(0, 0.6f, 0), 0.7f, 1.5f);
    scene s;
    view v;
    int off = 0, pixels = 0;
    scene_create(&s, 0, NULL);
    bvh *tree = bvh_create(&s);
    CHECK(view_create(&v, &s, &eye, 150, 100), "memory");
    for (int i = 0; i < 150 * 100; i++) {
        surface piece[VIEW_SAMPLES];
        const int pieces = view_surfaces(&v, &s, i % 150, i / 150, piece);
        float share = 0;
        for (int k = 0; k < pieces; k++) {
            const vec3 d = vec_sub(piece[k].position, eye.position);
            const float t = bvh_hit_nearest(tree, eye.position, d);
            share += piece[k].share;
            pixels++;
            off += fabsf(t - 1) > 1e-3f;
        }
        CHECK(share <= 1 && (pieces > 0) == (share > 0), "pixel %d", i);
    }
    CHECK(off <= pixels / 500, "%d of %d surfaces are off", off, pixels);
    view_free(&v);
    bvh_free(tree);
    scene_free(&s);
}

// Whatever is behind the scene, the exposure is that of the scene, in proportion to its light.
static void exposure_follows_what_is_lit(void)
{
    const camera eye = camera_look(vec(0.3f, 2.25f, 7.7f), vec(-0.05f, 0.86f, 0), 0.57f, 1.5f);
    const float background[3] = {0, 1, 1e5f};
    scene s;
    view v;
    image im;
    CHECK(scene_create(&s, 0, NULL) && view_create(&v, &s, &eye, 151, 101) &&
              image_create(&im, 151, 101),
          "memory");
    for (int trial = 0; trial < 6; trial++) {
        const float light = trial < 3 ? 1 : 40;
        for (int i = 0; i < 151 * 101; i++) {
            surface piece[VIEW_SAMPLES];
            const bool lit = view_surfaces(&v, &s, i % 151, i / 151, piece) > 0;
            const float value = lit ? light : background[trial % 3];
            image_set(&im, i % 151, i / 151, vec(value, value, value));
        }
        const float exposure = lighting_exposure(&im, &s, &eye);
        unsigned char grey[3];
        const image one = {1, 1, (float[3]){light, light, light}};
        image_tonemap(&one, exposure, grey);
        CHECK(grey[1] > 170 && grey[1] < 210, "light %g before %g: %d", (double)light,
              (double)background[trial % 3], grey[1]);
    }
    // Nothing of the scene in sight: the picture decides.
    const camera up = camera_look(vec(0, 20, 0), vec(1, 40, 0), 0.57f, 1.5f);
    CHECK(lighting_exposure(&im, &s, &up) == image_exposure(&im), "an empty picture");
    image_free(&im);
    view_free(&v);
    scene_free(&s);
}

static float only_seen(vec3 normal, bool seen)
{
    (void)normal;
    return seen ? 1 : 0;
}

// Where one surface fills a pixel, the traced picture is its albedo or black, as a ray says; it may
// be between them where a shadow ends, or another where the samples between touch an edge.
static void traced_pictures_have_shadows(void)
{
    const camera eye = camera_look(vec(1, 2.5f, 6), vec(0, 0.6f, 0), 0.7f, 1.5f);
    const vec3 up = vec_unit(vec(0.3f, 1, 0.2f));
    scene s;
    view v;
    image picture;
    int asked = 0, dark = 0, between = 0;
    CHECK(scene_create(&s, 0, NULL) && view_create(&v, &s, &eye, 150, 100), "memory");
    bvh *tree = bvh_create(&s);
    CHECK(tree && trace_picture(&s, &eye, up, only_seen, 150, 100, &picture), "memory");
    for (int i = 0; i < 150 * 100; i++) {
        surface piece[VIEW_SAMPLES];
        const vec3 got = image_get(&picture, i % 150, i / 150);
        if (view_surfaces(&v, &s, i % 150, i / 150, piece) != 1 || piece[0].share < 1) continue;
        const vec3 albedo = s.albedo[piece[0].object];
        const vec3 from = vec_mad(piece[0].position, piece[0].normal, 2e-3f);
        const bool seen = !bvh_hit_any(tree, from, up, 100);
        asked++;
        dark += !seen;
        between += fabsf(got.x - (seen ? albedo.x : 0)) > 0.02f;
    }
    CHECK(asked > 8000 && dark > asked / 20 && dark < asked / 2, "%d of %d dark", dark, asked);
    CHECK(between < asked / 16, "%d of %d are neither", between, asked);
    test_note("%d pixels, %d dark, %d at edges", asked, dark, between);
    image_free(&picture);
    view_free(&v);
    bvh_free(tree);
    scene_free(&s);
}

static void tree_agrees_with_trying_all(void)
{
    scene s;
    uint64_t random = 31;
    int off = 0;
    scene_create(&s, 0, NULL);
    bvh *tree = bvh_create(&s);
    const int trials = test_trials(1000);
    for (int i = 0; i < trials; i++) {
        const vec3 from =
            vec((float)test_range(&random, -4, 4), (float)test_range(&random, 0.01, 3),
                (float)test_range(&random, -4, 4));
        const vec3 d = i % 20 ? random_direction(&random) : vec(0, i % 40 ? 1.0f : -1.0f, 0);
        const float a = nearest_of_all(&s, from, d, false), b = nearest_of_all(&s, from, d, true);
        const float want = a < b ? a : b, got = bvh_hit_nearest(tree, from, d);
        off += got != want && !(fabsf(got - want) < 1e-4f * want);
        const bool any = bvh_hit_any(tree, from, d, HUGE_VALF);
        CHECK(any == (got < HUGE_VALF), "ray %d: any says %d, nearest %g", i, any, (double)got);
        if (got < HUGE_VALF)
            CHECK(!bvh_hit_any(tree, from, d, 0.999f * got), "ray %d is too short", i);
    }
    CHECK(off <= trials / 300, "%d of %d rays are off", off, trials);
    bvh_free(tree);
    scene_free(&s);
}

static void traced_light_has_known_values(void)
{
    scene s;
    probe p;
    probe_sampler sampler;
    scene_create(&s, 0, NULL);
    bvh *tree = bvh_create(&s);
    probe_create(&p, 16);
    for (int i = 0; i < 18 * 256; i++) p.texels[i] = 0.5f;
    CHECK(probe_sampler_create(&sampler, &p), "memory");
    // High above everything the ground fills the lower half, looking up there is only sky.
    const vec3 open = trace_irradiance(tree, &sampler, vec(0, 50, 0), vec(0, 1, 0), 20000, 1);
    CHECK(fabs((double)open.y / (0.5 * PI) - 1) < 0.02, "irradiance %g for pi / 2", (double)open.y);
    const vec3 below = trace_irradiance(tree, &sampler, vec(0, -0.2f, 0), vec(0, 1, 0), 2000, 1);
    CHECK(below.x < 0.02f, "irradiance %g under the ground", (double)below.x);
    // Straight below the rim of the ground half of a light overhead is hidden.
    const float half = trace_rectangle(tree, vec(4.4f, -5, 0), NULL, vec(0, 1, 0), vec(1, 0, 0),
                                       vec(0, 0, 1), 0.06f, 0.06f, 60, 1);
    CHECK(half > 0.49f && half < 0.52f, "visibility %g", (double)half);
    // A wall there has that half above its horizon, or the other.
    for (int side = -1; side <= 1; side += 2) {
        const vec3 normal = vec((float)side, 0, 0);
        const float seen = trace_rectangle(tree, vec(4.4f, -5, 0), &normal, vec(0, 1, 0),
                                           vec(1, 0, 0), vec(0, 0, 1), 0.06f, 0.06f, 60, 1);
        CHECK(fabsf(seen - (side > 0)) < 0.02f, "seen from a wall: %g", (double)seen);
    }
    probe_sampler_free(&sampler);
    probe_free(&p);
    bvh_free(tree);
    scene_free(&s);
}

const test_case files_tests[] = {
    {"a PFM of either byte order keeps every value", pfm_keeps_values},
    {"flat, old and new HDR coding give the same pixels", hdr_codings_agree},
    {"PFM headers are read in every dialect", pfm_headers_have_dialects},
    {"PFM values may begin late", pfm_values_may_begin_late},
    {"HDR headers are read in every dialect, or refused", hdr_headers_have_dialects},
    {"flat HDR pictures may look coded", flat_pictures_may_look_coded},
    {"pictures cut short anywhere are refused", truncated_pictures_are_refused},
    {"hostile picture headers are refused", hostile_headers_are_refused},
    {"damaged pictures and meshes do no harm", damaged_files_do_no_harm},
    {"files that cannot be opened are named", missing_files_are_named},
    {"options that make no sense are refused", options_are_checked},
    {"a PNG decodes to its pixels and is small", png_decodes_to_its_pixels},
    {"the tone curve is total and monotone", tone_curve_is_total},
    {"texel directions follow the cube map convention", directions_follow_the_convention},
    {"a constant lat-long picture becomes a constant cube", lat_long_keeps_constants},
    {"a bright lat-long pixel keeps energy and direction", lat_long_keeps_single_pixels},
    {"broken lat-long pixels are counted, and an infinite sun is bright",
     broken_pixels_are_counted},
    {"pictures of every layout become probes", pictures_become_probes},
    {"turning a probe moves its light and keeps its energy", turning_moves_light},
    {"a broken texel does not break its neighbours", broken_texels_stay_alone},
    {"a probe survives the way through a strip of faces", strips_round_trip},
    {"OBJ edge cases are read or refused", obj_edge_cases},
    {"OBJ files that are refused have their line named", obj_refusals_name_the_line},
    {"OBJ polygons may be concave", obj_polygons_may_be_concave},
    {"OBJ polygons may be long, within reason", obj_polygons_may_be_long},
    {"OBJ meshes far from the origin keep their shape", obj_far_from_the_origin},
    {"meshes of any size have normals", meshes_of_any_size_have_normals},
    {"the default scene is closed and faces outwards", default_scene_is_closed},
    {"depth maps agree with rays", depth_maps_agree_with_rays},
    {"depth maps cull and cut as OpenGL does", depth_maps_cut_as_opengl_does},
    {"perspective depth is linear along the axis", perspective_depth_is_linear},
    {"the camera sees what rays hit", camera_sees_what_rays_hit},
    {"exposure follows what is lit", exposure_follows_what_is_lit},
    {"traced pictures have the shadows that rays find", traced_pictures_have_shadows},
    {"the tree of boxes finds what trying all finds", tree_agrees_with_trying_all},
    {"traced light has known values", traced_light_has_known_values},
    {NULL, NULL},
};
