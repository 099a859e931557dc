#!/bin/sh
# Do the headers, the code in their comments, the README and the examples compile everywhere?
#
#     sh tests/compile.sh          every compiler, standard and foreign header
#     sh tests/compile.sh quick    cc and c++ alone, for `make test`
#
# One line a check: "ok   name", "FAIL name" with the compiler's words below it, or
# "skip name: what is missing". Exit 1 if anything failed.

set -u
cd "$(dirname "$0")/.." || exit 1

root=$PWD
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
trap 'exit 1' HUP INT TERM

warnings="-Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror"

silent=1 run=env
. tests/check.sh

have() { command -v "$1" > /dev/null 2>&1; }

# builds COMPILER... -- SOURCES...: compiles, links and runs (unless the program is for elsewhere).
builds()
{
    "$@" -o "$lane/program" -lm && $run "$lane/program"
}

# two_units COMMAND-A COMMAND-B LINKER: one file is compiled by each command.
two_units()
{
    one=$1
    other=$2
    linker=$3
    $one -c tests/compile/two_units_a.c -o "$lane/a.o" &&
        $other -c tests/compile/two_units_b.c -o "$lane/b.o" &&
        $linker "$lane/a.o" "$lane/b.o" -o "$lane/program" -lm && $run "$lane/program"
}

# static_units COMMAND LINKER: the headers twice in one program, and no function of theirs to be seen outside.
static_units()
{
    $1 -c tests/compile/static.c -o "$lane/a.o" && $1 -DSECOND -c tests/compile/static.c -o "$lane/b.o" &&
        $2 "$lane/a.o" "$lane/b.o" -o "$lane/program" -lm && $run "$lane/program" || return 1
    ! have nm || ! nm -g --defined-only "$lane/a.o" | grep -E 'mssm_|lightprobe_'
}

# Every file under one compiler and standard. $1: what to call it, $2: the command with its flags,
# $3: what links objects.
all_files()
{
    check "$1: both" builds $2 tests/compile/together.c
    # What only the optimiser sees was seen above.
    check "$1: both, the other way round" builds $2 -O0 -DLIGHTPROBE_FIRST tests/compile/together.c
    check "$1: mssm.h alone" builds $2 -O0 tests/compile/alone_mssm.c
    check "$1: lightprobe.h alone" builds $2 -O0 tests/compile/alone_lightprobe.c
    check "$1: two source files" two_units "$2 -O0" "$2 -O0" "$3"
    check "$1: static" static_units "$2 -O0" "$3"
}

# One compiler family: C compiler, C++ compiler, their Debian package.
family()
{
    cc=$1 cxx=$2 package=$3
    lane=$work/$cc
    mkdir "$lane"
    if have "$cc"; then
        all_files "$cc -std=c99" "$cc -std=c99 -O2 $warnings -I." $cc
        check "$cc -std=c11: both" builds $cc -std=c11 $warnings -I. tests/compile/together.c
        no_gl="-std=c99 $warnings -I. -DMSSM_NO_GL -DLIGHTPROBE_NO_GL"
        check "$cc: without the GL halves" builds $cc $no_gl tests/compile/together.c
        check "$cc: without filtered shadows" builds $cc -std=c99 $warnings -I. -DMSSM_NO_FILTERED \
            tests/compile/together.c
        check "$cc: without scattering" builds $cc -std=c99 $warnings -I. -DMSSM_NO_SCATTERING \
            tests/compile/together.c
        check "$cc: static, without all of these" static_units \
            "$cc $no_gl -DMSSM_NO_FILTERED -DMSSM_NO_SCATTERING" $cc
        check "$cc: without all of these" builds $cc $no_gl -DMSSM_NO_FILTERED -DMSSM_NO_SCATTERING \
            tests/compile/together.c
    else
        echo "skip $cc: no compiler, apt-get install ${package%% *}"
    fi
    if have "$cxx"; then
        all_files "$cxx -std=c++11" "$cxx -x c++ -std=c++11 -O2 $warnings -I." $cxx
    else
        echo "skip $cxx: no compiler, apt-get install ${package##* }"
    fi
    if have "$cc" && have "$cxx"; then
        check "$cc and $cxx: implementation in C, use in C++" two_units \
            "$cc -std=c99 $warnings -I." "$cxx -x c++ -std=c++11 $warnings -I." $cxx
    fi
}

