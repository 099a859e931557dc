#!/bin/sh
# Lines and branches of both headers' CPU halves that the tests take, as a table; exit 1 below 100%.
# Two builds are added up: with vectors of four floats and without, as lightprobe.h has code for both; for
# the second its own tests do.
# Whatever a table of 100% leaves out is printed below it. Called by `make coverage`; needs gcc and gcov.
# COVERAGE_OF is the pattern of the tests to run, all without it.
set -u
cd "$(dirname "$0")/.." || exit 1
command -v gcov >/dev/null || { echo "skip  coverage: apt-get install gcc"; exit 0; }
flags="-O0 -g --coverage -DNO_THREADS -Dalways_inline=unused"

# build CONFIG FLAGS [TESTS]: runs the tests and leaves gcov's text in build/CONFIG/gcov.txt.
build()
{
    ${MAKE:-make} -s -j2 CC=gcc config="$1" CFLAGS="$flags $2" test-cpu || exit 1
    find "build/$1" -name '*.gcda' -exec rm -f {} +
    TEST_SCALE=10 "build/$1/test-cpu" ${3:+"$3"} >"build/$1/log" || { grep -v '^ok' "build/$1/log"; exit 1; }
    gcov -b -c -t "build/$1/cpu/examples/common/implementation.o" >"build/$1/gcov.txt" || exit 1
}

build coverage "" "${COVERAGE_OF-}"
build coverage-plain -U__SSE2__ "parts:|edges:|probe: hostile|probe: a |probe: lights follow"

for header in mssm.h lightprobe.h; do
    # "count:line:text" before the branches of that line; counts are - (no code), ##### or a number.
    awk -v header=$header '
        /^ *-: *0:Source:/ { wanted = $0 ~ ("[:/]" header "$") }
        !wanted { next }
        /^ *[-#=0-9*]+: *[0-9]+:/ {
            split($0, part, ":"); count = part[1]; line = part[2] + 0; branch = 0
            gsub(/[ *]/, "", count)
            source[line] = substr($0, index($0, part[2] ":") + length(part[2]) + 1)
            if (count == "-") next
            if (!(line in hits)) { hits[line] = 0; order[n++] = line }
            if (count + 0 > 0) hits[line] = 1
        }
        /^branch/ {
            key = line "," branch++
            if (!(key in taken)) { taken[key] = 0; of[m] = line; keys[m++] = key }
            if ($0 ~ /taken [1-9]/) taken[key] = 1
        }
        END {
            for (i = 0; i < n; i++) if (hits[order[i]]) lines++; else missed[order[i]] = 1
            for (i = 0; i < m; i++) if (taken[keys[i]]) branches++; else missed[of[i]] = 1
            printf "%-14s lines %4d of %4d  %6.2f%%   branches %4d of %4d  %6.2f%%\n", header, lines, n,
                   100 * lines / n, branches, m, 100 * branches / m
            for (i = 0; i < n; i++) if (order[i] in missed) print "    not taken: " source[order[i]]
            exit lines < n || branches < m || n < 500
        }' build/coverage/gcov.txt build/coverage-plain/gcov.txt || failed=1
done
echo "left out: the OpenGL halves (MSSM_NO_GL, LIGHTPROBE_NO_GL); and what only other compilers see:"
for header in mssm.h lightprobe.h; do
    awk -v header=$header '
        /^#ifndef (MSSM|LIGHTPROBE)_NO_GL/ { exit }
        /^#if/ { depth++; gnu[depth] = /^#if defined __GNUC__( \|\| defined _MSC_VER)?$/; other[depth] = 0 }
        /^#else/ { other[depth] = gnu[depth]; next }
        /^#endif/ { other[depth] = 0; depth-- }
        other[depth] { print "    " header ": " $0 }' $header
done
if [ -n "${failed-}" ]; then
    echo "FAIL  coverage of the CPU halves is below 100%"
    exit 1
fi
echo "ok    all lines and branches of the CPU halves are taken"
