#!/bin/sh
# Does the check of README's and docs' claims let true ones pass and stop false ones?
#
#     sh tests/claims.sh [build/release/report]
#
# Runs the program on a small file of figures and pages with one claim each. One line a check: "ok   name"
# or "FAIL name". Exit 1 if any failed.

set -u
cd "$(dirname "$0")/.." || exit 1
report=${1:-build/release/report}
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
failed=0

cat > "$work/figures.csv" << 'END'
experiment,scene,method,x,metric,value,low,high
error,near,"layered, 6 moments",0.1,rms,0.04,0.04,0.04
error,near,"layered, 6 moments",0.2,rms,0.06,0.06,0.06
error,far,"layered, 6 moments",0.1,rms,0.02,0.02,0.02
error,near,"PCSS, all texels",0.1,rms,0.08,0.08,0.08
error,near,"PCSS, all texels",0.2,rms,0.05,0.05,0.05
error,far,"PCSS, all texels",0.1,rms,0.08,0.08,0.08
error,all,"layered, 6 moments",0.1,rms,9,9,9
END

# verdict WANTED NAME TEXT: a page of that text must pass (0) or fail (1).
verdict()
{
    printf 'First line.\n\n%s\n' "$3" > "$work/page.md"
    "$report" "$work/figures.csv" --check "$work/page.md" > "$work/log" 2>&1
    if [ $? -eq "$1" ]; then
        echo "ok   $2"
    else
        echo "FAIL $2: \"$3\""
        sed 's/^/     /' "$work/log"
        failed=1
    fi
}

verdict 0 "a page without claims passes" "Nothing is said."
verdict 0 "a true comparison passes" "less<!-- claim: {error|near|layered, 6 moments|0.1|rms} < 0.6 * {error|near|PCSS, all texels|0.1|rms} -->"
verdict 1 "a false comparison fails" "less<!-- claim: {error|near|layered, 6 moments|0.1|rms} < 0.5 * {error|near|PCSS, all texels|0.1|rms} -->"
verdict 0 "equality passes <=" "less<!-- claim: 2 <= {error|near|layered, 6 moments|0.1|rms} / {error|far|layered, 6 moments|0.1|rms} <= 2 -->"
verdict 1 "a false link of a chain fails" "between<!-- claim: 0.01 < {error|near|layered, 6 moments|0.1|rms} < 0.03 -->"
verdict 0 "the mean is over scenes and x, not over \"all\"" "0.040<!-- claim: = {error|mean|layered, 6 moments|mean|rms} -->"
verdict 0 "the mean over scenes at one x" "0.03<!-- claim: = {error|mean|layered, 6 moments|0.1|rms} -->"
verdict 0 "least and most" "3.0 times<!-- claim: = {error|most|layered, 6 moments|most|rms} / {error|least|layered, 6 moments|least|rms} -->"
verdict 0 "each scene" "in every scene<!-- claim: {error|each|layered, 6 moments|0.1|rms} < {error|each|PCSS, all texels|0.1|rms} -->"
verdict 1 "each scene and x: one that fails is enough" "everywhere<!-- claim: {error|each|layered, 6 moments|each|rms} < {error|each|PCSS, all texels|each|rms} -->"
verdict 0 "a rounded number passes" "0.57 of it<!-- claim: = {error|mean|layered, 6 moments|mean|rms} / {error|mean|PCSS, all texels|mean|rms} -->"
verdict 1 "a number off by one in its last decimal fails" "0.58 of it<!-- claim: = {error|mean|layered, 6 moments|mean|rms} / {error|mean|PCSS, all texels|mean|rms} -->"
verdict 0 "percent" "43% less<!-- claim: = 100 * (1 - {error|mean|layered, 6 moments|mean|rms} / {error|mean|PCSS, all texels|mean|rms}) -->"
verdict 1 "a number that is not there fails" "half<!-- claim: = {error|far|layered, 6 moments|0.1|rms} -->"
verdict 1 "an unknown method fails" "<!-- claim: {error|near|layered, 7 moments|0.1|rms} < 1 -->"
verdict 1 "an unknown scene under each fails" "<!-- claim: {err|each|layered, 6 moments|0.1|rms} < 1 -->"
verdict 1 "an x that was not measured fails" "<!-- claim: {error|near|layered, 6 moments|0.3|rms} < 1 -->"
verdict 1 "what is no comparison fails" "<!-- claim: {error|near|layered, 6 moments|0.1|rms} -->"
verdict 1 "what cannot be read fails" "<!-- claim: {error|near|layered, 6 moments|0.1|rms} < 1 and more -->"
verdict 1 "a comment that does not end fails" "<!-- claim: 1 < 2"
verdict 1 "division by nothing fails" "<!-- claim: {error|near|layered, 6 moments|0.1|rms} / 0 < 0 / 0 -->"
verdict 1 "one false claim among true ones fails" "<!-- claim: 1 < 2 --><!-- claim: 2 < 1 -->"

# The page that the report writes: as written, and with one digit changed.
mkdir "$work/docs"
"$report" "$work/figures.csv" --docs "$work/docs" > "$work/log" 2>&1
if "$report" "$work/figures.csv" --check "$work/docs/accuracy.md" > "$work/log" 2>&1; then
    echo "ok   the page written from the figures passes"
else
    echo "FAIL the page written from the figures passes"
    failed=1
fi
sed 's/0\.050/0.051/' "$work/docs/accuracy.md" > "$work/docs/changed.md"
if cmp -s "$work/docs/accuracy.md" "$work/docs/changed.md" ||
    "$report" "$work/figures.csv" --check "$work/docs/changed.md" > "$work/log" 2>&1; then
    echo "FAIL a changed number in the written page is found"
    failed=1
else
    echo "ok   a changed number in the written page is found"
fi
exit $failed
