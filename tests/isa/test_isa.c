#include "listing.h"
#include "../support/test.h"

// As RADV prints it: an inner loop in an outer one, with two branches back, and a branch forward.
static const char assembly[] = "BB0:\n"
                               "\ts_load_dwordx4 s[0:3], s[2:3], 0x0  ; f4080001 fa000000\n"
                               "\ts_waitcnt lgkmcnt(0)                ; bf8cc07f\n"
                               "\tv_mov_b32_e32 v0, 0                 ; 7e000280\n"
                               "BB1:\n"
                               "\timage_load v[0:3], v[0:1], s[0:7]   ; f0000f08\n"
                               "\tv_rcp_f32_e32 v1, v0                ; 7e025500\n"
                               "\ts_cbranch_scc0 BB3                  ; bf840003\n"
                               "BB2:\n"
                               "\tv_add_f32_e32 v1, v0, v1            ; 06020300\n"
                               "\tv_mul_f32_e32 v1, v0, v1            ; 10020300\n"
                               "\ts_cbranch_vccz BB2                  ; bf860003\n"
                               "\ts_branch BB2                        ; bf820003\n"
                               "BB3:\n"
                               "\tbuffer_load_dword v1, v0, s[0:3], 0 ; e0301000\n"
                               "\ts_branch BB1                        ; bf820003\n"
                               "BB4:\n"
                               "\timage_store v[0:3], v[0:1], s[0:7]  ; f0200f08\n"
                               "\tds_read_b32 v0, v1                  ; d8d80000\n"
                               "\ts_endpgm                            ; bf810000\n";

static void executed_instructions(void)
{
    const int turns[LISTING_LOOPS] = {5, 7};
    const double expected[LISTING_KINDS] = {1 + 5 * 7 * 2, 5, 5 + 5 * 7 * 2 + 5, 5 + 5, 1, 2};
    double n[LISTING_KINDS];
    CHECK(listing_count(assembly, turns, n) == 2, "not two loops");
    for (int k = 0; k < LISTING_KINDS; k++) {
        CHECK(n[k] == expected[k], "kind %d: %g, not %g", k, n[k], expected[k]);
    }
}

const test_case isa_tests[] = {
    {"instructions that a GPU executes are counted through nested loops", executed_instructions},
    {0, 0},
};
