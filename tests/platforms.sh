#!/bin/sh
# Both headers under other compilers, flags, processors and byte orders: the CPU tests must pass there,
# and a fixed set of results is compared with that of gcc -O2 on this machine. The table goes to
# build/platforms.md. What this machine lacks is skipped, with the line that installs it.
#     make platforms             all of them
#     make platforms ONLY=clang  those whose name contains the word
set -u
cd "$(dirname "$0")/.." || exit 1
table=build/platforms.md
failed=0
MAKE=${MAKE:-make}

# can COMPILER FLAGS...: whether a small program can be made, and run behind $wrapper.
can()
{
    program=build/platforms/can.$$
    rm -f $program $program.exe
    printf '#include <math.h>\n#include <stdio.h>\nint main(void) { return printf("%%g", sqrt(4.0)) != 1; }\n' >$program.c
    "$@" $program.c -o $program -lm 2>/dev/null || return 1
    [ -f $program ] || program=$program.exe
    # shellcheck disable=SC2086
    $wrapper $program >/dev/null 2>&1
}

# platform NAME WRAPPER PACKAGES SCALE COMPILER CFLAGS [HEADER_CFLAGS [LIBS]]: HEADER_CFLAGS are for the
# headers alone; tests that look for NaN cannot do so under -ffast-math. Three tests are left out there: sums
# are taken in any order, so that equal formulas in different places differ in the last digits; and without
# denormal numbers roots are lost where the leading coefficient is below 1e-17 of the largest.
platform()
{
    name=$1 wrapper=$2 packages=$3 scale=$4 compiler=$5 cflags=$6 header_cflags=${7-} libs=${8--lm -lpthread}
    case $name in *"${ONLY-}"*) ;; *) return ;; esac
    # shellcheck disable=SC2086
    if ! can $compiler $cflags $header_cflags ${libs%%-lm*}; then
        echo "skip  $name: apt-get install $packages"
        return
    fi
    config=platforms/$(echo "$name" | tr -c 'a-z0-9A-Z\n' -)
    log=build/$config.log
    if ! $MAKE -s -j2 config="$config" CC="$compiler" CFLAGS="$cflags" HEADER_CFLAGS="$header_cflags" \
        CPU_LIBS="$libs" test-cpu outputs >"$log" 2>&1; then
        echo "FAIL  $name: does not compile"
        head -n 5 "$log"
        echo "| $name | does not compile |" >>$table
        failed=1
        return
    fi
    for program in test-cpu outputs; do
        [ -f "build/$config/$program.exe" ] && cp "build/$config/$program.exe" "build/$config/$program"
    done
    case $header_cflags in *fast-math*) words="-arrays give what|decode undoes encode|vanishing leading" ;; *) words= ;; esac
    # shellcheck disable=SC2086
    TEST_SCALE=$scale $wrapper "build/$config/test-cpu" ${words:+"$words"} >"$log" 2>&1
    counts=$(tr -d '\r' <"$log" | grep ' passed, ' | tail -n 1)
    # shellcheck disable=SC2086
    $wrapper "build/$config/outputs" 2>/dev/null | tr -d '\r' >"build/$config/outputs.txt"
    row=$(build/release/outputs "build/$config/outputs.txt" build/platforms/reference.txt)
    echo "| $name | $counts |$row" >>$table
    case $counts in
    *" 0 failed"*) echo "ok    $name: $counts;$row" ;;
    *)
        echo "FAIL  $name: $counts"
        grep -B 3 '^FAIL' "$log" | head -n 40
        failed=1
        ;;
    esac
}

mkdir -p build/platforms
$MAKE -s CC=gcc outputs && build/release/outputs >build/platforms/reference.txt || exit 1
echo "| platform | tests |$(build/release/outputs head)" >$table
echo "| --- | --- |$(build/release/outputs head | sed 's/[^|]*|/ --- |/g')" >>$table

for cc in gcc clang; do
    platform "$cc -O0" "" $cc 4 $cc -O0
    platform "$cc -O2" "" $cc 4 $cc -O2
    platform "$cc -O3 -march=native" "" $cc 4 $cc "-O3 -march=native"
    platform "$cc -O2 -mfma -ffp-contract=fast" "" $cc 4 $cc "-O2 -mfma -ffp-contract=fast"
    platform "$cc -O2 -mfma -ffp-contract=off" "" $cc 4 $cc "-O2 -mfma -ffp-contract=off"
    # Linked with it too: gcc then makes the processor flush denormal numbers to zero.
    platform "$cc -O2 -ffast-math" "" $cc 4 $cc -O2 -ffast-math "-ffast-math -lm -lpthread"
    platform "$cc -O3 -march=native -ffast-math" "" $cc 4 $cc -O2 "-O3 -march=native -ffast-math" \
        "-ffast-math -lm -lpthread"
    platform "$cc -m32 -msse2 -mfpmath=sse" "" "gcc-multilib" 4 $cc "-O2 -m32 -msse2 -mfpmath=sse"
done
platform "gcc -m32 -mfpmath=387" "" "gcc-multilib" 4 gcc "-O2 -m32 -march=i686 -mfpmath=387"
# Debian's wine64 alone puts nothing into the path.
wine=$(command -v wine64 || command -v wine || echo /usr/lib/wine/wine64)
export WINEDEBUG=-all
platform "x86-64 Windows (mingw-w64)" "$wine" "gcc-mingw-w64-x86-64 wine64" 10 x86_64-w64-mingw32-gcc -O2 "" \
    "-static -lm -lpthread"
# Debian's gcc for these cannot live next to gcc-multilib; clang with their libraries can.
platform "aarch64" qemu-aarch64 "clang libc6-dev-arm64-cross libgcc-12-dev-arm64-cross binutils-aarch64-linux-gnu qemu-user" \
    50 "clang --target=aarch64-linux-gnu" -O2 "" "-static -lm -lpthread"
platform "s390x (big-endian)" qemu-s390x \
    "clang libc6-dev-s390x-cross libgcc-12-dev-s390x-cross binutils-s390x-linux-gnu qemu-user" \
    50 "clang --target=s390x-linux-gnu" -O2 "" "-static -lm -lpthread"
echo "the table is in $table"
[ $failed = 0 ]
