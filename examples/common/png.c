#include "png.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

// ---- Output: bytes, and deflate's bits, lowest first

typedef struct stream {
    unsigned char *bytes;
    size_t size, room;
    uint32_t bits; // not written yet
    int bit_count;
    bool failed; // out of memory: everything after is dropped
} stream;

static void put_byte(stream *out, unsigned byte)
{
    if (out->size == out->room) {
        const size_t room = out->room * 2 + 4096;
        unsigned char *grown = realloc(out->bytes, room);
        if (!grown) {
            out->failed = true;
            return;
        }
        out->bytes = grown;
        out->room = room;
    }
    out->bytes[out->size++] = (unsigned char)byte;
}

static void put_word(stream *out, uint32_t word) // big-endian
{
    for (int shift = 24; shift >= 0; shift -= 8) put_byte(out, word >> shift & 255);
}

static void put_bits(stream *out, uint32_t bits, int count)
{
    out->bits |= bits << out->bit_count;
    for (out->bit_count += count; out->bit_count >= 8; out->bit_count -= 8, out->bits >>= 8) {
        put_byte(out, out->bits & 255);
    }
}

// Huffman codes stand in the stream with their highest bit first.
static void put_code(stream *out, unsigned code, int length)
{
    uint32_t reversed = 0;
    for (int i = 0; i < length; i++) reversed |= (code >> i & 1u) << (length - 1 - i);
    put_bits(out, reversed, length);
}

// ---- Deflate with the fixed code (RFC 1951, 3.2.6)

static void put_symbol(stream *out, unsigned symbol)
{
    if (symbol < 144)
        put_code(out, 0x30 + symbol, 8);
    else if (symbol < 256)
        put_code(out, 0x190 + symbol - 144, 9);
    else if (symbol < 280)
        put_code(out, symbol - 256, 7);
    else
        put_code(out, 0xc0 + symbol - 280, 8);
}

// Lengths and distances share one scheme: the classes double in width every few steps. Writes value
// as class and extra bits and returns the class; per_octave is 4 for lengths and 2 for distances.
static unsigned split_value(unsigned value, unsigned per_octave, int *extra_bits, unsigned *extra)
{
    int shift = 0;
    while (value >> shift >= 2 * per_octave) shift++;
    *extra_bits = shift;
    *extra = value & ((1u << shift) - 1);
    return (unsigned)shift * per_octave + (value >> shift);
}

static void put_match(stream *out, unsigned length, unsigned distance)
{
    int extra_bits;
    unsigned extra;
    if (length == 258) {
        put_symbol(out, 285); // the longest has a class of its own
    } else {
        put_symbol(out, 257 + split_value(length - 3, 4, &extra_bits, &extra));
        put_bits(out, extra, extra_bits);
    }
    put_code(out, split_value(distance - 1, 2, &extra_bits, &extra), 5);
    put_bits(out, extra, extra_bits);
}

enum { WINDOW = 32768, HASHES = 1 << 15, CHAIN = 64 };

typedef struct matcher {
    const unsigned char *data;
    size_t size;
    size_t newest[HASHES];  // position + 1 of the last three bytes with this hash; 0 for none
    size_t earlier[WINDOW]; // the one before it
} matcher;

static unsigned hash_at(const unsigned char *p)
{
    return ((unsigned)p[0] * 0x9e37u ^ (unsigned)p[1] * 0x79b9u ^ (unsigned)p[2] * 0x4f1bu) %
           HASHES;
}

static void remember(matcher *m, size_t at)
{
    if (at + 3 > m->size) return;
    const unsigned hash = hash_at(m->data + at);
    m->earlier[at % WINDOW] = m->newest[hash];
    m->newest[hash] = at + 1;
}

static unsigned longest_match(const matcher *m, size_t at, unsigned *distance)
{
    unsigned best = 2;
    if (at + 3 > m->size) return 0;
    const size_t most = m->size - at < 258 ? m->size - at : 258;
    size_t next = m->newest[hash_at(m->data + at)];
    for (int i = 0; i < CHAIN && next > 0 && at - (next - 1) < WINDOW; i++) {
        const unsigned char *a = m->data + at, *b = m->data + next - 1;
        unsigned length = 0;
        while (length < most && a[length] == b[length]) length++;
        if (length > best) {
            best = length;
            *distance = (unsigned)(a - b);
        }
        next = m->earlier[(next - 1) % WINDOW];
    }
    return best;
}

static void deflate(stream *out, const unsigned char *data, size_t size)
{
    matcher *m = calloc(1, sizeof *m);
    out->failed |= !m;
    if (!m) return;
    m->data = data;
    m->size = size;
    put_bits(out, 3, 3); // last block, fixed code
    for (size_t at = 0; at < size;) {
        unsigned distance = 0, later = 0;
        unsigned length = longest_match(m, at, &distance);
        remember(m, at);
        // A literal first, when the match that starts one byte later is longer. A match of three
        // bytes from far away takes more bits than three literals.
        if (length >= 3 && length < 32) later = longest_match(m, at + 1, &(unsigned){0});
        if (length < 3 || (length == 3 && distance > 4096) || later > length) {
            put_symbol(out, data[at++]);
            continue;
        }
        put_match(out, length, distance);
        for (size_t end = at + length; ++at < end;) remember(m, at);
    }
    put_symbol(out, 256);
    put_bits(out, 0, 7); // to the next whole byte
    free(m);
}

