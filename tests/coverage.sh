#!/usr/bin/env bash
# Line and branch coverage of sss_resample.h by bits.c and the tests in C that take no long time.
# Red: a line or branch that is not reached and not listed in tests/coverage.txt, or listed there
# and reached. Run from the repository's root: make coverage
# SPDX-License-Identifier: MIT
set -u
tests="profiles robust fuzz"
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT

# Every function of the header stands in every program once and is not inlined, so that counts can
# be added up.
flags="-std=c99 -O0 -ffp-contract=off -fno-math-errno -fno-trapping-math -fopenmp --coverage -fprofile-update=atomic
    -fkeep-static-functions -fkeep-inline-functions -Dalways_inline=unused -I. -Itests"
count() { # SOURCE [LIBRARY]: builds and runs a program, and leaves its counts
    local name
    name=$(basename "$1" .c)
    mkdir "$work/$name"
    # shellcheck disable=SC2086
    gcc $flags '-DDATA_DIR="tests/data"' "$1" -o "$work/$name/$name" ${2:-} -lm &&
        "$work/$name/$name" --short >"$work/log" 2>&1 ||
            { cat "$work/log"; echo "coverage: $name failed"; exit 1; }
    gcov -b -c -t "$work/$name"/*.gcda >"$work/$name.gcov" || exit 1
}
count tests/bits.c
for test in $tests; do [ ! -f "tests/test_$test.c" ] || count "tests/test_$test.c" -lcmocka; done

# Sums of lines and branches over the programs; what is 0 must be listed.
awk -v listed=tests/coverage.txt '
    BEGIN {
        while ((getline line < listed) > 0) {
            if (line ~ /^#/ || line !~ / \| /) continue
            text[++known] = substr(line, 1, index(line, " | ") - 1)
        }
    }
    /^ *-: *0:Source:/ { header = /sss_resample\.h$/ }
    !header { next }
    /^ *[-#=0-9*]+: *[0-9]+:/ {
        split($0, part, ":")
        number = part[2] + 0
        branch = 0
        source[number] = substr($0, length(part[1]) + length(part[2]) + 3)
        if (part[1] !~ /-/) lines[number] += part[1] + 0
        next
    }
    /^branch/ { branches[number, branch++] += $3 == "taken" ? $4 : 0 }
    function report(number, what,    k) {
        for (k = 1; k <= known; ++k) if (index(source[number], text[k])) { used[k] = 1; ++allowed; return }
        printf "not reached: %s of line %d:%s\n", what, number, source[number]
        ++bad
    }
    END {
        for (number in lines) { ++all; if (lines[number]) ++reached; else report(number, "all") }
        for (key in branches) {
            split(key, part, SUBSEP)
            if (!lines[part[1]]) continue # the line is reported
            ++all_branches
            if (branches[key]) ++taken; else report(part[1], "branch " part[2])
        }
        for (k = 1; k <= known; ++k) if (!(k in used)) { printf "reached, yet listed: %s\n", text[k]; ++bad }
        printf "sss_resample.h: %d of %d lines, %d of %d branches reached; %d listed with a reason, %d not\n",
            reached, all, taken, all_branches, allowed, bad
        exit bad > 0 || all < 300
    }' "$work"/*.gcov
