#!/bin/sh
# Writes the GLSL text of a header from the C source of the same header (one source for both), and what both
# headers have alike, the plumbing of OpenGL, from mssm.h into the other.
#
#     sh tests/make_glsl.sh mssm.h lightprobe.h            rewrite where stale
#     sh tests/make_glsl.sh --check mssm.h lightprobe.h    exit 1 where stale, write nothing
#
# The pieces between "// [glsl begin]" and "// [glsl end]" are quoted, one C string a line, between
#     // [glsl text begin] made by "make glsl", do not edit
#     // [glsl text end]
# A header with several texts names them: "// [glsl begin shading]", "// [glsl text begin shading] made ...".
# These quotes stand behind all code, in the chapter >>generated: no piece comes after the first of them.
# In mssm.h the parts between "// [plumbing begin]" and "// [plumbing end]" go into the same places of other
# headers in its folder, the first into the first and so on, with their prefix for its own.
# GLSL has no typedef, so "typedef struct NAME { ... } NAME;" becomes "struct NAME { ... };"; and it
# names a struct without the word, so "struct NAME x" becomes "NAME x". Nor has it pointers: what a function
# finds through its parameter w, a pointer to PREFIX__work, lies in buffers of the same names there, so "w->"
# and w are left out.
# Comments stay: a driver's error message then names a line that a reader finds in the C source.

set -u

check=0
if [ "${1-}" = "--check" ]; then
    check=1
    shift
