// Machine code of the shaders for three AMD GPUs, by Mesa's compiler: `make isa` writes docs/gpu.md
// with it, `make test` holds the ceilings below.
//
//     isa WORK PAGE     shaders and assembly go to the folder WORK; a line a check: "ok" or "FAIL"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../compare/figures.h"
#include "listing.h"
#include "radv.h"
#include "texts.h"

typedef enum subject_kind {
    LAYERED,
    FILTERED,
    REFERENCE,
    SAMPLES,
    TABLES,
    MIPS,
    KERNEL
} subject_kind;

typedef struct subject {
    const char *name; // as in docs/accuracy.csv; of a kernel, its label
    subject_kind kind;
    int variant; // moments, gl_reference_kind, gl_percentage_closer_kind or terms of convolution
    mssm_settings settings;
    int turns
        [LISTING_LOOPS]; // of its loops, in the order of the code; {ANY}: it depends on the input
    int most_vgprs,
        most_vector; // ceilings on navi21: registers, vector instructions executed; 0: none
} subject;

enum { ANY = -1 };

// Loops turn: looks at the cone 2 (up to 6) and kernels 2 (up to 4), which is what receivers of the
// chart take in the mean (1.9 and 1.6), rounded up; rows of PCSS, whose columns and samples are
// unrolled; a pass over 256 texels; taps of a filter 1. CEILINGS are the last two numbers of a
// line: lower them as soon as a shader gets cheaper.
static const subject subjects[] = {
    {"layered, 6 moments", LAYERED, 6, {.moments = 6}, {2, 2}, 80, 2560},
    {"layered, 4 moments", LAYERED, 4, {.moments = 4}, {2, 2}, 80, 1990},
    {LAYERED_HORIZON, LAYERED, 6, {6, MSSM_HORIZON, 0, 0, 0, 0}, {2, 2}, 80, 2930},
    {"MSSM 6, lower blocker", LAYERED, 6, {6, MSSM_LOWER_BLOCKER, 0, 0, 0, 0}, {2}, 64, 1434},
    {"MSSM 4, lower blocker", LAYERED, 4, {4, MSSM_LOWER_BLOCKER, 0, 0, 0, 0}, {2}, 64, 1009},
    {"MSSM 6, upper blocker", LAYERED, 6, {6, MSSM_UPPER_BLOCKER, 0, 0, 0, 0}, {2}, 64, 1434},
    {"MSSM 4, upper blocker", LAYERED, 4, {4, MSSM_UPPER_BLOCKER, 0, 0, 0, 0}, {2}, 64, 1009},
    {"filtered hard, 6 moments", FILTERED, 6, {0}, {1}, 32, 430},
    {"filtered hard, 4 moments", FILTERED, 4, {0}, {1}, 24, 290},
    {"hard", REFERENCE, GL_REFERENCE_HARD, {0}, {0}, 0, 0},
    {PCSS_TAPS, SAMPLES, GL_PERCENTAGE_CLOSER_TAPS, {0}, {27, 27}, 0, 0},
    {PCSS_GATHER, SAMPLES, GL_PERCENTAGE_CLOSER_GATHER, {0}, {14, 14, 14, 14}, 0, 0},
    {PCSS_POISSON, SAMPLES, GL_PERCENTAGE_CLOSER_16, {0}, {0}, 0, 0},
    {PCSS_MORE, SAMPLES, GL_PERCENTAGE_CLOSER_32, {0}, {0}, 0, 0},
    {PCSS_GATHER_NORMAL, SAMPLES, GL_PERCENTAGE_CLOSER_GATHER_NORMAL, {0}, {14, 14, 14, 14}, 0, 0},
    {PCSS_POISSON_NORMAL, SAMPLES, GL_PERCENTAGE_CLOSER_16_NORMAL, {0}, {0}, 0, 0},
    {PCSS_MORE_NORMAL, SAMPLES, GL_PERCENTAGE_CLOSER_32_NORMAL, {0}, {0}, 0, 0},
    {CSSM8 CSSM_TABLES, TABLES, 4, {0}, {0}, 0, 0},
    {CSSM16 CSSM_TABLES, TABLES, 8, {0}, {0}, 0, 0},
    {CSSM_ANNEN CSSM_TABLES, TABLES, 16, {0}, {0}, 0, 0},
    {CSSM8 CSSM_MIPS, MIPS, 4, {0}, {0}, 0, 0},
    {CSSM16 CSSM_MIPS, MIPS, 8, {0}, {0}, 0, 0},
    {CSSM_ANNEN CSSM_MIPS, MIPS, 16, {0}, {0}, 0, 0},
    {"mssm resolve", KERNEL, 6, {0}, {4}, 16, 0},
    {"mssm rows", KERNEL, 6, {0}, {5, 1, 6}, 80, 300},
    {"mssm halve", KERNEL, 6, {0}, {5, 1, 6}, 80, 700},
    {"mssm columns", KERNEL, 6, {0}, {256 / 8}, 56, 3180},
    {"lightprobe tiles", KERNEL, 6, {0}, {ANY}, 56, 0},
    {"lightprobe leaves", KERNEL, 6, {0}, {ANY}, 32, 0},
    {"lightprobe gather", KERNEL, 6, {0}, {ANY}, 56, 0},
    {"lightprobe divide", KERNEL, 6, {0}, {ANY}, 64, 0},
    {"lightprobe reassign", KERNEL, 6, {0}, {ANY}, 64, 0},
    {"lightprobe write", KERNEL, 6, {0}, {ANY}, 64, 0},
};
enum { SUBJECTS = sizeof subjects / sizeof *subjects, GPUS = 3, CEILING_GPU = 1 };

