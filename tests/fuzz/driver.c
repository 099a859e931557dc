// Runs a fuzzer without libFuzzer, under any compiler: every file named on the command line, then
// FUZZ_RUNS (1000) mutations of them, the same on every machine.
#include "fuzz.h"

static uint64_t state = 88172645463325252u;

static size_t below(size_t n)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (size_t)((state >> 11) % n);
}

static size_t read_file(const char *path, uint8_t *bytes, size_t room)
{
    FILE *file = fopen(path, "rb");
    if (!file) {
        perror(path);
        exit(2);
    }
    const size_t size = fread(bytes, 1, room, file);
    fclose(file);
    return size;
}

// Changes, inserts, removes and doubles bytes; ends up with at most `room`.
static size_t mutate(uint8_t *bytes, size_t size, size_t room)
{
    for (size_t n = below(6) + 1; n > 0; n--) {
        const size_t at = below(size + 1), kind = below(5), length = below(size - at + 1);
        if (kind == 0 && size < room) {
            memmove(bytes + at + 1, bytes + at, size - at);
            bytes[at] = (uint8_t)below(256);
            size++;
        } else if (kind == 1) {
            memmove(bytes + at, bytes + at + length, size - at - length);
            size -= length;
        } else if (kind == 2 && size + length <= room) {
            memmove(bytes + at + length, bytes + at, size - at);
            size += length;
        } else if (at < size) {
            bytes[at] = (uint8_t)(kind == 3 ? below(256) : bytes[at] ^ 1u << below(8));
        }
    }
    return size;
}

// In a block of exactly this size, so that a sanitizer or valgrind sees what is read beyond it.
static void run(const uint8_t *bytes, size_t size)
{
    uint8_t *copy = fuzz_allocate(size);
    memcpy(copy, bytes, size);
    LLVMFuzzerTestOneInput(copy, size);
    free(copy);
}

int main(int argc, char **argv)
{
    static uint8_t bytes[4096];
    const char *text = getenv("FUZZ_RUNS");
    const int runs = text ? atoi(text) : 1000;
    for (int i = 1; i < argc; i++) run(bytes, read_file(argv[i], bytes, sizeof bytes));
    for (int i = 0; i < runs; i++) {
        size_t size = below(200);
        if (argc > 1 && i % 4) {
            size = read_file(argv[1 + below((size_t)argc - 1)], bytes, sizeof bytes);
            size = mutate(bytes, size, sizeof bytes);
        } else {
            for (size_t k = 0; k < size; k++) bytes[k] = (uint8_t)below(256);
        }
        run(bytes, size);
    }
    printf("%d files and %d mutations\n", argc - 1, runs);
    return 0;
}