fi
if [ $# -eq 0 ]; then
    echo "usage: sh tests/make_glsl.sh [--check] HEADER..." >&2
    exit 1
fi

fresh=$(mktemp) || exit 1
trap 'rm -f "$fresh" "$fresh".c' EXIT
trap 'exit 1' HUP INT TERM

# The header with the plumbing of the mssm.h beside it.
plumbing()
{
    case $1 in */*) from=${1%/*}/mssm.h ;; *) from=mssm.h ;; esac
    if [ "$1" = "$from" ] || ! grep -q '^// \[plumbing begin\]' "$1" || [ ! -r "$from" ]; then
        cat "$1"
        return
    fi
    prefix=$(basename "$1" .h)
    awk -v small="$prefix" -v large="$(echo "$prefix" | tr a-z A-Z)" '
    FNR == 1 { part = 0 }
    /^\/\/ \[plumbing end\]/ { inside = 0 }
    FNR == NR && inside { gsub(/mssm/, small); gsub(/MSSM/, large); text[part] = text[part] $0 "\n" }
    FNR != NR && !inside { print }
    /^\/\/ \[plumbing begin\]/ { inside = 1; part++; if (FNR != NR) printf "%s", text[part] }' "$from" "$1"
}

# Prints the whole header with a fresh block; on bad input, one message and exit 1.
rewrite()
{
    LC_ALL=C awk -v header="$1" '
    function stop(line, message)
    {
        printf "%s:%d: %s\n", header, line, message > "/dev/stderr"
        failed = 1
        exit 1
    }

    # Without the word "struct" before a name; a comment at the end of the line stays as it is.
    function drop_struct(text,    comment, at)
    {
        at = index(text, "//")
        comment = at ? substr(text, at) : ""
        if (at) text = substr(text, 1, at - 1)
        gsub(/struct +/, "", text)
        return text comment
    }

    # One line of C as GLSL. open_struct is the name of the typedef that is still open.
    function to_glsl(text, line,    name)
    {
        if (text ~ /^[ \t]*#/) stop(line, "the C preprocessor would act on this line of a piece")
        if (text ~ /\\$/) stop(line, "GLSL text cannot continue a line with a backslash")
        if (text ~ /[^\t -~]/) stop(line, "only ASCII passes every GLSL compiler, also in comments")
        if (text ~ /^[ \t]*typedef struct [A-Za-z_][A-Za-z_0-9]*[ \t]*([{].*)?$/) {
            name = text
            sub(/^[ \t]*typedef struct /, "", name)
            sub(/[^A-Za-z_0-9].*$/, "", name)
            sub(/typedef /, "", text)
            open_struct = name
            open_line = line
        }
        if (open_struct != "" && match(text, "}[ \t]*" open_struct "[ \t]*;")) {
            text = substr(text, 1, RSTART) ";" substr(text, RSTART + RLENGTH)
            open_struct = ""
        }
        if (gsub(/(const )?[a-z]+__work \*w,? ?/, "", text)) has_work = 1
        if (text ~ /^}/) has_work = 0
        if (has_work) {
            gsub(/\(w, ?/, "(", text)
            gsub(/\(w\)/, "()", text)
            gsub(/w->/, "", text)
        }
        # "struct NAME", followed by anything but what opens its body, is NAME.
        if (text !~ /^[ \t]*struct [A-Za-z_][A-Za-z_0-9]*[ \t]*([{;].*)?$/) text = drop_struct(text)
        if (text ~ /^[ \t]*typedef[ \t]/)
            stop(line, "GLSL knows no typedef but \"typedef struct NAME { ... } NAME;\"")
        return text
    }

    # The text as a C string literal; "??" is kept from being a trigraph.
    function quote(text,    out, i, c, last)
    {
        out = ""
        for (i = 1; i <= length(text); i++) {
            c = substr(text, i, 1)
            if (c == "\\" || c == "\"") out = out "\\" c
            else if (c == "\t") out = out "\\t"
            else if (c == "?" && last == "?") out = out "\\?"
            else out = out c
            last = c
        }
        return "\"" out "\\n\""
    }

    { source[NR] = $0 }

    # The name in a marker "// [glsl <word> NAME]rest", "" without one; -1 where it is no such marker.
    function marker(text, word, rest,    start, name)
    {
        start = "// [glsl " word
        if (index(text, start) != 1) return -1
        name = substr(text, length(start) + 1)
        if (substr(name, length(name) - length(rest)) != "]" rest) return -1
        name = substr(name, 1, length(name) - length(rest) - 1)
        if (name == "") return ""
        if (name !~ /^ [a-z]+$/) return -1
        return substr(name, 2)
    }

    END {
        if (failed) exit 1
        made = " made by \"make glsl\", do not edit"
        for (i = 1; i <= NR; i++) {
            text = source[i]
            sub(/^[ \t]+/, "", text)
            sub(/[ \t]+$/, "", text)
            if ((name = marker(text, "begin", "")) != -1) {
                if (piece) stop(i, "a piece begins inside the piece of line " piece)
                if (block) stop(i, "a piece comes after the quoted text of line " block)
                piece = i
                piece_name = name
                pieces[name]++
                if (lines[name]) blanks = 1
            } else if (marker(text, "end", "") == "") {
                if (!piece) stop(i, "a piece ends that did not begin")
                if (open_struct != "")
                    stop(open_line, "struct " open_struct " is not closed in its piece")
                piece = 0
            } else if ((name = marker(text, "text begin", made)) != -1) {
                if (piece) stop(i, "the quoted text begins inside the piece of line " piece)
                if (block && !ends[block]) stop(i, "the quoted text of line " block " is not closed")
                if (name in block_of) stop(i, "a second block; the first is at line " block_of[name])
                block = block_of[name] = i
                name_of[i] = name
                indent[i] = source[i]
                sub(/[^ \t].*$/, "", indent[i])
            } else if (marker(text, "text end", "") == "") {
                if (!block || ends[block]) stop(i, "the quoted text ends where it did not begin")
                ends[block] = i
            } else if (text ~ /^\/\/ *\[ *glsl/) {
                stop(i, "not a marker: " text)
            } else if (piece && text == "") {
                if (i > piece + 1) blanks++
            } else if (piece) {
                for (; blanks > 0; blanks--) glsl[piece_name, ++lines[piece_name]] = ""
                glsl[piece_name, ++lines[piece_name]] = to_glsl(source[i], i)
            }
        }
        if (piece) stop(piece, "this piece is not closed by // [glsl end]")
        if (!block) stop(NR, "no line // [glsl text begin]" made)
        if (!ends[block]) stop(block, "the quoted text is not closed by // [glsl text end]")
        for (name in pieces) if (!(name in block_of)) stop(NR, "pieces \"" name "\" without a block")
        for (name in block_of) if (!lines[name]) stop(block_of[name], "this block has no pieces")

        for (i = 1; i <= NR; i++) {
            print source[i]
            if (!(i in name_of)) continue
            for (n = 1; n <= lines[name_of[i]]; n++) print indent[i] quote(glsl[name_of[i], n])
            i = ends[i] - 1
        }
    }' "$2"
}

status=0
for header in "$@"; do
    if [ ! -r "$header" ]; then
        echo "$header: cannot be read" >&2
        status=1
    elif ! plumbing "$header" > "$fresh.c" || ! rewrite "$header" "$fresh.c" > "$fresh"; then
        status=1
    elif cmp -s "$fresh" "$header"; then
        :
    elif [ $check -eq 1 ]; then
        echo "$header: its quoted GLSL or its plumbing is stale; mend it with: sh tests/make_glsl.sh $header" >&2
        status=1
    else
        cat "$fresh" > "$header" || status=1
        echo "$header: GLSL text and plumbing renewed"
    fi
done
exit $status
