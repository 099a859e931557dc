#!/bin/sh
# Do the tests notice? Changes operators, constants, signs and statements of the moment math, the tables, the
# estimators and the clusters of a copy of the headers, one at a time, and runs the CPU tests on each; what
# survives, with sanitizers.
# Exit 1 if a mutant survives that tests/mutants.txt does not list as equivalent, with its reason. Called by
# `make mutants`; 10 minutes.
#     MUTANTS=300 make mutants    how many of all that there are (about 7400)
#     FIRST=7                     another choice of as many
#     AGAIN=1                     those that survived the last run
#     ONLY="text of a line"       all mutants (or MUTANTS of them) of the lines that contain it, or of what
#                                 bears that name: ONLY="in mssm_cut_light" a function, ONLY=">>estimators" a chapter
#     JOBS=1                      at a time; default 2
#     LIST=1                      none: only whether what is listed is there in the headers
set -u
cd "$(dirname "$0")/.." || exit 1
work=build/mutants
mkdir -p $work
CC=${CC:-gcc}
export CC work

# One candidate a line: header, line, column, length, replacement, what it is, text of the line, chapter.
# Columns and lines are those of this run's headers; the list of equivalent mutants goes by the text.
candidates()
{
    awk -v OFS='\t' -v only="${ONLY-}" '
        function offer(at, length_, to)
        {
            text = line; sub(/^ +/, "", text); sub(/ *\/\/.*$/, "", text)
            if (only != "" && !index(text " in " place " >>" mark, only)) return
            key = substr(line, at, length_) " -> " to
            gsub(/^ +/, "", key)
            if (to == ";") key = "removed"
            count[FILENAME, FNR, key]++
            if (count[FILENAME, FNR, key] > 1) key = key " (" count[FILENAME, FNR, key] ")"
            print FILENAME, FNR, at, length_, to, key, text, mark
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
        implementation == FILENAME && /^\/\/ .* >>[a-z ]+$/ { # a chapter begins
            mark = $0; sub(/^.*>>/, "", mark)
            inside = !index("|lights|angles|scratch|vectors|median cut|extraction|pictures|panoramas|crosses|without|texts|gl|" \
                            "shaders|plumbing|state|passes|filtered gl|updates|licence|generated|", "|" mark "|")
            seen += inside
        }
        /^[A-Za-z].*\(/ { # a function begins
            place = $0; sub(/\(.*$/, "", place); sub(/^.*[ *]/, "", place)
        }
        !inside || /^ *\/\// { next }
        /^#/ && !/^#define [A-Z_0-9]+ +[-(0-9]/ { next }
        {
            line = $0
            code = line
            sub(/\/\/.*$/, "", code)
            if (match(code, /^ +[a-z][][A-Za-z0-9_.>-]* [-+*\/]?= .*; *$/)) {
                match(code, /[a-z]/)
                offer(RSTART, length(code) - RSTART + 1, ";")
            }
            for (at = 1; at <= length(code); at++) {
                rest = substr(code, at)
                for (i = 1; i <= n; i++) {
                    if (index(rest, " " from[i] " ") == 1) offer(at + 1, length(from[i]), to[i])
                }
                before = at > 1 ? substr(code, at - 1, 1) : " "
                if (before ~ /[ (,]/ && rest ~ /^[-!][a-z(]/) offer(at, 1, " ")
                if (match(rest, /^\? [^?:;()]+ : [^?:;()]+[;)]/)) {
                    split(substr(rest, 3, RLENGTH - 3), way, " : ")
                    offer(at, RLENGTH - 1, "? " way[2] " : " way[1])
                }
                if (match(rest, /^ < [a-z][a-z_>.-]*;/)) offer(at, RLENGTH - 1, substr(rest, 1, RLENGTH - 1) " - 1")
                if (before ~ /[A-Za-z0-9_.]/ || !match(rest, /^[0-9]+(\.[0-9]+)?(e-?[0-9]+)?f?/)) continue
                number = substr(rest, 1, RLENGTH)
                after = substr(rest, RLENGTH + 1, 1)
                if (after ~ /[A-Za-z_]/ || /uint32_t|int32_t|(float|int) [a-z0-9]+\[|struct/ && after == "]") continue
                if (number ~ /[.ef]/) offer(at, RLENGTH, number + 0 == 0 ? "1.0f" : "(2 * " number ")")
                else if (after == "]" && before == "[") offer(at, RLENGTH, number > 0 ? number - 1 : 1)
                else offer(at, RLENGTH, number + 1)
                at += RLENGTH - 1
            }
        }
        END { if (seen != 14) { print "mutants: a chapter has lost its mark >>..." > "/dev/stderr"; exit 1 } }' mssm.h lightprobe.h
}

candidates >$work/all.tsv || exit 1
# What is listed must be there in the headers.
[ -n "${ONLY-}" ] || awk -F '\t' '
    FNR == NR { if ($0 !~ /^#/ && NF >= 3) { mutation[++n] = $1; part[n] = $2 }; next }
    {
        plain = $6
        sub(/ \([0-9]+\)$/, "", plain)
        for (i = 1; i <= n; i++) found[i] += (mutation[i] == $6 || mutation[i] == plain) && index($7, part[i])
    }
    END {
        for (i = 1; i <= n; i++) if (!found[i]) { print "listed, but not in the headers: " mutation[i] ": " part[i]; bad = 1 }
        exit bad
    }' tests/mutants.txt $work/all.tsv || exit 1
[ -n "${LIST-}" ] && exit 0
total=$(wc -l <$work/all.tsv)
wanted=${MUTANTS:-240}
[ -n "${ONLY-}" ] && wanted=${MUTANTS:-$total}
# Chosen by what they are, not by where they stand: changes elsewhere in the headers leave the choice as it is.
awk -F '\t' -v salt="${FIRST:-0}" '
    BEGIN { for (i = 32; i < 127; i++) code[sprintf("%c", i)] = i }
    {
        hash = salt + 1
        text = $6 $7
        for (i = 1; i <= length(text); i++) hash = (hash * 263 + code[substr(text, i, 1)]) % 1000003
        print hash * 7919 % 1000003 "\t" NR "\t" $0
    }' $work/all.tsv | sort -n | head -n "$wanted" | sort -n -k 2 | cut -f 3- >$work/chosen.tsv
if [ -n "${AGAIN-}" ]; then
    awk -F '\t' 'NR == FNR { if ($1 == "survived") left[$2, $3, $4]; next } ($1, $6, $7) in left' \
        $work/results.tsv $work/all.tsv >$work/chosen.tsv
fi
echo "$(wc -l <$work/chosen.tsv) of $total mutants"

${MAKE:-make} -s -j2 config=mutants CC="$CC" CFLAGS=-O1 test-cpu || exit 1
flags="-std=c99 -w -O1 -DTEST_CPU_ONLY -DMSSM_NO_GL -DLIGHTPROBE_NO_GL"
export flags
for header in mssm.h lightprobe.h; do
    printf '#define %s_IMPLEMENTATION\n#include "%s"\n' "$(basename $header .h | tr a-z A-Z)" $header >$work/$header.c
    $CC $flags -I. -c $work/$header.c -o $work/$header.o || exit 1
done
# run.sh PROGRAM HEADER CHAPTER [quick]: the tests that concern a chapter. Fast ones first, with a hundredth of
# their trials, then those that need many.
cat >$work/run.sh <<'EOF'
case $2/$3 in
mssm.h/estimators)
    quick="20:map/horizon 100:map/map|map/visibility 100:map/estimators"
    rest="1:both/edges 4:map/estimators 4:map/visibility 1:lights/lights" ;;
mssm.h/tables)
    quick="20:map/horizon 100:map/map|map/visibility 100:map/estimators" rest="4:map/ 1:both/edges" ;;
mssm.h/filtered)
    quick="100:filtered/" rest="1:filtered/ 1:both/edges 1:lights/cascades" ;;
mssm.h/scattering)
    quick="100:scattering/" rest="4:scattering/ 1:both/edges 1:scattering/" ;;
lightprobe.h/specular)
    quick="100:lightprobe/specular" rest="4:lightprobe/specular 1:both/edges 1:both/room" ;;
lightprobe.h/*)
    quick="100:both/parts|both/edges 100:lightprobe/lightprobe"
    rest="20:lightprobe/ 4:both/parts|both/edges|lightprobe/ 1:both/room" ;;
*)
    quick="100:math/|map/map|map/visibility 100:map/estimators"
    rest="20:math/|map/|both/e|lights/|filtered/|scattering/ 4:math/|map/|filtered/|scattering/" ;;
esac
[ -n "${4-}" ] && rest=
for run in $quick $rest; do
    TEST_STOP=1 TEST_SCALE=${run%%:*} timeout 200 "$1" "${run#*:}" || exit 1
done
EOF
for header in mssm.h lightprobe.h; do
    for chapter in $(awk -F '\t' -v header=$header '$1 == header { print $8 }' $work/chosen.tsv | sort -u); do
        sh $work/run.sh build/mutants/test-cpu $header $chapter >$work/log || { echo "FAIL  $chapter fails without any mutant"; exit 1; }
    done
done

# one NUMBER: prints "killed by ..." or "survived", and the mutant.
cat >$work/one.sh <<'EOF'
number=$1
IFS='	' read -r header line at length to key text chapter <<END
$(sed -n "${number}p" $work/chosen.tsv)
END
tree=$work/tree$number
# A test of private functions contains the header, too.
case $header/$chapter in
mssm.h/tables | mssm.h/estimators) other=lightprobe.h parts=tests/map/test_horizon.c ;;
mssm.h/*) other=lightprobe.h parts= ;;
*) other=mssm.h parts=tests/both/test_parts.c ;;
esac
mkdir -p $tree/tests/map $tree/tests/both $tree/tests/support
cp mssm.h lightprobe.h $tree
[ -z "$parts" ] || cp $parts $tree/$parts
cp tests/support/*.h $tree/tests/support
cp tests/suites.h $tree/tests
awk -v line="$line" -v at="$at" -v length_="$length" -v to="$to" '
    NR == line { $0 = substr($0, 1, at - 1) to substr($0, at + length_) }
    { print }' $header >$tree/$header
# build FLAGS: what contains the header, and links it with the rest.
build()
{
    for source in $work/$header.c ${parts:+$tree/$parts}; do
        object=$tree/$(basename $source).o
        $CC $flags $1 -I$tree -c $source -o $object 2>$tree/log || return 1
    done
    others="$(find $work/cpu -name '*.o' ! -name implementation.o ! -name "$(basename "$parts" .c).o") $work/$other.o"
    $CC $1 $tree/*.o $others -o $tree/test -lm -lpthread
}
verdict=survived
if ! build ""; then
    verdict="killed by the compiler"
elif ! sh $work/run.sh $tree/test $header $chapter >$tree/log 2>&1; then
    verdict="killed by $(tail -n 1 $tree/log | sed 's/^ *//')"
elif ! build "-fsanitize=address,undefined -fno-sanitize-recover=all" ||
        ! sh $work/run.sh $tree/test $header $chapter quick >$tree/log 2>&1; then
    verdict="killed by the sanitizers"
fi
printf '%s\t%s\t%s\t%s\n' "$verdict" "$header" "$key" "$text"
rm -rf $tree
EOF
seq "$(wc -l <$work/chosen.tsv)" | xargs -P "${JOBS:-2}" -n 1 sh $work/one.sh >$work/results.tsv

# Survivors that are not in the list.
awk -F '\t' '
    function listed(key, text, i)
    {
        for (i = 1; i <= n; i++)
            if ((mutation[i] == key || mutation[i] == plain(key)) && index(text, part[i])) return 1
        return 0
    }
    function plain(key) { sub(/ \([0-9]+\)$/, "", key); return key }
    FILENAME ~ /mutants.txt$/ { if ($0 !~ /^#/ && NF >= 3) { mutation[++n] = $1; part[n] = $2 }; next }
    $1 != "survived" { killed++; next }
    listed($3, $4) { equivalent++; next }
    { print "survived: " $2 ": " $4 "    " $3; survived++ }
    END {
        printf "%d killed, %d equivalent, %d survived\n", killed, equivalent, survived
        print (survived ? "FAIL" : "ok   ") "  mutants are noticed"
        exit survived > 0
    }' tests/mutants.txt $work/results.tsv
