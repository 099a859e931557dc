#!/bin/sh
# Fuzzers of tests/fuzz, under the address and undefined behaviour sanitizers.
#     sh tests/fuzz.sh short     the corpus and FUZZ_RUNS (1500) mutations of it, the same everywhere, with any
#                                compiler: a part of `make test-all`
#     sh tests/fuzz.sh           FUZZ_SECONDS (60) each with clang's libFuzzer, called by `make fuzz`;
#                                FUZZ=map chooses one. What it finds is kept in build/fuzz/NAME, an input that
#                                fails as build/fuzz/NAME-crash-... : run build/fuzz/NAME.bin on it.
set -u
cd "$(dirname "$0")/.." || exit 1
flags="-std=c99 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror -g -O1 -fno-omit-frame-pointer"
sanitizers="-fsanitize=address,undefined,float-cast-overflow -fno-sanitize-recover=all"
failed=0
mkdir -p build/fuzz

# result NAME STATUS LOG
result()
{
    if [ "$2" = 0 ]; then
        echo "ok    fuzz $1: $(tail -n 1 "$3")"
    else
        echo "FAIL  fuzz $1"
        grep -v '^#\|NEW_FUNC' "$3" | tail -n 20
        failed=1
    fi
}

# Without the sanitizers where the compiler has none.
short()
{
    program=build/fuzz/$1-short
    # shellcheck disable=SC2086
    ${CC:-cc} $flags $sanitizers tests/fuzz/fuzz_$1.c tests/fuzz/driver.c -o $program -lm 2>/dev/null ||
        ${CC:-cc} $flags tests/fuzz/fuzz_$1.c tests/fuzz/driver.c -o $program -lm || return 1
    FUZZ_RUNS=${FUZZ_RUNS-1500} $program tests/fuzz/corpus/$1/*
}

long()
{
    mkdir -p build/fuzz/$1
    # shellcheck disable=SC2086
    clang $flags $sanitizers -fsanitize=fuzzer tests/fuzz/fuzz_$1.c -o build/fuzz/$1.bin -lm &&
        build/fuzz/$1.bin -max_total_time="${FUZZ_SECONDS:-60}" -max_len=4096 -timeout=20 \
            -malloc_limit_mb=64 -rss_limit_mb=2000 -artifact_prefix=build/fuzz/$1- build/fuzz/$1 tests/fuzz/corpus/$1
}

[ "${1-}" = short ] && kind=short || kind=long
if [ $kind = long ] && ! command -v clang >/dev/null; then
    echo "skip  fuzz: apt-get install clang"
    exit 0
fi
for name in ${FUZZ:-moments map filtered scattering probe images files}; do
    $kind $name >build/fuzz/$name.log 2>&1
    result $name $? build/fuzz/$name.log
done
exit $failed
