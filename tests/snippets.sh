#!/bin/sh
# Does the code on the pages of docs/ compile?
#
#     sh tests/snippets.sh [PAGE...]
#
# ```c blocks go to the C compiler, each as a file of its own; ```glsl vertex | fragment | compute to
# glslangValidator behind #version and declarations of mssm_visibility() and two of a name (for real shaders the drivers'
# compiler sees the whole text, tests/gl). With "vulkan" in the first line the block comes
# behind the whole text of mssm_glsl_math() and mssm_glsl_shading(), and must become SPIR-V; with "probe" behind that of
# lightprobe_glsl_math() and lightprobe_glsl_lights().
# One line a check: "ok   name", "FAIL name" or "skip name: what is missing". Exit 1 if any failed.

set -u
cd "$(dirname "$0")/.." || exit 1
[ $# -gt 0 ] || set -- docs/integration.md
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
. tests/check.sh

# Blocks of a page: $work/NUMBER.LANGUAGE.STAGE, where STAGE is what follows the language, with dots.
split_page()
{
    rm -f "$work"/[0-9]*.c "$work"/[0-9]*.glsl.*
    awk -v work="$work" '
    /^ *```/ && file == "" {
        sub(/^ *```/, ""); gsub(/ +/, "."); n++
        file = $0 ~ /^(c|glsl\..*)$/ ? work "/" n "." $0 : "-"
        next }
    /^ *```/ { if (file != "-") close(file); file = ""; next }
    file != "" && file != "-" { print > file }' "$1"
}

# text HEADER FUNCTIONS: the texts that these functions return, from a program that the page itself could contain.
text()
{
    upper=$(echo "$1" | tr a-z A-Z) format=$(echo "$2" | sed 's/[a-z_]*/%s/g; s/ //g')
    printf '#define %s_IMPLEMENTATION\n#include "%s.h"\n#include <stdio.h>\nint main(void)\n{\n    %s\n}\n' "$upper" "$1" \
        "printf(\"$format\", $(echo "$2" | sed 's/ /(), /')()); return 0;" > "$work/text.c"
    cc -I. "$work/text.c" -o "$work/text" -lm && "$work/text" > "$work/text.$1"
}

# glsl_block FILE: its name ends in .glsl.STAGE, .glsl.STAGE.vulkan or .glsl.STAGE.probe.
glsl_block()
{
    stage=${1#*.glsl.}
    vulkan= probe=
    case $stage in
    *.vulkan) vulkan=-V ;;
    *.probe) probe=1 ;;
    esac
    stage=${stage%%.*}
    case $stage in vertex) end=vert ;; fragment) end=frag ;; compute) end=comp ;; *) echo "unknown stage $stage"; return 1 ;; esac
    {
        echo '#version 450 core'
        if [ -n "$vulkan" ]; then
            cat "$work/text.mssm"
        else
            [ -z "$probe" ] || cat "$work/text.lightprobe"
            echo 'float mssm_visibility(int light, vec3 world_position);'
            echo 'float mssm_visibility(int light, vec3 world_position, vec3 normal);'
            echo 'float mssm_visibility_at(int light, vec3 shadow);'
            echo 'float sun_shadow(int light, vec3 world_position, vec3 ddx, vec3 ddy);' # desc.name of a filtered one
            echo 'float lamp_shadow(int light, vec3 world_position, vec3 normal);'
        fi
        cat "$1"
    } > "$work/block.$end"
    glslangValidator $vulkan "$work/block.$end" -o "$work/block.spv" > "$work/said" 2>&1 ||
        { [ -z "$vulkan" ] && glslangValidator "$work/block.$end" > "$work/said" 2>&1; }
    result=$?
    grep -v "^[^ ]*block.$end\$" "$work/said"
    return $result
}

for page in "$@"; do
    split_page "$page"
    for file in $(ls "$work" | sort -n); do
        case $file in
        [0-9]*.c)
            check "$page: block ${file%%.*}, C" ${CC:-cc} -std=c99 -Wall -Wextra -Wpedantic -Werror -I. \
                -fsyntax-only "$work/$file" ;;
        [0-9]*.glsl.*)
            if ! command -v glslangValidator > /dev/null; then
                echo "skip $page: block ${file%%.*}, GLSL: apt-get install glslang-tools"
                continue
            fi
            case $file in
            *.vulkan) [ -e "$work/text.mssm" ] || text mssm "mssm_glsl_math mssm_glsl_shading" ;;
            *.probe) [ -e "$work/text.lightprobe" ] || text lightprobe "lightprobe_glsl_math lightprobe_glsl_lights" ;;
            esac
            check "$page: block ${file%%.*}, GLSL ${file#*.glsl.}" glsl_block "$work/$file" ;;
        esac
    done
done
[ ! -e "$work/failed" ]
