#!/bin/sh
# Both headers under other compilers, flags, processors and byte orders: the CPU tests must pass there,
# and a fixed set of results is compared with that of gcc -O2 on this machine. Writes the page
# build/platforms.md, of which docs/platforms.md is a copy. What this machine lacks is left out, on the
# page too, with what it takes.
#     make platforms             all of them
#     make platforms ONLY=clang  those whose name contains the word
set -u
cd "$(dirname "$0")/.." || exit 1
page=build/platforms.md
failed=0 whole=0 absent=0
MAKE=${MAKE:-make}
# Programs for Windows: Debian's wine64 alone puts nothing into the path.
wine=$(command -v wine64 || command -v wine || echo /usr/lib/wine/wine64)
export WINEDEBUG=-all

# can COMPILER FLAGS...: whether a small program can be made, and run behind $wrapper; 3 where it says that
# 3 * 5 is not 15, as QEMU's s390x did before 8.0.4 for floats multiplied as doubles (MDEBR).
can()
{
    program=build/platforms/can
    rm -f $program $program.exe
    cat >$program.c <<'EOF'
#include <math.h>
#include <stdio.h>
static double product(float a, float b) { return (double)a * b; }
int main(int count, char **words)
{
    (void)words;
    return printf("%g", sqrt(count + 3.0f)) != 1 ? 1 : product((float)count + 2, (float)count + 4) != 15 ? 3 : 0;
}
EOF
    "$@" $program.c -o $program -lm 2>/dev/null || return 1
    [ -f $program ] || program=$program.exe
    # shellcheck disable=SC2086
    $wrapper $program >/dev/null 2>&1
}

# leave_out WHAT IT TAKES
leave_out()
{
    echo "skip  $name: left out; it needs $1"
    echo "| $name | left out; it needs $1 |" >>$page
    absent=$((absent + 1))
}

# platform NAME WRAPPER NEEDS SCALE COMPILER CFLAGS [HEADER_CFLAGS [LIBS [HEADER_CC]]]: the last but LIBS are
# for the headers alone; tests that look for NaN cannot do so under -ffast-math.
platform()
{
    name=$1 wrapper=$2 needs=$3 scale=$4 compiler=$5 cflags=$6
    header_cflags=${7-} libs=${8--lm -lpthread} header_cc=${9-$5}
    case $name in *"${ONLY-}"*) ;; *) return ;; esac
    # shellcheck disable=SC2086
    can $compiler $cflags ${libs%%-lm*} && can $header_cc $cflags $header_cflags ${libs%%-lm*}
    case $? in
    0) ;;
    3) leave_out "QEMU 8.0.4 or later: this one has 3 * 5 wrong" && return ;;
    *) leave_out "$needs" && return ;;
    esac
    config=platforms/$(echo "$name" | tr -c 'a-z0-9A-Z\n' -)
    log=build/$config.log
    if ! $MAKE -s -j2 config="$config" CC="$compiler" CFLAGS="$cflags" HEADER_CFLAGS="$header_cflags" \
        HEADER_CC="$header_cc" CPU_LIBS="$libs" test-cpu outputs >"$log" 2>&1; then
        echo "FAIL  $name: does not compile"
        head -n 5 "$log"
        echo "| $name | does not compile |" >>$page
        failed=1
        return
    fi
    for program in test-cpu outputs; do
        [ -f "build/$config/$program.exe" ] && cp "build/$config/$program.exe" "build/$config/$program"
    done
    # shellcheck disable=SC2086
    TEST_SCALE=$scale $wrapper "build/$config/test-cpu" >"$log" 2>&1
    counts=$(tr -d '\r' <"$log" | grep ' passed, ' | tail -n 1)
    # shellcheck disable=SC2086
    $wrapper "build/$config/outputs" 2>/dev/null | tr -d '\r' >"build/$config/outputs.txt"
    differences=$(build/release/outputs "build/$config/outputs.txt" build/platforms/reference.txt)
    echo "| $name | $counts |$differences" >>$page
    case $counts$differences in
    *" 0 failed"*"not the same"* | *" 0 failed"*nan* | *" 0 failed"*inf*) echo "FAIL  $name: $differences" && failed=1 ;;
    *" 0 failed"*) echo "ok    $name: $counts;$differences" && whole=$((whole + 1)) ;;
    *)
        echo "FAIL  $name: $counts"
        grep -B 3 '^FAIL' "$log" | head -n 40
        failed=1
        ;;
    esac
}

# version COMMAND...: the first line of what it says of itself
version()
{
    "$@" --version 2>/dev/null | head -n 1
}

mkdir -p build/platforms
$MAKE -s CC=gcc outputs && build/release/outputs >build/platforms/reference.txt || exit 1
cat >$page <<'EOF'
# Platforms

These are the tests of the CPU halves of both headers under other compilers, flags, processors and byte orders, with a tenth
of their random trials (a fiftieth under QEMU). The other columns: the largest difference of fixed results from those of gcc
-O2, over the largest value of its kind or 1, whichever is more; = if all bits are the same. Written by `make platforms`.

EOF
echo "| platform | tests |$(build/release/outputs head)" >>$page
echo "| --- | --- |$(build/release/outputs head | sed 's/[^|]*|/ --- |/g')" >>$page

