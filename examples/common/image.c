#include "image.h"

#include "png.h"

#include <float.h>
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

static bool is_blank(int c)
{
    return c == ' ' || (c >= '\t' && c <= '\r');
}

// One word of a PFM header, behind any blanks and comments, and not the blank that ends it.
static bool next_word(reader *in, char *word, size_t room)
{
    size_t length = 0;
    for (; left(in) && (is_blank(*in->at) || *in->at == '#'); in->at++) {
        if (*in->at != '#') continue;
        while (left(in) > 1 && in->at[1] != '\n' && in->at[1] != '\r') in->at++;
    }
    while (left(in) && *in->at > ' ' && *in->at != '#') {
        if (length + 1 >= room) return false;
        word[length++] = (char)*in->at++;
    }
    word[length] = 0;
    return length > 0 && left(in) > 0 && (is_blank(*in->at) || *in->at == '#');
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

// Behind blanks, a comment of plain text and the line's end; where it was if something else comes
// first.
static reader end_of_line(reader in)
{
    reader at = in;
    bool comment = false;
    for (; left(&at) && *at.at != '\r' && *at.at != '\n'; at.at++) {
        comment |= *at.at == '#';
        if (!is_blank(*at.at) && (!comment || *at.at < ' ')) return in;
    }
    const bool cr = left(&at) && *at.at == '\r', lf = left(&at) > cr && at.at[cr] == '\n';
    at.at += cr + lf;
    return cr || lf ? at : in;
}

// Past further blanks, where these are what the file has too many of. As many at its end make that
// uncertain: then they are values.
static reader past_blanks(reader in, size_t size)
{
    const size_t more = left(&in) > size ? left(&in) - size : 0;
    size_t first = 0, last = 0;
    while (first < more && is_blank(in.at[first])) first++;
    while (last < more && is_blank(in.end[-1 - (ptrdiff_t)last])) last++;
    in.at += first == more && last < more ? more : 0;
    return in;
}

// Where the values of a PFM begin. By the book one blank ends the header, but writers also put CR
// LF, blanks or comments there, and any of these may as well be a value's first byte. So the line
// ends it, with comments below, or that one blank in headers without LF; what fits the size of the
// file goes first.
static reader pfm_values(reader in, const unsigned char *start, size_t size)
{
    const reader one = {in.at + 1, in.end};
    reader line = end_of_line(in);
    const bool single = !memchr(start, '\n', (size_t)(in.at - start));
    if (line.at == in.at || (single && left(&one) == size)) return past_blanks(one, size);
    while (left(&line) != size && left(&line) && *line.at == '#') {
        const reader more = end_of_line(line);
        if (more.at == line.at) break;
        line = more;
    }
    return past_blanks(line, size);
}

static bool decode_pfm(image *im, reader in, message *why)
{
    char kind[4], width[16], height[16], scale[32];
    const unsigned char *start = in.at;
    if (!next_word(&in, kind, sizeof kind) || !next_word(&in, width, sizeof width) ||
        !next_word(&in, height, sizeof height) || !next_word(&in, scale, sizeof scale)) {
        return fail(why, "the PFM header is cut short, or no PFM header");
    }
    const int channels = kind[1] == 'f' ? 1 : kind[2] == '4' ? 4 : 3;
    const int w = parse_side(width), h = parse_side(height);
    char *end;
    const double order = strtod(scale, &end);
    if (w == 0 || h == 0) {
        return fail(why, "PFM size %.15s x %.15s is not 1..%d", width, height, IMAGE_SIDE_MOST);
    }
    // The size of the number scales to physical units that nobody agrees on; its sign is the byte
    // order, little-endian when negative.
    if (*end || !(fabs(order) > 0 && fabs(order) < HUGE_VAL))
        return fail(why, "PFM scale %.20s is not a number", scale);
    const size_t row = (size_t)w * (size_t)channels;
    if (left(&in) / 4 / row < (size_t)h) {
        return fail(why, "PFM of %d x %d needs more bytes than the file has", w, h);
    }
    in = pfm_values(in, start, row * 4 * (size_t)h);
    if (left(&in) < row * 4 * (size_t)h) {
        return fail(why, "PFM of %d x %d needs more bytes than the file has", w, h);
    }
    if (!image_create(im, w, h)) return fail(why, "no memory for %d x %d pixels", w, h);
    for (int y = 0; y < h; y++) {
        const unsigned char *from = in.at + row * 4 * (size_t)(h - 1 - y); // bottom row first
        for (int x = 0; x < w; x++) {
            for (int c = 0; c < 3; c++) {
                const size_t i = (size_t)x * (size_t)channels + (size_t)(channels > 1 ? c : 0);
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

// The numbers of a header's line: "KEY=1 2 3". Blanks around are fine, anything else is not.
static bool parse_values(const char *text, int count, double *value)
{
    for (int i = 0; i < count; i++) {
        char *end;
        value[i] = strtod(text, &end);
        if (end == text || !(fabs(value[i]) < HUGE_VAL)) return false;
        text = end;
    }
    return text[strspn(text, " \t")] == 0;
}

// What a pixel's values must be multiplied by. EXPOSURE and COLORCORR say what they have been
// multiplied by already, and may come several times.
static bool parse_hdr_line(const char *line, double scale[3], message *why)
{
    // The red, green and blue of Rec. 709, which differ from Radiance's own by .01, and both
    // whites.
    static const double rec709[8] = {0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.323, 0.331};
    double value[8] = {1, 1, 1};
    const char *text = line + strcspn(line, "=");
    const size_t key = strcspn(line, " \t=");
    if (!*text++) return true;
    if (key == 6 && !strncmp(line, "FORMAT", key)) {
        const size_t blanks = strspn(text, " \t");
        if (!strcmp(text + blanks, "32-bit_rle_rgbe")) return true;
        return fail(why, "HDR format %.40s is not 32-bit_rle_rgbe", text + blanks);
    }
    if (key == 8 && !strncmp(line, "EXPOSURE", key)) {
        if (!parse_values(text, 1, value)) value[0] = 0;
        value[1] = value[2] = value[0];
    } else if (key == 9 && !strncmp(line, "COLORCORR", key)) {
        if (!parse_values(text, 3, value)) value[0] = 0;
    } else if (key == 5 && !strncmp(line, "GAMMA", key)) {
        return (parse_values(text, 1, value) && value[0] == 1) ||
               fail(why, "HDR values are not linear: %.60s", line);
    } else if (key == 9 && !strncmp(line, "PRIMARIES", key)) {
        bool near = parse_values(text, 8, value);
        for (int i = 0; i < 8 && near; i++) near = fabs(value[i] - rec709[i]) <= 0.0151;
        return near || fail(why, "HDR colours are not those of Rec. 709: %.100s", line);
    }
    for (int c = 0; c < 3; c++) {
        scale[c] /= value[c];
        if (!(value[c] > 0 && scale[c] > 1e-30 && scale[c] < 1e30)) {
            return fail(why, "an HDR picture cannot have %.60s", line);
        }
    }
    return true;
}

static bool next_hdr_line(reader *in, char *line, size_t room)
{
    if (!next_line(in, line, room)) return false;
    size_t length = strlen(line);
    while (length > 0 && is_blank(line[length - 1])) length--;
    line[length] = 0;
    return true;
}

// Reads the header up to and with the line of sizes. Only pictures stored in rows are taken, from
// either corner, as all known writers make them.
static bool decode_hdr_header(reader *in, int *width, int *height, bool *flip_x, bool *flip_y,
                              double scale[3], message *why)
{
    char line[128];
    message reason = {{0}};
    for (int number = 1; next_hdr_line(in, line, sizeof line); number++) {
        if (!line[0]) break;
        // Lines behind a tab are of the pictures that this one was composed of, by Radiance's pcompos.
        if (line[0] != '#' && line[0] != '\t' &&
            !parse_hdr_line(line + strspn(line, " \t"), scale, &reason)) {
            return fail(why, "line %d: %.200s", number, reason.text);
        }
    }
    if (!left(in)) return fail(why, "the HDR header has no empty line at its end, or is cut short");
    char sign_y, sign_x, h[16], w[16];
    if (!next_hdr_line(in, line, sizeof line) ||
        sscanf(line, " %cY %15s %cX %15s", &sign_y, h, &sign_x, w) != 4 || !strchr("+-", sign_y) ||
        !strchr("+-", sign_x)) {
        return fail(why, "HDR sizes are not given as -Y height +X width: %.60s", line);
    }
    *width = parse_side(w);
    *height = parse_side(h);
    *flip_x = sign_x == '-';
    *flip_y = sign_y == '+';
    if (*width && *height) return true;
    return fail(why, "HDR size %.15s x %.15s is not 1..%d", w, h, IMAGE_SIDE_MOST);
}

// Whether these are plain pixels from first to last, some of which look like marks of a coding:
// they fill the rest of the file to the byte, and read as coded rows they do not.
static bool is_flat(reader in, unsigned char *rgbe, int w, int h)
{
    if (left(&in) != 4 * (size_t)w * (size_t)h) return false;
    for (int row = 0; row < h; row++) {
        const bool marked = w >= 8 && in.at[0] == 2 && in.at[1] == 2 && in.at[2] < 128;
        if (!decode_scanline(&in, rgbe, w)) return true;
        if (row == 0 && marked) return false; // a whole row of runs is no chance: cut short perhaps
        if (left(&in) < 4) return row + 1 < h || left(&in) > 0;
    }
    return true;
}

static bool decode_hdr(image *im, reader in, message *why)
{
    int w = 0, h = 0;
    bool flip_x = false, flip_y = false;
    double scale[3] = {1, 1, 1};
    if (!decode_hdr_header(&in, &w, &h, &flip_x, &flip_y, scale, why)) return false;
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
    const bool flat = is_flat(in, rgbe, w, h);
    for (int row = 0; row < h; row++) {
        if (flat) {
            memcpy(rgbe, in.at, 4 * (size_t)w);
            in.at += 4 * (size_t)w;
        } else if (!decode_scanline(&in, rgbe, w)) {
            free(rgbe);
            image_free(im);
            return fail(why, "HDR row %d of %d is broken or cut short", row + 1, h);
        }
        for (int x = 0; x < w; x++) {
            const unsigned char *p = rgbe + 4 * (flip_x ? w - 1 - x : x);
            const double unit = p[3] ? ldexp(1, p[3] - 136) : 0;
            // Divided by an exposure, the brightest may leave the range of float.
            image_set(im, x, flip_y ? h - 1 - row : row,
                      vec((float)fmin(p[0] * unit * scale[0], FLT_MAX),
                          (float)fmin(p[1] * unit * scale[1], FLT_MAX),
                          (float)fmin(p[2] * unit * scale[2], FLT_MAX)));
        }
    }
    free(rgbe);
    return true;
}

bool image_decode(image *im, const unsigned char *bytes, size_t size, message *why)
{
    // Some editors leave a mark of UTF-8 at the start.
    const size_t mark = size >= 3 && !memcmp(bytes, "\xef\xbb\xbf", 3) ? 3 : 0;
    const reader in = {bytes + mark, bytes + size};
    memset(im, 0, sizeof *im);
    bytes += mark;
    size -= mark;
    if (size >= 4 && bytes[0] == 'P' && (bytes[1] == 'F' || bytes[1] == 'f') &&
        (bytes[2] <= ' ' || bytes[2] == '#' || (bytes[2] == '4' && bytes[1] == 'F'))) {
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

// Slope 1 at black, so that shadows, the subject here, keep their contrast (film curves with a toe
// crush them), and a long shoulder: a lamp 20 times as bright as a white wall is not white yet.
static float film(float x)
{
    return 1 - 1 / ((1 + 0.5f * x) * (1 + 0.5f * x));
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

bool image_save(const image *im, float exposure, const char *path, message *why)
{
    const size_t length = strlen(path);
    if (length > 4 && !strcmp(path + length - 4, ".pfm")) return image_save_pfm(im, path, why);
    return image_save_png(im, exposure, path, why);
}