static const struct {
    const char *family, *later, *name; // RADV's, and that of later versions
} gpus[GPUS] = {{"vega10", "vega10", "Vega 10 (GCN 5)"},
                {"navi21", "navi21", "Navi 21 (RDNA 2)"},
                {"gfx1100", "navi31", "Navi 31 (RDNA 3)"}};

typedef struct result {
    radv_code code;
    double executed[LISTING_KINDS];
} result;

static result results[SUBJECTS][GPUS];
static char driver[256];
static int failures;

static void stop(const char *what, const char *detail)
{
    printf("FAIL  %s %s\n", what, detail);
    exit(1);
}

// ---- Compiling ----

static bool write_text(const subject *s, char *text)
{
    if (s->kind == LAYERED) return texts_layered(text, s->variant, &s->settings);
    if (s->kind == FILTERED) return texts_filtered(text, s->variant);
    if (s->kind == REFERENCE) return texts_reference(text, (gl_reference_kind)s->variant);
    if (s->kind == KERNEL) return texts_kernel(text, s->name, s->variant);
    if (s->kind == SAMPLES) return texts_samples(text, (gl_percentage_closer_kind)s->variant);
    return texts_convolution(text, s->kind == MIPS ? GL_CONVOLUTION_MIPS : GL_CONVOLUTION_TABLES,
                             s->variant);
}

static void path_of(char path[512], const char *folder, int i, const char *end)
{
    int at = snprintf(path, 512, "%.300s/", folder);
    for (const char *c = subjects[i].name; *c; c++) path[at++] = *c == ' ' || *c == ',' ? '_' : *c;
    snprintf(path + at, (size_t)(512 - at), ".%s", end);
}

static void save(const char *path, const char *text)
{
    FILE *f = fopen(path, "w");
    if (!f || fputs(text, f) < 0 || fclose(f)) stop("cannot write", path);
}

// GLSL of OpenGL is taken as it is: -R puts loose uniforms into a block, bindings are moved apart.
static void compile(const char *folder, int i)
{
    static char text[TEXTS_ROOM];
    char from[512], to[512], command[4096];
    if (!write_text(&subjects[i], text)) stop("no text of", subjects[i].name);
    path_of(from, folder, i, "comp");
    path_of(to, folder, i, "spv");
    save(from, text);
    snprintf(command, sizeof command,
             "glslangValidator -V -R -S comp --target-env vulkan1.2 --auto-map-bindings "
             "--auto-map-locations --shift-image-binding 16 --shift-ssbo-binding 32 "
             "--shift-ubo-binding 48 -o '%s' '%s' >'%s.log' || { cat '%s.log'; false; }",
             to, from, to, to);
    if (system(command)) stop("glslangValidator refuses", from);
}

static size_t load(const char *path, uint32_t *to, size_t words)
{
    FILE *f = fopen(path, "rb");
    const size_t count = f ? fread(to, sizeof *to, words, f) : 0;
    if (f) fclose(f);
    if (count == 0 || count == words) stop("cannot read", path);
    return count * sizeof *to;
}

static void judge(radv *r, const char *folder, int i, int gpu)
{
    static uint32_t spirv[1 << 18];
    const subject *s = &subjects[i];
    result *to = &results[i][gpu];
    char path[512], end[32];
    int loops = 0;
    path_of(path, folder, i, "spv");
    const size_t bytes = load(path, spirv, sizeof spirv / sizeof *spirv);
    if (!radv_compile(r, spirv, bytes, &to->code)) stop("RADV refuses", s->name);
    snprintf(end, sizeof end, "%s.s", gpus[gpu].family);
    path_of(path, folder, i, end);
    save(path, to->code.assembly);
    while (loops < LISTING_LOOPS && s->turns[loops]) loops++;
    const int found = listing_count(to->code.assembly, s->turns, to->executed);
    if (found != loops && s->turns[0] != ANY) {
        printf("FAIL  %s: %d loops, but turns of %d are known\n", s->name, found, loops);
        failures++;
    }
    free(to->code.assembly);
}

