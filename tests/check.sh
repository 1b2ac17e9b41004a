# What the shell tests share; sourced by them from the top of the repository. BUILD names where the programs are.
# SPDX-License-Identifier: MIT
passed=0 failed=0 skipped=0
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT

# check NAME COMMAND...: the command succeeds, or what it said is shown.
check() {
    local name=$1
    shift
    if "$@" >"$work/out" 2>&1; then
        echo "ok $name"
        passed=$((passed + 1))
    else
        echo "not ok $name"
        sed 's/^/    /' "$work/out" | head -n 20
        failed=$((failed + 1))
    fi
}

skip() {
    echo "ok $1 # SKIP $2"
    skipped=$((skipped + 1))
}

finish() {
    echo "$passed passed, $failed failed, $skipped skipped"
    exit $((failed > 0))
}

# needs PROGRAM...: the test ends here if one of them was not built.
needs() {
    local program
    for program in "$@"; do
        [ -x "$program" ] && continue
        check "$program is there: build it first" false
        finish
    done
}

# refuses CODE PROGRAM WORDS...: this exit code, one line of complaint, nothing on the standard output. It runs where no
# stray file can stay.
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
