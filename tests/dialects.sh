#!/bin/sh
# Shading where OpenGL 4.5 is not: OpenGL 3.3, macOS, OpenGL ES 3.0, WebGL 2.
#
#     sh tests/dialects.sh          with the page, where emscripten and Chromium are
#     sh tests/dialects.sh quick    without it
#
# The texts of both headers in all dialects of GLSL on two compilers, glslangValidator and the driver's; their
# values in OpenGL ES 3.0 and 3.3; the picture of gl_portable there; the page in a browser; and whether a name in them
# is reserved in WGSL. One line a check: "ok   name", "FAIL name" or "skip name: what is missing".

set -u
cd "$(dirname "$0")/.." || exit 1
MAKE=${MAKE:-make}
out=build/release
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
. tests/check.sh

# Keywords and reserved words of WGSL (W3C), less those that GLSL asks for.
reserved="NULL Self abstract active alias alignas alignof as asm asm_fragment async attribute auto await become case
cast catch class co_await co_return co_yield coherent column_major common compile compile_fragment concept const_assert
const_cast consteval constexpr constinit continuing crate debugger decltype default delete demote demote_to_helper
diagnostic discard dynamic_cast enable enum explicit export extends extern external fallthrough filter final finally fn
friend from fxgroup get goto groupshared impl implements import inline instanceof interface let loop lowp macro
macro_rules match mediump meta mod module move mut mutable namespace new nil noexcept noinline nointerpolation
non_coherent noncoherent noperspective null nullptr of operator override package packoffset partial pass patch
pixelfragment premerge priv protected pub public ref regardless register reinterpret_cast require requires resource
restrict self set shared sizeof smooth snorm static static_assert static_cast std subroutine super switch target
template this thread_local throw trait try type typedef typeid typename typeof union unless unorm unsafe unsized use
using var varying virtual volatile wgsl where with writeonly yield"

words()
{
    "$out/dialects" words >"$work/texts" || return 1
    [ "$(wc -l <"$work/texts")" -gt 3000 ] || { echo "texts are missing"; return 1; }
    sed 's,//.*,,; /^#error/d' "$work/texts" | tr -c 'A-Za-z0-9_\n' '\n' | sort -u >"$work/words"
    echo "$reserved" | tr ' ' '\n' | sort | comm -12 - "$work/words" >"$work/taken"
    cat "$work/taken"
    [ ! -s "$work/taken" ]
}

glslang()
{
    "$out/dialects" "$1" >"$work/all.frag" && glslangValidator "$work/all.frag" >"$work/said" 2>&1
    result=$?
    grep -v '/all.frag$' "$work/said"
    return $result
}

pictures()
{
    "$out/gl_hello" "$work/hello.pfm" && "$out/gl_portable" "$1" "$work/portable.pfm" &&
        "$out/compare_pictures" "$work/hello.pfm" "$work/portable.pfm" 1.3
}

$MAKE -s -j2 $out/dialects $out/compare_pictures $out/gl_hello $out/gl_portable || exit 1
check "no name in the texts is reserved in WGSL" words
if command -v glslangValidator >/dev/null; then
    for version in "300 es" "310 es" "320 es" 330 410 430 450; do
        check "all texts compile as $version with glslangValidator" glslang "$version"
    done
else
    echo "skip the second compiler: apt-get install glslang-tools"
fi
"$out/dialects" >"$work/driver" || : >"$work/failed"
cat "$work/driver"
if grep -q '^skip' "$work/driver"; then
    echo "skip pictures: apt-get install libegl1 libgl1-mesa-dri"
else
    check "gl_portable in OpenGL ES 3.0 draws gl_hello's picture, to one step of 255" pictures --es
    check "gl_portable in OpenGL 3.3 draws gl_hello's picture, to one step of 255" pictures --gl33
fi
if [ "${1-}" = quick ]; then
    :
elif ! command -v emcc >/dev/null; then
    echo "skip page: apt-get install emscripten"
elif ! command -v chromium >/dev/null; then
    echo "skip page in a browser: apt-get install chromium"
elif ! grep -q '^skip' "$work/driver"; then
    check "make page" $MAKE -s page
    "$out/gl_portable" --es "$work/native.png" &&
        node tests/dialects/browser.js "$(command -v chromium)" build/page/page.html "$work" || : >"$work/failed"
fi
[ ! -e "$work/failed" ]