# -m32 counts as present if it can link a program that includes <math.h>, and something here runs it.
other_targets()
{
    lane=$work/targets
    mkdir "$lane"
    printf '#include <math.h>\nint main(void) { return 0; }\n' > "$lane/empty.c"
    if ! have gcc; then
        echo "skip 32 bits: no compiler, apt-get install gcc gcc-multilib"
    elif ! gcc -m32 "$lane/empty.c" -o "$lane/program" -lm > /dev/null 2>&1; then
        echo "skip 32 bits: gcc -m32 cannot link, apt-get install gcc-multilib"
    elif ! run=$(runner "$lane/program"); then
        echo "skip 32 bits: this kernel runs no programs of 32 bits, apt-get install qemu-user"
    else
        all_files "gcc -m32" "gcc -m32 -std=c99 -O2 $warnings -I." "gcc -m32"
    fi
    run=env
    mingw=x86_64-w64-mingw32-gcc
    if have $mingw; then
        for file in alone_mssm alone_lightprobe together; do
            check "$mingw: $file.c" $mingw -std=c99 $warnings -I. tests/compile/$file.c \
                -o "$lane/program.exe"
        done
        check "$mingw: a DLL, optimised" $mingw -std=c99 -O2 $warnings -I. "-DMSSM_API=__declspec(dllexport)" \
            "-DLIGHTPROBE_API=__declspec(dllexport)" -shared tests/compile/together.c -o "$lane/program.dll"
    else
        echo "skip Windows: no $mingw, apt-get install gcc-mingw-w64-x86-64"
    fi
}

# One OpenGL header of other people: how to write it in an #include, its Debian package. It need not be
# clean itself, so it counts as a system header, and its own library is not linked.
next_to()
{
    echo "#include $1" > "$lane/empty.c"
    if ! cc -fsyntax-only "$lane/empty.c" 2> /dev/null; then
        echo "skip next to $1: not there, apt-get install $2"
        return
    fi
    for compiler in "cc -std=c99" "c++ -x c++ -std=c++11"; do
        have "${compiler%% *}" || continue  # said elsewhere
        for order in FIRST LAST; do
            check "${compiler%% *}: next to $1, which comes $order" $compiler -fsyntax-only $warnings -I. \
                -D$order -DOTHER="$1" -DGLFW_INCLUDE_GLCOREARB tests/compile/next_to.c
        done
    done
}

other_gl_headers()
{
    lane=$work/others
    mkdir "$lane"
    next_to "<GL/gl.h>" libgl-dev
    next_to "<GL/glcorearb.h>" libgl-dev
    next_to "<GL/glew.h>" libglew-dev
    next_to "<SDL2/SDL_opengl.h>" libsdl2-dev
    next_to "<epoxy/gl.h>" libepoxy-dev
    next_to "<GLFW/glfw3.h>" libglfw3-dev
}

# glslangValidator prints the file's name in any case; what is left then is a warning or an error.
validate_glsl()
{
    cc -I. tests/compile/print_glsl.c -o "$lane/print_glsl" -lm || return 1
    "$lane/print_glsl" > "$lane/math.comp"
    "$lane/print_glsl" translucent > "$lane/translucent.frag"
    glslangValidator "$lane/math.comp" "$lane/translucent.frag" > "$lane/glslang" 2>&1
    result=$?
    grep -v '^[^ ]*/[a-z]*\.[a-z]*$' "$lane/glslang"
    return $result
}

second_glsl_compiler()
{
    if have glslangValidator; then
        check "glslangValidator: GLSL text of both headers" validate_glsl
    else
        echo "skip glslangValidator: not there, apt-get install glslang-tools"
    fi
}

