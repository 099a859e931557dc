#include "gl_percentage_closer.h"

#include <stdio.h>

#include "methods.h"

// NORMAL: the bias follows the receiver's plane (Isidoro 2006). How depth changes along it, from 0 to
// 1, with the place in the map; and the depth up to which texels off the receiver's place block.
static const char plane_text[] =
    "#if NORMAL\n"
    "#define RECEIVER vec3 position, vec3 normal\n"
    "vec2 plane;\n"
    "void find_plane(int light, vec3 normal)\n"
    "{\n"
    "    mat3 row = transpose(mat3(reference[light].world_to_shadow));\n"
    "    vec3 along = normal * row / vec3(dot(row[0], row[0]), dot(row[1], row[1]), dot(row[2], "
    "row[2]));\n"
    "    plane = clamp(-along.xy / along.z, -1e3, 1e3);\n"
    "}\n"
    "float before(float z, vec2 off) { return min(z + dot(plane, off), z); }\n"
    "#else\n"
    "#define RECEIVER vec3 position\n"
    "#define find_plane(light, normal)\n"
    "#define before(z, off) z\n"
    "#endif\n";

// The kernel in cells: texels, or as much larger as the kernel is wider than TAPS of them.
static const char gather_text[] =
    "struct Found { float area, depths, all; };\n" // of blockers, in cells; all: of the kernel
    "Found blockers(int light, vec2 centre, vec2 half_size, float z)\n"
    "{\n"
    "    vec2 side = textureSize(depth_maps, 0).xy;\n"
    "    vec2 cell = max(2 * side * half_size / TAPS, 1);\n"
    "    vec2 low = (centre - half_size) * side / cell, high = (centre + half_size) * side / "
    "cell;\n"
    "    vec2 first = floor(low), step = cell / side, at;\n"
    "    Found f = Found(0, 0, (high.x - low.x) * (high.y - low.y));\n"
    "    for (at.y = first.y; at.y < high.y; at.y += 2) {\n"
    "        vec2 y = at.y + vec2(0, 1);\n"
    "#if NORMAL\n"
    "        vec2 rise = plane * step;\n"
    "        float ahead = dot(plane, (vec2(first.x, at.y) + 0.5) * step - centre);\n"
    "#endif\n"
    "        vec2 rows = clamp(min(y + 1, high.y) - max(y, low.y), 0, 1);\n"
    "        for (at.x = first.x; at.x < high.x; at.x += 2) {\n"
    "            vec2 x = at.x + vec2(0, 1);\n"
    "            vec2 columns = clamp(min(x + 1, high.x) - max(x, low.x), 0, 1);\n"
    "            vec4 depth = textureGather(depth_maps, vec3((at + 1) * step, light));\n"
    "            vec4 limit = vec4(z);\n"
    "#if NORMAL\n"
    "            limit = min(z + ahead + vec4(rise.y, rise.x + rise.y, rise.x, 0), z);\n"
    "            ahead += 2 * rise.x;\n"
    "#endif\n"
    "            vec4 share = columns.xyyx * rows.yyxx * vec4(lessThan(depth, limit));\n"
    "            f.area += dot(share, vec4(1));\n"
    "            f.depths += dot(share, depth);\n"
    "        }\n"
    "    }\n"
    "    return f;\n"
    "}\n"
    "float mssm_visibility(int light, RECEIVER)\n"
    "{\n"
    "    vec3 p = shadow_place(light, position);\n"
    "    vec3 kernel = reference[light].kernel.xyz;\n"
    "    find_plane(light, normal);\n"
    "    vec2 least = 0.5 / textureSize(depth_maps, 0).xy;\n"
    "    float z = min(0.5 * (p.z - kernel.z) + 0.5, 1);\n"
    "    Found f = blockers(light, p.xy, max(kernel.xy * (p.z + 1), least), z);\n"
    "    if (f.area <= 0) return 1;\n"
    "    if (f.area >= 0.9999 * f.all) return 0;\n"
    "    float blocker = 2 * f.depths / f.area - 1;\n"
    "    f = blockers(light, p.xy, max(kernel.xy * (p.z - blocker), least), z);\n"
    "    return clamp(1 - f.area / f.all, 0, 1);\n"
    "}\n";

