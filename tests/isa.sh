#!/bin/sh
# Machine code of the shaders for GPUs that are not there, against ceilings (tests/isa/isa.c).
#
#     sh tests/isa.sh          one line a check: "ok", "FAIL" or "skip"; docs/gpu.md must be up to date
#     sh tests/isa.sh write    the same, but docs/gpu.md is written

set -u
cd "$(dirname "$0")/.." || exit 1
MAKE=${MAKE:-make}

if ! command -v glslangValidator >/dev/null ||
    ! printf '#include <vulkan/vulkan.h>\nint main(void) { return !vkCreateInstance; }\n' |
        ${CC:-cc} -x c - -o /dev/null -lvulkan 2>/dev/null; then
    echo "skip  isa: apt-get install mesa-vulkan-drivers libvulkan-dev glslang-tools"
    exit 0
fi
mkdir -p build/isa
rm -f build/isa/gpu.md
$MAKE -s -j2 build/release/isa || exit 1
build/release/isa build/isa build/isa/gpu.md
status=$?
[ -f build/isa/gpu.md ] || exit $status # skipped

# ACO does not compile the resolve for Vega twice alike: its instructions vary by 2%.
lasting() { grep -v '^| mssm resolve ' "$1"; }
compiler() { sed -n 's/^Compiler: \(.*\)\. Numbers.*/\1/p' "$1"; }

if [ "${1-}" = write ]; then
    cp build/isa/gpu.md docs/gpu.md
elif [ "$(lasting build/isa/gpu.md)" = "$(lasting docs/gpu.md)" ]; then
    echo "ok    docs/gpu.md is what the shaders are"
elif [ "$(compiler build/isa/gpu.md)" != "$(compiler docs/gpu.md)" ]; then
    echo "skip  docs/gpu.md is by $(compiler docs/gpu.md), here is $(compiler build/isa/gpu.md)"
else
    echo "FAIL  docs/gpu.md is stale; mend it with: make isa"
    status=1
fi
exit $status
