#include "test.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static int failures, skipped; // of the running test

void test_fail(const char *file, int line, const char *format, ...)
{
    if (failures++ >= 5) return; // the first few say enough
    va_list list;
    va_start(list, format);
    printf("    %s:%d: ", file, line);
    vprintf(format, list);
    printf("\n");
    va_end(list);
    if (getenv("TEST_STOP")) exit(1);
}

void test_note(const char *format, ...)
{
    va_list list;
    va_start(list, format);
    printf("    ");
    vprintf(format, list);
    printf("\n");
    va_end(list);
}

void test_skip(const char *format, ...)
{
    va_list list;
    va_start(list, format);
    printf("    skipped: ");
    vprintf(format, list);
    printf("\n");
    va_end(list);
    skipped = 1;
}

int test_trials(int n)
{
    const char *text = getenv("TEST_SCALE");
    const int scale = text ? atoi(text) : 1;
    return scale > 1 ? (n / scale > 0 ? n / scale : 1) : n;
}

// Several words have | between them. One with a slash is of a room or of a suite: "map/", "map/visibility".
static int chosen(const char *suite, const char *name, const char *words)
{
    const int without = words[0] == '-';
    for (const char *at = words + without; *at;) {
        char word[80];
        const size_t length = strcspn(at, "|");
        snprintf(word, sizeof word, "%.*s", (int)length, at);
        if (strstr(strchr(word, '/') ? suite : name, word)) return !without;
        at += length + (at[length] == '|');
    }
    return without;
}

int main(int argc, char **argv)
{
    const struct {
        const char *name;
        const test_case *tests;
    } suites[] = {
#define CPU(room, name) {#room "/" #name, name##_tests},
#ifdef TEST_CPU_ONLY
#define ALL(room, name)
#else
#define ALL(room, name) CPU(room, name)
#endif
#if UINTPTR_MAX > 0xffffffffu
#define GL64(room, name) ALL(room, name)
#else
#define GL64(room, name)
#endif
#include "../suites.h"
    };
    int passed = 0, failed = 0, left_out = 0;
    setvbuf(stdout, NULL, _IOLBF, 0);
    for (size_t s = 0; s < sizeof suites / sizeof *suites; s++) {
        for (const test_case *test = suites[s].tests; test->name; test++) {
            if (argc > 1 && !chosen(suites[s].name, test->name, argv[1])) continue;
            failures = skipped = 0;
            const clock_t start = clock();
            test->run();
            if (getenv("TEST_TIMES"))
                printf("    %.1f s of all cores\n", (double)(clock() - start) / CLOCKS_PER_SEC);
            printf("%s  %s\n", failures ? "FAIL" : skipped ? "skip" : "ok  ", test->name);
            if (failures)
                failed++;
            else if (skipped)
                left_out++;
            else
                passed++;
        }
    }
    if (passed + failed + left_out == 0) printf("no test is named like \"%s\"\n", argv[1]);
    printf("%d passed, %d failed, %d skipped\n", passed, failed, left_out);
    return failed || passed + left_out == 0;
}
