#!/usr/bin/env bash
# Runs test programs (cmocka) and test scripts one after another and counts: run.sh PROGRAM_OR_SCRIPT ...
# Their output is shown and kept in build/logs; the last line is the sum. A program that dies counts as failed.
set -u
build=${BUILD:-build}
mkdir -p "$build/logs"
passed=0 failed=0 skipped=0
for test in "$@"; do
    name=$(basename "$test")
    log=$build/logs/$name.log
    echo "== $name"
    start=$SECONDS
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
    echo "   $ok passed, $bad failed, $left skipped in $((SECONDS - start)) s"
    passed=$((passed + ok)) failed=$((failed + bad)) skipped=$((skipped + left))
done
echo "$passed passed, $failed failed, $skipped skipped"
[ "$failed" -eq 0 ]