// ---- PNG

static uint32_t crc32(const unsigned char *bytes, size_t size)
{
    uint32_t crc = 0xffffffffu;
    for (size_t i = 0; i < size; i++) {
        crc ^= bytes[i];
        for (int k = 0; k < 8; k++) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

static uint32_t adler32(const unsigned char *bytes, size_t size)
{
    uint32_t a = 1, b = 0;
    for (size_t i = 0; i < size; i++) {
        a = (a + bytes[i]) % 65521;
        b = (b + a) % 65521;
    }
    return b << 16 | a;
}

static int paeth(int left, int up, int corner)
{
    const int guess = left + up - corner;
    const int dl = abs(guess - left), du = abs(guess - up), dc = abs(guess - corner);
    return dl <= du && dl <= dc ? left : du <= dc ? up : corner;
}

// One row through filter 0..4 into out (without the filter's byte); returns the sum of the
// differences' sizes, the usual guess at how well they compress.
static long filter_row(int filter, const unsigned char *row, const unsigned char *above, int bytes,
                       unsigned char *out)
{
    long cost = 0;
    for (int i = 0; i < bytes; i++) {
        const int left = i >= 3 ? row[i - 3] : 0, up = above ? above[i] : 0;
        const int corner = i >= 3 && above ? above[i - 3] : 0;
        const int guesses[5] = {0, left, up, (left + up) / 2, paeth(left, up, corner)};
        out[i] = (unsigned char)(row[i] - guesses[filter]);
        cost += out[i] < 128 ? out[i] : 256 - out[i];
    }
    return cost;
}

static void filter_picture(const unsigned char *rgb8, int width, int height, unsigned char *out,
                           unsigned char *trial)
{
    const size_t bytes = (size_t)width * 3;
    for (size_t y = 0; y < (size_t)height; y++, out += bytes + 1) {
        long best = -1;
        for (int filter = 0; filter < 5; filter++) {
            const unsigned char *row = rgb8 + y * bytes;
            const long cost = filter_row(filter, row, y ? row - bytes : NULL, (int)bytes, trial);
            if (best >= 0 && cost >= best) continue;
            best = cost;
            out[0] = (unsigned char)filter;
            memcpy(out + 1, trial, bytes);
        }
    }
}

// A chunk is written with its length left open; this fills the length in and adds the checksum.
static void end_chunk(stream *out, size_t start)
{
    if (out->failed) return;
    const size_t length = out->size - start - 8;
    for (size_t i = 0; i < 4; i++) out->bytes[start + i] = (unsigned char)(length >> (24 - 8 * i));
    put_word(out, crc32(out->bytes + start + 4, length + 4));
}

static size_t begin_chunk(stream *out, const char *name)
{
    const size_t start = out->size;
    put_word(out, 0);
    for (int i = 0; i < 4; i++) put_byte(out, (unsigned char)name[i]);
    return start;
}

unsigned char *png_encode(const unsigned char *rgb8, int width, int height, size_t *size)
{
    const size_t row = (size_t)width * 3 + 1, filtered = row * (size_t)height;
    stream out = {0};
    unsigned char *lines = malloc(filtered + row);
    if (!lines) return NULL;
    filter_picture(rgb8, width, height, lines, lines + filtered);

    put_word(&out, 0x89504e47);
    put_word(&out, 0x0d0a1a0a);
    size_t chunk = begin_chunk(&out, "IHDR");
    put_word(&out, (uint32_t)width);
    put_word(&out, (uint32_t)height);
    put_byte(&out, 8);                             // bits a channel
    put_byte(&out, 2);                             // RGB
    for (int i = 0; i < 3; i++) put_byte(&out, 0); // deflate, adaptive filters, not interlaced
    end_chunk(&out, chunk);
    chunk = begin_chunk(&out, "sRGB");
    put_byte(&out, 0);
    end_chunk(&out, chunk);
    chunk = begin_chunk(&out, "IDAT");
    put_byte(&out, 0x78); // deflate with a window of 32 KiB
    put_byte(&out, 0x9c);
    deflate(&out, lines, filtered);
    put_word(&out, adler32(lines, filtered));
    end_chunk(&out, chunk);
    end_chunk(&out, begin_chunk(&out, "IEND"));

    free(lines);
    if (out.failed) {
        free(out.bytes);
        return NULL;
    }
    *size = out.size;
    return out.bytes;
}

bool png_write(const char *path, const unsigned char *rgb8, int width, int height, message *why)
{
    size_t size;
    unsigned char *bytes = png_encode(rgb8, width, height, &size);
    if (!bytes) return fail(why, "%s: no memory", path);
    const bool written = file_write(path, bytes, size, why);
    free(bytes);
    return written;
}
