# What the scripts of checks share, to be sourced with a folder of one's own in $work.

# check NAME COMMAND...: "ok   NAME" if the command succeeds, else "FAIL NAME", what it said and $work/failed.
# With $silent set it must also have said nothing. Checks that run side by side each want a folder, $lane.
check()
{
    name=$1
    shift
    if "$@" > "${lane:-$work}/log" 2>&1 && { [ -z "${silent-}" ] || [ ! -s "${lane:-$work}/log" ]; }; then
        echo "ok   $name"
    else
        echo "FAIL $name"
        echo "     $*"
        sed 's/^/     /' "${lane:-$work}/log" | head -n 30
        : > "$work/failed"
    fi
}

# runner PROGRAM: what runs this program here: env, or QEMU where the kernel runs no programs of 32 bits.
runner()
{
    for runner in env qemu-i386; do
        $runner "$1" > /dev/null 2>&1 && echo $runner && return
    done
    return 1
}