// ---- Ceilings ----

// Nothing may spill; scalar registers of passes may move to lanes of vector ones.
static void check_subject(int i)
{
    const subject *s = &subjects[i];
    const result *r = &results[i][CEILING_GPU];
    const int vgprs = r->code.vgprs, vector = (int)(r->executed[LISTING_VECTOR] + 0.5);
    int spilled = 0;
    for (int g = 0; g < GPUS; g++) {
        const radv_code *c = &results[i][g].code;
        spilled += c->spilled_vgprs + c->scratch + (s->kind == KERNEL ? 0 : c->spilled_sgprs);
    }
    const bool good = spilled == 0 && (!s->most_vgprs || vgprs <= s->most_vgprs) &&
                      (!s->most_vector || vector <= s->most_vector);
    failures += !good;
    printf("%s  %s: spilled %d", good ? "ok  " : "FAIL", s->name, spilled);
    if (s->most_vgprs) printf(", %d registers of %d", vgprs, s->most_vgprs);
    if (s->most_vector) printf(", %d vector instructions of %d", vector, s->most_vector);
    printf("\n");
}

// ---- The page ----

typedef enum column {
    REGISTERS,
    WAVES,
    BYTES,
    LATENCY,
    VECTOR,
    SLOW,
    READS,
    ARITHMETIC,
    COLUMNS
} column;

static double value_of(int i, int gpu, column c)
{
    const result *r = &results[i][gpu];
    const double *n = r->executed;
    switch (c) {
    case REGISTERS: return r->code.vgprs;
    case WAVES: return r->code.waves;
    case BYTES: return r->code.bytes;
    case LATENCY: return r->code.latency;
    case VECTOR: return n[LISTING_VECTOR];
    case SLOW: return n[LISTING_SLOW];
    case READS: return n[LISTING_READ];
    default: return n[LISTING_VECTOR] + 4 * n[LISTING_SLOW]; // in time of those at full rate
    }
}

static int named(const char *name)
{
    for (int i = 0; i < SUBJECTS; i++) {
        if (!strcmp(subjects[i].name, name)) return i;
    }
    stop("no subject", name);
    return 0;
}

// Of two subjects on the GPU of the ceilings.
static double ratio(const char *name, const char *to, column c)
{
    return value_of(named(name), CEILING_GPU, c) / value_of(named(to), CEILING_GPU, c);
}

// One number where it is the same for all GPUs.
static void print_cell(FILE *f, int i, column c)
{
    char text[GPUS][32];
    int same = 0;
    for (int g = 0; g < GPUS; g++) {
        const double one = c == ARITHMETIC ? value_of(0, g, c) : 1;
        snprintf(text[g], sizeof text[g], c == ARITHMETIC ? "%.2f" : "%.0f",
                 value_of(i, g, c) / one);
        same += !strcmp(text[g], text[0]);
    }
    fprintf(f, " %s", text[0]);
    for (int g = 1; g < GPUS && same < GPUS; g++) fprintf(f, " / %s", text[g]);
    fprintf(f, " |");
}

static void print_llvmpipe(FILE *f, const figures *measured, const char *name)
{
    const figure *a = figures_find(measured, "gl", "default", name, 16, "shade_ms");
    const figure *b = figures_find(measured, "gl", "default", subjects[0].name, 16, "shade_ms");
    if (a && b)
        fprintf(f, " %.2f |", a->value / b->value);
    else
        fprintf(f, " |");
}

static void print_table(FILE *f, const figures *measured, bool kernels)
{
    const column last = kernels ? READS : ARITHMETIC;
    fprintf(f, "\n| %s | registers | waves | bytes | latency | vector | slow | reads |%s\n",
            kernels ? "pass" : "shading", kernels ? "" : " arithmetic | llvmpipe |");
    fprintf(f, "|---|---|---|---|---|---|---|---|%s\n", kernels ? "" : "---|---|");
    for (int i = 0; i < SUBJECTS; i++) {
        if ((subjects[i].kind == KERNEL) != kernels) continue;
        fprintf(f, "| %s |", subjects[i].name);
        for (column c = 0; c <= last; c++) {
            if (c >= VECTOR && subjects[i].turns[0] == ANY)
                fprintf(f, " |");
            else
                print_cell(f, i, c);
        }
        if (!kernels) print_llvmpipe(f, measured, subjects[i].name);
        fprintf(f, "\n");
    }
}

