#!/bin/sh
# Does the viewer open, draw and switch between its methods? Under Xvfb, without a display of one's own.
#
#     sh tests/viewer.sh
#
# One line a check: "ok   name", "FAIL name" or "skip name: what is missing". Exit 1 if any failed.

set -u
cd "$(dirname "$0")/.." || exit 1
for need in pkg-config:pkg-config Xvfb:xvfb xvfb-run:xvfb xauth:xauth; do
    command -v "${need%:*}" > /dev/null && continue
    echo "skip viewer: no ${need%:*}, apt-get install ${need#*:}"
    exit 0
done
if ! pkg-config --exists glfw3; then
    echo "skip viewer: no GLFW, apt-get install libglfw3-dev"
    exit 0
fi
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
failed=0
${MAKE:-make} -s build/release/viewer || exit 1

for words in "--frames x" "--frames" "--size 4x4" "extra" "extra words"; do
    # shellcheck disable=SC2086 # one word each
    said=$(build/release/viewer $words 2>&1) && said=
    case $said in
    "viewer: ${words%% *} cannot be"*) echo "ok   viewer: $words is refused by its name" ;;
    *) echo "FAIL viewer: $words: $said"; failed=1 ;;
    esac
done

# shot NAME KEYS FRAMES: a picture that is not nearly empty, which PNG would make small.
shot()
{
    if xvfb-run -a -s "-screen 0 1280x800x24" build/release/viewer --size 480x270 --keys "$2" --frames "$3" \
        --screenshot "$work/shot.png" > "$work/log" 2>&1 &&
        [ "$(wc -c < "$work/shot.png")" -gt 20000 ]; then
        echo "ok   viewer: $1"
    else
        echo "FAIL viewer: $1"
        sed 's/^/     /' "$work/log"
        failed=1
    fi
    mv "$work/shot.png" "$work/last.png"
}

shot "layered" "[[" 1
shot "lower blocker with 4 moments, larger lights, both faces" "[[EM=F" 1
shot "layered beside upper blocker" "[[SSS" 1
shot "layered beside hard shadows, without text" "[[SSSST" 1
shot "layered beside the sampled truth" "[[SSSSSS" 8
shot "a turning probe" "[[A" 3
shot "holding a frame time" "HA" 9

# compare NAME WANTED: whether the last picture and other.png are "same" or "different".
compare()
{
    cmp -s "$work/last.png" "$work/other.png" && got=same || got=different
    if [ $got = "$2" ]; then
        echo "ok   viewer: $1"
    else
        echo "FAIL viewer: $1"
        failed=1
    fi
}

# Without shadows the estimators would make no difference.
shot "upper blocker without text" "[[EET" 1
mv "$work/last.png" "$work/other.png"
shot "lower blocker without text" "[[ET" 1
compare "estimators differ" different
shot "settings of one's own without text" "[[EMT." 1
mv "$work/last.png" "$work/other.png"
shot "holding a frame time without text" "[[EMT.H" 1
compare "holding a frame time chooses other settings" different
shot "holding no longer" "[[EMT.H.HHH" 1
compare "settings of one's own return" same
exit $failed
