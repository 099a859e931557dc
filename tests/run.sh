#!/bin/sh
# Runs the tests and ends with one line of counts.
#
#     sh tests/run.sh          what a change is tried with, in minutes: `make test`
#     sh tests/run.sh all      also all trials, sanitizers, valgrind, 32 bits, other drivers ...: `make test-all`
#
# Each section ends with a line of its counts and seconds; the first prints only what is not ok, the second
# all. If something failed, that and what was skipped is repeated at the end. What this machine lacks is
# skipped, with the line that installs it; TEST_REQUIRE_GL=1 turns the skip of the GL half into a failure,
# TEST_REQUIRE_ALL=1 every skip (.ci/run sets both). Where there is EGL, the release and the sanitized tests
# run once more without it.

set -u
cd "$(dirname "$0")/.." || exit 1
. tests/check.sh
MAKE=${MAKE:-make}
all=$([ "${1-}" = all ] && echo 1)
passed=0 failed=0 skipped=0 only= no_egl=
log=$(mktemp) || exit 1
trap 'rm -f "$log" "$log".*' EXIT
: >"$log.repeated"

# section NAME COMMAND...: shows what the command prints and adds its counts: its last line
# "N passed, N failed, N skipped", or else its lines that start with ok, FAIL or skip.
section()
{
    name=$1
    echo "== $name"
    shift
    start=$(date +%s)
    "$@" >"$log" 2>&1
    status=$?
    if [ -n "$all" ]; then
        cat "$log"
    else # failures and skips with their notes: programs write them above, scripts below by five blanks
        awk '/^ok / { note = ""; below = 0; next }
             /^     / && below { print; next }
             /^(FAIL|skip) |: (fatal )?error: |: warning: |runtime error|\*\*\*/ { printf "%s%s\n", note, $0; note = ""; below = 1; next }
             { note = note $0 "\n" }' "$log"
    fi
    counts=$(sed -n 's/^\([0-9]*\) passed, \([0-9]*\) failed, \([0-9]*\) skipped$/\1 \2 \3/p' "$log" |
        tail -n 1)
    [ -n "$counts" ] ||
        counts="$(grep -c '^ok ' "$log") $(grep -c '^FAIL ' "$log") $(grep -c '^skip ' "$log")"
    # shellcheck disable=SC2086
    set -- $counts
    passed=$((passed + $1)) failed=$((failed + $2)) skipped=$((skipped + $3))
    # A command that died without counting a failure is one itself.
    if [ "$2" -eq 0 ] && { [ "$status" -ne 0 ] || [ $(($1 + $3)) -eq 0 ]; }; then
        echo "FAIL  (exit code $status)" | tee -a "$log"
        failed=$((failed + 1))
    fi
    sed -n "s/^\(FAIL\|skip\) */\1  $(echo "$name" | tr / .): /p" "$log" >>"$log.repeated"
    echo "== $name: $1 passed, $2 failed, $3 skipped in $(($(date +%s) - start)) s"
}

# missing WHAT: a section that cannot run here, and the line that installs what it needs.
missing()
{
    echo "skip  $1"
    echo "skip  $1" >>"$log.repeated"
    skipped=$((skipped + 1))
}

# Whether the compiler can make, and this machine run, a program with these flags; $runner is what runs it.
can()
{
    printf '#include <math.h>\n#include <stdio.h>\nint main(void) { return printf("%%g", sqrt(4.0)) != 1; }\n' |
        ${CC:-cc} "$@" -x c - -o "$log.run" -lm 2>/dev/null && runner=$(runner "$log.run")
}

# suite CONFIG [WRAPPER...]: the test program, built with that configuration; all of it, or what the
# variable `only` says.
suite()
{
    config=$1
    shift
    $MAKE -s -j2 config="$config" test-binary && "$@" "build/$config/test" ${only:+"$only"}
}

