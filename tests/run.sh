#!/usr/bin/env bash
# Runs test programs (cmocka) and test scripts and counts: run.sh PROGRAM_OR_SCRIPT ... The programs, which use all
# cores, and the scripts, which mostly use one, run side by side; after the programs, the scripts from both ends. Output
# is kept in build/logs, and shown where a test fails; the last line is the sum. A program that dies counts as failed.
set -u
build=${BUILD:-build}
mkdir -p "$build/logs"

# Runs one and leaves "passed failed skipped" in its .count.
run() {
    local test=$1 name log start=$SECONDS status ok bad left
    name=$(basename "$test")
    log=$build/logs/$name.log
    mkdir "$build/logs/$name.taken" 2>/dev/null || return 0 # another has it
    case $test in
    *.sh) bash "$test" >"$log" 2>&1 ;;
    *) "$test" ${LONG:+--long} >"$log" 2>&1 ;;
    esac
    status=$?
    if [[ $test == *.sh ]]; then
        left=$(grep -c "^ok .*# SKIP" "$log") bad=$(grep -c "^not ok " "$log")
        ok=$(($(grep -c "^ok " "$log") - left))
    else
        ok=$(grep -c '^\[       OK \]' "$log") # cmocka names what failed or was skipped twice
        bad=$(grep '^\[  FAILED  \] [a-z_0-9]*$' "$log" | sort -u | wc -l)
        left=$(grep '^\[  SKIPPED \] [a-z_0-9]*$' "$log" | sort -u | wc -l)
    fi
    if [ "$status" -ne 0 ]; then
        [ "$bad" -gt 0 ] || bad=1
        cat "$log"
        echo "== $name failed with status $status"
    elif [ "$((ok + left))" -eq 0 ]; then
        bad=1
        echo "== $name ran no test"
    fi
    echo "$ok $bad $left" >"$build/logs/$name.count"
    echo "$name: $ok passed, $bad failed, $left skipped in $((SECONDS - start)) s"
}
rm -rf "$build"/logs/*.count "$build"/logs/*.taken
trap 'trap - TERM && kill 0' INT TERM # what runs in the background ignores Ctrl-C
programs=() scripts=() backwards=()
for test in "$@"; do
    if [[ $test == *.sh ]]; then scripts+=("$test") backwards=("$test" "${backwards[@]}")
    else programs+=("$test"); fi
done
for test in "${programs[@]}" "${backwards[@]}"; do run "$test"; done &
for test in "${scripts[@]}"; do run "$test"; done
wait
passed=0 failed=0 skipped=0
for test in "$@"; do
    ok=0 bad=1 left=0 # what has left no count counts as failed
    [ ! -f "$build/logs/$(basename "$test").count" ] || read -r ok bad left <"$build/logs/$(basename "$test").count"
    passed=$((passed + ok)) failed=$((failed + bad)) skipped=$((skipped + left))
done
echo "$passed passed, $failed failed, $skipped skipped"
[ "$failed" -eq 0 ]
