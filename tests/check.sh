# What the shell tests share; sourced by them from the top of the repository. They speak TAP. BUILD
# names where the programs are; with --long as the first word a test goes on after what is quick.
# SPDX-License-Identifier: MIT
checks=0 failed=0 in_long_run=
[ "${1:-}" != --long ] || in_long_run=1
build=$(cd "${BUILD:-build}" 2>/dev/null && pwd) || build=none
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
export POCL_CACHE_DIR=${POCL_CACHE_DIR:-$build/pocl} # nothing goes into a home directory

# check NAME COMMAND...: the command succeeds, or what it said is shown.
check() {
    local name=$1
    shift
    checks=$((checks + 1))
    if "$@" >"$work/out" 2>&1; then
        echo "ok $checks - $name"
    else
        echo "not ok $checks - $name"
        sed 's/^/# /' "$work/out" | head -n 20
        failed=$((failed + 1))
    fi
}

# figures: what the last check has measured, for the log.
figures() { sed 's/^/    /' "$work/out"; }

skip() {
    checks=$((checks + 1))
    echo "ok $checks - $1 # SKIP $2"
}

finish() {
    echo "1..$checks"
    exit $((failed > 0))
}

# What follows belongs to the long run alone.
only_long_from_here() { [ "$in_long_run" ] || finish; }

have() { command -v "$1" >/dev/null 2>&1; }

# needs PROGRAM...: the test ends here if one of them was not built.
needs() {
    local program
    for program in "$@"; do
        [ -x "$program" ] && continue
        check "$program is there: build it first" false
        finish
    done
}

# refuses CODE PROGRAM WORDS...: this exit code, one line of complaint, nothing on the standard
# output. It runs where no stray file can stay.
refuses() {
    local expected=$1 code lines
    shift
    (cd "$work" && "$@" >plain_output 2>error)
    code=$?
    lines=$(wc -l <"$work/error")
    cat "$work/error"
    echo "exit code $code, $lines lines on stderr, $(wc -c <"$work/plain_output") bytes on stdout"
    [ $code -eq "$expected" ] && [ "$lines" -eq 1 ] && [ ! -s "$work/plain_output" ]
}

# help_tells PROGRAM OPTIONS: --help goes to the standard output and tells of each of them.
help_tells() {
    local option
    "$1" --help >"$work/help" 2>"$work/error" && [ ! -s "$work/error" ] || return 1
    for option in $2; do
        grep -q -- "--$option" "$work/help" || { echo "--help says nothing of --$option" &&
            return 1; }
    done
}

# until_true COMMAND...: up to half a minute, or `tries` times 0.1: long enough for a machine that
# does much else.
until_true() {
    local i
    for ((i = 0; i < ${tries:-300}; i++)); do
        "$@" && return
        sleep 0.1
    done
    return 1
}

# A display of the test's own; what it shows is in $work/Xvfb_screen0.
start_display() {
    have Xvfb && have xdotool || return 1
    Xvfb -noreset -displayfd 3 -screen 0 1280x800x24 -fbdir "$work" 3>"$work/display" 2>"$work/xvfb.log" &
    xvfb=$!
    trap 'kill $xvfb 2>/dev/null; rm -rf "$work"' EXIT
    until_true test -s "$work/display" || return 1
    export DISPLAY=:$(cat "$work/display")
}
finds_window() {
    window=$(xdotool search --onlyvisible --name "$1" 2>/dev/null | head -n 1) && [ -n "$window" ]
}
gone() { ! kill -0 $running 2>/dev/null; }
