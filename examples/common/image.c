#include "image.h"

#include "png.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define IMAGE_SIDE_MOST 32768

bool image_create(image *im, int width, int height)
{
    memset(im, 0, sizeof *im);
    if (width < 1 || height < 1 || width > IMAGE_SIDE_MOST || height > IMAGE_SIDE_MOST)
        return false;
    im->rgb = calloc((size_t)width * (size_t)height, 3 * sizeof *im->rgb);
    if (!im->rgb) return false;
    im->width = width;
    im->height = height;
    return true;
}

void image_free(image *im)
{
    free(im->rgb);
    memset(im, 0, sizeof *im);
}

// What is left to read. Every read goes through here, so that a file can never be read past its
// end.
typedef struct reader {
    const unsigned char *at, *end;
} reader;

static size_t left(const reader *in)
{
    return (size_t)(in->end - in->at);
}

static int next(reader *in)
{
    return in->at < in->end ? *in->at++ : -1;
}

// One line without its newline, cut to the room there is; false at the end of the file.
static bool next_line(reader *in, char *line, size_t room)
{
    size_t length = 0;
    int c = next(in);
    if (c < 0) return false;
    for (; c >= 0 && c != '\n'; c = next(in)) {
        if (length + 1 < room) line[length++] = (char)c;
    }
    if (length > 0 && line[length - 1] == '\r') length--;
    line[length] = 0;
    return true;
}

// One word of a PFM header and the single blank that ends it.
static bool next_word(reader *in, char *word, size_t room)
{
    size_t length = 0;
    int c = next(in);
    while (c == ' ' || c == '\t' || c == '\r' || c == '\n') c = next(in);
    for (; c > ' '; c = next(in)) {
        if (length + 1 >= room) return false;
        word[length++] = (char)c;
    }
    word[length] = 0;
    return length > 0 && c >= 0;
}

// A size written in decimal digits alone; 0 when it is anything else or larger than any picture.
static int parse_side(const char *text)
{
    int side = 0;
    for (; *text >= '0' && *text <= '9' && side <= IMAGE_SIDE_MOST; text++) {
        side = side * 10 + (*text - '0');
    }
    return *text || side > IMAGE_SIDE_MOST ? 0 : side;
}

// ---- PFM

static float float_at(const unsigned char *bytes, bool little)
{
    uint32_t bits = 0;
    float value;
    for (int i = 0; i < 4; i++) bits = bits << 8 | bytes[little ? 3 - i : i];
    memcpy(&value, &bits, sizeof value);
    return value;
}

static bool decode_pfm(image *im, reader in, message *why)
{
    char kind[4], width[16], height[16], scale[32];
    if (!next_word(&in, kind, sizeof kind) || !next_word(&in, width, sizeof width) ||
        !next_word(&in, height, sizeof height) || !next_word(&in, scale, sizeof scale)) {
        return fail(why, "the PFM header is cut short");
    }
    const int channels = kind[1] == 'F' ? 3 : 1;
    const int w = parse_side(width), h = parse_side(height);
    char *end;
    const double order = strtod(scale, &end);
    if (w == 0 || h == 0) {
        return fail(why, "PFM size %.15s x %.15s is not 1..%d", width, height, IMAGE_SIDE_MOST);
    }
    // The size of the number scales to physical units that nobody agrees on; its sign is the byte
    // order, little-endian when negative.
    if (*end || !(order < 0 || order > 0))
        return fail(why, "PFM scale %.20s is not a number", scale);
    const size_t row = (size_t)w * (size_t)channels;
    if (left(&in) / 4 / row < (size_t)h) {
        return fail(why, "PFM of %d x %d needs more bytes than the file has", w, h);
    }
    if (!image_create(im, w, h)) return fail(why, "no memory for %d x %d pixels", w, h);
    for (int y = 0; y < h; y++) {
        const unsigned char *from = in.at + row * 4 * (size_t)(h - 1 - y); // bottom row first
        for (int x = 0; x < w; x++) {
            for (int c = 0; c < 3; c++) {
                const size_t i = (size_t)x * (size_t)channels + (size_t)(channels == 3 ? c : 0);
                im->rgb[((size_t)y * (size_t)w + (size_t)x) * 3 + (size_t)c] =
                    float_at(from + i * 4, order < 0);
            }
        }
    }
    return true;
}