# The tests of that configuration as on a machine without EGL: an empty file stands before libEGL.so.1, and
# dlopen refuses it. There each test of OpenGL must be skipped, say what installs EGL and leave nothing
# behind. Those of the CPU ran before, so few trials do.
without_egl()
{
    mkdir -p build/no-egl && : >build/no-egl/libEGL.so.1
    (
        unset TEST_REQUIRE_GL
        only="-compare: |$seconds|$once|$slow_on_cpu"
        suite "$1" env LD_LIBRARY_PATH="$PWD/build/no-egl" TEST_SCALE=200
    ) >"$log.run" 2>&1
    status=$?
    awk '
    /^    skipped: / { installs = /apt-get install/; hidden += /libEGL/ }
    /^skip / { print (installs ? "ok    skipped: " : "FAIL  without a line that installs: ") substr($0, 7)
               installs = 0; next }
    !/^[0-9]+ passed, / { print }
    END { if (!hidden) print "FAIL  no test was skipped for want of EGL" }' "$log.run"
    return $status
}

fresh_glsl()
{
    for header in mssm.h lightprobe.h; do
        if sh tests/make_glsl.sh --check $header; then
            echo "ok    GLSL text of $header is what its C source says"
        else
            echo "FAIL  GLSL text of $header is stale"
        fi
    done
}

# Other versions of clang-format break lines elsewhere.
format()
{
    case $(clang-format --version 2>/dev/null) in
        *" version 14."*) ;;
        *) echo "skip  format: apt-get install clang-format (version 14, Debian 12)" && return ;;
    esac
    wrong=$(find ./*.h examples tests -name '*.[ch]' | xargs -P 2 -n 32 clang-format --dry-run -Werror 2>&1 |
        sed -n 's/:[0-9]*:.* error: .*//p' | sort -u)
    if [ -z "$wrong" ]; then
        echo "ok    all C code is as .clang-format says"
    else
        echo "FAIL  mend the format with: clang-format -i" $wrong
    fi
}

