// The test harness: a suite is an array of named properties; a failing one can be rerun alone by
// name.
//     build/release/test                 runs everything
//     build/release/test "enclose|GL"    runs the tests whose name contains one of the words
//     build/release/test "-GL|layered"   runs those whose name contains neither
// TEST_SCALE=10 divides the number of random trials by ten (used under valgrind and sanitizers).
// TEST_STOP=1 ends the program at the first failed check (used for mutants); TEST_TIMES=1 says what
// each test costs.
#ifndef TEST_H
#define TEST_H

#include <stdint.h>

typedef struct test_case {
    const char *name; // the property that holds
    void (*run)(void);
} test_case;

// Marks the running test as failed and prints where and why (printf arguments follow the
// condition).
#define CHECK(condition, ...)                                         \
    do {                                                              \
        if (!(condition)) test_fail(__FILE__, __LINE__, __VA_ARGS__); \
    } while (0)

#if defined __GNUC__
#define TEST_PRINTF(text, first) __attribute__((format(printf, text, first)))
#else
#define TEST_PRINTF(text, first)
#endif

void test_fail(const char *file, int line, const char *format, ...) TEST_PRINTF(3, 4);
// Prints a figure that a test measured: worst case, seed, percentile.
void test_note(const char *format, ...) TEST_PRINTF(1, 2);
// Marks the running test as skipped: what is missing, and the line that installs it.
void test_skip(const char *format, ...) TEST_PRINTF(1, 2);
// The number of trials to run when the full number is n.
int test_trials(int n);

// xorshift64*: the same sequence on every machine.
uint64_t test_random(uint64_t *state);
double test_uniform(uint64_t *state);                        // [0,1)
double test_range(uint64_t *state, double low, double high); // [low,high)

// One array per suite, ended by a null name.
#define CPU(room, name) extern const test_case name##_tests[];
#define ALL(room, name) CPU(room, name)
#define GL64(room, name) CPU(room, name)
#include "../suites.h"
#undef CPU
#undef ALL
#undef GL64

#endif
