#!/bin/sh
# Do the tests notice? Changes operators and constants of the moment math, the tables and the cuts of a copy
# of the headers, one at a time, and runs the CPU tests on each. Exit 1 if a mutant survives that
# tests/mutants.txt does not list as equivalent, with its reason. Called by `make mutants`; 10 minutes.
#     MUTANTS=300 make mutants    how many, spread evenly over all that there are (about 1900)
#     FIRST=7                     another choice of as many
#     AGAIN=1                     those that survived the last run
#     ONLY="text of a line"       all mutants of the lines that contain it
set -u
cd "$(dirname "$0")/.." || exit 1
work=build/mutants
mkdir -p $work
CC=${CC:-gcc}
export CC work

# One candidate a line: header, line, column, length, replacement, what it is, text of the line. Columns and
# lines are those of this run's headers; the list of equivalent mutants goes by the text.
candidates()
{
    awk -v OFS='\t' -v only="${ONLY-}" '
        function offer(at, length_, to)
        {
            text = line; sub(/^ +/, "", text); sub(/ *\/\/.*$/, "", text)
            if (only != "" && !index(text, only)) return
            key = substr(line, at, length_) " -> " to
            gsub(/^ +/, "", key)
            count[FILENAME, FNR, key]++
            if (count[FILENAME, FNR, key] > 1) key = key " (" count[FILENAME, FNR, key] ")"
            print FILENAME, FNR, at, length_, to, key, text
        }
        BEGIN {
            n = split("+ - * / < > <= >= == != && || += -= << >> | &", from, " ")
            split("- + / * >= <= > < != == || && -= += >> << & |", to, " ")
        }
        FNR == 1 { inside = 0 }
        /^#else/ { other = 1 } # not compiled here
        /^#endif/ { other = 0 }
        other { next }
        /^#ifdef MSSM_IMPLEMENTATION|^#if defined LIGHTPROBE_IMPLEMENTATION/ { implementation = FILENAME }
        implementation != FILENAME { next }
        /^\/\/ (\[glsl begin\]|---- Moments and|---- Tables|Disc irradiance|Sums over tiles|Cells of all|Leaves:|Clusters:)/ {
            inside = 1
        }
        /^\/\/ (---- Lights|---- Estimators|Directions and solid|Lights$|The paper)/ { inside = 0 }
        !inside || /^ *\/\// { next }
        /^#/ && !/^#define [A-Z_0-9]+ +[-(0-9]/ { next }
        {
            line = $0
            code = line
            sub(/\/\/.*$/, "", code)
            for (at = 1; at <= length(code); at++) {
                rest = substr(code, at)
                for (i = 1; i <= n; i++) {
                    if (index(rest, " " from[i] " ") == 1) offer(at + 1, length(from[i]), to[i])
                }
                before = at > 1 ? substr(code, at - 1, 1) : " "
                if (before ~ /[A-Za-z0-9_.]/ || !match(rest, /^[0-9]+(\.[0-9]+)?(e-?[0-9]+)?f?/)) continue
                number = substr(rest, 1, RLENGTH)
                after = substr(rest, RLENGTH + 1, 1)
                if (after ~ /[A-Za-z_]/ || /uint32_t|int32_t|float [a-z0-9]+\[|struct/ && after == "]") continue
                if (number ~ /[.ef]/) offer(at, RLENGTH, number + 0 == 0 ? "1.0f" : "(2 * " number ")")
                else if (after == "]" && before == "[") offer(at, RLENGTH, number > 0 ? number - 1 : 1)
                else offer(at, RLENGTH, number + 1)
                at += RLENGTH - 1
            }
        }' mssm.h lightprobe.h
}

candidates >$work/all.tsv
total=$(wc -l <$work/all.tsv)
wanted=${MUTANTS:-240}
[ -n "${ONLY-}" ] && wanted=$total
# Evenly spread.
awk -v n="$wanted" -v total="$total" -v first="${FIRST:-0}" '
    int(NR * n / total) > int((NR - 1) * n / total) && first == 0 { print }
    first > 0 && NR % int(total / n) == first % int(total / n) { print }' $work/all.tsv >$work/chosen.tsv
if [ -n "${AGAIN-}" ]; then
    awk -F '\t' 'NR == FNR { if ($1 == "survived") left[$2, $3, $4]; next } ($1, $6, $7) in left' \
        $work/results.tsv $work/all.tsv >$work/chosen.tsv
fi
echo "$(wc -l <$work/chosen.tsv) of $total mutants"

${MAKE:-make} -s -j2 config=mutants CC="$CC" CFLAGS=-O1 test-cpu || exit 1
# Fast tests first, then those that need many trials.
cat >$work/run.sh <<'EOF'
for run in "100 -layered" "20 -layered" "10 moments:" "4 "; do
    TEST_STOP=1 TEST_SCALE=${run%% *} timeout 100 "$1" "${run#* }" || exit 1
done
EOF
sh $work/run.sh build/mutants/test-cpu >$work/log || { echo "FAIL  the tests fail without any mutant"; exit 1; }

# one NUMBER: prints "killed by ..." or "survived", and the mutant.
cat >$work/one.sh <<'EOF'
number=$1
IFS='	' read -r header line at length to key text <<END
$(sed -n "${number}p" $work/chosen.tsv)
END
tree=$work/tree$number
mkdir -p $tree/examples/common
cp mssm.h lightprobe.h $tree
cp examples/common/implementation.c $tree/examples/common
awk -v line="$line" -v at="$at" -v length_="$length" -v to="$to" '
    NR == line { $0 = substr($0, 1, at - 1) to substr($0, at + length_) }
    { print }' $header >$tree/$header
verdict=survived
if ! $CC -std=c99 -w -O1 -DMSSM_NO_GL -DLIGHTPROBE_NO_GL -c $tree/examples/common/implementation.c -o $tree/it.o 2>$tree/log; then
    verdict="killed by the compiler"
else
    $CC $tree/it.o $(find build/mutants/cpu -name '*.o' ! -name implementation.o) -o $tree/test -lm -lpthread
    if ! sh $work/run.sh $tree/test >$tree/log 2>&1; then
        verdict="killed by $(grep -v '^    \|^ok\|^skip' $tree/log | head -n 1)"
        [ "$verdict" = "killed by " ] && verdict="killed by $(tail -n 1 $tree/log)"
    fi
fi
printf '%s\t%s\t%s\t%s\n' "$verdict" "$header" "$key" "$text"
rm -rf $tree
EOF
seq "$(wc -l <$work/chosen.tsv)" | xargs -P 2 -n 1 sh $work/one.sh >$work/results.tsv

# Survivors that are not in the list. Both ways: what is listed must be there in the headers.
awk -F '\t' '
    FILENAME ~ /mutants.txt$/ { if ($0 !~ /^#/ && NF >= 3) reason[$1, $2] = $3; next }
    $1 != "survived" { killed++; next }
    ($3, $4) in reason { equivalent++; next }
    { print "survived: " $2 ": " $4 "    " $3; survived++ }
    END {
        printf "%d killed, %d equivalent, %d survived\n", killed, equivalent, survived
        print (survived ? "FAIL" : "ok   ") "  mutants are noticed"
        exit survived > 0
    }' tests/mutants.txt $work/results.tsv