# The code of a header's quick start: the indented comment lines up to the next title in capitals.
quick_start()
{
    awk '
    /^\/\/ *(QUICK START|Quick start)/ { inside = 1; next }
    inside && (!/^\/\// || /^\/\/ [A-Z][A-Z][A-Z][A-Z]/) { exit }
    inside && sub(/^\/\/     ?/, "") { print; next }
    inside { print "" }' "$1"
}

# Code from a page into a program. Preprocessor lines go first; statements are wrapped in a
# function; a main is added where there is none.
# $1: the code, $2: the program, $3: lines to begin with.
complete()
{
    {
        printf '%s\n' "$3"
        grep '^ *#' "$1"
        if grep -q '^}' "$1"; then
            grep -v '^ *#' "$1"
        else
            echo 'void fragment(void);'
            echo 'void fragment(void)'
            echo '{'
            grep -v '^ *#' "$1"
            echo '}'
        fi
        grep -q 'main *(' "$1" || echo 'int main(void) { return 0; }'
    } > "$2"
}

quick_starts()
{
    for header in mssm lightprobe; do
        quick_start $header.h > "$lane/code"
        name="$header.h: quick start ($(grep -c '[^ ]' "$lane/code") lines)"
        if [ ! -s "$lane/code" ]; then
            check "$name" echo "no quick start found in the header's comment"
            continue
        fi
        complete "$lane/code" "$lane/quick_$header.c" ''
        check "$name" cc -std=c99 -O2 -Wall -Wextra -Werror -I. "$lane/quick_$header.c" \
            -o "$lane/program" -lm
    done
}

# Every ```c block of the README, as README_1.c, README_2.c ... in the lane's directory.
readme_blocks()
{
    awk -v stem="$lane/README_" '
    /^ *```/ && file == "" { file = /^ *```c *$/ ? stem (++n) ".code" : "-"; next }
    /^ *```/ { if (file != "-") close(file); file = ""; next }
    file != "" && file != "-" { print > file }' README.md
    number=1
    while [ -f "$lane/README_$number.code" ]; do
        code=$lane/README_$number.code
        prelude=$(printf '#include "mssm.h"\n#include "lightprobe.h"')
        grep -q 'main *(' "$code" && prelude=
        grep -q '_IMPLEMENTATION' "$code" && prelude=
        complete "$code" "$lane/README_$number.c" "$prelude"
        objects=
        if ! grep -q '_IMPLEMENTATION' "$code"; then
            printf '#define MSSM_IMPLEMENTATION\n#include "mssm.h"\n' > "$lane/rest.c"
            printf '#define LIGHTPROBE_IMPLEMENTATION\n#include "lightprobe.h"\n' >> "$lane/rest.c"
            objects=$lane/rest.c
        fi
        check "README.md: code block $number" cc -std=c99 -Wall -Wextra -Werror -Wno-unused -I. \
            "$lane/README_$number.c" $objects -o "$lane/program" -lm
        number=$((number + 1))
    done
}

# The README's command for one example, run where its output does not disturb. Their common part is the
# same in all: it is compiled once, and without the optimiser, as the tests and the demo were built with it.
common_objects()
{
    (cd "$lane/tree" && mkdir -p objects && cd objects && cc -c -I.. ../examples/common/*.c)
}

example()
{
    command=$(awk -v file="examples/$1" '
    { line = line $0; if (sub(/\\$/, "", line)) next
      sub(/^[ \t]*(\$ )?/, "", line)
      if (line ~ /^(cc|gcc|clang) / && index(line, file)) { print line; exit }
      line = "" }' README.md)
    if [ -z "$command" ]; then
        echo "README.md has no line \"cc ... examples/$1 ...\""
        return 1
    fi
    command=$(printf '%s\n' "$command" |
        sed 's/ *&& .*//; s/ *#.*//; s/ -O2 / /; s,examples/common/\*\.c,objects/*.o,')
    (cd "$lane/tree" && eval "$command")
}

pages()
{
    lane=$work/pages
    mkdir "$lane" "$lane/tree"
    for name in mssm.h lightprobe.h examples tests; do
        ln -s "$root/$name" "$lane/tree/$name"
    done
    second_glsl_compiler
    quick_starts
    if [ ! -r README.md ]; then
        check "README.md" echo "not there"
        return
    fi
    readme_blocks
    [ -n "${quick-}" ] && return
    check "examples/common" common_objects
    for file in examples/*.c; do
        [ -e "$file" ] && [ "$file" != examples/page.c ] || continue # that is for emscripten
        if [ "$file" = examples/viewer.c ] && ! pkg-config --exists glfw3 2>/dev/null; then
            echo "skip $file: no GLFW, apt-get install pkg-config libglfw3-dev"
            continue
        fi
        check "$file: the README's command" example "${file#examples/}"
    done
}

# The compiler that is there, in both languages.
here()
{
    lane=$work/here
    mkdir "$lane"
    check "cc -std=c99: both" builds ${CC:-cc} -std=c99 -O2 $warnings -I. tests/compile/together.c
    if have c++; then
        check "c++ -std=c++11: both" builds c++ -x c++ -std=c++11 $warnings -I. tests/compile/together.c
    fi
}

# Two lanes, as most machines have two cores; each lane prints its lines in order.
if [ "${1-}" = quick ]; then
    quick=1
    pages > "$work/first" 2>&1 &
    here > "$work/second" 2>&1 &
else
    { family gcc g++ "gcc g++"; pages; } > "$work/first" 2>&1 &
    { family clang clang++ "clang clang"; other_targets; other_gl_headers; } > "$work/second" 2>&1 &
fi
wait
cat "$work/first" "$work/second"
[ ! -e "$work/failed" ]