# Both sides of a conflict once stood in docs/lightprobe.md.
merged()
{
    if grep -rnIE '^(<<<<<<<|>>>>>>>) ' ./*.h ./*.md Makefile docs examples tests; then
        echo "FAIL  marks of a merge are left"
    else
        echo "ok    no marks of a merge are left"
    fi
}

# Mutants themselves take too long for here.
mutants_listed()
{
    if LIST=1 sh tests/mutants.sh; then
        echo "ok    what tests/mutants.txt lists is there in the headers"
    else
        echo "FAIL  tests/mutants.txt lists lines that the headers no longer have"
    fi
}

# Programs that fail where a promise does not hold.
promises()
{
    if $MAKE -s -j2 bias; then
        echo "ok    the safe biases of mssm.h are proven"
    else
        echo "FAIL  a bias of mssm.h is not safe"
    fi
    if $MAKE -s -j2 specular; then
        echo "ok    the numbers of lightprobe.h's reflection are those of the fit"
    else
        echo "FAIL  lightprobe.h reflects by other numbers than the fit's"
    fi
    if $MAKE -s -j2 build/release/stability && build/release/stability --quick 2>/dev/null; then
        echo "ok    stability, a quick run"
    else
        echo "FAIL  stability, a quick run"
    fi
    if $MAKE -s -j2 build/release/figures && mkdir -p build/figures &&
        build/release/figures --quick build/figures 2>/dev/null; then
        echo "ok    the papers' figures, a quick run"
    else
        echo "FAIL  the papers' figures, a quick run"
    fi
    mkdir -p build/no-egl && : >build/no-egl/libEGL.so.1
    if LD_LIBRARY_PATH="$PWD/build/no-egl" build/release/figures --quick build/figures \
        probe-times shadow-times many-lights 2>/dev/null | grep -ic 'left out\*\*.*libEGL' | grep -qx 3; then
        echo "ok    the papers' figures say what is left out without EGL"
    else
        echo "FAIL  the papers' figures without EGL"
    fi
}

# README and docs against docs/accuracy.csv, and the program that does this against false claims.
claims()
{
    $MAKE -s -j2 build/release/report && sh tests/claims.sh
    if $MAKE -s chart-check; then
        echo "ok    README and docs say what the figures say"
    else
        echo "FAIL  a claim of README or docs does not follow from docs/accuracy.csv"
    fi
}

# Minutes where programs run in others, and code that other tests run too.
slow_on_cpu="halve the error|few lights cast|behind random edges|steady as the map|lamps that pass|go on smoothly"
slow_on_cpu="$slow_on_cpu|flat emitters|keep lamps in place|irradiance of 32 lights|body alone|weak lights go"
slow_on_cpu="$slow_on_cpu|what is above the horizon|bars before a wall|does not jump|probe: lights follow|light times the shadow"
slow="shadow ratio|turning probe|a walk shows|$slow_on_cpu"

# As long, but some lines of the headers are run by these alone: coverage has them.
once="of its lobe|come to rest|a fitted light|shafts are those"

# Seconds, however few the trials are.
seconds="radiance is that of|cuts: lights hold|carry all energy|does not pop"
seconds="$seconds|agree with ray|the light grazes|a convex caster|under a roof|normals help|a finer map"

# Whole pictures by rays and by OpenGL.
pictures="room GL|gl_catcher|the sampled light is the truth"

# Large files in and out.
images="panoramas|half floats"

# All but these, OpenGL and rivals.
on_cpu="-GL|gl_catcher|the shader is|hostile driver|compared methods|$images|$seconds|$once|$slow"

# The tests as other compilers' flags and machines have them.
suite_of()
{
    case $1 in
        native) # not what does not go by the flags: the calls that a driver sees, and rivals
            only="-GL: components|GL: failures|GL: finding lights|leaves the caller|leave the caller|is left alone"
            only="$only|leave nothing|undone|refused|refuses|names that died|transform feedback|contexts at once"
            only="$only|hostile driver|second compiler|may fail|may be missing|names GL|compare: |$pictures|$seconds|$once|$slow"
            suite native env TEST_SCALE=100 ;;
        x87)
            only=$on_cpu
            suite x87 env TEST_SCALE=100 ;;
        m32)
            only="-compare: |compared methods|2000 lives|$images|$seconds|$once|$slow"
            log=$log.m32 # its own, for can
            can -m32 && suite m32 env TEST_SCALE=100 "$runner" ;;
        compatibility | zink) # contexts and drivers that engines have and the default is not: what differs there
            only="GL's tables|GL's spot lights|GL's visibility is|GL state|GL numbers|GL's transform|GL's names|GL works in two"
            only="$only|GL finds the CPU's lights of a probe|GL: finding lights|GL refuses probes|filtered GL: nothing|filtered GL: the caller"
            if [ "$1" = zink ]; then
                suite release env TEST_SCALE=100 TEST_RENDERER=zink LIBGL_ALWAYS_SOFTWARE=1 GALLIUM_DRIVER=zink
            else
                suite release env GL_COMPATIBILITY=1 TEST_SCALE=20
            fi ;;
        rounding) # a GPU whose quotients and roots are two units off: what is compared with C
            only="GLSL gives C's|GL finds|GL's tables|GL's visibility is|GL's spot lights|any order|filtered GL|GL's given"
            suite release env TEST_SCALE=20 TEST_ROUNDING=1 ;;
        valgrind)
            # The sanitizers see the rest.
            only="$on_cpu|governor|PNG|may be long|traced pictures|every layout|no seams|texels are enough|do not crawl"
            suite release env TEST_SCALE=200 valgrind -q --suppressions=tests/valgrind.supp --error-exitcode=9 \
                --leak-check=full --errors-for-leak-kinds=definite ;;
    esac
}

# What needs one core and takes minutes. Whoever comes first to a part runs it: the loop beside the sections
# before it, or its own section.
run_part()
{
    (set -C && : >"$log.$1.taken") 2>/dev/null || return 0
    case $1 in # these use programs that are built in the meantime
        valgrind | promises | compatibility | zink | rounding | viewer | isa)
            while [ ! -e "$log.built" ] && kill -0 $$ 2>/dev/null; do sleep 1; done ;;
    esac
    from=$(date +%s)
    case $1 in
        fuzz) sh tests/fuzz.sh short ;;
        coverage) COVERAGE_OF="-$slow" sh tests/coverage.sh ;;
        viewer | isa) sh tests/$1.sh ;;
        promises) promises ;;
        *) (suite_of $1) ;;
    esac >"$log.$1" 2>&1
    echo "$? $(($(date +%s) - from))" >"$log.$1.ended"
    mv "$log.$1.ended" "$log.$1.status"
}

beside()
{
    for part in fuzz coverage native x87 m32 valgrind promises isa viewer zink compatibility rounding; do
        run_part $part
    done
}

later()
{
    run_part "$1"
    while [ ! -e "$log.$1.status" ]; do
        kill -0 "$beside" 2>/dev/null || [ -e "$log.$1.status" ] || return 1
        sleep 1
    done
    cat "$log.$1"
    read -r status took <"$log.$1.status"
    echo "(its own time: $took s)"
    return "$status"
}

# What a release must pass besides.
more()
{
    grep -q '^    skipped: .*libEGL' "$log" && no_egl=1 # these skips are seen already
    [ -n "$no_egl" ] || section "tests, release, EGL hidden" without_egl release
    section "claims" claims
    only="-compare: |$pictures|$seconds|$slow" # rivals and their times
    if can -fsanitize=address,undefined; then
        section "tests, address and undefined behaviour sanitizers" suite sanitize env TEST_SCALE=40
        [ -n "$no_egl" ] || section "tests, sanitizers, EGL hidden" without_egl sanitize
    else
        missing "sanitizers: apt-get install libasan8 libubsan1"
    fi
    section "tests, OpenGL's compatibility profile" later compatibility
    section "tests, OpenGL with loose quotients and roots" later rounding
    if ls /usr/share/vulkan/icd.d/lvp_icd* >/dev/null 2>&1; then
        section "tests, zink over lavapipe" later zink
    else
        missing "zink over lavapipe: apt-get install mesa-vulkan-drivers"
    fi
    only=
    if can -O3 -march=native; then
        section "tests, -O3 -march=native -ffp-contract=fast" later native
    else
        missing "native: the compiler knows no -march=native"
    fi
    if can -mfpmath=387; then
        section "tests, numbers as the 8087 rounds them" later x87
    else
        missing "8087: the compiler is for another processor"
    fi
    if can -m32; then
        section "tests, 32 bits" later m32
    else
        missing "32 bits: apt-get install gcc-multilib qemu-user"
    fi
    if command -v valgrind >/dev/null; then
        section "tests, valgrind" later valgrind
    else
        missing "valgrind: apt-get install valgrind"
    fi
    section "promises" later promises
    section "viewer" later viewer
    section "isa" later isa
    section "fuzz, short" later fuzz
    if command -v gcov >/dev/null && gcc --version >/dev/null 2>&1; then
        section "coverage" later coverage
    else
        missing "coverage: apt-get install gcc"
    fi
}

section "GLSL text" fresh_glsl
section "format" format
section "merges" merged
section "list of mutants" mutants_listed
section "docs" sh tests/snippets.sh
[ -z "$all" ] || { beside & beside=$!; }
section "dialects" sh tests/dialects.sh ${all:-quick}
if [ -z "$all" ]; then
    section "compile" sh tests/compile.sh quick
    only="-compare: |a walk shows" # rivals in OpenGL and a long walk: half a minute
    section "tests" suite release env TEST_SCALE=10
    section "claims" claims
else
    section "compile" sh tests/compile.sh
    # All objects that several parts link.
    $MAKE -s -j2 config=release test-binary build/release/report build/release/figures build/release/stability
    : >"$log.built"
    section "tests, release" suite release
    more
fi

if [ -n "${TEST_REQUIRE_ALL-}" ] && [ "$skipped" -gt 0 ]; then
    echo "FAIL  $skipped skipped where nothing may be"
    failed=$((failed + 1))
fi
[ "$failed" -eq 0 ] || cat "$log.repeated"
echo "$passed passed, $failed failed, $skipped skipped"
[ "$failed" -eq 0 ]