fast="-ffast-math -lm -lpthread" static="-static -lm -lpthread"
for cc in gcc clang; do
    install="apt-get install $cc"
    platform "$cc -O0" "" "$install" 10 $cc -O0
    platform "$cc -O2" "" "$install" 10 $cc -O2
    platform "$cc -O3 -march=native" "" "$install" 10 $cc "-O3 -march=native"
    for contract in fast off; do
        platform "$cc -O2 -mfma -ffp-contract=$contract" "" "$install, and a processor with FMA" 10 $cc \
            "-O2 -mfma -ffp-contract=$contract"
    done
    # Linked with it too, the processor takes numbers below 1e-38 for zero. Clang counts on that when compiling.
    [ $cc = gcc ] && platform "$cc -O2 -ffast-math, not linked with it" "" "$install" 10 $cc -O2 -ffast-math
    platform "$cc -O2 -ffast-math" "" "$install" 10 $cc -O2 -ffast-math "$fast"
    platform "$cc -O3 -march=native -ffast-math" "" "$install" 10 $cc -O2 "-O3 -march=native -ffast-math" "$fast"
    # With clang 14 -m32 a * b + a of __float128 3 and 5 is 0, so gcc compiles the tests and their oracles.
    platform "$cc -m32 -msse2 -mfpmath=sse" "" "$install gcc-multilib" 10 gcc "-O2 -m32 -msse2 -mfpmath=sse" "" \
        "-lm -lpthread" $cc
done
platform "gcc -m32 -mfpmath=387" "" "apt-get install gcc-multilib" 10 gcc "-O2 -m32 -march=i686 -mfpmath=387"
platform "x86-64 Windows (mingw-w64, Wine)" "$wine" "apt-get install gcc-mingw-w64-x86-64 wine64" 10 \
    x86_64-w64-mingw32-gcc -O2 "" "$static"
# Debian's gcc for these two refuses to be installed beside gcc-multilib; clang with their libraries does not.
for arch in aarch64 s390x; do
    case $arch in aarch64) debian=arm64 row=aarch64 ;; *) debian=$arch row="s390x (big-endian)" ;; esac
    install="apt-get install libc6-dev-$debian-cross libgcc-12-dev-$debian-cross binutils-$arch-linux-gnu qemu-user"
    for flags in -O0 -O2; do
        platform "$row, clang $flags" qemu-$arch "$install clang" 50 "clang --target=$arch-linux-gnu" $flags "" "$static"
    done
    install="apt-get install gcc-$arch-linux-gnu qemu-user (not beside gcc-multilib)"
    for flags in -O2 -O3; do # gcc 12 -O3 for aarch64 dies of a test, so these have -O2
        platform "$row, gcc $flags" qemu-$arch "$install" 50 $arch-linux-gnu-gcc -O2 $flags "$static"
    done
done

for tool in gcc clang x86_64-w64-mingw32-gcc "$wine" aarch64-linux-gnu-gcc s390x-linux-gnu-gcc qemu-s390x; do
    version "$tool"
done | sed 's/ Copyright.*//; s/^/- /' | sort -u >build/platforms/tools
native=$(gcc -march=native -Q --help=target | awk '$1 == "-march=" { print $2 }')
cat >>$page <<EOF

The tools, where native is $native:

$(cat build/platforms/tools)

## What is promised, and what is not

- Every row that passes has what the tests of the CPU halves check: no NaN and nothing out of range from any input, the
  errors of [stability.md](stability.md), and all energy in the lights. \`make test-all\` tests the GL halves, which are not listed.
- The bits are the same wherever every product is rounded, at any compiler and optimisation. Fused products (clang by default
  and gcc with -std=gnu99, where the processor has them) and 387 arithmetic change the last digits of all steps. Visibility
  shows that most, since its bounds rest on small differences of table entries.
- **387 arithmetic** needs gcc's -fexcess-precision=standard, which -std=c99 implies and -std=gnu99 does not. Without it, and
  with clang, the same comparison can have two results; then nothing is promised (measured: light axes not orthogonal).
- **-ffast-math** is undone for the headers' own code: NaN is handled as without it, and sums keep their order; errno and
  traps stay off, so vectors stay fast. Clang 14 obeys for x86 and s390x only and warns elsewhere, where nothing is then
  promised for NaN. A program *linked* with -ffast-math takes numbers below 1e-38 for zero, which costs no digit. Where clang
  compiles the header with -ffast-math and the program is linked without, \`mssm_solve_cubic\` may give NaN for coefficients
  that lead to such numbers, because clang computes roots from an estimate that fails there.
- **Big-endian**: nothing in the headers depends on byte order. QEMU before 8.0.4 multiplies floats as doubles wrongly
  (s390x instruction MDEBR: 3 * 5 = 160); clang uses it from -O1 on, gcc does not. Rows of such emulators are left out.
- Clang 14 has no working \`__float128\` on 32-bit x86 (3 * 5 + 3 = 0), so gcc compiles the tests there, clang the headers.
EOF
echo "$whole platforms pass, $absent are left out; the page is $page"
[ $failed = 0 ]