bool image_save_pfm(const image *im, const char *path, message *why)
{
    const size_t row = (size_t)im->width * 3;
    unsigned char *bytes = malloc(64 + row * 4 * (size_t)im->height);
    if (!bytes) return fail(why, "%s: no memory", path);
    unsigned char *to = bytes + sprintf((char *)bytes, "PF\n%d %d\n-1.0\n", im->width, im->height);
    for (int y = im->height - 1; y >= 0; y--) {
        for (size_t i = 0; i < row; i++) {
            uint32_t bits;
            memcpy(&bits, im->rgb + (size_t)y * row + i, sizeof bits);
            for (int b = 0; b < 4; b++) *to++ = (unsigned char)(bits >> (8 * b));
        }
    }
    const bool written = file_write(path, bytes, (size_t)(to - bytes), why);
    free(bytes);
    return written;
}

// ---- Radiance HDR

// The run-length coding since 1991: 2 2 width, then the four channels one after the other.
static bool decode_scanline_new(reader *in, unsigned char *rgbe, int width)
{
    for (int channel = 0; channel < 4; channel++) {
        for (int x = 0; x < width;) {
            int count = next(in);
            if (count <= 0) return false;
            const bool run = count > 128;
            if (run) count -= 128;
            if (count > width - x) return false;
            int value = run ? next(in) : 0;
            for (; count > 0; count--, x++) {
                if (!run) value = next(in);
                if (value < 0) return false;
                rgbe[4 * x + channel] = (unsigned char)value;
            }
        }
    }
    return true;
}

// Plain pixels; 1 1 1 n repeats the last one n times, and such pixels in a row are the digits of a
// larger n, lowest first.
static bool decode_scanline_old(reader *in, unsigned char *rgbe, int width)
{
    int shift = 0;
    for (int x = 0; x < width;) {
        if (left(in) < 4) return false;
        const unsigned char *pixel = in->at;
        in->at += 4;
        if (pixel[0] == 1 && pixel[1] == 1 && pixel[2] == 1) {
            if (x == 0 || shift > 16) return false;
            const long count = (long)pixel[3] << shift;
            if (count > width - x) return false;
            for (long i = 0; i < count; i++, x++) memcpy(rgbe + 4 * x, rgbe + 4 * x - 4, 4);
            shift += 8;
        } else {
            memcpy(rgbe + 4 * x, pixel, 4);
            x++;
            shift = 0;
        }
    }
    return true;
}

static bool decode_scanline(reader *in, unsigned char *rgbe, int width)
{
    if (width >= 8 && width < 32768 && left(in) >= 4 && in->at[0] == 2 && in->at[1] == 2 &&
        in->at[2] < 128) {
        if ((in->at[2] << 8 | in->at[3]) != width) return false;
        in->at += 4;
        return decode_scanline_new(in, rgbe, width);
    }
    return decode_scanline_old(in, rgbe, width);
}

// Reads the header up to and with the line of sizes. Only pictures stored in rows are taken, from
// either corner, as all known writers make them.
static bool decode_hdr_header(reader *in, int *width, int *height, bool *flip_x, bool *flip_y,
                              message *why)
{
    char line[128];
    do {
        if (!next_line(in, line, sizeof line)) return fail(why, "the HDR header is cut short");
        if (!strncmp(line, "FORMAT=", 7) && strcmp(line + 7, "32-bit_rle_rgbe")) {
            return fail(why, "HDR format %.40s is not 32-bit_rle_rgbe", line + 7);
        }
    } while (line[0]);
    char sign_y, sign_x, h[16], w[16];
    if (!next_line(in, line, sizeof line) ||
        sscanf(line, "%cY %15s %cX %15s", &sign_y, h, &sign_x, w) != 4 || !strchr("+-", sign_y) ||
        !strchr("+-", sign_x)) {
        return fail(why, "HDR sizes are not given as -Y height +X width");
    }
    *width = parse_side(w);
    *height = parse_side(h);
    *flip_x = sign_x == '-';
    *flip_y = sign_y == '+';
    if (*width && *height) return true;
    return fail(why, "HDR size %.15s x %.15s is not 1..%d", w, h, IMAGE_SIDE_MOST);
}

