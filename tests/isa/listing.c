#include "listing.h"

#include <ctype.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_BLOCKS = 2048 };

typedef struct block {
    int id, last; // of the loop that begins here, as an index, or -1
    double count[LISTING_KINDS], turns;
} block;

static bool starts(const char *op, const char *const *with)
{
    for (; *with; with++) {
        if (!strncmp(op, *with, strlen(*with))) return true;
    }
    return false;
}

static listing_kind kind_of(const char *op)
{
    static const char *const waiting[] = {"s_waitcnt", "s_nop",       "s_clause", "s_inst_prefetch",
                                          "s_sleep",   "s_delay_alu", "s_endpgm", "s_code_end",
                                          "v_nop",     "s_wait_idle", NULL};
    static const char *const slow[] = {"v_rcp", "v_rsq", "v_sqrt", "v_sin",
                                       "v_cos", "v_exp", "v_log",  NULL};
    static const char *const loads[] = {"s_load", "s_buffer_load", "ds_", NULL};
    static const char *const scalar[] = {"s_", NULL}, *const vector[] = {"v_", NULL};
    static const char *const memory[] = {"image_",   "buffer_",  "global_", "flat_",
                                         "scratch_", "tbuffer_", NULL};
    if (starts(op, waiting)) return LISTING_KINDS;
    if (starts(op, loads)) return LISTING_OTHER;
    if (starts(op, scalar)) return LISTING_SCALAR;
    if (starts(op, slow)) return LISTING_SLOW;
    if (starts(op, vector)) return LISTING_VECTOR;
    if (!starts(op, memory)) return LISTING_KINDS;
    return strstr(op, "store") || strstr(op, "atomic") ? LISTING_WRITE : LISTING_READ;
}

// A branch back closes a loop over all blocks in between; the last of several counts.
static void close_loop(block *b, int count, int target)
{
    for (int i = 0; i < count; i++) {
        if (b[i].id == target) b[i].last = count - 1;
    }
}

// Lines of the listing: "BB3:", and a tab, the instruction, a semicolon and its encoding.
static int read_blocks(const char *text, block *b)
{
    int count = 1, id;
    b[0] = (block){.last = -1, .turns = 1};
    while (*text) {
        char line[256], op[64];
        const size_t length = strcspn(text, "\n");
        snprintf(line, sizeof line, "%.*s", (int)length, text);
        text += length + (text[length] == '\n');
        line[strcspn(line, ";/")] = 0;
        if (sscanf(line, "BB%d:", &id) == 1) {
            if (id == b[count - 1].id) continue;
            if (count == MOST_BLOCKS) return 0;
            b[count++] = (block){.id = id, .last = -1, .turns = 1};
        } else if (sscanf(line, " %63s", op) == 1 && isalpha((unsigned char)op[0])) {
            const listing_kind kind = kind_of(op);
            const char *to = strstr(op, "branch") ? strstr(line, "BB") : NULL;
            if (kind < LISTING_KINDS) b[count - 1].count[kind]++;
            if (to) close_loop(b, count, atoi(to + 2));
        }
    }
    return count;
}

int listing_count(const char *assembly, const int turns[LISTING_LOOPS],
                  double executed[LISTING_KINDS])
{
    static block b[MOST_BLOCKS];
    const int count = read_blocks(assembly, b);
    int loops = 0;
    for (int k = 0; k < LISTING_KINDS; k++) executed[k] = 0;
    for (int i = 0; i < count; i++) {
        if (b[i].last >= 0) {
            const int n = loops < LISTING_LOOPS ? turns[loops] : 0;
            for (int k = i; k <= b[i].last; k++) b[k].turns *= n;
            loops++;
        }
        for (int k = 0; k < LISTING_KINDS; k++) executed[k] += b[i].turns * b[i].count[k];
    }
    return loops;
}