// The samples' rings and places on them, in shares of the perimeter. Where a pixel begins is
// interleaved gradient noise (Jimenez 2014).
static const char sampled_text[] =
    "#ifndef PIXEL\n"
    "#define PIXEL gl_FragCoord.xy\n"
    "#endif\n"
    "vec2 turned(int i, float turn)\n"
    "{\n"
    "    vec2 at = fract(samples[i].y + turn + vec2(0, 0.75));\n"
    "    return samples[i].x * clamp(abs(8 * at - 4) - 2, -1, 1);\n"
    "}\n"
    "float map_depth(int light, vec2 at) { return textureLod(depth_maps, vec3(at, light), 0).r; }\n"
    "float mssm_visibility(int light, RECEIVER)\n"
    "{\n"
    "    vec3 p = shadow_place(light, position);\n"
    "    vec4 kernel = reference[light].kernel;\n"
    "    find_plane(light, normal);\n"
    "    vec2 least = 0.5 / textureSize(depth_maps, 0).xy;\n"
    "    float z = min(0.5 * (p.z - kernel.z) + 0.5, 1), sum = 0, blockers = 0, blocked = 0;\n"
    "    float noise = 52.9829189 * fract(dot(PIXEL, vec2(0.06711056, 0.00583715)));\n"
    "    float turn = fract(noise + 0.618034 * (kernel.w + 3 * light));\n"
    "    vec2 wide = max(kernel.xy * (p.z + 1), least);\n"
    "    for (int i = 0; i < SAMPLES; i++) {\n"
    "        vec2 off = wide * turned(i, turn);\n"
    "        float d = map_depth(light, p.xy + off);\n"
    "        if (d < before(z, off)) { sum += d; blockers++; }\n"
    "    }\n"
    "    if (blockers == 0) return 1;\n"
    "    wide = max(kernel.xy * (p.z - 2 * sum / blockers + 1), least);\n"
    "    for (int i = 0; i < SAMPLES; i++) {\n"
    "        vec2 off = wide * turned(i, turn);\n"
    "        if (map_depth(light, p.xy + off) < before(z, off)) blocked++;\n"
    "    }\n"
    "    return 1 - blocked / SAMPLES;\n"
    "}\n";

static void write_sampled(int samples, bool normal, char *text, size_t room)
{
    ring_sample sample[SAMPLES_MAX];
    poisson_pattern(samples, sample);
    int at = snprintf(
        text, room,
        "#define NORMAL %d\n#define SAMPLES %d\n%s%sconst vec2 samples[SAMPLES] = vec2[SAMPLES](",
        normal, samples, gl_reference_text, plane_text);
    for (int i = 0; i < samples; i++) {
        at += snprintf(text + at, room - (size_t)at, "%svec2(%.5f, %.5f)", i ? ", " : "",
                       (double)sample[i].ring, (double)sample[i].at / 8);
    }
    snprintf(text + at, room - (size_t)at, ");\n%s", sampled_text);
}

void gl_percentage_closer_visibility(gl_percentage_closer_kind kind, char *text, size_t room)
{
    const bool normal = gl_percentage_closer_normal(kind);
    if (kind == GL_PERCENTAGE_CLOSER_TAPS) {
        gl_reference_visibility(GL_REFERENCE_PCSS, text, room);
    } else if (kind == GL_PERCENTAGE_CLOSER_GATHER || kind == GL_PERCENTAGE_CLOSER_GATHER_NORMAL) {
        snprintf(text, room, "#define NORMAL %d\n#define TAPS %d\n%s%s%s", normal,
                 GL_REFERENCE_TAPS, gl_reference_text, plane_text, gather_text);
    } else {
        const bool more = kind == GL_PERCENTAGE_CLOSER_32 || kind == GL_PERCENTAGE_CLOSER_32_NORMAL;
        write_sampled(more ? 32 : 16, normal, text, room);
    }
}

bool gl_percentage_closer_normal(gl_percentage_closer_kind kind)
{
    return kind >= GL_PERCENTAGE_CLOSER_GATHER_NORMAL;
}