static bool decode_hdr(image *im, reader in, message *why)
{
    int w = 0, h = 0;
    bool flip_x = false, flip_y = false;
    if (!decode_hdr_header(&in, &w, &h, &flip_x, &flip_y, why)) return false;
    // The densest coding in use puts 127 pixels into 8 bytes and the old one 255 into 4, so memory
    // stays in proportion to the file whatever its header says.
    if ((size_t)w * (size_t)h / 64 > left(&in)) {
        return fail(why, "HDR of %d x %d needs more bytes than the file has", w, h);
    }
    unsigned char *rgbe = malloc((size_t)w * 4);
    if (!rgbe || !image_create(im, w, h)) {
        free(rgbe);
        return fail(why, "no memory for %d x %d pixels", w, h);
    }
    for (int row = 0; row < h; row++) {
        if (!decode_scanline(&in, rgbe, w)) {
            free(rgbe);
            image_free(im);
            return fail(why, "HDR row %d of %d is broken or cut short", row + 1, h);
        }
        for (int x = 0; x < w; x++) {
            const unsigned char *p = rgbe + 4 * (flip_x ? w - 1 - x : x);
            const float unit = p[3] ? ldexpf(1.0f, p[3] - 136) : 0;
            image_set(im, x, flip_y ? h - 1 - row : row,
                      vec((float)p[0] * unit, (float)p[1] * unit, (float)p[2] * unit));
        }
    }
    free(rgbe);
    return true;
}

bool image_decode(image *im, const unsigned char *bytes, size_t size, message *why)
{
    const reader in = {bytes, bytes + size};
    memset(im, 0, sizeof *im);
    if (size >= 3 && bytes[0] == 'P' && (bytes[1] == 'F' || bytes[1] == 'f') && bytes[2] <= ' ') {
        return decode_pfm(im, in, why);
    }
    if (size >= 2 && bytes[0] == '#' && bytes[1] == '?') return decode_hdr(im, in, why);
    return fail(why, "neither a Radiance .hdr nor a .pfm file");
}

bool image_load(image *im, const char *path, message *why)
{
    unsigned char *bytes;
    size_t size;
    message reason;
    memset(im, 0, sizeof *im);
    if (!file_read(path, &bytes, &size, why)) return false;
    const bool decoded = image_decode(im, bytes, size, &reason);
    free(bytes);
    return decoded || fail(why, "%s: %.180s", path, reason.text);
}

// ---- For the screen

void image_average(image *a, const image *b)
{
    const size_t values = (size_t)a->width * (size_t)a->height * 3;
    for (size_t i = 0; i < values; i++) a->rgb[i] = 0.5f * (a->rgb[i] + b->rgb[i]);
}

float image_rms(const image *a, const image *b)
{
    const size_t values = (size_t)a->width * (size_t)a->height * 3;
    double sum = 0;
    for (size_t i = 0; i < values; i++) {
        const double off = (double)a->rgb[i] - (double)b->rgb[i];
        sum += off * off;
    }
    return (float)sqrt(sum / (double)values);
}

static int compare_floats(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

float image_exposure(const image *im)
{
    // Every 7th pixel is enough for a median; black ones are holes or deep shadow, not the subject.
    const size_t pixels = (size_t)im->width * (size_t)im->height;
    float *samples = malloc((pixels / 7 + 1) * sizeof *samples);
    size_t count = 0;
    if (!samples) return 1;
    for (size_t i = 0; i < pixels; i += 7) {
        const float luminance = vec_luminance(vec_of(im->rgb + 3 * i));
        if (luminance > 0 && luminance < HUGE_VALF) samples[count++] = luminance;
    }
    qsort(samples, count, sizeof *samples, compare_floats);
    const float median = count ? samples[count / 2] : 0;
    free(samples);
    return median > 1e-20f ? 0.33f / median : 1;
}

// As a layer of grains saturates: slope 1 at black, so that shadows, the subject here, keep their
// contrast (film curves with a toe crush them), and a shoulder that never quite reaches white.
static float film(float x)
{
    return 1 - expf(-x);
}

static float srgb(float x)
{
    return x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1 / 2.4f) - 0.055f;
}

void image_tonemap(const image *im, float exposure, unsigned char *rgb8)
{
    const size_t values = (size_t)im->width * (size_t)im->height * 3;
    for (size_t i = 0; i < values; i++) {
        const float x = im->rgb[i] * exposure;
        const float y = x > 0 ? srgb(film(fminf(x, 1e6f))) : 0; // NaN fails the comparison
        rgb8[i] = (unsigned char)(fminf(y, 1) * 255 + 0.5f);
    }
}

bool image_save_png(const image *im, float exposure, const char *path, message *why)
{
    unsigned char *rgb8 = malloc((size_t)im->width * (size_t)im->height * 3);
    if (!rgb8) return fail(why, "%s: no memory", path);
    image_tonemap(im, exposure, rgb8);
    const bool written = png_write(path, rgb8, im->width, im->height, why);
    free(rgb8);
    return written;
}