static void print_ratios(FILE *f)
{
    static const char *const rivals[] = {PCSS_TAPS,          PCSS_GATHER,         PCSS_POISSON,
                                         PCSS_GATHER_NORMAL, PCSS_POISSON_NORMAL, PCSS_MORE_NORMAL,
                                         CSSM16 CSSM_TABLES, CSSM16 CSSM_MIPS};
    fprintf(
        f,
        "\n**Which ratios hold where.** Times under OpenGL in [accuracy.md](accuracy.md) are of "
        "llvmpipe, a rasterizer on\nthe CPU, where every read of a texture is arithmetic too. On "
        "a GPU the slower of the two units decides. Arithmetic and\nreads, relative to \"" LAYERED_HORIZON
        "\" (%s):\n\n"
        "| | arithmetic | reads |\n"
        "|---|---|---|\n",
        gpus[CEILING_GPU].name);
    for (size_t i = 0; i < sizeof rivals / sizeof *rivals; i++) {
        fprintf(f, "| %s | %.2f | %.2f |\n", rivals[i],
                ratio(rivals[i], LAYERED_HORIZON, ARITHMETIC),
                ratio(rivals[i], LAYERED_HORIZON, READS));
    }
    fprintf(f,
            "\nPCSS is counted with its widest kernel. A read of tables takes four texels of 128 "
            "bits, one of mip maps eight of\n32 or 64 bits, which GPUs filter for free: mip maps "
            "shade faster there than llvmpipe says, but cost memory and\nupdate time.\n");
}

static void write_page(const char *path, const figures *measured)
{
    FILE *f = fopen(path, "w");
    if (!f) stop("cannot write", path);
    fprintf(f,
            "# What GPUs execute\n\n"
            "Written by `make isa`, which needs no GPU: RADV, Mesa's driver for AMD, compiles the "
            "shaders to\nmachine code for GPUs that are not installed. No time is measured, and "
            "caches are not modelled.\n\n"
            "Compiler: %s. Numbers between slashes: ",
            driver);
    for (int g = 0; g < GPUS; g++) fprintf(f, "%s%s", g ? ", " : "", gpus[g].name);
    fprintf(f, ".\nThe light is the same for all threads.\n");
    print_ratios(f);
    print_table(f, measured, false);
    fprintf(f,
            "\nPasses that make the tables of 256 x 256 texels with 6 moments, and the lights.\n");
    print_table(f, measured, true);
    fprintf(
        f,
        "\n- **registers**: vector registers of a thread; none is spilled to memory. **waves**: "
        "how many waves fit on a SIMD\n  at once, to work while others wait for memory (RDNA: "
        "waves of 32 threads).\n"
        "- **latency**: clocks of one wave alone, by the compiler's model, which takes every "
        "loop for 8 turns.\n"
        "- **vector, slow, reads**: instructions that a wave executes if it takes every branch, "
        "as it does as soon as one\n  of its threads does: every block of the assembly times the "
        "turns of the loops around it (2 lookups in the cone and 2 kernels, the chart's mean "
        "rounded up; for PCSS its\n  widest kernel, twice; for columns 32 times eight rows). "
        "slow: reciprocals, roots, powers, at a quarter of the rate. reads: of\n  images and "
        "buffers, with the receiver's position. Empty where turns depend on the probe.\n"
        "- **arithmetic**: vector + 4 slow; **llvmpipe**: time of the shading pass with 16 "
        "lights (docs/accuracy.csv); both\n  relative to the first row.\n");
    if (fclose(f)) stop("cannot write", path);
}

int main(int argc, char **argv)
{
    figures measured = {NULL, 0, 0};
    if (argc != 3) stop("usage:", "isa WORK PAGE");
    radv *one = radv_open(gpus[CEILING_GPU].family);
    if (!one) {
        printf("skip  isa: apt-get install mesa-vulkan-drivers\n");
        return 0;
    }
    radv_close(one);
    if (!figures_load(&measured, "docs/accuracy.csv")) return 1;
    for (int i = 0; i < SUBJECTS; i++) compile(argv[1], i);
    for (int g = 0; g < GPUS; g++) {
        radv *r = radv_open(gpus[g].family);
        if (!r) r = radv_open(gpus[g].later);
        if (!r) stop("RADV knows no", gpus[g].family);
        snprintf(driver, sizeof driver, "%s", radv_driver(r));
        for (int i = 0; i < SUBJECTS; i++) judge(r, argv[1], i, g);
        radv_close(r);
    }
    for (int i = 0; i < SUBJECTS; i++) check_subject(i);
    write_page(argv[2], &measured);
    figures_free(&measured);
    return failures != 0;
}
